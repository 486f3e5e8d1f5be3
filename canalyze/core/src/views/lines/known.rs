//! Lines of PDOs that were written before, up to their signals: of one CAN-ID they differ in stamp and data only, and nine
//! tenths of a capture are such lines.

use crate::bytes::frame::{BusId, CanId, Direction, Frame, Kind, LengthForm};
use crate::words::digits::{hex_digits, put_beginning};
use crate::world::event::{Event, ProcessData, Signals, Unmapped, What};

/// Bytes of the data column: eight bytes, each behind a blank.
pub(super) const DATA: usize = 24;

/// All that decides such a line from the bus to its signals, except for its data and the layout of the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PdoForm {
    bus: BusId,
    id: CanId,
    dir: Option<Direction>,
    len: u8,
    length_form: LengthForm,
    transmit: bool,
    number: u16,
    node: u8,
    /// The reason for a PDO without signals.
    why: Option<Unmapped>,
}

impl PdoForm {
    /// Returns the form of a frame's line, and its PDO, if it is such a line and has nothing below it.
    #[inline]
    pub(super) fn of<'a>(frame: &Frame, events: &'a [Event]) -> Option<(Self, &'a ProcessData)> {
        let [Event { what: What::Pdo(data), .. }] = events else { return None };
        let ProcessData { transmit, number, node, .. } = *data;
        let why = if let Signals::None(why) = data.content { Some(why) } else { None };
        let Frame { bus, id, kind: Kind::Data, dir, len: len @ ..=8, length_form, .. } = *frame else { return None };
        Some((Self { bus, id, dir, len, length_form, transmit, number, node, why }, data))
    }

    /// Returns true if nothing is behind the part of the line that is kept.
    #[inline]
    pub(super) fn ends(&self, pdo: &ProcessData) -> bool {
        self.why.is_some() && pdo.sync.is_none()
    }

    fn place(&self) -> usize {
        // Multiplied by 2^32 by the golden ratio, numbers that are close to each other have places of their own.
        let key = self.id.raw() ^ u32::from(self.bus.0) << 24;
        (key.wrapping_mul(0x9E37_79B9) >> 24) as usize % KnownLines::PLACES
    }
}

/// A line from the bus to its signals, in two lines of the processor's cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct KnownLine {
    form: PdoForm,
    bytes: [u8; KnownLines::MOST],
    len: u8,
    /// The place of the data column.
    data: u8,
}

/// Such lines by their forms. The last one of each place is kept.
#[derive(Debug, Default)]
pub(super) struct KnownLines {
    lines: Vec<Option<KnownLine>>,
    /// Number of lines that were not kept, since memory for a few of them is not worth it.
    few: usize,
    /// The columns' layout in these lines.
    layout: (usize, bool),
}

impl KnownLines {
    /// Number of places: most captures have fewer CAN-IDs.
    const PLACES: usize = 256;
    /// Number of lines from which on they are kept.
    const FEW: usize = 32;
    /// Maximum length of a kept line, in bytes.
    const MOST: usize = 106;

    /// Appends the line of a frame up to its signals if one of its form is known in this layout of the columns; returns
    /// true if it is.
    #[inline]
    pub(super) fn put(&self, out: &mut Vec<u8>, form: &PdoForm, frame: &Frame, layout: (usize, bool)) -> bool {
        let Some(Some(known)) = self.lines.get(form.place()) else { return false };
        if known.form != *form || self.layout != layout {
            return false;
        }
        let start = out.len();
        put_beginning(out, &known.bytes, usize::from(known.len));
        let place = start + usize::from(known.data);
        if let Some(column) = out.get_mut(place..).and_then(<[u8]>::first_chunk_mut) {
            put_data(column, frame.head(), frame.len);
        }
        true
    }

    /// Keeps the line of a frame up to its signals, unless it is too long. `data`: the place of the data column.
    pub(super) fn keep(&mut self, form: &PdoForm, line: &[u8], data: usize, layout: (usize, bool)) {
        if self.few < Self::FEW {
            self.few += 1;
            return;
        }
        if self.lines.is_empty() || self.layout != layout {
            (self.lines, self.layout) = (vec![None; Self::PLACES], layout);
        }
        let mut bytes = [0; Self::MOST];
        if let Some(known) = self.lines.get_mut(form.place())
            && let Some(kept) = bytes.get_mut(..line.len())
        {
            kept.copy_from_slice(line);
            *known = Some(KnownLine { form: *form, bytes, len: line.len() as u8, data: data as u8 });
        }
    }
}

/// Writes the data column of a frame with up to eight bytes, where it has to be: bytes that were just written one by one
/// are slow to copy.
#[inline]
pub(super) fn put_data(column: &mut [u8; DATA], bytes: [u8; 8], len: u8) {
    *column = [b' '; DATA];
    for ([_, high, low], byte) in column.as_chunks_mut::<3>().0.iter_mut().zip(bytes) {
        [*high, *low] = hex_digits(byte);
    }
    if len < 8 {
        column.get_mut(3 * usize::from(len)..).unwrap_or_default().fill(b' ');
    }
}
