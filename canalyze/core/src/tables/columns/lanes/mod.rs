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
//! | `pdo/BUS/nodeN/TPDO1` | never a state: null where samples of its quantities do not hold on | |
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

use self::node::{Node, NodeState};
use self::rows::{At, Pen, prefix};
use self::transfers::Channels;
use self::values::Values;
use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::{BusId, Frame};
use crate::rules::finding::{Code, Finding};
use crate::sdo::transfer::Transfer;
use crate::sdo::wire::Side;
use crate::tables::selection::Selection;
use crate::tables::setting::Setting;
use crate::tables::table::{Moment, U64, Word as Choice, table};
use crate::wire::error_control::BOOT_UP;
use crate::wire::nmt;
use crate::words::Lang;
use crate::words::lane::Word;
use crate::world::change::{Change, DriveEvidence, EmcyChange, LostBy};
use crate::world::event::{Event, Note, ProcessData, What};

/// A change of a lane.
#[derive(Clone, Copy)]
pub(in crate::tables) struct LaneChange<'a> {
    lane: &'a str,
    at: At,
    state: Option<&'a str>,
    class: Option<&'static str>,
}

table! {
    /// One row per change in a lane of the timeline.
    /// 一行是时间轴上一条状态条的一次变化
    Changes arrow "lanes", |_cx (()), one: LaneChange<'_>| {
        /// name of the lane
        /// 状态条的名称
        lane: Choice = one.lane;
        t: Moment or null = one.at.t_ns;
        frame: U64 = one.at.frame;
        cycle: U64 = one.at.cycle;
        /// text shown; empty where it ends
        /// 显示的文字；空表示不再有
        state: Choice or null = one.state;
        /// class of its colour
        /// 颜色类别
        class: Choice or null = one.class;
    }
}

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
    /// Nodes whose state is known only from a boot-up or a command to all, one bit each.
    fresh: u128,
}

/// The lanes.
#[derive(Debug)]
pub(super) struct Lanes {
    sheet: Sheet,
    buses: Vec<Bus>,
    values: Values,
    channels: Channels,
}

/// The table, and the text that is being written.
#[derive(Debug)]
struct Sheet {
    table: Table<Changes>,
    lang: Lang,
    /// Words being put together.
    text: Vec<u8>,
}

impl Sheet {
    fn pen<'a>(&'a mut self, done: &'a mut Vec<Batch>) -> Pen<'a> {
        let Self { table, lang, text } = self;
        Pen { table, done, lang: *lang, text }
    }
}

/// The place of a frame; `shown`: the filter lets it through.
#[derive(Clone, Copy, Debug)]
struct Place<'a> {
    frame: &'a Frame,
    at: At,
    shown: bool,
}

impl Lanes {
    /// Returns lanes without rows. `selection`: the signals that have one.
    pub(super) fn new(lang: Lang, selection: Selection) -> Self {
        let sheet = Sheet { table: Table::default(), lang, text: Vec::new() };
        Self { sheet, buses: Vec::new(), values: Values::new(selection), channels: Channels::default() }
    }
}

impl Collector for Lanes {
    fn passing(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        let at = At::frame(frame, scene.cycle);
        let place = Place { frame, at, shown: scene.shown };
        self.know(scene.setting, frame.bus);
        // Losses that became due before the frame are behind its own event.
        for event in events.iter().skip(1) {
            self.lost(done, event, scene.cycle);
        }
        let Some(bus) = self.buses.get_mut(usize::from(frame.bus.0)) else { return };
        bus.last = at;
        self.channels.frame(frame.bus, at);
        for event in events {
            match &event.what {
                What::Pdo(data) => self.process_data(done, place, data),
                What::Change(Change::Drive { .. }) => {
                    let at = if event.at.no == frame.no { at } else { At::of(event.at, event.bus, scene.cycles) };
                    self.drive(done, event, at, scene.shown);
                }
                What::Change(change) => self.change(done, place, change),
                What::Sdo(step) => {
                    let node = event.node.unwrap_or(0);
                    self.sdo(done, place, step.side, node);
                    self.channels.step(event.transfer, step.side, node, frame);
                }
                What::Note(Note::NodeIdChanged { from, .. }) => self.left(done, place, *from),
                _ => {}
            }
        }
    }

    fn asides(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, events: &[Event]) {
        for event in events {
            self.lost(done, event, scene.cycles.at(event.bus, event.at.no));
            self.drive(done, event, At::of(event.at, event.bus, scene.cycles), true);
        }
    }

    /// Frames are missing.
    fn about_capture(&mut self, done: &mut Vec<Batch>, finding: &Finding) {
        match finding.code {
            Code::Cap002 => self.gap(done, finding.bus),
            Code::Cap004 | Code::Cap008 => {
                for index in 0..self.buses.len() {
                    self.gap(done, BusId(index as u8));
                }
            }
            _ => {}
        }
    }

    /// Frames of a bus are missing behind its last one: no state is known any more.
    fn gap(&mut self, done: &mut Vec<Batch>, id: BusId) {
        let Some(bus) = self.buses.get_mut(usize::from(id.0)) else { return };
        let Bus { prefix, last, nodes, fresh, .. } = bus;
        let mut pen = self.sheet.pen(done);
        for node in nodes.values_mut() {
            node.lose(&mut pen, prefix, NodeState::Unknown(Word::Gap), None, *last);
            node.end_drives(&mut pen, prefix, false, *last);
            node.forget_errors(&mut pen, prefix, *last);
            node.forget();
        }
        *fresh = 0;
        self.values.end(&mut pen, id, None, *last);
    }

    fn transfer(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, transfer: &Transfer) {
        let cycles = scene.cycles;
        self.know(scene.setting, transfer.bus);
        let Some(bus) = self.buses.get_mut(usize::from(transfer.bus.0)) else { return };
        self.channels.take(&mut self.sheet.pen(done), &bus.prefix, cycles, transfer);
    }

    fn finish(&mut self, done: &mut Vec<Batch>, _: TableContext<'_>) {
        self.channels.flush(&mut self.sheet.pen(done));
        self.sheet.table.finish(done);
    }

    fn flush(&mut self, done: &mut Vec<Batch>) {
        self.channels.flush(&mut self.sheet.pen(done));
        self.sheet.table.flush(done);
    }

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.sheet.table
    }
}

impl Lanes {
    /// A bus has a frame.
    fn know(&mut self, setting: Setting<'_>, bus: BusId) {
        while self.buses.len() <= usize::from(bus.0) && bus != BusId::NONE {
            let name = setting.buses.name(BusId(self.buses.len() as u8));
            self.buses.push(Bus { prefix: prefix(name), ..Bus::default() });
        }
    }

    /// A node, or every node, is lost.
    fn lost(&mut self, done: &mut Vec<Batch>, event: &Event, cycle: u64) {
        let What::Change(Change::Lost { node: lost, by, since_ns: t_ns }) = event.what else { return };
        let node_state = match by {
            LostBy::Heartbeat => NodeState::Lost(Word::HeartbeatLost),
            LostBy::Guarding => NodeState::Lost(Word::GuardingLost),
            LostBy::Silence => NodeState::Unknown(Word::Silence),
        };
        let Some(bus) = self.buses.get_mut(usize::from(event.bus.0)) else { return };
        let at = At { t_ns: event.at.t_ns, frame: event.at.no, cycle };
        let mut pen = self.sheet.pen(done);
        for (id, node) in &mut bus.nodes {
            if lost.is_some_and(|lost| lost != *id) || lost.is_none() && !node.is_heard() {
                continue;
            }
            bus.fresh &= !bit(*id);
            node.lose(&mut pen, &bus.prefix, node_state, t_ns, at);
            node.lose_drives(&mut pen, &bus.prefix, t_ns, at);
            // The frame at which it is found out may carry a PDO of the node itself.
            self.values.end_since(&mut pen, event.bus, Some(*id), at, bus.last);
        }
    }

    #[inline]
    fn process_data(&mut self, done: &mut Vec<Batch>, place: Place<'_>, data: &ProcessData) {
        let Some(bus) = self.buses.get_mut(usize::from(place.frame.bus.0)) else { return };
        let mut pen = self.sheet.pen(done);
        if data.transmit && (bus.present & bit(data.node) == 0 || bus.fresh & bit(data.node) != 0) {
            bus.sends(&mut pen, place, data.node);
        }
        let Bus { prefix, nodes, .. } = bus;
        if place.shown && self.values.is_same(place.frame, data) {
            return;
        }
        let at = place.frame.reference();
        if data.transmit && nodes.get(&data.node).is_some_and(|node| node.will_obey(at)) {
            if place.shown {
                self.values.late(&mut pen, place.frame, data, place.at);
            }
            return;
        }
        let pdo = (place.frame, place.at, place.shown);
        if self.values.change(&mut pen, prefix, pdo, data)
            && let Some(node) = nodes.get_mut(&data.node)
        {
            node.end_drives(&mut pen, prefix, true, place.at);
        }
    }

    /// A statusword shows the state of an axis, at a place.
    fn drive(&mut self, done: &mut Vec<Batch>, event: &Event, at: At, shown: bool) {
        let What::Change(Change::Drive { node, axis, state, by, .. }) = event.what else { return };
        let Some(bus) = self.buses.get_mut(usize::from(event.bus.0)).filter(|_| shown && by.is_sure()) else { return };
        let by_pdo = by != DriveEvidence::Sdo;
        let (prefix, node) = bus.parts(node);
        if !by_pdo || !node.will_obey(event.at) {
            node.reports(&mut self.sheet.pen(done), prefix, (axis, by_pdo), state, at);
        }
    }

    fn sdo(&mut self, done: &mut Vec<Batch>, place: Place<'_>, side: Side, node: u8) {
        let Some(bus) = self.buses.get_mut(usize::from(place.frame.bus.0)) else { return };
        match side {
            Side::Client => bus.node(node).managed = true,
            Side::Server if bus.present & bit(node) == 0 => bus.appears(&mut self.sheet.pen(done), place, node),
            Side::Server => {}
        }
    }

    fn change(&mut self, done: &mut Vec<Batch>, place: Place<'_>, change: &Change) {
        let id = place.frame.bus;
        let Some(bus) = self.buses.get_mut(usize::from(id.0)) else { return };
        let mut pen = self.sheet.pen(done);
        let at = place.frame.reference();
        match *change {
            Change::BootUp { node } => {
                bus.present |= bit(node);
                bus.node(node).boots(at);
                let (prefix, one) = bus.parts(node);
                one.stand(&mut pen, prefix, NodeState::BootUp, place.at, place.shown);
                bus.fresh |= bit(node);
                self.restart(done, place, node);
            }
            Change::State { node, state, .. } => {
                bus.present |= bit(node);
                let Some(node_state) = bus.node(node).shows(state, at) else { return };
                bus.fresh &= !bit(node);
                let (prefix, one) = bus.parts(node);
                if one.stand(&mut pen, prefix, node_state, place.at, place.shown) {
                    self.follow(done, place, node, node_state);
                }
            }
            Change::Command { command, node } => self.command(done, place, command, node),
            Change::Error(ref emcy @ EmcyChange { node, profile, .. }) => {
                if bus.present & bit(node) == 0 {
                    bus.appears(&mut pen, place, node);
                }
                let (prefix, one) = bus.parts(node);
                one.profile = profile;
                one.errors(&mut pen, prefix, emcy, place.at, place.shown);
            }
            _ => {}
        }
    }

    /// The master commands a node, or all of them (0).
    fn command(&mut self, done: &mut Vec<Batch>, place: Place<'_>, command: u8, addressed: u8) {
        let Some(state) = nmt::commanded_state(command) else { return };
        let Some(bus) = self.buses.get_mut(usize::from(place.frame.bus.0)) else { return };
        if (1..=127).contains(&addressed) {
            bus.node(addressed);
        }
        let at = place.frame.reference();
        let nodes: Vec<u8> = bus.nodes.keys().copied().filter(|id| addressed == 0 || addressed == *id).collect();
        for id in nodes {
            let Some(bus) = self.buses.get_mut(usize::from(place.frame.bus.0)) else { return };
            let present = bus.present & bit(id) != 0;
            let (prefix, node) = bus.parts(id);
            if state == BOOT_UP && node.has_obeyed(at) {
                node.managed |= addressed != 0;
                continue;
            }
            let node_state = node.commanded(state, addressed != 0, present, at);
            let news =
                node_state.filter(|one| node.stand(&mut self.sheet.pen(done), prefix, *one, place.at, place.shown));
            match news {
                // What it sends now says more.
                Some(NodeState::Unknown(_)) => bus.fresh |= bit(id),
                Some(_) => bus.fresh &= !bit(id),
                None => {}
            }
            if state == BOOT_UP {
                self.restart(done, place, id);
            } else if let Some(node_state) = news {
                self.follow(done, place, id, node_state);
            }
        }
    }

    /// A node is in another state now: its PDOs say nothing any more where it sends none.
    fn follow(&mut self, done: &mut Vec<Batch>, place: Place<'_>, id: u8, node_state: NodeState) {
        if node_state.has_pdos() {
            return;
        }
        let Some(bus) = self.buses.get_mut(usize::from(place.frame.bus.0)) else { return };
        let mut pen = self.sheet.pen(done);
        let (prefix, node) = bus.parts(id);
        node.end_drives(&mut pen, prefix, node_state.has_sdo(), place.at);
        self.values.end(&mut pen, place.frame.bus, Some(id), place.at);
    }

    /// A node starts anew: nothing that it said before holds.
    fn restart(&mut self, done: &mut Vec<Batch>, place: Place<'_>, id: u8) {
        let Some(bus) = self.buses.get_mut(usize::from(place.frame.bus.0)) else { return };
        let mut pen = self.sheet.pen(done);
        let (prefix, node) = bus.parts(id);
        node.end_drives(&mut pen, prefix, false, place.at);
        node.forget_errors(&mut pen, prefix, place.at);
        self.values.end(&mut pen, place.frame.bus, Some(id), place.at);
    }

    /// A node has another node-ID now.
    fn left(&mut self, done: &mut Vec<Batch>, place: Place<'_>, id: u8) {
        self.restart(done, place, id);
        let Some(bus) = self.buses.get_mut(usize::from(place.frame.bus.0)) else { return };
        bus.present &= !bit(id);
        bus.fresh &= !bit(id);
        let (prefix, node) = bus.parts(id);
        node.end_node_state(&mut self.sheet.pen(done), prefix, place.at);
    }
}

impl Bus {
    fn node(&mut self, id: u8) -> &mut Node {
        self.parts(id).1
    }

    fn parts(&mut self, id: u8) -> (&str, &mut Node) {
        (&self.prefix, self.nodes.entry(id).or_insert_with(|| Node::new(id)))
    }

    /// A node sends a PDO, and nothing has shown yet that it does.
    fn sends(&mut self, pen: &mut Pen<'_>, place: Place<'_>, id: u8) {
        if self.present & bit(id) == 0 {
            self.appears(pen, place, id);
        }
        let fresh = self.fresh & bit(id) != 0;
        let (prefix, node) = self.parts(id);
        if fresh && node.began_before(place.frame.no) {
            node.stand(pen, prefix, node.sends(), place.at, place.shown);
            self.fresh &= !bit(id);
        }
    }

    /// A node has sent something for the first time: a command that it was given counts.
    fn appears(&mut self, pen: &mut Pen<'_>, place: Place<'_>, id: u8) {
        self.present |= bit(id);
        let (prefix, node) = self.parts(id);
        if let Some(node_state) = node.appears() {
            node.stand(pen, prefix, node_state, place.at, place.shown);
        }
    }
}

/// The bit of a node.
fn bit(node: u8) -> u128 {
    1 << (node & 0x7F)
}
