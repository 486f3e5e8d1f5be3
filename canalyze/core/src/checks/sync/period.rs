//! The period of SYNC: its SYNCs counted, how regularly they come, and what an irregular gap was.
//!
//! A gap is judged against the phase: a SYNC that was only listed late is followed by one at the old time, a missing
//! one moves nothing after it. The judgement therefore waits for the SYNCs that follow. Gaps that a burst of the
//! recording begins or ends are not judged. It raises nothing: `sync` reports what a gap was.

use std::collections::VecDeque;

use super::jitter::Spread;
use crate::evidence::period::{Learnt, Period};
use crate::evidence::recording::Recording;
use crate::evidence::when::When;
use crate::frame::FrameRef;

/// SYNCs remembered: as many as the longest cycle of a synchronous PDO (transmission type 240).
const SYNCS: usize = 256;
/// Gaps that are looked back on, and how many of them must agree, at least and in quarters, before gaps are judged.
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
/// Gaps out of [`GAPS`] that are off the period by more than a sixth, before that is a finding: a loaded host is late now
/// and then.
const UNSTEADY: u32 = 11;
/// Regular gaps in a row that a mean is taken of.
const MEANT: u32 = 8;
/// No producer is this fast, in ns.
const FASTEST_NS: i64 = 200_000;

/// Whether the producer may have restarted since the last SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restart {
    /// No.
    #[default]
    None,
    /// A node was stopped of which it is not known whether it is the producer: that would not have gone on.
    Hardly,
    /// A node was reset of which it is not known whether it is the producer: most are not.
    Perhaps,
    /// All nodes were sent to Pre-operational, where a master may stop SYNC for longer to configure them.
    Configuring,
    /// Yes.
    Likely,
}

/// What a gap between SYNCs was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Irregular {
    /// SYNCs are missing before the one that began a cycle; 0: it and all after it were late.
    Late {
        /// Time since the one before, in ns.
        gap_ns: i64,
        /// The cycle that it began.
        cycle: u64,
        /// How many.
        missing: i64,
    },
    /// A SYNC was late, and those after it came in time.
    CaughtUp {
        /// Time since the one before, in ns.
        gap_ns: i64,
        /// The cycle that it began.
        cycle: u64,
    },
    /// One too many.
    Extra {
        /// Time since the one before, in ns.
        gap_ns: i64,
        /// The cycle that it began.
        cycle: u64,
    },
    /// One too many again and again: two producers.
    Two {
        /// The shorter of the last two gaps, in ns.
        short_ns: i64,
        /// The longer, in ns.
        long_ns: i64,
        /// The cycle that the last SYNC began.
        cycle: u64,
    },
    /// The period is another one from a SYNC on.
    Changed {
        /// Before, in ns.
        from_ns: i64,
        /// Now, in ns.
        to_ns: i64,
        /// The first SYNC of the new period.
        since: FrameRef,
    },
    /// SYNCs come unsteadily.
    Unsteady {
        /// How far gaps are off the period at most, in ns.
        off_ns: i64,
        /// The cycle that the last SYNC began.
        cycle: u64,
    },
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
    /// The last gaps, judged or not; and which of them agree with the period, the last one in bit 0.
    recent: VecDeque<Gap>,
    steadiness: Steadiness,
    behind: Behind,
    second: Second,
    deviation: Deviation,
    /// The SYNC before the next gap may have been late: no gap before it was judged.
    joined: bool,
    /// The last SYNC came after a pause.
    resumed: bool,
    calm_from: u64,
}

/// How the last gaps stand to the period: one bit for each, the last one in bit 0.
#[derive(Debug, Default)]
struct Steadiness {
    /// Those that agree with it.
    agree: u16,
    /// Those that are far off.
    unsteady: u16,
    /// Gaps are judged: enough of them agree.
    regular: bool,
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

/// How far SYNCs are off the period: measured, or given by option.
#[derive(Debug, Default)]
struct Deviation {
    spread: Spread,
    p99_ns: i64,
    /// By option, in ns.
    jitter_ns: Option<i64>,
}

impl SyncPeriod {
    /// A period whose tolerance is given, or measured.
    pub fn new(jitter_ns: Option<i64>) -> Self {
        Self { deviation: Deviation { jitter_ns, ..Deviation::default() }, joined: true, ..Self::default() }
    }

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

    /// The period that traffic shows, where it is regular.
    pub fn period_ns(&self) -> Option<i64> {
        self.period.learnt_ns().filter(|_| self.steadiness.regular)
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

    /// What a verdict on times has to allow for: as given, or the larger of the stamps' resolution and the 99th
    /// percentile of the period's deviation. `None` before that is known.
    pub fn tolerance_ns(&self, recording: &Recording) -> Option<i64> {
        let measured = || (self.deviation.spread.count() >= 2).then(|| self.deviation.p99_ns.max(recording.grain_ns()));
        self.deviation.jitter_ns.or_else(measured)
    }

    /// Whether SYNCs come as of one producer for some time.
    pub fn is_single(&self) -> bool {
        self.steadiness.regular && self.cycle > self.second.cycle + 2 * EXTRA_WITHIN
    }

    /// How many gaps the tolerance is measured from.
    pub fn measured(&self) -> u64 {
        self.deviation.spread.count()
    }

    /// The mean of the last gaps in ns, and how far it may be off, where all of them were regular.
    pub fn mean_ns(&self, recording: &Recording) -> Option<(i64, i64)> {
        let count = self.steadiness.agree.trailing_ones();
        if count < MEANT || self.behind.late.is_some() || !self.steadiness.regular || self.period.is_contested() {
            return None;
        }
        let first = self.cycle.checked_sub(u64::from(count))?;
        let (since, now) = (self.sync(first)?, self.sync(self.cycle)?);
        let uncertain = recording.grain_ns().saturating_add(lag(now, recording));
        let mean = recording.between(since, now)? / i64::from(count);
        // While the period changes the mean is neither the old one nor the new one; a pause is not in the period.
        let settled = |period: &i64| mean.abs_diff(*period) <= (period / 32).unsigned_abs();
        self.period.learnt_ns().filter(settled).map(|_| (mean, uncertain / i64::from(count)))
    }

    /// Frames were lost, or SYNC was moved: the next gap is not judged.
    pub fn broken(&mut self) {
        self.in_phase();
        self.joined = true;
        self.calm_from = self.cycle + 2;
    }

    /// The cycle that has begun, and the one before, are not judged.
    pub fn disturbed(&mut self) {
        self.calm_from = self.cycle + 1;
    }

    /// The period is another one by configuration: it is learnt anew.
    pub fn forget(&mut self) {
        self.period.forget();
        self.recent.clear();
        (self.steadiness.agree, self.steadiness.unsteady, self.steadiness.regular) = (0, 0, false);
        (self.second.extra, self.second.two, self.joined) = (0, false, true);
        self.in_phase();
    }

    /// What was late is over, or cannot be judged.
    fn in_phase(&mut self) {
        self.behind = Behind::default();
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
        let place = self.cycle as usize % SYNCS;
        match self.syncs.get_mut(place) {
            Some(slot) => *slot = now,
            None => self.syncs.push(now),
        }
        self.cycle += 1;
        let mut out = Vec::new();
        if let Some(since) = since
            && let Some(ns) = recording.between(since, now)
        {
            if recording.teaches(since) && recording.teaches(now) {
                let gap = Gap { now, ns, cycle: self.cycle, restart, silent, spread_ns };
                self.take(gap, recording, &mut out);
            } else {
                self.in_phase();
                self.joined = true;
                self.calm_from = self.calm_from.max(self.cycle + 1);
            }
        }
        out
    }

    /// The capture is over: what was late, where that is certain without the SYNCs that would follow.
    pub fn finish(&mut self, now: FrameRef, recording: &Recording) -> Option<Irregular> {
        let period = self.period_ns()?;
        let whole = self.behind.off_ns.saturating_add(period / 2).div_euclid(period.max(1));
        let in_phase = self.behind.off_ns.abs_diff(whole * period) <= (period / 50).unsigned_abs();
        let silent = self.delay_ns(now).is_some_and(|delay| delay > period);
        let certain = self.behind.calm > 0 || silent || (in_phase && whole > 0);
        if certain { self.lateness(period, recording) } else { None }
    }

    fn take(&mut self, gap: Gap, recording: &Recording, out: &mut Vec<Irregular>) {
        if self.recent.len() == GAPS {
            self.recent.pop_front();
        }
        self.recent.push_back(gap);
        if self.steadiness.regular {
            return self.judge(gap, true, recording, out);
        }
        if gap.ns > 0 {
            let _ = self.period.take(gap.ns, recording.grain_ns(), gap.now.at);
        }
        let median = median(&self.recent);
        let agreeing = self.recent.iter().filter(|gap| close(gap.ns, median)).count();
        if agreeing < ENOUGH || agreeing * 4 < self.recent.len() * 3 || median < FASTEST_NS {
            return;
        }
        // Listed late now and then, gaps differ and make up for each other: then only the mean of many is a period.
        let (mut least, mut most, mut sum) = (i64::MAX, 0, 0_i64);
        for gap in self.recent.iter().filter(|gap| close(gap.ns, median)) {
            (least, most, sum) = (least.min(gap.ns), most.max(gap.ns), sum.saturating_add(gap.ns));
        }
        let uneven = most.saturating_sub(least) > median / 16;
        if uneven && self.recent.len() < GAPS {
            return;
        }
        let mean = sum / agreeing.max(1) as i64;
        self.period.forget();
        for gap in self.recent.iter().filter(|gap| close(gap.ns, median)) {
            let ns = if uneven { mean } else { gap.ns };
            let _ = self.period.take(ns, recording.grain_ns(), gap.now.at);
        }
        self.steadiness.regular = true;
        // What the first gaps were is known only now.
        for gap in self.recent.clone() {
            self.judge(gap, false, recording, out);
        }
    }

    fn judge(&mut self, gap: Gap, new: bool, recording: &Recording, out: &mut Vec<Irregular>) {
        let Some(period) = self.period.learnt_ns() else { return };
        let steady = close(gap.ns, period);
        let before_ns = std::mem::replace(&mut self.second.before_ns, gap.ns);
        if std::mem::take(&mut self.resumed) && !steady && new {
            self.forget();
            return;
        }
        let room = self.tolerance_ns(recording).unwrap_or(0).max(recording.grain_ns()).min(period);
        if self.is_pause(gap, period, room) {
            if self.behind.late.is_some() {
                out.extend(self.lateness(period, recording));
            }
            self.in_phase();
            self.calm_from = gap.cycle + 1;
            self.resumed = true;
            return;
        }
        if new
            && !self.second.two
            && let Learnt::Changed { from_ns, to_ns, since } =
                self.period.take(gap.ns, (room / 2).min(period / 16), gap.now.at)
        {
            self.in_phase();
            (self.second.extra, self.steadiness.agree, self.steadiness.unsteady) = (0, 0, 0);
            out.push(Irregular::Changed { from_ns, to_ns, since });
            return;
        }
        self.steadiness.agree = self.steadiness.agree << 1 | u16::from(steady);
        self.judge_steadiness(gap, period, recording, out);
        self.behind.off_ns = self.behind.off_ns.saturating_add(gap.ns - period);
        if std::mem::take(&mut self.joined) && gap.ns < period {
            self.behind.off_ns = 0;
        }
        if gap.ns > period + period / 2 && self.behind.late.is_none() {
            self.behind.late = Some(gap);
        }
        if !steady {
            self.calm_from = self.calm_from.max(gap.cycle);
        }
        if gap.ns < period / 4 * 3 && self.behind.off_ns < -(period / 2 + room) {
            return self.one_too_many(gap, before_ns, period, out);
        }
        if gap.cycle > self.second.cycle + 2 * EXTRA_WITHIN && std::mem::take(&mut self.second.two) {
            self.in_phase();
        }
        self.settle(gap, period, recording, out);
        if gap.ns >= period / 2 && gap.ns <= period + period / 2 {
            // A change of the period is no jitter: what the next gap makes up for is.
            let (off, before) = (gap.ns - period, before_ns - period);
            let made_up = (off >= 0) != (before >= 0);
            self.deviate(if made_up { off.abs().min(before.abs()) } else { 0 });
        }
    }

    /// Whether enough SYNCs have come in one phase to tell what the one that was late has been.
    fn settle(&mut self, gap: Gap, period: i64, recording: &Recording, out: &mut Vec<Irregular>) {
        let exact = if self.is_explainable(gap, recording) { period / 16 + recording.grain_ns() } else { period / 4 };
        let calm = gap.ns.abs_diff(period) <= exact.unsigned_abs();
        self.behind.calm = if calm { self.behind.calm.saturating_add(1) } else { 0 };
        let whole = self.behind.off_ns.saturating_add(period / 2).div_euclid(period.max(1));
        let moved =
            self.behind.late.is_some() && self.behind.off_ns.abs_diff(whole * period) > (period / 4).unsigned_abs();
        if self.behind.calm >= if moved { 2 * CALM } else { CALM } {
            out.extend(self.lateness(period, recording));
        }
    }

    /// Whether the producer was stopped, or the whole network stood still.
    fn is_pause(&self, gap: Gap, period: i64, room: i64) -> bool {
        if gap.ns / PAUSE > period && gap.silent {
            return true;
        }
        // One that is missing in the old phase is none that began anew with the next one.
        let exact = match gap.restart {
            Restart::None => return false,
            Restart::Hardly => room.min(period / 16),
            Restart::Perhaps if room <= period / 16 => room,
            Restart::Configuring if gap.ns <= period.saturating_mul(3) => return false,
            Restart::Perhaps | Restart::Configuring | Restart::Likely => -1,
        };
        gap.ns > period && !close(gap.ns, period) && gap.ns.abs_diff(period.saturating_mul(2)) as i64 > exact
    }

    /// Whether the host's late listing alone may have put the SYNCs off as far as they are.
    fn is_explainable(&self, gap: Gap, recording: &Recording) -> bool {
        self.behind.off_ns <= lag(gap.now, recording)
    }

    fn judge_steadiness(&mut self, gap: Gap, period: i64, recording: &Recording, out: &mut Vec<Irregular>) {
        let off_ns = (gap.ns - period).abs();
        let put_off = lag(gap.now, recording).min(gap.spread_ns.unwrap_or(i64::MAX));
        let far = off_ns > (period / 6).saturating_add(put_off) && off_ns < period / 2;
        self.steadiness.unsteady = self.steadiness.unsteady << 1 | u16::from(far);
        if far
            && !self.second.two
            && self.steadiness.unsteady.count_ones() == UNSTEADY
            && self.steadiness.unsteady >> 1 & 1 == 1
        {
            out.push(Irregular::Unsteady { off_ns, cycle: gap.cycle });
        }
    }

    fn one_too_many(&mut self, gap: Gap, before_ns: i64, period: i64, out: &mut Vec<Irregular>) {
        self.behind.off_ns = self.behind.off_ns.saturating_add(period);
        self.behind.calm = 0;
        let again = gap.cycle <= self.second.cycle + EXTRA_WITHIN;
        self.second.extra = if again { self.second.extra.saturating_add(1) } else { 1 };
        self.second.cycle = gap.cycle;
        let (short_ns, long_ns) = (gap.ns.min(before_ns), gap.ns.max(before_ns));
        // Even gaps are another period, not two producers.
        if self.second.extra >= EXTRA && long_ns - short_ns > period / 16 {
            if !std::mem::replace(&mut self.second.two, true) {
                out.push(Irregular::Two { short_ns, long_ns, cycle: gap.cycle });
            }
        } else {
            out.push(Irregular::Extra { gap_ns: gap.ns, cycle: gap.cycle });
        }
    }

    /// What the SYNC that was late has turned out to be, now that others came in the same phase.
    fn lateness(&mut self, period: i64, recording: &Recording) -> Option<Irregular> {
        let off = self.behind.off_ns;
        let late = self.behind.late.take();
        self.in_phase();
        let gap = late?;
        let missing = off.saturating_add(period / 2).div_euclid(period.max(1));
        let most = gap.ns.saturating_add(period / 2) / period.max(1) - 1;
        let room = self.tolerance_ns(recording).unwrap_or(0).max(recording.grain_ns()).min(period);
        let explainable = off <= lag(gap.now, recording);
        let exact = if explainable { period / 16 } else { period / 4 };
        let whole = missing > 0 && off.abs_diff(missing * period) <= exact.unsigned_abs();
        let (gap_ns, cycle) = (gap.ns, gap.cycle);
        if whole && recording.grain_ns() < period {
            return Some(Irregular::Late { gap_ns, cycle, missing: missing.min(most).max(1) });
        }
        if off > period / 2 + room && (!explainable || room <= period / 8) {
            return Some(Irregular::Late { gap_ns, cycle, missing: 0 });
        }
        Some(Irregular::CaughtUp { gap_ns, cycle })
    }

    fn deviate(&mut self, by_ns: i64) {
        self.deviation.spread.record(by_ns);
        let count = self.deviation.spread.count();
        if count < 128 || count.is_multiple_of(16) {
            self.deviation.p99_ns = self.deviation.spread.p99_ns();
        }
    }
}

/// How late a frame may be listed, in ns.
fn lag(when: When, recording: &Recording) -> i64 {
    if when.own { recording.lag_ns() } else { 0 }
}

/// Within a quarter.
fn close(gap: i64, period: i64) -> bool {
    gap.abs_diff(period) <= period.unsigned_abs() / 4
}

fn median(gaps: &VecDeque<Gap>) -> i64 {
    let mut sorted = [i64::MAX; GAPS];
    for (slot, gap) in sorted.iter_mut().zip(gaps) {
        *slot = gap.ns;
    }
    sorted.sort_unstable();
    sorted.get(gaps.len().min(GAPS) / 2).copied().unwrap_or(0)
}
