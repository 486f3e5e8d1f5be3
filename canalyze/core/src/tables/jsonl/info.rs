//! A file as one JSON object: kind `info`.
//!
//! The command adds `format`, `compression`, `checked` (all that was unpacked has a check sum; null where nothing was)
//! and `size`, which are not known here.

use super::obj::{WriteJson, array, named, obj, raw, text, time};
use super::{Setting, contents};
use crate::bytes::frame::{BusId, Stamp, StampForm};
use crate::bytes::info::{Info, Zone};
use crate::bytes::readers::listing::LeftOut;
use crate::bytes::readers::{Contents, Damage, DamageKind, FilePlace};
use crate::bytes::writers::console;

/// Names of damage, as this crate's callers say it too.
pub const DAMAGES: &[(&str, DamageKind)] = &[
    ("cut", DamageKind::Cut),
    ("checksum", DamageKind::Checksum),
    ("structure", DamageKind::Structure),
    ("compression", DamageKind::Compression),
    ("rest", DamageKind::Rest),
    ("undefined", DamageKind::Undefined),
    ("doubtful", DamageKind::Doubtful),
    ("definition", DamageKind::Definition),
    ("missing", DamageKind::Missing),
    ("excess", DamageKind::Excess),
    ("unlocated", DamageKind::Unlocated),
];

/// Appends the object of a file.
pub fn info(out: &mut Vec<u8>, setting: Setting<'_>, info: &Info, known: &Contents) {
    let buses = info.buses.iter().enumerate().filter(|(_, frames)| **frames > 0);
    let decimals = info.decimals.map_or(9, |(_, most)| most);
    let date = |ns| text(move |out| console::digits(out, &Stamp { form: StampForm::Calendar, ns, width: 1, decimals }));
    let (ends, dates) = (info.span.ends_ns, info.dates());
    obj! {
        "kind": "info", "file": setting.file, "frames": info.frames,
        /// In order of first appearance.
        "buses": array(buses.map(|(no, frames)| obj! {
            "bus": named(setting.buses.name(BusId(no as u8))), "frames": *frames,
        })),
        /// The last two are counts of the first three.
        "kinds": obj! {
            "data": info.data, "remote": info.remote, "fd": info.fd, "error": info.error,
            "standard": info.standard, "extended": info.extended,
        },
        /// Where the format has them.
        "directions": obj! { "rx": info.rx, "tx": info.tx },
        "unstamped": info.unstamped,
        "first_t": time(ends.map(|ends| ends.0), decimals),
        "last_t": time(ends.map(|ends| ends.1), decimals),
        /// The time between, without the time by which the clock was set back.
        "seconds": time(info.span.elapsed_ns, decimals),
        /// Null where unknown.
        "first_date": dates.map(|(first, ..)| date(first)),
        "last_date": dates.map(|(_, last, _)| date(last)),
        "zone": dates.map(|(.., zone)| match zone {
            Zone::Utc => "utc",
            Zone::Local => "local",
        }),
        /// Digits after the point of a stamp: the fewest, the most.
        "decimals": info.decimals.map(|(fewest, most)| array([fewest, most])),
        /// Stamps earlier than the one before, and the longest such step.
        "backward": info.span.backward,
        "backward_most_us": info.span.backward_most_ns.abs() / 1000,
        /// Stamps outside of 1677-09-21 to 2262-04-11, taken as the end of that range.
        "clamped_stamps": info.clamped_stamps,
        "unreadable": info.first_unreadable.map(|place| obj! {
            "count": info.unreadable, "first_line": place.line(), "first_offset": offset(place),
            /// Those that are on more buses than are kept apart.
            "further_buses": info.of_further_buses,
        }),
        /// Reports of lost frames, and the frames that were lost by them.
        "gaps": info.gaps,
        "dropped": info.dropped,
        /// Error markers without content.
        "error_markers": info.error_markers,
        /// Rows that are missing by the file itself.
        "left_out": left_out(&info.left_out),
        /// The first 64.
        "damage": array(info.damage.iter().map(damage)),
        "damages": info.damages,
        "contents": raw(|out| contents::contents(out, known)),
    }
    .write_line(out);
}

/// Frames of the kinds `doubtful` and `definition` are not lost, but may be wrong.
fn damage(damage: &Damage) -> impl WriteJson + use<> {
    obj! {
        "kind": DAMAGES.iter().find(|(_, kind)| *kind == damage.kind).map_or("", |(name, _)| *name),
        "line": damage.place.line(), "offset": offset(damage.place), "bytes": damage.bytes, "frames": damage.frames,
    }
}

fn offset(place: FilePlace) -> Option<u64> {
    if let FilePlace::Byte(offset) = place { Some(offset) } else { None }
}

/// Returns the places where the file itself shows that rows are missing: those without a count, and the rows of the others.
pub(super) fn left_out(known: &LeftOut) -> Option<impl WriteJson> {
    let LeftOut { places, uncounted, rows } = *known;
    (places > 0).then_some(obj! { "places": places, "uncounted": uncounted, "rows": rows })
}
