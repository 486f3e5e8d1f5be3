//! The context of findings: the last frames of every service of every node, with their events.
//!
//! Frames and their events are moved in as they are, and put into words only for a finding. A ring keeps [`DEPTH`]
//! frames, under 9 kB, and an SDO ring the beginning of its transfer. There are at most [`RINGS`] rings, so memory
//! stays under 21 MB for any capture: services of further nodes share one. The last transfer of each object is kept
//! when its ring moves on, since expectations about it are judged at the end.

use std::collections::BTreeMap;

use crate::bytes::frame::{BusId, CanId, Frame};
use crate::rules::finding::{Code, Facts, Finding};
use crate::rules::{Family, Rule};
use crate::sdo::wire::{Command, Mux, Side};
use crate::wire::cob_id::Role;
use crate::wire::message::Message;
use crate::world::event::{Event, What};

/// Number of frames that are kept of one service of one node.
const DEPTH: usize = 24;
/// Maximum number of rings; the first one is shared by those for which there is no room.
const RINGS: usize = 2048;
/// Maximum number of objects whose last transfer is kept.
const OBJECTS: usize = 1024;
/// Maximum number of frames of one finding.
pub const MOST: usize = 8;
/// Node-IDs, and 0 for frames without a node.
const NODES: usize = 128;

/// Families that are kept by node.
const BY_NODE: usize = 5;
const FAMILIES: usize = 11;
/// Number of rings that a bus may have.
const PLACES: usize = BY_NODE * NODES + FAMILIES - BY_NODE;

use Family::{Emcy, Error, ErrorControl, Lss, Nmt, Other, Pdo, Sdo, Srdo, Sync, Time};

/// A frame and its event.
#[derive(Debug)]
pub struct HeldFrame {
    /// The frame.
    pub frame: Frame,
    /// Its own event; `None` if there is none.
    pub event: Option<Event>,
}

impl HeldFrame {
    /// Takes a frame, and its own event from its events.
    fn new(frame: &Frame, events: &mut Vec<Event>) -> Self {
        Self { frame: *frame, event: (!events.is_empty()).then(|| events.remove(0)) }
    }

    /// Takes another one in its place: to move both would take as long as all else here.
    #[inline]
    fn renew(&mut self, frame: &Frame, events: &mut Vec<Event>) {
        let (Some(event), Some(own)) = (&mut self.event, events.first_mut()) else {
            return *self = Self::new(frame, events);
        };
        std::mem::swap(event, own);
        self.frame = *frame;
        match events.len() {
            1 => events.clear(),
            _ => _ = events.remove(0),
        }
    }

    fn family(&self) -> Family {
        self.event.as_ref().map_or(Other, |event| family(&event.what))
    }

    fn node(&self) -> Option<u8> {
        self.event.as_ref().and_then(|event| event.node)
    }

    fn transfer(&self) -> Option<u64> {
        self.event.as_ref().and_then(|event| event.transfer).map(|id| id.0)
    }

    /// Returns the object of the SDO transfer that ends with it.
    fn ends(&self) -> Option<Mux> {
        let What::Sdo(step) = &self.event.as_ref()?.what else { return None };
        step.result.as_ref()?.mux
    }

    /// Returns the object that a client begins to write with it.
    fn writes(&self) -> Option<Mux> {
        let What::Sdo(step) = &self.event.as_ref()?.what else { return None };
        match step.command {
            Command::InitiateDownload(..) | Command::InitiateBlockDownload { .. } => step.command.mux(),
            _ => None,
        }
    }

    /// Returns the side that begins an SDO transfer with it, if any.
    fn opens(&self) -> Option<Side> {
        let What::Sdo(step) = &self.event.as_ref()?.what else { return None };
        match step.command {
            Command::InitiateDownload(..)
            | Command::InitiateUpload(..)
            | Command::InitiateBlockDownload { .. }
            | Command::InitiateBlockUpload { .. } => Some(Side::Client),
            Command::DownloadInitiated(..)
            | Command::UploadInitiated(..)
            | Command::BlockDownloadInitiated { .. }
            | Command::BlockUploadInitiated { .. } => Some(Side::Server),
            _ => None,
        }
    }
}

/// The last frames of one place.
#[derive(Debug, Default)]
struct Ring {
    held: Vec<HeldFrame>,
    /// The index of the next frame once the ring is full.
    next: usize,
    /// Request and response at the beginning of the last transfer whose beginning has left the ring.
    opening: Vec<HeldFrame>,
}

impl Ring {
    /// Keeps a frame. Returns a transfer that has left the ring: its kept frames, the last frame last.
    fn push(&mut self, frame: &Frame, events: &mut Vec<Event>) -> Option<(Mux, Vec<HeldFrame>)> {
        if self.held.len() < DEPTH {
            self.held.push(HeldFrame::new(frame, events));
            return None;
        }
        let slot = self.held.get_mut(self.next)?;
        self.next = (self.next + 1) % DEPTH;
        if slot.family() != Sdo {
            slot.renew(frame, events);
            return None;
        }
        let left = std::mem::replace(slot, HeldFrame::new(frame, events));
        if let Some(object) = left.ends() {
            let mut whole = std::mem::take(&mut self.opening);
            whole.retain(|held| held.transfer() == left.transfer());
            whole.push(left);
            return Some((object, whole));
        }
        match left.opens() {
            Some(Side::Client) => {
                self.opening.clear();
                self.opening.push(left);
            }
            Some(Side::Server) if self.opening.len() == 1 => self.opening.push(left),
            _ => {}
        }
        None
    }
}

/// The last frames of all buses.
#[derive(Debug)]
pub struct FindingContext {
    /// The ring by bus and place; 0 if there is none yet.
    places: Vec<[u16; PLACES]>,
    rings: Vec<Ring>,
    /// The last transfer of each object, by bus and node-ID, that has left its ring.
    past: BTreeMap<(BusId, Option<u8>, Mux), Vec<HeldFrame>>,
    /// The ring of the last frame.
    last: usize,
}

impl Default for FindingContext {
    fn default() -> Self {
        Self { places: Vec::new(), rings: vec![Ring::default()], past: BTreeMap::new(), last: 0 }
    }
}

impl FindingContext {
    /// Keeps a frame with its own event, which is taken from its events.
    pub fn push(&mut self, frame: &Frame, events: &mut Vec<Event>) {
        let (family, node) = events.first().map_or((Other, None), |event| (family(&event.what), event.node));
        let index = self.ring_for(frame.bus, place(family, node));
        self.last = index;
        let left = self.rings.get_mut(index).and_then(|ring| ring.push(frame, events));
        let Some((object, whole)) = left else { return };
        let Some(last) = whole.last() else { return };
        let key = (last.frame.bus, last.node(), object);
        if self.past.len() < OBJECTS || self.past.contains_key(&key) {
            self.past.insert(key, whole);
        }
    }

    /// Returns the frames that give a finding its context, oldest first: the frames that it is about and that show it,
    /// the write that configured its object, the last one of each family before, and the frames around the one that it
    /// is about; as far as they are still held. Empty for a finding about a file, and for one that only counts further
    /// ones.
    pub fn frames(&self, finding: &Finding) -> Vec<&HeldFrame> {
        let Rule { context: families, one_pdo, .. } = finding.code.rule();
        let counts = match &finding.facts {
            Facts::Repeated { .. } => true,
            Facts::Unmet(unmet) => unmet.repeated > 0,
            _ => false,
        };
        if families.is_empty() || counts {
            return Vec::new();
        }
        let at = self.find(finding.at.no, finding);
        let cause = finding.cause.and_then(|cause| self.find(cause.no, finding));
        let about = cause.map_or(finding.at.no, |held| held.frame.no);
        // A cause is more reliable: a missing PDO may show at any frame.
        let pdo = |held: &&HeldFrame| held.family() == Pdo && held.node() == finding.node;
        let pdo = [cause, at].into_iter().flatten().find(pdo).map(|held| held.frame.id);
        let mut found: Vec<&HeldFrame> = Vec::new();
        // A rule about both is about values, which come in PDOs or by SDO.
        let both = families.contains(&Pdo) && families.contains(&Sdo);
        for family in families.iter().filter(|family| !both || pdo.is_none() || **family != Sdo) {
            found.extend(self.of(*family, finding, pdo.filter(|_| *one_pdo)));
        }
        found.sort_unstable_by_key(|held| held.frame.no);
        let before = |held: &&&HeldFrame| held.frame.no <= about;
        let transfer = found.iter().rev().filter(before).find_map(|held| held.transfer());
        let past = self.past(finding).iter().filter(|_| at.is_none() || cause.is_none());
        let written = self.written(finding).filter(|_| !families.contains(&Sdo));
        let opening = self.opening(finding, transfer);
        let mut named: Vec<&HeldFrame> =
            [at, cause, written].into_iter().flatten().chain(opening).chain(past).collect();
        let last = |family: &Family| found.iter().rev().filter(before).find(|held| held.family() == *family).copied();
        let mut witnesses: Vec<&HeldFrame> =
            families.iter().filter_map(last).filter(|held| !holds(&named, held)).collect();
        witnesses.sort_unstable_by_key(|held| std::cmp::Reverse(held.frame.no));
        witnesses.truncate(MOST.saturating_sub(named.len()) / 2);
        named.extend(witnesses);
        found.retain(|held| !holds(&named, held));
        let room = MOST.saturating_sub(named.len());
        named.extend(around(&found, about, room));
        named.sort_unstable_by_key(|held| held.frame.no);
        named.dedup_by_key(|held| held.frame.no);
        named
    }

    /// Returns the last write of the finding's object, which configured it.
    fn written(&self, finding: &Finding) -> Option<&HeldFrame> {
        let object = finding.object?;
        let ring = self.ring(finding.bus, place(Sdo, finding.node)).map_or(&[][..], |ring| &ring.held);
        let past = self.past.get(&(finding.bus, finding.node, object)).map_or(&[][..], |whole| whole);
        let fits = |held: &&HeldFrame| {
            held.frame.bus == finding.bus && held.node() == finding.node && held.frame.no <= finding.at.no
        };
        let written = ring.iter().chain(past).filter(fits).filter(|held| held.writes() == Some(object));
        written.max_by_key(|held| held.frame.no)
    }

    /// Returns the held frames of a family: of the finding's node, and of one PDO if the finding names one.
    fn of(
        &self,
        family: Family,
        finding: &Finding,
        one_pdo: Option<CanId>,
    ) -> impl Iterator<Item = &HeldFrame> + use<'_> {
        let (bus, node, until) = (finding.bus, finding.node, finding.at.no);
        let by_node = (family as usize) < BY_NODE;
        let ring = self.ring(bus, place(family, node)).filter(|_| !by_node || node.is_some());
        ring.into_iter().flat_map(|ring| &ring.held).filter(move |held| {
            let fits = match family {
                Nmt => held.node().is_none() || node.is_none() || held.node() == node,
                Pdo => held.node() == node && one_pdo.is_none_or(|id| id == held.frame.id),
                _ => !by_node || held.node() == node,
            };
            fits && held.family() == family && held.frame.bus == bus && held.frame.no <= until
        })
    }

    /// Returns the beginning of this SDO transfer, if it has left the ring.
    fn opening(&self, finding: &Finding, transfer: Option<u64>) -> impl Iterator<Item = &HeldFrame> {
        let ring = self.ring(finding.bus, place(Sdo, finding.node));
        let opening = ring.map_or(&[][..], |ring| &ring.opening);
        opening.iter().filter(move |held| transfer.is_some() && held.transfer() == transfer)
    }

    /// Returns the transfer that the finding is about, if it has left the ring.
    fn past(&self, finding: &Finding) -> &[HeldFrame] {
        let about = |held: &HeldFrame| {
            held.frame.no == finding.at.no || finding.cause.is_some_and(|one| one.no == held.frame.no)
        };
        let whole = finding.object.and_then(|object| self.past.get(&(finding.bus, finding.node, object)));
        whole.filter(|whole| whole.iter().any(about)).map_or(&[], |whole| whole)
    }

    /// Returns the frame of this number, if it is held in the rings of the finding's families or is the last one of
    /// all.
    fn find(&self, no: u64, finding: &Finding) -> Option<&HeldFrame> {
        let of_node = (0..BY_NODE).map(|family| family * NODES + usize::from(finding.node.unwrap_or(0)) % NODES);
        let places = of_node.chain(BY_NODE * NODES..PLACES);
        let rings = places.filter_map(|place| self.ring(finding.bus, place)).chain(self.rings.get(self.last));
        rings.flat_map(|ring| &ring.held).find(|held| held.frame.no == no)
    }

    fn ring(&self, bus: BusId, place: usize) -> Option<&Ring> {
        self.rings.get(usize::from(*self.places.get(usize::from(bus.0))?.get(place)?))
    }

    fn ring_for(&mut self, bus: BusId, place: usize) -> usize {
        let bus = usize::from(bus.0);
        while self.places.len() <= bus {
            self.places.push([0; PLACES]);
        }
        let Some(index) = self.places.get_mut(bus).and_then(|places| places.get_mut(place)) else { return 0 };
        if *index == 0 && self.rings.len() < RINGS {
            *index = self.rings.len() as u16;
            self.rings.push(Ring::default());
        }
        usize::from(*index)
    }
}

fn holds(found: &[&HeldFrame], held: &HeldFrame) -> bool {
    found.iter().any(|one| one.frame.no == held.frame.no)
}

/// Returns the frames around the one of this number: at most a third of the room is for later ones, unless there are
/// fewer before it.
fn around<'f, 'a>(
    found: &'f [&'a HeldFrame],
    about: u64,
    room: usize,
) -> impl Iterator<Item = &'a HeldFrame> + use<'f, 'a> {
    let before = found.partition_point(|held| held.frame.no <= about);
    let after = (found.len() - before).min((room / 3).max(room.saturating_sub(before)));
    let from = before.saturating_sub(room - after);
    found.iter().skip(from).take(before - from + after).copied()
}

/// Returns the ring of a family on its bus.
fn place(family: Family, node: Option<u8>) -> usize {
    let family = family as usize;
    match family < BY_NODE {
        true => family * NODES + usize::from(node.unwrap_or(0)) % NODES,
        false => BY_NODE * NODES + family - BY_NODE,
    }
}

/// Returns true if a frame with this event of its own is one that a rule is about.
pub fn concerns(code: Code, what: &What) -> bool {
    code.rule().context.contains(&family(what))
}

fn family(what: &What) -> Family {
    match what {
        What::Pdo(_) | What::Mpdo(_) => Pdo,
        What::Sdo(_) => Sdo,
        What::Message(message) => match message {
            Message::Usdo { .. } => Sdo,
            Message::ErrorFrame => Error,
            _ => of_role(message.role()),
        },
        What::Transfer(_) | What::Note(_) | What::Change(_) | What::Finding(_) => Other,
    }
}

fn of_role(role: Role) -> Family {
    match role {
        Role::Nmt | Role::Gfc | Role::FlyingMaster(_) => Nmt,
        Role::Sync => Sync,
        Role::Emcy(_) => Emcy,
        Role::Time => Time,
        Role::Srdo { .. } => Srdo,
        Role::Tpdo { .. } | Role::Rpdo { .. } => Pdo,
        Role::SdoRequest(_) | Role::SdoResponse(_) => Sdo,
        Role::ErrorControl(_) => ErrorControl,
        Role::LssRequest | Role::LssResponse => Lss,
        Role::DynamicSdo | Role::Reserved | Role::Unassigned | Role::Foreign => Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::FrameRef;
    use crate::rules::finding::Code;
    use crate::sdo::transfer::TransferId;
    use crate::world::event::{ProcessData, Signals, Step, Unmapped};

    fn frame(no: u64, id: u16, payload: &[u8]) -> Frame {
        Frame { no, ..Frame::classic(CanId::standard(id), payload) }
    }

    fn event(frame: &Frame, node: Option<u8>, what: What) -> Event {
        Event { at: frame.reference(), about: None, bus: frame.bus, node, transfer: None, what }
    }

    fn heartbeat(context: &mut FindingContext, no: u64, node: u8) {
        let frame = frame(no, 0x700 + u16::from(node), &[5]);
        let message = Message::Heartbeat { node, state: 5, toggle: false, guarding: false, previous: None };
        context.push(&frame, &mut vec![event(&frame, Some(node), What::Message(message))]);
    }

    fn pdo(context: &mut FindingContext, no: u64, node: u8, number: u16) {
        let frame = frame(no, 0x80 + 0x100 * number + u16::from(node), &[0; 8]);
        let content = Signals::None(Unmapped::Unknown);
        let data = ProcessData { transmit: true, number, node, content, state: None, sync: None, is_off: false };
        context.push(&frame, &mut vec![event(&frame, Some(node), What::Pdo(data))]);
    }

    fn sdo(context: &mut FindingContext, no: u64, transfer: u64, side: Side, payload: &[u8]) {
        let frame = frame(no, if side == Side::Client { 0x605 } else { 0x585 }, payload);
        let mut event = event(&frame, Some(5), What::Sdo(Step::alone(side, &frame)));
        event.transfer = Some(TransferId(transfer));
        context.push(&frame, &mut vec![event]);
    }

    fn finding(code: Code, at: u64, cause: Option<u64>, node: Option<u8>) -> Finding {
        let reference = |no| FrameRef { no, ..FrameRef::default() };
        let cause = cause.map(reference);
        Finding {
            code,
            at: reference(at),
            cause,
            bus: BusId(0),
            node,
            object: None,
            facts: Facts::None,
            because_of: None,
        }
    }

    fn numbers(context: &FindingContext, finding: &Finding) -> Vec<u64> {
        context.frames(finding).iter().map(|held| held.frame.no).collect()
    }

    #[test]
    fn memory_is_what_is_said() {
        assert!(size_of::<HeldFrame>() * (DEPTH + 2) * RINGS <= 19 << 20, "{}", size_of::<HeldFrame>());
    }

    #[test]
    fn frames_are_of_the_node_and_the_service() {
        let mut context = FindingContext::default();
        for no in 1..=40 {
            heartbeat(&mut context, no, if no % 2 == 0 { 5 } else { 6 });
        }
        pdo(&mut context, 41, 5, 1);
        let late = finding(Code::Hbt001, 41, Some(30), Some(5));
        assert_eq!(numbers(&context, &late), [22, 24, 26, 28, 30, 32, 34, 41]);
        let forgotten = finding(Code::Hbt001, 41, Some(2), Some(5));
        assert_eq!(numbers(&context, &forgotten).len(), MOST);
        assert!(numbers(&context, &finding(Code::Cap001, 41, None, None)).is_empty());
    }

    #[test]
    fn a_pdo_is_not_mixed_with_others_of_its_node() {
        let mut context = FindingContext::default();
        for no in 1..=12 {
            pdo(&mut context, no, 5, 1 + (no % 3) as u16);
        }
        assert_eq!(numbers(&context, &finding(Code::Pdo001, 12, None, Some(5))), [3, 6, 9, 12]);
        // The PDO is unknown.
        heartbeat(&mut context, 13, 5);
        assert_eq!(numbers(&context, &finding(Code::Pdo005, 13, None, Some(5))), [6, 7, 8, 9, 10, 11, 12, 13]);
        assert_eq!(numbers(&context, &finding(Code::Pdo005, 13, Some(11), Some(5))), [2, 5, 8, 11, 13]);
    }

    #[test]
    fn a_long_transfer_keeps_its_beginning() {
        let mut context = FindingContext::default();
        sdo(&mut context, 1, 1, Side::Client, &[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
        sdo(&mut context, 2, 1, Side::Server, &[0x41, 0x08, 0x10, 0, 0xFF, 0, 0, 0]);
        for no in 3..=60 {
            let side = if no % 2 == 1 { Side::Client } else { Side::Server };
            sdo(&mut context, no, 1, side, &[if no % 2 == 1 { 0x60 } else { 0 }; 8]);
        }
        let toggle = finding(Code::Sdo001, 60, Some(59), Some(5));
        assert_eq!(numbers(&context, &toggle), [1, 2, 55, 56, 57, 58, 59, 60]);
        sdo(&mut context, 61, 2, Side::Client, &[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]);
        let next = finding(Code::Sdo002, 61, None, Some(5));
        assert_eq!(numbers(&context, &next), [54, 55, 56, 57, 58, 59, 60, 61]);
    }

    #[test]
    fn more_places_than_rings_share_one() {
        let mut context = FindingContext::default();
        for bus in 0..64 {
            for node in 1..128u8 {
                let mut one = frame(u64::from(bus) * 128 + u64::from(node), 0x700 + u16::from(node), &[5]);
                one.bus = BusId(bus);
                let mut said = event(&one, Some(node), What::Message(Message::GuardingRequest { node }));
                said.bus = one.bus;
                context.push(&one, &mut vec![said]);
            }
        }
        assert_eq!(context.rings.len(), RINGS);
        let last = Finding { bus: BusId(63), ..finding(Code::Hbt001, 63 * 128 + 127, None, Some(127)) };
        assert_eq!(numbers(&context, &last), [63 * 128 + 127]);
    }
}
