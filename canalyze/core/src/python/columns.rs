//! Tables of columns, exported without a copy by Arrow's C data interface.
//!
//! A capsule owns its structures and shares the columns with its batch, which may be dropped first; an unused capsule
//! releases its share by itself.

use std::collections::BTreeMap;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi::{FFI_ArrowArray, FFI_ArrowSchema};
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, RecordBatch, RecordBatchIterator, StructArray};
use arrow_schema::{ArrowError, DataType, Schema, SchemaRef};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyList};

use crate::tables::columns;

fn refused(error: &ArrowError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

fn names(schema: &Schema) -> Vec<String> {
    schema.fields().iter().map(|field| field.name().clone()).collect()
}

fn metadata(schema: &Schema) -> BTreeMap<String, String> {
    schema.metadata().iter().map(|(key, value)| (key.clone(), value.clone())).collect()
}

fn place(schema: &Schema, column: &str) -> PyResult<usize> {
    schema.index_of(column).map_err(|_| PyKeyError::new_err(column.to_owned()))
}

fn schema_capsule<'py>(py: Python<'py>, schema: &Schema) -> PyResult<Bound<'py, PyCapsule>> {
    let schema = FFI_ArrowSchema::try_from(schema).map_err(|error| refused(&error))?;
    PyCapsule::new_with_value(py, schema, c"arrow_schema")
}

/// Rows of one table.
#[pyclass(module = "canalyze._core", frozen)]
#[derive(Clone)]
pub(super) struct Batch {
    name: Arc<str>,
    rows: RecordBatch,
}

impl From<columns::Batch> for Batch {
    fn from(batch: columns::Batch) -> Self {
        Self { name: batch.name, rows: batch.rows }
    }
}

#[pymethods]
impl Batch {
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    #[getter]
    fn num_rows(&self) -> usize {
        self.rows.num_rows()
    }

    #[getter]
    fn column_names(&self) -> Vec<String> {
        names(self.rows.schema_ref())
    }

    #[getter]
    fn metadata(&self) -> BTreeMap<String, String> {
        metadata(self.rows.schema_ref())
    }

    fn __len__(&self) -> usize {
        self.rows.num_rows()
    }

    fn __repr__(&self) -> String {
        format!("<Batch {}: {} rows>", self.name, self.rows.num_rows())
    }

    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyList>> {
        let place = place(self.rows.schema_ref(), name)?;
        let found = PyList::empty(py);
        extend(py, &found, self.rows.column(place))?;
        Ok(found)
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_array__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyCapsule>, Bound<'py, PyCapsule>)> {
        // The interface allows a producer to use its own types if it has no others.
        drop(requested_schema);
        let rows = StructArray::from(self.rows.clone());
        let array = PyCapsule::new_with_value(py, FFI_ArrowArray::new(&rows.into_data()), c"arrow_array")?;
        Ok((schema_capsule(py, self.rows.schema_ref())?, array))
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        schema_capsule(py, self.rows.schema_ref())
    }
}

/// Batches of one table.
#[pyclass(module = "canalyze._core", frozen)]
pub(super) struct Table {
    name: Arc<str>,
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

#[pymethods]
impl Table {
    #[new]
    fn new(batches: Vec<PyRef<'_, Batch>>) -> PyResult<Self> {
        let Some(first) = batches.first() else { return Err(PyValueError::new_err("batches=[]")) };
        let (name, schema) = (Arc::clone(&first.name), first.rows.schema());
        if let Some(other) = batches.iter().find(|one| one.name != name || *one.rows.schema_ref() != schema) {
            return Err(PyValueError::new_err(format!("batches: {} {}", name, other.name)));
        }
        let batches = batches.iter().map(|one| one.rows.clone()).collect();
        Ok(Self { name, schema, batches })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    #[getter]
    fn num_rows(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    #[getter]
    fn column_names(&self) -> Vec<String> {
        names(&self.schema)
    }

    #[getter]
    fn metadata(&self) -> BTreeMap<String, String> {
        metadata(&self.schema)
    }

    fn __len__(&self) -> usize {
        self.num_rows()
    }

    fn __repr__(&self) -> String {
        format!("<Table {}: {} rows>", self.name, self.num_rows())
    }

    fn batches(&self) -> Vec<Batch> {
        self.batches.iter().map(|rows| Batch { name: Arc::clone(&self.name), rows: rows.clone() }).collect()
    }

    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyList>> {
        let place = place(&self.schema, name)?;
        let found = PyList::empty(py);
        for rows in &self.batches {
            extend(py, &found, rows.column(place))?;
        }
        Ok(found)
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        drop(requested_schema);
        let batches: Vec<_> = self.batches.iter().cloned().map(Ok).collect();
        let reader = RecordBatchIterator::new(batches, Arc::clone(&self.schema));
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), c"arrow_array_stream")
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        schema_capsule(py, &self.schema)
    }
}

/// Appends the values of a column to a list, null as None.
fn extend(py: Python<'_>, list: &Bound<'_, PyList>, column: &dyn Array) -> PyResult<()> {
    macro_rules! append {
        ($values:expr) => {
            for value in $values {
                list.append(value)?;
            }
        };
    }
    match column.data_type() {
        DataType::Boolean => append!(column.as_boolean()),
        DataType::UInt8 => append!(column.as_primitive::<UInt8Type>()),
        DataType::UInt16 => append!(column.as_primitive::<UInt16Type>()),
        DataType::UInt32 => append!(column.as_primitive::<UInt32Type>()),
        DataType::UInt64 => append!(column.as_primitive::<UInt64Type>()),
        DataType::Int8 => append!(column.as_primitive::<Int8Type>()),
        DataType::Int16 => append!(column.as_primitive::<Int16Type>()),
        DataType::Int32 => append!(column.as_primitive::<Int32Type>()),
        DataType::Int64 => append!(column.as_primitive::<Int64Type>()),
        DataType::Float32 => append!(column.as_primitive::<Float32Type>()),
        DataType::Float64 => append!(column.as_primitive::<Float64Type>()),
        DataType::Utf8 => append!(column.as_string::<i32>()),
        DataType::Binary => append!(column.as_binary::<i32>().iter().map(|one| one.map(|one| PyBytes::new(py, one)))),
        DataType::Dictionary(..) => {
            let column = column.as_dictionary::<Int32Type>();
            // Each distinct word becomes a single Python object.
            let words = PyList::empty(py);
            extend(py, &words, column.values())?;
            for key in column.keys() {
                match key {
                    Some(key) => list.append(words.get_item(usize::try_from(key)?)?)?,
                    None => list.append(py.None())?,
                }
            }
        }
        DataType::List(_) => {
            for one in column.as_list::<i32>().iter() {
                match one {
                    Some(one) => {
                        let inner = PyList::empty(py);
                        extend(py, &inner, &one)?;
                        list.append(inner)?;
                    }
                    None => list.append(py.None())?,
                }
            }
        }
        other => return Err(PyValueError::new_err(other.to_string())),
    }
    Ok(())
}
