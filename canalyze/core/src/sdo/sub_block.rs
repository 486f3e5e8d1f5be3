//! One sub-block of a block transfer: the segments since the last acknowledgement, in sequence or not.

use crate::bytes::frame::FrameRef;
use crate::rules::sdo::Sdo012;

/// A received segment. If its frame was too short, its data have a hole; in an empty frame the mark of the last segment
/// is unknown.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Sequence number in the sub-block.
    pub seqno: u8,
    /// c: last segment of the transfer.
    pub last: bool,
    /// Seven data bytes.
    pub data: [u8; 7],
    /// Length of the frame in bytes.
    pub len: u8,
}

impl Segment {
    /// Returns the number of data bytes in the frame.
    pub(super) fn carried(&self) -> usize {
        usize::from(self.len.saturating_sub(1)).min(self.data.len())
    }

    /// Returns true if two segments agree except for a damaged byte or two; short ones agree with any.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let same = self.data.iter().zip(&other.data).filter(|(one, other)| one == other).count();
        same > 4 || self.carried().min(other.carried()) < self.data.len()
    }
}

/// A segment out of sequence.
#[derive(Clone, Debug)]
pub(super) struct Wrong {
    pub(super) at: FrameRef,
    /// The number expected at that time; its acknowledgement accepts the fault.
    pub(super) expected: u8,
    pub(super) what: Sdo012,
}

/// The classification of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// The next one.
    InSequence,
    /// On its way during an early acknowledgement; it does not count.
    InFlight,
    /// Out of sequence, with the expected number.
    OutOfSequence(u8),
}

/// A sub-block with its segments in sequence.
#[derive(Clone, Debug, Default)]
pub(super) struct SubBlock {
    pub(super) segments: Vec<Segment>,
    /// Highest sequence number sent, in sequence or not.
    pub(super) sent: u8,
    /// Sequence number of the segment with c = 1.
    pub(super) last_at: Option<u8>,
    pub(super) wrong: Option<Wrong>,
    /// Number of segments out of sequence.
    pub(super) astray: u64,
    /// Segments after a gap while numbers ascend; the acknowledgement shows if the receiver has got the missing ones.
    pub(super) behind: Vec<Segment>,
    /// A number was repeated or lower than one before.
    pub(super) descends: bool,
}

impl SubBlock {
    pub(super) fn expected(&self) -> u8 {
        (self.segments.len() as u8).saturating_add(1)
    }

    pub(super) fn is_complete(&self, blksize: u8) -> bool {
        let taken = self.segments.len();
        taken >= usize::from(blksize) || self.last_at.is_some_and(|seqno| usize::from(seqno) == taken)
    }

    /// Returns true if its newest segment came in an empty frame and may be the last one.
    pub(super) fn ends_unread(&self) -> bool {
        self.wrong.is_none() && self.segments.last().is_some_and(|segment| segment.len == 0)
    }

    pub(super) fn take(&mut self, blksize: u8, at: FrameRef, segment: Segment) -> Taken {
        let Segment { seqno, last, .. } = segment;
        let expected = self.expected();
        self.descends |= seqno <= self.sent;
        self.sent = self.sent.max(seqno);
        if last {
            self.last_at = Some(seqno);
        }
        if seqno == expected && seqno <= blksize {
            self.segments.push(segment);
            return Taken::InSequence;
        }
        self.astray += 1;
        self.wrong.get_or_insert(Wrong { at, expected, what: sequence(expected, seqno) });
        // Numbers that do not ascend are no loss of the recording. At most one sub-block of them is kept.
        if !self.descends {
            self.behind.push(segment);
        }
        Taken::OutOfSequence(expected)
    }

    /// Returns the number of segments out of sequence covered by an acknowledgement.
    pub(super) fn acknowledged_astray(&self, ackseq: u8) -> u64 {
        let covered = || self.behind.iter().filter(|segment| segment.seqno <= ackseq).count() as u64;
        if self.descends { self.astray } else { covered() }
    }

    /// Returns the number of segments up to `ackseq` that the receiver has got and the capture lacks, in a sub-block of
    /// up to `most`: numbers ascend up to the last one, and it acknowledges beyond the gap, or the whole sub-block.
    pub(super) fn not_captured(&self, ackseq: u8, most: u8) -> u8 {
        let seen = self.segments.len() + self.behind.len();
        let ends = self.last_at.is_none_or(|last| last == ackseq) && ackseq <= most;
        let gap = self.wrong.is_some() && ackseq == self.sent;
        let tail = seen > 0 && ackseq > self.sent && ackseq == most;
        if self.descends || !ends || !(gap || tail) { 0 } else { ackseq.saturating_sub(seen as u8) }
    }

    /// Returns all segments up to `ackseq` in place; missing ones are empty.
    pub(super) fn in_place(self, ackseq: u8) -> Vec<Segment> {
        let mut seen = self.segments.into_iter().chain(self.behind).peekable();
        let at = |seqno| {
            let segment = seen.next_if(|segment| segment.seqno == seqno);
            segment.unwrap_or(Segment { seqno, last: false, data: [0; 7], len: 0 })
        };
        (1..=ackseq).map(at).collect()
    }
}

/// Returns the violation of an unexpected number.
pub(super) fn sequence(expected: u8, found: u8) -> Sdo012 {
    Sdo012::Sequence { expected: expected.into(), found: found.into() }
}
