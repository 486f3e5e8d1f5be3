//! The recent SDO transfers that have ended. Running transfers are followed by their channels.

use std::collections::VecDeque;

use crate::sdo::transfer::{Status, Transfer};
use crate::tables::jsonl::obj::{Obj, Values, WriteJson, array, obj, raw, text, written};
use crate::tables::jsonl::{Setting, sdo};
use crate::words::transferred;
use crate::world::dictionary::Described;

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

    /// Returns those that are kept, oldest first.
    pub(super) fn list(&self) -> impl WriteJson {
        array(self.done.iter().map(|one| written(one)))
    }
}

/// Returns the first keys of a transfer.
pub(super) fn head<'a>(setting: Setting<'a>, transfer: &'a Transfer, described: Described) -> Obj<impl Values> {
    obj! {
        "transfer": transfer.id.0,
        "bus": setting.buses.name(transfer.bus),
        "node": transfer.node, "direction": transfer.direction.name(), "mode": transfer.mode.name(),
        _: raw(move |out| sdo::object(out, setting.lang, transfer.mux, &described)),
    }
}

fn json(out: &mut Vec<u8>, setting: Setting<'_>, transfer: &Transfer) {
    let shown = transfer.outcome.status == Status::Ok && transfer.data.kept.len() <= VALUE;
    obj! {
        _: head(setting, transfer, transfer.described.clone()).inline(),
        "size": transfer.data.size,
        "value": shown.then(|| raw(|out| sdo::json_value(out, transfer.data_type(), &transfer.data.kept))),
        "text": text(|out| transferred::transferred(out, setting.lang, transfer)),
        "status": transfer.outcome.status.name(),
        "abort": raw(|out| sdo::abort_or_null(out, setting.lang, transfer.outcome.abort)),
        "first_frame": transfer.first.no, "last_frame": transfer.last.no, "t_ns": transfer.first.t_ns,
        "duration_ns": transfer.duration_ns(),
    }
    .write_json(out);
}
