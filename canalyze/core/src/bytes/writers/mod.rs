//! The writers of capture formats, one file or folder for each: frames in, bytes out.
//!
//! A writer sees frames, the markers of readers and, if it writes decoded content, events. It does no I/O and never
//! fails: it counts as a loss whatever its format cannot hold. A new format needs a file, a row of [`Format`], and an
//! arm of [`Writer`].

pub mod asc;
pub mod console;
pub mod log;
pub mod loss;
pub mod mcap;
pub mod packed;
pub mod pcapng;

use std::borrow::Cow;

use self::asc::Asc;
use self::console::Console;
use self::log::Log;
use self::mcap::Mcap;
use self::packed::Packed;
use self::pcapng::Pcapng;
use crate::bytes::frame::{BusId, Buses, Frame, MAX_BUS_NAME};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::rules::finding::Finding;
use crate::world::event::Event;

pub use self::loss::{Loss, Losses};

/// The formats that this crate writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// candump's log form (`candump -l`).
    #[default]
    Log,
    /// Records for another program's writer; not a file format, and so without a name.
    Packed,
    /// Vector's ASC log.
    Asc,
    /// candump's console form.
    Console,
    /// MCAP with ROS 2 messages.
    Mcap,
    /// pcapng.
    Pcapng,
}

impl Format {
    /// All file formats by their names.
    pub const NAMES: &[(&str, Format)] = &[
        ("candump", Format::Log),
        ("console", Format::Console),
        ("asc", Format::Asc),
        ("mcap", Format::Mcap),
        ("pcapng", Format::Pcapng),
    ];
}

/// Options of formats that can be written in several ways.
#[derive(Clone, Debug, Default)]
pub struct WriterSettings {
    /// MCAP.
    pub mcap: mcap::McapSettings,
}

/// The facts about the whole capture when a frame is written.
#[derive(Clone, Copy, Debug)]
pub struct CaptureFacts<'a> {
    /// The names of the buses so far.
    pub buses: &'a Buses,
    /// The date from which the stamps count, in ns since 1970-01-01, if the capture has one.
    pub date_ns: Option<Ns>,
}

impl CaptureFacts<'_> {
    /// Returns the time of a frame in ns since 1970-01-01 (since the start of the capture if no date is known); `None`
    /// without stamps.
    pub fn moment(&self, frame: &Frame) -> Option<Ns> {
        frame.t_ns.map(|t_ns| t_ns + self.date_ns.unwrap_or_default())
    }
}

/// The writer of one file.
#[derive(Debug)]
pub enum Writer {
    /// candump's log form.
    Log(Log),
    /// Records for another program's writer.
    Packed(Packed),
    /// Vector's ASC log.
    Asc(Asc),
    /// candump's console form.
    Console(Console),
    /// MCAP.
    Mcap(Box<Mcap>),
    /// pcapng.
    Pcapng(Pcapng),
}

impl Writer {
    /// Creates a writer at the beginning of a file.
    pub fn new(format: Format, settings: &WriterSettings) -> Self {
        match format {
            Format::Log => Self::Log(Log::default()),
            Format::Packed => Self::Packed(Packed::default()),
            Format::Asc => Self::Asc(Asc::default()),
            Format::Console => Self::Console(Console::default()),
            Format::Mcap => Self::Mcap(Box::new(Mcap::new(settings.mcap.clone()))),
            Format::Pcapng => Self::Pcapng(Pcapng::default()),
        }
    }

    /// Records that the next frames come from `file` in this format.
    pub fn source(&mut self, file: &[u8], format: &str) {
        if let Self::Mcap(writer) = self {
            writer.source(file, format);
        }
    }

    /// Returns true if it writes decoded content.
    pub fn wants_events(&self) -> bool {
        matches!(self, Self::Mcap(writer) if writer.wants_events())
    }

    /// Appends a frame.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: &Frame) {
        match self {
            Self::Log(writer) => writer.frame(out, setting, frame),
            Self::Packed(writer) => writer.frame(out, setting, frame),
            Self::Asc(writer) => writer.frame(out, setting, frame),
            Self::Console(writer) => writer.frame(out, setting, frame),
            Self::Mcap(writer) => writer.frame(out, setting, frame),
            Self::Pcapng(writer) => writer.frame(out, setting, frame),
        }
    }

    /// Appends a marker if the format has a form for it.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, marker: &Marker) {
        match self {
            Self::Log(writer) => writer.marker(out, setting, marker),
            Self::Packed(writer) => writer.marker(out, setting, marker),
            Self::Asc(writer) => writer.marker(out, setting, marker),
            Self::Console(writer) => writer.marker(out, setting, marker),
            Self::Mcap(writer) => writer.marker(out, setting, marker),
            Self::Pcapng(writer) => writer.marker(out, setting, marker),
        }
    }

    /// Appends the events of the frame just written, if the format holds them and they are wanted. Without a frame:
    /// later knowledge.
    pub fn events(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: Option<&Frame>, events: &[Event]) {
        if let Self::Mcap(writer) = self {
            writer.events(out, setting, frame, events);
        }
    }

    /// Appends a finding about the capture, which has no frame.
    pub fn finding(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, finding: &Finding) {
        if let Self::Mcap(writer) = self {
            writer.finding(out, setting, finding);
        }
    }

    /// Appends buffered content that is old at `now_ns` on the clock of live frames, so that a growing file can be
    /// read.
    pub fn until(&mut self, out: &mut Vec<u8>, now_ns: Ns) {
        if let Self::Mcap(writer) = self {
            writer.until(out, now_ns);
        }
    }

    /// Appends the end of the file.
    pub fn finish(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>) {
        match self {
            Self::Log(_) | Self::Console(_) | Self::Packed(_) => {}
            Self::Asc(writer) => writer.finish(out, setting),
            Self::Mcap(writer) => writer.finish(out, setting),
            Self::Pcapng(writer) => writer.finish(out),
        }
    }

    /// Returns the losses.
    pub fn losses(&self) -> &Losses {
        match self {
            Self::Log(writer) => &writer.losses,
            Self::Packed(writer) => &writer.losses,
            Self::Asc(writer) => &writer.losses,
            Self::Console(writer) => &writer.losses,
            Self::Mcap(writer) => &writer.losses,
            Self::Pcapng(writer) => &writer.losses,
        }
    }
}

/// Returns the name of a bus as candump's text can hold it: without blanks or control characters, beginning with a
/// letter or digit. Empty if the capture names none.
fn name_of<'a>(buses: &'a Buses, bus: BusId, losses: &mut Losses) -> Cow<'a, [u8]> {
    let name = buses.name(bus);
    let fits = |byte: &u8| byte.is_ascii_graphic() && *byte != b'#';
    if name.is_empty() || name.first().is_some_and(u8::is_ascii_alphanumeric) && name.iter().all(fits) {
        return Cow::Borrowed(name);
    }
    losses.count(Loss::BusName);
    let odd = |byte: &u8| !byte.is_ascii_alphanumeric();
    let kept = name.iter().skip_while(|byte| odd(byte)).map(|byte| if fits(byte) { *byte } else { b'_' });
    let kept: Vec<u8> = kept.take(MAX_BUS_NAME).collect();
    Cow::Owned(if kept.is_empty() { format!("bus{}", bus.0).into_bytes() } else { kept })
}

#[cfg(test)]
mod tests;
