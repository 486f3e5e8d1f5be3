//! Findings: what an engineer should know, at a frame.
//!
//! Rules, what they measure and their words stand in `rules`.

use std::sync::Arc;

pub use crate::rules::{Code, CrcMatch, Deviation, Facts, Measured, Problem, Quantity, Said, Severity, Unmet, Verdict};

use crate::bytes::frame::{BusId, FrameRef};
use crate::sdo::wire::Mux;

/// Something an engineer should know, at a frame.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The rule.
    pub code: Code,
    /// The frame that shows it. What is only known later stands at the frame that proves it.
    pub at: FrameRef,
    /// The earlier frame it is about, if another.
    pub cause: Option<FrameRef>,
    /// The bus.
    pub bus: BusId,
    /// The node, where one is concerned.
    pub node: Option<u8>,
    /// The object, where one is concerned.
    pub object: Option<Mux>,
    /// What was measured.
    pub facts: Facts,
    /// The frame of the event, or of the finding, that explains it: it is a consequence of that, and no fault by itself.
    pub because_of: Option<FrameRef>,
}

impl Finding {
    /// The frame that it is about: the one that shows it, or an earlier one.
    pub fn about(&self) -> Option<FrameRef> {
        let earlier = self.cause.filter(|_| !self.code.rule().about_here);
        Some(earlier.unwrap_or(self.at)).filter(|about| about.no > 0)
    }

    /// How bad it is: as its rule says, but a consequence is only worth knowing.
    pub fn severity(&self) -> Severity {
        if self.because_of.is_some() { Severity::Info } else { self.code.rule().severity }
    }

    /// The expectation that it is about, `boot.expect.toml:12`, where it is about one.
    pub fn expectation(&self) -> Option<&Arc<str>> {
        if let Facts::Unmet(unmet) = &self.facts { Some(&unmet.expectation) } else { None }
    }

    /// The variant of the rule that it is, with what was measured; none where it has no facts, is about an expectation, or
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
