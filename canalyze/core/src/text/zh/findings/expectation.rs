//! Rules of expectations in Chinese. It must carry the same facts as `en::findings::expectation`.

use crate::text::RuleText;

pub(super) const EXP001: RuleText = RuleText {
    message: "缺少期望的SDO传输",
    meaning: "期望要求出现这一传输, 而它没有出现, 或者次数不够、出现得太晚。到记录结束时仍未完成的传输不算出现。",
    cause: "主站不再像以前那样配置该节点, 节点不在, 记录太短, 或者期望文件已经过时。",
    faces: &[
        "没有这样的传输",
        "没有这样的读取",
        "没有这样的写入",
        "没有传输{expected}",
        "没有读到{expected}",
        "没有写入{expected}",
        "这样的传输有{found}次, 期望至少{expected}次",
        "在记录开始后{found}才出现, 期望在{expected}之内",
        "传输从这一帧开始, 到记录结束时仍未完成",
        "没有被中止的传输",
        "没有以{expected}中止的传输",
    ],
};

pub(super) const EXP002: RuleText = RuleText {
    message: "SDO传输的次序与期望不同",
    meaning: "序列中的传输必须按所列次序完成, 中间可以有其他传输。这一传输出现得太早, 之后没有在应有的位置再次出现。",
    cause: "主站的配置次序改变了, 或者有几个客户端同时工作。",
    faces: &["太早: 序列{sequence}中应先完成{before}的传输"],
};

pub(super) const EXP003: RuleText = RuleText {
    message: "SDO传输与期望不同",
    meaning: "该对象有过传输, 但值或结果不同, 而期望的传输没有出现。有多次时指出最后一次。",
    cause: "配置或固件不同, 或者节点有故障。",
    faces: &[
        "值为{found}, 期望为{expected}",
        "以{found}中止, 期望成功",
        "成功, 期望被中止",
        "成功, 期望以{expected}中止",
        "以{found}中止, 期望的是{expected}",
        "因违反SDO协议而失败, 与期望不同",
    ],
};

pub(super) const EXP004: RuleText = RuleText {
    message: "不应出现的SDO传输",
    meaning: "期望规定这一传输不得出现。",
    cause: "另有客户端或工具访问该节点, 或者主站有了新的动作。",
    faces: &["不应出现", "不应出现 ({found})"],
};

pub(super) const EXP005: RuleText = RuleText {
    message: "没有达到期望的状态",
    meaning: "启动报文、心跳或节点保护应答(驱动器则是状态字)显示了该状态才算达到, 仅有命令不算。时间以最先显示它的帧为准。",
    cause: "节点启动时卡住, 主站没有启动它, 节点报告错误, 或者比以前慢。",
    faces: &[
        "从未显示{expected}状态, 最后的状态为{found}",
        "从未显示{expected}状态, 也没有显示任何其他状态",
        "记录开始后{found}才显示{expected}状态, 期望在{limit}之内",
        "启动报文之后{found}才显示{expected}状态, 期望在{limit}之内",
        "没有启动报文",
        "记录开始后{found}才有启动报文, 期望在{limit}之内",
        "上次启动报文之后没有显示{expected}状态, 期望在{limit}之内; 最后的状态为{found}",
    ],
};

pub(super) const EXP006: RuleText = RuleText {
    message: "离开了应保持的状态",
    meaning: "期望规定节点(或其驱动器)达到这一状态后保持不变。",
    cause: "收到命令, 出现错误及其反应(1029h、驱动器故障), 复位, 或者电源跌落。",
    faces: &["离开{expected}状态, 变为{found}", "节点重新启动, 期望保持{expected}状态"],
};

pub(super) const EXP007: RuleText = RuleText {
    message: "信号超出期望的范围",
    meaning: "物理值(已计入符号、类型和系数)小于期望的最小值或大于最大值。",
    cause: "工况不同, 传感器或其换算有误, 或者使用了另一份描述文件或映射。",
    faces: &["{pdo}中的值{found}小于{expected}", "{pdo}中的值{found}大于{expected}"],
};

pub(super) const EXP008: RuleText = RuleText {
    message: "信号的周期与期望不同",
    meaning: "带有该信号的PDO前后两次的间隔超出期望的周期及其容差。跨越启动报文、停止PDO的NMT命令和记录缺口的间隔不计。",
    cause: "事件定时器、抑制时间、传输类型或同步周期改变, 总线繁忙, 或者节点不再发送。",
    faces: &[
        "{pdo}与前一次间隔{found}, 期望每{expected}一次, 容差{tolerance}",
        "{found}没有{pdo}, 期望每{expected}一次, 容差{tolerance}",
    ],
};

pub(super) const EXP009: RuleText = RuleText {
    message: "心跳周期与期望不同",
    meaning: "前后两次心跳的间隔超出期望的周期及其容差, 或者没有心跳。状态改变时额外的心跳是合法的。跨越复位、启动报文和记录缺口的间隔不计。",
    cause: "1017h的值不同, 节点繁忙、卡死或已离线。",
    faces: &[
        "与上次心跳间隔{found}, 期望每{expected}一次, 容差{tolerance}",
        "{found}没有心跳, 期望每{expected}一次, 容差{tolerance}",
        "记录中没有心跳, 期望每{expected}一次",
    ],
};

pub(super) const EXP010: RuleText = RuleText {
    message: "同步周期与期望不同",
    meaning: "前后两个同步报文的间隔超出期望的周期及其容差, 或者没有同步报文。跨越记录缺口的间隔不计。",
    cause: "1006h的值不同, 生产者繁忙或已停止, 或者记录的时间戳没有容差那么准确。",
    faces: &[
        "与前一个同步报文间隔{found}, 期望每{expected}一个, 容差{tolerance}",
        "{found}没有同步报文, 期望每{expected}一个, 容差{tolerance}",
        "记录中没有同步报文, 期望每{expected}一个",
    ],
};

pub(super) const EXP011: RuleText = RuleText {
    message: "缺少期望的紧急报文",
    meaning: "期望要求出现这一紧急报文。",
    cause: "测试引发的故障没有被检测到, 或者节点以另一错误码报告。",
    faces: &["没有紧急报文", "没有紧急报文{expected}"],
};

pub(super) const EXP012: RuleText = RuleText {
    message: "不应出现的紧急报文",
    meaning: "期望规定这一紧急报文不得出现, 或者除所列之外都不得出现。错误复位(00xxh)不在其内, 除非写明了它的错误码。",
    cause: "节点有了编写期望时没有的故障。",
    faces: &["{found}不应出现"],
};

pub(super) const EXP013: RuleText = RuleText {
    message: "用时超过期望",
    meaning: "测量的是: SDO请求到其响应, 同步报文到同步TPDO, 或者NMT命令到第一个显示相应状态的错误控制帧。记录次序颠倒的帧对不计。",
    cause: "节点繁忙, 总线负载高, 网关太慢; 对NMT命令则是心跳周期太长。",
    faces: &[
        "请求之后{found}才有响应, 期望在{expected}之内",
        "同步报文之后{found}才有{pdo}, 期望在{expected}之内",
        "命令“{command}”在{found}之后才显示生效, 期望在{expected}之内",
        "命令“{command}”之后{found}仍处于{state}状态, 期望在{expected}之内",
    ],
};

pub(super) const EXP014: RuleText = RuleText {
    message: "总线负载超过期望的上限",
    meaning: "窗口内总线上的位数(含填充位)占波特率的百分比超过期望。每次越过上限只报告一次。",
    cause: "PDO比以前多或周期更短, 某个节点大量发送, 或者帧被重发。",
    faces: &["{window}内负载为{found} %, 期望不超过{expected} %"],
};

pub(super) const EXP015: RuleText = RuleText {
    message: "期望未能检查",
    meaning: "记录不足以说明该期望是否成立, 因此不作判断。",
    cause: "记录没有时间戳, 波特率未知(--bitrate), PDO没有描述文件(--eds), 或者事情的开头不在记录中。",
    faces: &[
        "记录没有时间戳, 时间未检查",
        "波特率未知, 负载未检查",
        "有些PDO可能带有它, 而映射未知",
        "传输的数据没有全部记录或保留, 值未检查",
        "已命令进入{expected}状态, 但节点不发送能显示状态的错误控制帧",
        "记录开始后{found}首次出现时已处于{expected}状态, 何时进入不得而知",
        "记录中在此之前没有可以起算时间的启动报文",
        "记录中没有可以测量的内容",
        "在见到它之前有帧丢失: 它可能就在丢失的帧中",
    ],
};

pub(super) const EXP016: RuleText = RuleText {
    message: "缺少期望的信号",
    meaning: "记录中没有任何PDO带有这一名称的信号。",
    cause: "节点没有发送该PDO, 映射改变了, 名称写法不同, 或者缺少描述文件(--eds)。",
    faces: &["记录中没有信号{expected}"],
};
