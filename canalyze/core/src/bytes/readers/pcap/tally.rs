//! Facts of a pcap or pcapng file beside its frames, for `info`: dialect, interfaces, and other content.
//!
//! Memory does not grow with the file: kinds are numbers, and at most 64 of them are kept.

use std::io::Write;

use super::ByteOrder;
use super::identifiers::{Orders, Reading, Votes};
use crate::bytes::readers::Contents;

/// Maximum number of separately counted kinds; all others are counted together.
const KINDS: usize = 63;
/// Maximum number of described interfaces.
const INTERFACES: usize = 64;
/// Maximum length of a kept text, in bytes.
const TEXT: usize = 256;

/// Content without a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passed {
    /// A packet of this link type.
    Packet(u16),
    /// A packet of this protocol in a cooked capture.
    Protocol(u16),
    /// A block of this type in a pcapng file.
    Block(u32),
}

/// The facts so far.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// The byte order of identifiers that are big-endian by the format.
    pub(super) reading: Reading,
    /// The byte orders seen so far.
    pub(super) orders: Orders,
    /// Set while packets are only examined for their byte order.
    pub(super) votes: Option<Votes>,
    dialect: Vec<(&'static str, Vec<u8>)>,
    interfaces: usize,
    passed: Vec<(Passed, u64)>,
    others: u64,
}

impl Tally {
    /// Counts one item.
    pub(super) fn pass(&mut self, kind: Passed) {
        if let Some((_, count)) = self.passed.iter_mut().find(|(known, _)| *known == kind) {
            *count += 1;
        } else if self.passed.len() < KINDS {
            self.passed.push((kind, 1));
        } else {
            self.others += 1;
        }
    }

    /// Adds a property of the file, unless another section has the same.
    pub(super) fn note(&mut self, name: &'static str, value: &[u8]) {
        let value = value.get(..TEXT).unwrap_or(value);
        let known = self.dialect.iter().any(|(other, text)| *other == name && text == value);
        if !known && self.dialect.len() < 2 * INTERFACES {
            self.dialect.push((name, value.to_vec()));
        }
    }

    /// Adds the byte order of identifiers, if it is not that of the format.
    pub(super) fn identifiers(&mut self, reading: Reading) {
        self.reading = reading;
        match reading {
            Reading::Big => {}
            Reading::Little => self.note("identifiers", b"little-endian"),
            Reading::Neither => self.note("identifiers", b"implausible"),
        }
    }

    /// Adds version and byte order.
    pub(super) fn version(&mut self, major: u16, minor: u16, order: ByteOrder) {
        self.note("version", format!("{major}.{minor}").as_bytes());
        self.note("byte order", if order == ByteOrder::Big { b"big-endian" } else { b"little-endian" });
    }

    /// Adds an interface: its name, link type, resolution of stamps, and the length to which packets were cut (0 for
    /// none).
    pub(super) fn interface(&mut self, name: &[u8], link_type: u16, resolution: &str, snaplen: u32) {
        self.interfaces += 1;
        if self.interfaces > INTERFACES {
            return;
        }
        let mut text = name.to_vec();
        text.extend_from_slice(b": ");
        link_name(&mut text, link_type);
        // Writing to memory cannot fail.
        let _ = write!(text, ", {resolution}");
        if snaplen > 0 {
            let _ = write!(text, ", snaplen {snaplen}");
        }
        self.note("interface", &text);
    }

    /// Returns all facts.
    pub(super) fn contents(&self) -> Contents {
        let mut passed_over: Vec<(Vec<u8>, u64)> =
            self.passed.iter().map(|(kind, count)| (name(*kind), *count)).collect();
        if self.others > 0 {
            passed_over.push((b"...".to_vec(), self.others));
        }
        Contents { dialect: self.dialect.clone(), passed_over, topics: Vec::new() }
    }
}

fn name(kind: Passed) -> Vec<u8> {
    let mut out = Vec::new();
    match kind {
        Passed::Packet(link_type) => link_name(&mut out, link_type),
        Passed::Protocol(protocol) => out = format!("LINUX_SLL protocol 0x{protocol:04X}").into_bytes(),
        Passed::Block(kind) => match BLOCKS.iter().find(|(number, _)| *number == kind) {
            Some((_, name)) => out.extend_from_slice(name.as_bytes()),
            None => out = format!("block 0x{kind:08X}").into_bytes(),
        },
    }
    out
}

fn link_name(out: &mut Vec<u8>, link_type: u16) {
    let name = LINK_TYPES.iter().find(|(number, _)| *number == link_type).map_or("LINKTYPE", |(_, name)| name);
    let _ = write!(out, "{name} ({link_type})");
}

/// Link types found beside CAN, by their registered names without LINKTYPE_.
const LINK_TYPES: &[(u16, &str)] = &[
    (0, "NULL"),
    (1, "ETHERNET"),
    (101, "RAW"),
    (105, "IEEE802_11"),
    (113, "LINUX_SLL"),
    (127, "IEEE802_11_RADIOTAP"),
    (147, "USER0"),
    (187, "BLUETOOTH_HCI_H4"),
    (189, "USB_LINUX"),
    (190, "CAN20B"),
    (195, "IEEE802_15_4_WITHFCS"),
    (201, "BLUETOOTH_HCI_H4_WITH_PHDR"),
    (210, "FLEXRAY"),
    (212, "LIN"),
    (220, "USB_LINUX_MMAPPED"),
    (227, "CAN_SOCKETCAN"),
    (231, "DBUS"),
    (239, "NFLOG"),
    (249, "USBPCAP"),
    (252, "WIRESHARK_UPPER_PDU"),
    (253, "NETLINK"),
    (254, "BLUETOOTH_LINUX_MONITOR"),
    (276, "LINUX_SLL2"),
];

/// Blocks of pcapng without a packet.
const BLOCKS: &[(u32, &str)] = &[
    (4, "Name Resolution Block"),
    (9, "systemd Journal Export Block"),
    (10, "Decryption Secrets Block"),
    (0xBAD, "Custom Block"),
    (0x4000_0BAD, "Custom Block, not to be copied"),
];
