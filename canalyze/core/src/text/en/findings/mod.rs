//! Findings and notes in English, and what each rule means.
//!
//! It must carry the same facts as `zh::findings`; a rule without words does not compile.

mod bus;
mod capture;
mod description;
mod drive;
mod expectation;
mod lss;
mod nodes;
mod pdo;
mod srdo;
mod sync;

use crate::event::Note;
use crate::finding::{Code, CrcMatch, Facts, Finding, Severity};
use crate::services::sdo::wire::Side;
use crate::text::digits::{Hex, put};
use crate::text::{Lang, RuleText, escape, told, value};

/// The word for a severity.
pub fn severity(severity: Severity) -> &'static str {
    severity.name()
}

fn side(side: Side) -> &'static str {
    match side {
        Side::Client => "client",
        Side::Server => "server",
    }
}

/// Appends the frame that shows a finding, where the finding stands under another one's line.
pub fn place(out: &mut Vec<u8>, frame: Option<u64>, node: Option<u8>) {
    if let Some(frame) = frame {
        put!(out; "frame ", frame, if node.is_some() { " " } else { ": " });
    }
}

/// Appends what a finding says, in one sentence without line end.
pub fn message(out: &mut Vec<u8>, finding: &Finding) {
    if let Some(node) = finding.node {
        put!(out; "node ", node, " ");
    }
    if let Some(object) = finding.object.filter(|_| !matches!(finding.facts, Facts::Objects { .. })) {
        value::object(out, object);
        value::pdo_of(out, object);
        put!(out; " ");
    }
    if finding.node.is_some() {
        out.pop();
        put!(out; ": ");
    }
    if let Some(cause) = finding.cause {
        put!(out; "frame ", cause.no, ": ");
    }
    match finding.facts {
        Facts::None => put!(out; rule(finding.code).message),
        Facts::Lines { count } => put!(out; count, if count == 1 { " line" } else { " lines" }, " cannot be read"),
        Facts::Dropped { count, total } => {
            put!(out; count, if count == 1 { " frame" } else { " frames" }, " lost (", total, " in total)")
        }
        Facts::Toggle { expected, found, by } => {
            put!(out; "toggle=", u8::from(found), " from the ", side(by), ", ", u8::from(expected), " was due");
        }
        Facts::Missing { by: Side::Server } => put!(out; "request without response"),
        Facts::Missing { by: Side::Client } => put!(out; "response without request"),
        Facts::NotAcknowledged => put!(out; "sub-block not acknowledged"),
        Facts::Duplicate => put!(out; "duplicate response"),
        Facts::Objects { expected, found } => {
            put!(out; "asked for ");
            value::object(out, expected);
            put!(out; ", answered ");
            value::object(out, found);
        }
        Facts::Unused(n) => put!(out; rule(finding.code).message, " (n=", n, ")"),
        Facts::Size { indicated, transferred } => {
            value::size(out, Lang::En, indicated);
            put!(out; " indicated, ");
            value::size(out, Lang::En, transferred);
            put!(out; " transferred");
        }
        Facts::Outside => put!(out; "the frame belongs to no open transfer"),
        Facts::NoLast => put!(out; "all data were transferred, but no segment has the last-segment flag (c=1)"),
        Facts::Length(len) => put!(out; "SDO frame of ", len, " bytes instead of 8"),
        Facts::Sequence { expected, found } => put!(out; "block sequence number ", found, ", ", expected, " was due"),
        Facts::Acknowledged { ackseq, sent } => put!(out; "segment ", ackseq, " acknowledged, only ", sent, " sent"),
        Facts::NotResent { ackseq } => {
            put!(out; "segments up to ", ackseq, " acknowledged, and those after it not sent again");
        }
        Facts::BlockSize(size) => put!(out; "block size ", size, ", must be 1 to 127"),
        Facts::EarlyEnd => put!(out; "the block transfer ends before its last segment was acknowledged"),
        Facts::EndNotConfirmed => put!(out; "the end of the block transfer was not confirmed"),
        Facts::Crc { computed, found, matches } => {
            put!(out; "CRC ", Hex::<4>(u64::from(found)), "h, the data give ", Hex::<4>(u64::from(computed)), "h");
            put!(out; match matches {
                CrcMatch::Nothing => "",
                CrcMatch::WithPadding => " (matches only with the padding of the last segment)",
                CrcMatch::InitialFfff => " (matches only with the initial value FFFFh)",
                CrcMatch::Reflected => " (matches only the reflected variant)",
            });
        }
        Facts::Abort { code, by } => {
            put!(out; "aborted by the ", side(by), ": ");
            super::sdo::abort(out, code);
        }
        Facts::Command(command) => put!(out; "undefined command byte ", Hex::<2>(u64::from(command)), "h"),
        Facts::Frames { count } => {
            put!(out; rule(finding.code).message, " (", count, if count == 1 { " frame)" } else { " frames)" });
        }
        Facts::Told { face, measured } => match rule(finding.code).faces.get(usize::from(face)) {
            Some(sentence) => told::fill(out, Lang::En, sentence, &measured),
            None => put!(out; rule(finding.code).message),
        },
        Facts::Unmet(ref unmet) => {
            match rule(finding.code).faces.get(usize::from(unmet.face)).filter(|_| unmet.repeated == 0) {
                Some(sentence) => told::fill_said(out, Lang::En, sentence, &unmet.said),
                None => repeated(out, unmet.repeated),
            }
            put!(out; " (expected by ");
            escape::terminal(out, unmet.expectation.as_bytes());
            put!(out; ")");
        }
        Facts::Repeated { count } => repeated(out, count),
    }
}

fn repeated(out: &mut Vec<u8>, count: u64) {
    put!(out; count, " more of the same");
}

/// Appends a note of what has become known of an earlier frame.
pub fn note(out: &mut Vec<u8>, note: Note, about: u64) {
    match note {
        Note::RequestNotCaptured => put!(out; "the request that frame ", about, " answers is not in the capture"),
        Note::AnsweredByAbort => {
            put!(out; "the request in frame ", about, " was answered by the abort captured before it");
        }
        Note::LostByReset => {
            put!(out; "the SDO transfer that began in frame ", about, " was ended by a reset of the node");
        }
        Note::LssSelected { address } => lss::selected(out, address),
        Note::Fastscan(scanned) => lss::scanned(out, scanned, about),
        Note::BitTimingActivated { delay, rate } => lss::activated(out, delay, rate),
        Note::NodeIdChanged { from, to } => lss::changed(out, from, to, about),
    }
}

/// The words of a rule.
pub fn rule(code: Code) -> RuleText {
    let text = |message, meaning, cause| RuleText { message, meaning, cause, faces: &[] };
    match code {
        Code::Bus001 => bus::BUS001,
        Code::Bus002 => bus::BUS002,
        Code::Bus003 => bus::BUS003,
        Code::Bus004 => bus::BUS004,
        Code::Bus005 => bus::BUS005,
        Code::Bus006 => bus::BUS006,
        Code::Bus007 => bus::BUS007,
        Code::Bus008 => bus::BUS008,
        Code::Cap001 => text(
            "lines or records that cannot be read",
            "They are neither frames of the format that is read nor comments; all others are decoded all the same.",
            "The file was cut or edited, holds another program's output, or is of a format not supported yet.",
        ),
        Code::Cap002 => text(
            "frames lost by the capturing program",
            "The capturing program says itself that it lost frames. Across the gap no toggle bit, sequence number or answer is judged, and open transfers are incomplete.",
            "The receive buffer is too small, the host too busy or its disk too slow; candump takes a larger buffer with -r, dumpcap with -B, other programs in their settings.",
        ),
        Code::Cap003 => text(
            "time stamps go backwards",
            "The stamps of a pipe were taken as counted from zero, but one goes backwards: they are probably differences to the frame before.",
            "candump ran with -t d; add --stamps delta.",
        ),
        Code::Cap004 => capture::CAP004,
        Code::Cap005 => capture::CAP005,
        Code::Cap006 => capture::CAP006,
        Code::Drv001 => drive::DRV001,
        Code::Drv002 => drive::DRV002,
        Code::Drv003 => drive::DRV003,
        Code::Drv004 => drive::DRV004,
        Code::Drv005 => drive::DRV005,
        Code::Nmt001 => nodes::NMT001,
        Code::Nmt002 => nodes::NMT002,
        Code::Nmt003 => nodes::NMT003,
        Code::Nmt004 => nodes::NMT004,
        Code::Nmt005 => nodes::NMT005,
        Code::Hbt001 => nodes::HBT001,
        Code::Hbt002 => nodes::HBT002,
        Code::Hbt003 => nodes::HBT003,
        Code::Hbt004 => nodes::HBT004,
        Code::Hbt005 => nodes::HBT005,
        Code::Hbt006 => nodes::HBT006,
        Code::Grd001 => nodes::GRD001,
        Code::Grd002 => nodes::GRD002,
        Code::Grd003 => nodes::GRD003,
        Code::Grd004 => nodes::GRD004,
        Code::Emc001 => nodes::EMC001,
        Code::Emc002 => nodes::EMC002,
        Code::Emc003 => nodes::EMC003,
        Code::Emc004 => nodes::EMC004,
        Code::Emc005 => nodes::EMC005,
        Code::Emc006 => nodes::EMC006,
        Code::Emc007 => nodes::EMC007,
        Code::Emc008 => nodes::EMC008,
        Code::Emc009 => nodes::EMC009,
        Code::Emc010 => nodes::EMC010,
        Code::Exp001 => expectation::EXP001,
        Code::Exp002 => expectation::EXP002,
        Code::Exp003 => expectation::EXP003,
        Code::Exp004 => expectation::EXP004,
        Code::Exp005 => expectation::EXP005,
        Code::Exp006 => expectation::EXP006,
        Code::Exp007 => expectation::EXP007,
        Code::Exp008 => expectation::EXP008,
        Code::Exp009 => expectation::EXP009,
        Code::Exp010 => expectation::EXP010,
        Code::Exp011 => expectation::EXP011,
        Code::Exp012 => expectation::EXP012,
        Code::Exp013 => expectation::EXP013,
        Code::Exp014 => expectation::EXP014,
        Code::Exp015 => expectation::EXP015,
        Code::Exp016 => expectation::EXP016,
        Code::Tim001 => nodes::TIM001,
        Code::Tim002 => nodes::TIM002,
        Code::Eds001 => description::EDS001,
        Code::Eds002 => description::EDS002,
        Code::Eds003 => description::EDS003,
        Code::Eds004 => description::EDS004,
        Code::Mpd001 => pdo::MPD001,
        Code::Pdo001 => pdo::PDO001,
        Code::Pdo004 => pdo::PDO004,
        Code::Pdo005 => pdo::PDO005,
        Code::Pdo006 => pdo::PDO006,
        Code::Pdo008 => pdo::PDO008,
        Code::Pdo009 => pdo::PDO009,
        Code::Pdo010 => pdo::PDO010,
        Code::Pdo011 => pdo::PDO011,
        Code::Pdo012 => pdo::PDO012,
        Code::Pdo013 => pdo::PDO013,
        Code::Pdo014 => pdo::PDO014,
        Code::Pdo015 => pdo::PDO015,
        Code::Pdo016 => pdo::PDO016,
        Code::Pdo018 => pdo::PDO018,
        Code::Pdo019 => pdo::PDO019,
        Code::Lss001 => lss::LSS001,
        Code::Lss002 => lss::LSS002,
        Code::Lss003 => lss::LSS003,
        Code::Lss004 => lss::LSS004,
        Code::Lss005 => lss::LSS005,
        Code::Lss006 => lss::LSS006,
        Code::Lss007 => lss::LSS007,
        Code::Lss008 => lss::LSS008,
        Code::Lss009 => lss::LSS009,
        Code::Lss010 => lss::LSS010,
        Code::Lss011 => lss::LSS011,
        Code::Lss012 => lss::LSS012,
        Code::Lss030 => lss::LSS030,
        Code::Sdo001 => text(
            "toggle bit error",
            "The toggle bit of a segmented transfer is 0 in the first segment and then alternates; a response repeats the bit of its request.",
            "A fault of a stack, a segment repeated though it was accepted, or a frame missing from the capture.",
        ),
        Code::Sdo002 => text(
            "request and response do not pair",
            "SDO is question and answer: every request has a response, and there is no response without a request.",
            "The node is gone or too slow, two clients share one SDO channel, or a frame is missing from the capture.",
        ),
        Code::Sdo003 => text(
            "response names another object than the request",
            "An initiate response carries the index and sub-index of its request.",
            "A fault of the server, or two clients used the same SDO channel at once.",
        ),
        Code::Sdo004 => text(
            "invalid number of unused bytes n",
            "n has a meaning only where e and s are both 1; otherwise it shall be 0.",
            "A command byte put together by hand; some vendors' manuals leave out e and s.",
        ),
        Code::Sdo005 => text(
            "segment not full though not the last",
            "A segment that is not the last one has unused bytes. Stacks accept it, but it is rare.",
            "The sender cuts segments as its own buffers come.",
        ),
        Code::Sdo006 => text(
            "bytes transferred differ from the size indicated",
            "The size in the initiate frame equals the sum of the segments' data bytes.",
            "n of the last segment is wrong, a string's terminating zero was counted or not, or a segment is missing from the capture.",
        ),
        Code::Sdo007 => text(
            "segment outside a transfer, or a transfer without last segment",
            "The segment with c=1 ends a transfer: none may follow, and one must have it once all data are there.",
            "One side overlooks the last-segment flag, or does not set it.",
        ),
        Code::Sdo008 => text(
            "new transfer while one is open",
            "The client sent a new initiate request though its transfer was running, without an abort.",
            "The client starts anew after a time-out, or two clients share one SDO channel.",
        ),
        Code::Sdo009 => text(
            "reserved bits or unused bytes are not 0",
            "Reserved bits and bytes shall be 0; most stacks do not check.",
            "The sender does not clear its buffer.",
        ),
        Code::Sdo010 => text(
            "SDO frame is not 8 bytes long",
            "SDO frames always have 8 bytes; many servers drop shorter ones without a word.",
            "The sender sets the DLC to the length of its data.",
        ),
        Code::Sdo011 => nodes::SDO011,
        Code::Sdo012 => text(
            "sequence, acknowledgement or end of a block transfer",
            "Sequence numbers count from 1 in each sub-block; no more is acknowledged than was sent; the block size is 1 to 127; the end comes after the last segment was acknowledged, and is confirmed.",
            "A fault in one side's block transfer, or a segment missing from the capture.",
        ),
        Code::Sdo013 => description::SDO013,
        Code::Sdo014 => description::SDO014,
        Code::Sdo015 => text(
            "repeated request",
            "The same request was sent again without a response in between.",
            "The client repeats after a time-out, or the capture shows one frame twice.",
        ),
        Code::Sdo017 => text(
            "SDO transfer aborted",
            "One side ended the transfer with an abort; the abort code tells why.",
            "An object that does not exist, access rights, a wrong length, or a time-out: see the abort code.",
        ),
        Code::Sdo019 => text(
            "CRC of a block transfer is wrong",
            "Where both sides support a CRC, the end frame carries CRC-16/XMODEM over the data without padding.",
            "Another CRC variant, padding counted in, or corrupt data.",
        ),
        Code::Sdo020 => text(
            "late answer",
            "The server answered a request that its client had given up.",
            "The server is slow, or the client's time-out too short.",
        ),
        Code::Sdo021 => text(
            "write request with e=s=0 whose data are meant as expedited",
            "By the standard e=s=0 starts a segmented transfer of unknown size, but no segment follows: the data are in the initiate frame.",
            "A command byte put together as in Roboteq's manual (20h, 28h, 2Ch).",
        ),
        Code::Sdo022 => text(
            "read response with e=s=0 whose data are meant as expedited",
            "By the standard e=s=0 starts a segmented transfer of unknown size, but the client asks for no segment: the data are in the initiate response.",
            "A device that answers as in Roboteq's manual (40h, 48h, 4Ch).",
        ),
        Code::Sdo023 => text(
            "undefined SDO command",
            "The standard does not define this command specifier for this side.",
            "A fault of a stack, corrupt data, or something else than SDO on this COB-ID.",
        ),
        Code::Sdo030 => text(
            "traffic does not look like SDO",
            "No valid pair of request and response was seen on these COB-IDs, so they are not judged as SDO.",
            "The network is not CANopen, only one direction was captured, or another protocol uses the identifiers.",
        ),
        Code::Sdo031 => text(
            "requests never answered",
            "The capture has no SDO response of this node.",
            "The node does not exist or has no power (a master scans), or only one direction was captured.",
        ),
        Code::Srd001 => srdo::SRD001,
        Code::Srd002 => srdo::SRD002,
        Code::Srd003 => srdo::SRD003,
        Code::Srd004 => srdo::SRD004,
        Code::Srd005 => srdo::SRD005,
        Code::Pdo002 => nodes::PDO002,
        Code::Pdo003 => nodes::PDO003,
        Code::Syn001 => sync::SYN001,
        Code::Syn002 => sync::SYN002,
        Code::Syn003 => sync::SYN003,
        Code::Syn004 => sync::SYN004,
        Code::Syn005 => sync::SYN005,
        Code::Syn006 => sync::SYN006,
        Code::Syn007 => sync::SYN007,
        Code::Syn008 => sync::SYN008,
        Code::Syn009 => sync::SYN009,
        Code::Syn010 => sync::SYN010,
        Code::Syn011 => sync::SYN011,
        Code::Syn012 => sync::SYN012,
        Code::Syn013 => sync::SYN013,
    }
}
