//! The columns of a listing: their names in headings, and the cells of a line.

use super::pairs::{Pair, pairs};
use crate::bytes::readers::candump::lex::is_blank;

/// Maximum number of cells of a row.
const CELLS: usize = 96;

/// The content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Column {
    /// A time in units of so many ns, as a decimal number or a time of day.
    Time(i64),
    /// Ticks of 0.1 ms, in hexadecimal digits (ZLG's adapters).
    Ticks,
    /// The identifier, in this base or [`UNSAID`].
    Id(u32),
    Direction,
    /// 0 for a received frame, 1 for a sent one.
    Sent,
    Length,
    /// The code of the length, beside the length.
    Code,
    /// All bytes.
    Data,
    /// One byte.
    Byte,
    /// Words for standard or extended, data or remote.
    Attribute,
    /// True for an extended identifier.
    Extended,
    /// True for a remote frame.
    Remote,
    /// Some of the bytes, decoded: the others are elsewhere.
    Part,
    /// The channel, counted from this number.
    Channel(u8),
    /// The number of the row, or the channel if it does not count them.
    Number,
    Other,
}

use Column::{Attribute, Channel, Data, Extended, Id, Length, Other, Part, Remote, Ticks, Time};

/// The base of identifiers whose heading does not say it.
pub(super) const UNSAID: u32 = 0;
/// Maximum number of words of a name.
const WORDS: usize = 4;

pub(super) const SECOND: i64 = 1_000_000_000;
pub(super) const MILLISECOND: i64 = 1_000_000;
pub(super) const MICROSECOND: i64 = 1_000;

/// The names of columns in headings, in lower case and without what brackets say of them. Others have no meaning.
pub(super) const NAMES: &[(&str, Column)] = &[
    ("time", Time(SECOND)),
    ("timestamp", Time(SECOND)),
    ("time stamp", Time(MICROSECOND)),
    ("time offset", Time(SECOND)),
    ("时间", Time(SECOND)),
    ("系统时间", Time(SECOND)),
    ("时间标识", Ticks),
    ("id", Id(UNSAID)),
    ("can id", Id(UNSAID)),
    ("can-id", Id(UNSAID)),
    ("canid", Id(UNSAID)),
    ("cob-id", Id(UNSAID)),
    ("identifier", Id(UNSAID)),
    ("message id", Id(UNSAID)),
    ("arbitration id", Id(UNSAID)),
    ("帧id", Id(UNSAID)),
    ("id号", Id(UNSAID)),
    ("dir", Column::Direction),
    ("direction", Column::Direction),
    ("rx/tx", Column::Direction),
    ("tx/rx", Column::Direction),
    ("传输方向", Column::Direction),
    ("方向", Column::Direction),
    ("len", Length),
    ("length", Length),
    ("dlc", Length),
    ("dl", Length),
    ("数据长度", Length),
    ("长度", Length),
    ("data", Data),
    ("data bytes", Data),
    ("payload", Data),
    ("数据", Data),
    ("extended", Extended),
    ("ext", Extended),
    ("ide", Extended),
    ("format", Attribute),
    ("type", Attribute),
    ("frame type", Attribute),
    ("帧格式", Attribute),
    ("帧类型", Attribute),
    ("bus", Channel(0)),
    ("channel", Channel(1)),
    ("chn", Channel(0)),
    ("通道", Channel(1)),
    ("通道号", Channel(1)),
    ("源通道", Channel(1)),
    ("can通道", Channel(1)),
    ("timestamps", Time(SECOND)),
    ("timestampepoch", Time(SECOND)),
    ("abs time", Time(SECOND)),
    ("abs. time", Time(SECOND)),
    ("absolute time", Time(SECOND)),
    ("relative time", Time(SECOND)),
    ("rel. time", Time(SECOND)),
    ("zeit", Time(SECOND)),
    ("zeitstempel", Time(SECOND)),
    ("时间戳", Time(SECOND)),
    ("时间标签", Time(SECOND)),
    ("接收时间", Time(SECOND)),
    ("can_id", Id(UNSAID)),
    ("arbitration_id", Id(UNSAID)),
    ("arb id", Id(UNSAID)),
    ("arbid", Id(UNSAID)),
    ("message_id", Id(UNSAID)),
    ("msg id", Id(UNSAID)),
    ("msgid", Id(UNSAID)),
    ("frame id", Id(UNSAID)),
    ("frameid", Id(UNSAID)),
    ("cobid", Id(UNSAID)),
    ("cob id", Id(UNSAID)),
    ("cob_id", Id(UNSAID)),
    ("can identifier", Id(UNSAID)),
    ("报文id", Id(UNSAID)),
    ("标识符", Id(UNSAID)),
    ("databytes", Data),
    ("bytes", Data),
    ("frame data", Data),
    ("data field", Data),
    ("daten", Data),
    ("帧数据", Data),
    ("数据内容", Data),
    ("datalength", Length),
    ("data length", Length),
    ("system time", Time(SECOND)),
    ("buschannel", Channel(1)),
    ("kanal", Channel(1)),
    ("richtung", Column::Direction),
    ("länge", Length),
    ("m:s.ms.us", Time(SECOND)),
    ("laenge", Length),
    ("类型", Attribute),
    ("格式", Attribute),
    ("rtr", Remote),
    ("remote", Remote),
    ("remote frame", Remote),
    ("远程帧", Remote),
    ("sub", Part),
    ("subindex", Part),
    ("sub-index", Part),
    ("sub index", Part),
    ("子索引", Part),
    ("ts", Time(SECOND)),
    ("arbitrationid", Id(UNSAID)),
    ("can_dlc", Length),
    ("can_data", Data),
    ("is_extended_id", Extended),
    ("is_extended", Extended),
    ("is_remote_frame", Remote),
    ("is_rtr", Remote),
];

/// The separator of the cells of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Separator {
    Byte(u8),
    /// Each value has its name before it.
    Pairs,
    #[default]
    Blanks,
}

impl Column {
    /// The word in `info`.
    pub(super) fn word(self) -> &'static str {
        match self {
            Time(_) | Ticks => "time",
            Id(_) => "id",
            Self::Direction | Self::Sent => "direction",
            Length => "length",
            Data | Self::Byte => "data",
            Attribute | Extended | Remote => "format",
            Channel(_) | Self::Number => "channel",
            Other | Part | Self::Code => "-",
        }
    }

    /// Returns the column of a value with a name.
    pub(super) fn of(pair: &Pair<'_>) -> Self {
        Self::named(&String::from_utf8_lossy(pair.name).to_lowercase())
    }

    /// Returns the column with this name in a heading, in lower case.
    pub(super) fn named(name: &str) -> Self {
        let name = name.trim_start_matches(['#', ' ']);
        let (bare, said) = name.split_once(['(', '[']).unwrap_or((name, ""));
        let said = said.trim_end_matches([')', ']']);
        let (bare, said) = match bare.trim().rsplit_once(['_', ' ', '/']) {
            Some((bare, said @ ("s" | "ms" | "us" | "µs" | "ns" | "hex" | "dec" | "dez"))) => {
                (bare.trim_end_matches(['/', ' ']), said)
            }
            _ => (bare.trim(), said),
        };
        if let Some((_, column)) = NAMES.iter().find(|(known, _)| *known == bare) {
            return match (column, said) {
                (Id(_), "dec" | "dez") => Id(10),
                (Id(_), "hex") => Id(16),
                (Time(_), "s") => Time(SECOND),
                (Time(_), "ms") => Time(MILLISECOND),
                (Time(_), "us" | "µs") => Time(MICROSECOND),
                (Time(_), "ns") => Time(1),
                _ => *column,
            };
        }
        let number = ["data", "byte", "d", "b"].iter().find_map(|prefix| name.strip_prefix(prefix));
        let number = number.map(str::trim).filter(|number| !number.is_empty() && number.len() <= 2);
        if number.is_some_and(|number| number.bytes().all(|digit| digit.is_ascii_digit())) { Self::Byte } else { Other }
    }
}

/// Returns the names in a heading, in lower case. Between blanks a name may have several words, as `Time [s]` and `CAN ID`.
pub(super) fn names(text: &[u8], separator: Separator) -> Vec<String> {
    let words: Vec<String> =
        cells(text, separator).iter().map(|word| String::from_utf8_lossy(word).to_lowercase()).collect();
    let mut names = Vec::new();
    let mut rest = words.as_slice();
    while let [first, others @ ..] = rest {
        let joined = |count: usize| {
            let name = rest.get(..count)?.join(" ");
            let whole = name.find([')', ']']).is_none_or(|end| end + 1 == name.len()) && first != "#";
            (whole && Column::named(&name) != Other).then_some((name, rest.get(count..)?))
        };
        let most = if separator == Separator::Blanks { WORDS } else { 1 };
        let (name, behind) = (2..=most).rev().find_map(joined).unwrap_or_else(|| (first.clone(), others));
        names.push(name);
        rest = behind;
    }
    names
}

/// Returns the cells of a line, without quotation marks and blanks around them.
pub(super) fn cells(text: &[u8], separator: Separator) -> Vec<&[u8]> {
    let parts: Vec<&[u8]> = match separator {
        Separator::Byte(sign) => {
            let mut quoted = false;
            let between = |byte: &u8| {
                quoted ^= *byte == b'"';
                *byte == sign && !quoted
            };
            text.split(between).take(CELLS).collect()
        }
        Separator::Pairs => pairs(text).map(|pair| pair.value).take(CELLS).collect(),
        Separator::Blanks => {
            let words = text.split(|byte| is_blank(*byte)).map(bare);
            return words.filter(|cell| !cell.is_empty()).take(CELLS).collect();
        }
    };
    parts.into_iter().map(bare).collect()
}

/// Returns a cell without what spreadsheets put around it: blanks, quotation marks, `=`, `x|`.
pub(super) fn bare(mut cell: &[u8]) -> &[u8] {
    loop {
        cell = cell.trim_ascii();
        cell = match cell {
            [b'`', inner @ .., b'`'] => inner,
            [b'=', b'"', inner @ .., b'"'] | [b'"', inner @ .., b'"'] => inner,
            [b'x' | b'X', b'|', inner @ ..] => inner,
            _ => return cell,
        };
    }
}
