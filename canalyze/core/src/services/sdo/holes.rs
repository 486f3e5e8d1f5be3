//! The parts of a transfer's data that the capture does not show: where each stands, and how long it is.
//!
//! A hole whose length is known keeps its place: what comes behind it has its true offset. Where a length is not known,
//! the bytes behind follow those before, and their offset in the object is not known. It decides nothing: whoever takes
//! frames says that something is missing, and when the last byte was seen.

use super::transfer::{KEPT, Mode, Status, Transfer};

/// Most holes of one transfer that are kept; behind the last of them nothing is.
pub const MOST_HOLES: usize = 1024;

/// The longest hole that is measured by the size of the object, which is only claimed.
const LONGEST: u64 = 4096;

/// Bytes that the capture does not show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hole {
    /// Where it begins: bytes from the beginning of the transfer's data, as far as those are known.
    pub offset: u64,
    /// How many bytes are missing. `None`: it is not known.
    pub length: Option<u64>,
}

/// The holes of one transfer, by their place.
#[derive(Clone, Debug, Default)]
pub struct Holes {
    list: Vec<Hole>,
    /// The last byte of the object was seen, or is missing in its place.
    ended: bool,
}

impl Holes {
    /// The holes, by their place.
    pub fn list(&self) -> &[Hole] {
        &self.list
    }

    /// There are more holes than are kept: no byte has a place any more.
    fn is_full(&self) -> bool {
        self.list.len() >= MOST_HOLES
    }

    fn add(&mut self, offset: u64, length: Option<u64>) {
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

    fn has_unknown(&self) -> bool {
        self.list.iter().any(|hole| hole.length.is_none())
    }
}

impl Transfer {
    /// What comes before the first byte is not in the capture.
    pub fn miss_beginning(&mut self) {
        self.data.holes.add(0, None);
    }

    /// The first byte that comes is the first one of the object.
    pub fn begin_with_first(&mut self) {
        self.data.holes = Holes::default();
    }

    /// The next bytes of the data are not in the capture; `None`: their number is not known.
    pub fn miss(&mut self, length: Option<u64>) {
        let data = &mut self.data;
        if length == Some(0) {
            return;
        }
        data.hole = true;
        if data.holes.is_full() {
            return;
        }
        data.holes.add(data.size, length);
        if data.holes.is_full() {
            return;
        }
        data.size = data.size.saturating_add(length.unwrap_or(0));
        let end = usize::try_from(data.size).unwrap_or(KEPT).min(KEPT);
        if data.kept.len() < end && length.is_some() {
            data.kept.resize(end, 0);
        }
    }

    /// The last byte of the object has its place.
    pub fn reach_end(&mut self) {
        self.data.holes.ended = true;
    }

    /// Whether bytes that come have a place.
    pub(super) fn has_place(&self) -> bool {
        !self.data.holes.is_full()
    }

    /// How many bytes the object still has, where that is known.
    pub fn rest(&self) -> Option<u64> {
        let size = u64::from(self.data.size_indicated?);
        let placed = !self.data.holes.has_unknown();
        (placed && !self.data.holes.ended).then(|| size.saturating_sub(self.data.size))
    }

    /// The transfer has ended: what is missing of it is settled.
    pub(super) fn settle_holes(&mut self) {
        let whole =
            self.data.holes.ended && self.data.size_indicated.is_some_and(|size| u64::from(size) == self.data.size);
        if self.data.hole && self.data.holes.list.is_empty() && !whole && self.outcome.status != Status::Ok {
            // Something is missing, or came twice, and nothing tells where.
            self.data.holes.list.push(Hole { offset: 0, length: None });
        }
        self.measure();
        let tail = self.trim();
        let incomplete = self.outcome.status == Status::Incomplete;
        let rest = match self.data.holes.ended {
            true => Some(0),
            false => self
                .data
                .size_indicated
                .filter(|_| !self.data.holes.has_unknown())
                .map(|size| u64::from(size).saturating_sub(self.data.size.saturating_add(tail))),
        };
        let behind = rest.map(|rest| rest.saturating_add(tail));
        if self.data.size == 0 && tail == 0 && !self.data.holes.ended {
            // No byte was seen: there is nothing that could have holes.
            self.data.holes.list.clear();
        } else if incomplete && behind != Some(0) {
            self.data.holes.add(self.data.size, behind);
        } else if tail > 0 {
            self.data.holes.add(self.data.size, Some(tail));
        }
    }

    /// Where all but one hole of a whole transfer are measured, its size tells how long that one is. Segments of a block
    /// may come twice, which the capture need not show.
    fn measure(&mut self) {
        let data = &mut self.data;
        let Some(size) = data.size_indicated.map(u64::from).filter(|size| *size >= data.size) else { return };
        let mut unknown = data.holes.list.iter().enumerate().filter(|(_, hole)| hole.length.is_none());
        let (Some((place, hole)), None) = (unknown.next(), unknown.next()) else { return };
        if !data.holes.ended || self.mode != Mode::Segmented || data.holes.is_full() {
            return;
        }
        let (offset, length) = (hole.offset, size - data.size);
        if length > LONGEST {
            return;
        }
        data.size = size;
        if length == 0 {
            data.holes.list.remove(place);
            return;
        }
        for (number, hole) in data.holes.list.iter_mut().enumerate().skip(place) {
            match number == place {
                true => hole.length = Some(length),
                false => hole.offset = hole.offset.saturating_add(length),
            }
        }
        if let Some(at) = usize::try_from(offset).ok().filter(|at| *at <= data.kept.len()) {
            let behind = data.kept.split_off(at);
            let end = usize::try_from(size).unwrap_or(KEPT).min(KEPT);
            data.kept.resize(at.saturating_add(usize::try_from(length).unwrap_or(KEPT)).min(end), 0);
            data.kept.extend(behind.into_iter().take(end.saturating_sub(data.kept.len())));
        }
    }

    /// The data end with the last byte that was seen. Returns how many are missing behind it.
    fn trim(&mut self) -> u64 {
        let data = &mut self.data;
        let behind = data.holes.list.pop_if(|hole| hole.length.is_some_and(|length| hole.offset + length == data.size));
        let Some(Hole { offset, length: Some(length) }) = behind else { return 0 };
        data.size = offset;
        data.kept.truncate(usize::try_from(offset).unwrap_or(KEPT));
        length
    }
}
