//! What somebody owes by a time: a response, the next heartbeat, a boot-up after a reset.
//!
//! Every deadline is one of these. It is opened with the evidence for it, met by a frame, voided by what excuses it, or
//! due. It must not report: whoever opened it does.

use std::collections::BTreeMap;

use crate::frame::FrameRef;

use super::recording::Recording;
use super::when::When;

/// Obligations kept at most (invariant 6); further ones are not watched.
const KEPT: usize = 4096;

/// Something owed.
#[derive(Clone, Copy, Debug)]
pub struct Owed {
    /// Since when.
    pub since: When,
    /// For how long it may be owed, in ns.
    pub limit_ns: i64,
    /// The frame that shows that it is owed: the write that configured it, the command; `None`: learnt, or described.
    pub why: Option<FrameRef>,
}

/// What is owed, by a key of the check.
#[derive(Debug)]
pub struct Obligations<K> {
    open: BTreeMap<K, Owed>,
    /// Nothing is due before this, in ns.
    next_ns: i64,
}

impl<K: Ord> Default for Obligations<K> {
    fn default() -> Self {
        Self { open: BTreeMap::new(), next_ns: i64::MAX }
    }
}

impl<K: Ord + Copy> Obligations<K> {
    /// Something is owed from now on; what was owed by the same key is replaced.
    pub fn open(&mut self, key: K, owed: Owed) {
        if self.open.len() >= KEPT && !self.open.contains_key(&key) {
            return;
        }
        if let Some(since) = owed.since.at.t_ns {
            self.next_ns = self.next_ns.min(since.saturating_add(owed.limit_ns));
        }
        self.open.insert(key, owed);
    }

    /// Whether nothing is owed.
    pub fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// What is owed by a key.
    pub fn get(&self, key: K) -> Option<&Owed> {
        self.open.get(&key)
    }

    /// It has come.
    pub fn met(&mut self, key: K) -> Option<Owed> {
        self.open.remove(&key)
    }

    /// All is owed anew from `now` on.
    pub fn renew(&mut self, now: When) {
        self.open.values_mut().for_each(|owed| owed.since = now);
    }

    /// What fits is not owed any more.
    pub fn void(&mut self, mut fits: impl FnMut(&K) -> bool) {
        self.open.retain(|key, _| !fits(key));
    }

    /// What has certainly been owed for longer than `limit_ns` says at `now`, whatever its own limit; it is not owed any
    /// more.
    pub fn overdue(&mut self, now: When, recording: &Recording, limit_ns: impl Fn(K, &Owed) -> i64) -> Vec<(K, Owed)> {
        let late = |key: K, owed: &Owed| recording.certainly_later(now, owed.since, limit_ns(key, owed));
        let due: Vec<(K, Owed)> = self.open.iter().filter(|(k, o)| late(**k, o)).map(|(k, o)| (*k, *o)).collect();
        for (key, _) in &due {
            self.open.remove(key);
        }
        due
    }

    /// Whether something may be overdue at `now_ns`.
    #[inline]
    pub fn may_be_due(&self, now_ns: i64) -> bool {
        now_ns > self.next_ns
    }

    /// What is certainly overdue at `now`, in the order of the keys; it is not owed any more.
    #[inline]
    pub fn due(&mut self, now: When, recording: &Recording) -> Vec<(K, Owed)> {
        match now.at.t_ns {
            Some(now_ns) if self.may_be_due(now_ns) => self.due_at(now_ns, now, recording),
            _ => Vec::new(),
        }
    }

    fn due_at(&mut self, now_ns: i64, now: When, recording: &Recording) -> Vec<(K, Owed)> {
        // Where frames may be missing, or the clock was set, it is owed anew.
        self.open.values_mut().filter(|owed| owed.since.epoch != now.epoch).for_each(|owed| owed.since = now);
        let late = |owed: &Owed| recording.certainly_later(now, owed.since, owed.limit_ns);
        let due: Vec<(K, Owed)> = self.open.iter().filter(|(_, owed)| late(owed)).map(|(k, o)| (*k, *o)).collect();
        for (key, _) in &due {
            self.open.remove(key);
        }
        let deadlines = self.open.values().filter_map(|owed| Some(owed.since.at.t_ns?.saturating_add(owed.limit_ns)));
        // What is only likely overdue is looked at again with the next frame.
        self.next_ns = deadlines.min().unwrap_or(i64::MAX).max(now_ns);
        due
    }
}
