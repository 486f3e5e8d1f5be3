//! Rules of nodes in English: NMT, heartbeats, guarding, emergencies, TIME, and what a state permits.
//!
//! It must carry the same facts as `zh::findings::nodes`.

use crate::text::RuleText;

pub(super) const NMT001: RuleText = RuleText {
    message: "invalid NMT command",
    meaning: "CiA 301 defines the commands 01h, 02h, 80h, 81h and 82h, node-IDs 0 (all) to 127, and a length of 2 bytes; nodes ignore anything else.",
    cause: "A command put together wrongly by the master, or another protocol on CAN-ID 000.",
    faces: &[
        "unknown NMT command {found}",
        "NMT command to node-ID {found}, which should be 0 to 127",
        "length of the NMT command {found}, which should be 2 bytes",
    ],
};

pub(super) const NMT002: RuleText = RuleText {
    message: "NMT command without effect",
    meaning: "A node enters the state it is commanded to; two heartbeat periods later it still reports another one.",
    cause: "The node refuses to start (an error, or an incomplete configuration), or did not receive the command.",
    faces: &[
        "after the command \"{command}\" the node is still {found}",
        "after the command \"{command}\" the node has sent no boot-up and is still {found}",
    ],
};

pub(super) const NMT003: RuleText = RuleText {
    message: "spontaneous reset",
    meaning: "A boot-up that no reset command precedes, nor anything else that explains it.",
    cause: "A watchdog, a dip of the supply, a crash of the firmware, or somebody has switched the node off and on.",
    faces: &[
        "boot-up without a reset command, {after} after the last boot-up",
        "boot-up without a reset command",
        "the node was running (last heartbeat {after} before) and booted without a reset command",
    ],
};

pub(super) const NMT004: RuleText = RuleText {
    message: "change of state without command",
    meaning: "The node reports another NMT state though no command changed it, and no emergency explains it.",
    cause: "Error behaviour (1029h) or local operation of the node, two nodes with one node-ID, or a command that is not in the capture.",
    faces: &["from {from} to {to} without a command"],
};

pub(super) const NMT005: RuleText = RuleText {
    message: "change of state on an error",
    meaning: "The node left Operational, or stopped, without a command and sent an emergency: the error behaviour of 1029h. It stays there; no error starts a node.",
    cause: "A communication error, such as the loss of a heartbeat that the node watches.",
    faces: &["from {from} to {to} without a command, along with an emergency of the node"],
};

pub(super) const HBT001: RuleText = RuleText {
    message: "heartbeat late",
    meaning: "Two heartbeats are clearly further apart than the period, which is known from 1017h or the heartbeats before. Additional heartbeats are legal.",
    cause: "A busy node, high bus load, or a missing frame.",
    faces: &["{found} after the last heartbeat, the period is {expected}"],
};

pub(super) const HBT002: RuleText = RuleText {
    message: "heartbeat lost",
    meaning: "No heartbeat within the consumer heartbeat time (1016h) or, where none is known, within three periods and a tolerance. It is said once.",
    cause: "The node is gone, off or hung, a cable is open, or its controller is in bus-off.",
    faces: &[
        "no heartbeat for {silence} after it, the consumer heartbeat time is {limit}",
        "no heartbeat for {silence} after it, the limit is {limit}",
    ],
};

pub(super) const HBT003: RuleText = RuleText {
    message: "unknown NMT state",
    meaning: "Error control carries the state 00h, 04h, 05h or 7Fh; bit 7 of a heartbeat is 0.",
    cause: "A fault of the firmware, corrupt data, or another protocol on this CAN-ID.",
    faces: &["the state is {found}", "bit 7 of a heartbeat is 1 ({found}), and nobody has sent a guarding request"],
};

pub(super) const HBT004: RuleText = RuleText {
    message: "duplicate node-ID",
    meaning: "Two series of heartbeats are interleaved on one node-ID, or two boot-ups follow one reset: two nodes use the same node-ID.",
    cause: "Equal DIP switches, or a new device with the default node-ID.",
    faces: &[
        "the state alternates between {one} and {other} without commands",
        "gaps between heartbeats alternate between {one} and {other}: two series",
        "gaps between heartbeats are {found}, half of the {expected} of 1017h",
        "two boot-ups within {gap}",
    ],
};

pub(super) const HBT005: RuleText = RuleText {
    message: "silent bus",
    meaning: "There was no frame at all, so no node counts as lost for that; who does not come back afterwards does.",
    cause: "The recording paused or the host stalled, the bus was open, or the network had no power.",
    faces: &["the bus was silent for {silence}; nodes whose heartbeat was due: {nodes}"],
};

pub(super) const GRD001: RuleText = RuleText {
    message: "toggle bit of node guarding",
    meaning: "The toggle bit alternates with each guarding answer, from 0 after a reset.",
    cause: "A fault of the stack, or an answer is missing from the capture.",
    faces: &["toggle={found}, expected {expected}"],
};

pub(super) const GRD002: RuleText = RuleText {
    message: "guarding request without answer",
    meaning: "The NMT master asks for the node's state by a remote frame, and the node answers.",
    cause: "The node is gone or starting, does not support node guarding, or its CAN controller does not answer remote frames.",
    faces: &["no answer to the guarding request within {age}", "no answer to the guarding request"],
};

pub(super) const GRD003: RuleText = RuleText {
    message: "heartbeat and node guarding at once",
    meaning: "A node uses one or the other: where 1017h is not 0 it sends heartbeats and does not answer guarding requests.",
    cause: "The master is configured for guarding while 1017h of the node is not 0.",
    faces: &[
        "the guarded node sends heartbeats that nobody asked for",
        "guarding requests to a node that sends heartbeats",
    ],
};

pub(super) const GRD004: RuleText = RuleText {
    message: "guarded node never seen",
    meaning: "The capture has guarding requests for this node and no frame of its own.",
    cause: "The node does not exist or has no power, or only one direction was captured.",
    faces: &["{requests} guarding requests and no frame of the node"],
};

pub(super) const EMC001: RuleText = RuleText {
    message: "error code with error register 0",
    meaning: "While there is an error at least one bit of the error register (1001h) is set; bit 0 with any error.",
    cause: "The firmware does not maintain 1001h, or the emergency was put together by hand.",
    faces: &["error code {code}, error register {register}"],
};

pub(super) const EMC002: RuleText = RuleText {
    message: "partial error reset",
    meaning: "Error code 0000h with a register that is not 0: one error has gone, others remain. This is legal.",
    cause: "Several errors go one by one.",
    faces: &[
        "error reset, the error register is still {register}",
        "{cleared} is taken back, {left} is left; the error register is {register}",
        "{cleared} is taken back, {count} errors are left, the oldest is {left}; the error register is {register}",
        "{cleared} is taken back; by the error register {register} another error is left, which the capture does not show",
        "one of {count} errors is taken back; the error register is still {register}",
    ],
};

pub(super) const EMC003: RuleText = RuleText {
    message: "reserved bit of the error register",
    meaning: "Bit 6 of the error register (1001h) is reserved and shall be 0.",
    cause: "The firmware uses the bit for its own purposes, or bytes are in the wrong order.",
    faces: &["the error register is {register}, bit 6 is reserved"],
};

pub(super) const EMC004: RuleText = RuleText {
    message: "emergency in a state that has none",
    meaning: "A node sends no emergencies in Stopped, nor before its boot-up.",
    cause: "The device does not stop the EMCY service with the NMT state; some makers' do not.",
    faces: &["emergency of a node that is {state}", "emergency after the reset and before the boot-up"],
};

pub(super) const EMC005: RuleText = RuleText {
    message: "inhibit time of emergencies",
    meaning: "Emergencies are at least the time of 1015h (in tenths of a millisecond) apart.",
    cause: "The firmware does not obey 1015h.",
    faces: &["{found} apart, the inhibit time is {expected}"],
};

pub(super) const EMC006: RuleText = RuleText {
    message: "an emergency is not 8 bytes long",
    meaning: "An emergency always has 8 bytes: error code, error register and five of the manufacturer's. Consumers may ignore another length.",
    cause: "The firmware sets the DLC by what it has to say; a length of 0 is the boot-up of DS301 version 3.",
    faces: &["the emergency has {found} bytes and should have 8"],
};

pub(super) const EMC007: RuleText = RuleText {
    message: "device reports an error",
    meaning: "An emergency says that the device itself has an error: current, voltage, temperature, hardware, software, a module, or what it drives. It stands until the node takes it back (0000h) or boots.",
    cause: "The error code and the maker's manual say what it is; the error register shows its class.",
    faces: &["the node reports {code}, error register {register}"],
};

pub(super) const EMC008: RuleText = RuleText {
    message: "node reports an error",
    meaning: "An emergency says that the node has an error of communication, or one that its code does not name further (generic or device specific). It stands until the node takes it back (0000h) or boots.",
    cause: "A partner that is gone or silent, a PDO of another length, lost frames; or see the maker's manual.",
    faces: &["the node reports {code}, error register {register}"],
};

pub(super) const EMC009: RuleText = RuleText {
    message: "error that stands",
    meaning: "An error that the node has reported and not taken back by the end of the capture, or that it sent several times while it stood.",
    cause: "Its cause is still there, or the device takes an error back only when it is told to, or restarts.",
    faces: &[
        "{code} has not been taken back",
        "{code} has not been taken back, it was sent {count} times",
        "{code} was sent {count} times until it was taken back",
    ],
};

pub(super) const EMC010: RuleText = RuleText {
    message: "flood of emergencies",
    meaning: "An emergency is sent once for each error. Ten or more of one node came within a second.",
    cause: "An error that comes and goes (a loose contact, a value at its threshold), or a device that repeats its emergencies; 1015h limits their rate.",
    faces: &["{count} emergencies within {duration}", "{count} emergencies in all within {duration}"],
};

pub(super) const HBT006: RuleText = RuleText {
    message: "error control is not 1 byte long",
    meaning: "Heartbeat, boot-up and guarding answer have one byte, the state.",
    cause: "The firmware sets a wrong DLC, or another protocol uses this COB-ID.",
    faces: &["error control has {found} bytes and should have 1"],
};

pub(super) const TIM001: RuleText = RuleText {
    message: "invalid time",
    meaning: "TIME has 6 bytes, fewer than 86400000 milliseconds (a day), and its four reserved bits are 0.",
    cause: "The producer fills the fields wrongly, such as with another epoch or unit.",
    faces: &[
        "{found} milliseconds; a day ends with 86399999",
        "the reserved bits are {found} and should be 0",
        "TIME has {found} bytes and should have 6",
    ],
};

pub(super) const TIM002: RuleText = RuleText {
    message: "time jumps",
    meaning: "Two TIMEs differ by over a second from the time that passed in the capture.",
    cause: "The producer's clock was set, there are two producers, or the clock of the capturing host was changed.",
    faces: &["TIME went on by {passed}, in the capture {elapsed} passed"],
};

pub(super) const SDO011: RuleText = RuleText {
    message: "SDO in a state that has none",
    meaning: "There is no SDO in Stopped, nor before the boot-up: a node does not answer, and a client should not ask.",
    cause: "The master has not switched the node to Pre-operational first, or the stack does not stop SDO with the state.",
    faces: &[
        "SDO request to a node that is {state}",
        "SDO response of a node that is {state}",
        "SDO response after the reset and before the boot-up",
    ],
};

pub(super) const PDO002: RuleText = RuleText {
    message: "TPDO of a node that is not Operational",
    meaning: "PDOs exist in Operational only; frames under way when the state changed do not count. Of several TPDOs the first one is told of, once a stay in the state.",
    cause: "The stack does not stop PDOs with the state, the command to start is missing, or another node uses this COB-ID.",
    faces: &["{pdo} of a node that is {state}"],
};

pub(super) const PDO003: RuleText = RuleText {
    message: "RPDO to a node that is not Operational",
    meaning: "A node processes RPDOs in Operational only; these data are ignored.",
    cause: "The master sends RPDOs in cycles before it starts the node; usually harmless.",
    faces: &["the node is {state} and ignores {pdo}"],
};
