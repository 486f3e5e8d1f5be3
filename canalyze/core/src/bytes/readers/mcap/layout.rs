//! The two types of nearly all captures, read directly: the steps of `plan` in a straight line.
//!
//! Only for little-endian messages; `plan` reads the others, with the same result.

use super::bytes::{Bytes, Wire};
use super::fields::Fields;
use crate::bytes::frame::CanId;

/// `can_msgs/Frame` of ROS 1 and 2.
pub(super) const CAN_FRAME: &str =
    "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\nuint8 dlc\nuint8[8] data";
/// `ros2_socketcan_msgs/FdFrame`.
pub(super) const FD_FRAME: &str =
    "std_msgs/Header header\nuint32 id\nbool is_extended\nbool is_error\nuint8 len\nuint8[<=64] data";

/// A type that is read directly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    Can,
    Fd,
}

impl Layout {
    /// Returns the fields of a message; `None` if it is incomplete or in the other byte order.
    #[inline(always)]
    pub(super) fn read(self, wire: Wire, message: &[u8]) -> Option<Fields<'_>> {
        let mut rest = Bytes(message);
        match wire {
            Wire::Ros1 => rest.u32().map(|_| ())?,
            Wire::Cdr => matches!(rest.take(4)?, [0, 1 | 7, ..]).then_some(())?,
        }
        let stamp_ns = Some(nanoseconds(rest.u32()?, rest.u32()?));
        let name = rest.counted()?;
        if wire == Wire::Cdr {
            // The bytes before are a multiple of four.
            rest.take(name.len().wrapping_neg() & 3)?;
        }
        let id = u64::from(rest.u32()?);
        let flags = *rest.0.first_chunk::<4>()?;
        rest.take(4)?;
        match self {
            Self::Can => {
                let [rtr, ext, err, dlc] = flags;
                let (rtr, ext, err) = (rtr != 0, ext != 0, err != 0);
                let data = rest.take(8)?;
                let len = Some(u64::from(dlc));
                Some(Fields { stamp_ns, id, ext, rtr, err, len, len_is_code: true, data, ..Fields::default() })
            }
            Self::Fd => {
                // In ROS 1 there is no padding before the length of the data.
                if wire == Wire::Ros1 {
                    return None;
                }
                let [ext, err, len, _] = flags;
                let (ext, err, len) = (ext != 0, err != 0, Some(u64::from(len)));
                let data = rest.counted()?;
                Some(Fields { stamp_ns, id, ext, err, fd: Some(true), len, data, ..Fields::default() })
            }
        }
    }
}

/// Reads the most common message: a consistent classic data frame of at most eight bytes. Returns its stamp,
/// identifier, length and data; `None` leaves it to [`Layout::read`].
#[inline(always)]
pub(super) fn plain(message: &[u8]) -> Option<(i64, CanId, u8, [u8; 8])> {
    let (head, rest) = message.split_first_chunk::<16>()?;
    let [0, 1, _, _, s0, s1, s2, s3, n0, n1, n2, n3, l0, l1, l2, l3] = *head else { return None };
    let name = u32::from_le_bytes([l0, l1, l2, l3]).checked_next_multiple_of(4)?;
    let frame = rest.get(name as usize..)?.first_chunk::<16>()?;
    let [i0, i1, i2, i3, 0, ext @ (0 | 1), 0, len @ 0..=8, data @ ..] = *frame else { return None };
    let id = match (u32::from_le_bytes([i0, i1, i2, i3]), ext) {
        (id @ 0..=0x7FF, 0) => CanId::standard(id as u16),
        (id @ 0..=0x1FFF_FFFF, 1) => CanId::extended(id),
        _ => return None,
    };
    let kept = u64::MAX.checked_shr(64 - 8 * u32::from(len)).unwrap_or(0);
    let data = (u64::from_le_bytes(data) & kept).to_le_bytes();
    let stamp_ns = nanoseconds(u32::from_le_bytes([s0, s1, s2, s3]), u32::from_le_bytes([n0, n1, n2, n3]));
    Some((stamp_ns, id, len, data))
}

/// Returns a stamp in ns; seconds are signed and may be negative.
#[inline(always)]
pub(super) fn nanoseconds(seconds: u32, ns: u32) -> i64 {
    i64::from(seconds as i32) * 1_000_000_000 + i64::from(ns)
}
