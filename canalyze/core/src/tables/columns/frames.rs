//! `frames`: one row per frame that the filter lets through.
//!
//! `fd` is `{"brs","esi"}` of an FD frame, else false. `text` is the default line's words. `findings` are the codes
//! raised at the frame, each of which has a `finding` line after it. Must not: judge.

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::{Direction, Frame, Kind as Form};
use crate::tables::jsonl::{pdo, sdo, services};
use crate::tables::table::{
    Any, Bytes, Cx, Given, Identifier, List, Members, Name, Stamped, Text, Truth, U8, U64, Word, list, table,
};
use crate::words::digits::put;
use crate::words::{Depth, Lang, services as words};
use crate::world::event::{Event, Signals, What};

/// A frame and what follows from it.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Framed<'a> {
    pub(in crate::tables) frame: &'a Frame,
    /// Its service, and the node that it is about.
    pub(in crate::tables) service: (&'static str, Option<u8>),
    pub(in crate::tables) events: &'a [Event],
}

impl Framed<'_> {
    /// Returns all that decides the part of its meaning; `None` where the bytes of the frame do, too.
    pub(in crate::tables) fn meaning_key(self, lang: Lang) -> Option<u64> {
        let [Event { node, what: What::Pdo(data), .. }] = self.events else { return None };
        let constant = matches!(data.content, Signals::None(_)) && data.sync.is_none() && *node == Some(data.node);
        let state = data.state.map_or(0, |state| 0x100 | u64::from(state));
        constant.then(|| words::pdo::beginning_key(lang, Depth::Default, data, self.frame.len) | state << 40)
    }
}

table! {
    /// One row per frame.
    /// 一行是一帧
    Frames arrow "frames" json "frame", |cx, one: Framed<'_>| {
        frame: U64 = one.frame.no;
        line: U64 or null = one.frame.line;
        file: Given = cx.setting.file;
        t: Stamped or null = (one.frame.t_ns, one.frame.stamp.map_or(9, |stamp| stamp.decimals));
        bus: Name or null = cx.setting.bus(one.frame.bus);
        /// direction, rx or tx
        /// 方向 rx、tx
        dir: Word or null in json = direction(one.frame);
        /// CAN-ID; of an error frame its class
        /// CAN-ID；错误帧为其类别
        id: Identifier = one.frame.id;
        /// 29-bit identifier
        /// 29位ID
        extended as "ext": Truth = one.frame.id.is_extended() && one.frame.kind != Form::Error;
        /// remote frame
        /// 远程帧
        rtr: Truth in json = one.frame.kind == Form::Remote;
        /// of a CAN FD frame its bits brs and esi, else false
        /// CAN FD帧的brs和esi位，其余为false
        fd: Any in json = |out: &mut Vec<u8>| flexible(out, one.frame.kind);
        /// error frame
        /// 错误帧
        err: Truth in json = one.frame.kind == Form::Error;
        /// data, remote, error, ...
        /// data、remote、error等
        kind: Word in arrow = form(one.frame.kind);
        /// BRS bit of CAN FD
        /// CAN FD的BRS位
        brs: Truth or null in arrow = flags(one.frame.kind).map(|(brs, _)| brs);
        /// ESI bit of CAN FD
        /// CAN FD的ESI位
        esi: Truth or null in arrow = flags(one.frame.kind).map(|(_, esi)| esi);
        /// direction, rx or tx
        /// 方向 rx、tx
        direction as "dir": Word or null in arrow = direction(one.frame);
        /// length of the data, in bytes
        /// 数据长度，字节
        len: U8 = one.frame.len;
        data: Bytes = one.frame.payload();
        service: Word = one.service.0;
        node: U8 or null = one.service.1;
        text: Text in json = |out: &mut Vec<u8>| text(out, cx, one);
        findings: List in json = |out: &mut Vec<u8>| codes(out, one.events);
        /// the fields of its service, under the service's name
        /// 以服务名为键，该服务的各字段
        fields: Members in members = |out: &mut Vec<u8>| fields(out, cx, one);
    }
    parts {
        number [frame, line]
        source [file]
        moment [t]
        form [bus, dir, id, extended, rtr, fd, err, len]
        content [data]
        meaning [service, node, text, findings, fields]
    }
}

impl Collector for Table<Frames> {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, frame: &Frame, events: &[Event]) {
        self.row(done, &scene.cx(), Framed { frame, service: scene.service, events });
    }

    fn table(&mut self) -> &mut dyn Ends {
        self
    }
}

fn direction(frame: &Frame) -> Option<&'static str> {
    frame.dir.map(|direction| match direction {
        Direction::Rx => "rx",
        Direction::Tx => "tx",
    })
}

fn form(kind: Form) -> &'static str {
    match kind {
        Form::Data => "data",
        Form::Remote => "remote",
        Form::Error => "error",
        Form::Fd { .. } => "fd",
    }
}

fn flags(kind: Form) -> Option<(bool, bool)> {
    if let Form::Fd { brs, esi } = kind { Some((brs, esi)) } else { None }
}

fn flexible(out: &mut Vec<u8>, kind: Form) {
    let truth = |yes| if yes { "true" } else { "false" };
    match flags(kind) {
        Some((brs, esi)) => put!(out; "{\"brs\":", truth(brs), ",\"esi\":", truth(esi), "}"),
        None => put!(out; "false"),
    }
}

fn text(out: &mut Vec<u8>, cx: &Cx<'_>, Framed { frame, events, .. }: Framed<'_>) {
    let (lang, Some(event)) = (cx.setting.lang, events.first()) else { return };
    match &event.what {
        What::Message(message) => words::message(out, lang, Depth::Default, message, frame),
        What::Pdo(data) => words::pdo::process_data(out, lang, Depth::Default, data, frame),
        What::Mpdo(data) => words::pdo::multiplex(out, lang, Depth::Default, data),
        What::Sdo(step) => words::sdo::step(out, lang, Depth::Default, step, frame.len),
        What::Finding(_) | What::Transfer(_) | What::Note(_) | What::Change(_) => {}
    }
}

fn codes(out: &mut Vec<u8>, events: &[Event]) {
    let found = events.iter().filter_map(|event| match &event.what {
        What::Finding(finding) => Some(finding.code.rule().id),
        _ => None,
    });
    list(out, found, |out, code| put!(out; "\"", code, "\""));
}

fn fields(out: &mut Vec<u8>, cx: &Cx<'_>, one: Framed<'_>) {
    let Some(event) = one.events.first() else { return };
    put!(out; ",\"", one.service.0, "\":");
    match &event.what {
        What::Message(message) => services::fields(out, message, one.frame),
        What::Pdo(data) => pdo::fields(out, cx, data, one.frame),
        What::Mpdo(data) => services::multiplexed(out, cx.setting.lang, data, one.frame),
        What::Sdo(step) => sdo::fields(out, step, event.transfer, one.frame),
        What::Finding(_) | What::Transfer(_) | What::Note(_) | What::Change(_) => {}
    }
}
