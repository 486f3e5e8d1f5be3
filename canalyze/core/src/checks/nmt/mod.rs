//! NMT states (CiA 301, 7.3.2): what state each node is in, from where that is known, and what moved it.
//!
//! A state is unknown until the node shows it: by a heartbeat or a guarding answer. A boot-up shows that the node
//! is there, not where it went from Initialisation (1F80h lets it start itself). A command shows what is expected; it
//! proves nothing, since it is not confirmed. Changes that no command explains are held back, since
//! the master's own frames may be captured late. It must not judge other services: those are `permissions`'.

pub mod commandless;
mod node_state;
pub mod permissions;

use self::commandless::Commandless;
use self::node_state::{Command, NodeState, Reports, Spontaneous, Suspect, bit, bits_of};
use crate::context::Context;
use crate::evidence::Obligations;
use crate::evidence::Rules;
use crate::evidence::circumstance::Kind as Circumstance;
use crate::evidence::duplicates::Sighting;
use crate::evidence::obligation::Owed;
use crate::finding::{Finding, Verdict};
use crate::frame::FrameRef;
use crate::node::PerNode;
use crate::rules::heartbeat::Hbt004;
use crate::rules::nmt::{Nmt001, Nmt003, Nmt004, Nmt005, Nmt006};
use crate::wire::error_control::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::lss::Command as Lss;
use crate::wire::nmt;

/// After a bus was silent for this long, boot-ups are those of a network that was switched on, in ns.
pub(super) const SWITCHED_ON_NS: i64 = 2_000_000_000;
/// Nodes that are switched on together boot within this time, in ns.
const POWER_UP_NS: i64 = 5_000_000_000;
/// The same in frames, without stamps.
const TOGETHER: u64 = 10;
/// Several resets in a row may yield as many boot-ups within this time, in ns.
pub(super) const RESETS_NS: i64 = 1_000_000_000;
/// How long after LSS sends its slaves back to waiting a boot-up is due to that, in ns.
const ACTIVATED_NS: i64 = 5_000_000_000;
/// Two boot-ups of one node-ID closer than this come from two nodes, in ns.
const TWO_BOOT_UPS_NS: i64 = 20_000_000;
/// A node whose boot-up follows its last heartbeat within this time did not lose its power, in ns.
const RESTART_NS: i64 = 1_000_000_000;
/// How long a node may take to boot after a reset, in ns: CiA 301 gives no limit, real nodes take well below 2 s.
const BOOT_NS: i64 = 3_000_000_000;
/// The same at a capture's end, of a node that has sent nothing since.
const LEAST_BOOT_NS: i64 = 1_000_000_000;
/// A node may show its old state for so long after a command that it was not seen before, in ns.
const FIRST_SEEN_NS: i64 = 1_000_000_000;
/// Heartbeat periods for which a change of state waits: two nodes with one node-ID change it in turns.
const ALTERNATES: i64 = 3;
/// What else a node does before it obeys a command, and what others send it meanwhile, in ns.
pub(super) const OBEYED_NS: i64 = 50_000_000;
/// The same in frames, where there are no stamps.
const OBEYED_FRAMES: u64 = 8;
/// Shown states after which a node was running, and not just about to obey a reset before the capture.
const RUNNING: u8 = 3;
/// A node boots within this time after a frame that it has taken for a reset, in ns.
const GARBLED_NS: i64 = 5_000_000_000;
/// Extended commands that are not CiA 301's but known: sleep and standby.
const EXTENSIONS: [u8; 2] = [0x50, 0x60];

/// Whether the network was switched off and on again.
#[derive(Clone, Copy, Debug)]
struct Power {
    /// All nodes, if several, have just booted without command.
    all: bool,
    /// The nodes that have not, and the number of the last frame of any of them.
    others: u32,
    heard: u64,
}

impl Power {
    /// Whether it is still to be seen what became of the nodes other than the one that booted at `boot`: none of them
    /// has been heard since.
    fn is_open(self, boot: FrameRef, at: FrameRef) -> bool {
        let soon = at.since(boot).map_or(boot.no + TOGETHER >= at.no, |age| age <= SWITCHED_ON_NS);
        self.others > 0 && self.heard < boot.no && soon
    }
}

/// A state that is known, for verdicts on other services.
#[derive(Clone, Copy, Debug)]
pub struct KnownState {
    /// 04, 05, 7F.
    pub state: u8,
    /// The frame with which the node was first shown or commanded to be in it.
    pub at: FrameRef,
    /// The node has shown it; else it was commanded.
    pub shown: bool,
    /// The node may still be a master that starts itself.
    pub may_start_itself: bool,
    /// It was shown once, and no command explains it.
    pub doubtful: bool,
}

/// The states of a bus's nodes.
#[derive(Debug, Default)]
pub struct Nmt {
    nodes: PerNode<NodeState>,
    suspects: u32,
    commandless: Commandless,
    /// Boot-ups that are due after a reset.
    boot_ups: Obligations<u8>,
    /// Some node has booted or shown its state: the capture was not filtered of these.
    shows_states: bool,
    /// The last command to all, as it concerns a node that was not seen by then.
    broadcast: Option<Command>,
    activated: Option<i64>,
    /// The first frame of the capture, or after a gap.
    began: Option<FrameRef>,
    /// The last boot-up with a node-ID that was given.
    moved: Option<FrameRef>,
    /// The first boot-up after a silence: the network was switched on.
    switched_on: Option<i64>,
    /// The last frame on NMT's identifier that is no command: what it was meant as, nodes may have obeyed.
    garbled: Option<FrameRef>,
    /// Commands came before their effects, and never after: the capture is in causal order.
    causal: bool,
    late: bool,
}

impl Nmt {
    /// The NMT state of a node, as far as known: 04, 05, 7F. A command counts where the node is known to be there.
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

    /// The same with its evidence, for verdicts.
    pub fn known(&self, node: u8) -> Option<KnownState> {
        let node_state = self.nodes.get(node)?;
        let state = self.state(node)?;
        let may_start_itself = state == PRE_OPERATIONAL && !node_state.managed && node_state.command.is_none();
        // What could not be read since may have been a command to this node.
        let commanded = |last: FrameRef| self.garbled.is_some_and(|garbled| garbled.no > last.no);
        match node_state.command {
            Some(command) if !command.judged => {
                let doubtful = commanded(command.at);
                Some(KnownState { state, at: command.at, shown: false, may_start_itself, doubtful })
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
                })
            }
        }
    }

    /// The state that a node has shown last since its boot-up.
    pub fn shown_last(&self, node: u8) -> Option<u8> {
        self.nodes.get(node)?.reports.first.map(|(state, _)| state)
    }

    /// The last frame in which a node has shown its state since it booted.
    pub fn last_report(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node)?.reports.last
    }

    /// Whether a node has shown states since it booted.
    pub fn shows(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|node_state| node_state.reports.count > 0)
    }

    /// The reset command after which a node that has been seen has not booted yet.
    pub fn resetting(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node).filter(|node_state| node_state.reset.awaited && node_state.present)?.reset.at
    }

    /// The same, where the node has shown no state since, and nothing that cannot be read.
    pub fn silent_since_reset(&self, node: u8) -> Option<FrameRef> {
        let node_state = self.nodes.get(node)?;
        self.resetting(node).filter(|_| !node_state.reset.heard)
    }

    /// Whether the capture shows any command.
    pub fn commanded(&self) -> bool {
        self.commandless.commanded()
    }

    /// Whether anything was seen of a node.
    pub fn is_present(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|node_state| node_state.present)
    }

    /// A node has sent something.
    pub fn present(&mut self, node: u8, at: FrameRef) {
        Self::meet(&mut self.nodes, self.broadcast, node, at);
    }

    /// The node that has sent a frame. One that is seen for the first time may be obeying a command to all.
    fn meet(nodes: &mut PerNode<NodeState>, broadcast: Option<Command>, node: u8, at: FrameRef) -> &mut NodeState {
        let broadcast = broadcast.filter(|command| at.since(command.at).is_none_or(|age| age < FIRST_SEEN_NS));
        let node_state = nodes.entry(node);
        if let Some(command) = broadcast.filter(|_| !node_state.present) {
            node_state.command = Some(command);
            node_state.allowed |= bits_of(command.state);
        }
        (node_state.present, node_state.heard) = (true, Some(at));
        node_state
    }

    /// An SDO request was sent to a node.
    pub fn managed(&mut self, node: u8) {
        self.nodes.entry(node).managed = true;
    }

    /// Node control: the master commands `node`, or all (0).
    pub fn command(&mut self, specifier: u8, node: u8, cx: &mut Context<'_>) {
        let Some(state) = commanded_state(specifier) else {
            if EXTENSIONS.contains(&specifier) {
                return;
            }
            self.garbled = Some(cx.at);
            return cx.raise(Nmt001::Command { found: specifier }, None, None, None);
        };
        self.commandless.command(cx);
        match node {
            0 => self.broadcast = Some(Command::new(state, specifier, cx.at, false)),
            1..=127 => _ = self.nodes.entry(node),
            _ => {
                self.garbled = Some(cx.at);
                return cx.raise(Nmt001::NodeId { found: node.into() }, None, None, None);
            }
        }
        let explicit = node != 0;
        let crossed = self.moved.is_some_and(|boot_up| !cx.evidence.recording.is_settled(boot_up, cx.at));
        // Of all, those are meant that are there.
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

    /// A frame on NMT's identifier that is not two bytes long.
    pub fn malformed(&mut self, len: u8, cx: &mut Context<'_>) {
        self.garbled = Some(cx.at);
        cx.raise(Nmt001::Length { found: len.into() }, None, None, None);
    }

    /// A boot-up. `silence_ns`: the bus was silent for that long before it.
    pub fn boot_up(&mut self, node: u8, silence_ns: i64, cx: &mut Context<'_>) {
        self.boot_ups.met(node);
        self.shows_states = true;
        if silence_ns >= SWITCHED_ON_NS {
            self.switched_on = cx.at.t_ns;
        }
        let node_state = self.nodes.entry(node);
        if node_state.given {
            // A slave has another node-ID: which it had before is not certain.
            self.boot_ups.void(|_| true);
            self.moved = Some(cx.at);
        }
        node_state.forget_answered_resets(cx.at);
        self.causal |= node_state.reset.count > 0;
        let soon = |then: Option<i64>, limit_ns: i64| {
            then.zip(cx.at.t_ns).is_some_and(|(then, now)| (0..limit_ns).contains(&now.saturating_sub(then)))
        };
        let garbled = self.garbled.is_some_and(|garbled| {
            node_state.reports.last.is_none_or(|last| last.no < garbled.no)
                && cx.at.since(garbled).is_none_or(|age| age < GARBLED_NS)
        });
        let switched = soon(self.activated, ACTIVATED_NS) || soon(self.switched_on, POWER_UP_NS);
        let explained = node_state.reset.count > 0 || node_state.given || switched || garbled;
        let before = (node_state.boots.last, node_state.reports);
        node_state.boot(cx.at);
        if explained {
            return;
        }
        let duplicate = cx.sighting == Sighting::Suspect;
        let Some(what) = spontaneous_boot(before, cx) else { return };
        if matches!(what, Spontaneous::TwoBootUps { .. }) && duplicate && node_state.suspect.is_some() {
            // What is suspected already may stand here a second time.
            return;
        }
        self.suspects += u32::from(node_state.suspect.is_none());
        node_state.boots.unexplained = Some(cx.at);
        node_state.suspect = Some(Suspect { at: cx.at, what, duplicate });
    }

    /// A node shows its state. `period_ns`: how often it does so, where that is known.
    pub fn shown(&mut self, node: u8, state: u8, period_ns: Option<i64>, cx: &mut Context<'_>) {
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
            // It may be about to obey a command that came just before the capture.
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
            self.commandless.find(finding, 0, cx);
        }
        if allowed || starts_itself || node_state.reports.unsettled {
            return;
        }
        self.suspects += u32::from(node_state.suspect.is_none());
        let wait_ns = period_ns.map_or(0, |period_ns| period_ns.saturating_mul(ALTERNATES));
        let what = Spontaneous::Change { from: before, to: state, wait_ns };
        node_state.suspect = Some(Suspect { at: cx.at, what, duplicate: false });
    }

    /// A node's error control frame that cannot be read: it may be the boot-up that is due after a reset.
    pub fn unreadable(&mut self, node: u8) {
        if let Some(node_state) = self.nodes.get_mut(node) {
            node_state.command = node_state.command.filter(|command| command.state != 0);
            node_state.reset.heard = true;
        }
        self.boot_ups.met(node);
    }

    /// A node has sent an emergency; `code` 0: an error is over.
    pub fn emergency(&mut self, node: u8, code: u16, at: FrameRef) {
        let node_state = Self::meet(&mut self.nodes, self.broadcast, node, at);
        if code != 0 {
            node_state.emergency = Some(at);
        }
    }

    /// LSS gives a node-ID, or sends its slaves back to waiting, where a new node-ID takes effect.
    pub fn lss(&mut self, command: Lss, at: FrameRef) {
        match command {
            Lss::ConfigureNodeId { node } if (1..=127).contains(&node) => self.nodes.entry(node).given = true,
            Lss::SwitchGlobal { mode: 0 } => self.activated = at.t_ns,
            _ => {}
        }
    }

    /// A program control command (1F51h) was written: the node may boot.
    pub fn program_controlled(&mut self, node: u8) {
        self.nodes.entry(node).given = true;
    }

    /// Reports what stayed unexplained, and which boot-ups are missing. Called with each frame before it is followed.
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

    /// The capture is over: no command can follow any more, where commands have come before their effects.
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
            // The network, or its recorder, paused.
            self.boot_ups.renew(cx.when);
        }
        // Who still sends by then is not booting.
        let running = |node: u8, reset: FrameRef| {
            let heard = self.nodes.get(node).and_then(|node_state| node_state.heard);
            heard.and_then(|heard| heard.since(reset)).is_some_and(|age| age > LEAST_BOOT_NS)
        };
        let limit_ns = |node: u8, owed: &Owed| match owed.limit_ns {
            LEAST_BOOT_NS if over || running(node, owed.since.at) => LEAST_BOOT_NS,
            longer => longer.max(BOOT_NS),
        };
        for (node, owed) in self.boot_ups.overdue(cx.when, &cx.evidence.recording, limit_ns) {
            let Some(node_state) = self.nodes.get_mut(node) else { continue };
            let heard = node_state.heard.is_some_and(|heard| heard.no > owed.since.at.no);
            // The master does not reset itself; and where no node shows its state, boot-ups are not recorded.
            if heard && (node_state.may_be_master() || !self.shows_states) {
                continue;
            }
            if let Some(command) = node_state.command.as_mut().filter(|command| command.state == 0) {
                command.judged = true;
            }
            if !heard {
                cx.evidence.circumstances.note(Circumstance::NodeLost, Some(node), cx.when);
            }
            let command = node_state.reset.specifier;
            let age = cx.evidence.recording.between(owed.since, cx.when).unwrap_or(0);
            cx.raise(Nmt006::Missing { command, age }, Some(node), None, owed.why);
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
            // Where the capture shows one CAN-ID only, it would not show the command.
            if twice && suspect.duplicate || booted && power.all || !cx.evidence.recording.shows_several() {
                continue;
            }
            let of = |what: Verdict| Finding { at: suspect.at, ..cx.verdict(what, Some(node), None, None) };
            let Spontaneous::Change { from, to, wait_ns } = suspect.what else {
                let finding = of(boot_verdict(suspect));
                match suspect.what {
                    Spontaneous::TwoBootUps { .. } => cx.report(finding),
                    _ => self.commandless.find(finding, 0, cx),
                }
                continue;
            };
            node_state.reports.unsettled = true;
            let finding = of(Nmt004::Changed { from, to }.into());
            // An error makes a node leave Operational, or stop (1029h); nothing else.
            if (from == OPERATIONAL || to == STOPPED) && node_state.has_emergency(suspect.at) {
                let excused = of(Nmt005::Changed { from, to }.into());
                node_state.excused = Some((from, finding));
                self.commandless.find(excused, 0, cx);
                continue;
            }
            self.commandless.changed(node, to, &finding);
            // Two nodes with one node-ID seem to change their state.
            self.commandless.find(cx.excused(Rules::Nmt, cx.when, finding), wait_ns, cx);
        }
    }

    /// Which nodes have booted without command lately, and which have not. A master without commands keeps its own
    /// power.
    fn power(&self, at: FrameRef) -> Power {
        let (mut count, mut power) = (0, Power { all: false, others: 0, heard: 0 });
        for (_, node_state) in self.nodes.iter().filter(|(_, node_state)| node_state.present) {
            let again = node_state
                .boots
                .unexplained
                .is_some_and(|boot| at.since(boot).map_or(boot.no + TOGETHER >= at.no, |age| age <= SWITCHED_ON_NS));
            if again {
                count += 1;
            } else if node_state.managed || node_state.boots.last.is_some() {
                power.others += 1;
                power.heard = power.heard.max(node_state.heard.map_or(0, |heard| heard.no));
            }
        }
        Power { all: count > 1 && power.others == 0, ..power }
    }

    /// Frames were lost: commands and boot-ups may be among them.
    pub fn forget(&mut self) {
        for (_, node_state) in self.nodes.iter_mut() {
            let NodeState { present, managed, given, .. } = *node_state;
            *node_state = NodeState { present, managed, given, ..NodeState::default() };
        }
        self.suspects = 0;
        self.boot_ups.void(|_| true);
        (self.broadcast, self.began) = (None, None);
        self.commandless.forget();
    }
}

/// The state that a command asks for, 0 for a reset.
pub fn commanded_state(specifier: u8) -> Option<u8> {
    match specifier {
        nmt::START => Some(OPERATIONAL),
        nmt::STOP => Some(STOPPED),
        nmt::PRE_OPERATIONAL => Some(PRE_OPERATIONAL),
        nmt::RESET_NODE | nmt::RESET_COMMUNICATION => Some(0),
        _ => None,
    }
}

/// What an unexplained boot-up is, after the boot-up before it and the states that the node has shown.
fn spontaneous_boot((last, reports): (Option<FrameRef>, Reports), cx: &Context<'_>) -> Option<Spontaneous> {
    let (at, recording) = (cx.at, &cx.evidence.recording);
    let within = |then: FrameRef, limit_ns: i64| at.since(then).is_some_and(|gap| gap < limit_ns);
    // What waited in the recorder, or has coarse stamps, may have been far apart.
    let together = |last: FrameRef| {
        let gap = at.since(last).filter(|gap| *gap >= 0 && recording.teaches(cx.when));
        gap.is_some_and(|gap| gap.saturating_add(recording.resolution_ns()) < TWO_BOOT_UPS_NS)
    };
    match (last, reports.last.filter(|_| reports.count >= RUNNING)) {
        (Some(last), _) if together(last) => Some(Spontaneous::TwoBootUps { last }),
        (Some(last), _) => Some(Spontaneous::BootUp { last }),
        (None, Some(last)) if within(last, RESTART_NS) => Some(Spontaneous::Restart { last }),
        (None, _) => None,
    }
}

/// What is reported of a boot-up.
fn boot_verdict(suspect: Suspect) -> Verdict {
    let after = |last: FrameRef| suspect.at.since(last);
    match suspect.what {
        Spontaneous::TwoBootUps { last } => Hbt004::BootUps { gap: after(last).unwrap_or(0) }.into(),
        Spontaneous::Restart { last } => Nmt003::WhileRunning { after: after(last).unwrap_or(0) }.into(),
        Spontaneous::BootUp { last } => {
            after(last).map_or(Nmt003::BootUp, |after| Nmt003::SinceBootUp { after }).into()
        }
        Spontaneous::Change { from, to, .. } => Nmt004::Changed { from, to }.into(),
    }
}
