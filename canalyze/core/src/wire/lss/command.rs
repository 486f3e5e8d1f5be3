//! What one LSS frame says (CiA 305), as values. Its bytes are read in `wire::lss`.

/// The four numbers of an LSS address (object 1018h, sub-index 1 to 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Vendor-ID.
    Vendor,
    /// Product code.
    Product,
    /// Revision number.
    Revision,
    /// Serial number.
    Serial,
}

impl Part {
    /// The part by its number, 0..=3, as Fastscan and the command specifiers count.
    pub const fn from_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Vendor),
            1 => Some(Self::Product),
            2 => Some(Self::Revision),
            3 => Some(Self::Serial),
            _ => None,
        }
    }

    /// Its number, 0..=3.
    pub const fn number(self) -> u8 {
        match self {
            Self::Vendor => 0,
            Self::Product => 1,
            Self::Revision => 2,
            Self::Serial => 3,
        }
    }
}

/// What the identify-remote-slave commands bound, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bound {
    /// Vendor-ID, exactly (46).
    Vendor,
    /// Product code, exactly (47).
    Product,
    /// Least revision number (48).
    RevisionLow,
    /// Greatest revision number (49).
    RevisionHigh,
    /// Least serial number (4A).
    SerialLow,
    /// Greatest serial number (4B).
    SerialHigh,
}

/// The configuration commands that a slave confirms with an error code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LssSetting {
    /// Configure node-ID (11).
    NodeId,
    /// Configure bit timing (13).
    BitTiming,
    /// Store configuration (17).
    Store,
}

/// An LSS command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// 04: all slaves change to a state.
    SwitchGlobal {
        /// 0 waiting, 1 configuration; others are reserved.
        mode: u8,
    },
    /// 40..43: one number of the address of the slave that is to enter the configuration state.
    SwitchSelective {
        /// Which number.
        part: Part,
        /// Its value.
        value: u32,
    },
    /// 44: the addressed slave has entered the configuration state.
    SwitchSelectiveResponse,
    /// 11: gives a node-ID.
    ConfigureNodeId {
        /// 1..=127, FF = unconfigured; others are invalid.
        node: u8,
    },
    /// 13: gives a bit timing.
    ConfigureBitTiming {
        /// Table selector, 0 = CiA's table.
        selector: u8,
        /// Index into the table.
        index: u8,
    },
    /// 17: the configuration is to be stored.
    Store,
    /// 11, 13, 17 from a slave.
    Confirmation {
        /// What it confirms.
        of: LssSetting,
        /// Error code, 0 = done, FF = see `specific`.
        error: u8,
        /// Implementation-specific error code.
        specific: u8,
    },
    /// 15: bit timing takes effect.
    ActivateBitTiming {
        /// Switch delay in ms; the bus is silent for twice that time.
        delay: u16,
    },
    /// 46..4B: one bound of the addresses searched for.
    Identify {
        /// Which bound.
        bound: Bound,
        /// Its value.
        value: u32,
    },
    /// 4C: all slaves without a node-ID are to answer.
    IdentifyNonConfigured,
    /// 4F: a slave within the bounds, or one that Fastscan matches.
    IdentifySlave,
    /// 50: a slave without a node-ID.
    IdentifyNonConfiguredSlave,
    /// 51: one step of Fastscan.
    Fastscan {
        /// The bits known so far.
        id_number: u32,
        /// The lowest bit compared, 0..=31; 80 asks for any slave; others are invalid.
        bit_check: u8,
        /// Number of the part compared, 0..=3.
        sub: u8,
        /// Number of the part to be compared next, 0..=3.
        next: u8,
    },
    /// 5A..5D from the master.
    Inquire {
        /// Which number is asked for.
        part: Part,
    },
    /// 5A..5D from a slave.
    InquireResponse {
        /// Which number it is.
        part: Part,
        /// Its value.
        value: u32,
    },
    /// 5E from the master.
    InquireNodeId,
    /// 5E from a slave.
    InquireNodeIdResponse {
        /// The slave's node-ID, FF = unconfigured.
        node: u8,
    },
    /// A command specifier that CiA 305 does not define for this direction.
    Unknown(u8),
}
