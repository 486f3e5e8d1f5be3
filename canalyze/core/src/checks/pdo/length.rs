//! The length of a PDO against its mapping (CiA 301, 7.5.2.36 and 7.5.2.38).
//!
//! A receiver does not process a PDO shorter than its mapping, and ignores excess bytes. Only a mapping from the
//! capture, an option or a DCF is trusted; against an EDS, the device may have been configured before the capture. A
//! PDO of unknown mapping is expected to keep its length. The finding does not say which side is at fault.

use super::series::Series;
use crate::bytes::frame::{Frame, FrameRef, Kind};
use crate::evidence::Rules;
use crate::rules::description::Eds001;
use crate::rules::finding::{Code, Finding, Verdict};
use crate::rules::pdo::{Pdo001, Pdo006, Pdo012, Pdo021};
use crate::sdo::wire::Mux;
use crate::wire::pdo::{communication_parameter, mapping_parameter};
use crate::world::configuration::Provenance;
use crate::world::context::Context;
use crate::world::event::{Signals, Unmapped};
use crate::world::node::{Node, PerNode, PerPdo};

/// Lengths of a CAN FD frame beyond eight bytes; others are filled up.
const FD_LENGTHS: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];
/// Maximum number of bits in a classic PDO; a longer mapping is itself at fault.
const CLASSIC_BITS: u16 = 64;
/// Number of frames after a mapping became known that may have been on their way before.
const UNDER_WAY: u64 = 1;

/// Number of frames of one length that make it the PDO's length.
const SHOWN: u8 = 3;

/// Evidence for the trust in a mapping.
#[derive(Debug, Default)]
pub struct PdoLength {
    /// The frame after which frames were lost; earlier observations may no longer hold.
    lost: Option<u64>,
    nodes: PerNode<Lengths>,
}

/// The PDO lengths of a node.
#[derive(Debug, Default)]
struct Lengths {
    /// Its last reset or boot-up.
    reset: Option<u64>,
    /// TPDOs and RPDOs 1 to 64 that had the length of their mapping since then, one bit each.
    fitted: [u64; 2],
    pdos: PerPdo<PdoLengths>,
    /// The capture contains its SDO, and would show a change of the mapping.
    asked: bool,
}

/// The lengths of a PDO.
#[derive(Debug, Default)]
struct PdoLengths {
    /// Frames of another length than its mapping, by rule.
    wrong: Vec<(Code, Series)>,
    /// Its length if its mapping is unknown.
    kept: Option<Kept>,
}

impl PdoLengths {
    /// Adds a frame of another length; returns the first frame by the same rule if this is a further one.
    fn fault(&mut self, code: Code, at: FrameRef) -> Option<FrameRef> {
        if !self.wrong.iter().any(|(known, _)| *known == code) {
            self.wrong.push((code, Series::default()));
        }
        self.wrong.iter_mut().find(|(known, _)| *known == code).and_then(|(_, wrong)| wrong.fault(at))
    }
}

/// The length of a PDO of unknown mapping.
#[derive(Clone, Copy, Debug)]
struct Kept {
    len: u8,
    /// Number of frames with this length, up to [`SHOWN`].
    count: u8,
    /// The length, number and first frame of a series with another length since then.
    other: Option<(u8, u8, FrameRef)>,
    wrong: Series,
}

/// A PDO whose length differs from its mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Misfit {
    found: u64,
    mapped: u64,
    from: Provenance,
    /// Node-ID and RPDO of the receiver that the mapping belongs to.
    consumer: Option<(u8, u16)>,
}

impl Misfit {
    /// Returns true if the frame is too short for the mapping.
    pub fn is_short(&self) -> bool {
        self.found < self.mapped
    }
}

/// Compares a frame with the mapping that decodes it.
#[inline]
pub fn misfit(content: &Signals, frame: &Frame) -> Option<Misfit> {
    let (mapping, from, consumer) = match content {
        Signals::Mapped(mapping, from) => (mapping, *from, None),
        Signals::ByConsumer(mapping, from, node, number) => (mapping, *from, Some((*node, *number))),
        Signals::None(_) => return None,
    };
    let (found, mapped) = (usize::from(frame.len), mapping.bytes());
    if from.is_unconfirmed() || found == mapped || mapped == 0 {
        return None;
    }
    match frame.kind {
        Kind::Fd { .. } if FD_LENGTHS.iter().find(|length| **length >= mapped) == Some(&found) => return None,
        Kind::Data if mapping.bits > CLASSIC_BITS => return None,
        _ => {}
    }
    Some(Misfit { found: found as u64, mapped: mapped as u64, from, consumer })
}

/// Returns true if a frame has the length of its PDO's mapping, as far as known.
pub fn fits(content: &Signals, frame: &Frame) -> bool {
    misfit(content, frame).is_none() && !matches!(content, Signals::None(Unmapped::Contradicted))
}

impl PdoLength {
    /// Reports a frame of another length than its mapping.
    pub fn judge(
        &mut self,
        transmit: bool,
        number: u16,
        node: u8,
        known: Option<&Node>,
        misfit: &Misfit,
        cx: &mut Context<'_>,
    ) {
        let Misfit { found, mapped, from, consumer } = *misfit;
        let lengths = self.nodes.get(consumer.map_or(node, |(consumer, _)| consumer));
        // A device may have stored another mapping than the EDS default, unless it was seen to keep that.
        let (place, bit) = bit(transmit, number);
        let kept = lengths.is_some_and(|known| known.fitted.get(place).is_some_and(|set| set & bit != 0));
        // A value only read before a reset may have been written before the capture and be gone; a written one may have
        // outlived a reset of communication. A frame that fits since then has shown which.
        let reset = lengths.and_then(|lengths| lengths.reset).filter(|_| !kept || consumer.is_some());
        let doubted = |known| self.lost.is_some_and(|lost| known <= lost) || reset.is_some_and(|reset| known <= reset);
        if let Provenance::Observed(known) = from
            && (cx.at.no <= known.saturating_add(UNDER_WAY) || doubted(known))
        {
            return;
        }
        if from == Provenance::Profile {
            return; // nobody says that the device has that mapping
        }
        let trusted = from > Provenance::Eds;
        if !trusted && (consumer.is_some() || known.is_none_or(|known| mixed(known, transmit, number))) {
            return;
        }
        let consumer = consumer.map(|(consumer, number)| (u64::from(consumer), (false, number)));
        let what: Verdict = match (trusted, found < mapped, consumer) {
            (false, ..) if kept => Pdo012::Length { found, mapped }.into(),
            (false, ..) => Eds001::PdoLength { found, mapped }.into(),
            (true, true, None) => Pdo001::Length { found, mapped }.into(),
            (true, true, Some((consumer, pdo))) => Pdo001::OfConsumer { found, mapped, consumer, pdo }.into(),
            (true, false, None) => Pdo006::Length { found, mapped }.into(),
            (true, false, Some((consumer, pdo))) => Pdo006::OfConsumer { found, mapped, consumer, pdo }.into(),
        };
        let object = Mux { index: communication_parameter(transmit, number), sub: 0 };
        let because_of = self.nodes.entry(node).pdos.entry(transmit, number).fault(what.code, cx.at);
        let finding = cx.verdict(what, Some(node), Some(object), None);
        cx.report(cx.excused(Rules::PdoLength, cx.when, Finding { because_of, ..finding }));
    }

    /// Takes a frame of a PDO that has the length of its mapping.
    pub fn fitted(&mut self, transmit: bool, number: u16, node: u8) {
        let (place, bit) = bit(transmit, number);
        let lengths = self.nodes.entry(node);
        if let Some(set) = lengths.fitted.get_mut(place) {
            *set |= bit;
        }
        if let Some(pdo) = lengths.pdos.get_mut(transmit, number) {
            pdo.wrong.iter_mut().for_each(|(_, wrong)| wrong.keep());
        }
    }

    /// Notes that the capture contains SDO of a node.
    pub fn asked(&mut self, node: u8) {
        self.nodes.entry(node).asked = true;
    }

    /// Takes a write, or possible write, to a PDO parameter, which may change its length.
    pub fn reconfigured(&mut self, node: u8, transmit: bool, number: u16) {
        if let Some(pdo) = self.nodes.get_mut(node).and_then(|lengths| lengths.pdos.get_mut(transmit, number)) {
            pdo.kept = None;
        }
    }

    /// Takes a frame of a PDO of unknown mapping. If the capture would not show a change of mapping, the frames after
    /// it decide: they return to the previous length.
    #[inline]
    pub fn unmapped(&mut self, name: (bool, u16, u8), frame: &Frame, cx: &mut Context<'_>) {
        let (transmit, number, node) = name;
        let pdo = self.nodes.get_mut(node).and_then(|lengths| lengths.pdos.get_mut(transmit, number));
        let kept = pdo.and_then(|pdo| pdo.kept.as_mut());
        match kept.filter(|kept| kept.len == frame.len && kept.count == SHOWN && kept.other.is_none()) {
            Some(kept) => kept.wrong.keep(),
            None => self.differs(name, frame, cx),
        }
    }

    /// Does the same where it may have another length than before.
    #[inline(never)]
    fn differs(&mut self, (transmit, number, node): (bool, u16, u8), frame: &Frame, cx: &mut Context<'_>) {
        let lengths = self.nodes.entry(node);
        let fresh = Kept { len: frame.len, count: 0, other: None, wrong: Series::default() };
        let kept = lengths.pdos.entry(transmit, number).kept.get_or_insert(fresh);
        let object = Mux { index: communication_parameter(transmit, number), sub: 0 };
        let found = |len: u8, before: u8| Pdo021::Changed { found: len.into(), before: before.into() };
        if frame.len == kept.len {
            kept.count = kept.count.saturating_add(1).min(SHOWN);
            kept.wrong.keep();
            if let Some((len, _, first)) = kept.other.take().filter(|_| !lengths.asked) {
                let finding = cx.verdict(found(len, kept.len), Some(node), Some(object), None);
                cx.report(Finding { at: first, because_of: kept.wrong.fault(first), ..finding });
            }
            return;
        }
        if kept.count < SHOWN {
            *kept = Kept { count: 1, ..fresh };
            return;
        }
        let before = kept.other.filter(|(len, ..)| *len == frame.len);
        let (count, first) = before.map_or((1, cx.at), |(_, count, first)| (count + 1, first));
        kept.other = Some((frame.len, count, first));
        if lengths.asked {
            let finding = cx.verdict(found(frame.len, kept.len), Some(node), Some(object), None);
            let because_of = kept.wrong.fault(cx.at);
            cx.report(Finding { because_of, ..finding });
        }
        if count > SHOWN {
            // It has that length from now on.
            *kept = Kept { count: SHOWN, ..fresh };
        }
    }

    /// Takes a reset of a node, or of all.
    pub fn reset(&mut self, node: Option<u8>, cx: &Context<'_>) {
        let nodes = match node {
            Some(node) => node..=node,
            None => 1..=127,
        };
        for node in nodes {
            let asked = self.nodes.entry(node).asked;
            *self.nodes.entry(node) = Lengths { reset: Some(cx.at.no), asked, ..Lengths::default() };
        }
    }

    /// Forgets lengths after lost frames.
    pub fn lost(&mut self, cx: &Context<'_>) {
        self.lost = Some(cx.at.no);
        for (_, lengths) in self.nodes.iter_mut() {
            lengths.fitted = [0; 2];
            lengths.pdos.values_mut().for_each(|pdo| pdo.kept = None);
        }
    }
}

/// Returns true if part of the mapping comes from another source than the EDS: the whole is then unknown.
fn mixed(node: &Node, transmit: bool, number: u16) -> bool {
    let index = mapping_parameter(transmit, number);
    node.configuration.is_beyond_eds(index)
}

/// Returns the place and bit of a PDO in [`Lengths::fitted`]; bit 0 beyond number 64.
fn bit(transmit: bool, number: u16) -> (usize, u64) {
    (usize::from(transmit), 1_u64.checked_shl(u32::from(number.saturating_sub(1))).unwrap_or(0))
}
