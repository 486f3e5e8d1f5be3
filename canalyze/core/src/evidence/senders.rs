//! How often each CAN-ID comes: when its next frame is expected, and what a silence of the bus has left out.
//!
//! This is what the recording itself is measured by; what a check owes and is owed it learns by itself
//! ([`Period`](super::period::Period)). It must not know what a frame means, beyond which CAN-IDs come by themselves.

use crate::frame::{Frame, Kind};

/// CAN-IDs of which the usual gap is kept: all 11-bit ones, and their remote frames behind them.
const IDENTIFIERS: usize = 0x1000;
const REMOTE: usize = 0x800;
/// Those that tell nothing of a pause: commands, emergencies, SDO and LSS are sent when there is a reason, and the two
/// frames of an SRDO are one node's.
const APERIODIC: [std::ops::RangeInclusive<usize>; 5] =
    [0x000..=0x07F, 0x081..=0x0FF, 0x101..=0x180, 0x580..=0x67F, 0x7E4..=0x7E5];

/// CAN-IDs of error control.
pub(super) const ERROR_CONTROL: std::ops::RangeInclusive<usize> = 0x701..=0x77F;

/// The two frames of an SRDO are one node's, and so no two senders.
const SRDO: std::ops::RangeInclusive<usize> = 0x101..=0x180;
/// Gaps after which it is known how often a CAN-ID comes.
const KNOWN: usize = 3;
/// Where only two gaps are known, they may differ by this part of one at most.
const EXACT: i64 = 64;
/// What comes this close to its time is on time, in ns, and further off than that it is late.
const ON_TIME_NS: i64 = 1_000_000;
/// By how much, at least, the gaps of a CAN-ID that comes evenly are longer than those in a burst.
const SQUEEZED: i64 = 3;

/// A CAN-ID of which more than one frame in this many comes again at once comes in pairs.
const PAIRS: usize = 4;
/// Gaps that are kept of a CAN-ID.
const KEPT: usize = 5;

/// How often a CAN-ID comes.
#[derive(Clone, Copy, Debug, Default)]
struct Usual {
    last_ns: i64,
    /// The last gaps, and how many were taken.
    kept: [i64; KEPT],
    gaps: usize,
    /// Their median, and the median of how far they are off it, in ns.
    gap_ns: i64,
    off_ns: i64,
    /// The last gap, in ns, whatever it was.
    before_ns: i64,
    /// How often it came again in a small part of that: once for each run of frames, of which the last is kept.
    pairs: usize,
    pair_run: u32,
    squeezed: Squeezed,
}

/// A CAN-ID of which little was known came again in a burst: how often it comes behind it tells whether that was one.
#[derive(Clone, Copy, Debug, Default)]
struct Squeezed {
    /// The number of the burst; 0: none.
    burst: u32,
    /// In how short a time it came again, and the last gap behind the burst, in ns.
    ns: i64,
    gap_ns: i64,
}

/// A CAN-ID that comes by itself and evenly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Even {
    pub(super) id: usize,
    /// Whose heartbeat it is. 0: another CAN-ID; they may depend on each other, as PDOs do on SYNC.
    pub(super) node: u8,
    /// Its last frame's time, its usual gap, and how far gaps are off that, in ns.
    pub(super) last_ns: i64,
    pub(super) gap_ns: i64,
    pub(super) off_ns: i64,
    /// How far the last gaps were off it at most, in ns.
    pub(super) most_off_ns: i64,
}

/// By how much a frame came later than it was due, and how exactly that is known, in ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Late {
    pub(super) ns: i64,
    pub(super) room_ns: i64,
}

impl Late {
    /// Whether the frame came when it was due.
    pub(super) fn is_on_time(self) -> bool {
        self.ns <= ON_TIME_NS && self.room_ns <= 4 * ON_TIME_NS
    }
}

/// What the time of a frame has shown of its sender.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Seen {
    /// It was due since the silence began.
    pub(super) late: Option<Late>,
    /// Its CAN-ID, that comes by itself and evenly, came again in a small part of its usual gap.
    pub(super) compressed: bool,
    /// And it had come later than usual before.
    pub(super) caught_up: bool,
    /// The same of one of which too little is known: frames behind the burst will tell.
    pub(super) again: bool,
    /// The number of a burst in which its CAN-ID came closer than it does behind it; 0: none.
    pub(super) tells_of: u32,
}

/// A burst that runs: its number, and the silence before it (from, to in ns).
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) number: u32,
    pub(super) from_ns: i64,
    pub(super) to_ns: i64,
    /// It is longer than those of late.
    pub(super) unusual: bool,
}

impl Usual {
    /// When the next frame is expected, of a CAN-ID whose gaps are even, in ns.
    fn due_ns(&self) -> Option<i64> {
        let even = self.gaps >= KNOWN && self.off_ns < self.gap_ns / 8;
        even.then(|| self.last_ns.saturating_add(self.gap_ns))
    }

    /// Its usual gap and how far gaps are off it, in ns, where they are even. The last two tell, where little else is known.
    fn even(&self) -> Option<(i64, i64)> {
        if self.due_ns().is_some() {
            // Gaps that a stall may have lengthened were left out: the last one, whatever it was, has to be like them.
            let as_usual = self.before_ns.abs_diff(self.gap_ns) < self.gap_ns.unsigned_abs() / 2;
            return as_usual.then_some((self.gap_ns, self.off_ns));
        }
        let kept = |before: usize| self.kept.get(self.gaps.checked_sub(before)? % KEPT).copied();
        let (last, before) = (kept(1)?, kept(2)?);
        let off_ns = last.saturating_sub(before).saturating_abs();
        (off_ns < last / EXACT).then_some((last, off_ns))
    }

    /// How far the gaps that are kept are off a gap at most, in ns.
    fn most_off_ns(&self, gap_ns: i64) -> i64 {
        let kept = self.kept.iter().take(self.gaps);
        kept.map(|gap| gap.saturating_sub(gap_ns).saturating_abs()).max().unwrap_or(0)
    }

    /// How late it is at `now`. Where several were due and one has come, others are missing: it is not late.
    fn late(&self, from: i64, now: i64) -> Option<Late> {
        let ns = now.saturating_sub(self.due_ns().filter(|due| *due > from)?);
        let room_ns = self.off_ns.saturating_mul(4).max(ON_TIME_NS);
        (-room_ns..self.gap_ns / 4 * 3).contains(&ns).then_some(Late { ns, room_ns })
    }

    /// Takes a gap behind a burst in which the CAN-ID came again: the number of that burst, once two gaps agree that it
    /// comes less often.
    fn compare(&mut self, gap: i64, least_ns: i64) -> u32 {
        let Squeezed { burst, ns, gap_ns } = self.squeezed;
        if burst == 0 {
            return 0;
        }
        let longer = |gap: i64| gap / SQUEEZED > ns.max(least_ns);
        self.squeezed.gap_ns = gap;
        if longer(gap) && longer(gap_ns) && gap.abs_diff(gap_ns) < gap.unsigned_abs() / 4 { burst } else { 0 }
    }

    /// It came again in a small part of its usual gap. Says whether that is unusual: some CAN-IDs come in pairs.
    fn pair(&mut self, run: Option<Run>) -> bool {
        let number = run.map_or(0, |run| run.number);
        let again = number != 0 && number == self.pair_run;
        let before = self.pairs.saturating_sub(usize::from(again));
        self.pairs += usize::from(!again);
        self.pair_run = number;
        before * PAIRS < self.gaps + PAIRS
    }

    /// A frame came at `now`, neither too early nor in a burst: gives what [`Self::compare`] does.
    #[inline]
    fn take(&mut self, now: i64, drain_ns: i64) -> u32 {
        let gap = now.saturating_sub(self.last_ns);
        (self.last_ns, self.before_ns) = (now, gap);
        let tells_of = self.compare(gap, drain_ns);
        self.learn(gap);
        tells_of
    }

    /// Looks closely at a frame, which came at `now`. Out of line: few frames need it.
    #[inline(never)]
    fn see(&mut self, id: usize, now: i64, run: Option<Run>, drain_ns: i64) -> Seen {
        let gap = now.saturating_sub(self.last_ns);
        let again = run.filter(|run| gap <= now.saturating_sub(run.to_ns));
        let even = self.gap_ns > 4 * drain_ns;
        let timed = run.filter(|_| even && again.is_none() && is_timed(id));
        let late = timed.and_then(|run| self.late(run.from_ns, now));
        let mut seen = Seen { late, ..Seen::default() };
        let known = std::mem::replace(&mut self.last_ns, now) != 0;
        if !known || gap < 0 {
            return seen;
        }
        // The recorder may have lengthened it.
        let across = run.is_some_and(|run| run.unusual && again.is_none() && self.gaps > 0);
        let short = self.gaps > 1 && even && gap < self.gap_ns / 4;
        // Frames of a slow buffer are compressed less; then it needs an unusual silence to tell.
        let squeezed = self.gaps > 1 && run.is_some_and(|run| run.unusual) && gap / 2 < self.gap_ns / 5;
        seen.compressed = even && (short || squeezed) && is_timed(id) && self.pair(run);
        seen.caught_up = seen.compressed && self.before_ns > self.gap_ns.saturating_add(self.gap_ns / 4);
        self.before_ns = gap;
        // A silence can have brought two frames no closer than by its length.
        if let Some(run) = again.filter(|run| gap <= run.to_ns.saturating_sub(run.from_ns) / 2) {
            // What it shows of its sender is known when the burst is.
            seen.again = self.gaps < KNOWN && is_timed(id);
            if seen.again {
                let before = Some(self.squeezed).filter(|one| one.burst == run.number);
                let ns = before.map_or(gap, |one| one.ns.min(gap));
                self.squeezed = Squeezed { burst: run.number, ns, gap_ns: 0 };
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
    fn learn(&mut self, gap: i64) {
        let place = self.gaps % KEPT;
        if let Some(slot) = self.kept.get_mut(place) {
            *slot = gap;
        }
        self.gaps += 1;
        // Once the last gaps are known they are looked at together, when all of them are new.
        if self.gaps < KEPT || place + 1 == KEPT {
            self.average();
        }
    }

    #[inline(never)]
    fn average(&mut self) {
        if self.gaps >= KEPT {
            self.gap_ns = median_of_five(self.kept);
            self.off_ns = median_of_five(self.kept.map(|gap| gap.saturating_sub(self.gap_ns).saturating_abs()));
            return;
        }
        let mut kept = self.kept;
        let Some(kept) = kept.get_mut(..self.gaps) else { return };
        self.gap_ns = median(kept);
        kept.iter_mut().for_each(|gap| *gap = gap.saturating_sub(self.gap_ns).saturating_abs());
        self.off_ns = median(kept);
    }
}

/// The same as [`median`] without sorting: every CAN-ID takes it again and again.
fn median_of_five([a, b, c, d, e]: [i64; KEPT]) -> i64 {
    let low = a.min(b).max(c.min(d));
    let high = a.max(b).min(c.max(d));
    // Of these and the fifth, the one in the middle.
    e.min(low).max(e.max(low).min(high))
}

fn median(values: &mut [i64]) -> i64 {
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or(0)
}

/// The CAN-IDs of a bus.
#[derive(Debug, Default)]
pub(super) struct Senders {
    /// By CAN-ID; empty until the first stamp.
    usual: Vec<Usual>,
    /// CAN-IDs that were seen.
    active: Vec<usize>,
}

impl Senders {
    /// Takes the time of a frame, which may stand in a run behind a silence. Frames of a buffer follow each other within
    /// `drain_ns`.
    pub(super) fn see(&mut self, frame: &Frame, now: i64, run: Option<Run>, drain_ns: i64) -> Seen {
        if self.usual.is_empty() {
            self.usual = vec![Usual::default(); IDENTIFIERS];
        }
        let Some(id) = identifier(frame) else { return Seen::default() };
        let Some(usual) = self.usual.get_mut(id) else { return Seen::default() };
        if usual.last_ns == 0 {
            self.active.push(id);
        } else if run.is_none() && now.saturating_sub(usual.last_ns) > usual.gap_ns / 4 {
            // All that it shows is how often it comes.
            return Seen { tells_of: usual.take(now, drain_ns), ..Seen::default() };
        }
        usual.see(id, now, run, drain_ns)
    }

    /// The CAN-IDs that come by themselves and evenly.
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

    /// How many CAN-IDs came evenly and were overdue by `room_ns` and their jitter when a silence ended, and not when it
    /// began.
    pub(super) fn overdue(&self, from: i64, to: i64, room_ns: i64) -> usize {
        let overdue = |usual: &Usual| {
            let room = (usual.gap_ns / 16).saturating_add(usual.off_ns.saturating_mul(2)).saturating_add(room_ns);
            usual.due_ns().is_some_and(|due| due >= from && due.saturating_add(room) < to)
        };
        self.active.iter().filter(|id| self.usual.get(**id).is_some_and(overdue)).count()
    }

    /// Whether a CAN-ID came in a burst closer than it does behind it, as far as one gap tells.
    pub(super) fn likely_tell_of(&self, burst: u32, least_ns: i64) -> bool {
        let longer = |one: &Squeezed| one.burst == burst && one.gap_ns / SQUEEZED > one.ns.max(least_ns);
        self.active.iter().any(|id| self.usual.get(*id).is_some_and(|usual| longer(&usual.squeezed)))
    }

    /// The nodes, one bit each, of which a frame was expected during a silence, `tenths` of its usual gap after the last.
    /// A sender that fell silent before does not count.
    pub(super) fn missing(&self, from: i64, now: i64, tenths: i64) -> u128 {
        let due = |usual: &Usual| {
            let due = usual.last_ns.saturating_add(usual.gap_ns.saturating_mul(tenths) / 10);
            usual.gap_ns > 0 && (from..now).contains(&due)
        };
        let mut nodes = 0_u128;
        for id in self.active.iter().filter(|id| comes_by_itself(**id) && self.usual.get(**id).is_some_and(due)) {
            nodes |= 1 << (id % 0x80);
        }
        nodes
    }
}

/// Whether the time at which a frame of a CAN-ID comes tells how late it is.
fn is_timed(id: usize) -> bool {
    comes_by_itself(id) || SRDO.contains(&id)
}

/// The place of a frame's CAN-ID among those that are kept: remote frames have places of their own.
pub(super) fn identifier(frame: &Frame) -> Option<usize> {
    let id = frame.id.raw() as usize | if frame.kind == Kind::Remote { REMOTE } else { 0 };
    (!frame.id.is_extended()).then_some(id)
}

/// Whether frames of a CAN-ID come when their time has come.
pub(super) fn comes_by_itself(id: usize) -> bool {
    !APERIODIC.iter().any(|range| range.contains(&(id % REMOTE)))
}

#[cfg(test)]
mod tests {
    use super::{median, median_of_five};

    #[test]
    fn the_middle_of_five_is_the_median() {
        for number in 0..3_125_i64 {
            let five = [number % 5, number / 5 % 5, number / 25 % 5, number / 125 % 5, number / 625];
            assert_eq!(median_of_five(five), median(&mut five.clone()), "{five:?}");
        }
    }
}
