//! The byte order of a file's identifiers.
//!
//! LINKTYPE_CAN_SOCKETCAN defines big-endian, but programs that dump the kernel's structure write the order of their
//! host. In the wrong order, 181h becomes an identifier of 29 bits without any visible error. The first records of a
//! file are therefore examined before any is emitted: an identifier of 11 bits has two zero bytes, whose side is
//! significant. No record is judged alone.

use super::ByteOrder;
use crate::bytes::frame::{Frame, Kind};
use crate::bytes::readers::Unreadable;

const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = 0x2000_0000;
/// Maximum class of an error frame.
const CLASSES: u32 = 0x3FF;

/// Maximum number of examined records.
const RECORDS: u32 = 64;
/// Number of bytes of the file in which they are examined.
const HEAD: u64 = 64 * 1024;
/// Number of records that can be 11-bit identifiers in the wrong order only from which that order is certain.
const SURE: u32 = 3;
/// Minimum number of records by which a file is judged. It is also enough if all of them are valid in the right order
/// only.
const ENOUGH: u32 = 8;

/// The byte order of a file's identifiers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Reading {
    /// As the format defines.
    #[default]
    Big,
    /// Contrary to the format.
    Little,
    /// Unknown: most are invalid in either order.
    Neither,
}

impl Reading {
    pub(super) fn order(self) -> ByteOrder {
        if self == Self::Little { ByteOrder::Little } else { ByteOrder::Big }
    }
}

/// The meaning of four bytes in one order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sense {
    /// Not an identifier.
    Nothing,
    Extended,
    Standard,
}

fn sense(id: u32) -> Sense {
    let number = id & !(EXTENDED | REMOTE | ERROR);
    match id & (EXTENDED | REMOTE | ERROR) {
        ERROR if number <= CLASSES => Sense::Standard,
        ERROR => Sense::Extended,
        0 | REMOTE if number <= 0x7FF => Sense::Standard,
        flags if flags & EXTENDED != 0 && flags & ERROR == 0 => Sense::Extended,
        _ => Sense::Nothing,
    }
}

/// The evidence from the first records of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Votes {
    decided: Option<Reading>,
    seen: u32,
    /// Number of records that are valid identifiers in this order.
    big: u32,
    little: u32,
    /// Number of 11-bit identifiers in the wrong order.
    standard: u32,
    /// Number of 11-bit identifiers in the wrong order that are invalid in the right one.
    sure: u32,
    /// Number of 11-bit identifiers in the wrong order that have 29 bits, mostly zero, in the right one.
    shifted: u32,
    first: Option<[u8; 4]>,
    /// True if these are not all the same.
    various: bool,
}

impl Votes {
    /// Adds the first bytes of a packet whose record begins at this offset.
    pub(super) fn take(&mut self, packet: &[u8], at: u64) {
        let Some(id) = packet.first_chunk::<4>().filter(|_| self.decided.is_none()) else { return };
        if at >= HEAD || self.seen >= RECORDS {
            self.decided = Some(self.judge());
            return;
        }
        let senses = (sense(u32::from_be_bytes(*id)), sense(u32::from_le_bytes(*id)));
        if *id == [0; 4] {
            return; // the same in both
        }
        self.seen += 1;
        self.big += u32::from(senses.0 != Sense::Nothing);
        self.little += u32::from(senses.1 != Sense::Nothing);
        self.standard += u32::from(senses.1 == Sense::Standard);
        match senses {
            (Sense::Standard, _) => self.decided = Some(Reading::Big),
            (Sense::Nothing, Sense::Standard) => self.sure += 1,
            (_, Sense::Standard) => {
                self.shifted += 1;
                self.various |= *self.first.get_or_insert(*id) != *id;
            }
            _ => {}
        }
        if self.sure >= SURE {
            self.decided = Some(Reading::Little);
        } else if self.seen >= ENOUGH && self.big == self.seen && self.little == 0 {
            self.decided = Some(Reading::Big);
        }
    }

    /// Returns the decision, if certain; the file has been examined up to `at`.
    pub(super) fn decided(&self, at: u64) -> Option<Reading> {
        self.decided.or_else(|| (at >= HEAD).then(|| self.judge()))
    }

    /// Returns the most likely order by all evidence.
    pub(super) fn judge(&self) -> Reading {
        if let Some(decided) = self.decided {
            return decided;
        }
        // Invalid in the right order, or valid only as several identifiers that are unlikely together.
        let odd = self.seen - self.big + if self.various { self.shifted } else { 0 };
        let most = |count: u32| count > 0 && count * 2 >= self.seen;
        let extended = self.little == self.seen && self.seen >= ENOUGH;
        match () {
            () if most(odd) && (most(self.standard) || extended) => Reading::Little,
            () if self.seen >= ENOUGH && self.big * 2 < self.seen => Reading::Neither,
            () => Reading::Big,
        }
    }
}

/// The kinds of identifiers read so far, which show records of another order among them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Orders {
    /// True if there were 11-bit identifiers, and 29-bit identifiers that are not 11-bit ones in the other order.
    standard: bool,
    extended: bool,
    /// The first 29-bit identifier that is an 11-bit one in the other order.
    odd: Option<u32>,
    /// True if there are records of that order: some are invalid in this one, or several identifiers are odd.
    mixed: bool,
}

impl Orders {
    /// Returns the frame, unless its identifier is more likely an 11-bit one in the other order.
    #[inline(always)]
    pub(super) fn take(&mut self, frame: Frame) -> Result<Frame, Unreadable> {
        if !frame.id.is_extended() || frame.kind == Kind::Error {
            self.standard = true;
            return Ok(frame);
        }
        let flags = if frame.kind == Kind::Remote { EXTENDED | REMOTE } else { EXTENDED };
        if sense((frame.id.raw() | flags).swap_bytes()) != Sense::Standard {
            self.extended = true;
            return Ok(frame);
        }
        let various = *self.odd.get_or_insert(frame.id.raw()) != frame.id.raw();
        self.mixed |= various && self.standard && !self.extended;
        if self.mixed { Err(Unreadable::Identifier) } else { Ok(frame) }
    }

    /// Records an unreadable record.
    pub(super) fn failed(&mut self, reason: Unreadable) {
        self.mixed |= reason == Unreadable::Identifier;
    }
}

#[cfg(test)]
mod tests {
    use super::{Reading, Votes};

    fn judged(ids: &[u32]) -> Reading {
        let mut votes = Votes::default();
        for (at, id) in (0..).zip(ids) {
            votes.take(&id.to_be_bytes(), at);
        }
        votes.judge()
    }

    #[test]
    fn identifiers_as_the_format_has_them() {
        for ids in [
            &[][..],
            &[0],
            &[0x601],
            &[0x181, 0x8000_0000],
            &[0x98FE_F100, 0x98EB_FF00],
            &[0x8C00_0000],
            &[0x8C00_0000, 0x8C00_0000, 0x98FE_F103],
            &[0x98FE_F181, 0x98EB_FF90],
            &[0x2000_0004],
            &[0x4000_0701],
            &[0x0800, 0x601],
            &[0x0001_0600, 0x601],
        ] {
            assert_eq!(judged(ids), Reading::Big, "{ids:X?}");
            let whole: Vec<u32> = ids.iter().copied().cycle().take(if ids.is_empty() { 0 } else { 200 }).collect();
            assert_eq!(judged(&whole), Reading::Big, "{ids:X?}");
        }
    }

    #[test]
    fn identifiers_in_the_wrong_order() {
        for ids in [
            &[0x601][..],
            &[0, 0x601],
            &[0x181, 0x182],
            &[0x080, 0x181, 0x281],
            &[0x581, 0x601],
            &[0x98FE_F103, 0x98EB_FF00, 0x8CF0_0400, 0x98FE_F200].repeat(2),
            &[0x2000_0004],
            &[0x4000_0701],
            &[0x98FE_F181, 0x601],
        ] {
            let swapped: Vec<u32> = ids.iter().map(|id: &u32| id.swap_bytes()).collect();
            assert_eq!(judged(&swapped), Reading::Little, "{ids:X?}");
        }
        // A single identifier that is valid in both orders is read as the format defines.
        assert_eq!(judged(&[0x181_u32.swap_bytes(); 100]), Reading::Big);
    }

    #[test]
    fn bytes_that_are_no_identifiers() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state ^ state >> 15
        };
        for _ in 0..50 {
            let ids: Vec<u32> = (0..64).map(|_| next()).collect();
            assert_ne!(judged(&ids), Reading::Little);
        }
        assert_eq!(judged(&[0x1234_5678; 100]), Reading::Neither);
        assert_eq!(judged(&[0x98FE_F103_u32.swap_bytes(); 7]), Reading::Big, "29 bits, and too few to tell");
        assert_eq!(judged(&[0x1234_5678; 7]), Reading::Big, "too few to tell");
    }
}
