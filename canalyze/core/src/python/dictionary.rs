//! Device descriptions as tables, and the standards' PDOs, objects and data types, converted between rows of Python and
//! values of the core.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::{choose, language};
use crate::sdo::wire::Mux;
use crate::wire::pdo;
use crate::words::profiles::Profile;
use crate::words::{terms, value};
use crate::world::dictionary::{Described, Dictionary as Table, Form, Object, ObjectRow};
use crate::world::od::DataType;
use crate::world::preset;

#[pyclass(module = "canalyze._core", frozen)]
pub(super) struct Dictionary {
    pub(super) table: Arc<Table>,
}

#[pymethods]
impl Dictionary {
    #[new]
    #[pyo3(signature = (*, file, form, device, rows))]
    fn new(file: String, form: &str, device: String, rows: Vec<ObjectRow>) -> PyResult<Self> {
        let form = choose("form", form, Form::NAMES)?;
        let objects = rows.into_iter().map(object).collect::<PyResult<_>>()?;
        Ok(Self { table: Arc::new(Table::new(file, form, device, objects)) })
    }

    #[getter]
    fn file(&self) -> &str {
        &self.table.file
    }

    fn pdos(&self, dummies: Vec<u16>) -> Vec<Pdo> {
        preset::presets(&self.table, &dummies).into_iter().map(|(preset, _)| Pdo::new(preset)).collect()
    }
}

fn object(row: ObjectRow) -> PyResult<Object> {
    Object::from_row(row).map_err(|access| PyValueError::new_err(format!("access={access:?}")))
}

#[pyclass(module = "canalyze._core", frozen, get_all, eq)]
#[derive(Clone, PartialEq)]
pub(super) struct CobId {
    valid: bool,
    rtr_allowed: bool,
    extended: bool,
    base: u32,
    relative: bool,
    assumed: bool,
}

#[pymethods]
impl CobId {
    #[pyo3(signature = (node))]
    fn at(&self, node: Option<u8>) -> Option<u32> {
        if self.relative { node.map(|node| self.base + u32::from(node)) } else { Some(self.base) }
    }
}

#[pyclass(module = "canalyze._core", frozen, get_all)]
#[derive(Clone)]
pub(super) struct Mapped {
    index: u16,
    sub: u8,
    offset: u16,
    bits: u8,
    dummy: bool,
}

#[pyclass(module = "canalyze._core", frozen, get_all)]
pub(super) struct Pdo {
    number: u16,
    direction: &'static str,
    communication: u16,
    cob_id: CobId,
    transmission: Option<u8>,
    inhibit: Option<u16>,
    event_timer: Option<u16>,
    sync_start: Option<u8>,
    multiplex: Option<&'static str>,
    mapped: Vec<Mapped>,
    bits: u16,
}

impl Pdo {
    pub(super) fn new(of: preset::Preset) -> Self {
        let (cob, _) = of.pdo.cob;
        Self {
            number: of.pdo.number,
            direction: if of.pdo.transmit { "tpdo" } else { "rpdo" },
            communication: of.pdo.communication(),
            cob_id: CobId {
                valid: cob.valid,
                rtr_allowed: cob.rtr_allowed,
                extended: cob.id.is_extended(),
                base: cob.id.raw(),
                relative: of.relative,
                assumed: of.assumed,
            },
            transmission: of.pdo.transmission.map(|(value, _)| value),
            inhibit: of.pdo.inhibit.map(|(value, _)| value),
            event_timer: of.pdo.event_timer.map(|(value, _)| value),
            sync_start: of.pdo.sync_start.map(|(value, _)| value),
            multiplex: of.multiplex.map(|destination| if destination { "dam" } else { "sam" }),
            bits: of.mapped.last().map_or(0, |last| last.offset + u16::from(last.bits)),
            mapped: of
                .mapped
                .iter()
                .map(|one| Mapped {
                    index: one.index,
                    sub: one.sub,
                    offset: one.offset,
                    bits: one.bits,
                    dummy: one.dummy,
                })
                .collect(),
        }
    }
}

#[pyfunction]
fn mapping_parameter(direction: &str, number: u16) -> PyResult<u16> {
    let transmit = choose("direction", direction, &[("tpdo", true), ("rpdo", false)])?;
    Ok(pdo::mapping_parameter(transmit, number))
}

#[pyfunction]
fn standard_object(index: u16, sub: u8, profile: u16, lang: &str) -> PyResult<(Option<&str>, Option<&str>)> {
    let (profile, lang) = (Profile::of(profile.into()), language(lang)?);
    let data_type = profile.data_type(index, sub).map(DataType::name);
    Ok((terms::object_name(lang, profile, index, sub), data_type))
}

#[pyfunction]
fn object_text(index: u16, sub: u8, data: &[u8], kind: u16, profile: u16, lang: &str) -> PyResult<String> {
    let profile = Profile::of(profile.into());
    let row = (index, sub, String::new(), kind, "rw".to_owned(), None, false, false, false, String::new(), 1.0);
    let object = if kind == 0 { None } else { Some(Arc::new(object(row)?)) };
    let mut out = Vec::new();
    value::of_object(&mut out, language(lang)?, Mux { index, sub }, &Described { object, profile, told: None }, data);
    Ok(String::from_utf8_lossy(&out).into_owned())
}

/// Returns code, name, and bits (if fixed) of each data type.
fn data_types() -> BTreeMap<u16, (&'static str, Option<u8>)> {
    let known = (0..=0x1B).filter_map(|code| Some((code, DataType::from_code(code)?)));
    known.map(|(code, data_type)| (code, (data_type.name(), data_type.bits()))).collect()
}

pub(super) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Dictionary>()?;
    module.add_class::<Pdo>()?;
    module.add_class::<Mapped>()?;
    module.add_class::<CobId>()?;
    module.add_function(wrap_pyfunction!(mapping_parameter, module)?)?;
    module.add_function(wrap_pyfunction!(standard_object, module)?)?;
    module.add_function(wrap_pyfunction!(object_text, module)?)?;
    module.add("DATA_TYPES", data_types())
}
