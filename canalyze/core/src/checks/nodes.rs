//! The checks of nodes, and their order for a frame: states, heartbeats, guarding, emergencies, TIME, permissions.
//!
//! A message is completed with earlier knowledge and passed on; verdicts are left to the checks.

use super::emcy::Emergencies;
use super::guarding::Guarding;
use super::heartbeat::Heartbeats;
use super::nmt::permissions::NmtPermissions;
use super::nmt::{Nmt, OBEYED_NS, SWITCHED_ON_NS};
use super::time::Times;
use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::emcy::{Emc006, Emc011};
use crate::rules::finding::{Finding, Verdict};
use crate::rules::heartbeat::Hbt006;
use crate::rules::time::Tim001;
use crate::sdo::wire::Side;
use crate::wire::cob_id::Role;
use crate::wire::error_control::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::lss::Command as Lss;
use crate::wire::message::{Flaw, Message};
use crate::wire::nmt::{commanded_state, is_reset};
use crate::words::profiles::Profile;
use crate::world::context::Context;
use crate::world::network::Network;
use crate::world::node::{Node, PerNode};

/// Silence of the bus that was not recorded, in ns.
const UNRECORDED_NS: Ns = Ns::from_s(10);
/// Maximum number of kept frames of wrong length.
const MISSHAPEN: usize = 16;
/// Objects that only an NMT master has: what it does itself, and its slaves (CiA 302-2).
const OF_MASTERS: std::ops::RangeInclusive<u16> = 0x1F80..=0x1F8A;

/// A node's method of error control (CiA 301, 7.2.8.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorControl {
    /// Heartbeats.
    Heartbeat,
    /// Answers to the master.
    Guarding,
}

impl ErrorControl {
    /// Returns the word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Heartbeat => "heartbeat",
            Self::Guarding => "guarding",
        }
    }
}

/// The checks of a bus's nodes.
#[derive(Debug)]
pub struct Nodes {
    nmt: Nmt,
    heartbeats: Heartbeats,
    guarding: Guarding,
    emergencies: Emergencies,
    times: Times,
    permissions: NmtPermissions,
    /// Duration of the bus's silence before the current frame, in ns.
    silence_ns: Ns,
    /// End of the silence for a switch of the bit rate (CiA 305), in ns; a heartbeat in it begins no series.
    quiet_until_ns: Ns,
    /// Findings about frames of an unusual form of nodes not yet known to exist.
    misshapen: Vec<Finding>,
    /// Nodes with an emergency that is not judged, one bit each.
    unread: u128,
}

impl Nodes {
    /// Creates the checks of a bus.
    pub fn new(network: &Network) -> Self {
        Self {
            nmt: Nmt::default(),
            heartbeats: Heartbeats::default(),
            guarding: Guarding::default(),
            emergencies: Emergencies::new(network.jitter_ns),
            times: Times::default(),
            permissions: NmtPermissions::default(),
            silence_ns: Ns::ZERO,
            quiet_until_ns: Ns::MIN,
            misshapen: Vec::new(),
            unread: 0,
        }
    }

    /// Returns the NMT state of a node if known: 04, 05, 7F.
    #[inline]
    pub fn state(&self, node: u8) -> Option<u8> {
        self.nmt.state(node)
    }

    /// Returns the last frame of a node, as far as it is known by that to be there.
    pub fn heard_last(&self, node: u8) -> Option<FrameRef> {
        self.nmt.heard(node)
    }

    /// Returns the last frame in which a node has reported its state, if that is Operational.
    pub fn operational(&self, node: u8) -> Option<FrameRef> {
        self.nmt.last_report(node).filter(|_| self.nmt.shown_last(node) == Some(OPERATIONAL))
    }

    /// Clears the errors of a node whose error register is read as 0.
    pub fn has_no_error(&mut self, node: u8) {
        self.emergencies.has_none(node);
    }

    /// Returns the last boot-up of a node.
    pub fn booted(&self, node: u8) -> Option<FrameRef> {
        self.nmt.booted(node)
    }

    /// Returns the last boot-up of a node if it is the second one for no reason.
    pub fn booted_twice(&self, node: u8) -> Option<FrameRef> {
        self.nmt.booted_twice(node)
    }

    /// Returns the last state reported by a node since its boot-up.
    #[inline]
    pub fn reported(&self, node: u8) -> Option<u8> {
        self.nmt.shown_last(node)
    }

    /// Returns the heartbeat period of a node if known, in ns.
    pub fn heartbeat_period(&self, node: u8) -> Option<Ns> {
        self.heartbeats.period(node)
    }

    /// Returns true if nothing but its supply explains the last boot-up of a node, which reported states before.
    pub fn booted_unasked(&self, node: u8) -> bool {
        self.nmt.booted_unasked(node)
    }

    /// Returns the kind of error control by which a node is overdue at `now_ns`.
    pub fn silent(&self, node: u8, now_ns: Option<Ns>) -> Option<ErrorControl> {
        if self.guarding.is_unanswered(node) {
            Some(ErrorControl::Guarding)
        } else if now_ns.is_some_and(|now| self.heartbeats.is_overdue(node, now)) {
            Some(ErrorControl::Heartbeat)
        } else {
            None
        }
    }

    /// Marks a change of a node's consumer heartbeat times (1016h).
    pub fn watches_others(&mut self, node: u8) {
        self.heartbeats.watches_others(node);
    }

    /// Updates the times of heartbeats and guarding after a change.
    pub fn configure(&mut self, nodes: &PerNode<Node>) {
        self.heartbeats.configure(nodes);
        self.guarding.configure(nodes);
    }

    /// Returns a message completed with knowledge from earlier frames.
    pub fn complete(&mut self, message: Message, nodes: &PerNode<Node>, cx: &Context<'_>) -> Message {
        match message {
            Message::Heartbeat { node, state, toggle, .. } => Message::Heartbeat {
                node,
                state,
                toggle,
                guarding: self.guarding.is_answer(node, toggle, &self.heartbeats, cx),
                previous: self.nmt.shown_last(node),
            },
            Message::Emcy { node, code, register, manufacturer, .. } => {
                let [bit, ..] = manufacturer;
                let profile = nodes.get(node).map_or(Profile::UNKNOWN, Node::profile);
                let (active, cleared) = self.emergencies.follow(node, (code, profile), register, bit, cx.at);
                Message::Emcy { node, code, profile, register, manufacturer, active, cleared }
            }
            other => other,
        }
    }

    /// Reports unexplained events; called for each frame before it is followed.
    #[inline]
    pub fn settle(&mut self, cx: &mut Context<'_>) {
        if !self.misshapen.is_empty() {
            self.release_misshapen(cx);
        }
        self.nmt.settle(cx);
    }

    /// Notes that the bus is alive; called for each frame before it is followed and after `advance`.
    #[inline]
    pub fn heard(&mut self, cx: &Context<'_>) {
        let ended = |now: Ns| cx.evidence.recording.ended_silence(now);
        self.silence_ns = cx.at.t_ns.and_then(ended).map_or(Ns::ZERO, |silence| silence.ns());
        if self.paused() {
            self.times.paused();
        }
    }

    /// Reports what should have happened by `now_ns`. `heard`: the time comes from a frame, not the clock alone.
    #[inline]
    pub fn advance(&mut self, now_ns: Ns, heard: bool, cx: &mut Context<'_>) {
        self.heartbeats.advance(now_ns, heard, cx);
        self.guarding.advance(now_ns, &self.nmt, &self.heartbeats, cx);
    }

    /// Takes a frame of a service other than SDO and PDO.
    pub fn follow(&mut self, message: &Message, frame: &Frame, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        match *message {
            Message::Nmt { command, node } => {
                if is_reset(command) && node <= 127 {
                    self.heartbeats.reset(node, cx);
                    self.guarding.restart(node, &self.nmt, cx);
                }
                self.nmt.command(command, node, cx);
                if node > 127 {
                    return;
                }
                self.permissions.command(&self.nmt, node, commanded_state(command).unwrap_or(0), cx);
                self.heartbeats.commanded(node);
            }
            Message::Malformed { role: Role::Nmt, flaw: Flaw::Length { .. } } => self.nmt.malformed(frame.len, cx),
            Message::Malformed { role, flaw: Flaw::Length { .. } } => self.wrong_length(role, frame, cx),
            Message::BootUp { node } => {
                self.permissions.boot_up(node, cx);
                self.guarding.restart(node, &self.nmt, cx);
                self.nmt.boot_up(node, self.silence_ns, cx);
                if self.silence_ns >= SWITCHED_ON_NS {
                    self.heartbeats.power_up(cx);
                }
                self.heartbeats.booted(node, cx);
                self.emergencies.boot_up(node, cx);
            }
            Message::Heartbeat { node, state, toggle, guarding, .. } => {
                self.error_control(node, state, toggle, guarding, cx);
            }
            Message::GuardingRequest { node } => self.guarding.request(node, &self.nmt, &self.heartbeats, cx),
            Message::Emcy { node, code, register, .. } => {
                self.permissions.emergency(&self.nmt, node, cx);
                self.nmt.emergency(node, code, cx.at);
                self.emergencies.judge((code, register), node, nodes.get(node), cx);
            }
            Message::EmcyFd { node, .. } if self.unread >> node & 1 == 0 => {
                self.unread |= 1 << node;
                self.misshapen(Emc011::First.into(), Some(node), cx);
            }
            Message::Time { ms, days, reserved } => self.times.judge(ms, days, reserved, cx),
            Message::Lss { from_master: true, command } => {
                self.nmt.lss(command, cx.at);
                if let Lss::ActivateBitTiming { delay } = command {
                    self.heartbeats.pause(0, cx);
                    let silence = Ns::from_ms(2 * i64::from(delay));
                    self.quiet_until_ns = frame.t_ns.map_or(Ns::MIN, |now| now + silence);
                }
            }
            _ => {}
        }
    }

    /// Reports a frame of a wrong length.
    fn wrong_length(&mut self, role: Role, frame: &Frame, cx: &mut Context<'_>) {
        let found = frame.len.into();
        let (what, node): (Verdict, _) = match role {
            Role::Emcy(node) => (Emc006::Length { found }.into(), Some(node)),
            Role::ErrorControl(node) => (Hbt006::Length { found }.into(), Some(node)),
            Role::Time => (Tim001::Length { found }.into(), None),
            _ => return,
        };
        let present = self.misshapen(what, node, cx);
        if let Role::ErrorControl(node) = role
            && present
        {
            self.misshapen_error_control(node, frame, cx);
        }
    }

    /// Reports a frame of an unusual form, once the node (for TIME, any node) is known to exist: other networks use
    /// these identifiers for other data. Returns true if it does.
    fn misshapen(&mut self, what: Verdict, node: Option<u8>, cx: &mut Context<'_>) -> bool {
        let finding = cx.verdict(what, node, None, None);
        let present = self.is_present(node);
        if present {
            cx.report(finding);
        } else if self.misshapen.len() < MISSHAPEN {
            self.misshapen.push(finding);
        }
        present
    }

    /// Takes an error control frame not one byte long: it still shows that the node is present, and its state if it has
    /// a first byte. That is no second fault.
    fn misshapen_error_control(&mut self, node: u8, frame: &Frame, cx: &mut Context<'_>) {
        match frame.payload().first() {
            Some(0) => {
                self.permissions.boot_up(node, cx);
                self.nmt.boot_up(node, self.silence_ns, cx);
                self.heartbeats.booted(node, cx);
            }
            Some(byte) if matches!(byte & 0x7F, STOPPED | OPERATIONAL | PRE_OPERATIONAL) => {
                let toggle = byte & 0x80 != 0;
                let answer = self.guarding.is_answer(node, toggle, &self.heartbeats, cx);
                self.error_control(node, byte & 0x7F, toggle, answer, cx);
            }
            _ => {
                self.nmt.unreadable(node);
                self.guarding.excuse(node);
                self.heartbeats.alive(node, cx);
            }
        }
    }

    /// Returns true if a node, or any, is known to exist.
    fn is_present(&self, node: Option<u8>) -> bool {
        let present = |node: u8| self.nmt.is_present(node);
        node.map_or_else(|| (1..=127).any(present), present)
    }

    /// Reports kept frames of an unusual form whose nodes are now known to exist.
    fn release_misshapen(&mut self, cx: &mut Context<'_>) {
        let (shown, waiting) =
            std::mem::take(&mut self.misshapen).into_iter().partition(|finding| self.is_present(finding.node));
        self.misshapen = waiting;
        shown.into_iter().for_each(|finding: Finding| cx.report(finding));
    }

    fn error_control(&mut self, node: u8, state: u8, toggle: bool, guarding: bool, cx: &mut Context<'_>) {
        if toggle && !self.guarding.toggles(node) {
            let producer = self.heartbeats.is_producer(node) || self.heartbeats.is_configured(node);
            if producer && !self.guarding.is_guarded(node, cx.at) {
                self.nmt.unreadable(node);
                return self.heartbeats.bit_7(state | 0x80, node, cx);
            }
            if !matches!(state, STOPPED | OPERATIONAL | PRE_OPERATIONAL) {
                // It is no guarding answer either.
                self.nmt.unreadable(node);
                self.heartbeats.known_state(node, state, cx);
                return self.heartbeats.alive(node, cx);
            }
            self.heartbeats.pause(node, cx);
        }
        self.guarding.frame(node, (state, toggle), guarding, cx);
        let period = self.heartbeats.period(node);
        let gap = cx.at.since(self.nmt.last_report(node));
        let changes = gap.zip(period).is_some_and(|(gap, period)| gap < period - period / 8);
        self.permissions.shown(node, state, changes, cx);
        self.nmt.shown(node, state, period, cx);
        if guarding || self.guarding.toggles(node) {
            self.heartbeats.known_state(node, state, cx);
            self.heartbeats.answers(node);
        } else {
            self.heartbeats.heartbeat(node, state, cx);
            // It may have been on its way when the node was reset.
            let obeying =
                self.nmt.resetting(node).and_then(|reset| cx.at.since(reset)).is_some_and(|age| age < OBEYED_NS);
            if obeying || cx.at.t_ns.is_some_and(|now| now < self.quiet_until_ns) {
                self.heartbeats.pause(node, cx);
            }
        }
    }

    /// Returns true if the bus was silent before the current frame for so long that it was not recorded.
    pub fn paused(&self) -> bool {
        self.silence_ns >= UNRECORDED_NS
    }

    /// Takes a PDO.
    #[inline]
    pub fn pdo(&mut self, transmit: bool, number: u16, node: u8, cx: &mut Context<'_>) {
        self.permissions.pdo(&self.nmt, transmit, number, node, cx);
    }

    /// Returns the last SDO request to a node if it is a fault by itself.
    pub fn asked_in_vain(&self, node: u8) -> Option<FrameRef> {
        self.permissions.asked_in_vain(node)
    }

    /// Takes a write request with its data.
    pub fn requested(&mut self, node: u8, index: u16, bytes: &[u8], cx: &Context<'_>) {
        // A tool reads from a master, too, and writes there which slaves it has.
        if !OF_MASTERS.contains(&index) {
            self.nmt.managed(node);
        }
        if let (0x1017, [low, high, ..]) = (index, bytes) {
            let ms = i64::from(u16::from_le_bytes([*low, *high]));
            self.heartbeats.written(node, Ns::from_ms(ms), cx);
        }
    }

    /// Takes a server's acknowledgement of a write.
    pub fn acknowledged(&mut self, node: u8, index: u16, cx: &Context<'_>) {
        if index == 0x1017 {
            self.heartbeats.acknowledged(node, cx);
        }
    }

    /// Takes a frame of a node's default SDO channel, by which side, true if it is an abort, and the object of its
    /// transfer.
    pub fn sdo(&mut self, (side, aborts): (Side, bool), node: u8, index: Option<u16>, cx: &mut Context<'_>) {
        // The abort of a client asks for nothing.
        if side == Side::Server || !aborts {
            self.permissions.sdo(&self.nmt, side, node, cx);
        }
        match side {
            Side::Client => self.nmt.asked(node),
            Side::Server => self.nmt.present(node, cx.at),
        }
        if index == Some(0x1F51) {
            self.nmt.program_controlled(node);
        }
    }

    /// Expects nodes with heartbeats behind lost frames, which are forgotten next.
    pub fn expect_again(&mut self) {
        self.heartbeats.expect_again();
    }

    /// Forgets what was open after lost frames.
    pub fn lost(&mut self, cx: &mut Context<'_>) {
        self.nmt.forget();
        self.permissions.forget();
        self.heartbeats.forget(cx);
        self.guarding.forget(cx);
    }

    /// Reports what is open at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        self.release_misshapen(cx);
        self.heartbeats.finish(cx);
        self.nmt.finish(cx);
        self.guarding.finish(&self.nmt, cx);
        self.permissions.finish(cx);
        self.emergencies.finish(cx);
    }
}
