//! Items of several live buses, held until their order is known: joined by time, unchanged within a bus.
//!
//! Each receiver delivers the items of one bus, and earlier ones of another bus may come later. All are therefore held
//! until everything up to some time has come. Memory is bounded, and items of a single bus are never held.

use crate::bytes::ns::Ns;
use crate::bytes::readers::Item;

/// Maximum number of held items; beyond it all are released in their present order.
pub(super) const MOST: usize = 1 << 18;

/// The held items.
#[derive(Debug, Default)]
pub(super) struct HeldItems {
    /// True if there are several buses.
    pub(super) joins: bool,
    /// The items with the times that they wait for, in ns.
    items: Vec<(Ns, Item)>,
    /// The last such time by the stream's own index of buses, in ns.
    times: Vec<Ns>,
    /// The last time up to which everything had come, in ns.
    until: Option<Ns>,
}

impl HeldItems {
    /// Takes an item of a bus and passes it on at once if the bus is alone. It waits for its stamp, but at least as
    /// long as earlier items of its bus; an item without a stamp follows these.
    pub(super) fn take(&mut self, bus: u8, item: Item, mut give: impl FnMut(Item)) {
        if !self.joins {
            return give(item);
        }
        let index = usize::from(bus);
        if self.times.len() <= index {
            self.times.resize(index + 1, Ns::MIN);
        }
        let Some(time) = self.times.get_mut(index) else { return give(item) };
        if let Item::Frame(frame) = &item {
            *time = frame.t_ns.map_or(*time, |t_ns| t_ns.max(*time));
        }
        self.items.push((*time, item));
        if self.items.len() >= MOST {
            self.release(None, give);
        }
    }

    /// Releases everything up to `until`, or everything, ordered by time and then by arrival.
    pub(super) fn release(&mut self, until: Option<Ns>, give: impl FnMut(Item)) {
        // After a step back of the clock, none of the held items would ever be due.
        let back = until.zip(self.until).is_some_and(|(now, before)| now < before);
        self.until = until.or(self.until);
        self.items.sort_by_key(|(time, _)| *time);
        let due = match until.filter(|_| !back) {
            Some(until) => self.items.partition_point(|(time, _)| *time <= until),
            None => self.items.len(),
        };
        if due == self.items.len() {
            self.times.clear();
        }
        self.items.drain(..due).map(|(_, item)| item).for_each(give);
    }
}
