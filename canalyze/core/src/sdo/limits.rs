//! Times by which a request counts as unanswered or given up.

use crate::bytes::frame::FrameRef;

/// Age in ns at which a request at the capture's end counts as unanswered (CiA 301 sets no limit).
pub const UNANSWERED_NS: i64 = 1_000_000_000;
/// The shortest time-out of known clients, in ns.
pub(super) const SHORTEST_TIMEOUT_NS: i64 = 300_000_000;
/// Time after which a client that goes on has given up waiting, in ns.
pub(super) const GIVEN_UP_NS: i64 = 20_000_000;

/// Returns true if a frame follows another within a time in ns; without stamps, always.
pub(super) fn within(from: FrameRef, to: FrameRef, limit_ns: i64) -> bool {
    match (from.t_ns, to.t_ns) {
        (Some(from), Some(to)) => to.saturating_sub(from) <= limit_ns,
        _ => true,
    }
}
