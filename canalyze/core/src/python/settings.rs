//! The files of users, `canalyze.toml` and expectations, and the values that options share with them.
//!
//! An error in a file raises a `SettingsError` with the key of its sentence and the facts that fill it.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use crate::bytes::ns::Ns;
use crate::settings::{self, Mistake};
use crate::views::expectation::Expectations as Expected;

create_exception!(canalyze._core, SettingsError, PyException);

/// An identifier; true for 29 bits.
type Id = (u32, bool);
/// Bus, identifier, node-ID, direction and number of a PDO.
type Cob = (Option<String>, Id, u8, &'static str, u16);
/// Bus, identifiers (client to server, server to client), and node-ID of an SDO server.
type SdoServer = (Option<String>, Id, Id, u8);
/// The sentence and the allowed values of each key, by table.
type Keys = BTreeMap<&'static str, BTreeMap<&'static str, (&'static str, String)>>;
/// Codes, severity, reason, globs of files, nodes, bus, FILE:LINE.
type Override = (Vec<String>, String, String, Vec<String>, Vec<u16>, Option<String>, String);

fn raised(mistake: Mistake) -> PyErr {
    SettingsError::new_err((mistake.key, mistake.facts.into_iter().collect::<BTreeMap<_, _>>()))
}

#[pyclass(module = "canalyze._core", frozen)]
pub(super) struct Expectations {
    pub(super) expected: Arc<Expected>,
    normal: String,
}

#[pymethods]
impl Expectations {
    #[new]
    fn new(content: &[u8], file: &str) -> PyResult<Self> {
        let form = settings::expectations(content, file).map_err(raised)?;
        let normal = form.to_string();
        Ok(Self { expected: Arc::new(Expected::normalized(form).map_err(PyValueError::new_err)?), normal })
    }

    #[getter]
    fn normal(&self) -> &str {
        &self.normal
    }
}

#[pyclass(module = "canalyze._core", frozen, get_all)]
struct Check {
    fail_on: Option<String>,
    problems: Option<String>,
    incidents: Option<String>,
    select: Vec<String>,
    ignore: Vec<String>,
    baseline: Option<String>,
    at: (String, String),
    overrides: Vec<Override>,
}

#[pyclass(module = "canalyze._core", frozen, get_all)]
struct Settings {
    lang: Option<String>,
    descriptions: Vec<(Option<String>, Vec<u16>, String)>,
    cobs: Vec<Cob>,
    sdos: Vec<SdoServer>,
    sync_period_ns: Option<i64>,
    sync_window_ns: Option<i64>,
    jitter_ns: Option<i64>,
    bitrate: Option<u32>,
    check: Option<Py<Check>>,
}

/// Converts to numbers that Python does not take for bytes.
fn numbers(nodes: Vec<u8>) -> Vec<u16> {
    nodes.into_iter().map(u16::from).collect()
}

fn direction(transmit: bool) -> &'static str {
    if transmit { "tpdo" } else { "rpdo" }
}

#[pyfunction(name = "settings")]
fn read(py: Python<'_>, content: &[u8], file: &str) -> PyResult<Settings> {
    let read = settings::settings(content, file).map_err(raised)?;
    let overridden =
        |one: settings::Override| (one.codes, one.severity, one.reason, one.files, numbers(one.nodes), one.bus, one.at);
    let check = |check: settings::CheckSettings| Check {
        fail_on: check.fail_on,
        problems: check.problems,
        incidents: check.incidents,
        select: check.select,
        ignore: check.ignore,
        baseline: check.baseline,
        at: check.at,
        overrides: check.overrides.into_iter().map(overridden).collect(),
    };
    Ok(Settings {
        lang: read.lang,
        descriptions: read.descriptions.into_iter().map(|one| (one.bus, numbers(one.nodes), one.file)).collect(),
        cobs: read.cobs.into_iter().map(|one| (one.bus, one.id, one.node, direction(one.pdo.0), one.pdo.1)).collect(),
        sdos: read.sdos.into_iter().map(|one| (one.bus, one.client, one.server, one.node)).collect(),
        sync_period_ns: read.sync_period_ns.map(Ns::as_ns),
        sync_window_ns: read.sync_window_ns.map(Ns::as_ns),
        jitter_ns: read.jitter_ns.map(Ns::as_ns),
        bitrate: read.bit_rate,
        check: read.check.map(|one| Py::new(py, check(one))).transpose()?,
    })
}

/// Parses a text; `None` if it is not valid UTF-8.
fn spelled<T>(text: &Bound<'_, PyString>, read: impl Fn(&str) -> Option<T>) -> Option<T> {
    text.to_cow().ok().and_then(|text| read(&text))
}

#[pyfunction]
fn node(text: &Bound<'_, PyString>) -> Option<u8> {
    spelled(text, settings::node)
}

#[pyfunction]
fn nodes<'py>(text: &Bound<'py, PyString>) -> PyResult<Option<Bound<'py, PyTuple>>> {
    spelled(text, settings::nodes).map(|nodes| PyTuple::new(text.py(), nodes)).transpose()
}

#[pyfunction]
fn can_id(text: &Bound<'_, PyString>) -> Option<(u32, bool)> {
    spelled(text, settings::can_id)
}

#[pyfunction]
fn pdo(text: &Bound<'_, PyString>) -> Option<(&'static str, u16)> {
    spelled(text, settings::pdo).map(|(transmit, number)| (direction(transmit), number))
}

#[pyfunction]
#[allow(clippy::type_complexity, reason = "a tuple for Python")]
fn pdo_mapping(text: &Bound<'_, PyString>) -> Option<(u8, &'static str, u16, Vec<(u16, u8, u64)>)> {
    let found = spelled(text, settings::pdo_mapping)?;
    Some((found.node, direction(found.transmit), found.number, found.objects))
}

#[pyfunction]
fn profile(text: &Bound<'_, PyString>) -> Option<u16> {
    spelled(text, settings::profile)
}

#[pyfunction]
fn address(text: &Bound<'_, PyString>) -> Option<(u16, Option<u8>)> {
    spelled(text, settings::address)
}

#[pyfunction]
fn tolerance(text: &Bound<'_, PyString>) -> Option<i64> {
    spelled(text, settings::tolerance)
}

#[pyfunction]
fn bit_rate(text: &Bound<'_, PyString>) -> Option<u32> {
    spelled(text, settings::bit_rate)
}

#[pyfunction]
fn codes<'py>(text: &Bound<'py, PyString>) -> PyResult<Option<Bound<'py, PyTuple>>> {
    spelled(text, settings::codes).map(|codes| PyTuple::new(text.py(), codes)).transpose()
}

/// Returns all keys by the kind of file.
fn schemas() -> BTreeMap<&'static str, Keys> {
    let keys = |keys: Vec<(&'static str, &'static str, String)>| {
        keys.into_iter().map(|(key, sentence, allowed)| (key, (sentence, allowed))).collect()
    };
    let tables = |schema: settings::Schema| schema.into_iter().map(|(name, of)| (name, keys(of))).collect();
    settings::schemas().into_iter().map(|(kind, schema)| (kind, tables(schema))).collect()
}

/// Adds these classes and functions to the module.
pub(super) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Expectations>()?;
    module.add_class::<Settings>()?;
    module.add_class::<Check>()?;
    module.add("SettingsError", module.py().get_type::<SettingsError>())?;
    module.add("SETTINGS", schemas())?;
    module.add_function(wrap_pyfunction!(read, module)?)?;
    module.add_function(wrap_pyfunction!(node, module)?)?;
    module.add_function(wrap_pyfunction!(nodes, module)?)?;
    module.add_function(wrap_pyfunction!(can_id, module)?)?;
    module.add_function(wrap_pyfunction!(pdo, module)?)?;
    module.add_function(wrap_pyfunction!(pdo_mapping, module)?)?;
    module.add_function(wrap_pyfunction!(profile, module)?)?;
    module.add_function(wrap_pyfunction!(address, module)?)?;
    module.add_function(wrap_pyfunction!(tolerance, module)?)?;
    module.add_function(wrap_pyfunction!(bit_rate, module)?)?;
    module.add_function(wrap_pyfunction!(codes, module)?)
}
