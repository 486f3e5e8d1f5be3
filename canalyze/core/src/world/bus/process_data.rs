//! PDOs on their way through the bus: their signals by the mapping in force, their place in the SYNC cycle, and what is checked
//! of them.
//!
//! A multiplex PDO addresses an object of any node. Must not: change a mapping, which is learnt elsewhere.

use std::sync::Arc;

use super::Bus;
use super::drives::reported;
use crate::bytes::frame::Frame;
use crate::checks::PdoName;
use crate::evidence::duplicates::Sighting;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;
use crate::wire::pdo::mapping::Mapping;
use crate::wire::pdo::{self, Multiplexed};
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::dictionary::Object;
use crate::world::event::{Addressed, Event, ProcessData, Signals, Unmapped, What};
use crate::world::node::{Content, Node, Pdo};

impl Bus {
    /// Takes a PDO.
    pub(super) fn process_data(&mut self, name: PdoName, frame: &Frame, cx: &mut Context<'_>) {
        let PdoName { transmit, number, node } = name;
        let known = self.nodes.get(node).and_then(|node| node.pdo(transmit, number));
        let unconfirmed = self.roles.unconfirmed(frame.id);
        let asked = self.nodes.get(node).and_then(|node| node.unconfirmed_pdo(transmit, number));
        let mapping = asked.and_then(|asked| asked.mapping_of(frame.len));
        let content = match (mapping, known.map(|pdo| &pdo.content)) {
            (Some((mapping, from)), _) => Signals::Mapped(Arc::clone(mapping), *from),
            (None, Some(Content::Multiplex { from, .. })) if unconfirmed.is_none() => {
                return self.multiplexed(name, *from, frame, cx);
            }
            (None, Some(Content::Mapped(mapping, from))) => Signals::Mapped(Arc::clone(mapping), *from),
            (None, Some(Content::Disabled(from))) if !from.is_doubted() => Signals::None(Unmapped::Disabled),
            (None, _) => self.by_consumer(frame),
        };
        if let Some(from) = unconfirmed {
            return self.unconfirmed(name, content.by(from), frame, cx);
        }
        let refuted = asked.map(|asked| (asked.cob.is_some(), asked.is_refuted_by(frame.len)));
        let (state, is_off) = (self.checks.nodes.state(node), known.is_some_and(Pdo::is_off));
        let own = cx.events.len();
        cx.push(
            None,
            Some(node),
            What::Pdo(ProcessData { transmit, number, node, content, state, sync: None, is_off }),
        );
        // It is judged where it is, since bytes that were just written are slow to move. The last event is the one above.
        let Some(Event { what: What::Pdo(data), .. }) = cx.events.last_mut() else { return };
        if let Some(place) = self.checks.sync.place(node, known, frame, cx.evidence.recording.lag_ns()) {
            data.sync = Some(place);
        }
        let fit = self.checks.content(name, &mut data.content, frame);
        let consumed = (transmit && fit.is_by_own_mapping()).then(|| self.by_consumer(frame));
        if cx.sighting == Sighting::Duplicate {
            return;
        }
        self.checks.due(frame, cx);
        reported(&mut self.publisher, own, frame, cx);
        self.checks.process_data(name, known, &fit, &self.nodes, frame, cx);
        if let Some(consumed) = consumed {
            self.checks.consumed(name, &consumed, &self.nodes, frame, cx);
        }
        if let Some((cob, mapping)) = refuted {
            self.refute(name, cob, mapping);
        }
    }

    #[inline(never)]
    fn multiplexed(&mut self, name: PdoName, from: Provenance, frame: &Frame, cx: &mut Context<'_>) {
        let PdoName { transmit, number, node } = name;
        let role = if transmit { Role::Tpdo { number, node } } else { Role::Rpdo { number, node } };
        let message = pdo::decode_multiplexed(role, transmit, number, node, frame);
        let what = match message {
            Message::Mpdo { content, .. } => {
                let mapping = self.addressed(transmit.then_some(node), &content);
                What::Mpdo(Box::new(Addressed { transmit, number, node, content, mapping, from }))
            }
            _ => What::Message(message),
        };
        cx.push(None, Some(node), what);
        if cx.sighting == Sighting::Duplicate {
            return;
        }
        self.checks.due(frame, cx);
        self.checks.multiplexed(name, &message, &self.nodes, frame, cx);
    }

    /// Returns the object in a multiplex PDO, by the node that owns it. To all nodes, it is that of the first described
    /// node except the producer, if all that have the object agree.
    fn addressed(&self, producer: Option<u8>, content: &Multiplexed) -> Mapping {
        let Multiplexed { destination, node, index, sub, .. } = *content;
        let unknown = Node::default();
        let owner = if destination && node == 0 {
            let consumers = self.nodes.iter().filter(|(id, _)| Some(*id) != producer);
            let mut having = consumers.filter_map(|(_, one)| Some((one, one.configuration.object(index, sub)?)));
            let first = having.next();
            let mut same = |object: &Object| having.all(|(_, other)| object.is_alike(other));
            first.filter(|(_, object)| same(object)).map(|(one, _)| one)
        } else {
            self.nodes.get(node)
        };
        owner.unwrap_or(&unknown).multiplexed(index, sub)
    }

    /// Returns the signals of a PDO by the mapping of a node that receives it.
    pub(super) fn by_consumer(&self, frame: &Frame) -> Signals {
        let Some((node, number)) = self.roles.consumer(frame.id) else { return Signals::None(Unmapped::Unknown) };
        let consumed = || {
            let consumer = self.nodes.get(node)?;
            let asked = consumer.unconfirmed_pdo(false, number);
            if let Some((mapping, from)) = asked.and_then(|asked| asked.mapping_of(frame.len)) {
                return Some(Signals::ByConsumer(Arc::clone(mapping), *from, node, number));
            }
            let moved = asked.and_then(|asked| asked.cob).filter(|(cob, _)| cob.id == frame.id);
            match &consumer.pdo(false, number)?.content {
                Content::Mapped(mapping, from) => {
                    let from = moved.map_or(*from, |(_, from)| from);
                    Some(Signals::ByConsumer(Arc::clone(mapping), from, node, number))
                }
                _ => None,
            }
        };
        consumed().unwrap_or(Signals::None(Unmapped::Unknown))
    }
}
