//! Decoded frames as messages of their own: plots, state lanes and logs of the usual viewers show them without
//! knowing CANopen.
//!
//! | topic | message |
//! |---|---|
//! | `/<bus>/node5/tpdo1` | the signals of a PDO, a type of message for each mapping; see `pdo` |
//! | `/<bus>/node5/nmt_state` | `canalyze_msgs/msg/NmtState` |
//! | `/<bus>/node5/drive_state` | `canalyze_msgs/msg/DriveState`; `drive_state_2` is that of the second axis |
//! | `/<bus>/node5/emcy` | `canalyze_msgs/msg/Emergency` |
//! | `/<bus>/node5/sdo` | `canalyze_msgs/msg/SdoTransfer` |
//! | `/findings` | `canalyze_msgs/msg/Finding` |
//! | `/log` | `rcl_interfaces/msg/Log`: findings and emergencies |
//!
//! It must not judge: it writes down what events say.

mod fields;
mod pdo;
mod report;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use self::pdo::PdoTypes;
use super::cdr::Cdr;
use super::container::{ChannelId, Container, SchemaId};
use super::message::{RosMessage, RosValues};
use super::{CaptureFacts, Losses, ROS2};
use crate::bytes::frame::{Frame, FrameRef};
use crate::rules::finding::Finding;
use crate::words::Lang;
use crate::world::event::{Event, What};

/// The destination and time of messages.
pub(super) struct MessagePlace<'a, 'b> {
    /// The file.
    pub(super) out: &'a mut Vec<u8>,
    /// Its records.
    pub(super) container: &'a mut Container,
    /// The message that is being put together.
    pub(super) cdr: &'a mut Cdr,
    /// Data that could not be written.
    pub(super) losses: &'a mut Losses,
    /// The facts about the capture.
    pub(super) setting: CaptureFacts<'b>,
    /// The moment of the last frame.
    pub(super) now: u64,
}

impl MessagePlace<'_, '_> {
    /// The moment of a frame that is spoken of: that of the last one where it has no stamp.
    fn moment(&self, at: FrameRef) -> u64 {
        self.stamped(at).unwrap_or(self.now)
    }

    /// The same; `None` without a stamp.
    fn stamped(&self, at: FrameRef) -> Option<u64> {
        let t_ns = at.t_ns?;
        Some(u64::try_from((t_ns + self.setting.date_ns.unwrap_or_default()).as_ns()).unwrap_or(0))
    }

    /// Takes the message that has been put together.
    fn send(&mut self, channel: ChannelId, at: FrameRef, time: u64) {
        self.container.message(self.out, channel, at.no as u32, time, self.cdr.bytes());
    }
}

/// The state of one file.
#[derive(Debug)]
pub(super) struct Decoded {
    lang: Lang,
    pdos: PdoTypes,
    schemas: BTreeMap<&'static str, Option<SchemaId>>,
    /// By topic. Nodes and buses are few.
    channels: BTreeMap<String, ChannelId>,
    /// Words being put together.
    words: Vec<u8>,
}

impl Decoded {
    /// Nothing seen yet.
    pub(super) fn new(lang: Lang) -> Self {
        let (schemas, channels) = Default::default();
        Self { lang, pdos: PdoTypes::new(lang), schemas, channels, words: Vec::new() }
    }

    /// Appends what an event says.
    pub(super) fn event(&mut self, place: &mut MessagePlace<'_, '_>, bus: &str, frame: Option<&Frame>, event: &Event) {
        match (&event.what, frame) {
            (What::Pdo(data), Some(frame)) => self.pdos.process_data(place, bus, event, data, frame),
            (What::Mpdo(data), Some(frame)) => self.pdos.multiplexed(place, bus, event, data, frame),
            (What::Message(message), Some(frame)) => report::message(self, place, bus, event.at, message, frame),
            (What::Change(change), _) => report::change(self, place, bus, event.at, change),
            (What::Transfer(transfer), _) => report::transfer(self, place, bus, event.at, transfer),
            (What::Finding(finding), _) => self.finding(place, bus, finding),
            _ => {}
        }
    }

    /// Appends a finding.
    pub(super) fn finding(&mut self, place: &mut MessagePlace<'_, '_>, bus: &str, finding: &Finding) {
        report::finding(self, place, bus, finding);
    }

    /// Appends a message, at this time and about this frame. The channel of its topic is declared when it is first needed.
    fn send(
        &mut self,
        place: &mut MessagePlace<'_, '_>,
        topic: &str,
        (at, time): (FrameRef, u64),
        message: RosMessage<impl RosValues>,
    ) {
        let Some(channel) = self.channel(place, topic, &message) else { return };
        message.values.append(place.cdr.begin());
        place.send(channel, at, time);
    }

    fn channel(
        &mut self,
        place: &mut MessagePlace<'_, '_>,
        topic: &str,
        message: &RosMessage<impl RosValues>,
    ) -> Option<ChannelId> {
        if let Some(known) = self.channels.get(topic) {
            return Some(*known);
        }
        let slot = self.schemas.entry(message.name).or_default();
        let schema = super::declare(place.container, slot, message)?;
        let channel = place.container.channel(topic, schema, ROS2.1, &[])?;
        self.channels.insert(topic.to_owned(), channel);
        Some(channel)
    }
}
