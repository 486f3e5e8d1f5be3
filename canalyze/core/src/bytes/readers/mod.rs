//! The readers of capture formats, one file or folder for each: push parsers that accept bytes in any chunking.
//!
//! A reader sees only `frame`: it knows no CANopen, does no I/O, and never fails, but reports what it cannot read.
//! `sniff` detects the format by the first bytes. A new format needs a file, a row of [`InputFormat`], an arm of
//! [`Reader`], and its signature in `sniff`.

pub mod asc;
pub mod blf;
pub mod candump;
mod lines;
pub mod listing;
pub mod live;
pub mod mcap;
pub mod packed;
pub mod pcap;
pub mod rows;
pub mod sniff;
pub mod trc;

use self::asc::Asc;
use self::blf::Blf;
use self::candump::{Candump, Stamps};
use self::live::Live;
use self::mcap::Mcap;
use self::packed::Packed;
use self::pcap::Pcap;
use self::rows::Rows;
use self::trc::Trc;
use crate::bytes::frame::{BusId, Buses, Frame, Stamp};
use crate::bytes::ns::Ns;

/// The formats that this crate reads. Their names are those of `--input-format`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InputFormat {
    /// Text of can-utils, in log and console form.
    #[default]
    Candump,
    /// Records of another program's reader; not a file format, and so without a name.
    Packed,
    /// Live buses; not a file format, and so without a name.
    Live,
    /// Vector's ASC log.
    Asc,
    /// Vector's binary log.
    Blf,
    /// MCAP, as recorded by ROS.
    Mcap,
    /// pcap and pcapng, which the reader distinguishes.
    Pcap,
    /// Rows that other programs list.
    Rows,
    /// PEAK's trace.
    Trc,
}

impl InputFormat {
    /// All file formats by their names.
    pub const NAMES: &[(&str, InputFormat)] = &[
        ("candump", InputFormat::Candump),
        ("asc", InputFormat::Asc),
        ("blf", InputFormat::Blf),
        ("mcap", InputFormat::Mcap),
        ("pcap", InputFormat::Pcap),
        ("pcapng", InputFormat::Pcap),
        ("rows", InputFormat::Rows),
        ("trc", InputFormat::Trc),
    ];
}

/// Options for reading a file.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The meaning of small stamps of candump's console form, and of all stamps of rows.
    pub stamps: Stamps,
    /// True for a complete file and not a pipe: its beginning may decide the dialect, so output may lag.
    pub regular: bool,
    /// The choice of topics of an MCAP file.
    pub mcap: mcap::Choice,
}

/// The reader of one file.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one for each file")]
pub enum Reader {
    /// Text of can-utils.
    Candump(Candump),
    /// Records of another program's reader.
    Packed(Packed),
    /// Live buses.
    Live(Live),
    /// Vector's ASC log.
    Asc(Asc),
    /// Vector's binary log.
    Blf(Blf),
    /// MCAP.
    Mcap(Mcap),
    /// pcap and pcapng.
    Pcap(Pcap),
    /// Rows of a listing.
    Rows(Rows),
    /// PEAK's trace.
    Trc(Trc),
}

impl Reader {
    /// Creates a reader at the beginning of a file.
    pub fn new(format: InputFormat, settings: &Settings) -> Self {
        match format {
            InputFormat::Candump => Self::Candump(Candump::new(settings.stamps, settings.regular)),
            InputFormat::Packed => Self::Packed(Packed::default()),
            InputFormat::Live => Self::Live(Live::default()),
            InputFormat::Asc => Self::Asc(Asc::default()),
            InputFormat::Blf => Self::Blf(Blf::default()),
            InputFormat::Mcap => Self::Mcap(Mcap::new(settings.mcap.clone())),
            InputFormat::Pcap => Self::Pcap(Pcap::default()),
            InputFormat::Rows => Self::Rows(Rows::new(settings.stamps, settings.regular)),
            InputFormat::Trc => Self::Trc(Trc::default()),
        }
    }

    /// Returns true if it reads live buses, whose items are passed on at once.
    pub fn is_live(&self) -> bool {
        matches!(self, Self::Live(_))
    }

    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(&mut Item, &Buses)) {
        let sink = &mut |mut item: Item, buses: &Buses| {
            item.refuse_further_bus();
            sink(&mut item, buses);
        };
        match self {
            Self::Candump(reader) => reader.feed(bytes, buses, sink),
            Self::Packed(reader) => reader.feed(bytes, buses, sink),
            Self::Live(reader) => reader.feed(bytes, buses, sink),
            Self::Asc(reader) => reader.feed(bytes, buses, sink),
            Self::Blf(reader) => reader.feed(bytes, buses, sink),
            Self::Mcap(reader) => reader.feed(bytes, buses, sink),
            Self::Pcap(reader) => reader.feed(bytes, buses, sink),
            Self::Rows(reader) => reader.feed(bytes, buses, sink),
            Self::Trc(reader) => reader.feed(bytes, buses, sink),
        }
    }

    /// Returns true if rows wait until later ones show their layout.
    pub fn holds(&self) -> bool {
        matches!(self, Self::Rows(reader) if reader.holds())
    }

    /// Reads what waits, since a pipe has come to a rest.
    pub fn rest(&mut self, buses: &mut Buses, sink: &mut impl FnMut(&mut Item, &Buses)) {
        if let Self::Rows(reader) = self {
            reader.rest(buses, &mut |mut item: Item, buses: &Buses| {
                item.refuse_further_bus();
                sink(&mut item, buses);
            });
        }
    }

    /// Ends the file.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(&mut Item, &Buses)) {
        let sink = &mut |mut item: Item, buses: &Buses| {
            item.refuse_further_bus();
            sink(&mut item, buses);
        };
        match self {
            Self::Candump(reader) => reader.finish(buses, sink),
            Self::Packed(reader) => reader.finish(buses, sink),
            Self::Live(reader) => reader.finish(buses, sink),
            Self::Asc(reader) => reader.finish(buses, sink),
            Self::Blf(reader) => reader.finish(buses, sink),
            Self::Mcap(reader) => reader.finish(buses, sink),
            Self::Pcap(reader) => reader.finish(buses, sink),
            Self::Rows(reader) => reader.finish(buses, sink),
            Self::Trc(reader) => reader.finish(buses, sink),
        }
    }

    /// Ends an interrupted file, whose incomplete end is not a fault of the file.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(&mut Item, &Buses)) {
        let sink = &mut |mut item: Item, buses: &Buses| {
            item.refuse_further_bus();
            sink(&mut item, buses);
        };
        match self {
            Self::Candump(reader) => reader.interrupt(buses, sink),
            Self::Packed(reader) => reader.interrupt(buses, sink),
            Self::Live(reader) => reader.interrupt(buses, sink),
            Self::Asc(reader) => reader.interrupt(buses, sink),
            Self::Blf(reader) => reader.interrupt(buses, sink),
            Self::Mcap(reader) => reader.interrupt(buses, sink),
            Self::Pcap(reader) => reader.interrupt(buses, sink),
            Self::Rows(reader) => reader.interrupt(buses, sink),
            Self::Trc(reader) => reader.interrupt(buses, sink),
        }
    }

    /// Returns the facts about the file beyond its frames, for `info`.
    pub fn contents(&self) -> Contents {
        match self {
            Self::Candump(_) | Self::Live(_) => Contents::default(),
            Self::Packed(reader) => reader.contents(),
            Self::Asc(reader) => reader.contents(),
            Self::Blf(reader) => reader.contents(),
            Self::Mcap(reader) => reader.contents(),
            Self::Pcap(reader) => reader.contents(),
            Self::Rows(reader) => reader.contents(),
            Self::Trc(reader) => reader.contents(),
        }
    }
}

/// An item of a capture, in order.
#[derive(Clone, Copy, Debug)]
pub enum Item {
    /// A frame; its `no` is 0 until the session sets it.
    Frame(Frame),
    /// A statement about the capture itself.
    Marker(Marker),
    /// Something that should be a frame but is unreadable.
    Unreadable {
        /// Its place.
        place: FilePlace,
        /// The reason.
        reason: Unreadable,
    },
    /// A lost part of the file.
    Damaged(Damage),
    /// A live bus cannot be received from here on: frames may be missing, without a finding.
    Gap {
        /// The bus.
        bus: BusId,
        /// True if the bus may be away for long, so that more than a few frames are missing.
        away: bool,
    },
    /// All frames of live buses with this stamp or an earlier one have come: the time on their clock.
    Until {
        /// In ns.
        now_ns: Ns,
    },
}

impl Item {
    /// Makes the item an unreadable one if its bus is beyond the maximum number.
    #[inline]
    pub fn refuse_further_bus(&mut self) {
        let (bus, line) = match self {
            Self::Frame(frame) => (frame.bus, frame.line),
            Self::Gap { bus, .. } => (*bus, None),
            Self::Marker(Marker::Dropped { bus, place, .. } | Marker::Error { bus, place, .. }) => (*bus, place.line()),
            _ => return,
        };
        if bus == BusId::BEYOND {
            let place = line.map_or(FilePlace::Live, FilePlace::Line);
            *self = Self::Unreadable { place, reason: Unreadable::Bus };
        }
    }
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FilePlace {
    /// A line, from 1.
    Line(u64),
    /// An offset in bytes, from 0, in a file without lines.
    Byte(u64),
    /// None: a frame of a live bus, or a record whose place is no longer known.
    Live,
}

impl FilePlace {
    /// Returns the line; `None` in a file without lines.
    pub fn line(self) -> Option<u64> {
        match self {
            Self::Line(line) => Some(line),
            Self::Byte(_) | Self::Live => None,
        }
    }
}

/// An unreadable part of a damaged file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Its beginning.
    pub place: FilePlace,
    /// Its kind.
    pub kind: DamageKind,
    /// Number of skipped bytes of the file, if known.
    pub bytes: Option<u64>,
    /// Number of frames lost, or possibly wrong if the kind says so; `None` if unknown.
    pub frames: Option<u64>,
}

/// The kind of a damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamageKind {
    /// The file ends within a record, since the recording program was ended. Everything before is complete.
    Cut,
    /// A check sum does not match; the covered part was skipped.
    Checksum,
    /// An impossible length or type; the affected part was skipped.
    Structure,
    /// Data that cannot be decompressed; they were skipped.
    Compression,
    /// The rest of the file cannot be read.
    Rest,
    /// Messages of a topic whose definition, or whose type's, is lost or cannot be used.
    Undefined,
    /// Decompressed data from here on may be wrong: their check sum fails or cannot be reached.
    Doubtful,
    /// Definitions of types or topics that contradict each other, so the frames read by the first may be wrong.
    Definition,
    /// The file states more messages than were found.
    Missing,
    /// The file states fewer messages than were found.
    Excess,
    /// The check sum over all data of the file does not match, at an unknown place; any data may be wrong.
    Unlocated,
}

/// The facts about a file beyond its frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// Properties of the dialect: a word of the format (`base`, `profile`) and its value.
    pub dialect: Vec<(&'static str, Vec<u8>)>,
    /// Counts of content other than frames, by kind in the words of the format. At most 64 kinds, the last one being
    /// `...` for all others.
    pub passed_over: Vec<(Vec<u8>, u64)>,
    /// Topics or channels.
    pub topics: Vec<Topic>,
}

/// A topic or channel of a capture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: Vec<u8>,
    /// The type of its messages.
    pub schema: Vec<u8>,
    /// The encoding of schema and messages: `ros2msg/cdr`.
    pub encoding: Vec<u8>,
    /// Number of messages.
    pub messages: u64,
    /// The fields by which its messages are read as frames; empty if they are not.
    pub read_as: Vec<u8>,
    /// The bus of its frames; empty if there is none.
    pub bus: Vec<u8>,
}

/// A line or record about the capture itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// The date from which stamps count from here on. Without one they are absolute or count from zero.
    Start {
        /// ns since 1970-01-01: UTC if the format says so, otherwise local civil time as if it were UTC.
        date_ns: Ns,
    },
    /// A gap: the capturing program lost frames.
    Dropped {
        /// The bus.
        bus: BusId,
        /// Number of lost frames, as reported.
        count: u64,
        /// Total number so far, as reported.
        total: u64,
        /// The place of the report.
        place: FilePlace,
    },
    /// The file itself shows that frames are missing here, on an unknown bus: by a jump of its row numbers or by a
    /// line.
    LeftOut {
        /// Number of rows, if known, including rows that are not frames.
        count: Option<u64>,
        /// The numbers of the rows before and after the gap, if known.
        rows: Option<(u64, u64)>,
        /// The place.
        place: FilePlace,
    },
    /// The identifiers of the file are in the wrong byte order and are read accordingly.
    Swapped,
    /// An error marker without any content (`can0  ERROR`).
    Error {
        /// The bus.
        bus: BusId,
        /// Its stamp, if any.
        stamp: Option<Stamp>,
        /// The place.
        place: FilePlace,
    },
    /// Stamps of a pipe, assumed to count from zero, went backward: they may be differences (`-t d`).
    Backward {
        /// The place.
        place: FilePlace,
    },
}

/// The reason why a line or record is unreadable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// The line is neither a frame of any known dialect nor a comment.
    NoFrame,
    /// The identifier is out of range for its number of digits, or has impossible flag bits.
    Identifier,
    /// The length is out of range, or not one of a CAN FD frame.
    Length,
    /// Fewer data bytes than the length says, or a byte that is not a number.
    Data,
    /// The line ends within a frame: the capture was cut.
    Cut,
    /// A CAN XL frame.
    CanXl,
    /// Its bus is beyond the maximum number.
    Bus,
    /// The cell at this place, from 1, should be an identifier.
    NoIdentifier {
        /// Its place in the row.
        cell: u64,
    },
    /// The bytes are in several columns or rows that are not understood.
    Spread,
    /// The identifiers may be hexadecimal or decimal.
    Base {
        /// One of them, read as hexadecimal.
        hexadecimal: u32,
        /// The same, read as decimal.
        decimal: u32,
    },
    /// A row of a table that this program exported.
    Exported,
}

/// Processes bytes in any chunking: `take` gets the leftover `rest` followed by `bytes` and returns the number of bytes
/// consumed. Returns the new leftover; bytes are copied only if there is one.
fn in_pieces(mut rest: Vec<u8>, bytes: &[u8], mut take: impl FnMut(&[u8]) -> usize) -> Vec<u8> {
    if rest.is_empty() {
        let used = take(bytes);
        rest.extend_from_slice(bytes.get(used..).unwrap_or_default());
    } else {
        rest.extend_from_slice(bytes);
        let used = take(&rest);
        rest.drain(..used);
    }
    rest
}
