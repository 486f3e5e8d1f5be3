//! The behaviour of the recording of one bus: the accuracy of its stamps, its stalls, lost frames, steps of its clock,
//! and the delay of the host's own frames.
//!
//! Tolerances of the recording are kept here and not beside a verdict. Here are also the comparisons of times on which
//! verdicts rest ([`Recording::certainly_later`], [`Recording::certainly_within`]): they hold for every time at which
//! the frames may have been on the bus.
//!
//! # Reading ahead
//!
//! Later frames may show how a frame was recorded. Each frame is therefore observed first ([`Recording::observe`]), and
//! taken for verdicts once nothing about it is open ([`Recording::undecided_since`]).

use crate::bytes::frame::{CanId, Direction, Frame, FrameRef, Kind};
use crate::bytes::ns::Ns;
use crate::rules::finding::Finding;

use super::duplicates::{Duplicates, Sighting};
use super::echoes::Echoes;
use super::holes::Holes;
use super::losses::Losses;
use super::resolution::Resolution;
use super::senders::UNUSUAL_TENTHS;
use super::stalls::{DRAIN_NS, SHORTEST_STALL_NS, Stalls, wire_ns};
use super::when::When;

pub use super::stalls::{FRAME_NS, Verdict};

/// Maximum delay with which a host lists its own frames, in ns.
const LATEST_ECHO_NS: Ns = Ns::from_ms(10);
/// The same in frames, without stamps.
const LATEST_ECHO_FRAMES: u64 = 2;
/// Minimum allowance for late own frames, in ns, whatever has been seen so far.
const LEAST_ECHO_NS: Ns = Ns::from_us(2_500);
/// Usual maximum delay of own frames on a host that lists them late, in ns: a request this close after the preceding
/// answer belongs to it.
pub const USUAL_ECHO_NS: Ns = Ns::from_ms(1);
/// Number of exchanges after which the delay is taken from them.
const EXCHANGES: u32 = 64;
/// Number of exchanges, all in order, after which a missing own frame is not awaited at the end of the capture; and of prompt
/// ones after which own frames are known to be listed in time for the most part.
const IN_ORDER: u32 = 16;
/// The same where all own frames are as late or early as each other.
const FEW_IN_ORDER: u32 = 4;
/// The limit for [`Silence::paused`], in tenths of a period.
const TWO_PERIODS_TENTHS: i64 = 20;
/// Minimum backward step of the stamps that is a set clock, in ns. Below, two buses or the host's own frames are listed
/// out of order.
pub(super) const CLOCK_STEP_NS: Ns = Ns(LATEST_ECHO_NS.as_ns() + 1);
/// Minimum backward step after which another recording may begin, as in files joined or recorded twice into one, in ns;
/// a running clock is set by less.
const ANOTHER_NS: Ns = Ns::from_s(1);
/// Possible lateness of the first stamp after an equally long silence, as a part of the time to the next frame, and its
/// minimum in ns.
const LATE_PART: i64 = 3;
const LATE_NS: Ns = Ns::from_ms(2);
/// Minimum length of a silence of the whole bus that is a pause of the network, whatever was due in it, in ns.
pub const PAUSE_NS: Ns = Ns::from_s(1);
/// The CAN-IDs of requests of SDO clients.
const SDO_REQUESTS: std::ops::RangeInclusive<u32> = 0x601..=0x67F;
/// Number of periods of a single sender from which a silence is the recording's, even if no other node was due.
const LONG: i64 = 10;
/// A silence of the whole bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Silence {
    /// Its beginning, in ns.
    pub from_ns: Ns,
    /// Its end, or its latest time so far, in ns.
    pub to_ns: Ns,
    /// Nodes, one bit each, with a missing frame in it, if it was longer than recent ones; bit 0: no node.
    pub missing: u128,
    /// The same for frames that were due for two periods when it ended.
    pub paused: u128,
    /// True if a sender that does not depend on SYNC was due for two periods in it.
    pub others: bool,
    /// True if it exceeded the longest recent one several times, so that the frames after it may have been delayed by
    /// the recorder.
    pub odd: bool,
}

impl Silence {
    /// Returns its length, in ns.
    pub fn ns(self) -> Ns {
        self.to_ns - self.from_ns
    }

    /// Returns true if it is not caused by the node: others were due as well, or it was far longer than the node's
    /// period.
    pub fn is_of_all(self, node: u8, period_ns: Ns) -> bool {
        self.missing & !(1 << (node & 0x7F)) != 0 || self.ns() / LONG > period_ns
    }
}

/// The events of the recording at a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Happened {
    /// The clock was set.
    pub step: Option<ClockStep>,
    /// The silence of the whole bus before this frame, if it concerns a verdict.
    pub silence: Option<Box<Silence>>,
    /// The sighting of the frame, as a possible duplicate.
    pub sighting: Sighting,
}

/// A frame's place in the recording, and the events there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedFrame {
    /// The place.
    pub when: When,
    /// The events; `None` at most frames. Boxed, since they are rare and this is moved at every frame.
    pub happened: Option<Box<Happened>>,
}

impl RecordedFrame {
    /// Returns true if the clock was set before the frame.
    pub fn is_behind_step(&self) -> bool {
        self.happened.as_ref().is_some_and(|happened| happened.step.is_some())
    }
}

/// The knowledge about the recording of one bus.
#[derive(Debug, Default)]
pub struct Recording {
    clock: StampClock,
    /// Incremented at each loss of frames.
    losses: u32,
    resolution: Resolution,
    /// Time of the last frame, in ns.
    last_ns: Option<Ns>,
    /// The last silence before a run of frames, in ns.
    silence_ns: Ns,
    /// The last silence, and the time of the last frame, among the frames taken.
    silence: Option<Silence>,
    taken_ns: Option<Ns>,
    /// The CAN-ID of the first of them, and true if others have another one.
    only: Option<CanId>,
    several: bool,
    /// True if a frame is no request of an SDO client.
    others: bool,
    /// True if an SDO client has gone on as if answered.
    goes_on: bool,
    /// The SDO servers, one bit each by node-ID, with an answer in the capture.
    answering: u128,
    stalls: Stalls,
    echo: Echo,
    duplicates: Duplicates,
    echoes: Echoes,
    holes: Holes,
    single: Losses,
    /// The option `--jitter`, in ns.
    jitter_ns: Option<Ns>,
}

/// A step by which the clock of the stamps was set back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockStep {
    /// The bus goes on.
    Set,
    /// Another recording may begin, as in files that were joined: what was known before holds no longer. The step is
    /// long, or leads back to where the recording began.
    NewRecording,
}

/// The clock of the stamps.
#[derive(Clone, Copy, Debug, Default)]
struct StampClock {
    /// Incremented at each step.
    steps: u32,
    /// The first and the latest time since, in ns.
    first_ns: Option<Ns>,
    latest_ns: Option<Ns>,
}

/// The delay of own frames.
#[derive(Clone, Copy, Debug, Default)]
struct Echo {
    exchanges: u32,
    /// Those in order whose answer came so soon that an own frame listed late would have been listed behind it.
    prompt: u32,
    latest_ns: Ns,
    /// The shortest time from a request to its answer.
    shortest_ns: Ns,
}

impl Recording {
    /// Creates a recording, with its accuracy if the user gives one.
    pub fn new(jitter_ns: Option<Ns>) -> Self {
        Self { jitter_ns, ..Self::default() }
    }

    /// Observes the next frame of the bus; returns its place and the events of the recording. If the stamps are
    /// useless, the place has no time, as without stamps.
    #[inline]
    pub fn observe(&mut self, frame: &Frame) -> RecordedFrame {
        match self.ordinary_gap(frame).filter(|(now, _)| self.echoes.pass(frame, *now)) {
            Some((now, gap)) => RecordedFrame { when: self.observe_ordinary(frame, now, gap), happened: None },
            None => self.observe_any(frame),
        }
    }

    /// Returns the time of a frame and the gap before it, in ns, if nothing about the recording is open and the frame
    /// can open nothing: most frames only add to the usual gaps.
    #[inline]
    pub(super) fn ordinary_gap(&self, frame: &Frame) -> Option<(Ns, Ns)> {
        let (now, last) = (frame.t_ns?, self.last_ns?);
        let gap = now - last;
        let ordinary = frame.kind != Kind::Error
            && (Ns::ZERO..=SHORTEST_STALL_NS).contains(&gap)
            && self.clock.latest_ns.is_some_and(|latest| latest <= now)
            && self.resolution.stays_of_use()
            && self.duplicates.are_settled()
            && self.stalls.are_over()
            && self.holes.undecided_since().is_none();
        ordinary.then_some((now, gap))
    }

    /// Observes such a frame, with the result of [`Self::observe_any`].
    #[inline]
    fn observe_ordinary(&mut self, frame: &Frame, now: Ns, gap: Ns) -> When {
        self.resolution.narrow(frame, now);
        let (resolution_ns, wire_ns) = (self.resolution.ns(), wire_ns(frame));
        self.resolution.follow(frame, (now, Some(gap), wire_ns), Sighting::Original);
        let missed = self.stalls.follow_ordinary(frame, (now, gap), (gap < wire_ns, resolution_ns < wire_ns));
        self.single.follow(frame, missed.filter(|_| resolution_ns < LATE_NS));
        (self.last_ns, self.clock.latest_ns) = (Some(now), Some(now));
        if gap > DRAIN_NS {
            self.silence_ns = gap;
        }
        let (at, epoch) = (frame.reference(), self.clock.steps);
        When { at, epoch, burst: 0, own: false, silent_ns: self.silence_ns }
    }

    /// Observes any frame.
    pub(super) fn observe_any(&mut self, frame: &Frame) -> RecordedFrame {
        let of_use = self.resolution.is_of_use();
        if let Some(now) = frame.t_ns {
            self.resolution.narrow(frame, now);
        }
        if self.resolution.is_of_use() != of_use {
            // Times before and after are not comparable.
            self.clock.steps = self.clock.steps.saturating_add(1);
            (self.clock.first_ns, self.clock.latest_ns, self.last_ns) = (None, None, None);
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
        let gap = frame.t_ns.zip(self.last_ns).map(|(now, last)| now - last);
        let close = gap.is_some_and(|gap| gap < wire_ns);
        // Stamps coarser than the distance of duplicates only show the order.
        let compared_ns = frame.t_ns.filter(|_| resolution_ns <= super::duplicates::APART_NS);
        happened.sighting = self.duplicates.step(frame, compared_ns, close, resolution_ns);
        // Behind a step of the clock it may be any frame.
        let echo = frame.t_ns.filter(|_| gap.is_none_or(|gap| gap >= Ns::ZERO));
        let echo = echo.map(|now| self.echoes.step(frame, now, resolution_ns));
        if let Some(echo) = echo.filter(|echo| *echo != Sighting::Original && happened.sighting != Sighting::Duplicate)
        {
            // It was on the bus once, and shows nothing about the recording.
            if echo == Sighting::Duplicate {
                happened.sighting = echo;
            }
            return self.place(frame, happened);
        }
        let mut silent_ns = Ns::ZERO;
        if let Some(now) = frame.t_ns {
            self.resolution.follow(frame, (now, gap, wire_ns), happened.sighting);
            happened.step = self.step_of_clock(now);
            if happened.step.is_some() || self.last_ns.is_none() {
                self.holes.start(now);
            }
            silent_ns = gap.map_or(Ns::ZERO, |gap| gap.max(Ns::ZERO));
            if let Some(last) = self.last_ns.filter(|_| silent_ns > SHORTEST_STALL_NS) {
                happened.silence = Some(Box::new(self.measure(last, now)));
                if !self.duplicates.are_proven() && self.duplicates.is_decided() {
                    let unusual = self.stalls.is_unusual(silent_ns);
                    self.holes.begin(frame, (last, now, unusual), &self.stalls, resolution_ns);
                }
            }
            let original = happened.sighting == Sighting::Original;
            let too_close = (close, resolution_ns < wire_ns, resolution_ns);
            let missed = self.stalls.follow(frame, (self.last_ns, now, silent_ns), happened.sighting, too_close);
            // A recording that shows frames twice does not lose them.
            let missed = missed.filter(|_| original && resolution_ns < LATE_NS);
            self.single.follow(frame, missed);
            self.last_ns = Some(now);
            self.clock.first_ns = self.clock.first_ns.or(Some(now));
            self.clock.latest_ns = Some(self.clock.latest_ns.map_or(now, |latest| latest.max(now)));
        }
        self.stalls.decide_shown(&self.duplicates);
        if let Some(now) = frame.t_ns {
            self.holes.follow(frame, now, &self.stalls);
        }
        if silent_ns > DRAIN_NS {
            self.silence_ns = silent_ns;
        }
        self.place(frame, happened)
    }

    /// Returns the place of a frame, with the events there.
    fn place(&self, frame: &Frame, happened: Happened) -> RecordedFrame {
        let (at, epoch, burst) = (frame.reference(), self.clock.steps, self.stalls.running());
        let when = When { at, epoch, burst, own: false, silent_ns: self.silence_ns };
        RecordedFrame { when, happened: (happened != Happened::default()).then(|| Box::new(happened)) }
    }

    /// Takes an observed frame and completes its place. `commands`: a master sends such frames (SDO requests, NMT,
    /// SYNC, TIME, RPDOs, remote frames, LSS requests), and the recording host may be the master.
    pub fn take(&mut self, when: &mut When, happened: Option<&Happened>, frame: &Frame, commands: bool) {
        if let Some(silence) = happened.and_then(|happened| happened.silence.as_ref()) {
            self.silence = Some(**silence);
        }
        self.taken_ns = frame.t_ns.or(self.taken_ns);
        self.others |= !SDO_REQUESTS.contains(&frame.id.raw()) || frame.id.is_extended();
        self.several |= *self.only.get_or_insert(frame.id) != frame.id;
        when.own = match frame.dir {
            Some(direction) => direction == Direction::Tx,
            None => commands || frame.kind == Kind::Remote,
        };
        when.epoch = when.epoch.saturating_add(self.losses);
    }

    /// Records that an SDO client goes on as if answered.
    pub fn client_goes_on(&mut self) {
        self.goes_on = true;
    }

    /// Records that the capture has the answer of an SDO server to a request.
    pub fn shows_answer_of(&mut self, node: u8) {
        self.answering |= 1 << (node & 0x7F);
    }

    /// Returns true if the capture has answers of other SDO servers than that of a node.
    pub fn has_answers_beside(&self, node: u8) -> bool {
        self.answering & !(1 << (node & 0x7F)) != 0
    }

    /// Returns true if the capture would contain the answers to requests of SDO clients: it has other frames than such
    /// requests, or none that follows from an answer.
    pub fn contains_answers(&self) -> bool {
        self.others || !self.goes_on
    }

    /// Returns true if the capture has more than one CAN-ID so far, so that no filter has reduced it to one.
    pub fn shows_several(&self) -> bool {
        self.several
    }

    /// Returns the final sighting of a frame when it is taken. Buffered frames are close to equal ones for that reason
    /// only.
    pub fn sighting(&self, at: FrameRef, observed: Sighting) -> Sighting {
        let near_burst = |at_ns| self.stalls.is_near_confirmed(at_ns, super::duplicates::APART_NS);
        if self.echoes.has_found(at.no) {
            return Sighting::Duplicate;
        }
        match self.duplicates.decided(at.no, observed) {
            Sighting::Suspect if at.t_ns.is_some_and(near_burst) => Sighting::Original,
            decided => decided,
        }
    }

    /// Returns true if nothing is open about any frame so far.
    #[inline]
    pub fn is_decided(&self) -> bool {
        let (duplicates, stalls) = (&self.duplicates, &self.stalls);
        duplicates.is_decided()
            && stalls.undecided_since().is_none()
            && self.holes.undecided_since().is_none()
            && self.single.undecided_since().is_none()
            && self.echoes.undecided_since().is_none()
    }

    /// Returns the number of the first frame about which something is open.
    pub fn undecided_since(&self) -> Option<u64> {
        let (stalls, duplicates) = (self.stalls.undecided_since(), self.duplicates.undecided_since());
        let (holes, losses) = (self.holes.undecided_since(), self.single.undecided_since());
        let echoes = self.echoes.undecided_since();
        [stalls, duplicates, holes, losses, echoes].into_iter().flatten().min()
    }

    /// Decides everything that is open by the evidence so far, since no further frames are there. `over`: none will
    /// follow.
    pub fn settle(&mut self, over: bool) {
        self.duplicates.settle(over);
        self.echoes.settle();
        self.stalls.settle(&self.duplicates);
        self.holes.settle();
        self.single.settle();
    }

    /// Returns true if a frame is the first one after an unannounced hole of the recording.
    #[inline]
    pub fn is_behind_hole(&self, number: u64) -> bool {
        self.holes.is_behind(number)
    }

    /// Returns the number of missing frames and of those that were due, if a frame is the first by which it is shown that
    /// frames were lost one by one.
    #[inline]
    pub fn losses_shown_at(&self, number: u64) -> Option<(u64, u64)> {
        self.single.shown_at(number)
    }

    /// Records that a step of an SDO exchange may be missing, which a finding is about; `sent`: it was certainly sent.
    /// Returns the frame from which the finding follows, if it is known that frames were lost one by one.
    pub fn lacks_step(&mut self, finding: &Finding, sent: bool) -> Option<FrameRef> {
        self.single.lacks_step(finding, sent)
    }

    /// Returns the frame from which a finding follows, if frames that were lost one by one explain it.
    pub fn explain_by_losses(&mut self, finding: &Finding) -> Option<FrameRef> {
        self.single.explain(finding)
    }

    /// Returns true if a frame is the first one after a stall of the recorder.
    pub fn is_first_of_stall(&self, when: When) -> bool {
        self.stalls.is_first_of_confirmed(when.burst, when.at.no)
    }

    /// Returns the place of something without a frame: the end of the capture, or a time without a frame.
    pub fn at(&self, at: FrameRef) -> When {
        let burst = self.stalls.running();
        let at = FrameRef { t_ns: at.t_ns.filter(|_| self.resolution.is_of_use()), ..at };
        When { at, epoch: self.clock.steps.saturating_add(self.losses), burst, ..When::default() }
    }

    /// Advances to `now_ns` without a frame and decides a burst that has ended by then.
    pub fn advance(&mut self, now_ns: Ns) {
        self.duplicates.advance(now_ns);
        self.echoes.advance(now_ns);
        self.stalls.advance(self.last_ns, now_ns, &self.duplicates);
        self.holes.advance(now_ns);
        self.single.advance(now_ns);
    }

    /// Records a loss of frames before those that were observed but not taken.
    pub fn lost(&mut self) {
        self.losses = self.losses.saturating_add(1);
        if self.taken_ns == self.last_ns {
            self.last_ns = None;
            self.stalls.end_burst();
        }
        (self.taken_ns, self.silence) = (None, None);
    }

    /// Records an exchange whose frames are `apart_ns` apart; `in_order`: its request is listed before the answer.
    pub fn exchanged(&mut self, apart_ns: Ns, in_order: bool) {
        let shortest_ns = if self.echo.exchanges == 0 { apart_ns } else { self.echo.shortest_ns.min(apart_ns) };
        self.echo.shortest_ns = if in_order { shortest_ns } else { self.echo.shortest_ns };
        self.echo.exchanges = self.echo.exchanges.saturating_add(1);
        if in_order {
            self.echo.prompt = self.echo.prompt.saturating_add(u32::from(apart_ns < LEAST_ECHO_NS));
        } else {
            self.echo.latest_ns = self.echo.latest_ns.max(apart_ns.min(LATEST_ECHO_NS));
        }
    }

    /// Returns the resolution of the stamps in ns; at least 1.
    pub fn resolution_ns(&self) -> Ns {
        self.resolution.ns()
    }

    /// Returns the maximum delay with which own frames are listed, in ns.
    pub fn lag_ns(&self) -> Ns {
        if self.echo.exchanges < EXCHANGES {
            return LATEST_ECHO_NS;
        }
        // The largest delay so far is rarely the largest of all.
        (self.echo.latest_ns * 2).clamp(LEAST_ECHO_NS, LATEST_ECHO_NS)
    }

    /// Returns true if the capture lists own frames when they are sent, as far as its exchanges show.
    pub fn lists_in_order(&self) -> bool {
        self.echo.exchanges >= IN_ORDER && self.echo.latest_ns == Ns::ZERO
    }

    /// Returns true if own frames are less than a time away from their place, which is the same for all of them: as far as its
    /// exchanges show, none is listed late, and none is stamped early by more than its answer came.
    pub fn is_closer_than(&self, shift_ns: Ns) -> bool {
        self.echo.exchanges >= FEW_IN_ORDER && self.echo.latest_ns == Ns::ZERO && self.echo.shortest_ns < shift_ns
    }

    /// Returns true if the host lists own frames in time for the most part: single ones may be late all the same.
    pub fn lists_promptly(&self) -> bool {
        self.echo.prompt >= IN_ORDER && self.echo.latest_ns == Ns::ZERO
    }

    /// Returns true if the time of a frame shows something about its sender; frames of a burst may have any time.
    pub fn teaches(&self, when: When) -> bool {
        when.at.t_ns.is_some() && !matches!(self.verdict(when.burst), Some(Verdict::Open | Verdict::Confirmed))
    }

    /// Returns true if the capture shows its frames twice.
    pub fn shows_duplicates(&self) -> bool {
        self.duplicates.are_proven()
    }

    /// Returns true if the capture is known to show each frame once.
    pub fn shows_once(&self) -> bool {
        self.duplicates.are_refuted()
    }

    /// Returns the accuracy of the stamps that the user gives, in ns.
    pub fn stated_jitter_ns(&self) -> Option<Ns> {
        self.jitter_ns
    }

    /// Returns the possible lateness of a frame's stamp in ns: at most the preceding silence of the bus, since delayed
    /// frames are stamped in a row. 0 if the user gives the accuracy.
    pub fn lateness_ns(&self, when: When) -> Ns {
        if self.jitter_ns.is_some() { Ns::ZERO } else { when.silent_ns }
    }

    /// Returns the same, limited to the part that may shorten a time of `apart_ns` to the next frame.
    pub fn shortens_ns(&self, when: When, apart_ns: Ns) -> Ns {
        self.lateness_ns(when).min(LATE_NS.max(apart_ns / LATE_PART))
    }

    /// Returns the earliest and the latest time at which a frame was on the bus, in ns.
    pub fn interval(&self, when: When) -> (Ns, Ns) {
        let Some(stamp) = when.at.t_ns else { return (Ns::MIN, Ns::MAX) };
        let uncertain = self.jitter_ns.unwrap_or_else(|| self.resolution_ns());
        let echo = if when.own { self.lag_ns() } else { Ns::ZERO };
        let earliest = stamp - (uncertain + echo);
        match self.stalls.since_ns(when.burst) {
            Some(from_ns) => (from_ns.min(earliest), stamp),
            None => (earliest, stamp),
        }
    }

    /// Returns true if an own frame that was on the bus before `since` must have been listed by `now`.
    pub fn is_settled(&self, since: FrameRef, now: FrameRef) -> bool {
        match since.t_ns.zip(now.t_ns) {
            Some((since_ns, now_ns)) => now.no > since.no && !(Ns::ZERO..LATEST_ECHO_NS).contains(&(now_ns - since_ns)),
            None => now.no > since.no + LATEST_ECHO_FRAMES,
        }
    }

    /// Returns true if certainly more than `limit_ns` lies between two frames.
    pub fn certainly_later(&self, now: When, since: When, limit_ns: Ns) -> bool {
        let ((earliest, _), (_, latest)) = (self.interval(now), self.interval(since));
        now.epoch == since.epoch && earliest - latest > limit_ns
    }

    /// Returns true if certainly less than `limit_ns` lies between two frames.
    pub fn certainly_within(&self, now: When, since: When, limit_ns: Ns) -> bool {
        let ((_, latest), (earliest, _)) = (self.interval(now), self.interval(since));
        now.epoch == since.epoch && latest - earliest < limit_ns
    }

    /// Returns true if a frame may have been on the bus before another, whatever their order in the list.
    pub fn may_precede(&self, one: When, other: When) -> bool {
        if one.epoch != other.epoch || one.at.t_ns.is_none() {
            return one.at.no < other.at.no;
        }
        let ((earliest, _), (_, latest)) = (self.interval(one), self.interval(other));
        earliest <= latest
    }

    /// Returns true if an equal frame was sent again and is not a duplicate of the earlier one.
    pub fn is_sent_again(&self, before: FrameRef, now: FrameRef) -> bool {
        before.t_ns.zip(now.t_ns).is_some_and(|(before, now)| now - before > super::duplicates::APART_NS)
    }

    /// Returns the time between two frames by their stamps, in ns; `None` without stamps or across a gap.
    pub fn between(&self, since: When, now: When) -> Option<Ns> {
        if since.epoch != now.epoch {
            return None;
        }
        Some(now.at.t_ns? - since.at.t_ns?)
    }

    /// Returns the last stall of the recorder: its end, as a frame's time, and its length, in ns.
    pub fn stalled(&self) -> Option<(Ns, Ns)> {
        let (from_ns, to_ns) = self.stalls.last_stall()?;
        Some((to_ns, to_ns - from_ns))
    }

    /// Returns the last silence of the whole bus that concerns a verdict; it may still last at `now_ns`.
    pub fn silence(&self, now_ns: Ns) -> Option<Silence> {
        match self.taken_ns {
            Some(from_ns) if now_ns - from_ns > SHORTEST_STALL_NS => Some(self.measure(from_ns, now_ns)),
            _ => self.silence,
        }
    }

    /// Returns true if a node's obligation fell due at `fell_ns`, in a silence of the whole bus (perhaps still lasting
    /// at `now_ns`) that is not the node's own fault. `period_ns`: the period of the obligation.
    pub fn was_silent(&self, node: u8, fell_ns: Ns, period_ns: Ns, now_ns: Ns) -> bool {
        let holds = |one: &Silence| (one.from_ns..=one.to_ns).contains(&fell_ns) && one.is_of_all(node, period_ns);
        self.silence(now_ns).is_some_and(|silence| holds(&silence))
    }

    /// Returns the silence of the whole bus that a frame ended at `now_ns`, if it concerns a verdict.
    #[inline]
    pub fn ended_silence(&self, now_ns: Ns) -> Option<&Silence> {
        self.silence.as_ref().filter(|silence| silence.to_ns == now_ns)
    }

    fn measure(&self, from_ns: Ns, to_ns: Ns) -> Silence {
        let missing = |tenths: i64| self.stalls.missing(from_ns, to_ns, tenths);
        let (missing, paused) = (missing(UNUSUAL_TENTHS), missing(TWO_PERIODS_TENTHS));
        let others = self.stalls.others_missed(from_ns, to_ns);
        Silence { from_ns, to_ns, missing, paused, others, odd: self.stalls.is_odd(to_ns - from_ns) }
    }

    /// Returns the verdict on a burst; `None` for none, or for one forgotten after its verdict.
    pub fn verdict(&self, burst: u32) -> Option<Verdict> {
        self.stalls.verdict(burst)
    }

    fn step_of_clock(&mut self, now: Ns) -> Option<ClockStep> {
        let first = self.clock.first_ns?;
        let back = self.clock.latest_ns? - now;
        if back < CLOCK_STEP_NS {
            return None;
        }
        self.clock.steps = self.clock.steps.saturating_add(1);
        (self.clock.first_ns, self.clock.latest_ns) = (None, None);
        self.stalls.end_burst();
        Some(if back >= ANOTHER_NS || now <= first { ClockStep::NewRecording } else { ClockStep::Set })
    }

    /// Returns true if a frame at this time ends a silence of the bus longer than recent ones.
    pub fn is_unusual_silence(&self, now_ns: Option<Ns>) -> bool {
        let silence_ns = now_ns.zip(self.last_ns).map(|(now, last)| now - last);
        silence_ns.is_some_and(|silence_ns| self.stalls.is_unusual(silence_ns))
    }

    /// Returns the time of the last frame of the bus, in ns.
    pub fn last_ns(&self) -> Option<Ns> {
        self.last_ns
    }
}
