//! SDO (CiA 301, 7.2.4): the one service whose frames mean nothing alone.
//!
//! | file | what it does |
//! |---|---|
//! | `wire` | reads eight bytes |
//! | `transfer`, `holes` | hold what was moved; where the capture lacks a part of it |
//! | `channel` | owns the state, takes a frame, begins and ends transfers |
//! | `sequence` | puts the frames in the order in which they were on the bus |
//! | `machine` | the protocol as one table: state, side and command to action and next state |
//! | `exchange` | what responses and aborts do to the transfer |
//! | `pace` | how fast the exchanges of a segmented transfer follow each other |
//! | `block_transfer`, `block` | what the frames of a block transfer do; which segments count |
//! | `hypotheses` | what may run where the capture begins, or goes on after lost frames |
//! | `unasked` | frames of the server without a request, and floods of them |
//! | `proof` | how sure it is that the frames are SDO |
//! | `judgement` | reports, withholds or links findings |
//! | `listing` | which transfers are listed |
//!
//! A channel is a pair of COB-IDs on a bus; at most one transfer runs on it. A capture taken on the client's own
//! host may show client frames one frame late, after their answers, since a driver echoes what it sent later
//! than it delivers what it received. Everything here must hold for such captures too.

pub mod block;
mod block_transfer;
pub mod channel;
pub mod exchange;
pub mod holes;
mod hypotheses;
pub mod judgement;
mod listing;
mod machine;
mod pace;
mod phase;
pub mod proof;
mod sequence;
mod sub_block;
#[cfg(test)]
mod tests;
pub mod transfer;
mod unasked;
pub mod wire;
