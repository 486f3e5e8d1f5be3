//! The SYNC configuration of a bus's nodes (1005h, 1006h, 1007h, 1019h), and the options in its place.
//!
//! If nodes disagree, the producer determines period and counter, each node its own window, and then the most trusted
//! source. Compiled again when one of these objects changes.

use crate::bytes::ns::Ns;
use crate::world::configuration::Provenance;
use crate::world::network::Network;
use crate::world::node::{Node, PerNode};

/// Bit 30 of 1005h: the node produces SYNC.
const PRODUCES: u64 = 1 << 30;

/// The SYNC configuration.
#[derive(Debug, Default)]
pub struct SyncSettings {
    /// The only node configured to produce SYNC.
    pub producer: Option<u8>,
    /// All nodes configured to produce SYNC.
    pub producers: Vec<u8>,
    /// Communication cycle period in ns.
    pub period_ns: Option<Ns>,
    /// Periods that should agree with the traffic, in ns, and their node (`None` for an option).
    pub periods: Vec<(Option<u8>, Ns)>,
    /// 1019h of the producer.
    pub overflow: Option<u8>,
    /// 1019h of the most trusted node, and that node.
    pub any_overflow: Option<(u8, u8)>,
    /// Synchronous window length in ns by node-ID; `None` if disabled or unknown.
    pub windows: Vec<Option<Ns>>,
    /// The shortest of the windows, in ns.
    pub least_window_ns: Option<Ns>,
}

impl SyncSettings {
    /// Returns the present configuration.
    pub fn compile(network: &Network, nodes: &PerNode<Node>) -> Self {
        let producers: Vec<u8> = nodes.iter().filter(|(_, node)| produces(node)).map(|(id, _)| id).collect();
        let producer = producers.first().copied().filter(|_| producers.len() == 1);
        let mut made = Self { producer, producers, ..Self::default() };
        made.periods(network, nodes);
        made.counters(nodes);
        made.windows(network, nodes);
        made
    }

    fn periods(&mut self, network: &Network, nodes: &PerNode<Node>) {
        let mut best: Option<((bool, Provenance), Ns)> = None;
        let mut take = |node: Option<u8>, produces: bool, ns: Ns, from: Provenance, periods: &mut Vec<_>| {
            if ns <= Ns::ZERO || from.is_doubted() {
                return;
            }
            if from >= Provenance::Dcf {
                periods.push((node, ns));
            }
            let rank = (produces && from > Provenance::Eds, ranked(from));
            if best.is_none_or(|(before, _)| rank > before) {
                best = Some((rank, ns));
            }
        };
        if let Some(ns) = network.sync_period_ns {
            take(None, false, ns, Provenance::Option, &mut self.periods);
        }
        for (id, node) in nodes.iter() {
            if let Some((us, from)) = node.value(0x1006, 0) {
                take(Some(id), self.producer == Some(id), ns(us), from, &mut self.periods);
            }
        }
        self.period_ns = best.map(|(_, ns)| ns);
    }

    fn counters(&mut self, nodes: &PerNode<Node>) {
        let mut best = None;
        for (id, node) in nodes.iter() {
            let Some((value, from)) = node.value(0x1019, 0).filter(|(_, from)| *from > Provenance::Eds) else {
                continue;
            };
            let Ok(value @ (0 | 2..=240)) = u8::try_from(value) else { continue };
            if self.producer == Some(id) {
                self.overflow = Some(value);
            }
            let rank = (self.producer == Some(id), ranked(from));
            if best.is_none_or(|before| rank > before) {
                best = Some(rank);
                self.any_overflow = Some((value, id));
            }
        }
    }

    fn windows(&mut self, network: &Network, nodes: &PerNode<Node>) {
        let mut others: Option<(Provenance, Ns)> = None;
        for (_, node) in nodes.iter() {
            if let Some((us, from)) = node.value(0x1007, 0).filter(|(us, from)| *us > 0 && *from > Provenance::Eds) {
                // The longest of several, so that none is judged by another's shorter window.
                others = others.max(Some((ranked(from), ns(us))));
            }
        }
        let fallback = network.sync_window_ns.or(others.map(|(_, ns)| ns));
        self.windows = vec![fallback.filter(|ns| *ns > Ns::ZERO); 128];
        for (id, node) in nodes.iter() {
            let Some((us, from)) = node.value(0x1007, 0) else { continue };
            let own = ranked(from) > Provenance::Option || network.sync_window_ns.is_none();
            if let Some(slot) = self.windows.get_mut(usize::from(id)).filter(|_| own && from >= Provenance::Eds) {
                *slot = Some(ns(us)).filter(|ns| *ns > Ns::ZERO);
            }
        }
        self.least_window_ns = self.windows.iter().skip(1).copied().flatten().min();
    }
}

/// Returns true if a node is configured to produce SYNC by a better source than an EDS.
fn produces(node: &Node) -> bool {
    node.value(0x1005, 0).is_some_and(|(value, from)| from > Provenance::Eds && value & PRODUCES != 0)
}

/// Ranks all observations alike, regardless of their time.
fn ranked(from: Provenance) -> Provenance {
    if let Provenance::Observed(_) = from { Provenance::Observed(0) } else { from }
}

/// Converts an object's time from µs to ns.
pub fn ns(us: u64) -> Ns {
    Ns::from_us(i64::try_from(us).unwrap_or(i64::MAX))
}
