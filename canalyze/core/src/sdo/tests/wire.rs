//! The eight bytes of a frame: one byte by direction, lengths, block commands, and matching answers.

use crate::sdo::wire::{Command, Mux, Side, block_segment, decode, fits, kind_fits};

#[test]
fn same_byte_by_direction() {
    let seg = [0x60, 0, 0, 0, 0, 0, 0, 0];
    assert_eq!(decode(Side::Client, seg), Command::SegmentRequest { toggle: false });
    assert_eq!(decode(Side::Server, seg), Command::DownloadInitiated(Mux { index: 0, sub: 0 }));
    let twenty = [0x20, 0x03, 0x20, 0x02, 0x0A, 0, 0, 0];
    assert!(matches!(decode(Side::Client, twenty), Command::InitiateDownload(m, i)
        if m == Mux { index: 0x2003, sub: 2 } && !i.expedited && !i.size_indicated));
    assert_eq!(decode(Side::Server, twenty), Command::SegmentResponse { toggle: false });
}

#[test]
fn last_segment_of_the_notes() {
    let Command::Segment(s) = decode(Side::Server, [0x1B, 0x64, 0x65, 0, 0, 0, 0, 0]) else {
        panic!("1B is a segment");
    };
    assert!(s.toggle && s.last);
    assert_eq!(s.unused, 5);
}

#[test]
fn expedited_lengths() {
    for (command, len) in [(0x43, 4), (0x47, 3), (0x4B, 2), (0x4F, 1), (0x42, 4)] {
        let Command::UploadInitiated(_, i) = decode(Side::Server, [command, 0, 0x20, 0, 1, 2, 3, 4]) else {
            panic!("{command:02X} is an upload response");
        };
        assert!(i.expedited);
        assert_eq!(i.expedited_len(8), len);
    }
    let Command::UploadInitiated(_, i) = decode(Side::Server, [0x41, 8, 0x10, 0, 0x17, 0, 0, 0]) else {
        panic!("41 is an upload response");
    };
    assert_eq!(i.size(), Some(23));
}

#[test]
fn block_commands() {
    let mux = Mux { index: 0x2004, sub: 0 };
    assert_eq!(
        decode(Side::Client, [0xA4, 4, 0x20, 0, 0x7F, 0x17, 0, 0]),
        Command::InitiateBlockUpload { mux, crc: true, blksize: 0x7F, threshold: 0x17 }
    );
    assert_eq!(
        decode(Side::Server, [0xC6, 4, 0x20, 0, 0x14, 0, 0, 0]),
        Command::BlockUploadInitiated { mux, crc: true, size: Some(20) }
    );
    assert_eq!(
        decode(Side::Client, [0xC6, 4, 0x20, 0, 0x14, 0, 0, 0]),
        Command::InitiateBlockDownload { mux, crc: true, size: Some(20) }
    );
    assert_eq!(
        decode(Side::Server, [0xA4, 4, 0x20, 0, 0x7F, 0, 0, 0]),
        Command::BlockDownloadInitiated { mux, crc: true, blksize: 0x7F }
    );
    assert_eq!(decode(Side::Server, [0xC5, 0xCC, 0xAC, 0, 0, 0, 0, 0]), Command::EndBlock { unused: 1, crc: 0xACCC });
    assert_eq!(
        block_segment([0x83, 1, 2, 3, 4, 5, 6, 7]),
        Command::BlockSegment { seqno: 3, last: true, data: [1, 2, 3, 4, 5, 6, 7] }
    );
    assert!(matches!(block_segment([0x80, 8, 0x10, 0, 0, 0, 4, 5]), Command::Abort(_, 0x0504_0000)));
}

#[test]
fn what_fits() {
    let mux = Mux { index: 0x1008, sub: 0 };
    let other = Mux { index: 0x1009, sub: 0 };
    let read = Command::InitiateUpload(mux);
    let answer = |mux| decode(Side::Server, [0x43, (mux as Mux).index as u8, 0x10, 0, 0, 0, 0, 0]);
    assert!(fits(&read, &answer(mux)));
    assert!(!fits(&read, &answer(other)));
    assert!(kind_fits(&read, &answer(other)));
    assert!(!kind_fits(&read, &Command::DownloadInitiated(mux)));
}
