//! `lanes`: what a timeline shows beside plots, one lane a thing: NMT states, drives, SDO transfers, errors, values.
//!
//! | lane | `state` | `class` |
//! |---|---|---|
//! | `nmt/BUS/nodeN` | the NMT state: shown, commanded, lost | `initialising pre-operational operational stopped lost unknown` |
//! | `drive/BUS/nodeN`, `.../axis2` | the state of CiA 402 | its name: `operation-enabled` |
//! | `sdo/BUS/nodeN`, `.../604-584` | the transfer, from its first frame to its last | `ok aborted failed incomplete` |
//! | `emcy/BUS/nodeN` | the errors that the node has reported and not taken back | `active` |
//! | `value/BUS/nodeN/TPDO1/SIGNAL` | the value of a signal that is no quantity | `0 1` of truth values |
//! | `value/BUS/nodeN/TPDO1/SIGNAL.3` | a bit of it, once it has changed | `0 1` |
//!
//! A row is a change, and `state` is null where nothing is known any more: what was shown before a restart, a loss of
//! the heartbeat or of frames is not drawn on. `BUS/` is left out where the capture names none. The rows of one lane
//! stand in the order of their frames, those of different lanes need not. Signals, drives and errors of frames that a
//! filter keeps back are not shown; lanes end there. Must not: judge.

mod node;
mod rows;
#[cfg(test)]
mod tests;
mod transfers;
mod values;

use std::collections::BTreeMap;

use self::node::{Node, Standing};
use self::rows::{At, Pen, prefix};
use self::transfers::Channels;
use self::values::Values;
use super::column::{Batch, Table};
use crate::drive::{self, Object};
use crate::event::{Event, Note, What};
use crate::finding::{Code, Facts, Finding, Quantity};
use crate::frame::{BusId, Frame};
use crate::message::Message;
use crate::od::DataType;
use crate::render::jsonl::Setting;
use crate::render::selection::Selection;
use crate::services::heartbeat::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::services::nmt;
use crate::services::sdo::transfer::{Direction, Status, Transfer};
use crate::services::sdo::wire::Side;
use crate::text::lane::Word;
use crate::text::{Lang, signal, value};

pub(super) use self::rows::Rows;

/// Profiles of a device type (1000h) that do not say what the device is: those of its axes stand elsewhere.
const NO_PROFILE: [u16; 2] = [0, 0xFFFF];

/// One bus.
#[derive(Debug, Default)]
struct Bus {
    /// `can0/`.
    prefix: String,
    /// Its last frame.
    last: At,
    nodes: BTreeMap<u8, Node>,
    /// Nodes that have sent something, a bit each.
    present: u128,
    /// Nodes of which nothing but the boot-up says their state, a bit each.
    fresh: u128,
}

/// The lanes.
#[derive(Debug)]
pub(super) struct Lanes {
    table: Table<Rows>,
    lang: Lang,
    buses: Vec<Bus>,
    values: Values,
    channels: Channels,
    /// Words being put together.
    text: Vec<u8>,
}

/// Where a message stands.
#[derive(Clone, Copy)]
struct Place<'a> {
    bus: BusId,
    frame: &'a Frame,
    at: At,
    shown: bool,
}

impl Lanes {
    /// No row yet. `selection`: which signals are shown.
    pub(super) fn new(table: Table<Rows>, selection: Selection, lang: Lang) -> Self {
        let (buses, channels, text) = (Vec::new(), Channels::default(), Vec::new());
        Self { table, lang, buses, values: Values::new(selection), channels, text }
    }

    /// Takes a frame and what follows from it, in the SYNC cycle that runs on its bus. `shown`: the filter lets it
    /// through.
    pub(super) fn frame(
        &mut self,
        done: &mut Vec<Batch>,
        setting: Setting<'_>,
        (cycle, shown): (u64, bool),
        frame: &Frame,
        events: &[Event],
    ) {
        let at = At::frame(frame, cycle);
        let place = Place { bus: frame.bus, frame, at, shown };
        // What became due before the frame.
        for event in events.iter().skip(1) {
            if let What::Finding(finding) = &event.what {
                self.finding(done, setting, finding);
            }
        }
        self.bus(setting, frame.bus).last = at;
        for event in events {
            match &event.what {
                What::Pdo(data) => self.process_data(done, place, data),
                What::Message(message) => self.message(done, place, message),
                What::Sdo(step) => {
                    let node = event.node.unwrap_or(0);
                    match step.side {
                        Side::Client => self.node(place.bus, node, |one| one.managed = true),
                        Side::Server => self.present(done, place, node),
                    }
                    self.channels.step(event.transfer, step.side, frame, cycle);
                }
                What::Note(Note::NodeIdChanged { from, .. }) => self.gone(done, place.bus, *from, at),
                _ => {}
            }
        }
        self.settle(done, cycle);
    }

    /// Takes what belongs to no frame at hand.
    pub(super) fn asides(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, events: &[Event]) {
        for event in events {
            if let What::Finding(finding) = &event.what {
                self.finding(done, setting, finding);
            }
        }
        self.settle(done, 0);
    }

    /// Takes a transfer that has ended.
    pub(super) fn transfer(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, transfer: &Transfer) {
        self.channels.take(self.lang, transfer);
        let whole = transfer.status == Status::Ok && !transfer.bad && !transfer.hole;
        let Some(mux) = transfer.mux.filter(|mux| whole && mux.sub == 0 && transfer.direction == Direction::Upload)
        else {
            return;
        };
        match *transfer.kept.as_slice() {
            [low, high, _, _] if mux.index == 0x1000 => {
                self.bus(setting, transfer.bus);
                let profile = u16::from_le_bytes([low, high]);
                let is_other = !NO_PROFILE.contains(&profile) && profile != drive::PROFILE;
                self.node(transfer.bus, transfer.node, |node| node.is_other = is_other);
            }
            [low, high] if Object::at(mux.index) == Some(Object::Statusword) => {
                let described = transfer.described.as_deref();
                if described.is_some_and(|object| !signal::is_drives(&value::as_mapped(object))) {
                    return;
                }
                let at = At::earlier(transfer.last, self.bus(setting, transfer.bus).last.cycle);
                let axis = drive::axis(mux.index).unwrap_or(0);
                self.with(done, transfer.bus, transfer.node, |node, pen, prefix| {
                    if described.is_some() || !node.is_other {
                        node.reports(pen, prefix, (axis, false), u16::from_le_bytes([low, high]), at);
                    }
                });
            }
            _ => {}
        }
    }

    /// Takes a finding: that somebody or something is lost.
    pub(super) fn finding(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, finding: &Finding) {
        match (finding.code, finding.node) {
            (Code::Cap002, _) => self.lost(done, setting, finding.bus),
            (Code::Cap004, _) => {
                for index in 0..self.buses.len() {
                    self.lost(done, setting, BusId(index as u8));
                }
            }
            (Code::Hbt002, Some(node)) => {
                let heard = finding.cause.and_then(|cause| cause.t_ns);
                let over = heard.zip(measured(finding, "limit")).map(|(heard, limit)| heard.saturating_add(limit));
                self.lose(done, setting, finding, node, (Standing::Lost(Word::HeartbeatLost), over));
            }
            (Code::Grd002, Some(node)) => {
                self.lose(done, setting, finding, node, (Standing::Lost(Word::GuardingLost), None));
            }
            (Code::Hbt005, _) => {
                let silence = measured(finding, "silence").unwrap_or(0);
                let since = finding.at.t_ns.map(|now| now.saturating_sub(silence));
                let nodes = &self.bus(setting, finding.bus).nodes;
                let heard: Vec<u8> = nodes.iter().filter(|(_, node)| node.is_heard()).map(|(id, _)| *id).collect();
                for node in heard {
                    self.lose(done, setting, finding, node, (Standing::Unknown(Word::Silence), since));
                }
            }
            _ => {}
        }
    }

    /// Frames of a bus are missing behind its last one.
    pub(super) fn lost(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, bus: BusId) {
        self.bus(setting, bus);
        let Self { table, lang, buses, values, text, .. } = self;
        let Some(Bus { prefix, last, nodes, fresh, .. }) = buses.get_mut(usize::from(bus.0)) else { return };
        let mut pen = Pen { table, done, lang: *lang, text };
        for node in nodes.values_mut() {
            node.lose(&mut pen, prefix, Standing::Unknown(Word::Gap), None, *last);
            node.end_drives(&mut pen, prefix, false, *last);
            node.forget_errors(&mut pen, prefix, *last);
            node.forget(*last);
        }
        *fresh = 0;
        values.end(&mut pen, bus, None, *last);
    }

    /// The capture is over.
    pub(super) fn finish(&mut self, done: &mut Vec<Batch>) {
        self.settle(done, 0);
        self.held_back(done);
        self.table.finish(done);
    }

    /// The batch that runs ends.
    pub(super) fn flush(&mut self, done: &mut Vec<Batch>) {
        self.held_back(done);
        self.table.flush(done);
    }

    fn held_back(&mut self, done: &mut Vec<Batch>) {
        let Self { table, lang, channels, text, .. } = self;
        channels.flush(&mut Pen { table, done, lang: *lang, text });
    }

    fn settle(&mut self, done: &mut Vec<Batch>, cycle: u64) {
        let Self { table, lang, buses, channels, text, .. } = self;
        let name = |bus: BusId| buses.get(usize::from(bus.0)).map_or_else(String::new, |bus| bus.prefix.clone());
        channels.settle(&mut Pen { table, done, lang: *lang, text }, cycle, name);
    }

    /// A bus, known from now on.
    fn bus(&mut self, setting: Setting<'_>, id: BusId) -> &mut Bus {
        let index = usize::from(id.0);
        while self.buses.len() <= index {
            let name = setting.buses.name(BusId(self.buses.len() as u8));
            self.buses.push(Bus { prefix: prefix(name), ..Bus::default() });
        }
        // It is there: the loop has made it.
        &mut self.buses[index]
    }
}
