//! Errors that nodes report by emergencies: each problem of a node from its first emergency to the one that clears it.
//!
//! `checks/emcy` knows the active errors; here they are combined into problems as people see them.

use std::collections::BTreeMap;

use super::AGAIN_NS;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::problems::kinds::{ProblemKind, reported};
use crate::problems::ledger::LedgerPlace;
use crate::problems::problem::{Problem, StepRole, Subject, bit};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::Scene;
use crate::rules::finding::{Finding, Quantity};
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::world::change::EmcyChange;

/// Maximum distance of errors of one node with one cause, in ns.
const TOGETHER_NS: Ns = Ns::from_ms(500);

/// Number of reports of a loss, without one, that show the consumer's time to be too short, if no earlier sign does.
const TOO_SHORT: u64 = 3;
/// Number of periods from which a silence at the end of the capture is one.
const SILENT_PERIODS: i64 = 3;

/// The error code of a drive (CiA 402-2).
const ERROR_CODE: u16 = 0x603F;
/// Bit of the error register: communication (CiA 301, 7.5.2.2).
const COMMUNICATION: u8 = 1 << 4;
/// Error code of a loss reported by a heartbeat consumer (CiA 301, 7.2.7.1).
pub(in crate::problems) const LIFE_GUARD: u16 = 0x8130;
/// Error code of an RPDO that did not come in time.
pub(in crate::problems) const RPDO_TIMEOUT: u16 = 0x8250;

/// Returns the bit of the error register (CiA 301, 7.5.2.2) that shows an error code, among those that were set with it; all
/// of them if there is none.
fn class(code: u16, reported: u8) -> u8 {
    let bit = match code >> 12 {
        class @ 2..=4 => 1 << (class - 1),
        8 => COMMUNICATION,
        _ => 0,
    };
    if reported & bit != 0 { bit } else { u8::MAX }
}

/// The open problems of emergencies on a bus.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct Emergencies {
    open: BTreeMap<u8, Vec<LedgerPlace>>,
    /// Nodes that have booted in the capture without an emergency since, one bit each.
    quiet: u128,
    /// The last error code of each drive that was read, with the frame.
    read: BTreeMap<u8, (FrameRef, Quantity)>,
}

impl Emergencies {
    /// Processes an emergency that raises an error or clears errors.
    pub(in crate::problems) fn emergency(&mut self, emergency: EmcyChange, scene: &mut Scene<'_>) {
        self.quiet &= !bit(emergency.node);
        let unsaid = scene.ledger.last(scene.id, |one| {
            one.kind == ProblemKind::RegisterWithoutEmcy
                && one.subject.node == Some(emergency.node)
                && one.end.is_none()
        });
        if let Some(one) = unsaid.and_then(|place| scene.ledger.get_mut(place)) {
            // The emergency came just afterwards.
            if one.began_within(scene.at, TOGETHER_NS) {
                one.clue.least = u64::MAX;
            }
            one.ends(scene.at);
        }
        if emergency.code > 0xFF {
            self.raised(emergency, scene);
        } else {
            self.taken_back(emergency, scene);
        }
    }

    /// Clears the errors that an error register, read or reported, does not show any more. Only bit 0 is mandatory: that of
    /// an error's class counts if it was set when the error was reported.
    fn shown(&mut self, node: u8, register: u8, at: FrameRef, scene: &mut Scene<'_>) {
        let Some(open) = self.open.get_mut(&node) else { return };
        open.retain(|place| {
            let Some(one) = scene.ledger.get_mut(*place) else { return false };
            let Some(Quantity::Hex2(reported)) = one.get("register") else { return true };
            one.clue.codes.retain(|code| register & class(*code, reported) != 0);
            if one.clue.codes.is_empty() {
                one.step(at, StepRole::Recovery, Saying::RegisterRead { register }, None);
                one.fact("taken_back", Quantity::Count(at.listed().no));
            }
            !one.clue.codes.is_empty()
        });
    }

    fn raised(&mut self, emergency: EmcyChange, scene: &mut Scene<'_>) {
        let EmcyChange { node, code, profile, register, .. } = emergency;
        let at = scene.at;
        let Some(kind) = reported(code) else { return };
        let open = self.open.entry(node).or_default();
        let known = |place: &&LedgerPlace, scene: &Scene<'_>| {
            scene.ledger.get(**place).is_some_and(|one| one.clue.codes.contains(&code))
        };
        if let Some(place) = open.iter().find(|place| known(place, scene)).copied() {
            if let Some(one) = scene.ledger.get_mut(place) {
                one.step(at, StepRole::Sign, Saying::Raised { code: (code, profile), register }, None);
                one.repeats.count += 1;
            }
            return;
        }
        // What followed from a command that is over has not come again.
        let ordered = |one: &Problem| {
            let cause = one.cause.and_then(|link| scene.ledger.by_id(link.cause));
            cause.is_some_and(|cause| cause.kind.is_harmless() && cause.end.is_some())
        };
        let same = scene.ledger.last(scene.id, |one| {
            let before = one.subject.node == Some(node) && one.clue.reported.contains(&code);
            before && one.ended_within(at, AGAIN_NS) && !ordered(one)
        });
        let near = scene.ledger.last(scene.id, |one| {
            let near = one.began_within(at, TOGETHER_NS)
                || one.steps.last().is_some_and(|step| {
                    at.since(step.at).is_some_and(|since| (Ns::ZERO..=TOGETHER_NS).contains(&since))
                        && !one.clue.reported.is_empty()
                });
            let errs = !one.clue.reported.is_empty() || one.kind.is(KindRole::Announced);
            one.subject.node == Some(node) && near && errs && one.end.is_none()
        });
        let place = match same.or(near) {
            Some(place) => {
                if let Some(one) = scene.ledger.get_mut(place)
                    && one.end.is_some()
                {
                    one.again(at);
                }
                place
            }
            None => {
                let Some(place) = scene.ledger.open(kind, scene.id, Subject::node(node), at, at) else { return };
                self.begin(place, emergency, scene);
                place
            }
        };
        if let Some(one) = scene.ledger.get_mut(place) {
            one.step(at, StepRole::Sign, Saying::Raised { code: (code, profile), register }, None);
            one.clue.codes.push(code);
            one.clue.communication |= register & COMMUNICATION != 0;
            if !one.clue.reported.contains(&code) {
                one.clue.reported.push(code);
            }
            if !one.has("code") {
                one.fact("code", Quantity::Emcy(code, profile));
                one.fact("register", Quantity::Hex2(register));
            }
        }
        scene.ledger.grown.push(place);
        let open = self.open.entry(node).or_default();
        if !open.contains(&place) {
            open.push(place);
        }
    }

    /// Adds the facts that are known at the beginning and needed to find the cause.
    fn begin(&mut self, place: LedgerPlace, emergency: EmcyChange, scene: &mut Scene<'_>) {
        let EmcyChange { node, code, manufacturer, .. } = emergency;
        let misfit = matches!(code, 0x8210 | 0x8220);
        let (watched, sources) = (scene.watched(node), if misfit { scene.taken(node) } else { scene.sources(node) });
        let suspects = if code == RPDO_TIMEOUT { scene.suspects(node) } else { 0 };
        let sync = scene.heard.sync_period_ns.map(|period| (scene.heard.sync, period));
        let short = (code == LIFE_GUARD).then(|| too_short(&watched, manufacturer, scene)).flatten();
        let written =
            short.and_then(|(_, _, _, sub)| scene.value(node, 0x1016, sub)).and_then(|(_, from)| from.frame());
        let Some(one) = scene.ledger.get_mut(place) else { return };
        one.clue.watched = watched.iter().map(|(node, time, _)| (*node, *time)).collect();
        if code == LIFE_GUARD {
            let nodes = manufacturer.iter().filter(|byte| (1..=127).contains(*byte));
            one.clue.named = nodes.fold(0, |all, node| all | bit(*node));
        }
        (one.clue.sources, one.clue.sync, one.clue.suspects) = (sources, sync, suspects);
        if let Some(short) = short {
            is_too_short(one, short, written);
        }
    }

    /// Completes problems at the end of the capture with the known consumer times. A silence that a rule assumed by a
    /// time that is too short was none.
    pub(in crate::problems) fn finish(&mut self, scene: &mut Scene<'_>) {
        for (node, (at, code)) in &self.read {
            let fault = |one: &Problem| one.kind.is(KindRole::Fault) && one.subject.node == Some(*node);
            let place = scene.ledger.last(scene.id, |one| fault(one) && !one.has("code") && one.begin.no < at.no);
            if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                one.fact("error_code", *code);
            }
        }
        for place in 0..scene.ledger.all.len() {
            let Some(one) = scene.ledger.get(place) else { continue };
            let Some(node) = one.subject.node.filter(|_| one.bus == scene.id) else { continue };
            let often = one.kind.is(KindRole::Reported) && one.repeats.count >= TOO_SHORT;
            if often && let Some(short) = too_short(&scene.watched(node), [0; 5], scene) {
                let written = scene.value(node, 0x1016, short.3).and_then(|(_, from)| from.frame());
                if let Some(one) = scene.ledger.get_mut(place) {
                    is_too_short(one, short, written);
                }
            }
        }
        for place in 0..scene.ledger.all.len() {
            let Some(one) = scene.ledger.get(place) else { continue };
            let silent = one.bus == scene.id && one.kind.is(KindRole::LostBeats);
            // A silence at the end that is longer than all before is none of those.
            let periods = one.ns("period").unwrap_or(Ns::ZERO) * SILENT_PERIODS;
            let again = one.repeats.count > 1 && scene.at.since(one.repeats.since).is_some_and(|rest| rest < periods);
            let silent = silent && (one.end.is_some() || again);
            let Some(node) = one.subject.node.filter(|_| silent && !one.has("boot_up")) else { continue };
            let short = scene.ledger.all.iter().position(|other| {
                let watches = other.kind.is(KindRole::TimeTooShort) && other.count("watched") == u64::from(node);
                watches && other.bus == scene.id && one.ns("limit") <= other.ns("period")
            });
            if let Some(short) = short {
                scene.ledger.merge(place, short);
            }
        }
    }

    fn taken_back(&mut self, emergency: EmcyChange, scene: &mut Scene<'_>) {
        let EmcyChange { node, profile, register, active, .. } = emergency;
        let at = scene.at;
        if register != 0 {
            self.shown(node, register, at, scene);
        } else {
            // It says that no error is left.
            self.quiet |= bit(node);
        }
        let Some(open) = self.open.get_mut(&node) else { return };
        open.retain(|place| {
            let Some(one) = scene.ledger.get_mut(*place) else { return false };
            let before = one.clue.codes.len();
            one.clue.codes.retain(|code| register != 0 && active.iter().any(|known| known == *code));
            if one.clue.codes.is_empty() {
                let said = match one.clue.reported.as_slice() {
                    [code] => Saying::TakenBack { code: (*code, profile) },
                    _ => Saying::AllTakenBack,
                };
                one.step(at, StepRole::Recovery, said, None);
                one.fact("taken_back", Quantity::Count(at.listed().no));
            } else if one.clue.codes.len() == before {
                one.step(at, StepRole::Reaction, Saying::StillSet { register }, None);
            }
            !one.clue.codes.is_empty()
        });
    }

    /// Records an error register other than 0 without an emergency since the node booted.
    pub(in crate::problems) fn transfer(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        let node = transfer.node;
        let read = transfer.direction == Direction::Upload && transfer.outcome.status == Status::Ok;
        if let (true, Some(Mux { index: ERROR_CODE, sub: 0 }), [low, high]) = (read, transfer.mux, &*transfer.data.kept)
        {
            let code = u16::from_le_bytes([*low, *high]);
            if code != 0 {
                self.read.insert(node, (transfer.last, Quantity::Emcy(code, transfer.described.profile)));
            }
            return;
        }
        let (true, Some(Mux { index: 0x1001, sub: 0 }), [register]) = (read, transfer.mux, &*transfer.data.kept) else {
            return;
        };
        let at = transfer.last;
        self.shown(node, *register, at, scene);
        let open = scene.ledger.last(scene.id, |one| {
            one.kind == ProblemKind::RegisterWithoutEmcy && one.subject.node == Some(node) && one.end.is_none()
        });
        match (open.and_then(|place| scene.ledger.get_mut(place)), *register) {
            (Some(one), 0) => {
                one.step(at, StepRole::Recovery, Saying::RegisterRead { register: 0 }, None);
                one.ends(at);
            }
            (None, register) if register != 0 && self.quiet & bit(node) != 0 => {
                let subject = Subject::node(node);
                let place = scene.ledger.open(ProblemKind::RegisterWithoutEmcy, scene.id, subject, at, at);
                if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
                    one.fact("register", Quantity::Hex2(register));
                    one.step(at, StepRole::Sign, Saying::RegisterRead { register }, None);
                }
            }
            _ => {}
        }
    }

    /// Clears the errors of a node that booted.
    pub(in crate::problems) fn booted(&mut self, node: u8, scene: &mut Scene<'_>) {
        self.quiet |= bit(node);
        for place in self.open.remove(&node).unwrap_or_default() {
            if let Some(one) = scene.ledger.get_mut(place) {
                one.clue.codes.clear();
                one.step(scene.at, StepRole::Recovery, Saying::Booted, None);
                one.fact("taken_back", Quantity::Count(scene.at.listed().no));
            }
        }
    }

    /// Adds a finding about an emergency to the problem that it reports; returns true if there is one.
    pub(in crate::problems) fn found(&self, node: u8, finding: &Finding, scene: &mut Scene<'_>) -> bool {
        let place = scene.ledger.last(scene.id, |one| one.subject.node == Some(node) && one.holds(finding.at.no));
        if let Some(one) = place.and_then(|place| scene.ledger.get_mut(place)) {
            one.found(finding);
            return true;
        }
        false
    }
}

/// Records that a consumer waits for less than the period of the monitored node; `written`: the frame that configured
/// it.
fn is_too_short(one: &mut Problem, (watched, limit, period, _): Short, written: Option<u64>) {
    one.kind = ProblemKind::ConsumerTimeTooShort;
    one.subject.nodes |= bit(watched);
    one.fact("watched", Quantity::Count(watched.into()));
    one.fact("limit", Quantity::Ns(limit));
    one.fact("period", Quantity::Ns(period));
    if let Some(frame) = written {
        one.fact("written", Quantity::Count(frame));
    }
}

/// A monitored node, its consumer's time and its period in ns, and the sub-index of 1016h.
type Short = (u8, Ns, Ns, u8);

/// Returns a monitored node whose heartbeats come with a period longer than its consumer waits.
fn too_short(watched: &[(u8, Ns, u8)], manufacturer: [u8; 5], scene: &Scene<'_>) -> Option<Short> {
    let here = |node: u8, period: Ns| {
        let last = scene.heard.last_heartbeat(node).and_then(|last| scene.at.since(last));
        last.is_some_and(|since| since <= period + period / 4)
    };
    let short = watched.iter().filter_map(|(node, limit, sub)| {
        let period = scene.bus.heartbeat_period(*node)?;
        (*limit * 10 <= period * 12 && here(*node, period)).then_some((*node, *limit, period, *sub))
    });
    let short: Vec<_> = short.collect();
    // CANopenNode names the entry of 1016h: its index from 0 follows the error bit.
    let said = u8::try_from(u32::from_le_bytes([manufacturer[1], manufacturer[2], manufacturer[3], manufacturer[4]]));
    let said = said.ok().and_then(|index| short.iter().find(|one| one.3 == index.saturating_add(1)).copied());
    said.or_else(|| short.first().copied())
}
