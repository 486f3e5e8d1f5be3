//! Unannounced holes of a recording: frames of some time are missing, or its clock was set forward.
//!
//! The whole bus is silent, and then several independent senders with even gaps continue as if nothing had happened:
//! either each comes a whole number of its periods after its last frame, so that frames are missing, or all are late by
//! the same time, so that the clock was set forward. No fault of one node does that. A sender that does not come back
//! or restarts has fallen silent itself; frames late by different times were delayed by the recorder
//! ([`Stalls`](super::stalls::Stalls)).
//!
//! A counter of SYNC shows it, too: where it goes on by as many SYNCs as were due in a silence in which more than the
//! SYNCs is missing, they were sent, and the recording lacks them with all others. Frames that answer SYNC are missing
//! with it; so the silence has to be longer than is usual between those that do not.

use std::collections::BTreeSet;

use crate::bytes::frame::{Frame, Kind};
use crate::bytes::ns::Ns;
use crate::wire::error_frame::{BUS_ERROR, PROTOCOL};

use super::duplicates::PATIENCE_NS;
use super::senders::{CountedSync, Even, SYNC, identifier};
use super::stalls::{Stalls, Verdict};

/// Minimum deviation of an even sender from its due time, in ns, and the part of its period up to which it may deviate
/// and still be evidence.
const OFF_NS: Ns = Ns::from_ms(1);
const SHOWS_PART: i64 = 8;
/// Uncertainty of a sender's period, as a part of it; several periods add up.
const PERIOD_PART: i64 = 1024;
/// Maximum number of frames that wait until a silence is known to be a hole or not.
const KEPT: u64 = 16_384;
/// Number of independent senders that prove a hole.
const SENDERS: usize = 2;
/// Maximum number of remembered holes.
const HOLES: usize = 16;

/// A sender with a frame due when the bus fell silent.
#[derive(Clone, Copy, Debug)]
struct Sender {
    even: Even,
    /// Possible deviation from its due time, in ns.
    room_ns: Ns,
    /// True if a frame was due during the silence.
    missed: bool,
    /// Time of its return, in ns.
    back_ns: Option<Ns>,
    /// True if it sent its first frame at that time. Frames right after a silence may have been delayed by the
    /// recorder, unless the sender keeps its period from there on.
    firm: bool,
    /// True once it has come twice and gives no further evidence.
    over: bool,
}

/// One explanation of a silence.
#[derive(Clone, Debug, Default)]
struct Guess {
    /// Nodes that support it.
    shown: BTreeSet<u8>,
    /// True if error control contradicts it.
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
struct HoleDoubt {
    /// The number of the first frame after it.
    first: u64,
    from_ns: Ns,
    to_ns: Ns,
    senders: Vec<Sender>,
    /// SYNC with a counter until its first one after the silence, if frames of others were due, too; and true if that
    /// one has counted those in between.
    counted: Option<CountedSync>,
    counts: bool,
    /// Frames are missing, or the clock was set forward by a time within `by_ns`, in ns.
    missing: Guess,
    later: Guess,
    by_ns: (Ns, Ns),
}

impl HoleDoubt {
    /// Follows a frame of a sender at `now`. `in_row`: no pause has come since the silence.
    fn heard(&mut self, place: usize, now: Ns, in_row: bool) {
        let Some(slot) = self.senders.get_mut(place).filter(|sender| !sender.over) else { return };
        let before = *slot;
        let Some(back_ns) = before.back_ns else {
            // Of delayed frames, all those due in a longer time would have come at once.
            let late_ns = now - slot.even.last_ns - slot.even.gap_ns;
            let waited = in_row && late_ns <= slot.even.gap_ns + slot.room_ns;
            (slot.back_ns, slot.firm) = (Some(now), !waited);
            let sender = *slot;
            return self.back(&sender, now);
        };
        let after_ns = now - back_ns;
        let goes_on = (after_ns - before.even.gap_ns).abs() <= before.room_ns;
        (slot.over, slot.firm) = (true, slot.firm || goes_on);
        let sender = *slot;
        if !before.firm {
            self.missing.take(&sender, goes_on && self.is_as_due(&sender, back_ns), sender.missed);
        }
        // A clock that was set forward stays so; a sender that was late once is back in time.
        self.later.take(&sender, goes_on, true);
    }

    /// Adds the evidence of a sender's first frame after the silence.
    fn back(&mut self, sender: &Sender, back_ns: Ns) {
        if sender.firm {
            self.missing.take(sender, self.is_as_due(sender, back_ns), sender.missed);
        }
        let late_ns = back_ns - sender.even.last_ns - sender.even.gap_ns;
        let (least, most) = (late_ns - sender.room_ns, late_ns + sender.room_ns);
        let both = (self.by_ns.0.max(least), self.by_ns.1.min(most));
        let fits = both.0 <= both.1 && late_ns / SHOWS_PART > sender.room_ns;
        if fits {
            self.by_ns = both;
        }
        self.later.take(sender, fits, false);
    }

    /// Returns true if a sender came back when it was due as if nothing had happened.
    fn is_as_due(&self, sender: &Sender, back_ns: Ns) -> bool {
        let Sender { even, room_ns, missed, .. } = *sender;
        let late_ns = back_ns - even.last_ns - even.gap_ns;
        if missed { self.in_phase(sender, back_ns) } else { late_ns.abs() <= room_ns }
    }

    /// Returns true if a sender with frames due in the silence came back in time after it, and in its phase as far as
    /// that is known.
    fn in_phase(&self, sender: &Sender, back_ns: Ns) -> bool {
        let Even { last_ns, gap_ns, off_ns, .. } = sender.even;
        let after_ns = back_ns - last_ns;
        let periods = (after_ns + gap_ns / 2) / gap_ns.max(Ns(1));
        let off = (after_ns - periods * gap_ns).abs();
        let room_ns = sender.room_ns + periods * (off_ns / 2 + gap_ns / PERIOD_PART);
        off <= room_ns && back_ns <= self.to_ns + gap_ns + sender.room_ns
    }

    /// Counts senders that are overdue at `now` as evidence against missing frames.
    fn overdue(&mut self, now: Ns) {
        let silence_ns = self.to_ns - self.from_ns;
        for sender in self.senders.iter().filter(|sender| sender.back_ns.is_none()) {
            let Sender { even, room_ns, missed, .. } = *sender;
            let due_ns = even.last_ns + even.gap_ns + room_ns;
            let again_ns = self.to_ns + even.gap_ns + room_ns;
            if now > if missed { again_ns } else { due_ns } {
                self.missing.take(sender, false, false);
            }
            if now > due_ns + silence_ns {
                self.later.take(sender, false, false);
            }
        }
    }

    /// Returns true if further frames give no more evidence.
    fn is_over(&self, frame: &Frame, now: Ns) -> bool {
        let waits = |sender: &Sender| {
            let longest_ns = self.to_ns - self.from_ns + 3 * sender.even.gap_ns;
            !sender.over && now <= self.to_ns + longest_ns
        };
        let refuted = self.missing.refuted && self.later.refuted && self.counted.is_none();
        refuted || frame.no > self.first + KEPT || !self.senders.iter().any(waits)
    }
}

/// The holes of a bus.
#[derive(Debug, Default)]
pub(super) struct Holes {
    doubt: Option<HoleDoubt>,
    /// The numbers of the first frames after the last ones.
    found: Vec<u64>,
    /// Time since which the recording is known to be continuous, in ns; a frame before it does not show when the next
    /// one is due.
    since_ns: Ns,
    /// Time until which a live bus has reported all its frames, in ns.
    given_ns: Option<Ns>,
    /// Time of the last error frame with an error of the bus: a silence that begins with one is that of a disturbed bus.
    error_ns: Option<Ns>,
}

impl Holes {
    /// Returns true if a frame is the first one after a hole.
    pub(super) fn is_behind(&self, number: u64) -> bool {
        !self.found.is_empty() && self.found.contains(&number)
    }

    /// Returns the number of the first frame that may be after a hole not decided yet.
    #[inline]
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.doubt.as_ref().map(|doubt| doubt.first)
    }

    /// Starts anew: at the beginning of the recording, after lost frames, or after a step of its clock.
    pub(super) fn start(&mut self, now: Ns) {
        *self = Self { found: std::mem::take(&mut self.found), since_ns: now, ..Self::default() };
    }

    /// Ends the doubt, since no further frames follow.
    pub(super) fn settle(&mut self) {
        self.doubt = None;
    }

    /// Advances a live bus to `now_ns`; later frames are awaited only for a short time.
    pub(super) fn advance(&mut self, now_ns: Ns) {
        self.given_ns = Some(now_ns);
        if self.doubt.as_ref().is_some_and(|doubt| now_ns - doubt.to_ns > PATIENCE_NS) {
            self.settle();
        }
    }

    /// Examines a frame that ended a silence (its beginning and end in ns, and true if it is longer than recent ones).
    /// `stalls`: what is known of the senders before it. `resolution_ns`: the resolution of the stamps.
    pub(super) fn begin(
        &mut self,
        frame: &Frame,
        (from_ns, to_ns, unusual): (Ns, Ns, bool),
        stalls: &Stalls,
        resolution_ns: Ns,
    ) {
        let given = self.given_ns.is_some_and(|given_ns| given_ns > from_ns);
        if given || self.doubt.is_some() || restarts(frame) || self.error_ns == Some(from_ns) {
            return;
        }
        let expected = |even: Even| {
            // If such a silence is usual, a sender is evidence only by a deviation that exceeds its usual ones.
            let odd_ns = if unusual { Ns::ZERO } else { even.most_off_ns };
            let room_ns = (even.off_ns * 4).max(OFF_NS).max(resolution_ns * 2).max(odd_ns);
            let due_ns = even.last_ns + even.gap_ns + room_ns;
            let known = (self.since_ns..=from_ns).contains(&even.last_ns);
            let shows = known && room_ns <= even.gap_ns / SHOWS_PART && due_ns > from_ns;
            shows.then_some(Sender { even, room_ns, missed: due_ns < to_ns, back_ns: None, firm: false, over: false })
        };
        let senders: Vec<Sender> = stalls.even().filter_map(expected).collect();
        let independent = |of: &dyn Fn(&Sender) -> bool| {
            let nodes: BTreeSet<u8> = senders.iter().filter(|one| of(one)).map(|one| one.even.node).collect();
            nodes.len()
        };
        let missed = independent(&|sender| sender.missed);
        let others = senders.iter().any(|sender| sender.missed && sender.even.id != SYNC);
        let counted = stalls.counted_sync(from_ns, to_ns).filter(|_| others);
        if counted.is_some() || missed > 0 && independent(&|_| true) >= SENDERS {
            let (missing, later) = (Guess { refuted: missed < SENDERS, ..Guess::default() }, Guess::default());
            let by_ns = (Ns(1), to_ns - from_ns);
            let first = frame.no;
            self.doubt =
                Some(HoleDoubt { first, from_ns, to_ns, senders, counted, counts: false, missing, later, by_ns });
        }
    }

    /// Follows the next frame, at `now`.
    pub(super) fn follow(&mut self, frame: &Frame, now: Ns, stalls: &Stalls) {
        if frame.kind == Kind::Error && frame.id.raw() & (PROTOCOL | BUS_ERROR) != 0 {
            self.error_ns = Some(now);
        }
        let Some(doubt) = &mut self.doubt else { return };
        let id = identifier(frame);
        if let Some(place) = doubt.senders.iter().position(|one| Some(one.even.id) == id) {
            doubt.heard(place, now, stalls.runs_since(doubt.from_ns));
        }
        if id == Some(SYNC) {
            doubt.counts |= doubt.counted.take().is_some_and(|counted| counted.goes_on(frame, now));
        }
        doubt.overdue(now);
        let sure = doubt.missing.is_sure() || doubt.later.is_sure();
        let burst = stalls.verdict_behind(doubt.from_ns);
        // The recorder that only stood still lists the SYNCs that were due.
        let listed = burst == Some(Verdict::Confirmed) && doubt.counted.is_none();
        if !doubt.counts && (listed || restarts(frame) || doubt.is_over(frame, now) && !sure) {
            self.doubt = None;
        } else if doubt.counts || sure && !matches!(burst, Some(Verdict::Open | Verdict::Confirmed)) {
            if self.found.len() == HOLES {
                self.found.remove(0);
            }
            self.found.push(doubt.first);
            self.since_ns = doubt.to_ns;
            self.doubt = None;
        }
    }
}

/// Returns true if a frame shows that nodes restart: an NMT command or a boot-up.
fn restarts(frame: &Frame) -> bool {
    let id = identifier(frame).unwrap_or(usize::MAX);
    frame.kind == Kind::Data && (id == 0 || super::senders::ERROR_CONTROL.contains(&id) && frame.payload() == [0])
}
