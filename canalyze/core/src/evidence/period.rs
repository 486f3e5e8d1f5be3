//! How often something comes, learnt from the gaps between its frames: one way for SYNC, heartbeats, PDOs, guarding.
//!
//! The period is the median of the recent gaps that agree. Gaps of a whole number of periods (something was missing)
//! and single odd ones teach nothing; several in a row that agree on another length are another period, which is told
//! ([`Learnt::Changed`]). A configured value is a prior: traffic confirms or contradicts it. It must not judge, and not
//! decide which gaps count: its user hands it none across a burst or a gap of the recording.

use crate::frame::FrameRef;

/// Gaps that are kept.
const KEPT: usize = 16;
/// Gaps that must agree before there is a period at all; and before it is certain.
const LIKELY: usize = 2;
const CERTAIN: usize = 5;
/// Gaps in a row that agree on another length before the period has changed.
const CHANGED: u32 = 6;
/// Gaps agree that differ by less than this part of the period, or by less than twice the usual deviation.
const AGREE_PART: i64 = 32;
/// The mean of as many gaps as are kept has changed if it differs by more than this part of what it was: clocks differ by
/// less, and single gaps that are farther off make up for each other.
const LASTING_PART: i64 = 25;

/// How much is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Confidence {
    /// It is configured, or was seen before something that may have changed it.
    Configured,
    /// Few gaps agree.
    Likely,
    /// At least five gaps agree.
    Certain,
}

/// A period in ns and how much it is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// The period in ns.
    pub ns: i64,
    /// How far gaps usually differ from it, in ns.
    pub deviation_ns: i64,
    /// How much is known.
    pub confidence: Confidence,
    /// How many gaps that are kept show it.
    pub gaps: usize,
}

/// What a gap has shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learnt {
    /// Nothing beyond what was known.
    Nothing,
    /// The first period of which there is certainty.
    First,
    /// Another period than before, for several gaps already: the old and the new one in ns, and the frame that ended
    /// the first gap of the new length.
    Changed {
        /// The period before.
        from_ns: i64,
        /// The period now.
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

/// The mean of as many gaps as are kept, and of those that have come since.
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
    /// Gaps taken, up to [`KEPT`]; and the place of the next one.
    count: usize,
    place: usize,
    learnt_ns: Option<i64>,
    deviation_ns: i64,
    configured_ns: Option<i64>,
    /// What traffic had shown before it was doubted.
    former_ns: Option<i64>,
    rival: Rival,
    lasting: Lasting,
    /// The first certain period was told.
    told: bool,
}

impl Period {
    /// What configuration says; `None`: nothing, or that it is off.
    pub fn configure(&mut self, ns: Option<i64>) {
        self.configured_ns = ns.filter(|ns| *ns > 0);
    }

    /// Whether it is more than what was before something that may have changed it.
    pub fn is_known(&self) -> bool {
        self.learnt_ns.or(self.configured_ns).is_some()
    }

    /// Whether it is certain, or no gap has contradicted it yet.
    pub fn is_even(&self) -> bool {
        let Some(known) = self.learnt_ns else { return true };
        let near = |gap: &i64| gap.abs_diff(known) <= (known / 4).unsigned_abs();
        self.count >= CERTAIN || self.gaps.iter().take(self.count).all(near)
    }

    /// What configuration says, in ns.
    pub fn configured_ns(&self) -> Option<i64> {
        self.configured_ns
    }

    /// The period, by traffic where that has shown one, else as configured.
    pub fn expected(&self) -> Option<Expected> {
        if let Some(ns) = self.learnt_ns {
            let confidence = if self.count >= CERTAIN { Confidence::Certain } else { Confidence::Likely };
            return Some(Expected { ns, deviation_ns: self.deviation_ns, confidence, gaps: self.count });
        }
        let ns = self.configured_ns.max(self.former_ns)?;
        Some(Expected { ns, deviation_ns: 0, confidence: Confidence::Configured, gaps: 0 })
    }

    /// What traffic has shown, in ns.
    pub fn learnt_ns(&self) -> Option<i64> {
        self.learnt_ns
    }

    /// Whether the last gaps agree on another length: the period may be changing.
    pub fn is_contested(&self) -> bool {
        self.rival.count > 0
    }

    /// A reset, or another configuration: it may be another one. Until gaps show which, it may be as long as before.
    pub fn doubt(&mut self) {
        let former_ns = self.learnt_ns.or(self.former_ns);
        *self = Self { former_ns, configured_ns: self.configured_ns, ..Self::default() };
    }

    /// Nothing is known any more but what is configured.
    pub fn forget(&mut self) {
        *self = Self { configured_ns: self.configured_ns, ..Self::default() };
    }

    /// Takes a gap in ns (above 0) that `at` has ended; `uncertain_ns`: how far the recording may be off.
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

    /// A gap that agrees: the mean of many tells a change that is too small for each of them to tell.
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

    /// Gaps agree that differ by less than this, in ns.
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

    /// The median of what is kept, once half of it agrees.
    fn settle(&mut self) -> Learnt {
        let mut sorted = self.gaps;
        let Some(kept) = sorted.get_mut(..self.count) else { return Learnt::Nothing };
        kept.sort_unstable();
        let Some(median) = kept.get(self.count / 2).copied() else { return Learnt::Nothing };
        let near = |gap: &&i64| gap.abs_diff(median) <= (median / 4).unsigned_abs();
        let agreeing = kept.iter().filter(near).count();
        if agreeing < LIKELY || agreeing * 2 < self.count {
            return Learnt::Nothing;
        }
        if self.learnt_ns.is_none() {
            let off = kept.iter().filter(near).map(|gap| gap.saturating_sub(median).saturating_abs()).max();
            self.deviation_ns = off.unwrap_or(0);
        }
        self.learnt_ns = Some(median);
        if self.count < CERTAIN || std::mem::replace(&mut self.told, true) { Learnt::Nothing } else { Learnt::First }
    }

    /// A gap of another length.
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
        // They come one behind the other, or with others between that were set aside. Where their distance is no multiple
        // of their length, shorter ones make up for them: it is jitter.
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
