//! Suggestions for a misspelled word.
//!
//! The similarity is that of Ratcliff and Obershelp: twice the letters in common runs, divided by all letters. The time
//! grows with the square of the length, so words must be short.

/// Returns up to `most` words whose similarity is at least `cutoff` (0 to 1), the most similar first.
pub(super) fn near<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, most: usize, cutoff: f64) -> Vec<&'a str> {
    let meant: Vec<char> = word.chars().collect();
    let likeness = |one: &str| {
        let letters: Vec<char> = one.chars().collect();
        let all = letters.len() + meant.len();
        if all == 0 { 1.0 } else { 2.0 * common(&letters, &meant) as f64 / all as f64 }
    };
    let mut found: Vec<(f64, &str)> =
        known.into_iter().map(|one| (likeness(one), one)).filter(|(like, _)| *like >= cutoff).collect();
    found.sort_by(|one, other| other.0.total_cmp(&one.0).then_with(|| other.1.cmp(one.1)));
    found.into_iter().take(most).map(|(_, one)| one).collect()
}

/// Counts the letters of the longest common run and, recursively, of those before and behind it.
fn common(one: &[char], other: &[char]) -> usize {
    let mut sum = 0;
    let mut rest = vec![(one, other)];
    while let Some((one, other)) = rest.pop() {
        let (at, of, length) = longest(one, other);
        if length > 0 {
            let (before, behind) = (one.get(..at), one.get(at + length..));
            rest.extend(before.zip(other.get(..of)));
            rest.extend(behind.zip(other.get(of + length..)));
            sum += length;
        }
    }
    sum
}

/// Returns the first longest common run: its start in both, and its length.
fn longest(one: &[char], other: &[char]) -> (usize, usize, usize) {
    let mut best = (0, 0, 0);
    // Lengths of the runs that end at the previous letter, by their ends in the other word.
    let mut ending: Vec<usize> = vec![0; other.len()];
    for (at, letter) in one.iter().enumerate() {
        let mut before = 0;
        for (of, (same, run)) in other.iter().map(|wanted| wanted == letter).zip(&mut ending).enumerate() {
            let length = if same { before + 1 } else { 0 };
            before = std::mem::replace(run, length);
            if length > best.2 {
                best = (at + 1 - length, of + 1 - length, length);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_likest_comes_first() {
        let keys = ["node", "object", "direction", "value", "data"];
        assert_eq!(near("vlaue", keys, 1, 0.7), ["value"]);
        assert_eq!(near("colour", keys, 1, 0.7), [""; 0]);
        assert_eq!(near("within_ms", ["within_s", "window_ms"], 3, 0.5), ["within_s", "window_ms"]);
        assert_eq!(near("", [""], 1, 0.7), [""]);
    }

    #[test]
    fn common_runs() {
        let letters = |word: &str| word.chars().collect::<Vec<_>>();
        for (one, other, sum) in [("abcd", "bcde", 3), ("abxcd", "abcd", 4), ("", "a", 0), ("period_ms", "period_s", 8)]
        {
            assert_eq!(common(&letters(one), &letters(other)), sum, "{one} {other}");
        }
    }
}
