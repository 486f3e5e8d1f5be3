//! One CAN frame, independent of the format of its capture.
//!
//! A frame knows nothing of CANopen. It keeps the digits of its stamp, its direction and its raw DLC, so that it can be
//! printed exactly as it was recorded. It owns no heap memory, since frames are copied on the hot path.

use crate::bytes::ns::Ns;

use std::num::NonZeroU64;

/// A bus (capture interface), as an index into [`Buses`]. Index 0 is the first interface of the capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BusId(pub u8);

impl BusId {
    /// The bus of something that was not captured.
    pub const NONE: Self = Self(u8::MAX);
    /// Any bus after the first [`MAX_BUSES`]; its frames are counted and skipped.
    pub const BEYOND: Self = Self(u8::MAX - 1);
}

/// Maximum number of buses of a capture that are told apart (invariant 6). Frames of further ones are skipped.
pub const MAX_BUSES: usize = 64;
/// Maximum length of a bus name, in bytes; the rest is cut off. Linux allows 15.
pub const MAX_BUS_NAME: usize = 32;

/// The names of a capture's buses in order of first appearance.
///
/// The name is empty if the capture has no interface column.
#[derive(Clone, Debug, Default)]
pub struct Buses {
    names: Vec<Box<[u8]>>,
    last: usize,
}

impl Buses {
    /// Returns the index of `name`, adding it if it is new; [`BusId::BEYOND`] for the 65th and later names.
    pub fn intern(&mut self, name: &[u8]) -> BusId {
        let name = name.get(..MAX_BUS_NAME).unwrap_or(name);
        if self.names.get(self.last).is_some_and(|known| &**known == name) {
            return BusId(self.last as u8);
        }
        let index = match self.names.iter().position(|known| &**known == name) {
            Some(index) => index,
            None if self.names.len() < MAX_BUSES => {
                self.names.push(name.into());
                self.names.len() - 1
            }
            None => return BusId::BEYOND,
        };
        self.last = index;
        BusId(index as u8)
    }

    /// Returns the name of a bus; empty if the capture names none.
    pub fn name(&self, bus: BusId) -> &[u8] {
        self.names.get(usize::from(bus.0)).map_or(b"", |name| name)
    }

    /// Returns the number of buses.
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// Iterates over all names in order of first appearance.
    pub fn names(&self) -> impl Iterator<Item = &[u8]> {
        self.names.iter().map(|name| &**name)
    }
}

/// A CAN identifier of 11 or 29 bits, with its frame format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CanId(u32);

impl CanId {
    const EXTENDED: u32 = 0x8000_0000;

    /// Makes an 11-bit identifier; higher bits are cut off.
    pub const fn standard(id: u16) -> Self {
        Self((id & 0x7FF) as u32)
    }

    /// Makes a 29-bit identifier; higher bits are cut off.
    pub const fn extended(id: u32) -> Self {
        Self(id & 0x1FFF_FFFF | Self::EXTENDED)
    }

    /// Returns the number of the identifier: 000..7FF or 00000000..1FFFFFFF.
    pub const fn raw(self) -> u32 {
        self.0 & 0x1FFF_FFFF
    }

    /// Returns true for a 29-bit identifier (extended frame format).
    pub const fn is_extended(self) -> bool {
        self.0 & Self::EXTENDED != 0
    }
}

impl std::fmt::Debug for CanId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.is_extended() { write!(f, "{:08X}", self.raw()) } else { write!(f, "{:03X}", self.raw()) }
    }
}

/// The kind of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A classic data frame, 0 to 8 bytes.
    Data,
    /// A remote frame (RTR) without data; `len` is the requested length.
    Remote,
    /// A CAN FD data frame, 0 to 64 bytes.
    Fd {
        /// Bit rate switch.
        brs: bool,
        /// Error state indicator: the sender is error passive.
        esi: bool,
    },
    /// A SocketCAN error frame: `id` carries the error class bits (without the error flag), `data` the details.
    Error,
}

/// The direction of a frame, seen from the capturing host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Received from the bus.
    Rx,
    /// Sent by the capturing host.
    Tx,
}

/// A time stamp as written, so that its digits can be printed unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// The form in which it is written.
    pub form: StampForm,
    /// The written number, in ns: seconds, a difference, or local civil time as if it were UTC.
    pub ns: Ns,
    /// Digits before the decimal point (for zero padding); 1..=20. Unused for `Calendar`.
    pub width: u8,
    /// Digits after the decimal point, 0..=9.
    pub decimals: u8,
}

/// The last whole second that an `i64` of nanoseconds can represent, 2262-04-11 23:47:16. Readers clamp later stamps to
/// it, and stamps before 1970 to its negative.
pub const LAST_SECOND_NS: Ns = Ns(i64::MAX / 1_000_000_000 * 1_000_000_000);

/// The forms of a time stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StampForm {
    /// `(1549455524.265601)`, `(000.304418)`: seconds, absolute, from zero, or since the frame before.
    Seconds,
    /// `(2026-09-15 18:44:56.479963)`: local time, no zone.
    Calendar,
}

/// The form in which the capture writes a length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LengthForm {
    /// candump `-8`: braces around the raw DLC.
    pub braces: bool,
    /// Raw DLC 9..=15 of a classic frame with 8 bytes; 0 if it equals `len`.
    pub raw_dlc: u8,
    /// A two-digit length in brackets, `[08]`, as candump prints FD frames.
    pub two_digits: bool,
}

/// One frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Number in the capture, from 1, over all its files; where frames are judged in another order, that of the place
    /// among them.
    pub no: u64,
    /// Its number in the files, less `no`.
    pub moved: i32,
    /// Time in ns by which `t_ns` is later than the stamp in the capture, as its clock is not that of other frames; 0 for
    /// most.
    pub corrected_ns: i32,
    /// Line in its file, from 1; `None` in binary formats.
    pub line: Option<u64>,
    /// Time in ns: since the epoch, since the start of the capture, or civil time as if it were UTC. `None` without
    /// stamps.
    pub t_ns: Option<Ns>,
    /// The stamp as written; `None` without stamps.
    pub stamp: Option<Stamp>,
    /// The bus on which it was captured.
    pub bus: BusId,
    /// The identifier; the error class for [`Kind::Error`].
    pub id: CanId,
    /// Data, remote, FD or error.
    pub kind: Kind,
    /// Direction; `None` if the capture does not record it.
    pub dir: Option<Direction>,
    /// Payload length in bytes, 0..=64 (for a remote frame the requested length, 0..=8).
    pub len: u8,
    /// The form in which the length is written.
    pub length_form: LengthForm,
    /// Payload; bytes from `len` on are zero.
    pub data: [u8; 64],
}

impl Frame {
    /// Returns true if the stamp was out of range and has been clamped to ± [`LAST_SECOND_NS`].
    pub fn is_clamped(&self) -> bool {
        self.t_ns.is_some_and(|t_ns| t_ns.abs() >= LAST_SECOND_NS.abs())
    }

    /// Makes a classic data frame on bus 0 without a stamp.
    pub fn classic(id: CanId, payload: &[u8]) -> Self {
        let mut data = [0; 64];
        let len = payload.len().min(8);
        for (slot, byte) in data.iter_mut().zip(payload.iter().take(8)) {
            *slot = *byte;
        }
        Self {
            no: 0,
            moved: 0,
            corrected_ns: 0,
            line: None,
            t_ns: None,
            stamp: None,
            bus: BusId(0),
            id,
            kind: Kind::Data,
            dir: None,
            len: len as u8,
            length_form: LengthForm::default(),
            data,
        }
    }

    /// Returns the payload bytes; none for a remote frame.
    pub fn payload(&self) -> &[u8] {
        if matches!(self.kind, Kind::Remote) {
            &[]
        } else {
            self.data.get(..usize::from(self.len)).unwrap_or(&self.data)
        }
    }

    /// Returns the first eight payload bytes, zero-extended, as classic services decode them.
    pub fn head(&self) -> [u8; 8] {
        let [a, b, c, d, e, f, g, h, ..] = self.data;
        [a, b, c, d, e, f, g, h]
    }

    /// Returns the frame with the number and the stamp that it has in the files, as it is printed.
    pub fn listed(&self) -> Self {
        let FrameRef { no, moved, corrected_ns, t_ns, .. } = self.reference().listed();
        Self { no, moved, corrected_ns, t_ns, ..*self }
    }

    /// Returns true if the frame is judged at another place or at another time than the files list it.
    pub fn is_relisted(&self) -> bool {
        self.moved != 0 || self.corrected_ns != 0
    }

    /// Returns the number, line and time of this frame, for events and findings.
    pub fn reference(&self) -> FrameRef {
        FrameRef {
            no: self.no,
            moved: self.moved,
            corrected_ns: self.corrected_ns,
            t_ns: self.t_ns,
            line: self.line.and_then(NonZeroU64::new),
        }
    }
}

/// A reference to a frame: its number, line and time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameRef {
    /// Number in the capture, from 1, in the order in which frames are judged.
    pub no: u64,
    /// Its number in the files, less `no`.
    pub moved: i32,
    /// Time in ns by which `t_ns` is later than the stamp in the capture.
    pub(crate) corrected_ns: i32,
    pub(crate) line: Option<NonZeroU64>,
    /// Time in ns.
    pub t_ns: Option<Ns>,
}

impl FrameRef {
    /// Returns the reference with another line, from 1.
    pub fn with_line(self, line: Option<u64>) -> Self {
        Self { line: line.and_then(NonZeroU64::new), ..self }
    }

    /// Returns its line in its file, from 1.
    pub fn line(self) -> Option<u64> {
        self.line.map(NonZeroU64::get)
    }

    /// Returns the reference with the number and the stamp that the frame has in the files, as it is printed.
    pub fn listed(self) -> Self {
        let t_ns = self.t_ns.map(|t_ns| t_ns - Ns(i64::from(self.corrected_ns)));
        Self { no: self.no.saturating_add_signed(i64::from(self.moved)), t_ns, moved: 0, corrected_ns: 0, ..self }
    }

    /// Returns its number; `None` where it is no frame.
    pub fn number(self) -> Option<u64> {
        Some(self.no).filter(|no| *no > 0)
    }

    /// Returns the time from `then` to this frame, in ns; `None` if either has no stamp.
    #[inline]
    pub fn since(self, then: impl Into<Option<Self>>) -> Option<Ns> {
        Some(self.t_ns? - then.into()?.t_ns?)
    }
}
