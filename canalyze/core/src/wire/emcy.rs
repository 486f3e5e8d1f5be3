//! EMCY, the emergency object (CiA 301, 7.2.7): sent once when an error appears or disappears.
//!
//! The error code has its meaning by the device's profile, which the bus knows.

use super::prelude::*;
use crate::wire::message::{Errors, Flaw};
use crate::words::profiles::Profile;

/// Codes and classes. A row whose low byte is 00 stands for its whole high byte; one whose low twelve bits are 0
/// for what no other row of its first digit takes, since device profiles fill these.
static CODES: &[Term<u16>] = words!("emcy_codes");

/// Bits of the error register.
static REGISTER: &[Term<u8>] = words!("error_register");

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

/// Length of an emergency of CANopen FD in bytes.
const FD: usize = 20;

static FD_FIELDS: &[FieldRow] = &[field(
    0,
    2,
    ("读作错误码", "read as error code"),
    With(code_line),
    &[
        JsonKey::Hex("read_as_code"),
        JsonKey::With(|object, read| {
            object.optional("read_as_name", code(Lang::En, Profile::UNKNOWN, read.value as u16))
        }),
        JsonKey::With(|object, read| object.bytes("undecoded", read.payload.get(2..).unwrap_or_default())),
    ],
)];

/// Decodes an FD frame on a node's EMCY identifier: CANopen FD has an emergency of its own.
pub fn decode_fd(role: Role, node: u8, payload: &[u8]) -> Message {
    match *payload {
        [low, high, ..] if payload.len() == FD => Message::EmcyFd { node, code: u16::from_le_bytes([low, high]) },
        _ => Message::Malformed { role, flaw: Flaw::Fd },
    }
}

/// The forms of an emergency of CANopen FD. The order of its fields is not public; that the code comes first, as in
/// CiA 301, is said as a reading.
pub(super) struct EmcyFdService;

impl WireService for EmcyFdService {
    /// `节点10的紧急报文 (CANopen FD, 20字节): 前两字节读作错误码 8130h 寿命保护错误或心跳错误, 其余未解码`.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, _: &Frame) {
        let Message::EmcyFd { node, code } = *message else { return };
        put!(out; Named(lang, Role::Emcy(node)));
        if !full {
            return;
        }
        let meaning = self::code(lang, Profile::UNKNOWN, code).unwrap_or(lang.pick("未知错误码", "unknown error code"));
        let code = Hex::<4>(u64::from(code));
        say!(out, lang;
            zh: " (CANopen FD, 20字节): 前两字节读作错误码 ", code, "h ", meaning, ", 其余未解码";
            en: " (CANopen FD, 20 bytes): first two read as error code ", code, "h ", meaning, ", others not decoded");
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        fields::lines(out, lang, FD_FIELDS, message, frame);
        fields::data(out, lang, frame.payload().get(2..).unwrap_or_default());
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        fields::json(object, FD_FIELDS, message, frame);
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
