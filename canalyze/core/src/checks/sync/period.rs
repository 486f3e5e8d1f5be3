//! The period of SYNC: its SYNCs counted, how regularly they come, and what an irregular gap was.
//!
//! A gap is judged against the phase: a SYNC that was only listed late is followed by one at the old time, a missing
//! one moves nothing after it. The judgement therefore waits for the SYNCs that follow. Gaps that a burst of the
//! recording begins or ends are not judged. It raises nothing: `sync` reports what a gap was.

use crate::evidence::period::{Learnt, Period};
use crate::evidence::recording::Recording;
use crate::evidence::when::When;
use crate::finding::Verdict;
use crate::frame::FrameRef;
use crate::rules::sync::{Syn003, Syn006, Syn012};

/// SYNCs remembered: as many as the longest cycle of a synchronous PDO (transmission type 240).
const SYNCS: usize = 256;
/// Gaps that wait at most for the period to show, and how many of them must agree with it at least.
const GAPS: usize = 16;
const ENOUGH: usize = 4;
/// A silence of the bus of more periods than this is a pause of the network, not a fault of the producer.
const PAUSE: i64 = 10;
/// Regular gaps in a row after which what was late is not caught up any more; twice as many where all SYNCs after it
/// are late as well.
const CALM: u8 = 2;
/// SYNCs beyond the period, each within this many SYNCs of the one before, that show a second producer.
const EXTRA: u8 = 3;
const EXTRA_WITHIN: u64 = 6;
/// Gaps out of 16 that are off the period by more than a sixth, before that is a finding: a loaded host is late now and
/// then.
const UNSTEADY: u32 = 8;
/// Gaps that a mean is taken of.
const MEANT: u64 = 8;
/// No producer is this fast, in ns: what comes faster was kept in a buffer.
const FASTEST_NS: i64 = 200_000;

/// Whether the producer may have restarted since the last SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restart {
    /// No.
    #[default]
    None,
    /// A node was stopped or reset of which it is not known whether it is the producer: most are not.
    Perhaps,
    /// Yes.
    Likely,
}

/// What gaps between SYNCs have turned out to be.
#[derive(Debug)]
pub enum Irregular {
    /// Something was wrong with the SYNC that began a cycle.
    Sync(u64, Verdict),
    /// The period is another one from a SYNC on: before and now, in ns, and that SYNC.
    Changed(i64, i64, FrameRef),
}

/// The time between two SYNCs.
#[derive(Clone, Copy, Debug)]
struct Gap {
    now: When,
    ns: i64,
    /// The cycle that its end began.
    cycle: u64,
    restart: Restart,
    /// The whole bus was silent for most of it.
    silent: bool,
    /// By how much the listings of the SYNCs before were put off at most, in ns, where a PDO shows it.
    spread_ns: Option<i64>,
}

/// The SYNCs of a bus.
#[derive(Debug, Default)]
pub struct SyncPeriod {
    cycle: u64,
    syncs: Vec<When>,
    period: Period,
    /// Gaps agree with the period, and are judged; those before, until then.
    regular: bool,
    early: Vec<Gap>,
    behind: Behind,
    second: Second,
    /// Which of the last gaps are far off the period, the last one in bit 0.
    unsteady: u16,
    calm_from: u64,
    /// A gap before the next one was judged: the SYNC between them was not late.
    phased: bool,
    /// How far SYNCs were off the period of late, but for what lasted, in ns.
    deviation_ns: i64,
}

/// A SYNC that was late, until those after it show what it was.
#[derive(Debug, Default)]
struct Behind {
    /// How far the last SYNC is behind the phase of those before the disturbance, in ns; below 0: ahead.
    off_ns: i64,
    /// The gap before the first SYNC that was late.
    late: Option<Gap>,
    /// The regular gaps in a row since then.
    calm: u8,
}

/// Signs of a second producer.
#[derive(Debug, Default)]
struct Second {
    /// SYNCs beyond the period, each soon after the one before, and the cycle of the last.
    extra: u8,
    cycle: u64,
    /// The gap before the last one, in ns.
    before_ns: i64,
    /// It was reported.
    two: bool,
}

impl SyncPeriod {
    /// Number of SYNCs seen.
    pub fn cycle(&self) -> u64 {
        self.cycle
    }

    /// The SYNC of a cycle, as far back as is remembered.
    pub fn sync(&self, cycle: u64) -> Option<When> {
        if cycle == 0 || cycle > self.cycle || self.cycle - cycle >= SYNCS as u64 {
            return None;
        }
        self.syncs.get((cycle - 1) as usize % SYNCS).copied()
    }

    /// The frame of the SYNC of a cycle.
    pub fn frame(&self, cycle: u64) -> Option<FrameRef> {
        self.sync(cycle).map(|sync| sync.at)
    }

    /// Time since the last SYNC.
    pub fn delay_ns(&self, at: FrameRef) -> Option<i64> {
        Some(at.t_ns?.saturating_sub(self.sync(self.cycle)?.at.t_ns?))
    }

    /// Whether the SYNC that is due has not come, half a period after its time.
    pub fn is_overdue(&self, at: FrameRef) -> bool {
        self.period_ns().zip(self.delay_ns(at)).is_some_and(|(period, gap)| gap > period + period / 2)
    }

    /// The period that traffic shows, where it is regular.
    pub fn period_ns(&self) -> Option<i64> {
        self.period.learnt_ns().filter(|_| self.regular)
    }

    /// The least and the most that the period may be, in ns: before it is known, of the gaps between the last SYNCs.
    pub fn scale_ns(&self, recording: &Recording) -> Option<(i64, i64)> {
        if let Some(period) = self.period_ns() {
            return Some((period, period));
        }
        let first = self.cycle.saturating_sub(GAPS as u64).max(1);
        let gap = |cycle: u64| recording.between(self.sync(cycle)?, self.sync(cycle + 1)?).filter(|ns| *ns > 0);
        let gaps = || (first..self.cycle).filter_map(gap);
        Some((gaps().min()?, gaps().max()?))
    }

    /// The first cycle that nothing disturbed.
    pub fn calm_from(&self) -> u64 {
        self.calm_from
    }

    /// What a verdict on times has to allow for: as given, or the larger of the stamps' resolution and the period's
    /// deviation. `None` before that is known.
    pub fn tolerance_ns(&self, recording: &Recording) -> Option<i64> {
        let measured = self.period_ns().map(|_| self.deviation_ns.max(recording.resolution_ns()));
        recording.stated_jitter_ns().or(measured)
    }

    /// The same as room for what a gap may differ from the period `period`.
    fn room_ns(&self, period: i64, recording: &Recording) -> i64 {
        self.tolerance_ns(recording).unwrap_or(0).max(recording.resolution_ns()).min(period)
    }

    /// Whether SYNCs come as of one producer for some time.
    pub fn is_single(&self) -> bool {
        self.regular && self.cycle > self.second.cycle + 2 * EXTRA_WITHIN
    }

    /// The mean of the last gaps in ns, and how far it may be off, where all of them were regular.
    pub fn mean_ns(&self, recording: &Recording) -> Option<(i64, i64)> {
        let first = self.calm_from.max(self.cycle.saturating_sub(GAPS as u64)).max(1);
        let count = self.cycle.checked_sub(first).filter(|count| *count >= MEANT)? as i64;
        if self.behind.late.is_some() || self.period.is_contested() {
            return None;
        }
        let (since, now) = (self.sync(first)?, self.sync(self.cycle)?);
        let uncertain = recording.resolution_ns().saturating_add(lag(now, recording));
        let mean = recording.between(since, now)? / count;
        // A pause is not in the period.
        let settled = |period: &i64| mean.abs_diff(*period) <= (period / 32).unsigned_abs();
        self.period_ns().filter(settled).map(|_| (mean, uncertain / count))
    }

    /// Frames were lost, or SYNC was moved: the next gap is not judged.
    pub fn broken(&mut self) {
        (self.behind, self.phased) = (Behind::default(), false);
        self.calm_from = self.cycle + 2;
    }

    /// The cycle that has begun, and the one before, are not judged.
    pub fn disturbed(&mut self) {
        self.calm_from = self.cycle + 1;
    }

    /// The period is another one by configuration: it is learnt again.
    pub fn forget(&mut self) {
        let (cycle, calm_from) = (self.cycle, self.calm_from);
        *self = Self { cycle, calm_from, syncs: std::mem::take(&mut self.syncs), ..Self::default() };
    }

    /// Takes a SYNC. `silent`: the bus was silent for most of the time since the one before; `spread_ns`: by how much
    /// the listings of those before were put off, where that shows.
    pub fn step(
        &mut self,
        now: When,
        (restart, silent, spread_ns): (Restart, bool, Option<i64>),
        recording: &Recording,
    ) -> Vec<Irregular> {
        let since = self.sync(self.cycle);
        match self.syncs.get_mut(self.cycle as usize % SYNCS) {
            Some(slot) => *slot = now,
            None => self.syncs.push(now),
        }
        self.cycle += 1;
        let mut out = Vec::new();
        if let Some(since) = since
            && let Some(ns) = recording.between(since, now)
        {
            if recording.teaches(since) && recording.teaches(now) {
                self.take(Gap { now, ns, cycle: self.cycle, restart, silent, spread_ns }, recording, &mut out);
            } else {
                (self.behind, self.phased) = (Behind::default(), false);
                self.calm_from = self.calm_from.max(self.cycle + 1);
            }
        }
        out
    }

    /// The capture is over: what was late, where that is certain without the SYNCs that would follow.
    pub fn finish(&mut self, now: FrameRef, recording: &Recording) -> Option<Irregular> {
        let period = self.period_ns()?;
        let silent = self.delay_ns(now).is_some_and(|delay| delay > period);
        let (whole, off) = self.whole(period);
        let in_phase = whole > 0 && off <= period / 50;
        if self.behind.calm > 0 || silent || in_phase { self.lateness(period, recording) } else { None }
    }

    fn take(&mut self, gap: Gap, recording: &Recording, out: &mut Vec<Irregular>) {
        if let Some(period) = self.period_ns() {
            return self.judge(gap, period, true, recording, out);
        }
        if gap.ns < FASTEST_NS {
            return;
        }
        if self.early.len() == GAPS {
            self.early.remove(0);
        }
        self.early.push(gap);
        let _ = self.period.take(gap.ns, recording.resolution_ns(), gap.now.at);
        // Gaps are whole units of coarse stamps then, whatever the period.
        let resolution = recording.resolution_ns();
        let Some(period) = self.period.learnt_ns().filter(|period| *period > resolution) else { return };
        let agreeing = self.early.iter().filter(|gap| close(gap.ns, period)).count();
        // Listed late now and then, gaps differ and make up for each other: then a few show no period.
        let uneven =
            self.early.iter().any(|gap| close(gap.ns, period) && gap.ns.abs_diff(period) > period.unsigned_abs() / 16);
        let enough = if uneven { GAPS * 3 / 4 } else { ENOUGH };
        if agreeing >= enough && agreeing * 4 >= self.early.len() * 3 {
            if uneven {
                // Only the mean of many is a period then.
                let sum: i64 = self.early.iter().filter(|gap| close(gap.ns, period)).map(|gap| gap.ns).sum();
                let mean = sum / agreeing.max(1) as i64;
                self.period.forget();
                for _ in 0..agreeing {
                    let _ = self.period.take(mean, recording.resolution_ns(), gap.now.at);
                }
            }
            let Some(period) = self.period.learnt_ns() else { return };
            self.regular = true;
            // What the first gaps were is known only now.
            for gap in std::mem::take(&mut self.early) {
                self.judge(gap, period, false, recording, out);
            }
        }
    }

    /// `new`: the period has not taken the gap yet.
    fn judge(&mut self, gap: Gap, period: i64, new: bool, recording: &Recording, out: &mut Vec<Irregular>) {
        let resolution = recording.resolution_ns();
        if period <= resolution {
            // It was learnt before the stamps showed how coarse they are.
            return self.forget();
        }
        let before_ns = std::mem::replace(&mut self.second.before_ns, gap.ns);
        let room = self.room_ns(period, recording);
        if is_pause(gap, period) {
            out.extend(self.lateness(period, recording));
            self.calm_from = gap.cycle + 1;
            if new {
                // The period may be another one after it.
                self.forget();
            }
            return;
        }
        if new
            && !self.second.two
            && let Learnt::Changed { from_ns, to_ns, since } =
                self.period.take(gap.ns, (room / 2).min(period / 16), gap.now.at)
        {
            self.behind = Behind::default();
            (self.second.extra, self.unsteady, self.calm_from) = (0, 0, gap.cycle);
            out.push(Irregular::Changed(from_ns, to_ns, since));
            return;
        }
        self.judge_steadiness(gap, period, recording, out);
        if self.behind.late.is_none() {
            // The period is not exact: what is off only by that must not add up.
            self.behind.off_ns -= self.behind.off_ns / 4;
            if gap.ns > period + period / 2 {
                self.behind.late = Some(gap);
            }
        }
        self.behind.off_ns = self.behind.off_ns.saturating_add(gap.ns - period);
        if !std::mem::replace(&mut self.phased, true) && gap.ns < period {
            self.behind.off_ns = 0;
        }
        if !close(gap.ns, period) {
            self.calm_from = self.calm_from.max(gap.cycle);
        }
        if gap.ns.saturating_add(resolution) < period / 4 * 3 && self.behind.off_ns < -(period / 2 + room) {
            return self.one_too_many(gap, before_ns, period, recording, out);
        }
        if gap.cycle > self.second.cycle + 2 * EXTRA_WITHIN && std::mem::take(&mut self.second.two) {
            self.behind = Behind::default();
        }
        self.settle(gap, period, recording, out);
        // What the next gap makes up for is a deviation; what it does not is another phase, or another period.
        let (off, before) = (gap.ns - period, before_ns - period);
        if gap.ns >= period / 2 && gap.ns <= period + period / 2 {
            let made_up = if (off >= 0) == (before >= 0) { 0 } else { off.abs().min(before.abs()) };
            self.deviation_ns = made_up.max(self.deviation_ns - self.deviation_ns / 64);
        }
    }

    /// Whether enough SYNCs have come in one phase to tell what the one that was late has been.
    fn settle(&mut self, gap: Gap, period: i64, recording: &Recording, out: &mut Vec<Irregular>) {
        let explainable = self.behind.off_ns <= lag(gap.now, recording);
        let exact = if explainable { period / 16 + recording.resolution_ns() } else { period / 4 };
        let calm = gap.ns.abs_diff(period) <= exact.unsigned_abs();
        self.behind.calm = if calm { self.behind.calm.saturating_add(1) } else { 0 };
        let moved = self.behind.late.is_some() && self.whole(period).1 > period / 4;
        if self.behind.calm >= if moved { 2 * CALM } else { CALM } {
            out.extend(self.lateness(period, recording));
        }
    }

    /// By how many whole periods SYNC is behind, and how far it is off that, in ns.
    fn whole(&self, period: i64) -> (i64, i64) {
        let whole = self.behind.off_ns.saturating_add(period / 2).div_euclid(period.max(1));
        (whole, self.behind.off_ns.saturating_sub(whole.saturating_mul(period)).saturating_abs())
    }

    fn judge_steadiness(&mut self, gap: Gap, period: i64, recording: &Recording, out: &mut Vec<Irregular>) {
        let off_ns = (gap.ns - period).abs();
        let put_off = lag(gap.now, recording).min(gap.spread_ns.unwrap_or(i64::MAX));
        let far = off_ns > (period / 6).saturating_add(put_off) && off_ns < period / 4 * 3;
        self.unsteady = self.unsteady << 1 | u16::from(far);
        if far && !self.second.two && self.unsteady.count_ones() == UNSTEADY && self.unsteady >> 1 & 1 == 1 {
            out.push(Irregular::Sync(gap.cycle, Syn003::Unsteady { jitter: off_ns, period }.into()));
        }
    }

    fn one_too_many(
        &mut self,
        Gap { ns: gap, cycle, .. }: Gap,
        before_ns: i64,
        period: i64,
        recording: &Recording,
        out: &mut Vec<Irregular>,
    ) {
        self.behind.off_ns = self.behind.off_ns.saturating_add(period);
        self.behind.calm = 0;
        let again = cycle <= self.second.cycle + EXTRA_WITHIN;
        self.second.extra = if again { self.second.extra.saturating_add(1) } else { 1 };
        self.second.cycle = cycle;
        let (short, long) = (gap.min(before_ns), gap.max(before_ns));
        // Even gaps are another period, not two producers.
        if self.second.extra < EXTRA || long - short <= period / 16 {
            let tolerance = self.tolerance_ns(recording).unwrap_or(0);
            out.push(Irregular::Sync(cycle, Syn003::Early { gap, period, tolerance }.into()));
        } else if !std::mem::replace(&mut self.second.two, true) {
            out.push(Irregular::Sync(cycle, Syn006::Interleaved { short, long, period }.into()));
        }
    }

    /// What the SYNC that was late has turned out to be, now that others came in the same phase.
    fn lateness(&mut self, period: i64, recording: &Recording) -> Option<Irregular> {
        let (missing, from_whole) = self.whole(period);
        let Behind { off_ns, late, .. } = std::mem::take(&mut self.behind);
        let Gap { ns: gap, cycle, now, .. } = late?;
        let room = self.room_ns(period, recording);
        let tolerance = self.tolerance_ns(recording).unwrap_or(0);
        let explainable = off_ns <= lag(now, recording);
        let exact = if explainable { period / 16 } else { period / 4 };
        let what = if missing > 0 && from_whole <= exact && recording.resolution_ns() < period {
            let most = gap.saturating_add(period / 2) / period.max(1) - 1;
            let missing = missing.min(most).max(1).unsigned_abs();
            Syn003::Missing { gap, period, tolerance, missing }.into()
        } else if off_ns > period / 2 + room && (!explainable || room <= period / 8) {
            Syn003::Late { gap, period, tolerance, missing: 1 }.into()
        } else {
            Syn012::Late { gap, period }.into()
        };
        Some(Irregular::Sync(cycle, what))
    }
}

/// Whether the producer was stopped, or the whole network stood still.
fn is_pause(gap: Gap, period: i64) -> bool {
    if gap.ns / PAUSE > period && gap.silent {
        return true;
    }
    let exact = match gap.restart {
        Restart::None => return false,
        // SYNCs that are missing in the old phase are no restart of the producer.
        Restart::Perhaps => period / 64,
        Restart::Likely => -1,
    };
    let off = gap.ns.saturating_add(period / 2) % period.max(1) - period / 2;
    gap.ns > period && !close(gap.ns, period) && off.abs() > exact
}

/// How late a frame may be listed, in ns.
fn lag(when: When, recording: &Recording) -> i64 {
    if when.own { recording.lag_ns() } else { 0 }
}

/// Within a quarter.
fn close(gap: i64, period: i64) -> bool {
    gap.abs_diff(period) <= period.unsigned_abs() / 4
}
