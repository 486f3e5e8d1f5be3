//! Rules about drives (CiA 402) in English. It must carry the same facts as `zh::findings::drive`.

use crate::text::RuleText;

pub(super) const DRV001: RuleText = RuleText {
    message: "a state that no command led to",
    meaning: "A drive changes its state by CiA 402's state machine alone; each step toward operation enabled needs its command in the controlword. Between these two statuswords no controlword can have caused the change.",
    cause: "A fault in the drive's state machine, another master or a local panel in control, or a controlword that was lost in the capture.",
    faces: &[
        "the statusword went from {from} to {to}, and no controlword between them explains it (the last one: {controlword})",
    ],
};

pub(super) const DRV002: RuleText = RuleText {
    message: "a command has no effect",
    meaning: "The controlword holds a command that should lead out of the present state, and statuswords keep coming, but the state stays. A command away from operation enabled and a fault reset are given 1 second, one toward it 5; not counted are local operation (bit 9 is 0) and, for the latter, a supply that is not there (bit 4 is 0).",
    cause: "A condition is missing (enable input, STO, brake), the cause of the fault is still there, the commands came in the wrong order, or the drive does not receive the RPDO.",
    faces: &["{after} after controlword {controlword} the statusword still is {statusword}"],
};

pub(super) const DRV003: RuleText = RuleText {
    message: "fault state without EMCY",
    meaning: "The drive entered a fault state, and there is no emergency message of the node within 500 ms before and after.",
    cause: "The drive sends no EMCY, the same error was announced earlier, or EMCYs were filtered out of the capture.",
    faces: &["the statusword went to {statusword}, and no EMCY came before or after"],
};

pub(super) const DRV004: RuleText = RuleText {
    message: "another mode of operation is displayed than was asked for",
    meaning: "The mode of operation written to 6060h did not appear in 6061h within 1 second. Some drives change modes in certain states only, and an unsupported mode is not taken at all.",
    cause: "The drive does not support the mode (see 6502h), does not change it in this state, or another PDO writes another mode.",
    faces: &["mode {requested} was asked for, after {after} the display still says {displayed}"],
};

pub(super) const DRV005: RuleText = RuleText {
    message: "the drive is in fault",
    meaning: "The statusword says that the drive has entered a fault state: it has stopped, or is stopping, and needs a fault reset. Where an EMCY of the node announces it, that EMCY is the finding and this its consequence.",
    cause: "See the error code of the EMCY or in 603Fh, and the maker's manual; a lost connection may be the cause, too.",
    faces: &["the statusword went to {statusword}"],
};
