//! The sentences of incidents and their steps, and the first things to check, in both languages.
//!
//! A sentence is declared with its facts like those of rules; an unknown name in braces does not compile. Times called
//! `at` count from the first frame of the capture.

use crate::rules::quantity::{Abort, Command, Count, Emcy, Hex2, Ns, Object, Pdo, State, Statusword};
use crate::rules::rules;
use crate::rules::{Measured, Words};

macro_rules! sayings {
    ($($saying:ident $({ $($fact:ident: $kind:ty),+ })? $zh:literal $en:literal;)*) => {
        /// A sentence with its facts.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Saying {
            $(
                #[doc = $en]
                $saying $({ $(#[doc = stringify!($kind)] $fact: <$kind as crate::rules::FactKind>::Value),+ })?,
            )*
        }

        $(const _: () = rules!(@variant $zh, $en, [], [$($($fact: $kind),+)?]).check();)*

        impl From<Saying> for Measured {
            fn from(what: Saying) -> Self {
                match what {$(
                    Saying::$saying $({ $($fact),+ })? => {
                        const VARIANT: &crate::rules::Variant = &rules!(@variant $zh, $en, [], [$($($fact: $kind),+)?]);
                        Self::new(VARIANT, [$($(<$kind as crate::rules::FactKind>::of($fact)),+)?])
                    }
                )*}
            }
        }
    };
}

sayings! {
    // Titles.
    Silent { at: Ns, period: Ns }
        "{at}起没有任何报文, 此前每{period}一次心跳" "silent since {at}, previously a heartbeat every {period}";
    SilentSince { at: Ns } "{at}起没有任何报文" "silent since {at}";
    SilentAndBack { at: Ns, silence: Ns }
        "{at}起{silence}没有任何报文, 之后恢复" "silent for {silence} from {at} on, then back";
    SilentAndWaits { at: Ns, silence: Ns }
        "{at}起{silence}没有任何报文, 之后恢复, 但未再进入操作状态"
        "silent for {silence} from {at} on, then back, but not Operational since";
    SilentAndBooted { at: Ns, silence: Ns }
        "{at}起{silence}没有任何报文, 之后自行启动" "silent for {silence} from {at} on, came back with a boot-up without a command";
    SilentOften { at: Ns, count: Count } "{at}起{count}次失去联系" "silent {count} times from {at} on";
    HeartbeatStopped { at: Ns } "{at}起没有心跳, 其他报文仍在" "no heartbeat since {at}, but other frames of the node";
    Segment { at: Ns, count: Count } "{at}起{count}个节点同时没有任何报文" "{count} nodes silent at the same time since {at}";
    Restarted { at: Ns } "{at}自行重启" "restarted by itself at {at}";
    RestartedOften { at: Ns, count: Count } "{at}起自行重启{count}次" "restarted by itself {count} times from {at} on";
    Absent { at: Ns } "{at}起被访问, 从未响应" "requests since {at}, never heard";
    NoBootUp { at: Ns } "{at}复位后没有启动报文" "no boot-up after the reset at {at}";
    LeftOperational { at: Ns, state: State } "{at}自行进入{state}" "went to {state} by itself at {at}";
    WithoutEffect { at: Ns, command: Command } "{at}的NMT命令“{command}”未生效" "NMT command \"{command}\" at {at} without effect";
    ResetByCommand { at: Ns, command: Command } "{at}按命令复位: {command}" "reset by command at {at}: {command}";
    StoppedByCommand { at: Ns, command: Command } "{at}按命令离开操作状态: {command}" "stopped by command at {at}: {command}";
    Reported { code: Emcy, at: Ns } "{at}报告EMCY {code}" "reported EMCY {code} at {at}";
    ReportedOnce { code: Emcy } "报告EMCY {code}" "reported EMCY {code}";
    FaultOnce { code: Emcy } "进入故障状态, EMCY {code}" "in fault, EMCY {code}";
    UnansweredOnce { object: Object } "对{object}的请求没有响应" "request for {object} not answered";
    OfPdo { pdo: Pdo } "{pdo}" "{pdo}";
    ReportedOften { code: Emcy, at: Ns, count: Count } "{at}起{count}次报告EMCY {code}" "reported EMCY {code} {count} times from {at} on";
    TooShort { limit: Ns, watched: Count, period: Ns }
        "监视节点{watched}的1016h时限为{limit}, 短于该节点的心跳周期{period}: 反复误报心跳丢失"
        "its consumer heartbeat time (1016h) for node {watched} is {limit}, shorter than the heartbeat period {period}: false alarms";
    Fault { at: Ns } "{at}进入故障状态" "in fault since {at}";
    FaultSeen { at: Ns } "{at}首次出现时已处于故障状态" "already in fault when first seen at {at}";
    FaultWith { at: Ns, code: Emcy } "{at}进入故障状态, EMCY {code}" "in fault since {at}, EMCY {code}";
    Refused { count: Count, object: Object, abort: Abort }
        "{count}次写入被拒绝, 第一次是{object}: {abort}" "{count|write|writes} refused, the first to {object}: {abort}";
    RefusedMadeGood { count: Count, object: Object, abort: Abort }
        "{count}次写入被拒绝({object}: {abort}), 之后都已改正"
        "{count|write|writes} refused ({object}: {abort}), all repeated successfully";
    RefusedOthers { count: Count, object: Object, abort: Abort }
        "{count}次写入被拒绝({object}: {abort}), 之后写入其他值成功"
        "{count|write|writes} refused ({object}: {abort}), other values accepted later";
    Unanswered { object: Object, at: Ns } "{at}对{object}的请求没有响应" "request for {object} at {at} not answered";
    UnansweredAt { at: Ns } "{at}的请求没有响应" "request at {at} not answered";
    GapOf { at: Ns, silence: Ns } "{at}处{silence}没有任何帧: 记录停顿" "no frame for {silence} at {at}: the recording paused";
    Gap { at: Ns } "{at}处记录有缺口" "gap in the recording at {at}";
    SyncStopped { at: Ns } "{at}起没有SYNC" "no SYNC since {at}";
    PdoMissing { pdo: Pdo, at: Ns } "{at}起没有{pdo}" "no {pdo} since {at}";
    PdoOf { pdo: Pdo, at: Ns } "{at}: {pdo}" "{pdo} at {at}";
    Since { at: Ns } "{at}起" "since {at}";
    Times { at: Ns, count: Count } "{at}起{count}次" "{count} times from {at} on";
    AllNodes "整个总线" "the whole bus";

    // Steps.
    LastSign "最后一帧" "last frame";
    BootedUnasked "未见命令却启动" "boot-up without a command";
    HeardAgain "重新出现, 没有启动报文" "back, without a boot-up";
    Booted "启动报文" "boot-up";
    OperationalAgain "重新进入操作状态" "Operational again";
    Went { from: State, to: State } "从{from}进入{to}, 没有命令" "from {from} to {to} without a command";
    Commanded { command: Command } "NMT命令: {command}" "NMT command: {command}";
    Raised { code: Emcy, register: Hex2 } "EMCY {code}, 错误寄存器{register}" "EMCY {code}, error register {register}";
    TakenBack { code: Emcy } "{code}已清除" "{code} cleared";
    AllTakenBack "所有错误已清除" "all errors cleared";
    StillSet { register: Hex2 } "错误复位报文, 错误寄存器仍为{register}" "error reset, error register still {register}";
    SyncGone "SYNC随之停止" "SYNC stops with it";
    InFault { statusword: Statusword } "状态字{statusword}" "statusword {statusword}";
    LeftFault "离开故障状态" "out of fault";
    FaultReset "故障复位命令" "fault reset";
    ResetInVain "故障复位未生效" "fault reset without effect";
    WriteRefused { object: Object, abort: Abort } "写入{object}被拒绝: {abort}" "write to {object} refused: {abort}";
    WriteTaken { object: Object } "写入{object}成功" "write to {object} succeeded";
    Answered "节点又有响应" "node responds again";
    NotAnswered "没有响应" "not answered";
    ClientGaveUp "客户端放弃" "the client gave up";
    SyncAgain "SYNC恢复" "SYNC back";
    PdoAgain "PDO恢复" "PDO back";
    LengthFits "长度恢复正常" "length correct again";
    RecordingGoesOn "记录继续" "recording continues";
    Recovered "已恢复" "recovered";
    WrittenAgain "同一对象写入成功" "same object written successfully";
    NotStartedSince { since: Ns } "{since}内未再被启动" "not started again for {since}";
    SameTime { object: Object } "同时请求{object}" "{object} requested at the same time";
    RegisterRead { register: Hex2 } "错误寄存器1001h为{register}" "error register 1001h is {register}";
    DeviceTypeRead "读设备类型1000h" "device type 1000h read";
    StartedAllTheSame "仍被启动" "started anyway";
    Floods { gap: Ns, period: Ns } "每{gap}一帧, 此前每{period}" "one frame every {gap}, previously every {period}";
    Loaded { load: Count, rate: Count } "总线负载{load} % ({rate} kbit/s)" "bus load {load} % at {rate} kbit/s";
    Reports { statusword: Statusword } "状态字{statusword}" "statusword {statusword}";
    NoTarget { gap: Ns, period: Ns } "{gap}没有目标值(周期{period})" "no target value for {gap} (period {period})";
}

/// One of the first things to check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Check {
    /// The word in machine output.
    pub name: &'static str,
    /// The text for people.
    pub words: Words,
}

macro_rules! checks {
    ($($(#[$doc:meta])* $check:ident $name:literal $zh:literal $en:literal;)*) => {
        $(#[doc = $en] pub const $check: Check = Check { name: $name, words: Words { zh: $zh, en: $en } };)*
    };
}

checks! {
    SUPPLY "supply" "节点的电源" "power supply of the node";
    CONNECTOR "connector" "节点的接插件和电缆" "connector and cable of the node";
    LEDS "leds" "节点的指示灯" "LEDs of the node";
    SEGMENT "segment" "这些节点共用的电缆段或电源" "shared cable segment or supply of these nodes";
    WATCHDOG "watchdog" "看门狗或固件: 有启动报文说明节点断过电或自行复位, 仅电缆松动不会有启动报文"
        "watchdog or firmware: the boot-up shows a power loss or reset; a loose cable alone causes none";
    CABLE_ONLY "cable-only" "没有启动报文, 说明没有断电: 仅连接中断" "no boot-up, so the node kept its power: only the connection was lost";
    FELL_BACK "fell-back" "恢复时处于预操作状态却没有启动报文: 可能重启过(有的协议栈不发启动报文), 或按1029h退出操作状态"
        "back in Pre-operational without a boot-up: restarted (some stacks send none), or left Operational by 1029h";
    NO_SIGN "no-sign" "没有紧急报文或启动报文: 没有重启, 从总线上看不出原因"
        "no EMCY and no boot-up: the node did not restart, and the bus does not show why it stopped";
    ERROR_FRAMES_OFF "berr-reporting"
        "本记录中没有错误帧; 要判断接线和干扰, 请打开错误帧: ip link set can0 type can berr-reporting on"
        "no error frames in this capture; to check for wiring and noise, enable them: ip link set can0 type can berr-reporting on";
    WIRING "wiring" "前后有错误帧: 接线、终端电阻、屏蔽" "error frames nearby: wiring, termination, shield";
    FIRMWARE "firmware" "节点仍在发送其他报文: 固件任务或1017h, 不是电缆" "the node still sends other frames: firmware or 1017h, not the cable";
    CAUSE "cause" "先处理起因, 而不是这个节点" "its cause, not this node";
    WATCHED "watched-node" "它所监视的节点(1016h)" "the node it monitors (1016h)";
    CONSUMER_TIME "consumer-time" "消费者心跳时间1016h应至少为对方1017h的1.5倍" "1016h: at least 1.5 times the producer's 1017h";
    PRODUCER "producer" "它所等待的PDO的发送方" "producer of the PDO it waits for";
    SYNC_PRODUCER "sync-producer" "SYNC生产者" "SYNC producer";
    MANUAL "manual" "设备手册中的错误码; 1003h, 驱动器为603Fh" "error code in the device manual; 1003h, of drives 603Fh";
    PDO_ORDER "pdo-order" "写入顺序: COB-ID位31=1, 映射:00=0, 各条目, :00=n, 最后有效"
        "write order: COB-ID bit 31 = 1, mapping :00 = 0, entries, :00 = n, then valid";
    EDS "eds" "主站所用的EDS是否属于这个固件" "whether the EDS used by the master fits this firmware";
    STATE "state" "设备当时的状态(NMT、驱动、本地操作)" "device state at that time (NMT, drive, local operation)";
    CLIENT "client" "主站的SDO超时时间" "SDO timeout of the client";
    SERVER "server" "节点当时是否忙(存储、启动)" "whether the node was busy (storing, booting)";
    RECORDER "recorder" "记录用的主机" "recording host";
    MASTER "master" "主站" "the master";
    NODE_ID "node-id" "拨码开关或LSS设置的节点ID" "DIP switches, or the node-ID set by LSS";
    ERROR_BEHAVIOUR "error-behaviour" "1029h: 是否应离开操作状态" "1029h: whether it should leave Operational";
    MAPPING "mapping" "两端的PDO映射" "PDO mapping of both ends";
    TERMINATION "termination" "终端电阻(H-L间60Ω)、分支、短路、波特率" "termination (60 Ω between H and L), stubs, shorts, bit rate";
    ENABLE "enable" "使能输入、STO、直流母线(状态字位4)" "enable input, STO, DC link (statusword bit 4)";
    ALL_AXES "safety" "所有轴共同的原因: STO、急停、电源" "common causes of the axes: STO, emergency stop, supply";
    FAULT_CAUSE "fault-cause" "故障原因仍在: 先消除它" "fault cause still present: remove it first";
    LOAD "load" "总线负载和发送方的实时性" "bus load and timing of the sender";
    HOST "host" "控制器的程序、电源和CAN接口" "controller: program, supply and CAN interface";
    MASTER_BOOT "master-boot" "主站的启动列表(1F80h、1F81h)和期望的身份(1F84h至1F88h)"
        "the boot list of the master (1F80h, 1F81h) and the identity it expects (1F84h to 1F88h)";
    OTHER_MASTER "other-master" "是否还有第二个主站或调试工具在总线上" "whether a second master or a tool is on the bus";
    EVENT_RATE "event-rate" "该PDO的传输类型、抑制时间(18xxh:03)和事件源" "transmission type, inhibit time (18xxh:03) and event source of the PDO";
    EDGE "rising-edge" "控制字位7: 须先为0, 再置1" "controlword bit 7: first 0, then 1";
    POWER_STAGE "power-stage" "主电源(状态字位4)、STO和使能输入" "mains (statusword bit 4), STO and enable input";
    MECHANICS "mechanics" "机械、增益、转矩限制, 以及SYNC和目标值的周期" "mechanics, gains, torque limits, and the period of SYNC and targets";
    HOMING "homing" "回零方法(6098h)、限位和零点开关" "the homing method (6098h), limit and home switches";
    SET_POINT "set-point" "控制字位4的上升沿, 位12确认之后再清零" "rising edge of controlword bit 4, cleared again after bit 12";
    CYCLE "cycle" "主站周期、SYNC周期(1006h)与60C2h是否一致" "whether the master's cycle, SYNC (1006h) and 60C2h agree";
    SIGNATURE "signature" "签名(“save”“load”)和设备手册中的时间" "signature (\"save\", \"load\") and storage time given in the manual";
    PROGRAM "program" "擦除时间与主站SDO超时、节点是否处于引导程序" "erase time against the client's SDO timeout, whether the node is in its bootloader";
    COOLING "cooling" "散热、负载和环境温度" "cooling, load and ambient temperature";
    MAINS "mains" "供电能力和启动电流" "supply capacity and inrush current";
    IO_MODULE "io-module" "耦合器后的模块和内部总线" "modules and internal bus behind the coupler";
    UNHEARD "unheard" "1016h中从未出现的节点: 接上它, 或删除该条目" "1016h lists a node that was never seen: connect it or remove the entry";
    REPEATED_START "repeated-start" "主站重复发送的启动命令" "repeated start command of the master";
    NOTHING "nothing" "无需处理" "nothing";
}
