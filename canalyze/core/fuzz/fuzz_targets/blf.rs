//! Arbitrary bytes as a Vector BLF file.
#![no_main]

#[macro_use]
mod pieces;

any_pieces!(canalyze_core::bytes::readers::blf::Blf);
