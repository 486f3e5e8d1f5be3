//! Compares frames with an assumed mapping, the default of an EDS.
//!
//! A device may have stored another mapping. A frame shorter than the default contradicts it. Additional bytes are
//! padding if they are one constant value, as in devices that fill up their PDOs; other or changing bytes are objects
//! that the default lacks. Mappings from the capture, a DCF or an option are not examined.

use crate::bytes::frame::Frame;
use crate::checks::PdoName;
use crate::world::configuration::Provenance;
use crate::world::event::Signals;
use crate::world::node::{PerNode, PerPdo};

/// The bytes behind the assumed mappings of PDOs.
#[derive(Debug, Default)]
pub struct Assumed {
    behind: PerNode<PerPdo<Option<BehindMapping>>>,
}

/// The bytes behind a mapping.
#[derive(Debug)]
enum BehindMapping {
    /// This byte in all frames.
    Padding(u8),
    /// Other or changing bytes.
    Data,
}

impl Assumed {
    /// Returns true if a frame of another length than its mapping, or an earlier one of the PDO, contradicts the mapping as
    /// assumed.
    #[inline]
    pub fn contradicts(&mut self, name: PdoName, content: &Signals, frame: &Frame) -> bool {
        let (mapping, own) = match content {
            Signals::Mapped(mapping, Provenance::Eds | Provenance::Profile) => (mapping, true),
            Signals::ByConsumer(mapping, Provenance::Eds | Provenance::Profile, ..) => (mapping, false),
            _ => return false,
        };
        let Some(beyond) = frame.payload().get(mapping.bytes()..) else { return true };
        // A receiver may use a part of it.
        own && self.is_data(name, beyond)
    }

    /// Returns true if the bytes behind a mapping are data, not padding.
    fn is_data(&mut self, PdoName { transmit, number, node }: PdoName, beyond: &[u8]) -> bool {
        let Some(first) = beyond.first() else { return false };
        let behind = self.behind.entry(node).entry(transmit, number).get_or_insert(BehindMapping::Padding(*first));
        if let BehindMapping::Padding(filler) = *behind
            && beyond.iter().any(|byte| *byte != filler)
        {
            *behind = BehindMapping::Data;
        }
        matches!(behind, BehindMapping::Data)
    }
}
