//! What a capture format cannot hold, in English.

use crate::text::digits::put;
use crate::writers::loss::Loss;

/// `12 frames: the direction is not kept`.
pub fn loss(out: &mut Vec<u8>, loss: Loss, count: u64) {
    let (one, many, what) = match loss {
        Loss::Direction => ("frame", "frames", "the direction is not kept"),
        Loss::UnknownDirection => ("frame", "frames", "the direction is not known, written as received"),
        Loss::BusName => ("frame", "frames", "the name of the bus is not kept as it is"),
        Loss::StampDigits => ("frame", "frames", "the last digits of the stamp are not kept"),
        Loss::NoStamp => ("frame", "frames", "no stamp that could be written, given an invented one"),
        Loss::Order => ("frame", "frames", "the stamp steps back, which the format does not allow"),
        Loss::NoDate => ("frame", "frames", "the date is not known, the stamp counts from zero"),
        Loss::FdFlags => ("frame", "frames", "bit rate switch or error state indicator not kept"),
        Loss::FdFormat => ("CAN FD frame", "CAN FD frames", "written in the classic frame format"),
        Loss::FdFrame => ("CAN FD frame", "CAN FD frames", "left out, the format has none"),
        Loss::RawDlc => ("frame", "frames", "the raw DLC above 8 is not kept"),
        Loss::RemoteLength => ("remote frame", "remote frames", "the requested length is not kept"),
        Loss::ErrorDetails => ("error frame", "error frames", "class and details are not kept"),
        Loss::ErrorFrame => ("error frame", "error frames", "left out, the format has none"),
        Loss::Gap => ("gap", "gaps", "that the capturing program lost frames is not kept"),
        Loss::Topics => ("frame", "frames", "the signals are not written, there is no room for another topic"),
    };
    put!(out; count, " ", if count == 1 { one } else { many }, ": ", what);
}
