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

use crate::bytes::frame::Frame;

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::bytes::frame::{CanId, Kind};

    fn error(class: u32, payload: &[u8]) -> Frame {
        Frame { kind: Kind::Error, ..Frame::classic(CanId::extended(class), payload) }
    }

    #[test]
    fn classes_and_counters() {
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
