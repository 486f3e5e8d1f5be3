//! Rules of SYNC and synchronous PDOs, in English.
//!
//! It must carry the same facts as `zh::findings::sync`.

use crate::text::RuleText;

pub(super) const SYN001: RuleText = RuleText {
    message: "wrong length of SYNC",
    meaning: "A SYNC has no data where 1019h is 0, else one byte with the counter. Consumers may ignore a SYNC of another length, and report 8240h.",
    cause: "Producer and consumers disagree about 1019h, or there is another SYNC producer on the bus.",
    faces: &[
        "SYNC of length {found} (in bytes) though 1019h is {overflow}",
        "SYNC of length {found}, those before had length {expected} (in bytes)",
        "SYNC of length {found} instead of 0 or 1 (in bytes)",
    ],
};

pub(super) const SYN002: RuleText = RuleText {
    message: "SYNC counter out of sequence",
    meaning: "The counter begins with 1, counts every SYNC, and goes back to 1 after the overflow value (1019h); it is never 0.",
    cause: "A SYNC was lost or doubled, the producer is wrong, or there are two producers on the bus.",
    faces: &["SYNC counter {found} instead of {expected}", "SYNC counter {found} is not within 1 to {limit}"],
};

pub(super) const SYN003: RuleText = RuleText {
    message: "irregular SYNC period",
    meaning: "SYNCs should come with the communication cycle period (1006h); consumers call one missing after one and a half periods. Where 1006h is not known the period is taken from the traffic.",
    cause: "The producer stalled or is overloaded, a SYNC was lost, one too many was sent, or 1006h is not what the producer does.",
    faces: &[
        "the next SYNC came {gap} after this one, period {period} (tolerance {tolerance}): {missing} missing",
        "the next SYNC came {gap} after this one, period {period} (tolerance {tolerance}): late",
        "the next SYNC came only {gap} after this one, period {period} (tolerance {tolerance})",
        "the SYNC period is {period}, configured is {expected}",
        "the SYNC period is {period} from here on, before it was {expected}; no write of 1006h explains it",
        "SYNCs come unsteadily, up to {jitter} off the period of {period}",
    ],
};

pub(super) const SYN004: RuleText = RuleText {
    message: "synchronous PDO outside the window",
    meaning: "Synchronous TPDOs should be sent within the synchronous window (1007h) after the SYNC; consumers may drop later ones.",
    cause: "The node is too slow, the bus load too high, or the window too short.",
    faces: &["SYNC cycle {cycle}: {delay} after the SYNC, window {window}, tolerance {tolerance}"],
};

pub(super) const SYN005: RuleText = RuleText {
    message: "synchronous PDO before the first SYNC",
    meaning: "Synchronous TPDOs are triggered by SYNC, and the capture has none before this one.",
    cause: "The transmission type is another one than is known, or SYNC has another COB-ID (1005h).",
    faces: &[],
};

pub(super) const SYN006: RuleText = RuleText {
    message: "two SYNC producers on the bus",
    meaning: "Only one node should produce SYNC at a time; two trains of SYNCs double or displace synchronous PDOs.",
    cause: "The producer bit (bit 30) of 1005h is set on two nodes, or the master produces SYNC beside a node.",
    faces: &[
        "two SYNC counters run beside each other: {found}, while {expected} is due in the other",
        "two trains of SYNCs: {short} and {long} apart in turn, period {period}",
        "configured as SYNC producer, and so is node {other}",
    ],
};

pub(super) const SYN007: RuleText = RuleText {
    message: "synchronous window not below the period",
    meaning: "The synchronous window (1007h) should be shorter than the communication cycle period (1006h), else it means nothing.",
    cause: "The unit of 1006h or 1007h was mistaken (both are in microseconds), or only one of them was changed.",
    faces: &["the synchronous window of {window} is not below the communication cycle period of {period}"],
};

pub(super) const SYN008: RuleText = RuleText {
    message: "synchronous PDO missing in its cycle",
    meaning: "A TPDO of transmission type n (1 to 240) is sent with every n-th SYNC; this one was, and did not come.",
    cause: "The node did not get the SYNC or was too slow, its window had passed, or a frame was lost from the capture.",
    faces: &[
        "not sent in SYNC cycle {cycle} ({count} missing)",
        "not sent from SYNC cycle {cycle} on, for {since} cycles, though the node is Operational",
    ],
};

pub(super) const SYN009: RuleText = RuleText {
    message: "synchronous PDO more than once in a cycle",
    meaning: "A synchronous TPDO is sent at most once in a SYNC cycle.",
    cause: "The node is wrong, two nodes use the same COB-ID, or a SYNC is missing from the capture.",
    faces: &["sent more than once in SYNC cycle {cycle}"],
};

pub(super) const SYN010: RuleText = RuleText {
    message: "synchronous PDO in the wrong cycle",
    meaning: "A TPDO of transmission type n (1 to 240) is sent with every n-th SYNC; this one came in another cycle.",
    cause: "The node missed or miscounted a SYNC, was so slow that it came a cycle late, or the SYNC start value is wrong.",
    faces: &[
        "sent at SYNC {found} after the one it was last sent at, due by its transmission type at SYNC {expected}",
        "belongs to SYNC cycle {expected} and came in cycle {found}",
    ],
};

pub(super) const SYN011: RuleText = RuleText {
    message: "times of SYNC cannot be judged",
    meaning: "Without stamps, or with stamps that are less steady than the synchronous window is long, period and window are not judged; counter and composition of the cycles are.",
    cause: "The capture has no stamps (-t of candump), or was taken on a busy host; --jitter gives the tolerance.",
    faces: &[
        "the capture has no stamps: SYNC period and window are not judged",
        "the tolerance of {tolerance} is not below the window of {window}: the window is not judged",
    ],
};

pub(super) const SYN012: RuleText = RuleText {
    message: "a single SYNC was late",
    meaning: "One SYNC came over half a period late, and those after it came at the old times: none is missing, this one was only sent or recorded late.",
    cause: "The producer, or the recording computer, was busy with something else for a moment; a high bus load.",
    faces: &["{gap} since the SYNC before, the period is {period}; those after it came in time"],
};

pub(super) const SYN013: RuleText = RuleText {
    message: "SYNC has stopped",
    meaning: "SYNC came periodically and then no more, while nodes go on in Operational: synchronous PDOs are neither sent nor actuated any more. No NMT command, boot-up or write of 1005h or 1006h explains it.",
    cause: "The producer was switched off, disconnected or has ended its program; its 1005h or 1006h was changed outside of the capture. At the end of a test this is often meant.",
    faces: &["no SYNC for {silence}, the period was {period}; the node is still Operational"],
};
