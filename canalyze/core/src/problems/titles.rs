//! The title line of a problem: the first title in the row of its kind whose conditions hold and whose facts are known.

use super::advice::hold;
use super::problem::Problem;
use super::roles::KindRole;
use super::sayings::title;
use super::signs::{Titles, When};
use crate::bytes::ns::Ns;
use crate::rules::finding::Quantity;
use crate::rules::{Measured, Variant};

/// The titles of kinds whose row has none.
const OTHERS: Titles = &[
    (&[When::Reported, When::Often], &title::ReportedOften),
    (&[When::Reported, When::Ended], &title::ReportedWithOver),
    (&[When::Reported, When::Ended], &title::ReportedOver),
    (&[When::Reported], &title::ReportedWith),
    (&[When::Reported], &title::Reported),
    (&[When::Has("unseen")], &title::AbortedUnseen),
    (&[When::Has("client_aborted")], &title::ClientAborted),
    (&[When::Has("client_aborted")], &title::ClientAbortedUnseen),
    (&[When::Timed, When::Over, When::Has("booted")], &title::Refused),
    (&[When::Timed, When::Over, When::Has("others")], &title::RefusedOthers),
    (&[When::Timed, When::Over], &title::RefusedMadeGood),
    (&[When::Timed], &title::Refused),
    (&[When::Often], &title::Times),
    (&[When::AtOnce], &title::At),
    (&[When::Ended], &title::FromTo),
    (&[], &title::Since),
    (&[], &title::ReportedOnce),
    (&[], &title::Refused),
];
/// The titles behind the words of the kind; others name the kind by themselves.
const BEHIND: [&Variant; 6] = [&title::Since, &title::FromTo, &title::At, &title::Times, &title::PdoOf, &title::OfPdo];

/// Returns the line, and true if it names the kind by itself; `None` if the words of the kind suffice. `began_ns`: the
/// first stamp of the capture.
pub fn of(one: &Problem, began_ns: Option<Ns>) -> Option<(Measured, bool)> {
    // A clock that was set back since has no time of the capture's beginning.
    let since = |t_ns: Option<Ns>| t_ns.zip(began_ns).map_or(Ns::ZERO, |(at, began)| at - began);
    let at = one.begin.t_ns.map(|_| since(one.begin.listed().t_ns)).filter(|at| *at >= Ns::ZERO);
    let known = |name: &str| fact(one, name, at);
    let own = one.kind.row().titles;
    let titles = if own.is_empty() { OTHERS } else { own };
    let fitting = titles.iter().filter(|(when, _)| hold(when, one, at.is_some()));
    let line = fitting.map(|(_, title)| *title).find_map(|title| Measured::filled(title, known))?;
    let of_pdo = at.is_none() && one.kind.is(KindRole::WrongLength);
    Some((line, !of_pdo && !BEHIND.contains(&line.variant)))
}

/// Returns a fact of a title. `at`: the time of its beginning from that of the capture.
fn fact(one: &Problem, name: &str, at: Option<Ns>) -> Option<Quantity> {
    let lasts = || one.end.and_then(|end| end.since(one.begin));
    match name {
        "at" => at.map(Quantity::Ns),
        "count" => Some(Quantity::Count(one.repeats.count)),
        "nodes" => Some(Quantity::Count(one.subject.nodes.count_ones().into())),
        "further" => {
            let Some(Quantity::Emcy(first, profile)) = one.get("code") else { return None };
            let further = one.clue.reported.iter().find(|code| **code != first)?;
            Some(Quantity::Emcy(*further, profile))
        }
        "pdo" => one.subject.pdo.map(|(transmit, number)| Quantity::Pdo(transmit, number)),
        "heard" | "until" => {
            lasts().filter(|lasts| *lasts > Ns::ZERO).and_then(|lasts| Some(Quantity::Ns(at? + lasts)))
        }
        "lasts" => lasts().filter(|lasts| one.repeats.count == 1 && *lasts > Ns::ZERO).map(Quantity::Ns),
        "silence" if one.kind.is(KindRole::AloneSilent) && one.end.is_some() && !one.has(name) => {
            Some(Quantity::Ns(lasts().unwrap_or(Ns::ZERO)))
        }
        _ => one.get(name),
    }
}
