//! CiA 402's words: states of a drive, commands, modes of operation, bits of statusword and controlword.

use super::{Row, find};
use crate::words::Lang;
use crate::world::drive::{DriveCommand, DriveState};

/// The states of the power drive system.
pub static STATES: &[Row<DriveState>] = words!("drive_states");

/// The commands of the controlword.
pub static COMMANDS: &[Row<DriveCommand>] = words!("drive_commands");

/// The modes of operation that the standard defines.
pub static MODES: &[Row<i8>] = words!("drive_modes");

/// The bits of the statusword.
pub static STATUSWORD: &[Row<u8>] = words!("statusword");

/// The bits of the controlword.
pub static CONTROLWORD: &[Row<u8>] = words!("controlword");

/// Returns the word for a state.
pub fn state(lang: Lang, state: DriveState) -> &'static str {
    find(STATES, lang, state).unwrap_or_default()
}

/// Returns the word for a command.
pub fn command(lang: Lang, command: DriveCommand) -> &'static str {
    find(COMMANDS, lang, command).unwrap_or_default()
}

/// Returns the word for a mode of operation (6060h, 6061h). Every value has one.
pub fn mode(lang: Lang, mode: i8) -> &'static str {
    find(MODES, lang, mode).unwrap_or(match mode {
        ..0 => lang.pick("制造商定义的模式", "manufacturer-specific mode"),
        0.. => lang.pick("保留的模式", "reserved mode"),
    })
}

/// Returns the abbreviation of a mode that the standard defines, the same in every language: `CSP`.
pub fn abbreviation(mode: i8) -> Option<&'static str> {
    find(MODES, Lang::En, mode)?.split_once('(')?.1.strip_suffix(')')
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::words::lang::tests::sound;

    #[test]
    fn complete_and_sorted() {
        sound(STATES);
        sound(COMMANDS);
        sound(MODES);
        sound(STATUSWORD);
        sound(CONTROLWORD);
        assert!(DriveState::ALL.iter().all(|it| !state(Lang::Zh, *it).is_empty()));
        assert_eq!((COMMANDS.len(), STATUSWORD.len(), CONTROLWORD.len()), (8, 16, 16));
    }

    #[test]
    fn words() {
        assert_eq!(state(Lang::Zh, DriveState::OperationEnabled), "运行使能");
        assert_eq!(command(Lang::Zh, DriveCommand::EnableOperation), "使能运行");
        assert_eq!(mode(Lang::Zh, 8), "循环同步位置(CSP)");
        assert_eq!(mode(Lang::En, 1), "profile position (PP)");
        assert_eq!(mode(Lang::Zh, -1), "制造商定义的模式");
        assert_eq!(mode(Lang::En, 5), "reserved mode");
        assert_eq!((abbreviation(11), abbreviation(0), abbreviation(5)), (Some("CSTCA"), None, None));
    }
}
