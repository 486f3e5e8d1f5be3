//! Two TPDOs configured to one CAN-ID (CiA 301, 7.3.5): their nodes disturb each other, and their frames are
//! indistinguishable.
//!
//! Judged when frames appear on it, so that a master may move identifiers before it starts the nodes. Between two nodes
//! an EDS default does not count: a device may have been configured before the capture. RPDOs are not judged, since any
//! number of nodes may receive one PDO.

use std::collections::{BTreeMap, BTreeSet};

use crate::bytes::frame::{CanId, FrameRef};
use crate::checks::PdoName;
use crate::evidence::circumstance::CircumstanceKind;
use crate::rules::pdo::Pdo020;
use crate::sdo::wire::Mux;
use crate::wire::pdo::communication_parameter;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{Content, Node, Pdo, PerNode};

/// A TPDO: its node and its number.
type TpdoKey = (u8, u16);

/// A bit for each CAN-ID of 11 bits.
#[derive(Debug, Default)]
struct Heard([u64; 32]);

impl Heard {
    fn take(&mut self, id: CanId) {
        if let Some(bits) = self.0.get_mut(id.raw() as usize / 64).filter(|_| !id.is_extended()) {
            *bits |= 1 << (id.raw() % 64);
        }
    }

    fn has(&self, id: CanId) -> bool {
        !id.is_extended() && self.0.get(id.raw() as usize / 64).is_some_and(|bits| bits >> (id.raw() % 64) & 1 != 0)
    }
}

/// The identifiers of a bus's TPDOs.
#[derive(Debug, Default)]
pub struct PdoIdentifiers {
    /// Two TPDOs configured to one identifier; true if reported.
    shared: BTreeMap<CanId, (TpdoKey, TpdoKey, bool)>,
    /// All active TPDOs by identifier.
    senders: BTreeMap<CanId, BTreeMap<TpdoKey, Provenance>>,
    /// Their identifiers.
    ids: BTreeMap<TpdoKey, CanId>,
    /// TPDOs whose configuration has changed.
    stale: BTreeSet<TpdoKey>,
    /// The last acknowledged write of a TPDO's COB-ID.
    written: BTreeMap<TpdoKey, FrameRef>,
    /// The identifiers that TPDOs had before.
    former: BTreeMap<TpdoKey, CanId>,
    /// The CAN-IDs on which PDOs came while no TPDO was configured to them, one bit each.
    heard: Heard,
}

impl PdoIdentifiers {
    /// Marks PDOs whose configuration has changed.
    pub fn renewed(&mut self, pdos: &[PdoName]) {
        self.stale.extend(pdos.iter().filter(|pdo| pdo.transmit).map(|pdo| (pdo.node, pdo.number)));
    }

    /// Takes a write to the COB-ID of a TPDO.
    pub fn written(&mut self, node: u8, number: u16, at: FrameRef) {
        self.written.insert((node, number), at);
    }

    /// Takes a PDO's frame.
    #[inline]
    pub fn used(&mut self, id: CanId, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        if !self.stale.is_empty() {
            self.compile(nodes, cx);
        }
        if !self.shared.is_empty() {
            self.judge(id, cx);
        }
        if !self.heard.has(id) && !self.is_told(id) {
            self.heard.take(id);
        }
    }

    /// Returns true if a TPDO is known to have an identifier by more than an EDS default.
    fn is_told(&self, id: CanId) -> bool {
        self.senders.get(&id).is_some_and(|names| names.values().any(|from| *from > Provenance::Eds))
    }

    #[cold]
    fn judge(&mut self, id: CanId, cx: &mut Context<'_>) {
        let Some((one, other, reported)) = self.shared.get_mut(&id).filter(|(.., reported)| !reported) else { return };
        *reported = true;
        let written = |name: &TpdoKey| self.written.get(name).copied();
        // The one configured later took the other's identifier.
        let later = written(other).map(|at| at.no) >= written(one).map(|at| at.no);
        let (this, that) = if later { (*other, *one) } else { (*one, *other) };
        let object = Mux { index: communication_parameter(true, this.1), sub: 1 };
        let what = Pdo020::Shared { pdo: (true, this.1), id, other: (true, that.1), of: that.0.into() };
        cx.raise(what, Some(this.0), Some(object), written(&this));
        for node in [this.0, that.0] {
            cx.evidence.circumstances.note(CircumstanceKind::SharedIdentifier, Some(node), cx.when);
        }
    }

    #[cold]
    fn compile(&mut self, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let mut concerned = BTreeSet::new();
        for name in std::mem::take(&mut self.stale) {
            if let Some(id) = self.ids.remove(&name) {
                self.former.insert(name, id);
                concerned.insert(id);
                self.senders.entry(id).or_default().remove(&name);
            }
            let pdo = nodes.get(name.0).and_then(|node| node.pdo(true, name.1));
            if let Some((cob, from)) = pdo.filter(|pdo| is_sent(pdo)).map(|pdo| pdo.cob) {
                concerned.insert(cob.id);
                self.ids.insert(name, cob.id);
                self.senders.entry(cob.id).or_default().insert(name, from);
                // Frames on it while this one was sent on another show who had the identifier.
                let moved = self.former.get(&name).is_some_and(|former| *former != cob.id);
                let taken = moved && self.heard.has(cob.id);
                if let Some(owner) = owner(cob.id, nodes).filter(|owner| taken && owner.0 != name.0) {
                    self.ids.insert(owner, cob.id);
                    self.senders.entry(cob.id).or_default().insert(owner, Provenance::Observed(cx.at.no));
                }
            }
        }
        for id in concerned {
            self.compare(id, cx);
        }
    }

    /// Finds the first two TPDOs of an identifier that are of one node or better known than by an EDS default.
    fn compare(&mut self, id: CanId, cx: &mut Context<'_>) {
        let before = self.shared.remove(&id);
        for (node, _) in before.into_iter().flat_map(|(one, other, _)| [one, other]) {
            cx.evidence.circumstances.over(CircumstanceKind::SharedIdentifier, node);
        }
        let mut names = self.senders.get(&id).into_iter().flatten();
        let Some((&first, &known)) = names.next() else {
            self.senders.remove(&id);
            return;
        };
        let certain = known > Provenance::Eds;
        let other = names.find(|(name, from)| name.0 == first.0 || certain && **from > Provenance::Eds);
        if let Some((&name, _)) = other {
            let reported = before.is_some_and(|(one, other, reported)| reported && (one, other) == (first, name));
            self.shared.insert(id, (first, name, reported));
        }
    }
}

/// Returns the TPDO that has an identifier by the pre-defined connection set or by its EDS, if nothing says otherwise.
fn owner(id: CanId, nodes: &PerNode<Node>) -> Option<TpdoKey> {
    let number = match id.raw() {
        raw @ 0x181..=0x4FF if raw & 0x80 != 0 && raw & 0x7F != 0 && !id.is_extended() => (raw >> 8) as u16,
        _ => return None,
    };
    let node = (id.raw() & 0x7F) as u8;
    let elsewhere = |pdo: &Pdo| {
        let (cob, from) = pdo.cob;
        !cob.valid || cob.id != id || !matches!(from, Provenance::Default | Provenance::Eds)
    };
    (!nodes.get(node)?.pdo(true, number).is_some_and(elsewhere)).then_some((node, number))
}

/// Returns true if a PDO is known for certain to be sent by its node.
fn is_sent(pdo: &Pdo) -> bool {
    let (cob, from) = pdo.cob;
    let empty = matches!(pdo.content, Content::Disabled(_));
    pdo.transmit && cob.valid && !empty && !from.is_doubted() && from != Provenance::Default
}
