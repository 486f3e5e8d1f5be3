//! Aborts (CiA 301, 7.2.4.3.17): they end the transfer, whoever sends them, and are never answered.
//!
//! The multiplexor of an abort is unreliable, so an abort belongs to its channel's transfer, not to an object. Its
//! provoking request may be captured after it, and frames that were under way may follow it.

use super::channel::{Channel, Half, Outside, Phase, strict_initiate};
use super::exchange::expedited;
use super::pairing::{GIVEN_UP_NS, UnderWay};
use super::sequence::within;
use super::transfer::{Abort, Direction, Status};
use super::wire::{Command, Mux, Segment, Side};
use crate::context::Context;
use crate::event::Note;
use crate::frame::FrameRef;
use crate::rules::sdo::{Sdo001, Sdo002, Sdo006, Sdo007, Sdo016, Sdo017};

/// Abort code: SDO protocol timed out.
const TIMED_OUT: u32 = 0x0504_0000;

/// Refused writes that are remembered.
const REFUSED: usize = 64;

/// A write that the server refused.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refused {
    pub(super) object: Mux,
    /// The abort, and its code.
    pub(super) at: FrameRef,
    pub(super) code: u32,
    /// What explains that it was refused.
    pub(super) because_of: Option<FrameRef>,
}

impl Channel {
    /// An abort, from either side: it ends the transfer, and is never answered.
    pub(super) fn abort(&mut self, side: Side, at: FrameRef, code: u32, cx: &mut Context<'_>) {
        if let Some(pending) = self.pairing.pending {
            match (side, pending.command) {
                (Side::Client, _) if code == TIMED_OUT => {
                    self.find(Sdo002::NoResponse, pending.at, cx);
                }
                (Side::Server, Command::SegmentRequest { toggle } | Command::Segment(Segment { toggle, .. })) => {
                    if let Phase::Segments { toggle: due } = self.phase
                        && due != toggle
                    {
                        let wrong = Sdo001::Toggle { expected: due, found: toggle, by: Side::Client };
                        self.find(wrong, pending.at, cx);
                    }
                    self.judge_refused_segment(pending, cx);
                }
                (Side::Server, Command::EndBlock { .. }) => self.judge_refused_end(pending, cx),
                _ => {}
            }
        }
        if side == Side::Client && code == TIMED_OUT {
            self.judge_stalled_block(cx);
        }
        self.judge_aborted_block(cx);
        if side == Side::Client && code == TIMED_OUT {
            self.judge_timed_out(cx);
        }
        if self.all_bytes_without_last() {
            let last = self.transfer.as_ref().map_or(at, |transfer| transfer.last);
            self.find(Sdo007::NoLast, last, cx);
        }
        // One that waited for its request was reported at its own frame.
        if at.no == cx.at.no {
            self.find(Sdo017::Abort { abort: code, by: side }, at, cx);
        }
        if let Some(transfer) = &mut self.transfer {
            transfer.abort = Some(Abort { code, by: side });
            transfer.last = at;
        }
        self.complete(Status::Aborted, cx);
        self.outside = if self.proof.begun { Outside::Violation } else { Outside::Uncaptured };
    }

    /// The client says that it has waited in vain, though by the protocol nobody owed it anything.
    fn judge_timed_out(&mut self, cx: &mut Context<'_>) {
        if self.verdicts.fault.is_none()
            && let Some(transfer) = self.transfer.as_deref().filter(|it| it.mux.is_some() && !it.hole)
            && let newest = self.newest(transfer)
            && !within(newest, cx.at, GIVEN_UP_NS)
        {
            self.find(Sdo002::TimedOut, newest, cx);
        }
    }

    /// An abort should name the object of the transfer that it ends. One that names none (index 0) is let pass.
    fn judge_object(&mut self, half: &Half, by: Side, found: Mux, cx: &mut Context<'_>) {
        let object = self.transfer.as_ref().and_then(|transfer| transfer.mux);
        if let Some(expected) = object.filter(|object| *object != found && found.index != 0) {
            self.find(Sdo016::Objects { expected, found, by }, half.at, cx);
        }
    }

    /// A last segment that the server refused: was it for its size?
    pub(super) fn judge_refused_segment(&mut self, pending: Half, cx: &mut Context<'_>) {
        let (Command::Segment(segment), Some(transfer)) = (pending.command, &self.transfer) else { return };
        let Some(indicated) = transfer.size_indicated.map(u64::from) else { return };
        let transferred = transfer.size.saturating_add(u64::from(7 - segment.unused));
        if !transfer.hole && (transferred > indicated || (segment.last && transferred != indicated)) {
            self.find(Sdo006::Size { indicated, transferred }, pending.at, cx);
        }
    }

    /// The pending request was answered by the abort that was captured before it.
    pub(super) fn answered_by_abort(&mut self, cx: &mut Context<'_>) {
        self.pairing.abort_may_answer = false;
        let Some(pending) = self.pairing.pending.take() else { return };
        let object = self.pairing.last_abort.map(|(object, _)| object);
        if strict_initiate(&pending) && pending.command.mux() == object {
            self.trust(cx);
        }
        let own = self.own;
        if pending.at.no != cx.at.no {
            self.note(Note::AnsweredByAbort, pending.at, cx);
            self.own = false;
        }
        let abort = self.pairing_abort();
        if let Some(transfer) = &mut self.transfer {
            transfer.reordered = true;
            transfer.abort = abort;
        }
        self.complete(Status::Aborted, cx);
        self.own = own;
    }

    pub(super) fn client_abort(&mut self, half: &Half, mux: Mux, code: u32, cx: &mut Context<'_>) {
        self.judge_object(half, Side::Client, mux, cx);
        let seqno = self.block_seqno(Side::Server);
        self.abort(Side::Client, half.at, code, cx);
        self.pairing.given_up = self.pairing.pending.take().or(self.pairing.given_up);
        self.pairing.abort_may_answer = false;
        self.pairing.under_way = Some(UnderWay { side: Side::Server, at: half.at, seqno, owed: None, unasked: false });
    }

    pub(super) fn server_abort(&mut self, half: &Half, mux: Mux, code: u32, cx: &mut Context<'_>) {
        if let Some(pending) = self.pairing.pending
            && pending.command.mux() != Some(mux)
            && self.pairing.may_be_answered(&pending)
        {
            self.leave_answered(cx);
        }
        let pending_object = self.pairing.pending.and_then(|pending| pending.command.mux());
        if self.pairing.abort_may_answer
            && pending_object != Some(mux)
            && pending_object == self.pairing.last_abort.map(|(object, _)| object)
        {
            self.answered_by_abort(cx);
        }
        let seqno = self.block_seqno(Side::Client);
        let owed = self.owed_ack();
        let unasked = self.pairing.pending.is_none_or(|pending| self.is_edge(&pending));
        let idle = self.transfer.is_none();
        if unasked && idle && self.pairing.given_up.take().is_some() {
            // Both sides gave up, or the server refuses late: the abort is not for what the client asks next.
            self.abort(Side::Server, half.at, code, cx);
            return;
        }
        if let Some(pending) = self.pairing.pending {
            self.attempted(&pending);
        }
        self.proof.paired |= self.pairing.pending.is_some_and(|pending| pending.command.mux() == Some(mux));
        if self.pairing.pending.is_some_and(|pending| strict_initiate(&pending) && pending.command.mux() == Some(mux)) {
            // A refusal of what was asked for is as good an answer as any.
            self.trust(cx);
        }
        if !unasked {
            self.judge_object(half, Side::Server, mux, cx);
        }
        let written = self.written();
        self.abort(Side::Server, half.at, code, cx);
        self.refuse(written, half.at, code);
        self.pairing.answered = self.pairing.pending.take().map(|_| *half);
        self.pairing.abort_may_answer = false;
        self.pairing.last_abort = Some((mux, code));
        self.pairing.under_way = Some(UnderWay { side: Side::Client, at: half.at, seqno, owed, unasked });
    }

    /// The object that the transfer writes.
    fn written(&self) -> Option<Mux> {
        self.transfer.as_ref().filter(|it| it.direction == Direction::Download)?.mux
    }

    /// The server has refused a write of `object`: it stays refused until the same object is written after all.
    fn refuse(&mut self, object: Option<Mux>, at: FrameRef, code: u32) {
        if let Some(object) = object.filter(|object| self.verdicts.refused.iter().all(|it| it.object != *object))
            && self.verdicts.refused.len() < REFUSED
        {
            self.verdicts.refused.push(Refused { object, at, code, because_of: self.verdicts.fault });
        }
    }

    /// What the server refuses is still what the client wanted to write.
    pub(super) fn attempted(&mut self, request: &Half) {
        if let Command::InitiateDownload(object, i) = request.command
            && let Some(transfer) = &mut self.transfer
            && i.expedited
        {
            transfer.append(expedited(Some(object), &i, request.len));
        }
    }

    pub(super) fn pairing_abort(&self) -> Option<Abort> {
        self.pairing.last_abort.map(|(_, code)| Abort { code, by: Side::Server })
    }
}
