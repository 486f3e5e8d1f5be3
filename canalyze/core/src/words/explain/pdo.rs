//! The breakdown of a PDO: COB-ID, parameters, and each mapped object bit by bit.

use super::{cob_id, data};
use crate::bytes::frame::Frame;
use crate::wire::cob_id::Role;
use crate::words::digits::put;
use crate::words::{Lang, say};
use crate::world::configuration::Provenance;
use crate::world::event::{ProcessData, Signals, Unmapped};

/// Appends the breakdown of a PDO with data.
pub fn process_data(out: &mut Vec<u8>, lang: Lang, pdo: &ProcessData, frame: &Frame) {
    let (number, node) = (pdo.number, pdo.node);
    cob_id(out, lang, if pdo.transmit { Role::Tpdo { number, node } } else { Role::Rpdo { number, node } }, frame);
    super::services::parameters(out, lang, pdo.transmit, number);
    match &pdo.content {
        Signals::Mapped(mapping, from) | Signals::ByConsumer(mapping, from, ..) => {
            provenance(out, lang, *from);
            super::mapping::mapping(out, lang, mapping, frame.payload());
        }
        Signals::None(why) => {
            if *why == Unmapped::Unconfirmed {
                say!(out, lang;
                    zh: "#   COB-ID来源: 记录中的SDO写请求, 未见响应\n";
                    en: "#   COB-ID from: SDO write request in the capture, no response seen\n");
            }
            if *why == Unmapped::Contradicted {
                say!(out, lang;
                    zh: "#   映射未知: 该PDO的帧与EDS默认映射不符\n";
                    en: "#   mapping unknown: frames of this PDO do not fit the EDS default mapping\n");
            }
            data(out, lang, frame.payload());
        }
    }
}

/// From where the mapping is known.
fn provenance(out: &mut Vec<u8>, lang: Lang, from: Provenance) {
    put!(out; lang.pick("#   映射来源: ", "#   mapping from: "));
    match from {
        Provenance::Observed(frame) => say!(out, lang;
            zh: "记录中的SDO, 到第", frame, "帧为止"; en: "SDO in the capture, up to frame ", frame),
        Provenance::Doubted(frame) => say!(out, lang;
            zh: "记录中的SDO, 到第", frame, "帧为止, 此后有帧丢失";
            en: "SDO in the capture, up to frame ", frame, "; frames lost since then"),
        Provenance::Unconfirmed(frame) => say!(out, lang;
            zh: "未确认: 记录中的SDO写请求, 到第", frame, "帧为止, 未见响应";
            en: "unconfirmed: SDO write requests in the capture, up to frame ", frame, ", no response seen"),
        Provenance::Option => say!(out, lang; zh: "命令行选项"; en: "command line option"),
        Provenance::Dcf => put!(out; "DCF"),
        Provenance::Profile => say!(out, lang; zh: "设备规范默认值"; en: "defaults of the profile"),
        Provenance::Eds => say!(out, lang; zh: "EDS默认值"; en: "EDS defaults"),
        Provenance::Default => say!(out, lang; zh: "预定义连接集"; en: "pre-defined connection set"),
    }
    put!(out; "\n");
}
