//! Vector's ASC log, as read by Vector's programs, python-can and asc2log.
//!
//! Stamps count from a date in whole milliseconds, as the header requires. A frame before that date begins a block with
//! an earlier one. Content without a column is written in comment lines that this program's reader understands
//! (`readers::asc::notes`). No line may read as a different frame in another program.

use super::{CaptureFacts, Loss, Losses};
use crate::bytes::calendar::date_of;
use crate::bytes::frame::{BusId, CanId, Direction, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::bytes::readers::Marker;
use crate::bytes::readers::asc::notes::Note;
use crate::bytes::readers::asc::{AscChannel, fd_code};
use crate::words::digits::{Hex, Padded, Spaced, filled, fraction, hex, put};

const SECOND: i64 = 1_000_000_000;
const MILLISECOND: Ns = Ns::from_ms(1);
/// Lower limit of times that are dates, in ns (1973); others count from the start of the capture, unless it has a date.
const UNDATED: Ns = Ns::from_s(100_000_000);

/// A writer of ASC logs.
#[derive(Debug)]
pub struct Asc {
    /// The losses.
    pub losses: Losses,
    /// The time from which the stamps count; `None` before the header.
    origin: Option<Ns>,
    /// True if the dates are not real.
    undated: bool,
    /// The last written time.
    last: Ns,
    frames: i64,
    /// The channels of buses.
    channels: Vec<(BusId, AscChannel)>,
    directions: bool,
    stamps: bool,
    /// Comments from before the header.
    held: Vec<u8>,
}

impl Default for Asc {
    fn default() -> Self {
        Self {
            losses: Losses::default(),
            origin: None,
            undated: false,
            last: Ns::ZERO,
            frames: 0,
            channels: Vec::new(),
            directions: true,
            stamps: true,
            held: Vec::new(),
        }
    }
}

impl Asc {
    /// Appends a frame's line, and the lines that have to precede it.
    pub fn frame(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, frame: &Frame) {
        let known = setting.moment(frame);
        let moment = known.unwrap_or_else(|| {
            self.losses.count(Loss::NoStamp);
            if self.frames == 0 { Ns::ZERO } else { self.last + MILLISECOND }
        });
        self.frames += 1;
        self.last = moment;
        let origin = self.begin(out, setting, moment);
        if self.stamps != known.is_some() {
            self.stamps = known.is_some();
            Note::Stamps(self.stamps).write(out);
        }
        let channel = self.channel(out, setting, frame.bus);
        if frame.kind == Kind::Error {
            self.error(out, frame);
        } else {
            self.direction(out, frame.dir);
        }
        stamp(out, moment - origin, frame.stamp.map_or(6, |stamp| stamp.decimals));
        match frame.kind {
            Kind::Error => {
                put!(out; channel, "  ErrorFrame");
            }
            Kind::Fd { brs, esi } => fd(out, channel, frame, brs, esi),
            Kind::Data | Kind::Remote => classic(out, channel, frame),
        }
        out.push(b'\n');
    }

    /// Appends a comment with the content of an error frame that its line cannot hold.
    fn error(&mut self, out: &mut Vec<u8>, frame: &Frame) {
        if frame.dir.is_some() {
            self.losses.count(Loss::Direction);
        }
        if frame.id.raw() != 0 {
            self.losses.count(Loss::ErrorDetails);
        }
        if frame.id.raw() != 0 || frame.len > 0 {
            Note::Error(frame.id, frame.payload().get(..8).unwrap_or(frame.payload()).to_vec()).write(out);
        }
    }

    fn direction(&mut self, out: &mut Vec<u8>, dir: Option<Direction>) {
        if dir.is_none() {
            self.losses.count(Loss::UnknownDirection);
        }
        if self.directions != dir.is_some() {
            self.directions = dir.is_some();
            Note::Directions(self.directions).write(out);
        }
    }

    /// Appends a gap as a comment line; other markers have none.
    pub fn marker(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, marker: &Marker) {
        match *marker {
            Marker::Dropped { bus, count, total, .. } => {
                let mut held = std::mem::take(&mut self.held);
                let place = if self.origin.is_some() { out } else { &mut held };
                let channel = self.channel(place, setting, bus);
                Note::Dropped(count, channel, total).write(place);
                self.held = held;
            }
            Marker::Error { .. } => self.losses.count(Loss::ErrorFrame),
            Marker::LeftOut { count, .. } => {
                Note::LeftOut(count).write(if self.origin.is_some() { out } else { &mut self.held });
            }
            Marker::Start { .. } | Marker::Backward { .. } | Marker::Swapped => {}
        }
    }

    /// Appends the end of the block, and the header if there was no frame.
    pub fn finish(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>) {
        if self.origin.is_none() {
            self.begin(out, setting, setting.date_ns.unwrap_or_default());
        }
        out.extend_from_slice(b"End TriggerBlock\n");
    }

    /// Appends the header before the first frame, or a block before a frame earlier than all previous ones. Returns the
    /// time from which the stamps count.
    fn begin(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, moment: Ns) -> Ns {
        match self.origin {
            Some(origin) if moment >= origin => return origin,
            Some(_) => out.extend_from_slice(b"End TriggerBlock\n"),
            None => {}
        }
        let first = self.origin.is_none();
        let mut origin = MILLISECOND * moment.as_ns().div_euclid(MILLISECOND.as_ns());
        if first {
            self.undated = setting.date_ns.is_none() && (-UNDATED..UNDATED).contains(&moment);
            if self.undated {
                self.losses.count(Loss::NoDate);
                origin = origin.min(Ns::ZERO);
            }
            out.extend_from_slice(b"date ");
            date(out, origin);
            out.extend_from_slice(b"\nbase hex  timestamps absolute\nno internal events logged\n");
            if self.undated {
                Note::NoDate.write(out);
            }
            out.append(&mut self.held);
        }
        out.extend_from_slice(b"Begin Triggerblock ");
        date(out, origin);
        out.push(b'\n');
        if first {
            out.extend_from_slice(b"   0.000000 Start of measurement\n");
        }
        self.origin = Some(origin);
        origin
    }

    /// Returns the channel of a bus: n + 1 for `can{n}` if that is free, otherwise the first free one. Appends a
    /// comment with the name of the bus if the number does not show it.
    fn channel(&mut self, out: &mut Vec<u8>, setting: CaptureFacts<'_>, bus: BusId) -> AscChannel {
        if let Some((_, channel)) = self.channels.iter().find(|(known, _)| *known == bus) {
            return *channel;
        }
        let name = setting.buses.name(bus);
        let free = |channel: &AscChannel| self.channels.iter().all(|(_, taken)| taken != channel);
        let own = numbered(name);
        let channel = own.filter(free).or_else(|| (1..=AscChannel::MAX).find(free)).unwrap_or(AscChannel::MAX);
        self.channels.push((bus, channel));
        if own != Some(channel) && !name.is_empty() {
            Note::Channel(channel, name.to_vec()).write(out);
        }
        channel
    }
}

/// Returns the channel that other programs show as this bus.
fn numbered(name: &[u8]) -> Option<AscChannel> {
    let digits = name.strip_prefix(b"can")?;
    let number: AscChannel = std::str::from_utf8(digits).ok()?.parse().ok().filter(|number| *number < 255)?;
    // `can007` and `can+7` are other names.
    (digits.len() == number.to_string().len()).then_some(number + 1)
}

/// Appends `1  601             Rx   d 8 40 08 10 00 00 00 00 00`.
fn classic(out: &mut Vec<u8>, channel: AscChannel, frame: &Frame) {
    put!(out; channel, "  ");
    let start = out.len();
    identifier(out, frame.id);
    while out.len() < start + 15 {
        out.push(b' ');
    }
    out.extend_from_slice(if frame.dir == Some(Direction::Tx) { b" Tx   " } else { b" Rx   " });
    let code = if frame.length_form.raw_dlc > 8 { frame.length_form.raw_dlc } else { frame.len.min(8) };
    put!(out; if frame.kind == Kind::Remote { "r " } else { "d " }, Hex::<1>(u64::from(code)));
    bytes(out, frame.payload());
}

/// Appends `CANFD   1 Rx        601                                    1 0 9 12 00 .. 00        0    0     3000 ..`;
/// except for the flags, the columns after the data are unknown.
fn fd(out: &mut Vec<u8>, channel: AscChannel, frame: &Frame, brs: bool, esi: bool) {
    out.extend_from_slice(b"CANFD ");
    filled(out, u64::from(channel), 3, b' ');
    out.extend_from_slice(if frame.dir == Some(Direction::Tx) { b" Tx   " } else { b" Rx   " });
    // Right-aligned in nine columns, including the `x`; then the width of a symbolic name.
    let width = digits_of(frame.id);
    out.extend(std::iter::repeat_n(b' ', 8 - width.min(8)));
    identifier(out, frame.id);
    out.extend(std::iter::repeat_n(b' ', if frame.id.is_extended() { 34 } else { 35 }));
    out.extend_from_slice(if brs { b"1 " } else { b"0 " });
    out.extend_from_slice(if esi { b"1 " } else { b"0 " });
    put!(out; Hex::<1>(fd_code(u64::from(frame.len))), " ");
    filled(out, u64::from(frame.len), 2, b' ');
    bytes(out, frame.payload());
    let flags = 0x1000 | u64::from(brs) << 13 | u64::from(esi) << 14;
    put!(out; "        0    0     ", Hex::<4>(flags), "        0        0        0        0        0");
}

fn digits_of(id: CanId) -> usize {
    (1..8).find(|digits| id.raw() >> (4 * digits) == 0).unwrap_or(8)
}

fn identifier(out: &mut Vec<u8>, id: CanId) {
    hex(out, u64::from(id.raw()), digits_of(id));
    if id.is_extended() {
        out.push(b'x');
    }
}

fn bytes(out: &mut Vec<u8>, payload: &[u8]) {
    if !payload.is_empty() {
        put!(out; " ", Spaced(payload));
    }
}

/// Appends `   0.000000 `: seconds in four columns, six or nine decimals.
fn stamp(out: &mut Vec<u8>, time: Ns, decimals: u8) {
    let ns = time.as_ns();
    filled(out, ns.div_euclid(SECOND).unsigned_abs(), 4, b' ');
    let rest = ns.rem_euclid(SECOND) as u32;
    // Times of joined files may be finer than their stamps.
    fraction(out, rest, if decimals > 6 || !rest.is_multiple_of(1000) { 9 } else { 6 });
    out.push(b' ');
}

/// Appends `Thu Apr 28 10:44:52.480 am 2022`.
fn date(out: &mut Vec<u8>, moment: Ns) {
    let ns = moment.as_ns();
    const WEEKDAYS: [&str; 7] = ["Thu", "Fri", "Sat", "Sun", "Mon", "Tue", "Wed"];
    const MONTHS: [&str; 12] = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let days = ns.div_euclid(86_400 * SECOND);
    let time = ns.rem_euclid(86_400 * SECOND).unsigned_abs() / 1_000_000;
    let (year, month, day) = date_of(days);
    let (hour, minute, second) = (time / 3_600_000, time / 60_000 % 60, time / 1000 % 60);
    let name = |names: &[&'static str], index: i64| names.get(index as usize).copied().unwrap_or_default();
    put!(out; name(&WEEKDAYS, days.rem_euclid(7)), " ", name(&MONTHS, month - 1), " ", day.unsigned_abs(), " ");
    put!(out; Padded::<2>((hour + 11) % 12 + 1), ":", Padded::<2>(minute), ":", Padded::<2>(second));
    put!(out; ".", Padded::<3>(time % 1000), if hour < 12 { " am " } else { " pm " }, Padded::<4>(year.unsigned_abs()));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

    use crate::bytes::ns::Ns;
    use proptest::prelude::*;

    use super::super::{CaptureFacts, Format, Loss, Writer};
    use crate::bytes::frame::{BusId, Buses, CanId, Direction, Frame, Kind, Stamp, StampForm};
    use crate::bytes::readers::{FilePlace, InputFormat as Input, Item, Marker, Reader, Settings};

    const DATE: i64 = 1_549_455_524_265_601_000;

    fn at(t_ns: i64, decimals: u8, frame: Frame) -> Frame {
        let stamp = Stamp { form: StampForm::Seconds, ns: Ns(t_ns), width: 1, decimals };
        Frame { t_ns: Some(Ns(t_ns)), stamp: Some(stamp), ..frame }
    }

    fn write(frames: &[Frame], markers: &[Marker], buses: &Buses, date_ns: Option<i64>) -> (String, Writer) {
        let setting = CaptureFacts { buses, date_ns: date_ns.map(Ns) };
        let mut writer = Writer::new(Format::Asc, &Default::default());
        let mut out = Vec::new();
        for marker in markers {
            writer.marker(&mut out, setting, marker);
        }
        for frame in frames {
            writer.frame(&mut out, setting, frame);
        }
        writer.finish(&mut out, setting);
        (String::from_utf8(out).unwrap(), writer)
    }

    #[test]
    fn the_lines() {
        let mut buses = Buses::default();
        let (second, vcan0) = (buses.intern(b"can1"), buses.intern(b"vcan0"));
        let data = Frame { dir: Some(Direction::Tx), ..Frame::classic(CanId::standard(0x601), &[0x40, 0, 8]) };
        let mut fd = Frame { kind: Kind::Fd { brs: true, esi: false }, len: 12, bus: vcan0, ..data };
        fd.id = CanId::extended(0x50005);
        let remote = Frame { kind: Kind::Remote, len: 8, data: [0; 64], dir: Some(Direction::Rx), ..data };
        let mut raw = Frame { dir: None, ..Frame::classic(CanId::standard(5), &[1; 8]) };
        raw.length_form.raw_dlc = 13;
        let error = Frame { kind: Kind::Error, dir: None, ..Frame::classic(CanId::extended(0x88), &[0, 1]) };
        let frames = [
            at(DATE, 6, Frame { bus: second, ..data }),
            at(DATE + 1000, 9, fd),
            at(DATE + 2_000_000, 6, Frame { bus: second, ..remote }),
            at(DATE + 3_000_000, 6, Frame { bus: second, ..raw }),
            at(DATE + 4_000_000, 6, Frame { bus: second, ..error }),
            at(DATE - 5_000_000_000, 6, Frame { bus: second, ..data }),
        ];
        let gap = Marker::Dropped { bus: second, count: 3, total: 5, place: FilePlace::Line(1) };
        let (text, writer) = write(&frames, &[gap], &buses, None);
        let date = "Wed Feb 6 12:18:44.265 pm 2019";
        assert_eq!(
            text,
            format!(
                "date {date}
base hex  timestamps absolute
no internal events logged
// canalyze: dropped 3 on channel 2, 5 in total
Begin Triggerblock {date}
   0.000000 Start of measurement
   0.000601 2  601             Tx   d 3 40 00 08
// canalyze: channel 1 is vcan0
   0.000602000 CANFD   1 Tx      50005x                                  1 0 9 12 40 00 08 00 00 00 00 00 00 00 00 00        0    0     3000        0        0        0        0        0
   0.002601 2  601             Rx   r 8
// canalyze: directions unknown
   0.003601 2  5               Rx   d D 01 01 01 01 01 01 01 01
// canalyze: error 00000088 00 01
   0.004601 2  ErrorFrame
End TriggerBlock
Begin Triggerblock Wed Feb 6 12:18:39.265 pm 2019
// canalyze: directions known
   0.000601 2  601             Tx   d 3 40 00 08
End TriggerBlock
"
            )
        );
        let losses: Vec<_> = writer.losses().iter().collect();
        assert_eq!(losses, [(Loss::UnknownDirection, 1), (Loss::ErrorDetails, 1)]);
    }

    #[test]
    fn stamps_without_a_date() {
        let mut buses = Buses::default();
        buses.intern(b"can0");
        let frame = Frame { dir: Some(Direction::Rx), ..Frame::classic(CanId::standard(0x80), &[]) };
        let (text, writer) = write(&[at(1_500_000_000, 3, frame), frame], &[], &buses, None);
        assert_eq!(
            text,
            "date Thu Jan 1 12:00:00.000 am 1970
base hex  timestamps absolute
no internal events logged
// canalyze: no date
Begin Triggerblock Thu Jan 1 12:00:00.000 am 1970
   0.000000 Start of measurement
   1.500000 1  80              Rx   d 0
// canalyze: stamps unknown
   1.501000 1  80              Rx   d 0
End TriggerBlock
"
        );
        assert_eq!(writer.losses().iter().collect::<Vec<_>>(), [(Loss::NoStamp, 1), (Loss::NoDate, 1)]);
        let (text, _) = write(&[], &[], &buses, Some(DATE));
        assert!(text.starts_with("date Wed Feb 6 12:18:44.265 pm 2019\n") && text.ends_with("End TriggerBlock\n"));
    }

    /// The content of a frame, regardless of the form in which it was written.
    type Essence = (Option<i64>, Vec<u8>, CanId, Kind, Option<Direction>, u8, u8, [u8; 64]);

    fn essence(frame: &Frame, buses: &Buses, date_ns: Option<i64>) -> Essence {
        let moment = CaptureFacts { buses, date_ns: date_ns.map(Ns) }.moment(frame);
        let raw = frame.length_form.raw_dlc;
        (
            moment.map(Ns::as_ns),
            buses.name(frame.bus).to_vec(),
            frame.id,
            frame.kind,
            frame.dir,
            frame.len,
            raw,
            frame.data,
        )
    }

    fn read(text: &str) -> Vec<Essence> {
        let mut buses = Buses::default();
        let mut found = Vec::new();
        let mut date = None;
        let mut reader = Reader::new(Input::Asc, &Settings::default());
        let mut sink = |item: &mut Item, buses: &Buses| match *item {
            Item::Frame(frame) => found.push(essence(&frame, buses, date)),
            Item::Marker(Marker::Start { date_ns }) => date = Some(date_ns.as_ns()),
            other => panic!("{other:?}"),
        };
        reader.feed(text.as_bytes(), &mut buses, &mut sink);
        reader.finish(&mut buses, &mut sink);
        found
    }

    fn any_frame() -> impl Strategy<Value = Frame> {
        let id = prop_oneof![
            (0u16..0x800).prop_map(CanId::standard),
            (0u32..0x2000_0000).prop_map(CanId::extended),
            Just(CanId::extended(0)),
        ];
        let dir = prop::sample::select(vec![None, Some(Direction::Rx), Some(Direction::Tx)]);
        let data = prop::collection::vec(any::<u8>(), 64);
        (0..4u8, id, dir, 0..=64u8, 0..=15u8, data, any::<(bool, bool)>(), 0..4u8).prop_map(
            |(kind, id, dir, len, raw, bytes, (brs, esi), bus)| {
                let mut frame = Frame { id, dir, bus: BusId(bus), ..Frame::classic(id, &[]) };
                frame.len = if kind == 2 { len } else { len.min(8) };
                frame.kind = [Kind::Data, Kind::Remote, Kind::Fd { brs, esi }, Kind::Error][usize::from(kind)];
                if kind < 2 && frame.len == 8 && raw > 8 {
                    frame.length_form.raw_dlc = raw;
                }
                if frame.kind == Kind::Error {
                    frame.id = CanId::extended(id.raw());
                    frame.dir = None;
                }
                if frame.kind != Kind::Remote {
                    let len = usize::from(frame.len);
                    frame.data[..len].copy_from_slice(&bytes[..len]);
                }
                frame
            },
        )
    }

    proptest! {
        // Nothing is lost between this writer and this reader, including content without a column.
        #[test]
        fn what_is_written_is_read(
            frames in prop::collection::vec((any_frame(), prop::option::weighted(0.95, -3_000_000_000i64..9_000_000_000), 0..=9u8), 0..20),
            origin in prop::sample::select(vec![0, DATE, -DATE]),
            date in prop::option::of(0i64..2_000_000_000_000_000_000),
            names in prop::collection::vec("(can[0-5]|vcan0|can 9%|can01|)", 4),
        ) {
            let mut buses = Buses::default();
            let known: Vec<BusId> = names.iter().map(|name| buses.intern(name.as_bytes())).collect();
            let unnamed = names.iter().any(String::is_empty);
            let frames: Vec<Frame> = frames
                .into_iter()
                .map(|(frame, t, decimals)| {
                    let frame = Frame { bus: known[usize::from(frame.bus.0)], ..frame };
                    match t {
                        Some(t) => at(if date.is_some() { t } else { t + origin }, decimals, frame),
                        None => frame,
                    }
                })
                .collect();
            let (text, _) = write(&frames, &[], &buses, date);
            let back = read(&text);
            prop_assert_eq!(back.len(), frames.len());
            for (mut back, frame) in back.into_iter().zip(&frames) {
                let expected = essence(frame, &buses, date);
                if unnamed {
                    back.1 = expected.1.clone();
                }
                prop_assert_eq!(back, expected, "{}", text);
            }
        }
    }
}
