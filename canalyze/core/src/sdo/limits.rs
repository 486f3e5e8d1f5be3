//! Times by which a request counts as unanswered or given up; that of any service is here.

use super::wire::Mux;
use crate::bytes::frame::FrameRef;
use crate::bytes::ns::Ns;

/// Age in ns at which a request of SDO, node guarding or LSS counts as unanswered: CiA 301 and CiA 305 set no limit; it is
/// the time-out of CANopenNode's LSS master, and the longest one known.
pub const UNANSWERED_NS: Ns = Ns::from_s(1);
/// The shortest time-out of known clients, in ns.
pub const SHORTEST_TIMEOUT_NS: Ns = Ns::from_ms(300);
/// Time after which a client that goes on has given up waiting, in ns.
pub const GIVEN_UP_NS: Ns = Ns::from_ms(20);

/// Time after which a client that neither goes on with its transfer nor aborts it has left it, in ns; CiA 301 sets no limit.
pub const LEFT_NS: Ns = Ns::from_s(5);

/// Response time that is nearly too late, in ns: clients wait for 1 s or less.
pub const LATE_NS: Ns = Ns::from_ms(900);
/// Multiple of a server's longest response time that it does not exceed.
pub const PROMPT: i64 = 10;
/// Maximum waiting time of a request without any frame, in ns; clients give up sooner, slow servers answer sooner.
pub const SILENT_NS: Ns = Ns::from_ms(1_500);

/// Returns true if a server may be slow on an object: it writes or erases non-volatile memory (CiA 301, 7.5.2.13 and
/// 7.5.2.14; CiA 302-3).
pub fn takes_time(object: Mux) -> bool {
    matches!(object.index, 0x1010 | 0x1011 | 0x1F50 | 0x1F51)
}

/// Returns true if a frame follows another within a time in ns; without stamps, always.
pub fn within(from: FrameRef, to: FrameRef, limit_ns: Ns) -> bool {
    match (from.t_ns, to.t_ns) {
        (Some(from), Some(to)) => to - from <= limit_ns,
        _ => true,
    }
}
