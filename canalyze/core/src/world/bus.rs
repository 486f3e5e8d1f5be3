//! One bus: the owner of its nodes and channels, and the path of a frame through it.
//!
//! It looks up an identifier's role, passes SDO frames to their channel and others to the service's decoder, forwards
//! the effects of one service on another (a reset ends the node's transfers), and informs the checks. Only `learning`
//! changes a COB-ID, a mapping or a time by the capture.

mod drives;
mod learning;
mod process_data;
mod unconfirmed;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use self::learning::{known, renewed};
use crate::bytes::frame::{CanId, Frame, FrameRef, Kind};
use crate::bytes::ns::Ns;
use crate::checks;
use crate::checks::nodes::ErrorControl;
use crate::checks::srdo::SrdoResult;
use crate::checks::{Checks, PdoName};
use crate::evidence::When;
use crate::evidence::circumstance;
use crate::evidence::duplicates::Sighting;
use crate::evidence::recording::{ClockStep, Happened};
use crate::sdo::channel::{Interruption, is_whole};
use crate::sdo::exchange::expedited;
use crate::sdo::limits::UNANSWERED_NS;
use crate::sdo::state::SdoChannel;
use crate::sdo::transfer::Transfer;
use crate::sdo::wire::{Command, Mux, Side};
use crate::usdo::sessions::Usdo;
use crate::wire;
use crate::wire::cob_id::Role;
use crate::wire::error_frame;
use crate::wire::message::Message;
use crate::wire::nmt;
use crate::wire::pdo;
use crate::words::profiles::Profile;
use crate::world::change::Publisher;
use crate::world::context::Context;
use crate::world::dictionary::Described;
use crate::world::drive;
use crate::world::event::{Event, Step, What};
use crate::world::network::Network;
use crate::world::node::{Node, PerNode};
use crate::world::profile_defaults;
use crate::world::roles::Roles;

/// Maximum number of further SDO channels tracked (invariant 6).
const CHANNELS: usize = 1024;
/// Number of absent servers that shows a scan of the bus.
const SCANNED: usize = 8;

/// The state of one bus.
#[derive(Debug)]
pub struct Bus {
    roles: Roles,
    nodes: PerNode<Node>,
    /// Default SDO channels by the server's node-ID (with identifier `None`), then further ones by theirs.
    channels: BTreeMap<(u8, Option<CanId>), Box<SdoChannel>>,
    /// The USDO transfers; boxed, since few buses have them.
    usdo: Box<Usdo>,
    checks: Checks,
    /// The earliest time at which a channel decides something without a frame, in ns.
    due_ns: Option<Ns>,
    /// Time of the first frame, or of the first after lost frames, in ns.
    began_ns: Option<Ns>,
    /// The last frame is a duplicate in the capture.
    again: bool,
    /// Nodes whose boot-up was seen, without a later reset or lost frames.
    booted: BTreeSet<u8>,
    /// The last write to each node that may still be answered.
    open_writes: BTreeMap<u8, (Mux, When)>,
    /// The earliest time of one of them or an earlier time, in ns.
    writes_since_ns: Ns,
    publisher: Publisher,
}

impl Bus {
    /// Creates the state of a bus.
    pub fn new(network: Arc<Network>, name: &[u8]) -> Self {
        let mut nodes = PerNode::<Node>::default();
        // Data given for this bus by name override data given for every bus, so they come last.
        let mut descriptions: Vec<_> = network.descriptions.iter().collect();
        descriptions.sort_by_key(|one| one.bus.is_some());
        for one in descriptions {
            if Network::holds(one.bus.as_ref(), name) {
                known(&mut nodes, one.node).configuration.describe(Arc::clone(&one.dictionary));
            }
        }
        for one in &network.cobs {
            if Network::holds(one.bus.as_ref(), name) {
                let frame = if one.id.is_extended() { 1 << 29 } else { 0 };
                let index = pdo::communication_parameter(one.transmit, one.number);
                known(&mut nodes, one.node).configuration.set_option(index, 1, u64::from(one.id.raw()) | frame);
            }
        }
        for one in network.values.iter().filter(|one| Network::holds(one.bus.as_ref(), name)) {
            known(&mut nodes, one.node).configuration.set_option(one.index, one.sub, one.value);
        }
        for one in network.profiles.iter().filter(|one| Network::holds(one.bus.as_ref(), name)) {
            for ((index, sub), value) in profile_defaults::objects(one.number) {
                known(&mut nodes, one.node).configuration.assume(index, sub, value);
            }
        }
        for (_, node) in nodes.iter_mut() {
            node.compile_all();
        }
        let roles = Roles::compile(&network, name, &nodes);
        let renewed = renewed(&mut nodes);
        let checks = Checks::new(&network, &nodes, &renewed);
        Self {
            roles,
            nodes,
            channels: BTreeMap::new(),
            usdo: Box::default(),
            checks,
            due_ns: None,
            began_ns: None,
            again: false,
            booted: BTreeSet::new(),
            open_writes: BTreeMap::new(),
            writes_since_ns: Ns::MAX,
            publisher: Publisher::default(),
        }
    }

    /// Returns true if the last frame is a duplicate in the capture and was on the bus once.
    pub fn shows_again(&self) -> bool {
        self.again
    }

    /// Returns the current SYNC cycle; 0 before the first.
    pub fn sync_cycle(&self) -> u64 {
        self.checks.sync.cycle()
    }

    /// Returns the shortest synchronous window, in ns; `None` if there is none or none is known.
    pub fn sync_window_ns(&self) -> Option<Ns> {
        self.checks.sync.least_window_ns()
    }

    /// Returns the period of SYNC in ns, as configured, else as measured; `None` if unknown or irregular.
    pub fn sync_period_ns(&self) -> Option<Ns> {
        self.checks.sync.period_ns()
    }

    /// Returns the heartbeat period of a node in ns if known, by 1017h or its heartbeats.
    pub fn heartbeat_period(&self, node: u8) -> Option<Ns> {
        self.checks.nodes.heartbeat_period(node)
    }

    /// Returns true if nothing but its supply explains the last boot-up of a node, which reported states before.
    pub fn booted_unasked(&self, node: u8) -> bool {
        self.checks.nodes.booted_unasked(node)
    }

    /// Returns the last reported or commanded state of a node, coded as in a heartbeat.
    pub fn state(&self, node: u8) -> Option<u8> {
        self.checks.nodes.state(node)
    }

    /// Returns the kind of error control by which a node is overdue at `now_ns`, so that its last reported state may be
    /// outdated.
    pub fn silent(&self, node: u8, now_ns: Option<Ns>) -> Option<ErrorControl> {
        self.checks.nodes.silent(node, now_ns)
    }

    /// Returns the last reported state of each axis of a drive, with the axis number from 0.
    pub fn drive_states(&self, node: u8) -> impl Iterator<Item = (usize, drive::DriveState)> {
        self.drive_reports(node).map(|(axis, state, _)| (axis, state))
    }

    /// Returns the axes of a drive that were in fault when first seen and have shown no other state: number from 0,
    /// statusword, and the first frame that reported it.
    pub fn found_in_fault(&self, node: u8) -> impl Iterator<Item = (usize, u16, FrameRef)> {
        self.checks.drives.found_in_fault(node)
    }

    /// Returns the last reported state of each axis with its frame.
    pub fn drive_reports(&self, node: u8) -> impl Iterator<Item = (usize, drive::DriveState, FrameRef)> {
        self.publisher.axes(node)
    }

    /// Returns a node if anything is known of it.
    pub fn node(&self, node: u8) -> Option<&Node> {
        self.nodes.get(node)
    }

    /// Returns the role of an 11-bit identifier by the knowledge of the nodes.
    pub fn carries(&self, id: u16) -> Role {
        self.roles.of(CanId::standard(id))
    }

    /// Returns the nodes that have a TPDO with an identifier, one bit each, by their configuration or the pre-defined
    /// connection set.
    pub fn producers(&self, id: CanId) -> u128 {
        let sends = |node: &Node| node.pdos().iter().any(|pdo| pdo.transmit && pdo.cob.0.valid && pdo.cob.0.id == id);
        let known =
            self.nodes.iter().filter(|(_, node)| sends(node)).fold(0, |all, (node, _)| all | 1 << (node & 0x7F));
        match self.roles.of(id) {
            Role::Tpdo { node, .. } if known == 0 => 1 << (node & 0x7F),
            _ => known,
        }
    }

    /// Returns the running SDO transfers by server, with descriptions of their objects.
    pub fn running(&self) -> impl Iterator<Item = (&Transfer, Described)> {
        self.channels.values().filter_map(|channel| channel.running())
    }

    /// Takes one frame: appends its own event, then what became due before it, then its consequences.
    #[inline]
    pub fn step(&mut self, frame: &Frame, happened: Option<&Happened>, cx: &mut Context<'_>) {
        self.began_ns = self.began_ns.or(frame.t_ns);
        let role = self.roles.of(frame.id);
        cx.evidence.recording.take(&mut cx.when, happened, frame, role.is_command());
        let waits = |now: Ns| now - self.writes_since_ns <= UNANSWERED_NS;
        let role = if cx.when.at.t_ns.is_none_or(waits) { role } else { self.role_after_writes(frame, cx) };
        cx.sighting =
            cx.evidence.recording.sighting(cx.at, happened.map_or(Sighting::Original, |happened| happened.sighting));
        self.again = cx.sighting == Sighting::Duplicate;
        if cx.evidence.recording.is_first_of_stall(cx.when) {
            cx.evidence.circumstances.note(circumstance::CircumstanceKind::Stall, None, cx.when);
        }
        let silence = happened.and_then(|happened| happened.silence.as_ref());
        if let Some(paused) = silence.map(|silence| silence.paused).filter(|paused| *paused != 0) {
            let only = (paused.count_ones() == 1).then(|| paused.trailing_zeros() as u8);
            cx.evidence.circumstances.note(circumstance::CircumstanceKind::Pause, only, cx.when);
        }
        let start = cx.events.len();
        if let Some(step) = happened.and_then(|happened| happened.step) {
            cx.evidence.circumstances.note(circumstance::CircumstanceKind::Gap, None, cx.when);
            if step == ClockStep::NewRecording {
                cx.release_all();
                self.checks.lost(cx);
                self.doubt(cx.at.no.saturating_sub(1));
            }
        }
        let before = cx.events.split_off(start);
        if cx.sighting != Sighting::Duplicate && self.roles.unconfirmed(frame.id).is_none() {
            cx.evidence.services.take(role, frame);
        }
        let data = frame.kind != Kind::Remote && frame.kind != Kind::Error;
        match role {
            Role::SdoRequest(node) if frame.kind == Kind::Data => self.sdo(Side::Client, node, frame, cx),
            Role::SdoResponse(node) if frame.kind == Kind::Data => self.sdo(Side::Server, node, frame, cx),
            Role::SdoRequest(_) | Role::SdoResponse(_) if matches!(frame.kind, Kind::Fd { .. }) => {
                self.usdo(role, frame, cx);
            }
            Role::Tpdo { number, node } if data => {
                self.process_data(PdoName { transmit: true, number, node }, frame, cx);
            }
            Role::Rpdo { number, node } if data => {
                self.process_data(PdoName { transmit: false, number, node }, frame, cx);
            }
            Role::Srdo { number, inverted } if frame.kind == Kind::Data => self.srdo(number, inverted, frame, cx),
            _ => self.message(role, frame, cx),
        }
        if !before.is_empty() {
            let place = (start + 1).min(cx.events.len());
            cx.events.splice(place..place, before);
        }
        if let Some(now_ns) = frame.t_ns {
            self.rest(now_ns, cx);
        }
        // Findings explained by this frame go out with it, regardless of the clock.
        cx.release();
        self.note_changes(1, cx);
    }

    /// Returns true if only the channel's next frame may show the meaning of an SDO frame, because a transfer from
    /// before the capture may run.
    #[inline]
    pub fn is_ambiguous(&self, frame: &Frame) -> bool {
        matches!(self.roles.of(frame.id), Role::SdoRequest(_) | Role::SdoResponse(_)) && self.is_ambiguous_sdo(frame)
    }

    fn is_ambiguous_sdo(&self, frame: &Frame) -> bool {
        if frame.kind != Kind::Data {
            return false;
        }
        self.channel_of(frame).is_some_and(|key| {
            let whole =
                |now: Ns| self.booted.contains(&key.0) || self.began_ns.is_some_and(|began| is_whole(now - began));
            let side = if matches!(self.roles.of(frame.id), Role::SdoRequest(_)) { Side::Client } else { Side::Server };
            let channel = self.channels.get(&key);
            channel.map_or_else(|| !frame.t_ns.is_some_and(whole), |channel| channel.is_ambiguous(side, frame))
        })
    }

    /// Returns true if two frames belong to the same SDO channel.
    pub fn is_of_channel(&self, one: &Frame, other: &Frame) -> bool {
        other.kind == Kind::Data && self.channel_of(one).is_some_and(|key| self.channel_of(other) == Some(key))
    }

    /// Returns the key of a frame's SDO channel.
    fn channel_of(&self, frame: &Frame) -> Option<(u8, Option<CanId>)> {
        match self.roles.of(frame.id) {
            Role::SdoRequest(node) | Role::SdoResponse(node) => Some((node, self.roles.channel(frame.id))),
            _ => None,
        }
    }

    /// Returns the channel's next frame if it was read ahead.
    fn read_ahead(&self, cx: &Context<'_>) -> Option<(Side, Frame)> {
        let next = cx.next?;
        match self.roles.of(next.id) {
            Role::SdoRequest(_) => Some((Side::Client, *next)),
            Role::SdoResponse(_) => Some((Side::Server, *next)),
            _ => None,
        }
    }

    fn sdo(&mut self, side: Side, node: u8, frame: &Frame, cx: &mut Context<'_>) {
        let key = (node, self.roles.channel(frame.id));
        let next = self.read_ahead(cx);
        if self.channels.len() >= CHANNELS && !self.channels.contains_key(&key) {
            return self.message(Role::Unassigned, frame, cx);
        }
        let nodes = &self.nodes;
        let heard_ns = frame.t_ns.zip(self.began_ns).map_or(Ns::ZERO, |(now, began)| now - began);
        let booted = self.booted.contains(&node);
        let channel = self.channels.entry(key).or_insert_with(|| {
            let mut channel = Box::new(SdoChannel::new(frame.bus, node, key.1));
            channel.idle_for(heard_ns, booted);
            channel.describe(nodes.get(node).and_then(|node| node.configuration.description()).map(Arc::clone));
            channel
        });
        let profile = self.nodes.get(node).map_or(Profile::UNKNOWN, Node::profile);
        channel.follows(profile);
        channel.is_of_node(key.1.is_none() && self.checks.nodes.state(node).is_some());
        let before = cx.events.len();
        channel.asked_in_vain(key.1.is_none().then(|| self.checks.nodes.asked_in_vain(node)).flatten());
        channel.step(side, frame, next.as_ref(), cx);
        self.due_ns = [self.due_ns, channel.due()].into_iter().flatten().min();
        let unanswered = channel.is_unanswered();
        if cx.sighting == Sighting::Duplicate {
            return;
        }
        self.checks.due(frame, cx);
        if key.1.is_none() {
            let (object, aborts) = match cx.events.get(before).map(|event| &event.what) {
                Some(What::Sdo(step)) => (step.mux.or(step.command.mux()), matches!(step.command, Command::Abort(..))),
                _ => (None, false),
            };
            self.checks.sdo((side, aborts), node, object, cx);
        }
        for place in before..cx.events.len() {
            match cx.events.get(place).map(|event| &event.what) {
                Some(What::Transfer(transfer)) => {
                    let transfer = Arc::clone(transfer);
                    self.ended(&transfer, cx);
                }
                Some(What::Sdo(Step { command: Command::InitiateDownload(mux, i), .. })) => {
                    let mux = *mux;
                    let i = *i;
                    if i.expedited {
                        let bytes = i.data.get(..i.expedited_len(frame.len)).unwrap_or(&i.data);
                        self.checks.requested(node, mux, bytes, cx);
                    }
                    self.doubt_object(node, mux, cx);
                    let bytes = if i.expedited { expedited(Some(mux), profile, &i, frame.len) } else { &[] };
                    self.request(node, mux, bytes, unanswered, cx);
                }
                Some(What::Sdo(Step { side: Side::Server, command: Command::Abort(mux, _), .. })) => {
                    let mux = *mux;
                    self.withdraw(node, mux.index, Some(mux.sub));
                }
                Some(What::Sdo(Step { command: Command::DownloadInitiated(mux), .. })) => {
                    let mux = *mux;
                    self.checks.acknowledged(node, mux, frame, cx);
                    self.doubt_object(node, mux, cx);
                }
                _ => {}
            }
        }
        if let Some(transfer) = self.channels.get(&key).and_then(|channel| channel.confirmed()).map(Arc::clone) {
            self.ended(&transfer, cx);
        }
    }

    /// Takes an FD frame on an identifier of SDO.
    fn usdo(&mut self, role: Role, frame: &Frame, cx: &mut Context<'_>) {
        let message = wire::decode(role, frame);
        if !matches!(message, Message::Usdo { .. }) {
            return self.message(role, frame, cx);
        }
        let before = cx.events.len();
        self.usdo.step(message, frame, &self.nodes, cx);
        if cx.sighting == Sighting::Duplicate {
            return;
        }
        self.checks.due(frame, cx);
        self.took(before, cx);
    }

    /// Takes the transfers that have ended in the events from a place on.
    fn took(&mut self, before: usize, cx: &mut Context<'_>) {
        for place in before..cx.events.len() {
            if let Some(What::Transfer(transfer)) = cx.events.get(place).map(|event| &event.what) {
                let transfer = Arc::clone(transfer);
                self.ended(&transfer, cx);
            }
        }
    }

    /// Takes a transfer that has ended, or seems to have.
    fn ended(&mut self, transfer: &Transfer, cx: &mut Context<'_>) {
        self.uploaded(transfer, cx);
        self.learn(transfer, cx);
        self.checks.ended(transfer, &self.nodes, cx);
    }

    fn srdo(&mut self, number: u8, inverted: bool, frame: &Frame, cx: &mut Context<'_>) {
        let duplicate = cx.sighting == Sighting::Duplicate;
        let seen = if duplicate {
            SrdoResult::default()
        } else {
            self.checks.safety(number, inverted, frame, &self.nodes, cx)
        };
        let mut message = wire::decode(Role::Srdo { number, inverted }, frame);
        if let Message::Srdo { valid, .. } = &mut message {
            *valid = seen.valid;
        }
        cx.push(None, message.node(), What::Message(message));
        if duplicate {
            return;
        }
        self.checks.due(frame, cx);
        self.checks.shown(&seen, cx);
    }

    fn message(&mut self, role: Role, frame: &Frame, cx: &mut Context<'_>) {
        if cx.sighting == Sighting::Duplicate {
            let message = wire::decode(role, frame);
            return cx.push(None, message.node(), What::Message(message));
        }
        if cx.evidence.services.is_other(role) {
            let message = wire::decode(role, frame);
            cx.push(None, message.node(), What::Message(message));
            return self.checks.due(frame, cx);
        }
        let message = self.checks.nodes.complete(wire::decode(role, frame), &self.nodes, cx);
        cx.push(None, message.node(), What::Message(message));
        self.checks.due(frame, cx);
        self.note_changes(1, cx);
        let own = cx.events.len();
        if let Some((from, to)) = self.checks.message(&message, &self.nodes, frame, cx) {
            self.moved(from, to);
        }
        match message {
            Message::BootUp { node } => {
                self.reset(Some(node), Interruption::BootUp, cx);
                self.booted.insert(node);
                self.channels
                    .values_mut()
                    .filter(|channel| channel.node() == node)
                    .for_each(|channel| channel.boot_up());
            }
            Message::ErrorFrame if error_frame::is_deaf(frame) => self.lost(None, Interruption::LostFrames, cx),
            Message::Nmt { command, node: 0 } if nmt::is_reset(command) => self.reset(None, Interruption::Command, cx),
            Message::Nmt { command, node } if nmt::is_reset(command) => {
                self.reset(Some(node), Interruption::Command, cx)
            }
            _ => {}
        }
        self.checks.follow(&message, &self.nodes, frame, cx);
        if let Message::BootUp { node } = message {
            let twice = self.checks.nodes.booted_twice(node);
            let own = self.channels.values_mut().filter(|channel| channel.node() == node);
            own.for_each(|channel| channel.booted_twice(twice));
        }
        self.publish(&message, own, cx);
    }

    /// Publishes the change that a message shows, before its findings.
    #[inline]
    fn publish(&mut self, message: &Message, place: usize, cx: &mut Context<'_>) {
        let reported = message.role().node().and_then(|node| self.checks.nodes.reported(node));
        let Some(change) = self.publisher.message(message, reported, self.checks.sync.cycle()) else { return };
        let node = change.node();
        let what = What::Change(change);
        cx.events.insert(place, Event { at: cx.at, about: None, bus: cx.bus, node, transfer: None, what });
    }

    /// Takes the changes that were published from a place on.
    #[inline]
    fn note_changes(&mut self, from: usize, cx: &Context<'_>) {
        if cx.events.len() > from {
            self.note_changes_from(from, cx);
        }
    }

    #[inline(never)]
    fn note_changes_from(&mut self, from: usize, cx: &Context<'_>) {
        for event in cx.events.iter().skip(from) {
            if let What::Change(change) = &event.what {
                self.publisher.published(change);
            }
        }
    }

    /// Takes an error frame without content.
    pub fn bare_error(&mut self, cx: &mut Context<'_>) {
        self.checks.error_frames.bare(cx);
    }

    /// Reports what should have happened by `now_ns`, at the current frame.
    pub fn advance(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        cx.release();
        self.checks.advance(now_ns, cx);
        self.rest(now_ns, cx);
        self.note_changes(0, cx);
    }

    /// Lets quiet SDO channels decide what has waited long enough at `now_ns`.
    #[inline]
    fn rest(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        self.usdo.rest(now_ns, cx);
        if self.due_ns.is_some_and(|due_ns| now_ns > due_ns) {
            self.decide(now_ns, cx);
        }
    }

    #[inline(never)]
    fn decide(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        let before = cx.events.len();
        self.look_for_scan();
        for ((node, id), channel) in &mut self.channels {
            channel.asked_in_vain(id.is_none().then(|| self.checks.nodes.asked_in_vain(*node)).flatten());
            channel.rest(now_ns, cx);
        }
        self.due_ns = self.channels.values().filter_map(|channel| channel.due()).min();
        self.took(before, cx);
    }

    /// Resets a node (or all): its transfers end, and written values that were not stored are gone.
    fn reset(&mut self, node: Option<u8>, by: Interruption, cx: &mut Context<'_>) {
        self.lost(node, by, cx);
        self.booted.retain(|one| node.is_some_and(|node| node != *one));
        self.checks.reset(node, cx);
        self.publisher.restart(node, cx.at);
        let mut changed = false;
        for (id, one) in self.nodes.iter_mut() {
            if node.is_none_or(|node| node == id) && one.configuration.reset() {
                one.compile();
                changed = true;
            }
        }
        if changed {
            self.assign();
            self.reconfigured();
        }
    }

    /// Closes what was open on all nodes after lost frames.
    /// `goes_on`: the recording is the same on both sides, so that its nodes are expected again.
    pub fn lost_frames(&mut self, goes_on: bool, cx: &mut Context<'_>) {
        if goes_on {
            self.checks.nodes.expect_again();
        }
        self.lost(None, Interruption::LostFrames, cx);
    }

    /// Closes what was open on one node (or all) after a reset or lost frames.
    fn lost(&mut self, node: Option<u8>, by: Interruption, cx: &mut Context<'_>) {
        let concerned = |of: &u8| node.is_none_or(|node| node == *of);
        let open: Vec<_> =
            self.open_writes.iter().filter(|(of, _)| concerned(of)).map(|(of, it)| (*of, it.0)).collect();
        for (of, mux) in open {
            self.unanswered(of, mux);
        }
        if by == Interruption::LostFrames {
            self.began_ns = None;
            self.booted.clear();
            cx.release_all();
            cx.evidence.recording.lost();
            cx.evidence.circumstances.note(circumstance::CircumstanceKind::Gap, None, cx.when);
            self.checks.lost(cx);
            self.publisher.forget(cx.at);
            self.doubt(cx.at.no);
        }
        for channel in self.channels.values_mut() {
            if node.is_none_or(|node| node == channel.node()) {
                channel.lost(by, cx);
            }
        }
        self.usdo.lost(node, by, &self.nodes, cx);
    }

    /// Doubts earlier observations after frames were lost behind the frame `last`.
    fn doubt(&mut self, last: u64) {
        let mut changed = false;
        for (_, node) in self.nodes.iter_mut() {
            if node.configuration.doubt(last) {
                node.compile();
                changed = true;
            }
        }
        if changed {
            self.reconfigured();
        }
    }

    /// Marks servers as scanned: a client that asks all node-IDs does not expect all to answer.
    fn look_for_scan(&mut self) {
        if self.channels.values().filter(|channel| channel.is_probed()).count() > SCANNED {
            self.channels.values_mut().for_each(|channel| channel.scanned(channel.is_probed()));
        }
    }

    /// Reports what is open at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        let sdo = self.channels.values().map(|channel| (channel.is_sdo(), channel.frames()));
        self.checks.conclude(sdo.chain(self.usdo.shown()), cx);
        self.look_for_scan();
        self.channels.values_mut().for_each(|channel| channel.others_answer(cx));
        let one_sided: Vec<_> =
            self.channels.values().filter_map(|channel| channel.one_sided()).chain(self.usdo.one_sided()).collect();
        checks::one_sided::conclude(&one_sided, cx);
        for ((node, id), channel) in &mut self.channels {
            channel.asked_in_vain(id.is_none().then(|| self.checks.nodes.asked_in_vain(*node)).flatten());
            channel.scanned(channel.one_sided().is_some());
            channel.finish(cx);
        }
        self.usdo.finish(&self.nodes, cx);
        self.checks.finish(&self.nodes, cx);
        cx.release_all();
        cx.release_unproven();
    }
}

#[cfg(test)]
mod tests;
