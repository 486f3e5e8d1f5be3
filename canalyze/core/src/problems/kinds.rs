//! The kinds of problems; each row holds everything about its kind.
//!
//! A kind has a name for machines, an impact, and its words. Sentences with figures are in `sayings`.

use crate::rules::Words;

/// The effect of a problem on the machine, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Impact {
    /// Something stopped.
    A,
    /// Something does not start.
    B,
    /// Something works worse than it should.
    C,
    /// Something is wrong on the wire without a visible effect.
    D,
    /// Worth knowing.
    E,
}

impl Impact {
    /// Returns the letter used in machine output.
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
pub struct KindRow {
    /// The kind.
    pub kind: ProblemKind,
    /// The name in machine output, in kebab-case.
    pub name: &'static str,
    /// The effect on the machine.
    pub impact: Impact,
    /// The description, without figures.
    pub words: Words,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident $name:literal $impact:ident $zh:literal $en:literal;)*) => {
        /// The kind of a problem.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum ProblemKind {
            $(#[doc = $en] $kind,)*
        }

        /// All kinds.
        pub const KINDS: &[KindRow] = &[
            $(KindRow { kind: ProblemKind::$kind, name: $name, impact: Impact::$impact, words: Words { zh: $zh, en: $en } },)*
        ];

        impl ProblemKind {
            /// Returns true for kinds that a command or the recording explains.
            pub fn is_harmless(self) -> bool {
                self.row().impact == Impact::E || self == Self::BusSilent
            }

            /// Returns the row of the kind.
            pub fn row(self) -> &'static KindRow {
                match self {
                    $(Self::$kind => &const {
                        KindRow { kind: ProblemKind::$kind, name: $name, impact: Impact::$impact, words: Words { zh: $zh, en: $en } }
                    },)*
                }
            }
        }
    };
}

kinds! {
    BusOff "bus-off" A "总线关闭(bus off)" "bus-off";
    ErrorPassive "error-passive" C "控制器处于错误被动状态或达到警告水平" "controller error passive or at its warning level";
    NotAcknowledged "not-acknowledged" B "发出的帧没有节点应答(ACK)" "frames not acknowledged by any node";
    BusErrors "bus-errors" C "错误帧" "error frames";
    TransceiverFault "transceiver-fault" A "收发器或线路故障" "transceiver or line fault";
    WrongBitRate "wrong-bit-rate" B "只有错误帧: 波特率可能不符" "error frames only: the bit rate may be wrong";
    SegmentLost "segment-lost" A "几个节点同时失去联系" "several nodes silent at the same time";
    BusSilent "bus-silent" A "整个总线静默" "whole bus silent";
    NotCanopen "not-canopen" E "不是CANopen的报文" "not CANopen traffic";
    CaptureGap "capture-gap" E "记录有缺口" "gap in the recording";
    Overload "overload" C "总线过载" "bus overload";
    Flood "node-floods" C "单个COB-ID的报文激增" "one COB-ID floods the bus";
    BitTiming "bit-timing-activated" E "按LSS命令切换波特率" "bit rate switched by LSS";

    NodeAbsent "node-absent" B "节点不存在" "node absent";
    Scan "scan" E "扫描节点ID" "node-ID scan";
    NodeSilent "node-silent" A "节点失去联系" "node silent";
    HeartbeatStopped "heartbeat-stopped" C "心跳停止, 节点仍在发送其他报文" "heartbeat stopped while the node still sends other frames";
    NodeRestarted "node-restarted" A "节点自行重启" "node restarted by itself";
    RestartLoop "restart-loop" A "节点反复重启" "node restarts repeatedly";
    MuteAfterBoot "mute-after-boot-up" B "启动后再无报文" "nothing heard after a boot-up";
    ResetAgain "reset-again-and-again" B "节点被反复复位" "node repeatedly reset by command";
    AnotherDevice "another-device" B "该节点ID上是另一个设备" "another device at the node-ID";
    NoBootUp "no-boot-up" B "复位后没有启动报文" "no boot-up after a reset";
    NotStarted "not-started" B "节点没有被主站启动" "node never started by the master";
    BootStuck "boot-stuck" B "主站的启动过程停滞" "boot process of the master stuck";
    TwoMasters "two-masters" A "NMT命令相互矛盾" "contradicting NMT commands";
    LeftOperational "left-operational" A "节点自行离开操作状态" "node left Operational by itself";
    StartWithoutEffect "start-without-effect" B "NMT命令未生效" "NMT command without effect";
    CommandedReset "commanded-reset" E "按命令复位" "reset by command";
    CommandedStop "commanded-stop" E "按命令离开操作状态" "stopped by command";
    HeartbeatConsumerError "heartbeat-consumer-error" A "心跳消费者报告对方心跳丢失" "heartbeat consumer reports a loss";
    GuardingUnanswered "guarding-unanswered" A "节点保护请求没有应答" "node guarding requests unanswered";
    GuardingStopped "guarding-stopped" A "主站停止节点保护" "node guarding stopped by the master";
    GuardingAndHeartbeat "guarding-and-heartbeat" D "同时使用节点保护和心跳" "node guarding and heartbeat at the same time";
    DuplicateNodeId "duplicate-node-id" A "节点ID重复" "duplicate node-ID";
    HeartbeatIrregular "heartbeat-irregular" C "心跳不均匀" "irregular heartbeats";
    HeartbeatSwitchedOff "heartbeat-switched-off" E "心跳被写入关闭" "heartbeat switched off by a write";
    ConsumerTimeTooShort "consumer-time-too-short" B "消费者心跳时间短于对方的心跳周期" "consumer heartbeat time shorter than the producer's period";
    WatchedAbsent "watched-node-absent" C "被监视的节点从未出现" "monitored node never seen";

    RequestUnanswered "request-unanswered" B "SDO请求没有响应" "SDO requests unanswered";
    LateAnswer "late-answer" C "SDO响应过晚" "SDO response too late";
    AnswerElsewhere "answer-on-another-id" B "响应出现在其他CAN-ID上" "SDO response with another CAN-ID";
    ReadInVain "read-in-vain" C "读取对象总是被拒绝" "reads of an object always refused";
    ObjectRefused "object-refused" B "写入的对象不存在" "write to an object that does not exist";
    AccessRefused "access-refused" B "写入被拒绝: 访问权限" "write refused: access right";
    LengthRefused "length-refused" B "写入被拒绝: 长度或类型" "write refused: length or type";
    ValueRefused "value-refused" B "写入被拒绝: 数值" "write refused: value";
    StateRefused "state-refused" B "写入被拒绝: 设备状态" "write refused: device state";
    MappingRefused "mapping-refused" B "PDO配置被拒绝" "PDO configuration refused";
    WriteRefused "write-refused" B "写入被拒绝" "write refused";
    HalfConfigured "half-configured" B "配置未完成就被启动" "started with an incomplete configuration";
    StoreFailed "store-failed" C "存储或恢复参数失败" "storing or restoring parameters failed";
    ProgramFailed "program-download-failed" B "程序下载失败" "program download failed";
    Storing "storing" E "正在存储参数或写入程序" "storing parameters or a program";
    DamagedTransfer "damaged-transfer" B "SDO传输违反协议" "SDO transfer violates the protocol";
    TwoClients "two-clients" D "一个SDO通道上有两个客户端" "two clients on one SDO channel";
    IdentityMismatch "identity-mismatch" B "设备标识与设备描述不符" "device identity differs from the description";

    PdoLength "pdo-length" B "PDO长度与映射不符" "PDO length differs from its mapping";
    PdoMissing "pdo-missing" A "PDO中断, 节点仍在线" "PDO missing although the node is online";
    RpdoTimeout "rpdo-timeout" A "RPDO超时" "RPDO timeout";
    RpdoStopped "rpdo-stopped" A "RPDO停止, SYNC继续" "RPDO stopped while SYNC goes on";
    NotTaken "frames-not-taken" B "没有RPDO接收的帧" "frames that no RPDO takes";
    SharedCobId "shared-cob-id" A "两个发送方使用同一COB-ID" "two producers with the same COB-ID";
    PdoNotAllowed "pdo-not-allowed" D "不应出现的PDO" "PDO that should not be sent";
    PdoConfiguration "pdo-configuration" D "PDO配置有误" "wrong PDO configuration";
    InhibitTime "inhibit-time" C "短于抑制时间" "sent within the inhibit time";
    PdoMultiplied "pdo-multiplied" C "重复启动后PDO成倍发送" "PDO rate multiplied after a repeated start";
    CommandsNotTaken "commands-not-taken" B "向未处于操作状态的节点发送RPDO" "RPDOs to a node that is not Operational";
    SyncStopped "sync-stopped" A "SYNC停止" "SYNC stopped";
    SyncIrregular "sync-irregular" C "SYNC或同步PDO时序异常" "SYNC or synchronous PDOs with wrong timing";
    TwoSyncProducers "two-sync-producers" A "两个SYNC生产者" "two SYNC producers";
    SyncLength "sync-length" D "SYNC长度不符" "wrong SYNC length";

    AxisFault "axis-fault" A "驱动器故障" "axis in fault";
    FaultResetWithoutEffect "fault-reset-without-effect" A "故障复位未生效" "fault reset without effect";
    NotEnabled "not-enabled" B "驱动器命令未生效" "drive command without effect";
    QuickStop "quick-stop" A "快速停止" "quick stop";
    StateLeft "state-left" A "驱动器未经命令离开运行使能" "drive left operation enabled without a command";
    IllegalTransition "illegal-transition" D "状态跳变没有对应的控制字" "drive state changed without a matching controlword";
    ModeNotTaken "mode-not-taken" B "操作模式未生效" "mode of operation not accepted";
    FaultResetWithoutEdge "fault-reset-without-edge" B "故障复位没有上升沿" "fault reset without a rising edge";
    FollowingError "following-error" A "跟随误差" "following error";
    InternalLimit "internal-limit" C "内部限制生效" "internal limit active";
    SetPointIgnored "set-point-not-acknowledged" B "新设定点未得到确认" "set-point not acknowledged";
    HomingFailed "homing-failed" B "回零失败" "homing failed";
    TargetsLate "targets-late" C "目标值没有按周期到达" "late target values";

    CommunicationError "communication-error" A "节点报告通信错误" "node reports a communication error";
    Overrun "overrun" C "节点报告CAN溢出" "node reports a CAN overrun";
    BusTrouble "bus-trouble" C "节点报告总线错误" "node reports bus errors";
    DeviceError "device-error" C "设备报告错误" "device reports an error";
    SupplyVoltage "supply-voltage" A "设备报告供电电压错误" "device reports a supply voltage error";
    Temperature "temperature" C "设备报告温度错误" "device reports a temperature error";
    ModuleFailed "module-failed" A "I/O模块故障" "I/O module failed";
    RegisterWithoutEmcy "register-without-emcy" C "错误寄存器不为0, 却没有紧急报文" "error register not 0 without an EMCY";
    EmcyFlood "emcy-flood" C "大量紧急报文" "EMCY flood";

    LssUnanswered "lss-unanswered" B "LSS没有响应" "LSS unanswered";
    LssRefused "lss-refused" B "LSS命令被拒绝" "LSS command refused";
    TimeJump "time-jump" C "TIME跳变" "TIME jumps";
    SrdoInvalid "srdo-invalid" A "SRDO无效" "invalid SRDO";
    WireError "wire-error" D "报文违反协议" "frames violate the protocol";
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
