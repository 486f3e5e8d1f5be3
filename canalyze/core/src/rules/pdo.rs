//! Rules about PDOs and MPDOs (CiA 301, 7.2.2): length, state, times and configuration.

use crate::bytes::ns::Ns;

use super::quantity::{Count, Id, Pdo, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// MPDO固定为8字节: 地址1字节, 索引和子索引3字节, 数据4字节; 其他长度的帧无法解释。
    /// An MPDO is always 8 bytes long: 1 of address, 3 of index and sub-index, 4 of data. Other lengths cannot be decoded.
    ///
    /// 发送方实现有误, 或者该标识符上还有其他报文。
    /// A bug in the sender, or another protocol on the same identifier.
    Mpd001 "MPD001" "mpdo-length" Warning "CiA 301 7.2.2.4" one [Pdo] {
        message "MPDO长度不是8字节" "MPDO is not 8 bytes long";
        Length { found: Count } "MPDO长度为{found}字节, 应为8字节" "MPDO is {found|byte|bytes} long, expected 8";
    }

    /// 数据比映射的对象短时, 接收方不处理该PDO, 并可发送紧急报文8210h。
    /// A receiver does not process a PDO shorter than its mapping, and may send EMCY 8210h.
    ///
    /// 发送方的DLC或映射有误, 两侧的映射不一致, 或者映射改变后发送方仍按旧映射发送。
    /// The sender's DLC or mapping is wrong, the mappings of both sides differ, or the sender still uses an old mapping.
    Pdo001 "PDO001" "pdo-too-short" Error "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "PDO短于其映射" "PDO is shorter than its mapping";
        Length { found: Count, mapped: Count }
            "PDO为{found}字节, 映射需要{mapped}字节" "PDO is {found|byte|bytes}, its mapping needs {mapped}";
        OfConsumer { found: Count, mapped: Count, consumer: Count, pdo: Pdo }
            "PDO为{found}字节, 节点{consumer}的{pdo}的映射需要{mapped}字节"
            "PDO is {found|byte|bytes}, the mapping of node {consumer}'s {pdo} needs {mapped}";
    }

    /// 只有操作状态才允许PDO; 状态切换时已在发送途中的帧不计。多个TPDO只报告第一个, 每次处于该状态只报告一次。
    /// PDOs are allowed in Operational only; frames already in flight when the state changed do not count. Of several TPDOs the first is reported, once per stay in the state.
    ///
    /// 协议栈没有按状态停止PDO, 缺少启动命令, 或者另一个节点使用了这个COB-ID。
    /// The stack does not stop PDOs with the state, the start command is missing, or another node uses this COB-ID.
    Pdo002 "PDO002" "tpdo-when-not-operational" Error "CiA 301 7.3.2.2" one [Pdo, ErrorControl, Nmt] {
        message "在非操作状态下发送TPDO" "TPDO from a node that is not Operational";
        InState { pdo: Pdo, state: State } "节点处于{state}时发送了{pdo}" "{pdo} from a node that is {state}";
    }

    /// 节点只在操作状态处理RPDO, 此时的数据被忽略。
    /// A node processes RPDOs in Operational only; these data are ignored.
    ///
    /// 主站在启动节点之前就循环发送RPDO; 通常无害。
    /// The master sends cyclic RPDOs before it starts the node; usually harmless.
    Pdo003 "PDO003" "rpdo-to-not-operational" Info "CiA 301 7.3.2.2" one [Pdo, ErrorControl, Nmt] {
        message "RPDO发给非操作状态的节点" "RPDO to a node that is not Operational";
        InState { pdo: Pdo, state: State } "节点处于{state}, {pdo}被忽略" "node is {state}, {pdo} ignored";
    }

    /// 事件驱动的TPDO两次发送之间至少相隔抑制时间(通信参数子索引03h, 单位100 µs); 对远程请求的响应不计。
    /// Two transmissions of an event-driven TPDO must be at least the inhibit time apart (sub-index 03h of the communication parameter, unit 100 µs); responses to remote frames are exempt.
    ///
    /// 设备没有实现抑制时间, 单位弄错, 或者抑制时间在PDO有效时被改写。
    /// The device does not implement the inhibit time, its unit was misread, or it was written while the PDO was valid.
    Pdo004 "PDO004" "inhibit-time" Warning "CiA 301 7.5.2.37" one here [Pdo] {
        message "抑制时间内再次发送" "sent again within the inhibit time";
        TooClose { found: Ns, limit: Ns, tolerance: Ns } "距上一帧{found}, 小于抑制时间{limit}(容差{tolerance})"
            "{found} after the previous one (inhibit time {limit}, tolerance {tolerance})";
    }

    /// 节点处于操作状态, 事件定时器(通信参数子索引05h, 单位ms)到期后TPDO仍未发送: 超过1.5倍时间。事件定时器未知时, 以数据不变时的最长间隔为准: 超过10倍且至少1 s, 节点仍在发送错误控制报文。
    /// The node is Operational, but its TPDO was not sent for 1.5 times the event timer (sub-index 05h of the communication parameter, in ms). If that is unknown, for 10 times the longest gap before frames without a change, at least 1 s, while the node gives signs of life.
    ///
    /// 设备太忙, 固件停止了发送, 或者记录中丢帧。
    /// The device is overloaded, its firmware stopped sending, or a frame is missing from the capture.
    Pdo005 "PDO005" "event-timer-late" Warning "CiA 301 7.5.2.37" one [Pdo] {
        message "事件定时器到期而PDO没有发送" "event timer expired without the PDO";
        Overdue { found: Ns, limit: Ns } "已{found}没有发送(事件定时器{limit})" "not sent for {found} (event timer {limit})";
        Stopped { found: Ns, limit: Ns } "已{found}没有发送(此前最长间隔{limit})"
            "not sent for {found} (before, {limit} at most)";
    }

    /// 多出的字节被接收方忽略; 接收方可发送紧急报文8220h。
    /// Receivers ignore the bytes beyond the mapping and may send EMCY 8220h.
    ///
    /// 发送方总是发送8字节, 或者两侧的映射不一致。
    /// The sender always sends 8 bytes, or the mappings of both sides differ.
    Pdo006 "PDO006" "pdo-too-long" Warning "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "PDO长于其映射" "PDO is longer than its mapping";
        Length { found: Count, mapped: Count }
            "PDO为{found}字节, 映射只有{mapped}字节" "PDO is {found|byte|bytes}, its mapping has only {mapped}";
        OfConsumer { found: Count, mapped: Count, consumer: Count, pdo: Pdo }
            "PDO为{found}字节, 节点{consumer}的{pdo}的映射只有{mapped}字节"
            "PDO is {found|byte|bytes}, the mapping of node {consumer}'s {pdo} has only {mapped}";
    }

    /// TPDO的传输类型241到251保留, RPDO的241到253保留; 设备应以中止码06090030h拒绝, 却接受了写入。
    /// Transmission types 241 to 251 of a TPDO and 241 to 253 of an RPDO are reserved; the device should refuse them with 06090030h but accepted the write.
    ///
    /// 配置有误, 设备不检查该值; 该PDO何时发送或生效没有定义。
    /// A configuration error that the device does not check; when the PDO is sent or takes effect is undefined.
    Pdo008 "PDO008" "reserved-transmission-type" Warning "CiA 301 7.5.2.35, 7.5.2.37" [Sdo] {
        message "写入了保留的传输类型" "reserved transmission type written";
        Tpdo { found: Count } "TPDO的传输类型{found}是保留值, 设备却接受了" "reserved TPDO transmission type {found} was accepted";
        Rpdo { found: Count } "RPDO的传输类型{found}是保留值, 设备却接受了" "reserved RPDO transmission type {found} was accepted";
    }

    /// 修改映射前应先把COB-ID的位31置1使PDO无效, 再把映射的子索引00h写0; 否则修改期间的PDO会新旧混杂。
    /// Before the mapping is changed, the PDO must be made invalid (bit 31 of the COB-ID = 1) and sub-index 00h of the mapping set to 0. Otherwise PDOs sent in between mix old and new mapping.
    ///
    /// 配置程序漏掉了使PDO无效这一步, 设备也不检查; 多数协议栈会拒绝。
    /// The configuration tool skips making the PDO invalid, and the device does not check; most stacks refuse.
    Pdo009 "PDO009" "mapping-changed-while-valid" Warning "CiA 301 7.5.2.36, 7.5.2.38" [Sdo] {
        message "PDO有效时修改了映射" "mapping changed while the PDO is valid";
        InUse { pdo: Pdo } "{pdo}仍有效(COB-ID位31=0), 映射也在使用中, 却修改了映射"
            "mapping changed while {pdo} is valid (COB-ID bit 31 = 0) and the mapping in use";
        Disabled { pdo: Pdo } "{pdo}仍有效(COB-ID位31=0), 只把映射的子索引00h写了0就修改映射"
            "mapping changed while {pdo} is valid (COB-ID bit 31 = 0); only sub-index 00h of the mapping was set to 0";
    }

    /// PDO有效(位31=0)时不得改变COB-ID的位0到29: 应先写入位31=1, 再写入新的COB-ID。
    /// Bits 0 to 29 of the COB-ID must not change while the PDO is valid (bit 31 = 0): write bit 31 = 1 first, then the new COB-ID.
    ///
    /// 配置程序漏掉了使PDO无效这一步, 设备也不检查; 多数协议栈会以06090030h拒绝。
    /// The configuration tool skips making the PDO invalid, and the device does not check; most stacks refuse with 06090030h.
    Pdo010 "PDO010" "cob-id-changed-while-valid" Warning "CiA 301 7.5.2.35, 7.5.2.37" [Sdo] {
        message "PDO有效时修改了CAN-ID" "CAN-ID changed while the PDO is valid";
        Changed { old: Id, found: Id } "CAN-ID从{old}直接改为{found}, 没有先使PDO无效"
            "CAN-ID changed from {old} to {found} without making the PDO invalid first";
    }

    /// 该TPDO的COB-ID位30=1: 不允许远程请求, 设备不会响应。
    /// Bit 30 of the TPDO's COB-ID is 1: remote frames are not allowed, and the device does not respond.
    ///
    /// 主站按轮询方式配置, 而设备的COB-ID中位30=1。
    /// The master is configured for polling, but bit 30 of the device's COB-ID is 1.
    Pdo011 "PDO011" "rtr-not-allowed" Warning "CiA 301 7.5.2.37" one [Pdo] {
        message "对不允许远程请求的TPDO发送远程帧" "remote frame for a TPDO that allows none";
        Remote { pdo: Pdo, id: Id }
            "{pdo} ({id})的COB-ID位30=1, 不允许远程请求" "COB-ID bit 30 of {pdo} ({id}) is 1: remote frames are not allowed";
    }

    /// 只有EDS给出了该PDO的映射, 此前的帧与其相符, 而这一帧的长度不符: 信号的解释不可信。
    /// The mapping of this PDO is known from an EDS only; earlier frames fit it, but this one has another length: its decoded signals are unreliable.
    ///
    /// 发送方的DLC有误, 设备存有另外的映射, 或者EDS不是这台设备的。可用DCF, 或把配置过程也记录下来。
    /// The sender's DLC is wrong, the device has stored another mapping, or the EDS is for another device. Use a DCF, or capture the configuration as well.
    Pdo012 "PDO012" "pdo-length-differs-from-eds" Warning "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "PDO长度与EDS的默认映射不符" "PDO length differs from the EDS's default mapping";
        Length { found: Count, mapped: Count } "PDO为{found}字节, EDS的默认映射为{mapped}字节, 此前该PDO与其相符"
            "PDO is {found|byte|bytes}, the EDS's default mapping has {mapped}, which fit until now";
    }

    /// RPDO的通信参数子索引05h为接收期限(ms); 超时后节点可发送紧急报文8250h。
    /// Sub-index 05h of an RPDO's communication parameter is its deadline in ms; after it the node may send EMCY 8250h.
    ///
    /// 发送方停止发送或周期太长。
    /// The sender stopped or its period is too long.
    Pdo013 "PDO013" "rpdo-deadline" Info "CiA 301 7.5.2.35" one [Pdo] {
        message "RPDO超过接收期限" "RPDO missed its deadline";
        Overdue { found: Ns, limit: Ns } "已{found}没有收到(期限{limit})" "not received for {found} (deadline {limit})";
    }

    /// 000到07F, 101到180, 581到5FF, 601到67F, 6E0到6FF, 701到7FF保留给固定的服务, 不得配置给其他对象; 设备却接受了写入。
    /// 000 to 07F, 101 to 180, 581 to 5FF, 601 to 67F, 6E0 to 6FF and 701 to 7FF are reserved for fixed services and must not be configured; the device accepted the write.
    ///
    /// COB-ID算错, 设备也不检查。
    /// A COB-ID was miscalculated, and the device does not check.
    Pdo014 "PDO014" "restricted-cob-id" Warning "CiA 301 7.3.5" [Sdo] {
        message "配置了受限的CAN-ID" "restricted CAN-ID configured";
        Restricted { id: Id } "CAN-ID {id}受限, 不得配置, 设备却接受了" "CAN-ID {id} is restricted but was accepted";
    }

    /// 该PDO的映射为空(子索引00h为0), 总线上却有它的数据帧, 无法解释。
    /// The mapping of the PDO is empty (sub-index 00h is 0), but there are data frames of it, which cannot be decoded.
    ///
    /// 映射正在修改, 或者设备在记录开始之前已被重新配置。
    /// The mapping is being changed, or the device was configured before the capture began.
    Pdo015 "PDO015" "mapping-empty" Info "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo] {
        message "映射为空的PDO" "PDO with an empty mapping";
        Empty { pdo: Pdo, id: Id }
            "{pdo}的映射为空, CAN-ID {id}上却有数据" "the mapping of {pdo} is empty, but there are data on {id}";
        EmptyInDescription { pdo: Pdo, id: Id } "按设备描述, {pdo}的映射为空, CAN-ID {id}上却有数据"
            "the mapping of {pdo} is empty in the description, but there are data on {id}";
    }

    /// 映射各项的位数之和超过64位, 一帧容纳不下; 设备应以中止码06040042h拒绝, 却接受了写入。
    /// The mapping entries add up to more than 64 bits, which do not fit into a frame; the device should refuse with 06040042h but accepted the write.
    ///
    /// 映射长度算错, 设备也不检查。
    /// The mapping length was miscalculated, and the device does not check.
    Pdo016 "PDO016" "mapping-too-long" Error "CiA 301 7.5.2.36, 7.5.2.38" [Sdo] {
        message "映射超过8字节" "mapping of more than 8 bytes";
        Bits { found: Count }
            "映射共{found}位, 一帧最多64位, 设备却接受了" "mapping of {found} bits was accepted, a frame holds at most 64";
    }

    /// TPDO已由COB-ID的位31=1禁用, 该CAN-ID上仍有数据帧。
    /// The TPDO was disabled with bit 31 of its COB-ID, but there are still data frames on its CAN-ID.
    ///
    /// 设备没有按位31停止发送, 或者另一个节点在使用该CAN-ID。
    /// The device ignores bit 31, or another node uses the CAN-ID.
    Pdo018 "PDO018" "disabled-pdo-sent" Warning "CiA 301 7.5.2.37" one [Pdo] {
        message "已禁用的TPDO仍在发送" "disabled TPDO still sent";
        Sent { pdo: Pdo, id: Id } "{pdo}已禁用(COB-ID位31=1), CAN-ID {id}上仍有数据"
            "{pdo} is disabled (COB-ID bit 31 = 1), but there are still data on {id}";
    }

    /// 接收方禁用了该RPDO, 或者设备描述中该PDO无效, 总线上却有它的数据帧。
    /// The receiver disabled the RPDO, or the PDO is invalid in the description, but there are data frames of it.
    ///
    /// 设备在记录开始之前已被重新配置; 或者接收方正在重新配置, 这些数据不起作用。
    /// The device was configured before the capture began; or the receiver is being configured, and the data have no effect.
    Pdo019 "PDO019" "disabled-pdo-on-bus" Info "CiA 301 7.5.2.35, 7.5.2.37" one [Pdo] {
        message "已禁用的PDO出现在总线上" "disabled PDO on the bus";
        DisabledInDescription { pdo: Pdo, id: Id }
            "按设备描述, {pdo}已禁用, CAN-ID {id}上却有数据" "{pdo} is disabled in the description, but there are data on {id}";
        Disabled { pdo: Pdo, id: Id } "{pdo}已禁用(COB-ID位31=1), CAN-ID {id}上的数据不起作用"
            "{pdo} is disabled (COB-ID bit 31 = 1): the data on {id} have no effect";
    }

    /// 每个CAN-ID只能有一个发送者。两个TPDO配置为同一CAN-ID时, 接收方无法区分其数据, 两个节点同时发送还会产生错误帧。
    /// A CAN-ID must have one sender only. If two TPDOs use the same CAN-ID, receivers cannot distinguish their data, and two nodes sending at the same time cause error frames.
    ///
    /// COB-ID写错, 两个节点用了同一份配置, 或者设备描述中的COB-ID没有按节点ID计算。
    /// A wrong COB-ID, two nodes with the same configuration, or a device description whose COB-IDs do not depend on the node-ID.
    Pdo020 "PDO020" "shared-cob-id" Warning "CiA 301 7.3.5, 7.5.2.37" one [Pdo, Sdo] {
        message "两个TPDO使用同一CAN-ID" "two TPDOs with the same CAN-ID";
        Shared { pdo: Pdo, id: Id, other: Pdo, of: Count }
            "{pdo}与节点{of}的{other}使用同一CAN-ID {id}" "{pdo} and {other} of node {of} use the same CAN-ID {id}";
    }

    /// PDO的长度由映射决定, 映射不变则长度不变。该PDO的映射未知, 此前各帧长度相同, 这一帧却不同, 期间映射没有被改写, 节点也没有复位。
    /// The mapping sets the length of a PDO, which stays the same as long as the mapping does. The mapping of this PDO is unknown; its previous frames had one length and this one has another, though nothing changed the mapping and the node was not reset.
    ///
    /// 发送方的DLC有误, 两个发送者使用同一COB-ID, 或者映射被改写而该过程不在记录中。
    /// The sender's DLC is wrong, two senders use the COB-ID, or the mapping was changed and the capture does not show it.
    Pdo021 "PDO021" "pdo-length-changed" Warning "CiA 301 7.5.2.36, 7.5.2.38" one [Pdo, Sdo] {
        message "PDO长度改变" "PDO length has changed";
        Changed { found: Count, before: Count } "PDO为{found}字节, 此前均为{before}字节, 期间映射没有被改写"
            "PDO is {found|byte|bytes}, previous ones were {before}, and nothing changed its mapping";
    }

    /// 记录中的配置要求发送该TPDO (COB-ID有效, 传输类型1到240或254、255且事件定时器不为0), 节点一直处于操作状态, 但从未发送。
    /// The configuration in the capture asks for the TPDO (COB-ID valid, transmission type 1 to 240, or 254 or 255 with an event timer), and its node was Operational for long, but it never came.
    ///
    /// 映射为空, 固件不支持该传输类型或事件定时器, 配置写入后没有生效, 或者节点的控制器发不出去。
    /// An empty mapping, firmware without this transmission type or without event timer, a configuration that did not take effect, or a PDO that is never transmitted.
    Pdo022 "PDO022" "pdo-never-sent" Warning "CiA 301 7.5.2.37" one [Sync, Pdo] {
        message "已配置的TPDO从未发送" "configured TPDO was never sent";
        Never { found: Ns, limit: Ns } "处于操作状态{found}, 从未发送(事件定时器{limit})" "never sent in {found} of Operational (event timer {limit})";
        NeverWithSync { cycles: Count, expected: Count }
            "处于操作状态, {cycles}个同步报文期间从未发送(传输类型{expected})"
            "never sent with {cycles|SYNC|SYNCs} while Operational (transmission type {expected})";
    }

    /// TPDO一直以同一个间隔发送, 但不是其配置的间隔: 比事件定时器长, 或者SYNC的个数与传输类型不符。
    /// The TPDO always comes at one interval, but not at that of its configuration: it is longer than the event timer, or not the number of SYNCs of its transmission type.
    ///
    /// 固件使用自己的周期, 写入在节点复位后才生效, 或者写入了错误的值。
    /// The firmware has its own interval, the write takes effect after a reset only, or a wrong value was written.
    Pdo023 "PDO023" "pdo-at-other-interval" Warning "CiA 301 7.5.2.37" one [Sync, Pdo] {
        message "TPDO的间隔不符合其配置" "TPDO at another interval than configured";
        Slower { found: Ns, limit: Ns } "每{found}发送一次(事件定时器{limit})" "sent every {found} (event timer {limit})";
        WithSync { found: Count, expected: Count } "每{found}个SYNC发送一次(传输类型{expected})"
            "always sent {found|SYNC|SYNCs} after the previous one (transmission type {expected})";
    }
}
