//! One SDO transfer: its object, its data so far, its end.
//!
//! Memory is bounded: [`KEPT`] bytes are kept, length and CRC go on. A claimed size allocates nothing. The channel
//! decides and updates the transfer.

use crc::{CRC_16_IBM_3740, CRC_16_KERMIT, CRC_16_XMODEM, Crc, Digest, Table};

use super::abort_code::AbortCode;
use super::wire::{Mux, Segment, Side};
use crate::bytes::frame::{BusId, CanId, FrameRef};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Code, CrcMatch};
use crate::world::dictionary::Described;
use crate::world::od::DataType;

/// Maximum number of bytes of a transfer kept for its value.
pub const KEPT: usize = 65_536;
/// Maximum number of holes kept per transfer; after the last, no data are kept.
pub const MOST_HOLES: usize = 1024;
/// FNV-1a, 64 bits: offset basis and prime.
const FNV_OFFSET: u64 = 0xCBF2_9CE4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01B3;
/// Maximum number of findings listed with a transfer.
const FINDINGS: usize = 16;

static XMODEM: Crc<u16, Table<1>> = Crc::<u16, Table<1>>::new(&CRC_16_XMODEM);
static FFFF: Crc<u16, Table<1>> = Crc::<u16, Table<1>>::new(&CRC_16_IBM_3740);
static REFLECTED: Crc<u16, Table<1>> = Crc::<u16, Table<1>>::new(&CRC_16_KERMIT);

/// Number of a transfer in the capture, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TransferId(pub u64);

/// The direction of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Read from the server.
    Upload,
    /// Written to the server.
    Download,
}

impl Direction {
    /// Returns the word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Upload => "upload",
            Self::Download => "download",
        }
    }
}

/// The mode of transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// In the initiate frames.
    Expedited,
    /// In segments of seven bytes, each confirmed.
    Segmented,
    /// In sub-blocks of up to 127 segments, with CRC.
    Block,
}

impl Mode {
    /// Returns the word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Expedited => "expedited",
            Self::Segmented => "segmented",
            Self::Block => "block",
        }
    }
}

/// The status of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Still running.
    Open,
    /// Completed.
    Ok,
    /// Aborted by either side.
    Aborted,
    /// Cut by the edge of the capture, by lost frames or by a reset of the node: no violation.
    Incomplete,
    /// Ended in violation of the protocol: its data cannot be trusted.
    Failed,
}

impl Status {
    /// Returns the word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Ok => "ok",
            Self::Aborted => "aborted",
            Self::Incomplete => "incomplete",
            Self::Failed => "failed",
        }
    }
}

/// An abort that ended a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abort {
    /// Abort code.
    pub code: AbortCode,
    /// The sender.
    pub by: Side,
}

/// Running checksums of a block transfer's data.
#[derive(Clone)]
struct Sums {
    xmodem: Digest<'static, u16, Table<1>>,
    ffff: Digest<'static, u16, Table<1>>,
    reflected: Digest<'static, u16, Table<1>>,
}

/// Bytes missing in the capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hole {
    /// Its first byte, counted from the beginning of the known data.
    pub offset: u64,
    /// Number of missing bytes; `None` if unknown.
    pub length: Option<u64>,
}

/// The holes of one transfer in order.
#[derive(Clone, Debug, Default)]
pub struct Holes {
    pub(super) list: Vec<Hole>,
    /// The last byte of the object was seen, or is missing in its place.
    pub(super) ended: bool,
}

impl Holes {
    /// Returns the holes in order.
    pub fn list(&self) -> &[Hole] {
        &self.list
    }

    /// Returns true if the limit is reached, so that further bytes have no place.
    pub(super) fn is_full(&self) -> bool {
        self.list.len() >= MOST_HOLES
    }

    pub(super) fn add(&mut self, offset: u64, length: Option<u64>) {
        let last_kept = self.list.len() + 1 == MOST_HOLES;
        match (self.list.last_mut(), length) {
            (Some(Hole { offset: last, length: Some(before) }), Some(length)) if *last + *before == offset => {
                *before = before.saturating_add(length);
            }
            (Some(Hole { offset: last, length: None }), None) if *last == offset => {}
            _ if last_kept => self.list.push(Hole { offset, length: None }),
            _ => self.list.push(Hole { offset, length }),
        }
    }

    pub(super) fn has_unknown(&self) -> bool {
        self.list.iter().any(|hole| hole.length.is_none())
    }
}

/// The data of a transfer.
#[derive(Clone)]
pub struct Data {
    /// Size in bytes as indicated by the sender of the data.
    pub size_indicated: Option<u32>,
    /// The other side's frame that initiated the transfer; it indicates the size of an upload.
    pub initiated: Option<FrameRef>,
    /// Number of transferred bytes up to the last seen one, including holes of known length.
    pub size: u64,
    /// The first [`KEPT`] of them; 0 in holes.
    pub kept: Vec<u8>,
    /// The bytes in the request of an expedited download, which count once the server has confirmed them.
    pub requested: Vec<u8>,
    /// FNV-1a over all of them, to compare the data of transfers of any length.
    pub digest: u64,
    /// Segments transferred; 0 for an expedited transfer.
    pub segments: u32,
    /// Every segment but the last carried seven bytes.
    pub even: bool,
    /// The capture lacks a part: size and CRC cannot be judged.
    pub hole: bool,
    /// The missing parts.
    pub holes: Holes,
    /// Bytes seen since they were last passed on, if data are extracted.
    pub fresh: Vec<u8>,
    extract: bool,
    sums: Option<Box<Sums>>,
}

/// The course of a transfer.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Its status.
    pub status: Status,
    /// The abort that ended it.
    pub abort: Option<Abort>,
    /// A client frame was captured after its answer.
    pub reordered: bool,
    /// Number of sub-blocks that were partly repeated.
    pub retransmissions: u32,
    /// Both sides announced that they support a CRC. `None` outside block transfers.
    pub crc_negotiated: Option<bool>,
    /// The capture lacks its initiate request.
    pub midway: bool,
    /// Its content is wrong although both sides took it as complete: another object was answered.
    pub bad: bool,
    /// Findings of this transfer, the first sixteen.
    pub findings: Vec<Code>,
}

/// One transfer.
#[derive(Clone)]
pub struct Transfer {
    /// Its number.
    pub id: TransferId,
    /// The bus.
    pub bus: BusId,
    /// The server's node-ID.
    pub node: u8,
    /// The identifier (client to server) of its channel unless it is the default one.
    pub channel: Option<CanId>,
    /// The session of a USDO transfer; `None` for SDO.
    pub session: Option<UsdoSession>,
    /// Upload or download.
    pub direction: Direction,
    /// Expedited, segmented or block.
    pub mode: Mode,
    /// The object; `None` if the initiate request was not captured.
    pub mux: Option<Mux>,
    /// The description of the object.
    pub described: Described,
    /// First frame.
    pub first: FrameRef,
    /// Last frame so far.
    pub last: FrameRef,
    /// The transferred data.
    pub data: Data,
    /// Its course.
    pub outcome: Outcome,
}

impl std::fmt::Debug for Transfer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Transfer")
            .field("id", &self.id.0)
            .field("direction", &self.direction)
            .field("mode", &self.mode)
            .field("mux", &self.mux)
            .field("status", &self.outcome.status)
            .field("abort", &self.outcome.abort)
            .field("size", &self.data.size)
            .field("kept", &self.data.kept)
            .finish_non_exhaustive()
    }
}

/// The session of a USDO transfer (CiA 1301).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UsdoSession {
    /// The client's node-ID.
    pub client: u8,
    /// The session-ID, 1..=255.
    pub id: u8,
}

/// The parameters of a new transfer.
#[derive(Clone, Copy, Debug)]
pub struct Beginning {
    /// Its number.
    pub id: TransferId,
    /// The bus.
    pub bus: BusId,
    /// The server's node-ID.
    pub node: u8,
    /// The identifier of its channel unless it is the default one.
    pub channel: Option<CanId>,
    /// True if its data are passed on as they come.
    pub extract: bool,
    /// Its first frame.
    pub at: FrameRef,
}

impl Transfer {
    /// Returns the type of its object by the server's description, else by the standard.
    pub fn data_type(&self) -> Option<DataType> {
        self.mux.and_then(|mux| self.described.data_type(mux.index, mux.sub))
    }

    /// Returns true if it reads an error register (1001h) of 0.
    pub fn shows_no_error(&self) -> bool {
        let read = self.direction == Direction::Upload && self.outcome.status == Status::Ok;
        read && self.mux == Some(Mux { index: 0x1001, sub: 0 }) && self.data.kept.as_ref() == [0]
    }

    /// Creates a transfer.
    pub fn new(beginning: Beginning, direction: Direction, mode: Mode, mux: Option<Mux>) -> Self {
        let Beginning { id, bus, node, channel, extract, at } = beginning;
        let data = Data {
            size_indicated: None,
            initiated: None,
            size: 0,
            kept: Vec::new(),
            requested: Vec::new(),
            digest: FNV_OFFSET,
            segments: 0,
            even: true,
            hole: false,
            holes: Holes::default(),
            fresh: Vec::new(),
            extract,
            sums: None,
        };
        let outcome = Outcome {
            status: Status::Open,
            abort: None,
            reordered: false,
            retransmissions: 0,
            crc_negotiated: None,
            midway: false,
            bad: false,
            findings: Vec::new(),
        };
        Self {
            id,
            bus,
            node,
            channel,
            session: None,
            direction,
            mode,
            mux,
            described: Described::default(),
            first: at,
            last: at,
            data,
            outcome,
        }
    }

    /// Appends data bytes and keeps as many as allowed.
    pub fn append(&mut self, bytes: &[u8]) {
        if !self.has_place() {
            return;
        }
        self.data.size = self.data.size.saturating_add(bytes.len() as u64);
        let room = KEPT.saturating_sub(self.data.kept.len()).min(bytes.len());
        self.data.kept.extend_from_slice(bytes.get(..room).unwrap_or(&[]));
        self.data.digest =
            bytes.iter().fold(self.data.digest, |digest, byte| (digest ^ u64::from(*byte)).wrapping_mul(FNV_PRIME));
        if self.data.extract {
            self.data.fresh.extend_from_slice(bytes);
        }
        if self.mode == Mode::Block {
            let sums = self.data.sums.get_or_insert_with(|| {
                Box::new(Sums { xmodem: XMODEM.digest(), ffff: FFFF.digest(), reflected: REFLECTED.digest() })
            });
            sums.xmodem.update(bytes);
            sums.ffff.update(bytes);
            sums.reflected.update(bytes);
        }
    }

    /// Appends the data of a segment in a frame of `len` bytes; bytes missing in a short frame become a hole.
    pub fn append_segment(&mut self, segment: &Segment, len: u8) {
        let announced = 7 - usize::from(segment.unused.min(7));
        let carried = announced.min(usize::from(len.saturating_sub(1)));
        self.append(segment.data.get(..carried).unwrap_or(&[]));
        self.miss(Some(announced.saturating_sub(carried) as u64));
    }

    /// Returns the CRC over the data so far, and the variant that explains a different `found`. `padding`: bytes of the
    /// last segment without data.
    pub fn check_crc(&self, found: u16, padding: &[u8]) -> (u16, CrcMatch) {
        let Some(sums) = &self.data.sums else { return (0, CrcMatch::Nothing) };
        let computed = sums.xmodem.clone().finalize();
        let mut padded = sums.xmodem.clone();
        padded.update(padding);
        let matches = if padded.finalize() == found {
            CrcMatch::WithPadding
        } else if sums.ffff.clone().finalize() == found {
            CrcMatch::InitialFfff
        } else if sums.reflected.clone().finalize() == found {
            CrcMatch::Reflected
        } else {
            CrcMatch::Nothing
        };
        (computed, matches)
    }

    /// Lists a finding with the transfer.
    pub fn note_finding(&mut self, code: Code) {
        if self.outcome.findings.len() < FINDINGS && !self.outcome.findings.contains(&code) {
            self.outcome.findings.push(code);
        }
    }

    /// Returns true if all indicated bytes have come, or if the transfer cannot tell.
    pub fn size_is_right(&self) -> bool {
        self.data.hole || self.data.size_indicated.is_none_or(|size| u64::from(size) == self.data.size)
    }

    /// Returns the duration from the first to the last frame in ns if both have stamps.
    pub fn duration_ns(&self) -> Option<Ns> {
        Some(self.last.t_ns? - self.first.t_ns?)
    }
}
