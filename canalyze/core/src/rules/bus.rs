//! Rules about a bus as such: error frames (ISO 11898-1, fault confinement), in which the controller that recorded speaks of
//! itself and of its bus, and traffic that is not CANopen.

use super::quantity::{Count, Id, JsonOnly, Ns};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// The recording controller is off the bus.
    Bus001 "BUS001" "bus-off" Error "ISO 11898-1" [Error] {
        message "总线关闭" "bus-off";
        meaning
            "记录所用的CAN控制器的发送错误计数达到256, 已脱离总线: 重启之前既不发送也不接收, 其间总线上的报文不在记录中。"
            "The CAN controller that recorded counted 256 transmit errors and has left the bus: until it is restarted it neither sends nor receives. What was on the bus meanwhile is not in the capture.";
        cause
            "短路或断线, 波特率不对, 缺少终端电阻, 或者总线上没有其他节点。"
            "A short circuit or an open wire, the wrong bit rate, a missing termination, or no other node on the bus.";
        BusOff { count: JsonOnly<Count> }
            "控制器进入总线关闭状态"
            "the controller is off the bus";
        BusOffAfter { count: Count }
            "控制器进入总线关闭状态, 共{count}个错误帧"
            "the controller is off the bus, {count} error frames";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧"
            "{count} error frames in all within {duration}";
        Unseen
            "控制器重新启动: 此前曾进入总线关闭状态, 但不在记录中"
            "the controller was restarted: it had been off the bus before, which is not in the capture";
    }

    /// The recording controller is error passive.
    Bus002 "BUS002" "error-passive" Warning "ISO 11898-1" [Error] {
        message "错误被动" "error passive";
        meaning
            "记录所用的CAN控制器的错误计数达到128: 有大量报文出错或无人应答。控制器仍可发送, 但不再能破坏它认为错误的帧。"
            "An error counter of the CAN controller that recorded has reached 128: so many frames were faulty, or acknowledged by nobody. It may still send, but no longer destroys frames that it sees as wrong.";
        cause
            "总线上没有其他节点, 波特率不对, 终端或屏蔽不良, 或者接触不良。"
            "No other node on the bus, the wrong bit rate, bad termination or shielding, or a loose contact.";
        ErrorPassive { count: JsonOnly<Count> }
            "控制器进入错误被动状态"
            "the controller is error passive";
        ErrorPassiveAfter { count: Count }
            "控制器进入错误被动状态, 共{count}个错误帧"
            "the controller is error passive, {count} error frames";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧"
            "{count} error frames in all within {duration}";
    }

    /// An error counter of the recording controller is at its warning level.
    Bus003 "BUS003" "error-warning-level" Warning "ISO 11898-1" [Error] {
        message "错误计数达到警告水平" "error warning level";
        meaning
            "记录所用的CAN控制器的错误计数达到96; 总线正常时应接近0。"
            "An error counter of the CAN controller that recorded has reached 96; on a sound bus it stays near 0.";
        cause
            "接线不良或干扰使报文出错, 或者报文无人应答。"
            "Faulty frames by bad wiring or disturbance, or frames that nobody acknowledges.";
        WarningLevel { count: JsonOnly<Count> }
            "错误计数达到警告水平"
            "an error counter is at the warning level";
        WarningLevelAfter { count: Count }
            "错误计数达到警告水平, 共{count}个错误帧"
            "an error counter is at the warning level, {count} error frames";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧"
            "{count} error frames in all within {duration}";
    }

    /// A frame was acknowledged by nobody, or could not be transmitted in time.
    Bus004 "BUS004" "not-transmitted" Warning "ISO 11898-1" [Error] {
        message "报文未能发出" "frame not transmitted";
        meaning
            "任何正确收到报文的节点都会应答。这里无人应答, 或者报文未能按时发出: 没有任何节点收到它。"
            "Any node that receives a frame without a fault acknowledges it. Nobody did, or the frame could not be sent in time: no partner has got it.";
        cause
            "总线上没有其他已上电的节点, 波特率不同, 断线, 或者总线一直被占用。"
            "No other node on the bus or in power, another bit rate, an open wire, or a bus that is always busy.";
        NotAcknowledged { count: JsonOnly<Count> }
            "报文无人应答"
            "a frame was acknowledged by nobody";
        NotAcknowledgedOften { count: Count }
            "报文无人应答, 共{count}个错误帧"
            "frames were acknowledged by nobody, {count} error frames";
        TransmitTimeout { count: JsonOnly<Count> }
            "报文未能按时发出"
            "a frame could not be transmitted in time";
        TransmitTimeouts { count: Count }
            "报文未能按时发出, 共{count}个错误帧"
            "frames could not be transmitted in time, {count} error frames";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧"
            "{count} error frames in all within {duration}";
    }

    /// A buffer of the recording controller overflowed.
    Bus005 "BUS005" "controller-overflow" Warning "-" [Error] {
        message "控制器缓冲区溢出" "overflow of the controller";
        meaning
            "记录所用的CAN控制器没有空间存放报文: 收到的报文没有记录下来, 或者主机要发的报文没有发出。跨越缺失处不作判断。"
            "The CAN controller that recorded had no room for a frame: received frames are missing from the capture, or frames that the host wanted to send were not sent. Across a loss nothing is judged.";
        cause
            "主机太慢或太忙, 或者总线过载。"
            "The host is too slow or too busy, or the bus is overloaded.";
        Receive { count: JsonOnly<Count> }
            "接收缓冲区溢出, 记录有缺失"
            "the receive buffer overflowed, frames are missing";
        ReceiveOften { count: Count }
            "接收缓冲区溢出{count}次, 记录有缺失"
            "the receive buffer overflowed {count} times, frames are missing";
        Transmit { count: JsonOnly<Count> }
            "发送缓冲区溢出"
            "the transmit buffer overflowed";
        TransmitOften { count: Count }
            "发送缓冲区溢出{count}次"
            "the transmit buffer overflowed {count} times";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧"
            "{count} error frames in all within {duration}";
    }

    /// The recording controller is error active again, or was restarted.
    Bus006 "BUS006" "controller-recovered" Info "ISO 11898-1" [Error] {
        message "控制器已恢复" "controller recovered";
        meaning
            "记录所用的CAN控制器恢复到错误主动状态, 或者在总线关闭后重新启动。"
            "The CAN controller that recorded is error active again, or was restarted after bus-off.";
        cause
            "总线故障已排除, 或者主机自动重启了控制器。"
            "The fault on the bus is over, or the host restarts the controller by itself.";
        ErrorActive
            "控制器恢复到错误主动状态"
            "the controller is error active again";
        Restarted
            "控制器重新启动"
            "the controller was restarted";
        ErrorActiveAfter { after: Ns }
            "{after}后控制器恢复到错误主动状态"
            "the controller is error active again after {after}";
        RestartedAfter { after: Ns }
            "{after}后控制器重新启动"
            "the controller was restarted after {after}";
    }

    /// A frame violated the CAN protocol.
    Bus007 "BUS007" "bus-error" Warning "ISO 11898-1" [Error] {
        message "总线错误" "bus error";
        meaning
            "有报文违反CAN协议 (位错误、填充错误、格式错误或CRC错误), 被错误帧破坏, 由发送者重发。总线正常时几乎不会出现。"
            "A frame violated the CAN protocol (bit, stuff, form or CRC error) and was destroyed by an error frame; its sender repeats it. On a sound bus this hardly ever happens.";
        cause
            "干扰, 终端或屏蔽不良, 接触不良, 有节点的波特率不同, 或者刚刚插入节点。"
            "Disturbance, bad termination or shielding, a loose contact, a node with another bit rate, or one that was just plugged in.";
        BusError { count: JsonOnly<Count> }
            "总线错误"
            "a bus error";
        BusErrors { count: Count }
            "{count}个总线错误"
            "{count} bus errors";
        Unspecified { count: JsonOnly<Count> }
            "错误帧, 记录中没有说明类别"
            "an error frame; the capture does not say of which kind";
        UnspecifiedOften { count: Count }
            "{count}个错误帧, 记录中没有说明类别"
            "{count} error frames; the capture does not say of which kind";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧"
            "{count} error frames in all within {duration}";
    }

    /// The transceiver reports a faulty wire.
    Bus008 "BUS008" "transceiver-fault" Warning "ISO 11898-3" [Error] {
        message "收发器故障" "fault of the transceiver";
        meaning
            "记录所用的CAN控制器的收发器报告信号线断开或短路。"
            "The transceiver of the CAN controller that recorded reports a wire that is open or shorted.";
        cause
            "CANH或CANL断线, 两线相碰, 或者与地、电源短接。"
            "CANH or CANL is broken, or touches the other one, ground or a supply.";
        FaultyWire { count: JsonOnly<Count> }
            "收发器报告信号线故障"
            "the transceiver reports a faulty wire";
        FaultyWireOften { count: Count }
            "收发器报告信号线故障, 共{count}个错误帧"
            "the transceiver reports a faulty wire, {count} error frames";
        InAll { count: Count, duration: Option<Ns> }
            "{duration}内共{count}个错误帧"
            "{count} error frames in all within {duration}";
    }

    /// The traffic of a bus, or of an identifier, is not CANopen.
    Bus009 "BUS009" "not-canopen" Info "-" [Other] {
        message "不是CANopen报文" "traffic that is not CANopen";
        meaning
            "总线或该标识符上的报文不符合CANopen规定的服务(长度、命令字和取值), 也没有任何应答或启动报文能证明是CANopen; 因此不按CANopen判断。summary按CAN-ID列出这些报文。"
            "The frames of the bus, or of the identifier, do not have the lengths, commands and values of the service that CANopen assigns, and no answer or boot-up shows that they are CANopen: they are not judged as such. summary lists them by CAN-ID.";
        cause
            "总线使用其他协议 (J1939、UDS/ISO-TP、OBD-II或厂商自定义协议), 或者其他设备占用了CANopen的标识符。"
            "Another protocol on the bus (J1939, UDS over ISO-TP, OBD-II, a maker's own), or another device that uses CANopen's identifiers.";
        Bus { frames: Count }
            "{frames}帧中没有任何一帧能证明这条总线是CANopen: 不按CANopen判断"
            "nothing in the {frames} frames shows that this bus is CANopen: they are not judged as such";
        Extended { frames: Count }
            "只有29位标识符 ({frames}帧), 预定义连接集中没有: 不是CANopen, 或者COB-ID的配置不在记录中"
            "only 29-bit identifiers ({frames} frames), of which the pre-defined connection set has none: not CANopen, or the capture does not have its COB-IDs";
        Identifier { id: Id, frames: Count }
            "{id}上的{frames}帧不是CANopen为该标识符规定的服务: 不按它判断"
            "the {frames} frames on {id} are not those of the service that CANopen assigns to it: they are not judged as such";
    }
}
