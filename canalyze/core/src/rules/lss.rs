//! Rules about LSS (CiA 305).

use super::quantity::{Count, Hex2, Hex8, Lss, LssError, Ns};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// A command specifier that CiA 305 does not define for this side, or a frame of another length than 8 bytes.
    Lss001 "LSS001" "unknown-command" Warning "CiA 305" [Lss] {
        message "未定义的LSS报文" "undefined LSS frame";
        meaning
            "LSS报文总是8字节, 首字节是命令字; CiA 305没有为这一方定义该命令字, 或者长度不对。"
            "LSS frames always have 8 bytes, the first is the command specifier; CiA 305 does not define this one for this side, or the length is wrong.";
        cause
            "协议栈实现有误, 数据损坏, 或者7E4h/7E5h上不是LSS。"
            "A fault of a stack, corrupt data, or something else than LSS on 7E4h and 7E5h.";
        ByMaster { command: Hex2 }
            "主站发送了未定义的命令字 {command}"
            "undefined command specifier {command} from the master";
        BySlave { command: Hex2 }
            "从站发送了未定义的命令字 {command}"
            "undefined command specifier {command} from a slave";
        Length { length: Count }
            "LSS帧长度为{length}字节, 应为8字节"
            "LSS frame of {length} bytes instead of 8";
    }

    /// A slave's frame that no request explains.
    Lss002 "LSS002" "answer-without-request" Warning "CiA 305" [Lss] {
        message "没有对应请求的LSS应答" "LSS answer without request";
        meaning
            "LSS从站只应答主站的请求; 记录中此前和紧接其后都没有同类的请求。"
            "LSS slaves only answer the master's requests; the capture has no request of this kind before the answer or right after it.";
        cause
            "从站实现有误, 或者记录中缺少主站的帧。"
            "A fault of the slave, or frames of the master missing from the capture.";
        Unrequested { command: Lss }
            "应答 {command} 没有对应的请求"
            "answer {command} has no request";
    }

    /// A configuration command while no slave is in the configuration state.
    Lss003 "LSS003" "configuration-without-selection" Warning "CiA 305" [Lss] {
        message "没有从站处于配置状态时发送配置命令" "configuration command while no slave is in the configuration state";
        meaning
            "配置和查询命令只有配置状态的从站才执行; 主站已把所有从站切换到等待状态, 之后没有选中任何从站。"
            "Only slaves in the configuration state follow configure and inquire commands; the master has switched all slaves to waiting and selected none since.";
        cause
            "主站漏掉了切换状态, 或者没有检查选择性切换是否得到应答。"
            "The master leaves out the switch of the state, or does not check that its selective switch was answered.";
        NotSelected { command: Lss }
            "没有从站处于配置状态, 主站却发送了 {command}"
            "{command} from the master, but no slave is in the configuration state";
    }

    /// A slave refuses a node-ID, a bit timing, or to store them.
    Lss004 "LSS004" "error-code" Warning "CiA 305" [Lss] {
        message "LSS从站应答了错误码" "LSS slave answered with an error code";
        meaning
            "从站没有接受节点ID或位定时, 或者没有存储配置。错误码FFh表示制造商定义的错误, 其含义见设备手册。"
            "The slave has not accepted the node-ID or the bit timing, or has not stored its configuration. Error code FFh is the manufacturer's own: see the device's manual.";
        cause
            "节点ID不在1到127之内, 从站不支持该波特率或不支持存储, 或者存储介质出错。"
            "A node-ID out of 1 to 127, a bit rate or storage that the slave does not support, or a storage fault.";
        Refused { command: Lss, error: LssError }
            "{command} 被拒绝: 错误码 {error}"
            "{command} refused: error code {error}";
        RefusedSpecific { command: Lss, error: LssError, specific: Hex2 }
            "{command} 被拒绝: 错误码 {error}, 特定错误码 {specific}"
            "{command} refused: error code {error}, specific error code {specific}";
    }

    /// A node-ID was given and should be in effect, and no node has booted up with it.
    Lss005 "LSS005" "no-boot-up-after-node-id" Info "CiA 305" [Lss, ErrorControl] {
        message "配置节点ID后没有以新节点ID启动" "no boot-up with the new node-ID";
        meaning
            "没有节点ID的从站回到等待状态后以新节点ID启动; 已有节点ID的从站在复位通信后, 或存储后重新启动时才使用新节点ID。"
            "A slave without node-ID boots up with the new one as it returns to waiting; one that has a node-ID uses the new one after a reset of its communication, or as it restarts if it was stored.";
        cause
            "从站要求重新上电, 没有存储配置就复位了节点, 或者启动报文不在记录中。"
            "The slave needs a power cycle, it was reset without having stored its configuration, or the boot-up is not in the capture.";
        NoBootUp { node: Count, limit: Ns }
            "{limit}内没有节点以节点ID {node} 启动"
            "no node has booted up with node-ID {node} within {limit}";
        OldNodeId { found: Count, expected: Count }
            "节点仍以节点ID {found} 启动, 应为 {expected}"
            "the node boots up with node-ID {found} still, {expected} was due";
    }

    /// A bit timing was configured and neither activated nor stored.
    Lss006 "LSS006" "bit-timing-not-activated" Info "CiA 305" [Lss] {
        message "位定时已配置, 但没有激活也没有存储" "bit timing configured, but neither activated nor stored";
        meaning
            "从站接受了位定时, 之后回到等待状态, 而主站既没有激活位定时(15h), 也没有存储配置(17h): 波特率没有改变。"
            "A slave has accepted a bit timing and returned to waiting, but the master has neither activated it (15h) nor stored the configuration (17h): the bit rate stays as it is.";
        cause
            "主站漏掉了激活位定时或存储配置。"
            "The master leaves out the activation or the storage.";
    }

    /// More than one slave answers what only one should.
    Lss007 "LSS007" "several-answers" Warning "CiA 305" [Lss] {
        message "不止一个从站应答" "more than one slave answers";
        meaning
            "配置节点ID和查询命令只应有一个从站处于配置状态; 应答来自哪个从站无法区分。"
            "Configure node-ID and inquire are for one slave in the configuration state; nothing in the answers tells the slaves apart.";
        cause
            "全局切换到配置状态时总线上有多个从站, 选中下一个从站之前没有切换到等待状态, 或者两个从站的LSS地址相同。"
            "All slaves were switched to configuration, the master selects the next slave without a switch to waiting, or two slaves have the same LSS address.";
        InConfiguration { command: Lss }
            "{command} 得到了不止一个应答: 不止一个从站处于配置状态"
            "{command} was answered more than once: more than one slave is in the configuration state";
        SameAddress { command: Lss }
            "{command} 不止一个: 不止一个从站具有该LSS地址"
            "{command} more than once: more than one slave has this LSS address";
    }

    /// A frame while the bus should be silent for the change of the bit rate.
    Lss008 "LSS008" "frame-during-switch-delay" Warning "CiA 305" [Lss] {
        message "切换延迟期间有报文" "frame during the switch delay";
        meaning
            "激活位定时后, 从站在一个切换延迟后改变波特率, 再等待一个切换延迟才能发送; 期间任何节点都不应发送。"
            "After the activation of a bit timing slaves change their bit rate one switch delay later and send nothing for another one; no node may send in that time.";
        cause
            "主站没有等待, 或者总线上还有不参与切换的节点。"
            "The master does not wait, or nodes on the bus take no part in the change.";
        Frame { elapsed: Ns, silence: Ns }
            "激活位定时后{elapsed}有报文, 总线应静默{silence}"
            "a frame {elapsed} after the activation of the bit timing, the bus has to be silent for {silence}";
    }

    /// The selected slave does not answer.
    Lss009 "LSS009" "request-unanswered" Warning "CiA 305" [Lss] {
        message "已选中的从站没有应答" "selected slave does not answer";
        meaning
            "处于配置状态的从站必须应答配置和查询命令。"
            "A slave in the configuration state answers configure and inquire commands.";
        cause
            "从站不支持该命令, 已复位或已断开, 或者应答太慢。"
            "The slave does not support the command, was reset or disconnected, or is too slow.";
        NoResponseWithin { command: Lss, limit: Ns }
            "已选中的从站在{limit}内没有应答 {command}"
            "the selected slave has not answered {command} within {limit}";
        NoResponse { command: Lss }
            "主站继续之前没有收到对 {command} 的应答"
            "no answer to {command} before the master went on";
    }

    /// A Fastscan step that no slave answers.
    Lss010 "LSS010" "invalid-fastscan" Info "CiA 305" [Lss] {
        message "无效的快速扫描参数" "invalid Fastscan parameter";
        meaning
            "BitCheck只能是0到31或80h, LSSSub和LSSNext只能是0到3; 从站忽略其他值。"
            "BitCheck is 0 to 31 or 80h, LSSSub and LSSNext are 0 to 3; slaves ignore other values.";
        cause
            "主站的快速扫描实现有误。"
            "A fault in the master's Fastscan.";
        BitCheck { found: Hex2 }
            "无效的BitCheck {found}"
            "invalid BitCheck {found}";
        SubOrNext { sub: Count, next: Count }
            "无效的LSSSub={sub}或LSSNext={next}"
            "invalid LSSSub={sub} or LSSNext={next}";
    }

    /// The parts of a selective switch are not in their order.
    Lss011 "LSS011" "selective-order" Warning "CiA 305" [Lss] {
        message "选择性切换状态的顺序不对" "parts of a selective switch out of order";
        meaning
            "LSS地址必须按制造商ID、产品码、修订号、序列号(40h到43h)的顺序发送; 顺序不对时从站可以不应答。"
            "The LSS address is sent as vendor-ID, product code, revision number, serial number (40h to 43h), in this order; a slave need not answer another one.";
        cause
            "主站漏发或重发了其中一帧。"
            "The master has left out or repeated one of the frames.";
        Order { found: Lss, expected: Lss }
            "收到 {found}, 应为 {expected}"
            "{found} came, {expected} was due";
    }

    /// No slave answers.
    Lss012 "LSS012" "no-slave-answers" Info "CiA 305" [Lss] {
        message "没有从站应答" "no slave answers";
        meaning
            "没有从站具有该LSS地址, 或者全局切换后总线上没有LSS从站。"
            "No slave has this LSS address, or after a global switch there is no LSS slave on the bus.";
        cause
            "从站不存在或未上电(主站在查找), 或者LSS地址写错。"
            "The slave does not exist or has no power (a master searches), or the LSS address is mistyped.";
        Address { vendor: Hex8, product: Hex8, revision: Hex8, serial: Hex8 }
            "没有从站应答该LSS地址: 制造商ID={vendor}, 产品码={product}, 修订号={revision}, 序列号={serial}"
            "no slave answers to the LSS address vendor-ID={vendor}, product code={product}, revision number={revision}, serial number={serial}";
        Command { command: Lss, limit: Ns }
            "{limit}内没有从站应答 {command}"
            "no slave has answered {command} within {limit}";
    }

    /// The traffic on these identifiers does not look like LSS.
    Lss030 "LSS030" "not-lss" Info "-" [Lss] {
        message "7E4h/7E5h上的报文不像LSS" "traffic on 7E4h and 7E5h does not look like LSS";
        meaning
            "没有出现过一对有效的请求和应答, 因此不作LSS判断。"
            "No valid pair of request and answer was seen, so these frames are not judged as LSS.";
        cause
            "网络不是CANopen, 只记录到一个方向, 或者总线上没有LSS从站。"
            "The network is not CANopen, only one direction was captured, or there is no LSS slave.";
    }
}
