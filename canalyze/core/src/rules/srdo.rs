//! Rules about SRDOs (CiA 304).

use crate::bytes::ns::Ns;

use super::quantity::{Count, Id, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// SRDO由正常数据和取反数据两帧组成: 长度相同, 第二帧是第一帧的逐位取反。不符时接收方必须进入安全状态。
    /// An SRDO is a frame of normal and a frame of inverted data: of the same length, the second one the bitwise inverse of the first. Where they differ, receivers must go to their safe state.
    ///
    /// 发送方在两帧之间改变了数据, 映射不成对, 或者另有节点使用同一COB-ID。
    /// The sender changed the data between the two frames, the mapping is not paired, or another node uses the same COB-ID.
    Srd001 "SRD001" "not-inverse" Error "CiA 304, EN 50325-5" here [Srdo] {
        message "SRDO的两帧不是互为取反" "the two frames of an SRDO are not each other's inverse";
        NotInverse { srdo: Count }
            "SRDO{srdo}的第二帧不是第一帧的逐位取反" "the second frame of SRDO{srdo} is not the bitwise inverse of the first";
        Lengths { srdo: Count, normal: Count, inverted: Count } "SRDO{srdo}的正常数据为{normal}字节, 取反数据为{inverted}字节"
            "SRDO{srdo} has {normal|byte|bytes} of normal data, but {inverted} of inverted data";
    }

    /// 取反数据必须在正常数据之后的验证时间(SRVT, 子索引3)内到达; 该时间未知时, 须在平时的两个周期内到达。
    /// The inverted data must come within the validation time (SRVT, sub-index 3) after the normal data; where that is unknown, within two of the usual periods.
    ///
    /// 总线负载过高使第二帧延迟, 发送方把两帧分在不同的任务周期中发送, 或者SRVT设得太短。
    /// Bus load delays the second frame, the sender handles the two frames in different cycles of its task, or the SRVT is too short.
    Srd002 "SRD002" "validation-time" Error "CiA 304, 1301h:03" here [Srdo] {
        message "SRDO的验证时间超时" "SRDO validation time exceeded";
        Late { srdo: Count, delay: Ns, limit: Ns, tolerance: Ns }
            "SRDO{srdo}的取反数据在正常数据之后{delay}才到达, 限值{limit} (容差{tolerance})"
            "the inverted data of SRDO{srdo} came {delay} after the normal data, limit {limit} (tolerance {tolerance})";
        Behind { srdo: Count, delay: Ns, period: Ns } "SRDO{srdo}的取反数据在正常数据之后{delay}才到达, 而平时每隔{period}一对"
            "the inverted data of SRDO{srdo} came {delay} after the normal data, although a pair comes every {period}";
    }

    /// 相邻两对SRDO的间隔不得超过安全周期时间(SCT, 子索引2); 判断时采用接收方的值, 没有时采用发送方的值, 都未知时采用平时周期的三倍。不再出现的SRDO, 在10倍该时间且至少1 s之后或在记录结束时报告。
    /// Two SRDOs must not be further apart than the safeguard cycle time (SCT, sub-index 2): a receiver's, where one is known, else the sender's, else three of the usual periods. One that does not come again is reported after ten of these times and at least 1 s, or at the end of the capture.
    ///
    /// 发送方停止、周期过长或曾停顿, 总线过载, 或者SCT设得太短。
    /// The sender stopped, paused, or has too long a period, the bus is overloaded, or the SCT is too short.
    Srd003 "SRD003" "cycle-time" Error "CiA 304, 1301h:02" [Srdo] {
        message "SRDO的安全周期时间超时" "SRDO safeguard cycle time exceeded";
        Late { srdo: Count, gap: Ns, limit: Ns, tolerance: Ns } "SRDO{srdo}距上一对{gap}, 限值{limit} (容差{tolerance})"
            "SRDO{srdo} came {gap} after the previous pair, limit {limit} (tolerance {tolerance})";
        Paused { srdo: Count, gap: Ns, period: Ns } "SRDO{srdo}距上一对{gap}, 此前每隔{period}一对"
            "SRDO{srdo} came {gap} after the previous pair, before that every {period}";
        Stopped [reason = "stopped"] { srdo: Count, silence: Ns, limit: Ns } "此后{silence}没有SRDO{srdo}, 限值{limit}"
            "no SRDO{srdo} for {silence} since then, limit {limit}";
        Gone [reason = "stopped"] { srdo: Count, silence: Ns, period: Ns } "此后{silence}没有SRDO{srdo}, 此前每隔{period}一对"
            "no SRDO{srdo} for {silence} since then, before that every {period}";
    }

    /// 每对SRDO先发正常数据, 再发取反数据, 两帧缺一不可。偶然一次顺序颠倒不报告。
    /// Each SRDO is sent as normal data followed by inverted data, always both. A single swapped pair is not reported.
    ///
    /// 发送方实现有误, 其中一帧的COB-ID配置有误, 或者记录中丢了一帧。
    /// A bug in the sender, a wrong COB-ID of one of the frames, or a frame missing from the capture.
    Srd004 "SRD004" "pair-order" Warning "CiA 304, EN 50325-5" [Srdo] {
        message "SRDO的两帧顺序不对或缺一帧" "SRDO frames out of order, or one missing";
        Swapped { srdo: Count }
            "SRDO{srdo}的取反数据多次先于正常数据" "the inverted data of SRDO{srdo} repeatedly come before the normal data";
        NoInverted { srdo: Count, id: Id }
            "SRDO{srdo}缺少取反数据({id})" "the inverted data of SRDO{srdo} ({id}) are missing";
        NoNormal { srdo: Count, id: Id } "SRDO{srdo}缺少正常数据({id})" "the normal data of SRDO{srdo} ({id}) are missing";
    }

    /// SRDO和PDO一样只允许在操作状态下发送。
    /// Like PDOs, SRDOs are only sent in NMT state Operational.
    ///
    /// 发送方没有随NMT状态停止SRDO。
    /// The sender does not stop its SRDOs with the NMT state.
    Srd005 "SRD005" "not-operational" Warning "CiA 304, CiA 301 7.3.2.2" [Srdo, ErrorControl, Nmt] {
        message "非操作状态下发送SRDO" "SRDO from a node that is not Operational";
        InState { srdo: Count, state: State } "节点处于{state}, 却在发送SRDO{srdo}" "the node is {state} but sends SRDO{srdo}";
    }
}
