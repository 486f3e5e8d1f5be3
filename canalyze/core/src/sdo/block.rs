//! The sub-blocks of one block transfer (CiA 301, 7.2.4.3.9 to 7.2.4.3.15), and the segments that count.
//!
//! A segment counts once it is acknowledged. The receiver may acknowledge fewer segments than were sent, and may do so
//! early; the sender then goes on with the data after the acknowledged ones, numbered from 1 again, while queued
//! segments still appear with old numbers. The last acknowledged segment is kept back, since only the end frame shows
//! how many of its bytes are padding. Channels, findings and time are unknown here.

use super::pace::Pace;
use super::sub_block::{Segment, SubBlock, Taken, Wrong, sequence};
use super::transfer::Transfer;
use crate::bytes::frame::FrameRef;
use crate::rules::sdo::Sdo012;

/// Maximum number of segments in a sub-block.
pub const MOST: u8 = 127;

/// The end frame of the transfer.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// Its frame.
    pub at: FrameRef,
    /// Number of bytes of the last segment without data; `None` if the frame is unreadable.
    pub unused: Option<u8>,
    /// The CRC field if the frame has one.
    pub crc: Option<u16>,
}

/// The effect of an acknowledgement.
#[derive(Clone, Debug, Default)]
pub struct Acked {
    /// Part of the sub-block will be sent again.
    pub retransmission: bool,
    /// The numbers of the first and the last segment that were sent and will be sent again.
    pub again: Option<(u8, u8)>,
    /// A violation, and the earlier frame it is about.
    pub fault: Option<(Sdo012, Option<FrameRef>)>,
    /// Number of segments that the receiver has got and the capture lacks.
    pub missing: u8,
}

/// The segment from which on frames count again after an acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resume {
    /// Any segment.
    Now,
    /// Sequence number 1; everything sent was acknowledged.
    AtFirst,
    /// Sequence number 1; the segments sent before are unknown.
    Unknown,
    /// Sequence number 1; others may be on their way, since a part was acknowledged early.
    BehindInFlight,
}

/// Segments in sequence after a partial acknowledgement; the next segment should be the first of them.
#[derive(Clone, Debug)]
struct Rest {
    segments: Vec<Segment>,
    ack: Acknowledgement,
}

/// The frame and the number of an acknowledgement.
pub type Acknowledgement = (FrameRef, u8);

/// Frames that findings are about.
#[derive(Clone, Copy, Debug, Default)]
pub struct Marks {
    /// The first segment of the transfer.
    pub first: Option<FrameRef>,
    /// The newest segment.
    pub newest: Option<FrameRef>,
    /// The segment that completed the sub-block, after which an acknowledgement is expected.
    pub complete: Option<FrameRef>,
}

/// The data phase of a block transfer.
#[derive(Clone, Debug)]
pub struct Block {
    /// Number of segments in the current sub-block; 0 if unknown, as the capture lacks the receiver's frames.
    blksize: u8,
    /// The number of the newest segment.
    seqno: u8,
    current: SubBlock,
    rest: Option<Rest>,
    /// The acknowledgement after which the sender went on with other data, until that is reported.
    pub not_resent: Option<Acknowledgement>,
    /// The segment from which on frames count.
    pub resume: Resume,
    /// Segments of the sub-block at the capture's start; its acknowledgement shows their place.
    unplaced: Vec<Segment>,
    /// The last acknowledged segment; the end frame shows how much of it is data.
    tail: Option<Segment>,
    /// The last segment was acknowledged, and the end frame is expected.
    pub finished: bool,
    /// A segment marked as last was sent, acknowledged or not.
    pub last_sent: bool,
    /// Frames that findings are about.
    pub marks: Marks,
    /// The pace of its segments.
    pub pace: Pace,
    /// The end frame, once seen.
    pub end: Option<End>,
    /// The client's start of an upload has been seen.
    pub started: bool,
    /// An acknowledgement was unreadable, so repeated segments are unknown.
    pub unsure: bool,
    /// It ended without a segment: if the server agrees, none was captured.
    pub unseen: bool,
    /// Number of segments out of sequence that were acknowledged without a place in the data, and of those since the
    /// last acknowledgement, which may be repeated.
    uncounted: (u64, u64),
}

impl Block {
    /// Creates a data phase with the receiver's block size; 0 if unknown.
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
            unseen: false,
            uncounted: (0, 0),
        }
    }

    /// Creates a data phase joined midway, which counts from the next sub-block on.
    pub fn midway() -> Self {
        Self { resume: Resume::Unknown, started: true, ..Self::new(0) }
    }

    /// Returns the number of segments out of sequence, which are no part of the data.
    pub fn uncounted(&self) -> u64 {
        self.uncounted.0.saturating_add(self.uncounted.1)
    }

    /// Returns the maximum number of segments in the current sub-block.
    pub fn most(&self) -> u8 {
        if self.blksize == 0 { MOST } else { self.blksize }
    }

    /// Returns true if the capture contains the receiver's frames.
    pub fn is_answered(&self) -> bool {
        self.blksize > 0
    }

    /// Returns true if a number neither follows the newest segment nor begins a sub-block.
    pub fn is_off(&self, seqno: u8) -> bool {
        seqno != 1 && seqno != self.seqno.saturating_add(1)
    }

    /// Returns true if an acknowledgement, in a transfer without beginning in the capture, belongs to the previous
    /// sub-block and is listed late: the current one has fewer segments and goes on with number `next`, or is complete.
    /// The first acknowledgement may be so, too, if it is `late` enough.
    pub fn is_of_before(&self, ackseq: u8, next: Option<u8>, late: bool) -> bool {
        let current = &self.current;
        let fewer = current.sent > 0 && current.wrong.is_none() && ackseq > current.sent;
        let goes_on = next == Some(current.sent.saturating_add(1));
        self.resume == Resume::Now && fewer && (current.last_at.is_some() || goes_on || late && !self.is_answered())
    }

    /// Returns true if an acknowledgement of this number of segments asks for one that was sent with these data.
    pub fn asks_again(&self, ackseq: u8, data: &[u8]) -> bool {
        let again = self.current.segments.get(usize::from(ackseq));
        again.is_some_and(|segment| segment.data.as_slice() == data)
    }

    /// Sets the number of segments that the receiver requests from the next sub-block on.
    pub fn set_size(&mut self, blksize: u8) {
        if (1..=MOST).contains(&blksize) {
            self.blksize = blksize;
        }
    }

    /// Returns true if a sequence number is the next one, even if the capture lacks the sub-block's beginning.
    pub fn is_next(&self, seqno: u8) -> bool {
        let unknown = self.resume == Resume::Unknown && self.seqno > 0;
        seqno == if unknown { self.seqno.saturating_add(1) } else { self.expected() }
    }

    /// Returns true if an acknowledgement of this number of segments fits the newest ones, whose number is otherwise
    /// unknown.
    pub fn may_owe(&self, ackseq: u8) -> bool {
        match self.resume {
            Resume::Unknown => self.seqno == ackseq,
            Resume::Now => self.runs_open() && self.current.sent == ackseq,
            _ => false,
        }
    }

    /// Returns true if a sub-block of unknown length runs.
    fn runs_open(&self) -> bool {
        !self.is_answered() && !self.owes_ack() && self.current.wrong.is_none()
    }

    /// Returns true if a segment with number 1 comes although the newest one was, as far as known, not acknowledged.
    pub fn restarts_early(&self) -> bool {
        let open = self.resume == Resume::Unknown || self.resume == Resume::Now && self.runs_open();
        open && self.seqno > 1
    }

    /// Returns true if an acknowledgement is expected.
    pub fn owes_ack(&self) -> bool {
        !self.finished && self.current.is_complete(self.most())
    }

    /// Returns the number of the expected acknowledgement without repetition.
    pub fn owed_ack(&self) -> Option<u8> {
        let whole = self.owes_ack() && self.current.wrong.is_none();
        whole.then_some(self.current.sent)
    }

    /// Returns true if the end frame may come: the last segment was sent, if perhaps not yet acknowledged.
    pub fn may_end(&self) -> bool {
        let current = &self.current;
        self.finished || (current.last_at.is_some() && current.is_complete(self.most()))
    }

    /// Returns the sequence number of the segment represented by an empty frame of the data's sender, if one was
    /// expected.
    pub fn unread(&self) -> Option<u8> {
        let current = &self.current;
        let ended = self.finished || self.end.is_some() || (self.owes_ack() && current.last_at.is_some());
        (!ended && current.wrong.is_none() && self.resume != Resume::BehindInFlight).then(|| self.expected())
    }

    /// Returns the expected sequence number.
    pub fn expected(&self) -> u8 {
        if self.owes_ack() { 1 } else { self.current.expected() }
    }

    /// Returns true if a sequence number begins the next sub-block or continues this one.
    pub fn goes_on(&self, seqno: u8) -> bool {
        seqno == 1 || seqno == self.current.expected()
    }

    /// Returns the number of the next segment in the transfer, from 1, after the `committed` ones.
    pub fn ordinal(&self, committed: u32) -> u32 {
        let current = self.current.segments.len() as u32;
        committed.saturating_add(current).saturating_add(1)
    }

    /// Returns the number of segments acknowledged by `ackseq` that were not seen and may be listed late.
    pub fn not_seen(&self, ackseq: u8) -> u8 {
        if self.resume == Resume::Unknown {
            return if self.seqno == 0 { 0 } else { ackseq.saturating_sub(self.seqno) };
        }
        let settled = self.current.wrong.is_some() || self.owes_ack() || self.finished;
        if settled { 0 } else { ackseq.saturating_sub(self.current.segments.len() as u8) }
    }

    /// Takes a segment; returns its classification, and the frame after which the capture lacks an acknowledgement.
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
                // Some of them may be repeated, so their number is unknown.
                self.miss(transfer);
            }
            self.resume = Resume::Now;
        }
        self.resume(transfer, &segment);
        self.last_sent |= last;
        let blksize = self.most();
        let mut ack_missing = None;
        if self.blksize == 0 && seqno == 1 && !self.owes_ack() && !self.current.segments.is_empty() {
            // The next sub-block: the capture lacks the acknowledgement of this one, and perhaps its end.
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
            // The segment marked as last was not last, or is repeated.
            (self.finished, self.last_sent) = (false, false);
        }
        let taken = self.current.take(blksize, at, segment);
        if self.owes_ack() {
            self.marks.complete = Some(at);
        }
        (taken, ack_missing)
    }

    /// Takes the first segment after a partial acknowledgement. If it is not the first of the rest, the sender takes
    /// those for acknowledged as well.
    fn resume(&mut self, transfer: &mut Transfer, segment: &Segment) {
        if let Some(Rest { segments, ack }) = self.rest.take()
            && segments.first().is_some_and(|first| !first.is_like(segment))
        {
            self.commit(transfer, &segments);
            self.not_resent = Some(ack);
        }
    }

    /// Takes an end frame before the last segments were acknowledged, which the sender takes for acknowledged; returns
    /// true if there were such segments.
    pub fn finish_unacknowledged(&mut self, transfer: &mut Transfer) -> bool {
        let Some(Rest { segments, .. }) = self.rest.take().filter(|_| self.last_sent) else { return false };
        self.commit(transfer, &segments);
        self.finished = true;
        true
    }

    /// Takes segments after a sub-block acknowledged with its last one: the mark was wrong. Returns the segment that
    /// carried it.
    pub fn reopen(&mut self) -> Option<FrameRef> {
        (self.finished, self.last_sent) = (false, false);
        self.marks.complete
    }

    /// Takes a segment that does not begin a new sub-block although the current one is complete. One that continues
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

    /// Takes the receiver's acknowledgement.
    pub fn ack(&mut self, transfer: &mut Transfer, at: FrameRef, ackseq: u8, blksize: u8) -> Acked {
        let mut acked = Acked::default();
        let current = std::mem::take(&mut self.current);
        // The empty frame may have been the last segment.
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
            // Nothing can be missing after the last segment.
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

    /// Takes an unreadable acknowledgement, which may request any repetition; returns true if one was due.
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
        // It acknowledged something, so none of these is owed any more.
        self.seqno = 0;
        true
    }

    /// Counts everything sent so far, because the capture lacks its acknowledgement.
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

    /// Takes an end frame without a segment marked as last: everything was sent.
    pub fn finish_early(&mut self, transfer: &mut Transfer) {
        self.settle_whole(transfer);
        self.finished = true;
    }

    /// Adds the data of the last segment; returns its padding. `unused`: number of its bytes without data, if known.
    pub fn close(&mut self, transfer: &mut Transfer, unused: Option<u8>) -> [u8; 7] {
        let mut padding = [0; 7];
        let Some(tail) = self.tail.take() else { return padding };
        // Without the end frame, the size may decide.
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

    /// Counts the segments of known place when the capture shows no more of the transfer. `unused`: as for
    /// [`Self::close`], if the end frame was seen.
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

    /// Holds a segment of the sub-block at the capture's start while numbers ascend.
    fn hold_unplaced(&mut self, transfer: &Transfer, segment: Segment) {
        let begins = self.resume == Resume::Unknown && transfer.outcome.midway && transfer.data.segments == 0;
        if begins && self.unplaced.last().is_none_or(|before| before.seqno < segment.seqno) {
            self.unplaced.push(segment);
        }
    }

    /// Counts the segments of the sub-block at the capture's start, up to `ackseq` or all; returns true if there were
    /// any.
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

    /// Marks a hole after the counted segments: some are missing or repeated.
    pub fn miss(&mut self, transfer: &mut Transfer) {
        // The amount of data in a segment marked as last is unknown.
        if let Some(tail) = self.tail.take().filter(|tail| !tail.last) {
            append(transfer, &tail, 7);
        }
        transfer.miss(None);
    }

    /// Returns the first segment out of sequence since the last acknowledgement.
    pub fn wrong(&self) -> Option<(Sdo012, FrameRef)> {
        self.current.wrong.as_ref().map(|wrong| (wrong.what.clone(), wrong.at))
    }
}

/// Appends the first bytes of a segment to the data; bytes missing in its frame become a hole.
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
