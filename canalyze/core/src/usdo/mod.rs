//! USDO (CiA 1301): the transfers of CANopen FD.
//!
//! | file | purpose |
//! |---|---|
//! | `sessions` | the running transfers by client, server and session-ID |
//! | `open` | one running transfer |
//! | `requests`, `responses` | what the frames of clients and of servers do to them |
//! | `endings` | their ends |
//! | `servers` | what is known of each server, and the findings |
//!
//! Each request has one response, in any order across sessions; there is no toggle bit, but a counter of segments. The
//! frames are in `wire::usdo`, the transfers are those of `sdo::transfer`. Bulk transfer, several sub-indices and
//! remote commands begin no transfer, since their bytes are not public.

mod endings;
mod open;
mod requests;
mod responses;
mod servers;
pub mod sessions;
#[cfg(test)]
mod tests;
