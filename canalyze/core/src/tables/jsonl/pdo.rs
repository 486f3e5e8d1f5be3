//! The `pdo` object of a PDO frame with data.
//!
//! `raw` is the unsigned number in the payload; `value` has sign, type and factor applied; both are strings beyond 2^53
//! and hex strings for bytes, null where the payload does not reach. Dummy entries are not listed. Must not: decide
//! which mapping holds.

use crate::bytes::frame::Frame;
use crate::bytes::ns::Ns;
use crate::tables::number::{self, marked};
use crate::tables::table::{
    Any, Cx, Given, Hex4, Json, Label, List, MaybeText, Truth, U8, U16, U64, Word, list, table,
};
use crate::wire::pdo;
use crate::wire::pdo::mapping::Mapping;
use crate::words::digits::{Hex, Padded, put};
use crate::words::signal;
use crate::world::configuration::Provenance;
use crate::world::event::{Placement, ProcessData, Signals as Content, Unmapped};

/// A PDO and its frame.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Carried<'a> {
    data: &'a ProcessData,
    frame: &'a Frame,
}

impl<'a> Carried<'a> {
    fn mapping(self) -> Option<(&'a Mapping, Provenance)> {
        match &self.data.content {
            Content::Mapped(mapping, from) | Content::ByConsumer(mapping, from, ..) => Some((mapping, *from)),
            Content::None(_) => None,
        }
    }

    fn provenance(self) -> Option<&'static str> {
        let unconfirmed = matches!(self.data.content, Content::None(Unmapped::Unconfirmed)).then_some("unconfirmed");
        self.mapping().map(|(_, from)| from.name()).or(unconfirmed)
    }

    fn unmapped(self) -> Option<&'static str> {
        match &self.data.content {
            Content::None(Unmapped::Unknown | Unmapped::Unconfirmed) => Some("unknown"),
            Content::None(Unmapped::Contradicted) => Some("contradicted"),
            Content::None(Unmapped::Disabled) => Some("disabled"),
            Content::None(Unmapped::Multiplex) => Some("multiplex"),
            Content::Mapped(..) | Content::ByConsumer(..) => None,
        }
    }
}

table! {
    /// The object of a PDO.
    /// PDO的内容
    Pdos object "frame.pdo", |cx, one: Carried<'_>| {
        /// transmit or receive
        /// transmit（发送）、receive（接收）
        direction: Word = if one.data.transmit { "transmit" } else { "receive" };
        /// number of the PDO
        /// PDO编号
        number: U16 = one.data.number;
        /// a remote request
        /// 远程请求
        remote: Truth = false;
        /// index of the communication parameter
        /// 通信参数的索引
        communication_parameter: Hex4 = pdo::communication_parameter(one.data.transmit, one.data.number);
        /// index of the mapping parameter
        /// 映射参数的索引
        mapping_parameter: Hex4 = pdo::mapping_parameter(one.data.transmit, one.data.number);
        pdo: Any = |out: &mut Vec<u8>| name(out, one.data.transmit, one.data.number);
        /// NMT state of the node, in hexadecimal
        /// 节点的NMT状态，十六进制
        state: Any or null = |out: &mut Vec<u8>| state(out, one.data.state);
        provenance: Word or null = one.provenance();
        /// frame that completed an observed mapping
        /// 写完该映射的帧
        mapped_at: U64 or null = one.mapping().and_then(|(_, from)| from.frame());
        /// why there is no mapping: unknown, contradicted by the frames, disabled, or multiplex
        /// 没有映射的原因：unknown、contradicted（与报文不符）、disabled、multiplex
        unmapped: Word or null = one.unmapped();
        /// the RPDO whose mapping was used: node, number
        /// 所用映射的RPDO：node、number
        consumer: Json or null = |out: &mut Vec<u8>| consumer(out, one.data);
        /// SYNC cycle, and the delay after its SYNC in us
        /// 同步周期及距SYNC的延迟（us）
        sync: Json or null = |out: &mut Vec<u8>| placement(out, one.data.sync);
        /// its signals
        /// 各信号
        signals: List = |out: &mut Vec<u8>| signals(out, cx, one);
    }
}

/// A signal of a PDO.
#[derive(Clone, Copy)]
pub(in crate::tables) struct CarriedSignal<'a> {
    entry: number::EntryBits<'a>,
    place: usize,
    from: Provenance,
}

table! {
    /// A signal of a PDO.
    /// PDO的一个信号
    Signals object "frame.pdo.signals", |cx, one: CarriedSignal<'_>| {
        index: Hex4 = one.entry.mapped.index;
        sub: U8 = one.entry.mapped.sub;
        name: Given = signal::own_name(one.entry.mapping, cx.names, one.place);
        /// offset in bits
        /// 起始位
        bit: U16 = one.entry.mapped.offset;
        /// length in bits
        /// 位数
        bits: U8 = one.entry.mapped.bits;
        raw: Any or null = |out: &mut Vec<u8>| marked(out, |out| number::raw(out, one.entry));
        value: Any or null = |out: &mut Vec<u8>| marked(out, |out| number::value(out, one.entry));
        unit: Label or null = one.entry.mapped.unit.as_deref();
        text: MaybeText or null = |out: &mut Vec<u8>| {
            let number::EntryBits { mapping, raw, .. } = one.entry;
            raw.map(|raw| signal::value_at(out, cx.setting.lang, mapping, one.place, raw)).is_some()
        };
        provenance: Word = one.from.name();
    }
}

/// Appends the object.
pub(in crate::tables) fn fields(out: &mut Vec<u8>, cx: &Cx<'_>, data: &ProcessData, frame: &Frame) {
    Pdos::json(out, cx, Carried { data, frame });
}

/// Appends the name of a PDO as a JSON string: `TPDO1`.
pub(super) fn name(out: &mut Vec<u8>, transmit: bool, number: u16) {
    put!(out; if transmit { "\"TPDO" } else { "\"RPDO" }, number, "\"");
}

fn state(out: &mut Vec<u8>, state: Option<u8>) {
    match state {
        Some(state) => put!(out; "\"", Hex::<2>(u64::from(state)), "\""),
        None => put!(out; "null"),
    }
}

fn consumer(out: &mut Vec<u8>, data: &ProcessData) {
    match data.content {
        Content::ByConsumer(_, _, node, number) => put!(out; "{\"node\":", node, ",\"number\":", number, "}"),
        Content::Mapped(..) | Content::None(_) => put!(out; "null"),
    }
}

fn placement(out: &mut Vec<u8>, sync: Option<Placement>) {
    let Some(sync) = sync else { return put!(out; "null") };
    put!(out; "{\"cycle\":", sync.cycle, ",\"delay_us\":");
    match sync.delay_ns {
        Some(ns) => {
            put!(out; if ns < Ns::ZERO { "-" } else { "" }, ns.as_ns().unsigned_abs() / 1000, ".");
            put!(out; Padded::<3>(ns.as_ns().unsigned_abs() % 1000), "}");
        }
        None => put!(out; "null}"),
    }
}

fn signals(out: &mut Vec<u8>, cx: &Cx<'_>, one: Carried<'_>) {
    let Some((mapping, from)) = one.mapping() else { return put!(out; "[]") };
    let entries = mapping.entries.iter().enumerate().filter(|(_, mapped)| !mapped.dummy);
    list(out, entries, |out, (place, mapped)| {
        let entry = number::EntryBits::new(mapping, mapped, one.frame.payload());
        Signals::json(out, cx, CarriedSignal { entry, place, from });
    });
}
