//! Two nodes with one node-ID, found by alternating states or by two series of heartbeats.
//!
//! A second series shows if the heartbeats of a known period go on in turn and others come evenly between them, or if
//! gaps alternate. Gaps that are all the same are those of one series, however long its period was before. Single
//! additional heartbeats are legal.

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

/// Consecutive gaps that agree.
#[derive(Clone, Copy, Debug, Default)]
struct EvenRun {
    least: Ns,
    most: Ns,
    total: Ns,
    count: usize,
}

impl EvenRun {
    fn add(&mut self, gap: Ns) {
        let (least, most) = (self.least.min(gap), self.most.max(gap));
        *self = if self.count > 0 && most - least <= uneven(most) {
            Self { least, most, total: self.total + gap, count: self.count.saturating_add(1) }
        } else {
            Self { least: gap, most: gap, total: gap, count: 1 }
        };
    }

    /// Returns true if they are many, and last for longer than a period: none comes between, and none of that period.
    fn is_one_series(&self, period: Ns) -> bool {
        self.count >= GAPS && self.total > period + self.most
    }
}

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
    /// The latest gaps, latest last; and those in a row that agree.
    gaps: Vec<Ns>,
    run: EvenRun,
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

    /// Returns true if the heartbeats are certainly those of one node whose period was `period` ns, or should be.
    pub(super) fn is_one_series(&self, period: Ns) -> bool {
        !self.found && self.run.is_one_series(period)
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
        self.run = EvenRun::default();
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
        self.run.add(gap);
        let known = period.expected().filter(|known| known.confidence == Confidence::Certain);
        let Some(known) = known else {
            (self.since_turn, self.since_additional) = (Ns::ZERO, Ns::ZERO);
            self.alternating(node, [period.usual_ns(), None], (last, uncertain), cx);
            return SeriesPlace::InTurn(gap);
        };
        self.alternating(node, [period.usual_ns(), Some(known.ns)], (last, uncertain), cx);
        if self.run.is_one_series(known.ns) {
            (self.since_turn, self.since_additional) = (Ns::ZERO, Ns::ZERO);
            self.additional.clear();
            return SeriesPlace::InTurn(gap);
        }
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

    /// Reports alternating gaps. If two of them are the period as configured, from before a reset, or as learnt (`usual`),
    /// each of two nodes keeps it; otherwise they must differ by more than a slow task explains.
    fn alternating(
        &mut self,
        node: u8,
        usual: [Option<Ns>; 2],
        (last, uncertain): (FrameRef, Ns),
        cx: &mut Context<'_>,
    ) {
        let Some((one, two)) = self.alternate() else { return };
        let (whole, apart) = (one + two, (one - two).abs());
        let room = ((whole / 32) + uncertain).abs();
        let kept = usual.into_iter().flatten().any(|usual| whole.abs_diff(usual) <= room);
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

/// Returns true if gaps differ by no more than those of one series.
fn even<'a>(gaps: impl Iterator<Item = &'a Ns> + Clone) -> bool {
    let most = gaps.clone().max().copied().unwrap_or(Ns::ZERO);
    spread(gaps) <= uneven(most)
}

/// Returns the maximum difference of the gaps of one series whose longest is `most`: an eighth, or 4 ms.
fn uneven(most: Ns) -> Ns {
    (most / 8).max(Ns(4_000_000))
}

/// Returns the difference between the longest and the shortest gap.
fn spread<'a>(gaps: impl Iterator<Item = &'a Ns> + Clone) -> Ns {
    let least = gaps.clone().min().copied().unwrap_or(Ns::ZERO);
    gaps.max().copied().unwrap_or(Ns::ZERO) - least
}
