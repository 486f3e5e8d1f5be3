//! Values of a TOML file with their lines, and their form in messages.
//!
//! Plain data in the order of the file. The keys are not known here.

use std::fmt::Write as _;

/// Maximum number of characters of a text in a message.
const SHOWN: usize = 200;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    Whole(i128),
    /// A number with decimals, or a number that is not finite.
    Real(f64),
    /// A whole number beyond the supported range: its text, and its approximate value.
    Huge(String, f64),
    Truth(bool),
    /// A date, a time or both.
    When(String),
    List(Vec<Value>),
    Table(TomlTable),
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TomlTable {
    /// The line of its heading, or of its start.
    pub(super) line: usize,
    /// In the order of the file.
    pub(super) keys: Vec<(KeyName, Value)>,
}

/// A key of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct KeyName {
    pub(super) text: String,
    pub(super) line: usize,
}

impl TomlTable {
    /// The value of a key.
    pub(super) fn get(&self, key: &str) -> Option<&Value> {
        self.keys.iter().find(|(name, _)| name.text == key).map(|(_, value)| value)
    }

    /// Returns the line of a key, or of the table if the key is missing.
    pub(super) fn line_of(&self, key: &str) -> usize {
        self.keys.iter().find(|(name, _)| name.text == key).map_or(self.line, |(name, _)| name.line)
    }
}

impl Value {
    /// Formats the value as in the file, in one line of bounded length.
    pub(super) fn shown(&self) -> String {
        match self {
            // The quotes stay, even if the text between them is shortened.
            Self::Text(text) => format!("\"{}\"", short(text)),
            _ => {
                let mut shown = String::new();
                self.put(&mut shown);
                short(&shown)
            }
        }
    }

    fn put(&self, out: &mut String) {
        match self {
            Self::Text(text) => _ = write!(out, "\"{text}\""),
            Self::Whole(number) => _ = write!(out, "{number}"),
            Self::Real(number) => out.push_str(&real(*number)),
            Self::Huge(text, _) | Self::When(text) => out.push_str(text),
            Self::Truth(truth) => _ = write!(out, "{truth}"),
            Self::List(list) => {
                out.push('[');
                for (place, value) in list.iter().enumerate() {
                    out.push_str(if place > 0 { ", " } else { "" });
                    value.put(out);
                }
                out.push(']');
            }
            Self::Table(table) => {
                out.push('{');
                for (place, (name, value)) in table.keys.iter().enumerate() {
                    _ = write!(out, "{}{} = ", if place > 0 { ", " } else { "" }, name.text);
                    value.put(out);
                }
                out.push('}');
            }
        }
    }
}

/// Formats a number with decimals, with an exponent if it is far from 1.
fn real(number: f64) -> String {
    if !number.is_finite() {
        return number.to_string().to_lowercase();
    }
    let scientific = format!("{number:e}");
    let (digits, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if !(-4..16).contains(&exponent) {
        return format!("{digits}e{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.unsigned_abs());
    }
    let plain = number.to_string();
    if plain.contains('.') { plain } else { plain + ".0" }
}

/// Formats a text for a message of one line.
pub(super) fn short(text: &str) -> String {
    match text.char_indices().nth(SHOWN - 1) {
        Some((end, last)) if end + last.len_utf8() < text.len() => format!("{}…", text.get(..end).unwrap_or_default()),
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_as_people_write_them() {
        for (number, shown) in [
            (0.0, "0.0"),
            (1e-9, "1e-09"),
            (1.5e-5, "1.5e-05"),
            (0.0001, "0.0001"),
            (500.0, "500.0"),
            (1e15, "1000000000000000.0"),
            (1e16, "1e+16"),
            (-2.5e300, "-2.5e+300"),
            (f64::NAN, "nan"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(real(number), shown);
        }
    }

    #[test]
    fn long_texts_are_cut() {
        assert_eq!(short(&"ä".repeat(SHOWN)), "ä".repeat(SHOWN));
        assert_eq!(short(&"ä".repeat(SHOWN + 1)), "ä".repeat(SHOWN - 1) + "…");
        assert_eq!(Value::Text("x".repeat(300)).shown().chars().count(), SHOWN + 2);
        let list = Value::List(vec![Value::Text("a".into()), Value::List(vec![Value::Truth(true)])]);
        assert_eq!(list.shown(), "[\"a\", [true]]");
    }
}
