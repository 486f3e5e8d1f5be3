//! The options of a session and the description of a file, read from JSON.
//!
//! Names and meanings are those of `canalyze/running/options.py`, whose words the binding for Python reads by the same
//! tables. What is known of a network from descriptions is not among them yet.

use std::sync::Arc;

use canalyze_core::bytes::masks::Masks;
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
use canalyze_core::world::network::Network;
use serde::Deserialize;

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
    /// The bit rate of the buses, where it is known.
    bitrate: Option<u32>,
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
            bitrate: None,
        }
    }
}

impl GivenOptions {
    /// Reads JSON.
    pub fn read(json: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(json).map_err(|error| error.to_string())
    }

    /// Returns the options of the core, or an error in words.
    pub fn options(self) -> Result<Options, String> {
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
            until_ns: self.until_ns,
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
        let network = Network { bit_rate: self.bitrate, ..Network::default() };
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
