//! Which LSS slaves are in the configuration state, and the address by which the master is switching one there.
//!
//! What happened before the capture, or in a gap, is unknown. It must not judge.

use super::node_id::Before;
use crate::wire::lss::Part;

/// Which slaves are in the configuration state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selected {
    /// Not known.
    #[default]
    Unknown,
    /// None: all were switched to waiting.
    Nobody,
    /// As many as have answered a selective switch or a Fastscan.
    Slaves(u32),
    /// Every slave on the bus, if there is any.
    All,
}

/// What is known of the slaves in the configuration state.
#[derive(Debug, Default)]
pub struct Selection {
    /// Which they are.
    pub selected: Selected,
    /// Selections so far.
    pub number: u64,
    /// The node-ID of the selected slave, as it has reported or as follows from how it was found.
    pub before: Before,
    /// Its address, by which it was selected.
    slave: Option<[u32; 4]>,
    /// The address that the master is sending, and the part that comes next; `None` where that is not known.
    address: [Option<u32>; 4],
    next_part: Option<u8>,
    /// It was reported that the parts of this address come out of order.
    misordered: bool,
}

impl Selection {
    /// All slaves were switched to waiting (0) or to configuration (1).
    pub fn switch(&mut self, mode: u8) {
        self.selected = match mode {
            0 => Selected::Nobody,
            1 => Selected::All,
            _ => Selected::Unknown,
        };
        self.select(None, Before::Unknown);
        (self.next_part, self.misordered) = (Some(0), false);
    }

    /// A part of the address of the slave that is to be selected. Gives the number of the expected part where this is
    /// another one, once for each address.
    pub fn part(&mut self, part: Part, value: u32) -> Option<u8> {
        let number = part.number();
        if number == 0 {
            self.address = [None; 4];
        }
        let expected = self.next_part.filter(|expected| *expected != number && number != 0);
        if expected.is_some() {
            // Which one is wrong, this one or the one before, shows with the next address.
            self.next_part = None;
        }
        let news = expected.filter(|_| !std::mem::replace(&mut self.misordered, true));
        self.misordered &= number != 3;
        if number == 0 || self.next_part.is_some() {
            self.next_part = Some((number + 1) % 4);
        }
        if let Some(slot) = self.address.get_mut(usize::from(number)) {
            *slot = Some(value);
        }
        news
    }

    /// The address that the master has sent, where all of it was seen.
    pub fn address(&self) -> Option<[u32; 4]> {
        let [vendor, product, revision, serial] = self.address;
        Some([vendor?, product?, revision?, serial?])
    }

    /// One more slave is in the configuration state, unless it is the same one again.
    pub fn join(&mut self, address: Option<[u32; 4]>, before: Before) {
        if address.is_some() && address == self.slave && matches!(self.selected, Selected::Slaves(_)) {
            return;
        }
        self.selected = match self.selected {
            Selected::Nobody | Selected::Unknown => Selected::Slaves(1),
            Selected::Slaves(count) => Selected::Slaves(count.saturating_add(1)),
            Selected::All => Selected::All,
        };
        self.select(address, before);
    }

    /// The node-ID that the only selected slave had.
    pub fn single(&self) -> Before {
        let single = matches!(self.selected, Selected::Slaves(1) | Selected::All | Selected::Unknown);
        if single { self.before } else { Before::Unknown }
    }

    /// A frame could not be read: it may have switched slaves.
    pub fn unreadable(&mut self) {
        self.next_part = None;
        if self.selected == Selected::Nobody {
            self.selected = Selected::Unknown;
        }
    }

    /// A node was reset or has booted up: it is in the waiting state, and whether others are not is not known.
    pub fn restarted(&mut self) {
        if self.selected != Selected::Nobody {
            self.selected = Selected::Unknown;
        }
    }

    /// Frames were lost: slaves may have been switched.
    pub fn lost(&mut self) {
        *self = Self { number: self.number + 1, ..Self::default() };
    }

    fn select(&mut self, address: Option<[u32; 4]>, before: Before) {
        (self.number, self.slave, self.before) = (self.number.saturating_add(1), address, before);
    }
}
