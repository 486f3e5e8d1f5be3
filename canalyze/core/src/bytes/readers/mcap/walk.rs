//! The records of a file in order, from bytes in any chunking, and the recovery after damage.
//!
//! A record is returned when it is complete. Unused records (indexes, attachments) are skipped without being kept. At
//! an impossible record, the search continues for the next place with a certain one. Memory holds at most a record and
//! a piece of input.
//!
//! Limits: a record that has to be kept is at most [`MAX_RECORD`] bytes, a message of frames at most [`MAX_MESSAGE`].

use crc32fast::Hasher;

use super::bytes::Bytes;
use crate::bytes::readers::{Damage, DamageKind, FilePlace};

pub(super) const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
/// Maximum length of a record, in bytes (256 MiB); chunks usually have 1 to 16 MiB.
pub(super) const MAX_RECORD: u64 = 256 << 20;
/// Maximum length of a message with a frame, in bytes.
pub(super) const MAX_MESSAGE: u64 = 64 << 10;
/// Maximum length of a schema or channel, in bytes, which are text.
const MAX_TEXT: u64 = 16 << 20;
/// Number of bytes that are examined to recognize a record.
const LOOK: usize = 64;
/// Maximum distance in time to the previous message, in ns, of a message that is accepted in a search.
const NEAR_NS: u64 = 86_400_000_000_000;

/// The types of records.
pub(super) mod op {
    pub(crate) const HEADER: u8 = 0x01;
    pub(crate) const FOOTER: u8 = 0x02;
    pub(crate) const SCHEMA: u8 = 0x03;
    pub(crate) const CHANNEL: u8 = 0x04;
    pub(crate) const MESSAGE: u8 = 0x05;
    pub(crate) const CHUNK: u8 = 0x06;
    pub(crate) const MESSAGE_INDEX: u8 = 0x07;
    pub(crate) const CHUNK_INDEX: u8 = 0x08;
    pub(crate) const ATTACHMENT: u8 = 0x09;
    pub(crate) const ATTACHMENT_INDEX: u8 = 0x0A;
    pub(crate) const STATISTICS: u8 = 0x0B;
    pub(crate) const METADATA: u8 = 0x0C;
    pub(crate) const METADATA_INDEX: u8 = 0x0D;
    pub(crate) const SUMMARY_OFFSET: u8 = 0x0E;
    pub(crate) const DATA_END: u8 = 0x0F;
}

/// The next step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// More bytes are needed.
    More,
    /// A file begins; nothing of the previous one applies.
    Begin,
    /// A record: [`Walk::body`] returns its bytes, [`Walk::went`] takes the result.
    Record(Record),
    /// A record that the end of the input cuts off.
    Cut(Record),
    /// A part without a record.
    Damaged(Damage),
}

/// A record in the held bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    /// Its offset in the file.
    pub(super) at: u64,
    pub(super) op: u8,
    /// Its length with its own head; for a skipped record only its first bytes.
    pub(super) len: usize,
    /// True if its own length was wrong and that of its content was taken; only a check sum can decide.
    pub(super) doubtful: bool,
}

/// Size of the type and length before a record, in bytes.
pub(super) const HEAD: usize = 9;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Before the magic at the beginning.
    Magic,
    Records,
    /// Within a skipped record, with this number of bytes to go.
    Passing(u64),
    /// In zeros, from this offset on.
    Zeros(u64),
    /// Damaged from this offset on.
    Lost(u64),
    /// After the magic at the end.
    Over,
}

/// The walk through one input.
#[derive(Debug)]
pub(super) struct Walk {
    held: Vec<u8>,
    /// Number of consumed bytes in `held`.
    from: usize,
    /// Offset of `held` in the input.
    at: u64,
    /// Minimum number of bytes for the next step.
    need: usize,
    state: State,
    /// True if the end was as it should be.
    whole: bool,
    /// Channels of frames, by their IDs.
    frames: Vec<bool>,
    /// Time of recording of the last message outside chunks.
    near_ns: Option<u64>,
    /// True after the end of the data: only records of the summary follow.
    data_ended: bool,
    /// The check sum of the data so far, and its end in `held`; `None` after a loss.
    sum: Option<Hasher>,
    summed: usize,
}

impl Walk {
    pub(super) fn new() -> Self {
        Self {
            held: Vec::new(),
            from: 0,
            at: 0,
            need: 0,
            state: State::Magic,
            whole: true,
            frames: Vec::new(),
            near_ns: None,
            data_ended: false,
            sum: None,
            summed: 0,
        }
    }

    /// Adds the next bytes of the input.
    pub(super) fn push(&mut self, mut bytes: &[u8]) {
        if self.from > 0 {
            self.add_up();
            self.held.drain(..self.from);
            self.summed = 0;
            self.at += self.from as u64;
            self.need = self.need.saturating_sub(self.from);
            self.from = 0;
        }
        if let (State::Passing(left), true) = (&mut self.state, self.held.is_empty()) {
            let passed = bytes.len().min(usize::try_from(*left).unwrap_or(usize::MAX));
            *left -= passed as u64;
            self.at += passed as u64;
            if let (Some(sum), Some(bytes)) = (&mut self.sum, bytes.get(..passed)) {
                sum.update(bytes);
            }
            bytes = bytes.get(passed..).unwrap_or_default();
        }
        self.held.extend_from_slice(bytes);
    }

    /// Marks a channel as one of frames, whose messages are kept.
    pub(super) fn mark(&mut self, channel: u16) {
        let index = usize::from(channel);
        if self.frames.len() <= index {
            self.frames.resize(index + 1, false);
        }
        if let Some(frames) = self.frames.get_mut(index) {
            *frames = true;
        }
    }

    fn has_frames(&self, channel: u16) -> bool {
        self.frames.get(usize::from(channel)).copied().unwrap_or_default()
    }

    /// Returns true if the input ended like a complete file, perhaps followed by zeros.
    pub(super) fn is_whole(&self) -> bool {
        self.whole
    }

    /// Returns the current offset.
    pub(super) fn offset(&self) -> u64 {
        self.at + self.from as u64
    }

    /// Stops, discarding the rest.
    pub(super) fn stop(&mut self) {
        (self.held, self.from, self.need, self.whole, self.state) = (Vec::new(), 0, 0, true, State::Over);
    }

    fn rest(&self) -> &[u8] {
        self.held.get(self.from..).unwrap_or_default()
    }

    /// Returns the content of a record, or the first bytes of a skipped one.
    pub(super) fn body(&self, record: Record) -> &[u8] {
        let rest = self.rest();
        rest.get(HEAD..record.len.min(rest.len())).unwrap_or_default()
    }

    /// Finishes a record. If it was not `fine`, the search for the next one starts at its beginning.
    pub(super) fn went(&mut self, record: Record, fine: bool) {
        if !fine {
            self.lose();
        } else if !matches!(self.state, State::Passing(_)) {
            self.advance(record.len);
            self.data_ended |= record.op == op::DATA_END;
            if record.op == op::FOOTER {
                self.state = State::Records;
            }
        }
    }

    /// Records the time of a message outside chunks.
    pub(super) fn near(&mut self, log_ns: u64) {
        self.near_ns = Some(log_ns);
    }

    /// Adds consumed bytes to the check sum.
    fn add_up(&mut self) {
        if let (Some(sum), Some(done)) = (&mut self.sum, self.held.get(self.summed..self.from)) {
            sum.update(done);
        }
        self.summed = self.from;
    }

    /// Returns the damage that only the end of the data shows.
    fn end_of_data(&mut self, op: u8) -> Option<Step> {
        self.add_up();
        let sum = self.sum.take()?.finalize();
        let crc = self.rest().get(HEAD..).and_then(|body| Bytes(body).u32()).unwrap_or_default();
        let kind = match op {
            // The wrong length of a record has covered the end of the data.
            op::FOOTER if !self.data_ended => DamageKind::Structure,
            op::DATA_END if crc != 0 && crc != sum => DamageKind::Unlocated,
            _ => return None,
        };
        Some(Step::Damaged(Damage { place: FilePlace::Byte(self.offset()), kind, bytes: None, frames: None }))
    }

    fn advance(&mut self, count: usize) {
        self.from = (self.from + count).min(self.held.len());
        self.need = 0;
    }

    /// Begins a search, since no record is possible here.
    fn lose(&mut self) {
        self.state = State::Lost(self.offset());
        (self.whole, self.sum) = (false, None);
        self.advance(1);
    }

    /// Returns the next step. `done`: no more bytes follow.
    pub(super) fn next(&mut self, done: bool) -> Step {
        loop {
            let have = self.rest().len();
            if !done && have < self.need.max(1) {
                return Step::More;
            }
            let step = match self.state {
                State::Magic => self.magic(done),
                State::Records => self.record(done),
                State::Passing(left) => self.pass(left, done),
                State::Zeros(since) => self.zeros(since),
                State::Lost(since) => self.search(since, done),
                State::Over => self.over(done),
            };
            if let Some(step) = step {
                return step;
            }
        }
    }

    /// Requires `count` bytes; returns a step if they are missing.
    fn want(&mut self, count: usize, done: bool) -> Option<Step> {
        if self.rest().len() >= count {
            return None;
        }
        self.need = count;
        Some(if done { self.cut(0) } else { Step::More })
    }

    /// Handles the end of the input, within a record if any bytes are left.
    fn cut(&mut self, op: u8) -> Step {
        let have = self.rest().len();
        if have == 0 {
            return Step::More;
        }
        self.whole = false;
        Step::Cut(Record { at: self.offset(), op, len: have, doubtful: false })
    }

    fn magic(&mut self, done: bool) -> Option<Step> {
        if self.rest().is_empty() {
            return Some(Step::More);
        }
        if self.rest().starts_with(MAGIC) {
            (self.sum, self.summed) = (Some(Hasher::new()), self.from);
            self.advance(MAGIC.len());
            self.state = State::Records;
            (self.whole, self.data_ended) = (false, false);
            self.frames.clear();
            return Some(Step::Begin);
        }
        if MAGIC.starts_with(self.rest()) {
            return self.want(MAGIC.len(), done);
        }
        self.lose();
        None
    }

    fn over(&mut self, done: bool) -> Option<Step> {
        match self.rest() {
            [] => Some(Step::More),
            [0, ..] => {
                self.state = State::Zeros(self.offset());
                None
            }
            rest if MAGIC.starts_with(rest.get(..MAGIC.len()).unwrap_or(rest)) => {
                self.state = State::Magic;
                self.magic(done)
            }
            _ => {
                self.lose();
                None
            }
        }
    }

    fn record(&mut self, done: bool) -> Option<Step> {
        let whole = self.rest();
        match whole {
            [] => return Some(Step::More),
            [0, ..] => {
                self.state = State::Zeros(self.offset());
                return None;
            }
            [first, ..] if Some(first) == MAGIC.first() && MAGIC.starts_with(whole.get(..8).unwrap_or(whole)) => {
                if let Some(step) = self.want(MAGIC.len(), done).or_else(|| self.end_of_data(op::FOOTER)) {
                    return Some(step);
                }
                self.advance(MAGIC.len());
                (self.state, self.whole) = (State::Over, true);
                return None;
            }
            _ => {}
        }
        if let Some(step) = self.want(HEAD, done) {
            return Some(step);
        }
        let mut head = Bytes(self.rest());
        let op = head.take(1).and_then(<[u8]>::first).copied().unwrap_or_default();
        let len = head.u64().unwrap_or_default();
        let at = self.offset();
        match self.kept(op, len) {
            Kept::No => {
                self.lose();
                None
            }
            Kept::More(count) => {
                if self.rest().len() < count && !done {
                    self.need = count;
                    return Some(Step::More);
                }
                Some(self.cut(op))
            }
            Kept::Head(count) => {
                if let Some(Step::More) = self.want(HEAD + count, done) {
                    return Some(Step::More);
                }
                self.state = State::Passing((HEAD as u64).saturating_add(len));
                Some(Step::Record(Record { at, op, len: HEAD + count, doubtful: false }))
            }
            Kept::Whole { len, doubtful } => {
                let total = HEAD + len;
                if self.rest().len() < total {
                    if !done {
                        self.need = total;
                        return Some(Step::More);
                    }
                    if doubtful {
                        self.lose();
                        return None;
                    }
                    return Some(self.cut(op));
                }
                if let op::DATA_END | op::FOOTER = op
                    && let Some(step) = self.end_of_data(op)
                {
                    return Some(step);
                }
                Some(Step::Record(Record { at, op, len: total, doubtful }))
            }
        }
    }

    /// Returns the part of a record to keep, by its type and its length.
    fn kept(&self, op: u8, len: u64) -> Kept {
        let whole = |most: u64, least: u64| match usize::try_from(len) {
            Ok(len) if (least..=most).contains(&(len as u64)) => Kept::Whole { len, doubtful: false },
            _ => Kept::No,
        };
        let body = self.rest().get(HEAD..).unwrap_or_default();
        let head = |count: usize, fine: bool| if fine { Kept::Head(count) } else { Kept::No };
        match op {
            _ if self.data_ended && is_of_data(op) => Kept::No,
            op::HEADER => whole(MAX_TEXT, 8),
            op::SCHEMA => whole(MAX_TEXT, 14),
            op::CHANNEL => whole(MAX_TEXT, 16),
            op::FOOTER => whole(20, 20),
            op::DATA_END => whole(4, 4),
            op::STATISTICS => whole(MAX_TEXT, 46),
            op::CHUNK => chunk(body, len),
            op::MESSAGE => match Bytes(body).u16() {
                None if len >= 22 => Kept::More(HEAD + 2),
                Some(channel) if self.has_frames(channel) => whole(MAX_MESSAGE, 22),
                _ => head(2, (22..=MAX_RECORD).contains(&len)),
            },
            op::MESSAGE_INDEX => match index(Bytes(body)) {
                None if len >= 6 && body.len() < 6 => Kept::More(HEAD + 6),
                Some(size) => head(6, len == 6 + size),
                None => Kept::No,
            },
            op::ATTACHMENT => head(0, len < 1 << 50),
            op::SUMMARY_OFFSET => head(0, len == 17),
            0 => Kept::No,
            _ => head(0, len <= MAX_RECORD),
        }
    }

    fn pass(&mut self, left: u64, done: bool) -> Option<Step> {
        let have = self.rest().len();
        let passed = have.min(usize::try_from(left).unwrap_or(usize::MAX));
        self.advance(passed);
        let left = left - passed as u64;
        if left == 0 {
            self.state = State::Records;
            return None;
        }
        self.state = State::Passing(left);
        if done {
            self.whole = false;
        }
        Some(Step::More)
    }

    /// Skips trailing zeros, which a file system leaves after a loss of power and which are not damage.
    fn zeros(&mut self, since: u64) -> Option<Step> {
        let count = self.rest().iter().take_while(|byte| **byte == 0).count();
        self.advance(count);
        if self.rest().is_empty() {
            return Some(Step::More);
        }
        self.state = State::Lost(since);
        self.whole = false;
        None
    }

    /// Searches for the next place that is certainly a record.
    fn search(&mut self, since: u64, done: bool) -> Option<Step> {
        let rest = self.rest();
        let last = if done { rest.len() } else { rest.len().saturating_sub(LOOK) };
        let found = (0..last).find(|at| rest.get(*at..).is_some_and(|here| self.surely(here)));
        self.advance(found.unwrap_or(last));
        self.need = LOOK + 1;
        let damage = |kind, end: u64| {
            Step::Damaged(Damage { place: FilePlace::Byte(since), kind, bytes: Some(end - since), frames: None })
        };
        match found {
            Some(_) => {
                (self.state, self.need) = (State::Records, 0);
                Some(damage(DamageKind::Structure, self.offset()))
            }
            None if done => {
                let end = self.offset();
                self.stop();
                Some(damage(DamageKind::Rest, end))
            }
            None => Some(Step::More),
        }
    }

    /// Returns true if there is certainly a record here.
    fn surely(&self, here: &[u8]) -> bool {
        let mut rest = Bytes(here);
        let Some(op) = rest.take(1).and_then(<[u8]>::first) else { return false };
        if !matches!(*op, op::CHUNK | op::MESSAGE_INDEX | op::DATA_END | op::FOOTER | op::MESSAGE) {
            return false;
        }
        if self.data_ended && is_of_data(*op) {
            return false;
        }
        let Some(len) = rest.u64() else { return false };
        let after = |count: usize| rest.0.get(count..).unwrap_or_default();
        match *op {
            op::CHUNK => matches!(chunk(rest.0, len), Kept::Whole { doubtful: false, .. }),
            op::MESSAGE_INDEX => index(rest).is_some_and(|size| size > 0 && len == 6 + size),
            op::FOOTER => len == 20 && after(20).starts_with(MAGIC),
            op::DATA_END => {
                let next = after(4).first().copied().unwrap_or_default();
                len == 4 && matches!(next, op::FOOTER | op::SCHEMA | op::CHANNEL | op::CHUNK_INDEX..=op::SUMMARY_OFFSET)
            }
            _ => self.surely_message(rest, len).unwrap_or(false),
        }
    }

    fn surely_message(&self, mut body: Bytes<'_>, len: u64) -> Option<bool> {
        let channel = body.u16()?;
        body.u32()?;
        let (log, publish) = (body.u64()?, body.u64()?);
        let near = self.near_ns?;
        let known = self.has_frames(channel);
        let close = log.abs_diff(near) < NEAR_NS && publish.abs_diff(near) < NEAR_NS;
        Some(known && close && (22..=MAX_MESSAGE).contains(&len))
    }
}

/// Returns the first record in a chunk or similar bytes: its type, its content, the rest.
#[inline(always)]
pub(super) fn inner(records: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let mut rest = Bytes(records);
    let op = *rest.take(1)?.first()?;
    let len = rest.u64()?;
    let body = rest.take(usize::try_from(len).ok()?)?;
    Some((op, body, rest.0))
}

/// The part of a record to keep.
#[derive(Clone, Copy, Debug)]
enum Kept {
    /// Not a record.
    No,
    /// Unknown before this number of bytes is available.
    More(usize),
    /// The first bytes of its content; the rest is skipped.
    Head(usize),
    /// All of its content, of this length.
    Whole { len: usize, doubtful: bool },
}

/// Returns the size of a message index after its channel, if it has whole entries.
fn index(mut body: Bytes<'_>) -> Option<u64> {
    body.u16()?;
    let size = body.u32()?;
    (size % 16 == 0).then_some(u64::from(size))
}

/// Returns true for records that are possible only before the end of the data.
fn is_of_data(op: u8) -> bool {
    matches!(
        op,
        op::HEADER | op::MESSAGE | op::CHUNK | op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA | op::DATA_END
    )
}

/// Decides on a chunk, which gives its length twice: if its own is wrong, that of its content may be right.
fn chunk(body: &[u8], len: u64) -> Kept {
    let Some(head) = super::chunk::head(body) else {
        // Longer than the head of any supported chunk.
        let unknown = body.len() >= LOOK - HEAD;
        return if unknown { Kept::No } else { Kept::More(LOOK) };
    };
    let inner = head.len.saturating_add(head.size as u64);
    if !head.is_sound() || inner > MAX_RECORD {
        // An unknown compression: only the outer length is known.
        let alone = inner == len && len <= MAX_RECORD;
        return if alone { Kept::Whole { len: len as usize, doubtful: false } } else { Kept::No };
    }
    Kept::Whole { len: inner as usize, doubtful: inner != len }
}
