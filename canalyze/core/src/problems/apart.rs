//! Facts that distinguish the possible causes of a problem.
//!
//! Each line is a fact of this capture, or a question that it leaves open, with the way to answer it.

use super::advice::AdviceFacts;
use super::causes::within;
use super::ledger::Ledger;
use super::problem::{Grade, Problem};
use super::roles::{Apart, KindRole};
use crate::bytes::ns::Ns;
use crate::rules::Words;
use crate::rules::finding::Quantity;

/// Maximum distance of losses that belong together, in ns.
const TOGETHER_NS: Ns = Ns::from_ms(100);
/// Maximum time before a problem within which an earlier one belongs to it, in ns.
const BEFORE_NS: Ns = Ns::from_s(2);
/// Minimum number of nodes on a bus for the loss of a single one to exclude a shared cause.
const ENOUGH: u32 = 3;
/// Maximum distance of error frames around a problem, in ns.
const AROUND_NS: Ns = Ns::from_s(1);

/// One line.
#[derive(Clone, Copy, Debug)]
pub struct Tell {
    /// True for a fact of the capture, false for an open question.
    pub told: bool,
    /// The text for people.
    pub words: Words,
}

macro_rules! tells {
    ($($(#[$doc:meta])* $name:ident $told:literal $zh:literal $en:literal;)*) => {
        $(const $name: Tell = Tell { told: $told, words: Words { zh: $zh, en: $en } };)*
    };
}

include!(concat!(env!("OUT_DIR"), "/tells.rs"));

/// Returns the facts for a problem; none for other kinds.
pub fn of(one: &Problem, ledger: &Ledger, shown: AdviceFacts) -> Vec<Tell> {
    match one.kind.row().apart {
        Apart::Loss => {
            let others = others(one, ledger, shown);
            [back(one)].into_iter().chain(others).chain([warned(one, ledger), noise(one, ledger, shown)]).collect()
        }
        // The node may have sent other frames all the time.
        Apart::NoAnswer => vec![warned(one, ledger), noise(one, ledger, shown)],
        Apart::Absence if one.has("boot_up") => Vec::new(),
        Apart::Absence => {
            vec![if one.end.is_some() { HEARD_LATER } else { NEVER_HEARD }, noise(one, ledger, shown)]
        }
        Apart::OtherFrames => vec![GOES_ON, warned(one, ledger)],
        Apart::Error => {
            let named = match (one.clue.reported.is_empty(), one.has("error_code")) {
                (false, _) => NAMED,
                (true, true) => READ,
                (true, false) => UNNAMED,
            };
            let mut tells = vec![named];
            let lost = lost(one, ledger);
            // Reactions to one loss come together and need have nothing else in common.
            let reacts = lost.is_some_and(|tell| tell.words.en == COMMUNICATION.words.en);
            if !reacts && (one.subject.axis.is_some() || one.subject.axes != 0) {
                let many = one.subject.axes.count_ones() > 1 || one.subject.nodes.count_ones() > 1;
                tells.push(if many { AXES } else { ONE_AXIS });
            }
            tells.extend(lost);
            tells
        }
        Apart::Report => match one.cause.and_then(|link| ledger.by_id(link.cause)) {
            Some(cause) => vec![limit(one, cause)],
            None => Vec::new(),
        },
        Apart::Presence => presence(one, ledger).into_iter().collect(),
        Apart::Refusal if one.has("refused") => vec![match one.end.filter(|_| !one.has("booted")) {
            Some(_) if one.has("others") => OTHER_VALUES,
            Some(_) => MADE_GOOD,
            // Most abort codes say why.
            None if says_why(one) => return Vec::new(),
            None => NOT_MADE_GOOD,
        }],
        Apart::Refusal => Vec::new(),
    }
}

/// Returns true if the abort code of a refused write tells an unsupported value or object from a wrong state.
fn says_why(one: &Problem) -> bool {
    let Some(Quantity::Abort(code)) = one.get("abort") else { return false };
    let meaning = code.meaning();
    let general = matches!(meaning, 0 | 0x0604_0043 | 0x0604_0047 | 0x0800_0000 | 0x0800_0020);
    !general && !code.is_violation() || code.is_busy()
}

fn back(one: &Problem) -> Tell {
    match one.kind {
        kind if kind.is(KindRole::Booted) => BOOTED,
        _ if one.has("boot_up") => BOOTED,
        _ if one.is_back() => RETURNED,
        _ => AWAY,
    }
}

/// Returns the line on the time that a consumer waits, compared with the time that passed.
fn limit(one: &Problem, cause: &Problem) -> Tell {
    let delay = one.cause.and_then(|link| link.delay_ns);
    let limit = one.clue.watched.iter().find(|(node, _)| cause.subject.concerns(*node));
    match limit.zip(delay) {
        Some(((_, limit), delay)) if within(cause, *limit).contains(&delay) => LIMIT_KNOWN,
        Some(_) => LIMIT_DIFFERS,
        None => LIMIT_UNKNOWN,
    }
}

/// Returns the line on other nodes lost with it; `None` if there are too few others to tell.
fn others(one: &Problem, ledger: &Ledger, shown: AdviceFacts) -> Option<Tell> {
    let with = |other: &Problem| {
        let silent = other.kind.is(KindRole::Falls);
        silent
            && other.id != one.id
            && other.subject.nodes & !one.subject.nodes != 0
            && is_near(one, other, TOGETHER_NS)
    };
    if one.subject.nodes.count_ones() > 1 || ledger.told().any(with) {
        return Some(WITH_OTHERS);
    }
    (shown.nodes >= ENOUGH).then_some(ALONE)
}

/// Returns the line on errors reported by the node before.
fn warned(one: &Problem, ledger: &Ledger) -> Tell {
    let reported = |other: &Problem| {
        let before = one.begin.since(other.begin).is_some_and(|since| (Ns::ZERO..=BEFORE_NS).contains(&since));
        other.id != one.id && other.subject.nodes & one.subject.nodes != 0 && !other.clue.reported.is_empty() && before
    };
    if ledger.told().any(reported) { WARNED } else { NO_WARNING }
}

fn noise(one: &Problem, ledger: &Ledger, shown: AdviceFacts) -> Tell {
    let around = |other: &Problem| {
        let errors = other.kind.is(KindRole::Noise);
        errors && is_near(one, other, AROUND_NS)
    };
    match (ledger.told().any(around), shown.error_frames) {
        (true, _) => NOISE,
        (false, true) => QUIET,
        (false, false) => NO_ERROR_FRAMES,
    }
}

fn is_near(one: &Problem, other: &Problem, ns: Ns) -> bool {
    one.bus == other.bus && one.begin.since(other.begin).is_some_and(|since| since.abs() <= ns)
}

/// Returns the line on a loss of communication before it; `None` if that may be chance.
fn lost(one: &Problem, ledger: &Ledger) -> Option<Tell> {
    let before = |other: &Problem| {
        let since = one.begin.since(other.begin);
        other.id != one.id
            && other.kind.is(KindRole::CommunicationLost)
            && since.is_none_or(|since| (Ns::ZERO..=BEFORE_NS).contains(&since))
    };
    if cause(one, ledger).is_some_and(|cause| cause.kind.is(KindRole::CommunicationLost)) {
        return Some(COMMUNICATION);
    }
    (!ledger.told().any(before)).then_some(NO_LOSS)
}

/// Returns the line on the presence of the node; `None` if nothing shows it, or if it was silent at another time.
fn presence(one: &Problem, ledger: &Ledger) -> Option<Tell> {
    let silent =
        |other: &Problem| other.kind.is(KindRole::CommunicationLost) && other.subject.nodes & one.subject.nodes != 0;
    if let Some(cause) = cause(one, ledger).filter(|cause| silent(cause)) {
        let commanded = cause.kind.is(KindRole::Commanded);
        return Some(if commanded { STOPPED } else { GONE });
    }
    (one.has("heard_meanwhile") && !ledger.told().any(silent)).then_some(PRESENT)
}

/// Returns its cause, if that is more than possible.
fn cause<'a>(one: &Problem, ledger: &'a Ledger) -> Option<&'a Problem> {
    ledger.by_id(one.cause.filter(|link| link.grade >= Grade::Likely)?.cause)
}
