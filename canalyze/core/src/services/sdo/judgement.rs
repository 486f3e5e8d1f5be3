//! Findings of a channel: what is said, withheld, or dropped.
//!
//! Nothing is judged before the first request that can be one; findings are withheld until the channel has shown
//! one valid request with its response. A channel that never does says so once.

use super::channel::{Channel, Half};
use super::wire::{self, Command, Segment, Side};
use crate::context::Context;
use crate::event::{Event, Note, Place, What};
use crate::finding::{Code, Facts, Finding, Severity};
use crate::frame::FrameRef;

/// Odd frames on a channel that has shown no valid exchange, from which on it is not taken for SDO.
const FOREIGN: u64 = 16;
/// What was odd about the last exchange and was said: not again in other words. Frames by their numbers.
#[derive(Debug, Default)]
pub(super) struct OddExchange {
    /// The last client frame, where nothing could be read from it.
    request: Option<u64>,
    /// The response after such a one.
    asked: Option<u64>,
    /// The request that something else than an answer came after.
    answered: Option<u64>,
    /// The last frame that is missing, or that nothing could be read from.
    broken: Option<u64>,
    /// Since it was said that frames belong to nothing, none has been answered as it should.
    pub(super) astray: bool,
}

/// Findings withheld at most; more of the same say nothing new.
const WITHHELD: usize = 32;

impl Channel {
    /// Flaws of the frame itself, whatever its place.
    pub(super) fn judge_frame(&mut self, half: &Half, cx: &mut Context<'_>) {
        if half.len != 8 {
            self.find(Code::Sdo010, half.at, Facts::Length(half.len), cx);
        }
        if matches!(self.step.place, Place::Uncaptured | Place::InFlight) {
            return;
        }
        match half.command {
            Command::Unknown(command) => self.find(Code::Sdo023, half.at, Facts::Command(command), cx),
            Command::Segment(Segment { last: false, unused, .. }) if unused != 0 => {
                self.find(Code::Sdo005, half.at, Facts::Unused(unused), cx);
            }
            Command::InitiateDownload(_, i) | Command::UploadInitiated(_, i)
                if half.command.has_invalid_unused() && (i.expedited || i.size_indicated) =>
            {
                self.find(Code::Sdo004, half.at, Facts::Unused(i.unused), cx);
            }
            Command::InitiateBlockUpload { blksize, .. } | Command::BlockDownloadInitiated { blksize, .. }
                if half.command.has_invalid_block_size() && half.len > 4 && self.is_asked_for(half) =>
            {
                self.find(Code::Sdo012, half.at, Facts::BlockSize(blksize), cx);
            }
            _ => {}
        }
        if half.command.has_reserved_bits(half.bytes) {
            self.find(Code::Sdo009, half.at, Facts::None, cx);
        }
    }

    /// Whether a response is of the kind that the pending request asks for: what is not is no answer to it, whatever it
    /// says. A request always is.
    fn is_asked_for(&self, half: &Half) -> bool {
        let fits = |pending: Half| wire::kind_fits(&pending.command, &half.command);
        half.command.is_initiate() || self.pairing.pending.is_none_or(fits)
    }

    pub(super) fn note(&mut self, note: Note, about: FrameRef, cx: &mut Context<'_>) {
        if !self.trusted {
            return;
        }
        cx.events.push(Event {
            at: cx.at,
            about: Some(about),
            bus: self.bus,
            node: Some(self.node),
            transfer: self.transfer.as_ref().map(|transfer| transfer.id),
            what: What::Note(note),
        });
    }

    /// A finding about `offender`: at that frame where it is the wrong one, at the frame at hand where something is
    /// missing after it.
    pub(super) fn find(&mut self, code: Code, offender: FrameRef, facts: Facts, cx: &mut Context<'_>) {
        // What is wrong with the channel's first frame itself, or with what answers it, counts if it can only be a
        // request.
        let first = self.plausible > 0 && self.requests <= 1 && self.responses <= 1;
        // No frame of a transfer, in whatever phase, has another length.
        if !self.begun && !first && !matches!(code, Code::Sdo017 | Code::Sdo010) {
            return;
        }
        if self.is_consequence(code, offender, &facts) {
            return;
        }
        let object = match &mut self.transfer {
            Some(transfer) => {
                transfer.note_finding(code);
                transfer.mux
            }
            None => self.step.result.as_ref().and_then(|transfer| transfer.mux),
        };
        let object = self.find_about.take().or(object);
        let initiated = self.transfer.as_ref().is_some_and(|transfer| transfer.initiated == Some(offender));
        let last = code == Code::Sdo006 && !initiated;
        let at = if last || is_wrong(code, &facts) { offender } else { cx.at };
        let finding = Finding {
            code,
            at,
            cause: (offender.no != at.no).then_some(offender),
            bus: self.bus,
            node: Some(self.node),
            object,
            facts,
            because_of: None,
        };
        self.say(finding, cx);
    }

    /// Says a finding, or withholds it until the channel has shown that it is one.
    pub(super) fn say(&mut self, finding: Finding, cx: &mut Context<'_>) {
        if self.trusted {
            push_finding(finding, cx);
        } else if self.withheld.len() < WITHHELD {
            self.withheld.push(finding);
        }
    }

    /// Whether another finding has said this already. One wrong frame leaves two gaps: what it should have been is
    /// missing, and what it is belongs to nothing. And once it is not known what the two sides are talking about,
    /// that they do not fit is said once, until they do.
    fn is_consequence(&mut self, code: Code, offender: FrameRef, facts: &Facts) -> bool {
        let in_transfer = |no: u64| self.transfer.as_ref().is_some_and(|transfer| transfer.first.no <= no);
        let broken = self.odd_exchange.broken.is_some_and(in_transfer);
        if code == Code::Sdo008 && (broken || self.has_finding(Code::Sdo004)) {
            return true;
        }
        if matches!(facts, Facts::NotAcknowledged) && self.odd_exchange.broken.is_some_and(|no| no >= offender.no) {
            return true;
        }
        if matches!(facts, Facts::Duplicate) && self.odd_exchange.asked == Some(offender.no) {
            return true;
        }
        if matches!(code, Code::Sdo002 | Code::Sdo023) {
            self.odd_exchange.broken = Some(self.odd_exchange.broken.unwrap_or_default().max(offender.no));
        }
        let missing = match (code, facts) {
            (Code::Sdo002, Facts::Missing { by }) => Some(*by),
            (Code::Sdo012, Facts::EndNotConfirmed) => Some(Side::Server),
            _ => None,
        };
        match missing {
            Some(Side::Server) => self.odd_exchange.answered == Some(offender.no),
            Some(Side::Client) if self.odd_exchange.asked == Some(offender.no) => true,
            Some(Side::Client) => {
                self.answered_oddly();
                std::mem::replace(&mut self.odd_exchange.astray, true)
            }
            None if code == Code::Sdo007 && matches!(facts, Facts::Outside) => {
                std::mem::replace(&mut self.odd_exchange.astray, true)
            }
            None => false,
        }
    }

    fn has_finding(&self, code: Code) -> bool {
        self.transfer.as_ref().is_some_and(|transfer| transfer.findings.contains(&code))
    }

    /// Something came in the place of the answer to the pending request, and a finding says so.
    fn answered_oddly(&mut self) {
        self.odd_exchange.answered = self.pairing.pending.map(|pending| pending.at.no).or(self.odd_exchange.answered);
    }

    /// That a request may be left without an answer has been said, or need not be.
    pub(super) fn unanswerable(&mut self, request: &Half) {
        self.odd_exchange.answered = Some(request.at.no);
    }

    /// The pending request may be left without an answer if it should not have been sent.
    pub(super) fn excuse_answer(&mut self) {
        if let (Some(vain), Some(pending)) = (self.in_vain, self.pairing.pending)
            && vain.no == pending.at.no
        {
            self.unanswerable(&pending);
        }
    }

    /// Whether a request may be left without an answer.
    pub(super) fn is_unanswerable(&self, request: &Half) -> bool {
        self.odd_exchange.answered == Some(request.at.no)
    }

    /// In the place of a block transfer's end came what does not belong there, and a finding says so: what answers it
    /// answers the end.
    pub(super) fn instead_of_end(&mut self, half: &Half) {
        match self.step.side {
            Side::Client => self.odd_exchange.request = Some(half.at.no),
            Side::Server => self.odd_exchange.answered = self.transfer.as_ref().map(|transfer| transfer.last.no),
        }
    }

    /// A frame that says nothing stands for the request or the answer that it should have been.
    pub(super) fn note_unreadable(&mut self, side: Side, half: &Half) {
        let unreadable = half.command.is_unreadable();
        if unreadable {
            self.odd_exchange.broken = Some(half.at.no);
        }
        match side {
            Side::Client => self.odd_exchange.request = unreadable.then_some(half.at.no),
            Side::Server => {
                if self.odd_exchange.request.take().is_some() {
                    self.odd_exchange.asked = Some(half.at.no);
                }
                if unreadable {
                    self.answered_oddly();
                }
            }
        }
    }

    pub(super) fn trust(&mut self, cx: &mut Context<'_>) {
        (self.trusted, self.proven, self.begun) = (true, true, true);
        for finding in std::mem::take(&mut self.withheld) {
            push_finding(finding, cx);
        }
    }

    /// Whether the traffic looks so little like SDO that no transfer is made of it.
    pub(super) fn is_foreign(&self) -> bool {
        let frames = self.requests.saturating_add(self.responses);
        !self.proven && self.odd >= FOREIGN && self.odd > frames / 2
    }

    pub(super) fn is_trusted(&self) -> bool {
        self.trusted
    }

    pub(super) fn say_distrust(&mut self, cx: &mut Context<'_>) {
        let Some(first) = self.first else { return };
        if self.proven || self.scanned {
            return;
        }
        let unanswered = self.requests > 0 && self.responses == 0 && self.plausible > 0;
        if self.paired {
            return;
        }
        if self.plausible > 0 && self.responses > 0 && self.withheld.len() == 1 && self.odd <= 1 {
            // One frame is wrong, and the others can only be SDO.
            self.trust(cx);
            return;
        }
        let nothing_odd = self.withheld.iter().all(|finding| finding.severity() == Severity::Info);
        let code = if unanswered { Code::Sdo031 } else { Code::Sdo030 };
        let few = self.requests.saturating_add(self.responses) < 2;
        if (!unanswered && few) || (unanswered && !nothing_odd && self.requests < 2) {
            return;
        }
        let finding = Finding {
            code,
            at: first,
            cause: None,
            bus: self.bus,
            node: Some(self.node),
            object: None,
            facts: Facts::Frames { count: self.requests.saturating_add(self.responses) },
            because_of: None,
        };
        push_finding(finding, cx);
    }
}

/// Whether a finding is about a frame that is wrong, and not about one after which something is missing.
fn is_wrong(code: Code, facts: &Facts) -> bool {
    match code {
        Code::Sdo002 => matches!(facts, Facts::Missing { by: Side::Client } | Facts::Duplicate),
        Code::Sdo012 => !matches!(facts, Facts::EndNotConfirmed | Facts::NoLast),
        Code::Sdo001 | Code::Sdo003 | Code::Sdo004 | Code::Sdo019 | Code::Sdo021 | Code::Sdo022 => true,
        _ => false,
    }
}

fn push_finding(finding: Finding, cx: &mut Context<'_>) {
    cx.events.push(Event {
        at: finding.at,
        about: finding.cause,
        bus: finding.bus,
        node: finding.node,
        transfer: None,
        what: What::Finding(Box::new(finding)),
    });
}
