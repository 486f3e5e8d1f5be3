//! SDO (CiA 301, 7.2.4): the one service whose frames mean nothing alone.
//!
//! | file | what it does |
//! |---|---|
//! | `wire` | reads eight bytes |
//! | `channel` | owns the state, takes a frame, begins and ends transfers |
//! | `sequence` | puts the frames in the order in which they were on the bus |
//! | `pairing` | puts requests and responses together |
//! | `exchange` | moves the transfer with each pair |
//! | `block_phase`, `block` | do so while sub-blocks run; which segments count |
//! | `midway` | takes up transfers that began before the capture |
//! | `abort` | ends transfers |
//! | `judgement` | says, withholds or drops findings |
//! | `transfer` | holds what was moved |
//!
//! A channel is a pair of COB-IDs on a bus; at most one transfer runs on it. A capture taken on the client's own
//! host may show client frames one frame late, after their answers, since a driver echoes what it sent later
//! than it delivers what it received. Everything here must hold for such captures too.

mod abort;
pub mod block;
mod block_phase;
pub mod channel;
pub mod exchange;
mod judgement;
mod midway;
mod pairing;
mod sequence;
#[cfg(test)]
mod tests;
pub mod transfer;
pub mod wire;
