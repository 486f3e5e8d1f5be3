//! Checks that need more than one frame or more than one service: states, times, and verdicts on them.
//!
//! Each file is a check, or a family of checks that shares its state and raises findings. [`Checks`] owns them all and
//! passes on every frame from the bus with its meaning. Each of its methods is an input and lists the checks that take
//! it, in their order; no check asks for a message elsewhere. Checks never change a node's configuration.

use crate::bytes::ns::Ns;

pub mod description;
pub mod drive;
pub mod emcy;
pub mod error_frames;
pub mod foreign;
pub mod guarding;
pub mod heartbeat;
pub mod limits;
pub mod lss;
pub mod nmt;
pub mod nodes;
pub mod one_sided;
pub mod pdo;
pub mod srdo;
pub mod sync;
pub mod time;

#[cfg(test)]
pub(crate) mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bytes::frame::{CanId, Frame};
use crate::rules::pdo::Mpd001;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::{Mux, Side};
use crate::wire::error_control::OPERATIONAL;
use crate::wire::lss::Command;
use crate::wire::message::Message;
use crate::wire::nmt::START;
use crate::wire::pdo::communication_parameter;
use crate::world::configuration::{self, Provenance};
use crate::world::context::Context;
use crate::world::event::{Signals, Unmapped};
use crate::world::network::Network;
use crate::world::node::{Node, Pdo, PerNode};

use description::Descriptions;
use drive::Drives;
use error_frames::ErrorFrames;
use lss::Lss;
use nodes::Nodes;
use pdo::assumed::Assumed;
use pdo::configuration::{self as pdo_configuration, PdoConfiguration};
use pdo::identifier::PdoIdentifiers;
use pdo::length::{Misfit, PdoLength, misfit};
use pdo::timing::PdoTiming;
use srdo::{SrdoResult, Srdos};
use sync::Sync;

/// The identity of a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PdoName {
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, from 1.
    pub number: u16,
    /// The node whose PDO it is.
    pub node: u8,
}

/// Changes in the configurations of a bus's nodes.
#[derive(Debug, Default)]
pub struct Renewed {
    /// PDOs built anew.
    pub pdos: Vec<PdoName>,
    /// Other changed objects, with their nodes.
    pub objects: Vec<(u8, u16)>,
}

impl Renewed {
    /// Adds a node's changes since the last call.
    pub fn add(&mut self, id: u8, node: &mut Node) {
        let pdos = node.renewed().into_iter();
        self.pdos.extend(pdos.map(|(transmit, number)| PdoName { transmit, number, node: id }));
        self.objects.extend(node.configuration.untold().into_iter().map(|index| (id, index)));
    }
}

impl PdoName {
    fn of(self, nodes: &PerNode<Node>) -> Option<&Pdo> {
        nodes.get(self.node)?.pdo(self.transmit, self.number)
    }
}

/// The relation of a PDO frame's bytes to its mapping.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// The deviation of their number from the mapping.
    misfit: Option<Misfit>,
    /// The PDO has its own mapping, and their number agrees with it.
    fits: bool,
    /// A mapping is known, or known to be absent.
    read: bool,
    /// Frames contradict the assumed mapping.
    contradicted: bool,
}

impl Fit {
    /// Returns true if the frame has the length of the PDO's own mapping.
    pub fn is_by_own_mapping(&self) -> bool {
        self.fits
    }

    /// Compares a frame with its content.
    #[inline]
    fn of(content: &Signals, frame: &Frame) -> Self {
        let misfit = misfit(content, frame);
        Self {
            misfit,
            fits: misfit.is_none() && matches!(content, Signals::Mapped(_, from) if !from.is_unconfirmed()),
            read: match content {
                Signals::None(Unmapped::Unknown | Unmapped::Unconfirmed) => false,
                Signals::Mapped(_, from) | Signals::ByConsumer(_, from, ..) => !from.is_doubted(),
                Signals::None(_) => true,
            },
            contradicted: false,
        }
    }
}

/// Returns true if the capture shows the communication parameter of a TPDO, after the frame `since`: the last restart of
/// its node.
fn is_configured(pdo: &Pdo, since: u64) -> bool {
    let shown = |from: Provenance| matches!(from, Provenance::Observed(frame) if frame > since);
    let holds = |from: Provenance| from <= Provenance::Eds || shown(from);
    let kind = pdo.transmission.is_some_and(|(_, from)| shown(from));
    kind && holds(pdo.cob.1) && pdo.event_timer.is_none_or(|(_, from)| holds(from))
}

/// All checks of one bus.
#[derive(Debug)]
pub struct Checks {
    network: Arc<Network>,
    /// States, heartbeats, guarding and emergencies of nodes.
    pub nodes: Nodes,
    /// SYNC and synchronous PDOs.
    pub sync: Sync,
    descriptions: Descriptions,
    assumed: Assumed,
    pdo_configuration: PdoConfiguration,
    pdo_identifiers: PdoIdentifiers,
    pdo_length: PdoLength,
    pdo_timing: PdoTiming,
    lss: Lss,
    /// States and commands of drives.
    pub drives: Drives,
    srdos: Srdos,
    /// Error frames.
    pub error_frames: ErrorFrames,
}

impl Checks {
    /// Creates the checks of a bus.
    pub fn new(network: &Arc<Network>, nodes: &PerNode<Node>, renewed: &Renewed) -> Self {
        let mut checks = Self {
            network: Arc::clone(network),
            nodes: Nodes::new(network),
            sync: Sync::new(network, nodes),
            descriptions: Descriptions::default(),
            assumed: Assumed::default(),
            pdo_configuration: PdoConfiguration::default(),
            pdo_identifiers: PdoIdentifiers::default(),
            pdo_length: PdoLength::default(),
            pdo_timing: PdoTiming::default(),
            lss: Lss::default(),
            drives: Drives::default(),
            srdos: Srdos::default(),
            error_frames: ErrorFrames::default(),
        };
        checks.renewed(renewed);
        checks.nodes.configure(nodes);
        checks
    }

    /// Reports what became due before a frame; called after the frame's own event.
    pub fn due(&mut self, frame: &Frame, cx: &mut Context<'_>) {
        cx.release();
        self.error_frames.advance(frame.t_ns, frame.no, cx);
        self.nodes.settle(cx);
        if let Some(now_ns) = frame.t_ns {
            self.pass(now_ns, true, cx);
            let nodes = &self.nodes;
            self.pdo_timing.advance(now_ns, |node| nodes.heard_last(node), cx);
            self.srdos.advance(now_ns, cx);
            self.sync.heard(now_ns);
        }
        self.nodes.heard(cx);
        if self.nodes.paused() {
            self.srdos.paused(cx);
        }
    }

    /// Reports what should have happened by `now_ns`, at the current frame.
    pub fn advance(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        self.error_frames.advance(Some(now_ns), cx.at.no, cx);
        self.pass(now_ns, false, cx);
    }

    /// Does the same; `heard`: the time comes from a frame, not from the clock alone.
    fn pass(&mut self, now_ns: Ns, heard: bool, cx: &mut Context<'_>) {
        self.nodes.advance(now_ns, heard, cx);
        self.lss.advance(now_ns, cx);
        let states = &self.nodes;
        self.drives.advance(now_ns, |node| states.operational(node), cx);
    }

    /// Takes an SDO write request with its data, which the server may obey before it answers.
    pub fn requested(&mut self, node: u8, mux: Mux, bytes: &[u8], cx: &Context<'_>) {
        self.nodes.requested(node, mux.index, bytes, cx);
        self.drives.request(node, mux, bytes, cx.at);
    }

    /// Takes the end of an SDO transfer, successful or not.
    pub fn ended(&mut self, transfer: &Transfer, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let node = transfer.node;
        if let (Direction::Download, Status::Failed | Status::Incomplete, Some(mux)) =
            (transfer.direction, transfer.outcome.status, transfer.mux)
        {
            self.pdo_configuration.doubt(node, mux, cx.at.no);
        }
        self.descriptions.refused(nodes.get(node), transfer, cx);
        self.drives.transfer(transfer, nodes.get(node), self.nodes.state(node), cx);
    }

    /// Takes a frame of an SRDO, before its own event.
    pub fn safety(
        &mut self,
        number: u8,
        inverted: bool,
        frame: &Frame,
        nodes: &PerNode<Node>,
        cx: &Context<'_>,
    ) -> SrdoResult {
        let states = &self.nodes;
        self.srdos.follow(number, inverted, frame, nodes, cx, |node| states.state(node))
    }

    /// Judges the same frame after its own event.
    pub fn shown(&self, seen: &SrdoResult, cx: &mut Context<'_>) {
        self.srdos.judge(seen, cx);
    }

    /// Takes an SDO frame of a default channel, by which side, true if it is an abort, and its object.
    pub fn sdo(&mut self, side: (Side, bool), node: u8, object: Option<Mux>, cx: &mut Context<'_>) {
        self.nodes.sdo(side, node, object.map(|mux| mux.index), cx);
        self.pdo_length.asked(node);
        if let Some((_, transmit, number)) = object.and_then(|mux| pdo_configuration::pdo_parameter(mux.index)) {
            self.pdo_length.reconfigured(node, transmit, number);
        }
    }

    /// Returns the content of a PDO's frame and its relation to the mapping. An assumed mapping holds until frames
    /// contradict it.
    #[inline]
    pub fn content(&mut self, name: PdoName, content: &mut Signals, frame: &Frame) -> Fit {
        let mut fit = Fit::of(content, frame);
        if fit.misfit.is_some() && self.assumed.contradicts(name, content, frame) {
            (fit.read, fit.contradicted) = (false, true);
            // Of a device without a description nothing is known then.
            let of_profile = matches!(content, Signals::Mapped(_, from) | Signals::ByConsumer(_, from, ..) if *from == Provenance::Profile);
            let why = if of_profile { Unmapped::Unknown } else { Unmapped::Contradicted };
            *content = Signals::None(why);
        }
        fit
    }

    /// Judges a TPDO that has the length of its mapping by the mapping of a node that receives it.
    #[inline]
    pub fn consumed(
        &mut self,
        name: PdoName,
        content: &Signals,
        nodes: &PerNode<Node>,
        frame: &Frame,
        cx: &mut Context<'_>,
    ) {
        let PdoName { transmit, number, node } = name;
        if let Some(misfit) = misfit(content, frame).filter(Misfit::is_short) {
            self.pdo_length.judge(transmit, number, node, nodes.get(node), &misfit, cx);
        }
    }

    /// Takes a PDO with data; `known` is its configuration.
    #[inline]
    pub fn process_data(
        &mut self,
        name: PdoName,
        known: Option<&Pdo>,
        fit: &Fit,
        nodes: &PerNode<Node>,
        frame: &Frame,
        cx: &mut Context<'_>,
    ) {
        let PdoName { transmit, number, node } = name;
        self.nodes.pdo(transmit, number, node, cx);
        self.pdo_identifiers.used(frame.id, nodes, cx);
        self.sync.process_data(name, known, cx);
        let used = known.is_none_or(|pdo| pdo.cob.0.valid || pdo.cob.1 <= Provenance::Eds);
        if let Some(misfit) = &fit.misfit
            && used
        {
            self.pdo_length.judge(transmit, number, node, nodes.get(node), misfit, cx);
        } else if fit.fits {
            self.pdo_length.fitted(transmit, number, node);
        } else if !fit.read && !fit.contradicted && self.nodes.state(node).is_some() {
            // The frames of a node not seen otherwise may belong to another protocol.
            self.pdo_length.unmapped((transmit, number, node), frame, cx);
        }
        let states = &self.nodes;
        self.drives.process_data(name, (fit.read, fit.contradicted), frame, nodes, |node| states.state(node), cx);
        match known {
            Some(pdo) => self.pdo_configuration.used(node, pdo, frame, cx),
            None => self.pdo_configuration.sent(node, transmit, number, frame.id),
        }
        self.pdo_timing.sent(name, known, Some(frame.head()), cx);
    }

    /// Takes a multiplex PDO.
    pub fn multiplexed(
        &mut self,
        name: PdoName,
        message: &Message,
        nodes: &PerNode<Node>,
        frame: &Frame,
        cx: &mut Context<'_>,
    ) {
        let PdoName { transmit, number, node } = name;
        self.nodes.pdo(transmit, number, node, cx);
        self.drives.blind(node, cx);
        if matches!(message, Message::Malformed { .. }) {
            let object = Mux { index: communication_parameter(transmit, number), sub: 0 };
            cx.raise(Mpd001::Length { found: frame.len.into() }, Some(node), Some(object), None);
        }
        self.pdo_timing.sent(name, name.of(nodes), None, cx);
    }

    /// Takes a message of another service before its resets are applied; returns the old and the new node-ID of a node
    /// that LSS has renamed.
    pub fn message(
        &mut self,
        message: &Message,
        nodes: &PerNode<Node>,
        frame: &Frame,
        cx: &mut Context<'_>,
    ) -> Option<(u8, u8)> {
        self.sync.message(message, frame, nodes, cx);
        match *message {
            Message::ErrorFrame => self.error_frames.follow(frame, cx),
            Message::Nmt { command, node } => {
                self.srdos.interrupt(cx.at.no, false);
                if command != START {
                    self.srdos.halted((1..=127).contains(&node).then_some(node));
                }
                if node <= 127 {
                    self.pdo_timing.commanded((node != 0).then_some(node), command);
                }
            }
            Message::BootUp { node } => {
                self.srdos.not_operational(node, cx);
                self.pdo_timing.state(node, 0, cx);
            }
            Message::Heartbeat { node, state, .. } => {
                if state != OPERATIONAL {
                    self.srdos.not_operational(node, cx);
                }
                self.pdo_timing.state(node, state, cx);
            }
            Message::Sync { .. } => self.pdo_timing.synced(cx),
            Message::PdoRequest { transmit: true, number, node } => {
                if let Some(pdo) = nodes.get(node).and_then(|node| node.pdo(true, number)) {
                    self.pdo_configuration.requested(node, pdo, frame, cx);
                    self.pdo_timing.requested(node, number);
                }
            }
            Message::Lss { command: Command::ActivateBitTiming { delay }, .. } => {
                self.error_frames.switch(delay, cx);
                self.pdo_timing.forget(None);
                self.srdos.halted(None);
                self.sync.lost();
            }
            _ => {}
        }
        self.lss.follow(message, frame, nodes, cx)
    }

    /// Takes the same message after its resets.
    pub fn follow(&mut self, message: &Message, nodes: &PerNode<Node>, frame: &Frame, cx: &mut Context<'_>) {
        self.nodes.follow(message, frame, nodes, cx);
        match *message {
            Message::BootUp { node } => self.drives.booted(node),
            Message::Emcy { node, code, .. } => self.drives.emcy(node, code, cx),
            _ => {}
        }
    }

    /// Takes a server's acknowledgement of a write, with or without its request in the capture.
    pub fn acknowledged(&mut self, node: u8, mux: Mux, frame: &Frame, cx: &Context<'_>) {
        self.pdo_configuration.acknowledged(node, mux, frame);
        self.nodes.acknowledged(node, mux.index, cx);
    }

    /// Takes a successful transfer before its value is learnt.
    pub fn transferred(&mut self, transfer: &Transfer, mux: Mux, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let node = nodes.get(transfer.node);
        self.descriptions.expected(nodes, transfer, mux, cx);
        self.descriptions.judge(node, transfer, mux, cx);
        if transfer.shows_no_error() {
            self.nodes.has_no_error(transfer.node);
        }
        if transfer.direction == Direction::Download
            && let Some(value) = configuration::number(&transfer.data.kept)
        {
            let state = self.nodes.state(transfer.node);
            self.pdo_configuration.written((node, state), transfer, mux, value, cx);
            if let Some((mapping, transmit, number)) = pdo_configuration::pdo_parameter(mux.index) {
                if transmit && !mapping && mux.sub == 1 {
                    self.pdo_identifiers.written(transfer.node, number, transfer.first);
                }
                self.pdo_timing.reconfigured(transfer.node, transmit, number);
            }
        }
    }

    /// Takes a changed value of an object that decoding depends on.
    pub fn learnt(&mut self, node: u8, mux: Mux, nodes: &PerNode<Node>, cx: &Context<'_>) {
        if matches!(mux.index, 0x100C | 0x100D | 0x1016 | 0x1017) {
            self.nodes.configure(nodes);
        }
        self.sync.configured(node, mux, &self.network, nodes, cx.at);
    }

    /// Takes changed or removed objects.
    pub fn renewed(&mut self, renewed: &Renewed) {
        self.drives.renewed(&renewed.pdos);
        self.pdo_identifiers.renewed(&renewed.pdos);
        for &(node, index) in &renewed.objects {
            match index {
                0x1016 => self.nodes.watches_others(node),
                0x1301..=0x1340 => self.srdos.renewed(node, index),
                _ => {}
            }
        }
    }

    /// Takes a change of many objects.
    pub fn reconfigured(&mut self, nodes: &PerNode<Node>) {
        self.nodes.configure(nodes);
        self.sync.reconfigure(&self.network, nodes);
    }

    /// Takes a reset of one node, or of all.
    pub fn reset(&mut self, node: Option<u8>, cx: &mut Context<'_>) {
        self.pdo_configuration.reset(node);
        self.pdo_length.reset(node, cx);
        self.pdo_timing.forget(node);
        self.drives.forget(node);
        self.srdos.interrupt(cx.at.no, false);
        self.srdos.halted(node);
    }

    /// Drops everything that was open after lost frames.
    pub fn lost(&mut self, cx: &mut Context<'_>) {
        self.nodes.lost(cx);
        self.pdo_timing.forget(None);
        self.drives.forget(None);
        self.srdos.interrupt(cx.at.no, true);
        self.pdo_length.lost(cx);
        self.pdo_configuration.lost();
        self.sync.lost();
        self.lss.lost();
    }

    /// Reports foreign traffic at the end of the capture. `sdo`: for each channel whether it is SDO, if known, and its
    /// frame count.
    pub fn conclude(&self, sdo: impl Iterator<Item = (Option<bool>, u64)>, cx: &mut Context<'_>) {
        let (frames, is_lss) = self.lss.shown();
        foreign::conclude(sdo, if is_lss { 0 } else { frames }, frames > 0 && is_lss, cx);
    }

    /// Reports what is open at the end of the capture.
    pub fn finish(&mut self, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        self.error_frames.finish(cx);
        self.nodes.finish(cx);
        let mut taken = BTreeMap::<CanId, u32>::new();
        let pdos = nodes.iter().flat_map(|(_, node)| node.pdos());
        pdos.filter(|pdo| pdo.transmit && pdo.cob.0.valid).for_each(|pdo| *taken.entry(pdo.cob.0.id).or_default() += 1);
        // Frames of a CAN-ID that others have, too, may be theirs.
        let own = |id: CanId| !pdo_configuration::restricted(id) && taken.get(&id).is_none_or(|count| *count == 1);
        let restarted: BTreeMap<u8, u64> = nodes
            .iter()
            .filter_map(|(id, _)| {
                let both = [self.nodes.booted(id), self.pdo_timing.fallen(id)];
                Some((id, both.into_iter().flatten().map(|at| at.no).max()?))
            })
            .collect();
        let since = |node: u8| restarted.get(&node).copied().unwrap_or(0);
        let configured = |node: u8, pdo: &Pdo| own(pdo.cob.0.id) && is_configured(pdo, since(node));
        let unproduced = self.sync.finish(nodes, configured, cx);
        self.pdo_timing.finish(nodes, configured, unproduced, cx);
        self.srdos.finish(cx);
        self.lss.finish(cx);
    }
}
