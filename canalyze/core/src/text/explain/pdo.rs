//! The breakdown of a PDO: COB-ID, parameters, and each mapped object bit by bit.

use super::{cob_id, data};
use crate::cob_id::Role;
use crate::event::{ProcessData, Signals};
use crate::frame::Frame;
use crate::text::Lang;

/// Appends the breakdown of a PDO with data.
pub fn process_data(out: &mut Vec<u8>, lang: Lang, pdo: &ProcessData, frame: &Frame) {
    let (number, node) = (pdo.number, pdo.node);
    cob_id(out, lang, if pdo.transmit { Role::Tpdo { number, node } } else { Role::Rpdo { number, node } }, frame);
    super::services::parameters(out, lang, pdo.transmit, number);
    match &pdo.content {
        Signals::Mapped(..) | Signals::ByConsumer(..) | Signals::None(_) => data(out, lang, frame.payload()),
    }
}
