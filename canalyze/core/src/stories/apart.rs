//! Facts that distinguish the possible causes of an incident.
//!
//! Each line is a fact of this capture, or a question that it leaves open, with the way to answer it.

use super::advice::AdviceFacts;
use super::causes::within;
use super::incident::{Grade, Incident};
use super::kinds::IncidentKind;
use super::ledger::Ledger;
use crate::rules::Words;

/// Maximum distance of losses that belong together, in ns.
const TOGETHER_NS: i64 = 100_000_000;
/// Maximum time before an incident within which an earlier one belongs to it, in ns.
const BEFORE_NS: i64 = 2_000_000_000;
/// Maximum distance of error frames around an incident, in ns.
const AROUND_NS: i64 = 1_000_000_000;

/// One line.
#[derive(Clone, Copy, Debug)]
pub struct Tell {
    /// True for a fact of the capture, false for an open question.
    pub told: bool,
    /// The text for people.
    pub words: Words,
}

macro_rules! tells {
    ($($(#[$doc:meta])* $name:ident $told:literal $zh:literal $en:literal;)*) => {
        $(const $name: Tell = Tell { told: $told, words: Words { zh: $zh, en: $en } };)*
    };
}

tells! {
    BOOTED true "恢复时有启动报文: 断过电或自行复位, 不只是电缆松动"
        "it came back with a boot-up: it lost power or reset itself, not a loose cable alone";
    RETURNED true "恢复时没有启动报文: 一直有电, 仅连接中断"
        "it came back without a boot-up: it kept its power, only the connection was lost";
    AWAY false "没有恢复: 无法区分断电与断线; 可看指示灯, 或看恢复时有无启动报文"
        "it has not come back: power loss or broken connection cannot be distinguished; check its LEDs, or whether it comes back with a boot-up";
    NEVER_HEARD false "从未收到其报文: 无法区分不存在、未上电还是节点ID不同; 用 canalyze summary 查看有哪些节点"
        "never seen: absent, unpowered or another node-ID cannot be distinguished; use canalyze summary to list the nodes";
    ALONE true "没有其他节点同时失去联系: 不是主干电缆, 也不是公共电源"
        "no other node went silent at the same time: neither the trunk cable nor a shared supply";
    WITH_OTHERS true "其他节点同时失去联系: 公共的电缆段、接插件或电源"
        "other nodes went silent at the same time: a shared cable segment, connector or supply";
    WARNED true "此前不久报告过错误(EMCY): 原因可能在设备自身"
        "it reported an error (EMCY) shortly before: the device itself may be the cause";
    NO_WARNING true "此前没有报告错误(EMCY)"
        "it reported no error (EMCY) before";
    NOISE true "前后有错误帧: 接线、终端电阻、屏蔽"
        "error frames nearby: wiring, termination, shield";
    QUIET true "前后没有错误帧, 而记录中其他位置有: 接线不太可能是原因"
        "no error frames nearby, but elsewhere in the capture: wiring is unlikely";
    NO_ERROR_FRAMES false "记录中没有错误帧: 无法判断接线和干扰; 打开错误帧后重新记录: ip link set can0 type can berr-reporting on"
        "no error frames in the capture: wiring and noise cannot be judged; enable them and record again: ip link set can0 type can berr-reporting on";
    GOES_ON true "仍在发送其他报文: 不是电缆或电源, 而是固件或1017h"
        "it still sends other frames: not the cable or supply, but its firmware or 1017h";
    NAMED true "以EMCY报告了错误码: 含义见设备手册"
        "it reported an error code by EMCY: see the device manual";
    UNNAMED false "没有EMCY: 错误码未知; 请读603Fh和1003h"
        "no EMCY: the error code is unknown; read 603Fh and 1003h";
    AXES true "几个轴同时发生: 共同的原因(STO、急停、供电)"
        "several axes at the same time: a common cause (STO, emergency stop, supply)";
    ONE_AXIS true "其他轴没有同时发生: 多为该轴自身"
        "no other axis at the same time: probably this axis itself";
    COMMUNICATION true "此前通信已中断: 是对通信中断的反应, 不是电机"
        "communication was lost before: this is the reaction to it, not the motor";
    NO_LOSS true "此前没有节点、SYNC或PDO中断"
        "no node, SYNC or PDO was lost before it";
    LIMIT_KNOWN true "记录中可见1016h的时限, 与延迟相符"
        "the limit in 1016h is in the capture and fits the delay";
    LIMIT_DIFFERS true "记录中可见1016h的时限, 但与延迟不符"
        "the limit in 1016h is in the capture but does not fit the delay";
    LIMIT_UNKNOWN false "1016h的时限未知: 读1016h, 或用 --eds 给出设备描述"
        "the limit in 1016h is unknown: read 1016h, or give a description with --eds";
    PRESENT true "这段时间节点没有失去联系: 从站忙, 或请求不对"
        "the node was not silent meanwhile: its SDO server is busy, or the request is wrong";
    GONE true "当时节点已失去联系"
        "the node was silent then";
    MADE_GOOD true "之后写入成功: 设备支持, 只是当时的顺序或状态不对"
        "written successfully later: supported by the device, but the order or its state was wrong";
    OTHER_VALUES true "之后写入其他值成功: 被拒绝的值不合适, 见中止码"
        "other values were accepted later: the refused values were wrong, see the abort codes";
    NOT_MADE_GOOD false "之后未写入成功: 无法区分不支持还是状态不对; 请在预操作状态下重试"
        "never written successfully: not supported or wrong state cannot be distinguished; try again in Pre-operational";
}

/// Returns the facts for an incident; none for other kinds.
pub fn of(one: &Incident, ledger: &Ledger, shown: AdviceFacts) -> Vec<Tell> {
    use IncidentKind::{
        AxisFault, DeviceError, GuardingUnanswered, HeartbeatConsumerError, HeartbeatStopped, LateAnswer, NoBootUp,
        NodeAbsent, NodeRestarted, NodeSilent, QuickStop, RequestUnanswered, RestartLoop, SegmentLost, StateLeft,
        SupplyVoltage, Temperature,
    };
    match one.kind {
        NodeSilent | SegmentLost | NodeRestarted | RestartLoop | GuardingUnanswered | NoBootUp => {
            vec![back(one), others(one, ledger), warned(one, ledger), noise(one, ledger, shown)]
        }
        NodeAbsent => vec![if one.end.is_some() { back(one) } else { NEVER_HEARD }, noise(one, ledger, shown)],
        HeartbeatStopped => vec![GOES_ON, warned(one, ledger)],
        AxisFault | QuickStop | StateLeft | DeviceError | SupplyVoltage | Temperature => {
            let mut tells = vec![if one.clue.reported.is_empty() { UNNAMED } else { NAMED }];
            let lost = lost(one, ledger);
            // Reactions to one loss come together and need have nothing else in common.
            let reacts = lost.is_some_and(|tell| tell.words.en == COMMUNICATION.words.en);
            if !reacts && (one.subject.axis.is_some() || one.subject.axes != 0) {
                let many = one.subject.axes.count_ones() > 1 || one.subject.nodes.count_ones() > 1;
                tells.push(if many { AXES } else { ONE_AXIS });
            }
            tells.extend(lost);
            tells
        }
        HeartbeatConsumerError => match one.cause.and_then(|link| ledger.by_id(link.cause)) {
            Some(cause) => vec![limit(one, cause)],
            None => Vec::new(),
        },
        RequestUnanswered | LateAnswer => presence(one, ledger).into_iter().collect(),
        _ if one.has("refused") => vec![match one.end.filter(|_| !one.has("booted")) {
            Some(_) if one.has("others") => OTHER_VALUES,
            Some(_) => MADE_GOOD,
            None => NOT_MADE_GOOD,
        }],
        _ => Vec::new(),
    }
}

fn back(one: &Incident) -> Tell {
    match (one.has("boot_up") || matches!(one.kind, IncidentKind::NodeRestarted | IncidentKind::RestartLoop), one.end) {
        (true, _) => BOOTED,
        (false, Some(_)) => RETURNED,
        (false, None) => AWAY,
    }
}

/// Returns the line on the time that a consumer waits, compared with the time that passed.
fn limit(one: &Incident, cause: &Incident) -> Tell {
    let delay = one.cause.and_then(|link| link.delay_ns);
    match one.limit(cause).zip(delay) {
        Some(((_, limit), delay)) if within(cause, limit).contains(&delay) => LIMIT_KNOWN,
        Some(_) => LIMIT_DIFFERS,
        None => LIMIT_UNKNOWN,
    }
}

/// Returns the line on other nodes lost with it.
fn others(one: &Incident, ledger: &Ledger) -> Tell {
    let with = |other: &Incident| {
        let silent =
            matches!(other.kind, IncidentKind::NodeSilent | IncidentKind::SegmentLost | IncidentKind::NodeRestarted);
        silent
            && other.id != one.id
            && other.subject.nodes & !one.subject.nodes != 0
            && is_near(one, other, TOGETHER_NS)
    };
    if one.subject.nodes.count_ones() > 1 || ledger.told().any(with) { WITH_OTHERS } else { ALONE }
}

/// Returns the line on errors reported by the node before.
fn warned(one: &Incident, ledger: &Ledger) -> Tell {
    let reported = |other: &Incident| {
        let before = one.begin.since(other.begin).is_some_and(|since| (0..=BEFORE_NS).contains(&since));
        other.id != one.id && other.subject.nodes & one.subject.nodes != 0 && !other.clue.reported.is_empty() && before
    };
    if ledger.told().any(reported) { WARNED } else { NO_WARNING }
}

fn noise(one: &Incident, ledger: &Ledger, shown: AdviceFacts) -> Tell {
    let around = |other: &Incident| {
        let errors = matches!(
            other.kind,
            IncidentKind::BusOff
                | IncidentKind::ErrorPassive
                | IncidentKind::BusErrors
                | IncidentKind::NotAcknowledged
                | IncidentKind::TransceiverFault
        );
        errors && is_near(one, other, AROUND_NS)
    };
    match (ledger.told().any(around), shown.error_frames) {
        (true, _) => NOISE,
        (false, true) => QUIET,
        (false, false) => NO_ERROR_FRAMES,
    }
}

fn is_near(one: &Incident, other: &Incident, ns: i64) -> bool {
    one.bus == other.bus && one.begin.since(other.begin).is_some_and(|since| since.saturating_abs() <= ns)
}

/// Returns the line on a loss of communication before it; `None` if that may be chance.
fn lost(one: &Incident, ledger: &Ledger) -> Option<Tell> {
    let before = |other: &Incident| {
        let since = one.begin.since(other.begin);
        other.id != one.id && is_loss(other.kind) && since.is_none_or(|since| (0..=BEFORE_NS).contains(&since))
    };
    if cause(one, ledger).is_some_and(|cause| is_loss(cause.kind)) {
        return Some(COMMUNICATION);
    }
    (!ledger.told().any(before)).then_some(NO_LOSS)
}

/// Returns the line on the presence of the node; `None` if it was silent at another time.
fn presence(one: &Incident, ledger: &Ledger) -> Option<Tell> {
    let silent = |other: &Incident| is_loss(other.kind) && other.subject.nodes & one.subject.nodes != 0;
    if cause(one, ledger).is_some_and(silent) {
        return Some(GONE);
    }
    (!ledger.told().any(silent)).then_some(PRESENT)
}

/// Returns its cause, if that is more than possible.
fn cause<'a>(one: &Incident, ledger: &'a Ledger) -> Option<&'a Incident> {
    ledger.by_id(one.cause.filter(|link| link.grade >= Grade::Likely)?.cause)
}

/// Returns true if a kind means a loss of communication.
fn is_loss(kind: IncidentKind) -> bool {
    use IncidentKind::{
        CommandedReset, CommandedStop, CommunicationError, GuardingStopped, HeartbeatConsumerError, HeartbeatStopped,
        NodeAbsent, NodeRestarted, NodeSilent, PdoMissing, RestartLoop, RpdoTimeout, SegmentLost, SyncStopped,
    };
    matches!(
        kind,
        CommandedReset
            | CommandedStop
            | CommunicationError
            | GuardingStopped
            | HeartbeatConsumerError
            | HeartbeatStopped
            | NodeAbsent
            | NodeRestarted
            | NodeSilent
            | PdoMissing
            | RestartLoop
            | RpdoTimeout
            | SegmentLost
            | SyncStopped
    )
}
