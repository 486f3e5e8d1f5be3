//! Frames that the recording lost one by one, and the findings that such a loss explains.
//!
//! A lost frame leaves a gap of several periods at a sender with even gaps, which then comes in its phase. A node that
//! skips a frame does the same, so that one sender shows nothing. A recording that loses frames is shown by several
//! nodes that miss frames at different times, and by a SYNC that is missing although PDOs answered it. A step that is
//! missing from an SDO transfer that goes on shows it as well. From then on, a finding that needs no more losses than
//! are likely at that rate is a consequence.

use std::collections::BTreeMap;

use crate::bytes::frame::{Frame, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Code, Finding};

use super::duplicates::PATIENCE_NS;
use super::senders::{Missed, identifier, is_sent_by_time};

/// Maximum number of frames that wait until it is known if the recording loses frames.
const KEPT: u64 = 16_384;
/// CAN-IDs of SDO.
const SDO: std::ops::RangeInclusive<usize> = 0x580..=0x67F;
/// Number of losses at different times, and of nodes with such, that show it; and number of losses if one was certainly
/// sent: a SYNC that was answered or counted, or a step of a transfer that goes on.
const TIMES: u32 = 3;
const NODES: u32 = 2;
const PROVEN: u32 = 2;
/// Number of missing frames from which a share is known well enough not to wait for further ones.
const ENOUGH: u64 = 8;
/// Least expected number of runs of so many losses in a row that are likely, as a part of one.
const LIKELY: f64 = 1.0 / 32.0;
/// Number of findings about one node that are explained, and the multiple of the estimated losses added to it. A lost
/// frame is seen by two rules at most.
const FEW: u64 = 4;
const RULES: u64 = 2;
/// The distance from the last sign at which the recording is taken to lose frames no longer, in multiples of the mean
/// distance of signs, and at least in frames.
const FAR: u64 = 8;
const NEAR: u64 = 2_048;

/// The number of losses in a row that explain a finding.
#[derive(Clone, Copy, Debug)]
enum Needs {
    /// One.
    One,
    /// As many as a fact says.
    Fact(&'static str),
    /// As many as one fact is a multiple of another, without the last.
    Multiple(&'static str, &'static str),
    /// The difference of two facts.
    Difference(&'static str, &'static str),
}

/// The findings that lost frames explain.
const EXPLAINED: &[(Code, Needs)] = &[
    (Code::Hbt001, Needs::Multiple("found", "expected")),
    (Code::Grd001, Needs::One),
    (Code::Grd002, Needs::One),
    (Code::Nmt003, Needs::One),
    (Code::Nmt004, Needs::One),
    (Code::Nmt006, Needs::One),
    (Code::Syn002, Needs::Difference("found", "expected")),
    (Code::Syn003, Needs::Fact("missing")),
    (Code::Syn008, Needs::Fact("count")),
    (Code::Syn009, Needs::One),
    (Code::Syn010, Needs::One),
    (Code::Pdo005, Needs::Multiple("found", "limit")),
    (Code::Srd003, Needs::One),
    (Code::Srd002, Needs::One),
    (Code::Srd004, Needs::One),
    (Code::Sdo001, Needs::One),
    (Code::Sdo003, Needs::One),
    (Code::Sdo006, Needs::One),
    (Code::Sdo007, Needs::One),
    (Code::Sdo008, Needs::One),
    (Code::Sdo012, Needs::One),
    (Code::Sdo015, Needs::One),
    (Code::Sdo019, Needs::One),
    (Code::Sdo024, Needs::One),
    (Code::Sdo026, Needs::One),
    (Code::Lss002, Needs::One),
    (Code::Lss003, Needs::One),
    (Code::Lss009, Needs::One),
    (Code::Drv001, Needs::One),
];

/// The signs since the first one.
#[derive(Clone, Debug, Default)]
struct Signs {
    /// Number of the frame behind the first missing one, and of that behind the last.
    first: u64,
    last: u64,
    /// Number of times at which frames were missing, of missing frames, and of those that were certainly sent.
    times: u32,
    missing: u64,
    sent: u32,
    /// Nodes with missing frames, one bit each; bit 0: the producer of SYNC.
    nodes: u128,
    /// Number of frames that came when they were due.
    came: u64,
    /// The time of the last missing frame, in ns, and half the period of its sender.
    at_ns: Ns,
    near_ns: Ns,
}

impl Signs {
    fn take(&mut self, number: u64, missed: Missed) {
        let Missed { node, frames, at_ns, period_ns, answered } = missed;
        let apart_ns = (at_ns - self.at_ns).abs();
        // Frames that are missing at one time have one cause.
        let same = self.times > 0 && apart_ns <= self.near_ns.min(period_ns / 2);
        if self.times == 0 {
            self.first = number;
        }
        (self.at_ns, self.near_ns, self.last) = (at_ns, period_ns / 2, number);
        self.times += u32::from(!same);
        self.missing += u64::from(frames);
        self.sent += u32::from(answered && !same);
        self.nodes |= 1 << (node & 0x7F);
    }

    fn show(&self) -> bool {
        let proofs = self.sent > 0 && self.times >= PROVEN;
        proofs || self.times >= TIMES && self.nodes.count_ones() >= NODES
    }

    /// Returns the share of missing frames.
    fn share(&self) -> f64 {
        self.missing as f64 / (self.missing + self.came).max(1) as f64
    }
}

/// The frames that the recording of a bus lost one by one.
#[derive(Debug, Default)]
pub(super) struct Losses {
    signs: Signs,
    /// The first frame that waits until the signs show something.
    open: Option<FrameRef>,
    /// The first frame with a sign that was judged after they showed it.
    shown: Option<FrameRef>,
    /// The frame at which an SDO transfer first lacked a step.
    step: Option<FrameRef>,
    /// Number of explained findings by node.
    explained: BTreeMap<Option<u8>, u64>,
}

impl Losses {
    /// Follows a frame that was observed. `missed`: frames of its sender that are missing before it.
    #[inline]
    pub(super) fn follow(&mut self, frame: &Frame, missed: Option<Box<Missed>>) {
        if missed.is_some() || self.signs.times > 0 {
            self.weigh(frame, missed);
        }
    }

    fn weigh(&mut self, frame: &Frame, missed: Option<Box<Missed>>) {
        if self.shown.is_none() && self.signs.times > 0 && frame.no > self.signs.first.saturating_add(KEPT) {
            (self.signs, self.open) = (Signs::default(), None);
        }
        if let Some(missed) = missed {
            self.signs.take(frame.no, *missed);
            if self.shown.is_none() {
                self.open.get_or_insert(frame.reference());
            }
        }
        self.signs.came += u64::from(identifier(frame).is_some_and(|id| is_sent_by_time(id) || SDO.contains(&id)));
        if self.open.is_some() && self.signs.missing >= ENOUGH {
            self.decide();
        }
    }

    /// Decides by the signs so far, if they show something.
    fn decide(&mut self) {
        if self.signs.show() {
            self.shown = self.shown.or(self.open.take());
        }
    }

    /// Decides by the signs so far, since no further frames follow.
    pub(super) fn settle(&mut self) {
        self.decide();
        self.open = None;
    }

    /// Advances a live bus to `now_ns`; later frames are awaited only for a short time.
    pub(super) fn advance(&mut self, now_ns: Ns) {
        if self.open.and_then(|open| open.t_ns).is_some_and(|open| now_ns - open > PATIENCE_NS) {
            self.settle();
        }
    }

    /// Returns the number of the first frame that waits.
    #[inline]
    pub(super) fn undecided_since(&self) -> Option<u64> {
        self.open.map(|open| open.no)
    }

    /// Returns the number of missing frames and of those that were due, if a frame is the first by which that is shown.
    pub(super) fn shown_at(&self, number: u64) -> Option<(u64, u64)> {
        let shown = self.shown.is_some_and(|shown| shown.no == number);
        shown.then_some((self.signs.missing, self.signs.missing + self.signs.came))
    }

    /// Records that a step of an SDO exchange may be missing, which a finding is about; `sent`: it was certainly sent.
    /// Returns the frame from which the finding follows, if lost frames explain it.
    pub(super) fn lacks_step(&mut self, finding: &Finding, sent: bool) -> Option<FrameRef> {
        let (step, signs) = (*self.step.get_or_insert(finding.at), &mut self.signs);
        if signs.times == 0 {
            signs.first = finding.at.no;
        }
        (signs.times, signs.missing, signs.sent) = (signs.times + 1, signs.missing + 1, signs.sent + u32::from(sent));
        signs.nodes |= finding.node.map_or(0, |node| 1 << (node & 0x7F));
        signs.last = signs.last.max(finding.at.no);
        if signs.show() {
            self.shown.get_or_insert(step);
        }
        self.explain_by(finding, Needs::One)
    }

    /// Returns the frame from which a finding follows, if lost frames explain it.
    pub(super) fn explain(&mut self, finding: &Finding) -> Option<FrameRef> {
        if finding.because_of.is_some() {
            return None;
        }
        let (_, needs) = EXPLAINED.iter().find(|(code, _)| *code == finding.code)?;
        if finding.code == Code::Sdo024 { self.lacks_step(finding, true) } else { self.explain_by(finding, *needs) }
    }

    fn explain_by(&mut self, finding: &Finding, needs: Needs) -> Option<FrameRef> {
        let shown = self.shown.filter(|shown| shown.no <= finding.at.no)?;
        if self.step.is_some_and(|step| step.no == shown.no && step.no == finding.at.no) {
            return None;
        }
        let Signs { first, last, times, missing, came, .. } = self.signs;
        let apart = last.saturating_sub(first) / u64::from(times).max(1);
        let near = finding.at.no <= last.saturating_add(apart.saturating_mul(FAR).max(NEAR));
        let lost = (self.signs.share() * finding.at.no.saturating_sub(first) as f64) as u64;
        let explained = self.explained.entry(finding.node).or_default();
        if !near || *explained >= FEW + RULES * lost {
            return None;
        }
        let in_row = needs.losses(finding)?;
        let expected = self.signs.share().powi(in_row) * (missing + came) as f64;
        if expected < LIKELY {
            return None;
        }
        *explained += 1;
        Some(shown)
    }
}

impl Needs {
    /// Returns the number of losses in a row.
    fn losses(self, finding: &Finding) -> Option<i32> {
        let measured = finding.measured();
        let fact = |name: &str| measured?.spoken(name);
        let losses = match self {
            Self::One => 1,
            Self::Fact(name) => fact(name)?,
            Self::Multiple(found, of) => (fact(found)? + fact(of)? / 2) / fact(of)?.max(1) - 1,
            Self::Difference(found, expected) => (fact(found)? - fact(expected)?).max(1),
        };
        i32::try_from(losses.max(1)).ok()
    }
}
