//! The breakdown under a line: COB-ID formula, bit groups, little-endian fields, data bytes, as the notes'
//! explanation chapters give them. Whole lines, each `#   ...` and a line end.
//!
//! The layout is one and only the words differ: they stand in [`Lang::pick`]. A new service gets its arm in
//! `services::message`. Must not decide anything.

pub mod code;
pub mod command_byte;
mod described;
pub mod lss;
pub mod mapping;
pub mod parameter;
pub mod pdo;
pub mod sdo;
pub mod services;
mod term;

use super::Lang;
use super::services::role::Named;
use super::value::Size;
use crate::bytes::frame::{Frame, Kind};
use crate::wire::cob_id::{Role, predefined};
use crate::words::digits::{Hex, Put, Spaced, put};

/// Appends one line of a breakdown.
macro_rules! line {
    ($out:expr; $($part:expr),+ $(,)?) => { $crate::words::digits::put!($out; "#   ", $($part),+, "\n") };
}
pub(crate) use line;

/// The identifier with its digits, three or eight: `60Ah`.
struct Id<'a>(&'a Frame);

impl Put for Id<'_> {
    fn put(&self, out: &mut Vec<u8>) {
        let raw = u64::from(self.0.id.raw());
        if self.0.id.is_extended() { put!(out; Hex::<8>(raw), "h") } else { put!(out; Hex::<3>(raw), "h") }
    }
}

/// The COB-ID chapter: what the identifier is made of, and who speaks to whom.
///
/// `#   COB-ID 60Ah = 600h + 节点ID 0Ah (10): SDO请求, 主站(客户端) -> 从站(服务器)`
///
/// `role` may be another than the pre-defined one, where a configuration moved the service.
pub fn cob_id(out: &mut Vec<u8>, lang: Lang, role: Role, frame: &Frame) {
    if frame.kind == Kind::Error {
        return;
    }
    put!(out; "#   COB-ID ", Id(frame));
    if predefined(frame.id) != role {
        return put!(out; lang.pick(": 由配置指定, ", ": set by configuration, "), Named(lang, role), "\n");
    }
    let node = match role {
        Role::Emcy(node) | Role::SdoResponse(node) | Role::SdoRequest(node) | Role::ErrorControl(node) => Some(node),
        Role::Tpdo { node, .. } | Role::Rpdo { node, .. } => Some(node),
        _ => None,
    };
    if let Some(node) = node {
        let base = u64::from(frame.id.raw()).saturating_sub(u64::from(node));
        put!(out; " = ", Hex::<3>(base), lang.pick("h + 节点ID ", "h + node-ID "));
        put!(out; Hex::<2>(u64::from(node)), "h (", node, ")");
    }
    if let Role::Srdo { number, inverted } = role {
        put!(out; if inverted { " = 100h + 2 x " } else { " = 0FFh + 2 x " }, number);
    }
    put!(out; ": ");
    purpose(out, lang, role);
    put!(out; "\n");
}

/// What the identifier carries, and from whom to whom. The node has been named before.
fn purpose(out: &mut Vec<u8>, lang: Lang, role: Role) {
    match role {
        Role::Nmt => {
            put!(out; lang.pick("NMT节点控制, NMT主站 -> NMT从站", "NMT node control, NMT master -> NMT slaves"))
        }
        Role::Sync => put!(out; lang.pick("同步报文, 生产者 -> 消费者", "SYNC, producer -> consumers")),
        Role::Time => put!(out; lang.pick("时间报文(TIME), 生产者 -> 消费者", "TIME, producer -> consumers")),
        Role::Emcy(_) => put!(out; lang.pick("紧急报文, 生产者 -> 消费者", "EMCY, producer -> consumers")),
        Role::Tpdo { number, .. } => {
            put!(out; "TPDO", number, lang.pick(", 该节点 -> 消费者", ", this node -> consumers"));
        }
        Role::Rpdo { number, .. } => {
            put!(out; "RPDO", number, lang.pick(", 生产者 -> 该节点", ", producer -> this node"));
        }
        Role::SdoRequest(_) => {
            put!(out; lang.pick("SDO请求, 主站(客户端) -> 从站(服务器)", "SDO request, client -> server"))
        }
        Role::SdoResponse(_) => {
            put!(out; lang.pick("SDO响应, 从站(服务器) -> 主站(客户端)", "SDO response, server -> client"))
        }
        Role::ErrorControl(_) => put!(out; lang.pick("错误控制 (启动报文, 心跳, 节点保护)",
            "error control (boot-up, heartbeat, node guarding)",
        )),
        Role::LssRequest => put!(out; lang.pick("LSS, 主站 -> 从站", "LSS, master -> slaves")),
        Role::LssResponse => put!(out; lang.pick("LSS, 从站 -> 主站", "LSS, slave -> master")),
        Role::Gfc
        | Role::FlyingMaster(_)
        | Role::Srdo { .. }
        | Role::DynamicSdo
        | Role::Reserved
        | Role::Unassigned
        | Role::Foreign => put!(out; Named(lang, role)),
    }
}

/// Data bytes, sixteen a line: `#   9C FF FF FF  数据(4字节)`. Nothing where there are none.
pub fn data(out: &mut Vec<u8>, lang: Lang, bytes: &[u8]) {
    for chunk in bytes.chunks(16) {
        put!(out; "#   ", Spaced(chunk), lang.pick("  数据(", "  data ("), Size(lang, chunk.len() as u64), ")");
        ascii(out, chunk);
        put!(out; "\n");
    }
}

/// The bytes as text, in quotes, where all of them are printable ASCII.
fn ascii(out: &mut Vec<u8>, bytes: &[u8]) {
    if bytes.iter().all(|byte| (0x20..0x7F).contains(byte)) {
        put!(out; " \"");
        out.extend_from_slice(bytes);
        put!(out; "\"");
    }
}

/// Bytes that a frame has beyond its fields: reserved.
pub fn reserved(out: &mut Vec<u8>, lang: Lang, bytes: &[u8]) {
    if !bytes.is_empty() {
        line!(out; Spaced(bytes), lang.pick("  保留", "  reserved"));
    }
}

/// `#   0A  节点ID 0Ah (10)`.
pub fn node_id(out: &mut Vec<u8>, lang: Lang, node: u8) {
    let hex = Hex::<2>(u64::from(node));
    put!(out; "#   ", hex, lang.pick("  节点ID ", "  node-ID "), hex, "h (", node, ")");
    if node > 127 {
        put!(out; lang.pick(" 无效", " invalid"));
    }
    put!(out; "\n");
}
