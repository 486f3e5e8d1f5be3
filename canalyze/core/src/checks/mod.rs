//! What needs more than one frame, or more than one service: states, timing, and verdicts on them.
//!
//! One file a check, or a family of checks that shares its state. Each owns what it has to remember, is told of
//! frames by the bus, and raises findings. None may change what a frame means.

pub mod beat;
pub mod emcy;
pub mod guarding;
pub mod heartbeat;
pub mod jitter;
pub mod nmt;
pub mod nodes;
pub mod permitted;
pub mod sync;
pub mod sync_counter;
pub mod sync_settings;
pub mod sync_window;
pub mod time;

#[cfg(test)]
mod tests;
