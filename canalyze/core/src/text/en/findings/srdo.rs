//! Rules about SRDO (CiA 304) in English. It must carry the same facts as `zh::findings::srdo`.

use crate::text::RuleText;

pub(super) const SRD001: RuleText = RuleText {
    message: "the two frames of an SRDO are not each other's inverse",
    meaning: "An SRDO is a frame of normal and a frame of inverted data: of the same length, the second one the bitwise inverse of the first. Where they differ, receivers must go to their safe state.",
    cause: "The sender changed the data between the two frames, the mapping is not in pairs, or another node uses the same COB-ID.",
    faces: &[
        "the second frame of SRDO{srdo} is not the bitwise inverse of the first",
        "the normal data of SRDO{srdo} have a length of {normal}, the inverted data of {inverted}",
    ],
};

pub(super) const SRD002: RuleText = RuleText {
    message: "the validation time of an SRDO is exceeded",
    meaning: "The inverted data must come within the validation time (SRVT, sub-index 3) after the normal data.",
    cause: "Bus load delays the second frame, the sender handles the two frames in different cycles of its task, or the SRVT is too short.",
    faces: &[
        "the inverted data of SRDO{srdo} came {delay} after the normal data, limit {limit} (tolerance {tolerance})",
    ],
};

pub(super) const SRD003: RuleText = RuleText {
    message: "the safeguard cycle time of an SRDO is exceeded",
    meaning: "Two SRDOs must not be further apart than the safeguard cycle time (SCT, sub-index 2): a receiver's, where one is known, else the sender's.",
    cause: "The sender's period is too long or it paused, the bus is overloaded, or the SCT is too short.",
    faces: &["SRDO{srdo} came {gap} after the one before, limit {limit} (tolerance {tolerance})"],
};

pub(super) const SRD004: RuleText = RuleText {
    message: "the frames of an SRDO are out of order, or one is missing",
    meaning: "Of each SRDO the normal data come first, then the inverted data, always both. A single frame that is late is not counted.",
    cause: "A fault in the sender, a wrong COB-ID of one of the frames, or a frame that was lost in the capture.",
    faces: &[
        "the inverted data of SRDO{srdo} come before the normal data, again and again",
        "the inverted data of SRDO{srdo} ({id}) are missing",
        "the normal data of SRDO{srdo} ({id}) are missing",
    ],
};

pub(super) const SRD005: RuleText = RuleText {
    message: "SRDO from a node that is not Operational",
    meaning: "Like PDOs, SRDOs are only sent in NMT state Operational.",
    cause: "The sender does not stop its SRDOs with the NMT state.",
    faces: &["the node is {state} and sends SRDO{srdo}"],
};
