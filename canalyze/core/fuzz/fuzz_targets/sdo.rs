//! Arbitrary SDO traffic, pushed frame by frame: no panic, and every frame has its line in every kind of output.
//!
//! The first byte sets the options. Each frame is then a control byte and its data: side, node, bus, the time since
//! the frame before, and what kind of frame it is, so that the fuzzer finds sessions and not only single frames.
#![no_main]

mod outputs;

use canalyze_core::bytes::frame::{BusId, CanId, Frame, Kind};
use canalyze_core::bytes::ns::Ns;
use libfuzzer_sys::fuzz_target;

const NODES: [u16; 4] = [1, 2, 10, 127];
/// Within a response time, within the hold of a response, beyond it, beyond a client's patience.
const GAPS_NS: [i64; 4] = [400_000, 4_900_000, 5_100_000, 1_500_000_000];

/// Frames of up to 8 bytes, from a control byte each: `sbnnggkk`.
fn frames(mut input: &[u8], stamped: bool) -> Vec<Frame> {
    let mut frames = Vec::new();
    let mut now = 1_000_000_000_i64;
    while let Some((&control, rest)) = input.split_first() {
        input = rest;
        let node = NODES[usize::from(control >> 4 & 3)];
        let mut id = CanId::standard(if control & 0x80 == 0 { 0x600 } else { 0x580 } + node);
        now += GAPS_NS[usize::from(control >> 2 & 3)];
        let mut len = 8;
        let mut kind = Kind::Data;
        match control & 3 {
            0 | 1 => {}
            // A short frame: its length stands before its data.
            2 => {
                let Some((&byte, rest)) = input.split_first() else { break };
                input = rest;
                len = usize::from(byte % 9);
            }
            // What ends transfers, what is no SDO though it has its identifier, and a step back in time.
            _ => {
                let Some((&what, rest)) = input.split_first() else { break };
                input = rest;
                match what % 6 {
                    0 => (id, len) = (CanId::standard(0), 2),
                    1 => (id, len) = (CanId::standard(0x700 + node), 1),
                    2 => kind = Kind::Remote,
                    3 => kind = Kind::Fd { brs: what & 0x40 != 0, esi: what & 0x80 != 0 },
                    4 => id = CanId::extended(u32::from(what)),
                    _ => now -= 10_000_000,
                }
            }
        }
        let (data, rest) = input.split_at(len.min(input.len()));
        input = rest;
        let mut frame = Frame::classic(id, data);
        frame.kind = kind;
        frame.bus = BusId(control >> 6 & 1);
        outputs::place(&mut frame, frames.len(), stamped.then_some(Ns(now)));
        frames.push(frame);
    }
    frames
}

fuzz_target!(|input: &[u8]| {
    let Some((options, traffic)) = input.split_first() else { return };
    outputs::check(&frames(traffic, options & 2 == 0), *options);
});
