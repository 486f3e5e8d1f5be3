//! TIME (CiA 301, 7.2.6): a time of day that cannot be, and one that jumps against the capture's clock.

use super::nmt::since;
use crate::context::Context;
use crate::finding::{Code, Facts, Quantity};
use crate::frame::FrameRef;
use crate::services::time::DAY_MS;

/// What two TIMEs may differ by from the time between them, in ns.
const JUMP_NS: i64 = 1_000_000_000;

/// The last TIME of a bus.
#[derive(Debug, Default)]
pub struct Times {
    /// The frame, and what it says in ns since 1984-01-01.
    last: Option<(FrameRef, i64)>,
    /// The one before the last jump: where the next goes on from it, only one was wrong.
    before_jump: Option<(FrameRef, i64)>,
}

impl Times {
    /// The bus was silent for so long that it was not recorded, or the capture's clock was set: neither is TIME's fault.
    pub fn paused(&mut self) {
        self.last = None;
    }

    /// A TIME.
    pub fn judge(&mut self, ms: u32, days: u16, reserved: u8, cx: &mut Context<'_>) {
        if reserved != 0 {
            let facts = Facts::told(1, &[("found", Quantity::Hex2(reserved))]);
            cx.find(Code::Tim001, None, None, None, facts);
        }
        if ms >= DAY_MS {
            cx.find(Code::Tim001, None, None, None, Facts::told(0, &[("found", Quantity::Count(u64::from(ms)))]));
            return;
        }
        let told = (i64::from(days) * i64::from(DAY_MS) + i64::from(ms)) * 1_000_000;
        let before_jump = self.before_jump.take();
        let Some((last, before)) = self.last.replace((cx.at, told)) else { return };
        let Some(elapsed) = since(Some(last), cx.at).filter(|elapsed| *elapsed >= 0) else { return };
        let passed = told - before;
        if jumps(passed, elapsed) {
            if let Some((then, told_then)) = before_jump
                && since(Some(then), cx.at).is_some_and(|elapsed| !jumps(told - told_then, elapsed))
            {
                return;
            }
            self.before_jump = Some((last, before));
            let facts = [("passed", Quantity::Ns(passed)), ("elapsed", Quantity::Ns(elapsed))];
            cx.find(Code::Tim002, None, None, Some(last), Facts::told(0, &facts));
        }
    }
}

/// Whether two TIMEs differ from the time between them.
fn jumps(passed: i64, elapsed: i64) -> bool {
    passed.saturating_sub(elapsed).saturating_abs() > JUMP_NS
}
