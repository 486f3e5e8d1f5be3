//! Arbitrary bytes as rows that another program lists.
#![no_main]

#[macro_use]
mod pieces;

any_pieces!(canalyze_core::bytes::readers::rows::Rows);
