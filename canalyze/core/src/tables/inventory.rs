//! Objects of devices by what the traffic shows of them, as CSV: the same in every language.
//!
//! Columns are those of the JSON lines of [`super::jsonl::inventory`]; `aborts` are `download:06010002:3` (request, code,
//! how often) with blanks between, `in_force` is a number, or
//! nothing where `in_force_from` says that it is `unknown`. Must not: decide anything.

use super::csv::{bare, cell};
use super::jsonl::inventory::{bytes, name, number_of, type_of};
use super::jsonl::sdo::side;
use super::jsonl::{NAMES, Setting};
use crate::sdo::wire::Mux;
use crate::views::inventory::sighting::{Content, ObjectSighting, Source};
use crate::views::inventory::{HeldValue, InForce, Inventory, ObservedObject};
use crate::words::digits::{Hex, put};
use crate::words::value;
use crate::world::od::{self, DataType, Value};

/// Appends the headings of objects.
pub fn head(out: &mut Vec<u8>) {
    put!(out; "node,bus,object,name,type,type_from,bits,access,value,data,source,t,frame,values");
    for source in Source::ALL {
        put!(out; ",", source.name());
    }
    put!(out; ",requested,aborts,in_force,in_force_from\n");
}

/// Appends all objects.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, all: &Inventory) {
    for ((bus, id), node) in &all.nodes {
        for (mux, object) in &node.objects {
            // A number stands first: no line may begin as a command of whatever reads a log.
            put!(out; *id, ",");
            cell(out, setting.buses.name(*bus));
            put!(out; ",");
            row(out, setting, *mux, object);
        }
    }
}

fn row(out: &mut Vec<u8>, setting: Setting<'_>, mux: Mux, object: &ObservedObject) {
    place(out, mux);
    let mut known = Vec::new();
    value::name(&mut known, NAMES, mux, &object.described);
    put!(out; ",");
    cell(out, known.trim_ascii_start());
    let known = object.data_type(mux);
    let data_type = known.map(|known| known.0);
    put!(out; ",", data_type.map_or("", DataType::name), ",", known.map_or("", |known| known.1.name()), ",");
    if let Some(bits) = object.bits() {
        put!(out; bits);
    }
    put!(out; ",", object.access().unwrap_or(""), ",");
    let last = object.value.as_ref();
    value_cell(out, data_type, last.map(HeldValue::content));
    put!(out; ",");
    bare(out, |out| bytes(out, last.map(HeldValue::content)));
    put!(out; ",", last.map_or("", |held| held.source.name()), ",");
    bare(out, |out| setting.moment(out, last.and_then(|held| held.at.t_ns)));
    put!(out; ",");
    if let Some(held) = last {
        put!(out; held.at.no);
    }
    put!(out; ",", object.values());
    for source in Source::ALL {
        put!(out; ",", object.count(source));
    }
    put!(out; ",");
    value_cell(out, data_type, object.requested.as_ref().map(HeldValue::content));
    for (place, one) in object.aborted.iter().enumerate() {
        put!(out; if place > 0 { " " } else { "," }, one.direction.name(), ":");
        put!(out; Hex::<8>(u64::from(one.abort.code)), ":", one.count);
    }
    put!(out; if object.aborted.is_empty() { ",," } else { "," });
    match object.in_force {
        InForce::Value(known) => put!(out; known.value, ",", known.from.name(), "\n"),
        InForce::Unknown => put!(out; ",unknown\n"),
        InForce::Unfollowed => put!(out; ",\n"),
    }
}

/// Appends the headings of single values.
pub fn history_head(out: &mut Vec<u8>) {
    put!(out; "t,frame,bus,node,object,name,type,source,value,data,abort_by,abort_code\n");
}

/// Appends what is seen of an object.
pub fn sighting(out: &mut Vec<u8>, setting: Setting<'_>, sighting: &ObjectSighting<'_>) {
    bare(out, |out| setting.moment(out, sighting.at.t_ns));
    put!(out; ",", sighting.at.no, ",");
    cell(out, setting.buses.name(sighting.bus));
    put!(out; ",", sighting.node, ",");
    place(out, sighting.object);
    put!(out; ",");
    let mut known = Vec::new();
    name(&mut known, NAMES, sighting);
    cell(out, &known);
    let (data_type, content) = (type_of(sighting), sighting.content());
    put!(out; ",", data_type.map_or("", DataType::name), ",", sighting.source.name(), ",");
    value_cell(out, data_type, Some(content));
    put!(out; ",");
    bare(out, |out| bytes(out, Some(content)));
    match sighting.aborted() {
        Some((_, abort)) => put!(out; ",", side(abort.by), ",", Hex::<8>(u64::from(abort.code)), "\n"),
        None => put!(out; ",,\n"),
    }
}

fn place(out: &mut Vec<u8>, mux: Mux) {
    put!(out; Hex::<4>(u64::from(mux.index)), ":", Hex::<2>(u64::from(mux.sub)));
}

/// Appends a value; texts as cells are.
fn value_cell(out: &mut Vec<u8>, data_type: Option<DataType>, content: Option<Content<'_>>) {
    if let Some(Content::Bytes(bytes, size)) = content
        && bytes.len() as u64 == size
        && let Value::Text(text) = od::decode(data_type, bytes)
    {
        return cell(out, text.as_bytes());
    }
    bare(out, |out| number_of(out, data_type, content));
}
