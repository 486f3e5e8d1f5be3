//! Findings of a channel: what is said, withheld, or dropped.
//!
//! Nothing is judged before the first request that can be one; findings are withheld until the channel has shown
//! one valid request with its response. A channel that never does says so once.

use super::channel::{Channel, Half};
use super::wire::{Command, Segment};
use crate::context::Context;
use crate::event::{Event, Note, Place, What};
use crate::finding::{Code, Facts, Finding, Severity};
use crate::frame::FrameRef;

/// Odd frames on a channel that has shown no valid exchange, from which on it is not taken for SDO.
const FOREIGN: u64 = 16;
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
                if half.command.has_invalid_block_size() =>
            {
                self.find(Code::Sdo012, half.at, Facts::BlockSize(blksize), cx);
            }
            _ => {}
        }
        if half.command.has_reserved_bits(half.bytes) {
            self.find(Code::Sdo009, half.at, Facts::None, cx);
        }
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

    /// A finding at the frame at hand, about `offender`.
    pub(super) fn find(&mut self, code: Code, offender: FrameRef, facts: Facts, cx: &mut Context<'_>) {
        // What is wrong with the channel's first frame itself counts if it can only be a request.
        let first = self.first == Some(cx.at) && self.plausible > 0;
        if !self.begun && !first && code != Code::Sdo017 {
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
        let finding = Finding {
            code,
            at: cx.at,
            cause: (offender.no != cx.at.no).then_some(offender),
            bus: self.bus,
            node: Some(self.node),
            object,
            facts,
        };
        if self.trusted {
            push_finding(finding, cx);
        } else if self.withheld.len() < WITHHELD {
            self.withheld.push(finding);
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
        let nothing_odd = self.withheld.iter().all(|finding| finding.code.rule().severity == Severity::Info);
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
        };
        push_finding(finding, cx);
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
