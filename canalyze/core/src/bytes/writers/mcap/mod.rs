//! MCAP with ROS 2 messages: each frame is a `can_msgs/msg/Frame` or, with CAN FD, a `ros2_socketcan_msgs/msg/FdFrame`,
//! on the topics of `ros2_socketcan`.
//!
//! | topic | frames |
//! |---|---|
//! | `/<bus>/from_can_bus` | classic, remote and error frames, received or of unknown direction |
//! | `/<bus>/to_can_bus` | the same, sent by the capturing host |
//! | `/<bus>/from_can_bus_fd`, `/<bus>/to_can_bus_fd` | CAN FD frames |
//!
//! Log time, publish time and the header's stamp are the time of the frame; `frame_id` is the bus. An error frame has
//! `is_error` and its class in `id`, without flag bits. The metadata record `canalyze.source` names files, formats and
//! buses. `decoded` adds the decoded content.

use crate::bytes::ns::Ns;

mod cdr;
mod container;
mod decoded;
mod frames;
mod message;
#[cfg(test)]
mod tests;

use self::cdr::Cdr;
use self::container::{ChannelId, Container, SchemaId};
use self::decoded::Decoded;
use self::message::{Header, RosMessage, RosValues};
use super::{CaptureFacts, Loss, Losses};
use crate::bytes::frame::{BusId, CanId, Direction, Frame, Kind};
use crate::bytes::readers::Marker;
use crate::rules::finding::Finding;
use crate::words::Lang;
use crate::world::event::Event;

/// The encodings of schemas and messages.
const ROS2: (&str, &str) = ("ros2msg", "cdr");
/// Maximum number of files named in the metadata.
const FILES: usize = 64;
/// Time between frames without a stamp, in ns.
const STEP: u64 = 1_000_000;

/// The schema of CAN FD frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FdSchema {
    /// `ros2_socketcan_msgs/msg/FdFrame`: the usual one, without BRS and ESI.
    #[default]
    Ros2,
    /// `dataspeed_can_msgs/msg/Frame`, with BRS and ESI.
    Dataspeed,
}

impl FdSchema {
    /// All schemas by their names.
    pub const NAMES: &[(&str, FdSchema)] = &[("ros2", FdSchema::Ros2), ("dataspeed", FdSchema::Dataspeed)];
}

/// The options of a file.
#[derive(Clone, Debug, Default)]
pub struct McapSettings {
    /// The schema of CAN FD frames.
    pub fd_schema: FdSchema,
    /// Without message indexes: almost half the size, but refused by some readers.
    pub archive: bool,
    /// The language of additional topics with decoded signals, states and transfers; `None` without such topics.
    pub decoded: Option<Lang>,
}

/// The topics of one bus.
#[derive(Clone, Debug, Default)]
struct Topics {
    /// Its name in topics; empty until a frame needs it.
    name: String,
    /// True if this differs from its name in the capture.
    renamed: bool,
    /// Channels by direction (from the bus, to it), classic and FD.
    channels: [[Option<ChannelId>; 2]; 2],
}

/// A writer of MCAP.
#[derive(Debug)]
pub struct Mcap {
    /// The losses.
    pub losses: Losses,
    settings: McapSettings,
    container: Container,
    cdr: Cdr,
    frame: Option<SchemaId>,
    fd: Option<SchemaId>,
    /// Topics by bus.
    topics: Vec<Topics>,
    /// The names of the source files, without folders, and their formats.
    sources: Vec<(String, String)>,
    decoded: Option<Box<Decoded>>,
    frames: u64,
    /// The time of the last frame, in ns.
    now: u64,
}

impl Default for Mcap {
    fn default() -> Self {
        Self::new(McapSettings::default())
    }
}

impl Mcap {
    /// Creates a writer at the beginning of a file.
    pub fn new(settings: McapSettings) -> Self {
        Self {
            losses: Losses::default(),
            container: Container::new(!settings.archive),
            decoded: settings.decoded.map(|lang| Box::new(Decoded::new(lang))),
            settings,
            cdr: Cdr::default(),
            frame: None,
            fd: None,
            topics: Vec::new(),
            sources: Vec::new(),
            frames: 0,
            now: 0,
        }
    }

    /// Records that the next frames come from `file` in this format.
    pub fn source(&mut self, file: &[u8], format: &str) {
        if self.sources.len() < FILES {
            let name = file.rsplit(|byte| *byte == b'/').next().unwrap_or(file);
            self.sources.push((String::from_utf8_lossy(name).into_owned(), format.to_owned()));
        }
    }

    /// Returns true if it writes decoded content.
    pub fn wants_events(&self) -> bool {
        self.decoded.is_some()
    }

    /// Appends a frame.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: &Frame) {
        self.begin(out);
        let moment = setting.moment(frame);
        self.now = match moment {
            Some(ns) => u64::try_from(ns.as_ns()).unwrap_or(0),
            None => self.frames.saturating_mul(STEP),
        };
        self.frames += 1;
        // A time before 1970 cannot be written either and becomes 0.
        if moment.is_none_or(|ns| ns < Ns::ZERO) {
            self.losses.count(Loss::NoStamp);
        }
        if frame.dir.is_none() {
            self.losses.count(Loss::UnknownDirection);
        }
        if frame.length_form.raw_dlc > 8 && !matches!(frame.kind, Kind::Fd { .. }) {
            self.losses.count(Loss::RawDlc);
        }
        let Some(channel) = self.channel(setting, frame) else { return };
        let bus = self.topics.get(usize::from(frame.bus.0)).map_or("", |topics| &topics.name);
        let (header, cdr) = (Header(self.now, bus), self.cdr.begin());
        match (frame.kind, self.settings.fd_schema) {
            (Kind::Fd { brs, esi }, FdSchema::Ros2) => {
                if brs || esi {
                    self.losses.count(Loss::FdFlags);
                }
                frames::fd(header, frame).values.append(cdr);
            }
            (Kind::Fd { .. }, FdSchema::Dataspeed) => frames::dataspeed(header, frame).values.append(cdr),
            _ => frames::classic(header, frame).values.append(cdr),
        }
        self.container.message(out, channel, self.frames as u32, self.now, self.cdr.bytes());
    }

    /// Appends an error marker as an error frame without a class; other markers are counted as losses.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { .. } | Marker::LeftOut { .. } => self.losses.count(Loss::Gap),
            Marker::Error { bus, stamp, .. } => {
                let t_ns = stamp.map(|stamp| stamp.ns);
                let bare = Frame::classic(CanId::standard(0), &[]);
                self.frame(out, setting, &Frame { bus, t_ns, stamp, kind: Kind::Error, ..bare });
            }
            Marker::Start { .. } | Marker::Backward { .. } | Marker::Swapped => {}
        }
    }

    /// Appends the events of the last frame, if decoded topics are wanted. Without a frame: later knowledge.
    pub fn events(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: Option<&Frame>, events: &[Event]) {
        if self.decoded.is_none() {
            return;
        }
        self.begin(out);
        for event in events {
            self.bus(setting, event.bus);
        }
        let Self { decoded: Some(decoded), container, cdr, topics, losses, now, .. } = self else { return };
        let mut place = decoded::MessagePlace { out, container, cdr, losses, setting, now: *now };
        for event in events {
            let bus = topics.get(usize::from(event.bus.0)).map_or("", |topics| &topics.name);
            decoded.event(&mut place, bus, frame, event);
        }
    }

    /// Appends a finding about the capture, which has no frame.
    pub fn finding(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, finding: &Finding) {
        if self.decoded.is_none() {
            return;
        }
        self.begin(out);
        self.bus(setting, finding.bus);
        let Self { decoded: Some(decoded), container, cdr, topics, losses, now, .. } = self else { return };
        let bus = topics.get(usize::from(finding.bus.0)).map_or("", |topics| &topics.name);
        decoded.finding(&mut decoded::MessagePlace { out, container, cdr, losses, setting, now: *now }, bus, finding);
    }

    /// Appends a chunk that is old at `now_ns` on the clock of live frames.
    pub fn until(&mut self, out: &mut Vec<u8>, now_ns: Ns) {
        self.container.until(out, u64::try_from(now_ns.as_ns()).unwrap_or(0));
    }

    /// Appends the end of the file.
    pub fn finish(&mut self, out: &mut Vec<u8>, _setting: CaptureFacts<'_>) {
        self.begin(out);
        // One line for each, since names may contain anything else.
        let lines = |words: Vec<&str>| words.join("\n");
        let buses = self.topics.iter().map(|topics| &*topics.name).filter(|name| !name.is_empty());
        let rows = [
            ("buses", lines(buses.collect())),
            ("file", lines(self.sources.iter().map(|(file, _)| &**file).collect())),
            ("format", lines(self.sources.iter().map(|(_, format)| &**format).collect())),
        ];
        let rows: Vec<_> = rows.iter().map(|(key, value)| (*key, value.as_str())).collect();
        self.container.metadata(out, "canalyze.source", &rows);
        self.container.finish(out);
    }

    fn begin(&mut self, out: &mut Vec<u8>) {
        if !self.container.is_begun() {
            self.container.begin(out, "ros2", concat!("canalyze/", env!("CARGO_PKG_VERSION")));
        }
    }

    /// Returns the topics of a bus, naming them on first use.
    fn bus(&mut self, setting: CaptureFacts<'_>, bus: BusId) -> Option<&mut Topics> {
        let place = usize::from(bus.0);
        if self.topics.len() <= place {
            self.topics.resize(place + 1, Topics::default());
        }
        if self.topics.get(place).is_some_and(|topics| topics.name.is_empty()) {
            let given = setting.buses.name(bus);
            let taken: Vec<&str> = self.topics.iter().map(|topics| &*topics.name).collect();
            let name = topic_name(given, &taken);
            if let Some(topics) = self.topics.get_mut(place) {
                topics.renamed = !given.is_empty() && name.as_bytes() != given;
                topics.name = name;
            }
        }
        self.topics.get_mut(place)
    }

    /// Returns the channel of a frame, declaring it on first use.
    fn channel(&mut self, setting: CaptureFacts<'_>, frame: &Frame) -> Option<ChannelId> {
        let fd = matches!(frame.kind, Kind::Fd { .. });
        let sent = frame.dir == Some(Direction::Tx);
        let topics = self.bus(setting, frame.bus)?;
        let renamed = topics.renamed;
        let [from, to] = &mut topics.channels;
        let [classic, with_fd] = if sent { to } else { from };
        let slot = if fd { with_fd } else { classic };
        if let Some(known) = *slot {
            if renamed {
                self.losses.count(Loss::BusName);
            }
            return Some(known);
        }
        let topic =
            format!("/{}/{}_can_bus{}", topics.name, if sent { "to" } else { "from" }, if fd { "_fd" } else { "" });
        let (container, header) = (&mut self.container, Header(0, ""));
        let schema = match (fd, self.settings.fd_schema) {
            (false, _) => declare(container, &mut self.frame, &frames::classic(header, frame)),
            (true, FdSchema::Ros2) => declare(container, &mut self.fd, &frames::fd(header, frame)),
            (true, FdSchema::Dataspeed) => declare(container, &mut self.fd, &frames::dataspeed(header, frame)),
        }?;
        let channel = self.container.channel(&topic, schema, ROS2.1, &[])?;
        let [from, to] = &mut self.bus(setting, frame.bus)?.channels;
        let [classic, with_fd] = if sent { to } else { from };
        *(if fd { with_fd } else { classic }) = Some(channel);
        if renamed {
            self.losses.count(Loss::BusName);
        }
        Some(channel)
    }
}

/// Returns the ID of a schema, declaring it on first use.
fn declare(
    container: &mut Container,
    slot: &mut Option<SchemaId>,
    message: &RosMessage<impl RosValues>,
) -> Option<SchemaId> {
    if slot.is_none() {
        *slot = container.schema(message.name, ROS2.0, &message.definition());
    }
    *slot
}

/// Returns the name of a bus in topics: `can0` if the capture names none; characters that would end the name, or are
/// not text, become `_`. Names made equal by this are numbered.
fn topic_name(given: &[u8], taken: &[&str]) -> String {
    let mut name = String::new();
    for chunk in given.utf8_chunks() {
        name.extend(
            chunk.valid().chars().map(|c| if c == '/' || c.is_control() || c.is_whitespace() { '_' } else { c }),
        );
        name.extend(chunk.invalid().iter().map(|_| '_'));
    }
    if name.is_empty() {
        name.push_str("can0");
    }
    let mut free = name.clone();
    let mut number = 2;
    while taken.contains(&&*free) {
        free = format!("{name}_{number}");
        number += 1;
    }
    free
}
