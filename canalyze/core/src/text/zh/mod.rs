//! The Chinese sentences.

pub mod findings;
pub mod sdo;
pub mod services;
