//! What checks say by a number and by names in strings, as the variant that it means.
//!
//! It goes when the last check hands over a variant of its rule.

use super::facts::{Facts, Measured};
use super::{Code, MEASURED, Quantity};

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
            Self::None | Self::Unmet(_) | Self::Repeated { .. } => None,
        }
    }
}
