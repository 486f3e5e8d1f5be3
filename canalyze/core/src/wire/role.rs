//! Nouns of the frames: a PDO of a node, and what an identifier stands for. Must not say what a frame carries.

use crate::bytes::frame::{Frame, Kind};
use crate::wire::cob_id::{Role, predefined};
use crate::words::digits::{Hex, Put, put};
use crate::words::lang::{Lang, say};

/// A PDO of a node: `节点5的TPDO1`, `TPDO1 of node 5`.
#[derive(Clone, Copy, Debug)]
pub struct PdoLabel {
    /// The language.
    pub lang: Lang,
    /// Whether it is a TPDO.
    pub transmit: bool,
    /// Its number, from 1.
    pub number: u16,
    /// The node-ID.
    pub node: u8,
}

impl Put for PdoLabel {
    fn put(&self, out: &mut Vec<u8>) {
        let kind = if self.transmit { "TPDO" } else { "RPDO" };
        say!(out, self.lang; zh: "节点", self.node, "的", kind, self.number; en: kind, self.number, " of node ", self.node);
    }
}

/// One node, or with 0 all of them: `节点5`, `node 5`.
#[derive(Clone, Copy, Debug)]
pub struct Nodes(pub Lang, pub u8);

impl Put for Nodes {
    fn put(&self, out: &mut Vec<u8>) {
        match *self {
            Self(lang, 0) => put!(out; lang.pick("所有节点", "all nodes")),
            Self(lang, node) => put!(out; lang.pick("节点", "node "), node),
        }
    }
}

/// What an identifier stands for: `节点10的紧急报文`, `EMCY of node 10`.
#[derive(Clone, Copy, Debug)]
pub struct Named(pub Lang, pub Role);

impl Put for Named {
    fn put(&self, out: &mut Vec<u8>) {
        let Self(lang, role) = *self;
        match role {
            Role::Nmt => say!(out, lang; zh: "NMT节点控制"; en: "NMT node control"),
            Role::Gfc => say!(out, lang; zh: "全局故障安全命令(GFC)"; en: "global fail-safe command (GFC)"),
            Role::FlyingMaster(_) => say!(out, lang; zh: "飞行主站报文"; en: "flying master"),
            Role::Sync => say!(out, lang; zh: "同步报文"; en: "SYNC"),
            Role::Emcy(node) => say!(out, lang; zh: "节点", node, "的紧急报文"; en: "EMCY of node ", node),
            Role::Time => say!(out, lang; zh: "时间报文(TIME)"; en: "TIME"),
            Role::Srdo { number, inverted: false } => {
                say!(out, lang; zh: "SRDO", number, "的正常数据"; en: "normal data of SRDO", number);
            }
            Role::Srdo { number, inverted: true } => {
                say!(out, lang; zh: "SRDO", number, "的取反数据"; en: "inverted data of SRDO", number);
            }
            Role::Tpdo { number, node } => put!(out; PdoLabel { lang, transmit: true, number, node }),
            Role::Rpdo { number, node } => put!(out; PdoLabel { lang, transmit: false, number, node }),
            Role::SdoResponse(node) => {
                say!(out, lang; zh: "节点", node, "的SDO响应"; en: "SDO response of node ", node)
            }
            Role::SdoRequest(node) => {
                say!(out, lang; zh: "对节点", node, "的SDO请求"; en: "SDO request to node ", node)
            }
            Role::ErrorControl(node) => {
                say!(out, lang; zh: "节点", node, "的错误控制报文"; en: "error control of node ", node);
            }
            Role::LssRequest => say!(out, lang; zh: "LSS主站报文"; en: "LSS master"),
            Role::LssResponse => say!(out, lang; zh: "LSS从站报文"; en: "LSS slave"),
            Role::DynamicSdo => {
                say!(out, lang; zh: "CiA 302保留的ID (动态SDO)"; en: "ID reserved by CiA 302 (dynamic SDO)");
            }
            Role::Reserved => say!(out, lang; zh: "CiA 301保留的ID"; en: "ID reserved by CiA 301"),
            Role::Foreign => {
                say!(out, lang; zh: "29位ID, 非CANopen预定义"; en: "29-bit ID, not pre-defined in CANopen");
            }
            Role::Unassigned => {
                say!(out, lang; zh: "未分配的ID"; en: "unassigned ID");
            }
        }
    }
}

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
    if let Some(node) = role.node() {
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
