//! `od`: one row per object of a node that the capture shows, as `canalyze od` lists them.
//!
//! All rows come at the end. `value` has sign, type and factor applied, `integer` is the same exactly where it is a
//! whole number without factor; in JSON and CSV `value` is without unit and factor. `aborts` of CSV are
//! `download:06010002:3` (request, code, count) with blanks between. CSV is the same in every language. Must not: decide
//! anything.

use std::borrow::Cow;

use super::column::{Batch, Table};
use super::signals::numbers;
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::{BusId, Frame};
use crate::sdo::transfer::{Direction, Transfer};
use crate::sdo::wire::Mux;
use crate::tables::csv;
use crate::tables::jsonl::sdo::{json_value, side};
use crate::tables::setting::{NAMES, Setting, quoted};
use crate::tables::table::{
    Bytes, ColumnKind, Cx, Hex4, I64, InJson, Json, List, MaybeText, Moment, Name, Piece, Real, Truth, U8, U32s, U64,
    Word, list, table,
};
use crate::views::inventory::sighting::{Content, Source};
use crate::views::inventory::{HeldValue, InForce, Inventory, NodeObjects, ObservedObject, TypeFrom};
use crate::wire::pdo::mapping::{Mapped, Number, extract, number};
use crate::words::digits::{Hex, Joined, put};
use crate::words::{Lang, escape, inventory, terms};
use crate::world::bus::Bus;
use crate::world::event::Event;
use crate::world::od::{self, DataType};

/// An object of a node.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Owned<'a> {
    bus: BusId,
    node: u8,
    mux: Mux,
    object: &'a ObservedObject,
}

impl<'a> Owned<'a> {
    fn known(self) -> Option<(DataType, TypeFrom)> {
        self.object.data_type(self.mux)
    }

    fn last(self) -> Option<&'a HeldValue> {
        self.object.value.as_ref()
    }

    /// A value by the type of the object.
    fn typed(self, held: Option<&'a HeldValue>) -> ByType<'a> {
        (self.known().map(|known| known.0), held.map(HeldValue::content))
    }
}

table! {
    /// One row per object of a node, known at the end of the capture: what `canalyze od` lists.
    /// 一行是一个节点的一个对象，读完整个记录后得出：`canalyze od` 列出的内容
    Objects arrow "od" json "od_object", |cx, one: Owned<'_>| {
        bus: Name or null = cx.setting.bus(one.bus);
        node: U8 = one.node;
        object: Piece in csv = |out: &mut Vec<u8>| place(out, one.mux);
        index: Hex4 = one.mux.index;
        sub: U8 = one.mux.sub;
        /// name; empty where it has none
        /// 名称；没有时为空
        name: Name or null = cx.object(Some(one.mux), &one.object.described);
        r#type as "type": Word or null = one.known().map(|known| known.0.name());
        /// where the type is from: eds, standard (CiA 301), profile, or inferred from the values
        /// 类型的依据：eds、standard（CiA 301）、profile（设备规范）、inferred（由值推断）
        type_from: Word or null = one.known().map(|known| known.1.name());
        /// size of the value in bits
        /// 值的位数
        bits: U64 or null = one.object.bits();
        /// access: rw, ro, wo; r or w where the other one is not known
        /// 访问权限：rw、ro、wo；只知其一时为 r 或 w
        access: Word or null = one.object.access();
        /// whether it can be read; empty where the traffic does not tell
        /// 能否读；报文中看不出时为空
        readable: Truth or null = one.object.is_readable();
        /// whether it can be written; empty where the traffic does not tell
        /// 能否写；报文中看不出时为空
        writable: Truth or null = one.object.is_writable();
        /// whether the device has the object; empty where the traffic does not tell
        /// 设备中是否有此对象；看不出时为空
        exists: Truth or null = one.object.exists();
        /// last value, scaled
        /// 最后一个值，已换算
        value: Real or null in arrow = read(one).1;
        /// the same as an integer, where it has no factor
        /// 整数值（不带系数时）
        integer: I64 or null in arrow = read(one).0;
        /// last value, without unit and factor
        /// 最后一个值，不带单位和系数
        value_shown as "value": ShownValue or null in json = one.typed(one.last());
        /// last value in words
        /// 最后一个值的文字
        text: MaybeText or null = |out: &mut Vec<u8>| text(out, cx.setting.lang, one);
        /// bytes of the last value, the first 4096
        /// 最后一个值的字节，最多4096个
        data: Bytes or null = octets(one.last().map(HeldValue::content)).as_deref();
        /// what carried the last value: read, written, tpdo, rpdo or emcy
        /// 最后一个值的来源：read、written、tpdo、rpdo、emcy
        source: Word or null = one.last().map(|held| held.source.name());
        /// timestamp of the last value
        /// 最后一个值的时间戳
        t: Moment or null = one.last().and_then(|held| held.at.t_ns);
        /// frame of the last value
        /// 最后一个值的帧号
        frame: U64 or null = one.last().map(|held| held.at.no);
        /// number of values
        /// 值的个数
        values: U64 = one.object.values();
        /// two values that the device gave differ, though nothing was written in between
        /// 设备给出的两个值不同，其间没有写入
        varies: Truth in json = one.object.varies;
        /// number of uploads that are ok
        /// 读出的次数
        read: U64 = one.object.count(Source::Read);
        /// number of downloads that are ok
        /// 写入的次数
        written: U64 = one.object.count(Source::Written);
        /// number of TPDOs that carried it
        /// TPDO中的次数
        tpdo: U64 = one.object.count(Source::Tpdo);
        /// number of RPDOs that carried it
        /// RPDO中的次数
        rpdo: U64 = one.object.count(Source::Rpdo);
        /// number of EMCYs that carried it
        /// EMCY中的次数
        emcy: U64 = one.object.count(Source::Emcy);
        /// number of requests that the device aborted
        /// 被设备中止的请求数
        refused: U64 = one.object.count(Source::Refused);
        /// number of requests without a sound end: unanswered, given up, incomplete, or failed
        /// 没有结果的请求数：无响应、被客户端放弃、不完整、违反协议
        unconfirmed: U64 = one.object.count(Source::Unconfirmed);
        /// value of a write without an answer
        /// 没有响应的写入值
        requested: ShownValue or null in json = one.typed(one.object.requested.as_ref());
        /// the last write that was accepted: value, data, size, frame; null of a command or process data
        /// 最后一次被接受的写入：value、data、size、frame；命令和过程数据为null
        configured: Json or null in json = |out: &mut Vec<u8>| configured(out, one);
        /// aborted requests: request, code, by, text, count, frame
        /// 被中止的请求：request、code、by、text、count、frame
        aborts: List in json = |out: &mut Vec<u8>| aborts(out, cx.setting, one.object);
        aborts_cell as "aborts": Piece in csv = |out: &mut Vec<u8>| aborts_cell(out, one.object);
        /// abort codes seen
        /// 出现过的中止码
        abort_codes: U32s in arrow = one.object.aborted.iter().map(|one| one.abort.code.number());
        /// value in force by all that is known: value, text, from; all null where it is no longer known
        /// 当前有效的值：value、text、from；不再知道时都为null
        in_force: Json or null in json = |out: &mut Vec<u8>| in_force(out, cx.setting, one);
        /// value in force by all that is known: after a reset it may differ from the last one; only of communication objects that decoding depends on
        /// 当前有效的值：由全部已知信息得出，复位后可能不同于最后一个值；只用于解码所依据的通信对象
        in_force_value as "in_force": U64 or null in arrow = match one.object.in_force {
            InForce::Value(known) => Some(known.value),
            InForce::Unknown | InForce::Unfollowed => None,
        };
        /// where that is from: observed, option, dcf or eds; unknown where it is no longer known
        /// 其依据：observed、option、dcf、eds；unknown 表示不再知道
        in_force_from: Word or null in arrow = match one.object.in_force {
            InForce::Value(known) => Some(known.from.name()),
            InForce::Unknown => Some("unknown"),
            InForce::Unfollowed => None,
        };
        /// the first value read before any write: data, size, booted, frame
        /// 写入前首次读出的值：data、size、booted、frame
        first: Json or null in json = |out: &mut Vec<u8>| first(out, one.object);
        /// least and greatest size in bytes of SDO transfers, read and written
        /// SDO读写的最小和最大字节数
        sizes: Json in json = |out: &mut Vec<u8>| sizes(out, one.object);
        /// bytes of the values by SDO that are least or greatest as a signed or unsigned number or as a real
        /// SDO值中按有符号数、无符号数或实数为最小或最大者的字节
        extremes: List in json = |out: &mut Vec<u8>| extremes(out, one.object);
        /// first frame that shows it
        /// 首次出现的帧号
        first_frame: U64 = one.object.first.no;
        /// last frame that shows it
        /// 最后出现的帧号
        last_frame: U64 = one.object.last.no;
    }
    csv [
        node, bus, object, name, r#type, type_from, bits, access, value_shown, data, source, t, frame, values, read,
        written, tpdo, rpdo, emcy, refused, unconfirmed, requested, aborts_cell, in_force_value, in_force_from,
    ]
}

/// The table, and the objects seen so far.
#[derive(Debug, Default)]
pub(super) struct Od {
    table: Table<Objects>,
    inventory: Inventory,
}

impl Collector for Od {
    fn taking(&mut self, inventory: &mut Inventory) {
        self.inventory = std::mem::take(inventory);
    }

    fn frame(&mut self, _: &mut Vec<Batch>, _: TableContext<'_>, frame: &Frame, events: &[Event]) {
        self.inventory.frame(frame, events);
    }

    fn transfer(&mut self, _: &mut Vec<Batch>, _: TableContext<'_>, transfer: &Transfer) {
        self.inventory.transfer(transfer);
    }

    fn settle(&mut self, state: &[Bus]) {
        self.inventory.settle(state);
    }

    fn finish(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>) {
        each(&self.inventory, |one| self.table.row(done, &scene.cx(), one));
        self.table.finish(done);
    }

    /// Appends no batch: rows come at the end.
    fn flush(&mut self, _: &mut Vec<Batch>) {}

    fn table(&mut self) -> &mut dyn Ends {
        &mut self.table
    }
}

fn each<'a>(all: &'a Inventory, mut take: impl FnMut(Owned<'a>)) {
    for ((bus, id), node) in &all.nodes {
        for (mux, object) in &node.objects {
            take(Owned { bus: *bus, node: *id, mux: *mux, object });
        }
    }
}

/// Appends the JSON lines of a node's objects.
pub(super) fn lines(out: &mut Vec<u8>, cx: &Cx<'_>, (bus, node): (BusId, u8), of: &NodeObjects) {
    for (mux, object) in &of.objects {
        Objects::json(out, cx, Owned { bus, node, mux: *mux, object });
        out.push(b'\n');
    }
}

/// Appends all objects as CSV.
pub fn csv(out: &mut Vec<u8>, setting: Setting<'_>, all: &Inventory) {
    csv::headings(out, Objects::HEADINGS);
    // A number comes first: no line may begin as a command of a program that reads a log.
    each(all, |one| Objects::csv(out, &Cx { setting, names: NAMES }, one));
}

/// Appends an object: `1008:00`.
pub(super) fn place(out: &mut Vec<u8>, mux: Mux) {
    put!(out; Hex::<4>(u64::from(mux.index)), ":", Hex::<2>(u64::from(mux.sub)));
}

/// The type of a value, and its bytes or bits.
type ByType<'a> = (Option<DataType>, Option<Content<'a>>);

/// A value by its type, without its unit; null where it is not known.
pub(super) enum ShownValue {}

impl InJson for ShownValue {
    const JSON: &'static str = "any";
}

impl ShownValue {
    fn write(out: &mut Vec<u8>, (data_type, content): ByType<'_>) {
        match content {
            Some(Content::Bytes(bytes, size)) if bytes.len() as u64 == size => json_value(out, data_type, bytes),
            Some(Content::Bits(raw, bits)) => match number(data_type, raw, bits) {
                Number::Bool(on) => put!(out; if on { "true" } else { "false" }),
                Number::Bytes => put!(out; "null"),
                // Whole numbers and reals are written as those of SDO.
                Number::Unsigned(_) => json_value(out, Some(DataType::Unsigned64), &raw.to_le_bytes()),
                Number::Signed(read) => json_value(out, Some(DataType::Integer64), &read.to_le_bytes()),
                Number::Real32(read) => json_value(out, Some(DataType::Real32), &read.to_le_bytes()),
                Number::Real64(read) => json_value(out, Some(DataType::Real64), &read.to_le_bytes()),
            },
            _ => put!(out; "null"),
        }
    }
}

impl ColumnKind<ByType<'_>> for ShownValue {
    fn json(out: &mut Vec<u8>, _: &Cx<'_>, value: ByType<'_>) {
        Self::write(out, value);
    }

    fn csv(out: &mut Vec<u8>, _: &Cx<'_>, (data_type, content): ByType<'_>) {
        if let Some(Content::Bytes(bytes, size)) = content
            && bytes.len() as u64 == size
            && let od::Value::Text(text) = od::decode(data_type, bytes)
        {
            return csv::cell(out, text.as_bytes());
        }
        csv::bare(out, |out| Self::write(out, (data_type, content)));
    }
}

/// Returns the bytes of a value; of bits those that they fill.
pub(super) fn octets(content: Option<Content<'_>>) -> Option<Cow<'_, [u8]>> {
    match content? {
        Content::Bytes(bytes, _) => Some(bytes.into()),
        Content::Bits(raw, bits) => {
            let mut all = raw.to_le_bytes().to_vec();
            all.truncate(usize::from(bits).div_ceil(8));
            Some(all.into())
        }
        Content::None => None,
    }
}

/// Returns the last value as a whole number and in its unit.
fn read(one: Owned<'_>) -> (Option<i64>, Option<f64>) {
    let (raw, bits) = match one.last().map(HeldValue::content) {
        Some(Content::Bits(raw, bits)) => (Some(raw), bits),
        Some(Content::Bytes(bytes, size)) => {
            let number = bytes.len() as u64 == size && (1..=8).contains(&bytes.len());
            (if number { extract(bytes, 0, 8 * bytes.len()) } else { None }, 8 * bytes.len().min(8) as u8)
        }
        Some(Content::None) | None => (None, 0),
    };
    let mapped = Mapped { bits, ..inventory::mapped(one.mux, one.object) };
    raw.map_or((None, None), |raw| numbers(&mapped, raw))
}

fn text(out: &mut Vec<u8>, lang: Lang, one: Owned<'_>) -> bool {
    let Some(held) = one.last() else { return false };
    inventory::held(out, lang, one.mux, one.object, &held.value);
    true
}

fn configured(out: &mut Vec<u8>, one: Owned<'_>) {
    let Some(held) = one.object.configured(one.mux) else { return put!(out; "null") };
    put!(out; "{\"value\":", |out: &mut Vec<u8>| ShownValue::write(out, one.typed(Some(held))));
    put!(out; ",\"data\":\"", Joined(&octets(Some(held.content())).unwrap_or_default()));
    put!(out; "\",\"size\":", held.content().size(), ",\"frame\":", held.at.no, "}");
}

fn aborts(out: &mut Vec<u8>, setting: Setting<'_>, object: &ObservedObject) {
    list(out, &object.aborted, |out, one| {
        put!(out; "{\"request\":\"", one.direction.name(), "\",\"code\":\"");
        put!(out; one.abort.code, "\",\"by\":\"", side(one.abort.by), "\",\"text\":");
        match terms::abort_code(setting.lang, one.abort.code) {
            Some(text) => escape::json(out, text.as_bytes()),
            None => put!(out; "null"),
        }
        put!(out; ",\"count\":", one.count, ",\"frame\":", one.at.no, "}");
    });
}

fn aborts_cell(out: &mut Vec<u8>, object: &ObservedObject) {
    for (place, one) in object.aborted.iter().enumerate() {
        put!(out; if place > 0 { " " } else { "" }, one.direction.name(), ":");
        put!(out; one.abort.code, ":", one.count);
    }
}

fn in_force(out: &mut Vec<u8>, setting: Setting<'_>, one: Owned<'_>) {
    match one.object.in_force {
        InForce::Value(known) => {
            put!(out; "{\"value\":", known.value, ",\"text\":");
            quoted(out, |text| inventory::number(text, setting.lang, one.mux, &one.object.described, known.value));
            put!(out; ",\"from\":\"", known.from.name(), "\"}");
        }
        InForce::Unknown => put!(out; "{\"value\":null,\"text\":null,\"from\":null}"),
        InForce::Unfollowed => put!(out; "null"),
    }
}

fn first(out: &mut Vec<u8>, object: &ObservedObject) {
    let Some(held) = &object.measured.first else { return put!(out; "null") };
    put!(out; "{\"data\":\"", Joined(&octets(Some(held.content())).unwrap_or_default()), "\",\"size\":");
    put!(out; held.content().size(), ",\"booted\":", if object.measured.booted { "true" } else { "false" });
    put!(out; ",\"frame\":", held.at.no, "}");
}

fn sizes(out: &mut Vec<u8>, object: &ObservedObject) {
    for (key, direction) in [("{\"read\":", Direction::Upload), (",\"written\":", Direction::Download)] {
        match object.measured.sizes(direction) {
            Some((least, most)) => put!(out; key, "[", least, ",", most, "]"),
            None => put!(out; key, "null"),
        }
    }
    put!(out; "}");
}

fn extremes(out: &mut Vec<u8>, object: &ObservedObject) {
    let (values, size) = object.measured.extremes().unwrap_or_default();
    list(out, &values, |out, raw| {
        let all = raw.to_le_bytes();
        put!(out; "\"", Joined(all.get(..size).unwrap_or(&all)), "\"");
    });
}
