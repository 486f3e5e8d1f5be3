//! The command byte of an SDO frame, bit group by bit group (CiA 301, 7.2.4.3).

use crate::sdo::wire::{Command, Initiate, Segment, Side};
use crate::words::Lang;
use crate::words::digits::{Hex, Nibbles, binary, put};
use crate::world::event::Step;

/// One group of bits of the command byte.
struct Bits {
    high: u8,
    low: u8,
    zh: &'static str,
    en: &'static str,
}

/// `1B = 0001 1011b  位7-5: 000b 段响应 | 位4: 1 toggle | ...`
pub fn command_byte(out: &mut Vec<u8>, lang: Lang, command: u8, step: &Step) {
    put!(out; "#   ", Hex::<2>(u64::from(command)), " = ", Nibbles(command), "  ");
    for (no, bits) in groups(step).iter().enumerate() {
        if no > 0 {
            put!(out; " | ");
        }
        let count = bits.high.saturating_sub(bits.low) + 1;
        let value = command >> bits.low & (0xFF_u16 >> (8 - count)) as u8;
        if count == 1 {
            put!(out; lang.pick("位", "bit "), bits.low, ": ", value);
        } else {
            put!(out; lang.pick("位", "bits "), bits.high, "-", bits.low, ": ");
            binary(out, u64::from(value), count.into());
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

const fn bits(high: u8, low: u8, zh: &'static str, en: &'static str) -> Bits {
    Bits { high, low, zh, en }
}

/// The bit groups, from the highest down.
fn groups(step: &Step) -> Vec<Bits> {
    let mut groups = vec![specifier(step)];
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
        Command::Undetermined(_) => Vec::new(),
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

/// The highest group: the command specifier, or of a block segment whether it is the last one.
fn specifier(step: &Step) -> Bits {
    let client = step.side == Side::Client;
    match step.command {
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
        Command::Undetermined(_) => bits(7, 0, "无法判定", "undetermined"),
        Command::Truncated(_) => bits(7, 5, "命令字", "command specifier"),
    }
}

/// Returns the bits of an initiating frame besides its specifier.
fn flags(i: Initiate) -> Vec<Bits> {
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
}

fn segment(s: Segment) -> Vec<Bits> {
    vec![
        bits(4, 4, "toggle", "toggle"),
        bits(3, 1, " = {}个未使用字节", " = {} bytes unused"),
        if s.last { bits(0, 0, "最后段", "last segment") } else { bits(0, 0, "还有更多段", "more segments") },
    ]
}

fn crc(yes: bool) -> Bits {
    if yes { bits(2, 2, "支持CRC", "CRC supported") } else { bits(2, 2, "不支持CRC", "CRC not supported") }
}

fn sized(size: Option<u32>) -> Bits {
    if size.is_some() {
        bits(1, 1, "长度指示s: 长度有效", "s: size indicated")
    } else {
        bits(1, 1, "长度指示s: 未指明长度", "s: size not indicated")
    }
}
