//! The binding: bytes in, bytes out. The only file that knows Python.
//!
//! Every call that works on a capture releases the GIL. Nothing here raises on the content of a capture. The
//! signatures are documented in `canalyze/_core.pyi`.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::dictionary::{Access, Dictionary as Table, Form, Object, Preset};
use crate::diff;
use crate::diff::record::Record;
use crate::filter::Filter;
use crate::finding::RULES;
use crate::frame::{Buses, CanId};
use crate::inputs::Refusal;
use crate::network::{Cob, Description, Network as Known, Sdo};
use crate::readers::candump::{self, Stamps};
use crate::readers::mcap::{Choice, Clock, Map};
use crate::readers::{Damage, Format as Input, Place, sniff};
use crate::render;
use crate::render::text::Time;
use crate::select::Select;
use crate::session::{Format, Options, Session as Core};
use crate::text::{Depth, Lang, RuleText, complaints, en, zh};
use crate::writers::mcap::{self, FdSchema};
use crate::writers::{self, Format as Written, Loss};

fn choose<T: Copy>(name: &str, value: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(word, _)| *word == value).map(|(_, choice)| *choice).ok_or_else(|| {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        PyValueError::new_err(format!("{name}={value:?}: {}", words.join(" ")))
    })
}

fn language(lang: &str) -> PyResult<Lang> {
    choose("lang", lang, &[("zh", Lang::Zh), ("en", Lang::En)])
}

#[pyclass(module = "canalyze._core", frozen)]
struct Session {
    core: Mutex<(Core, Vec<u8>)>,
}

impl Session {
    /// Runs on the core without the GIL. A lock poisoned by a panic elsewhere is taken all the same.
    fn run<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Core) -> T + Send) -> T {
        py.detach(|| act(&mut self.lock().0))
    }

    fn lock(&self) -> MutexGuard<'_, (Core, Vec<u8>)> {
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The same for calls that yield output: its buffer is kept, since fresh memory costs more than the copy.
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

/// A row of a description, as Python hands it over: index, sub-index, name, type, access, value, relative to the
/// node-ID, configured by a DCF, mappable, unit, factor.
type Row = (u16, u8, String, u16, String, Option<i128>, bool, bool, bool, String, f64);

#[pyclass(module = "canalyze._core", frozen)]
struct Dictionary {
    table: Arc<Table>,
}

#[pymethods]
impl Dictionary {
    #[new]
    #[pyo3(signature = (*, file, form, device, rows))]
    fn new(file: String, form: &str, device: String, rows: Vec<Row>) -> PyResult<Self> {
        let form = choose("form", form, &[("eds", Form::Eds), ("dcf", Form::Dcf), ("xdd", Form::Eds)])?;
        let objects = rows.into_iter().map(object).collect::<PyResult<_>>()?;
        Ok(Self { table: Arc::new(Table::new(file, form, device, objects)) })
    }
}

fn object(row: Row) -> PyResult<Object> {
    let (index, sub, name, data_type, access, value, relative, configured, mappable, unit, factor) = row;
    let access = Access::from_name(&access).ok_or_else(|| PyValueError::new_err(format!("access={access:?}")))?;
    // Two's complement: what an object holds is at most 64 bits.
    let preset = value.map(|value| Preset { value: value as u64, relative, configured });
    let unit = (!unit.is_empty()).then(|| Arc::from(unit));
    Ok(Object { index, sub, name: Arc::from(name), data_type, access, preset, mappable, unit, factor })
}

fn identifier(id: u32, extended: bool) -> CanId {
    if extended { CanId::extended(id) } else { CanId::standard((id & 0x7FF) as u16) }
}

#[pyclass(module = "canalyze._core", frozen)]
struct Network {
    known: Arc<Known>,
}

#[pymethods]
impl Network {
    #[new]
    #[pyo3(signature = (*, descriptions = Vec::new(), cobs = Vec::new(), sdos = Vec::new(), sync_period_ns = None, sync_window_ns = None, jitter_ns = None, bitrate = None))]
    #[allow(clippy::type_complexity, reason = "tuples of a Python call")]
    fn new(
        descriptions: Vec<(Option<String>, u8, PyRef<'_, Dictionary>)>,
        cobs: Vec<(Option<String>, u32, bool, u8, String, u16)>,
        sdos: Vec<(Option<String>, u32, bool, u32, bool, u8)>,
        sync_period_ns: Option<i64>,
        sync_window_ns: Option<i64>,
        jitter_ns: Option<i64>,
        bitrate: Option<u32>,
    ) -> PyResult<Self> {
        let describe = |(bus, node, dictionary): (_, _, PyRef<'_, Dictionary>)| Description {
            bus,
            node,
            dictionary: Arc::clone(&dictionary.table),
        };
        let cob = |(bus, id, extended, node, direction, number): (_, _, _, _, String, _)| -> PyResult<Cob> {
            let transmit = choose("direction", &direction, &[("tpdo", true), ("rpdo", false)])?;
            Ok(Cob { bus, id: identifier(id, extended), node, transmit, number })
        };
        let known = Known {
            descriptions: descriptions.into_iter().map(describe).collect(),
            cobs: cobs.into_iter().map(cob).collect::<PyResult<_>>()?,
            sdos: sdos
                .into_iter()
                .map(|(bus, client, client_extended, server, server_extended, node)| Sdo {
                    bus,
                    client: identifier(client, client_extended),
                    server: identifier(server, server_extended),
                    node,
                })
                .collect(),
            sync_period_ns,
            sync_window_ns,
            jitter_ns,
            bit_rate: bitrate,
        };
        Ok(Self { known: Arc::new(known) })
    }
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (*, lang = "zh", format = "text", depth = "default", stamps = "auto", time = None, filter = None, extract = false, network = None, select = None, topics = Vec::new(), time_source = None, mcap_maps = Vec::new(), to = "candump", decoded = false, mcap_fd_schema = "ros2", mcap_archive = false))]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments of a Python constructor")]
    fn new(
        lang: &str,
        format: &str,
        depth: &str,
        stamps: &str,
        time: Option<&str>,
        filter: Option<&str>,
        extract: bool,
        network: Option<&Network>,
        select: Option<&str>,
        topics: Vec<String>,
        time_source: Option<&str>,
        mcap_maps: Vec<String>,
        to: &str,
        decoded: bool,
        mcap_fd_schema: &str,
        mcap_archive: bool,
    ) -> PyResult<Self> {
        let lang = language(lang)?;
        // What no user can ask for: records for another program's writer.
        let to = if to == "packed" { Written::Packed } else { choose("to", to, Written::NAMES)? };
        let formats = [
            ("text", Format::Text),
            ("jsonl", Format::Jsonl),
            ("transfers", Format::Transfers),
            ("signals", Format::Signals),
            ("signals-csv", Format::SignalsCsv),
            ("summary", Format::Summary),
            ("convert", Format::Convert(to)),
            ("info", Format::Info),
            ("record", Format::Record),
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
            topics: Select::parse(&topics.join(",")),
            clock: time_source.map(|source| choose("time_source", source, Clock::NAMES)).transpose()?,
            maps: mcap_maps.iter().map(map).collect::<PyResult<_>>()?,
        };
        let fd_schema = choose("mcap_fd_schema", mcap_fd_schema, FdSchema::NAMES)?;
        let written = mcap::Settings { fd_schema, archive: mcap_archive, decoded: decoded.then_some(lang) };
        let options = Options {
            lang,
            format: choose("format", format, &formats)?,
            depth: choose("depth", depth, &depths)?,
            stamps: choose("stamps", stamps, &kinds)?,
            time: time.map(|time| choose("time", time, &times)).transpose()?,
            filter: Filter::parse(filter.unwrap_or(""))
                .map_err(|mistake| PyValueError::new_err(complaints::filter(lang, &mistake)))?,
            extract,
            network: network.map(|network| Arc::clone(&network.known)).unwrap_or_default(),
            select: Select::parse(select.unwrap_or("")),
            mcap,
            writing: writers::Settings { mcap: written },
        };
        Ok(Self { core: Mutex::new((Core::new(options), Vec::new())) })
    }

    #[pyo3(signature = (name, regular, format = "candump", input = 0))]
    fn begin(&self, py: Python<'_>, name: &str, regular: bool, format: &str, input: usize) -> PyResult<()> {
        // What no user can ask for: records of another program's reader.
        let format = if format == "packed" { Input::Packed } else { choose("format", format, Input::NAMES)? };
        self.run(py, |core| core.begin_one(input, name.as_bytes(), format, regular));
        Ok(())
    }

    #[pyo3(signature = (data, input = 0))]
    fn feed<'py>(&self, py: Python<'py>, data: &[u8], input: usize) -> Bound<'py, PyBytes> {
        self.output(py, |core, out| core.feed_one(input, data, out))
    }

    #[pyo3(signature = (kind, offset, bytes = None, input = 0))]
    fn damaged(&self, py: Python<'_>, kind: &str, offset: u64, bytes: Option<u64>, input: usize) -> PyResult<()> {
        let kind = choose("kind", kind, render::jsonl::DAMAGES)?;
        self.run(py, |core| core.damaged(input, Damage { place: Place::Byte(offset), kind, bytes, frames: None }));
        Ok(())
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

    fn advance<'py>(&self, py: Python<'py>, now_ns: i64) -> Bound<'py, PyBytes> {
        self.output(py, |core, out| core.advance(now_ns, out))
    }

    #[pyo3(signature = (interrupted = false, input = 0))]
    fn end<'py>(&self, py: Python<'py>, interrupted: bool, input: usize) -> Bound<'py, PyBytes> {
        self.output(py, |core, out| core.end_one(input, interrupted, out))
    }

    fn finish<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.output(py, Core::finish)
    }

    fn contents(&self, py: Python<'_>) -> String {
        String::from_utf8_lossy(&self.run(py, |core| core.contents())).into_owned()
    }

    fn complaints(&self, py: Python<'_>) -> Vec<String> {
        self.run(py, Core::take_complaints)
    }

    fn extracted<'py>(&self, py: Python<'py>) -> Vec<(String, Bound<'py, PyBytes>, &'static str)> {
        let extracted = self.run(py, Core::take_extracted);
        extracted
            .into_iter()
            .map(|one| {
                let status = one.status.map_or("", crate::services::sdo::transfer::Status::name);
                (one.name, PyBytes::new(py, &one.bytes), status)
            })
            .collect()
    }

    #[pyo3(signature = (name, further = BTreeMap::new()))]
    fn losses(&self, py: Python<'_>, name: &str, further: BTreeMap<String, u64>) -> PyResult<Vec<String>> {
        let lost = |(loss, count): (String, u64)| Ok((choose("loss", &loss, Loss::NAMES)?, count));
        let further = further.into_iter().map(lost).collect::<PyResult<Vec<_>>>()?;
        Ok(self.run(py, |core| core.losses(name.as_bytes(), &further)))
    }

    #[getter]
    fn frames(&self, py: Python<'_>) -> u64 {
        self.run(py, |core| core.frames().0)
    }

    #[getter]
    fn file_frames(&self, py: Python<'_>) -> u64 {
        self.run(py, |core| core.frames().1)
    }
}

#[pyclass(module = "canalyze._core", frozen)]
struct Comparison {
    lang: Lang,
    records: [Record; 2],
    names: [String; 2],
    compared: diff::Comparison,
}

impl Comparison {
    fn setting(&self) -> render::diff::Setting<'_> {
        let [a, b] = &self.records;
        render::diff::Setting { lang: self.lang, records: [a, b] }
    }

    fn bytes<'py>(py: Python<'py>, write: impl FnOnce(&mut Vec<u8>) + Send) -> Bound<'py, PyBytes> {
        let out = py.detach(|| {
            let mut out = Vec::new();
            write(&mut out);
            out
        });
        PyBytes::new(py, &out)
    }
}

#[pymethods]
impl Comparison {
    #[new]
    #[pyo3(signature = (a, b, *, names, lang = "zh", tolerance = 0.1, buses = Vec::new()))]
    fn new(
        py: Python<'_>,
        a: &Session,
        b: &Session,
        names: (String, String),
        lang: &str,
        tolerance: f64,
        buses: Vec<(String, String)>,
    ) -> PyResult<Self> {
        let lang = language(lang)?;
        let take = |session: &Session| session.run(py, |core| core.take_record());
        let records = [take(a), take(b)].map(|record| record.ok_or_else(|| PyValueError::new_err("format: record")));
        let [a, b] = records;
        let (a, b) = (a?, b?);
        let compared = py.detach(|| diff::compare(&a, &b, &diff::Settings { tolerance, buses }));
        Ok(Self { lang, records: [a, b], names: names.into(), compared })
    }

    #[getter]
    fn differences(&self) -> u64 {
        self.compared.differences.len() as u64 + self.compared.more
    }

    fn first(&self) -> (Option<u64>, Option<u64>) {
        let Some(first) = self.compared.differences.first() else { return (None, None) };
        let mut numbers =
            first.sides.iter().zip(first.beside).map(|(side, beside)| {
                side.as_ref().map(|side| side.since).or(beside).map(|at| at.no).filter(|no| *no > 0)
            });
        (numbers.next().flatten(), numbers.next().flatten())
    }

    fn head<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        Self::bytes(py, |out| render::diff::head(out, self.setting(), &self.compared))
    }

    fn body<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        Self::bytes(py, |out| render::diff::body(out, self.setting(), &self.compared))
    }

    fn jsonl<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let [a, b] = &self.names;
        let names = [a.as_bytes(), b.as_bytes()];
        Self::bytes(py, |out| render::jsonl::diff::write(out, self.setting(), &self.compared, names))
    }
}

#[pyclass(module = "canalyze._core", frozen, get_all)]
struct Rule {
    code: &'static str,
    name: &'static str,
    severity: &'static str,
    clause: &'static str,
    message: &'static str,
    meaning: &'static str,
    cause: &'static str,
}

#[pyfunction]
#[pyo3(signature = (lang = "zh"))]
fn rules(lang: &str) -> PyResult<Vec<Rule>> {
    let lang = language(lang)?;
    let words = |code| match lang {
        Lang::Zh => zh::findings::rule(code),
        Lang::En => en::findings::rule(code),
    };
    Ok(RULES
        .iter()
        .map(|rule| {
            let RuleText { message, meaning, cause, faces: _ } = words(rule.code);
            let severity = rule.severity.name();
            Rule { code: rule.id, name: rule.name, severity, clause: rule.clause, message, meaning, cause }
        })
        .collect())
}

#[pyfunction]
#[pyo3(signature = (line, lang = "zh"))]
fn explain(line: &str, lang: &str) -> PyResult<Option<String>> {
    let lang = language(lang)?;
    let mut buses = Buses::default();
    Ok(candump::line(line.as_bytes(), &mut buses).map(|frame| {
        let mut out = Vec::new();
        render::text::explain(&mut out, lang, &frame, &buses);
        String::from_utf8_lossy(&out).into_owned()
    }))
}

#[pyfunction]
#[pyo3(name = "sniff")]
fn sniffed(head: &[u8], complete: bool) -> Option<&'static str> {
    sniff::sniff(head, complete)
}

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<Session>()?;
    module.add_class::<Comparison>()?;
    module.add_class::<Rule>()?;
    module.add_class::<Dictionary>()?;
    module.add_class::<Network>()?;
    module.add_function(wrap_pyfunction!(rules, module)?)?;
    module.add_function(wrap_pyfunction!(explain, module)?)?;
    module.add_function(wrap_pyfunction!(sniffed, module)?)?;
    module.add("FORMATS", Input::NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>())?;
    module.add("WRITERS", Written::NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>())
}
