//! Drives (CiA 402): commands, the states that follow, announced faults, and modes of operation.
//!
//! For every axis the controlwords sent and the statuswords reported are followed, in PDOs and SDO. 6040h and 6041h
//! have another meaning on an encoder or a valve, so only these nodes are judged: those with the device type of a
//! drive, and those of unknown type that have climbed the steps of CiA 402 and never showed another coding. A
//! controlword that may have come unseen excuses everything. States are decoded in `drive`. A verdict is about two samples
//! with a sure mapping, so the last one is kept here, also of devices whose objects the bus does not take as a drive's.

mod controlwords;
mod effect;
mod fault;
mod watch;

use self::controlwords::Controlwords;
use self::effect::{PendingOrder, leads_out};
use self::fault::EmcyDue;
use self::watch::{Watch, WatchedPdo};
use super::PdoName;
use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::drive::{Drv001, Drv004};
use crate::rules::finding::{Code, Finding};
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::wire::error_control::OPERATIONAL;
use crate::wire::pdo::mapping::extract;
use crate::words::profiles::Profile;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::drive::{self, DriveCommand, DriveObject, DriveState, Reach};
use crate::world::node::{Content, Node, PerNode};

/// Time for a command that removes power, and for a change of mode, in ns.
const PROMPT: Ns = Ns::from_s(1);
/// Number of upward steps that show a node of unknown type to be a drive.
const PROOF: u8 = 2;

/// A reported statusword.
#[derive(Clone, Copy, Debug)]
struct Sample {
    word: u16,
    state: DriveState,
    at: FrameRef,
    by_pdo: bool,
}

/// A change of state that no controlword has explained so far.
#[derive(Clone, Copy, Debug)]
struct Jump {
    axis: u8,
    from: Sample,
    to: Sample,
}

/// A requested mode of operation.
#[derive(Clone, Copy, Debug)]
struct Request {
    mode: i8,
    at: FrameRef,
    /// Time from which on the display should show it, in ns.
    since_ns: Option<Ns>,
    /// Number of reports of another mode since then.
    reports: u8,
    raised: bool,
}

/// The state of one axis.
#[derive(Clone, Debug, Default)]
struct Axis {
    controlwords: Controlwords,
    sample: Option<Sample>,
    /// The first report if it showed a fault and no other state has followed.
    found: Option<Sample>,
    jump: Option<Jump>,
    /// The finding about `jump` while the node is not yet known to be a drive.
    suspect: Option<Box<Finding>>,
    order: Option<PendingOrder>,
    /// The first fault reset without effect in the present fault.
    vain: Option<FrameRef>,
    request: Option<Request>,
    likeness: Likeness,
}

/// Evidence that an axis is one of a drive.
#[derive(Clone, Copy, Debug, Default)]
struct Likeness {
    /// Number of upward steps that controlwords explain.
    climbed: u8,
    /// It showed a statusword that CiA 402 does not define.
    strange: bool,
}

/// The state of one node.
#[derive(Debug, Default)]
struct Drive {
    axes: [Option<Box<Axis>>; drive::AXES as usize],
    /// Its last EMCY with an error.
    emcy: Option<FrameRef>,
    /// The last unexplained fault of any axis.
    fault: Option<FrameRef>,
    /// It has booted in the capture.
    fresh: bool,
}

/// The drives of a bus.
#[derive(Debug, Default)]
pub struct Drives {
    nodes: PerNode<Drive>,
    watch: Watch,
    emcy_due: EmcyDue,
    /// The earliest time at which an order is due whose effect would be reported at once, in ns.
    due_ns: Option<Ns>,
}

/// The origin of a value, and the node it belongs to.
#[derive(Clone, Copy, Debug)]
struct AxisPlace<'a> {
    node: &'a Node,
    axis: u8,
    at: FrameRef,
    state: Option<u8>,
    by_pdo: bool,
}

impl Drives {
    /// Marks PDOs whose configuration has changed.
    pub fn renewed(&mut self, pdos: &[PdoName]) {
        self.watch.renewed(pdos);
    }

    /// Returns the axes that were in fault when first seen and have shown no other state: number from 0, statusword,
    /// and the first frame that reported it.
    pub fn found_in_fault(&self, node: u8) -> impl Iterator<Item = (usize, u16, FrameRef)> {
        let axes = self.nodes.get(node).into_iter().flat_map(|drive| drive.axes.iter().enumerate());
        axes.filter_map(|(number, axis)| {
            let found = axis.as_ref()?.found?;
            Some((number, found.word, found.at))
        })
    }

    /// Follows a PDO. `read` is true if its content is known; `state` returns a node's NMT state if known.
    #[inline]
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
        if !self.watch.of(frame.id, nodes).is_empty() {
            self.watched(pdo, contradicted, frame, nodes, state, cx);
        }
    }

    /// Follows a PDO whose identifier is one of drives.
    fn watched(
        &mut self,
        pdo: PdoName,
        contradicted: bool,
        frame: &Frame,
        nodes: &PerNode<Node>,
        state: impl Fn(u8) -> Option<u8>,
        cx: &mut Context<'_>,
    ) {
        let Self { nodes: drives, watch, emcy_due, due_ns } = self;
        for WatchedPdo { node, transmit, number, objects } in watch.of(frame.id, nodes) {
            // An identifier has one sender, which the bus model knows.
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
                let place = AxisPlace { node: known, axis: part.axis, at: cx.at, state: state(*node), by_pdo: true };
                match (part.object, transmit) {
                    (DriveObject::Controlword, false) => {
                        drive.sent(place, raw as u16, cx);
                        *due_ns = earliest(*due_ns, drive.taken(place, raw as u16));
                    }
                    (DriveObject::ModesOfOperation, false) => drive.requested(place, raw as u8),
                    (DriveObject::Statusword, true) => drive.reported(place, raw as u16, emcy_due, cx),
                    (DriveObject::ModesOfOperationDisplay, true) => drive.displayed(place, raw as u8, cx),
                    _ => {}
                }
            }
        }
    }

    /// Takes into account that an unreadable controlword may have come.
    pub fn blind(&mut self, node: u8, cx: &mut Context<'_>) {
        if let Some(drive) = self.nodes.get_mut(node) {
            drive.blind(cx);
        }
    }

    /// Follows an SDO write request, which a drive may obey before it answers.
    pub fn request(&mut self, node: u8, mux: Mux, bytes: &[u8], at: FrameRef) {
        if let (Some((axis, DriveObject::Controlword)), &[low, high]) = (object(mux), bytes)
            && let Some(axis) = self.nodes.entry(node).axis(axis)
        {
            axis.controlwords.send(u16::from_le_bytes([low, high]), at);
        }
    }

    /// Follows a finished SDO transfer.
    pub fn transfer(&mut self, transfer: &Transfer, known: Option<&Node>, state: Option<u8>, cx: &mut Context<'_>) {
        let Some((mux, (axis, object))) = transfer.mux.and_then(|mux| Some((mux, object(mux)?))) else { return };
        let nobody = Node::new(transfer.node);
        let drive = self.nodes.entry(transfer.node);
        let place = AxisPlace { node: known.unwrap_or(&nobody), axis, at: cx.at, state, by_pdo: false };
        let whole = transfer.outcome.status == Status::Ok && !transfer.outcome.bad && !transfer.data.hole;
        let fits = Profile::DRIVE.data_type(mux.index, mux.sub).and_then(crate::world::od::DataType::size);
        if !whole || fits != Some(transfer.data.kept.len()) || transfer.data.size != transfer.data.kept.len() as u64 {
            if object == DriveObject::Controlword && transfer.direction == Direction::Download {
                drive.blind(cx);
            }
            return;
        }
        let raw = transfer.data.kept.iter().rev().fold(0, |raw, byte| raw << 8 | u16::from(*byte));
        match (object, transfer.direction) {
            (DriveObject::Controlword, Direction::Upload) => drive.sent(place, raw, cx),
            (DriveObject::Controlword, Direction::Download) => {
                drive.sent(place, raw, cx);
                self.due_ns = earliest(self.due_ns, drive.taken(place, raw));
            }
            (DriveObject::ModesOfOperation, Direction::Download) => drive.requested(place, raw as u8),
            (DriveObject::Statusword, Direction::Upload) => drive.reported(place, raw, &mut self.emcy_due, cx),
            (DriveObject::ModesOfOperationDisplay, Direction::Upload) => drive.displayed(place, raw as u8, cx),
            _ => {}
        }
    }

    /// Follows an EMCY, which announces the faults that the node's axes have just shown.
    pub fn emcy(&mut self, node: u8, code: u16, cx: &mut Context<'_>) {
        if code > 0xFF
            && let Some(drive) = self.nodes.get_mut(node)
        {
            drive.emcy = Some(cx.at);
            self.emcy_due.announced(node, cx);
        }
    }

    /// Reports faults that no EMCY has announced by `now_ns`, and orders without effect. `reported`: the last frame in which a
    /// node has reported to be Operational, if that is its last state.
    #[inline]
    pub fn advance(&mut self, now_ns: Ns, reported: impl Fn(u8) -> Option<FrameRef>, cx: &mut Context<'_>) {
        self.emcy_due.advance(now_ns, cx);
        if self.due_ns.is_some_and(|due| due <= now_ns) {
            self.unchanged(now_ns, reported, cx);
        }
    }

    /// Reports orders without effect whose drives would report the effect at once.
    #[cold]
    fn unchanged(&mut self, now_ns: Ns, reported: impl Fn(u8) -> Option<FrameRef>, cx: &mut Context<'_>) {
        self.due_ns = None;
        for (node, drive) in self.nodes.iter_mut() {
            let at_ns = reported(node).and_then(|at| at.t_ns);
            for (number, axis) in (0..).zip(&mut drive.axes) {
                let Some(axis) = axis else { continue };
                // The node goes on, so that it would have sent another state by then.
                if let Some(at_ns) = at_ns {
                    axis.unchanged((node, number), at_ns, cx);
                }
                // Otherwise it is looked at again.
                let due_ns = axis.order.and_then(PendingOrder::due_ns).map(|due| due.max(now_ns + PROMPT));
                self.due_ns = earliest(self.due_ns, due_ns);
            }
        }
    }

    /// Resets a node that boots up: it has got no controlword yet.
    pub fn booted(&mut self, node: u8) {
        self.forget(Some(node));
        let drive = self.nodes.entry(node);
        drive.fresh = true;
        for axis in drive.axes.iter_mut().flatten() {
            axis.controlwords.fresh = true;
        }
    }

    /// Forgets what was seen of a node (or of all) after a reset or lost frames.
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

    /// Adds a controlword that the drive may have taken.
    fn sent(&mut self, place: AxisPlace<'_>, word: u16, cx: &mut Context<'_>) {
        if let Some(axis) = self.axis(place.axis) {
            axis.controlwords.by_pdo |= place.by_pdo;
            axis.controlwords.send(word, cx.at);
            axis.reconsider(cx);
        }
    }

    /// Adds a controlword that the drive must have taken. Returns the time in ns at which its effect is due, if that would be
    /// reported at once.
    fn taken(&mut self, place: AxisPlace<'_>, word: u16) -> Option<Ns> {
        let axis = self.axis(place.axis)?;
        let asked = word & 0x8F;
        if axis.controlwords.given == Some(asked) {
            return None;
        }
        let given = axis.controlwords.given;
        // Only a reset needs the word before it: its bit may have been set all along.
        let command = drive::command(word, given).filter(|it| given.is_some() || *it != DriveCommand::FaultReset);
        axis.controlwords.given = Some(asked);
        let state = axis.sample.map(|sample| sample.state);
        // Only a fault reset leads out of a fault; its edge counts, whatever follows.
        if axis.order.is_some_and(|order| order.command == DriveCommand::FaultReset && state == Some(order.from)) {
            return None;
        }
        axis.order = None;
        if let (Some(sample), Some(command)) = (axis.sample, command)
            && leads_out(sample.state, command)
            && place.at.t_ns.is_some()
            && place.heard()
        {
            let reported_at_once = sample.by_pdo && axis.is_drive(place) && place.reports_at_once();
            axis.order =
                Some(PendingOrder { word, command, from: sample.state, at: place.at, reports: 0, reported_at_once });
        }
        axis.order.and_then(PendingOrder::due_ns)
    }

    /// Takes a requested mode of operation.
    fn requested(&mut self, place: AxisPlace<'_>, mode: u8) {
        let mode = mode.cast_signed();
        let Some(axis) = self.axis(place.axis).filter(|_| place.heard()) else { return };
        if axis.request.is_none_or(|request| request.mode != mode) {
            let request = Request { mode, at: place.at, since_ns: place.at.t_ns, reports: 0, raised: false };
            // 0 asks for no change.
            axis.request = (mode != 0).then_some(request);
        }
    }

    /// Compares the displayed mode of operation with the requested one.
    fn displayed(&mut self, place: AxisPlace<'_>, mode: u8, cx: &mut Context<'_>) {
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

    /// Takes a reported statusword.
    fn reported(&mut self, place: AxisPlace<'_>, word: u16, emcy_due: &mut EmcyDue, cx: &mut Context<'_>) {
        let (emcy, mut fault) = (self.emcy, self.fault);
        let Some(axis) = self.axis(place.axis) else { return };
        let Some(state) = DriveState::of(word) else {
            axis.likeness.strange = true;
            (axis.sample, axis.found, axis.jump, axis.order) = (None, None, None, None);
            return;
        };
        let sample = Sample { word, state, at: place.at, by_pdo: place.by_pdo };
        axis.effect(place, sample, cx);
        let of_drive = || place.device().is_none_or(|profile| profile == u64::from(drive::PROFILE));
        axis.found = match axis.sample {
            None => Some(sample).filter(|_| state == DriveState::Fault && of_drive() && !axis.likeness.strange),
            Some(_) => axis.found.filter(|_| state == DriveState::Fault),
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
    /// Withdraws the finding about the last change of state if a controlword listed late explains it.
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

    /// Returns true if the node is a drive.
    fn is_drive(&self, place: AxisPlace<'_>) -> bool {
        match place.device() {
            None => self.likeness.climbed >= PROOF && !self.likeness.strange,
            Some(profile) => profile == u64::from(drive::PROFILE),
        }
    }

    /// Judges a change of state.
    fn follow(&mut self, place: AxisPlace<'_>, before: Sample, sample: Sample, judged: bool, cx: &mut Context<'_>) {
        match self.controlwords.explain(&before, &sample) {
            Some(true) if matches!(drive::reach(before.state, sample.state), Reach::Directly(2..=4)) => {
                self.likeness.climbed = self.likeness.climbed.saturating_add(1);
            }
            Some(false) => {
                let remote = drive::remote(before.word) && drive::remote(sample.word);
                // A controlword in an unknown PDO is not seen.
                let all_seen = self.controlwords.by_pdo || place.state.is_some_and(|state| state != OPERATIONAL);
                let restarted = sample.state == DriveState::NotReadyToSwitchOn;
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

impl AxisPlace<'_> {
    /// Returns the profile in the node's device type (1000h); `None` if unknown, or if it names no profile or several.
    fn device(&self) -> Option<u64> {
        let profile = self.node.value(0x1000, 0).map(|(device, _)| device & 0xFFFF);
        profile.filter(|profile| !matches!(profile, 0 | 0xFFFF))
    }

    /// Returns true if a TPDO with the statusword is sent when that changes.
    fn reports_at_once(&self) -> bool {
        let index = statusword(self.axis).index;
        self.node.pdos().iter().filter(|pdo| pdo.transmit && pdo.cob.0.valid).any(|pdo| {
            let by_events = pdo.transmission.is_some_and(|(kind, from)| kind >= 254 && from > Provenance::Eds);
            let Content::Mapped(mapping, from) = &pdo.content else { return false };
            by_events && !from.is_doubted() && mapping.entries.iter().any(|entry| entry.index == index)
        })
    }

    /// Returns true if the node accepts data sent this way.
    fn heard(&self) -> bool {
        !self.by_pdo || self.state.is_none_or(|state| state == OPERATIONAL)
    }
}

/// Returns the axis and the meaning of an object.
fn object(mux: Mux) -> Option<(u8, DriveObject)> {
    Some((drive::axis(mux.index)?, DriveObject::at(mux.index).filter(|_| mux.sub == 0)?))
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

fn is_fault(state: DriveState) -> bool {
    matches!(state, DriveState::Fault | DriveState::FaultReactionActive)
}

fn earliest(one: Option<Ns>, other: Option<Ns>) -> Option<Ns> {
    one.into_iter().chain(other).min()
}

fn elapsed(from: Option<Ns>, to: Option<Ns>) -> Option<Ns> {
    Some(to? - from?)
}
