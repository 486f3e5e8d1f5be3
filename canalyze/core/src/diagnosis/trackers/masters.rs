//! NMT commands that take back each other: two masters on one bus.
//!
//! One master that stops a node to configure it writes to it before it starts it again. Who stops a node and is
//! contradicted within moments, again and again, with nothing done in between, is another one than who starts it. Must
//! not: know what the nodes make of it.

use std::collections::BTreeMap;

use crate::diagnosis::incident::{Grade, Role, Subject, bit, members};
use crate::diagnosis::kinds::Kind;
use crate::diagnosis::ledger::Place;
use crate::diagnosis::sayings::Saying;
use crate::diagnosis::scene::Scene;
use crate::frame::FrameRef;

/// A stop is contradicted by a start within this time, in ns.
const CONTRARY_NS: i64 = 2_000_000_000;
/// So many contradictions of one node, this close together in ns, are more than one master makes.
const CONTRADICTIONS: usize = 2;
const WITHIN_NS: i64 = 15_000_000_000;
/// Contradictions of a node that are kept.
const KEPT: usize = 8;

/// A command and the frame that carried it.
type Given = (u8, FrameRef);

/// The commands to one node.
#[derive(Debug, Default)]
struct Commanded {
    last: Option<Given>,
    /// Stops that were taken back, with the starts that did.
    contrary: Vec<(Given, Given)>,
}

/// The commands of a bus.
#[derive(Debug, Default)]
pub(in crate::diagnosis) struct Masters {
    /// By node; 0: all.
    nodes: BTreeMap<u8, Commanded>,
    open: Option<Place>,
}

impl Masters {
    /// The NMT master has commanded a node, or all (0).
    pub(in crate::diagnosis) fn commanded(&mut self, command: u8, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        let one = self.nodes.entry(node).or_default();
        let Some(stop) =
            one.last.replace((command, at)).filter(|(last, _)| command == 0x01 && matches!(last, 0x02 | 0x80))
        else {
            return;
        };
        let soon = at.since(stop.1).is_some_and(|since| since <= CONTRARY_NS);
        let told = |node: u8| scene.heard.written(node).is_some_and(|written| written.no > stop.1.no);
        let for_a_reason = if node == 0 { members(scene.heard.known).any(told) } else { told(node) };
        if !soon || for_a_reason {
            return;
        }
        one.contrary.retain(|(_, (_, start))| at.since(*start).is_some_and(|since| since <= WITHIN_NS));
        if one.contrary.len() < KEPT {
            one.contrary.push((stop, (command, at)));
        }
        if one.contrary.len() < CONTRADICTIONS {
            return;
        }
        let told = match self.open {
            Some(_) => one.contrary.len() - 1,
            None => 0,
        };
        let Some((first, _)) = one.contrary.first().copied() else { return };
        let nodes = if node == 0 { scene.heard.known } else { bit(node) };
        let place =
            self.open.or_else(|| scene.ledger.open(Kind::TwoMasters, scene.id, Subject::nodes(nodes), first.1, at));
        self.open = place;
        let Some(incident) = place.and_then(|place| scene.ledger.get_mut(place)) else { return };
        incident.grade = Grade::Likely;
        incident.subject.nodes |= nodes;
        incident.repeats.count = incident.repeats.count.max(one.contrary.len() as u64);
        incident.repeats.since = at;
        for (command, at) in one.contrary.iter().skip(told).flat_map(|(stop, start)| [*stop, *start]) {
            incident.step(at, Role::Sign, Saying::Commanded { command }, None);
        }
    }

    /// The capture is over: so is this, where nothing was contradicted for longer than it takes.
    pub(in crate::diagnosis) fn finish(&mut self, scene: &mut Scene<'_>) {
        if let Some(one) = self.open.take().and_then(|place| scene.ledger.get_mut(place)) {
            let last = one.repeats.since;
            if scene.at.since(last).is_some_and(|rest| rest > CONTRARY_NS) {
                one.ends(last);
            }
        }
    }
}
