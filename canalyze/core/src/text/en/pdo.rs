//! A PDO with its signals, in English.
//!
//! It must carry the same facts as `zh::pdo`. No `format!`: nine tenths of a capture are these lines.

use crate::configuration::Provenance;
use crate::event::{Addressed, Placement, ProcessData, Signals, Unmapped};
use crate::frame::Frame;
use crate::text::digits::put;
use crate::text::{Depth, Lang, sentence, signal};

/// Appends the phrase of a PDO, and at other depths than brief its signals. No line end.
pub fn process_data(out: &mut Vec<u8>, depth: Depth, data: &ProcessData, frame: &Frame) {
    put!(out; if data.transmit { "TPDO" } else { "RPDO" }, data.number, " of node ", data.node);
    if depth == Depth::Brief {
        return;
    }
    put!(out; ": ");
    match &data.content {
        Signals::Mapped(mapping, from) => {
            signal::all(out, Lang::En, mapping, frame.payload());
            preset(out, *from);
        }
        Signals::ByConsumer(mapping, from, node, number) => {
            signal::all(out, Lang::En, mapping, frame.payload());
            put!(out; " (mapped as RPDO", *number, " of node ", *node, ")");
            preset(out, *from);
        }
        Signals::None(why) => {
            put!(out; frame.len, if frame.len == 1 { " byte" } else { " bytes" }, match why {
                Unmapped::Unknown => ", mapping unknown",
                Unmapped::Disabled => ", mapping disabled",
                Unmapped::Multiplex => ", no complete MPDO",
            });
        }
    }
    if let Some(sync) = &data.sync {
        placement(out, sync);
    }
}

/// Appends the phrase of a multiplex PDO, and at other depths than brief what it carries. No line end.
pub fn multiplexed(out: &mut Vec<u8>, depth: Depth, data: &Addressed) {
    put!(out; if data.transmit { "TPDO" } else { "RPDO" }, data.number, " of node ", data.node);
    if depth != Depth::Brief {
        put!(out; ": ");
        super::services::multiplexed(out, &data.content, Some(&data.mapping));
    }
}

/// What is only preset may not be what the device sends.
fn preset(out: &mut Vec<u8>, from: Provenance) {
    if from == Provenance::Eds {
        put!(out; " (default mapping of the EDS)");
    }
}

/// `[SYNC 41 +0.8ms]`.
fn placement(out: &mut Vec<u8>, sync: &Placement) {
    put!(out; " [SYNC ", sync.cycle);
    if let Some(delay) = sync.delay_ns {
        put!(out; if delay < 0 { " " } else { " +" });
        sentence::duration(out, delay);
    }
    put!(out; "]");
}
