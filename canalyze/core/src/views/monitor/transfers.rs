//! The recent SDO transfers that have ended. Running transfers are followed by their channels.

use std::collections::VecDeque;

use crate::sdo::transfer::{Status, Transfer};
use crate::tables::jsonl::{self, Setting};
use crate::words::digits::put;
use crate::words::transferred;

/// Maximum number of transfers that are kept.
const DONE: usize = 200;
/// Maximum number of bytes of a value that is shown.
const VALUE: usize = 256;

/// The transfers of a capture.
#[derive(Debug, Default)]
pub(super) struct Transfers {
    /// In JSON.
    done: VecDeque<Vec<u8>>,
}

impl Transfers {
    /// Takes a transfer that has ended.
    pub(super) fn take(&mut self, setting: Setting<'_>, transfer: &Transfer) {
        let mut out = if self.done.len() < DONE { Vec::new() } else { self.done.pop_front().unwrap_or_default() };
        out.clear();
        json(&mut out, setting, transfer);
        self.done.push_back(out);
    }

    /// Appends those that are kept, oldest first, as a JSON list.
    pub(super) fn list(&self, out: &mut Vec<u8>) {
        for (place, one) in self.done.iter().enumerate() {
            put!(out; if place > 0 { "," } else { "[" });
            out.extend_from_slice(one);
        }
        put!(out; if self.done.is_empty() { "[]" } else { "]" });
    }
}

fn json(out: &mut Vec<u8>, setting: Setting<'_>, transfer: &Transfer) {
    put!(out; "{\"transfer\":", transfer.id.0, ",\"bus\":");
    jsonl::name(out, setting.buses.name(transfer.bus));
    put!(out; ",\"node\":", transfer.node, ",\"direction\":\"", transfer.direction.name());
    put!(out; "\",\"mode\":\"", transfer.mode.name(), "\"");
    jsonl::sdo::object(out, setting.lang, transfer.mux, &transfer.described);
    put!(out; ",\"size\":", transfer.data.size, ",\"value\":");
    if transfer.outcome.status == Status::Ok && transfer.data.kept.len() <= VALUE {
        jsonl::sdo::json_value(out, transfer.data_type(), &transfer.data.kept);
    } else {
        put!(out; "null");
    }
    put!(out; ",\"text\":");
    jsonl::quoted(out, |text| transferred::transferred(text, setting.lang, transfer));
    put!(out; ",\"status\":\"", transfer.outcome.status.name(), "\",\"abort\":");
    jsonl::sdo::abort_or_null(out, setting.lang, transfer.outcome.abort);
    put!(out; ",\"first_frame\":", transfer.first.no, ",\"last_frame\":", transfer.last.no, ",\"t_ns\":");
    jsonl::signed_or_null(out, transfer.first.t_ns);
    put!(out; ",\"duration_ns\":");
    jsonl::signed_or_null(out, transfer.duration_ns());
    put!(out; "}");
}
