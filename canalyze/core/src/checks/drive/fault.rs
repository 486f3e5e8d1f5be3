//! Faults of a drive (CiA 402, transitions 13 and 14): each is reported once and explained by the EMCY that announces
//! it, which may come before or after it.

use super::{AxisPlace, Sample, statusword};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::checks::limits::{FAULT_EMCY_NS, FAULTS_TOGETHER_NS};
use crate::evidence::Obligations;
use crate::evidence::obligation::Owed;
use crate::rules::drive::{Drv003, Drv005};
use crate::rules::finding::{Code, Finding};
use crate::wire::error_control::STOPPED;
use crate::world::context::Context;

/// Faults that still wait for an EMCY: node, axis, statusword.
#[derive(Debug, Default)]
pub(super) struct EmcyDue {
    owed: Obligations<(u8, u8, u16)>,
}

impl EmcyDue {
    /// Reports a new fault in a statusword. `emcy` is the node's last EMCY with an error, `first` the last unexplained
    /// fault of the device's axes.
    pub(super) fn entered(
        &mut self,
        place: AxisPlace<'_>,
        (before, fault): (Sample, Sample),
        emcy: Option<FrameRef>,
        first: &mut Option<FrameRef>,
        cx: &mut Context<'_>,
    ) {
        let node = place.node.id();
        // In 100 µs.
        let inhibit =
            place.node.value(0x1015, 0).map_or(Ns::ZERO, |(time, _)| Ns::from_us((time & 0xFFFF) as i64 * 100));
        let apart = FAULT_EMCY_NS.max(inhibit);
        let emcy = emcy.filter(|emcy| match before.at.t_ns.zip(emcy.t_ns) {
            Some((earliest, emcy)) => emcy >= earliest - apart,
            None => emcy.no > before.at.no,
        });
        let together = |first: &FrameRef| {
            let times = first.t_ns.zip(fault.at.t_ns).filter(|_| first.no != fault.at.no);
            times.is_some_and(|(first, then)| (Ns::ZERO..FAULTS_TOGETHER_NS).contains(&(then - first)))
        };
        let because_of = emcy.or(first.filter(together));
        if because_of.is_none() {
            *first = Some(fault.at);
        }
        let what = Drv005::Entered { statusword: fault.word };
        let finding = cx.verdict(what, Some(node), Some(statusword(place.axis)), None);
        cx.report_later(Finding { because_of, ..finding }, apart);
        let disabled = place.node.value(0x1014, 0).is_some_and(|(cob, _)| cob & 1 << 31 != 0);
        if emcy.is_none() && !disabled && place.state != Some(STOPPED) {
            self.owed.open((node, place.axis, fault.word), Owed { since: cx.when, limit_ns: apart, why: None });
        }
    }

    /// Takes an EMCY with an error as the announcement of the faults that the node's axes have just shown.
    pub(super) fn announced(&mut self, node: u8, cx: &mut Context<'_>) {
        self.forget(Some(node));
        cx.evidence.pending.explain(cx.at, |finding| finding.code == Code::Drv005 && finding.node == Some(node));
    }

    /// Reports faults that no EMCY has announced by `now_ns`.
    #[inline]
    pub(super) fn advance(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        if self.owed.may_be_due(now_ns) {
            self.miss(now_ns, cx);
        }
    }

    fn miss(&mut self, now_ns: Ns, cx: &mut Context<'_>) {
        for ((node, axis, word), owed) in self.owed.due(cx.clock(now_ns), &cx.evidence.recording) {
            let fault = Some(owed.since.at);
            let what = Drv003::Unannounced { statusword: word };
            let finding = cx.verdict(what, Some(node), Some(statusword(axis)), fault);
            cx.report(Finding { because_of: fault, ..finding });
        }
    }

    /// Drops the EMCYs expected of a node, or of all.
    pub(super) fn forget(&mut self, node: Option<u8>) {
        self.owed.void(|(owing, ..)| node.is_none_or(|node| node == *owing));
    }
}
