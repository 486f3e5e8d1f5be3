//! In which byte order the identifiers of a file stand.
//!
//! LINKTYPE_CAN_SOCKETCAN has them big-endian, but programs that pack the kernel's structure by themselves write them in
//! the order of their host. Read the wrong way round, 181h becomes an identifier of 29 bits and nothing looks wrong. So
//! the first records of a file are looked at before one is given out: an identifier of 11 bits has two bytes that are
//! zero, and on which side these are is not left to chance. Must not: judge a record by itself.

use super::Order;
use crate::frame::{Frame, Kind};
use crate::readers::Unreadable;

const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = 0x2000_0000;
/// Greatest class of an error frame.
const CLASSES: u32 = 0x3FF;

/// Records that are looked at.
const RECORDS: u32 = 64;
/// Bytes of the file in which they are looked for.
const HEAD: u64 = 64 * 1024;
/// Records that can be identifiers of 11 bits in the wrong order only, for that order to be taken at once.
const SURE: u32 = 3;
/// Records of which most must be identifiers in one order or the other; fewer tell nothing of a file. Where all of them
/// are in the right order only, that is enough.
const ENOUGH: u32 = 8;

/// How the identifiers of a file are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Reading {
    /// As the format has them.
    #[default]
    Big,
    /// Against the format.
    Little,
    /// Not at all: most are no identifiers in either order.
    Neither,
}

impl Reading {
    pub(super) fn order(self) -> Order {
        if self == Self::Little { Order::Little } else { Order::Big }
    }
}

/// What four bytes are in one order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sense {
    /// No identifier.
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

/// What the first records of a file show.
#[derive(Clone, Debug, Default)]
pub(super) struct Votes {
    decided: Option<Reading>,
    seen: u32,
    /// Records that are identifiers in this order.
    big: u32,
    little: u32,
    /// Those of 11 bits in the wrong order.
    standard: u32,
    /// Those of 11 bits in the wrong order and none at all in the right one.
    sure: u32,
    /// Those of 11 bits in the wrong order, and of 29 bits, most of them zero, in the right one.
    shifted: u32,
    first: Option<[u8; 4]>,
    /// These are not all the same.
    various: bool,
}

impl Votes {
    /// Takes the first bytes of a packet whose record begins at this offset.
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

    /// What is known for certain by now, `at` being how far the file was looked at.
    pub(super) fn decided(&self, at: u64) -> Option<Reading> {
        self.decided.or_else(|| (at >= HEAD).then(|| self.judge()))
    }

    /// What is most likely by all that was seen.
    pub(super) fn judge(&self) -> Reading {
        if let Some(decided) = self.decided {
            return decided;
        }
        // What the right order does not allow, or allows only as identifiers that nobody has more than one of.
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

/// What has been read of a file so far, and what that says of records of another order among those of one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Orders {
    /// Identifiers of 11 bits have been read, and identifiers of 29 bits that are none of 11 bits in the other order.
    standard: bool,
    extended: bool,
    /// The first identifier of 29 bits that is one of 11 bits in the other order.
    odd: Option<u32>,
    /// There are records of that order: some are no identifiers in this one, or several identifiers are odd.
    mixed: bool,
}

impl Orders {
    /// Gives the frame, unless its identifier is more likely one of 11 bits in the other order.
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

    /// A record could not be read.
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
        // A single identifier that both readings allow is what the format says.
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
