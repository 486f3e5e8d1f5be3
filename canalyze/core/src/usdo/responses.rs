//! The frames of servers, and their effect on the transfers.

use super::open::{OpenTransfer, TransferKey, UsdoPhase, told};
use super::sessions::Usdo;
use crate::rules::finding::Code;
use crate::rules::sdo::{Sdo001, Sdo002, Sdo003, Sdo007, Sdo024};
use crate::sdo::limits::{UNANSWERED_NS, within};
use crate::sdo::transfer::{Direction, Mode, Status, TransferId};
use crate::sdo::wire::Side;
use crate::wire::usdo::{Body, Pdu};
use crate::world::context::Context;
use crate::world::node::{Node, PerNode};

/// The abort code of an unknown session.
const NO_SESSION: u8 = 0x21;

impl Usdo {
    pub(super) fn server(
        &mut self,
        key: TransferKey,
        pdu: &Pdu<'_>,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<TransferId> {
        if matches!(pdu.body, Body::Undecoded | Body::Unknown) {
            return None;
        }
        if !self.is_open(key) && self.joins_all(key, pdu) {
            self.open_of_all(key, nodes, cx);
        }
        if !self.is_open(key) {
            return self.without_request(key, pdu, nodes, cx);
        }
        let one = self.running.get_mut(&key)?;
        let (id, at, object) = (one.transfer.id, cx.at, one.transfer.mux);
        if let Body::Abort(_, code) = pdu.body {
            one.transfer.last = at;
            return self.abort(key, Side::Server, code, nodes, cx);
        }
        let awaited = match one.phase {
            UsdoPhase::Initiated(0x01) => matches!(pdu.command, 0x21 | 0x32),
            UsdoPhase::Initiated(0x11) => matches!(pdu.command, 0x31 | 0x32),
            UsdoPhase::Initiated(_) => pdu.command == 0x22,
            UsdoPhase::Segments if one.is_upload() => matches!(pdu.command, 0x33 | 0x34),
            UsdoPhase::Segments => matches!(pdu.command, 0x23 | 0x24),
            UsdoPhase::Ending => matches!(pdu.command, 0x23 | 0x24),
            UsdoPhase::Over => false,
        };
        if !awaited {
            self.servers.find_lost_request(key.server, object, cx);
            return Some(id);
        }
        one.transfer.last = at;
        if one.is_upload() || pdu.command == 0x32 {
            one.transfer.described.told = told(&pdu.body).or(one.transfer.described.told);
        }
        let asked = one.asked.take();
        self.judge_time(key, asked, cx);
        let one = self.running.get_mut(&key)?;
        if let (Some(expected), Some(found)) = (object, pdu.mux())
            && expected != found
        {
            one.transfer.note_finding(Code::Sdo003);
            one.transfer.outcome.bad = true;
            self.servers.find(Sdo003::Objects { expected, found }, key.server, object, at, cx);
        }
        let one = self.running.get_mut(&key)?;
        match pdu.body {
            Body::Object(_) | Body::Expedited(..) if pdu.command == 0x21 => {
                let data = std::mem::take(&mut one.transfer.data.requested);
                one.transfer.append(&data);
                self.end(key, nodes, cx);
            }
            Body::Expedited(_, _, size, data) => {
                one.transfer.data.size_indicated = Some(size.into());
                one.transfer.data.initiated = Some(at);
                one.transfer.append(data);
                one.transfer.miss(Some(u64::from(size).saturating_sub(data.len() as u64)));
                self.end(key, nodes, cx);
            }
            Body::Initiate(_, _, size) => {
                // An answer of any size is a read, even to an expedited download.
                (one.transfer.direction, one.transfer.mode) = (Direction::Upload, Mode::Segmented);
                one.transfer.data.size_indicated = Some(size);
                one.transfer.data.initiated = Some(at);
                one.transfer.data.requested = Vec::new();
                one.phase = UsdoPhase::Segments;
            }
            Body::Object(_) => one.phase = UsdoPhase::Segments,
            Body::Segment(counter, data) => self.segment(key, counter, data, asked.is_some(), cx),
            Body::Counter(counter) => self.confirmed(key, counter, cx),
            Body::Last(_, data) => {
                let due = one.counter.unwrap_or(one.due);
                let missing = one.miss_until(due);
                one.transfer.append(data);
                one.transfer.reach_end();
                self.missing(key, missing, cx);
                self.end(key, nodes, cx);
            }
            _ => {
                if one.phase == UsdoPhase::Segments {
                    // The last segment is confirmed, and not in the capture.
                    let rest = one.transfer.rest();
                    one.transfer.miss(rest);
                    self.missing(key, 1, cx);
                }
                self.end(key, nodes, cx);
            }
        }
        Some(id)
    }

    /// Takes a segment of an upload.
    pub(super) fn segment(&mut self, key: TransferKey, found: u8, data: &[u8], asked: bool, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key) else { return };
        let object = one.transfer.mux;
        let expected = one.counter.filter(|_| asked && !one.wrapped).unwrap_or(found);
        if expected != found {
            one.transfer.note_finding(Code::Sdo001);
            one.transfer.outcome.bad = true;
            let what = wrong_counter(expected, found, Side::Server);
            return self.servers.find(what, key.server, object, cx.at, cx);
        }
        if found < one.due && !one.wrapped {
            return;
        }
        let missing = one.miss_until(found);
        one.append(data);
        self.missing(key, missing, cx);
    }

    /// Takes the confirmation of a segment of a download.
    pub(super) fn confirmed(&mut self, key: TransferKey, counter: u8, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key) else { return };
        let (object, sent) = (one.transfer.mux, one.counter);
        let mut missing = one.take_jump();
        if counter >= one.due && !one.wrapped {
            // The server took a segment that is missing in the capture.
            missing += one.miss_until(counter.saturating_add(1));
        } else if let Some(expected) = sent.filter(|sent| *sent != counter && !one.wrapped) {
            one.transfer.note_finding(Code::Sdo001);
            let what = wrong_counter(expected, counter, Side::Server);
            return self.servers.find(what, key.server, object, cx.at, cx);
        }
        self.missing(key, missing, cx);
    }

    /// Reports segments that are missing in the capture.
    pub(super) fn missing(&mut self, key: TransferKey, missing: u64, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key).filter(|_| missing > 0) else { return };
        one.transfer.note_finding(Code::Sdo024);
        let object = one.transfer.mux;
        self.servers.find(Sdo024::Missing { missing }, key.server, object, cx.at, cx);
    }

    /// Returns true if a response may belong to a request to all nodes.
    pub(super) fn joins_all(&self, key: TransferKey, pdu: &Pdu<'_>) -> bool {
        let fits = |request: &[u8]| {
            let object = Pdu::read(request).and_then(|request| request.mux());
            let answers = match request.get(1) {
                Some(0x11) => matches!(pdu.command, 0x31 | 0x32 | 0x7F),
                Some(0x01) => matches!(pdu.command, 0x21 | 0x7F),
                _ => matches!(pdu.command, 0x22 | 0x7F),
            };
            answers && pdu.mux() == object && !matches!(pdu.body, Body::Abort(_, NO_SESSION))
        };
        let asked = self.broadcast.get(&(key.client, key.session));
        asked.is_some_and(|(at, _, request)| {
            fits(request) && self.running.get(&key).is_none_or(|one| one.transfer.first.no < at.no)
        })
    }

    /// Opens the transfer of one server that responds to a request to all.
    pub(super) fn open_of_all(&mut self, key: TransferKey, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let Some((at, when, request)) = self.broadcast.get(&(key.client, key.session)).cloned() else { return };
        self.servers.asked_of_all(key.server);
        if let Some(pdu) = Pdu::read(&request) {
            self.begin(key, &pdu, nodes, cx);
        }
        if let Some(one) = self.running.get_mut(&key) {
            one.transfer.first = at;
            one.asked = Some(when);
        }
    }

    /// Takes a response without a running transfer: its request is not in the capture, or there was none.
    pub(super) fn without_request(
        &mut self,
        key: TransferKey,
        pdu: &Pdu<'_>,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<TransferId> {
        let stray = self.stray.take_if(|(of, _)| *of == key);
        let ended = self.running.get(&key).map(|one| (one.transfer.last, one.transfer.mux));
        match pdu.body {
            Body::Abort(_, NO_SESSION) if stray.is_some() => {
                let at = stray.map_or(cx.at, |(_, at)| at);
                self.servers.find_at(Sdo007::Outside, key.server, None, at, cx);
                return None;
            }
            // An abort may cross that of the other side.
            Body::Abort(..) => return None,
            _ => {}
        }
        if let Some((ended, object)) = ended
            && within(ended, cx.at, UNANSWERED_NS)
            && pdu.mux().is_none_or(|mux| object == Some(mux))
        {
            if pdu.mux().is_some() {
                self.servers.find(Sdo002::Duplicate, key.server, object, ended, cx);
            }
            return None;
        }
        let (direction, mode) = match pdu.command {
            0x31 => (Direction::Upload, Mode::Expedited),
            0x32 => (Direction::Upload, Mode::Segmented),
            0x22 => (Direction::Download, Mode::Segmented),
            _ => return None,
        };
        let mut transfer = self.transfer(key, direction, mode, pdu.mux(), cx);
        transfer.outcome.midway = true;
        transfer.described.told = told(&pdu.body);
        if self.servers.find_lost_request(key.server, pdu.mux(), cx) {
            transfer.note_finding(Code::Sdo002);
        }
        let id = transfer.id;
        let mut one = Box::new(OpenTransfer::new(transfer, UsdoPhase::Segments, None));
        match pdu.body {
            Body::Expedited(_, _, size, data) => {
                one.transfer.data.size_indicated = Some(size.into());
                one.transfer.append(data);
                one.transfer.reach_end();
                self.running.insert(key, one);
                self.complete(key, Status::Incomplete, true, nodes, cx);
            }
            Body::Initiate(_, _, size) => {
                one.transfer.data.size_indicated = Some(size);
                self.running.insert(key, one);
            }
            _ => {
                self.running.insert(key, one);
            }
        }
        Some(id)
    }
}

pub(super) fn wrong_counter(expected: u8, found: u8, by: Side) -> Sdo001 {
    Sdo001::Counter { expected: expected.into(), found: found.into(), by }
}
