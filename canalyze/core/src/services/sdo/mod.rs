//! SDO (CiA 301, 7.2.4): the one service whose frames mean nothing alone.
//!
//! `wire` reads eight bytes; `pairing` puts requests and responses together, whatever order the capture shows
//! them in; `channel` moves the transfer with the pairs; `block_phase` does so while sub-blocks run; `block`
//! counts their segments; `transfer` holds what was moved.
//!
//! A channel is a pair of COB-IDs on a bus; at most one transfer runs on it. A capture taken on the client's own
//! host may show client frames one frame late, after their answers, since a driver echoes what it sent later
//! than it delivers what it received. Everything here must hold for such captures too.

pub mod block;
mod block_phase;
pub mod channel;
mod pairing;
#[cfg(test)]
mod tests;
pub mod transfer;
pub mod wire;

/// Abort code: SDO protocol timed out.
const TIMED_OUT: u32 = 0x0504_0000;
