//! The sub-blocks of one block transfer (CiA 301, 7.2.4.3.9 to 7.2.4.3.15): which segments count.
//!
//! A segment counts once it is acknowledged. The receiver may acknowledge fewer segments than were sent, and may
//! do so early; the sender then goes on with the data after the acknowledged ones, numbered from 1 again, while
//! segments already queued still appear with old numbers. The last acknowledged segment is kept back, since only
//! the end frame tells how many of its bytes are padding.
//!
//! This file judges sequence numbers only. It knows nothing of channels, findings or time.

use super::pace::Pace;
use super::sub_block::{Segment, SubBlock, Taken, Wrong, sequence};
use super::transfer::Transfer;
use crate::frame::FrameRef;
use crate::rules::sdo::Sdo012;

/// Most segments of a sub-block.
pub const MOST: u8 = 127;

/// The end frame of the transfer.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// Where it stands.
    pub at: FrameRef,
    /// Bytes of the last segment without data; `None`: nothing can be read from the frame.
    pub unused: Option<u8>,
    /// The CRC field, where the frame has one.
    pub crc: Option<u16>,
}

/// What an acknowledgement settled.
#[derive(Clone, Debug, Default)]
pub struct Acked {
    /// Part of the sub-block will be sent again.
    pub retransmission: bool,
    /// The numbers of the first and the last segment that were sent and will be sent again.
    pub again: Option<(u8, u8)>,
    /// A violation, and the earlier frame it is about.
    pub fault: Option<(Sdo012, Option<FrameRef>)>,
    /// Segments that the receiver has got and that are not in the capture.
    pub missing: u8,
}

/// From which segment on frames count again after an acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resume {
    /// From any.
    Now,
    /// From sequence number 1 on; everything sent was acknowledged.
    AtFirst,
    /// From sequence number 1 on; nothing is known of what was sent.
    Unknown,
    /// From sequence number 1 on; others may be under way, since a part was acknowledged early.
    BehindInFlight,
}

/// Segments in sequence that a partial acknowledgement left: the next segment should be the first of them.
#[derive(Clone, Debug)]
struct Rest {
    segments: Vec<Segment>,
    ack: Acknowledgement,
}

/// An acknowledgement: where it stands, and its number.
pub type Acknowledgement = (FrameRef, u8);

/// Frames that findings are about.
#[derive(Clone, Copy, Debug, Default)]
pub struct Marks {
    /// The transfer's first segment.
    pub first: Option<FrameRef>,
    /// Its newest one.
    pub newest: Option<FrameRef>,
    /// The segment that completed the sub-block: since then an acknowledgement is expected.
    pub complete: Option<FrameRef>,
}

/// The data phase of a block transfer.
#[derive(Clone, Debug)]
pub struct Block {
    /// Segments in the current sub-block; 0: not known, as the receiver's frames are not in the capture.
    blksize: u8,
    /// The number of the newest segment.
    seqno: u8,
    current: SubBlock,
    rest: Option<Rest>,
    /// The acknowledgement after which the sender went on with other data, until it is reported.
    pub not_resent: Option<Acknowledgement>,
    /// From which segment on frames count.
    pub resume: Resume,
    /// Segments of the sub-block in which the capture begins: their place shows its acknowledgement.
    unplaced: Vec<Segment>,
    /// The last acknowledged segment: only the end frame shows how much of it is data.
    tail: Option<Segment>,
    /// The last segment was acknowledged: the end frame is expected.
    pub finished: bool,
    /// A segment marked as last was sent, acknowledged or not.
    pub last_sent: bool,
    /// Frames that findings are about.
    pub marks: Marks,
    /// How fast its segments follow each other.
    pub pace: Pace,
    /// The end frame, once seen.
    pub end: Option<End>,
    /// The client's start of an upload has been seen.
    pub started: bool,
    /// An acknowledgement could not be read: what was sent again is not known.
    pub unsure: bool,
    /// Segments out of sequence that were acknowledged, but have no place in the data; and those since the last
    /// acknowledgement, which the sender may send again.
    uncounted: (u64, u64),
}

impl Block {
    /// A data phase that begins, with the receiver's block size; 0: it is not known.
    pub fn new(blksize: u8) -> Self {
        Self {
            blksize: blksize.min(MOST),
            seqno: 0,
            current: SubBlock::default(),
            rest: None,
            not_resent: None,
            resume: Resume::Now,
            unplaced: Vec::new(),
            tail: None,
            finished: false,
            last_sent: false,
            marks: Marks::default(),
            pace: Pace::default(),
            end: None,
            started: false,
            unsure: false,
            uncounted: (0, 0),
        }
    }

    /// A data phase met in its midst: it counts from the next sub-block on.
    pub fn midway() -> Self {
        Self { resume: Resume::Unknown, started: true, ..Self::new(0) }
    }

    /// Segments that came out of sequence, and are no part of the data.
    pub fn uncounted(&self) -> u64 {
        self.uncounted.0.saturating_add(self.uncounted.1)
    }

    /// The most segments of the current sub-block.
    pub fn most(&self) -> u8 {
        if self.blksize == 0 { MOST } else { self.blksize }
    }

    /// Whether the capture shows what the receiver sends.
    pub fn is_answered(&self) -> bool {
        self.blksize > 0
    }

    /// Whether a number neither goes on from the newest segment nor begins a sub-block.
    pub fn is_off(&self, seqno: u8) -> bool {
        seqno != 1 && seqno != self.seqno.saturating_add(1)
    }

    /// Whether an acknowledgement, where the beginning of the transfer is not in the capture, is of the sub-block before
    /// and listed late: this one has fewer segments so far, and goes on with number `next`, or has had its last one. The
    /// first one may be, where it is `late` enough.
    pub fn is_of_before(&self, ackseq: u8, next: Option<u8>, late: bool) -> bool {
        let current = &self.current;
        let fewer = current.sent > 0 && current.wrong.is_none() && ackseq > current.sent;
        let goes_on = next == Some(current.sent.saturating_add(1));
        self.resume == Resume::Now && fewer && (current.last_at.is_some() || goes_on || late && !self.is_answered())
    }

    /// Whether an acknowledgement of this many segments asks for one that was sent with these data.
    pub fn asks_again(&self, ackseq: u8, data: &[u8]) -> bool {
        let again = self.current.segments.get(usize::from(ackseq));
        again.is_some_and(|segment| segment.data.as_slice() == data)
    }

    /// What the receiver asks for: segments of a sub-block, from the next one on.
    pub fn set_size(&mut self, blksize: u8) {
        if (1..=MOST).contains(&blksize) {
            self.blksize = blksize;
        }
    }

    /// Whether a sequence number is the next one, also where the beginning of the sub-block is not in the capture.
    pub fn is_next(&self, seqno: u8) -> bool {
        let unknown = self.resume == Resume::Unknown && self.seqno > 0;
        seqno == if unknown { self.seqno.saturating_add(1) } else { self.expected() }
    }

    /// Whether an acknowledgement of this many segments is of the newest ones, of which the number in the sub-block is not
    /// known otherwise.
    pub fn may_owe(&self, ackseq: u8) -> bool {
        match self.resume {
            Resume::Unknown => self.seqno == ackseq,
            Resume::Now => self.runs_open() && self.current.sent == ackseq,
            _ => false,
        }
    }

    /// Whether a sub-block runs of which nobody can tell how long it is.
    fn runs_open(&self) -> bool {
        !self.is_answered() && !self.owes_ack() && self.current.wrong.is_none()
    }

    /// Whether a segment with number 1 comes where the newest one has another number and was not acknowledged, as far as
    /// that is known.
    pub fn restarts_early(&self) -> bool {
        let open = self.resume == Resume::Unknown || self.resume == Resume::Now && self.runs_open();
        open && self.seqno > 1
    }

    /// Whether an acknowledgement is expected.
    pub fn owes_ack(&self) -> bool {
        !self.finished && self.current.is_complete(self.most())
    }

    /// The number that the acknowledgement that is expected has to have, if nothing is to be sent again.
    pub fn owed_ack(&self) -> Option<u8> {
        let whole = self.owes_ack() && self.current.wrong.is_none();
        whole.then_some(self.current.sent)
    }

    /// Whether the end frame may come: the last segment was sent, though perhaps not yet acknowledged.
    pub fn may_end(&self) -> bool {
        let current = &self.current;
        self.finished || (current.last_at.is_some() && current.is_complete(self.most()))
    }

    /// The sequence number of the segment that an empty frame by the sender of the data stands for, where one was
    /// expected.
    pub fn unread(&self) -> Option<u8> {
        let current = &self.current;
        let ended = self.finished || self.end.is_some() || (self.owes_ack() && current.last_at.is_some());
        (!ended && current.wrong.is_none() && self.resume != Resume::BehindInFlight).then(|| self.expected())
    }

    /// The sequence number that is expected.
    pub fn expected(&self) -> u8 {
        if self.owes_ack() { 1 } else { self.current.expected() }
    }

    /// Whether a sequence number begins the next sub-block, or counts on in this one.
    pub fn goes_on(&self, seqno: u8) -> bool {
        seqno == 1 || seqno == self.current.expected()
    }

    /// Number in the transfer of the next segment, from 1, behind those that are acknowledged.
    pub fn ordinal(&self, committed: u32) -> u32 {
        let current = self.current.segments.len() as u32;
        committed.saturating_add(current).saturating_add(1)
    }

    /// How many segments an acknowledgement of `ackseq` covers that were not seen, and may be listed late.
    pub fn not_seen(&self, ackseq: u8) -> u8 {
        if self.resume == Resume::Unknown {
            return if self.seqno == 0 { 0 } else { ackseq.saturating_sub(self.seqno) };
        }
        let settled = self.current.wrong.is_some() || self.owes_ack() || self.finished;
        if settled { 0 } else { ackseq.saturating_sub(self.current.segments.len() as u8) }
    }

    /// Takes a segment. Returns how it was taken, and the frame after which an acknowledgement is missing from the
    /// capture.
    pub fn segment(&mut self, transfer: &mut Transfer, at: FrameRef, segment: Segment) -> (Taken, Option<FrameRef>) {
        let Segment { seqno, last, .. } = segment;
        self.marks.first.get_or_insert(at);
        self.marks.newest = Some(at);
        self.seqno = seqno;
        self.uncounted.1 = 0;
        if self.resume != Resume::Now {
            if seqno != 1 {
                self.hold_unplaced(transfer, segment);
                return (Taken::InFlight, None);
            }
            if self.place(transfer, None) {
                // How many of them count is not known: some may come again.
                self.miss(transfer);
            }
            self.resume = Resume::Now;
        }
        self.resume(transfer, &segment);
        self.last_sent |= last;
        let blksize = self.most();
        let mut ack_missing = None;
        if self.blksize == 0 && seqno == 1 && !self.owes_ack() && !self.current.segments.is_empty() {
            // The next sub-block: the acknowledgement of this one is not in the capture, nor perhaps its end.
            self.settle_whole(transfer);
            (self.finished, self.last_sent) = (false, false);
            self.miss(transfer);
        }
        if self.owes_ack() {
            if seqno != 1 {
                return (self.beyond_complete(at, segment), None);
            }
            ack_missing = self.marks.complete;
            let marked = self.current.last_at.is_some();
            self.settle_whole(transfer);
            if marked {
                self.miss(transfer);
            }
            // What was marked as the last segment was not, or is sent again.
            (self.finished, self.last_sent) = (false, false);
        }
        let taken = self.current.take(blksize, at, segment);
        if self.owes_ack() {
            self.marks.complete = Some(at);
        }
        (taken, ack_missing)
    }

    /// The first segment after an acknowledgement of a part: is it the first of the others? If not, the sender takes
    /// these for acknowledged as well.
    fn resume(&mut self, transfer: &mut Transfer, segment: &Segment) {
        if let Some(Rest { segments, ack }) = self.rest.take()
            && segments.first().is_some_and(|first| !first.is_like(segment))
        {
            self.commit(transfer, &segments);
            self.not_resent = Some(ack);
        }
    }

    /// The end frame came though segments up to the last one were not acknowledged: the sender takes them for it.
    /// Returns whether there were such.
    pub fn finish_unacknowledged(&mut self, transfer: &mut Transfer) -> bool {
        let Some(Rest { segments, .. }) = self.rest.take().filter(|_| self.last_sent) else { return false };
        self.commit(transfer, &segments);
        self.finished = true;
        true
    }

    /// Segments go on after a sub-block that was acknowledged with its last one: the mark was wrong. Returns the
    /// segment that carried it.
    pub fn reopen(&mut self) -> Option<FrameRef> {
        (self.finished, self.last_sent) = (false, false);
        self.marks.complete
    }

    /// A segment that does not begin a new sub-block though the current one is complete. One that goes on counting
    /// after a segment marked as last shows that the mark was wrong.
    fn beyond_complete(&mut self, at: FrameRef, segment: Segment) -> Taken {
        let seqno = segment.seqno;
        let goes_on = seqno == self.current.expected() && seqno <= self.most();
        match self.current.last_at {
            Some(marked) if goes_on => {
                let marked_at = self.marks.complete.unwrap_or(at);
                self.current.wrong.get_or_insert(Wrong { at: marked_at, expected: marked, what: Sdo012::Outside });
                self.current.last_at = None;
                self.current.take(self.most(), at, segment)
            }
            _ => {
                self.current.astray += 1;
                self.current.sent = self.current.sent.max(seqno);
                self.current.wrong.get_or_insert(Wrong { at, expected: 1, what: sequence(1, seqno) });
                Taken::OutOfSequence(1)
            }
        }
    }

    /// The receiver's acknowledgement.
    pub fn ack(&mut self, transfer: &mut Transfer, at: FrameRef, ackseq: u8, blksize: u8) -> Acked {
        let mut acked = Acked::default();
        let current = std::mem::take(&mut self.current);
        // What came in an empty frame may have been the last segment.
        let unread = current.ends_unread() && usize::from(ackseq) == current.segments.len();
        let whole = unread || (!self.finished && current.is_complete(self.most()));
        acked.missing = current.not_captured(ackseq, self.most());
        if acked.missing > 0 {
            self.finished = current.last_at.is_some();
            let segments = current.in_place(ackseq);
            self.commit(transfer, &segments);
            (self.rest, self.resume) = (None, Resume::Now);
            self.set_size(blksize);
            return acked;
        }
        let in_sequence = current.segments.len() as u8;
        let acknowledged = current.acknowledged_astray(ackseq);
        self.uncounted = (self.uncounted.0.saturating_add(acknowledged), current.astray.saturating_sub(acknowledged));
        if ackseq > current.sent && transfer.mux.is_some() {
            acked.fault = Some((Sdo012::Acknowledged { ackseq: ackseq.into(), sent: current.sent.into() }, None));
        }
        if let Some(wrong) = &current.wrong
            && ackseq >= wrong.expected
            && acked.fault.is_none()
        {
            acked.fault = Some((wrong.what.clone(), Some(wrong.at)));
        }
        acked.retransmission = ackseq < current.sent || !whole;
        acked.again = (ackseq < current.sent).then_some((ackseq.saturating_add(1), current.sent));
        self.commit(transfer, current.segments.get(..usize::from(ackseq.min(in_sequence))).unwrap_or(&[]));
        if !self.place(transfer, Some(ackseq)) && ackseq > in_sequence {
            // Behind the last segment nothing can be missing.
            match self.tail.is_some_and(|tail| tail.last) {
                true => transfer.data.hole = true,
                false => self.miss(transfer),
            }
        }
        let rest =
            current.segments.get(usize::from(ackseq)..).filter(|rest| !rest.is_empty() && current.wrong.is_none());
        self.rest = rest.map(|rest| Rest { segments: rest.to_vec(), ack: (at, ackseq) });
        self.finished = current.last_at.is_some_and(|seqno| ackseq >= seqno);
        self.resume = match self.finished || whole {
            true => Resume::Now,
            false if ackseq >= current.sent => Resume::AtFirst,
            false => Resume::BehindInFlight,
        };
        if (1..=MOST).contains(&blksize) {
            self.blksize = blksize;
        } else if acked.fault.is_none() {
            acked.fault = Some((Sdo012::BlockSize { blksize: blksize.into() }, None));
        }
        acked
    }

    /// An acknowledgement of which nothing can be read: it may leave anything to be sent again. Returns whether one was
    /// due.
    pub fn ack_unread(&mut self, transfer: &mut Transfer) -> bool {
        if self.finished || self.current.segments.is_empty() {
            return false;
        }
        self.unsure = true;
        let resume = if self.owes_ack() { Resume::Unknown } else { Resume::BehindInFlight };
        self.settle_whole(transfer);
        self.finished = self.end.is_some();
        self.resume = if self.finished { Resume::Now } else { resume };
        (self.rest, self.last_sent) = (None, false);
        // It acknowledged something: none of these is owed any more.
        self.seqno = 0;
        true
    }

    /// Counts everything sent so far: its acknowledgement is missing from the capture.
    pub fn settle_whole(&mut self, transfer: &mut Transfer) {
        let current = std::mem::take(&mut self.current);
        self.commit(transfer, &current.segments);
        self.finished |= current.last_at.is_some();
    }

    fn commit(&mut self, transfer: &mut Transfer, segments: &[Segment]) {
        for segment in segments {
            if let Some(tail) = self.tail.replace(*segment) {
                append(transfer, &tail, 7);
            }
            transfer.data.hole |= segment.len == 0;
        }
        transfer.data.segments = transfer.data.segments.saturating_add(segments.len() as u32);
    }

    /// The end frame came though no segment was marked as the last one: what was sent is all.
    pub fn finish_early(&mut self, transfer: &mut Transfer) {
        self.settle_whole(transfer);
        self.finished = true;
    }

    /// Adds the data bytes of the last segment; returns its padding. `unused`: bytes of it without data, as far as known.
    pub fn close(&mut self, transfer: &mut Transfer, unused: Option<u8>) -> [u8; 7] {
        let mut padding = [0; 7];
        let Some(tail) = self.tail.take() else { return padding };
        // Where the end frame does not tell, the size may.
        let rest = transfer.rest().filter(|rest| *rest <= 7).map(|rest| rest as usize);
        let Some(carried) = unused.map(|unused| 7 - usize::from(unused.min(7))).or(rest) else {
            transfer.miss(None);
            return padding;
        };
        append(transfer, &tail, carried);
        for (slot, byte) in padding.iter_mut().zip(tail.data.iter().skip(carried)) {
            *slot = *byte;
        }
        transfer.reach_end();
        padding
    }

    /// The capture shows no more of the transfer: what was sent counts as far as its place is known. `unused`: as for
    /// [`Self::close`], where the end frame was seen.
    pub fn cut_off(&mut self, transfer: &mut Transfer, unused: Option<u8>) {
        self.place(transfer, None);
        let mut current = std::mem::take(&mut self.current);
        if current.segments.is_empty()
            && let Some(Rest { segments, .. }) = self.rest.take()
        {
            current.segments = segments;
        }
        let newest = if current.descends { None } else { current.behind.last().map(|segment| segment.seqno) };
        match newest {
            Some(newest) => {
                let segments = current.in_place(newest);
                self.commit(transfer, &segments);
            }
            None => self.commit(transfer, &current.segments),
        }
        if unused.is_some() || self.tail.is_some_and(|tail| tail.last) {
            self.close(transfer, unused);
        } else if let Some(tail) = self.tail.take() {
            append(transfer, &tail, 7);
        }
    }

    /// Holds a segment of the sub-block in which the capture begins, as long as numbers ascend.
    fn hold_unplaced(&mut self, transfer: &Transfer, segment: Segment) {
        let begins = self.resume == Resume::Unknown && transfer.outcome.midway && transfer.data.segments == 0;
        if begins && self.unplaced.last().is_none_or(|before| before.seqno < segment.seqno) {
            self.unplaced.push(segment);
        }
    }

    /// Counts the segments of the sub-block in which the capture begins, up to `ackseq`, or all of them. Returns whether
    /// there were such.
    fn place(&mut self, transfer: &mut Transfer, ackseq: Option<u8>) -> bool {
        let unplaced = std::mem::take(&mut self.unplaced);
        let (Some(first), Some(last)) = (unplaced.first(), unplaced.last()) else { return false };
        let (first, newest) = (first.seqno, last.seqno);
        let last = ackseq.unwrap_or(newest).min(newest);
        let current = SubBlock { behind: unplaced, ..SubBlock::default() };
        let segments = current.in_place(last);
        self.commit(transfer, segments.get(usize::from(first) - 1..).unwrap_or(&[]));
        if ackseq.is_some_and(|ackseq| ackseq > newest) {
            // It may also be listed late.
            self.miss(transfer);
        }
        true
    }

    /// Behind what was counted some segments are missing, or some come again.
    pub fn miss(&mut self, transfer: &mut Transfer) {
        // Of one that was marked as the last it is not known how much is data.
        if let Some(tail) = self.tail.take().filter(|tail| !tail.last) {
            append(transfer, &tail, 7);
        }
        transfer.miss(None);
    }

    /// The first segment out of sequence since the last acknowledgement.
    pub fn wrong(&self) -> Option<(Sdo012, FrameRef)> {
        self.current.wrong.as_ref().map(|wrong| (wrong.what.clone(), wrong.at))
    }
}

/// Adds the first bytes of a segment to the transfer's data, as far as its frame had them: the others are missing.
fn append(transfer: &mut Transfer, segment: &Segment, bytes: usize) {
    let carried = segment.carried().min(bytes);
    transfer.append(segment.data.get(..carried).unwrap_or(&[]));
    transfer.miss(Some(bytes.saturating_sub(carried) as u64));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_that_do_not_ascend_take_no_memory() {
        let mut current = SubBlock::default();
        for no in 0..10_000_u32 {
            let segment = Segment { seqno: 5 + (no % 3) as u8, last: false, data: [0; 7], len: 8 };
            current.take(MOST, FrameRef::default(), segment);
        }
        assert_eq!(current.behind.len(), 3);
        assert!(current.segments.is_empty());
    }
}
