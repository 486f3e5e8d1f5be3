//! Rules of SYNC and synchronous PDOs, in Chinese.
//!
//! It must carry the same facts as `en::findings::sync`.

use crate::text::RuleText;

pub(super) const SYN001: RuleText = RuleText {
    message: "同步报文长度错误",
    meaning: "1019h为0时同步报文没有数据, 否则有1字节的计数器; 长度不符时, 消费者可能不处理该同步报文, 并报告8240h。",
    cause: "生产者与消费者的1019h设置不一致, 或者总线上有另一个同步生产者。",
    faces: &[
        "同步报文有{found}字节, 而1019h为{overflow}",
        "同步报文有{found}字节, 之前的都是{expected}字节",
        "同步报文有{found}字节, 应为0或1字节",
    ],
};

pub(super) const SYN002: RuleText = RuleText {
    message: "同步计数器不连续",
    meaning: "同步计数器从1开始, 每个同步报文加1, 到溢出值(1019h)后回到1, 从不为0。",
    cause: "同步报文丢失或重复, 生产者实现有误, 或者总线上有两个同步生产者。",
    faces: &["同步计数器为{found}, 应为{expected}", "同步计数器为{found}, 应在1到{limit}之间"],
};

pub(super) const SYN003: RuleText = RuleText {
    message: "同步周期异常",
    meaning: "同步报文应按同步周期(1006h)到来; 间隔超过1.5个周期时, 消费者视为超时。1006h未知时, 周期按报文测得。",
    cause: "生产者停顿或过载, 同步报文丢失, 发出了多余的同步报文, 或者1006h与实际周期不一致。",
    faces: &[
        "下一个同步报文在{gap}后才到来, 周期{period} (容差{tolerance}): 缺少{missing}个同步报文",
        "下一个同步报文在{gap}后才到来, 周期{period} (容差{tolerance}): 迟到",
        "下一个同步报文仅{gap}后就到来, 周期{period} (容差{tolerance})",
        "同步周期实际为{period}, 配置为{expected}",
        "同步周期从此变为{period}, 之前为{expected}; 没有对1006h的写入可以解释",
        "同步报文间隔不稳定, 偏离周期{period}达{jitter}",
    ],
};

pub(super) const SYN004: RuleText = RuleText {
    message: "同步PDO在同步窗口之外",
    meaning: "同步TPDO应在同步报文之后的同步窗口(1007h)内发出; 更晚的可能被消费者丢弃。",
    cause: "节点处理太慢, 总线负载太高, 或者窗口设得太短。",
    faces: &["第{cycle}个同步周期: 在同步报文之后{delay}到来, 窗口{window}, 容差{tolerance}"],
};

pub(super) const SYN005: RuleText = RuleText {
    message: "同步PDO在第一个同步报文之前",
    meaning: "同步TPDO由同步报文触发, 而记录中在它之前还没有同步报文。",
    cause: "传输类型与已知的配置不同, 或者同步报文使用了别的COB-ID (1005h)。",
    faces: &[],
};

pub(super) const SYN006: RuleText = RuleText {
    message: "总线上有两个同步生产者",
    meaning: "同一时刻只应有一个节点产生同步报文; 两路同步报文会使同步PDO加倍或错位。",
    cause: "两个节点的1005h都置了生产者位(位30), 或者主站与某个节点同时产生同步报文。",
    faces: &[
        "两路同步计数器交错: 收到{found}, 另一路应为{expected}",
        "两路同步报文交错: 间隔{short}与{long}交替, 周期{period}",
        "该节点和节点{other}都配置为同步生产者",
    ],
};

pub(super) const SYN007: RuleText = RuleText {
    message: "同步窗口不小于同步周期",
    meaning: "同步窗口(1007h)应小于同步周期(1006h), 否则它不起作用。",
    cause: "1006h或1007h的单位弄错 (都是µs), 或者只改了其中一个。",
    faces: &["同步窗口{window}不小于同步周期{period}"],
};

pub(super) const SYN008: RuleText = RuleText {
    message: "周期内缺少同步PDO",
    meaning: "传输类型为n (1到240)的TPDO应每n个同步报文发送一次; 它之前一直如此, 这次没有来。",
    cause: "节点没有收到同步报文或处理太慢, 窗口已过而放弃发送, 或者记录中丢了一帧。",
    faces: &[
        "第{cycle}个同步周期没有发送 (缺{count}次)",
        "从第{cycle}个同步周期起不再发送, 已过{since}个周期, 而节点仍在操作状态",
    ],
};

pub(super) const SYN009: RuleText = RuleText {
    message: "同一周期内同步PDO出现多次",
    meaning: "同步TPDO在一个同步周期内最多发送一次。",
    cause: "节点实现有误, 两个节点使用同一个COB-ID, 或者记录中缺少一个同步报文。",
    faces: &["第{cycle}个同步周期内多次发送"],
};

pub(super) const SYN010: RuleText = RuleText {
    message: "同步PDO在错误的周期",
    meaning: "传输类型为n (1到240)的TPDO应每n个同步报文发送一次; 它在别的周期到来。",
    cause: "节点漏收或多算了一个同步报文, 处理太慢而拖到下一周期, 或者同步起始值设置有误。",
    faces: &[
        "在上次发送后的第{found}个同步报文发送, 按传输类型应为第{expected}个",
        "属于第{expected}个同步周期, 到第{found}个周期才到来",
    ],
};

pub(super) const SYN011: RuleText = RuleText {
    message: "无法判断同步时间",
    meaning: "没有时间戳, 或者时间戳的抖动超过同步窗口, 因此不判断周期和窗口; 计数器和各周期内的PDO照常判断。",
    cause: "记录没有时间戳 (candump的 -t), 或者是在繁忙的主机上记录的; --jitter 可以给出容差。",
    faces: &["记录没有时间戳, 不判断同步周期和窗口", "容差{tolerance}不小于窗口{window}, 不判断窗口"],
};

pub(super) const SYN012: RuleText = RuleText {
    message: "个别同步报文迟到",
    meaning: "一个同步报文比周期晚了一半以上, 之后的又按原来的节拍到来: 没有缺少同步报文, 只是这一个发送或记录得晚。",
    cause: "同步报文的生产者或记录的计算机被别的任务占用了片刻; 总线负载高。",
    faces: &["同步报文间隔{gap}, 周期为{period}, 之后恢复原来的节拍"],
};

pub(super) const SYN013: RuleText = RuleText {
    message: "同步报文停止",
    meaning: "同步报文原来按周期发送, 之后不再出现, 而节点仍处于操作状态: 同步PDO既不再发送, 也不再生效。没有NMT命令、启动报文或对1005h、1006h的写入可以解释。",
    cause: "同步报文的生产者断电、断线或程序结束; 它的1005h或1006h在记录之外被改动。测试结束时往往是有意停止的。",
    faces: &["已有{silence}没有同步报文, 原来的周期为{period}; 节点仍处于操作状态"],
};
