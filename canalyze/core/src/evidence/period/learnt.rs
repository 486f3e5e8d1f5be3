//! The period of a message, learnt from the gaps between its frames, for SYNC, heartbeats, PDOs and guarding alike.
//!
//! The period is the median of the recent gaps that agree. Gaps of several periods (something was missing) and single
//! odd gaps do not count; several consecutive gaps that agree on another length are another period, which is reported
//! ([`Learnt::Changed`]). A configured value is a prior that traffic confirms or contradicts. The user of a period
//! leaves out gaps across a burst or a hole of the recording.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;

/// Number of kept gaps.
const KEPT: usize = 16;
/// Number of agreeing gaps that make a period, and that make it certain.
const LIKELY: usize = 2;
const CERTAIN: usize = 5;
/// Number of consecutive gaps of another length that change the period; and the number if each is longer than this many
/// periods: of the frames between, all would be missing each time.
const CHANGED: u32 = 6;
const CHANGED_LONG: u32 = 3;
const LONG: i64 = 3;
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
    pub ns: Ns,
    /// Usual deviation of gaps from it, in ns.
    pub deviation_ns: Ns,
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
        from_ns: Ns,
        /// The new period, in ns.
        to_ns: Ns,
        /// The frame that ended the first of the new gaps.
        since: FrameRef,
    },
}

/// Gaps that agree on another length than the period.
#[derive(Clone, Copy, Debug, Default)]
struct Rival {
    sum_ns: Ns,
    least_ns: Ns,
    most_ns: Ns,
    count: u32,
    since: FrameRef,
}

/// The mean of the former [`KEPT`] gaps, and the sum of those since.
#[derive(Clone, Copy, Debug, Default)]
struct Lasting {
    before_ns: Option<Ns>,
    sum_ns: Ns,
    count: usize,
    since: FrameRef,
}

/// A period that is being learnt.
#[derive(Clone, Debug, Default)]
pub struct Period {
    gaps: [Ns; KEPT],
    /// Number of gaps, up to [`KEPT`]; and the index of the next one.
    count: usize,
    place: usize,
    learnt_ns: Option<Ns>,
    deviation_ns: Ns,
    configured_ns: Option<Ns>,
    /// The learnt period before it was doubted, in ns.
    former_ns: Option<Ns>,
    rival: Rival,
    lasting: Lasting,
    /// True once the first certain period has been reported.
    told: bool,
}

impl Period {
    /// Sets the configured period; `None` if it is unknown or off.
    pub fn configure(&mut self, ns: Option<Ns>) {
        self.configured_ns = ns.filter(|ns| *ns > Ns::ZERO);
    }

    /// Returns true if it is learnt or configured, and not only remembered from before a doubt.
    pub fn is_known(&self) -> bool {
        self.learnt_ns.or(self.configured_ns).is_some()
    }

    /// Returns true if it is certain, or no gap has contradicted it yet.
    pub fn is_even(&self) -> bool {
        let Some(known) = self.learnt_ns else { return true };
        let near = |gap: &Ns| gap.abs_diff(known) <= (known / 4).abs();
        self.count >= CERTAIN || self.gaps.iter().take(self.count).all(near)
    }

    /// Returns the configured period, in ns.
    pub fn configured_ns(&self) -> Option<Ns> {
        self.configured_ns
    }

    /// Returns the period that was configured, or learnt before a doubt, in ns.
    pub fn usual_ns(&self) -> Option<Ns> {
        self.configured_ns.or(self.former_ns)
    }

    /// Returns the learnt period, or else the longer of the configured and the former one.
    pub fn expected(&self) -> Option<Expected> {
        if let Some(ns) = self.learnt_ns {
            let confidence = if self.count >= CERTAIN { Confidence::Certain } else { Confidence::Likely };
            return Some(Expected { ns, deviation_ns: self.deviation_ns, confidence, gaps: self.count });
        }
        let ns = self.configured_ns.max(self.former_ns)?;
        Some(Expected { ns, deviation_ns: Ns::ZERO, confidence: Confidence::Configured, gaps: 0 })
    }

    /// Returns the learnt period, in ns.
    pub fn learnt_ns(&self) -> Option<Ns> {
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
    pub fn take(&mut self, gap_ns: Ns, uncertain_ns: Ns, at: FrameRef) -> Learnt {
        if gap_ns <= Ns::ZERO {
            return Learnt::Nothing;
        }
        let Some(known) = self.learnt_ns else {
            self.remember(gap_ns);
            return self.settle();
        };
        let room = self.room(known, uncertain_ns);
        if gap_ns.abs_diff(known) <= room.abs() {
            self.rival = Rival::default();
            self.deviation_ns = (gap_ns - known).abs().max(self.deviation_ns - self.deviation_ns / 16);
            self.remember(gap_ns);
            let learnt = self.settle();
            return self.last(gap_ns, uncertain_ns, at).unwrap_or(learnt);
        }
        self.contest(gap_ns, known, room, at)
    }

    /// Adds an agreeing gap: the mean of many shows a change too small to show in each of them.
    fn last(&mut self, gap_ns: Ns, uncertain_ns: Ns, at: FrameRef) -> Option<Learnt> {
        let lasting = &mut self.lasting;
        if lasting.count == 0 {
            (lasting.since, lasting.sum_ns) = (at, Ns::ZERO);
        }
        lasting.sum_ns += gap_ns;
        lasting.count += 1;
        if lasting.count < KEPT {
            return None;
        }
        let (to_ns, since) = (lasting.sum_ns / KEPT as i64, lasting.since);
        lasting.count = 0;
        let from_ns = *lasting.before_ns.get_or_insert(to_ns);
        let off_ns = (self.deviation_ns + uncertain_ns) / KEPT as i64;
        let most = (from_ns / LASTING_PART) + off_ns;
        if to_ns.abs_diff(from_ns) <= most.abs() {
            return None;
        }
        lasting.before_ns = Some(to_ns);
        Some(Learnt::Changed { from_ns, to_ns, since })
    }

    /// Returns the maximum difference of agreeing gaps, in ns.
    fn room(&self, known: Ns, uncertain_ns: Ns) -> Ns {
        (known / AGREE_PART).max(self.deviation_ns * 2).max(uncertain_ns * 2).min(known / 2)
    }

    fn remember(&mut self, gap_ns: Ns) {
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
        let near = |gap: &&Ns| gap.abs_diff(median) <= (median / 4).abs();
        let agreeing = kept.iter().filter(near).count();
        // A single gap suffices to confirm the period from before a doubt.
        let confirms = |former: Ns| former.abs_diff(median) <= (former / AGREE_PART).abs();
        let likely = agreeing >= LIKELY || self.former_ns.is_some_and(confirms);
        if !likely || agreeing * 2 < self.count {
            return Learnt::Nothing;
        }
        if self.learnt_ns.is_none() {
            let off = kept.iter().filter(near).map(|gap| (*gap - median).abs()).max();
            self.deviation_ns = off.unwrap_or(Ns::ZERO);
        }
        self.learnt_ns = Some(median);
        if self.count < CERTAIN || std::mem::replace(&mut self.told, true) { Learnt::Nothing } else { Learnt::First }
    }

    /// Adds a gap of another length.
    fn contest(&mut self, gap_ns: Ns, known: Ns, room: Ns, at: FrameRef) -> Learnt {
        let rival = &mut self.rival;
        let fits = rival.count > 0
            && rival.most_ns.max(gap_ns) - rival.least_ns.min(gap_ns) <= room.max(gap_ns / 8)
            && (rival.least_ns > known) == (gap_ns > known);
        if !fits {
            *rival = Rival { sum_ns: gap_ns, least_ns: gap_ns, most_ns: gap_ns, count: 1, since: at };
            return Learnt::Nothing;
        }
        rival.sum_ns += gap_ns;
        (rival.least_ns, rival.most_ns) = (rival.least_ns.min(gap_ns), rival.most_ns.max(gap_ns));
        rival.count += 1;
        // They follow each other directly, or with ignored gaps between them. If their distance is no multiple of their
        // length, shorter gaps compensate them: it is jitter.
        let mean_ns = (rival.sum_ns / i64::from(rival.count)).max(Ns(1));
        let apart = i64::from(rival.count - 1);
        let times = |lasts: Ns| ((lasts + mean_ns / 2) / mean_ns).max(apart);
        let off = |lasts: Ns| (lasts - times(lasts) * mean_ns).abs();
        if at.since(rival.since).is_some_and(|lasts| off(lasts) > mean_ns * apart / 8) {
            *rival = Rival { sum_ns: gap_ns, least_ns: gap_ns, most_ns: gap_ns, count: 1, since: at };
            return Learnt::Nothing;
        }
        if rival.count < if rival.least_ns > known * LONG { CHANGED_LONG } else { CHANGED } {
            return Learnt::Nothing;
        }
        let Rival { sum_ns, least_ns, most_ns, count, since } = std::mem::take(rival);
        let to_ns = sum_ns / i64::from(count);
        self.lasting = Lasting::default();
        self.gaps = [to_ns; KEPT];
        (self.count, self.place) = (count as usize, count as usize % KEPT);
        (self.learnt_ns, self.deviation_ns) = (Some(to_ns), (most_ns - least_ns) / 2);
        Learnt::Changed { from_ns: known, to_ns, since }
    }
}
