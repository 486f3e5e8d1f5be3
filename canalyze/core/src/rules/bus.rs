//! Rules about a bus as a whole: error frames (ISO 11898-1, fault confinement), by which the recording controller
//! reports its own state and that of its bus, and traffic that is not CANopen.

use crate::bytes::ns::Ns;

use super::quantity::{Count, Id, JsonOnly};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 记录所用的CAN控制器的发送错误计数达到256, 已脱离总线: 重启之前既不发送也不接收, 其间总线上的报文不在记录中。
    /// The recording CAN controller counted 256 transmit errors and went bus-off: until it is restarted it neither sends nor receives. Bus traffic in between is not in the capture.
    ///
    /// 短路或断线, 波特率不对, 缺少终端电阻, 或者总线上没有其他节点。
    /// A short circuit or broken wire, a wrong bit rate, missing termination, or no other node on the bus.
    Bus001 "BUS001" "bus-off" Error "ISO 11898-1" [Error] {
        message "总线关闭" "bus-off";
        BusOff { count: JsonOnly<Count> } "控制器进入总线关闭状态" "controller went bus-off";
        BusOffAfter { count: Count }
            "控制器进入总线关闭状态, 共{count}个错误帧" "controller went bus-off, {count|error frame|error frames}";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧" "{count|error frame|error frames} in total within {duration}";
        Unseen "控制器重新启动: 此前曾进入总线关闭状态, 但未录到" "controller restarted after a bus-off that is not in the capture";
    }

    /// 记录所用的CAN控制器的错误计数达到128: 有大量报文出错或未得到应答。控制器仍可发送, 但不再能破坏它认为错误的帧。
    /// An error counter of the recording CAN controller reached 128: many frames were faulty or not acknowledged. It can still send, but no longer destroys frames it considers faulty.
    ///
    /// 总线上没有其他节点, 波特率不对, 终端或屏蔽不良, 或者接触不良。
    /// No other node on the bus, the wrong bit rate, bad termination or shielding, or a loose contact.
    Bus002 "BUS002" "error-passive" Warning "ISO 11898-1" [Error] {
        message "错误被动" "error passive";
        ErrorPassive { count: JsonOnly<Count> } "控制器进入错误被动状态" "controller is error passive";
        ErrorPassiveAfter { count: Count }
            "控制器进入错误被动状态, 共{count}个错误帧" "controller is error passive, {count|error frame|error frames}";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧" "{count|error frame|error frames} in total within {duration}";
    }

    /// 记录所用的CAN控制器的错误计数达到96; 总线正常时应接近0。
    /// An error counter of the recording CAN controller reached 96; on a healthy bus it stays near 0.
    ///
    /// 接线不良或干扰使报文出错, 或者报文未得到应答。
    /// Faulty frames from bad wiring or interference, or frames that are not acknowledged.
    Bus003 "BUS003" "error-warning-level" Warning "ISO 11898-1" [Error] {
        message "错误计数达到警告水平" "error warning level reached";
        WarningLevel { count: JsonOnly<Count> } "错误计数达到警告水平" "error counter reached the warning level";
        WarningLevelAfter { count: Count }
            "错误计数达到警告水平, 共{count}个错误帧" "error counter reached the warning level, {count|error frame|error frames}";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧" "{count|error frame|error frames} in total within {duration}";
    }

    /// 任何正确收到报文的节点都会应答(ACK)。这里没有节点应答, 或者报文未能按时发出: 没有任何节点收到它。
    /// Every node that receives a frame correctly acknowledges it. No node did, or the frame could not be sent in time: no node received it.
    ///
    /// 总线上没有其他已上电的节点, 波特率不同, 断线, 或者总线一直被占用。
    /// No other powered node on the bus, another bit rate, a broken wire, or a bus that is always busy.
    Bus004 "BUS004" "not-transmitted" Warning "ISO 11898-1" [Error] {
        message "报文未能发出" "frame not transmitted";
        NotAcknowledged { count: JsonOnly<Count> } "报文没有节点应答(ACK)" "frame not acknowledged by any node";
        NotAcknowledgedOften { count: Count }
            "报文没有节点应答(ACK), 共{count}个错误帧" "frames not acknowledged by any node, {count|error frame|error frames}";
        TransmitTimeout { count: JsonOnly<Count> } "报文未能按时发出" "frame could not be transmitted in time";
        TransmitTimeouts { count: Count }
            "报文未能按时发出, 共{count}个错误帧" "frames could not be transmitted in time, {count|error frame|error frames}";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧" "{count|error frame|error frames} in total within {duration}";
    }

    /// 记录所用的CAN控制器没有空间存放报文: 收到的报文没有记录下来, 或者主机要发的报文没有发出。缺失处前后的关系不作判断。
    /// The recording CAN controller had no room for a frame: received frames are missing from the capture, or frames of the host were not sent. Nothing is judged across a loss.
    ///
    /// 主机太慢或太忙, 或者总线过载。
    /// The host is too slow or too busy, or the bus is overloaded.
    Bus005 "BUS005" "controller-overflow" Warning "-" [Error] {
        message "控制器缓冲区溢出" "controller buffer overflow";
        Receive { count: JsonOnly<Count> } "接收缓冲区溢出, 记录有缺失" "receive buffer overflow, frames are missing";
        ReceiveOften { count: Count }
            "接收缓冲区溢出{count}次, 记录有缺失" "receive buffer overflow ({count|time|times}), frames are missing";
        Transmit { count: JsonOnly<Count> } "发送缓冲区溢出" "transmit buffer overflow";
        TransmitOften { count: Count } "发送缓冲区溢出{count}次" "transmit buffer overflow ({count|time|times})";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧" "{count|error frame|error frames} in total within {duration}";
    }

    /// 记录所用的CAN控制器恢复到错误主动状态, 或者在总线关闭后重新启动。
    /// The recording CAN controller is error active again, or was restarted after bus-off.
    ///
    /// 总线故障已排除, 或者主机自动重启了控制器。
    /// The bus fault is gone, or the host restarts the controller automatically.
    Bus006 "BUS006" "controller-recovered" Info "ISO 11898-1" [Error] {
        message "控制器已恢复" "controller recovered";
        ErrorActive "控制器恢复到错误主动状态" "controller is error active again";
        Restarted "控制器重新启动" "controller restarted";
        ErrorActiveAfter { after: Ns } "{after}后控制器恢复到错误主动状态" "controller is error active again after {after}";
        RestartedAfter { after: Ns } "{after}后控制器重新启动" "controller restarted after {after}";
    }

    /// 有报文违反CAN协议 (位错误、填充错误、格式错误或CRC错误), 被错误帧破坏后由发送方重发。总线正常时几乎不会出现。
    /// A frame violated the CAN protocol (bit, stuff, form or CRC error) and was destroyed by an error frame; its sender repeats it. On a healthy bus this hardly ever happens.
    ///
    /// 干扰, 终端或屏蔽不良, 接触不良, 有节点的波特率不同, 或者刚接入节点。
    /// Interference, bad termination or shielding, a loose contact, a node with another bit rate, or one that was just plugged in.
    Bus007 "BUS007" "bus-error" Warning "ISO 11898-1" [Error] {
        message "总线错误" "bus error";
        BusError { count: JsonOnly<Count> } "总线错误" "bus error";
        BusErrors { count: Count } "{count}个总线错误" "{count|bus error|bus errors}";
        Unspecified { count: JsonOnly<Count> } "错误帧, 记录未注明类别" "error frame of unknown class (not in the capture)";
        UnspecifiedOften { count: Count }
            "{count}个错误帧, 记录未注明类别" "{count|error frame|error frames} of unknown class (not in the capture)";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧" "{count|error frame|error frames} in total within {duration}";
    }

    /// 记录所用的CAN控制器的收发器报告信号线断开或短路。
    /// The transceiver of the recording CAN controller reports an open or shorted wire.
    ///
    /// CANH或CANL断线, 两线相碰, 或者与地、电源短接。
    /// CANH or CANL is broken, or shorted to each other, to ground or to a supply.
    Bus008 "BUS008" "transceiver-fault" Warning "ISO 11898-3" [Error] {
        message "收发器故障" "transceiver fault";
        FaultyWire { count: JsonOnly<Count> } "收发器报告信号线故障" "transceiver reports a faulty wire";
        FaultyWireOften { count: Count }
            "收发器报告信号线故障, 共{count}个错误帧" "transceiver reports a faulty wire, {count|error frame|error frames}";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧" "{count|error frame|error frames} in total within {duration}";
    }

    /// 总线或该标识符上的报文不符合CANopen规定的服务(长度、命令字和取值), 也没有任何响应或启动报文能证明是CANopen, 因此不按CANopen判断。summary按CAN-ID列出这些报文。
    /// The frames of the bus, or of the identifier, do not have the lengths, commands and values of the service that CANopen assigns, and no response or boot-up proves CANopen: they are not judged as such. summary lists them by CAN-ID.
    ///
    /// 总线使用其他协议 (J1939、UDS/ISO-TP、OBD-II或制造商自定义协议), 或者其他设备占用了CANopen的标识符。
    /// Another protocol on the bus (J1939, UDS over ISO-TP, OBD-II, a proprietary one), or another device that uses CANopen's identifiers.
    Bus009 "BUS009" "not-canopen" Info "-" [Other] {
        message "不是CANopen报文" "not CANopen traffic";
        Bus { frames: Count } "{frames}帧中没有一帧能证明这条总线是CANopen: 不按CANopen判断"
            "nothing in {frames|frame|frames} shows that this bus is CANopen: not judged as such";
        Extended { frames: Count }
            "只有29位标识符 ({frames}帧), 不属于预定义连接集: 不是CANopen, 或者COB-ID的配置未录到"
            "only 29-bit identifiers ({frames|frame|frames}), outside the pre-defined connection set: not CANopen, or its COB-ID configuration is not in the capture";
        Identifier { id: Id, frames: Count } "{id}上的{frames}帧不符合CANopen为该标识符规定的服务: 不按该服务判断"
            "{frames|frame|frames} on {id} do not fit the service that CANopen assigns to it: not judged as such";
    }
}
