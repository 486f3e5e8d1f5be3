//! What is lost on the way into another format, counted by kind. Words for it stand in `text`.

use std::collections::BTreeMap;

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
    /// That a frame was an FD frame; it is written as a classic one.
    FdFormat,
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
    /// The signals of a frame: there is no room for yet another topic.
    Topics,
}

impl Loss {
    /// All of them, with the names by which writers outside of this crate count them.
    pub const NAMES: &[(&str, Loss)] = &[
        ("direction", Loss::Direction),
        ("unknown_direction", Loss::UnknownDirection),
        ("bus_name", Loss::BusName),
        ("stamp_digits", Loss::StampDigits),
        ("no_stamp", Loss::NoStamp),
        ("order", Loss::Order),
        ("no_date", Loss::NoDate),
        ("fd_flags", Loss::FdFlags),
        ("fd_format", Loss::FdFormat),
        ("fd_frame", Loss::FdFrame),
        ("raw_dlc", Loss::RawDlc),
        ("remote_length", Loss::RemoteLength),
        ("error_details", Loss::ErrorDetails),
        ("error_frame", Loss::ErrorFrame),
        ("gap", Loss::Gap),
        ("topics", Loss::Topics),
    ];
}

/// How often what was lost.
#[derive(Clone, Debug, Default)]
pub struct Losses(BTreeMap<Loss, u64>);

impl Losses {
    /// Counts one.
    pub fn count(&mut self, loss: Loss) {
        self.add(loss, 1);
    }

    /// Counts several.
    pub fn add(&mut self, loss: Loss, count: u64) {
        *self.0.entry(loss).or_default() += count;
    }

    /// What was lost, and how often.
    pub fn iter(&self) -> impl Iterator<Item = (Loss, u64)> {
        self.0.iter().map(|(loss, count)| (*loss, *count))
    }
}
