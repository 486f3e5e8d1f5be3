//! The entries of a device description about an object, and about an identifier.
//!
//! Standards are explained in `code`.

use crate::wire::pdo::mapping::decode_entry;
use crate::words::Lang;
use crate::words::digits::{Hex, put};
use crate::words::escape;
use crate::world::dictionary::{Dictionary, Object};
use crate::world::network::Description;
use crate::world::od::DataType;

/// A PDO whose identifier is not used (bit 31 of its COB-ID).
const INVALID: u64 = 1 << 31;
/// The identifier in a COB-ID of eleven bits.
const BASE: u64 = 0x7FF;
/// Sub-indices that are told of an object.
const SUBS: usize = 16;

/// Returns true if a description has an object, or its part `sub`.
pub(super) fn has(dictionary: &Dictionary, index: u16, sub: Option<u8>) -> bool {
    sub.map_or_else(|| dictionary.has(index), |sub| dictionary.get(index, sub).is_some())
}

/// Appends what a description says of an object, a line each part.
pub(super) fn object(out: &mut Vec<u8>, lang: Lang, device: &Description, index: u16, sub: Option<u8>) {
    let parts = device.dictionary.of(index);
    for one in parts.iter().filter(|one| sub.is_none_or(|sub| one.sub == sub)).take(SUBS) {
        put!(out; "  ");
        whose(out, lang, device);
        put!(out; Hex::<4>(u64::from(index)), "h:", Hex::<2>(u64::from(one.sub)), " ");
        escape::terminal(out, one.name.as_bytes());
        if let Some(data_type) = one.data_type() {
            put!(out; ", ", data_type.name());
        }
        put!(out; ", ", one.access.name());
        preset(out, lang, one, device.node);
        put!(out; "\n");
    }
}

/// Appends whose PDO an identifier is, and what is mapped into it, by a description.
pub(super) fn cob_id(out: &mut Vec<u8>, lang: Lang, device: &Description, id: u16) {
    for (first, mapping, kind) in [(0x1400_u16, 0x1600_u16, "RPDO"), (0x1800, 0x1A00, "TPDO")] {
        for one in device.dictionary.within(first..=first + 0x1FF).iter().filter(|one| one.sub == 1) {
            let Some(node) = node_of(one, device.node, id) else { continue };
            let number = one.index - first;
            put!(out; "  ");
            whose(out, lang, device);
            put!(out; kind, u64::from(number) + 1);
            if device.node == 0 && node != 0 {
                put!(out; lang.pick(", 若节点ID为", ", where the node-ID is "), node);
            }
            for (place, entry) in device.dictionary.of(mapping + number).iter().filter(|one| one.sub > 0).enumerate() {
                let Some(value) = entry.preset_at(node).filter(|value| *value != 0) else { continue };
                let (index, sub, _) = decode_entry(value as u32);
                put!(out; if place > 0 { ", " } else { ": " }, Hex::<4>(u64::from(index)), "h:", Hex::<2>(u64::from(sub)));
                if let Some(mapped) = device.dictionary.get(index, sub) {
                    put!(out; " ");
                    escape::terminal(out, mapped.name.as_bytes());
                }
            }
            put!(out; "\n");
        }
    }
}

/// The node-ID with which a COB-ID is this identifier; `None` where it cannot be, or the PDO is not valid.
fn node_of(cob_id: &Object, node: u8, id: u16) -> Option<u8> {
    let preset = cob_id.preset?;
    if preset.value & INVALID != 0 {
        return None;
    }
    if node == 0 && preset.relative {
        let found = u64::from(id).checked_sub(preset.value & BASE).filter(|found| (1..=127).contains(found))?;
        return u8::try_from(found).ok();
    }
    (cob_id.preset_at(node)? & BASE == u64::from(id)).then_some(node)
}

/// `drive.eds, node 5: `.
fn whose(out: &mut Vec<u8>, lang: Lang, device: &Description) {
    escape::terminal(out, device.dictionary.file.as_bytes());
    if device.node > 0 {
        put!(out; lang.pick(", 节点", ", node "), device.node);
    }
    put!(out; ": ");
}

fn preset(out: &mut Vec<u8>, lang: Lang, object: &Object, node: u8) {
    let Some(preset) = object.preset else { return };
    let word = if preset.configured {
        lang.pick(", 配置值 ", ", configured ")
    } else {
        lang.pick(", 默认值 ", ", default ")
    };
    put!(out; word);
    if preset.relative && node == 0 {
        put!(out; "$NODEID+");
        number(out, object, preset.value);
    } else if let Some(value) = object.preset_at(node) {
        number(out, object, value);
        put!(out; " (", value, ")");
    }
}

fn number(out: &mut Vec<u8>, object: &Object, value: u64) {
    match object.data_type().and_then(DataType::size) {
        Some(1) => put!(out; Hex::<2>(value), "h"),
        Some(2) => put!(out; Hex::<4>(value), "h"),
        Some(..=4) => put!(out; Hex::<8>(value), "h"),
        _ => put!(out; Hex::<16>(value), "h"),
    }
}
