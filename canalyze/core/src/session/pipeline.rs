//! Several cores on one piece of a file: its next frames are read, what came before is understood, and what was
//! understood is written, at the same time.
//!
//! The threads begin and end within one call, so that between two calls a session is what it is without them: nothing is
//! under way, and what was fed has come out. Items go from the reader to the session, and calls from there to the
//! format, in blocks through queues that are bounded. Must not: know a service or a format, or change what comes out.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Builder, Scope};

use super::capture::View;
use super::rows::FrameRows;
use super::sink::{Notice, Passing, Sink};
use super::stream::Stream;
use super::subject::service;
use crate::bytes::frame::{Buses, Frame};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{Item, Marker, Reader};
use crate::bytes::writers;
use crate::rules::finding::Finding;
use crate::tables::jsonl;
use crate::views::filter::FilterClock;
use crate::views::lines::Clocked;
use crate::words::Lang;
use crate::world::event::Event;

/// Bytes of a piece below which threads cost more than they gain.
const LEAST: usize = 32 << 10;
/// Items of a block: to wake a thread costs as much as some tens of them.
const BLOCK: usize = 1024;
/// Blocks that wait to be understood: with that many the reader of a piece need not stop on its way.
const READ: usize = 32;
/// Most threads.
pub(super) const MOST: usize = 64;
/// Blocks that wait to be written.
const UNDERSTOOD: usize = 4;

/// A piece of a file, and what reads it.
pub(super) struct Piece<'a> {
    pub(super) reader: &'a mut Reader,
    pub(super) bytes: &'a [u8],
    pub(super) buses: &'a mut Buses,
}

/// Items of a file, and the names of the buses that were known when the first of them was read: a further name begins
/// a block.
struct Block {
    items: Vec<Item>,
    buses: Arc<Buses>,
}

/// Does what `reader.feed` and `stream.item` would do one after the other, by `threads` threads and one or two more
/// that wait for them; `counts` is called with each item first. Whether it could: a piece may be too small, and the
/// system may refuse threads. Then nothing was done.
pub(super) fn feed(
    piece: Piece<'_>,
    threads: usize,
    stream: &mut Stream,
    counts: &mut dyn FnMut(&Item),
    out: &mut Vec<u8>,
) -> bool {
    if threads < 2 || piece.bytes.len() < LEAST {
        return false;
    }
    if !stream.defers() {
        return thread::scope(|scope| {
            let Some(blocks) = read_beside(scope, piece) else { return false };
            understand(blocks, stream, counts, out);
            true
        });
    }
    let (to, calls) = sync_channel(UNDERSTOOD);
    let (calls, ordered) = (Mutex::new(calls), Mutex::new(Ordered { next: 0, out, waiting: BTreeMap::new() }));
    let deferred = Deferred::new(to, stream.capture.numbered());
    let Some(mut sink) = stream.sinks.replace(Box::new(deferred)) else { return false };
    let mut others: Vec<_> = (1..threads).map_while(|_| sink.another()).collect();
    let done = thread::scope(|scope| {
        let mut sinks = std::iter::once(&mut sink).chain(&mut others);
        let started = sinks.all(|sink| write_beside(scope, &mut **sink, &calls, &ordered));
        let blocks = started.then(|| read_beside(scope, piece)).flatten();
        let done = blocks.is_some();
        understand(blocks.into_iter().flatten(), stream, counts, &mut Vec::new());
        // The last calls are handed over, and the writing ends.
        stream.sinks.replace(Box::<FrameRows>::default());
        done
    });
    stream.sinks.replace(sink);
    done
}

/// Takes items in their order.
fn understand(
    blocks: impl IntoIterator<Item = Block>,
    stream: &mut Stream,
    counts: &mut dyn FnMut(&Item),
    out: &mut Vec<u8>,
) {
    for Block { mut items, buses } in blocks {
        for item in &mut items {
            counts(item);
            stream.item(item, &buses, out);
        }
        if let Some(deferred) = stream.sinks.find_mut::<Deferred>() {
            deferred.understood(items);
        }
    }
}

/// Reads a piece on a thread of its own; `None` where there can be none.
fn read_beside<'scope>(scope: &'scope Scope<'scope, '_>, piece: Piece<'scope>) -> Option<Receiver<Block>> {
    let (to, blocks) = sync_channel::<Block>(READ);
    let read = move || {
        let Piece { reader, bytes, buses } = piece;
        let known = |buses: &Buses| Block { items: Vec::with_capacity(BLOCK), buses: Arc::new(buses.clone()) };
        let mut block = known(buses);
        reader.feed(bytes, buses, &mut |item, buses| {
            let is_full = block.items.len() >= BLOCK;
            if is_full || block.buses.count() != buses.count() {
                let next = match block.buses.count() == buses.count() {
                    true => Block { items: Vec::with_capacity(BLOCK), buses: Arc::clone(&block.buses) },
                    false => known(buses),
                };
                // Nobody takes them where the capture is over for those who read it.
                let _ = to.send(std::mem::replace(&mut block, next));
            }
            block.items.push(*item);
        });
        let _ = to.send(block);
    };
    Builder::new().spawn_scoped(scope, read).ok().map(|_| blocks)
}

/// Writes what is called for on a thread of its own; whether there can be one.
fn write_beside<'scope>(
    scope: &'scope Scope<'scope, '_>,
    sink: &'scope mut dyn Sink,
    calls: &'scope Mutex<Receiver<(usize, Calls)>>,
    ordered: &'scope Mutex<Ordered<'_>>,
) -> bool {
    let write = move || {
        let (mut bytes, mut events) = (Vec::new(), Vec::new());
        loop {
            let next = lock(calls).recv();
            let Ok((place, calls)) = next else { return };
            calls.to(sink, &mut bytes, &mut events);
            lock(ordered).take(place, &mut bytes);
        }
    };
    Builder::new().spawn_scoped(scope, write).is_ok()
}

/// The output of several threads, in the order of the calls.
struct Ordered<'a> {
    next: usize,
    out: &'a mut Vec<u8>,
    waiting: BTreeMap<usize, Vec<u8>>,
}

impl Ordered<'_> {
    /// Takes the bytes of the block at this place.
    fn take(&mut self, place: usize, bytes: &mut Vec<u8>) {
        if place != self.next {
            self.waiting.insert(place, std::mem::take(bytes));
            return;
        }
        self.out.append(bytes);
        self.next += 1;
        while let Some(mut bytes) = self.waiting.remove(&self.next) {
            self.out.append(&mut bytes);
            self.next += 1;
        }
    }
}

/// A call that is made later.
#[derive(Debug)]
enum Call {
    /// The frame of this number, which is among the items of the block, and how many events it has.
    Frame(u64, u32),
    /// A frame of an earlier block, which was held back, and how many events it has.
    HeldFrame(Box<Frame>, u32),
    /// So many events that belong to no frame at hand.
    Asides(u32),
    Finding(Box<Finding>),
    Marker(Box<Marker>),
}

/// Calls in their order, each with the number of the setting that it was made in. Frames that pass the filter stay
/// where they were read: to copy them costs as much as to write them.
#[derive(Debug, Default)]
struct Calls {
    settings: Vec<Setting>,
    calls: Vec<(u32, Call)>,
    events: Vec<Event>,
    items: Vec<Item>,
}

/// A view that outlives what it is of.
#[derive(Debug)]
struct Setting {
    lang: Lang,
    buses: Arc<Buses>,
    file: Arc<[u8]>,
    decimals: u8,
    moments: Clocked,
    clock: FilterClock,
    date_ns: Option<Ns>,
}

impl Setting {
    fn new(view: &View<'_>, before: Option<&Self>) -> Self {
        let known = before.filter(|before| before.buses.count() == view.buses.count());
        let buses = known.map_or_else(|| Arc::new(view.buses.clone()), |before| Arc::clone(&before.buses));
        let of_file = before.filter(|before| *before.file == *view.jsonl.file);
        let file = of_file.map_or_else(|| view.jsonl.file.into(), |before| Arc::clone(&before.file));
        let jsonl::Setting { lang, decimals, clock: moments, .. } = view.jsonl;
        Self { lang, buses, file, decimals, moments, clock: view.clock, date_ns: view.writing.date_ns }
    }

    fn is(&self, view: &View<'_>) -> bool {
        let View { clock, jsonl, writing, buses } = *view;
        self.clock == clock
            && self.date_ns == writing.date_ns
            && (self.lang, self.decimals, self.moments) == (jsonl.lang, jsonl.decimals, jsonl.clock)
            && self.buses.count() == buses.count()
            && *self.file == *jsonl.file
    }

    fn view(&self) -> View<'_> {
        let Self { lang, buses, file, decimals, moments, clock, date_ns } = self;
        let jsonl = jsonl::Setting { lang: *lang, file, buses, decimals: *decimals, clock: *moments };
        View { buses, clock: *clock, jsonl, writing: writers::CaptureFacts { buses, date_ns: *date_ns } }
    }
}

impl Calls {
    /// Makes the calls. `out` and `scratch` are cleared.
    fn to(self, sink: &mut dyn Sink, out: &mut Vec<u8>, scratch: &mut Vec<Event>) {
        out.clear();
        let mut events = self.events.into_iter();
        let mut frames = self.items.iter().filter_map(|item| match item {
            Item::Frame(frame) => Some(frame),
            _ => None,
        });
        for (setting, call) in &self.calls {
            let Some(view) = self.settings.get(*setting as usize).map(Setting::view) else { continue };
            let (frame, count) = match call {
                Call::Frame(no, count) => (frames.find(|frame| frame.no == *no), *count),
                Call::HeldFrame(frame, count) => (Some(&**frame), *count),
                Call::Asides(count) => (None, *count),
                Call::Finding(finding) => {
                    sink.take(out, &view, Notice::Finding(finding));
                    continue;
                }
                Call::Marker(marker) => {
                    sink.take(out, &view, Notice::Marker(marker));
                    continue;
                }
            };
            scratch.clear();
            scratch.extend(events.by_ref().take(count as usize));
            match frame {
                Some(frame) => {
                    let passing = Passing { frame, service: service(scratch), shown: true, sync: (0, None) };
                    sink.frame(out, &view, &passing, scratch);
                }
                None => sink.take(out, &view, Notice::Asides(scratch)),
            }
        }
    }
}

/// The place of a format whose calls are made by other threads. It stands for one that defers ([`Sink::defers`]).
#[derive(Debug)]
struct Deferred {
    calls: Calls,
    /// The number of the last frame of the blocks before: one up to that was held back.
    before: u64,
    place: usize,
    to: SyncSender<(usize, Calls)>,
}

impl Deferred {
    fn new(to: SyncSender<(usize, Calls)>, before: u64) -> Self {
        Self { calls: Calls::default(), before, place: 0, to }
    }

    fn call(&mut self, view: &View<'_>, call: Call) {
        let last = self.calls.settings.last();
        if !last.is_some_and(|last| last.is(view)) {
            let setting = Setting::new(view, last);
            self.calls.settings.push(setting);
        }
        self.calls.calls.push((self.calls.settings.len() as u32 - 1, call));
    }

    /// Takes the items of a block that was understood, and hands over its calls.
    fn understood(&mut self, items: Vec<Item>) {
        let number = |item: &Item| if let Item::Frame(frame) = item { Some(frame.no) } else { None };
        self.before = items.iter().rev().find_map(number).unwrap_or(0).max(self.before);
        self.calls.items = items;
        self.hand_over();
    }

    fn hand_over(&mut self) {
        let room = Calls { calls: Vec::with_capacity(BLOCK), events: Vec::with_capacity(BLOCK), ..Calls::default() };
        // Only a panic ends the writing before.
        let _ = self.to.send((self.place, std::mem::replace(&mut self.calls, room)));
        self.place += 1;
    }
}

impl Drop for Deferred {
    fn drop(&mut self) {
        self.hand_over();
    }
}

impl Sink for Deferred {
    fn frame(&mut self, _out: &mut Vec<u8>, view: &View<'_>, passing: &Passing<'_>, events: &mut Vec<Event>) {
        let Passing { frame, shown, .. } = *passing;
        if shown {
            let count = events.len() as u32;
            self.calls.events.append(events);
            self.call(
                view,
                match frame.no > self.before {
                    true => Call::Frame(frame.no, count),
                    false => Call::HeldFrame(Box::new(*frame), count),
                },
            );
        }
    }

    fn take(&mut self, _out: &mut Vec<u8>, view: &View<'_>, notice: Notice<'_>) {
        match notice {
            Notice::Asides(events) if !events.is_empty() => {
                self.calls.events.extend_from_slice(events);
                self.call(view, Call::Asides(events.len() as u32));
            }
            Notice::Finding(finding) => self.call(view, Call::Finding(Box::new(finding.clone()))),
            Notice::Marker(marker) => self.call(view, Call::Marker(Box::new(*marker))),
            _ => {}
        }
    }
}

/// A lock that a panic elsewhere has poisoned is taken all the same.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::super::{Options, Output, Session};
    use super::*;
    use crate::bytes::readers::{InputFormat, Settings};

    /// Returns true if a piece with this number of lines was shared, and its output.
    fn fed(lines: usize, threads: usize) -> (bool, Vec<u8>) {
        let line = b"(1700000000.000000) can0 185#0102030405060708\n";
        let (mut session, bytes) = (Session::new(Options::of(Lang::Zh, &[Output::Lines])), line.repeat(lines));
        let mut reader = Reader::new(InputFormat::Candump, &Settings::default());
        let Session { buses, stream, .. } = &mut session;
        let (mut out, mut counted) = (Vec::new(), 0);
        let piece = Piece { reader: &mut reader, bytes: &bytes, buses };
        let shared = feed(piece, threads, stream, &mut |_| counted += 1, &mut out);
        assert_eq!(counted, if shared { lines } else { 0 });
        (shared, out)
    }

    #[test]
    fn what_is_worth_threads_is_shared() {
        let (shared, out) = fed(3000, 2);
        assert!(shared);
        assert_eq!(out.iter().filter(|byte| **byte == b'\n').count(), 3000);
    }

    #[test]
    fn nothing_is_done_where_it_is_not() {
        assert_eq!(fed(3000, 1), (false, Vec::new()));
        assert_eq!(fed(10, 2), (false, Vec::new()));
    }
}
