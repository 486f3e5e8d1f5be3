//! Nouns of the frames: a PDO of a node, and what an identifier stands for. Must not say what a frame carries.

use crate::wire::cob_id::Role;
use crate::words::digits::{Put, put};
use crate::words::{Lang, say};

/// A PDO of a node: `节点5的TPDO1`, `TPDO1 of node 5`.
#[derive(Clone, Copy, Debug)]
pub struct Pdo {
    /// The language.
    pub lang: Lang,
    /// Whether it is a TPDO.
    pub transmit: bool,
    /// Its number, from 1.
    pub number: u16,
    /// The node-ID.
    pub node: u8,
}

impl Put for Pdo {
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
            Role::Tpdo { number, node } => put!(out; Pdo { lang, transmit: true, number, node }),
            Role::Rpdo { number, node } => put!(out; Pdo { lang, transmit: false, number, node }),
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
