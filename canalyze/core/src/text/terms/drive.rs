//! CiA 402's words: states of a drive, commands, modes of operation, bits of statusword and controlword.

use super::{Row, find};
use crate::drive::{Command, State};
use crate::text::Lang;

/// The states of the power drive system.
pub static STATES: &[Row<State>] = &[
    (State::NotReadyToSwitchOn, "未准备好", "not ready to switch on"),
    (State::SwitchOnDisabled, "禁止接通", "switch on disabled"),
    (State::ReadyToSwitchOn, "准备接通", "ready to switch on"),
    (State::SwitchedOn, "已接通", "switched on"),
    (State::OperationEnabled, "运行使能", "operation enabled"),
    (State::QuickStopActive, "快速停止有效(Quick stop active)", "quick stop active"),
    (State::FaultReactionActive, "故障反应中(Fault reaction active)", "fault reaction active"),
    (State::Fault, "故障", "fault"),
];

/// The commands of the controlword.
pub static COMMANDS: &[Row<Command>] = &[
    (Command::FaultReset, "故障复位", "fault reset"),
    (Command::DisableVoltage, "断开电压(Disable voltage)", "disable voltage"),
    (Command::QuickStop, "快速停止", "quick stop"),
    (Command::Shutdown, "关闭(Shutdown)", "shutdown"),
    (Command::SwitchOn, "接通", "switch on"),
    (Command::DisableOperation, "禁止运行", "disable operation"),
    (Command::SwitchOnOrDisableOperation, "接通/禁止运行", "switch on / disable operation"),
    (Command::EnableOperation, "使能运行", "enable operation"),
];

/// The modes of operation that the standard defines.
pub static MODES: &[Row<i8>] = &[
    (0, "未指定模式", "no mode"),
    (1, "轮廓位置(PP)", "profile position (PP)"),
    (2, "速度(VL)", "velocity (VL)"),
    (3, "轮廓速度(PV)", "profile velocity (PV)"),
    (4, "轮廓转矩(TQ)", "profile torque (TQ)"),
    (6, "回零(HM)", "homing (HM)"),
    (7, "插补位置(IP)", "interpolated position (IP)"),
    (8, "循环同步位置(CSP)", "cyclic synchronous position (CSP)"),
    (9, "循环同步速度(CSV)", "cyclic synchronous velocity (CSV)"),
    (10, "循环同步转矩(CST)", "cyclic synchronous torque (CST)"),
    (11, "带换相角的循环同步转矩(CSTCA)", "cyclic synchronous torque with commutation angle (CSTCA)"),
];

/// The bits of the statusword.
pub static STATUSWORD: &[Row<u8>] = &[
    (0, "准备接通", "ready to switch on"),
    (1, "已接通", "switched on"),
    (2, "运行使能", "operation enabled"),
    (3, "故障", "fault"),
    (4, "主电源已接入", "voltage enabled"),
    (5, "快速停止(0有效)", "quick stop (active at 0)"),
    (6, "禁止接通", "switch on disabled"),
    (7, "警告", "warning"),
    (8, "制造商定义", "manufacturer-specific"),
    (9, "远程(接受控制字)", "remote (the controlword is obeyed)"),
    (10, "目标到达", "target reached"),
    (11, "内部限制有效", "internal limit active"),
    (12, "由操作模式定义", "operation mode specific"),
    (13, "由操作模式定义", "operation mode specific"),
    (14, "制造商定义", "manufacturer-specific"),
    (15, "制造商定义", "manufacturer-specific"),
];

/// The bits of the controlword.
pub static CONTROLWORD: &[Row<u8>] = &[
    (0, "接通", "switch on"),
    (1, "使能电压", "enable voltage"),
    (2, "快速停止(0有效)", "quick stop (active at 0)"),
    (3, "使能运行", "enable operation"),
    (4, "由操作模式定义", "operation mode specific"),
    (5, "由操作模式定义", "operation mode specific"),
    (6, "由操作模式定义", "operation mode specific"),
    (7, "故障复位(上升沿)", "fault reset (rising edge)"),
    (8, "暂停", "halt"),
    (9, "由操作模式定义", "operation mode specific"),
    (10, "保留", "reserved"),
    (11, "制造商定义", "manufacturer-specific"),
    (12, "制造商定义", "manufacturer-specific"),
    (13, "制造商定义", "manufacturer-specific"),
    (14, "制造商定义", "manufacturer-specific"),
    (15, "制造商定义", "manufacturer-specific"),
];

/// The word for a state.
pub fn state(lang: Lang, state: State) -> &'static str {
    find(STATES, lang, state).unwrap_or_default()
}

/// The word for a command.
pub fn command(lang: Lang, command: Command) -> &'static str {
    find(COMMANDS, lang, command).unwrap_or_default()
}

/// The word for a mode of operation (6060h, 6061h). Every value has one.
pub fn mode(lang: Lang, mode: i8) -> &'static str {
    find(MODES, lang, mode).unwrap_or(match mode {
        ..0 => lang.pick("制造商定义的模式", "manufacturer-specific mode"),
        0.. => lang.pick("保留的模式", "reserved mode"),
    })
}

/// The abbreviation of a mode that the standard defines, the same in every language: `CSP`.
pub fn abbreviation(mode: i8) -> Option<&'static str> {
    find(MODES, Lang::En, mode)?.split_once('(')?.1.strip_suffix(')')
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::text::lang::tests::sound;

    #[test]
    fn complete_and_sorted() {
        sound(STATES);
        sound(COMMANDS);
        sound(MODES);
        sound(STATUSWORD);
        sound(CONTROLWORD);
        assert!(State::ALL.iter().all(|it| !state(Lang::Zh, *it).is_empty()));
        assert_eq!((COMMANDS.len(), STATUSWORD.len(), CONTROLWORD.len()), (8, 16, 16));
    }

    #[test]
    fn words() {
        assert_eq!(state(Lang::Zh, State::OperationEnabled), "运行使能");
        assert_eq!(command(Lang::Zh, Command::EnableOperation), "使能运行");
        assert_eq!(mode(Lang::Zh, 8), "循环同步位置(CSP)");
        assert_eq!(mode(Lang::En, 1), "profile position (PP)");
        assert_eq!(mode(Lang::Zh, -1), "制造商定义的模式");
        assert_eq!(mode(Lang::En, 5), "reserved mode");
        assert_eq!((abbreviation(11), abbreviation(0), abbreviation(5)), (Some("CSTCA"), None, None));
    }
}
