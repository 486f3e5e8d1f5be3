//! Machine output: one JSON object a line. Keys are only ever added, never renamed.

pub mod services;
