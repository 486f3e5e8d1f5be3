//! What the recording did with the frames of one bus: how exact its stamps are, where it stood still, where it lost
//! frames, where its clock was set, and how late it lists the host's own frames.
//!
//! A tolerance that concerns the recording belongs here, and not beside a verdict. The comparisons of times that verdicts
//! rest on are made here ([`Recording::certainly_later`], [`Recording::certainly_within`]): they hold for every time at
//! which the frames may have been on the bus. It must not know what a frame means.
//!
//! # Bursts
//!
//! A recorder that stands still keeps frames in a buffer and stamps them all when it goes on. What it then lists is a
//! *burst*: after a silence of the whole bus that is longer than any lately, frames come without a pause until the
//! buffer is empty, and among them what should have come during the silence. Until that has shown, the burst is open. A
//! burst that is confirmed has no times of its own: each frame may have been sent at any time since the
//! silence began. One that is refuted was ordinary traffic.
//!
//! # Reading ahead
//!
//! What the recording did with a frame may show only by the frames behind it. Each frame is observed first
//! ([`Recording::observe`]), and verdicts take it once nothing about it is open any more
//! ([`Recording::undecided_since`]).

use crate::frame::{Direction, Frame, FrameRef, Kind};

use super::duplicates::{Duplicates, PATIENCE_NS, Sighting};
use super::when::When;

/// The coarsest resolution of stamps that is taken for one, in ns: software that prints hundredths of a second.
const COARSEST_NS: i64 = 10_000_000;
/// The latest that a host lists its own frames, in ns.
const LATEST_ECHO_NS: i64 = 10_000_000;
/// The same in frames, where there are no stamps.
const LATEST_ECHO_FRAMES: u64 = 2;
/// The least that is allowed for late own frames, whatever was seen so far, in ns.
const LEAST_ECHO_NS: i64 = 2_500_000;
/// Where a host lists its own frames late, most are late by no more than this, in ns: what is this close to the answer that
/// stands before it is its request.
pub const USUAL_ECHO_NS: i64 = 1_000_000;
/// Exchanges whose order was seen before the lag is taken from them.
const EXCHANGES: u32 = 64;
/// Exchanges, all of them in order, by which an own frame that is missing at the end of the capture is not awaited.
const IN_ORDER: u32 = 16;
/// A silence shorter than this is no stall, in ns: it moves no verdict.
const SHORTEST_STALL_NS: i64 = 10_000_000;
/// Frames from a buffer follow each other within this time, in ns.
const DRAIN_NS: i64 = 1_500_000;
/// By how much a silence must exceed the longest of late, in tenths, to be unusual.
const UNUSUAL_TENTHS: i64 = 13;
/// What [`Happened::paused`] counts: frames that were expected for two periods.
const TWO_PERIODS_TENTHS: i64 = 20;
/// A step back of the stamps by at least this much is a clock that was set, in ns. Below, two buses or the host's own
/// frames are listed out of order.
const CLOCK_STEP_NS: i64 = 10_000_000;
/// The bit rate of the fastest bus, in ns a bit: no frame follows another in less than it takes itself.
const BIT_NS: i64 = 1_000;
/// The bits of a frame without data, without stuff bits.
const FRAME_BITS: i64 = 44;
/// Frames that were due at times further apart than this, and come at once, waited for the recorder, in ns.
const APART_NS: i64 = 3_000_000;
/// Frames of a burst by which it has shown that it is one; where it has not, it is ordinary traffic.
const SHOWN: u32 = 256;
/// Frames in which little is known of a bus yet.
const FIRST: u64 = 64;
/// The part of a time between two frames, and the least in ns, by which the stamp of the first is taken to be late, where
/// the bus was silent that long before it.
const LATE_PART: i64 = 3;
const LATE_NS: i64 = 2_000_000;
/// Bursts remembered.
const BURSTS: usize = 8;
/// A silence of so many periods of a single sender, while nobody else was expected, is the recording's.
const LONG: i64 = 10;
/// A silence that exceeds the longest of late so many times may be the recorder's, whoever ends it.
const ODD: i64 = 4;
/// CAN-IDs of which the usual gap is kept: all 11-bit ones.
const IDENTIFIERS: usize = 0x800;
/// Those that tell nothing of a pause: commands, emergencies, SDO and LSS are sent when there is a reason, and the two
/// frames of an SRDO are one node's.
const APERIODIC: [std::ops::RangeInclusive<usize>; 5] =
    [0x000..=0x07F, 0x081..=0x0FF, 0x101..=0x180, 0x580..=0x67F, 0x7E4..=0x7E5];

/// What became of a burst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// It still runs.
    #[default]
    Open,
    /// The recorder had stood still: its frames have no times of their own.
    Confirmed,
    /// Ordinary traffic after a silence.
    Refuted,
}

/// Frames without a pause after an unusual silence.
#[derive(Clone, Copy, Debug, Default)]
struct Burst {
    /// Its number, from 1, and that of its first frame.
    number: u32,
    first: u64,
    /// When the silence before it began, and when it ended, in ns.
    from_ns: i64,
    to_ns: i64,
    /// The silence was longer than those of late, or several senders were overdue in it: else only frames that cannot
    /// have been on the bus when they are stamped tell that it is one.
    unusual: bool,
    /// Frames in it.
    frames: u32,
    /// By how much its frames came later than they were due, at least and at most, in ns.
    late_ns: Option<(i64, i64)>,
    /// A CAN-ID came again in it.
    again: bool,
    /// It has shown that it is one, unless the capture shows frames twice.
    shown: bool,
    verdict: Verdict,
}

/// A silence of the whole bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Silence {
    /// When it began, in ns.
    pub from_ns: i64,
    /// When it ended, or until when it has lasted, in ns.
    pub to_ns: i64,
    /// Nodes, one bit each, of which a frame was expected in it and did not come, where it was longer than any of late;
    /// bit 0: of no node.
    pub missing: u128,
    /// It exceeded the longest of late several times: what ends it may have waited with the recorder.
    pub odd: bool,
}

impl Silence {
    /// How long it was, in ns.
    pub fn ns(self) -> i64 {
        self.to_ns.saturating_sub(self.from_ns)
    }

    /// Whether it is no node's own: others had been expected as well, or it was far longer than the node's period.
    pub fn is_of_all(self, node: u8, period_ns: i64) -> bool {
        self.missing & !(1 << (node & 0x7F)) != 0 || self.ns() / LONG > period_ns
    }
}

/// How often a CAN-ID comes.
#[derive(Clone, Copy, Debug, Default)]
struct Usual {
    last_ns: i64,
    gap_ns: i64,
    /// By how much its gaps differ, in ns.
    off_ns: i64,
    /// Gaps seen, up to a few.
    gaps: u8,
    /// In how short a time it came again in the first burst, in ns; 0: it did not.
    squeezed_ns: i64,
}

impl Usual {
    /// When the next frame is due, of a CAN-ID whose gaps are even, in ns.
    fn due_ns(&self) -> Option<i64> {
        let even = self.gaps > 2 && self.off_ns < self.gap_ns / 8;
        even.then(|| self.last_ns.saturating_add(self.gap_ns))
    }
}

/// What happened to the recording with a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Happened {
    /// The clock was set by so many ns.
    pub step_ns: Option<i64>,
    /// Nodes, one bit each, of which frames had been due during the silence of the whole bus before this frame.
    pub paused: u128,
    /// The silence of the whole bus before this frame, where it concerns a verdict.
    pub silence: Option<Silence>,
    /// The frame is one that stood shortly before already.
    pub sighting: Sighting,
}

/// What is known of the recording of one bus.
#[derive(Debug, Default)]
pub struct Recording {
    /// Counts up where the clock was set, and where frames were lost.
    steps: u32,
    losses: u32,
    /// The resolution of the stamps in ns; 0: nothing was seen.
    grain_ns: i64,
    /// The last frame's time, and the latest so far.
    last_ns: Option<i64>,
    latest_ns: Option<i64>,
    /// The last silence of the bus after which frames came in a row, in ns.
    silence_ns: i64,
    /// Mean gap between frames, in 64ths of ns.
    mean_gap_64: i64,
    /// The longest gap of late, in ns.
    usual_gap_ns: i64,
    bursts: Vec<Burst>,
    /// The last burst still runs: no pause has come since it began.
    running: bool,
    /// By CAN-ID; empty until the first stamp.
    usual: Vec<Usual>,
    /// CAN-IDs that were seen.
    active: Vec<usize>,
    /// Frames, and those that stand closer to the one before than they can be on a bus.
    frames: u64,
    gaps: u64,
    close: u64,
    /// The last silence, and the last frame's time, of the frames that were taken.
    silence: Option<Silence>,
    taken_ns: Option<i64>,
    echo: Echo,
    duplicates: Duplicates,
    /// By option (`--jitter`), in ns.
    jitter_ns: Option<i64>,
}

/// How late own frames were listed.
#[derive(Clone, Copy, Debug, Default)]
struct Echo {
    exchanges: u32,
    latest_ns: i64,
}

impl Recording {
    /// A recording of which a person says how exact it is.
    pub fn new(jitter_ns: Option<i64>) -> Self {
        Self { jitter_ns, ..Self::default() }
    }

    /// Takes the next frame of the bus: its place, and what happened to the recording with it.
    pub fn observe(&mut self, frame: &Frame) -> (When, Happened) {
        let mut happened = Happened::default();
        let gap_ns = frame.t_ns.zip(self.last_ns).map_or(i64::MAX, |(now, last)| now.saturating_sub(last));
        happened.sighting = self.duplicates.step(frame, gap_ns < wire_ns(frame));
        let mut silent_ns = 0;
        if let Some(now) = frame.t_ns {
            self.narrow_grain(frame, now);
            happened.step_ns = self.step_of_clock(now);
            silent_ns = self.last_ns.map_or(0, |last| now.saturating_sub(last).max(0));
            if let Some(last) = self.last_ns.filter(|_| silent_ns > SHORTEST_STALL_NS) {
                happened.silence = Some(self.measure(last, now));
                happened.paused = self.missing(last, now, TWO_PERIODS_TENTHS);
            }
            self.frames += 1;
            self.follow_burst(frame, now, happened.sighting == Sighting::Original);
            self.last_ns = Some(now);
            self.latest_ns = Some(self.latest_ns.map_or(now, |latest| latest.max(now)));
        }
        self.decide_shown();
        if silent_ns > DRAIN_NS {
            self.silence_ns = silent_ns;
        }
        (When { silent_ns: self.silence_ns, epoch: self.steps, ..self.at(frame.reference()) }, happened)
    }

    /// The place of a frame that was observed, once it is taken. `commands`: it is of a kind that a master sends (an SDO
    /// request, NMT, SYNC, TIME, an RPDO, a remote frame, LSS of the master), which may be the recording host itself.
    pub fn take(&mut self, observed: When, happened: Happened, frame: &Frame, commands: bool) -> When {
        self.silence = happened.silence.or(self.silence);
        self.taken_ns = frame.t_ns.or(self.taken_ns);
        let own = match frame.dir {
            Some(direction) => direction == Direction::Tx,
            None => commands || frame.kind == Kind::Remote,
        };
        When { own, epoch: observed.epoch.saturating_add(self.losses), ..observed }
    }

    /// Whether a frame that was observed as such is a duplicate, once it is taken.
    pub fn sighting(&self, number: u64, observed: Sighting) -> Sighting {
        self.duplicates.decided(number, observed)
    }

    /// The number of the first frame of which it is not known yet what the recording did with it.
    pub fn undecided_since(&self) -> Option<u64> {
        let burst = self.bursts.last().filter(|burst| burst.verdict == Verdict::Open).map(|burst| burst.first);
        match (burst, self.duplicates.undecided_since()) {
            (Some(burst), Some(suspect)) => Some(burst.min(suspect)),
            (burst, suspect) => burst.or(suspect),
        }
    }

    /// No further frame tells what the recording did: what is open is decided by what was seen.
    pub fn settle(&mut self) {
        self.duplicates.settle();
        self.end_burst();
        self.decide_shown();
        self.refute();
    }

    /// Whether a frame is the first after a time for which the recorder stood still.
    pub fn is_first_of_stall(&self, when: When) -> bool {
        let burst = self.burst(when.burst);
        burst.is_some_and(|burst| burst.verdict == Verdict::Confirmed && burst.first == when.at.no)
    }

    /// The place of what has no frame of its own: the end of the capture, or a time at which no frame came.
    pub fn at(&self, at: FrameRef) -> When {
        let burst = self.bursts.last().filter(|_| self.running).map_or(0, |burst| burst.number);
        When { at, epoch: self.steps.saturating_add(self.losses), burst, ..When::default() }
    }

    /// It is `now_ns` and no frame has come. A burst that has ended by now is settled.
    pub fn advance(&mut self, now_ns: i64) {
        if self.last_ns.is_some_and(|last| now_ns.saturating_sub(last) > DRAIN_NS) {
            self.end_burst();
        }
        self.duplicates.advance(now_ns);
        self.decide_shown();
        // Nobody who watches a live bus waits long for what comes behind a burst.
        if self.bursts.last().is_some_and(|burst| now_ns.saturating_sub(burst.to_ns) > PATIENCE_NS) {
            self.end_burst();
            self.refute();
        }
    }

    /// Frames are missing here.
    pub fn lost(&mut self) {
        self.losses = self.losses.saturating_add(1);
        (self.last_ns, self.taken_ns, self.silence) = (None, None, None);
        self.end_burst();
    }

    /// A request and its answer were seen, the request listed `late_ns` after the answer (0: before it).
    pub fn exchanged(&mut self, late_ns: i64) {
        self.echo.exchanges = self.echo.exchanges.saturating_add(1);
        self.echo.latest_ns = self.echo.latest_ns.max(late_ns.clamp(0, LATEST_ECHO_NS));
    }

    /// The resolution of the stamps in ns; at least 1.
    pub fn grain_ns(&self) -> i64 {
        self.grain_ns.max(1)
    }

    /// How late an own frame may be listed at most, in ns.
    pub fn lag_ns(&self) -> i64 {
        if self.echo.exchanges < EXCHANGES {
            return LATEST_ECHO_NS;
        }
        // The latest so far is seldom the latest of all.
        self.echo.latest_ns.saturating_mul(2).clamp(LEAST_ECHO_NS, LATEST_ECHO_NS)
    }

    /// Whether the capture lists own frames when they are sent, as far as its exchanges show.
    pub fn lists_in_order(&self) -> bool {
        self.echo.exchanges >= IN_ORDER && self.echo.latest_ns == 0
    }

    /// Whether a frame's time tells something of its sender: not that of a burst, which is any time.
    pub fn teaches(&self, when: When) -> bool {
        when.at.t_ns.is_some() && !matches!(self.verdict(when.burst), Some(Verdict::Open | Verdict::Confirmed))
    }

    /// Whether the capture shows its frames twice.
    pub fn shows_twice(&self) -> bool {
        self.duplicates.are_proven()
    }

    /// Whether the capture is known to show each frame once.
    pub fn shows_once(&self) -> bool {
        self.duplicates.are_refuted()
    }

    /// By how much a frame may have been stamped late, in ns: no longer than the bus was silent before it, as what waits
    /// is stamped in a row. Nothing, where a person says how exact the stamps are.
    pub fn lateness_ns(&self, when: When) -> i64 {
        if self.jitter_ns.is_some() { 0 } else { when.silent_ns }
    }

    /// The same, as far as it may shorten a time of `apart_ns` to the next frame.
    pub fn shortens_ns(&self, when: When, apart_ns: i64) -> i64 {
        self.lateness_ns(when).min(LATE_NS.max(apart_ns / LATE_PART))
    }

    /// When a frame was on the bus: the earliest and the latest time, in ns.
    pub fn interval(&self, when: When) -> (i64, i64) {
        let Some(stamp) = when.at.t_ns else { return (i64::MIN, i64::MAX) };
        let uncertain = self.jitter_ns.unwrap_or_else(|| self.grain_ns());
        let echo = if when.own { self.lag_ns() } else { 0 };
        let earliest = stamp.saturating_sub(uncertain.saturating_add(echo));
        match self.burst(when.burst).filter(|burst| burst.verdict == Verdict::Confirmed) {
            Some(burst) => (burst.from_ns.min(earliest), stamp),
            None => (earliest, stamp),
        }
    }

    /// Whether an own frame that was on the bus before `since` must have been listed by `now`.
    pub fn is_settled(&self, since: FrameRef, now: FrameRef) -> bool {
        match since.t_ns.zip(now.t_ns) {
            Some((since_ns, now_ns)) => {
                now.no > since.no && !(0..LATEST_ECHO_NS).contains(&now_ns.saturating_sub(since_ns))
            }
            None => now.no > since.no + LATEST_ECHO_FRAMES,
        }
    }

    /// Whether more than `limit_ns` lies between two frames, whatever the recording did.
    pub fn certainly_later(&self, now: When, since: When, limit_ns: i64) -> bool {
        let ((earliest, _), (_, latest)) = (self.interval(now), self.interval(since));
        now.epoch == since.epoch && earliest.saturating_sub(latest) > limit_ns
    }

    /// Whether less than `limit_ns` lies between two frames, whatever the recording did.
    pub fn certainly_within(&self, now: When, since: When, limit_ns: i64) -> bool {
        let ((_, latest), (earliest, _)) = (self.interval(now), self.interval(since));
        now.epoch == since.epoch && latest.saturating_sub(earliest) < limit_ns
    }

    /// Whether a frame may have been on the bus before another one, whichever is listed first.
    pub fn may_precede(&self, one: When, other: When) -> bool {
        if one.epoch != other.epoch || one.at.t_ns.is_none() {
            return one.at.no < other.at.no;
        }
        let ((earliest, _), (_, latest)) = (self.interval(one), self.interval(other));
        earliest <= latest
    }

    /// Whether an equal frame was sent again: it is no duplicate that the capture shows of the one before.
    pub fn is_sent_again(&self, before: FrameRef, now: FrameRef) -> bool {
        before.t_ns.zip(now.t_ns).is_some_and(|(before, now)| now.saturating_sub(before) > super::duplicates::APART_NS)
    }

    /// The time from one frame to another by their stamps, in ns; `None` without stamps or across a gap.
    pub fn between(&self, since: When, now: When) -> Option<i64> {
        if since.epoch != now.epoch {
            return None;
        }
        Some(now.at.t_ns?.saturating_sub(since.at.t_ns?))
    }

    /// When the recorder stood still last: the end of the silence, as a frame's time, and how long it was, in ns.
    pub fn stalled(&self) -> Option<(i64, i64)> {
        let burst = self.bursts.iter().rev().find(|burst| burst.verdict == Verdict::Confirmed)?;
        Some((burst.to_ns, burst.to_ns.saturating_sub(burst.from_ns)))
    }

    /// The last silence of the whole bus that concerns a verdict, which may last at `now_ns`.
    pub fn silence(&self, now_ns: i64) -> Option<Silence> {
        match self.taken_ns {
            Some(from_ns) if now_ns.saturating_sub(from_ns) > SHORTEST_STALL_NS => Some(self.measure(from_ns, now_ns)),
            _ => self.silence,
        }
    }

    fn measure(&self, from_ns: i64, to_ns: i64) -> Silence {
        let odd = self.usual_gap_ns > 0 && to_ns.saturating_sub(from_ns) / ODD > self.usual_gap_ns;
        Silence { from_ns, to_ns, missing: self.missing(from_ns, to_ns, UNUSUAL_TENTHS), odd }
    }

    /// Whether a silence is longer than those of late.
    fn is_unusual(&self, gap: i64) -> bool {
        gap > SHORTEST_STALL_NS && gap / UNUSUAL_TENTHS > self.usual_gap_ns / 10
    }

    /// What became of a burst; `None` where it is none, or forgotten: then it was settled long ago.
    pub fn verdict(&self, burst: u32) -> Option<Verdict> {
        self.burst(burst).map(|burst| burst.verdict)
    }

    fn burst(&self, number: u32) -> Option<&Burst> {
        if number == 0 { None } else { self.bursts.iter().rev().find(|burst| burst.number == number) }
    }

    /// The multiple of which all stamps are, whatever the number of decimals they are written with.
    fn narrow_grain(&mut self, frame: &Frame, now: i64) {
        let written = frame.stamp.map_or(1, |stamp| 10_i64.pow(9 - u32::from(stamp.decimals.min(9))));
        if self.grain_ns == 0 {
            self.grain_ns = COARSEST_NS;
        }
        while self.grain_ns > written && now % self.grain_ns != 0 {
            self.grain_ns /= 10;
        }
    }

    fn step_of_clock(&mut self, now: i64) -> Option<i64> {
        let back = self.latest_ns?.saturating_sub(now);
        if back < CLOCK_STEP_NS.max(self.lag_ns()) {
            return None;
        }
        self.steps = self.steps.saturating_add(1);
        self.latest_ns = None;
        self.end_burst();
        Some(-back)
    }

    /// Takes a frame's time. One that may be a duplicate shows nothing until that is decided.
    fn follow_burst(&mut self, frame: &Frame, now: i64, original: bool) {
        let Some(last) = self.last_ns else {
            self.see(frame, now);
            return;
        };
        let gap = now.saturating_sub(last).max(0);
        if gap > DRAIN_NS || self.has_caught_up(now) {
            self.end_burst();
        }
        let overdue = if gap > SHORTEST_STALL_NS { self.overdue(last, now) } else { 0 };
        let unusual = overdue > 1 || self.is_unusual(gap);
        if unusual || overdue > 0 {
            self.begin_burst(Burst { from_ns: last, to_ns: now, first: frame.no, unusual, ..Burst::default() });
        }
        let late_ns = self.lateness(frame, now);
        let before_ns = self.came_before(frame, now);
        let compressed = self.see(frame, now);
        self.compare_later(before_ns);
        let too_close = self.is_too_close(frame, gap);
        if !self.running {
            return self.know_gap(gap);
        }
        let mean = self.mean_gap_64 / 64;
        let Some(burst) = self.bursts.last_mut() else { return };
        burst.frames += 1;
        if burst.verdict != Verdict::Open {
            return;
        }
        if let Some(late_ns) = late_ns {
            let (least, most) = burst.late_ns.unwrap_or((late_ns, late_ns));
            burst.late_ns = Some((least.min(late_ns), most.max(late_ns)));
        }
        if let Some((id, gap_ns)) = before_ns.filter(|(_, gap_ns)| *gap_ns <= now.saturating_sub(burst.to_ns))
            && let Some(usual) = self.usual.get_mut(id)
        {
            burst.again = true;
            usual.squeezed_ns = gap_ns;
        }
        let at_once = burst.late_ns.is_some_and(|(least, most)| most.saturating_sub(least) > APART_NS);
        let expected = now.saturating_sub(burst.from_ns) / mean.max(1);
        let many = burst.frames > 2 && i64::from(burst.frames) * 10 >= expected.saturating_mul(6);
        let dense = burst.unusual && (compressed || many);
        if burst.frames > 1 && (dense || at_once || too_close) {
            burst.shown = true;
            if original {
                burst.verdict = Verdict::Confirmed;
            }
        } else if burst.frames > SHOWN && !burst.shown {
            self.end_burst();
        }
    }

    /// How many CAN-IDs came evenly and were overdue when a silence ended, and not when it began.
    fn overdue(&self, from: i64, to: i64) -> usize {
        let overdue = |usual: &Usual| {
            let room = (usual.gap_ns / 16).saturating_add(usual.off_ns.saturating_mul(2)).saturating_add(APART_NS);
            usual.due_ns().is_some_and(|due| due >= from && due.saturating_add(room) < to)
        };
        self.active.iter().filter(|id| self.usual.get(**id).is_some_and(overdue)).count()
    }

    /// By how much a frame of a burst comes later than it was due, in ns; `None` where it was not due since the silence
    /// began, or comes unevenly.
    fn lateness(&self, frame: &Frame, now: i64) -> Option<i64> {
        let from = self.bursts.last().filter(|_| self.running)?.from_ns;
        let usual = self.usual.get(frame.id.raw() as usize).filter(|_| !frame.id.is_extended())?;
        let due = usual.due_ns().filter(|due| *due > from)?;
        (due < now.saturating_add(usual.gap_ns / 4)).then(|| now.saturating_sub(due))
    }

    /// Whether a frame follows the one before in less time than it takes on the fastest bus, where that is rare: it was
    /// kept in a buffer.
    fn is_too_close(&mut self, frame: &Frame, gap: i64) -> bool {
        let close = gap < wire_ns(frame);
        if !self.running {
            self.gaps += 1;
            self.close += u64::from(close);
        }
        close && self.close * 16 <= self.gaps && self.grain_ns < wire_ns(frame)
    }

    /// How long ago the CAN-ID of a frame came before, in ns, if it comes by itself.
    fn came_before(&self, frame: &Frame, now: i64) -> Option<(usize, i64)> {
        let id = frame.id.raw() as usize;
        let usual = self.usual.get(id).filter(|usual| usual.last_ns != 0 && !frame.id.is_extended())?;
        let periodic = !APERIODIC.iter().any(|range| range.contains(&id));
        periodic.then(|| (id, now.saturating_sub(usual.last_ns)))
    }

    /// At the beginning of a capture nothing is known of its CAN-IDs: a burst in which one came again is decided by how
    /// often that one comes behind it.
    fn compare_later(&mut self, before_ns: Option<(usize, i64)>) {
        let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open) else { return };
        if self.running {
            return;
        }
        burst.frames += 1;
        if burst.frames > SHOWN {
            burst.verdict = Verdict::Refuted;
        }
        let Some((id, gap_ns)) = before_ns else { return };
        let squeezed_ns = self.usual.get(id).map_or(0, |usual| usual.squeezed_ns);
        if squeezed_ns > 0 && gap_ns > 4 * squeezed_ns.max(DRAIN_NS) {
            burst.verdict = Verdict::Confirmed;
        }
    }

    fn begin_burst(&mut self, burst: Burst) {
        self.refute();
        let number = self.bursts.last().map_or(0, |burst| burst.number) + 1;
        if self.bursts.len() == BURSTS {
            self.bursts.remove(0);
        }
        self.bursts.push(Burst { number, ..burst });
        self.running = true;
    }

    /// Whether the buffer must be empty by now: it fills no faster than it is emptied.
    fn has_caught_up(&self, now: i64) -> bool {
        let burst = self.bursts.last().filter(|_| self.running);
        burst.is_some_and(|burst| now.saturating_sub(burst.to_ns) > burst.to_ns.saturating_sub(burst.from_ns))
    }

    /// The frames after a silence have come to a pause: they were ordinary traffic unless they have shown otherwise.
    fn end_burst(&mut self) {
        if !std::mem::take(&mut self.running) {
            return;
        }
        let first = self.frames <= FIRST;
        let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open) else { return };
        if burst.shown || first && burst.again {
            return;
        }
        burst.verdict = Verdict::Refuted;
        let silence = burst.to_ns.saturating_sub(burst.from_ns);
        self.know_gap(silence);
    }

    /// Whether the capture shows frames twice is decided: so is what frames have shown that might have been duplicates.
    fn decide_shown(&mut self) {
        if self.duplicates.undecided_since().is_some() {
            return;
        }
        let twice = self.duplicates.are_proven();
        if let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open && burst.shown) {
            burst.verdict = if twice { Verdict::Refuted } else { Verdict::Confirmed };
        }
    }

    /// A burst that is still open was ordinary traffic.
    fn refute(&mut self) {
        if let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open) {
            burst.verdict = Verdict::Refuted;
        }
    }

    /// Takes an ordinary gap between frames.
    fn know_gap(&mut self, gap: i64) {
        let gap = gap.min(i64::MAX / 128);
        self.usual_gap_ns = (self.usual_gap_ns - self.usual_gap_ns / 256).max(gap);
        self.mean_gap_64 += if self.mean_gap_64 == 0 { gap * 64 } else { gap - self.mean_gap_64 / 64 };
    }

    /// Takes the time of a frame of a CAN-ID; whether it came in less than a quarter of its usual gap.
    fn see(&mut self, frame: &Frame, now: i64) -> bool {
        if self.usual.is_empty() {
            self.usual = vec![Usual::default(); IDENTIFIERS];
        }
        let index = frame.id.raw() as usize;
        let Some(usual) = self.usual.get_mut(index).filter(|_| !frame.id.is_extended()) else { return false };
        let gap = now.saturating_sub(usual.last_ns);
        let known = usual.last_ns != 0;
        usual.last_ns = now;
        if !known {
            self.active.push(index);
        }
        if !known || gap < 0 {
            return false;
        }
        let compressed = usual.gap_ns > 4 * DRAIN_NS && gap < usual.gap_ns / 4;
        if !compressed {
            usual.gaps = usual.gaps.saturating_add(1);
            if usual.gap_ns == 0 {
                usual.gap_ns = gap;
            }
            usual.off_ns += ((gap - usual.gap_ns).abs() - usual.off_ns) / 4;
            usual.gap_ns += (gap - usual.gap_ns) / 4;
        }
        compressed
    }

    /// The nodes of which a frame had been expected, by so many tenths of its usual gap, during a silence, if it is longer
    /// than any of late. A sender that fell silent before does not count.
    fn missing(&self, from: i64, now: i64, tenths: i64) -> u128 {
        if !self.is_unusual(now.saturating_sub(from)) {
            return 0;
        }
        let due = |usual: &Usual| {
            let due = usual.last_ns.saturating_add(usual.gap_ns.saturating_mul(tenths) / 10);
            usual.gap_ns > 0 && (from..now).contains(&due)
        };
        let mut nodes = 0_u128;
        let periodic = |id: &usize| !APERIODIC.iter().any(|range| range.contains(id));
        for id in self.active.iter().filter(|id| periodic(id) && self.usual.get(**id).is_some_and(due)) {
            nodes |= 1 << (id % 0x80);
        }
        nodes
    }

    /// The last frame of the bus.
    pub fn last_ns(&self) -> Option<i64> {
        self.last_ns
    }
}

/// How long a frame takes at least, in ns: on the fastest bus, without stuff bits.
fn wire_ns(frame: &Frame) -> i64 {
    match frame.kind {
        Kind::Data => (FRAME_BITS + 8 * i64::from(frame.len)) * BIT_NS,
        _ => FRAME_BITS * BIT_NS,
    }
}
