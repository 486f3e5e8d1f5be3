//! Frames that were judged before others that the capture lists first: they are written in the order of the capture.
//!
//! Must not: change what is known of them.

use std::collections::BTreeMap;

use super::capture::Origin;
use crate::bytes::frame::Frame;
use crate::bytes::ns::Ns;
use crate::world::event::Event;

/// A frame with all that follows from it.
#[derive(Debug)]
pub(super) struct JudgedFrame {
    /// The frame with its number in the capture.
    pub(super) frame: Frame,
    pub(super) events: Vec<Event>,
    /// The SYNC cycle and window, as sinks take them.
    pub(super) sync: (u64, Option<Ns>),
    /// Its file, where it was held back.
    pub(super) origin: Option<Origin>,
}

/// Frames that wait to be written, by their numbers.
#[derive(Debug, Default)]
pub(super) struct Judged {
    held: BTreeMap<u64, JudgedFrame>,
    /// The number of the next frame to be written.
    next: u64,
}

impl Judged {
    pub(super) fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// Keeps a frame. `place`: its place among those that are judged; all places before are taken by now.
    pub(super) fn hold(&mut self, place: u64, judged: JudgedFrame) {
        if self.held.is_empty() {
            self.next = place;
        }
        self.held.insert(judged.frame.no, judged);
    }

    /// Returns the next frame in the order of the capture, if all before it were written. `over`: those that are missing
    /// do not follow.
    pub(super) fn next(&mut self, over: bool) -> Option<JudgedFrame> {
        let first = self.held.first_entry().filter(|first| over || *first.key() == self.next)?;
        self.next = first.key().saturating_add(1);
        Some(first.remove())
    }
}
