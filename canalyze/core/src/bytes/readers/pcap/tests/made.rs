//! Files packed by hand.

use super::super::ByteOrder;

pub(super) fn two(order: ByteOrder, value: u16) -> [u8; 2] {
    if order == ByteOrder::Big { value.to_be_bytes() } else { value.to_le_bytes() }
}

pub(super) fn four(order: ByteOrder, value: u32) -> [u8; 4] {
    if order == ByteOrder::Big { value.to_be_bytes() } else { value.to_le_bytes() }
}

pub(super) fn eight(order: ByteOrder, value: u64) -> [u8; 8] {
    if order == ByteOrder::Big { value.to_be_bytes() } else { value.to_le_bytes() }
}

/// Makes the classic structure of SocketCAN.
pub(super) fn classic(id: u32, data: &[u8]) -> Vec<u8> {
    let mut out = [&id.to_be_bytes()[..], &[data.len() as u8, 0, 0, 0], data].concat();
    out.resize(16, 0);
    out
}

/// Makes the FD structure of SocketCAN.
pub(super) fn fd(id: u32, flags: u8, data: &[u8]) -> Vec<u8> {
    let mut out = [&id.to_be_bytes()[..], &[data.len() as u8, flags, 0, 0], data].concat();
    out.resize(72, 0);
    out
}

pub(super) fn sll(kind: u16, protocol: u16, packet: &[u8]) -> Vec<u8> {
    let head = [kind, 280, 0, 0, 0, 0, 0, protocol].map(u16::to_be_bytes).concat();
    [&head, packet].concat()
}

pub(super) fn sll2(kind: u16, protocol: u16, interface: u16, packet: &[u8]) -> Vec<u8> {
    let head = [protocol, 0, 0, interface, 280, kind << 8, 0, 0, 0, 0].map(u16::to_be_bytes).concat();
    [&head, packet].concat()
}

pub(super) fn legacy(order: ByteOrder, nano: bool, link_type: u32) -> Vec<u8> {
    let magic = if nano { 0xA1B2_3C4D } else { 0xA1B2_C3D4 };
    let version = [two(order, 2), two(order, 4)].concat();
    let words = [0, 0, 65535, link_type].map(|word| four(order, word)).concat();
    [four(order, magic).to_vec(), version, words].concat()
}

pub(super) fn record(order: ByteOrder, seconds: u32, fraction: u32, packet: &[u8]) -> Vec<u8> {
    let size = packet.len() as u32;
    let head = [seconds, fraction, size, size].map(|word| four(order, word)).concat();
    [&head, packet].concat()
}

pub(super) fn block(order: ByteOrder, kind: u32, body: &[u8]) -> Vec<u8> {
    let mut out = [&four(order, kind)[..], &[0; 4], body].concat();
    out.resize(out.len().next_multiple_of(4), 0);
    let len = four(order, out.len() as u32 + 4);
    out[4..8].copy_from_slice(&len);
    [&out, &len[..]].concat()
}

pub(super) fn option(order: ByteOrder, code: u16, value: &[u8]) -> Vec<u8> {
    let mut out = [&two(order, code)[..], &two(order, value.len() as u16), value].concat();
    out.resize(out.len().next_multiple_of(4), 0);
    out
}

pub(super) fn shb(order: ByteOrder) -> Vec<u8> {
    let body = [&four(order, 0x1A2B_3C4D)[..], &two(order, 1), &two(order, 0), &[0xFF; 8]].concat();
    block(order, 0x0A0D_0D0A, &[body, option(order, 4, b"made by hand"), option(order, 0, b"")].concat())
}

pub(super) fn idb(order: ByteOrder, link_type: u16, snaplen: u32, options: &[u8]) -> Vec<u8> {
    block(order, 1, &[&two(order, link_type)[..], &[0; 2], &four(order, snaplen), options].concat())
}

pub(super) fn epb(order: ByteOrder, interface: u32, units: u64, packet: &[u8], options: &[u8]) -> Vec<u8> {
    let size = packet.len() as u32;
    let head = [interface, (units >> 32) as u32, units as u32, size, size].map(|word| four(order, word)).concat();
    let mut packet = packet.to_vec();
    packet.resize(packet.len().next_multiple_of(4), 0);
    block(order, 6, &[&head, &packet, options].concat())
}

/// A file with the offsets of its records.
#[derive(Clone, Default)]
pub(super) struct Made {
    pub(super) bytes: Vec<u8>,
    pub(super) starts: Vec<usize>,
}

impl Made {
    pub(super) fn add(&mut self, record: Vec<u8>) {
        self.starts.push(self.bytes.len());
        self.bytes.extend(record);
    }
}

/// Makes a section with two interfaces and six frames; those on the first bus are `001`, `003`, `005`.
pub(super) fn sample(order: ByteOrder) -> Made {
    let mut file = Made::default();
    file.add(shb(order));
    for name in [b"can0", b"can1"] {
        file.add(idb(order, 227, 0, &option(order, 2, name)));
    }
    for no in 1..=6 {
        let packet = if no == 4 { fd(4, 4, &[4]) } else { classic(no, &[no as u8]) };
        file.add(epb(order, (no + 1) % 2, u64::from(no), &packet, &[]));
    }
    file
}
