//! Emergencies (CiA 301, 7.2.7): which errors a node has reported and not taken back, and what is wrong in the frame.
//!
//! An emergency error code stays active until the node says that all errors are gone (0000h with error register 0) or
//! boots. Which of several errors a partial reset (0000h with other bits left) takes back, no standard field tells.

use crate::configuration::Provenance;
use crate::context::Context;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::FrameRef;
use crate::message::Errors;
use crate::node::{Node, PerNode};

/// Bit of the error register that is reserved.
const RESERVED: u8 = 1 << 6;
/// What an inhibit time may be undercut by, in ns.
const SLACK_NS: i64 = 1_000_000;

#[derive(Debug, Default)]
struct Reported {
    active: Errors,
    last: Option<FrameRef>,
}

/// The errors of a bus's nodes.
#[derive(Debug, Default)]
pub struct Emergencies {
    nodes: PerNode<Reported>,
    slack_ns: i64,
}

impl Emergencies {
    /// Emergencies whose times are judged with at least this tolerance (`--jitter`).
    pub fn new(jitter_ns: Option<i64>) -> Self {
        Self { slack_ns: jitter_ns.unwrap_or(0), ..Self::default() }
    }

    /// Which errors are active after an emergency, and which ones it takes back.
    pub fn follow(&mut self, node: u8, code: u16, register: u8) -> (Errors, Errors) {
        let reported = self.nodes.entry(node);
        let mut cleared = Errors::default();
        if code > 0xFF {
            reported.active.add(code);
        } else if register == 0 {
            cleared = std::mem::take(&mut reported.active);
        }
        (reported.active, cleared)
    }

    /// A boot-up: the node reports its errors anew.
    pub fn boot_up(&mut self, node: u8) {
        if let Some(reported) = self.nodes.get_mut(node) {
            *reported = Reported::default();
        }
    }

    /// What is wrong with an emergency.
    pub fn judge(&mut self, code: u16, register: u8, node: u8, configured: Option<&Node>, cx: &mut Context<'_>) {
        let found = [("code", Quantity::Emcy(code)), ("register", Quantity::Hex2(register))];
        if code > 0xFF && register == 0 {
            cx.find(Code::Emc001, Some(node), None, None, Facts::told(0, &found));
        }
        if code <= 0xFF && register != 0 {
            cx.find(Code::Emc002, Some(node), None, None, Facts::told(0, &found));
        }
        if register & RESERVED != 0 {
            cx.find(Code::Emc003, Some(node), None, None, Facts::told(0, &found));
        }
        let last = self.nodes.entry(node).last.replace(cx.at);
        let Some(gap) = super::nmt::since(last, cx.at).filter(|gap| *gap >= 0) else { return };
        let inhibit = configured.and_then(|configured| configured.value(0x1015, 0));
        let Some((inhibit, _)) = inhibit.filter(|(_, from)| *from > Provenance::Eds) else { return };
        let inhibit_ns = (inhibit & 0xFFFF) as i64 * 100_000;
        if gap < inhibit_ns - SLACK_NS.max(inhibit_ns / 10).max(self.slack_ns) {
            let facts = [("found", Quantity::Ns(gap)), ("expected", Quantity::Ns(inhibit_ns))];
            cx.find(Code::Emc005, Some(node), None, last, Facts::told(0, &facts));
        }
    }
}
