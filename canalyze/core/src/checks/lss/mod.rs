//! LSS (CiA 305): the slaves in the configuration state, the master's requests, and the slaves' answers.
//!
//! An answer is explained by any earlier request of its kind, and by one that follows within the delay of the
//! recording's own frames (`evidence::recording`). Events before the capture or in a gap are unknown, and no verdict
//! rests on them. An absent slave is no fault: only a selected slave owes an answer. Fastscan's bits are followed in
//! `fastscan`, node-IDs in `node_id`.

pub mod bit_timing;
pub mod exchange;
pub mod fastscan;
pub mod node_id;
pub mod selection;
pub mod withheld;

use self::bit_timing::BitTiming;
use self::exchange::{Asked, Early, Exchange, Exchanges, configures, specifier};
use self::fastscan::{Fastscan, Over, ScanStep};
use self::node_id::{Before, NodeIds};
use self::selection::{Selected, Selection};
use self::withheld::Withheld;
use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::evidence::duplicates::Sighting;
use crate::evidence::recording::Verdict;
use crate::rules::finding::Code;
use crate::rules::lss::{Lss001, Lss002, Lss003, Lss004, Lss007, Lss009, Lss010, Lss011, Lss012};
use crate::wire::cob_id::Role;
use crate::wire::lss::{BIT_CHECK_ANY, Command, LssSetting, Part, UNCONFIGURED, is_plain};
use crate::wire::message::{Flaw, Message};
use crate::wire::nmt;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::event::{Note, What};
use crate::world::node::{Node, PerNode};

/// Time after its last step for which a Fastscan counts as in progress, in ns.
const PATIENCE_NS: Ns = Ns::from_s(5);

/// The state of LSS on one bus.
#[derive(Debug, Default)]
pub struct Lss {
    findings: Withheld,
    selection: Selection,
    exchanges: Exchanges,
    scan: Fastscan,
    node_ids: NodeIds,
    bit_timing: BitTiming,
    /// The time of the next deadline, in ns.
    due_ns: Option<Ns>,
}

impl Lss {
    /// Takes one frame that is neither SDO nor PDO; returns the old and the new node-ID of a node that LSS has renamed.
    pub fn follow(
        &mut self,
        message: &Message,
        frame: &Frame,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<(u8, u8)> {
        self.exchanges.lag_ns = cx.evidence.recording.lag_ns();
        let mut moved = None;
        match *message {
            Message::Lss { from_master, command } => {
                let plain = is_plain(from_master, frame.payload());
                self.findings.follow(cx.at, from_master, plain && !matches!(command, Command::Unknown(_)));
                if from_master { self.master(command, plain, nodes, cx) } else { self.slave(command, plain, nodes, cx) }
            }
            Message::Malformed { role: role @ (Role::LssRequest | Role::LssResponse), flaw: Flaw::Length { .. } } => {
                let from_master = matches!(role, Role::LssRequest);
                self.findings.follow(cx.at, from_master, false);
                self.unreadable(from_master, cx.at);
                self.findings.raise(Lss001::Length { length: frame.len.into() }, None, None, cx);
            }
            Message::Nmt { command, node } if nmt::is_reset(command) => {
                self.settle_early(nodes, cx);
                self.restarted(cx);
                self.node_ids.reset(command, node, cx.at);
            }
            Message::BootUp { node } => {
                self.settle_early(nodes, cx);
                self.restarted(cx);
                if let Some((from, since)) = self.node_ids.booted(node, cx.at, &mut self.findings, cx) {
                    cx.push(Some(since), Some(node), What::Note(Note::NodeIdChanged { from, to: node }));
                    moved = Some((from, node));
                }
            }
            Message::Heartbeat { node, .. } => {
                // The deadline may be earlier than needed, which costs one check.
                self.node_ids.alive(node);
                return None;
            }
            _ => return None,
        }
        self.schedule();
        moved
    }

    /// Reports what is overdue at `now_ns`, and a frame that breaks the silence.
    #[inline]
    pub fn advance(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        if self.due_ns.is_some_and(|due_ns| now_ns >= due_ns) {
            self.judge_due(now_ns, cx);
        }
    }

    fn judge_due(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        // In a burst, an answer may follow frames that came after it was due.
        if cx.evidence.recording.verdict(cx.when.burst) == Some(Verdict::Confirmed) {
            return;
        }
        self.bit_timing.heard(now_ns, &mut self.findings, cx);
        let stale = self.exchanges.stale(now_ns);
        self.all_unexplained(stale, cx);
        while let Some((exchange, asked)) = self.exchanges.overdue(now_ns) {
            self.unanswered(exchange, asked, cx);
        }
        if self.scan.last().and_then(|last| last.t_ns).is_some_and(|last| last + PATIENCE_NS <= now_ns) {
            let over = self.scan.give_up();
            self.scan.lost();
            self.scanned(over, cx);
        }
        self.bit_timing.advance(now_ns, &mut self.findings, cx);
        self.node_ids.advance(now_ns, &mut self.findings, cx);
        self.schedule();
    }

    /// Forgets selections and requests after lost frames.
    pub fn lost(&mut self) {
        self.selection.lost();
        self.exchanges.lost();
        self.bit_timing.lost();
        self.scan.lost();
        self.node_ids.lost();
        self.schedule();
    }

    /// Returns the number of its frames, and true if they are known to be LSS.
    pub fn shown(&self) -> (u64, bool) {
        self.findings.shown()
    }

    /// Reports what is open at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        let left = self.exchanges.left();
        self.all_unexplained(left, cx);
        let over = self.scan.give_up();
        self.scanned(over, cx);
        self.findings.finish(cx);
    }

    fn master(&mut self, command: Command, plain: bool, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        self.settle_early(nodes, cx);
        let exchange = Exchange::asked_by(command);
        let (own, others) = self.exchanges.settle(exchange, cx.at);
        self.all_unexplained(others, cx);
        let configures = configures(command);
        let proving = configures && self.scan.may_have_found();
        if !proving && !matches!(command, Command::Fastscan { .. } | Command::Unknown(_)) {
            let over = self.scan.give_up();
            self.scanned(over, cx);
        }
        let unselected = configures && self.selection.selected == Selected::Nobody && own.is_empty() && !proving;
        if unselected {
            self.findings.raise(Lss003::NotSelected { command: specifier(command) }, None, None, cx);
        }
        self.take(command, cx);
        if let Some(exchange) = exchange {
            let certain = matches!(self.selection.selected, Selected::Slaves(_)) && !proving;
            let settled = unselected || proving;
            let (doubtful, own): (Vec<Early>, Vec<Early>) = own.into_iter().partition(|early| early.repeats);
            let early = doubtful.into_iter().next();
            let open = Asked { at: cx.at, owed: 1, answered: false, plain, certain, settled, surplus: None, early };
            self.exchanges.open(exchange, open);
            for early in own {
                self.answered(exchange, early.command, early.plain, early.at, nodes, cx);
            }
        }
    }

    /// Applies the immediate effect of a master's command.
    fn take(&mut self, command: Command, cx: &mut Context<'_>) {
        match command {
            Command::Unknown(found) => {
                self.unreadable(true, cx.at);
                self.findings.raise(Lss001::ByMaster { command: found }, None, None, cx);
            }
            Command::SwitchGlobal { mode } => self.switch(mode, cx),
            Command::SwitchSelective { part, value } => self.selective(part, value, cx),
            Command::ConfigureNodeId { node } => self.node_ids.request(node),
            Command::ConfigureBitTiming { selector, index } => self.bit_timing.configure(selector, index),
            Command::ActivateBitTiming { delay } => self.activate(delay, cx),
            Command::Fastscan { id_number, bit_check, sub, next } => {
                self.step(ScanStep { id_number, bit_check, sub, next }, cx);
            }
            _ => {}
        }
    }

    fn activate(&mut self, delay: u16, cx: &mut Context<'_>) {
        if self.bit_timing.activate(delay, cx) {
            self.exchanges.forgive();
        }
    }

    fn switch(&mut self, mode: u8, cx: &mut Context<'_>) {
        self.selection.switch(mode);
        if mode == 0 {
            self.node_ids.waiting(cx.at);
            self.bit_timing.waiting(cx.at);
        }
    }

    fn selective(&mut self, part: Part, value: u32, cx: &mut Context<'_>) {
        if part.number() == 0
            && let Some(asked) = self.exchanges.give_up(Exchange::Selective)
        {
            // The master goes on to the next slave: the one before was absent.
            self.unanswered(Exchange::Selective, asked, cx);
        }
        if let Some(expected) = self.selection.part(part, value) {
            let what = Lss011::Order { found: 0x40 + part.number(), expected: 0x40 + expected };
            self.findings.raise(what, None, None, cx);
        }
    }

    fn step(&mut self, step: ScanStep, cx: &mut Context<'_>) {
        let bad_bit = step.bit_check >= 32 && step.bit_check != BIT_CHECK_ANY;
        if bad_bit {
            return self.findings.raise(Lss010::BitCheck { found: step.bit_check }, None, None, cx);
        }
        if step.sub > 3 || step.next > 3 {
            let what = Lss010::SubOrNext { sub: step.sub.into(), next: step.next.into() };
            return self.findings.raise(what, None, None, cx);
        }
        let over = self.scan.step(step, cx.at, cx.evidence.recording.lag_ns());
        self.scanned(over, cx);
        if self.scan.may_have_found() {
            self.selection.selected = Selected::Unknown;
        }
    }

    fn slave(&mut self, command: Command, plain: bool, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if let Command::Unknown(found) = command {
            self.unreadable(false, cx.at);
            return self.findings.raise(Lss001::BySlave { command: found }, None, None, cx);
        }
        let repeats = cx.sighting == Sighting::Suspect;
        let Some(exchange) = Exchange::answered_by(command) else { return };
        if let Some(early) = self.exchanges.take_early(exchange) {
            // The request has its own answer: the one captured before it is a duplicate.
            self.unexplained(early, cx);
        }
        if self.exchanges.explains(exchange) {
            self.answered(exchange, command, plain, cx.at, nodes, cx);
        } else {
            self.exchanges.hold(Early { at: cx.at, exchange, command, plain, repeats, passed: false });
        }
    }

    /// Assigns early answers to their requests, because the master goes on and no other answers have come.
    fn settle_early(&mut self, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        while let Some(early) = self.exchanges.take_any_early() {
            self.answered(early.exchange, early.command, early.plain, early.at, nodes, cx);
        }
    }

    /// Takes a slave's answer to a request. `at` is its frame, which may precede the request.
    fn answered(
        &mut self,
        exchange: Exchange,
        command: Command,
        plain: bool,
        at: FrameRef,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) {
        let Some(asked) = self.exchanges.answered(exchange, at) else { return };
        if plain && asked.plain {
            self.findings.show(cx);
        }
        if exchange.configures() {
            self.show_selected(asked, cx);
        }
        match command {
            Command::SwitchSelectiveResponse => {
                let address = self.selection.address();
                let before = address.and_then(|address| holder(nodes, address)).map_or(Before::Unknown, Before::Node);
                self.selection.join(address, before);
                if let Some(address) = address {
                    cx.push(Some(asked.at), None, What::Note(Note::LssSelected { address }));
                }
            }
            Command::IdentifySlave => {
                let over = self.scan.answer(at);
                self.scanned(over, cx);
            }
            Command::Confirmation { of, error: 0, .. } => self.accepted(of, at),
            Command::Confirmation { error, specific, .. } => {
                let command = exchange.specifier();
                let error = (command, error);
                let what = match error {
                    (_, 0xFF) => Lss004::RefusedSpecific { command, error, specific },
                    _ => Lss004::Refused { command, error },
                };
                self.findings.raise(what, None, Some(asked.at), cx);
            }
            Command::InquireNodeIdResponse { node } => {
                self.selection.before = match node {
                    UNCONFIGURED => Before::Unconfigured,
                    1..=127 => Before::Node(node),
                    _ => Before::Unknown,
                };
            }
            _ => {}
        }
    }

    /// Takes evidence that a slave is in the configuration state.
    fn show_selected(&mut self, asked: Asked, cx: &mut Context<'_>) {
        while let Some((other, request)) = self.exchanges.passed_over(asked.at) {
            self.silent(other, request, cx);
        }
        let over = self.scan.proven(cx.at);
        self.scanned(over, cx);
        let unknown = self.selection.selected == Selected::Unknown;
        if unknown || self.selection.selected == Selected::Nobody {
            self.selection.selected = Selected::Unknown;
            let asked = self.exchanges.give_up(Exchange::Selective);
            if let Some(asked) = asked.filter(|asked| unknown && !asked.answered) {
                // It was selected and did not answer.
                self.silent(Exchange::Selective, asked, cx);
            }
        }
    }

    fn accepted(&mut self, of: LssSetting, at: FrameRef) {
        match of {
            LssSetting::NodeId => self.node_ids.accept(self.selection.single(), self.selection.number, at),
            LssSetting::BitTiming => self.bit_timing.accept(at),
            LssSetting::Store => {
                self.node_ids.stored(self.selection.number);
                self.bit_timing.store();
            }
        }
    }

    fn scanned(&mut self, over: Option<Over>, cx: &mut Context<'_>) {
        let Some((first, scanned)) = over else { return };
        cx.push(Some(first), None, What::Note(Note::Fastscan(scanned)));
        if scanned.found {
            self.selection.join(None, Before::Unconfigured);
        }
    }

    /// Takes a reset or boot-up of a node.
    fn restarted(&mut self, cx: &mut Context<'_>) {
        while let Some((exchange, asked)) = self.exchanges.overtaken(cx.at) {
            self.silent(exchange, asked, cx);
        }
        self.selection.restarted();
        self.bit_timing.restarted();
        self.exchanges.forgive();
    }

    /// Takes an unreadable frame, which may be any request or answer; a wrong bit in its identifier swaps the sides.
    fn unreadable(&mut self, request: bool, at: FrameRef) {
        self.selection.unreadable();
        self.exchanges.unreadable(request, at);
    }

    /// Reports answers without request: those of one kind lack the same one.
    fn all_unexplained(&mut self, mut early: Vec<Early>, cx: &mut Context<'_>) {
        early.dedup_by_key(|early| early.exchange);
        for early in early {
            self.unexplained(early, cx);
        }
    }

    /// Reports an answer without request.
    fn unexplained(&mut self, early: Early, cx: &mut Context<'_>) {
        if self.exchanges.may_be_requested(early.at) {
            return;
        }
        let cause = (early.at.no != cx.at.no).then_some(early.at);
        let command = early.exchange.answer();
        if !self.exchanges.is_recent(early.exchange, early.at) {
            self.selection.selected = Selected::Unknown;
            // It takes the place of the outstanding answer, or its request that of the open one.
            self.exchanges.excuse();
            self.findings.raise(Lss002::Unrequested { command }, None, cause, cx);
            return;
        }
        if early.exchange == Exchange::InquireNodeId {
            self.selection.before = Before::Unknown;
        }
        let what = match early.exchange {
            Exchange::Selective => Lss007::SameAddress { command },
            _ => Lss007::InConfiguration { command },
        };
        self.findings.raise(what, None, cause, cx);
    }

    /// Reports a request without answer.
    fn unanswered(&mut self, exchange: Exchange, asked: Asked, cx: &mut Context<'_>) {
        let cause = (asked.at.no != cx.at.no).then_some(asked.at);
        if exchange == Exchange::Selective {
            let Some([vendor, product, revision, serial]) = self.selection.address() else {
                return self.findings.raise_timed(Code::Lss012, None, cause, cx);
            };
            let what = Lss012::Address { vendor, product, revision, serial };
            return self.findings.raise_timed(what, None, cause, cx);
        }
        let (command, limit) = (exchange.specifier(), exchange.limit_ns());
        if asked.certain {
            self.findings.raise_timed(Lss009::NoResponseWithin { command, limit }, None, cause, cx);
        } else {
            self.findings.raise_timed(Lss012::Command { command, limit }, None, cause, cx);
        }
    }

    /// Reports that a selected slave has not answered before the master went on.
    fn silent(&mut self, exchange: Exchange, asked: Asked, cx: &mut Context<'_>) {
        self.findings.raise(Lss009::NoResponse { command: exchange.specifier() }, None, Some(asked.at), cx);
    }

    fn schedule(&mut self) {
        let scan = self.scan.last().and_then(|last| last.t_ns).map(|last| last + PATIENCE_NS);
        let due = [self.exchanges.due(), self.node_ids.due(), scan, self.bit_timing.due()];
        self.due_ns = due.into_iter().flatten().min();
    }
}

/// Returns the only node known to have an LSS address in its identity object.
fn holder(nodes: &PerNode<Node>, address: [u32; 4]) -> Option<u8> {
    let holds = |node: &Node| {
        (1..).zip(address).all(|(sub, part)| {
            let known = node.value(0x1018, sub).filter(|(_, from)| *from > Provenance::Eds);
            known.is_some_and(|(value, _)| value == u64::from(part))
        })
    };
    let mut found = nodes.iter().filter(|(_, node)| holds(node)).map(|(id, _)| id);
    found.next().filter(|_| found.next().is_none())
}
