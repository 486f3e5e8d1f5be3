//! Trackers, which follow one kind of problem each from beginning to end.
//!
//! A tracker owns the memory of its open problems. It reads events and the state of the bus, and writes only to the
//! ledger.

pub(super) mod boots;
mod commanded;
pub(super) mod configuration;
pub(super) mod drive;
pub(super) mod emcy;
pub(super) mod heartbeats;
pub(super) mod identity;
pub(super) mod idle;
pub(super) mod in_vain;
pub(super) mod load;
pub(super) mod masters;
pub(super) mod motion;
pub(super) mod nodes;
pub(super) mod pdos;
pub(super) mod rules;

pub(super) use crate::checks::limits::AGAIN_NS;
