//! The options of a session, in groups, and the formats by their names.
//!
//! Each field has the name and the meaning of an option in `canalyze/running/reading.py`, whose words are read by the
//! binding.

use std::sync::Arc;

use crate::bytes::masks::Masks;
use crate::bytes::ns::Ns;
use crate::bytes::readers;
use crate::bytes::select::Select;
use crate::bytes::writers;
use crate::tables::columns;
use crate::tables::jsonl::NAMES;
use crate::views::expectation::Expectations;
use crate::views::filter::Filter;
use crate::views::lines::{Look, Time};
use crate::words::{Depth, Lang};
use crate::world::network::Network;

/// One of the things that come out of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Annotated lines in candump's console form.
    Lines,
    /// The problems among these lines, as they begin, are linked to a cause and end.
    LinesOfChanges,
    /// Records of one kind, one a line.
    Rows(Rows, Encoding),
    /// A table in Arrow's memory layout; [`Session::take_batches`](super::Session::take_batches) returns its batches.
    Columns(columns::Name),
    /// The frames in another capture format, [`Writing::to`].
    Convert,
    /// No bytes: [`Session::take_digest`](super::Session::take_digest) returns the digest for a comparison.
    Digest,
    /// No bytes: [`Session::snapshot`](super::Session::snapshot) and [`Session::trace`](super::Session::trace) return
    /// the state so far.
    Monitor,
}

impl Output {
    /// Returns records as JSON lines.
    pub const fn json(rows: Rows) -> Self {
        Self::Rows(rows, Encoding::Json)
    }
}

/// Kinds of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Frames, notes, findings and transfers.
    Frames,
    /// The lines of [`Output::Lines`], each with the number of its frame.
    Lines,
    /// SDO transfers.
    Transfers,
    /// Findings, each with the annotated lines of its context.
    Findings,
    /// Decoded signals.
    Signals,
    /// Objects of devices as the traffic shows them, at the end.
    Objects,
    /// Values of objects as they are seen.
    History,
    /// PDOs with their mappings, at the end.
    Pdos,
    /// Figures of the capture, at the end.
    Summary,
    /// Observations from which expectations can be written, at the end.
    Observed,
    /// Problems and the verdict, at the end.
    Problems,
    /// The same, numbered in the order in which they were noticed while the capture was read.
    NumberedProblems,
    /// Problems as they begin, are linked to a cause and end.
    Changes,
    /// Problems that end with the capture.
    Endings,
    /// Files; nothing is decoded.
    Files,
}

/// Encodings of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// JSON lines; the names of objects are English.
    Json,
    /// JSON lines for a table that people read; the names of objects are in the language of the session.
    Localized,
    /// CSV, a line of headings first. For transfers, signals, objects and history; other records are JSON lines.
    Csv,
}

impl Encoding {
    /// Returns the language of objects' names; `None` for CSV, which has its own columns.
    pub(super) fn names(self, lang: Lang) -> Option<Lang> {
        match self {
            Self::Json => Some(NAMES),
            Self::Localized => Some(lang),
            Self::Csv => None,
        }
    }
}

/// A row of [`Format::NAMES`].
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// The outputs of the format. Findings come last, since they keep the frames' events.
    pub outputs: &'static [Output],
    /// Further outputs if problems are asked for.
    pub problems: &'static [Output],
}

impl Format {
    /// All formats, with their names.
    pub const NAMES: &[(&str, Self)] = &[
        ("text", Self { outputs: &[Output::Lines], problems: &[Output::LinesOfChanges] }),
        (
            "jsonl",
            Self {
                outputs: &[Output::json(Rows::Frames)],
                problems: &[Output::json(Rows::Changes), Output::json(Rows::Endings)],
            },
        ),
        (
            "events",
            Self {
                outputs: &[Output::json(Rows::Frames)],
                problems: &[Output::json(Rows::Changes), Output::json(Rows::Problems)],
            },
        ),
        ("transfers", Self::rows(&[Output::json(Rows::Transfers)])),
        ("transfers-text", Self::rows(&[Output::Rows(Rows::Transfers, Encoding::Localized)])),
        ("transfers-csv", Self::rows(&[Output::Rows(Rows::Transfers, Encoding::Csv)])),
        ("signals", Self::rows(&[Output::json(Rows::Signals)])),
        ("signals-csv", Self::rows(&[Output::Rows(Rows::Signals, Encoding::Csv)])),
        ("objects", Self::rows(&[Output::json(Rows::Objects)])),
        ("objects-text", Self::rows(&[Output::Rows(Rows::Objects, Encoding::Localized)])),
        ("objects-csv", Self::rows(&[Output::Rows(Rows::Objects, Encoding::Csv)])),
        ("pdos", Self::rows(&[Output::json(Rows::Pdos)])),
        ("history", Self::rows(&[Output::json(Rows::History)])),
        ("history-text", Self::rows(&[Output::Rows(Rows::History, Encoding::Localized)])),
        ("history-csv", Self::rows(&[Output::Rows(Rows::History, Encoding::Csv)])),
        ("summary", Self::rows(&[Output::json(Rows::Summary)])),
        (
            "observed",
            Self {
                outputs: &[
                    Output::Rows(Rows::Transfers, Encoding::Localized),
                    Output::json(Rows::Summary),
                    Output::json(Rows::Observed),
                ],
                problems: &[Output::json(Rows::NumberedProblems)],
            },
        ),
        (
            "records",
            Self::rows(&[Output::json(Rows::Transfers), Output::json(Rows::Summary), Output::json(Rows::Findings)]),
        ),
        ("lines", Self::rows(&[Output::json(Rows::Lines)])),
        ("convert", Self::rows(&[Output::Convert])),
        ("info", Self::rows(&[Output::json(Rows::Files)])),
        ("check", Self { outputs: &[Output::json(Rows::Findings)], problems: &[Output::json(Rows::NumberedProblems)] }),
        ("diagnosis", Self::rows(&[Output::json(Rows::Problems)])),
        ("columns", Self::rows(&[])),
        ("digest", Self::rows(&[Output::Digest])),
        ("monitor", Self::rows(&[Output::Monitor])),
    ];

    const fn rows(outputs: &'static [Output]) -> Self {
        Self { outputs, problems: &[] }
    }
}

/// All options of a session.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The language of words for people.
    pub lang: Lang,
    /// Settings of the readers.
    pub reading: readers::Settings,
    /// Knowledge from before the capture.
    pub known: Knowledge,
    /// The part of the capture that is shown.
    pub shown: Scope,
    /// The outputs and their look.
    pub writing: Writing,
    /// Threads that share a piece of a file, at least 1; `None`: one for each processor. The output does not depend on
    /// it.
    pub threads: Option<usize>,
}

impl Options {
    /// Returns options with these outputs; all others have their defaults.
    pub fn of(lang: Lang, outputs: &[Output]) -> Self {
        Self { lang, writing: Writing { outputs: outputs.to_vec(), ..Writing::default() }, ..Self::default() }
    }
}

/// Knowledge from before the capture.
#[derive(Clone, Debug, Default)]
pub struct Knowledge {
    /// The network: descriptions of its nodes and the like.
    pub network: Arc<Network>,
    /// Expectations that the capture is checked against.
    pub expectations: Option<Arc<Expectations>>,
}

/// The part of a capture that is shown.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    /// The filter expression.
    pub filter: Filter,
    /// Filters in candump's form, by channel.
    pub masks: Masks,
    /// The signals that are listed.
    pub select: Select,
    /// Maximum number of frames (or transfers) shown; the capture ends behind the last of them.
    pub limit: Option<u64>,
    /// Time in ns since the first frame with which the capture ends.
    pub until_ns: Option<Ns>,
}

/// The outputs of a session and their look.
#[derive(Clone, Debug, Default)]
pub struct Writing {
    /// The outputs, in the order in which each is given a frame; none: no bytes come out.
    pub outputs: Vec<Output>,
    /// Details of a line.
    pub depth: Depth,
    /// The form of times; `None`: as they came.
    pub time: Option<Time>,
    /// Marks of lines.
    pub look: Look,
    /// The capture format of [`Output::Convert`].
    pub to: writers::Format,
    /// Variants of that format.
    pub settings: writers::WriterSettings,
    /// Returns the bytes of SDO transfers by [`Session::take_extracted`](super::Session::take_extracted).
    pub extract: bool,
}
