//! What a finding says, in both languages.
//!
//! The sentences stand with their rules. It must not choose one; the finding says which.

use super::digits::put;
use super::{Lang, escape, sentence, value};
use crate::finding::{Facts, Finding, Measured, Quantity, Said, Severity};

/// The word for a severity.
pub fn severity(lang: Lang, severity: Severity) -> &'static str {
    match (lang, severity) {
        (Lang::En, _) => severity.name(),
        (Lang::Zh, Severity::Info) => "提示",
        (Lang::Zh, Severity::Warning) => "警告",
        (Lang::Zh, Severity::Error) => "错误",
    }
}

/// Appends the frame that shows a finding, where the finding stands under another one's line.
pub fn place(out: &mut Vec<u8>, lang: Lang, frame: Option<u64>, node: Option<u8>) {
    if let Some(frame) = frame {
        put!(out; lang.pick("第", "frame "), frame, lang.pick("帧", ""), if node.is_some() { " " } else { ": " });
    }
}

/// Appends what a finding says, in one sentence without line end.
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

/// Node, object and the earlier frame that a finding is about. An object that the sentence names is not named before it.
fn subject(out: &mut Vec<u8>, lang: Lang, finding: &Finding, measured: Option<&Measured>) {
    if let Some(node) = finding.node {
        put!(out; lang.pick("节点", "node "), node, " ");
    }
    let named = measured.is_some_and(|all| all.facts().any(|(_, fact)| matches!(fact, Quantity::Object(_))));
    if let Some(object) = finding.object.filter(|_| !named) {
        value::object(out, object);
        value::pdo_of(out, object);
        put!(out; " ");
    }
    if finding.node.is_some() {
        out.pop();
        put!(out; ": ");
    }
    if let Some(cause) = finding.cause {
        put!(out; lang.pick("第", "frame "), cause.no, lang.pick("帧: ", ": "));
    }
}

fn repeated(out: &mut Vec<u8>, lang: Lang, count: u64) {
    put!(out; lang.pick("同样的情况另有", ""), count, lang.pick("次", " more of the same"));
}
