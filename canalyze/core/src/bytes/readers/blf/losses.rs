//! Lost parts of a file, joined where nothing sound is between them: one wrong size may lead to many more.

use super::Blf;
use crate::bytes::frame::Buses;
use crate::bytes::readers::{Damage, DamageKind, FilePlace, Item};

/// Takes the items of a file.
pub(super) struct Out<'a, S: FnMut(Item, &Buses)> {
    pub(super) buses: &'a mut Buses,
    pub(super) sink: &'a mut S,
}

impl<S: FnMut(Item, &Buses)> Out<'_, S> {
    pub(super) fn item(&mut self, item: Item) {
        (self.sink)(item, self.buses);
    }
}

/// A part that cannot be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loss {
    pub(super) kind: DamageKind,
    /// Its offset in the file; parts of a packed container all have its offset.
    pub(super) at: u64,
    /// Number of lost bytes, if known.
    pub(super) size: Option<u64>,
}

impl Loss {
    /// Returns both as one; `None` if something may be between them.
    fn joined(self, after: Self) -> Option<Self> {
        let (size, more) = (self.size?, after.size?);
        let apart = after.at != self.at && after.at != self.at.saturating_add(size);
        let other = after.kind != DamageKind::Structure && after.kind != self.kind;
        let cut = [self.kind, after.kind].contains(&DamageKind::Cut);
        (!apart && !other && !cut).then_some(Self { size: Some(size.saturating_add(more)), ..self })
    }
}

impl Blf {
    /// Takes a lost part.
    pub(super) fn damaged<S: FnMut(Item, &Buses)>(&mut self, loss: Loss, out: &mut Out<'_, S>) {
        if self.interrupted && loss.kind == DamageKind::Cut {
            return;
        }
        if let Some(joined) = self.pending.and_then(|before| before.joined(loss)) {
            self.pending = Some(joined);
            return;
        }
        self.sound(out);
        self.damaged = true;
        self.pending = Some(loss);
    }

    /// Takes something sound: what was lost before it is complete.
    pub(super) fn sound<S: FnMut(Item, &Buses)>(&mut self, out: &mut Out<'_, S>) {
        if let Some(Loss { kind, at, size }) = self.pending.take() {
            out.item(Item::Damaged(Damage { place: FilePlace::Byte(at), kind, bytes: size, frames: None }));
        }
    }

    /// Takes what was lost before the next object.
    pub(super) fn tell<S: FnMut(Item, &Buses)>(&mut self, out: &mut Out<'_, S>) {
        for loss in std::mem::take(&mut self.losses) {
            self.damaged(loss, out);
        }
    }
}
