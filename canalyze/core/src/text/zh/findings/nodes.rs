//! Rules of nodes in Chinese: NMT, heartbeats, guarding, emergencies, TIME, and what a state permits.
//!
//! It must carry the same facts as `en::findings::nodes`.

use crate::text::RuleText;

pub(super) const NMT001: RuleText = RuleText {
    message: "NMT命令无效",
    meaning: "CiA 301定义的命令是01h、02h、80h、81h和82h, 节点ID为0 (所有节点) 到127, 帧长2字节; 其他的命令节点会忽略。",
    cause: "主站程序拼错了命令, 或者别的协议占用了CAN-ID 000。",
    faces: &["未知的NMT命令{found}", "NMT命令的节点ID为{found}, 应为0到127", "NMT命令长{found}字节, 应为2字节"],
};

pub(super) const NMT002: RuleText = RuleText {
    message: "NMT命令没有效果",
    meaning: "节点收到命令后必须进入相应状态; 两个心跳周期之后它仍然报告另一个状态。",
    cause: "节点拒绝启动 (有错误, 或配置不完整), 没有收到命令, 或者命令发给了不执行它的节点。",
    faces: &[
        "命令“{command}”之后节点仍然处于{found}状态",
        "命令“{command}”之后节点没有发送启动报文, 仍然处于{found}状态",
    ],
};

pub(super) const NMT003: RuleText = RuleText {
    message: "节点自行复位",
    meaning: "启动报文之前没有复位命令, 也没有其他能解释它的帧。",
    cause: "看门狗复位, 电源跌落, 固件崩溃, 或者有人给节点断过电。",
    faces: &[
        "没有复位命令的启动报文, 距上次启动{after}",
        "没有复位命令的启动报文",
        "节点正在运行 (上次心跳在{after}之前), 没有复位命令却重新启动",
    ],
};

pub(super) const NMT004: RuleText = RuleText {
    message: "没有命令的状态变化",
    meaning: "节点报告了另一个NMT状态, 但没有使它改变的命令, 也没有紧急报文。",
    cause: "节点内部的错误处理 (1029h), 本地操作, 两个节点使用同一个节点ID, 或者命令不在记录中。",
    faces: &["没有命令, 状态由{from}变为{to}"],
};

pub(super) const NMT005: RuleText = RuleText {
    message: "因错误改变状态",
    meaning: "节点没有收到命令而离开操作状态或停止, 同时发送了紧急报文: 这是1029h规定的错误行为。此后它保持该状态; 错误不会使节点启动。",
    cause: "通信错误, 例如它监视的心跳丢失。",
    faces: &["没有命令, 状态由{from}变为{to}, 与节点的紧急报文同时发生"],
};

pub(super) const HBT001: RuleText = RuleText {
    message: "心跳迟到",
    meaning: "两个心跳的间隔明显超过了周期。周期取自1017h或之前的心跳; 额外的心跳是允许的。",
    cause: "节点太忙, 总线负载太高, 或者丢了一帧。",
    faces: &["与上次心跳间隔{found}, 周期为{expected}"],
};

pub(super) const HBT002: RuleText = RuleText {
    message: "心跳丢失",
    meaning: "消费者时间 (1016h) 内没有心跳; 没有已知的消费者时间时, 以三个周期加容差为限。只说一次。",
    cause: "节点掉线、断电或死机, 电缆断开, 或者节点总线关闭(bus off)。",
    faces: &["此后{silence}没有心跳, 消费者时间为{limit}", "此后{silence}没有心跳, 限值为{limit}"],
};

pub(super) const HBT003: RuleText = RuleText {
    message: "未知的NMT状态",
    meaning: "错误控制报文中的状态只能是00h、04h、05h或7Fh; 心跳的位7为0。",
    cause: "固件错误, 数据损坏, 或者别的协议占用了这个CAN-ID。",
    faces: &["状态为{found}", "心跳的位7为1 ({found}), 而没有保护请求"],
};

pub(super) const HBT004: RuleText = RuleText {
    message: "节点ID重复",
    meaning: "同一个节点ID上有两路心跳交错, 或者一次复位后有两个启动报文: 总线上有两个节点使用了同一个节点ID。",
    cause: "拨码开关设置相同, 或者新设备使用默认的节点ID。",
    faces: &[
        "没有命令而状态交替为{one}和{other}",
        "心跳间隔交替为{one}和{other}: 两路心跳",
        "心跳间隔为{found}, 只有1017h周期{expected}的一半",
        "{gap}内有两个启动报文",
    ],
};

pub(super) const HBT005: RuleText = RuleText {
    message: "总线静默",
    meaning: "这段时间里总线上一帧也没有, 因此不据此判断节点丢失; 之后不再出现的节点才算丢失。",
    cause: "记录暂停或主机停顿, 总线断开, 或者整个网络断电。",
    faces: &["总线静默{silence}, {nodes}个节点的心跳应到未到"],
};

pub(super) const GRD001: RuleText = RuleText {
    message: "节点保护的toggle位错误",
    meaning: "节点保护应答的toggle位每次都要翻转; 复位后从0开始。",
    cause: "协议栈实现有误, 或者记录中丢了一个应答。",
    faces: &["toggle={found}, 应为{expected}"],
};

pub(super) const GRD002: RuleText = RuleText {
    message: "保护请求没有应答",
    meaning: "NMT主站用远程帧询问节点状态, 节点必须应答。",
    cause: "节点掉线或正在启动, 不支持节点保护, 或者它的CAN控制器不应答远程帧。",
    faces: &["保护请求{age}内没有应答", "保护请求没有应答"],
};

pub(super) const GRD003: RuleText = RuleText {
    message: "同时使用心跳和节点保护",
    meaning: "一个节点只能使用其中之一: 1017h不为0时使用心跳, 节点不应答保护请求。",
    cause: "主站配置了节点保护, 而节点的1017h没有清零。",
    faces: &["被保护的节点还发送没有请求的心跳", "向发送心跳的节点发送保护请求"],
};

pub(super) const GRD004: RuleText = RuleText {
    message: "被保护的节点从未出现",
    meaning: "记录中有对该节点的保护请求, 但没有它的任何帧。",
    cause: "节点不存在或没有上电, 或者只记录到一个方向。",
    faces: &["{requests}个保护请求, 没有该节点的任何帧"],
};

pub(super) const EMC001: RuleText = RuleText {
    message: "有错误码而错误寄存器为0",
    meaning: "出现错误时错误寄存器 (1001h) 至少有一位为1; 位0在任何错误时都置位。",
    cause: "固件没有更新1001h, 或者紧急报文是手工拼的。",
    faces: &["错误码{code}, 错误寄存器为{register}"],
};

pub(super) const EMC002: RuleText = RuleText {
    message: "部分错误复位",
    meaning: "错误码为0000h而错误寄存器不为0: 一个错误消失, 其他错误仍在。这是允许的。",
    cause: "几个错误先后消失。",
    faces: &[
        "错误复位, 错误寄存器仍为{register}",
        "{cleared}已消失, {left}仍在; 错误寄存器为{register}",
        "{cleared}已消失, 还有{count}个错误, 其中最早的是{left}; 错误寄存器为{register}",
        "{cleared}已消失; 错误寄存器为{register}, 说明还有记录中没有出现的错误",
        "{count}个错误之一已消失; 错误寄存器仍为{register}",
    ],
};

pub(super) const EMC003: RuleText = RuleText {
    message: "错误寄存器的保留位不为0",
    meaning: "错误寄存器 (1001h) 的位6保留, 必须为0。",
    cause: "固件把该位用于自己的目的, 或者字节顺序错误。",
    faces: &["错误寄存器为{register}, 位6保留"],
};

pub(super) const EMC004: RuleText = RuleText {
    message: "不应发送紧急报文的状态",
    meaning: "在停止状态和启动报文之前, 节点不应发送紧急报文。",
    cause: "设备没有按NMT状态关闭EMCY服务; 有些厂商的设备如此。",
    faces: &["节点处于{state}状态时发送了紧急报文", "复位之后, 启动报文之前发送了紧急报文"],
};

pub(super) const EMC005: RuleText = RuleText {
    message: "违反紧急报文的抑制时间",
    meaning: "两个紧急报文的间隔不得短于1015h (以0.1ms为单位)。",
    cause: "固件不遵守1015h。",
    faces: &["间隔{found}, 抑制时间为{expected}"],
};

pub(super) const EMC006: RuleText = RuleText {
    message: "紧急报文的长度不是8字节",
    meaning: "紧急报文总是8字节: 错误码2字节, 错误寄存器1字节, 制造商定义5字节。消费者可能不处理其他长度。",
    cause: "固件按实际内容设置了DLC; 长度为0的是DS301第3版的启动报文。",
    faces: &["紧急报文有{found}字节, 应为8字节"],
};

pub(super) const EMC007: RuleText = RuleText {
    message: "设备报告错误",
    meaning: "紧急报文说明设备本身有错误: 电流、电压、温度、硬件、软件、模块或被控对象。节点发出错误复位(0000h)或重新启动之前, 该错误一直存在。",
    cause: "见错误码和厂商手册; 错误寄存器给出类别。",
    faces: &["节点报告{code}, 错误寄存器为{register}"],
};

pub(super) const EMC008: RuleText = RuleText {
    message: "节点报告错误",
    meaning: "紧急报文说明节点有通信错误, 或者错误码没有进一步说明的错误(一般性或设备特定)。节点发出错误复位(0000h)或重新启动之前, 该错误一直存在。",
    cause: "通信伙伴已离线或沉默, PDO长度不同, 报文丢失; 其他情况见厂商手册。",
    faces: &["节点报告{code}, 错误寄存器为{register}"],
};

pub(super) const EMC009: RuleText = RuleText {
    message: "错误仍然存在",
    meaning: "节点报告了错误, 到记录结束仍没有复位; 或者错误存在期间重复发送了紧急报文。",
    cause: "错误的原因还在, 或者设备只在收到命令或重新启动后才复位错误。",
    faces: &["{code}没有复位", "{code}没有复位, 共发送{count}次", "{code}在复位前共发送{count}次"],
};

pub(super) const EMC010: RuleText = RuleText {
    message: "紧急报文过多",
    meaning: "每个错误只应发送一次紧急报文。一个节点在1秒内发送了10个以上。",
    cause: "错误时有时无(接触不良, 数值在阈值附近), 或者设备重复发送紧急报文; 1015h可限制其频率。",
    faces: &["{duration}内{count}个紧急报文", "{duration}内共{count}个紧急报文"],
};

pub(super) const HBT006: RuleText = RuleText {
    message: "错误控制报文的长度不是1字节",
    meaning: "心跳、启动报文和保护应答都是1字节, 只有状态。",
    cause: "固件设置了错误的DLC, 或者该COB-ID上是别的协议。",
    faces: &["错误控制报文有{found}字节, 应为1字节"],
};

pub(super) const TIM001: RuleText = RuleText {
    message: "时间无效",
    meaning: "时间戳为6字节, 毫秒数小于86400000 (一天), 保留的四位为0。",
    cause: "时间戳的生产者填错了字段, 例如使用了其他的起点或单位。",
    faces: &["毫秒数为{found}, 一天最多到86399999", "保留位为{found}, 应为0", "时间戳有{found}字节, 应为6字节"],
};

pub(super) const TIM002: RuleText = RuleText {
    message: "时间跳变",
    meaning: "两个时间戳之差与记录中经过的时间相差1秒以上。",
    cause: "生产者的时钟被校准, 有两个生产者, 或者记录主机的时钟被调整。",
    faces: &["TIME的时间走过{passed}, 记录中经过{elapsed}"],
};

pub(super) const SDO011: RuleText = RuleText {
    message: "不允许SDO的状态",
    meaning: "在停止状态和启动报文之前没有SDO: 节点既不应应答, 客户端也不应询问。",
    cause: "主站忘记先把节点切换到预操作, 或者协议栈没有按状态关闭SDO。",
    faces: &["向处于{state}状态的节点发送SDO请求", "节点处于{state}状态时应答了SDO", "复位之后, 启动报文之前应答了SDO"],
};

pub(super) const PDO002: RuleText = RuleText {
    message: "TPDO在非操作状态发送",
    meaning: "PDO只存在于操作状态; 切换时已在途中的帧不算。有多个TPDO时只说第一个, 每次处于该状态只说一次。",
    cause: "协议栈没有按状态停止PDO, 缺少启动命令, 或者另一个节点使用了这个COB-ID。",
    faces: &["节点处于{state}状态时发送了{pdo}"],
};

pub(super) const PDO003: RuleText = RuleText {
    message: "RPDO发给非操作状态的节点",
    meaning: "节点只在操作状态处理RPDO, 此时的数据被忽略。",
    cause: "主站在启动节点之前就循环发送RPDO; 通常无害。",
    faces: &["节点处于{state}状态, {pdo}被忽略"],
};
