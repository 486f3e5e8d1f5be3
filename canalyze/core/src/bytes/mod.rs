//! From bytes to frames and back: the frame, readers and writers of capture formats, files joined by time.

pub mod calendar;
pub mod frame;
pub mod info;
pub mod inputs;
pub mod masks;
pub mod ns;
pub mod readers;
pub mod select;
pub mod span;
pub mod writers;
