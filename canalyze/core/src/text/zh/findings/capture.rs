//! 关于记录文件本身的诊断 (中文): 损坏与截断。其余在规则表旁边。

use super::RuleText;

pub(super) const CAP004: RuleText = RuleText {
    message: "文件有一部分损坏, 已跳过",
    meaning: "损坏处前后能读的内容都已读取。跨越缺口不判断toggle位、序号和应答, 未完成的传输记为不完整。",
    cause: "记录设备断电、存储介质出错, 或文件在传送中被改动; 请重新拷贝并比较校验和。",
    faces: &[
        "校验和不符; 跳过{bytes}字节",
        "长度或类型无效; 跳过{bytes}字节",
        "压缩数据损坏; 跳过{bytes}字节",
        "文件的其余部分无法读取",
        "部分topic的定义已丢失, 其消息已跳过",
        "校验和不符; 跳过{bytes}字节, 其中{frames}帧",
        "长度或类型无效; 跳过{bytes}字节, 其中{frames}帧",
        "压缩数据损坏; 跳过{bytes}字节, 其中{frames}帧",
    ],
};
pub(super) const CAP005: RuleText = RuleText {
    message: "文件在一条记录中间结束",
    meaning: "截断之前的内容都已读取; 正在写入的那条记录丢失。",
    cause: "记录程序被终止, 或文件仍在写入、拷贝中。",
    faces: &["文件在一条记录中间结束; 此前的内容都已读取"],
};
pub(super) const CAP006: RuleText = RuleText {
    message: "时间戳倒退",
    meaning: "该帧的时间戳比同一总线上的前一帧早10毫秒以上: 时钟被调整过, 或者帧的顺序不对。跨越此处的时间不作判断。",
    cause: "主机时钟被调整(NTP、GPS或手动), 记录拼接的顺序不对, 或者记录被编辑过。",
    faces: &["时间戳倒退{back}"],
};
