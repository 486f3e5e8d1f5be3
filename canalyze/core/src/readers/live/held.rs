//! Items of several live buses until their order is known: joined by time, never changed within a bus.
//!
//! Each receiver hands over what one bus had; what another bus had before may come later. So all wait until it is said
//! that everything up to some time has come. Must not: hold anything of a bus that is alone, or hold without bound.

use crate::readers::Item;

/// Items held at most; if there are more, all are given as they stand.
pub(super) const MOST: usize = 1 << 18;

/// What is held.
#[derive(Debug, Default)]
pub(super) struct Held {
    /// There are several buses.
    pub(super) joins: bool,
    /// Each with the time that it waits for, in ns.
    items: Vec<(i64, Item)>,
    /// The last such time by the stream's own index of buses.
    times: Vec<i64>,
    /// The last time up to which all had come.
    until: Option<i64>,
}

impl Held {
    /// Takes an item of a bus, and gives it at once if the bus is alone. It waits for its stamp, but never before what
    /// came before it on its bus; what has no stamp goes with that.
    pub(super) fn take(&mut self, bus: u8, item: Item, mut give: impl FnMut(Item)) {
        if !self.joins {
            return give(item);
        }
        let index = usize::from(bus);
        if self.times.len() <= index {
            self.times.resize(index + 1, i64::MIN);
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

    /// Everything up to `until` has come, or everything: gives it in the order of time; of equal times what came first.
    pub(super) fn release(&mut self, until: Option<i64>, give: impl FnMut(Item)) {
        // A clock that was set back: by its new time none of what is held would ever be due.
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
