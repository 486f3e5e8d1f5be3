//! Short names of services, as a list of communication objects has them.

use super::{Row, find};
use crate::words::Lang;

/// Services by their names in filters and JSON.
pub static SERVICES: &[Row<&str>] = words!("services");

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
