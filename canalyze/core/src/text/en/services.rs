//! What one frame says by itself, in English, in CiA 301's terms.
//!
//! It must carry the same facts as `zh::services` and must not decide anything. No `format!`: these are the
//! lines of the hot path.

use crate::cob_id::Role;
use crate::frame::{Frame, Kind};
use crate::message::{Errors, Flaw, Message};
use crate::services::lss::{BIT_CHECK_ANY, Command, Part, Setting, UNCONFIGURED, bit_rate};
use crate::services::pdo::Multiplexed;
use crate::services::pdo::mapping::Mapping;
use crate::services::{error_frame, nmt, time, usdo};
use crate::text::digits::{Hex, Padded, Spaced, put};
use crate::text::{Depth, Lang, terms, value};

const EN: Lang = Lang::En;

/// Appends the phrase of a message, and at other depths than brief its content. No line end.
pub fn message(out: &mut Vec<u8>, depth: Depth, message: &Message, frame: &Frame) {
    let full = depth != Depth::Brief;
    match *message {
        Message::Pdo { transmit, number, node } => {
            pdo(out, transmit, number, node);
            if full {
                put!(out; ": ");
                bytes(out, frame.len);
            }
        }
        Message::Sync { counter } => {
            put!(out; "SYNC");
            if let (true, Some(counter)) = (full, counter) {
                put!(out; ": counter=", counter);
            }
        }
        Message::Heartbeat { node, state, toggle, guarding, previous } => {
            put!(out; if guarding { "node guarding answer of node " } else { "heartbeat of node " }, node);
            if full {
                error_control(out, state, guarding, toggle, previous);
            }
        }
        Message::BootUp { node } => put!(out; "boot-up of node ", node),
        Message::Emcy { node, code, register, manufacturer, cleared, .. } => {
            put!(out; "emergency of node ", node);
            if full {
                emcy(out, code, register, &manufacturer);
                errors_cleared(out, cleared);
            }
        }
        Message::Nmt { command, node } => node_control(out, full, command, node),
        Message::GuardingRequest { node } => {
            put!(out; "node guarding request of the NMT master to node ", node);
            if full && frame.len > 1 {
                put!(out; " (requested length ", frame.len, " bytes, expected 0 or 1)");
            }
        }
        Message::PdoRequest { transmit, number, node } => {
            put!(out; "remote request for ");
            pdo(out, transmit, number, node);
            if full {
                put!(out; ": requested length ");
                bytes(out, frame.len);
            }
        }
        Message::Mpdo { transmit, number, node, content } => {
            pdo(out, transmit, number, node);
            if full {
                put!(out; ": ");
                multiplexed(out, &content, None);
            }
        }
        Message::Time { ms, days, reserved } => {
            put!(out; "TIME");
            if full {
                time_of_day(out, ms, days, reserved);
            }
        }
        Message::Lss { from_master, command } => lss(out, full, from_master, command),
        Message::Srdo { number, inverted, valid } => {
            put!(out; if inverted { "inverted data of SRDO" } else { "normal data of SRDO" }, number);
            if full {
                put!(out; ": ");
                bytes(out, frame.len);
                put!(out; match valid {
                    Some(true) => ", the inverse of the normal data",
                    Some(false) => ", not the inverse of the normal data",
                    None => "",
                });
            }
        }
        Message::Gfc => put!(out; "global fail-safe command (GFC)"),
        Message::FlyingMaster { kind, master } => flying_master(out, full, kind, master),
        Message::Usdo { request, source, destination, command } => {
            put!(out; if request { "USDO request" } else { "USDO response" }, ", node ", source, " -> ");
            if destination == 0 {
                put!(out; "all nodes");
            } else {
                put!(out; "node ", destination);
            }
            if full {
                usdo_command(out, command, frame.payload());
            }
        }
        Message::ErrorFrame => errors(out, full, frame),
        Message::Foreign { role } => foreign(out, role),
        Message::Malformed { role, flaw } => malformed(out, full, role, flaw, frame),
    }
}

/// `TPDO1 of node 5`.
fn pdo(out: &mut Vec<u8>, transmit: bool, number: u16, node: u8) {
    put!(out; if transmit { "TPDO" } else { "RPDO" }, number, " of node ", node);
}

/// `1 byte`, `8 bytes`.
fn bytes(out: &mut Vec<u8>, count: u8) {
    put!(out; count, if count == 1 { " byte" } else { " bytes" });
}

fn error_control(out: &mut Vec<u8>, state: u8, guarding: bool, toggle: bool, previous: Option<u8>) {
    match terms::nmt::state(EN, state) {
        Some(word) => put!(out; ": ", word),
        None => put!(out; ": unknown state ", Hex::<2>(u64::from(state)), "h"),
    }
    if guarding {
        put!(out; " (toggle=", u8::from(toggle), ")");
    }
    if let Some(before) = previous.filter(|before| *before != state).and_then(|before| terms::nmt::state(EN, before)) {
        put!(out; " (before: ", before, ")");
    }
}

fn node_control(out: &mut Vec<u8>, full: bool, command: u8, node: u8) {
    match terms::nmt::command(EN, command) {
        Some(word) => put!(out; "NMT ", word, ": "),
        None => put!(out; "NMT unknown command ", Hex::<2>(u64::from(command)), "h: "),
    }
    match node {
        0 => put!(out; "all nodes"),
        1..=127 => put!(out; "node ", node),
        _ => put!(out; "invalid node-ID ", node),
    }
    if full {
        put!(out; match command {
            nmt::START => " (to Operational)",
            nmt::STOP => " (to Stopped)",
            nmt::PRE_OPERATIONAL => " (PDO off)",
            nmt::RESET_NODE => " (resets the application, to Initialisation)",
            nmt::RESET_COMMUNICATION => " (to Initialisation)",
            _ => "",
        });
    }
}

fn emcy(out: &mut Vec<u8>, code: u16, register: u8, manufacturer: &[u8; 5]) {
    put!(out; ": ", Hex::<4>(u64::from(code)), "h ", terms::emcy::code(EN, code).unwrap_or("unknown error code"));
    put!(out; ", error register=", Hex::<2>(u64::from(register)), "h");
    register_bits(out, register);
    put!(out; ", manufacturer bytes ", Spaced(manufacturer));
}

/// Which errors a reset takes back.
fn errors_cleared(out: &mut Vec<u8>, cleared: Errors) {
    let mut between = ", clears ";
    for code in cleared.iter() {
        put!(out; between, Hex::<4>(u64::from(code)), "h");
        between = ", ";
    }
}

fn register_bits(out: &mut Vec<u8>, register: u8) {
    let mut between = " (";
    for bit in (0..8).filter(|bit| register & 1 << bit != 0) {
        put!(out; between, terms::emcy::register_bit(EN, bit).unwrap_or_default());
        between = ", ";
    }
    if register != 0 {
        put!(out; ")");
    }
}

/// What a multiplex PDO carries: `DAM-MPDO, write to node 10: 2000h:01 = 2A 00 00 00`, as far as
/// `mapping` knows the object with its name and value.
pub fn multiplexed(out: &mut Vec<u8>, content: &Multiplexed, mapping: Option<&Mapping>) {
    if content.destination {
        put!(out; "DAM-MPDO, write to ");
        if content.node == 0 {
            put!(out; "all nodes");
        } else {
            put!(out; "node ", content.node);
        }
    } else if content.node == 0 {
        put!(out; "SAM-MPDO, invalid producer node-ID 0");
    } else {
        put!(out; "SAM-MPDO, producer node ", content.node);
    }
    put!(out; ": ");
    value::multiplexed(out, EN, content, mapping);
}

fn time_of_day(out: &mut Vec<u8>, ms: u32, days: u16, reserved: u8) {
    let (year, month, day) = time::date(days);
    put!(out; ": ", year, "-", Padded::<2>(u64::from(month)), "-", Padded::<2>(u64::from(day)), " ");
    clock(out, ms);
    put!(out; " (", ms, " ms, day ", days, ")");
    if ms >= time::DAY_MS {
        put!(out; ", beyond a day");
    }
    if reserved != 0 {
        put!(out; ", reserved bits are not 0 (", Hex::<1>(u64::from(reserved)), "h)");
    }
}

fn clock(out: &mut Vec<u8>, ms: u32) {
    let (hour, minute, second, ms) = time::clock(ms);
    put!(out; Padded::<2>(u64::from(hour)), ":", Padded::<2>(u64::from(minute)), ":");
    put!(out; Padded::<2>(u64::from(second)), ".", Padded::<3>(u64::from(ms)));
}

fn lss(out: &mut Vec<u8>, full: bool, from_master: bool, command: Command) {
    put!(out; if from_master { "LSS master: " } else { "LSS slave: " });
    match command {
        Command::SwitchGlobal { .. } => put!(out; "switch state global"),
        Command::SwitchSelective { part, .. } => put!(out; "switch state selective, ", terms::lss::part(EN, part)),
        Command::SwitchSelectiveResponse => put!(out; "switch state selective response (in configuration state)"),
        Command::ConfigureNodeId { .. } => put!(out; "configure node-ID"),
        Command::ConfigureBitTiming { .. } => put!(out; "configure bit timing"),
        Command::Store => put!(out; "store configuration"),
        Command::Confirmation { of, .. } => put!(out; terms::lss::setting(EN, of), " response"),
        Command::ActivateBitTiming { .. } => put!(out; "activate bit timing"),
        Command::Identify { bound, .. } => put!(out; "identify remote slave, ", terms::lss::bound(EN, bound)),
        Command::IdentifyNonConfigured => put!(out; "identify non-configured remote slave"),
        Command::IdentifySlave => put!(out; "identify slave"),
        Command::IdentifyNonConfiguredSlave => put!(out; "identify non-configured slave"),
        Command::Fastscan { .. } => put!(out; "Fastscan"),
        Command::Inquire { part } => put!(out; "inquire ", terms::lss::part(EN, part)),
        Command::InquireResponse { part, .. } => put!(out; "inquire response, ", terms::lss::part(EN, part)),
        Command::InquireNodeId => put!(out; "inquire node-ID"),
        Command::InquireNodeIdResponse { .. } => put!(out; "inquire response, node-ID"),
        Command::Unknown(cs) => put!(out; "unknown command specifier ", Hex::<2>(u64::from(cs)), "h"),
    }
    if full {
        lss_content(out, command);
    }
}

fn lss_content(out: &mut Vec<u8>, command: Command) {
    match command {
        Command::SwitchGlobal { mode: 0 } => put!(out; ": waiting state"),
        Command::SwitchGlobal { mode: 1 } => put!(out; ": configuration state"),
        Command::SwitchGlobal { mode } => put!(out; ": reserved mode ", Hex::<2>(u64::from(mode)), "h"),
        Command::SwitchSelective { value, .. }
        | Command::Identify { value, .. }
        | Command::InquireResponse { value, .. } => {
            put!(out; " = ", Hex::<8>(u64::from(value)), "h");
        }
        Command::ConfigureNodeId { node } | Command::InquireNodeIdResponse { node } => match node {
            1..=127 => put!(out; " = ", node),
            UNCONFIGURED => put!(out; " = FFh (unconfigured)"),
            _ => put!(out; " = ", node, " (invalid)"),
        },
        Command::ConfigureBitTiming { selector, index } => bit_timing(out, selector, index),
        Command::Confirmation { of, error, specific } => confirmation(out, of, error, specific),
        Command::ActivateBitTiming { delay } => put!(out; ": switch delay=", delay, " ms"),
        Command::Fastscan { id_number, bit_check, sub, next } => fastscan(out, id_number, bit_check, sub, next),
        Command::SwitchSelectiveResponse
        | Command::Store
        | Command::IdentifyNonConfigured
        | Command::IdentifySlave
        | Command::IdentifyNonConfiguredSlave
        | Command::Inquire { .. }
        | Command::InquireNodeId
        | Command::Unknown(_) => {}
    }
}

fn bit_timing(out: &mut Vec<u8>, selector: u8, index: u8) {
    put!(out; ": ");
    if selector != 0 {
        put!(out; if selector < 128 { "reserved bit timing table" } else { "manufacturer-specific bit timing table" });
    } else if let Some(rate) = bit_rate(index) {
        put!(out; "bit rate ", rate, " kbit/s");
    } else if index == 9 {
        put!(out; "automatic bit rate detection");
    } else {
        put!(out; "reserved bit rate");
    }
    put!(out; " (table=", selector, ", index=", index, ")");
}

fn confirmation(out: &mut Vec<u8>, of: Setting, error: u8, specific: u8) {
    put!(out; ": ", terms::lss::error(EN, of, error).unwrap_or("reserved error code"));
    if error != 0 {
        put!(out; " (error code ", Hex::<2>(u64::from(error)), "h");
        if error == 0xFF {
            put!(out; ", specific error code ", Hex::<2>(u64::from(specific)), "h");
        }
        put!(out; ")");
    }
}

fn fastscan(out: &mut Vec<u8>, id_number: u32, bit_check: u8, sub: u8, next: u8) {
    match bit_check {
        BIT_CHECK_ANY => put!(out; ": is there any non-configured slave?"),
        32.. => put!(out; ": invalid BitCheck"),
        _ => {
            put!(out; ": ");
            address_part(out, sub);
            put!(out; ", compare bits 31-", bit_check);
            if sub != next && bit_check == 0 {
                put!(out; ", confirm and go on to ");
                address_part(out, next);
            }
        }
    }
    put!(out; " (IDNumber=", Hex::<8>(u64::from(id_number)), "h, BitCheck=", Hex::<2>(u64::from(bit_check)));
    put!(out; "h, LSSSub=", sub, ", LSSNext=", next, ")");
}

fn address_part(out: &mut Vec<u8>, number: u8) {
    match Part::from_number(number) {
        Some(part) => put!(out; terms::lss::part(EN, part)),
        None => put!(out; "invalid part of the LSS address"),
    }
}

fn flying_master(out: &mut Vec<u8>, full: bool, kind: u8, master: Option<(u8, u8)>) {
    put!(out; "flying master: ", match kind {
        1 => "answer of the active NMT master",
        2 => "negotiation request",
        3 => "request for the active NMT master",
        4 => "a device capable of NMT master is present",
        5 => "request for devices capable of NMT master",
        6 => "force negotiation",
        _ => "unknown message",
    });
    if let (true, Some((priority, node))) = (full, master) {
        put!(out; ": node ", node, ", priority=", priority);
    }
}

fn usdo_command(out: &mut Vec<u8>, command: u8, payload: &[u8]) {
    match terms::usdo::command(EN, command) {
        Some(word) => put!(out; ": ", word),
        None => put!(out; ": unknown command specifier ", Hex::<2>(u64::from(command)), "h"),
    }
    if command & 0x80 != 0 {
        put!(out; " (remote network)");
    }
    if let Some(session) = payload.get(2) {
        put!(out; ", session=", *session);
    }
    let Some(object) = usdo::object(payload) else {
        return;
    };
    put!(out; ", ", Hex::<4>(u64::from(object.index)), "h:", Hex::<2>(u64::from(object.sub)));
    if let Some(code) = object.abort {
        put!(out; ", abort code ", Hex::<2>(u64::from(code)), "h ");
        put!(out; terms::usdo::abort(EN, code).unwrap_or("unknown"));
    }
    if let Some(data_type) = object.data_type {
        match crate::od::DataType::from_code(u16::from(data_type)) {
            Some(known) => put!(out; ", type ", known.name()),
            None => put!(out; ", type ", Hex::<2>(u64::from(data_type)), "h"),
        }
    }
    if let Some(size) = object.size {
        put!(out; ", ");
        bytes(out, size);
        if !object.data.is_empty() {
            put!(out; ": ", Spaced(object.data));
        }
    }
}

fn errors(out: &mut Vec<u8>, full: bool, frame: &Frame) {
    put!(out; "error frame");
    let mut between = ": ";
    for class in error_frame::classes(frame).filter(|class| full && *class != error_frame::COUNTERS) {
        put!(out; between);
        between = ", ";
        match terms::find(terms::error_frame::CLASSES, EN, class) {
            Some(word) => put!(out; word),
            None => put!(out; "unknown class ", Hex::<8>(u64::from(class)), "h"),
        }
        error_details(out, class, &frame.head());
    }
    if let (true, Some((tx, rx))) = (full, error_frame::counters(frame)) {
        put!(out; between, "TX error counter=", tx, ", RX error counter=", rx);
    }
}

fn error_details(out: &mut Vec<u8>, class: u32, head: &[u8; 8]) {
    let [bit, controller, protocol, location, transceiver, ..] = *head;
    match class {
        error_frame::LOST_ARBITRATION if bit == 0 => put!(out; " (position unspecified)"),
        error_frame::LOST_ARBITRATION => put!(out; " (bit ", bit, ")"),
        error_frame::CONTROLLER => bits(out, terms::error_frame::CONTROLLER, controller),
        error_frame::PROTOCOL => {
            bits(out, terms::error_frame::PROTOCOL, protocol);
            match terms::find(terms::error_frame::LOCATION, EN, location) {
                Some(word) => put!(out; ", location: ", word),
                None if location == 0 => put!(out; ", location unspecified"),
                None => put!(out; ", location: unknown ", Hex::<2>(u64::from(location)), "h"),
            }
        }
        error_frame::TRANSCEIVER => wires(out, transceiver),
        _ => {}
    }
}

fn bits(out: &mut Vec<u8>, rows: &'static [terms::Row<u8>], byte: u8) {
    let mut between = " (";
    for bit in (0..8).map(|bit| 1 << bit).filter(|bit| byte & bit != 0) {
        match terms::find(rows, EN, bit) {
            Some(word) => put!(out; between, word),
            None => put!(out; between, "unknown ", Hex::<2>(u64::from(bit)), "h"),
        }
        between = ", ";
    }
    put!(out; if byte == 0 { " (unspecified)" } else { ")" });
}

fn wires(out: &mut Vec<u8>, status: u8) {
    let mut between = " (";
    for wire in [status & 0x0F, status & 0xF0].into_iter().filter(|wire| *wire != 0) {
        match terms::find(terms::error_frame::TRANSCEIVER, EN, wire) {
            Some(word) => put!(out; between, word),
            None => put!(out; between, "unknown ", Hex::<2>(u64::from(wire)), "h"),
        }
        between = ", ";
    }
    put!(out; if status == 0 { " (unspecified)" } else { ")" });
}

fn foreign(out: &mut Vec<u8>, role: Role) {
    put!(out; match role {
        Role::DynamicSdo => "ID reserved by CiA 302 (dynamic SDO)",
        Role::Reserved => "ID reserved by CiA 301",
        Role::Foreign => "29-bit ID, not pre-defined in CANopen",
        _ => "ID outside the pre-defined connection set",
    });
}

/// What an identifier stands for, as a noun: `emergency of node 10`.
pub fn role(out: &mut Vec<u8>, role: Role) {
    match role {
        Role::Nmt => put!(out; "NMT node control"),
        Role::Gfc => put!(out; "global fail-safe command (GFC)"),
        Role::FlyingMaster(_) => put!(out; "flying master"),
        Role::Sync => put!(out; "SYNC"),
        Role::Emcy(node) => put!(out; "emergency of node ", node),
        Role::Time => put!(out; "TIME"),
        Role::Srdo { number, inverted } => {
            put!(out; if inverted { "inverted data of SRDO" } else { "normal data of SRDO" }, number);
        }
        Role::Tpdo { number, node } => pdo(out, true, number, node),
        Role::Rpdo { number, node } => pdo(out, false, number, node),
        Role::SdoResponse(node) => put!(out; "SDO response of node ", node),
        Role::SdoRequest(node) => put!(out; "SDO request to node ", node),
        Role::ErrorControl(node) => put!(out; "error control of node ", node),
        Role::LssRequest => put!(out; "LSS master"),
        Role::LssResponse => put!(out; "LSS slave"),
        Role::DynamicSdo | Role::Reserved | Role::Unassigned | Role::Foreign => foreign(out, role),
    }
}

fn malformed(out: &mut Vec<u8>, full: bool, of: Role, flaw: Flaw, frame: &Frame) {
    put!(out; "malformed (");
    role(out, of);
    put!(out; ")");
    if !full {
        return;
    }
    match flaw {
        Flaw::Length { least, most } => {
            put!(out; ": length ");
            bytes(out, frame.len);
            put!(out; ", expected ");
            if most == least.saturating_add(1) {
                put!(out; least, " or ");
            } else if most != least {
                put!(out; least, " to ");
            }
            bytes(out, most);
            if matches!(of, Role::Emcy(_)) && frame.len == 0 && frame.kind == Kind::Data {
                put!(out; " (may be the boot-up message of DS 301 V3)");
            }
        }
        Flaw::Remote => {
            put!(out; ": this service has no remote frames (requested length ");
            bytes(out, frame.len);
            put!(out; ")");
        }
        Flaw::Fd => {
            put!(out; ": this service has no CAN FD frames (");
            bytes(out, frame.len);
            put!(out; ")");
        }
    }
}
