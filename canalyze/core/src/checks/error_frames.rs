//! Error frames (ISO 11898-1, fault confinement): bus-off, error passive, missing acknowledgement, bus errors.
//!
//! A fault of the bus appears as a series of error frames: a wire breaks, acknowledgements are missing, the counters
//! rise, the controller becomes error passive and goes bus-off. Error frames less than [`QUIET_NS`] apart are one
//! disturbance and one finding: the worst condition, at its first frame; the other conditions are its consequences. It
//! is raised at the end of the disturbance or after [`QUIET_NS`]; the total duration is reported at the end. No node is
//! named: an error frame is the view of the recording controller.

use std::collections::BTreeMap;

use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::bus::{Bus001, Bus002, Bus003, Bus004, Bus005, Bus006, Bus007, Bus008};
use crate::rules::finding::{Finding, Verdict};
use crate::wire::error_frame::{self, Condition, Recovery};
use crate::world::context::Context;

/// Time without error frames that ends a disturbance, and after which an ongoing one is raised, in ns.
const QUIET_NS: Ns = Ns::from_s(1);
/// The same in frames of the capture, used without stamps.
const QUIET_FRAMES: u64 = 256;

/// The state of a bus's error frames.
#[derive(Debug, Default)]
pub struct ErrorFrames {
    /// The present disturbance of the bus.
    bus: Option<Disturbance>,
    /// The present overflow of the controller, which is independent of the bus.
    overflow: Option<Disturbance>,
    /// The last raised state of the controller that it has not left: warning level or error passive.
    state: Option<(Condition, FrameRef)>,
    /// The frame at which it went bus-off, until it has recovered.
    off: Option<FrameRef>,
    /// A command that switches the bit timing, and the end of the time in which it explains error frames, in ns.
    switched: Option<(FrameRef, Ns)>,
}

/// A series of error frames.
#[derive(Debug)]
struct Disturbance {
    /// The first frame of each condition, and the number of frames.
    seen: BTreeMap<Condition, (FrameRef, u64)>,
    first: FrameRef,
    last: FrameRef,
    frames: u64,
    /// The raised condition, its frame, and the number of frames counted in it.
    raised: Option<(Condition, FrameRef, u64)>,
    /// The recovery of the controller if nothing has happened since.
    recovery: Option<(Recovery, FrameRef)>,
}

impl ErrorFrames {
    /// Takes an error frame.
    pub fn follow(&mut self, frame: &Frame, cx: &mut Context<'_>) {
        if let Some(overflow) = error_frame::overflow(frame) {
            take(&mut self.overflow, overflow, cx);
        }
        match (error_frame::condition(frame), error_frame::recovery(frame)) {
            (Some(condition), _) => take(&mut self.bus, condition, cx),
            (None, Some(recovery)) => self.recovered(recovery, cx),
            (None, None) => {}
        }
    }

    /// Takes an error frame whose content is not in the capture.
    pub fn bare(&mut self, cx: &mut Context<'_>) {
        take(&mut self.bus, Condition::Unspecified, cx);
    }

    /// Notes a switch of the bit timing: for twice the delay (in ms) no frame is understood (CiA 305).
    pub fn switch(&mut self, delay: u16, cx: &Context<'_>) {
        let until = cx.at.t_ns.map(|now| now + Ns::from_ms(2 * i64::from(delay)) + QUIET_NS);
        self.switched = until.map(|until| (cx.at, until));
    }

    /// Ends disturbances that are over at frame `no`, at `now_ns` if known.
    #[inline]
    pub fn advance(&mut self, now_ns: Option<Ns>, no: u64, cx: &mut Context<'_>) {
        if self.bus.is_none() && self.overflow.is_none() {
            return;
        }
        if let Some(event) = self.overflow.take() {
            self.overflow = self.progress(event, now_ns, no, cx);
        }
        if let Some(event) = self.bus.take() {
            self.bus = self.progress(event, now_ns, no, cx);
        }
    }

    /// Ends all disturbances at the end of the capture.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        for event in [self.overflow.take(), self.bus.take()].into_iter().flatten() {
            self.end(event, cx);
        }
    }

    fn recovered(&mut self, recovery: Recovery, cx: &mut Context<'_>) {
        if let Some(event) = &mut self.bus {
            (event.recovery, event.last) = (Some((recovery, cx.at)), cx.at);
        } else {
            let (off, state) = (self.off.take(), self.state.take());
            if recovery == Recovery::Restarted && off.is_none() {
                // A restart leaves only bus-off.
                return cx.report(cx.verdict(Bus001::Unseen, None, None, None));
            }
            raise_recovery(recovery, cx.at, off.or(state.map(|(_, at)| at)), cx);
        }
    }

    fn progress(
        &mut self,
        mut event: Disturbance,
        now_ns: Option<Ns>,
        no: u64,
        cx: &mut Context<'_>,
    ) -> Option<Disturbance> {
        let since = |from: FrameRef| now_ns.zip(from.t_ns).map(|(now, from)| now - from);
        // A clock that jumps back by this much was set: the elapsed time is unknown.
        let over = since(event.last).map(|quiet| quiet.abs() >= QUIET_NS.abs());
        if over.unwrap_or(no.saturating_sub(event.last.no) >= QUIET_FRAMES) {
            self.end(event, cx);
            return None;
        }
        if event.raised.is_none() && since(event.first).is_some_and(|since| since >= QUIET_NS) {
            self.raise(&mut event, cx);
        }
        Some(event)
    }

    /// Raises the worst condition of a disturbance, and the others as consequences.
    fn raise(&mut self, event: &mut Disturbance, cx: &mut Context<'_>) {
        let Some((worst, (at, _))) = event.seen.last_key_value() else { return };
        let (worst, at) = (*worst, *at);
        let switched = self.switched.filter(|(_, until)| at.t_ns.is_some_and(|now| now <= *until));
        let again = self.state.filter(|(state, _)| *state == worst);
        let because_of = switched.map(|(at, _)| at).or(again.map(|(_, at)| at));
        raise_condition(worst, event.frames, at, because_of, cx);
        for (condition, (first, count)) in event.seen.iter().filter(|(condition, _)| **condition != worst) {
            raise_condition(*condition, *count, *first, Some(at), cx);
        }
        event.raised = Some((worst, at, event.frames));
        if worst == Condition::BusOff {
            self.off = Some(at);
        }
        if matches!(worst, Condition::WarningLevel | Condition::ErrorPassive) && again.is_none() {
            self.state = Some((worst, at));
        }
    }

    fn end(&mut self, mut event: Disturbance, cx: &mut Context<'_>) {
        if event.raised.is_none() {
            self.raise(&mut event, cx);
        }
        let Some((condition, at, counted)) = event.raised else { return };
        if event.frames > counted {
            let what = in_all(condition, event.frames, event.last.since(event.first));
            let finding = cx.verdict(what, None, None, Some(at));
            cx.report(Finding { at: event.last, because_of: Some(at), ..finding });
        }
        if let Some((recovery, back)) = event.recovery {
            (self.state, self.off) = (None, None);
            raise_recovery(recovery, back, Some(at), cx);
        }
    }
}

/// Adds a frame that shows a condition.
fn take(event: &mut Option<Disturbance>, condition: Condition, cx: &mut Context<'_>) {
    let at = cx.at;
    let fresh = || Disturbance { seen: BTreeMap::new(), first: at, last: at, frames: 0, raised: None, recovery: None };
    let event = event.get_or_insert_with(fresh);
    (event.last, event.recovery) = (at, None);
    event.frames += 1;
    let (_, count) = event.seen.entry(condition).or_insert((at, 0));
    *count += 1;
    if *count > 1 {
        return;
    }
    if let Some((raised, root, _)) = event.raised {
        // It has become worse.
        let severity = |condition| finding_of(condition, 1).code.rule().severity;
        let worse = severity(condition) > severity(raised) && condition > raised;
        raise_condition(condition, 1, at, (!worse).then_some(root), cx);
        if worse {
            event.raised = Some((condition, at, event.frames));
        }
    }
}

fn raise_condition(condition: Condition, count: u64, at: FrameRef, because_of: Option<FrameRef>, cx: &mut Context<'_>) {
    cx.report(Finding { at, because_of, ..cx.verdict(finding_of(condition, count), None, None, None) });
}

fn raise_recovery(recovery: Recovery, at: FrameRef, because_of: Option<FrameRef>, cx: &mut Context<'_>) {
    let after = because_of.and_then(|since| at.since(since)).filter(|after| *after > Ns::ZERO);
    let what = match (recovery == Recovery::Restarted, after) {
        (false, None) => Bus006::ErrorActive,
        (false, Some(after)) => Bus006::ErrorActiveAfter { after },
        (true, None) => Bus006::Restarted,
        (true, Some(after)) => Bus006::RestartedAfter { after },
    };
    cx.report(Finding { at, because_of, ..cx.verdict(what, None, None, because_of) });
}

/// Returns the finding of a condition that `count` frames have shown.
fn finding_of(condition: Condition, count: u64) -> Verdict {
    match (condition, count) {
        (Condition::BusOff, ..=1) => Bus001::BusOff { count }.into(),
        (Condition::BusOff, _) => Bus001::BusOffAfter { count }.into(),
        (Condition::ErrorPassive, ..=1) => Bus002::ErrorPassive { count }.into(),
        (Condition::ErrorPassive, _) => Bus002::ErrorPassiveAfter { count }.into(),
        (Condition::WarningLevel, ..=1) => Bus003::WarningLevel { count }.into(),
        (Condition::WarningLevel, _) => Bus003::WarningLevelAfter { count }.into(),
        (Condition::NotAcknowledged, ..=1) => Bus004::NotAcknowledged { count }.into(),
        (Condition::NotAcknowledged, _) => Bus004::NotAcknowledgedOften { count }.into(),
        (Condition::TransmitTimeout, ..=1) => Bus004::TransmitTimeout { count }.into(),
        (Condition::TransmitTimeout, _) => Bus004::TransmitTimeouts { count }.into(),
        (Condition::ReceiveOverflow, ..=1) => Bus005::Receive { count }.into(),
        (Condition::ReceiveOverflow, _) => Bus005::ReceiveOften { count }.into(),
        (Condition::TransmitOverflow, ..=1) => Bus005::Transmit { count }.into(),
        (Condition::TransmitOverflow, _) => Bus005::TransmitOften { count }.into(),
        (Condition::BusError, ..=1) => Bus007::BusError { count }.into(),
        (Condition::BusError, _) => Bus007::BusErrors { count }.into(),
        (Condition::Unspecified, ..=1) => Bus007::Unspecified { count }.into(),
        (Condition::Unspecified, _) => Bus007::UnspecifiedOften { count }.into(),
        (Condition::Transceiver, ..=1) => Bus008::FaultyWire { count }.into(),
        (Condition::Transceiver, _) => Bus008::FaultyWireOften { count }.into(),
    }
}

/// Returns the finding of a condition's total number of frames and duration in ns.
fn in_all(condition: Condition, count: u64, duration: Option<Ns>) -> Verdict {
    match condition {
        Condition::BusOff => Bus001::InAll { count, duration }.into(),
        Condition::ErrorPassive => Bus002::InAll { count, duration }.into(),
        Condition::WarningLevel => Bus003::InAll { count, duration }.into(),
        Condition::NotAcknowledged | Condition::TransmitTimeout => Bus004::InAll { count, duration }.into(),
        Condition::ReceiveOverflow | Condition::TransmitOverflow => Bus005::InAll { count, duration }.into(),
        Condition::BusError | Condition::Unspecified => Bus007::InAll { count, duration }.into(),
        Condition::Transceiver => Bus008::InAll { count, duration }.into(),
    }
}
