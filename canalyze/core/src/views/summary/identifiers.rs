//! Figures for each CAN-ID, for traffic that is not CANopen.

use std::collections::BTreeMap;

use crate::bytes::frame::{CanId, Frame};
use crate::evidence::period::Gaps;
use crate::evidence::period::spread::Spread;

/// Maximum number of identifiers of a bus that are counted apart (invariant 6).
const TOLD_APART: usize = 1024;

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
    all: BTreeMap<CanId, Identifier>,
    /// Nothing on the bus is CANopen.
    foreign: bool,
}

impl Identifiers {
    /// Takes a frame with data.
    pub fn take(&mut self, frame: &Frame) {
        if self.all.len() >= TOLD_APART && !self.all.contains_key(&frame.id) {
            return;
        }
        let one = self.all.entry(frame.id).or_insert_with(|| Identifier {
            frames: 0,
            interval: Spread::default(),
            length: (frame.len, frame.len),
            foreign: false,
            gaps: Gaps::default(),
        });
        one.frames += 1;
        one.length = (one.length.0.min(frame.len), one.length.1.max(frame.len));
        if let Some(gap) = one.gaps.take(frame.t_ns) {
            one.interval.add(gap);
        }
    }

    /// Marks the frames of an identifier, or of all, as not CANopen.
    pub fn foreign(&mut self, id: Option<CanId>) {
        match id {
            Some(id) => {
                if let Some(one) = self.all.get_mut(&id) {
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

    /// Returns those that are not CANopen.
    pub fn iter(&self) -> impl Iterator<Item = (CanId, &Identifier)> {
        self.all.iter().filter(|(_, one)| self.foreign || one.foreign).map(|(id, one)| (*id, one))
    }

    /// Stops the measurement of times at a gap, since frames were lost.
    pub fn lost(&mut self) {
        self.all.values_mut().for_each(|one| one.gaps.interrupt());
    }
}
