//! Findings that no other tracker follows: their kind, number and end.
//!
//! The table is in `signs`. Findings of one kind about one subject are one problem if they recur soon.

use std::collections::{BTreeMap, VecDeque};

use super::AGAIN_NS;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::checks::pdo::configuration::pdo_parameter;
use crate::problems::kinds::{ProblemKind, signed};
use crate::problems::ledger::{DOUBLE_NS, LedgerPlace};
use crate::problems::problem::{Grade, Problem, StepRole, Subject};
use crate::problems::roles::KindRole;
use crate::problems::sayings::Saying;
use crate::problems::scene::{Last, Scene};
use crate::problems::signs::{self, Ends};
use crate::rules::Measured;
use crate::rules::finding::{Code, Finding, Quantity};
use crate::sdo::transfer::Transfer;
use crate::sdo::wire::Mux;

/// Maximum distance of problems of one SDO server that are one, in ns.
const ONE_TRANSFER_NS: Ns = Ns::from_s(2);
/// A period that differs by less than this part is the same again.
const SAME_PERIOD: i64 = 8;
/// Ratio to its limit from which on a PDO is missing and not late.
const MISSING: i64 = 5;
/// Time without a PDO after which it is no longer sent, in ns.
const NO_LONGER_NS: Ns = Ns::from_s(2);
/// Maximum time from the first to the last node that a master stops guarding, in ns.
const MASTER_NS: Ns = Ns::from_s(5);
/// Number of transfers that are kept for findings that come later, and of objects that are followed.
const SERVED: usize = 64;
const IN_VAIN: usize = 4096;
/// Number of times from which a problem is still open at the end of the capture if the next time is not due yet.
pub(in crate::problems) const GOES_ON: u64 = 3;

/// The open problems.
#[derive(Clone, Debug, Default)]
pub(in crate::problems) struct RuleProblems {
    open: Vec<(LedgerPlace, Ends)>,
    /// The last time of problems that end at once.
    last: Vec<(LedgerPlace, FrameRef)>,
    /// Number of requests in vain since the last one that was served, by server and object.
    in_vain: BTreeMap<(u8, u16, u8), u64>,
    /// The last ones that were served, and boot-ups as object 0, with the numbers of their frames: a finding about one before
    /// may come later.
    served: VecDeque<((u8, u16, u8), u64)>,
}

/// A sign that may end problems.
#[derive(Clone, Copy, Debug)]
pub(in crate::problems) struct Sign {
    pub(in crate::problems) ends: Ends,
    pub(in crate::problems) node: Option<u8>,
    pub(in crate::problems) pdo: Option<(bool, u16)>,
    /// Length of the PDO in bytes.
    pub(in crate::problems) length: u64,
    pub(in crate::problems) object: Option<Mux>,
    /// Number of the SRDO.
    pub(in crate::problems) srdo: u8,
    /// The node has booted.
    pub(in crate::problems) boot_up: bool,
}

impl Sign {
    /// Makes a sign of a node, or of the bus.
    pub(in crate::problems) fn of(ends: Ends, node: Option<u8>) -> Self {
        Self { ends, node, pdo: None, length: 0, object: None, srdo: 0, boot_up: false }
    }
}

/// Returns true for kinds that are one problem of an SDO server.
fn is_sdo(kind: ProblemKind) -> bool {
    kind.is(KindRole::Sdo)
}

/// Returns true for kinds that are one problem of SYNC.
fn is_sync(kind: ProblemKind) -> bool {
    kind.is(KindRole::Sync)
}

impl RuleProblems {
    /// Processes a finding; returns its problem if that is new.
    pub(in crate::problems) fn found(&mut self, finding: &Finding, scene: &mut Scene<'_>) -> Option<LedgerPlace> {
        let (kind, signs::Sign { code, ends, least }) = signed(finding.code)?;
        let at = finding.about().unwrap_or(finding.at);
        // What was answered late is served, or was not answered in time before.
        let in_vain = kind.is(KindRole::NotServed) && code != Code::Sdo020;
        if let (true, Some(node), Some(Mux { index, sub })) = (in_vain, finding.node, finding.object) {
            let key = (node, index, sub);
            let since = self.served.iter().any(|(other, no)| (*other == key || *other == (node, 0, 0)) && *no > at.no);
            if !since && (self.in_vain.len() < IN_VAIN || self.in_vain.contains_key(&key)) {
                *self.in_vain.entry(key).or_default() += 1;
            }
        }
        let pdo =
            finding.object.and_then(|mux| pdo_parameter(mux.index)).map(|(_, transmit, number)| (transmit, number));
        // A period that stays another one counts from the first time on.
        let stays = match code {
            Code::Hbt007 => true,
            Code::Hbt001 => constant(finding, "reason") == Some("period"),
            Code::Syn003 => finding.measured().is_some_and(|all| all.get("expected").is_some()),
            _ => false,
        };
        let least = if stays || lacks(finding) { 1 } else { least };
        let (kind, ends) = match (code, constant(finding, "missing")) {
            _ if stays => (kind, Ends::Never),
            (Code::Srd003, _) if constant(finding, "reason") == Some("stopped") => (kind, Ends::Srdo),
            // Its own length has been right all the time.
            _ if finding.measured().is_some_and(|all| all.get("consumer").is_some()) => (kind, Ends::Never),
            (Code::Sdo002, Some("request")) => (ProblemKind::DamagedTransfer, Ends::Transferred),
            // A node that was heard exists.
            (Code::Sdo031, _) if finding.node.is_some_and(|node| scene.heard.last(node).is_some()) => {
                (ProblemKind::RequestUnanswered, Ends::Answered)
            }
            // The outcome of a write is not known until the next one.
            _ if kind.is(KindRole::Unanswered) && written(finding, scene) == Some(at.no) => (kind, Ends::Written),
            _ => (kind, ends),
        };
        // A stopped SYNC is not a problem of the node that misses it.
        let node = finding.node.filter(|_| !kind.is(KindRole::NoSync));
        let subject = Subject { pdo, ..Subject::of(node) };
        let because = finding.because_of.map(|frame| frame.no);
        // A finding with a count is placed at the last of them; one about a deadline where it was noticed.
        let last = if times(finding, 1) > 1 && finding.at.no > at.no { finding.at } else { at };
        let unasked = code == Code::Sdo002 && constant(finding, "missing") == Some("request");
        let gap_ns = match finding.measured().and_then(|all| all.get("found")) {
            Some(Quantity::Ns(gap)) if code == Code::Hbt001 && !stays => Some(gap),
            _ => None,
        };
        let again = scene.ledger.last(scene.id, |one| {
            let (node, other) = (one.subject.node, one.kind);
            let same =
                other == kind && (node, one.subject.pdo) == (subject.node, subject.pdo) && says_same(one, finding);
            let near =
                one.end.is_none() || one.ended_within(at, ONE_TRANSFER_NS) || one.began_within(at, ONE_TRANSFER_NS);
            let soon = one.end.is_none() || one.ended_within(at, AGAIN_NS);
            // What the client did not wait for comes late.
            let served = other.is(KindRole::Service) && !other.is(KindRole::Violation);
            let owed = served && unasked && node == subject.node && soon;
            let of_kind = |is: fn(ProblemKind) -> bool| is(other) && is(kind) && node == subject.node && near;
            let explained = because.is_some_and(|frame| one.holds(frame)) && !is_sdo(kind) && node == subject.node;
            let two = other.is(KindRole::SecondDevice) && node == subject.node;
            let second = kind.is(KindRole::Violation) && two;
            // The node was out, or restarted, in this gap of its heartbeats.
            let outage = [KindRole::Outage, KindRole::NoHeartbeats, KindRole::MissingPdo].map(|role| other.is(role));
            let in_gap = |gap| one.began_within(finding.at, gap) || one.ended_within(finding.at, gap);
            let concerns = node == subject.node || subject.node.is_some_and(|node| one.subject.concerns(node));
            let first = outage.contains(&true) && concerns && gap_ns.is_some_and(in_gap);
            // A SYNC that was unsteady and stops is another problem.
            let stops = kind.is(KindRole::NoSync) && !other.is(KindRole::NoSync);
            same && soon || second || first || owed || of_kind(is_sdo) || of_kind(is_sync) && !stops || explained
        });
        // It was there all along: the client did not wait for its response.
        let late = |one: &Problem| {
            one.kind.is(KindRole::NeverHeard) && one.subject.node == node && one.end == Some(finding.at)
        };
        if code == Code::Sdo020
            && let Some(one) = scene.ledger.last(scene.id, late).and_then(|place| scene.ledger.get_mut(place))
        {
            if let Some(object) = finding.object {
                one.fact("object", Quantity::Object(object));
            }
            one.measured = finding.measured();
            one.found(finding);
            answered_late(one, finding);
            return None;
        }
        if let Some(place) = again {
            let one = scene.ledger.get_mut(place)?;
            one.found(finding);
            if one.kind == kind {
                one.clue.least = one.clue.least.min(least);
            }
            if stays && one.kind == kind {
                self.last.retain(|(other, _)| *other != place);
                // It is what it was before.
                if is_former(one, finding) {
                    one.ends(finding.at);
                    return None;
                }
                // What explained a single late one explains no lasting change.
                one.cause = None;
                (one.clue.least, one.end, one.measured) = (least, None, finding.measured());
                for (name, value) in finding.measured().iter().flat_map(|all| all.facts()) {
                    if !one.has(name) {
                        one.fact(name, value);
                    }
                }
                return None;
            }
            // It was late before it stopped.
            if ends == Ends::Srdo && one.kind == kind {
                self.last.retain(|(other, _)| *other != place);
                one.measured = finding.measured();
                finding.measured().iter().flat_map(|all| all.facts()).for_each(|(name, value)| one.fact(name, value));
            }
            // Single late or early SYNCs at a change of the period.
            let changed = one.measured().is_some_and(|all| all.get("expected").is_some() && all.get("gap").is_none());
            if code == Code::Syn003 && !stays && changed && one.end.is_none() {
                return None;
            }
            // Behind a shorter period heartbeats seem to be lost where the former one is back.
            if stays && one.kind.is(KindRole::LostBeats) {
                let shorter = |one: &Problem| {
                    one.kind == kind && one.subject.node == node && one.end.is_none() && is_former(one, finding)
                };
                if let Some(former) = scene.ledger.last(scene.id, shorter) {
                    scene.ledger.merge(place, former);
                    scene.ledger.get_mut(former)?.ends(finding.at);
                    return None;
                }
            }
            // The cause of what seemed to be single late or early ones, or lost heartbeats.
            let one = scene.ledger.get_mut(place)?;
            let second = kind.is(KindRole::TwoSyncs) && one.kind.is(KindRole::UnsteadySync);
            let slower = one.kind.is(KindRole::LostBeats);
            if second || stays && slower {
                self.last.retain(|(other, _)| *other != place);
                (one.kind, one.clue.least, one.end, one.measured) = (kind, 1, None, finding.measured());
                one.repeats.count = 1;
                for (name, value) in finding.measured().iter().flat_map(|all| all.facts()) {
                    one.fact(name, value);
                }
                return None;
            }
            if code == Code::Sdo020 && one.kind.is(KindRole::Unanswered) && one.repeats.count == 1 {
                answered_late(one, finding);
            }
            // A consequence of an earlier one of the same kind is a repetition.
            let totals = matches!(code, Code::Bus001 | Code::Bus007)
                && finding.measured().is_some_and(|all| all.get("duration").is_some());
            if totals && code == Code::Bus007 {
                one.measured = finding.measured();
                // The last of them is at this frame.
                self.last.iter_mut().filter(|(other, _)| *other == place).for_each(|(_, last)| *last = finding.at);
            }
            if one.kind == kind && because.is_none_or(|frame| one.holds(frame)) && !totals {
                if one.end.is_some() || matches!(ends, Ends::Once | Ends::Never) {
                    one.again(at);
                }
                one.repeats.count += times(finding, least) - 1;
                self.keep(place, ends, last);
            }
            return None;
        }
        if kind.is(KindRole::SecondDevice)
            && let Some(place) = scene.ledger.last(scene.id, |one| {
                let shows = one.kind.is(KindRole::ShowsSecond);
                let told = one.kind == kind;
                (told || shows && one.began_within(finding.at, DOUBLE_NS)) && one.subject.node == subject.node
            })
        {
            let place = scene.ledger.doubles(place, finding.at, finding.measured());
            if let Some(one) = scene.ledger.get_mut(place) {
                one.found(finding);
            }
            return None;
        }
        // A consequence that is no problem of its own belongs to its cause.
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
        if kind.is(KindRole::Absent) {
            one.grade = Grade::Likely;
        }
        // A client that sends something else waits no longer; that nobody answers in time is no frame.
        let asks = finding.node.and_then(|node| scene.heard.noted(Last::Request, node));
        one.clue.given_up = asks.filter(|asks| *asks == finding.at && asks.no > at.no);
        one.clue.sync = producer;
        one.repeats.count = times(finding, least);
        for (name, value) in finding.measured().iter().flat_map(|all| all.facts()) {
            one.fact(name, value);
        }
        if let Some(object) = finding.object {
            one.fact("object", Quantity::Object(object));
        }
        one.measured = finding.measured();
        one.found(finding);
        // The finding waited for what excuses it: the node may have responded since.
        let answered =
            finding.node.and_then(|node| scene.heard.noted(Last::Answer, node)).filter(|at| at.no > finding.at.no);
        if kind == ProblemKind::PdoInterval {
            // The first of these intervals seemed to lack PDOs.
            let missing = |other: &Problem| {
                let same = (other.subject.node, other.subject.pdo) == (subject.node, subject.pdo);
                let during = other.begin.no >= at.no && other.end.is_some();
                same && during && other.kind.is(KindRole::MissingPdo)
            };
            if let Some(missing) = scene.ledger.last(scene.id, missing) {
                scene.ledger.get_mut(missing)?.steps.clear();
                scene.ledger.merge(missing, place);
            }
        }
        let one = scene.ledger.get_mut(place)?;
        if let (Ends::Answered, Some(answered)) = (ends, answered) {
            one.step(answered, StepRole::Recovery, Saying::Answered, None);
            one.ends(answered);
        } else {
            self.keep(place, ends, last);
        }
        Some(place)
    }

    fn keep(&mut self, place: LedgerPlace, ends: Ends, at: FrameRef) {
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

    /// Processes the end of a download that failed, or was taken although it was wrong: nothing but a write of the same
    /// object makes it good.
    pub(in crate::problems) fn not_written(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        for (place, ends) in self.open.iter_mut().filter(|(_, ends)| matches!(ends, Ends::Transferred | Ends::Answered))
        {
            let Some(one) = scene.ledger.get_mut(*place) else { continue };
            let within = one.bus == scene.id && one.repeats.since.no >= transfer.first.no;
            if let Some(mux) =
                transfer.mux.filter(|_| within && one.subject.node == Some(transfer.node) && is_sdo(one.kind))
            {
                one.fact("object", Quantity::Object(mux));
                *ends = Ends::Written;
            }
        }
    }

    /// Records a transfer that succeeded: what was asked for in vain is served again.
    pub(in crate::problems) fn served(&mut self, transfer: &Transfer) {
        if let Some(Mux { index, sub }) = transfer.mux {
            self.answered((transfer.node, index, sub), transfer.last);
        }
    }

    /// Records a boot-up: requests before it went to a node that was not there.
    pub(in crate::problems) fn booted(&mut self, node: u8, at: FrameRef) {
        self.in_vain.retain(|(server, ..), _| *server != node);
        self.answered((node, 0, 0), at);
    }

    fn answered(&mut self, key: (u8, u16, u8), at: FrameRef) {
        self.in_vain.remove(&key);
        if self.served.len() >= SERVED {
            self.served.pop_front();
        }
        self.served.push_back((key, at.no));
    }

    /// Marks problems of requests that were repeated in vain until the end of the capture.
    fn not_served(&mut self, scene: &mut Scene<'_>) {
        for ((node, ..), _) in std::mem::take(&mut self.in_vain).into_iter().filter(|(_, count)| *count >= GOES_ON) {
            let asked = |one: &Problem| one.kind.is(KindRole::NotServed) && one.subject.node == Some(node);
            if let Some(one) = scene.ledger.last(scene.id, asked).and_then(|place| scene.ledger.get_mut(place)) {
                one.clue.not_served = true;
            }
        }
    }

    /// Returns true if nothing is open.
    #[inline]
    pub(in crate::problems) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Returns true if the length of a PDO matters.
    pub(in crate::problems) fn measures(&self) -> bool {
        self.open.iter().any(|(_, ends)| *ends == Ends::Length)
    }

    /// Processes a sign that may end problems.
    pub(in crate::problems) fn sign(&mut self, sign: Sign, scene: &mut Scene<'_>) {
        if self.open.is_empty() {
            return;
        }
        let at = scene.at;
        self.open.retain(|(place, ends)| {
            let Some(one) = scene.ledger.get_mut(*place) else { return false };
            // Two devices with one node-ID are there whatever comes.
            if one.kind.is(KindRole::SecondDevice) {
                return false;
            }
            let soon = || at.since(one.begin).zip(one.ns("age")).is_some_and(|(since, age)| since <= 2 * age);
            let meanwhile = *ends == Ends::Answered || one.kind.is(KindRole::Guarding) && soon();
            if sign.ends == Ends::Heard && meanwhile && one.subject.node == sign.node {
                one.fact("heard_meanwhile", Quantity::Count(1));
            }
            let of_node = sign.node.is_none() || one.subject.node == sign.node;
            let of_pdo = one.subject.pdo.is_none() || one.subject.pdo == sign.pdo;
            if *ends == Ends::Operational && sign.ends == Ends::Pdo && of_pdo && one.subject.node == sign.node {
                one.repeats.since = at;
                return true;
            }
            let after = at.no > one.noticed.no;
            if *ends == Ends::Written && sign.object.map(Quantity::Object) != one.get("object") {
                return true;
            }
            let of_one = matches!(ends, Ends::Pdo | Ends::Length | Ends::Former);
            if *ends == Ends::Former && Some(Quantity::Count(sign.length)) != one.get("before") {
                return true;
            }
            if *ends == Ends::Srdo && Some(Quantity::Count(sign.srdo.into())) != one.get("srdo") {
                return true;
            }
            if *ends == Ends::SyncLength && !is_due(one, sign.length) {
                return true;
            }
            if *ends != sign.ends || !of_node || !after || of_one && !of_pdo {
                return true;
            }
            if sign.boot_up {
                one.fact("boot_up", Quantity::Count(1));
            }
            let said = match ends {
                _ if sign.boot_up => Saying::Booted,
                Ends::Heard if one.kind.is(KindRole::NeverHeard) => Saying::FirstHeard,
                Ends::Heard | Ends::Controlled => Saying::HeardAgain,
                Ends::Transferred => Saying::Transferred,
                Ends::Answered => Saying::Answered,
                Ends::Written => Saying::WrittenAgain,
                Ends::Sync => Saying::SyncAgain,
                Ends::Pdo => Saying::PdoAgain,
                Ends::Length | Ends::Former | Ends::SyncLength => Saying::LengthFits,
                _ => Saying::Recovered,
            };
            one.step(at, StepRole::Recovery, said, None);
            one.ends(at);
            false
        });
    }

    /// Ends problems at the end of the capture, except those that go on.
    pub(in crate::problems) fn finish(&mut self, end: FrameRef, scene: &mut Scene<'_>) {
        self.not_served(scene);
        together(KindRole::NoGuarding, |_| MASTER_NS, scene);
        together(KindRole::Guarding, |one| one.ns("age").unwrap_or(Ns::ZERO), scene);
        for (place, last) in self.last.drain(..) {
            let Some(one) = scene.ledger.get_mut(place).filter(|one| !one.clue.lasts) else { continue };
            let mean = last.since(one.begin).map(|all| all / one.repeats.count.max(2) as i64);
            let rest = end.since(last);
            let goes_on = mean.zip(rest).is_some_and(|(mean, rest)| rest < mean * 3);
            // Nothing shows yet that the second time was the last.
            let again = last.since(one.begin).zip(rest).is_some_and(|(apart, rest)| rest < apart);
            if one.repeats.count + 1 == GOES_ON && again {
                one.clue.unsettled = true;
            } else if one.repeats.count < GOES_ON || !goes_on {
                one.ends(last);
            }
        }
        for (place, ends) in self.open.drain(..) {
            if let Some(one) = scene.ledger.get_mut(place)
                && ends == Ends::Pdo
            {
                one.clue.least = 1;
            }
            if let Some(one) = scene.ledger.get_mut(place)
                && ends == Ends::Operational
                && end.since(one.repeats.since).is_some_and(|rest| rest >= NO_LONGER_NS)
            {
                let last = one.repeats.since;
                one.ends(last);
            }
        }
        for one in scene.ledger.all.iter_mut().filter(|one| one.kind.is(KindRole::MissingPdo) && one.clue.least > 1) {
            let limit = one.ns("limit").or_else(|| one.ns("period")).or(one.clue.sync.map(|(_, period)| period));
            if limit.is_some_and(|limit| one.repeats.longest_ns > limit * MISSING) {
                one.clue.least = 1;
            }
        }
    }
}

/// Makes one problem of several nodes that began, and ended or did not, within a time of each other: a master that
/// stops guarding them, or a segment that does not answer it.
fn together(role: KindRole, within: fn(&Problem) -> Ns, scene: &mut Scene<'_>) {
    let mut first: Option<(LedgerPlace, FrameRef, Option<FrameRef>)> = None;
    for place in 0..scene.ledger.all.len() {
        let of_role = |one: &&Problem| one.kind.is(role) && !one.merged && one.bus == scene.id;
        let Some(one) = scene.ledger.get(place).filter(of_role) else { continue };
        let near = |at: FrameRef, other: FrameRef| at.since(other).is_some_and(|ns| ns.abs() <= within(one));
        let ends = |other: Option<FrameRef>| match (one.end, other) {
            (Some(end), Some(other)) => near(end, other),
            (end, other) => end.is_none() && other.is_none(),
        };
        match first {
            Some((into, begin, end)) if near(one.begin, begin) && ends(end) => scene.ledger.merge(place, into),
            _ => first = Some((place, one.begin, one.end)),
        }
    }
}

/// Returns true if a SYNC has the length that is due in the problem: with a counter or without, as 1019h or those before.
fn is_due(one: &Problem, length: u64) -> bool {
    match (one.get("overflow"), one.get("expected")) {
        (Some(Quantity::Count(overflow)), _) => length == u64::from(overflow != 0),
        (None, Some(Quantity::Count(expected))) => length == expected,
        _ => length <= 1,
    }
}

/// Returns true unless a finding is about another SRDO than a problem, or, of one that stands for many rules, is of another
/// rule or says something else.
fn says_same(one: &Problem, finding: &Finding) -> bool {
    let sentence = |measured: Option<Measured>| measured.map(|measured| measured.variant.words.en);
    let code = one.findings.first().is_none_or(|cited| cited.code == finding.code);
    let srdo = one.get("srdo") == finding.measured().and_then(|all| all.get("srdo"));
    srdo && (!one.kind.is(KindRole::OneRule) || code && sentence(one.measured) == sentence(finding.measured()))
}

/// Returns true if a finding says that a period is again what it was before a problem, or what it should be.
fn is_former(one: &Problem, finding: &Finding) -> bool {
    let now = |name: &str| finding.measured().and_then(|all| all.get(name));
    let period = |[before, after]: [&str; 2]| match (one.get(before), now(after)) {
        (Some(Quantity::Ns(from)), Some(Quantity::Ns(to))) => (from - to).abs() <= from / SAME_PERIOD,
        (Some(before), Some(now)) => before == now,
        _ => false,
    };
    period(["from", "to"]) || period(["expected", "to"]) || period(["expected", "period"])
}

/// Records that the unanswered request of a problem was answered later.
fn answered_late(one: &mut Problem, finding: &Finding) {
    one.kind = ProblemKind::LateAnswer;
    let waited = one.clue.given_up.and_then(|at| at.since(one.begin));
    for (name, ns) in [("delay", finding.at.since(one.begin)), ("waited", waited)] {
        if let Some(ns) = ns {
            one.fact(name, Quantity::Ns(ns));
        }
    }
    one.ends(finding.at);
}

/// Returns the frame number of the last write to the node of a finding.
fn written(finding: &Finding, scene: &Scene<'_>) -> Option<u64> {
    Some(scene.heard.noted(Last::Written, finding.node?)?.no)
}

/// Returns the number of times in a finding; without a single gap the problem is lasting.
fn times(finding: &Finding, least: u64) -> u64 {
    let Some(measured) = finding.measured() else { return finding.facts.count().max(1) };
    let counted = measured.facts().find_map(|(name, value)| match value {
        Quantity::Count(count) if matches!(name, "count" | "missing") => Some(count),
        _ => None,
    });
    // These count error frames, and what is missing in one gap.
    if matches!(finding.code, Code::Bus001 | Code::Bus002 | Code::Bus003) {
        return 1;
    }
    match finding.code {
        Code::Syn003 if measured.get("gap").is_none() => least,
        Code::Syn003 => 1,
        _ => counted.unwrap_or(1).max(1),
    }
}

/// Returns true if a frame that was due never came before the one that a finding is about.
fn lacks(finding: &Finding) -> bool {
    let Some(measured) = finding.measured() else { return false };
    let ns = |name: &str| match measured.get(name) {
        Some(Quantity::Ns(ns)) => Some(ns),
        _ => None,
    };
    match finding.code {
        Code::Syn003 => matches!(measured.get("missing"), Some(Quantity::Count(1..))),
        // The first one behind a write of its time has no period before it.
        Code::Hbt001 if finding.cause.is_some() => false,
        Code::Hbt001 => ns("found").zip(ns("expected")).is_some_and(|(found, period)| found >= 2 * period - period / 4),
        Code::Pdo005 => ns("found").zip(ns("limit")).is_some_and(|(found, limit)| found / 2 >= limit),
        _ => false,
    }
}

/// Returns a word that the sentence of a finding always has, by its name in machine output.
pub(super) fn constant(finding: &Finding, wanted: &str) -> Option<&'static str> {
    let measured = finding.measured()?;
    let (_, value) = measured.variant.constants.iter().find(|(name, _)| *name == wanted)?;
    Some(value.trim_matches('"'))
}
