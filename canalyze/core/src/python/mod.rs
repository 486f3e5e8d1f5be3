//! The binding: bytes in, bytes out. The only folder that uses Python.
//!
//! Every call that works on a capture releases the GIL. No content of a capture raises an exception. The signatures are
//! documented in `canalyze/_core.pyi`.

mod columns;
mod comparison;
mod description;
mod dictionary;
mod network;
mod session;
mod settings;

use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use self::columns::{Batch, Table};
use self::comparison::Comparison;
use self::network::Network;
use self::session::Session;
use crate::bytes::frame::{Buses, Frame};
use crate::bytes::readers::candump;
use crate::bytes::readers::{InputFormat as Input, Item, Reader, Settings, listing, sniff};
use crate::bytes::writers::Format as Written;
use crate::evidence::services::Nature;
use crate::problems::kinds::KINDS;
use crate::rules::{RULES, SEVERITIES};
use crate::session::{Options, Output, Session as Core};
use crate::tables;
use crate::tables::columns::Name;
use crate::views::colour::{COLOURS, PLAIN};
use crate::views::filter::SERVICES;
use crate::words::{Depth, Lang, complaints, diagnosis};
use crate::world::network::Network as Known;

fn choose<T: Copy>(name: &str, value: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(word, _)| *word == value).map(|(_, choice)| *choice).ok_or_else(|| {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        PyValueError::new_err(format!("{name}={value:?}: {}", words.join(" ")))
    })
}

fn language(lang: &str) -> PyResult<Lang> {
    choose("lang", lang, Lang::NAMES)
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

#[pymethods]
impl Rule {
    fn __repr__(&self) -> String {
        format!("<Rule {} {}: {}>", self.code, self.name, self.severity)
    }
}

#[pyfunction]
#[pyo3(signature = (lang = "zh"))]
fn rules(lang: &str) -> PyResult<Vec<Rule>> {
    let lang = language(lang)?;
    let row = |rule: &&crate::rules::Rule| Rule {
        code: rule.id,
        name: rule.name,
        severity: rule.severity.name(),
        clause: rule.clause,
        message: lang.of(rule.message),
        meaning: lang.of(rule.meaning),
        cause: lang.of(rule.cause),
    };
    Ok(RULES.iter().map(row).collect())
}

/// The words of a diagnosis: `status.open`, in one language.
#[pyfunction]
fn diagnosis_words(lang: &str) -> PyResult<Vec<(&'static str, &'static str)>> {
    let lang = language(lang)?;
    Ok(diagnosis::WORDS.iter().map(|(name, zh, en)| (*name, lang.pick(zh, en))).collect())
}

/// The verdict about some of the roots: the status of the worst, and the words. `counts`: open, of unknown status, ended,
/// harmless.
#[pyfunction]
fn verdict(lang: &str, nature: &str, counts: [usize; 4]) -> PyResult<(&'static str, String)> {
    let all = [Nature::Silent, Nature::Foreign, Nature::Unproven, Nature::Canopen];
    let nature = all.into_iter().find(|one| one.name() == nature);
    let nature = nature.ok_or_else(|| PyValueError::new_err("nature"))?;
    let mut out = Vec::new();
    diagnosis::verdict(&mut out, language(lang)?, nature, counts);
    Ok((diagnosis::worst(nature, counts), String::from_utf8_lossy(&out).into_owned()))
}

#[pyfunction]
#[pyo3(signature = (line, lang = "zh", network = None))]
fn explain(line: &str, lang: &str, network: Option<&Network>) -> PyResult<Option<String>> {
    let lang = language(lang)?;
    let mut buses = Buses::default();
    let mut out = Vec::new();
    let devices = network.map_or(&[][..], |network| &network.known.descriptions);
    let read = candump::line(line.as_bytes(), &mut buses).map(|frame| (frame, Input::Candump));
    if read.is_err() && crate::words::explain::code::code(&mut out, lang, line, devices) {
        return Ok(Some(String::from_utf8_lossy(&out).into_owned()));
    }
    let (frame, input) = match read.or_else(|reason| row(line, &mut buses).ok_or(reason)) {
        Ok(read) => read,
        Err(None) => return Ok(None),
        Err(Some(reason)) => {
            return Err(PyValueError::new_err(complaints::no_frame(lang, line.as_bytes(), reason)));
        }
    };
    match network {
        Some(network) => within(&mut out, lang, (line, input), &network.known),
        None => crate::views::lines::explain(&mut out, lang, &frame, &buses),
    }
    Ok(Some(String::from_utf8_lossy(&out).into_owned()))
}

/// Reads a line as a row of a listing; `None` if that is not one frame.
fn row(line: &str, buses: &mut Buses) -> Option<(Frame, Input)> {
    let mut reader = Reader::new(Input::Rows, &Settings::default());
    let mut read = Vec::new();
    let mut sink = |item: &mut Item, _: &Buses| read.push(*item);
    reader.feed(line.as_bytes(), buses, &mut sink);
    reader.finish(buses, &mut sink);
    match read.pop() {
        Some(Item::Frame(frame)) if read.is_empty() => Some((frame, Input::Rows)),
        _ => None,
    }
}

/// Explains one frame as a capture of its own, in a partly known network.
fn within(out: &mut Vec<u8>, lang: Lang, (line, input): (&str, Input), known: &Known) {
    let mut known = known.clone();
    // Node 0 holds descriptions whose node is unknown.
    known.descriptions.retain(|one| one.node > 0);
    let mut options = Options::of(lang, &[Output::Lines]);
    (options.known.network, options.writing.depth) = (Arc::new(known), Depth::Explain);
    let mut session = Core::new(options);
    session.begin_one(0, b"", input, true);
    session.feed_one(0, line.as_bytes(), out);
    session.feed_one(0, b"\n", out);
    session.end_one(0, false, out);
    session.finish(out);
}

#[pyfunction]
#[pyo3(name = "sniff")]
fn sniffed(head: &[u8], complete: bool) -> Option<&'static str> {
    sniff::sniff(head, complete)
}

#[pyfunction]
fn omission(line: &[u8]) -> Option<i64> {
    let found = listing::omission(line)?;
    Some(found.count.and_then(|count| i64::try_from(count).ok()).unwrap_or(-1))
}

#[pyfunction]
fn may_hold_command(lines: &[u8]) -> bool {
    let held = |sign: &[u8]| memchr::memmem::find(lines, sign).is_some();
    // One pass over nearly all output.
    let pairs = lines.iter().zip(lines.get(1..).unwrap_or_default());
    let doubled = pairs.fold(false, |any, (one, next)| any | (one == next) & matches!(one, b':' | b'#'));
    doubled && (held(b"::") || held(b"##[") || held(b"##vso["))
}

#[pyfunction]
fn schema(py: Python<'_>) -> Bound<'_, PyBytes> {
    PyBytes::new(py, &tables::columns::schema())
}

/// Bytes below which the allocator of Linux keeps what is freed.
const KEPT: usize = 8 << 20;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // What is freed beyond twice the largest piece so far goes back to the system (mallopt(3), M_MMAP_THRESHOLD). Results have
    // some MiB: their pages would be cleared for each of them, a fourth of the time of JSON lines.
    drop(black_box(Vec::<u8>::with_capacity(KEPT)));
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<Session>()?;
    module.add_class::<Comparison>()?;
    module.add_class::<Rule>()?;
    description::add(module)?;
    dictionary::add(module)?;
    module.add_class::<Network>()?;
    settings::add(module)?;
    module.add_class::<Batch>()?;
    module.add_class::<Table>()?;
    module.add_function(wrap_pyfunction!(rules, module)?)?;
    module.add_function(wrap_pyfunction!(diagnosis_words, module)?)?;
    module.add_function(wrap_pyfunction!(verdict, module)?)?;
    module.add_function(wrap_pyfunction!(explain, module)?)?;
    module.add_function(wrap_pyfunction!(sniffed, module)?)?;
    module.add_function(wrap_pyfunction!(omission, module)?)?;
    module.add_function(wrap_pyfunction!(may_hold_command, module)?)?;
    module.add_function(wrap_pyfunction!(schema, module)?)?;
    module.add("SERVICES", SERVICES)?;
    module.add("SEVERITIES", SEVERITIES.iter().map(|one| one.name()).collect::<Vec<_>>())?;
    module.add("COLOURS", COLOURS.iter().copied().collect::<BTreeMap<_, _>>())?;
    module.add("PLAIN", PLAIN)?;
    module.add("PROBLEMS", KINDS.iter().map(|row| row.name).collect::<Vec<_>>())?;
    module.add("TABLES", Name::NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>())?;
    module.add("FORMATS", Input::NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>())?;
    module.add("WRITERS", Written::NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>())
}
