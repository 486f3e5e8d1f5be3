//! Turns the tables in `words/` into Rust: each becomes the expression of a slice, which `words!` includes. Nothing is
//! parsed at run time.
//!
//! A table is text: a row a line, a tab between cells, `#` before a comment; the first row names the columns. A line that
//! begins with a tab continues the row above. The name of a column defines the form of its cells:
//!
//! | column | cell | in Rust |
//! |---|---|---|
//! | `index` | four hexadecimal digits | a number |
//! | `range` | one index, or two with a hyphen between them | two numbers |
//! | `code` | two, four or eight hexadecimal digits | a number |
//! | `value`, `profile` | a decimal number | a number |
//! | `sub` | a decimal number if the row is a part of the row above, else empty | a slice of parts, behind the other cells |
//! | `type` | a data type, an array of it (`[]`), `RECORD`, or `-` if it is not standardized | a `Shape`; of a part a `DataType` |
//! | `names` | texts with `, ` between them | a slice |
//! | `codes` | codes of rules, likewise, or empty | a slice of `Code`s |
//! | capitalized, as `DriveState` | a variant of that type | the variant |
//! | `zh`, `en` | Chinese and English | two texts |
//! | `cause.zh`, `cause.en` | Chinese and English | one `Words` |
//! | any other | text | a text |
//!
//! Rows with numbers are in ascending order; other rows differ in their first cells.
//!
//! A table whose first column ends with `!` becomes a call of that macro: a row is its first cell as it is, `told` as it is,
//! `facts` in braces if there are any, `codes`, `roles`, `signs` (`SYN003 Once 3`: a code, the sign that ends it, and a number),
//! `emcy` (`8110, 8100-82FF`), `titles` and `checks` (`has others + Ended: EDS, MAPPING; EDS`: names, with conditions before
//! them) in brackets, cells of a capitalized
//! column as they are, and the other cells as texts, with `;` behind them.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=words");
    let out = env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?;
    for entry in fs::read_dir("words")? {
        let path = entry?.path();
        let made = path.file_name().map(|name| Path::new(&out).join(name).with_extension("rs"));
        if let (Some(made), Some("tsv")) = (made, path.extension().and_then(|extension| extension.to_str())) {
            match rows(&fs::read_to_string(&path)?) {
                Ok(rows) => fs::write(made, rows)?,
                Err((line, fault)) => println!("cargo::error={}:{line}: {fault}", path.display()),
            }
        }
    }
    Ok(())
}

/// The numbers by which rows are ordered: the ends of their ranges.
#[derive(Default, PartialEq)]
struct Key {
    first: Vec<i64>,
    last: Vec<i64>,
    sub: Option<i64>,
}

/// Returns the rows of a table in Rust, or the first fault with its line. Each row ends on the same line as in the table,
/// so that the lines of the compiler's errors are those of the table.
pub(crate) fn rows(table: &str) -> Result<String, (usize, String)> {
    let mut lines = table.lines().zip(1..).peekable();
    let (mut out, mut columns, mut above, mut seen) = (String::new(), Vec::new(), Key::default(), HashSet::new());
    let mut open = false;
    while let Some((line, mut at)) = lines.next() {
        if !line.is_empty() && !line.starts_with('#') {
            let mut cells: Vec<&str> = line.split('\t').collect();
            while let Some((more, end)) = lines.next_if(|(line, _)| line.starts_with('\t')) {
                cells.extend(more.split('\t').skip(1));
                out.push('\n');
                at = end;
            }
            if columns.is_empty() {
                columns = cells;
                match columns.first() {
                    Some(name) if name.ends_with('!') => out.insert_str(0, &format!("{name} {{")),
                    _ => out.insert_str(0, "&["),
                }
            } else {
                if columns.first().is_some_and(|name| name.ends_with('!')) {
                    let call = call(&columns, &cells).map_err(|fault| (at, fault))?;
                    if !seen.insert(cells.first().copied()) {
                        return Err((at, "is there already".to_owned()));
                    }
                    out.push_str(&call);
                    out.push('\n');
                    continue;
                }
                let (key, row) = row(&columns, &cells).map_err(|fault| (at, fault))?;
                let fits = match key.sub {
                    Some(_) => open && key.first == above.first && key.last == above.last && key.sub > above.sub,
                    None if key.first.is_empty() => seen.insert(cells.first().copied()),
                    None => key.first > above.last && key.first <= key.last,
                };
                if !fits {
                    return Err((at, "is there already, or not in order".to_owned()));
                }
                if open && key.sub.is_none() {
                    out.push_str("]),");
                }
                open = columns.contains(&"sub");
                let end = if open && key.sub.is_none() { ", &[" } else { ")," };
                _ = write!(out, "({row}{end}");
                above = key;
            }
        }
        out.push('\n');
    }
    let end = match columns.first() {
        Some(name) if name.ends_with('!') => "}",
        _ if open => "])]",
        _ => "]",
    };
    Ok(out + end)
}

/// Returns the cells of a row of a macro call in Rust.
fn call(columns: &[&str], cells: &[&str]) -> Result<String, String> {
    if cells.len() != columns.len() {
        return Err(format!("{} cells for {} columns", cells.len(), columns.len()));
    }
    let mut made = Vec::new();
    for (place, (name, cell)) in columns.iter().zip(cells).enumerate() {
        match *name {
            "facts" if cell.is_empty() => {}
            "facts" => made.push(format!("{{ {cell} }}")),
            "told" => made.push((*cell).to_owned()),
            _ if place == 0 => made.push((*cell).to_owned()),
            "codes" => made.push(format!("[{}]", list(cell, |code| format!("Code::{}", camel(code))))),
            "roles" => made.push(format!("[{}]", list(cell, |role| format!("KindRole::{role}")))),
            "signs" => made.push(format!("[{}]", list(cell, sign))),
            "emcy" => made.push(format!("[{}]", list(cell, range))),
            "titles" => made.push(format!("[{}]", conditional(cell, |title| format!("&title::{title}")))),
            "checks" => {
                let checks = |cell: &str| format!("&[{}]", list(cell, |check| format!("say::{check}")));
                made.push(format!("[{}]", conditional(cell, checks)));
            }
            name if name.starts_with(char::is_uppercase) => made.push((*cell).to_owned()),
            name if !fits(name, cell, cells.get(place + 1)) => return Err(format!("{name}: '{cell}' does not fit")),
            _ => made.push(format!("{cell:?}")),
        }
    }
    Ok(made.join(" ") + ";")
}

/// Returns true for a text without a word beside the facts in braces.
fn is_facts(cell: &str) -> bool {
    !cell.split(['{', '}']).step_by(2).any(|words| words.chars().any(char::is_alphabetic)) && cell.contains('{')
}

/// Returns true if a text fits its column. `next`: the cell behind it.
fn fits(name: &str, cell: &str, next: Option<&&str>) -> bool {
    let chinese = cell.chars().any(|one| ('\u{4E00}'..='\u{9FFF}').contains(&one));
    let fits = match name.rsplit('.').next() {
        // Words are put into sentences with half-width punctuation.
        Some("zh") => {
            (chinese || next == Some(&cell) || is_facts(cell)) && !cell.contains(['，', '（', '）', '：', '；'])
        }
        Some("en") => cell.chars().all(|one| one.is_ascii() || "±Ωµ×".contains(one)),
        _ => true,
    };
    fits && !cell.is_empty() && cell.trim() == cell
}

/// Returns the cells of a row in Rust, with commas between them, and its key.
fn row(columns: &[&str], cells: &[&str]) -> Result<(Key, String), String> {
    if cells.len() != columns.len() {
        return Err(format!("{} cells for {} columns", cells.len(), columns.len()));
    }
    let mut key = Key::default();
    let part = columns.iter().zip(cells).any(|(name, cell)| *name == "sub" && !cell.is_empty());
    let mut made = Vec::new();
    for (place, (name, cell)) in columns.iter().zip(cells).enumerate() {
        let fault = || format!("{name}: '{cell}' does not fit");
        let number = |text: &str, radix| i64::from_str_radix(text, radix).map_err(|_| fault());
        let hexadecimal = |text: &str, digits: &[usize]| match digits.contains(&text.len()) {
            true => number(text, 16),
            false => Err(fault()),
        };
        match *name {
            "index" | "range" | "code" => {
                let (first, last) = cell.split_once('-').filter(|_| *name == "range").unwrap_or((cell, cell));
                let digits: &[usize] = if *name == "code" { &[2, 4, 8] } else { &[4] };
                key.first.push(hexadecimal(first, digits)?);
                key.last.push(hexadecimal(last, digits)?);
                made.extend((!part).then(|| format!("0x{first}")));
                made.extend((!part && *name == "range").then(|| format!("0x{last}")));
            }
            "value" | "profile" => {
                key.first.push(number(cell, 10)?);
                key.last.push(number(cell, 10)?);
                made.push((*cell).to_owned());
            }
            "sub" if part => {
                key.sub = Some(number(cell, 10)?);
                made.push((*cell).to_owned());
            }
            "sub" => {}
            "type" => made.push(data_type(cell, part)),
            "codes" => made.push(format!("&[{}]", list(cell, |code| format!("Code::{}", camel(code))))),
            "names" => made.push(format!("&[{}]", list(cell, |name| format!("{name:?}")))),
            name if name.starts_with(char::is_uppercase) => made.push(format!("{name}::{cell}")),
            name => {
                if !fits(name, cell, cells.get(place + 1)) {
                    return Err(fault());
                }
                made.push(match name.split_once('.') {
                    Some((_, "zh")) => {
                        format!("Words {{ zh: {cell:?}, en: {:?} }}", cells.get(place + 1).unwrap_or(&""))
                    }
                    Some((_, "en")) => continue,
                    _ => format!("{cell:?}"),
                });
            }
        }
    }
    Ok((key, made.join(", ")))
}

/// Returns a data type as a variant; for a row that is not a part, its shape.
fn data_type(cell: &str, part: bool) -> String {
    match (cell, cell.strip_suffix("[]")) {
        _ if part => camel(cell),
        ("-", _) => "Own".to_owned(),
        ("RECORD", _) => "Record".to_owned(),
        (_, Some(of)) => format!("Array({})", camel(of)),
        _ => format!("Var({})", camel(cell)),
    }
}

/// Converts `TIME_OF_DAY` to `TimeOfDay`, and `SDO001` to `Sdo001`.
fn camel(name: &str) -> String {
    let word =
        |word: &str| word.chars().take(1).chain(word.chars().skip(1).map(|one| one.to_ascii_lowercase())).collect();
    name.split('_').map(word).collect::<Vec<String>>().concat()
}

/// Returns the sign `CODE ENDS` or `CODE ENDS LEAST` in Rust.
fn sign(text: &str) -> String {
    let mut words = text.split(' ');
    let (code, ends) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let least = words.next().unwrap_or("1");
    format!("Sign {{ code: Code::{}, ends: Ends::{ends}, least: {least} }}", camel(code))
}

/// Returns `8110` or `8100-82FF` in Rust.
fn range(text: &str) -> String {
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    format!("(0x{from}, 0x{to})")
}

/// Returns what has conditions, `CONDITION + CONDITION: ONE; ANOTHER`, in Rust.
fn conditional(cell: &str, inner: impl Fn(&str) -> String) -> String {
    let condition = |text: &str| match text.strip_prefix("has ") {
        Some(fact) => format!("When::Has({fact:?})"),
        None => format!("When::{text}"),
    };
    let one = |text: &str| {
        let (when, what) = text.split_once(": ").unwrap_or(("", text));
        let when: Vec<_> = when.split(" + ").filter(|text| !text.is_empty()).map(condition).collect();
        format!("(&[{}], {})", when.join(", "), inner(what))
    };
    cell.split("; ").filter(|text| !text.is_empty()).map(one).collect::<Vec<_>>().join(", ")
}

fn list(cell: &str, one: impl Fn(&str) -> String) -> String {
    cell.split(", ").filter(|text| !text.is_empty()).map(one).collect::<Vec<_>>().join(", ")
}
