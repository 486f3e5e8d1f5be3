//! Obligations with a deadline: a response, the next heartbeat, a boot-up after a reset.
//!
//! An obligation is opened with its evidence, and then met by a frame, voided by an excuse, or due. The check that
//! opened it reports it.

use std::collections::BTreeMap;

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;

use super::recording::Recording;
use super::when::When;

/// Maximum number of obligations (invariant 6); further ones are not watched.
const KEPT: usize = 4096;

/// One obligation.
#[derive(Clone, Copy, Debug)]
pub struct Owed {
    /// Its beginning.
    pub since: When,
    /// Its time limit, in ns.
    pub limit_ns: Ns,
    /// The frame that shows the obligation: the configuring write or the command; `None` if learnt or described.
    pub why: Option<FrameRef>,
}

/// Open obligations by a key of the check.
#[derive(Debug)]
pub struct Obligations<K> {
    open: BTreeMap<K, Owed>,
    /// The earliest deadline, in ns.
    next_ns: Ns,
}

impl<K: Ord> Default for Obligations<K> {
    fn default() -> Self {
        Self { open: BTreeMap::new(), next_ns: Ns::MAX }
    }
}

impl<K: Ord + Copy> Obligations<K> {
    /// Opens an obligation, replacing an earlier one of the same key.
    #[inline(never)]
    pub fn open(&mut self, key: K, owed: Owed) {
        if self.open.len() >= KEPT && !self.open.contains_key(&key) {
            return;
        }
        if let Some(since) = owed.since.at.t_ns {
            self.next_ns = self.next_ns.min(since + owed.limit_ns);
        }
        self.open.insert(key, owed);
    }

    /// Returns true if there are no obligations.
    pub fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Returns the obligation of a key.
    pub fn get(&self, key: K) -> Option<&Owed> {
        self.open.get(&key)
    }

    /// Removes an obligation that has been met.
    pub fn met(&mut self, key: K) -> Option<Owed> {
        self.open.remove(&key)
    }

    /// Restarts the obligations from before lost frames at the next frame.
    pub fn restart(&mut self) {
        self.next_ns = Ns::MIN;
    }

    /// Restarts all obligations at `now`.
    pub fn renew(&mut self, now: When) {
        self.open.values_mut().for_each(|owed| owed.since = now);
    }

    /// Removes the obligations whose key `fits`.
    pub fn void(&mut self, mut fits: impl FnMut(&K) -> bool) {
        self.open.retain(|key, _| !fits(key));
    }

    /// Removes and returns the obligations that are certainly older at `now` than `limit_ns`, regardless of their own
    /// limits.
    pub fn overdue(&mut self, now: When, recording: &Recording, limit_ns: impl Fn(K, &Owed) -> Ns) -> Vec<(K, Owed)> {
        let late = |key: K, owed: &Owed| recording.certainly_later(now, owed.since, limit_ns(key, owed));
        let due: Vec<(K, Owed)> = self.open.iter().filter(|(k, o)| late(**k, o)).map(|(k, o)| (*k, *o)).collect();
        for (key, _) in &due {
            self.open.remove(key);
        }
        due
    }

    /// Returns true if an obligation may be overdue at `now_ns`.
    #[inline]
    pub fn may_be_due(&self, now_ns: Ns) -> bool {
        now_ns > self.next_ns
    }

    /// Removes and returns the obligations that are certainly overdue at `now`, in the order of keys.
    #[inline]
    pub fn due(&mut self, now: When, recording: &Recording) -> Vec<(K, Owed)> {
        match now.at.t_ns {
            Some(now_ns) if self.may_be_due(now_ns) => self.due_at(now_ns, now, recording),
            _ => Vec::new(),
        }
    }

    fn due_at(&mut self, now_ns: Ns, now: When, recording: &Recording) -> Vec<(K, Owed)> {
        // After a possible loss of frames or a step of the clock, the time starts anew.
        self.open.values_mut().filter(|owed| owed.since.epoch != now.epoch).for_each(|owed| owed.since = now);
        let late = |owed: &Owed| recording.certainly_later(now, owed.since, owed.limit_ns);
        let due: Vec<(K, Owed)> = self.open.iter().filter(|(_, owed)| late(owed)).map(|(k, o)| (*k, *o)).collect();
        for (key, _) in &due {
            self.open.remove(key);
        }
        let deadlines = self.open.values().filter_map(|owed| Some(owed.since.at.t_ns? + owed.limit_ns));
        // Obligations that are only probably overdue are examined again with the next frame.
        self.next_ns = deadlines.min().unwrap_or(Ns::MAX).max(now_ns);
        due
    }
}
