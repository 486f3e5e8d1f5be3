//! 关于错误帧的规则 (中文)。It must carry the same facts as `en::findings::bus`.

use crate::text::RuleText;

pub(super) const BUS001: RuleText = RuleText {
    message: "总线关闭",
    meaning: "记录所用的CAN控制器的发送错误计数达到256, 已脱离总线: 重启之前既不发送也不接收, 其间总线上的报文不在记录中。",
    cause: "短路或断线, 波特率不对, 缺少终端电阻, 或者总线上没有其他节点。",
    faces: &["控制器进入总线关闭状态", "控制器进入总线关闭状态, 共{count}个错误帧", "{duration}内共{count}个错误帧"],
};

pub(super) const BUS002: RuleText = RuleText {
    message: "错误被动",
    meaning: "记录所用的CAN控制器的错误计数达到128: 有大量报文出错或无人应答。控制器仍可发送, 但不再能破坏它认为错误的帧。",
    cause: "总线上没有其他节点, 波特率不对, 终端或屏蔽不良, 或者接触不良。",
    faces: &["控制器进入错误被动状态", "控制器进入错误被动状态, 共{count}个错误帧", "{duration}内共{count}个错误帧"],
};

pub(super) const BUS003: RuleText = RuleText {
    message: "错误计数达到警告水平",
    meaning: "记录所用的CAN控制器的错误计数达到96; 总线正常时应接近0。",
    cause: "接线不良或干扰使报文出错, 或者报文无人应答。",
    faces: &["错误计数达到警告水平", "错误计数达到警告水平, 共{count}个错误帧", "{duration}内共{count}个错误帧"],
};

pub(super) const BUS004: RuleText = RuleText {
    message: "报文未能发出",
    meaning: "任何正确收到报文的节点都会应答。这里无人应答, 或者报文未能按时发出: 没有任何节点收到它。",
    cause: "总线上没有其他已上电的节点, 波特率不同, 断线, 或者总线一直被占用。",
    faces: &[
        "报文无人应答",
        "报文无人应答, 共{count}个错误帧",
        "报文未能按时发出",
        "报文未能按时发出, 共{count}个错误帧",
        "{duration}内共{count}个错误帧",
    ],
};

pub(super) const BUS005: RuleText = RuleText {
    message: "控制器缓冲区溢出",
    meaning: "记录所用的CAN控制器没有空间存放报文: 收到的报文没有记录下来, 或者主机要发的报文没有发出。跨越缺失处不作判断。",
    cause: "主机太慢或太忙, 或者总线过载。",
    faces: &[
        "接收缓冲区溢出, 记录有缺失",
        "接收缓冲区溢出{count}次, 记录有缺失",
        "发送缓冲区溢出",
        "发送缓冲区溢出{count}次",
        "{duration}内共{count}个错误帧",
    ],
};

pub(super) const BUS006: RuleText = RuleText {
    message: "控制器已恢复",
    meaning: "记录所用的CAN控制器恢复到错误主动状态, 或者在总线关闭后重新启动。",
    cause: "总线故障已排除, 或者主机自动重启了控制器。",
    faces: &[
        "控制器恢复到错误主动状态",
        "控制器重新启动",
        "{after}后控制器恢复到错误主动状态",
        "{after}后控制器重新启动",
    ],
};

pub(super) const BUS007: RuleText = RuleText {
    message: "总线错误",
    meaning: "有报文违反CAN协议 (位错误、填充错误、格式错误或CRC错误), 被错误帧破坏, 由发送者重发。总线正常时几乎不会出现。",
    cause: "干扰, 终端或屏蔽不良, 接触不良, 有节点的波特率不同, 或者刚刚插入节点。",
    faces: &[
        "总线错误",
        "{count}个总线错误",
        "错误帧, 记录中没有说明类别",
        "{count}个错误帧, 记录中没有说明类别",
        "{duration}内共{count}个错误帧",
    ],
};

pub(super) const BUS008: RuleText = RuleText {
    message: "收发器故障",
    meaning: "记录所用的CAN控制器的收发器报告信号线断开或短路。",
    cause: "CANH或CANL断线, 两线相碰, 或者与地、电源短接。",
    faces: &["收发器报告信号线故障", "收发器报告信号线故障, 共{count}个错误帧", "{duration}内共{count}个错误帧"],
};
