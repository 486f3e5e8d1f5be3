//! The known facts about a network before its capture is read (device descriptions, COB-IDs, SDO channels, times),
//! converted from rows of Python.

use std::sync::Arc;

use pyo3::prelude::*;

use super::choose;
use super::dictionary::Dictionary;
use crate::bytes::frame::CanId;
use crate::bytes::ns::Ns;
use crate::session::known_pdos;
use crate::world::network::{Cob, Description, GivenProfile, GivenValue, Network as Known, Sdo};

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
    #[pyo3(signature = (*, descriptions = Vec::new(), cobs = Vec::new(), values = Vec::new(), profiles = Vec::new(), sdos = Vec::new(), sync_period_ns = None, sync_window_ns = None, jitter_ns = None, bitrate = None))]
    #[allow(clippy::type_complexity, clippy::too_many_arguments, reason = "tuples and keywords of a Python call")]
    fn new(
        descriptions: Vec<(Option<String>, u8, PyRef<'_, Dictionary>)>,
        cobs: Vec<(Option<String>, u32, bool, u8, String, u16)>,
        values: Vec<(Option<String>, u8, u16, u8, u64)>,
        profiles: Vec<(Option<String>, u8, u16)>,
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
            values: values
                .into_iter()
                .map(|(bus, node, index, sub, value)| GivenValue { bus, node, index, sub, value })
                .collect(),
            profiles: profiles.into_iter().map(|(bus, node, number)| GivenProfile { bus, node, number }).collect(),
            sdos: sdos
                .into_iter()
                .map(|(bus, client, client_extended, server, server_extended, node)| Sdo {
                    bus,
                    client: identifier(client, client_extended),
                    server: identifier(server, server_extended),
                    node,
                })
                .collect(),
            sync_period_ns: sync_period_ns.map(Ns),
            sync_window_ns: sync_window_ns.map(Ns),
            jitter_ns: jitter_ns.map(Ns),
            bit_rate: bitrate,
        };
        Ok(Self { known: Arc::new(known) })
    }

    fn pdos(&self) -> String {
        String::from_utf8_lossy(&known_pdos(&self.known)).into_owned()
    }
}
