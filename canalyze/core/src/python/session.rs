//! A capture, from the bytes of its files to the output, with the options of Python converted to those of the core.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::columns::Batch;
use super::network::Network;
use super::settings::Expectations;
use super::{choose, language};
use crate::bytes::inputs::Refusal;
use crate::bytes::masks::Masks;
use crate::bytes::readers::candump::Stamps;
use crate::bytes::readers::mcap::{Choice, Clock, Map};
use crate::bytes::readers::{Damage, FilePlace, InputFormat as Input};
use crate::bytes::select::Select;
use crate::bytes::writers::mcap::{self, FdSchema};
use crate::bytes::writers::{self, Format as Written, Loss};
use crate::session::{Format, Options, Session as Core};
use crate::tables;
use crate::tables::columns::Name;
use crate::views::filter::Filter;
use crate::views::lines::{Look, Time};
use crate::views::monitor::{Line, Wanted};
use crate::words::{Depth, Lang, complaints};

#[pyclass(module = "canalyze._core", frozen)]
pub(super) struct Session {
    core: Mutex<(Core, Vec<u8>)>,
    lang: Lang,
}

/// The options of a session, by the names and words of `canalyze/running/options.py`.
#[derive(FromPyObject)]
struct SessionOptions {
    lang: String,
    format: String,
    depth: String,
    stamps: String,
    time: Option<String>,
    filter: Option<String>,
    extract: bool,
    network: Option<Py<Network>>,
    select: Option<String>,
    topics: Vec<String>,
    time_source: Option<String>,
    mcap_maps: Vec<String>,
    to: String,
    decoded: bool,
    mcap_fd_schema: String,
    mcap_archive: bool,
    tables: Vec<String>,
    expectations: Option<Py<Expectations>>,
    incidents: bool,
    masks: Vec<String>,
    limit: Option<u64>,
    until_ns: Option<i64>,
    threads: Option<usize>,
    coloured: bool,
    numbered: bool,
}

/// File name, further bytes, status after the end of the transfer, then its holes (offset and length) and its JSON
/// line.
type Piece<'py> = (String, Bound<'py, PyBytes>, &'static str, Vec<(u64, Option<u64>)>, String);
/// Frame, severity, time in ns, bus, identifier, data, words.
type TraceLine = (u64, &'static str, Option<i64>, String, String, String, String);

impl Session {
    /// Runs on the core without the GIL. A lock poisoned by a panic elsewhere is still used.
    pub(super) fn run<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Core) -> T + Send) -> T {
        py.detach(|| act(&mut self.lock().0))
    }

    fn lock(&self) -> MutexGuard<'_, (Core, Vec<u8>)> {
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs a call with output. Its buffer is kept, since fresh memory costs more than the copy.
    fn output<'py>(&self, py: Python<'py>, act: impl FnOnce(&mut Core, &mut Vec<u8>) + Send) -> Bound<'py, PyBytes> {
        let out = py.detach(|| {
            let (core, kept) = &mut *self.lock();
            let mut out = std::mem::take(kept);
            out.clear();
            act(core, &mut out);
            out
        });
        let bytes = PyBytes::new(py, &out);
        self.lock().1 = out;
        bytes
    }
}

#[pymethods]
impl Session {
    #[new]
    fn new(given: SessionOptions) -> PyResult<Self> {
        let SessionOptions { network, expectations, extract, limit, incidents, coloured, numbered, .. } = given;
        let lang = language(&given.lang)?;
        // Not available to users: records for another program's writer.
        let to = match given.to.as_str() {
            "packed" => Written::Packed,
            to => choose("to", to, Written::NAMES)?,
        };
        let formats = [
            ("text", Format::Text),
            ("jsonl", Format::Jsonl),
            ("events", Format::Events),
            ("transfers", Format::Transfers),
            ("transfers-text", Format::TransfersText),
            ("transfers-csv", Format::TransfersCsv),
            ("signals", Format::Signals),
            ("signals-csv", Format::SignalsCsv),
            ("objects", Format::Objects),
            ("objects-text", Format::ObjectsText),
            ("objects-csv", Format::ObjectsCsv),
            ("pdos", Format::Pdos),
            ("history", Format::History),
            ("history-text", Format::HistoryText),
            ("history-csv", Format::HistoryCsv),
            ("summary", Format::Summary),
            ("observed", Format::Observed),
            ("records", Format::Records),
            ("lines", Format::Lines),
            ("convert", Format::Convert(to)),
            ("info", Format::Info),
            ("check", Format::Check),
            ("diagnosis", Format::Diagnosis),
            ("columns", Format::Columns),
            ("digest", Format::Digest),
            ("monitor", Format::Monitor),
        ];
        let depths = [("brief", Depth::Brief), ("default", Depth::Default), ("explain", Depth::Explain)];
        let kinds =
            [("auto", Stamps::Auto), ("absolute", Stamps::Absolute), ("zero", Stamps::Zero), ("delta", Stamps::Delta)];
        let times =
            [("a", Time::Absolute), ("d", Time::Delta), ("z", Time::Zero), ("A", Time::Date), ("n", Time::None)];
        let map = |text: &String| {
            Map::parse(text).map_err(|mistake| PyValueError::new_err(complaints::mcap_map(lang, &mistake)))
        };
        let mcap = Choice {
            topics: Select::parse(&given.topics.join(",")),
            clock: given.time_source.map(|source| choose("time_source", &source, Clock::NAMES)).transpose()?,
            maps: given.mcap_maps.iter().map(map).collect::<PyResult<_>>()?,
        };
        let fd_schema = choose("mcap_fd_schema", &given.mcap_fd_schema, FdSchema::NAMES)?;
        let written =
            mcap::McapSettings { fd_schema, archive: given.mcap_archive, decoded: given.decoded.then_some(lang) };
        let options = Options {
            lang,
            format: choose("format", &given.format, &formats)?,
            depth: choose("depth", &given.depth, &depths)?,
            stamps: choose("stamps", &given.stamps, &kinds)?,
            time: given.time.map(|time| choose("time", &time, &times)).transpose()?,
            look: Look { coloured, numbered },
            filter: Filter::parse(given.filter.as_deref().unwrap_or(""))
                .map_err(|mistake| PyValueError::new_err(complaints::filter(lang, &mistake)))?,
            masks: Masks::parse(&given.masks)
                .map_err(|mistake| PyValueError::new_err(complaints::masks(lang, &mistake)))?,
            count: limit,
            until_ns: given.until_ns,
            extract,
            network: network.map(|network| Arc::clone(&network.get().known)).unwrap_or_default(),
            select: Select::parse(given.select.as_deref().unwrap_or("")),
            mcap,
            tables: given.tables.iter().map(|table| choose("tables", table, Name::NAMES)).collect::<PyResult<_>>()?,
            writing: writers::WriterSettings { mcap: written },
            incidents,
            threads: given.threads,
            expectations: expectations.map(|given| Arc::clone(&given.get().expected)),
        };
        Ok(Self { core: Mutex::new((Core::new(options), Vec::new())), lang })
    }

    #[pyo3(signature = (name, regular, format = "candump", input = 0))]
    fn begin(&self, py: Python<'_>, name: &str, regular: bool, format: &str, input: usize) -> PyResult<()> {
        let format = match format {
            // Not available to users: records of another program's reader, live buses.
            "packed" => Input::Packed,
            "live" => Input::Live,
            _ => choose("format", format, Input::NAMES)?,
        };
        self.run(py, |core| core.begin_one(input, name.as_bytes(), format, regular));
        Ok(())
    }

    #[pyo3(signature = (data, input = 0))]
    fn feed<'py>(&self, py: Python<'py>, data: &[u8], input: usize) -> Bound<'py, PyBytes> {
        self.output(py, |core, out| core.feed_one(input, data, out))
    }

    fn rest<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.output(py, |core, out| core.rest(out))
    }

    #[pyo3(signature = (kind, offset, bytes = None, input = 0))]
    fn damaged(&self, py: Python<'_>, kind: &str, offset: u64, bytes: Option<u64>, input: usize) -> PyResult<()> {
        let kind = choose("kind", kind, tables::jsonl::DAMAGES)?;
        self.run(py, |core| core.damaged(input, Damage { place: FilePlace::Byte(offset), kind, bytes, frames: None }));
        Ok(())
    }

    #[pyo3(signature = (input = 0))]
    fn covered(&self, py: Python<'_>, input: usize) {
        self.run(py, |core| core.covered(input));
    }

    fn wants(&self, py: Python<'_>) -> Option<usize> {
        self.run(py, |core| core.wants())
    }

    fn refusal(&self, py: Python<'_>) -> Option<(&'static str, Vec<usize>)> {
        self.run(py, |core| core.refusal()).map(|refusal| match refusal {
            Refusal::NoStamps(input) => ("no_stamps", vec![input]),
            Refusal::NoCommonClock(day, start) => ("no_clock", vec![day, start]),
        })
    }

    #[pyo3(signature = (interrupted = false, input = 0))]
    fn end<'py>(&self, py: Python<'py>, interrupted: bool, input: usize) -> Bound<'py, PyBytes> {
        self.output(py, |core, out| core.end_one(input, interrupted, out))
    }

    fn finish<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.output(py, Core::finish)
    }

    #[pyo3(signature = (flush = false))]
    fn batches(&self, py: Python<'_>, flush: bool) -> Vec<(String, Batch)> {
        let batches = self.run(py, |core| core.take_batches(flush));
        batches.into_iter().map(|batch| (batch.name.to_string(), Batch::from(batch))).collect()
    }

    fn snapshot(&self, py: Python<'_>) -> String {
        String::from_utf8_lossy(&self.run(py, |core| core.snapshot())).into_owned()
    }

    fn page(&self, py: Python<'_>, bus: &str, node: u8) -> String {
        String::from_utf8_lossy(&self.run(py, |core| core.page(bus.as_bytes(), node))).into_owned()
    }

    #[pyo3(signature = (filter = "", search = "", frame = None, rows = 50, back = true))]
    fn trace(
        &self,
        py: Python<'_>,
        filter: &str,
        search: &str,
        frame: Option<u64>,
        rows: usize,
        back: bool,
    ) -> PyResult<Vec<TraceLine>> {
        let lang = self.lang;
        let filter =
            Filter::parse(filter).map_err(|mistake| PyValueError::new_err(complaints::filter(lang, &mistake)))?;
        let lines = self.run(py, |core| core.trace(Wanted { filter: &filter, search, frame, rows, back }));
        let row = |line: Line| (line.frame, line.severity, line.t_ns, line.bus, line.id, line.data, line.text);
        Ok(lines.into_iter().map(row).collect())
    }

    fn contents(&self, py: Python<'_>) -> String {
        String::from_utf8_lossy(&self.run(py, |core| core.contents())).into_owned()
    }

    fn complaints(&self, py: Python<'_>) -> Vec<String> {
        self.run(py, Core::take_complaints)
    }

    fn extracted<'py>(&self, py: Python<'py>) -> Vec<Piece<'py>> {
        let extracted = self.run(py, Core::take_extracted);
        extracted
            .into_iter()
            .map(|one| {
                let status = one.status.map_or("", crate::sdo::transfer::Status::name);
                let holes = one.holes.iter().map(|hole| (hole.offset, hole.length)).collect();
                let about = String::from_utf8_lossy(&one.about).into_owned();
                (one.name, PyBytes::new(py, &one.bytes), status, holes, about)
            })
            .collect()
    }

    #[pyo3(signature = (name, further = BTreeMap::new()))]
    fn losses(&self, py: Python<'_>, name: &str, further: BTreeMap<String, u64>) -> PyResult<Vec<String>> {
        let lost = |(loss, count): (String, u64)| Ok((choose("loss", &loss, Loss::NAMES)?, count));
        let further = further.into_iter().map(lost).collect::<PyResult<Vec<_>>>()?;
        Ok(self.run(py, |core| core.losses(name.as_bytes(), &further)))
    }

    fn nodes(&self, py: Python<'_>) -> String {
        String::from_utf8_lossy(&self.run(py, |core| core.nodes())).into_owned()
    }

    fn tally(&self, py: Python<'_>) -> String {
        String::from_utf8_lossy(&self.run(py, |core| core.tally())).into_owned()
    }

    #[getter]
    fn done(&self, py: Python<'_>) -> bool {
        self.run(py, |core| core.is_done())
    }

    #[getter]
    fn holds(&self, py: Python<'_>) -> bool {
        self.run(py, |core| core.holds())
    }

    #[getter]
    fn frames(&self, py: Python<'_>) -> u64 {
        self.run(py, |core| core.frames().0)
    }

    #[getter]
    fn date_ns(&self, py: Python<'_>) -> Option<i64> {
        self.run(py, |core| core.date_ns())
    }

    #[getter]
    fn nature(&self, py: Python<'_>) -> &'static str {
        self.run(py, |core| core.nature().name())
    }

    #[getter]
    fn file_frames(&self, py: Python<'_>) -> u64 {
        self.run(py, |core| core.frames().1)
    }
}
