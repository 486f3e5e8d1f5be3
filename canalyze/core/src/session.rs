//! One capture, from the bytes of its files to lines: the loop.
//!
//! bytes -> reader -> frame -> bus -> events -> rendering. It owns the reader, the buses' state and what is said
//! on standard error. It does no I/O and reads no clock; it must not know a service or a format by name.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::bus::Bus;
use crate::context::{Chunk, Context};
use crate::event::{Event, What};
use crate::filter::Filter;
use crate::finding::{Code, Facts, Finding, Quantity};
use crate::frame::{BusId, Buses, Frame, FrameRef, Stamp};
use crate::info::Info;
use crate::inputs::{ABSOLUTE_NS, File, Inputs, Next, Refusal, Unreadable};
use crate::network::Network;
use crate::readers::candump::Stamps;
use crate::readers::mcap::Choice;
use crate::readers::{Contents, Damage, DamageKind, Format as Input, Item, Marker, Place, Reader, Settings};
use crate::render::jsonl::{self, Setting};
use crate::render::text::{Lines, Time};

use crate::render::signals::Signals;
use crate::repeats::Repeats;
use crate::select::Select;
use crate::services::sdo::transfer::Status;
use crate::services::sdo::wire::Mux;
use crate::summary::Summary;
use crate::text::{Depth, Lang, complaints};
use crate::writers::{self, Loss, Writer};

/// Unreadable lines of a file that are named one by one as they come.
const NAMED: u64 = 5;
/// What a file may begin before the end of the one before it: buses are not captured in strict order.
const STEP_BACK_NS: i64 = 10_000_000;

/// What comes out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Annotated lines in candump's console form.
    #[default]
    Text,
    /// JSON lines: frames, notes, findings, transfers.
    Jsonl,
    /// JSON lines of SDO transfers only.
    Transfers,
    /// JSON lines of decoded signals only.
    Signals,
    /// CSV of decoded signals.
    SignalsCsv,
    /// JSON lines of figures, all at the end.
    Summary,
    /// JSON lines of what each file is, one a file; nothing is decoded.
    Info,
    /// The frames themselves, in another capture format.
    Convert(writers::Format),
}

/// How a capture is read and shown.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The language.
    pub lang: Lang,
    /// What comes out.
    pub format: Format,
    /// How much a line says.
    pub depth: Depth,
    /// What small stamps mean.
    pub stamps: Stamps,
    /// What of an MCAP file is read, and how.
    pub mcap: Choice,
    /// How time is shown; as it came, by default.
    pub time: Option<Time>,
    /// Which frames are shown.
    pub filter: Filter,
    /// Whether the bytes of SDO transfers are handed out.
    pub extract: bool,
    /// What is known of the network beforehand.
    pub network: Arc<Network>,
    /// Which signals are listed.
    pub select: Select,
    /// How the format that is written is written.
    pub writing: writers::Settings,
}

/// Bytes of a transfer for a file of its own.
#[derive(Clone, Debug)]
pub struct Extracted {
    /// A safe file name: letters, digits, `.`, `_`, `-`.
    pub name: String,
    /// The next bytes.
    pub bytes: Vec<u8>,
    /// How the transfer ended; `None` while it runs.
    pub status: Option<Status>,
}

/// A capture being read.
#[derive(Debug)]
pub struct Session {
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
    options: Options,
    lines: Lines,
    signals: Signals,
    summary: Summary,
    state: Vec<Bus>,
    info: Info,
    /// The file at hand.
    file: File,
    /// The file before it, until its first frame.
    before: Option<Vec<u8>>,
    frames: u64,
    /// Frames or transfers that passed the filter.
    shown: u64,
    /// Time of the first frame.
    start_ns: Option<i64>,
    /// The date from which the capture's stamps count, where its first dated file says one.
    date_ns: Option<i64>,
    /// Digits after the point of the last stamp.
    decimals: u8,
    last: FrameRef,
    next_transfer: u64,
    events: Vec<Event>,
    chunks: Vec<Chunk>,
    /// Which nodes had a frame, a bit each, by bus.
    seen: Vec<u128>,
    repeats: Repeats,
    complaints: Vec<String>,
    extracted: Vec<Extracted>,
    writer: Writer,
    /// Nobody asks what frames mean, so no state is kept.
    blind: bool,
}

impl Session {
    /// A session at the beginning of a capture.
    pub fn new(options: Options) -> Self {
        let lines = Lines::new(options.lang, options.depth, options.time);
        let written = if let Format::Convert(format) = options.format { format } else { Default::default() };
        let writer = Writer::new(written, &options.writing);
        let blind = matches!(options.format, Format::Convert(_)) && options.filter.is_plain() && !writer.wants_events();
        Self {
            inputs: Inputs::default(),
            turn: 0,
            fed: 0,
            buses: Buses::default(),
            stream: Stream {
                signals: Signals::new(options.lang, options.format == Format::SignalsCsv, options.select.clone()),
                summary: Summary::new(Arc::clone(&options.network)),
                options,
                lines,
                state: Vec::new(),
                info: Info::default(),
                file: File::default(),
                before: None,
                frames: 0,
                shown: 0,
                start_ns: None,
                date_ns: None,
                decimals: 9,
                last: FrameRef::default(),
                next_transfer: 0,
                events: Vec::new(),
                chunks: Vec::new(),
                seen: Vec::new(),
                repeats: Repeats::default(),
                complaints: Vec::new(),
                extracted: Vec::new(),
                writer,
                blind,
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
        let Options { stamps, mcap, .. } = &self.stream.options;
        let reader = Reader::new(format, &Settings { stamps: *stamps, regular, mcap: mcap.clone() });
        self.inputs.open(input == 0, name, reader);
        self.stream.writer.source(name, Input::NAMES.iter().find(|row| row.1 == format).map_or("", |row| row.0));
        if input == 0 {
            let before = std::mem::replace(&mut self.stream.file, File { name: name.to_vec(), ..File::default() });
            self.stream.before = (before.frames > 0).then_some(before.name);
            (self.turn, self.fed) = (0, 0);
            if self.stream.options.format == Format::Info {
                (self.stream.info, self.buses) = (Info::default(), Buses::default());
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
            let Some(reader) = &mut alone.reader else { return };
            reader.feed(bytes, buses, &mut |item, buses| stream.item(item, buses, out));
        } else {
            inputs.feed(input, bytes);
            self.fed = input;
            self.join(out);
        }
    }

    /// The bytes of a file go on no further than here, for this reason; it is told when the file ends.
    pub fn damaged(&mut self, input: usize, damage: Damage) {
        if let Some(one) = self.inputs.get(input) {
            one.damage = Some(damage);
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
            let mut sink = |item, buses: &Buses| stream.item(item, buses, out);
            if interrupted || alone.damage.is_some() {
                reader.interrupt(buses, &mut sink);
            } else {
                reader.finish(buses, &mut sink);
            }
            if let Some(damage) = alone.damage.take() {
                sink(Item::Damaged(damage), buses);
            }
            alone.contents = reader.contents();
            stream.end_of_file(&alone.contents, buses, out);
        } else {
            inputs.end(input, interrupted);
            self.fed = input;
            self.join(out);
        }
    }

    /// The file that has to be fed before anything can go on; `None` when all are over or cannot be joined.
    pub fn wants(&self) -> Option<usize> {
        self.inputs.wants()
    }

    /// Why the files that have begun cannot be joined by time.
    pub fn refusal(&self) -> Option<Refusal> {
        self.inputs.refusal()
    }

    /// Takes what the files that are open together have to give by now.
    fn join(&mut self, out: &mut Vec<u8>) {
        let Self { inputs, turn, buses, stream, .. } = self;
        while let Some(next) = inputs.next(buses, &mut stream.date_ns, (*turn, &stream.file)) {
            let (Next::Item(input, _) | Next::End(input)) = next;
            if input != *turn {
                for other in [*turn, input] {
                    if let Some(one) = inputs.get(other) {
                        std::mem::swap(&mut one.file, &mut stream.file);
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
        std::mem::take(&mut self.stream.complaints)
    }

    /// Bytes of transfers since the last call.
    pub fn take_extracted(&mut self) -> Vec<Extracted> {
        std::mem::take(&mut self.stream.extracted)
    }

    /// What the format that is written cannot hold, a line each that begins with the name of the file. `further`: what
    /// a writer outside of this crate has lost of what it was handed.
    pub fn losses(&self, file: &[u8], further: &[(Loss, u64)]) -> Vec<String> {
        let mut losses = self.stream.writer.losses().clone();
        for (loss, count) in further {
            losses.add(*loss, *count);
        }
        let lost = losses.iter().filter(|(_, count)| *count > 0);
        lost.map(|(loss, count)| complaints::lost(self.stream.options.lang, file, loss, count)).collect()
    }

    /// Frames so far: those that all files have given, those that were read of the file that was fed last.
    pub fn frames(&mut self) -> (u64, u64) {
        let fed = if self.inputs.count() > 1 { self.inputs.get(self.fed) } else { None };
        (self.stream.frames, fed.map_or(self.stream.file.frames, |one| one.frames))
    }
}

impl Stream {
    fn item(&mut self, item: Item, buses: &Buses, out: &mut Vec<u8>) {
        if self.options.format == Format::Info {
            let frame = matches!(item, Item::Frame(_));
            self.frames += u64::from(frame);
            self.file.frames += u64::from(frame);
            return self.info.take(&item);
        }
        match item {
            Item::Frame(frame) => self.frame(frame, buses, out),
            Item::Marker(marker) => self.marker(marker, buses, out),
            Item::Unreadable { place, reason } => {
                self.file.unreadable.add(place);
                if self.file.unreadable.count <= NAMED {
                    self.complaints.push(complaints::unreadable(self.options.lang, &self.file.name, place, reason));
                }
            }
            Item::Damaged(damage) => self.damaged(damage, buses, out),
        }
    }

    fn frame(&mut self, mut frame: Frame, buses: &Buses, out: &mut Vec<u8>) {
        self.frames += 1;
        self.file.frames += 1;
        frame.no = self.frames;
        if let (Some(t_ns), Some(date_ns), false) = (frame.t_ns, self.date_ns, self.file.dated)
            && t_ns >= ABSOLUTE_NS
        {
            // A file of times of day behind one whose stamps count from a date.
            (self.file.shift_ns, self.file.dated) = (date_ns.saturating_neg(), true);
        }
        if self.file.shift_ns != 0 {
            let shift = |ns: i64| ns.saturating_add(self.file.shift_ns);
            frame.t_ns = frame.t_ns.map(shift);
            frame.stamp = frame.stamp.map(|stamp| Stamp { ns: shift(stamp.ns), ..stamp });
        }
        self.decimals = frame.stamp.map_or(9, |stamp| stamp.decimals);
        if let Some(before) = self.before.take() {
            self.boundary(&before, &frame);
        }
        self.last = frame.reference();
        self.on_bus(frame.bus, buses, |bus, cx| bus.step(&frame, cx));
        self.fold();
        let (service, node) = self.events.first().map_or(("foreign", None), |event| match &event.what {
            What::Message(message) => (message.service(), event.node),
            What::Pdo(_) | What::Mpdo(_) => ("pdo", event.node),
            _ => ("sdo", event.node),
        });
        self.see(frame.bus, node);
        let start_ns = *self.start_ns.get_or_insert(frame.t_ns.unwrap_or(0));
        if self.options.format == Format::Transfers {
            self.transfers(buses, out);
        } else if self.options.filter.shows(&frame, service, node, buses, start_ns) {
            self.shown += 1;
            let setting = Setting { lang: self.options.lang, file: &self.file.name, buses, decimals: self.decimals };
            match self.options.format {
                Format::Text => self.lines.frame(out, &frame, &self.events, buses),
                Format::Signals | Format::SignalsCsv => {
                    self.signals.frame(out, setting, &frame, &self.events);
                }
                Format::Summary => self.summary.frame(&frame, &self.events),
                Format::Convert(_) => {
                    let setting = self.writing(buses);
                    self.writer.frame(out, setting, &frame);
                    self.writer.events(out, setting, Some(&frame), &self.events);
                }
                Format::Jsonl | Format::Transfers | Format::Info => jsonl::frame(out, setting, &frame, &self.events),
            }
        }
        self.extract(buses);
        self.events.clear();
    }

    /// The first frame of a file that follows another: files that are named out of order are worth a word.
    fn boundary(&mut self, before: &[u8], frame: &Frame) {
        let (Some(end_ns), Some(t_ns)) = (self.last.t_ns, frame.t_ns) else { return };
        let back_ns = end_ns.saturating_sub(t_ns);
        if back_ns > STEP_BACK_NS {
            self.complaints.push(complaints::step_back(self.options.lang, &self.file.name, before, back_ns));
        }
    }

    fn marker(&mut self, marker: Marker, buses: &Buses, out: &mut Vec<u8>) {
        if let Format::Convert(_) = self.options.format {
            self.writer.marker(out, self.writing(buses), &marker);
        }
        let (code, place, facts, bus) = match marker {
            Marker::Start { date_ns } => {
                // Behind a file of times of day, what counts from a date becomes such too.
                let of_day = self.last.t_ns.is_some_and(|t_ns| t_ns >= ABSOLUTE_NS);
                self.file.shift_ns =
                    date_ns.saturating_sub(*self.date_ns.get_or_insert(if of_day { 0 } else { date_ns }));
                self.file.dated = true;
                return;
            }
            Marker::Dropped { bus, count, total, place } => {
                self.on_bus(bus, buses, |bus, cx| bus.lost(None, false, cx));
                (Some(Code::Cap002), place, Facts::Dropped { count, total }, bus)
            }
            Marker::Backward { place } => (Some(Code::Cap003), place, Facts::None, BusId(0)),
            Marker::Error { bus, place, .. } => (None, place, Facts::None, bus),
        };
        if self.options.format == Format::Text {
            self.lines.marker(out, &marker, buses);
        }
        if self.options.format == Format::Summary {
            self.summary.marker(&marker);
        }
        let finding = code.map(|code| self.capture_finding(code, place, facts, bus));
        self.complaints.push(complaints::marker(self.options.lang, &self.file.name, place, finding.as_ref()));
        if let Some(finding) = finding {
            self.tell(&finding, buses, out);
        }
        self.aside(buses, out);
    }

    /// A part of the file is lost: across it nothing is judged on any bus.
    fn damaged(&mut self, damage: Damage, buses: &Buses, out: &mut Vec<u8>) {
        let Damage { place, kind, bytes, frames } = damage;
        let (code, face) = match kind {
            DamageKind::Cut => (Code::Cap005, 0),
            DamageKind::Checksum => (Code::Cap004, 0),
            DamageKind::Structure => (Code::Cap004, 1),
            DamageKind::Compression => (Code::Cap004, 2),
            DamageKind::Rest => (Code::Cap004, 3),
            DamageKind::Undefined => (Code::Cap004, 4),
        };
        // The same with the number of frames.
        let face = if frames.is_some() && code == Code::Cap004 && face < 3 { face + 5 } else { face };
        if code == Code::Cap004 {
            for index in 0..self.state.len() {
                self.on_bus(BusId(index as u8), buses, |bus, cx| bus.lost(None, false, cx));
            }
        }
        let counted = |name, count: Option<u64>| count.map(|count| (name, Quantity::Count(count)));
        let (Place::Line(at) | Place::Byte(at)) = place;
        let measured = [counted("offset", Some(at)), counted("bytes", bytes), counted("frames", frames)];
        let measured: Vec<_> = measured.into_iter().flatten().collect();
        let finding = self.capture_finding(code, place, Facts::told(face, &measured), BusId(0));
        self.complaints.push(complaints::marker(self.options.lang, &self.file.name, place, Some(&finding)));
        self.tell(&finding, buses, out);
        self.aside(buses, out);
    }

    /// A finding about the capture. Where the file has no lines it names the last frame before it.
    fn capture_finding(&self, code: Code, place: Place, facts: Facts, bus: BusId) -> Finding {
        let at = match place {
            Place::Line(line) => FrameRef { line: Some(line), ..FrameRef::default() },
            Place::Byte(_) => self.last,
        };
        Finding { code, at, cause: None, bus, node: None, object: None, facts }
    }

    /// A finding about the capture, which belongs to no frame.
    fn tell(&mut self, finding: &Finding, buses: &Buses, out: &mut Vec<u8>) {
        match self.options.format {
            Format::Jsonl => jsonl::finding(out, self.setting(buses), finding),
            Format::Summary => self.summary.finding(finding),
            Format::Convert(_) => self.writer.finding(out, self.writing(buses), finding),
            Format::Text | Format::Transfers | Format::Signals | Format::SignalsCsv | Format::Info => {}
        }
    }

    fn end_of_file(&mut self, contents: &Contents, buses: &Buses, out: &mut Vec<u8>) {
        if self.options.format == Format::Info {
            return jsonl::info(out, self.setting(buses), &self.info, contents);
        }
        let unreadable = std::mem::take(&mut self.file.unreadable);
        if self.file.frames > 0 {
            self.summary.file(unreadable.count);
        }
        if unreadable.count == 0 || self.file.frames == 0 {
            return;
        }
        let facts = Facts::Lines { count: unreadable.count };
        let first = unreadable.first.unwrap_or(Place::Line(0));
        let finding = self.capture_finding(Code::Cap001, first, facts, BusId(0));
        if unreadable.count > NAMED {
            let Unreadable { count, ranges, .. } = &unreadable;
            self.complaints.push(complaints::unreadable_lines(
                self.options.lang,
                &self.file.name,
                first,
                *count,
                ranges,
            ));
        }
        self.tell(&finding, buses, out);
    }

    fn advance(&mut self, now_ns: i64, buses: &Buses, out: &mut Vec<u8>) {
        for index in 0..self.state.len() {
            self.on_bus(BusId(index as u8), buses, |bus, cx| bus.advance(now_ns, cx));
        }
        self.fold();
        self.aside(buses, out);
    }

    fn finish(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        for index in 0..self.state.len() {
            self.on_bus(BusId(index as u8), buses, Bus::finish);
        }
        self.fold();
        self.repeats.finish(self.last, &mut self.events);
        self.aside(buses, out);
        if self.frames > 0 && !self.blind {
            self.absent(buses);
        }
        if self.shown == 0 && self.frames > 0 && !self.options.filter.is_empty() {
            self.complaints.push(complaints::nothing_shown(self.options.lang, self.frames));
        }
        match self.options.format {
            Format::Summary if self.shown > 0 => jsonl::summary::write(out, self.setting(buses), &self.summary),
            Format::Convert(_) if self.frames > 0 => self.writer.finish(out, self.writing(buses)),
            _ => {}
        }
    }

    fn see(&mut self, bus: BusId, node: Option<u8>) {
        let index = usize::from(bus.0);
        if self.seen.len() <= index {
            self.seen.resize(index + 1, 0);
        }
        if let (Some(nodes), Some(node)) = (self.seen.get_mut(index), node) {
            *nodes |= 1 << (node & 0x7F);
        }
    }

    /// Descriptions of nodes that are not in the capture: a number was mistyped, or the capture is another one.
    fn absent(&mut self, buses: &Buses) {
        let mut absent: BTreeMap<&str, Vec<u8>> = BTreeMap::new();
        for one in &self.options.network.descriptions {
            let on = |index: usize| Network::holds(one.bus.as_ref(), buses.name(BusId(index as u8)));
            let mut seen = self.seen.iter().enumerate().filter(|(index, _)| on(*index));
            if !seen.any(|(_, nodes)| nodes & 1 << (one.node & 0x7F) != 0) {
                absent.entry(&one.dictionary.file).or_default().push(one.node);
            }
        }
        let lang = self.options.lang;
        let lines = absent.into_iter().map(|(file, nodes)| complaints::absent(lang, file.as_bytes(), nodes));
        self.complaints.extend(lines);
    }

    /// What belongs to no frame at hand.
    fn aside(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        match self.options.format {
            Format::Text => self.lines.end(out, &self.events),
            Format::Jsonl => jsonl::asides(out, self.setting(buses), &self.events),
            Format::Transfers => self.transfers(buses, out),
            Format::Summary => self.summary.asides(&self.events),
            Format::Convert(_) => self.writer.events(out, self.writing(buses), None, &self.events),
            Format::Signals | Format::SignalsCsv | Format::Info => {}
        }
        self.extract(buses);
        self.events.clear();
    }

    fn on_bus(&mut self, id: BusId, buses: &Buses, act: impl FnOnce(&mut Bus, &mut Context<'_>)) {
        if self.blind {
            return;
        }
        let index = usize::from(id.0);
        while self.state.len() <= index {
            let name = buses.name(BusId(self.state.len() as u8));
            self.state.push(Bus::new(Arc::clone(&self.options.network), name));
        }
        let Some(bus) = self.state.get_mut(index) else { return };
        let mut cx = Context {
            events: &mut self.events,
            next_transfer: &mut self.next_transfer,
            extract: self.options.extract,
            chunks: &mut self.chunks,
            bus: id,
            at: self.last,
        };
        act(bus, &mut cx);
    }

    /// Repeats of one finding on one object are counted instead of shown; figures count by themselves.
    fn fold(&mut self) {
        if self.options.format != Format::Summary {
            self.repeats.fold(&mut self.events);
        }
    }

    fn setting<'a>(&'a self, buses: &'a Buses) -> Setting<'a> {
        Setting { lang: self.options.lang, file: &self.file.name, buses, decimals: self.decimals }
    }

    fn writing<'a>(&self, buses: &'a Buses) -> writers::Setting<'a> {
        writers::Setting { buses, date_ns: self.date_ns.filter(|_| self.file.dated) }
    }

    fn transfers(&mut self, buses: &Buses, out: &mut Vec<u8>) {
        let start_ns = self.start_ns.unwrap_or(0);
        for event in &self.events {
            if let What::Transfer(transfer) = &event.what
                && self.options.filter.shows_transfer(transfer, buses, start_ns)
            {
                self.shown += 1;
                jsonl::transfer(out, self.setting(buses), transfer);
            }
        }
    }

    fn extract(&mut self, buses: &Buses) {
        if !self.options.extract {
            return;
        }
        for Chunk { id, bus, node, mux, bytes } in self.chunks.drain(..) {
            self.extracted.push(Extracted { name: file_name(id.0, buses.name(bus), node, mux), bytes, status: None });
        }
        for event in &self.events {
            if let What::Transfer(transfer) = &event.what {
                let name = file_name(transfer.id.0, buses.name(transfer.bus), transfer.node, transfer.mux);
                self.extracted.push(Extracted { name, bytes: Vec::new(), status: Some(transfer.status) });
            }
        }
    }
}

/// `00001_can1_node10_1008h_00.bin`: what a bus is called comes from the capture, so anything odd becomes `_`.
fn file_name(id: u64, bus: &[u8], node: u8, mux: Option<Mux>) -> String {
    let safe = |byte: &u8| if byte.is_ascii_alphanumeric() || *byte == b'-' { char::from(*byte) } else { '_' };
    let bus: String = bus.iter().map(safe).collect();
    let bus = if bus.is_empty() { "can".to_owned() } else { bus };
    match mux {
        Some(mux) => format!("{id:05}_{bus}_node{node}_{:04X}h_{:02X}.bin", mux.index, mux.sub),
        None => format!("{id:05}_{bus}_node{node}.bin"),
    }
}
