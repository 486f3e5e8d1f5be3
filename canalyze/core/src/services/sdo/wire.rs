//! One SDO frame's eight bytes (CiA 301, 7.2.4.3): command byte, multiplexor, data. Pure; knows no transfer.
//!
//! | byte | initiate, abort | segment | block sub-frames |
//! |---|---|---|---|
//! | 0 | command specifier and flags | `000t nnnc` | command specifier and sub-command, or `c sssssss` |
//! | 1-2 | index, little-endian | data | CRC, or ackseq and blksize, or data |
//! | 3 | sub-index | data | data |
//! | 4-7 | data, size, abort code, or blksize and pst | data | data |
//!
//! The same byte means different things by direction, so every function takes the side. Whether a byte is the
//! sequence number of a block segment only the transfer knows: [`decode`] never returns `BlockSegment`.

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
    /// Asks: sends on 600h + node-ID of the server by default.
    Client,
    /// Answers: sends on 580h + node-ID by default.
    Server,
}

/// Multiplexor: the object a transfer is about.
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
    /// The indicated size of a segmented transfer, in bytes.
    pub fn size(&self) -> Option<u32> {
        (!self.expedited && self.size_indicated).then(|| u32::from_le_bytes(self.data))
    }

    /// The number of data bytes of an expedited transfer: 4-n with e and s, up to 4 (by the frame) with e alone.
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

/// What an SDO frame says, given who sent it.
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
    /// Client ccs 3: asks for the next segment of an upload.
    SegmentRequest {
        /// t.
        toggle: bool,
    },
    /// Server scs 1: confirms a download segment.
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
        /// Segments in the next sub-block, 1..=127.
        blksize: u8,
    },
    /// Client ccs 5, sub-command 0.
    InitiateBlockUpload {
        /// The object.
        mux: Mux,
        /// cc: the client can generate a CRC.
        crc: bool,
        /// Segments in the next sub-block, 1..=127.
        blksize: u8,
        /// Protocol switch threshold in bytes; 0: switching is not allowed.
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
    /// Client ccs 5, sub-command 3: start the upload.
    StartBlockUpload,
    /// Receiver of a block transfer, sub-command 2.
    BlockAck {
        /// Last segment received in sequence; 0: none.
        ackseq: u8,
        /// Segments in the next sub-block, 1..=127.
        blksize: u8,
    },
    /// Sender of a block transfer, sub-command 1: end.
    EndBlock {
        /// Bytes of the last segment without data, 0..=7.
        unused: u8,
        /// CRC over the data.
        crc: u16,
    },
    /// Receiver of a block transfer, sub-command 1: end confirmed.
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
    /// A command specifier or sub-command that is not defined for this side.
    Unknown(u8),
    /// The frame ends before the object that its command byte calls for.
    Truncated(u8),
    /// Not known: the capture does not show the transfer, and the bytes can be read in several ways.
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
        // Byte 81h..9Fh is rather a block segment met in mid-transfer than an abort with reserved bits.
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

/// The same, given how many bytes the frame has: a frame too short for its object names none, and an
/// acknowledgement without its numbers acknowledges nothing.
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

/// The frame read as a segment of a block transfer (sub-block phase). Byte 80h there is an abort.
pub fn block_segment(bytes: [u8; 8]) -> Command {
    let [command, b1, b2, b3, b4, b5, b6, b7] = bytes;
    if command == 0x80 {
        let mux = Mux { index: u16::from_le_bytes([b1, b2]), sub: b3 };
        return Command::Abort(mux, u32::from_le_bytes([b4, b5, b6, b7]));
    }
    Command::BlockSegment { seqno: command & 0x7F, last: command & 0x80 != 0, data: [b1, b2, b3, b4, b5, b6, b7] }
}

impl Command {
    /// The object, for commands that carry one. An abort's multiplexor is unreliable and not among them.
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

    /// Whether the frame says nothing that could belong to a transfer.
    pub fn is_unreadable(&self) -> bool {
        matches!(self, Self::Unknown(_) | Self::Truncated(_) | Self::Undetermined(_))
    }

    /// Whether the sender of a block transfer's data may send it.
    pub fn is_of_block(&self) -> bool {
        matches!(self, Self::BlockSegment { .. } | Self::EndBlock { .. } | Self::Abort(..))
    }

    /// Whether a client starts a transfer with it.
    pub fn is_initiate(&self) -> bool {
        matches!(
            self,
            Self::InitiateDownload(..)
                | Self::InitiateUpload(_)
                | Self::InitiateBlockDownload { .. }
                | Self::InitiateBlockUpload { .. }
        )
    }

    /// Whether a client starts a block transfer with it.
    pub fn is_block_initiate(&self) -> bool {
        matches!(self, Self::InitiateBlockDownload { .. } | Self::InitiateBlockUpload { .. })
    }

    /// A block size that is not 1..=127.
    pub fn has_invalid_block_size(&self) -> bool {
        match self {
            Self::InitiateBlockUpload { blksize, .. } | Self::BlockDownloadInitiated { blksize, .. } => {
                !(1..=127).contains(blksize)
            }
            _ => false,
        }
    }

    /// n of an initiate that is not zero though e and s are not both set (CiA 301: n shall then be 0).
    pub fn has_invalid_unused(&self) -> bool {
        match self {
            Self::InitiateDownload(_, i) | Self::UploadInitiated(_, i) => {
                i.unused != 0 && !(i.expedited && i.size_indicated)
            }
            _ => false,
        }
    }

    /// Whether reserved bits of the command byte, reserved bytes, or bytes said to carry no data are not 0.
    ///
    /// An initiate with e = s = 0 is left to the rules for that quirk. The CRC field is not reserved here:
    /// stacks leave stale values in it.
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

/// Whether `response` can be the answer to `request`: the right kind, the same object, the same toggle bit.
pub fn fits(request: &Command, response: &Command) -> bool {
    kind_fits(request, response)
        && match (request, response) {
            (Command::SegmentRequest { toggle }, Command::Segment(s)) => *toggle == s.toggle,
            (Command::Segment(s), Command::SegmentResponse { toggle }) => *toggle == s.toggle,
            _ => request.mux() == response.mux(),
        }
}

/// Whether `response` is of the kind that answers `request`, whatever its object and toggle bit.
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

/// Whether a response, or an abort for the same object, can be the answer to a request.
pub fn may_answer(request: &Command, answer: &Command) -> bool {
    match answer {
        Command::Abort(object, _) => request.mux() == Some(*object),
        _ => fits(request, answer),
    }
}
