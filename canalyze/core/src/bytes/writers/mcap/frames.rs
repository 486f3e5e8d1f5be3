//! Frames as messages of other packages, field by field: the order of fields is the order on the wire and must not change.

use super::message::{AtMost64, Header, RosMessage, RosValues, message};
use crate::bytes::frame::{Frame, Kind};

/// Returns a classic frame as published by `ros2_socketcan`.
pub(super) fn classic(header: Header<'_>, frame: &Frame) -> RosMessage<impl RosValues> {
    let is_error = frame.kind == Kind::Error;
    let is_rtr = frame.kind == Kind::Remote;
    message! { "can_msgs/msg/Frame" {
        header: header,
        id: frame.id.raw(),
        is_rtr: is_rtr,
        is_extended: frame.id.is_extended() && !is_error,
        is_error: is_error,
        dlc: frame.len.min(8),
        data: if is_rtr { [0; 8] } else { frame.head() },
    }}
}

/// Returns a CAN FD frame as published by `ros2_socketcan`.
pub(super) fn fd<'a>(header: Header<'a>, frame: &'a Frame) -> RosMessage<impl RosValues> {
    message! { "ros2_socketcan_msgs/msg/FdFrame" {
        header: header,
        id: frame.id.raw(),
        is_extended: frame.id.is_extended(),
        is_error: false,
        len: frame.len,
        data: AtMost64(frame.payload()),
    }}
}

/// Returns a CAN FD frame with all its flags.
pub(super) fn dataspeed<'a>(header: Header<'a>, frame: &'a Frame) -> RosMessage<impl RosValues> {
    message! { "dataspeed_can_msgs/msg/Frame" {
        header: header,
        id: frame.id.raw(),
        extended: frame.id.is_extended(),
        fdf: true,
        brs: matches!(frame.kind, Kind::Fd { brs: true, .. }),
        esi: matches!(frame.kind, Kind::Fd { esi: true, .. }),
        rtr: false,
        data: AtMost64(frame.payload()),
    }}
}
