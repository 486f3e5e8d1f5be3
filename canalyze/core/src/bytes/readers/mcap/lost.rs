//! The lost parts of a file: a damaged chunk until its messages are counted, and missing messages by the file's counts.
//!
//! Message indexes follow their chunk and give its number of messages; the statistics at the end give the total. No
//! message is counted both as lost and as missing.

use std::collections::BTreeMap;

use super::bytes::Bytes;
use super::defined::Defined;
use crate::bytes::readers::Damage;

/// The losses of one file.
#[derive(Debug, Default)]
pub(super) struct Lost {
    /// A damaged chunk, until the number of its frames is known.
    bad: Option<Bad>,
    /// Reported messages of damaged chunks, by channel.
    frames: BTreeMap<u16, u64>,
    /// Number of messages of each channel, as given by the file.
    pub(super) counted: Option<BTreeMap<u16, u64>>,
    /// True if a damage of the file has been reported.
    pub(super) reported: bool,
}

#[derive(Debug)]
struct Bad {
    damage: Damage,
    /// Its messages by the indexes so far: channel and number.
    indexed: Vec<(u16, u64)>,
}

impl Lost {
    /// Adds a damaged chunk, whose indexes may follow.
    pub(super) fn chunk(&mut self, damage: Damage) {
        self.bad = Some(Bad { damage, indexed: Vec::new() });
    }

    /// Adds a message index: the number of messages of this channel in the preceding chunk.
    pub(super) fn index(&mut self, id: u16, count: u64) {
        if let Some(bad) = &mut self.bad {
            bad.indexed.push((id, count));
        }
    }

    /// Returns the damage of the chunk, completed, after its last index.
    pub(super) fn settle(&mut self, defined: &Defined) -> Option<Damage> {
        let bad = self.bad.take()?;
        let frames = |id: u16, count| match defined.channel(id) {
            Some(channel) if channel.plan.is_some() => Some(count),
            Some(channel) if !channel.lacking => Some(0),
            _ => None,
        };
        let each: Option<Vec<u64>> = bad.indexed.iter().map(|(id, count)| frames(*id, *count)).collect();
        let frames = each.filter(|each| !each.is_empty()).map(|each| each.iter().sum());
        if frames.is_some() {
            for (id, count) in bad.indexed {
                *self.frames.entry(id).or_default() += count;
            }
        }
        Some(Damage { frames, ..bad.damage })
    }

    /// Returns the number of frames that the file counts but that neither came nor are known to be lost.
    pub(super) fn missing(&self, defined: &Defined) -> Option<u64> {
        let (counted, found) = (self.counted.as_ref()?, defined.messages());
        let missing = counted.iter().map(|(id, count)| {
            let frames = defined.channel(*id).is_none_or(|channel| channel.plan.is_some());
            let all = [&found, &self.frames].map(|of| of.get(id).copied().unwrap_or_default());
            if frames { count.saturating_sub(all.iter().sum()) } else { 0 }
        });
        let missing = missing.fold(0, u64::saturating_add);
        // A channel that the file does not count is one of the others, whose number is damaged.
        let strange = found.iter().filter(|(id, _)| !counted.contains_key(id)).map(|(_, count)| count).sum();
        Some(missing.saturating_sub(strange)).filter(|missing| *missing > 0)
    }

    /// Returns the number of frames beyond those that the file counts: a part of it is there twice.
    pub(super) fn excess(&self, defined: &Defined) -> Option<u64> {
        let (counted, found) = (self.counted.as_ref()?, defined.messages());
        let excess = counted.iter().map(|(id, count)| {
            let frames = defined.channel(*id).is_some_and(|channel| channel.plan.is_some());
            if frames { found.get(id).copied().unwrap_or_default().saturating_sub(*count) } else { 0 }
        });
        Some(excess.fold(0, u64::saturating_add)).filter(|excess| *excess > 0)
    }
}

/// Parses the number of messages of each channel; `None` if the record has none or is damaged.
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
    // The total repeats the sum, which shows damage without a check sum.
    (sum == all).then_some(messages)
}
