//! Bus and direction from the name of a topic.
//!
//! `header.frame_id` is not used, since drivers write a constant into it.
//!
//! A frame sent to a driver (`to_can_bus`) is also on the topic of received frames if the driver's sockets receive each
//! other's frames: always in `ros2_socketcan` up to 1.3, later optionally. See `echo`.

use crate::bytes::frame::{Direction, MAX_BUS_NAME};

/// The ends of topics with frames, and their direction, seen from the driver.
const ENDS: &[(&[u8], Direction)] = &[
    (b"from_can_bus_fd", Direction::Rx),
    (b"to_can_bus_fd", Direction::Tx),
    (b"from_can_bus", Direction::Rx),
    (b"to_can_bus", Direction::Tx),
    (b"received_messages", Direction::Rx),
    (b"sent_messages", Direction::Tx),
    (b"can_rx", Direction::Rx),
    (b"can_tx", Direction::Tx),
    (b"receive", Direction::Rx),
    (b"transmit", Direction::Tx),
    (b"rx", Direction::Rx),
    (b"tx", Direction::Tx),
];
/// The bus of a topic without any other name.
const NAMELESS: &[u8] = b"can";

/// Returns the bus and the direction of a topic's frames: `/can0/from_can_bus` is `can0`, received.
///
/// A topic without such an end is itself the bus, without its first slash.
pub(super) fn bus(topic: &[u8]) -> (Vec<u8>, Option<Direction>) {
    let topic = topic.strip_prefix(b"/").unwrap_or(topic);
    for (end, direction) in ENDS {
        if let Some(rest) = topic.strip_suffix(*end)
            && (rest.is_empty() || rest.ends_with(b"/"))
        {
            return (word(rest), Some(*direction));
        }
    }
    (word(topic), None)
}

/// Returns a name that is one word of a console line. Of one that is too long the end is kept, since it names the
/// interface.
pub(super) fn word(name: &[u8]) -> Vec<u8> {
    let name = name.trim_ascii();
    let name = name.strip_suffix(b"/").unwrap_or(name);
    let name = name.get(name.len().saturating_sub(MAX_BUS_NAME)..).unwrap_or(name);
    let start = name.iter().position(u8::is_ascii_alphanumeric).unwrap_or(name.len());
    let name = name.get(start..).unwrap_or_default();
    if name.is_empty() {
        return NAMELESS.to_vec();
    }
    name.iter().map(|byte| if byte.is_ascii_graphic() && *byte != b'#' { *byte } else { b'_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buses_and_directions() {
        use Direction::{Rx, Tx};
        let rows: &[(&str, &str, Option<Direction>)] = &[
            ("/can0/from_can_bus", "can0", Some(Rx)),
            ("/can0/to_can_bus", "can0", Some(Tx)),
            ("/can0/from_can_bus_fd", "can0", Some(Rx)),
            ("/pc1/can/to_can_bus_fd", "pc1/can", Some(Tx)),
            ("from_can_bus", "can", Some(Rx)),
            ("/received_messages", "can", Some(Rx)),
            ("/can1/sent_messages", "can1", Some(Tx)),
            ("/can_bus_dbw/can_rx", "can_bus_dbw", Some(Rx)),
            ("CAN/can0/transmit", "CAN/can0", Some(Tx)),
            ("/socketcan_bridge/tx", "socketcan_bridge", Some(Tx)),
            ("/can/frame", "can/frame", None),
            ("/matrix", "matrix", None),
            ("/vehicle info", "vehicle_info", None),
            ("/", "can", None),
            ("", "can", None),
            ("/a/very/long/namespace/of/robot/number/1/can0/from_can_bus", "ce/of/robot/number/1/can0", Some(Rx)),
        ];
        for (topic, name, direction) in rows {
            let (bus, found) = bus(topic.as_bytes());
            assert_eq!(found, *direction, "{topic}");
            assert!(bus.ends_with(name.as_bytes()) && bus.len() <= MAX_BUS_NAME, "{topic}: {}", bus.escape_ascii());
            assert!(name.len() > 20 || bus.len() == name.len(), "{topic}: {}", bus.escape_ascii());
        }
    }
}
