//! Periods of everything that repeats: the only place that measures and models them.
//!
//! | file | question |
//! |---|---|
//! | [`gaps`] | how long is it from one frame of a stream to the next? |
//! | [`learnt`] | which period do frames keep, in spite of what the recording did? |
//! | [`expected`] | does the next frame keep a period that somebody has given? |
//! | [`recent`] | how often did it come just now, for a screen; how often does it usually come, for a flood? |
//! | [`pace`] | which period and variation did a complete capture show, to compare it with another? |
//! | [`timer`] | how long does a sender wait at most although nothing changes? |
//! | [`spread`] | how are times distributed? |
//!
//! Nothing here knows what the frames mean.

pub mod expected;
pub mod gaps;
pub mod learnt;
pub mod pace;
pub mod recent;
pub mod spread;
pub mod timer;

pub use gaps::Gaps;
pub use learnt::{Confidence, Expected, Learnt, Period};
pub use timer::Timer;
