//! Where the recorder stood still: silences of the whole bus behind which it lists what it kept.
//!
//! A recorder that stands still keeps frames in a buffer and stamps them all when it goes on. What it then lists is a
//! *burst*: after a silence of the whole bus frames come without a pause until the buffer is empty, and among them what
//! should have come during the silence. Until that has shown, the burst is open. A burst that is confirmed has no times of
//! its own: each frame may have been sent at any time since the silence began. One that is refuted was ordinary traffic.
//!
//! Four things show a burst ([`Signs::prove`]): senders that are late by different times, as no fault of one node makes
//! them; a CAN-ID that comes again too soon after a late or unusual one; frames closer to each other than they can be on a
//! bus; and, after an unusual silence, as many frames as should have come in it. At the beginning of a capture nothing is
//! known of its CAN-IDs: a burst in which one comes again waits for the frames behind it, which tell how often it comes.
//!
//! It must not know what a frame means.

use crate::frame::{Frame, Kind};

use super::duplicates::{Duplicates, PATIENCE_NS};
use super::senders::{Even, Late, Run, Seen, Senders};

/// A silence shorter than this is no stall, in ns: it moves no verdict.
pub(super) const SHORTEST_STALL_NS: i64 = 10_000_000;
/// Frames from a buffer follow each other within this time, in ns.
pub(super) const DRAIN_NS: i64 = 1_500_000;
/// By how much a silence must exceed the longest of late, in tenths, to be unusual.
pub(super) const UNUSUAL_TENTHS: i64 = 13;
/// The bit rate of the fastest bus, in ns a bit: no frame follows another in less than it takes itself.
const BIT_NS: i64 = 1_000;
/// The bits of a frame without data, without stuff bits.
const FRAME_BITS: i64 = 44;
/// Frames that were due at times further apart than this, and come at once, waited for the recorder, in ns.
const APART_NS: i64 = 3_000_000;
/// Frames behind a burst by which it has shown that it is one; where it has not, it is ordinary traffic.
const SHOWN: u32 = 256;
/// The same of a burst that still runs.
const KEPT: u32 = 4096;
/// Frames of a burst at the end of a capture, the least by which it is known how fast they come.
const DENSE: i64 = 8;
/// Bursts remembered.
const BURSTS: usize = 16;
/// A silence that is this many times the longest recent one may be the recorder's, whoever ends it.
const ODD: i64 = 4;

/// What became of a burst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// It still runs.
    #[default]
    Open,
    /// The recorder had stood still: its frames have no times of their own.
    Confirmed,
    /// Ordinary traffic after a silence.
    Refuted,
}

/// What the frames of a burst have shown.
#[derive(Clone, Copy, Debug, Default)]
struct Signs {
    /// Frames in it, and those that follow the one before too closely.
    frames: u32,
    close: u32,
    /// Those of its frames that came the least and the most late.
    late: Option<(Late, Late)>,
    /// A CAN-ID that comes evenly came again in it, in a small part of its usual gap; one of these had come late before;
    /// and one came again of which that is not known yet.
    compressed: bool,
    caught_up: bool,
    again: bool,
}

impl Signs {
    fn take(&mut self, seen: Seen, too_close: bool) {
        self.frames += 1;
        self.close += u32::from(too_close);
        if let Some(late) = seen.late.filter(|late| late.ns > late.room_ns) {
            let (least, most) = self.late.unwrap_or((late, late));
            let (least, most) =
                (if late.ns < least.ns { late } else { least }, if late.ns > most.ns { late } else { most });
            self.late = Some((least, most));
        }
        self.compressed |= seen.compressed;
        self.caught_up |= seen.caught_up;
        self.again |= seen.again;
    }

    /// Whether they prove that the recorder had stood still. `unusual`: the silence before was; `usual_frames`: as many
    /// would have come since it began.
    fn prove(&self, unusual: bool, usual_frames: i64) -> bool {
        let (frames, close) = (i64::from(self.frames), i64::from(self.close));
        let too_close = if unusual { close > 0 } else { close > 1 && close * 4 > (frames - 1) * 3 };
        let apart =
            |(least, most): (Late, Late)| most.ns.saturating_sub(least.ns) > least.room_ns.saturating_add(most.room_ns);
        let many = unusual && frames > 2 && frames * 10 >= usual_frames.saturating_mul(6);
        let squeezed = self.caught_up || self.compressed && (unusual || self.late.is_some());
        frames > 1 && (too_close || self.late.is_some_and(apart) || squeezed || many)
    }
}

/// Frames without a pause after a silence.
#[derive(Clone, Copy, Debug, Default)]
struct Burst {
    /// Its number, from 1, and that of its first frame.
    number: u32,
    first: u64,
    /// When the silence before it began and when it ended, and the time of the last frame, in ns.
    from_ns: i64,
    to_ns: i64,
    until_ns: i64,
    /// The silence was longer than those of late, or several senders were overdue in it.
    unusual: bool,
    signs: Signs,
    /// It has shown that it is one, unless the capture shows frames twice.
    shown: bool,
    /// Frames behind it, while it waits for what they tell.
    behind: u32,
    verdict: Verdict,
}

impl Burst {
    fn silence_ns(&self) -> i64 {
        self.to_ns.saturating_sub(self.from_ns)
    }

    /// Whether the buffer is likely empty by now: it fills no faster than it is emptied.
    fn is_emptied(&self) -> bool {
        self.signs.frames > SHOWN && self.until_ns.saturating_sub(self.to_ns) > self.silence_ns()
    }

    /// Whether its frames come far faster than those before the silence (`mean_ns` apart; 0: nothing is known of them).
    fn is_dense(&self, mean_ns: i64) -> bool {
        let frames = i64::from(self.signs.frames);
        let apart_ns = self.until_ns.saturating_sub(self.to_ns) / frames.max(1);
        self.unusual && frames > DENSE && (self.signs.again || mean_ns == 0 || apart_ns < mean_ns / 4)
    }
}

/// The silences of a bus, and what became of the bursts behind them.
#[derive(Debug, Default)]
pub(super) struct Stalls {
    senders: Senders,
    /// Mean gap between frames, in 64ths of ns.
    mean_gap_64: i64,
    /// The longest gap of late, in ns.
    usual_gap_ns: i64,
    /// Those that are open or confirmed, and the last one; and how many there were.
    bursts: Vec<Burst>,
    count: u32,
    /// The last burst still runs: no pause has come since it began.
    running: bool,
    /// Gaps, and those that are shorter than they can be on a bus. A burst that is no ordinary traffic counts as one: where
    /// each silence ends in such a gap, that is how this recording shows frames that come together.
    gaps: u64,
    close: u64,
}

impl Stalls {
    /// Takes a frame's time (the last one's, its own, and how long the bus was silent between them, in ns). `original`:
    /// it is no duplicate; what may be one shows nothing until that is decided. `close`: it follows the frame before in
    /// less time than it takes on the fastest bus, and stamps are fine enough to tell; and their resolution in ns, within
    /// which there is no silence.
    pub(super) fn follow(
        &mut self,
        frame: &Frame,
        (last, now, gap): (Option<i64>, i64, i64),
        original: bool,
        (close, exact, resolution_ns): (bool, bool, i64),
    ) {
        let Some(last) = last else {
            self.senders.see(frame, now, None, DRAIN_NS);
            return;
        };
        if gap > DRAIN_NS {
            self.end_burst();
        }
        if gap > SHORTEST_STALL_NS.max(resolution_ns.saturating_mul(2)) {
            let unusual = self.is_unusual(gap) || self.senders.overdue(last, now, APART_NS) > 1;
            self.begin_burst(Burst {
                from_ns: last,
                to_ns: now,
                until_ns: now,
                first: frame.no,
                unusual,
                ..Burst::default()
            });
        }
        let seen = self.senders.see(frame, now, self.run(), DRAIN_NS);
        let too_close = self.is_too_close(close, exact);
        self.compare_later(seen.tells_of);
        if seen.late.is_some_and(Late::is_on_time) && !too_close {
            // What waited was listed before it.
            self.end_burst();
        }
        if !self.bursts.last().is_some_and(|burst| self.running && burst.unusual) {
            self.know_gap(gap);
        }
        if self.running {
            self.take(seen, now, too_close, original);
        }
    }

    /// Takes a frame of the burst that runs.
    fn take(&mut self, seen: Seen, now: i64, too_close: bool, original: bool) {
        let mean_ns = self.mean_gap_64 / 64;
        let Some(burst) = self.bursts.last_mut() else { return };
        burst.until_ns = now;
        burst.signs.take(seen, too_close);
        if burst.verdict != Verdict::Open {
            self.running = !burst.is_emptied();
        } else if burst.signs.prove(burst.unusual, now.saturating_sub(burst.from_ns) / mean_ns.max(1)) {
            burst.shown = true;
            if original {
                burst.verdict = Verdict::Confirmed;
            }
        } else if burst.signs.frames > KEPT || burst.is_emptied() && !burst.signs.again {
            self.end_burst();
        }
    }

    fn run(&self) -> Option<Run> {
        let burst = self.bursts.last().filter(|_| self.running)?;
        Some(Run { number: burst.number, from_ns: burst.from_ns, to_ns: burst.to_ns, unusual: burst.unusual })
    }

    /// Whether a frame follows the one before too closely, where that is rare: it was kept in a buffer.
    fn is_too_close(&mut self, close: bool, exact: bool) -> bool {
        if !self.running {
            self.gaps += 1;
            self.close += u64::from(close);
        }
        close && exact && self.close * 16 <= self.gaps
    }

    /// Bursts that have ended and in which a CAN-ID of which little was known came again are decided by how often that
    /// one comes behind them.
    fn compare_later(&mut self, tells_of: u32) {
        if self.bursts.is_empty() {
            return;
        }
        let running = self.running();
        for burst in self.bursts.iter_mut().filter(|one| one.verdict == Verdict::Open && one.number != running) {
            burst.behind += 1;
            if burst.number == tells_of {
                burst.verdict = Verdict::Confirmed;
            } else if burst.behind > SHOWN {
                burst.verdict = Verdict::Refuted;
            }
        }
    }

    fn begin_burst(&mut self, burst: Burst) {
        self.count += 1;
        self.bursts.retain(|burst| burst.verdict != Verdict::Refuted);
        if self.bursts.len() == BURSTS {
            self.bursts.remove(0);
        }
        self.bursts.push(Burst { number: self.count, ..burst });
        self.running = true;
    }

    /// The frames after a silence have come to a pause: they were ordinary traffic unless they have shown otherwise, or
    /// will be compared with what comes behind them.
    pub(super) fn end_burst(&mut self) {
        if !std::mem::take(&mut self.running) {
            return;
        }
        let Some(burst) = self.bursts.last_mut() else { return };
        if burst.verdict != Verdict::Open || burst.shown || burst.signs.again {
            self.gaps += 1;
            self.close += u64::from(burst.signs.close > 0);
            return;
        }
        burst.verdict = Verdict::Refuted;
        self.gaps += u64::from(burst.signs.frames);
        self.close += u64::from(burst.signs.close);
        if burst.unusual {
            let silence_ns = burst.silence_ns();
            self.know_gap(silence_ns);
        }
    }

    /// Whether the capture shows frames twice is decided: so is what frames have shown that might have been duplicates.
    pub(super) fn decide_shown(&mut self, duplicates: &Duplicates) {
        if duplicates.undecided_since().is_some() {
            return;
        }
        let twice = duplicates.are_proven();
        for burst in self.bursts.iter_mut().filter(|burst| burst.verdict == Verdict::Open && burst.shown) {
            burst.verdict = if twice { Verdict::Refuted } else { Verdict::Confirmed };
        }
    }

    /// No further frame tells: what is open is decided by what was seen. All that came since the silence may have come
    /// from the buffer.
    pub(super) fn settle(&mut self, duplicates: &Duplicates) {
        let mean_ns = self.mean_gap_64 / 64;
        for burst in self.bursts.iter_mut().filter(|burst| burst.verdict == Verdict::Open) {
            let last = burst.behind < burst.signs.frames && burst.is_dense(mean_ns);
            burst.shown |= last || self.senders.likely_tell_of(burst.number, DRAIN_NS);
        }
        self.end_burst();
        self.decide_shown(duplicates);
        self.refute();
    }

    /// It is `now_ns` on a live bus, and the last frame came at `last_ns`.
    pub(super) fn advance(&mut self, last_ns: Option<i64>, now_ns: i64, duplicates: &Duplicates) {
        if last_ns.is_some_and(|last| now_ns.saturating_sub(last) > DRAIN_NS) {
            self.end_burst();
        }
        self.decide_shown(duplicates);
        // Nobody who watches a live bus waits long for what comes behind a burst.
        let open = self.bursts.iter().find(|burst| burst.verdict == Verdict::Open);
        if open.is_some_and(|burst| now_ns.saturating_sub(burst.to_ns) > PATIENCE_NS) {
            self.end_burst();
            self.refute();
        }
    }

    /// The number of the first frame of which it is not known yet whether it is in a burst.
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.bursts.iter().find(|burst| burst.verdict == Verdict::Open).map(|burst| burst.first)
    }

    /// The number of the burst that runs; 0: none.
    pub(super) fn running(&self) -> u32 {
        self.bursts.last().filter(|_| self.running).map_or(0, |burst| burst.number)
    }

    /// What became of a burst; `None` where it is none, or forgotten: then it was settled long ago.
    pub(super) fn verdict(&self, burst: u32) -> Option<Verdict> {
        self.burst(burst).map(|burst| burst.verdict)
    }

    /// Whether a frame is the first of a burst that is confirmed.
    pub(super) fn is_first_of_confirmed(&self, burst: u32, number: u64) -> bool {
        self.confirmed(burst).is_some_and(|burst| burst.first == number)
    }

    /// Whether a time may be that of a frame which is too close to a burst that is confirmed, by less than `near_ns`: equal
    /// frames of both are no duplicates.
    pub(super) fn is_near_confirmed(&self, at_ns: i64, near_ns: i64) -> bool {
        let mut confirmed = self.bursts.iter().filter(|burst| burst.verdict == Verdict::Confirmed);
        confirmed.any(|burst| (burst.to_ns..burst.until_ns.saturating_add(near_ns)).contains(&at_ns))
    }

    /// When the silence began before a burst that is confirmed, in ns.
    pub(super) fn since_ns(&self, burst: u32) -> Option<i64> {
        self.confirmed(burst).map(|burst| burst.from_ns)
    }

    /// The last silence that was the recorder's: when it began and when it ended, in ns.
    pub(super) fn last_stall(&self) -> Option<(i64, i64)> {
        let burst = self.bursts.iter().rev().find(|burst| burst.verdict == Verdict::Confirmed)?;
        Some((burst.from_ns, burst.to_ns))
    }

    /// Whether frames have come without a pause since the silence that began then.
    pub(super) fn runs_since(&self, from_ns: i64) -> bool {
        self.run().is_some_and(|run| run.from_ns == from_ns)
    }

    /// What became of the burst behind the silence that began then; `None` where there is none any more.
    pub(super) fn verdict_behind(&self, from_ns: i64) -> Option<Verdict> {
        self.bursts.iter().rev().find(|burst| burst.from_ns == from_ns).map(|burst| burst.verdict)
    }

    /// The CAN-IDs that come by themselves and evenly.
    pub(super) fn even(&self) -> impl Iterator<Item = Even> {
        self.senders.even()
    }

    /// The nodes, one bit each, of which a frame was expected during a silence, `tenths` of its usual gap after the last;
    /// none where such silences are usual.
    pub(super) fn missing(&self, from: i64, to: i64, tenths: i64) -> u128 {
        if self.is_unusual(to.saturating_sub(from)) { self.senders.missing(from, to, tenths) } else { 0 }
    }

    /// Whether a silence exceeds the longest of late several times.
    pub(super) fn is_odd(&self, silence_ns: i64) -> bool {
        self.usual_gap_ns > 0 && silence_ns / ODD > self.usual_gap_ns
    }

    /// Whether a silence is longer than those of late.
    pub(super) fn is_unusual(&self, gap: i64) -> bool {
        gap > SHORTEST_STALL_NS && gap / UNUSUAL_TENTHS > self.usual_gap_ns / 10
    }

    fn confirmed(&self, number: u32) -> Option<&Burst> {
        self.burst(number).filter(|burst| burst.verdict == Verdict::Confirmed)
    }

    fn burst(&self, number: u32) -> Option<&Burst> {
        if number == 0 { None } else { self.bursts.iter().rev().find(|burst| burst.number == number) }
    }

    /// Bursts that are still open were ordinary traffic.
    fn refute(&mut self) {
        for burst in self.bursts.iter_mut().filter(|burst| burst.verdict == Verdict::Open) {
            burst.verdict = Verdict::Refuted;
        }
    }

    /// Takes an ordinary gap between frames.
    fn know_gap(&mut self, gap: i64) {
        let gap = gap.min(i64::MAX / 128);
        self.usual_gap_ns = (self.usual_gap_ns - self.usual_gap_ns / 256).max(gap);
        self.mean_gap_64 += if self.mean_gap_64 == 0 { gap * 64 } else { gap - self.mean_gap_64 / 64 };
    }
}

/// How long a frame takes at least, in ns: on the fastest bus, without stuff bits.
pub(super) fn wire_ns(frame: &Frame) -> i64 {
    match frame.kind {
        Kind::Data => (FRAME_BITS + 8 * i64::from(frame.len)) * BIT_NS,
        _ => FRAME_BITS * BIT_NS,
    }
}
