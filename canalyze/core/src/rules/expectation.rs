//! Rules about a user's expectations of a capture (`canalyze check --expect`).

use crate::bytes::ns::Ns;

use super::quantity::{Command, Count, Emcy, JsonOnly, Pdo, Problems, Quantity, Real, Said, State, Text, Word};
use super::{Deviation, rules};

rules! {
    Deviation:

    /// 期望要求出现这一传输, 但它没有出现, 或者次数不够、出现过晚。到记录结束时仍未完成的传输视为没有出现。
    /// The expectation requires this transfer; it did not occur, or not often or early enough. A transfer still running at the end of the capture does not count.
    ///
    /// 主站不再像以前那样配置该节点, 节点不在线, 记录太短, 或者期望文件已过时。
    /// The master does not configure the node as before, the node was offline, the capture is too short, or the expectation is out of date.
    Exp001 "EXP001" "transfer-missing" Error "-" [Sdo] {
        message "缺少期望的SDO传输" "expected SDO transfer missing";
        NoTransfer { expected: JsonOnly<Said> } "没有这样的传输" "no such transfer";
        NoRead { expected: JsonOnly<Said> } "没有这样的读取" "no such read";
        NoWrite { expected: JsonOnly<Said> } "没有这样的写入" "no such write";
        NoTransferOf { expected: Said } "没有传输{expected}" "no transfer of {expected}";
        NoReadOf { expected: Said } "没有读到{expected}" "no read of {expected}";
        NoWriteOf { expected: Said } "没有写入{expected}" "no write of {expected}";
        TooFew { expected: Count, found: Count }
            "这样的传输有{found}次, 期望至少{expected}次" "{found|such transfer|such transfers}, expected at least {expected}";
        Late { expected: Ns, found: Ns }
            "在记录开始后{found}才出现, 期望在{expected}之内" "{found} after the start of the capture, expected within {expected}";
        NotCompleted { expected: JsonOnly<Said> }
            "传输从这一帧开始, 到记录结束时仍未完成" "the transfer started here and was not completed in the capture";
        NoAbort { expected: JsonOnly<Said> } "没有被中止的传输" "no aborted transfer";
        NoAbortWith { expected: Said } "没有以{expected}中止的传输" "no transfer aborted with {expected}";
    }

    /// 序列中的传输必须按所列次序完成, 中间可以有其他传输。这一传输出现过早, 之后也没有在应有的位置再次出现。
    /// The transfers of a sequence must complete in the listed order; others may come in between. This one came too early, and not again at its place.
    ///
    /// 主站的配置次序改变了, 或者有几个客户端同时工作。
    /// The master's configuration sequence has changed, or several clients work at the same time.
    Exp002 "EXP002" "transfer-out-of-order" Error "-" [Sdo] {
        message "SDO传输的次序与期望不同" "SDO transfer out of the expected order";
        TooEarly { sequence: Text, before: Text } "过早: 序列{sequence}中应先完成{before}的传输"
            "too early: in sequence {sequence} the transfer of {before} must come first";
    }

    /// 该对象有过传输, 但值或结果不符, 期望的传输没有出现。有多次时指出最后一次。
    /// The object was transferred, but with another value or result, and the expected transfer did not occur. Of several transfers the last one is named.
    ///
    /// 配置或固件不同, 或者节点有故障。
    /// Another configuration, another firmware, or a node fault.
    Exp003 "EXP003" "transfer-differs" Error "-" [Sdo] {
        message "SDO传输与期望不符" "SDO transfer differs from the expectation";
        Value { expected: Said, found: Said } "值为{found}, 期望为{expected}" "value {found}, expected {expected}";
        Aborted { expected: JsonOnly<Said>, found: Said } "以{found}中止, 期望成功" "aborted with {found}, expected success";
        Succeeded { expected: JsonOnly<Said>, found: JsonOnly<Said> } "成功, 期望被中止" "succeeded, expected an abort";
        SucceededNotWith { expected: Said, found: JsonOnly<Said> }
            "成功, 期望以{expected}中止" "succeeded, expected an abort with {expected}";
        AbortedOtherwise { expected: Said, found: Said }
            "以{found}中止, 期望为{expected}" "aborted with {found}, expected {expected}";
        Failed { expected: JsonOnly<Said>, found: JsonOnly<Said> }
            "因违反SDO协议而失败, 与期望不符" "failed by a violation of the SDO protocol, expected otherwise";
    }

    /// 期望规定这一传输不得出现。
    /// The expectation forbids this transfer.
    ///
    /// 另有客户端或工具访问该节点, 或者主站有了新的动作。
    /// Another client or tool accesses the node, or the master does something new.
    Exp004 "EXP004" "forbidden-transfer" Error "-" [Sdo] {
        message "不应出现的SDO传输" "SDO transfer that must not occur";
        Occurred "不应出现" "must not occur";
        OccurredWith { found: Said } "不应出现 ({found})" "must not occur ({found})";
    }

    /// 启动报文、心跳或节点保护应答(驱动器为状态字)报告该状态才算进入, 仅有命令不算。时间以首个报告该状态的帧为准。
    /// A state counts as reached when a boot-up, heartbeat or node guarding response, or a drive's statusword, reports it; a command alone does not. The time is that of the first frame that reports it.
    ///
    /// 节点启动时卡住, 主站没有启动它, 节点报告错误, 或者启动比以前慢。
    /// The node hangs during start, was not started by the master, reports an error, or is slower than before.
    Exp005 "EXP005" "state-not-reached" Error "-" [ErrorControl, Nmt, Pdo, Sdo] {
        message "未进入期望的状态" "expected state not reached";
        Never { expected: Quantity, found: Quantity }
            "从未进入{expected}, 最后的状态为{found}" "never {expected}; last state is {found}";
        NeverAnything { expected: Quantity }
            "从未进入{expected}, 记录中也没有该节点的其他状态" "never {expected}, and no other state of the node in the capture";
        LateAfterStart { expected: Quantity, limit: Ns, found: Ns } "记录开始后{found}才进入{expected}, 期望在{limit}之内"
            "{expected} {found} after the start of the capture, expected within {limit}";
        LateAfterBootUp { expected: Quantity, limit: Ns, found: Ns }
            "启动报文之后{found}才进入{expected}, 期望在{limit}之内" "{expected} {found} after the boot-up, expected within {limit}";
        NoBootUp { expected: JsonOnly<Quantity> } "没有启动报文" "no boot-up";
        BootUpLate { expected: JsonOnly<Quantity>, limit: Ns, found: Ns } "记录开始后{found}才有启动报文, 期望在{limit}之内"
            "boot-up {found} after the start of the capture, expected within {limit}";
        NotSinceBootUp { expected: Quantity, limit: Ns, found: Quantity }
            "上次启动报文之后没有进入{expected}, 期望在{limit}之内; 最后的状态为{found}"
            "not {expected} since the last boot-up, expected within {limit}; last state is {found}";
    }

    /// 期望规定节点(或其驱动器)进入这一状态后保持不变。
    /// The expectation requires the node, or its drive, to keep this state once it is reached.
    ///
    /// 收到命令, 出现错误并作出反应(1029h、驱动器故障), 复位, 或者电源跌落。
    /// A command, an error and its reaction (1029h, drive fault), a reset or a supply dip.
    Exp006 "EXP006" "state-left" Error "-" [ErrorControl, Nmt, Pdo, Sdo] {
        message "离开了应保持的状态" "required state left";
        Left { expected: Quantity, found: Quantity } "离开{expected}, 变为{found}" "left {expected} for {found}";
        BootedUp { expected: Quantity, found: JsonOnly<Quantity> }
            "节点重新启动, 期望保持{expected}" "booted up, expected to stay {expected}";
    }

    /// 物理值(已计入符号、类型和系数)小于期望的最小值或大于最大值。
    /// The physical value (with sign, type and factor) is below the expected minimum or above the expected maximum.
    ///
    /// 工况不同, 传感器或其换算有误, 或者使用了另一份描述文件或映射。
    /// Different operating conditions, a wrong sensor or scaling, or another description or mapping.
    Exp007 "EXP007" "signal-out-of-range" Error "-" one [Pdo] {
        message "信号超出期望的范围" "signal outside its expected range";
        Below { pdo: Pdo, limit: JsonOnly<Word>, expected: Real, found: Real }
            "{pdo}中的值{found}小于{expected}" "{found} in {pdo} is below {expected}";
        Above { pdo: Pdo, limit: JsonOnly<Word>, expected: Real, found: Real }
            "{pdo}中的值{found}大于{expected}" "{found} in {pdo} is above {expected}";
    }

    /// 带有该信号的PDO前后两次的间隔超出期望的周期及其容差。跨越启动报文、停止PDO的NMT命令和记录缺口的间隔不计。
    /// The interval between two PDOs with the signal is outside the expected period and its tolerance. Intervals across boot-ups, NMT commands that stop PDOs and gaps in the capture are not measured.
    ///
    /// 事件定时器、抑制时间、传输类型或同步周期改变, 总线繁忙, 或者节点不再发送。
    /// Event timer, inhibit time, transmission type or SYNC period have changed, the bus is busy, or the node has stopped sending.
    Exp008 "EXP008" "signal-rate" Error "-" one [Pdo] {
        message "信号的周期与期望不符" "signal not at its expected period";
        Interval { pdo: Pdo, expected: Ns, found: Ns, tolerance: Ns } "{pdo}距上一帧{found}, 期望周期{expected}(容差{tolerance})"
            "{pdo} {found} after the previous one, expected every {expected} (tolerance {tolerance})";
        Overdue { pdo: Pdo, expected: Ns, found: Ns, tolerance: Ns } "已{found}没有{pdo}, 期望周期{expected}(容差{tolerance})"
            "no {pdo} for {found}, expected every {expected} (tolerance {tolerance})";
    }

    /// 前后两次心跳的间隔超出期望的周期及其容差, 或者没有心跳。状态改变时允许额外的心跳。跨越复位、启动报文和记录缺口的间隔不计。
    /// The interval between two heartbeats is outside the expected period and its tolerance, or there is none. Additional heartbeats at a state change are legal. Intervals across resets, boot-ups and gaps in the capture are not measured.
    ///
    /// 1017h的值不同, 节点繁忙、卡死或已离线。
    /// 1017h has another value, or the node is busy, hung or offline.
    Exp009 "EXP009" "heartbeat-period" Error "-" [ErrorControl, Nmt] {
        message "心跳周期与期望不符" "heartbeat not at its expected period";
        Interval { expected: Ns, found: Ns, tolerance: Ns } "距上次心跳{found}, 期望周期{expected}(容差{tolerance})"
            "heartbeat {found} after the previous one, expected every {expected} (tolerance {tolerance})";
        Overdue { expected: Ns, found: Ns, tolerance: Ns } "已{found}没有心跳, 期望周期{expected}(容差{tolerance})"
            "no heartbeat for {found}, expected every {expected} (tolerance {tolerance})";
        None { expected: Ns } "记录中没有心跳, 期望周期{expected}" "no heartbeat in the capture, expected every {expected}";
    }

    /// 前后两个同步报文的间隔超出期望的周期及其容差, 或者没有同步报文。跨越记录缺口的间隔不计。
    /// The interval between two SYNCs is outside the expected period and its tolerance, or there is none. Intervals across gaps in the capture are not measured.
    ///
    /// 1006h的值不同, 生产者繁忙或已停止, 或者时间戳的精度低于容差。
    /// 1006h has another value, the producer is busy or stopped, or the timestamps are less accurate than the tolerance.
    Exp010 "EXP010" "sync-period" Error "-" [Sync] {
        message "同步周期与期望不符" "SYNC not at its expected period";
        Interval { expected: Ns, found: Ns, tolerance: Ns } "距上一同步报文{found}, 期望周期{expected}(容差{tolerance})"
            "SYNC {found} after the previous one, expected every {expected} (tolerance {tolerance})";
        Overdue { expected: Ns, found: Ns, tolerance: Ns } "已{found}没有同步报文, 期望周期{expected}(容差{tolerance})"
            "no SYNC for {found}, expected every {expected} (tolerance {tolerance})";
        None { expected: Ns } "记录中没有同步报文, 期望周期{expected}" "no SYNC in the capture, expected every {expected}";
    }

    /// 期望要求出现这一紧急报文。
    /// The expectation requires this EMCY.
    ///
    /// 测试引发的故障没有被检测到, 或者节点以另一错误码报告。
    /// The fault provoked by the test was not detected, or the node reports it with another error code.
    Exp011 "EXP011" "emcy-missing" Error "-" [Emcy] {
        message "缺少期望的紧急报文" "expected EMCY missing";
        None "没有紧急报文" "no EMCY";
        NoneOf { expected: Said } "没有紧急报文{expected}" "no EMCY {expected}";
    }

    /// 期望规定这一紧急报文不得出现, 或者只允许所列的紧急报文。错误复位(00xxh)不计, 除非写明了它的错误码。
    /// The expectation forbids this EMCY, or allows only those it lists. Error resets (00xxh) do not count unless their code is given.
    ///
    /// 节点出现了编写期望时没有的故障。
    /// The node has a fault that was not present when the expectation was written.
    Exp012 "EXP012" "emcy-unexpected" Error "-" [Emcy] {
        message "不应出现的紧急报文" "EMCY that must not occur";
        Occurred [expected = "never"] { found: Emcy } "{found}不应出现" "{found} must not occur";
    }

    /// 测量的是: SDO请求到其响应, 同步报文到同步TPDO, 或者NMT命令到首个报告相应状态的错误控制帧。记录次序颠倒的不计。
    /// Measured from an SDO request to its response, from SYNC to a synchronous TPDO, or from an NMT command to the first error control frame that reports the state. Pairs captured in reverse order are not measured.
    ///
    /// 节点繁忙, 总线负载高, 网关太慢; 对NMT命令则是心跳周期太长。
    /// A busy node, high bus load, a slow gateway; for NMT commands also a long heartbeat period.
    Exp013 "EXP013" "latency" Error "-" here [Sdo, Sync, Pdo, Nmt] {
        message "用时超过期望" "longer than expected";
        Response { expected: Ns, found: Ns }
            "请求之后{found}才有响应, 期望在{expected}之内" "response {found} after the request, expected within {expected}";
        Sync { expected: Ns, found: Ns, pdo: Pdo }
            "同步报文之后{found}才有{pdo}, 期望在{expected}之内" "{pdo} {found} after the SYNC, expected within {expected}";
        Command { expected: Ns, found: Ns, command: Command } "NMT命令“{command}”在{found}之后才生效, 期望在{expected}之内"
            "NMT command \"{command}\" took effect after {found}, expected within {expected}";
        CommandPending { expected: Ns, found: Ns, command: Command, state: State }
            "NMT命令“{command}”之后{found}仍处于{state}, 期望在{expected}之内"
            "still {state} {found} after NMT command \"{command}\", expected within {expected}";
    }

    /// 窗口内总线上的位数(含填充位)占波特率的百分比超过期望。每次超过上限只报告一次。
    /// The bits on the bus within the window (including stuff bits) exceed the expected share of the bit rate. Reported once each time the limit is exceeded.
    ///
    /// PDO比以前多或周期更短, 某个节点大量发送, 或者帧被重发。
    /// More PDOs or shorter periods than before, a node that floods the bus, or repeated frames.
    Exp014 "EXP014" "bus-load" Error "-" [Sdo, Pdo, ErrorControl, Emcy, Srdo, Nmt, Sync, Other] {
        message "总线负载超过期望的上限" "bus load above the expected limit";
        Above { window: Ns, expected: Real, found: Real } "{window}内总线负载为{found} %, 期望不超过{expected} %"
            "bus load {found} % within {window}, expected at most {expected} %";
    }

    /// 记录不足以说明该期望是否成立, 因此不作判断。
    /// The capture does not show whether the expectation holds, so it is not judged.
    ///
    /// 记录没有时间戳, 波特率未知(--bitrate), PDO没有描述文件(--eds), 或者过程的开头未录到。
    /// No timestamps, unknown bit rate (--bitrate), no description (--eds) for the PDOs, or the start is not in the capture.
    Exp015 "EXP015" "expectation-not-checked" Info "-" [Sdo, Pdo, ErrorControl, Emcy, Srdo, Nmt, Sync, Other] {
        message "期望未能检查" "expectation not checked";
        NoStamps "记录没有时间戳, 时间未检查" "no timestamps: times not checked";
        NoBitRate "波特率未知, 负载未检查" "unknown bit rate: load not checked";
        NoMapping "有些PDO的映射未知, 可能带有该信号" "some PDOs with unknown mapping may carry it";
        NotWhole "传输的数据不完整, 值未检查" "transfer data incomplete: value not checked";
        OnlyCommanded { expected: Quantity } "已命令进入{expected}, 但节点不发送报告状态的错误控制帧"
            "commanded to {expected}, but the node sends no error control that reports its state";
        SinceWhen { expected: Quantity, found: Ns } "记录开始后{found}首次出现时已处于{expected}, 何时进入未知"
            "already {expected} when first seen, {found} after the start of the capture; since when is unknown";
        NoBootUp "记录中此前没有可用于计时的启动报文" "no earlier boot-up in the capture to measure from";
        NothingMeasured "记录中没有可以测量的内容" "nothing to measure in the capture";
        NotOverYet { problem: Problems } "{problem}: 记录结束时期限未到, 是否按期恢复未检查"
            "{problem}: the capture ends before the deadline, recovery in time not checked";
        Lost "此前有帧丢失: 它可能在丢失的帧中" "frames were lost before: it may have been among them";
    }

    /// 记录中没有任何PDO带有这一名称的信号。
    /// No PDO in the capture has a signal of this name.
    ///
    /// 节点没有发送该PDO, 映射改变了, 名称写法不同, 或者缺少描述文件(--eds)。
    /// The node does not send the PDO, its mapping has changed, the name is spelled differently, or the description (--eds) is missing.
    Exp016 "EXP016" "signal-missing" Error "-" one [Pdo] {
        message "缺少期望的信号" "expected signal missing";
        None { expected: Text } "记录中没有信号{expected}" "no signal {expected} in the capture";
    }

    /// 期望要求出现这一种问题(见 canalyze diagnose), 但它没有出现, 或者次数不够。反复出现的, 每次都计入。
    /// The expectation requires this kind of problem (see canalyze diagnose); it did not occur, or not often enough. Each occurrence of a recurring problem counts.
    ///
    /// 测试引发的故障没有发生, 或者表现为另一种问题。
    /// The fault provoked by the test did not happen, or shows as another kind of problem.
    Exp017 "EXP017" "problem-missing" Error "-" [ErrorControl, Nmt, Emcy, Sdo, Pdo, Sync, Error] {
        message "缺少期望的问题" "expected problem missing";
        Nothing { expected: Text } "没有出现{expected}, 也没有其他问题" "no {expected}, and no other problem either";
        NoneOf { expected: Text, found: Problems }
            "没有出现{expected}; 实际出现: {found}" "no {expected}; found instead: {found}";
        TooFew { expected: Count, count: Count, found: Problems }
            "出现{count}次, 期望至少{expected}次: {found}" "{count|time|times}, expected at least {expected}: {found}";
    }

    /// 期望规定这一种问题不得出现, 或者限制其次数, 或者只允许所列的问题。未写种类时, 由其他问题引起的和无害的不计。
    /// The expectation forbids this kind of problem, limits its count, or allows only those it lists. Without a kind, consequences of other problems and harmless ones do not count.
    ///
    /// 出现了编写期望时没有的问题; canalyze diagnose 说明其经过和原因。
    /// A problem that did not exist when the expectation was written; canalyze diagnose shows its course and cause.
    Exp018 "EXP018" "problem-unexpected" Error "-" [ErrorControl, Nmt, Emcy, Sdo, Pdo, Sync, Error] {
        message "不应出现的问题" "problem that must not occur";
        Occurred { found: Problems } "不应出现: {found}" "must not occur: {found}";
        TooMany { expected: Count, count: Count, found: Problems }
            "出现{count}次, 期望至多{expected}次: {found}" "{count|time|times}, expected at most {expected}: {found}";
    }

    /// 期望规定此类问题须在一定时间内恢复, 从第一个迹象算起(节点失去联系从其最后一帧算起)。反复出现的, 以最长的一次为准。
    /// The expectation requires such problems to end within a time, counted from the first evidence (for a silent node, its last frame). For a recurring problem the longest time counts.
    ///
    /// 恢复比以前慢, 或者没有恢复。
    /// Recovery is slower than before, or does not happen.
    Exp019 "EXP019" "problem-not-ended" Error "-" [ErrorControl, Nmt, Emcy, Sdo, Pdo, Sync, Error] {
        message "问题没有按期恢复" "problem not ended in time";
        Late { expected: Ns, found: Ns, problem: Problems, end: Count }
            "{problem}经过{found}才恢复(第{end}帧), 期望在{expected}之内"
            "{problem} ended after {found} (frame {end}), expected within {expected}";
        Standing { expected: Ns, found: Ns, problem: Problems } "{problem}到记录结束时已有{found}, 仍未恢复, 期望在{expected}之内"
            "{problem} still open after {found} at the end of the capture, expected to end within {expected}";
    }

    /// 期望规定此类问题须由某一种问题直接或间接引起。仅为可能的原因不计。
    /// The expectation requires such problems to be caused, directly or indirectly, by another kind of problem. A merely possible cause does not count.
    ///
    /// 出现了另外的问题, 或者记录不足以判断原因。
    /// Another problem occurred, or the capture does not show the cause.
    Exp020 "EXP020" "problem-cause" Error "-" [ErrorControl, Nmt, Emcy, Sdo, Pdo, Sync, Error] {
        message "问题的原因与期望不符" "problem with another cause than expected";
        Other { expected: Text, problem: Problems, found: Problems }
            "{problem}的原因为{found}, 期望为{expected}" "{problem} is caused by {found}, expected {expected}";
        NotSure { expected: Text, problem: Problems, found: Problems } "{problem}的原因可能为{found}(不确定), 期望为{expected}"
            "{problem} may be caused by {found} (uncertain), expected {expected}";
        Unknown { expected: Text, problem: Problems }
            "{problem}的原因不明, 期望为{expected}" "cause of {problem} unknown, expected {expected}";
    }
}
