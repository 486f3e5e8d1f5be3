//! The expression of `--select`, which chooses the signals to list.
//!
//! Patterns are separated by commas; `*` matches any run of characters, `?` any one; case is ignored. A pattern is
//! compared with a signal's name, with `NODE.NAME`, with `NODE.PDO.NAME` and, in place of the name, with its object as
//! `6041:00`, `6041h:00` or `6041`.

/// A parsed `--select` expression.
#[derive(Clone, Debug, Default)]
pub struct Select {
    patterns: Vec<Vec<char>>,
}

impl Select {
    /// Parses an expression; an empty one selects everything.
    pub fn parse(expression: &str) -> Self {
        let patterns = expression.split(',').map(str::trim).filter(|pattern| !pattern.is_empty());
        Self { patterns: patterns.map(|pattern| pattern.to_lowercase().chars().collect()).collect() }
    }

    /// Returns true if every signal is selected.
    pub fn is_everything(&self) -> bool {
        self.patterns.is_empty()
    }

    /// Returns true if any of a signal's names is selected.
    pub fn takes<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> bool {
        self.is_everything()
            || names.into_iter().any(|name| {
                let name: Vec<char> = name.to_lowercase().chars().collect();
                self.patterns.iter().any(|pattern| matches(pattern, &name))
            })
    }
}

/// Returns true if a pattern matches a whole name. Each `*` first tries its shortest run; only the last one is retried.
fn matches(pattern: &[char], name: &[char]) -> bool {
    let (mut at, mut of) = (0, 0);
    let mut back: Option<(usize, usize)> = None;
    loop {
        match (pattern.get(at), name.get(of)) {
            (Some('*'), _) => {
                back = Some((at, of));
                at += 1;
            }
            (Some(wanted), Some(found)) if *wanted == '?' || wanted == found => {
                at += 1;
                of += 1;
            }
            (None, None) => return true,
            (_, found) => match back {
                Some((star, from)) if found.is_some() || from < name.len() => {
                    back = Some((star, from + 1));
                    at = star + 1;
                    of = from + 1;
                    if of > name.len() {
                        return false;
                    }
                }
                _ => return false,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns() {
        for (expression, name, taken) in [
            ("", "anything", true),
            ("*", "", true),
            ("5.*", "5.Statusword", true),
            ("5.*", "15.Statusword", false),
            ("*velocity*", "5.TPDO1.Velocity actual value", true),
            ("*velocity", "5.Velocity actual value", false),
            ("status?ord", "Statusword", true),
            ("a*b*c", "a-b-b-c", true),
            ("a*b*c", "a-b-b-d", false),
            ("x, 6041*", "6041:00", true),
        ] {
            assert_eq!(Select::parse(expression).takes([name]), taken, "{expression} {name}");
        }
    }
}
