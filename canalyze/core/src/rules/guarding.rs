//! Rules about node guarding (CiA 301, 7.2.8.3.2.1).

use crate::bytes::ns::Ns;

use super::quantity::{Bit, Count};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 节点保护应答的toggle位每次都要翻转; 复位后从0开始。
    /// The toggle bit alternates with each guarding response, starting with 0 after a reset.
    ///
    /// 协议栈实现有误, 或者记录中丢了一个应答。
    /// A stack bug, or a response missing from the capture.
    Grd001 "GRD001" "guarding-toggle" Error "CiA 301 7.2.8.3.2.1" [ErrorControl, Nmt] {
        message "节点保护的toggle位错误" "wrong toggle bit in node guarding";
        Toggle { found: Bit, expected: Bit }
            "节点保护应答的toggle={found}, 应为{expected}" "node guarding response has toggle={found}, expected {expected}";
    }

    /// NMT主站用远程帧查询节点状态, 节点必须应答。
    /// The NMT master requests the node's state with a remote frame, and the node must respond.
    ///
    /// 节点掉线或正在启动, 不支持节点保护, 或者它的CAN控制器不应答远程帧。
    /// The node is offline or starting, does not support node guarding, or its CAN controller does not answer remote frames.
    Grd002 "GRD002" "guarding-unanswered" Warning "CiA 301 7.2.8.3.2.1" [ErrorControl, Nmt] {
        message "节点保护请求没有应答" "node guarding request without response";
        NoResponseWithin { age: Ns } "节点保护请求在{age}内没有应答" "no response to the node guarding request within {age}";
        NoResponse "节点保护请求没有应答" "no response to the node guarding request";
    }

    /// 一个节点只能使用其中之一: 1017h不为0时使用心跳, 节点不应答节点保护请求。
    /// A node uses one or the other: where 1017h is not 0 it sends heartbeats and does not answer guarding requests.
    ///
    /// 主站配置了节点保护, 而节点的1017h没有清零。
    /// The master is configured for guarding while 1017h of the node is not 0.
    Grd003 "GRD003" "heartbeat-and-guarding" Warning "CiA 301 7.2.8.3.2" [ErrorControl, Nmt] {
        message "同时使用心跳和节点保护" "heartbeat and node guarding at the same time";
        Heartbeats "节点受节点保护监视, 却还在主动发送心跳" "the guarded node also sends heartbeats";
        Requests "向发送心跳的节点发送节点保护请求" "node guarding requests to a node that sends heartbeats";
    }

    /// 记录中有对该节点的节点保护请求, 但没有它的任何报文。
    /// The capture has node guarding requests for this node but no frame from it.
    ///
    /// 节点不存在或没有上电, 或者只记录到一个方向。
    /// The node does not exist or has no power, or only one direction was captured.
    Grd004 "GRD004" "guarded-node-absent" Info "-" [ErrorControl, Nmt] {
        message "被保护的节点从未出现" "guarded node never seen";
        Absent { requests: Count } "发出{requests}次节点保护请求, 记录中没有该节点的任何报文"
            "{requests|node guarding request|node guarding requests}, but no frame from the node";
    }

    /// NMT主站在节点寿命时间 (100Ch乘以100Dh) 内没有发送节点保护请求, 节点由此认为主站丢失 (寿命保护事件)。
    /// The NMT master sent no guarding request within the node life time (100Ch times 100Dh). The node considers the master lost (life guarding event).
    ///
    /// 主站停止, 太忙, 或者查询间隔长于节点的配置。
    /// The master has stopped, is busy, or polls less often than the node is configured for.
    Grd005 "GRD005" "life-guarding" Error "CiA 301 7.2.8.3.2.1" [ErrorControl, Nmt] {
        message "寿命保护" "life guarding";
        Expired { age: Ns, limit: Ns }
            "{age}没有节点保护请求, 超过节点寿命时间{limit}" "no node guarding request for {age} (node life time {limit})";
    }
}
