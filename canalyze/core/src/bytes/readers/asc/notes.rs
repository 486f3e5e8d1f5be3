//! Comment lines that this program's writer leaves for its reader, with content that has no column.
//!
//! For example `// canalyze: channel 1 is vcan0`. Since they may come from any file, only these exact forms are
//! accepted. They are written and read here, so that both sides agree.

use super::AscChannel;
use super::words::{LineWords, number};
use crate::bytes::frame::{CanId, MAX_BUS_NAME};
use crate::bytes::readers::candump::lex::{byte, nibble};

/// The beginning of each note.
const SIGN: &[u8] = b"// canalyze: ";

/// The content of a note.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Note {
    /// The name of the bus of a channel.
    Channel(AscChannel, Vec<u8>),
    /// The stamps count from zero, and the dates of the file are not real.
    NoDate,
    /// True if the following directions are real, false if they are only placeholders of the format.
    Directions(bool),
    /// True if the following stamps are real, false if they are only placeholders of the format.
    Stamps(bool),
    /// Class and data of the error frame on the next line.
    Error(CanId, Vec<u8>),
    /// Lost frames: their number, channel, and total number.
    Dropped(u64, AscChannel, u64),
    /// Rows left out, and their number if known.
    LeftOut(Option<u64>),
}

impl Note {
    /// Appends it as a line.
    pub(crate) fn write(&self, out: &mut Vec<u8>) {
        use std::io::Write;

        out.extend_from_slice(SIGN);
        // Writing to memory does not fail.
        let _ = match self {
            Self::Channel(channel, name) => write!(out, "channel {channel} is {}", escaped(name)),
            Self::NoDate => write!(out, "no date"),
            Self::Directions(known) => write!(out, "directions {}", if *known { "known" } else { "unknown" }),
            Self::Stamps(known) => write!(out, "stamps {}", if *known { "known" } else { "unknown" }),
            Self::Error(class, data) => {
                let _ = write!(out, "error {:08X}", class.raw());
                data.iter().try_for_each(|byte| write!(out, " {byte:02X}"))
            }
            Self::LeftOut(Some(count)) => write!(out, "{count} rows left out"),
            Self::LeftOut(None) => write!(out, "rows left out"),
            Self::Dropped(count, channel, total) => {
                write!(out, "dropped {count} on channel {channel}, {total} in total")
            }
        };
        out.push(b'\n');
    }

    /// Parses a comment line; `None` if it is not a note.
    pub(super) fn read(line: &[u8]) -> Option<Self> {
        let mut words = LineWords::new(line.strip_prefix(SIGN)?);
        let note = match words.next()? {
            b"channel" => {
                let channel = channel(words.next()?)?;
                (words.next()? == b"is").then_some(())?;
                Self::Channel(channel, unescaped(words.next()?)?)
            }
            b"no" if words.next()? == b"date" => Self::NoDate,
            b"directions" => Self::Directions(known(words.next()?)?),
            b"stamps" => Self::Stamps(known(words.next()?)?),
            b"error" => {
                let class = u32::try_from(number(words.next()?, false)?).ok().filter(|class| *class < 1 << 29)?;
                let mut data = Vec::new();
                while let Some(word) = words.next() {
                    let &[high, low] = word else { return None };
                    data.push(byte(high, low).filter(|_| data.len() < 8)?);
                }
                Self::Error(CanId::extended(class), data)
            }
            b"dropped" => {
                let count = count(words.next()?)?;
                (words.next()? == b"on" && words.next()? == b"channel").then_some(())?;
                let channel = channel(words.next()?.strip_suffix(b",")?)?;
                let total = count_of_total(&mut words)?;
                Self::Dropped(count, channel, total)
            }
            first => {
                let counted = count(first);
                let rows = if counted.is_some() { words.next()? } else { first };
                (rows == b"rows" && words.next()? == b"left" && words.next()? == b"out").then_some(())?;
                Self::LeftOut(counted)
            }
        };
        words.is_empty().then_some(note)
    }
}

fn count_of_total(words: &mut LineWords<'_>) -> Option<u64> {
    let total = count(words.next()?)?;
    (words.next()? == b"in" && words.next()? == b"total").then_some(total)
}

fn count(word: &[u8]) -> Option<u64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn known(word: &[u8]) -> Option<bool> {
    match word {
        b"known" => Some(true),
        b"unknown" => Some(false),
        _ => None,
    }
}

/// Parses the number of a channel.
pub(super) fn channel(word: &[u8]) -> Option<AscChannel> {
    (word.len() <= 5).then(|| number(word, true)).flatten().and_then(|number| AscChannel::try_from(number).ok())
}

/// Returns a bus name in graphic ASCII characters, all others as `%` and two digits.
fn escaped(name: &[u8]) -> String {
    let mut out = String::new();
    for &byte in name {
        if byte.is_ascii_graphic() && byte != b'%' {
            out.push(char::from(byte));
        } else {
            out.push_str(&format!("%{byte:02X}"));
        }
    }
    out
}

fn unescaped(mut word: &[u8]) -> Option<Vec<u8>> {
    let mut name = Vec::new();
    while let Some((&first, rest)) = word.split_first() {
        word = rest;
        name.push(match (first, rest) {
            (b'%', [high, low, rest @ ..]) if nibble(*high) | nibble(*low) < 16 => {
                word = rest;
                byte(*high, *low)?
            }
            (b'%', _) => return None,
            _ => first,
        });
    }
    (!name.is_empty() && name.len() <= MAX_BUS_NAME).then_some(name)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

    use super::{CanId, Note};

    #[test]
    fn what_is_written_is_read() {
        for (note, line) in [
            (Note::Channel(1, b"vcan0".to_vec()), "// canalyze: channel 1 is vcan0\n"),
            (Note::Channel(300, b"100% \n".to_vec()), "// canalyze: channel 300 is 100%25%20%0A\n"),
            (Note::NoDate, "// canalyze: no date\n"),
            (Note::Directions(false), "// canalyze: directions unknown\n"),
            (Note::Stamps(true), "// canalyze: stamps known\n"),
            (Note::Error(CanId::extended(0x88), vec![0, 0xA]), "// canalyze: error 00000088 00 0A\n"),
            (Note::LeftOut(Some(6)), "// canalyze: 6 rows left out\n"),
            (Note::LeftOut(None), "// canalyze: rows left out\n"),
            (Note::Dropped(3, 1, 5), "// canalyze: dropped 3 on channel 1, 5 in total\n"),
        ] {
            let mut out = Vec::new();
            note.write(&mut out);
            assert_eq!(String::from_utf8_lossy(&out), line);
            assert_eq!(Note::read(line.trim_end().as_bytes()), Some(note));
        }
    }

    #[test]
    fn anything_else_is_a_comment() {
        for line in [
            "// canalyze: channel 1 is",
            "// canalyze: channel x is can0",
            "// canalyze: channel 70000 is can0",
            "// canalyze: channel 1 is a b",
            "// canalyze: channel 1 is %4",
            "// canalyze: channel 1 is %zz",
            "// canalyze: channel 1 is 0123456789012345678901234567890123",
            "// canalyze: no dates",
            "// canalyze: error FFFFFFFF",
            "// canalyze: error 0 00 00 00 00 00 00 00 00 00",
            "// canalyze: dropped many on channel 1, 5 in total",
            "// canalyze: rows left",
            "// canalyze: many rows left out",
            "// canalyze:",
            "// version 9.0.0",
        ] {
            assert_eq!(Note::read(line.as_bytes()), None, "{line}");
        }
    }
}
