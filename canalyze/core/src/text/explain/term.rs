//! Terms of CANopen: what they are, where they are defined, and what usually goes wrong with them.
//!
//! A term is found by any of its names, whatever their case, in either language. Must not: look at a frame.

use crate::text::Lang;
use crate::text::digits::{Hex, put};

/// A row.
struct Term {
    /// Its names with single spaces; the first one, in English, and the second, in Chinese, are shown.
    names: &'static [&'static str],
    clause: &'static str,
    /// What it is, in Chinese and English.
    what: (&'static str, &'static str),
    /// What usually goes wrong.
    wrong: (&'static str, &'static str),
}

/// Appends what a term is; `false`, and nothing, where it is none that is known.
pub(super) fn term(out: &mut Vec<u8>, lang: Lang, text: &str) -> bool {
    let wanted: Vec<String> =
        text.split(|one: char| one.is_whitespace() || one == '-').map(str::to_lowercase).collect();
    let wanted = wanted.iter().filter(|one| !one.is_empty()).map(String::as_str).collect::<Vec<_>>().join(" ");
    let known = |name: &str| !is_object(name) && name.to_lowercase().replace('-', " ") == wanted;
    let Some(one) = TERMS.iter().find(|one| one.names.iter().any(|name| known(name))) else { return false };
    let (english, chinese) = (one.names.first().copied().unwrap_or(""), one.names.get(1).copied().unwrap_or(""));
    put!(out; lang.pick(chinese, english), " (", lang.pick(english, chinese), "): ");
    put!(out; lang.pick(one.what.0, one.what.1), "\n  ");
    put!(out; lang.pick("常见错误: ", "Usual mistakes: "), lang.pick(one.wrong.0, one.wrong.1), "\n  ");
    put!(out; one.clause, "\n");
    true
}

/// Appends what is to be known of an object, where it is that of a term.
pub(super) fn of_object(out: &mut Vec<u8>, lang: Lang, index: u16) {
    let index = match index {
        0x1200..=0x12FF => 0x1200,
        0x1400..=0x15FF => 0x1400,
        0x1600..=0x17FF | 0x1A00..=0x1BFF => 0x1600,
        0x1800..=0x19FF => 0x1800,
        other => other,
    };
    let mut name = Vec::new();
    put!(&mut name; Hex::<4>(u64::from(index)), "h");
    let of = |one: &&Term| one.names.iter().any(|known| known.as_bytes().eq_ignore_ascii_case(&name));
    if let Some(one) = TERMS.iter().find(of) {
        put!(out; "  ", lang.pick(one.what.0, one.what.1), "\n");
        put!(out; lang.pick("  常见错误: ", "  Usual mistakes: "), lang.pick(one.wrong.0, one.wrong.1), "\n");
    }
}

/// Whether a name is the index of an object: as a word it is one, not a term.
fn is_object(name: &str) -> bool {
    matches!(name.as_bytes(), [digits @ .., b'h'] if digits.len() == 4 && digits.iter().all(u8::is_ascii_hexdigit))
}

macro_rules! terms {
    ($([$($name:literal),+] $clause:literal $what_zh:literal $what_en:literal; $wrong_zh:literal $wrong_en:literal;)*) => {
        static TERMS: &[Term] = &[$(Term {
            names: &[$($name),+],
            clause: $clause,
            what: ($what_zh, $what_en),
            wrong: ($wrong_zh, $wrong_en),
        },)*];
    };
}

terms! {
    ["COB-ID", "通信对象标识符", "cob", "can-id", "can-id标识符"] "CiA 301 7.3.5, 7.5.2"
        "通信对象的标识符: CAN-ID(11或29位)加上标志位; 位31为1时PDO、EMCY无效, 位30在1005h里表示生产SYNC, 在180xh:01里表示不允许RTR"
        "the identifier of a communication object: the CAN-ID (11 or 29 bits) with flags; bit 31 makes a PDO or EMCY invalid, bit 30 makes a SYNC producer in 1005h and forbids RTR in 180xh:01";
        "对象有效时改写CAN-ID(应先使其无效), 写入的值忘了加节点ID, 两个节点使用同一COB-ID"
        "the CAN-ID is changed while the object is valid (make it invalid first), the node-ID is not added, two nodes share a COB-ID";
    ["node-id", "节点ID", "节点号"] "CiA 301 7.3.5"
        "节点在总线上的地址, 1到127; 预定义连接集由它算出COB-ID"
        "the address of a node, 1 to 127; the pre-defined connection set derives COB-IDs from it";
        "两个节点ID相同, 拨码开关改动后未复位, LSS设置后未存储"
        "two nodes with the same node-ID, DIP switches changed without a reset, an LSS setting not stored";
    ["pre-defined connection set", "预定义连接集", "predefined connection set"] "CiA 301 7.3.5"
        "COB-ID的默认分配: NMT 000h, SYNC 080h, EMCY 080h+n, TPDO1 180h+n, RPDO1 200h+n, SDO 580h+n和600h+n, 心跳700h+n"
        "the default COB-IDs: NMT 000h, SYNC 080h, EMCY 080h+n, TPDO1 180h+n, RPDO1 200h+n, SDO 580h+n and 600h+n, heartbeat 700h+n";
        "自定义的COB-ID与另一个节点的默认值重叠; 第5个以后的PDO没有默认COB-ID"
        "a custom COB-ID that is another node's default; PDOs beyond the fourth have no default";
    ["NMT", "网络管理", "network management"] "CiA 301 7.2.8, 7.3.2"
        "主站用CAN-ID 000h命令节点的状态: 01h启动, 02h停止, 80h进入预操作状态, 81h复位节点, 82h复位通信; 第二字节是节点ID, 0为全部"
        "the master commands states by CAN-ID 000h: 01h start, 02h stop, 80h Pre-operational, 81h reset node, 82h reset communication; the second byte is the node-ID, 0 for all";
        "命令没有确认, 丢失后只能由心跳看出; 两个命令相隔不到1 ms时有的节点会漏收; 同时有两个主站"
        "commands are not confirmed: only heartbeats show a lost one; some nodes miss one of two within 1 ms; two masters at the same time";
    ["master", "主站", "slave", "从站", "nmt master", "nmt主站", "nmt slave", "nmt从站"] "CiA 301 7.2.8, 7.3.2"
        "主站以NMT命令启动、停止和复位节点, 多由控制器担任; 其余节点为从站。与PDO、SDO的方向无关: 从站也可自行发送"
        "the master starts, stops and resets nodes by NMT commands, usually the controller does; all other nodes are slaves. PDO and SDO are independent of it: slaves send on their own as well";
        "同时有两个主站; 主站未启动从站; 与SDO的客户端和服务器混淆"
        "two masters at the same time; slaves that the master never starts; confused with SDO client and server";
    ["client", "客户端", "server", "服务器", "sdo client", "sdo客户端", "sdo server", "sdo服务器"] "CiA 301 7.2.4"
        "SDO的两端: 客户端(多为主站)以600h+n请求, 服务器(拥有对象字典的节点n)以580h+n响应"
        "the two ends of an SDO: the client, usually the master, requests on 600h+n; the server, node n with its object dictionary, responds on 580h+n";
        "两个客户端同时使用一个服务器的默认通道; 客户端超时短于服务器的处理时间"
        "two clients on the default channel of one server at the same time; a client timeout shorter than the server needs";
    ["request", "请求", "response", "响应"] "CiA 301 7.2.4, 7.2.8.3.2.1"
        "请求由SDO客户端、LSS主站或节点保护的主站发送, 对方应以响应回复"
        "a request is sent by an SDO client, an LSS master or a guarding master; the other end has to send a response";
        "没有响应: 节点离线或停止; 响应过晚; 没有请求的响应"
        "no response: node offline or Stopped; a late response; a response without a request";
    ["timeout", "超时"] "CiA 301 7.2.4.3.17, 7.2.8.3.2"
        "在规定时间内没有收到应有的报文: SDO响应、心跳(1016h)、节点保护、RPDO(140xh:05)"
        "an expected frame does not come in time: an SDO response, a heartbeat (1016h), node guarding, an RPDO (140xh:05)";
        "时间设得过短; 单位弄错(ms, 100 µs, µs); 存储参数时节点响应很慢"
        "time set too short; wrong unit (ms, 100 µs, µs); nodes respond slowly while storing parameters";
    ["boot-up", "启动报文", "bootup", "boot up message"] "CiA 301 7.2.8.3.3"
        "节点初始化后发送一次700h+n, 数据00h, 随后进入预操作状态"
        "700h+n with 00h, sent once after initialisation; the node is then Pre-operational";
        "没有复位命令却出现, 说明断电或看门狗复位; 未存储的配置会丢失"
        "a boot-up without a reset command means power loss or a watchdog reset; configuration that was not stored is lost";
    ["operational", "操作状态", "nmt state", "nmt状态", "pre-operational", "预操作状态", "预操作", "stopped", "停止状态"] "CiA 301 7.3.2"
        "NMT状态: 启动后为预操作状态(7Fh, 只有SDO), 启动命令后为操作状态(05h, 有PDO), 停止状态(04h)下只有NMT和心跳"
        "NMT states: Pre-operational (7Fh, SDO only) after boot-up, Operational (05h, with PDOs) after a start, Stopped (04h) with NMT and heartbeat only";
        "节点未启动就等待其PDO; 重启后停留在预操作状态"
        "waiting for PDOs of a node that was never started; node stays Pre-operational after a restart";
    ["heartbeat", "心跳", "producer heartbeat time", "心跳生产者时间", "1017h"] "CiA 301 7.2.8.3.2.2, 7.5.2.20"
        "节点按1017h(ms)的周期发送700h+n, 数据为其NMT状态; 0为关闭"
        "700h+n with the NMT state of the node, sent every 1017h milliseconds; 0 turns it off";
        "1017h默认为0, 没有节点监视; 周期没有存储, 重启后心跳消失"
        "1017h is 0 by default, so nothing is monitored; a period that was not stored is lost after a restart";
    ["heartbeat consumer time", "消费者心跳时间", "心跳消费者时间", "consumer heartbeat time", "heartbeat consumer", "心跳消费者", "1016h"] "CiA 301 7.2.8.3.2.2, 7.5.2.19"
        "1016h的每个子索引: 位23-16为被监视的节点ID, 位15-0为时限(ms); 收到第一个心跳后开始监视, 超时报告EMCY 8130h"
        "each sub-index of 1016h: bits 23-16 the monitored node-ID, bits 15-0 the limit in ms; monitoring starts with the first heartbeat, a timeout is reported by EMCY 8130h";
        "时限短于对方的1017h(应至少1.5倍); 留有已不再安装的节点; 复位对方也会触发"
        "limit shorter than the producer's 1017h (use at least 1.5 times); entries for nodes no longer installed; a reset of the other node also triggers it";
    ["node guarding", "节点保护", "guarding", "guard time", "保护时间", "100ch"] "CiA 301 7.2.8.3.2.1, 7.5.2.11"
        "主站以远程帧查询700h+n, 节点应答状态和toggle位; 周期为100Ch (ms)"
        "the master sends a remote frame of 700h+n, the node responds with its state and a toggle bit; the period is 100Ch in ms";
        "与心跳同时使用; 适配器或节点不支持远程帧"
        "used together with heartbeats; an adapter or a node that does not support remote frames";
    ["life guarding", "寿命保护", "life time", "寿命时间", "life time factor", "寿命因子", "100dh"] "CiA 301 7.2.8.3.2.1, 7.5.2.12"
        "节点监视主站: 在100Ch × 100Dh (ms)内没有节点保护请求就报告EMCY 8130h并按1029h反应"
        "the node monitors the master: without a guarding request for 100Ch x 100Dh ms it reports EMCY 8130h and reacts as set in 1029h";
        "主站停在断点或过载时电机停止; 100Dh为0则不监视"
        "motors stop when the master halts at a breakpoint or is overloaded; with 100Dh = 0 there is no monitoring";
    ["toggle bit", "toggle位", "toggle", "翻转位"] "CiA 301 7.2.4.3.5, 7.2.8.3.2.1"
        "每帧翻转一次的位, 用于检测丢失或重复: SDO分段传输和节点保护应答都从0开始"
        "a bit that changes with each frame to detect lost or repeated ones; it starts with 0 in SDO segments and in guarding responses";
        "丢帧或重复请求后不再交替(中止码05030000h); 节点重启后又从0开始"
        "it does not alternate after a lost frame or a repeated request (abort code 05030000h); it starts again with 0 after a restart";
    ["SYNC", "同步报文", "同步", "sync producer", "sync生产者", "同步周期", "communication cycle period", "1005h", "1006h"] "CiA 301 7.2.5, 7.5.2.5, 7.5.2.6"
        "周期性的空报文(默认080h), 同步PDO以它为准; 生产者由1005h位30决定, 周期为1006h(µs)"
        "a periodic frame, empty by default, on 080h, that synchronous PDOs follow; bit 30 of 1005h makes the producer, 1006h is the period in µs";
        "没有生产者或有两个生产者; 1006h的单位为µs而不是ms; 抖动使驱动器报告同步错误"
        "no producer, or two; the unit of 1006h is µs, not ms; jitter makes drives report a sync error";
    ["SYNC window", "同步窗口", "synchronous window length", "同步窗口长度", "1007h"] "CiA 301 7.2.5, 7.5.2.7"
        "1007h, µs: 同步PDO应在SYNC之后这段时间内发送, 否则消费者可以丢弃"
        "1007h, in µs: synchronous PDOs have to be sent within this time after SYNC; consumers may drop later ones";
        "窗口短于总线发送全部同步PDO所需的时间; 大于周期没有意义"
        "window shorter than the bus needs for all synchronous PDOs; longer than the period has no effect";
    ["synchronous counter overflow", "同步计数器溢出值", "sync counter", "同步计数器", "1019h"] "CiA 301 7.5.2.22"
        "1019h: 非0时SYNC带一个从1到该值的计数字节; 180xh:06为TPDO开始发送的计数值"
        "1019h: if not 0, SYNC has a byte counting from 1 to this value; 180xh:06 is the count at which a TPDO starts";
        "生产者和消费者不一致: EMCY 8240h, SYNC长度异常"
        "producer and consumers differ: EMCY 8240h, unexpected SYNC length";
    ["PDO", "过程数据对象", "process data object"] "CiA 301 7.2.2"
        "过程数据: 一帧至多8字节, 没有协议开销和确认, 内容由映射(16xxh、1Axxh)决定"
        "process data: a frame of up to 8 bytes without overhead or confirmation; the mapping (16xxh, 1Axxh) defines its content";
        "双方映射不同; 节点不在操作状态; COB-ID位31为1"
        "mappings of both ends differ; node not Operational; bit 31 of the COB-ID is set";
    ["TPDO", "发送PDO", "transmit pdo", "1800h"] "CiA 301 7.2.2, 7.5.2.37, 7.5.2.38"
        "节点发送的PDO: 180xh为通信参数, 1Axxh为映射; 传输类型决定何时发送"
        "a PDO sent by the node: 180xh are its parameters, 1Axxh its mapping; the transmission type defines when it is sent";
        "传输类型为同步但没有SYNC; 事件型且抑制时间为0而占满总线; 与RPDO的方向弄反"
        "synchronous type without SYNC; event-driven with inhibit time 0 that fills the bus; confused with an RPDO";
    ["RPDO", "接收PDO", "receive pdo", "1400h"] "CiA 301 7.2.2, 7.5.2.35, 7.5.2.36"
        "节点接收的PDO: 140xh为通信参数, 16xxh为映射; 140xh:05为接收期限(ms), 超时则报告EMCY 8250h"
        "a PDO received by the node: 140xh are its parameters, 16xxh its mapping; 140xh:05 is a deadline in ms, a timeout is reported by EMCY 8250h";
        "节点未启动时被忽略; 长度不符时EMCY 8210h; 发送方离线"
        "ignored while the node is not Operational; EMCY 8210h for another length; producer offline";
    ["MPDO", "多路PDO", "multiplex pdo"] "CiA 301 7.2.2.4"
        "多路复用PDO: 前4字节是标志加节点ID、索引、子索引, 后4字节是数据; 分目的地址(DAM)和源地址(SAM)两种"
        "a multiplex PDO: flag and node-ID, index and sub-index in 4 bytes, then 4 bytes of data; by destination (DAM) or source (SAM)";
        "长度不是8字节(EMCY 8230h); 接收方没有分派表(1FD0h)"
        "another length than 8 bytes (EMCY 8230h); a consumer without a dispatcher list (1FD0h)";
    ["SRDO", "安全相关数据对象", "safety relevant data object"] "CiA 304, EN 50325-5"
        "安全数据: 相同内容以两帧发送, 第二帧逐位取反; SCT限制周期, SRVT限制两帧的间隔"
        "safety data: the same content in two frames, the second one inverse; SCT limits the cycle, SRVT the time between the two";
        "两帧不互为取反, SRVT或SCT太短, 校验和(13FFh)或配置有效(13FEh)未写"
        "frames not inverse, SRVT or SCT too short, checksum (13FFh) or configuration valid (13FEh) not written";
    ["inverse data", "取反数据", "complement"] "CiA 304, EN 50325-5"
        "SRDO的第二帧: 内容为第一帧的逐位取反"
        "the second frame of an SRDO: the content of the first one, each bit inverse";
        "两帧不互为取反, 次序颠倒"
        "frames that are not inverse, or in the wrong order";
    ["checksum", "校验和", "crc"] "CiA 301 7.2.4.3.9, CiA 304"
        "SDO块传输结束时的16位CRC; SRDO参数的校验和13FFh"
        "the 16-bit CRC at the end of an SDO block transfer; 13FFh, the checksum of SRDO parameters";
        "CRC不符(中止码05040004h); 改写SRDO参数后未更新13FFh"
        "CRC error (abort code 05040004h); 13FFh not updated after SRDO parameters were changed";
    ["PDO mapping", "PDO映射", "mapping", "映射", "1600h"] "CiA 301 7.5.2.36, 7.5.2.38"
        "每个条目32位: 索引、子索引、位长; 改写顺序: PDO无效(COB-ID位31=1), :00=0, 条目, :00=n, 有效"
        "an entry has 32 bits: index, sub-index, length in bits; to change it: PDO invalid (bit 31 of the COB-ID), :00 = 0, entries, :00 = n, valid";
        "顺序不对而被拒绝(06040041h、06040042h、06010000h); 总长超过64位; 重启后丢失"
        "refused because of the order (06040041h, 06040042h, 06010000h); more than 64 bits; lost by a restart";
    ["transmission type", "传输类型"] "CiA 301 7.5.2.35, 7.5.2.37"
        "0非循环同步, 1到240每n个SYNC一次, 252和253仅RTR, 254和255事件驱动"
        "0 synchronous acyclic, 1 to 240 every n-th SYNC, 252 and 253 RTR only, 254 and 255 event-driven";
        "没有SYNC时同步PDO不发送; 241到251保留"
        "synchronous PDOs are not sent without SYNC; 241 to 251 are reserved";
    ["inhibit time", "抑制时间", "禁止时间", "1015h"] "CiA 301 7.5.2.37, 7.5.2.18"
        "同一PDO(180xh:03)或EMCY(1015h)两次发送之间的最短时间, 单位100 µs"
        "the minimum time between two of one PDO (180xh:03) or EMCY (1015h), in units of 100 µs";
        "单位当成1 ms; 为0时一个节点可占满总线; 只能在PDO无效时改写"
        "unit taken for 1 ms; with 0 one node can fill the bus; can be written only while the PDO is invalid";
    ["event timer", "事件定时器", "event time"] "CiA 301 7.5.2.37, 7.5.2.35"
        "180xh:05, ms: 事件型TPDO最长每隔这么久发送一次; 140xh:05则为RPDO的接收期限"
        "180xh:05, in ms: an event-driven TPDO is sent at least this often; 140xh:05 is the deadline of an RPDO";
        "0为关闭, 值不变时消费者无法判断节点是否在线; RPDO接收期限短于发送方的周期"
        "0 disables it, so consumers see nothing while the value does not change; RPDO deadline shorter than the producer's period";
    ["SDO", "服务数据对象", "service data object", "1200h"] "CiA 301 7.2.4"
        "读写对象字典: 客户端600h+n请求, 服务器580h+n响应; 4字节以内加速, 更长的分段或块传输"
        "reads and writes the object dictionary: requests on 600h+n, responses on 580h+n; up to 4 bytes expedited, longer data segmented or by block transfer";
        "超时太短, 两个客户端共用一个通道, 停止状态下没有SDO"
        "timeout too short, two clients on one channel, no SDO in Stopped";
    ["expedited transfer", "加速传输", "expedited"] "CiA 301 7.2.4.3.3, 7.2.4.3.6"
        "数据至多4字节, 与请求或响应同在一帧里"
        "up to 4 bytes of data in the request or response itself";
        "未置长度指示(s位)而被服务器拒绝; 长度与对象类型不符"
        "server refuses because the size is not indicated (bit s); length differs from the object's type";
    ["segmented transfer", "分段传输", "segment"] "CiA 301 7.2.4.3.5, 7.2.4.3.6"
        "每帧7字节, 逐帧确认, 用toggle位交替, c位表示最后一段"
        "7 bytes per frame, each confirmed, with a toggle bit; bit c marks the last one";
        "toggle位错误(05030000h), 声明的长度与实际不符"
        "wrong toggle bit (05030000h), size differs from the indicated one";
    ["block transfer", "块传输", "sdo block transfer"] "CiA 301 7.2.4.3.9 to 7.2.4.3.16"
        "至多127段连续发送才确认一次, 可带CRC, 适合固件等大数据"
        "up to 127 segments between two confirmations, with a CRC if both sides support it; for large data such as firmware";
        "接收缓冲不足而丢段, blksize不符(05040002h), CRC不符(05040004h), 设备不支持(05040001h)"
        "segments lost for lack of buffers, invalid block size (05040002h), CRC error (05040004h), not supported by the device (05040001h)";
    ["abort code", "中止码", "sdo abort", "sdo中止"] "CiA 301 7.2.4.3.17"
        "任一方以80h和4字节代码结束SDO传输, 说明原因"
        "either side ends an SDO transfer with 80h and a 4-byte code that gives the reason";
        "被主站程序忽略; 05040000h是客户端超时, 不是服务器的拒绝"
        "ignored by the master's program; 05040000h is a client timeout, not a refusal by the server";
    ["object dictionary", "对象字典", "od"] "CiA 301 7.4"
        "节点的全部参数, 由16位索引和8位子索引寻址; 1000h起为通信, 2000h起为制造商, 6000h起为设备规范"
        "all parameters of a node, addressed by a 16-bit index and an 8-bit sub-index: communication from 1000h, manufacturer-specific from 2000h, device profile from 6000h";
        "EDS与固件版本不同; 写入后未存储(1010h)"
        "EDS of another firmware version; values written but not stored (1010h)";
    ["EDS", "电子数据文件", "electronic data sheet", "dcf", "设备配置文件"] "CiA 306"
        "文本文件, 列出设备的对象; DCF还含节点ID、波特率和要写入的值"
        "a text file that lists a device's objects; a DCF also has node-ID, bit rate and the values to be written";
        "与固件版本不符, 默认值写错, 缺少映射对象"
        "does not fit the firmware version, wrong defaults, mapped objects missing";
    ["EMCY", "紧急报文", "emergency", "1014h"] "CiA 301 7.2.7"
        "节点在错误发生和消失时发送080h+n: 错误码、错误寄存器、5字节制造商数据; 0000h为清除"
        "080h+n, sent when an error occurs and when it disappears: error code, error register, 5 bytes of manufacturer data; 0000h clears it";
        "有的设备在错误消失时不发0000h; 1014h位31=1时不发送; 多个错误时一个0000h只清除其中一个"
        "devices that never send 0000h; bit 31 of 1014h disables it; with several errors one 0000h clears only one of them";
    ["error code", "错误码", "emcy error code"] "CiA 301 7.2.7.1"
        "EMCY的前两个字节: 0000h清除, 1xxxh通用, 2xxxh电流, 3xxxh电压, 4xxxh温度, 5xxxh硬件, 6xxxh软件, 8xxxh监视(81xxh通信), FFxxh设备规定"
        "the first two bytes of an EMCY: 0000h clears, 1xxxh generic, 2xxxh current, 3xxxh voltage, 4xxxh temperature, 5xxxh hardware, 6xxxh software, 8xxxh monitoring (81xxh communication), FFxxh device-specific";
        "与SDO的中止码混淆; 字节顺序弄反(低字节在前)"
        "confused with an SDO abort code; byte order reversed (the low byte comes first)";
    ["error register", "错误寄存器", "1001h"] "CiA 301 7.5.2.2"
        "1001h, 8位: 0通用, 1电流, 2电压, 3温度, 4通信, 5设备规范, 7制造商"
        "1001h, 8 bits: 0 generic, 1 current, 2 voltage, 3 temperature, 4 communication, 5 device profile, 7 manufacturer";
        "不为0时有的节点拒绝进入操作状态"
        "some nodes refuse to become Operational while it is not 0";
    ["error behaviour", "错误行为", "error behavior", "1029h"] "CiA 301 7.5.2.32"
        "1029h:01: 通信错误时0进入预操作状态, 1不变, 2进入停止状态"
        "1029h:01: reaction to a communication error: 0 to Pre-operational, 1 no change, 2 to Stopped";
        "默认0: 失去一个被监视的节点就离开操作状态"
        "with the default 0 a node leaves Operational when a monitored node is lost";
    ["LSS", "层设置服务", "layer setting services"] "CiA 305"
        "用7E5h和7E4h设置节点ID和波特率; 从站由身份(1018h的4个值)选择或用快速扫描找到"
        "sets node-ID and bit rate by 7E5h and 7E4h; slaves are selected by their identity (the 4 values of 1018h) or found by Fastscan";
        "已有节点ID的从站不参加快速扫描; 设置后未存储; 需要复位通信才生效; 同时选中多个从站"
        "configured slaves do not take part in Fastscan; setting not stored; takes effect only after reset communication; several slaves selected at the same time";
    ["fastscan", "快速扫描", "lss fastscan"] "CiA 305"
        "主站逐位比较未配置从站的身份, 找到其中一个"
        "the master finds a slave without a node-ID by comparing its identity bit by bit";
        "已配置的从站不响应; 超时太短"
        "configured slaves do not respond; timeout too short";
    ["TIME", "时间报文", "time stamp", "time of day", "1012h"] "CiA 301 7.2.6"
        "100h, 6字节: 从0时起的毫秒数和从1984年1月1日起的天数"
        "100h, 6 bytes: milliseconds since midnight and days since 1 January 1984";
        "有两个生产者; 毫秒数超出一天"
        "two producers; milliseconds beyond one day";
    ["device profile", "设备规范", "profile"] "CiA 301 7.5.2.1"
        "一类设备共同的对象(6000h起)和行为, 如CiA 401(I/O)、CiA 402(驱动器); 1000h的低16位给出其编号"
        "the objects (from 6000h) and the behaviour that a class of devices shares, such as CiA 401 (I/O) or CiA 402 (drives); the low 16 bits of 1000h have its number";
        "1000h为0: 不遵循任何设备规范; 只实现了一部分对象"
        "1000h is 0: no profile is followed; only some of its objects are implemented";
    ["manufacturer", "制造商", "vendor", "vendor-id", "制造商id"] "CiA 301 7.5.2.21"
        "设备的生产者, 由1018h:01的制造商ID标识, 该ID由CiA分配; 2000h到5FFFh的对象由其定义"
        "who makes the device, known by the vendor-ID in 1018h:01, which CiA assigns; it defines the objects from 2000h to 5FFFh";
        "制造商ID为0; EDS是另一型号的"
        "a vendor-ID of 0; an EDS of another model";
    ["identity object", "标识对象", "身份对象", "identity", "1018h"] "CiA 301 7.5.2.21"
        "1018h: 制造商ID、产品码、修订号、序列号"
        "1018h: vendor-ID, product code, revision number, serial number";
        "与主站期望(1F85h到1F88h)不符而不启动"
        "differs from what the master expects (1F85h to 1F88h), so the node is not started";
    ["store parameters", "存储参数", "1010h", "save", "restore parameters", "恢复参数", "1011h"] "CiA 301 7.5.2.13, 7.5.2.14"
        "向1010h写“save”(65766173h)存储, 向1011h写“load”(64616F6Ch)后复位恢复默认值"
        "writing \"save\" (65766173h) to 1010h stores, \"load\" (64616F6Ch) to 1011h restores the defaults at the next reset";
        "存储期间节点可能不响应; 签名错误(08000020h); 每次启动都存储会磨损闪存"
        "the node may not respond while storing; wrong signature (08000020h); storing at every start wears out the flash";
    ["controlword", "控制字", "statusword", "状态字", "cia 402", "drive state", "驱动状态", "shutdown", "关闭(Shutdown)", "disable voltage", "断开电压(Disable voltage)", "6040h", "6041h"] "CiA 402-2, 6040h, 6041h"
        "驱动器状态机: 06h关闭(Shutdown), 07h接通, 0Fh使能运行, 位7上升沿为故障复位; 状态字显示当前状态"
        "the state machine of drives: 06h shutdown, 07h switch on, 0Fh enable operation, a rising edge of bit 7 resets a fault; the statusword shows the state";
        "命令顺序不对; 位7没有上升沿; 远程位(位9)为0; 主电源未接入(位4为0)"
        "wrong command order; no rising edge of bit 7; remote bit (bit 9) is 0; no voltage (bit 4 is 0)";
    ["bit rate", "波特率", "bit timing", "位定时"] "CiA 301 6.3, 6.4"
        "总线的传输速率, 所有节点相同, 10 kbit/s到1 Mbit/s; 位定时规定采样点, 建议为87.5%"
        "the speed of the bus, the same for all nodes, 10 kbit/s to 1 Mbit/s; the bit timing sets the sample point, 87.5% is recommended";
        "一个节点的波特率不同, 使总线充满错误帧; 采样点不同; 线缆对该波特率过长"
        "one node with another bit rate fills the bus with error frames; different sample points; cable too long for the bit rate";
    ["timestamp", "时间戳"] "-"
        "记录程序收到该帧的时间, 不是报文的内容; 周期和延迟都由它计算"
        "when the recording program received a frame, not part of its content; periods and delays are computed from it";
        "由软件而不是适配器打时间戳, 抖动可达数ms; 记录中没有时间戳"
        "stamped by software instead of the adapter, with a jitter of some milliseconds; a capture without timestamps";
    ["problem", "问题", "incident"] "-"
        "总线上发生的一件事, 如节点失去联系; 由若干检查结果和报文得出, 列出原因、后果和应先检查的位置"
        "something that happened on the bus, such as a silent node; drawn from findings and frames, with its cause, its consequences and what to check first";
        "把后果当成原因: 先处理没有原因的问题"
        "a consequence taken for the cause: start with problems that have no cause";
    ["finding", "检查结果"] "-"
        "某一帧违反规则或期望, 有代码(如SDO001)和严重程度"
        "a frame violates a rule or an expectation; it has a code (such as SDO001) and a severity";
        "记录不完整或没有时间戳时, 有些规则无法检查"
        "some rules cannot be checked on a capture that is cut or has no timestamps";
    ["bus-off", "总线关闭", "error passive", "错误被动", "被动错误", "error active", "错误主动"] "ISO 11898-1"
        "发送错误计数达到128为错误被动, 达到256为总线关闭: 控制器不再参与总线通信"
        "a controller is error passive at a transmit error count of 128 and bus-off at 256: it no longer takes part in bus traffic";
        "短路、接反、波特率不同; 总线上只有自己时因无ACK而进入错误被动"
        "short circuit, swapped wires, different bit rate; alone on the bus it becomes error passive without acknowledgement";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_belongs_to_one_term_and_every_term_is_found() {
        let mut names = std::collections::BTreeSet::new();
        for one in TERMS {
            assert!(one.names.len() >= 2 && !one.names.get(1).is_some_and(|name| name.is_ascii()), "{:?}", one.names);
            for name in one.names {
                assert!(names.insert(name.to_lowercase().replace('-', " ")), "{name}");
                let (mut zh, mut en) = (Vec::new(), Vec::new());
                if is_object(name) {
                    let index = u16::from_str_radix(name.trim_end_matches('h'), 16).unwrap_or_default();
                    of_object(&mut en, Lang::En, index);
                    assert!(!en.is_empty(), "{name}");
                    continue;
                }
                assert!(term(&mut zh, Lang::Zh, name) && term(&mut en, Lang::En, &name.to_uppercase()), "{name}");
                assert_ne!(zh, en);
            }
            for (zh, en) in [one.what, one.wrong] {
                assert!(en.chars().all(|one| one.is_ascii() || "Ωµ×".contains(one)), "{en}");
                assert!(!zh.is_ascii(), "{zh}");
            }
        }
    }

    #[test]
    fn what_is_no_term_is_none() {
        for text in ["", "foo", "sync foo", "-"] {
            assert!(!term(&mut Vec::new(), Lang::En, text), "{text}");
        }
    }
}
