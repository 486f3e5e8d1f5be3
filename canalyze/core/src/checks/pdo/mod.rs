//! PDOs (CiA 301, 7.2.2): their length, times, identifiers and configuration. Synchronous ones in their cycle are
//! `sync`'s, what they carry of a drive is `drive`'s.

pub mod assumed;
pub mod configuration;
pub mod identifier;
pub mod length;
pub mod series;
pub mod timing;
