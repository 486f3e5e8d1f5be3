//! The text of a TOML file as values with their lines. Invalid TOML and excessive nesting are mistakes.
//!
//! The keys are not known here.

use std::ops::Range;

use ::toml::de::{DeTable, DeValue};
use toml_parser::Source;
use toml_parser::lexer::TokenKind;

use super::Mistake;
use super::value::{KeyName, TomlTable, Value, short};

/// Maximum depth of brackets, and number of parts of a dotted key; our files need three.
const DEEPEST: usize = 32;
/// Maximum number of characters of a number, or of a key without quotes.
const LONGEST: usize = 128;

/// Returns the values of a file of this content.
pub(super) fn parse(content: &[u8], file: &str) -> Result<TomlTable, Mistake> {
    // Editors of Windows begin a file with a byte order mark.
    let content = content.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(content);
    let text = std::str::from_utf8(content).map_err(|error| {
        let before = content.get(..error.valid_up_to()).unwrap_or(content);
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        Mistake::new("config.not_utf8", [("file", file.to_owned()), ("line", line.to_string())])
    })?;
    let lines = Lines::of(text);
    let broken = |at: usize, problem: &str| {
        let (line, column) = lines.place(at);
        Mistake::new(
            "config.broken",
            [
                ("file", file.to_owned()),
                ("line", line.to_string()),
                ("column", column.to_string()),
                ("problem", short(problem)),
            ],
        )
    };
    limit(text, file, &lines)?;
    let root = DeTable::parse(text).map_err(|error| {
        let at = error.span().map_or(text.len(), |span| span.start);
        broken(at, error.message())
    })?;
    Ok(table(root.get_ref(), 0, &lines))
}

/// Refuses excessive input: too many nested brackets, parts of a dotted key or characters of a number.
fn limit(text: &str, file: &str, lines: &Lines<'_>) -> Result<(), Mistake> {
    let (mut depth, mut parts, mut dotted) = (0_usize, 0_usize, false);
    for token in Source::new(text).lex() {
        let kind = token.kind();
        let mut long = false;
        match kind {
            TokenKind::Whitespace | TokenKind::Comment => continue,
            TokenKind::Atom | TokenKind::BasicString | TokenKind::LiteralString => {
                parts = if dotted { parts + 1 } else { 1 };
                let span = token.span();
                let name = text.get(span.start()..span.end()).unwrap_or_default();
                long = kind == TokenKind::Atom && name.len() > LONGEST && is_long(name);
            }
            TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => depth += 1,
            TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket => depth = depth.saturating_sub(1),
            _ => {}
        }
        dotted = kind == TokenKind::Dot;
        if long || depth > DEEPEST || parts > DEEPEST {
            let (key, most) = if long { ("config.long", LONGEST) } else { ("config.deep", DEEPEST) };
            let line = lines.place(token.span().start()).0;
            let facts = [("file", file.to_owned()), ("line", line.to_string()), ("most", most.to_string())];
            return Err(Mistake::new(key, facts));
        }
    }
    Ok(())
}

/// Returns true if unquoted text has a number or a key of too many characters.
fn is_long(atom: &str) -> bool {
    let mut names = atom.split(|c: char| !c.is_alphanumeric() && !matches!(c, '_' | '+' | '-'));
    names.any(|name| name.chars().nth(LONGEST).is_some())
}

/// The starts of the lines of a text.
struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    fn of(text: &'a str) -> Self {
        let ends = memchr::memchr_iter(b'\n', text.as_bytes());
        Self { text, starts: std::iter::once(0).chain(ends.map(|end| end + 1)).collect() }
    }

    /// Returns line and column of a byte, each from 1.
    fn place(&self, at: usize) -> (usize, usize) {
        let line = self.starts.partition_point(|start| *start <= at);
        let start = self.starts.get(line.saturating_sub(1)).copied().unwrap_or(0);
        (line, 1 + self.text.get(start..at).map_or(0, |before| before.chars().count()))
    }

    fn line(&self, span: &Range<usize>) -> usize {
        self.starts.partition_point(|start| *start <= span.start)
    }
}

fn table(from: &DeTable<'_>, line: usize, lines: &Lines<'_>) -> TomlTable {
    let mut keys: Vec<_> = from.iter().collect();
    keys.sort_by_key(|(name, _)| name.span().start);
    let named = keys.into_iter().map(|(name, held)| {
        let line = lines.line(&name.span());
        (KeyName { text: name.get_ref().to_string(), line }, value(held.get_ref(), lines.line(&held.span()), lines))
    });
    TomlTable { line, keys: named.collect() }
}

fn value(from: &DeValue<'_>, line: usize, lines: &Lines<'_>) -> Value {
    match from {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(number) => whole(number.as_str(), number.radix(), number.to_string()),
        DeValue::Float(number) => Value::Real(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(truth) => Value::Truth(*truth),
        DeValue::Datetime(when) => Value::When(when.to_string()),
        DeValue::Array(list) => {
            Value::List(list.iter().map(|one| value(one.get_ref(), lines.line(&one.span()), lines)).collect())
        }
        DeValue::Table(inner) => Value::Table(table(inner, line, lines)),
    }
}

fn whole(digits: &str, radix: u32, written: String) -> Value {
    match i128::from_str_radix(digits, radix) {
        Ok(number) => Value::Whole(number),
        Err(_) => {
            let sign = if digits.starts_with('-') { -1.0 } else { 1.0 };
            let values = digits.chars().filter_map(|c| c.to_digit(radix));
            let size = values.fold(0.0, |sum, digit| sum * f64::from(radix) + f64::from(digit));
            Value::Huge(written, sign * size)
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic)]

    use super::*;

    fn list(of: &TomlTable, key: &str) -> Vec<TomlTable> {
        let Some(Value::List(list)) = of.get(key) else { return Vec::new() };
        let tables =
            list.iter().filter_map(|one| if let Value::Table(table) = one { Some(table.clone()) } else { None });
        tables.collect()
    }

    #[test]
    fn lines_of_keys_and_tables() {
        let text = "lang = 'zh'\n[[a]]\nx = 1\n'y z' = 2\n[[a]]\n# x = 1\n  \"x\" = 3\n[b]\nx.k = 4\n";
        let root = parse(text.as_bytes(), "f").unwrap();
        let a = list(&root, "a");
        let Some(Value::Table(b)) = root.get("b") else { panic!("{root:?}") };
        assert_eq!([root.line_of("lang"), a[0].line_of("x"), a[0].line_of("y z")], [1, 3, 4]);
        assert_eq!([a[1].line_of("x"), a[1].line_of("gone"), b.line_of("x"), b.line], [7, 5, 9, 8]);
        assert_eq!([root.line_of("b"), root.line_of("a"), root.line_of("c"), a[0].line], [8, 2, 0, 2]);
        let inline = parse(b"a = [\n{ x = 1 },\n{ y = 1 }]\r\nb.c = 1\n[d.e]\nf=1", "f").unwrap();
        assert_eq!(list(&inline, "a").iter().map(|one| one.line).collect::<Vec<_>>(), [2, 3]);
        assert_eq!([inline.line_of("b"), inline.line_of("d")], [4, 5]);
    }

    #[test]
    fn keys_stand_in_the_order_of_the_file() {
        let root = parse(b"z = 1\nb = 2\na = 3\n[y]\n[c]\n", "f").unwrap();
        assert_eq!(root.keys.iter().map(|(name, _)| name.text.as_str()).collect::<Vec<_>>(), ["z", "b", "a", "y", "c"]);
    }

    #[test]
    fn values() {
        let text = "a = 0x10\nb = -1_000\nc = 1e3\nd = nan\ne = 1979-05-27\nf = [true, 'x', {g = 1}]\nh = +7\n";
        let root = parse(text.as_bytes(), "f").unwrap();
        let shown: Vec<_> = root.keys.iter().map(|(_, value)| value.shown()).collect();
        assert_eq!(shown, ["16", "-1000", "1000.0", "nan", "1979-05-27", "[true, \"x\", {g = 1}]", "7"]);
        let huge = parse(format!("a = {}\nb = 0x{}", "9".repeat(120), "f".repeat(40)).as_bytes(), "f").unwrap();
        let sizes = huge.keys.iter().map(|(_, value)| if let Value::Huge(_, size) = value { *size } else { 0.0 });
        let sizes: Vec<_> = sizes.collect();
        assert!((sizes[0] / 1e120 - 1.0).abs() < 1e-9 && (sizes[1] / 2_f64.powi(160) - 1.0).abs() < 1e-9, "{sizes:?}");
    }

    #[test]
    fn what_is_no_toml_is_told_with_its_place() {
        let told = |content: &[u8]| {
            let mistake = parse(content, "f").unwrap_err();
            let place = |name| mistake.facts.iter().find(|fact| fact.0 == name).map_or("", |fact| &fact.1).to_owned();
            (mistake.key.clone(), place("line"), place("column"))
        };
        let broken = |line: &str, column: &str| ("config.broken".to_owned(), line.to_owned(), column.to_owned());
        assert_eq!(told("# é\nä = 1 é\n".as_bytes()).0, "config.broken");
        assert_eq!(told(b"a = 1\na = 2\n"), broken("2", "1"));
        assert!(parse("\u{feff}a = 1".as_bytes(), "f").is_ok());
        assert_eq!(told(b"a = 1\n\xff").0, "config.not_utf8");
        assert_eq!(told(b"a = 1\n\xff").1, "2");
        assert_eq!(told(format!("a = {}", "/long".repeat(50)).as_bytes()).0, "config.broken");
        assert_eq!(told(format!("\na = {}", "long".repeat(50)).as_bytes()).0, "config.long");
    }
}
