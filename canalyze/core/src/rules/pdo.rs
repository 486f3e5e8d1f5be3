//! Rules about PDOs and MPDOs (CiA 301, 7.2.2): length, state, times and configuration.

use super::quantity::{Count, Id, Ns, Pdo, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// A multiplex PDO has another length than 8 bytes.
    Mpd001 "MPD001" "mpdo-length" Warning "CiA 301 7.2.2.4" one [Pdo] {
        message "MPDO长度不是8字节" "MPDO is not 8 bytes long";
        meaning
            "MPDO总是8字节: 地址1字节, 索引和子索引3字节, 数据4字节; 其他长度的帧无法解释。"
            "An MPDO always has 8 bytes: one of address, three of index and sub-index, four of data. Another length has no meaning.";
        cause
            "发送方实现有误, 或者该标识符上还有别的报文。"
            "A fault of the sender, or something else on the same identifier.";
        Length { found: Count }
            "MPDO长度为{found}字节, 应为8字节"
            "MPDO length {found} instead of 8 (in bytes)";
    }

    /// A PDO is shorter than its mapping.
    Pdo001 "PDO001" "pdo-too-short" Error "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "PDO短于其映射" "PDO is shorter than its mapping";
        meaning
            "数据比映射的对象短时, 接收方不处理该PDO, 并可发送紧急报文8210h。"
            "A receiver does not process a PDO that is shorter than what is mapped, and may send emergency 8210h.";
        cause
            "发送方的DLC或映射有误, 两侧的映射不一致, 或者映射改变后发送方仍按旧映射发送。"
            "The sender's DLC or mapping is wrong, the mappings of both sides differ, or the sender keeps to an old mapping.";
        Length { found: Count, mapped: Count }
            "PDO为{found}字节, 映射需要{mapped}字节"
            "PDO length {found}, its mapping needs {mapped} (in bytes)";
        OfConsumer { found: Count, mapped: Count, consumer: Count, pdo: Pdo }
            "PDO为{found}字节, 节点{consumer}的{pdo}的映射需要{mapped}字节"
            "PDO length {found}, the mapping of node {consumer}'s {pdo} needs {mapped} (in bytes)";
    }

    /// A TPDO of a node that is not Operational.
    Pdo002 "PDO002" "tpdo-when-not-operational" Error "CiA 301 7.3.2.2" one [Pdo, ErrorControl, Nmt] {
        message "TPDO在非操作状态发送" "TPDO of a node that is not Operational";
        meaning
            "PDO只存在于操作状态; 切换时已在途中的帧不算。有多个TPDO时只说第一个, 每次处于该状态只说一次。"
            "PDOs exist in Operational only; frames under way when the state changed do not count. Of several TPDOs the first one is told of, once a stay in the state.";
        cause
            "协议栈没有按状态停止PDO, 缺少启动命令, 或者另一个节点使用了这个COB-ID。"
            "The stack does not stop PDOs with the state, the command to start is missing, or another node uses this COB-ID.";
        InState { pdo: Pdo, state: State }
            "节点处于{state}状态时发送了{pdo}"
            "{pdo} of a node that is {state}";
    }

    /// An RPDO to a node that is not Operational.
    Pdo003 "PDO003" "rpdo-to-not-operational" Info "CiA 301 7.3.2.2" one [Pdo, ErrorControl, Nmt] {
        message "RPDO发给非操作状态的节点" "RPDO to a node that is not Operational";
        meaning
            "节点只在操作状态处理RPDO, 此时的数据被忽略。"
            "A node processes RPDOs in Operational only; these data are ignored.";
        cause
            "主站在启动节点之前就循环发送RPDO; 通常无害。"
            "The master sends RPDOs in cycles before it starts the node; usually harmless.";
        InState { pdo: Pdo, state: State }
            "节点处于{state}状态, {pdo}被忽略"
            "the node is {state} and ignores {pdo}";
    }

    /// An event-driven TPDO within its inhibit time.
    Pdo004 "PDO004" "inhibit-time" Warning "CiA 301 7.5.2.37" one here [Pdo] {
        message "抑制时间未到就再次发送" "sent again within the inhibit time";
        meaning
            "事件驱动的TPDO两次发送之间至少相隔抑制时间(通信参数子索引03h, 单位100µs); 对远程请求的应答不算。"
            "Between two transmissions of an event-driven TPDO lies at least its inhibit time (sub-index 03h of the communication parameter, in 100 us); answers to remote frames excepted.";
        cause
            "设备没有实现抑制时间, 单位弄错, 或者抑制时间在PDO有效时被改写。"
            "The device does not implement the inhibit time, its unit was mistaken, or it was written while the PDO was valid.";
        TooClose { found: Ns, limit: Ns, tolerance: Ns }
            "间隔{found}, 抑制时间为{limit} (容差{tolerance})"
            "gap of {found}, inhibit time {limit} (tolerance {tolerance})";
    }

    /// An event-driven TPDO does not come though its event timer has run out.
    Pdo005 "PDO005" "event-timer-late" Warning "CiA 301 7.5.2.37" one [Pdo] {
        message "事件定时器到期而PDO没有发送" "event timer has run out and the PDO does not come";
        meaning
            "节点处于操作状态, 事件定时器(通信参数子索引05h, 单位ms)到期后TPDO仍未发送: 超过1.5倍时间。"
            "The node is operational, and its TPDO was not sent though the event timer (sub-index 05h of the communication parameter, in ms) has run out by half of its time.";
        cause
            "设备太忙, 固件停止了发送, 或者记录中丢帧。"
            "The device is too busy, its firmware stopped sending, or a frame is missing from the capture.";
        Overdue { found: Ns, limit: Ns }
            "已{found}没有发送, 事件定时器为{limit}"
            "not sent for {found}, event timer {limit}";
    }

    /// A PDO is longer than its mapping.
    Pdo006 "PDO006" "pdo-too-long" Warning "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "PDO长于其映射" "PDO is longer than its mapping";
        meaning
            "多出的字节被接收方忽略; 接收方可发送紧急报文8220h。"
            "Receivers ignore the bytes beyond the mapping; they may send emergency 8220h.";
        cause
            "发送方总是发送8字节, 或者两侧的映射不一致。"
            "The sender always sends 8 bytes, or the mappings of both sides differ.";
        Length { found: Count, mapped: Count }
            "PDO为{found}字节, 映射只有{mapped}字节"
            "PDO length {found}, its mapping has only {mapped} (in bytes)";
        OfConsumer { found: Count, mapped: Count, consumer: Count, pdo: Pdo }
            "PDO为{found}字节, 节点{consumer}的{pdo}的映射只有{mapped}字节"
            "PDO length {found}, the mapping of node {consumer}'s {pdo} has only {mapped} (in bytes)";
    }

    /// A reserved transmission type was written and acknowledged.
    Pdo008 "PDO008" "reserved-transmission-type" Warning "CiA 301 7.5.2.35, 7.5.2.37" [Sdo] {
        message "写入了保留的传输类型" "reserved transmission type written";
        meaning
            "TPDO的传输类型241到251保留, RPDO的241到253保留; 设备应以06090030h拒绝, 却确认了写入。"
            "Transmission types 241 to 251 of a TPDO and 241 to 253 of an RPDO are reserved; the device should refuse them with 06090030h but acknowledged the write.";
        cause
            "配置有误, 设备不检查该值; 该PDO何时发送或生效没有定义。"
            "A mistake in the configuration that the device does not check; when the PDO is sent or takes effect is not defined.";
        Tpdo { found: Count }
            "TPDO的传输类型{found}是保留值, 设备却接受了"
            "the reserved transmission type {found} of a TPDO was accepted";
        Rpdo { found: Count }
            "RPDO的传输类型{found}是保留值, 设备却接受了"
            "the reserved transmission type {found} of an RPDO was accepted";
    }

    /// The mapping of a valid PDO was changed.
    Pdo009 "PDO009" "mapping-changed-while-valid" Warning "CiA 301 7.5.2.36, 7.5.2.38" [Sdo] {
        message "PDO有效时修改了映射" "mapping changed while the PDO is valid";
        meaning
            "修改映射前应先把COB-ID的位31置1使PDO无效, 再把映射的子索引00h写0。否则修改期间的PDO是新旧混合的。"
            "Before its mapping changes, a PDO is made invalid (bit 31 of the COB-ID = 1) and sub-index 00h of the mapping is set to 0. Otherwise PDOs sent meanwhile are a mixture of old and new.";
        cause
            "配置程序跳过了使PDO无效这一步; 设备不检查, 多数协议栈会拒绝。"
            "The configuring program leaves out the step that makes the PDO invalid, and the device does not check; most stacks refuse.";
        InUse { pdo: Pdo }
            "{pdo}仍有效(COB-ID位31=0), 映射也在使用中, 却修改了映射"
            "mapping changed though {pdo} is valid (bit 31 of the COB-ID = 0) and the mapping in use";
        Disabled { pdo: Pdo }
            "{pdo}仍有效(COB-ID位31=0), 只把映射的子索引00h写了0就修改映射"
            "mapping changed though {pdo} is valid (bit 31 of the COB-ID = 0); only sub-index 00h of the mapping was set to 0";
    }

    /// The identifier of a valid PDO was changed.
    Pdo010 "PDO010" "cob-id-changed-while-valid" Warning "CiA 301 7.5.2.35, 7.5.2.37" [Sdo] {
        message "PDO有效时修改了CAN-ID" "CAN-ID changed while the PDO is valid";
        meaning
            "PDO有效(位31=0)时不得改变COB-ID的位0到29: 应先写入位31=1, 再写入新的COB-ID。"
            "Bits 0 to 29 of the COB-ID shall not change while the PDO is valid (bit 31 = 0): first bit 31 = 1 is written, then the new COB-ID.";
        cause
            "配置程序跳过了使PDO无效这一步; 设备不检查, 多数协议栈会以06090030h拒绝。"
            "The configuring program leaves out the step that makes the PDO invalid, and the device does not check; most stacks refuse with 06090030h.";
        Changed { old: Id, found: Id }
            "CAN-ID从{old}直接改为{found}, 没有先使PDO无效"
            "CAN-ID changed from {old} to {found} without making the PDO invalid first";
    }

    /// A remote frame for a TPDO that allows none.
    Pdo011 "PDO011" "rtr-not-allowed" Warning "CiA 301 7.5.2.37" one [Pdo] {
        message "对不允许远程请求的TPDO发送远程帧" "remote frame for a TPDO that allows none";
        meaning
            "该TPDO的COB-ID位30=1: 不允许远程请求, 设备不会应答。"
            "Bit 30 of the TPDO's COB-ID is 1: no remote frames are allowed, and the device does not answer.";
        cause
            "主站按轮询方式配置, 而设备的COB-ID中位30=1。"
            "The master polls, but bit 30 is set in the device's COB-ID.";
        Remote { pdo: Pdo, id: Id }
            "{pdo} ({id})的COB-ID位30=1, 不允许远程请求"
            "bit 30 of the COB-ID of {pdo} ({id}) is 1: remote frames are not allowed";
    }

    /// A PDO is not as long as the EDS's default mapping.
    Pdo012 "PDO012" "pdo-length-differs-from-eds" Warning "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "PDO长度与EDS的默认映射不符" "PDO length differs from the EDS's default mapping";
        meaning
            "只有EDS给出了该PDO的映射, 此前的帧与它相符, 而这一帧的长度不符: 信号的解释不可信。"
            "Only an EDS tells the mapping of this PDO; it kept to that before, but this frame is not as long: its signals are not to be trusted.";
        cause
            "发送方的DLC有误, 设备存有另外的映射, 或者EDS不是这台设备的。可用DCF, 或把配置过程也记录下来。"
            "The sender's DLC is wrong, the device has stored another mapping, or the EDS is not of this device. A DCF helps, or a capture that has the configuration.";
        Length { found: Count, mapped: Count }
            "PDO为{found}字节, EDS的默认映射为{mapped}字节: 此前该PDO与它相符"
            "PDO length {found}, the EDS's default mapping has {mapped} (in bytes), which the PDO kept to before";
    }

    /// An RPDO does not come within its deadline.
    Pdo013 "PDO013" "rpdo-deadline" Info "CiA 301 7.5.2.35" one [Pdo] {
        message "RPDO超过了接收期限" "RPDO beyond its deadline";
        meaning
            "RPDO的通信参数子索引05h是接收期限(ms); 超过它节点可发送紧急报文8250h。"
            "Sub-index 05h of an RPDO's communication parameter is its deadline in ms; beyond it the node may send emergency 8250h.";
        cause
            "发送方停止发送或周期太长。"
            "The sender stopped or its period is too long.";
        Overdue { found: Ns, limit: Ns }
            "已{found}没有收到, 期限为{limit}"
            "not received for {found}, deadline {limit}";
    }

    /// A restricted CAN-ID was configured.
    Pdo014 "PDO014" "restricted-cob-id" Warning "CiA 301 7.3.5" [Sdo] {
        message "配置了受限的CAN-ID" "restricted CAN-ID configured";
        meaning
            "000到07F, 101到180, 581到5FF, 601到67F, 6E0到6FF, 701到7FF保留给固定的服务, 不得配置给别的对象; 设备却确认了写入。"
            "000 to 07F, 101 to 180, 581 to 5FF, 601 to 67F, 6E0 to 6FF and 701 to 7FF are kept for fixed services and shall not be configured; the device acknowledged the write.";
        cause
            "COB-ID算错, 设备不检查。"
            "A COB-ID was miscalculated, and the device does not check.";
        Restricted { id: Id }
            "CAN-ID {id}受限, 不得配置, 设备却接受了"
            "CAN-ID {id} is restricted but was accepted";
    }

    /// A PDO without mapped objects is sent.
    Pdo015 "PDO015" "mapping-empty" Info "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "没有映射对象的PDO" "PDO without mapped objects";
        meaning
            "该PDO的映射为空(子索引00h为0), 但总线上有它的数据帧, 无法解释。"
            "The mapping of the PDO is empty (sub-index 00h is 0), but there are data frames of it, which have no meaning.";
        cause
            "映射正在修改, 或者设备在记录开始之前已被重新配置。"
            "The mapping is being changed, or the device was configured before the capture began.";
        Empty { pdo: Pdo, id: Id }
            "{pdo}的映射为空, 标识符{id}上却有数据"
            "the mapping of {pdo} is empty, but there are data on {id}";
        EmptyInDescription { pdo: Pdo, id: Id }
            "按设备描述{pdo}的映射为空, 标识符{id}上却有数据"
            "by the description the mapping of {pdo} is empty, but there are data on {id}";
    }

    /// A mapping of more bits than a frame holds was acknowledged.
    Pdo016 "PDO016" "mapping-too-long" Error "CiA 301 7.5.2.36, 7.5.2.38" [Sdo] {
        message "映射超过8字节" "mapping of more than 8 bytes";
        meaning
            "映射各项的位数之和超过64位, 一帧放不下; 设备应以06040042h拒绝, 却确认了写入。"
            "The entries of the mapping have more than 64 bits together, which no frame holds; the device should refuse with 06040042h but acknowledged the write.";
        cause
            "映射长度算错, 设备不检查。"
            "The lengths were miscalculated, and the device does not check.";
        Bits { found: Count }
            "映射共{found}位, 一帧最多64位, 设备却接受了"
            "mapping of {found} bits was accepted, a frame holds 64";
    }

    /// A TPDO is sent though it was made invalid.
    Pdo018 "PDO018" "disabled-pdo-sent" Warning "CiA 301 7.5.2.37" one [Pdo] {
        message "已禁用的TPDO仍在发送" "disabled TPDO is sent";
        meaning
            "COB-ID的位31=1使TPDO无效后, 该标识符上仍有数据帧。"
            "The TPDO was made invalid with bit 31 of its COB-ID, but there are still data frames on its identifier.";
        cause
            "设备没有按位31停止发送, 或者另一个节点在使用该标识符。"
            "The device does not stop sending with bit 31, or another node uses the identifier.";
        Sent { pdo: Pdo, id: Id }
            "{pdo}已被设为无效, 标识符{id}上仍有数据"
            "{pdo} was made invalid, but there are still data on {id}";
    }

    /// A PDO is on the bus that its receiver or its description has disabled.
    Pdo019 "PDO019" "disabled-pdo-on-bus" Info "CiA 301 7.5.2.35, 7.5.2.37" one [Pdo] {
        message "总线上有被禁用的PDO" "disabled PDO on the bus";
        meaning
            "接收方禁用了该RPDO, 或者设备描述中该PDO无效, 但总线上有它的数据帧。"
            "The receiver has disabled the RPDO, or the description has the PDO invalid, but there are data frames of it.";
        cause
            "设备在记录开始之前已被重新配置; 或者接收方正在重新配置, 这些数据不起作用。"
            "The device was configured before the capture began; or the receiver is being configured, and the data have no effect.";
        DisabledInDescription { pdo: Pdo, id: Id }
            "按设备描述{pdo}是禁用的, 标识符{id}上却有数据"
            "by the description {pdo} is disabled, but there are data on {id}";
        Disabled { pdo: Pdo, id: Id }
            "{pdo}已被设为无效, 标识符{id}上的数据不起作用"
            "{pdo} was made invalid: the data on {id} have no effect";
    }

    /// Two TPDOs are configured to one CAN-ID.
    Pdo020 "PDO020" "shared-cob-id" Warning "CiA 301 7.3.5, 7.5.2.37" one [Pdo, Sdo] {
        message "两个TPDO使用同一CAN-ID" "two TPDOs with one CAN-ID";
        meaning
            "每个CAN-ID只能有一个发送者。两个TPDO配置为同一CAN-ID时, 接收方无法区分其数据, 两个节点同时发送还会产生错误帧。"
            "A CAN-ID has one sender. Where two TPDOs are configured to the same one, receivers cannot tell their data apart, and two nodes that send at the same time cause error frames.";
        cause
            "COB-ID写错, 两个节点用了同一份配置, 或者设备描述中的COB-ID没有按节点ID计算。"
            "A mistyped COB-ID, two nodes with the same configuration, or a device description whose COB-IDs do not follow the node-ID.";
        Shared { pdo: Pdo, id: Id, other: Pdo, of: Count }
            "{pdo}的CAN-ID {id}也是节点{of}的{other}的CAN-ID"
            "{pdo} has CAN-ID {id}, which is that of {other} of node {of}, too";
    }
}
