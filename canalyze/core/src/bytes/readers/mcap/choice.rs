//! The user's options for a file with topics: topics, clock, fields.

use crate::bytes::select::Select;

/// `--topic`, `--time-source` and `--mcap-map`.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Topics to read; all by default.
    pub topics: Select,
    /// The source of times; `None` to detect it for each topic.
    pub clock: Option<Clock>,
    /// Fields that are not found by their names.
    pub maps: Vec<Map>,
}

/// The three times of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The driver's time, `header.stamp`.
    Stamp,
    /// The time of publishing.
    Publish,
    /// The time of recording.
    Log,
}

impl Clock {
    /// All clocks by the names of `--time-source`.
    pub const NAMES: &[(&str, Clock)] = &[("stamp", Clock::Stamp), ("publish", Clock::Publish), ("log", Clock::Log)];
}

/// The role of a message's field in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// The CAN identifier, optionally with the flags of SocketCAN.
    Id,
    /// The payload.
    Data,
    /// True for an identifier of 29 bits.
    Ext,
    /// True for a remote frame.
    Rtr,
    /// True for an error frame.
    Err,
    /// The length of the payload in bytes, or its code.
    Len,
    /// True for a CAN FD frame.
    Fd,
    /// Bit rate switch.
    Brs,
    /// Error state indicator.
    Esi,
    /// The bus, as a name or number.
    Bus,
    /// The driver's time.
    Stamp,
}

impl Role {
    /// All roles by the words of `--mcap-map`.
    pub const NAMES: &[(&str, Role)] = &[
        ("id", Role::Id),
        ("ext", Role::Ext),
        ("rtr", Role::Rtr),
        ("err", Role::Err),
        ("len", Role::Len),
        ("fd", Role::Fd),
        ("brs", Role::Brs),
        ("esi", Role::Esi),
        ("data", Role::Data),
        ("bus", Role::Bus),
        ("stamp", Role::Stamp),
    ];
}

/// Fields of some topics, by their names or paths (`msg.id`).
#[derive(Clone, Debug, Default)]
pub struct Map {
    topics: Select,
    fields: Vec<(Role, String)>,
}

/// An invalid part of a `--mcap-map`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake(pub String);

impl Map {
    /// Parses `topic=/x,id=can_id,data=payload`; without `topic` it applies to all topics.
    pub fn parse(text: &str) -> Result<Self, Mistake> {
        let mut map = Self::default();
        for part in text.split(',').map(str::trim) {
            let mistake = || Mistake(part.to_owned());
            let (key, value) = part.split_once('=').ok_or_else(mistake)?;
            let (key, value) = (key.trim(), value.trim());
            if value.is_empty() {
                return Err(mistake());
            }
            if key == "topic" {
                map.topics = Select::parse(value);
                continue;
            }
            let (_, role) = Role::NAMES.iter().find(|(word, _)| *word == key).ok_or_else(mistake)?;
            map.fields.push((*role, value.to_owned()));
        }
        if map.fields.is_empty() { Err(Mistake(text.to_owned())) } else { Ok(map) }
    }
}

impl Choice {
    /// Returns the fields that the user names for a topic.
    pub(super) fn fields(&self, topic: &str) -> Vec<(Role, &str)> {
        let maps = self.maps.iter().filter(|map| map.topics.takes([topic]));
        maps.flat_map(|map| map.fields.iter().map(|(role, name)| (*role, name.as_str()))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps() {
        let map = Map::parse("topic=/x*, id=can_id ,data=msg.payload").map_err(|mistake| mistake.0);
        let choice = Choice { maps: map.into_iter().collect(), ..Choice::default() };
        assert_eq!(choice.fields("/xy"), [(Role::Id, "can_id"), (Role::Data, "msg.payload")]);
        assert_eq!(choice.fields("/y"), []);
        for (text, part) in [("", ""), ("id", "id"), ("id=", "id="), ("ident=x", "ident=x"), ("topic=/x", "topic=/x")] {
            assert_eq!(Map::parse(text).err(), Some(Mistake(part.to_owned())), "{text}");
        }
    }
}
