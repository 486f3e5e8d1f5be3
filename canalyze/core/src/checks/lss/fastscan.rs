//! LSS Fastscan as one action (CiA 305): the identity found by a scan, by its confirmations.
//!
//! A slave is found bit by bit; the final bits are in four confirmations (BitCheck 0, LSSNext other than LSSSub).
//! Unanswered steps between them, the normal way to find a bit that is 1, need no timing. A confirmation succeeded if
//! the next step uses the part that it names, the last one if it was answered. Permission for a step is judged in
//! `checks::lss`.

use super::exchange::close;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;
use crate::wire::lss::BIT_CHECK_ANY;
use crate::world::event::Scanned;

/// A step of the master.
#[derive(Clone, Copy, Debug)]
pub struct ScanStep {
    /// The bits known so far.
    pub id_number: u32,
    /// The lowest bit compared.
    pub bit_check: u8,
    /// Part compared, 0..=3.
    pub sub: u8,
    /// Part to be compared next, 0..=3.
    pub next: u8,
}

/// A finished scan, and its first frame.
pub type Over = (FrameRef, Scanned);

/// The scan in progress.
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
    confirming: Option<ScanStep>,
    answer: Option<FrameRef>,
    /// The last confirmation was captured right after an answer that may be its own.
    early: bool,
}

impl Fastscan {
    /// Takes a step of the master, which may be listed `lag_ns` late; returns a scan abandoned for it.
    pub fn step(&mut self, step: ScanStep, at: FrameRef, lag_ns: Ns) -> Option<Over> {
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

    /// Takes a slave's answer; returns the finished scan if it answers the last confirmation.
    pub fn answer(&mut self, at: FrameRef) -> Option<Over> {
        let scan = self.scan.as_mut()?;
        scan.answer = Some(at);
        scan.confirming.filter(|step| step.next < step.sub)?;
        self.found(at)
    }

    /// Returns true if the last confirmation is open and the answer right before it may be its own.
    pub fn may_have_found(&self) -> bool {
        self.scan.as_ref().is_some_and(|scan| scan.early)
    }

    /// Finishes the scan when a slave proves to be configured, so that the early answer was to the last confirmation.
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

    /// Abandons the scan for another command; a question that no slave answered is not reported.
    pub fn give_up(&mut self) -> Option<Over> {
        let scan = self.scan.take()?;
        let end = scan.last;
        let begun = scan.frames > 1 && (scan.answer.is_some() || scan.address.iter().any(Option::is_some));
        (begun && !scan.early).then(|| scan.over(false, end))
    }

    /// Returns the last step of the scan in progress.
    pub fn last(&self) -> Option<FrameRef> {
        self.scan.as_ref().map(|scan| scan.last)
    }

    /// Forgets the scan after lost frames.
    pub fn lost(&mut self) {
        self.scan = None;
    }
}

impl Scan {
    fn confirm(&mut self, step: ScanStep) {
        if let Some(part) = self.address.get_mut(usize::from(step.sub)) {
            *part = Some(step.id_number);
        }
    }

    fn over(&self, found: bool, end: FrameRef) -> Over {
        let duration_ns = end.t_ns.zip(self.first.t_ns).map(|(end, first)| end - first);
        (self.first, Scanned { found, address: self.address, frames: self.frames, duration_ns })
    }
}
