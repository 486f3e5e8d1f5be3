//! The English sentences.

pub mod losses;
pub mod pdo;
pub mod sdo;
pub mod services;
