//! Two nodes with one node-ID, found by alternating states or by two series of heartbeats.
//!
//! A second series shows if the heartbeats of a known period go on in turn and others come evenly between them, or,
//! with no known period, if gaps alternate. Single additional heartbeats are legal.

use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::evidence::Period;
use crate::evidence::circumstance::CircumstanceKind;
use crate::evidence::period::Confidence;
use crate::rules::finding::Code;
use crate::rules::heartbeat::Hbt004;
use crate::world::context::Context;

/// Number of gaps between heartbeats that are kept.
const GAPS: usize = 8;
/// Number of evenly spaced additional heartbeats that make a second series.
const ADDITIONAL: usize = 5;
/// Number of consecutive changes, each back to the state before, that show two nodes.
const ALTERNATIONS: u8 = 4;
/// Minimum difference of alternating gaps, in ns; the stamps of a loaded host vary by less.
const APART_NS: Ns = Ns::from_ms(10);

/// The place of a heartbeat in its series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SeriesPlace {
    /// In turn, with the time since the one before in the series, in ns.
    InTurn(Ns),
    /// Between two heartbeats of the series.
    Additional,
}

/// The evidence of a second node in a node's heartbeats.
#[derive(Debug, Default)]
pub(super) struct DuplicateId {
    found: bool,
    alternations: u8,
    before: Option<u8>,
    /// The latest gaps, latest last.
    gaps: Vec<Ns>,
    /// Time since the last heartbeat in turn, in ns.
    since_turn: Ns,
    /// Time since the last additional heartbeat, in ns, and the gaps between those so far.
    since_additional: Ns,
    additional: Vec<Ns>,
}

impl DuplicateId {
    /// Returns true if two nodes were reported.
    pub(super) fn is_found(&self) -> bool {
        self.found
    }

    /// Takes a command, after which a change of state is no evidence.
    pub(super) fn commanded(&mut self) {
        self.alternations = 0;
    }

    /// Takes the state of a heartbeat: two nodes with one node-ID show theirs in turns.
    pub(super) fn state(
        &mut self,
        node: u8,
        changed: bool,
        (before, state): (Option<u8>, u8),
        last: FrameRef,
        cx: &mut Context<'_>,
    ) {
        let back = changed && self.before.is_none_or(|earlier| earlier == state);
        self.alternations = if back { self.alternations.saturating_add(1) } else { 0 };
        if changed {
            self.before = before;
        }
        if self.alternations >= ALTERNATIONS {
            self.find(node, Hbt004::States { one: before.unwrap_or(0), other: state }, last, cx);
        }
    }

    /// Restarts both series after a gap that shows nothing.
    pub(super) fn interrupt(&mut self) {
        (self.since_turn, self.since_additional) = (Ns::ZERO, Ns::ZERO);
        self.gaps.clear();
        self.additional.clear();
    }

    /// Takes a gap between two heartbeats in the same state. `uncertain`: maximum error of stamps, in ns.
    pub(super) fn gap(
        &mut self,
        node: u8,
        gap: Ns,
        last: FrameRef,
        period: &Period,
        uncertain: Ns,
        cx: &mut Context<'_>,
    ) -> SeriesPlace {
        if self.gaps.len() == GAPS {
            self.gaps.remove(0);
        }
        self.gaps.push(gap.min(Ns::MAX / 1024));
        let known = period.expected().filter(|known| known.confidence == Confidence::Certain);
        let Some(known) = known else {
            (self.since_turn, self.since_additional) = (Ns::ZERO, Ns::ZERO);
            self.alternating(node, period.usual_ns(), (last, uncertain), cx);
            return SeriesPlace::InTurn(gap);
        };
        let configured =
            period.configured_ns().filter(|configured| (*configured / 5 * 2..=*configured / 5 * 3).contains(&known.ns));
        if let Some(configured) = configured {
            self.find(node, Hbt004::HalfPeriod { found: known.ns, expected: configured }, last, cx);
        }
        self.alternating(node, period.usual_ns(), (last, uncertain), cx);
        let room = (known.ns / 16).max(known.deviation_ns * 2).max(2 * uncertain).min(known.ns / 4);
        let turn = self.since_turn + gap;
        self.since_additional += gap;
        if turn >= known.ns - room {
            self.since_turn = Ns::ZERO;
            if turn <= known.ns + room {
                return SeriesPlace::InTurn(turn);
            }
            // The series itself has changed or is interrupted.
            (self.since_additional, self.additional) = (Ns::ZERO, Vec::new());
            return SeriesPlace::InTurn(gap);
        }
        self.since_turn = turn;
        self.additional.push(std::mem::take(&mut self.since_additional));
        self.series(node, known.ns, last, cx);
        SeriesPlace::Additional
    }

    /// Reports heartbeats that come twice as often as before without a change of their period.
    pub(super) fn halved(&mut self, node: u8, period: Ns, last: FrameRef, cx: &mut Context<'_>) {
        self.find(node, Hbt004::Series { one: period, other: period }, last, cx);
    }

    /// Reports additional heartbeats that form a series. The time to the first of them does not count.
    fn series(&mut self, node: u8, period: Ns, last: FrameRef, cx: &mut Context<'_>) {
        if self.additional.len() < ADDITIONAL {
            return;
        }
        let recent = self.additional.iter().rev().take(ADDITIONAL - 1);
        if !even(recent.clone()) {
            self.additional.remove(0);
            return;
        }
        let other = recent.sum::<Ns>() / (ADDITIONAL as i64 - 1);
        if !self.gaps.iter().any(|gap| *gap < other / 4 * 3) {
            // One stream, which is faster: no heartbeat comes between.
            return;
        }
        self.find(node, Hbt004::Series { one: period, other }, last, cx);
    }

    /// Returns the means of every other gap and of the others, once there are enough and both are steady, in ns.
    fn alternate(&self) -> Option<(Ns, Ns)> {
        let odd = || self.gaps.iter().step_by(2);
        let other = || self.gaps.iter().skip(1).step_by(2);
        let half = (GAPS / 2) as i64;
        let (one, two) = (odd().sum::<Ns>() / half, other().sum::<Ns>() / half);
        let steady = spread(odd()).max(spread(other())) <= ((one + two) / 40).max(Ns(2_000_000));
        (self.gaps.len() == GAPS && steady).then_some((one, two))
    }

    /// Reports alternating gaps. If two of them are the period from a configuration or from before a reset (`usual`),
    /// each of two nodes keeps it; otherwise they must differ by more than a slow task explains.
    fn alternating(&mut self, node: u8, usual: Option<Ns>, (last, uncertain): (FrameRef, Ns), cx: &mut Context<'_>) {
        let Some((one, two)) = self.alternate() else { return };
        let (whole, apart) = (one + two, (one - two).abs());
        let room = ((whole / 32) + uncertain).abs();
        let kept = usual.is_some_and(|usual| whole.abs_diff(usual) <= room);
        if apart > APART_NS && (kept || apart > whole / 4) {
            self.find(node, Hbt004::Gaps { one, other: two }, last, cx);
        }
    }

    fn find(&mut self, node: u8, what: Hbt004, last: FrameRef, cx: &mut Context<'_>) {
        if !std::mem::replace(&mut self.found, true) {
            cx.evidence.circumstances.note(CircumstanceKind::SharedId, Some(node), cx.when);
            cx.evidence
                .pending
                .explain(cx.at, |one| one.node == Some(node) && matches!(one.code, Code::Nmt004 | Code::Hbt001));
            cx.report_timed(cx.verdict(what, Some(node), None, Some(last)));
        }
    }
}

/// Returns true if gaps differ by no more than an eighth, or 4 ms.
fn even<'a>(gaps: impl Iterator<Item = &'a Ns> + Clone) -> bool {
    let most = gaps.clone().max().copied().unwrap_or(Ns::ZERO);
    spread(gaps) <= (most / 8).max(Ns(4_000_000))
}

/// Returns the difference between the longest and the shortest gap.
fn spread<'a>(gaps: impl Iterator<Item = &'a Ns> + Clone) -> Ns {
    let least = gaps.clone().min().copied().unwrap_or(Ns::ZERO);
    gaps.max().copied().unwrap_or(Ns::ZERO) - least
}
