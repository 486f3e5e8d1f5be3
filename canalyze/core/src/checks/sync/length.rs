//! The length of SYNC (CiA 301, 7.2.5.3.1): one byte with a counter, none without. Longer ones are malformed and not
//! judged here.

use crate::rules::sync::Syn001;
use crate::sdo::wire::Mux;
use crate::world::context::Context;

/// Number of SYNCs that make their length the usual one.
const LENGTHS: u8 = 3;
/// The usual length of SYNCs.
#[derive(Clone, Copy, Debug)]
struct Usual {
    bytes: u8,
    /// Number of SYNCs of this length, up to [`LENGTHS`].
    had: u8,
    /// Number of SYNCs of another length in a row since.
    others: u8,
}

/// The lengths of a bus's SYNCs.
#[derive(Debug, Default)]
pub struct Lengths {
    usual: Option<Usual>,
    /// The last SYNC's length contradicted 1019h, and that was reported.
    against_1019: bool,
}

impl Lengths {
    /// Takes a change of the configured overflow value.
    pub fn reconfigured(&mut self) {
        self.usual = None;
    }

    /// Judges the length against 1019h and against earlier SYNCs; returns true if it is wrong. `overflow`: 1019h and
    /// its node if known.
    pub fn judge(&mut self, found: u8, overflow: Option<(u8, u8)>, restarted: bool, cx: &mut Context<'_>) -> bool {
        if found > 1 {
            return true;
        }
        let reported = std::mem::take(&mut self.against_1019);
        if let Some((overflow, node)) = overflow.filter(|(overflow, _)| (*overflow > 0) != (found == 1)) {
            self.against_1019 = true;
            if reported {
                return true;
            }
            let what = Syn001::Overflow { found: found.into(), overflow: overflow.into() };
            cx.raise(what, Some(node), Some(Mux { index: 0x1019, sub: 0 }), None);
            return true;
        }
        let fresh = Usual { bytes: found, had: 1, others: 0 };
        let Some(known) = self.usual.filter(|_| !restarted) else {
            self.usual = Some(fresh);
            return false;
        };
        if found == known.bytes {
            self.usual = Some(Usual { had: (known.had + 1).min(LENGTHS), others: 0, ..known });
            return false;
        }
        let gives_way = known.had < LENGTHS || known.others + 1 >= LENGTHS;
        self.usual = Some(if gives_way { fresh } else { Usual { others: known.others + 1, ..known } });
        let wrong = known.had >= LENGTHS && known.others == 0;
        if wrong {
            cx.raise(Syn001::Before { found: found.into(), expected: known.bytes.into() }, None, None, None);
        }
        wrong
    }
}
