//! Vector's binary log (BLF): a header, then objects, most of them containers of compressed objects.
//!
//! | file | purpose |
//! |---|---|
//! | `mod` | the header, the objects of the file, and what becomes of a container |
//! | `walk` | the objects within a container, which run on from one container to the next |
//! | `head` | the head of an object, and the search for one |
//! | `frame` | the frame in an object |
//! | `losses` | lost parts, joined where nothing sound is between them |
//!
//! An object has 16 bytes (`LOBJ`, size of its header, version of the header, its size, its type), then flags and a
//! stamp. No size is trusted: an object is believed if the next one begins where it ends, since damage may begin in the
//! one before it; behind damage reading goes on with the next head. A container that cannot be unpacked is passed over
//! as a whole.

use crate::bytes::ns::Ns;

mod frame;
mod head;
mod losses;
#[cfg(test)]
mod tests;
mod walk;

use std::cmp::Ordering;
use std::collections::BTreeMap;

use flate2::{Decompress, FlushDecompress, Status};

use self::head::{HEAD, ObjectHead, SIGN, is_padding, next_container, next_head};
use self::losses::{Loss, Out};
use super::{Contents, Damage, DamageKind, FilePlace, Item, Marker};
use crate::bytes::calendar;
use crate::bytes::frame::Buses;

/// Size of the fields of the file's header that are read, in bytes.
const FILE: usize = 72;
/// Size of the file's header where its own is impossible, in bytes.
const USUAL: usize = 144;
/// Maximum size of the file's header, in bytes.
const LARGEST_HEADER: usize = 4096;
/// Place and size of the date of the start in the file's header, in bytes.
const DATE_AT: usize = 40;
const DATE_SIZE: usize = 16;
/// Place of the number of objects in the file's header, in bytes.
const COUNT_AT: usize = 32;
/// The type of objects that are not counted.
const RESTORE_POINT: u32 = 115;
/// The type of a container.
const CONTAINER: u32 = 10;
/// Size of a container's head, and of the shortest head of another object, in bytes.
const BEHIND: usize = 32;
/// Maximum size of a container, packed or unpacked, in bytes; writers make them of 128 KiB, or a few MiB.
const MOST: usize = 64 << 20;
/// Bytes of a piece of unpacked data.
const PIECE: usize = 1 << 16;
/// Maximum number of separately counted kinds of other objects.
const KINDS: usize = 64;

/// The reader of one file.
#[derive(Debug, Default)]
pub struct Blf {
    /// Bytes that are not consumed, from `gone` on.
    buffer: Vec<u8>,
    gone: usize,
    /// Number of bytes of the file before `gone`.
    at: u64,
    /// Behind damage: the next head is looked for.
    searching: bool,
    /// The file's header has been read.
    begun: bool,
    /// The application that wrote the file, by its number.
    application: u8,
    /// The size of the file by its header, in bytes.
    size: u64,
    /// Number of its objects by its header; 0 if the header does not tell.
    count: u64,
    /// Number of objects with a frame so far.
    objects: u64,
    /// The reading was broken off, so the end is no fault of the file.
    interrupted: bool,
    /// A damage has been reported.
    damaged: bool,
    /// Size of the object before the buffer, which its padding follows.
    before: usize,
    /// An object whose end is in the next container, and the place where it, or its container, begins.
    tail: Vec<u8>,
    tail_at: u64,
    /// Size of the object before it.
    inner_before: usize,
    /// All stamps so far are of 10 µs.
    fine: bool,
    /// The end of the file, within an object, has been reported.
    cut: bool,
    losses: Vec<Loss>,
    pending: Option<Loss>,
    /// The buses by the channels of the file, in the order of their first frames.
    channels: Vec<u16>,
    passed_over: BTreeMap<String, u64>,
}

impl Blf {
    /// Feeds the next bytes, in any chunking.
    pub fn feed(&mut self, bytes: &[u8], buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.buffer.extend_from_slice(bytes);
        let out = &mut Out { buses, sink };
        self.objects(false, out);
        self.buffer.drain(..self.gone);
        self.gone = 0;
    }

    /// Ends the file.
    pub fn finish(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.end(true, buses, sink);
    }

    /// Ends an interrupted file, whose incomplete end is no fault of its own.
    pub fn interrupt(&mut self, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        self.end(false, buses, sink);
    }

    /// Returns application and channels, and the counts of other objects.
    pub fn contents(&self) -> Contents {
        let mut dialect = Vec::new();
        if self.begun {
            dialect.push(("application", self.application.to_string().into_bytes()));
        }
        if !self.channels.is_empty() {
            let named = |channel: &u16| format!("{channel} = {}", String::from_utf8_lossy(&frame::bus(*channel)));
            let all: Vec<String> = self.channels.iter().map(named).collect();
            dialect.push(("channels", all.join(", ").into_bytes()));
        }
        let passed_over = self.passed_over.iter().map(|(kind, count)| (kind.clone().into_bytes(), *count)).collect();
        Contents { dialect, passed_over, topics: Vec::new() }
    }

    /// Counts an object that is no frame.
    fn pass_over(&mut self, kind: u32) {
        if kind == RESTORE_POINT {
            return;
        }
        let name = match kind {
            3 => "CAN_OVERLOAD".to_owned(),
            4 => "CAN_STATISTIC".to_owned(),
            5 => "APP_TRIGGER".to_owned(),
            65 => "APP_TEXT".to_owned(),
            96 => "GLOBAL_MARKER".to_owned(),
            _ => format!("object type {kind}"),
        };
        let known = self.passed_over.len() < KINDS || self.passed_over.contains_key(&name);
        *self.passed_over.entry(if known { name } else { "...".to_owned() }).or_default() += 1;
    }

    fn rest(&self) -> &[u8] {
        self.buffer.get(self.gone..).unwrap_or_default()
    }

    /// Consumes bytes; returns their number.
    fn take(&mut self, size: usize) -> usize {
        let taken = size.min(self.rest().len());
        self.gone += taken;
        self.at += taken as u64;
        taken
    }

    /// Reads the file's header; returns false while it is incomplete.
    fn header<S: FnMut(Item, &Buses)>(&mut self, out: &mut Out<'_, S>) -> bool {
        let rest = self.rest();
        let Some(fields) = rest.first_chunk::<FILE>() else { return false };
        let own = head::u32_at(fields, 4) as usize;
        let size = if (FILE..=LARGEST_HEADER).contains(&own) { own } else { USUAL };
        if rest.len() < size {
            return false;
        }
        let (application, whole) = (fields.get(8).copied().unwrap_or(0), head::u64_at(fields, 16));
        let count = head::u32_at(fields, COUNT_AT).into();
        let date: [i64; 8] = std::array::from_fn(|place| i64::from(head::u16_at(fields, DATE_AT + 2 * place)));
        (self.begun, self.application, self.size, self.count) = (true, application, whole, count);
        self.take(size);
        match date_ns(date) {
            Some(date_ns) => out.item(Item::Marker(Marker::Start { date_ns: Ns(date_ns) })),
            None if date != [0; 8] => {
                let at = DATE_AT as u64;
                self.damaged(Loss { kind: DamageKind::Structure, at, size: Some(DATE_SIZE as u64) }, out);
            }
            None => {}
        }
        true
    }

    /// Takes the complete objects of the buffer; `ended`: nothing follows.
    fn objects<S: FnMut(Item, &Buses)>(&mut self, ended: bool, out: &mut Out<'_, S>) {
        if !self.begun && !self.header(out) {
            return;
        }
        while self.rest().len() >= HEAD {
            let rest = self.rest();
            if self.searching {
                let following = next_head(rest, 0, rest.len());
                // The beginning of a head may be at the end.
                let kept = if ended { 0 } else { HEAD - 1 };
                self.lose(following.unwrap_or(rest.len() - kept), DamageKind::Structure);
                self.searching = following.is_none();
                if self.searching {
                    return;
                }
                continue;
            }
            match head::sign_near(rest, 0) {
                Some(gap) if is_padding(rest.get(..gap).unwrap_or_default(), self.before) => {
                    self.take(gap);
                }
                _ => {
                    self.searching = true;
                    continue;
                }
            }
            let rest = self.rest();
            let Some(head) = ObjectHead::read(rest, 0) else { return };
            if !(BEHIND..=MOST).contains(&head.size) || head.kind != CONTAINER && head.header < BEHIND {
                self.lose(SIGN.len(), DamageKind::Structure);
                continue;
            }
            if rest.len() < head.size + BEHIND && !ended {
                return;
            }
            self.before = head.size;
            self.object(head, out);
        }
    }

    /// Takes the object at the buffer's beginning, which the end of the file may cut.
    fn object<S: FnMut(Item, &Buses)>(&mut self, head: ObjectHead, out: &mut Out<'_, S>) {
        let (at, rest, size) = (self.at, self.rest(), head.size);
        let there = rest.len();
        let cut = there < size;
        let following = if cut { next_head(rest, SIGN.len(), there) } else { None };
        if head.kind != CONTAINER || there < BEHIND {
            let inner = if cut || self.is_followed(size) { None } else { next_head(rest, SIGN.len(), size + HEAD) };
            return match (inner, following) {
                // The next one begins in it: its size is wrong, or bytes of it are gone.
                (Some(inner), _) if inner < size => self.lose(inner, DamageKind::Structure),
                _ if !cut => self.bare(at, size, out),
                (_, None) => self.end_here(there),
                (_, Some(following)) => self.lose(following, DamageKind::Structure),
            };
        }
        let held = rest.get(BEHIND..size.min(there)).unwrap_or_default();
        let mut short = false;
        match head::u16_at(rest, HEAD) {
            0 => {
                let further = next_container(rest, BEHIND, size + BEHIND).filter(|further| *further < size);
                short = further.is_some();
                let held = held.get(..further.map_or(held.len(), |further| further - BEHIND)).unwrap_or(held).to_vec();
                self.take(BEHIND + held.len());
                self.tell(out);
                let followed = self.is_followed(0);
                self.walk(held, (at + BEHIND as u64, true), followed, out);
            }
            2 => match unpacked(held) {
                Some((data, used)) if used.is_some() || cut && following.is_none() => {
                    self.take(used.map_or(size, |used| BEHIND + used));
                    self.tell(out);
                    self.walk(data, (at, false), true, out);
                }
                _ => return self.lose(following.unwrap_or(size), DamageKind::Compression),
            },
            _ => return self.lose(following.unwrap_or(size), DamageKind::Structure),
        }
        if cut && !short && self.rest().is_empty() {
            self.tail = Vec::new();
            self.cut = true;
            self.damaged(Loss { kind: DamageKind::Cut, at, size: None }, out);
        } else if cut || short {
            // All of it is read, but its size is wrong.
            self.damaged(Loss { kind: DamageKind::Structure, at, size: Some(0) }, out);
        }
    }

    /// Takes an object that is in no container.
    fn bare<S: FnMut(Item, &Buses)>(&mut self, at: u64, size: usize, out: &mut Out<'_, S>) {
        self.tell(out);
        let tail = std::mem::take(&mut self.tail);
        let whole = self.rest().get(..size).unwrap_or_default().to_vec();
        self.take(size);
        let followed = self.is_followed(0);
        self.walk(whole, (at, true), followed, out);
        if !self.tail.is_empty() {
            let size = Some(self.tail.len() as u64);
            self.damaged(Loss { kind: DamageKind::Structure, at: self.tail_at, size }, out);
        }
        self.tail = tail;
    }

    /// Returns true if an object begins at a place of the buffer, or the buffer ends there, so that what is before it
    /// ends where it should.
    fn is_followed(&self, at: usize) -> bool {
        let rest = self.rest();
        if let Some(gap) = head::sign_near(rest, at) {
            return is_padding(rest.get(at..at + gap).unwrap_or_default(), self.before);
        }
        let near = rest.get(at..).unwrap_or_default();
        let near = near.get(..head::NEAR).unwrap_or(near);
        let begin = near.iter().position(|byte| *byte != 0).unwrap_or(near.len());
        near.len() < head::NEAR && SIGN.starts_with(near.get(begin..).unwrap_or_default())
    }

    /// Passes bytes over, and with them what was to go on there.
    fn lose(&mut self, size: usize, kind: DamageKind) {
        let tail = std::mem::take(&mut self.tail);
        if !tail.is_empty() {
            let size = Some(tail.len() as u64);
            self.losses.push(Loss { kind: DamageKind::Structure, at: self.tail_at, size });
        }
        let at = self.at;
        let taken = self.take(size);
        if taken > 0 {
            self.losses.push(Loss { kind, at, size: Some(taken as u64) });
        }
    }

    /// Passes over the object that the end of the file cuts.
    fn end_here(&mut self, there: usize) {
        let tail = std::mem::take(&mut self.tail);
        let at = if tail.is_empty() { self.at } else { self.tail_at };
        let taken = self.take(there);
        self.losses.push(Loss { kind: DamageKind::Cut, at, size: Some((tail.len() + taken) as u64) });
        self.cut = true;
    }

    fn end(&mut self, whole: bool, buses: &mut Buses, sink: &mut impl FnMut(Item, &Buses)) {
        let out = &mut Out { buses, sink };
        self.interrupted = !whole;
        self.objects(true, out);
        self.tell(out);
        let (at, rest) = (self.at, self.rest());
        let (there, some) = (rest.len(), rest.iter().any(|byte| *byte != 0));
        let tail = std::mem::take(&mut self.tail);
        let cut = |at, size| Some(Loss { kind: DamageKind::Cut, at, size });
        let last = if self.cut {
            None
        } else if !self.begun || there > 0 && some {
            cut(if tail.is_empty() { at } else { self.tail_at }, Some((tail.len() + there) as u64))
        } else if tail.iter().any(|byte| *byte != 0) {
            cut(self.tail_at, Some(tail.len() as u64))
        } else if there > head::PADDING {
            Some(Loss { kind: DamageKind::Structure, at, size: Some(there as u64) })
        } else if at + (there as u64) < self.size {
            cut(at + there as u64, None)
        } else {
            None
        };
        if let Some(loss) = last {
            self.damaged(loss, out);
        }
        self.sound(out);
        self.compare_count(out);
        self.buffer = Vec::new();
        self.gone = 0;
    }

    /// Compares the number of objects with that of the file's header. Of which other objects it counts is not certain.
    fn compare_count<S: FnMut(Item, &Buses)>(&self, out: &mut Out<'_, S>) {
        if self.damaged || self.interrupted || self.count == 0 || !self.passed_over.is_empty() {
            return;
        }
        let (kind, frames) = match self.count.cmp(&self.objects) {
            Ordering::Less => (DamageKind::Excess, self.objects - self.count),
            Ordering::Equal => return,
            Ordering::Greater => (DamageKind::Missing, self.count - self.objects),
        };
        out.item(Item::Damaged(Damage { place: FilePlace::Byte(0), kind, bytes: None, frames: Some(frames) }));
    }
}

/// Unpacks a container: its data, and the number of bytes consumed if its end was reached. `None` if it is damaged.
fn unpacked(held: &[u8]) -> Option<(Vec<u8>, Option<usize>)> {
    let (mut unpacker, mut data) = (Decompress::new(true), Vec::new());
    loop {
        let used = usize::try_from(unpacker.total_in()).ok()?;
        if data.len() >= MOST {
            return Some((data, None));
        }
        data.reserve(PIECE);
        let before = unpacker.total_out();
        let status =
            unpacker.decompress_vec(held.get(used..).unwrap_or_default(), &mut data, FlushDecompress::None).ok()?;
        let now = usize::try_from(unpacker.total_in()).ok()?;
        match status {
            Status::StreamEnd => return Some((data, Some(now))),
            _ if now == used && unpacker.total_out() == before => return Some((data, None)),
            Status::Ok | Status::BufError => {}
        }
    }
}

/// Returns the date of year, month, weekday, day, hour, minute, second and millisecond, in ns since 1970 as if it were
/// UTC; `None` if there is no such date.
fn date_ns([year, month, _, day, hour, minute, second, millisecond]: [i64; 8]) -> Option<i64> {
    let date = (1..=9999).contains(&year) && (1..=12).contains(&month);
    let valid = date && (1..=calendar::days_of(year, month)).contains(&day) && hour < 24 && minute < 60 && second < 60;
    let days = valid.then(|| calendar::days_to(year, month, day))?;
    let seconds = days * 86_400 + hour * 3600 + minute * 60 + second;
    seconds.checked_mul(1_000_000_000)?.checked_add(millisecond.min(999) * 1_000_000)
}
