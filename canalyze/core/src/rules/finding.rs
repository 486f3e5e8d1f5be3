//! Findings: facts at a frame that an engineer should know. Rules, their facts and their words are in `rules`.

use std::sync::Arc;

pub use crate::rules::{
    Code, CrcMatch, Deviation, Facts, Measured, NamedProblem, Quantity, Said, Severity, Unmet, Verdict,
};

use crate::bytes::frame::{BusId, FrameRef};
use crate::sdo::wire::Mux;

/// A fact at a frame that an engineer should know.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The rule.
    pub code: Code,
    /// The frame that shows it. A finding that becomes known later is at the frame that proves it.
    pub at: FrameRef,
    /// The earlier frame that it is about, if any.
    pub cause: Option<FrameRef>,
    /// The bus.
    pub bus: BusId,
    /// The node, if it is about one.
    pub node: Option<u8>,
    /// The object, if it is about one.
    pub object: Option<Mux>,
    /// The measured facts.
    pub facts: Facts,
    /// The frame of the event, or of the finding, that explains it: it is a consequence of that, not a fault by itself.
    pub because_of: Option<FrameRef>,
}

impl Finding {
    /// Returns the frame that it is about: the one that shows it, or an earlier one.
    pub fn about(&self) -> Option<FrameRef> {
        let earlier = self.cause.filter(|_| !self.code.rule().about_here);
        Some(earlier.unwrap_or(self.at)).filter(|about| about.no > 0)
    }

    /// Returns its severity: that of its rule, but info for a consequence.
    pub fn severity(&self) -> Severity {
        if self.because_of.is_some() { Severity::Info } else { self.code.rule().severity }
    }

    /// Returns the expectation that it is about, `boot.expect.toml:12`, if any.
    pub fn expectation(&self) -> Option<&Arc<str>> {
        if let Facts::Unmet(unmet) = &self.facts { Some(&unmet.expectation) } else { None }
    }

    /// Returns the variant of its rule with the measured facts; `None` if it has no facts, is about an expectation, or
    /// only counts further ones.
    pub fn measured(&self) -> Option<Measured> {
        if let Facts::Measured(measured) = self.facts { Some(measured) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_consequence_is_only_worth_knowing() {
        let (at, facts) = (FrameRef::default(), Facts::None);
        let raised = Finding {
            code: Code::Hbt002,
            at,
            cause: None,
            bus: BusId(0),
            node: Some(5),
            object: None,
            facts,
            because_of: None,
        };
        assert_eq!(raised.severity(), Severity::Error);
        assert_eq!(Finding { because_of: Some(at), ..raised }.severity(), Severity::Info);
    }
}
