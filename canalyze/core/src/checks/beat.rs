//! The beat of a bus: its SYNCs counted, their period learnt, and how steadily they come.
//!
//! The period is the median of recent gaps between SYNCs, once these agree; a SYNC that is asked for by a person has
//! none. It knows stamps only, and raises nothing: a gap gets a word (`Pace`), the judgement is `sync`'s.

use crate::checks::jitter::Spread;
use crate::frame::FrameRef;

/// SYNCs remembered: as many as the longest cycle of a synchronous PDO (transmission type 240).
const SYNCS: usize = 256;
/// Gaps of which the period is the median.
const GAPS: usize = 16;
/// Gaps that must agree before there is a period; fewer where a configured period agrees with them.
const ENOUGH: usize = 4;
const ENOUGH_CONFIGURED: usize = 2;
/// Gaps in a row beside the period after which it is learnt anew.
const MISSES: u8 = 8;
/// A gap of more periods than this is a pause: the producer was stopped.
const PAUSE: i64 = 10;
/// Gaps in a row that add up in pairs to the period: two producers.
const PAIRS: u8 = 6;
/// Steady gaps in a row after which what was late is not caught up any more.
const CALM: u8 = 2;
/// The latest that the capturing host sees a SYNC of its own.
const ECHO_NS: i64 = 2_200_000;
/// No producer is this fast: frames that a machine that stood still takes from its buffer.
const FASTEST_NS: i64 = 200_000;
/// The slowest that such frames follow each other.
const DRAINED_NS: i64 = 1_000_000;
/// Gaps in a row that agree among themselves, and are more than frames from a buffer: another period.
const ALIKE: u8 = 8;
/// After a pause, how far SYNCs may be behind that come together then.
const STALL_NS: i64 = 1_000_000_000;

/// How a SYNC came after the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// No period is known, or the stamps do not tell.
    Unknown,
    /// As it should, or a little off.
    Steady,
    /// More than one and a half periods after the one before. Whether it was is told when the beat is steady again
    /// (`Settled`): a machine that stood still lists all that were due together.
    Late,
    /// Less than half a period after the one before, and not because that one was late.
    Early,
    /// Less than half a period after one that was late: the producer catches up. Or the second of a pair that is the
    /// period together, where one was told of before.
    CaughtUp,
    /// What was late has not been caught up.
    Settled(Lateness),
    /// After a pause.
    Resumed,
    /// Two trains of SYNCs have shown: the gaps before and after.
    TwoTrains(i64, i64),
}

/// Whether there was reason for the producer to begin anew since the last SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restart {
    /// No.
    #[default]
    None,
    /// A node was stopped of which it is not known whether it is the producer: that would not have gone on.
    Hardly,
    /// A node was reset of which it is not known whether it is the producer: most are not.
    Perhaps,
    /// Yes.
    Likely,
}

/// A SYNC that was late, and not only listed late.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lateness {
    /// Time since the one before.
    pub gap_ns: i64,
    /// The cycle that it began.
    pub cycle: u64,
    /// SYNCs missing before it; 0: it and all after it were late.
    pub missing: i64,
}

/// The beat.
#[derive(Debug, Default)]
pub struct Beat {
    cycle: u64,
    /// A late SYNC that was caught up, until it is told.
    caught_up: Option<(i64, u64)>,
    /// What was late before a pause that had its reason, until it is told.
    before_pause: Option<Lateness>,
    syncs: Vec<FrameRef>,
    /// Recent gaps, a ring.
    gaps: Vec<i64>,
    place: usize,
    period_ns: Option<i64>,
    /// The gap before the last one.
    before_ns: i64,
    misses: u8,
    pairs: u8,
    /// How far the last SYNC was behind the grid of those before it was disturbed; below 0: ahead.
    off_ns: i64,
    /// Steady gaps in a row.
    calm: u8,
    /// The first that was late since: gap and cycle.
    held: Option<(i64, u64)>,
    /// Gaps in a row that are alike, while catching up.
    alike: u8,
    resumed: bool,
    /// Steady gaps since the period was learnt.
    steady: u32,
    calm_from: u64,
    unbroken: bool,
    /// Behind a gap no gap was judged yet: the SYNC before it may have been late.
    joined: bool,
    deviation: Spread,
    p99_ns: i64,
    resolution_ns: i64,
    /// By option.
    jitter_ns: Option<i64>,
}

impl Beat {
    /// A beat whose tolerance is given, or measured.
    pub fn new(jitter_ns: Option<i64>) -> Self {
        Self { jitter_ns, ..Self::default() }
    }

    /// Number of SYNCs seen.
    pub fn cycle(&self) -> u64 {
        self.cycle
    }

    /// The SYNC of a cycle, as far back as is remembered.
    pub fn sync(&self, cycle: u64) -> Option<FrameRef> {
        if cycle == 0 || cycle > self.cycle || self.cycle - cycle >= SYNCS as u64 {
            return None;
        }
        self.syncs.get((cycle - 1) as usize % SYNCS).copied()
    }

    /// Time since the last SYNC.
    pub fn delay_ns(&self, at: FrameRef) -> Option<i64> {
        Some(at.t_ns?.saturating_sub(self.sync(self.cycle)?.t_ns?))
    }

    /// By how much the SYNC of a cycle came later than a period after the one before.
    pub fn lag_ns(&self, cycle: u64) -> i64 {
        let at = |cycle: u64| self.sync(cycle).and_then(|sync| sync.t_ns);
        let gap = at(cycle).zip(at(cycle.saturating_sub(1))).map(|(at, before)| at.saturating_sub(before));
        gap.zip(self.period_ns).map_or(0, |(gap, period)| gap.saturating_sub(period))
    }

    /// The gap before the last SYNC; 0: none is known.
    pub fn last_gap_ns(&self) -> i64 {
        self.before_ns
    }

    /// The period, where there is one.
    pub fn period_ns(&self) -> Option<i64> {
        self.period_ns
    }

    /// Steady gaps since the period was learnt.
    pub fn steady(&self) -> u32 {
        self.steady
    }

    /// The first cycle since which the beat is undisturbed.
    pub fn calm_from(&self) -> u64 {
        self.calm_from
    }

    /// What a verdict on times has to allow for: as given, or the larger of the stamps' resolution and the 99th
    /// percentile of the period's deviation. `None` before that can be said.
    pub fn tolerance_ns(&self) -> Option<i64> {
        let measured = || (self.deviation.count() >= 2).then(|| self.p99_ns.max(self.resolution_ns));
        self.jitter_ns.or_else(measured)
    }

    /// How long before a SYNC a PDO may stand that belongs to it: the capturing host sees its own SYNC late.
    pub fn early_ns(&self) -> i64 {
        self.period_ns.map_or(ECHO_NS, |period| (period * 2 / 5).min(ECHO_NS))
    }

    /// The resolution of the stamps.
    pub fn resolution_ns(&self) -> i64 {
        self.resolution_ns
    }

    /// Frames were lost, or the SYNC was moved: the next gap says nothing.
    pub fn broken(&mut self) {
        self.unbroken = false;
        self.settle();
        self.joined = true;
        self.calm_from = self.cycle + 2;
    }

    /// The cycle that has begun, and the one before, say nothing of what nodes do.
    pub fn disturbed(&mut self) {
        self.calm_from = self.cycle + 1;
    }

    /// The period is another one by configuration: it is learnt anew.
    pub fn forget_period(&mut self) {
        self.period_ns = None;
        self.gaps.clear();
        self.place = 0;
        self.misses = 0;
        self.pairs = 0;
        self.steady = 0;
        self.alike = 0;
        self.settle();
    }

    /// What was late is over, or nothing can be said of it.
    fn settle(&mut self) {
        (self.off_ns, self.calm, self.held) = (0, 0, None);
    }

    /// Whether SYNCs come that were due before.
    pub fn catching_up(&self) -> bool {
        self.held.is_some() || self.off_ns > self.period_ns.unwrap_or(0) / 4
    }

    /// A SYNC that was late while those after it came in time: the time since the one before, and the cycle it began.
    pub fn take_caught_up(&mut self) -> Option<(i64, u64)> {
        self.caught_up.take()
    }

    /// What was late before the pause that has ended.
    pub fn take_before_pause(&mut self) -> Option<Lateness> {
        self.before_pause.take()
    }

    /// The capture is over: what was late, if nothing that was due came in a while.
    pub fn finish(&mut self, now: FrameRef) -> Option<Lateness> {
        self.stopped(self.delay_ns(now))
    }

    /// The same where no SYNC comes any more, for so long already.
    fn stopped(&mut self, delay_ns: Option<i64>) -> Option<Lateness> {
        let period = self.period_ns?;
        let off = self.off_ns.rem_euclid(period.max(1));
        let off = off.min(period - off);
        // What is a whole number of periods late is not caught up soon; what is not may be, with the next one.
        let wait = if off <= period / 4 { period / 4 } else { period };
        let silent = delay_ns.is_some_and(|delay| delay > wait);
        let in_grid = off <= period / 50 && self.tolerance_ns().is_none_or(|tolerance| tolerance <= period / 8);
        if self.calm > 0 || silent || in_grid { self.lateness(period) } else { None }
    }

    fn lateness(&mut self, period: i64) -> Option<Lateness> {
        let off = self.off_ns;
        let held = self.held.take();
        self.settle();
        let (gap_ns, cycle) = held.filter(|_| off / PAUSE <= period)?;
        let missing = off.saturating_add(period / 2) / period.max(1);
        let most = gap_ns.saturating_add(period / 2) / period.max(1) - 1;
        let room = self.tolerance_ns().unwrap_or(0).max(self.resolution_ns).min(period);
        let whole = missing > 0 && off.abs_diff(missing * period) <= (period / 4).unsigned_abs();
        if whole && self.resolution_ns < period {
            return Some(Lateness { gap_ns, cycle, missing: missing.min(most).max(1) });
        }
        if off > period / 2 + room {
            return Some(Lateness { gap_ns, cycle, missing: 0 });
        }
        self.caught_up = Some((gap_ns, cycle));
        None
    }

    /// Takes a SYNC. `configured_ns`: the period that it should have.
    pub fn step(&mut self, at: FrameRef, resolution_ns: i64, restart: Restart, configured_ns: Option<i64>) -> Pace {
        let gap = self.delay_ns(at).filter(|_| self.unbroken);
        self.unbroken = true;
        self.resolution_ns = resolution_ns;
        let place = self.cycle as usize % SYNCS;
        match self.syncs.get_mut(place) {
            Some(slot) => *slot = at,
            None => self.syncs.push(at),
        }
        self.cycle += 1;
        let pace = match gap {
            Some(gap) if gap > 0 || (gap == 0 && self.period_ns.is_some()) => self.pace(gap, restart, configured_ns),
            Some(_) => {
                self.disturbed();
                Pace::Unknown
            }
            None => Pace::Unknown,
        };
        if !matches!(pace, Pace::Unknown | Pace::Steady) {
            self.disturbed();
        }
        self.before_ns = gap.unwrap_or(0);
        pace
    }

    fn pace(&mut self, gap: i64, restart: Restart, configured_ns: Option<i64>) -> Pace {
        let restarted = restart != Restart::None;
        let Some(period) = self.period_ns else {
            self.learn(gap, restarted, configured_ns);
            return Pace::Unknown;
        };
        let steady = close(gap, period);
        // After a pause SYNCs come fast where a machine that stood still lists those from its buffer; else it is
        // another period.
        let drained = gap < period / 2 && gap < (period / 4).max(2 * DRAINED_NS);
        if std::mem::take(&mut self.resumed) && !steady && !drained {
            self.forget_period();
            self.learn(gap, restarted, configured_ns);
            return Pace::Unknown;
        }
        let paired = gap < period - period / 10
            && self.before_ns < period - period / 10
            && gap.saturating_add(self.before_ns).abs_diff(period) <= period.unsigned_abs() / 10
            && (gap - self.before_ns).abs() > period / 10;
        self.pairs = if paired { self.pairs + 1 } else { 0 };
        let room = self.tolerance_ns().unwrap_or(0).max(self.resolution_ns).min(period);
        // One that is missing on the old grid is none that began anew with the next one.
        let exact = match restart {
            Restart::Hardly => room.min(period / 16),
            Restart::Perhaps if room <= period / 16 => room,
            _ => -1,
        };
        let one_missing = gap.saturating_sub(period.saturating_mul(2)).abs() <= exact;
        let anew = restarted && gap > period && !steady && !one_missing;
        if anew && self.held.is_some() {
            self.before_pause = self.stopped(Some(gap));
        }
        self.off_ns = self.off_ns.saturating_add(gap - period);
        let joined = std::mem::take(&mut self.joined);
        let pace = match gap {
            _ if steady => Pace::Steady,
            _ if gap / PAUSE > period || anew => Pace::Resumed,
            _ if gap > period.saturating_add(period / 2) => Pace::Late,
            _ if gap >= period / 2 => Pace::Steady,
            _ if joined => Pace::CaughtUp,
            _ if self.off_ns >= -(period / 2 + room) || self.pairs >= 2 => Pace::CaughtUp,
            _ => Pace::Early,
        };
        if joined && pace == Pace::CaughtUp {
            self.settle();
        }
        self.resumed = pace == Pace::Resumed;
        // A command beside which SYNCs go on as before has changed nothing.
        if self.resumed || (restarted && !steady && pace != Pace::Late) {
            let off = self.off_ns.max(gap - period).min(STALL_NS);
            self.settle();
            self.off_ns = if self.resumed { off } else { 0 };
        }
        if pace == Pace::Late && self.held.is_none() {
            self.held = Some((gap, self.cycle));
        }
        let alike = pace == Pace::CaughtUp && gap > DRAINED_NS / 2 && close(gap, self.before_ns);
        self.alike = if alike { self.alike + 1 } else { 0 };
        if self.alike >= ALIKE {
            self.forget_period();
            return Pace::CaughtUp;
        }
        self.calm = if steady { self.calm.saturating_add(1) } else { 0 };
        let whole = self.off_ns.saturating_add(period / 2) / period.max(1);
        // All that come later may still be caught up: what only moved is told after longer.
        let moved = self.held.is_some() && self.off_ns.abs_diff(whole * period) > (period / 4).unsigned_abs();
        let enough = if moved { 2 * CALM } else { CALM };
        let settled = if self.calm >= enough { self.lateness(period) } else { None };
        if steady {
            self.misses = 0;
            self.steady = self.steady.saturating_add(1);
            self.remember(gap);
            self.period_ns = Some(median(&self.gaps));
        } else if pace != Pace::Resumed && (pace != Pace::CaughtUp || self.pairs > 0) {
            self.misses += 1;
        }
        if pace == Pace::Steady {
            self.deviate(gap - period);
        }
        if self.pairs == PAIRS {
            self.forget_period();
            return Pace::TwoTrains(gap.min(self.before_ns), gap.max(self.before_ns));
        }
        if self.misses >= MISSES {
            self.forget_period();
        }
        settled.map_or(pace, Pace::Settled)
    }

    /// A period was learnt of few gaps: one of two periods or more among them may have been a late SYNC.
    fn look_back(&mut self, period: i64) {
        let missing = |gap: &i64| {
            (2..=PAUSE).any(|times| gap.abs_diff(times.saturating_mul(period)) <= period.unsigned_abs() / 4)
        };
        let found = self.gaps.iter().rev().enumerate().find(|(_, gap)| missing(gap));
        let found = found.filter(|_| self.gaps.len() < GAPS);
        self.held = found.map(|(ago, gap)| (*gap, self.cycle.saturating_sub(ago as u64)));
        let last = self.gaps.last().copied().filter(|gap| !close(*gap, period));
        self.off_ns = match self.held {
            Some(_) => self.gaps.iter().fold(0, |off: i64, gap| off.saturating_add(gap - period)),
            None => last.map_or(0, |gap| gap - period),
        };
    }

    fn learn(&mut self, gap: i64, restarted: bool, configured_ns: Option<i64>) {
        let usual = if self.gaps.is_empty() { 0 } else { median(&self.gaps) };
        if restarted && gap / 3 > usual / 2 {
            // A pause that has its reason is no gap.
            self.gaps.clear();
            self.place = 0;
            return;
        }
        self.remember(gap);
        let median = median(&self.gaps);
        let agreeing = self.gaps.iter().filter(|gap| close(**gap, median)).count();
        let configured = configured_ns.is_some_and(|period| close(median, period)) && agreeing == self.gaps.len();
        if (self.gaps.len() >= ENOUGH && agreeing * 4 >= self.gaps.len() * 3 && median >= FASTEST_NS)
            || (self.gaps.len() >= ENOUGH_CONFIGURED && configured)
        {
            self.period_ns = Some(median);
            self.look_back(median);
            for place in 0..self.gaps.len() {
                if let Some(gap) = self.gaps.get(place).filter(|gap| close(**gap, median)) {
                    self.deviate(gap - median);
                }
            }
        }
    }

    fn remember(&mut self, gap: i64) {
        match self.gaps.get_mut(self.place) {
            Some(slot) => *slot = gap,
            None => self.gaps.push(gap),
        }
        self.place = (self.place + 1) % GAPS;
    }

    fn deviate(&mut self, by_ns: i64) {
        self.deviation.record(by_ns.abs());
        let count = self.deviation.count();
        if count < 128 || count.is_multiple_of(16) {
            self.p99_ns = self.deviation.p99_ns();
        }
    }
}

/// Within a quarter.
fn close(gap: i64, period: i64) -> bool {
    gap.abs_diff(period) <= period.unsigned_abs() / 4
}

fn median(gaps: &[i64]) -> i64 {
    let mut sorted = [i64::MAX; GAPS];
    for (slot, gap) in sorted.iter_mut().zip(gaps) {
        *slot = *gap;
    }
    sorted.sort_unstable();
    sorted.get(gaps.len().min(GAPS) / 2).copied().unwrap_or(0)
}
