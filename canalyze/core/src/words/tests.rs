//! Frames as literal bytes with their expected words, in both languages.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use super::{Depth, Lang, explain, services};
use crate::bytes::frame::{CanId, Frame, Kind};
use crate::tables::jsonl;
use crate::wire::cob_id::{Role, predefined};
use crate::wire::decode;
use crate::wire::message::Message;
use crate::wire::pdo;
use crate::words::escape::unsafe_on_a_terminal;
use proptest::prelude::*;

fn data(id: u16, payload: &[u8]) -> Frame {
    Frame::classic(CanId::standard(id), payload)
}

fn remote(id: u16, len: u8) -> Frame {
    Frame { kind: Kind::Remote, len, ..data(id, &[]) }
}

fn error(class: u32, payload: &[u8]) -> Frame {
    Frame { kind: Kind::Error, ..Frame::classic(CanId::extended(class), payload) }
}

fn fd(id: u16, payload: &[u8]) -> Frame {
    let mut frame = Frame { kind: Kind::Fd { brs: true, esi: false }, ..data(id, &[]) };
    frame.data[..payload.len()].copy_from_slice(payload);
    frame.len = payload.len() as u8;
    frame
}

fn says(lang: Lang, depth: Depth, message: &Message, frame: &Frame) -> String {
    let mut out = Vec::new();
    services::message(&mut out, lang, depth, message, frame);
    String::from_utf8(out).unwrap()
}

fn explains(lang: Lang, message: &Message, frame: &Frame) -> String {
    let mut out = Vec::new();
    explain::services::message(&mut out, lang, message, frame);
    String::from_utf8(out).unwrap()
}

fn json(message: &Message, frame: &Frame) -> serde_json::Value {
    let mut out = Vec::new();
    jsonl::services::fields(&mut out, message, frame);
    serde_json::from_slice(&out).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&out)))
}

fn own(frame: &Frame) -> Message {
    decode(predefined(frame.id), frame)
}

#[track_caller]
fn check(frame: &Frame, zh: &str, en: &str) {
    let message = own(frame);
    assert_eq!(says(Lang::Zh, Depth::Default, &message, frame), zh);
    assert_eq!(says(Lang::En, Depth::Default, &message, frame), en);
}

#[track_caller]
fn check_brief(frame: &Frame, zh: &str, en: &str) {
    let message = own(frame);
    assert_eq!(says(Lang::Zh, Depth::Brief, &message, frame), zh);
    assert_eq!(says(Lang::En, Depth::Brief, &message, frame), en);
}

#[track_caller]
fn check_explained(frame: &Frame, lines: &str) {
    let lang = if lines.is_ascii() { Lang::En } else { Lang::Zh };
    assert_eq!(explains(lang, &own(frame), frame), lines);
}

#[test]
fn time() {
    let frame = data(0x100, &[0x95, 0x2C, 0xB3, 0x02, 0x9E, 0x39]);
    check(
        &frame,
        "时间报文(TIME): 2024-05-20 12:34:56.789 (45296789 ms, 第14750天)",
        "TIME: 2024-05-20 12:34:56.789 (45296789 ms, day 14750)",
    );
    check_brief(&frame, "时间报文(TIME)", "TIME");
    check_explained(
        &frame,
        "#   COB-ID 100h: 时间报文(TIME), 生产者 -> 消费者\n\
         #   95 2C B3 02 = 02B32C95h (小端格式)  位31-28: 0000b 保留 | 位27-0: 午夜起45296789 ms = 12:34:56.789\n\
         #   9E 39 = 399Eh (小端格式)  1984-01-01起14750天 = 2024-05-20\n",
    );
    check(
        &data(0x100, &[0xFF, 0xFF, 0xFF, 0x1F, 0, 0]),
        "时间报文(TIME): 1984-01-01 74:33:55.455 (268435455 ms, 第0天), 超出一天, 保留位不为0 (1h)",
        "TIME: 1984-01-01 74:33:55.455 (268435455 ms, day 0), beyond a day, reserved bits are not 0 (1h)",
    );
    check(
        &data(0x100, &[0; 8]),
        "格式错误 (时间报文(TIME)): 长度8字节, 应为6字节",
        "malformed (TIME): length 8 bytes, expected 6 bytes",
    );
}

#[test]
fn emergency() {
    let frame = data(0x08A, &[0x30, 0x81, 0x11, 0x05, 0, 0, 0, 0]);
    check(
        &frame,
        "节点10的紧急报文: 8130h 寿命保护错误或心跳错误, 错误寄存器=11h (一般错误, 通信错误), 制造商数据 05 00 00 00 00",
        "EMCY of node 10: 8130h life guard error or heartbeat error, error register=11h (generic error, \
         communication error), manufacturer data 05 00 00 00 00",
    );
    check_brief(&frame, "节点10的紧急报文", "EMCY of node 10");
    check_explained(
        &frame,
        "#   COB-ID 08Ah = 080h + 节点ID 0Ah (10): 紧急报文, 生产者 -> 消费者\n\
         #   30 81  错误码 8130h (小端格式): 寿命保护错误或心跳错误\n\
         #   11 = 0001 0001b  错误寄存器(1001h)  位0: 1 一般错误 | 位4: 1 通信错误\n\
         #   05 00 00 00 00  制造商数据\n",
    );
    check(
        &data(0x08A, &[0; 8]),
        "节点10的紧急报文: 0000h 错误复位或无错误, 错误寄存器=00h, 制造商数据 00 00 00 00 00",
        "EMCY of node 10: 0000h error reset or no error, error register=00h, manufacturer data 00 00 00 00 00",
    );
    check(
        &data(0x08A, &[]),
        "格式错误 (节点10的紧急报文): 长度0字节, 应为8字节 (可能是DS 301 V3的启动报文)",
        "malformed (EMCY of node 10): length 0 bytes, expected 8 bytes (may be the boot-up message of DS 301 V3)",
    );
    let json = json(&own(&frame), &frame);
    assert_eq!(json["code"], "8130");
    assert_eq!(json["register_bits"], serde_json::json!([0, 4]));
    assert_eq!(json["manufacturer"], "0500000000");
}

#[test]
fn layer_setting() {
    let master = |payload: &[u8], zh: &str, en: &str| check(&data(0x7E5, payload), zh, en);
    let slave = |payload: &[u8], zh: &str, en: &str| check(&data(0x7E4, payload), zh, en);
    master(
        &[0x04, 1, 0, 0, 0, 0, 0, 0],
        "LSS主站: 全局切换状态: 配置状态",
        "LSS master: switch state global: configuration state",
    );
    master(
        &[0x04, 0, 0, 0, 0, 0, 0, 0],
        "LSS主站: 全局切换状态: 等待状态",
        "LSS master: switch state global: waiting state",
    );
    master(&[0x11, 0x0A, 0, 0, 0, 0, 0, 0], "LSS主站: 配置节点ID = 10", "LSS master: configure node-ID = 10");
    master(
        &[0x11, 0, 0, 0, 0, 0, 0, 0],
        "LSS主站: 配置节点ID = 0 (无效)",
        "LSS master: configure node-ID = 0 (invalid)",
    );
    check_explained(
        &data(0x7E5, &[0x11, 0, 0, 0, 0, 0, 0, 0]),
        "#   COB-ID 7E5h: LSS, 主站 -> 从站\n\
         #   11  命令字: LSS主站: 配置节点ID\n\
         #   00  节点ID 00h (0) 无效\n\
         #   00 00 00 00 00 00  保留\n",
    );
    master(
        &[0x11, 0xFF, 0, 0, 0, 0, 0, 0],
        "LSS主站: 配置节点ID = FFh (未配置)",
        "LSS master: configure node-ID = FFh (unconfigured)",
    );
    master(
        &[0x13, 0, 2, 0, 0, 0, 0, 0],
        "LSS主站: 配置位定时: 波特率 500 kbit/s (表=0, 序号=2)",
        "LSS master: configure bit timing: bit rate 500 kbit/s (table=0, index=2)",
    );
    master(
        &[0x15, 0xE8, 0x03, 0, 0, 0, 0, 0],
        "LSS主站: 激活位定时: 切换延迟=1000 ms",
        "LSS master: activate bit timing: switch delay=1000 ms",
    );
    master(&[0x17, 0, 0, 0, 0, 0, 0, 0], "LSS主站: 存储配置", "LSS master: store configuration");
    master(
        &[0x40, 0x78, 0x56, 0x34, 0x12, 0, 0, 0],
        "LSS主站: 选择性切换状态, 制造商ID = 12345678h",
        "LSS master: switch state selective, vendor-ID = 12345678h",
    );
    master(
        &[0x41, 0xDD, 0xCC, 0xBB, 0xAA, 0, 0, 0],
        "LSS主站: 选择性切换状态, 产品码 = AABBCCDDh",
        "LSS master: switch state selective, product code = AABBCCDDh",
    );
    master(
        &[0x42, 2, 0, 1, 0, 0, 0, 0],
        "LSS主站: 选择性切换状态, 修订号 = 00010002h",
        "LSS master: switch state selective, revision number = 00010002h",
    );
    master(
        &[0x43, 0x99, 0, 0, 0, 0, 0, 0],
        "LSS主站: 选择性切换状态, 序列号 = 00000099h",
        "LSS master: switch state selective, serial number = 00000099h",
    );
    slave(
        &[0x44, 0, 0, 0, 0, 0, 0, 0],
        "LSS从站: 选择性切换状态响应 (已进入配置状态)",
        "LSS slave: switch state selective response (in configuration state)",
    );
    slave(
        &[0x11, 1, 0, 0, 0, 0, 0, 0],
        "LSS从站: 配置节点ID响应: 节点ID超出范围 (错误码 01h)",
        "LSS slave: configure node-ID response: node-ID out of range (error code 01h)",
    );
    slave(
        &[0x17, 0xFF, 7, 0, 0, 0, 0, 0],
        "LSS从站: 存储配置响应: 制造商定义的错误 (错误码 FFh, 特定错误码 07h)",
        "LSS slave: store configuration response: implementation-specific error (error code FFh, specific error code 07h)",
    );
    slave(
        &[0x13, 0, 0, 0, 0, 0, 0, 0],
        "LSS从站: 配置位定时响应: 成功",
        "LSS slave: configure bit timing response: done",
    );
    slave(
        &[0x5A, 0x78, 0x56, 0x34, 0x12, 0, 0, 0],
        "LSS从站: 制造商ID查询响应 = 12345678h",
        "LSS slave: inquire response, vendor-ID = 12345678h",
    );
    slave(&[0x5E, 0x0A, 0, 0, 0, 0, 0, 0], "LSS从站: 节点ID查询响应 = 10", "LSS slave: inquire response, node-ID = 10");
    slave(&[0x50, 0, 0, 0, 0, 0, 0, 0], "LSS从站: 未配置从站的识别响应", "LSS slave: identify non-configured slave");
}

#[test]
fn layer_setting_fastscan() {
    let any = data(0x7E5, &[0x51, 0, 0, 0, 0, 0x80, 0, 0]);
    check(
        &any,
        "LSS主站: 快速扫描(Fastscan): 询问是否有未配置的从站 (IDNumber=00000000h, BitCheck=80h, LSSSub=0, LSSNext=0)",
        "LSS master: Fastscan: is there any non-configured slave? (IDNumber=00000000h, BitCheck=80h, LSSSub=0, LSSNext=0)",
    );
    check(
        &data(0x7E5, &[0x51, 0, 0, 0, 0, 0x1F, 1, 1]),
        "LSS主站: 快速扫描(Fastscan): 产品码, 比较位31 (IDNumber=00000000h, BitCheck=31, LSSSub=1, LSSNext=1)",
        "LSS master: Fastscan: product code, compare bit 31 (IDNumber=00000000h, BitCheck=31, LSSSub=1, LSSNext=1)",
    );
    check(
        &data(0x7E5, &[0x51, 3, 0, 0, 0, 0, 3, 0]),
        "LSS主站: 快速扫描(Fastscan): 序列号, 比较位31-0, 确认并转到制造商ID \
         (IDNumber=00000003h, BitCheck=0, LSSSub=3, LSSNext=0)",
        "LSS master: Fastscan: serial number, compare bits 31-0, confirm and continue with vendor-ID \
         (IDNumber=00000003h, BitCheck=0, LSSSub=3, LSSNext=0)",
    );
    check(&data(0x7E4, &[0x4F, 0, 0, 0, 0, 0, 0, 0]), "LSS从站: 从站识别响应", "LSS slave: identify slave");
    check_explained(
        &any,
        "#   COB-ID 7E5h: LSS, master -> slaves\n\
         #   51  command specifier: LSS master: Fastscan\n\
         #   00 00 00 00  IDNumber 00000000h (little-endian)\n\
         #   80  BitCheck: is there any non-configured slave?\n\
         #   00  LSSSub: vendor-ID\n\
         #   00  LSSNext: vendor-ID\n",
    );
}

#[test]
fn error_control() {
    let operational = data(0x70A, &[0x05]);
    check(&operational, "节点10的心跳: 操作状态", "heartbeat of node 10: Operational");
    check_brief(&operational, "节点10的心跳", "heartbeat of node 10");
    check_explained(
        &operational,
        "#   COB-ID 70Ah = 700h + 节点ID 0Ah (10): 错误控制 (启动报文, 心跳, 节点保护)\n\
         #   05 = 0000 0101b  位7: 0 (心跳中恒为0; 节点保护中为toggle位) | 位6-0: 05h 操作状态\n",
    );
    check(&data(0x70A, &[0x00]), "节点10的启动报文", "boot-up of node 10");
    check(&remote(0x70A, 0), "NMT主站对节点10的节点保护请求", "node guarding request of the NMT master to node 10");
    check(
        &data(0x70A, &[0xFF]),
        "节点10的节点保护应答: 预操作状态 (toggle=1)",
        "node guarding response of node 10: Pre-operational (toggle=1)",
    );
    check(&data(0x70A, &[0x7F]), "节点10的心跳: 预操作状态", "heartbeat of node 10: Pre-operational");
    check(&data(0x70A, &[0x06]), "节点10的心跳: 未知状态 06h", "heartbeat of node 10: unknown state 06h");
    assert_eq!(own(&data(0x70A, &[0xFF])).service(), "guarding");
    assert_eq!(own(&data(0x70A, &[0x00])).service(), "heartbeat");
}

#[test]
fn node_control() {
    let start = data(0x000, &[0x01, 0x0A]);
    check(&start, "NMT主站命令: 启动节点10 (进入操作状态)", "NMT start remote node: node 10 (to Operational)");
    check_brief(&start, "NMT主站命令: 启动节点10", "NMT start remote node: node 10");
    check_explained(
        &start,
        "#   COB-ID 000h: NMT节点控制, NMT主站 -> NMT从站\n\
         #   01  命令字: 启动远程节点\n\
         #   0A  节点ID 0Ah (10)\n",
    );
    check_brief(&data(0x000, &[0x82, 0x00]), "NMT主站命令: 所有节点复位通信", "NMT reset communication: all nodes");
    check(
        &data(0x000, &[0x50, 0xC8]),
        "NMT主站命令: 未知命令 50h, 无效的节点ID 200",
        "NMT unknown command 50h: invalid node-ID 200",
    );
    assert_eq!(own(&start).node(), Some(10));
    assert_eq!(own(&data(0x000, &[0x82, 0x00])).node(), None);
    assert_eq!(json(&own(&start), &start)["name"], "start remote node");
}

#[test]
fn sync() {
    check(&data(0x080, &[]), "同步报文", "SYNC");
    for counter in [1, 2, 3, 4, 1] {
        let zh = format!("同步报文: 计数={counter}");
        check(&data(0x080, &[counter]), &zh, &format!("SYNC: counter={counter}"));
    }
    check(
        &data(0x080, &[1, 2]),
        "格式错误 (同步报文): 长度2字节, 应为0或1字节",
        "malformed (SYNC): length 2 bytes, expected 0 or 1 byte",
    );
    check(
        &remote(0x080, 0),
        "格式错误 (同步报文): 该服务没有远程帧 (请求长度0字节)",
        "malformed (SYNC): this service has no remote frames (requested length 0 bytes)",
    );
}

#[test]
fn process_data() {
    let frame = data(0x185, &[1, 2, 3, 4, 5, 6, 7, 8]);
    check(&frame, "节点5的TPDO1: 8字节", "TPDO1 of node 5: 8 bytes");
    check_brief(&frame, "节点5的TPDO1", "TPDO1 of node 5");
    check_explained(
        &frame,
        "#   COB-ID 185h = 180h + 节点ID 05h (5): TPDO1, 该节点 -> 消费者\n\
         #   通信参数 1800h, 映射参数 1A00h: 数据的含义由映射决定\n\
         #   01 02 03 04 05 06 07 08  数据(8字节)\n",
    );
    check(
        &remote(0x285, 4),
        "对节点5的TPDO2的远程请求: 请求长度4字节",
        "remote request for TPDO2 of node 5: requested length 4 bytes",
    );
    // Moved by a configuration: the identifier's own formula would be wrong.
    let frame = data(0x2AA, &[0xAA]);
    let message = Message::Pdo { transmit: true, number: 5, node: 10 };
    assert_eq!(
        explains(Lang::Zh, &message, &frame),
        "#   COB-ID 2AAh: 由配置指定, 节点10的TPDO5\n\
         #   通信参数 1804h, 映射参数 1A04h: 数据的含义由映射决定\n\
         #   AA  数据(1字节)\n"
    );
}

#[test]
fn multiplex_pdo() {
    let role = Role::Tpdo { number: 1, node: 10 };
    let frame = data(0x18A, &[0x8A, 0x00, 0x20, 0x01, 0x2A, 0, 0, 0]);
    let message = pdo::decode_multiplexed(role, true, 1, 10, &frame);
    assert_eq!(
        says(Lang::Zh, Depth::Default, &message, &frame),
        "节点10的TPDO1: DAM-MPDO, 写节点10的2000h:01 = 2A 00 00 00 (42)"
    );
    assert_eq!(
        says(Lang::En, Depth::Default, &message, &frame),
        "TPDO1 of node 10: DAM-MPDO, write to node 10: 2000h:01 = 2A 00 00 00 (42)"
    );
    assert_eq!(
        explains(Lang::En, &message, &frame),
        "#   COB-ID 18Ah = 180h + node-ID 0Ah (10): TPDO1, this node -> consumers\n\
         #   communication parameter 1800h, mapping parameter 1A00h: the mapping defines the data\n\
         #   8A = 1000 1010b  bit 7: 1 destination address mode (DAM) | bits 6-0: 0Ah node-ID (10)\n\
         #   00 20  index 2000h (little-endian)\n\
         #   01  sub-index 01h\n\
         #   2A 00 00 00  data (4 bytes) = 42 (little-endian)\n"
    );
    let frame = data(0x18A, &[0x0A, 0x00, 0x20, 0x01, 0x2A, 0, 0, 0]);
    let message = pdo::decode_multiplexed(role, true, 1, 10, &frame);
    assert_eq!(
        says(Lang::Zh, Depth::Default, &message, &frame),
        "节点10的TPDO1: SAM-MPDO, 生产者节点10的2000h:01 = 2A 00 00 00 (42)"
    );
    assert_eq!(
        says(Lang::En, Depth::Default, &message, &frame),
        "TPDO1 of node 10: SAM-MPDO, producer node 10: 2000h:01 = 2A 00 00 00 (42)"
    );
    assert_eq!(json(&message, &frame)["mpdo"]["mode"], "sam");
    let frame = data(0x18A, &[0x0A]);
    assert!(matches!(pdo::decode_multiplexed(role, true, 1, 10, &frame), Message::Malformed { .. }));
}

#[test]
fn error_frames() {
    let frame = error(0x004, &[0, 0x08, 0, 0, 0, 0, 0x60, 0]);
    check(
        &frame,
        "错误帧: 控制器问题 (发送错误达到警告水平), 发送错误计数=96, 接收错误计数=0",
        "error frame: controller problem (TX error warning level), TX error counter=96, RX error counter=0",
    );
    check_brief(&frame, "错误帧", "error frame");
    check_explained(
        &frame,
        "#   错误帧, 类别 00000004h\n\
         #     00000004h  控制器问题\n\
         #   d1: 08 = 0000 1000b  位3: 1 发送错误达到警告水平\n\
         #   d6: 60  发送错误计数 = 96\n\
         #   d7: 00  接收错误计数 = 0\n",
    );
    check(
        &error(0x09A, &[5, 0, 0x84, 0x0A, 0x74, 0, 0, 0]),
        "错误帧: 仲裁丢失 (第5位), 协议违规 (位填充错误, 发生在发送时), 位置: 数据段, \
         收发器状态 (CANH断线, CANL对地短路), 总线错误",
        "error frame: lost arbitration (bit 5), protocol violation (bit stuffing error, occurred on transmission), \
         location: data section, transceiver status (CANH no wire, CANL short to GND), bus error",
    );
    check(
        &error(0x200, &[0; 8]),
        "错误帧: 发送错误计数=0, 接收错误计数=0",
        "error frame: TX error counter=0, RX error counter=0",
    );
    check(&error(0x400, &[0; 8]), "错误帧: 未知类别 00000400h", "error frame: unknown class 00000400h");
    assert_eq!(json(&own(&frame), &frame)["tx_errors"], 96);
}

#[test]
fn the_rest() {
    check(&data(0x001, &[]), "全局故障安全命令(GFC)", "global fail-safe command (GFC)");
    check(
        &data(0x071, &[0, 1]),
        "飞行主站: 活动NMT主站的响应: 节点1, 优先级=0",
        "flying master: response of the active NMT master: node 1, priority=0",
    );
    check(&data(0x102, &[0xFE]), "SRDO1的取反数据: 1字节", "inverted data of SRDO1: 1 byte");
    check(&data(0x7FF, &[1]), "CiA 301保留的ID", "ID reserved by CiA 301");
    check(&data(0x680, &[1]), "未分配的ID", "unassigned ID");
    check(
        &Frame::classic(CanId::extended(0x18FE_F100), &[1]),
        "29位ID, 非CANopen预定义",
        "29-bit ID, not pre-defined in CANopen",
    );
    let usdo = fd(0x60A, &[5, 0x01, 7, 0x01, 0x00, 0x20, 0x07, 4, 0x2A, 0, 0, 0]);
    check(
        &usdo,
        "USDO请求, 节点10 -> 节点5: 加速下载请求, 会话=7, 2000h:01, 类型 UNSIGNED32, 4字节: 2A 00 00 00",
        "USDO request, node 10 -> node 5: expedited download request, session=7, 2000h:01, type UNSIGNED32, \
         4 bytes: 2A 00 00 00",
    );
    check(
        &fd(0x585, &[10, 0x7F, 7, 0x01, 0x00, 0x20, 0x33]),
        "USDO响应, 节点5 -> 节点10: 中止, 会话=7, 2000h:01, 中止码 33h 对象字典中不存在该对象",
        "USDO response, node 5 -> node 10: abort, session=7, 2000h:01, abort code 33h object does not exist in the \
         object dictionary",
    );
    check(
        &data(0x60A, &[0x40]),
        "格式错误 (对节点10的SDO请求): 长度1字节, 应为8字节",
        "malformed (SDO request to node 10): length 1 byte, expected 8 bytes",
    );
    let mut out = Vec::new();
    explain::cob_id(&mut out, Lang::Zh, Role::SdoRequest(10), &data(0x60A, &[]));
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "#   COB-ID 60Ah = 600h + 节点ID 0Ah (10): SDO请求, 主站(客户端) -> 从站(服务器)\n"
    );
}

/// The digits of a sentence, which have to be the same in both languages.
fn figures(text: &str) -> String {
    text.chars().filter(char::is_ascii_digit).collect()
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let kind = prop_oneof![
        4 => Just(Kind::Data),
        1 => Just(Kind::Remote),
        1 => Just(Kind::Fd { brs: false, esi: true }),
        1 => Just(Kind::Error),
    ];
    let id = prop_oneof![
        4 => (0u16..0x800).prop_map(CanId::standard),
        2 => Just(CanId::standard(0x7E5)),
        2 => Just(CanId::standard(0x7E4)),
        1 => any::<u32>().prop_map(CanId::extended),
        1 => (0u32..0x400).prop_map(CanId::extended),
    ];
    let payload = prop_oneof![
        4 => proptest::collection::vec(any::<u8>(), 0..=8),
        2 => proptest::collection::vec(any::<u8>(), 8),
        1 => proptest::collection::vec(any::<u8>(), 0..=64),
    ];
    (kind, id, payload).prop_map(|(kind, id, payload)| {
        let mut frame = Frame { kind, ..Frame::classic(id, &[]) };
        let most = if matches!(kind, Kind::Fd { .. }) { 64 } else { 8 };
        let len = payload.len().min(most);
        frame.len = len as u8;
        if kind != Kind::Remote {
            frame.data[..len].copy_from_slice(&payload[..len]);
        }
        frame
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 4000, ..ProptestConfig::default() })]

    #[test]
    fn every_frame_has_words(frame in any_frame(), multiplex in any::<bool>()) {
        let mut message = own(&frame);
        if let (true, Message::Pdo { transmit, number, node }) = (multiplex, message) {
            message = pdo::decode_multiplexed(predefined(frame.id), transmit, number, node, &frame);
        }
        prop_assert!(!message.service().is_empty());
        for depth in [Depth::Brief, Depth::Default, Depth::Explain] {
            let (zh, en) = (says(Lang::Zh, depth, &message, &frame), says(Lang::En, depth, &message, &frame));
            for text in [&zh, &en] {
                prop_assert!(!text.is_empty());
                prop_assert!(!text.chars().any(unsafe_on_a_terminal), "{:?}", text);
            }
            prop_assert!(en.is_ascii(), "{}", en);
            prop_assert!(says(Lang::Zh, Depth::Default, &message, &frame).starts_with(&says(Lang::Zh, Depth::Brief, &message, &frame)));
        }
        for lang in [Lang::Zh, Lang::En] {
            let lines = explains(lang, &message, &frame);
            prop_assert!(lines.ends_with('\n'));
            for line in lines.lines() {
                prop_assert!(line.starts_with("#   ") && line.len() > 4, "{:?}", line);
                prop_assert!(!line.chars().any(unsafe_on_a_terminal), "{:?}", line);
            }
            prop_assert!(json(&message, &frame).is_object());
        }
        let (zh, en) = (explains(Lang::Zh, &message, &frame), explains(Lang::En, &message, &frame));
        prop_assert_eq!(zh.lines().count(), en.lines().count());
        prop_assert!(en.is_ascii(), "{}", en);
        if !matches!(message, Message::Malformed { .. } | Message::Mpdo { .. } | Message::Pdo { .. } | Message::Nmt { .. }) {
            // These name node and number in another order, or repeat a figure; all others must agree digit by digit.
            let (zh, en) = (says(Lang::Zh, Depth::Default, &message, &frame), says(Lang::En, Depth::Default, &message, &frame));
            let (mut zh, mut en): (Vec<_>, Vec<_>) = (figures(&zh).chars().collect(), figures(&en).chars().collect());
            zh.sort_unstable();
            en.sort_unstable();
            prop_assert_eq!(zh, en);
        }
    }
}
