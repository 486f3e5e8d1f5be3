//! Arbitrary bytes as a PEAK trace.
#![no_main]

#[macro_use]
mod pieces;

any_pieces!(canalyze_core::bytes::readers::trc::Trc);
