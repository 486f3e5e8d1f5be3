//! SocketCAN error frames: what the CAN controller reports, written by Linux as frames of eight bytes.
//!
//! | part | field |
//! |---|---|
//! | identifier | class bits, several may be set at once (table below) |
//! | byte 0 | lost arbitration: bit number, 0 = unspecified |
//! | byte 1 | controller status bits |
//! | byte 2 | protocol violation type bits |
//! | byte 3 | protocol violation location |
//! | byte 4 | transceiver status |
//! | bytes 6-7 | transmit and receive error counter, valid with class 200; older kernels fill them without it |
//!
//! The report is the listener's own view of the bus. Nothing here names a node.

use super::fields::line;
use super::prelude::*;

/// Transmission timed out.
pub const TX_TIMEOUT: u32 = 0x001;
/// Arbitration lost; details in byte 0.
pub const LOST_ARBITRATION: u32 = 0x002;
/// Controller problem; details in byte 1.
pub const CONTROLLER: u32 = 0x004;
/// Protocol violation; details in bytes 2 and 3.
pub const PROTOCOL: u32 = 0x008;
/// Transceiver status; details in byte 4.
pub const TRANSCEIVER: u32 = 0x010;
/// No acknowledgement on transmission.
pub const NO_ACK: u32 = 0x020;
/// Bus off.
pub const BUS_OFF: u32 = 0x040;
/// Bus error.
pub const BUS_ERROR: u32 = 0x080;
/// Controller restarted.
pub const RESTARTED: u32 = 0x100;
/// Error counters are valid, in bytes 6 and 7.
pub const COUNTERS: u32 = 0x200;

/// Bits of byte 1, the status of the controller.
const RX_OVERFLOW: u8 = 0x01;
const TX_OVERFLOW: u8 = 0x02;
const WARNING: u8 = 0x0C;
const PASSIVE: u8 = 0x30;
const ACTIVE: u8 = 0x40;
/// Byte 3: the violation was in the acknowledge slot.
const ACK_SLOT: u8 = 0x19;
/// Error counters from which on a controller is at the warning level, and error passive (ISO 11898-1).
const WARNING_COUNT: u8 = 96;
const PASSIVE_COUNT: u8 = 128;

/// Error classes, by bit of the identifier.
static CLASSES: &[Term<u32>] = words!("error_classes");

/// Controller status, by bit of byte 1.
static STATUS: &[Term<u8>] = words!("error_status");

/// Protocol violation type, by bit of byte 2.
static VIOLATIONS: &[Term<u8>] = words!("error_violations");

/// Protocol violation location, byte 3: the field of the frame.
static LOCATIONS: &[Term<u8>] = words!("error_locations");

/// Transceiver status, byte 4: one value for each wire (low nibble CANH, high nibble CANL).
static WIRES: &[Term<u8>] = words!("error_wires");

const UNKNOWN: Bilingual = ("未知", "unknown");
const UNSPECIFIED: Bilingual = ("未指明", "unspecified");

/// A byte of details, which holds only with its class.
struct DetailRow {
    class: u32,
    at: usize,
    key: &'static str,
    content: Detail,
}

/// The content of a byte of details.
#[derive(Clone, Copy)]
enum Detail {
    /// The number of a bit, 0 if it is unspecified.
    Bit,
    /// Flags by their masks.
    Flags(&'static [Term<u8>]),
    /// A place in the frame.
    Location,
    /// A code for each wire, in its nibble.
    Wires,
}

static DETAILS: &[DetailRow] = &[
    DetailRow { class: LOST_ARBITRATION, at: 0, key: "arbitration_bit", content: Detail::Bit },
    DetailRow { class: CONTROLLER, at: 1, key: "controller", content: Detail::Flags(STATUS) },
    DetailRow { class: PROTOCOL, at: 2, key: "protocol", content: Detail::Flags(VIOLATIONS) },
    DetailRow { class: PROTOCOL, at: 3, key: "location", content: Detail::Location },
    DetailRow { class: TRANSCEIVER, at: 4, key: "transceiver", content: Detail::Wires },
];

impl DetailRow {
    fn byte(&self, frame: &Frame) -> u8 {
        frame.head().get(self.at).copied().unwrap_or_default()
    }

    /// Appends it behind the class of a line.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, byte: u8) {
        match self.content {
            Detail::Bit if byte == 0 => put!(out; lang.pick(" (位置未指明)", " (position unspecified)")),
            Detail::Bit => say!(out, lang; zh: " (第", byte, "位)"; en: " (bit ", byte, ")"),
            Detail::Flags(terms) => listed(out, lang, terms, masks(byte)),
            Detail::Location => match find(LOCATIONS, lang, byte) {
                Some(word) => put!(out; lang.pick(", 位置: ", ", location: "), word),
                None if byte == 0 => put!(out; lang.pick(", 位置未指明", ", location unspecified")),
                None => {
                    let unknown = lang.pick(", 位置: 未知 ", ", location: unknown ");
                    put!(out; unknown, Hex::<2>(u64::from(byte)), "h");
                }
            },
            Detail::Wires => listed(out, lang, WIRES, [byte & 0x0F, byte & 0xF0].into_iter().filter(|wire| *wire != 0)),
        }
    }

    /// Appends its line of the breakdown: `#   d1: 08 = 0000 1000b  位3: 1 发送错误达到警告水平`.
    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, byte: u8) {
        let word = |terms, code, none: Bilingual| find(terms, lang, code).unwrap_or(lang.word(none));
        let or = |code| if code == 0 { UNSPECIFIED } else { UNKNOWN };
        put!(out; "#   d", self.at as u64, ": ", Hex::<2>(u64::from(byte)));
        match self.content {
            Detail::Bit => {
                put!(out; lang.pick("  仲裁丢失的位 (0未指明) = ", "  lost at bit (0 unspecified) = "), byte)
            }
            Detail::Flags(terms) => {
                put!(out; " = ", Nibbles(byte));
                let mut between = "  ";
                for mask in masks(byte) {
                    let bit = mask.trailing_zeros();
                    put!(out; between, lang.pick("位", "bit "), bit, ": 1 ", word(terms, mask, UNKNOWN));
                    between = " | ";
                }
                if byte == 0 {
                    put!(out; "  ", lang.word(UNSPECIFIED));
                }
            }
            Detail::Location => put!(out; lang.pick("  位置: ", "  location: "), word(LOCATIONS, byte, or(byte))),
            Detail::Wires => {
                let (canh, canl) = (byte & 0x0F, byte & 0xF0);
                put!(out; " = ", Nibbles(byte), lang.pick("  位3-0: ", "  bits 3-0: "), word(WIRES, canh, or(canh)));
                put!(out; lang.pick(" | 位7-4: ", " | bits 7-4: "), word(WIRES, canl, or(canl)));
            }
        }
        put!(out; "\n");
    }
}

/// What is wrong with the bus or with the controller that recorded, from the least to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Condition {
    /// An error counter is at its warning level.
    WarningLevel,
    /// An error frame of which the capture says nothing else.
    Unspecified,
    /// A frame violated the protocol.
    BusError,
    /// A frame could not be transmitted in time.
    TransmitTimeout,
    /// Nobody has acknowledged a frame.
    NotAcknowledged,
    /// The transceiver reports a fault of a wire.
    Transceiver,
    /// The controller is error passive.
    ErrorPassive,
    /// The controller is off the bus.
    BusOff,
    /// Frames that the host wanted to send are lost.
    TransmitOverflow,
    /// Frames that were received are lost.
    ReceiveOverflow,
}

/// How a controller comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovery {
    /// It is error active again.
    ErrorActive,
    /// It was restarted after bus-off.
    Restarted,
}

/// The worst that an error frame says; `None` where it says nothing bad. Overflows are apart: see [`overflow`].
pub fn condition(frame: &Frame) -> Option<Condition> {
    let class = class(frame);
    let [_, status, _, location, wire, _, tx, rx] = frame.head();
    let controller = if class & CONTROLLER != 0 { status } else { 0 };
    let count = if class & COUNTERS != 0 { tx.max(rx) } else { 0 };
    Some(if class & BUS_OFF != 0 {
        Condition::BusOff
    } else if controller & PASSIVE != 0 {
        Condition::ErrorPassive
    } else if class & TRANSCEIVER != 0 && wire != 0 {
        Condition::Transceiver
    } else if class & NO_ACK != 0 || (class & PROTOCOL != 0 && location == ACK_SLOT) {
        Condition::NotAcknowledged
    } else if class & TX_TIMEOUT != 0 {
        Condition::TransmitTimeout
    } else if class & (PROTOCOL | BUS_ERROR) != 0 {
        Condition::BusError
    } else if controller & WARNING != 0 {
        Condition::WarningLevel
    } else if recovery(frame).is_some() || overflow(frame).is_some() {
        return None;
    } else if count >= PASSIVE_COUNT {
        Condition::ErrorPassive
    } else if count >= WARNING_COUNT {
        Condition::WarningLevel
    } else if class & (LOST_ARBITRATION | COUNTERS) != 0 {
        return None;
    } else {
        Condition::Unspecified
    })
}

/// Frames that the controller has lost. Both at once count as received ones.
pub fn overflow(frame: &Frame) -> Option<Condition> {
    let [_, status, ..] = frame.head();
    match class(frame) & CONTROLLER {
        0 => None,
        _ if status & RX_OVERFLOW != 0 => Some(Condition::ReceiveOverflow),
        _ if status & TX_OVERFLOW != 0 => Some(Condition::TransmitOverflow),
        _ => None,
    }
}

/// Whether the controller takes part in the bus again.
pub fn recovery(frame: &Frame) -> Option<Recovery> {
    let [_, status, ..] = frame.head();
    let class = class(frame);
    if class & RESTARTED != 0 {
        Some(Recovery::Restarted)
    } else {
        (class & CONTROLLER != 0 && status & ACTIVE != 0).then_some(Recovery::ErrorActive)
    }
}

/// Whether the controller has missed frames of the bus.
pub fn is_deaf(frame: &Frame) -> bool {
    class(frame) & BUS_OFF != 0 || overflow(frame) == Some(Condition::ReceiveOverflow)
}

/// The class bits of an error frame.
pub fn class(frame: &Frame) -> u32 {
    frame.id.raw()
}

/// The class bits that are set, lowest first; bits without a meaning too.
pub fn classes(frame: &Frame) -> impl Iterator<Item = u32> {
    let class = class(frame);
    (0..29).map(|bit| 1 << bit).filter(move |bit| class & bit != 0)
}

/// Transmit and receive error counter, where the frame carries them.
///
/// Kernels before class 200 fill the bytes without saying so: there, bytes that are not both 0 count.
pub fn counters(frame: &Frame) -> Option<(u8, u8)> {
    let [.., tx, rx] = frame.head();
    (frame.len == 8 && (class(frame) & COUNTERS != 0 || tx != 0 || rx != 0)).then_some((tx, rx))
}

/// The forms of an error frame.
pub(super) struct ErrorFrameService;

impl WireService for ErrorFrameService {
    /// `错误帧: 控制器问题 (发送错误达到警告水平), 发送错误计数=96, 接收错误计数=0`.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, _: &Message, frame: &Frame) {
        put!(out; lang.pick("错误帧", "error frame"));
        if !full {
            return;
        }
        let mut between = ": ";
        for class in classes(frame).filter(|class| *class != COUNTERS) {
            match find(CLASSES, lang, class) {
                Some(word) => put!(out; between, word),
                None => put!(out; between, lang.pick("未知类别 ", "unknown class "), Hex::<8>(u64::from(class)), "h"),
            }
            between = ", ";
            for row in DETAILS.iter().filter(|row| row.class == class) {
                row.line(out, lang, row.byte(frame));
            }
        }
        if let Some((tx, rx)) = counters(frame) {
            put!(out; between, lang.pick("发送错误计数=", "TX error counter="), tx);
            put!(out; lang.pick(", 接收错误计数=", ", RX error counter="), rx);
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, _: &Message, frame: &Frame) {
        let class = class(frame);
        line!(out; lang.pick("错误帧, 类别 ", "error frame, class "), Hex::<8>(u64::from(class)), "h");
        for bit in classes(frame) {
            line!(out; "  ", Hex::<8>(u64::from(bit)), "h  ", find(CLASSES, lang, bit).unwrap_or(lang.word(UNKNOWN)));
        }
        for row in DETAILS.iter().filter(|row| class & row.class != 0) {
            row.breakdown(out, lang, row.byte(frame));
        }
        if let Some((tx, rx)) = counters(frame) {
            line!(out; "d6: ", Hex::<2>(u64::from(tx)), lang.pick("  发送错误计数 = ", "  TX error counter = "), tx);
            line!(out; "d7: ", Hex::<2>(u64::from(rx)), lang.pick("  接收错误计数 = ", "  RX error counter = "), rx);
        }
    }

    fn json(&self, object: &mut Object<'_>, _: &Message, frame: &Frame) {
        let class = class(frame);
        object.hex::<8>("class", u64::from(class));
        object.list("classes", classes(frame), |out, bit| match find(CLASSES, Lang::En, bit) {
            Some(word) => put!(out; "\"", word, "\""),
            None => put!(out; "\"", Hex::<8>(u64::from(bit)), "\""),
        });
        for row in DETAILS {
            let byte = (class & row.class != 0).then(|| row.byte(frame));
            match row.content {
                Detail::Bit => object.maybe(row.key, byte),
                _ => object.maybe_hex(row.key, byte.is_some(), byte.unwrap_or_default()),
            }
        }
        let counters = counters(frame);
        object.maybe("tx_errors", counters.map(|(tx, _)| tx));
        object.maybe("rx_errors", counters.map(|(_, rx)| rx));
    }
}

/// Iterates over the bits of a byte that are set, as masks.
fn masks(byte: u8) -> impl Iterator<Item = u8> {
    (0..8).map(|bit| 1 << bit).filter(move |mask| byte & mask != 0)
}

/// Appends the words for some codes in brackets.
fn listed(out: &mut Vec<u8>, lang: Lang, terms: &'static [Term<u8>], codes: impl Iterator<Item = u8>) {
    let mut between = " (";
    for code in codes {
        match find(terms, lang, code) {
            Some(word) => put!(out; between, word),
            None => put!(out; between, lang.pick("未知 ", "unknown "), Hex::<2>(u64::from(code)), "h"),
        }
        between = ", ";
    }
    put!(out; if between == " (" { lang.pick(" (未指明)", " (unspecified)") } else { ")" });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::bytes::frame::{CanId, Kind};
    use crate::words::lang::tests::sound;

    fn error(class: u32, payload: &[u8]) -> Frame {
        Frame { kind: Kind::Error, ..Frame::classic(CanId::extended(class), payload) }
    }

    #[test]
    fn classes_and_counters() {
        sound(CLASSES);
        [STATUS, VIOLATIONS, LOCATIONS, WIRES].into_iter().for_each(sound);
        let frame = error(0x004, &[0, 0x08, 0, 0, 0, 0, 0x60, 0]);
        assert_eq!(classes(&frame).collect::<Vec<_>>(), [CONTROLLER]);
        assert_eq!(counters(&frame), Some((96, 0)));
        let frame = error(0x088, &[0; 8]);
        assert_eq!(classes(&frame).collect::<Vec<_>>(), [PROTOCOL, BUS_ERROR]);
        assert_eq!(counters(&frame), None);
        assert_eq!(counters(&error(0x200, &[0; 8])), Some((0, 0)));
    }

    #[test]
    fn what_an_error_frame_says() {
        use Condition::*;
        let status = |bits: u8| [0, bits, 0, 0, 0, 0, 0, 0];
        for (class, payload, expected) in [
            (0x040, [0; 8], Some(BusOff)),
            (0x044, status(0x20), Some(BusOff)),
            (0x004, status(0x10), Some(ErrorPassive)),
            (0x204, [0, 0x20, 0, 0, 0, 0, 128, 0], Some(ErrorPassive)),
            (0x004, status(0x08), Some(WarningLevel)),
            (0x004, status(0x40), None),
            (0x004, status(0x03), None),
            (0x005, status(0x01), Some(TransmitTimeout)),
            (0x020, [0; 8], Some(NotAcknowledged)),
            (0x088, [0, 0, 0x80, 0x19, 0, 0, 8, 0], Some(NotAcknowledged)),
            (0x088, [0, 0, 0x04, 0x0A, 0, 0, 0, 1], Some(BusError)),
            (0x080, [0; 8], Some(BusError)),
            (0x010, [0, 0, 0, 0, 0x04, 0, 0, 0], Some(Transceiver)),
            (0x001, [0; 8], Some(TransmitTimeout)),
            (0x002, [12, 0, 0, 0, 0, 0, 0, 0], None),
            (0x100, [0; 8], None),
            (0x200, [0, 0, 0, 0, 0, 0, 96, 0], Some(WarningLevel)),
            (0x200, [0, 0, 0, 0, 0, 0, 0, 128], Some(ErrorPassive)),
            (0x200, [0; 8], None),
            (0x000, [0; 8], Some(Unspecified)),
        ] {
            assert_eq!(condition(&error(class, &payload)), expected, "{class:03X}");
        }
        let overflows = [0x00, 0x01, 0x02, 0x03].map(|bits| overflow(&error(0x004, &status(bits))));
        assert_eq!(overflows, [None, Some(ReceiveOverflow), Some(TransmitOverflow), Some(ReceiveOverflow)]);
        assert_eq!(overflow(&error(0x008, &status(0x01))), None);
        assert_eq!(recovery(&error(0x100, &[0; 8])), Some(Recovery::Restarted));
        assert_eq!(recovery(&error(0x004, &status(0x40))), Some(Recovery::ErrorActive));
        assert_eq!(recovery(&error(0x004, &status(0x20))), None);
        assert!(is_deaf(&error(0x040, &[0; 8])) && is_deaf(&error(0x004, &status(1))));
        assert!(!is_deaf(&error(0x004, &status(0x20))));
    }
}
