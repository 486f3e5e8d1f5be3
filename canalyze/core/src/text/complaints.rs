//! What is said on standard error: lines of a capture that cannot be read, what a capture says of itself, and what a
//! converted one has lost.
//!
//! One line each, with file and line. File names and buses come from outside: they are escaped.

use super::digits::put;
use super::{Lang, escape, findings, losses};
use crate::finding::Finding;
use crate::readers::{Place, Unreadable};
use crate::writers::loss::Loss;

fn line(lang: Lang, file: &[u8], place: Place, words: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    match (place, lang) {
        (Place::Line(number), _) => put!(&mut out; ":", number, ": "),
        (Place::Byte(offset), Lang::Zh) => put!(&mut out; ": 偏移", offset, ": "),
        (Place::Byte(offset), Lang::En) => put!(&mut out; ": byte ", offset, ": "),
        (Place::Live, _) => put!(&mut out; ": "),
    }
    words(&mut out);
    String::from_utf8_lossy(&out).into_owned()
}

/// One line or record that cannot be read.
pub fn unreadable(lang: Lang, file: &[u8], place: Place, reason: Unreadable) -> String {
    let of_text = matches!(place, Place::Line(_));
    let words = match (lang, reason) {
        (Lang::Zh, Unreadable::NoFrame) => "无法读取: 不是CAN帧",
        (Lang::Zh, Unreadable::Identifier) => "无法读取: CAN标识符超出范围",
        (Lang::Zh, Unreadable::Length) => "无法读取: 长度无效",
        (Lang::Zh, Unreadable::Data) => "无法读取: 数据字节与长度不符",
        (Lang::Zh, Unreadable::Cut) if of_text => "无法读取: 该行被截断",
        (Lang::Zh, Unreadable::Cut) => "无法读取: 该记录被截断",
        (Lang::Zh, Unreadable::CanXl) => "无法读取: 尚不支持CAN XL帧",
        (Lang::En, Unreadable::NoFrame) => "cannot be read: no CAN frame",
        (Lang::En, Unreadable::Identifier) => "cannot be read: CAN identifier out of range",
        (Lang::En, Unreadable::Length) => "cannot be read: invalid length",
        (Lang::En, Unreadable::Data) => "cannot be read: the data bytes do not match the length",
        (Lang::En, Unreadable::Cut) if of_text => "cannot be read: the line is cut off",
        (Lang::En, Unreadable::Cut) => "cannot be read: the record is cut off",
        (Lang::En, Unreadable::CanXl) => "cannot be read: CAN XL frames are not supported",
    };
    line(lang, file, place, |out| put!(out; words))
}

/// All lines, or records by their offsets, of a file that cannot be read, as ranges; the list may be cut. `first` is
/// where the first one is.
pub fn unreadable_lines(lang: Lang, file: &[u8], first: Place, count: u64, ranges: &[(u64, u64)]) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    let of_text = matches!(first, Place::Line(_));
    if first == Place::Live {
        match lang {
            Lang::Zh => put!(&mut out; ": 共", count, "帧无法读取"),
            Lang::En => put!(&mut out; ": ", count, " frames cannot be read"),
        }
        return String::from_utf8_lossy(&out).into_owned();
    }
    match (lang, of_text) {
        (Lang::Zh, true) => put!(&mut out; ": 共", count, "行无法读取: 第"),
        (Lang::Zh, false) => put!(&mut out; ": 共", count, "条记录无法读取: 偏移"),
        (Lang::En, true) => put!(&mut out; ": ", count, " lines cannot be read: "),
        (Lang::En, false) => put!(&mut out; ": ", count, " records cannot be read: byte "),
    }
    let mut listed = 0;
    for (no, (from, to)) in ranges.iter().enumerate() {
        if no > 0 {
            put!(&mut out; ", ");
        }
        put!(&mut out; *from);
        if to > from {
            put!(&mut out; "-", *to);
        }
        listed += to - from + 1;
    }
    if listed < count {
        put!(&mut out; ", ...");
    }
    if lang == Lang::Zh && of_text {
        put!(&mut out; "行");
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// What a capture says of itself, at this place; `finding` is what it raised. Why live buses have lost frames their
/// receivers know better than the rule.
pub fn marker(lang: Lang, file: &[u8], place: Place, finding: Option<&Finding>) -> String {
    let cause = |finding: &Finding| match place {
        Place::Live => "",
        _ => lang.of(finding.code.rule().cause),
    };
    line(lang, file, place, |out| match (lang, finding) {
        (_, Some(finding)) => {
            put!(out; finding.code.rule().id, " ");
            findings::message(out, lang, finding);
            let cause = cause(finding);
            put!(out; if cause.is_empty() { "" } else { ". " }, cause);
        }
        (Lang::Zh, None) => put!(out; "只有ERROR字样而没有内容的错误标记, 不计为帧"),
        (Lang::En, None) => put!(out; "error marker without content, not counted as a frame"),
    })
}

/// A file that goes on where another ended begins before that end, by so much.
pub fn step_back(lang: Lang, file: &[u8], before: &[u8], back_ns: i64) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    let (seconds, ms) = (back_ns / 1_000_000_000, back_ns / 1_000_000 % 1000);
    let back = format!("{seconds}.{ms:03}");
    match lang {
        Lang::Zh => {
            put!(&mut out; ": 第一帧的时间戳比 ");
            escape::terminal(&mut out, before);
            put!(&mut out; " 的最后一帧早", back.as_str(), " s; 仍按给出的顺序读取. 若时间戳出自同一时钟, 请用 --merge 按时间合并");
        }
        Lang::En => {
            put!(&mut out; ": its first stamp is ", back.as_str(), " s before the last one of ");
            escape::terminal(&mut out, before);
            put!(&mut out; "; read in the given order all the same. If the stamps are of one clock, --merge joins the files by time");
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// A description was given for nodes that have no frame in the capture.
pub fn absent(lang: Lang, file: &[u8], mut nodes: Vec<u8>) -> String {
    nodes.sort_unstable();
    nodes.dedup();
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    put!(&mut out; match (lang, nodes.len()) {
        (Lang::Zh, _) => ": 记录中没有节点",
        (Lang::En, 1) => ": the capture has no frame of node ",
        (Lang::En, _) => ": the capture has no frame of nodes ",
    });
    let mut rest = nodes.as_slice();
    while let [first, ..] = rest {
        let run = rest.iter().zip(*first..).take_while(|(node, due)| *node == due).count();
        let last = first + (run - 1) as u8;
        if rest.len() < nodes.len() {
            put!(&mut out; ", ");
        }
        put!(&mut out; *first);
        if run > 1 {
            put!(&mut out; "-", last);
        }
        rest = rest.get(run..).unwrap_or(&[]);
    }
    if lang == Lang::Zh {
        put!(&mut out; "的帧");
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// What a file in another format could not hold, and how often.
pub fn lost(lang: Lang, file: &[u8], loss: Loss, count: u64) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    put!(&mut out; ": ");
    losses::loss(&mut out, lang, loss, count);
    String::from_utf8_lossy(&out).into_owned()
}

/// The filter let nothing through.
pub fn nothing_shown(lang: Lang, frames: u64) -> String {
    match lang {
        Lang::Zh => format!("canalyze: 没有内容符合过滤条件 (共{frames}帧)"),
        Lang::En => format!("canalyze: nothing passes the filter ({frames} frames)"),
    }
}

/// Why a `--mcap-map` cannot be read.
pub fn mcap_map(lang: Lang, mistake: &crate::readers::mcap::Mistake) -> String {
    let words: Vec<&str> = crate::readers::mcap::Role::NAMES.iter().map(|(word, _)| *word).collect();
    let (part, words) = (&mistake.0, words.join(" "));
    match lang {
        Lang::Zh => {
            format!(
                "--mcap-map 的“{part}”无法识别: 应为 topic= 及 {words} 中的键=字段名, 例如 topic=/x,id=can_id,data=payload"
            )
        }
        Lang::En => {
            format!(
                "--mcap-map: '{part}' is unknown: use topic= and KEY=FIELD with one of {words}, as in topic=/x,id=can_id,data=payload"
            )
        }
    }
}

/// Why what stands behind a channel's name cannot be read.
pub fn masks(lang: Lang, mistake: &crate::masks::Mistake) -> String {
    let crate::masks::Mistake(part, whole) = mistake;
    match lang {
        Lang::Zh => format!(
            "“{whole}”中的过滤条件“{part}”无法识别: 应为 标识符:掩码, 标识符~掩码 (取反), #错误掩码 或 j (全部满足), 均为十六进制, 例如 can0,123:7FF,#1F"
        ),
        Lang::En => format!(
            "filter '{part}' of '{whole}' is unknown: use ID:MASK, ID~MASK (all others), #ERRORMASK or j (all must match), in hexadecimal, as in can0,123:7FF,#1F"
        ),
    }
}

/// Why a filter cannot be read.
pub fn filter(lang: Lang, mistake: &crate::filter::Mistake) -> String {
    use crate::filter::{Mistake, SERVICES};
    match (lang, mistake) {
        (Lang::Zh, Mistake::Key(word)) => {
            format!(
                "过滤条件“{word}”无法识别: 应为 service= node= id= bus= t= frame= 之一, 例如 'service=sdo,emcy node=5'"
            )
        }
        (Lang::En, Mistake::Key(word)) => {
            format!(
                "filter '{word}' is unknown: use service= node= id= bus= t= or frame=, as in 'service=sdo,emcy node=5'"
            )
        }
        (lang, Mistake::Value(key, value)) => {
            let allowed = match (lang, key.as_str()) {
                (_, "service") => SERVICES.join(" "),
                (Lang::Zh, "node") => "十进制节点ID或范围, 如 5 或 1-9".into(),
                (Lang::En, "node") => "a decimal node-ID or range, such as 5 or 1-9".into(),
                (Lang::Zh, "id") => "十六进制CAN标识符或范围, 如 185 或 180-1FF".into(),
                (Lang::En, "id") => "a hexadecimal CAN identifier or range, such as 185 or 180-1FF".into(),
                (Lang::Zh, "t") => "以秒计的时间段, 如 1.0..2.5 或 10..".into(),
                (Lang::En, "t") => "a span in seconds, such as 1.0..2.5 or 10..".into(),
                (Lang::Zh, "frame") => "帧序号或范围, 如 12 或 10-20".into(),
                (Lang::En, "frame") => "the number of a frame or a range, such as 12 or 10-20".into(),
                (Lang::Zh, _) => "总线名".into(),
                (Lang::En, _) => "a bus name".into(),
            };
            match lang {
                Lang::Zh => format!("过滤条件 {key}= 不接受“{value}”, 可用: {allowed}"),
                Lang::En => format!("filter {key}= does not take '{value}', use: {allowed}"),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binary_files_have_records() {
        let (line, byte) = (Place::Line(7), Place::Byte(7));
        let said = |lang, place| unreadable(lang, b"a", place, Unreadable::Cut);
        assert_eq!(said(Lang::En, line), "a:7: cannot be read: the line is cut off");
        assert_eq!(said(Lang::En, byte), "a: byte 7: cannot be read: the record is cut off");
        assert_eq!(said(Lang::Zh, line), "a:7: 无法读取: 该行被截断");
        assert_eq!(said(Lang::Zh, byte), "a: 偏移7: 无法读取: 该记录被截断");
        let all = |lang, place| unreadable_lines(lang, b"a", place, 9, &[(7, 8), (20, 20)]);
        assert_eq!(all(Lang::En, line), "a: 9 lines cannot be read: 7-8, 20, ...");
        assert_eq!(all(Lang::En, byte), "a: 9 records cannot be read: byte 7-8, 20, ...");
        assert_eq!(all(Lang::Zh, line), "a: 共9行无法读取: 第7-8, 20, ...行");
        assert_eq!(all(Lang::Zh, byte), "a: 共9条记录无法读取: 偏移7-8, 20, ...");
    }
}
