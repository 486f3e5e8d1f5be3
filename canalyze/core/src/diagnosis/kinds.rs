//! The kinds of incident: all that is known of a kind stands in its row.
//!
//! A kind has a name for machines, an impact, and the clause or practice it rests on. Must not: judge, or hold a sentence
//! that is filled (those are in `sayings`).

use crate::rules::Words;

/// What an incident means for the machine, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Impact {
    /// Something has stopped.
    A,
    /// Something does not start.
    B,
    /// Something works worse than it should.
    C,
    /// Something is wrong on the wire, and nothing else shows it.
    D,
    /// Worth knowing.
    E,
}

impl Impact {
    /// The letter in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
            Self::D => "D",
            Self::E => "E",
        }
    }
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The kind.
    pub kind: Kind,
    /// In kebab-case, as machine output has it.
    pub name: &'static str,
    /// What it means for the machine.
    pub impact: Impact,
    /// What it is, without any figure.
    pub words: Words,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident $name:literal $impact:ident $zh:literal $en:literal;)*) => {
        /// What went wrong.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Kind {
            $(#[doc = $en] $kind,)*
        }

        /// All kinds.
        pub const KINDS: &[Row] = &[
            $(Row { kind: Kind::$kind, name: $name, impact: Impact::$impact, words: Words { zh: $zh, en: $en } },)*
        ];

        impl Kind {
            /// The row of the kind.
            pub fn row(self) -> &'static Row {
                match self {
                    $(Self::$kind => &const {
                        Row { kind: Kind::$kind, name: $name, impact: Impact::$impact, words: Words { zh: $zh, en: $en } }
                    },)*
                }
            }
        }
    };
}

kinds! {
    BusOff "bus-off" A "总线关闭(bus off)" "bus-off";
    ErrorPassive "error-passive" C "控制器处于被动错误状态或达到警告界限" "a controller error passive or at its warning level";
    NotAcknowledged "not-acknowledged" B "发出的帧没有节点应答" "frames that nobody acknowledges";
    BusErrors "bus-errors" C "错误帧" "error frames";
    TransceiverFault "transceiver-fault" A "收发器或线路故障" "a fault of the transceiver or the line";
    WrongBitRate "wrong-bit-rate" B "只有错误帧: 波特率可能不符" "nothing but error frames: the bit rate may be wrong";
    SegmentLost "segment-lost" A "几个节点同时失去联系" "several nodes silent at once";
    BusSilent "bus-silent" A "整个总线静默" "the whole bus silent";
    NotCanopen "not-canopen" E "不是CANopen的报文" "traffic that is not CANopen";
    CaptureGap "capture-gap" E "记录有缺口" "a gap of the recording";
    Overload "overload" C "总线过载" "the bus overloaded";
    Flood "node-floods" C "一个COB-ID的报文激增" "one COB-ID floods the bus";
    BitTiming "bit-timing-activated" E "按LSS命令切换波特率" "the bit rate switched by LSS";

    NodeAbsent "node-absent" B "节点不存在" "a node is absent";
    Scan "scan" E "扫描节点ID" "a scan for node-IDs";
    NodeSilent "node-silent" A "节点失去联系" "a node is silent";
    HeartbeatStopped "heartbeat-stopped" C "心跳停止, 节点仍在发送其他报文" "heartbeats stopped while the node goes on";
    NodeRestarted "node-restarted" A "节点自行重启" "a node restarted by itself";
    RestartLoop "restart-loop" A "节点反复重启" "a node restarts again and again";
    NoBootUp "no-boot-up" B "复位后没有启动报文" "no boot-up after a reset";
    NotStarted "not-started" B "节点没有被主站启动" "a node that the master never started";
    BootStuck "boot-stuck" B "主站的启动过程停滞" "a boot that is stuck";
    TwoMasters "two-masters" A "NMT命令相互矛盾" "NMT commands that contradict each other";
    LeftOperational "left-operational" A "节点自行离开操作状态" "a node left Operational by itself";
    StartWithoutEffect "start-without-effect" B "NMT命令没有效果" "an NMT command without effect";
    CommandedReset "commanded-reset" E "按命令复位" "reset by command";
    CommandedStop "commanded-stop" E "按命令离开操作状态" "stopped by command";
    HeartbeatConsumerError "heartbeat-consumer-error" A "心跳消费者报告对方丢失" "a heartbeat consumer reports a loss";
    GuardingUnanswered "guarding-unanswered" A "节点保护请求没有应答" "guarding requests unanswered";
    GuardingStopped "guarding-stopped" A "主站停止节点保护" "guarding stopped by the master";
    GuardingAndHeartbeat "guarding-and-heartbeat" D "同时使用节点保护和心跳" "guarding and heartbeat at once";
    DuplicateNodeId "duplicate-node-id" A "节点ID重复" "two nodes with one node-ID";
    HeartbeatIrregular "heartbeat-irregular" C "心跳不均匀" "irregular heartbeats";
    ConsumerTimeTooShort "consumer-time-too-short" B "心跳消费者时间短于对方的心跳周期" "a consumer heartbeat time shorter than the producer's period";
    WatchedAbsent "watched-node-absent" C "被监视的节点从未出现" "a watched node that was never there";

    RequestUnanswered "request-unanswered" B "SDO请求没有响应" "SDO requests unanswered";
    LateAnswer "late-answer" C "SDO响应太迟" "an SDO response too late";
    ObjectRefused "object-refused" B "写入的对象不存在" "a write to an object that does not exist";
    AccessRefused "access-refused" B "写入被拒绝: 访问权限" "a write refused by access";
    LengthRefused "length-refused" B "写入被拒绝: 长度或类型" "a write refused by its length";
    ValueRefused "value-refused" B "写入被拒绝: 数值" "a write refused by its value";
    StateRefused "state-refused" B "写入被拒绝: 设备状态" "a write refused by the state of the device";
    MappingRefused "mapping-refused" B "PDO配置被拒绝" "a PDO configuration refused";
    WriteRefused "write-refused" B "写入被拒绝" "a write refused";
    HalfConfigured "half-configured" B "配置未完成就被启动" "started though its configuration is not complete";
    StoreFailed "store-failed" C "存储或恢复参数失败" "storing or restoring parameters failed";
    ProgramFailed "program-download-failed" B "程序下载失败" "a program download failed";
    Storing "storing" E "存储参数或写入程序" "parameters or a program being stored";
    DamagedTransfer "damaged-transfer" B "SDO传输违反协议" "an SDO transfer against the protocol";
    TwoClients "two-clients" D "一个SDO通道上有两个客户端" "two clients on one SDO channel";
    IdentityMismatch "identity-mismatch" B "设备身份与描述不符" "another device than described";

    PdoLength "pdo-length" B "PDO长度与映射不符" "a PDO of another length than its mapping";
    PdoMissing "pdo-missing" A "PDO中断, 节点仍在" "a PDO missing though the node is there";
    RpdoTimeout "rpdo-timeout" A "RPDO超时" "an RPDO timeout";
    SharedCobId "shared-cob-id" A "两个发送者使用同一个COB-ID" "two producers of one COB-ID";
    PdoNotAllowed "pdo-not-allowed" D "不该出现的PDO" "PDOs that should not be sent";
    PdoConfiguration "pdo-configuration" D "PDO配置有误" "a PDO configured wrongly";
    InhibitTime "inhibit-time" C "短于禁止时间" "sent within the inhibit time";
    PdoMultiplied "pdo-multiplied" C "重复启动后PDO成倍发送" "a PDO sent several times as often after a repeated start";
    CommandsNotTaken "commands-not-taken" B "向未处于操作状态的节点发送RPDO" "RPDOs to a node that is not Operational";
    SyncStopped "sync-stopped" A "SYNC停止" "SYNC stopped";
    SyncIrregular "sync-irregular" C "SYNC或同步PDO不合时序" "SYNC or synchronous PDOs out of time";
    TwoSyncProducers "two-sync-producers" A "两个SYNC生产者" "two SYNC producers";
    SyncLength "sync-length" D "SYNC长度不符" "a SYNC of another length";

    AxisFault "axis-fault" A "驱动故障" "an axis in fault";
    FaultResetWithoutEffect "fault-reset-without-effect" A "故障复位没有效果" "a fault reset without effect";
    NotEnabled "not-enabled" B "驱动命令没有效果" "a drive command without effect";
    QuickStop "quick-stop" A "快速停止" "a quick stop";
    StateLeft "state-left" A "驱动未经命令离开运行使能" "a drive left operation enabled without a command";
    IllegalTransition "illegal-transition" D "状态跳变没有命令依据" "a state of a drive that no command led to";
    ModeNotTaken "mode-not-taken" B "运行模式未被采纳" "a mode of operation not taken";
    FaultResetWithoutEdge "fault-reset-without-edge" B "故障复位没有上升沿" "a fault reset without a rising edge";
    FollowingError "following-error" A "跟随误差" "a following error";
    InternalLimit "internal-limit" C "内部限制生效" "an internal limit active";
    SetPointIgnored "set-point-not-acknowledged" B "新设定点没有应答" "a set-point not acknowledged";
    HomingFailed "homing-failed" B "回零失败" "homing failed";
    TargetsLate "targets-late" C "目标值没有按周期到达" "targets that come late";

    CommunicationError "communication-error" A "节点报告通信错误" "a node reports a communication error";
    Overrun "overrun" C "节点报告CAN溢出" "a node reports an overrun";
    BusTrouble "bus-trouble" C "节点报告总线错误" "a node reports bus errors";
    DeviceError "device-error" C "设备报告错误" "a device reports an error";
    SupplyVoltage "supply-voltage" A "设备报告供电电压错误" "a device reports its supply voltage";
    Temperature "temperature" C "设备报告温度过高" "a device reports its temperature";
    ModuleFailed "module-failed" A "I/O模块故障" "a module of an I/O device failed";
    RegisterWithoutEmcy "register-without-emcy" C "错误寄存器不为0, 而没有紧急报文" "an error register that is not 0, and no EMCY";
    EmcyFlood "emcy-flood" C "大量紧急报文" "a flood of emergencies";

    LssUnanswered "lss-unanswered" B "LSS没有应答" "LSS unanswered";
    LssRefused "lss-refused" B "LSS命令被拒绝" "LSS refused";
    TimeJump "time-jump" C "TIME跳变" "TIME jumps";
    SrdoInvalid "srdo-invalid" A "SRDO无效" "an SRDO invalid";
    WireError "wire-error" D "报文违反协议" "frames against the protocol";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_a_name_of_its_own() {
        for (place, row) in KINDS.iter().enumerate() {
            assert_eq!(row.kind.row().name, row.name);
            assert!(KINDS.iter().skip(place + 1).all(|other| other.name != row.name), "{}", row.name);
            assert!(row.name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-'), "{}", row.name);
        }
    }
}
