//! Node guarding (CiA 301, 7.2.8.3.2.1): the master asks by remote frame; the node answers with its state and a toggle
//! bit.
//!
//! An answer with toggle bit 0 looks like a heartbeat. It is an answer if it followed a request, or if the node has
//! answered with the bit set before. A request may be captured just after its answer. The toggle bit is not judged in a
//! node's first answer and in the one after an unanswered request.
//!
//! The bit also tells what the recording lacks: where it alternates twice across a request without answer, one was sent;
//! where it does not across two periods of the guarding, a request and its answer are missing between them. The report
//! of a request without answer waits for the next answer.

use super::heartbeat::Heartbeats;
use super::nmt::Nmt;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::circumstance::CircumstanceKind;
use crate::evidence::duplicates::Sighting;
use crate::evidence::obligation::Owed;
use crate::evidence::{Obligations, Period, When};
use crate::rules::finding::Finding;
use crate::rules::guarding::{Grd001, Grd002, Grd003, Grd004, Grd005};
use crate::rules::heartbeat::Hbt003;
use crate::rules::heartbeat::Hbt004;
use crate::sdo::limits::UNANSWERED_NS;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{Node, PerNode};

/// Maximum time from a request to its answer, in ns.
const ANSWER_NS: Ns = Ns::from_ms(500);
/// Usual maximum time between two requests to a guarded node, in ns.
const ROUND_NS: Ns = Ns::from_s(10);
/// Time after which a request before a reset counts as unanswered, in ns.
const SLOW_NS: Ns = Ns::from_ms(50);
/// Number of frames in a row with the same toggle bit that shows them to be no answers.
const SAME: u8 = 3;
/// Maximum time between the responses of two nodes to one request, in ns.
const SECOND_NS: Ns = Ns::from_ms(20);
/// Number of frames without request that shows a guarded node to send heartbeats as well.
const UNASKED: u8 = 3;

/// Part of the period of answers by which one may deviate from its time.
const ON_TIME_PART: i64 = 4;

/// A request without answer that is reported unless the next answer shows that one was sent.
#[derive(Debug)]
struct Unanswered {
    finding: Finding,
    /// The place at which it was missed, and the toggle bit of the answer before it.
    at: When,
    toggle: bool,
}

/// The only frame with toggle bit 1 so far.
#[derive(Clone, Copy, Debug)]
struct Lone {
    at: FrameRef,
    byte: u8,
    /// Number of frames without the bit in a row since then, and the first of them.
    same: Option<(u8, FrameRef)>,
}

#[derive(Debug, Default)]
struct Guarded {
    /// Number of requests in the capture, and the first of them.
    requests: u64,
    first: Option<FrameRef>,
    lone: Option<Lone>,
    /// The last request.
    asked: Option<FrameRef>,
    /// The last request while it is unanswered.
    request: Option<When>,
    /// An answer, perhaps to this request, came just before it.
    doubtful: bool,
    /// The toggle bit of the last answer if it determines the next one.
    toggle: Option<bool>,
    /// The last answer, and the usual time between answers.
    answer: Option<FrameRef>,
    period: Period,
    unanswered: Option<Unanswered>,
    /// It has answered with toggle bit 1, so its frames are no heartbeats.
    toggles: bool,
    /// A frame still without request, its toggle bit, and true if it was counted as an answer.
    ahead: Option<(FrameRef, bool, bool)>,
    /// Number of frames without request, and the first of them.
    unasked: u8,
    unasked_since: FrameRef,
    /// Number of those that came soon after a response, as a second node's do.
    second: u8,
    /// Reported: requests without answer; heartbeats besides answers.
    silent: bool,
    both: bool,
}

/// The guarded nodes of a bus.
#[derive(Debug)]
pub struct Guarding {
    nodes: PerNode<Guarded>,
    /// The node life times in ns (100Ch times 100Dh); 0 if disabled or unknown.
    life_ns: PerNode<Ns>,
    /// The next request that the master owes a node.
    life: Obligations<u8>,
    /// A time no later than the expiry of the first open request, in ns.
    next: Ns,
}

impl Default for Guarding {
    fn default() -> Self {
        Self { nodes: PerNode::default(), life_ns: PerNode::default(), life: Obligations::default(), next: Ns::MAX }
    }
}

impl Guarding {
    /// Returns true if a frame on a node's error-control identifier is a guarding answer.
    pub fn is_answer(&self, node: u8, toggle: bool, heartbeats: &Heartbeats, cx: &Context<'_>) -> bool {
        let Some(guarded) = self.nodes.get(node) else { return toggle };
        let asked = guarded.is_asked(cx) && (guarded.toggles || !heartbeats.produces(node));
        toggle || asked || guarded.toggles && guarded.requests == 0
    }

    /// Returns true if a node has answered with its toggle bit set.
    pub fn toggles(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|guarded| guarded.toggles)
    }

    /// Returns true if missing answers of a node were reported, and it still does not answer.
    pub fn is_unanswered(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|guarded| guarded.silent)
    }

    /// Returns true if the master guards a node. The request may be captured after its answer, so that of the round
    /// before counts.
    pub fn is_guarded(&self, node: u8, at: FrameRef) -> bool {
        let asked = self.nodes.get(node).and_then(|guarded| guarded.asked);
        asked.is_some_and(|asked| at.since(asked).is_none_or(|age| age <= ROUND_NS))
    }

    /// Updates the node life times after a change of 100Ch or 100Dh.
    pub fn configure(&mut self, nodes: &PerNode<Node>) {
        for (id, node) in nodes.iter() {
            let known =
                |index| node.value(index, 0).filter(|(_, from)| *from > Provenance::Eds).map(|(value, _)| value);
            let (guard_ms, factor) = (known(0x100C), known(0x100D));
            let off = guard_ms == Some(0) || factor == Some(0);
            let life_ns = guard_ms.zip(factor).map_or(Ns::ZERO, |(guard_ms, factor)| {
                Ns::from_ms((guard_ms & 0xFFFF) as i64 * (factor & 0xFF) as i64)
            });
            if life_ns > Ns::ZERO || self.life_ns.get(id).is_some() {
                *self.life_ns.entry(id) = life_ns;
            }
            // A longer time holds at once, a shorter one from the next request on; one that is not known for now changes nothing.
            if off {
                self.life.met(id);
            } else if let Some(owed) = self.life.get(id).copied().filter(|owed| owed.limit_ns < life_ns) {
                self.life.open(id, Owed { limit_ns: life_ns, ..owed });
            }
        }
    }

    /// Expects the master's next request within the node's life time.
    fn await_request(&mut self, node: u8, heartbeats: &Heartbeats, cx: &Context<'_>) {
        let life_ns = self.life_ns.get(node).copied().unwrap_or(Ns::ZERO);
        if life_ns > Ns::ZERO && !heartbeats.is_configured(node) {
            self.life.open(node, Owed { since: cx.when, limit_ns: life_ns, why: Some(cx.at) });
        }
    }

    /// Reports nodes that the master has not asked within their life time, unless the whole bus was silent.
    fn overdue(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        let now = cx.clock(now_ns);
        for (node, Owed { since, limit_ns: limit, .. }) in self.life.due(now, &cx.evidence.recording) {
            let age = cx.evidence.recording.between(since, now).unwrap_or(Ns::ZERO);
            let fell = since.at.t_ns.map_or(Ns::ZERO, |since| since + limit);
            // Of a node that does not answer the master may ask no more.
            if !cx.evidence.recording.was_silent(node, fell, limit, now_ns) && !self.is_unanswered(node) {
                cx.raise(Grd005::Expired { age, limit }, Some(node), None, Some(since.at));
            }
        }
    }

    /// Takes a request of the master.
    pub fn request(&mut self, node: u8, nmt: &Nmt, heartbeats: &Heartbeats, cx: &mut Context<'_>) {
        let pending = self.nodes.get(node).is_some_and(|guarded| guarded.request.is_some());
        if pending && cx.sighting == Sighting::Suspect {
            return;
        }
        self.await_request(node, heartbeats, cx);
        let guarded = self.nodes.entry(node);
        guarded.requests += 1;
        guarded.first.get_or_insert(cx.at);
        guarded.asked = Some(cx.at);
        let recording = &cx.evidence.recording;
        if let Some((frame, toggle, counted)) = guarded.ahead.filter(|(frame, ..)| !recording.is_settled(*frame, cx.at))
        {
            // Its answer was captured before it.
            guarded.ahead = None;
            if !counted {
                guarded.answer_at(node, toggle, frame, cx);
            }
            guarded.request = None;
            return;
        }
        if guarded.requests == 1 && guarded.toggle == Some(false) {
            // Frames before the first request in the capture may have been heartbeats.
            guarded.toggle = None;
        }
        guarded.expire(node, cx);
        let just_answered = guarded.answer.is_some_and(|answer| !cx.evidence.recording.is_settled(answer, cx.at));
        let doubtful = std::mem::replace(&mut guarded.doubtful, just_answered);
        if let Some(before) = guarded.request.replace(cx.when).map(|when| when.at).filter(|_| !doubtful) {
            if heartbeats.produces(node) && !guarded.toggles {
                if !guarded.both {
                    guarded.both = true;
                    cx.raise(Grd003::Requests, Some(node), None, Some(before));
                }
            } else {
                guarded.unanswered(node, before, nmt, cx);
            }
        }
        if let Some(now) = cx.at.t_ns {
            self.next = self.next.min(now + UNANSWERED_NS);
        }
    }

    /// Takes a node's answer, or a heartbeat of a node that may be guarded.
    pub fn frame(&mut self, node: u8, (state, toggle): (u8, bool), answer: bool, cx: &mut Context<'_>) {
        let guarded = self.nodes.entry(node);
        if is_duplicate(cx) {
            return;
        }
        if toggle {
            let lone = Lone { at: cx.at, byte: state | 0x80, same: None };
            let before = std::mem::replace(&mut guarded.lone, Some(lone).filter(|_| !guarded.toggles));
            if let Some((_, first)) = before.and_then(|lone| lone.same) {
                report_toggle(node, false, first, cx);
                guarded.toggle = None;
            }
        } else if let Some(lone) =
            guarded.lone.as_mut().filter(|_| guarded.requests == 0 && guarded.toggle == Some(false))
        {
            // No requests, and several frames without the bit follow a single one with it: no answers.
            let (count, first) = lone.same.map_or((1, cx.at), |(count, first)| (count + 1, first));
            lone.same = Some((count, first));
            if count >= SAME {
                guarded.was_heartbeat(node, cx);
            }
            return;
        }
        guarded.toggles |= toggle;
        if guarded.is_asked(cx) && answer {
            guarded.request = None;
            guarded.settle(node, Some(toggle), cx);
            if std::mem::take(&mut guarded.silent) {
                cx.evidence.circumstances.over(CircumstanceKind::NodeLost, node);
            }
            guarded.expire(node, cx);
            return guarded.answer_at(node, toggle, cx.at, cx);
        }
        guarded.expire(node, cx);
        let counts = toggle || guarded.toggles && guarded.requests == 0;
        guarded.ahead = Some((cx.at, toggle, counts));
        if counts {
            guarded.answer_at(node, toggle, cx.at, cx);
        }
    }

    /// Takes an unreadable answer.
    pub fn excuse(&mut self, node: u8) {
        if let Some(guarded) = self.nodes.get_mut(node) {
            (guarded.request, guarded.toggle) = (None, None);
        }
    }

    /// Restarts a node that is reset or has booted: its toggle bit begins at 0.
    pub fn restart(&mut self, node: u8, nmt: &Nmt, cx: &mut Context<'_>) {
        self.life.void(|id| node == 0 || node == *id);
        for (id, guarded) in self.nodes.iter_mut() {
            if node == 0 || node == id {
                let request = guarded.request.filter(|request| {
                    cx.evidence.recording.certainly_later(cx.when, *request, SLOW_NS) && !guarded.doubtful
                });
                if let Some(request) = request {
                    guarded.unanswered(id, request.at, nmt, cx);
                }
                guarded.settle(id, None, cx);
                guarded.period.doubt();
                // A single frame with toggle bit 1 stays undecided until later frames decide.
                (guarded.request, guarded.toggle, guarded.ahead) = (None, None, None);
                (guarded.silent, guarded.unasked, guarded.second) = (false, 0, 0);
            }
        }
    }

    /// Forgets requests and answers after lost frames.
    pub fn forget(&mut self, cx: &mut Context<'_>) {
        self.life.void(|_| true);
        for (node, guarded) in self.nodes.iter_mut() {
            guarded.settle(node, None, cx);
            (guarded.request, guarded.toggle, guarded.ahead) = (None, None, None);
            // It may send heartbeats instead by now.
            (guarded.toggles, guarded.requests, guarded.first, guarded.unasked) = (false, 0, None, 0);
            guarded.second = 0;
            guarded.lone = None;
        }
    }

    /// Reports requests that should have been answered by `now_ns`.
    #[inline]
    pub fn advance(&mut self, now_ns: Ns, nmt: &Nmt, heartbeats: &Heartbeats, cx: &mut Context<'_>) {
        if self.life.may_be_due(now_ns) {
            self.overdue(now_ns, cx);
        }
        if now_ns >= self.next {
            self.miss(now_ns, nmt, heartbeats, cx);
        }
    }

    fn miss(&mut self, now_ns: Ns, nmt: &Nmt, heartbeats: &Heartbeats, cx: &mut Context<'_>) {
        let now = cx.clock(now_ns);
        self.next = Ns::MAX;
        for (node, guarded) in self.nodes.iter_mut() {
            let Some(request) = guarded.request else { continue };
            let due = request.at.t_ns.map_or(Ns::MAX, |asked| asked + UNANSWERED_NS);
            if due > now_ns || !cx.evidence.recording.certainly_later(now, request, UNANSWERED_NS) {
                // In a burst of the recorder the answer may still come.
                self.next = self.next.min(due);
            } else if guarded.doubtful || cx.evidence.recording.was_silent(node, due, UNANSWERED_NS, now_ns) {
                guarded.request = None;
            } else if guarded.toggles || !heartbeats.produces(node) {
                guarded.request = None;
                guarded.unanswered(node, request.at, nmt, cx);
            }
        }
    }

    /// Reports nodes that were asked and never seen, at the end of the capture.
    pub fn finish(&mut self, nmt: &Nmt, cx: &mut Context<'_>) {
        for (node, guarded) in self.nodes.iter_mut() {
            guarded.settle(node, None, cx);
            if guarded.requests > 1 && !nmt.is_present(node) {
                cx.raise(Grd004::Absent { requests: guarded.requests }, Some(node), None, guarded.first);
            }
        }
    }
}

impl Guarded {
    /// Returns true if a frame may be the answer to a request; within a burst of the recorder at any age.
    fn is_asked(&self, cx: &Context<'_>) -> bool {
        let recording = &cx.evidence.recording;
        let late = |asked: When| {
            cx.at.t_ns.is_some() && recording.teaches(cx.when) && recording.certainly_later(cx.when, asked, ANSWER_NS)
        };
        self.request.is_some_and(|asked| !late(asked))
    }

    /// Reports the frame with bit 7 as a heartbeat.
    fn was_heartbeat(&mut self, node: u8, cx: &mut Context<'_>) {
        if let Some(Lone { at, byte: found, .. }) = self.lone.take() {
            let finding = cx.verdict(Hbt003::ToggleBit { found }, Some(node), None, None);
            cx.report(Finding { at, ..finding });
        }
        (self.toggles, self.toggle, self.ahead, self.answer) = (false, None, None, None);
    }

    fn answer_at(&mut self, node: u8, toggle: bool, at: FrameRef, cx: &mut Context<'_>) {
        let gap = self.answer.replace(at).and_then(|before| at.since(before));
        let lacks_answers = gap.is_some_and(|gap| self.lacks_odd_number(gap));
        if let Some(gap) = gap {
            let _ = self.period.take(gap, cx.evidence.recording.resolution_ns(), at);
        }
        if self.toggle == Some(toggle) && lacks_answers {
            return;
        }
        if self.toggle == Some(toggle) {
            // The node may continue either way: the next toggle bit is not judged.
            self.toggle = None;
            return report_toggle(node, toggle, at, cx);
        }
        self.toggle = Some(toggle);
    }

    /// Returns true if an odd number of answers is missing in the time between two, and the last one is in time.
    fn lacks_odd_number(&self, gap: Ns) -> bool {
        let Some(period) = self.period.learnt_ns().filter(|period| *period > Ns::ZERO) else { return false };
        let periods = (gap + period / 2) / period;
        periods % 2 == 0 && periods > 0 && (gap - periods * period).abs() <= period / ON_TIME_PART
    }

    fn unanswered(&mut self, node: u8, request: FrameRef, nmt: &Nmt, cx: &mut Context<'_>) {
        let toggle = self.toggle.take();
        if self.silent || !nmt.is_present(node) || nmt.resetting(node).is_some() {
            return;
        }
        if self.unanswered.is_some() {
            return self.settle(node, None, cx);
        }
        let what = match cx.at.since(request) {
            Some(age) => Grd002::NoResponseWithin { age },
            None => Grd002::NoResponse,
        };
        let finding = cx.verdict(what, Some(node), None, Some(request));
        self.unanswered = Some(Unanswered { finding, at: cx.when, toggle: toggle.unwrap_or_default() });
        if toggle.is_none() {
            self.settle(node, None, cx);
        }
    }

    /// Reports the request without answer that waits, unless the next answer has this toggle bit and shows that one was
    /// sent.
    fn settle(&mut self, node: u8, toggle: Option<bool>, cx: &mut Context<'_>) {
        let Some(Unanswered { finding, at, toggle: before }) = self.unanswered.take() else { return };
        if toggle == Some(before) {
            return;
        }
        self.silent = true;
        cx.report(finding);
        cx.evidence.circumstances.note(CircumstanceKind::NodeLost, Some(node), at);
    }

    /// Settles a frame that no request has followed.
    fn expire(&mut self, node: u8, cx: &mut Context<'_>) {
        let Some((frame, toggle, counted)) = self.ahead.take() else { return };
        if !counted {
            // It may be an answer whose request was assigned to the frame before.
            self.toggle = None;
        }
        if toggle || self.requests == 0 || !self.toggles {
            return;
        }
        if self.unasked == 0 {
            self.unasked_since = frame;
        }
        self.unasked = self.unasked.saturating_add(1);
        let after = self.answer.and_then(|answer| frame.since(answer));
        self.second =
            self.second.saturating_add(u8::from(after.is_some_and(|ns| (Ns::ZERO..=SECOND_NS).contains(&ns))));
        // A node that sends heartbeats instead is not guarded any longer.
        let guarded = self.requests == 0 || self.asked.is_some_and(|asked| asked.no > self.unasked_since.no);
        if self.unasked >= UNASKED && guarded && !self.both {
            self.both = true;
            if self.second < self.unasked {
                return cx.raise(Grd003::Heartbeats, Some(node), None, Some(frame));
            }
            cx.evidence.circumstances.note(CircumstanceKind::SharedId, Some(node), cx.when);
            cx.raise(Hbt004::Responses, Some(node), None, Some(frame));
        }
    }
}

/// Reports a toggle bit that did not alternate.
fn report_toggle(node: u8, toggle: bool, at: FrameRef, cx: &mut Context<'_>) {
    let finding = cx.verdict(Grd001::Toggle { found: toggle, expected: !toggle }, Some(node), None, None);
    cx.report(Finding { at, ..finding });
}

/// Returns true if the current frame is likely a duplicate. In a recorder's burst requests and answers are as close.
fn is_duplicate(cx: &Context<'_>) -> bool {
    cx.sighting == Sighting::Suspect && cx.evidence.recording.teaches(cx.when)
}
