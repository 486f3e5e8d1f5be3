//! The output of the core: lines of text, JSON lines. Each form takes a frame with its events and appends bytes.
//!
//! It must not decide or count anything, and holds no words of its own: those come from `words`.

pub mod columns;
mod csv;
pub mod diff;
pub mod jsonl;
mod number;
mod selection;
mod setting;
mod table;
