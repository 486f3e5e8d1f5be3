//! The knowledge of a network before its capture is read: descriptions of its devices, and options.
//!
//! Plain data, shared by all buses. Nothing here depends on the capture.

use std::sync::Arc;

use crate::bytes::frame::CanId;
use crate::bytes::ns::Ns;
use crate::world::dictionary::Dictionary;

/// Data that were given beforehand.
#[derive(Clone, Debug, Default)]
pub struct Network {
    /// The descriptions of devices.
    pub descriptions: Vec<Description>,
    /// COB-IDs of PDOs (`--cob`).
    pub cobs: Vec<Cob>,
    /// Values of objects (`--pdo`).
    pub values: Vec<GivenValue>,
    /// Profiles whose default mappings hold (`--profile`).
    pub profiles: Vec<GivenProfile>,
    /// Further SDO channels (`--sdo`).
    pub sdos: Vec<Sdo>,
    /// Communication cycle period in ns (`--sync-period`), if no object defines it.
    pub sync_period_ns: Option<Ns>,
    /// Synchronous window length in ns (`--sync-window`), if no object defines it.
    pub sync_window_ns: Option<Ns>,
    /// Tolerance of timing verdicts in ns (`--jitter`); measured if it is not given.
    pub jitter_ns: Option<Ns>,
    /// Bit rate in bit/s (`--bitrate`).
    pub bit_rate: Option<u32>,
}

/// A node's description.
#[derive(Clone, Debug)]
pub struct Description {
    /// The bus's name; `None`: every bus.
    pub bus: Option<String>,
    /// Node-ID, 1..=127.
    pub node: u8,
    /// The table.
    pub dictionary: Arc<Dictionary>,
}

/// A PDO's COB-ID by option.
#[derive(Clone, Debug)]
pub struct Cob {
    /// The bus's name; `None`: every bus.
    pub bus: Option<String>,
    /// The identifier.
    pub id: CanId,
    /// Node-ID, 1..=127.
    pub node: u8,
    /// Transmit or receive, seen from the node.
    pub transmit: bool,
    /// PDO number, 1..=512.
    pub number: u16,
}

/// The value of an object by option.
#[derive(Clone, Debug)]
pub struct GivenValue {
    /// The bus's name; `None`: every bus.
    pub bus: Option<String>,
    /// Node-ID, 1..=127.
    pub node: u8,
    /// The object.
    pub index: u16,
    /// Its sub-index.
    pub sub: u8,
    /// The value.
    pub value: u64,
}

/// The profile of a node by option.
#[derive(Clone, Debug)]
pub struct GivenProfile {
    /// The bus's name; `None`: every bus.
    pub bus: Option<String>,
    /// Node-ID, 1..=127.
    pub node: u8,
    /// Its number: 401, 402.
    pub number: u16,
}

/// An SDO channel by option.
#[derive(Clone, Debug)]
pub struct Sdo {
    /// The bus's name; `None`: every bus.
    pub bus: Option<String>,
    /// Client to server.
    pub client: CanId,
    /// Server to client.
    pub server: CanId,
    /// The server's node-ID, 1..=127.
    pub node: u8,
}

impl Network {
    /// Returns true if any node or identifier of the bus `name` was given.
    pub fn describes(&self, name: &[u8]) -> bool {
        let mut of = self.descriptions.iter().map(|one| one.bus.as_ref());
        let mut cobs = self.cobs.iter().map(|one| one.bus.as_ref());
        let mut values = self.values.iter().map(|one| one.bus.as_ref());
        let mut profiles = self.profiles.iter().map(|one| one.bus.as_ref());
        let mut sdos = self.sdos.iter().map(|one| one.bus.as_ref());
        of.any(|bus| Self::holds(bus, name))
            || cobs.any(|bus| Self::holds(bus, name))
            || values.any(|bus| Self::holds(bus, name))
            || profiles.any(|bus| Self::holds(bus, name))
            || sdos.any(|bus| Self::holds(bus, name))
    }

    /// Returns true if something given for `of` applies to the bus `name`.
    pub fn holds(of: Option<&String>, name: &[u8]) -> bool {
        of.is_none_or(|bus| bus.as_bytes() == name)
    }
}
