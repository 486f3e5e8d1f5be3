//! NMT commands that contradict each other: two masters on one bus.
//!
//! One master may stop a node and start it again; who takes back each other's commands within moments, again and again,
//! are two. Must not: know what the nodes make of it.

use std::collections::{BTreeMap, VecDeque};

use crate::diagnosis::incident::{Grade, Role, Subject};
use crate::diagnosis::kinds::Kind;
use crate::diagnosis::ledger::Place;
use crate::diagnosis::sayings::Saying;
use crate::diagnosis::scene::Scene;
use crate::frame::FrameRef;

/// A command that takes back the one before within this time contradicts it, in ns.
const CONTRARY_NS: i64 = 2_000_000_000;
/// So many contradictions within this time, in ns, are more than one master makes.
const CONTRADICTIONS: usize = 4;
const WITHIN_NS: i64 = 15_000_000_000;

/// A command and what it was.
type Given = (u8, FrameRef);

/// The last commands of a bus.
#[derive(Debug, Default)]
pub(in crate::diagnosis) struct Masters {
    /// The last command to each node; 0: to all.
    last: BTreeMap<u8, Given>,
    /// Those that were contradicted, with those that did.
    contrary: VecDeque<(Given, Given)>,
    open: Option<Place>,
}

/// Whether a command makes nodes run.
fn starts(command: u8) -> bool {
    command == 0x01
}

impl Masters {
    /// The NMT master has commanded a node, or all (0).
    pub(in crate::diagnosis) fn commanded(&mut self, command: u8, node: u8, scene: &mut Scene<'_>) {
        let at = scene.at;
        let before = [node, 0].into_iter().filter_map(|key| self.last.get(&key)).max_by_key(|(_, at)| at.no).copied();
        if node == 0 {
            self.last.clear();
        }
        self.last.insert(node, (command, at));
        let Some(before) = before.filter(|(other, since)| {
            starts(*other) != starts(command) && at.since(*since).is_some_and(|since| since <= CONTRARY_NS)
        }) else {
            return;
        };
        // Reset, boot-up, start is what one master does.
        if matches!(before.0, 0x81 | 0x82) {
            return;
        }
        self.contrary.push_back((before, (command, at)));
        while self.contrary.front().is_some_and(|(_, (_, first))| at.since(*first).is_none_or(|ns| ns > WITHIN_NS)) {
            self.contrary.pop_front();
        }
        if let Some(one) = self.open.and_then(|place| scene.ledger.get_mut(place)) {
            one.repeats.count += 1;
            one.step(at, Role::Sign, Saying::Commanded { command }, None);
            one.repeats.since = at;
            return;
        }
        if self.contrary.len() < CONTRADICTIONS {
            return;
        }
        let Some(((_, begin), _)) = self.contrary.front().copied() else { return };
        self.open = scene.ledger.open(Kind::TwoMasters, scene.id, Subject::default(), begin, at);
        if let Some(one) = self.open.and_then(|place| scene.ledger.get_mut(place)) {
            one.grade = Grade::Likely;
            one.repeats.count = self.contrary.len() as u64;
            let mut told = 0;
            for (command, at) in self.contrary.iter().flat_map(|(first, then)| [*first, *then]) {
                if at.no > told {
                    one.step(at, Role::Sign, Saying::Commanded { command }, None);
                    told = at.no;
                }
            }
            one.repeats.since = at;
        }
    }

    /// The capture is over: it is over where both have agreed for longer than they ever did in between.
    pub(in crate::diagnosis) fn finish(&mut self, scene: &mut Scene<'_>) {
        if let Some(one) = self.open.take().and_then(|place| scene.ledger.get_mut(place)) {
            let last = one.repeats.since;
            if scene.at.since(last).is_some_and(|rest| rest > CONTRARY_NS * 2) {
                one.ends(last);
            }
        }
    }
}
