//! The Chinese sentences.

pub mod services;
