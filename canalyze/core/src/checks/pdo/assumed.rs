//! Whether frames bear out a mapping that is only assumed: the default of an EDS.
//!
//! A device may have stored another mapping. A frame that is shorter than the default is not of it. What follows behind it
//! is padding as long as it is one and the same byte throughout: some devices fill their PDOs up. Other bytes there, or a
//! change, are of an object that the default does not have. What the capture, a DCF or an option shows needs no bearing out. It must not judge whose
//! fault a difference is.

use std::collections::BTreeMap;

use super::length::misfit;
use crate::configuration::Provenance;
use crate::event::Signals;
use crate::frame::Frame;

/// What came behind the assumed mappings of PDOs, by node, direction and number.
#[derive(Debug, Default)]
pub struct Assumed {
    behind: BTreeMap<(u8, bool, u16), Behind>,
}

/// What came behind a mapping.
#[derive(Debug)]
enum Behind {
    /// This byte, each time.
    Padding(u8),
    /// Other bytes, or bytes that changed.
    Data,
}

impl Assumed {
    /// Whether a frame of a node's PDO, or one before it, contradicts the mapping that it is assumed to have.
    #[inline]
    pub fn contradicts(&mut self, name: (u8, bool, u16), content: &Signals, frame: &Frame) -> bool {
        let (mapping, own) = match content {
            Signals::Mapped(mapping, Provenance::Eds) => (mapping, true),
            Signals::ByConsumer(mapping, Provenance::Eds, ..) => (mapping, false),
            _ => return false,
        };
        if misfit(content, frame).is_none() {
            return false;
        }
        let Some(beyond) = frame.payload().get(mapping.bytes()..) else { return true };
        // A receiver may take less than all of it.
        own && self.is_data(name, beyond)
    }

    /// Whether what is behind a mapping is no padding, by now.
    fn is_data(&mut self, name: (u8, bool, u16), beyond: &[u8]) -> bool {
        let Some(first) = beyond.first() else { return false };
        let behind = self.behind.entry(name).or_insert(Behind::Padding(*first));
        if let Behind::Padding(filler) = *behind
            && beyond.iter().any(|byte| *byte != filler)
        {
            *behind = Behind::Data;
        }
        matches!(behind, Behind::Data)
    }
}
