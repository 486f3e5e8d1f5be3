//! Rules about heartbeats, boot-ups and node-IDs (CiA 301, 7.2.8.3.2).

use crate::bytes::ns::Ns;

use super::quantity::{Count, Hex2, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 两个心跳的间隔明显超过了周期, 或者写入1017h之后第一个心跳延迟了一个周期, 复位命令之后的启动报文后的也是如此。周期取自1017h或其他心跳; 额外的心跳是允许的。
    /// Two heartbeats are clearly further apart than the period, or the first one after a write of 1017h is a period late, or that after a commanded boot-up is late. The period is taken from 1017h or the other heartbeats. Additional heartbeats are legal.
    ///
    /// 节点太忙, 总线负载太高, 或者丢了一帧。
    /// A busy node, high bus load, or a missing frame.
    Hbt001 "HBT001" "heartbeat-late" Warning "CiA 301 7.2.8.3.2.2" [ErrorControl, Nmt] {
        message "心跳延迟" "heartbeat late";
        Late { found: Ns, expected: Ns }
            "距上次心跳{found}, 周期为{expected}" "{found} since the previous heartbeat (period {expected})";
        AfterWrite { found: Ns, expected: Ns }
            "写入1017h之后{found}才收到第一个心跳, 周期为{expected}"
            "first heartbeat {found} after 1017h was written (period {expected})";
        AfterBoot { found: Ns, expected: Ns }
            "启动报文之后{found}才收到第一个心跳, 周期为{expected}"
            "first heartbeat {found} after the boot-up (period {expected})";
        Slower [reason = "period"] { found: Ns, expected: Ns }
            "心跳周期为{found}, 而1017h为{expected}" "heartbeat period is {found}, 1017h holds {expected}";
    }

    /// 上一个心跳或写入1017h之后, 消费者心跳时间 (1016h) 内没有心跳; 消费者心跳时间未知时, 判定时限为三个周期加容差。节点启动后尚未表明其周期时, 时限为此前周期的10倍且至少5 s。只报告一次。
    /// No heartbeat after the previous one or a write of 1017h within the consumer heartbeat time (1016h) or, where none is known, within three periods plus a tolerance. Behind a boot-up, until the node has shown its period again, within ten of the former periods and at least 5 s. Reported once.
    ///
    /// 节点掉线、断电或死机, 电缆断开, 或者节点总线关闭(bus off)。
    /// The node is disconnected, powered off or hung, a cable is broken, or its controller is bus-off.
    Hbt002 "HBT002" "heartbeat-lost" Error "CiA 301 7.2.8.3.2.2" [ErrorControl, Nmt] {
        message "心跳丢失" "heartbeat lost";
        ConsumerTime { silence: Ns, limit: Ns } "此后{silence}没有心跳, 超过消费者心跳时间(1016h) {limit}"
            "no heartbeat for {silence} since then (consumer heartbeat time 1016h: {limit})";
        Limit { silence: Ns, limit: Ns } "此后{silence}没有心跳, 判定时限{limit}(3个周期加容差)"
            "no heartbeat for {silence} since then (limit {limit}: 3 periods plus tolerance)";
        AfterBoot { silence: Ns, limit: Ns, period: Ns } "此后{silence}没有心跳, 判定时限{limit}(启动之前的周期为{period})"
            "no heartbeat for {silence} since then (limit {limit}: before the boot-up the period was {period})";
        AfterWrite { silence: Ns, expected: Ns }
            "写入1017h后{silence}没有心跳, 写入的周期为{expected}"
            "no heartbeat for {silence} since 1017h was written (period written: {expected})";
    }

    /// 错误控制报文中的状态只能是00h、04h、05h或7Fh; 心跳的位7为0。
    /// Error control carries the state 00h, 04h, 05h or 7Fh; bit 7 of a heartbeat is 0.
    ///
    /// 固件错误, 数据损坏, 或者其他协议占用了这个CAN-ID。
    /// A firmware bug, corrupt data, or another protocol on this CAN-ID.
    Hbt003 "HBT003" "unknown-state" Warning "CiA 301 7.2.8.3.2" [ErrorControl, Nmt] {
        message "未知的NMT状态" "unknown NMT state";
        State { found: Hex2 } "心跳中的状态{found}未定义" "undefined state {found}";
        ToggleBit { found: Hex2 } "心跳的位7为1 ({found}), 却没有节点保护请求"
            "bit 7 of the heartbeat is 1 ({found}), but there was no node guarding request";
    }

    /// 同一节点ID上有两路心跳交错, 一次复位后收到两个启动报文, 或者每个节点保护请求有两个应答: 总线上有两个节点使用同一节点ID。
    /// Two heartbeat streams are interleaved on one node-ID, two boot-ups follow one reset, or each node guarding request has two responses: two nodes use the same node-ID.
    ///
    /// 拨码开关设置相同, 或者新设备使用默认的节点ID。
    /// Equal DIP switches, or a new device with the default node-ID.
    Hbt004 "HBT004" "duplicate-node-id" Warning "CiA 301 7.3.5" [ErrorControl, Nmt] {
        message "节点ID重复" "duplicate node-ID";
        States { one: State, other: State }
            "没有NMT命令, 状态却在{one}与{other}之间交替" "the state alternates between {one} and {other} without NMT commands";
        Gaps { one: Ns, other: Ns } "心跳间隔{one}与{other}交替: 存在两路心跳"
            "heartbeat intervals alternate between {one} and {other}: two heartbeat streams";
        Responses "一个节点保护请求有两个应答" "two responses to each node guarding request";
        BootUps { gap: Ns } "{gap}内收到两个启动报文" "two boot-ups within {gap}";
        Series { one: Ns, other: Ns } "周期{one}的心跳之间另有每隔{other}的心跳: 存在两路心跳"
            "between heartbeats of period {one} there are others every {other}: two heartbeat streams";
    }

    /// 这段时间总线上没有任何报文, 因此不判断节点丢失; 之后不再出现的节点才视为丢失。
    /// There was no frame at all, so no node counts as lost during that time; a node that does not come back afterwards does.
    ///
    /// 记录暂停或主机停顿, 总线断开, 或者整个网络断电。
    /// The recording paused or the host stalled, the bus was disconnected, or the network had no power.
    Hbt005 "HBT005" "silent-bus" Info "-" [ErrorControl, Nmt] {
        message "总线静默" "silent bus";
        Silent { silence: Ns, nodes: Count } "总线静默{silence}, 期间{nodes}个节点的心跳应到未到"
            "bus silent for {silence}; heartbeats of {nodes|node|nodes} missing meanwhile";
    }

    /// 心跳、启动报文和节点保护应答都是1字节, 仅含状态。
    /// Heartbeat, boot-up and node guarding response have one byte, the state.
    ///
    /// 固件设置了错误的DLC, 或者该COB-ID被其他协议使用。
    /// The firmware sets a wrong DLC, or another protocol uses this COB-ID.
    Hbt006 "HBT006" "error-control-length" Warning "CiA 301 7.2.8.3.2" [ErrorControl, Nmt] {
        message "错误控制报文的长度不是1字节" "error control is not 1 byte long";
        Length { found: Count } "错误控制报文为{found}字节, 应为1字节" "error control is {found|byte|bytes} long, expected 1";
    }

    /// 心跳改以另一周期均匀发送, 而记录中没有对1017h的写入或复位可以解释; 或者周期短于1017h。
    /// Heartbeats come regularly with another period than before, and the capture has no write to 1017h and no reset that explains it; or with a shorter period than 1017h holds.
    ///
    /// 固件中的任务过载或重新启动, 固件未采用写入的值, 本地操作, 或者另一个节点使用了同一个节点ID。
    /// An overloaded or restarted firmware task, firmware that does not take the value written, local operation, or a second node with this node-ID.
    Hbt007 "HBT007" "heartbeat-period-changed" Warning "CiA 301 7.5.2.20" [ErrorControl, Nmt] {
        message "心跳周期改变或不符" "heartbeat period changed or not as configured";
        Faster [reason = "period"] { found: Ns, expected: Ns }
            "心跳周期为{found}, 而1017h为{expected}" "heartbeat period is {found}, 1017h holds {expected}";
        Changed { from: Ns, to: Ns } "心跳周期由{from}变为{to}" "heartbeat period changed from {from} to {to}";
    }
}
