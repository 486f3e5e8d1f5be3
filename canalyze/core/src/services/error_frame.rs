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

use crate::frame::Frame;

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
    use crate::frame::{CanId, Kind};

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
}
