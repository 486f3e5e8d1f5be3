//! `states`: the NMT states of nodes, a row where one changes, and what was commanded.
//!
//! | `source` | rows | `state` | `command` |
//! |---|---|---|---|
//! | `boot-up` | each | 0 | null |
//! | `heartbeat`, `guarding` | the first since the node's boot-up, and each with another state than the one before | 4, 5, 127, or what it carried | null |
//! | `command` | each NMT command; `node` is null where it is to all | the state that it asks for, null for a reset or an unknown one | 1, 2, 128, 129, 130 |
//!
//! Must not: keep state of its own; what a node has shown before comes with the message.

use arrow_array::types::{Int64Type, UInt8Type, UInt64Type};

use super::column::{Batch, Numbers, Table, Words, columns};
use crate::tables::jsonl::Setting;
use crate::wire::error_control;
use crate::wire::message::Message;
use crate::world::event::Event;

columns! {
    /// The columns.
    States {
        t_ns: Numbers<Int64Type>, or_null;
        frame: Numbers<UInt64Type>;
        bus: Words, or_null;
        node: Numbers<UInt8Type>, or_null;
        state: Numbers<UInt8Type>, or_null;
        name: Words, or_null;
        source: Words;
        command: Numbers<UInt8Type>, or_null;
    }
}

impl Table<States> {
    /// Appends what a message says of a state.
    pub(super) fn message(&mut self, done: &mut Vec<Batch>, setting: Setting<'_>, event: &Event, message: &Message) {
        let (node, state, source, command) = match (seen(message), message) {
            (Some((node, state, source)), _) => (Some(node), Some(state), source, None),
            (None, &Message::Nmt { command, node }) => {
                ((node > 0).then_some(node), commanded(command), "command", Some(command))
            }
            _ => return,
        };
        let columns = &mut self.columns;
        columns.t_ns.append_option(event.at.t_ns);
        columns.frame.append_value(event.at.no);
        columns.bus.name(setting.buses.name(event.bus));
        columns.node.append_option(node);
        columns.state.append_option(state);
        columns.name.maybe(state.and_then(|state| error_control::state(setting.lang, state)));
        columns.source.word(source);
        columns.command.append_option(command);
        self.end_row(0, done);
    }
}

/// Node and state that a message shows, and what it is, unless the node was in that state before.
pub(super) fn seen(message: &Message) -> Option<(u8, u8, &'static str)> {
    match *message {
        Message::BootUp { node } => Some((node, 0, "boot-up")),
        Message::Heartbeat { state, previous: Some(before), .. } if before == state => None,
        Message::Heartbeat { node, state, guarding: true, .. } => Some((node, state, "guarding")),
        Message::Heartbeat { node, state, .. } => Some((node, state, "heartbeat")),
        _ => None,
    }
}

/// The state that a command asks for (CiA 301, 7.2.8.3.1).
fn commanded(command: u8) -> Option<u8> {
    match command {
        0x01 => Some(0x05),
        0x02 => Some(0x04),
        0x80 => Some(0x7F),
        _ => None,
    }
}
