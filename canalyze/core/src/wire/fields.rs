//! Rows of fields: the bytes of a message, and how each form shows them.
//!
//! The breakdown and the JSON object of a message follow from its rows, in their order.

use crate::bytes::frame::Frame;
use crate::tables::jsonl::object::Object;
use crate::wire::message::Message;
use crate::words::digits::{Hex, Nibbles, Spaced, hex, put};
use crate::words::lang::{Bilingual, Lang, Size, Term, find};

/// One field of a message.
#[derive(Clone, Copy)]
pub(super) struct FieldRow {
    /// The position of its first byte.
    at: usize,
    /// The number of its bytes; they are little-endian.
    width: usize,
    /// Its name in the breakdown.
    pub(super) name: Bilingual,
    /// How the breakdown shows its value.
    shown: Breakdown,
    /// Its keys in JSON.
    json: &'static [JsonKey],
}

/// The value of a field in a frame.
pub(super) struct FieldValue<'a> {
    /// The message.
    pub(super) message: &'a Message,
    /// The payload of its frame.
    pub(super) payload: &'a [u8],
    /// The value.
    pub(super) value: u32,
}

/// Appends a value in a form of its own.
type Written = fn(&mut Vec<u8>, Lang, &FieldValue<'_>);

/// How the breakdown shows a value behind its bytes.
#[derive(Clone, Copy)]
pub(super) enum Breakdown {
    /// The name alone.
    Name,
    /// `name = 5`.
    Decimal,
    /// `name 12345678h (little-endian)`.
    Little,
    /// `name: word`, with the word for a value without a term.
    Word(&'static [Term<u8>], Bilingual),
    /// `= 0001 0001b  name  bit 0: 1 word | bit 4: 1 word`, with the words for 0.
    Flags(&'static [Term<u8>], Bilingual),
    /// The name and what the function appends.
    With(Written),
    /// What the function appends.
    Only(Written),
}

/// One key of a field in JSON.
#[derive(Clone, Copy)]
pub(super) enum JsonKey {
    /// A number.
    Decimal(&'static str),
    /// A hexadecimal string.
    Hex(&'static str),
    /// The English term of the value, or null.
    Name(&'static str, &'static [Term<u8>]),
    /// What the function appends.
    With(fn(&mut Object<'_>, &FieldValue<'_>)),
}

/// Makes a field of `width` bytes.
pub(super) const fn field(
    at: usize,
    width: usize,
    name: Bilingual,
    shown: Breakdown,
    json: &'static [JsonKey],
) -> FieldRow {
    FieldRow { at, width, name, shown, json }
}

impl FieldRow {
    /// Returns the bytes of the field; fewer if the payload ends before.
    fn bytes(self, payload: &[u8]) -> &[u8] {
        let rest = payload.get(self.at..).unwrap_or_default();
        rest.get(..self.width).unwrap_or(rest)
    }

    fn read<'a>(self, message: &'a Message, payload: &'a [u8]) -> FieldValue<'a> {
        let value = self.bytes(payload).iter().take(4).rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
        FieldValue { message, payload, value }
    }
}

impl FieldValue<'_> {
    /// Returns the value of a field of one byte.
    pub(super) fn byte(&self) -> u8 {
        self.value as u8
    }
}

/// Returns the number of bytes up to the end of the last field.
pub(super) fn end(fields: &[FieldRow]) -> usize {
    fields.last().map_or(0, |last| last.at + last.width)
}

/// Appends the keys of all fields.
pub(super) fn json(object: &mut Object<'_>, fields: &[FieldRow], message: &Message, frame: &Frame) {
    for field in fields {
        let read = field.read(message, frame.payload());
        for key in field.json {
            match *key {
                JsonKey::Decimal(key) => object.number(key, read.value),
                JsonKey::Hex(key) => {
                    put!(object.key(key); "\"", |out: &mut Vec<u8>| hex(out, u64::from(read.value), 2 * field.width), "\"")
                }
                JsonKey::Name(key, terms) => object.optional(key, find(terms, Lang::En, read.byte())),
                JsonKey::With(written) => written(object, &read),
            }
        }
    }
}

/// Appends the breakdown: a line for each field, then the bytes that no field has.
pub(super) fn breakdown(out: &mut Vec<u8>, lang: Lang, fields: &[FieldRow], message: &Message, frame: &Frame) {
    breakdown_from(out, lang, 0, fields, message, frame);
}

/// Appends the breakdown of a frame whose first bytes are shown already.
pub(super) fn breakdown_from(
    out: &mut Vec<u8>,
    lang: Lang,
    first: usize,
    fields: &[FieldRow],
    message: &Message,
    frame: &Frame,
) {
    lines(out, lang, fields, message, frame);
    reserved(out, lang, frame.payload().get(end(fields).max(first)..).unwrap_or_default());
}

/// Appends a line of the breakdown for each field.
pub(super) fn lines(out: &mut Vec<u8>, lang: Lang, fields: &[FieldRow], message: &Message, frame: &Frame) {
    let payload = frame.payload();
    for field in fields {
        put!(out; "#   ", Spaced(field.bytes(payload)));
        shown(out, lang, *field, &field.read(message, payload));
        put!(out; "\n");
    }
}

fn shown(out: &mut Vec<u8>, lang: Lang, field: FieldRow, read: &FieldValue<'_>) {
    let name = lang.word(field.name);
    match field.shown {
        Breakdown::Name => put!(out; "  ", name),
        Breakdown::Decimal => put!(out; "  ", name, " = ", read.value),
        Breakdown::Little => {
            put!(out; "  ", name, " ");
            hex(out, u64::from(read.value), 2 * field.width);
            put!(out; lang.pick("h (小端格式)", "h (little-endian)"));
        }
        Breakdown::Word(terms, none) => {
            put!(out; "  ", name, ": ", find(terms, lang, read.byte()).unwrap_or(lang.word(none)));
        }
        Breakdown::Flags(terms, none) => flags(out, lang, name, read.byte(), terms, none),
        Breakdown::With(written) => {
            put!(out; "  ", name);
            written(out, lang, read);
        }
        Breakdown::Only(written) => written(out, lang, read),
    }
}

/// Iterates over the bits of a byte that are set, lowest first.
pub(super) fn set_bits(byte: u8) -> impl Iterator<Item = u8> {
    (0..8).filter(move |bit| byte & 1 << bit != 0)
}

/// Appends a byte of flags: ` = 0001 0001b  name  bit 0: 1 word | bit 4: 1 word`.
fn flags(out: &mut Vec<u8>, lang: Lang, name: &'static str, byte: u8, terms: &'static [Term<u8>], none: Bilingual) {
    put!(out; " = ", Nibbles(byte), "  ", name);
    let mut between = "  ";
    for bit in set_bits(byte) {
        let word = find(terms, lang, bit).unwrap_or_default();
        put!(out; between, lang.pick("位", "bit "), bit, ": 1 ", word);
        between = " | ";
    }
    if byte == 0 {
        put!(out; "  ", lang.word(none));
    }
}

/// Appends one line of a breakdown.
macro_rules! line {
    ($out:expr; $($part:expr),+ $(,)?) => { $crate::words::digits::put!($out; "#   ", $($part),+, "\n") };
}
pub(crate) use line;

/// Appends data bytes, sixteen a line: `#   9C FF FF FF  数据(4字节)`.
pub(crate) fn data(out: &mut Vec<u8>, lang: Lang, bytes: &[u8]) {
    for chunk in bytes.chunks(16) {
        put!(out; "#   ", Spaced(chunk), lang.pick("  数据(", "  data ("), Size(lang, chunk.len() as u64), ")");
        ascii(out, chunk);
        put!(out; "\n");
    }
}

/// Appends the bytes as text, in quotes, if all of them are printable ASCII.
fn ascii(out: &mut Vec<u8>, bytes: &[u8]) {
    if bytes.iter().all(|byte| (0x20..0x7F).contains(byte)) {
        put!(out; " \"");
        out.extend_from_slice(bytes);
        put!(out; "\"");
    }
}

/// Appends bytes that a frame has beyond its fields.
pub(crate) fn reserved(out: &mut Vec<u8>, lang: Lang, bytes: &[u8]) {
    if !bytes.is_empty() {
        line!(out; Spaced(bytes), lang.pick("  保留", "  reserved"));
    }
}

/// Appends a node-ID: `  节点ID 0Ah (10)`.
pub(crate) fn node_id(out: &mut Vec<u8>, lang: Lang, node: u8) {
    put!(out; lang.pick("  节点ID ", "  node-ID "), Hex::<2>(u64::from(node)), "h (", node, ")");
    if node > 127 {
        put!(out; lang.pick(" 无效", " invalid"));
    }
}

/// Appends the line of a remote frame.
pub(crate) fn requested(out: &mut Vec<u8>, lang: Lang, len: u8) {
    let words = lang.pick("远程帧: 无数据, 请求长度(字节)=", "remote frame: no data, requested length (bytes)=");
    line!(out; words, len);
}
