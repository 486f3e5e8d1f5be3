//! LSS (CiA 305): which slaves are in the configuration state, what the master has asked, and who answers.
//!
//! An answer is explained by any earlier request of its kind, and by one that follows within the lag of the
//! recording's own frames (`evidence::recording`). What happened before the capture, or in a gap, is unknown, and nothing
//! rests on it. Whether a slave answers nothing because it is not there is no fault: only a slave that was selected owes
//! an answer. It must not follow Fastscan's bits (`fastscan`) or the fate of node-IDs (`node_id`).

pub mod exchange;
pub mod fastscan;
pub mod node_id;
pub mod withheld;

use self::exchange::{Asked, Early, Exchange, Exchanges, configures, specifier};
use self::fastscan::{Fastscan, Over, Step};
use self::node_id::{Before, NodeIds};
use self::withheld::Withheld;
use crate::cob_id::Role;
use crate::configuration::Provenance;
use crate::context::Context;
use crate::event::{Event, Note, What};
use crate::evidence::duplicates::Sighting;
use crate::evidence::recording::Verdict;
use crate::finding::Code;
use crate::frame::{Frame, FrameRef};
use crate::message::{Flaw, Message};
use crate::node::{Node, PerNode};
use crate::rules::lss::{Lss001, Lss002, Lss003, Lss004, Lss007, Lss008, Lss009, Lss010, Lss011, Lss012};
use crate::services::lss::{BIT_CHECK_ANY, Command, Part, Setting, UNCONFIGURED, bit_rate, is_plain};

/// NMT commands that reset nodes.
const RESETS: [u8; 2] = [0x81, 0x82];
/// How long after its last step a Fastscan is under way, in ns.
const PATIENCE_NS: i64 = 5_000_000_000;
/// How long after the return to waiting a bit timing may still be activated, in ns: masters do it at once.
const ACTIVATION_NS: i64 = 500_000_000;
/// Valid LSS frames for each finding, before the traffic counts as LSS.
const PLAIN: usize = 3;

/// Which slaves are in the configuration state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Selected {
    /// Not known.
    #[default]
    Unknown,
    /// None: all were switched to waiting.
    Nobody,
    /// So many that have answered a selective switch or a Fastscan.
    Slaves(u32),
    /// Every slave on the bus, if there is any.
    All,
}

/// What is known of the slave in the configuration state.
#[derive(Debug)]
struct Slave {
    /// Selections so far.
    selection: u64,
    /// Its address, as it was selected by.
    address: Option<[u32; 4]>,
    /// Its node-ID, as it has reported or as follows from how it was found.
    before: Before,
}

/// A bit timing that a slave has accepted.
#[derive(Debug)]
struct Timing {
    at: FrameRef,
    rate: Option<u16>,
    stored: bool,
    /// The slaves have returned to waiting: from then on until when it should be activated.
    until_ns: Option<i64>,
}

/// The time during which the bus is silent for the change of the bit rate.
#[derive(Debug)]
struct Silence {
    at: FrameRef,
    from_ns: i64,
    to_ns: i64,
    delay_ns: i64,
}

/// LSS on one bus.
#[derive(Debug)]
pub struct Lss {
    findings: Withheld,
    /// The first LSS frame.
    first: Option<FrameRef>,
    selected: Selected,
    slave: Slave,
    exchanges: Exchanges,
    /// The address that the master is sending, and the part that comes next; `None` where that is not known.
    address: [Option<u32>; 4],
    due_part: Option<u8>,
    /// That the parts of this address come out of turn has been said.
    misordered: bool,
    /// The node-ID and the bit rate that the master has asked for last.
    wanted: Option<u8>,
    rate: Option<u16>,
    timing: Option<Timing>,
    silence: Option<Silence>,
    scan: Fastscan,
    node_ids: NodeIds,
    /// The last frame of the master that could not be read, until an answer that has no other request.
    odd_request: Option<FrameRef>,
    /// The last frame of the master.
    last: Option<FrameRef>,
    /// Frames that LSS knows, with their unused bytes 0.
    plain: usize,
    /// A slave's is among them.
    answered: bool,
    /// When something becomes due, in ns.
    due_ns: i64,
}

impl Default for Lss {
    fn default() -> Self {
        Self {
            findings: Withheld::default(),
            first: None,
            selected: Selected::Unknown,
            slave: Slave { selection: 0, address: None, before: Before::Unknown },
            exchanges: Exchanges::default(),
            address: [None; 4],
            due_part: None,
            misordered: false,
            wanted: None,
            rate: None,
            timing: None,
            silence: None,
            scan: Fastscan::default(),
            node_ids: NodeIds::default(),
            odd_request: None,
            last: None,
            plain: 0,
            answered: false,
            due_ns: i64::MAX,
        }
    }
}

impl Lss {
    /// Takes one frame that is neither SDO nor PDO. Says which node has another node-ID now: the old and the new one.
    pub fn follow(
        &mut self,
        message: &Message,
        frame: &Frame,
        nodes: &PerNode<Node>,
        cx: &mut Context<'_>,
    ) -> Option<(u8, u8)> {
        self.node_ids.next_frame();
        self.exchanges.lag_ns = cx.evidence.recording.lag_ns();
        let mut moved = None;
        match *message {
            Message::Lss { from_master, command } => {
                self.first.get_or_insert(cx.at);
                let plain = is_plain(from_master, frame.payload());
                let plain_command = plain && !matches!(command, Command::Unknown(_));
                self.plain += usize::from(plain_command);
                self.answered |= plain_command && !from_master;
                if from_master { self.master(command, plain, nodes, cx) } else { self.slave(command, plain, nodes, cx) }
            }
            Message::Malformed { role: role @ (Role::LssRequest | Role::LssResponse), flaw: Flaw::Length { .. } } => {
                self.first.get_or_insert(cx.at);
                self.unreadable(matches!(role, Role::LssRequest), cx.at);
                self.findings.raise(Lss001::Length { length: frame.len.into() }, None, None, cx);
            }
            Message::Nmt { command, node } if RESETS.contains(&command) => {
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
                // What is due too early only costs a look.
                self.node_ids.alive(node);
                return None;
            }
            _ => return None,
        }
        self.schedule();
        moved
    }

    /// Whether the boot-up of `node` at the frame at hand, which was followed before, is the consequence of LSS: the
    /// slave was given this node-ID.
    pub fn explains_boot_up(&self, node: u8) -> bool {
        self.node_ids.explains_boot_up(node)
    }

    /// It is `now_ns`: what is overdue, and whether the frame at hand, if any, breaks the silence.
    pub fn advance(&mut self, now_ns: i64, cx: &mut Context<'_>) {
        if now_ns < self.due_ns {
            return;
        }
        // In a burst an answer may stand behind frames that came after it was due.
        if cx.evidence.recording.verdict(cx.when.burst) == Some(Verdict::Confirmed) {
            return;
        }
        self.heard(now_ns, cx);
        let stale = self.exchanges.stale(now_ns);
        self.all_unexplained(stale, cx);
        while let Some((exchange, asked)) = self.exchanges.overdue(now_ns) {
            self.unanswered(exchange, asked, cx);
        }
        if self.scan.last().and_then(|last| last.t_ns).is_some_and(|last| last.saturating_add(PATIENCE_NS) <= now_ns) {
            let over = self.scan.give_up();
            self.scan.lost();
            self.scanned(over, cx);
        }
        if let Some(timing) = self.timing.take_if(|timing| timing.until_ns.is_some_and(|until| until <= now_ns))
            && !timing.stored
        {
            self.findings.raise_timed(Code::Lss006, None, Some(timing.at), cx);
        }
        self.node_ids.advance(now_ns, &mut self.findings, cx);
        self.schedule();
    }

    /// Frames of the bus were lost: slaves may have been switched, and answers missed.
    pub fn lost(&mut self) {
        self.selected = Selected::Unknown;
        self.select(None, Before::Unknown);
        self.exchanges = Exchanges::default();
        self.address = [None; 4];
        (self.due_part, self.misordered) = (None, false);
        self.timing = None;
        self.silence = None;
        self.scan.lost();
        self.node_ids.lost();
        self.schedule();
    }

    /// The capture is over.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        let left = self.exchanges.left();
        self.all_unexplained(left, cx);
        let over = self.scan.give_up();
        self.scanned(over, cx);
        if self.answered && self.plain >= PLAIN && self.findings.waiting() * PLAIN <= self.plain {
            self.findings.show(cx);
        }
        if let Some(first) = self.first {
            self.findings.finish(Code::Lss012, Code::Lss030, first, cx);
        }
    }

    fn master(&mut self, command: Command, plain: bool, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        self.settle_early(nodes, cx);
        let exchange = Exchange::asked_by(command);
        self.last = Some(cx.at);
        let (own, others) = self.exchanges.settle(exchange, cx.at);
        self.all_unexplained(others, cx);
        let configures = configures(command);
        let proving = configures && self.scan.may_have_found();
        if !proving && !matches!(command, Command::Fastscan { .. } | Command::Unknown(_)) {
            let over = self.scan.give_up();
            self.scanned(over, cx);
        }
        let unselected = configures && self.selected == Selected::Nobody && own.is_empty() && !proving;
        if unselected {
            self.findings.raise(Lss003::NotSelected { command: specifier(command) }, None, None, cx);
        }
        self.told(command, cx);
        if let Some(exchange) = exchange {
            let certain = matches!(self.selected, Selected::Slaves(_)) && !proving;
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

    /// What a command of the master changes at once.
    fn told(&mut self, command: Command, cx: &mut Context<'_>) {
        match command {
            Command::Unknown(found) => {
                self.unreadable(true, cx.at);
                self.findings.raise(Lss001::ByMaster { command: found }, None, None, cx);
            }
            Command::SwitchGlobal { mode } => self.switch(mode, cx),
            Command::SwitchSelective { part, value } => self.selective(part, value, cx),
            Command::ConfigureNodeId { node } => self.wanted = Some(node),
            Command::ConfigureBitTiming { selector, index } => {
                self.rate = if selector == 0 { bit_rate(index) } else { None };
            }
            Command::ActivateBitTiming { delay } => self.activate(delay, cx),
            Command::Fastscan { id_number, bit_check, sub, next } => {
                self.step(Step { id_number, bit_check, sub, next }, cx);
            }
            _ => {}
        }
    }

    fn switch(&mut self, mode: u8, cx: &mut Context<'_>) {
        self.selected = match mode {
            0 => Selected::Nobody,
            1 => Selected::All,
            _ => Selected::Unknown,
        };
        self.select(None, Before::Unknown);
        (self.due_part, self.misordered) = (Some(0), false);
        if mode == 0 {
            self.node_ids.waiting(cx.at);
            if let Some(timing) = &mut self.timing {
                timing.until_ns = cx.at.t_ns.map(|now| now.saturating_add(ACTIVATION_NS));
            }
        }
    }

    fn selective(&mut self, part: Part, value: u32, cx: &mut Context<'_>) {
        let number = part.number();
        if number == 0 {
            // The master goes on to the next slave: the one before was not there.
            if let Some(asked) = self.exchanges.give_up(Exchange::Selective) {
                self.unanswered(Exchange::Selective, asked, cx);
            }
            self.address = [None; 4];
        }
        if let Some(due) = self.due_part.filter(|due| *due != number && number != 0) {
            if !std::mem::replace(&mut self.misordered, true) {
                let what = Lss011::Order { found: 0x40 + number, expected: 0x40 + due };
                self.findings.raise(what, None, None, cx);
            }
            // Which one is wrong, this one or the one before, shows with the next address.
            self.due_part = None;
        }
        self.misordered &= number != 3;
        if number == 0 || self.due_part.is_some() {
            self.due_part = Some((number + 1) % 4);
        }
        if let Some(slot) = self.address.get_mut(usize::from(number)) {
            *slot = Some(value);
        }
    }

    fn step(&mut self, step: Step, cx: &mut Context<'_>) {
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
            self.selected = Selected::Unknown;
        }
    }

    fn activate(&mut self, delay: u16, cx: &mut Context<'_>) {
        let Some(timing) = self.timing.take() else { return };
        cx.push(Some(timing.at), None, What::Note(Note::BitTimingActivated { delay, rate: timing.rate }));
        self.exchanges.forgive();
        let Some(now) = cx.at.t_ns else { return };
        let delay_ns = i64::from(delay) * 1_000_000;
        // Frames that were under way, and clocks that differ, at either end.
        let grace = cx.evidence.recording.lag_ns().max(delay_ns / 10);
        let (from_ns, to_ns) = (now.saturating_add(grace), now.saturating_add(2 * delay_ns - grace));
        self.silence = (from_ns < to_ns).then_some(Silence { at: cx.at, from_ns, to_ns, delay_ns });
    }

    /// A frame during the silence. Error frames are what a change of the bit rate looks like.
    fn heard(&mut self, now_ns: i64, cx: &mut Context<'_>) {
        let Some(silence) = self.silence.take_if(|silence| silence.from_ns <= now_ns) else { return };
        if now_ns >= silence.to_ns {
            return;
        }
        let own = cx.events.first().filter(|event| event.at == cx.at);
        match own.map(|Event { what, .. }| what) {
            None | Some(What::Message(Message::ErrorFrame)) => self.silence = Some(silence),
            Some(_) => {
                let elapsed = now_ns.saturating_sub(silence.at.t_ns.unwrap_or(now_ns));
                let what = Lss008::Frame { elapsed, silence: silence.delay_ns.saturating_mul(2) };
                self.findings.raise(what, None, Some(silence.at), cx);
            }
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
            // The request has an answer of its own: the one captured before it was the one before, twice.
            self.unexplained(early, cx);
        }
        if self.exchanges.explains(exchange) {
            self.answered(exchange, command, plain, cx.at, nodes, cx);
        } else {
            self.exchanges.hold(Early { at: cx.at, exchange, command, plain, repeats, passed: false });
        }
    }

    /// The master goes on, and its request has no other answer than one captured before it.
    fn settle_early(&mut self, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        while let Some(early) = self.exchanges.take_any_early() {
            self.answered(early.exchange, early.command, early.plain, early.at, nodes, cx);
        }
    }

    /// A slave's answer to a request. `at` is its frame; the request may have been captured after it.
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
            while let Some((other, request)) = self.exchanges.passed_over(asked.at) {
                self.silent(other, request, cx);
            }
            let over = self.scan.proven(cx.at);
            self.scanned(over, cx);
            let unknown = self.selected == Selected::Unknown;
            if unknown || self.selected == Selected::Nobody {
                self.selected = Selected::Unknown;
                let asked = self.exchanges.give_up(Exchange::Selective);
                if let Some(asked) = asked.filter(|asked| unknown && !asked.answered) {
                    // There is one that does what selected slaves do: it was selected, and did not answer.
                    self.silent(Exchange::Selective, asked, cx);
                }
            }
        }
        match command {
            Command::SwitchSelectiveResponse => {
                let [vendor, product, revision, serial] = self.address;
                let whole = || Some([vendor?, product?, revision?, serial?]);
                let address = whole();
                let before = address.and_then(|address| holder(nodes, address)).map_or(Before::Unknown, Before::Node);
                self.joined(address, before);
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
                self.slave.before = match node {
                    UNCONFIGURED => Before::Unconfigured,
                    1..=127 => Before::Node(node),
                    _ => Before::Unknown,
                };
            }
            _ => {}
        }
    }

    fn accepted(&mut self, of: Setting, at: FrameRef) {
        match of {
            Setting::NodeId => {
                let alone = matches!(self.selected, Selected::Slaves(1) | Selected::All | Selected::Unknown);
                let before = if alone { self.slave.before } else { Before::Unknown };
                if let Some(node) = self.wanted {
                    self.node_ids.given(node, before, self.slave.selection, at);
                }
            }
            Setting::BitTiming => self.timing = Some(Timing { at, rate: self.rate, stored: false, until_ns: None }),
            Setting::Store => {
                self.node_ids.stored(self.slave.selection);
                if let Some(timing) = &mut self.timing {
                    timing.stored = true;
                }
            }
        }
    }

    /// One more slave is in the configuration state, unless it is the same one again.
    fn joined(&mut self, address: Option<[u32; 4]>, before: Before) {
        if address.is_some() && address == self.slave.address && matches!(self.selected, Selected::Slaves(_)) {
            return;
        }
        self.selected = match self.selected {
            Selected::Nobody | Selected::Unknown => Selected::Slaves(1),
            Selected::Slaves(count) => Selected::Slaves(count.saturating_add(1)),
            Selected::All => Selected::All,
        };
        self.select(address, before);
    }

    fn select(&mut self, address: Option<[u32; 4]>, before: Before) {
        self.slave = Slave { selection: self.slave.selection.saturating_add(1), address, before };
    }

    fn scanned(&mut self, over: Option<Over>, cx: &mut Context<'_>) {
        let Some((first, scanned)) = over else { return };
        cx.push(Some(first), None, What::Note(Note::Fastscan(scanned)));
        if scanned.found {
            self.joined(None, Before::Unconfigured);
        }
    }

    /// A node was reset or has booted up: it is in the waiting state, and whether others are not is not known.
    fn restarted(&mut self, cx: &mut Context<'_>) {
        while let Some((exchange, asked)) = self.last.and_then(|last| self.exchanges.overtaken(last, cx.at)) {
            self.silent(exchange, asked, cx);
        }
        if self.selected != Selected::Nobody {
            self.selected = Selected::Unknown;
        }
        self.timing = None;
        self.exchanges.forgive();
    }

    /// A frame that cannot be read stands for the request, or the answer, that it should have been: with a wrong bit
    /// in its identifier, for one of the other side.
    fn unreadable(&mut self, request: bool, at: FrameRef) {
        if request {
            self.odd_request = Some(at);
        }
        self.due_part = None;
        self.exchanges.excuse();
        if self.selected == Selected::Nobody {
            self.selected = Selected::Unknown;
        }
    }

    /// Answers that no request explains: those of one kind together lack the same one.
    fn all_unexplained(&mut self, mut early: Vec<Early>, cx: &mut Context<'_>) {
        early.dedup_by_key(|early| early.exchange);
        for early in early {
            self.unexplained(early, cx);
        }
    }

    /// An answer that no request explains.
    fn unexplained(&mut self, early: Early, cx: &mut Context<'_>) {
        if self.odd_request.take().is_some_and(|request| request.no < early.at.no) {
            return;
        }
        let cause = (early.at.no != cx.at.no).then_some(early.at);
        let command = early.exchange.answer();
        if !self.exchanges.is_recent(early.exchange, early.at) {
            self.selected = Selected::Unknown;
            // It stands for the answer that is owed, or its request for the one that is.
            self.exchanges.excuse();
            self.findings.raise(Lss002::Unrequested { command }, None, cause, cx);
            return;
        }
        if early.exchange == Exchange::InquireNodeId {
            self.slave.before = Before::Unknown;
        }
        let what = match early.exchange {
            Exchange::Selective => Lss007::SameAddress { command },
            _ => Lss007::InConfiguration { command },
        };
        self.findings.raise(what, None, cause, cx);
    }

    /// A request that nobody has answered.
    fn unanswered(&mut self, exchange: Exchange, asked: Asked, cx: &mut Context<'_>) {
        let cause = (asked.at.no != cx.at.no).then_some(asked.at);
        if exchange == Exchange::Selective {
            let [Some(vendor), Some(product), Some(revision), Some(serial)] = self.address else {
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

    /// A selected slave has not answered before the master went on.
    fn silent(&mut self, exchange: Exchange, asked: Asked, cx: &mut Context<'_>) {
        self.findings.raise(Lss009::NoResponse { command: exchange.specifier() }, None, Some(asked.at), cx);
    }

    fn schedule(&mut self) {
        let scan = self.scan.last().and_then(|last| last.t_ns).map(|last| last.saturating_add(PATIENCE_NS));
        let timing = self.timing.as_ref().and_then(|timing| timing.until_ns);
        let silence = self.silence.as_ref().map(|silence| silence.from_ns);
        let due = [self.exchanges.due(), self.node_ids.due(), scan, timing, silence];
        self.due_ns = due.into_iter().flatten().min().unwrap_or(i64::MAX);
    }
}

/// The node that holds an LSS address by its identity object, where exactly one is known to.
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
