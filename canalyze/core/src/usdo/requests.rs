//! The frames of clients, and their effect on the transfers.

use super::open::{Jump, OpenTransfer, TransferKey, UsdoPhase, counter, told};
use super::sessions::{KEPT, Usdo};
use crate::bytes::frame::Frame;
use crate::rules::finding::Code;
use crate::rules::sdo::{Sdo002, Sdo024};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::limits::{GIVEN_UP_NS, within};
use crate::sdo::transfer::{Direction, Mode, Status, TransferId};
use crate::sdo::wire::Side;
use crate::wire::usdo::{Body, Pdu};
use crate::world::context::Context;
use crate::world::node::{Node, PerNode};

impl Usdo {
    /// Takes a request to all nodes: the transfers are those of the servers that respond.
    pub(super) fn sent_to_all(
        &mut self,
        key: TransferKey,
        pdu: &Pdu<'_>,
        frame: &Frame,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<TransferId> {
        if matches!(pdu.command, 0x01 | 0x02 | 0x11) {
            let sender = (key.client, key.session);
            if self.broadcast.len() >= KEPT && !self.broadcast.contains_key(&sender) {
                self.broadcast.clear();
            }
            self.broadcast.insert(sender, (cx.at, cx.when, frame.payload().to_vec()));
            let own = |one: &&TransferKey| (one.client, one.session) == sender;
            let before: Vec<TransferKey> = self.running.keys().filter(own).copied().collect();
            for key in before {
                if self.is_open(key) {
                    self.complete(key, Status::Incomplete, false, nodes, cx);
                }
            }
            return None;
        }
        let own = |one: &&TransferKey| one.client == key.client && one.session == key.session;
        let all: Vec<TransferKey> = self.running.keys().filter(own).copied().collect();
        for key in all {
            if self.is_open(key) {
                self.client(key, pdu, nodes, cx);
            }
        }
        None
    }

    pub(super) fn client(
        &mut self,
        key: TransferKey,
        pdu: &Pdu<'_>,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<TransferId> {
        if matches!(pdu.body, Body::Expedited(..) | Body::Initiate(..) | Body::Object(_)) {
            // Commands of a server begin nothing.
            return if matches!(pdu.command, 0x01 | 0x02 | 0x11) { self.begin(key, pdu, nodes, cx) } else { None };
        }
        if matches!(pdu.body, Body::Undecoded | Body::Unknown) {
            return None;
        }
        let Some(one) = self.running.get_mut(&key).filter(|one| one.phase != UsdoPhase::Over) else {
            self.stray = (!matches!(pdu.body, Body::Abort(..))).then_some((key, cx.at));
            return None;
        };
        let (id, at, mux) = (one.transfer.id, cx.at, one.transfer.mux);
        one.transfer.last = at;
        if let Body::Abort(_, code) = pdu.body {
            let asked = one.asked.take();
            if let Some(asked) = asked.filter(|_| AbortCode::Usdo(code).is_timeout() && one.reported.is_none()) {
                one.transfer.note_finding(Code::Sdo002);
                self.servers.find(Sdo002::NoResponse, key.server, mux, asked.at, cx);
            }
            return self.abort(key, Side::Client, code, nodes, cx);
        }
        // The client goes on: it has the response that the capture lacks.
        let initiated = matches!(one.phase, UsdoPhase::Initiated(_));
        let on = one.counter != counter(&pdu.body) && !one.is_upload();
        if one.asked.is_some() && (initiated || on) {
            let missing = one.take_jump();
            let lacking = if missing > 0 { Sdo024::Missing { missing } } else { Sdo024::Response };
            one.transfer.note_finding(Code::Sdo024);
            self.servers.find(lacking, key.server, mux, at, cx);
        }
        if one.phase != UsdoPhase::Ending {
            one.phase = UsdoPhase::Segments;
        }
        match pdu.body {
            Body::Segment(counter, data) if !one.is_upload() => {
                if counter == one.due || one.wrapped {
                    one.append(data);
                } else if counter > one.due {
                    one.jump = Some(Jump { at, found: counter, data: data.to_vec() });
                }
            }
            Body::Last(_, data) if !one.is_upload() => {
                one.transfer.append(data);
                one.transfer.reach_end();
                one.phase = UsdoPhase::Ending;
            }
            Body::Counter(_) => {
                (one.transfer.direction, one.transfer.mode) = (Direction::Upload, Mode::Segmented);
                if initiated {
                    // The response that gives the size is not in the capture.
                    one.transfer.data.size_indicated = None;
                    one.transfer.data.requested = Vec::new();
                }
            }
            _ => return Some(id),
        }
        (one.asked, one.counter) = (Some(cx.when), counter(&pdu.body));
        Some(id)
    }

    /// Begins a transfer with its initiate request.
    pub(super) fn begin(
        &mut self,
        key: TransferKey,
        pdu: &Pdu<'_>,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<TransferId> {
        if self.is_open(key) {
            self.leave(key, pdu, nodes, cx);
        }
        if pdu.destination != 0 {
            self.broadcast.remove(&(key.client, key.session));
        }
        if self.running.len() >= KEPT {
            self.running.retain(|_, one| one.phase != UsdoPhase::Over);
            let oldest = self.running.iter().min_by_key(|(_, one)| one.transfer.first.no).map(|(key, _)| *key);
            if let Some(oldest) = oldest.filter(|_| self.running.len() >= KEPT) {
                self.complete(oldest, Status::Incomplete, false, nodes, cx);
                self.running.remove(&oldest);
            }
        }
        let mux = pdu.mux();
        let direction = if pdu.command == 0x11 { Direction::Upload } else { Direction::Download };
        let mode = if pdu.command == 0x02 { Mode::Segmented } else { Mode::Expedited };
        let mut transfer = self.transfer(key, direction, mode, mux, cx);
        match pdu.body {
            Body::Expedited(_, _, size, data) => {
                transfer.data.size_indicated = Some(size.into());
                transfer.data.requested = data.to_vec();
            }
            Body::Initiate(_, _, size) => transfer.data.size_indicated = Some(size),
            _ => {}
        }
        transfer.described.told = told(&pdu.body);
        let id = transfer.id;
        // A client that asks for the same in another session has given up the first.
        for (other, one) in &mut self.running {
            let same = one.transfer.mux == mux && one.transfer.direction == direction;
            let at = (other.client, other.server) == (key.client, key.server) && other.session != key.session;
            let waited = one.asked.is_some_and(|asked| !within(asked.at, cx.at, GIVEN_UP_NS));
            one.given_up |= at && same && waited && matches!(one.phase, UsdoPhase::Initiated(_));
            one.went_on |= at && !same && one.asked.is_some_and(|asked| self.servers.goes_on(key.server, asked, cx));
        }
        self.servers.asked(key.server, mux, cx.at);
        self.running
            .insert(key, Box::new(OpenTransfer::new(transfer, UsdoPhase::Initiated(pdu.command), Some(cx.when))));
        Some(id)
    }

    /// Ends a transfer whose client begins another one in its session.
    pub(super) fn leave(&mut self, key: TransferKey, pdu: &Pdu<'_>, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key) else { return };
        let mux = one.transfer.mux;
        let again = one.phase == UsdoPhase::Initiated(pdu.command) && one.transfer.mux == pdu.mux();
        if let Some(asked) = one.asked.filter(|_| one.reported.is_none()) {
            if again && cx.evidence.recording.is_sent_again(asked.at, cx.at) {
                one.transfer.note_finding(Code::Sdo015);
                self.servers.find(Code::Sdo015, key.server, mux, asked.at, cx);
            } else if !again {
                one.went_on |= self.servers.goes_on(key.server, asked, cx);
                let verdict = one.unanswered();
                self.servers.find(verdict, key.server, mux, asked.at, cx);
            }
        } else if one.reported.is_none() {
            one.transfer.note_finding(Code::Sdo008);
            self.servers.find(Code::Sdo008, key.server, mux, cx.at, cx);
        }
        self.complete(key, Status::Incomplete, false, nodes, cx);
    }
}
