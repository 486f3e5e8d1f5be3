//! One capture, from the bytes of its files to lines: the loop.
//!
//! bytes -> reader -> frame -> bus -> events -> output. `capture` knows which frame it is and what is wrong with its
//! file, `decoding` what it means, `output` writes it down; this file hands on from one to the next. It does no I/O
//! and reads no clock; it must not know a service or a format by name.

mod ahead;
mod capture;
mod decoding;
mod inventory;
mod judged;
mod options;
mod pipeline;
mod rows;
mod sink;
mod sinks;
mod stream;
mod subject;
mod tally;

use std::num::NonZero;
use std::thread;

use self::ahead::Ahead;
use self::capture::Capture;
use self::decoding::Decoding;
use self::judged::Judged;
use self::pipeline::Piece;
use self::sink::{CHANGES, DIAGNOSIS, Digested, ITEMS, Notice};
use self::sinks::Sinks;
use self::stream::Stream;
use self::tally::Tally;
use crate::bytes::frame::{BusId, Buses, Frame};
use crate::bytes::inputs::{Inputs, Next, Refusal};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{Damage, InputFormat as Input, Item, Reader, Settings};
use crate::bytes::writers::{Loss, Writer};
use crate::evidence::order::Order;
use crate::evidence::services::Nature;
use crate::tables::columns::{Batch, Columns};
use crate::tables::jsonl;
use crate::views::diff::digest::Digest;
use crate::views::monitor::{Known, Line, Monitor, Wanted};
use crate::words::{Lang, complaints};

pub use self::decoding::Extracted;
pub use self::inventory::known_pdos;
pub use self::options::{Encoding, Format, Knowledge, Options, Output, Rows, Scope, Writing};

/// A capture being read.
#[derive(Debug)]
pub struct Session {
    lang: Lang,
    /// Settings of the readers.
    reading: Settings,
    inputs: Inputs,
    /// The file that has its turn: what is kept of it is with the stream.
    turn: usize,
    /// The file that was fed last.
    fed: usize,
    /// Threads that share the work on a piece of a file.
    threads: usize,
    buses: Buses,
    stream: Stream,
}

impl Session {
    /// A session at the beginning of a capture.
    pub fn new(options: Options) -> Self {
        let sinks = Sinks::new(&options);
        let Options { lang, reading, known, writing, threads, .. } = options;
        // Of frames in JSON lines the time is that of the capture.
        let time = writing.time.filter(|_| !writing.outputs.contains(&Output::json(Rows::Frames)));
        let mut decoding = Decoding::new(known.network, writing.extract, sinks.is_blind(), sinks.folds());
        if let Some(expected) = known.expectations {
            decoding.expect(&expected);
        }
        if sinks.want(DIAGNOSIS | CHANGES) {
            decoding.diagnose();
        }
        decoding.count_at_once(!sinks.has_beside());
        decoding.publish_news(sinks.defers() && !sinks.has_beside());
        Self {
            lang,
            reading,
            inputs: Inputs::default(),
            turn: 0,
            fed: 0,
            threads: threads
                .unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZero::get))
                .min(pipeline::MOST),
            buses: Buses::default(),
            stream: Stream {
                capture: Capture::new(lang, time),
                order: Order::default(),
                ahead: Ahead::default(),
                decoding,
                judged: Judged::default(),
                sinks,
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
        if !regular || reader.is_live() {
            self.stream.order.pass_first();
        }
        self.inputs.open(input == 0, name, reader);
        let format = Input::NAMES.iter().find(|row| row.1 == format).map_or("", |row| row.0);
        let Stream { capture, sinks, .. } = &mut self.stream;
        let begin = Notice::Begin { file: name, format, first: input == 0 };
        sinks.take(&mut Vec::new(), &capture.view(&self.buses), begin);
        if input == 0 {
            capture.begin(name);
            (self.turn, self.fed) = (0, 0);
            if sinks.want(ITEMS) {
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
            let Some(mut reader) = alone.reader.take() else { return };
            alone.feeds(bytes);
            let threads = if stream.sinks.want(ITEMS) || reader.is_live() { 1 } else { self.threads };
            let piece = Piece { reader: &mut reader, bytes, buses };
            if !pipeline::feed(piece, threads, stream, &mut |item| alone.counts(item), out) {
                reader.feed(bytes, buses, &mut |item, buses| {
                    alone.counts(item);
                    stream.item(item, buses, out);
                });
            }
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

    /// Marks the beginning of bytes under a check sum of their own: if it fails, earlier bytes are sound.
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
            let mut sink = |item: &mut Item, buses: &Buses| {
                alone.counts(item);
                stream.item(item, buses, out);
            };
            if interrupted || damaged {
                reader.interrupt(buses, &mut sink);
            } else {
                reader.finish(buses, &mut sink);
            }
            if let Some(damage) = alone.told() {
                stream.item(&mut Item::Damaged(damage), buses, out);
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
                Next::Item(_, mut item) => stream.item(&mut item, buses, out),
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
        self.stream.item(&mut Item::Frame(frame), &self.buses, out);
    }

    /// Returns true if frames are held back until later ones show the effect of the recording on them, or their layout.
    pub fn holds(&self) -> bool {
        self.inputs.holds() || !(self.stream.ahead.is_empty() && self.stream.order.is_empty())
    }

    /// No more is there to be read at the moment: what was read is not held back any longer. For a pipe that has come
    /// to a rest; a file goes on at once.
    pub fn rest(&mut self, out: &mut Vec<u8>) {
        let Self { inputs, buses, stream, .. } = self;
        if let Some(alone) = inputs.alone()
            && let Some(mut reader) = alone.reader.take()
        {
            reader.rest(buses, &mut |item, buses| {
                alone.counts(item);
                stream.item(item, buses, out);
            });
            alone.reader = Some(reader);
        }
        self.stream.settle(false, &self.buses, out);
    }

    /// It is `now_ns` on the clock of the frames' stamps, though no frame has come: what should have happened by now
    /// and has not. For live sources; a file's frames say the time themselves.
    pub fn advance(&mut self, now_ns: Ns, out: &mut Vec<u8>) {
        self.stream.advance(now_ns, &self.buses, out);
    }

    /// Returns the contents so far of the current file (the last one, between files; of several the one fed last) beyond its
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
        self.stream.sinks.find_mut::<Columns>().map_or_else(Vec::new, |columns| columns.take(flush))
    }

    /// Bytes of transfers since the last call.
    pub fn take_extracted(&mut self) -> Vec<Extracted> {
        std::mem::take(&mut self.stream.decoding.extracted)
    }

    /// Returns a line, beginning with the name of the file, for each kind of loss in the written format. `further`:
    /// losses of a writer outside this crate.
    pub fn losses(&self, file: &[u8], further: &[(Loss, u64)]) -> Vec<String> {
        let mut losses = self.stream.sinks.find::<Writer>().map(|writer| writer.losses().clone()).unwrap_or_default();
        for (loss, count) in further {
            losses.add(*loss, *count);
        }
        let lost = losses.iter().filter(|(_, count)| *count > 0);
        lost.map(|(loss, count)| complaints::lost(self.lang, file, loss, count)).collect()
    }

    /// Hands out what is kept of the capture to be compared, after [`Self::finish`]; `None` in other formats.
    pub fn take_digest(&mut self) -> Option<Digest> {
        self.stream.sinks.find_mut::<Digested>().map(|one| std::mem::take(&mut one.digest))
    }

    /// As many frames were shown as [`Scope::limit`] allows: nothing further is taken.
    pub fn is_done(&self) -> bool {
        self.stream.sinks.is_done()
    }

    /// Returns the counts so far, as a JSON object: `frames` and `shown`; `findings` by severity, reported ones (of repeats
    /// that are not, the number is added by [`Self::finish`]); `transfers` of SDO by how they ended; `expectations`,
    /// null where there are none, with those `missed`; `buses`, each with `name`, `frames`, `error_frames` among them,
    /// and `dropped` ones.
    pub fn tally(&self) -> Vec<u8> {
        let (mut out, Stream { capture, sinks, tally, decoding, .. }) = (Vec::new(), &self.stream);
        tally.write(&mut out, (capture.frames, sinks.shown), decoding.expects(), &self.buses);
        out
    }

    /// Returns the counts of each node so far, as a JSON list: see `tally.rs`.
    pub fn nodes(&self) -> Vec<u8> {
        let (mut out, Stream { capture, tally, decoding, .. }) = (Vec::new(), &self.stream);
        tally.nodes(&mut out, self.lang, decoding.buses(), (&self.buses, capture.last.t_ns));
        out
    }

    /// All that a view shows by now but the trace, as a JSON object (see `monitor/snapshot.rs`); empty in other
    /// formats.
    pub fn snapshot(&mut self) -> Vec<u8> {
        let by_now = self.stream.decoding.diagnosis_by_now();
        let Some(monitor) = self.stream.sinks.find::<Monitor>() else { return Vec::new() };
        let (tally, decoding) = (self.tally(), &self.stream.decoding);
        let known = Known {
            tally: &tally,
            buses: decoding.buses(),
            diagnosis: decoding.diagnosis(),
            by_now: by_now.as_ref().or(decoding.diagnosis()),
        };
        monitor.snapshot(self.stream.capture.view(&self.buses).jsonl, known)
    }

    /// Returns the page of one node in a view, as a JSON object (see `monitor/page.rs`); empty in other formats, and
    /// of a bus that there is not.
    pub fn page(&self, bus: &[u8], node: u8) -> Vec<u8> {
        let Some(monitor) = self.stream.sinks.find::<Monitor>() else { return Vec::new() };
        let Some(place) = self.buses.names().position(|name| name == bus) else { return Vec::new() };
        monitor.page(
            self.stream.capture.view(&self.buses).jsonl,
            self.stream.decoding.buses(),
            (BusId(place as u8), node),
        )
    }

    /// Lines of the trace, oldest first; none in other formats.
    pub fn trace(&self, wanted: Wanted<'_>) -> Vec<Line> {
        let Some(monitor) = self.stream.sinks.find::<Monitor>() else { return Vec::new() };
        monitor.trace(wanted, &self.buses, self.stream.capture.view(&self.buses).clock)
    }

    /// Returns the nature of the buses at the end of the capture: CANopen if one of them is.
    pub fn nature(&self) -> Nature {
        self.stream.decoding.nature()
    }

    /// The date from which relative stamps count, in ns since 1970, where a file so far has one.
    pub fn date_ns(&self) -> Option<Ns> {
        self.stream.capture.date_ns.filter(|date_ns| *date_ns != Ns::ZERO)
    }

    /// Frames so far: those that all files have given, those that were found in the file that was fed last.
    pub fn frames(&mut self) -> (u64, u64) {
        let fed = if self.inputs.count() > 1 { self.inputs.get(self.fed) } else { None };
        (self.stream.capture.frames, fed.map_or(self.stream.capture.file.found(), |one| one.frames))
    }
}
