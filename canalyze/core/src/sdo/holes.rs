//! The parts of a transfer's data that the capture lacks, with place and length.
//!
//! After a hole of known length, data have their true offset. After one of unknown length, the bytes follow those
//! before it, and their offset in the object is unknown. Holes and the last byte are reported by the takers of frames.

use super::transfer::{Hole, Holes, KEPT, MOST_HOLES, Mode, Status, Transfer};

/// The longest hole measured by the object's size, which is only claimed, in bytes.
const LONGEST: u64 = 4096;

impl Transfer {
    /// Marks data missing before the first byte.
    pub fn miss_beginning(&mut self) {
        self.data.holes.add(0, None);
    }

    /// Makes the next byte the first one of the object.
    pub fn begin_with_first(&mut self) {
        self.data.holes = Holes::default();
    }

    /// Marks the next bytes as missing; `None` if their number is unknown.
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

    /// Marks an unknown number of bytes missing before this offset of the seen data.
    pub fn miss_before(&mut self, offset: u64) {
        self.data.hole = true;
        let list = &mut self.data.holes.list;
        let place = list.partition_point(|hole| hole.offset < offset);
        if list.get(place).is_none_or(|hole| hole.offset != offset) && list.len() + 1 < MOST_HOLES {
            list.insert(place, Hole { offset, length: None });
        }
    }

    /// Marks the last byte of the object as placed.
    pub fn reach_end(&mut self) {
        self.data.holes.ended = true;
    }

    /// Returns true if further bytes have a place.
    pub(super) fn has_place(&self) -> bool {
        !self.data.holes.is_full()
    }

    /// Returns the number of remaining bytes of the object if known.
    pub fn rest(&self) -> Option<u64> {
        let size = u64::from(self.data.size_indicated?);
        let placed = !self.data.holes.has_unknown();
        (placed && !self.data.holes.ended).then(|| size.saturating_sub(self.data.size))
    }

    /// Settles the holes of a finished transfer.
    pub fn settle_holes(&mut self) {
        let whole =
            self.data.holes.ended && self.data.size_indicated.is_some_and(|size| u64::from(size) == self.data.size);
        let anywhere = self.data.holes.list.is_empty();
        self.measure();
        if self.data.hole && anywhere && !whole && self.outcome.status != Status::Ok {
            // Something is missing or was repeated in an unknown place.
            self.data.holes.list.push(Hole { offset: 0, length: None });
        }
        let open = self.data.holes.list.pop_if(|hole| hole.length.is_none() && hole.offset == self.data.size).is_some();
        let tail = self.trim();
        let ended = self.data.holes.ended;
        let data = &mut self.data;
        if data.size == 0 && tail == 0 && !ended {
            // Without any byte there are no holes.
            data.holes.list.clear();
            return;
        }
        let placed = !data.holes.has_unknown();
        let size = data.size_indicated.map(u64::from).filter(|_| placed);
        let rest = match size.map(|size| size.saturating_sub(data.size.saturating_add(tail))) {
            _ if ended && !open => Some(0),
            rest => rest,
        };
        let behind = rest.map(|rest| rest.saturating_add(tail));
        if (open || self.outcome.status == Status::Incomplete) && behind != Some(0) {
            data.holes.add(data.size, behind);
        } else if tail > 0 {
            data.holes.add(data.size, Some(tail));
        }
    }

    /// Measures the only hole of unknown length in a complete transfer by its size. Segments of a block may be
    /// repeated, which the capture need not show.
    fn measure(&mut self) {
        let data = &mut self.data;
        let Some(size) = data.size_indicated.map(u64::from).filter(|size| *size >= data.size) else { return };
        if size == data.size && data.holes.ended && self.mode == Mode::Segmented {
            // All bytes are there; the supposed hole was a frame listed late.
            data.holes.list.retain(|hole| hole.length.is_some());
            return;
        }
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

    /// Ends the data at the last seen byte; returns the number of bytes missing after it.
    fn trim(&mut self) -> u64 {
        let data = &mut self.data;
        let behind = data.holes.list.pop_if(|hole| hole.length.is_some_and(|length| hole.offset + length == data.size));
        let Some(Hole { offset, length: Some(length) }) = behind else { return 0 };
        data.size = offset;
        data.kept.truncate(usize::try_from(offset).unwrap_or(KEPT));
        length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::{BusId, FrameRef};
    use crate::sdo::transfer::{Beginning, Direction, TransferId};

    fn segmented(size: Option<u32>) -> Transfer {
        let (id, bus, at) = (TransferId(1), BusId(0), FrameRef::default());
        let beginning = Beginning { id, bus, node: 10, channel: None, extract: true, at };
        let mut transfer = Transfer::new(beginning, Direction::Upload, Mode::Segmented, None);
        transfer.data.size_indicated = size;
        transfer.outcome.status = Status::Incomplete;
        transfer
    }

    fn hole(offset: u64, length: Option<u64>) -> Hole {
        Hole { offset, length }
    }

    #[test]
    fn holes_that_touch_are_one() {
        let mut transfer = segmented(Some(20));
        transfer.append(b"12");
        transfer.miss(Some(7));
        transfer.miss(Some(7));
        transfer.append(b"34");
        transfer.settle_holes();
        assert_eq!(transfer.data.holes.list(), [hole(2, Some(14)), hole(18, Some(2))]);
        assert_eq!(transfer.data.kept, b"12\0\0\0\0\0\0\0\0\0\0\0\0\0\x0034");
        assert_eq!(transfer.data.fresh, b"1234");
    }

    #[test]
    fn one_hole_is_measured_by_the_size() {
        let mut transfer = segmented(Some(9));
        transfer.append(b"12");
        transfer.miss(None);
        transfer.append(b"3");
        transfer.miss(Some(2));
        transfer.append(b"4");
        transfer.reach_end();
        transfer.settle_holes();
        assert_eq!(transfer.data.holes.list(), [hole(2, Some(3)), hole(6, Some(2))]);
        assert_eq!(transfer.data.kept, b"12\0\0\x003\0\x004");
    }

    #[test]
    fn where_all_bytes_are_there_nothing_is_missing() {
        let mut transfer = segmented(Some(3));
        for byte in [b"1", b"2", b"3"] {
            transfer.append(byte);
            transfer.miss(None);
        }
        transfer.reach_end();
        transfer.settle_holes();
        assert_eq!(transfer.data.holes.list(), []);
        assert_eq!(transfer.data.kept, b"123");
    }

    #[test]
    fn a_claimed_size_allocates_nothing() {
        let mut transfer = segmented(Some(u32::MAX));
        transfer.append(b"12");
        transfer.miss(None);
        transfer.append(b"3");
        transfer.reach_end();
        transfer.settle_holes();
        assert_eq!(transfer.data.holes.list(), [hole(2, None)]);
        assert_eq!(transfer.data.kept, b"123");
    }

    #[test]
    fn behind_the_most_holes_no_byte_has_a_place() {
        let mut transfer = segmented(None);
        for _ in 0..2 * MOST_HOLES {
            transfer.append(b"1");
            transfer.miss(Some(1));
        }
        transfer.settle_holes();
        assert_eq!(transfer.data.holes.list().len(), MOST_HOLES);
        assert_eq!(transfer.data.holes.list().last(), Some(&hole(transfer.data.size, None)));
        assert_eq!(transfer.data.size, 2 * MOST_HOLES as u64 - 1);
        assert_eq!(transfer.data.fresh.len(), MOST_HOLES);
    }
}
