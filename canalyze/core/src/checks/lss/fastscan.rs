//! LSS Fastscan as one action (CiA 305): which identity a scan has found, by its confirmations.
//!
//! A slave is found bit by bit; which bits are known at last stands in four confirmations (BitCheck 0, LSSNext other
//! than LSSSub), so that the unanswered steps between them, the normal way to find a bit that is 1, need no timing. A
//! confirmation held if the next step works on the part it names, the last one if it was answered. It must not judge:
//! whether a step is allowed is `checks::lss`'s question.

use super::exchange::close;
use crate::event::Scanned;
use crate::frame::FrameRef;
use crate::wire::lss::BIT_CHECK_ANY;

/// One step of the master.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The bits known so far.
    pub id_number: u32,
    /// The lowest bit compared.
    pub bit_check: u8,
    /// Part compared, 0..=3.
    pub sub: u8,
    /// Part to be compared next, 0..=3.
    pub next: u8,
}

/// A scan that is over, and its first frame.
pub type Over = (FrameRef, Scanned);

/// The scan that is under way, if any.
#[derive(Debug, Default)]
pub struct Fastscan {
    scan: Option<Scan>,
}

#[derive(Debug)]
struct Scan {
    first: FrameRef,
    last: FrameRef,
    frames: u32,
    address: [Option<u32>; 4],
    confirming: Option<Step>,
    answer: Option<FrameRef>,
    /// The last confirmation was captured right after an answer that may be its own.
    early: bool,
}

impl Fastscan {
    /// The master's frame, which may be listed `lag_ns` late. Says which scan was given up for it.
    pub fn step(&mut self, step: Step, at: FrameRef, lag_ns: i64) -> Option<Over> {
        let over = if step.bit_check == BIT_CHECK_ANY { self.give_up() } else { None };
        let scan = self.scan.get_or_insert(Scan {
            first: at,
            last: at,
            frames: 0,
            address: [None; 4],
            confirming: None,
            answer: None,
            early: false,
        });
        scan.frames = scan.frames.saturating_add(1);
        scan.last = at;
        if let Some(before) = scan.confirming
            && step.sub == before.next
            && step.bit_check != BIT_CHECK_ANY
        {
            scan.confirm(before);
        }
        let confirmation = step.bit_check == 0 && step.next != step.sub;
        scan.confirming = confirmation.then_some(step);
        scan.early =
            confirmation && step.next < step.sub && scan.answer.is_some_and(|answer| close(answer, at, lag_ns));
        over
    }

    /// A slave's answer. Says what was found, where it is the one to the last confirmation.
    pub fn answer(&mut self, at: FrameRef) -> Option<Over> {
        let scan = self.scan.as_mut()?;
        scan.answer = Some(at);
        scan.confirming.filter(|step| step.next < step.sub)?;
        self.found(at)
    }

    /// Whether the scan stands at its last confirmation, and an answer right before it may be the one to it.
    pub fn may_have_found(&self) -> bool {
        self.scan.as_ref().is_some_and(|scan| scan.early)
    }

    /// A slave shows that it is in the configuration state: the early answer was the one to the last confirmation.
    pub fn proven(&mut self, at: FrameRef) -> Option<Over> {
        if self.may_have_found() { self.found(at) } else { None }
    }

    fn found(&mut self, at: FrameRef) -> Option<Over> {
        let mut scan = self.scan.take()?;
        if let Some(step) = scan.confirming {
            scan.confirm(step);
        }
        let end = if scan.early { scan.last } else { at };
        Some(scan.over(true, end))
    }

    /// The master does something else. Nothing is reported of a question that no slave answered.
    pub fn give_up(&mut self) -> Option<Over> {
        let scan = self.scan.take()?;
        let end = scan.last;
        let begun = scan.frames > 1 && (scan.answer.is_some() || scan.address.iter().any(Option::is_some));
        (begun && !scan.early).then(|| scan.over(false, end))
    }

    /// The last step, while a scan is under way.
    pub fn last(&self) -> Option<FrameRef> {
        self.scan.as_ref().map(|scan| scan.last)
    }

    /// Frames were lost: what was under way is not known any more.
    pub fn lost(&mut self) {
        self.scan = None;
    }
}

impl Scan {
    fn confirm(&mut self, step: Step) {
        if let Some(part) = self.address.get_mut(usize::from(step.sub)) {
            *part = Some(step.id_number);
        }
    }

    fn over(&self, found: bool, end: FrameRef) -> Over {
        let duration_ns = end.t_ns.zip(self.first.t_ns).map(|(end, first)| end.saturating_sub(first));
        (self.first, Scanned { found, address: self.address, frames: self.frames, duration_ns })
    }
}
