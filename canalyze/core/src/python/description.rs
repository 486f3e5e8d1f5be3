//! Device descriptions, converted to the rows of Python's named tuples.
//!
//! A file that is no description raises a `DescriptionError` with the key of its sentence and the facts that fill it.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::IntoPyObjectExt;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString, PyTuple};

use super::dictionary::{Dictionary, Pdo};
use crate::description::{self, Dcf, Defect, DefectFact, DeviceDescription, Entry, FiledObject, FiledValue, Unusable};

create_exception!(canalyze._core, DescriptionError, PyException);

/// An object of Python.
type Any<'py> = PyResult<Bound<'py, PyAny>>;

fn raised(py: Python<'_>, unusable: Unusable) -> PyErr {
    let (key, filled) = unusable.sentence();
    match facts(py, &filled) {
        Ok(facts) => DescriptionError::new_err((key, facts.unbind())),
        Err(error) => error,
    }
}

fn facts<'py>(py: Python<'py>, of: &[(&'static str, DefectFact)]) -> PyResult<Bound<'py, PyDict>> {
    let facts = PyDict::new(py);
    for (name, fact) in of {
        match fact {
            DefectFact::Whole(value) => facts.set_item(name, whole(py, *value)?)?,
            DefectFact::Real(value) => facts.set_item(name, value)?,
            DefectFact::Text(text) => facts.set_item(name, text)?,
        }
    }
    Ok(facts)
}

/// Converts a value; an offset to the node-ID becomes a tuple of one.
fn value<'py>(py: Python<'py>, of: &Option<FiledValue>) -> Any<'py> {
    match of {
        None => Ok(py.None().into_bound(py)),
        Some(FiledValue::Whole(value)) => whole(py, *value),
        Some(FiledValue::Offset(value)) => Ok(PyTuple::new(py, [whole(py, *value)?])?.into_any()),
        Some(FiledValue::Real(value)) => value.into_bound_py_any(py),
        Some(FiledValue::Text(text)) => text.into_bound_py_any(py),
        Some(FiledValue::Bytes(bytes)) => Ok(PyBytes::new(py, bytes).into_any()),
    }
}

/// Converts an integer, of which nearly all are short.
fn whole(py: Python<'_>, value: i128) -> Any<'_> {
    i64::try_from(value).map_or_else(|_| value.into_bound_py_any(py), |value| value.into_bound_py_any(py))
}

fn optional(py: Python<'_>, value: Option<i128>) -> Any<'_> {
    value.map_or_else(|| Ok(py.None().into_bound(py)), |value| whole(py, value))
}

/// Converts an entry to the fields of `Entry`, in their order.
fn entry<'py>(py: Python<'py>, of: &Entry) -> PyResult<Bound<'py, PyTuple>> {
    PyTuple::new(
        py,
        [
            of.index.into_bound_py_any(py)?,
            of.sub.into_bound_py_any(py)?,
            of.name.as_str().into_bound_py_any(py)?,
            of.data_type.into_bound_py_any(py)?,
            PyString::intern(py, of.access).into_any(),
            value(py, &of.default)?,
            value(py, &of.parameter)?,
            of.mappable.into_bound_py_any(py)?,
            value(py, &of.low)?,
            value(py, &of.high)?,
            of.unit.as_str().into_bound_py_any(py)?,
            of.factor.into_bound_py_any(py)?,
            of.line.into_bound_py_any(py)?,
        ],
    )
}

fn object<'py>(py: Python<'py>, of: &FiledObject) -> Any<'py> {
    let entries = of.entries.iter().map(|one| entry(py, one)).collect::<PyResult<Vec<_>>>()?;
    (of.index, of.name.as_str(), of.code, entries, of.line).into_bound_py_any(py)
}

fn defect<'py>(py: Python<'py>, of: &Defect) -> Any<'py> {
    (of.line, of.code, facts(py, &of.facts)?).into_bound_py_any(py)
}

/// Converts a description to its parts, in the order of `_core.pyi`.
fn parts<'py>(py: Python<'py>, of: DeviceDescription) -> PyResult<Bound<'py, PyTuple>> {
    let (info, device) = (of.info, of.device);
    let rates = device.bit_rates.iter().map(|rate| whole(py, *rate)).collect::<PyResult<Vec<_>>>()?;
    let device = PyTuple::new(
        py,
        [
            device.vendor_name.into_bound_py_any(py)?,
            optional(py, device.vendor_number)?,
            device.product_name.into_bound_py_any(py)?,
            optional(py, device.product_number)?,
            optional(py, device.revision_number)?,
            device.order_code.into_bound_py_any(py)?,
            PyTuple::new(py, rates)?.into_any(),
            optional(py, device.rpdos)?,
            optional(py, device.tpdos)?,
            device.lss.into_bound_py_any(py)?,
        ],
    )?;
    let info =
        (info.name, info.version, info.revision, info.eds_version, info.description, info.created, info.modified);
    let objects = of.objects.iter().map(|one| object(py, one)).collect::<PyResult<Vec<_>>>()?;
    let defects = of.defects.iter().map(|one| defect(py, one)).collect::<PyResult<Vec<_>>>()?;
    let pdos: Vec<Pdo> = of.pdos.into_iter().map(Pdo::new).collect();
    PyTuple::new(
        py,
        [
            of.form.name().into_bound_py_any(py)?,
            of.encoding.into_bound_py_any(py)?,
            info.into_bound_py_any(py)?,
            device.into_any(),
            PyTuple::new(py, of.comments)?.into_any(),
            of.node.into_bound_py_any(py)?,
            of.node_name.into_bound_py_any(py)?,
            optional(py, of.bit_rate)?,
            objects.into_bound_py_any(py)?,
            of.dummies.into_bound_py_any(py)?,
            Dictionary { table: Arc::clone(&of.table) }.into_bound_py_any(py)?,
            pdos.into_bound_py_any(py)?,
            defects.into_bound_py_any(py)?,
        ],
    )
}

#[pyfunction(name = "description")]
fn read<'py>(py: Python<'py>, content: &[u8], file: String) -> PyResult<Bound<'py, PyTuple>> {
    let read = py.detach(|| description::read(content, file)).map_err(|unusable| raised(py, unusable))?;
    parts(py, read)
}

#[pyfunction]
fn is_description(head: &[u8]) -> bool {
    description::is_description(head)
}

#[pyfunction]
fn configured(
    py: Python<'_>,
    content: &[u8],
    values: BTreeMap<(u16, u8), Vec<u8>>,
    node: u8,
    keys: Vec<(String, String)>,
) -> PyResult<(String, Vec<(u16, u8)>)> {
    let made = description::configured(content, &values, node, &keys);
    let Dcf { text, left_out } = made.map_err(|unusable| raised(py, unusable))?;
    Ok((text, left_out))
}

/// Adds these functions to the module.
pub(super) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("DescriptionError", module.py().get_type::<DescriptionError>())?;
    module.add_function(wrap_pyfunction!(read, module)?)?;
    module.add_function(wrap_pyfunction!(is_description, module)?)?;
    module.add_function(wrap_pyfunction!(configured, module)?)
}
