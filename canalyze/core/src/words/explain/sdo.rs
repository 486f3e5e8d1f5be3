//! The breakdown of an SDO frame: COB-ID, command byte, multiplexor, data, as the notes' explanation chapters give it.
//! Must not decide anything: what the frame means to its transfer comes in `Step`.

use super::{cob_id, line, parameter};
use crate::bytes::frame::Frame;
use crate::sdo::abort_code::AbortCode;
use crate::sdo::transfer::{Mode, Status, Transfer};
use crate::sdo::wire::{Command, Initiate, Mux, Segment, Side};
use crate::wire::cob_id::Role;
use crate::wire::sdo_command;
use crate::words::digits::{Hex, Spaced, put};
use crate::words::profiles::Profile;
use crate::words::value::Size;
use crate::words::{Lang, escape, say, terms};
use crate::world::event::Step;

/// Most segments whose joining is spelled out.
const PIECES: usize = 8;

/// Appends the breakdown of an SDO frame, whole lines.
pub fn step(out: &mut Vec<u8>, lang: Lang, step: &Step, node: u8, frame: &Frame) {
    let role = if step.side == Side::Client { Role::SdoRequest(node) } else { Role::SdoResponse(node) };
    cob_id(out, lang, role, frame);
    let [command, rest @ ..] = frame.head();
    if frame.len > 0 {
        sdo_command::command_byte(out, lang, command, &step.command, step.side);
    }
    fields(out, lang, step.described.profile, step.command, rest, frame);
    if frame.len != 8 {
        line!(out; lang.pick("长度(字节)=", "length (bytes)="), frame.len, lang.pick(", 应为8", ", expected 8"));
    }
    if let Some(transfer) = &step.result {
        joined(out, lang, transfer);
    }
}

/// The bytes behind the command byte: `rest`.
fn fields(out: &mut Vec<u8>, lang: Lang, profile: Profile, command: Command, rest: [u8; 7], frame: &Frame) {
    // Of a short frame those that it has.
    let there = usize::from(frame.len.saturating_sub(1)).min(rest.len());
    let rest = rest.get(..there).unwrap_or(&rest);
    match command {
        Command::InitiateDownload(mux, i) | Command::UploadInitiated(mux, i) => {
            multiplexor(out, lang, profile, mux);
            initiate(out, lang, i, frame.len);
            if i.expedited {
                parameter::bits(out, lang, mux, i.data.get(..i.expedited_len(frame.len)).unwrap_or_default());
            }
        }
        Command::InitiateUpload(mux) | Command::DownloadInitiated(mux) => {
            multiplexor(out, lang, profile, mux);
            padding(out, lang, rest.get(3..).unwrap_or(&[]));
        }
        Command::Segment(Segment { unused, data, .. }) => {
            let carried = (7 - usize::from(unused)).min(usize::from(frame.len.saturating_sub(1)));
            segment_data(out, lang, data.get(..there).unwrap_or(&data), carried);
        }
        Command::SegmentRequest { .. }
        | Command::SegmentResponse { .. }
        | Command::StartBlockUpload
        | Command::BlockEnded => padding(out, lang, rest),
        Command::InitiateBlockDownload { mux, size, .. } | Command::BlockUploadInitiated { mux, size, .. } => {
            multiplexor(out, lang, profile, mux);
            match size {
                Some(size) => data_size(out, lang, size),
                None => padding(out, lang, rest.get(3..).unwrap_or(&[])),
            }
        }
        Command::BlockDownloadInitiated { mux, blksize, .. } => {
            multiplexor(out, lang, profile, mux);
            block_size(out, lang, blksize);
            padding(out, lang, rest.get(4..).unwrap_or(&[]));
        }
        Command::InitiateBlockUpload { mux, blksize, threshold, .. } => {
            multiplexor(out, lang, profile, mux);
            block_size(out, lang, blksize);
            put!(out; "#   ", Hex::<2>(u64::from(threshold)));
            say!(out, lang;
                zh: "  协议切换阈值pst (0: 不允许切换) = ", threshold, "\n";
                en: "  protocol switch threshold pst (0: no switch) = ", threshold, "\n");
            padding(out, lang, rest.get(5..).unwrap_or(&[]));
        }
        Command::BlockAck { ackseq, blksize } => {
            put!(out; "#   ", Hex::<2>(u64::from(ackseq)));
            say!(out, lang;
                zh: "  确认序号ackseq: 按顺序收到的最后一段 = ", ackseq, "\n";
                en: "  ackseq: last segment received in sequence = ", ackseq, "\n");
            block_size(out, lang, blksize);
            padding(out, lang, rest.get(2..).unwrap_or(&[]));
        }
        Command::EndBlock { crc, .. } => {
            let [low, high] = crc.to_le_bytes();
            let what = lang.pick("  CRC (小端格式) = ", "  CRC (little-endian) = ");
            line!(out; Spaced(&[low, high]), what, Hex::<4>(u64::from(crc)), "h");
            padding(out, lang, rest.get(2..).unwrap_or(&[]));
        }
        Command::BlockSegment { data, .. } => segment_data(out, lang, data.get(..there).unwrap_or(&data), 7),
        Command::Abort(mux, code) => {
            multiplexor(out, lang, profile, mux);
            abort_code(out, lang, code);
        }
        Command::Unknown(_) | Command::Undetermined(_) => super::data(out, lang, rest),
        Command::Truncated(_) => super::data(out, lang, frame.payload().get(1..).unwrap_or(&[])),
    }
}

fn multiplexor(out: &mut Vec<u8>, lang: Lang, profile: Profile, mux: Mux) {
    let [low, high] = mux.index.to_le_bytes();
    put!(out; "#   ", Spaced(&[low, high]), lang.pick("  索引 ", "  index "), Hex::<4>(u64::from(mux.index)), "h");
    if let Some(name) = terms::object_name(lang, profile, mux.index, 0) {
        put!(out; " ", name);
    }
    put!(out; lang.pick(" (小端格式: 低字节在前)\n", " (little-endian: low byte first)\n"));
    line!(out; Hex::<2>(u64::from(mux.sub)), lang.pick("  子索引 ", "  sub-index "), mux.sub);
}

fn initiate(out: &mut Vec<u8>, lang: Lang, i: Initiate, len: u8) {
    if let Some(size) = i.size() {
        data_size(out, lang, size);
        return;
    }
    if !i.expedited {
        padding(out, lang, &i.data);
        return;
    }
    let there = usize::from(len.saturating_sub(4)).min(i.data.len());
    segment_data(out, lang, i.data.get(..there).unwrap_or(&i.data), i.expedited_len(len));
}

fn data_size(out: &mut Vec<u8>, lang: Lang, size: u32) {
    put!(out; "#   ", Spaced(&size.to_le_bytes()), lang.pick("  数据长度 = ", "  data size = "));
    put!(out; Size(lang, u64::from(size)), " (", Hex::<8>(u64::from(size)), lang.pick("h, 小端格式)\n", "h, little-endian)\n"));
}

fn block_size(out: &mut Vec<u8>, lang: Lang, blksize: u8) {
    put!(out; "#   ", Hex::<2>(u64::from(blksize)));
    say!(out, lang;
        zh: "  块大小blksize: 下一子块的段数 = ", blksize, "\n";
        en: "  blksize: segments in the next sub-block = ", blksize, "\n");
}

fn abort_code(out: &mut Vec<u8>, lang: Lang, code: u32) {
    let what = lang.pick("  中止码 (小端格式) = ", "  abort code (little-endian) = ");
    let unknown = lang.pick("保留/未知", "reserved or unknown");
    put!(out; "#   ", Spaced(&code.to_le_bytes()), what, Hex::<8>(u64::from(code)), "h ");
    put!(out; terms::abort_code(lang, AbortCode::Sdo(code)).unwrap_or(unknown), "\n");
}

fn padding(out: &mut Vec<u8>, lang: Lang, bytes: &[u8]) {
    if bytes.is_empty() {
        return;
    }
    let zero = bytes.iter().all(|byte| *byte == 0);
    line!(out; Spaced(bytes), if zero {
        lang.pick("  填充字节, 保留", "  padding, reserved")
    } else {
        lang.pick("  保留, 应为0", "  reserved, expected 0")
    });
}

/// `64 65  数据 "de"     00 00 00 00 00  未使用(5字节)`
fn segment_data(out: &mut Vec<u8>, lang: Lang, bytes: &[u8], carried: usize) {
    if bytes.is_empty() {
        return;
    }
    let (data, unused) = bytes.split_at_checked(carried).unwrap_or((bytes, &[]));
    put!(out; "#   ");
    if !data.is_empty() {
        put!(out; Spaced(data), lang.pick("  数据", "  data"));
        if data.iter().all(|byte| (0x20..0x7F).contains(byte)) {
            put!(out; " \"");
            escape::terminal(out, data);
            put!(out; "\"");
        }
    }
    if !unused.is_empty() {
        if !data.is_empty() {
            put!(out; "     ");
        }
        put!(out; Spaced(unused), lang.pick("  未使用(", "  unused ("), Size(lang, unused.len() as u64), ")");
    }
    put!(out; "\n");
}

/// Appends the joined data of the segments if they are text.
fn joined(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    if transfer.mode == Mode::Expedited || transfer.outcome.status != Status::Ok {
        return;
    }
    let text = !transfer.data.kept.is_empty() && transfer.data.kept.iter().all(|byte| (0x20..0x7F).contains(byte));
    let pieces = transfer.data.kept.chunks(7);
    if !text || !transfer.data.even || pieces.len() > PIECES || transfer.data.kept.len() as u64 != transfer.data.size {
        return;
    }
    put!(out; "#   ", lang.pick("数据拼接结果: ", "data joined: "));
    for (no, piece) in pieces.enumerate() {
        put!(out; if no > 0 { " + \"" } else { "\"" });
        escape::terminal(out, piece);
        put!(out; "\"");
    }
    put!(out; " = \"");
    escape::terminal(out, &transfer.data.kept);
    put!(out; "\" (", Size(lang, transfer.data.size), ")\n");
}
