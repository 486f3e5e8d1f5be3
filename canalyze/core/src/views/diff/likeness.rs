//! Keys by which items of two captures are compared: equal items, and the same action with another content. Positions
//! do not matter here.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::digest::Action;
use crate::sdo::transfer::{Direction, Status};

/// Returns a key that is equal for equal items; without the value, or the size, if these vary.
pub(super) fn symbol(action: &Action, varies: bool, resizes: bool) -> u64 {
    let mut hasher = DefaultHasher::new();
    match action {
        Action::Transfer(moved) => {
            (1, moved.direction == Direction::Upload, moved.mux).hash(&mut hasher);
            (moved.mode.name(), moved.status.name()).hash(&mut hasher);
            moved.abort.map(|abort| (abort.code, abort.by)).hash(&mut hasher);
            // The progress of an aborted transfer is not part of its outcome.
            if moved.status == Status::Ok {
                (!varies).then_some(moved.hash).hash(&mut hasher);
                (!resizes).then_some(moved.size).hash(&mut hasher);
            }
        }
        Action::Nmt(command) => (2, command).hash(&mut hasher),
        Action::BootUp => 3.hash(&mut hasher),
        Action::State(state) => (4, state).hash(&mut hasher),
        Action::Drive(state) => (5, state).hash(&mut hasher),
        Action::Emcy(code, register) => (6, code, register).hash(&mut hasher),
        Action::Lss(bytes) => (7, bytes).hash(&mut hasher),
    }
    hasher.finish()
}

/// Returns a key that is equal for the same action with any content.
pub(super) fn likeness(action: &Action) -> u64 {
    let mut hasher = DefaultHasher::new();
    match action {
        Action::Transfer(moved) => (1, moved.direction == Direction::Upload, moved.mux).hash(&mut hasher),
        Action::Nmt(_) => 2.hash(&mut hasher),
        Action::BootUp => 3.hash(&mut hasher),
        Action::State(_) => 4.hash(&mut hasher),
        Action::Drive(_) => 5.hash(&mut hasher),
        Action::Emcy(..) => 6.hash(&mut hasher),
        Action::Lss(bytes) => (7, bytes.first()).hash(&mut hasher),
    }
    hasher.finish()
}
