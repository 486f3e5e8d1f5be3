//! Findings in words, in both languages. The sentences are declared with their rules.

use std::collections::BTreeMap;

use super::digits::put;
use super::{Lang, escape, object, say, sentence};
use crate::rules::finding::{Code, Facts, Finding, Measured, Said, Severity};

/// Returns the word for a severity.
pub fn severity(lang: Lang, severity: Severity) -> &'static str {
    let zh = match severity {
        Severity::Info => "提示",
        Severity::Warning => "警告",
        Severity::Error => "错误",
    };
    lang.pick(zh, severity.name())
}

/// Appends the number of consequences of a frame, with their rules.
pub fn consequences(out: &mut Vec<u8>, lang: Lang, cause: u64, rules: &BTreeMap<Code, u64>) {
    let count: u64 = rules.values().sum();
    let many = if count == 1 { " consequence: " } else { " consequences: " };
    say!(out, lang; zh: "第", cause, "帧: ", count, "条后果: "; en: "frame ", cause, ": ", count, many);
    for (place, (code, count)) in rules.iter().enumerate() {
        put!(out; if place > 0 { "; " } else { "" }, code.rule().id, " ", lang.of(code.rule().message));
        if *count > 1 {
            put!(out; " (", *count, ")");
        }
    }
}

/// Appends a finding, in one sentence without line end, that is read at the frame `seen_at`: if it is about
/// another frame, that is named first.
pub fn placed(out: &mut Vec<u8>, lang: Lang, finding: &Finding, seen_at: u64) {
    if let Some(frame) = finding.about().filter(|about| about.no != seen_at) {
        let after = if finding.node.is_some() { " " } else { ": " };
        say!(out, lang; zh: "第", frame.no, "帧", after; en: "frame ", frame.no, after);
    }
    message(out, lang, finding);
}

/// Appends the statement of a finding about its frame, in one sentence without line end.
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

/// Appends node and object of a finding. An object that is part of the sentence is not repeated.
fn subject(out: &mut Vec<u8>, lang: Lang, finding: &Finding, measured: Option<&Measured>) {
    if let Some(node) = finding.node {
        put!(out; lang.pick("节点", "node "), node, " ");
    }
    object::before(out, finding.object, measured);
    if finding.node.is_some() {
        out.pop();
        put!(out; ": ");
    }
}

fn repeated(out: &mut Vec<u8>, lang: Lang, count: u64) {
    say!(out, lang; zh: "同类问题另有", count, "次"; en: count, " more of the same");
}
