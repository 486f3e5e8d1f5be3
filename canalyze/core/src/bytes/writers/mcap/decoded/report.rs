//! States, emergencies, SDO transfers and findings as messages.

use super::super::definitions;
use super::{Decoded, Place};
use crate::bytes::frame::{Frame, FrameRef};
use crate::rules::finding::{Finding, Severity};
use crate::sdo::transfer::Transfer;
use crate::wire::error_control;
use crate::wire::message::Message;
use crate::words::digits::put;
use crate::words::{Depth, findings, services, terms, transferred, value};
use crate::world::drive::State;
use crate::world::event::Event;

/// Most bytes of a transfer that its message has.
const DATA: usize = 1024;

/// How bad a line of the log is, in ROS's numbers.
const fn level(severity: Severity) -> u8 {
    match severity {
        Severity::Info => 20,
        Severity::Warning => 30,
        Severity::Error => 40,
    }
}

/// Appends what a frame of an error-control or an emergency service says.
pub(super) fn message(
    decoded: &mut Decoded,
    place: &mut Place<'_, '_>,
    bus: &str,
    at: FrameRef,
    message: &Message,
    frame: &Frame,
) {
    match *message {
        Message::BootUp { node } => nmt_state(decoded, place, bus, at, node, 0),
        Message::Heartbeat { node, state, .. } => nmt_state(decoded, place, bus, at, node, state),
        Message::Emcy { node, code, register, manufacturer, .. } => {
            let mut words = std::mem::take(&mut decoded.words);
            words.clear();
            services::message(&mut words, decoded.lang, Depth::Default, message, frame);
            if let Some(channel) = decoded.channel(place, &format!("/{bus}/node{node}/emcy"), definitions::EMERGENCY) {
                let time = place.now;
                place.cdr.begin().header(time, bus.as_bytes()).u16(code).u8(register).array(&manufacturer);
                place.cdr.string(&words);
                place.send(channel, at, time);
            }
            // 00xx says that an error has gone.
            let severity = if code & 0xFF00 == 0 { Severity::Info } else { Severity::Error };
            log(decoded, place, bus, Some(node), at, severity, &words);
            decoded.words = words;
        }
        _ => {}
    }
}

fn nmt_state(decoded: &mut Decoded, place: &mut Place<'_, '_>, bus: &str, at: FrameRef, node: u8, state: u8) {
    let topic = format!("/{bus}/node{node}/nmt_state");
    let Some(channel) = decoded.channel(place, &topic, definitions::NMT_STATE) else { return };
    let time = place.now;
    let name = error_control::state(decoded.lang, state).unwrap_or("");
    place.cdr.begin().header(time, bus.as_bytes()).u8(state).string(name.as_bytes());
    place.send(channel, at, time);
}

/// Appends the state of a drive, where it is another one than before.
pub(super) fn drive_state(
    decoded: &mut Decoded,
    place: &mut Place<'_, '_>,
    bus: &str,
    event: &Event,
    node: u8,
    axis: u8,
    statusword: u16,
) {
    let state = State::of(statusword);
    if decoded.drives.insert((event.bus, node, axis), state) == Some(state) {
        return;
    }
    let mut topic = format!("/{bus}/node{node}/drive_state");
    if axis > 0 {
        topic.push_str(&format!("_{}", axis + 1));
    }
    let Some(channel) = decoded.channel(place, &topic, definitions::DRIVE_STATE) else { return };
    let time = place.now;
    let name = state.map_or("", |state| terms::drive::state(decoded.lang, state));
    place.cdr.begin().header(time, bus.as_bytes()).u16(statusword).string(name.as_bytes());
    place.send(channel, event.at, time);
}

/// Appends an SDO transfer.
pub(super) fn transfer(decoded: &mut Decoded, place: &mut Place<'_, '_>, bus: &str, at: FrameRef, transfer: &Transfer) {
    let lang = decoded.lang;
    let topic = format!("/{bus}/node{}/sdo", transfer.node);
    let Some(channel) = decoded.channel(place, &topic, definitions::SDO_TRANSFER) else { return };
    let time = place.moment(at);
    let start = place.stamped(transfer.first).unwrap_or(0);
    let duration = transfer.duration_ns().map_or(f64::NAN, |ns| ns as f64 / 1e9);
    let mut name = Vec::new();
    if let Some(mux) = transfer.mux {
        value::name(&mut name, lang, mux, &transfer.described);
    }
    // A blank stands before the name.
    let name = name.get(1..).unwrap_or(&[]);
    let mut words = std::mem::take(&mut decoded.words);
    words.clear();
    transferred::transferred(&mut words, lang, transfer);
    let abort = transfer.outcome.abort.map(|abort| abort.code);
    let abort_words = abort.and_then(|code| terms::abort_code(lang, code)).unwrap_or("");
    let cdr = place.cdr.begin().header(time, bus.as_bytes()).time(start).f64(duration);
    cdr.string(transfer.direction.name().as_bytes()).string(transfer.mode.name().as_bytes());
    cdr.u16(transfer.mux.map_or(0, |mux| mux.index)).u8(transfer.mux.map_or(0, |mux| mux.sub));
    cdr.string(name).string(&words).u64(transfer.data.size);
    cdr.sequence(transfer.data.kept.get(..DATA).unwrap_or(&transfer.data.kept));
    cdr.string(transfer.outcome.status.name().as_bytes()).u32(abort.unwrap_or(0)).string(abort_words.as_bytes());
    cdr.u64(transfer.first.no).u64(transfer.last.no);
    words.clear();
    services::sdo::result(&mut words, lang, transfer);
    cdr.string(&words);
    place.send(channel, at, time);
    decoded.words = words;
}

/// Appends a finding, as itself and as a line of the log.
pub(super) fn finding(decoded: &mut Decoded, place: &mut Place<'_, '_>, bus: &str, finding: &Finding) {
    let rule = finding.code.rule();
    let mut words = std::mem::take(&mut decoded.words);
    words.clear();
    findings::message(&mut words, decoded.lang, finding);
    if let Some(channel) = decoded.channel(place, "/findings", definitions::FINDING) {
        let time = place.moment(finding.at);
        let cdr = place.cdr.begin().header(time, bus.as_bytes());
        cdr.string(rule.id.as_bytes()).string(rule.name.as_bytes()).string(finding.severity().name().as_bytes());
        cdr.string(&words).u8(finding.node.unwrap_or(0));
        cdr.u16(finding.object.map_or(0, |mux| mux.index)).u8(finding.object.map_or(0, |mux| mux.sub));
        let number = |frame: Option<FrameRef>| frame.map_or(0, |frame| frame.no);
        cdr.u64(finding.at.no).u64(number(finding.cause));
        cdr.u64(number(finding.about())).u64(number(finding.because_of));
        place.send(channel, finding.at, time);
    }
    let mut line = Vec::new();
    put!(&mut line; rule.id, " ");
    findings::placed(&mut line, decoded.lang, finding, finding.at.no);
    log(decoded, place, bus, finding.node, finding.at, finding.severity(), &line);
    decoded.words = words;
}

/// Appends a line of the log.
fn log(
    decoded: &mut Decoded,
    place: &mut Place<'_, '_>,
    bus: &str,
    node: Option<u8>,
    at: FrameRef,
    severity: Severity,
    words: &[u8],
) {
    let Some(channel) = decoded.channel(place, "/log", definitions::LOG) else { return };
    let time = place.moment(at);
    let mut name = bus.to_owned();
    if let Some(node) = node {
        name.push_str(&format!("/node{node}"));
    }
    let line = u32::try_from(at.line.unwrap_or(0)).unwrap_or(0);
    let cdr = place.cdr.begin().time(time).u8(level(severity)).string(name.as_bytes()).string(words);
    cdr.string(b"").string(b"").u32(line);
    place.send(channel, at, time);
}
