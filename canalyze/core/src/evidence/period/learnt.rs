//! The period of a message, learnt from the gaps between its frames, for SYNC, heartbeats, PDOs and guarding alike.
//!
//! The period is the median of the recent gaps that agree. Gaps of several periods (something was missing) and single
//! odd gaps do not count; several consecutive gaps that agree on another length are another period, which is reported
//! ([`Learnt::Changed`]). A configured value is a prior that traffic confirms or contradicts. The user of a period
//! leaves out gaps across a burst or a hole of the recording.

use crate::bytes::frame::FrameRef;

/// Number of kept gaps.
const KEPT: usize = 16;
/// Number of agreeing gaps that make a period, and that make it certain.
const LIKELY: usize = 2;
const CERTAIN: usize = 5;
/// Number of consecutive gaps of another length that change the period.
const CHANGED: u32 = 6;
/// Gaps agree if they differ by less than this part of the period, or by less than twice the usual deviation.
const AGREE_PART: i64 = 32;
/// The mean of [`KEPT`] gaps has changed if it differs by more than this part: clocks differ by less, and single gaps
/// farther off compensate each other.
const LASTING_PART: i64 = 25;

/// The confidence in a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Confidence {
    /// It is configured, or was seen before something that may have changed it.
    Configured,
    /// Few gaps agree.
    Likely,
    /// At least five gaps agree.
    Certain,
}

/// A period with its confidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// The period in ns.
    pub ns: i64,
    /// Usual deviation of gaps from it, in ns.
    pub deviation_ns: i64,
    /// Its confidence.
    pub confidence: Confidence,
    /// Number of kept gaps that show it.
    pub gaps: usize,
}

/// The result of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learnt {
    /// Nothing new.
    Nothing,
    /// The first certain period.
    First,
    /// Another period, for several gaps already.
    Changed {
        /// The former period, in ns.
        from_ns: i64,
        /// The new period, in ns.
        to_ns: i64,
        /// The frame that ended the first of the new gaps.
        since: FrameRef,
    },
}

/// Gaps that agree on another length than the period.
#[derive(Clone, Copy, Debug, Default)]
struct Rival {
    sum_ns: i64,
    least_ns: i64,
    most_ns: i64,
    count: u32,
    since: FrameRef,
}

/// The mean of the former [`KEPT`] gaps, and the sum of those since.
#[derive(Clone, Copy, Debug, Default)]
struct Lasting {
    before_ns: Option<i64>,
    sum_ns: i64,
    count: usize,
    since: FrameRef,
}

/// A period that is being learnt.
#[derive(Clone, Debug, Default)]
pub struct Period {
    gaps: [i64; KEPT],
    /// Number of gaps, up to [`KEPT`]; and the index of the next one.
    count: usize,
    place: usize,
    learnt_ns: Option<i64>,
    deviation_ns: i64,
    configured_ns: Option<i64>,
    /// The learnt period before it was doubted, in ns.
    former_ns: Option<i64>,
    rival: Rival,
    lasting: Lasting,
    /// True once the first certain period has been reported.
    told: bool,
}

impl Period {
    /// Sets the configured period; `None` if it is unknown or off.
    pub fn configure(&mut self, ns: Option<i64>) {
        self.configured_ns = ns.filter(|ns| *ns > 0);
    }

    /// Returns true if it is learnt or configured, and not only remembered from before a doubt.
    pub fn is_known(&self) -> bool {
        self.learnt_ns.or(self.configured_ns).is_some()
    }

    /// Returns true if it is certain, or no gap has contradicted it yet.
    pub fn is_even(&self) -> bool {
        let Some(known) = self.learnt_ns else { return true };
        let near = |gap: &i64| gap.abs_diff(known) <= (known / 4).unsigned_abs();
        self.count >= CERTAIN || self.gaps.iter().take(self.count).all(near)
    }

    /// Returns the configured period, in ns.
    pub fn configured_ns(&self) -> Option<i64> {
        self.configured_ns
    }

    /// Returns the period that was configured, or learnt before a doubt, in ns.
    pub fn usual_ns(&self) -> Option<i64> {
        self.configured_ns.or(self.former_ns)
    }

    /// Returns the learnt period, or else the longer of the configured and the former one.
    pub fn expected(&self) -> Option<Expected> {
        if let Some(ns) = self.learnt_ns {
            let confidence = if self.count >= CERTAIN { Confidence::Certain } else { Confidence::Likely };
            return Some(Expected { ns, deviation_ns: self.deviation_ns, confidence, gaps: self.count });
        }
        let ns = self.configured_ns.max(self.former_ns)?;
        Some(Expected { ns, deviation_ns: 0, confidence: Confidence::Configured, gaps: 0 })
    }

    /// Returns the learnt period, in ns.
    pub fn learnt_ns(&self) -> Option<i64> {
        self.learnt_ns
    }

    /// Returns true if the last gaps agree on another length, so that the period may be changing.
    pub fn is_contested(&self) -> bool {
        self.rival.count > 0
    }

    /// Doubts the period after a reset or new configuration. Until gaps show it, it may be as long as before.
    pub fn doubt(&mut self) {
        let former_ns = self.learnt_ns.or(self.former_ns);
        *self = Self { former_ns, configured_ns: self.configured_ns, ..Self::default() };
    }

    /// Forgets everything except the configured period.
    pub fn forget(&mut self) {
        *self = Self { configured_ns: self.configured_ns, ..Self::default() };
    }

    /// Learns from a gap in ns (above 0) that ended with the frame `at`; `uncertain_ns`: the uncertainty of the
    /// recording.
    pub fn take(&mut self, gap_ns: i64, uncertain_ns: i64, at: FrameRef) -> Learnt {
        if gap_ns <= 0 {
            return Learnt::Nothing;
        }
        let Some(known) = self.learnt_ns else {
            self.remember(gap_ns);
            return self.settle();
        };
        let room = self.room(known, uncertain_ns);
        if gap_ns.abs_diff(known) <= room.unsigned_abs() {
            self.rival = Rival::default();
            self.deviation_ns =
                gap_ns.saturating_sub(known).saturating_abs().max(self.deviation_ns - self.deviation_ns / 16);
            self.remember(gap_ns);
            let learnt = self.settle();
            return self.last(gap_ns, uncertain_ns, at).unwrap_or(learnt);
        }
        self.contest(gap_ns, known, room, at)
    }

    /// Adds an agreeing gap: the mean of many shows a change too small to show in each of them.
    fn last(&mut self, gap_ns: i64, uncertain_ns: i64, at: FrameRef) -> Option<Learnt> {
        let lasting = &mut self.lasting;
        if lasting.count == 0 {
            (lasting.since, lasting.sum_ns) = (at, 0);
        }
        lasting.sum_ns = lasting.sum_ns.saturating_add(gap_ns);
        lasting.count += 1;
        if lasting.count < KEPT {
            return None;
        }
        let (to_ns, since) = (lasting.sum_ns / KEPT as i64, lasting.since);
        lasting.count = 0;
        let from_ns = *lasting.before_ns.get_or_insert(to_ns);
        let off_ns = self.deviation_ns.saturating_add(uncertain_ns) / KEPT as i64;
        let most = (from_ns / LASTING_PART).saturating_add(off_ns);
        if to_ns.abs_diff(from_ns) <= most.unsigned_abs() {
            return None;
        }
        lasting.before_ns = Some(to_ns);
        Some(Learnt::Changed { from_ns, to_ns, since })
    }

    /// Returns the maximum difference of agreeing gaps, in ns.
    fn room(&self, known: i64, uncertain_ns: i64) -> i64 {
        (known / AGREE_PART).max(self.deviation_ns.saturating_mul(2)).max(uncertain_ns.saturating_mul(2)).min(known / 2)
    }

    fn remember(&mut self, gap_ns: i64) {
        if let Some(slot) = self.gaps.get_mut(self.place) {
            *slot = gap_ns;
        }
        self.place = (self.place + 1) % KEPT;
        self.count = (self.count + 1).min(KEPT);
    }

    /// Sets the period to the median of the kept gaps, once half of them agree.
    fn settle(&mut self) -> Learnt {
        let mut sorted = self.gaps;
        let Some(kept) = sorted.get_mut(..self.count) else { return Learnt::Nothing };
        kept.sort_unstable();
        let Some(median) = kept.get(self.count / 2).copied() else { return Learnt::Nothing };
        let near = |gap: &&i64| gap.abs_diff(median) <= (median / 4).unsigned_abs();
        let agreeing = kept.iter().filter(near).count();
        // A single gap suffices to confirm the period from before a doubt.
        let confirms = |former: i64| former.abs_diff(median) <= (former / AGREE_PART).unsigned_abs();
        let likely = agreeing >= LIKELY || self.former_ns.is_some_and(confirms);
        if !likely || agreeing * 2 < self.count {
            return Learnt::Nothing;
        }
        if self.learnt_ns.is_none() {
            let off = kept.iter().filter(near).map(|gap| gap.saturating_sub(median).saturating_abs()).max();
            self.deviation_ns = off.unwrap_or(0);
        }
        self.learnt_ns = Some(median);
        if self.count < CERTAIN || std::mem::replace(&mut self.told, true) { Learnt::Nothing } else { Learnt::First }
    }

    /// Adds a gap of another length.
    fn contest(&mut self, gap_ns: i64, known: i64, room: i64, at: FrameRef) -> Learnt {
        let rival = &mut self.rival;
        let fits = rival.count > 0
            && rival.most_ns.max(gap_ns).saturating_sub(rival.least_ns.min(gap_ns)) <= room.max(gap_ns / 8)
            && (rival.least_ns > known) == (gap_ns > known);
        if !fits {
            *rival = Rival { sum_ns: gap_ns, least_ns: gap_ns, most_ns: gap_ns, count: 1, since: at };
            return Learnt::Nothing;
        }
        rival.sum_ns = rival.sum_ns.saturating_add(gap_ns);
        (rival.least_ns, rival.most_ns) = (rival.least_ns.min(gap_ns), rival.most_ns.max(gap_ns));
        rival.count += 1;
        // They follow each other directly, or with ignored gaps between them. If their distance is no multiple of their
        // length, shorter gaps compensate them: it is jitter.
        let mean_ns = (rival.sum_ns / i64::from(rival.count)).max(1);
        let apart = i64::from(rival.count - 1);
        let times = |lasts: i64| (lasts.saturating_add(mean_ns / 2) / mean_ns).max(apart);
        let off = |lasts: i64| lasts.saturating_sub(times(lasts).saturating_mul(mean_ns)).saturating_abs();
        if at.since(rival.since).is_some_and(|lasts| off(lasts) > mean_ns.saturating_mul(apart) / 8) {
            *rival = Rival { sum_ns: gap_ns, least_ns: gap_ns, most_ns: gap_ns, count: 1, since: at };
            return Learnt::Nothing;
        }
        if rival.count < CHANGED {
            return Learnt::Nothing;
        }
        let Rival { sum_ns, least_ns, most_ns, count, since } = std::mem::take(rival);
        let to_ns = sum_ns / i64::from(count);
        self.lasting = Lasting::default();
        self.gaps = [to_ns; KEPT];
        (self.count, self.place) = (count as usize, count as usize % KEPT);
        (self.learnt_ns, self.deviation_ns) = (Some(to_ns), most_ns.saturating_sub(least_ns) / 2);
        Learnt::Changed { from_ns: known, to_ns, since }
    }
}
