//! Arbitrary traffic of a whole network, for the targets that push frames.
//!
//! Each frame is two bytes of identifier and kind, one byte of time since the frame before, one byte of length, and its
//! data.

use canalyze_core::bytes::frame::{BusId, CanId, Frame, Kind, Stamp, StampForm};
use canalyze_core::bytes::ns::Ns;
use canalyze_core::world::dictionary::{Access, Dictionary, Form, Object, Preset};
use canalyze_core::world::network::{Description, Network};
use std::sync::Arc;

/// Time since the frame before, in ns, by the byte's lowest three bits; bit 3 makes it a step back.
const GAPS_NS: [i64; 8] = [0, 200_000, 1_000_000, 4_900_000, 10_000_000, 50_000_000, 600_000_000, i64::MAX / 4];

fn object(index: u16, sub: u8, data_type: u16, value: u64) -> Object {
    Object {
        index,
        sub,
        name: format!("object {index:04X}").into(),
        data_type,
        access: if index == 0x6041 { Access::Ro } else { Access::Rw },
        preset: Some(Preset { value, relative: sub == 1 && index & 0xFF00 == 0x1800, configured: false }),
        mappable: true,
        unit: (index == 0x606C).then(|| "rpm".into()),
        factor: if index == 0x6077 { 0.1 } else { 1.0 },
    }
}

/// A drive: TPDO 1 event-driven with timers, TPDO 2 with every SYNC, SYNC times, a heartbeat.
pub fn network() -> Network {
    let objects = vec![
        object(0x1000, 0, 7, 0x0002_0192),
        object(0x1006, 0, 7, 10_000),
        object(0x1007, 0, 7, 2_000),
        object(0x1017, 0, 6, 100),
        object(0x1800, 1, 7, 0x4000_0180),
        object(0x1800, 2, 5, 255),
        object(0x1800, 3, 6, 100),
        object(0x1800, 5, 6, 50),
        object(0x1A00, 0, 5, 3),
        object(0x1A00, 1, 7, 0x6041_0010),
        object(0x1A00, 2, 7, 0x606C_0020),
        object(0x1A00, 3, 7, 0x6077_0010),
        object(0x1801, 1, 7, 0x4000_0280),
        object(0x1801, 2, 5, 1),
        object(0x1A01, 0, 5, 1),
        object(0x1A01, 1, 7, 0x2000_010D),
        object(0x6041, 0, 6, 0),
        object(0x606C, 0, 4, 0),
        object(0x6077, 0, 3, 0),
    ];
    let dictionary = Arc::new(Dictionary::new("drive.eds".into(), Form::Eds, "drive".into(), objects));
    Network { descriptions: vec![Description { bus: None, node: 5, dictionary }], ..Network::default() }
}

/// The frames of the input, on at most two buses.
pub fn frames(mut input: &[u8], stamped: bool) -> Vec<Frame> {
    let mut frames = Vec::new();
    let mut now = 1_000_000_000_i64;
    while let [high, low, time, length, rest @ ..] = input {
        let len = usize::from(length % 9).min(rest.len());
        let (data, after) = rest.split_at(len);
        input = after;
        let gap = GAPS_NS[usize::from(time & 7)];
        now = now.saturating_add(if time & 8 == 0 { gap } else { -gap });
        let word = u16::from_be_bytes([*high, *low]);
        let id = if high & 0x40 == 0 { CanId::standard(word & 0x7FF) } else { CanId::extended(u32::from(word)) };
        let mut frame = Frame::classic(id, data);
        frame.bus = BusId(time >> 7);
        frame.kind = match high >> 4 & 3 {
            1 => Kind::Remote,
            2 => Kind::Error,
            3 => Kind::Fd { brs: false, esi: false },
            _ => Kind::Data,
        };
        if stamped {
            frame.t_ns = Some(Ns(now));
            frame.stamp = Some(Stamp { form: StampForm::Seconds, ns: Ns(now), width: 1, decimals: 6 });
        }
        frames.push(frame);
    }
    frames
}
