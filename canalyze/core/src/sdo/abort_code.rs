//! The code of an abort: 32 bits in SDO (CiA 301, table 22), 8 bits in USDO (CiA 1301, table 31).

use crate::words::digits::{Hex, Put};

/// A time-out of SDO.
const TIMED_OUT: u32 = 0x0504_0000;

/// The codes of USDO that mean the same as one of SDO.
const SAME: [(u8, u32); 29] = [
    (0x10, 0x0800_0000),
    (0x12, TIMED_OUT),
    (0x13, 0x0504_0001),
    (0x15, 0x0607_0010),
    (0x16, 0x0504_0005),
    (0x17, 0x0604_0043),
    (0x18, 0x0604_0047),
    (0x30, 0x0601_0000),
    (0x31, 0x0601_0001),
    (0x32, 0x0601_0002),
    (0x33, 0x0602_0000),
    (0x34, 0x0609_0011),
    (0x35, 0x0606_0000),
    (0x36, 0x0607_0010),
    (0x37, 0x0607_0012),
    (0x38, 0x0607_0013),
    (0x40, 0x0609_0030),
    (0x41, 0x0609_0031),
    (0x42, 0x0609_0032),
    (0x43, 0x0609_0036),
    (0x50, 0x0604_0041),
    (0x51, 0x0604_0042),
    (0x55, 0x0800_0022),
    (0x56, 0x0800_0022),
    (0x60, 0x0800_0020),
    (0x61, 0x0800_0021),
    (0x62, 0x0800_0022),
    (0x63, 0x0800_0023),
    (0x64, 0x0800_0024),
];

/// The code of an abort.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AbortCode {
    /// Of an SDO transfer.
    Sdo(u32),
    /// Of a USDO transfer.
    Usdo(u8),
}

impl AbortCode {
    /// Returns the code by its number: SDO's are longer than a byte.
    pub fn of(number: u32) -> Self {
        u8::try_from(number).map_or(Self::Sdo(number), Self::Usdo)
    }

    /// Returns the number in the frame.
    pub fn number(self) -> u32 {
        match self {
            Self::Sdo(code) => code,
            Self::Usdo(code) => code.into(),
        }
    }

    /// Returns the code of SDO with the same meaning; 0 if there is none.
    pub fn meaning(self) -> u32 {
        match self {
            Self::Sdo(code) => code,
            Self::Usdo(code) => SAME.iter().find(|(known, _)| *known == code).map_or(0, |(_, meaning)| *meaning),
        }
    }

    /// Returns true if the frames of the other side violated the protocol.
    pub fn is_violation(self) -> bool {
        match self {
            Self::Sdo(code) => code != TIMED_OUT && (0x0503_0000..=0x0504_0004).contains(&code),
            Self::Usdo(code) => matches!(code, 0x11 | 0x13..=0x15 | 0x1E | 0x1F | 0x21),
        }
    }

    /// Returns true if the server has no time now.
    pub fn is_busy(self) -> bool {
        self == Self::Usdo(0x70)
    }

    /// Returns true for a time-out of the protocol.
    pub fn is_timeout(self) -> bool {
        self.meaning() == TIMED_OUT
    }
}

impl Put for AbortCode {
    /// Appends eight hexadecimal digits, or two for USDO.
    fn put(&self, out: &mut Vec<u8>) {
        match *self {
            Self::Sdo(code) => Hex::<8>(u64::from(code)).put(out),
            Self::Usdo(code) => Hex::<2>(u64::from(code)).put(out),
        }
    }
}
