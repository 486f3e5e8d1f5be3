//! LSS, layer setting services (CiA 305): one frame's command.
//!
//! Always eight bytes, unused ones 0; byte 0 is the command specifier. M: master to slave (7E5), S: slave to
//! master (7E4).
//!
//! | cs | dir | command | bytes |
//! |---|---|---|---|
//! | 04 | M | switch state global | 1: 0 waiting, 1 configuration |
//! | 40-43 | M | switch state selective: vendor-ID, product code, revision, serial number | 1-4 |
//! | 44 | S | switch state selective, answer | |
//! | 11 | M | configure node-ID | 1: node-ID, FF = unconfigured |
//! | 13 | M | configure bit timing | 1: table selector, 2: table index |
//! | 17 | M | store configuration | |
//! | 11 13 17 | S | their answers | 1: error code, 2: specific error |
//! | 15 | M | activate bit timing | 1-2: switch delay in ms |
//! | 46-4B | M | identify remote slave: vendor-ID, product code, revision low, high, serial low, high | 1-4 |
//! | 4C | M | identify non-configured remote slave | |
//! | 4F, 50 | S | identify slave, identify non-configured slave | |
//! | 51 | M | Fastscan | 1-4: IDNumber, 5: BitCheck, 6: LSSSub, 7: LSSNext |
//! | 5A-5D | M, S | inquire vendor-ID, product code, revision, serial number | answer 1-4 |
//! | 5E | M, S | inquire node-ID | answer 1 |
//!
//! Which slave is in the configuration state, and whether an answer is owed, is the bus's question.

pub mod command;

pub use self::command::{Bound, Command, Part, Setting};
use super::length;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;

/// What is sent with BitCheck 80h: asks for any unconfigured slave.
pub const BIT_CHECK_ANY: u8 = 0x80;
/// The node-ID of a slave that has none.
pub const UNCONFIGURED: u8 = 0xFF;

/// The bit rate in kbit/s of an index into CiA's bit timing table (selector 0). `None` for 5 (reserved), for 9
/// (automatic detection) and above.
pub const fn bit_rate(index: u8) -> Option<u16> {
    match index {
        0 => Some(1000),
        1 => Some(800),
        2 => Some(500),
        3 => Some(250),
        4 => Some(125),
        6 => Some(50),
        7 => Some(20),
        8 => Some(10),
        _ => None,
    }
}

/// Whether the bytes that a defined command does not use are 0, as CiA 305 wants: what tells LSS from other traffic.
pub fn is_plain(from_master: bool, payload: &[u8]) -> bool {
    let used = match (from_master, payload.first()) {
        (true, Some(0x17 | 0x4C | 0x5A..=0x5E)) | (false, Some(0x44 | 0x4F | 0x50)) => 1,
        (true, Some(0x04 | 0x11)) | (false, Some(0x5E)) => 2,
        (true, Some(0x13 | 0x15)) | (false, Some(0x11 | 0x13 | 0x17)) => 3,
        (true, Some(0x40..=0x43 | 0x46..=0x4B)) | (false, Some(0x5A..=0x5D)) => 5,
        (true, Some(0x51)) => 8,
        _ => return false,
    };
    payload.len() == 8 && payload.iter().skip(used).all(|byte| *byte == 0)
}

/// Decodes a frame on 7E5 (`from_master`) or 7E4.
pub fn decode(role: Role, from_master: bool, payload: &[u8]) -> Message {
    let [cs, a, b, c, d, e, f, g] = *payload else {
        return length(role, 8, 8);
    };
    let value = u32::from_le_bytes([a, b, c, d]);
    let command = if from_master {
        match cs {
            0x04 => Command::SwitchGlobal { mode: a },
            0x11 => Command::ConfigureNodeId { node: a },
            0x13 => Command::ConfigureBitTiming { selector: a, index: b },
            0x15 => Command::ActivateBitTiming { delay: u16::from_le_bytes([a, b]) },
            0x17 => Command::Store,
            0x40 => Command::SwitchSelective { part: Part::Vendor, value },
            0x41 => Command::SwitchSelective { part: Part::Product, value },
            0x42 => Command::SwitchSelective { part: Part::Revision, value },
            0x43 => Command::SwitchSelective { part: Part::Serial, value },
            0x46 => Command::Identify { bound: Bound::Vendor, value },
            0x47 => Command::Identify { bound: Bound::Product, value },
            0x48 => Command::Identify { bound: Bound::RevisionLow, value },
            0x49 => Command::Identify { bound: Bound::RevisionHigh, value },
            0x4A => Command::Identify { bound: Bound::SerialLow, value },
            0x4B => Command::Identify { bound: Bound::SerialHigh, value },
            0x4C => Command::IdentifyNonConfigured,
            0x51 => Command::Fastscan { id_number: value, bit_check: e, sub: f, next: g },
            0x5A => Command::Inquire { part: Part::Vendor },
            0x5B => Command::Inquire { part: Part::Product },
            0x5C => Command::Inquire { part: Part::Revision },
            0x5D => Command::Inquire { part: Part::Serial },
            0x5E => Command::InquireNodeId,
            _ => Command::Unknown(cs),
        }
    } else {
        match cs {
            0x11 => Command::Confirmation { of: Setting::NodeId, error: a, specific: b },
            0x13 => Command::Confirmation { of: Setting::BitTiming, error: a, specific: b },
            0x17 => Command::Confirmation { of: Setting::Store, error: a, specific: b },
            0x44 => Command::SwitchSelectiveResponse,
            0x4F => Command::IdentifySlave,
            0x50 => Command::IdentifyNonConfiguredSlave,
            0x5A => Command::InquireResponse { part: Part::Vendor, value },
            0x5B => Command::InquireResponse { part: Part::Product, value },
            0x5C => Command::InquireResponse { part: Part::Revision, value },
            0x5D => Command::InquireResponse { part: Part::Serial, value },
            0x5E => Command::InquireNodeIdResponse { node: a },
            _ => Command::Unknown(cs),
        }
    };
    Message::Lss { from_master, command }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    fn command(from_master: bool, payload: [u8; 8]) -> Command {
        let role = if from_master { Role::LssRequest } else { Role::LssResponse };
        match decode(role, from_master, &payload) {
            Message::Lss { command, .. } => command,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn configuration_session() {
        let master = |payload| command(true, payload);
        assert_eq!(master([0x04, 1, 0, 0, 0, 0, 0, 0]), Command::SwitchGlobal { mode: 1 });
        assert_eq!(master([0x11, 0x0A, 0, 0, 0, 0, 0, 0]), Command::ConfigureNodeId { node: 10 });
        assert_eq!(master([0x13, 0, 2, 0, 0, 0, 0, 0]), Command::ConfigureBitTiming { selector: 0, index: 2 });
        assert_eq!(bit_rate(2), Some(500));
        assert_eq!(master([0x15, 0xE8, 0x03, 0, 0, 0, 0, 0]), Command::ActivateBitTiming { delay: 1000 });
        assert_eq!(master([0x17, 0, 0, 0, 0, 0, 0, 0]), Command::Store);
        assert_eq!(
            master([0x40, 0x78, 0x56, 0x34, 0x12, 0, 0, 0]),
            Command::SwitchSelective { part: Part::Vendor, value: 0x1234_5678 }
        );
        assert_eq!(
            command(false, [0x11, 1, 0, 0, 0, 0, 0, 0]),
            Command::Confirmation { of: Setting::NodeId, error: 1, specific: 0 }
        );
    }

    #[test]
    fn fastscan() {
        let fastscan = |id_number, bit_check, sub, next| Command::Fastscan { id_number, bit_check, sub, next };
        assert_eq!(command(true, [0x51, 0, 0, 0, 0, 0x80, 0, 0]), fastscan(0, BIT_CHECK_ANY, 0, 0));
        assert_eq!(command(true, [0x51, 0, 0, 0, 0, 0x1F, 0, 0]), fastscan(0, 31, 0, 0));
        assert_eq!(command(true, [0x51, 1, 0, 0, 0, 0, 0, 1]), fastscan(1, 0, 0, 1));
        assert_eq!(command(true, [0x51, 3, 0, 0, 0, 0, 3, 0]), fastscan(3, 0, 3, 0));
        assert_eq!(command(false, [0x4F, 0, 0, 0, 0, 0, 0, 0]), Command::IdentifySlave);
    }

    #[test]
    fn unused_bytes() {
        assert!(is_plain(true, &[0x04, 1, 0, 0, 0, 0, 0, 0]));
        assert!(!is_plain(true, &[0x04, 1, 1, 0, 0, 0, 0, 0]));
        assert!(is_plain(true, &[0x51, 1, 2, 3, 4, 5, 6, 7]));
        assert!(is_plain(false, &[0x5A, 1, 2, 3, 4, 0, 0, 0]));
        assert!(!is_plain(false, &[0x40, 0, 0, 0, 0, 0, 0, 0]));
        assert!(!is_plain(false, &[0x44]));
    }

    #[test]
    fn direction_decides() {
        assert_eq!(command(true, [0x4F, 0, 0, 0, 0, 0, 0, 0]), Command::Unknown(0x4F));
        assert_eq!(command(false, [0x04, 0, 0, 0, 0, 0, 0, 0]), Command::Unknown(0x04));
        assert_eq!(command(false, [0x5E, 0xFF, 0, 0, 0, 0, 0, 0]), Command::InquireNodeIdResponse { node: 255 });
        assert_eq!(decode(Role::LssRequest, true, &[0x04, 1]), length(Role::LssRequest, 8, 8));
    }
}
