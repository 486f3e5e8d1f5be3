//! PDOs (CiA 301, 7.2.2): length, times, identifiers and configuration. `sync` judges synchronous PDOs in their cycle,
//! `drive` their drive objects.

pub mod assumed;
pub mod configuration;
pub mod identifier;
pub mod length;
pub mod series;
pub mod timing;
