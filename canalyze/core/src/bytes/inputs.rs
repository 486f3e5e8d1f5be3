//! The files of a capture that are open together, each with its reader and its queue of items.
//!
//! A file read alone yields its items at once. Several files are joined by time: the earliest frame at the head of a
//! queue comes next, of equal ones that of the file named first, and nothing comes while an unfinished file has an
//! empty queue. Memory therefore holds at most the items of one piece of each file. The order within a file never
//! changes.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::bytes::frame::{BusId, Buses, Frame, FrameRef, StampForm};
use crate::bytes::ns::Ns;
use crate::bytes::readers::{Contents, Damage, DamageKind, FilePlace, Item, Marker, Reader, Unreadable as Reason};

/// Maximum number of listed ranges of unreadable lines of a file.
const RANGES: usize = 20;
/// Lower limit of absolute stamps, in ns, as in filters; smaller ones count from some start.
pub const ABSOLUTE_NS: Ns = Ns::from_s(100000000);

/// The figures of one file.
#[derive(Debug, Default)]
pub struct File {
    /// Its name.
    pub name: Arc<[u8]>,
    /// Number of its frames so far.
    pub frames: u64,
    /// Time from the date that the capture's stamps count from to the one that this file's stamps count from, in ns.
    pub shift_ns: Ns,
    /// True if it gives the date from which its stamps count.
    pub dated: bool,
    /// Its unreadable lines or records.
    pub unreadable: Unreadable,
    /// Unreadable ones on buses beyond the maximum number.
    pub of_further_buses: u64,
    /// Frames with stamps out of the range of an `i64` of nanoseconds.
    pub beyond: u64,
    /// Number of damaged places so far.
    pub damages: u64,
    /// The last frame but one and the last one of each bus, by bus index.
    pub last: Vec<[Option<FrameRef>; 2]>,
    /// True if its stamps turned out to have another meaning than assumed, and this has been reported.
    pub misread: bool,
}

/// Unreadable lines of a file (in a file without lines, offsets of records).
#[derive(Debug, Default)]
pub struct Unreadable {
    /// Number of lines.
    pub count: u64,
    /// The first one.
    pub first: Option<FilePlace>,
    /// The first ranges.
    pub ranges: Vec<(u64, u64)>,
}

impl File {
    /// Returns the number of its frames so far, including those skipped for their bus.
    pub fn found(&self) -> u64 {
        self.frames + self.of_further_buses
    }
}

impl Unreadable {
    /// Counts a place.
    pub fn add(&mut self, place: FilePlace) {
        self.first.get_or_insert(place);
        self.count += 1;
        let (FilePlace::Line(line) | FilePlace::Byte(line)) = place else { return };
        let room = self.ranges.len() < RANGES;
        match self.ranges.last_mut() {
            Some((_, to)) if *to + 1 == line => *to = line,
            _ if room => self.ranges.push((line, line)),
            _ => {}
        }
    }
}

/// The reason that files cannot be joined by time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The frames of this file have no stamps.
    NoStamps(usize),
    /// The stamps of the first file are times of day, those of the second count from an unknown start.
    NoCommonClock(usize, usize),
}

/// The origin of a file's stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StampOrigin {
    Absent,
    Start,
    Day,
}

/// One open file.
#[derive(Debug)]
pub struct Input {
    /// Its reader; `None` after the end of the file.
    pub reader: Option<Reader>,
    /// Its figures, while another file has its turn.
    pub file: File,
    /// The contents that its reader knows at the end.
    pub contents: Contents,
    /// Damage of the byte stream, reported after the last item.
    pub damage: Option<Damage>,
    /// The part covered by the last check sum, if the bytes have check sums.
    covered: Option<Covered>,
    /// Its own bus indexes, while it is joined with others.
    buses: Buses,
    queue: VecDeque<Item>,
    /// Number of frames found in it.
    pub frames: u64,
    clock: Option<StampOrigin>,
    date_ns: Option<Ns>,
    /// True after its end has been returned.
    closed: bool,
}

/// The part of a file that one check sum covers.
#[derive(Clone, Copy, Debug)]
struct Covered {
    /// Its first line.
    line: u64,
    /// Number of newlines since the beginning of the first such part of the file.
    newlines: u64,
    /// Number of its frames.
    frames: u64,
}

impl Input {
    fn new(name: &[u8], reader: Reader) -> Self {
        Self {
            reader: Some(reader),
            file: File { name: name.into(), ..File::default() },
            contents: Contents::default(),
            damage: None,
            covered: None,
            buses: Buses::default(),
            queue: VecDeque::new(),
            frames: 0,
            clock: None,
            date_ns: None,
            closed: false,
        }
    }

    fn take(&mut self, item: Item) {
        self.counts(&item);
        match &item {
            Item::Frame(frame) => {
                self.frames += 1;
                if self.clock.is_none() {
                    self.clock = Some(clock(frame, self.date_ns));
                    self.queue.extend(self.date_ns.map(|date_ns| Item::Marker(Marker::Start { date_ns })));
                }
            }
            Item::Unreadable { reason: Reason::Bus, .. } => self.frames += 1,
            // Only the last one before the first frame counts; it is returned together with that frame.
            Item::Marker(Marker::Start { date_ns }) if self.clock.is_none() => {
                self.date_ns = Some(*date_ns);
                return;
            }
            _ => {}
        }
        self.queue.push_back(item);
    }

    /// Feeds the next bytes of the file.
    fn feed(&mut self, bytes: &[u8]) {
        let Some(mut reader) = self.reader.take() else { return };
        self.feeds(bytes);
        let mut buses = std::mem::take(&mut self.buses);
        reader.feed(bytes, &mut buses, &mut |item, _| self.take(*item));
        (self.buses, self.reader) = (buses, Some(reader));
    }

    /// Ends the file.
    fn end(&mut self, interrupted: bool) {
        let Some(mut reader) = self.reader.take() else { return };
        let mut buses = std::mem::take(&mut self.buses);
        if interrupted || self.damage.is_some() {
            reader.interrupt(&mut buses, &mut |item, _| self.take(*item));
        } else {
            reader.finish(&mut buses, &mut |item, _| self.take(*item));
        }
        let damage = self.told();
        self.queue.extend(damage.map(Item::Damaged));
        (self.buses, self.contents) = (buses, reader.contents());
    }

    /// Begins a part under another check sum with the next bytes.
    pub fn covers(&mut self) {
        let newlines = self.covered.map_or(0, |covered| covered.newlines);
        self.covered = Some(Covered { line: newlines + 1, newlines, frames: 0 });
    }

    /// Counts the newlines of bytes that are covered by a check sum.
    pub fn feeds(&mut self, bytes: &[u8]) {
        if let Some(covered) = &mut self.covered {
            covered.newlines += memchr::memchr_iter(b'\n', bytes).count() as u64;
        }
    }

    /// Counts a frame covered by the last check sum. A reader may lag behind its bytes; the line, if any, shows that.
    pub fn counts(&mut self, item: &Item) {
        if let (Some(covered), Item::Frame(frame)) = (&mut self.covered, item) {
            covered.frames += u64::from(frame.line.is_none_or(|line| line >= covered.line));
        }
    }

    /// Takes the damage of the byte stream; doubtful damage includes the number of frames.
    pub fn told(&mut self) -> Option<Damage> {
        let frames = self.covered.map(|covered| covered.frames);
        let damage = self.damage.take()?;
        Some(if damage.kind == DamageKind::Doubtful { Damage { frames, ..damage } } else { damage })
    }

    /// Removes the item at the head of the queue and converts its bus to the common index.
    fn pop(&mut self, buses: &mut Buses) -> Option<Item> {
        let mut item = self.queue.pop_front()?;
        match &mut item {
            Item::Frame(Frame { bus, .. })
            | Item::Gap { bus, .. }
            | Item::Marker(Marker::Dropped { bus, .. } | Marker::Error { bus, .. }) => {
                *bus = common(*bus, &self.buses, buses);
            }
            _ => {}
        }
        item.refuse_further_bus();
        Some(item)
    }
}

fn common(bus: BusId, own: &Buses, all: &mut Buses) -> BusId {
    all.intern(own.name(bus))
}

fn clock(frame: &Frame, date_ns: Option<Ns>) -> StampOrigin {
    match (frame.t_ns, frame.stamp.map(|stamp| stamp.form)) {
        (None, _) => StampOrigin::Absent,
        (Some(_), Some(StampForm::Calendar)) => StampOrigin::Day,
        (Some(t_ns), _) if t_ns >= ABSOLUTE_NS || date_ns.is_some() => StampOrigin::Day,
        _ => StampOrigin::Start,
    }
}

/// The next step of joined files.
#[derive(Clone, Copy, Debug)]
pub enum Next {
    /// An item of a file, by its index.
    Item(usize, Item),
    /// The end of a file, by its index.
    End(usize),
}

/// The files that are open.
#[derive(Debug, Default)]
pub struct Inputs {
    all: Vec<Input>,
    /// True once every file has shown the origin of its stamps.
    begun: bool,
    refusal: Option<Refusal>,
}

impl Inputs {
    /// Opens another file. `first` closes all earlier ones.
    pub fn open(&mut self, first: bool, name: &[u8], reader: Reader) {
        if first {
            *self = Self::default();
        }
        self.all.push(Input::new(name, reader));
    }

    /// Returns an input by its index.
    pub fn get(&mut self, input: usize) -> Option<&mut Input> {
        self.all.get_mut(input)
    }

    /// Returns the input if it is the only one.
    pub fn alone(&mut self) -> Option<&mut Input> {
        if let [only] = self.all.as_mut_slice() { Some(only) } else { None }
    }

    /// Returns true if the only one has rows that wait until later ones show their layout.
    pub fn holds(&self) -> bool {
        matches!(self.all.as_slice(), [only] if only.reader.as_ref().is_some_and(Reader::holds))
    }

    /// Returns the number of files, including finished ones.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Feeds the next bytes of one of several files.
    pub fn feed(&mut self, input: usize, bytes: &[u8]) {
        if let Some(one) = self.all.get_mut(input) {
            one.feed(bytes);
        }
    }

    /// Ends one of several files.
    pub fn end(&mut self, input: usize, interrupted: bool) {
        if let Some(one) = self.all.get_mut(input) {
            one.end(interrupted);
        }
    }

    /// Returns the file whose bytes are needed next; `None` if all are finished or cannot be joined.
    pub fn wants(&self) -> Option<usize> {
        if self.refusal.is_some() {
            return None;
        }
        let needy =
            |one: &Input| one.reader.is_some() && if self.begun { one.queue.is_empty() } else { one.clock.is_none() };
        self.all.iter().position(needy)
    }

    /// Returns the reason that the files cannot be joined.
    pub fn refusal(&self) -> Option<Refusal> {
        self.refusal
    }

    /// Returns the next item or end of a file; `None` if a file has to be fed first or nothing is left. `date_ns` is
    /// the date from which all stamps count, set before the first frame; `turn` is the index and figures of the current
    /// file.
    pub fn next(&mut self, buses: &mut Buses, date_ns: &mut Option<Ns>, turn: (usize, &File)) -> Option<Next> {
        if self.refusal.is_some() {
            return None;
        }
        if !self.begun {
            // Items before the first frame of a file are returned at once, since keeping them would need unbounded
            // memory.
            for (index, one) in self.all.iter_mut().enumerate() {
                let waits =
                    matches!(one.queue.front(), None | Some(Item::Frame(_) | Item::Marker(Marker::Start { .. })));
                if !waits {
                    return Some(Next::Item(index, one.pop(buses)?));
                }
            }
            if self.all.iter().any(|one| one.clock.is_none() && one.reader.is_some()) {
                return None;
            }
            self.begin(date_ns);
            if self.refusal.is_some() {
                return None;
            }
        }
        let mut earliest: Option<(usize, Ns)> = None;
        let mut missing = false;
        for (index, one) in self.all.iter_mut().enumerate() {
            match one.queue.front() {
                Some(Item::Frame(frame)) => {
                    let file = if turn.0 == index { turn.1 } else { &one.file };
                    // A frame without a stamp among stamped ones keeps its place in the file.
                    let t_ns = frame.t_ns.map_or(Ns::MIN, |t_ns| t_ns + file.shift_ns);
                    if earliest.is_none_or(|(_, before)| t_ns < before) {
                        earliest = Some((index, t_ns));
                    }
                }
                Some(_) => return Some(Next::Item(index, one.pop(buses)?)),
                None if one.reader.is_some() => missing = true,
                None if !one.closed => {
                    one.closed = true;
                    return Some(Next::End(index));
                }
                None => {}
            }
        }
        let (index, _) = earliest.filter(|_| !missing)?;
        let item = self.all.get_mut(index)?.pop(buses)?;
        Some(Next::Item(index, item))
    }

    /// Determines the clock that all files share.
    fn begin(&mut self, date_ns: &mut Option<Ns>) {
        self.begun = true;
        let of = |clock| self.all.iter().position(|one| one.clock == Some(clock));
        self.refusal = match (of(StampOrigin::Absent), of(StampOrigin::Day), of(StampOrigin::Start)) {
            (Some(input), _, _) => Some(Refusal::NoStamps(input)),
            (None, Some(day), Some(start)) => Some(Refusal::NoCommonClock(day, start)),
            _ => None,
        };
        let dates = self.all.iter().filter(|one| one.clock.is_some()).map(|one| one.date_ns);
        if date_ns.is_none() && dates.clone().any(|date| date.is_some()) {
            // If other stamps are plain times of day, stamps with a date are converted to such.
            *date_ns = dates.map(|date| date.unwrap_or(Ns::ZERO)).min();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::bytes::frame::{CanId, Stamp};
    use crate::bytes::readers::{InputFormat, Settings};

    fn frame(t_ns: Option<Ns>, bus: u8) -> Item {
        let stamp = t_ns.map(|ns| Stamp { form: StampForm::Seconds, ns, width: 1, decimals: 9 });
        Item::Frame(Frame { t_ns, stamp, bus: BusId(bus), ..Frame::classic(CanId::standard(0x701), &[5]) })
    }

    fn start(date_ns: Ns) -> Item {
        Item::Marker(Marker::Start { date_ns })
    }

    fn opened(files: &[&[Item]]) -> Inputs {
        let mut inputs = Inputs::default();
        for (no, items) in files.iter().enumerate() {
            inputs.open(no == 0, b"x", Reader::new(InputFormat::Candump, &Settings::default()));
            let input = inputs.get(no).unwrap();
            input.buses.intern(format!("bus{no}").as_bytes());
            for item in *items {
                input.take(*item);
            }
        }
        inputs
    }

    /// Collects the file and absolute time of all frames.
    fn joined(inputs: &mut Inputs, date_ns: &mut Option<Ns>) -> Vec<(usize, i64)> {
        let (mut buses, mut file, mut turn) = (Buses::default(), File::default(), 0);
        let mut found = Vec::new();
        while let Some(next) = inputs.next(&mut buses, date_ns, (turn, &file)) {
            let (Next::Item(input, _) | Next::End(input)) = next;
            for other in [turn, input] {
                std::mem::swap(&mut inputs.get(other).unwrap().file, &mut file);
            }
            turn = input;
            match next {
                Next::Item(_, Item::Frame(frame)) => {
                    found.push((input, (frame.t_ns.unwrap_or(Ns::ZERO) + file.shift_ns).as_ns()))
                }
                Next::Item(_, Item::Marker(Marker::Start { date_ns: date })) => file.shift_ns = date - date_ns.unwrap(),
                _ => {}
            }
        }
        found
    }

    fn end_all(inputs: &mut Inputs) {
        for input in 0..inputs.count() {
            inputs.end(input, false);
        }
    }

    #[test]
    fn nothing_comes_while_a_file_has_nothing_to_give() {
        let mut inputs = opened(&[&[frame(Some(Ns(1)), 0), frame(Some(Ns(4)), 0)], &[frame(Some(Ns(2)), 0)]]);
        let mut date = None;
        assert_eq!(joined(&mut inputs, &mut date), [(0, 1), (1, 2)]);
        assert_eq!(inputs.wants(), Some(1));
        inputs.end(1, false);
        assert_eq!(joined(&mut inputs, &mut date), [(0, 4)]);
        assert_eq!(inputs.wants(), Some(0));
        inputs.end(0, false);
        assert_eq!(joined(&mut inputs, &mut date), []);
        assert_eq!((inputs.wants(), date), (None, None));
    }

    #[test]
    fn dates_make_one_clock() {
        const DAY: i64 = 1_700_000_000_000_000_000;
        // Both have dates: stamps count from the earlier one.
        let mut inputs = opened(&[
            &[start(Ns(DAY + 10)), frame(Some(Ns::ZERO), 0), frame(Some(Ns(7)), 0)],
            &[start(Ns(DAY)), frame(Some(Ns(12)), 0)],
        ]);
        end_all(&mut inputs);
        let mut date = None;
        assert_eq!(joined(&mut inputs, &mut date), [(0, 10), (1, 12), (0, 17)]);
        assert_eq!(date, Some(Ns(DAY)));
        // One has a date, the other is absolute: all become absolute. A second date within a file applies from there
        // on.
        let late = [start(Ns(DAY + 10)), frame(Some(Ns::ZERO), 0), start(Ns(DAY + 100)), frame(Some(Ns(1)), 0)];
        let mut inputs = opened(&[&late, &[frame(Some(Ns(DAY + 50)), 0)]]);
        end_all(&mut inputs);
        let mut date = None;
        assert_eq!(joined(&mut inputs, &mut date), [(0, DAY + 10), (1, DAY + 50), (0, DAY + 101)]);
        assert_eq!(date, Some(Ns(0)));
    }

    #[test]
    fn clocks_that_are_not_shared_are_refused() {
        const DAY: i64 = 1_700_000_000_000_000_000;
        for (files, refusal) in [
            ([frame(Some(Ns(DAY)), 0), frame(Some(Ns(1)), 0)], Refusal::NoCommonClock(0, 1)),
            ([frame(Some(Ns(1)), 0), frame(Some(Ns(DAY)), 0)], Refusal::NoCommonClock(1, 0)),
            ([frame(Some(Ns(1)), 0), frame(None, 0)], Refusal::NoStamps(1)),
        ] {
            let mut inputs = opened(&[&files[..1], &files[1..]]);
            assert_eq!(joined(&mut inputs, &mut None), []);
            assert_eq!((inputs.refusal(), inputs.wants()), (Some(refusal), None));
        }
    }

    #[test]
    fn buses_are_numbered_in_the_order_of_what_is_given() {
        let mut inputs = opened(&[&[frame(Some(Ns(5)), 0)], &[frame(Some(Ns(3)), 0)]]);
        end_all(&mut inputs);
        let mut buses = Buses::default();
        let file = File::default();
        while inputs.next(&mut buses, &mut None, (0, &file)).is_some() {}
        assert_eq!(buses.names().collect::<Vec<_>>(), [b"bus1", b"bus0"]);
    }

    #[test]
    fn what_comes_before_any_frame_is_not_kept() {
        let unreadable =
            Item::Unreadable { place: FilePlace::Line(1), reason: crate::bytes::readers::Unreadable::NoFrame };
        let mut inputs = opened(&[&[], &[unreadable; 100]]);
        assert_eq!(joined(&mut inputs, &mut None), []);
        assert!(inputs.get(1).unwrap().queue.is_empty());
        assert_eq!(inputs.wants(), Some(0));
    }
}
