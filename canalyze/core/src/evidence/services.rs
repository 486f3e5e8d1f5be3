//! Evidence that the frames on a service's identifier are, or are not, messages of that service.
//!
//! A bus may carry other protocols, beside CANopen or instead of it, on any identifier. Their frames are not messages
//! of NMT, SYNC, TIME, EMCY or error control, and no verdict may rest on them. A faulty device repeats the same wrong
//! frame, perhaps among right ones. Several different wrong frames, or many equal ones of an unknown node, are
//! certainly another protocol; until then findings wait. A single frame like an emergency is not judged if nothing else
//! looks like CANopen. SDO and LSS have their own proofs, which rest on requests and responses.

use crate::bytes::frame::{CanId, Frame, FrameRef, Kind};
use crate::bytes::ns::Ns;
use crate::rules::Family;
use crate::rules::finding::Finding;
use crate::wire::cob_id::Role;

use super::recording::Recording;
use super::when::When;

/// Number of messages of the service, with hardly a wrong one among them, that prove it.
const PROOF: u32 = 3;
/// Maximum number of findings that wait for a proof (invariant 6).
const KEPT: usize = 64;
/// Minimum number of frames from which a whole bus is judged.
const FEW: u64 = 20;
/// Minimum number of messages of services from which a bus may be CANopen.
const HINTS: u64 = 2;
/// A whole bus is taken for another protocol if at least one of this number of frames is certainly not CANopen.
const PART: u64 = 4;
/// Maximum waiting time of a finding if the node or the bus is known to be CANopen, in ns.
const WAIT_NS: Ns = Ns::from_s(3);

/// The certain content of an identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Carries {
    /// The service.
    Service,
    /// Not decided yet.
    Open,
    /// Something else.
    Other,
}

/// The evidence from the frames of one identifier.
#[derive(Clone, Debug, Default)]
struct Shown {
    /// Number of messages of the service, and of other frames.
    fit: u32,
    misfit: u32,
    /// Number of wrong frames whose data differ from the previous frame.
    different: u32,
    proven: bool,
    /// The first frame; and the first bytes of the last one.
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

    /// Decides the content. `ground`: other evidence of CANopen; `over`: no further frames follow.
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
            // Some random values look like messages, too.
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

/// The evidence of CANopen in frames of other identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ground {
    /// Nothing.
    Nothing,
    /// The bus.
    Bus,
    /// The node; for a service without a node, the bus.
    Node,
}

/// An identifier whose frames are not messages of its service.
#[derive(Clone, Copy, Debug)]
pub struct Other {
    /// The identifier.
    pub id: CanId,
    /// The first frame.
    pub first: FrameRef,
    /// Number of frames.
    pub frames: u64,
}

/// A bus without any CANopen.
#[derive(Clone, Copy, Debug)]
pub struct Alien {
    /// The first frame.
    pub first: FrameRef,
    /// Number of frames.
    pub frames: u64,
    /// True if all identifiers have 29 bits.
    pub extended: bool,
}

/// The evidence about a whole bus, ordered by precedence among several buses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nature {
    /// No frames.
    Silent,
    /// Another protocol than CANopen.
    Foreign,
    /// Evidence neither for nor against CANopen.
    Unproven,
    /// CANopen.
    Canopen,
}

impl Nature {
    /// Returns the word used in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::Foreign => "foreign",
            Self::Unproven => "unproven",
            Self::Canopen => "canopen",
        }
    }
}

/// The evidence about the identifiers of a bus.
#[derive(Debug)]
pub struct Services {
    /// NMT, SYNC and TIME, then EMCY and error control by node-ID.
    shown: Vec<Shown>,
    /// Nodes, one bit each, proven by an SDO exchange, a boot-up or heartbeats.
    nodes: u128,
    /// True if the user has described the bus.
    described: bool,
    /// Number of frames that are messages of their service.
    fits: u64,
    /// True if the capture is over and exchanges of SDO or LSS have proven the bus to be CANopen.
    exchanged: bool,
    /// True if the capture is over and the bus is proven to be CANopen.
    shown_canopen: bool,
    /// Number of data frames, of those with 29-bit identifiers, and of those on identifiers without a service.
    frames: u64,
    extended: u64,
    unassigned: u64,
    first: Option<FrameRef>,
    /// True if the capture is over.
    over: bool,
    /// True if the bus carries another protocol, so that its services are not judged.
    alien: bool,
    waiting: Vec<(Finding, When)>,
    /// True if an identifier was proven.
    proven: bool,
    /// The time from which on a finding may have waited long enough, in ns, unless the evidence changes before.
    next_ns: Ns,
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
            proven: false,
            next_ns: Ns::MAX,
        }
    }
}

impl Services {
    /// Creates the evidence of a bus without frames; `described`: the user says that it is CANopen.
    pub fn new(described: bool) -> Self {
        Self { described, ..Self::default() }
    }

    /// Counts a frame and the role of its identifier.
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
        self.proven |= shown.proven;
        self.next_ns = Ns::MIN;
        if let Role::ErrorControl(node) = role
            && shown.proven
        {
            self.prove(node);
        }
    }

    /// Records a proof that a node is CANopen: it has answered a request by the rules of SDO.
    pub fn prove(&mut self, node: u8) {
        self.nodes |= 1 << (node & 0x7F);
        self.next_ns = Ns::MIN;
    }

    /// Returns true if the frames of an identifier are certainly not messages of its service.
    #[inline]
    pub fn is_other(&self, role: Role) -> bool {
        slot(role).is_some_and(|slot| self.is_other_at(slot))
    }

    fn is_other_at(&self, slot: usize) -> bool {
        self.carries(slot) == Carries::Other
    }

    /// Returns true if there is evidence that the bus is CANopen.
    pub fn is_canopen(&self) -> bool {
        self.described || self.nodes != 0 || self.proven
    }

    /// Concludes the capture. `further`: number of frames on identifiers of SDO and LSS that certainly belong to
    /// neither; `canopen`: exchanges of these have been proven. Returns the whole bus if it is not CANopen; its
    /// services then have no findings.
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

    /// Returns the nature of the bus after the end of the capture.
    pub fn nature(&self) -> Nature {
        match (self.frames, self.alien) {
            (0, _) => Nature::Silent,
            (_, true) => Nature::Foreign,
            (_, false) if self.shown_canopen => Nature::Canopen,
            _ => Nature::Unproven,
        }
    }

    /// Returns a finding if its services are proven, keeps it while that is open, and drops it if they are refuted.
    #[inline]
    pub fn admit(&mut self, finding: Finding, at: When) -> Option<Finding> {
        let carries = self.of(&finding);
        if carries == Carries::Service {
            return Some(finding);
        }
        if carries == Carries::Open && self.waiting.len() < KEPT {
            self.waiting.push((finding, at));
            self.next_ns = Ns::MIN;
        }
        None
    }

    /// Returns true if findings are waiting.
    #[inline]
    pub fn holds(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// Returns the findings that have waited long enough at `now`, in order.
    pub fn release(&mut self, now: When, recording: &Recording) -> Vec<Finding> {
        let mut out = Vec::new();
        let now_ns = now.at.t_ns.unwrap_or(Ns::MIN);
        if self.next_ns > now_ns {
            return out;
        }
        self.next_ns = Ns::MAX;
        for (finding, since) in std::mem::take(&mut self.waiting) {
            let known = finding.node.map_or_else(|| self.is_canopen(), |node| self.is_node(node));
            match self.of(&finding) {
                Carries::Service => out.push(finding),
                Carries::Open if known && recording.certainly_later(now, since, WAIT_NS) => out.push(finding),
                Carries::Open => {
                    if known && let Some(since_ns) = since.at.t_ns {
                        self.next_ns = self.next_ns.min(since_ns + WAIT_NS);
                    }
                    self.waiting.push((finding, since));
                }
                Carries::Other => {}
            }
        }
        out
    }

    /// Returns the waiting findings that are not about another protocol, after the end of the capture.
    pub fn finish(&mut self) -> Vec<Finding> {
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        waiting.map(|(finding, _)| finding).filter(|finding| self.is_likely(finding)).collect()
    }

    /// Returns true if a finding probably concerns its service, when no further frames follow. Any values may look like
    /// one emergency.
    fn is_likely(&self, finding: &Finding) -> bool {
        let emergency = finding.code.rule().context.contains(&Family::Emcy);
        let own = finding.node.and_then(|node| self.shown.get(slot(Role::Emcy(node))?)).map_or(0, |shown| shown.fit);
        match self.of(finding) {
            Carries::Service => true,
            Carries::Open => !emergency || self.exchanged || self.is_canopen() || self.fits > u64::from(own == 1),
            Carries::Other => false,
        }
    }

    /// Iterates over the identifiers that carry another protocol.
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
            // Wrong frames of a CANopen node on its own identifiers are its fault.
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

/// Returns true if CANopen assigns no service to an identifier.
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

/// Returns the first bytes of a frame combined with its length.
fn head(frame: &Frame) -> u64 {
    u64::from_le_bytes(frame.head()) ^ u64::from(frame.len).rotate_right(8)
}

/// Returns true if a frame is a message of its service. `last`: [`head`] of the previous frame; `seen`: there was a
/// message before.
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
            // Bit 0 is set with any other error; bit 6 is reserved (CiA 301, table 48).
            is_emergency(u16::from_le_bytes([low, high])) && (register == 0 || register & 0x41 == 1)
        }
        (Role::ErrorControl(_), &[state]) => matches!(state & 0x7F, 0x00 | 0x04 | 0x05 | 0x7F),
        _ => false,
    }
}

/// Returns true if an error code belongs to a class of CiA 301, table 26, or of CiA 402, which divides them further
/// (8611h: following error).
fn is_emergency(code: u16) -> bool {
    let [high, low] = code.to_be_bytes();
    match high {
        0x00 => low == 0,
        0x10 | 0x20..=0x23 | 0x30..=0x34 | 0x40..=0x45 | 0x50..=0x55 | 0x60..=0x63 | 0x70..=0x76 => true,
        0x80..=0x87 | 0x8A | 0x90 | 0xF0 | 0xFF => true,
        _ => false,
    }
}
