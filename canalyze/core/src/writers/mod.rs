//! Capture formats to be written: one file (or folder) a format; frames in, bytes out.
//!
//! A writer sees only `frame` and what readers say of a capture. It does no I/O and never fails: what its format
//! cannot hold it counts as a loss. A new format is a file here, a row of [`Format`], and an arm of [`Writer`].

pub mod log;
pub mod pcapng;

use self::log::Log;
use self::pcapng::Pcapng;
use crate::frame::{Buses, Frame};
use crate::readers::Marker;

/// Formats that this crate writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// candump's log form (`candump -l`).
    #[default]
    Log,
    /// pcapng.
    Pcapng,
}

impl Format {
    /// All of them, with their names.
    pub const NAMES: &[(&str, Format)] = &[("candump", Format::Log), ("pcapng", Format::Pcapng)];
}

/// What is known of the capture as a whole when a frame is written.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The names of the buses so far.
    pub buses: &'a Buses,
    /// The date from which the stamps count, in ns since 1970-01-01, where the capture says one.
    pub date_ns: Option<i64>,
}

impl Setting<'_> {
    /// When a frame was seen, in ns since 1970-01-01 (since the capture's start where no date is known); `None`
    /// without stamps.
    pub fn moment(&self, frame: &Frame) -> Option<i64> {
        frame.t_ns.map(|t_ns| t_ns.saturating_add(self.date_ns.unwrap_or(0)))
    }
}

/// The writer of one file.
#[derive(Debug)]
pub enum Writer {
    /// candump's log form.
    Log(Log),
    /// pcapng.
    Pcapng(Pcapng),
}

impl Writer {
    /// A writer at the beginning of a file.
    pub fn new(format: Format) -> Self {
        match format {
            Format::Log => Self::Log(Log::default()),
            Format::Pcapng => Self::Pcapng(Pcapng::default()),
        }
    }

    /// Appends a frame.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, frame: &Frame) {
        match self {
            Self::Log(writer) => writer.frame(out, setting, frame),
            Self::Pcapng(writer) => writer.frame(out, setting, frame),
        }
    }

    /// Appends what the capture says of itself, where the format can.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: Setting<'_>, marker: &Marker) {
        match self {
            Self::Log(writer) => writer.marker(out, setting, marker),
            Self::Pcapng(writer) => writer.marker(out, setting, marker),
        }
    }

    /// Appends what belongs at the end of the file.
    pub fn finish(&mut self, out: &mut Vec<u8>, _setting: Setting<'_>) {
        match self {
            Self::Log(_) => {}
            Self::Pcapng(writer) => writer.finish(out),
        }
    }

    /// What could not be written.
    pub fn losses(&self) -> &Losses {
        match self {
            Self::Log(writer) => &writer.losses,
            Self::Pcapng(writer) => &writer.losses,
        }
    }
}

/// What a format cannot hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Loss {
    /// The direction of a frame.
    Direction,
    /// A direction that is not known had to be written as received.
    UnknownDirection,
    /// The name of a bus; its number remains.
    BusName,
    /// Digits of a stamp.
    StampDigits,
    /// The format demands stamps, and the capture has none: frames got invented ones, evenly spaced.
    NoStamp,
    /// A stamp that steps back; the format wants them in order.
    Order,
    /// The format demands a date, and the capture's stamps count from zero: they were written as they are.
    NoDate,
    /// Bit rate switch or error state indicator of an FD frame.
    FdFlags,
    /// An FD frame as a whole.
    FdFrame,
    /// The raw DLC 9 to 15 of a classic frame.
    RawDlc,
    /// The length that a remote frame asks for.
    RemoteLength,
    /// The class and details of an error frame; that there was one remains.
    ErrorDetails,
    /// An error frame as a whole.
    ErrorFrame,
    /// That the capturing program lost frames.
    Gap,
}

/// How often what was lost.
#[derive(Clone, Debug, Default)]
pub struct Losses(std::collections::BTreeMap<Loss, u64>);

impl Losses {
    /// Counts one.
    pub fn count(&mut self, loss: Loss) {
        *self.0.entry(loss).or_default() += 1;
    }

    /// What was lost, and how often.
    pub fn iter(&self) -> impl Iterator<Item = (Loss, u64)> {
        self.0.iter().map(|(loss, count)| (*loss, *count))
    }
}
