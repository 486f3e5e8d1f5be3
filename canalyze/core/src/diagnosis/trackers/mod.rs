//! What follows one kind of trouble each, from begin to end.
//!
//! A tracker owns what it has to remember of open incidents. It reads events and what the bus knows, and writes to the
//! ledger alone. Must not: link incidents, or say words.

pub(super) mod boots;
mod commanded;
pub(super) mod configuration;
pub(super) mod drive;
pub(super) mod emcy;
pub(super) mod load;
pub(super) mod masters;
pub(super) mod motion;
pub(super) mod nodes;
pub(super) mod rules;

/// What happens again within this time after it was over is the same trouble, in ns.
pub(super) const AGAIN_NS: i64 = 10_000_000_000;
