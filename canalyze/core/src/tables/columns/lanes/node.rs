//! The lanes of one node: its NMT state, the states of its drive, its errors.
//!
//! A state is shown, commanded or lost, and the words say which. What is not known is `unknown`, rather than what was
//! known last. Must not: judge; that a node is lost, a rule has said.

use super::rows::{At, Pen};
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::wire::error_control::{BOOT_UP, OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::message::Errors;
use crate::words::lane::{self, Word};
use crate::words::profiles::Profile;
use crate::words::terms;
use crate::world::change::EmcyChange;
use crate::world::drive::DriveState;

/// A reset command captured so soon after a boot-up was sent before it, in ns: an echo may be late.
const LATE_NS: Ns = Ns::from_ms(10);
/// The same in frames, where there are no stamps.
const LATE: u64 = 2;
/// A state that a node shows within this time after a command was sent before it obeyed, in ns.
const SENT_NS: Ns = Ns::from_ms(1);

/// A state in the lane of the NMT state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodeState {
    /// The state that the node has shown.
    Shown(u8),
    /// The state that it was commanded to.
    Commanded(u8),
    /// It has booted: it is Pre-operational, until it says otherwise.
    BootUp,
    /// It is not heard any more.
    Lost(Word),
    /// The state is unknown.
    Unknown(Word),
}

impl NodeState {
    /// The word by which it is coloured.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Commanded(BOOT_UP) => "initialising",
            Self::Shown(BOOT_UP | PRE_OPERATIONAL) | Self::Commanded(PRE_OPERATIONAL) | Self::BootUp => {
                "pre-operational"
            }
            Self::Shown(OPERATIONAL) | Self::Commanded(OPERATIONAL) => "operational",
            Self::Shown(STOPPED) | Self::Commanded(STOPPED) => "stopped",
            Self::Lost(_) => "lost",
            Self::Shown(_) | Self::Commanded(_) | Self::Unknown(_) => "unknown",
        }
    }

    fn say(self, out: &mut Vec<u8>, lang: crate::words::Lang) {
        match self {
            Self::Shown(state) => lane::state(out, lang, state, None),
            Self::Commanded(BOOT_UP) => lane::word(out, lang, Word::Reset),
            Self::Commanded(state) => lane::state(out, lang, state, Some(Word::Commanded)),
            Self::BootUp => lane::state(out, lang, BOOT_UP, None),
            Self::Lost(word) | Self::Unknown(word) => lane::word(out, lang, word),
        }
    }

    /// Returns true if PDOs of the node go on.
    pub(super) fn has_pdos(self) -> bool {
        matches!(self, Self::Shown(OPERATIONAL) | Self::Commanded(OPERATIONAL) | Self::Unknown(Word::Sends | Word::All))
    }

    /// Returns true if SDO can still show the state of its drive.
    pub(super) fn has_sdo(self) -> bool {
        !matches!(self, Self::Shown(STOPPED) | Self::Commanded(STOPPED))
    }
}

/// One logical device of a drive.
#[derive(Debug)]
struct Axis {
    number: u8,
    state: Option<DriveState>,
    /// It came in a PDO.
    by_pdo: bool,
    /// Since when its lane shows it.
    since: At,
}

/// One node.
#[derive(Debug, Default)]
pub(super) struct Node {
    id: u8,
    /// The state in its lane, and its beginning.
    node_state: Option<NodeState>,
    since: At,
    boot_up: Option<FrameRef>,
    /// The last command to this node, until it shows a state.
    command: Option<(u8, FrameRef)>,
    /// A master commands or configures it: it is not the master itself.
    pub(super) managed: bool,
    /// By its device type.
    pub(super) profile: Profile,
    axes: Vec<Axis>,
    errors: Errors,
    /// Errors that it may have taken back where frames are missing.
    doubted: Vec<u16>,
    /// Its lane shows errors.
    failing: bool,
}

impl Node {
    /// Nothing known of it.
    pub(super) fn new(id: u8) -> Self {
        Self { id, ..Self::default() }
    }

    /// Returns true if a frame now was sent after its boot-up and after the last command.
    pub(super) fn began_before(&self, frame: u64) -> bool {
        let command = self.command.map(|(_, at)| at);
        [self.boot_up, command].into_iter().flatten().all(|at| at.no + LATE < frame)
    }

    /// Returns true if it has shown states.
    pub(super) fn is_heard(&self) -> bool {
        matches!(self.node_state, Some(NodeState::Shown(_)))
    }

    /// Writes the state into its lane, and returns true if it is a new one. A lane that is not shown ends instead.
    pub(super) fn stand(
        &mut self,
        pen: &mut Pen<'_>,
        prefix: &str,
        node_state: NodeState,
        at: At,
        shown: bool,
    ) -> bool {
        if self.node_state == Some(node_state) {
            return false;
        }
        if !shown {
            self.end_node_state(pen, prefix, at);
            return true;
        }
        self.node_state = Some(node_state);
        self.since = at;
        pen.says(&self.name("nmt", prefix), at, Some(node_state.class()), |out, lang| node_state.say(out, lang));
        true
    }

    /// The lane of its state ends.
    pub(super) fn end_node_state(&mut self, pen: &mut Pen<'_>, prefix: &str, at: At) {
        if self.node_state.take().is_some() {
            self.since = at;
            pen.end(&self.name("nmt", prefix), at);
        }
    }

    /// The node, or every node, is silent, since `t_ns` if known.
    pub(super) fn lose(&mut self, pen: &mut Pen<'_>, prefix: &str, node_state: NodeState, t_ns: Option<Ns>, at: At) {
        if self.node_state.is_some() {
            let at = at.at_time(t_ns, self.since);
            self.stand(pen, prefix, node_state, at, true);
        }
    }

    /// Error control has shown a state; gives what the lane should show. `None`: it says nothing new.
    pub(super) fn shows(&mut self, state: u8, at: FrameRef) -> Option<NodeState> {
        if let Some((commanded, command)) = self.command
            && commanded != state
            && sent_before(command, at)
        {
            return None;
        }
        self.command = None;
        Some(NodeState::Shown(state))
    }

    /// It has booted.
    pub(super) fn boots(&mut self, at: FrameRef) {
        (self.boot_up, self.command) = (Some(at), None);
    }

    /// Returns true if a reset command is the echo of one that its boot-up has already answered.
    pub(super) fn has_obeyed(&self, at: FrameRef) -> bool {
        self.boot_up.is_some_and(|boot_up| match at.since(boot_up) {
            Some(age) => (Ns::ZERO..LATE_NS).contains(&age),
            None => boot_up.no + LATE >= at.no,
        })
    }

    /// It was commanded to a state (00: reset); gives what the lane should show. `present`: it was seen. A command to
    /// all nodes is not for the one that gives it: that may be this one.
    pub(super) fn commanded(&mut self, state: u8, explicit: bool, present: bool, at: FrameRef) -> Option<NodeState> {
        self.managed |= explicit;
        let there = match self.node_state {
            // Who is not heard does not hear, as far as anybody knows.
            Some(NodeState::Lost(_) | NodeState::Unknown(Word::Silence)) => true,
            Some(NodeState::Shown(shown)) => shown == state,
            _ => false,
        };
        if there {
            return None;
        }
        self.command = Some((state, at));
        let node_state = if self.managed { NodeState::Commanded(state) } else { NodeState::Unknown(Word::All) };
        (present && (self.managed || self.node_state.is_some())).then_some(node_state)
    }

    /// Concludes its state from its PDOs where no message has shown it.
    pub(super) fn sends(&self) -> NodeState {
        match self.command {
            Some((OPERATIONAL, _)) => NodeState::Commanded(OPERATIONAL),
            _ => NodeState::Unknown(Word::Sends),
        }
    }

    /// Returns true if a PDO was sent before the node could obey a command to send none.
    pub(super) fn will_obey(&self, at: FrameRef) -> bool {
        self.command.is_some_and(|(state, command)| state != OPERATIONAL && sent_before(command, at))
    }

    /// It has sent something for the first time: what it was commanded before.
    pub(super) fn appears(&self) -> Option<NodeState> {
        let told = |(state, _): &(u8, FrameRef)| *state != 0 && self.managed && self.node_state.is_none();
        let (state, _) = self.command.filter(told)?;
        Some(NodeState::Commanded(state))
    }

    /// A statusword has shown the state of an axis, by a PDO or an upload.
    pub(super) fn reports(
        &mut self,
        pen: &mut Pen<'_>,
        prefix: &str,
        (axis, by_pdo): (u8, bool),
        state: Option<DriveState>,
        at: At,
    ) {
        let place = match self.axes.iter().position(|one| one.number == axis) {
            Some(place) => place,
            None if state.is_none() => return,
            None => {
                self.axes.push(Axis { number: axis, state: None, by_pdo, since: at });
                self.axes.len() - 1
            }
        };
        let id = self.id;
        let Some(one) = self.axes.get_mut(place) else { return };
        one.by_pdo = by_pdo;
        if std::mem::replace(&mut one.state, state) == state {
            return;
        }
        one.since = at;
        let name = drive(id, prefix, axis);
        match state {
            Some(state) => pen.row(&name, at, Some(terms::drive::state(pen.lang, state)), Some(state.name())),
            None => pen.end(&name, at),
        }
    }

    /// The state of its drive becomes unknown. `by_pdo`: only if a PDO showed it.
    pub(super) fn end_drives(&mut self, pen: &mut Pen<'_>, prefix: &str, by_pdo: bool, at: At) {
        for one in self.axes.iter_mut().filter(|one| one.by_pdo || !by_pdo) {
            if one.state.take().is_some() {
                pen.end(&drive(self.id, prefix, one.number), at);
            }
        }
    }

    /// The node is not heard any more, since `t_ns` where that is known: nor is its drive, from the same moment on.
    pub(super) fn lose_drives(&mut self, pen: &mut Pen<'_>, prefix: &str, t_ns: Option<Ns>, at: At) {
        for one in &mut self.axes {
            if one.state.take().is_some() {
                pen.end(&drive(self.id, prefix, one.number), at.at_time(t_ns, one.since));
            }
        }
    }

    /// It reports an error, or that there is none any more: these are left.
    pub(super) fn errors(&mut self, pen: &mut Pen<'_>, prefix: &str, emcy: &EmcyChange, at: At, shown: bool) {
        let mut active = Errors::default();
        emcy.active
            .iter()
            .filter(|code| *code == emcy.code || !self.doubted.contains(code))
            .for_each(|code| active.add(code));
        self.doubted.retain(|code| *code != emcy.code && emcy.active.iter().any(|known| known == *code));
        let before = std::mem::replace(&mut self.errors, active);
        let none = self.errors.iter().next().is_none();
        if none || !shown {
            return self.end_errors(pen, prefix, at);
        }
        if self.errors != before || !self.failing {
            self.failing = true;
            let (profile, errors) = (self.profile, self.errors);
            pen.says(&self.name("emcy", prefix), at, Some("active"), |out, lang| {
                lane::errors(out, lang, profile, errors)
            });
        }
    }

    /// Its reported errors become unknown.
    pub(super) fn forget_errors(&mut self, pen: &mut Pen<'_>, prefix: &str, at: At) {
        self.doubted.extend(std::mem::take(&mut self.errors).iter());
        self.end_errors(pen, prefix, at);
    }

    fn end_errors(&mut self, pen: &mut Pen<'_>, prefix: &str, at: At) {
        if std::mem::take(&mut self.failing) {
            pen.end(&self.name("emcy", prefix), at);
        }
    }

    /// Frames are missing: what it does is known again when it says it.
    pub(super) fn forget(&mut self) {
        (self.boot_up, self.command) = (None, None);
    }

    fn name(&self, lane: &str, prefix: &str) -> String {
        format!("{lane}/{prefix}node{}", self.id)
    }
}

/// The name of the lane of a drive: further axes have their number.
fn drive(node: u8, prefix: &str, axis: u8) -> String {
    match axis {
        0 => format!("drive/{prefix}node{node}"),
        _ => format!("drive/{prefix}node{node}/axis{}", axis + 1),
    }
}

/// Returns true if a node sent its state before it could obey a command.
fn sent_before(command: FrameRef, at: FrameRef) -> bool {
    at.since(command).map_or(command.no + 1 == at.no, |age| (Ns::ZERO..SENT_NS).contains(&age))
}
