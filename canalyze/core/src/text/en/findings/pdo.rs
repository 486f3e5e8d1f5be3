//! Rules on PDOs and their configuration, in English.
//!
//! It must carry the same facts as `zh::findings::pdo`.

use crate::text::RuleText;

pub(super) const MPD001: RuleText = RuleText {
    message: "MPDO is not 8 bytes long",
    meaning: "An MPDO always has 8 bytes: one of address, three of index and sub-index, four of data. Another length has no meaning.",
    cause: "A fault of the sender, or something else on the same identifier.",
    faces: &["MPDO length {found} instead of 8 (in bytes)"],
};

pub(super) const PDO001: RuleText = RuleText {
    message: "PDO is shorter than its mapping",
    meaning: "A receiver does not process a PDO that is shorter than what is mapped, and may send emergency 8210h.",
    cause: "The sender's DLC or mapping is wrong, the mappings of both sides differ, or the sender keeps to an old mapping.",
    faces: &[
        "PDO length {found}, its mapping needs {mapped} (in bytes)",
        "PDO length {found}, the mapping of node {consumer}'s {pdo} needs {mapped} (in bytes)",
    ],
};

pub(super) const PDO004: RuleText = RuleText {
    message: "sent again within the inhibit time",
    meaning: "Between two transmissions of an event-driven TPDO lies at least its inhibit time (sub-index 03h of the communication parameter, in 100 us); answers to remote frames excepted.",
    cause: "The device does not implement the inhibit time, its unit was mistaken, or it was written while the PDO was valid.",
    faces: &["gap of {found}, inhibit time {limit} (tolerance {tolerance})"],
};

pub(super) const PDO005: RuleText = RuleText {
    message: "event timer has run out and the PDO does not come",
    meaning: "The node is operational, and its TPDO was not sent though the event timer (sub-index 05h of the communication parameter, in ms) has run out by half of its time.",
    cause: "The device is too busy, its firmware stopped sending, or a frame is missing from the capture.",
    faces: &["not sent for {found}, event timer {limit}"],
};

pub(super) const PDO006: RuleText = RuleText {
    message: "PDO is longer than its mapping",
    meaning: "Receivers ignore the bytes beyond the mapping; they may send emergency 8220h.",
    cause: "The sender always sends 8 bytes, or the mappings of both sides differ.",
    faces: &[
        "PDO length {found}, its mapping has only {mapped} (in bytes)",
        "PDO length {found}, the mapping of node {consumer}'s {pdo} has only {mapped} (in bytes)",
    ],
};

pub(super) const PDO008: RuleText = RuleText {
    message: "reserved transmission type written",
    meaning: "Transmission types 241 to 251 of a TPDO and 241 to 253 of an RPDO are reserved; the device should refuse them with 06090030h but acknowledged the write.",
    cause: "A mistake in the configuration that the device does not check; when the PDO is sent or takes effect is not defined.",
    faces: &[
        "the reserved transmission type {found} of a TPDO was accepted",
        "the reserved transmission type {found} of an RPDO was accepted",
    ],
};

pub(super) const PDO009: RuleText = RuleText {
    message: "mapping changed while the PDO is valid",
    meaning: "Before its mapping changes, a PDO is made invalid (bit 31 of the COB-ID = 1) and sub-index 00h of the mapping is set to 0. Otherwise PDOs sent meanwhile are a mixture of old and new.",
    cause: "The configuring program leaves out the step that makes the PDO invalid, and the device does not check; most stacks refuse.",
    faces: &[
        "mapping changed though {pdo} is valid (bit 31 of the COB-ID = 0) and the mapping in use",
        "mapping changed though {pdo} is valid (bit 31 of the COB-ID = 0); only sub-index 00h of the mapping was set to 0",
    ],
};

pub(super) const PDO010: RuleText = RuleText {
    message: "CAN-ID changed while the PDO is valid",
    meaning: "Bits 0 to 29 of the COB-ID shall not change while the PDO is valid (bit 31 = 0): first bit 31 = 1 is written, then the new COB-ID.",
    cause: "The configuring program leaves out the step that makes the PDO invalid, and the device does not check; most stacks refuse with 06090030h.",
    faces: &["CAN-ID changed from {old} to {found} without making the PDO invalid first"],
};

pub(super) const PDO011: RuleText = RuleText {
    message: "remote frame for a TPDO that allows none",
    meaning: "Bit 30 of the TPDO's COB-ID is 1: no remote frames are allowed, and the device does not answer.",
    cause: "The master polls, but bit 30 is set in the device's COB-ID.",
    faces: &["bit 30 of the COB-ID of {pdo} ({id}) is 1: remote frames are not allowed"],
};

pub(super) const PDO012: RuleText = RuleText {
    message: "PDO length differs from the EDS's default mapping",
    meaning: "Only an EDS tells the mapping of this PDO; it kept to that before, but this frame is not as long: its signals are not to be trusted.",
    cause: "The sender's DLC is wrong, the device has stored another mapping, or the EDS is not of this device. A DCF helps, or a capture that has the configuration.",
    faces: &["PDO length {found}, the EDS's default mapping has {mapped} (in bytes), which the PDO kept to before"],
};

pub(super) const PDO013: RuleText = RuleText {
    message: "RPDO beyond its deadline",
    meaning: "Sub-index 05h of an RPDO's communication parameter is its deadline in ms; beyond it the node may send emergency 8250h.",
    cause: "The sender stopped or its period is too long.",
    faces: &["not received for {found}, deadline {limit}"],
};

pub(super) const PDO014: RuleText = RuleText {
    message: "restricted CAN-ID configured",
    meaning: "000 to 07F, 101 to 180, 581 to 5FF, 601 to 67F, 6E0 to 6FF and 701 to 7FF are kept for fixed services and shall not be configured; the device acknowledged the write.",
    cause: "A COB-ID was miscalculated, and the device does not check.",
    faces: &["CAN-ID {id} is restricted but was accepted"],
};

pub(super) const PDO015: RuleText = RuleText {
    message: "PDO without mapped objects",
    meaning: "The mapping of the PDO is empty (sub-index 00h is 0), but there are data frames of it, which have no meaning.",
    cause: "The mapping is being changed, or the device was configured before the capture began.",
    faces: &[
        "the mapping of {pdo} is empty, but there are data on {id}",
        "by the description the mapping of {pdo} is empty, but there are data on {id}",
    ],
};

pub(super) const PDO016: RuleText = RuleText {
    message: "mapping of more than 8 bytes",
    meaning: "The entries of the mapping have more than 64 bits together, which no frame holds; the device should refuse with 06040042h but acknowledged the write.",
    cause: "The lengths were miscalculated, and the device does not check.",
    faces: &["mapping of {found} bits was accepted, a frame holds 64"],
};

pub(super) const PDO018: RuleText = RuleText {
    message: "disabled TPDO is sent",
    meaning: "The TPDO was made invalid with bit 31 of its COB-ID, but there are still data frames on its identifier.",
    cause: "The device does not stop sending with bit 31, or another node uses the identifier.",
    faces: &["{pdo} was made invalid, but there are still data on {id}"],
};

pub(super) const PDO019: RuleText = RuleText {
    message: "disabled PDO on the bus",
    meaning: "The receiver has disabled the RPDO, or the description has the PDO invalid, but there are data frames of it.",
    cause: "The device was configured before the capture began; or the receiver is being configured, and the data have no effect.",
    faces: &[
        "by the description {pdo} is disabled, but there are data on {id}",
        "{pdo} was made invalid: the data on {id} have no effect",
    ],
};
