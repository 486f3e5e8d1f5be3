//! What checks say by a number and by names in strings, as the variant that it means.
//!
//! It goes when the last check hands over a variant of its rule.

use super::facts::{Facts, Measured};
use super::sdo::{
    Sdo001, Sdo002, Sdo003, Sdo004, Sdo005, Sdo006, Sdo007, Sdo010, Sdo012, Sdo017, Sdo019, Sdo021, Sdo022, Sdo023,
    Sdo030, Sdo031,
};
use super::{Code, MEASURED, Quantity, Verdict};
use crate::services::sdo::wire::Side;

/// An unused place of [`Facts::Told`].
pub(super) const NOTHING: (&str, Quantity) = ("", Quantity::Nothing);

impl Facts {
    /// A sentence of the rule by its number, with up to [`MEASURED`] quantities by name.
    pub fn told(face: u8, quantities: &[(&'static str, Quantity)]) -> Self {
        let mut measured = [NOTHING; MEASURED];
        for (slot, quantity) in measured.iter_mut().zip(quantities) {
            *slot = *quantity;
        }
        Self::Told { face, measured }
    }

    /// The variant of the rule that it means, where it is one.
    pub(crate) fn measured(&self, code: Code) -> Option<Measured> {
        match *self {
            Self::Measured(measured) => Some(measured),
            Self::Told { face, measured } => {
                let variant = code.rule().variants.get(usize::from(face))?;
                let named = |name| measured.iter().find(|(known, _)| *known == name).map(|(_, quantity)| *quantity);
                let mut names = variant.facts.iter().map(|fact| fact.name);
                let told = measured.map(|_| names.next().and_then(named).unwrap_or(Quantity::Nothing));
                Some(Measured::new(variant, told))
            }
            _ => match self.verdict(code)?.facts {
                Self::Measured(measured) => Some(measured),
                _ => None,
            },
        }
    }

    fn verdict(&self, code: Code) -> Option<Verdict> {
        Some(match *self {
            Self::Toggle { expected, found, by } => Sdo001::Toggle { expected, found, by }.into(),
            Self::Missing { by: Side::Server } => Sdo002::NoResponse.into(),
            Self::Missing { by: Side::Client } => Sdo002::NoRequest.into(),
            Self::NotAcknowledged => Sdo002::NotAcknowledged.into(),
            Self::Duplicate => Sdo002::Duplicate.into(),
            Self::Objects { expected, found } => Sdo003::Objects { expected, found }.into(),
            Self::Unused(unused) => {
                let unused = unused.into();
                match code {
                    Code::Sdo004 => Sdo004::Unused { unused }.into(),
                    Code::Sdo005 => Sdo005::Unused { unused }.into(),
                    Code::Sdo021 => Sdo021::Unused { unused }.into(),
                    _ => Sdo022::Unused { unused }.into(),
                }
            }
            Self::Size { indicated, transferred } => Sdo006::Size { indicated, transferred }.into(),
            Self::Outside if code == Code::Sdo007 => Sdo007::Outside.into(),
            Self::Outside => Sdo012::Outside.into(),
            Self::NoLast if code == Code::Sdo007 => Sdo007::NoLast.into(),
            Self::NoLast => Sdo012::NoLast.into(),
            Self::Length(length) => Sdo010::Length { length: length.into() }.into(),
            Self::Sequence { expected, found } => {
                Sdo012::Sequence { expected: expected.into(), found: found.into() }.into()
            }
            Self::Acknowledged { ackseq, sent } => {
                Sdo012::Acknowledged { ackseq: ackseq.into(), sent: sent.into() }.into()
            }
            Self::NotResent { ackseq } => Sdo012::NotResent { ackseq: ackseq.into() }.into(),
            Self::BlockSize(blksize) => Sdo012::BlockSize { blksize: blksize.into() }.into(),
            Self::EarlyEnd => Sdo012::EarlyEnd.into(),
            Self::EndNotConfirmed => Sdo012::EndNotConfirmed.into(),
            Self::Crc { computed, found, matches } => Sdo019::Crc { computed, found, matches }.into(),
            Self::Abort { code, by } => Sdo017::Abort { abort: code, by }.into(),
            Self::Command(command) => Sdo023::Command { command }.into(),
            Self::Frames { count } if code == Code::Sdo030 => Sdo030::Frames { frames: count }.into(),
            Self::Frames { count } => Sdo031::Frames { frames: count }.into(),
            Self::None | Self::Told { .. } | Self::Measured(_) | Self::Unmet(_) | Self::Repeated { .. } => return None,
        })
    }
}
