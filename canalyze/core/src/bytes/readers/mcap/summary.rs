//! The summary at the end of a file, where it can be read before the rest: what the file says that it holds.
//!
//! It repeats all definitions and counts the messages, under a check sum of its own. So it is asked where the data are
//! damaged, or where no check sum covers them. Must not: be believed where its check sum fails.

use std::collections::BTreeMap;
use std::ops::Range;

use super::bytes::Bytes;
use super::walk::{HEAD, MAGIC, inner, op};

/// Bytes of the footer's content, and of it before its check sum, which covers those too.
const FOOTER: usize = 20;
const BEFORE_CRC: usize = 16;

/// What a summary holds.
#[derive(Debug)]
pub(super) struct Summary {
    bytes: Box<[u8]>,
    schemas: BTreeMap<u16, Range<usize>>,
    channels: BTreeMap<u16, Range<usize>>,
    /// Messages of each channel, where it counts them.
    pub(super) messages: Option<BTreeMap<u16, u64>>,
    /// Its check sum is there and holds.
    pub(super) verified: bool,
}

impl Summary {
    /// Reads it from its first byte to the end of the file; `None` where that is no sound summary.
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        let body = bytes.strip_suffix(MAGIC)?;
        let covered = body.get(..body.len().checked_sub(FOOTER - BEFORE_CRC)?)?;
        let crc = Bytes(body.get(covered.len()..)?).u32()?;
        let footer = body.len().checked_sub(HEAD + FOOTER)?;
        let verified = crc != 0;
        if body.get(footer) != Some(&op::FOOTER) || verified && crc32fast::hash(covered) != crc {
            return None;
        }
        let mut summary =
            Self { bytes: bytes.into(), schemas: BTreeMap::new(), channels: BTreeMap::new(), messages: None, verified };
        let mut rest = body.get(..footer)?;
        while let Some((op, content, after)) = inner(rest) {
            let from = footer - rest.len() + HEAD;
            let range = from..from + content.len();
            match (op, Bytes(content).u16()) {
                (op::SCHEMA, Some(id)) => _ = summary.schemas.insert(id, range),
                (op::CHANNEL, Some(id)) => _ = summary.channels.insert(id, range),
                (op::STATISTICS, _) => summary.messages = statistics(content),
                _ => {}
            }
            rest = after;
        }
        rest.is_empty().then_some(summary)
    }

    /// The content of the record that defines a schema.
    pub(super) fn schema(&self, id: u16) -> Option<&[u8]> {
        self.schemas.get(&id).and_then(|range| self.bytes.get(range.clone()))
    }

    /// The content of the record that defines a channel.
    pub(super) fn channel(&self, id: u16) -> Option<&[u8]> {
        self.channels.get(&id).and_then(|range| self.bytes.get(range.clone()))
    }

    /// The channels that it defines.
    pub(super) fn channels(&self) -> impl Iterator<Item = u16> {
        self.channels.keys().copied()
    }
}

/// The messages of each channel; `None` where they are not told, or damaged.
pub(super) fn statistics(content: &[u8]) -> Option<BTreeMap<u16, u64>> {
    let mut rest = Bytes(content);
    let all = rest.u64()?;
    // Schemas, channels, attachments, metadata, chunks, two times.
    rest.take(2 + 4 + 4 + 4 + 4 + 8 + 8)?;
    let mut rows = Bytes(rest.counted()?);
    let mut messages = BTreeMap::new();
    while let (Some(id), Some(count)) = (rows.u16(), rows.u64()) {
        messages.insert(id, count);
    }
    let sum = messages.values().fold(0, |sum: u64, count| sum.saturating_add(*count));
    // It says all of them twice: where no check sum covers it, that tells damage.
    (sum == all).then_some(messages)
}
