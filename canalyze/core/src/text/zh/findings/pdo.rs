//! Rules on PDOs and their configuration, in Chinese.
//!
//! It must carry the same facts as `en::findings::pdo`.

use crate::text::RuleText;

pub(super) const MPD001: RuleText = RuleText {
    message: "MPDO长度不是8字节",
    meaning: "MPDO总是8字节: 地址1字节, 索引和子索引3字节, 数据4字节; 其他长度的帧无法解释。",
    cause: "发送方实现有误, 或者该标识符上还有别的报文。",
    faces: &["MPDO长度为{found}字节, 应为8字节"],
};

pub(super) const PDO001: RuleText = RuleText {
    message: "PDO短于其映射",
    meaning: "数据比映射的对象短时, 接收方不处理该PDO, 并可发送紧急报文8210h。",
    cause: "发送方的DLC或映射有误, 两侧的映射不一致, 或者映射改变后发送方仍按旧映射发送。",
    faces: &["PDO为{found}字节, 映射需要{mapped}字节", "PDO为{found}字节, 节点{consumer}的{pdo}的映射需要{mapped}字节"],
};

pub(super) const PDO004: RuleText = RuleText {
    message: "抑制时间未到就再次发送",
    meaning: "事件驱动的TPDO两次发送之间至少相隔抑制时间(通信参数子索引03h, 单位100µs); 对远程请求的应答不算。",
    cause: "设备没有实现抑制时间, 单位弄错, 或者抑制时间在PDO有效时被改写。",
    faces: &["间隔{found}, 抑制时间为{limit} (容差{tolerance})"],
};

pub(super) const PDO005: RuleText = RuleText {
    message: "事件定时器到期而PDO没有发送",
    meaning: "节点处于操作状态, 事件定时器(通信参数子索引05h, 单位ms)到期后TPDO仍未发送: 超过1.5倍时间。",
    cause: "设备太忙, 固件停止了发送, 或者记录中丢帧。",
    faces: &["已{found}没有发送, 事件定时器为{limit}"],
};

pub(super) const PDO006: RuleText = RuleText {
    message: "PDO长于其映射",
    meaning: "多出的字节被接收方忽略; 接收方可发送紧急报文8220h。",
    cause: "发送方总是发送8字节, 或者两侧的映射不一致。",
    faces: &["PDO为{found}字节, 映射只有{mapped}字节", "PDO为{found}字节, 节点{consumer}的{pdo}的映射只有{mapped}字节"],
};

pub(super) const PDO008: RuleText = RuleText {
    message: "写入了保留的传输类型",
    meaning: "TPDO的传输类型241到251保留, RPDO的241到253保留; 设备应以06090030h拒绝, 却确认了写入。",
    cause: "配置有误, 设备不检查该值; 该PDO何时发送或生效没有定义。",
    faces: &["TPDO的传输类型{found}是保留值, 设备却接受了", "RPDO的传输类型{found}是保留值, 设备却接受了"],
};

pub(super) const PDO009: RuleText = RuleText {
    message: "PDO有效时修改了映射",
    meaning: "修改映射前应先把COB-ID的位31置1使PDO无效, 再把映射的子索引00h写0。否则修改期间的PDO是新旧混合的。",
    cause: "配置程序跳过了使PDO无效这一步; 设备不检查, 多数协议栈会拒绝。",
    faces: &[
        "{pdo}仍有效(COB-ID位31=0), 映射也在使用中, 却修改了映射",
        "{pdo}仍有效(COB-ID位31=0), 只把映射的子索引00h写了0就修改映射",
    ],
};

pub(super) const PDO010: RuleText = RuleText {
    message: "PDO有效时修改了CAN-ID",
    meaning: "PDO有效(位31=0)时不得改变COB-ID的位0到29: 应先写入位31=1, 再写入新的COB-ID。",
    cause: "配置程序跳过了使PDO无效这一步; 设备不检查, 多数协议栈会以06090030h拒绝。",
    faces: &["CAN-ID从{old}直接改为{found}, 没有先使PDO无效"],
};

pub(super) const PDO011: RuleText = RuleText {
    message: "对不允许远程请求的TPDO发送远程帧",
    meaning: "该TPDO的COB-ID位30=1: 不允许远程请求, 设备不会应答。",
    cause: "主站按轮询方式配置, 而设备的COB-ID中位30=1。",
    faces: &["{pdo} ({id})的COB-ID位30=1, 不允许远程请求"],
};

pub(super) const PDO012: RuleText = RuleText {
    message: "PDO长度与EDS的默认映射不符",
    meaning: "只有EDS给出了该PDO的映射, 此前的帧与它相符, 而这一帧的长度不符: 信号的解释不可信。",
    cause: "发送方的DLC有误, 设备存有另外的映射, 或者EDS不是这台设备的。可用DCF, 或把配置过程也记录下来。",
    faces: &["PDO为{found}字节, EDS的默认映射为{mapped}字节: 此前该PDO与它相符"],
};

pub(super) const PDO013: RuleText = RuleText {
    message: "RPDO超过了接收期限",
    meaning: "RPDO的通信参数子索引05h是接收期限(ms); 超过它节点可发送紧急报文8250h。",
    cause: "发送方停止发送或周期太长。",
    faces: &["已{found}没有收到, 期限为{limit}"],
};

pub(super) const PDO014: RuleText = RuleText {
    message: "配置了受限的CAN-ID",
    meaning: "000到07F, 101到180, 581到5FF, 601到67F, 6E0到6FF, 701到7FF保留给固定的服务, 不得配置给别的对象; 设备却确认了写入。",
    cause: "COB-ID算错, 设备不检查。",
    faces: &["CAN-ID {id}受限, 不得配置, 设备却接受了"],
};

pub(super) const PDO015: RuleText = RuleText {
    message: "没有映射对象的PDO",
    meaning: "该PDO的映射为空(子索引00h为0), 但总线上有它的数据帧, 无法解释。",
    cause: "映射正在修改, 或者设备在记录开始之前已被重新配置。",
    faces: &["{pdo}的映射为空, 标识符{id}上却有数据", "按设备描述{pdo}的映射为空, 标识符{id}上却有数据"],
};

pub(super) const PDO016: RuleText = RuleText {
    message: "映射超过8字节",
    meaning: "映射各项的位数之和超过64位, 一帧放不下; 设备应以06040042h拒绝, 却确认了写入。",
    cause: "映射长度算错, 设备不检查。",
    faces: &["映射共{found}位, 一帧最多64位, 设备却接受了"],
};

pub(super) const PDO018: RuleText = RuleText {
    message: "已禁用的TPDO仍在发送",
    meaning: "COB-ID的位31=1使TPDO无效后, 该标识符上仍有数据帧。",
    cause: "设备没有按位31停止发送, 或者另一个节点在使用该标识符。",
    faces: &["{pdo}已被设为无效, 标识符{id}上仍有数据"],
};

pub(super) const PDO019: RuleText = RuleText {
    message: "总线上有被禁用的PDO",
    meaning: "接收方禁用了该RPDO, 或者设备描述中该PDO无效, 但总线上有它的数据帧。",
    cause: "设备在记录开始之前已被重新配置; 或者接收方正在重新配置, 这些数据不起作用。",
    faces: &["按设备描述{pdo}是禁用的, 标识符{id}上却有数据", "{pdo}已被设为无效, 标识符{id}上的数据不起作用"],
};
