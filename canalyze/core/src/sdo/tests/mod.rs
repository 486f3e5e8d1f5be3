//! The reference's worked examples as literal bytes, and the law of pairing.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::sync::Arc;

use proptest::prelude::*;

use super::state::SdoChannel;
use super::transfer::{Direction, Mode, Status, Transfer};
use super::wire::{Mux, Side};
use crate::bytes::frame::{BusId, CanId, Frame};
use crate::bytes::ns::Ns;
use crate::evidence::duplicates::Sighting;
use crate::evidence::recording::RecordedFrame;
use crate::evidence::{Evidence, When};
use crate::rules::finding::{Code, Finding, Severity};
use crate::world::context::{Chunk, Context};
use crate::world::event::What;

mod table;
mod verdicts;
mod wire;

type Bytes = (Side, Vec<u8>);

/// Parses `c 40 08 10 00` or `s 41 ...`, frames separated by `/`; short frames are padded to eight bytes.
fn frames(text: &str) -> Vec<Bytes> {
    text.split('/')
        .map(|frame| {
            let mut words = frame.split_whitespace();
            let side = if words.next().unwrap() == "c" { Side::Client } else { Side::Server };
            let mut bytes: Vec<u8> = words.map(|word| u8::from_str_radix(word, 16).unwrap()).collect();
            bytes.resize(8, 0);
            (side, bytes)
        })
        .collect()
}

#[derive(Default, Debug)]
struct Outcome {
    transfers: Vec<Arc<Transfer>>,
    findings: Vec<Finding>,
    steps: usize,
}

impl Outcome {
    fn codes(&self) -> Vec<Code> {
        self.findings.iter().map(|finding| finding.code).collect()
    }

    fn loud(&self) -> Vec<&Finding> {
        self.findings.iter().filter(|finding| finding.severity() > Severity::Info).collect()
    }

    fn only(&self) -> &Transfer {
        assert_eq!(self.transfers.len(), 1, "{self:?}");
        &self.transfers[0]
    }
}

fn run(frames: &[Bytes]) -> Outcome {
    run_timed(frames, |_| None)
}

/// Creates a frame of server 10's channel at a place in a capture.
fn placed(side: Side, bytes: &[u8], no: usize, t_ns: Option<Ns>) -> Frame {
    let id = if side == Side::Client { 0x60A } else { 0x58A };
    let mut frame = Frame::classic(CanId::standard(id), bytes);
    (frame.no, frame.t_ns) = (no as u64 + 1, t_ns);
    frame
}

fn run_timed(frames: &[Bytes], time: impl Fn(usize) -> Option<i64>) -> Outcome {
    let mut channel = SdoChannel::new(BusId(0), 10, None);
    let (mut events, mut next, mut chunks) = (Vec::new(), 0, Vec::new());
    let mut at = Default::default();
    let mut evidence = Evidence::default();
    for (no, (side, bytes)) in frames.iter().enumerate() {
        let frame = placed(*side, bytes, no, time(no).map(Ns));
        let behind =
            frames.get(no + 1).map(|(side, bytes)| (*side, placed(*side, bytes, no + 1, time(no + 1).map(Ns))));
        at = frame.reference();
        let RecordedFrame { mut when, happened } = evidence.recording.observe(&frame);
        evidence.recording.take(&mut when, happened.as_deref(), &frame, *side == Side::Client);
        let mut cx = Context {
            events: &mut events,
            next_transfer: &mut next,
            extract: true,
            chunks: &mut chunks,
            bus: BusId(0),
            at,
            evidence: &mut evidence,
            when,
            sighting: Sighting::Original,
            next: None,
            repeats: None,
            news_only: false,
        };
        channel.step(*side, &frame, behind.as_ref(), &mut cx);
    }
    let mut cx = Context {
        events: &mut events,
        next_transfer: &mut next,
        extract: true,
        chunks: &mut chunks,
        bus: BusId(0),
        at,
        evidence: &mut evidence,
        when: When { at, ..When::default() },
        sighting: Sighting::Original,
        next: None,
        repeats: None,
        news_only: false,
    };
    channel.finish(&mut cx);
    let mut outcome = Outcome::default();
    for event in events {
        match event.what {
            What::Transfer(transfer) => outcome.transfers.push(transfer),
            What::Finding(finding) => outcome.findings.push(*finding),
            What::Sdo(_) => outcome.steps += 1,
            _ => {}
        }
    }
    assert_eq!(outcome.steps, frames.len(), "every frame has its step");
    for transfer in &outcome.transfers {
        if transfer.outcome.status == Status::Ok {
            let bytes: Vec<u8> = chunks
                .iter()
                .filter(|chunk: &&Chunk| chunk.id == transfer.id)
                .flat_map(|chunk| chunk.bytes.clone())
                .collect();
            assert_eq!(bytes, transfer.data.kept, "extracted bytes are the value");
        }
    }
    outcome
}

const NAME: &[u8] = b"Zephyr RTOS/CANopenNode";
const E1: &str = "c 40 08 10 00/s 41 08 10 00 17/c 60/s 00 5A 65 70 68 79 72 20/c 70/s 10 52 54 4F 53 2F 43 41/\
    c 60/s 00 4E 6F 70 65 6E 4E 6F/c 70/s 1B 64 65";
const E12: &str = "c A4 04 20 00 7F/s C6 04 20 00 14/c A3/s 01 00 01 02 03 04 05 06/s 02 07 08 09 0A 0B 0C 0D/\
    s 83 0E 0F 10 11 12 13 00/c A2 03 7F/s C5 CC AC/c A1";
const E13: &str = "c A4 04 20 00 02/s C6 04 20 00 14/c A3/s 01 00 01 02 03 04 05 06/s 02 07 08 09 0A 0B 0C 0D/\
    c A2 02 02/s 81 0E 0F 10 11 12 13 00/c A2 01 02/s C5 CC AC/c A1";
const E14: &str = "c C6 04 20 00 14/s A4 04 20 00 7F/c 01 00 01 02 03 04 05 06/c 83 0E 0F 10 11 12 13 00/\
    s A2 01 7F/c 01 07 08 09 0A 0B 0C 0D/c 82 0E 0F 10 11 12 13 00/s A2 02 7F/c C5 CC AC/s A1";
const E15: &str = "c A4 04 20 00 7F/s C6 04 20 00 14/c A3/s 01 00 01 02 03 04 05 06/s 02 07 08 09 0A 0B 0C 0D/\
    s 83 0E 0F 10 11 12 13 00/c A2 01 7F/s 01 07 08 09 0A 0B 0C 0D/s 82 0E 0F 10 11 12 13 00/c A2 02 7F/\
    s C5 CC AC/c A1";
const E15_ZERO: &str = "c A4 04 20 00 7F/s C6 04 20 00 14/c A3/s 01 00 01 02 03 04 05 06/s 02 07 08 09 0A 0B 0C 0D/\
    s 83 0E 0F 10 11 12 13 00/c A2 00 7F/s 01 00 01 02 03 04 05 06/s 02 07 08 09 0A 0B 0C 0D/\
    s 83 0E 0F 10 11 12 13 00/c A2 03 7F/s C5 CC AC/c A1";
const E17: &str = "c A4 08 10 00 7F/s C6 08 10 00 17/c A3/s 01 5A 65 70 68 79 72 20/s 02 52 54 4F 53 2F 43 41/\
    s 03 4E 6F 70 65 6E 4E 6F/s 84 64 65/c A2 04 7F/s D5 20 3E/c A1";

fn counting(n: u8) -> Vec<u8> {
    (0..n).collect()
}

#[track_caller]
fn check_ok(text: &str, direction: Direction, mode: Mode, mux: (u16, u8), data: &[u8]) -> Outcome {
    let outcome = run(&frames(text));
    {
        let transfer = outcome.only();
        assert_eq!(transfer.outcome.status, Status::Ok);
        assert_eq!((transfer.direction, transfer.mode), (direction, mode));
        assert_eq!(transfer.mux, Some(Mux { index: mux.0, sub: mux.1 }));
        assert_eq!(transfer.data.kept, data);
        assert_eq!(transfer.data.size, data.len() as u64);
    }
    outcome
}

#[test]
fn e1_segmented_upload_in_causal_order() {
    let outcome = check_ok(E1, Direction::Upload, Mode::Segmented, (0x1008, 0), NAME);
    assert!(outcome.findings.is_empty(), "{outcome:?}");
}

#[test]
fn the_listing_of_the_notes() {
    let listing = "c 40 08 10 00/s 41 08 10 00 17/s 00 5A 65 70 68 79 72 20/c 60/c 70/s 10 52 54 4F 53 2F 43 41/\
        s 00 4E 6F 70 65 6E 4E 6F/c 60/c 70/s 1B 64 65";
    let outcome = check_ok(listing, Direction::Upload, Mode::Segmented, (0x1008, 0), NAME);
    assert!(outcome.findings.is_empty(), "{outcome:?}");
    assert!(outcome.only().outcome.reordered);
}

#[test]
fn e2_to_e4_expedited_uploads() {
    use Direction::Upload;
    use Mode::Expedited;
    check_ok("c 40 00 20 00/s 43 00 20 00 78 56 34 12", Upload, Expedited, (0x2000, 0), &[0x78, 0x56, 0x34, 0x12]);
    check_ok("c 40 01 20 00/s 4B 01 20 00 EF BE", Upload, Expedited, (0x2001, 0), &[0xEF, 0xBE]);
    check_ok("c 40 02 20 00/s 4F 02 20 00 5A", Upload, Expedited, (0x2002, 0), &[0x5A]);
}

#[test]
fn e5_to_e7_segmented_and_writes() {
    let u64_read = "c 40 03 20 00/s 41 03 20 00 08/c 60/s 00 88 77 66 55 44 33 22/c 70/s 1D 11";
    let value = 0x1122_3344_5566_7788_u64.to_le_bytes();
    check_ok(u64_read, Direction::Upload, Mode::Segmented, (0x2003, 0), &value);
    let write = "c 23 00 20 00 0A/s 60 00 20 00";
    check_ok(write, Direction::Download, Mode::Expedited, (0x2000, 0), &[10, 0, 0, 0]);
    let segmented = "c 21 04 20 00 14/s 60 04 20 00/c 00 00 01 02 03 04 05 06/s 20/c 10 07 08 09 0A 0B 0C 0D/s 30/\
        c 03 0E 0F 10 11 12 13 00/s 20";
    check_ok(segmented, Direction::Download, Mode::Segmented, (0x2004, 0), &counting(20));
}

#[test]
fn e8_aborts() {
    let outcome = run(&frames(
        "c 23 05 20 00/s 80 05 20 00 02 00 01 06/c 40 00 50 01/s 80 00 50 01 00 00 02 06/c 40 02 20 00/s 4F 02 20 00 5A",
    ));
    assert_eq!(outcome.transfers.len(), 3);
    assert_eq!(outcome.transfers[0].outcome.abort.unwrap().code.number(), 0x0601_0002);
    assert_eq!(outcome.transfers[1].outcome.abort.unwrap().code.number(), 0x0602_0000);
    assert_eq!(outcome.codes(), [Code::Sdo017, Code::Sdo017]);
}

#[test]
fn e9_toggle_errors() {
    let first = "c 40 08 10 00/s 41 08 10 00 17/c 70/s 80 08 10 00 00 00 03 05";
    assert_eq!(run(&frames(first)).codes(), [Code::Sdo001, Code::Sdo017]);
    let twice = "c 40 08 10 00/s 41 08 10 00 17/c 60/s 00 5A 65 70 68 79 72 20/c 60/s 80 08 10 00 00 00 03 05";
    assert_eq!(run(&frames(twice)).codes(), [Code::Sdo001, Code::Sdo017]);
    let download = "c 21 03 20 00 0C/s 60 03 20 00/c 00 01 02 03 04 05 06 07/s 20/c 0D 07/s 80 03 20 00 00 00 03 05";
    assert!(run(&frames(download)).codes().contains(&Code::Sdo001));
}

#[test]
fn e10_size() {
    let text = "c 21 03 20 00 08/s 60 03 20 00/c 01 00 01 02 03 04 05 06/s 80 03 20 00 13 00 07 06";
    assert_eq!(run(&frames(text)).codes(), [Code::Sdo006, Code::Sdo017]);
}

#[test]
fn e11_short_segment() {
    let text = "c 21 03 20 00 08/s 60 03 20 00/c 02 00 01 02 03 04 05/s 20/c 1B 06 07/s 30";
    let outcome = check_ok(text, Direction::Download, Mode::Segmented, (0x2003, 0), &counting(8));
    assert_eq!(outcome.codes(), [Code::Sdo005]);
}

#[test]
fn e12_to_e17_block() {
    for (text, data, retransmissions) in [
        (E12, counting(20), 0),
        (E13, counting(20), 0),
        (E14, counting(20), 1),
        (E15, counting(20), 1),
        (E15_ZERO, counting(20), 1),
        (E17, NAME.to_vec(), 0),
    ] {
        let outcome = run(&frames(text));
        let transfer = outcome.only();
        assert_eq!((transfer.outcome.status, &transfer.data.kept), (Status::Ok, &data), "{text}");
        assert_eq!(transfer.outcome.retransmissions, retransmissions, "{text}");
        let again = vec![Code::Sdo025; retransmissions as usize];
        assert_eq!(outcome.codes(), again, "{text}: {outcome:?}");
    }
}

#[test]
fn e16_bad_end() {
    let bad_crc = E14.replace("C5 CC AC/s A1", "C5 CD AC/s 80 04 20 00 04 00 04 05");
    assert_eq!(run(&frames(&bad_crc)).codes(), [Code::Sdo025, Code::Sdo019, Code::Sdo017]);
    let bad_n = E14.replace("C5 CC AC/s A1", "C1 CC AC/s 80 04 20 00 12 00 07 06");
    assert_eq!(run(&frames(&bad_n)).codes(), [Code::Sdo025, Code::Sdo006, Code::Sdo017]);
    let early = "c C6 04 20 00 14/s A4 04 20 00 7F/c 01 00 01 02 03 04 05 06/c 83 0E 0F 10 11 12 13 00/\
        s A2 01 7F/c C5 CC AC/c 80 00 00 00 00 00 04 05";
    assert_eq!(run(&frames(early)).codes(), [Code::Sdo025, Code::Sdo012, Code::Sdo017]);
}

#[test]
fn e17_protocol_switch() {
    let text = E1.replace("c 40 08 10 00", "c A4 08 10 00 7F 17");
    let outcome = check_ok(&text, Direction::Upload, Mode::Segmented, (0x1008, 0), NAME);
    assert!(outcome.findings.is_empty());
    check_codes("c A4 08 10 00 00/s 80 08 10 00 02 00 04 05", &[Code::Sdo012, Code::Sdo017]);
}

#[test]
fn e18_roboteq() {
    let outcome = run(&frames("c 20 03 20 02 0A/s 60 03 20 02/c 40 02 20 00/s 4F 02 20 00 5A"));
    assert_eq!(outcome.codes(), [Code::Sdo021]);
    assert_eq!(outcome.transfers[0].data.kept, [10, 0, 0, 0]);
    assert_eq!(outcome.transfers[0].mode, Mode::Expedited);
    let outcome = run(&frames("c 2C 0C 20 00 01/s 60 0C 20 00"));
    assert_eq!((outcome.codes(), &outcome.only().data.kept), (vec![Code::Sdo021], &vec![1]));
    let outcome = run(&frames("c 48 0D 21 02 0A/s 48 0D 21 02 90 01"));
    assert_eq!((outcome.codes(), &outcome.only().data.kept), (vec![Code::Sdo022], &vec![0x90, 1]));
}

#[test]
fn unknown_size_is_no_quirk() {
    let text = "c 20 00 20 00/s 60 00 20 00/c 00 31 32 33 34 35 36 37/s 20/c 1A 38 39/s 30/c 0F/s 20";
    let outcome = run(&frames(text));
    assert_eq!(
        (outcome.only().outcome.status, outcome.only().data.kept.as_slice()),
        (Status::Ok, b"123456789".as_slice())
    );
    assert!(outcome.loud().is_empty(), "{outcome:?}");
}

#[test]
fn e33_new_initiate_in_mid_transfer() {
    let text = "c 40 08 10 00/s 41 08 10 00 17/c 40 00 20 00/s 80 08 10 00 01 00 04 05";
    let outcome = run(&frames(text));
    assert_eq!(outcome.codes(), [Code::Sdo008, Code::Sdo016, Code::Sdo017]);
    assert_eq!(outcome.loud().len(), 1);
    let statuses: Vec<Status> = outcome.transfers.iter().map(|transfer| transfer.outcome.status).collect();
    assert_eq!(statuses, [Status::Incomplete, Status::Aborted]);
}

const GOOD: &str = "c 40 02 20 00/s 4F 02 20 00 5A/";

#[track_caller]
fn check_codes(text: &str, codes: &[Code]) {
    let outcome = run(&frames(&format!("{GOOD}{text}")));
    assert_eq!(outcome.codes(), codes, "{outcome:?}");
}

#[test]
fn faults_are_named() {
    check_codes("c 40 08 10 00/s 43 09 10 00 01", &[Code::Sdo003]);
    check_codes("c 40 08 10 00/c 40 09 10 00/s 4F 09 10 00 01", &[Code::Sdo002]);
    check_codes("s 4F 08 10 00 01/c 40 09 10 00/s 4F 09 10 00 01", &[Code::Sdo002]);
    let again = frames(&format!("{GOOD}c 40 08 10 00/c 40 08 10 00/s 4F 08 10 00 01"));
    for (apart_ns, codes) in [(1_000_000, vec![]), (100_000_000, vec![Code::Sdo015])] {
        let outcome = run_timed(&again, |no| Some(no as i64 * apart_ns));
        assert_eq!(outcome.codes(), codes, "{outcome:?}");
    }
    check_codes("c E0/c 40 08 10 00/s 4F 08 10 00 01", &[Code::Sdo023]);
    check_codes(
        "c 40 08 10 00/s 41 08 10 00 07/c 60/s 01 31 32 33 34 35 36 37/c 70/s 80 08 10 00 01 00 04 05",
        &[Code::Sdo007, Code::Sdo017],
    );
    check_codes(
        "c 40 08 10 00/s 41 08 10 00 07/c 60/s 00 31 32 33 34 35 36 37/c 40 02 20 00/s 4F 02 20 00 5A",
        &[Code::Sdo007],
    );
}

#[test]
fn late_answer_is_not_given_to_the_next_request() {
    let text = "c 40 02 20 00/s 4F 02 20 00 5A/c 40 08 10 00/c 80 08 10 00 00 00 04 05/c 40 09 10 00/\
        s 43 08 10 00 31 32 33 34/s 43 09 10 00 35 36 37 38";
    let outcome = run(&frames(text));
    assert_eq!(outcome.codes(), [Code::Sdo002, Code::Sdo017, Code::Sdo020]);
    assert_eq!(outcome.transfers.last().unwrap().data.kept, b"5678");
}

#[test]
fn a_capture_that_begins_between_request_and_answer() {
    let text = "s 4F 02 20 00 01/c 40 02 20 00/s 4F 02 20 00 02/c 40 02 20 00/s 4F 02 20 00 03";
    let outcome = run(&frames(text));
    let values: Vec<u8> = outcome.transfers.iter().map(|transfer| transfer.data.kept[0]).collect();
    assert_eq!(values, [2, 3]);
    assert!(outcome.findings.is_empty());
}

#[test]
fn a_held_response_expires() {
    let text = frames("c 40 02 20 00/s 4F 02 20 00 5A/s 4F 08 10 00 01/c 40 08 10 00/s 4F 08 10 00 01");
    let times = [0, 1, 2, 20, 21];
    let outcome = run_timed(&text, |no| Some(times[no] * 1_000_000));
    assert_eq!(outcome.codes(), [Code::Sdo002]);
    assert_eq!(outcome.transfers.len(), 2);
}

#[test]
fn traffic_that_is_no_sdo_says_so_once() {
    let mut text = Vec::new();
    for n in 0..200_u8 {
        text.push((Side::Server, vec![n, 1, 2, 3, n, 5, 6, 7]));
    }
    assert_eq!(run(&text).codes(), [Code::Sdo030]);
    let again = frames("c 40 00 10 00/c 40 00 10 00");
    assert_eq!(run(&again).codes(), [Code::Sdo031]);
    let goes_on = frames("c 40 00 10 00/c 40 18 10 01");
    assert_eq!(run(&goes_on).codes(), [], "its answers may not have been recorded");
}

/// Delays chosen client frames by one frame, after the server frame that follows them.
fn displace(causal: &[Bytes], chosen: u128) -> Vec<Bytes> {
    let mut shown = causal.to_vec();
    for no in 0..shown.len().saturating_sub(1) {
        let late = causal[no].0 == Side::Client && causal[no + 1].0 == Side::Server;
        if late && chosen.checked_shr(no as u32).unwrap_or(0) & 1 == 1 {
            shown.swap(no, no + 1);
        }
    }
    shown
}

type Essence = (Direction, Mode, Option<Mux>, Status, Vec<u8>, Option<u32>);

fn essence(outcome: &Outcome) -> Vec<Essence> {
    outcome
        .transfers
        .iter()
        .map(|t| {
            // The data of an aborted transfer are no value.
            let value = if t.outcome.status == Status::Ok { t.data.kept.clone() } else { Vec::new() };
            (t.direction, t.mode, t.mux, t.outcome.status, value, t.outcome.abort.map(|abort| abort.code.number()))
        })
        .collect()
}

#[test]
fn each_client_frame_displaced_in_turn() {
    for text in [E1, E12, E13, E14, E15, E15_ZERO, E17] {
        let causal = frames(text);
        let truth = essence(&run(&causal));
        for no in 0..causal.len() {
            let shown = displace(&causal, 1 << no);
            let outcome = run(&shown);
            assert_eq!(essence(&outcome), truth, "{text}, frame {no}: {outcome:?}");
            assert!(outcome.loud().is_empty(), "{text}, frame {no}: {outcome:?}");
        }
    }
}

fn pad(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(8, 0);
    bytes
}

fn mux_bytes(index: u16, sub: u8) -> [u8; 3] {
    let [low, high] = index.to_le_bytes();
    [low, high, sub]
}

/// Returns the frames of one conformant transfer in causal order.
fn session(index: u16, kind: u8, data: &[u8], blksize: u8, cut: usize, code: u32) -> Vec<Bytes> {
    use Side::{Client, Server};
    let [low, high, sub] = mux_bytes(index, 1);
    let size = (data.len() as u32).to_le_bytes();
    let mut out: Vec<Bytes> = Vec::new();
    let mut put = |side, bytes: Vec<u8>| out.push((side, pad(bytes)));
    let segments: Vec<&[u8]> = data.chunks(7).collect();
    let head = |command: u8, tail: &[u8]| [&[command, low, high, sub], tail].concat();
    match kind {
        0 if data.len() <= 4 && !data.is_empty() => {
            let n = (4 - data.len() as u8) << 2;
            put(Client, head(0x40, &[]));
            put(Server, head(0x43 | n, data));
        }
        1 if data.len() <= 4 && !data.is_empty() => {
            let n = (4 - data.len() as u8) << 2;
            put(Client, head(0x23 | n, data));
            put(Server, head(0x60, &[]));
        }
        0 | 2 => {
            put(Client, head(0x40, &[]));
            put(Server, head(0x41, &size));
            for (no, segment) in segments.iter().enumerate() {
                let toggle = (no as u8 & 1) << 4;
                let last = u8::from(no + 1 == segments.len());
                put(Client, vec![0x60 | toggle]);
                put(Server, [&[toggle | (7 - segment.len() as u8) << 1 | last], *segment].concat());
            }
        }
        1 | 3 => {
            put(Client, head(0x21, &size));
            put(Server, head(0x60, &[]));
            for (no, segment) in segments.iter().enumerate() {
                let toggle = (no as u8 & 1) << 4;
                let last = u8::from(no + 1 == segments.len());
                put(Client, [&[toggle | (7 - segment.len() as u8) << 1 | last], *segment].concat());
                put(Server, vec![0x20 | toggle]);
            }
        }
        _ => {
            let upload = kind == 4;
            let (sender, receiver) = if upload { (Server, Client) } else { (Client, Server) };
            if upload {
                put(Client, head(0xA4, &[blksize]));
                put(Server, head(0xC6, &size));
                put(Client, vec![0xA3]);
            } else {
                put(Client, head(0xC6, &size));
                put(Server, head(0xA4, &[blksize]));
            }
            let mut no = 0;
            while no < segments.len() {
                let block = segments.len().min(no + usize::from(blksize));
                for (seq, segment) in segments[no..block].iter().enumerate() {
                    let last = if no + seq + 1 == segments.len() { 0x80 } else { 0 };
                    put(sender, [&[last | (seq as u8 + 1)], *segment].concat());
                }
                put(receiver, vec![0xA2, (block - no) as u8, blksize]);
                no = block;
            }
            let unused = 7 - segments.last().map_or(7, |segment| segment.len()) as u8;
            let crc = crc::Crc::<u16>::new(&crc::CRC_16_XMODEM).checksum(data).to_le_bytes();
            put(sender, vec![0xC1 | unused << 2, crc[0], crc[1]]);
            put(receiver, vec![0xA1]);
        }
    }
    if code != 0 && cut > 0 && cut < out.len() {
        // The server refuses the client's last request.
        let at = (cut..out.len()).find(|no| out[*no].0 == Server && out[*no - 1].0 == Client);
        if let Some(at) = at {
            let [a, b, c, d] = code.to_le_bytes();
            out.truncate(at);
            out.push((Server, vec![0x80, low, high, sub, a, b, c, d]));
        }
    }
    out
}

prop_compose! {
    fn any_session()(
        kind in 0_u8..6,
        data in proptest::collection::vec(any::<u8>(), 1..60),
        blksize in 1_u8..6,
        cut in 0_usize..30,
        code in prop_oneof![3 => Just(0_u32), 1 => Just(0x0602_0000), 1 => Just(0x0800_0000)],
    ) -> (u8, Vec<u8>, u8, usize, u32) {
        (kind, data, blksize, cut, code)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 5000, failure_persistence: None, ..ProptestConfig::default() })]

    /// The law: any subset of client frames delayed by one frame of the channel changes no transfer and no value.
    #[test]
    fn pairing_law(
        sessions in proptest::collection::vec(any_session(), 1..5),
        chosen in any::<u128>(),
    ) {
        let mut causal = Vec::new();
        for (no, (kind, data, blksize, cut, code)) in sessions.iter().enumerate() {
            causal.extend(session(0x2000 + no as u16, *kind, data, *blksize, *cut, *code));
        }
        let clean = run(&causal);
        prop_assert!(clean.loud().is_empty(), "{clean:?}");
        prop_assert_eq!(clean.transfers.len(), sessions.len());
        let shown = displace(&causal, chosen);
        let outcome = run(&shown);
        prop_assert_eq!(essence(&outcome), essence(&clean), "{:X?}", shown);
        prop_assert!(outcome.loud().is_empty(), "{outcome:?}\n{shown:X?}");
    }

    /// Reading one object again and again, with any subset of client frames but the first ones delayed.
    #[test]
    fn pairing_law_for_polling(
        values in proptest::collection::vec(any::<[u8; 4]>(), 2..12),
        chosen in any::<u128>(),
    ) {
        let causal: Vec<Bytes> = values.iter().flat_map(|value| session(0x2000, 0, value, 1, 0, 0)).collect();
        let outcome = run(&displace(&causal, chosen & !1));
        prop_assert!(outcome.loud().is_empty(), "{outcome:?}");
        let seen: Vec<&[u8]> = outcome.transfers.iter().map(|t| t.data.kept.as_slice()).collect();
        prop_assert_eq!(seen, values.iter().map(|v| v.as_slice()).collect::<Vec<_>>());
    }

    /// Every suffix of a capture keeps the values of transfers that begin in it, and a cut raises nothing.
    #[test]
    fn every_suffix(
        sessions in proptest::collection::vec(any_session(), 2..4),
        chosen in any::<u128>(),
        start in 0_usize..60,
    ) {
        let mut causal = Vec::new();
        let mut begins = Vec::new();
        for (no, (kind, data, blksize, cut, code)) in sessions.iter().enumerate() {
            begins.push(causal.len());
            causal.extend(session(0x2000 + no as u16, *kind, data, *blksize, *cut, *code));
        }
        let clean = essence(&run(&causal));
        let shown = displace(&causal, chosen);
        let start = start.min(shown.len());
        let outcome = run(&shown[start..]);
        prop_assert!(outcome.loud().is_empty(), "{outcome:?}\n{:X?}", &shown[start..]);
        let found = essence(&outcome);
        for (no, begin) in begins.iter().enumerate() {
            if *begin >= start {
                prop_assert!(found.contains(&clean[no]), "{:X?}\n{:?}\n{:?}", &shown[start..], clean[no], found);
            }
        }
    }

    /// Any bytes: no panic, one step per frame, and the kept data agree with their count.
    #[test]
    fn any_bytes(frames in proptest::collection::vec((any::<bool>(), any::<[u8; 8]>()), 0..200)) {
        let frames: Vec<Bytes> = frames
            .into_iter()
            .map(|(client, bytes)| (if client { Side::Client } else { Side::Server }, bytes.to_vec()))
            .collect();
        let outcome = run(&frames);
        for transfer in &outcome.transfers {
            prop_assert_eq!(transfer.data.size, transfer.data.kept.len() as u64);
        }
    }
}
