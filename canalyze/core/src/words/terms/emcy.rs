//! Emergency error codes (CiA 301, table 26) and the bits of the error register (object 1001h).

use super::{Row, find};
use crate::words::Lang;
use crate::words::profiles::Profile;

/// Codes and classes. A row whose low byte is 00 stands for its whole high byte; one whose low twelve bits are 0
/// for what no other row of its first digit takes, since device profiles fill these.
pub static CODES: &[Row<u16>] = &[
    (0x0000, "错误复位或无错误", "error reset or no error"),
    (0x1000, "一般性错误", "generic error"),
    (0x2000, "电流", "current"),
    (0x2100, "电流, 设备输入侧", "current, device input side"),
    (0x2200, "设备内部电流", "current inside the device"),
    (0x2300, "电流, 设备输出侧", "current, device output side"),
    (0x3000, "电压", "voltage"),
    (0x3100, "电源电压", "mains voltage"),
    (0x3200, "设备内部电压", "voltage inside the device"),
    (0x3300, "输出电压", "output voltage"),
    (0x4000, "温度", "temperature"),
    (0x4100, "环境温度", "ambient temperature"),
    (0x4200, "设备温度", "device temperature"),
    (0x5000, "设备硬件", "device hardware"),
    (0x6000, "设备软件", "device software"),
    (0x6100, "内部软件", "internal software"),
    (0x6200, "用户软件", "user software"),
    (0x6300, "数据集", "data set"),
    (0x7000, "附加模块", "additional modules"),
    (0x8000, "监控", "monitoring"),
    (0x8100, "通信", "communication"),
    (0x8110, "CAN溢出(报文丢失)", "CAN overrun (objects lost)"),
    (0x8120, "CAN进入错误被动状态", "CAN in error passive mode"),
    (0x8130, "寿命保护错误或心跳错误", "life guard error or heartbeat error"),
    (0x8140, "从总线关闭恢复", "recovered from bus off"),
    (0x8150, "CAN-ID冲突", "CAN-ID collision"),
    (0x8200, "协议错误", "protocol error"),
    (0x8210, "PDO因长度错误未处理", "PDO not processed due to length error"),
    (0x8220, "PDO长度超出", "PDO length exceeded"),
    (0x8230, "DAM MPDO未处理, 目标对象不可用", "DAM MPDO not processed, destination object not available"),
    (0x8240, "SYNC数据长度异常", "unexpected SYNC data length"),
    (0x8250, "RPDO超时", "RPDO timeout"),
    (0x9000, "外部错误", "external error"),
    (0xF000, "附加功能", "additional functions"),
    (0xFF00, "设备特定", "device specific"),
];

/// Bits of the error register.
pub static REGISTER: &[Row<u8>] = &[
    (0, "一般错误", "generic error"),
    (1, "电流", "current"),
    (2, "电压", "voltage"),
    (3, "温度", "temperature"),
    (4, "通信错误", "communication error"),
    (5, "设备规范定义", "device-profile specific"),
    (6, "保留", "reserved"),
    (7, "制造商定义", "manufacturer specific"),
];

/// What a code means on a device of a profile: by the profile where it has the code or what it is a case of; else by
/// CiA 301 the code itself, else its high byte's class, else its first digit's.
pub fn code(lang: Lang, profile: Profile, code: u16) -> Option<&'static str> {
    if let Some((zh, en)) = profile.emergency(code) {
        return Some(lang.pick(zh, en));
    }
    find(CODES, lang, code).or_else(|| find(CODES, lang, code & 0xFF00)).or_else(|| {
        // 01xx..0Fxx are no codes at all; 00xx alone means that an error has gone.
        if code & 0xF000 == 0 { None } else { find(CODES, lang, code & 0xF000) }
    })
}

/// The name of a bit of the error register, 0..=7.
pub fn register_bit(lang: Lang, bit: u8) -> Option<&'static str> {
    find(REGISTER, lang, bit)
}
