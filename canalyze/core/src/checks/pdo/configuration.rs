//! The configuration of PDOs by SDO (CiA 301, 7.5.2.35 to .38), and their use as configured.
//!
//! A PDO is made invalid (bit 31 of its COB-ID) before its identifier or mapping changes. Only acknowledged writes are
//! judged, with the knowledge before them: the bus reports a write before it takes the value. A PDO that was not seen
//! before the first write is not assumed to be valid.

use std::collections::{BTreeMap, BTreeSet};

use crate::bytes::frame::{CanId, Frame, FrameRef, Kind};
use crate::rules::finding::{Code, Finding, Verdict};
use crate::rules::pdo::{Pdo008, Pdo009, Pdo010, Pdo011, Pdo014, Pdo015, Pdo016, Pdo018, Pdo019};
use crate::sdo::transfer::Transfer;
use crate::sdo::wire::Mux;
use crate::wire::error_control::OPERATIONAL;
use crate::wire::pdo::communication_parameter;
use crate::wire::pdo::mapping::decode_entry;
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::node::{CobId, Content, Node, Pdo, PerNode};

/// Maximum number of bits in a classic PDO.
const CLASSIC_BITS: u32 = 64;
/// Number of frames that may still have been on their way after a PDO was made invalid.
const UNDER_WAY: u64 = 2;
/// Identifiers that no object may use (CiA 301, 7.3.5).
const RESTRICTED: [std::ops::RangeInclusive<u32>; 6] =
    [0x000..=0x07F, 0x101..=0x180, 0x581..=0x5FF, 0x601..=0x67F, 0x6E0..=0x6FF, 0x701..=0x7FF];

/// The observed PDO configurations of a bus.
#[derive(Debug, Default)]
pub struct PdoConfiguration {
    nodes: PerNode<SeenPdos>,
    /// PDOs may be longer than eight bytes.
    fd: bool,
}

#[derive(Debug, Default)]
struct SeenPdos {
    /// The identifiers of TPDOs 1 to 8 seen since the last reset.
    sent: [Option<CanId>; 8],
    /// Findings reported once per PDO.
    reported: BTreeSet<(Code, bool, u16)>,
    /// Frame of the last acknowledged write of a COB-ID, with or without its request in the capture.
    acknowledged: BTreeMap<(bool, u16), u64>,
    /// TPDOs sent although disabled, and the first such frame.
    disabled: BTreeMap<u16, FrameRef>,
    /// PDOs whose mapping is being changed although they are valid.
    live: BTreeSet<(bool, u16)>,
    /// PDOs whose COB-ID was written with unknown success, and the frame that showed it.
    doubted: BTreeMap<(bool, u16), u64>,
    /// It was reset or has booted.
    booted: bool,
}

/// Returns true for a mapping parameter and for a transmit PDO, and the PDO number.
pub fn pdo_parameter(index: u16) -> Option<(bool, bool, u16)> {
    let (mapping, transmit) = match index {
        0x1400..=0x15FF => (false, false),
        0x1600..=0x17FF => (true, false),
        0x1800..=0x19FF => (false, true),
        0x1A00..=0x1BFF => (true, true),
        _ => return None,
    };
    Some((mapping, transmit, (index & 0x1FF) + 1))
}

/// Returns true if CiA 301 forbids configuring an identifier.
pub fn restricted(id: CanId) -> bool {
    !id.is_extended() && RESTRICTED.iter().any(|range| range.contains(&id.raw()))
}

impl PdoConfiguration {
    /// Takes an acknowledged write. Its value is unknown if the request is missing or late in the capture.
    pub fn acknowledged(&mut self, node: u8, mux: Mux, frame: &Frame) {
        if let (Some((false, transmit, number)), 1) = (pdo_parameter(mux.index), mux.sub) {
            self.nodes.entry(node).acknowledged.insert((transmit, number), frame.no);
            self.doubt(node, mux, frame.no);
        }
    }

    /// Takes a write that was neither acknowledged nor refused correctly, or has an unknown result.
    pub fn doubt(&mut self, node: u8, mux: Mux, frame: u64) {
        if let (Some((false, transmit, number)), 1) = (pdo_parameter(mux.index), mux.sub) {
            self.nodes.entry(node).doubted.entry((transmit, number)).or_insert(frame);
        }
    }

    /// Judges an acknowledged write before it is applied; `state` is the node's NMT state if known.
    pub fn written(
        &mut self,
        (node, state): (Option<&Node>, Option<u8>),
        transfer: &Transfer,
        mux: Mux,
        value: u64,
        cx: &mut Context<'_>,
    ) {
        let cause = (transfer.first.no != cx.at.no).then_some(transfer.first);
        let write = Write { id: transfer.node, mux, value, cause };
        write.identifier(cx);
        let Some((mapping, transmit, number)) = pdo_parameter(mux.index) else { return };
        let seen = self.nodes.entry(transfer.node);
        let doubted = seen.doubted.get(&(transmit, number)).is_some_and(|since| *since < transfer.first.no);
        let valid = seen.valid(node, transmit, number).filter(|_| !doubted);
        if !mapping && mux.sub == 1 {
            seen.doubted.remove(&(transmit, number));
        }
        match (mapping, mux.sub) {
            (false, 1) => {
                seen.reported.retain(|(_, direction, pdo)| (*direction, *pdo) != (transmit, number));
                if transmit {
                    seen.disabled.remove(&number);
                }
                let cob = CobId::from_entry(value);
                if !cob.valid {
                    seen.live.remove(&(transmit, number));
                    seen.sent(transmit, number, None);
                } else if let Some(old) = valid
                    && old != cob.id
                {
                    write.raise(Pdo010::Changed { old, found: cob.id }, cx);
                }
            }
            (false, 2) => write.transmission(transmit, cx),
            (true, sub) => {
                let active = node.and_then(|node| node.value(mux.index, 0)).is_none_or(|(count, _)| count != 0);
                // Many masters write only sub-index 0 while no PDO is sent anyway.
                let idle = state.map_or(seen.booted, |state| state != OPERATIONAL) && !seen.sends(transmit, number);
                let judged = valid.is_some() && (active || !idle) && write.changes_live(node);
                if judged && seen.live.insert((transmit, number)) {
                    let pdo = (transmit, number);
                    write.raise(if active { Pdo009::InUse { pdo } } else { Pdo009::Disabled { pdo } }, cx);
                }
                if sub == 0 && value != 0 {
                    seen.live.remove(&(transmit, number));
                    if !self.fd {
                        write.length(node, cx);
                    }
                }
            }
            _ => {}
        }
    }

    /// Takes a data frame of a PDO that is partly known.
    pub fn used(&mut self, node: u8, pdo: &Pdo, frame: &Frame, cx: &mut Context<'_>) {
        self.fd |= matches!(frame.kind, Kind::Fd { .. });
        let (cob, from) = pdo.cob;
        let (name, id) = ((pdo.transmit, pdo.number), frame.id);
        let what: Verdict = match (cob.valid, from, &pdo.content) {
            (false, Provenance::Observed(known), _) if pdo.transmit => {
                let seen = self.nodes.entry(node);
                // The value of a later write, or its acceptance, is unknown.
                let later = [seen.acknowledged.get(&name), seen.doubted.get(&name)].into_iter().flatten();
                let superseded = later.into_iter().any(|later| *later > known);
                if cx.at.no > known.saturating_add(UNDER_WAY) && !superseded {
                    let because_of = seen.disabled.get(&pdo.number).copied();
                    seen.disabled.entry(pdo.number).or_insert(cx.at);
                    let object = Mux { index: pdo.communication(), sub: 1 };
                    let finding = cx.verdict(Pdo018::Sent { pdo: name, id }, Some(node), Some(object), None);
                    cx.report(Finding { because_of, ..finding });
                }
                return;
            }
            (false, Provenance::Observed(_), _) => Pdo019::Disabled { pdo: name, id }.into(),
            (false, Provenance::Eds | Provenance::Dcf, _) => Pdo019::DisabledInDescription { pdo: name, id }.into(),
            (true, _, Content::Disabled(from)) if frame.len > 0 && !from.is_doubted() => match from {
                Provenance::Observed(_) => Pdo015::Empty { pdo: name, id }.into(),
                _ => Pdo015::EmptyInDescription { pdo: name, id }.into(),
            },
            _ => return self.sent(node, pdo.transmit, pdo.number, frame.id),
        };
        let seen = self.nodes.entry(node);
        seen.sent(pdo.transmit, pdo.number, Some(frame.id));
        if seen.reported.insert((what.code, pdo.transmit, pdo.number)) {
            let object = Mux { index: pdo.communication(), sub: u8::from(what.code == Code::Pdo019) };
            cx.raise(what, Some(node), Some(object), None);
        }
    }

    /// Takes a data frame of a PDO: a TPDO that is sent is valid.
    pub fn sent(&mut self, node: u8, transmit: bool, number: u16, id: CanId) {
        if transmit {
            self.nodes.entry(node).sent(transmit, number, Some(id));
        }
    }

    /// Takes a remote frame for a TPDO.
    pub fn requested(&mut self, node: u8, pdo: &Pdo, frame: &Frame, cx: &mut Context<'_>) {
        let (cob, from) = pdo.cob;
        if pdo.transmit && cob.valid && !cob.rtr_allowed && from > Provenance::Eds {
            let object = Mux { index: pdo.communication(), sub: 1 };
            cx.raise(Pdo011::Remote { pdo: (true, pdo.number), id: frame.id }, Some(node), Some(object), None);
        }
    }

    /// Forgets identifiers and changes after lost frames.
    pub fn lost(&mut self) {
        for (_, seen) in self.nodes.iter_mut() {
            seen.sent = Default::default();
            seen.live.clear();
        }
    }

    /// Takes a reset of a node, or of all.
    pub fn reset(&mut self, node: Option<u8>) {
        let fresh = || SeenPdos { booted: true, ..SeenPdos::default() };
        match node {
            Some(node) => *self.nodes.entry(node) = fresh(),
            None => self.nodes.iter_mut().for_each(|(_, seen)| *seen = fresh()),
        }
    }
}

impl SeenPdos {
    fn sent(&mut self, transmit: bool, number: u16, id: Option<CanId>) {
        if let Some(slot) = self.sent.get_mut(usize::from(number.saturating_sub(1))).filter(|_| transmit) {
            *slot = id;
        }
    }

    /// Returns true if a TPDO was seen since it was configured.
    fn sends(&self, transmit: bool, number: u16) -> bool {
        transmit && self.sent.get(usize::from(number.saturating_sub(1))).is_some_and(Option::is_some)
    }

    /// Returns the identifier of a PDO known to be valid by its COB-ID in the capture or its frames.
    fn valid(&self, node: Option<&Node>, transmit: bool, number: u16) -> Option<CanId> {
        match node.and_then(|node| node.before_writing(communication_parameter(transmit, number), 1)) {
            Some((cob, Provenance::Observed(_))) => {
                Some(CobId::from_entry(cob)).filter(|cob| cob.valid).map(|cob| cob.id)
            }
            _ => self.sent.get(usize::from(number.saturating_sub(1))).copied().flatten().filter(|_| transmit),
        }
    }
}

/// An acknowledged write.
struct Write {
    id: u8,
    mux: Mux,
    value: u64,
    /// The frame of its request.
    cause: Option<FrameRef>,
}

impl Write {
    fn raise(&self, what: impl Into<Verdict>, cx: &mut Context<'_>) {
        cx.raise(what, Some(self.id), Some(self.mux), self.cause);
    }

    /// Judges a COB-ID of any service.
    fn identifier(&self, cx: &mut Context<'_>) {
        let cob = CobId::from_entry(self.value);
        let (used, default_channel) = match (self.mux.index, self.mux.sub) {
            (0x1005, 0) => (true, false),
            (0x1012, 0) => (self.value & 3 << 30 != 0, false),
            (0x1014, 0) | (0x1400..=0x15FF | 0x1800..=0x19FF, 1) => (cob.valid, false),
            (0x1201..=0x127F, 1 | 2) => (cob.valid, false),
            (0x1280..=0x12FF, 1 | 2) => (cob.valid, true),
            _ => (false, false),
        };
        // A client's channel to a server's default channel uses the same identifiers.
        let default_channel = default_channel && matches!(cob.id.raw(), 0x581..=0x5FF | 0x601..=0x67F);
        if used && restricted(cob.id) && !default_channel {
            self.raise(Pdo014::Restricted { id: cob.id }, cx);
        }
    }

    fn transmission(&self, transmit: bool, cx: &mut Context<'_>) {
        let reserved = if transmit { 241..=251 } else { 241..=253 };
        if reserved.contains(&self.value) {
            let found = self.value;
            self.raise(if transmit { Pdo008::Tpdo { found } } else { Pdo008::Rpdo { found } }, cx);
        }
    }

    /// Returns true if a write to the mapping of a valid PDO changes the meaning of its bytes. Sub-index 0 alone only
    /// disables or enables the mapping.
    fn changes_live(&self, node: Option<&Node>) -> bool {
        let before = node.and_then(|node| node.value(self.mux.index, self.mux.sub)).map(|(value, _)| value);
        match self.mux.sub {
            0 => self.value != 0 && before.is_some_and(|before| before != 0 && before != self.value),
            _ => before != Some(self.value),
        }
    }

    /// Judges the length of a mapping that is enabled.
    fn length(&self, node: Option<&Node>, cx: &mut Context<'_>) {
        let (Some(node), 1..=64) = (node, self.value) else { return };
        let mut bits = 0;
        for sub in 1..=self.value as u8 {
            let Some((word, Provenance::Observed(_))) = node.value(self.mux.index, sub) else { return };
            bits += u32::from(decode_entry(word as u32).2);
        }
        if bits > CLASSIC_BITS {
            self.raise(Pdo016::Bits { found: bits.into() }, cx);
        }
    }
}
