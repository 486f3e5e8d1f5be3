//! Rules about node guarding (CiA 301, 7.2.8.3.2.1).

use super::quantity::{Bit, Count, Ns};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// The toggle bit of guarding answers does not alternate.
    Grd001 "GRD001" "guarding-toggle" Error "CiA 301 7.2.8.3.2.1" [ErrorControl, Nmt] {
        message "节点保护的toggle位错误" "toggle bit of node guarding";
        meaning
            "节点保护应答的toggle位每次都要翻转; 复位后从0开始。"
            "The toggle bit alternates with each guarding answer, from 0 after a reset.";
        cause
            "协议栈实现有误, 或者记录中丢了一个应答。"
            "A fault of the stack, or an answer is missing from the capture.";
        Toggle { found: Bit, expected: Bit }
            "toggle={found}, 应为{expected}"
            "toggle={found}, expected {expected}";
    }

    /// A guarding request was not answered.
    Grd002 "GRD002" "guarding-unanswered" Warning "CiA 301 7.2.8.3.2.1" [ErrorControl, Nmt] {
        message "保护请求没有应答" "guarding request without answer";
        meaning
            "NMT主站用远程帧询问节点状态, 节点必须应答。"
            "The NMT master asks for the node's state by a remote frame, and the node answers.";
        cause
            "节点掉线或正在启动, 不支持节点保护, 或者它的CAN控制器不应答远程帧。"
            "The node is gone or starting, does not support node guarding, or its CAN controller does not answer remote frames.";
        NoResponseWithin { age: Ns }
            "保护请求{age}内没有应答"
            "no answer to the guarding request within {age}";
        NoResponse
            "保护请求没有应答"
            "no answer to the guarding request";
    }

    /// One node is guarded and sends heartbeats.
    Grd003 "GRD003" "heartbeat-and-guarding" Warning "CiA 301 7.2.8.3.2" [ErrorControl, Nmt] {
        message "同时使用心跳和节点保护" "heartbeat and node guarding at once";
        meaning
            "一个节点只能使用其中之一: 1017h不为0时使用心跳, 节点不应答保护请求。"
            "A node uses one or the other: where 1017h is not 0 it sends heartbeats and does not answer guarding requests.";
        cause
            "主站配置了节点保护, 而节点的1017h没有清零。"
            "The master is configured for guarding while 1017h of the node is not 0.";
        Heartbeats
            "被保护的节点还发送没有请求的心跳"
            "the guarded node sends heartbeats that nobody asked for";
        Requests
            "向发送心跳的节点发送保护请求"
            "guarding requests to a node that sends heartbeats";
    }

    /// A node that is guarded was never seen.
    Grd004 "GRD004" "guarded-node-absent" Info "-" [ErrorControl, Nmt] {
        message "被保护的节点从未出现" "guarded node never seen";
        meaning
            "记录中有对该节点的保护请求, 但没有它的任何帧。"
            "The capture has guarding requests for this node and no frame of its own.";
        cause
            "节点不存在或没有上电, 或者只记录到一个方向。"
            "The node does not exist or has no power, or only one direction was captured.";
        Absent { requests: Count }
            "{requests}个保护请求, 没有该节点的任何帧"
            "{requests} guarding requests and no frame of the node";
    }

    /// The master has stopped guarding a node for longer than its life time.
    Grd005 "GRD005" "life-guarding" Error "CiA 301 7.2.8.3.2.1" [ErrorControl, Nmt] {
        message "寿命保护" "life guarding";
        meaning
            "NMT主站在节点寿命时间 (100Ch乘以100Dh) 内没有发送保护请求, 节点由此认为主站已丢失 (寿命保护事件)。"
            "The NMT master has sent no guarding request within the node life time (100Ch times 100Dh). The node takes the master for lost (life guarding event).";
        cause
            "主站停止, 太忙, 或者询问的间隔比节点的配置长。"
            "The master has stopped, is busy, or asks less often than the node is configured for.";
        Expired { age: Ns, limit: Ns }
            "此后{age}没有保护请求, 节点寿命时间为{limit}"
            "no guarding request for {age} after it, the node life time is {limit}";
    }
}
