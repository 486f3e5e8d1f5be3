//! Figures for each CAN-ID, for traffic that is not CANopen.

use std::collections::BTreeMap;

use crate::bytes::frame::{CanId, Frame};
use crate::evidence::period::Gaps;
use crate::evidence::period::spread::Spread;

/// Maximum number of identifiers of a bus that are counted apart (invariant 6).
const TOLD_APART: usize = 1024;
/// Number of 11-bit identifiers.
const STANDARD: usize = 0x800;

/// The frames of one identifier.
#[derive(Clone, Debug)]
pub struct Identifier {
    /// Frames.
    pub frames: u64,
    /// Times from one to the next, in ns.
    pub interval: Spread,
    /// The least and the greatest length, in bytes.
    pub length: (u8, u8),
    /// CANopen defines no service for it, or its frames are not those of that service.
    pub foreign: bool,
    gaps: Gaps,
}

/// The identifiers of a bus.
#[derive(Clone, Debug, Default)]
pub struct Identifiers {
    /// By 11-bit identifier; empty before the first.
    standard: Vec<Option<Box<Identifier>>>,
    extended: BTreeMap<CanId, Box<Identifier>>,
    count: usize,
    /// Nothing on the bus is CANopen.
    foreign: bool,
}

impl Identifiers {
    /// Takes a frame with data.
    pub fn take(&mut self, frame: &Frame) {
        if self.get_mut(frame.id).is_none() && !self.add(frame) {
            return;
        }
        let Some(one) = self.get_mut(frame.id) else { return };
        one.frames += 1;
        one.length = (one.length.0.min(frame.len), one.length.1.max(frame.len));
        if let Some(gap) = one.gaps.take(frame.t_ns) {
            one.interval.add(gap);
        }
    }

    #[inline]
    fn get_mut(&mut self, id: CanId) -> Option<&mut Identifier> {
        if id.is_extended() {
            return self.extended.get_mut(&id).map(|one| &mut **one);
        }
        self.standard.get_mut(id.raw() as usize)?.as_deref_mut()
    }

    /// Adds the identifier of a frame; returns true unless there are too many.
    #[cold]
    fn add(&mut self, frame: &Frame) -> bool {
        if self.count >= TOLD_APART {
            return false;
        }
        self.count += 1;
        let one = Box::new(Identifier {
            frames: 0,
            interval: Spread::default(),
            length: (frame.len, frame.len),
            foreign: false,
            gaps: Gaps::default(),
        });
        if frame.id.is_extended() {
            self.extended.insert(frame.id, one);
            return true;
        }
        self.standard.resize(STANDARD, None);
        if let Some(slot) = self.standard.get_mut(frame.id.raw() as usize) {
            *slot = Some(one);
        }
        true
    }

    /// Marks the frames of an identifier, or of all, as not CANopen.
    pub fn foreign(&mut self, id: Option<CanId>) {
        match id {
            Some(id) => {
                if let Some(one) = self.get_mut(id) {
                    one.foreign = true;
                }
            }
            None => self.foreign = true,
        }
    }

    /// Returns true if nothing on the bus is CANopen.
    pub fn are_foreign(&self) -> bool {
        self.foreign
    }

    /// Returns those that are not CANopen, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (CanId, &Identifier)> {
        let standard = self.standard.iter().enumerate();
        let standard = standard.filter_map(|(id, one)| Some((CanId::standard(id as u16), one.as_deref()?)));
        let all = standard.chain(self.extended.iter().map(|(id, one)| (*id, &**one)));
        all.filter(|(_, one)| self.foreign || one.foreign)
    }

    /// Stops the measurement of times at a gap, since frames were lost.
    pub fn lost(&mut self) {
        let all = self.standard.iter_mut().flatten().chain(self.extended.values_mut());
        all.for_each(|one| one.gaps.interrupt());
    }
}
