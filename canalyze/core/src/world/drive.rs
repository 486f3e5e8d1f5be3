//! CiA 402 (IEC 61800-7-201), drives: the meaning of statusword, controlword and modes of operation, and the possible
//! transitions of states.
//!
//! | transition | from | to | by |
//! |---|---|---|---|
//! | 1 | not ready to switch on | switch on disabled | itself |
//! | 2 | switch on disabled | ready to switch on | shutdown |
//! | 3 | ready to switch on | switched on | switch on |
//! | 4 | switched on | operation enabled | enable operation |
//! | 5 | operation enabled | switched on | disable operation |
//! | 6 | switched on | ready to switch on | shutdown |
//! | 7 | ready to switch on | switch on disabled | disable voltage, quick stop |
//! | 8 | operation enabled | ready to switch on | shutdown |
//! | 9 | operation enabled | switch on disabled | disable voltage |
//! | 10 | switched on | switch on disabled | disable voltage, quick stop |
//! | 11 | operation enabled | quick stop active | quick stop |
//! | 12 | quick stop active | switch on disabled | itself, disable voltage |
//! | 13 | any but the fault states | fault reaction active | a fault |
//! | 14 | fault reaction active | fault | itself |
//! | 15 | fault | switch on disabled | fault reset |
//! | 16 | quick stop active | operation enabled | enable operation |
//!
//! A statusword is a sample: states between two of them are not seen, and every state can be reached from every
//! other one in some steps (not ready to switch on only by a restart). A pair of samples alone therefore proves
//! nothing; [`explained`] takes the controlwords in between. These are pure functions over numbers: the caller has to
//! know the object of a value, and that the device is a drive.

/// Maximum number of logical devices: 6000h-9FFFh in steps of 800h.
pub const AXES: u8 = 8;

/// The profile's number in bits 15-0 of 1000h.
pub const PROFILE: u16 = 402;

/// An object of the power drive system whose value has words of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DriveObject {
    /// 6040h.
    Controlword,
    /// 6041h.
    Statusword,
    /// 6060h.
    ModesOfOperation,
    /// 6061h.
    ModesOfOperationDisplay,
    /// 6502h.
    SupportedModes,
}

impl DriveObject {
    /// Returns the object at an index of any axis.
    pub const fn at(index: u16) -> Option<Self> {
        if axis(index).is_none() {
            return None;
        }
        Some(match crate::world::od::first_axis(index) {
            0x6040 => Self::Controlword,
            0x6041 => Self::Statusword,
            0x6060 => Self::ModesOfOperation,
            0x6061 => Self::ModesOfOperationDisplay,
            0x6502 => Self::SupportedModes,
            _ => return None,
        })
    }
}

/// Returns the logical device of an index, 0..=7; `None` outside 6000h-9FFFh.
pub const fn axis(index: u16) -> Option<u8> {
    match index {
        0x6000..=0x9FFF => Some(((index - 0x6000) / 0x800) as u8),
        _ => None,
    }
}

/// A state of the power drive system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DriveState {
    /// Not ready to switch on: the drive starts.
    NotReadyToSwitchOn,
    /// Switch on disabled.
    SwitchOnDisabled,
    /// Ready to switch on.
    ReadyToSwitchOn,
    /// Switched on.
    SwitchedOn,
    /// Operation enabled.
    OperationEnabled,
    /// Quick stop active.
    QuickStopActive,
    /// Fault reaction active.
    FaultReactionActive,
    /// Fault.
    Fault,
}

use DriveState::{
    Fault, FaultReactionActive, NotReadyToSwitchOn, OperationEnabled, QuickStopActive, ReadyToSwitchOn,
    SwitchOnDisabled, SwitchedOn,
};

/// The mask of a statusword, the masked value, and the state. No statusword matches two rows.
const STATES: [(u16, u16, DriveState); 8] = [
    (0x004F, 0x0000, NotReadyToSwitchOn),
    (0x004F, 0x0040, SwitchOnDisabled),
    (0x006F, 0x0021, ReadyToSwitchOn),
    (0x006F, 0x0023, SwitchedOn),
    (0x006F, 0x0027, OperationEnabled),
    (0x006F, 0x0007, QuickStopActive),
    (0x004F, 0x000F, FaultReactionActive),
    (0x004F, 0x0008, Fault),
];

impl DriveState {
    /// Every state, in the order of the standard's table.
    pub const ALL: [Self; 8] = [
        NotReadyToSwitchOn,
        SwitchOnDisabled,
        ReadyToSwitchOn,
        SwitchedOn,
        OperationEnabled,
        QuickStopActive,
        FaultReactionActive,
        Fault,
    ];

    /// The name in machine output, that of the standard in kebab-case.
    pub const fn name(self) -> &'static str {
        match self {
            NotReadyToSwitchOn => "not-ready-to-switch-on",
            SwitchOnDisabled => "switch-on-disabled",
            ReadyToSwitchOn => "ready-to-switch-on",
            SwitchedOn => "switched-on",
            OperationEnabled => "operation-enabled",
            QuickStopActive => "quick-stop-active",
            FaultReactionActive => "fault-reaction-active",
            Fault => "fault",
        }
    }

    /// Returns the state of a statusword; `None` if its bits are invalid.
    pub fn of(statusword: u16) -> Option<Self> {
        STATES.iter().find(|(mask, left, _)| statusword & mask == *left).map(|row| row.2)
    }

    /// Returns the bits of the statusword for this state, and their value.
    pub fn coding(self) -> (u16, u16) {
        STATES.iter().find(|row| row.2 == self).map_or((0, 0), |row| (row.0, row.1))
    }

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// A command of the controlword.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DriveCommand {
    /// Bit 7 rises.
    FaultReset,
    /// `0xxx xx0x`.
    DisableVoltage,
    /// `0xxx x01x`.
    QuickStop,
    /// `0xxx x110`.
    Shutdown,
    /// `0xxx 0111` after another command than enable operation.
    SwitchOn,
    /// `0xxx 0111` after enable operation.
    DisableOperation,
    /// `0xxx 0111` after an unknown command: both commands have these bits, and both lead to switched on.
    SwitchOnOrDisableOperation,
    /// `0xxx 1111`; if the drive is only ready to switch on, it switches on first.
    EnableOperation,
}

/// Returns the command of bits 7 and 3-0 of a controlword as a level: `None` with bit 7 set.
const fn level(controlword: u16) -> Option<DriveCommand> {
    Some(match controlword & 0x8F {
        0x80.. => return None,
        low if low & 0b0010 == 0 => DriveCommand::DisableVoltage,
        low if low & 0b0100 == 0 => DriveCommand::QuickStop,
        low if low & 0b0001 == 0 => DriveCommand::Shutdown,
        0b0111 => DriveCommand::SwitchOnOrDisableOperation,
        _ => DriveCommand::EnableOperation,
    })
}

/// Returns the command of a controlword. `previous` is the last one that differs from it, `None` if it is unknown.
///
/// `None` if bit 7 stays set: the edge resets a fault, and no other command has the bit.
pub fn command(controlword: u16, previous: Option<u16>) -> Option<DriveCommand> {
    let Some(asked) = level(controlword) else {
        return previous.is_none_or(|word| word & 0x80 == 0).then_some(DriveCommand::FaultReset);
    };
    if asked != DriveCommand::SwitchOnOrDisableOperation {
        return Some(asked);
    }
    Some(match previous.map(level) {
        None | Some(Some(DriveCommand::SwitchOnOrDisableOperation)) => asked,
        Some(Some(DriveCommand::EnableOperation)) => DriveCommand::DisableOperation,
        Some(_) => DriveCommand::SwitchOn,
    })
}

/// Bit 7 of the statusword.
pub const fn warning(statusword: u16) -> bool {
    statusword & 1 << 7 != 0
}

/// Bit 9 of the statusword: the drive obeys the controlword. Otherwise it is operated locally.
pub const fn remote(statusword: u16) -> bool {
    statusword & 1 << 9 != 0
}

/// Bit 8 of the controlword.
pub const fn halt(controlword: u16) -> bool {
    controlword & 1 << 8 != 0
}

/// Returns the standard modes in supported drive modes (6502h) with the numbers of 6060h: bit n is mode n+1.
pub fn supported_modes(modes: u32) -> impl Iterator<Item = i8> {
    (1..=11).filter(move |mode| *mode != 5 && modes >> (mode - 1) & 1 != 0)
}

/// A transition: number, from, to, the commands that cause it, and true if it can occur without a command.
///
/// More of them occur without a command than the standard lists, since drives leave their states when power is lost, a
/// limit switch is hit, the bus is lost or a local input resets a fault. Upward, toward operation enabled, none does.
type Transition = (u8, DriveState, DriveState, &'static [DriveCommand], bool);

const TRANSITIONS: &[Transition] = &[
    (1, NotReadyToSwitchOn, SwitchOnDisabled, &[], true),
    (2, SwitchOnDisabled, ReadyToSwitchOn, &[DriveCommand::Shutdown], false),
    (3, ReadyToSwitchOn, SwitchedOn, &[DriveCommand::SwitchOnOrDisableOperation, DriveCommand::EnableOperation], false),
    (4, SwitchedOn, OperationEnabled, &[DriveCommand::EnableOperation], false),
    (5, OperationEnabled, SwitchedOn, &[DriveCommand::SwitchOnOrDisableOperation], true),
    (6, SwitchedOn, ReadyToSwitchOn, &[DriveCommand::Shutdown], true),
    (7, ReadyToSwitchOn, SwitchOnDisabled, &[DriveCommand::DisableVoltage, DriveCommand::QuickStop], true),
    (8, OperationEnabled, ReadyToSwitchOn, &[DriveCommand::Shutdown], true),
    (9, OperationEnabled, SwitchOnDisabled, &[DriveCommand::DisableVoltage], true),
    (10, SwitchedOn, SwitchOnDisabled, &[DriveCommand::DisableVoltage, DriveCommand::QuickStop], true),
    (11, OperationEnabled, QuickStopActive, &[DriveCommand::QuickStop], true),
    (12, QuickStopActive, SwitchOnDisabled, &[DriveCommand::DisableVoltage], true),
    (13, NotReadyToSwitchOn, FaultReactionActive, &[], true),
    (13, SwitchOnDisabled, FaultReactionActive, &[], true),
    (13, ReadyToSwitchOn, FaultReactionActive, &[], true),
    (13, SwitchedOn, FaultReactionActive, &[], true),
    (13, OperationEnabled, FaultReactionActive, &[], true),
    (13, QuickStopActive, FaultReactionActive, &[], true),
    (14, FaultReactionActive, Fault, &[], true),
    (15, Fault, SwitchOnDisabled, &[DriveCommand::FaultReset], true),
    (16, QuickStopActive, OperationEnabled, &[DriveCommand::EnableOperation], false),
];

/// The relation of two states in two samples of the statusword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// It is the same state.
    Same,
    /// One transition of the standard, 1..=16.
    Directly(u8),
    /// At least this many transitions, 2..: the states between were not seen.
    Through(u8),
    /// Only a restart of the device: no transition leads to not ready to switch on.
    Restart,
}

/// Returns the relation of `from` and `to`, whatever was commanded.
pub fn reach(from: DriveState, to: DriveState) -> Reach {
    if from == to {
        return Reach::Same;
    }
    if let Some(row) = TRANSITIONS.iter().find(|row| row.1 == from && row.2 == to) {
        return Reach::Directly(row.0);
    }
    let mut reached = from.bit();
    for steps in 1..=8 {
        reached = step(reached, |_| true);
        if reached & to.bit() != 0 {
            return Reach::Through(steps);
        }
    }
    Reach::Restart
}

/// Returns true if `to` can follow `from` after these controlwords: the one in force at `from`, and all after it up to
/// `to`, in their order. Without any, the one in force is unknown, and the result is true.
///
/// It errs toward true: a controlword may be obeyed late, in part, or not at all; faults and falls toward switch on
/// disabled may occur at any time; a fault may be reset otherwise. False is left for a state nearer to operation
/// enabled without a controlword that leads to it. The caller has to consider three more cases. Several controlwords
/// from before `from` may still be in progress: a word held back for a SYNC, or a sample of the statusword that waited
/// to be sent; they have to be passed, too. A drive that is operated locally ([`remote`] is false in either sample)
/// obeys other commands. A restart of the device, or a gap in the capture, explains everything.
pub fn explained(from: DriveState, to: DriveState, controlwords: impl IntoIterator<Item = u16>) -> bool {
    let mut reached = from.bit();
    let mut any = false;
    for word in controlwords {
        any = true;
        // Drives obey the other bits beside a bit 7 that stays set, although the standard defines no such command.
        let asked = level(word & !0x80);
        // A word is in force until the next one: the drive may take several steps by it.
        loop {
            let further = step(reached, |row| row.4 || asked.is_some_and(|asked| row.3.contains(&asked)));
            if further == reached {
                break;
            }
            reached = further;
        }
    }
    !any || reached & to.bit() != 0
}

/// Returns the states of a set and those that one transition leads to.
fn step(states: u8, may: impl Fn(&Transition) -> bool) -> u8 {
    let taken = TRANSITIONS.iter().filter(|row| states & row.1.bit() != 0 && may(row));
    taken.fold(states, |reached, row| reached | row.2.bit())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn states_of_real_statuswords() {
        let words = [
            (0x1637, Some(OperationEnabled)),
            (0x0250, Some(SwitchOnDisabled)),
            (0x0218, Some(Fault)),
            (0x0217, Some(QuickStopActive)),
            (0x0740, Some(SwitchOnDisabled)),
            (0x0721, Some(ReadyToSwitchOn)),
            (0x0723, Some(SwitchedOn)),
            (0x0737, Some(OperationEnabled)),
            (0x0000, Some(NotReadyToSwitchOn)),
            (0x021F, Some(FaultReactionActive)),
            (0x0001, None),
            (0x0022, None),
            (0x0048, None),
        ];
        for (word, state) in words {
            assert_eq!(DriveState::of(word), state, "{word:04X}");
        }
        for word in 0..=u16::MAX {
            assert!(STATES.iter().filter(|row| word & row.0 == row.1).count() <= 1, "{word:04X}");
        }
        for state in DriveState::ALL {
            assert_eq!(DriveState::of(state.coding().1), Some(state));
        }
    }

    #[test]
    fn commands() {
        let words = [
            (0x0000, None, Some(DriveCommand::DisableVoltage)),
            (0x000D, None, Some(DriveCommand::DisableVoltage)),
            (0x0002, None, Some(DriveCommand::QuickStop)),
            (0x000B, None, Some(DriveCommand::QuickStop)),
            (0x0006, None, Some(DriveCommand::Shutdown)),
            (0x000E, None, Some(DriveCommand::Shutdown)),
            (0x0007, None, Some(DriveCommand::SwitchOnOrDisableOperation)),
            (0x0007, Some(0x0006), Some(DriveCommand::SwitchOn)),
            (0x0007, Some(0x000F), Some(DriveCommand::DisableOperation)),
            (0x0007, Some(0x001F), Some(DriveCommand::DisableOperation)),
            (0x0007, Some(0x0107), Some(DriveCommand::SwitchOnOrDisableOperation)),
            (0x0007, Some(0x0080), Some(DriveCommand::SwitchOn)),
            (0x000F, Some(0x0007), Some(DriveCommand::EnableOperation)),
            (0x003F, None, Some(DriveCommand::EnableOperation)),
            (0x0080, None, Some(DriveCommand::FaultReset)),
            (0x008F, Some(0x000F), Some(DriveCommand::FaultReset)),
            (0x008F, Some(0x0080), None),
        ];
        for (word, previous, expected) in words {
            assert_eq!(command(word, previous), expected, "{word:04X} after {previous:04X?}");
        }
    }

    #[test]
    fn objects_of_every_axis() {
        assert_eq!(DriveObject::at(0x6040), Some(DriveObject::Controlword));
        assert_eq!(DriveObject::at(0x6841), Some(DriveObject::Statusword));
        assert_eq!(DriveObject::at(0x9861), Some(DriveObject::ModesOfOperationDisplay));
        assert_eq!(DriveObject::at(0x6064), None);
        assert_eq!(DriveObject::at(0xA040), None);
        assert_eq!((axis(0x6040), axis(0x6841), axis(0x9FFF)), (Some(0), Some(1), Some(AXES - 1)));
        assert_eq!((axis(0x5FFF), axis(0xA000)), (None, None));
    }

    #[test]
    fn bits() {
        assert_eq!(supported_modes(0x0000_03ED).collect::<Vec<_>>(), [1, 3, 4, 6, 7, 8, 9, 10]);
        assert_eq!(supported_modes(0xFFFF_0010).count(), 0);
        assert!(warning(0x0080) && remote(0x0200) && !warning(0x0200));
        assert!(halt(0x010F) && !halt(0x000F));
    }

    #[test]
    fn reach_of_states() {
        assert_eq!(reach(Fault, Fault), Reach::Same);
        assert_eq!(reach(SwitchOnDisabled, ReadyToSwitchOn), Reach::Directly(2));
        assert_eq!(reach(QuickStopActive, OperationEnabled), Reach::Directly(16));
        assert_eq!(reach(SwitchOnDisabled, OperationEnabled), Reach::Through(3));
        assert_eq!(reach(Fault, OperationEnabled), Reach::Through(4));
        assert_eq!(reach(OperationEnabled, Fault), Reach::Through(2));
        assert_eq!(reach(NotReadyToSwitchOn, OperationEnabled), Reach::Through(4));
        for from in DriveState::ALL {
            for to in DriveState::ALL {
                let restart = to == NotReadyToSwitchOn && from != to;
                assert_eq!(reach(from, to) == Reach::Restart, restart, "{from:?} {to:?}");
            }
        }
    }

    #[test]
    fn what_controlwords_explain() {
        // The whole way up, sampled at its ends or at any step.
        let way = [0x0000, 0x0006, 0x0007, 0x000F];
        assert!(explained(SwitchOnDisabled, OperationEnabled, way));
        assert!(explained(Fault, OperationEnabled, [0x0080, 0x0006, 0x000F]));
        assert!(explained(SwitchOnDisabled, OperationEnabled, [0x0006, 0x000F]));
        assert!(explained(Fault, ReadyToSwitchOn, [0x0086]));
        for to in [ReadyToSwitchOn, SwitchedOn, OperationEnabled, Fault, QuickStopActive] {
            assert!(explained(SwitchOnDisabled, to, way), "{to:?}");
        }
        // A controlword that stays: the fault comes, and the drive does not go up by itself.
        assert!(explained(OperationEnabled, Fault, [0x000F]));
        assert!(explained(OperationEnabled, SwitchOnDisabled, [0x000F]));
        assert!(!explained(Fault, OperationEnabled, [0x000F]));
        assert!(!explained(SwitchOnDisabled, OperationEnabled, [0x000F]));
        assert!(!explained(SwitchOnDisabled, ReadyToSwitchOn, [0x0000]));
        assert!(!explained(SwitchedOn, OperationEnabled, [0x0006, 0x0007]));
        // After a fault the way up begins with shutdown.
        assert!(!explained(Fault, OperationEnabled, [0x0080, 0x0007, 0x000F]));
        // Quick stop, and enabled again out of it.
        assert!(explained(OperationEnabled, OperationEnabled, [0x0002, 0x000F]));
        assert!(explained(QuickStopActive, OperationEnabled, [0x0002, 0x000F]));
        assert!(!explained(QuickStopActive, OperationEnabled, [0x0002]));
        // The word in force is unknown.
        assert!(explained(Fault, OperationEnabled, []));
        assert!(!explained(Fault, NotReadyToSwitchOn, [0x0080]));
    }

    /// A drive that keeps to the standard: its state after a controlword, the commands' rows taken at once.
    fn obey(state: DriveState, word: u16, before: u16) -> DriveState {
        let asked = if word & !before & 0x80 != 0 { Some(DriveCommand::FaultReset) } else { level(word) };
        TRANSITIONS
            .iter()
            .find(|row| row.1 == state && asked.is_some_and(|asked| row.3.contains(&asked)))
            .map_or(state, |row| row.2)
    }

    proptest! {
        /// Two samples of a drive are always explained, whatever it is commanded, in words that are obeyed once, twice
        /// or not at all, with faults in between.
        #[test]
        fn never_wrong_on_a_drive_that_obeys(
            words in proptest::collection::vec((0..16_u16, any::<bool>(), 0..3_u8, 0..12_u8), 1..40),
            samples: (prop::sample::Index, prop::sample::Index),
        ) {
            let mut state = SwitchOnDisabled;
            let mut seen = vec![];
            let mut before = 0;
            for (low, reset, times, chance) in words {
                let word = low | u16::from(reset) << 7;
                for _ in 0..times {
                    state = obey(state, word, before);
                }
                if times > 0 {
                    before = word;
                }
                state = match (state, chance) {
                    (Fault, _) => Fault,
                    (FaultReactionActive, _) => Fault,
                    (QuickStopActive, 0..6) => SwitchOnDisabled,
                    (_, 0) => FaultReactionActive,
                    (state, _) => state,
                };
                seen.push((word, state));
            }
            let (a, b) = (samples.0.index(seen.len()), samples.1.index(seen.len()));
            let (first, last) = (a.min(b), a.max(b));
            let given = seen[first..=last].iter().map(|row| row.0);
            // An earlier word than the last one may be in force at the first sample.
            let given = std::iter::once(before_of(&seen, first)).chain(given);
            prop_assert!(explained(seen[first].1, seen[last].1, given));
        }
    }

    fn before_of(seen: &[(u16, DriveState)], at: usize) -> u16 {
        at.checked_sub(1).map_or(0, |before| seen[before].0)
    }
}
