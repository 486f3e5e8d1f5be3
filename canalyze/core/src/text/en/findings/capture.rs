//! Findings about the capture itself, in English: damage. The older ones stand beside the table.

use super::RuleText;

pub(super) const CAP004: RuleText = RuleText {
    message: "a part of the file is damaged and was passed over",
    meaning: "What can be read before and after it is read. Across the gap no toggle bit, sequence number or answer is judged, and open transfers are incomplete.",
    cause: "The recording machine lost power, the medium has errors, or the file was changed on its way; copy it again and compare check sums.",
    faces: &[
        "the check sum does not match; {bytes} bytes were passed over",
        "a length or type that cannot be; {bytes} bytes were passed over",
        "compressed data are damaged; {bytes} bytes were passed over",
        "the rest of the file cannot be read",
        "messages of topics whose definition is lost were passed over",
        "the check sum does not match; {bytes} bytes with {frames} frames were passed over",
        "a length or type that cannot be; {bytes} bytes with {frames} frames were passed over",
        "compressed data are damaged; {bytes} bytes with {frames} frames were passed over",
    ],
};
pub(super) const CAP005: RuleText = RuleText {
    message: "the file ends in the middle of a record",
    meaning: "Everything before the cut is read; what was being written is lost.",
    cause: "The recording program was ended, or the file is still being written or copied.",
    faces: &["the file ends in the middle of a record; all before it is read"],
};
pub(super) const CAP006: RuleText = RuleText {
    message: "time stamps go back",
    meaning: "A frame's stamp is 10 ms or more earlier than that of the frame before on the same bus: the clock was set, or frames stand in the wrong order. Times across the step are not judged.",
    cause: "The host's clock was set (NTP, GPS, by hand), recordings were joined out of order, or the recording was edited.",
    faces: &["its stamp is {back} earlier"],
};
