//! Messages that cannot be read yet: of a channel that is not known, whose type is not, or of which only a damaged
//! chunk tells. A sound definition may come later; files repeat them at their end.
//!
//! Bounded: what there is no room for is only counted. Must not: know what a channel is.

use std::collections::BTreeMap;

/// Messages are kept for so many bytes.
const MOST: usize = 64 << 20;
/// A message that has less is not all there: of what nobody reads the walk keeps only the beginning.
const LEAST: usize = 22;

/// Messages by channel.
#[derive(Debug, Default)]
pub(super) struct Waiting {
    channels: BTreeMap<u16, Channel>,
    /// Memory of them.
    size: usize,
    /// How many came so far.
    came: u64,
}

/// Those of one channel.
#[derive(Debug)]
struct Channel {
    held: Vec<Message>,
    /// Those that there was no room for.
    lost: u64,
    /// Where the first stands.
    at: u64,
}

/// One of them.
#[derive(Debug)]
pub(super) struct Message {
    /// Its place among all.
    number: u64,
    /// Where it stands.
    pub(super) at: u64,
    pub(super) body: Box<[u8]>,
}

impl Waiting {
    /// Whether there is room for one more of this size.
    pub(super) fn has_room(&self, body: &[u8]) -> bool {
        self.size + cost(body) <= MOST
    }

    /// Keeps a message, or only counts it.
    pub(super) fn push(&mut self, channel: u16, body: &[u8], at: u64) {
        let room = body.len() >= LEAST && self.has_room(body);
        let one = self.channels.entry(channel).or_insert_with(|| Channel { held: Vec::new(), lost: 0, at });
        if room {
            self.size += cost(body);
            self.came += 1;
            one.held.push(Message { number: self.came, at, body: body.into() });
        } else {
            one.lost += 1;
        }
    }

    /// Gives those of these channels, in the order in which they came; what was only counted stays.
    pub(super) fn take(&mut self, channels: &[u16]) -> Vec<Message> {
        let mut messages = Vec::new();
        for id in channels {
            if let Some(one) = self.channels.get_mut(id) {
                self.size -= one.held.iter().map(|message| cost(&message.body)).sum::<usize>();
                messages.append(&mut one.held);
                if one.lost == 0 {
                    self.channels.remove(id);
                }
            }
        }
        messages.sort_by_key(|message| message.number);
        messages
    }

    /// Messages of a channel that wait, or were only counted.
    pub(super) fn count(&self, channel: u16) -> u64 {
        self.channels.get(&channel).map_or(0, |one| one.held.len() as u64 + one.lost)
    }

    /// All channels, with where their first message stands.
    pub(super) fn rest(&self) -> impl Iterator<Item = (u16, u64)> {
        self.channels.iter().map(|(id, one)| (*id, one.at))
    }
}

fn cost(body: &[u8]) -> usize {
    body.len() + size_of::<Message>() + 16
}
