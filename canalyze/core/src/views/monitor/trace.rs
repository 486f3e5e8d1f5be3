//! The last lines with their words at the time, for scrolling and searching.
//!
//! Lines are formatted once, and a page of them is dropped at a time, so nothing is allocated line by line. Nothing is
//! decoded here.

use std::collections::VecDeque;
use std::sync::Arc;

use memchr::memmem::Finder;

use crate::bytes::frame::{BusId, Buses, CanId, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Code, Severity};
use crate::sdo::wire::Mux;
use crate::views::filter::{Filter, FilterClock, Subject};
use crate::wire::pdo::mapping::Mapping;
use crate::words::digits::{Hex, put};

/// Number of lines that are kept at least, once as many have come.
const LINES: usize = 50_000;
/// Maximum number of bytes of their words.
const BYTES: usize = 32 << 20;
/// Number of lines of a page.
const PAGE: usize = 512;
/// Number of bytes of a page after which the next one begins.
const PAGE_BYTES: usize = 64 << 10;

/// One line as it is shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Line {
    /// Number of the frame; for a line without a frame, that of the last frame before it.
    pub frame: u64,
    /// The worst finding of the frame, or the finding of the line; `""` for none.
    pub severity: &'static str,
    /// Time in ns.
    pub t_ns: Option<Ns>,
    /// The bus.
    pub bus: String,
    /// The identifier as candump writes it; empty below the frame's own line.
    pub id: String,
    /// The data as candump writes them.
    pub data: String,
    /// The text.
    pub text: String,
}

/// A request for lines.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// The filter of frames.
    pub filter: &'a Filter,
    /// Text that a line must contain; the case of ASCII letters does not matter.
    pub search: &'a str,
    /// The frame with whose last line they end, or with whose first line they begin.
    pub frame: Option<u64>,
    /// Maximum number of lines.
    pub rows: usize,
    /// They end there, instead of beginning there.
    pub back: bool,
}

/// The properties of a frame that filters use.
#[derive(Clone, Debug)]
pub(super) struct FramePlace {
    pub(super) frame: u64,
    pub(super) t_ns: Option<Ns>,
    pub(super) bus: BusId,
    pub(super) id: CanId,
    pub(super) kind: Kind,
    pub(super) service: &'static str,
    pub(super) node: Option<u8>,
    /// The object that it is about.
    pub(super) object: Option<Mux>,
    /// Those that are mapped into it.
    pub(super) mapping: Option<Arc<Mapping>>,
    /// The rule of the finding, if the line is one.
    pub(super) code: Option<Code>,
}

/// A line in the form for filters.
struct AskedLine<'a> {
    page: &'a Page,
    row: &'a TraceRow,
}

impl AskedLine<'_> {
    fn passes(&self, filter: &Filter, buses: &Buses, clock: FilterClock) -> bool {
        let FramePlace { frame: no, t_ns, bus, kind, id, .. } = self.row.place;
        let frame = Frame { no, t_ns, bus, kind, ..Frame::classic(id, &[]) };
        filter.shows(&frame, self, buses, clock)
    }
}

impl Subject for AskedLine<'_> {
    fn service(&self) -> (&str, Option<u8>) {
        (self.row.place.service, self.row.place.node)
    }

    fn has_object(&self, wanted: &dyn Fn(Mux) -> bool) -> bool {
        let mapped = self.row.place.mapping.iter().flat_map(|mapping| &mapping.entries).filter(|one| !one.dummy);
        let mut all = mapped.map(|one| Mux { index: one.index, sub: one.sub }).chain(self.row.place.object);
        all.any(wanted)
    }

    fn has_finding(&self, wanted: &dyn Fn(&str, Severity) -> bool) -> bool {
        let id = self.row.place.code.map_or("", |code| code.rule().id);
        self.row.severity.is_some_and(|severity| wanted(id, severity))
    }

    fn annotation(&self, out: &mut Vec<u8>) {
        let [_, said, end] = self.row.text;
        out.extend_from_slice(self.page.part(said, end));
    }
}

#[derive(Debug)]
struct TraceRow {
    place: FramePlace,
    severity: Option<Severity>,
    /// It is the frame's own line.
    own: bool,
    /// The beginning of its data and its words in the page, and their end.
    text: [u32; 3],
}

#[derive(Debug, Default)]
struct Page {
    rows: Vec<TraceRow>,
    text: Vec<u8>,
}

impl Page {
    fn part(&self, from: u32, to: u32) -> &[u8] {
        self.text.get(from as usize..to as usize).unwrap_or(&[])
    }
}

/// The kept lines.
#[derive(Debug, Default)]
pub(super) struct Trace {
    pages: VecDeque<Page>,
    lines: usize,
    bytes: usize,
}

impl Trace {
    /// Adds a line. `own`: it is that of the frame itself.
    pub(super) fn push(&mut self, place: FramePlace, severity: Option<Severity>, own: bool, data: &[u8], said: &[u8]) {
        if self.pages.back().is_none_or(|page| page.rows.len() >= PAGE || page.text.len() >= PAGE_BYTES) {
            self.turn();
        }
        let Some(page) = self.pages.back_mut() else { return };
        let from = page.text.len();
        page.text.extend_from_slice(data);
        page.text.extend_from_slice(said);
        let text = [from, from + data.len(), page.text.len()].map(|at| at as u32);
        page.rows.push(TraceRow { place, severity, own, text });
        self.lines += 1;
        self.bytes += data.len() + said.len();
    }

    fn turn(&mut self) {
        let mut free = Page::default();
        while let Some(oldest) = self.pages.front()
            && (self.lines - oldest.rows.len() >= LINES || self.bytes > BYTES - 2 * PAGE_BYTES)
            && let Some(page) = self.pages.pop_front()
        {
            self.lines -= page.rows.len();
            self.bytes -= page.text.len();
            free = page;
        }
        free.rows.clear();
        free.text.clear();
        self.pages.push_back(free);
    }

    /// Returns the requested lines, oldest first.
    pub(super) fn lines(&self, wanted: Wanted<'_>, buses: &Buses, clock: FilterClock) -> Vec<Line> {
        let search = wanted.search.to_ascii_lowercase();
        let finder = Finder::new(search.as_bytes());
        let mut hay = Vec::new();
        let mut passes = |page: &Page, row: &TraceRow| {
            if !wanted.filter.is_empty() && !(AskedLine { page, row }).passes(wanted.filter, buses, clock) {
                return false;
            }
            if search.is_empty() {
                return true;
            }
            hay.clear();
            hay.extend_from_slice(buses.name(row.place.bus));
            hay.push(b' ');
            id(&mut hay, row);
            let [data, said, end] = row.text;
            for part in [page.part(data, said), page.part(said, end)] {
                hay.push(b' ');
                hay.extend_from_slice(part);
            }
            hay.make_ascii_lowercase();
            finder.find(&hay).is_some()
        };
        let mut found = Vec::new();
        if wanted.back {
            let until = wanted.frame.unwrap_or(u64::MAX);
            let pages = self.pages.iter().rev().filter(|page| first(page) <= until);
            let rows = pages.flat_map(|page| page.rows.iter().rev().map(move |row| (page, row)));
            let rows = rows.filter(|(_, row)| row.place.frame <= until);
            found.extend(rows.filter(|(page, row)| passes(page, row)).take(wanted.rows));
            found.reverse();
        } else {
            let from = wanted.frame.unwrap_or(0);
            let pages = self.pages.iter().filter(|page| last(page) >= from);
            let rows = pages.flat_map(|page| page.rows.iter().map(move |row| (page, row)));
            let rows = rows.filter(|(_, row)| row.place.frame >= from);
            found.extend(rows.filter(|(page, row)| passes(page, row)).take(wanted.rows));
        }
        found.iter().map(|(page, row)| line(page, row, buses)).collect()
    }
}

fn first(page: &Page) -> u64 {
    page.rows.first().map_or(0, |row| row.place.frame)
}

fn last(page: &Page) -> u64 {
    page.rows.last().map_or(0, |row| row.place.frame)
}

fn line(page: &Page, row: &TraceRow, buses: &Buses) -> Line {
    let words = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let mut name = Vec::new();
    id(&mut name, row);
    let [data, said, end] = row.text;
    Line {
        frame: row.place.frame,
        severity: row.severity.map_or("", Severity::name),
        t_ns: row.place.t_ns,
        bus: words(buses.name(row.place.bus)),
        id: words(&name),
        data: words(page.part(data, said)),
        text: words(page.part(said, end)),
    }
}

fn id(out: &mut Vec<u8>, row: &TraceRow) {
    if row.own {
        identifier(out, row.place.id, row.place.kind == Kind::Error);
    }
}

/// Appends an identifier in candump's form; of an error frame the class with the error flag.
pub(super) fn identifier(out: &mut Vec<u8>, id: CanId, error: bool) {
    let raw = u64::from(id.raw());
    if error {
        put!(out; Hex::<8>(raw | 0x2000_0000));
    } else if id.is_extended() {
        put!(out; Hex::<8>(raw));
    } else {
        put!(out; Hex::<3>(raw));
    }
}
