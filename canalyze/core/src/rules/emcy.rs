//! Rules about emergency messages (CiA 301, 7.2.7).

use super::quantity::{Count, Emcy, Hex2, JsonOnly, Ns, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// An emergency error code with error register 0.
    Emc001 "EMC001" "code-without-register" Warning "CiA 301 7.2.7.3.1" [Emcy] {
        message "有错误码而错误寄存器为0" "error code with error register 0";
        meaning
            "出现错误时错误寄存器 (1001h) 至少有一位为1; 位0在任何错误时都置位。"
            "While there is an error at least one bit of the error register (1001h) is set; bit 0 with any error.";
        cause
            "固件没有更新1001h, 或者紧急报文是手工拼的。"
            "The firmware does not maintain 1001h, or the emergency was put together by hand.";
        NoRegister { code: Emcy, register: Hex2 }
            "错误码{code}, 错误寄存器为{register}"
            "error code {code}, error register {register}";
    }

    /// Error reset while other errors remain.
    Emc002 "EMC002" "partial-reset" Info "CiA 301 7.2.7.1" [Emcy] {
        message "部分错误复位" "partial error reset";
        meaning
            "错误码为0000h而错误寄存器不为0: 一个错误消失, 其他错误仍在。这是允许的。"
            "Error code 0000h with a register that is not 0: one error has gone, others remain. This is legal.";
        cause
            "几个错误先后消失。"
            "Several errors go one by one.";
        StillSet { code: JsonOnly<Emcy>, register: Hex2 }
            "错误复位, 错误寄存器仍为{register}"
            "error reset, the error register is still {register}";
        OneLeft { register: Hex2, cleared: Emcy, left: Emcy }
            "{cleared}已消失, {left}仍在; 错误寄存器为{register}"
            "{cleared} is taken back, {left} is left; the error register is {register}";
        SeveralLeft { register: Hex2, cleared: Emcy, left: Emcy, count: Count }
            "{cleared}已消失, 还有{count}个错误, 其中最早的是{left}; 错误寄存器为{register}"
            "{cleared} is taken back, {count} errors are left, the oldest is {left}; the error register is {register}";
        UnknownLeft { register: Hex2, cleared: Emcy }
            "{cleared}已消失; 错误寄存器为{register}, 说明还有记录中没有出现的错误"
            "{cleared} is taken back; by the error register {register} another error is left, which the capture does not show";
        OneOf { register: Hex2, count: Count }
            "{count}个错误之一已消失; 错误寄存器仍为{register}"
            "one of {count} errors is taken back; the error register is still {register}";
    }

    /// Bit 6 of the error register is set.
    Emc003 "EMC003" "reserved-register-bit" Warning "CiA 301 7.5.2.2" [Emcy] {
        message "错误寄存器的保留位不为0" "reserved bit of the error register";
        meaning
            "错误寄存器 (1001h) 的位6保留, 必须为0。"
            "Bit 6 of the error register (1001h) is reserved and shall be 0.";
        cause
            "固件把该位用于自己的目的, 或者字节顺序错误。"
            "The firmware uses the bit for its own purposes, or bytes are in the wrong order.";
        Bit6 { code: JsonOnly<Emcy>, register: Hex2 }
            "错误寄存器为{register}, 位6保留"
            "the error register is {register}, bit 6 is reserved";
    }

    /// An emergency in Stopped or before the boot-up.
    Emc004 "EMC004" "emcy-in-wrong-state" Warning "CiA 301 7.3.2.2" [Emcy, ErrorControl, Nmt] {
        message "不应发送紧急报文的状态" "emergency in a state that has none";
        meaning
            "在停止状态和启动报文之前, 节点不应发送紧急报文。"
            "A node sends no emergencies in Stopped, nor before its boot-up.";
        cause
            "设备没有按NMT状态关闭EMCY服务; 有些厂商的设备如此。"
            "The device does not stop the EMCY service with the NMT state; some makers' do not.";
        InState { state: State }
            "节点处于{state}状态时发送了紧急报文"
            "emergency of a node that is {state}";
        BeforeBootUp
            "复位之后, 启动报文之前发送了紧急报文"
            "emergency after the reset and before the boot-up";
    }

    /// Two emergencies closer than the inhibit time.
    Emc005 "EMC005" "emcy-inhibit-time" Warning "CiA 301 7.5.2.18" [Emcy] {
        message "违反紧急报文的抑制时间" "inhibit time of emergencies";
        meaning
            "两个紧急报文的间隔不得短于1015h (以0.1ms为单位)。"
            "Emergencies are at least the time of 1015h (in tenths of a millisecond) apart.";
        cause
            "固件不遵守1015h。"
            "The firmware does not obey 1015h.";
        TooClose { found: Ns, expected: Ns }
            "间隔{found}, 抑制时间为{expected}"
            "{found} apart, the inhibit time is {expected}";
    }

    /// An emergency has another length than 8 bytes.
    Emc006 "EMC006" "emcy-length" Warning "CiA 301 7.2.7.3" [Emcy] {
        message "紧急报文的长度不是8字节" "an emergency is not 8 bytes long";
        meaning
            "紧急报文总是8字节: 错误码2字节, 错误寄存器1字节, 制造商定义5字节。消费者可能不处理其他长度。"
            "An emergency always has 8 bytes: error code, error register and five of the manufacturer's. Consumers may ignore another length.";
        cause
            "固件按实际内容设置了DLC; 长度为0的是DS301第3版的启动报文。"
            "The firmware sets the DLC by what it has to say; a length of 0 is the boot-up of DS301 version 3.";
        Length { found: Count }
            "紧急报文有{found}字节, 应为8字节"
            "the emergency has {found} bytes and should have 8";
    }

    /// A device reports an error of its own: current, voltage, temperature, hardware, software, a module.
    Emc007 "EMC007" "device-error" Error "CiA 301 7.2.7.1" [Emcy] {
        message "设备报告错误" "device reports an error";
        meaning
            "紧急报文说明设备本身有错误: 电流、电压、温度、硬件、软件、模块或被控对象。节点发出错误复位(0000h)或重新启动之前, 该错误一直存在。"
            "An emergency says that the device itself has an error: current, voltage, temperature, hardware, software, a module, or what it drives. It stands until the node takes it back (0000h) or boots.";
        cause
            "见错误码和厂商手册; 错误寄存器给出类别。"
            "The error code and the maker's manual say what it is; the error register shows its class.";
        Reported { code: Emcy, register: Hex2 }
            "节点报告{code}, 错误寄存器为{register}"
            "the node reports {code}, error register {register}";
    }

    /// A device reports an error of communication, or one that is not specific.
    Emc008 "EMC008" "reported-error" Warning "CiA 301 7.2.7.1" [Emcy] {
        message "节点报告错误" "node reports an error";
        meaning
            "紧急报文说明节点有通信错误, 或者错误码没有进一步说明的错误(一般性或设备特定)。节点发出错误复位(0000h)或重新启动之前, 该错误一直存在。"
            "An emergency says that the node has an error of communication, or one that its code does not name further (generic or device specific). It stands until the node takes it back (0000h) or boots.";
        cause
            "通信伙伴已离线或沉默, PDO长度不同, 报文丢失; 其他情况见厂商手册。"
            "A partner that is gone or silent, a PDO of another length, lost frames; or see the maker's manual.";
        Reported { code: Emcy, register: Hex2 }
            "节点报告{code}, 错误寄存器为{register}"
            "the node reports {code}, error register {register}";
    }

    /// An error that was not taken back, or was sent several times.
    Emc009 "EMC009" "error-standing" Info "CiA 301 7.2.7.1" [Emcy] {
        message "错误仍然存在" "error that stands";
        meaning
            "节点报告了错误, 到记录结束仍没有复位; 或者错误存在期间重复发送了紧急报文。"
            "An error that the node has reported and not taken back by the end of the capture, or that it sent several times while it stood.";
        cause
            "错误的原因还在, 或者设备只在收到命令或重新启动后才复位错误。"
            "Its cause is still there, or the device takes an error back only when it is told to, or restarts.";
        Stands { code: Emcy, count: JsonOnly<Count>, age: JsonOnly<Option<Ns>> }
            "{code}没有复位"
            "{code} has not been taken back";
        StandsAndRepeats { code: Emcy, count: Count, age: JsonOnly<Option<Ns>> }
            "{code}没有复位, 共发送{count}次"
            "{code} has not been taken back, it was sent {count} times";
        Repeated { code: Emcy, count: Count }
            "{code}在复位前共发送{count}次"
            "{code} was sent {count} times until it was taken back";
    }

    /// Many emergencies in a short time.
    Emc010 "EMC010" "emcy-flood" Warning "CiA 301 7.2.7.1" [Emcy] {
        message "紧急报文过多" "flood of emergencies";
        meaning
            "每个错误只应发送一次紧急报文。一个节点在1秒内发送了10个以上。"
            "An emergency is sent once for each error. Ten or more of one node came within a second.";
        cause
            "错误时有时无(接触不良, 数值在阈值附近), 或者设备重复发送紧急报文; 1015h可限制其频率。"
            "An error that comes and goes (a loose contact, a value at its threshold), or a device that repeats its emergencies; 1015h limits their rate.";
        Flood { count: Count, duration: Ns }
            "{duration}内{count}个紧急报文"
            "{count} emergencies within {duration}";
        InAll { count: Count, duration: Ns }
            "{duration}内共{count}个紧急报文"
            "{count} emergencies in all within {duration}";
    }
}
