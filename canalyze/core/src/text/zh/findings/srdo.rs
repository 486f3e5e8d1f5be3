//! Rules about SRDO (CiA 304) in Chinese. It must carry the same facts as `en::findings::srdo`.

use crate::text::RuleText;

pub(super) const SRD001: RuleText = RuleText {
    message: "SRDO的两帧不是互为取反",
    meaning: "SRDO由正常数据和取反数据两帧组成: 长度相同, 第二帧是第一帧的逐位取反。不符时接收方必须进入安全状态。",
    cause: "发送方在两帧之间改变了数据, 映射不成对, 或者另有节点使用同一COB-ID。",
    faces: &["SRDO{srdo}的第二帧不是第一帧的逐位取反", "SRDO{srdo}的正常数据为{normal}字节, 取反数据为{inverted}字节"],
};

pub(super) const SRD002: RuleText = RuleText {
    message: "SRDO的验证时间超时",
    meaning: "取反数据必须在正常数据之后的验证时间(SRVT, 子索引3)内到达。",
    cause: "总线负载过高使第二帧延迟, 发送方把两帧分在不同的任务周期中发送, 或者SRVT设得太短。",
    faces: &["SRDO{srdo}的取反数据在正常数据之后{delay}才到, 限值{limit} (容差{tolerance})"],
};

pub(super) const SRD003: RuleText = RuleText {
    message: "SRDO的安全周期时间超时",
    meaning: "相邻两对SRDO的间隔不得超过安全周期时间(SCT, 子索引2); 判断时采用接收方的值, 没有时采用发送方的值。",
    cause: "发送方周期过长或曾停顿, 总线过载, 或者SCT设得太短。",
    faces: &["SRDO{srdo}与上一对相隔{gap}, 限值{limit} (容差{tolerance})"],
};

pub(super) const SRD004: RuleText = RuleText {
    message: "SRDO的两帧顺序不对或缺一帧",
    meaning: "每对SRDO先发正常数据, 再发取反数据, 两帧缺一不可。偶然晚一帧的顺序颠倒不计。",
    cause: "发送方实现有误, 其中一帧的COB-ID配置有误, 或者记录中丢了一帧。",
    faces: &["SRDO{srdo}的取反数据接连先于正常数据", "SRDO{srdo}缺少取反数据({id})", "SRDO{srdo}缺少正常数据({id})"],
};

pub(super) const SRD005: RuleText = RuleText {
    message: "非操作状态下发送SRDO",
    meaning: "SRDO和PDO一样只允许在操作状态下发送。",
    cause: "发送方没有随NMT状态停止SRDO。",
    faces: &["节点处于{state}状态, 却在发送SRDO{srdo}"],
};
