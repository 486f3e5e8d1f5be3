//! Objects of devices by what the traffic shows of them, as JSON lines.
//!
//! | kind | keys |
//! |---|---|
//! | `od_node` | `bus node objects values further booted device_type profile vendor_id product_code revision serial device_name` |
//! | `od_object` | `bus node index sub name type type_from bits access readable writable exists value text data source t frame values varies read written tpdo rpdo emcy refused unconfirmed requested configured aborts in_force first sizes extremes first_frame last_frame` |
//! | `od_pdo` | `bus node pdo id ext frames length_min length_max` |
//! | `od_value` | `bus node index sub name type bits source value text data t frame abort` |
//!
//! A node comes before its objects, which stand in order. Its identity (1000h, 1008h, 1018h) is null as far as the
//! capture does not show it; `device_type` and the like are hexadecimal. `booted`: the capture shows a boot-up of it, and
//! no frames were lost since. `further`: how often something was seen of objects for which there is no room.
//!
//! `value` is a number, a string, a boolean, or null for bytes; without the unit and the factor that `text` has. `data`
//! are its bytes, the first 4096. `t`, `frame` and `source` are those of the last value. `access` is `rw`, `ro`, `wo`, or
//! `r` and `w` where the other one is not known; null where neither is. `exists` is false where the device says so.
//! `varies`: two values that the device gave differ, though nothing was written in between.
//! `requested` is what a write asked for to which there is no answer, `configured` `{"value","data","size","frame"}` of the
//! last write that was accepted, null where that is a command or process data. `aborts` are
//! `{"request","code","by","text","count","frame"}`. `in_force` is `{"value","text","from"}` of what the object holds by
//! all that is known, of those that decoding depends on: after a reset that need not be the last value, and all three
//! are null where nothing is known of it. `first` is `{"data","size","booted","frame"}` of what was read first where
//! nothing had written it before. `sizes` are `{"read","written"}`, each least and greatest in bytes, as far as SDO
//! transfers tell them; `extremes` the bytes of those values by SDO that are the least and the greatest by any reading of
//! them: with a sign, without, as a real. `od_pdo`, behind the nodes, is an identifier that carries a PDO, with its
//! lengths in bytes. In `od_value` the type is null where neither a description nor a standard has one. Must not: decide
//! anything.

use super::sdo::{abort_or_null, json_value, side};
use super::summary::can_id;
use super::{Setting, name_or_null, number_or_null, quoted, truth};
use crate::sdo::transfer::Direction;
use crate::sdo::wire::Mux;
use crate::views::inventory::sighting::{Content, ObjectSighting, Shown, Source};
use crate::views::inventory::{HeldValue, InForce, Inventory, NodeObjects, ObservedObject};
use crate::wire::pdo::mapping::{Number, number};
use crate::words::digits::{Hex, Joined, put};
use crate::words::{Lang, inventory, signal, terms, value};
use crate::world::od::DataType;

/// Appends all nodes, each with its objects. `names`: the language of names.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, all: &Inventory, names: Lang) {
    for ((bus, id), node) in &all.nodes {
        let whose = (setting.buses.name(*bus), *id);
        self::node(out, whose, node, all.has_booted(*bus, *id));
        for (mux, object) in &node.objects {
            self::object(out, setting, (whose, *mux), object, names);
        }
    }
    for ((bus, id), pdo) in &all.pdos {
        head(out, "od_pdo", (setting.buses.name(*bus), pdo.node));
        put!(out; ",\"pdo\":\"", if pdo.transmit { "TPDO" } else { "RPDO" }, pdo.number, "\"");
        can_id(out, *id);
        let (least, most) = pdo.lengths;
        put!(out; ",\"frames\":", pdo.frames, ",\"length_min\":", least, ",\"length_max\":", most, "}\n");
    }
}

fn head(out: &mut Vec<u8>, kind: &str, (bus, node): (&[u8], u8)) {
    put!(out; "{\"kind\":\"", kind, "\",\"bus\":");
    name_or_null(out, bus);
    put!(out; ",\"node\":", node);
}

fn node(out: &mut Vec<u8>, whose: (&[u8], u8), node: &NodeObjects, booted: bool) {
    head(out, "od_node", whose);
    let values: u64 = node.objects.values().map(ObservedObject::values).sum();
    put!(out; ",\"objects\":", node.objects.len(), ",\"values\":", values, ",\"further\":", node.further);
    put!(out; ",\"booted\":", truth(booted));
    let identity = [
        ("device_type", 0x1000, 0),
        ("vendor_id", 0x1018, 1),
        ("product_code", 0x1018, 2),
        ("revision", 0x1018, 3),
        ("serial", 0x1018, 4),
    ];
    for (key, index, sub) in identity {
        put!(out; ",\"", key, "\":");
        match node.number(index, sub) {
            Some(number) => put!(out; "\"", Hex::<8>(u64::from(number)), "\""),
            None => put!(out; "null"),
        }
    }
    let profile = node.number(0x1000, 0).map(|number| u64::from(number & 0xFFFF)).filter(|number| *number != 0);
    put!(out; ",\"profile\":");
    number_or_null(out, profile);
    put!(out; ",\"device_name\":");
    name_or_null(out, node.text(0x1008, 0).unwrap_or("").as_bytes());
    put!(out; "}\n");
}

fn object(
    out: &mut Vec<u8>,
    setting: Setting<'_>,
    (whose, mux): ((&[u8], u8), Mux),
    object: &ObservedObject,
    names: Lang,
) {
    head(out, "od_object", whose);
    super::sdo::object(out, names, Some(mux), &object.described);
    let known = object.data_type(mux);
    put!(out; ",\"type\":");
    name_or_null(out, known.map_or("", |known| known.0.name()).as_bytes());
    put!(out; ",\"type_from\":");
    name_or_null(out, known.map_or("", |known| known.1.name()).as_bytes());
    put!(out; ",\"bits\":");
    number_or_null(out, object.bits());
    put!(out; ",\"access\":");
    name_or_null(out, object.access().unwrap_or("").as_bytes());
    for (key, said) in
        [("readable", object.is_readable()), ("writable", object.is_writable()), ("exists", object.exists())]
    {
        put!(out; ",\"", key, "\":", said.map_or("null", truth));
    }
    let data_type = known.map(|known| known.0);
    let last = object.value.as_ref();
    put!(out; ",\"value\":");
    number_of(out, data_type, last.map(HeldValue::content));
    put!(out; ",\"text\":");
    match last {
        Some(held) => quoted(out, |text| inventory::held(text, setting.lang, mux, object, &held.value)),
        None => put!(out; "null"),
    }
    put!(out; ",\"data\":");
    bytes(out, last.map(HeldValue::content));
    put!(out; ",\"source\":");
    name_or_null(out, last.map_or("", |held| held.source.name()).as_bytes());
    put!(out; ",\"t\":");
    setting.moment(out, last.and_then(|held| held.at.t_ns));
    put!(out; ",\"frame\":");
    number_or_null(out, last.map(|held| held.at.no));
    put!(out; ",\"values\":", object.values(), ",\"varies\":", truth(object.varies));
    for source in Source::ALL {
        put!(out; ",\"", source.name(), "\":", object.count(source));
    }
    put!(out; ",\"requested\":");
    number_of(out, data_type, object.requested.as_ref().map(HeldValue::content));
    put!(out; ",\"configured\":");
    match object.configured(mux) {
        Some(held) => {
            put!(out; "{\"value\":");
            number_of(out, data_type, Some(held.content()));
            put!(out; ",\"data\":");
            bytes(out, Some(held.content()));
            put!(out; ",\"size\":", held.content().size(), ",\"frame\":", held.at.no, "}");
        }
        None => put!(out; "null"),
    }
    aborts(out, setting, object);
    put!(out; ",\"in_force\":");
    match object.in_force {
        InForce::Value(known) => {
            put!(out; "{\"value\":", known.value, ",\"text\":");
            quoted(out, |text| inventory::number(text, setting.lang, mux, &object.described, known.value));
            put!(out; ",\"from\":\"", known.from.name(), "\"}");
        }
        InForce::Unknown => put!(out; "{\"value\":null,\"text\":null,\"from\":null}"),
        InForce::Unfollowed => put!(out; "null"),
    }
    measured(out, object);
    put!(out; ",\"first_frame\":", object.first.no, ",\"last_frame\":", object.last.no, "}\n");
}

fn aborts(out: &mut Vec<u8>, setting: Setting<'_>, object: &ObservedObject) {
    put!(out; ",\"aborts\":[");
    for (place, one) in object.aborted.iter().enumerate() {
        put!(out; if place > 0 { "," } else { "" }, "{\"request\":\"", one.direction.name(), "\",\"code\":\"");
        put!(out; Hex::<8>(u64::from(one.abort.code)), "\",\"by\":\"", side(one.abort.by), "\",\"text\":");
        name_or_null(out, terms::abort_code(setting.lang, one.abort.code).unwrap_or("").as_bytes());
        put!(out; ",\"count\":", one.count, ",\"frame\":", one.at.no, "}");
    }
    put!(out; "]");
}

fn measured(out: &mut Vec<u8>, object: &ObservedObject) {
    put!(out; ",\"first\":");
    match &object.measured.first {
        Some(held) => {
            let size = held.content().size();
            put!(out; "{\"data\":");
            bytes(out, Some(held.content()));
            put!(out; ",\"size\":", size, ",\"booted\":", truth(object.measured.booted));
            put!(out; ",\"frame\":", held.at.no, "}");
        }
        None => put!(out; "null"),
    }
    put!(out; ",\"sizes\":{");
    for (key, direction) in [("\"read\":", Direction::Upload), (",\"written\":", Direction::Download)] {
        put!(out; key);
        match object.measured.sizes(direction) {
            Some((least, most)) => put!(out; "[", least, ",", most, "]"),
            None => put!(out; "null"),
        }
    }
    put!(out; "},\"extremes\":[");
    let (values, size) = object.measured.extremes().unwrap_or_default();
    for (place, raw) in values.iter().enumerate() {
        let all = raw.to_le_bytes();
        put!(out; if place > 0 { ",\"" } else { "\"" }, Joined(all.get(..size).unwrap_or(&all)), "\"");
    }
    put!(out; "]");
}

/// Appends a value without its unit, or null.
pub(in crate::tables) fn number_of(out: &mut Vec<u8>, data_type: Option<DataType>, content: Option<Content<'_>>) {
    match content {
        Some(Content::Bytes(bytes, size)) if bytes.len() as u64 == size => json_value(out, data_type, bytes),
        Some(Content::Bits(raw, bits)) => match number(data_type, raw, bits) {
            Number::Bool(on) => put!(out; truth(on)),
            Number::Bytes => put!(out; "null"),
            // Whole numbers and reals are written as those of SDO.
            Number::Unsigned(_) => json_value(out, Some(DataType::Unsigned64), &raw.to_le_bytes()),
            Number::Signed(read) => json_value(out, Some(DataType::Integer64), &read.to_le_bytes()),
            Number::Real32(read) => json_value(out, Some(DataType::Real32), &read.to_le_bytes()),
            Number::Real64(read) => json_value(out, Some(DataType::Real64), &read.to_le_bytes()),
        },
        _ => put!(out; "null"),
    }
}

/// Appends the bytes of a value, or null; of bits those that they fill.
pub(in crate::tables) fn bytes(out: &mut Vec<u8>, content: Option<Content<'_>>) {
    match content {
        Some(Content::Bytes(bytes, _)) => put!(out; "\"", Joined(bytes), "\""),
        Some(Content::Bits(raw, bits)) => {
            let all = raw.to_le_bytes();
            put!(out; "\"", Joined(all.get(..usize::from(bits).div_ceil(8)).unwrap_or(&all)), "\"");
        }
        Some(Content::None) | None => put!(out; "null"),
    }
}

/// Appends the name of an object that is seen.
pub(in crate::tables) fn name(out: &mut Vec<u8>, names: Lang, sighting: &ObjectSighting<'_>) {
    match sighting.shown {
        Shown::Transfer(transfer) => {
            let mut known = Vec::new();
            value::name(&mut known, names, sighting.object, &transfer.described);
            out.extend_from_slice(known.trim_ascii_start());
        }
        Shown::Bits(mapped, _) | Shown::Octets(mapped, _) if signal::has_name(names, mapped) => {
            signal::name_beside_object(out, names, mapped);
        }
        Shown::Bits(..) | Shown::Octets(..) => {}
        Shown::Register(_, profile) => {
            let Mux { index, sub } = sighting.object;
            put!(out; terms::object_name(names, profile, index, sub).unwrap_or(""));
        }
    }
}

/// The type of what is seen, as far as a description or a standard has one.
pub(in crate::tables) fn type_of(sighting: &ObjectSighting<'_>) -> Option<DataType> {
    match sighting.shown {
        Shown::Transfer(transfer) => transfer.data_type(),
        Shown::Bits(mapped, _) | Shown::Octets(mapped, _) => mapped.data_type,
        Shown::Register(..) => Some(DataType::Unsigned8),
    }
}

/// Appends what is seen of an object.
pub fn sighting(out: &mut Vec<u8>, setting: Setting<'_>, sighting: &ObjectSighting<'_>, names: Lang) {
    let ObjectSighting { bus, node, object: Mux { index, sub }, at, source, .. } = *sighting;
    head(out, "od_value", (setting.buses.name(bus), node));
    put!(out; ",\"index\":\"", Hex::<4>(u64::from(index)), "\",\"sub\":", sub, ",\"name\":");
    let mut known = Vec::new();
    name(&mut known, names, sighting);
    name_or_null(out, &known);
    let data_type = type_of(sighting);
    put!(out; ",\"type\":");
    name_or_null(out, data_type.map_or("", DataType::name).as_bytes());
    let content = sighting.content();
    put!(out; ",\"bits\":");
    number_or_null(
        out,
        match content {
            Content::None => None,
            Content::Bits(_, bits) => Some(u64::from(bits)),
            Content::Bytes(_, size) => Some(size.saturating_mul(8)),
        },
    );
    put!(out; ",\"source\":\"", source.name(), "\",\"value\":");
    number_of(out, data_type, Some(content));
    put!(out; ",\"text\":");
    quoted(out, |text| inventory::seen(text, setting.lang, sighting));
    put!(out; ",\"data\":");
    bytes(out, Some(content));
    put!(out; ",\"t\":");
    setting.moment(out, at.t_ns);
    put!(out; ",\"frame\":", at.no, ",\"abort\":");
    abort_or_null(out, setting.lang, sighting.aborted().map(|(_, abort)| abort));
    put!(out; "}\n");
}
