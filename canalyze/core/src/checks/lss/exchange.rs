//! Requests of an LSS master and the answers that slaves owe or give (CiA 305): which belongs to which.
//!
//! Of each kind only the last request is kept: LSS frames carry no number. It must not
//! judge what a request without answer, or an answer without request, means.

use crate::frame::FrameRef;
use crate::wire::lss::{Bound, Command, Part, Setting};

/// Answers kept that may have been captured before their request.
const EARLY: usize = 8;
/// How long an answer may take: 1 s, the time-out of CANopenNode's master, the longest of those known.
const ANSWER_NS: i64 = 1_000_000_000;
/// The same where a slave writes its memory.
const STORE_NS: i64 = 5_000_000_000;

/// The kinds of request that are answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// 43, answered by 44.
    Selective,
    /// 4B or a Fastscan step, answered by 4F of every slave that matches.
    Identify,
    /// 4C, answered by 50 of every slave without node-ID.
    NonConfigured,
    /// 11.
    NodeId,
    /// 13, of every slave in the configuration state.
    BitTiming,
    /// 17, likewise.
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

/// How many kinds there are.
const KINDS: usize = 11;

impl Exchange {
    /// The kind of a master's command.
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

    /// The kind of a slave's answer.
    pub fn answered_by(command: Command) -> Option<Self> {
        match command {
            Command::SwitchSelectiveResponse => Some(Self::Selective),
            Command::IdentifySlave => Some(Self::Identify),
            Command::IdentifyNonConfiguredSlave => Some(Self::NonConfigured),
            Command::Confirmation { of: Setting::NodeId, .. } => Some(Self::NodeId),
            Command::Confirmation { of: Setting::BitTiming, .. } => Some(Self::BitTiming),
            Command::Confirmation { of: Setting::Store, .. } => Some(Self::Store),
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

    /// The command specifier of the request; where there are two, that of the answer.
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

    /// The command specifier of the answer.
    pub fn answer(self) -> u8 {
        match self {
            Self::Selective => 0x44,
            Self::NonConfigured => 0x50,
            _ => self.specifier(),
        }
    }

    /// Whether only slaves in the configuration state take it.
    pub fn configures(self) -> bool {
        !matches!(self, Self::Selective | Self::Identify | Self::NonConfigured)
    }

    /// Whether several slaves may answer: all of them that match, or, to a bit timing and its storage, all of them
    /// that were switched to configuration together.
    pub fn is_shared(self) -> bool {
        matches!(self, Self::Identify | Self::NonConfigured | Self::BitTiming | Self::Store)
    }

    /// How long the answer may take, in ns.
    pub fn limit_ns(self) -> i64 {
        if self == Self::Store { STORE_NS } else { ANSWER_NS }
    }
}

/// The last request of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Its frame.
    pub at: FrameRef,
    /// Answers owed: more than one where the master has repeated it.
    pub owed: u32,
    /// Somebody has answered it, or the one before that it repeats.
    pub answered: bool,
    /// Its unused bytes are 0.
    pub plain: bool,
    /// A slave is known to be in the configuration state.
    pub certain: bool,
    /// It was reported that it is not answered, or that is no fault.
    pub settled: bool,
    /// The last answer to it that was not owed any more: it may be one to the next request, captured before that.
    pub surplus: Option<FrameRef>,
    /// An answer captured before it that may be a duplicate of the one before.
    pub early: Option<Early>,
}

impl Asked {
    /// Whether it is still to be answered, and a finding if it is not.
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
    /// It may be the slave's frame before, captured twice.
    pub repeats: bool,
    /// The master has gone on since, with something else.
    pub passed: bool,
}

/// The requests of a master.
#[derive(Debug, Default)]
pub struct Exchanges {
    asked: [Option<Asked>; KINDS],
    early: Vec<Early>,
    /// How late the recording lists the master's frames at most, in ns.
    pub lag_ns: i64,
    /// Master's frames seen since the capture began, or since the last gap, and the last of them.
    seen: u64,
    last: Option<FrameRef>,
    /// The last frame of the master that could not be read, until an answer that has no other request.
    unreadable: Option<FrameRef>,
}

impl Exchanges {
    /// A frame of the master at `at`, which opens a request of the kind `next`. Early answers are settled: those to
    /// it, and those to nothing. Others wait for the frames of the master that are listed late as well.
    pub fn settle(&mut self, next: Option<Exchange>, at: FrameRef) -> (Vec<Early>, Vec<Early>) {
        (self.seen, self.last) = (self.seen.saturating_add(1), Some(at));
        let (mut own, mut others) = (Vec::new(), Vec::new());
        for early in std::mem::take(&mut self.early) {
            let near = close(early.at, at, self.lag_ns);
            // One slave answers a request, and the next answer is that to the next one.
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

    /// The capture is over: early answers after which the master has gone on.
    pub fn left(&mut self) -> Vec<Early> {
        std::mem::take(&mut self.early).into_iter().filter(|early| early.passed).collect()
    }

    /// A request.
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

    /// Whether an answer of this kind has a request.
    pub fn explains(&self, exchange: Exchange) -> bool {
        self.get(exchange).is_some_and(|asked| asked.owed > 0 || exchange.is_shared())
    }

    /// Whether a request of this kind was seen so shortly before `at` that answers to it may still come.
    pub fn is_recent(&self, exchange: Exchange, at: FrameRef) -> bool {
        self.get(exchange).is_some_and(|asked| match (asked.at.t_ns, at.t_ns) {
            (Some(asked), Some(at)) => at.saturating_sub(asked) <= exchange.limit_ns(),
            _ => true,
        })
    }

    /// The request that the answer at `at` belongs to; it owes one less.
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

    /// Takes the early answer that an open request may have: the master goes on, or the request is answered.
    pub fn take_early(&mut self, exchange: Exchange) -> Option<Early> {
        self.asked.get_mut(exchange as usize)?.as_mut()?.early.take()
    }

    /// The same of any kind.
    pub fn take_any_early(&mut self) -> Option<Early> {
        self.asked.iter_mut().flatten().find_map(|asked| asked.early.take())
    }

    /// Keeps an answer whose request may follow. Right at the capture's beginning its request is just not captured.
    pub fn hold(&mut self, early: Early) {
        if self.seen >= 2 && self.early.len() < EARLY {
            self.early.push(early);
        }
    }

    /// Early answers whose request has not followed.
    pub fn stale(&mut self, now_ns: i64) -> Vec<Early> {
        let kept = |early: &Early| early.at.t_ns.is_none_or(|at| now_ns.saturating_sub(at) <= self.lag_ns);
        if self.early.iter().all(kept) {
            return Vec::new();
        }
        let (kept, stale) = std::mem::take(&mut self.early).into_iter().partition(kept);
        self.early = kept;
        stale
    }

    /// A request that is not answered in time.
    pub fn overdue(&mut self, now_ns: i64) -> Option<(Exchange, Asked)> {
        let late = |asked: &Asked, exchange: Exchange| {
            asked.at.t_ns.is_some_and(|at| at.saturating_add(exchange.limit_ns()) <= now_ns)
        };
        OWING.iter().find_map(|exchange| {
            let asked = self.asked.get_mut(*exchange as usize)?.as_mut()?;
            // An answer that may be that of a request before is one: a slave is there.
            let due = asked.owes() && !asked.answered && late(asked, *exchange);
            due.then(|| settled(asked, *exchange))
        })
    }

    /// The open request of a kind: the master does not wait for its answer any more.
    pub fn give_up(&mut self, exchange: Exchange) -> Option<Asked> {
        let asked = self.asked.get_mut(exchange as usize)?.as_mut()?;
        asked.owes().then(|| settled(asked, exchange).1)
    }

    /// A request to a selected slave that nobody has answered, though the master has gone on. `now` is a frame by which
    /// an answer that was sent would be in the capture.
    pub fn overtaken(&mut self, now: FrameRef) -> Option<(Exchange, Asked)> {
        let (next, lag_ns) = (self.last?, self.lag_ns);
        let over = |asked: FrameRef| asked.no < next.no && !close(asked, now, lag_ns);
        self.unanswered(over)
    }

    /// The same of requests before the frame `next`, which a slave has answered: it takes them one after the other.
    pub fn passed_over(&mut self, next: FrameRef) -> Option<(Exchange, Asked)> {
        self.unanswered(|asked| asked.no < next.no)
    }

    fn unanswered(&mut self, over: impl Fn(FrameRef) -> bool) -> Option<(Exchange, Asked)> {
        // An answer that waits for its request may be the one that is owed, with a wrong specifier.
        let waits = self.early.iter().map(|early| early.at.no).max().unwrap_or(0);
        let over = |asked: FrameRef| over(asked) && asked.no > waits;
        OWING.iter().filter(|exchange| exchange.configures()).find_map(|exchange| {
            let asked = self.asked.get_mut(*exchange as usize)?.as_mut()?;
            let open = asked.owes() && !asked.answered && asked.certain;
            (open && over(asked.at)).then(|| settled(asked, *exchange))
        })
    }

    /// A frame cannot be read: it may be any answer, or (`request`) any request.
    pub fn unreadable(&mut self, request: bool, at: FrameRef) {
        if request {
            self.unreadable = Some(at);
        }
        self.excuse();
    }

    /// Whether a frame of the master that could not be read may have been the request of an answer. Of one only.
    pub fn may_be_requested(&mut self, answer: FrameRef) -> bool {
        self.unreadable.take().is_some_and(|request| request.no < answer.no)
    }

    /// Frames were lost.
    pub fn lost(&mut self) {
        *self = Self { lag_ns: self.lag_ns, unreadable: self.unreadable, ..Self::default() };
    }

    /// An answer cannot be read: it may be one that is owed.
    pub fn excuse(&mut self) {
        for asked in self.asked.iter_mut().flatten().filter(|asked| asked.owed > 0) {
            asked.answered = true;
        }
    }

    /// Nothing is owed any more: slaves were reset, or change their bit rate.
    pub fn forgive(&mut self) {
        for asked in self.asked.iter_mut().flatten() {
            asked.settled = true;
        }
    }

    /// When something becomes due, in ns.
    pub fn due(&self) -> Option<i64> {
        let open = OWING.iter().filter_map(|exchange| {
            let asked = self.get(*exchange).filter(|asked| asked.owes() && !asked.answered)?;
            Some(asked.at.t_ns?.saturating_add(exchange.limit_ns()))
        });
        let early = self.early.iter().filter_map(|early| Some(early.at.t_ns?.saturating_add(self.lag_ns + 1)));
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

/// The kinds to which one slave owes an answer.
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

/// Whether only slaves in the configuration state take a command.
pub fn configures(command: Command) -> bool {
    Exchange::asked_by(command).is_some_and(Exchange::configures)
        || matches!(command, Command::ActivateBitTiming { .. })
}

/// The command specifier of a configuration command.
pub fn specifier(command: Command) -> u8 {
    Exchange::asked_by(command).map_or(0x15, Exchange::specifier)
}

/// Whether an answer stands so shortly before a request that it may be the one to it. `lag_ns`: how late the recording
/// lists the host's own frames at most.
pub fn close(answer: FrameRef, request: FrameRef, lag_ns: i64) -> bool {
    request.since(answer).is_none_or(|age| (0..=lag_ns).contains(&age))
}
