//! NMT states (CiA 301, 7.3.2): the state of each node, its evidence, and its cause.
//!
//! A state is unknown until the node reports it by a heartbeat or a guarding answer. A boot-up shows that the node is
//! there, not where it went from Initialisation (1F80h may start it). A command is not confirmed: it shows the expected
//! state and proves nothing. Changes that no command explains are withheld, since the master's own frames may be
//! captured late. Other services are judged in `permissions`.

pub mod commandless;
mod node_state;
pub mod permissions;

use self::commandless::Commandless;
use self::node_state::{NodeState, PendingCommand, Reports, Spontaneous, Suspect, bit, bits_of};
use super::limits::{BOOT_NS, POWER_UP_NS};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::Obligations;
use crate::evidence::circumstance::CircumstanceKind as Circumstance;
use crate::evidence::duplicates::Sighting;
use crate::evidence::obligation::Owed;
use crate::evidence::{Rules, When};
use crate::rules::finding::{Finding, Verdict};
use crate::rules::heartbeat::Hbt004;
use crate::rules::nmt::{Nmt001, Nmt003, Nmt004, Nmt005, Nmt006};
use crate::wire::error_control::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::lss::Command as Lss;
use crate::wire::nmt;
use crate::world::context::Context;
use crate::world::node::PerNode;

/// Silence of the bus, in ns, after which boot-ups belong to a network that was switched on.
pub(super) const SWITCHED_ON_NS: Ns = Ns::from_s(2);
/// Maximum number of frames between the boot-ups of nodes switched on together, used without stamps.
const TOGETHER: u64 = 10;
/// Time in which several resets in a row may cause as many boot-ups, in ns.
pub(super) const RESETS_NS: Ns = Ns::from_s(1);
/// Time in which a boot-up is explained by LSS returning its slaves to waiting, in ns.
const ACTIVATED_NS: Ns = Ns::from_s(5);
/// Boot-ups of one node-ID closer than this come from two nodes, in ns.
const TWO_BOOT_UPS_NS: Ns = Ns::from_ms(20);
/// A node that boots within this time after its last heartbeat did not lose its power, in ns; or within the time after
/// which heartbeats are missing.
const RESTART_NS: Ns = Ns::from_s(1);
/// Maximum time of a boot-up after a reset at the end of a capture, in ns, for a node that has sent nothing since.
const LEAST_BOOT_NS: Ns = Ns::from_s(1);
/// Time for which a node seen first after a command may show its old state, in ns.
const FIRST_SEEN_NS: Ns = Ns::from_s(1);
/// Number of heartbeat periods for which a change of state waits: two nodes with one node-ID alternate.
const ALTERNATES: i64 = 3;
/// Time in which a node may act, and others address it, as before a command, in ns.
pub(super) const OBEYED_NS: Ns = Ns::from_ms(50);
/// The same in frames, used without stamps.
const OBEYED_FRAMES: u64 = 8;
/// Number of reported states that show a running node, not one about to obey a reset before the capture.
const RUNNING: u8 = 3;
/// Maximum time from a frame taken for a reset to the boot-up, in ns.
const GARBLED_NS: Ns = Ns::from_s(5);
/// Known commands beyond CiA 301: sleep and standby.
const EXTENSIONS: [u8; 2] = [0x50, 0x60];

/// Evidence that the network was switched off and on.
#[derive(Clone, Copy, Debug)]
struct Power {
    /// Several nodes, and all of them, have just booted without command.
    all: bool,
    /// There are nodes that have not, and the number of the last frame of any of them.
    others: bool,
    heard: u64,
}

impl Power {
    /// Returns true if the other nodes are undecided, because none was heard since the boot-up at `boot`.
    fn is_open(self, boot: FrameRef, at: FrameRef) -> bool {
        let soon = at.since(boot).map_or(boot.no + TOGETHER >= at.no, |age| age <= SWITCHED_ON_NS);
        self.others && self.heard < boot.no && soon
    }
}

/// A known state, for verdicts on other services.
#[derive(Clone, Copy, Debug)]
pub struct KnownState {
    /// 04, 05, 7F.
    pub state: u8,
    /// The frame that first reported or commanded the state.
    pub at: FrameRef,
    /// True if the node reported it, false if it was commanded.
    pub shown: bool,
    /// The node may still be a master that starts itself.
    pub may_start_itself: bool,
    /// It was reported once, and no command explains it.
    pub doubtful: bool,
    /// The frame at which the node was reported for not having started by a command.
    pub not_started: Option<FrameRef>,
}

/// The states of a bus's nodes.
#[derive(Debug, Default)]
pub struct Nmt {
    nodes: PerNode<NodeState>,
    suspects: u32,
    commandless: Commandless,
    /// Boot-ups due after a reset.
    boot_ups: Obligations<u8>,
    /// Some node has booted or reported its state: the capture contains such frames.
    shows_states: bool,
    /// The last command to all, for nodes not seen before it.
    broadcast: Option<PendingCommand>,
    activated: Option<Ns>,
    /// The first frame of the capture or after a gap.
    began: Option<FrameRef>,
    /// The last boot-up with an assigned node-ID.
    moved: Option<FrameRef>,
    /// The time of the first boot-up after a silence, when the network was switched on, in ns.
    switched_on: Option<Ns>,
    /// The last invalid frame on the NMT identifier; nodes may have obeyed its intended command.
    garbled: Option<FrameRef>,
    /// Commands always preceded their effects: the capture is in causal order.
    causal: bool,
    late: bool,
}

/// Returns the place of a node's last frame before the current one; that of the current one if there is none.
fn since(last: Option<FrameRef>, cx: &Context<'_>) -> When {
    last.map_or(cx.when, |last| cx.evidence.recording.at(last))
}

impl Nmt {
    /// Returns the NMT state of a node if known: 04, 05, 7F. A command counts for nodes known to be present.
    pub fn state(&self, node: u8) -> Option<u8> {
        let node_state = self.nodes.get(node)?;
        match node_state.command {
            Some(command) if !command.judged => {
                let counts = command.sure && node_state.present && command.wrong == 0 && command.state != 0;
                counts.then_some(command.state)
            }
            _ => node_state.reports.first.map(|(state, _)| state),
        }
    }

    /// Returns the last boot-up of a node if it is the second one for no reason.
    pub fn booted_twice(&self, node: u8) -> Option<FrameRef> {
        let suspect = self.nodes.get(node)?.suspect?;
        matches!(suspect.what, Spontaneous::TwoBootUps { .. }).then_some(suspect.at)
    }

    /// Returns the state with its evidence, for verdicts.
    pub fn known(&self, node: u8) -> Option<KnownState> {
        let node_state = self.nodes.get(node)?;
        let Some(state) = self.state(node) else {
            // A node that has booted is Pre-operational, unless it starts itself.
            let at = node_state.boots.last.filter(|_| node_state.command.is_none() && !node_state.reset.awaited)?;
            let (shown, may_start_itself, doubtful) = (false, true, true);
            return Some(KnownState {
                state: PRE_OPERATIONAL,
                at,
                shown,
                may_start_itself,
                doubtful,
                not_started: None,
            });
        };
        let may_start_itself = state == PRE_OPERATIONAL && !node_state.managed && node_state.command.is_none();
        // An unreadable frame since then may have been a command to this node.
        let commanded = |last: FrameRef| self.garbled.is_some_and(|garbled| garbled.no > last.no);
        match node_state.command {
            Some(command) if !command.judged => {
                let doubtful = commanded(command.at);
                Some(KnownState { state, at: command.at, shown: false, may_start_itself, doubtful, not_started: None })
            }
            _ => {
                let seen = node_state.reports.last.or(node_state.boots.last);
                let doubtful =
                    node_state.reports.unsettled || node_state.suspect.is_some() || seen.is_some_and(commanded);
                node_state.reports.first.map(|(state, at)| KnownState {
                    state,
                    at,
                    shown: true,
                    may_start_itself,
                    doubtful,
                    not_started: node_state.command.filter(|it| it.state == OPERATIONAL).and_then(|it| it.reported),
                })
            }
        }
    }

    /// Returns the last state reported by a node since its boot-up.
    pub fn shown_last(&self, node: u8) -> Option<u8> {
        self.nodes.get(node)?.reports.first.map(|(state, _)| state)
    }

    /// Returns the last frame in which a node has reported its state since its boot-up.
    pub fn last_report(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node)?.reports.last
    }

    /// Returns true if a node has reported states since its boot-up.
    pub fn shows(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|node_state| node_state.reports.count > 0)
    }

    /// Returns the reset command after which a known node has not booted yet.
    pub fn resetting(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node).filter(|node_state| node_state.reset.awaited && node_state.present)?.reset.at
    }

    /// Returns the same if the node has since sent neither a state nor an unreadable frame.
    pub fn silent_since_reset(&self, node: u8) -> Option<FrameRef> {
        let node_state = self.nodes.get(node)?;
        self.resetting(node).filter(|_| !node_state.reset.heard)
    }

    /// Returns the last boot-up of a node.
    pub fn booted(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node)?.boots.last
    }

    /// Returns true if the capture contains a command.
    pub fn commanded(&self) -> bool {
        self.commandless.commanded()
    }

    /// Returns true if a frame of a node was seen.
    pub fn is_present(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|node_state| node_state.present)
    }

    /// Returns the last frame of a node.
    pub fn heard(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node)?.heard
    }

    /// Takes a frame of a node.
    pub fn present(&mut self, node: u8, at: FrameRef) {
        Self::meet(&mut self.nodes, self.broadcast, node, at);
    }

    /// Returns the sender of a frame. A node seen for the first time may be obeying a command to all.
    fn meet(
        nodes: &mut PerNode<NodeState>,
        broadcast: Option<PendingCommand>,
        node: u8,
        at: FrameRef,
    ) -> &mut NodeState {
        let broadcast = broadcast.filter(|command| at.since(command.at).is_none_or(|age| age < FIRST_SEEN_NS));
        let node_state = nodes.entry(node);
        if let Some(command) = broadcast.filter(|_| !node_state.present) {
            node_state.command = Some(command);
            node_state.allowed |= bits_of(command.state);
        }
        (node_state.present, node_state.heard) = (true, Some(at));
        node_state
    }

    /// Takes an SDO request to a node.
    pub fn asked(&mut self, node: u8) {
        self.nodes.entry(node).asked = true;
    }

    /// Takes a write request to a node.
    pub fn managed(&mut self, node: u8) {
        self.nodes.entry(node).managed = true;
    }

    /// Takes a node control command to `node`, or to all (0).
    pub fn command(&mut self, specifier: u8, node: u8, cx: &mut Context<'_>) {
        let Some(state) = nmt::commanded_state(specifier) else {
            if EXTENSIONS.contains(&specifier) {
                return;
            }
            self.garbled = Some(cx.at);
            return cx.raise(Nmt001::Command { found: specifier }, None, None, None);
        };
        self.commandless.command(cx);
        match node {
            0 => self.broadcast = Some(PendingCommand::new(state, specifier, cx.when, false)),
            1..=127 => _ = self.nodes.entry(node),
            _ => {
                self.garbled = Some(cx.at);
                return cx.raise(Nmt001::NodeId { found: node.into() }, None, None, None);
            }
        }
        let explicit = node != 0;
        let crossed = self.moved.is_some_and(|boot_up| !cx.evidence.recording.is_settled(boot_up, cx.at));
        // A command to all concerns the nodes that are present.
        let meant = |(id, node_state): &(u8, &mut NodeState)| if explicit { *id == node } else { node_state.present };
        for (id, node_state) in self.nodes.iter_mut().filter(meant) {
            let explained = node_state.commanded(id, (state, specifier, explicit), cx);
            if state == 0
                && !crossed
                && let Some(limit_ns) = node_state.owes_boot_up(cx)
            {
                self.boot_ups.open(id, Owed { since: cx.when, limit_ns, why: Some(cx.at) });
            }
            self.late |= explained;
            self.suspects = self.suspects.saturating_sub(u32::from(explained));
        }
    }

    /// Takes a frame on the NMT identifier that is not two bytes long.
    pub fn malformed(&mut self, len: u8, cx: &mut Context<'_>) {
        self.garbled = Some(cx.at);
        cx.raise(Nmt001::Length { found: len.into() }, None, None, None);
    }

    /// Takes a boot-up. `silence_ns`: duration of the bus's silence before it.
    pub fn boot_up(&mut self, node: u8, silence_ns: Ns, cx: &mut Context<'_>) {
        self.boot_ups.met(node);
        self.shows_states = true;
        if silence_ns >= SWITCHED_ON_NS {
            self.switched_on = cx.at.t_ns;
        }
        let first = !self.commanded() && self.nodes.iter().all(|(_, other)| !other.present);
        let node_state = self.nodes.entry(node);
        node_state.first = first || node_state.first && node_state.reset.count == 0;
        if node_state.given {
            // A slave has another node-ID; its previous one is uncertain.
            self.boot_ups.void(|_| true);
            self.moved = Some(cx.at);
        }
        node_state.forget_answered_resets(cx.at);
        self.causal |= node_state.reset.count > 0;
        let soon = |then: Option<Ns>, limit_ns: Ns| {
            then.zip(cx.at.t_ns).is_some_and(|(then, now)| (Ns::ZERO..limit_ns).contains(&(now - then)))
        };
        let garbled = self.garbled.is_some_and(|garbled| {
            node_state.reports.last.is_none_or(|last| last.no < garbled.no)
                && cx.at.since(garbled).is_none_or(|age| age < GARBLED_NS)
        });
        // Each explains one boot-up of a node.
        let booted = node_state.boots.last.and_then(|boot| boot.t_ns);
        let anew = |then: Option<Ns>| booted.is_none_or(|boot| then.is_some_and(|then| boot < then));
        let explains = |then: Option<Ns>, limit_ns: Ns| soon(then, limit_ns) && anew(then);
        let activated = explains(self.activated, ACTIVATED_NS);
        let asked = node_state.reset.count > 0 || node_state.given || activated || garbled;
        let explained = asked || explains(self.switched_on, POWER_UP_NS);
        let before = (node_state.boots.last, node_state.reports);
        node_state.boot(cx.at);
        node_state.boots.unasked = !asked && before.1.last.is_some();
        if explained {
            return;
        }
        let duplicate = cx.sighting == Sighting::Suspect;
        node_state.boots.unexplained = before.1.last.map(|_| cx.at);
        let Some(what) = spontaneous_boot(before, cx) else { return };
        if matches!(what, Spontaneous::TwoBootUps { .. }) && duplicate && node_state.suspect.is_some() {
            // A suspect may be in the capture a second time.
            return;
        }
        self.suspects += u32::from(node_state.suspect.is_none());
        node_state.boots.unexplained = Some(cx.at);
        node_state.suspect = Some(Suspect { at: cx.at, since: since(before.1.last, cx), what, duplicate });
    }

    /// Returns true if nothing but its supply explains the last boot-up of a node, which reported states before.
    pub fn booted_unasked(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|node_state| node_state.boots.unasked)
    }

    /// Takes a reported state. `period_ns`: the period of the node's reports if known.
    pub fn shown(&mut self, node: u8, state: u8, period_ns: Option<Ns>, cx: &mut Context<'_>) {
        if !matches!(state, STOPPED | OPERATIONAL | PRE_OPERATIONAL) {
            return self.unreadable(node);
        }
        self.shows_states = true;
        let node_state = Self::meet(&mut self.nodes, self.broadcast, node, cx.at);
        let beat = node_state.reports.last.replace(cx.at);
        node_state.reports.period_ns = period_ns;
        node_state.reports.count = node_state.reports.count.saturating_add(1);
        let garbled = beat.zip(self.garbled).is_some_and(|(beat, garbled)| beat.no < garbled.no);
        let allowed = node_state.allowed & bit(state) != 0 || node_state.reset.awaited || garbled;
        node_state.allowed &= !bit(state);
        let before = node_state.reports.first.map(|(before, _)| before);
        let soon =
            |began: FrameRef| cx.at.since(began).map_or(cx.at.no < began.no + OBEYED_FRAMES, |age| age < OBEYED_NS);
        self.causal |= before.is_some_and(|before| before != state) && allowed;
        if before == Some(state) && node_state.command.is_none() {
            node_state.allowed = 0;
        } else if before.is_none() && self.began.is_some_and(soon) {
            // It may be about to obey a command from just before the capture.
            node_state.allowed = bits_of(0);
        }
        let starts_itself = before.is_some_and(|before| node_state.starts_itself(before, state, cx.at));
        node_state.obeys(node, state, period_ns, cx);
        if !node_state.reset.awaited {
            self.boot_ups.met(node);
        }
        if before == Some(state) {
            node_state.reports.unsettled = false;
            return;
        }
        node_state.reports.first = Some((state, cx.at));
        let Some(before) = before else { return };
        if let Some((from, finding)) = node_state.excused.take()
            && node_state.reports.unsettled
            && from == state
            && !allowed
        {
            // It was never in the other state: no error brings a node back by itself.
            self.commandless.find(finding, Ns::ZERO, cx);
        }
        if state == OPERATIONAL && before == PRE_OPERATIONAL {
            self.commandless.returned(node, node_state.boots.last);
        }
        if allowed || starts_itself || node_state.reports.unsettled {
            return;
        }
        self.suspects += u32::from(node_state.suspect.is_none());
        let wait_ns = period_ns.map_or(Ns::ZERO, |period_ns| period_ns * ALTERNATES);
        let what = Spontaneous::Change { from: before, to: state, wait_ns };
        node_state.suspect = Some(Suspect { at: cx.at, since: since(beat, cx), what, duplicate: false });
    }

    /// Takes an unreadable error control frame, which may be the boot-up due after a reset.
    pub fn unreadable(&mut self, node: u8) {
        if let Some(node_state) = self.nodes.get_mut(node) {
            node_state.command = node_state.command.filter(|command| command.state != 0);
            node_state.reset.heard = true;
        }
        self.boot_ups.met(node);
    }

    /// Takes an emergency; `code` 0 ends an error.
    pub fn emergency(&mut self, node: u8, code: u16, at: FrameRef) {
        let node_state = Self::meet(&mut self.nodes, self.broadcast, node, at);
        if code != 0 {
            node_state.emergency = Some(at);
        }
    }

    /// Takes an LSS command that assigns a node-ID, or returns slaves to waiting, where it takes effect.
    pub fn lss(&mut self, command: Lss, at: FrameRef) {
        match command {
            Lss::ConfigureNodeId { node } if (1..=127).contains(&node) => self.nodes.entry(node).given = true,
            Lss::SwitchGlobal { mode: 0 } => self.activated = at.t_ns,
            _ => {}
        }
    }

    /// Takes a program control command (1F51h), after which the node may boot.
    pub fn program_controlled(&mut self, node: u8) {
        self.nodes.entry(node).given = true;
    }

    /// Reports unexplained changes and missing boot-ups; called for each frame before it is followed.
    #[inline]
    pub fn settle(&mut self, cx: &mut Context<'_>) {
        if self.suspects > 0 {
            self.resolve(false, cx);
        }
        self.began.get_or_insert(cx.at);
        if !self.boot_ups.is_empty() {
            self.missing_boot_ups(false, cx);
        }
        self.commandless.settle(cx);
    }

    /// Reports unexplained changes at the end of the capture, if commands always preceded their effects.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        if self.suspects > 0 && self.causal && !self.late {
            self.resolve(true, cx);
        }
        self.missing_boot_ups(true, cx);
        self.commandless.finish(cx);
    }

    /// Reports nodes that have not booted after a reset.
    fn missing_boot_ups(&mut self, over: bool, cx: &mut Context<'_>) {
        if cx.when.silent_ns > LEAST_BOOT_NS {
            // The network or its recorder paused.
            self.boot_ups.renew(cx.when);
        }
        // A node that still sends by then is not booting.
        let running = |node: u8, reset: FrameRef| {
            let heard = self.nodes.get(node).and_then(|node_state| node_state.heard);
            heard.and_then(|heard| heard.since(reset)).is_some_and(|age| age > LEAST_BOOT_NS)
        };
        let limit_ns = |node: u8, owed: &Owed| match owed.limit_ns {
            LEAST_BOOT_NS if over || running(node, owed.since.at) => LEAST_BOOT_NS,
            longer => longer.max(BOOT_NS),
        };
        for (node, owed) in self.boot_ups.overdue(cx.when, &cx.evidence.recording, limit_ns) {
            let others =
                || self.nodes.iter().filter(|(id, other)| *id != node && other.present).map(|(_, other)| other);
            let alone = !others().any(|other| other.goes_on_unmanaged(owed.since.at));
            let configures = others().filter(|other| other.asked).count() > 1;
            let Some(node_state) = self.nodes.get_mut(node) else { continue };
            let heard = node_state.heard.is_some_and(|heard| heard.no > owed.since.at.no);
            // The master does not reset itself; and if no node reports its state, boot-ups are not recorded.
            let goes_on = alone && node_state.goes_on_unmanaged(owed.since.at);
            if heard && (node_state.may_be_master() || goes_on || !self.shows_states) {
                continue;
            }
            // A master without heartbeats, which asks the others, or a slave that is gone.
            let unclear = configures && node_state.has_only_booted();
            if let Some(command) = node_state.command.as_mut().filter(|command| command.state == 0) {
                command.judged = true;
            }
            if !heard {
                cx.evidence.circumstances.note(Circumstance::NodeLost, Some(node), cx.when);
            }
            let command = node_state.reset.specifier;
            let age = cx.evidence.recording.between(owed.since, cx.when).unwrap_or(Ns::ZERO);
            let what = if unclear { Nmt006::Unclear { command, age } } else { Nmt006::Missing { command, age } };
            cx.raise(what, Some(node), None, owed.why);
        }
    }

    fn resolve(&mut self, over: bool, cx: &mut Context<'_>) {
        let recording = &cx.evidence.recording;
        let (twice, once) = (recording.shows_duplicates(), recording.shows_once());
        let power = self.power(cx.at);
        for (node, node_state) in self.nodes.iter_mut() {
            let recording = &cx.evidence.recording;
            let Some(suspect) = node_state.suspect else { continue };
            let settled = recording.is_settled(suspect.at, cx.at) && !(suspect.duplicate && !twice && !once);
            let booted = matches!(suspect.what, Spontaneous::BootUp { .. } | Spontaneous::Restart { .. });
            if !over && (!settled || booted && power.is_open(suspect.at, cx.at)) {
                continue;
            }
            node_state.suspect = None;
            self.suspects = self.suspects.saturating_sub(1);
            // A capture of a single CAN-ID would not contain the command.
            if twice && suspect.duplicate || booted && power.all || !cx.evidence.recording.shows_several() {
                continue;
            }
            let of = |what: Verdict| Finding { at: suspect.at, ..cx.verdict(what, Some(node), None, None) };
            let Spontaneous::Change { from, to, wait_ns } = suspect.what else {
                let finding = of(boot_verdict(suspect));
                match suspect.what {
                    Spontaneous::TwoBootUps { .. } => cx.report(finding),
                    _ => self.commandless.find(cx.excused(Rules::Nmt, suspect.since, finding), Ns::ZERO, cx),
                }
                continue;
            };
            node_state.reports.unsettled = true;
            let finding = of(Nmt004::Changed { from, to }.into());
            // An error makes a node leave Operational or stop (1029h), nothing else.
            if (from == OPERATIONAL || to == STOPPED) && node_state.has_emergency(suspect.at) {
                let excused = of(Nmt005::Changed { from, to }.into());
                node_state.excused = Some((from, finding));
                self.commandless.find(excused, Ns::ZERO, cx);
                continue;
            }
            self.commandless.changed(node, to, &finding);
            // Two nodes with one node-ID seem to change their state.
            self.commandless.find(cx.excused(Rules::Nmt, suspect.since, finding), wait_ns, cx);
        }
    }

    /// Returns the nodes that have recently booted without command, and the others. One that is neither commanded nor has
    /// booted may be the master, which keeps its own power; if there are only such others, each of them counts.
    fn power(&self, at: FrameRef) -> Power {
        let (mut count, mut kept, mut heard) = (0, false, [0; 2]);
        for (_, node_state) in self.nodes.iter().filter(|(_, node_state)| node_state.present) {
            let again = node_state
                .boots
                .unexplained
                .is_some_and(|boot| at.since(boot).map_or(boot.no + TOGETHER >= at.no, |age| age <= SWITCHED_ON_NS));
            if again {
                count += 1;
                continue;
            }
            let is_slave = node_state.managed || node_state.boots.last.is_some();
            kept |= is_slave;
            let [last, of_slaves] = &mut heard;
            let at = node_state.heard.map_or(0, |heard| heard.no);
            (*last, *of_slaves) = ((*last).max(at), (*of_slaves).max(if is_slave { at } else { 0 }));
        }
        let [last, of_slaves] = heard;
        Power { all: count > 1 && !kept, others: kept || last > 0, heard: if kept { of_slaves } else { last } }
    }

    /// Forgets states and commands after lost frames.
    pub fn forget(&mut self) {
        for (_, node_state) in self.nodes.iter_mut() {
            let NodeState { present, managed, asked, given, first, .. } = *node_state;
            *node_state = NodeState { present, managed, asked, given, first, ..NodeState::default() };
        }
        self.suspects = 0;
        self.boot_ups.void(|_| true);
        (self.broadcast, self.began) = (None, None);
        self.commandless.forget();
    }
}

/// Classifies an unexplained boot-up by the one before it and the states reported by the node.
fn spontaneous_boot((last, reports): (Option<FrameRef>, Reports), cx: &Context<'_>) -> Option<Spontaneous> {
    let (at, recording) = (cx.at, &cx.evidence.recording);
    let within = |then: FrameRef, limit_ns: Ns| at.since(then).is_some_and(|gap| gap < limit_ns);
    // Frames that waited in the recorder, or have coarse stamps, may have been far apart.
    let together = |last: FrameRef| {
        let gap = at.since(last).filter(|gap| *gap >= Ns::ZERO && recording.teaches(cx.when));
        gap.is_some_and(|gap| gap + recording.resolution_ns() < TWO_BOOT_UPS_NS)
    };
    // Until then no heartbeat is reported as missing.
    let unmissed_ns = RESTART_NS.max(reports.period_ns.unwrap_or(Ns::ZERO) * 13 / 4);
    match (last, reports.last.filter(|_| reports.count >= RUNNING)) {
        (Some(last), _) if together(last) => Some(Spontaneous::TwoBootUps { last }),
        (Some(last), _) => Some(Spontaneous::BootUp { last }),
        (None, Some(last)) if within(last, unmissed_ns) => Some(Spontaneous::Restart { last }),
        (None, _) => None,
    }
}

/// Returns the verdict on a boot-up.
fn boot_verdict(suspect: Suspect) -> Verdict {
    let after = |last: FrameRef| suspect.at.since(last);
    match suspect.what {
        Spontaneous::TwoBootUps { last } => Hbt004::BootUps { gap: after(last).unwrap_or(Ns::ZERO) }.into(),
        Spontaneous::Restart { last } => Nmt003::WhileRunning { after: after(last).unwrap_or(Ns::ZERO) }.into(),
        Spontaneous::BootUp { last } => {
            after(last).map_or(Nmt003::BootUp, |after| Nmt003::SinceBootUp { after }).into()
        }
        Spontaneous::Change { from, to, .. } => Nmt004::Changed { from, to }.into(),
    }
}
