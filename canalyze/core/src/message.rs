//! What one frame says by itself, before any history: the services of CANopen other than SDO.
//!
//! SDO is not here, since the meaning of an SDO frame depends on its channel (`services::sdo`). Nothing here
//! may look at another frame, at time or at a device description.

use crate::cob_id::Role;
use crate::profiles::Profile;

/// One frame's own meaning.
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
        /// The synchronous counter, where the frame has one byte.
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
        /// The device profile by which the code has its meaning, as far as it is known. Never from one frame alone.
        profile: Profile,
        /// Error register (object 1001h).
        register: u8,
        /// Manufacturer-specific bytes.
        manufacturer: [u8; 5],
        /// The node's errors after it, as far as the capture shows them. Empty from one frame alone.
        active: Errors,
        /// The errors that it takes back: those before it, where it says that none is left.
        cleared: Errors,
    },
    /// A PDO of the pre-defined connection set; its content needs a mapping.
    Pdo {
        /// Transmit (seen from the node) or receive.
        transmit: bool,
        /// PDO number, from 1.
        number: u16,
        /// The node whose PDO it is.
        node: u8,
    },
    /// A remote frame that asks for a PDO.
    PdoRequest {
        /// Transmit or receive, as the CAN-ID says.
        transmit: bool,
        /// PDO number, from 1.
        number: u16,
        /// The node whose PDO it is.
        node: u8,
    },
    /// A multiplex PDO (CiA 301, 7.2.2.4). Never from one frame alone: the bus makes it where a mapping says so.
    Mpdo {
        /// Transmit (seen from the node) or receive.
        transmit: bool,
        /// PDO number, from 1.
        number: u16,
        /// The node whose PDO it is.
        node: u8,
        /// What it carries.
        content: crate::services::pdo::multiplexed::Multiplexed,
    },
    /// One frame of an SRDO pair (CiA 304).
    Srdo {
        /// Number of the pair, 1..=64.
        number: u8,
        /// Whether the data are the bitwise inverted ones.
        inverted: bool,
        /// Whether these are the inverse of the normal data before them: what the bus knows, `None` for a frame by
        /// itself.
        valid: Option<bool>,
    },
    /// Boot-up (CiA 301, 7.2.8.3.3): error control with state 00.
    BootUp {
        /// The node that has booted.
        node: u8,
    },
    /// Heartbeat, or an answer to node guarding: both carry a state.
    Heartbeat {
        /// The node.
        node: u8,
        /// Bits 6..0: 04 Stopped, 05 Operational, 7F Pre-operational; others are unknown.
        state: u8,
        /// Bit 7: the toggle bit of node guarding; 0 in a heartbeat.
        toggle: bool,
        /// An answer to node guarding. From one frame alone only where the toggle bit is set.
        guarding: bool,
        /// The state that the node has shown before, since its last boot-up. `None` from one frame alone.
        previous: Option<u8>,
    },
    /// Remote frame of node guarding, from the NMT master.
    GuardingRequest {
        /// The guarded node.
        node: u8,
    },
    /// LSS (CiA 305): the command specifier is in the frame's first byte.
    Lss {
        /// From the LSS master (7E5) or from a slave (7E4).
        from_master: bool,
        /// What it says.
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
    /// Reserved or unassigned 11-bit identifier, 6E0..6FF, or 29-bit identifier: no CANopen meaning by itself.
    Foreign {
        /// Which of these it is.
        role: Role,
    },
    /// A frame on the identifier of a service that cannot be one of its messages.
    Malformed {
        /// The role of the identifier.
        role: Role,
        /// What is wrong.
        flaw: Flaw,
    },
}

impl Message {
    /// The service's one word: the name in filters, in JSON, and of the file that decodes it. Boot-up counts as
    /// heartbeat.
    pub fn service(&self) -> &'static str {
        match self {
            Self::Nmt { .. } => "nmt",
            Self::Gfc => "gfc",
            Self::FlyingMaster { .. } => "flying_master",
            Self::Sync { .. } => "sync",
            Self::Time { .. } => "time",
            Self::Emcy { .. } => "emcy",
            Self::Pdo { .. } | Self::PdoRequest { .. } | Self::Mpdo { .. } => "pdo",
            Self::Srdo { .. } => "srdo",
            Self::Heartbeat { guarding: true, .. } | Self::GuardingRequest { .. } => "guarding",
            Self::BootUp { .. } | Self::Heartbeat { .. } => "heartbeat",
            Self::Lss { .. } => "lss",
            Self::Usdo { .. } => "usdo",
            Self::ErrorFrame => "error",
            Self::Foreign { role } | Self::Malformed { role, .. } => match role {
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

    /// The node the message is about: who sends it, or whom an NMT command addresses. `None` where it is about
    /// none or about all, or where the number cannot be a node-ID.
    pub fn node(&self) -> Option<u8> {
        let node = match *self {
            Self::Nmt { node, .. }
            | Self::Emcy { node, .. }
            | Self::Pdo { node, .. }
            | Self::PdoRequest { node, .. }
            | Self::Mpdo { node, .. }
            | Self::BootUp { node }
            | Self::Heartbeat { node, .. }
            | Self::GuardingRequest { node } => node,
            Self::FlyingMaster { master, .. } => master.map_or(0, |(_, node)| node),
            Self::Srdo { number, .. } => number,
            Self::Usdo { source, .. } => source,
            Self::Gfc | Self::Sync { .. } | Self::Time { .. } | Self::Lss { .. } | Self::ErrorFrame => 0,
            Self::Foreign { role } | Self::Malformed { role, .. } => match role {
                Role::Emcy(node) | Role::SdoRequest(node) | Role::SdoResponse(node) | Role::ErrorControl(node) => node,
                Role::Tpdo { node, .. } | Role::Rpdo { node, .. } => node,
                Role::Srdo { number, .. } => number,
                Role::Nmt
                | Role::Gfc
                | Role::FlyingMaster(_)
                | Role::Sync
                | Role::Time
                | Role::DynamicSdo
                | Role::LssRequest
                | Role::LssResponse
                | Role::Reserved
                | Role::Unassigned
                | Role::Foreign => 0,
            },
        };
        (1..=127).contains(&node).then_some(node)
    }
}

/// Emergency error codes that a node has reported, oldest first. Further ones than [`ERRORS`] are not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    codes: [u16; ERRORS],
    count: u8,
}

/// Error codes that are kept of one node.
pub const ERRORS: usize = 8;

impl Errors {
    /// Adds a code, where it is not there yet.
    pub fn add(&mut self, code: u16) {
        if !self.iter().any(|known| known == code)
            && let Some(slot) = self.codes.get_mut(usize::from(self.count))
        {
            *slot = code;
            self.count += 1;
        }
    }

    /// The codes.
    pub fn iter(&self) -> impl Iterator<Item = u16> {
        self.codes.into_iter().take(usize::from(self.count))
    }
}

/// Why a frame cannot be a message of the service its identifier stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// The payload has another length than the service defines.
    Length {
        /// What the service defines, in bytes: least.
        least: u8,
        /// What the service defines, in bytes: most.
        most: u8,
    },
    /// A remote frame where the service knows none.
    Remote,
    /// A CAN FD frame where a classic frame is defined.
    Fd,
}
