//! States that a node, or its drive (CiA 402), must reach, with a time limit, and those that it must keep.
//!
//! A state counts when it is shown: by boot-up, heartbeat or guarding response; that of a drive by a statusword in a
//! TPDO or an upload. A command is not a state.

use serde::Deserialize;

use super::{Breach, Closing, EntryPlace, Scene, check_node, check_times, mistake};
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::expectation::{Exp005, Exp006, Exp015};
use crate::rules::finding::Quantity;
use crate::wire::error_control::{BOOT_UP, OPERATIONAL, PRE_OPERATIONAL, STOPPED};
use crate::wire::nmt::commanded_state;
use crate::world::change::Change;
use crate::world::drive::{self, DriveState};

/// An NMT state in the encoding of error control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
struct Nmt(u8);

/// The names of NMT states.
pub(super) const NMT: [(&str, u8); 4] =
    [("boot-up", BOOT_UP), ("stopped", STOPPED), ("operational", OPERATIONAL), ("pre-operational", PRE_OPERATIONAL)];

impl TryFrom<String> for Nmt {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let row = NMT.iter().find(|row| row.0 == name);
        row.map(|row| Self(row.1)).ok_or_else(|| format!("state={name:?}"))
    }
}

/// A state of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
struct Drive(DriveState);

impl TryFrom<String> for Drive {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let state = DriveState::ALL.into_iter().find(|state| state.name() == name);
        state.map(Self).ok_or_else(|| format!("drive={name:?}"))
    }
}

/// The event from which time is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Since {
    /// The capture's first frame.
    Start,
    /// The node's last boot-up.
    BootUp,
}

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StateEntry {
    line: u32,
    bus: Option<String>,
    node: u8,
    state: Option<Nmt>,
    drive: Option<Drive>,
    axis: Option<u8>,
    by_ns: Option<Ns>,
    since: Option<Since>,
    stays: Option<bool>,
}

impl StateEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_node(self.line, Some(self.node))?;
        check_times(self.line, &[], &[self.by_ns])?;
        if self.state.is_some() == self.drive.is_some() {
            return mistake(self.line, "either state or drive");
        }
        if self.axis.is_some_and(|axis| !(1..=drive::AXES).contains(&axis)) {
            return mistake(self.line, "axis");
        }
        if self.state == Some(Nmt(BOOT_UP)) && self.stays == Some(true) {
            return mistake(self.line, "boot-up with stays");
        }
        Ok(())
    }

    fn target(&self) -> Target {
        match (self.state, self.drive) {
            (_, Some(Drive(state))) => Target::Drive(state, self.axis.unwrap_or(1)),
            (Some(Nmt(state)), None) => Target::Nmt(state),
            (None, None) => Target::Nmt(BOOT_UP),
        }
    }
}

/// The required state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Nmt(u8),
    /// The state of an axis, from 1.
    Drive(DriveState, u8),
}

impl Target {
    fn quantity(self) -> Quantity {
        match self {
            Self::Nmt(state) => Quantity::State(state),
            Self::Drive(state, _) => Quantity::Drive(state.coding().1),
        }
    }

    fn is_shown_by(self, shown: Quantity) -> bool {
        match (self, shown) {
            (Self::Nmt(wanted), Quantity::State(state)) => wanted == state,
            (Self::Drive(wanted, _), Quantity::Statusword(word)) => DriveState::of(word) == Some(wanted),
            _ => false,
        }
    }
}

/// A node of one bus.
#[derive(Clone, Copy, Debug)]
struct NodeTrack {
    bus: BusId,
    /// The last state shown.
    shown: Option<Quantity>,
    /// Its last boot-up.
    booted: Option<FrameRef>,
    /// The state was reached, and it was reached since the last boot-up.
    reached: bool,
    reached_since: bool,
    /// It is in the state.
    inside: bool,
    /// It sends error control other than boot-ups.
    controlled: bool,
    /// The state of its last command, or that after a boot-up.
    commanded: Option<u8>,
}

/// An expectation and its progress.
#[derive(Debug)]
struct Progress {
    entry: StateEntry,
    place: EntryPlace,
    target: Target,
    tracks: Vec<NodeTrack>,
    /// It was reached in time, or has no time limit.
    timely: bool,
    /// Timestamps are missing where it was reached.
    untimed: bool,
    /// It was reached without a boot-up before.
    unbooted: bool,
    /// Its time was judged, or cannot be judged.
    judged: bool,
    /// It was reported as overdue.
    overdue: bool,
    /// Frames were lost before it was reached.
    lost: bool,
}

impl Progress {
    fn track(&mut self, bus: BusId) -> Option<&mut NodeTrack> {
        if let Some(place) = self.tracks.iter().position(|track| track.bus == bus) {
            return self.tracks.get_mut(place);
        }
        self.tracks.push(NodeTrack {
            bus,
            shown: None,
            booted: None,
            reached: false,
            reached_since: false,
            inside: false,
            controlled: false,
            commanded: None,
        });
        self.tracks.last_mut()
    }

    /// Records a shown state.
    fn show(&mut self, shown: Quantity, scene: &mut Scene<'_>) {
        let hit = self.target.is_shown_by(shown);
        let (expected, stays) = (self.target.quantity(), self.entry.stays == Some(true));
        let Some(track) = self.track(scene.bus) else { return };
        let first = track.shown.replace(shown).is_none();
        let (inside, again) = (std::mem::replace(&mut track.inside, hit), track.reached_since);
        if hit {
            (track.reached, track.reached_since) = (true, true);
            let booted = track.booted;
            if !again {
                self.judge(first, booted, scene);
            }
        } else if inside && stays {
            let breach = scene.breach(match shown {
                Quantity::State(BOOT_UP) => Exp006::BootedUp { expected, found: shown },
                _ => Exp006::Left { expected, found: shown },
            });
            scene.raise(&self.place, breach);
        }
    }

    /// Records a boot-up.
    fn boot_up(&mut self, scene: &mut Scene<'_>) {
        let (since, at) = (self.entry.since, scene.at);
        if let Some(track) = self.track(scene.bus) {
            track.booted = Some(at);
            if since == Some(Since::BootUp) {
                track.reached_since = false;
                (self.overdue, self.lost) = (false, false);
            }
        }
        if let Target::Nmt(_) = self.target {
            self.show(Quantity::State(BOOT_UP), scene);
        } else if let Some(track) = self.track(scene.bus)
            && std::mem::take(&mut track.inside)
            && self.entry.stays == Some(true)
        {
            let (expected, found) = (self.target.quantity(), Quantity::State(BOOT_UP));
            scene.raise(&self.place, scene.breach(Exp006::BootedUp { expected, found }));
        }
    }

    /// Judges a state that is reached for the first time or since a boot-up. `first`: the node was not seen before.
    fn judge(&mut self, first: bool, booted: Option<FrameRef>, scene: &mut Scene<'_>) {
        let Some(limit) = self.entry.by_ns else {
            self.timely = true;
            return;
        };
        let event = self.target == Target::Nmt(BOOT_UP);
        let since = self.entry.since.unwrap_or(Since::Start);
        let elapsed = match since {
            Since::Start => scene.elapsed_ns(),
            Since::BootUp => match booted {
                Some(booted) => scene.at.t_ns.zip(booted.t_ns).map(|(now, then)| now - then),
                None => {
                    self.unbooted = true;
                    return;
                }
            },
        };
        let Some(elapsed) = elapsed else {
            self.untimed = true;
            return;
        };
        self.judged = true;
        if elapsed <= limit {
            self.timely = true;
        } else if self.overdue {
            // This was reported when its time expired.
        } else if self.lost {
            scene.raise(&self.place, scene.breach(Exp015::Lost));
        } else if since == Since::Start && self.timely {
            // It was in time on another bus.
        } else if since == Since::Start && first && !event {
            let unknown = Exp015::SinceWhen { expected: self.target.quantity(), found: elapsed };
            scene.raise(&self.place, scene.breach(unknown));
        } else {
            let (expected, found) = (self.target.quantity(), elapsed);
            let breach = scene.breach(match (event, since) {
                (true, _) => Exp005::BootUpLate { expected, limit, found },
                (false, Since::Start) => Exp005::LateAfterStart { expected, limit, found },
                (false, Since::BootUp) => Exp005::LateAfterBootUp { expected, limit, found },
            });
            let breach =
                if let (Since::BootUp, Some(booted)) = (since, booted) { breach.about(booted) } else { breach };
            scene.raise(&self.place, breach);
        }
    }

    /// Notes that frames of a bus are missing: the state may have been reached meanwhile.
    fn lose(&mut self, bus: BusId) {
        let reached = |track: &NodeTrack| match self.entry.since {
            Some(Since::BootUp) => track.reached_since || track.booted.is_none() && track.reached,
            _ => track.reached,
        };
        self.lost |= !self.tracks.iter().any(|track| track.bus == bus && reached(track));
    }

    /// Reports, by the clock, a state that was not reached in time.
    fn expire(&mut self, start_ns: Option<Ns>, closing: &mut Closing<'_>) {
        let (Some(limit), Some(now), false) = (self.entry.by_ns, closing.end_ns, self.overdue) else { return };
        let over = |then: Option<Ns>| then.is_some_and(|then| now - then > limit);
        let waited = self.entry.since == Some(Since::BootUp);
        let expired = if waited {
            self.tracks.iter().any(|track| !track.reached_since && over(track.booted.and_then(|booted| booted.t_ns)))
        } else {
            over(start_ns) && !self.tracks.iter().any(|track| track.reached)
        };
        if expired {
            self.finish(closing);
            self.overdue = true;
        }
    }

    fn finish(&self, closing: &mut Closing<'_>) {
        if self.overdue {
            return;
        }
        let expected = self.target.quantity();
        if !self.tracks.iter().any(|track| track.reached) {
            return self.never(closing);
        }
        if !self.judged && self.entry.by_ns.is_some() {
            if self.untimed {
                closing.unchecked(&self.place, Exp015::NoStamps);
            } else if self.unbooted {
                closing.unchecked(&self.place, Exp015::NoBootUp);
            }
        }
        let (Some(limit), Some(Since::BootUp), Some(end)) = (self.entry.by_ns, self.entry.since, closing.end_ns) else {
            return;
        };
        let again = self.tracks.iter().find_map(|track| {
            let booted = track.booted.filter(|_| track.reached && !track.reached_since)?;
            Some((track, booted)).filter(|_| booted.t_ns.is_some_and(|then| end - then > limit))
        });
        if let Some((track, booted)) = again {
            if self.lost {
                return closing.unchecked(&self.place, Exp015::Lost);
            }
            let found = track.shown.unwrap_or(Quantity::State(BOOT_UP));
            let what = Exp005::NotSinceBootUp { expected, limit, found };
            closing.raise(&self.place, Breach::new(what, closing.last, track.bus).about(booted));
        }
    }

    /// Reports a state that was never reached.
    fn never(&self, closing: &mut Closing<'_>) {
        let expected = self.target.quantity();
        if self.lost && (self.entry.by_ns.is_some() || self.target == Target::Nmt(BOOT_UP)) {
            return closing.unchecked(&self.place, Exp015::Lost);
        }
        let obeyed = self
            .tracks
            .iter()
            .find(|track| !track.controlled && track.commanded.is_some_and(|state| self.target == Target::Nmt(state)));
        if let Some(track) = obeyed {
            let breach = Breach::new(Exp015::OnlyCommanded { expected }, closing.last, track.bus);
            return closing.raise(&self.place, breach);
        }
        let last = self.tracks.iter().find_map(|track| Some((track.bus, track.shown?)));
        let breach = match (last, self.target) {
            (_, Target::Nmt(BOOT_UP)) => closing.breach(&self.place, Exp005::NoBootUp { expected }),
            (None, _) => closing.breach(&self.place, Exp005::NeverAnything { expected }),
            (Some((bus, found)), _) => Breach::new(Exp005::Never { expected, found }, closing.last, bus),
        };
        closing.raise(&self.place, breach);
    }
}

/// All expectations of states.
#[derive(Debug)]
pub(super) struct States {
    all: Vec<Progress>,
}

impl States {
    pub(super) fn new(file: &str, entries: &[StateEntry]) -> Self {
        let all = entries.iter().map(|entry| Progress {
            entry: entry.clone(),
            place: EntryPlace::new(file, entry.line, entry.bus.as_ref(), Some(entry.node)),
            target: entry.target(),
            tracks: Vec::new(),
            timely: false,
            untimed: false,
            unbooted: false,
            judged: false,
            overdue: false,
            lost: false,
        });
        Self { all: all.collect() }
    }

    fn of<'a>(&'a mut self, node: u8, name: &'a [u8]) -> impl Iterator<Item = &'a mut Progress> {
        self.all.iter_mut().filter(move |one| one.place.holds(name, Some(node)))
    }

    /// Takes a boot-up, a report of a state, a statusword or an NMT command.
    pub(super) fn change(&mut self, change: &Change, scene: &mut Scene<'_>) {
        let name = scene.name;
        match *change {
            Change::BootUp { node } => {
                for one in self.of(node, name) {
                    if let Some(track) = one.track(scene.bus) {
                        track.commanded = Some(PRE_OPERATIONAL);
                    }
                    one.boot_up(scene);
                }
            }
            Change::State { node, state, .. } => {
                for one in self.of(node, name) {
                    if let Some(track) = one.track(scene.bus) {
                        track.controlled = true;
                    }
                    if let Target::Nmt(_) = one.target {
                        one.show(Quantity::State(state), scene);
                    }
                }
            }
            Change::Drive { node, axis, statusword, state: Some(_), by, .. } if by.is_sure() => {
                for one in self.of(node, name) {
                    if matches!(one.target, Target::Drive(_, number) if number == axis + 1) {
                        one.show(Quantity::Statusword(statusword), scene);
                    }
                }
            }
            Change::Command { command, node } => {
                let Some(state) = commanded_state(command) else { return };
                for one in self.all.iter_mut().filter(|one| one.place.is_on(name)) {
                    if (node == 0 || node == one.entry.node)
                        && let Some(track) = one.track(scene.bus)
                    {
                        track.commanded = Some(state);
                    }
                }
            }
            _ => {}
        }
    }

    /// Notes that frames of a bus are missing.
    pub(super) fn lost(&mut self, bus: BusId, name: &[u8]) {
        for one in self.all.iter_mut().filter(|one| one.place.is_on(name)) {
            one.lose(bus);
        }
    }

    /// Reports what should have been reached by the time of `closing` and was not.
    pub(super) fn overdue(&mut self, start_ns: Option<Ns>, closing: &mut Closing<'_>) {
        for one in &mut self.all {
            one.expire(start_ns, closing);
        }
    }

    /// Reports at the end of the capture.
    pub(super) fn finish(&self, closing: &mut Closing<'_>) {
        for one in &self.all {
            one.finish(closing);
        }
    }
}
