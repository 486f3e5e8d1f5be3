//! SDO (CiA 301, 7.2.4): the only service whose frames have no meaning alone.
//!
//! | file | purpose |
//! |---|---|
//! | `wire` | decodes eight bytes |
//! | `abort_code` | the code of an abort |
//! | `transfer`, `holes` | the data moved, and the parts missing in the capture |
//! | `state`, `phase` | the state of a channel, and the frames that it keeps |
//! | `limits` | times by which a request counts as unanswered or given up |
//! | `channel` | takes a frame, begins and ends transfers |
//! | `sequence` | restores the order of frames on the bus |
//! | `machine` | the protocol as one table: state, side and command to action and next state |
//! | `exchange` | effects of responses and aborts on the transfer |
//! | `pace` | the pace of a transfer's exchanges |
//! | `block_transfer`, `block` | effects of the frames of a block transfer; the segments that count |
//! | `hypotheses` | possible states at the capture's start or after lost frames |
//! | `unasked` | frames of the server without a request, and floods of them |
//! | `proof` | evidence that the frames are SDO |
//! | `judgement` | reports, withholds or links findings |
//! | `listing` | the transfers that are listed |
//!
//! A channel is a pair of COB-IDs on a bus with at most one running transfer. A capture from the client's own host may
//! list client frames one frame late, after their answers, because a driver echoes a sent frame later than it delivers
//! a received one. Everything here supports such captures.

pub mod abort_code;
pub mod block;
mod block_transfer;
pub mod channel;
pub mod exchange;
mod holes;
mod hypotheses;
pub mod judgement;
pub mod limits;
mod listing;
mod machine;
mod pace;
mod phase;
pub mod proof;
mod sequence;
pub mod state;
mod sub_block;
#[cfg(test)]
mod tests;
pub mod transfer;
mod unasked;
pub mod wire;
