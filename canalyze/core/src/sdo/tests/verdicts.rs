//! Single faults and their nearest clean neighbours: one verdict each, at the frame at fault, and a correct transfer
//! after it; and clean traffic that looks like a fault.

use super::*;

/// An exchange of known value that ends every capture here.
const NEXT: &str = "/c 40 03 20 00/s 4F 03 20 00 77";

/// Returns the codes above info with their frames for `GOOD` + text + `NEXT`; the last transfer must be correct.
#[track_caller]
fn loud(text: &str) -> Vec<(Code, u64)> {
    let outcome = run(&frames(&format!("{GOOD}{text}{NEXT}")));
    let last = outcome.transfers.last().unwrap();
    assert_eq!((last.outcome.status, last.data.kept.as_slice()), (Status::Ok, [0x77].as_slice()), "{outcome:?}");
    outcome.loud().iter().map(|finding| (finding.code, finding.cause.unwrap_or(finding.at).no)).collect()
}

#[test]
fn a_lost_frame_is_one_finding() {
    let initiate_request = "s 41 04 20 00 08/c 60/s 00 01 02 03 04 05 06 07/c 70/s 1D 08";
    assert_eq!(loud(initiate_request), [(Code::Sdo002, 3)]);
    let block_response = "c C2 04 20 00 0E/c 01 00 01 02 03 04 05 06/c 82 07 08 09 0A 0B 0C 0D/s A2 02 7F/c C1/s A1";
    assert_eq!(loud(block_response), [(Code::Sdo024, 3)]);
    let switched_response = "c A4 04 20 00 7F FF/c 60/s 00 00 01 02 03 04 05 06/c 70/s 1D 07";
    assert_eq!(loud(switched_response), [(Code::Sdo024, 3)]);
}

#[test]
fn a_foreign_frame_is_one_finding() {
    let unknown = "c 40 04 20 00/c E0 EB D4 DC A6 BC 8F 86/s 41 04 20 00 07/c 60/s 01 00 01 02 03 04 05 06";
    assert_eq!(loud(unknown), [(Code::Sdo023, 4)]);
    let in_block = "c C2 04 20 00 07/s A0 04 20 00 7F/c 81 00 01 02 03 04 05 06/s A2 01 7F/c 66 96/c C1/s A1";
    assert_eq!(loud(in_block), [(Code::Sdo012, 7)]);
}

#[test]
fn faults_of_block_transfers() {
    let block_size = "c C6 04 20 00 07/s A4 04 20 00 7F/c 81 00 01 02 03 04 05 06/s A2 01 00/c C1 0C D9/s A1";
    assert_eq!(loud(block_size), [(Code::Sdo012, 6)]);
    let number = "c A0 04 20 00 7F/s C2 04 20 00 07/c A3/s 83 00 01 02 03 04 05 06/c A2 01 7F/s C1/c A1";
    assert_eq!(loud(number), [(Code::Sdo012, 6)]);
    let middle = "c A0 04 20 00 7F/s C2 04 20 00 0F/c A3/s 81 00 01 02 03 04 05 06/s 02 07 08 09 0A 0B 0C 0D/s 83/\
        c A2 03 7F/s D9/c A1";
    assert_eq!(loud(middle), [(Code::Sdo012, 6)]);
}

#[test]
fn another_objects_answer_is_no_value() {
    let outcome = run(&frames(&format!("{GOOD}c 40 00 20 00/s 43 01 20 00 11")));
    let wrong = outcome.transfers.last().unwrap();
    assert_eq!((wrong.outcome.status, wrong.data.kept.len()), (Status::Failed, 0));
    assert_eq!(outcome.codes(), [Code::Sdo003]);
}

#[test]
fn the_servers_abort_after_the_clients_is_not_the_retrys() {
    let text =
        "c 40 08 10 00/c 80 08 10 00 00 00 04 05/s 80 08 10 00 00 00 04 05/c 40 08 10 00/s 43 08 10 00 31 32 33 34";
    assert_eq!(loud(text), [(Code::Sdo002, 3)]);
    let outcome = run(&frames(&format!("{GOOD}{text}")));
    let retry = outcome.transfers.last().unwrap();
    assert_eq!((retry.outcome.status, retry.data.kept.as_slice()), (Status::Ok, b"1234".as_slice()));
}

#[test]
fn two_requests_may_get_two_answers() {
    assert_eq!(loud("c 40 01 20 00/c 40 01 20 00/s 43 01 20 00 02/s 43 01 20 00 02"), []);
}

#[test]
fn segments_confirmed_are_segmented() {
    let text = "c 20 04 20 00/s 60 04 20 00/s 20";
    assert_eq!(loud(text).first(), Some(&(Code::Sdo002, 5)));
    assert!(loud(text).iter().all(|(code, _)| *code != Code::Sdo021));
}

#[test]
fn the_last_segment_of_a_long_sub_block_is_no_end() {
    let mut all = frames("c C0 04 20 00/s A0 04 20 00 7F");
    for seqno in 1..=63 {
        all.push((Side::Client, vec![seqno, 1, 1, 1, 1, 1, 1, 1]));
    }
    // Segment 64 is lost on the bus; 65 is the last one and looks like an end frame.
    all.extend(frames("c C1 22 22/s A2 3F 7F/c 01 40 40 40 40 40 40 40/c 82 22 22/s A2 02 7F/c D5/s A1"));
    let outcome = run(&all);
    assert!(outcome.loud().is_empty(), "{outcome:?}");
    assert_eq!((outcome.only().data.size, outcome.only().outcome.retransmissions), (450, 1));
}

#[test]
fn refusals_alone_are_sdo() {
    let outcome = run(&frames("c 40 00 50 00/s 80 00 50 00 00 00 02 06"));
    assert_eq!(outcome.codes(), [Code::Sdo017]);
}

#[test]
fn the_edge_of_the_capture_is_no_fault() {
    let outcome = run(&frames("c 40 08 10 00/c 40 00 20 00/s 43 00 20 00 01"));
    assert_eq!(outcome.transfers[0].outcome.status, Status::Incomplete);
    assert!(outcome.loud().is_empty());
    for midway in [
        "s 81 00 01 02 03 04 05 06/c A2 01 7F/s C1 0C D9/c A1/c 40 00 20 00/s 43 00 20 00 01",
        "c 82 00 01 02 03 04 05 08/s A2 02 7F/c C1 0C D9/s A1/c 40 00 20 00/s 43 00 20 00 01",
        "s 80 08 10 00 01 00 04 05/c 40 08 10 00/s 43 08 10 00 31/c 40 00 20 00/s 43 00 20 00 01",
    ] {
        let outcome = run(&frames(midway));
        assert!(outcome.loud().is_empty(), "{midway}: {outcome:?}");
        let last = outcome.transfers.last().unwrap();
        assert_eq!((last.outcome.status, last.data.kept[0]), (Status::Ok, 1), "{midway}");
    }
}

#[test]
fn a_lost_request_while_polling_with_stamps_shifts_no_value() {
    let text = frames(
        "c 40 00 20 00/s 43 00 20 00 01/s 43 00 20 00 02/c 40 00 20 00/s 43 00 20 00 03/c 40 00 20 00/s 43 00 20 00 04",
    );
    // In ms: an answer takes 1, the client asks every 4.
    let times = [0, 1, 5, 8, 9, 12, 13];
    let outcome = run_timed(&text, |no| Some(times[no] * 1_000_000));
    let values: Vec<u8> = outcome.transfers.iter().map(|transfer| transfer.data.kept[0]).collect();
    assert_eq!(values, [1, 3, 4]);
    let found: Vec<_> = outcome.loud().iter().map(|f| (f.code, f.at.no)).collect();
    assert_eq!(found, [(Code::Sdo002, 3)]);
}

/// Returns the last transfer before that of `NEXT`, for `GOOD` + text + `NEXT`.
fn before_next(text: &str) -> (Status, Vec<u8>) {
    let outcome = run(&frames(&format!("{GOOD}{text}{NEXT}")));
    let transfer = outcome.transfers.iter().nth_back(1).unwrap();
    (transfer.outcome.status, transfer.data.kept.clone())
}

#[test]
fn a_block_download_without_a_segment() {
    // The server acknowledges nothing, is silent, or refuses.
    let still_there = "s A2 00 7F/c A4 04 20 00 7F/s A2 00 7F/c 80 00 00 00 01 00 04 05";
    for server in ["s A2 00 7F", "", "s 80 04 20 00 01 00 04 05", still_there] {
        let text = format!("c C6 04 20 00/s A4 04 20 00 7F/c C1/{server}").trim_end_matches('/').to_owned();
        assert_eq!(loud(&text), [(Code::Sdo012, 5)], "{server}");
        let (status, kept) = before_next(&text);
        assert!(matches!(status, Status::Failed | Status::Aborted) && kept.is_empty(), "{server}: {status:?}");
    }
    // If a segment carries no data, it is an ordinary transfer.
    let text = "c C6 04 20 00/s A4 04 20 00 7F/c 81/s A2 01 7F/c DD/s A1";
    assert_eq!((loud(text), before_next(text).0), (vec![], Status::Ok));
    // An acknowledgement too many is a fault if the end was correct.
    let text = "c C2 04 20 00 02/s A4 04 20 00 7F/c 81 01 02/s A2 01 7F/c D5/s A2 01 7F/s A1";
    assert_eq!(loud(text), [(Code::Sdo007, 8)]);
}

#[test]
fn a_server_that_segments_without_a_size() {
    let segmented = "c 40 04 20 00/s 40 04 20 00/c 60/s 01 00 01 02 03 04 05 06/";
    let alone = "c 40 04 20 00/s 40 04 20 00 07";
    assert_eq!(loud(alone), [(Code::Sdo022, 4)]);
    // The client does not ask for the segments: its fault, and no value.
    let left = format!("{segmented}c 40 04 20 00/s 40 04 20 00");
    assert_eq!(loud(&left), [(Code::Sdo008, 9)]);
    assert_eq!(before_next(&left), (Status::Incomplete, vec![]));
    // It leaves 0 in the place of data.
    assert_eq!(loud(&format!("{segmented}{alone}")), [(Code::Sdo022, 8)]);
    assert_eq!(loud(format!("{segmented}{segmented}").trim_end_matches('/')), []);
}

#[test]
fn the_acknowledgement_that_was_owed_when_the_server_aborted() {
    let told = |ackseq: u8, delay: i64, more: &str| {
        let block = "c A4 04 20 00 02/s C6 04 20 00 10/c A3/s 01 01 02 03 04 05 06 07/s 02 01 02 03 04 05 06 07";
        let text = format!("{GOOD}{block}/s 80 04 20 00 00 00 04 05/c A2 {ackseq:02X} 02{more}{NEXT}");
        let outcome = run_timed(&frames(&text), |no| Some((no as i64 + if no > 7 { delay } else { 0 }) * 1_000_000));
        let last = outcome.transfers.last().unwrap();
        assert_eq!((last.outcome.status, last.data.kept.as_slice()), (Status::Ok, [0x77].as_slice()), "{outcome:?}");
        outcome.loud().iter().map(|finding| (finding.code, finding.at.no)).collect::<Vec<_>>()
    };
    for delay in [0, 1, 10, 200, 900] {
        assert_eq!(told(2, delay, ""), [], "{delay} ms");
    }
    // Other data than sent, too late, or repeated.
    assert_eq!(told(1, 50, ""), [(Code::Sdo007, 9)]);
    assert_eq!(told(3, 50, ""), [(Code::Sdo007, 9)]);
    assert_eq!(told(2, 1500, ""), [(Code::Sdo007, 9)]);
    assert_eq!(told(2, 50, "/c A2 02 02"), [(Code::Sdo007, 10)]);
}

#[test]
fn late_requests_behind_a_transfer_met_in_its_midst() {
    // Each request is listed after its answer; the first frames belong to a transfer before the capture.
    let answers = "s 4F 02 20 01/c 40 02 20 01";
    for (text, status) in [
        ("c A2 01 01/s 4F 01 20 01/c 40 01 20 01", Status::Ok),
        ("c A3/s 4F 01 20 01/c 40 01 20 01", Status::Ok),
        ("c 60/s 80 01 20 01 00 00 02 06/c 40 01 20 01", Status::Aborted),
    ] {
        let outcome = run(&frames(&format!("{text}/{answers}")));
        assert!(outcome.loud().is_empty(), "{outcome:?}");
        let found = |index| {
            let mut all = outcome.transfers.iter();
            all.find(|it| it.mux == Some(Mux { index, sub: 1 })).map(|it| it.outcome.status)
        };
        assert_eq!((found(0x2001), found(0x2002)), (Some(status), Some(Status::Ok)), "{text}");
    }
}

#[test]
fn a_block_upload_that_was_not_started() {
    let text = "c A4 04 20 00 7F/s C6 04 20 00 07/s 81 00 01 02 03 04 05 06/c A2 01 7F/s C1 0C D9/c A1";
    assert_eq!(loud(text), [(Code::Sdo002, 5)]);
}

#[test]
fn what_follows_from_a_fault_is_linked_to_it() {
    // An unknown command in the place of a request, and the response without request.
    let outcome = run(&frames(&format!("{GOOD}c E0/s 43 00 20 00 01/{}", NEXT.trim_start_matches('/'))));
    assert_eq!(
        outcome.loud().iter().map(|finding| (finding.code, finding.at.no)).collect::<Vec<_>>(),
        [(Code::Sdo023, 3)]
    );
    let linked: Vec<_> =
        outcome.findings.iter().filter_map(|finding| Some((finding.code, finding.because_of?.no))).collect();
    assert_eq!(linked, [(Code::Sdo002, 3)]);
}
