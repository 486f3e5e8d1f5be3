//! What needs more than one frame, or more than one service: states, timing, and verdicts on them.
//!
//! One file a check, or a family of checks that shares its state. Each owns what it has to remember, is told of
//! frames by the bus, and raises findings. None may change what a frame means.

pub mod drive;
pub mod srdo;
#[cfg(test)]
mod tests;
