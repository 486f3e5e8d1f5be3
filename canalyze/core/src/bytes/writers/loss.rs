//! Losses in the conversion to another format, counted by kind. Their words are in `text`.

use std::collections::BTreeMap;

/// Content that a format cannot hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Loss {
    /// The direction of a frame.
    Direction,
    /// An unknown direction, written as received.
    UnknownDirection,
    /// The name of a bus; its number is kept.
    BusName,
    /// Digits of a stamp.
    StampDigits,
    /// Missing stamps that the format requires; evenly spaced ones were invented.
    NoStamp,
    /// A stamp that steps backward, while the format requires order.
    Order,
    /// A missing date that the format requires; stamps count from zero as in the capture.
    NoDate,
    /// Bit rate switch or error state indicator of an FD frame.
    FdFlags,
    /// The FD format of a frame, which is written as a classic one.
    FdFormat,
    /// A whole FD frame.
    FdFrame,
    /// The raw DLC 9 to 15 of a classic frame.
    RawDlc,
    /// The length that a remote frame requests.
    RemoteLength,
    /// The class and details of an error frame, which itself is kept.
    ErrorDetails,
    /// A whole error frame.
    ErrorFrame,
    /// A report of lost frames by the capturing program.
    Gap,
    /// The signals of a frame, since no further topic is possible.
    Topics,
}

impl Loss {
    /// All losses with the names by which writers outside this crate count them.
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

/// The number of losses of each kind.
#[derive(Clone, Debug, Default)]
pub struct Losses(BTreeMap<Loss, u64>);

impl Losses {
    /// Counts one loss.
    pub fn count(&mut self, loss: Loss) {
        self.add(loss, 1);
    }

    /// Counts several losses.
    pub fn add(&mut self, loss: Loss, count: u64) {
        *self.0.entry(loss).or_default() += count;
    }

    /// Iterates over the losses and their numbers.
    pub fn iter(&self) -> impl Iterator<Item = (Loss, u64)> {
        self.0.iter().map(|(loss, count)| (*loss, *count))
    }
}
