//! SDO frames in English, in CiA 301's terms: the phrase, then the content.
//!
//! It must carry the same facts as `zh::sdo` and must not decide anything.

use crate::event::{Place, Step};
use crate::services::sdo::exchange::expedited;
use crate::services::sdo::transfer::{Direction, Status, Transfer};
use crate::services::sdo::wire::{Command, Mux, Segment, Side};
use crate::text::digits::{Hex, put};
use crate::text::{Depth, Lang, object, terms, value};

const EN: Lang = Lang::En;

/// Appends the phrase of an SDO frame, and at other depths than brief its content. No line end.
pub fn step(out: &mut Vec<u8>, depth: Depth, step: &Step, len: u8) {
    phrase(out, step);
    if depth == Depth::Brief {
        return;
    }
    let start = out.len();
    content(out, step, len);
    if out.len() > start {
        out.splice(start..start, *b": ");
    }
    if let Some(transfer) = &step.result
        && !shows_result(step)
    {
        let separator = if out.len() > start { "; " } else { ": " };
        put!(out; separator);
        result(out, transfer);
    }
    place(out, step);
    if len != 8 {
        put!(out; " [", len, if len == 1 { " byte" } else { " bytes" }, " instead of 8]");
    }
}

fn phrase(out: &mut Vec<u8>, step: &Step) {
    let client = step.side == Side::Client;
    let who = if client { " from the client" } else { " from the server" };
    match step.command {
        Command::InitiateUpload(_) => put!(out; "SDO request sent by the client"),
        Command::InitiateDownload(..) => put!(out; "SDO write request sent by the client"),
        Command::UploadInitiated(..) => put!(out; "initiate upload response from the server"),
        Command::DownloadInitiated(_) => put!(out; "initiate download response from the server"),
        Command::SegmentRequest { toggle } => {
            put!(out; "segment request from the client (toggle=", u8::from(toggle), ")");
        }
        Command::SegmentResponse { toggle } => {
            put!(out; "segment response from the server (toggle=", u8::from(toggle), ")");
        }
        Command::Segment(Segment { last: true, .. }) => put!(out; "last segment of data", who),
        Command::Segment(_) if step.ordinal == 0 => put!(out; "segment of data", who),
        Command::Segment(_) => put!(out; "segment ", step.ordinal, " of data", who),
        Command::InitiateBlockUpload { .. } => put!(out; "initiate block upload request from the client"),
        Command::InitiateBlockDownload { .. } => put!(out; "initiate block download request from the client"),
        Command::BlockUploadInitiated { .. } => put!(out; "initiate block upload response from the server"),
        Command::BlockDownloadInitiated { .. } => put!(out; "initiate block download response from the server"),
        Command::StartBlockUpload => put!(out; "start of the block upload from the client"),
        Command::BlockAck { .. } => put!(out; "sub-block acknowledgement", who),
        Command::BlockSegment { seqno, last, .. } => {
            put!(out; if last { "last block segment" } else { "block segment" }, who, " (seqno=", seqno, ")");
        }
        Command::EndBlock { .. } => {
            put!(out; if client { "end block download request" } else { "end block upload request" }, who);
        }
        Command::BlockEnded => {
            put!(out; if client { "end block upload response" } else { "end block download response" }, who);
        }
        Command::Abort(..) => put!(out; "abort transfer", who),
        Command::Unknown(_) => put!(out; "unknown SDO command", who),
        Command::Truncated(_) => put!(out; "truncated SDO frame", who),
    }
}

fn named(out: &mut Vec<u8>, mux: Mux, step: &Step) {
    object::number(out, mux);
    value::name(out, EN, mux, step.described.as_deref());
}

fn announced(out: &mut Vec<u8>, mode: &str, size: Option<u32>) {
    put!(out; ", ", mode, ", ");
    match size {
        Some(size) => value::size(out, EN, u64::from(size)),
        None => put!(out; "size not indicated"),
    }
}

/// Whether the content already is the transfer's result.
fn shows_result(step: &Step) -> bool {
    step.result
        .as_ref()
        .is_some_and(|transfer| transfer.outcome.status == Status::Ok || transfer.outcome.status == Status::Aborted)
        && matches!(step.command, Command::UploadInitiated(..) | Command::DownloadInitiated(_) | Command::Abort(..))
}

fn content(out: &mut Vec<u8>, step: &Step, len: u8) {
    match step.command {
        Command::InitiateUpload(mux) => {
            put!(out; "read ");
            named(out, mux, step);
        }
        Command::InitiateDownload(mux, i) => {
            put!(out; "write ");
            named(out, mux, step);
            if i.expedited {
                let bytes = expedited(Some(mux), &i, len);
                put!(out; " = ");
                value::of_object(out, EN, mux, step.described.as_deref(), bytes);
            } else {
                announced(out, "segmented", i.size());
            }
        }
        Command::UploadInitiated(mux, i) => match &step.result {
            Some(transfer) if shows_result(step) => result(out, transfer),
            _ => {
                object::number(out, mux);
                if i.expedited {
                    let bytes = expedited(Some(mux), &i, len);
                    put!(out; " = ");
                    value::of_object(out, EN, mux, step.described.as_deref(), bytes);
                } else {
                    announced(out, "segmented", i.size());
                }
            }
        },
        Command::DownloadInitiated(mux) => match &step.result {
            Some(transfer) if shows_result(step) => result(out, transfer),
            _ => object::number(out, mux),
        },
        Command::Segment(segment) => {
            let carried = (7 - usize::from(segment.unused)).min(usize::from(len.saturating_sub(1)));
            if carried > 0 {
                value::segment(out, segment.data.get(..carried).unwrap_or(&[]));
            } else {
                put!(out; "no data");
            }
            if segment.unused > 0 {
                put!(out; ", ");
                value::size(out, EN, u64::from(segment.unused));
                put!(out; " unused");
            }
        }
        Command::InitiateBlockDownload { mux, crc, size } => {
            put!(out; "write ");
            named(out, mux, step);
            announced(out, "block", size);
            put!(out; crc_word(crc));
        }
        Command::InitiateBlockUpload { mux, crc, blksize, threshold } => {
            put!(out; "read ");
            named(out, mux, step);
            put!(out; ", block, blksize=", blksize, crc_word(crc));
            if threshold > 0 {
                put!(out; ", protocol switch threshold ");
                value::size(out, EN, u64::from(threshold));
            }
        }
        Command::BlockUploadInitiated { mux, crc, size } => {
            object::number(out, mux);
            announced(out, "block", size);
            put!(out; crc_word(crc));
        }
        Command::BlockDownloadInitiated { mux, crc, blksize } => {
            object::number(out, mux);
            put!(out; ", blksize=", blksize, crc_word(crc));
        }
        Command::BlockAck { ackseq, blksize } => put!(out; "ackseq=", ackseq, ", next blksize=", blksize),
        Command::BlockSegment { data, .. } => value::segment(out, &data),
        Command::EndBlock { unused, crc } => {
            put!(out; "CRC=", Hex::<4>(u64::from(crc)), "h, ");
            value::size(out, EN, u64::from(unused));
            put!(out; " of the last segment unused");
        }
        Command::Abort(mux, code) => {
            object::number(out, step.mux.unwrap_or(mux));
            put!(out; " ");
            abort(out, code);
            if step.mux.is_some_and(|known| known != mux) {
                put!(out; " (the frame names ");
                object::number(out, mux);
                put!(out; ")");
            }
        }
        Command::Truncated(command) if len > 0 => put!(out; "command byte ", Hex::<2>(u64::from(command)), "h"),
        Command::Truncated(_) => {}
        Command::Unknown(command) => put!(out; "command byte ", Hex::<2>(u64::from(command)), "h"),
        Command::SegmentRequest { .. }
        | Command::SegmentResponse { .. }
        | Command::StartBlockUpload
        | Command::BlockEnded => {}
    }
}

fn crc_word(crc: bool) -> &'static str {
    if crc { ", CRC supported" } else { ", CRC not supported" }
}

/// An abort code with its meaning.
pub fn abort(out: &mut Vec<u8>, code: u32) {
    put!(out; Hex::<8>(u64::from(code)), "h ", terms::abort_code(EN, code).unwrap_or("reserved or unknown abort code"));
}

/// What a transfer came to: `1008h:00 = "..." (23 bytes)`.
pub fn result(out: &mut Vec<u8>, transfer: &Transfer) {
    match transfer.mux {
        Some(mux) => object::number(out, mux),
        None => {
            put!(out; if transfer.direction == Direction::Upload { "upload" } else { "download" });
            put!(out; " whose start was not captured");
        }
    }
    if let (Status::Aborted, Some(by)) = (transfer.outcome.status, transfer.outcome.abort) {
        put!(out; if transfer.direction == Direction::Upload { " upload" } else { " download" });
        put!(out; if by.by == Side::Client { " aborted by the client: " } else { " aborted by the server: " });
        abort(out, by.code);
        return;
    }
    if transfer.outcome.status != Status::Aborted && (transfer.data.size > 0 || transfer.outcome.status == Status::Ok) {
        put!(out; " = ");
        value::transferred(out, EN, transfer);
        put!(out; " (");
        value::size(out, EN, transfer.data.size);
        put!(out; ")");
    }
    put!(out; match transfer.outcome.status {
        Status::Ok => "",
        Status::Open | Status::Incomplete => " [incomplete]",
        Status::Aborted => " [aborted]",
        Status::Failed => " [failed]",
    });
}

/// The same where it becomes known only at a later frame.
pub fn later_result(out: &mut Vec<u8>, transfer: &Transfer) {
    put!(out; "transfer that began in frame ", transfer.first.no, ": ");
    result(out, transfer);
}

fn place(out: &mut Vec<u8>, step: &Step) {
    match (step.place, step.answered_by) {
        (Place::Late, Some(request)) => put!(out; " [late answer to frame ", request.no, "]"),
        (Place::Late, None) => put!(out; " [late answer]"),
        (_, Some(answer)) => put!(out; " [answered by frame ", answer.no, "]"),
        (Place::Due, None) => {}
        (Place::Repeated, None) => put!(out; " [repeated request]"),
        (Place::Uncaptured, None) if step.side == Side::Server => put!(out; " [no request seen before]"),
        (Place::Uncaptured, None) => put!(out; " [start of the transfer not captured]"),
        (Place::InFlight, None) => put!(out; " [under way, does not count]"),
        (Place::OutOfSequence(due), None) => put!(out; " [out of sequence, ", due, " was due]"),
        (Place::Twin, None) => put!(out; " [captured twice]"),
        (Place::Outside, None) => put!(out; " [not due here]"),
    }
}
