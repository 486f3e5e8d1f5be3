//! Values of an object as the capture shows them, one after another: as JSON lines and as CSV.
//!
//! The type is null where neither a description nor a standard has one. CSV is the same in every language. Must not:
//! decide anything.

use super::od::{ShownValue, octets, place};
use crate::sdo::wire::Mux;
use crate::tables::csv;
use crate::tables::jsonl::sdo::{abort_or_null, side};
use crate::tables::setting::{NAMES, Setting};
use crate::tables::table::{AbortDigits, Any, Bytes, Cx, Hex4, Moment, Name, Piece, Text, U8, U64, Word, table};
use crate::views::inventory::sighting::{Content, ObjectSighting, Shown};
use crate::words::digits::put;
use crate::words::{Lang, inventory, signal, terms, value};
use crate::world::od::DataType;

table! {
    /// One line per value of an object, in the order of the capture.
    /// 一行是一个对象的一个值，按记录的次序
    Values json "od_value", |cx, one: &ObjectSighting<'_>| {
        bus: Name or null = cx.setting.bus(one.bus);
        node: U8 = one.node;
        object: Piece in csv = |out: &mut Vec<u8>| place(out, one.object);
        index: Hex4 = one.object.index;
        sub: U8 = one.object.sub;
        name: Name or null = name(cx.names, one);
        r#type as "type": Word or null = type_of(one).map(DataType::name);
        /// size of the value in bits
        /// 值的位数
        bits: U64 or null = match one.content() {
            Content::None => None,
            Content::Bits(_, bits) => Some(u64::from(bits)),
            Content::Bytes(_, size) => Some(size.saturating_mul(8)),
        };
        /// what shows it: read, written, tpdo, rpdo, emcy, refused or unconfirmed
        /// 来源：read、written、tpdo、rpdo、emcy、refused、unconfirmed
        source: Word = one.source.name();
        /// value, without unit and factor
        /// 值，不带单位和系数
        value: ShownValue or null = (type_of(one), Some(one.content()));
        text: Text = |out: &mut Vec<u8>| inventory::seen(out, cx.setting.lang, one);
        data: Bytes or null = octets(Some(one.content())).as_deref();
        t: Moment or null = one.at.t_ns;
        frame: U64 = one.at.no;
        /// code of the abort, who aborted, and its meaning
        /// 中止码、中止方和中止原因
        abort: Any or null = |out: &mut Vec<u8>| abort_or_null(out, cx.setting.lang, one.aborted().map(|(_, abort)| abort));
        abort_by: Word or null in csv = one.aborted().map(|(_, abort)| side(abort.by));
        abort_code: AbortDigits or null in csv = one.aborted().map(|(_, abort)| abort.code);
    }
    csv [t, frame, bus, node, object, name, r#type, source, value, data, abort_by, abort_code]
}

/// Appends a value's JSON line. `names`: the language of names.
pub fn line(out: &mut Vec<u8>, setting: Setting<'_>, sighting: &ObjectSighting<'_>, names: Lang) {
    Values::json(out, &Cx { setting, names }, sighting);
    out.push(b'\n');
}

/// Appends the headings of CSV.
pub fn head(out: &mut Vec<u8>) {
    csv::headings(out, Values::HEADINGS);
}

/// Appends a value's row of CSV.
pub fn row(out: &mut Vec<u8>, setting: Setting<'_>, sighting: &ObjectSighting<'_>) {
    Values::csv(out, &Cx { setting, names: NAMES }, sighting);
}

/// Returns the name of the object.
fn name(names: Lang, sighting: &ObjectSighting<'_>) -> Vec<u8> {
    let mut out = Vec::new();
    match sighting.shown {
        Shown::Transfer(transfer) => {
            value::name(&mut out, names, sighting.object, &transfer.described);
            return out.trim_ascii_start().to_vec();
        }
        Shown::Bits(mapped, _) | Shown::Octets(mapped, _) if signal::has_name(names, mapped) => {
            signal::name_beside_object(&mut out, names, mapped);
        }
        Shown::Bits(..) | Shown::Octets(..) => {}
        Shown::Register(_, profile) => {
            let Mux { index, sub } = sighting.object;
            put!(&mut out; terms::object_name(names, profile, index, sub).unwrap_or(""));
        }
    }
    out
}

/// Returns the type of the value, as far as a description or a standard has one.
fn type_of(sighting: &ObjectSighting<'_>) -> Option<DataType> {
    match sighting.shown {
        Shown::Transfer(transfer) => transfer.data_type(),
        Shown::Bits(mapped, _) | Shown::Octets(mapped, _) => mapped.data_type,
        Shown::Register(..) => Some(DataType::Unsigned8),
    }
}
