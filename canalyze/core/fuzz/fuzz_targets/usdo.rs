//! Arbitrary USDO traffic (CANopen FD), pushed frame by frame: no panic, and every frame has its line in every kind of
//! output.
//!
//! The first byte sets the options. Each frame is then a control byte (server's side, client, time since the frame
//! before, kind), one of server and session, a length and its bytes from the command on; the head is made of the control
//! bytes, so that the fuzzer finds transfers and not only single frames.
#![no_main]

mod outputs;

use canalyze_core::bytes::frame::{CanId, Frame, Kind};
use canalyze_core::bytes::ns::Ns;
use libfuzzer_sys::fuzz_target;

const NODES: [u8; 4] = [1, 2, 10, 127];
/// Within a response time, within the hold of a response, beyond it, beyond a client's patience.
const GAPS_NS: [i64; 4] = [400_000, 4_900_000, 5_100_000, 1_500_000_000];

/// Returns the length of the FD frame that holds this number of bytes.
fn fd_length(bytes: usize) -> u8 {
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48]
        .into_iter()
        .find(|length| usize::from(*length) >= bytes)
        .unwrap_or(64)
}

/// Frames from `sccggkkk`, `ddiiiiii` and a length each: s the server's side, c the client, d the server, i the session.
fn frames(mut input: &[u8], stamped: bool) -> Vec<Frame> {
    let mut frames = Vec::new();
    let mut now = 1_000_000_000_i64;
    while let [control, head, length, rest @ ..] = input {
        let len = usize::from(length & 63).min(rest.len());
        let (body, after) = rest.split_at(len);
        input = after;
        let client = NODES[usize::from(control >> 5 & 3)];
        let server = NODES[usize::from(head >> 6)];
        let session = head & 63;
        now += GAPS_NS[usize::from(control >> 3 & 3)];
        let (base, sender, receiver) =
            if control & 0x80 == 0 { (0x600, client, server) } else { (0x580, server, client) };
        let mut id = CanId::standard(base + u16::from(sender));
        let mut kind = Kind::Fd { brs: control & 1 != 0, esi: false };
        let mut data = vec![receiver];
        if let [command, fields @ ..] = body {
            data.extend_from_slice(&[*command, session]);
            data.extend_from_slice(fields);
        }
        // What is no USDO: a reset, a boot-up, a classic frame, a step back in time.
        match control & 7 {
            4 => (id, kind, data) = (CanId::standard(0), Kind::Data, vec![0x81, server]),
            5 => (id, kind, data) = (CanId::standard(0x700 + u16::from(server)), Kind::Data, vec![0]),
            6 => kind = Kind::Data,
            7 => now -= 10_000_000,
            _ => {}
        }
        let mut frame = Frame::classic(id, &data);
        if kind != Kind::Data {
            frame.kind = kind;
            frame.len = fd_length(data.len());
            for (slot, byte) in frame.data.iter_mut().zip(&data).skip(8) {
                *slot = *byte;
            }
        }
        outputs::place(&mut frame, frames.len(), stamped.then_some(Ns(now)));
        frames.push(frame);
    }
    frames
}

fuzz_target!(|input: &[u8]| {
    let Some((options, traffic)) = input.split_first() else { return };
    outputs::check(&frames(traffic, options & 2 == 0), *options);
});
