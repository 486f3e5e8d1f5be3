//! Faults of a drive (CiA 402, transitions 13 and 14): each is found once, and the EMCY that announces it explains it.
//!
//! The fault and its EMCY come in either order. It must not decode a state, or follow commands.

use super::{Axis, Place, Sample, statusword};
use crate::context::Context;
use crate::finding::Finding;
use crate::frame::FrameRef;
use crate::rules::drive::Drv005;

/// How far an EMCY may be from the fault it announces, in ns.
const EMCY: i64 = 500_000_000;
/// Axes of one device that fail within this time of each other have one cause, in ns.
const TOGETHER: i64 = 100_000_000;
const STOPPED: u8 = 0x04;

/// Faults of an axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults {
    /// One that may still be announced by an EMCY.
    pub(super) unannounced: Option<Unannounced>,
    /// What explains that the axis is in fault: the EMCY, or the statusword that showed it.
    pub(super) fault: Option<FrameRef>,
    /// The first fault reset since then that had no effect.
    pub(super) vain: Option<FrameRef>,
}

/// A fault without EMCY so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unannounced {
    pub(super) fault: Sample,
    /// Until when one may come, in ns.
    pub(super) due_ns: i64,
}

/// What announces a fault.
#[derive(Clone, Copy, Debug)]
pub(super) enum Announced {
    /// This EMCY did.
    By(FrameRef),
    /// An EMCY may, until then.
    Later(i64),
    /// The node sends none in this state or configuration, or nothing is known of times.
    Never,
}

/// What announces a fault that a statusword shows for the first time. `emcy`: the node's last one with an error.
pub(super) fn announced(place: Place<'_>, before: Sample, fault: Sample, emcy: Option<FrameRef>) -> Announced {
    let (Some(earliest), Some(latest)) = (before.at.t_ns, fault.at.t_ns) else {
        return emcy.filter(|emcy| emcy.no > before.at.no).map_or(Announced::Never, Announced::By);
    };
    // In 100 µs.
    let inhibit = place.node.value(0x1015, 0).map_or(0, |(time, _)| (time & 0xFFFF) as i64 * 100_000);
    let apart = EMCY.max(inhibit);
    let near = |emcy: &FrameRef| emcy.t_ns.is_some_and(|emcy| emcy >= earliest.saturating_sub(apart));
    if let Some(emcy) = emcy.filter(near) {
        return Announced::By(emcy);
    }
    let disabled = place.node.value(0x1014, 0).is_some_and(|(cob, _)| cob & 1 << 31 != 0);
    if disabled || place.state == Some(STOPPED) {
        return Announced::Never;
    }
    Announced::Later(latest.saturating_add(apart))
}

impl Axis {
    /// A fault that no EMCY explains. `first`: the last fault of the device's axes that nothing explained.
    pub(super) fn unexplained(
        &mut self,
        (node, axis): (u8, u8),
        fault: Sample,
        first: &mut Option<FrameRef>,
        cx: &mut Context<'_>,
    ) {
        let together = |first: &FrameRef| {
            first.no != fault.at.no
                && first
                    .t_ns
                    .zip(fault.at.t_ns)
                    .is_some_and(|(first, then)| (0..TOGETHER).contains(&then.saturating_sub(first)))
        };
        let because_of = first.filter(together);
        if because_of.is_none() {
            *first = Some(fault.at);
        }
        self.faults.fault = because_of.or(Some(fault.at));
        raise_fault(node, axis, fault, because_of, cx);
    }
}

/// Raises a fault where its statusword stands.
pub(super) fn raise_fault(node: u8, axis: u8, fault: Sample, because_of: Option<FrameRef>, cx: &mut Context<'_>) {
    let what = Drv005::Entered { statusword: fault.word };
    let finding = cx.verdict(what, Some(node), Some(statusword(axis)), None);
    cx.emit(Finding { at: fault.at, because_of, ..finding });
}
