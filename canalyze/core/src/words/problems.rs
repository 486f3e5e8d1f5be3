//! Problems in words, in both languages. The sentences are declared in `diagnosis`.

use super::digits::put;
use super::{Lang, object, sentence};
use crate::bytes::ns::Ns;
use crate::problems::problem::{Grade, Problem, ProblemId, members};
use crate::problems::rank::is_root;
use crate::problems::roles::KindRole;
use crate::problems::{Diagnosis, Phase, titles};
use crate::rules::Words;
use crate::rules::finding::{Measured, Said};

/// Maximum number of nodes that are named one by one.
const NAMED: usize = 6;

/// Appends the statement of a step.
pub fn said(out: &mut Vec<u8>, lang: Lang, measured: &Measured) {
    let named = |name: &str| measured.get(name).map(Said::Quantity);
    sentence::fill(out, lang, lang.of(measured.variant.words), named);
}

/// Appends the line about a problem that begins to show, whose cause has changed, or that is over.
pub fn changed(out: &mut Vec<u8>, lang: Lang, diagnosis: &Diagnosis, (phase, id): (Phase, ProblemId)) {
    let Some(one) = diagnosis.ledger().by_id(id) else { return };
    let began_ns = diagnosis.extent().1.and_then(|first| first.t_ns);
    let number = u64::from(one.number);
    match phase {
        Phase::Opened => {
            put!(out; lang.pick("# ✖ 问题", "# ✖ problem "), number, ": ");
            title(out, lang, one, began_ns);
            if !is_root(one) {
                put!(out; ", ");
                because(out, lang, diagnosis, one, began_ns);
            }
        }
        Phase::Linked => {
            put!(out; lang.pick("# ↳ 问题", "# ↳ problem "), number, ": ");
            because(out, lang, diagnosis, one, began_ns);
        }
        Phase::Ended => {
            put!(out; lang.pick("# ✔ 已恢复 ", "# ✔ ended "), number, ": ");
            title(out, lang, one, began_ns);
        }
    }
    put!(out; "\n");
}

/// Appends the cause of a problem, with its number and title; with a question mark if another cause may still be
/// found.
fn because(out: &mut Vec<u8>, lang: Lang, diagnosis: &Diagnosis, one: &Problem, began_ns: Option<Ns>) {
    let Some((link, cause)) = one.cause.and_then(|link| Some((link, diagnosis.ledger().by_id(link.cause)?))) else {
        return;
    };
    let words = match link.grade {
        Grade::Certain => lang.pick("起因是问题", "caused by "),
        _ => lang.pick("起因很可能是问题", "probably caused by "),
    };
    put!(out; words, u64::from(cause.number), if diagnosis.is_settled_by_now(one) { " (" } else { "? (" });
    title(out, lang, cause, began_ns);
    put!(out; ")");
}

/// Returns the words of the rule of a problem that stands for many rules, if it has findings of one only.
fn plain(one: &Problem) -> Option<Words> {
    let many = one.kind.is(KindRole::ManyRules);
    let first = one.findings.first().filter(|_| many)?.code;
    one.findings.iter().all(|cited| cited.code == first).then(|| first.rule().message)
}

/// Appends the subject of a problem and its statement, in one line. `began_ns`: the first timestamp of the capture.
pub fn title(out: &mut Vec<u8>, lang: Lang, one: &Problem, began_ns: Option<Ns>) {
    subject(out, lang, one);
    let words = lang.of(one.kind.row().words);
    match titles::of(one, began_ns) {
        Some((title, true)) => said(out, lang, &title),
        title => {
            match one.measured() {
                Some(measured) => {
                    object::before(out, one.object(), Some(measured));
                    said(out, lang, measured);
                }
                None => put!(out; plain(one).map_or(words, |words| lang.of(words))),
            }
            if let Some((title, _)) = title {
                put!(out; ", ");
                said(out, lang, &title);
            }
        }
    }
}

/// Appends `node 3: `, `nodes 3, 4: `; nothing if it is not about nodes.
fn subject(out: &mut Vec<u8>, lang: Lang, one: &Problem) {
    if let Some(node) = one.subject.node {
        put!(out; lang.pick("节点", "node "), node);
        let axes = (1..=8_u8).filter(|axis| one.subject.axes >> (axis - 1) & 1 != 0);
        for (place, axis) in axes.filter(|axis| *axis > 1 || one.subject.axis.is_none()).enumerate() {
            let many = one.subject.axis.is_none();
            let first = lang.pick("轴", if many { " axes " } else { " axis " });
            put!(out; if place > 0 { lang.pick("、", ", ") } else { first }, axis);
        }
        return put!(out; ": ");
    }
    let nodes: Vec<u8> = members(one.subject.nodes).collect();
    if nodes.is_empty() {
        return;
    }
    put!(out; lang.pick("节点", if nodes.len() == 1 { "node " } else { "nodes " }));
    for (place, node) in nodes.iter().take(NAMED).enumerate() {
        put!(out; if place > 0 { lang.pick("、", ", ") } else { "" }, *node);
    }
    if nodes.len() > NAMED {
        put!(out; " ...");
    }
    put!(out; ": ");
}
