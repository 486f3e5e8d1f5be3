//! The object that stands under a service's name in a frame's JSON line, for every service but SDO.
//!
//! Keys are only ever added, never renamed. It must not decide anything.

use super::object::Object;
use super::{NAMES, marked, quoted};
use crate::bytes::frame::Frame;
use crate::tables::number::{self, EntryBits};
use crate::wire;
use crate::wire::message::Message;
use crate::wire::pdo;
use crate::wire::pdo::Multiplexed;
use crate::wire::pdo::mapping::Mapping;
use crate::words::digits::put;
use crate::words::{Lang, escape, signal};
use crate::world::event::Addressed;
use crate::world::od::DataType;

/// Appends `{...}`: the fields of a message, without what the frame's line already says (node, data).
///
/// Hexadecimal numbers are upper-case strings without prefix, bytes hexadecimal strings, other numbers decimal.
/// Words marked (w) are those of the standard in English, but for `text`, which is in the chosen language.
///
/// | service | keys |
/// |---|---|
/// | `nmt` | `command` hex, `name` (w) or null, `target` node-ID, 0 = all |
/// | `gfc` | none |
/// | `flying_master` | `kind` 1-6, `priority`, `master` node-ID (both null but for kind 1) |
/// | `sync` | `counter` or null |
/// | `time` | `ms`, `days`, `reserved` hex, `date` YYYY-MM-DD, `time_of_day` HH:MM:SS.mmm or null beyond a day |
/// | `emcy` | `code` hex, `name` (w) or null, `register` hex, `register_bits` list of bit numbers, `manufacturer` bytes, `active` list of the node's error codes (hex) after it as far as the capture shows them, `cleared` list of those that it takes back |
/// | `pdo` | `direction` transmit/receive, `number`, `remote`, `communication_parameter` and `mapping_parameter` hex, and for a multiplex PDO `mpdo`: `mode` dam/sam, `node`, `index` hex, `sub`, `data` bytes, and what is known of the object: `name` (w), `type`, `value` with sign, type and factor applied, `unit`, `text` (w) the value in words, each null where it is not known |
/// | `srdo` | `number`, `inverted`, `valid`: whether it is the inverse of the normal data before it, null where that is not known |
/// | `heartbeat` | `state` hex, `name` (w) or null, `boot_up`, and unless it is one `previous` state (hex) shown since the last boot-up or null, `changed` |
/// | `guarding` | `request`, and for an answer `state` hex, `name` (w) or null, `toggle` 0/1, `previous`, `changed` |
/// | `lss` | `from` master/slave, `command` hex, and by command: `mode`, `part`, `bound`, `value` hex, `new_node`, `node`, `selector`, `index`, `kbit_s`, `delay_ms`, `confirms`, `error`, `error_name` (w), `specific`, `id_number` hex, `bit_check` hex, `lss_sub`, `lss_next` |
/// | `usdo` | `request`, `destination`, `command` hex, `name` (w) or null, `remote_network`, `session`, and where an object is named `index` hex, `sub`, `type`, `size`, `abort` hex, `abort_name` (w), `data` bytes |
/// | `error` | `class` hex, `classes` (w) list, `arbitration_bit`, `controller` hex, `protocol` hex, `location` hex, `transceiver` hex (each null unless its class is set), `tx_errors`, `rx_errors` or null |
/// | `foreign` | `reason` reserved/unassigned/dynamic_sdo/extended |
/// | any, malformed | `malformed` length/remote/fd, and for length `least`, `most` in bytes |
pub fn fields(out: &mut Vec<u8>, message: &Message, frame: &Frame) {
    let mut object = Object::open(out);
    match *message {
        Message::Pdo { transmit, number, .. } => process_data(&mut object, transmit, number, false),
        Message::PdoRequest { transmit, number, .. } => process_data(&mut object, transmit, number, true),
        Message::Mpdo { transmit, number, content, .. } => {
            process_data(&mut object, transmit, number, false);
            addressed(&mut object, NAMES, &content, &Mapping::default(), frame);
        }
        _ => wire::json(&mut object, message, frame),
    }
    object.close();
}

fn process_data(object: &mut Object<'_>, transmit: bool, number: u16, remote: bool) {
    object.word("direction", if transmit { "transmit" } else { "receive" });
    object.number("number", number);
    object.flag("remote", remote);
    object.hex::<4>("communication_parameter", u64::from(pdo::communication_parameter(transmit, number)));
    object.hex::<4>("mapping_parameter", u64::from(pdo::mapping_parameter(transmit, number)));
}

/// The same for a multiplex PDO of whose object something is known.
pub(in crate::tables) fn multiplexed(out: &mut Vec<u8>, lang: Lang, data: &Addressed, frame: &Frame) {
    let mut object = Object::open(out);
    process_data(&mut object, data.transmit, data.number, false);
    addressed(&mut object, lang, &data.content, &data.mapping, frame);
    object.close();
}

fn addressed(object: &mut Object<'_>, lang: Lang, content: &Multiplexed, mapping: &Mapping, frame: &Frame) {
    let mut inner = Object::open(object.key("mpdo"));
    inner.word("mode", if content.destination { "dam" } else { "sam" });
    inner.number("node", content.node);
    inner.hex::<4>("index", u64::from(content.index));
    inner.number("sub", content.sub);
    inner.bytes("data", &content.data);
    let known = mapping.entries.first();
    match known.filter(|mapped| signal::has_name(NAMES, mapped)) {
        Some(mapped) => quoted(inner.key("name"), |text| signal::name(text, NAMES, mapped)),
        None => put!(inner.key("name"); "null"),
    }
    let whole = known.filter(|mapped| mapped.is_whole());
    inner.optional("type", whole.and_then(|mapped| mapped.data_type).map(DataType::name));
    match whole {
        Some(mapped) => {
            marked(inner.key("value"), |out| number::value(out, EntryBits::new(mapping, mapped, frame.payload())))
        }
        None => put!(inner.key("value"); "null"),
    }
    match known.and_then(|mapped| mapped.unit.as_deref()) {
        Some(unit) => escape::json(inner.key("unit"), unit.as_bytes()),
        None => put!(inner.key("unit"); "null"),
    }
    match whole.and_then(|mapped| Some((mapped, mapping.raw(mapped, frame.payload())?))) {
        Some((mapped, raw)) => quoted(inner.key("text"), |text| signal::value(text, lang, mapped, raw)),
        None => put!(inner.key("text"); "null"),
    }
    inner.close();
}
