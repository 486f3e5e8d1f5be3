//! Views of events: lines, summary, object inventory, comparison, expectations, monitor. Events go in, rows come out.

pub mod colour;
pub mod diff;
pub mod expectation;
pub mod filter;
pub mod finding_context;
pub mod inventory;
pub mod lines;
pub mod monitor;
pub mod summary;
