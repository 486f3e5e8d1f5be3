//! One node's NMT state as far as the capture shows it: its reports, commands, and unexplained changes.

use super::super::limits::BOOT_NS;
use super::{LEAST_BOOT_NS, RESETS_NS};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::When;
use crate::rules::finding::Finding;
use crate::rules::nmt::Nmt002;
use crate::wire::error_control::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::world::context::Context;

/// Time after its boot-up in which a slave starts itself, in ns; it reports Pre-operational at most once.
const SELF_START_NS: Ns = Ns::from_s(5);

/// Maximum time in ns, and number of frames, from an emergency to a change of state that it explains (1029h).
const EMERGENCY_NS: Ns = Ns::from_s(1);
const EMERGENCY_FRAMES: u64 = 10;
/// Number of missing heartbeats after which a possible master has not returned from a reset.
const MASTER_PERIODS: i64 = 4;
/// Part of a heartbeat period by which one that is sent a period after another may be early.
const ON_TIME_PART: i64 = 16;
/// Time after a reset in which a boot-up was sent before the node saw it, in ns.
const SENT_NS: Ns = Ns::from_ms(1);

/// One node's state as far as the capture shows it.
#[derive(Debug, Default)]
pub(super) struct NodeState {
    /// It has sent a frame; its last frame since a gap.
    pub(super) present: bool,
    pub(super) heard: Option<FrameRef>,
    /// A master commands or configures it, or it has obeyed a command to all, so it is not the master itself.
    pub(super) managed: bool,
    /// Its SDO server was asked: by its master, or by a tool that reads from the master.
    pub(super) asked: bool,
    pub(super) reports: Reports,
    /// The last command, until the node has obeyed it.
    pub(super) command: Option<PendingCommand>,
    /// States commanded since the node last reported a commanded one: bit 0 Stopped, 1 Operational, 2 Pre-operational.
    pub(super) allowed: u8,
    pub(super) boots: Boots,
    pub(super) reset: Reset,
    /// Its boot-up is the first frame of the network, before any command, and it has obeyed no reset since.
    pub(super) first: bool,
    /// LSS has assigned this node-ID, and no node has booted with it yet.
    pub(super) given: bool,
    /// Its last emergency, except those that end an error.
    pub(super) emergency: Option<FrameRef>,
    /// A change that it explained: the previous state, and the finding left out.
    pub(super) excused: Option<(u8, Finding)>,
    pub(super) suspect: Option<Suspect>,
}

/// The states reported by a node since its last boot-up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reports {
    /// The last state, and the first frame that reported it.
    pub(super) first: Option<(u8, FrameRef)>,
    /// The last frame that reported a state, and the number of such frames.
    pub(super) last: Option<FrameRef>,
    pub(super) count: u8,
    /// The period of its reports if known, in ns.
    pub(super) period_ns: Option<Ns>,
    /// A change without command was reported, and the state has not been confirmed since.
    pub(super) unsettled: bool,
}

/// A node's boot-ups.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Boots {
    pub(super) last: Option<FrameRef>,
    /// The last unexplained one, except the first.
    pub(super) unexplained: Option<FrameRef>,
    /// The last one came while the node reported states, and nothing but its supply explains it.
    pub(super) unasked: bool,
}

/// Resets of a node by command.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reset {
    /// The number of resets without boot-up, and the last of all.
    pub(super) count: u8,
    pub(super) at: Option<FrameRef>,
    pub(super) specifier: u8,
    /// The last of them still waits for its boot-up.
    pub(super) awaited: bool,
    /// Since then the node has reported a state, or sent an unreadable frame that may be its boot-up.
    pub(super) heard: bool,
}

/// A command that waits for its effect.
#[derive(Clone, Copy, Debug)]
pub(super) struct PendingCommand {
    pub(super) state: u8,
    pub(super) specifier: u8,
    pub(super) at: FrameRef,
    pub(super) when: When,
    /// It was addressed to this node, or to all while the node is not the master.
    pub(super) sure: bool,
    /// The number of frames since then that reported another state, and the first of them.
    pub(super) wrong: u8,
    pub(super) first: Option<FrameRef>,
    pub(super) judged: bool,
    /// The frame at which it was reported as disobeyed.
    pub(super) reported: Option<FrameRef>,
}

impl PendingCommand {
    pub(super) const fn new(state: u8, specifier: u8, when: When, sure: bool) -> Self {
        Self { state, specifier, at: when.at, when, sure, wrong: 0, first: None, judged: false, reported: None }
    }
}

/// A seemingly spontaneous event that may still be explained.
#[derive(Clone, Copy, Debug)]
pub(super) struct Suspect {
    pub(super) at: FrameRef,
    /// The node's frame before it, or the same: the command may have been between them.
    pub(super) since: When,
    pub(super) what: Spontaneous,
    /// The frame may be a second capture of another.
    pub(super) duplicate: bool,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Spontaneous {
    /// `wait_ns`: time in which two nodes with one node-ID may explain it.
    Change {
        from: u8,
        to: u8,
        wait_ns: Ns,
    },
    BootUp {
        last: FrameRef,
    },
    /// The last boot-up is not in the capture, but the node was running.
    Restart {
        last: FrameRef,
    },
    TwoBootUps {
        last: FrameRef,
    },
}

impl NodeState {
    /// Drops resets that were answered by a boot-up long ago.
    pub(super) fn forget_answered_resets(&mut self, at: FrameRef) {
        let answered = self.boots.last.zip(self.reset.at).is_some_and(|(boot_up, reset)| boot_up.no > reset.no);
        if answered && at.since(self.reset.at).is_some_and(|age| age > RESETS_NS) {
            self.reset.count = 0;
        }
    }

    /// Takes the node's boot-up, which clears its reports.
    pub(super) fn boot(&mut self, at: FrameRef) {
        let crossed = at.since(self.reset.at).is_some_and(|age| age < SENT_NS);
        let count = self.reset.count.saturating_sub(u8::from(!crossed));
        *self = Self {
            present: true,
            heard: Some(at),
            managed: self.managed || self.reset.awaited,
            asked: self.asked,
            boots: Boots { last: Some(at), ..Boots::default() },
            reset: Reset { count, at: self.reset.at, ..Reset::default() },
            first: self.first,
            emergency: self.emergency,
            suspect: self.suspect,
            ..Self::default()
        };
    }

    /// Returns true if an emergency explains a change of state.
    pub(super) fn has_emergency(&self, changed: FrameRef) -> bool {
        let before =
            |at: FrameRef| changed.since(at).map_or(at.no + EMERGENCY_FRAMES >= changed.no, |age| age <= EMERGENCY_NS);
        self.emergency.is_some_and(before)
    }

    /// Takes a command; returns true if it explains the suspect.
    pub(super) fn commanded(
        &mut self,
        node: u8,
        (state, specifier, explicit): (u8, u8, bool),
        cx: &mut Context<'_>,
    ) -> bool {
        let at = cx.at;
        self.managed |= explicit;
        self.restarted_silently(node, cx);
        let explains = self.suspect.is_some_and(|suspect| match suspect.what {
            // Some nodes boot without a boot-up message.
            Spontaneous::Change { to, .. } => state == to || (state == 0 && to == PRE_OPERATIONAL),
            _ => state == 0,
        });
        if explains {
            self.suspect = None;
        }
        // A reset just after a boot-up may have been sent before it, to a node not yet present.
        let crossed = state == 0 && self.boots.last.is_some_and(|boot| !cx.evidence.recording.is_settled(boot, at));
        // A master goes on as before where it stops or resets all others.
        let goes_on = state != OPERATIONAL && self.reports.first.is_none_or(|(shown, _)| shown == OPERATIONAL);
        let sure = (explicit || self.managed || self.asked && !goes_on) && !crossed;
        let command = PendingCommand::new(state, specifier, cx.when, sure);
        if state == 0 {
            if explains {
                return true;
            }
            self.reset.count = (self.reset.count + 1).min(3);
            (self.reset.at, self.reset.specifier) = (Some(at), specifier);
            (self.reset.awaited, self.reset.heard) = (true, false);
            self.allowed = bits_of(0);
            self.command = Some(command);
            return false;
        }
        self.allowed |= bit(state);
        let there = self.reports.first.is_some_and(|(shown, _)| shown == state) && (explains || self.command.is_none());
        self.command = Some(command).filter(|_| !there);
        if there {
            self.allowed = 0;
        }
        explains
    }

    /// Returns true if the node may be the master itself.
    pub(super) fn may_be_master(&self) -> bool {
        !self.managed && (self.boots.last.is_none() || self.first)
    }

    /// Returns true if the node, which nobody manages, has gone on after a reset: of several such nodes one may be the master.
    pub(super) fn goes_on_unmanaged(&self, reset: FrameRef) -> bool {
        !self.managed && self.reset.awaited && self.heard.is_some_and(|heard| heard.no > reset.no)
    }

    /// Returns true if the node has sent nothing but its boot-up, and nobody asks or manages it: it may be a master without
    /// heartbeats.
    pub(super) fn has_only_booted(&self) -> bool {
        !self.managed && !self.asked && self.heard.is_some() && self.heard == self.boots.last
    }

    /// Returns the time in ns after which a reset must be followed by a boot-up; `None` if one came just before it and
    /// may be its answer. A possible master goes on instead and is heard by its next heartbeats.
    pub(super) fn owes_boot_up(&self, cx: &Context<'_>) -> Option<Ns> {
        let answered = self.boots.last.is_some_and(|boot_up| !cx.evidence.recording.is_settled(boot_up, cx.at));
        if self.heard.is_none() || !self.reset.awaited || answered {
            return None;
        }
        if self.may_be_master() {
            return Some(BOOT_NS.max(self.reports.period_ns? * MASTER_PERIODS));
        }
        Some(LEAST_BOOT_NS)
    }

    /// Reports a missing boot-up at the next command: the node was in another state and is Pre-operational since the
    /// reset.
    fn restarted_silently(&mut self, node: u8, cx: &mut Context<'_>) {
        let Some(command) = self.command.filter(|command| command.state == 0 && command.sure && !command.judged) else {
            return;
        };
        let fresh = self.reports.first.filter(|(state, at)| *state == PRE_OPERATIONAL && at.no > command.at.no);
        if let (Some((state, _)), true, Some(first)) = (fresh, command.wrong > 1, command.first) {
            self.reset.awaited = false;
            let what = Nmt002::NoBootUp { command: command.specifier, found: state };
            let finding = cx.verdict(what, Some(node), None, Some(command.at));
            cx.report(Finding { at: first, ..finding });
        }
    }

    /// Compares a reported state with the last command.
    pub(super) fn obeys(&mut self, node: u8, state: u8, period_ns: Option<Ns>, cx: &mut Context<'_>) {
        let Some(command) = &mut self.command else { return };
        if command.state == state {
            let changed = self.reports.first.is_some_and(|(before, _)| before != state);
            // A master may start itself with its slaves.
            self.managed |= changed && state != OPERATIONAL;
            (self.command, self.allowed) = (None, 0);
            return;
        }
        if command.judged {
            return;
        }
        self.reset.heard |= command.state == 0;
        command.wrong = command.wrong.saturating_add(1);
        command.first = command.first.or(Some(cx.at));
        // A device may store something before it obeys a reset.
        let least = if command.state == 0 { RESETS_NS } else { Ns::ZERO };
        let late = match (cx.at.since(command.at), period_ns) {
            // A heartbeat on its way, and then a second one: the node has had a whole period.
            (Some(_), Some(period)) => {
                let limit_ns = (period - period / ON_TIME_PART).max(least);
                command.wrong > 1 && cx.evidence.recording.certainly_later(cx.when, command.when, limit_ns)
            }
            (Some(age), None) => command.wrong > 2 && age > least,
            (None, _) => command.wrong > 2,
        };
        if !late {
            return;
        }
        command.judged = true;
        command.reported = Some(cx.at).filter(|_| command.sure);
        let PendingCommand { state: expected, specifier, at, sure, .. } = *command;
        if expected == 0 {
            // It goes on as before.
            (self.reset.awaited, self.allowed) = (false, 0);
        }
        if sure {
            let (command, found) = (specifier, state);
            let no_boot_up = Nmt002::NoBootUp { command, found };
            let what = if expected == 0 { no_boot_up } else { Nmt002::Still { command, found } };
            cx.raise(what, Some(node), None, Some(at));
        }
    }

    /// Returns true if a change may be the node's own start: soon after its boot-up, or by a master, which starts when
    /// its slaves are ready.
    pub(super) fn starts_itself(&self, from: u8, to: u8, at: FrameRef) -> bool {
        if from != PRE_OPERATIONAL || to != OPERATIONAL || self.command.is_some() {
            return false;
        }
        !self.managed
            || self.reports.count <= 2
                && at
                    .since(self.boots.last)
                    .map_or(self.boots.last.is_some_and(|boot| boot.no + 50 > at.no), |age| age < SELF_START_NS)
    }
}

pub(super) const fn bit(state: u8) -> u8 {
    match state {
        STOPPED => 1,
        OPERATIONAL => 2,
        PRE_OPERATIONAL => 4,
        _ => 0,
    }
}

/// Returns the states that a command may lead to; 0 is a reset.
pub(super) const fn bits_of(commanded: u8) -> u8 {
    match commanded {
        0 => bit(STOPPED) | bit(OPERATIONAL) | bit(PRE_OPERATIONAL),
        state => bit(state),
    }
}
