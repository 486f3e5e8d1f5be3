//! What an incident of a kind usually comes from, what ends it, and on what it rests.
//!
//! One row a kind. Must not: say what one incident has come from; that is the diagnosis' matter.

use crate::diagnosis::kinds::Kind;
use crate::rules::Code;

/// A row.
pub(super) struct Row {
    pub(super) kind: Kind,
    /// The clause or practice; `-`: none.
    pub(super) clause: &'static str,
    /// What usually causes it, in Chinese and English.
    pub(super) cause: (&'static str, &'static str),
    /// What ends it.
    pub(super) ends: (&'static str, &'static str),
    /// Rules that show it beside those that are incidents by themselves.
    pub(super) codes: &'static [Code],
}

/// The row of a kind.
pub(super) fn of(kind: Kind) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.kind == kind)
}

macro_rules! rows {
    ($($kind:ident $clause:literal [$($code:ident),*] $cause_zh:literal $cause_en:literal; $ends_zh:literal $ends_en:literal;)*) => {
        static ROWS: &[Row] = &[$(Row {
            kind: Kind::$kind,
            clause: $clause,
            cause: ($cause_zh, $cause_en),
            ends: ($ends_zh, $ends_en),
            codes: &[$(Code::$code),*],
        },)*];
    };
}

rows! {
    BusOff "ISO 11898-1" [Bus006]
        "CAN_H与CAN_L短路或接反, 波特率不符, 缺少终端电阻, 记录用的适配器自身故障"
        "CAN_H and CAN_L shorted or swapped, a wrong bit rate, missing termination, a fault of the recording adapter";
        "控制器恢复并再次收到报文(restart-ms 或手动重启接口)"
        "the controller is restarted (restart-ms, or the interface manually) and receives frames again";
    ErrorPassive "ISO 11898-1" [Bus006]
        "终端电阻缺失或多余(断电时H与L间应为60 Ω), 支线过长, 接触不良, 干扰"
        "missing or excess termination (60 Ω between H and L with power off), long stubs, a bad contact, noise";
        "控制器恢复到错误主动状态"
        "the controller is error active again";
    NotAcknowledged "ISO 11898-1" []
        "总线上没有其他上电的节点, 插头未接好, 其他节点波特率不同或在bus-off"
        "no other powered node on the bus, a loose plug, other nodes at another bit rate or bus-off";
        "任何其他节点出现并应答"
        "any other node appears and acknowledges";
    BusErrors "ISO 11898-1" []
        "干扰、屏蔽或接地不良; 仅在驱动使能时出现则多为EMC"
        "noise, shield or ground; if it appears only with enabled drives it is mostly EMC";
        "不再出现错误帧"
        "no more error frames";
    TransceiverFault "ISO 11898-3" []
        "断线、对地或对电源短路、收发器损坏"
        "a broken wire, a short to ground or supply, a damaged transceiver";
        "控制器恢复正常"
        "the controller recovers";
    WrongBitRate "ISO 11898-1" []
        "记录用的接口或某个节点的波特率与总线不同"
        "the recording interface or a node uses another bit rate than the bus";
        "以正确的波特率重新记录"
        "a capture at the right bit rate";
    SegmentLost "CiA 301 7.2.8.3.2.2" [Hbt002]
        "一段电缆、接插件或一组节点的公共电源中断"
        "a cable segment, a connector or the common supply of a group of nodes is interrupted";
        "这些节点再次发送报文; 有启动报文说明是电源, 没有则是电缆"
        "the nodes come back: boot-ups mean the supply, none means the cable";
    BusSilent "-" []
        "总电源中断, 总线断开, 记录程序停顿"
        "main supply lost, bus disconnected, or the recording paused";
        "再次收到报文"
        "frames are received again";
    NotCanopen "-" []
        "记录的是另一种协议(J1939、设备自有协议)的总线"
        "the recorded bus uses another protocol (J1939, a proprietary one)";
        "不会结束: 选择正确的接口"
        "does not end: choose the right interface";
    CaptureGap "-" []
        "记录的主机过载, 适配器丢帧, 文件损坏或被拼接"
        "recording host overloaded, frames dropped by the adapter, file damaged or joined";
        "记录继续"
        "recording continues";
    Overload "-" []
        "PDO周期太短, 抑制时间为0的事件型PDO, 重复启动, 波特率太低"
        "PDO periods that are too short, event-driven PDOs without inhibit time, repeated starts, a low bit rate";
        "总线负载降到限值以下"
        "the bus load falls below the limit";
    Flood "CiA 301 7.5.2.37" []
        "抑制时间(180xh:03)为0, 事件型PDO映射了变化很快的值, 固件错误"
        "inhibit time (180xh:03) is 0, an event-driven PDO maps a fast-changing value, a firmware bug";
        "发送频率回落"
        "the rate returns to normal";
    BitTiming "CiA 305" []
        "主站用LSS切换波特率"
        "the master switches the bit rate by LSS";
        "切换延迟结束"
        "the switch delay is over";
    Scan "CiA 301 7.2.4.1" []
        "主站或工具逐个访问节点ID, 未安装的节点不响应"
        "the master or a tool requests one node-ID after the other; nodes that are not installed do not respond";
        "扫描停止"
        "the scan ends";
    NodeAbsent "CiA 301 7.2.4.1" []
        "节点未上电、未接线, 节点ID或波特率与主站配置不符"
        "the node has no power or no connection, or another node-ID or bit rate than the master expects";
        "收到该节点的第一帧"
        "the first frame of the node";
    NodeSilent "CiA 301 7.2.8.3.2.2" [Hbt002]
        "断电、接插件松动、节点固件停止、节点进入bus-off"
        "power loss, a loose connector, stopped firmware, a node in bus-off";
        "再次收到该节点的报文: 有启动报文说明它断电或复位过"
        "the node is heard again; a boot-up shows a power loss or reset";
    HeartbeatStopped "CiA 301 7.2.8.3.2.2" [Hbt002]
        "1017h被写为0, 或固件的心跳任务停止"
        "1017h was written to 0, or the firmware's heartbeat task has stopped";
        "心跳恢复"
        "heartbeats resume";
    NodeRestarted "CiA 301 7.3.2.1" [Nmt003]
        "供电跌落, 看门狗, 固件错误, 本地复位按钮"
        "a supply dip, a watchdog, a firmware bug, a local reset";
        "重新配置并再次进入操作状态"
        "it is configured and Operational again";
    RestartLoop "CiA 301 7.3.2.1" [Nmt003]
        "看门狗(间隔均匀)、供电不足(随负载出现)、固件在启动后崩溃"
        "a watchdog (regular intervals), a weak supply (under load), firmware that crashes after start";
        "节点保持运行"
        "the node stays up";
    NoBootUp "CiA 301 7.3.2.1" [Nmt006]
        "复位后固件没有启动, 节点停在bootloader, 节点ID或波特率改变"
        "the firmware does not start after a reset, the node stays in its bootloader, changed node-ID or bit rate";
        "收到启动报文"
        "a boot-up";
    NotStarted "CiA 302-2" []
        "主站的启动列表(1F80h、1F81h)里没有该节点, 或配置检查失败"
        "the node is not in the master's boot list (1F80h, 1F81h), or a check of its configuration failed";
        "NMT启动命令并进入操作状态"
        "an NMT start that takes it to Operational";
    BootStuck "CiA 302-2" []
        "身份不符(1F84h-1F88h), 启动超时, 心跳未配置, 某个SDO始终失败"
        "identity mismatch (1F84h to 1F88h), boot timeout, no heartbeat configured, an SDO that always fails";
        "节点被启动"
        "the node is started";
    TwoMasters "CiA 301 7.2.8" []
        "调试工具仍在线, 两个控制器都被配置为主站"
        "a tool is still connected, two controllers are both set up as masters";
        "其中一个停止发送命令"
        "one of them stops sending commands";
    LeftOperational "CiA 301 7.5.2.32" [Nmt004, Nmt005]
        "通信错误后按1029h离开操作状态(心跳消费者、节点保护、RPDO超时、bus-off), 或本地故障"
        "by 1029h after a communication error (heartbeat consumer, life guarding, RPDO timeout, bus-off), or a local fault";
        "再次进入操作状态"
        "it is Operational again";
    StartWithoutEffect "CiA 301 7.2.8.3.1" [Nmt002]
        "错误寄存器不为0, 1029h或固件不允许, 两个NMT命令相隔太近被丢失"
        "error register not 0, refused by 1029h or the firmware, one of two NMT commands in quick succession lost";
        "节点报告所命令的状态"
        "the node reports the commanded state";
    CommandedReset "CiA 301 7.2.8.3.1" []
        "主站或工具发出复位命令"
        "the master or a tool has commanded a reset";
        "启动报文, 并再次启动"
        "a boot-up, and the next start";
    CommandedStop "CiA 301 7.2.8.3.1" []
        "主站或工具命令进入停止或预操作状态"
        "the master or a tool has commanded Stopped or Pre-operational";
        "NMT启动命令"
        "an NMT start";
    HeartbeatConsumerError "CiA 301 7.2.8.3.2.2, 7.5.2.19" [Emc008]
        "被监视的节点(1016h)停止心跳, 被复位, 或消费者心跳时间太短"
        "a monitored node (1016h) stopped its heartbeat or was reset, or the consumer heartbeat time is too short";
        "EMCY 0000h且错误寄存器位4清零"
        "EMCY 0000h with bit 4 of the error register cleared";
    GuardingUnanswered "CiA 301 7.2.8.3.2.1" []
        "节点不在线, 不支持远程帧, 节点保护COB-ID不符"
        "the node is offline, does not support remote frames, or uses another COB-ID for guarding";
        "节点应答"
        "the node responds";
    GuardingStopped "CiA 301 7.2.8.3.2.1" [Emc008]
        "主站停止或过载, 主站程序被中断(断点)"
        "the master stopped, is overloaded, or its program was halted (breakpoint)";
        "节点保护请求恢复"
        "node guarding requests resume";
    GuardingAndHeartbeat "CiA 301 7.2.8.3.2" []
        "100Ch、100Dh与1017h同时不为0"
        "both 100Ch/100Dh and 1017h are not 0";
        "改为只用其中一种"
        "only one of them is used";
    DuplicateNodeId "CiA 301 7.3.5" []
        "拨码开关或LSS设置相同, 更换设备后未改节点ID"
        "same DIP switch or LSS setting, a replacement device with an unchanged node-ID";
        "其中一个改用另一个节点ID"
        "one of them is given another node-ID";
    HeartbeatIrregular "CiA 301 7.2.8.3.2.2" []
        "节点忙(写闪存), 总线负载高, 1017h被改写"
        "the node is busy (writing flash), high bus load, 1017h was written";
        "心跳恢复均匀"
        "heartbeats are regular again";
    ConsumerTimeTooShort "CiA 301 7.5.2.19, 7.5.2.20" [Emc008]
        "1016h的时间没有按生产者的1017h设置, 应至少为其1.5倍"
        "1016h does not match the producer's 1017h; it should be at least 1.5 times that";
        "改正1016h或1017h"
        "1016h or 1017h is corrected";
    WatchedAbsent "CiA 301 7.5.2.19" [Emc008]
        "1016h里还有不再安装的节点"
        "1016h still lists nodes that are no longer installed";
        "节点出现或删除该条目"
        "the node appears or the entry is removed";

    RequestUnanswered "CiA 301 7.2.4.1" [Sdo018]
        "节点忙(1010h、擦除闪存), 处于停止状态, 已离线, 或请求发到错误的COB-ID"
        "the node is busy (1010h, erasing flash), Stopped or offline, or the request was sent to a wrong COB-ID";
        "服务器响应"
        "the server responds";
    LateAnswer "CiA 301 7.2.4.1" []
        "客户端超时设置短于服务器处理时间, 总线负载高"
        "client timeout shorter than the server's processing time, high bus load";
        "响应及时到达"
        "responses arrive in time";
    ObjectRefused "CiA 301 7.2.4.3.17" [Sdo018]
        "EDS属于另一固件版本, 可选对象未实现"
        "EDS of another firmware version, optional object not implemented";
        "同一对象写入成功"
        "the same object is written successfully";
    AccessRefused "CiA 301 7.2.4.3.17" [Sdo018]
        "写只读或常量对象, 映射被设为固定"
        "write to a read-only or constant object, fixed mapping";
        "同一对象写入成功"
        "the same object is written successfully";
    LengthRefused "CiA 301 7.2.4.3.17" [Sdo018]
        "主站里的数据长度与对象类型不符"
        "the data length in the master does not match the object's type";
        "以正确的长度写入成功"
        "it is written with the correct length";
    ValueRefused "CiA 301 7.2.4.3.17" [Sdo018]
        "数值超出设备的上下限"
        "value outside the limits of the device";
        "写入允许的数值"
        "an allowed value is written";
    StateRefused "CiA 301 7.2.4.3.17" [Sdo018]
        "对象只能在预操作状态、驱动未使能或本地控制关闭时写入"
        "the object can only be written in Pre-operational, with the drive disabled or local control off";
        "在允许的状态下写入成功"
        "it is written in a state that allows it";
    MappingRefused "CiA 301 7.5.2.36, 7.5.2.38" [Sdo018]
        "顺序不对: 应先使PDO无效(位31), 再将:00写0, 写入条目, 写:00=n, 最后使其有效; 或对象不可映射"
        "wrong order: make the PDO invalid (bit 31), write :00 = 0, the entries, :00 = n, then make it valid; or the object cannot be mapped";
        "整个映射按正确顺序写入成功"
        "the whole mapping is written in the correct order";
    WriteRefused "CiA 301 7.2.4.3.17" [Sdo018]
        "见中止码"
        "see the abort code";
        "同一对象写入成功"
        "the same object is written successfully";
    HalfConfigured "CiA 302-2" [Sdo018]
        "主站忽略SDO错误, 配置中断后仍启动节点"
        "the master ignores SDO errors and starts the node anyway";
        "缺少的写入补做成功, 或重新配置"
        "the missing writes succeed, or the node is configured again";
    StoreFailed "CiA 301 7.5.2.13, 7.5.2.14" []
        "签名(\"save\"、\"load\")错误, 闪存故障, 设备状态不允许"
        "wrong signature (\"save\", \"load\"), flash fault, device state does not allow it";
        "再次写入成功"
        "the write succeeds";
    ProgramFailed "CiA 302-3" []
        "擦除时间超过SDO超时, 固件文件与设备不符, 下载中断"
        "erasing takes longer than the SDO timeout, firmware file for another device, interrupted download";
        "下载完整成功"
        "a complete download succeeds";
    Storing "CiA 301 7.5.2.13" []
        "主站命令存储参数或写入程序, 期间节点可能短时无响应"
        "commanded by the master; the node may not respond for a short time";
        "节点响应"
        "the node responds";
    DamagedTransfer "CiA 301 7.2.4.3" []
        "丢帧, 总线负载高, 两个客户端, 协议栈错误"
        "lost frames, high bus load, two clients, a stack bug";
        "同一节点的传输成功"
        "a transfer of the node succeeds";
    TwoClients "CiA 301 7.2.4.1" []
        "调试工具与主站同时使用默认SDO通道"
        "a tool and the master use the default SDO channel at the same time";
        "只剩一个客户端"
        "only one client remains";
    IdentityMismatch "CiA 306, CiA 301 7.5.2.21" []
        "设备被替换为另一型号或固件, 用错EDS或DCF"
        "device replaced by another type or firmware, wrong EDS or DCF";
        "使用相符的设备描述或设备"
        "a matching description or device is used";

    PdoLength "CiA 301 7.5.2.36, 7.5.2.38" [Emc008]
        "生产者与消费者的映射不同, 重启后映射丢失, 主站用固定长度发送"
        "producer and consumer mappings differ, mapping lost at a restart, master sends a fixed length";
        "长度再次与映射一致"
        "the length matches the mapping again";
    PdoMissing "CiA 301 7.5.2.37" []
        "PDO被禁用, 传输类型或事件定时器改变, 节点离开操作状态, 固件错误"
        "PDO disabled, transmission type or event timer changed, node left Operational, firmware bug";
        "PDO再次出现"
        "the PDO is sent again";
    RpdoTimeout "CiA 301 7.5.2.35" [Emc008]
        "发送该PDO的节点停止、离开操作状态或被复位; 时限(140xh:05)太短"
        "the sender of this PDO stopped, left Operational or was reset; deadline (140xh:05) too short";
        "EMCY 0000h; 部分协议栈在PDO恢复后也不清除"
        "EMCY 0000h; some stacks keep the error even after the PDO is back";
    SharedCobId "CiA 301 7.3.5" [Emc008]
        "COB-ID被改写到另一节点的标识符"
        "a COB-ID was changed to another node's identifier";
        "改正COB-ID"
        "the COB-ID is corrected";
    PdoNotAllowed "CiA 301 7.3.2.2, 7.5.2.37" []
        "固件在非操作状态也发送, 或忽略COB-ID的位31"
        "firmware sends outside Operational or ignores bit 31 of the COB-ID";
        "不再出现"
        "no longer occurs";
    PdoConfiguration "CiA 301 7.5.2.35 to 7.5.2.38" []
        "在PDO有效时改写, 使用保留的传输类型或受限的COB-ID, 映射超过8字节"
        "changed while the PDO was valid, reserved transmission type, restricted COB-ID, mapping longer than 8 bytes";
        "改正配置"
        "the configuration is corrected";
    InhibitTime "CiA 301 7.5.2.37" []
        "固件没有实现抑制时间, 单位是100 µs而被当作1 ms"
        "inhibit time not implemented, or its unit of 100 µs taken for 1 ms";
        "间隔不再短于抑制时间"
        "intervals no longer shorter than the inhibit time";
    PdoMultiplied "-" []
        "重复的NMT启动使协议栈重复建立定时器"
        "the stack creates its timers again with each repeated NMT start";
        "频率恢复"
        "the rate returns to normal";
    CommandsNotTaken "CiA 301 7.3.2.2" []
        "节点未被启动或自行离开操作状态, 而主站继续发送"
        "the node was not started, or left Operational, but the master keeps sending";
        "节点进入操作状态"
        "the node is Operational";
    SyncStopped "CiA 301 7.2.5, 7.5.2.5, 7.5.2.6" []
        "SYNC生产者(1005h位30)停止、被复位或离线"
        "the SYNC producer (1005h bit 30) stopped, was reset or is offline";
        "SYNC再次出现"
        "SYNC is sent again";
    SyncIrregular "CiA 301 7.2.5, 7.5.2.6, 7.5.2.7" []
        "主站实时性不足, 总线负载高, 同步窗口(1007h)太短"
        "insufficient real-time behaviour of the master, high bus load, synchronous window (1007h) too short";
        "周期恢复稳定"
        "the period is stable again";
    TwoSyncProducers "CiA 301 7.2.5" []
        "两个节点的1005h位30都置1"
        "bit 30 of 1005h is set in two nodes";
        "只剩一个生产者"
        "only one producer remains";
    SyncLength "CiA 301 7.5.2.22" [Emc008]
        "生产者与消费者的1019h(同步计数器溢出值)不同"
        "1019h (synchronous counter overflow value) differs between producer and consumers";
        "1019h一致"
        "1019h is the same everywhere";

    AxisFault "CiA 402-2" [Drv005, Emc008, Drv003]
        "见EMCY和603Fh的错误码; 多轴同时且无EMCY多为STO、急停或供电; 也可能是通信丢失的反应(6007h)"
        "see the error code in the EMCY and 603Fh; several axes at the same time without EMCY: mostly STO, emergency stop or supply; may also be the reaction to lost communication (6007h)";
        "原因消除, 控制字位7上升沿, 随后06h 07h 0Fh"
        "cause removed, rising edge of bit 7 of the controlword, then 06h 07h 0Fh";
    FaultResetWithoutEffect "CiA 402-2" [Drv002]
        "故障的原因仍存在"
        "the cause of the fault is still present";
        "离开故障状态"
        "the drive leaves the fault state";
    NotEnabled "CiA 402-2" [Drv002]
        "STO断开, 直流母线未充电(状态字位4), 命令顺序不对, 远程位(位9)为0, 节点不在操作状态"
        "STO open, DC link not charged (statusword bit 4), wrong command order, remote bit (bit 9) is 0, node not Operational";
        "状态字显示所命令的状态"
        "the statusword shows the commanded state";
    QuickStop "CiA 402-2" []
        "控制字位2被清零, 限位开关, 605Ah的反应"
        "controlword bit 2 cleared, limit switch, reaction by 605Ah";
        "重新使能"
        "enabled again";
    StateLeft "CiA 402-2" []
        "硬件使能被断开, STO, 驱动自身保护"
        "hardware enable opened, STO, internal protection of the drive";
        "重新使能"
        "enabled again";
    IllegalTransition "CiA 402-2" [Drv001]
        "驱动器固件的状态机, 另有主站或面板在控制, 控制字未录到"
        "state machine of the drive's firmware, another master or a panel in control, a controlword missing from the capture";
        "每次单独判断"
        "each occurrence is judged separately";
    ModeNotTaken "CiA 402-2, 6060h, 6061h" [Drv004]
        "6502h不支持该模式, 只能在未使能时切换, 6060h没有映射"
        "mode not supported (6502h), can only be changed while disabled, 6060h not mapped";
        "6061h显示请求的模式"
        "6061h shows the requested mode";
    FaultResetWithoutEdge "CiA 402-2" []
        "位7一直保持为1, 或0与1相隔太短被漏掉"
        "bit 7 held at 1, or 0 and 1 too close together to be noticed";
        "位7先0后1"
        "bit 7 first 0, then 1";
    FollowingError "CiA 402-2, 6065h" []
        "机械阻力, 增益或加速度不合适, 目标值跳变, 同步不稳"
        "mechanical resistance, unsuitable gains or acceleration, jumps in the target, unsteady SYNC";
        "位13清零"
        "bit 13 is cleared";
    InternalLimit "CiA 402-2" []
        "软限位、转矩或速度限值生效"
        "software limit, torque or speed limit active";
        "位11清零"
        "bit 11 is cleared";
    SetPointIgnored "CiA 402-2, 6040h" []
        "位4没有上升沿, 模式不是轮廓位置, 轴未使能"
        "no rising edge of bit 4, mode is not profile position, axis not enabled";
        "状态字位12跟随"
        "bit 12 of the statusword follows";
    HomingFailed "CiA 402-2, 6098h" []
        "原点开关未触发, 回零方式不支持, 轴未使能或碰到限位"
        "home switch not reached, unsupported method, axis not enabled or at a limit switch";
        "位13清零, 位12置1"
        "bit 13 cleared, bit 12 set";
    TargetsLate "CiA 402-2, 60C2h" []
        "主站周期不稳, 60C2h与1006h不同, 总线负载高"
        "unsteady master cycle, 60C2h differs from 1006h, high bus load";
        "目标值再次按周期到达"
        "target values arrive every cycle again";

    CommunicationError "CiA 301 7.2.7.1" [Emc008]
        "被监视的节点、SYNC或PDO不再到来; 总线错误"
        "a monitored node, SYNC or a PDO is missing; bus errors";
        "EMCY 0000h或节点重启"
        "EMCY 0000h or node restart";
    Overrun "CiA 301 7.2.7.1 (8110h)" [Emc008]
        "节点处理太慢, 发送队列无法发出(无ACK), 总线负载高"
        "node too slow, transmit queue not emptied (no acknowledgement), high bus load";
        "EMCY 0000h或节点重启"
        "EMCY 0000h or node restart";
    BusTrouble "CiA 301 7.2.7.1 (8120h, 8140h)" [Emc008]
        "布线、终端电阻、波特率; 8140h表示刚从bus-off恢复"
        "wiring, termination, bit rate; 8140h means just recovered from bus-off";
        "EMCY 0000h或节点重启"
        "EMCY 0000h or node restart";
    DeviceError "CiA 301 7.2.7.1" [Emc007, Emc008, Emc009]
        "设备自身: 在手册中查错误码和制造商数据"
        "the device itself: look up error code and manufacturer data in its manual";
        "EMCY 0000h或节点重启"
        "EMCY 0000h or node restart";
    SupplyVoltage "CiA 301 7.2.7.1 (3xxxh)" [Emc007, Emc008]
        "供电或直流母线过低或过高: 电源容量、同时使能、制动电阻"
        "supply or DC link too low or too high: supply capacity, axes enabled at the same time, brake resistor";
        "EMCY 0000h"
        "EMCY 0000h";
    Temperature "CiA 301 7.2.7.1 (4xxxh)" [Emc007, Emc008]
        "冷却不足, 负载过大, 环境温度高, 传感器断线"
        "insufficient cooling, overload, high ambient temperature, broken sensor";
        "EMCY 0000h"
        "EMCY 0000h";
    ModuleFailed "CiA 301 7.2.7.1 (5xxxh, 7xxxh)" [Emc007, Emc008]
        "模块松动、内部总线或现场供电中断"
        "loose module, internal bus or field supply interrupted";
        "EMCY 0000h"
        "EMCY 0000h";
    RegisterWithoutEmcy "CiA 301 7.5.2.2, 7.5.2.17" []
        "1014h位31=1(EMCY关闭), 或错误在记录开始之前已存在"
        "1014h bit 31 = 1 (EMCY disabled), or the error existed before the capture began";
        "1001h读出0"
        "1001h reads 0";
    EmcyFlood "CiA 301 7.2.7.1, 7.5.2.18" []
        "数值在阈值附近抖动, 接触不良, 1015h(抑制时间)为0"
        "a value around its threshold, a bad contact, inhibit time (1015h) is 0";
        "不再频繁出现"
        "no longer frequent";

    LssUnanswered "CiA 305" [Lss012]
        "没有未配置的从站, 波特率不同, 从站不支持该命令"
        "no unconfigured slave, different bit rate, command not supported by the slave";
        "从站响应"
        "a slave responds";
    LssRefused "CiA 305" []
        "节点ID或波特率不在支持范围, 存储失败, 同时选中多个从站"
        "unsupported node-ID or bit rate, storing failed, several slaves selected at the same time";
        "命令成功"
        "the command succeeds";
    TimeJump "CiA 301 7.2.6" []
        "时间生产者校时, 或有两个生产者"
        "the producer's clock was set, or there are two producers";
        "时间恢复连续"
        "time is continuous again";
    SrdoInvalid "CiA 304, EN 50325-5" []
        "两帧不互为取反, 超过SRVT或SCT, 生产者离线, 总线负载高"
        "the two frames are not inverse, SRVT or SCT exceeded, producer offline, high bus load";
        "有效的SRDO对再次出现; 安全状态可能需要确认"
        "valid SRDO pairs again; the safe state may need an acknowledgement";
    WireError "CiA 301" []
        "固件或协议栈错误, 其他协议使用同一标识符"
        "firmware or stack bug, another protocol on the same identifier";
        "不再出现"
        "no longer occurs";
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::kinds::KINDS;

    #[test]
    fn every_kind_has_one_row_in_both_languages() {
        for row in KINDS {
            assert_eq!(ROWS.iter().filter(|one| one.kind == row.kind).count(), 1, "{}", row.name);
        }
        for one in ROWS {
            for (zh, en) in [one.cause, one.ends] {
                assert!(!zh.is_empty() && !en.is_empty() && zh != en || zh == "EMCY 0000h", "{:?}", one.kind);
                assert!(en.is_ascii() || en.contains(['Ω', 'µ']), "{en}");
            }
            assert!(!one.clause.is_empty());
        }
    }
}
