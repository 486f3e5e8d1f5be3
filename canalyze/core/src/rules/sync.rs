//! Rules about SYNC, its counter, and synchronous TPDOs (CiA 301, 7.2.5).

use super::quantity::{Count, JsonOnly, Ns};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// A SYNC has another length than 1019h asks for, or than the SYNCs before.
    Syn001 "SYN001" "sync-length" Error "CiA 301 7.2.5.3.1, 7.5.2.22" one [Sync, Pdo] {
        message "同步报文长度错误" "wrong length of SYNC";
        meaning
            "1019h为0时同步报文没有数据, 否则有1字节的计数器; 长度不符时, 消费者可能不处理该同步报文, 并报告8240h。"
            "A SYNC has no data where 1019h is 0, else one byte with the counter. Consumers may ignore a SYNC of another length, and report 8240h.";
        cause
            "生产者与消费者的1019h设置不一致, 或者总线上有另一个同步生产者。"
            "Producer and consumers disagree about 1019h, or there is another SYNC producer on the bus.";
        Overflow { found: Count, overflow: Count }
            "同步报文有{found}字节, 而1019h为{overflow}"
            "SYNC of length {found} (in bytes) though 1019h is {overflow}";
        Before { found: Count, expected: Count }
            "同步报文有{found}字节, 之前的都是{expected}字节"
            "SYNC of length {found}, those before had length {expected} (in bytes)";
        Length { found: Count }
            "同步报文有{found}字节, 应为0或1字节"
            "SYNC of length {found} instead of 0 or 1 (in bytes)";
    }

    /// The synchronous counter does not go on as it should.
    Syn002 "SYN002" "sync-counter" Error "CiA 301 7.2.5.3.1, 7.5.2.22" one [Sync, Pdo] {
        message "同步计数器不连续" "SYNC counter out of sequence";
        meaning
            "同步计数器从1开始, 每个同步报文加1, 到溢出值(1019h)后回到1, 从不为0。"
            "The counter begins with 1, counts every SYNC, and goes back to 1 after the overflow value (1019h); it is never 0.";
        cause
            "同步报文丢失或重复, 生产者实现有误, 或者总线上有两个同步生产者。"
            "A SYNC was lost or doubled, the producer is wrong, or there are two producers on the bus.";
        Skipped { found: Count, expected: Count }
            "同步计数器为{found}, 应为{expected}"
            "SYNC counter {found} instead of {expected}";
        OutOfRange { found: Count, limit: Count }
            "同步计数器为{found}, 应在1到{limit}之间"
            "SYNC counter {found} is not within 1 to {limit}";
    }

    /// A SYNC is missing, late or one too many, or the period is not the configured one, or another one than before.
    Syn003 "SYN003" "sync-period" Warning "CiA 301 7.2.5, 7.5.2.6" one [Sync, Pdo] {
        message "同步周期异常" "irregular SYNC period";
        meaning
            "同步报文应按同步周期(1006h)到来; 间隔超过1.5个周期时, 消费者视为超时。1006h未知时, 周期按报文测得。"
            "SYNCs should come with the communication cycle period (1006h); consumers call one missing after one and a half periods. Where 1006h is not known the period is taken from the traffic.";
        cause
            "生产者停顿或过载, 同步报文丢失, 发出了多余的同步报文, 或者1006h与实际周期不一致。"
            "The producer stalled or is overloaded, a SYNC was lost, one too many was sent, or 1006h is not what the producer does.";
        Missing { gap: Ns, period: Ns, tolerance: Ns, missing: Count }
            "下一个同步报文在{gap}后才到来, 周期{period} (容差{tolerance}): 缺少{missing}个同步报文"
            "the next SYNC came {gap} after this one, period {period} (tolerance {tolerance}): {missing} missing";
        Late { gap: Ns, period: Ns, tolerance: Ns, missing: JsonOnly<Count> }
            "下一个同步报文在{gap}后才到来, 周期{period} (容差{tolerance}): 迟到"
            "the next SYNC came {gap} after this one, period {period} (tolerance {tolerance}): late";
        Early { gap: Ns, period: Ns, tolerance: Ns }
            "下一个同步报文仅{gap}后就到来, 周期{period} (容差{tolerance})"
            "the next SYNC came only {gap} after this one, period {period} (tolerance {tolerance})";
        NotConfigured { period: Ns, expected: Ns }
            "同步周期实际为{period}, 配置为{expected}"
            "the SYNC period is {period}, configured is {expected}";
        Changed { period: Ns, expected: Ns }
            "同步周期从此变为{period}, 之前为{expected}; 没有对1006h的写入可以解释"
            "the SYNC period is {period} from here on, before it was {expected}; no write of 1006h explains it";
        Unsteady { jitter: Ns, period: Ns }
            "同步报文间隔不稳定, 偏离周期{period}达{jitter}"
            "SYNCs come unsteadily, up to {jitter} off the period of {period}";
    }

    /// A synchronous TPDO came after the synchronous window.
    Syn004 "SYN004" "outside-window" Warning "CiA 301 7.2.5, 7.5.2.7" one [Sync, Pdo] {
        message "同步PDO在同步窗口之外" "synchronous PDO outside the window";
        meaning
            "同步TPDO应在同步报文之后的同步窗口(1007h)内发出; 更晚的可能被消费者丢弃。"
            "Synchronous TPDOs should be sent within the synchronous window (1007h) after the SYNC; consumers may drop later ones.";
        cause
            "节点处理太慢, 总线负载太高, 或者窗口设得太短。"
            "The node is too slow, the bus load too high, or the window too short.";
        Late { delay: Ns, window: Ns, tolerance: Ns, cycle: Count }
            "第{cycle}个同步周期: 在同步报文之后{delay}到来, 窗口{window}, 容差{tolerance}"
            "SYNC cycle {cycle}: {delay} after the SYNC, window {window}, tolerance {tolerance}";
    }

    /// Synchronous TPDOs without any SYNC before.
    Syn005 "SYN005" "before-first-sync" Info "CiA 301 7.2.2.2" one [Sync, Pdo] {
        message "同步PDO在第一个同步报文之前" "synchronous PDO before the first SYNC";
        meaning
            "同步TPDO由同步报文触发, 而记录中在它之前还没有同步报文。"
            "Synchronous TPDOs are triggered by SYNC, and the capture has none before this one.";
        cause
            "传输类型与已知的配置不同, 或者同步报文使用了别的COB-ID (1005h)。"
            "The transmission type is another one than is known, or SYNC has another COB-ID (1005h).";
    }

    /// Two nodes produce SYNC.
    Syn006 "SYN006" "two-producers" Error "CiA 301 7.2.5" one [Sync, Pdo] {
        message "总线上有两个同步生产者" "two SYNC producers on the bus";
        meaning
            "同一时刻只应有一个节点产生同步报文; 两路同步报文会使同步PDO加倍或错位。"
            "Only one node should produce SYNC at a time; two trains of SYNCs double or displace synchronous PDOs.";
        cause
            "两个节点的1005h都置了生产者位(位30), 或者主站与某个节点同时产生同步报文。"
            "The producer bit (bit 30) of 1005h is set on two nodes, or the master produces SYNC beside a node.";
        Counters { found: Count, expected: Count }
            "两路同步计数器交错: 收到{found}, 另一路应为{expected}"
            "two SYNC counters run beside each other: {found}, while {expected} is due in the other";
        Interleaved { short: Ns, long: Ns, period: Ns }
            "两路同步报文交错: 间隔{short}与{long}交替, 周期{period}"
            "two trains of SYNCs: {short} and {long} apart in turn, period {period}";
        Configured { other: Count }
            "该节点和节点{other}都配置为同步生产者"
            "configured as SYNC producer, and so is node {other}";
    }

    /// The synchronous window is not shorter than the communication cycle.
    Syn007 "SYN007" "window-not-below-period" Warning "CiA 301 7.5.2.6, 7.5.2.7" one [Sync, Pdo] {
        message "同步窗口不小于同步周期" "synchronous window not below the period";
        meaning
            "同步窗口(1007h)应小于同步周期(1006h), 否则它不起作用。"
            "The synchronous window (1007h) should be shorter than the communication cycle period (1006h), else it means nothing.";
        cause
            "1006h或1007h的单位弄错 (都是µs), 或者只改了其中一个。"
            "The unit of 1006h or 1007h was mistaken (both are in microseconds), or only one of them was changed.";
        Window { window: Ns, period: Ns }
            "同步窗口{window}不小于同步周期{period}"
            "the synchronous window of {window} is not below the communication cycle period of {period}";
    }

    /// A cyclic synchronous TPDO did not come in its cycle.
    Syn008 "SYN008" "missing-synchronous-pdo" Warning "CiA 301 7.2.2.2, 7.5.2.37" one [Sync, Pdo] {
        message "周期内缺少同步PDO" "synchronous PDO missing in its cycle";
        meaning
            "传输类型为n (1到240)的TPDO应每n个同步报文发送一次; 它之前一直如此, 这次没有来。"
            "A TPDO of transmission type n (1 to 240) is sent with every n-th SYNC; this one was, and did not come.";
        cause
            "节点没有收到同步报文或处理太慢, 窗口已过而放弃发送, 或者记录中丢了一帧。"
            "The node did not get the SYNC or was too slow, its window had passed, or a frame was lost from the capture.";
        Missing { cycle: Count, count: Count }
            "第{cycle}个同步周期没有发送 (缺{count}次)"
            "not sent in SYNC cycle {cycle} ({count} missing)";
        Since { cycle: Count, since: Count }
            "从第{cycle}个同步周期起不再发送, 已过{since}个周期, 而节点仍在操作状态"
            "not sent from SYNC cycle {cycle} on, for {since} cycles, though the node is Operational";
    }

    /// A synchronous TPDO came more than once in a cycle.
    Syn009 "SYN009" "twice-in-cycle" Warning "CiA 301 7.2.2.2, 7.5.2.37" one here [Sync, Pdo] {
        message "同一周期内同步PDO出现多次" "synchronous PDO more than once in a cycle";
        meaning
            "同步TPDO在一个同步周期内最多发送一次。"
            "A synchronous TPDO is sent at most once in a SYNC cycle.";
        cause
            "节点实现有误, 两个节点使用同一个COB-ID, 或者记录中缺少一个同步报文。"
            "The node is wrong, two nodes use the same COB-ID, or a SYNC is missing from the capture.";
        Twice { cycle: Count }
            "第{cycle}个同步周期内多次发送"
            "sent more than once in SYNC cycle {cycle}";
    }

    /// A cyclic synchronous TPDO came in another cycle than it should.
    Syn010 "SYN010" "wrong-cycle" Warning "CiA 301 7.2.2.2, 7.5.2.37" one here [Sync, Pdo] {
        message "同步PDO在错误的周期" "synchronous PDO in the wrong cycle";
        meaning
            "传输类型为n (1到240)的TPDO应每n个同步报文发送一次; 它在别的周期到来。"
            "A TPDO of transmission type n (1 to 240) is sent with every n-th SYNC; this one came in another cycle.";
        cause
            "节点漏收或多算了一个同步报文, 处理太慢而拖到下一周期, 或者同步起始值设置有误。"
            "The node missed or miscounted a SYNC, was so slow that it came a cycle late, or the SYNC start value is wrong.";
        TransmissionType { found: Count, expected: Count }
            "在上次发送后的第{found}个同步报文发送, 按传输类型应为第{expected}个"
            "sent at SYNC {found} after the one it was last sent at, due by its transmission type at SYNC {expected}";
        OtherCycle { expected: Count, found: Count }
            "属于第{expected}个同步周期, 到第{found}个周期才到来"
            "belongs to SYNC cycle {expected} and came in cycle {found}";
    }

    /// Times of SYNC cannot be judged.
    Syn011 "SYN011" "sync-not-judged" Info "-" one [Sync, Pdo] {
        message "无法判断同步时间" "times of SYNC cannot be judged";
        meaning
            "没有时间戳, 或者时间戳的抖动超过同步窗口, 因此不判断周期和窗口; 计数器和各周期内的PDO照常判断。"
            "Without stamps, or with stamps that are less steady than the synchronous window is long, period and window are not judged; counter and composition of the cycles are.";
        cause
            "记录没有时间戳 (candump的 -t), 或者是在繁忙的主机上记录的; --jitter 可以给出容差。"
            "The capture has no stamps (-t of candump), or was taken on a busy host; --jitter gives the tolerance.";
        NoStamps
            "记录没有时间戳, 不判断同步周期和窗口"
            "the capture has no stamps: SYNC period and window are not judged";
        Tolerance { tolerance: Ns, window: Ns }
            "容差{tolerance}不小于窗口{window}, 不判断窗口"
            "the tolerance of {tolerance} is not below the window of {window}: the window is not judged";
    }

    /// A SYNC was late, and those after it came in time.
    Syn012 "SYN012" "late-sync" Info "CiA 301 7.2.5, 7.5.2.6" one [Sync, Pdo] {
        message "个别同步报文迟到" "a single SYNC was late";
        meaning
            "一个同步报文比周期晚了一半以上, 之后的又按原来的节拍到来: 没有缺少同步报文, 只是这一个发送或记录得晚。"
            "One SYNC came over half a period late, and those after it came at the old times: none is missing, this one was only sent or recorded late.";
        cause
            "同步报文的生产者或记录的计算机被别的任务占用了片刻; 总线负载高。"
            "The producer, or the recording computer, was busy with something else for a moment; a high bus load.";
        Late { gap: Ns, period: Ns }
            "同步报文间隔{gap}, 周期为{period}, 之后恢复原来的节拍"
            "{gap} since the SYNC before, the period is {period}; those after it came in time";
    }

    /// SYNC has stopped, and nodes are Operational all the same.
    Syn013 "SYN013" "sync-stopped" Warning "CiA 301 7.2.5, 7.5.2.6" one [Sync, Pdo] {
        message "同步报文停止" "SYNC has stopped";
        meaning
            "同步报文原来按周期发送, 之后不再出现, 而节点仍处于操作状态: 同步PDO既不再发送, 也不再生效。没有NMT命令、启动报文或对1005h、1006h的写入可以解释。"
            "SYNC came periodically and then no more, while nodes go on in Operational: synchronous PDOs are neither sent nor actuated any more. No NMT command, boot-up or write of 1005h or 1006h explains it.";
        cause
            "同步报文的生产者断电、断线或程序结束; 它的1005h或1006h在记录之外被改动。测试结束时往往是有意停止的。"
            "The producer was switched off, disconnected or has ended its program; its 1005h or 1006h was changed outside of the capture. At the end of a test this is often meant.";
        Stopped { silence: Ns, period: Ns }
            "已有{silence}没有同步报文, 原来的周期为{period}; 节点仍处于操作状态"
            "no SYNC for {silence}, the period was {period}; the node is still Operational";
    }
}
