//! A capture, from the bytes of its files to the output, with the options of Python converted to those of the core.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::choose;
use super::columns::Batch;
use super::network::Network;
use super::settings::Expectations;
use crate::bytes::inputs::Refusal;
use crate::bytes::masks::Masks;
use crate::bytes::ns::Ns;
use crate::bytes::readers::candump::Stamps;
use crate::bytes::readers::mcap::{Choice, Clock, Map};
use crate::bytes::readers::{Damage, FilePlace, InputFormat as Input, Settings as Reading};
use crate::bytes::select::Select;
use crate::bytes::writers::mcap::{self, FdSchema};
use crate::bytes::writers::{self, Format as Written, Loss};
use crate::session::{Format, Knowledge, Options, Output, Rows, Scope, Session as Core, Writing};
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

/// The options of `canalyze/running/reading.py`, read by their names.
struct GivenOptions<'a, 'py> {
    options: Borrowed<'a, 'py, PyAny>,
    lang: Lang,
}

impl<'py> GivenOptions<'_, 'py> {
    fn get<T: FromPyObjectOwned<'py>>(&self, name: &str) -> PyResult<T> {
        self.options.getattr(name)?.extract().map_err(Into::into)
    }

    /// Returns the choice that has the name given.
    fn one<T: Copy>(&self, name: &str, choices: &[(&str, T)]) -> PyResult<T> {
        choose(name, &self.get::<String>(name)?, choices)
    }

    /// Returns the choices that have the names given.
    fn some<T: Copy>(&self, name: &str, choices: &[(&str, T)]) -> PyResult<Vec<T>> {
        self.get::<Vec<String>>(name)?.iter().map(|word| choose(name, word, choices)).collect()
    }

    /// Returns the choice that has the name given, if there is one.
    fn maybe<T: Copy>(&self, name: &str, choices: &[(&str, T)]) -> PyResult<Option<T>> {
        self.get::<Option<String>>(name)?.map(|word| choose(name, &word, choices)).transpose()
    }

    /// Returns an expression; without one it is the empty one.
    fn text(&self, name: &str) -> PyResult<String> {
        Ok(self.get::<Option<String>>(name)?.unwrap_or_default())
    }

    /// Returns a value as it was read, or the error with the mistake in words.
    fn read<T, M>(&self, read: Result<T, M>, words: fn(Lang, &M) -> String) -> PyResult<T> {
        read.map_err(|mistake| PyValueError::new_err(words(self.lang, &mistake)))
    }

    /// Returns the outputs of a format, and the tables beside it.
    fn outputs(&self) -> PyResult<Vec<Output>> {
        let format = self.one("format", Format::NAMES)?;
        let problems = if self.get("incidents")? { format.problems } else { &[] };
        let tables = self.some("tables", Name::NAMES)?.into_iter().map(Output::Columns);
        // Nothing is decoded for files.
        let tables = tables.filter(|_| !format.outputs.contains(&Output::json(Rows::Files)));
        Ok(format.outputs.iter().chain(problems).copied().chain(tables).collect())
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Options {
    type Error = PyErr;

    fn extract(options: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let lang = choose("lang", &options.getattr("lang")?.extract::<String>()?, Lang::NAMES)?;
        let given = GivenOptions { options, lang };
        let maps: Vec<String> = given.get("mcap_maps")?;
        let mcap = Choice {
            topics: Select::parse(&given.get::<Vec<String>>("topics")?.join(",")),
            clock: given.maybe("time_source", Clock::NAMES)?,
            maps: given.read(maps.iter().map(|map| Map::parse(map)).collect(), complaints::mcap_map)?,
        };
        let known = Knowledge {
            network: given
                .get::<Option<Py<Network>>>("network")?
                .map(|one| Arc::clone(&one.get().known))
                .unwrap_or_default(),
            expectations: given
                .get::<Option<Py<Expectations>>>("expectations")?
                .map(|one| Arc::clone(&one.get().expected)),
        };
        let shown = Scope {
            filter: given.read(Filter::parse(&given.text("filter")?), complaints::filter)?,
            masks: given.read(Masks::parse(&given.get::<Vec<String>>("masks")?), complaints::masks)?,
            select: Select::parse(&given.text("select")?),
            limit: given.get("limit")?,
            until_ns: given.get::<Option<i64>>("until_ns")?.map(Ns),
        };
        let settings = mcap::McapSettings {
            fd_schema: given.one("mcap_fd_schema", FdSchema::NAMES)?,
            archive: given.get("mcap_archive")?,
            decoded: given.get::<bool>("decoded")?.then_some(lang),
        };
        // Records for another program's writer have no name among the formats of files.
        let to = match given.get::<String>("to")?.as_str() {
            "packed" => Written::Packed,
            to => choose("to", to, Written::NAMES)?,
        };
        let writing = Writing {
            outputs: given.outputs()?,
            depth: given.one("depth", Depth::NAMES)?,
            time: given.maybe("time", Time::NAMES)?,
            look: Look { coloured: given.get("coloured")?, numbered: given.get("numbered")? },
            to,
            settings: writers::WriterSettings { mcap: settings },
            extract: given.get("extract")?,
        };
        let reading = Reading { stamps: given.one("stamps", Stamps::NAMES)?, regular: false, mcap };
        Ok(Self { lang, reading, known, shown, writing, threads: given.get("threads")? })
    }
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
    fn new(options: Options) -> Self {
        let lang = options.lang;
        Self { core: Mutex::new((Core::new(options), Vec::new())), lang }
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

    #[pyo3(signature = (data, input = 0, start = 0, end = None))]
    fn feed<'py>(
        &self,
        py: Python<'py>,
        data: &[u8],
        input: usize,
        start: usize,
        end: Option<usize>,
    ) -> Bound<'py, PyBytes> {
        let part = data.get(start..end.map_or(data.len(), |end| end.min(data.len()))).unwrap_or_default();
        self.output(py, |core, out| core.feed_one(input, part, out))
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
        let row =
            |line: Line| (line.frame, line.severity, line.t_ns.map(Ns::as_ns), line.bus, line.id, line.data, line.text);
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
        self.run(py, |core| core.date_ns()).map(Ns::as_ns)
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
