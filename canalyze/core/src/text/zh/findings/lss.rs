//! LSS's findings and notes in Chinese (CiA 305).
//!
//! It must carry the same facts as `en::findings::lss`.

use crate::event::Scanned;
use crate::services::lss::Part;
use crate::text::digits::{Hex, put};
use crate::text::{Lang, RuleText, terms, told};

const ZH: Lang = Lang::Zh;

pub(super) const LSS001: RuleText = RuleText {
    message: "未定义的LSS报文",
    meaning: "LSS报文总是8字节, 首字节是命令字; CiA 305没有为这一方定义该命令字, 或者长度不对。",
    cause: "协议栈实现有误, 数据损坏, 或者7E4h/7E5h上不是LSS。",
    faces: &[
        "主站发送了未定义的命令字 {command}",
        "从站发送了未定义的命令字 {command}",
        "LSS帧长度为{length}字节, 应为8字节",
    ],
};

pub(super) const LSS002: RuleText = RuleText {
    message: "没有对应请求的LSS应答",
    meaning: "LSS从站只应答主站的请求; 记录中此前和紧接其后都没有同类的请求。",
    cause: "从站实现有误, 或者记录中缺少主站的帧。",
    faces: &["应答 {command} 没有对应的请求"],
};

pub(super) const LSS003: RuleText = RuleText {
    message: "没有从站处于配置状态时发送配置命令",
    meaning: "配置和查询命令只有配置状态的从站才执行; 主站已把所有从站切换到等待状态, 之后没有选中任何从站。",
    cause: "主站漏掉了切换状态, 或者没有检查选择性切换是否得到应答。",
    faces: &["没有从站处于配置状态, 主站却发送了 {command}"],
};

pub(super) const LSS004: RuleText = RuleText {
    message: "LSS从站应答了错误码",
    meaning: "从站没有接受节点ID或位定时, 或者没有存储配置。错误码FFh表示制造商定义的错误, 其含义见设备手册。",
    cause: "节点ID不在1到127之内, 从站不支持该波特率或不支持存储, 或者存储介质出错。",
    faces: &["{command} 被拒绝: 错误码 {error}", "{command} 被拒绝: 错误码 {error}, 特定错误码 {specific}"],
};

pub(super) const LSS005: RuleText = RuleText {
    message: "配置节点ID后没有以新节点ID启动",
    meaning: "没有节点ID的从站回到等待状态后以新节点ID启动; 已有节点ID的从站在复位通信后, 或存储后重新启动时才使用新节点ID。",
    cause: "从站要求重新上电, 没有存储配置就复位了节点, 或者启动报文不在记录中。",
    faces: &["{limit}内没有节点以节点ID {node} 启动", "节点仍以节点ID {found} 启动, 应为 {expected}"],
};

pub(super) const LSS006: RuleText = RuleText {
    message: "位定时已配置, 但没有激活也没有存储",
    meaning: "从站接受了位定时, 之后回到等待状态, 而主站既没有激活位定时(15h), 也没有存储配置(17h): 波特率没有改变。",
    cause: "主站漏掉了激活位定时或存储配置。",
    faces: &[],
};

pub(super) const LSS007: RuleText = RuleText {
    message: "不止一个从站应答",
    meaning: "配置节点ID和查询命令只应有一个从站处于配置状态; 应答来自哪个从站无法区分。",
    cause: "全局切换到配置状态时总线上有多个从站, 选中下一个从站之前没有切换到等待状态, 或者两个从站的LSS地址相同。",
    faces: &["{command} 得到了不止一个应答: 不止一个从站处于配置状态", "{command} 不止一个: 不止一个从站具有该LSS地址"],
};

pub(super) const LSS008: RuleText = RuleText {
    message: "切换延迟期间有报文",
    meaning: "激活位定时后, 从站在一个切换延迟后改变波特率, 再等待一个切换延迟才能发送; 期间任何节点都不应发送。",
    cause: "主站没有等待, 或者总线上还有不参与切换的节点。",
    faces: &["激活位定时后{elapsed}有报文, 总线应静默{silence}"],
};

pub(super) const LSS009: RuleText = RuleText {
    message: "已选中的从站没有应答",
    meaning: "处于配置状态的从站必须应答配置和查询命令。",
    cause: "从站不支持该命令, 已复位或已断开, 或者应答太慢。",
    faces: &["已选中的从站在{limit}内没有应答 {command}", "主站继续之前没有收到对 {command} 的应答"],
};

pub(super) const LSS010: RuleText = RuleText {
    message: "无效的快速扫描参数",
    meaning: "BitCheck只能是0到31或80h, LSSSub和LSSNext只能是0到3; 从站忽略其他值。",
    cause: "主站的快速扫描实现有误。",
    faces: &["无效的BitCheck {found}", "无效的LSSSub={sub}或LSSNext={next}"],
};

pub(super) const LSS011: RuleText = RuleText {
    message: "选择性切换状态的顺序不对",
    meaning: "LSS地址必须按制造商ID、产品码、修订号、序列号(40h到43h)的顺序发送; 顺序不对时从站可以不应答。",
    cause: "主站漏发或重发了其中一帧。",
    faces: &["收到 {found}, 应为 {expected}"],
};

pub(super) const LSS012: RuleText = RuleText {
    message: "没有从站应答",
    meaning: "没有从站具有该LSS地址, 或者全局切换后总线上没有LSS从站。",
    cause: "从站不存在或未上电(主站在查找), 或者LSS地址写错。",
    faces: &[
        "没有从站应答该LSS地址: 制造商ID={vendor}, 产品码={product}, 修订号={revision}, 序列号={serial}",
        "{limit}内没有从站应答 {command}",
    ],
};

pub(super) const LSS030: RuleText = RuleText {
    message: "7E4h/7E5h上的报文不像LSS",
    meaning: "没有出现过一对有效的请求和应答, 因此不作LSS判断。",
    cause: "网络不是CANopen, 只记录到一个方向, 或者总线上没有LSS从站。",
    faces: &[],
};

/// A slave has entered the configuration state.
pub(super) fn selected(out: &mut Vec<u8>, address: [u32; 4]) {
    put!(out; "从站已进入配置状态: ");
    parts(out, address.map(Some));
}

/// A Fastscan is over.
pub(super) fn scanned(out: &mut Vec<u8>, scanned: Scanned, about: u64) {
    put!(out; "第", about, "帧开始的快速扫描");
    if scanned.found {
        put!(out; "找到从站: ");
        parts(out, scanned.address);
        if scanned.address.iter().any(Option::is_none) {
            put!(out; ", 其余部分不在记录中");
        }
    } else {
        put!(out; "未完成");
        if scanned.address.iter().any(Option::is_some) {
            put!(out; ", 已确认: ");
            parts(out, scanned.address);
        }
    }
    put!(out; " (", scanned.frames, "个请求");
    if let Some(ns) = scanned.duration_ns {
        put!(out; ", 历时");
        told::duration(out, ns);
    }
    put!(out; ")");
}

/// Bit timing is activated.
pub(super) fn activated(out: &mut Vec<u8>, delay: u16, rate: Option<u16>) {
    put!(out; "此后", u32::from(delay) * 2, "ms总线应静默, 之后");
    if let Some(rate) = rate {
        put!(out; "波特率为", rate, " kbit/s: ");
    } else {
        put!(out; "波特率改变: ");
    }
    put!(out; "仍用旧波特率记录只会看到错误或静默");
}

/// A node has another node-ID.
pub(super) fn changed(out: &mut Vec<u8>, from: u8, to: u8, about: u64) {
    put!(out; "节点", from, "的节点ID改为", to, " (第", about, "帧接受)");
}

fn parts(out: &mut Vec<u8>, address: [Option<u32>; 4]) {
    let mut between = "";
    for (number, value) in (0..).zip(address) {
        if let (Some(part), Some(value)) = (Part::from_number(number), value) {
            put!(out; between, terms::lss::part(ZH, part), "=", Hex::<8>(u64::from(value)), "h");
            between = ", ";
        }
    }
}
