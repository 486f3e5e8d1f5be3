//! What one frame says by itself, in Chinese, as an engineer would write it.
//!
//! It must carry the same facts as `en::services` and must not decide anything. No `format!`: these are the
//! lines of the hot path.

use crate::cob_id::Role;
use crate::frame::{Frame, Kind};
use crate::message::{Errors, Flaw, Message};
use crate::services::lss::{BIT_CHECK_ANY, Command, Part, Setting, UNCONFIGURED, bit_rate};
use crate::services::pdo::Multiplexed;
use crate::services::pdo::mapping::Mapping;
use crate::services::{error_frame, nmt, time, usdo};
use crate::text::digits::{Hex, Padded, Spaced, put};
use crate::text::{Depth, Lang, terms, value};

const ZH: Lang = Lang::Zh;

/// Appends the phrase of a message, and at other depths than brief its content. No line end.
pub fn message(out: &mut Vec<u8>, depth: Depth, message: &Message, frame: &Frame) {
    let full = depth != Depth::Brief;
    match *message {
        Message::Pdo { transmit, number, node } => {
            pdo(out, transmit, number, node);
            if full {
                put!(out; ": ", frame.len, "字节");
            }
        }
        Message::Sync { counter } => {
            put!(out; "同步报文");
            if let (true, Some(counter)) = (full, counter) {
                put!(out; ": 计数=", counter);
            }
        }
        Message::Heartbeat { node, state, toggle, guarding, previous } => {
            put!(out; "节点", node, if guarding { "的保护应答" } else { "的心跳" });
            if full {
                error_control(out, state, guarding, toggle, previous);
            }
        }
        Message::BootUp { node } => put!(out; "节点", node, "的启动报文"),
        Message::Emcy { node, code, register, manufacturer, cleared, .. } => {
            put!(out; "节点", node, "的紧急报文");
            if full {
                emcy(out, code, register, &manufacturer);
                errors_cleared(out, cleared);
            }
        }
        Message::Nmt { command, node } => node_control(out, full, command, node),
        Message::GuardingRequest { node } => {
            put!(out; "NMT主站对节点", node, "的保护请求");
            if full && frame.len > 1 {
                put!(out; " (请求长度", frame.len, "字节, 应为0或1)");
            }
        }
        Message::PdoRequest { transmit, number, node } => {
            put!(out; "对");
            pdo(out, transmit, number, node);
            put!(out; "的远程请求");
            if full {
                put!(out; ": 请求长度", frame.len, "字节");
            }
        }
        Message::Mpdo { transmit, number, node, content } => {
            pdo(out, transmit, number, node);
            if full {
                put!(out; ": ");
                multiplexed(out, &content, None);
            }
        }
        Message::Time { ms, days, reserved } => {
            put!(out; "时间戳");
            if full {
                time_of_day(out, ms, days, reserved);
            }
        }
        Message::Lss { from_master, command } => lss(out, full, from_master, command),
        Message::Srdo { number, inverted, valid } => {
            put!(out; "SRDO", number, if inverted { "的取反数据" } else { "的正常数据" });
            if full {
                put!(out; ": ", frame.len, "字节", match valid {
                    Some(true) => ", 与正常数据一致",
                    Some(false) => ", 与正常数据不一致",
                    None => "",
                });
            }
        }
        Message::Gfc => put!(out; "全局故障安全命令(GFC)"),
        Message::FlyingMaster { kind, master } => flying_master(out, full, kind, master),
        Message::Usdo { request, source, destination, command } => {
            put!(out; if request { "USDO请求" } else { "USDO响应" }, ", 节点", source, " -> ");
            if destination == 0 {
                put!(out; "所有节点");
            } else {
                put!(out; "节点", destination);
            }
            if full {
                usdo_command(out, command, frame.payload());
            }
        }
        Message::ErrorFrame => errors(out, full, frame),
        Message::Foreign { role } => foreign(out, role),
        Message::Malformed { role, flaw } => malformed(out, full, role, flaw, frame),
    }
}

/// `节点5的TPDO1`.
fn pdo(out: &mut Vec<u8>, transmit: bool, number: u16, node: u8) {
    put!(out; "节点", node, if transmit { "的TPDO" } else { "的RPDO" }, number);
}

fn error_control(out: &mut Vec<u8>, state: u8, guarding: bool, toggle: bool, previous: Option<u8>) {
    match terms::nmt::state(ZH, state) {
        Some(word) => put!(out; ": ", word),
        None => put!(out; ": 未知状态 ", Hex::<2>(u64::from(state)), "h"),
    }
    if guarding {
        put!(out; " (toggle=", u8::from(toggle), ")");
    }
    if let Some(before) = previous.filter(|before| *before != state).and_then(|before| terms::nmt::state(ZH, before)) {
        put!(out; " (此前: ", before, ")");
    }
}

fn node_control(out: &mut Vec<u8>, full: bool, command: u8, node: u8) {
    let (before, after, effect) = match command {
        nmt::START => ("启动", "", " (进入操作状态)"),
        nmt::STOP => ("停止", "", " (进入停止状态)"),
        nmt::PRE_OPERATIONAL => ("", "进入预操作", " (停止PDO)"),
        nmt::RESET_NODE => ("复位", "", " (复位应用, 进入初始化状态)"),
        nmt::RESET_COMMUNICATION => ("", "复位通信", " (进入初始化状态)"),
        _ => ("", "", ""),
    };
    put!(out; "NMT主站命令: ");
    if before.is_empty() && after.is_empty() {
        put!(out; "未知命令 ", Hex::<2>(u64::from(command)), "h, ");
    }
    put!(out; before);
    match node {
        0 => put!(out; "所有节点"),
        1..=127 => put!(out; "节点", node),
        _ => put!(out; "无效的节点ID ", node),
    }
    put!(out; after);
    if full {
        put!(out; effect);
    }
}

fn emcy(out: &mut Vec<u8>, code: u16, register: u8, manufacturer: &[u8; 5]) {
    put!(out; ": ", Hex::<4>(u64::from(code)), "h ", terms::emcy::code(ZH, code).unwrap_or("未知错误码"));
    put!(out; ", 错误寄存器=", Hex::<2>(u64::from(register)), "h");
    register_bits(out, register);
    put!(out; ", 厂商字节 ", Spaced(manufacturer));
}

/// Which errors a reset takes back.
fn errors_cleared(out: &mut Vec<u8>, cleared: Errors) {
    let mut between = ", 清除 ";
    for code in cleared.iter() {
        put!(out; between, Hex::<4>(u64::from(code)), "h");
        between = ", ";
    }
}

fn register_bits(out: &mut Vec<u8>, register: u8) {
    let mut between = " (";
    for bit in (0..8).filter(|bit| register & 1 << bit != 0) {
        put!(out; between, terms::emcy::register_bit(ZH, bit).unwrap_or_default());
        between = ", ";
    }
    if register != 0 {
        put!(out; ")");
    }
}

/// What a multiplex PDO carries: `DAM-MPDO, 写节点10的2000h:01 = 2A 00 00 00`, as far as
/// `mapping` knows the object with its name and value.
pub fn multiplexed(out: &mut Vec<u8>, content: &Multiplexed, mapping: Option<&Mapping>) {
    if content.destination {
        put!(out; "DAM-MPDO, 写");
        if content.node == 0 {
            put!(out; "所有节点");
        } else {
            put!(out; "节点", content.node);
        }
    } else if content.node == 0 {
        put!(out; "SAM-MPDO, 无效的生产者节点ID 0 ");
    } else {
        put!(out; "SAM-MPDO, 生产者节点", content.node);
    }
    put!(out; "的");
    value::multiplexed(out, ZH, content, mapping);
}

fn time_of_day(out: &mut Vec<u8>, ms: u32, days: u16, reserved: u8) {
    let (year, month, day) = time::date(days);
    put!(out; ": ", year, "-", Padded::<2>(u64::from(month)), "-", Padded::<2>(u64::from(day)), " ");
    clock(out, ms);
    put!(out; " (", ms, "ms, 第", days, "天)");
    if ms >= time::DAY_MS {
        put!(out; ", 超出一天");
    }
    if reserved != 0 {
        put!(out; ", 保留位不为0 (", Hex::<1>(u64::from(reserved)), "h)");
    }
}

fn clock(out: &mut Vec<u8>, ms: u32) {
    let (hour, minute, second, ms) = time::clock(ms);
    put!(out; Padded::<2>(u64::from(hour)), ":", Padded::<2>(u64::from(minute)), ":");
    put!(out; Padded::<2>(u64::from(second)), ".", Padded::<3>(u64::from(ms)));
}

fn lss(out: &mut Vec<u8>, full: bool, from_master: bool, command: Command) {
    put!(out; if from_master { "LSS主站: " } else { "LSS从站: " });
    match command {
        Command::SwitchGlobal { .. } => put!(out; "全局切换状态"),
        Command::SwitchSelective { part, .. } => put!(out; "选择性切换状态, ", terms::lss::part(ZH, part)),
        Command::SwitchSelectiveResponse => put!(out; "选择性切换状态应答 (已进入配置状态)"),
        Command::ConfigureNodeId { .. } => put!(out; "配置节点ID"),
        Command::ConfigureBitTiming { .. } => put!(out; "配置位定时"),
        Command::Store => put!(out; "存储配置"),
        Command::Confirmation { of, .. } => put!(out; terms::lss::setting(ZH, of), "的应答"),
        Command::ActivateBitTiming { .. } => put!(out; "激活位定时"),
        Command::Identify { bound, .. } => put!(out; "识别从站, ", terms::lss::bound(ZH, bound)),
        Command::IdentifyNonConfigured => put!(out; "识别未配置的从站"),
        Command::IdentifySlave => put!(out; "从站识别应答"),
        Command::IdentifyNonConfiguredSlave => put!(out; "未配置从站的识别应答"),
        Command::Fastscan { .. } => put!(out; "快速扫描(Fastscan)"),
        Command::Inquire { part } => put!(out; "查询", terms::lss::part(ZH, part)),
        Command::InquireResponse { part, .. } => put!(out; terms::lss::part(ZH, part), "查询应答"),
        Command::InquireNodeId => put!(out; "查询节点ID"),
        Command::InquireNodeIdResponse { .. } => put!(out; "节点ID查询应答"),
        Command::Unknown(cs) => put!(out; "未知命令字 ", Hex::<2>(u64::from(cs)), "h"),
    }
    if full {
        lss_content(out, command);
    }
}

fn lss_content(out: &mut Vec<u8>, command: Command) {
    match command {
        Command::SwitchGlobal { mode: 0 } => put!(out; ": 等待状态"),
        Command::SwitchGlobal { mode: 1 } => put!(out; ": 配置状态"),
        Command::SwitchGlobal { mode } => put!(out; ": 保留的模式 ", Hex::<2>(u64::from(mode)), "h"),
        Command::SwitchSelective { value, .. }
        | Command::Identify { value, .. }
        | Command::InquireResponse { value, .. } => {
            put!(out; " = ", Hex::<8>(u64::from(value)), "h");
        }
        Command::ConfigureNodeId { node } | Command::InquireNodeIdResponse { node } => match node {
            1..=127 => put!(out; " = ", node),
            UNCONFIGURED => put!(out; " = FFh (未配置)"),
            _ => put!(out; " = ", node, " (无效)"),
        },
        Command::ConfigureBitTiming { selector, index } => bit_timing(out, selector, index),
        Command::Confirmation { of, error, specific } => confirmation(out, of, error, specific),
        Command::ActivateBitTiming { delay } => put!(out; ": 切换延迟=", delay, "ms"),
        Command::Fastscan { id_number, bit_check, sub, next } => fastscan(out, id_number, bit_check, sub, next),
        Command::SwitchSelectiveResponse
        | Command::Store
        | Command::IdentifyNonConfigured
        | Command::IdentifySlave
        | Command::IdentifyNonConfiguredSlave
        | Command::Inquire { .. }
        | Command::InquireNodeId
        | Command::Unknown(_) => {}
    }
}

fn bit_timing(out: &mut Vec<u8>, selector: u8, index: u8) {
    put!(out; ": ");
    if selector != 0 {
        put!(out; if selector < 128 { "保留的位定时表" } else { "制造商定义的位定时表" });
    } else if let Some(rate) = bit_rate(index) {
        put!(out; "波特率 ", rate, " kbit/s");
    } else if index == 9 {
        put!(out; "自动检测波特率");
    } else {
        put!(out; "保留的波特率");
    }
    put!(out; " (表=", selector, ", 序号=", index, ")");
}

fn confirmation(out: &mut Vec<u8>, of: Setting, error: u8, specific: u8) {
    put!(out; ": ", terms::lss::error(ZH, of, error).unwrap_or("保留的错误码"));
    if error != 0 {
        put!(out; " (错误码 ", Hex::<2>(u64::from(error)), "h");
        if error == 0xFF {
            put!(out; ", 特定错误码 ", Hex::<2>(u64::from(specific)), "h");
        }
        put!(out; ")");
    }
}

fn fastscan(out: &mut Vec<u8>, id_number: u32, bit_check: u8, sub: u8, next: u8) {
    match bit_check {
        BIT_CHECK_ANY => put!(out; ": 询问是否有未配置的从站"),
        32.. => put!(out; ": 无效的BitCheck"),
        _ => {
            put!(out; ": ");
            address_part(out, sub);
            put!(out; ", 比较位31-", bit_check);
            if sub != next && bit_check == 0 {
                put!(out; ", 确认并转到");
                address_part(out, next);
            }
        }
    }
    put!(out; " (IDNumber=", Hex::<8>(u64::from(id_number)), "h, BitCheck=", Hex::<2>(u64::from(bit_check)));
    put!(out; "h, LSSSub=", sub, ", LSSNext=", next, ")");
}

fn address_part(out: &mut Vec<u8>, number: u8) {
    match Part::from_number(number) {
        Some(part) => put!(out; terms::lss::part(ZH, part)),
        None => put!(out; "无效的LSS地址部分"),
    }
}

fn flying_master(out: &mut Vec<u8>, full: bool, kind: u8, master: Option<(u8, u8)>) {
    put!(out; "飞行主站: ", match kind {
        1 => "活动NMT主站的应答",
        2 => "协商请求",
        3 => "查询活动NMT主站",
        4 => "存在可作NMT主站的设备",
        5 => "查询可作NMT主站的设备",
        6 => "强制重新协商",
        _ => "未知报文",
    });
    if let (true, Some((priority, node))) = (full, master) {
        put!(out; ": 节点", node, ", 优先级=", priority);
    }
}

fn usdo_command(out: &mut Vec<u8>, command: u8, payload: &[u8]) {
    match terms::usdo::command(ZH, command) {
        Some(word) => put!(out; ": ", word),
        None => put!(out; ": 未知命令字 ", Hex::<2>(u64::from(command)), "h"),
    }
    if command & 0x80 != 0 {
        put!(out; " (远程网络)");
    }
    if let Some(session) = payload.get(2) {
        put!(out; ", 会话=", *session);
    }
    let Some(object) = usdo::object(payload) else {
        return;
    };
    put!(out; ", ", Hex::<4>(u64::from(object.index)), "h:", Hex::<2>(u64::from(object.sub)));
    if let Some(code) = object.abort {
        put!(out; ", 中止码 ", Hex::<2>(u64::from(code)), "h ");
        put!(out; terms::usdo::abort(ZH, code).unwrap_or("未知"));
    }
    if let Some(data_type) = object.data_type {
        match crate::od::DataType::from_code(u16::from(data_type)) {
            Some(known) => put!(out; ", 类型 ", known.name()),
            None => put!(out; ", 类型 ", Hex::<2>(u64::from(data_type)), "h"),
        }
    }
    if let Some(size) = object.size {
        put!(out; ", ", size, "字节");
        if !object.data.is_empty() {
            put!(out; ": ", Spaced(object.data));
        }
    }
}

fn errors(out: &mut Vec<u8>, full: bool, frame: &Frame) {
    put!(out; "错误帧");
    let mut between = ": ";
    for class in error_frame::classes(frame).filter(|class| full && *class != error_frame::COUNTERS) {
        put!(out; between);
        between = ", ";
        match terms::find(terms::error_frame::CLASSES, ZH, class) {
            Some(word) => put!(out; word),
            None => put!(out; "未知类别 ", Hex::<8>(u64::from(class)), "h"),
        }
        error_details(out, class, &frame.head());
    }
    if let (true, Some((tx, rx))) = (full, error_frame::counters(frame)) {
        put!(out; between, "发送错误计数=", tx, ", 接收错误计数=", rx);
    }
}

fn error_details(out: &mut Vec<u8>, class: u32, head: &[u8; 8]) {
    let [bit, controller, protocol, location, transceiver, ..] = *head;
    match class {
        error_frame::LOST_ARBITRATION if bit == 0 => put!(out; " (位置未指明)"),
        error_frame::LOST_ARBITRATION => put!(out; " (第", bit, "位)"),
        error_frame::CONTROLLER => bits(out, terms::error_frame::CONTROLLER, controller),
        error_frame::PROTOCOL => {
            bits(out, terms::error_frame::PROTOCOL, protocol);
            match terms::find(terms::error_frame::LOCATION, ZH, location) {
                Some(word) => put!(out; ", 位置: ", word),
                None if location == 0 => put!(out; ", 位置未指明"),
                None => put!(out; ", 位置: 未知 ", Hex::<2>(u64::from(location)), "h"),
            }
        }
        error_frame::TRANSCEIVER => wires(out, transceiver),
        _ => {}
    }
}

fn bits(out: &mut Vec<u8>, rows: &'static [terms::Row<u8>], byte: u8) {
    let mut between = " (";
    for bit in (0..8).map(|bit| 1 << bit).filter(|bit| byte & bit != 0) {
        match terms::find(rows, ZH, bit) {
            Some(word) => put!(out; between, word),
            None => put!(out; between, "未知 ", Hex::<2>(u64::from(bit)), "h"),
        }
        between = ", ";
    }
    put!(out; if byte == 0 { " (未指明)" } else { ")" });
}

fn wires(out: &mut Vec<u8>, status: u8) {
    let mut between = " (";
    for wire in [status & 0x0F, status & 0xF0].into_iter().filter(|wire| *wire != 0) {
        match terms::find(terms::error_frame::TRANSCEIVER, ZH, wire) {
            Some(word) => put!(out; between, word),
            None => put!(out; between, "未知 ", Hex::<2>(u64::from(wire)), "h"),
        }
        between = ", ";
    }
    put!(out; if status == 0 { " (未指明)" } else { ")" });
}

fn foreign(out: &mut Vec<u8>, role: Role) {
    put!(out; match role {
        Role::DynamicSdo => "CiA 302保留的ID (动态SDO)",
        Role::Reserved => "CiA 301保留的ID",
        Role::Foreign => "29位ID, 非CANopen预定义",
        _ => "预定义连接集之外的ID",
    });
}

/// What an identifier stands for, as a noun: `节点10的紧急报文`.
pub fn role(out: &mut Vec<u8>, role: Role) {
    match role {
        Role::Nmt => put!(out; "NMT节点控制"),
        Role::Gfc => put!(out; "全局故障安全命令(GFC)"),
        Role::FlyingMaster(_) => put!(out; "飞行主站报文"),
        Role::Sync => put!(out; "同步报文"),
        Role::Emcy(node) => put!(out; "节点", node, "的紧急报文"),
        Role::Time => put!(out; "时间戳"),
        Role::Srdo { number, inverted } => {
            put!(out; "SRDO", number, if inverted { "的取反数据" } else { "的正常数据" });
        }
        Role::Tpdo { number, node } => pdo(out, true, number, node),
        Role::Rpdo { number, node } => pdo(out, false, number, node),
        Role::SdoResponse(node) => put!(out; "节点", node, "的SDO响应"),
        Role::SdoRequest(node) => put!(out; "对节点", node, "的SDO请求"),
        Role::ErrorControl(node) => put!(out; "节点", node, "的错误控制报文"),
        Role::LssRequest => put!(out; "LSS主站报文"),
        Role::LssResponse => put!(out; "LSS从站报文"),
        Role::DynamicSdo | Role::Reserved | Role::Unassigned | Role::Foreign => foreign(out, role),
    }
}

fn malformed(out: &mut Vec<u8>, full: bool, of: Role, flaw: Flaw, frame: &Frame) {
    put!(out; "不合规的报文 (");
    role(out, of);
    put!(out; ")");
    if !full {
        return;
    }
    match flaw {
        Flaw::Length { least, most } => {
            put!(out; ": 长度", frame.len, "字节, 应为", least);
            if most == least.saturating_add(1) {
                put!(out; "或", most);
            } else if most != least {
                put!(out; "至", most);
            }
            put!(out; "字节");
            if matches!(of, Role::Emcy(_)) && frame.len == 0 && frame.kind == Kind::Data {
                put!(out; " (可能是DS 301 V3的启动报文)");
            }
        }
        Flaw::Remote => put!(out; ": 该服务没有远程帧 (请求长度", frame.len, "字节)"),
        Flaw::Fd => put!(out; ": 该服务没有CAN FD帧 (", frame.len, "字节)"),
    }
}
