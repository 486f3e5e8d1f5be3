//! What a file is, as one JSON object a file: kind `info`.
//!
//! | key | value |
//! |---|---|
//! | `kind` `file` | `info`, the file's name |
//! | `frames` | how many |
//! | `buses` | list of `{"bus", "frames"}`, in order of first appearance; `bus` is null where none is named |
//! | `kinds` | `{"data", "remote", "fd", "error", "standard", "extended"}`: counts; the last two of the first three |
//! | `directions` | `{"rx", "tx"}`: counts, where the format tells |
//! | `unstamped` | frames without a stamp |
//! | `first_t` `last_t` `seconds` | the stamps of the first frame and the last one and the time between, without what the clock was set back, as strings |
//! | `first_date` `last_date` `zone` | the same as dates; `utc`, or `local` where no zone is told; null where unknown |
//! | `decimals` | digits after the point of a stamp: null or `[fewest, most]` |
//! | `backward` `backward_most_us` | how often a stamp is earlier than the one before, and the longest such step |
//! | `clamped_stamps` | stamps out of the range that can be shown, 1677-09-21 to 2262-04-11, taken as its end |
//! | `unreadable` | null or `{"count", "first_line", "first_offset", "further_buses"}`; the last one: those that are on more buses than are kept apart |
//! | `gaps` `dropped` `error_markers` | reports of lost frames, frames said to be lost, error markers without content |
//! | `left_out` | null or `{"places", "uncounted", "rows"}`: where the file itself shows that rows are missing, those of them without a count, and the rows that the others count |
//! | `damage` | list of `{"kind", "line", "offset", "bytes", "frames"}`, the first 64; of the kinds `doubtful` and `definition` the frames are not lost, but may be wrong |
//! | `damages` | how many in all |
//! | `contents` | see `contents` |
//!
//! The command adds `format`, `compression`, `checked` (whether all that was unpacked has a check sum; null where nothing was)
//! and `size`, which are not known here.

use super::{Setting, contents, left_out, name_or_null, number_or_null, seconds};
use crate::bytes::frame::{BusId, Stamp, StampForm};
use crate::bytes::info::{Info, Zone};
use crate::bytes::readers::{Contents, Damage, DamageKind, Place};
use crate::bytes::writers::console;
use crate::words::digits::put;
use crate::words::escape;

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
    ("unlocated", DamageKind::Unlocated),
];

/// Appends the object of a file.
pub fn info(out: &mut Vec<u8>, setting: Setting<'_>, info: &Info, known: &Contents) {
    put!(out; "{\"kind\":\"info\",\"file\":");
    escape::json(out, setting.file);
    put!(out; ",\"frames\":", info.frames, ",\"buses\":[");
    let mut empty = true;
    for (no, frames) in info.buses.iter().enumerate().filter(|(_, frames)| **frames > 0) {
        put!(out; if empty { "" } else { "," }, "{\"bus\":");
        name_or_null(out, setting.buses.name(BusId(no as u8)));
        put!(out; ",\"frames\":", *frames, "}");
        empty = false;
    }
    put!(out; "],\"kinds\":{\"data\":", info.data, ",\"remote\":", info.remote, ",\"fd\":", info.fd, ",\"error\":");
    put!(out; info.error, ",\"standard\":", info.standard, ",\"extended\":", info.extended);
    put!(out; "},\"directions\":{\"rx\":", info.rx, ",\"tx\":", info.tx, "},\"unstamped\":", info.unstamped);
    times(out, info);
    put!(out; ",\"backward\":", info.span.backward, ",\"backward_most_us\":", info.span.backward_most_ns.unsigned_abs() / 1000);
    put!(out; ",\"clamped_stamps\":", info.clamped_stamps, ",\"unreadable\":");
    match info.first_unreadable {
        Some(place) => {
            put!(out; "{\"count\":", info.unreadable);
            placed(out, place, ["first_line", "first_offset"]);
            put!(out; ",\"further_buses\":", info.of_further_buses, "}");
        }
        None => put!(out; "null"),
    }
    put!(out; ",\"gaps\":", info.gaps, ",\"dropped\":", info.dropped, ",\"error_markers\":", info.error_markers);
    put!(out; ",\"left_out\":");
    left_out(out, &info.left_out);
    put!(out; ",\"damage\":[");
    for (no, one) in info.damage.iter().enumerate() {
        put!(out; if no > 0 { "," } else { "" });
        damage(out, one);
    }
    put!(out; "],\"damages\":", info.damages, ",\"contents\":");
    contents::contents(out, known);
    put!(out; "}\n");
}

fn times(out: &mut Vec<u8>, info: &Info) {
    let decimals = info.decimals.map_or(9, |(_, most)| most);
    let ends = info.span.ends_ns;
    let (first, last, elapsed) = (ends.map(|ends| ends.0), ends.map(|ends| ends.1), info.span.elapsed_ns);
    for (key, ns) in [("first_t", first), ("last_t", last), ("seconds", elapsed)] {
        put!(out; ",\"", key, "\":");
        seconds(out, ns, decimals);
    }
    match info.dates() {
        Some((first, last, zone)) => {
            for (key, ns) in [("first_date", first), ("last_date", last)] {
                put!(out; ",\"", key, "\":\"");
                console::digits(out, &Stamp { form: StampForm::Calendar, ns, width: 1, decimals });
                put!(out; "\"");
            }
            put!(out; ",\"zone\":", match zone {
                Zone::Utc => "\"utc\"",
                Zone::Local => "\"local\"",
            });
        }
        None => put!(out; ",\"first_date\":null,\"last_date\":null,\"zone\":null"),
    }
    put!(out; ",\"decimals\":");
    match info.decimals {
        Some((fewest, most)) => put!(out; "[", fewest, ",", most, "]"),
        None => put!(out; "null"),
    }
}

fn damage(out: &mut Vec<u8>, damage: &Damage) {
    let name = DAMAGES.iter().find(|(_, kind)| *kind == damage.kind).map_or("", |(name, _)| name);
    put!(out; "{\"kind\":\"", name, "\"");
    placed(out, damage.place, ["line", "offset"]);
    for (key, count) in [("bytes", damage.bytes), ("frames", damage.frames)] {
        put!(out; ",\"", key, "\":");
        number_or_null(out, count);
    }
    put!(out; "}");
}

/// A place: its line or its offset, the other one null.
fn placed(out: &mut Vec<u8>, place: Place, keys: [&'static str; 2]) {
    let [line, offset] = keys;
    put!(out; ",\"", line, "\":");
    number_or_null(out, place.line());
    put!(out; ",\"", offset, "\":");
    number_or_null(out, if let Place::Byte(offset) = place { Some(offset) } else { None });
}
