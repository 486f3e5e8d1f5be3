//! The PDOs that a description presets, and its defects about them.

use std::sync::Arc;

use super::{DefectFact, Defects, FiledObject};
use crate::wire::pdo::mapping_parameter;
use crate::world::dictionary::Dictionary;
use crate::world::preset::{self, Doubt, Doubted, Preset};

/// Returns the PDOs of a table. Its inconsistencies are noted, each at the line of the object; without `defects` none.
pub(super) fn presets(
    table: &Arc<Dictionary>,
    dummies: &[u16],
    objects: &[FiledObject],
    mut defects: Option<&mut Defects>,
) -> Vec<Preset> {
    let mut presets = Vec::new();
    for (preset, doubts) in preset::presets(table, dummies) {
        for doubt in doubts {
            if let Some(defects) = &mut defects {
                let (code, facts) = said(&preset, &doubt);
                defects.note(line(objects, &doubt), code, facts);
            }
        }
        presets.push(preset);
    }
    presets
}

/// Returns the line of the object in doubt.
fn line(objects: &[FiledObject], doubt: &Doubt) -> usize {
    let place = objects.binary_search_by_key(&doubt.index, |object| object.index);
    let Some(object) = place.ok().and_then(|place| objects.get(place)) else { return 0 };
    let entry = object.entries.iter().find(|entry| Some(entry.sub) == doubt.sub);
    entry.map_or(object.line, |entry| entry.line)
}

/// Returns the code and the facts of an inconsistency.
fn said(preset: &Preset, doubt: &Doubt) -> (&'static str, Vec<(&'static str, DefectFact)>) {
    let (transmit, number) = (preset.pdo.transmit, preset.pdo.number);
    let whole = |value: u64| DefectFact::Whole(i128::from(value));
    let object = |index: u16| ("object", format!("{index:04X}h").into());
    let part = |index: u16, sub: u8| ("object", format!("{index:04X}h:{sub:02X}").into());
    let (code, facts) = match doubt.what {
        Doubted::CobId { value } => ("cob-id", vec![("value", format!("{value:08X}h").into())]),
        Doubted::NoMapping => ("mapping-missing", vec![object(mapping_parameter(transmit, number))]),
        Doubted::Count { said, found } => {
            ("mapping-count", vec![object(doubt.index), ("said", whole(said)), ("found", found.into())])
        }
        Doubted::Length { bits } => {
            ("mapping-length", vec![("bits", whole(bits.into())), ("most", whole(preset::MOST_BITS.into()))])
        }
        Doubted::Unknown { index, sub } => ("mapped-unknown", vec![part(index, sub)]),
        Doubted::Size { index, sub, bits, width } => {
            ("mapped-size", vec![part(index, sub), ("bits", whole(bits.into())), ("width", whole(width.into()))])
        }
    };
    let pdo = format!("{}{number}", if transmit { "TPDO" } else { "RPDO" });
    (code, std::iter::once(("pdo", pdo.into())).chain(facts).collect())
}
