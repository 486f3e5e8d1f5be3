//! LSS's findings and notes in English (CiA 305).
//!
//! It must carry the same facts as `zh::findings::lss`.

use crate::event::Scanned;
use crate::services::lss::Part;
use crate::text::digits::{Hex, put};
use crate::text::{Lang, RuleText, terms, told};

const EN: Lang = Lang::En;

pub(super) const LSS001: RuleText = RuleText {
    message: "undefined LSS frame",
    meaning: "LSS frames always have 8 bytes, the first is the command specifier; CiA 305 does not define this one for this side, or the length is wrong.",
    cause: "A fault of a stack, corrupt data, or something else than LSS on 7E4h and 7E5h.",
    faces: &[
        "undefined command specifier {command} from the master",
        "undefined command specifier {command} from a slave",
        "LSS frame of {length} bytes instead of 8",
    ],
};

pub(super) const LSS002: RuleText = RuleText {
    message: "LSS answer without request",
    meaning: "LSS slaves only answer the master's requests; the capture has no request of this kind before the answer or right after it.",
    cause: "A fault of the slave, or frames of the master missing from the capture.",
    faces: &["answer {command} has no request"],
};

pub(super) const LSS003: RuleText = RuleText {
    message: "configuration command while no slave is in the configuration state",
    meaning: "Only slaves in the configuration state follow configure and inquire commands; the master has switched all slaves to waiting and selected none since.",
    cause: "The master leaves out the switch of the state, or does not check that its selective switch was answered.",
    faces: &["{command} from the master, but no slave is in the configuration state"],
};

pub(super) const LSS004: RuleText = RuleText {
    message: "LSS slave answered with an error code",
    meaning: "The slave has not accepted the node-ID or the bit timing, or has not stored its configuration. Error code FFh is the manufacturer's own: see the device's manual.",
    cause: "A node-ID out of 1 to 127, a bit rate or storage that the slave does not support, or a storage fault.",
    faces: &[
        "{command} refused: error code {error}",
        "{command} refused: error code {error}, specific error code {specific}",
    ],
};

pub(super) const LSS005: RuleText = RuleText {
    message: "no boot-up with the new node-ID",
    meaning: "A slave without node-ID boots up with the new one as it returns to waiting; one that has a node-ID uses the new one after a reset of its communication, or as it restarts if it was stored.",
    cause: "The slave needs a power cycle, it was reset without having stored its configuration, or the boot-up is not in the capture.",
    faces: &[
        "no node has booted up with node-ID {node} within {limit}",
        "the node boots up with node-ID {found} still, {expected} was due",
    ],
};

pub(super) const LSS006: RuleText = RuleText {
    message: "bit timing configured, but neither activated nor stored",
    meaning: "A slave has accepted a bit timing and returned to waiting, but the master has neither activated it (15h) nor stored the configuration (17h): the bit rate stays as it is.",
    cause: "The master leaves out the activation or the storage.",
    faces: &[],
};

pub(super) const LSS007: RuleText = RuleText {
    message: "more than one slave answers",
    meaning: "Configure node-ID and inquire are for one slave in the configuration state; nothing in the answers tells the slaves apart.",
    cause: "All slaves were switched to configuration, the master selects the next slave without a switch to waiting, or two slaves have the same LSS address.",
    faces: &[
        "{command} was answered more than once: more than one slave is in the configuration state",
        "{command} more than once: more than one slave has this LSS address",
    ],
};

pub(super) const LSS008: RuleText = RuleText {
    message: "frame during the switch delay",
    meaning: "After the activation of a bit timing slaves change their bit rate one switch delay later and send nothing for another one; no node may send in that time.",
    cause: "The master does not wait, or nodes on the bus take no part in the change.",
    faces: &["a frame {elapsed} after the activation of the bit timing, the bus has to be silent for {silence}"],
};

pub(super) const LSS009: RuleText = RuleText {
    message: "selected slave does not answer",
    meaning: "A slave in the configuration state answers configure and inquire commands.",
    cause: "The slave does not support the command, was reset or disconnected, or is too slow.",
    faces: &[
        "the selected slave has not answered {command} within {limit}",
        "no answer to {command} before the master went on",
    ],
};

pub(super) const LSS010: RuleText = RuleText {
    message: "invalid Fastscan parameter",
    meaning: "BitCheck is 0 to 31 or 80h, LSSSub and LSSNext are 0 to 3; slaves ignore other values.",
    cause: "A fault in the master's Fastscan.",
    faces: &["invalid BitCheck {found}", "invalid LSSSub={sub} or LSSNext={next}"],
};

pub(super) const LSS011: RuleText = RuleText {
    message: "parts of a selective switch out of order",
    meaning: "The LSS address is sent as vendor-ID, product code, revision number, serial number (40h to 43h), in this order; a slave need not answer another one.",
    cause: "The master has left out or repeated one of the frames.",
    faces: &["{found} came, {expected} was due"],
};

pub(super) const LSS012: RuleText = RuleText {
    message: "no slave answers",
    meaning: "No slave has this LSS address, or after a global switch there is no LSS slave on the bus.",
    cause: "The slave does not exist or has no power (a master searches), or the LSS address is mistyped.",
    faces: &[
        "no slave answers to the LSS address vendor-ID={vendor}, product code={product}, revision number={revision}, serial number={serial}",
        "no slave has answered {command} within {limit}",
    ],
};

pub(super) const LSS030: RuleText = RuleText {
    message: "traffic on 7E4h and 7E5h does not look like LSS",
    meaning: "No valid pair of request and answer was seen, so these frames are not judged as LSS.",
    cause: "The network is not CANopen, only one direction was captured, or there is no LSS slave.",
    faces: &[],
};

/// A slave has entered the configuration state.
pub(super) fn selected(out: &mut Vec<u8>, address: [u32; 4]) {
    put!(out; "slave in configuration state: ");
    parts(out, address.map(Some));
}

/// A Fastscan is over.
pub(super) fn scanned(out: &mut Vec<u8>, scanned: Scanned, about: u64) {
    put!(out; "the Fastscan that began in frame ", about);
    if scanned.found {
        put!(out; " has found a slave: ");
        parts(out, scanned.address);
        if scanned.address.iter().any(Option::is_none) {
            put!(out; ", the rest is not in the capture");
        }
    } else {
        put!(out; " is incomplete");
        if scanned.address.iter().any(Option::is_some) {
            put!(out; ", confirmed: ");
            parts(out, scanned.address);
        }
    }
    put!(out; " (", scanned.frames, if scanned.frames == 1 { " request" } else { " requests" });
    if let Some(ns) = scanned.duration_ns {
        put!(out; " in ");
        told::duration(out, ns);
    }
    put!(out; ")");
}

/// Bit timing is activated.
pub(super) fn activated(out: &mut Vec<u8>, delay: u16, rate: Option<u16>) {
    put!(out; "the bus has to be silent for ", u32::from(delay) * 2, " ms, then ");
    if let Some(rate) = rate {
        put!(out; "the bit rate is ", rate, " kbit/s: ");
    } else {
        put!(out; "the bit rate is another one: ");
    }
    put!(out; "captured at the old one there are only errors, or nothing");
}

/// A node has another node-ID.
pub(super) fn changed(out: &mut Vec<u8>, from: u8, to: u8, about: u64) {
    put!(out; "the node-ID of node ", from, " is ", to, " now (accepted in frame ", about, ")");
}

fn parts(out: &mut Vec<u8>, address: [Option<u32>; 4]) {
    let mut between = "";
    for (number, value) in (0..).zip(address) {
        if let (Some(part), Some(value)) = (Part::from_number(number), value) {
            put!(out; between, terms::lss::part(EN, part), "=", Hex::<8>(u64::from(value)), "h");
            between = ", ";
        }
    }
}
