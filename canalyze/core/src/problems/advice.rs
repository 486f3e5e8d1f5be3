//! The first things to check: the first list in the row of the kind whose condition holds.

use super::problem::{Grade, Problem, Status};
use super::roles::KindRole;
use super::sayings::{self as say, Check};
use super::signs::When;
use crate::checks::pdo::configuration::pdo_parameter;
use crate::rules::finding::{Code, Quantity};
use crate::sdo::abort_code::AbortCode;
use crate::world::drive::{self, DriveState};

/// The facts of the whole capture that advice depends on.
#[derive(Clone, Copy, Debug, Default)]
pub struct AdviceFacts {
    /// True if it has error frames.
    pub error_frames: bool,
    /// Number of nodes seen.
    pub nodes: u32,
}

/// Emergency error codes of too high a voltage, without their last digit (CiA 402-2: mains, DC link).
const OVER: [u16; 2] = [0x3110, 0x3210];
/// Bit of the statusword: voltage enabled (CiA 402-2).
const VOLTAGE: u16 = 1 << 4;

/// Returns true if all conditions hold. `timed`: the time of its beginning is known.
pub(super) fn hold(conditions: &[When], one: &Problem, timed: bool) -> bool {
    conditions.iter().all(|when| holds(*when, one, timed))
}

fn holds(when: When, one: &Problem, timed: bool) -> bool {
    let aborted = |such: fn(AbortCode) -> bool| matches!(one.get("abort"), Some(Quantity::Abort(code)) if such(code));
    match when {
        When::Has(name) => one.has(name),
        When::Controller => one.clue.controller && one.end.is_none(),
        When::Ended => one.end.is_some(),
        When::Open => one.end.is_none(),
        When::Over => one.status == Status::Ended,
        When::Back => one.is_back(),
        When::Once => one.repeats.count == 1,
        When::AtOnce => one.end.is_some_and(|end| end.no <= one.noticed.no),
        When::Often => one.repeats.count > 1,
        When::Single => one.subject.nodes.count_ones() < 2,
        When::Several => one.subject.nodes.count_ones() > 1,
        When::Reported => !one.clue.reported.is_empty(),
        When::Timed => timed,
        When::Untimed => !timed,
        When::Hardware => aborted(|code| code.meaning() == 0x0606_0000),
        When::ToStopped => one.findings.first().is_some_and(|cited| cited.code == Code::Sdo011),
        When::Fixed => aborted(|code| (0x0601_0000..=0x0601_00FF).contains(&code.meaning())),
        When::NotMappable => aborted(|code| code.meaning() == 0x0604_0041),
        When::TooLong => aborted(|code| code.meaning() == 0x0604_0042),
        When::WrongState => aborted(|code| (0x0800_0020..=0x0800_0022).contains(&code.meaning())),
        When::TimedOut => aborted(AbortCode::is_timeout),
        When::Violation => aborted(AbortCode::is_violation),
        When::Busy => aborted(AbortCode::is_busy),
        When::NoPdoParameter => one.object().is_none_or(|mux| pdo_parameter(mux.index).is_none()),
        When::NotOperational => one.findings.iter().any(|cited| cited.code == Code::Pdo002),
        When::OfPdo => one.subject.pdo.is_some(),
        When::UnannouncedAxes => one.clue.reported.is_empty() && one.subject.axes.count_ones() > 1,
        When::Overvoltage => one.clue.reported.iter().any(|code| OVER.contains(&(code & 0xFFF0))),
        When::VoltageEnabled => statusword(one).is_some_and(|word| word & VOLTAGE != 0),
        When::OperatedLocally => statusword(one).is_some_and(|word| !drive::remote(word)),
        When::StaysEnabled => {
            statusword(one).is_some_and(|word| DriveState::of(word) == Some(DriveState::OperationEnabled))
        }
    }
}

fn statusword(one: &Problem) -> Option<u16> {
    if let Some(Quantity::Statusword(word)) = one.get("statusword") { Some(word) } else { None }
}

/// Returns the things to check, the first one first.
pub fn of(one: &Problem, shown: AdviceFacts) -> Vec<Check> {
    if one.status == Status::Harmless {
        return vec![if one.kind.is(KindRole::Gap) { say::RECORDER } else { say::NOTHING }];
    }
    if one.cause.is_some_and(|link| link.grade >= Grade::Likely) {
        let mut checks = vec![say::CAUSE];
        if one.has("left_operational") {
            checks.push(say::ERROR_BEHAVIOUR);
        }
        return checks;
    }
    let fits = |(when, _): &&(&[When], &'static [Check])| hold(when, one, true);
    let checks = one.kind.row().checks.iter().find(fits).map_or(&[][..], |(_, checks)| *checks);
    let shown =
        |check: &Check| if *check == say::ERROR_FRAMES_OFF && shown.error_frames { say::WIRING } else { *check };
    checks.iter().map(shown).collect()
}
