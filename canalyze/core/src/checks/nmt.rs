//! NMT states (CiA 301, 7.3.2): what state each node is in, from where that is known, and what moved it.
//!
//! A state is unknown until the node shows it: by a heartbeat or a guarding answer. A boot-up shows that the node
//! is there, not where it went from Initialisation (1F80h lets it start itself). A command says what is expected; it
//! proves nothing, since nobody confirms it. Changes that no command explains are held back, since
//! the master's own frames may be captured late. It must not judge other services: that is `permitted`.

use super::commandless::Commandless;
use super::standing::{Command, Spontaneous, Standing, Suspect, bit, bits_of};
use crate::context::Context;
use crate::evidence::Obligations;
use crate::evidence::circumstance::Kind as Circumstance;
use crate::evidence::duplicates::Sighting;
use crate::evidence::obligation::Owed;
use crate::evidence::recording::{Silence, Verdict};
use crate::finding::{Code, Facts, Quantity};
use crate::frame::FrameRef;
use crate::node::PerNode;
use crate::services::heartbeat::{OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::services::lss::Command as Lss;
use crate::services::nmt;

/// An emergency within this time before a change of state explains it (1029h), in ns.
const EMERGENCY_NS: i64 = 1_000_000_000;
/// After a bus was silent for this long, boot-ups are those of a network that was switched on, in ns.
pub(super) const SWITCHED_ON_NS: i64 = 2_000_000_000;
/// Nodes that are switched on together boot within this time, in ns.
const POWER_UP_NS: i64 = 5_000_000_000;
/// Nodes that boot within so many frames, where there are no stamps, boot together.
const TOGETHER: u64 = 10;
/// Several resets in a row may yield as many boot-ups within this time, in ns.
pub(super) const RESETS_NS: i64 = 1_000_000_000;
/// How long after LSS sends its slaves back to waiting a boot-up is due to that, in ns.
const ACTIVATED_NS: i64 = 5_000_000_000;
/// Two boot-ups of one node-ID closer than this come from two nodes, in ns.
const TWO_BOOT_UPS_NS: i64 = 20_000_000;
/// A boot-up this soon after a reset was sent before the node saw it, in ns.
const SENT_NS: i64 = 1_000_000;
/// A node whose boot-up follows its last heartbeat within this time did not lose its power, in ns.
const RESTART_NS: i64 = 1_000_000_000;
/// How long a node may take to boot after a reset, in ns: CiA 301 gives no limit, real nodes take well below 2 s.
const BOOT_NS: i64 = 3_000_000_000;
/// The same at a capture's end, of a node that has sent nothing since.
const LEAST_BOOT_NS: i64 = 1_000_000_000;
/// A node may show its old state for so long after a command that it was not seen before, in ns.
const FIRST_SEEN_NS: i64 = 1_000_000_000;
/// So many shown states mean that a node was running, and not just about to obey a reset before the capture.
const RUNNING: u8 = 3;
/// A node boots within this time after a frame that it has taken for a reset, in ns.
const GARBLED_NS: i64 = 5_000_000_000;
/// Extended commands that are not CiA 301's but known: sleep and standby.
const EXTENSIONS: [u8; 2] = [0x50, 0x60];

/// Whether somebody has switched the network off and on again.
#[derive(Clone, Copy, Debug)]
struct Power {
    /// All nodes, if several, have just booted unasked.
    all: bool,
    /// The nodes that have not, and the number of the last frame of any of them.
    others: u32,
    heard: u64,
}

impl Power {
    /// Whether it is still to be seen what became of the nodes other than the one that booted at `boot`: none of them
    /// has been heard since.
    fn is_open(self, boot: FrameRef, at: FrameRef) -> bool {
        let soon = since(Some(boot), at).map_or(boot.no + TOGETHER >= at.no, |age| age <= SWITCHED_ON_NS);
        self.others > 0 && self.heard < boot.no && soon
    }
}

/// A state that is known, for verdicts on other services.
#[derive(Clone, Copy, Debug)]
pub struct Known {
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
    nodes: PerNode<Standing>,
    suspects: u32,
    commandless: Commandless,
    /// Boot-ups that are due after a reset.
    boot_ups: Obligations<u8>,
    /// The last command to all, as it concerns a node that was not seen by then.
    broadcast: Option<Command>,
    activated: Option<i64>,
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
        let standing = self.nodes.get(node)?;
        match standing.command {
            Some(command) if !command.judged => {
                let counts = command.sure && standing.present && command.wrong == 0 && command.state != 0;
                counts.then_some(command.state)
            }
            _ => standing.shown.map(|(state, _)| state),
        }
    }

    /// The same with its evidence, for verdicts.
    pub fn known(&self, node: u8) -> Option<Known> {
        let standing = self.nodes.get(node)?;
        let state = self.state(node)?;
        let may_start_itself = state == PRE_OPERATIONAL && !standing.managed && standing.command.is_none();
        // What could not be read since may have been a command to this node.
        let commanded = |last: FrameRef| self.garbled.is_some_and(|garbled| garbled.no > last.no);
        match standing.command {
            Some(command) if !command.judged => {
                let doubtful = commanded(command.at);
                Some(Known { state, at: command.at, shown: false, may_start_itself, doubtful })
            }
            _ => {
                let seen = standing.beat.or(standing.boot_up);
                let doubtful = standing.unsettled || standing.suspect.is_some() || seen.is_some_and(commanded);
                standing.shown.map(|(state, at)| Known { state, at, shown: true, may_start_itself, doubtful })
            }
        }
    }

    /// The state that a node has shown last since its boot-up.
    pub fn shown_last(&self, node: u8) -> Option<u8> {
        self.nodes.get(node)?.shown.map(|(state, _)| state)
    }

    /// Whether a node has shown states since it booted.
    pub fn shows(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|standing| standing.beats > 0)
    }

    /// The reset command after which a node that has been seen has not booted yet.
    pub fn resetting(&self, node: u8) -> Option<FrameRef> {
        self.nodes.get(node).filter(|standing| standing.resetting && standing.present)?.reset
    }

    /// The same, where the node has shown no state since, and nothing that cannot be read.
    pub fn silent_since_reset(&self, node: u8) -> Option<FrameRef> {
        let standing = self.nodes.get(node)?;
        self.resetting(node).filter(|_| !standing.heard_since_reset)
    }

    /// Whether the capture shows any command.
    pub fn commanded(&self) -> bool {
        self.commandless.commanded()
    }

    /// Whether anything was seen of a node.
    pub fn is_present(&self, node: u8) -> bool {
        self.nodes.get(node).is_some_and(|standing| standing.present)
    }

    /// A node has sent something.
    pub fn present(&mut self, node: u8, at: FrameRef) {
        Self::meet(&mut self.nodes, self.broadcast, node, at);
    }

    /// The node that has sent a frame. One that is seen for the first time may be obeying a command to all.
    fn meet(nodes: &mut PerNode<Standing>, broadcast: Option<Command>, node: u8, at: FrameRef) -> &mut Standing {
        let broadcast = broadcast.filter(|command| since(Some(command.at), at).is_none_or(|age| age < FIRST_SEEN_NS));
        let standing = nodes.entry(node);
        if let Some(command) = broadcast.filter(|_| !standing.present) {
            standing.command = Some(command);
            standing.allowed |= bits_of(command.state);
        }
        (standing.present, standing.heard) = (true, at.no);
        standing
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
            return cx.find(Code::Nmt001, None, None, None, Facts::told(0, &[("found", Quantity::Hex2(specifier))]));
        };
        self.commandless.command(cx);
        let crossed = self.moved.is_some_and(|boot_up| !cx.evidence.recording.is_settled(boot_up, cx.at));
        match node {
            0 => {
                self.broadcast = Some(Command::new(state, specifier, cx.at, false));
                // Who was only asked for is none of those who are meant.
                for (id, standing) in self.nodes.iter_mut().filter(|(_, standing)| standing.present) {
                    let explained = standing.commanded(id, (state, specifier, false), cx);
                    if state == 0 && !crossed && standing.owes_boot_up(false, cx) {
                        self.boot_ups.open(id, Owed { since: cx.when, limit_ns: LEAST_BOOT_NS, why: Some(cx.at) });
                    }
                    self.late |= explained;
                    self.suspects = self.suspects.saturating_sub(u32::from(explained));
                }
            }
            1..=127 => {
                let standing = self.nodes.entry(node);
                let explained = standing.commanded(node, (state, specifier, true), cx);
                if state == 0 && !crossed && standing.owes_boot_up(true, cx) {
                    self.boot_ups.open(node, Owed { since: cx.when, limit_ns: LEAST_BOOT_NS, why: Some(cx.at) });
                }
                self.late |= explained;
                self.suspects = self.suspects.saturating_sub(u32::from(explained));
            }
            _ => {
                self.garbled = Some(cx.at);
                let found = [("found", Quantity::Count(u64::from(node)))];
                cx.find(Code::Nmt001, None, None, None, Facts::told(1, &found));
            }
        }
    }

    /// A frame on NMT's identifier that is not two bytes long.
    pub fn malformed(&mut self, len: u8, cx: &mut Context<'_>) {
        self.garbled = Some(cx.at);
        cx.find(Code::Nmt001, None, None, None, Facts::told(2, &[("found", Quantity::Count(u64::from(len)))]));
    }

    /// A boot-up. `silence_ns`: the bus was silent for that long before it.
    pub fn boot_up(&mut self, node: u8, silence_ns: i64, cx: &mut Context<'_>) {
        let activated =
            self.activated.zip(cx.at.t_ns).is_some_and(|(then, now)| now.saturating_sub(then) < ACTIVATED_NS);
        let standing = self.nodes.entry(node);
        self.boot_ups.met(node);
        if standing.given {
            // A slave has another node-ID: which it had before is not certain.
            self.boot_ups.void(|_| true);
            self.moved = Some(cx.at);
        }
        let answered = standing.boot_up.zip(standing.reset).is_some_and(|(boot_up, reset)| boot_up.no > reset.no);
        if answered && since(standing.reset, cx.at).is_some_and(|age| age > RESETS_NS) {
            standing.resets = 0;
        }
        self.causal |= standing.resets > 0;
        if silence_ns >= SWITCHED_ON_NS {
            self.switched_on = cx.at.t_ns;
        }
        let powered = self
            .switched_on
            .zip(cx.at.t_ns)
            .is_some_and(|(then, now)| (0..POWER_UP_NS).contains(&now.saturating_sub(then)));
        let garbled = self.garbled.is_some_and(|garbled| {
            standing.beat.is_none_or(|beat| beat.no < garbled.no)
                && since(Some(garbled), cx.at).is_none_or(|age| age < GARBLED_NS)
        });
        let explained = standing.resets > 0 || standing.given || activated || powered || garbled;
        let crossed = standing.resets > 0 && since(standing.reset, cx.at).is_some_and(|age| age < SENT_NS);
        let (last, beat) = (standing.boot_up, standing.beat.filter(|_| standing.beats >= RUNNING));
        *standing = Standing {
            present: true,
            heard: cx.at.no,
            managed: standing.managed || standing.resetting,
            boot_up: Some(cx.at),
            resets: standing.resets.saturating_sub(u8::from(!crossed)),
            reset: standing.reset,
            emergency: standing.emergency,
            suspect: standing.suspect,
            ..Standing::default()
        };
        let what = match (last, beat) {
            _ if explained => return,
            (Some(last), _) if since(Some(last), cx.at).is_some_and(|gap| (0..TWO_BOOT_UPS_NS).contains(&gap)) => {
                if cx.sighting == Sighting::Suspect && standing.suspect.is_some() {
                    // What is suspected already may stand here a second time.
                    return;
                }
                Spontaneous::TwoBootUps { last }
            }
            (Some(last), _) => Spontaneous::BootUp { last },
            (None, Some(last)) if since(Some(last), cx.at).is_some_and(|gap| gap < RESTART_NS) => {
                Spontaneous::Restart { last }
            }
            (None, _) => return,
        };
        self.suspects += u32::from(standing.suspect.is_none());
        standing.again = Some(cx.at);
        standing.suspect =
            Some(Suspect { at: cx.at, what, duplicate: cx.sighting == Sighting::Suspect, burst: cx.when.burst });
    }

    /// A node shows its state. `period_ns`: how often it does so, where that is known.
    pub fn shown(&mut self, node: u8, state: u8, period_ns: Option<i64>, cx: &mut Context<'_>) {
        if !matches!(state, STOPPED | OPERATIONAL | PRE_OPERATIONAL) {
            return self.unreadable(node);
        }
        let standing = Self::meet(&mut self.nodes, self.broadcast, node, cx.at);
        let beat = standing.beat.replace(cx.at);
        standing.beats = standing.beats.saturating_add(1);
        let garbled = beat.zip(self.garbled).is_some_and(|(beat, garbled)| beat.no < garbled.no);
        let allowed = standing.allowed & bit(state) != 0 || standing.resetting || garbled;
        standing.allowed &= !bit(state);
        let before = standing.shown.map(|(before, _)| before);
        self.causal |= before.is_some_and(|before| before != state) && allowed;
        let starts_itself = before.is_some_and(|before| standing.starts_itself(before, state, cx.at));
        standing.obeys(node, state, period_ns, cx);
        if !standing.resetting {
            self.boot_ups.met(node);
        }
        if before == Some(state) {
            standing.unsettled = false;
            return;
        }
        standing.shown = Some((state, cx.at));
        let Some(before) = before else { return };
        if let Some((at, from, facts)) = standing.excused.take()
            && standing.unsettled
            && from == state
            && !allowed
        {
            // It was never in the other state: no error brings a node back by itself.
            self.commandless.find(Code::Nmt004, node, at, facts, cx);
        }
        if allowed || starts_itself || standing.unsettled {
            return;
        }
        self.suspects += u32::from(standing.suspect.is_none());
        standing.suspect = Some(Suspect {
            at: cx.at,
            what: Spontaneous::Change { from: before, to: state },
            duplicate: false,
            burst: cx.when.burst,
        });
    }

    /// A node's error control frame that cannot be read: it may be the boot-up that is due after a reset.
    pub fn unreadable(&mut self, node: u8) {
        if let Some(standing) = self.nodes.get_mut(node) {
            standing.command = standing.command.filter(|command| command.state != 0);
            standing.heard_since_reset = true;
        }
        self.boot_ups.met(node);
    }

    /// A node has sent an emergency; `code` 0: an error is over.
    pub fn emergency(&mut self, node: u8, code: u16, at: FrameRef) {
        let standing = Self::meet(&mut self.nodes, self.broadcast, node, at);
        if code != 0 {
            standing.emergency = Some(at);
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
        self.missing_boot_ups(false, cx);
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
        let least_ns = if over { LEAST_BOOT_NS } else { BOOT_NS };
        for (node, owed) in self.boot_ups.overdue(cx.when, &cx.evidence.recording, least_ns) {
            let Some(standing) = self.nodes.get(node) else { continue };
            let recording = &cx.evidence.recording;
            let silence = cx.at.t_ns.and_then(|now_ns| recording.silence(now_ns));
            let silent_ns =
                silence.filter(|one| owed.since.at.t_ns.is_some_and(|since| since < one.to_ns)).map_or(0, Silence::ns);
            if !recording.certainly_later(cx.when, owed.since, least_ns + silent_ns) {
                // The network, or its recorder, paused meanwhile.
                self.boot_ups.open(node, owed);
                continue;
            }
            if standing.heard <= owed.since.at.no {
                cx.evidence.circumstances.note(Circumstance::NodeLost, Some(node), cx.when);
            }
            let specifier = standing.command.map_or(nmt::RESET_NODE, |command| command.specifier);
            let age = cx.evidence.recording.between(owed.since, cx.when).unwrap_or(0);
            let facts = [("command", Quantity::Command(specifier)), ("age", Quantity::Ns(age))];
            cx.find(Code::Nmt006, Some(node), None, owed.why, Facts::told(0, &facts));
        }
    }

    fn resolve(&mut self, over: bool, cx: &mut Context<'_>) {
        let (twice, once) = (cx.evidence.recording.shows_twice(), cx.evidence.recording.shows_once());
        let power = self.power(cx.at);
        for (node, standing) in self.nodes.iter_mut() {
            let Some(suspect) = standing.suspect else { continue };
            let settled = cx.evidence.recording.is_settled(suspect.at, cx.at)
                && !(suspect.duplicate && !twice && !once)
                && cx.evidence.recording.verdict(suspect.burst) != Some(Verdict::Open);
            if !settled && !over {
                continue;
            }
            let booted = matches!(suspect.what, Spontaneous::BootUp { .. } | Spontaneous::Restart { .. });
            if booted && power.is_open(suspect.at, cx.at) && !over {
                continue;
            }
            standing.suspect = None;
            self.suspects = self.suspects.saturating_sub(1);
            if twice && suspect.duplicate {
                continue;
            }
            if booted && power.all {
                continue;
            }
            let emergency = standing.emergency.filter(|at| {
                since(Some(*at), suspect.at).map_or(at.no + 10 >= suspect.at.no, |age| age <= EMERGENCY_NS)
            });
            let (code, facts) = match suspect.what {
                Spontaneous::Change { from, to } => {
                    let states = [("from", Quantity::State(from)), ("to", Quantity::State(to))];
                    // An error makes a node leave Operational, or stop (1029h); nothing else.
                    let down = from == OPERATIONAL || to == STOPPED;
                    let code = if down && emergency.is_some() { Code::Nmt005 } else { Code::Nmt004 };
                    standing.unsettled = true;
                    let facts = Facts::told(0, &states);
                    standing.excused = (code == Code::Nmt005).then(|| (suspect.at, from, facts.clone()));
                    if code == Code::Nmt004 {
                        self.commandless.changed(node, suspect.at, to, &facts);
                    }
                    (code, facts)
                }
                Spontaneous::BootUp { last } => match since(Some(last), suspect.at) {
                    Some(gap) => (Code::Nmt003, Facts::told(0, &[("after", Quantity::Ns(gap))])),
                    None => (Code::Nmt003, Facts::told(1, &[])),
                },
                Spontaneous::Restart { last } => {
                    let gap = since(Some(last), suspect.at).unwrap_or_default();
                    (Code::Nmt003, Facts::told(2, &[("after", Quantity::Ns(gap))]))
                }
                Spontaneous::TwoBootUps { last } => {
                    let gap = since(Some(last), suspect.at).unwrap_or_default();
                    (Code::Hbt004, Facts::told(3, &[("gap", Quantity::Ns(gap))]))
                }
            };
            match code {
                Code::Hbt004 => cx.find_at(suspect.at, code, Some(node), None, None, facts),
                _ => self.commandless.find(code, node, suspect.at, facts, cx),
            }
        }
    }

    /// Who has booted unasked of late, and who has not. A master that nobody commands keeps its own power.
    fn power(&self, at: FrameRef) -> Power {
        let (mut count, mut power) = (0, Power { all: false, others: 0, heard: 0 });
        for (_, standing) in self.nodes.iter().filter(|(_, standing)| standing.present) {
            let again = standing.again.is_some_and(|boot| {
                since(Some(boot), at).map_or(boot.no + TOGETHER >= at.no, |age| age <= SWITCHED_ON_NS)
            });
            if again {
                count += 1;
            } else if standing.managed || standing.boot_up.is_some() {
                power.others += 1;
                power.heard = power.heard.max(standing.heard);
            }
        }
        Power { all: count > 1 && power.others == 0, ..power }
    }

    /// Frames were lost: commands and boot-ups may be among them.
    pub fn forget(&mut self) {
        for (_, standing) in self.nodes.iter_mut() {
            let Standing { present, managed, given, .. } = *standing;
            *standing = Standing { present, managed, given, ..Standing::default() };
        }
        self.suspects = 0;
        self.boot_ups.void(|_| true);
        self.broadcast = None;
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

/// Time from one frame to another, in ns.
pub(super) fn since(then: Option<FrameRef>, now: FrameRef) -> Option<i64> {
    Some(now.t_ns?.saturating_sub(then?.t_ns?))
}
