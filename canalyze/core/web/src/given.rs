//! The options of a session and the description of a file, read from JSON.
//!
//! Names and meanings are those of `canalyze/running/reading.py`, whose words the binding for Python reads by the same
//! tables; `network` has the arguments of `_core.Network`, with those of `_core.Dictionary` for each description.

use std::sync::Arc;

use canalyze_core::bytes::frame::CanId;
use canalyze_core::bytes::masks::Masks;
use canalyze_core::bytes::ns::Ns;
use canalyze_core::bytes::readers;
use canalyze_core::bytes::readers::candump::Stamps;
use canalyze_core::bytes::readers::mcap::{Choice, Clock, Map};
use canalyze_core::bytes::select::Select;
use canalyze_core::bytes::writers::mcap::{FdSchema, McapSettings};
use canalyze_core::bytes::writers::{Format as Written, WriterSettings};
use canalyze_core::session::{Format, Knowledge, Options, Output, Rows, Scope, Writing};
use canalyze_core::tables::columns::Name;
use canalyze_core::views::filter::Filter;
use canalyze_core::views::lines::{Look, Time};
use canalyze_core::words::{Depth, Lang, complaints};
use canalyze_core::world::dictionary::{Dictionary, Form, Object, ObjectRow};
use canalyze_core::world::network::{Cob, Description, GivenProfile, GivenValue, Network, Sdo};
use serde::Deserialize;

use super::descriptions::Descriptions;

/// Returns the choice of this name, or an error with all names.
pub fn choose<T: Copy>(option: &str, name: &str, choices: &[(&str, T)]) -> Result<T, String> {
    choices.iter().find(|(word, _)| *word == name).map(|(_, choice)| *choice).ok_or_else(|| {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        format!("{option}={name:?}: {}", words.join(" "))
    })
}

/// A file that begins.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenFile {
    /// The name for people.
    pub name: String,
    /// The capture format by its name.
    pub format: String,
    /// True for a whole file, false for a pipe.
    pub regular: bool,
}

impl GivenFile {
    /// Reads JSON.
    pub fn read(json: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(json).map_err(|error| error.to_string())
    }
}

/// Damage that ends a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenDamage {
    /// The kind by its name.
    pub kind: String,
    /// The offset in the file, in bytes.
    pub offset: u64,
    /// The number of bytes from there on.
    pub bytes: Option<u64>,
}

/// A bus; `None`: every bus.
type GivenBus = Option<String>;

/// A device description.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenDictionary {
    file: String,
    form: String,
    device: String,
    rows: Vec<ObjectRow>,
}

/// The known facts about a network, in the rows of `_core.Network`.
#[derive(Deserialize, Default)]
#[serde(default, deny_unknown_fields)]
struct GivenNetwork {
    descriptions: Vec<(GivenBus, u8, usize)>,
    /// The descriptions that nodes have, by their places; behind them are those that the page was given.
    dictionaries: Vec<GivenDictionary>,
    cobs: Vec<(GivenBus, u32, bool, u8, String, u16)>,
    values: Vec<(GivenBus, u8, u16, u8, u64)>,
    profiles: Vec<(GivenBus, u8, u16)>,
    sdos: Vec<(GivenBus, u32, bool, u32, bool, u8)>,
    sync_period_ns: Option<i64>,
    sync_window_ns: Option<i64>,
    jitter_ns: Option<i64>,
    bitrate: Option<u32>,
}

impl GivenNetwork {
    /// Returns the facts for the core.
    fn known(self, described: &Descriptions) -> Result<Network, String> {
        let table = |given: GivenDictionary| {
            let form = choose("form", &given.form, Form::NAMES)?;
            let objects = given.rows.into_iter().map(Object::from_row).collect::<Result<_, _>>()?;
            Ok(Arc::new(Dictionary::new(given.file, form, given.device, objects)))
        };
        let mut tables = self.dictionaries.into_iter().map(table).collect::<Result<Vec<_>, String>>()?;
        tables.extend(described.tables());
        let describe = |(bus, node, place): (GivenBus, u8, usize)| {
            let dictionary = Arc::clone(tables.get(place).ok_or_else(|| format!("descriptions: {place}"))?);
            Ok(Description { bus, node, dictionary })
        };
        let cob = |(bus, id, extended, node, direction, number): (_, _, _, _, String, _)| {
            let transmit = choose("direction", &direction, &[("tpdo", true), ("rpdo", false)])?;
            Ok(Cob { bus, id: identifier(id, extended), node, transmit, number })
        };
        let value = |(bus, node, index, sub, value)| GivenValue { bus, node, index, sub, value };
        let sdo = |(bus, client, client_extended, server, server_extended, node)| {
            let (client, server) = (identifier(client, client_extended), identifier(server, server_extended));
            Sdo { bus, client, server, node }
        };
        Ok(Network {
            descriptions: self.descriptions.into_iter().map(describe).collect::<Result<_, String>>()?,
            cobs: self.cobs.into_iter().map(cob).collect::<Result<_, String>>()?,
            values: self.values.into_iter().map(value).collect(),
            profiles: self.profiles.into_iter().map(|(bus, node, number)| GivenProfile { bus, node, number }).collect(),
            sdos: self.sdos.into_iter().map(sdo).collect(),
            sync_period_ns: self.sync_period_ns.map(Ns),
            sync_window_ns: self.sync_window_ns.map(Ns),
            jitter_ns: self.jitter_ns.map(Ns),
            bit_rate: self.bitrate,
        })
    }
}

fn identifier(id: u32, extended: bool) -> CanId {
    if extended { CanId::extended(id) } else { CanId::standard((id & 0x7FF) as u16) }
}

/// The options as they are given; those that are not have the values of a session without options.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GivenOptions {
    lang: String,
    format: String,
    depth: String,
    stamps: String,
    time: Option<String>,
    filter: Option<String>,
    select: Option<String>,
    topics: Vec<String>,
    time_source: Option<String>,
    mcap_maps: Vec<String>,
    mcap_fd_schema: String,
    mcap_archive: bool,
    to: String,
    decoded: bool,
    tables: Vec<String>,
    incidents: bool,
    masks: Vec<String>,
    limit: Option<u64>,
    until_ns: Option<i64>,
    coloured: bool,
    numbered: bool,
    network: GivenNetwork,
}

impl Default for GivenOptions {
    fn default() -> Self {
        Self {
            lang: "zh".to_owned(),
            format: "text".to_owned(),
            depth: "default".to_owned(),
            stamps: "auto".to_owned(),
            time: None,
            filter: None,
            select: None,
            topics: Vec::new(),
            time_source: None,
            mcap_maps: Vec::new(),
            mcap_fd_schema: "ros2".to_owned(),
            mcap_archive: false,
            to: "candump".to_owned(),
            decoded: false,
            tables: Vec::new(),
            incidents: false,
            masks: Vec::new(),
            limit: None,
            until_ns: None,
            coloured: false,
            numbered: false,
            network: GivenNetwork::default(),
        }
    }
}

impl GivenOptions {
    /// Reads JSON.
    pub fn read(json: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(json).map_err(|error| error.to_string())
    }

    /// Returns the options of the core, or an error in words.
    pub fn options(self, described: &Descriptions) -> Result<Options, String> {
        let lang = choose("lang", &self.lang, Lang::NAMES)?;
        let outputs = self.outputs()?;
        let maybe = |name: &Option<String>| name.clone().unwrap_or_default();
        let maps = self.mcap_maps.iter().map(|map| Map::parse(map)).collect::<Result<_, _>>();
        let mcap = Choice {
            topics: Select::parse(&self.topics.join(",")),
            clock: self.time_source.map(|name| choose("time_source", &name, Clock::NAMES)).transpose()?,
            maps: maps.map_err(|mistake| complaints::mcap_map(lang, &mistake))?,
        };
        let shown = Scope {
            filter: Filter::parse(&maybe(&self.filter)).map_err(|mistake| complaints::filter(lang, &mistake))?,
            masks: Masks::parse(&self.masks).map_err(|mistake| complaints::masks(lang, &mistake))?,
            select: Select::parse(&maybe(&self.select)),
            limit: self.limit,
            until_ns: self.until_ns.map(Ns),
        };
        let settings = McapSettings {
            fd_schema: choose("mcap_fd_schema", &self.mcap_fd_schema, FdSchema::NAMES)?,
            archive: self.mcap_archive,
            decoded: self.decoded.then_some(lang),
        };
        let writing = Writing {
            outputs,
            depth: choose("depth", &self.depth, Depth::NAMES)?,
            time: self.time.map(|name| choose("time", &name, Time::NAMES)).transpose()?,
            look: Look { coloured: self.coloured, numbered: self.numbered },
            to: choose("to", &self.to, Written::NAMES)?,
            settings: WriterSettings { mcap: settings },
            extract: false,
        };
        let stamps = choose("stamps", &self.stamps, Stamps::NAMES)?;
        let network = self.network.known(described)?;
        Ok(Options {
            lang,
            reading: readers::Settings { stamps, regular: false, mcap },
            known: Knowledge { network: Arc::new(network), expectations: None },
            shown,
            writing,
            threads: Some(1),
        })
    }

    /// Returns the outputs of the format, and the tables beside it.
    fn outputs(&self) -> Result<Vec<Output>, String> {
        let format = choose("format", &self.format, Format::NAMES)?;
        let problems = if self.incidents { format.problems } else { &[] };
        let tables = self.tables.iter().map(|name| choose("tables", name, Name::NAMES).map(Output::Columns));
        let mut tables = tables.collect::<Result<Vec<_>, _>>()?;
        if format.outputs.contains(&Output::json(Rows::Files)) {
            tables.clear(); // nothing is decoded for files
        }
        Ok([format.outputs, problems, &tables].concat())
    }
}
