//! Differences of two captures in words: their subjects, and the content of each capture.
//!
//! The order of words is the same in both languages, so their words are side by side. The layout of a report is not
//! decided here.

use super::digits::{Hex, Padded, Spaced, put};
use super::object::pdo_of;
use super::value::{self, Size};
use super::{Lang, escape, findings, say, terms};
use crate::bytes::frame::{CanId, FrameRef};
use crate::bytes::ns::Ns;
use crate::problems::problem::{Problem, Status as Standing};
use crate::sdo::transfer::{Direction, Mode, Status};
use crate::sdo::wire::{Mux, Side as Sender};
use crate::views::diff::difference::{Aspect, CaptureSide, Difference, DifferenceKind, Shows};
use crate::views::diff::digest::{Action, ItemKind, Service, TransferDigest};
use crate::views::diff::problems::{Differs, lasted_ns};
use crate::wire::error_control;
use crate::wire::{emcy, lss, nmt};
use crate::words::profiles::Profile;
use crate::world::dictionary::Described;

/// The words of a report around its differences: `{}` is filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phrase {
    /// Above the first one.
    First,
    /// Above all of them.
    All,
    /// Nothing differs.
    Same,
    /// A frame of a capture.
    Frame,
    /// Its line.
    Line,
    /// Beside a missing frame.
    Near,
    /// The number of differences.
    Count,
    /// Above the problems.
    Problems,
    /// Nothing else differs than the problems.
    NothingElse,
    /// Above problems of one capture.
    Only,
    /// Above problems that both have and that differ.
    Both,
    /// The number of differences that are not listed.
    More,
    /// The range that was compared.
    Compared,
    /// Content that was not compared, since only one capture covers its time.
    Outside,
    /// A capture was too long.
    Full,
    /// Times were not compared.
    NoTimes,
    /// The relation of the captures in time is unknown.
    Unplaced,
    /// A bus that has no name.
    Unnamed,
}

/// Rows: the phrase, Chinese, English.
static PHRASES: &[(Phrase, &str, &str)] = &[
    (Phrase::First, "首处差异: ", "first difference: "),
    (Phrase::All, "全部差异:", "all differences:"),
    (Phrase::Same, "相同: 没有CANopen意义上的差异", "identical: no difference in CANopen terms"),
    (Phrase::Frame, "第{}帧", "frame {}"),
    (Phrase::Line, " (第{}行)", " (line {})"),
    (Phrase::Near, "{}之后无", "none after {}"),
    (Phrase::Count, "差异: {}", "differences: {}"),
    (Phrase::Problems, "问题的差异: {}", "differing problems: {}"),
    (Phrase::NothingElse, "此外没有CANopen意义上的差异", "no other difference in CANopen terms"),
    (Phrase::Only, "仅{}有:", "only in {}:"),
    (Phrase::Both, "两者都有但不同:", "in both but different:"),
    (Phrase::More, "另有{}处未列出", "{} more not listed"),
    (Phrase::Compared, "比较范围: ", "compared: "),
    (
        Phrase::Outside,
        "未比较: 仅一个记录覆盖的时段内的传输、命令、状态等, A {} B {}",
        "not compared (time covered by one capture only): transfers, commands, states; in A {} in B {}",
    ),
    (Phrase::Full, "{} 太长, 后面部分未比较", "{} is too long; its later part was not compared"),
    (
        Phrase::NoTimes,
        "至少一个记录没有时间戳: 周期、抖动和问题未比较",
        "at least one capture has no timestamps: periods, jitter and problems were not compared",
    ),
    (
        Phrase::Unplaced,
        "两个记录只有相同内容的重复, 无法确定对应位置: 仅一个记录有的内容未作判断",
        "both captures only repeat the same content, so their relative position is unknown: content of one capture only was not judged",
    ),
    (Phrase::Unnamed, "总线", "bus"),
];

/// A part that fills a gap.
pub type Fact<'a> = &'a dyn Fn(&mut Vec<u8>);

/// Appends a phrase with its gaps filled.
pub fn phrase(out: &mut Vec<u8>, lang: Lang, phrase: Phrase, facts: &[Fact<'_>]) {
    let row = PHRASES.iter().find(|row| row.0 == phrase);
    let text = row.map_or("", |row| lang.pick(row.1, row.2));
    let mut facts = facts.iter();
    for (place, part) in text.split("{}").enumerate() {
        if place > 0
            && let Some(fact) = facts.next()
        {
            fact(out);
        }
        put!(out; part);
    }
}

/// Appends a frame and its line.
pub fn frame(out: &mut Vec<u8>, lang: Lang, at: FrameRef) {
    phrase(out, lang, Phrase::Frame, &[&|out| put!(out; at.no)]);
    if let Some(line) = at.line() {
        phrase(out, lang, Phrase::Line, &[&|out| put!(out; line)]);
    }
}

/// Appends the subject of a difference: `SDO download 1017h:00 producer heartbeat time`.
pub fn subject(out: &mut Vec<u8>, lang: Lang, difference: &Difference) {
    let action = difference.sides.iter().flatten().find_map(|side| match &side.shows {
        Shows::Action(action) => Some(action),
        _ => None,
    });
    match (difference.what, action) {
        (DifferenceKind::Item(ItemKind::Sdo(_), aspect), Some(Action::Transfer(moved))) => {
            transfer(out, lang, moved);
            put!(out; match aspect {
                Aspect::Presence => "",
                Aspect::Outcome => lang.pick(", 结果", ", outcome"),
                Aspect::Mode => lang.pick(", 方式", ", mode"),
                Aspect::Value => lang.pick(", 值", ", value"),
            });
        }
        (DifferenceKind::Poll, Some(Action::Transfer(moved))) => {
            transfer(out, lang, moved);
            put!(out; lang.pick(", 周期", ", period"));
        }
        (DifferenceKind::Item(kind, _), _) => put!(out; item(lang, kind, action)),
        (DifferenceKind::Bus, _) => put!(out; lang.pick("总线", "bus")),
        (DifferenceKind::Node, _) => put!(out; lang.pick("节点", "node")),
        (DifferenceKind::Finding, _) => put!(out; lang.pick("检查结果", "finding")),
        (what, _) => {
            if let Some(of) = what.service() {
                service(out, lang, of);
            }
            put!(out; match what {
                DifferenceKind::Frames(_) => lang.pick(", 帧数", ", frames"),
                DifferenceKind::Period(_) => lang.pick(", 周期", ", period"),
                DifferenceKind::Jitter(_) => lang.pick(", 抖动", ", jitter"),
                DifferenceKind::CobId(_) => ", COB-ID",
                DifferenceKind::Mapping(_) => lang.pick(", 映射", ", mapping"),
                DifferenceKind::Length(_) => lang.pick(", 长度", ", length"),
                _ => "",
            });
        }
    }
}

fn item(lang: Lang, kind: ItemKind, action: Option<&Action>) -> &'static str {
    match kind {
        ItemKind::Nmt => lang.pick("NMT命令", "NMT command"),
        ItemKind::State if matches!(action, Some(Action::BootUp)) => lang.pick("启动报文", "boot-up"),
        ItemKind::State => lang.pick("NMT状态", "NMT state"),
        ItemKind::Sdo(_) => "SDO",
        ItemKind::Emcy => "EMCY",
        ItemKind::Drive(_) => lang.pick("驱动器状态", "drive state"),
        ItemKind::LssMaster => lang.pick("LSS主站命令", "LSS command"),
        ItemKind::LssSlave => lang.pick("LSS从站响应", "LSS response"),
    }
}

fn transfer(out: &mut Vec<u8>, lang: Lang, moved: &TransferDigest) {
    put!(out; match moved.direction {
        Direction::Upload => lang.pick("SDO上传", "SDO upload"),
        Direction::Download => lang.pick("SDO下载", "SDO download"),
    });
    if let Some(mux) = moved.mux {
        put!(out; " ", mux);
        value::name(out, lang, mux, &moved.described);
        pdo_of(out, mux);
    }
}

/// Appends a periodic service.
pub fn service(out: &mut Vec<u8>, lang: Lang, service: Service) {
    match service {
        Service::Sync => put!(out; lang.pick("同步报文", "SYNC")),
        Service::Time => put!(out; "TIME"),
        Service::ErrorControl => {
            put!(out; lang.pick("错误控制(心跳或节点保护)", "error control (heartbeat or node guarding)"))
        }
        Service::Pdo(transmit, number) => put!(out; if transmit { "TPDO" } else { "RPDO" }, number),
        Service::Srdo(number, inverted) => {
            put!(out; "SRDO", number);
            if inverted {
                put!(out; lang.pick(" (取反数据)", " (inverted)"));
            }
        }
    }
}

/// Appends the content of one capture.
pub fn side(out: &mut Vec<u8>, lang: Lang, what: DifferenceKind, side: Option<&CaptureSide>) {
    let Some(side) = side else { return put!(out; lang.pick("无", "none")) };
    if let Some(ns) = side.pace_ns {
        return time(out, ns);
    }
    match &side.shows {
        Shows::Action(action) => done(out, lang, what, action),
        Shows::Count(count) => put!(out; *count, lang.pick("帧", if *count == 1 { " frame" } else { " frames" })),
        Shows::Time(ns) => time(out, *ns),
        Shows::Id(id) => identifier(out, *id),
        Shows::Mapping(words) if words.is_empty() => put!(out; lang.pick("(空)", "(empty)")),
        Shows::Mapping(words) => {
            for (place, word) in words.iter().enumerate() {
                put!(out; if place > 0 { ", " } else { "" });
                let mux = Mux { index: (word >> 16) as u16, sub: (word >> 8) as u8 };
                put!(out; mux);
                value::name(out, lang, mux, &Described::default());
                put!(out; " (", word & 0xFF, lang.pick("位)", if word & 0xFF == 1 { " bit)" } else { " bits)" }));
            }
        }
        Shows::Length(bytes) => put!(out; Size(lang, u64::from(*bytes))),
        Shows::Finding(finding) => {
            put!(out; finding.code.rule().id, " ");
            findings::placed(out, lang, finding, finding.at.no);
        }
    }
}

fn identifier(out: &mut Vec<u8>, id: CanId) {
    let raw = u64::from(id.raw());
    if id.is_extended() {
        put!(out; Hex::<8>(raw), "h");
    } else {
        put!(out; Hex::<3>(raw), "h");
    }
}

/// Appends a time in ms, with up to three digits behind the point.
fn time(out: &mut Vec<u8>, ns: Ns) {
    let us = ns.as_ns().unsigned_abs() / 1000;
    put!(out; us / 1000);
    if !us.is_multiple_of(1000) {
        put!(out; ".", Padded::<3>(us % 1000));
        while out.last() == Some(&b'0') {
            out.pop();
        }
    }
    put!(out; " ms");
}

fn done(out: &mut Vec<u8>, lang: Lang, what: DifferenceKind, action: &Action) {
    match action {
        Action::Transfer(moved) => moved_words(out, lang, what, moved),
        Action::Nmt(command) => match nmt::command(lang, *command) {
            Some(word) => put!(out; word),
            None => put!(out; Hex::<2>(u64::from(*command)), "h"),
        },
        Action::BootUp => put!(out; lang.pick("有", "present")),
        Action::State(state) => match error_control::state(lang, *state) {
            Some(word) => put!(out; word),
            None => put!(out; Hex::<2>(u64::from(*state)), "h"),
        },
        Action::Drive(state) => put!(out; match state {
            Some(state) => terms::drive::state(lang, *state),
            None => lang.pick("未定义", "undefined"),
        }),
        Action::Emcy(code, register) => {
            put!(out; Hex::<4>(u64::from(*code)), "h");
            if let Some(word) = emcy::code(lang, Profile::UNKNOWN, *code) {
                put!(out; " ", word);
            }
            put!(out; lang.pick(", 错误寄存器", ", error register "), Hex::<2>(u64::from(*register)), "h");
        }
        Action::Lss(bytes) => {
            let [specifier, ..] = *bytes;
            if let Some(word) = lss::command(lang, specifier) {
                put!(out; word, " ");
            }
            put!(out; Spaced(bytes));
        }
    }
}

fn moved_words(out: &mut Vec<u8>, lang: Lang, what: DifferenceKind, moved: &TransferDigest) {
    if matches!(what, DifferenceKind::Item(ItemKind::Sdo(_), Aspect::Mode)) {
        return put!(out; match moved.mode {
            Mode::Expedited => lang.pick("加速", "expedited"),
            Mode::Segmented => lang.pick("分段", "segmented"),
            Mode::Block => lang.pick("块", "block"),
        });
    }
    match moved.status {
        Status::Ok => {
            let whole = moved.kept.len() as u64 == moved.size;
            match moved.mux {
                Some(mux) if whole => value::of_object(out, lang, mux, &moved.described, &moved.kept),
                _ => value::value(out, lang, None, &moved.kept, moved.size),
            }
            if !whole {
                put!(out; " (", Size(lang, moved.size), ", FNV-1a ", Hex::<16>(moved.hash), ")");
            }
        }
        Status::Aborted => {
            put!(out; lang.pick("中止", "aborted"));
            if let Some(abort) = moved.abort {
                put!(out; match abort.by {
                    Sender::Client => lang.pick(" (主站)", " by the client"),
                    Sender::Server => lang.pick(" (从站)", " by the server"),
                });
                put!(out; " ", abort.code, "h");
                if let Some(word) = terms::abort_code(lang, abort.code) {
                    put!(out; " ", word);
                }
            }
        }
        Status::Failed => put!(out; lang.pick("失败", "failed")),
        Status::Incomplete | Status::Open => put!(out; lang.pick("不完整", "incomplete")),
    }
}

/// Appends the property in which a problem differs.
pub fn respect(out: &mut Vec<u8>, lang: Lang, differs: Differs) {
    put!(out; match differs {
        Differs::Status => lang.pick("状态", "status"),
        Differs::Duration => lang.pick("持续时间", "duration"),
        Differs::Count => lang.pick("次数", "count"),
        Differs::Cause => lang.pick("原因", "cause"),
    });
}

/// Appends that property of a problem. `cause`: its cause.
pub fn problem(out: &mut Vec<u8>, lang: Lang, differs: Differs, one: &Problem, cause: Option<&Problem>) {
    match differs {
        Differs::Status => put!(out; match one.status {
            Standing::Open => lang.pick("仍存在", "open"),
            Standing::Unknown => lang.pick("未知", "unknown"),
            Standing::Ended => lang.pick("已恢复", "ended"),
            Standing::Harmless => lang.pick("无害", "harmless"),
        }),
        Differs::Duration => match lasted_ns(one) {
            Some(ns) => time(out, ns),
            None => put!(out; "-"),
        },
        Differs::Count => put!(out; one.repeats.count),
        Differs::Cause => match cause {
            Some(cause) => {
                put!(out; lang.of(cause.kind.row().words), lang.pick(" (第", " (frame "), cause.begin.listed().no, lang.pick("帧)", ")"))
            }
            None => put!(out; lang.pick("不明", "unknown")),
        },
    }
}

/// Appends a bus by its name.
pub fn bus(out: &mut Vec<u8>, lang: Lang, name: &[u8]) {
    if name.is_empty() {
        return phrase(out, lang, Phrase::Unnamed, &[]);
    }
    escape::terminal(out, name);
}

/// Appends the words for a node-ID.
pub fn node(out: &mut Vec<u8>, lang: Lang, node: u8) {
    put!(out; lang.pick("节点", "node "), node);
}

/// Appends the number of occurrences of a difference.
pub fn times(out: &mut Vec<u8>, lang: Lang, count: u64) {
    say!(out, lang; zh: " (共", count, "次)"; en: " (", count, " times)");
}
