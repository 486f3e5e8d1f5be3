//! `states`: the NMT states of nodes, a row where one changes, and the NMT commands.
//!
//! | `source` | rows | `state` | `command` |
//! |---|---|---|---|
//! | `boot-up` | each | 0 | null |
//! | `heartbeat`, `guarding` | the first since the node's boot-up, and each with another state than the one before | 4, 5, 127, or the state it carried | null |
//! | `command` | each NMT command; `node` is null where it is to all | the state that it asks for, null for a reset or an unknown one | 1, 2, 128, 129, 130 |
//!
//! Must not: keep state of its own; the state that a node has shown before comes with the change.

use super::column::{Batch, Table};
use super::{Collector, Ends, TableContext};
use crate::bytes::frame::Frame;
use crate::tables::table::{Moment, Name, U8, U64, Word, table};
use crate::wire::error_control::{self, BOOT_UP};
use crate::wire::nmt::commanded_state;
use crate::world::change::Change;
use crate::world::event::{Event, What};

/// A state or a command, and the event that shows it.
#[derive(Clone, Copy)]
pub(in crate::tables) struct ShownState<'a> {
    event: &'a Event,
    node: Option<u8>,
    state: Option<u8>,
    source: &'static str,
    command: Option<u8>,
}

table! {
    /// One row per change of an NMT state, and per NMT command.
    /// 一行是一次NMT状态变化或一条NMT命令
    States arrow "states", |cx, one: ShownState<'_>| {
        t: Moment or null = one.event.at.t_ns;
        frame: U64 = one.event.at.no;
        bus: Name or null = cx.setting.bus(one.event.bus);
        node: U8 or null = one.node;
        /// code of the NMT state
        /// NMT状态码
        state: U8 or null = one.state;
        name: Word or null = one.state.and_then(|state| error_control::state(cx.setting.lang, state));
        source: Word = one.source;
        /// NMT command specifier
        /// NMT命令字
        command: U8 or null = one.command;
    }
}

impl Collector for Table<States> {
    fn frame(&mut self, done: &mut Vec<Batch>, scene: TableContext<'_>, _: &Frame, events: &[Event]) {
        for event in events {
            let What::Change(change) = &event.what else { continue };
            let shown = match (seen(change), change) {
                (Some((node, state, source)), _) => {
                    ShownState { event, node: Some(node), state: Some(state), source, command: None }
                }
                (None, &Change::Command { command, node }) => {
                    let (node, state) =
                        ((node > 0).then_some(node), commanded_state(command).filter(|state| *state != BOOT_UP));
                    ShownState { event, node, state, source: "command", command: Some(command) }
                }
                _ => continue,
            };
            self.row(done, &scene.cx(), shown);
        }
    }

    fn table(&mut self) -> &mut dyn Ends {
        self
    }
}

/// Returns the node and the state that a change shows and its source, unless the node was in that state before.
pub(super) fn seen(change: &Change) -> Option<(u8, u8, &'static str)> {
    match *change {
        Change::BootUp { node } => Some((node, 0, "boot-up")),
        Change::State { state, previous: Some(before), .. } if before == state => None,
        Change::State { node, state, guarding: true, .. } => Some((node, state, "guarding")),
        Change::State { node, state, .. } => Some((node, state, "heartbeat")),
        _ => None,
    }
}
