//! Properties of any two captures.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use proptest::prelude::*;

use super::digest::Digest;
use super::{DiffSettings, compare};
use crate::bytes::frame::{CanId, Frame, Stamp, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::InputFormat as Input;
use crate::session::{Options, Output, Session};
use crate::words::Lang;

fn settings() -> DiffSettings {
    DiffSettings { tolerance: 0.1, buses: Vec::new() }
}

fn digest(frames: &[Frame]) -> Digest {
    let mut session = Session::new(Options::of(Lang::Zh, &[Output::Digest]));
    let mut out = Vec::new();
    session.begin(b"x", Input::Candump, true);
    for frame in frames {
        session.push(*frame, &mut out);
    }
    session.finish(&mut out);
    assert!(out.is_empty());
    session.take_digest().unwrap()
}

fn frames() -> impl Strategy<Value = Vec<Frame>> {
    let ids = [0x000, 0x080, 0x085, 0x185, 0x205, 0x285, 0x605, 0x585, 0x605, 0x585, 0x606, 0x586, 0x705, 0x706, 0x7E5];
    let heads = [0x40, 0x43, 0x4B, 0x23, 0x2B, 0x60, 0x80, 0x41, 0x00, 0x10, 0x01, 0x05, 0x7F, 0xC2, 0xA4];
    let frame = (0..ids.len(), 0..heads.len(), 0..4_u8, 0..3_u8, 0..9_usize, 0..3_000_000_i64);
    let stamped = any::<bool>();
    (proptest::collection::vec(frame, 0..60), stamped).prop_map(move |(drawn, stamped)| {
        let mut now_ns = 1_700_000_000_000_000_000;
        drawn
            .into_iter()
            .map(|(id, head, index, value, len, step_ns)| {
                let mut data = [heads[head], index, 0x20, 0, value, 0, 0, 0];
                if ids[id] == 0 {
                    data[..2].copy_from_slice(&[[0x01, 0x80, 0x81, 0x82][usize::from(index)], 5]);
                }
                let mut frame = Frame::classic(CanId::standard(ids[id]), &data[..if len < 6 { 8 } else { len }]);
                now_ns += step_ns;
                if stamped {
                    frame.t_ns = Some(Ns(now_ns));
                    frame.stamp = Some(Stamp { form: StampForm::Seconds, ns: Ns(now_ns), width: 10, decimals: 9 });
                }
                frame
            })
            .collect()
    })
}

proptest! {
    #[test]
    fn a_capture_is_the_same_as_itself(one in frames()) {
        let digest = digest(&one);
        let found = compare(&digest, &digest, &settings());
        prop_assert!(found.differences.is_empty(), "{:?}", found.differences);
    }

    #[test]
    fn any_two_can_be_compared(one in frames(), other in frames()) {
        let (a, b) = (digest(&one), digest(&other));
        compare(&a, &b, &settings());
        compare(&b, &a, &settings());
    }
}
