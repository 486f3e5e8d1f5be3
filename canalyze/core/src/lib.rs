//! The core of canalyze: everything between the bytes of a capture and events, text and columns.
//!
//! # Invariants
//!
//! 1. The core does no I/O and reads no clock: same input, same output, whatever the chunking.
//! 2. Decoding never fails and never panics. Every frame yields at least one event, in frame order. Only
//!    opening or reading a file can fail.
//! 3. No word for people outside `text/` and `rules/`; no protocol knowledge in Python.
//! 4. Every finding names a frame. A transfer cut by the edge of the capture is incomplete, never a violation.
//! 5. Only `python` knows Python. Python objects never cross per frame on the file path.
//! 6. Memory is bounded whatever the input: at most 64 buses; per transfer a stated part is kept, length and
//!    CRC run on. A claimed size allocates nothing.
//! 7. Nothing is dropped in silence: unreadable lines, error frames, foreign identifiers and gaps are counted
//!    and shown.
//! 8. Order never comes from a hash map.
//! 9. Strings from captures are escaped before they reach a terminal, a report or a file name.
//!
//! # Modules
//!
//! Dependency runs one way: `frame`, `od` <- `profiles` <- `dictionary`, `rules` <- `message` <- `event`, `finding` <- `evidence` (what
//! the recording did) <- `context` <- `wire`, `services` <- `configuration` <- `node` <- `checks` <- `bus` <- `session` <-
//! `python`. On the side of files, `readers` sees only
//! `frame`; `inputs` (files joined by time) and `info` (what a file is) see `readers`; `writers` sees `frame`, `event`
//! and, like all that writes, `text::digits`. On the side of people, `text` sees `message`, `event`, `finding`, `rules`,
//! `od`; `summary`, `repeats`, `expectation` (a capture held against what is expected of it), `inventory` (which objects devices have), `diff` (two captures held
//! against each other) and `finding_context` (the frames beside a finding) see `event`; `render` sees `text`, `info`,
//! `summary`, `expectation`, `finding_context`, `diff` and the columns of `writers::console`; `monitor` (what holds now)
//! sees `bus`, `summary` and `render`; `settings` (what users write for the program) sees `expectation` and `diagnosis`;
//! `preset` (the PDOs of a description) sees `node`. `masks` (candump's filters) sees `frame`. `calendar`, `select` and
//! `span` see nothing. The whole table stands in `tests/layers.rs`, which keeps it.

/// Returns the rows of a table in `words/`, which `build.rs` has checked and turned into Rust.
macro_rules! words {
    ($table:literal) => {
        include!(concat!(env!("OUT_DIR"), "/", $table, ".rs"))
    };
}

pub mod bytes;
pub mod checks;
pub mod evidence;
#[cfg(feature = "python")]
mod python;
pub mod rules;
pub mod sdo;
pub mod session;
pub mod settings;
pub mod stories;
pub mod tables;
pub mod views;
pub mod wire;
pub mod words;
pub mod world;
