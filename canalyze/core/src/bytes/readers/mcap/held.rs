//! A frame that waits for earlier ones, at a quarter of its size, since a chunk has tens of thousands of them. Only
//! fields that this reader sets are kept.

use crate::bytes::frame::{BusId, CanId, Direction, Frame, Kind, LengthForm, Stamp, StampForm};
use crate::bytes::ns::Ns;

/// A frame with its time in ns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Held {
    pub(super) t_ns: i64,
    pub(super) id: CanId,
    pub(super) bus: BusId,
    pub(super) kind: Kind,
    pub(super) dir: Option<Direction>,
    len: u8,
    raw_dlc: u8,
    /// True if another frame replaces it, so that it is not emitted.
    pub(super) gone: bool,
    data: Data,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Data {
    Short([u8; 8]),
    Long(Box<[u8; 64]>),
}

impl Held {
    /// Keeps a frame with this time.
    #[inline(always)]
    pub(super) fn new(t_ns: i64, frame: &Frame) -> Self {
        let data = if frame.len > 8 { Data::Long(Box::new(frame.data)) } else { Data::Short(frame.head()) };
        let Frame { id, bus, kind, dir, len, length_form: LengthForm { raw_dlc, .. }, .. } = *frame;
        Self { t_ns, id, bus, kind, dir, len, raw_dlc, gone: false, data }
    }

    /// Keeps a classic data frame; bytes from its length on are 0.
    #[inline(always)]
    pub(super) fn classic(t_ns: i64, id: CanId, bus: BusId, dir: Option<Direction>, len: u8, data: [u8; 8]) -> Self {
        Self { t_ns, id, bus, kind: Kind::Data, dir, len, raw_dlc: 0, gone: false, data: Data::Short(data) }
    }

    /// Returns true if both are equal on the wire and on the same bus.
    pub(super) fn same(&self, other: &Self) -> bool {
        self.id == other.id
            && (self.bus, self.kind, self.len) == (other.bus, other.kind, other.len)
            && self.data == other.data
    }

    /// Returns the frame.
    #[inline(always)]
    pub(super) fn frame(self) -> Frame {
        let mut data = [0; 64];
        match self.data {
            Data::Short(short) => {
                if let Some(head) = data.first_chunk_mut::<8>() {
                    *head = short;
                }
            }
            Data::Long(long) => data = *long,
        }
        Frame {
            no: 0,
            moved: 0,
            corrected_ns: 0,
            line: None,
            t_ns: Some(Ns(self.t_ns)),
            stamp: Some(Stamp { form: StampForm::Seconds, ns: Ns(self.t_ns), width: 1, decimals: 9 }),
            bus: self.bus,
            id: self.id,
            kind: self.kind,
            dir: self.dir,
            len: self.len,
            length_form: LengthForm { raw_dlc: self.raw_dlc, ..LengthForm::default() },
            data,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_comes_out_as_it_went_in() {
        let mut long = Frame::classic(CanId::extended(0x1ABC), &[]);
        (long.kind, long.len, long.data) = (Kind::Fd { brs: true, esi: false }, 64, [7; 64]);
        let mut short = Frame::classic(CanId::standard(0x181), &[1, 2, 3, 4, 5, 6, 7, 8]);
        (short.dir, short.bus, short.length_form.raw_dlc) = (Some(Direction::Tx), BusId(3), 12);
        for mut frame in [long, short] {
            frame.t_ns = Some(Ns(5));
            frame.stamp = Some(Stamp { form: StampForm::Seconds, ns: Ns(5), width: 1, decimals: 9 });
            assert_eq!(format!("{:?}", Held::new(5, &frame).frame()), format!("{frame:?}"));
        }
    }

    #[test]
    fn it_is_small() {
        assert!(size_of::<Held>() <= 40, "{}", size_of::<Held>());
    }
}
