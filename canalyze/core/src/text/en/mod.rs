//! The English sentences.

pub mod services;
