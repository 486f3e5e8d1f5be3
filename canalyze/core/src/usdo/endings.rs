//! The ends of transfers, and what is found without a frame of them: by time, by a reset, at the capture's end.

use std::sync::Arc;

use super::open::{TransferKey, UsdoPhase};
use super::responses::wrong_counter;
use super::sessions::Usdo;
use crate::bytes::ns::Ns;
use crate::evidence::When;
use crate::rules::finding::Code;
use crate::rules::sdo::{Sdo006, Sdo017, Sdo020};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::channel::{Interruption, chunk};
use crate::sdo::transfer::{Abort, Direction, Mode, Status, TransferId};
use crate::sdo::wire::Side;
use crate::wire::usdo::SEGMENT;
use crate::words::profiles::Profile;
use crate::world::context::Context;
use crate::world::dictionary::Described;
use crate::world::event::{Event, Note, What};
use crate::world::node::{Node, PerNode};

/// The abort code of a wrong counter.
const COUNTER: u8 = 0x14;
/// The abort codes of a wrong size.
const SIZES: [u8; 4] = [0x15, 0x36, 0x37, 0x38];

impl Usdo {
    /// Takes an abort of a running transfer.
    pub(super) fn abort(
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
    pub(super) fn end(&mut self, key: TransferKey, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
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
    pub(super) fn complete(
        &mut self,
        key: TransferKey,
        status: Status,
        own: bool,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) {
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
    pub(super) fn judge_time(&mut self, key: TransferKey, asked: Option<When>, cx: &mut Context<'_>) {
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
    #[inline]
    pub fn rest(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        if self.servers.may_be_due(now_ns) {
            self.decide(now_ns, cx);
        }
    }

    fn decide(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
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
