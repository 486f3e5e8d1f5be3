//! The usual gap of each CAN-ID, from which follow the next due time and the frames missing in a silence of the bus.
//!
//! The recording itself is measured by these gaps; checks learn periods of their own
//! ([`Period`](super::period::Period)).

use crate::bytes::frame::{Frame, Kind};
use crate::bytes::ns::Ns;

/// Number of CAN-IDs with a usual gap: all 11-bit ones, and their remote frames behind them.
pub(super) const IDENTIFIERS: usize = 0x1000;
pub(super) const REMOTE: usize = 0x800;
/// CAN-IDs that show nothing about a pause: commands, emergencies, SDO and LSS have occasions, and the two frames of an
/// SRDO come from one node.
const APERIODIC: [(usize, usize); 5] = [(0x000, 0x07F), (0x081, 0x0FF), (0x101, 0x180), (0x580, 0x67F), (0x7E4, 0x7E5)];
/// True for all others, by CAN-ID.
static BY_ITSELF: [bool; REMOTE] = by_itself();

#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler, which refuses what is out of bounds")]
const fn by_itself() -> [bool; REMOTE] {
    let (mut table, mut row) = ([true; REMOTE], 0);
    while row < APERIODIC.len() {
        let (mut id, last) = APERIODIC[row];
        while id <= last {
            table[id] = false;
            id += 1;
        }
        row += 1;
    }
    table
}

/// CAN-IDs of error control.
pub(super) const ERROR_CONTROL: std::ops::RangeInclusive<usize> = 0x701..=0x77F;

/// CAN-IDs of SRDOs, whose two frames come from one node and so are not two senders.
const SRDO: std::ops::RangeInclusive<usize> = 0x101..=0x180;
/// Number of gaps after which the usual gap is known.
const KNOWN: usize = 3;
/// Part by which two gaps may differ at most if no others are known.
const EXACT: i64 = 64;
/// Maximum deviation of a frame that is on time, in ns; beyond it, the frame is late.
const ON_TIME_NS: Ns = Ns::from_ms(1);
/// Minimum ratio of the gaps of an even CAN-ID to those in a burst.
const SQUEEZED: i64 = 3;

/// Minimum ratio of an unusual silence to the longest recent one, in tenths.
pub(super) const UNUSUAL_TENTHS: i64 = 13;

/// CAN-ID of SYNC.
pub(super) const SYNC: usize = 0x080;
/// CAN-IDs of PDOs, which may answer SYNC.
const PDO: std::ops::RangeInclusive<usize> = 0x181..=0x57F;
/// Number of frames in a row with a similar delay after SYNC that show that a CAN-ID answers it.
const ANSWERS: u8 = 3;
/// Maximum difference of such delays as a part of the period of SYNC, and in ns.
const ANSWER_PART: i64 = 8;
const ANSWER_NS: Ns = Ns::from_us(500);

/// Maximum number of periods between two frames of which some in between were lost one by one, and the part of the
/// period by which the phase may deviate.
const MISSED: i64 = 5;
const IN_PHASE_PART: i64 = 16;
/// The part of a time by which a usual gap may be wrong across it.
const DRIFT_PART: i64 = 1024;

/// A CAN-ID comes in pairs if more than one frame in this many repeats at once.
const PAIRS: usize = 4;
/// Number of kept gaps of a CAN-ID.
const KEPT: usize = 5;

/// The usual gap of a CAN-ID.
#[derive(Clone, Copy, Debug, Default)]
struct Usual {
    last_ns: Ns,
    /// The last gaps, and the number of all so far.
    kept: [Ns; KEPT],
    gaps: usize,
    /// Their median, and the median of their deviations from it, in ns.
    gap_ns: Ns,
    off_ns: Ns,
    /// The last gap of any length, in ns.
    before_ns: Ns,
    /// Number of repetitions after a small part of the usual gap, counted once for each run of frames; and the last
    /// such run.
    pairs: usize,
    pair_run: u32,
    squeezed: Squeezed,
    answer: Answer,
}

/// The delay of a CAN-ID after SYNC.
#[derive(Clone, Copy, Debug, Default)]
struct Answer {
    /// The delay of the last frame after the SYNC before it, in ns.
    delay_ns: Ns,
    /// Number of frames in a row with similar delays.
    even: u8,
}

impl Answer {
    /// Takes a frame after SYNC; returns true if its CAN-ID answers SYNC and this frame does so.
    #[inline]
    fn take(&mut self, sync: SyncSeen, now: Ns) -> bool {
        let delay_ns = now - sync.last_ns;
        let alike = (delay_ns - self.delay_ns).abs() <= sync.most_ns && delay_ns <= sync.half_ns;
        let answers = alike && self.even >= ANSWERS;
        if alike {
            self.even = (self.even + 1).min(2 * ANSWERS);
        } else {
            // One delay of its own does not change what the CAN-ID is.
            self.even = self.even.saturating_sub(2);
        }
        if alike || self.even < ANSWERS {
            self.delay_ns = delay_ns;
        }
        answers
    }
}

/// The last SYNC and half the usual gap between SYNCs, in ns.
#[derive(Clone, Copy, Debug, Default)]
struct SyncSeen {
    last_ns: Ns,
    half_ns: Ns,
    /// Maximum difference of the delays of an answer, in ns.
    most_ns: Ns,
    /// Its counter, if it has one, and the value after which the counter began anew.
    counter: Option<u8>,
    overflow: Option<u8>,
}

impl SyncSeen {
    /// Returns true if a counter went on by a number of SYNCs since then; `None` if one of the two has none, or if the
    /// next SYNC would have the same value.
    fn counts(&self, now: Option<u8>, syncs: i64) -> Option<bool> {
        let (before, now) = (i64::from(self.counter?), i64::from(now?));
        let overflow = self.overflow.map(i64::from).filter(|overflow| before.max(now) <= *overflow);
        let fits = |syncs: i64| match overflow {
            Some(overflow) => (before - 1 + syncs).rem_euclid(overflow.max(1)) + 1 == now,
            None => now - before == syncs,
        };
        let next = fits(1);
        (!next || overflow.is_none()).then(|| fits(syncs))
    }
}

/// SYNC with a counter, before a silence in which it was due.
#[derive(Clone, Copy, Debug)]
pub(super) struct CountedSync {
    seen: SyncSeen,
    gap_ns: Ns,
}

impl CountedSync {
    /// Returns true if the first SYNC since then comes at its time and has counted those in between.
    pub(super) fn goes_on(&self, frame: &Frame, now: Ns) -> bool {
        let after_ns = now - self.seen.last_ns;
        let periods = (after_ns + self.gap_ns / 2) / self.gap_ns.max(Ns(1));
        let off_ns = (after_ns - periods * self.gap_ns).abs();
        let counted = || self.seen.counts(counter_of(frame), periods) == Some(true);
        periods > 1 && off_ns <= self.gap_ns / IN_PHASE_PART + after_ns / DRIFT_PART && counted()
    }
}

/// A repetition of a little-known CAN-ID in a burst; the gaps after the burst show if it was one.
#[derive(Clone, Copy, Debug, Default)]
struct Squeezed {
    /// The number of the burst, or 0.
    burst: u32,
    /// The time to the repetition, and the last gap after the burst, in ns.
    ns: Ns,
    gap_ns: Ns,
}

/// A CAN-ID that is sent on its own with even gaps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Even {
    pub(super) id: usize,
    /// The node of a heartbeat; 0 for other CAN-IDs, which may depend on each other like PDOs on SYNC.
    pub(super) node: u8,
    /// Time of the last frame, usual gap, and its usual deviation, in ns.
    pub(super) last_ns: Ns,
    pub(super) gap_ns: Ns,
    pub(super) off_ns: Ns,
    /// Largest deviation of the last gaps, in ns.
    pub(super) most_off_ns: Ns,
}

/// Lateness of a frame and its uncertainty, in ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Late {
    pub(super) ns: Ns,
    pub(super) room_ns: Ns,
}

impl Late {
    /// Returns true if the frame was on time.
    pub(super) fn is_on_time(self) -> bool {
        self.ns <= ON_TIME_NS && self.room_ns <= 4 * ON_TIME_NS
    }
}

/// The evidence of a frame's time about its sender.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct SenderEvidence {
    /// Its lateness, if it was due since the silence began.
    pub(super) late: Option<Late>,
    /// True if its CAN-ID, sent on its own with even gaps, repeated after a small part of its usual gap.
    pub(super) compressed: bool,
    /// True if it had also been later than usual before.
    pub(super) caught_up: bool,
    /// True if a little-known CAN-ID repeated; frames after the burst will show more.
    pub(super) again: bool,
    /// The number of a burst in which the gaps of its CAN-ID were shorter than after it, or 0.
    pub(super) tells_of: u32,
    /// True if it answers a SYNC with its usual delay, so that it is late only if SYNC is.
    pub(super) answers: bool,
    /// Frames of its CAN-ID that are missing before it.
    pub(super) missed: Option<Box<Missed>>,
}

/// Frames that are missing between two of an even CAN-ID that keeps its phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Missed {
    /// The node of a heartbeat; 0 for SYNC.
    pub(super) node: u8,
    /// Their number.
    pub(super) frames: u32,
    /// The due time of the first one, and the period, in ns.
    pub(super) at_ns: Ns,
    pub(super) period_ns: Ns,
    /// True if it is a SYNC that was counted, or that PDOs answered.
    pub(super) answered: bool,
}

/// A running burst: its number, and the beginning and end of the preceding silence in ns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) number: u32,
    pub(super) from_ns: Ns,
    pub(super) to_ns: Ns,
    /// True if the silence is longer than recent ones.
    pub(super) unusual: bool,
}

impl Usual {
    /// Returns the due time of the next frame in ns, if the gaps are even.
    fn due_ns(&self) -> Option<Ns> {
        let even = self.gaps >= KNOWN && self.off_ns < self.gap_ns / 8;
        even.then(|| self.last_ns + self.gap_ns)
    }

    /// Returns the usual gap and its deviation in ns, if the gaps are even. The last two gaps suffice if little else is
    /// known.
    fn even(&self) -> Option<(Ns, Ns)> {
        if self.due_ns().is_some() {
            // Gaps that a stall may have lengthened were left out; the last gap of any length has to be similar.
            let as_usual = self.before_ns.abs_diff(self.gap_ns) < self.gap_ns.abs() / 2;
            return as_usual.then_some((self.gap_ns, self.off_ns));
        }
        let kept = |before: usize| self.kept.get(self.gaps.checked_sub(before)? % KEPT).copied();
        let (last, before) = (kept(1)?, kept(2)?);
        let off_ns = (last - before).abs();
        (off_ns < last / EXACT).then_some((last, off_ns))
    }

    /// Returns the largest deviation of the kept gaps from `gap_ns`.
    fn most_off_ns(&self, gap_ns: Ns) -> Ns {
        let kept = self.kept.iter().take(self.gaps);
        kept.map(|gap| (*gap - gap_ns).abs()).max().unwrap_or(Ns::ZERO)
    }

    /// Returns the lateness of a frame at `now`. If several were due and one has come, others are missing and it is not
    /// late.
    fn late(&self, from: Ns, now: Ns) -> Option<Late> {
        let ns = now - self.due_ns().filter(|due| *due > from)?;
        let room_ns = (self.off_ns * 4).max(ON_TIME_NS);
        (-room_ns..self.gap_ns / 4 * 3).contains(&ns).then_some(Late { ns, room_ns })
    }

    /// Adds a gap after a burst in which the CAN-ID repeated; returns the number of the burst once two gaps agree on
    /// being longer.
    fn compare(&mut self, gap: Ns, least_ns: Ns) -> u32 {
        let Squeezed { burst, ns, gap_ns } = self.squeezed;
        if burst == 0 {
            return 0;
        }
        let longer = |gap: Ns| gap / SQUEEZED > ns.max(least_ns);
        self.squeezed.gap_ns = gap;
        if longer(gap) && longer(gap_ns) && gap.abs_diff(gap_ns) < gap.abs() / 4 { burst } else { 0 }
    }

    /// Records a repetition after a small part of the usual gap; returns true if that is unusual, since some CAN-IDs
    /// come in pairs.
    fn pair(&mut self, run: Option<Run>) -> bool {
        let number = run.map_or(0, |run| run.number);
        let again = number != 0 && number == self.pair_run;
        let before = self.pairs.saturating_sub(usize::from(again));
        self.pairs += usize::from(!again);
        self.pair_run = number;
        before * PAIRS < self.gaps + PAIRS
    }

    /// Returns true if a frame at `now` outside a burst only adds to the usual gap.
    #[inline]
    fn only_adds(&self, now: Ns) -> bool {
        self.last_ns != Ns::ZERO && now - self.last_ns > self.gap_ns / 4
    }

    /// Adds a frame at `now` that is neither early nor in a burst; returns the result of [`Self::compare`].
    #[inline]
    fn take(&mut self, now: Ns, drain_ns: Ns) -> u32 {
        let gap = now - self.last_ns;
        (self.last_ns, self.before_ns) = (now, gap);
        let tells_of = self.compare(gap, drain_ns);
        self.learn(gap);
        tells_of
    }

    /// Examines a frame at `now` in detail. Out of line, since few frames need it.
    #[inline(never)]
    fn see(&mut self, id: usize, now: Ns, run: Option<Run>, drain_ns: Ns) -> SenderEvidence {
        let gap = now - self.last_ns;
        let again = run.filter(|run| gap <= now - run.to_ns);
        let even = self.gap_ns > 4 * drain_ns;
        let timed = run.filter(|_| even && again.is_none() && is_timed(id));
        let late = timed.and_then(|run| self.late(run.from_ns, now));
        let mut seen = SenderEvidence { late, ..SenderEvidence::default() };
        let known = std::mem::replace(&mut self.last_ns, now) != Ns::ZERO;
        if !known || gap < Ns::ZERO {
            return seen;
        }
        // The recorder may have lengthened the gap.
        let across = run.is_some_and(|run| run.unusual && again.is_none() && self.gaps > 0);
        let short = self.gaps > 1 && even && gap < self.gap_ns / 4;
        // Frames from a slow buffer are compressed less, which is evidence only after an unusual silence.
        let squeezed = self.gaps > 1 && run.is_some_and(|run| run.unusual) && gap / 2 < self.gap_ns / 5;
        seen.compressed = even && (short || squeezed) && is_timed(id) && self.pair(run);
        seen.caught_up = seen.compressed && self.before_ns > self.gap_ns + self.gap_ns / 4;
        self.before_ns = gap;
        // A silence can bring two frames closer by its length at most.
        if let Some(run) = again.filter(|run| gap <= (run.to_ns - run.from_ns) / 2) {
            // The meaning for its sender is known once the burst is decided.
            seen.again = self.gaps < KNOWN && is_timed(id);
            if seen.again {
                let before = Some(self.squeezed).filter(|one| one.burst == run.number);
                let ns = before.map_or(gap, |one| one.ns.min(gap));
                self.squeezed = Squeezed { burst: run.number, ns, gap_ns: Ns::ZERO };
            }
            return seen;
        }
        seen.tells_of = self.compare(gap, drain_ns);
        if !short && !across {
            self.learn(gap);
        }
        seen
    }

    #[inline]
    fn learn(&mut self, gap: Ns) {
        let place = self.gaps % KEPT;
        if let Some(slot) = self.kept.get_mut(place) {
            *slot = gap;
        }
        self.gaps += 1;
        // Once there are enough gaps, they are averaged each time all of them are new.
        if self.gaps < KEPT || place + 1 == KEPT {
            self.average();
        }
    }

    #[inline(never)]
    fn average(&mut self) {
        if self.gaps >= KEPT {
            self.gap_ns = median_of_five(self.kept);
            self.off_ns = median_of_five(self.kept.map(|gap| (gap - self.gap_ns).abs()));
            return;
        }
        let mut kept = self.kept;
        let Some(kept) = kept.get_mut(..self.gaps) else { return };
        self.gap_ns = median(kept);
        kept.iter_mut().for_each(|gap| *gap = (*gap - self.gap_ns).abs());
        self.off_ns = median(kept);
    }
}

/// Returns the same as [`median`] without sorting, since every CAN-ID needs it often.
fn median_of_five([a, b, c, d, e]: [Ns; KEPT]) -> Ns {
    let low = a.min(b).max(c.min(d));
    let high = a.max(b).min(c.max(d));
    // The median of these and the fifth.
    e.min(low).max(e.max(low).min(high))
}

fn median(values: &mut [Ns]) -> Ns {
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or(Ns::ZERO)
}

/// The CAN-IDs of a bus.
#[derive(Debug, Default)]
pub(super) struct Senders {
    /// Usual gaps by CAN-ID; empty until the first stamp.
    usual: Vec<Usual>,
    /// CAN-IDs seen so far.
    active: Vec<usize>,
    sync: SyncSeen,
    alone: Alone,
}

/// The frames that neither are SYNC nor answer it.
#[derive(Clone, Copy, Debug, Default)]
struct Alone {
    /// Time of the last one, and the longest recent gap between two, in ns.
    last_ns: Ns,
    gap_ns: Ns,
}

impl Alone {
    #[inline]
    fn take(&mut self, now: Ns) {
        if self.last_ns != Ns::ZERO {
            self.gap_ns = (self.gap_ns - self.gap_ns / 256).max(now - self.last_ns);
        }
        self.last_ns = now;
    }
}

impl Senders {
    /// Follows a frame at `now`, perhaps in a run after a silence. Buffered frames follow each other within `drain_ns`.
    pub(super) fn see(&mut self, frame: &Frame, now: Ns, run: Option<Run>, drain_ns: Ns) -> SenderEvidence {
        let Some((id, usual, answers, missed)) = self.come(frame, now) else { return SenderEvidence::default() };
        if run.is_none() && usual.only_adds(now) {
            return SenderEvidence { tells_of: usual.take(now, drain_ns), missed, ..SenderEvidence::default() };
        }
        SenderEvidence { answers, missed, ..usual.see(id, now, run, drain_ns) }
    }

    /// Follows a frame at `now` as [`Self::see`] does without a run; returns the frames missing before it.
    #[inline(always)]
    pub(super) fn see_alone(&mut self, frame: &Frame, now: Ns, drain_ns: Ns) -> Option<Box<Missed>> {
        let (id, usual, _, missed) = self.come(frame, now)?;
        if usual.only_adds(now) {
            usual.take(now, drain_ns);
        } else {
            usual.see(id, now, None, drain_ns);
        }
        missed
    }

    /// Takes a frame's place after SYNC; returns the index of its CAN-ID with its usual gap, true if it answers SYNC with
    /// its usual delay, and the frames missing before it.
    #[inline(always)]
    fn come(&mut self, frame: &Frame, now: Ns) -> Option<(usize, &mut Usual, bool, Option<Box<Missed>>)> {
        if self.usual.is_empty() {
            self.usual = vec![Usual::default(); IDENTIFIERS];
        }
        let id = identifier(frame)?;
        let missed = if is_sent_by_time(id) && frame.payload() != [0] { self.missed(id, frame, now) } else { None };
        let usual = self.usual.get_mut(id)?;
        let answers = PDO.contains(&id) && usual.answer.take(self.sync, now);
        if id != SYNC && !answers {
            self.alone.take(now);
        }
        if id == SYNC {
            let (half_ns, most_ns) = (usual.gap_ns / 2, (usual.gap_ns / ANSWER_PART).min(ANSWER_NS));
            let counter = counter_of(frame);
            let even = now - usual.last_ns < usual.gap_ns + usual.gap_ns / 4;
            let anew = counter == Some(1) && even && self.sync.counter > Some(1);
            let overflow =
                if anew { self.sync.counter } else { self.sync.overflow.filter(|most| counter <= Some(*most)) };
            self.sync = SyncSeen { last_ns: now, half_ns, most_ns, counter, overflow };
        }
        if usual.last_ns == Ns::ZERO {
            self.active.push(id);
        }
        Some((id, usual, answers, missed))
    }

    /// Returns the frames missing before one at `now` of a CAN-ID that is sent by time, if it keeps its phase.
    #[inline]
    fn missed(&self, id: usize, frame: &Frame, now: Ns) -> Option<Box<Missed>> {
        let usual = self.usual.get(id)?;
        let gap = now - usual.last_ns;
        if usual.gaps < KNOWN || gap / 3 < usual.gap_ns / 2 || gap / MISSED > usual.gap_ns {
            return None;
        }
        self.missed_by((id, usual), counter_of(frame), gap)
    }

    #[cold]
    fn missed_by(&self, (id, usual): (usize, &Usual), counter: Option<u8>, gap: Ns) -> Option<Box<Missed>> {
        let period_ns = usual.even().map(|(gap_ns, _)| gap_ns).filter(|gap_ns| *gap_ns > Ns::ZERO)?;
        let periods = (gap + period_ns / 2) / period_ns;
        let off_ns = (gap - periods * period_ns).abs();
        let room_ns = (usual.off_ns * 4).max(ON_TIME_NS).min(period_ns / IN_PHASE_PART);
        // Guarding has occasions.
        // Frames that are fetched at times of their own come by unequal gaps; those across a loss are multiples.
        let off = |gap: &Ns| (*gap + period_ns / 2) % period_ns - period_ns / 2;
        let mut kept = usual.kept.iter().take(usual.gaps);
        let uneven = kept.any(|gap| off(gap).abs() > period_ns / IN_PHASE_PART);
        if off_ns > room_ns || uneven || periods < 2 || self.active.contains(&(id | REMOTE)) {
            return None;
        }
        let at_ns = usual.last_ns + period_ns;
        let answers = |usual: &Usual| {
            let early_ns = (usual.answer.delay_ns - (usual.last_ns - at_ns)).abs();
            usual.answer.even >= ANSWERS && early_ns <= (period_ns / ANSWER_PART).min(ANSWER_NS)
        };
        let followers = || self.active.iter().filter(|id| PDO.contains(id)).filter_map(|id| self.usual.get(*id));
        let counted = self.sync.counts(counter, periods);
        let answered = id == SYNC && counted.unwrap_or_else(|| followers().any(answers));
        // A producer that skips a SYNC does not count it, and is not answered.
        let skipped = counted.is_some() || followers().any(|usual| usual.answer.even >= ANSWERS);
        if id == SYNC && !answered && skipped {
            return None;
        }
        let frames = u32::try_from(periods - 1).ok()?;
        Some(Box::new(Missed { node: (id % 0x80) as u8, frames, at_ns, period_ns, answered }))
    }

    /// Iterates over the CAN-IDs that are sent on their own with even gaps.
    pub(super) fn even(&self) -> impl Iterator<Item = Even> {
        let known = self.active.iter().filter(|id| comes_by_itself(**id));
        known.filter_map(|id| {
            let usual = self.usual.get(*id)?;
            let (gap_ns, off_ns) = usual.even()?;
            let heartbeat = ERROR_CONTROL.contains(id) && !self.active.contains(&(id | REMOTE));
            let node = if heartbeat { *id as u8 & 0x7F } else { 0 };
            let most_off_ns = usual.most_off_ns(gap_ns);
            Some(Even { id: *id, node, last_ns: usual.last_ns, gap_ns, off_ns, most_off_ns })
        })
    }

    /// Returns SYNC if it has a counter and was due in a silence, which is longer than recent ones of those that do not
    /// depend on SYNC: where SYNC alone does not come, others do.
    pub(super) fn counted_sync(&self, from: Ns, to: Ns) -> Option<CountedSync> {
        self.sync.counter?;
        let usual_ns = self.alone.gap_ns.max(from - self.alone.last_ns);
        if self.alone.last_ns == Ns::ZERO || (to - from) / UNUSUAL_TENTHS <= usual_ns / 10 {
            return None;
        }
        let (gap_ns, off_ns) = self.usual.get(SYNC)?.even()?;
        let due = self.sync.last_ns + gap_ns;
        let missed = due > from && due + (off_ns * 4).max(ON_TIME_NS) < to;
        missed.then_some(CountedSync { seen: self.sync, gap_ns })
    }

    /// Returns the number of even CAN-IDs, those that answer SYNC apart, that became overdue during a silence, with a
    /// tolerance of `room_ns` and their jitter.
    pub(super) fn overdue(&self, from: Ns, to: Ns, room_ns: Ns) -> usize {
        let overdue = |usual: &Usual| {
            let room = (usual.gap_ns / 16) + usual.off_ns * 2 + room_ns;
            let of_its_own = usual.answer.even < ANSWERS;
            of_its_own && usual.due_ns().is_some_and(|due| due >= from && due + room < to)
        };
        self.active.iter().filter(|id| self.usual.get(**id).is_some_and(overdue)).count()
    }

    /// Returns true if a frame of a sender that does not depend on SYNC was due in a silence, twice its usual gap after
    /// the previous one.
    pub(super) fn others_missed(&self, from: Ns, to: Ns) -> bool {
        let due = |usual: &Usual| {
            let due = usual.last_ns + usual.gap_ns * 2;
            usual.gap_ns > Ns::ZERO && usual.answer.even < ANSWERS && (from..to).contains(&due)
        };
        let mut others = self.active.iter().filter(|id| comes_by_itself(**id) && **id != SYNC);
        others.any(|id| self.usual.get(*id).is_some_and(due))
    }

    /// Returns the number of frames that usually answer SYNC within `ns`.
    pub(super) fn usual_answers(&self, ns: Ns) -> i64 {
        let frames = |id: &usize| {
            let usual = self.usual.get(*id)?;
            (usual.answer.even >= ANSWERS && usual.gap_ns > Ns::ZERO).then(|| ns / usual.gap_ns)
        };
        self.active.iter().filter_map(frames).fold(0, i64::saturating_add)
    }

    /// Returns true if a CAN-ID had shorter gaps in a burst than after it, as far as one gap shows.
    pub(super) fn likely_tell_of(&self, burst: u32, least_ns: Ns) -> bool {
        let longer = |one: &Squeezed| one.burst == burst && one.gap_ns / SQUEEZED > one.ns.max(least_ns);
        self.active.iter().any(|id| self.usual.get(*id).is_some_and(|usual| longer(&usual.squeezed)))
    }

    /// Returns the nodes, one bit each, with a frame due in a silence, `tenths` of its usual gap after the previous
    /// one. Senders that fell silent before do not count.
    pub(super) fn missing(&self, from: Ns, now: Ns, tenths: i64) -> u128 {
        let due = |usual: &Usual| {
            let due = usual.last_ns + usual.gap_ns * tenths / 10;
            usual.gap_ns > Ns::ZERO && (from..now).contains(&due)
        };
        let mut nodes = 0_u128;
        for id in self.active.iter().filter(|id| comes_by_itself(**id) && self.usual.get(**id).is_some_and(due)) {
            nodes |= 1 << (id % 0x80);
        }
        nodes
    }
}

/// Returns the counter of a SYNC.
fn counter_of(frame: &Frame) -> Option<u8> {
    match frame.payload() {
        [counter] => Some(*counter),
        _ => None,
    }
}

/// Returns true if the time of a CAN-ID's frame shows its lateness.
fn is_timed(id: usize) -> bool {
    comes_by_itself(id) || SRDO.contains(&id)
}

/// Returns true if a CAN-ID is sent by time alone: SYNC and heartbeats. PDOs may depend on their values.
pub(super) fn is_sent_by_time(id: usize) -> bool {
    id == SYNC || ERROR_CONTROL.contains(&id)
}

/// Returns the index of a frame's CAN-ID; remote frames have indexes of their own.
pub(super) fn identifier(frame: &Frame) -> Option<usize> {
    let id = frame.id.raw() as usize | if frame.kind == Kind::Remote { REMOTE } else { 0 };
    (!frame.id.is_extended()).then_some(id)
}

/// Returns true if frames of a CAN-ID are sent by time and not on an occasion.
pub(super) fn comes_by_itself(id: usize) -> bool {
    BY_ITSELF.get(id % REMOTE).is_some_and(|by_itself| *by_itself)
}

#[cfg(test)]
mod tests {
    use super::{Ns, median, median_of_five};

    #[test]
    fn the_middle_of_five_is_the_median() {
        for number in 0..3_125_i64 {
            let five = [1, 5, 25, 125, 625].map(|part| Ns(number / part % 5));
            assert_eq!(median_of_five(five), median(&mut five.clone()), "{five:?}");
        }
    }
}
