//! Short names of services, as a list of communication objects has them.

use super::{Row, find};
use crate::words::Lang;

/// Services by their names in filters and JSON.
pub static SERVICES: &[Row<&str>] = &[
    ("emcy", "紧急报文", "EMCY"),
    ("error", "错误帧", "error frames"),
    ("flying_master", "飞行主站", "flying master"),
    ("foreign", "其他", "other"),
    ("gfc", "GFC", "GFC"),
    ("guarding", "节点保护", "node guarding"),
    ("heartbeat", "心跳", "heartbeat"),
    ("lss", "LSS", "LSS"),
    ("nmt", "NMT", "NMT"),
    ("pdo", "PDO", "PDO"),
    ("sdo", "SDO", "SDO"),
    ("srdo", "SRDO", "SRDO"),
    ("sync", "同步报文", "SYNC"),
    ("time", "时间报文", "TIME"),
    ("usdo", "USDO", "USDO"),
];

/// Frames of an SDO channel: from the client, from the server.
pub static SDO: &[Row<u8>] = &[(0, "SDO请求", "SDO request"), (1, "SDO响应", "SDO response")];

/// The second frame of an SRDO, with inverted data.
pub static INVERTED: &[Row<u8>] = &[(0, "取反", "inverted")];

/// The name of a service.
pub fn name(lang: Lang, service: &'static str) -> Option<&'static str> {
    find(SERVICES, lang, service)
}

/// The name of the frames of an SDO channel.
pub fn sdo(lang: Lang, from_server: bool) -> &'static str {
    find(SDO, lang, u8::from(from_server)).unwrap_or("SDO")
}

/// The word for the inverted frame of an SRDO.
pub fn inverted(lang: Lang) -> &'static str {
    find(INVERTED, lang, 0).unwrap_or("")
}
