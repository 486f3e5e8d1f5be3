//! The roles of CAN-IDs in the pre-defined connection set (CiA 301, 7.3.5), with the fixed and reserved identifiers of
//! CiA 302, 304 and 305. A table filled at compile time needs one look-up for each frame.
//!
//! Identifiers that a capture or device description moves elsewhere are not considered; the bus overrules this table.

use crate::bytes::frame::CanId;

/// The role of a CAN-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// 000: NMT node control.
    Nmt,
    /// 001: global fail-safe command (CiA 304).
    Gfc,
    /// 071..076: flying master (CiA 302-2); the last hexadecimal digit.
    FlyingMaster(u8),
    /// 080: SYNC.
    Sync,
    /// 081..0FF: emergency of a node.
    Emcy(u8),
    /// 100: TIME.
    Time,
    /// 101..180: SRDO pairs (CiA 304).
    Srdo {
        /// Number of the pair, 1..=64: node-ID in the default assignment.
        number: u8,
        /// True for the frame with bitwise inverted data.
        inverted: bool,
    },
    /// 181..1FF, 281..2FF, 381..3FF, 481..4FF: TPDO 1 to 4 of a node.
    Tpdo {
        /// PDO number, from 1.
        number: u16,
        /// Producing node, 1..=127.
        node: u8,
    },
    /// 201..27F, 301..37F, 401..47F, 501..57F: RPDO 1 to 4 of a node.
    Rpdo {
        /// PDO number, from 1.
        number: u16,
        /// Consuming node, 1..=127.
        node: u8,
    },
    /// 581..5FF: SDO, server to client; the server's node-ID.
    SdoResponse(u8),
    /// 601..67F: SDO, client to server; the server's node-ID.
    SdoRequest(u8),
    /// 6E0..6FF: reserved by CiA 302 (dynamic SDO requests, node claiming).
    DynamicSdo,
    /// 701..77F: NMT error control (boot-up, heartbeat, node guarding) of a node.
    ErrorControl(u8),
    /// 7E4: LSS, slave to master.
    LssResponse,
    /// 7E5: LSS, master to slave.
    LssRequest,
    /// An identifier that CiA 301 keeps reserved.
    Reserved,
    /// An 11-bit identifier that is outside the pre-defined connection set, or that its object has given up for
    /// another.
    Unassigned,
    /// A 29-bit identifier, without a CANopen meaning unless configured.
    Foreign,
}

impl Role {
    /// Returns true if a master sends it, so that the frames are the recording host's own if it is the master.
    pub fn is_command(self) -> bool {
        matches!(
            self,
            Self::Nmt
                | Self::Gfc
                | Self::FlyingMaster(_)
                | Self::Sync
                | Self::Time
                | Self::Rpdo { .. }
                | Self::SdoRequest(_)
                | Self::LssRequest
        )
    }

    /// Returns the node whose identifier it is; `None` if the identifier is not made of a node-ID.
    pub fn node(self) -> Option<u8> {
        match self {
            Self::Emcy(node) | Self::SdoResponse(node) | Self::SdoRequest(node) | Self::ErrorControl(node) => {
                Some(node)
            }
            Self::Tpdo { node, .. } | Self::Rpdo { node, .. } => Some(node),
            _ => None,
        }
    }
}

/// Returns the role of an identifier in the pre-defined connection set.
pub fn predefined(id: CanId) -> Role {
    if id.is_extended() {
        return Role::Foreign;
    }
    TABLE.get(id.raw() as usize).copied().unwrap_or(Role::Foreign)
}

static TABLE: [Role; 0x800] = {
    let mut table = [Role::Unassigned; 0x800];
    let mut id = 0;
    while id < 0x800 {
        #[allow(clippy::indexing_slicing, reason = "evaluated at compile time, over exactly the table's range")]
        {
            table[id] = classify(id as u16);
        }
        id += 1;
    }
    table
};

const fn classify(id: u16) -> Role {
    let node = (id & 0x7F) as u8;
    match id {
        0x000 => Role::Nmt,
        0x001 => Role::Gfc,
        0x071..=0x076 => Role::FlyingMaster((id & 0xF) as u8),
        0x002..=0x07F => Role::Reserved,
        0x080 => Role::Sync,
        0x081..=0x0FF => Role::Emcy(node),
        0x100 => Role::Time,
        0x101..=0x180 => Role::Srdo { number: ((id - 0x0FF) / 2) as u8, inverted: id & 1 == 0 },
        0x181..=0x1FF | 0x281..=0x2FF | 0x381..=0x3FF | 0x481..=0x4FF => Role::Tpdo { number: (id >> 8), node },
        0x201..=0x27F | 0x301..=0x37F | 0x401..=0x47F | 0x501..=0x57F => Role::Rpdo { number: (id >> 8) - 1, node },
        0x581..=0x5FF => Role::SdoResponse(node),
        0x601..=0x67F => Role::SdoRequest(node),
        0x6E0..=0x6FF => Role::DynamicSdo,
        0x701..=0x77F => Role::ErrorControl(node),
        0x7E4 => Role::LssResponse,
        0x7E5 => Role::LssRequest,
        0x780..=0x7FF => Role::Reserved,
        _ => Role::Unassigned,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn role(id: u16) -> Role {
        predefined(CanId::standard(id))
    }

    #[test]
    fn pre_defined_connection_set() {
        assert_eq!(role(0x000), Role::Nmt);
        assert_eq!(role(0x001), Role::Gfc);
        assert_eq!(role(0x070), Role::Reserved);
        assert_eq!(role(0x071), Role::FlyingMaster(1));
        assert_eq!(role(0x077), Role::Reserved);
        assert_eq!(role(0x080), Role::Sync);
        assert_eq!(role(0x08A), Role::Emcy(10));
        assert_eq!(role(0x100), Role::Time);
        assert_eq!(role(0x101), Role::Srdo { number: 1, inverted: false });
        assert_eq!(role(0x102), Role::Srdo { number: 1, inverted: true });
        assert_eq!(role(0x180), Role::Srdo { number: 64, inverted: true });
        assert_eq!(role(0x185), Role::Tpdo { number: 1, node: 5 });
        assert_eq!(role(0x4FF), Role::Tpdo { number: 4, node: 127 });
        assert_eq!(role(0x200), Role::Unassigned);
        assert_eq!(role(0x205), Role::Rpdo { number: 1, node: 5 });
        assert_eq!(role(0x57F), Role::Rpdo { number: 4, node: 127 });
        assert_eq!(role(0x580), Role::Unassigned);
        assert_eq!(role(0x58A), Role::SdoResponse(10));
        assert_eq!(role(0x60A), Role::SdoRequest(10));
        assert_eq!(role(0x680), Role::Unassigned);
        assert_eq!(role(0x6E0), Role::DynamicSdo);
        assert_eq!(role(0x700), Role::Unassigned);
        assert_eq!(role(0x70A), Role::ErrorControl(10));
        assert_eq!(role(0x7E4), Role::LssResponse);
        assert_eq!(role(0x7E5), Role::LssRequest);
        assert_eq!(role(0x7FF), Role::Reserved);
        assert_eq!(predefined(CanId::extended(0x60A)), Role::Foreign);
    }
}
