//! The breakdown of an SDO frame: COB-ID, each bit group of the command byte, multiplexor, data, as the notes'
//! explanation chapters give it.
//!
//! What the frame means to its transfer comes in `Step`; nothing is decided here.

use super::{cob_id, line};
use crate::cob_id::Role;
use crate::event::Step;
use crate::frame::Frame;
use crate::services::sdo::transfer::{Mode, Status, Transfer};
use crate::services::sdo::wire::{Command, Initiate, Mux, Segment, Side};
use crate::text::digits::{Bin, Hex, Nibbles, Put, Spaced, put};
use crate::text::value::Size;
use crate::text::{Lang, escape, say, terms};

/// Most segments whose joining is spelled out.
const PIECES: usize = 8;

/// One group of bits of the command byte.
struct Bits {
    high: u8,
    low: u8,
    zh: &'static str,
    en: &'static str,
}

/// Appends the breakdown of an SDO frame, whole lines.
pub fn step(out: &mut Vec<u8>, lang: Lang, step: &Step, node: u8, frame: &Frame) {
    let role = if step.side == Side::Client { Role::SdoRequest(node) } else { Role::SdoResponse(node) };
    cob_id(out, lang, role, frame);
    let bytes = frame.head();
    let [command, rest @ ..] = bytes;
    if frame.len > 0 {
        command_byte(out, lang, command, &groups(step));
    }
    match step.command {
        Command::InitiateDownload(mux, i) | Command::UploadInitiated(mux, i) => {
            multiplexor(out, lang, mux);
            initiate(out, lang, i, frame.len);
        }
        Command::InitiateUpload(mux) | Command::DownloadInitiated(mux) => {
            multiplexor(out, lang, mux);
            padding(out, lang, rest.get(3..).unwrap_or(&[]));
        }
        Command::Segment(Segment { unused, data, .. }) => {
            let carried = (7 - usize::from(unused)).min(usize::from(frame.len.saturating_sub(1)));
            segment_data(out, lang, &data, carried);
        }
        Command::SegmentRequest { .. }
        | Command::SegmentResponse { .. }
        | Command::StartBlockUpload
        | Command::BlockEnded => padding(out, lang, &rest),
        Command::InitiateBlockDownload { mux, size, .. } | Command::BlockUploadInitiated { mux, size, .. } => {
            multiplexor(out, lang, mux);
            match size {
                Some(size) => data_size(out, lang, size),
                None => padding(out, lang, rest.get(3..).unwrap_or(&[])),
            }
        }
        Command::BlockDownloadInitiated { mux, blksize, .. } => {
            multiplexor(out, lang, mux);
            block_size(out, lang, blksize);
            padding(out, lang, rest.get(4..).unwrap_or(&[]));
        }
        Command::InitiateBlockUpload { mux, blksize, threshold, .. } => {
            multiplexor(out, lang, mux);
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
        Command::BlockSegment { data, .. } => segment_data(out, lang, &data, 7),
        Command::Abort(mux, code) => {
            multiplexor(out, lang, mux);
            let meaning = terms::abort_code(lang, code);
            let what = lang.pick("  中止码 (小端格式) = ", "  abort code (little-endian) = ");
            line!(
                out;
                Spaced(&code.to_le_bytes()), what, Hex::<8>(u64::from(code)), "h ",
                meaning.unwrap_or(lang.pick("保留/未知", "reserved or unknown"))
            );
        }
        Command::Unknown(_) => super::data(out, lang, &rest),
        Command::Truncated(_) => super::data(out, lang, frame.payload().get(1..).unwrap_or(&[])),
    }
    if frame.len != 8 {
        line!(out; lang.pick("长度(字节)=", "length (bytes)="), frame.len, lang.pick(", 应为8", ", shall be 8"));
    }
    if let Some(transfer) = &step.result {
        joined(out, lang, transfer);
    }
}

/// `1B = 0001 1011b  位7-5: 000b 段响应 | 位4: 1 toggle | ...`
fn command_byte(out: &mut Vec<u8>, lang: Lang, command: u8, groups: &[Bits]) {
    put!(out; "#   ", Hex::<2>(u64::from(command)), " = ", Nibbles(command), "  ");
    for (no, bits) in groups.iter().enumerate() {
        if no > 0 {
            put!(out; " | ");
        }
        let count = bits.high.saturating_sub(bits.low) + 1;
        let value = command >> bits.low & (0xFF_u16 >> (8 - count)) as u8;
        if count == 1 {
            put!(out; lang.pick("位", "bit "), bits.low, ": ", value);
        } else {
            put!(out; lang.pick("位", "bits "), bits.high, "-", bits.low, ": ");
            BinOf(value, count).put(out);
            put!(out; "b");
        }
        let words = lang.pick(bits.zh, bits.en);
        match words.split_once("{}") {
            None => put!(out; " ", words),
            Some((before, after)) => put!(out; before, value, after),
        }
    }
    put!(out; "\n");
}

struct BinOf(u8, u8);

impl Put for BinOf {
    fn put(&self, out: &mut Vec<u8>) {
        match self.1 {
            2 => put!(out; Bin::<2>(u64::from(self.0))),
            3 => put!(out; Bin::<3>(u64::from(self.0))),
            4 => put!(out; Bin::<4>(u64::from(self.0))),
            5 => put!(out; Bin::<5>(u64::from(self.0))),
            7 => put!(out; Bin::<7>(u64::from(self.0))),
            _ => put!(out; Bin::<8>(u64::from(self.0))),
        }
    }
}

const fn bits(high: u8, low: u8, zh: &'static str, en: &'static str) -> Bits {
    Bits { high, low, zh, en }
}

/// The bit groups of the command byte, from the highest down.
fn groups(step: &Step) -> Vec<Bits> {
    let client = step.side == Side::Client;
    let flags = |i: Initiate| {
        vec![
            bits(4, 4, "保留", "reserved"),
            match (i.expedited && i.size_indicated, i.unused) {
                (true, _) => bits(3, 2, " = {}个未使用字节(n)", " = {} bytes without data (n)"),
                (false, 0) => bits(3, 2, "n (只在e=s=1时有意义)", "n (only with e=s=1)"),
                (false, _) => bits(3, 2, "n (e和s不都为1, 应为0)", "n (shall be 0: e and s are not both 1)"),
            },
            if i.expedited {
                bits(1, 1, "加速标志e: 数据就在本帧", "e: expedited, the data are in this frame")
            } else {
                bits(1, 1, "加速标志e: 不是加速传输", "e: not expedited")
            },
            if i.size_indicated {
                bits(0, 0, "长度指示s: 长度有效", "s: size indicated")
            } else {
                bits(0, 0, "长度指示s: 未指明长度", "s: size not indicated")
            },
        ]
    };
    let segment = |s: Segment| {
        vec![
            bits(4, 4, "toggle", "toggle"),
            bits(3, 1, " = {}个未使用字节", " = {} bytes unused"),
            if s.last {
                bits(0, 0, "最后段", "last segment")
            } else {
                bits(0, 0, "还有更多段", "more segments")
            },
        ]
    };
    let crc = |yes: bool| {
        if yes { bits(2, 2, "支持CRC", "CRC supported") } else { bits(2, 2, "不支持CRC", "CRC not supported") }
    };
    let sized = |size: Option<u32>| {
        if size.is_some() {
            bits(1, 1, "长度指示s: 长度有效", "s: size indicated")
        } else {
            bits(1, 1, "长度指示s: 未指明长度", "s: size not indicated")
        }
    };
    let mut groups = vec![match step.command {
        Command::InitiateDownload(..) => bits(7, 5, "写请求", "initiate download request"),
        Command::InitiateUpload(_) => bits(7, 5, "读请求", "initiate upload request"),
        Command::UploadInitiated(..) => bits(7, 5, "初始化响应(读)", "initiate upload response"),
        Command::DownloadInitiated(_) => bits(7, 5, "初始化响应(写)", "initiate download response"),
        Command::Segment(_) if client => bits(7, 5, "写段请求", "download segment request"),
        Command::Segment(_) => bits(7, 5, "段响应", "upload segment response"),
        Command::SegmentRequest { .. } => bits(7, 5, "段请求", "upload segment request"),
        Command::SegmentResponse { .. } => bits(7, 5, "写段响应", "download segment response"),
        Command::InitiateBlockDownload { .. } | Command::EndBlock { .. } if client => {
            bits(7, 5, "块下载", "block download")
        }
        Command::InitiateBlockUpload { .. } | Command::StartBlockUpload => bits(7, 5, "块上传", "block upload"),
        Command::BlockAck { .. } | Command::BlockEnded if client => bits(7, 5, "块上传", "block upload"),
        Command::BlockAck { .. } | Command::BlockEnded | Command::BlockDownloadInitiated { .. } => {
            bits(7, 5, "块下载响应", "block download response")
        }
        Command::BlockUploadInitiated { .. } | Command::EndBlock { .. } => {
            bits(7, 5, "块上传响应", "block upload response")
        }
        Command::InitiateBlockDownload { .. } => bits(7, 5, "块下载", "block download"),
        Command::BlockSegment { last: true, .. } => bits(7, 7, "最后段", "last segment"),
        Command::BlockSegment { .. } => bits(7, 7, "还有更多段", "more segments"),
        Command::Abort(..) => bits(7, 5, "中止", "abort transfer"),
        Command::Unknown(_) => bits(7, 5, "未定义", "undefined"),
        Command::Truncated(_) => bits(7, 5, "命令字", "command specifier"),
    }];
    groups.extend(match step.command {
        Command::InitiateDownload(_, i) | Command::UploadInitiated(_, i) => flags(i),
        Command::Segment(s) => segment(s),
        Command::SegmentRequest { .. } | Command::SegmentResponse { .. } => {
            vec![bits(4, 4, "toggle", "toggle"), bits(3, 0, "保留", "reserved")]
        }
        Command::InitiateBlockDownload { crc: yes, size, .. }
        | Command::BlockUploadInitiated { crc: yes, size, .. } => {
            vec![
                bits(4, 3, "保留", "reserved"),
                crc(yes),
                sized(size),
                bits(0, 0, "子命令: 初始化", "sub-command: initiate"),
            ]
        }
        Command::InitiateBlockUpload { crc: yes, .. } | Command::BlockDownloadInitiated { crc: yes, .. } => {
            vec![bits(4, 3, "保留", "reserved"), crc(yes), bits(1, 0, "子命令: 初始化", "sub-command: initiate")]
        }
        Command::StartBlockUpload => {
            vec![bits(4, 2, "保留", "reserved"), bits(1, 0, "子命令: 开始上传", "sub-command: start upload")]
        }
        Command::BlockAck { .. } => {
            vec![bits(4, 2, "保留", "reserved"), bits(1, 0, "子命令: 子块确认", "sub-command: sub-block acknowledged")]
        }
        Command::BlockEnded => {
            vec![bits(4, 2, "保留", "reserved"), bits(1, 0, "子命令: 结束确认", "sub-command: end confirmed")]
        }
        Command::EndBlock { .. } => vec![
            bits(4, 2, " = {}个未使用字节(最后一段)", " = {} bytes of the last segment unused"),
            bits(1, 1, "保留", "reserved"),
            bits(0, 0, "子命令: 结束", "sub-command: end"),
        ],
        Command::BlockSegment { .. } => vec![bits(6, 0, " = 序列号{}", " = sequence number {}")],
        Command::InitiateUpload(_)
        | Command::DownloadInitiated(_)
        | Command::Abort(..)
        | Command::Unknown(_)
        | Command::Truncated(_) => {
            vec![bits(4, 0, "保留", "reserved")]
        }
    });
    groups
}

fn multiplexor(out: &mut Vec<u8>, lang: Lang, mux: Mux) {
    let [low, high] = mux.index.to_le_bytes();
    put!(out; "#   ", Spaced(&[low, high]), lang.pick("  索引 ", "  index "), Hex::<4>(u64::from(mux.index)), "h");
    if let Some(name) = terms::object_name(lang, mux.index, 0) {
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
    segment_data(out, lang, &i.data, i.expedited_len(len));
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

fn padding(out: &mut Vec<u8>, lang: Lang, bytes: &[u8]) {
    if bytes.is_empty() {
        return;
    }
    let zero = bytes.iter().all(|byte| *byte == 0);
    line!(out; Spaced(bytes), if zero {
        lang.pick("  填充字节, 保留", "  padding, reserved")
    } else {
        lang.pick("  保留, 应为0", "  reserved, shall be 0")
    });
}

/// `64 65  数据 "de"     00 00 00 00 00  未使用(5字节)`
fn segment_data(out: &mut Vec<u8>, lang: Lang, bytes: &[u8], carried: usize) {
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

/// How the segments' data join, where they are text.
fn joined(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    if transfer.mode == Mode::Expedited || transfer.status != Status::Ok {
        return;
    }
    let text = !transfer.kept.is_empty() && transfer.kept.iter().all(|byte| (0x20..0x7F).contains(byte));
    let pieces = transfer.kept.chunks(7);
    if !text || !transfer.even || pieces.len() > PIECES || transfer.kept.len() as u64 != transfer.size {
        return;
    }
    put!(out; "#   ", lang.pick("数据拼接结果: ", "data joined: "));
    for (no, piece) in pieces.enumerate() {
        put!(out; if no > 0 { " + \"" } else { "\"" });
        escape::terminal(out, piece);
        put!(out; "\"");
    }
    put!(out; " = \"");
    escape::terminal(out, &transfer.kept);
    put!(out; "\" (", Size(lang, transfer.size), ")\n");
}
