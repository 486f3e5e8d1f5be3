//! The commands of SDO (CiA 301, 7.2.4.3): the key, the phrase and the bits of the command byte of each.
//!
//! `sdo::wire` takes the bytes apart; which command a byte is depends on the transfer.

use crate::sdo::wire::{Command, Initiate, Segment, Side};
use crate::words::digits::{Hex, Nibbles, binary, put};
use crate::words::lang::{Bilingual, Lang};

/// A command.
pub(crate) struct CommandRow {
    /// Its key in JSON.
    pub(crate) key: &'static str,
    /// Its phrase in a line.
    pub(crate) phrase: Bilingual,
    /// The meaning of bits 7-5; empty if `bits` has them.
    specifier: Bilingual,
    /// The other bits of the command byte, from the highest down.
    bits: &'static [BitGroup],
}

/// A group of bits of the command byte.
#[derive(Clone, Copy)]
struct BitGroup {
    high: u8,
    low: u8,
    meaning: Meaning,
}

#[derive(Clone, Copy)]
enum Meaning {
    Word(Bilingual),
    /// The words for 0 and for 1.
    Flag(Bilingual, Bilingual),
    /// The words before and behind the value.
    Value(Bilingual, Bilingual),
    /// n of an initiate, which counts only with e and s.
    Unused,
}

const fn word(high: u8, low: u8, zh: &'static str, en: &'static str) -> BitGroup {
    BitGroup { high, low, meaning: Meaning::Word((zh, en)) }
}

const fn reserved(high: u8, low: u8) -> BitGroup {
    word(high, low, "保留", "reserved")
}

const fn flag(bit: u8, clear: Bilingual, set: Bilingual) -> BitGroup {
    BitGroup { high: bit, low: bit, meaning: Meaning::Flag(clear, set) }
}

const fn value(high: u8, low: u8, before: Bilingual, behind: Bilingual) -> BitGroup {
    BitGroup { high, low, meaning: Meaning::Value(before, behind) }
}

const TOGGLE: BitGroup = word(4, 4, "toggle", "toggle");
const MORE: Bilingual = ("还有更多段", "more segments");
const LAST: Bilingual = ("最后段", "last segment");
const CRC: BitGroup = flag(2, ("不支持CRC", "CRC not supported"), ("支持CRC", "CRC supported"));
const NO_SIZE: Bilingual = ("长度指示s: 未指明长度", "s: size not indicated");
const SIZE: Bilingual = ("长度指示s: 长度有效", "s: size indicated");

static INITIATE: &[BitGroup] = &[
    reserved(4, 4),
    BitGroup { high: 3, low: 2, meaning: Meaning::Unused },
    flag(
        1,
        ("加速标志e: 不是加速传输", "e: not expedited"),
        ("加速标志e: 数据就在本帧", "e: expedited, the data are in this frame"),
    ),
    flag(0, NO_SIZE, SIZE),
];
static SEGMENT: &[BitGroup] = &[TOGGLE, value(3, 1, ("", ""), ("个未使用字节", " bytes unused")), flag(0, MORE, LAST)];
static TOGGLED: &[BitGroup] = &[TOGGLE, reserved(3, 0)];
static BLOCK_OF_SIZE: &[BitGroup] =
    &[reserved(4, 3), CRC, flag(1, NO_SIZE, SIZE), word(0, 0, "子命令: 初始化", "sub-command: initiate")];
static BLOCK: &[BitGroup] = &[reserved(4, 3), CRC, word(1, 0, "子命令: 初始化", "sub-command: initiate")];
static START: &[BitGroup] = &[reserved(4, 2), word(1, 0, "子命令: 开始上传", "sub-command: start upload")];
static ACK: &[BitGroup] = &[reserved(4, 2), word(1, 0, "子命令: 子块确认", "sub-command: sub-block acknowledged")];
static ENDED: &[BitGroup] = &[reserved(4, 2), word(1, 0, "子命令: 结束确认", "sub-command: end confirmed")];
static END: &[BitGroup] = &[
    value(4, 2, ("", ""), ("个未使用字节(最后一段)", " bytes of the last segment unused")),
    reserved(1, 1),
    word(0, 0, "子命令: 结束", "sub-command: end"),
];
static SEQUENCE: &[BitGroup] = &[flag(7, MORE, LAST), value(6, 0, ("序列号", "sequence number "), ("", ""))];
static REST: &[BitGroup] = &[reserved(4, 0)];
static UNDETERMINED: &[BitGroup] = &[word(7, 0, "无法判定", "undetermined")];

/// The specifier of a byte whose bits 7-5 are no group of their own.
const WHOLE: Bilingual = ("", "");
const DOWNLOAD: Bilingual = ("块下载", "block download");
const DOWNLOAD_RESPONSE: Bilingual = ("块下载响应", "block download response");
const UPLOAD: Bilingual = ("块上传", "block upload");
const UPLOAD_RESPONSE: Bilingual = ("块上传响应", "block upload response");

/// Returns the row of a command of one side.
#[rustfmt::skip]
pub(crate) fn row(command: &Command, side: Side) -> CommandRow {
    let client = side == Side::Client;
    let of = |client_phrase: Bilingual, server_phrase| if client { client_phrase } else { server_phrase };
    let (key, phrase, specifier, bits) = match *command {
        Command::InitiateUpload(_) => ("initiate_upload_request",
            ("主站发送的SDO请求", "SDO request sent by the client"), ("读请求", "initiate upload request"), REST),
        Command::InitiateDownload(..) => ("initiate_download_request",
            ("主站发送的SDO写请求", "SDO write request sent by the client"), ("写请求", "initiate download request"), INITIATE),
        Command::UploadInitiated(_, Initiate { expedited, .. }) => ("initiate_upload_response",
            (if expedited { "从站回复的读响应" } else { "从站回复的初始化响应" }, "initiate upload response from the server"),
            ("初始化响应(读)", "initiate upload response"), INITIATE),
        Command::DownloadInitiated(_) => ("initiate_download_response",
            ("从站回复的写响应", "initiate download response from the server"),
            ("初始化响应(写)", "initiate download response"), REST),
        Command::SegmentRequest { .. } => ("upload_segment_request",
            ("主站发送的段请求", "segment request from the client"), ("段请求", "upload segment request"), TOGGLED),
        Command::SegmentResponse { .. } => ("download_segment_response",
            ("从站回复的段响应", "segment response from the server"), ("写段响应", "download segment response"), TOGGLED),
        Command::Segment(Segment { last, .. }) if client => ("download_segment_request",
            if last { ("主站发送的最后一段数据", "last segment of data from the client") }
            else { ("主站发送的一段数据", "segment of data from the client") },
            ("写段请求", "download segment request"), SEGMENT),
        Command::Segment(Segment { last, .. }) => ("upload_segment_response",
            if last { ("从站发送的最后一段数据", "last segment of data from the server") }
            else { ("从站发送的一段数据", "segment of data from the server") },
            ("段响应", "upload segment response"), SEGMENT),
        Command::InitiateBlockUpload { .. } => ("initiate_block_upload_request",
            ("主站发送的块上传请求", "initiate block upload request from the client"), UPLOAD, BLOCK),
        Command::InitiateBlockDownload { .. } => ("initiate_block_download_request",
            ("主站发送的块下载请求", "initiate block download request from the client"), DOWNLOAD, BLOCK_OF_SIZE),
        Command::BlockUploadInitiated { .. } => ("initiate_block_upload_response",
            ("从站回复的块上传响应", "initiate block upload response from the server"), UPLOAD_RESPONSE, BLOCK_OF_SIZE),
        Command::BlockDownloadInitiated { .. } => ("initiate_block_download_response",
            ("从站回复的块下载响应", "initiate block download response from the server"), DOWNLOAD_RESPONSE, BLOCK),
        Command::StartBlockUpload => ("start_block_upload",
            ("主站发送的块上传开始", "start of the block upload from the client"), UPLOAD, START),
        Command::BlockAck { .. } if client => ("block_acknowledgement",
            ("主站发送的子块确认", "sub-block acknowledgement from the client"), UPLOAD, ACK),
        Command::BlockAck { .. } => ("block_acknowledgement",
            ("从站回复的子块确认", "sub-block acknowledgement from the server"), DOWNLOAD_RESPONSE, ACK),
        Command::EndBlock { .. } if client => ("end_block_download_request",
            ("主站发送的块下载结束", "end block download request from the client"), DOWNLOAD, END),
        Command::EndBlock { .. } => ("end_block_upload_request",
            ("从站发送的块上传结束", "end block upload request from the server"), UPLOAD_RESPONSE, END),
        Command::BlockEnded if client => ("end_block_upload_response",
            ("主站发送的块上传结束确认", "end block upload response from the client"), UPLOAD, ENDED),
        Command::BlockEnded => ("end_block_download_response",
            ("从站回复的块下载结束确认", "end block download response from the server"), DOWNLOAD_RESPONSE, ENDED),
        Command::BlockSegment { last: true, .. } => ("block_segment",
            of(("主站发送的最后一个块数据段", "last block segment from the client"),
               ("从站发送的最后一个块数据段", "last block segment from the server")), WHOLE, SEQUENCE),
        Command::BlockSegment { .. } => ("block_segment",
            of(("主站发送的块数据段", "block segment from the client"),
               ("从站发送的块数据段", "block segment from the server")), WHOLE, SEQUENCE),
        Command::Abort(..) => ("abort",
            of(("主站发送的中止", "abort transfer from the client"), ("从站发送的中止", "abort transfer from the server")),
            ("中止", "abort transfer"), REST),
        Command::Unknown(_) => ("unknown",
            of(("主站发送的未知SDO命令", "unknown SDO command from the client"),
               ("从站发送的未知SDO命令", "unknown SDO command from the server")), ("未定义", "undefined"), REST),
        Command::Truncated(_) => ("truncated",
            of(("主站发送的不完整SDO帧", "truncated SDO frame from the client"),
               ("从站发送的不完整SDO帧", "truncated SDO frame from the server")), ("命令字", "command specifier"), REST),
        Command::Undetermined(_) => ("undetermined",
            of(("主站发送的SDO数据", "SDO data from the client"), ("从站发送的SDO数据", "SDO data from the server")),
            WHOLE, UNDETERMINED),
    };
    CommandRow { key, phrase, specifier, bits }
}

/// Appends the command byte, bit group by bit group: `1B = 0001 1011b  位7-5: 000b 段响应 | 位4: 1 toggle | ...`.
pub(crate) fn command_byte(out: &mut Vec<u8>, lang: Lang, byte: u8, command: &Command, side: Side) {
    put!(out; "#   ", Hex::<2>(u64::from(byte)), " = ", Nibbles(byte), "  ");
    let row = row(command, side);
    let specifier = word(7, 5, row.specifier.0, row.specifier.1);
    let specifier = Some(&specifier).filter(|_| row.specifier != WHOLE);
    for (number, group) in specifier.into_iter().chain(row.bits).enumerate() {
        put!(out; if number > 0 { " | " } else { "" });
        group.put(out, lang, byte);
    }
    put!(out; "\n");
}

impl BitGroup {
    fn put(&self, out: &mut Vec<u8>, lang: Lang, byte: u8) {
        let count = self.high.saturating_sub(self.low) + 1;
        let value = byte >> self.low & (0xFF_u16 >> (8 - count)) as u8;
        if count == 1 {
            put!(out; lang.pick("位", "bit "), self.low, ": ", value);
        } else {
            put!(out; lang.pick("位", "bits "), self.high, "-", self.low, ": ");
            binary(out, u64::from(value), count.into());
            put!(out; "b");
        }
        match self.meaning {
            Meaning::Word(word) => put!(out; " ", lang.word(word)),
            Meaning::Flag(clear, set) => put!(out; " ", lang.word(if value == 0 { clear } else { set })),
            Meaning::Value(before, behind) => put!(out; " = ", lang.word(before), value, lang.word(behind)),
            Meaning::Unused if byte & 3 == 3 => {
                put!(out; " = ", value, lang.pick("个未使用字节(n)", " bytes without data (n)"));
            }
            Meaning::Unused if value == 0 => put!(out; lang.pick(" n (只在e=s=1时有意义)", " n (only with e=s=1)")),
            Meaning::Unused => {
                put!(out; lang.pick(" n (e和s不都为1, 应为0)", " n (shall be 0: e and s are not both 1)"));
            }
        }
    }
}
