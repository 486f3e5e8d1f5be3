//! What a step of the bus writes to: events, findings, and bytes of transfers that are handed out.
//!
//! It is passed down to whoever judges a frame. It must not decide anything.

use crate::event::{Event, What};
use crate::finding::{Code, Facts, Finding};
use crate::frame::{BusId, FrameRef};
use crate::services::sdo::transfer::TransferId;
use crate::services::sdo::wire::Mux;

/// Where events go while one frame is taken.
pub struct Context<'a> {
    /// Events of this frame, its own first.
    pub events: &'a mut Vec<Event>,
    /// The number the next transfer gets.
    pub next_transfer: &'a mut u64,
    /// Whether transferred bytes are handed out.
    pub extract: bool,
    /// Bytes handed out.
    pub chunks: &'a mut Vec<Chunk>,
    /// The bus.
    pub bus: BusId,
    /// The frame at hand (or the last one, at the capture's end and while a live bus is silent).
    pub at: FrameRef,
}

/// Bytes of a transfer that are handed out while it runs.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// Number of the transfer.
    pub id: TransferId,
    /// The bus.
    pub bus: BusId,
    /// The server's node-ID.
    pub node: u8,
    /// The object, if known.
    pub mux: Option<Mux>,
    /// The next bytes.
    pub bytes: Vec<u8>,
}

impl Context<'_> {
    /// Raises a finding at the frame at hand. `cause` is the earlier frame it is about, if another.
    pub fn find(&mut self, code: Code, node: Option<u8>, object: Option<Mux>, cause: Option<FrameRef>, facts: Facts) {
        let finding = Finding { code, at: self.at, cause, bus: self.bus, node, object, facts, because_of: None };
        self.push(cause, node, What::Finding(Box::new(finding)));
    }

    /// Raises a finding at an earlier frame, which is wrong itself. `cause` as in [`Self::find`].
    pub fn find_at(
        &mut self,
        at: FrameRef,
        code: Code,
        node: Option<u8>,
        object: Option<Mux>,
        cause: Option<FrameRef>,
        facts: Facts,
    ) {
        let finding = Finding { code, at, cause, bus: self.bus, node, object, facts, because_of: None };
        let what = What::Finding(Box::new(finding));
        self.events.push(Event { at, about: cause, bus: self.bus, node, transfer: None, what });
    }

    /// Appends an event at the frame at hand.
    pub fn push(&mut self, about: Option<FrameRef>, node: Option<u8>, what: What) {
        self.events.push(Event { at: self.at, about, bus: self.bus, node, transfer: None, what });
    }
}
