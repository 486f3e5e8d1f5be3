//! Rules on what a device's description says and the device does otherwise, in English.
//!
//! It must carry the same facts as `zh::findings::description`.

use crate::text::RuleText;

pub(super) const EDS001: RuleText = RuleText {
    message: "value read differs from the EDS's default",
    meaning: "The parameter was not written in the capture before, and the value read is not the EDS's default; or from the beginning a PDO is not as long as the EDS's default mapping.",
    cause: "The device was configured or stored its parameters before the capture began, or the EDS is of another firmware or another device.",
    faces: &[
        "{found} read, {described} by default in the EDS",
        "PDO length {found}, the EDS's default mapping has {mapped} (in bytes): the device was configured before the capture began, or the EDS is not of this device",
    ],
};

pub(super) const EDS002: RuleText = RuleText {
    message: "value read differs from the DCF",
    meaning: "The parameter was not written in the capture before, and the value read is not what the DCF configures.",
    cause: "The device is not configured by this DCF, or lost its configuration in a reset.",
    faces: &["{found} read, {described} in the DCF"],
};

pub(super) const EDS003: RuleText = RuleText {
    message: "object is not in the description",
    meaning: "The access succeeded, but the device's description has no such index or sub-index.",
    cause: "The EDS is of another firmware, or the vendor left the object out of it.",
    faces: &[
        "accessed, but the description has no such index",
        "accessed, but the description has no such sub-index of it",
    ],
};

pub(super) const EDS004: RuleText = RuleText {
    message: "identity differs from the description",
    meaning: "Device type (1000h), vendor-ID or product code (1018h) are not those of the description: it probably is that of another device.",
    cause: "The wrong EDS was given for the node, node-IDs were mixed up, or the device was replaced.",
    faces: &["{found} read, {described} in the description: the EDS is probably not of this device"],
};

pub(super) const SDO013: RuleText = RuleText {
    message: "length of a value differs from the object's type",
    meaning: "Both sides completed the transfer, but the value does not have the length of the number's type: that in the description or, without one, of CiA 301 for objects that every device has; where all short values of a device are sent as four bytes, that is let pass then.",
    cause: "A wrong data type in the EDS, another firmware, a client with the wrong length and a server that does not check, or a server that answers everything with 4 bytes.",
    faces: &[
        "written with length {found}, {type} has {length} (in bytes)",
        "read with length {found}, {type} has {length} (in bytes)",
    ],
};

pub(super) const SDO014: RuleText = RuleText {
    message: "access against the description succeeded",
    meaning: "The description does not allow the access, but the server completed it.",
    cause: "A wrong AccessType in the EDS, another firmware, or a server that does not check access.",
    faces: &[
        "written, but the object is read-only in the description",
        "read, but the object is write-only in the description",
    ],
};
