//! TIME (CiA 301, 7.2.6): impossible times of day, and jumps against the capture's clock.

use crate::bytes::ns::Ns;
use crate::evidence::{Recording, When};
use crate::rules::time::{Tim001, Tim002};
use crate::wire::time::DAY_MS;
use crate::world::context::Context;

/// Maximum deviation of two TIMEs from the time between them: in ns, and as the fraction by which clocks differ.
const JUMP_NS: Ns = Ns::from_s(1);
const CLOCK_PART: i64 = 100;

/// The last TIME of a bus.
#[derive(Debug, Default)]
pub struct Times {
    /// The last TIME, in ns since 1984-01-01.
    last: Option<(When, Ns)>,
    /// The TIME before the last jump; if the next one continues from it, only one was wrong.
    before_jump: Option<(When, Ns)>,
}

impl Times {
    /// Forgets the last TIME after a silence that was not recorded, or after the capture's clock was set.
    pub fn paused(&mut self) {
        self.last = None;
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
        let before_jump = self.before_jump.take();
        let Some((last, before)) = self.last.replace((cx.when, time)) else { return };
        let recording = &cx.evidence.recording;
        let Some(elapsed) = recording.between(last, cx.when).filter(|elapsed| *elapsed >= Ns::ZERO) else { return };
        let passed = time - before;
        if !jumps(passed, last, cx.when, recording) {
            return;
        }
        if before_jump.is_some_and(|(then, time_then)| !jumps(time - time_then, then, cx.when, recording)) {
            return;
        }
        self.before_jump = Some((last, before));
        cx.report_timed(cx.verdict(Tim002::Jump { passed, elapsed }, None, None, Some(last.at)));
    }
}

/// Returns true if two TIMEs certainly deviate from the time between them.
fn jumps(passed: Ns, since: When, now: When, recording: &Recording) -> bool {
    let allowance = JUMP_NS + passed.abs() / CLOCK_PART;
    recording.certainly_later(now, since, passed + allowance)
        || recording.certainly_within(now, since, passed - allowance)
}
