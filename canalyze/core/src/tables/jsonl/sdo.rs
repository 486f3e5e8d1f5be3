//! SDO in JSON: a frame's `sdo` object, and parts of others.
//!
//! Keys are only ever added, never renamed. It must not decide anything.

use super::{name_or_null, number_or_null, truth};
use crate::bytes::frame::Frame;
use crate::sdo::transfer::{Abort, TransferId};
use crate::sdo::wire::{self, Command, Mux, Side};
use crate::wire::sdo_command::row;
use crate::words::digits::{Hex, put};
use crate::words::{Lang, escape, terms, value};
use crate::world::dictionary::Described;
use crate::world::event::{Place, Step};
use crate::world::od::{self, DataType, Value};

/// Largest integer that every JSON reader takes exactly.
const EXACT: u64 = 1 << 53;

/// Appends the fields of an SDO frame.
///
/// `by` client/server; `command`; `transfer` its number or null; `index` hex and `sub` of the transfer's object or
/// null; `segment` its number in the transfer or null; `place` due, repeated, late, uncaptured, in_flight,
/// out_of_sequence, outside or duplicate (captured twice); `answered_by` the frame that was captured before this request,
/// for a late answer the request, or null; then, where the command has them: `toggle` 0/1, `unused`, `last`, `seqno`, `ackseq`,
/// `blksize`, `threshold`, `crc` (flag or hex), `size`, `expedited`, `abort` hex; of the command `undetermined`, which
/// belongs to a transfer that the capture does not show, its `candidates`.
pub fn fields(out: &mut Vec<u8>, step: &Step, transfer: Option<TransferId>, frame: &Frame) {
    put!(out; "{\"by\":\"", side(step.side), "\",\"command\":\"", row(&step.command, step.side).key, "\",\"transfer\":");
    number_or_null(out, transfer.map(|id| id.0));
    match step.mux.or(step.command.mux()) {
        Some(mux) => put!(out; ",\"index\":\"", Hex::<4>(u64::from(mux.index)), "\",\"sub\":", mux.sub),
        None => put!(out; ",\"index\":null,\"sub\":null"),
    }
    put!(out; ",\"segment\":");
    number_or_null(out, (step.ordinal > 0).then_some(u64::from(step.ordinal)));
    put!(out; ",\"place\":\"", match step.place {
        Place::Due => "due",
        Place::Repeated => "repeated",
        Place::Late => "late",
        Place::Uncaptured => "uncaptured",
        Place::InFlight => "in_flight",
        Place::OutOfSequence(_) => "out_of_sequence",
        Place::Outside => "outside",
        Place::Duplicate => "duplicate",
    });
    put!(out; "\",\"answered_by\":");
    number_or_null(out, step.answered_by.as_ref().map(|at| at.no));
    match step.command {
        Command::InitiateDownload(_, i) | Command::UploadInitiated(_, i) => {
            let size = if i.expedited { Some(i.expedited_len(frame.len) as u64) } else { i.size().map(u64::from) };
            put!(out; ",\"expedited\":", truth(i.expedited), ",\"size\":");
            number_or_null(out, size);
        }
        Command::Segment(s) => {
            put!(out; ",\"toggle\":", u8::from(s.toggle), ",\"unused\":", s.unused, ",\"last\":", truth(s.last));
        }
        Command::SegmentRequest { toggle } | Command::SegmentResponse { toggle } => {
            put!(out; ",\"toggle\":", u8::from(toggle));
        }
        Command::InitiateBlockDownload { crc, size, .. } | Command::BlockUploadInitiated { crc, size, .. } => {
            put!(out; ",\"crc\":", truth(crc), ",\"size\":");
            number_or_null(out, size.map(u64::from));
        }
        Command::InitiateBlockUpload { crc, blksize, threshold, .. } => {
            put!(out; ",\"crc\":", truth(crc), ",\"blksize\":", blksize, ",\"threshold\":", threshold);
        }
        Command::BlockDownloadInitiated { crc, blksize, .. } => {
            put!(out; ",\"crc\":", truth(crc), ",\"blksize\":", blksize);
        }
        Command::BlockAck { ackseq, blksize } => put!(out; ",\"ackseq\":", ackseq, ",\"blksize\":", blksize),
        Command::BlockSegment { seqno, last, .. } => put!(out; ",\"seqno\":", seqno, ",\"last\":", truth(last)),
        Command::EndBlock { unused, crc } => {
            put!(out; ",\"unused\":", unused, ",\"crc\":\"", Hex::<4>(u64::from(crc)), "\"");
        }
        Command::Abort(_, code) => put!(out; ",\"abort\":\"", Hex::<8>(u64::from(code)), "\""),
        Command::InitiateUpload(_)
        | Command::DownloadInitiated(_)
        | Command::StartBlockUpload
        | Command::BlockEnded
        | Command::Unknown(_)
        | Command::Truncated(_) => {}
        Command::Undetermined(_) if step.place == Place::Outside => {}
        Command::Undetermined(bytes) => {
            put!(out; ",\"candidates\":[\"block_segment\"");
            let plain = wire::decode(step.side, bytes);
            if !plain.is_unreadable() {
                put!(out; ",\"", row(&plain, step.side).key, "\"");
            }
            put!(out; "]");
        }
    }
    put!(out; "}");
}

/// The word for a side.
pub(crate) fn side(side: Side) -> &'static str {
    match side {
        Side::Client => "client",
        Side::Server => "server",
    }
}

/// Appends the keys `index`, `sub` and `name` of an object, null where it is not known.
pub(crate) fn object(out: &mut Vec<u8>, lang: Lang, mux: Option<Mux>, described: &Described) {
    let mut name = Vec::new();
    match mux {
        Some(mux) => {
            put!(out; ",\"index\":\"", Hex::<4>(u64::from(mux.index)), "\",\"sub\":", mux.sub);
            value::name(&mut name, lang, mux, described);
        }
        None => put!(out; ",\"index\":null,\"sub\":null"),
    }
    put!(out; ",\"name\":");
    // A blank is before the name.
    name_or_null(out, name.get(1..).unwrap_or(&[]));
}

/// Appends `{"code","by","text"}`, or null.
pub(crate) fn abort_or_null(out: &mut Vec<u8>, lang: Lang, abort: Option<Abort>) {
    let Some(abort) = abort else { return put!(out; "null") };
    put!(out; "{\"code\":\"", abort.code, "\",\"by\":\"", side(abort.by), "\",\"text\":");
    name_or_null(out, terms::abort_code(lang, abort.code).unwrap_or("").as_bytes());
    put!(out; "}");
}

/// Appends a value as a number, string or boolean, or null.
pub(crate) fn json_value(out: &mut Vec<u8>, data_type: Option<DataType>, bytes: &[u8]) {
    match od::decode(data_type, bytes) {
        Value::Empty | Value::Bytes(_) | Value::Time { .. } | Value::Difference { .. } => put!(out; "null"),
        Value::Bool(value) => put!(out; truth(value)),
        Value::Signed(value) if value.unsigned_abs() <= EXACT => put!(out; value),
        Value::Signed(value) => put!(out; "\"", value, "\""),
        Value::Unsigned(value) if value <= EXACT => put!(out; value),
        Value::Unsigned(value) => put!(out; "\"", value, "\""),
        Value::Real(value) if value.is_finite() => out.extend_from_slice(value.to_string().as_bytes()),
        Value::Real(_) => put!(out; "null"),
        Value::Text(text) => escape::json(out, text.as_bytes()),
    }
}
