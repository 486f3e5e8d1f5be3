//! Emergencies (CiA 301, 7.2.7): the errors that are active on a node, and mistakes in the frame.
//!
//! An error is active until the node reports that all errors are gone (0000h with error register 0) or boots. A partial
//! reset (0000h with other bits left) names no code. A stack that puts its own error number into the first manufacturer
//! byte (CANopenNode's error bit) repeats it in the reset: if exactly one active error has that number, it is that one.

use std::collections::VecDeque;

use super::limits::AGAIN_NS;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::When;
use crate::rules::emcy::{Emc001, Emc002, Emc003, Emc005, Emc007, Emc008, Emc009, Emc010};
use crate::rules::finding::{Finding, Severity, Verdict};
use crate::wire::message::{ERRORS, Errors};
use crate::words::profiles::Profile;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{Node, PerNode};

/// The reserved bit of the error register.
const RESERVED: u8 = 1 << 6;
/// Tolerance of the inhibit time, in ns.
const SLACK_NS: Ns = Ns::from_ms(1);
/// Errors of one node within this time have one cause, in ns.
const TOGETHER_NS: Ns = Ns::from_ms(200);
/// Number of emergencies of one node within [`FLOOD_NS`] that make a flood; an emergency is sent once per error.
const FLOOD: usize = 10;
/// The time in which [`FLOOD`] emergencies make a flood, in ns.
const FLOOD_NS: Ns = Ns::from_s(1);
/// Number of first manufacturer bytes kept per error.
const BITS: usize = 4;

/// An active error.
#[derive(Clone, Copy, Debug)]
struct Standing {
    code: u16,
    /// First manufacturer bytes that came with it; 0 is empty.
    bits: [u8; BITS],
    /// The emergency that reported it first.
    at: FrameRef,
    when: When,
    /// Number of emergencies that reported it.
    count: u64,
}

impl Standing {
    fn holds(&self, bit: u8) -> bool {
        bit != 0 && self.bits.contains(&bit)
    }
}

/// An error that was reset.
#[derive(Clone, Copy, Debug)]
struct Gone {
    code: u16,
    /// The stack's own error number if the reset repeated it; 0 if unknown.
    bit: u8,
    /// The frame of the finding about it.
    at: FrameRef,
    /// Time of the reset, in ns.
    then_ns: Option<Ns>,
}

impl Gone {
    /// Returns true if an error reported at `now_ns` is this one again.
    fn is_back(&self, code: u16, bit: u8, now_ns: Option<Ns>) -> bool {
        let soon = |(then, now): (Ns, Ns)| now - then < AGAIN_NS;
        let same = self.bit == 0 || bit == 0 || self.bit == bit;
        self.code == code && same && self.then_ns.zip(now_ns).is_some_and(soon)
    }
}

/// Many emergencies in a short time.
#[derive(Clone, Copy, Debug)]
struct Flood {
    first: FrameRef,
    last: FrameRef,
    count: u64,
}

/// The effect of an emergency.
#[derive(Clone, Copy, Debug, Default)]
enum Change {
    /// No known effect.
    #[default]
    None,
    /// A new error.
    Raised,
    /// An error that is active already.
    Again,
    /// Reset of all errors.
    AllGone,
    /// Reset of this error; others may be active.
    Gone(u16),
}

#[derive(Debug, Default)]
struct Reported {
    /// The profile that defines its codes.
    profile: Profile,
    standing: Vec<Standing>,
    /// Errors that were reset.
    gone: VecDeque<Gone>,
    /// Errors removed by the last reset.
    ended: Vec<Standing>,
    change: Change,
    last: Option<When>,
    /// The first emergency of a series that violates the inhibit time.
    close: Option<FrameRef>,
    /// The last emergencies that have stamps.
    recent: VecDeque<When>,
    flood: Option<Flood>,
    /// The frame of the last finding.
    found: Option<FrameRef>,
}

/// The active errors of all nodes of a bus.
#[derive(Debug, Default)]
pub struct Emergencies {
    nodes: PerNode<Reported>,
    slack_ns: Ns,
}

impl Emergencies {
    /// Creates an empty state; `jitter_ns` is the minimum tolerance of times (`--jitter`).
    pub fn new(jitter_ns: Option<Ns>) -> Self {
        Self { slack_ns: jitter_ns.unwrap_or(Ns::ZERO), ..Self::default() }
    }

    /// Applies an emergency; returns the active errors and the removed ones. `bit` is the first manufacturer byte.
    pub fn follow(
        &mut self,
        node: u8,
        (code, profile): (u16, Profile),
        register: u8,
        bit: u8,
        at: FrameRef,
    ) -> (Errors, Errors) {
        let reported = self.nodes.entry(node);
        reported.profile = profile;
        reported.change = Change::None;
        let mut cleared = Errors::default();
        if code > 0xFF {
            reported.stand(code, bit, at);
        } else {
            reported.take_back(register, bit, at);
            reported.ended.iter().for_each(|one| cleared.add(one.code));
        }
        let mut active = Errors::default();
        reported.standing.iter().for_each(|one| active.add(one.code));
        (active, cleared)
    }

    /// Clears the errors of a node whose error register is read as 0.
    pub fn has_none(&mut self, node: u8) {
        if let Some(reported) = self.nodes.get_mut(node) {
            reported.standing.clear();
        }
    }

    /// Resets a node that boots up: it reports its errors again.
    pub fn boot_up(&mut self, node: u8, cx: &mut Context<'_>) {
        if let Some(reported) = self.nodes.get_mut(node) {
            reported.end_flood(node, cx);
            *reported = Reported::default();
        }
    }

    /// Reports the errors in an emergency and its mistakes.
    pub fn judge(&mut self, (code, register): (u16, u8), node: u8, configured: Option<&Node>, cx: &mut Context<'_>) {
        self.nodes.entry(node).report(node, code, register, cx);
        let named = (code, self.nodes.entry(node).profile);
        if code > 0xFF && register == 0 {
            cx.raise(Emc001::NoRegister { code: named, register }, Some(node), None, None);
        }
        if register & RESERVED != 0 {
            cx.raise(Emc003::Bit6 { code: named, register }, Some(node), None, None);
        }
        let recording = &cx.evidence.recording;
        let Some(last) = self.nodes.entry(node).last.replace(cx.when) else { return };
        let Some(gap) = recording.between(last, cx.when).filter(|gap| *gap >= Ns::ZERO) else { return };
        let inhibit = configured.and_then(|configured| configured.value(0x1015, 0));
        let Some((inhibit, _)) = inhibit.filter(|(_, from)| *from > Provenance::Eds) else { return };
        let inhibit_ns = Ns::from_us((inhibit & 0xFFFF) as i64 * 100);
        let limit_ns = inhibit_ns - SLACK_NS.max(inhibit_ns / 10).max(self.slack_ns);
        if recording.certainly_within(cx.when, last, limit_ns) {
            let what = Emc005::TooClose { found: gap, expected: inhibit_ns };
            let because_of = self.nodes.entry(node).close;
            self.nodes.entry(node).close = because_of.or(Some(cx.at));
            cx.report_timed(Finding { because_of, ..cx.verdict(what, Some(node), None, None) });
        } else {
            self.nodes.entry(node).close = None;
        }
    }

    /// Reports the errors that are active at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        for (node, reported) in self.nodes.iter_mut() {
            reported.end_flood(node, cx);
            for one in std::mem::take(&mut reported.standing) {
                let Standing { code, at, count, .. } = one;
                let (code, age) = ((code, reported.profile), cx.at.since(at));
                let repeated = Emc009::StandsAndRepeats { code, count, age };
                let what = if count > 1 { repeated } else { Emc009::Stands { code, count, age } };
                find(what, node, cx.at, Some(at), Some(at), cx);
            }
        }
    }
}

impl Reported {
    fn stand(&mut self, code: u16, bit: u8, at: FrameRef) {
        if let Some(known) = self.standing.iter_mut().find(|one| one.code == code) {
            self.change = Change::Again;
            if bit != 0
                && !known.holds(bit)
                && let Some(slot) = known.bits.iter_mut().find(|slot| **slot == 0)
            {
                *slot = bit;
            }
            return;
        }
        self.change = Change::Raised;
        if self.standing.len() < ERRORS {
            let mut bits = [0; BITS];
            if let Some(slot) = bits.first_mut() {
                *slot = bit;
            }
            let when = When { at, ..When::default() };
            self.standing.push(Standing { code, bits, at, when, count: 1 });
        }
    }

    fn take_back(&mut self, register: u8, bit: u8, at: FrameRef) {
        self.ended.clear();
        if register == 0 {
            self.change = Change::AllGone;
            self.ended = std::mem::take(&mut self.standing);
        } else {
            let mut fitting = self.standing.iter().enumerate().filter(|(_, one)| one.holds(bit));
            let (Some((place, _)), None) = (fitting.next(), fitting.next()) else { return };
            let Some(one) = self.standing.get_mut(place) else { return };
            // Two errors with one code: it is active until both are gone.
            if one.bits.iter().any(|known| ![0, bit].contains(known)) {
                one.bits.iter_mut().filter(|known| **known == bit).for_each(|known| *known = 0);
                return;
            }
            let gone = self.standing.remove(place);
            self.change = Change::Gone(gone.code);
            self.ended.push(gone);
        }
        for one in &self.ended {
            if self.gone.len() >= ERRORS {
                self.gone.pop_front();
            }
            let bit = if one.holds(bit) { bit } else { 0 };
            self.gone.push_back(Gone { code: one.code, bit, at: one.at, then_ns: at.t_ns });
        }
    }

    fn report(&mut self, node: u8, code: u16, register: u8, cx: &mut Context<'_>) {
        match self.change {
            Change::Raised => {
                let raised = self.standing.iter().find(|one| one.code == code);
                let bit = raised.and_then(|one| one.bits.first().copied()).unwrap_or(0);
                let again = self.gone.iter().rev().find(|gone| gone.is_back(code, bit, cx.at.t_ns));
                let with = self.standing.iter().find(|one| {
                    let gap = cx.evidence.recording.between(one.when, cx.when);
                    let near = gap.is_some_and(|gap| (Ns::ZERO..TOGETHER_NS).contains(&gap));
                    one.code != code && (near || one.when.epoch != cx.when.epoch)
                });
                let with = with.filter(|one| severity(one.code) >= severity(code));
                let because_of = again.map(|gone| gone.at).or(with.map(|one| one.at));
                if let Some(one) = self.standing.iter_mut().find(|one| one.code == code) {
                    // The trouble continues: its next occurrence also follows from the first.
                    (one.at, one.when) = (because_of.unwrap_or(one.at), cx.when);
                }
                find(reported((code, self.profile), register), node, cx.at, None, because_of, cx);
                self.found = because_of.or(Some(cx.at));
            }
            Change::Again => {
                self.standing.iter_mut().filter(|one| one.code == code).for_each(|one| one.count += 1);
            }
            Change::Gone(_) | Change::None if code <= 0xFF && register != 0 => self.partial(node, register, cx),
            _ => {}
        }
        for one in self.ended.drain(..).filter(|one| one.count > 1) {
            let what = Emc009::Repeated { code: (one.code, self.profile), count: one.count };
            find(what, node, cx.at, Some(one.at), Some(one.at), cx);
        }
        self.count(node, cx);
    }

    /// Reports a partial reset: the removed error and the remaining ones, as far as known.
    fn partial(&self, node: u8, register: u8, cx: &mut Context<'_>) {
        let count = self.standing.len() as u64;
        let named = |code| (code, self.profile);
        let left = self.standing.first().map(|one| named(one.code));
        let what = match (self.change, left) {
            (Change::Gone(code), None) => Emc002::UnknownLeft { register, cleared: named(code) },
            (Change::Gone(code), Some(left)) if count == 1 => Emc002::OneLeft { register, cleared: named(code), left },
            (Change::Gone(code), Some(left)) => Emc002::SeveralLeft { register, cleared: named(code), left, count },
            _ if count > 1 => Emc002::OneOf { register, count },
            _ => Emc002::StillSet { code: named(0), register },
        };
        find(what, node, cx.at, None, None, cx);
    }

    /// Counts an emergency; reports a flood.
    fn count(&mut self, node: u8, cx: &mut Context<'_>) {
        if cx.at.t_ns.is_none() {
            return;
        }
        let within = |then: When, cx: &Context<'_>| cx.evidence.recording.certainly_within(cx.when, then, FLOOD_NS);
        if self.flood.is_some_and(|flood| !within(When { at: flood.last, ..cx.when }, cx)) {
            self.end_flood(node, cx);
        }
        if let Some(flood) = &mut self.flood {
            (flood.last, flood.count) = (cx.at, flood.count + 1);
            return;
        }
        while self.recent.front().is_some_and(|first| !within(*first, cx)) {
            self.recent.pop_front();
        }
        self.recent.push_back(cx.when);
        if self.recent.len() >= FLOOD
            && let Some(first) = self.recent.front().map(|first| first.at)
        {
            self.recent.clear();
            let count = FLOOD as u64;
            self.flood = Some(Flood { first, last: cx.at, count });
            let because_of = self.found.filter(|found| found.no >= first.no);
            let duration = cx.at.since(first).unwrap_or(Ns::ZERO);
            find(Emc010::Flood { count, duration }, node, first, None, because_of, cx);
        }
    }

    /// Ends a flood; reports its size unless it was reported.
    fn end_flood(&mut self, node: u8, cx: &mut Context<'_>) {
        let Some(Flood { first, last, count }) = self.flood.take() else { return };
        if count > FLOOD as u64 {
            let duration = last.since(first).unwrap_or(Ns::ZERO);
            find(Emc010::InAll { count, duration }, node, last, Some(first), Some(first), cx);
        }
    }
}

/// Returns the finding of an error; generic, communication and device-specific codes may be harmless.
fn reported(code: (u16, Profile), register: u8) -> Verdict {
    match code.0 {
        ..0x2000 | 0x8000..=0x82FF | 0xF000.. => Emc008::Reported { code, register }.into(),
        _ => Emc007::Reported { code, register }.into(),
    }
}

fn severity(code: u16) -> Severity {
    reported((code, Profile::UNKNOWN), 0).code.rule().severity
}

fn find(
    what: impl Into<Verdict>,
    node: u8,
    at: FrameRef,
    cause: Option<FrameRef>,
    because_of: Option<FrameRef>,
    cx: &mut Context<'_>,
) {
    cx.report(Finding { at, because_of, ..cx.verdict(what, Some(node), None, cause) });
}
