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
//! buffer is empty, and among them what should have come during the silence. Until that has shown, the burst is open:
//! findings that rest on its times wait (see [`Context::report_timed`](crate::context::Context::report_timed)), and deadlines are not
//! judged. A burst that is confirmed has no times of its own: each frame may have been sent at any time since the
//! silence began. One that is refuted was ordinary traffic.

use crate::frame::{Direction, Frame, FrameRef, Kind};

use super::duplicates::{Duplicates, Sighting};
use super::when::When;

/// The coarsest resolution of stamps that is taken for one, in ns: software that prints hundredths of a second.
const COARSEST_NS: i64 = 10_000_000;
/// The latest that a host lists its own frames, in ns.
const LATEST_ECHO_NS: i64 = 10_000_000;
/// The least that is allowed for late own frames, whatever was seen so far, in ns.
const LEAST_ECHO_NS: i64 = 2_500_000;
/// Where a host lists its own frames late, most are late by no more than this, in ns: what is this close to the answer that
/// stands before it is its request.
pub const USUAL_ECHO_NS: i64 = 1_000_000;
/// Exchanges whose order was seen before the lag is taken from them.
const EXCHANGES: u32 = 64;
/// A silence shorter than this is no stall, in ns: it moves no verdict.
const SHORTEST_STALL_NS: i64 = 10_000_000;
/// Frames from a buffer follow each other within this time, in ns.
const DRAIN_NS: i64 = 1_500_000;
/// By how much a silence must exceed the longest of late, in tenths, to be unusual.
const UNUSUAL_TENTHS: i64 = 13;
/// A step back of the stamps by at least this much is a clock that was set, in ns. Below, two buses or the host's own
/// frames are listed out of order.
const CLOCK_STEP_NS: i64 = 10_000_000;
/// Bursts remembered.
const BURSTS: usize = 8;
/// CAN-IDs of which the usual gap is kept: all 11-bit ones.
const IDENTIFIERS: usize = 0x800;
/// Those that tell nothing of a pause: SDO is sent when somebody asks, and the two frames of an SRDO are one node's.
const APERIODIC: [std::ops::RangeInclusive<usize>; 2] = [0x580..=0x67F, 0x101..=0x180];

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
    /// Its number, from 1.
    number: u32,
    /// When the silence before it began, and when it ended, in ns.
    from_ns: i64,
    to_ns: i64,
    /// Frames in it.
    frames: u32,
    verdict: Verdict,
}

/// How often a CAN-ID comes.
#[derive(Clone, Copy, Debug, Default)]
struct Usual {
    last_ns: i64,
    gap_ns: i64,
}

/// What happened to the recording with a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Happened {
    /// The clock was set by so many ns.
    pub step_ns: Option<i64>,
    /// The recorder had stood still: the burst that the frame is in is confirmed by it.
    pub confirmed: bool,
    /// Nodes, one bit each, of which frames had been due during the silence of the whole bus before this frame.
    pub paused: u128,
    /// The frame is one that stood shortly before already.
    pub sighting: Sighting,
}

/// What is known of the recording of one bus.
#[derive(Debug, Default)]
pub struct Recording {
    epoch: u32,
    /// The resolution of the stamps in ns; 0: nothing was seen.
    grain_ns: i64,
    /// The last frame's time, and the latest so far.
    last_ns: Option<i64>,
    latest_ns: Option<i64>,
    /// Mean gap between frames, in 64ths of ns.
    mean_gap_64: i64,
    /// The longest gap of late, in ns.
    usual_gap_ns: i64,
    bursts: Vec<Burst>,
    /// The last burst still runs: no pause has come since it began.
    running: bool,
    /// By CAN-ID; empty until the first stamp.
    usual: Vec<Usual>,
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

    /// Takes the next frame of the bus. `commands`: it is of a kind that a master sends (an SDO request, NMT, SYNC,
    /// TIME, an RPDO, a remote frame, LSS of the master), which may be the recording host itself.
    pub fn step(&mut self, frame: &Frame, commands: bool) -> (When, Happened) {
        let mut happened = Happened { sighting: self.duplicates.step(frame), ..Happened::default() };
        let mut silent_ns = 0;
        if let Some(now) = frame.t_ns {
            self.narrow_grain(frame, now);
            happened.step_ns = self.step_of_clock(now);
            silent_ns = self.last_ns.map_or(0, |last| now.saturating_sub(last).max(0));
            happened.paused = if silent_ns > SHORTEST_STALL_NS { self.missing(now) } else { 0 };
            happened.confirmed = self.follow_burst(frame, now);
            self.last_ns = Some(now);
            self.latest_ns = Some(self.latest_ns.map_or(now, |latest| latest.max(now)));
        }
        let own = match frame.dir {
            Some(direction) => direction == Direction::Tx,
            None => commands || frame.kind == Kind::Remote,
        };
        (When { own, silent_ns, ..self.at(frame.reference()) }, happened)
    }

    /// The place of what has no frame of its own: the end of the capture, or a time at which no frame came.
    pub fn at(&self, at: FrameRef) -> When {
        let burst = self.bursts.last().filter(|_| self.running).map_or(0, |burst| burst.number);
        When { at, epoch: self.epoch, burst, ..When::default() }
    }

    /// It is `now_ns` and no frame has come. A burst that has ended by now is settled.
    pub fn advance(&mut self, now_ns: i64) {
        if self.last_ns.is_some_and(|last| now_ns.saturating_sub(last) > DRAIN_NS) {
            self.end_burst();
        }
    }

    /// Frames are missing here.
    pub fn lost(&mut self) {
        self.epoch += 1;
        self.last_ns = None;
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

    /// Whether an unusual silence has just ended and it is not known yet whether the recorder stood still.
    pub fn is_open(&self) -> bool {
        self.bursts.last().is_some_and(|burst| burst.verdict == Verdict::Open)
    }

    /// Whether a frame's time tells something of its sender: not that of a burst, which is any time.
    pub fn teaches(&self, when: When) -> bool {
        when.at.t_ns.is_some() && !matches!(self.verdict(when.burst), Some(Verdict::Open | Verdict::Confirmed))
    }

    /// Whether the capture shows its frames twice.
    pub fn shows_twice(&self) -> bool {
        self.duplicates.are_proven() || self.duplicates.are_all_so_far()
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
        self.epoch += 1;
        self.latest_ns = None;
        self.end_burst();
        Some(-back)
    }

    /// Takes a frame's time; whether it confirms the burst that it is in.
    fn follow_burst(&mut self, frame: &Frame, now: i64) -> bool {
        let Some(last) = self.last_ns else {
            self.see(frame, now);
            return false;
        };
        let gap = now.saturating_sub(last).max(0);
        if gap > DRAIN_NS || self.has_caught_up(now) {
            self.end_burst();
        }
        if gap > SHORTEST_STALL_NS && gap / UNUSUAL_TENTHS > self.usual_gap_ns / 10 {
            self.begin_burst(last, now);
        }
        let compressed = self.see(frame, now);
        if !self.running {
            self.know_gap(gap);
            return false;
        }
        let mean = self.mean_gap_64 / 64;
        let Some(burst) = self.bursts.last_mut() else { return false };
        burst.frames += 1;
        if burst.verdict != Verdict::Open {
            return false;
        }
        let expected = now.saturating_sub(burst.from_ns) / mean.max(1);
        let many = burst.frames > 2 && i64::from(burst.frames) * 10 >= expected.saturating_mul(6);
        if burst.frames > 1 && (compressed || many) {
            burst.verdict = Verdict::Confirmed;
            return true;
        }
        false
    }

    fn begin_burst(&mut self, from_ns: i64, to_ns: i64) {
        let number = self.bursts.last().map_or(0, |burst| burst.number) + 1;
        if self.bursts.len() == BURSTS {
            self.bursts.remove(0);
        }
        self.bursts.push(Burst { number, from_ns, to_ns, ..Burst::default() });
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
        let Some(burst) = self.bursts.last_mut().filter(|burst| burst.verdict == Verdict::Open) else { return };
        burst.verdict = Verdict::Refuted;
        let silence = burst.to_ns.saturating_sub(burst.from_ns);
        self.know_gap(silence);
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
        if !known || gap < 0 {
            return false;
        }
        let compressed = usual.gap_ns > 4 * DRAIN_NS && gap < usual.gap_ns / 4;
        if !compressed {
            usual.gap_ns = if usual.gap_ns == 0 { gap } else { usual.gap_ns + (gap - usual.gap_ns) / 4 };
        }
        compressed
    }

    /// The nodes of which a frame had been due for two periods during the silence that ends at `now`. A sender that
    /// fell silent before does not count.
    fn missing(&self, now: i64) -> u128 {
        let Some(from) = self.last_ns else { return 0 };
        if now.saturating_sub(from) / UNUSUAL_TENTHS <= self.usual_gap_ns / 10 {
            return 0;
        }
        let due = |usual: &Usual| {
            let due = usual.last_ns.saturating_add(usual.gap_ns.saturating_mul(2));
            usual.gap_ns > 0 && (from..now).contains(&due)
        };
        let mut nodes = 0_u128;
        let periodic = |id: &usize| !APERIODIC.iter().any(|range| range.contains(id));
        for (id, _) in self.usual.iter().enumerate().filter(|(id, usual)| periodic(id) && due(usual)) {
            nodes |= 1 << (id % 0x80);
        }
        nodes
    }

    /// The last frame of the bus.
    pub fn last_ns(&self) -> Option<i64> {
        self.last_ns
    }
}
