//! States, emergencies, SDO transfers and findings as messages.

use super::super::message::{Header, Octets, Time, message};
use super::{Decoded, MessagePlace};
use crate::bytes::frame::{Frame, FrameRef};
use crate::rules::finding::{Finding, Severity};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::transfer::Transfer;
use crate::wire::error_control::{self, BOOT_UP};
use crate::wire::message::Message;
use crate::words::digits::put;
use crate::words::{Depth, findings, services, terms, transferred, value};
use crate::world::change::Change;

/// Most bytes of a transfer that its message has.
const DATA: usize = 1024;

/// Returns the severity of a log line in ROS's numbers.
const fn level(severity: Severity) -> u8 {
    match severity {
        Severity::Info => 20,
        Severity::Warning => 30,
        Severity::Error => 40,
    }
}

/// Appends a state that a node reports, or another state of its drive.
pub(super) fn change(
    decoded: &mut Decoded,
    place: &mut MessagePlace<'_, '_>,
    bus: &str,
    at: FrameRef,
    change: &Change,
) {
    match *change {
        Change::BootUp { node } => nmt_state(decoded, place, bus, at, node, BOOT_UP),
        Change::State { node, state, .. } => nmt_state(decoded, place, bus, at, node, state),
        Change::Drive { node, axis, statusword, state, .. } if change.is_news() => {
            let name = state.map_or("", |state| terms::drive::state(decoded.lang, state));
            drive_state(decoded, place, bus, at, (node, axis), (statusword, name));
        }
        _ => {}
    }
}

/// Appends an emergency.
pub(super) fn message(
    decoded: &mut Decoded,
    place: &mut MessagePlace<'_, '_>,
    bus: &str,
    at: FrameRef,
    message: &Message,
    frame: &Frame,
) {
    let Message::Emcy { node, code, register, manufacturer, .. } = *message else { return };
    let mut words = std::mem::take(&mut decoded.words);
    words.clear();
    services::message(&mut words, decoded.lang, Depth::Default, message, frame);
    let topic = format!("/{bus}/node{node}/emcy");
    let report = message! { "canalyze_msgs/msg/Emergency" {
        header: Header(place.now, bus),
        code: code,
        error_register: register,
        manufacturer: manufacturer,
        text: &*words,
    }};
    decoded.send(place, &topic, (at, place.now), report);
    // 00xx says that an error has gone.
    let severity = if code & 0xFF00 == 0 { Severity::Info } else { Severity::Error };
    log(decoded, place, bus, Some(node), at, severity, &words);
    decoded.words = words;
}

fn nmt_state(decoded: &mut Decoded, place: &mut MessagePlace<'_, '_>, bus: &str, at: FrameRef, node: u8, state: u8) {
    let topic = format!("/{bus}/node{node}/nmt_state");
    let message = message! {
        /// As boot-up, heartbeat and guarding show it: 0 booted (pre-operational), 4 stopped, 5 operational, 127 pre-operational.
        "canalyze_msgs/msg/NmtState" {
            header: Header(place.now, bus),
            state: state,
            name: error_control::state(decoded.lang, state).unwrap_or(""),
        }
    };
    decoded.send(place, &topic, (at, place.now), message);
}

fn drive_state(
    decoded: &mut Decoded,
    place: &mut MessagePlace<'_, '_>,
    bus: &str,
    at: FrameRef,
    (node, axis): (u8, u8),
    (statusword, name): (u16, &str),
) {
    let mut topic = format!("/{bus}/node{node}/drive_state");
    if axis > 0 {
        topic.push_str(&format!("_{}", axis + 1));
    }
    let message = message! {
        /// The state of a CiA 402 power drive system, whenever a statusword in a PDO or an SDO shows another one.
        "canalyze_msgs/msg/DriveState" {
            header: Header(place.now, bus),
            statusword: statusword,
            state: name,
        }
    };
    decoded.send(place, &topic, (at, place.now), message);
}

/// Appends an SDO transfer.
pub(super) fn transfer(
    decoded: &mut Decoded,
    place: &mut MessagePlace<'_, '_>,
    bus: &str,
    at: FrameRef,
    transfer: &Transfer,
) {
    let lang = decoded.lang;
    let topic = format!("/{bus}/node{}/sdo", transfer.node);
    let time = place.moment(at);
    let mut name = Vec::new();
    if let Some(mux) = transfer.mux {
        value::name(&mut name, lang, mux, &transfer.described);
    }
    let (mut words, mut whole) = (Vec::new(), Vec::new());
    transferred::transferred(&mut words, lang, transfer);
    services::sdo::result(&mut whole, lang, transfer);
    let abort = transfer.outcome.abort.map(|abort| abort.code);
    let message = message! {
        /// An SDO transfer at its end. Without its initiate request in the capture index, sub and name are empty.
        "canalyze_msgs/msg/SdoTransfer" {
            header: Header(time, bus),
            /// Of its first frame; 0 without stamps.
            start: Time(place.stamped(transfer.first).unwrap_or(0)),
            /// In seconds; NaN without stamps.
            duration: transfer.duration_ns().map_or(f64::NAN, |ns| ns.as_ns() as f64 / 1e9),
            /// upload, download
            direction: transfer.direction.name(),
            /// expedited, segmented, block
            mode: transfer.mode.name(),
            index: transfer.mux.map_or(0, |mux| mux.index),
            sub: transfer.mux.map_or(0, |mux| mux.sub),
            // A blank is before the name.
            name: name.get(1..).unwrap_or(&[]),
            /// The value in words.
            value: &*words,
            /// Bytes transferred, and the first 1024 of them.
            size: transfer.data.size,
            data: Octets(transfer.data.kept.get(..DATA).unwrap_or(&transfer.data.kept)),
            /// ok, aborted, incomplete, failed
            status: transfer.outcome.status.name(),
            abort_code: abort.map_or(0, AbortCode::number),
            abort_text: abort.and_then(|code| terms::abort_code(lang, code)).unwrap_or(""),
            /// Numbers in the capture, from 1.
            first_frame: transfer.first.no,
            last_frame: transfer.last.no,
            /// All of it in words, on one line.
            text: &*whole,
        }
    };
    decoded.send(place, &topic, (at, time), message);
}

/// Appends a finding, as itself and as a line of the log.
pub(super) fn finding(decoded: &mut Decoded, place: &mut MessagePlace<'_, '_>, bus: &str, finding: &Finding) {
    let rule = finding.code.rule();
    let mut words = std::mem::take(&mut decoded.words);
    words.clear();
    findings::message(&mut words, decoded.lang, finding);
    let time = place.moment(finding.at);
    let number = |frame: Option<FrameRef>| frame.map_or(0, |frame| frame.no);
    let message = message! { "canalyze_msgs/msg/Finding" {
        header: Header(time, bus),
        code: rule.id,
        name: rule.name,
        /// info, warning, error
        severity: finding.severity().name(),
        message: &*words,
        /// 0 where none is concerned.
        node: finding.node.unwrap_or(0),
        /// The object; 0 where none is concerned.
        index: finding.object.map_or(0, |mux| mux.index),
        sub: finding.object.map_or(0, |mux| mux.sub),
        /// Numbers in the capture, from 1; 0 where there is none: the frame that shows it, and an earlier one that belongs to it.
        frame: finding.at.no,
        cause_frame: number(finding.cause),
        /// The one of the two that the message is about, and the frame of what explains it: then it is a consequence.
        about_frame: number(finding.about()),
        because_of: number(finding.because_of),
    }};
    decoded.send(place, "/findings", (finding.at, time), message);
    let mut line = Vec::new();
    put!(&mut line; rule.id, " ");
    findings::placed(&mut line, decoded.lang, finding, finding.at.no);
    log(decoded, place, bus, finding.node, finding.at, finding.severity(), &line);
    decoded.words = words;
}

/// Appends a line of the log.
fn log(
    decoded: &mut Decoded,
    place: &mut MessagePlace<'_, '_>,
    bus: &str,
    node: Option<u8>,
    at: FrameRef,
    severity: Severity,
    words: &[u8],
) {
    let time = place.moment(at);
    let mut name = bus.to_owned();
    if let Some(node) = node {
        name.push_str(&format!("/node{node}"));
    }
    let message = message! {
        "rcl_interfaces/msg/Log" "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\n" {
            stamp: Time(time),
            level: level(severity),
            name: &*name,
            msg: words,
            file: "",
            function: "",
            line: u32::try_from(at.line().unwrap_or(0)).unwrap_or(0),
        }
    };
    decoded.send(place, "/log", (at, time), message);
}
