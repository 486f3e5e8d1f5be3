//! SDO transfers that must occur, alone or in order, and those that must not.
//!
//! A missing transfer is reported at the end, together with the transfer that came instead, if there was one that no
//! other expectation requires. The frames of a transfer do not matter here.

use serde::Deserialize;

use super::value::{ExpectedValue, Same, found};
use super::{Breach, Closing, EntryPlace, Scene, check_node, check_times, mistake};
use crate::bytes::frame::{BusId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::expectation::{Exp001, Exp002, Exp003, Exp004, Exp015};
use crate::rules::finding::{Quantity, Said};
use crate::sdo::abort_code::AbortCode;
use crate::sdo::transfer::{Direction, Status, Transfer};
use crate::sdo::wire::Mux;

/// The direction of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Way {
    Upload,
    Download,
}

/// The required outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Outcome {
    Ok,
    Aborted,
    Any,
}

/// An expectation in the form of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SdoEntry {
    line: u32,
    bus: Option<String>,
    node: u8,
    index: u16,
    sub: u8,
    direction: Option<Way>,
    value: Option<ExpectedValue>,
    outcome: Option<Outcome>,
    abort: Option<u32>,
    sequence: Option<String>,
    count: Option<u64>,
    within_ns: Option<Ns>,
}

impl SdoEntry {
    pub(super) fn check(&self) -> Result<(), String> {
        check_node(self.line, Some(self.node))?;
        check_times(self.line, &[], &[self.within_ns])?;
        let outcome = self.outcome();
        if self.value.is_some() && outcome == Outcome::Aborted {
            return mistake(self.line, "value and aborted");
        }
        if self.abort.is_some() && outcome != Outcome::Aborted {
            return mistake(self.line, "abort and not aborted");
        }
        if self.count == Some(0) && (self.sequence.is_some() || self.within_ns.is_some()) {
            return mistake(self.line, "count 0 with sequence or within_ns");
        }
        Ok(())
    }

    fn outcome(&self) -> Outcome {
        self.outcome.unwrap_or(Outcome::Ok)
    }

    fn count(&self) -> u64 {
        self.count.unwrap_or(1)
    }

    /// Compares an ended transfer with it.
    fn fit(&self, transfer: &Transfer) -> Fit {
        let way = match transfer.direction {
            Direction::Upload => Way::Upload,
            Direction::Download => Way::Download,
        };
        let object = Mux { index: self.index, sub: self.sub };
        if transfer.node != self.node
            || transfer.mux != Some(object)
            || self.direction.is_some_and(|wanted| wanted != way)
        {
            return Fit::Elsewhere;
        }
        let valued = |value: &ExpectedValue| match value.is_of(transfer) {
            Same::Yes => Fit::Fits,
            Same::Unknown => Fit::Undecided,
            Same::No => Fit::Other(Other::Value(found(transfer, Some(value)))),
        };
        let status = if transfer.outcome.bad && transfer.outcome.status == Status::Ok {
            Status::Failed
        } else {
            transfer.outcome.status
        };
        match (self.outcome(), status) {
            (Outcome::Ok | Outcome::Any, Status::Ok) => self.value.as_ref().map_or(Fit::Fits, valued),
            (Outcome::Any, _) if self.value.is_some() => Fit::Undecided,
            (Outcome::Any, _) => Fit::Fits,
            (_, Status::Incomplete | Status::Open) => Fit::Cut,
            (_, Status::Failed) => Fit::Other(Other::Failed),
            (Outcome::Ok, Status::Aborted) => {
                Fit::Other(Other::Aborted(transfer.outcome.abort.map_or(AbortCode::Sdo(0), |abort| abort.code)))
            }
            (Outcome::Aborted, Status::Ok) => Fit::Other(Other::Succeeded),
            (Outcome::Aborted, Status::Aborted) => match (self.abort, transfer.outcome.abort) {
                (Some(wanted), Some(abort)) if wanted != abort.code.number() => Fit::Other(Other::Aborted(abort.code)),
                _ => Fit::Fits,
            },
        }
    }

    /// The expected value, for a finding.
    fn said(&self) -> Said {
        match (&self.value, self.abort, self.outcome()) {
            (Some(value), ..) => value.said(),
            (None, Some(code), _) => Said::Quantity(Quantity::Abort(AbortCode::of(code))),
            (None, None, Outcome::Aborted) => Said::Word("aborted"),
            (None, None, _) => Said::Word("ok"),
        }
    }
}

/// The result of comparing a transfer with an expectation.
#[derive(Clone, Debug)]
enum Fit {
    /// It is about something else.
    Elsewhere,
    Fits,
    /// Its value is not completely known and may match.
    Undecided,
    /// It was not completed in the capture.
    Cut,
    Other(Other),
}

/// The property that differs.
#[derive(Clone, Debug)]
enum Other {
    Value(Said),
    Aborted(AbortCode),
    Succeeded,
    Failed,
}

/// The frames of a transfer.
#[derive(Clone, Copy, Debug)]
struct TransferSighting {
    at: FrameRef,
    bus: BusId,
}

/// An expectation and its progress.
#[derive(Debug)]
struct Progress {
    entry: SdoEntry,
    place: EntryPlace,
    /// The number of matching transfers (for a step of a sequence: in its place).
    done: u64,
    /// The last of these.
    completed: Option<TransferSighting>,
    /// It came, but its value is not completely known.
    undecided: Option<TransferSighting>,
    /// It came before its place in the sequence.
    early: Option<TransferSighting>,
    /// The transfer that came instead.
    other: Option<(TransferSighting, Other)>,
    /// It began, but was not completed.
    cut: Option<TransferSighting>,
    late: bool,
    /// It has a time limit, and came without a timestamp.
    untimed: bool,
    /// It was reported as overdue.
    overdue: bool,
    /// Frames were lost before it came.
    lost: bool,
}

impl Progress {
    fn is_done(&self) -> bool {
        self.done >= self.entry.count()
    }

    /// Records a matching transfer.
    fn come(&mut self, decided: bool, scene: &mut Scene<'_>) {
        let seen = TransferSighting { at: scene.at, bus: scene.bus };
        if !decided {
            self.undecided.get_or_insert(seen);
        }
        if self.entry.count() == 0 {
            if decided {
                self.forbid(scene);
            }
            return;
        }
        if !self.is_done()
            && let Some(limit) = self.entry.within_ns
        {
            match scene.elapsed_ns() {
                None => self.untimed = true,
                Some(elapsed) if elapsed > limit && self.lost && !std::mem::replace(&mut self.late, true) => {
                    let breach = scene.breach(Exp015::Lost);
                    scene.raise(&self.place, breach);
                }
                Some(elapsed) if elapsed > limit && !std::mem::replace(&mut self.late, true) => {
                    let breach = scene.breach(Exp001::Late { expected: limit, found: elapsed });
                    scene.raise(&self.place, breach);
                }
                Some(_) => {}
            }
        }
        self.done += 1;
        self.completed = Some(seen);
    }

    fn forbid(&self, scene: &mut Scene<'_>) {
        let value = self.entry.value.as_ref().map(ExpectedValue::said);
        let occurred = value.map_or(Exp004::Occurred, |found| Exp004::OccurredWith { found });
        scene.raise(&self.place, scene.breach(occurred));
    }

    /// Reports that it has not come, or not in its place, until the end.
    fn missing(&self, closing: &mut Closing<'_>) {
        if self.overdue {
            return;
        }
        if self.lost && self.other.is_none() {
            return closing.unchecked(&self.place, Exp015::Lost);
        }
        let expected = self.entry.said();
        if let Some((seen, other)) = &self.other {
            let breach = Breach::new(self.differs(other, expected), seen.at, seen.bus);
            return closing.raise(&self.place, breach);
        }
        let breach = |closing: &Closing<'_>, what| closing.breach(&self.place, what);
        let breach = if self.done > 0 {
            breach(closing, Exp001::TooFew { expected: self.entry.count(), found: self.done })
        } else if let Some(seen) = self.cut {
            Breach { bus: seen.bus, ..breach(closing, Exp001::NotCompleted { expected }).about(seen.at) }
        } else {
            let valued = self.entry.value.is_some();
            let what = match (self.entry.outcome(), self.entry.direction) {
                (Outcome::Aborted, _) if self.entry.abort.is_some() => Exp001::NoAbortWith { expected },
                (Outcome::Aborted, _) => Exp001::NoAbort { expected },
                (_, None) if valued => Exp001::NoTransferOf { expected },
                (_, None) => Exp001::NoTransfer { expected },
                (_, Some(Way::Upload)) if valued => Exp001::NoReadOf { expected },
                (_, Some(Way::Upload)) => Exp001::NoRead { expected },
                (_, Some(Way::Download)) if valued => Exp001::NoWriteOf { expected },
                (_, Some(Way::Download)) => Exp001::NoWrite { expected },
            };
            breach(closing, what)
        };
        closing.raise(&self.place, breach);
    }

    /// Returns the deviation of a transfer that differs from the expectation.
    fn differs(&self, other: &Other, expected: Said) -> Exp003 {
        let aborted = |code: AbortCode| Said::Quantity(Quantity::Abort(code));
        let ok = Said::Word("ok");
        match (other, self.entry.outcome()) {
            (Other::Value(value), _) => Exp003::Value { expected, found: value.clone() },
            (Other::Aborted(code), Outcome::Aborted) => Exp003::AbortedOtherwise { expected, found: aborted(*code) },
            (Other::Aborted(code), _) => Exp003::Aborted { expected, found: aborted(*code) },
            (Other::Succeeded, _) if self.entry.abort.is_some() => Exp003::SucceededNotWith { expected, found: ok },
            (Other::Succeeded, _) => Exp003::Succeeded { expected, found: ok },
            (Other::Failed, _) => Exp003::Failed { expected, found: Said::Word("failed") },
        }
    }
}

/// Transfers that have to complete one after the other.
#[derive(Debug)]
struct Sequence {
    name: String,
    /// Indices of its steps among all expectations, in order.
    steps: Vec<usize>,
    /// The number of completed steps.
    done: usize,
}

/// All expectations of SDO transfers.
#[derive(Debug)]
pub(super) struct Transfers {
    all: Vec<Progress>,
    sequences: Vec<Sequence>,
    /// The result of comparing the current transfer with each.
    fits: Vec<Fit>,
}

impl Transfers {
    pub(super) fn new(file: &str, entries: &[SdoEntry]) -> Self {
        let mut sequences: Vec<Sequence> = Vec::new();
        for (place, entry) in entries.iter().enumerate() {
            let Some(name) = &entry.sequence else { continue };
            match sequences.iter_mut().find(|one| one.name == *name) {
                Some(one) => one.steps.push(place),
                None => sequences.push(Sequence { name: name.clone(), steps: vec![place], done: 0 }),
            }
        }
        let all = entries.iter().map(|entry| Progress {
            place: EntryPlace {
                object: Some(Mux { index: entry.index, sub: entry.sub }),
                ..EntryPlace::new(file, entry.line, entry.bus.as_ref(), Some(entry.node))
            },
            entry: entry.clone(),
            done: 0,
            completed: None,
            undecided: None,
            early: None,
            other: None,
            cut: None,
            late: false,
            untimed: false,
            overdue: false,
            lost: false,
        });
        Self { all: all.collect(), sequences, fits: Vec::new() }
    }

    /// Takes a transfer that has ended.
    pub(super) fn ended(&mut self, transfer: &Transfer, scene: &mut Scene<'_>) {
        let Self { all, sequences, fits } = self;
        fits.clear();
        fits.extend(all.iter().map(
            |one| {
                if one.place.is_on(scene.name) { one.entry.fit(transfer) } else { Fit::Elsewhere }
            },
        ));
        let asked_for = fits.iter().any(|fit| matches!(fit, Fit::Fits | Fit::Undecided));
        let seen = TransferSighting { at: scene.at, bus: scene.bus };
        for (one, fit) in all.iter_mut().zip(fits.iter()) {
            match fit {
                Fit::Fits | Fit::Undecided if one.entry.sequence.is_none() => {
                    one.come(matches!(fit, Fit::Fits), scene);
                }
                Fit::Other(other) if !asked_for && !one.is_done() => one.other = Some((seen, other.clone())),
                Fit::Cut => one.cut = Some(TransferSighting { at: transfer.first, bus: scene.bus }),
                _ => {}
            }
        }
        for sequence in sequences {
            sequence.take(all, fits, scene);
        }
    }

    /// Notes that frames of a bus are missing: what has not come may have been among them.
    pub(super) fn lost(&mut self, name: &[u8]) {
        for one in self.all.iter_mut().filter(|one| one.place.is_on(name) && !one.is_done()) {
            one.lost = true;
        }
    }

    /// Reports what should have come by the time of `closing` and has not.
    pub(super) fn overdue(&mut self, start_ns: Option<Ns>, closing: &mut Closing<'_>) {
        for one in self.all.iter_mut().filter(|one| !one.is_done() && !one.late) {
            let elapsed = closing.end_ns.zip(start_ns).map(|(now, start)| now - start);
            if one.entry.within_ns.zip(elapsed).is_some_and(|(limit, elapsed)| elapsed > limit) {
                one.missing(closing);
                (one.overdue, one.late) = (true, true);
            }
        }
    }

    /// Reports at the end of the capture.
    pub(super) fn finish(&mut self, closing: &mut Closing<'_>) {
        for one in self.all.iter().filter(|one| one.entry.sequence.is_none() && !one.is_done()) {
            one.missing(closing);
        }
        for sequence in &self.sequences {
            sequence.finish(&self.all, closing);
        }
        for one in &self.all {
            if let Some(seen) = one.undecided {
                let breach = Breach::new(Exp015::NotWhole, seen.at, seen.bus);
                closing.raise(&one.place, breach);
            }
            if one.untimed && !one.late {
                closing.unchecked(&one.place, Exp015::NoStamps);
            }
        }
    }
}

impl Sequence {
    /// Takes a transfer: the step that is due, else one that came too early.
    fn take(&mut self, all: &mut [Progress], fits: &[Fit], scene: &mut Scene<'_>) {
        let fit = |step: usize| fits.get(step).filter(|fit| matches!(fit, Fit::Fits | Fit::Undecided));
        let mut open = self.steps.iter().skip(self.done);
        if let Some(due) = open.next()
            && let Some(fit) = fit(*due)
            && let Some(one) = all.get_mut(*due)
        {
            one.come(matches!(fit, Fit::Fits), scene);
            self.done += usize::from(one.is_done());
            return;
        }
        let seen = TransferSighting { at: scene.at, bus: scene.bus };
        for step in open.filter(|step| fit(**step).is_some()) {
            if let Some(one) = all.get_mut(*step) {
                one.early = Some(seen);
            }
        }
    }

    /// Reports the steps that were never in their place. The sequence continues from one that came too early: those
    /// after it are compared with it.
    fn finish(&self, all: &[Progress], closing: &mut Closing<'_>) {
        let steps = || self.steps.iter().filter_map(|step| all.get(*step));
        let mut before = None;
        for one in steps() {
            let seen = if one.is_done() { one.completed } else { one.early };
            let due = before.is_none_or(|(no, _): (u64, _)| seen.is_some_and(|seen| seen.at.no > no));
            match seen {
                Some(seen) if one.is_done() || due => before = Some((seen.at.no, one)),
                Some(seen) => {
                    let first = before.map_or("", |(_, one)| &one.place.label);
                    let early = Exp002::TooEarly { sequence: self.name.as_str().into(), before: first.into() };
                    closing.raise(&one.place, Breach::new(early, seen.at, seen.bus));
                    before = Some((seen.at.no, one));
                }
                None => one.missing(closing),
            }
        }
    }
}
