//! The contents of a file, counted without knowledge of any protocol.
//!
//! Only figures are kept, in bounded memory.

use crate::bytes::frame::{Direction, Frame, Kind, MAX_BUSES, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::listing::LeftOut;
use crate::bytes::readers::{Damage, FilePlace, Item, Marker, Unreadable};
use crate::bytes::span::Span;

/// Maximum number of listed damages; further ones are only counted.
const LISTED: usize = 64;
/// Lower limit of absolute stamps, in ns (1973); smaller ones count from some start.
const DATED_NS: Ns = Ns::from_s(100000000);

/// The figures of one file.
#[derive(Debug, Default)]
pub struct Info {
    /// Frames of each bus, by bus index.
    pub buses: Vec<u64>,
    /// All frames.
    pub frames: u64,
    /// Classic data frames.
    pub data: u64,
    /// Remote frames.
    pub remote: u64,
    /// CAN FD frames.
    pub fd: u64,
    /// Error frames.
    pub error: u64,
    /// Data, remote and FD frames with 11-bit identifiers.
    pub standard: u64,
    /// Data, remote and FD frames with 29-bit identifiers.
    pub extended: u64,
    /// Received frames.
    pub rx: u64,
    /// Frames sent by the capturing host.
    pub tx: u64,
    /// Frames without a stamp.
    pub unstamped: u64,
    /// The stamps in file order.
    pub span: Span,
    /// Fewest and most digits after the decimal point.
    pub decimals: Option<(u8, u8)>,
    /// The date from which the stamps count, if the file has one, in ns.
    pub date_ns: Option<Ns>,
    /// True if the stamps are written as dates.
    pub calendar: bool,
    /// Stamps out of range, clamped to its end.
    pub clamped_stamps: u64,
    /// Unreadable lines or records.
    pub unreadable: u64,
    /// Unreadable ones on buses beyond the maximum number.
    pub of_further_buses: u64,
    /// The first unreadable one.
    pub first_unreadable: Option<FilePlace>,
    /// Number of reports by the capturing program of lost frames.
    pub gaps: u64,
    /// Number of lost frames in these reports.
    pub dropped: u64,
    /// Rows that the file itself shows to be left out.
    pub left_out: LeftOut,
    /// Error markers without content.
    pub error_markers: u64,
    /// The first damages.
    pub damage: Vec<Damage>,
    /// Number of all damages.
    pub damages: u64,
}

/// The time zone of a date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zone {
    /// Coordinated universal time.
    Utc,
    /// Civil time at the place of recording, in an unknown zone.
    Local,
}

impl Info {
    /// Counts an item of the reader.
    pub fn take(&mut self, item: &Item) {
        match item {
            Item::Frame(frame) => self.frame(frame),
            Item::Unreadable { place, reason } => {
                self.unreadable += 1;
                self.of_further_buses += u64::from(*reason == Unreadable::Bus);
                self.first_unreadable.get_or_insert(*place);
            }
            Item::Damaged(damage) => {
                self.damages += 1;
                if self.damage.len() < LISTED {
                    self.damage.push(*damage);
                }
            }
            Item::Marker(Marker::Start { date_ns }) => _ = self.date_ns.get_or_insert(*date_ns),
            Item::Marker(Marker::Dropped { count, .. }) => {
                self.gaps += 1;
                self.dropped = self.dropped.saturating_add(*count);
            }
            Item::Marker(Marker::LeftOut { count, .. }) => self.left_out.add(*count),
            Item::Marker(Marker::Error { .. }) => self.error_markers += 1,
            Item::Marker(Marker::Backward { .. } | Marker::Swapped) | Item::Gap { .. } | Item::Until { .. } => {}
        }
    }

    fn frame(&mut self, frame: &Frame) {
        self.frames += 1;
        let bus = usize::from(frame.bus.0).min(MAX_BUSES);
        if self.buses.len() <= bus {
            self.buses.resize(bus + 1, 0);
        }
        if let Some(count) = self.buses.get_mut(bus) {
            *count += 1;
        }
        *match frame.kind {
            Kind::Data => &mut self.data,
            Kind::Remote => &mut self.remote,
            Kind::Fd { .. } => &mut self.fd,
            Kind::Error => &mut self.error,
        } += 1;
        if frame.kind != Kind::Error {
            *if frame.id.is_extended() { &mut self.extended } else { &mut self.standard } += 1;
        }
        match frame.dir {
            Some(Direction::Rx) => self.rx += 1,
            Some(Direction::Tx) => self.tx += 1,
            None => {}
        }
        self.clamped_stamps += u64::from(frame.is_clamped());
        let (Some(t_ns), Some(stamp)) = (frame.t_ns, frame.stamp) else {
            self.unstamped += 1;
            return;
        };
        self.calendar |= stamp.form == StampForm::Calendar;
        let (fewest, most) = self.decimals.unwrap_or((stamp.decimals, stamp.decimals));
        self.decimals = Some((fewest.min(stamp.decimals), most.max(stamp.decimals)));
        self.span.take(t_ns);
    }

    /// Returns the dates of the first and the last frame in ns since 1970-01-01, if the file gives them.
    pub fn dates(&self) -> Option<(Ns, Ns, Zone)> {
        let (first, last) = self.span.ends_ns?;
        match self.date_ns {
            Some(date) => Some((first + date, last + date, Zone::Local)),
            None if self.calendar => Some((first, last, Zone::Local)),
            None => (first >= DATED_NS).then_some((first, last, Zone::Utc)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::frame::{BusId, CanId, Stamp};

    fn at(t_ns: Ns, kind: Kind, bus: u8) -> Item {
        let stamp = Stamp { form: StampForm::Seconds, ns: t_ns, width: 1, decimals: 6 };
        let frame = Frame::classic(CanId::standard(0x601), &[0; 8]);
        Item::Frame(Frame { t_ns: Some(t_ns), stamp: Some(stamp), kind, bus: BusId(bus), ..frame })
    }

    #[test]
    fn figures() {
        let mut info = Info::default();
        for item in
            [at(Ns(5), Kind::Data, 0), at(Ns(9), Kind::Remote, 2), at(Ns(7), Kind::Error, 0), at(Ns(11), Kind::Data, 0)]
        {
            info.take(&item);
        }
        assert_eq!((info.frames, info.data, info.remote, info.error, info.standard), (4, 2, 1, 1, 3));
        assert_eq!((info.buses.as_slice(), info.span.ends_ns), (&[3, 0, 1][..], Some((Ns(5), Ns(11)))));
        assert_eq!((info.span.backward, info.span.backward_most_ns, info.decimals), (1, Ns(2), Some((6, 6))));
        assert_eq!(info.dates(), None);
        info.take(&Item::Marker(Marker::Start { date_ns: Ns(1000) }));
        assert_eq!(info.dates(), Some((Ns(1005), Ns(1011), Zone::Local)));
    }
}
