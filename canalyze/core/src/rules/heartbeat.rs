//! Rules about heartbeats, boot-ups and node-IDs (CiA 301, 7.2.8.3.2).

use super::quantity::{Count, Hex2, Ns, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// A heartbeat came late.
    Hbt001 "HBT001" "heartbeat-late" Warning "CiA 301 7.2.8.3.2.2" [ErrorControl, Nmt] {
        message "心跳迟到" "heartbeat late";
        meaning
            "两个心跳的间隔明显超过了周期。周期取自1017h或之前的心跳; 额外的心跳是允许的。"
            "Two heartbeats are clearly further apart than the period, which is known from 1017h or the heartbeats before. Additional heartbeats are legal.";
        cause
            "节点太忙, 总线负载太高, 或者丢了一帧。"
            "A busy node, high bus load, or a missing frame.";
        Late { found: Ns, expected: Ns }
            "与上次心跳间隔{found}, 周期为{expected}"
            "{found} after the last heartbeat, the period is {expected}";
    }

    /// No heartbeat for longer than a consumer waits, or than three periods.
    Hbt002 "HBT002" "heartbeat-lost" Error "CiA 301 7.2.8.3.2.2" [ErrorControl, Nmt] {
        message "心跳丢失" "heartbeat lost";
        meaning
            "消费者时间 (1016h) 内没有心跳; 没有已知的消费者时间时, 以三个周期加容差为限。只说一次。"
            "No heartbeat within the consumer heartbeat time (1016h) or, where none is known, within three periods and a tolerance. It is said once.";
        cause
            "节点掉线、断电或死机, 电缆断开, 或者节点总线关闭(bus off)。"
            "The node is gone, off or hung, a cable is open, or its controller is in bus-off.";
        ConsumerTime { silence: Ns, limit: Ns }
            "此后{silence}没有心跳, 消费者时间为{limit}"
            "no heartbeat for {silence} after it, the consumer heartbeat time is {limit}";
        Limit { silence: Ns, limit: Ns }
            "此后{silence}没有心跳, 限值为{limit}"
            "no heartbeat for {silence} after it, the limit is {limit}";
    }

    /// Error control with a state that the standard does not define.
    Hbt003 "HBT003" "unknown-state" Warning "CiA 301 7.2.8.3.2" [ErrorControl, Nmt] {
        message "未知的NMT状态" "unknown NMT state";
        meaning
            "错误控制报文中的状态只能是00h、04h、05h或7Fh; 心跳的位7为0。"
            "Error control carries the state 00h, 04h, 05h or 7Fh; bit 7 of a heartbeat is 0.";
        cause
            "固件错误, 数据损坏, 或者别的协议占用了这个CAN-ID。"
            "A fault of the firmware, corrupt data, or another protocol on this CAN-ID.";
        State { found: Hex2 }
            "状态为{found}"
            "the state is {found}";
        ToggleBit { found: Hex2 }
            "心跳的位7为1 ({found}), 而没有保护请求"
            "bit 7 of a heartbeat is 1 ({found}), and nobody has sent a guarding request";
    }

    /// Two nodes use one node-ID.
    Hbt004 "HBT004" "duplicate-node-id" Warning "CiA 301 7.3.5" [ErrorControl, Nmt] {
        message "节点ID重复" "duplicate node-ID";
        meaning
            "同一个节点ID上有两路心跳交错, 或者一次复位后有两个启动报文: 总线上有两个节点使用了同一个节点ID。"
            "Two series of heartbeats are interleaved on one node-ID, or two boot-ups follow one reset: two nodes use the same node-ID.";
        cause
            "拨码开关设置相同, 或者新设备使用默认的节点ID。"
            "Equal DIP switches, or a new device with the default node-ID.";
        States { one: State, other: State }
            "没有命令而状态交替为{one}和{other}"
            "the state alternates between {one} and {other} without commands";
        Gaps { one: Ns, other: Ns }
            "心跳间隔交替为{one}和{other}: 两路心跳"
            "gaps between heartbeats alternate between {one} and {other}: two series";
        HalfPeriod { found: Ns, expected: Ns }
            "心跳间隔为{found}, 只有1017h周期{expected}的一半"
            "gaps between heartbeats are {found}, half of the {expected} of 1017h";
        BootUps { gap: Ns }
            "{gap}内有两个启动报文"
            "two boot-ups within {gap}";
        Series { one: Ns, other: Ns }
            "周期为{one}的心跳之间每隔{other}另有心跳: 两路心跳"
            "between heartbeats of period {one} come others every {other}: two series";
    }

    /// The whole bus was silent: no heartbeat could be seen.
    Hbt005 "HBT005" "silent-bus" Info "-" [ErrorControl, Nmt] {
        message "总线静默" "silent bus";
        meaning
            "这段时间里总线上一帧也没有, 因此不据此判断节点丢失; 之后不再出现的节点才算丢失。"
            "There was no frame at all, so no node counts as lost for that; who does not come back afterwards does.";
        cause
            "记录暂停或主机停顿, 总线断开, 或者整个网络断电。"
            "The recording paused or the host stalled, the bus was open, or the network had no power.";
        Silent { silence: Ns, nodes: Count }
            "总线静默{silence}, {nodes}个节点的心跳应到未到"
            "the bus was silent for {silence}; nodes whose heartbeat was due: {nodes}";
    }

    /// Error control has another length than 1 byte.
    Hbt006 "HBT006" "error-control-length" Warning "CiA 301 7.2.8.3.2" [ErrorControl, Nmt] {
        message "错误控制报文的长度不是1字节" "error control is not 1 byte long";
        meaning
            "心跳、启动报文和保护应答都是1字节, 只有状态。"
            "Heartbeat, boot-up and guarding answer have one byte, the state.";
        cause
            "固件设置了错误的DLC, 或者该COB-ID上是别的协议。"
            "The firmware sets a wrong DLC, or another protocol uses this COB-ID.";
        Length { found: Count }
            "错误控制报文有{found}字节, 应为1字节"
            "error control has {found} bytes and should have 1";
    }

    /// Heartbeats come with another period, and nothing has changed it.
    Hbt007 "HBT007" "heartbeat-period-changed" Warning "CiA 301 7.5.2.16" [ErrorControl, Nmt] {
        message "心跳周期改变" "heartbeat period changed";
        meaning
            "心跳以另一个周期均匀出现, 而记录中没有能解释它的1017h写入或复位。"
            "Heartbeats come evenly with another period than before, and neither a write to 1017h nor a reset is in the capture that explains it.";
        cause
            "固件中的任务过载或重新启动, 本地操作, 或者另一个节点使用了同一个节点ID。"
            "A busy or restarted task of the firmware, local operation, or a second node with this node-ID.";
        Changed { from: Ns, to: Ns }
            "从这里起心跳周期为{to}, 此前为{from}"
            "heartbeats come every {to} from here on, every {from} before";
    }
}
