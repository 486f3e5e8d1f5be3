//! The period of SYNC: count of SYNCs, regularity, and explanation of irregular gaps.
//!
//! A gap is judged by the phase: a SYNC only listed late is followed by one at the old time; a missing one moves
//! nothing after it. The verdict therefore waits for the next SYNCs. Gaps at the ends of a recorder's burst are not
//! judged. `sync` reports the results.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::period::{Learnt, Period};
use crate::evidence::recording::{FRAME_NS, PAUSE_NS, Recording};
use crate::evidence::when::When;
use crate::rules::finding::Verdict;
use crate::rules::sync::{Syn003, Syn006, Syn012};

/// Number of SYNCs kept: the longest cycle of a synchronous PDO (transmission type 240) and more.
const SYNCS: usize = 256;
/// Maximum number of gaps that wait for the period, and minimum number that agree with it.
const GAPS: usize = 16;
const ENOUGH: usize = 4;
/// Number of periods of silence on the bus that are a pause of the network, not a fault of the producer.
const PAUSE: i64 = 10;
/// Number of regular gaps in a row after which a delay is permanent; twice that if all later SYNCs are late as well.
const CALM: u8 = 2;
/// Number of additional SYNCs, each within this many SYNCs of the one before, that show a second producer.
const EXTRA: u8 = 3;
const EXTRA_WITHIN: u64 = 6;
/// Number of gaps out of 16 that deviate by more than a part of the period before it is a finding; a loaded host is late
/// now and then. Each way, this many of them: gaps that are all longer are another period.
const UNSTEADY: u32 = 8;
const UNSTEADY_PART: i64 = 10;
const EACH_WAY: u32 = 2;
/// The most that the deviation of the first gaps adds to that part.
const UNSTEADY_USUAL_PART: i64 = 15;
/// Uncertainty of the period across a stall of the recorder, as a part of its length.
const ACROSS_PART: i64 = 64;
/// Part of a gap's deviation that is added to the mean of the deviations.
const JITTER_PART: i64 = 16;
/// Minimum number of gaps in a mean.
const MEANT: u64 = 8;
/// Minimum difference of gaps that alternate from the beginning, as a part of their sum, and maximum spread of either, as
/// a part of that difference, by which two producers show. A single one that keeps its period by a coarse tick has gaps in
/// the ratio of one to two, up to this part; those from a buffer that is read now and then are far apart in length.
const ALTERNATE_PART: i64 = 4;
const STEADY_PART: i64 = 4;
const TICK_PART: i64 = 50;
const BUFFERED: i64 = 12;
/// The shortest period of a producer, in ns; shorter gaps come from a buffer.
const FASTEST_NS: Ns = Ns::from_us(200);

/// The possibility of a restart of the producer since the last SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restart {
    /// No restart.
    #[default]
    None,
    /// A node was stopped or reset that may be the producer; most are not.
    Perhaps,
    /// Likely restart.
    Likely,
}

/// The explanation of gaps between SYNCs.
#[derive(Debug)]
pub enum Irregular {
    /// A fault of the SYNC that began a cycle.
    Sync(u64, Verdict),
    /// The same, and later ones follow from it until SYNCs are steady again.
    Unsteady(u64, Verdict),
    /// A change of period: before and after in ns, and the first SYNC of the new one.
    Changed(Ns, Ns, FrameRef),
}

/// The time between two SYNCs.
#[derive(Clone, Copy, Debug)]
struct Gap {
    now: When,
    ns: Ns,
    /// The cycle that it precedes.
    cycle: u64,
    restart: Restart,
    /// The whole bus was silent for most of it, and others were due then, or for so long that the network paused.
    paused: bool,
    /// The whole bus was silent for most of it.
    silent: bool,
    /// The maximum difference between listing delays of earlier SYNCs, in ns, if a PDO shows it.
    spread_ns: Option<Ns>,
}

/// The SYNCs of a bus.
#[derive(Debug, Default)]
pub struct SyncPeriod {
    cycle: u64,
    syncs: Vec<When>,
    period: Period,
    /// Gaps agree with the period and are judged; earlier ones wait.
    regular: bool,
    early: Vec<Gap>,
    behind: LateSync,
    second: Second,
    unsteady: Unsteady,
    /// The period before the last change of it, in ns.
    former_ns: Option<Ns>,
    /// Mean deviation of the recent gaps, in ns.
    jitter_ns: Ns,
    /// The last SYNC before a stall of the recorder, its cycle, and the possibility of a restart since.
    across: Option<(When, u64, Restart)>,
    /// The maximum difference between the listing delays of the last SYNCs, in ns, if a PDO shows it.
    spread_ns: Option<Ns>,
    calm_from: u64,
    /// A gap was judged before the next one: the SYNC between them was not late.
    phased: bool,
    /// Recent deviation of SYNCs from the period, without lasting shifts, in ns.
    deviation_ns: Ns,
    /// The counters of the SYNCs so far show one producer.
    pub counted: bool,
}

/// A late SYNC, until later ones explain it.
#[derive(Debug, Default)]
struct LateSync {
    /// Delay of the last SYNC against the phase before the disturbance, in ns; negative if ahead.
    off_ns: Ns,
    /// The gap before the first late SYNC.
    late: Option<Gap>,
    /// Number of regular gaps in a row since then.
    calm: u8,
}

/// The last gaps that are much longer or shorter than the period, the latest in bit 0.
#[derive(Debug, Default)]
struct Unsteady {
    long: u16,
    short: u16,
    /// It was reported, and there have been such gaps since.
    reported: bool,
    /// The deviation of the first gaps, in ns: the recording may show SYNC so from the beginning.
    usual_ns: Ns,
}

/// Signs of a second producer.
#[derive(Debug, Default)]
struct Second {
    /// Number of additional SYNCs close together, and the cycle of the last.
    extra: u8,
    cycle: u64,
    /// The gap before the last one, in ns.
    before_ns: Ns,
    /// It was reported.
    two: bool,
}

impl SyncPeriod {
    /// Returns the number of SYNCs seen.
    pub fn cycle(&self) -> u64 {
        self.cycle
    }

    /// Returns the SYNC of a cycle if it is kept.
    pub fn sync(&self, cycle: u64) -> Option<When> {
        if cycle == 0 || cycle > self.cycle || self.cycle - cycle >= SYNCS as u64 {
            return None;
        }
        self.syncs.get((cycle - 1) as usize % SYNCS).copied()
    }

    /// Returns the frame of the SYNC of a cycle.
    pub fn frame(&self, cycle: u64) -> Option<FrameRef> {
        self.sync(cycle).map(|sync| sync.at)
    }

    /// Returns the time since the last SYNC, in ns.
    pub fn delay_ns(&self, at: FrameRef) -> Option<Ns> {
        Some(at.t_ns? - self.sync(self.cycle)?.at.t_ns?)
    }

    /// Returns true if the next SYNC is overdue by half a period.
    pub fn is_overdue(&self, at: FrameRef) -> bool {
        self.period_ns().zip(self.delay_ns(at)).is_some_and(|(period, gap)| gap > period + period / 2)
    }

    /// Returns the measured period if it is regular, in ns.
    pub fn period_ns(&self) -> Option<Ns> {
        self.period.learnt_ns().filter(|_| self.regular)
    }

    /// Returns the minimum and maximum of the period in ns, by the last gaps while it is unknown.
    pub fn scale_ns(&self, recording: &Recording) -> Option<(Ns, Ns)> {
        if let Some(period) = self.period_ns() {
            return Some((period, period));
        }
        let first = self.cycle.saturating_sub(GAPS as u64).max(1);
        let gap = |cycle: u64| recording.between(self.sync(cycle)?, self.sync(cycle + 1)?).filter(|ns| *ns > Ns::ZERO);
        let gaps = || (first..self.cycle).filter_map(gap);
        Some((gaps().min()?, gaps().max()?))
    }

    /// Returns the first undisturbed cycle.
    pub fn calm_from(&self) -> u64 {
        self.calm_from
    }

    /// Returns the tolerance of times: as given, or the larger of the stamps' resolution and the period's deviation.
    /// `None` before that is known.
    pub fn tolerance_ns(&self, recording: &Recording) -> Option<Ns> {
        let measured = self.period_ns().map(|_| self.deviation_ns.max(recording.resolution_ns()));
        recording.stated_jitter_ns().or(measured)
    }

    /// Returns the same as the allowance for a gap against `period`.
    fn room_ns(&self, period: Ns, recording: &Recording) -> Ns {
        self.tolerance_ns(recording).unwrap_or(Ns::ZERO).max(recording.resolution_ns()).min(period)
    }

    /// Returns true if SYNCs have come from one producer for some time.
    pub fn is_single(&self) -> bool {
        self.regular && self.cycle > self.second.cycle + 2 * EXTRA_WITHIN
    }

    /// Returns the mean of the last gaps and its maximum error in ns, if all of them were regular.
    pub fn mean_ns(&self, recording: &Recording) -> Option<(Ns, Ns)> {
        let first = self.calm_from.max(self.cycle.saturating_sub(GAPS as u64)).max(1);
        let count = self.cycle.checked_sub(first).filter(|count| *count >= MEANT)? as i64;
        if self.behind.late.is_some() || self.period.is_contested() || self.unsteady.long | self.unsteady.short != 0 {
            return None;
        }
        let (since, now) = (self.sync(first)?, self.sync(self.cycle)?);
        let uncertain = recording.resolution_ns() + lag(now, recording);
        let mean = recording.between(since, now)? / count;
        // A pause does not belong to the period.
        let settled = |period: &Ns| mean.abs_diff(*period) <= (*period / 32).abs();
        self.period_ns().filter(settled).map(|_| (mean, uncertain / count))
    }

    /// Returns true if SYNCs were reported as unsteady and still are.
    pub fn is_unsteady(&self) -> bool {
        self.unsteady.reported
    }

    /// Skips the next gap, because frames were lost or SYNC was moved.
    pub fn broken(&mut self) {
        (self.behind, self.phased, self.across) = (LateSync::default(), false, None);
        self.calm_from = self.cycle + 2;
    }

    /// Excludes the current cycle and the one before from verdicts.
    pub fn disturbed(&mut self) {
        self.calm_from = self.cycle + 1;
    }

    /// Forgets the period after a change of configuration.
    pub fn forget(&mut self) {
        // The gap that runs meanwhile has neither of the periods.
        let (cycle, calm_from) = (self.cycle, self.calm_from.max(self.cycle + 1));
        *self = Self { cycle, calm_from, syncs: std::mem::take(&mut self.syncs), ..Self::default() };
    }

    /// Takes a SYNC. `silent`: the bus was silent for most of the time since the last one. `spread_ns`: difference
    /// between the listing delays of earlier ones, if known.
    pub fn step(
        &mut self,
        now: When,
        (restart, silent, spread_ns): (Restart, bool, Option<Ns>),
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
            let last = now.at.t_ns.filter(|_| silent).and_then(|now_ns| recording.silence(now_ns));
            let others = last.is_some_and(|last| last.others && since.at.t_ns.is_some_and(|ns| last.to_ns > ns));
            let paused = silent && (others || ns >= PAUSE_NS);
            let gap = Gap { now, ns, cycle: self.cycle, restart, paused, silent, spread_ns };
            self.spread_ns = spread_ns;
            if recording.teaches(since) && recording.teaches(now) {
                self.take(gap, recording, &mut out);
            } else {
                out.extend(self.stalled(since, gap, recording));
                (self.behind, self.phased) = (LateSync::default(), false);
                self.calm_from = self.calm_from.max(self.cycle + 1);
            }
        }
        out
    }

    /// Takes a gap at an end of a stall of the recorder, which delivers the SYNCs that were due and keeps their phase;
    /// returns a fault if it does not.
    fn stalled(&mut self, since: When, gap: Gap, recording: &Recording) -> Option<Irregular> {
        if recording.teaches(since) {
            self.across = Some((since, gap.cycle - 1, gap.restart)).filter(|_| !gap.paused);
            return None;
        }
        let (before, cycle, restart) = self.across?;
        self.across = Some((before, cycle, restart.max(gap.restart))).filter(|_| !gap.paused);
        if gap.paused || !recording.teaches(gap.now) {
            return None;
        }
        self.across = None;
        let (period, lasts) = (self.period_ns()?, recording.between(before, gap.now)?);
        let passed = i64::try_from(gap.cycle - cycle).ok()?;
        let off_ns = lasts - period * passed;
        let room = self.room_ns(period, recording) + lasts / ACROSS_PART;
        let uncertain = room + put_off(gap.now, gap.spread_ns, recording);
        if restart.max(gap.restart) != Restart::None || off_ns <= (period / 2) + uncertain {
            return None;
        }
        let first = recording.between(before, self.sync(cycle + 1)?)?;
        let missing = ((off_ns + period / 2) / period).max(1).unsigned_abs();
        let tolerance = self.tolerance_ns(recording).unwrap_or(Ns::ZERO);
        Some(Irregular::Sync(cycle + 1, Syn003::Missing { gap: first, period, tolerance, missing }.into()))
    }

    /// Returns a late SYNC at the end of the capture if it is certain without later ones.
    pub fn finish(&mut self, now: FrameRef, recording: &Recording) -> Option<Irregular> {
        let period = self.period_ns()?;
        let silent = self.delay_ns(now).is_some_and(|delay| delay > period);
        let (whole, off) = self.whole(period);
        let in_phase = whole > 0 && off <= period / 50;
        if self.behind.calm > 0 || silent || in_phase { self.lateness(period, recording) } else { None }
    }

    fn take(&mut self, gap: Gap, recording: &Recording, out: &mut Vec<Irregular>) {
        // A single additional SYNC counts if a bus can carry it.
        if gap.ns < if self.regular { FRAME_NS } else { FASTEST_NS } {
            return;
        }
        if let Some(period) = self.period_ns() {
            return self.judge(gap, period, true, recording, out);
        }
        if self.early.len() == GAPS {
            self.early.remove(0);
        }
        self.early.push(gap);
        if let Some((short, long)) = self.alternate().filter(|_| !self.second.two) {
            (self.second.two, self.second.cycle) = (true, gap.cycle);
            let (jitter, period) = ((long - short) / 2, (long + short) / 2);
            out.push(match self.counted {
                true => Irregular::Unsteady(gap.cycle, Syn003::Unsteady { jitter, period }.into()),
                false => Irregular::Sync(gap.cycle, Syn006::Interleaved { short, long, period: short + long }.into()),
            });
        }
        let _ = self.period.take(gap.ns, recording.resolution_ns(), gap.now.at);
        // With coarse stamps gaps are multiples of their unit, whatever the period.
        let resolution = recording.resolution_ns();
        let Some(period) = self.period.learnt_ns().filter(|period| *period > resolution) else { return };
        let agreeing = self.early.iter().filter(|gap| close(gap.ns, period)).count();
        // Occasional listing delays make gaps differ and compensate; then a few show no period.
        let uneven = self.early.iter().any(|gap| close(gap.ns, period) && gap.ns.abs_diff(period) > period.abs() / 16);
        let enough = if uneven { GAPS * 3 / 4 } else { ENOUGH };
        if agreeing >= enough && agreeing * 4 >= self.early.len() * 3 {
            if uneven {
                // Then only the mean of many is a period.
                let sum: Ns = self.early.iter().filter(|gap| close(gap.ns, period)).map(|gap| gap.ns).sum();
                let mean = sum / agreeing.max(1) as i64;
                self.period.forget();
                for _ in 0..agreeing {
                    let _ = self.period.take(mean, recording.resolution_ns(), gap.now.at);
                }
            }
            let Some(period) = self.period.learnt_ns() else { return };
            self.regular = true;
            let off = |gap: &Gap| (gap.ns - period).abs();
            let usual = self.early.iter().filter(|gap| close(gap.ns, period)).map(off).max();
            self.unsteady.usual_ns = usual.unwrap_or(Ns::ZERO).min(period / UNSTEADY_USUAL_PART);
            // The first gaps can be judged only now.
            for gap in std::mem::take(&mut self.early) {
                self.judge(gap, period, false, recording, out);
            }
        }
    }

    /// Returns the means of gaps that alternate between a short and a long one, in ns, while no period is known.
    fn alternate(&self) -> Option<(Ns, Ns)> {
        let disturbed = |gap: &Gap| gap.paused || gap.restart != Restart::None;
        if self.early.len() < GAPS || self.early.iter().any(disturbed) {
            return None;
        }
        let half = |skipped: usize| {
            let gaps = || self.early.iter().skip(skipped).step_by(2).map(|gap| gap.ns);
            let spread = gaps().max()? - gaps().min()?;
            Some((gaps().sum::<Ns>() / (GAPS / 2) as i64, spread))
        };
        let ((one, spread), (two, other)) = half(0).zip(half(1))?;
        let (short, long, apart) = (one.min(two), one.max(two), (one - two).abs());
        let tick = (long - short * 2).abs() <= long / TICK_PART;
        let steady = spread.max(other) <= apart / STEADY_PART;
        let buffered = short < long / BUFFERED;
        (apart > (short + long) / ALTERNATE_PART && steady && !tick && !buffered).then_some((short, long))
    }

    /// `new`: the gap has not been added to the period yet.
    fn judge(&mut self, gap: Gap, period: Ns, new: bool, recording: &Recording, out: &mut Vec<Irregular>) {
        let resolution = recording.resolution_ns();
        if period <= resolution {
            // It was learnt before the stamps showed their resolution.
            return self.forget();
        }
        let before_ns = std::mem::replace(&mut self.second.before_ns, gap.ns);
        let room = self.room_ns(period, recording);
        if is_pause(gap, period) {
            out.extend(self.lateness(period, recording));
            self.calm_from = gap.cycle + 1;
            if new {
                // The period may differ after it.
                self.forget();
            }
            return;
        }
        let agreed_ns = (room / 2).min(period / 16);
        let off_ns = (gap.ns - period).abs();
        self.jitter_ns += (off_ns - self.jitter_ns) / JITTER_PART;
        if new
            && !self.second.two
            && let Learnt::Changed { from_ns, to_ns, since } = self.period.take(gap.ns, agreed_ns, gap.now.at)
        {
            // A bus that was silent for long and goes on at another period was set up anew.
            let anew = self.behind.late.is_some_and(|late| late.silent && late.ns / PAUSE > period);
            self.behind = LateSync::default();
            (self.second.extra, self.calm_from, self.former_ns) = (0, gap.cycle, Some(from_ns));
            (self.unsteady.long, self.unsteady.short) = (0, 0);
            // Gaps that agree only roughly, or are uneven all the time, may have another mean by chance.
            let least_ns = self.jitter_ns.max(2 * agreed_ns);
            if !anew && (from_ns - to_ns).abs() > least_ns {
                out.push(Irregular::Changed(from_ns, to_ns, since));
            }
            return;
        }
        let back = |former: Ns| gap.ns.abs_diff(former) <= former.abs() / 16 && !close(gap.ns, period);
        if self.former_ns.is_some_and(back) && self.period.is_contested() {
            // The period is about to change back.
            (self.behind, self.calm_from) = (LateSync::default(), gap.cycle);
            return;
        }
        self.judge_steadiness(gap, period, recording, out);
        if self.behind.late.is_none() {
            // The period is inexact; its error must not add up.
            self.behind.off_ns -= self.behind.off_ns / 4;
            if gap.ns > period + period / 2 {
                self.behind.late = Some(gap);
            }
        }
        self.behind.off_ns += gap.ns - period;
        if !std::mem::replace(&mut self.phased, true) && gap.ns < period {
            self.behind.off_ns = Ns::ZERO;
        }
        if !close(gap.ns, period) {
            self.calm_from = self.calm_from.max(gap.cycle);
        }
        if gap.ns + resolution < period / 4 * 3 && self.behind.off_ns < -(period / 2 + room) {
            return self.one_too_many(gap, before_ns, period, recording, out);
        }
        if gap.cycle > self.second.cycle + 2 * EXTRA_WITHIN && std::mem::take(&mut self.second.two) {
            self.behind = LateSync::default();
        }
        self.settle(gap, period, recording, out);
        // A deviation is compensated by the next gap; otherwise it is another phase or period.
        let (off, before) = (gap.ns - period, before_ns - period);
        if gap.ns >= period / 2 && gap.ns <= period + period / 2 {
            let made_up =
                if (off >= Ns::ZERO) == (before >= Ns::ZERO) { Ns::ZERO } else { off.abs().min(before.abs()) };
            self.deviation_ns = made_up.max(self.deviation_ns - self.deviation_ns / 64);
        }
    }

    /// Explains a late SYNC once enough SYNCs have come in one phase.
    fn settle(&mut self, gap: Gap, period: Ns, recording: &Recording, out: &mut Vec<Irregular>) {
        let explainable = self.behind.off_ns <= put_off(gap.now, gap.spread_ns, recording);
        let exact = if explainable { period / 16 + recording.resolution_ns() } else { period / 4 };
        let calm = gap.ns.abs_diff(period) <= exact.abs();
        self.behind.calm = if calm { self.behind.calm.saturating_add(1) } else { 0 };
        let moved = self.behind.late.is_some() && self.whole(period).1 > period / 4;
        if self.behind.calm >= if moved { 2 * CALM } else { CALM } {
            out.extend(self.lateness(period, recording));
        }
    }

    /// Returns the delay of SYNC in whole periods, and the remaining deviation in ns.
    fn whole(&self, period: Ns) -> (i64, Ns) {
        let whole = (self.behind.off_ns + period / 2).as_ns().div_euclid(period.max(Ns(1)).as_ns());
        (whole, (self.behind.off_ns - whole * period).abs())
    }

    fn judge_steadiness(&mut self, gap: Gap, period: Ns, recording: &Recording, out: &mut Vec<Irregular>) {
        let off_ns = (gap.ns - period).abs();
        let uncertain = put_off(gap.now, gap.spread_ns, recording) + recording.resolution_ns();
        let uncertain = uncertain + self.unsteady.usual_ns;
        let far = off_ns > (period / UNSTEADY_PART) + uncertain && off_ns < period / 4 * 3;
        let Unsteady { long, short, reported, .. } = &mut self.unsteady;
        *long = *long << 1 | u16::from(far && gap.ns > period);
        *short = *short << 1 | u16::from(far && gap.ns < period);
        let (longer, shorter) = (long.count_ones(), short.count_ones());
        *reported &= longer + shorter > 0;
        if far && !self.second.two && longer.min(shorter) >= EACH_WAY && longer + shorter >= UNSTEADY && !*reported {
            *reported = true;
            out.push(Irregular::Unsteady(gap.cycle, Syn003::Unsteady { jitter: off_ns, period }.into()));
        }
    }

    fn one_too_many(
        &mut self,
        Gap { ns: gap, cycle, .. }: Gap,
        before_ns: Ns,
        period: Ns,
        recording: &Recording,
        out: &mut Vec<Irregular>,
    ) {
        self.behind.off_ns += period;
        self.behind.calm = 0;
        let again = cycle <= self.second.cycle + EXTRA_WITHIN;
        self.second.extra = if again { self.second.extra.saturating_add(1) } else { 1 };
        self.second.cycle = cycle;
        let (short, long) = (gap.min(before_ns), gap.max(before_ns));
        // Even gaps are another period, not two producers; and where one was unsteady before, any gap may be short.
        if self.second.extra < EXTRA || long - short <= period / 16 || self.unsteady.reported {
            let tolerance = self.tolerance_ns(recording).unwrap_or(Ns::ZERO);
            out.push(Irregular::Sync(cycle, Syn003::Early { gap, period, tolerance }.into()));
        } else if !std::mem::replace(&mut self.second.two, true) {
            out.push(Irregular::Sync(cycle, Syn006::Interleaved { short, long, period }.into()));
        }
    }

    /// Returns the explanation of a late SYNC after others have come in the same phase.
    fn lateness(&mut self, period: Ns, recording: &Recording) -> Option<Irregular> {
        let (missing, from_whole) = self.whole(period);
        let LateSync { off_ns, late, .. } = std::mem::take(&mut self.behind);
        let Gap { ns: gap, cycle, now, .. } = late?;
        let room = self.room_ns(period, recording);
        let tolerance = self.tolerance_ns(recording).unwrap_or(Ns::ZERO);
        let put_off = put_off(now, self.spread_ns, recording);
        let explainable = off_ns <= put_off;
        // A frame between its due time and the silence before it shows that the recorder did not delay it.
        let alone_ns = (gap - period) - now.silent_ns;
        let exact = if explainable { period / 16 } else { period / 4 };
        let what = if missing > 0 && from_whole <= exact && recording.resolution_ns() < period {
            let most = (gap + period / 2) / period.max(Ns(1)) - 1;
            let missing = missing.min(most).max(1).unsigned_abs();
            Syn003::Missing { gap, period, tolerance, missing }.into()
        } else if off_ns > period / 2 + room && (!explainable || room <= period / 8)
            || gap - period > period / 2 + room && alone_ns > room && gap - period > put_off
        {
            Syn003::Late { gap, period, tolerance, missing: 1 }.into()
        } else {
            Syn012::Late { gap, period }.into()
        };
        Some(Irregular::Sync(cycle, what))
    }
}

/// Returns true if the producer was stopped, or the whole network paused.
fn is_pause(gap: Gap, period: Ns) -> bool {
    if gap.ns / PAUSE > period && gap.paused {
        return true;
    }
    let exact = match gap.restart {
        Restart::None => return false,
        // SYNCs missing in the old phase are no restart of the producer.
        Restart::Perhaps => period / 64,
        Restart::Likely => Ns(-1),
    };
    let off = (gap.ns + period / 2) % period.max(Ns(1)) - period / 2;
    gap.ns > period && !close(gap.ns, period) && off.abs() > exact
}

/// Returns the maximum listing delay of a frame, in ns.
fn lag(when: When, recording: &Recording) -> Ns {
    if when.own { recording.lag_ns() } else { Ns::ZERO }
}

/// Returns the same as far as a PDO that follows SYNC shows it.
fn put_off(when: When, spread_ns: Option<Ns>, recording: &Recording) -> Ns {
    lag(when, recording).min(spread_ns.unwrap_or(Ns::MAX))
}

/// Returns true if a gap is within a quarter of the period.
fn close(gap: Ns, period: Ns) -> bool {
    gap.abs_diff(period) <= period.abs() / 4
}
