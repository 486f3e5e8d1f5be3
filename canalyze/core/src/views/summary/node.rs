//! One node: its states, error control, SDO, EMCY, and its numbers of frames.
//!
//! It counts events and does not judge. Every list is bounded; further elements are only counted.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::period::spread::{Ranked, Spread};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::transfer::{Direction, Status, Transfer, TransferId};
use crate::sdo::wire::{Command, Mux, Side};
use crate::wire::error_control::BOOT_UP;
use crate::wire::nmt::commanded_state;
use crate::words::profiles::Profile;
use crate::world::change::{Change, EmcyChange};
use crate::world::event::{Place, Step};

/// Maximum number of listed changes of state.
pub const CHANGES: usize = 64;
/// Maximum number of distinct abort codes, and of emergency error codes, that are counted apart.
pub const CODES: usize = 32;
/// Maximum number of SDO requests that wait for their response at a time: one a channel.
const PENDING: usize = 8;
/// Maximum number of characters of the manufacturer device name (1008h) that are kept.
const NAME: usize = 64;
/// The manufacturer device name.
const DEVICE_NAME: Mux = Mux { index: 0x1008, sub: 0 };

/// A change of the node's state.
#[derive(Clone, Copy, Debug)]
pub struct StateChange {
    /// 00 (boot-up), 04, 05, 7F, or another value of error control.
    pub state: u8,
    /// The frame that shows it.
    pub at: FrameRef,
    /// It was commanded, and the node sends nothing that would confirm it.
    pub commanded: bool,
}

/// The occurrences of a code.
#[derive(Clone, Copy, Debug)]
pub struct Counted<K> {
    /// The code, with distinguishing data.
    pub code: K,
    /// The number of occurrences.
    pub count: u64,
    /// The first one.
    pub first: FrameRef,
    /// The last one.
    pub last: FrameRef,
}

/// Counts one occurrence; beyond [`CODES`] distinct codes nothing is kept.
fn count<K: PartialEq>(list: &mut Vec<Counted<K>>, code: K, at: FrameRef) {
    if let Some(counted) = list.iter_mut().find(|counted| counted.code == code) {
        counted.count += 1;
        counted.last = at;
    } else if list.len() < CODES {
        list.push(Counted { code, count: 1, first: at, last: at });
    }
}

/// The states of a node, by one kind of evidence.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// The last state; `None` if it is unknown.
    pub state: Option<u8>,
    /// The number of changes of state.
    pub changes: u64,
    /// The first [`CHANGES`] of these.
    pub listed: Vec<StateChange>,
}

impl Track {
    fn enters(&mut self, state: u8, at: FrameRef, commanded: bool) {
        self.state = Some(state);
        self.changes += 1;
        if self.listed.len() < CHANGES {
            self.listed.push(StateChange { state, at, commanded });
        }
    }
}

/// The figures of one node.
#[derive(Clone, Debug, Default)]
pub struct NodeSummary {
    /// Frames of its identifiers, to it and from it.
    pub frames: u64,
    /// Those of them that it sent.
    pub sent: u64,
    /// Frames of its TPDOs.
    pub tpdos: u64,
    /// Frames of its RPDOs.
    pub rpdos: u64,
    /// Its error control is lost: the state is the one before the loss.
    pub lost: bool,
    /// Boot-ups.
    pub boot_ups: u64,
    /// Heartbeats, and responses to node guarding.
    pub heartbeats: u64,
    /// Times between them, in ns.
    pub heartbeat: Spread,
    /// Node guarding was seen.
    pub guarded: bool,
    /// Its device profile, if it is known from an EMCY.
    pub profile: Profile,
    /// EMCYs.
    pub emcys: u64,
    /// By error code, with the error register of the last one.
    pub emcy_codes: Vec<Counted<u16>>,
    /// SDO transfers by their outcome: ok, aborted, failed, incomplete.
    pub transfers: [u64; 4],
    /// Times from a request to its response, in ns.
    pub response: Ranked,
    /// Aborts by abort code and sender.
    pub aborts: Vec<Counted<(AbortCode, Side)>>,
    /// The value of an upload of 1008h, if it is text.
    pub device_name: Option<String>,
    /// States by boot-ups and heartbeats.
    shown: Track,
    /// States by boot-ups and NMT commands.
    commanded: Track,
    last_heartbeat_ns: Option<Ns>,
    pending: Vec<(TransferId, Ns)>,
}

impl NodeSummary {
    /// Its states: those that it shows itself; the commanded ones only if it sends no state of its own.
    pub fn states(&self) -> &Track {
        if self.heartbeats > 0 { &self.shown } else { &self.commanded }
    }

    /// Stops the measurement of times, since frames of the bus were lost.
    pub fn lost(&mut self) {
        self.last_heartbeat_ns = None;
        self.pending.clear();
    }

    /// Takes a change of its state, a report of it, a command or an emergency.
    pub fn change(&mut self, change: &Change, at: FrameRef) {
        match *change {
            Change::BootUp { .. } => {
                self.boot_ups += 1;
                self.lost = false;
                self.last_heartbeat_ns = None;
                self.shown.enters(0, at, false);
                self.commanded.enters(0, at, false);
            }
            Change::State { state, guarding, .. } => {
                self.heartbeats += 1;
                self.lost = false;
                self.guarded |= guarding;
                if let (Some(now), Some(before)) = (at.t_ns, self.last_heartbeat_ns)
                    && now >= before
                {
                    self.heartbeat.add(now - before);
                }
                self.last_heartbeat_ns = at.t_ns;
                if self.shown.state != Some(state) {
                    self.shown.enters(state, at, false);
                }
            }
            Change::Error(EmcyChange { code, profile, .. }) => {
                self.profile = profile;
                self.emcys += 1;
                count(&mut self.emcy_codes, code, at);
            }
            Change::Command { command, .. } => self.command(command, at),
            Change::Lost { .. } => self.lost = true,
            _ => {}
        }
    }

    /// Takes an NMT command to it.
    pub fn command(&mut self, command: u8, at: FrameRef) {
        let Some(state) = commanded_state(command).filter(|state| *state != BOOT_UP) else { return };
        if self.commanded.state != Some(state) {
            self.commanded.enters(state, at, true);
        }
    }

    /// Takes a frame of one of its SDO channels. A response is timed only if it is due and was captured after its
    /// request; consecutive block segments are not responses.
    pub fn sdo(&mut self, step: &Step, transfer: Option<TransferId>, at: FrameRef) {
        let (client, due) = (step.side == Side::Client, step.place == Place::Due);
        let ends = matches!(step.command, Command::Abort(..) | Command::BlockEnded);
        let asks = client && step.answered_by.is_none() && due && !ends;
        self.exchange(transfer, (asks, !client && due), at);
    }

    /// Takes a frame of a transfer that asks for a response or is one.
    pub fn exchange(&mut self, transfer: Option<TransferId>, (asks, responds): (bool, bool), at: FrameRef) {
        let Some(id) = transfer else { return };
        let place = self.pending.iter().position(|(pending, _)| *pending == id);
        let requested_ns = place.map(|place| self.pending.swap_remove(place).1);
        let Some(now_ns) = at.t_ns else { return };
        if asks && self.pending.len() < PENDING {
            self.pending.push((id, now_ns));
        }
        if let Some(requested_ns) = requested_ns.filter(|requested| responds && now_ns >= *requested) {
            self.response.add(now_ns - requested_ns);
        }
    }

    /// Takes an SDO transfer that has ended.
    pub fn transfer(&mut self, transfer: &Transfer, at: FrameRef) {
        self.pending.retain(|(id, _)| *id != transfer.id);
        let slot = match transfer.outcome.status {
            Status::Ok => 0,
            Status::Aborted => 1,
            Status::Failed => 2,
            Status::Incomplete | Status::Open => 3,
        };
        if let Some(slot) = self.transfers.get_mut(slot) {
            *slot += 1;
        }
        if let Some(abort) = transfer.outcome.abort {
            count(&mut self.aborts, (abort.code, abort.by), at);
        }
        let read = transfer.direction == Direction::Upload && transfer.outcome.status == Status::Ok;
        if read && transfer.mux == Some(DEVICE_NAME) && !transfer.data.hole {
            let text = transfer.data.kept.split(|byte| *byte == 0).next().unwrap_or(&[]).trim_ascii();
            if let Ok(name) = std::str::from_utf8(text)
                && !name.is_empty()
                && !name.contains(char::is_control)
            {
                self.device_name = Some(name.chars().take(NAME).collect());
            }
        }
    }
}
