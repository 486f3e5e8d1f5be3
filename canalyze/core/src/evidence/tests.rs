#![allow(clippy::unwrap_used)]
use super::duplicates::Sighting;
use super::period::{Confidence, Learnt};
use super::recording::{ClockStep, Happened, RecordedFrame, Verdict};
use super::*;
use crate::bytes::frame::{CanId, Frame, FrameRef};
use crate::bytes::ns::Ns;

fn frame(no: u64, id: u16, payload: &[u8], us: i64) -> Frame {
    Frame { no, t_ns: Some(Ns(1_700_000_000_000_000_000 + us * 1000)), ..Frame::classic(CanId::standard(id), payload) }
}

/// Makes `ms` of frames of a cyclic bus (time in µs, CAN-ID): SYNC each 10 ms, two PDOs after it, a heartbeat each 100
/// ms.
fn cyclic(ms: i64) -> Vec<(i64, u16)> {
    let mut out = Vec::new();
    for cycle in 0..ms / 10 {
        let at = cycle * 10_000 + 137;
        out.extend([(at, 0x80), (at + 500, 0x181), (at + 900, 0x182)]);
        if cycle % 10 == 3 {
            out.push((at + 3_000, 0x701));
        }
    }
    out
}

/// Makes a recorder stall between `from` and `to` (µs) and then list its buffered frames `apart` µs apart.
fn stalled(frames: &[(i64, u16)], from: i64, to: i64, apart: i64) -> Vec<(i64, u16)> {
    let mut next = i64::MIN;
    let listed = frames.iter().map(|(at, id)| {
        let listed = if *at >= from { (*at).max(to).max(next) } else { *at };
        if *at >= from {
            next = listed + apart;
        }
        (listed, *id)
    });
    listed.collect()
}

/// Observes a frame and takes it at once.
fn observe(recording: &mut Recording, frame: &Frame, commands: bool) -> (When, Happened) {
    let RecordedFrame { mut when, happened } = recording.observe(frame);
    recording.take(&mut when, happened.as_deref(), frame, commands);
    (when, happened.map_or_else(Happened::default, |happened| *happened))
}

fn feed(recording: &mut Recording, frames: &[(i64, u16)]) -> Vec<When> {
    let numbered = frames.iter().enumerate();
    numbered
        .map(|(no, (at, id))| {
            observe(recording, &frame(no as u64 + 1, *id, &[no as u8, (no >> 8) as u8], *at), false).0
        })
        .collect()
}

#[test]
fn a_stall_of_any_length_is_confirmed_and_ordinary_traffic_is_not() {
    let clean = cyclic(3_000);
    let mut recording = Recording::default();
    feed(&mut recording, &clean);
    assert_eq!(recording.stalled(), None);
    for length in [40_000, 100_000, 600_000, 1_100_000, 5_000_000, 60_000_000] {
        for apart in [20, 200, 1000] {
            let frames = cyclic(1_000 + length / 1000 * 3);
            let frames = stalled(&frames, 1_000_000, 1_000_000 + length, apart);
            let mut recording = Recording::default();
            feed(&mut recording, &frames);
            assert!(recording.stalled().is_some(), "{length} {apart}");
        }
    }
}

#[test]
fn frames_of_a_burst_have_no_times_of_their_own() {
    let frames = stalled(&cyclic(2_000), 1_000_000, 1_300_000, 50);
    let mut recording = Recording::default();
    let whens = feed(&mut recording, &frames);
    let first = whens.iter().find(|when| when.burst > 0).unwrap();
    assert_eq!(recording.verdict(first.burst), Some(Verdict::Confirmed));
    let before = whens.iter().rev().find(|when| when.at.no < first.at.no).unwrap();
    assert!(!recording.certainly_later(*first, *before, Ns(1_000_000)));
    assert!(!recording.teaches(*first) && recording.teaches(*before));
    assert!(recording.certainly_later(*whens.last().unwrap(), *before, Ns(900_000_000)));
}

#[test]
fn a_silence_in_which_frames_are_really_missing_is_no_stall() {
    // One missing SYNC cycle, and 12 missing ones.
    for missing in [1, 12] {
        let gap = 1_000_000..1_000_000 + missing * 10_000;
        let frames: Vec<_> = cyclic(2_000).into_iter().filter(|(at, _)| !gap.contains(at)).collect();
        let mut recording = Recording::default();
        feed(&mut recording, &frames);
        assert_eq!(recording.stalled(), None, "{missing}");
    }
}

/// Makes frames of a slow bus: SYNC each 50 ms with one PDO, and two heartbeats each 100 ms.
fn slow(ms: i64) -> Vec<(i64, u16)> {
    let cycles = (0..ms / 50).flat_map(|cycle| {
        let at = cycle * 50_000 + 137;
        let beats = [(at + 20_000, 0x701), (at + 37_000, 0x702)].into_iter().filter(move |_| cycle % 2 == 0);
        [(at, 0x80), (at + 500, 0x181)].into_iter().chain(beats)
    });
    cycles.collect()
}

#[test]
fn a_stall_shows_by_frames_that_are_late_by_different_times() {
    for length in [25_000, 60_000, 300_000, 2_000_000] {
        for apart in [20, 200, 1000] {
            let frames = stalled(&slow(4_000), 1_000_000, 1_000_000 + length, apart);
            let mut recording = Recording::default();
            feed(&mut recording, &frames);
            assert!(recording.stalled().is_some(), "{length} {apart}");
        }
    }
}

#[test]
fn a_sender_that_is_late_itself_is_no_stall() {
    // A late heartbeat, and a late SYNC with its PDO; the next ones are on time.
    for ids in [&[0x701][..], &[0x80, 0x181]] {
        for late in [12_000, 15_000, 18_000] {
            let frames = slow(4_000).into_iter().map(|(at, id)| {
                let faulty = ids.contains(&id) && (1_000_000..1_040_000).contains(&at);
                (at + if faulty { late } else { 0 }, id)
            });
            let mut frames: Vec<_> = frames.collect();
            frames.sort_unstable();
            let mut recording = Recording::default();
            feed(&mut recording, &frames);
            recording.settle(true);
            assert_eq!(recording.stalled(), None, "{ids:?} {late}");
        }
    }
}

#[test]
fn a_stall_at_the_beginning_shows_by_the_frames_behind_it() {
    for length in [30_000, 100_000, 600_000, 2_000_000] {
        for apart in [20, 200, 1000] {
            let frames = stalled(&cyclic(4_000), 200, length, apart);
            let mut recording = Recording::default();
            feed(&mut recording, &frames);
            assert!(recording.stalled().is_some(), "{length} {apart}");
            assert_eq!(recording.undecided_since(), None, "{length} {apart}");
        }
    }
}

#[test]
fn a_pdo_sent_twice_at_the_beginning_is_no_stall() {
    // After a boot-up and a silence one PDO comes twice; then it and many others come unevenly.
    let mut frames = vec![(0, 0x701), (400_000, 0x605), (400_300, 0x585), (400_700, 0x181), (401_700, 0x181)];
    let mut at = 401_700;
    for (n, gap) in (0..100).zip([12_000, 35_000, 50_000, 20_000, 80_000].into_iter().cycle()) {
        at += gap;
        frames.extend([(at, 0x181), (at + 2_000 + n, 0x605), (at + 2_400 + n, 0x585)]);
    }
    let mut recording = Recording::default();
    feed(&mut recording, &frames);
    assert_eq!(recording.undecided_since(), None);
    assert_eq!(recording.stalled(), None);
}

#[test]
fn a_live_bus_does_not_wait_long_for_what_comes_behind_a_burst() {
    let mut recording = Recording::default();
    let frames = [(0, 0x701), (400_000, 0x181), (400_200, 0x181), (400_400, 0x182)];
    let whens = feed(&mut recording, &frames);
    assert_eq!(recording.undecided_since(), Some(2));
    recording.advance(whens.first().unwrap().at.t_ns.unwrap() + Ns(600_000_000));
    assert_eq!(recording.undecided_since(), Some(2));
    recording.advance(whens.first().unwrap().at.t_ns.unwrap() + Ns(700_000_000));
    assert_eq!(recording.undecided_since(), None);
}

#[test]
fn frames_captured_twice_are_duplicates_at_any_distance() {
    for apart in [1, 100, 800, 2_000, 5_000, 8_000, 15_000, 30_000, 50_000] {
        let mut frames: Vec<(i64, usize, u16)> = Vec::new();
        for (no, (at, id)) in cyclic(1_000).into_iter().enumerate() {
            frames.extend([(at, no, id), (at + apart, no, id)]);
        }
        frames.sort_unstable();
        let mut recording = Recording::default();
        let mut observed = Vec::new();
        for (number, (at, no, id)) in (1..).zip(&frames) {
            let frame = frame(number, *id, &[*no as u8, (*no >> 8) as u8], *at);
            observed.push((frame.reference(), recording.observe(&frame).happened.unwrap_or_default().sighting));
        }
        recording.settle(true);
        assert!(recording.shows_duplicates(), "{apart}");
        let duplicates =
            observed.iter().filter(|(at, sighting)| recording.sighting(*at, *sighting) == Sighting::Duplicate);
        assert_eq!(duplicates.count(), frames.len() / 2, "{apart}");
    }
}

#[test]
fn a_client_that_repeats_its_requests_is_no_second_adapter() {
    for apart in [15_000, 30_000, 50_000] {
        let mut recording = Recording::default();
        let mut duplicates = 0;
        for node in 1..=60u16 {
            let began = i64::from(node) * 200_000;
            let talk = [(0x600, 0), (0x600, apart), (0x580, apart + 300), (0x580, 2 * apart + 300)];
            for (id, at) in talk {
                let one = frame(u64::from(node), id + node, &[0x40, 0x18, 0x10, node as u8], began + at);
                let (_, happened) = observe(&mut recording, &one, false);
                duplicates += usize::from(happened.sighting == Sighting::Duplicate);
            }
        }
        recording.settle(true);
        assert!(!recording.shows_duplicates(), "{apart}");
        assert_eq!(duplicates, 0, "{apart}");
    }
}

/// Returns the numbers of the frames that are found to be duplicates, from frames by time, CAN-ID and payload.
fn duplicates(frames: &[(i64, u16, u8)]) -> Vec<u64> {
    let mut recording = Recording::default();
    let mut observed = Vec::new();
    for (number, (at, id, byte)) in (1..).zip(frames) {
        let frame = frame(number, *id, &[*byte], *at);
        observed.push((frame.reference(), recording.observe(&frame).happened.unwrap_or_default().sighting));
    }
    recording.settle(true);
    let found = observed.iter().filter(|(at, seen)| recording.sighting(*at, *seen) == Sighting::Duplicate);
    found.map(|(at, _)| at.no).collect()
}

#[test]
fn the_frames_of_the_host_are_listed_twice_and_those_of_others_once() {
    for apart in [10, 60, 200, 440] {
        for own in [&[0x80, 0x701, 0x601][..], &[0x80], &[0x601, 0x602, 0x702]] {
            let mut frames: Vec<(i64, u16, u8)> = Vec::new();
            for cycle in 0..400 {
                let at = cycle * 10_000 + 137;
                let asked = if cycle % 2 == 0 { 0x601 } else { 0x602 };
                let beat = 0x701 + (cycle % 7) as u16;
                let sent = [
                    (at, 0x80),
                    (at + 600, 0x181),
                    (at + 3_000, asked),
                    (at + 3_700, asked - 0x80),
                    (at + 6_000, beat),
                ];
                for (at, id) in sent {
                    frames.push((at, id, cycle as u8));
                    if own.contains(&id) {
                        frames.push((at + apart + cycle % 5, id, cycle as u8));
                    }
                }
            }
            frames.sort_unstable();
            let second = frames.iter().enumerate().filter(|(place, one)| {
                frames.iter().take(*place).rev().take(8).any(|other| (other.1, other.2) == (one.1, one.2))
            });
            let expected: Vec<u64> = second.map(|(place, _)| place as u64 + 1).collect();
            assert!(expected.len() > 100);
            assert_eq!(duplicates(&frames), expected, "{apart} {own:X?}");
        }
    }
}

#[test]
fn what_two_senders_do_is_no_echo() {
    // Heartbeats of two nodes with one node-ID, and requests that are repeated and answered twice.
    for apart in [20, 90, 400] {
        let mut frames: Vec<(i64, u16, u8)> = Vec::new();
        for cycle in 0..400 {
            let at = cycle * 10_000 + 137;
            frames.extend([(at, 0x181, cycle as u8), (at + 5_000, 0x705, 5), (at + 5_060 + cycle / 4, 0x705, 5)]);
            for again in [0, apart] {
                frames.extend([(at + 1_000 + again, 0x601, cycle as u8), (at + 1_450 + again, 0x581, cycle as u8)]);
            }
        }
        frames.sort_unstable();
        assert_eq!(duplicates(&frames), Vec::<u64>::new(), "{apart}");
    }
}

#[test]
fn equal_frames_of_one_sender_are_no_duplicates() {
    let mut recording = Recording::default();
    let mut suspects = 0;
    for (no, (at, id)) in cyclic(1_000).into_iter().enumerate() {
        // Constant payloads, each 5 ms: every frame has an equal one shortly before.
        for half in if id == 0x701 { &[0][..] } else { &[0, 5_000] } {
            let payload: &[u8] = if id == 0x701 { &[5] } else { &[] };
            let (_, happened) = observe(&mut recording, &frame(no as u64, id, payload, at + half), false);
            suspects += usize::from(happened.sighting == Sighting::Duplicate);
        }
    }
    assert!(!recording.shows_duplicates());
    assert!(suspects <= 4, "{suspects}");
}

#[test]
fn a_late_echo_is_an_interval() {
    let mut recording = Recording::default();
    let (sync, _) = observe(&mut recording, &frame(1, 0x80, &[], 100_001), true);
    let (pdo, _) = observe(&mut recording, &frame(2, 0x181, &[1], 104_001), false);
    assert!(recording.certainly_later(pdo, sync, Ns(3_000_000)));
    assert!(!recording.certainly_within(pdo, sync, Ns(6_000_000)));
    let (late, _) = observe(&mut recording, &frame(3, 0x80, &[], 109_001), true);
    assert!(recording.may_precede(late, pdo));
    for _ in 0..100 {
        recording.exchanged(Ns(1_000_000), true);
    }
    assert!(recording.certainly_within(pdo, sync, Ns(7_000_000)));
    assert!(!recording.may_precede(late, pdo));
}

#[test]
fn the_resolution_of_stamps_is_what_all_of_them_are_multiples_of() {
    for unit in [1, 5, 64, 100, 1000, 4000, 8000, 10_000] {
        let mut recording = Recording::default();
        let floored: Vec<(i64, u16)> = cyclic(3000).into_iter().map(|(us, id)| (us - us % unit, id)).collect();
        feed(&mut recording, &floored);
        assert_eq!(recording.resolution_ns(), Ns(unit * 1000), "{unit} us");
    }
}

#[test]
fn a_clock_that_is_set_back_begins_an_epoch() {
    for (back, stepped) in [(2_000, false), (9_000, false), (15_000, true), (3_600_000_000, true)] {
        let mut recording = Recording::default();
        observe(&mut recording, &frame(1, 0x181, &[1], 4_000_000_001), false);
        let (_, happened) = observe(&mut recording, &frame(2, 0x181, &[2], 4_000_000_001 - back), false);
        assert_eq!(happened.step.is_some(), stepped, "{back}");
    }
}

#[test]
fn a_step_back_to_the_beginning_begins_anew() {
    // A short capture may have been joined to itself.
    for (to_us, step) in [(1, ClockStep::Set), (0, ClockStep::NewRecording), (-5, ClockStep::NewRecording)] {
        let mut recording = Recording::default();
        for (no, us) in [(1, 0), (2, 300_000), (3, 500_000)] {
            observe(&mut recording, &frame(no, 0x181, &[1], 4_000_000_001 + us), false);
        }
        let (_, happened) = observe(&mut recording, &frame(4, 0x181, &[2], 4_000_000_001 + to_us), false);
        assert_eq!(happened.step, Some(step), "{to_us}");
    }
}

/// Makes `ms` of inexact frames: SYNC and a PDO every 10 ms, and the heartbeats of some nodes every 100 ms.
fn beating(nodes: i64, ms: i64) -> Vec<(i64, u16)> {
    let off = |cycle: i64, id: i64| (cycle * 7919 + id * 31) % 5 * 100;
    let mut out: Vec<(i64, u16)> = (0..ms / 10)
        .flat_map(|cycle| {
            let at = cycle * 10_000 + 137 + off(cycle, 0);
            let node = cycle % 10;
            let beat = (node < nodes).then_some((at + 3_000 + off(cycle, node), 0x701 + node as u16));
            [(at, 0x80), (at + 500, 0x181)].into_iter().chain(beat)
        })
        .collect();
    out.sort_unstable();
    out
}

/// Returns the numbers of the frames after holes that the recording is found to have.
fn holes(frames: &[(i64, u16)]) -> Vec<u64> {
    let mut recording = Recording::default();
    let frames: Vec<Frame> = (1..).zip(frames).map(|(no, (at, id))| frame(no, *id, &[no as u8, 5], *at)).collect();
    frames.iter().for_each(|frame| {
        recording.observe(frame);
    });
    recording.settle(true);
    let numbers = frames.iter().filter(|frame| recording.is_behind_hole(frame.no)).map(|frame| frame.no);
    numbers.collect()
}

/// Returns the number of the first frame from a time on.
fn first(frames: &[(i64, u16)], from: i64) -> u64 {
    1 + frames.iter().take_while(|(at, _)| *at < from).count() as u64
}

#[test]
fn lost_frames_and_a_clock_that_was_put_on_are_a_hole() {
    for nodes in [1, 2, 5, 10] {
        for lasts in [30_000, 100_000, 700_000, 5_000_000, 60_000_000] {
            for from in [500_000, 1_001_000, 1_330_000] {
                let frames = beating(nodes, 3_000 + lasts / 1000);
                // Each silence suppresses a heartbeat, except for the first one with a single node.
                let left: Vec<_> =
                    frames.iter().copied().filter(|(at, _)| !(from..from + lasts).contains(at)).collect();
                let lost = (1..=nodes).contains(&(from % 100_000 / 10_000 + 1)) || lasts >= 100_000;
                let behind = first(&frames, from);
                assert_eq!(holes(&left), if lost { vec![behind] } else { vec![] }, "{nodes} {lasts} {from}");
                let later = |(at, id): (i64, u16)| (if at < from { at } else { at + lasts }, id);
                let later: Vec<_> = beating(nodes, 3_000).into_iter().map(later).collect();
                assert_eq!(holes(&later), [behind], "{nodes}, put on {lasts} {from}");
            }
        }
    }
}

#[test]
fn a_counter_that_goes_on_by_the_time_shows_a_hole() {
    let cycles = |from: i64, to: i64, counter: &dyn Fn(i64) -> i64| -> Vec<Frame> {
        let sent = (from..to).flat_map(|cycle| {
            [
                (cycle * 20_000, 0x80, counter(cycle)),
                (cycle * 20_000 + 600, 0x181, 7),
                (cycle * 20_000 + 9_000, 0x601, 5),
            ]
        });
        let frames = (1..).zip(sent).map(|(no, (at, id, byte))| frame(no, id, &[byte as u8], at + at / 7 % 40));
        frames.collect()
    };
    let found = |frames: Vec<Frame>| {
        let mut recording = Recording::default();
        for (no, frame) in (1..).zip(&frames) {
            recording.observe(&Frame { no, ..*frame });
        }
        recording.settle(true);
        (1..=frames.len() as u64).filter(|no| recording.is_behind_hole(*no)).count()
    };
    for overflow in [4, 10, 240] {
        for missing in [1, 2, 5, 8, 30] {
            let by_time = |cycle: i64| cycle % overflow + 1;
            let before = cycles(0, 100, &by_time);
            let behind = |wrong: i64| cycles(100 + missing, 200, &|cycle| by_time(cycle + wrong));
            let lacks = |wrong: i64| found([before.clone(), behind(wrong)].concat());
            // The value would be the same if none were missing.
            let shows = missing % overflow != 0;
            assert_eq!(lacks(0), usize::from(shows), "{overflow} {missing}");
            for wrong in [1, 2] {
                assert_eq!(lacks(wrong), 0, "{overflow} {missing} {wrong}");
            }
        }
    }
}

#[test]
fn what_happened_on_the_bus_is_no_hole() {
    let (from, to) = (1_000_000, 1_700_000);
    let silent = |ids: fn(u16) -> bool| {
        let gone = move |(at, id): &(i64, u16)| (from..to).contains(at) && ids(*id);
        move |frames: Vec<(i64, u16)>| frames.into_iter().filter(|one| !gone(one)).collect::<Vec<_>>()
    };
    let beats_only = || beating(3, 3_000).into_iter().filter(|(_, id)| *id > 0x700).collect::<Vec<_>>();
    assert_eq!(holes(&beating(3, 3_000)), [] as [u64; 0]);
    // One node, SYNC with its PDOs, or two of three nodes.
    assert_eq!(holes(&silent(|id| id == 0x701)(beating(3, 3_000))), [] as [u64; 0]);
    assert_eq!(holes(&silent(|id| id < 0x700)(beating(3, 3_000))), [] as [u64; 0]);
    assert_eq!(holes(&silent(|id| id != 0x703)(beats_only())), [] as [u64; 0]);
    // A node that never comes back, and nodes that continue in other phases.
    let lost = |(at, id): &(i64, u16)| *id == 0x701 || *id == 0x702 && *at < to;
    let lost: Vec<_> = silent(|_| true)(beats_only()).into_iter().filter(lost).collect();
    assert_eq!(holes(&lost), [] as [u64; 0]);
    let phase = |(at, id): (i64, u16)| (at + if at > to { i64::from(id - 0x700) * 17_000 } else { 0 }, id);
    let mut other: Vec<_> = silent(|_| true)(beats_only()).into_iter().map(phase).collect();
    other.sort_unstable();
    assert_eq!(holes(&other), [] as [u64; 0]);
    // A command or a boot-up comes first.
    for (id, payload) in [(0, &[1, 0][..]), (0x701, &[0])] {
        let frames = silent(|_| true)(beating(3, 3_000));
        let mut recording = Recording::default();
        for (no, (at, one)) in (1..).zip(&frames) {
            if no == first(&frames, to) {
                recording.observe(&frame(no, id, payload, to - 3_000));
            }
            recording.observe(&frame(no + 1, *one, &[5], *at));
        }
        assert!((1..=frames.len() as u64 + 1).all(|no| !recording.is_behind_hole(no)));
    }
}

#[test]
fn a_stall_is_no_hole() {
    for length in [12_000, 20_000, 33_000, 60_000, 100_000, 104_000, 300_000, 5_000_000] {
        for apart in [20, 200, 1000] {
            for from in (1_000_000..1_100_000).step_by(3_700) {
                let frames = stalled(&beating(4, 4_000 + length / 1000 * 3), from, from + length, apart);
                assert_eq!(holes(&frames), [] as [u64; 0], "{length} {apart} {from}");
            }
        }
    }
}

#[test]
fn frames_that_are_listed_out_of_order_are_no_steps() {
    for late in [500, 2_000, 4_000, 9_000] {
        let mut recording = Recording::default();
        for no in 0..400 {
            let t_us = 4_000_000_001 + no * 300 - if no % 100 == 99 { late } else { 0 };
            let (_, happened) = observe(&mut recording, &frame(no as u64, 0x181, &[no as u8], t_us), false);
            assert!(happened.step.is_none(), "{no}, {late} us earlier");
        }
    }
}

#[test]
fn a_period_is_learnt_and_its_lasting_change_told() {
    let at = FrameRef::default();
    for percent in [5, 10, 20, 30, 100] {
        let mut period = Period::default();
        for n in 0..20 {
            period.take(Ns(10_000_000 + n % 3 * 1000), Ns(1000), at);
        }
        assert_eq!(period.expected().unwrap().confidence, Confidence::Certain);
        let longer = 10_000_000 + percent * 100_000;
        let told = (0..10).filter(|_| matches!(period.take(Ns(longer), Ns(1000), at), Learnt::Changed { .. })).count();
        assert_eq!(told, 1, "{percent}");
        assert_eq!(period.learnt_ns(), Some(Ns(longer)));
    }
    // Pairs of a late and an early frame are not another period.
    let mut period = Period::default();
    for n in 0..200 {
        let gap = match n % 4 {
            0 => 14_000_000,
            1 => 6_000_000,
            _ => 10_000_000,
        };
        assert!(!matches!(period.take(Ns(gap), Ns(1000), at), Learnt::Changed { .. }));
    }
    assert!((Ns(9_900_000)..=Ns(10_100_000)).contains(&period.learnt_ns().unwrap()));
}

#[test]
fn the_mean_of_many_gaps_tells_what_each_is_too_uneven_for() {
    let at = FrameRef::default();
    let uneven = |n: i64| [0, 3_000_000, -3_000_000, 1_000_000, -1_000_000].get((n % 5) as usize).copied().unwrap();
    for percent in [0, 2, 7, 10] {
        let mut period = Period::default();
        let told = (0..160).filter(|n| {
            let longer = if *n < 60 { 0 } else { percent * 1_000_000 };
            matches!(period.take(Ns(100_000_000 + longer + uneven(*n)), Ns(1000), at), Learnt::Changed { .. })
        });
        let told = told.count();
        assert_eq!(told > 0, percent > 5, "{percent} %: {told}");
    }
}

#[test]
fn one_gap_confirms_a_doubted_period() {
    for (gap_ms, learnt) in [(100, true), (103, true), (97, true), (104, false), (150, false), (200, false)] {
        let mut period = Period::default();
        let take = |period: &mut Period, ms: i64| _ = period.take(Ns(ms * 1_000_000), Ns(1000), FrameRef::default());
        (0..6).for_each(|_| take(&mut period, 100));
        period.doubt();
        take(&mut period, gap_ms);
        assert_eq!(period.learnt_ns().is_some(), learnt, "{gap_ms}");
    }
}

#[test]
fn gaps_that_were_not_judged_do_not_hide_another_period() {
    let ends = |no: i64| FrameRef { no: no as u64, t_ns: Some(Ns(no * 120_000_000)), ..FrameRef::default() };
    let mut period = Period::default();
    for no in 0..20 {
        period.take(
            Ns(100_000_000),
            Ns(1000),
            FrameRef { no, t_ns: Some(Ns(no as i64 * 100_000_000)), ..FrameRef::default() },
        );
    }
    let told = (20..60).filter(|no| {
        no % 3 != 0 && matches!(period.take(Ns(120_000_000), Ns(1000), ends(*no)), Learnt::Changed { .. })
    });
    assert_eq!(told.count(), 1);
}

#[test]
fn what_is_owed_is_due_once_it_certainly_is() {
    let mut recording = Recording::default();
    let (since, _) = observe(&mut recording, &frame(1, 0x701, &[5], 1), false);
    let mut owed: Obligations<u8> = Obligations::default();
    owed.open(1, obligation::Owed { since, limit_ns: Ns(100_000_000), why: None });
    let mut due = Vec::new();
    for no in 2..300 {
        let (now, _) = observe(&mut recording, &frame(no, 0x182, &[no as u8], no as i64 * 1_000 + 1), false);
        due.extend(owed.due(now, &recording).into_iter().map(|(key, _)| (key, no)));
    }
    assert_eq!(due, [(1, 101)]);
}

#[test]
fn what_is_sent_again_and_again_behind_pauses_stands_once() {
    let mut recording = Recording::default();
    let (mut no, mut t_us) = (0, 4_000_000_001);
    for _ in 0..60 {
        t_us += 50_000;
        for byte in [0x40, 0x60, 0x70].into_iter().cycle().take(15) {
            for id in [0x60A, 0x58A] {
                (no, t_us) = (no + 1, t_us + 60);
                observe(&mut recording, &frame(no, id, &[byte], t_us), false);
                assert!(!recording.shows_duplicates(), "{no}");
            }
        }
    }
}

#[test]
fn an_ordinary_frame_is_observed_as_any_frame_is() {
    let clean = cyclic(4_000);
    let disturbed = |seed: u64| {
        let (mut state, mut shift) = (seed, 0);
        let mut listed = Vec::new();
        for (at, id) in stalled(&clean, 1_700_000, 1_760_000, 200) {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            match state >> 33 & 0x7F {
                0 => shift += 12_000,
                1 => shift -= 3_000,
                2 => shift += 40,
                3 => continue,
                4 => listed.push((at + shift + 30, id)),
                5 if state >> 40 & 0x3F == 0 => shift -= 1_500_000,
                _ => {}
            }
            listed.push((at + shift, id));
        }
        listed
    };
    // Two steps of the clock, each too small to be one by itself, with an ordinary frame between them.
    let falling: Vec<_> = clean
        .iter()
        .copied()
        .chain(
            [(0, 0x181), (-7_000, 0x182), (-6_700, 0x183), (-13_500, 0x184), (-13_200, 0x185)]
                .map(|(us, id)| (3_998_000 + us, id)),
        )
        .collect();
    let mut ordinary = 0;
    for listed in [clean.clone(), falling].into_iter().chain((1..12).map(disturbed)) {
        let (mut one, mut other) = (Recording::default(), Recording::default());
        for (no, (at, id)) in listed.iter().enumerate() {
            // Some payloads are equal, as those of duplicates.
            let frame = frame(no as u64 + 1, *id, &[(no / 3) as u8, (no >> 8) as u8], *at);
            ordinary += usize::from(one.ordinary_gap(&frame).is_some());
            assert_eq!(one.observe(&frame), other.observe_any(&frame), "frame {no} of {}", listed.len());
            assert_eq!((one.undecided_since(), one.is_decided()), (other.undecided_since(), other.is_decided()));
        }
        assert_eq!(format!("{one:?}"), format!("{other:?}"));
    }
    assert!(ordinary > 5_000, "{ordinary}");
}
