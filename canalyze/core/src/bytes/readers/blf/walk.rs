//! The objects within a container. They run on from one container to the next.

use super::frame::{self, FileFacts};
use super::head::{HEAD, NEAR, ObjectHead, SIGN, is_padding, next_head, partial_head, sign_near};
use super::losses::{Loss, Out};
use super::{Blf, DamageKind};
use crate::bytes::frame::{Buses, Frame};
use crate::bytes::readers::Item;

/// Size of the fields before an object's stamp, in bytes.
const FLAGGED: usize = 20;
/// Maximum size of an object in a container, in bytes.
const MOST: usize = 8 << 20;
/// Types of objects are below this, with some room for later versions of the format.
const KINDS: u32 = 160;
/// No object with a frame is as long as this, in bytes.
const LONG: usize = 4096;

/// The last object, which is believed once the next one begins where it ends.
#[allow(clippy::large_enum_variant, reason = "there is one for each container")]
enum LastObject {
    /// There is none.
    Missing,
    /// One without a frame.
    Other,
    /// A frame.
    Frame(Frame, u16),
    /// An object of a frame with contradicting fields, with its offset and size.
    Unfit(u64, usize),
}

/// Lost bytes: the place from which, and up to which.
type Wrong = (usize, usize);

/// The data of a container behind the rest of the one before.
struct Inner {
    data: Vec<u8>,
    /// The end of that rest.
    seam: usize,
    tail_at: u64,
    /// The offset of the data in the file, or that of the container that they were packed in.
    at: u64,
    plain: bool,
}

impl Inner {
    /// Returns the offset of a place in the file.
    fn offset(&self, place: usize) -> u64 {
        match place.checked_sub(self.seam) {
            None => self.tail_at,
            Some(behind) if self.plain => self.at + behind as u64,
            Some(_) => self.at,
        }
    }

    /// Returns the place of the next head from a place on, else the end.
    fn following(&self, from: usize) -> usize {
        next_head(&self.data, from, self.data.len()).unwrap_or_else(|| partial_head(&self.data, from))
    }

    /// Judges an object with its head by itself and what follows; `Err(None)`: it goes on in the next container.
    fn judge(&self, found: usize, head: ObjectHead) -> Result<(), Option<Wrong>> {
        let (data, end, ObjectHead { version, size, kind, .. }) = (&self.data, self.data.len(), head);
        let stop = found.saturating_add(size);
        if found < self.seam && self.seam < stop && data.get(self.seam..).is_some_and(|rest| rest.starts_with(SIGN)) {
            // Its end is not in the container behind it.
            return Err(Some((found, self.seam)));
        }
        let sizes = frame::sizes(kind);
        let header = if version == 1 { 32 } else { 40 };
        let (least, most) = sizes.unwrap_or_default();
        let (bare, usual) = (header + least, header + most);
        let unknown = kind == 0 || kind >= KINDS || sizes.is_some() && !matches!(version, 1 | 2);
        if size < bare || size > MOST || unknown {
            return Err(Some((found, self.following(found + SIGN.len()))));
        }
        if size > usual {
            // The head of another object in it: its size is wrong.
            let inner = (found + usual).max(if found < self.seam { self.seam.saturating_sub(HEAD) } else { 0 });
            if let Some(following) = next_head(data, inner, stop.min(end)) {
                return Err(Some((found, following)));
            }
        }
        if stop > end {
            let long = size > LONG && sizes.is_some();
            return Err(long.then(|| (found, self.following(found + SIGN.len()))));
        }
        if sizes.is_some() && size > usual && stop + NEAR <= end && sign_near(data, stop).is_none() {
            let following = next_head(data, found + SIGN.len(), end);
            return following.map_or(Ok(()), |following| Err(Some((found, following))));
        }
        let disguised = sizes.is_none()
            && !frame::is_bare_error(kind)
            && frame::is_disguised(data.get(found..stop).unwrap_or_default(), head);
        if disguised { Err(Some((found, stop))) } else { Ok(()) }
    }
}

impl Blf {
    /// Takes the data of a container. `at`: their offset in the file and true, or that of the container that they were
    /// packed in and false. `followed`: what comes behind the data is what should come there.
    pub(super) fn walk<S: FnMut(Item, &Buses)>(
        &mut self,
        data: Vec<u8>,
        (at, plain): (u64, bool),
        followed: bool,
        out: &mut Out<'_, S>,
    ) {
        if data.is_empty() && !self.tail.is_empty() {
            return;
        }
        let mut whole = std::mem::take(&mut self.tail);
        let seam = whole.len();
        let data = if seam == 0 { data } else { [std::mem::take(&mut whole), data].concat() };
        let inner = Inner { data, seam, tail_at: self.tail_at, at, plain };
        let end = inner.data.len();
        // Behind the last object, and its beginning.
        let (mut position, mut last) = (0, 0);
        let (mut before, mut held) = (self.inner_before, LastObject::Missing);
        loop {
            let gap = sign_near(&inner.data, position);
            let wrong = match gap {
                None if position + NEAR > end => break,
                Some(gap) if is_padding(inner.data.get(position..position + gap).unwrap_or_default(), before) => {
                    let found = position + gap;
                    let Some(head) = ObjectHead::read(&inner.data, found).filter(|_| found + FLAGGED <= end) else {
                        break;
                    };
                    match inner.judge(found, head) {
                        Ok(()) => {
                            self.confirm(std::mem::replace(&mut held, LastObject::Missing), out);
                            let stop = found + head.size;
                            let object = inner.data.get(found..stop).unwrap_or_default();
                            held = self.read(object, head, inner.offset(found), out);
                            (position, last, before) = (stop, found, head.size);
                            continue;
                        }
                        Err(None) => break,
                        Err(Some(wrong)) => wrong,
                    }
                }
                _ => (last, inner.following(position)),
            };
            if wrong.0 != last || matches!(held, LastObject::Missing) {
                self.confirm(held, out);
            }
            held = LastObject::Missing;
            let size = Some((wrong.1 - wrong.0) as u64);
            self.damaged(Loss { kind: DamageKind::Structure, at: inner.offset(wrong.0), size }, out);
            (position, last, before) = (wrong.1, wrong.1, 0);
        }
        self.inner_before = before;
        if !followed && last < end && sign_near(&inner.data, position).is_none() {
            let (at, size) = (inner.offset(last), Some((end - last) as u64));
            return self.damaged(Loss { kind: DamageKind::Structure, at, size }, out);
        }
        let rest = inner.data.get(position..).unwrap_or_default();
        if rest.iter().any(|byte| *byte != 0) || rest.len() > super::head::PADDING {
            (self.tail, self.tail_at) = (rest.to_vec(), inner.offset(position));
        }
        self.confirm(held, out);
    }

    /// Reads an object.
    fn read<S: FnMut(Item, &Buses)>(
        &mut self,
        object: &[u8],
        head: ObjectHead,
        at: u64,
        out: &mut Out<'_, S>,
    ) -> LastObject {
        let error = frame::is_bare_error(head.kind) && matches!(head.version, 1 | 2);
        if frame::sizes(head.kind).is_none() && !error {
            self.pass_over(head.kind);
            return LastObject::Other;
        }
        self.fine |= frame::is_fine(object);
        let source = FileFacts { application: self.application, fine: self.fine };
        match frame::frame(object, head, source, out.buses) {
            Some((frame, channel)) => LastObject::Frame(frame, channel),
            None => LastObject::Unfit(at, head.size),
        }
    }

    /// Takes an object that the next one follows.
    fn confirm<S: FnMut(Item, &Buses)>(&mut self, object: LastObject, out: &mut Out<'_, S>) {
        match object {
            LastObject::Missing => {}
            LastObject::Other => self.sound(out),
            LastObject::Frame(frame, channel) => {
                self.sound(out);
                self.objects += 1;
                if !self.channels.contains(&channel) && self.channels.len() < super::KINDS {
                    self.channels.push(channel);
                }
                out.item(Item::Frame(frame));
            }
            LastObject::Unfit(at, size) => {
                self.damaged(Loss { kind: DamageKind::Structure, at, size: Some(size as u64) }, out);
            }
        }
    }
}
