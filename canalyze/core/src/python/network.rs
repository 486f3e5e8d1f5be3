//! What is known of a network before its capture is read: device descriptions, COB-IDs, SDO channels, times.
//!
//! Rows and tuples of Python become the core's own values. Must not: know what they mean.

use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::choose;
use crate::dictionary::{Access, Dictionary as Table, Form, Object, Preset};
use crate::frame::CanId;
use crate::network::{Cob, Description, Network as Known, Sdo};

/// A row of a description, as Python hands it over: index, sub-index, name, type, access, value, relative to the
/// node-ID, configured by a DCF, mappable, unit, factor.
type Row = (u16, u8, String, u16, String, Option<i128>, bool, bool, bool, String, f64);

#[pyclass(module = "canalyze._core", frozen)]
pub(super) struct Dictionary {
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
pub(super) struct Network {
    pub(super) known: Arc<Known>,
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
