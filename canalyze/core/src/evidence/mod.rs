//! What the recording did, and what is certain in spite of it: the ground under every verdict.
//!
//! A check compares times, knows what is owed and what excuses a breach only through this room, so that a property of
//! a capture (late echoes, frames captured twice, a recorder that stood still, coarse stamps, lost frames) is modelled
//! once. One value of [`Evidence`] belongs to one bus and travels in the [`Context`](crate::context::Context). It must
//! not know a service's rules, and it raises no finding of its own: it says when, whether and why.

pub mod circumstance;
pub mod duplicates;
mod holes;
pub mod obligation;
pub mod pending;
pub mod period;
pub mod recording;
mod resolution;
mod senders;
pub mod services;
mod stalls;
pub mod when;

#[cfg(test)]
mod tests;

pub use circumstance::{Circumstances, Kind, Rules};
pub use obligation::Obligations;
pub use pending::Pending;
pub use period::Period;
pub use recording::Recording;
pub use services::Services;
pub use when::When;

/// The evidence of one bus.
#[derive(Debug, Default)]
pub struct Evidence {
    /// What the recording did.
    pub recording: Recording,
    /// What happened on the bus that excuses others.
    pub circumstances: Circumstances,
    /// Findings that later evidence may still explain.
    pub pending: Pending,
    /// What the identifiers of services carry.
    pub services: Services,
}

impl Evidence {
    /// Of a bus of which nothing was seen; `jitter_ns`: how exact a person says that its stamps are; `described`: a
    /// person says that there is CANopen on it.
    pub fn new(jitter_ns: Option<i64>, described: bool) -> Self {
        Self { recording: Recording::new(jitter_ns), services: Services::new(described), ..Self::default() }
    }
}
