//! Assigns the answers of LSS slaves to the requests of the master (CiA 305).
//!
//! LSS frames carry no number, so only the last request of each kind is kept. Verdicts are given in `checks::lss`.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::sdo::limits::UNANSWERED_NS;
use crate::wire::lss::{Bound, Command, LssSetting, Part};

/// Maximum number of kept answers that may have been captured before their request.
const EARLY: usize = 8;
/// Maximum time to an answer of a slave that writes its memory, in ns.
const STORE_NS: Ns = Ns::from_s(5);

/// A kind of request that is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// 43, answered by 44.
    Selective,
    /// 4B or a Fastscan step, answered by 4F of every matching slave.
    Identify,
    /// 4C, answered by 50 of every slave without node-ID.
    NonConfigured,
    /// 11.
    NodeId,
    /// 13, answered by every slave in the configuration state.
    BitTiming,
    /// 17, answered like 13.
    Store,
    /// 5A.
    InquireVendor,
    /// 5B.
    InquireProduct,
    /// 5C.
    InquireRevision,
    /// 5D.
    InquireSerial,
    /// 5E.
    InquireNodeId,
}

/// Number of kinds.
const KINDS: usize = 11;

impl Exchange {
    /// Returns the kind of a master's command.
    pub fn asked_by(command: Command) -> Option<Self> {
        match command {
            Command::SwitchSelective { part: Part::Serial, .. } => Some(Self::Selective),
            Command::Identify { bound: Bound::SerialHigh, .. } | Command::Fastscan { .. } => Some(Self::Identify),
            Command::IdentifyNonConfigured => Some(Self::NonConfigured),
            Command::ConfigureNodeId { .. } => Some(Self::NodeId),
            Command::ConfigureBitTiming { .. } => Some(Self::BitTiming),
            Command::Store => Some(Self::Store),
            Command::Inquire { part } => Some(Self::inquires(part)),
            Command::InquireNodeId => Some(Self::InquireNodeId),
            _ => None,
        }
    }

    /// Returns the kind of a slave's answer.
    pub fn answered_by(command: Command) -> Option<Self> {
        match command {
            Command::SwitchSelectiveResponse => Some(Self::Selective),
            Command::IdentifySlave => Some(Self::Identify),
            Command::IdentifyNonConfiguredSlave => Some(Self::NonConfigured),
            Command::Confirmation { of: LssSetting::NodeId, .. } => Some(Self::NodeId),
            Command::Confirmation { of: LssSetting::BitTiming, .. } => Some(Self::BitTiming),
            Command::Confirmation { of: LssSetting::Store, .. } => Some(Self::Store),
            Command::InquireResponse { part, .. } => Some(Self::inquires(part)),
            Command::InquireNodeIdResponse { .. } => Some(Self::InquireNodeId),
            _ => None,
        }
    }

    fn inquires(part: Part) -> Self {
        match part {
            Part::Vendor => Self::InquireVendor,
            Part::Product => Self::InquireProduct,
            Part::Revision => Self::InquireRevision,
            Part::Serial => Self::InquireSerial,
        }
    }

    /// Returns the command specifier of the request, or that of the answer if the request has two.
    pub fn specifier(self) -> u8 {
        match self {
            Self::Selective => 0x43,
            Self::Identify => 0x4F,
            Self::NonConfigured => 0x4C,
            Self::NodeId => 0x11,
            Self::BitTiming => 0x13,
            Self::Store => 0x17,
            Self::InquireVendor => 0x5A,
            Self::InquireProduct => 0x5B,
            Self::InquireRevision => 0x5C,
            Self::InquireSerial => 0x5D,
            Self::InquireNodeId => 0x5E,
        }
    }

    /// Returns the command specifier of the answer.
    pub fn answer(self) -> u8 {
        match self {
            Self::Selective => 0x44,
            Self::NonConfigured => 0x50,
            _ => self.specifier(),
        }
    }

    /// Returns true if only slaves in the configuration state take it.
    pub fn configures(self) -> bool {
        !matches!(self, Self::Selective | Self::Identify | Self::NonConfigured)
    }

    /// Returns true if several slaves may answer: all that match, or, for a bit timing and its storage, all that were
    /// switched to configuration together.
    pub fn is_shared(self) -> bool {
        matches!(self, Self::Identify | Self::NonConfigured | Self::BitTiming | Self::Store)
    }

    /// Returns the maximum time to the answer, in ns.
    pub fn limit_ns(self) -> Ns {
        if self == Self::Store { STORE_NS } else { UNANSWERED_NS }
    }
}

/// The last request of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Its frame.
    pub at: FrameRef,
    /// Number of outstanding answers; more than one if the master has repeated the request.
    pub owed: u32,
    /// It was answered, or the request was that it repeats.
    pub answered: bool,
    /// Its unused bytes are 0.
    pub plain: bool,
    /// A slave is known to be in the configuration state.
    pub certain: bool,
    /// The missing answer was reported, or is no fault.
    pub settled: bool,
    /// The last unneeded answer, which may belong to the next request and be captured before it.
    pub surplus: Option<FrameRef>,
    /// An answer captured before it that may be a duplicate of the one before.
    pub early: Option<Early>,
}

impl Asked {
    /// Returns true if its answer is outstanding and would be missed.
    fn owes(&self) -> bool {
        self.owed > 0 && !self.settled && self.early.is_none()
    }
}

/// An answer without an earlier request.
#[derive(Clone, Copy, Debug)]
pub struct Early {
    /// Its frame.
    pub at: FrameRef,
    /// Its kind.
    pub exchange: Exchange,
    /// The command.
    pub command: Command,
    /// Its unused bytes are 0.
    pub plain: bool,
    /// It may be a second capture of the slave's previous frame.
    pub repeats: bool,
    /// The master has sent something else since.
    pub passed: bool,
}

/// The requests of a master.
#[derive(Debug, Default)]
pub struct Exchanges {
    asked: [Option<Asked>; KINDS],
    early: Vec<Early>,
    /// Maximum delay with which the recording lists the master's frames, in ns.
    pub lag_ns: Ns,
    /// Number of the master's frames since the capture's start or last gap, and the last of them.
    seen: u64,
    last: Option<FrameRef>,
    /// The last unreadable frame of the master, until an answer without other request uses it.
    unreadable: Option<FrameRef>,
}

impl Exchanges {
    /// Takes a frame of the master, which opens a request of the kind `next`; returns the early answers to it, and
    /// those without request. Others wait for frames of the master that are listed late as well.
    pub fn settle(&mut self, next: Option<Exchange>, at: FrameRef) -> (Vec<Early>, Vec<Early>) {
        (self.seen, self.last) = (self.seen.saturating_add(1), Some(at));
        let (mut own, mut others) = (Vec::new(), Vec::new());
        for early in std::mem::take(&mut self.early) {
            let near = close(early.at, at, self.lag_ns);
            // One slave answers a request; its next answer belongs to the next request.
            let further = own.iter().any(|one: &Early| !one.repeats) && !early.repeats && !early.exchange.is_shared();
            if near && Some(early.exchange) == next && !further {
                own.push(early);
            } else if near && at.t_ns.is_some() {
                self.early.push(Early { passed: true, ..early });
            } else {
                others.push(early);
            }
        }
        (own, others)
    }

    /// Returns the early answers after which the master has gone on, at the end of the capture.
    pub fn left(&mut self) -> Vec<Early> {
        std::mem::take(&mut self.early).into_iter().filter(|early| early.passed).collect()
    }

    /// Adds a request.
    pub fn open(&mut self, exchange: Exchange, request: Asked) {
        if let Some(slot) = self.asked.get_mut(exchange as usize) {
            let before = slot.map_or(0, |before| before.owed);
            let again = slot.is_some_and(|before| {
                let early = before.surplus.is_some_and(|answer| close(answer, request.at, self.lag_ns));
                early || before.at.no + 2 >= request.at.no && before.answered
            });
            *slot = Some(Asked { owed: before.saturating_add(1), answered: again, ..request });
        }
    }

    /// Returns true if an answer of this kind has a request.
    pub fn explains(&self, exchange: Exchange) -> bool {
        self.get(exchange).is_some_and(|asked| asked.owed > 0 || exchange.is_shared())
    }

    /// Returns true if answers to a request of this kind may still come at `at`.
    pub fn is_recent(&self, exchange: Exchange, at: FrameRef) -> bool {
        self.get(exchange).is_some_and(|asked| match (asked.at.t_ns, at.t_ns) {
            (Some(asked), Some(at)) => at - asked <= exchange.limit_ns(),
            _ => true,
        })
    }

    /// Assigns the answer at `at` to its request and returns that.
    pub fn answered(&mut self, exchange: Exchange, at: FrameRef) -> Option<Asked> {
        let asked = self.asked.get_mut(exchange as usize)?.as_mut()?;
        asked.surplus = (asked.owed == 0).then_some(at);
        asked.owed = asked.owed.saturating_sub(1);
        asked.answered = true;
        if exchange.is_shared() {
            asked.owed = 0;
        }
        Some(*asked)
    }

    /// Removes the early answer of an open request, because the master goes on or the request is answered.
    pub fn take_early(&mut self, exchange: Exchange) -> Option<Early> {
        self.asked.get_mut(exchange as usize)?.as_mut()?.early.take()
    }

    /// Removes an early answer of any kind.
    pub fn take_any_early(&mut self) -> Option<Early> {
        self.asked.iter_mut().flatten().find_map(|asked| asked.early.take())
    }

    /// Keeps an answer whose request may follow, except at the start of the capture, which may lack its request.
    pub fn hold(&mut self, early: Early) {
        if self.seen >= 2 && self.early.len() < EARLY {
            self.early.push(early);
        }
    }

    /// Removes and returns early answers whose request has not followed.
    pub fn stale(&mut self, now_ns: Ns) -> Vec<Early> {
        let kept = |early: &Early| early.at.t_ns.is_none_or(|at| now_ns - at <= self.lag_ns);
        if self.early.iter().all(kept) {
            return Vec::new();
        }
        let (kept, stale) = std::mem::take(&mut self.early).into_iter().partition(kept);
        self.early = kept;
        stale
    }

    /// Returns a request that was not answered in time.
    pub fn overdue(&mut self, now_ns: Ns) -> Option<(Exchange, Asked)> {
        let late =
            |asked: &Asked, exchange: Exchange| asked.at.t_ns.is_some_and(|at| at + exchange.limit_ns() <= now_ns);
        OWING.iter().find_map(|exchange| {
            let asked = self.asked.get_mut(*exchange as usize)?.as_mut()?;
            // An answer that may belong to an earlier request shows that a slave is there.
            let due = asked.owes() && !asked.answered && late(asked, *exchange);
            due.then(|| settled(asked, *exchange))
        })
    }

    /// Returns the open request of a kind, whose answer the master no longer waits for.
    pub fn give_up(&mut self, exchange: Exchange) -> Option<Asked> {
        let asked = self.asked.get_mut(exchange as usize)?.as_mut()?;
        asked.owes().then(|| settled(asked, exchange).1)
    }

    /// Returns an unanswered request to a selected slave after which the master has gone on. `now` is a frame by which
    /// a sent answer would be in the capture.
    pub fn overtaken(&mut self, now: FrameRef) -> Option<(Exchange, Asked)> {
        let (next, lag_ns) = (self.last?, self.lag_ns);
        let over = |asked: FrameRef| asked.no < next.no && !close(asked, now, lag_ns);
        self.unanswered(over)
    }

    /// Returns one before the request `next`, which a slave has answered: slaves take requests in order.
    pub fn passed_over(&mut self, next: FrameRef) -> Option<(Exchange, Asked)> {
        self.unanswered(|asked| asked.no < next.no)
    }

    fn unanswered(&mut self, over: impl Fn(FrameRef) -> bool) -> Option<(Exchange, Asked)> {
        // An answer that waits for its request may be the outstanding one, with a wrong specifier.
        let waits = self.early.iter().map(|early| early.at.no).max().unwrap_or(0);
        let over = |asked: FrameRef| over(asked) && asked.no > waits;
        OWING.iter().filter(|exchange| exchange.configures()).find_map(|exchange| {
            let asked = self.asked.get_mut(*exchange as usize)?.as_mut()?;
            let open = asked.owes() && !asked.answered && asked.certain;
            (open && over(asked.at)).then(|| settled(asked, *exchange))
        })
    }

    /// Takes an unreadable frame, which may be any answer, or any request if `request`.
    pub fn unreadable(&mut self, request: bool, at: FrameRef) {
        if request {
            self.unreadable = Some(at);
        }
        self.excuse();
    }

    /// Returns true once if an unreadable frame of the master may have been the request of an answer.
    pub fn may_be_requested(&mut self, answer: FrameRef) -> bool {
        self.unreadable.take().is_some_and(|request| request.no < answer.no)
    }

    /// Forgets everything but unreadable frames after lost frames.
    pub fn lost(&mut self) {
        *self = Self { lag_ns: self.lag_ns, unreadable: self.unreadable, ..Self::default() };
    }

    /// Takes an unreadable answer, which may be an outstanding one.
    pub fn excuse(&mut self) {
        for asked in self.asked.iter_mut().flatten().filter(|asked| asked.owed > 0) {
            asked.answered = true;
        }
    }

    /// Drops all outstanding answers: slaves were reset, or change their bit rate.
    pub fn forgive(&mut self) {
        for asked in self.asked.iter_mut().flatten() {
            asked.settled = true;
        }
    }

    /// Returns the time of the next deadline, in ns.
    pub fn due(&self) -> Option<Ns> {
        let open = OWING.iter().filter_map(|exchange| {
            let asked = self.get(*exchange).filter(|asked| asked.owes() && !asked.answered)?;
            Some(asked.at.t_ns? + exchange.limit_ns())
        });
        let early = self.early.iter().filter_map(|early| Some(early.at.t_ns? + (self.lag_ns + Ns(1))));
        open.chain(early).min()
    }

    fn get(&self, exchange: Exchange) -> Option<&Asked> {
        self.asked.get(exchange as usize)?.as_ref()
    }
}

fn settled(asked: &mut Asked, exchange: Exchange) -> (Exchange, Asked) {
    asked.settled = true;
    (exchange, *asked)
}

/// The kinds whose answer is owed by one slave.
const OWING: [Exchange; 9] = [
    Exchange::Selective,
    Exchange::NodeId,
    Exchange::BitTiming,
    Exchange::Store,
    Exchange::InquireVendor,
    Exchange::InquireProduct,
    Exchange::InquireRevision,
    Exchange::InquireSerial,
    Exchange::InquireNodeId,
];

/// Returns true if only slaves in the configuration state take a command.
pub fn configures(command: Command) -> bool {
    Exchange::asked_by(command).is_some_and(Exchange::configures)
        || matches!(command, Command::ActivateBitTiming { .. })
}

/// Returns the command specifier of a configuration command.
pub fn specifier(command: Command) -> u8 {
    Exchange::asked_by(command).map_or(0x15, Exchange::specifier)
}

/// Returns true if an answer may belong to a request that follows it. `lag_ns`: maximum delay with which the recording
/// lists the host's own frames.
pub fn close(answer: FrameRef, request: FrameRef, lag_ns: Ns) -> bool {
    request.since(answer).is_none_or(|age| (Ns::ZERO..=lag_ns).contains(&age))
}
