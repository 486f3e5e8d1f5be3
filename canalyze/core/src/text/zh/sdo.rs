//! SDO frames in Chinese: the notes' phrase, then the content.
//!
//! It must carry the same facts as `en::sdo` and must not decide anything.

use crate::event::{Place, Step};
use crate::services::sdo::exchange::expedited;
use crate::services::sdo::transfer::{Direction, Status, Transfer};
use crate::services::sdo::wire::{Command, Mux, Segment, Side};
use crate::text::digits::{Hex, put};
use crate::text::{Depth, Lang, object, terms, value};

const ZH: Lang = Lang::Zh;

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
        put!(out; " [长度", len, "字节, 应为8字节]");
    }
}

fn phrase(out: &mut Vec<u8>, step: &Step) {
    let client = step.side == Side::Client;
    let (who, answers) = if client { ("主站", "主站发送的") } else { ("从站", "从站回复的") };
    match step.command {
        Command::InitiateUpload(_) => put!(out; "主站发送的SDO请求"),
        Command::InitiateDownload(..) => put!(out; "主站发送的SDO写请求"),
        Command::UploadInitiated(..) => put!(out; "从站回复的初始化响应"),
        Command::DownloadInitiated(_) => put!(out; "从站回复的写响应"),
        Command::SegmentRequest { toggle } => put!(out; "主站发送的段请求 (toggle=", u8::from(toggle), ")"),
        Command::SegmentResponse { toggle } => put!(out; "从站回复的段响应 (toggle=", u8::from(toggle), ")"),
        Command::Segment(Segment { last, .. }) => {
            put!(out; who, "发送的");
            ordinal(out, step.ordinal, last);
            put!(out; "数据");
        }
        Command::InitiateBlockUpload { .. } => put!(out; "主站发送的块上传请求"),
        Command::InitiateBlockDownload { .. } => put!(out; "主站发送的块下载请求"),
        Command::BlockUploadInitiated { .. } => put!(out; "从站回复的块上传响应"),
        Command::BlockDownloadInitiated { .. } => put!(out; "从站回复的块下载响应"),
        Command::StartBlockUpload => put!(out; "主站发送的块上传开始"),
        Command::BlockAck { .. } => put!(out; answers, "子块确认"),
        Command::BlockSegment { seqno, last, .. } => {
            put!(out; who, if last { "发送的最后一个块数据段" } else { "发送的块数据段" }, " (序列号=", seqno, ")");
        }
        Command::EndBlock { .. } => put!(out; who, if client { "发送的块下载结束" } else { "发送的块上传结束" }),
        Command::BlockEnded => put!(out; answers, if client { "块上传结束确认" } else { "块下载结束确认" }),
        Command::Abort(..) => put!(out; who, "发送的中止"),
        Command::Unknown(_) => put!(out; who, "发送的未知SDO命令"),
        Command::Truncated(_) => put!(out; who, "发送的不完整SDO帧"),
    }
}

/// `第一段` to `第十段`, then `第11段`; a transfer's only or closing segment is `最后一段`.
fn ordinal(out: &mut Vec<u8>, number: u32, last: bool) {
    const WORDS: [&str; 10] = ["一", "二", "三", "四", "五", "六", "七", "八", "九", "十"];
    if last {
        put!(out; "最后一段");
        return;
    }
    let word = (number as usize).checked_sub(1).and_then(|index| WORDS.get(index));
    match (number, word) {
        (0, _) => put!(out; "一段"),
        (_, Some(word)) => put!(out; "第", *word, "段"),
        (_, None) => put!(out; "第", number, "段"),
    }
}

fn named(out: &mut Vec<u8>, mux: Mux, step: &Step) {
    object::number(out, mux);
    value::name(out, ZH, mux, step.described.as_deref());
}

fn announced(out: &mut Vec<u8>, mode: &str, size: Option<u32>) {
    put!(out; ", ", mode, ", 长度");
    match size {
        Some(size) => value::size(out, ZH, u64::from(size)),
        None => put!(out; "未知"),
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
            put!(out; "读 ");
            named(out, mux, step);
        }
        Command::InitiateDownload(mux, i) => {
            put!(out; "写 ");
            named(out, mux, step);
            if i.expedited {
                let bytes = expedited(Some(mux), &i, len);
                put!(out; " = ");
                value::of_object(out, ZH, mux, step.described.as_deref(), bytes);
            } else {
                announced(out, "分段传输", i.size());
            }
        }
        Command::UploadInitiated(mux, i) => match &step.result {
            Some(transfer) if shows_result(step) => result(out, transfer),
            _ => {
                object::number(out, mux);
                if i.expedited {
                    let bytes = expedited(Some(mux), &i, len);
                    put!(out; " = ");
                    value::of_object(out, ZH, mux, step.described.as_deref(), bytes);
                } else {
                    announced(out, "分段传输", i.size());
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
                put!(out; "无数据");
            }
            if segment.unused > 0 {
                put!(out; ", ");
                value::size(out, ZH, u64::from(segment.unused));
                put!(out; "未使用");
            }
        }
        Command::InitiateBlockDownload { mux, crc, size } => {
            put!(out; "写 ");
            named(out, mux, step);
            announced(out, "块传输", size);
            put!(out; crc_word(crc));
        }
        Command::InitiateBlockUpload { mux, crc, blksize, threshold } => {
            put!(out; "读 ");
            named(out, mux, step);
            put!(out; ", 块传输, 块大小=", blksize, crc_word(crc));
            if threshold > 0 {
                put!(out; ", 协议切换阈值=");
                value::size(out, ZH, u64::from(threshold));
            }
        }
        Command::BlockUploadInitiated { mux, crc, size } => {
            object::number(out, mux);
            announced(out, "块传输", size);
            put!(out; crc_word(crc));
        }
        Command::BlockDownloadInitiated { mux, crc, blksize } => {
            object::number(out, mux);
            put!(out; ", 块大小=", blksize, crc_word(crc));
        }
        Command::BlockAck { ackseq, blksize } => put!(out; "确认序号=", ackseq, ", 下一块大小=", blksize),
        Command::BlockSegment { data, .. } => value::segment(out, &data),
        Command::EndBlock { unused, crc } => {
            put!(out; "CRC=", Hex::<4>(u64::from(crc)), "h, 最后一段");
            value::size(out, ZH, u64::from(unused));
            put!(out; "未使用");
        }
        Command::Abort(mux, code) => {
            object::number(out, step.mux.unwrap_or(mux));
            put!(out; " ");
            abort(out, code);
            if step.mux.is_some_and(|known| known != mux) {
                put!(out; " (帧中为");
                object::number(out, mux);
                put!(out; ")");
            }
        }
        Command::Truncated(command) if len > 0 => put!(out; "命令字节 ", Hex::<2>(u64::from(command)), "h"),
        Command::Truncated(_) => {}
        Command::Unknown(command) => put!(out; "命令字节 ", Hex::<2>(u64::from(command)), "h"),
        Command::SegmentRequest { .. }
        | Command::SegmentResponse { .. }
        | Command::StartBlockUpload
        | Command::BlockEnded => {}
    }
}

fn crc_word(crc: bool) -> &'static str {
    if crc { ", 支持CRC" } else { ", 不支持CRC" }
}

/// An abort code with its meaning.
pub fn abort(out: &mut Vec<u8>, code: u32) {
    put!(out; Hex::<8>(u64::from(code)), "h ", terms::abort_code(ZH, code).unwrap_or("保留/未知的中止码"));
}

/// What a transfer came to: `1008h:00 = "..." (23字节)`.
pub fn result(out: &mut Vec<u8>, transfer: &Transfer) {
    match transfer.mux {
        Some(mux) => object::number(out, mux),
        None => put!(out; "起始未记录的", if transfer.direction == Direction::Upload { "上传" } else { "下载" }),
    }
    if let (Status::Aborted, Some(by)) = (transfer.outcome.status, transfer.outcome.abort) {
        put!(out; if transfer.direction == Direction::Upload { " 读取被" } else { " 写入被" });
        put!(out; if by.by == Side::Client { "主站中止: " } else { "从站中止: " });
        abort(out, by.code);
        return;
    }
    if transfer.outcome.status != Status::Aborted && (transfer.data.size > 0 || transfer.outcome.status == Status::Ok) {
        put!(out; " = ");
        value::transferred(out, ZH, transfer);
        put!(out; " (");
        value::size(out, ZH, transfer.data.size);
        put!(out; ")");
    }
    put!(out; match transfer.outcome.status {
        Status::Ok => "",
        Status::Open | Status::Incomplete => " [不完整]",
        Status::Aborted => " [已中止]",
        Status::Failed => " [传输失败]",
    });
}

/// The same where it becomes known only at a later frame.
pub fn later_result(out: &mut Vec<u8>, transfer: &Transfer) {
    put!(out; "第", transfer.first.no, "帧开始的传输: ");
    result(out, transfer);
}

fn place(out: &mut Vec<u8>, step: &Step) {
    match (step.place, step.answered_by) {
        (Place::Late, Some(request)) => put!(out; " [对第", request.no, "帧请求的迟到应答]"),
        (Place::Late, None) => put!(out; " [迟到的应答]"),
        (_, Some(answer)) => put!(out; " [应答见第", answer.no, "帧]"),
        (Place::Due, None) => {}
        (Place::Repeated, None) => put!(out; " [重复的请求]"),
        (Place::Uncaptured, None) if step.side == Side::Server => put!(out; " [此前未见请求]"),
        (Place::Uncaptured, None) => put!(out; " [传输起始未记录]"),
        (Place::InFlight, None) => put!(out; " [在途帧, 不计入]"),
        (Place::OutOfSequence(due), None) => put!(out; " [序列号不连续, 应为", due, "]"),
        (Place::Twin, None) => put!(out; " [同一帧被记录两次]"),
        (Place::Outside, None) => put!(out; " [此处不应出现]"),
    }
}
