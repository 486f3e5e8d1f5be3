//! Findings and notes in Chinese, and what each rule means.
//!
//! It must carry the same facts as `en::findings`; a rule without words does not compile.

mod bus;
mod capture;
mod description;
mod drive;
mod expectation;
mod lss;
mod nodes;
mod pdo;
mod srdo;
mod sync;

use crate::event::Note;
use crate::finding::{Code, CrcMatch, Facts, Finding, Severity};
use crate::services::sdo::wire::Side;
use crate::text::digits::{Hex, put};
use crate::text::{Lang, RuleText, escape, told, value};

/// The word for a severity.
pub fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Info => "提示",
        Severity::Warning => "警告",
        Severity::Error => "错误",
    }
}

fn side(side: Side) -> &'static str {
    match side {
        Side::Client => "主站",
        Side::Server => "从站",
    }
}

/// Appends the frame that shows a finding, where the finding stands under another one's line.
pub fn place(out: &mut Vec<u8>, frame: Option<u64>, node: Option<u8>) {
    if let Some(frame) = frame {
        put!(out; "第", frame, if node.is_some() { "帧 " } else { "帧: " });
    }
}

/// Appends what a finding says, in one sentence without line end.
pub fn message(out: &mut Vec<u8>, finding: &Finding) {
    if let Some(node) = finding.node {
        put!(out; "节点", node, " ");
    }
    if let Some(object) = finding.object.filter(|_| !matches!(finding.facts, Facts::Objects { .. })) {
        value::object(out, object);
        value::pdo_of(out, object);
        put!(out; " ");
    }
    if finding.node.is_some() {
        out.pop();
        put!(out; ": ");
    }
    if let Some(cause) = finding.cause {
        put!(out; "第", cause.no, "帧: ");
    }
    match finding.facts {
        Facts::None => put!(out; rule(finding.code).message),
        Facts::Lines { count } => put!(out; count, "行无法读取"),
        Facts::Dropped { count, total } => put!(out; "丢失", count, "帧 (累计", total, "帧)"),
        Facts::Toggle { expected, found, by } => {
            put!(out; side(by), "的toggle=", u8::from(found), ", 应为", u8::from(expected));
        }
        Facts::Missing { by: Side::Server } => put!(out; "请求没有得到响应"),
        Facts::Missing { by: Side::Client } => put!(out; "响应没有对应的请求"),
        Facts::NotAcknowledged => put!(out; "子块没有得到确认"),
        Facts::Duplicate => put!(out; "重复的响应"),
        Facts::Objects { expected, found } => {
            put!(out; "请求的是");
            value::object(out, expected);
            put!(out; ", 响应的是");
            value::object(out, found);
        }
        Facts::Unused(n) => put!(out; rule(finding.code).message, " (n=", n, ")"),
        Facts::Size { indicated, transferred } => {
            put!(out; "声明");
            value::size(out, Lang::Zh, indicated);
            put!(out; ", 实际传输");
            value::size(out, Lang::Zh, transferred);
        }
        Facts::Outside => put!(out; "该帧不属于任何进行中的传输"),
        Facts::NoLast => put!(out; "数据已传完, 但没有任何一段带最后段标志(c=1)"),
        Facts::Length(len) => put!(out; "SDO帧长度为", len, "字节, 应为8字节"),
        Facts::Sequence { expected, found } => put!(out; "块序列号为", found, ", 应为", expected),
        Facts::Acknowledged { ackseq, sent } => put!(out; "确认了第", ackseq, "段, 而只发送到第", sent, "段"),
        Facts::NotResent { ackseq } => put!(out; "只确认到第", ackseq, "段, 其后的段却没有重发"),
        Facts::BlockSize(size) => put!(out; "块大小为", size, ", 应为1到127"),
        Facts::EarlyEnd => put!(out; "最后一段尚未被确认就结束块传输"),
        Facts::EndNotConfirmed => put!(out; "块传输的结束没有得到确认"),
        Facts::Crc { computed, found, matches } => {
            put!(out; "CRC为", Hex::<4>(u64::from(found)), "h, 按数据应为", Hex::<4>(u64::from(computed)), "h");
            put!(out; match matches {
                CrcMatch::Nothing => "",
                CrcMatch::WithPadding => " (把最后一段的填充字节也算入时才相符)",
                CrcMatch::InitialFfff => " (初值取FFFFh时才相符)",
                CrcMatch::Reflected => " (按位反转的算法时才相符)",
            });
        }
        Facts::Abort { code, by } => {
            put!(out; side(by), "中止传输: ");
            super::sdo::abort(out, code);
        }
        Facts::Command(command) => put!(out; "未定义的命令字节 ", Hex::<2>(u64::from(command)), "h"),
        Facts::Frames { count } => put!(out; rule(finding.code).message, " (", count, "帧)"),
        Facts::Told { face, measured } => match rule(finding.code).faces.get(usize::from(face)) {
            Some(sentence) => told::fill(out, Lang::Zh, sentence, &measured),
            None => put!(out; rule(finding.code).message),
        },
        Facts::Unmet(ref unmet) => {
            match rule(finding.code).faces.get(usize::from(unmet.face)).filter(|_| unmet.repeated == 0) {
                Some(sentence) => told::fill_said(out, Lang::Zh, sentence, &unmet.said),
                None => repeated(out, unmet.repeated),
            }
            put!(out; " (期望: ");
            escape::terminal(out, unmet.expectation.as_bytes());
            put!(out; ")");
        }
        Facts::Repeated { count } => repeated(out, count),
    }
}

fn repeated(out: &mut Vec<u8>, count: u64) {
    put!(out; "同样的情况另有", count, "次");
}

/// Appends a note of what has become known of an earlier frame.
pub fn note(out: &mut Vec<u8>, note: Note, about: u64) {
    match note {
        Note::RequestNotCaptured => put!(out; "第", about, "帧所应答的请求不在记录中"),
        Note::AnsweredByAbort => put!(out; "第", about, "帧的请求已由在它之前记录到的中止应答"),
        Note::LostByReset => put!(out; "第", about, "帧开始的SDO传输因节点复位而终止"),
        Note::LssSelected { address } => lss::selected(out, address),
        Note::Fastscan(scanned) => lss::scanned(out, scanned, about),
        Note::BitTimingActivated { delay, rate } => lss::activated(out, delay, rate),
        Note::NodeIdChanged { from, to } => lss::changed(out, from, to, about),
    }
}

/// The words of a rule.
pub fn rule(code: Code) -> RuleText {
    let text = |message, meaning, cause| RuleText { message, meaning, cause, faces: &[] };
    match code {
        Code::Bus001 => bus::BUS001,
        Code::Bus002 => bus::BUS002,
        Code::Bus003 => bus::BUS003,
        Code::Bus004 => bus::BUS004,
        Code::Bus005 => bus::BUS005,
        Code::Bus006 => bus::BUS006,
        Code::Bus007 => bus::BUS007,
        Code::Bus008 => bus::BUS008,
        Code::Cap001 => text(
            "有无法读取的行或记录",
            "它们既不是所读格式的帧, 也不是注释; 其余内容照常解析。",
            "文件被截断或编辑过, 混入了其他程序的输出, 或者是尚不支持的格式。",
        ),
        Code::Cap002 => text(
            "记录程序丢帧",
            "记录程序自己声明丢失了帧。丢帧处的toggle位、序列号和应答不再判断, 进行中的传输记为不完整。",
            "接收缓冲区太小、主机太忙或存储太慢; candump可用 -r、dumpcap可用 -B 加大缓冲区, 其他记录程序见其缓冲设置。",
        ),
        Code::Cap003 => text(
            "时间戳倒退",
            "管道中的时间戳按从零开始解释, 但出现了倒退: 它们很可能是与前一帧的差值。",
            "candump使用了 -t d; 请加上 --stamps delta。",
        ),
        Code::Cap004 => capture::CAP004,
        Code::Cap005 => capture::CAP005,
        Code::Cap006 => capture::CAP006,
        Code::Drv001 => drive::DRV001,
        Code::Drv002 => drive::DRV002,
        Code::Drv003 => drive::DRV003,
        Code::Drv004 => drive::DRV004,
        Code::Drv005 => drive::DRV005,
        Code::Nmt001 => nodes::NMT001,
        Code::Nmt002 => nodes::NMT002,
        Code::Nmt003 => nodes::NMT003,
        Code::Nmt004 => nodes::NMT004,
        Code::Nmt005 => nodes::NMT005,
        Code::Hbt001 => nodes::HBT001,
        Code::Hbt002 => nodes::HBT002,
        Code::Hbt003 => nodes::HBT003,
        Code::Hbt004 => nodes::HBT004,
        Code::Hbt005 => nodes::HBT005,
        Code::Hbt006 => nodes::HBT006,
        Code::Grd001 => nodes::GRD001,
        Code::Grd002 => nodes::GRD002,
        Code::Grd003 => nodes::GRD003,
        Code::Grd004 => nodes::GRD004,
        Code::Emc001 => nodes::EMC001,
        Code::Emc002 => nodes::EMC002,
        Code::Emc003 => nodes::EMC003,
        Code::Emc004 => nodes::EMC004,
        Code::Emc005 => nodes::EMC005,
        Code::Emc006 => nodes::EMC006,
        Code::Emc007 => nodes::EMC007,
        Code::Emc008 => nodes::EMC008,
        Code::Emc009 => nodes::EMC009,
        Code::Emc010 => nodes::EMC010,
        Code::Exp001 => expectation::EXP001,
        Code::Exp002 => expectation::EXP002,
        Code::Exp003 => expectation::EXP003,
        Code::Exp004 => expectation::EXP004,
        Code::Exp005 => expectation::EXP005,
        Code::Exp006 => expectation::EXP006,
        Code::Exp007 => expectation::EXP007,
        Code::Exp008 => expectation::EXP008,
        Code::Exp009 => expectation::EXP009,
        Code::Exp010 => expectation::EXP010,
        Code::Exp011 => expectation::EXP011,
        Code::Exp012 => expectation::EXP012,
        Code::Exp013 => expectation::EXP013,
        Code::Exp014 => expectation::EXP014,
        Code::Exp015 => expectation::EXP015,
        Code::Exp016 => expectation::EXP016,
        Code::Tim001 => nodes::TIM001,
        Code::Tim002 => nodes::TIM002,
        Code::Eds001 => description::EDS001,
        Code::Eds002 => description::EDS002,
        Code::Eds003 => description::EDS003,
        Code::Eds004 => description::EDS004,
        Code::Mpd001 => pdo::MPD001,
        Code::Pdo001 => pdo::PDO001,
        Code::Pdo004 => pdo::PDO004,
        Code::Pdo005 => pdo::PDO005,
        Code::Pdo006 => pdo::PDO006,
        Code::Pdo008 => pdo::PDO008,
        Code::Pdo009 => pdo::PDO009,
        Code::Pdo010 => pdo::PDO010,
        Code::Pdo011 => pdo::PDO011,
        Code::Pdo012 => pdo::PDO012,
        Code::Pdo013 => pdo::PDO013,
        Code::Pdo014 => pdo::PDO014,
        Code::Pdo015 => pdo::PDO015,
        Code::Pdo016 => pdo::PDO016,
        Code::Pdo018 => pdo::PDO018,
        Code::Pdo019 => pdo::PDO019,
        Code::Lss001 => lss::LSS001,
        Code::Lss002 => lss::LSS002,
        Code::Lss003 => lss::LSS003,
        Code::Lss004 => lss::LSS004,
        Code::Lss005 => lss::LSS005,
        Code::Lss006 => lss::LSS006,
        Code::Lss007 => lss::LSS007,
        Code::Lss008 => lss::LSS008,
        Code::Lss009 => lss::LSS009,
        Code::Lss010 => lss::LSS010,
        Code::Lss011 => lss::LSS011,
        Code::Lss012 => lss::LSS012,
        Code::Lss030 => lss::LSS030,
        Code::Sdo001 => text(
            "toggle位错误",
            "分段传输中toggle位第一段为0, 以后逐段交替; 响应必须重复请求的toggle位。",
            "协议栈实现有误, 一方重发了已被接受的段, 或者记录中丢了一帧。",
        ),
        Code::Sdo002 => text(
            "请求与响应不配对",
            "SDO是一问一答的: 每个请求都应有响应, 没有请求就不应有响应。",
            "节点掉线或响应太慢, 两个客户端共用一个SDO通道, 或者记录中丢了一帧。",
        ),
        Code::Sdo003 => text(
            "响应的索引或子索引与请求不同",
            "初始化响应必须带有与请求相同的索引和子索引。",
            "服务器实现有误, 或者两个客户端同时使用了同一个SDO通道。",
        ),
        Code::Sdo004 => text(
            "未使用字节数n无效",
            "只有e和s都为1时n才有意义, 否则n必须为0。",
            "命令字节拼错; 某些厂商手册给出的命令字节省略了e和s。",
        ),
        Code::Sdo005 => text(
            "非最后段未填满",
            "不是最后一段却有未使用的字节。协议栈都会接受, 但少见。",
            "发送方按自己的缓冲区分段。",
        ),
        Code::Sdo006 => text(
            "传输的字节数与声明的长度不符",
            "初始化帧声明的长度必须等于各段数据的总字节数。",
            "最后一段的n算错, 字符串结尾的0被多算或少算, 或者记录中丢了一段。",
        ),
        Code::Sdo007 => text(
            "段不属于进行中的传输, 或传输没有最后段",
            "带c=1的段结束传输, 之后不应再有段; 数据传完时必须有一段带c=1。",
            "一方没有识别最后段标志, 或者最后段标志没有置位。",
        ),
        Code::Sdo008 => text(
            "传输未完成就开始新的传输",
            "上一个传输还在进行, 客户端又发出了新的初始化请求, 且没有先中止。",
            "客户端超时后直接重来, 或者两个客户端共用一个SDO通道。",
        ),
        Code::Sdo009 => {
            text("保留位或未使用字节不为0", "保留的位和字节应为0; 大多数协议栈不检查。", "发送方没有清零缓冲区。")
        }
        Code::Sdo010 => text(
            "SDO帧长度不是8字节",
            "SDO帧总是8字节; 不少服务器会不声不响地丢弃较短的帧。",
            "发送方按实际数据长度设置了DLC。",
        ),
        Code::Sdo011 => nodes::SDO011,
        Code::Sdo012 => text(
            "块传输的序列号、确认或结束有误",
            "子块内序列号从1起连续; 确认不能超过已发送的段; 块大小为1到127; 最后一段被确认后才能结束, 结束须得到确认。",
            "一方的块传输实现有误, 或者记录中丢了一段。",
        ),
        Code::Sdo013 => description::SDO013,
        Code::Sdo014 => description::SDO014,
        Code::Sdo015 => {
            text("重复的请求", "同一个请求在没有响应的情况下又发了一次。", "客户端超时重发, 或者记录中同一帧出现两次。")
        }
        Code::Sdo017 => text(
            "SDO传输被中止",
            "一方用中止帧结束了传输; 中止码说明原因。",
            "访问了不存在的对象, 读写权限或数据长度不对, 或者超时; 见中止码。",
        ),
        Code::Sdo019 => text(
            "块传输的CRC错误",
            "双方都声明支持CRC时, 结束帧中的CRC必须等于按CRC-16/XMODEM对数据(不含填充)计算的值。",
            "使用了别的CRC算法, 把填充字节算了进去, 或者数据有误。",
        ),
        Code::Sdo020 => {
            text("迟到的应答", "客户端已经放弃了请求, 服务器的应答才到。", "服务器太慢, 或者客户端超时设得太短。")
        }
        Code::Sdo021 => text(
            "写请求的e=s=0, 数据却按加速传输发送",
            "按标准e=s=0表示长度未知的分段传输, 但之后没有任何段: 数据就在初始化帧里。",
            "按Roboteq手册的简化说明拼出的命令字节(20h/28h/2Ch)。",
        ),
        Code::Sdo022 => text(
            "读响应的e=s=0, 数据却按加速传输发送",
            "按标准e=s=0表示长度未知的分段传输, 但客户端没有请求任何段: 数据就在初始化响应里。",
            "设备按Roboteq手册的形式应答(40h/48h/4Ch)。",
        ),
        Code::Sdo023 => text(
            "未定义的SDO命令字",
            "标准没有为这一方定义该命令字。",
            "协议栈实现有误, 数据损坏, 或者该COB-ID上不是SDO。",
        ),
        Code::Sdo030 => text(
            "该通道的报文不像SDO",
            "这些COB-ID上没有出现过一对有效的请求和响应, 因此不对它们作SDO判断。",
            "网络不是CANopen, 只记录到一个方向, 或者COB-ID被别的协议使用。",
        ),
        Code::Sdo031 => text(
            "请求从未得到应答",
            "记录中该节点没有任何SDO响应。",
            "节点不存在或未上电(主站扫描), 或者只记录到一个方向。",
        ),
        Code::Srd001 => srdo::SRD001,
        Code::Srd002 => srdo::SRD002,
        Code::Srd003 => srdo::SRD003,
        Code::Srd004 => srdo::SRD004,
        Code::Srd005 => srdo::SRD005,
        Code::Pdo002 => nodes::PDO002,
        Code::Pdo003 => nodes::PDO003,
        Code::Syn001 => sync::SYN001,
        Code::Syn002 => sync::SYN002,
        Code::Syn003 => sync::SYN003,
        Code::Syn004 => sync::SYN004,
        Code::Syn005 => sync::SYN005,
        Code::Syn006 => sync::SYN006,
        Code::Syn007 => sync::SYN007,
        Code::Syn008 => sync::SYN008,
        Code::Syn009 => sync::SYN009,
        Code::Syn010 => sync::SYN010,
        Code::Syn011 => sync::SYN011,
        Code::Syn012 => sync::SYN012,
        Code::Syn013 => sync::SYN013,
    }
}
