//! SDO in words (CiA 301, 7.2.4): the phrase of a frame, its content, and what a transfer came to. Must not decide
//! anything: what a frame means to its transfer comes in `Step`.

use crate::sdo::abort_code::AbortCode;
use crate::sdo::exchange::expedited;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::{self, Command, Initiate, Mux, Segment, Side};
use crate::wire::sdo_command;
use crate::words::digits::{Hex, Put, put};
use crate::words::value::{self, Size};
use crate::words::{Depth, Lang, say, terms, transferred};
use crate::world::event::{Place, Step};

/// Appends the phrase of an SDO frame, and at other depths than brief its content. No line end.
pub fn step(out: &mut Vec<u8>, lang: Lang, depth: Depth, step: &Step, len: u8) {
    phrase(out, lang, depth, step);
    if depth == Depth::Brief {
        return;
    }
    let start = out.len();
    content(out, lang, step, len);
    if out.len() > start {
        out.splice(start..start, *b": ");
    }
    if let Some(transfer) = &step.result
        && !shows_result(step)
    {
        let separator = if out.len() > start { "; " } else { ": " };
        put!(out; separator);
        result(out, lang, transfer);
    }
    place(out, lang, step);
    if len != 8 {
        let size = Size(lang, len.into());
        say!(out, lang; zh: " [长度", size, ", 应为8字节]"; en: " [", size, ", expected 8]");
    }
}

/// A request to write is named as such only where no content says it.
fn phrase(out: &mut Vec<u8>, lang: Lang, depth: Depth, step: &Step) {
    match step.command {
        Command::Segment(Segment { last: false, .. }) if step.ordinal > 0 => {
            return numbered(out, lang, step.side == Side::Client, step.ordinal);
        }
        Command::InitiateDownload(..) if depth != Depth::Brief => {
            say!(out, lang; zh: "主站发送的SDO请求"; en: "SDO request sent by the client");
        }
        _ => put!(out; lang.word(sdo_command::row(&step.command, step.side).phrase)),
    }
    match step.command {
        Command::SegmentRequest { toggle } | Command::SegmentResponse { toggle } => {
            put!(out; " (toggle=", u8::from(toggle), ")");
        }
        Command::BlockSegment { seqno, .. } => say!(out, lang; zh: " (序列号=", seqno, ")"; en: " (seqno=", seqno, ")"),
        _ => {}
    }
}

/// A segment that others follow: `主站发送的第一段数据` to `第十段`, then `第11段`.
fn numbered(out: &mut Vec<u8>, lang: Lang, client: bool, number: u32) {
    const WORDS: [&str; 11] = ["", "一", "二", "三", "四", "五", "六", "七", "八", "九", "十"];
    match (lang, WORDS.get(number as usize)) {
        (Lang::Zh, Some(word)) => put!(out; if client { "主站发送的第" } else { "从站发送的第" }, *word, "段数据"),
        (Lang::Zh, None) => put!(out; if client { "主站发送的第" } else { "从站发送的第" }, number, "段数据"),
        (Lang::En, _) => {
            put!(out; "segment ", number, if client { " of data from the client" } else { " of data from the server" });
        }
    }
}

fn content(out: &mut Vec<u8>, lang: Lang, step: &Step, len: u8) {
    match step.command {
        Command::InitiateUpload(mux) => {
            put!(out; lang.pick("读 ", "read "));
            named(out, lang, mux, step);
        }
        Command::InitiateDownload(mux, initiate) => {
            put!(out; lang.pick("写 ", "write "));
            named(out, lang, mux, step);
            initiated(out, lang, mux, initiate, step, len);
        }
        Command::UploadInitiated(..) | Command::DownloadInitiated(_) if shows_result(step) => {
            if let Some(transfer) = &step.result {
                result(out, lang, transfer);
            }
        }
        Command::UploadInitiated(mux, initiate) => {
            put!(out; mux);
            initiated(out, lang, mux, initiate, step, len);
        }
        Command::DownloadInitiated(mux) => put!(out; mux),
        Command::Segment(segment) => segment_data(out, lang, segment, len),
        Command::InitiateBlockDownload { mux, crc, size } => {
            put!(out; lang.pick("写 ", "write "));
            named(out, lang, mux, step);
            block(out, lang, size, crc);
        }
        Command::InitiateBlockUpload { mux, crc, blksize, threshold } => {
            put!(out; lang.pick("读 ", "read "));
            named(out, lang, mux, step);
            block_upload(out, lang, crc, blksize, threshold);
        }
        Command::BlockUploadInitiated { mux, crc, size } => {
            put!(out; mux);
            block(out, lang, size, crc);
        }
        Command::BlockDownloadInitiated { mux, crc, blksize } => {
            let crc = crc_word(lang, crc);
            say!(out, lang; zh: mux, ", 块大小=", blksize, crc; en: mux, ", blksize=", blksize, crc);
        }
        Command::BlockAck { ackseq, blksize } => say!(out, lang;
            zh: "确认序号=", ackseq, ", 下一块大小=", blksize; en: "ackseq=", ackseq, ", next blksize=", blksize),
        Command::BlockSegment { data, .. } => value::segment(out, &data),
        Command::EndBlock { unused, crc } => {
            let (crc, unused) = (Hex::<4>(u64::from(crc)), Size(lang, unused.into()));
            say!(out, lang;
                zh: "CRC=", crc, "h, 最后一段", unused, "未使用";
                en: "CRC=", crc, "h, ", unused, " of the last segment unused");
        }
        Command::Abort(mux, code) => aborted(out, lang, mux, code, step),
        Command::Truncated(_) if len == 0 => {}
        Command::Truncated(command) | Command::Unknown(command) => {
            let command = Hex::<2>(u64::from(command));
            say!(out, lang; zh: "命令字节 ", command, "h"; en: "command byte ", command, "h");
        }
        Command::Undetermined(bytes) => candidates(out, lang, step, bytes),
        Command::SegmentRequest { .. }
        | Command::SegmentResponse { .. }
        | Command::StartBlockUpload
        | Command::BlockEnded => {}
    }
}

/// Appends the possible meanings of bytes whose transfer is not in the capture.
fn candidates(out: &mut Vec<u8>, lang: Lang, step: &Step, bytes: [u8; 8]) {
    if step.place == Place::Outside {
        return value::segment(out, &bytes);
    }
    let [command, data @ ..] = bytes;
    let seqno = command & 0x7F;
    value::segment(out, &data);
    say!(out, lang; zh: ", 无法判定: 块数据段", seqno; en: ", undetermined: block segment ", seqno);
    let plain = wire::decode(step.side, bytes);
    if !plain.is_unreadable() {
        let (zh, en) = sdo_command::row(&plain, step.side).phrase;
        say!(out, lang; zh: ", 或", zh; en: ", or ", en);
    }
}

/// Returns true if the content is already the transfer's result.
fn shows_result(step: &Step) -> bool {
    step.result
        .as_ref()
        .is_some_and(|transfer| transfer.outcome.status == Status::Ok || transfer.outcome.status == Status::Aborted)
        && matches!(step.command, Command::UploadInitiated(..) | Command::DownloadInitiated(_) | Command::Abort(..))
}

fn named(out: &mut Vec<u8>, lang: Lang, mux: Mux, step: &Step) {
    put!(out; mux);
    value::name(out, lang, mux, &step.described);
}

/// Behind the object of an expedited transfer its value, of a segmented one its size.
fn initiated(out: &mut Vec<u8>, lang: Lang, mux: Mux, initiate: Initiate, step: &Step, len: u8) {
    if initiate.expedited {
        let bytes = expedited(Some(mux), step.described.profile, &initiate, len);
        put!(out; " = ");
        value::of_object(out, lang, mux, &step.described, bytes);
    } else {
        let size = Announced(lang, initiate.size());
        say!(out, lang; zh: ", 分段传输, 长度", size; en: ", segmented, ", size);
    }
}

fn block(out: &mut Vec<u8>, lang: Lang, size: Option<u32>, crc: bool) {
    let size = Announced(lang, size);
    say!(out, lang; zh: ", 块传输, 长度", size, crc_word(lang, crc); en: ", block, ", size, crc_word(lang, crc));
}

fn block_upload(out: &mut Vec<u8>, lang: Lang, crc: bool, blksize: u8, threshold: u8) {
    let crc = crc_word(lang, crc);
    say!(out, lang; zh: ", 块传输, 块大小=", blksize, crc; en: ", block, blksize=", blksize, crc);
    if threshold > 0 {
        let size = Size(lang, threshold.into());
        say!(out, lang; zh: ", 协议切换阈值=", size; en: ", protocol switch threshold ", size);
    }
}

/// The size that an initiating frame announces.
struct Announced(Lang, Option<u32>);

impl Put for Announced {
    fn put(&self, out: &mut Vec<u8>) {
        match *self {
            Self(lang, Some(size)) => put!(out; Size(lang, size.into())),
            Self(lang, None) => put!(out; lang.pick("未知", "size not indicated")),
        }
    }
}

fn crc_word(lang: Lang, crc: bool) -> &'static str {
    if crc { lang.pick(", 支持CRC", ", CRC supported") } else { lang.pick(", 不支持CRC", ", CRC not supported") }
}

fn segment_data(out: &mut Vec<u8>, lang: Lang, segment: Segment, len: u8) {
    let carried = (7 - usize::from(segment.unused)).min(usize::from(len.saturating_sub(1)));
    if carried > 0 {
        value::segment(out, segment.data.get(..carried).unwrap_or(&[]));
    } else {
        say!(out, lang; zh: "无数据"; en: "no data");
    }
    if segment.unused > 0 {
        let unused = Size(lang, segment.unused.into());
        say!(out, lang; zh: ", ", unused, "未使用"; en: ", ", unused, " unused");
    }
}

fn aborted(out: &mut Vec<u8>, lang: Lang, mux: Mux, code: u32, step: &Step) {
    put!(out; step.mux.unwrap_or(mux), " ");
    abort(out, lang, AbortCode::Sdo(code));
    if step.mux.is_some_and(|known| known != mux) {
        say!(out, lang; zh: " (帧中为", mux, ")"; en: " (frame names ", mux, ")");
    }
}

/// An abort code with its meaning.
pub fn abort(out: &mut Vec<u8>, lang: Lang, code: AbortCode) {
    let unknown = lang.pick("保留/未知的中止码", "reserved or unknown abort code");
    put!(out; code, "h ", terms::abort_code(lang, code).unwrap_or(unknown));
}

/// Appends the result of a transfer: `1008h:00 = "..." (23字节)`.
pub fn result(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    let upload = transfer.direction == Direction::Upload;
    match transfer.mux {
        Some(mux) => put!(out; mux),
        None if upload => say!(out, lang; zh: "未录到开头的上传"; en: "upload (start not captured)"),
        None => say!(out, lang; zh: "未录到开头的下载"; en: "download (start not captured)"),
    }
    if let (Status::Aborted, Some(by)) = (transfer.outcome.status, transfer.outcome.abort) {
        match (upload, by.by) {
            (true, Side::Client) => say!(out, lang; zh: " 读取被主站中止: "; en: " upload aborted by the client: "),
            (true, Side::Server) => say!(out, lang; zh: " 读取被从站中止: "; en: " upload aborted by the server: "),
            (false, Side::Client) => say!(out, lang; zh: " 写入被主站中止: "; en: " download aborted by the client: "),
            (false, Side::Server) => say!(out, lang; zh: " 写入被从站中止: "; en: " download aborted by the server: "),
        }
        abort(out, lang, by.code);
        if !transfer.data.requested.is_empty() {
            put!(out; ", ");
            transferred::transferred(out, lang, transfer);
        }
        return;
    }
    if transfer.outcome.status != Status::Aborted && (transfer.data.size > 0 || transfer.outcome.status == Status::Ok) {
        put!(out; " = ");
        transferred::transferred(out, lang, transfer);
        put!(out; " (", Size(lang, transfer.data.size), ")");
    } else if !transfer.data.requested.is_empty() {
        put!(out; ": ");
        transferred::transferred(out, lang, transfer);
    }
    match transfer.outcome.status {
        Status::Ok => {}
        Status::Open | Status::Incomplete => say!(out, lang; zh: " [不完整]"; en: " [incomplete]"),
        Status::Aborted => say!(out, lang; zh: " [已中止]"; en: " [aborted]"),
        Status::Failed => say!(out, lang; zh: " [传输失败]"; en: " [failed]"),
    }
}

/// The same where it becomes known only at a later frame.
pub fn later_result(out: &mut Vec<u8>, lang: Lang, transfer: &Transfer) {
    let first = transfer.first.no;
    say!(out, lang; zh: "第", first, "帧开始的传输: "; en: "transfer started in frame ", first, ": ");
    result(out, lang, transfer);
}

/// Appends the place of a frame in its transfer unless it is the expected one.
fn place(out: &mut Vec<u8>, lang: Lang, step: &Step) {
    match (step.place, step.answered_by.as_deref()) {
        (Place::Late, Some(request)) => say!(out, lang;
            zh: " [第", request.no, "帧请求的延迟响应]"; en: " [late response to frame ", request.no, "]"),
        (Place::Late, None) => say!(out, lang; zh: " [延迟的响应]"; en: " [late response]"),
        (_, Some(answer)) => {
            say!(out, lang; zh: " [响应在第", answer.no, "帧, 记录次序颠倒]"; en: " [response in frame ", answer.no, ", captured in reverse order]");
        }
        (Place::Due, None) => {}
        (Place::Repeated, None) => say!(out, lang; zh: " [重复的请求]"; en: " [repeated request]"),
        (Place::Uncaptured, None) if step.side == Side::Server => {
            say!(out, lang; zh: " [此前未见请求]"; en: " [no previous request]");
        }
        (Place::Uncaptured, None) => {
            say!(out, lang; zh: " [未录到传输开头]"; en: " [transfer start not captured]");
        }
        (Place::InFlight, None) => {
            say!(out, lang; zh: " [对方的响应到达前已发出, 不计入传输]"; en: " [sent before the response arrived, not counted]")
        }
        (Place::OutOfSequence(due), None) => say!(out, lang;
            zh: " [序列号不连续, 应为", due, "]"; en: " [out of sequence, expected ", due, "]"),
        (Place::Duplicate, None) => say!(out, lang; zh: " [同一帧被记录两次]"; en: " [captured twice]"),
        (Place::Outside, None) => say!(out, lang; zh: " [此处不应出现]"; en: " [not expected here]"),
    }
}
