//! `transfers`: one row per SDO transfer that has ended, in the order in which they end.
//!
//! Of an ok transfer the exact value is the first of `string`, `boolean`, `integer`, `raw` and `value` that is not
//! null; all of them are null where the bytes are no value of a simple type. `data` are the bytes kept, the first
//! 65536. CSV is the same in every language. Must not: judge a transfer.

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::sdo::transfer::{Hole, Status, Transfer};
use crate::tables::csv;
use crate::tables::jsonl::sdo::{abort_or_null, side};
use crate::tables::setting::{NAMES, Setting};
use crate::tables::table::{
    AbortDigits, Any, Bytes, Codes, Cx, Duration, Hex4, I64, List, Moment, Name, Real, Text, Truth, Typed, U8, U32,
    U64, Utf8, Word, list, table,
};
use crate::words::digits::put;
use crate::words::{Lang, terms, transferred};
use crate::world::configuration;
use crate::world::od::{self, DataType, Value};

/// A transfer that has ended, and its value as far as that is known by its type.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Ended<'a> {
    transfer: &'a Transfer,
    data_type: Option<DataType>,
    value: Value<'a>,
}

impl<'a> Ended<'a> {
    fn new(transfer: &'a Transfer) -> Self {
        let data_type = transfer.data_type();
        let kept: &[u8] = if transfer.outcome.status == Status::Ok { &transfer.data.kept } else { &[] };
        Self { transfer, data_type, value: od::decode(data_type, kept) }
    }

    /// The bytes of its value, or of the value that a write asked for without success.
    fn bytes(self, ok: bool) -> &'a [u8] {
        let Self { transfer: Transfer { data, outcome, .. }, .. } = self;
        match (ok, outcome.status == Status::Ok) {
            (true, true) => &data.kept,
            (false, false) => &data.requested,
            _ => &[],
        }
    }
}

table! {
    /// One row per SDO transfer.
    /// 一行是一次SDO传输
    Transfers arrow "transfers" json "transfer", |cx, one: Ended<'_>| {
        transfer: U64 = one.transfer.id.0;
        bus: Name or null = cx.setting.bus(one.transfer.bus);
        node: U8 = one.transfer.node;
        /// node-ID of the client of a USDO transfer; null for SDO
        /// USDO传输的客户端节点ID；SDO为null
        client: U8 or null = one.transfer.session.map(|session| session.client);
        /// session-ID of a USDO transfer; null for SDO
        /// USDO传输的会话ID；SDO为null
        session: U8 or null = one.transfer.session.map(|session| session.id);
        /// download writes, upload reads
        /// download 写，upload 读
        direction: Word = one.transfer.direction.name();
        /// expedited, segmented or block
        /// expedited、segmented、block
        mode: Word = one.transfer.mode.name();
        index: Hex4 or null = one.transfer.mux.map(|mux| mux.index);
        sub: U8 or null = one.transfer.mux.map(|mux| mux.sub);
        object: Word or null in arrow = object(one.transfer).as_deref();
        name: Name or null = cx.object(one.transfer.mux, &one.transfer.described);
        r#type as "type": Word or null = one.data_type.map(DataType::name);
        /// indicated size, in bytes
        /// 声明的长度，字节
        size_indicated: U32 or null = one.transfer.data.size_indicated;
        /// transferred size, in bytes
        /// 实际传输的长度，字节
        size: U64 = one.transfer.data.size;
        data: Bytes = one.transfer.data.kept.as_slice();
        /// value of a string type
        /// 值：字符串类型
        string: Utf8 or null in arrow = if let Value::Text(text) = one.value { Some(text) } else { None };
        /// value of a boolean type
        /// 值：布尔类型
        boolean: Truth or null in arrow = if let Value::Bool(on) = one.value { Some(on) } else { None };
        integer: I64 or null in arrow = integer(one.value);
        raw: U64 or null in arrow = raw(one);
        value: Real or null in arrow = real(one.value);
        value_shown as "value": Typed or null in json = (one.data_type, one.bytes(true));
        /// value of a write that was not confirmed
        /// 未得到确认的写入值
        requested: Typed or null in json = (one.data_type, one.bytes(false));
        text: Text = |out: &mut Vec<u8>| transferred::transferred(out, cx.setting.lang, one.transfer);
        /// ok, aborted, incomplete or failed
        /// ok、aborted、incomplete、failed
        status: Word = one.transfer.outcome.status.name();
        /// code of the abort, who aborted, and its meaning
        /// 中止码、中止方和中止原因
        abort: Any or null in json = |out: &mut Vec<u8>| abort_or_null(out, cx.setting.lang, one.transfer.outcome.abort);
        /// abort code
        /// 中止码
        abort_code: AbortDigits or null in arrow = one.transfer.outcome.abort.map(|abort| abort.code);
        /// who aborted: client or server
        /// 中止方 client、server
        abort_by: Word or null in arrow = one.transfer.outcome.abort.map(|abort| side(abort.by));
        /// meaning of the abort code
        /// 中止原因
        abort_text: Word or null in arrow = abort_text(cx, one.transfer);
        /// first frame
        /// 第一帧
        first_frame: U64 = one.transfer.first.no;
        /// last frame
        /// 最后一帧
        last_frame: U64 = one.transfer.last.no;
        /// line of the first frame
        /// 第一帧的行号
        first_line: U64 or null in arrow = one.transfer.first.line();
        /// line of the last frame
        /// 最后一帧的行号
        last_line: U64 or null in arrow = one.transfer.last.line();
        t: Moment or null = one.transfer.first.t_ns;
        /// from the request to the end
        /// 从请求到结束
        duration: Duration or null = one.transfer.duration_ns();
        /// its frames were recorded out of order; this was corrected
        /// 记录中帧的次序颠倒过，已纠正
        reordered: Truth = one.transfer.outcome.reordered;
        /// segments sent again in a block transfer
        /// 块传输中重发的段数
        retransmissions: U32 = one.transfer.outcome.retransmissions;
        /// a CRC was agreed on for the block transfer
        /// 块传输约定了CRC
        crc_negotiated: Truth or null = one.transfer.outcome.crc_negotiated;
        findings: Codes = one.transfer.outcome.findings.as_slice();
        /// missing bytes: offset in the data, and length; of an unknown length (null) they take no room in the data
        /// 缺少的字节：在数据中的偏移和长度；长度未知（null）时不占数据
        holes: List in optional = holes(one.transfer.data.holes.list());
    }
    csv [
        transfer, t, bus, node, client, session, direction, mode, object, name, r#type, value_shown, size, status, abort_by, abort_code,
        duration, first_frame, last_frame, findings, data,
    ]
}

impl Collector for Table<Transfers> {
    fn transfer(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, transfer: &Transfer) {
        self.row(done, &scene.cx(), Ended::new(transfer));
    }

    fn table(&mut self) -> &mut dyn Ends {
        self
    }
}

/// Appends a transfer's JSON line. `names`: the language of the object's name where only the standard names it.
pub fn line(out: &mut Vec<u8>, setting: Setting<'_>, transfer: &Transfer, names: Lang) {
    Transfers::json(out, &Cx { setting, names }, Ended::new(transfer));
    out.push(b'\n');
}

/// Appends the headings of CSV.
pub fn head(out: &mut Vec<u8>) {
    csv::headings(out, Transfers::HEADINGS);
}

/// Appends a transfer's row of CSV.
pub fn row(out: &mut Vec<u8>, setting: Setting<'_>, transfer: &Transfer) {
    Transfers::csv(out, &Cx { setting, names: NAMES }, Ended::new(transfer));
}

fn object(one: &Transfer) -> Option<String> {
    one.mux.map(|mux| format!("{:04X}:{:02X}", mux.index, mux.sub))
}

fn abort_text(cx: &Cx<'_>, one: &Transfer) -> Option<&'static str> {
    one.outcome.abort.and_then(|abort| terms::abort_code(cx.setting.lang, abort.code))
}

/// Returns a function that appends the holes, where there are any.
fn holes(holes: &[Hole]) -> Option<impl FnOnce(&mut Vec<u8>)> {
    let write = move |out: &mut Vec<u8>| {
        list(out, holes, |out, hole| {
            put!(out; "{\"offset\":", hole.offset, ",\"length\":");
            match hole.length {
                Some(length) => put!(out; length, "}"),
                None => put!(out; "null}"),
            }
        });
    };
    (!holes.is_empty()).then_some(write)
}

fn integer(value: Value<'_>) -> Option<i64> {
    match value {
        Value::Bool(on) => Some(i64::from(on)),
        Value::Signed(number) => Some(number),
        Value::Unsigned(number) => i64::try_from(number).ok(),
        _ => None,
    }
}

fn raw(one: Ended<'_>) -> Option<u64> {
    match one.value {
        Value::Bool(_) | Value::Signed(_) => configuration::number(&one.transfer.data.kept),
        Value::Unsigned(number) => Some(number),
        _ => None,
    }
}

fn real(value: Value<'_>) -> Option<f64> {
    match value {
        Value::Bool(on) => Some(f64::from(u8::from(on))),
        Value::Signed(number) => Some(number as f64),
        Value::Unsigned(number) => Some(number as f64),
        Value::Real(number) => Some(number),
        _ => None,
    }
}
