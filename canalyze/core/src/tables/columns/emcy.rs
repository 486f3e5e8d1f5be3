//! `emcy`: one row per emergency, with the errors of its node after it as far as the capture shows them.
//!
//! Must not: judge.

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::Frame;
use crate::tables::table::{Bytes, Moment, Name, U8, U16, U16s, U64, Word, table};
use crate::wire::emcy;
use crate::wire::message::Errors;
use crate::words::profiles::Profile;
use crate::world::change::{Change, EmcyChange};
use crate::world::event::{Event, What};

/// An emergency and its event.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Emergency<'a> {
    event: &'a Event,
    node: u8,
    code: u16,
    profile: Profile,
    register: u8,
    manufacturer: &'a [u8],
    active: Errors,
    cleared: Errors,
}

table! {
    /// One row per EMCY.
    /// 一行是一个紧急报文
    Emcy arrow "emcy", |cx, one: Emergency<'_>| {
        t: Moment or null = one.event.at.t_ns;
        frame: U64 = one.event.at.no;
        bus: Name or null = cx.setting.bus(one.event.bus);
        node: U8 = one.node;
        /// EMCY error code
        /// EMCY错误码
        code: U16 = one.code;
        name: Word or null = emcy::code(cx.setting.lang, one.profile, one.code);
        /// error register (1001h)
        /// 错误寄存器（1001h）
        register: U8 = one.register;
        /// manufacturer bytes (5)
        /// 制造商数据，5字节
        manufacturer: Bytes = one.manufacturer;
        /// error codes that are active after it
        /// 此后仍存在的错误码
        active: U16s = one.active.iter();
        /// error codes that it clears
        /// 由它清除的错误码
        cleared: U16s = one.cleared.iter();
    }
}

impl Collector for Table<Emcy> {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, _: &Frame, events: &[Event]) {
        for event in events {
            let What::Change(Change::Error(ref emcy)) = event.what else { continue };
            let EmcyChange { node, code, profile, register, ref manufacturer, active, cleared } = *emcy;
            self.row(
                done,
                &scene.cx(),
                Emergency { event, node, code, profile, register, manufacturer, active, cleared },
            );
        }
    }

    fn table(&mut self) -> &mut dyn Ends {
        self
    }
}
