//! A PDO with its signals, in Chinese.
//!
//! It must carry the same facts as `en::pdo`. No `format!`: nine tenths of a capture are these lines.

use crate::configuration::Provenance;
use crate::event::{Addressed, Placement, ProcessData, Signals, Unmapped};
use crate::frame::Frame;
use crate::text::digits::put;
use crate::text::{Depth, Lang, sentence, signal};

/// Appends the phrase of a PDO, and at other depths than brief its signals. No line end.
pub fn process_data(out: &mut Vec<u8>, depth: Depth, data: &ProcessData, frame: &Frame) {
    put!(out; "节点", data.node, if data.transmit { "的TPDO" } else { "的RPDO" }, data.number);
    if depth == Depth::Brief {
        return;
    }
    put!(out; ": ");
    match &data.content {
        Signals::Mapped(mapping, from) => {
            signal::all(out, Lang::Zh, mapping, frame.payload());
            preset(out, *from);
        }
        Signals::ByConsumer(mapping, from, node, number) => {
            signal::all(out, Lang::Zh, mapping, frame.payload());
            put!(out; " (按节点", *node, "的RPDO", *number, "的映射)");
            preset(out, *from);
        }
        Signals::None(why) => {
            put!(out; frame.len, "字节", match why {
                Unmapped::Unknown => ", 映射未知",
                Unmapped::Disabled => ", 映射已禁用",
                Unmapped::Multiplex => ", 不是完整的MPDO",
            });
        }
    }
    if let Some(sync) = &data.sync {
        placement(out, sync);
    }
}

/// Appends the phrase of a multiplex PDO, and at other depths than brief what it carries. No line end.
pub fn multiplexed(out: &mut Vec<u8>, depth: Depth, data: &Addressed) {
    put!(out; "节点", data.node, if data.transmit { "的TPDO" } else { "的RPDO" }, data.number);
    if depth != Depth::Brief {
        put!(out; ": ");
        super::services::multiplexed(out, &data.content, Some(&data.mapping));
    }
}

/// What is only preset may not be what the device sends.
fn preset(out: &mut Vec<u8>, from: Provenance) {
    if from == Provenance::Eds {
        put!(out; " (EDS默认映射)");
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
