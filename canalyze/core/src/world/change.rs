//! Changes of states: derived once for each bus from what its checks know, and published as events.
//!
//! A change is published before the findings of its frame; views render changes and follow no service for themselves. A
//! second capture of a frame, and a frame whose identifier carries another protocol, change nothing.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::finding::{Code, Finding, Quantity};
use crate::wire::cob_id::Role;
use crate::wire::error_control::{BOOT_UP, OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::message::{Errors, Message};
use crate::words::profiles::Profile;
use crate::world::configuration::Provenance;
use crate::world::drive::{self, DriveState};
use crate::world::node::PerNode;

/// A change of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// A node has booted.
    BootUp {
        /// The node.
        node: u8,
    },
    /// A node reports its state, another one or the same ([`Change::is_news`]).
    State {
        /// The node.
        node: u8,
        /// In the encoding of error control, without the toggle bit.
        state: u8,
        /// The state that it reported before, 00 for a boot-up; `None` if unknown.
        previous: Option<u8>,
        /// By a response to node guarding instead of a heartbeat.
        guarding: bool,
        /// The first report after its loss.
        returns: bool,
    },
    /// An NMT command asks for a state.
    Command {
        /// The command specifier.
        command: u8,
        /// The addressed node, 0 = all; above 127 it is invalid.
        node: u8,
    },
    /// The error control of a node is lost, until it reports a state again.
    Lost {
        /// The node; `None`: all nodes, since the whole bus is silent.
        node: Option<u8>,
        /// The reason.
        by: LostBy,
        /// The time from which on its state is unknown, in ns, if known.
        since_ns: Option<Ns>,
    },
    /// A node reports an error, or that errors are gone.
    Error(EmcyChange),
    /// A statusword shows the state of an axis of a drive, another one or the same ([`Change::is_news`]).
    Drive {
        /// The node.
        node: u8,
        /// The axis, from 0.
        axis: u8,
        /// 6041h of the axis.
        statusword: u16,
        /// `None` if CiA 402 does not define the statusword.
        state: Option<DriveState>,
        /// The statusword before it, also before a restart or lost frames; `None` if it is the first.
        previous: Option<u16>,
        /// The source of the statusword.
        by: DriveEvidence,
    },
    /// A SYNC cycle has begun.
    SyncCycle {
        /// Its number in the capture, from 1.
        cycle: u64,
        /// The counter of its SYNC.
        counter: Option<u8>,
    },
}

/// The source of a statusword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveEvidence {
    /// A TPDO, with the source of its mapping.
    Pdo(Provenance),
    /// An upload.
    Sdo,
}

impl DriveEvidence {
    /// Returns true for an upload, and for a PDO whose mapping is not in doubt.
    pub fn is_sure(self) -> bool {
        !matches!(self, Self::Pdo(from) if from.is_doubted())
    }
}

/// The sign that a node is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LostBy {
    /// Its heartbeat is missing.
    Heartbeat,
    /// It does not respond to node guarding.
    Guarding,
    /// The whole bus is silent.
    Silence,
}

/// An EMCY (CiA 301, 7.2.7) and the errors of its node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmcyChange {
    /// The producer.
    pub node: u8,
    /// EmcyChange error code.
    pub code: u16,
    /// The device profile that defines the code, as far as known.
    pub profile: Profile,
    /// Error register (object 1001h).
    pub register: u8,
    /// Manufacturer-specific bytes.
    pub manufacturer: [u8; 5],
    /// The node's active errors after it.
    pub active: Errors,
    /// The errors that it clears.
    pub cleared: Errors,
}

impl Change {
    /// Returns the node that changes; `None` for several, or for the bus.
    pub fn node(&self) -> Option<u8> {
        match *self {
            Self::BootUp { node } | Self::State { node, .. } | Self::Drive { node, .. } => Some(node),
            Self::Command { node, .. } => Some(node).filter(|node| (1..=127).contains(node)),
            Self::Lost { node, .. } => node,
            Self::Error(emergency) => Some(emergency.node),
            Self::SyncCycle { .. } => None,
        }
    }

    /// Returns true unless a node or an axis reports the state that it is known to be in.
    pub fn is_news(&self) -> bool {
        match *self {
            Self::State { state, previous: Some(before), returns: false, .. } => state != before,
            Self::Drive { state, previous, .. } => previous.map(DriveState::of) != Some(state),
            _ => true,
        }
    }

    /// Returns true if a node reports another state than the one that it reported before, boot-ups apart: such a report
    /// may come at any time.
    pub fn is_another_state(&self) -> bool {
        let Self::State { state, previous: Some(before), .. } = *self else { return false };
        before != state && before != BOOT_UP
    }

    /// Returns the loss that a finding reports.
    pub fn of_finding(finding: &Finding) -> Option<Self> {
        let after = |from: Option<FrameRef>, name, sign: i64| match finding.measured()?.get(name)? {
            Quantity::Ns(ns) => Some(from?.t_ns? + sign * ns),
            _ => None,
        };
        let (by, since_ns) = match finding.code {
            Code::Hbt002 => (LostBy::Heartbeat, after(finding.cause, "limit", 1)),
            Code::Grd002 => (LostBy::Guarding, None),
            Code::Hbt005 => (LostBy::Silence, after(Some(finding.at), "silence", -1)),
            _ => return None,
        };
        Some(Self::Lost { node: finding.node, by, since_ns })
    }
}

/// The last published state of a node.
#[derive(Clone, Copy, Debug, Default)]
struct LastPublished {
    /// The state that it reported.
    state: Option<u8>,
    /// It is lost.
    lost: bool,
    axes: [LastStatusword; drive::AXES as usize],
}

/// The last statusword of an axis.
#[derive(Clone, Copy, Debug, Default)]
struct LastStatusword {
    /// The state that one with a sure source showed; `None` once the node has restarted or frames were lost.
    state: Option<DriveState>,
    /// The statusword itself, also after that.
    word: Option<u16>,
    /// Its frame, or that of a later restart or loss.
    at: FrameRef,
}

/// The states that were published last.
#[derive(Debug, Default)]
pub struct Publisher {
    nodes: PerNode<LastPublished>,
    cycle: u64,
}

impl Publisher {
    /// Returns the change that a message shows. `reported`: the last state that the checks have taken from the node of
    /// the message; `cycle`: the current SYNC cycle.
    pub fn message(&mut self, message: &Message, reported: Option<u8>, cycle: u64) -> Option<Change> {
        match *message {
            Message::BootUp { node } => {
                let last = self.nodes.entry(node);
                (last.state, last.lost) = (Some(BOOT_UP), false);
                Some(Change::BootUp { node })
            }
            Message::Heartbeat { node, state, guarding, .. } => {
                if matches!(state, STOPPED | OPERATIONAL | PRE_OPERATIONAL) {
                    return Some(self.report(node, reported?, guarding));
                }
                // Only the states of CiA 301 are kept; another one is a change each time.
                let previous = self.nodes.entry(node).state;
                Some(Change::State { node, state, previous, guarding, returns: false })
            }
            // Its length is wrong; it may be too short to show a state.
            Message::Malformed { role: Role::ErrorControl(node), .. } => {
                Some(self.report(node, reported?, false)).filter(Change::is_news)
            }
            Message::Nmt { command, node } => Some(Change::Command { command, node }),
            Message::Emcy { node, code, profile, register, manufacturer, active, cleared } => {
                Some(Change::Error(EmcyChange { node, code, profile, register, manufacturer, active, cleared }))
            }
            _ if cycle > self.cycle => {
                self.cycle = cycle;
                let counter = if let Message::Sync { counter } = *message { counter } else { None };
                Some(Change::SyncCycle { cycle, counter })
            }
            _ => None,
        }
    }

    /// Returns the change that a statusword shows, the object at `index`; `None` if a later one is known.
    pub fn statusword(&mut self, node: u8, index: u16, word: u16, at: FrameRef, by: DriveEvidence) -> Option<Change> {
        let axis = drive::axis(index)?;
        let last = self.nodes.entry(node).axes.get_mut(usize::from(axis)).filter(|last| at.no >= last.at.no)?;
        let (state, previous) = (DriveState::of(word), last.word.replace(word));
        if by.is_sure() {
            (last.state, last.at) = (state, at);
        }
        Some(Change::Drive { node, axis, statusword: word, state, previous, by })
    }

    /// Returns the axes of a node whose state is known by a sure source, each with its number from 0, its state, and the frame of its last
    /// statusword.
    pub fn axes(&self, node: u8) -> impl Iterator<Item = (usize, DriveState, FrameRef)> {
        let axes = self.nodes.get(node).into_iter().flat_map(|last| last.axes.iter().enumerate());
        axes.filter_map(|(number, last)| Some((number, last.state?, last.at)))
    }

    /// Forgets the states of the axes of a node, or of all, which restart at a frame.
    pub fn restart(&mut self, node: Option<u8>, at: FrameRef) {
        for (_, last) in self.nodes.iter_mut().filter(|(id, _)| node.is_none_or(|node| node == *id)) {
            last.axes.iter_mut().for_each(|axis| (axis.state, axis.at) = (None, at));
        }
    }

    fn report(&mut self, node: u8, state: u8, guarding: bool) -> Change {
        let last = self.nodes.entry(node);
        let (previous, returns) = (last.state.replace(state), std::mem::take(&mut last.lost));
        Change::State { node, state, previous, guarding, returns }
    }

    /// Takes a published change, in order: a node may be back in the frame that shows its loss.
    pub fn published(&mut self, change: &Change) {
        match *change {
            Change::BootUp { node } | Change::State { node, .. } => self.nodes.entry(node).lost = false,
            Change::Lost { node: Some(node), .. } => self.nodes.entry(node).lost = true,
            Change::Lost { node: None, .. } => self.nodes.iter_mut().for_each(|(_, last)| last.lost = true),
            _ => {}
        }
    }

    /// Forgets the states after lost frames behind this one.
    pub fn forget(&mut self, at: FrameRef) {
        self.nodes.iter_mut().for_each(|(_, last)| *last = LastPublished { axes: last.axes, ..Default::default() });
        self.restart(None, at);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::world::drive::DriveState::{OperationEnabled, ReadyToSwitchOn};

    fn frame(no: u64) -> FrameRef {
        FrameRef { no, ..FrameRef::default() }
    }

    /// Takes a statusword of the second axis of node 5 and returns its state, the statusword before it, and true if it
    /// is news; `None` if a later one is known.
    fn take(publisher: &mut Publisher, no: u64, word: u16) -> Option<(Option<DriveState>, Option<u16>, bool)> {
        let change = publisher.statusword(5, 0x6841, word, frame(no), DriveEvidence::Sdo)?;
        let Change::Drive { node: 5, axis: 1, statusword, state, previous, .. } = change else { panic!("{change:?}") };
        assert_eq!(statusword, word);
        Some((state, previous, change.is_news()))
    }

    fn known(publisher: &Publisher) -> Vec<(usize, DriveState, u64)> {
        publisher.axes(5).map(|(axis, state, at)| (axis, state, at.no)).collect()
    }

    #[test]
    fn statuswords() {
        let mut all = Publisher::default();
        assert_eq!(known(&all), []);
        assert_eq!(take(&mut all, 1, 0x0231), Some((Some(ReadyToSwitchOn), None, true)));
        assert_eq!(take(&mut all, 2, 0x0631), Some((Some(ReadyToSwitchOn), Some(0x0231), false)));
        assert_eq!(take(&mut all, 9, 0x0237), Some((Some(OperationEnabled), Some(0x0631), true)));
        assert_eq!(known(&all), [(1, OperationEnabled, 9)]);
        // An upload that is reported after a later PDO.
        assert_eq!(take(&mut all, 8, 0x0231), None);
        // CiA 402 does not define it.
        assert_eq!(take(&mut all, 10, 0x0022), Some((None, Some(0x0237), true)));
        assert_eq!(take(&mut all, 11, 0x0001), Some((None, Some(0x0022), false)));
        assert_eq!(known(&all), []);
        assert_eq!(take(&mut all, 12, 0x0237), Some((Some(OperationEnabled), Some(0x0001), true)));
    }

    #[test]
    fn statuswords_after_a_restart_and_after_lost_frames() {
        let mut all = Publisher::default();
        take(&mut all, 1, 0x0237).unwrap();
        all.restart(Some(6), frame(2));
        assert_eq!(known(&all), [(1, OperationEnabled, 1)]);
        all.restart(Some(5), frame(4));
        assert_eq!(known(&all), []);
        // Its mapping may have changed.
        let by = DriveEvidence::Pdo(Provenance::Doubted(1));
        assert!(all.statusword(5, 0x6841, 0x0237, frame(5), by).is_some());
        assert_eq!(known(&all), []);
        // From before the restart.
        assert_eq!(take(&mut all, 3, 0x0237), None);
        assert_eq!(take(&mut all, 5, 0x0237), Some((Some(OperationEnabled), Some(0x0237), false)));
        all.forget(frame(7));
        assert_eq!(known(&all), []);
        assert_eq!(take(&mut all, 6, 0x0237), None);
        assert_eq!(take(&mut all, 8, 0x0231), Some((Some(ReadyToSwitchOn), Some(0x0237), true)));
    }
}
