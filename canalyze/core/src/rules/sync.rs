//! Rules about SYNC, its counter, and synchronous TPDOs (CiA 301, 7.2.5).

use crate::bytes::ns::Ns;

use super::quantity::{Count, JsonOnly};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 1019h为0时同步报文没有数据, 否则有1字节的计数器; 长度不符时, 消费者可能不处理该同步报文, 并报告8240h。
    /// SYNC has no data if 1019h is 0, otherwise one byte with the counter. Consumers may ignore a SYNC of another length and report 8240h.
    ///
    /// 生产者与消费者的1019h设置不一致, 或者总线上有另一个同步生产者。
    /// 1019h differs between producer and consumers, or there is another SYNC producer on the bus.
    Syn001 "SYN001" "sync-length" Error "CiA 301 7.2.5.3.1, 7.5.2.22" one [Sync, Pdo] {
        message "同步报文长度错误" "wrong SYNC length";
        Overflow { found: Count, overflow: Count }
            "同步报文为{found}字节, 而1019h为{overflow}" "SYNC is {found|byte|bytes} long, but 1019h is {overflow}";
        Before { found: Count, expected: Count }
            "同步报文为{found}字节, 此前均为{expected}字节" "SYNC is {found|byte|bytes} long, previous ones {expected}";
        Length { found: Count } "同步报文为{found}字节, 应为0或1字节" "SYNC is {found|byte|bytes} long, expected 0 or 1";
    }

    /// 同步计数器从1开始, 每个同步报文加1, 到溢出值(1019h)后回到1, 从不为0。
    /// The counter starts at 1, increments with every SYNC, and returns to 1 after the overflow value (1019h); it is never 0.
    ///
    /// 同步报文丢失或重复, 生产者实现有误, 或者总线上有两个同步生产者。
    /// A SYNC was lost or duplicated, the producer has a bug, or there are two producers on the bus.
    Syn002 "SYN002" "sync-counter" Error "CiA 301 7.2.5.3.1, 7.5.2.22" one [Sync, Pdo] {
        message "同步计数器不连续" "SYNC counter out of sequence";
        Skipped { found: Count, expected: Count }
            "同步计数器为{found}, 应为{expected}" "SYNC counter is {found}, expected {expected}";
        OutOfRange { found: Count, limit: Count }
            "同步计数器为{found}, 应在1到{limit}之间" "SYNC counter is {found}, expected 1 to {limit}";
    }

    /// 同步报文应按同步周期(1006h)到来; 间隔超过1.5个周期时, 消费者视为超时。1006h未知时, 周期按报文测得。
    /// SYNC should come every communication cycle period (1006h); consumers time out after 1.5 periods. If 1006h is unknown, the period is measured.
    ///
    /// 生产者停顿或过载, 同步报文丢失, 发出了多余的同步报文, 或者1006h与实际周期不一致。
    /// The producer stalled or is overloaded, a SYNC was lost, an extra one was sent, or 1006h differs from the actual period.
    Syn003 "SYN003" "sync-period" Warning "CiA 301 7.2.5, 7.5.2.6" one [Sync, Pdo] {
        message "同步周期异常" "irregular SYNC period";
        Missing { gap: Ns, period: Ns, tolerance: Ns, missing: Count }
            "与下一个同步报文相隔{gap}(周期{period}, 容差{tolerance}): 缺少{missing}个"
            "next SYNC {gap} later (period {period}, tolerance {tolerance}): {missing} missing";
        Late { gap: Ns, period: Ns, tolerance: Ns, missing: JsonOnly<Count> }
            "与下一个同步报文相隔{gap}(周期{period}, 容差{tolerance}): 延迟"
            "next SYNC {gap} later (period {period}, tolerance {tolerance}): late";
        Early { gap: Ns, period: Ns, tolerance: Ns } "与下一个同步报文仅相隔{gap}(周期{period}, 容差{tolerance})"
            "next SYNC only {gap} later (period {period}, tolerance {tolerance})";
        NotConfigured { period: Ns, expected: Ns }
            "同步周期实测为{period}, 配置为{expected}" "SYNC period is {period}, configured {expected}";
        Changed { period: Ns, expected: Ns } "同步周期由{expected}变为{period}, 其间没有写入1006h"
            "SYNC period changed from {expected} to {period} without a write to 1006h";
        Unsteady { jitter: Ns, period: Ns }
            "同步报文间隔不稳定, 与周期{period}最大偏差{jitter}" "unsteady SYNC, up to {jitter} off the period of {period}";
    }

    /// 同步TPDO应在同步报文之后的同步窗口(1007h)内发出; 更晚的可能被消费者丢弃。
    /// Synchronous TPDOs should be sent within the synchronous window (1007h) after SYNC; consumers may discard later ones.
    ///
    /// 节点处理太慢, 总线负载太高, 或者窗口设得太短。
    /// The node is too slow, the bus load too high, or the window too short.
    Syn004 "SYN004" "outside-window" Warning "CiA 301 7.2.5, 7.5.2.7" one [Sync, Pdo] {
        message "同步PDO超出同步窗口" "synchronous PDO outside the window";
        Late { delay: Ns, window: Ns, tolerance: Ns, cycle: Count }
            "第{cycle}个同步周期: SYNC之后{delay}才发出, 超出同步窗口{window}(容差{tolerance})"
            "SYNC cycle {cycle}: sent {delay} after SYNC, window {window} (tolerance {tolerance})";
    }

    /// 同步TPDO由同步报文触发, 而记录中在它之前还没有同步报文。
    /// Synchronous TPDOs are triggered by SYNC, but the capture has no SYNC before this one.
    ///
    /// 传输类型与已知的配置不同, 或者同步报文使用了别的COB-ID (1005h)。
    /// The transmission type differs from the known configuration, or SYNC uses another COB-ID (1005h).
    Syn005 "SYN005" "before-first-sync" Info "CiA 301 7.2.2.2" one [Sync, Pdo] {
        message "同步PDO在第一个同步报文之前" "synchronous PDO before the first SYNC";
    }

    /// 同一时刻只应有一个节点产生同步报文; 两路同步报文会使同步PDO加倍或错位。
    /// Only one node should produce SYNC at a time; two SYNC streams double or displace synchronous PDOs.
    ///
    /// 两个节点的1005h都置了生产者位(位30), 或者主站与某个节点同时产生同步报文。
    /// The producer bit (bit 30) of 1005h is set on two nodes, or both the master and a node produce SYNC.
    Syn006 "SYN006" "two-producers" Error "CiA 301 7.2.5" one [Sync, Pdo] {
        message "总线上有两个同步生产者" "two SYNC producers on the bus";
        Counters { found: Count, expected: Count } "两路同步计数器交错: 收到{found}, 而另一路应为{expected}"
            "two interleaved SYNC counters: got {found}, the other expects {expected}";
        Interleaved { short: Ns, long: Ns, period: Ns } "两路同步报文交错: 间隔{short}与{long}交替(周期{period})"
            "two interleaved SYNC streams (intervals alternate {short} and {long}, period {period})";
        Configured { other: Count } "该节点和节点{other}都配置为同步生产者" "configured as SYNC producer, as is node {other}";
    }

    /// 同步窗口(1007h)应小于同步周期(1006h), 否则它不起作用。
    /// The synchronous window (1007h) should be shorter than the communication cycle period (1006h), otherwise it has no effect.
    ///
    /// 1006h或1007h的单位弄错 (都是µs), 或者只改了其中一个。
    /// Wrong unit in 1006h or 1007h (both are in µs), or only one of them was changed.
    Syn007 "SYN007" "window-not-below-period" Warning "CiA 301 7.5.2.6, 7.5.2.7" one [Sync, Pdo] {
        message "同步窗口不小于同步周期" "synchronous window not shorter than the period";
        Window { window: Ns, period: Ns } "同步窗口{window}不小于同步周期{period}"
            "synchronous window {window} is not shorter than the communication cycle period {period}";
    }

    /// 传输类型为n (1到240)的TPDO应每n个同步报文发送一次; 此前一直如此, 这次没有发送。
    /// A TPDO of transmission type n (1 to 240) is sent with every n-th SYNC; it was so far, but not this time.
    ///
    /// 节点没有收到同步报文或处理太慢, 窗口已过而放弃发送, 或者记录中丢了一帧。
    /// The node missed the SYNC or was too slow, its window had passed, or a frame is missing from the capture.
    Syn008 "SYN008" "missing-synchronous-pdo" Warning "CiA 301 7.2.2.2, 7.5.2.37" one [Sync, Pdo] {
        message "周期内缺少同步PDO" "synchronous PDO missing in its cycle";
        Missing { cycle: Count, count: Count }
            "第{cycle}个同步周期没有发送 (共缺{count}次)" "not sent in SYNC cycle {cycle} ({count} missing)";
        Since { cycle: Count, since: Count } "从第{cycle}个同步周期起不再发送(已{since}个周期), 而节点仍处于操作状态"
            "missing since SYNC cycle {cycle} ({since|cycle|cycles}), although the node is Operational";
    }

    /// 同步TPDO在一个同步周期内最多发送一次。
    /// A synchronous TPDO is sent at most once in a SYNC cycle.
    ///
    /// 节点实现有误, 两个节点使用同一个COB-ID, 或者记录中缺少一个同步报文。
    /// A bug in the node, two nodes with the same COB-ID, or a SYNC missing from the capture.
    Syn009 "SYN009" "twice-in-cycle" Warning "CiA 301 7.2.2.2, 7.5.2.37" one here [Sync, Pdo] {
        message "同一周期内同步PDO出现多次" "synchronous PDO more than once in a cycle";
        Twice { cycle: Count } "第{cycle}个同步周期内多次发送" "sent more than once in SYNC cycle {cycle}";
    }

    /// 传输类型为n (1到240)的TPDO应每n个同步报文发送一次; 这次在其他周期发送。
    /// A TPDO of transmission type n (1 to 240) is sent with every n-th SYNC; this one was sent in another cycle.
    ///
    /// 节点漏收或多算了一个同步报文, 处理太慢而拖到下一周期, 或者同步起始值设置有误。
    /// The node missed or miscounted a SYNC, was so slow that it sent a cycle late, or the SYNC start value is wrong.
    Syn010 "SYN010" "wrong-cycle" Warning "CiA 301 7.2.2.2, 7.5.2.37" one here [Sync, Pdo] {
        message "同步PDO在错误的周期" "synchronous PDO in the wrong cycle";
        TransmissionType { found: Count, expected: Count }
            "上次发送后第{found}个SYNC再次发送, 传输类型要求每{expected}个SYNC一次"
            "sent {found|SYNC|SYNCs} after the previous one, its transmission type asks for one every {expected|SYNC|SYNCs}";
        OtherCycle { expected: Count, found: Count }
            "应在第{expected}个同步周期发送, 到第{found}个周期才发出" "expected in SYNC cycle {expected}, sent in cycle {found}";
    }

    /// 没有时间戳, 或者时间戳的抖动超过同步窗口, 因此不判断周期和窗口; 计数器和各周期内的PDO照常判断。
    /// Without timestamps, or with timestamp jitter beyond the synchronous window, period and window are not judged; counter and PDOs per cycle are.
    ///
    /// 记录没有时间戳 (candump的 -t), 或者是在繁忙的主机上记录的; --jitter 可设定容差。
    /// The capture has no timestamps (candump -t), or was taken on a busy host; --jitter sets the tolerance.
    Syn011 "SYN011" "sync-not-judged" Info "-" one [Sync, Pdo] {
        message "无法判断同步时间" "SYNC timing cannot be judged";
        NoStamps "记录没有时间戳, 不判断同步周期和窗口" "no timestamps: SYNC period and window are not judged";
        Tolerance { tolerance: Ns, window: Ns } "容差{tolerance}不小于窗口{window}, 不判断窗口"
            "tolerance {tolerance} is not smaller than the window {window}: the window is not judged";
    }

    /// 一个同步报文延迟半个周期以上, 之后恢复正常周期: 没有缺少同步报文, 只是这一个发送或记录得晚。
    /// One SYNC came more than half a period late, the following ones on time: none is missing, this one was only sent or recorded late.
    ///
    /// 同步报文的生产者或记录用的计算机短时繁忙; 总线负载高。
    /// The producer or the recording computer was briefly busy; high bus load.
    Syn012 "SYN012" "late-sync" Info "CiA 301 7.2.5, 7.5.2.6" one [Sync, Pdo] {
        message "个别同步报文延迟" "single late SYNC";
        Late { gap: Ns, period: Ns } "距上一同步报文{gap}(周期{period}), 之后恢复正常周期"
            "{gap} since the previous SYNC (period {period}); the following ones are on time";
    }

    /// 同步报文原来按周期发送, 之后不再出现, 而节点仍处于操作状态: 同步PDO不再发送, 也不再生效。其间没有NMT命令、启动报文或对1005h、1006h的写入。
    /// SYNC was periodic and then stopped while nodes are still Operational: synchronous PDOs are neither sent nor actuated any more. No NMT command, boot-up or write to 1005h or 1006h explains it.
    ///
    /// 同步报文的生产者断电、断线或程序结束; 它的1005h或1006h在记录之外被改动。测试结束时往往是有意停止的。
    /// The producer was switched off, disconnected or its program ended; its 1005h or 1006h was changed outside the capture. At the end of a test this is often intended.
    Syn013 "SYN013" "sync-stopped" Warning "CiA 301 7.2.5, 7.5.2.6" one [Sync, Pdo] {
        message "同步报文停止" "SYNC has stopped";
        Stopped { silence: Ns, period: Ns } "已{silence}没有同步报文(原周期{period}), 节点仍处于操作状态"
            "no SYNC for {silence} (period was {period}), but the node is still Operational";
    }

    /// 记录中的配置有同步TPDO (传输类型1到240), 节点一直处于操作状态, 但没有任何同步报文: 这些TPDO不会发送。
    /// The configuration in the capture has synchronous TPDOs (transmission type 1 to 240), and their nodes were Operational for long, but there is no SYNC: they are not sent.
    ///
    /// 没有节点产生SYNC (1005h位30, 1006h), 或者SYNC使用其他COB-ID。
    /// No node produces SYNC (1005h bit 30, 1006h), or SYNC has another COB-ID.
    Syn014 "SYN014" "no-sync" Warning "CiA 301 7.2.5, 7.5.2.5" [Sync, Pdo] {
        message "没有同步报文" "there is no SYNC";
        Producer { period: Ns } "该节点按1005h和1006h应每{period}发送同步报文, 但没有同步报文"
            "no SYNC, although the node produces it by 1005h, every {period} by 1006h";
        Never { pdos: Count } "没有同步报文, 而节点处于操作状态, {pdos}个TPDO是同步的"
            "no SYNC, although nodes are Operational and {pdos|TPDO is|TPDOs are} synchronous";
    }
}
