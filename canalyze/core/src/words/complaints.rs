//! Lines on standard error: unreadable lines of a capture, reports of a capture about itself, and losses of a converted
//! one.
//!
//! One line each, with file and line. File names and buses come from outside and are escaped.

use super::digits::put;
use super::{Lang, escape, findings, losses, say};
use crate::bytes::frame::MAX_BUSES;
use crate::bytes::ns::Ns;
use crate::bytes::readers::{FilePlace, Unreadable};
use crate::bytes::writers::loss::Loss;
use crate::rules::finding::Finding;

fn line(lang: Lang, file: &[u8], place: FilePlace, words: impl FnOnce(&mut Vec<u8>)) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    match place {
        FilePlace::Line(number) => put!(&mut out; ":", number, ": "),
        FilePlace::Byte(offset) => say!(&mut out, lang; zh: ": 偏移", offset, ": "; en: ": byte ", offset, ": "),
        FilePlace::Live => put!(&mut out; ": "),
    }
    words(&mut out);
    String::from_utf8_lossy(&out).into_owned()
}

/// An unreadable line or record.
pub fn unreadable(lang: Lang, file: &[u8], place: FilePlace, reason: Unreadable) -> String {
    let of_text = matches!(place, FilePlace::Line(_));
    line(lang, file, place, |out| {
        say!(out, lang; zh: "无法读取: "; en: "cannot be read: ");
        why(out, lang, reason, of_text);
    })
}

/// A line that is meant as a frame, and the reason why it is invalid.
pub fn no_frame(lang: Lang, text: &[u8], reason: Unreadable) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, text);
    put!(&mut out; ": ");
    let digits = text.iter().rposition(|byte| *byte == b'#').and_then(|mark| text.get(mark + 1..));
    let digits = digits.map(|digits| digits.iter().filter(|byte| byte.is_ascii_hexdigit()).count());
    let reason = if disagrees(text) { Unreadable::Data } else { reason };
    match (reason, digits) {
        (Unreadable::Data, Some(digits)) if digits % 2 == 1 => {
            say!(&mut out, lang; zh: "十六进制数字的个数为奇数"; en: "odd number of hexadecimal digits");
        }
        (Unreadable::Length, Some(_)) if memchr::memmem::find(text, b"##").is_some() => {
            say!(&mut out, lang; zh: "数据多于64字节"; en: "more than 64 bytes of data");
        }
        (Unreadable::Length, Some(digits)) if digits > 16 => say!(&mut out, lang;
            zh: "数据多于8字节 (CAN FD帧写作 ID##标志位数据, 至多64字节)";
            en: "more than 8 bytes of data (CAN FD is written with ## and a digit of flags, up to 64 bytes)"),
        _ => why(&mut out, lang, reason, true),
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// Returns true if candump's console form has another number of bytes than indicated: `60A [4] 40 08`.
fn disagrees(text: &[u8]) -> bool {
    let brackets = |byte: &u8| matches!(byte, b'[' | b']');
    let mut parts = text.split(brackets).skip(1);
    let (Some(said), Some(bytes)) = (parts.next(), parts.next()) else { return false };
    let said = std::str::from_utf8(said).ok().and_then(|said| said.trim().parse::<usize>().ok());
    let there = bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count();
    said.is_some_and(|said| said != there)
}

/// Appends the reason why a line or a record is unreadable.
fn why(out: &mut Vec<u8>, lang: Lang, reason: Unreadable, of_text: bool) {
    match reason {
        Unreadable::NoFrame => say!(out, lang; zh: "不是CAN帧"; en: "not a CAN frame"),
        Unreadable::Identifier => say!(out, lang; zh: "CAN标识符超出范围"; en: "CAN identifier out of range"),
        Unreadable::Length => say!(out, lang; zh: "长度无效"; en: "invalid length"),
        Unreadable::Data => {
            say!(out, lang; zh: "数据字节与长度不符"; en: "data bytes do not match the length");
        }
        Unreadable::Cut if of_text => say!(out, lang; zh: "该行被截断"; en: "line is truncated"),
        Unreadable::Cut => say!(out, lang; zh: "该记录被截断"; en: "record is truncated"),
        Unreadable::CanXl => say!(out, lang; zh: "不支持CAN XL帧"; en: "CAN XL frames are not supported"),
        Unreadable::Bus => say!(out, lang; zh: "总线过多"; en: "too many buses"),
        Unreadable::NoIdentifier { cell } => say!(out, lang;
            zh: "第", cell, "格不是标识符"; en: "cell ", cell, " is not an identifier"),
        Unreadable::Spread => say!(out, lang;
            zh: "数据字节分散在无法理解的多列或多行中";
            en: "the bytes are spread over columns or rows that are not understood"),
        Unreadable::Base { hexadecimal, decimal } => {
            let (one, other) = (format!("{hexadecimal:03X}h"), format!("{decimal:03X}h"));
            say!(out, lang;
                zh: "标识符可能是十六进制 (", one.as_str(), ") 或十进制 (", other.as_str(), "); 表头请写作 ID (hex) 或 ID (dec)";
                en: "identifiers may be hexadecimal (", one.as_str(), ") or decimal (", other.as_str(),
                    "); name their column ID (hex) or ID (dec)");
        }
        Unreadable::Exported => say!(out, lang;
            zh: "是canalyze导出的表格; 请读取原来的记录文件"; en: "a table that canalyze exported; read the capture itself"),
    }
}

/// All unreadable lines of a file, or records by their offsets, as ranges; the list may be cut. `first` is the place of
/// the first one.
pub fn unreadable_lines(lang: Lang, file: &[u8], first: FilePlace, count: u64, ranges: &[(u64, u64)]) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    let of_text = matches!(first, FilePlace::Line(_));
    if first == FilePlace::Live {
        say!(&mut out, lang; zh: ": 共", count, "帧无法读取"; en: ": ", count, " frames cannot be read");
        return String::from_utf8_lossy(&out).into_owned();
    }
    let mut list = Vec::new();
    let mut listed = 0;
    for (no, (from, to)) in ranges.iter().enumerate() {
        put!(&mut list; if no > 0 { ", " } else { "" }, *from);
        if to > from {
            put!(&mut list; "-", *to);
        }
        listed += to - from + 1;
    }
    if listed < count {
        put!(&mut list; ", ...");
    }
    let list = |out: &mut Vec<u8>| out.extend_from_slice(&list);
    if of_text {
        say!(&mut out, lang; zh: ": 共", count, "行无法读取: 第", list, "行"; en: ": ", count, " lines cannot be read: ", list);
    } else {
        say!(&mut out, lang;
            zh: ": 共", count, "条记录无法读取: 偏移", list; en: ": ", count, " records cannot be read: byte ", list);
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// The number of frames of a file on buses beyond the maximum.
pub fn further_buses(lang: Lang, file: &[u8], count: u64) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    say!(&mut out, lang;
        zh: ": 总线多于", MAX_BUSES, "条; 其余总线上的", count, "帧已跳过";
        en: ": more than ", MAX_BUSES, " buses; ", count, " frames on the others skipped");
    String::from_utf8_lossy(&out).into_owned()
}

/// A report of a capture about itself, at this place; `finding` is its finding. The cause of lost frames of a live bus
/// is known better to its receiver than to the rule.
pub fn marker(lang: Lang, file: &[u8], place: FilePlace, finding: Option<&Finding>) -> String {
    let cause = |finding: &Finding| match place {
        FilePlace::Live => "",
        _ => lang.of(finding.code.rule().cause),
    };
    line(lang, file, place, |out| match finding {
        Some(finding) => {
            put!(out; finding.code.rule().id, " ");
            findings::message(out, lang, finding);
            let cause = cause(finding);
            put!(out; if cause.is_empty() { "" } else { ". " }, cause);
        }
        None => {
            say!(out, lang; zh: "只有ERROR标记而没有内容, 不计为帧"; en: "ERROR marker without content, not counted as a frame")
        }
    })
}

/// The number of damaged places of a file; only the first ones were named.
pub fn damages(lang: Lang, file: &[u8], count: u64) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    say!(&mut out, lang; zh: ": 共", count, "处损坏"; en: ": ", count, " damaged places in total");
    String::from_utf8_lossy(&out).into_owned()
}

/// The number of timestamps of a file outside the range that can be shown.
pub fn beyond(lang: Lang, file: &[u8], count: u64) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    say!(&mut out, lang;
        zh: ": ", count, "个时间戳超出可表示的范围 (1677-09-21至2262-04-11), 已取该范围的边界值";
        en: ": ", count, if count == 1 { " timestamp" } else { " timestamps" },
            " outside the representable range (1677-09-21 to 2262-04-11), set to its limit");
    String::from_utf8_lossy(&out).into_owned()
}

/// The identifiers of a file are read in another byte order than its format requires.
pub fn swapped(lang: Lang, file: &[u8]) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    say!(&mut out, lang;
        zh: ": CAN标识符为小端序, 不符合该格式 (应为大端序); 已按小端序读取";
        en: ": CAN identifiers are little-endian, the format requires big-endian; read as little-endian");
    String::from_utf8_lossy(&out).into_owned()
}

/// A file that continues another one begins before its end, by `back_ns`.
pub fn step_back(lang: Lang, file: &[u8], before: &[u8], back_ns: Ns) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    let (seconds, ms) = (back_ns.as_ns() / 1_000_000_000, back_ns.as_ns() / 1_000_000 % 1000);
    let back = format!("{seconds}.{ms:03}");
    let before = |out: &mut Vec<u8>| escape::terminal(out, before);
    say!(&mut out, lang;
        zh: ": 第一帧的时间戳比 ", before, " 的最后一帧早", back.as_str(), " s; 仍按给出的顺序读取。",
            "若时间戳来自同一时钟, 请用 --merge 按时间合并";
        en: ": first timestamp is ", back.as_str(), " s before the last one of ", before,
            "; read in the given order anyway. If the timestamps share one clock, use --merge to merge the files by time");
    String::from_utf8_lossy(&out).into_owned()
}

/// The first frame of a file is far from the last one of the previous file: `back_ns` before it.
pub fn far_apart(lang: Lang, file: &[u8], before: &[u8], back_ns: Ns) -> String {
    const HOUR_NS: u64 = 3_600_000_000_000;
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    let hours = back_ns.as_ns().unsigned_abs() / HOUR_NS;
    let (count, unit) = if hours < 48 { (hours, " h") } else { (hours / 24, lang.pick(" 天", " days")) };
    let before = |out: &mut Vec<u8>| escape::terminal(out, before);
    let early = back_ns > Ns::ZERO;
    say!(&mut out, lang;
        zh: ": 第一帧比 ", before, " 的最后一帧", if early { "早 " } else { "晚 " }, count, unit,
            "; 所有文件按给出的顺序作为一个记录读取。若互不相关, 请逐个文件读取, 或用 canalyze check (逐个文件判断)",
            if early { "; 若是同一次记录的各部分, 请用 --merge 按时间合并" } else { "" };
        en: ": begins ", count, unit, if early { " before" } else { " after" }, " the last frame of ", before,
            "; all files are read as one capture in the given order. If they are unrelated, read them one by one, or use ",
            "canalyze check, which judges each file by itself",
            if early { "; if they are parts of one recording, use --merge to merge them by time" } else { "" });
    String::from_utf8_lossy(&out).into_owned()
}

/// A description was given for nodes without a frame in the capture.
pub fn absent(lang: Lang, file: &[u8], mut nodes: Vec<u8>) -> String {
    nodes.sort_unstable();
    nodes.dedup();
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    let mut list = Vec::new();
    let mut rest = nodes.as_slice();
    while let [first, ..] = rest {
        let run = rest.iter().zip(*first..).take_while(|(node, due)| *node == due).count();
        let last = first + (run - 1) as u8;
        put!(&mut list; if rest.len() < nodes.len() { ", " } else { "" }, *first);
        if run > 1 {
            put!(&mut list; "-", last);
        }
        rest = rest.get(run..).unwrap_or(&[]);
    }
    let list = |out: &mut Vec<u8>| out.extend_from_slice(&list);
    let noun = if nodes.len() == 1 { "node " } else { "nodes " };
    say!(&mut out, lang; zh: ": 记录中没有节点", list, "的帧"; en: ": no frames of ", noun, list, " in the capture");
    String::from_utf8_lossy(&out).into_owned()
}

/// The number of frames with a loss in the format of a converted file.
pub fn lost(lang: Lang, file: &[u8], loss: Loss, count: u64) -> String {
    let mut out = Vec::new();
    escape::terminal(&mut out, file);
    put!(&mut out; ": ");
    losses::loss(&mut out, lang, loss, count);
    String::from_utf8_lossy(&out).into_owned()
}

/// Frames that were requested by their numbers, from and to, are not in the capture.
pub fn no_such_frames(lang: Lang, spans: &[(u32, u32)], frames: u64) -> String {
    let span = |(from, to): &(u32, u32)| if from == to { from.to_string() } else { format!("{from}-{to}") };
    let spans: Vec<String> = spans.iter().map(span).collect();
    match lang {
        Lang::Zh => format!("canalyze: 没有第{}帧: 记录中有第1-{frames}帧", spans.join("、")),
        Lang::En => format!("canalyze: no frame {}: the capture has frames 1-{frames}", spans.join(", ")),
    }
}

/// No frame passes the filter.
pub fn nothing_shown(lang: Lang, frames: u64) -> String {
    match lang {
        Lang::Zh => format!("canalyze: 没有符合条件的帧 (共{frames}帧)"),
        Lang::En => format!("canalyze: no frame matches the filter ({frames} frames)"),
    }
}

/// The capture should end at a time, but its frames have none.
pub fn timeless(lang: Lang) -> String {
    let zh = "canalyze: 记录中没有时间戳, --at 不起作用: 列出的是记录结束时的情况";
    lang.pick(zh, "canalyze: no timestamps in the capture, so that --at has no effect: shown as of the end").to_owned()
}

/// The reason why a `--mcap-map` is invalid.
pub fn mcap_map(lang: Lang, mistake: &crate::bytes::readers::mcap::Mistake) -> String {
    let words: Vec<&str> = crate::bytes::readers::mcap::Role::NAMES.iter().map(|(word, _)| *word).collect();
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

/// The reason why the filter behind a channel's name is invalid.
pub fn masks(lang: Lang, mistake: &crate::bytes::masks::MaskMistake) -> String {
    let crate::bytes::masks::MaskMistake(part, whole) = mistake;
    match lang {
        Lang::Zh => format!(
            "“{whole}”中的过滤条件“{part}”无法识别: 应为 标识符:掩码, 标识符~掩码 (取反), #错误掩码 或 j (全部满足), 均为十六进制, 例如 can0,123:7FF,#1F"
        ),
        Lang::En => format!(
            "filter '{part}' of '{whole}' is unknown: use ID:MASK, ID~MASK (all others), #ERRORMASK or j (all must match), in hexadecimal, as in can0,123:7FF,#1F"
        ),
    }
}

/// The reason why a filter is invalid.
pub fn filter(lang: Lang, mistake: &crate::views::filter::FilterMistake) -> String {
    use crate::views::filter::{FilterMistake, SERVICES};
    let (key, value) = match mistake {
        FilterMistake::Key(word) => {
            let example = "'service=sdo,emcy node=5'";
            let keys = "service= node= id= bus= t= frame= object= code= severity= text=";
            return match lang {
                Lang::Zh => {
                    format!("过滤条件“{word}”无法识别: 应为 {keys} 之一, 例如 {example}")
                }
                Lang::En => {
                    format!("filter '{word}' is unknown: use one of {keys}, as in {example}")
                }
            };
        }
        FilterMistake::Node(value) => {
            return match lang {
                Lang::Zh => format!("过滤条件 node={value}: 节点ID应为1到127"),
                Lang::En => format!("filter node={value}: a node-ID is 1 to 127"),
            };
        }
        FilterMistake::Value(key, value) => (key, value),
    };
    let services = SERVICES.join(" ");
    let allowed = match key.as_str() {
        "service" => services.as_str(),
        "node" => lang.pick("节点ID或范围, 如 5、0x0A 或 1-9", "a node-ID or range, such as 5, 0x0A or 1-9"),
        "object" => lang.pick(
            "十六进制对象或范围, 如 6040、6040h:00 或 1A00-1BFF",
            "a hexadecimal object or range, such as 6040, 6040h:00 or 1A00-1BFF",
        ),
        "code" => lang.pick(
            "规则代码或其开头, 如 SDO002 或 SDO (见 canalyze rules)",
            "the code of a rule or its beginning, such as SDO002 or SDO (see canalyze rules)",
        ),
        "severity" => "error warning info",
        "text" => lang
            .pick("注释中的文字, 含空格时加双引号", "words of the annotation, in double quotes where they have blanks"),
        "id" => lang.pick(
            "十六进制CAN标识符或范围, 如 185 或 180-1FF",
            "a hexadecimal CAN identifier or range, such as 185 or 180-1FF",
        ),
        "t" => lang.pick("以秒计的时间段, 如 1.0..2.5 或 10..", "a range in seconds, such as 1.0..2.5 or 10.."),
        "frame" => lang.pick("帧序号或范围, 如 12 或 10-20", "a frame number or a range, such as 12 or 10-20"),
        _ => lang.pick("总线名", "a bus name"),
    };
    match lang {
        Lang::Zh => format!("过滤条件 {key}= 不接受“{value}”, 可用: {allowed}"),
        Lang::En => format!("filter {key}= does not accept '{value}', use: {allowed}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_with_a_frame() {
        for (text, reason, said) in [
            ("60A#40081", Unreadable::Data, "60A#40081: odd number of hexadecimal digits"),
            ("60A#4008 1", Unreadable::Length, "60A#4008 1: invalid length"),
            ("60A [2] 40", Unreadable::Data, "60A [2] 40: data bytes do not match the length"),
            ("60A [1] 40 08", Unreadable::Length, "60A [1] 40 08: data bytes do not match the length"),
            ("60A##000", Unreadable::Length, "60A##000: more than 64 bytes of data"),
        ] {
            assert_eq!(no_frame(Lang::En, text.as_bytes(), reason), said);
        }
        let long = no_frame(Lang::Zh, b"60A#400810000000000000", Unreadable::Length);
        assert!(long.starts_with("60A#400810000000000000: 数据多于8字节"), "{long}");
    }

    #[test]
    fn binary_files_have_records() {
        let (line, byte) = (FilePlace::Line(7), FilePlace::Byte(7));
        let said = |lang, place| unreadable(lang, b"a", place, Unreadable::Cut);
        assert_eq!(said(Lang::En, line), "a:7: cannot be read: line is truncated");
        assert_eq!(said(Lang::En, byte), "a: byte 7: cannot be read: record is truncated");
        assert_eq!(said(Lang::Zh, line), "a:7: 无法读取: 该行被截断");
        assert_eq!(said(Lang::Zh, byte), "a: 偏移7: 无法读取: 该记录被截断");
        let all = |lang, place| unreadable_lines(lang, b"a", place, 9, &[(7, 8), (20, 20)]);
        assert_eq!(all(Lang::En, line), "a: 9 lines cannot be read: 7-8, 20, ...");
        assert_eq!(all(Lang::En, byte), "a: 9 records cannot be read: byte 7-8, 20, ...");
        assert_eq!(all(Lang::Zh, line), "a: 共9行无法读取: 第7-8, 20, ...行");
        assert_eq!(all(Lang::Zh, byte), "a: 共9条记录无法读取: 偏移7-8, 20, ...");
    }
}
