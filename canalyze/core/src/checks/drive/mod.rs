//! Drives (CiA 402): whether states follow from commands, commands are obeyed, faults announced and modes taken.
//!
//! For every axis of every node the controlwords it is given and the statuswords it reports are followed, whether
//! PDOs or SDO carry them. 6040h and 6041h are something else on an encoder or a valve: judged are nodes whose device
//! type is known to be a drive's, and those of unknown type that have climbed by CiA 402's steps and never showed
//! another coding. A controlword that may have come unseen excuses everything.
//!
//! It must not read a configuration but the mappings of PDOs, and must not decode a state (`drive` does).

mod controlwords;
mod effect;
mod fault;
mod watch;

use self::controlwords::Controlwords;
use self::effect::{Order, leads_out};
use self::fault::EmcyDue;
use self::watch::{Watch, Watched};
use super::PdoName;
use crate::context::Context;
use crate::drive::{self, Command, Object, Reach, State};
use crate::finding::{Code, Finding};
use crate::frame::{Frame, FrameRef};
use crate::node::{Node, PerNode};
use crate::profiles::Profile;
use crate::rules::drive::{Drv001, Drv004};
use crate::services::pdo::mapping::extract;
use crate::services::sdo::transfer::{Direction, Status, Transfer};
use crate::services::sdo::wire::Mux;
use crate::wire::error_control::OPERATIONAL;

/// Time for a command that takes away, and for a mode.
const PROMPT: i64 = 1_000_000_000;
/// Steps upward that show a node of unknown type to be a drive.
const PROOF: u8 = 2;

/// A statusword as it was reported.
#[derive(Clone, Copy, Debug)]
struct Sample {
    word: u16,
    state: State,
    at: FrameRef,
}

/// A change of state that no controlword explains so far.
#[derive(Clone, Copy, Debug)]
struct Jump {
    axis: u8,
    from: Sample,
    to: Sample,
}

/// A mode of operation that was requested.
#[derive(Clone, Copy, Debug)]
struct Request {
    mode: i8,
    at: FrameRef,
    /// Since when it may be expected in the display.
    since_ns: Option<i64>,
    /// Reports of another one since then.
    reports: u8,
    raised: bool,
}

/// What is known of one axis.
#[derive(Clone, Debug, Default)]
struct Axis {
    controlwords: Controlwords,
    sample: Option<Sample>,
    /// The first report, where it shows a fault and no other state has followed.
    found: Option<Sample>,
    jump: Option<Jump>,
    /// The finding about it, of a node that is not yet known to be a drive.
    suspect: Option<Box<Finding>>,
    order: Option<Order>,
    /// The first fault reset without effect since it is in fault.
    vain: Option<FrameRef>,
    request: Option<Request>,
    likeness: Likeness,
}

/// Whether an axis behaves as one of a drive.
#[derive(Clone, Copy, Debug, Default)]
struct Likeness {
    /// Steps upward that controlwords explain.
    climbed: u8,
    /// It showed a statusword that CiA 402 does not know.
    strange: bool,
}

/// What is known of one node.
#[derive(Debug, Default)]
struct Drive {
    axes: [Option<Box<Axis>>; drive::AXES as usize],
    /// Its last EMCY with an error.
    emcy: Option<FrameRef>,
    /// The last fault of any axis that nothing explained.
    fault: Option<FrameRef>,
    /// It has booted up in the capture.
    fresh: bool,
}

/// The drives of a bus.
#[derive(Debug, Default)]
pub struct Drives {
    nodes: PerNode<Drive>,
    watch: Watch,
    emcy_due: EmcyDue,
}

/// Where a value was seen, and what the bus knows of the node it belongs to.
#[derive(Clone, Copy, Debug)]
struct Place<'a> {
    node: &'a Node,
    axis: u8,
    at: FrameRef,
    state: Option<u8>,
    by_pdo: bool,
}

impl Drives {
    /// PDOs that are other ones now.
    pub fn renewed(&mut self, pdos: &[PdoName]) {
        self.watch.renewed(pdos);
    }

    /// The states that a node's axes have reported last, by their number from 0.
    pub fn states(&self, node: u8) -> impl Iterator<Item = (usize, State)> {
        self.reports(node).map(|(number, state, _)| (number, state))
    }

    /// The axes that were in fault when they were first seen, and have shown no other state: their number from 0, their
    /// statusword, and the frame that reported it first.
    pub fn found_in_fault(&self, node: u8) -> impl Iterator<Item = (usize, u16, FrameRef)> {
        let axes = self.nodes.get(node).into_iter().flat_map(|drive| drive.axes.iter().enumerate());
        axes.filter_map(|(number, axis)| {
            let found = axis.as_ref()?.found?;
            Some((number, found.word, found.at))
        })
    }

    /// The same with the frames that reported them.
    pub fn reports(&self, node: u8) -> impl Iterator<Item = (usize, State, FrameRef)> {
        let axes = self.nodes.get(node).into_iter().flat_map(|drive| drive.axes.iter().enumerate());
        axes.filter_map(|(number, axis)| {
            let sample = axis.as_ref()?.sample?;
            Some((number, sample.state, sample.at))
        })
    }

    /// Follows a PDO; `read`: it is known what it carries. `state` is the NMT state of a node, where known.
    pub fn process_data(
        &mut self,
        pdo: PdoName,
        (read, contradicted): (bool, bool),
        frame: &Frame,
        nodes: &PerNode<Node>,
        state: impl Fn(u8) -> Option<u8>,
        cx: &mut Context<'_>,
    ) {
        if !pdo.transmit && !read {
            self.blind(pdo.node, cx);
        }
        if !self.watch.holds(frame.id, nodes) {
            return;
        }
        let Self { nodes: drives, watch, emcy_due } = self;
        for Watched { node, transmit, number, objects } in watch.of(frame.id) {
            // An identifier has one sender; whose it is, is known to the bus.
            if *transmit && !(pdo.transmit && (pdo.node, pdo.number) == (*node, *number)) {
                continue;
            }
            let (Some(known), drive) = (nodes.get(*node), drives.entry(*node)) else { continue };
            if objects.is_empty() || contradicted && !*transmit {
                drive.blind(cx);
            }
            if contradicted {
                continue;
            }
            for part in objects {
                let Some(raw) = extract(frame.payload(), usize::from(part.offset), usize::from(part.bits)) else {
                    continue;
                };
                let place = Place { node: known, axis: part.axis, at: cx.at, state: state(*node), by_pdo: true };
                match (part.object, transmit) {
                    (Object::Controlword, false) => {
                        drive.sent(place, raw as u16, cx);
                        drive.taken(place, raw as u16);
                    }
                    (Object::ModesOfOperation, false) => drive.requested(place, raw as u8),
                    (Object::Statusword, true) => drive.reported(place, raw as u16, emcy_due, cx),
                    (Object::ModesOfOperationDisplay, true) => drive.displayed(place, raw as u8, cx),
                    _ => {}
                }
            }
        }
    }

    /// A controlword may have come that nobody can read.
    pub fn blind(&mut self, node: u8, cx: &mut Context<'_>) {
        if let Some(drive) = self.nodes.get_mut(node) {
            drive.blind(cx);
        }
    }

    /// Follows a write request of SDO, which a drive may obey before it answers.
    pub fn request(&mut self, node: u8, mux: Mux, bytes: &[u8], at: FrameRef) {
        if let (Some((axis, Object::Controlword)), &[low, high]) = (object(mux), bytes)
            && let Some(axis) = self.nodes.entry(node).axis(axis)
        {
            axis.controlwords.send(u16::from_le_bytes([low, high]), at);
        }
    }

    /// Follows an SDO transfer that has ended.
    pub fn transfer(&mut self, transfer: &Transfer, known: Option<&Node>, state: Option<u8>, cx: &mut Context<'_>) {
        let Some((mux, (axis, object))) = transfer.mux.and_then(|mux| Some((mux, object(mux)?))) else { return };
        let nobody = Node::new(transfer.node);
        let drive = self.nodes.entry(transfer.node);
        let place = Place { node: known.unwrap_or(&nobody), axis, at: cx.at, state, by_pdo: false };
        let whole = transfer.outcome.status == Status::Ok && !transfer.outcome.bad && !transfer.data.hole;
        let fits = Profile::DRIVE.data_type(mux.index, mux.sub).and_then(crate::od::DataType::size);
        if !whole || fits != Some(transfer.data.kept.len()) || transfer.data.size != transfer.data.kept.len() as u64 {
            if object == Object::Controlword && transfer.direction == Direction::Download {
                drive.blind(cx);
            }
            return;
        }
        let raw = transfer.data.kept.iter().rev().fold(0, |raw, byte| raw << 8 | u16::from(*byte));
        match (object, transfer.direction) {
            (Object::Controlword, Direction::Upload) => drive.sent(place, raw, cx),
            (Object::Controlword, Direction::Download) => {
                drive.sent(place, raw, cx);
                drive.taken(place, raw);
            }
            (Object::ModesOfOperation, Direction::Download) => drive.requested(place, raw as u8),
            (Object::Statusword, Direction::Upload) => drive.reported(place, raw, &mut self.emcy_due, cx),
            (Object::ModesOfOperationDisplay, Direction::Upload) => drive.displayed(place, raw as u8, cx),
            _ => {}
        }
    }

    /// Follows an EMCY, which announces what the node's axes have shown just before.
    pub fn emcy(&mut self, node: u8, code: u16, cx: &mut Context<'_>) {
        if code > 0xFF
            && let Some(drive) = self.nodes.get_mut(node)
        {
            drive.emcy = Some(cx.at);
            self.emcy_due.announced(node, cx);
        }
    }

    /// It is `now_ns`: faults that no EMCY has announced by now.
    #[inline]
    pub fn advance(&mut self, now_ns: i64, cx: &mut Context<'_>) {
        self.emcy_due.advance(now_ns, cx);
    }

    /// A node boots up: it has got no controlword yet.
    pub fn booted(&mut self, node: u8) {
        self.forget(Some(node));
        let drive = self.nodes.entry(node);
        drive.fresh = true;
        for axis in drive.axes.iter_mut().flatten() {
            axis.controlwords.fresh = true;
        }
    }

    /// A node (or all) was reset, or frames were lost: what was seen before explains nothing.
    pub fn forget(&mut self, node: Option<u8>) {
        self.emcy_due.forget(node);
        for (id, drive) in self.nodes.iter_mut() {
            if node.is_none_or(|node| node == id) {
                drive.fresh = false;
                for axis in drive.axes.iter_mut().flatten() {
                    **axis = Axis { likeness: axis.likeness, ..Axis::default() };
                }
            }
        }
    }
}

impl Drive {
    fn axis(&mut self, axis: u8) -> Option<&mut Axis> {
        let fresh = self.fresh;
        let slot = self.axes.get_mut(usize::from(axis))?;
        Some(
            &mut **slot
                .get_or_insert_with(|| Box::new(Axis { controlwords: Controlwords::new(fresh), ..Axis::default() })),
        )
    }

    fn blind(&mut self, cx: &mut Context<'_>) {
        self.fresh = false;
        for axis in self.axes.iter_mut().flatten() {
            axis.order = None;
            axis.controlwords.forget();
            axis.reconsider(cx);
        }
    }

    /// A controlword was sent: the drive may have taken it.
    fn sent(&mut self, place: Place<'_>, word: u16, cx: &mut Context<'_>) {
        if let Some(axis) = self.axis(place.axis) {
            axis.controlwords.by_pdo |= place.by_pdo;
            axis.controlwords.send(word, cx.at);
            axis.reconsider(cx);
        }
    }

    /// A controlword was sent that the drive must have taken.
    fn taken(&mut self, place: Place<'_>, word: u16) {
        let Some(axis) = self.axis(place.axis) else { return };
        let asked = word & 0x8F;
        if axis.controlwords.given == Some(asked) {
            return;
        }
        let command = axis.controlwords.given.and_then(|given| drive::command(word, Some(given)));
        axis.controlwords.given = Some(asked);
        let state = axis.sample.map(|sample| sample.state);
        // Only a fault reset leads out of a fault: the edge counts, whatever comes after it.
        if axis.order.is_some_and(|order| order.command == Command::FaultReset && state == Some(order.from)) {
            return;
        }
        axis.order = None;
        if let (Some(sample), Some(command)) = (axis.sample, command)
            && leads_out(sample.state, command)
            && place.at.t_ns.is_some()
            && place.heard()
        {
            axis.order = Some(Order { word, command, from: sample.state, at: place.at, reports: 0 });
        }
    }

    /// A mode of operation was requested.
    fn requested(&mut self, place: Place<'_>, mode: u8) {
        let mode = mode.cast_signed();
        let Some(axis) = self.axis(place.axis).filter(|_| place.heard()) else { return };
        if axis.request.is_none_or(|request| request.mode != mode) {
            let request = Request { mode, at: place.at, since_ns: place.at.t_ns, reports: 0, raised: false };
            // 0 asks for no change.
            axis.request = (mode != 0).then_some(request);
        }
    }

    /// A mode of operation is displayed.
    fn displayed(&mut self, place: Place<'_>, mode: u8, cx: &mut Context<'_>) {
        let mode = mode.cast_signed();
        let Some(axis) = self.axis(place.axis) else { return };
        let judged = axis.is_drive(place) && place.state.is_none_or(|state| state == OPERATIONAL);
        let Some(request) = &mut axis.request else { return };
        if mode == request.mode {
            (request.since_ns, request.reports, request.raised) = (place.at.t_ns, 0, false);
            return;
        }
        request.reports = request.reports.saturating_add(1);
        let after = elapsed(request.since_ns, place.at.t_ns).filter(|after| *after > PROMPT);
        let Some(after) = after.filter(|_| judged && !request.raised && request.reports >= 2) else { return };
        request.raised = true;
        let what = Drv004::StillDisplayed { requested: request.mode, displayed: mode, after };
        cx.raise(what, Some(place.node.id()), Some(display(place.axis)), Some(request.at));
    }

    /// A statusword is reported.
    fn reported(&mut self, place: Place<'_>, word: u16, emcy_due: &mut EmcyDue, cx: &mut Context<'_>) {
        let (emcy, mut fault) = (self.emcy, self.fault);
        let Some(axis) = self.axis(place.axis) else { return };
        let Some(state) = State::of(word) else {
            axis.likeness.strange = true;
            (axis.sample, axis.found, axis.jump, axis.order) = (None, None, None, None);
            return;
        };
        let sample = Sample { word, state, at: place.at };
        axis.effect(place, sample, cx);
        let of_drive = place.device().is_none_or(|profile| profile == u64::from(drive::PROFILE));
        axis.found = match axis.sample {
            None => Some(sample).filter(|_| state == State::Fault && of_drive && !axis.likeness.strange),
            Some(_) => axis.found.filter(|_| state == State::Fault),
        };
        let Some(before) = axis.sample.replace(sample).filter(|before| before.state != state) else { return };
        let judged = axis.is_drive(place);
        if !is_fault(state) {
            axis.vain = None;
        } else if !is_fault(before.state) && judged {
            emcy_due.entered(place, (before, sample), emcy, &mut fault, cx);
        }
        axis.follow(place, before, sample, judged, cx);
        if judged && let Some(finding) = axis.suspect.take() {
            cx.report(*finding);
        }
        self.fault = fault;
    }
}

impl Axis {
    /// A controlword has come, or may have, that explains the last change of state.
    fn reconsider(&mut self, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        let listed_late = |jump: &mut Jump| {
            !recording.is_settled(jump.to.at, cx.at) && self.controlwords.explain(&jump.from, &jump.to) != Some(false)
        };
        if let Some(Jump { axis, to, .. }) = self.jump.take_if(listed_late) {
            self.suspect.take_if(|finding| finding.at == to.at);
            let about = |at: FrameRef, object: Option<Mux>| at == to.at && object == Some(statusword(axis));
            cx.evidence.pending.withdraw(|finding| finding.code == Code::Drv001 && about(finding.at, finding.object));
        }
    }

    /// Whether the node is a drive.
    fn is_drive(&self, place: Place<'_>) -> bool {
        match place.device() {
            None => self.likeness.climbed >= PROOF && !self.likeness.strange,
            Some(profile) => profile == u64::from(drive::PROFILE),
        }
    }

    /// A state has followed another one.
    fn follow(&mut self, place: Place<'_>, before: Sample, sample: Sample, judged: bool, cx: &mut Context<'_>) {
        match self.controlwords.explain(&before, &sample) {
            Some(true) if matches!(drive::reach(before.state, sample.state), Reach::Directly(2..=4)) => {
                self.likeness.climbed = self.likeness.climbed.saturating_add(1);
            }
            Some(false) => {
                let remote = drive::remote(before.word) && drive::remote(sample.word);
                // A controlword in an unknown PDO is not seen.
                let all_seen = self.controlwords.by_pdo || place.state.is_some_and(|state| state != OPERATIONAL);
                let restarted = sample.state == State::NotReadyToSwitchOn;
                if remote && all_seen && !restarted {
                    self.jump = Some(Jump { axis: place.axis, from: before, to: sample });
                    let controlword = self.controlwords.before(sample.at);
                    let what = Drv001::Unexplained { from: before.word, to: sample.word, controlword };
                    let finding = cx.verdict(what, Some(place.node.id()), Some(statusword(place.axis)), None);
                    if judged {
                        cx.report_listed(finding);
                    } else if place.device().is_none() {
                        self.suspect.get_or_insert_with(|| Box::new(finding));
                    }
                }
            }
            _ => {}
        }
    }
}

impl Place<'_> {
    /// The profile that the node's device type names (1000h). `None` where it is not known, and where it names none or
    /// several: those of the axes stand elsewhere.
    fn device(&self) -> Option<u64> {
        let profile = self.node.value(0x1000, 0).map(|(device, _)| device & 0xFFFF);
        profile.filter(|profile| !matches!(profile, 0 | 0xFFFF))
    }

    /// Whether the node takes what was sent this way.
    fn heard(&self) -> bool {
        !self.by_pdo || self.state.is_none_or(|state| state == OPERATIONAL)
    }
}

/// The axis and the meaning of an object.
fn object(mux: Mux) -> Option<(u8, Object)> {
    Some((drive::axis(mux.index)?, Object::at(mux.index).filter(|_| mux.sub == 0)?))
}

fn controlword(axis: u8) -> Mux {
    Mux { index: 0x6040 + 0x800 * u16::from(axis), sub: 0 }
}

fn statusword(axis: u8) -> Mux {
    Mux { index: 0x6041 + 0x800 * u16::from(axis), sub: 0 }
}

fn display(axis: u8) -> Mux {
    Mux { index: 0x6061 + 0x800 * u16::from(axis), sub: 0 }
}

fn is_fault(state: State) -> bool {
    matches!(state, State::Fault | State::FaultReactionActive)
}

fn elapsed(from: Option<i64>, to: Option<i64>) -> Option<i64> {
    Some(to?.saturating_sub(from?))
}
