//! The period that a complete capture shows, and its variation.

use crate::bytes::ns::Ns;

/// Minimum number of gaps.
const LEAST_GAPS: usize = 4;
/// Percentiles of the gaps between which their variation is measured, since the capturing machine may delay a few
/// frames.
const LEAST: usize = 5;
const MOST: usize = 95;

/// The period of a stream and its variation.
#[derive(Clone, Debug)]
pub struct Pace {
    /// The median gap, in ns.
    pub median_ns: Ns,
    /// The variation of gaps, without the extreme ones, in ns.
    pub spread_ns: Ns,
    /// It keeps its period.
    pub regular: bool,
    /// Number of gaps.
    pub gaps: usize,
}

impl Pace {
    /// Measures a stream by the positions of its frames, in ns; `None` for fewer than five frames.
    pub fn of(positions: impl Iterator<Item = Ns>) -> Option<Self> {
        let positions: Vec<Ns> = positions.collect();
        let pairs = positions.iter().zip(positions.iter().skip(1));
        let mut gaps: Vec<Ns> = pairs.map(|(one, next)| *next - *one).collect();
        if gaps.len() < LEAST_GAPS {
            return None;
        }
        gaps.sort_unstable();
        let at = |percent: usize| gaps.get((gaps.len() - 1) * percent / 100).copied().unwrap_or(Ns::ZERO);
        let median_ns = at(50);
        let spread_ns = at(MOST) - at(LEAST);
        let regular = median_ns > Ns::ZERO && at(75) - at(25) <= median_ns / 4;
        Some(Self { median_ns, spread_ns, regular, gaps: gaps.len() })
    }
}
