//! Notes: facts that become known of an earlier frame and are no findings.
//!
//! Must not: judge.

use super::facts;
use crate::bytes::frame::FrameRef;
use crate::tables::setting::{NAMES, Setting};
use crate::tables::table::{Cx, Members, Name, Text, U8, U64, Word, table};
use crate::words::notes;
use crate::world::event::{Event, Note, Scanned};

/// A note, its event, and the frame that it is about.
#[derive(Clone, Copy)]
pub(in crate::tables) struct Noted<'a> {
    note: Note,
    event: &'a Event,
    about: FrameRef,
}

table! {
    /// One line per note.
    /// 一行是一条说明
    Notes json "note", |cx, one: Noted<'_>| {
        /// the kind of note
        /// 说明的类型
        note: Word = word(one.note);
        frame: U64 = one.event.at.no;
        line: U64 or null = one.event.at.line();
        /// frame that it is about
        /// 它所说的帧
        about_frame: U64 = one.about.no;
        /// line of that frame
        /// 该帧的行号
        about_line: U64 or null = one.about.line();
        bus: Name or null = cx.setting.bus(one.event.bus);
        node: U8 or null = one.event.node;
        transfer: U64 or null = one.event.transfer.map(|id| id.0);
        text: Text = |out: &mut Vec<u8>| notes::note(out, cx.setting.lang, one.note, one.about.no);
        facts as "facts": Members in members = |out: &mut Vec<u8>| facts::note(out, one.note);
    }
}

/// Appends the line of a note.
pub(super) fn line(out: &mut Vec<u8>, setting: Setting<'_>, event: &Event, note: Note) {
    let about = event.about.as_deref().copied().unwrap_or(event.at);
    Notes::json(out, &Cx { setting, names: NAMES }, Noted { note, event, about });
    out.push(b'\n');
}

fn word(note: Note) -> &'static str {
    match note {
        Note::RequestNotCaptured => "request_not_captured",
        Note::LostByReset => "lost_by_reset",
        Note::LssSelected { .. } => "lss_selected",
        Note::Fastscan(Scanned { found: true, .. }) => "fastscan_found",
        Note::Fastscan(_) => "fastscan_incomplete",
        Note::BitTimingActivated { .. } => "bit_timing_activated",
        Note::NodeIdChanged { .. } => "node_id_changed",
    }
}
