//! USDO, CANopen FD's service data (CiA 1301), in SDO's place on 600h/580h + the sender's node-ID.
//!
//! | byte | field |
//! |---|---|
//! | 0 | destination node-ID, 0 = all |
//! | 1 | command specifier; bit 7: remote (across networks) |
//! | 2 | session-ID |
//! | 3 | sub-index |
//! | 4-5 | index |
//! | 6 | data type, or the abort code |
//! | 7 | size of the data in bytes |
//! | 8.. | data, at most 56 bytes |
//!
//! Only the first three bytes are common to all commands; the others stand where a command names an object. Open
//! sources are few, so what is not certain (segments, bulk transfer) is left as bytes.

use super::prelude::*;
use crate::world::od::DataType;

/// The abort command.
const ABORT: u8 = 0x7F;
/// The bit of a command that goes to another network.
const REMOTE: u8 = 0x80;
const UNKNOWN: Bilingual = ("未知", "unknown");

/// Command specifiers without the remote bit (80h).
static COMMANDS: &[Term<u8>] = words!("usdo_commands");

/// Abort codes.
const ABORTS: &[Term<u8>] = words!("usdo_abort_codes");

const fn byte(at: usize, name: Bilingual, shown: Breakdown, json: &'static [JsonKey]) -> FieldRow {
    field(at, 1, name, shown, json)
}

const DESTINATION: FieldRow = byte(
    0,
    ("目标节点ID", "destination node-ID"),
    Breakdown::With(|out, lang, read| match read.byte() {
        0 => put!(out; lang.pick(": 所有节点", ": all nodes")),
        node => put!(out; ": ", node),
    }),
    &[JsonKey::Decimal("destination")],
);
const COMMAND: FieldRow = byte(
    1,
    ("命令字", "command specifier"),
    Breakdown::With(|out, lang, read| {
        put!(out; ": ", command(lang, read.byte()).unwrap_or(lang.word(UNKNOWN)), remote(lang, read.byte()));
    }),
    &[
        JsonKey::Hex("command"),
        JsonKey::With(|object, read| object.optional("name", command(Lang::En, read.byte()))),
        JsonKey::With(|object, read| object.flag("remote_network", read.byte() & REMOTE != 0)),
    ],
);
const SESSION: FieldRow = byte(2, ("会话ID", "session-ID"), Breakdown::Decimal, &[JsonKey::Decimal("session")]);
/// The sub-index comes before the index, other than in SDO, but not in JSON.
const SUB: FieldRow =
    byte(3, ("子索引", "sub-index "), Breakdown::With(|out, _, read| put!(out; Hex::<2>(read.value.into()), "h")), &[]);
const INDEX: FieldRow = field(
    4,
    2,
    ("索引", "index "),
    Breakdown::With(
        |out, lang, read| put!(out; Hex::<4>(read.value.into()), lang.pick("h (小端格式)", "h (little-endian)")),
    ),
    &[JsonKey::Hex("index"), JsonKey::With(|object, read| object.maybe("sub", read.payload.get(3).copied()))],
);
const ABORT_CODE: FieldRow = byte(
    6,
    ("中止码", "abort code"),
    Breakdown::Word(ABORTS, UNKNOWN),
    &[JsonKey::Hex("abort"), JsonKey::Name("abort_name", ABORTS)],
);
const TYPE: FieldRow = byte(
    6,
    ("数据类型", "data type"),
    Breakdown::With(|out, _, read| put!(out; ": ", DataType::from_code(read.value as u16).map_or("-", DataType::name))),
    &[JsonKey::Hex("type")],
);
const SIZE: FieldRow = byte(
    7,
    ("数据长度(字节)", "size (bytes)"),
    Breakdown::Decimal,
    &[JsonKey::Decimal("size"), JsonKey::With(|object, read| object.bytes("data", data(read.payload)))],
);
static NAMED: &[FieldRow] = &[SUB, INDEX];
static ABORTED: &[FieldRow] = &[SUB, INDEX, ABORT_CODE];
static CARRYING: &[FieldRow] = &[SUB, INDEX, TYPE, SIZE];

/// Returns the fields of the object that a command names; none if it names none, or the frame is too short.
fn object(payload: &[u8]) -> &'static [FieldRow] {
    let [_, command, _, _, _, _, rest @ ..] = payload else { return &[] };
    match (command & !REMOTE, rest) {
        (ABORT, [_, ..]) => ABORTED,
        (0x01 | 0x31 | 0x02 | 0x32 | 0x06, [_, _, ..]) => CARRYING,
        (0x01 | 0x31 | 0x02 | 0x32 | 0x06 | 0x11 | 0x21 | 0x22 | 0x26 | ABORT, _) => NAMED,
        _ => &[],
    }
}

/// Returns the data, up to the stated size; the rest of the frame is padding.
fn data(payload: &[u8]) -> &[u8] {
    let data = payload.get(8..).unwrap_or_default();
    payload.get(7).and_then(|size| data.get(..usize::from(*size))).unwrap_or(data)
}

/// Returns the name of a command; its remote bit is ignored.
fn command(lang: Lang, command: u8) -> Option<&'static str> {
    find(COMMANDS, lang, command & !REMOTE)
}

fn remote(lang: Lang, command: u8) -> &'static str {
    if command & REMOTE != 0 { lang.pick(" (远程网络)", " (remote network)") } else { "" }
}

/// Decodes an FD frame on an SDO identifier.
pub fn decode(role: Role, request: bool, source: u8, payload: &[u8]) -> Message {
    match *payload {
        [destination, command, ..] => Message::Usdo { request, source, destination, command },
        _ => length(role, 2, 64),
    }
}

/// The forms of a USDO frame.
pub(super) struct UsdoService;

impl WireService for UsdoService {
    /// `USDO请求, 节点10 -> 节点5: 加速下载请求, 会话=7, 2000h:01, 类型 UNSIGNED32, 4字节: 2A 00 00 00`.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, frame: &Frame) {
        let Message::Usdo { request, source, destination, command } = *message else { return };
        let what =
            if request { lang.pick("USDO请求", "USDO request") } else { lang.pick("USDO响应", "USDO response") };
        put!(out; what, lang.pick(", 节点", ", node "), source, " -> ", Nodes(lang, destination));
        if !full {
            return;
        }
        match self::command(lang, command) {
            Some(word) => put!(out; ": ", word),
            None => {
                let unknown = lang.pick(": 未知命令字 ", ": unknown command specifier ");
                put!(out; unknown, Hex::<2>(u64::from(command)), "h");
            }
        }
        put!(out; remote(lang, command));
        let payload = frame.payload();
        if let Some(session) = payload.get(2) {
            put!(out; lang.pick(", 会话=", ", session="), *session);
        }
        let (fields @ [_, ..], [_, _, _, sub, low, high, rest @ ..]) = (object(payload), payload) else { return };
        put!(out; ", ", Hex::<4>(u64::from(u16::from_le_bytes([*low, *high]))), "h:", Hex::<2>(u64::from(*sub)));
        match (fields::end(fields), rest) {
            (7, [code, ..]) => {
                let meaning = find(ABORTS, lang, *code).unwrap_or(lang.word(UNKNOWN));
                put!(out; lang.pick(", 中止码 ", ", abort code "), Hex::<2>(u64::from(*code)), "h ", meaning);
            }
            (8, [data_type, size, ..]) => {
                put!(out; lang.pick(", 类型 ", ", type "));
                match DataType::from_code(u16::from(*data_type)) {
                    Some(known) => put!(out; known.name()),
                    None => put!(out; Hex::<2>(u64::from(*data_type)), "h"),
                }
                let data = data(payload);
                put!(out; ", ", Size(lang, u64::from(*size)), if data.is_empty() { "" } else { ": " }, Spaced(data));
            }
            _ => {}
        }
    }

    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        let Message::Usdo { request, source, .. } = *message else { return };
        put!(out; "#   COB-ID ", Hex::<3>(u64::from(frame.id.raw())), if request { "h = 600h + " } else { "h = 580h + " });
        put!(out; lang.pick("源节点ID ", "source node-ID "), Hex::<2>(u64::from(source)), "h (", source, "): ");
        put!(out; if request {
            lang.pick("USDO请求, 客户端 -> 服务器\n", "USDO request, client -> server\n")
        } else {
            lang.pick("USDO响应, 服务器 -> 客户端\n", "USDO response, server -> client\n")
        });
        let (payload, fields) = (frame.payload(), object(frame.payload()));
        fields::lines(out, lang, &[DESTINATION, COMMAND], message, frame);
        if payload.len() > 2 {
            fields::lines(out, lang, &[SESSION], message, frame);
        }
        if fields.is_empty() {
            return fields::data(out, lang, payload.get(3..).unwrap_or_default());
        }
        fields::lines(out, lang, fields, message, frame);
        let data = if fields::end(fields) == 8 { data(payload) } else { &[] };
        fields::data(out, lang, data);
        fields::reserved(out, lang, payload.get(fields::end(fields) + data.len()..).unwrap_or_default());
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        let Message::Usdo { request, .. } = *message else { return };
        object.flag("request", request);
        fields::json(object, &[DESTINATION, COMMAND], message, frame);
        match frame.len {
            2 => object.maybe("session", None::<u8>),
            _ => fields::json(object, &[SESSION], message, frame),
        }
        fields::json(object, self::object(frame.payload()), message, frame);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::lang::tests::sound;

    #[test]
    fn expedited_download() {
        let payload = [5, 0x01, 7, 0x01, 0x00, 0x20, 0x07, 4, 0x2A, 0, 0, 0];
        assert_eq!(
            decode(Role::SdoRequest(10), true, 10, &payload),
            Message::Usdo { request: true, source: 10, destination: 5, command: 1 }
        );
        assert_eq!(fields::end(object(&payload)), 8);
        assert_eq!(data(&[payload.as_slice(), &[0; 4]].concat()), [0x2A, 0, 0, 0]);
    }

    #[test]
    fn aborts_and_short_frames() {
        sound(COMMANDS);
        sound(ABORTS);
        assert_eq!(fields::end(object(&[5, 0x7F, 7, 0, 0x00, 0x20, 0x33])), 7);
        assert_eq!(fields::end(object(&[5, 0x7F, 7, 0, 0x00, 0x20])), 6);
        assert!(object(&[5, 0x03, 7, 0, 0, 0, 0, 0]).is_empty());
        assert!(object(&[5, 0x01, 7]).is_empty());
        assert_eq!(decode(Role::SdoRequest(10), true, 10, &[5]), length(Role::SdoRequest(10), 2, 64));
    }
}
