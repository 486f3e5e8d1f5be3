//! Capture formats: one file (or folder) a format, each a push parser that takes bytes in any chunking.
//!
//! A reader sees only `frame`: it knows no CANopen, does no I/O, and never fails. What it cannot read it says. Which
//! format an input has is told by its first bytes, in `sniff`. A new format is a file here, a row of [`Format`], an
//! arm of [`Reader`], and its sign in `sniff`.

pub mod asc;
pub mod candump;
mod lines;
pub mod listing;
pub mod live;
pub mod mcap;
pub mod packed;
pub mod pcap;
pub mod sniff;

use self::asc::Asc;
use self::candump::{Candump, Stamps};
use self::live::Live;
use self::mcap::Mcap;
use self::packed::Packed;
use self::pcap::Pcap;
use crate::frame::{BusId, Buses, Frame, Stamp};

/// Formats that this crate reads. Their names are those of `--input-format`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// can-utils' text, log and console form.
    #[default]
    Candump,
    /// Records of another program's reader; no format of files, so not among the names.
    Packed,
    /// What comes from live buses; no format of files, so not among the names.
    Live,
    /// Vector's text.
    Asc,
    /// MCAP, as ROS records it.
    Mcap,
    /// pcap and pcapng: one reader, which tells them apart itself.
    Pcap,
}

impl Format {
    /// All of them, with their names.
    pub const NAMES: &[(&str, Format)] = &[
        ("candump", Format::Candump),
        ("asc", Format::Asc),
        ("mcap", Format::Mcap),
        ("pcap", Format::Pcap),
        ("pcapng", Format::Pcap),
    ];
}

/// How a file is read.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// What small stamps of candump's console form mean.
    pub stamps: Stamps,
    /// It is a whole file, not a pipe: dialects may be decided on its beginning, so output may lag.
    pub regular: bool,
    /// What of an MCAP file is read, and how.
    pub mcap: mcap::Choice,
}

/// The reader of one file.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one for each file")]
pub enum Reader {
    /// can-utils' text.
    Candump(Candump),
    /// Records of another program's reader.
    Packed(Packed),
    /// What comes from live buses.
    Live(Live),
    /// Vector's text.
    Asc(Asc),
    /// MCAP.
    Mcap(Mcap),
    /// pcap and pcapng.
    Pcap(Pcap),
}

impl Reader {
    /// A reader at the beginning of a file.
    pub fn new(format: Format, settings: &Settings) -> Self {
        match format {
            Format::Candump => Self::Candump(Candump::new(settings.stamps, settings.regular)),
            Format::Packed => Self::Packed(Packed::default()),
            Format::Live => Self::Live(Live::default()),
            Format::Asc => Self::Asc(Asc::default()),
            Format::Mcap => Self::Mcap(Mcap::new(settings.mcap.clone())),
            Format::Pcap => Self::Pcap(Pcap::default()),
        }
    }

    /// Whether it reads live buses: what they give is handed on at once.
    pub fn is_live(&self) -> bool {
        matches!(self, Self::Live(_))
    }

    /// Takes the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let sink = &mut |item: Item, buses: &Buses| sink(item.on_known_bus(), buses);
        match self {
            Self::Candump(reader) => reader.feed(bytes, buses, sink),
            Self::Packed(reader) => reader.feed(bytes, buses, sink),
            Self::Live(reader) => reader.feed(bytes, buses, sink),
            Self::Asc(reader) => reader.feed(bytes, buses, sink),
            Self::Mcap(reader) => reader.feed(bytes, buses, sink),
            Self::Pcap(reader) => reader.feed(bytes, buses, sink),
        }
    }

    /// Takes the end of the file.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let sink = &mut |item: Item, buses: &Buses| sink(item.on_known_bus(), buses);
        match self {
            Self::Candump(reader) => reader.finish(buses, sink),
            Self::Packed(reader) => reader.finish(buses, sink),
            Self::Live(reader) => reader.finish(buses, sink),
            Self::Asc(reader) => reader.finish(buses, sink),
            Self::Mcap(reader) => reader.finish(buses, sink),
            Self::Pcap(reader) => reader.finish(buses, sink),
        }
    }

    /// Takes the end of what was read so far, where the reading was broken off: what is incomplete is no fault of the
    /// file.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let sink = &mut |item: Item, buses: &Buses| sink(item.on_known_bus(), buses);
        match self {
            Self::Candump(reader) => reader.interrupt(buses, sink),
            Self::Packed(reader) => reader.interrupt(buses, sink),
            Self::Live(reader) => reader.interrupt(buses, sink),
            Self::Asc(reader) => reader.interrupt(buses, sink),
            Self::Mcap(reader) => reader.interrupt(buses, sink),
            Self::Pcap(reader) => reader.interrupt(buses, sink),
        }
    }

    /// What it knows of the file beyond frames, for `info`.
    pub fn contents(&self) -> Contents {
        match self {
            Self::Candump(_) | Self::Live(_) => Contents::default(),
            Self::Packed(reader) => reader.contents(),
            Self::Asc(reader) => reader.contents(),
            Self::Mcap(reader) => reader.contents(),
            Self::Pcap(reader) => reader.contents(),
        }
    }
}

/// What a reader finds in a capture, in order.
#[derive(Clone, Copy, Debug)]
pub enum Item {
    /// A frame; its `no` is 0 and is given by the session.
    Frame(Frame),
    /// Something that is no frame but says something of the capture.
    Marker(Marker),
    /// Something that should have been a frame and cannot be read.
    Unreadable {
        /// Where.
        place: Place,
        /// Why not.
        reason: Unreadable,
    },
    /// A part of the file that is lost.
    Damaged(Damage),
    /// A live bus cannot be listened to from here on: frames may be missing, and nothing is said to be wrong.
    Gap {
        /// The bus.
        bus: BusId,
        /// It is away, and may be for long: not only a few frames are missing.
        away: bool,
    },
    /// Every frame of the live buses whose stamp is this or earlier has come: so late it is, on the frames' clock.
    Until {
        /// In ns.
        now_ns: i64,
    },
}

impl Item {
    /// The item; if it is of a bus beyond those that are kept apart, that it cannot be read.
    #[inline]
    pub fn on_known_bus(self) -> Self {
        let (bus, line) = match &self {
            Self::Frame(frame) => (frame.bus, frame.line),
            Self::Gap { bus, .. } => (*bus, None),
            Self::Marker(Marker::Dropped { bus, place, .. } | Marker::Error { bus, place, .. }) => (*bus, place.line()),
            _ => return self,
        };
        if bus != BusId::BEYOND {
            return self;
        }
        Self::Unreadable { place: line.map_or(Place::Live, Place::Line), reason: Unreadable::Bus }
    }
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// A line, from 1.
    Line(u64),
    /// An offset in bytes, from 0, in a file without lines.
    Byte(u64),
    /// No place: frames of live buses, of which there is no file, or of a record whose place is not known any more.
    Live,
}

impl Place {
    /// The line; `None` in a file without lines.
    pub fn line(self) -> Option<u64> {
        match self {
            Self::Line(line) => Some(line),
            Self::Byte(_) | Self::Live => None,
        }
    }
}

/// A part of a file that cannot be read because the file is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Where it begins.
    pub place: Place,
    /// What is wrong.
    pub kind: DamageKind,
    /// Bytes of the file that were passed over; `None` where that is not known.
    pub bytes: Option<u64>,
    /// Frames that were lost, or that may be wrong where the kind says so; `None` where that is not known.
    pub frames: Option<u64>,
}

/// What is wrong with a part of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamageKind {
    /// The file ends in the middle of a record: the recording program was ended. Everything before it is whole.
    Cut,
    /// A check sum does not match; what it covers was passed over.
    Checksum,
    /// A length or a type that cannot be; what it covers was passed over.
    Structure,
    /// Data that do not decompress; what they hold was passed over.
    Compression,
    /// The rest of the file cannot be read.
    Rest,
    /// Messages of a topic whose definition, or whose type's, is lost or cannot be used.
    Undefined,
    /// What was unpacked from here on may be wrong: the check sum that covers it fails, or cannot be reached.
    Doubtful,
    /// Definitions of types or topics that contradict each other, so the frames read by the first may be wrong.
    Definition,
    /// The file says that it has more messages than could be found.
    Missing,
    /// The check sum over all data of the file does not match, and nothing shows where: what was read may be wrong.
    Unlocated,
}

/// What a reader knows of its file beyond frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// Properties of the dialect: a word of the format's own (`base`, `profile`), and its value.
    pub dialect: Vec<(&'static str, Vec<u8>)>,
    /// What was passed over because it is no frame, by kind in the format's own words, with counts. At most 64 kinds,
    /// the last one being `...` for all others.
    pub passed_over: Vec<(Vec<u8>, u64)>,
    /// Topics or channels.
    pub topics: Vec<Topic>,
}

/// A topic or channel of a capture that has such.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: Vec<u8>,
    /// The name of its messages' type.
    pub schema: Vec<u8>,
    /// How schema and messages are encoded: `ros2msg/cdr`.
    pub encoding: Vec<u8>,
    /// Its messages.
    pub messages: u64,
    /// How its messages are read as frames: by which fields; empty where they are not.
    pub read_as: Vec<u8>,
    /// The bus that its frames are on; empty where none is.
    pub bus: Vec<u8>,
}

/// A line or record of a capture that speaks of the capture itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// The stamps from here on count from this date. Without one they are what they are: of a clock, or from zero.
    Start {
        /// ns since 1970-01-01: UTC where the format has it so, else local civil time counted as if it were UTC.
        date_ns: i64,
    },
    /// The capturing program lost frames: a gap.
    Dropped {
        /// The bus they were lost on.
        bus: BusId,
        /// How many, as said there.
        count: u64,
        /// How many in total so far, as said there.
        total: u64,
        /// Where it is said.
        place: Place,
    },
    /// The file itself shows that frames are missing here, on whatever bus: its row numbers jump, or a line says so.
    LeftOut {
        /// How many rows, where it is told. Rows that are no frames count as well.
        count: Option<u64>,
        /// The numbers of the rows before and behind the gap, where they show it.
        rows: Option<(u64, u64)>,
        /// Where.
        place: Place,
    },
    /// The identifiers of the file stand in the wrong byte order, and are read in that order.
    Swapped,
    /// An error marker without any content (`can0  ERROR`).
    Error {
        /// The bus it was seen on.
        bus: BusId,
        /// Its stamp, if any.
        stamp: Option<Stamp>,
        /// Where it stands.
        place: Place,
    },
    /// Stamps of a pipe were taken as counted from zero, and went backwards: they may be differences (`-t d`).
    Backward {
        /// Where.
        place: Place,
    },
}

/// Why a line or record could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// The line is no frame of any known dialect, nor a comment.
    NoFrame,
    /// The identifier is out of range for its number of digits, or has flag bits that no frame has.
    Identifier,
    /// The length is out of range, or not a length of a CAN FD frame.
    Length,
    /// Fewer data bytes than the length says, or a byte that is no number.
    Data,
    /// The line ends in the middle of a frame: the capture was cut.
    Cut,
    /// A CAN XL frame.
    CanXl,
    /// It is on one bus more than are kept apart.
    Bus,
}

/// Hands on bytes that come in any chunking: `take` gets what is left over (`rest`) with `bytes` behind it, and says how
/// much of it was whole. Gives what is left over then; nothing is copied while nothing is.
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
