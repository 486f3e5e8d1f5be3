//! The capture as a whole and the reports about it: numbers and times of frames, findings about
//! files.
//!
//! A finding about the capture belongs to no frame. Must not: write output, or know what a frame means.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bytes::frame::{BusId, Buses, Frame, FrameRef, Stamp};
use crate::bytes::inputs::{ABSOLUTE_NS, File, Unreadable};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{Damage, DamageKind, FilePlace, Marker, Unreadable as Reason};
use crate::bytes::writers;
use crate::rules::capture::{Cap001, Cap002, Cap004, Cap005, Cap008};
use crate::rules::finding::{Code, Finding, Verdict};
use crate::tables::jsonl;
use crate::views::filter::FilterClock;
use crate::views::lines::{Clocked, Time};
use crate::words::{Lang, complaints};

/// Unreadable lines and damaged places of a file that are named one by one as they come.
const NAMED: u64 = 5;
/// A file that begins so much earlier than the one before it ended is out of order, in ns.
const STEP_BACK_NS: Ns = Ns::from_ms(10);
/// Files further apart than this, in ns, are no parts of one recording that goes on: nothing is known of the time between
/// them, and they may have nothing to do with each other.
const APART_NS: Ns = Ns::from_s(3600);

/// A capture, of one file or several.
#[derive(Debug)]
pub(super) struct Capture {
    lang: Lang,
    /// The form of times.
    time: Option<Time>,
    /// The file at hand.
    pub(super) file: File,
    /// The file before it, until its first frame.
    before: Option<Arc<[u8]>>,
    /// Frames so far, over all files: those that were numbered, and those that were handed on.
    numbered: u64,
    pub(super) frames: u64,
    /// The file of the frame at hand, where that was held back and another file may have its turn.
    of_held: Option<Origin>,
    /// Time of the first frame.
    start_ns: Option<Ns>,
    /// The date from which the capture's stamps count, where its first dated file has one.
    pub(super) date_ns: Option<Ns>,
    /// Digits after the point of the last stamp.
    decimals: u8,
    /// Number of reports of the capturing program about itself.
    gaps: u64,
    /// The last frame.
    pub(super) last: FrameRef,
    /// Lines for standard error.
    pub(super) complaints: Vec<String>,
    /// It was said that files are far apart: a folder may hold hundreds.
    apart: bool,
}

/// A file, as far as a frame of it that is held back needs it.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    name: Arc<[u8]>,
    dated: bool,
}

/// The state of the capture that outputs need beside events.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pub(super) buses: &'a Buses,
    /// For filters.
    pub(super) clock: FilterClock,
    /// For JSON lines and signals.
    pub(super) jsonl: jsonl::Setting<'a>,
    /// For writers.
    pub(super) writing: writers::CaptureFacts<'a>,
}

impl Capture {
    pub(super) fn new(lang: Lang, time: Option<Time>) -> Self {
        Self {
            lang,
            time,
            file: File::default(),
            before: None,
            numbered: 0,
            frames: 0,
            of_held: None,
            start_ns: None,
            date_ns: None,
            decimals: 9,
            gaps: 0,
            last: FrameRef::default(),
            complaints: Vec::new(),
            apart: false,
        }
    }

    /// The next file begins.
    pub(super) fn begin(&mut self, name: &[u8]) {
        let before = std::mem::replace(&mut self.file, File { name: name.into(), ..File::default() });
        self.before = (before.frames > 0).then_some(before.name);
    }

    pub(super) fn view<'a>(&'a self, buses: &'a Buses) -> View<'a> {
        let (file, dated) = match &self.of_held {
            Some(origin) => (&origin.name, origin.dated),
            None => (&self.file.name, self.file.dated),
        };
        let date_ns = self.date_ns.filter(|_| dated);
        View {
            buses,
            clock: FilterClock { start_ns: self.start_ns.unwrap_or(Ns::ZERO), date_ns: date_ns.unwrap_or(Ns::ZERO) },
            jsonl: jsonl::Setting {
                lang: self.lang,
                file,
                buses,
                decimals: self.decimals,
                clock: Clocked { time: self.time, start_ns: self.start_ns, date_ns },
            },
            writing: writers::CaptureFacts { buses, date_ns },
        }
    }

    /// The time of its first frame, where one has come and has a stamp or counts from 0.
    pub(super) fn start_ns(&self) -> Option<Ns> {
        self.start_ns
    }

    /// The number of the last frame that was placed.
    pub(super) fn numbered(&self) -> u64 {
        self.numbered
    }

    /// Counts a frame that is not placed.
    pub(super) fn count(&mut self, frame: &Frame) {
        self.numbered += 1;
        self.frames += 1;
        self.arrived(frame);
    }

    /// A frame of the file has come.
    #[inline]
    fn arrived(&mut self, frame: &Frame) {
        self.file.frames += 1;
        self.file.beyond += u64::from(frame.is_clamped());
    }

    /// Gives the next frame its number and its time among the capture's. Whether it begins a file whose times
    /// cannot be compared with those of the one before.
    #[inline]
    pub(super) fn place(&mut self, frame: &mut Frame) -> bool {
        self.numbered += 1;
        self.arrived(frame);
        frame.no = self.numbered;
        if self.file.frames == 1 {
            self.begins(frame);
        }
        if self.file.shift_ns != Ns::ZERO {
            let shift = |ns: Ns| ns + self.file.shift_ns;
            frame.t_ns = frame.t_ns.map(shift);
            frame.stamp = frame.stamp.map(|stamp| Stamp { ns: shift(stamp.ns), ..stamp });
        }
        self.start_ns.get_or_insert(frame.t_ns.unwrap_or(Ns::ZERO));
        self.before.take().is_some_and(|before| self.boundary(&before, frame))
    }

    /// Returns true if the frame placed last begins a file that follows another.
    #[inline]
    pub(super) fn begins_file(&self) -> bool {
        self.file.frames == 1 && self.numbered > 1
    }

    /// The file that has its turn, for a frame that is held back.
    pub(super) fn origin(&self) -> Origin {
        Origin { name: Arc::clone(&self.file.name), dated: self.file.dated }
    }

    /// A frame that was placed is handed on. `held`: its file, where it was held back.
    #[inline]
    pub(super) fn take(&mut self, frame: &Frame, held: Option<Origin>) {
        self.frames += 1;
        self.of_held = held;
        self.decimals = frame.stamp.map_or(9, |stamp| stamp.decimals);
        self.last = frame.reference();
    }

    /// A frame that was handed on is written later than others.
    pub(super) fn show(&mut self, frame: &Frame, origin: Option<Origin>) {
        self.of_held = origin;
        self.decimals = frame.stamp.map_or(9, |stamp| stamp.decimals);
    }

    /// The file of the frame that was handed on last, where it was held back.
    pub(super) fn of_held(&self) -> Option<Origin> {
        self.of_held.clone()
    }

    /// No frame that was held back is at hand any more.
    pub(super) fn caught_up(&mut self) {
        self.of_held = None;
    }

    /// Takes the next frame of a bus in the file.
    #[inline]
    pub(super) fn follow(&mut self, frame: &Frame) {
        let bus = usize::from(frame.bus.0);
        if self.file.last.len() <= bus {
            self.file.last.resize(bus + 1, [None; 2]);
        }
        if let Some([before, last]) = self.file.last.get_mut(bus) {
            (*before, *last) = (*last, Some(frame.reference()));
        }
    }

    /// The frame before the last one of a bus, where it is in the same file and both stamps can be compared.
    pub(super) fn before(&self, bus: BusId) -> Option<FrameRef> {
        let [before, _] = *self.file.last.get(usize::from(bus.0))?;
        before.filter(|_| !self.file.misread)
    }

    /// A line of the file that is no frame, as a place on this bus: behind its last frame in the file, if there is one.
    pub(super) fn behind(&self, bus: BusId, line: Option<u64>) -> FrameRef {
        let last = self.file.last.get(usize::from(bus.0)).and_then(|[_, last]| *last);
        last.unwrap_or_default().with_line(line)
    }

    /// The first frame of a file. Files whose stamps are absolute and files whose stamps count from a date follow one
    /// another on one clock, which is that of the first.
    fn begins(&mut self, frame: &Frame) {
        if self.file.dated || frame.t_ns.is_none_or(|t_ns| t_ns < ABSOLUTE_NS) {
            return;
        }
        let date_ns = *self.date_ns.get_or_insert(Ns::ZERO);
        if date_ns != Ns::ZERO {
            self.file.shift_ns = -date_ns;
            self.file.dated = true;
        }
    }

    /// The first frame of a file that follows another: files that are named out of order are worth a word, and so are files
    /// that are far apart, as they may be no one capture. Whether its time cannot be compared with that of the one before.
    fn boundary(&mut self, before: &[u8], frame: &Frame) -> bool {
        let (Some(end_ns), Some(t_ns)) = (self.last.t_ns, frame.t_ns) else { return false };
        let back_ns = end_ns - t_ns;
        if back_ns.abs() >= APART_NS {
            if !std::mem::replace(&mut self.apart, true) {
                self.complaints.push(complaints::far_apart(self.lang, &self.file.name, before, back_ns));
            }
            return true;
        }
        if back_ns >= STEP_BACK_NS {
            self.complaints.push(complaints::step_back(self.lang, &self.file.name, before, back_ns));
        }
        back_ns > Ns::ZERO
    }

    /// From here on the file's stamps count from this date.
    pub(super) fn dated(&mut self, date_ns: Ns) {
        self.file.last.clear();
        self.file.shift_ns = date_ns - *self.date_ns.get_or_insert(date_ns);
        self.file.dated = true;
    }

    /// A live bus was away: its clock may be another one after that.
    pub(super) fn gap(&mut self) {
        self.file.last.clear();
    }

    /// Reports a message of the capturing program about itself as a complaint; returns the finding, if it is one.
    pub(super) fn marker(&mut self, marker: &Marker, buses: &Buses) -> Option<Finding> {
        let (what, place, bus) = match *marker {
            Marker::Start { .. } => return None,
            Marker::Dropped { bus, count, total, place } => {
                (Some(Cap002::Dropped { frames: count, total }.into()), place, bus)
            }
            Marker::LeftOut { count, rows, place } => (Some(left_out(count, rows)), place, BusId(0)),
            Marker::Swapped => {
                self.complaints.push(complaints::swapped(self.lang, &self.file.name));
                return None;
            }
            Marker::Backward { place } => {
                self.file.misread = true;
                (Some(Code::Cap003.into()), place, BusId(0))
            }
            Marker::Error { bus, place, .. } => (None, place, bus),
        };
        let finding = what.map(|what: Verdict| self.finding(what, place, bus));
        let of = if place == FilePlace::Live { buses.name(bus) } else { &self.file.name };
        self.gaps += 1;
        // A live bus may lose frames with every piece that it gives: it is reported less and less often.
        if place == FilePlace::Live && self.gaps > NAMED && !self.gaps.is_power_of_two() {
            return finding;
        }
        self.complaints.push(complaints::marker(self.lang, of, place, finding.as_ref()));
        finding
    }

    /// A part of the file is lost.
    pub(super) fn damaged(&mut self, damage: Damage) -> Finding {
        let Damage { place, kind, bytes, frames } = damage;
        let offset = match place {
            FilePlace::Line(at) | FilePlace::Byte(at) => Some(at),
            FilePlace::Live => None,
        };
        let what: Verdict = match (kind, bytes, frames) {
            (DamageKind::Cut, ..) => Cap005::Cut { offset, bytes, frames }.into(),
            (DamageKind::Checksum, None, _) => Cap004::ChecksumUncounted { offset, bytes, frames }.into(),
            (DamageKind::Checksum, _, None) => Cap004::Checksum { offset, bytes }.into(),
            (DamageKind::Checksum, _, Some(frames)) => Cap004::ChecksumWithFrames { offset, bytes, frames }.into(),
            (DamageKind::Structure, None, _) => Cap004::StructureUncounted { offset, bytes, frames }.into(),
            (DamageKind::Structure, _, None) => Cap004::Structure { offset, bytes }.into(),
            (DamageKind::Structure, _, Some(frames)) => Cap004::StructureWithFrames { offset, bytes, frames }.into(),
            (DamageKind::Compression, None, _) => Cap004::CompressionUncounted { offset, bytes, frames }.into(),
            (DamageKind::Compression, _, None) => Cap004::Compression { offset, bytes }.into(),
            (DamageKind::Compression, _, Some(frames)) => {
                Cap004::CompressionWithFrames { offset, bytes, frames }.into()
            }
            (DamageKind::Rest, ..) => Cap004::Rest { offset, bytes, frames }.into(),
            (DamageKind::Undefined, _, None) => Cap004::Undefined { offset, bytes, frames }.into(),
            (DamageKind::Undefined, _, Some(frames)) => Cap004::UndefinedWithFrames { offset, bytes, frames }.into(),
            (DamageKind::Doubtful, _, None) => Cap004::Doubtful { offset, bytes, frames }.into(),
            (DamageKind::Doubtful, _, Some(frames)) => Cap004::DoubtfulWithFrames { offset, bytes, frames }.into(),
            (DamageKind::Definition, ..) => Cap004::Definition { offset, bytes, frames }.into(),
            (DamageKind::Excess, ..) => Cap004::Excess { offset, bytes, frames }.into(),
            (DamageKind::Missing, ..) => Cap004::Missing { offset, bytes, frames }.into(),
            (DamageKind::Unlocated, ..) => Cap004::Unlocated { offset, bytes, frames }.into(),
        };
        let finding = self.finding(what, place, BusId(0));
        self.file.damages += 1;
        if self.file.damages <= NAMED {
            self.complaints.push(complaints::marker(self.lang, &self.file.name, place, Some(&finding)));
        }
        finding
    }

    /// A line of the file, or a record, cannot be read.
    pub(super) fn unreadable(&mut self, place: FilePlace, reason: Reason) {
        self.file.unreadable.add(place);
        self.file.of_further_buses += u64::from(reason == Reason::Bus);
        if self.file.unreadable.count <= NAMED {
            self.complaints.push(complaints::unreadable(self.lang, &self.file.name, place, reason));
        }
    }

    /// The file is over: how many damaged places it has, and stamps that could not be taken as they are.
    pub(super) fn end_of_complaints(&mut self) {
        if self.file.damages > NAMED {
            self.complaints.push(complaints::damages(self.lang, &self.file.name, self.file.damages));
        }
        if self.file.beyond > 0 {
            self.complaints.push(complaints::beyond(self.lang, &self.file.name, self.file.beyond));
        }
    }

    /// The file is over: what of it could not be read, and the finding about that. Of a file without frames nothing is
    /// said.
    pub(super) fn end(&mut self) -> (Unreadable, Option<Finding>) {
        let unreadable = std::mem::take(&mut self.file.unreadable);
        let Unreadable { count, first, ranges } = &unreadable;
        if *count == 0 || self.file.found() == 0 {
            return (unreadable, None);
        }
        let first = first.unwrap_or(FilePlace::Line(0));
        let what = match self.file.of_further_buses {
            0 => Cap001::Lines { lines: *count }.into(),
            further_buses => Cap001::OfFurtherBuses { lines: *count, further_buses }.into(),
        };
        let finding = self.finding(what, first, BusId(0));
        if *count > NAMED {
            self.complaints.push(complaints::unreadable_lines(self.lang, &self.file.name, first, *count, ranges));
        }
        let of_further_buses = self.file.of_further_buses;
        if of_further_buses > 0 {
            self.complaints.push(complaints::further_buses(self.lang, &self.file.name, of_further_buses));
        }
        (unreadable, Some(finding))
    }

    /// The capture is over. `absent`: descriptions of nodes that are not in it, by file. `idle`: a filter let nothing
    /// through. `beyond`: frames that it asks for and that there are not, and whether it asks for no others. One line says
    /// why nothing is shown. `timeless`: it should have ended with a time, and has none.
    pub(super) fn finish(
        &mut self,
        absent: BTreeMap<&str, Vec<u8>>,
        idle: bool,
        (beyond, all): (Vec<(u32, u32)>, bool),
        timeless: bool,
    ) {
        let lines = absent.into_iter().map(|(file, nodes)| complaints::absent(self.lang, file.as_bytes(), nodes));
        self.complaints.extend(lines);
        if idle && !all {
            self.complaints.push(complaints::nothing_shown(self.lang, self.frames));
        } else if !beyond.is_empty() {
            self.complaints.push(complaints::no_such_frames(self.lang, &beyond, self.frames));
        }
        if timeless {
            self.complaints.push(complaints::timeless(self.lang));
        }
    }

    /// Returns a finding; in a file without lines it names the last frame before it.
    fn finding(&self, what: Verdict, place: FilePlace, bus: BusId) -> Finding {
        let Verdict { code, facts } = what;
        let at = match place {
            FilePlace::Line(line) => FrameRef::default().with_line(Some(line)),
            FilePlace::Byte(_) | FilePlace::Live => self.last.listed(),
        };
        Finding { code, at, cause: None, bus, node: None, object: None, facts, because_of: None }
    }
}

/// The sentence about rows that are left out.
fn left_out(count: Option<u64>, rows: Option<(u64, u64)>) -> Verdict {
    match (count, rows) {
        (Some(rows), Some((last, next))) => Cap008::Rows { rows, last, next }.into(),
        (Some(rows), None) => Cap008::Counted { rows }.into(),
        (None, _) => Cap008::Uncounted.into(),
    }
}
