//! The content of one frame by itself, for the services of CANopen other than SDO.
//!
//! SDO is absent, since the meaning of an SDO frame depends on its channel (`services::sdo`). Other frames, time and
//! device descriptions are not considered.

use crate::wire::cob_id::Role;
use crate::words::profiles::Profile;

/// The content of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// NMT node control (CiA 301, 7.2.8.3.1).
    Nmt {
        /// Command specifier: 01, 02, 80, 81, 82; others are unknown.
        command: u8,
        /// Addressed node, 0 = all; above 127 it is invalid.
        node: u8,
    },
    /// Global fail-safe command (CiA 304).
    Gfc,
    /// Flying-master frame 071..076 (CiA 302-2).
    FlyingMaster {
        /// Last hexadecimal digit of the CAN-ID, 1..=6.
        kind: u8,
        /// Priority and node-ID, carried by 071 only.
        master: Option<(u8, u8)>,
    },
    /// SYNC (CiA 301, 7.2.5).
    Sync {
        /// The synchronous counter, if the frame has one byte.
        counter: Option<u8>,
    },
    /// TIME (CiA 301, 7.2.6).
    Time {
        /// Milliseconds since midnight, 28 bits.
        ms: u32,
        /// Days since 1984-01-01.
        days: u16,
        /// The four reserved bits; 0 in a conformant frame.
        reserved: u8,
    },
    /// Emergency (CiA 301, 7.2.7).
    Emcy {
        /// Producing node, 1..=127.
        node: u8,
        /// Emergency error code.
        code: u16,
        /// The device profile that defines the code, as far as known. Never from one frame alone.
        profile: Profile,
        /// Error register (object 1001h).
        register: u8,
        /// Manufacturer-specific bytes.
        manufacturer: [u8; 5],
        /// The node's active errors after this message, as far as the capture shows them. Empty from one frame alone.
        active: Errors,
        /// The errors that this message clears: all active ones, if it reports that none is left.
        cleared: Errors,
    },
    /// Emergency of CANopen FD (CiA 1301): 20 bytes, whose order is not public but for the error code.
    EmcyFd {
        /// Producing node, 1..=127.
        node: u8,
        /// Emergency error code.
        code: u16,
    },
    /// A PDO of the pre-defined connection set; its content needs a mapping.
    Pdo {
        /// Transmit (seen from the node) or receive.
        transmit: bool,
        /// PDO number, from 1.
        number: u16,
        /// The node that owns the PDO.
        node: u8,
    },
    /// A remote frame that requests a PDO.
    PdoRequest {
        /// Transmit or receive, by the CAN-ID.
        transmit: bool,
        /// PDO number, from 1.
        number: u16,
        /// The node that owns the PDO.
        node: u8,
    },
    /// A multiplex PDO (CiA 301, 7.2.2.4). Never from one frame alone: the bus makes it where a mapping shows one.
    Mpdo {
        /// Transmit (seen from the node) or receive.
        transmit: bool,
        /// PDO number, from 1.
        number: u16,
        /// The node that owns the PDO.
        node: u8,
        /// The address and data that it carries.
        content: crate::wire::pdo::multiplexed::Multiplexed,
    },
    /// One frame of an SRDO pair (CiA 304).
    Srdo {
        /// Number of the pair, 1..=64.
        number: u8,
        /// True for the bitwise inverted data.
        inverted: bool,
        /// True if the data are the inverse of the preceding normal data; `None` from one frame alone.
        valid: Option<bool>,
    },
    /// Boot-up (CiA 301, 7.2.8.3.3): error control with state 00.
    BootUp {
        /// The booting node.
        node: u8,
    },
    /// Heartbeat, or a response to node guarding: both carry a state.
    Heartbeat {
        /// The node.
        node: u8,
        /// Bits 6..0: 04 Stopped, 05 Operational, 7F Pre-operational; others are unknown.
        state: u8,
        /// Bit 7: the toggle bit of node guarding; 0 in a heartbeat.
        toggle: bool,
        /// A response to node guarding. From one frame alone only if the toggle bit is set.
        guarding: bool,
        /// The state in the node's previous message since its last boot-up. `None` from one frame alone.
        previous: Option<u8>,
    },
    /// Remote frame of node guarding from the NMT master.
    GuardingRequest {
        /// The guarded node.
        node: u8,
    },
    /// LSS (CiA 305); the command specifier is the first byte.
    Lss {
        /// From the LSS master (7E5) or from a slave (7E4).
        from_master: bool,
        /// The decoded command.
        command: crate::wire::lss::command::Command,
    },
    /// A CAN FD frame on an SDO identifier: CANopen FD's USDO (CiA 1301).
    Usdo {
        /// From the client (600 + own node-ID) or from the server (580 + own node-ID).
        request: bool,
        /// The sender's node-ID, which is in the CAN-ID.
        source: u8,
        /// Payload byte 0: the destination's node-ID, 0 = all.
        destination: u8,
        /// Payload byte 1: command specifier.
        command: u8,
    },
    /// A SocketCAN error frame; the frame's identifier is the error class.
    ErrorFrame,
    /// A reserved or unassigned 11-bit identifier (6E0..6FF included), or a 29-bit identifier, without a CANopen
    /// meaning by itself.
    Foreign {
        /// The role of the identifier.
        role: Role,
    },
    /// A frame on the identifier of a service that is not a valid message of that service.
    Malformed {
        /// The role of the identifier.
        role: Role,
        /// The flaw.
        flaw: Flaw,
    },
}

impl Message {
    /// Returns the role of the identifier under which the frame was decoded.
    pub fn role(&self) -> Role {
        match *self {
            Self::Nmt { .. } => Role::Nmt,
            Self::Gfc => Role::Gfc,
            Self::FlyingMaster { kind, .. } => Role::FlyingMaster(kind),
            Self::Sync { .. } => Role::Sync,
            Self::Time { .. } => Role::Time,
            Self::Emcy { node, .. } | Self::EmcyFd { node, .. } => Role::Emcy(node),
            Self::Pdo { transmit: true, number, node }
            | Self::PdoRequest { transmit: true, number, node }
            | Self::Mpdo { transmit: true, number, node, .. } => Role::Tpdo { number, node },
            Self::Pdo { number, node, .. }
            | Self::PdoRequest { number, node, .. }
            | Self::Mpdo { number, node, .. } => Role::Rpdo { number, node },
            Self::Srdo { number, inverted, .. } => Role::Srdo { number, inverted },
            Self::BootUp { node } | Self::Heartbeat { node, .. } | Self::GuardingRequest { node } => {
                Role::ErrorControl(node)
            }
            Self::Lss { from_master: true, .. } => Role::LssRequest,
            Self::Lss { from_master: false, .. } => Role::LssResponse,
            Self::Usdo { request: true, source, .. } => Role::SdoRequest(source),
            Self::Usdo { request: false, source, .. } => Role::SdoResponse(source),
            Self::ErrorFrame => Role::Foreign,
            Self::Foreign { role } | Self::Malformed { role, .. } => role,
        }
    }

    /// Returns the word for the service, as used in filters, in JSON, and as the name of the file that decodes it.
    /// Boot-up counts as heartbeat.
    pub fn service(&self) -> &'static str {
        match self {
            Self::Heartbeat { guarding: true, .. } | Self::GuardingRequest { .. } => "guarding",
            Self::Usdo { .. } => "usdo",
            Self::ErrorFrame => "error",
            _ => match self.role() {
                Role::Nmt => "nmt",
                Role::Gfc => "gfc",
                Role::FlyingMaster(_) => "flying_master",
                Role::Sync => "sync",
                Role::Emcy(_) => "emcy",
                Role::Time => "time",
                Role::Srdo { .. } => "srdo",
                Role::Tpdo { .. } | Role::Rpdo { .. } => "pdo",
                Role::SdoRequest(_) | Role::SdoResponse(_) => "sdo",
                Role::ErrorControl(_) => "heartbeat",
                Role::LssRequest | Role::LssResponse => "lss",
                Role::DynamicSdo | Role::Reserved | Role::Unassigned | Role::Foreign => "foreign",
            },
        }
    }

    /// Returns the node of the message: its sender, or the node that an NMT command addresses. `None` if it concerns no
    /// node or all nodes, or if the number is not a node-ID.
    pub fn node(&self) -> Option<u8> {
        let node = match *self {
            Self::Nmt { node, .. } | Self::FlyingMaster { master: Some((_, node)), .. } => node,
            Self::Srdo { number, .. } | Self::Malformed { role: Role::Srdo { number, .. }, .. } => number,
            _ => self.role().node()?,
        };
        (1..=127).contains(&node).then_some(node)
    }
}

/// Emergency error codes that a node has reported, oldest first; at most [`ERRORS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    codes: [u16; ERRORS],
    count: u8,
}

/// Maximum number of error codes kept for one node.
pub const ERRORS: usize = 8;

impl Errors {
    /// Adds a code unless it is present or the list is full.
    pub fn add(&mut self, code: u16) {
        if !self.iter().any(|known| known == code)
            && let Some(slot) = self.codes.get_mut(usize::from(self.count))
        {
            *slot = code;
            self.count += 1;
        }
    }

    /// Iterates over the codes.
    pub fn iter(&self) -> impl Iterator<Item = u16> {
        self.codes.into_iter().take(usize::from(self.count))
    }
}

/// The reason that a frame is not a valid message of its service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// The length is not one that the service defines.
    Length {
        /// Minimum length in bytes.
        least: u8,
        /// Maximum length in bytes.
        most: u8,
    },
    /// A remote frame, although the service has none.
    Remote,
    /// A CAN FD frame, although the service uses classic frames.
    Fd,
}
