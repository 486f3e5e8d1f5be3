//! What the recording did with the frames of one bus: how exact its stamps are, where it stood still, where it lost
//! frames, where its clock was set, and how late it lists the host's own frames.
//!
//! A tolerance that concerns the recording belongs here, and not beside a verdict. The comparisons of times that verdicts
//! rest on are made here ([`Recording::certainly_later`], [`Recording::certainly_within`]): they hold for every time at
//! which the frames may have been on the bus. It must not know what a frame means.
//!
//! # Reading ahead
//!
//! What the recording did with a frame may show only by the frames behind it. Each frame is observed first
//! ([`Recording::observe`]), and verdicts take it once nothing about it is open any more
//! ([`Recording::undecided_since`]).

use crate::frame::{CanId, Direction, Frame, FrameRef, Kind};

use super::duplicates::{Duplicates, Sighting};
use super::holes::Holes;
use super::resolution::Resolution;
use super::stalls::{DRAIN_NS, SHORTEST_STALL_NS, Stalls, UNUSUAL_TENTHS, wire_ns};
use super::when::When;

pub use super::stalls::Verdict;

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
/// What [`Silence::paused`] counts.
const TWO_PERIODS_TENTHS: i64 = 20;
/// A step back of the stamps by at least this much is a clock that was set, in ns. Below, two buses or the host's own
/// frames are listed out of order.
const CLOCK_STEP_NS: i64 = LATEST_ECHO_NS;
/// The part of a time between two frames, and the least in ns, by which the stamp of the first is taken to be late, where
/// the bus was silent that long before it.
const LATE_PART: i64 = 3;
const LATE_NS: i64 = 2_000_000;
/// A silence of so many periods of a single sender, while nobody else was expected, is the recording's.
const LONG: i64 = 10;
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
    /// The same of which a frame had been expected for two periods when it ended.
    pub paused: u128,
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

/// What happened to the recording with a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Happened {
    /// The clock was set by so many ns.
    pub step_ns: Option<i64>,
    /// The silence of the whole bus before this frame, where it concerns a verdict.
    pub silence: Option<Box<Silence>>,
    /// The frame is one that stood shortly before already.
    pub sighting: Sighting,
}

/// What is known of the recording of one bus.
#[derive(Debug, Default)]
pub struct Recording {
    clock: Clock,
    /// Counts up where frames were lost.
    losses: u32,
    resolution: Resolution,
    /// The last frame's time.
    last_ns: Option<i64>,
    /// The last silence of the bus after which frames came in a row, in ns.
    silence_ns: i64,
    /// The last silence, and the last frame's time, of the frames that were taken.
    silence: Option<Silence>,
    taken_ns: Option<i64>,
    /// The CAN-ID of the first of them, and whether others have another one.
    only: Option<CanId>,
    several: bool,
    stalls: Stalls,
    echo: Echo,
    duplicates: Duplicates,
    holes: Holes,
    /// By option (`--jitter`), in ns.
    jitter_ns: Option<i64>,
}

/// The clock of the stamps.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    /// Counts up where it was set.
    steps: u32,
    /// The latest time since.
    latest_ns: Option<i64>,
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

    /// Takes the next frame of the bus: its place, and what happened to the recording with it. Where the stamps are of no
    /// use the place has no time, as if there were none.
    pub fn observe(&mut self, frame: &Frame) -> (When, Happened) {
        let of_use = self.resolution.is_of_use();
        if let Some(now) = frame.t_ns {
            self.resolution.narrow(frame, now);
        }
        if self.resolution.is_of_use() != of_use {
            // Times before and after are not comparable.
            self.clock.steps = self.clock.steps.saturating_add(1);
            (self.clock.latest_ns, self.last_ns) = (None, None);
            self.stalls.end_burst();
        }
        let untimed;
        let frame = match self.resolution.is_of_use() {
            true => frame,
            false => {
                untimed = Frame { t_ns: None, ..*frame };
                &untimed
            }
        };
        let mut happened = Happened::default();
        let (resolution_ns, wire_ns) = (self.resolution.ns(), wire_ns(frame));
        let gap = frame.t_ns.zip(self.last_ns).map(|(now, last)| now.saturating_sub(last));
        let close = gap.is_some_and(|gap| gap < wire_ns);
        // Stamps that are coarser than duplicates are apart tell their order alone.
        let unstamped = Frame { t_ns: None, ..*frame };
        let compared = if resolution_ns > super::duplicates::APART_NS { &unstamped } else { frame };
        happened.sighting = self.duplicates.step(compared, close, resolution_ns);
        let mut silent_ns = 0;
        if let Some(now) = frame.t_ns {
            self.resolution.follow(frame, (now, gap, wire_ns), happened.sighting);
            happened.step_ns = self.step_of_clock(now);
            if happened.step_ns.is_some() || self.last_ns.is_none() {
                self.holes.start(now);
            }
            silent_ns = gap.map_or(0, |gap| gap.max(0));
            if let Some(last) = self.last_ns.filter(|_| silent_ns > SHORTEST_STALL_NS) {
                happened.silence = Some(Box::new(self.measure(last, now)));
                if !self.duplicates.are_proven() && self.duplicates.undecided_since().is_none() {
                    let unusual = self.stalls.is_unusual(silent_ns);
                    self.holes.begin(frame, (last, now, unusual), self.stalls.even(), resolution_ns);
                }
            }
            let original = happened.sighting == Sighting::Original;
            let too_close = (close, resolution_ns < wire_ns, resolution_ns);
            self.stalls.follow(frame, (self.last_ns, now, silent_ns), original, too_close);
            self.last_ns = Some(now);
            self.clock.latest_ns = Some(self.clock.latest_ns.map_or(now, |latest| latest.max(now)));
        }
        self.stalls.decide_shown(&self.duplicates);
        if let Some(now) = frame.t_ns {
            self.holes.follow(frame, now, &self.stalls);
        }
        if silent_ns > DRAIN_NS {
            self.silence_ns = silent_ns;
        }
        let (at, epoch, burst) = (frame.reference(), self.clock.steps, self.stalls.running());
        (When { at, epoch, burst, own: false, silent_ns: self.silence_ns }, happened)
    }

    /// Completes the place of a frame that was observed, once it is taken. `commands`: it is of a kind that a master
    /// sends (an SDO request, NMT, SYNC, TIME, an RPDO, a remote frame, LSS of the master), which may be the recording
    /// host itself.
    pub fn take(&mut self, when: &mut When, happened: &Happened, frame: &Frame, commands: bool) {
        if let Some(silence) = &happened.silence {
            self.silence = Some(**silence);
        }
        self.taken_ns = frame.t_ns.or(self.taken_ns);
        self.several |= *self.only.get_or_insert(frame.id) != frame.id;
        when.own = match frame.dir {
            Some(direction) => direction == Direction::Tx,
            None => commands || frame.kind == Kind::Remote,
        };
        when.epoch = when.epoch.saturating_add(self.losses);
    }

    /// Whether more than one CAN-ID is in the capture so far: it is not what a filter has left.
    pub fn shows_several(&self) -> bool {
        self.several
    }

    /// Whether a frame that was observed as such is a duplicate, once it is taken. What comes from a buffer is close to
    /// equal frames because of that.
    pub fn sighting(&self, at: FrameRef, observed: Sighting) -> Sighting {
        let near_burst = |at_ns| self.stalls.is_near_confirmed(at_ns, super::duplicates::APART_NS);
        match self.duplicates.decided(at.no, observed) {
            Sighting::Suspect if at.t_ns.is_some_and(near_burst) => Sighting::Original,
            decided => decided,
        }
    }

    /// Whether it is known of every frame so far what the recording did with it.
    #[inline]
    pub fn is_decided(&self) -> bool {
        let (stalls, duplicates, holes) = (&self.stalls, &self.duplicates, &self.holes);
        stalls.undecided_since().is_none()
            && duplicates.undecided_since().is_none()
            && holes.undecided_since().is_none()
    }

    /// The number of the first frame of which it is not known yet what the recording did with it.
    pub fn undecided_since(&self) -> Option<u64> {
        let open = [self.stalls.undecided_since(), self.duplicates.undecided_since(), self.holes.undecided_since()];
        open.into_iter().flatten().min()
    }

    /// No further frame tells what the recording did: what is open is decided by what was seen.
    pub fn settle(&mut self) {
        self.duplicates.settle();
        self.stalls.settle(&self.duplicates);
        self.holes.settle();
    }

    /// Whether a frame is the first one behind a hole of the recording that nothing announces.
    #[inline]
    pub fn is_behind_hole(&self, number: u64) -> bool {
        self.holes.is_behind(number)
    }

    /// Whether a frame is the first after a time for which the recorder stood still.
    pub fn is_first_of_stall(&self, when: When) -> bool {
        self.stalls.is_first_of_confirmed(when.burst, when.at.no)
    }

    /// The place of what has no frame of its own: the end of the capture, or a time at which no frame came.
    pub fn at(&self, at: FrameRef) -> When {
        let burst = self.stalls.running();
        let at = FrameRef { t_ns: at.t_ns.filter(|_| self.resolution.is_of_use()), ..at };
        When { at, epoch: self.clock.steps.saturating_add(self.losses), burst, ..When::default() }
    }

    /// It is `now_ns` and no frame has come. A burst that has ended by now is settled.
    pub fn advance(&mut self, now_ns: i64) {
        self.duplicates.advance(now_ns);
        self.stalls.advance(self.last_ns, now_ns, &self.duplicates);
        self.holes.advance(now_ns);
    }

    /// Frames are missing here, before those that were observed but not taken.
    pub fn lost(&mut self) {
        self.losses = self.losses.saturating_add(1);
        if self.taken_ns == self.last_ns {
            self.last_ns = None;
            self.stalls.end_burst();
        }
        (self.taken_ns, self.silence) = (None, None);
    }

    /// A request and its answer were seen, the request listed `late_ns` after the answer (0: before it).
    pub fn exchanged(&mut self, late_ns: i64) {
        self.echo.exchanges = self.echo.exchanges.saturating_add(1);
        self.echo.latest_ns = self.echo.latest_ns.max(late_ns.clamp(0, LATEST_ECHO_NS));
    }

    /// The resolution of the stamps in ns; at least 1.
    pub fn resolution_ns(&self) -> i64 {
        self.resolution.ns()
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
    pub fn shows_duplicates(&self) -> bool {
        self.duplicates.are_proven()
    }

    /// Whether the capture is known to show each frame once.
    pub fn shows_once(&self) -> bool {
        self.duplicates.are_refuted()
    }

    /// How exact a person says that the stamps are, in ns.
    pub fn stated_jitter_ns(&self) -> Option<i64> {
        self.jitter_ns
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
        let uncertain = self.jitter_ns.unwrap_or_else(|| self.resolution_ns());
        let echo = if when.own { self.lag_ns() } else { 0 };
        let earliest = stamp.saturating_sub(uncertain.saturating_add(echo));
        match self.stalls.since_ns(when.burst) {
            Some(from_ns) => (from_ns.min(earliest), stamp),
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
        let (from_ns, to_ns) = self.stalls.last_stall()?;
        Some((to_ns, to_ns.saturating_sub(from_ns)))
    }

    /// The last silence of the whole bus that concerns a verdict, which may last at `now_ns`.
    pub fn silence(&self, now_ns: i64) -> Option<Silence> {
        match self.taken_ns {
            Some(from_ns) if now_ns.saturating_sub(from_ns) > SHORTEST_STALL_NS => Some(self.measure(from_ns, now_ns)),
            _ => self.silence,
        }
    }

    /// Whether what a node owes fell due in a silence of the whole bus that may last at `now_ns` and is not its own fault.
    /// `period_ns`: how often it is due.
    pub fn was_silent(&self, node: u8, fell_ns: i64, period_ns: i64, now_ns: i64) -> bool {
        let holds = |one: &Silence| (one.from_ns..=one.to_ns).contains(&fell_ns) && one.is_of_all(node, period_ns);
        self.silence(now_ns).is_some_and(|silence| holds(&silence))
    }

    /// The silence of the whole bus that a frame has ended at `now_ns`, where it concerns a verdict.
    #[inline]
    pub fn ended_silence(&self, now_ns: i64) -> Option<&Silence> {
        self.silence.as_ref().filter(|silence| silence.to_ns == now_ns)
    }

    fn measure(&self, from_ns: i64, to_ns: i64) -> Silence {
        let missing = |tenths: i64| self.stalls.missing(from_ns, to_ns, tenths);
        let (missing, paused) = (missing(UNUSUAL_TENTHS), missing(TWO_PERIODS_TENTHS));
        Silence { from_ns, to_ns, missing, paused, odd: self.stalls.is_odd(to_ns.saturating_sub(from_ns)) }
    }

    /// What became of a burst; `None` where it is none, or forgotten: then it was settled long ago.
    pub fn verdict(&self, burst: u32) -> Option<Verdict> {
        self.stalls.verdict(burst)
    }

    fn step_of_clock(&mut self, now: i64) -> Option<i64> {
        let back = self.clock.latest_ns?.saturating_sub(now);
        if back < CLOCK_STEP_NS {
            return None;
        }
        self.clock.steps = self.clock.steps.saturating_add(1);
        self.clock.latest_ns = None;
        self.stalls.end_burst();
        Some(-back)
    }

    /// Whether a frame at this time ends a silence of the bus that is longer than those of late.
    pub fn is_unusual_silence(&self, now_ns: Option<i64>) -> bool {
        let silence_ns = now_ns.zip(self.last_ns).map(|(now, last)| now.saturating_sub(last));
        silence_ns.is_some_and(|silence_ns| self.stalls.is_unusual(silence_ns))
    }

    /// The last frame of the bus.
    pub fn last_ns(&self) -> Option<i64> {
        self.last_ns
    }
}
