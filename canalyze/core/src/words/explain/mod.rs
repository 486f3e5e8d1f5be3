//! The breakdown under a line: COB-ID formula, bit groups, little-endian fields, data bytes, as the notes'
//! explanation chapters give them. Whole lines, each `#   ...` and a line end.
//!
//! The layout is one and only the words differ: they stand in [`Lang::pick`]. A new service gets its arm in
//! `services::message`. Must not decide anything.

pub mod code;
mod described;
pub mod mapping;
pub mod parameter;
pub mod pdo;
pub mod sdo;
pub mod services;
mod term;

pub(crate) use crate::wire::fields::{data, line};
pub use crate::wire::role::cob_id;
