//! Rules about drives (CiA 402) in Chinese. It must carry the same facts as `en::findings::drive`.

use crate::text::RuleText;

pub(super) const DRV001: RuleText = RuleText {
    message: "状态跳变没有命令依据",
    meaning: "驱动器只能按CiA 402状态机转换; 朝\"运行使能\"方向的每一步都需要控制字中的相应命令。这里前后两个状态字之间, 没有任何控制字能引起这一变化。",
    cause: "驱动器固件的状态机有误, 另有主站或本地面板在控制, 或者记录中丢了控制字。",
    faces: &["状态字由{from}变为{to}, 其间没有控制字引起这一变化 (最后的控制字: {controlword})"],
};

pub(super) const DRV002: RuleText = RuleText {
    message: "命令没有生效",
    meaning: "控制字给出了应使驱动器离开当前状态的命令, 状态字持续上报, 状态却不变。断电方向的命令和故障复位等待1秒, 使能方向的命令等待5秒; 本地控制(位9为0)和使能方向上主电源未接入(位4为0)不计。",
    cause: "使能输入、STO或制动器条件不满足, 故障原因仍在, 命令顺序不对, 或者驱动器没有接收该RPDO。",
    faces: &["控制字{controlword}发出{after}后, 状态字仍为{statusword}"],
};

pub(super) const DRV003: RuleText = RuleText {
    message: "进入故障状态而没有紧急报文",
    meaning: "驱动器进入故障状态, 前后500毫秒内没有该节点的紧急报文(EMCY)。",
    cause: "驱动器不发送EMCY, 同一错误此前已经报告过, 或者记录时滤掉了EMCY。",
    faces: &["状态字变为{statusword}, 前后没有紧急报文"],
};

pub(super) const DRV004: RuleText = RuleText {
    message: "显示的操作模式与请求的不同",
    meaning: "写入6060h的操作模式在1秒内没有出现在6061h中。有些驱动器只在特定状态下才切换模式, 不支持的模式则不会切换。",
    cause: "驱动器不支持该模式(见6502h), 当前状态下不允许切换, 或者另一个PDO写入了别的模式。",
    faces: &["请求的模式为{requested}, {after}后显示的仍是{displayed}"],
};

pub(super) const DRV005: RuleText = RuleText {
    message: "驱动器故障",
    meaning: "状态字表明驱动器进入故障状态: 已经停止或正在停止, 需要故障复位。若该节点有紧急报文(EMCY)报告了此故障, 则以紧急报文为准, 本条是其后果。",
    cause: "见紧急报文或603Fh中的错误码和厂商手册; 通信中断也可能是原因。",
    faces: &["状态字变为{statusword}"],
};
