//! Knowledge from transfers: the configuration of nodes, and their identifiers.

use super::Bus;
use crate::checks::{PdoName, Renewed};
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;
use crate::world::configuration;
use crate::world::context::Context;
use crate::world::node::{Node, PerNode};

impl Bus {
    /// Takes a transfer's evidence of the server's configuration.
    pub(super) fn learn(&mut self, transfer: &Transfer, cx: &mut Context<'_>) {
        let Some(mux) = transfer.mux else { return };
        if transfer.outcome.status != Status::Ok || transfer.outcome.bad || transfer.data.hole {
            return self.refused(transfer, mux, cx);
        }
        self.checks.transferred(transfer, mux, &self.nodes, cx);
        if mux.index == 0x1F22 && transfer.direction == Direction::Download {
            return self.learn_concise(mux.sub, &transfer.data.kept);
        }
        let concerned = configuration::concerns(mux.index) || matches!(mux.index, 0x1010 | 0x1011);
        if !concerned || transfer.data.size > 8 {
            return;
        }
        let node = known(&mut self.nodes, transfer.node);
        if node.configuration.learn(transfer.direction, mux, &transfer.data.kept, cx.at.no) {
            node.compile();
            if moves(mux) {
                self.assign();
            }
            self.learnt(transfer.node, mux, cx);
        }
    }

    /// Announces a changed value of an object, or a change of its source.
    pub(super) fn learnt(&mut self, node: u8, mux: Mux, cx: &Context<'_>) {
        self.checks.renewed(&renewed(&mut self.nodes));
        self.checks.learnt(node, mux, &self.nodes, cx);
    }

    /// Announces changes of many objects.
    pub(super) fn reconfigured(&mut self) {
        self.checks.renewed(&renewed(&mut self.nodes));
        self.checks.reconfigured(&self.nodes);
    }

    /// Doubts an object that is being written: until success or refusal, the old or the new value may hold. An
    /// acknowledgement without a visible write leaves the value unknown.
    pub(super) fn doubt_object(&mut self, node: u8, mux: Mux, cx: &mut Context<'_>) {
        if !configuration::concerns(mux.index) {
            return;
        }
        let one = known(&mut self.nodes, node);
        if one.configuration.attempted(mux, cx.at.no) {
            one.compile();
            self.learnt(node, mux, cx);
        }
    }

    /// Takes a transfer without success; the old value holds only if the write was refused.
    pub(super) fn refused(&mut self, transfer: &Transfer, mux: Mux, cx: &mut Context<'_>) {
        if transfer.direction != Direction::Download {
            return;
        }
        if transfer.outcome.status != Status::Aborted {
            return self.unanswered(transfer.node, mux);
        }
        if let Some(node) = self.nodes.get_mut(transfer.node)
            && node.configuration.refused(mux, transfer.first.no)
        {
            node.compile();
            self.learnt(transfer.node, mux, cx);
        }
    }

    /// Takes a concise DCF written to a configuration manager for a node (CiA 302-3).
    pub(super) fn learn_concise(&mut self, node: u8, bytes: &[u8]) {
        if !(1..=127).contains(&node) {
            return;
        }
        let target = known(&mut self.nodes, node);
        for (mux, value) in concise(bytes) {
            target.configuration.configure(mux.index, mux.sub, value);
        }
        target.compile();
        self.assign();
        self.reconfigured();
    }

    /// Updates the roles of identifiers by the knowledge of the nodes.
    pub(super) fn assign(&mut self) {
        for (_, node) in self.nodes.iter_mut() {
            for index in node.configuration.unassigned() {
                self.roles.refresh(node, index);
            }
        }
    }

    /// Moves the knowledge of a node to its new node-ID (LSS), unless that is known already.
    pub(super) fn moved(&mut self, from: u8, to: u8) {
        if self.nodes.get(to).is_some() {
            return;
        }
        let Some(mut node) = self.nodes.take(from) else { return };
        node.configuration.all_untold();
        let mut gone = Renewed::default();
        gone.add(from, &mut node);
        gone.pdos.extend(node.pdos().iter().map(|pdo| PdoName {
            transmit: pdo.transmit,
            number: pdo.number,
            node: from,
        }));
        self.checks.renewed(&gone);
        self.roles.refresh_all(from, None);
        node.configuration.leave(from);
        node.rename(to);
        self.roles.refresh_all(to, Some(&node));
        self.nodes.put(to, node);
        self.assign();
        self.reconfigured();
    }
}

/// Returns the changes of the nodes since the last call.
pub(super) fn renewed(nodes: &mut PerNode<Node>) -> Renewed {
    let mut all = Renewed::default();
    nodes.iter_mut().for_each(|(id, node)| all.add(id, node));
    all
}

/// Returns a node, created if unknown.
pub(super) fn known(nodes: &mut PerNode<Node>, id: u8) -> &mut Node {
    if nodes.get(id).is_none() {
        nodes.put(id, Box::new(Node::new(id)));
    }
    nodes.entry(id)
}

/// Returns true if an object holds a COB-ID.
fn moves(mux: Mux) -> bool {
    match mux.index {
        0x1005 | 0x1012 | 0x1014 => true,
        0x1200..=0x12FF => matches!(mux.sub, 1..=3),
        0x1301..=0x1340 => matches!(mux.sub, 1 | 5 | 6),
        0x1400..=0x15FF | 0x1800..=0x19FF => mux.sub == 1,
        _ => false,
    }
}

/// Returns the entries of a concise DCF: a count, then index, sub-index, size and data of each (CiA 302-3).
fn concise(bytes: &[u8]) -> impl Iterator<Item = (Mux, &[u8])> {
    let mut rest = bytes.get(4..).unwrap_or(&[]);
    std::iter::from_fn(move || {
        let ([low, high, sub, a, b, c, d], after) = rest.split_first_chunk::<7>()?;
        let size = u32::from_le_bytes([*a, *b, *c, *d]) as usize;
        let value = after.get(..size)?;
        rest = after.get(size..)?;
        Some((Mux { index: u16::from_le_bytes([*low, *high]), sub: *sub }, value))
    })
}
