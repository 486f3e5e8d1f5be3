//! When two items of two captures are the same, or the same thing with another content, as a number to compare. It must
//! not know where they stand.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::course::Deed;
use crate::services::sdo::transfer::{Direction, Status};

/// A number for everything that is to be the same; without the value, or the size, where these vary.
pub(super) fn symbol(deed: &Deed, varies: bool, resizes: bool) -> u64 {
    let mut hasher = DefaultHasher::new();
    match deed {
        Deed::Transfer(moved) => {
            (1, moved.direction == Direction::Upload, moved.mux).hash(&mut hasher);
            (moved.mode.name(), moved.status.name()).hash(&mut hasher);
            moved.abort.map(|abort| (abort.code, abort.by)).hash(&mut hasher);
            // How far an aborted transfer came is no outcome.
            if moved.status == Status::Ok {
                (!varies).then_some(moved.digest).hash(&mut hasher);
                (!resizes).then_some(moved.size).hash(&mut hasher);
            }
        }
        Deed::Nmt(command) => (2, command).hash(&mut hasher),
        Deed::BootUp => 3.hash(&mut hasher),
        Deed::State(state) => (4, state).hash(&mut hasher),
        Deed::Drive(state) => (5, state).hash(&mut hasher),
        Deed::Emcy(code, register) => (6, code, register).hash(&mut hasher),
        Deed::Lss(bytes) => (7, bytes).hash(&mut hasher),
    }
    hasher.finish()
}

/// A number for what may be the same thing with another content.
pub(super) fn likeness(deed: &Deed) -> u64 {
    let mut hasher = DefaultHasher::new();
    match deed {
        Deed::Transfer(moved) => (1, moved.direction == Direction::Upload, moved.mux).hash(&mut hasher),
        Deed::Nmt(_) => 2.hash(&mut hasher),
        Deed::BootUp => 3.hash(&mut hasher),
        Deed::State(_) => 4.hash(&mut hasher),
        Deed::Drive(_) => 5.hash(&mut hasher),
        Deed::Emcy(..) => 6.hash(&mut hasher),
        Deed::Lss(bytes) => (7, bytes.first()).hash(&mut hasher),
    }
    hasher.finish()
}
