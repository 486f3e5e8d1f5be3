//! Message definitions of ROS (`ros2msg`, `ros1msg`): a text of fields, and after lines of `=` those of the types that
//! they use.
//!
//! Constants, defaults and comments are skipped.

use std::collections::BTreeMap;

/// A definition with those it uses, by type name without `/msg/`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Definitions {
    pub(super) fields: Vec<Field>,
    others: BTreeMap<String, Vec<Field>>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) many: Many,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A number of `size` bytes. `integer`: not a float or bool.
    Number { size: u8, integer: bool },
    /// A text in bytes.
    Text,
    /// Another type, with its package.
    Message(String),
    /// A type of unknown size.
    Unknown,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Many {
    One,
    Fixed(u32),
    /// A sequence after its length, with an optional maximum.
    Sequence(Option<u32>),
}

/// Maximum number of fields of a definition; further ones are cut off.
const MOST_FIELDS: usize = 512;
/// Maximum number of definitions of one text.
const MOST_TYPES: usize = 256;

/// Types that every definition may use without including them.
const BUILT_IN: &[(&str, &str)] = &[
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
];
const BUILT_IN_ROS1: &[(&str, &str)] = &[("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id")];

impl Definitions {
    /// Parses the definition of a type of this name. Lines without a field are skipped.
    pub(super) fn read(name: &str, text: &str, ros1: bool) -> Self {
        let mut others = BTreeMap::new();
        for (name, text) in if ros1 { BUILT_IN_ROS1 } else { BUILT_IN } {
            others.insert((*name).to_owned(), fields(text.lines(), name));
        }
        let mut parts: Vec<(String, Vec<&str>)> = vec![(plain(name), Vec::new())];
        let mut lines = text.lines().map(str::trim).peekable();
        while let Some(line) = lines.next() {
            let rule = line.len() >= 3 && line.bytes().all(|byte| byte == b'=');
            match lines.peek().and_then(|next| next.strip_prefix("MSG:")) {
                Some(next) if rule && parts.len() < MOST_TYPES => {
                    parts.push((plain(next.trim()), Vec::new()));
                    lines.next();
                }
                _ => {
                    if let Some((_, part)) = parts.last_mut() {
                        part.push(line);
                    }
                }
            }
        }
        let mut parts = parts.into_iter().map(|(name, lines)| (fields(lines.into_iter(), &name), name));
        let own = parts.next().map(|(fields, _)| fields).unwrap_or_default();
        others.extend(parts.map(|(fields, name)| (name, fields)));
        Self { fields: own, others }
    }

    /// Returns the fields of a nested type.
    pub(super) fn of(&self, name: &str) -> Option<&[Field]> {
        self.others.get(name).map(Vec::as_slice)
    }
}

/// Returns the name of a type in the form `package/Type`: without `/msg/`, decorations of DDS and blanks.
pub(super) fn plain(name: &str) -> String {
    let name = name.trim().replace("::", "/").replace("/msg/dds_/", "/").replace("/msg/", "/");
    name.trim_end_matches('_').to_owned()
}

fn fields<'a>(lines: impl Iterator<Item = &'a str>, owner: &str) -> Vec<Field> {
    let package = owner.split('/').next().unwrap_or_default();
    lines.filter_map(|line| field(line, package)).take(MOST_FIELDS).collect()
}

fn field(line: &str, package: &str) -> Option<Field> {
    let line = line.split('#').next().unwrap_or_default();
    let mut words = line.split_ascii_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    // A constant: `uint8 X=1`, `uint8 X = 1`.
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return None;
    }
    let (kind, many) = match kind.split_once('[') {
        None => (kind, Many::One),
        Some((kind, count)) => {
            let count = count.strip_suffix(']')?;
            let many = match count.strip_prefix("<=") {
                _ if count.is_empty() => Many::Sequence(None),
                Some(most) => Many::Sequence(Some(most.parse().ok()?)),
                None => Many::Fixed(count.parse().ok()?),
            };
            (kind, many)
        }
    };
    let number = |size, integer| Kind::Number { size, integer };
    let kind = match kind.split("<=").next().unwrap_or(kind) {
        "bool" => number(1, false),
        "byte" | "char" | "int8" | "uint8" => number(1, true),
        "int16" | "uint16" => number(2, true),
        "int32" | "uint32" => number(4, true),
        "int64" | "uint64" => number(8, true),
        "float32" => number(4, false),
        "float64" => number(8, false),
        "string" => Kind::Text,
        "wstring" => Kind::Unknown,
        "time" | "duration" => Kind::Message(kind.to_owned()),
        "Header" => Kind::Message("std_msgs/Header".to_owned()),
        kind if kind.contains('/') => Kind::Message(plain(kind)),
        kind => Kind::Message(format!("{package}/{kind}")),
    };
    Some(Field { name: name.to_owned(), kind, many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition() {
        let text = "# comment\nstd_msgs/msg/Header header # more\nuint8 A=1\nuint8 B = 2\nuint32 id 5\nuint8[<=64] data\n\
                    string<=10 name\nuint8[8] raw\nPart[] parts\n=====\nMSG: x_msgs/msg/Part\nuint16 y\n";
        let read = Definitions::read("x_msgs/msg/Whole", text, false);
        let shown: Vec<_> = read.fields.iter().map(|field| (field.name.as_str(), &field.kind, field.many)).collect();
        let message = |name: &str| Kind::Message(name.to_owned());
        let number = |size| Kind::Number { size, integer: true };
        assert_eq!(
            shown,
            [
                ("header", &message("std_msgs/Header"), Many::One),
                ("id", &number(4), Many::One),
                ("data", &number(1), Many::Sequence(Some(64))),
                ("name", &Kind::Text, Many::One),
                ("raw", &number(1), Many::Fixed(8)),
                ("parts", &message("x_msgs/Part"), Many::Sequence(None)),
            ]
        );
        assert_eq!(read.of("x_msgs/Part").map(<[Field]>::len), Some(1));
        assert_eq!(read.of("std_msgs/Header").map(<[Field]>::len), Some(2));
        assert_eq!(plain("can_msgs::msg::dds_::Frame_"), "can_msgs/Frame");
    }
}
