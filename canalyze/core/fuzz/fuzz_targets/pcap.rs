//! Arbitrary bytes as a pcap or pcapng file.
#![no_main]

#[macro_use]
mod pieces;

any_pieces!(canalyze_core::bytes::readers::pcap::Pcap);
