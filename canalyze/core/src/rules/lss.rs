//! Rules about LSS (CiA 305).

use crate::bytes::ns::Ns;

use super::quantity::{Count, Hex2, Hex8, Lss, LssError};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// LSS报文总是8字节, 首字节是命令字; CiA 305没有为这一方定义该命令字, 或者长度不对。
    /// LSS frames are always 8 bytes long and start with the command specifier; CiA 305 does not define this one for this side, or the length is wrong.
    ///
    /// 协议栈实现有误, 数据损坏, 或者7E4h/7E5h上不是LSS。
    /// A stack bug, corrupt data, or another protocol on 7E4h and 7E5h.
    Lss001 "LSS001" "unknown-command" Warning "CiA 305" [Lss] {
        message "未定义的LSS报文" "undefined LSS frame";
        ByMaster { command: Hex2 } "主站发送了未定义的命令字{command}" "undefined command specifier {command} from the master";
        BySlave { command: Hex2 } "从站发送了未定义的命令字{command}" "undefined command specifier {command} from a slave";
        Length { length: Count } "LSS帧长度为{length}字节, 应为8字节" "LSS frame is {length|byte|bytes} long, expected 8";
    }

    /// LSS从站只响应主站的请求; 记录中此前和紧接其后都没有同类请求。
    /// LSS slaves only respond to the master's requests; the capture has no request of this kind before the response or right after it.
    ///
    /// 从站实现有误, 或者记录中缺少主站的帧。
    /// A slave bug, or frames of the master missing from the capture.
    Lss002 "LSS002" "answer-without-request" Warning "CiA 305" [Lss] {
        message "没有对应请求的LSS响应" "LSS response without request";
        Unrequested { command: Lss } "收到“{command}”的响应, 但没有对应的请求" "response to \"{command}\" without a request";
    }

    /// 配置和查询命令只有配置状态的从站才执行; 主站已把所有从站切换到等待状态, 之后没有选中任何从站。
    /// Only slaves in configuration state execute configure and inquire commands; the master has switched all slaves to waiting state and selected none since.
    ///
    /// 主站漏掉了切换状态, 或者没有检查选择性切换是否得到响应。
    /// The master omits the state switch, or does not check the response to its selective switch.
    Lss003 "LSS003" "configuration-without-selection" Warning "CiA 305" [Lss] {
        message "没有从站处于配置状态时发送配置命令" "configuration command while no slave is in the configuration state";
        NotSelected { command: Lss }
            "没有从站处于配置状态, 主站却发送了“{command}”" "\"{command}\" from the master while no slave is in configuration state";
    }

    /// 从站没有接受节点ID或位定时, 或者没有存储配置。错误码FFh表示制造商定义的错误, 其含义见设备手册。
    /// The slave did not accept the node-ID or the bit timing, or did not store its configuration. Error code FFh is manufacturer-specific: see the device's manual.
    ///
    /// 节点ID不在1到127之内, 从站不支持该波特率或不支持存储, 或者存储介质出错。
    /// A node-ID outside 1 to 127, a bit rate or storage that the slave does not support, or a storage fault.
    Lss004 "LSS004" "error-code" Warning "CiA 305" [Lss] {
        message "LSS从站响应了错误码" "LSS slave responded with an error code";
        Refused { command: Lss, error: LssError }
            "“{command}”被拒绝: 错误码{error}" "\"{command}\" refused: error code {error}";
        RefusedSpecific { command: Lss, error: LssError, specific: Hex2 } "“{command}”被拒绝: 错误码{error}, 特定错误码{specific}"
            "\"{command}\" refused: error code {error}, specific error code {specific}";
    }

    /// 没有节点ID的从站回到等待状态后以新节点ID启动; 已有节点ID的从站在复位通信后, 或存储后重新启动时才使用新节点ID。
    /// A slave without node-ID boots up with the new one when it returns to waiting state; one that has a node-ID uses the new one after reset communication, or after a restart if it was stored.
    ///
    /// 从站要求重新上电, 没有存储配置就复位了节点, 或者启动报文不在记录中。
    /// The slave needs a power cycle, it was reset without storing its configuration, or the boot-up is not in the capture.
    Lss005 "LSS005" "no-boot-up-after-node-id" Info "CiA 305" [Lss, ErrorControl] {
        message "配置节点ID后没有以新节点ID启动" "no boot-up with the new node-ID";
        NoBootUp { node: Count, limit: Ns }
            "{limit}内没有节点以节点ID {node}启动" "no node booted up with node-ID {node} within {limit}";
        OldNodeId { found: Count, expected: Count }
            "节点仍以节点ID {found}启动, 应为{expected}" "node still boots up with node-ID {found}, expected {expected}";
    }

    /// 从站接受了位定时, 之后回到等待状态, 而主站既没有激活位定时(15h), 也没有存储配置(17h): 波特率没有改变。
    /// A slave accepted a bit timing and returned to waiting state, but the master neither activated it (15h) nor stored the configuration (17h): the bit rate does not change.
    ///
    /// 主站漏掉了激活位定时或存储配置。
    /// The master omits the activation or the storing.
    Lss006 "LSS006" "bit-timing-not-activated" Info "CiA 305" [Lss] {
        message "位定时已配置, 但没有激活也没有存储" "bit timing configured, but neither activated nor stored";
    }

    /// 发送配置节点ID和查询命令时只应有一个从站处于配置状态; 否则无法区分响应来自哪个从站。
    /// Configure node-ID and inquire expect a single slave in configuration state; the responses do not show which slave sent them.
    ///
    /// 全局切换到配置状态时总线上有多个从站, 选中下一个从站之前没有切换到等待状态, 或者两个从站的LSS地址相同。
    /// All slaves were switched to configuration state, the master selects the next slave without a switch to waiting state, or two slaves have the same LSS address.
    Lss007 "LSS007" "several-answers" Warning "CiA 305" [Lss] {
        message "不止一个从站响应" "more than one slave responds";
        InConfiguration { command: Lss } "“{command}”收到不止一个响应: 不止一个从站处于配置状态"
            "more than one response to \"{command}\": more than one slave is in configuration state";
        SameAddress { command: Lss } "收到不止一个“{command}”: 不止一个从站具有该LSS地址"
            "\"{command}\" received more than once: more than one slave has this LSS address";
    }

    /// 激活位定时后, 从站经过一个切换延迟改变波特率, 再等待一个切换延迟才能发送; 期间任何节点都不应发送。
    /// After activate bit timing, slaves change their bit rate after one switch delay and stay silent for another one; no node may send during that time.
    ///
    /// 主站没有等待, 或者总线上还有不参与切换的节点。
    /// The master does not wait, or there are nodes on the bus that do not take part in the switch.
    Lss008 "LSS008" "frame-during-switch-delay" Warning "CiA 305" [Lss] {
        message "切换延迟期间有报文" "frame during the switch delay";
        Frame { elapsed: Ns, silence: Ns } "激活位定时后{elapsed}有报文, 总线应静默{silence}"
            "frame {elapsed} after activate bit timing, the bus should be silent for {silence}";
    }

    /// 处于配置状态的从站必须响应配置和查询命令。
    /// A slave in configuration state must respond to configure and inquire commands.
    ///
    /// 从站不支持该命令, 已复位或已断开, 或者响应太慢。
    /// The slave does not support the command, was reset or disconnected, or is too slow.
    Lss009 "LSS009" "request-unanswered" Warning "CiA 305" [Lss] {
        message "已选中的从站没有响应" "selected slave does not respond";
        NoResponseWithin { command: Lss, limit: Ns }
            "已选中的从站在{limit}内没有响应“{command}”" "selected slave did not respond to \"{command}\" within {limit}";
        NoResponse { command: Lss }
            "主站没有等到“{command}”的响应就继续" "no response to \"{command}\" before the master continued";
    }

    /// BitCheck只能是0到31或80h, LSSSub和LSSNext只能是0到3; 从站忽略其他值。
    /// BitCheck is 0 to 31 or 80h, LSSSub and LSSNext are 0 to 3; slaves ignore other values.
    ///
    /// 主站的快速扫描实现有误。
    /// A bug in the master's Fastscan.
    Lss010 "LSS010" "invalid-fastscan" Info "CiA 305" [Lss] {
        message "快速扫描参数无效" "invalid Fastscan parameter";
        BitCheck { found: Hex2 } "BitCheck无效: {found}" "invalid BitCheck {found}";
        SubOrNext { sub: Count, next: Count } "LSSSub={sub}或LSSNext={next}无效" "invalid LSSSub={sub} or LSSNext={next}";
    }

    /// LSS地址必须按制造商ID、产品码、修订号、序列号(40h到43h)的顺序发送; 顺序不对时从站可以不响应。
    /// The LSS address is sent as vendor-ID, product code, revision number, serial number (40h to 43h), in this order; slaves may ignore any other order.
    ///
    /// 主站漏发或重发了其中一帧。
    /// The master omitted or repeated one of the frames.
    Lss011 "LSS011" "selective-order" Warning "CiA 305" [Lss] {
        message "选择性切换状态的顺序不对" "switch state selective out of order";
        Order { found: Lss, expected: Lss }
            "收到“{found}”, 应为“{expected}”" "received \"{found}\", expected \"{expected}\"";
    }

    /// 没有从站具有该LSS地址, 或者全局切换后总线上没有LSS从站。
    /// No slave has this LSS address, or there is no LSS slave on the bus after a global switch.
    ///
    /// 从站不存在或未上电(主站在查找), 或者LSS地址写错。
    /// The slave does not exist or has no power (the master is searching), or the LSS address is wrong.
    Lss012 "LSS012" "no-slave-answers" Info "CiA 305" [Lss] {
        message "没有从站响应" "no slave responds";
        Address { vendor: Hex8, product: Hex8, revision: Hex8, serial: Hex8 }
            "没有从站响应该LSS地址: 制造商ID={vendor}, 产品码={product}, 修订号={revision}, 序列号={serial}"
            "no slave responds to LSS address vendor-ID={vendor}, product code={product}, revision number={revision}, serial number={serial}";
        Command { command: Lss, limit: Ns }
            "{limit}内没有从站响应“{command}”" "no slave responded to \"{command}\" within {limit}";
    }

    /// 没有出现过一对有效的请求和响应, 因此不作LSS判断。
    /// No valid pair of request and response was seen, so these frames are not judged as LSS.
    ///
    /// 网络不是CANopen, 只记录到一个方向, 或者总线上没有LSS从站。
    /// The network is not CANopen, only one direction was captured, or there is no LSS slave.
    Lss030 "LSS030" "not-lss" Info "-" [Lss] {
        message "7E4h/7E5h上的报文不像LSS" "traffic on 7E4h and 7E5h does not look like LSS";
    }
}
