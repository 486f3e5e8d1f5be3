//! Whether a PDO is as long as its mapping (CiA 301, 7.5.2.36 and 7.5.2.38).
//!
//! A receiver does not process a PDO that is shorter than its mapping, and ignores what is beyond it. Only a mapping
//! that the capture, an option or a DCF shows is trusted: against an EDS the device may have been configured before the
//! capture began. It must not judge whose fault the difference is.

use crate::configuration::Provenance;
use crate::context::Context;
use crate::event::Signals;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::{Frame, Kind};
use crate::services::pdo::communication_parameter;
use crate::services::sdo::wire::Mux;

/// Lengths of a CAN FD frame beyond eight bytes: what lies between is filled up.
const FD_LENGTHS: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];
/// Most bits of a classic PDO. A longer mapping is at fault itself.
const CLASSIC_BITS: u16 = 64;
/// Frames after that with which a mapping was known that may have been under way before it.
const UNDER_WAY: u64 = 1;

/// What is known of lost frames.
#[derive(Debug, Default)]
pub struct PdoLength {
    /// Frames were lost after this one: what was observed before may no longer hold.
    lost: Option<u64>,
}

/// A PDO that is not as long as its mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Misfit {
    found: u64,
    mapped: u64,
    from: Provenance,
    /// The mapping is that of a receiver: its node-ID and RPDO.
    consumer: Option<(u8, u16)>,
}

/// Compares a frame with the mapping by which it is decoded.
pub fn misfit(content: &Signals, frame: &Frame) -> Option<Misfit> {
    let (mapping, from, consumer) = match content {
        Signals::Mapped(mapping, from) => (mapping, *from, None),
        Signals::ByConsumer(mapping, from, node, number) => (mapping, *from, Some((*node, *number))),
        Signals::None(_) => return None,
    };
    let (found, mapped) = (usize::from(frame.len), mapping.bytes());
    if found == mapped || mapped == 0 {
        return None;
    }
    match frame.kind {
        Kind::Fd { .. } if FD_LENGTHS.iter().find(|length| **length >= mapped) == Some(&found) => return None,
        Kind::Data if mapping.bits > CLASSIC_BITS => return None,
        _ => {}
    }
    Some(Misfit { found: found as u64, mapped: mapped as u64, from, consumer })
}

impl PdoLength {
    /// Raises what a frame of a node's PDO showed.
    pub fn judge(&self, transmit: bool, number: u16, node: u8, misfit: Misfit, cx: &mut Context<'_>) {
        let Misfit { found, mapped, from, consumer } = misfit;
        if let Provenance::Observed(known) = from
            && (cx.at.no <= known.saturating_add(UNDER_WAY) || self.lost.is_some_and(|lost| known <= lost))
        {
            return;
        }
        let trusted = from > Provenance::Eds;
        if !trusted && consumer.is_some() {
            return;
        }
        let code = match (trusted, found < mapped) {
            (false, _) => Code::Pdo012,
            (true, true) => Code::Pdo001,
            (true, false) => Code::Pdo006,
        };
        let object = Mux { index: communication_parameter(transmit, number), sub: 0 };
        let (consumer, pdo) = consumer.unwrap_or_default();
        let mut facts = vec![("found", Quantity::Count(found)), ("mapped", Quantity::Count(mapped))];
        if consumer != 0 {
            facts.extend([("consumer", Quantity::Count(u64::from(consumer))), ("pdo", Quantity::Pdo(false, pdo))]);
        }
        let facts = Facts::told(u8::from(consumer != 0), &facts);
        cx.find(code, Some(node), Some(object), None, facts);
    }

    /// Frames of the bus were lost.
    pub fn lost(&mut self, cx: &Context<'_>) {
        self.lost = Some(cx.at.no);
    }
}
