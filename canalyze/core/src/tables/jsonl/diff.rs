//! Differences of two captures in JSON: an object a line, then one that closes them.
//!
//! `difference`: `kind what bus node service index sub direction count text a b a_near b_near`. `what` is `bus`, `node`,
//! `transfer` (in one capture only), `outcome`, `value` or `mode` (of a transfer), `nmt`, `state`, `drive_state`, `emcy`,
//! `lss`, `frames`, `period`, `jitter`, `cob_id`, `mapping`, `length`, `poll` or `finding`. `bus` is the name in A, or in B
//! where A lacks the bus; `service` is `sync`, `time`, `error_control`, `TPDO1`, `RPDO1`, `SRDO1` or null;
//! `direction` is that of a transfer. `a` and `b` are what each capture has, or null: `{"bus","frame","line","t",
//! "last_frame","text","value"}`; `frame` is the first frame of it. `value` has, by kind: `status mode abort size data`
//! of a transfer (`data` are its first 64 bytes), `code` (and `register`) of a command, a state or an emergency, `frames`,
//! `period_us`, `id`, `mapping` (a list of entries), `length`, or `code message` of a finding. `a_near`, `b_near`: where
//! a capture has nothing, the nearest frame before that both have.
//!
//! `incident_difference`, before all others: `kind incident bus node differs a b`, what went wrong in one capture only, or
//! in both and otherwise. `differs` is a list of `status`, `duration`, `count` and `cause`, empty where one has nothing.
//! `a` and `b`, or null: `{"bus","id","frame","t","end_frame","status","duration_ns","count","cause","text"}`; `cause` is the
//! kind of what it comes from.
//!
//! `diff`: `kind same incidents differences more rigid times placed a b`; `more` were not listed; `rigid`: both captures show one
//! session in time; `times`: periods were compared; `placed`: it is known where one capture lies in the other. `a` and
//! `b`: `{"file","frames","first_frame","last_frame","outside","full"}`, the frames between which both captures were
//! compared, what lies outside, and whether the capture was too long.

use super::{name_or_null, number_or_null, quoted, seconds, truth};
use crate::bytes::frame::CanId;
use crate::sdo::wire::Side as Sender;
use crate::stories::incident::Incident;
use crate::tables::diff::{Setting, extents};
use crate::views::diff::Comparison;
use crate::views::diff::difference::{Difference, Shows, Side};
use crate::views::diff::digest::{Action, Digest, Service, TransferDigest};
use crate::views::diff::stories::{StoryDifference, lasted_ns};
use crate::words::diff as words;
use crate::words::digits::{Hex, Joined, put};
use crate::words::{escape, findings, incidents};

/// Appends all lines. `files`: the names of both.
pub fn write(out: &mut Vec<u8>, setting: Setting<'_>, comparison: &Comparison, files: [&[u8]; 2]) {
    for one in &comparison.stories {
        story(out, setting, one);
    }
    for one in &comparison.differences {
        difference(out, setting, one);
    }
    let count = comparison.differences.len() as u64 + comparison.more;
    put!(out; "{\"kind\":\"diff\",\"same\":", truth(comparison.count() == 0), ",\"incidents\":");
    put!(out; comparison.stories.len() as u64, ",\"differences\":", count);
    put!(out; ",\"more\":", comparison.more, ",\"rigid\":", truth(comparison.alignment.rigid));
    put!(out; ",\"times\":", truth(comparison.alignment.by_time), ",\"placed\":", truth(!comparison.alignment.is_blurred()));
    let sides = files.into_iter().zip(setting.digests).zip(comparison.outside).zip(extents(setting, comparison));
    for ((((file, digest), outside), (first, last)), key) in sides.zip([",\"a\":", ",\"b\":"]) {
        put!(out; key, "{\"file\":");
        escape::json(out, file);
        put!(out; ",\"frames\":", digest.frames, ",\"first_frame\":");
        number_or_null(out, (first > 0).then_some(first));
        put!(out; ",\"last_frame\":");
        number_or_null(out, (last > 0).then_some(last));
        put!(out; ",\"outside\":", outside, ",\"full\":", truth(digest.full), "}");
    }
    put!(out; "}\n");
}

fn story(out: &mut Vec<u8>, setting: Setting<'_>, one: &StoryDifference) {
    let sides = setting.incidents(one);
    let Some((_, first)) = sides.iter().flatten().next() else { return };
    put!(out; "{\"kind\":\"incident_difference\",\"incident\":\"", first.kind.row().name, "\",\"bus\":");
    name_or_null(out, setting.bus(one.bus));
    put!(out; ",\"node\":");
    number_or_null(out, first.subject.node.map(u64::from));
    put!(out; ",\"differs\":[");
    for (place, differs) in one.differs.iter().enumerate() {
        put!(out; if place > 0 { ",\"" } else { "\"" }, differs.name(), "\"");
    }
    put!(out; "]");
    for (key, side) in [",\"a\":", ",\"b\":"].into_iter().zip(sides) {
        put!(out; key);
        match side {
            Some((digest, one)) => incident(out, setting, digest, one),
            None => put!(out; "null"),
        }
    }
    put!(out; "}\n");
}

fn incident(out: &mut Vec<u8>, setting: Setting<'_>, digest: &Digest, one: &Incident) {
    put!(out; "{\"bus\":");
    name_or_null(out, digest.buses.name(one.bus));
    put!(out; ",\"id\":", u64::from(one.number), ",\"frame\":", one.begin.no, ",\"t\":");
    seconds(out, one.begin.t_ns, digest.decimals);
    put!(out; ",\"end_frame\":");
    number_or_null(out, one.end.map(|end| end.no));
    put!(out; ",\"status\":\"", one.status.name(), "\",\"duration_ns\":");
    number_or_null(out, lasted_ns(one).and_then(|ns| u64::try_from(ns).ok()));
    put!(out; ",\"count\":", one.repeats.count, ",\"cause\":");
    match digest.cause(one) {
        Some(cause) => put!(out; "\"", cause.kind.row().name, "\""),
        None => put!(out; "null"),
    }
    put!(out; ",\"text\":");
    quoted(out, |text| incidents::title(text, setting.lang, one, digest.began_ns));
    put!(out; "}");
}

fn difference(out: &mut Vec<u8>, setting: Setting<'_>, difference: &Difference) {
    put!(out; "{\"kind\":\"difference\",\"what\":\"", difference.what.name(), "\",\"bus\":");
    name_or_null(out, setting.bus(difference.bus));
    put!(out; ",\"node\":");
    number_or_null(out, difference.node.filter(|node| *node > 0).map(u64::from));
    put!(out; ",\"service\":");
    match difference.what.service() {
        Some(of) => service(out, of),
        None => put!(out; "null"),
    }
    let moved = difference.sides.iter().flatten().find_map(|side| match &side.shows {
        Shows::Action(Action::Transfer(moved)) => Some(moved),
        _ => None,
    });
    let raised = difference.sides.iter().flatten().find_map(|side| match &side.shows {
        Shows::Finding(finding) => finding.object,
        _ => None,
    });
    match moved.and_then(|moved| moved.mux).or(raised) {
        Some(mux) => put!(out; ",\"index\":\"", Hex::<4>(u64::from(mux.index)), "\",\"sub\":", mux.sub),
        None => put!(out; ",\"index\":null,\"sub\":null"),
    }
    match moved {
        Some(moved) => put!(out; ",\"direction\":\"", moved.direction.name(), "\""),
        None => put!(out; ",\"direction\":null"),
    }
    put!(out; ",\"count\":", difference.count, ",\"text\":");
    quoted(out, |text| words::subject(text, setting.lang, difference));
    for (place, key) in [",\"a\":", ",\"b\":"].into_iter().enumerate() {
        put!(out; key);
        side(out, setting, difference, place);
    }
    for (near, key) in difference.beside.iter().zip([",\"a_near\":", ",\"b_near\":"]) {
        put!(out; key);
        number_or_null(out, near.map(|at| at.no));
    }
    put!(out; "}\n");
}

fn service(out: &mut Vec<u8>, service: Service) {
    match service {
        Service::Sync => put!(out; "\"sync\""),
        Service::Time => put!(out; "\"time\""),
        Service::ErrorControl => put!(out; "\"error_control\""),
        Service::Pdo(transmit, number) => put!(out; if transmit { "\"TPDO" } else { "\"RPDO" }, number, "\""),
        Service::Srdo(number, _) => put!(out; "\"SRDO", number, "\""),
    }
}

fn side(out: &mut Vec<u8>, setting: Setting<'_>, difference: &Difference, place: usize) {
    let Some(side) = difference.sides.get(place).and_then(Option::as_ref) else { return put!(out; "null") };
    let digest = setting.digests.get(place);
    let name = difference.bus.get(place).copied().flatten().zip(digest).map(|(bus, digest)| digest.buses.name(bus));
    put!(out; "{\"bus\":");
    name_or_null(out, name.unwrap_or_default());
    put!(out; ",\"frame\":");
    number_or_null(out, (side.since.no > 0).then_some(side.since.no));
    put!(out; ",\"line\":");
    number_or_null(out, side.since.line);
    put!(out; ",\"t\":");
    seconds(out, side.since.t_ns, digest.map_or(9, |digest| digest.decimals));
    put!(out; ",\"last_frame\":");
    number_or_null(out, (side.at.no > 0).then_some(side.at.no));
    put!(out; ",\"text\":");
    quoted(out, |text| words::side(text, setting.lang, difference.what, Some(side)));
    put!(out; ",\"value\":");
    value(out, setting, side);
    put!(out; "}");
}

fn value(out: &mut Vec<u8>, setting: Setting<'_>, side: &Side) {
    if let Some(ns) = side.pace_ns {
        return put!(out; "{\"period_us\":", ns / 1000, "}");
    }
    match &side.shows {
        Shows::Action(action) => action_value(out, action),
        Shows::Count(frames) => put!(out; "{\"frames\":", *frames, "}"),
        Shows::Time(ns) => put!(out; "{\"period_us\":", ns / 1000, "}"),
        Shows::Id(id) => identifier(out, *id),
        Shows::Mapping(words) => {
            put!(out; "{\"mapping\":[");
            for (place, word) in words.iter().enumerate() {
                put!(out; if place > 0 { ",\"" } else { "\"" }, Hex::<8>(u64::from(*word)), "\"");
            }
            put!(out; "]}");
        }
        Shows::Length(bytes) => put!(out; "{\"length\":", *bytes, "}"),
        Shows::Finding(finding) => {
            put!(out; "{\"code\":\"", finding.code.rule().id, "\",\"message\":");
            quoted(out, |text| findings::placed(text, setting.lang, finding, finding.at.no));
            put!(out; "}");
        }
    }
}

fn identifier(out: &mut Vec<u8>, id: CanId) {
    let raw = u64::from(id.raw());
    put!(out; "{\"id\":\"");
    if id.is_extended() {
        put!(out; Hex::<8>(raw));
    } else {
        put!(out; Hex::<3>(raw));
    }
    put!(out; "\"}");
}

fn action_value(out: &mut Vec<u8>, action: &Action) {
    let code = |out: &mut Vec<u8>, code: u8| put!(out; "{\"code\":\"", Hex::<2>(u64::from(code)), "\"}");
    match action {
        Action::Transfer(moved) => transfer(out, moved),
        Action::Nmt(command) => code(out, *command),
        Action::BootUp => code(out, 0),
        Action::State(state) => code(out, *state),
        Action::Drive(state) => match state {
            Some(state) => {
                put!(out; "{\"code\":\"", Hex::<4>(u64::from(state.coding().1)), "\"}");
            }
            None => put!(out; "{\"code\":null}"),
        },
        Action::Emcy(emcy, register) => {
            put!(out; "{\"code\":\"", Hex::<4>(u64::from(*emcy)), "\",\"register\":\"");
            put!(out; Hex::<2>(u64::from(*register)), "\"}");
        }
        Action::Lss(bytes) => put!(out; "{\"data\":\"", Joined(bytes), "\"}"),
    }
}

fn transfer(out: &mut Vec<u8>, moved: &TransferDigest) {
    put!(out; "{\"status\":\"", moved.status.name(), "\",\"mode\":\"", moved.mode.name(), "\",\"abort\":");
    match moved.abort {
        None => put!(out; "null"),
        Some(abort) => put!(out; "{\"code\":\"", Hex::<8>(u64::from(abort.code)), "\",\"by\":\"", match abort.by {
            Sender::Client => "client",
            Sender::Server => "server",
        }, "\"}"),
    }
    put!(out; ",\"size\":", moved.size, ",\"data\":\"", Joined(&moved.kept), "\"}");
}
