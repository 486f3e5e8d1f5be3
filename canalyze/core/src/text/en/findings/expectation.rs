//! Rules of expectations in English. It must carry the same facts as `zh::findings::expectation`.

use crate::text::RuleText;

pub(super) const EXP001: RuleText = RuleText {
    message: "expected SDO transfer missing",
    meaning: "An expectation says that this transfer must occur; it has not, or not as often or as early as it must. A transfer that was still running at the end of the capture has not occurred.",
    cause: "The master does not configure the node as before, the node was not there, the capture is too short, or the expectation is out of date.",
    faces: &[
        "no such transfer",
        "no such read",
        "no such write",
        "no transfer of {expected}",
        "no read of {expected}",
        "no write of {expected}",
        "{found} such transfers, expected at least {expected}",
        "came only {found} after the start of the capture, expected within {expected}",
        "the transfer began here and was not completed in the capture",
        "no aborted transfer",
        "no transfer that was aborted with {expected}",
    ],
};

pub(super) const EXP002: RuleText = RuleText {
    message: "SDO transfer out of the expected order",
    meaning: "The transfers of a sequence must complete in the order in which they are listed; others may come between them. This one came too early, and not again in its place.",
    cause: "The master's configuration sequence has changed, or several clients work at the same time.",
    faces: &["too early: in the sequence {sequence} the transfer of {before} comes first"],
};

pub(super) const EXP003: RuleText = RuleText {
    message: "SDO transfer other than expected",
    meaning: "The object was transferred, but with another value or another outcome, and the expected transfer has not come. Of several, the last is named.",
    cause: "Another configuration, another firmware, or a fault of the node.",
    faces: &[
        "carried {found}, expected {expected}",
        "was aborted with {found}, expected to succeed",
        "succeeded, expected to be aborted",
        "succeeded, expected to be aborted with {expected}",
        "was aborted with {found}, expected is {expected}",
        "failed against the SDO protocol, expected otherwise",
    ],
};

pub(super) const EXP004: RuleText = RuleText {
    message: "SDO transfer that must not occur",
    meaning: "An expectation says that this transfer must never occur.",
    cause: "Another client or tool accesses the node, or the master does something new.",
    faces: &["must not occur", "must not occur ({found})"],
};

pub(super) const EXP005: RuleText = RuleText {
    message: "expected state not reached",
    meaning: "A state counts as reached when boot-up, heartbeat or guarding answer, or a drive's statusword, shows it; a command alone does not. The time is that of the frame that shows it first.",
    cause: "The node hangs in its start, was not started by the master, reports an error, or is slower than before.",
    faces: &[
        "never shown as {expected}; the last state is {found}",
        "never shown as {expected}, nor in any other state",
        "shown as {expected} only {found} after the start of the capture, expected within {limit}",
        "shown as {expected} only {found} after the boot-up, expected within {limit}",
        "no boot-up",
        "boot-up only {found} after the start of the capture, expected within {limit}",
        "not shown as {expected} since the last boot-up, expected within {limit}; the last state is {found}",
    ],
};

pub(super) const EXP006: RuleText = RuleText {
    message: "state left",
    meaning: "An expectation says that the node, or its drive, keeps this state once it is reached.",
    cause: "A command, an error with its reaction (1029h, a drive's fault), a reset or a dip of the supply.",
    faces: &["left {expected} for {found}", "booted up, expected to stay {expected}"],
};

pub(super) const EXP007: RuleText = RuleText {
    message: "signal out of its expected range",
    meaning: "The physical value, with sign, type and factor, is below the least or above the greatest that is expected.",
    cause: "The process differs, a sensor or its scaling is wrong, or another description or mapping is in use.",
    faces: &["{found} in {pdo} is below {expected}", "{found} in {pdo} is above {expected}"],
};

pub(super) const EXP008: RuleText = RuleText {
    message: "signal not at its expected rate",
    meaning: "The time from one PDO with the signal to the next is beyond the expected period and its tolerance. Across boot-ups, NMT commands that stop PDOs and gaps of the capture nothing is measured.",
    cause: "Event timer, inhibit time, transmission type or SYNC period have changed, the bus is busy, or the node has stopped sending.",
    faces: &[
        "{pdo} {found} after the one before, expected every {expected}, tolerance {tolerance}",
        "no {pdo} for {found}, expected every {expected}, tolerance {tolerance}",
    ],
};

pub(super) const EXP009: RuleText = RuleText {
    message: "heartbeats not with the expected period",
    meaning: "The time from one heartbeat to the next is beyond the expected period and its tolerance, or none has come. Additional heartbeats at a change of state are legal. Across resets, boot-ups and gaps of the capture nothing is measured.",
    cause: "1017h holds another value, the node is busy, hangs or is gone.",
    faces: &[
        "heartbeat {found} after the one before, expected every {expected}, tolerance {tolerance}",
        "no heartbeat for {found}, expected every {expected}, tolerance {tolerance}",
        "no heartbeat in the capture, expected every {expected}",
    ],
};

pub(super) const EXP010: RuleText = RuleText {
    message: "SYNC not with the expected period",
    meaning: "The time from one SYNC to the next is beyond the expected period and its tolerance, or none has come. Across gaps of the capture nothing is measured.",
    cause: "1006h holds another value, the producer is busy or stopped, or the recording's stamps are less exact than the tolerance.",
    faces: &[
        "SYNC {found} after the one before, expected every {expected}, tolerance {tolerance}",
        "no SYNC for {found}, expected every {expected}, tolerance {tolerance}",
        "no SYNC in the capture, expected every {expected}",
    ],
};

pub(super) const EXP011: RuleText = RuleText {
    message: "expected emergency missing",
    meaning: "An expectation says that this emergency must occur.",
    cause: "The fault that the test provokes was not detected, or the node reports it with another error code.",
    faces: &["no emergency", "no emergency {expected}"],
};

pub(super) const EXP012: RuleText = RuleText {
    message: "emergency that must not occur",
    meaning: "An expectation says that this emergency must never occur, or that none may but those it lists. Error resets (00xxh) are not meant, unless their code is given.",
    cause: "The node has a fault that it did not have when the expectation was written.",
    faces: &["{found} must not occur"],
};

pub(super) const EXP013: RuleText = RuleText {
    message: "took longer than expected",
    meaning: "Measured are: from an SDO request to its response, from SYNC to a synchronous TPDO, or from an NMT command to the first error-control frame that shows its state. Pairs captured in the wrong order are not measured.",
    cause: "A busy node, high bus load, a slow gateway; for NMT commands a long heartbeat period.",
    faces: &[
        "response {found} after the request, expected within {expected}",
        "{pdo} {found} after the SYNC, expected within {expected}",
        "command \"{command}\" shown {found} later, expected within {expected}",
        "{found} after the command \"{command}\" still {state}, expected within {expected}",
    ],
};

pub(super) const EXP014: RuleText = RuleText {
    message: "bus load above the expected limit",
    meaning: "The bits on the wire within the window, stuff bits included, take more of the bit rate than expected. It is said once for each time the limit is passed.",
    cause: "More PDOs or shorter periods than before, a node that floods the bus, or repeated frames.",
    faces: &["load {found} % within {window}, expected at most {expected} %"],
};

pub(super) const EXP015: RuleText = RuleText {
    message: "expectation not checked",
    meaning: "The capture cannot show whether the expectation holds, so that nothing is said against it.",
    cause: "A capture without stamps, an unknown bit rate (--bitrate), no description (--eds) for the PDOs, or a beginning that is not in the capture.",
    faces: &[
        "the capture has no stamps: times are not checked",
        "the bit rate is not known: the load is not checked",
        "there are PDOs that may carry it and whose mapping is not known",
        "not all data of the transfer were captured or kept: its value is not checked",
        "commanded to be {expected}, but the node sends no error control that would show it",
        "{expected} when first heard, {found} after the start of the capture: since when is not known",
        "no boot-up before it in the capture from which the time could be measured",
        "nothing to measure in the capture",
        "frames were lost before it was seen: it may have been among them",
    ],
};

pub(super) const EXP016: RuleText = RuleText {
    message: "expected signal missing",
    meaning: "No PDO of the capture carries a signal of this name.",
    cause: "The node does not send the PDO, its mapping has changed, the name is written differently, or the description (--eds) is missing.",
    faces: &["no signal {expected} in the capture"],
};
