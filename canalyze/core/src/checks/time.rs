//! TIME (CiA 301, 7.2.6): impossible times of day, and jumps against the capture's clock.

use crate::bytes::ns::Ns;
use crate::evidence::{Recording, When};
use crate::rules::time::{Tim001, Tim002};
use crate::wire::time::DAY_MS;
use crate::world::context::Context;

/// Maximum deviation of two TIMEs from the time between them: in ns, and as the fraction by which clocks differ.
const JUMP_NS: Ns = Ns::from_s(1);
const CLOCK_PART: i64 = 100;
/// The same over several TIMEs, in ns: a clock may count seconds only.
const AWAY_NS: Ns = Ns::from_s(2);

/// The clock of a bus. Times are in ns since 1984-01-01.
#[derive(Debug, Default)]
pub struct Times {
    /// The last TIME.
    last: Option<(When, Ns)>,
    /// The first one in a row of equal ones, and the first one since a jump: a clock that stands still, or runs at another
    /// rate, deviates from one TIME to the next by less than is allowed.
    equal: Option<(When, Ns)>,
    first: Option<(When, Ns)>,
    /// The TIME before the last jump; if the next one continues from it, only one was wrong.
    before_jump: Option<(When, Ns)>,
}

impl Times {
    /// Forgets the clock after a silence that was not recorded, or after the capture's clock was set.
    pub fn paused(&mut self) {
        (self.last, self.equal, self.first) = (None, None, None);
    }

    /// Takes a TIME.
    pub fn judge(&mut self, ms: u32, days: u16, reserved: u8, cx: &mut Context<'_>) {
        if reserved != 0 {
            cx.raise(Tim001::ReservedBits { found: reserved }, None, None, None);
        }
        if ms >= DAY_MS {
            cx.raise(Tim001::TimeOfDay { found: ms.into() }, None, None, None);
            return;
        }
        let time = Ns::from_ms(i64::from(days) * i64::from(DAY_MS) + i64::from(ms));
        let (now, before_jump) = ((cx.when, time), self.before_jump.take());
        let (last, equal, first) = (self.last.replace(now), self.equal, self.first);
        self.equal = equal.filter(|(_, before)| *before == time).or(self.last);
        self.first = first.or(self.last);
        let recording = &cx.evidence.recording;
        let away =
            |than: Option<(When, Ns)>, allowed_ns: Ns| than.filter(|than| jumps(*than, now, allowed_ns, recording));
        let found = away(last, JUMP_NS).or_else(|| away(equal, AWAY_NS)).or_else(|| away(first, AWAY_NS));
        let Some((since, before)) = found else { return };
        let Some(elapsed) = recording.between(since, cx.when).filter(|elapsed| *elapsed >= Ns::ZERO) else { return };
        (self.equal, self.first) = (self.last, self.last);
        if before_jump.is_some() && away(before_jump, JUMP_NS).is_none() {
            return;
        }
        self.before_jump = Some((since, before));
        cx.report_timed(cx.verdict(Tim002::Jump { passed: time - before, elapsed }, None, None, Some(since.at)));
    }
}

/// Returns true if two TIMEs certainly deviate by more from the time between them, beside the difference of clocks.
fn jumps(then: (When, Ns), now: (When, Ns), allowed_ns: Ns, recording: &Recording) -> bool {
    let passed = now.1 - then.1;
    let allowance = allowed_ns + passed.abs() / CLOCK_PART;
    recording.certainly_later(now.0, then.0, passed + allowance)
        || recording.certainly_within(now.0, then.0, passed - allowance)
}
