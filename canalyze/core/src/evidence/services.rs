//! Whether the frames on the identifier of a service are messages of that service.
//!
//! A bus may carry other protocols, beside CANopen or instead of it, and they use any identifier. Values and counters of
//! such traffic are no messages of NMT, SYNC, TIME, EMCY or error control, and nothing may be judged by them. A device
//! at fault sends the same wrong frame again and again, or right ones too. Several wrong frames that differ, or many
//! that are the same where the node is not known, are certain to be something else; until then findings wait. A single
//! frame like an emergency is not judged where nothing else is like CANopen. SDO and LSS have their own proofs, which
//! rest on requests and responses. It must not raise a finding.

use crate::cob_id::Role;
use crate::finding::Finding;
use crate::frame::{CanId, Frame, FrameRef, Kind};
use crate::rules::Family;

use super::recording::Recording;
use super::when::When;

/// Messages of the service, with hardly a wrong one among them, that prove it.
const PROOF: u32 = 3;
/// Findings that wait for a proof at most (invariant 6).
const KEPT: usize = 64;
/// Fewer frames say nothing of a whole bus.
const FEW: u64 = 20;
/// Messages of services, from which on a bus may be CANopen.
const HINTS: u64 = 2;
/// A whole bus is taken for something else where at least one of this number of frames is certain to be no message of
/// CANopen.
const PART: u64 = 4;
/// How long one waits where the node, or the bus, is known to be CANopen, in ns.
const WAIT_NS: i64 = 3_000_000_000;

/// What it is certain that an identifier carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Carries {
    /// The service.
    Service,
    /// Not known yet.
    Open,
    /// Something else.
    Other,
}

/// What the frames of one identifier have shown.
#[derive(Clone, Debug, Default)]
struct Shown {
    /// Frames that are messages of the service, and others.
    fit: u32,
    misfit: u32,
    /// Wrong frames with other data than the frame before.
    different: u32,
    proven: bool,
    /// The first frame and the last one, with its first bytes.
    first: Option<(CanId, FrameRef)>,
    last: u64,
}

impl Shown {
    fn take(&mut self, frame: &Frame, fits: bool) {
        let bytes = head(frame);
        self.first.get_or_insert((frame.id, frame.reference()));
        if fits {
            self.fit = self.fit.saturating_add(1);
            self.proven |= self.fit >= PROOF && self.misfit <= self.fit / PROOF;
        } else {
            self.different = self.different.saturating_add(u32::from(self.misfit == 0 || bytes != self.last));
            self.misfit = self.misfit.saturating_add(1);
        }
        self.last = bytes;
    }

    /// `ground`: what else is known to be CANopen; `over`: no further frame can tell.
    fn carries(&self, ground: Ground, over: bool) -> Carries {
        let (different, same) = match ground {
            Ground::Nothing => (4, 3),
            Ground::Bus => (4, 16),
            Ground::Node if over => (4, 16),
            Ground::Node => (12, 16),
        };
        if self.proven || self.misfit == 0 {
            Carries::Service
        } else if self.fit.saturating_mul(3) >= self.misfit {
            // Of random values some fit, too.
            if ground == Ground::Nothing { Carries::Open } else { Carries::Service }
        } else if self.different >= different {
            Carries::Other
        } else if self.misfit < same {
            Carries::Open
        } else if ground == Ground::Node {
            Carries::Service
        } else {
            Carries::Other
        }
    }
}

/// What is known to be CANopen by other frames than those of an identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ground {
    /// Nothing.
    Nothing,
    /// The bus.
    Bus,
    /// The node; for a service of no node, the bus.
    Node,
}

/// An identifier whose frames are not those of the service that its number stands for.
#[derive(Clone, Copy, Debug)]
pub struct Other {
    /// The identifier.
    pub id: CanId,
    /// Its first frame.
    pub first: FrameRef,
    /// Its frames.
    pub frames: u64,
}

/// A bus on which nothing is CANopen.
#[derive(Clone, Copy, Debug)]
pub struct Alien {
    /// Its first frame.
    pub first: FrameRef,
    /// Its frames.
    pub frames: u64,
    /// All of them have 29-bit identifiers.
    pub extended: bool,
}

/// What the capture has shown of a bus, in the order in which one bus decides for several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nature {
    /// No frame has come.
    Silent,
    /// It carries something else than CANopen.
    Foreign,
    /// Nothing has shown that it is CANopen, or that it is not.
    Unproven,
    /// It is CANopen.
    Canopen,
}

impl Nature {
    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::Foreign => "foreign",
            Self::Unproven => "unproven",
            Self::Canopen => "canopen",
        }
    }
}

/// What the identifiers of a bus carry.
#[derive(Debug)]
pub struct Services {
    /// NMT, SYNC and TIME, then EMCY and error control by node-ID.
    shown: Vec<Shown>,
    /// Nodes, one bit each, that an SDO exchange, a boot-up or heartbeats have shown.
    nodes: u128,
    /// A person has described the bus.
    described: bool,
    /// Frames that are messages of their service.
    fits: u64,
    /// The capture is over, and exchanges of SDO or LSS have shown that the bus is CANopen.
    exchanged: bool,
    /// The capture is over, and something has shown it.
    shown_canopen: bool,
    /// Frames with data; those with 29-bit identifiers; those on identifiers without a service.
    frames: u64,
    extended: u64,
    unassigned: u64,
    first: Option<FrameRef>,
    /// The capture is over.
    over: bool,
    /// The bus carries something else: nothing is said of its services.
    alien: bool,
    waiting: Vec<(Finding, When)>,
}

/// The first slots of EMCY and of error control.
const EMCY: usize = 3;
const ERROR_CONTROL: usize = EMCY + 128;
const SLOTS: usize = ERROR_CONTROL + 128;

impl Default for Services {
    fn default() -> Self {
        Self {
            shown: vec![Shown::default(); SLOTS],
            nodes: 0,
            described: false,
            fits: 0,
            exchanged: false,
            shown_canopen: false,
            frames: 0,
            extended: 0,
            unassigned: 0,
            first: None,
            over: false,
            alien: false,
            waiting: Vec::new(),
        }
    }
}

impl Services {
    /// Of a bus of which nothing was seen; `described`: a person says that there is CANopen on it.
    pub fn new(described: bool) -> Self {
        Self { described, ..Self::default() }
    }

    /// Takes a frame and what its identifier stands for.
    #[inline]
    pub fn take(&mut self, role: Role, frame: &Frame) {
        if matches!(frame.kind, Kind::Remote | Kind::Error) {
            return;
        }
        self.frames += 1;
        self.extended += u64::from(frame.id.is_extended());
        self.unassigned += u64::from(is_unassigned(role));
        self.first.get_or_insert(frame.reference());
        let Some(slot) = slot(role) else { return };
        let Some(shown) = self.shown.get_mut(slot) else { return };
        let fitting = fits(role, frame, shown.last, shown.fit > 0);
        self.fits += u64::from(fitting);
        shown.take(frame, fitting);
        if let Role::ErrorControl(node) = role
            && shown.proven
        {
            self.prove(node);
        }
    }

    /// A node is CANopen: it has answered a request as SDO does.
    pub fn prove(&mut self, node: u8) {
        self.nodes |= 1 << (node & 0x7F);
    }

    /// Whether it is certain that the frames of an identifier are not those of its service.
    #[inline]
    pub fn is_other(&self, role: Role) -> bool {
        slot(role).is_some_and(|slot| self.is_other_at(slot))
    }

    fn is_other_at(&self, slot: usize) -> bool {
        self.carries(slot) == Carries::Other
    }

    /// Whether anything has shown that the bus is CANopen.
    pub fn is_canopen(&self) -> bool {
        self.described || self.nodes != 0 || self.shown.iter().any(|shown| shown.proven)
    }

    /// The capture is over. `further`: frames of SDO and LSS that are certain to be none; `canopen`: others have shown
    /// that they are. Gives what the whole bus is, where it is not CANopen; then no finding about a service is admitted
    /// any more.
    pub fn conclude(&mut self, further: u64, canopen: bool) -> Option<Alien> {
        self.over = true;
        self.exchanged = canopen;
        // Any values may look like one emergency.
        let least = |slot| if (EMCY..ERROR_CONTROL).contains(&slot) { 1 } else { 0 };
        let hint =
            self.shown.iter().enumerate().any(|(slot, shown)| shown.fit > least(slot) && !self.is_other_at(slot));
        self.shown_canopen = canopen || hint || self.is_canopen();
        if self.shown_canopen || self.frames < FEW {
            return None;
        }
        let others: u64 = self.others().map(|other| other.frames).sum();
        let strange = self.unassigned.saturating_add(others).saturating_add(further);
        self.alien = strange >= self.frames / PART;
        let first = self.first.filter(|_| self.alien)?;
        Some(Alien { first, frames: self.frames, extended: self.extended == self.frames })
    }

    /// What the capture, which is over, has shown of the bus.
    pub fn nature(&self) -> Nature {
        match (self.frames, self.alien) {
            (0, _) => Nature::Silent,
            (_, true) => Nature::Foreign,
            (_, false) if self.shown_canopen => Nature::Canopen,
            _ => Nature::Unproven,
        }
    }

    /// Takes a finding: gives it back where the services that it is about are there, keeps it where that is not known
    /// yet, and drops it where they are not.
    pub fn admit(&mut self, finding: Finding, at: When) -> Option<Finding> {
        match self.of(&finding) {
            Carries::Service => Some(finding),
            Carries::Open if self.waiting.len() < KEPT => {
                self.waiting.push((finding, at));
                None
            }
            Carries::Open | Carries::Other => None,
        }
    }

    /// Whether findings wait.
    #[inline]
    pub fn holds(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// The findings that have waited long enough at `now`, in order.
    pub fn release(&mut self, now: When, recording: &Recording) -> Vec<Finding> {
        let mut out = Vec::new();
        for (finding, since) in std::mem::take(&mut self.waiting) {
            let known = finding.node.map_or_else(|| self.is_canopen(), |node| self.is_node(node));
            match self.of(&finding) {
                Carries::Service => out.push(finding),
                Carries::Open if known && recording.certainly_later(now, since, WAIT_NS) => out.push(finding),
                Carries::Open => self.waiting.push((finding, since)),
                Carries::Other => {}
            }
        }
        out
    }

    /// The capture is over: what waits and is not about something else.
    pub fn finish(&mut self) -> Vec<Finding> {
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        waiting.map(|(finding, _)| finding).filter(|finding| self.is_likely(finding)).collect()
    }

    /// Whether a finding is about its service, where no further frame can tell. Any values may look like one emergency.
    fn is_likely(&self, finding: &Finding) -> bool {
        let emergency = finding.code.rule().context.contains(&Family::Emcy);
        let own = finding.node.and_then(|node| self.shown.get(slot(Role::Emcy(node))?)).map_or(0, |shown| shown.fit);
        match self.of(finding) {
            Carries::Service => true,
            Carries::Open => !emergency || self.exchanged || self.is_canopen() || self.fits > u64::from(own == 1),
            Carries::Other => false,
        }
    }

    /// The identifiers that carry something else.
    pub fn others(&self) -> impl Iterator<Item = Other> {
        let others = self.shown.iter().enumerate().filter(|(slot, _)| self.carries(*slot) == Carries::Other);
        others.filter_map(|(_, shown)| {
            let (id, first) = shown.first?;
            Some(Other { id, first, frames: u64::from(shown.fit) + u64::from(shown.misfit) })
        })
    }

    fn is_node(&self, node: u8) -> bool {
        self.nodes & 1 << (node & 0x7F) != 0
    }

    fn carries(&self, slot: usize) -> Carries {
        let Some(shown) = self.shown.get(slot) else { return Carries::Service };
        if shown.misfit == 0 {
            let emergency = (EMCY..ERROR_CONTROL).contains(&slot);
            let alone = emergency && self.fits < HINTS && self.nodes == 0 && !self.described;
            return if alone { Carries::Open } else { Carries::Service };
        }
        let node = slot.checked_sub(EMCY).map(|place| place as u8);
        let ground = match node {
            // What a node of CANopen sends wrong on its own identifiers is its fault.
            Some(node) if self.is_node(node) => return Carries::Service,
            None if self.is_canopen() => Ground::Node,
            Some(_) if self.is_canopen() => Ground::Bus,
            _ => Ground::Nothing,
        };
        shown.carries(ground, self.over)
    }

    fn of(&self, finding: &Finding) -> Carries {
        let mut found = Carries::Service;
        let families = finding.code.rule().context;
        if self.alien && families.iter().any(|family| !matches!(family, Family::Error | Family::Other)) {
            return Carries::Other;
        }
        for family in families {
            let slot = match (family, finding.node) {
                (Family::Nmt, _) => slot(Role::Nmt),
                (Family::Sync, _) => slot(Role::Sync),
                (Family::Time, _) => slot(Role::Time),
                (Family::Emcy, Some(node)) => slot(Role::Emcy(node)),
                (Family::ErrorControl, Some(node)) => slot(Role::ErrorControl(node)),
                _ => None,
            };
            match slot.map(|slot| self.carries(slot)) {
                Some(Carries::Other) => return Carries::Other,
                Some(Carries::Open) => found = Carries::Open,
                Some(Carries::Service) | None => {}
            }
        }
        found
    }
}

/// Whether CANopen gives an identifier no service.
fn is_unassigned(role: Role) -> bool {
    matches!(role, Role::Foreign | Role::Unassigned | Role::Reserved | Role::DynamicSdo)
}

fn slot(role: Role) -> Option<usize> {
    Some(match role {
        Role::Nmt => 0,
        Role::Sync => 1,
        Role::Time => 2,
        Role::Emcy(node) => EMCY + usize::from(node & 0x7F),
        Role::ErrorControl(node) => ERROR_CONTROL + usize::from(node & 0x7F),
        _ => return None,
    })
}

/// The first bytes of a frame, and its length.
fn head(frame: &Frame) -> u64 {
    u64::from_le_bytes(frame.head()) ^ u64::from(frame.len).rotate_right(8)
}

/// Whether a frame is a message of its service. `last`: [`head`] of the one before; `seen`: one was a message.
fn fits(role: Role, frame: &Frame, last: u64, seen: bool) -> bool {
    let bytes = frame.payload();
    match (role, bytes) {
        (Role::Nmt, &[command, node]) => matches!(command, 0x01 | 0x02 | 0x80..=0x82) && node <= 127,
        (Role::Sync, &[]) => true,
        (Role::Sync, &[counter]) => {
            let before = (last & 0xFF) as u8;
            (1..=240).contains(&counter) && (!seen || counter == 1 || counter == before.wrapping_add(1))
        }
        (Role::Time, &[_, _, _, high, _, _]) => high >> 4 == 0,
        (Role::Emcy(_), &[low, high, register, ..]) if bytes.len() == 8 && frame.kind == Kind::Data => {
            // Bit 0 is set with any other; bit 6 is reserved (CiA 301, table 48).
            is_emergency(u16::from_le_bytes([low, high])) && (register == 0 || register & 0x41 == 1)
        }
        (Role::ErrorControl(_), &[state]) => matches!(state & 0x7F, 0x00 | 0x04 | 0x05 | 0x7F),
        _ => false,
    }
}

/// Whether an error code belongs to a class of CiA 301, table 26, or to one of CiA 402, which divides them further (8611h:
/// following error).
fn is_emergency(code: u16) -> bool {
    let [high, low] = code.to_be_bytes();
    match high {
        0x00 => low == 0,
        0x10 | 0x20..=0x23 | 0x30..=0x34 | 0x40..=0x45 | 0x50..=0x55 | 0x60..=0x63 | 0x70..=0x76 => true,
        0x80..=0x87 | 0x8A | 0x90 | 0xF0 | 0xFF => true,
        _ => false,
    }
}
