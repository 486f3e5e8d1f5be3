//! SDO transfers as CSV: one row a transfer, in the order in which they end. The same in every language.
//!
//! | column | |
//! |---|---|
//! | `transfer` | number in the capture, from 1 |
//! | `t` | of its first frame: seconds, all digits of the stamp, or as the time is asked for; empty without stamps |
//! | `bus` | name; empty where the capture has none |
//! | `node` | node-ID of the server |
//! | `direction` | `upload`, `download` |
//! | `mode` | `expedited`, `segmented`, `block` |
//! | `object` | `1008:00`; empty where it is not in the capture |
//! | `name` | the description's, else that of the standard in English |
//! | `type` | of the object, where it is known |
//! | `value` | where its type is known and the transfer completed |
//! | `size` | bytes transferred |
//! | `status` | `ok`, `aborted`, `failed`, `incomplete` |
//! | `abort_by`, `abort_code` | `client` or `server`, and the code, where it was aborted |
//! | `duration` | seconds |
//! | `first_frame`, `last_frame` | numbers in the capture, from 1 |
//! | `findings` | codes with blanks between |
//! | `data` | the bytes, the first 65536 of them |

use super::csv::{bare, cell};
use super::jsonl::sdo::{json_value, side};
use super::jsonl::{NAMES, Setting, seconds};
use crate::sdo::transfer::{Status, Transfer};
use crate::words::digits::{Hex, Joined, put};
use crate::words::value;
use crate::world::od::{self, DataType, Value};

/// Appends the headings.
pub fn head(out: &mut Vec<u8>) {
    put!(out; "transfer,t,bus,node,direction,mode,object,name,type,value,size,status,abort_by,abort_code,duration,");
    put!(out; "first_frame,last_frame,findings,data\n");
}

/// Appends the row of a transfer.
pub fn row(out: &mut Vec<u8>, setting: Setting<'_>, transfer: &Transfer) {
    let kept = &transfer.data.kept;
    put!(out; transfer.id.0, ",");
    bare(out, |out| setting.moment(out, transfer.first.t_ns));
    put!(out; ",");
    cell(out, setting.buses.name(transfer.bus));
    put!(out; ",", transfer.node, ",", transfer.direction.name(), ",", transfer.mode.name(), ",");
    if let Some(mux) = transfer.mux {
        put!(out; Hex::<4>(u64::from(mux.index)), ":", Hex::<2>(u64::from(mux.sub)));
        let mut name = Vec::new();
        value::name(&mut name, NAMES, mux, &transfer.described);
        put!(out; ",");
        cell(out, name.trim_ascii_start());
    } else {
        put!(out; ",");
    }
    let data_type = transfer.data_type();
    put!(out; ",", data_type.map_or("", DataType::name), ",");
    if transfer.outcome.status == Status::Ok {
        match od::decode(data_type, kept) {
            Value::Text(text) => cell(out, text.as_bytes()),
            _ => bare(out, |out| json_value(out, data_type, kept)),
        }
    }
    put!(out; ",", transfer.data.size, ",", transfer.outcome.status.name(), ",");
    match transfer.outcome.abort {
        Some(abort) => put!(out; side(abort.by), ",", Hex::<8>(u64::from(abort.code))),
        None => put!(out; ","),
    }
    put!(out; ",");
    bare(out, |out| seconds(out, transfer.duration_ns(), setting.decimals));
    put!(out; ",", transfer.first.no, ",", transfer.last.no, ",");
    for (place, code) in transfer.outcome.findings.iter().enumerate() {
        put!(out; if place > 0 { " " } else { "" }, code.rule().id);
    }
    put!(out; ",", Joined(kept), "\n");
}
