//! Rules about error frames in English. It must carry the same facts as `zh::findings::bus`.

use crate::text::RuleText;

pub(super) const BUS001: RuleText = RuleText {
    message: "bus-off",
    meaning: "The CAN controller that recorded counted 256 transmit errors and has left the bus: until it is restarted it neither sends nor receives. What was on the bus meanwhile is not in the capture.",
    cause: "A short circuit or an open wire, the wrong bit rate, a missing termination, or no other node on the bus.",
    faces: &[
        "the controller is off the bus",
        "the controller is off the bus, {count} error frames",
        "{count} error frames in all within {duration}",
    ],
};

pub(super) const BUS002: RuleText = RuleText {
    message: "error passive",
    meaning: "An error counter of the CAN controller that recorded has reached 128: so many frames were faulty, or acknowledged by nobody. It may still send, but no longer destroys frames that it sees as wrong.",
    cause: "No other node on the bus, the wrong bit rate, bad termination or shielding, or a loose contact.",
    faces: &[
        "the controller is error passive",
        "the controller is error passive, {count} error frames",
        "{count} error frames in all within {duration}",
    ],
};

pub(super) const BUS003: RuleText = RuleText {
    message: "error warning level",
    meaning: "An error counter of the CAN controller that recorded has reached 96; on a sound bus it stays near 0.",
    cause: "Faulty frames by bad wiring or disturbance, or frames that nobody acknowledges.",
    faces: &[
        "an error counter is at the warning level",
        "an error counter is at the warning level, {count} error frames",
        "{count} error frames in all within {duration}",
    ],
};

pub(super) const BUS004: RuleText = RuleText {
    message: "frame not transmitted",
    meaning: "Any node that receives a frame without a fault acknowledges it. Nobody did, or the frame could not be sent in time: no partner has got it.",
    cause: "No other node on the bus or in power, another bit rate, an open wire, or a bus that is always busy.",
    faces: &[
        "a frame was acknowledged by nobody",
        "frames were acknowledged by nobody, {count} error frames",
        "a frame could not be transmitted in time",
        "frames could not be transmitted in time, {count} error frames",
        "{count} error frames in all within {duration}",
    ],
};

pub(super) const BUS005: RuleText = RuleText {
    message: "overflow of the controller",
    meaning: "The CAN controller that recorded had no room for a frame: received frames are missing from the capture, or frames that the host wanted to send were not sent. Across a loss nothing is judged.",
    cause: "The host is too slow or too busy, or the bus is overloaded.",
    faces: &[
        "the receive buffer overflowed, frames are missing",
        "the receive buffer overflowed {count} times, frames are missing",
        "the transmit buffer overflowed",
        "the transmit buffer overflowed {count} times",
        "{count} error frames in all within {duration}",
    ],
};

pub(super) const BUS006: RuleText = RuleText {
    message: "controller recovered",
    meaning: "The CAN controller that recorded is error active again, or was restarted after bus-off.",
    cause: "The fault on the bus is over, or the host restarts the controller by itself.",
    faces: &[
        "the controller is error active again",
        "the controller was restarted",
        "the controller is error active again after {after}",
        "the controller was restarted after {after}",
    ],
};

pub(super) const BUS007: RuleText = RuleText {
    message: "bus error",
    meaning: "A frame violated the CAN protocol (bit, stuff, form or CRC error) and was destroyed by an error frame; its sender repeats it. On a sound bus this hardly ever happens.",
    cause: "Disturbance, bad termination or shielding, a loose contact, a node with another bit rate, or one that was just plugged in.",
    faces: &[
        "a bus error",
        "{count} bus errors",
        "an error frame; the capture does not say of which kind",
        "{count} error frames; the capture does not say of which kind",
        "{count} error frames in all within {duration}",
    ],
};

pub(super) const BUS008: RuleText = RuleText {
    message: "fault of the transceiver",
    meaning: "The transceiver of the CAN controller that recorded reports a wire that is open or shorted.",
    cause: "CANH or CANL is broken, or touches the other one, ground or a supply.",
    faces: &[
        "the transceiver reports a faulty wire",
        "the transceiver reports a faulty wire, {count} error frames",
        "{count} error frames in all within {duration}",
    ],
};
