//! What a session is to do.
//!
//! Must not: check what Python's names mean; that is done where they are taken.

use std::sync::Arc;

use crate::bytes::masks::Masks;
use crate::bytes::readers::candump::Stamps;
use crate::bytes::readers::mcap::Choice;
use crate::bytes::select::Select;
use crate::bytes::writers;
use crate::tables::columns;
use crate::views::expectation::Expectations;
use crate::views::filter::Filter;
use crate::views::lines::{Look, Time};
use crate::words::{Depth, Lang};
use crate::world::network::Network;

/// What comes out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Annotated lines in candump's console form.
    #[default]
    Text,
    /// JSON lines: frames, notes, findings, transfers.
    Jsonl,
    /// The same with all of the diagnosis at the end, for libraries.
    Events,
    /// JSON lines of SDO transfers only.
    Transfers,
    /// The same for a table for people: names of objects are in their language.
    TransfersText,
    /// CSV of SDO transfers.
    TransfersCsv,
    /// JSON lines of decoded signals only.
    Signals,
    /// CSV of decoded signals.
    SignalsCsv,
    /// JSON lines of objects of devices by what the traffic shows of them, all at the end.
    Objects,
    /// The same for a table for people: names of objects are in their language.
    ObjectsText,
    /// CSV of the same.
    ObjectsCsv,
    /// JSON lines of PDOs with their mappings, all at the end.
    Pdos,
    /// JSON lines of all that is seen of objects, as it comes.
    History,
    /// The same for a table for people.
    HistoryText,
    /// CSV of the same.
    HistoryCsv,
    /// JSON lines of figures, all at the end.
    Summary,
    /// JSON lines of what expectations can be written from: transfers as they end, then figures.
    Observed,
    /// JSON lines: the annotated lines of [`Format::Text`], each with the number of its frame.
    Lines,
    /// JSON lines of SDO transfers and findings as they come, and the figures at the end.
    Records,
    /// JSON lines of what each file is, one a file; nothing is decoded.
    Info,
    /// Nothing: what is to be compared is kept for [`Session::take_digest`].
    Digest,
    /// The frames themselves, in another capture format.
    Convert(writers::Format),
    /// JSON lines of findings only, each with the annotated lines of its context.
    Check,
    /// JSON lines of what went wrong: incidents, then the verdict, all at the end.
    Diagnosis,
    /// Nothing: what a view shows while the capture grows is asked for with [`Session::snapshot`] and
    /// [`Session::trace`].
    Monitor,
    /// Nothing: for tables alone (see [`Options::tables`]), of which batches are taken with [`Session::take_batches`].
    Columns,
}

/// How a capture is read and shown.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The language.
    pub lang: Lang,
    /// What comes out.
    pub format: Format,
    /// How detailed a line is.
    pub depth: Depth,
    /// What small stamps mean.
    pub stamps: Stamps,
    /// What of an MCAP file is read, and how.
    pub mcap: Choice,
    /// How time is shown; as it came, by default.
    pub time: Option<Time>,
    /// How lines are marked.
    pub look: Look,
    /// Which frames are shown.
    pub filter: Filter,
    /// The same in candump's manner, by channel.
    pub masks: Masks,
    /// Frames that are shown at most (transfers, where only they are): the capture ends behind the last of them.
    pub count: Option<u64>,
    /// The capture ends with this time in ns, counted from its first frame.
    pub until_ns: Option<i64>,
    /// Whether the bytes of SDO transfers are handed out.
    pub extract: bool,
    /// What is known of the network beforehand.
    pub network: Arc<Network>,
    /// Which signals are listed.
    pub select: Select,
    /// Which tables of columns are built, beside what comes out in any format but [`Format::Info`].
    pub tables: Vec<columns::Name>,
    /// How the format that is written is written.
    pub writing: writers::WriterSettings,
    /// Whether incidents are written, too: in [`Format::Text`] as they begin and end, in [`Format::Jsonl`] both so and at
    /// the end, in [`Format::Check`] and [`Format::Observed`] at the end.
    pub incidents: bool,
    /// Threads that share the work on a piece of a file, from 1; `None`: as many as there are processors to use. What
    /// comes out is the same.
    pub threads: Option<usize>,
    /// What is expected of the capture.
    pub expectations: Option<Arc<Expectations>>,
}
