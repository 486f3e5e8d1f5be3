//! The devices behind a node-ID: another one than before, two at once, and responses with another CAN-ID than the server's.

use std::collections::BTreeMap;

use crate::bytes::frame::{CanId, Frame, FrameRef, Kind};
use crate::bytes::ns::Ns;
use crate::problems::kinds::ProblemKind;
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Problem, Subject, bit};
use crate::problems::roles::KindRole;
use crate::problems::scene::Scene;
use crate::rules::finding::{Finding, Quantity};
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;

/// The identity object (CiA 301, 7.5.2.21).
const IDENTITY: u16 = 0x1018;
/// Maximum time between a request and a response, in ns.
const SOON_NS: Ns = Ns::from_ms(500);

/// The command bytes of responses that name an object: expedited uploads with their size, and downloads.
const RESPONSES: [u8; 5] = [0x43, 0x47, 0x4B, 0x4F, 0x60];
/// Maximum time between the responses of two servers to one request, in ns.
const SECOND_NS: Ns = Ns::from_ms(50);
/// Part of the shortest time between two requests for an object within which a second response is to the same request: after
/// that it is to the next one, which the recording has lost.
const TURN_PART: i64 = 4;
/// Number of second responses with other data that show two servers, and of requests in a row with two equal ones.
const DOUBLED: u64 = 3;
const EQUAL: u32 = 10;
/// Maximum number of objects whose requests are timed.
const TURNS: usize = 1024;
/// Maximum number of kept second responses.
const KEPT: usize = 64;

/// The identities and the open requests of a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Identities {
    /// The answer of a node to a part of its identity, and its boot-ups until then.
    known: BTreeMap<(u8, u8), (Vec<u8>, u32)>,
    boots: BTreeMap<u8, u32>,
    /// The open request of each node.
    asked: BTreeMap<u8, (Mux, FrameRef)>,
    /// The frame that may be the response to the open request of a node: the request, the frame and its CAN-ID.
    candidates: BTreeMap<u8, (Mux, FrameRef, FrameRef, CanId)>,
    elsewhere: BTreeMap<u8, LedgerPlace>,
    /// Nodes that were requested, one bit each; the first response of another server to a node's request.
    requested: u128,
    strange: BTreeMap<u8, (CanId, FrameRef, FrameRef)>,
    /// The last request for an object of each node, and the shortest time between two of them, in ns.
    turns: BTreeMap<(u8, Mux), (FrameRef, Option<Ns>)>,
    /// The last response of each node that names an object; and the number of requests in a row with two equal ones, up
    /// to that which has had one.
    answers: BTreeMap<u8, (Mux, [u8; 8], FrameRef)>,
    equal: BTreeMap<u8, (u32, bool)>,
    /// Second responses, which may be of another request that is listed late: how much each shows, by which fact.
    second: Vec<(u8, (u64, &'static str), FrameRef)>,
    /// The first of those of each node that are known to have no request, and what they show together.
    doubled: BTreeMap<u8, (FrameRef, u64)>,
}

impl Identities {
    /// Processes a boot-up.
    pub(in crate::problems) fn booted(&mut self, node: u8) {
        let boots = self.boots.entry(node).or_insert(0);
        *boots = boots.saturating_add(1);
    }

    /// Processes the end of an SDO transfer.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        let read = transfer.direction == Direction::Upload && transfer.outcome.status == Status::Ok;
        let Some(mux) = transfer.mux.filter(|mux| read && mux.index == IDENTITY && matches!(mux.sub, 1..=4)) else {
            return;
        };
        let (node, value) = (transfer.node, transfer.data.kept.clone());
        if value.len() != 4 {
            return;
        }
        let boots = self.boots.get(&node).copied().unwrap_or(0);
        let Some((before, then)) = self.known.insert((node, mux.sub), (value.clone(), boots)) else { return };
        if before == value || then == boots {
            return;
        }
        let (kind, subject) = (ProblemKind::AnotherDevice, Subject::node(node));
        let open = scene.ledger.last(scene.id, |one| one.kind == kind && one.subject.node == Some(node));
        if open.is_some() {
            return;
        }
        let place = scene.ledger.open(kind, scene.id, subject, transfer.last, transfer.last);
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
            one.fact("object", Quantity::Object(mux));
            let number = |bytes: &[u8]| bytes.iter().rev().fold(0_u32, |all, byte| all << 8 | u32::from(*byte));
            one.fact("was", Quantity::Hex8(number(&before)));
            one.fact("is", Quantity::Hex8(number(&value)));
        }
    }

    /// Records that the client of a node names an object: in a request, or as it gives up.
    pub(in crate::problems) fn asked(&mut self, node: u8, mux: Mux, frame: &Frame, scene: &mut Scene<'_>) {
        let [command, ..] = frame.data;
        if frame.id.raw() != 0x600 + u32::from(node) || RESPONSES.contains(&command) {
            return;
        }
        if let Some(candidate) = self.candidates.remove(&node) {
            self.elsewhere(node, candidate, scene);
        }
        self.requested |= bit(node);
        self.turn((node, mux), frame.reference());
        self.asked.insert(node, (mux, frame.reference()));
    }

    /// Records the time between requests for one object.
    fn turn(&mut self, of: (u8, Mux), at: FrameRef) {
        if self.turns.len() >= TURNS && !self.turns.contains_key(&of) {
            return;
        }
        let (last, shortest) = self.turns.entry(of).or_insert((at, None));
        if let Some(since) = at.since(*last).filter(|since| *since > Ns::ZERO) {
            *shortest = Some(shortest.map_or(since, |shortest| shortest.min(since)));
        }
        *last = at;
    }

    /// Processes a response of a server; several second ones to the same requests are of two servers.
    pub(in crate::problems) fn answered(&mut self, node: u8, mux: Option<Mux>, frame: &Frame) {
        if frame.id.raw() != 0x580 + u32::from(node) {
            return;
        }
        let asked = self.asked.remove(&node);
        self.candidates.remove(&node);
        let Some(mux) = mux else { return };
        let (at, bytes) = (frame.reference(), frame.head());
        let earlier = self.answers.insert(node, (mux, bytes, at));
        let (row, doubled) = self.equal.entry(node).or_default();
        if asked.is_some() {
            // The request before had one response.
            *row = if std::mem::take(doubled) { *row } else { 0 };
        }
        let Some((before, first, then)) = earlier.filter(|_| asked.is_none()) else { return };
        let turn = self.turns.get(&(node, mux)).and_then(|(_, shortest)| *shortest);
        let limit = turn.map_or(SECOND_NS, |turn| SECOND_NS.min(turn - turn / TURN_PART));
        let soon = at.since(then).is_none_or(|since| (Ns::ZERO..limit).contains(&since));
        if before != mux || !soon {
            return;
        }
        let shows = if first == bytes {
            (*row, *doubled) = (row.saturating_add(1), true);
            (if *row == EQUAL { DOUBLED } else { 0 }, "equal_answers")
        } else {
            // No device has two identities.
            (if mux.index == IDENTITY { DOUBLED } else { 1 }, "answers")
        };
        if self.second.len() >= KEPT {
            self.second.remove(0);
        }
        self.second.push((node, shows, at));
    }

    /// Processes the finding that a response has no request: it may be the second one to the same.
    pub(in crate::problems) fn unasked(&mut self, node: u8, finding: &Finding, scene: &mut Scene<'_>) {
        let at = finding.at;
        let place = self.second.iter().position(|(of, _, second)| (*of, second.no) == (node, at.no));
        let Some((_, (shown, fact), _)) = place.map(|place| self.second.remove(place)) else { return };
        let doubled = self.doubled.entry(node).or_insert((at, 0));
        let before = doubled.1;
        doubled.1 += shown;
        if before >= DOUBLED || doubled.1 < DOUBLED {
            return;
        }
        let begin = doubled.0;
        let shows = |one: &Problem| one.kind.is(KindRole::Violation) && one.subject.node == Some(node);
        let place = scene.ledger.last(scene.id, shows);
        let place = place.or_else(|| scene.ledger.double(scene.id, node, begin, at));
        let Some(place) = place else { return };
        let place = scene.ledger.doubles(place, at, None);
        if let Some(one) = scene.ledger.get_mut(place) {
            one.fact(fact, Quantity::Count(2));
        }
    }

    /// Looks at a frame of eight bytes that may be the response to an open request.
    #[inline]
    pub(in crate::problems) fn frame(&mut self, frame: &Frame) {
        if self.asked.is_empty() || frame.kind != Kind::Data || frame.len != 8 {
            return;
        }
        let [command, low, high, sub, ..] = frame.data;
        if !RESPONSES.contains(&command) || frame.id.is_extended() {
            return;
        }
        let mux = Mux { index: u16::from_le_bytes([low, high]), sub };
        let (at, id) = (frame.reference(), frame.id.raw());
        let soon = |asked: FrameRef| at.since(asked).is_none_or(|since| (Ns::ZERO..SOON_NS).contains(&since));
        let mut open = self.asked.iter().filter(|(_, (asked, when))| *asked == mux && at.no > when.no && soon(*when));
        // That of a server with a request of its own may be the response to that, listed late.
        if (0x581..=0x5FF).contains(&id) && self.requested >> (id & 0x7F) & 1 != 0 {
            return;
        }
        if let Some((node, (_, begin))) = open.next() {
            self.candidates.insert(*node, (mux, *begin, at, frame.id));
        }
    }

    /// Concludes at the end of the capture.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        for (node, candidate) in std::mem::take(&mut self.candidates) {
            self.elsewhere(node, candidate, scene);
        }
        // What was answered with another CAN-ID is not unanswered.
        for (node, place) in &self.elsewhere {
            let unanswered = scene.ledger.last(scene.id, |one| {
                let asked = one.kind.is(KindRole::Asked);
                asked && one.subject.node == Some(*node)
            });
            if let Some(unanswered) = unanswered {
                scene.ledger.merge(unanswered, *place);
            }
        }
    }

    /// Records a request whose response came with another CAN-ID only.
    fn elsewhere(&mut self, node: u8, found: (Mux, FrameRef, FrameRef, CanId), scene: &mut Scene<'_>) {
        let (mux, mut begin, mut at, id) = found;
        let known = self.elsewhere.get(&node).copied();
        let mut twice = false;
        if (0x581..=0x5FF).contains(&id.raw()) && known.is_none() {
            // Of another server two responses show it.
            if self.requested >> (id.raw() & 0x7F) & 1 != 0 {
                return;
            }
            match self.strange.insert(node, (id, begin, at)) {
                Some((before, first, then)) if before == id => (begin, at, twice) = (first, then, true),
                _ => return,
            }
        }
        let kind = ProblemKind::AnswerElsewhere;
        let place = known.or_else(|| scene.ledger.open(kind, scene.id, Subject::node(node), begin, at));
        let Some((place, one)) = place.and_then(|place| Some((place, scene.ledger.get_mut(place)?))) else { return };
        if known.is_some() || twice {
            one.again(begin);
        }
        one.fact("object", Quantity::Object(mux));
        one.fact("id", Quantity::Id(id));
        self.elsewhere.insert(node, place);
    }
}
