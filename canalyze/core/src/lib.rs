//! The core of canalyze: everything between the bytes of a capture and events, text and columns.
//!
//! # Invariants
//!
//! 1. The core does no I/O and reads no clock: same input, same output, whatever the chunking.
//! 2. Decoding never fails and never panics. Every frame yields at least one event, in frame order. Only
//!    opening or reading a file can fail.
//! 3. No word for people outside `words`, `wire`, `rules` and `problems`; no protocol knowledge in Python.
//! 4. Every finding names a frame. A transfer cut by the edge of the capture is incomplete, never a violation.
//! 5. Only `python` knows Python. Python objects never cross per frame on the file path.
//! 6. Memory is bounded whatever the input: at most 64 buses; per transfer a stated part is kept, length and
//!    CRC run on. A claimed size allocates nothing.
//! 7. Nothing is dropped in silence: unreadable lines, error frames, foreign identifiers and gaps are counted
//!    and shown.
//! 8. Order never comes from a hash map.
//! 9. Strings from captures are escaped before they reach a terminal, a report or a file name.
//! 10. A record is declared once, in `tables`; a message is described once, in `wire`: all their forms follow.
//!
//! # Rooms
//!
//! `bytes` (frames, readers, writers) -> `wire` (one frame by itself), `sdo` and `usdo` (transfers) -> `world` (objects,
//! nodes, the bus) with `evidence` (what the recording did) -> `checks` and `rules` (findings) -> `problems` (problems) ->
//! `views` and `tables` (output) -> `session` -> `python`. `words` has the languages, `settings` and `description` read files beside captures. README.md of the crate has the way
//! of a frame and how to add to it; `tests/layers/` keeps which module uses which, `tests/rooms.rs` the size of a room.

/// Returns the rows of a table in `words/`, which `build.rs` has checked and turned into Rust.
macro_rules! words {
    ($table:literal) => {
        include!(concat!(env!("OUT_DIR"), "/", $table, ".rs"))
    };
}

pub mod bytes;
pub mod checks;
pub mod description;
pub mod evidence;
pub mod problems;
#[cfg(feature = "python")]
mod python;
pub mod rules;
pub mod sdo;
pub mod session;
pub mod settings;
pub mod tables;
pub mod usdo;
pub mod views;
pub mod wire;
pub mod words;
pub mod world;
