//! The LSS slaves in the configuration state, and the address by which the master is selecting one.
//!
//! Events before the capture or in a gap are unknown.

use super::node_id::Before;
use crate::wire::lss::Part;

/// The set of slaves in the configuration state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selected {
    /// Unknown.
    #[default]
    Unknown,
    /// None: all were switched to waiting.
    Nobody,
    /// The number of slaves that have answered a selective switch or a Fastscan.
    Slaves(u32),
    /// All slaves on the bus.
    All,
}

/// The state of the selection.
#[derive(Debug, Default)]
pub struct Selection {
    /// The slaves in the configuration state.
    pub selected: Selected,
    /// Number of selections so far.
    pub number: u64,
    /// The node-ID of the selected slave, as reported or derived from the way it was found.
    pub before: Before,
    /// The address by which it was selected.
    slave: Option<[u32; 4]>,
    /// The address that the master is sending, and the next part; `None` if unknown.
    address: [Option<u32>; 4],
    next_part: Option<u8>,
    /// A wrong order of the parts of this address was reported.
    misordered: bool,
}

impl Selection {
    /// Switches all slaves to waiting (0) or to configuration (1).
    pub fn switch(&mut self, mode: u8) {
        self.selected = match mode {
            0 => Selected::Nobody,
            1 => Selected::All,
            _ => Selected::Unknown,
        };
        self.select(None, Before::Unknown);
        (self.next_part, self.misordered) = (Some(0), false);
    }

    /// Takes a part of the address of the slave to be selected; returns the number of the expected part if this is
    /// another one, once per address.
    pub fn part(&mut self, part: Part, value: u32) -> Option<u8> {
        let number = part.number();
        if number == 0 {
            self.address = [None; 4];
        }
        let expected = self.next_part.filter(|expected| *expected != number && number != 0);
        if expected.is_some() {
            // The next address shows if this part is wrong or the one before.
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

    /// Returns the address that the master has sent if all of it was seen.
    pub fn address(&self) -> Option<[u32; 4]> {
        let [vendor, product, revision, serial] = self.address;
        Some([vendor?, product?, revision?, serial?])
    }

    /// Adds a slave in the configuration state, unless it is the same one again.
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

    /// Returns the previous node-ID of the only selected slave.
    pub fn single(&self) -> Before {
        let single = matches!(self.selected, Selected::Slaves(1) | Selected::All | Selected::Unknown);
        if single { self.before } else { Before::Unknown }
    }

    /// Takes an unreadable frame, which may have switched slaves.
    pub fn unreadable(&mut self) {
        self.next_part = None;
        if self.selected == Selected::Nobody {
            self.selected = Selected::Unknown;
        }
    }

    /// Takes a reset or boot-up: the node is waiting, the others are unknown.
    pub fn restarted(&mut self) {
        if self.selected != Selected::Nobody {
            self.selected = Selected::Unknown;
        }
    }

    /// Forgets the selection after lost frames.
    pub fn lost(&mut self) {
        *self = Self { number: self.number + 1, ..Self::default() };
    }

    fn select(&mut self, address: Option<[u32; 4]>, before: Before) {
        (self.number, self.slave, self.before) = (self.number.saturating_add(1), address, before);
    }
}
