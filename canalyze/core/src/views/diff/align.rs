//! The alignment of two sequences of symbols: the shortest edit script of Myers (1986), found greedily and in bounded
//! steps.
//!
//! If two sequences differ by more than [`MOST`] edits, the best path so far is kept and the search starts anew at its
//! end, so that a million repetitions cost a million steps times a constant. The meaning of symbols does not matter
//! here.

/// Maximum number of edits of one search.
const MOST: usize = 768;

/// Returns the matching indices of two sequences, ascending in both.
pub(super) fn align(a: &[u64], b: &[u64]) -> Vec<(usize, usize)> {
    let mut pairs = Vec::with_capacity(a.len().min(b.len()));
    let head = a.iter().zip(b).take_while(|(one, other)| one == other).count();
    let tail = a.iter().skip(head).rev().zip(b.iter().skip(head).rev());
    let tail = tail.take_while(|(one, other)| one == other).count();
    let (head_a, head_b) = (a.get(..a.len() - tail).unwrap_or(a), b.get(..b.len() - tail).unwrap_or(b));
    let (mut x, mut y) = (0, 0);
    loop {
        let (rest_a, rest_b) = (head_a.get(x..).unwrap_or(&[]), head_b.get(y..).unwrap_or(&[]));
        let run = rest_a.iter().zip(rest_b).take_while(|(one, other)| one == other).count();
        pairs.extend((0..run).map(|step| (x + step, y + step)));
        (x, y) = (x + run, y + run);
        let (rest_a, rest_b) = (rest_a.get(run..).unwrap_or(&[]), rest_b.get(run..).unwrap_or(&[]));
        if rest_a.is_empty() || rest_b.is_empty() {
            break;
        }
        let (matched, to) = stretch(rest_a, rest_b);
        pairs.extend(matched.into_iter().map(|(i, j)| (x + i, y + j)));
        (x, y) = (x + to.0, y + to.1);
    }
    pairs.extend((0..tail).map(|step| (head_a.len() + step, head_b.len() + step)));
    settle(a, b, &mut pairs);
    pairs
}

/// Moves insertions as late as possible. An element that only one side has can often be placed at several positions;
/// the last one makes the first difference correct.
fn settle(a: &[u64], b: &[u64], pairs: &mut [(usize, usize)]) {
    let (mut x, mut y) = (0, 0);
    for (i, j) in pairs {
        if *i == x && *j > y && a.get(x) == b.get(y) {
            *j = y;
        } else if *j == y && *i > x && a.get(x) == b.get(y) {
            *i = x;
        }
        (x, y) = (*i + 1, *j + 1);
    }
}

/// The furthest row on each diagonal after a number of edits.
struct Front {
    rows: Vec<usize>,
    /// The number of edits.
    edits: usize,
}

impl Front {
    /// Returns the row of this front on the diagonal `k` = column - row, if it reaches the diagonal.
    fn at(&self, k: isize) -> Option<usize> {
        let slot = usize::try_from(k + self.edits as isize).ok()?;
        self.rows.get(slot).copied().filter(|row| *row != NOWHERE)
    }
}

const NOWHERE: usize = usize::MAX;

/// Returns the matches of the shortest path through both, or as far as [`MOST`] edits lead, and its end. It ends at
/// least one step further.
fn stretch(a: &[u64], b: &[u64]) -> (Vec<(usize, usize)>, (usize, usize)) {
    let mut fronts: Vec<Front> = Vec::new();
    for edits in 0..=MOST.min(a.len() + b.len()) {
        let mut rows = Vec::with_capacity(2 * edits + 1);
        let mut end = None;
        for k in -(edits as isize)..=edits as isize {
            let row = step(fronts.last(), k, edits, a, b).map_or(NOWHERE, |row| slide(a, b, k, row));
            if row == a.len() && column(row, k) == Some(b.len()) {
                end = Some(k);
            }
            rows.push(row);
        }
        fronts.push(Front { rows, edits });
        if let Some(k) = end {
            return (walk(&fronts, k), (a.len(), b.len()));
        }
    }
    let Some(last) = fronts.last() else { return (Vec::new(), (a.len(), b.len())) };
    let reach = |k: isize| last.at(k).map(|row| (row + column(row, k).unwrap_or(0), k));
    let edits = last.edits as isize;
    // Of paths that lead equally far, takes the one closest to the middle.
    let best = (-edits..=edits).filter_map(reach).max_by_key(|(far, k)| (*far, -k.abs()));
    let Some((_, k)) = best else { return (Vec::new(), (a.len(), b.len())) };
    let row = last.at(k).unwrap_or(0);
    (walk(&fronts, k), (row, column(row, k).unwrap_or(0)))
}

/// Returns the column on a diagonal at this row.
fn column(row: usize, k: isize) -> Option<usize> {
    usize::try_from(row as isize + k).ok()
}

/// Returns the furthest row on diagonal `k` with one edit more than the previous front. Rows count in `a`, columns in
/// `b`: an element left out of `a` leads to the diagonal below, one of `b` to the diagonal above.
fn step(before: Option<&Front>, k: isize, edits: usize, a: &[u64], b: &[u64]) -> Option<usize> {
    let Some(before) = before else { return (edits == 0).then_some(0) };
    let left_out = before.at(k + 1).map(|row| row + 1).filter(|row| *row <= a.len());
    let put_in = before.at(k - 1);
    let inside = |row: &usize| column(*row, k).is_some_and(|column| column <= b.len());
    left_out.filter(inside).max(put_in.filter(inside))
}

fn slide(a: &[u64], b: &[u64], k: isize, row: usize) -> usize {
    let Some(from) = column(row, k) else { return row };
    let (rest_a, rest_b) = (a.get(row..).unwrap_or(&[]), b.get(from..).unwrap_or(&[]));
    row + rest_a.iter().zip(rest_b).take_while(|(one, other)| one == other).count()
}

/// Returns the matches on the path to the end of diagonal `k` of the last front.
fn walk(fronts: &[Front], mut k: isize) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for (place, front) in fronts.iter().enumerate().rev() {
        let Some(end) = front.at(k) else { break };
        let before = place.checked_sub(1).and_then(|place| fronts.get(place));
        let left_out = before.and_then(|front| front.at(k + 1)).map(|row| row + 1);
        let put_in = before.and_then(|front| front.at(k - 1));
        // As in `step`: the further one, if it is inside.
        let left_out = left_out.filter(|row| *row <= end && column(*row, k).is_some());
        let put_in = put_in.filter(|row| *row <= end && column(*row, k).is_some());
        let start = if before.is_none() { 0 } else { left_out.max(put_in).unwrap_or(0) };
        pairs.extend((start..end).rev().filter_map(|row| Some((row, column(row, k)?))));
        if before.is_none() {
            break;
        }
        k += if left_out.is_some() && left_out >= put_in { 1 } else { -1 };
    }
    pairs.reverse();
    pairs
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use proptest::prelude::*;

    fn longest(a: &[u64], b: &[u64]) -> usize {
        let mut row = vec![0; b.len() + 1];
        for one in a {
            let mut corner = 0;
            for (j, other) in b.iter().enumerate() {
                let up = row[j + 1];
                row[j + 1] = if one == other { corner + 1 } else { up.max(row[j]) };
                corner = up;
            }
        }
        row[b.len()]
    }

    fn sound(a: &[u64], b: &[u64], pairs: &[(usize, usize)]) {
        for (i, j) in pairs {
            assert_eq!(a[*i], b[*j]);
        }
        for pair in pairs.windows(2) {
            assert!(pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1, "{pairs:?}");
        }
    }

    proptest! {
        #[test]
        fn as_many_as_can_be(a in proptest::collection::vec(0..5_u64, 0..40), b in proptest::collection::vec(0..5_u64, 0..40)) {
            let pairs = align(&a, &b);
            sound(&a, &b, &pairs);
            prop_assert_eq!(pairs.len(), longest(&a, &b));
        }

        #[test]
        fn nothing_of_the_order_of_sides(a in proptest::collection::vec(0..4_u64, 0..30), b in proptest::collection::vec(0..4_u64, 0..30)) {
            prop_assert_eq!(align(&a, &b).len(), align(&b, &a).len());
        }
    }

    #[test]
    fn far_apart() {
        let a: Vec<u64> = (0..20_000).collect();
        let b: Vec<u64> = (10_000..30_000).rev().collect();
        let pairs = align(&a, &b);
        sound(&a, &b, &pairs);
        let hole: Vec<u64> = a.iter().copied().filter(|n| !(5000..5600).contains(n)).collect();
        assert_eq!(align(&a, &hole).len(), hole.len());
    }

    #[test]
    fn a_million_of_a_poll() {
        let a: Vec<u64> = (0..1_000_000).map(|n| n % 7).collect();
        let b: Vec<u64> = (3..1_000_000).filter(|n| n % 100_003 != 0).map(|n| n % 7).collect();
        let pairs = align(&a, &b);
        sound(&a, &b, &pairs);
        assert!(pairs.len() > 999_000, "{}", pairs.len());
    }
}
