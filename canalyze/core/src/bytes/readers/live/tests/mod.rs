//! Blocks as a receiver makes them, and their results.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic, dead_code)]

mod sessions;
mod stream;

use super::kind;
use super::messages::{CONTROL, FRAME};
use crate::bytes::frame::{Frame, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::writers::{CaptureFacts, packed::Packed};

/// Makes one block.
pub(super) fn block(kind: u8, bus: u8, which: u8, number: i64, body: &[u8]) -> Vec<u8> {
    let mut out = vec![kind, bus, which, 0];
    out.extend_from_slice(&(body.len() as u32).to_le_bytes());
    out.extend_from_slice(&number.to_le_bytes());
    out.extend_from_slice(body);
    out
}

pub(super) fn named(bus: u8, name: &str) -> Vec<u8> {
    block(kind::BUS, bus, 0, 0, name.as_bytes())
}

pub(super) fn until(now_ns: Ns) -> Vec<u8> {
    block(kind::UNTIL, 0, 0, now_ns.as_ns(), b"")
}

/// The kernel's data for one message.
#[derive(Clone, Debug)]
pub(super) struct Sent {
    /// `struct can_frame` or `struct canfd_frame`.
    pub(super) frame: Vec<u8>,
    pub(super) flags: u32,
    pub(super) kernel: Option<i64>,
    pub(super) hardware: Option<i64>,
    pub(super) overflow: Option<u32>,
}

impl Sent {
    /// Makes a frame as the kernel delivers it.
    pub(super) fn new(frame: &Frame) -> Self {
        let fd = matches!(frame.kind, Kind::Fd { .. });
        let bit = |set: bool, bit: u32| if set { bit } else { 0 };
        let id = frame.id.raw()
            | bit(frame.id.is_extended() && frame.kind != Kind::Error, 1 << 31)
            | bit(frame.kind == Kind::Remote, 1 << 30)
            | bit(frame.kind == Kind::Error, 1 << 29);
        let mut bytes = id.to_ne_bytes().to_vec();
        let flags = match frame.kind {
            Kind::Fd { brs, esi } => 4 | u8::from(brs) | u8::from(esi) << 1,
            _ => 0,
        };
        bytes.extend_from_slice(&[frame.len, flags, 0, frame.length_form.raw_dlc]);
        bytes.extend_from_slice(&frame.data[..if fd { 64 } else { 8 }]);
        let flags = if frame.dir == Some(crate::bytes::frame::Direction::Tx) { 0x4 } else { 0 };
        Self { frame: bytes, flags, kernel: frame.t_ns.map(Ns::as_ns), hardware: None, overflow: None }
    }
}

/// Appends a control message with its padding.
fn control(out: &mut Vec<u8>, word: usize, kind: u32, data: &[u8]) {
    let head = (word + 8).next_multiple_of(word);
    out.extend_from_slice(&size(head + data.len(), word));
    out.extend_from_slice(&1_u32.to_ne_bytes());
    out.extend_from_slice(&kind.to_ne_bytes());
    out.extend_from_slice(data);
    out.resize(out.len().next_multiple_of(word), 0xAA);
}

fn size(size: usize, word: usize) -> Vec<u8> {
    if word == 8 { (size as u64).to_ne_bytes().to_vec() } else { (size as u32).to_ne_bytes().to_vec() }
}

fn timespec(ns: i64, word: usize) -> Vec<u8> {
    let [s, ns] = [ns.div_euclid(1_000_000_000), ns.rem_euclid(1_000_000_000)];
    let wide = [s, ns].map(i64::to_ne_bytes).concat();
    if word == 8 { wide } else { [s as i32, ns as i32].map(i32::to_ne_bytes).concat() }
}

/// Makes the structures and slots of messages for a host with this word size.
pub(super) fn messages(sent: &[Sent], word: usize) -> Vec<u8> {
    let (mut headers, mut slots) = (Vec::new(), Vec::new());
    for one in sent {
        let mut controls = Vec::new();
        if let Some(ns) = one.hardware {
            let stamps = [timespec(0, word), timespec(0, word), timespec(ns, word)].concat();
            control(&mut controls, word, 37, &stamps);
        }
        if let Some(total) = one.overflow {
            control(&mut controls, word, 40, &total.to_ne_bytes());
        }
        if let Some(ns) = one.kernel {
            control(&mut controls, word, 35, &timespec(ns, word));
        }
        // name, namelen with padding, iov, iovlen, control: pointers are garbage.
        headers.extend_from_slice(&vec![0x5A; 5 * word]);
        headers.extend_from_slice(&size(controls.len(), word));
        headers.extend_from_slice(&size(one.flags as usize, word));
        headers.extend_from_slice(&size(one.frame.len(), word));
        let mut slot = one.frame.clone();
        slot.resize(FRAME, 0x77);
        slot.extend_from_slice(&controls);
        slot.resize(FRAME + CONTROL, 0x99);
        slots.extend_from_slice(&slot);
    }
    [headers, slots].concat()
}

/// Makes a block of messages for this host.
pub(super) fn received(bus: u8, which: u8, sent: &[Sent]) -> Vec<u8> {
    block(kind::MESSAGES, bus, which, sent.len() as i64, &messages(sent, size_of::<usize>()))
}

/// Makes a block of frames of python-can.
pub(super) fn records(bus: u8, frames: &[Frame], setting: CaptureFacts<'_>) -> Vec<u8> {
    let (mut writer, mut out) = (Packed::default(), Vec::new());
    for frame in frames {
        writer.frame(&mut out, setting, frame);
    }
    block(kind::RECORDS, bus, 0, 0, &out)
}
