//! The data of a transfer in words, and its missing parts. They are determined in `Transfer`.

use super::digits::{Hex, put};
use super::value::{BYTES, Size, of_object, value};
use super::{Lang, say};
use crate::sdo::transfer::{Hole, Status, Transfer};
use crate::world::od::DataType;

/// Maximum number of holes that are named.
const NAMED: usize = 3;

/// Appends the data of a transfer: a value if it is complete, else bytes, since a fragment is not a number. For a write
/// that was not confirmed, the requested value.
pub fn transferred(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    let whole = transfer.data.kept.len() as u64 == transfer.data.size;
    match (transfer.outcome.status, transfer.mux) {
        (Status::Ok, Some(mux)) if whole => of_object(out, lang, mux, &transfer.described, &transfer.data.kept),
        (Status::Ok, _) => value(out, lang, None, &transfer.data.kept, transfer.data.size),
        (status, Some(mux)) if !transfer.data.requested.is_empty() => {
            put!(out; lang.pick("请求写入 ", "requested "));
            of_object(out, lang, mux, &transfer.described, &transfer.data.requested);
            if status != Status::Aborted {
                put!(out; lang.pick(", 未确认", ", not confirmed"));
            }
        }
        _ if transfer.data.kept.is_empty() => {}
        _ if !transfer.data.holes.list().is_empty() => holed(out, lang, transfer),
        _ => value(out, lang, Some(DataType::Domain), &transfer.data.kept, transfer.data.size),
    }
}

/// Appends the bytes of a transfer with holes: `..` for each missing byte, `...` if their number is unknown. A list of
/// the missing parts follows: `[missing: start, 7 bytes at offset 14]`.
fn holed(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    let start = out.len();
    let holes = transfer.data.holes.list();
    for (place, byte) in transfer.data.kept.iter().enumerate().take(BYTES) {
        let place = place as u64;
        if holes.iter().any(|hole| hole.length.is_none() && hole.offset == place) {
            put!(out; if place == 0 { "..." } else { " ..." });
        }
        if out.len() > start {
            put!(out; " ");
        }
        match holes
            .iter()
            .any(|hole| hole.length.is_some_and(|length| (hole.offset..hole.offset + length).contains(&place)))
        {
            true => put!(out; ".."),
            false => put!(out; Hex::<2>(u64::from(*byte))),
        }
    }
    if transfer.data.size > transfer.data.kept.len().min(BYTES) as u64 {
        put!(out; " ...");
    }
    if out.len() > start {
        put!(out; " ");
    }
    missing(out, lang, transfer);
}

fn missing(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    put!(out; lang.pick("[缺失: ", "[missing: "));
    let holes = transfer.data.holes.list();
    let mut placed = true;
    for (number, Hole { offset, length }) in holes.iter().enumerate() {
        if number > 0 {
            put!(out; ", ");
        }
        if number == NAMED {
            put!(out; "...");
            break;
        }
        let end = *offset == transfer.data.size;
        let size = Size(lang, length.unwrap_or(0));
        match length {
            Some(_) if placed => say!(out, lang; zh: "偏移", *offset, "起", size; en: size, " at offset ", *offset),
            Some(_) if end => say!(out, lang; zh: "结尾", size; en: size, " at the end"),
            Some(_) => say!(out, lang; zh: "中间", size; en: size, " in between"),
            // A transfer that is captured from its beginning lacks bytes at unknown positions.
            None if *offset == 0 && !transfer.outcome.midway => {
                put!(out; lang.pick("位置未知", "at an unknown position"))
            }
            None if *offset == 0 => put!(out; lang.pick("开头", "start")),
            None if end => put!(out; lang.pick("结尾", "end")),
            None => put!(out; lang.pick("中间长度未知的一段", "unknown number of bytes in between")),
        }
        placed &= length.is_some();
    }
    put!(out; "]");
}
