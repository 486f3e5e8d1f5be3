//! The status of a problem at the end of the capture.

use super::ledger::Ledger;
use super::problem::{Cited, Problem, Status};
use super::rank::is_root;
use super::roles::KindRole;
use super::trackers::rules::GOES_ON;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::rules::finding::Code;

/// Time in which a node that is back has to be started again, in ns.
const START_NS: Ns = Ns::from_ms(2_500);
/// Time after which an error that was not cleared counts as open, in ns.
const SETTLED_NS: Ns = Ns::from_ms(500);

/// Leaves a root open as long as one of its consequences is.
pub(super) fn of_chains(ledger: &mut Ledger) {
    let open: Vec<_> =
        ledger.told().filter(|one| !is_root(one) && one.status == Status::Open).map(|one| one.id).collect();
    ledger.all.iter_mut().for_each(|one| one.alone = one.status);
    for place in 0..ledger.all.len() {
        let Some(one) = ledger.get(place).filter(|one| is_root(one) && one.status > Status::Open) else { continue };
        let caused = open.iter().any(|effect| ledger.comes_from(*effect, one.id));
        if let Some(one) = ledger.get_mut(place).filter(|_| caused) {
            one.status = Status::Open;
        }
    }
}

/// Leaves nothing open that single lost frames explain: nothing of it was on the bus.
pub(super) fn of_lost_frames(ledger: &mut Ledger) {
    let lost: Vec<Problem> = ledger.told().filter(|one| one.kind.is(KindRole::LosesFrames)).cloned().collect();
    let explained = |cited: &Cited| {
        let frame = cited.because_of;
        frame.is_some_and(|frame| lost.iter().any(|one| one.holds(frame)))
    };
    let all = |one: &Problem| {
        let whole = !one.findings.is_empty() && one.repeats.count <= one.findings.len() as u64;
        whole && one.cause.is_some() && one.findings.iter().all(explained)
    };
    ledger.all.iter_mut().filter(|one| all(one)).for_each(|one| one.status = Status::Harmless);
}

/// Returns true if a problem has ended and will probably not recur at once.
pub(super) fn is_over(one: &Problem, last: FrameRef) -> bool {
    one.end.is_some() && !one.kind.is(KindRole::TimeTooShort) && !goes_on(one, last)
}

/// Returns true if a problem that keeps recurring is still going on, since its next time is not due yet.
fn goes_on(one: &Problem, end: FrameRef) -> bool {
    let mean = one.repeats.since.since(one.begin).map(|all| all / one.repeats.count.saturating_sub(1).max(1) as i64);
    let comes_again = !one.clue.reported.is_empty() || one.kind.is(KindRole::Recurs);
    let rest = end.since(one.end.unwrap_or(one.repeats.since));
    let soon = mean.zip(rest).is_some_and(|(mean, rest)| rest < mean + mean / 4);
    one.repeats.count >= GOES_ON && comes_again && soon
}

/// Returns the status of a problem at the end. `back`: the frame since which its node is back without being started;
/// `gone`: its node cannot be heard any more; `left_alone`: others have long been Operational while it is not; `idle`:
/// others are Operational and it is not.
pub(super) fn status(
    one: &Problem,
    end: FrameRef,
    (back, gone, left_alone, idle): (Option<FrameRef>, bool, bool, bool),
) -> Status {
    let is = |role: KindRole| one.kind.is(role);
    // A single node that stays stopped, or is not started behind a reset, while others run is not intended.
    if (is(KindRole::Stop) || is(KindRole::Reset)) && one.end.is_none() && left_alone && !one.has("started_again") {
        return Status::Open;
    }
    // It was not switched on yet, or clearing bit 2 of the controlword requested the quick stop.
    let later = is(KindRole::NeverHeard) && one.has("boot_up");
    let wanted = is(KindRole::QuickStop) && one.has("controlword") && one.cause.is_none();
    if one.kind.is_harmless() || later || wanted {
        return Status::Harmless;
    }
    // No frame shows that it has ended. A node in a restart loop that was not started since is probably still in it.
    if is(KindRole::Lasting) || is(KindRole::Loop) && idle {
        return Status::Open;
    }
    // Its node may respond, but not in time or not to this.
    if goes_on(one, end) || one.clue.not_served {
        return Status::Open;
    }
    if one.end.is_some() {
        // It may run again as before, but does not show that while others are Operational.
        return if is(KindRole::Restart) && idle { Status::Unknown } else { Status::Ended };
    }
    if let Some(back) = back {
        return if end.since(back).is_some_and(|since| since < START_NS) { Status::Unknown } else { Status::Open };
    }
    // An error reported at the very end may be cleared soon.
    if !one.clue.reported.is_empty() && end.since(one.repeats.since).is_none_or(|since| since < SETTLED_NS) {
        return Status::Unknown;
    }
    // Not every controller reports that it is active again.
    if is(KindRole::Passive) {
        return Status::Unknown;
    }
    if one.has("client_aborted") || one.clue.unsettled {
        return Status::Unknown;
    }
    // A refused write may still be made up for if the capture ends too soon for the rule.
    if one.has("refused") {
        let stays = one.findings.iter().any(|cited| cited.code == Code::Sdo018);
        return if stays { Status::Open } else { Status::Unknown };
    }
    // A node that restarts and is not heard any more is not well.
    let silent = is(KindRole::Unheard) || is(KindRole::Restart) || is(KindRole::Loop);
    if gone && !silent { Status::Unknown } else { Status::Open }
}
