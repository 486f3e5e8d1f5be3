//! The comparison of two captures for Python; `diff` and `tables::diff` do the work.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::language;
use super::session::Session;
use crate::tables;
use crate::views::diff;
use crate::views::diff::digest::Digest;
use crate::words::Lang;

#[pyclass(module = "canalyze._core", frozen)]
pub(super) struct Comparison {
    lang: Lang,
    digests: [Digest; 2],
    names: [String; 2],
    compared: diff::Comparison,
}

impl Comparison {
    fn setting(&self) -> tables::diff::DiffSetting<'_> {
        let [a, b] = &self.digests;
        tables::diff::DiffSetting { lang: self.lang, digests: [a, b] }
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
        let take = |session: &Session| session.run(py, |core| core.take_digest());
        let digests = [take(a), take(b)].map(|digest| digest.ok_or_else(|| PyValueError::new_err("format: digest")));
        let [a, b] = digests;
        let (a, b) = (a?, b?);
        let compared = py.detach(|| diff::compare(&a, &b, &diff::DiffSettings { tolerance, buses }));
        Ok(Self { lang, digests: [a, b], names: names.into(), compared })
    }

    /// Returns the names of the buses of A and of B.
    #[getter]
    fn buses(&self) -> (Vec<String>, Vec<String>) {
        let [a, b] = &self.digests;
        let shown = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
        let names = |digest: &Digest| digest.buses.names().filter(|name| !name.is_empty()).map(shown).collect();
        (names(a), names(b))
    }

    #[getter]
    fn differences(&self) -> u64 {
        self.compared.count()
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
        Self::bytes(py, |out| tables::diff::head(out, self.setting(), &self.compared))
    }

    fn body<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        Self::bytes(py, |out| tables::diff::body(out, self.setting(), &self.compared))
    }

    fn jsonl<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let [a, b] = &self.names;
        let names = [a.as_bytes(), b.as_bytes()];
        Self::bytes(py, |out| tables::jsonl::diff::write(out, self.setting(), &self.compared, names))
    }
}
