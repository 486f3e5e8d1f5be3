//! What a rule has found and no other tracker follows: what it is, how often it came, and what ends it.
//!
//! The table is in `signs`. Findings of one kind about one subject are one incident, as long as they come again soon.
//! Must not: know a rule by name, beyond that of an unanswered request.

use super::AGAIN_NS;
use crate::checks::pdo::configuration::pdo_parameter;
use crate::diagnosis::incident::{Role, Subject};
use crate::diagnosis::kinds::Kind;
use crate::diagnosis::ledger::Place;
use crate::diagnosis::sayings::Saying;
use crate::diagnosis::scene::Scene;
use crate::diagnosis::signs::{self, Ends};
use crate::finding::{Code, Finding, Quantity};
use crate::frame::FrameRef;
use crate::services::sdo::wire::Mux;

/// Trouble of one SDO server within this time is one, in ns.
const ONE_TRANSFER_NS: i64 = 2_000_000_000;
/// What a second node with a node-ID shows before it is known to be one comes within this time, in ns.
const DOUBLE_NS: i64 = 15_000_000_000;
/// So many times as long as it may be, a PDO is missing and not late.
const MISSING: i64 = 5;
/// What came so often goes on where the next time is not due yet at the end of the capture.
pub(in crate::diagnosis) const GOES_ON: u64 = 3;

/// What is open.
#[derive(Clone, Debug, Default)]
pub(in crate::diagnosis) struct Found {
    open: Vec<(Place, Ends)>,
    /// The last time of those that are over at once.
    last: Vec<(Place, FrameRef)>,
}

/// What happened, seen by what it ends.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnosis) struct Sign {
    pub(in crate::diagnosis) ends: Ends,
    pub(in crate::diagnosis) node: Option<u8>,
    pub(in crate::diagnosis) pdo: Option<(bool, u16)>,
    pub(in crate::diagnosis) object: Option<Mux>,
}

/// Kinds that are one trouble of an SDO server.
fn is_sdo(kind: Kind) -> bool {
    matches!(kind, Kind::RequestUnanswered | Kind::LateAnswer | Kind::DamagedTransfer | Kind::TwoClients)
}

/// Kinds that are one trouble of SYNC.
fn is_sync(kind: Kind) -> bool {
    matches!(kind, Kind::SyncIrregular | Kind::SyncStopped | Kind::TwoSyncProducers | Kind::SyncLength)
}

impl Found {
    /// Takes what a rule has found. Gives the incident where it is a new one.
    pub(in crate::diagnosis) fn found(&mut self, finding: &Finding, scene: &mut Scene<'_>) -> Option<Place> {
        let (code, kind, least, ends) = signs::of(finding.code)?;
        let at = finding.about().unwrap_or(finding.at);
        let pdo =
            finding.object.and_then(|mux| pdo_parameter(mux.index)).map(|(_, transmit, number)| (transmit, number));
        let (kind, ends) = match (code, says(finding)) {
            (Code::Sdo002, Some("request")) => (Kind::DamagedTransfer, Ends::Transferred),
            // Who was heard is there.
            (Code::Sdo031, _) if finding.node.is_some_and(|node| scene.heard.last(node).is_some()) => {
                (Kind::RequestUnanswered, Ends::Answered)
            }
            // Whether the value was taken is not known until it is written again.
            _ if kind == Kind::RequestUnanswered && written(finding, scene) == Some(at.no) => (kind, Ends::Written),
            _ => (kind, ends),
        };
        // A SYNC that stops is no trouble of the node that misses it.
        let node = finding.node.filter(|_| kind != Kind::SyncStopped);
        let subject = Subject { pdo, ..Subject::of(node) };
        let because = finding.because_of.map(|frame| frame.no);
        // A finding that counts stands at the last of them; one of a deadline where that was noticed.
        let last = if times(finding, 1) > 1 && finding.at.no > at.no { finding.at } else { at };
        let again = scene.ledger.last(scene.id, |one| {
            let (node, other) = (one.subject.node, one.kind);
            let same = other == kind && (node, one.subject.pdo) == (subject.node, subject.pdo);
            let near =
                one.end.is_none() || one.ended_within(at, ONE_TRANSFER_NS) || one.began_within(at, ONE_TRANSFER_NS);
            let soon = one.end.is_none() || one.ended_within(at, AGAIN_NS);
            let of_kind = |is: fn(Kind) -> bool| is(other) && is(kind) && node == subject.node && near;
            let explained = because.is_some_and(|frame| one.holds(frame)) && !is_sdo(kind) && node == subject.node;
            same && soon || of_kind(is_sdo) || of_kind(is_sync) || explained
        });
        if let Some(place) = again {
            let one = scene.ledger.get_mut(place)?;
            one.found(finding);
            // What follows from an earlier one of the same is one more.
            if one.kind == kind && because.is_none_or(|frame| one.holds(frame)) {
                if one.end.is_some() || matches!(ends, Ends::Once | Ends::Never) {
                    one.again(at);
                }
                one.repeats.count += times(finding, least) - 1;
                self.keep(place, ends, last);
            }
            return None;
        }
        if kind == Kind::DuplicateNodeId
            && let Some(one) = scene.ledger.last(scene.id, |one| {
                let shows = matches!(
                    one.kind,
                    Kind::NodeRestarted
                        | Kind::RestartLoop
                        | Kind::LeftOperational
                        | Kind::HeartbeatIrregular
                        | Kind::DamagedTransfer
                );
                shows && one.subject.node == subject.node && one.began_within(finding.at, DOUBLE_NS)
            })
            && let Some(one) = scene.ledger.get_mut(one)
        {
            (one.kind, one.end, one.clue.least) = (kind, None, 1);
            one.found(finding);
            return None;
        }
        // What something else explains, and is no trouble of its own, belongs to that.
        if let Some(frame) = because
            && !is_sdo(kind)
        {
            let cause = scene.ledger.last(scene.id, |one| one.holds(frame));
            if let Some(one) = cause.and_then(|place| scene.ledger.get_mut(place)) {
                one.found(finding);
                if finding.node.is_none_or(|node| one.subject.concerns(node)) {
                    return None;
                }
            }
        }
        let place = scene.ledger.open(kind, scene.id, subject, at, finding.at)?;
        let producer = scene.heard.sync_period_ns.map(|period| (scene.heard.sync, period));
        let one = scene.ledger.get_mut(place)?;
        one.clue.because_of = because;
        one.clue.least = least;
        one.clue.sync = producer;
        one.repeats.count = times(finding, least);
        for (name, value) in finding.measured().iter().flat_map(|all| all.facts()) {
            one.fact(name, value);
        }
        if let Some(object) = finding.object {
            one.fact("object", Quantity::Object(object));
        }
        one.found(finding);
        self.keep(place, ends, last);
        Some(place)
    }

    fn keep(&mut self, place: Place, ends: Ends, at: FrameRef) {
        match ends {
            Ends::Never => {}
            Ends::Once => {
                self.last.retain(|(other, _)| *other != place);
                self.last.push((place, at));
            }
            _ if self.open.iter().any(|(other, _)| *other == place) => {}
            _ => self.open.push((place, ends)),
        }
    }

    /// Whether anything is open that may end.
    #[inline]
    pub(in crate::diagnosis) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Whether the length of a PDO matters.
    pub(in crate::diagnosis) fn measures(&self) -> bool {
        self.open.iter().any(|(_, ends)| *ends == Ends::Length)
    }

    /// Something has happened that may end what is open.
    pub(in crate::diagnosis) fn sign(&mut self, sign: Sign, scene: &mut Scene<'_>) {
        if self.open.is_empty() {
            return;
        }
        let at = scene.at;
        self.open.retain(|(place, ends)| {
            let Some(one) = scene.ledger.get_mut(*place) else { return false };
            let of_node = sign.node.is_none() || one.subject.node == sign.node;
            let of_pdo = one.subject.pdo.is_none() || one.subject.pdo == sign.pdo;
            let after = at.no > one.noticed.no;
            if *ends == Ends::Written && sign.object.map(Quantity::Object) != one.get("object") {
                return true;
            }
            if *ends != sign.ends || !of_node || !after || (matches!(ends, Ends::Pdo | Ends::Length) && !of_pdo) {
                return true;
            }
            let said = match ends {
                Ends::Heard => Saying::HeardAgain,
                Ends::Answered | Ends::Transferred => Saying::Answered,
                Ends::Written => Saying::WrittenAgain,
                Ends::Sync => Saying::SyncAgain,
                Ends::Pdo => Saying::PdoAgain,
                Ends::Length => Saying::LengthFits,
                _ => Saying::Recovered,
            };
            one.step(at, Role::Recovery, said, None);
            one.ends(at);
            false
        });
    }

    /// The capture is over at this frame: what was over at once, and what goes on.
    pub(in crate::diagnosis) fn finish(&mut self, end: FrameRef, scene: &mut Scene<'_>) {
        for (place, last) in self.last.drain(..) {
            let Some(one) = scene.ledger.get_mut(place) else { continue };
            let mean = last.since(one.begin).map(|all| all / one.repeats.count.max(2) as i64);
            let rest = end.since(last);
            let goes_on = mean.zip(rest).is_some_and(|(mean, rest)| rest < mean.saturating_mul(3));
            if one.repeats.count < GOES_ON || !goes_on {
                one.ends(last);
            }
        }
        for (place, ends) in self.open.drain(..) {
            if let Some(one) = scene.ledger.get_mut(place)
                && ends == Ends::Pdo
            {
                one.clue.least = 1;
            }
        }
        for one in scene.ledger.all.iter_mut().filter(|one| one.kind == Kind::PdoMissing && one.clue.least > 1) {
            let limit = one.ns("limit").or_else(|| one.ns("period"));
            if limit.is_some_and(|limit| one.repeats.longest_ns > limit.saturating_mul(MISSING)) {
                one.clue.least = 1;
            }
        }
    }
}

/// The last write to the node that a finding is about.
fn written(finding: &Finding, scene: &Scene<'_>) -> Option<u64> {
    Some(scene.heard.written(finding.node?)?.no)
}

/// How often it happened by a finding: what has no single gap lasts.
fn times(finding: &Finding, least: u64) -> u64 {
    let Some(measured) = finding.measured() else { return finding.facts.count().max(1) };
    let counted = measured.facts().find_map(|(name, value)| match value {
        Quantity::Count(count) if matches!(name, "count" | "missing") => Some(count),
        _ => None,
    });
    let lasts = finding.code == Code::Syn003 && measured.get("gap").is_none();
    if lasts { least } else { counted.unwrap_or(1).max(1) }
}

/// What a finding about an unanswered request says is missing.
fn says(finding: &Finding) -> Option<&'static str> {
    let measured = finding.measured()?;
    let (_, value) = measured.variant.constants.iter().find(|(name, _)| *name == "missing")?;
    Some(value.trim_matches('"'))
}
