//! Rules about emergency messages (CiA 301, 7.2.7).

use crate::bytes::ns::Ns;

use super::quantity::{Count, Emcy, Hex2, JsonOnly, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 存在错误时错误寄存器 (1001h) 至少有一位为1; 任何错误都应置位0。
    /// While an error is present at least one bit of the error register (1001h) is set; bit 0 for any error.
    ///
    /// 固件没有更新1001h, 或者紧急报文由人工构造。
    /// The firmware does not maintain 1001h, or the EMCY was hand-made.
    Emc001 "EMC001" "code-without-register" Warning "CiA 301 7.2.7.3.1" [Emcy] {
        message "错误码不为0, 错误寄存器却为0" "error code with error register 0";
        NoRegister { code: Emcy, register: Hex2 }
            "错误码{code}, 错误寄存器为{register}" "error code {code}, error register {register}";
    }

    /// 错误码为0000h而错误寄存器不为0: 一个错误消失, 其他错误仍在。这是允许的。
    /// Error code 0000h with a non-zero register: one error is gone, others remain. This is legal.
    ///
    /// 几个错误先后消失。
    /// Several errors disappear one by one.
    Emc002 "EMC002" "partial-reset" Info "CiA 301 7.2.7.1" [Emcy] {
        message "部分错误复位" "partial error reset";
        StillSet { code: JsonOnly<Emcy>, register: Hex2 }
            "错误复位, 错误寄存器仍为{register}" "error reset, error register still {register}";
        OneLeft { register: Hex2, cleared: Emcy, left: Emcy }
            "错误{cleared}已清除, {left}仍在; 错误寄存器为{register}" "{cleared} cleared, {left} remains; error register {register}";
        SeveralLeft { register: Hex2, cleared: Emcy, left: Emcy, count: Count }
            "错误{cleared}已清除, 还有{count}个错误, 其中最早的是{left}; 错误寄存器为{register}"
            "{cleared} cleared, {count} errors remain, the oldest is {left}; error register {register}";
        UnknownLeft { register: Hex2, cleared: Emcy } "错误{cleared}已清除; 错误寄存器为{register}, 说明还有记录中没有出现的错误"
            "{cleared} cleared; error register {register} shows another error that is not in the capture";
        OneOf { register: Hex2, count: Count }
            "{count}个错误之一已清除; 错误寄存器仍为{register}" "one of {count} errors cleared; error register still {register}";
    }

    /// 错误寄存器 (1001h) 的位6保留, 必须为0。
    /// Bit 6 of the error register (1001h) is reserved and shall be 0.
    ///
    /// 固件把该位用于自己的目的, 或者字节顺序错误。
    /// The firmware uses the bit for its own purposes, or the byte order is wrong.
    Emc003 "EMC003" "reserved-register-bit" Warning "CiA 301 7.5.2.2" [Emcy] {
        message "错误寄存器的保留位不为0" "reserved bit of the error register set";
        Bit6 { code: JsonOnly<Emcy>, register: Hex2 }
            "错误寄存器为{register}, 位6保留" "error register is {register}, bit 6 is reserved";
    }

    /// 在停止状态和启动报文之前, 节点不应发送紧急报文。
    /// A node must not send EMCYs in Stopped, nor before its boot-up.
    ///
    /// 设备没有按NMT状态关闭EMCY服务; 有些制造商的设备如此。
    /// The device does not disable the EMCY service with the NMT state; some vendors' devices do not.
    Emc004 "EMC004" "emcy-in-wrong-state" Warning "CiA 301 7.3.2.2" [Emcy, ErrorControl, Nmt] {
        message "在不允许的状态下发送紧急报文" "EMCY in a state that does not allow it";
        InState { state: State } "节点处于{state}时发送了紧急报文" "EMCY from a node that is {state}";
        BeforeBootUp "复位之后, 启动报文之前发送了紧急报文" "EMCY after the reset and before the boot-up";
    }

    /// 两个紧急报文的间隔不得短于1015h (单位0.1 ms)。
    /// EMCYs must be at least the time in 1015h (unit 0.1 ms) apart.
    ///
    /// 固件不遵守1015h。
    /// The firmware ignores 1015h.
    Emc005 "EMC005" "emcy-inhibit-time" Warning "CiA 301 7.5.2.18" [Emcy] {
        message "违反紧急报文的抑制时间" "EMCY inhibit time violated";
        TooClose { found: Ns, expected: Ns }
            "距上一紧急报文{found}, 小于抑制时间{expected}" "{found} after the previous EMCY (inhibit time {expected})";
    }

    /// 紧急报文总是8字节: 错误码2字节, 错误寄存器1字节, 制造商定义5字节。消费者可能不处理其他长度。
    /// An EMCY is always 8 bytes long: 2 of error code, 1 of error register, 5 manufacturer-specific. Consumers may ignore other lengths.
    ///
    /// 固件按实际内容设置了DLC; 长度为0的是DS 301第3版的启动报文。
    /// The firmware sets the DLC to the actual payload; a length of 0 is the boot-up of DS 301 version 3.
    Emc006 "EMC006" "emcy-length" Warning "CiA 301 7.2.7.3" [Emcy] {
        message "紧急报文的长度不是8字节" "EMCY is not 8 bytes long";
        Length { found: Count } "紧急报文为{found}字节, 应为8字节" "EMCY is {found|byte|bytes} long, expected 8";
    }

    /// 紧急报文说明设备本身有错误: 电流、电压、温度、硬件、软件、模块或被控对象。节点发出错误复位(0000h)或重新启动之前, 该错误一直存在。
    /// The EMCY reports an error of the device itself: current, voltage, temperature, hardware, software, a module, or the controlled machine. The error is active until the node clears it (0000h) or boots.
    ///
    /// 见错误码和制造商手册; 错误寄存器给出类别。
    /// See the error code and the manufacturer's manual; the error register gives the class.
    Emc007 "EMC007" "device-error" Error "CiA 301 7.2.7.1" [Emcy] {
        message "设备报告错误" "device reports an error";
        Reported { code: Emcy, register: Hex2 }
            "节点报告{code}, 错误寄存器为{register}" "node reports {code}, error register {register}";
    }

    /// 紧急报文说明节点有通信错误, 或者错误码没有进一步说明的错误(一般性或设备特定)。节点发出错误复位(0000h)或重新启动之前, 该错误一直存在。
    /// The EMCY reports a communication error, or one that its code does not specify further (generic or device specific). The error is active until the node clears it (0000h) or boots.
    ///
    /// 通信对方离线或不再发送, PDO长度不同, 报文丢失; 其他情况见制造商手册。
    /// A partner that is offline or silent, a PDO of another length, lost frames; otherwise see the manufacturer's manual.
    Emc008 "EMC008" "reported-error" Warning "CiA 301 7.2.7.1" [Emcy] {
        message "节点报告错误" "node reports an error";
        Reported { code: Emcy, register: Hex2 }
            "节点报告{code}, 错误寄存器为{register}" "node reports {code}, error register {register}";
    }

    /// 节点报告了错误, 到记录结束仍未清除; 或者错误存在期间重复发送了紧急报文。
    /// An error the node reported and did not clear until the end of the capture, or reported several times while it was active.
    ///
    /// 错误原因仍然存在, 或者设备只在收到命令或重新启动后才清除错误。
    /// The cause is still present, or the device clears an error only on a command or a restart.
    Emc009 "EMC009" "error-standing" Info "CiA 301 7.2.7.1" [Emcy] {
        message "错误仍然存在" "error still active";
        Stands { code: Emcy, count: JsonOnly<Count>, age: JsonOnly<Option<Ns>> } "错误{code}尚未清除" "{code} not cleared";
        StandsAndRepeats { code: Emcy, count: Count, age: JsonOnly<Option<Ns>> }
            "错误{code}尚未清除, 共发送{count}次" "{code} not cleared, sent {count} times";
        Repeated { code: Emcy, count: Count }
            "错误{code}在清除前共发送{count}次" "{code} sent {count} times before being cleared";
    }

    /// 每个错误只应发送一次紧急报文。一个节点在1秒内发送了10个或更多。
    /// An EMCY is sent once per error. One node sent ten or more within a second.
    ///
    /// 错误时有时无(接触不良, 数值在阈值附近), 或者设备重复发送紧急报文; 1015h可限制其频率。
    /// An intermittent error (a loose contact, a value at its threshold), or a device that repeats its EMCYs; 1015h limits their rate.
    Emc010 "EMC010" "emcy-flood" Warning "CiA 301 7.2.7.1" [Emcy] {
        message "紧急报文过多" "EMCY flood";
        Flood { count: Count, duration: Ns } "{duration}内{count}个紧急报文" "{count} EMCYs within {duration}";
        InAll { count: Count, duration: Ns } "{duration}内共{count}个紧急报文" "{count} EMCYs in total within {duration}";
    }

    /// CANopen FD的紧急报文长20字节, 各字段的次序没有公开。只显示其字节: 节点是报告错误还是清除错误, 都不作判断。
    /// An EMCY of CANopen FD has 20 bytes, whose order is not public. Its bytes are shown; whether the node reports an error or clears one is not judged.
    ///
    /// 设备报告了错误, 或者错误已经消失; 请按制造商手册解读其字节。
    /// The device reports an error, or one has gone; read its bytes by the manufacturer's manual.
    Emc011 "EMC011" "emcy-not-judged" Warning "CiA 1301" [Emcy] {
        message "CANopen FD的紧急报文, 未作判断" "EMCY of CANopen FD, not judged";
        First "节点的第一个CANopen FD紧急报文: 内容未作判断" "the node's first EMCY of CANopen FD; its content is not judged";
    }
}
