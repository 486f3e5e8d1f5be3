//! The SYNC configuration of nodes (1005h, 1006h, 1007h), against each other and against the traffic.
//!
//! A configurator writes one object after the other: writes are judged after a few SYNCs without another.

use super::super::limits::NO_SYNC_NS;
use super::period::SyncPeriod;
use super::settings::{SyncSettings, ns};
use crate::bytes::frame::FrameRef;
use crate::rules::sync::{Syn003, Syn006, Syn007, Syn014};
use crate::sdo::wire::Mux;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{Node, PerNode};

/// Fraction by which a configured period may differ from the measured one; clocks may be 1 % apart.
const DIFFERS: i64 = 40;
/// Number of SYNCs after which the configuration counts as complete.
const SETTLED: u64 = 2;

/// Writes that are still to be judged.
#[derive(Debug, Default)]
pub struct Configured {
    /// Nodes whose 1005h, 1006h or 1007h has changed, with the frame and the cycle.
    written: Vec<(u8, FrameRef, u64)>,
    /// A configured period was compared with the traffic.
    pub compared: bool,
}

impl Configured {
    /// Takes a change of a node's 1005h, 1006h or 1007h.
    pub fn write(&mut self, node: u8, at: FrameRef, cycle: u64) {
        match self.written.iter_mut().find(|(other, ..)| *other == node) {
            Some(entry) => *entry = (node, at, cycle),
            None => self.written.push((node, at, cycle)),
        }
    }

    /// Compares configured periods with the measured one.
    pub fn compare(&mut self, settings: &SyncSettings, period: &SyncPeriod, cx: &mut Context<'_>) {
        if self.compared || settings.periods.is_empty() {
            return;
        }
        let Some((period, uncertain)) = period.mean_ns(&cx.evidence.recording) else { return };
        for (node, configured) in &settings.periods {
            if configured.abs_diff(period) > ((*configured / DIFFERS) + uncertain).abs() {
                let object = node.map(|_| Mux { index: 0x1006, sub: 0 });
                self.compared = true;
                cx.raise(Syn003::NotConfigured { period, expected: *configured }, *node, object, None);
            }
        }
    }

    /// Reports, at the end of a capture without SYNC, a node that was configured to produce it long ago; returns true if
    /// there is one.
    pub fn never(&self, settings: &SyncSettings, nodes: &PerNode<Node>, cx: &mut Context<'_>) -> bool {
        let long = |at: FrameRef| cx.at.since(at).is_some_and(|since| since >= NO_SYNC_NS);
        let shown = |node: u8, index: u16| {
            let (value, from) = nodes.get(node)?.value(index, 0)?;
            matches!(from, Provenance::Observed(_)).then_some(value)
        };
        let period = |node: u8| shown(node, 0x1005).and_then(|_| shown(node, 0x1006)).filter(|us| *us > 0).map(ns);
        let due = self.written.iter().filter(|(node, at, _)| settings.producers.contains(node) && long(*at));
        let Some((node, at, period)) = due.filter_map(|(node, at, _)| Some((*node, *at, period(*node)?))).next() else {
            return false;
        };
        let object = Mux { index: 0x1005, sub: 0 };
        cx.raise(Syn014::Producer { period }, Some(node), Some(object), Some(at));
        true
    }

    /// Judges the writes once the configuration has settled.
    pub fn judge(&mut self, settings: &SyncSettings, cycle: u64, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if self.written.is_empty() {
            return;
        }
        let mut written = std::mem::take(&mut self.written);
        let mut two: Option<(FrameRef, u8, u8)> = None;
        written.retain(|(node, at, since)| {
            if cycle < since.saturating_add(SETTLED) {
                return true;
            }
            let observed = |index| {
                let value = nodes.get(*node)?.value(index, 0);
                value.filter(|(us, from)| *us > 0 && *from > Provenance::Option).map(|(us, _)| ns(us))
            };
            let cause = Some(*at).filter(|at| at.no != cx.at.no);
            let period = observed(0x1006).or(settings.period_ns);
            if let (Some(window), Some(period)) = (observed(0x1007), period)
                && window >= period
            {
                let object = Some(Mux { index: 0x1007, sub: 0 });
                cx.raise(Syn007::Window { window, period }, Some(*node), object, cause);
            }
            let producers = &settings.producers;
            let other = producers.iter().find(|other| *other != node && active(nodes, **other));
            if let Some(other) = other.filter(|_| producers.contains(node) && active(nodes, *node)) {
                // Of two writes, the later one.
                two = two.filter(|(before, ..)| before.no > at.no).or(Some((*at, *node, *other)));
            }
            false
        });
        self.written = written;
        if let Some((at, node, other)) = two {
            let object = Some(Mux { index: 0x1005, sub: 0 });
            let cause = Some(at).filter(|at| at.no != cx.at.no);
            cx.raise(Syn006::Configured { other: other.into() }, Some(node), object, cause);
        }
    }
}

/// Returns true if a producer has a period; without one it sends nothing.
fn active(nodes: &PerNode<Node>, node: u8) -> bool {
    nodes.get(node).and_then(|node| node.value(0x1006, 0)).is_some_and(|(us, from)| us > 0 && from > Provenance::Eds)
}
