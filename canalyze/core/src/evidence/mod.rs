//! The behaviour of the recording, and the facts that are certain in spite of it, on which every verdict rests.
//!
//! Checks compare times, open obligations and find excuses only through this room, so that each property of a capture
//! (late echoes, duplicate frames, stalls, coarse stamps, lost frames) is modelled once. One [`Evidence`] belongs to
//! one bus and travels in the [`Context`](crate::world::context::Context). It knows no rules of services and raises no
//! findings of its own.

use crate::bytes::ns::Ns;

pub mod circumstance;
mod clocks;
pub mod duplicates;
mod echoes;
mod holes;
mod losses;
pub mod obligation;
pub mod order;
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

pub use circumstance::{CircumstanceKind, Circumstances, Rules};
pub use obligation::Obligations;
pub use pending::Pending;
pub use period::Period;
pub use recording::Recording;
pub use services::Services;
pub use when::When;

/// The evidence of one bus.
#[derive(Debug, Default)]
pub struct Evidence {
    /// The behaviour of the recording.
    pub recording: Recording,
    /// Circumstances on the bus that excuse breaches.
    pub circumstances: Circumstances,
    /// Findings that later evidence may still explain.
    pub pending: Pending,
    /// The evidence about the identifiers of services.
    pub services: Services,
}

impl Evidence {
    /// Creates the evidence of a bus without frames; `jitter_ns`: the accuracy of its stamps as given by the user;
    /// `described`: the user says that it is CANopen.
    pub fn new(jitter_ns: Option<Ns>, described: bool) -> Self {
        Self { recording: Recording::new(jitter_ns), services: Services::new(described), ..Self::default() }
    }
}
