//! What the core writes: text lines and machine output, appended to byte buffers.
//!
//! It must not decide anything and must not hold a word for people (those are in `text`).

pub mod digits;
pub mod escape;
pub mod jsonl;
