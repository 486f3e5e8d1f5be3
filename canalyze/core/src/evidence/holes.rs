//! Holes of a recording that nothing announces: frames of some time are not in it, or its clock was put on.
//!
//! The whole bus is silent, and behind the silence several senders that come evenly, and independently of each other, come
//! as they would have come: each a whole number of its periods after its last frame, so that frames are missing, or all of
//! them late by the same time, so that the clock was put on. No fault of one node does that. A sender that does not come back,
//! or that begins anew, fell silent itself; what comes late by different times waited for the recorder
//! ([`Stalls`](super::stalls::Stalls)). It must not know more of a frame than who sends it.

use std::collections::BTreeSet;

use crate::frame::{Frame, Kind};

use super::duplicates::PATIENCE_NS;
use super::senders::{Even, identifier};
use super::stalls::{Stalls, Verdict};

/// The least by which a sender that comes evenly is off its time, in ns, and the most, as a part of its period, by which
/// it may be off to show anything.
const OFF_NS: i64 = 1_000_000;
const SHOWS_PART: i64 = 8;
/// How exact the period of a sender is known, as a part of it: several periods add up.
const PERIOD_PART: i64 = 1024;
/// Most frames that wait until it is known whether a silence is a hole.
const KEPT: u64 = 16_384;
/// Senders, independent of each other, that show a hole.
const SENDERS: usize = 2;
/// Holes remembered.
const HOLES: usize = 16;

/// A sender that was expected when the bus fell silent.
#[derive(Clone, Copy, Debug)]
struct Sender {
    even: Even,
    /// By how much it may be off its time, in ns.
    room_ns: i64,
    /// A frame of it was due in the silence.
    missed: bool,
    /// When it came again, in ns.
    back_ns: Option<i64>,
    /// Whether that was its own time: frames that follow a silence without a pause may have waited for the recorder,
    /// unless the sender keeps its period from there.
    firm: bool,
    /// It has come twice: it shows no more.
    over: bool,
}

/// What may have happened.
#[derive(Clone, Debug, Default)]
struct Guess {
    /// The senders that show it.
    shown: BTreeSet<u8>,
    /// Error control shows otherwise.
    refuted: bool,
}

impl Guess {
    fn take(&mut self, sender: &Sender, fits: bool, shows: bool) {
        if fits && shows && sender.firm {
            self.shown.insert(sender.even.node);
        }
        self.refuted |= !fits && sender.even.node > 0;
    }

    fn is_sure(&self) -> bool {
        !self.refuted && self.shown.len() >= SENDERS
    }
}

/// A silence that may be a hole.
#[derive(Clone, Debug)]
struct Doubt {
    /// The number of the first frame behind it.
    first: u64,
    from_ns: i64,
    to_ns: i64,
    senders: Vec<Sender>,
    /// Frames are missing; or the clock was put on, by a time between these, in ns.
    missing: Guess,
    later: Guess,
    by_ns: (i64, i64),
}

impl Doubt {
    /// A frame of a sender has come at `now`. `in_row`: without a pause since the silence.
    fn heard(&mut self, place: usize, now: i64, in_row: bool) {
        let Some(slot) = self.senders.get_mut(place).filter(|sender| !sender.over) else { return };
        let before = *slot;
        let Some(back_ns) = before.back_ns else {
            // Of what waited, all that was due in a longer time would have come at once.
            let late_ns = now.saturating_sub(slot.even.last_ns).saturating_sub(slot.even.gap_ns);
            let waited = in_row && late_ns <= slot.even.gap_ns.saturating_add(slot.room_ns);
            (slot.back_ns, slot.firm) = (Some(now), !waited);
            let sender = *slot;
            return self.back(&sender, now);
        };
        let after_ns = now.saturating_sub(back_ns);
        let goes_on = after_ns.saturating_sub(before.even.gap_ns).saturating_abs() <= before.room_ns;
        (slot.over, slot.firm) = (true, slot.firm || goes_on);
        let sender = *slot;
        if !before.firm {
            self.missing.take(&sender, goes_on && self.is_as_due(&sender, back_ns), sender.missed);
        }
        // A clock that was put on stays so; what was only late once is back in its time.
        self.later.take(&sender, goes_on, true);
    }

    /// A sender has come again then: what its first frame shows.
    fn back(&mut self, sender: &Sender, back_ns: i64) {
        if sender.firm {
            self.missing.take(sender, self.is_as_due(sender, back_ns), sender.missed);
        }
        let late_ns = back_ns.saturating_sub(sender.even.last_ns).saturating_sub(sender.even.gap_ns);
        let (least, most) = (late_ns.saturating_sub(sender.room_ns), late_ns.saturating_add(sender.room_ns));
        let both = (self.by_ns.0.max(least), self.by_ns.1.min(most));
        let fits = both.0 <= both.1 && late_ns / SHOWS_PART > sender.room_ns;
        if fits {
            self.by_ns = both;
        }
        self.later.take(sender, fits, false);
    }

    /// Whether a sender has come again when it would have come, had nothing happened.
    fn is_as_due(&self, sender: &Sender, back_ns: i64) -> bool {
        let Sender { even, room_ns, missed, .. } = *sender;
        let late_ns = back_ns.saturating_sub(even.last_ns).saturating_sub(even.gap_ns);
        if missed { self.in_phase(sender, back_ns) } else { late_ns.saturating_abs() <= room_ns }
    }

    /// Whether a sender of which frames were due in the silence has come in time behind it, and in its phase as far as
    /// that is known.
    fn in_phase(&self, sender: &Sender, back_ns: i64) -> bool {
        let Even { last_ns, gap_ns, off_ns, .. } = sender.even;
        let after_ns = back_ns.saturating_sub(last_ns);
        let periods = after_ns.saturating_add(gap_ns / 2) / gap_ns.max(1);
        let off = after_ns.saturating_sub(periods.saturating_mul(gap_ns)).saturating_abs();
        let room_ns = sender.room_ns.saturating_add(periods.saturating_mul(off_ns / 2 + gap_ns / PERIOD_PART));
        off <= room_ns && back_ns <= self.to_ns.saturating_add(gap_ns).saturating_add(sender.room_ns)
    }

    /// Senders that must have come again by `now`, and have not.
    fn overdue(&mut self, now: i64) {
        let silence_ns = self.to_ns.saturating_sub(self.from_ns);
        for sender in self.senders.iter().filter(|sender| sender.back_ns.is_none()) {
            let Sender { even, room_ns, missed, .. } = *sender;
            let due_ns = even.last_ns.saturating_add(even.gap_ns).saturating_add(room_ns);
            let again_ns = self.to_ns.saturating_add(even.gap_ns).saturating_add(room_ns);
            if now > if missed { again_ns } else { due_ns } {
                self.missing.take(sender, false, false);
            }
            if now > due_ns.saturating_add(silence_ns) {
                self.later.take(sender, false, false);
            }
        }
    }

    /// Whether no further frame tells more.
    fn is_over(&self, frame: &Frame, now: i64) -> bool {
        let waits = |sender: &Sender| {
            let longest_ns = self.to_ns.saturating_sub(self.from_ns).saturating_add(3 * sender.even.gap_ns);
            !sender.over && now <= self.to_ns.saturating_add(longest_ns)
        };
        let refuted = self.missing.refuted && self.later.refuted;
        refuted || frame.no > self.first + KEPT || !self.senders.iter().any(waits)
    }
}

/// The holes of a bus.
#[derive(Debug, Default)]
pub(super) struct Holes {
    doubt: Option<Doubt>,
    /// The numbers of the frames behind the last ones.
    found: Vec<u64>,
    /// Since when the recording is known to go on, in ns: from a frame before that nothing is known of when the next is due.
    since_ns: i64,
    /// Until when a live bus has said that it gave all that there was, in ns.
    given_ns: Option<i64>,
}

impl Holes {
    /// Whether a frame is the first one behind a hole.
    pub(super) fn is_behind(&self, number: u64) -> bool {
        !self.found.is_empty() && self.found.contains(&number)
    }

    /// The number of the first frame of which it is not known yet whether it is behind a hole.
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.doubt.as_ref().map(|doubt| doubt.first)
    }

    /// The recording begins, goes on where frames were lost, or its clock was set.
    pub(super) fn start(&mut self, now: i64) {
        *self = Self { found: std::mem::take(&mut self.found), since_ns: now, ..Self::default() };
    }

    /// No further frame tells.
    pub(super) fn settle(&mut self) {
        self.doubt = None;
    }

    /// It is `now_ns` on a live bus: nobody waits long for what comes.
    pub(super) fn advance(&mut self, now_ns: i64) {
        self.given_ns = Some(now_ns);
        if self.doubt.as_ref().is_some_and(|doubt| now_ns.saturating_sub(doubt.to_ns) > PATIENCE_NS) {
            self.settle();
        }
    }

    /// A frame has ended a silence (from, to in ns, and whether it is longer than those of late).
    /// `even`: the senders that come evenly. `resolution_ns`: the resolution of the stamps.
    pub(super) fn begin(
        &mut self,
        frame: &Frame,
        (from_ns, to_ns, unusual): (i64, i64, bool),
        even: impl Iterator<Item = Even>,
        resolution_ns: i64,
    ) {
        let given = self.given_ns.is_some_and(|given_ns| given_ns > from_ns);
        if given || self.doubt.is_some() || restarts(frame) {
            return;
        }
        let expected = |even: Even| {
            // Where such a silence is usual, a sender shows something by being off its time more than it is now and then.
            let odd_ns = if unusual { 0 } else { even.most_off_ns };
            let room_ns = even.off_ns.saturating_mul(4).max(OFF_NS).max(resolution_ns.saturating_mul(2)).max(odd_ns);
            let due_ns = even.last_ns.saturating_add(even.gap_ns).saturating_add(room_ns);
            let known = (self.since_ns..=from_ns).contains(&even.last_ns);
            let shows = known && room_ns <= even.gap_ns / SHOWS_PART && due_ns > from_ns;
            shows.then_some(Sender { even, room_ns, missed: due_ns < to_ns, back_ns: None, firm: false, over: false })
        };
        let senders: Vec<Sender> = even.filter_map(expected).collect();
        let independent = |of: &dyn Fn(&Sender) -> bool| {
            let nodes: BTreeSet<u8> = senders.iter().filter(|one| of(one)).map(|one| one.even.node).collect();
            nodes.len()
        };
        let missed = independent(&|sender| sender.missed);
        if missed > 0 && independent(&|_| true) >= SENDERS {
            let (missing, later) = (Guess { refuted: missed < SENDERS, ..Guess::default() }, Guess::default());
            let by_ns = (1, to_ns.saturating_sub(from_ns));
            self.doubt = Some(Doubt { first: frame.no, from_ns, to_ns, senders, missing, later, by_ns });
        }
    }

    /// The next frame, at `now`.
    pub(super) fn follow(&mut self, frame: &Frame, now: i64, stalls: &Stalls) {
        let Some(doubt) = &mut self.doubt else { return };
        let id = identifier(frame);
        if let Some(place) = doubt.senders.iter().position(|one| Some(one.even.id) == id) {
            doubt.heard(place, now, stalls.runs_since(doubt.from_ns));
        }
        doubt.overdue(now);
        let (sure, burst) = (doubt.missing.is_sure() || doubt.later.is_sure(), stalls.verdict_behind(doubt.from_ns));
        if burst == Some(Verdict::Confirmed) || restarts(frame) || doubt.is_over(frame, now) && !sure {
            self.doubt = None;
        } else if sure && burst != Some(Verdict::Open) {
            if self.found.len() == HOLES {
                self.found.remove(0);
            }
            self.found.push(doubt.first);
            self.since_ns = doubt.to_ns;
            self.doubt = None;
        }
    }
}

/// Whether a frame shows that nodes begin anew: an NMT command, or a boot-up.
fn restarts(frame: &Frame) -> bool {
    let id = identifier(frame).unwrap_or(usize::MAX);
    frame.kind == Kind::Data && (id == 0 || super::senders::ERROR_CONTROL.contains(&id) && frame.payload() == [0])
}
