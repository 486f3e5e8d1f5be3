//! What a finding says, in both languages.
//!
//! The sentences stand with their rules. It must not choose one; the finding says which.

use std::collections::BTreeMap;

use super::digits::put;
use super::object::pdo_of;
use super::{Lang, escape, sentence};
use crate::finding::{Code, Facts, Finding, Measured, Quantity, Said, Severity};

/// The word for a severity.
pub fn severity(lang: Lang, severity: Severity) -> &'static str {
    match (lang, severity) {
        (Lang::En, _) => severity.name(),
        (Lang::Zh, Severity::Info) => "提示",
        (Lang::Zh, Severity::Warning) => "警告",
        (Lang::Zh, Severity::Error) => "错误",
    }
}

/// Appends how many consequences a frame has, and of which rules.
pub fn consequences(out: &mut Vec<u8>, lang: Lang, cause: u64, rules: &BTreeMap<Code, u64>) {
    let count: u64 = rules.values().sum();
    put!(out; lang.pick("第", "frame "), cause, lang.pick("帧: ", ": "), count);
    put!(out; lang.pick("条后果: ", if count == 1 { " consequence: " } else { " consequences: " }));
    sentence::codes(out, rules, lang.pick("、", ", "));
}

/// Appends what a finding says, in one sentence without line end, for a reader who sees it at the frame `seen_at`:
/// another frame that it is about is named before it.
pub fn placed(out: &mut Vec<u8>, lang: Lang, finding: &Finding, seen_at: u64) {
    if let Some(frame) = finding.about().filter(|about| about.no != seen_at) {
        let after = if finding.node.is_some() { " " } else { ": " };
        put!(out; lang.pick("第", "frame "), frame.no, lang.pick("帧", ""), after);
    }
    message(out, lang, finding);
}

/// Appends what a finding says of the frame that it is about, in one sentence without line end.
pub fn message(out: &mut Vec<u8>, lang: Lang, finding: &Finding) {
    let measured = finding.measured();
    subject(out, lang, finding, measured.as_ref());
    match (&finding.facts, measured) {
        (Facts::Unmet(unmet), _) => {
            let named = |name: &str| unmet.facts().find(|(known, _)| *known == name).map(|(_, said)| said.clone());
            match unmet.repeated {
                0 => sentence::fill(out, lang, lang.of(unmet.variant.words), named),
                more => repeated(out, lang, more),
            }
            put!(out; lang.pick(" (期望: ", " (expected by "));
            escape::terminal(out, unmet.expectation.as_bytes());
            put!(out; ")");
        }
        (Facts::Repeated { count }, _) => repeated(out, lang, *count),
        (_, Some(measured)) => {
            let named = |name: &str| measured.get(name).map(Said::Quantity);
            sentence::fill(out, lang, lang.of(measured.variant.words), named);
        }
        (_, None) => put!(out; lang.of(finding.code.rule().message)),
    }
}

/// Node and object that a finding is about. An object that the sentence names is not named before it.
fn subject(out: &mut Vec<u8>, lang: Lang, finding: &Finding, measured: Option<&Measured>) {
    if let Some(node) = finding.node {
        put!(out; lang.pick("节点", "node "), node, " ");
    }
    let named = measured.is_some_and(|all| all.facts().any(|(_, fact)| matches!(fact, Quantity::Object(_))));
    if let Some(object) = finding.object.filter(|_| !named) {
        put!(out; object);
        pdo_of(out, object);
        put!(out; " ");
    }
    if finding.node.is_some() {
        out.pop();
        put!(out; ": ");
    }
}

fn repeated(out: &mut Vec<u8>, lang: Lang, count: u64) {
    put!(out; lang.pick("同样的情况另有", ""), count, lang.pick("次", " more of the same"));
}
