//! Stalls of the recorder: silences of the whole bus after which it stamps the frames that it has buffered.
//!
//! A stalled recorder buffers frames and stamps them all when it resumes. This gives a *burst*: after a silence of the
//! whole bus, frames follow without a pause until the buffer is empty, among them those due during the silence. A burst
//! is open until it has been proven or refuted. The frames of a confirmed burst have no times of their own: each may
//! have been sent at any time since the silence began. A refuted burst was ordinary traffic.
//!
//! Four signs prove a burst ([`Signs::prove`]): senders that are late by different times, which no fault of one node
//! explains; a CAN-ID that repeats too soon after a late or unusual frame; frames closer together than a bus can carry
//! them; and, after an unusual silence, as many frames as were due in it. A PDO that answers SYNC with its usual delay
//! is no further sender: it comes late, and in a row with others, because SYNC does. At the beginning of a capture no CAN-ID is
//! known: a burst in which one repeats waits for the frames after it, which show the usual gap.

use crate::bytes::frame::{Frame, Kind};
use crate::bytes::ns::Ns;

use super::duplicates::{Duplicates, PATIENCE_NS, Sighting};
use super::senders::{CountedSync, Even, Late, Missed, Run, SenderEvidence, Senders, UNUSUAL_TENTHS};

/// Minimum length of a stall, in ns; shorter silences change no verdict.
pub(super) const SHORTEST_STALL_NS: Ns = Ns::from_ms(10);
/// Maximum gap between frames from a buffer, in ns.
pub(super) const DRAIN_NS: Ns = Ns::from_us(1_500);
/// Duration of a bit on the fastest bus, in ns; no frame follows another in less time than it takes to send.
const BIT_NS: Ns = Ns::from_us(1);
/// Length of a frame without data in bits, without stuff bits.
const FRAME_BITS: i64 = 44;
/// Minimum time that a frame without data takes, in ns.
pub const FRAME_NS: Ns = Ns(FRAME_BITS * BIT_NS.as_ns());
/// Minimum distance of the due times of frames that arrive together because the recorder buffered them, in ns.
const APART_NS: Ns = Ns::from_ms(3);
/// Number of frames after a burst within which it has to be proven; otherwise it is ordinary traffic.
const SHOWN: u32 = 256;
/// The same limit for a burst that is still running.
const KEPT: u32 = 4096;
/// Minimum number of frames in a burst at the end of a capture from which its rate is known.
const DENSE: i64 = 8;
/// Maximum number of remembered bursts.
const BURSTS: usize = 16;
/// Minimum ratio to the longest recent silence from which a silence may be the recorder's, whichever node ends it.
const ODD: i64 = 4;

/// The verdict on a burst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// Not decided yet.
    #[default]
    Open,
    /// A stall of the recorder: the frames have no times of their own.
    Confirmed,
    /// Ordinary traffic after a silence.
    Refuted,
}

/// The signs that the frames of a burst have given.
#[derive(Clone, Copy, Debug, Default)]
struct Signs {
    /// Number of its frames, and of those that follow the previous one too closely.
    frames: u32,
    close: u32,
    /// The same without those that answer SYNC.
    alone: u32,
    close_alone: u32,
    /// The least and the most late of its frames.
    late: Option<(Late, Late)>,
    /// A CAN-ID with even gaps repeated after a small part of its usual gap; such a CAN-ID had come late before; a
    /// CAN-ID with a gap still unknown repeated.
    compressed: bool,
    caught_up: bool,
    again: bool,
}

impl Signs {
    fn take(&mut self, seen: &SenderEvidence, too_close: bool) {
        self.frames += 1;
        self.close += u32::from(too_close);
        self.alone += u32::from(!seen.answers);
        self.close_alone += u32::from(too_close && !seen.answers);
        if let Some(late) = seen.late.filter(|late| late.ns > late.room_ns && !seen.answers) {
            let (least, most) = self.late.unwrap_or((late, late));
            let (least, most) =
                (if late.ns < least.ns { late } else { least }, if late.ns > most.ns { late } else { most });
            self.late = Some((least, most));
        }
        self.compressed |= seen.compressed;
        self.caught_up |= seen.caught_up;
        self.again |= seen.again;
    }

    /// Returns true if the signs prove a stall. `unusual`: the preceding silence was unusual; `usual_frames`: the
    /// number of frames usually sent in it, those that answer SYNC apart.
    fn prove(&self, unusual: bool, usual_frames: i64) -> bool {
        let (frames, close) = (i64::from(self.frames), i64::from(self.close));
        let too_close = unusual && self.close_alone > 0 || close > 1 && close * 4 > (frames - 1) * 3;
        let apart = |(least, most): (Late, Late)| most.ns - least.ns > least.room_ns + most.room_ns;
        let alone = i64::from(self.alone);
        let many = unusual && alone > 2 && alone * 10 >= usual_frames.saturating_mul(6);
        let squeezed = self.caught_up || self.compressed && (unusual || self.late.is_some());
        frames > 1 && (too_close || self.late.is_some_and(apart) || squeezed || many)
    }
}

/// A run of frames without a pause after a silence.
#[derive(Clone, Copy, Debug, Default)]
struct Burst {
    /// Its number, from 1, and the number of its first frame.
    number: u32,
    first: u64,
    /// Beginning and end of the preceding silence, and the time of the last frame, in ns.
    from_ns: Ns,
    to_ns: Ns,
    until_ns: Ns,
    /// True if the silence was longer than recent ones, or several senders were overdue in it.
    unusual: bool,
    /// Number of frames that usually answer SYNC in such a silence.
    usual_answers: i64,
    signs: Signs,
    /// True if the signs prove a stall, unless the capture turns out to show frames twice.
    shown: bool,
    /// Number of frames after it, while it waits for their evidence.
    behind: u32,
    verdict: Verdict,
}

impl Burst {
    fn silence_ns(&self) -> Ns {
        self.to_ns - self.from_ns
    }

    /// Returns true if the buffer is probably empty: it fills no faster than it is emptied.
    fn is_emptied(&self) -> bool {
        self.signs.frames > SHOWN && self.until_ns - self.to_ns > self.silence_ns()
    }

    /// Returns true if its frames come far faster than those before the silence (`mean_ns` apart; 0 if unknown).
    fn is_dense(&self, mean_ns: Ns) -> bool {
        let frames = i64::from(self.signs.frames);
        let apart_ns = (self.until_ns - self.to_ns) / frames.max(1);
        self.unusual && frames > DENSE && (self.signs.again || mean_ns == Ns::ZERO || apart_ns < mean_ns / 4)
    }
}

/// The silences of a bus and the bursts after them.
#[derive(Debug, Default)]
pub(super) struct Stalls {
    senders: Senders,
    /// Mean gap between frames, in 64ths of ns.
    mean_gap_64: Ns,
    /// The longest recent gap, in ns.
    usual_gap_ns: Ns,
    /// Open and confirmed bursts and the last one; and the number of all bursts so far.
    bursts: Vec<Burst>,
    count: u32,
    /// True while no pause has come since the last burst began.
    running: bool,
    /// Number of gaps, and of those shorter than possible on a bus. A burst that is ordinary traffic counts as one gap:
    /// if each silence ends in such a gap, this recording shows simultaneous frames in that way.
    gaps: u64,
    close: u64,
}

impl Stalls {
    /// Follows a frame by its times: that of the previous frame, its own, and the silence of the bus between them, in
    /// ns. Possible duplicates show nothing until they are decided, and known ones nothing at all. `close`: it follows
    /// the previous frame in less time than it takes on the fastest bus; `exact`: the stamps are fine enough to show
    /// that; the last value is the resolution of the stamps in ns, within which there is no silence. Returns the frames
    /// of its sender that are missing before it.
    pub(super) fn follow(
        &mut self,
        frame: &Frame,
        (last, now, gap): (Option<Ns>, Ns, Ns),
        sighting: Sighting,
        (close, exact, resolution_ns): (bool, bool, Ns),
    ) -> Option<Box<Missed>> {
        let Some(last) = last else {
            self.senders.see(frame, now, None, DRAIN_NS);
            return None;
        };
        if gap > DRAIN_NS {
            self.end_burst();
        }
        if gap > SHORTEST_STALL_NS.max(resolution_ns * 2) {
            let unusual = self.is_unusual(gap) || self.senders.overdue(last, now, APART_NS) > 1;
            self.begin_burst(Burst {
                from_ns: last,
                to_ns: now,
                until_ns: now,
                first: frame.no,
                unusual,
                usual_answers: if unusual { self.senders.usual_answers(gap) } else { 0 },
                ..Burst::default()
            });
        }
        let seen = match sighting {
            Sighting::Duplicate => SenderEvidence::default(),
            _ => self.senders.see(frame, now, self.run(), DRAIN_NS),
        };
        let too_close = self.is_too_close(close, exact);
        self.compare_later(seen.tells_of);
        if seen.late.is_some_and(Late::is_on_time) && !too_close {
            // Waiting frames were listed before it.
            self.end_burst();
        }
        if !self.bursts.last().is_some_and(|burst| self.running && burst.unusual) {
            self.know_gap(gap);
        }
        if self.running {
            self.take(&seen, now, too_close, sighting == Sighting::Original);
        }
        seen.missed
    }

    /// Follows a frame at `now` as [`Self::follow`] does if no burst is open ([`Self::are_over`]) and the gap before it
    /// begins none.
    #[inline]
    pub(super) fn follow_ordinary(
        &mut self,
        frame: &Frame,
        (now, gap): (Ns, Ns),
        (close, exact): (bool, bool),
    ) -> Option<Box<Missed>> {
        let missed = self.senders.see_alone(frame, now, DRAIN_NS);
        self.is_too_close(close, exact);
        self.know_gap(gap);
        missed
    }

    /// Returns true if no burst runs and none is open.
    #[inline]
    pub(super) fn are_over(&self) -> bool {
        !self.running && self.undecided_since().is_none()
    }

    /// Adds a frame to the running burst.
    fn take(&mut self, seen: &SenderEvidence, now: Ns, too_close: bool, original: bool) {
        let mean_ns = self.mean_gap_64 / 64;
        let Some(burst) = self.bursts.last_mut() else { return };
        burst.until_ns = now;
        let usual_frames = ((now - burst.from_ns) / mean_ns.max(Ns(1))).saturating_sub(burst.usual_answers);
        burst.signs.take(seen, too_close);
        if burst.verdict != Verdict::Open {
            self.running = !burst.is_emptied();
        } else if burst.signs.prove(burst.unusual, usual_frames) {
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

    /// Returns true if a frame follows the previous one too closely in a recording where that is rare, so that it was
    /// buffered.
    fn is_too_close(&mut self, close: bool, exact: bool) -> bool {
        if !self.running {
            self.gaps += 1;
            self.close += u64::from(close);
        }
        close && exact && self.close * 16 <= self.gaps
    }

    /// Decides finished bursts in which a little-known CAN-ID repeated, by the gaps of that CAN-ID after them.
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

    /// Ends the running burst at a pause. It was ordinary traffic, unless it is proven or waits for comparison with
    /// later frames.
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

    /// Decides the bursts whose signs may have come from duplicates, once it is known whether the capture shows frames
    /// twice.
    pub(super) fn decide_shown(&mut self, duplicates: &Duplicates) {
        if !duplicates.is_decided() {
            return;
        }
        let twice = duplicates.are_proven();
        for burst in self.bursts.iter_mut().filter(|burst| burst.verdict == Verdict::Open && burst.shown) {
            burst.verdict = if twice { Verdict::Refuted } else { Verdict::Confirmed };
        }
    }

    /// Decides open bursts by the evidence so far, since no further frames follow. All frames since the silence may
    /// have come from the buffer.
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

    /// Advances a live bus to `now_ns`; its last frame came at `last_ns`.
    pub(super) fn advance(&mut self, last_ns: Option<Ns>, now_ns: Ns, duplicates: &Duplicates) {
        if last_ns.is_some_and(|last| now_ns - last > DRAIN_NS) {
            self.end_burst();
        }
        self.decide_shown(duplicates);
        // On a live bus, later frames are awaited only for a short time.
        let open = self.bursts.iter().find(|burst| burst.verdict == Verdict::Open);
        if open.is_some_and(|burst| now_ns - burst.to_ns > PATIENCE_NS) {
            self.end_burst();
            self.refute();
        }
    }

    /// Returns the number of the first frame that may be in a burst not decided yet.
    #[inline]
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.bursts.iter().find(|burst| burst.verdict == Verdict::Open).map(|burst| burst.first)
    }

    /// Returns the number of the running burst, or 0.
    pub(super) fn running(&self) -> u32 {
        self.bursts.last().filter(|_| self.running).map_or(0, |burst| burst.number)
    }

    /// Returns the verdict on a burst; `None` for none, or for one forgotten after its verdict.
    pub(super) fn verdict(&self, burst: u32) -> Option<Verdict> {
        self.burst(burst).map(|burst| burst.verdict)
    }

    /// Returns true if a frame is the first of a confirmed burst.
    pub(super) fn is_first_of_confirmed(&self, burst: u32, number: u64) -> bool {
        self.confirmed(burst).is_some_and(|burst| burst.first == number)
    }

    /// Returns true if a frame at this time may be in a confirmed burst, or less than `near_ns` after it: there, equal
    /// frames are not duplicates.
    pub(super) fn is_near_confirmed(&self, at_ns: Ns, near_ns: Ns) -> bool {
        let mut confirmed = self.bursts.iter().filter(|burst| burst.verdict == Verdict::Confirmed);
        confirmed.any(|burst| (burst.to_ns..burst.until_ns + near_ns).contains(&at_ns))
    }

    /// Returns the beginning of the silence before a confirmed burst, in ns.
    pub(super) fn since_ns(&self, burst: u32) -> Option<Ns> {
        self.confirmed(burst).map(|burst| burst.from_ns)
    }

    /// Returns the beginning and the end of the last stall of the recorder, in ns.
    pub(super) fn last_stall(&self) -> Option<(Ns, Ns)> {
        let burst = self.bursts.iter().rev().find(|burst| burst.verdict == Verdict::Confirmed)?;
        Some((burst.from_ns, burst.to_ns))
    }

    /// Returns true if frames have come without a pause since the silence that began at `from_ns`.
    pub(super) fn runs_since(&self, from_ns: Ns) -> bool {
        self.run().is_some_and(|run| run.from_ns == from_ns)
    }

    /// Returns the verdict on the burst after the silence that began at `from_ns`; `None` if there is none any more.
    pub(super) fn verdict_behind(&self, from_ns: Ns) -> Option<Verdict> {
        self.bursts.iter().rev().find(|burst| burst.from_ns == from_ns).map(|burst| burst.verdict)
    }

    /// Iterates over the CAN-IDs that are sent on their own with even gaps.
    pub(super) fn even(&self) -> impl Iterator<Item = Even> {
        self.senders.even()
    }

    /// Returns SYNC if it has a counter and was due in a silence that is longer than recent ones without it.
    pub(super) fn counted_sync(&self, from: Ns, to: Ns) -> Option<CountedSync> {
        self.senders.counted_sync(from, to)
    }

    /// Returns the nodes, one bit each, with a frame due in a silence, `tenths` of its usual gap after the previous
    /// one; none if such silences are usual.
    pub(super) fn missing(&self, from: Ns, to: Ns, tenths: i64) -> u128 {
        if self.is_unusual(to - from) { self.senders.missing(from, to, tenths) } else { 0 }
    }

    /// Returns true if in a silence longer than recent ones a sender that does not depend on SYNC was due for two periods.
    pub(super) fn others_missed(&self, from: Ns, to: Ns) -> bool {
        self.is_unusual(to - from) && self.senders.others_missed(from, to)
    }

    /// Returns true if a silence exceeds the longest recent one several times.
    pub(super) fn is_odd(&self, silence_ns: Ns) -> bool {
        self.usual_gap_ns > Ns::ZERO && silence_ns / ODD > self.usual_gap_ns
    }

    /// Returns true if a silence is longer than recent ones.
    pub(super) fn is_unusual(&self, gap: Ns) -> bool {
        gap > SHORTEST_STALL_NS && gap / UNUSUAL_TENTHS > self.usual_gap_ns / 10
    }

    fn confirmed(&self, number: u32) -> Option<&Burst> {
        self.burst(number).filter(|burst| burst.verdict == Verdict::Confirmed)
    }

    fn burst(&self, number: u32) -> Option<&Burst> {
        if number == 0 { None } else { self.bursts.iter().rev().find(|burst| burst.number == number) }
    }

    /// Refutes all bursts that are still open.
    fn refute(&mut self) {
        for burst in self.bursts.iter_mut().filter(|burst| burst.verdict == Verdict::Open) {
            burst.verdict = Verdict::Refuted;
        }
    }

    /// Learns from an ordinary gap between frames.
    fn know_gap(&mut self, gap: Ns) {
        let gap = gap.min(Ns::MAX / 128);
        self.usual_gap_ns = (self.usual_gap_ns - self.usual_gap_ns / 256).max(gap);
        self.mean_gap_64 += if self.mean_gap_64 == Ns::ZERO { gap * 64 } else { gap - self.mean_gap_64 / 64 };
    }
}

/// Returns the minimum time that a frame takes in ns: on the fastest bus, without stuff bits.
pub(super) fn wire_ns(frame: &Frame) -> Ns {
    match frame.kind {
        Kind::Data => (FRAME_BITS + 8 * i64::from(frame.len)) * BIT_NS,
        _ => FRAME_NS,
    }
}
