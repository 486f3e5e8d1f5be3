//! The duration of a capture by its time stamps, which may step backward.
//!
//! All reports use this one measure, so that they agree about a capture.

use crate::bytes::ns::Ns;

/// The backward step, in ns, from which on the clock counts as set back; after a smaller one, frames only changed
/// places.
const SET_BACK_NS: Ns = Ns::from_s(1);

/// The time stamps of a capture in recorded order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// The first and the last stamp, in ns.
    pub ends_ns: Option<(Ns, Ns)>,
    /// Time from the first to the last stamp in ns, not counting the steps by which the clock was set back.
    pub elapsed_ns: Option<Ns>,
    /// Number of stamps earlier than their predecessor.
    pub backward: u64,
    /// The largest backward step, in ns.
    pub backward_most_ns: Ns,
    /// The largest stamp since the clock was last set back, in ns.
    high_ns: Ns,
}

impl Span {
    /// Adds the next stamp and returns the time since the previous one, in ns; `None` for the first.
    pub fn take(&mut self, now_ns: Ns) -> Option<Ns> {
        let (Some((first_ns, last_ns)), Some(elapsed_ns)) = (self.ends_ns, &mut self.elapsed_ns) else {
            (self.ends_ns, self.elapsed_ns, self.high_ns) = (Some((now_ns, now_ns)), Some(Ns::ZERO), now_ns);
            return None;
        };
        let step_ns = now_ns - last_ns;
        if step_ns < Ns::ZERO {
            self.backward += 1;
            self.backward_most_ns = self.backward_most_ns.max(-step_ns);
        }
        if now_ns > self.high_ns {
            *elapsed_ns += now_ns - self.high_ns;
            self.high_ns = now_ns;
        } else if self.high_ns - now_ns >= SET_BACK_NS {
            self.high_ns = now_ns;
        }
        self.ends_ns = Some((first_ns, now_ns));
        Some(step_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::Span;
    use crate::bytes::ns::Ns;

    #[test]
    fn stamps_that_go_back() {
        const S: i64 = 1_000_000_000;
        for (stamps, elapsed, backward, most) in [
            (&[5][..], 0, 0, 0),
            (&[1, 3, 9], 8, 0, 0),
            (&[1, 5, 3, 9], 10, 1, 2),
            (&[100, 5, 7, 9], 4, 1, 95),
            (&[10, 2, 12, 1], 10, 2, 11),
        ] {
            let mut span = Span::default();
            for stamp in stamps {
                span.take(Ns(stamp * S));
            }
            let found = (span.elapsed_ns, span.backward, span.backward_most_ns);
            assert_eq!(found, (Some(Ns(elapsed * S)), backward, Ns(most * S)), "{stamps:?}");
        }
        let mut swapped = Span::default();
        assert_eq!([5, 7, 6, 8].map(|ns| swapped.take(Ns(ns))), [None, Some(Ns(2)), Some(Ns(-1)), Some(Ns(2))]);
        assert_eq!((swapped.elapsed_ns, swapped.ends_ns), (Some(Ns(3)), Some((Ns(5), Ns(8)))));
    }
}
