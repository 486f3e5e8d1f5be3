//! Whether two TPDOs are configured to one CAN-ID (CiA 301, 7.3.5): two nodes that send on it disturb each other, and
//! their frames cannot be told apart.
//!
//! It is judged where frames come on it, so that a master may move identifiers around before it starts the nodes. Of
//! two nodes only what is more than an EDS's default counts: a device may have been configured before the capture. It
//! must not judge RPDOs: any number of nodes may receive what one sends.

use std::collections::BTreeMap;

use crate::configuration::Provenance;
use crate::context::Context;
use crate::frame::{CanId, FrameRef};
use crate::node::{Content, Node, Pdo, PerNode};
use crate::rules::pdo::Pdo020;
use crate::services::pdo::communication_parameter;
use crate::services::sdo::wire::Mux;

/// A TPDO: its node and its number.
type Name = (u8, u16);

/// The identifiers of a bus's TPDOs.
#[derive(Debug, Default)]
pub struct PdoIdentifiers {
    /// Two that are configured to one identifier, and whether that was reported.
    shared: BTreeMap<CanId, (Name, Name, bool)>,
    compiled: bool,
    /// The last acknowledged write of a TPDO's COB-ID.
    written: BTreeMap<Name, FrameRef>,
}

impl PdoIdentifiers {
    /// The configuration of some node is another one now.
    pub fn reconfigured(&mut self) {
        self.compiled = false;
    }

    /// The COB-ID of a TPDO was written.
    pub fn written(&mut self, node: u8, number: u16, at: FrameRef) {
        self.written.insert((node, number), at);
    }

    /// A PDO's frame.
    #[inline]
    pub fn used(&mut self, id: CanId, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if !self.compiled {
            self.compile(nodes);
        }
        if !self.shared.is_empty() {
            self.judge(id, cx);
        }
    }

    fn judge(&mut self, id: CanId, cx: &mut Context<'_>) {
        let Some((one, other, reported)) = self.shared.get_mut(&id).filter(|(.., reported)| !reported) else { return };
        *reported = true;
        let written = |name: &Name| self.written.get(name).copied();
        // The one that was configured later came to the other's identifier.
        let later = written(other).map(|at| at.no) >= written(one).map(|at| at.no);
        let (this, that) = if later { (*other, *one) } else { (*one, *other) };
        let object = Mux { index: communication_parameter(true, this.1), sub: 1 };
        let what = Pdo020::Shared { pdo: (true, this.1), id, other: (true, that.1), of: that.0.into() };
        cx.raise(what, Some(this.0), Some(object), written(&this));
    }

    fn compile(&mut self, nodes: &PerNode<Node>) {
        self.compiled = true;
        let before = std::mem::take(&mut self.shared);
        let mut senders: BTreeMap<CanId, (Name, Provenance)> = BTreeMap::new();
        for (node, pdo) in nodes.iter().flat_map(|(id, node)| node.pdos().iter().map(move |pdo| (id, pdo))) {
            if !is_sent(pdo) {
                continue;
            }
            let (cob, from) = pdo.cob;
            let name = (node, pdo.number);
            let Some((first, known)) = senders.get(&cob.id).copied() else {
                senders.insert(cob.id, (name, from));
                continue;
            };
            if first.0 == node || (from > Provenance::Eds && known > Provenance::Eds) {
                let reported = before
                    .get(&cob.id)
                    .is_some_and(|&(one, other, reported)| reported && (one, other) == (first, name));
                self.shared.entry(cob.id).or_insert((first, name, reported));
            }
        }
    }
}

/// Whether a PDO is one that its node sends, by what is known for certain.
fn is_sent(pdo: &Pdo) -> bool {
    let (cob, from) = pdo.cob;
    let empty = matches!(pdo.content, Content::Disabled(_));
    pdo.transmit && cob.valid && !empty && !from.is_doubted() && from != Provenance::Default
}
