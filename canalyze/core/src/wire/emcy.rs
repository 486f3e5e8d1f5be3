//! EMCY, the emergency object (CiA 301, 7.2.7): sent once when an error appears or disappears.
//!
//! The error code has its meaning by the device's profile, which the bus knows.

use super::prelude::*;
use crate::wire::message::Errors;
use crate::words::profiles::Profile;

/// Codes and classes. A row whose low byte is 00 stands for its whole high byte; one whose low twelve bits are 0
/// for what no other row of its first digit takes, since device profiles fill these.
static CODES: &[Term<u16>] = &[
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
static REGISTER: &[Term<u8>] = &[
    (0, "一般错误", "generic error"),
    (1, "电流", "current"),
    (2, "电压", "voltage"),
    (3, "温度", "temperature"),
    (4, "通信错误", "communication error"),
    (5, "设备规范定义", "device-profile specific"),
    (6, "保留", "reserved"),
    (7, "制造商定义", "manufacturer specific"),
];

static FIELDS: &[FieldRow] = &[
    field(
        0,
        2,
        ("错误码", "error code"),
        With(code_line),
        &[
            JsonKey::Hex("code"),
            JsonKey::With(|object, read| {
                object.optional("name", code(Lang::En, profile(read.message), read.value as u16))
            }),
        ],
    ),
    field(
        2,
        1,
        ("错误寄存器(1001h)", "error register (1001h)"),
        Flags(REGISTER, ("无错误", "no error")),
        &[
            JsonKey::Hex("register"),
            JsonKey::With(|object, read| {
                object.list("register_bits", fields::set_bits(read.byte()), |out, bit| bit.put(out))
            }),
        ],
    ),
    field(
        3,
        5,
        ("制造商数据", "manufacturer data"),
        Name,
        &[JsonKey::With(|object, read| object.bytes("manufacturer", read.payload.get(3..).unwrap_or_default()))],
    ),
];

/// Decodes a frame on a node's EMCY identifier.
pub fn decode(role: Role, node: u8, payload: &[u8]) -> Message {
    let [low, high, register, a, b, c, d, e] = *payload else {
        return length(role, 8, 8);
    };
    Message::Emcy {
        node,
        code: u16::from_le_bytes([low, high]),
        profile: Profile::UNKNOWN,
        register,
        manufacturer: [a, b, c, d, e],
        active: Errors::default(),
        cleared: Errors::default(),
    }
}

/// Returns the meaning of a code on a device of a profile: by the profile if it has the code or a group for it; else by
/// CiA 301 the code itself, the class of its high byte, or that of its first digit.
pub fn code(lang: Lang, profile: Profile, code: u16) -> Option<&'static str> {
    if let Some((zh, en)) = profile.emergency(code) {
        return Some(lang.pick(zh, en));
    }
    find(CODES, lang, code).or_else(|| find(CODES, lang, code & 0xFF00)).or_else(|| {
        // 01xx..0Fxx are no codes at all; 00xx alone means that an error has gone.
        if code & 0xF000 == 0 { None } else { find(CODES, lang, code & 0xF000) }
    })
}

/// Returns the name of a bit of the error register, 0..=7.
pub fn register_bit(lang: Lang, bit: u8) -> Option<&'static str> {
    find(REGISTER, lang, bit)
}

/// The forms of an emergency.
pub(super) struct EmcyService;

impl WireService for EmcyService {
    /// `节点10的紧急报文: 8130h 寿命保护错误或心跳错误, 错误寄存器=11h (一般错误, 通信错误), 制造商数据 00 ...`.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, _: &Frame) {
        let Message::Emcy { node, code, profile, register, manufacturer, cleared, .. } = message else { return };
        put!(out; Named(lang, Role::Emcy(*node)));
        if !full {
            return;
        }
        let meaning = self::code(lang, *profile, *code).unwrap_or(lang.pick("未知错误码", "unknown error code"));
        put!(out; ": ", Hex::<4>(u64::from(*code)), "h ", meaning);
        put!(out; lang.pick(", 错误寄存器=", ", error register="), Hex::<2>(u64::from(*register)), "h");
        register_bits(out, lang, *register);
        put!(out; lang.pick(", 制造商数据 ", ", manufacturer data "), Spaced(manufacturer));
        let mut between = lang.pick(", 清除 ", ", clears ");
        for code in cleared.iter() {
            put!(out; between, Hex::<4>(u64::from(code)), "h");
            between = ", ";
        }
    }

    fn fields(&self) -> &'static [FieldRow] {
        FIELDS
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        fields::json(object, FIELDS, message, frame);
        let Message::Emcy { active, cleared, .. } = message else { return };
        for (key, errors) in [("active", active), ("cleared", cleared)] {
            object.list(key, errors.iter(), |out, code| put!(out; "\"", Hex::<4>(u64::from(code)), "\""));
        }
    }
}

fn profile(message: &Message) -> Profile {
    if let Message::Emcy { profile, .. } = message { *profile } else { Profile::UNKNOWN }
}

fn code_line(out: &mut Vec<u8>, lang: Lang, read: &FieldValue<'_>) {
    let meaning = code(lang, profile(read.message), read.value as u16).unwrap_or(lang.pick("未知", "unknown"));
    put!(out; " ", Hex::<4>(u64::from(read.value)), lang.pick("h (小端格式): ", "h (little-endian): "), meaning);
}

fn register_bits(out: &mut Vec<u8>, lang: Lang, register: u8) {
    let mut between = " (";
    for bit in fields::set_bits(register) {
        put!(out; between, register_bit(lang, bit).unwrap_or_default());
        between = ", ";
    }
    if register != 0 {
        put!(out; ")");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::lang::tests::sound;

    fn emcy(code: u16, register: u8, manufacturer: [u8; 5]) -> Message {
        let (active, cleared) = (Errors::default(), Errors::default());
        Message::Emcy { node: 10, code, profile: Profile::UNKNOWN, register, manufacturer, active, cleared }
    }

    #[test]
    fn frames() {
        assert_eq!(
            decode(Role::Emcy(10), 10, &[0x30, 0x81, 0x11, 0x05, 0, 0, 0, 0]),
            emcy(0x8130, 0x11, [5, 0, 0, 0, 0])
        );
        assert_eq!(decode(Role::Emcy(10), 10, &[0; 8]), emcy(0, 0, [0; 5]));
        assert_eq!(decode(Role::Emcy(10), 10, &[0x30, 0x81]), length(Role::Emcy(10), 8, 8));
    }

    #[test]
    fn emergency_codes_from_special_to_general() {
        sound(CODES);
        sound(REGISTER);
        assert_eq!(code(Lang::Zh, Profile::UNKNOWN, 0x8130), Some("寿命保护错误或心跳错误"));
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0x8131), Some("communication"));
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0x5530), Some("device hardware"));
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0x7305), Some("additional modules"));
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0x0012), Some("error reset or no error"));
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0x0100), None);
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0xFF12), Some("device specific"));
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0xF112), Some("additional functions"));
        assert_eq!(code(Lang::En, Profile::UNKNOWN, 0xA000), None);
    }
}
