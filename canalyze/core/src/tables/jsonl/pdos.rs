//! PDOs with their mappings, as JSON lines of kind `pdo`, by bus and identifier.
//!
//! Dummy entries are not listed. A last line of kind `pdos` has `further`, the number of PDOs for which there was no
//! room, where there were any. Must not: decide anything.

use super::pdo::name;
use crate::bytes::frame::Buses;
use crate::tables::setting::{NAMES, Setting};
use crate::tables::table::{
    Any, Cx, Given, Hex4, Identifier, Label, List, Name, Text, Truth, U8, U16, U32, U64, Word, list, table,
};
use crate::views::inventory::pdos::{Address, KnownPdo, PdoInventory, PdoOwner};
use crate::views::lines::Clocked;
use crate::wire::pdo::mapping::{Mapped, Mapping, Number, number};
use crate::words::digits::put;
use crate::words::{escape, signal, terms};
use crate::world::drive;
use crate::world::node::Content;

/// Bit of the first byte of a multiplex PDO by which it has a destination.
const DESTINATION: u32 = 1 << 7;

table! {
    /// One line per PDO.
    /// 一行是一个PDO
    Lines json "pdo", |cx, one: (PdoOwner, &KnownPdo)| {
        bus: Name or null = cx.setting.bus(one.0.bus);
        /// identifier
        /// 标识符
        id: Identifier = one.0.id;
        /// 29-bit identifier
        /// 29位ID
        ext: Truth = one.0.id.is_extended();
        node: U8 = one.0.node;
        /// transmit, not receive
        /// 发送（否则为接收）
        transmit: Truth = one.0.transmit;
        pdo: Any = |out: &mut Vec<u8>| name(out, one.0.transmit, one.0.number);
        /// number of frames
        /// 帧数
        frames: U64 = one.1.frames;
        /// mapped, source and destination (multiplex PDOs), disabled, contradicted or unknown
        /// mapped、source和destination（多路PDO）、disabled、contradicted、unknown
        content: Word = content(one.1).0;
        /// where that is known from
        /// 其依据
        from: Word or null = content(one.1).1;
        /// number of changes of the mapping
        /// 映射改变的次数
        changes: U64 = one.1.changes;
        /// frames of a multiplex PDO with an object for which there was no room
        /// 多路PDO中因数量过多而未列出的对象出现的次数
        further: U64 = one.1.further;
        /// transmission type
        /// 传输类型
        r#type as "type": U8 or null = one.1.timing.transmission;
        /// inhibit time in 100 us
        /// 禁止时间，100 us
        inhibit: U16 or null = one.1.timing.inhibit;
        /// event timer in ms
        /// 事件定时器，ms
        event_timer: U16 or null = one.1.timing.event_timer;
        /// period of its SYNC in ns
        /// 其SYNC的周期，ns
        sync_ns: U64 or null = one.1.timing.sync_ns.map(|ns| ns.as_ns().unsigned_abs());
        /// length of the payload in bits
        /// 数据的位数
        bits: U16 = mapping(one.1).map_or(0, |mapping| mapping.bits);
        /// its signals
        /// 各信号
        signals: List = |out: &mut Vec<u8>| signals(out, cx, one.0.node, one.1);
    }
}

/// A signal of a PDO; `address`: in a multiplex PDO.
#[derive(Clone, Copy)]
pub(in crate::tables) struct KnownSignal<'a> {
    node: u8,
    address: Option<Address>,
    mapped: &'a Mapped,
    name: &'a [u8],
}

table! {
    /// A signal of a PDO.
    /// PDO的一个信号
    Signals object "pdo.signals", |_cx, one: KnownSignal<'_>| {
        /// node whose object it is; null where any may be
        /// 对象所属的节点；可为任意节点时为null
        node: U8 or null = Some(one.address.map_or(one.node, |address| address.node)).filter(|node| *node != 0);
        /// first four bytes of a multiplex PDO as one little-endian number
        /// 多路PDO的前四字节，小端数
        address: U32 or null = one.address.map(number_of);
        index: Hex4 = one.mapped.index;
        sub: U8 = one.mapped.sub;
        name: Given = one.name;
        /// offset in bits
        /// 起始位
        offset: U16 = one.mapped.offset;
        /// length in bits
        /// 位数
        bits: U8 = one.mapped.bits;
        /// unsigned, signed, real, or bytes
        /// unsigned、signed、real、bytes
        number: Word = kind(one.mapped);
        unit: Label or null = one.mapped.unit.as_deref().filter(|unit| !unit.is_empty());
        /// factor to the unit
        /// 换算到单位的系数
        factor: Text = |out: &mut Vec<u8>| put!(out; one.mapped.factor.to_string().as_str());
        /// words of values, in English: value, text
        /// 各值的英文名称：value、text
        words: List = |out: &mut Vec<u8>| list(out, words(one.mapped), |out, (value, word)| {
            put!(out; "{\"value\":", i64::from(value), ",\"text\":");
            escape::json(out, word.as_bytes());
            put!(out; "}");
        });
    }
}

/// Appends all of them.
pub fn write(out: &mut Vec<u8>, buses: &Buses, all: &PdoInventory) {
    let setting = Setting { lang: NAMES, file: b"", buses, decimals: 9, clock: Clocked::default() };
    for (whose, pdo) in &all.pdos {
        Lines::json(out, &Cx::of(setting), (*whose, pdo));
        out.push(b'\n');
    }
    if all.further > 0 {
        put!(out; "{\"kind\":\"pdos\",\"further\":", all.further, "}\n");
    }
}

/// Returns the word for the content, and for its source.
fn content(pdo: &KnownPdo) -> (&'static str, Option<&'static str>) {
    match &pdo.content {
        Content::Mapped(_, from) => ("mapped", Some(from.name())),
        Content::Multiplex { destination: true, from } => ("destination", Some(from.name())),
        Content::Multiplex { from, .. } => ("source", Some(from.name())),
        Content::Disabled(from) => ("disabled", Some(from.name())),
        Content::Unknown => (if pdo.contradicted { "contradicted" } else { "unknown" }, None),
    }
}

fn mapping(pdo: &KnownPdo) -> Option<&Mapping> {
    if let Content::Mapped(mapping, _) = &pdo.content { Some(mapping) } else { None }
}

fn signals(out: &mut Vec<u8>, cx: &Cx<'_>, node: u8, pdo: &KnownPdo) {
    let mapped = mapping(pdo).into_iter().flat_map(|mapping| {
        let names = signal::written(mapping, NAMES).iter().map(|how| how.name.clone());
        mapping.entries.iter().zip(names).filter(|(mapped, _)| !mapped.dummy)
    });
    let mapped = mapped.map(|(mapped, name)| (None, mapped, name));
    let addressed = pdo.objects.iter().map(|(address, mapped)| {
        let mut name = Vec::new();
        signal::name(&mut name, NAMES, mapped);
        (Some(*address), mapped, name)
    });
    list(out, mapped.chain(addressed), |out, (address, mapped, name)| {
        Signals::json(out, cx, KnownSignal { node, address, mapped, name: &name });
    });
}

/// The first four bytes of a multiplex PDO with this address.
fn number_of(Address { destination, node, object }: Address) -> u32 {
    let first = u32::from(node) | if destination { DESTINATION } else { 0 };
    first | u32::from(object.index) << 8 | u32::from(object.sub) << 24
}

fn kind(mapped: &Mapped) -> &'static str {
    match number(mapped.data_type, 0, mapped.bits) {
        _ if mapped.bits > 64 => "bytes",
        Number::Bytes => "bytes",
        Number::Unsigned(_) | Number::Bool(_) => "unsigned",
        Number::Signed(_) => "signed",
        Number::Real32(_) | Number::Real64(_) => "real",
    }
}

/// Returns the values of a mode of operation with their names.
fn words(mapped: &Mapped) -> impl Iterator<Item = (i8, &'static str)> {
    let object = drive::DriveObject::at(mapped.index).filter(|_| mapped.is_drives());
    let modes =
        matches!(object, Some(drive::DriveObject::ModesOfOperation | drive::DriveObject::ModesOfOperationDisplay));
    (i8::MIN..=i8::MAX)
        .filter(move |mode| modes && terms::drive::abbreviation(*mode).is_some())
        .map(|mode| (mode, terms::drive::mode(NAMES, mode)))
}
