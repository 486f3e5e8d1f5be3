//! The services of CANopen, one file each: what their frames mean. Pure functions over one frame, but for SDO,
//! the one place that needs its channel's history.

pub mod lss;
pub mod sdo;
