//! The eight bytes of an SDO frame (CiA 301, 7.2.4.3): command byte, multiplexor, data. Pure; independent of transfers.
//!
//! | byte | initiate, abort | segment | block sub-frames |
//! |---|---|---|---|
//! | 0 | command specifier and flags | `000t nnnc` | command specifier and sub-command, or `c sssssss` |
//! | 1-2 | index, little-endian | data | CRC, or ackseq and blksize, or data |
//! | 3 | sub-index | data | data |
//! | 4-7 | data, size, abort code, or blksize and pst | data | data |
//!
//! The meaning of a byte depends on the direction, so every function takes the side. Only the transfer knows if a byte
//! is the sequence number of a block segment: [`decode`] never returns `BlockSegment`.

/// The abort codes of CiA 301 (table 22), ascending.
#[rustfmt::skip]
const ABORT_CODES: [u32; 31] = [
    0x0503_0000, 0x0504_0000, 0x0504_0001, 0x0504_0002, 0x0504_0003, 0x0504_0004, 0x0504_0005, 0x0601_0000,
    0x0601_0001, 0x0601_0002, 0x0602_0000, 0x0604_0041, 0x0604_0042, 0x0604_0043, 0x0604_0047, 0x0606_0000,
    0x0607_0010, 0x0607_0012, 0x0607_0013, 0x0609_0011, 0x0609_0030, 0x0609_0031, 0x0609_0032, 0x0609_0036,
    0x060A_0023, 0x0800_0000, 0x0800_0020, 0x0800_0021, 0x0800_0022, 0x0800_0023, 0x0800_0024,
];

/// The two ends of an SDO channel. They are roles of the channel, not NMT master and slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// The requesting side, by default on 600h + node-ID of the server.
    Client,
    /// The answering side, by default on 580h + node-ID.
    Server,
}

/// A multiplexor: the object of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Mux {
    /// Index in the object dictionary.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
}

/// Flags and data of an initiate download request or initiate upload response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Initiate {
    /// e: the four bytes are the data themselves.
    pub expedited: bool,
    /// s: the size is indicated.
    pub size_indicated: bool,
    /// n: bytes 7-n..7 carry no data; meaningful with e and s only.
    pub unused: u8,
    /// Bytes 4..7.
    pub data: [u8; 4],
}

impl Initiate {
    /// Returns the indicated size of a segmented transfer, in bytes.
    pub fn size(&self) -> Option<u32> {
        (!self.expedited && self.size_indicated).then(|| u32::from_le_bytes(self.data))
    }

    /// Returns the length of expedited data in bytes: 4-n with e and s, up to 4 (by the frame) with e alone.
    pub fn expedited_len(&self, payload_len: u8) -> usize {
        let carried = usize::from(payload_len.saturating_sub(4)).min(4);
        if self.size_indicated { (4 - usize::from(self.unused & 3)).min(carried) } else { carried }
    }
}

/// A download or upload segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// t: alternates, 0 in the first segment.
    pub toggle: bool,
    /// n: bytes at the end without data, 0..=7.
    pub unused: u8,
    /// c: no more segments.
    pub last: bool,
    /// Bytes 1..7.
    pub data: [u8; 7],
}

/// A decoded SDO frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Client, ccs 1.
    InitiateDownload(Mux, Initiate),
    /// Client, ccs 2.
    InitiateUpload(Mux),
    /// Server, scs 3: download initiated.
    DownloadInitiated(Mux),
    /// Server, scs 2: upload initiated.
    UploadInitiated(Mux, Initiate),
    /// Client ccs 0 (download) or server scs 0 (upload).
    Segment(Segment),
    /// Client ccs 3: request for the next segment of an upload.
    SegmentRequest {
        /// t.
        toggle: bool,
    },
    /// Server scs 1: confirmation of a download segment.
    SegmentResponse {
        /// t.
        toggle: bool,
    },
    /// Client ccs 6, sub-command 0.
    InitiateBlockDownload {
        /// The object.
        mux: Mux,
        /// cc: the client can generate a CRC.
        crc: bool,
        /// Size in bytes, if indicated.
        size: Option<u32>,
    },
    /// Server scs 5, sub-command 0.
    BlockDownloadInitiated {
        /// The object.
        mux: Mux,
        /// sc: the server can generate a CRC.
        crc: bool,
        /// Number of segments in the next sub-block, 1..=127.
        blksize: u8,
    },
    /// Client ccs 5, sub-command 0.
    InitiateBlockUpload {
        /// The object.
        mux: Mux,
        /// cc: the client can generate a CRC.
        crc: bool,
        /// Number of segments in the next sub-block, 1..=127.
        blksize: u8,
        /// Protocol switch threshold in bytes; 0 forbids switching.
        threshold: u8,
    },
    /// Server scs 6, sub-command 0.
    BlockUploadInitiated {
        /// The object.
        mux: Mux,
        /// sc: the server can generate a CRC.
        crc: bool,
        /// Size in bytes, if indicated.
        size: Option<u32>,
    },
    /// Client ccs 5, sub-command 3: start of the upload.
    StartBlockUpload,
    /// Receiver of a block transfer, sub-command 2.
    BlockAck {
        /// Last segment received in sequence; 0 is none.
        ackseq: u8,
        /// Number of segments in the next sub-block, 1..=127.
        blksize: u8,
    },
    /// Sender of a block transfer, sub-command 1: end.
    EndBlock {
        /// Number of bytes of the last segment without data, 0..=7.
        unused: u8,
        /// CRC over the data.
        crc: u16,
    },
    /// Receiver of a block transfer, sub-command 1: confirmation of the end.
    BlockEnded,
    /// A segment of a block transfer.
    BlockSegment {
        /// Sequence number in the sub-block, 1..=127.
        seqno: u8,
        /// c: last segment of the transfer.
        last: bool,
        /// Seven data bytes; padding is known at the end.
        data: [u8; 7],
    },
    /// Either side, cs 4.
    Abort(Mux, u32),
    /// A command specifier or sub-command undefined for this side.
    Unknown(u8),
    /// A frame too short for the object that its command byte requires.
    Truncated(u8),
    /// Undetermined: the capture lacks the transfer, and the bytes are ambiguous.
    Undetermined([u8; 8]),
}

/// Decodes one frame's bytes, zero-extended to eight.
pub fn decode(side: Side, bytes: [u8; 8]) -> Command {
    let [command, b1, b2, sub, b4, b5, b6, b7] = bytes;
    let mux = Mux { index: u16::from_le_bytes([b1, b2]), sub };
    let tail = [b4, b5, b6, b7];
    let segment = || Segment {
        toggle: command & 0x10 != 0,
        unused: command >> 1 & 7,
        last: command & 1 != 0,
        data: [b1, b2, sub, b4, b5, b6, b7],
    };
    let initiate = || Initiate {
        expedited: command & 2 != 0,
        size_indicated: command & 1 != 0,
        unused: command >> 2 & 3,
        data: tail,
    };
    let crc_flag = command & 4 != 0;
    let size = (command & 2 != 0).then(|| u32::from_le_bytes(tail));
    let toggle = command & 0x10 != 0;
    match (side, command >> 5) {
        // A byte 81h..9Fh is rather a block segment joined midway than an abort with reserved bits.
        (_, 4) if command == 0x80 || ABORT_CODES.contains(&u32::from_le_bytes(tail)) => {
            Command::Abort(mux, u32::from_le_bytes(tail))
        }
        (_, 0) => Command::Segment(segment()),
        (Side::Client, 1) => Command::InitiateDownload(mux, initiate()),
        (Side::Client, 2) => Command::InitiateUpload(mux),
        (Side::Client, 3) => Command::SegmentRequest { toggle },
        (Side::Server, 1) => Command::SegmentResponse { toggle },
        (Side::Server, 2) => Command::UploadInitiated(mux, initiate()),
        (Side::Server, 3) => Command::DownloadInitiated(mux),
        (_, 6) if command & 1 != 0 => Command::EndBlock { unused: command >> 2 & 7, crc: u16::from_le_bytes([b1, b2]) },
        (Side::Client, 6) => Command::InitiateBlockDownload { mux, crc: crc_flag, size },
        (Side::Server, 6) => Command::BlockUploadInitiated { mux, crc: crc_flag, size },
        (_, 5) => match (side, command & 3) {
            (Side::Client, 0) => Command::InitiateBlockUpload { mux, crc: crc_flag, blksize: b4, threshold: b5 },
            (Side::Server, 0) => Command::BlockDownloadInitiated { mux, crc: crc_flag, blksize: b4 },
            (_, 1) => Command::BlockEnded,
            (_, 2) => Command::BlockAck { ackseq: b1, blksize: b2 },
            (Side::Client, _) => Command::StartBlockUpload,
            (Side::Server, _) => Command::Unknown(command),
        },
        _ => Command::Unknown(command),
    }
}

/// Decodes a frame of `len` bytes: one too short for its object is truncated, as is an acknowledgement without its
/// numbers.
pub fn decode_frame(side: Side, bytes: [u8; 8], len: u8) -> Command {
    let command = decode(side, bytes);
    let names_object = command.mux().is_some() || matches!(command, Command::Abort(..));
    let [first, ..] = bytes;
    let least = match command {
        _ if names_object => 4,
        Command::BlockAck { .. } => 3,
        _ => 1,
    };
    if len < least { Command::Truncated(first) } else { command }
}

/// Decodes the frame as a segment of a block transfer (sub-block phase). Byte 80h is an abort there.
pub fn block_segment(bytes: [u8; 8]) -> Command {
    let [command, b1, b2, b3, b4, b5, b6, b7] = bytes;
    if command == 0x80 {
        let mux = Mux { index: u16::from_le_bytes([b1, b2]), sub: b3 };
        return Command::Abort(mux, u32::from_le_bytes([b4, b5, b6, b7]));
    }
    Command::BlockSegment { seqno: command & 0x7F, last: command & 0x80 != 0, data: [b1, b2, b3, b4, b5, b6, b7] }
}

impl Command {
    /// Returns the object of commands that carry one; an abort's multiplexor is unreliable and excluded.
    pub fn mux(&self) -> Option<Mux> {
        match *self {
            Self::InitiateDownload(mux, _)
            | Self::InitiateUpload(mux)
            | Self::DownloadInitiated(mux)
            | Self::UploadInitiated(mux, _)
            | Self::InitiateBlockDownload { mux, .. }
            | Self::BlockDownloadInitiated { mux, .. }
            | Self::InitiateBlockUpload { mux, .. }
            | Self::BlockUploadInitiated { mux, .. } => Some(mux),
            _ => None,
        }
    }

    /// Returns true if the frame cannot belong to a transfer.
    pub fn is_unreadable(&self) -> bool {
        matches!(self, Self::Unknown(_) | Self::Truncated(_) | Self::Undetermined(_))
    }

    /// Returns true if the sender of a block transfer's data may send it.
    pub fn is_of_sender(&self) -> bool {
        matches!(self, Self::BlockSegment { .. } | Self::EndBlock { .. } | Self::Abort(..))
    }

    /// Returns true if the receiver of a block transfer's data may send it after the beginning.
    pub fn is_of_receiver(&self) -> bool {
        matches!(self, Self::BlockAck { .. } | Self::BlockEnded | Self::StartBlockUpload | Self::Abort(..))
    }

    /// Returns true if it begins a transfer.
    pub fn is_initiate(&self) -> bool {
        matches!(
            self,
            Self::InitiateDownload(..)
                | Self::InitiateUpload(_)
                | Self::InitiateBlockDownload { .. }
                | Self::InitiateBlockUpload { .. }
        )
    }

    /// Returns true if it begins a block transfer.
    pub fn is_block_initiate(&self) -> bool {
        matches!(self, Self::InitiateBlockDownload { .. } | Self::InitiateBlockUpload { .. })
    }

    /// Returns true if the block size is not 1..=127.
    pub fn has_invalid_block_size(&self) -> bool {
        match self {
            Self::InitiateBlockUpload { blksize, .. } | Self::BlockDownloadInitiated { blksize, .. } => {
                !(1..=127).contains(blksize)
            }
            _ => false,
        }
    }

    /// Returns true if n of an initiate is not 0 although e and s are not both set (CiA 301 requires 0).
    pub fn has_invalid_unused(&self) -> bool {
        match self {
            Self::InitiateDownload(_, i) | Self::UploadInitiated(_, i) => {
                i.unused != 0 && !(i.expedited && i.size_indicated)
            }
            _ => false,
        }
    }

    /// Returns true if reserved bits of the command byte, reserved bytes, or bytes marked as unused are not 0.
    ///
    /// An initiate with e = s = 0 is left to the rules for that quirk. The CRC field is not reserved here: stacks leave
    /// stale values in it.
    pub fn has_reserved_bits(&self, bytes: [u8; 8]) -> bool {
        let [command, b1, b2, b3, b4, b5, b6, b7] = bytes;
        let any = |bytes: &[u8]| bytes.iter().any(|byte| *byte != 0);
        match self {
            Self::InitiateDownload(_, i) | Self::UploadInitiated(_, i) => {
                let padding = if i.expedited && i.size_indicated { usize::from(i.unused) } else { 0 };
                command & 0x10 != 0 || any(i.data.get(4 - padding..).unwrap_or(&[]))
            }
            Self::InitiateUpload(_) | Self::DownloadInitiated(_) => command & 0x1F != 0 || any(&[b4, b5, b6, b7]),
            Self::Segment(s) => any(s.data.get(7 - usize::from(s.unused)..).unwrap_or(&[])),
            Self::SegmentRequest { .. } | Self::SegmentResponse { .. } => {
                command & 0x0F != 0 || any(&[b1, b2, b3, b4, b5, b6, b7])
            }
            Self::InitiateBlockDownload { size, .. } | Self::BlockUploadInitiated { size, .. } => {
                command & 0x18 != 0 || (size.is_none() && any(&[b4, b5, b6, b7]))
            }
            Self::BlockDownloadInitiated { .. } => command & 0x1A != 0 || any(&[b5, b6, b7]),
            Self::InitiateBlockUpload { .. } => command & 0x18 != 0 || any(&[b6, b7]),
            Self::StartBlockUpload | Self::BlockEnded => command & 0x1C != 0 || any(&[b1, b2, b3, b4, b5, b6, b7]),
            Self::BlockAck { .. } => command & 0x1C != 0 || any(&[b3, b4, b5, b6, b7]),
            Self::EndBlock { .. } => command & 2 != 0 || any(&[b3, b4, b5, b6, b7]),
            Self::Abort(..) => command & 0x1F != 0,
            Self::BlockSegment { .. } | Self::Unknown(_) | Self::Truncated(_) | Self::Undetermined(_) => false,
        }
    }
}

/// Returns true if `response` can answer `request`: kind, object and toggle bit agree.
pub fn fits(request: &Command, response: &Command) -> bool {
    kind_fits(request, response)
        && match (request, response) {
            (Command::SegmentRequest { toggle }, Command::Segment(s)) => *toggle == s.toggle,
            (Command::Segment(s), Command::SegmentResponse { toggle }) => *toggle == s.toggle,
            _ => request.mux() == response.mux(),
        }
}

/// Returns true if `response` is of the kind that answers `request`, with any object and toggle bit.
pub fn kind_fits(request: &Command, response: &Command) -> bool {
    use Command as C;
    matches!(
        (request, response),
        (C::InitiateUpload(_), C::UploadInitiated(..))
            | (C::InitiateDownload(..), C::DownloadInitiated(_))
            | (C::SegmentRequest { .. }, C::Segment(_))
            | (C::Segment(_), C::SegmentResponse { .. })
            | (C::InitiateBlockDownload { .. }, C::BlockDownloadInitiated { .. })
            | (C::InitiateBlockUpload { .. }, C::BlockUploadInitiated { .. } | C::UploadInitiated(..))
            | (C::EndBlock { .. }, C::BlockEnded)
    )
}

/// Returns true if a response, or an abort for the same object, can answer a request.
pub fn may_answer(request: &Command, answer: &Command) -> bool {
    match answer {
        Command::Abort(object, _) => request.mux() == Some(*object),
        _ => fits(request, answer),
    }
}
