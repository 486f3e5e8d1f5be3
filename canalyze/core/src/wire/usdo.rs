//! USDO, CANopen FD's service data (CiA 1301), in SDO's place on 600h/580h + the sender's node-ID.
//!
//! | command | 3 | 4-5 | 6 | 7 | 8.. |
//! |---|---|---|---|---|---|
//! | 01, 31 | sub-index | index | data type | number of data bytes | data, at most 56 bytes |
//! | 11, 21, 22 | sub-index | index | | | |
//! | 02, 32 | sub-index | index | data type | 0 | size of the whole, four bytes |
//! | 03, 33 | counter | 4-63: 60 bytes of data | | | |
//! | 13, 23 | counter | | | | |
//! | 04, 34 | number of data bytes | 4..: data | | | |
//! | 24 | | | | | |
//! | 7F | sub-index | index | abort code | | |
//!
//! Byte 0 is the destination's node-ID (0 = all), byte 1 the command specifier (bit 7: across networks), byte 2 the
//! session-ID. A response 21 may carry data as 31 does. The bytes of bulk transfer, of several sub-indices and of
//! remote commands are not public and left as they are. A frame is filled up to a length of CAN FD.

use super::prelude::*;
use crate::sdo::wire::Mux;
use crate::wire::message::Flaw;
use crate::world::od::DataType;

/// The abort command.
pub const ABORT: u8 = 0x7F;
/// The bit of a command that goes to another network.
const REMOTE: u8 = 0x80;
/// Data bytes of a segment that is not the last.
pub const SEGMENT: usize = 60;
const UNKNOWN: Bilingual = ("未知", "unknown");

/// Command specifiers without the remote bit (80h).
static COMMANDS: &[Term<u8>] = words!("usdo_commands");

/// Abort codes.
pub static ABORT_CODES: &[Term<u8>] = words!("usdo_abort_codes");

/// The fields of a frame by its command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body<'a> {
    /// An expedited transfer's data, with the code of their type; the frame may hold fewer than announced.
    Expedited(Mux, u8, u8, &'a [u8]),
    /// An object alone.
    Object(Mux),
    /// The begin of a segmented transfer: type and size in bytes.
    Initiate(Mux, u8, u32),
    /// A segment with its counter.
    Segment(u8, &'a [u8]),
    /// The counter of a segment that is requested or confirmed.
    Counter(u8),
    /// The last segment, with its announced number of bytes.
    Last(u8, &'a [u8]),
    /// The confirmation of the last segment.
    Confirmed,
    /// An abort and its code.
    Abort(Mux, u8),
    /// Bytes whose layout is not public.
    Undecoded,
    /// An unknown command, or a frame too short for its command.
    Unknown,
}

/// A frame of USDO.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pdu<'a> {
    /// The destination's node-ID, 0 = all.
    pub destination: u8,
    /// The command specifier.
    pub command: u8,
    /// The session-ID.
    pub session: u8,
    /// Its other fields.
    pub body: Body<'a>,
}

impl<'a> Pdu<'a> {
    /// Reads a payload; `None` if it has no session-ID.
    pub fn read(payload: &'a [u8]) -> Option<Self> {
        let [destination, command, session, rest @ ..] = payload else { return None };
        let (destination, command, session) = (*destination, *command, *session);
        Some(Self { destination, command, session, body: Body::read(command, rest) })
    }

    /// Returns the object that the frame names.
    pub fn mux(&self) -> Option<Mux> {
        match self.body {
            Body::Expedited(mux, ..) | Body::Object(mux) | Body::Initiate(mux, ..) | Body::Abort(mux, _) => Some(mux),
            _ => None,
        }
    }

    /// Returns true if a frame of this many bytes may be it: exactly as long, or filled up to a length of CAN FD, and
    /// with a session-ID that may be used.
    pub fn fits(&self, len: usize) -> bool {
        let own = match self.body {
            Body::Expedited(_, _, size, _) => 8 + usize::from(size),
            Body::Object(_) => 6,
            Body::Initiate(..) => 12,
            Body::Segment(..) => 4 + SEGMENT,
            Body::Counter(_) => 4,
            Body::Last(count, _) => 4 + usize::from(count),
            Body::Confirmed => 3,
            Body::Abort(..) => 7,
            Body::Undecoded => return self.session != 0,
            Body::Unknown => return false,
        };
        let filled = [8, 12, 16, 20, 24, 32, 48, 64].into_iter().find(|length| *length >= own);
        self.session != 0 && (len == own || Some(len) == filled)
    }
}

impl<'a> Body<'a> {
    /// Reads what is behind the session-ID.
    fn read(command: u8, rest: &'a [u8]) -> Self {
        let named = |rest: &[u8]| match *rest {
            [sub, low, high, ..] => Some(Mux { index: u16::from_le_bytes([low, high]), sub }),
            _ => None,
        };
        let held = |data: &'a [u8], size: u8| data.get(..usize::from(size)).unwrap_or(data);
        match (command, rest, named(rest)) {
            (0x05..=0x08 | 0x15 | 0x25 | 0x26 | 0x28 | 0x35 | REMOTE.., _, _) => Self::Undecoded,
            (0x01 | 0x31, [_, _, _, data_type, size, data @ ..], Some(mux)) => {
                Self::Expedited(mux, *data_type, *size, held(data, *size))
            }
            (0x21, [_, _, _, data_type, size, data @ ..], Some(mux))
                if *size > 0 && data.len() >= usize::from(*size) =>
            {
                Self::Expedited(mux, *data_type, *size, held(data, *size))
            }
            (0x02 | 0x32, [_, _, _, data_type, _, a, b, c, d, ..], Some(mux)) => {
                Self::Initiate(mux, *data_type, u32::from_le_bytes([*a, *b, *c, *d]))
            }
            (0x11 | 0x21 | 0x22, _, Some(mux)) => Self::Object(mux),
            (0x03 | 0x33, [counter, data @ ..], _) if !data.is_empty() => Self::Segment(*counter, held(data, 60)),
            (0x13 | 0x23, [counter, ..], _) => Self::Counter(*counter),
            (0x04 | 0x34, [count, data @ ..], _) => Self::Last(*count, held(data, *count)),
            (0x24, _, _) => Self::Confirmed,
            (ABORT, [_, _, _, code, ..], Some(mux)) => Self::Abort(mux, *code),
            _ => Self::Unknown,
        }
    }

    /// Returns the rows of its fields, and its data behind them.
    fn layout(self) -> (&'static [FieldRow], &'a [u8]) {
        match self {
            Self::Expedited(_, _, _, data) => (CARRYING, data),
            Self::Object(_) => (NAMED, &[]),
            Self::Initiate(..) => (INITIATING, &[]),
            Self::Segment(_, data) => (COUNTED, data),
            Self::Counter(_) => (COUNTED, &[]),
            Self::Last(_, data) => (LAST, data),
            Self::Abort(..) => (ABORTED, &[]),
            Self::Confirmed | Self::Undecoded | Self::Unknown => (&[], &[]),
        }
    }
}

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
    Breakdown::With(
        |out, lang, read| put!(out; ": ", find(ABORT_CODES, lang, read.byte()).unwrap_or(lang.word(UNKNOWN))),
    ),
    &[
        JsonKey::Hex("abort"),
        JsonKey::With(|object, read| object.optional("abort_name", find(ABORT_CODES, Lang::En, read.byte()))),
    ],
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
const RESERVED: FieldRow = byte(7, ("保留", "reserved"), Breakdown::Name, &[]);
const WHOLE_SIZE: FieldRow =
    field(8, 4, ("总长度(字节)", "size of the whole (bytes)"), Breakdown::Decimal, &[JsonKey::Decimal("size")]);
const COUNTER: FieldRow = byte(
    3,
    ("段计数器", "segment counter"),
    Breakdown::Decimal,
    &[
        JsonKey::Decimal("counter"),
        JsonKey::With(|object, read| {
            if read.payload.len() > 4 && matches!(read.payload.get(1), Some(0x03 | 0x33)) {
                object.bytes("data", data(read.payload));
            }
        }),
    ],
);
const COUNT: FieldRow = byte(
    3,
    ("数据长度(字节)", "size (bytes)"),
    Breakdown::Decimal,
    &[JsonKey::Decimal("size"), JsonKey::With(|object, read| object.bytes("data", data(read.payload)))],
);
static NAMED: &[FieldRow] = &[SUB, INDEX];
static ABORTED: &[FieldRow] = &[SUB, INDEX, ABORT_CODE];
static CARRYING: &[FieldRow] = &[SUB, INDEX, TYPE, SIZE];
static INITIATING: &[FieldRow] = &[SUB, INDEX, TYPE, RESERVED, WHOLE_SIZE];
static COUNTED: &[FieldRow] = &[COUNTER];
static LAST: &[FieldRow] = &[COUNT];

/// Returns the data; the rest of the frame is padding.
fn data(payload: &[u8]) -> &[u8] {
    Pdu::read(payload).map_or(&[], |pdu| pdu.body.layout().1)
}

/// Returns the name of a command; its remote bit is ignored.
fn command(lang: Lang, command: u8) -> Option<&'static str> {
    find(COMMANDS, lang, command & !REMOTE)
}

fn remote(lang: Lang, command: u8) -> &'static str {
    if command & REMOTE != 0 { lang.pick(" (远程网络)", " (remote network)") } else { "" }
}

/// Decodes an FD frame on an SDO identifier.
///
/// Devices exist that send SDO's own bytes in FD frames, with up to 60 bytes of data.
pub fn decode(role: Role, request: bool, source: u8, payload: &[u8]) -> Message {
    let is_sdo = |pdu: Pdu<'_>| !pdu.fits(payload.len()) && is_classic(payload);
    match *payload {
        _ if Pdu::read(payload).is_some_and(is_sdo) => Message::Malformed { role, flaw: Flaw::Fd },
        [destination, command, ..] => Message::Usdo { request, source, destination, command },
        _ => length(role, 2, 64),
    }
}

/// Returns true for an initiate or an abort of SDO about an object that devices have.
fn is_classic(payload: &[u8]) -> bool {
    let [command, low, high, _, _, ..] = *payload else { return false };
    let object = (0x1000..0xC000).contains(&u16::from_le_bytes([low, high]));
    object && matches!(command, 0x20..=0x23 | 0x27 | 0x2B | 0x2F | 0x40..=0x43 | 0x47 | 0x4B | 0x4F | 0x60 | 0x80)
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
        let Some(pdu) = Pdu::read(frame.payload()) else { return };
        put!(out; lang.pick(", 会话=", ", session="), pdu.session);
        if let Some(mux) = pdu.mux() {
            put!(out; ", ", mux);
        }
        let size = |size: u64| Size(lang, size);
        match pdu.body {
            Body::Expedited(_, data_type, announced, data) => {
                put!(out; ", ", Typed(lang, data_type), ", ", size(announced.into()));
                put!(out; if data.is_empty() { "" } else { ": " }, Spaced(data));
            }
            Body::Initiate(_, data_type, whole) => {
                let (typed, whole) = (Typed(lang, data_type), size(whole.into()));
                say!(out, lang; zh: ", ", typed, ", 共", whole; en: ", ", typed, ", ", whole, " in all");
            }
            Body::Segment(counter, data) => {
                let bytes = size(data.len() as u64);
                say!(out, lang; zh: ", 计数器=", counter, ", ", bytes; en: ", counter=", counter, ", ", bytes);
            }
            Body::Counter(counter) => say!(out, lang; zh: ", 计数器=", counter; en: ", counter=", counter),
            Body::Last(count, _) => put!(out; ", ", size(count.into())),
            Body::Abort(_, code) => {
                let meaning = find(ABORT_CODES, lang, code).unwrap_or(lang.word(UNKNOWN));
                put!(out; lang.pick(", 中止码 ", ", abort code "), Hex::<2>(u64::from(code)), "h ", meaning);
            }
            Body::Undecoded => put!(out; lang.pick(" (其余字节未解码)", " (other bytes not decoded)")),
            Body::Object(_) | Body::Confirmed | Body::Unknown => {}
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
        fields::lines(out, lang, &[DESTINATION, COMMAND], message, frame);
        let payload = frame.payload();
        let Some(pdu) = Pdu::read(payload) else { return };
        fields::lines(out, lang, &[SESSION], message, frame);
        let (fields, data) = pdu.body.layout();
        if fields.is_empty() && pdu.body != Body::Confirmed {
            return fields::data(out, lang, payload.get(3..).unwrap_or_default());
        }
        fields::lines(out, lang, fields, message, frame);
        fields::data(out, lang, data);
        let padding = payload.get(fields::end(fields).max(3) + data.len()..).unwrap_or_default();
        if !padding.is_empty() {
            fields::line!(out; Spaced(padding), lang.pick("  填充", "  padding"));
        }
    }

    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        let Message::Usdo { request, .. } = *message else { return };
        object.flag("request", request);
        fields::json(object, &[DESTINATION, COMMAND], message, frame);
        let Some(pdu) = Pdu::read(frame.payload()) else { return object.maybe("session", None::<u8>) };
        fields::json(object, &[SESSION], message, frame);
        fields::json(object, pdu.body.layout().0, message, frame);
    }
}

/// The name of a data type by its code.
struct Typed(Lang, u8);

impl Put for Typed {
    fn put(&self, out: &mut Vec<u8>) {
        put!(out; self.0.pick("类型 ", "type "));
        match DataType::from_code(u16::from(self.1)) {
            Some(known) => put!(out; known.name()),
            None => put!(out; Hex::<2>(u64::from(self.1)), "h"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::lang::tests::sound;

    fn body(payload: &[u8]) -> Body<'_> {
        Pdu::read(payload).map_or(Body::Unknown, |pdu| pdu.body)
    }

    #[test]
    fn expedited_download() {
        let payload = [5, 0x01, 7, 0x01, 0x00, 0x20, 0x07, 4, 0x2A, 0, 0, 0];
        assert_eq!(
            decode(Role::SdoRequest(10), true, 10, &payload),
            Message::Usdo { request: true, source: 10, destination: 5, command: 1 }
        );
        let padded = [payload.as_slice(), &[0; 4]].concat();
        let object = Mux { index: 0x2000, sub: 1 };
        assert_eq!(body(&padded), Body::Expedited(object, 7, 4, &[0x2A, 0, 0, 0]));
        assert_eq!(body(&[7, 0x21, 7, 1, 0, 0x20]), Body::Object(object));
        assert_eq!(body(&[7, 0x21, 7, 1, 0, 0x20, 0, 0]), Body::Object(object));
        assert_eq!(body(&[7, 0x21, 7, 1, 0, 0x20, 0x0F, 2, 1, 2, 0, 0]), Body::Expedited(object, 15, 2, &[1, 2]));
    }

    #[test]
    fn segmented() {
        let object = Mux { index: 0x2E00, sub: 13 };
        assert_eq!(body(&[0x7E, 0x32, 0x13, 13, 0, 0x2E, 15, 0, 0x3D, 0, 0, 0]), Body::Initiate(object, 15, 61));
        assert_eq!(body(&[5, 0x13, 0x13, 2]), Body::Counter(2));
        let segment = [[0x7E, 0x33, 0x13, 0].as_slice(), &[9; 60]].concat();
        assert_eq!(body(&segment), Body::Segment(0, &[9; 60]));
        assert_eq!(body(&[0x7E, 0x34, 0x13, 1, 0x80, 0, 0, 0]), Body::Last(1, &[0x80]));
        assert_eq!(body(&[0x7E, 0x24, 0x13]), Body::Confirmed);
    }

    #[test]
    fn what_is_not_public_and_what_is_short() {
        sound(COMMANDS);
        sound(ABORT_CODES);
        let object = Mux { index: 0x2000, sub: 0 };
        assert_eq!(body(&[5, 0x7F, 7, 0, 0x00, 0x20, 0x33]), Body::Abort(object, 0x33));
        assert_eq!(body(&[5, 0x7F, 7, 0, 0x00, 0x20]), Body::Unknown);
        assert_eq!(body(&[5, 0x06, 7, 0, 0x00, 0x20, 0, 0, 8, 0, 0, 0]), Body::Undecoded);
        assert_eq!(body(&[5, 0x81, 7, 0, 0, 0, 0, 0]), Body::Undecoded);
        assert_eq!(body(&[5, 0x01, 7]), Body::Unknown);
        assert_eq!(Pdu::read(&[5, 0x01]), None);
        assert_eq!(decode(Role::SdoRequest(10), true, 10, &[5]), length(Role::SdoRequest(10), 2, 64));
    }

    #[test]
    fn lengths() {
        let fits = |payload: &[u8], len| Pdu::read(payload).is_some_and(|pdu| pdu.fits(len));
        let read = [5, 0x11, 1, 1, 0x18, 0x10, 0, 0];
        assert!(fits(&read, 6) && fits(&read, 8) && !fits(&read, 12));
        // An upload request of SDO in an FD frame.
        assert!(!fits(&[0x40, 0x18, 0x10, 0x01, 0, 0, 0, 0], 8));
        assert!(!fits(&[5, 0x11, 0, 1, 0x18, 0x10], 6));
    }
}
