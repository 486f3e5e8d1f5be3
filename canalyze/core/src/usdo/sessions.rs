//! The running USDO transfers of a bus, and what each frame does to them.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::servers::Servers;
use crate::bytes::frame::{Frame, FrameRef};
use crate::evidence::When;
use crate::evidence::duplicates::Sighting;
use crate::rules::finding::{Code, Verdict};
use crate::rules::sdo::{Sdo001, Sdo002, Sdo003, Sdo006, Sdo007, Sdo017, Sdo020, Sdo024};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::channel::{Interruption, chunk};
use crate::sdo::limits::{GIVEN_UP_NS, UNANSWERED_NS, within};
use crate::sdo::proof::OneSided;
use crate::sdo::transfer::{Abort, Beginning, Direction, Mode, Status, Transfer, TransferId, UsdoSession};
use crate::sdo::wire::{Mux, Side};
use crate::wire::message::Message;
use crate::wire::usdo::{Body, Pdu, SEGMENT};
use crate::words::profiles::Profile;
use crate::world::context::Context;
use crate::world::dictionary::Described;
use crate::world::event::{Event, Note, What};
use crate::world::node::{Node, PerNode};
use crate::world::od::DataType;

/// Maximum number of transfers kept (invariant 6); ended ones make room.
const KEPT: usize = 1024;
/// The abort code of a wrong counter.
const COUNTER: u8 = 0x14;
/// The abort codes of a wrong size.
const SIZES: [u8; 4] = [0x15, 0x36, 0x37, 0x38];
/// The abort code of an unknown session.
const NO_SESSION: u8 = 0x21;

/// The identity of a transfer: client, server and session-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TransferKey {
    pub(super) client: u8,
    pub(super) server: u8,
    pub(super) session: u8,
}

/// The next frame of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UsdoPhase {
    /// The response to the initiate request with this command.
    Initiated(u8),
    /// The next segment, its request or its response.
    Segments,
    /// The response to the last segment of a download.
    Ending,
    /// Nothing: it has ended.
    Over,
}

/// A segment whose counter skips others. They are missing in the capture if the server takes it.
#[derive(Debug)]
struct Jump {
    at: FrameRef,
    found: u8,
    data: Vec<u8>,
}

/// A transfer and its state.
#[derive(Debug)]
struct OpenTransfer {
    transfer: Transfer,
    phase: UsdoPhase,
    /// The request that waits for its response.
    asked: Option<When>,
    /// The counter that this request carries.
    counter: Option<u8>,
    /// The counter of the next segment, and true once it has begun anew, which no source describes.
    due: u8,
    wrapped: bool,
    jump: Option<Jump>,
    /// The missing response was reported at this frame.
    reported: Option<FrameRef>,
    /// The client has asked for the same in another session.
    given_up: bool,
    /// The client went on in another session so soon that it had its response.
    went_on: bool,
}

impl OpenTransfer {
    fn new(transfer: Transfer, phase: UsdoPhase, asked: Option<When>) -> Self {
        let (counter, due, wrapped, jump) = (None, 0, false, None);
        let (reported, given_up, went_on) = (None, false, false);
        Self { transfer, phase, asked, counter, due, wrapped, jump, reported, given_up, went_on }
    }

    fn is_upload(&self) -> bool {
        self.transfer.direction == Direction::Upload
    }

    /// Lists the verdict on a request without response and returns it.
    fn unanswered(&mut self) -> Verdict {
        let verdict: Verdict = if self.went_on { Sdo024::Response.into() } else { Sdo002::NoResponse.into() };
        self.transfer.note_finding(verdict.code);
        verdict
    }

    /// Takes the data of a segment.
    fn append(&mut self, data: &[u8]) {
        self.transfer.append(data);
        self.transfer.data.segments = self.transfer.data.segments.saturating_add(1);
        let (due, wrapped) = self.due.overflowing_add(1);
        (self.due, self.wrapped) = (due, self.wrapped | wrapped);
    }

    /// Marks the segments before the one with this counter as missing; returns their number.
    fn miss_until(&mut self, counter: u8) -> u64 {
        let missing = u64::from(counter.saturating_sub(self.due));
        if !self.wrapped && missing > 0 {
            self.transfer.miss(Some(missing.saturating_mul(SEGMENT as u64)));
            self.due = counter;
            return missing;
        }
        0
    }

    /// Takes a held segment, and those before it as missing; returns their number.
    fn take_jump(&mut self) -> u64 {
        let Some(jump) = self.jump.take() else { return 0 };
        let missing = self.miss_until(jump.found);
        self.append(&jump.data);
        missing
    }
}

/// The USDO transfers of a bus.
#[derive(Debug, Default)]
pub struct Usdo {
    running: BTreeMap<TransferKey, Box<OpenTransfer>>,
    /// Requests to all nodes by client and session-ID, until the client uses the session-ID again.
    broadcast: BTreeMap<(u8, u8), (FrameRef, When, Vec<u8>)>,
    /// A client frame without a transfer, which the server may refuse.
    stray: Option<(TransferKey, FrameRef)>,
    pub(super) servers: Servers,
}

impl Usdo {
    /// Takes a frame: appends its own event and its consequences.
    pub fn step(&mut self, message: Message, frame: &Frame, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let Message::Usdo { request, source, destination, .. } = message else { return };
        let (client, server) = if request { (source, destination) } else { (destination, source) };
        let place = cx.events.len();
        cx.push(None, Some(server).filter(|server| (1..=127).contains(server)), What::Message(message));
        let Some(pdu) = Pdu::read(frame.payload()).filter(|_| cx.sighting != Sighting::Duplicate) else { return };
        if client > 127 || server > 127 {
            // A group of nodes, or no node.
            return;
        }
        let key = TransferKey { client, server, session: pdu.session };
        self.servers.count(request, server, &pdu, usize::from(frame.len), cx);
        let id = match (request, server) {
            (true, 0) => self.sent_to_all(key, &pdu, frame, nodes, cx),
            (true, _) => self.client(key, &pdu, nodes, cx),
            (false, _) => self.server(key, &pdu, nodes, cx),
        };
        if let Some(event) = cx.events.get_mut(place) {
            event.transfer = id;
        }
    }

    /// Takes a request to all nodes: the transfers are those of the servers that respond.
    fn sent_to_all(
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

    fn is_open(&self, key: TransferKey) -> bool {
        self.running.get(&key).is_some_and(|one| one.phase != UsdoPhase::Over)
    }

    fn client(
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
    fn begin(
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

    fn transfer(
        &self,
        key: TransferKey,
        direction: Direction,
        mode: Mode,
        mux: Option<Mux>,
        cx: &mut Context<'_>,
    ) -> Transfer {
        *cx.next_transfer = cx.next_transfer.saturating_add(1);
        let id = TransferId(*cx.next_transfer);
        let beginning = Beginning { id, bus: cx.bus, node: key.server, channel: None, extract: cx.extract, at: cx.at };
        let session = Some(UsdoSession { client: key.client, id: key.session });
        Transfer { session, ..Transfer::new(beginning, direction, mode, mux) }
    }

    /// Ends a transfer whose client begins another one in its session.
    fn leave(&mut self, key: TransferKey, pdu: &Pdu<'_>, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
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

    fn server(
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
    fn segment(&mut self, key: TransferKey, found: u8, data: &[u8], asked: bool, cx: &mut Context<'_>) {
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
    fn confirmed(&mut self, key: TransferKey, counter: u8, cx: &mut Context<'_>) {
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
    fn missing(&mut self, key: TransferKey, missing: u64, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key).filter(|_| missing > 0) else { return };
        one.transfer.note_finding(Code::Sdo024);
        let object = one.transfer.mux;
        self.servers.find(Sdo024::Missing { missing }, key.server, object, cx.at, cx);
    }

    /// Returns true if a response may belong to a request to all nodes.
    fn joins_all(&self, key: TransferKey, pdu: &Pdu<'_>) -> bool {
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
    fn open_of_all(&mut self, key: TransferKey, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
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
    fn without_request(
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

    /// Takes an abort of a running transfer.
    fn abort(
        &mut self,
        key: TransferKey,
        by: Side,
        code: u8,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<TransferId> {
        let one = self.running.get_mut(&key)?;
        let (id, object, data) = (one.transfer.id, one.transfer.mux, &one.transfer.data);
        let indicated = data.size_indicated.map_or(0, u64::from);
        let transferred = data.size;
        let ended = one.phase == UsdoPhase::Ending && !data.hole && data.size_indicated.is_some();
        if by == Side::Server
            && let Some(jump) = one.jump.take()
        {
            if code == COUNTER {
                one.transfer.note_finding(Code::Sdo001);
                let what = wrong_counter(one.due, jump.found, Side::Client);
                self.servers.find_at(what, key.server, object, jump.at, cx);
                one.transfer.append(&jump.data);
            } else {
                one.jump = Some(jump);
                one.take_jump();
            }
        } else if by == Side::Server && SIZES.contains(&code) && ended && transferred != indicated {
            one.transfer.note_finding(Code::Sdo006);
            let asked = one.asked.map_or(cx.at, |asked| asked.at);
            self.servers.find_at(Sdo006::Size { indicated, transferred }, key.server, object, asked, cx);
        }
        let one = self.running.get_mut(&key)?;
        let code = AbortCode::Usdo(code);
        one.transfer.outcome.abort = Some(Abort { code, by });
        one.transfer.note_finding(Code::Sdo017);
        if matches!(one.phase, UsdoPhase::Initiated(0x01)) {
            // What the client meant to write.
            let data = one.transfer.data.requested.clone();
            one.transfer.append(&data);
        }
        self.servers.find(Sdo017::Abort { abort: code, by }, key.server, object, cx.at, cx);
        if by == Side::Server && one.transfer.direction == Direction::Download {
            self.servers.refuse(key.server, object, code, cx.at);
        }
        self.complete(key, Status::Aborted, true, nodes, cx);
        Some(id)
    }

    /// Ends a transfer whose last frame has come; judges its size.
    fn end(&mut self, key: TransferKey, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key) else { return };
        one.take_jump();
        let (object, data) = (one.transfer.mux, &one.transfer.data);
        let missing = data.size_indicated.map_or(0, |size| u64::from(size).saturating_sub(data.size));
        let mut status = Status::Ok;
        if one.transfer.outcome.midway || data.hole {
            status = Status::Incomplete;
        } else if !one.transfer.size_is_right() {
            let (indicated, transferred) = (data.size_indicated.map_or(0, u64::from), data.size);
            // The counter in the request for the last segment of an upload shows that none is missing.
            let uncounted = !one.is_upload() || one.counter.is_none() || one.wrapped;
            let whole = missing > 0 && missing % SEGMENT as u64 == 0;
            if whole && uncounted && one.transfer.mode == Mode::Segmented {
                // Both sides took it as complete: what is missing are whole segments before the last one.
                let before = transferred.saturating_sub(transferred % SEGMENT as u64);
                one.transfer.miss_before(before);
                self.missing(key, missing / SEGMENT as u64, cx);
                status = Status::Incomplete;
            } else {
                one.transfer.note_finding(Code::Sdo006);
                self.servers.find(Sdo006::Size { indicated, transferred }, key.server, object, cx.at, cx);
                status = Status::Failed;
            }
        }
        self.complete(key, status, true, nodes, cx);
    }

    /// Ends a transfer; `own`: with the current frame.
    fn complete(&mut self, key: TransferKey, status: Status, own: bool, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key) else { return };
        one.take_jump();
        one.phase = UsdoPhase::Over;
        one.asked = None;
        let mut transfer = one.transfer.clone();
        // Only number and object are needed to know a second response.
        one.transfer.data.kept = Vec::new();
        one.transfer.data.fresh = Vec::new();
        let node = nodes.get(key.server);
        let object = transfer.mux.and_then(|mux| {
            node?.configuration.description().and_then(|description| description.get(mux.index, mux.sub)).cloned()
        });
        let (profile, told) = (node.map_or(Profile::UNKNOWN, Node::profile), transfer.described.told);
        transfer.described = Described { object, profile, told };
        if !self.servers.is_known(key.server) {
            // Nothing has been reported of a server that is not known.
            transfer.outcome.findings.clear();
        }
        let bad = transfer.outcome.bad && status == Status::Ok;
        transfer.outcome.status = if bad { Status::Failed } else { status };
        transfer.settle_holes();
        if transfer.outcome.status == Status::Ok && transfer.direction == Direction::Download {
            self.servers.written(key.server, transfer.mux);
        }
        if !transfer.data.fresh.is_empty() {
            let fresh = std::mem::take(&mut transfer.data.fresh);
            cx.chunks.push(chunk(&transfer, fresh));
        }
        let about = (!own).then(|| Box::new(transfer.last));
        let (bus, node, id) = (transfer.bus, Some(transfer.node), Some(transfer.id));
        let what = What::Transfer(Arc::new(transfer));
        cx.events.push(Event { at: cx.at, about, bus, node, transfer: id, what });
    }

    /// Reports a response later than clients wait.
    fn judge_time(&mut self, key: TransferKey, asked: Option<When>, cx: &mut Context<'_>) {
        let Some(one) = self.running.get_mut(&key) else { return };
        let Some(asked) = asked else { return };
        let (object, reported) = (one.transfer.mux, one.reported);
        if std::mem::take(&mut one.given_up) {
            one.transfer.note_finding(Code::Sdo020);
            return self.servers.find(Sdo020::GivenUp, key.server, object, asked.at, cx);
        }
        if self.servers.judge_time(key.server, object, asked, reported, cx)
            && let Some(one) = self.running.get_mut(&key)
        {
            one.transfer.note_finding(Code::Sdo020);
        }
    }

    /// Reports requests without response at `now_ns`.
    pub fn rest(&mut self, now_ns: i64, cx: &mut Context<'_>) {
        if !self.servers.may_be_due(now_ns) {
            return;
        }
        let mut next = None;
        for (key, one) in &mut self.running {
            let Some(asked) = one.asked.filter(|_| one.reported.is_none()) else { continue };
            if self.servers.is_overdue(key.server, one.transfer.mux, asked, now_ns, cx) {
                one.reported = Some(cx.at);
                let verdict = one.unanswered();
                self.servers.find(verdict, key.server, one.transfer.mux, asked.at, cx);
            } else if self.servers.is_awaited(key.server, one.transfer.mux) {
                next = [next, asked.at.t_ns].into_iter().flatten().min();
            }
        }
        self.servers.wait_from(next);
    }

    /// Ends what was open on one server (or all) after a reset or lost frames.
    pub fn lost(&mut self, server: Option<u8>, by: Interruption, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let reset = by != Interruption::LostFrames;
        let all: Vec<TransferKey> = self.running.keys().copied().collect();
        let concerned = |key: &TransferKey| server.is_none_or(|node| node == key.server || node == key.client);
        for key in all.into_iter().filter(concerned) {
            if self.is_open(key)
                && reset
                && let Some(one) = self.running.get(&key)
            {
                let (about, id) = (Some(Box::new(one.transfer.first)), Some(one.transfer.id));
                let what = What::Note(Note::LostByReset);
                cx.events.push(Event { at: cx.at, about, bus: cx.bus, node: Some(key.server), transfer: id, what });
            }
            if self.is_open(key) {
                self.complete(key, Status::Incomplete, false, nodes, cx);
            }
            self.running.remove(&key);
        }
        self.stray = None;
        if !reset {
            self.broadcast.clear();
            self.servers.restart();
        }
    }

    /// Returns the number of frames, and whether they are known to be USDO.
    pub fn shown(&self) -> Option<(Option<bool>, u64)> {
        self.servers.shown()
    }

    /// Returns the servers of which one direction only was recorded.
    pub fn one_sided(&self) -> Vec<OneSided> {
        self.servers.one_sided()
    }

    /// Reports what is open at the end of the capture.
    pub fn finish(&mut self, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let mut open: Vec<(u64, TransferKey)> = self
            .running
            .iter()
            .filter(|(_, one)| one.phase != UsdoPhase::Over)
            .map(|(key, one)| (one.transfer.first.no, *key))
            .collect();
        open.sort();
        for (_, key) in open {
            if let Some(one) = self.running.get_mut(&key)
                && let Some(asked) = one.asked.filter(|_| one.reported.is_none())
                && self.servers.is_old(asked, cx)
                && self.servers.is_known(key.server)
            {
                let verdict = one.unanswered();
                self.servers.find(verdict, key.server, one.transfer.mux, asked.at, cx);
            }
            self.complete(key, Status::Incomplete, false, nodes, cx);
        }
        self.servers.finish(cx);
    }
}

fn wrong_counter(expected: u8, found: u8, by: Side) -> Sdo001 {
    Sdo001::Counter { expected: expected.into(), found: found.into(), by }
}

/// Returns the data type that a frame names.
fn told(body: &Body<'_>) -> Option<DataType> {
    match body {
        Body::Expedited(_, code, ..) | Body::Initiate(_, code, _) => DataType::from_code(u16::from(*code)),
        _ => None,
    }
}

/// Returns the counter that a client's frame carries.
fn counter(body: &Body<'_>) -> Option<u8> {
    match body {
        Body::Segment(counter, _) | Body::Counter(counter) => Some(*counter),
        _ => None,
    }
}
