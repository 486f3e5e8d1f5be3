//! One capture, from the bytes of its files to lines: the loop.
//!
//! bytes -> reader -> frame -> bus -> events -> output. `capture` knows which frame it is and what is wrong with its
//! file, `decoding` what it means, `output` writes it down; this file hands on from one to the next. It does no I/O
//! and reads no clock; it must not know a service or a format by name.

mod ahead;
mod capture;
mod decoding;
mod output;
mod records;
mod sink;
mod subject;
mod tally;

use std::sync::Arc;

use self::ahead::{Ahead, Behind, Placed};
use self::capture::Capture;
use self::decoding::Decoding;
use self::output::Output;
use self::tally::Tally;
use crate::diff::digest::Digest;
use crate::evidence::When;
use crate::evidence::recording::Happened;
use crate::evidence::services::Nature;
use crate::expectation::Expectations;
use crate::filter::Filter;
use crate::finding::{Code, Finding};
use crate::frame::{BusId, Buses, Frame, FrameRef};
use crate::inputs::{Inputs, Next, Refusal};
use crate::masks::Masks;
use crate::monitor::{Known, Line, Wanted};
use crate::network::Network;
use crate::readers::candump::Stamps;
use crate::readers::mcap::Choice;
use crate::readers::{Contents, Damage, Format as Input, Item, Marker, Reader, Settings};
use crate::render::columns::{self, Batch};
use crate::render::jsonl;
use crate::render::text::{Look, Time};
use crate::rules::capture::{Cap006, Cap007};
use crate::select::Select;
use crate::text::{Depth, Lang, complaints};
use crate::writers::{self, Loss};

pub use self::decoding::Extracted;

/// What comes out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Annotated lines in candump's console form.
    #[default]
    Text,
    /// JSON lines: frames, notes, findings, transfers.
    Jsonl,
    /// The same with all of the diagnosis at the end, for libraries.
    Events,
    /// JSON lines of SDO transfers only.
    Transfers,
    /// The same for a table for people: names of objects are in their language.
    TransfersText,
    /// CSV of SDO transfers.
    TransfersCsv,
    /// JSON lines of decoded signals only.
    Signals,
    /// CSV of decoded signals.
    SignalsCsv,
    /// JSON lines of figures, all at the end.
    Summary,
    /// JSON lines of what expectations can be written from: transfers as they end, then figures.
    Observed,
    /// JSON lines: the annotated lines of [`Format::Text`], each with the number of its frame.
    Lines,
    /// JSON lines of SDO transfers and findings as they come, and the figures at the end.
    Records,
    /// JSON lines of what each file is, one a file; nothing is decoded.
    Info,
    /// Nothing: what is to be compared is kept for [`Session::take_digest`].
    Digest,
    /// The frames themselves, in another capture format.
    Convert(writers::Format),
    /// JSON lines of findings only, each with the annotated lines of its context.
    Check,
    /// JSON lines of what went wrong: incidents, then the verdict, all at the end.
    Diagnosis,
    /// Nothing: what a view shows while the capture grows is asked for with [`Session::snapshot`] and
    /// [`Session::trace`].
    Monitor,
    /// Nothing: for tables alone (see [`Options::tables`]), of which batches are taken with [`Session::take_batches`].
    Columns,
}

/// How a capture is read and shown.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The language.
    pub lang: Lang,
    /// What comes out.
    pub format: Format,
    /// How detailed a line is.
    pub depth: Depth,
    /// What small stamps mean.
    pub stamps: Stamps,
    /// What of an MCAP file is read, and how.
    pub mcap: Choice,
    /// How time is shown; as it came, by default.
    pub time: Option<Time>,
    /// How lines are marked.
    pub look: Look,
    /// Which frames are shown.
    pub filter: Filter,
    /// The same in candump's manner, by channel.
    pub masks: Masks,
    /// Frames that are shown at most (transfers, where only they are): the capture ends behind the last of them.
    pub count: Option<u64>,
    /// Whether the bytes of SDO transfers are handed out.
    pub extract: bool,
    /// What is known of the network beforehand.
    pub network: Arc<Network>,
    /// Which signals are listed.
    pub select: Select,
    /// Which tables of columns are built, beside what comes out in any format but [`Format::Info`].
    pub tables: Vec<columns::Name>,
    /// How the format that is written is written.
    pub writing: writers::Settings,
    /// Whether incidents are written, too: in [`Format::Text`] as they begin and end, in [`Format::Jsonl`] both so and at
    /// the end, in [`Format::Check`] and [`Format::Observed`] at the end.
    pub incidents: bool,
    /// What is expected of the capture.
    pub expectations: Option<Arc<Expectations>>,
}

/// A capture being read.
#[derive(Debug)]
pub struct Session {
    lang: Lang,
    /// How files are read.
    reading: Settings,
    inputs: Inputs,
    /// The file that has its turn: what is kept of it is with the stream.
    turn: usize,
    /// The file that was fed last.
    fed: usize,
    buses: Buses,
    stream: Stream,
}

/// Everything behind the reader.
#[derive(Debug)]
struct Stream {
    capture: Capture,
    /// Frames that wait until it is known what the recording did with them.
    ahead: Ahead,
    decoding: Decoding,
    output: Output,
    tally: Tally,
}

impl Session {
    /// A session at the beginning of a capture.
    pub fn new(options: Options) -> Self {
        let output = Output::new(&options);
        // Of frames in JSON lines the time is that of the capture.
        let time = options.time.filter(|_| options.format != Format::Jsonl);
        let Options { lang, stamps, mcap, extract, network, expectations, .. } = options;
        let mut decoding = Decoding::new(network, extract, output.is_blind(), output.folds());
        if let Some(expected) = expectations {
            decoding.expect(&expected);
        }
        if output.diagnoses() {
            decoding.diagnose();
        }
        Self {
            lang,
            reading: Settings { stamps, mcap, regular: false },
            inputs: Inputs::default(),
            turn: 0,
            fed: 0,
            buses: Buses::default(),
            stream: Stream {
                capture: Capture::new(lang, time),
                ahead: Ahead::default(),
                decoding,
                output,
                tally: Tally::default(),
            },
        }
    }

    /// The next file begins, in this format. `regular`: it is a whole file, not a pipe.
    pub fn begin(&mut self, name: &[u8], format: Input, regular: bool) {
        self.begin_one(0, name, format, regular);
    }

    /// The same of one of several files that are joined by time. They are numbered from 0 in the order in which they
    /// begin, and all of them begin before any is fed.
    pub fn begin_one(&mut self, input: usize, name: &[u8], format: Input, regular: bool) {
        let reader = Reader::new(format, &Settings { regular, ..self.reading.clone() });
        self.inputs.open(input == 0, name, reader);
        let format = Input::NAMES.iter().find(|row| row.1 == format).map_or("", |row| row.0);
        self.stream.output.begin(name, format, input == 0);
        if input == 0 {
            self.stream.capture.begin(name);
            (self.turn, self.fed) = (0, 0);
            if self.stream.output.info().is_some() {
                self.buses = Buses::default();
            }
        }
    }

    /// More bytes of the current file, in any chunking; appends what they yield.
    pub fn feed(&mut self, bytes: &[u8], out: &mut Vec<u8>) {
        self.feed_one(0, bytes, out);
    }

    /// The same of one of several files.
    pub fn feed_one(&mut self, input: usize, bytes: &[u8], out: &mut Vec<u8>) {
        let Self { inputs, buses, stream, .. } = self;
        if let Some(alone) = inputs.alone() {
            if !alone.is_covered() {
                let Some(reader) = &mut alone.reader else { return };
                return reader.feed(bytes, buses, &mut |item, buses| stream.item(item, buses, out));
            }
            let Some(mut reader) = alone.reader.take() else { return };
            alone.feeds(bytes);
            reader.feed(bytes, buses, &mut |item, buses| {
                alone.counts(&item);
                stream.item(item, buses, out);
            });
            alone.reader = Some(reader);
        } else {
            inputs.feed(input, bytes);
            self.fed = input;
            self.join(out);
        }
    }

    /// The bytes of a file go on no further than here, for this reason; it is reported when the file ends.
    pub fn damaged(&mut self, input: usize, damage: Damage) {
        if let Some(one) = self.inputs.get(input) {
            one.damage = Some(damage);
        }
    }

    /// What stands at the end of a file, from its summary on, before anything of it is fed. Only MCAP has such.
    pub fn foresee(&mut self, input: usize, end: &[u8]) {
        if let Some(reader) = self.inputs.get(input).and_then(|one| one.reader.as_mut()) {
            reader.foresee(end);
        }
    }

    /// What is fed of a file from here on is under a check sum of its own: where that fails, what came before is sound.
    pub fn covered(&mut self, input: usize) {
        if let Some(one) = self.inputs.get(input) {
            one.covers();
        }
    }

    /// The current file is over. `interrupted`: its reading was broken off, so a last line that has no end is no
    /// fault of the file.
    pub fn end(&mut self, interrupted: bool, out: &mut Vec<u8>) {
        self.end_one(0, interrupted, out);
    }

    /// The same of one of several files.
    pub fn end_one(&mut self, input: usize, interrupted: bool, out: &mut Vec<u8>) {
        let Self { inputs, buses, stream, .. } = self;
        if let Some(alone) = inputs.alone() {
            let Some(mut reader) = alone.reader.take() else { return };
            let damaged = alone.damage.is_some();
            let mut sink = |item: Item, buses: &Buses| {
                alone.counts(&item);
                stream.item(item, buses, out);
            };
            if interrupted || damaged {
                reader.interrupt(buses, &mut sink);
            } else {
                reader.finish(buses, &mut sink);
            }
            if let Some(damage) = alone.told() {
                stream.item(Item::Damaged(damage), buses, out);
            }
            alone.contents = reader.contents();
            stream.end_of_file(&alone.contents, buses, out);
        } else {
            inputs.end(input, interrupted);
            self.fed = input;
            self.join(out);
        }
    }

    /// The file that has to be fed before anything can go on; `None` when all are over or cannot be
    /// joined, or nothing further is taken.
    pub fn wants(&self) -> Option<usize> {
        if self.is_done() { None } else { self.inputs.wants() }
    }

    /// Why the files that have begun cannot be joined by time.
    pub fn refusal(&self) -> Option<Refusal> {
        self.inputs.refusal()
    }

    /// Takes what the files that are open together have to give by now.
    fn join(&mut self, out: &mut Vec<u8>) {
        let Self { inputs, turn, buses, stream, .. } = self;
        while let Some(next) = inputs.next(buses, &mut stream.capture.date_ns, (*turn, &stream.capture.file)) {
            let (Next::Item(input, _) | Next::End(input)) = next;
            if input != *turn {
                for other in [*turn, input] {
                    if let Some(one) = inputs.get(other) {
                        std::mem::swap(&mut one.file, &mut stream.capture.file);
                    }
                }
                *turn = input;
            }
            match next {
                Next::Item(_, item) => stream.item(item, buses, out),
                Next::End(_) => {
                    let contents = inputs.get(input).map(|one| one.contents.clone()).unwrap_or_default();
                    stream.end_of_file(&contents, buses, out);
                }
            }
        }
    }

    /// The capture is over: what is still open, and what is known only now.
    pub fn finish(&mut self, out: &mut Vec<u8>) {
        for input in 0..self.inputs.count() {
            self.end_one(input, false, out);
        }
        self.stream.finish(&self.buses, out);
    }

    /// Takes one frame that no reader of this crate has read.
    pub fn push(&mut self, frame: Frame, out: &mut Vec<u8>) {
        self.stream.item(Item::Frame(frame), &self.buses, out);
    }

    /// Whether frames are held back until the next ones have shown what the recording did with them.
    pub fn holds(&self) -> bool {
        !self.stream.ahead.is_empty()
    }

    /// No more is there to be read at the moment: what was read is not held back any longer. For a pipe that has come
    /// to a rest; a file goes on at once.
    pub fn rest(&mut self, out: &mut Vec<u8>) {
        self.stream.settle(&self.buses, out);
    }

    /// It is `now_ns` on the clock of the frames' stamps, though no frame has come: what should have happened by now
    /// and has not. For live sources; a file's frames say the time themselves.
    pub fn advance(&mut self, now_ns: i64, out: &mut Vec<u8>) {
        self.stream.advance(now_ns, &self.buses, out);
    }

    /// What is known so far of the current file (the last one, between files; of several the one fed last) beyond its
    /// frames, as a JSON object: see [`jsonl::contents`].
    pub fn contents(&mut self) -> Vec<u8> {
        let mut out = Vec::new();
        let fed = if self.inputs.count() > 1 { self.fed } else { 0 };
        let known = self.inputs.get(fed).map(|one| match &one.reader {
            Some(reader) => reader.contents(),
            None => one.contents.clone(),
        });
        jsonl::contents(&mut out, &known.unwrap_or_default());
        out
    }

    /// Lines for standard error since the last call.
    pub fn take_complaints(&mut self) -> Vec<String> {
        std::mem::take(&mut self.stream.capture.complaints)
    }

    /// Batches of the tables since the last call: those that are complete, after [`Session::finish`] all. `flush`:
    /// those that run end now.
    pub fn take_batches(&mut self, flush: bool) -> Vec<Batch> {
        self.stream.output.take_batches(flush)
    }

    /// Bytes of transfers since the last call.
    pub fn take_extracted(&mut self) -> Vec<Extracted> {
        std::mem::take(&mut self.stream.decoding.extracted)
    }

    /// What the format that is written cannot hold, a line each that begins with the name of the file. `further`: what
    /// a writer outside of this crate has lost of what it was handed.
    pub fn losses(&self, file: &[u8], further: &[(Loss, u64)]) -> Vec<String> {
        let mut losses = self.stream.output.losses().cloned().unwrap_or_default();
        for (loss, count) in further {
            losses.add(*loss, *count);
        }
        let lost = losses.iter().filter(|(_, count)| *count > 0);
        lost.map(|(loss, count)| complaints::lost(self.lang, file, loss, count)).collect()
    }

    /// Hands out what is kept of the capture to be compared, after [`Self::finish`]; `None` in other formats.
    pub fn take_digest(&mut self) -> Option<Digest> {
        self.stream.output.take_digest()
    }

    /// As many frames were shown as [`Options::count`] allows: nothing further is taken.
    pub fn is_done(&self) -> bool {
        self.stream.output.is_done()
    }

    /// What was seen so far, as a JSON object: `frames` and `shown`; `findings` by severity, reported ones (of repeats
    /// that are not, the number is added by [`Self::finish`]); `transfers` of SDO by how they ended; `expectations`,
    /// null where there are none, with those `missed`; `buses`, each with `name`, `frames`, `error_frames` among them,
    /// and `dropped` ones.
    pub fn tally(&self) -> Vec<u8> {
        let (mut out, Stream { capture, output, tally, decoding, .. }) = (Vec::new(), &self.stream);
        tally.write(&mut out, (capture.frames, output.shown), decoding.expects(), &self.buses);
        out
    }

    /// What each node was seen to do so far, as a JSON list: see `tally.rs`.
    pub fn nodes(&self) -> Vec<u8> {
        let (mut out, Stream { capture, tally, decoding, .. }) = (Vec::new(), &self.stream);
        tally.nodes(&mut out, self.lang, decoding.buses(), (&self.buses, capture.last.t_ns));
        out
    }

    /// All that a view shows by now but the trace, as a JSON object (see `monitor/snapshot.rs`); empty in other
    /// formats.
    pub fn snapshot(&self) -> Vec<u8> {
        let Some(monitor) = self.stream.output.monitor() else { return Vec::new() };
        let (tally, decoding) = (self.tally(), &self.stream.decoding);
        let known = Known { tally: &tally, buses: decoding.buses(), diagnosis: decoding.diagnosis() };
        monitor.snapshot(self.stream.capture.view(&self.buses).jsonl, known)
    }

    /// What a view shows of one node beyond its row, as a JSON object (see `monitor/page.rs`); empty in other formats, and
    /// of a bus that there is not.
    pub fn page(&self, bus: &[u8], node: u8) -> Vec<u8> {
        let Some(monitor) = self.stream.output.monitor() else { return Vec::new() };
        let Some(place) = self.buses.names().position(|name| name == bus) else { return Vec::new() };
        monitor.page(
            self.stream.capture.view(&self.buses).jsonl,
            self.stream.decoding.buses(),
            (BusId(place as u8), node),
        )
    }

    /// Lines of the trace, oldest first; none in other formats.
    pub fn trace(&self, wanted: Wanted<'_>) -> Vec<Line> {
        let Some(monitor) = self.stream.output.monitor() else { return Vec::new() };
        monitor.trace(wanted, &self.buses, self.stream.capture.view(&self.buses).clock)
    }

    /// What the capture, which is over, has shown of its buses: that one of them is CANopen, where one is.
    pub fn nature(&self) -> Nature {
        self.stream.decoding.nature()
    }

    /// Frames so far: those that all files have given, those that were found in the file that was fed last.
    pub fn frames(&mut self) -> (u64, u64) {
        let fed = if self.inputs.count() > 1 { self.inputs.get(self.fed) } else { None };
        (self.stream.capture.frames, fed.map_or(self.stream.capture.file.found(), |one| one.frames))
    }
}

impl Stream {
    fn item(&mut self, mut item: Item, buses: &Buses, out: &mut Vec<u8>) {
        if self.output.is_done() {
            return;
        }
        if let Some(info) = self.output.info() {
            if let Item::Frame(frame) = &item {
                self.capture.count(frame);
            }
            return info.take(&item);
        }
        if !matches!(item, Item::Frame(_) | Item::Unreadable { .. } | Item::Until { .. }) {
            self.settle(buses, out);
            if self.output.is_done() {
                return;
            }
        }
        match item {
            Item::Frame(ref mut frame) => self.place(frame, buses, out),
            Item::Marker(marker) => self.marker(marker, buses, out),
            Item::Unreadable { place, reason } => self.capture.unreadable(place, reason),
            Item::Damaged(damage) => self.damaged(damage, buses, out),
            Item::Gap { bus, away } => self.gap((bus, away), buses, out),
            Item::Until { now_ns } => self.until(now_ns, buses, out),
        }
    }

    /// Gives a frame its place in the capture and in the recording, and hands on what is known by that.
    fn place(&mut self, frame: &mut Frame, buses: &Buses, out: &mut Vec<u8>) {
        self.capture.place(frame);
        let seen = self.decoding.observe(frame, buses);
        let before = self.capture.before(frame);
        if self.ahead.is_empty() && self.decoding.is_decided() && !self.decoding.is_ambiguous(frame) {
            self.capture.take(frame, None);
            return self.frame(frame, (before.as_ref(), None), seen.as_ref(), buses, out);
        }
        self.ahead.hold(Placed { frame: *frame, before, seen }, self.capture.origin());
        self.release(false, buses, out);
    }

    /// Hands on the frames of which it is known what the recording did with them, and what comes next on their SDO
    /// channel where that matters. `over`: nothing more comes.
    fn release(&mut self, over: bool, buses: &Buses, out: &mut Vec<u8>) {
        let before = self.decoding.undecided_since().unwrap_or(u64::MAX);
        while let Some(first) = self.ahead.first_before(before) {
            let next = match self.decoding.is_ambiguous(first) {
                true => self.ahead.next(|one, other| self.decoding.is_of_channel(one, other)),
                false => Behind::None,
            };
            let next = match next {
                Behind::Frame(next) => Some(next),
                Behind::Open if !over => break,
                Behind::Open | Behind::None => None,
            };
            let Some((Placed { frame, before, seen }, origin)) = self.ahead.take() else { break };
            if !self.output.is_done() {
                self.capture.take(&frame, Some(origin));
                self.frame(&frame, (before.as_ref(), next.as_deref()), seen.as_ref(), buses, out);
            }
        }
        self.capture.caught_up();
    }

    /// Nothing is behind the frames that wait by which more would be known: they are taken by what is.
    fn settle(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.decoding.settle();
        self.release(true, buses, out);
    }

    fn frame(
        &mut self,
        frame: &Frame,
        (before, next): (Option<&FrameRef>, Option<&Frame>),
        seen: Option<&(When, Happened)>,
        buses: &Buses,
        out: &mut Vec<u8>,
    ) {
        let holed = self.decoding.is_behind_hole(frame);
        let stepped = seen.is_some_and(|(_, happened)| happened.step_ns.is_some());
        if holed && let Some(before) = before {
            self.output.gap(frame.bus, false);
            self.decoding.lost(frame.bus, *before, buses);
            self.aside(buses, out);
        }
        self.decoding.step(frame, seen, next, buses);
        if (holed || stepped)
            && let Some((before, apart)) = before.and_then(|before| Some((*before, frame.reference().since(*before)?)))
        {
            if holed {
                self.decoding.find(frame, Cap007::Silent { silence: apart }.into(), before);
            }
            if stepped {
                self.decoding.find(frame, Cap006::Back { back: apart.saturating_neg() }.into(), before);
            }
        }
        self.decoding.diagnosed(frame);
        if self.output.has_tables() {
            let sync = self.decoding.sync(frame.bus);
            self.output.rows(self.capture.view(buses), frame, &mut self.decoding.events, sync);
        }
        self.decoding.fold();
        self.tally.frame(frame, &self.decoding.events);
        self.output.frame(out, self.capture.view(buses), frame, &mut self.decoding.events);
        self.tell(buses, out);
        self.decoding.clear(buses);
    }

    /// Tells of incidents that begin to show, and of those that are over.
    #[inline]
    fn tell(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        if !self.output.tells() {
            return;
        }
        for (phase, id) in self.decoding.changes() {
            if let Some(diagnosis) = self.decoding.diagnosis() {
                self.output.incident(out, self.capture.view(buses), diagnosis, (phase, id));
            }
        }
    }

    fn marker(&mut self, marker: Marker, buses: &Buses, out: &mut Vec<u8>) {
        self.output.marker(out, self.capture.view(buses), &marker);
        if let Marker::Start { date_ns } = marker {
            return self.capture.dated(date_ns);
        }
        if let Marker::Dropped { bus, count, .. } = marker {
            self.tally.dropped(bus, count);
            self.decoding.lost(bus, self.capture.last, buses);
        }
        if let Marker::LeftOut { .. } = marker {
            self.decoding.all_lost(self.capture.last, buses);
        }
        if let Marker::Error { bus, place, .. } = marker {
            let at = self.capture.behind(bus, place.line());
            self.decoding.bare_error(bus, at, buses);
        }
        let finding = self.capture.marker(&marker, buses);
        self.report(finding.as_ref(), buses, out);
        self.aside(buses, out);
    }

    /// A live bus is away: across the gap nothing is judged, and nothing is wrong.
    fn gap(&mut self, (bus, away): (BusId, bool), buses: &Buses, out: &mut Vec<u8>) {
        self.output.gap(bus, away);
        self.capture.gap();
        self.decoding.lost(bus, self.capture.last, buses);
        self.aside(buses, out);
    }

    /// Live buses have given all until `now_ns`.
    fn until(&mut self, now_ns: i64, buses: &Buses, out: &mut Vec<u8>) {
        self.advance(now_ns, buses, out);
        self.output.until(out, now_ns);
    }

    /// A part of the file is lost: across it nothing is judged on any bus.
    fn damaged(&mut self, damage: Damage, buses: &Buses, out: &mut Vec<u8>) {
        let finding = self.capture.damaged(damage);
        if finding.code == Code::Cap004 {
            self.decoding.all_lost(self.capture.last, buses);
        }
        self.report(Some(&finding), buses, out);
        self.aside(buses, out);
    }

    fn end_of_file(&mut self, contents: &Contents, buses: &Buses, out: &mut Vec<u8>) {
        self.capture.end_of_complaints();
        if let Some(info) = self.output.info() {
            return jsonl::info(out, self.capture.view(buses).jsonl, info, contents);
        }
        if self.capture.file.unreadable.count > 0 {
            self.settle(buses, out);
        }
        let (unreadable, finding) = self.capture.end();
        if self.capture.file.frames > 0 {
            self.output.end_of_file(unreadable.count);
        }
        self.report(finding.as_ref(), buses, out);
    }

    fn advance(&mut self, now_ns: i64, buses: &Buses, out: &mut Vec<u8>) {
        if self.output.is_done() {
            return;
        }
        self.decoding.pass(now_ns);
        self.release(self.ahead.is_over(now_ns), buses, out);
        // What frames that wait have to say comes first.
        if self.ahead.is_empty() && !self.output.is_done() {
            self.decoding.advance(now_ns, self.capture.last, buses);
        }
        self.output.advance(self.capture.view(buses), now_ns);
        self.aside(buses, out);
    }

    fn finish(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.settle(buses, out);
        self.decoding.finish(self.capture.last, buses);
        self.aside(buses, out);
        let diagnosed = self.decoding.finish_diagnosis(self.capture.last, buses);
        self.aside(buses, out);
        self.decoding.counted(self.capture.last);
        self.write_aside(buses, out);
        if let Some(diagnosis) = self.decoding.diagnosis().filter(|_| diagnosed) {
            self.output.diagnosis(out, self.capture.view(buses), diagnosis);
        }
        if self.capture.frames > 0 {
            self.capture.finish(self.decoding.absent(buses), self.output.is_idle());
            self.output.finish(out, self.capture.view(buses));
        }
        self.output.close(self.capture.view(buses));
    }

    fn report(&mut self, finding: Option<&Finding>, buses: &Buses, out: &mut Vec<u8>) {
        if let Some(finding) = finding {
            self.tally.finding(finding);
            self.decoding.diagnosed_finding(finding);
            self.output.finding(out, self.capture.view(buses), finding);
        }
    }

    /// What belongs to no frame at hand.
    fn aside(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.output.aside_rows(self.capture.view(buses), &self.decoding.events);
        self.decoding.diagnosed_aside();
        self.decoding.fold();
        self.write_aside(buses, out);
    }

    /// The same of what is not only counted, but for tables.
    fn write_aside(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        self.tally.events(&self.decoding.events);
        self.output.aside(out, self.capture.view(buses), &self.decoding.events);
        self.tell(buses, out);
        self.decoding.clear(buses);
    }
}
