//! Names and types of the fields of a PDO's message: what ROS allows, made of what a description says.

use crate::wire::pdo::mapping::Mapped;
use crate::words::{Lang, signal};
use crate::world::od::DataType;

/// Longest name, in bytes.
const LONGEST: usize = 60;

/// Words that are no names in the languages into which definitions are translated, and names that messages have
/// already. Sorted.
const RESERVED: &[&str] = &[
    "alignas",
    "alignof",
    "and",
    "and_eq",
    "as",
    "asm",
    "assert",
    "async",
    "auto",
    "await",
    "bitand",
    "bitor",
    "bool",
    "break",
    "byte",
    "case",
    "catch",
    "char",
    "class",
    "compl",
    "concept",
    "const",
    "constexpr",
    "continue",
    "decltype",
    "def",
    "default",
    "del",
    "delete",
    "do",
    "double",
    "elif",
    "else",
    "enum",
    "except",
    "explicit",
    "export",
    "extern",
    "false",
    "finally",
    "float",
    "for",
    "friend",
    "from",
    "global",
    "goto",
    "header",
    "if",
    "import",
    "in",
    "inline",
    "int",
    "is",
    "lambda",
    "long",
    "match",
    "mutable",
    "namespace",
    "new",
    "noexcept",
    "nonlocal",
    "not",
    "not_eq",
    "nullptr",
    "object",
    "operator",
    "or",
    "or_eq",
    "pass",
    "print",
    "private",
    "protected",
    "public",
    "raise",
    "register",
    "requires",
    "return",
    "self",
    "sequence",
    "short",
    "signed",
    "sizeof",
    "stamp",
    "static",
    "string",
    "struct",
    "switch",
    "template",
    "this",
    "throw",
    "true",
    "try",
    "type",
    "typedef",
    "typeid",
    "typename",
    "union",
    "unsigned",
    "using",
    "virtual",
    "void",
    "volatile",
    "while",
    "with",
    "wstring",
    "xor",
    "xor_eq",
    "yield",
];

/// The form of an entry's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FieldForm {
    /// `bool`.
    Bool,
    /// A whole number of so many bytes, with or without sign.
    Whole {
        /// 1, 2, 4 or 8.
        size: usize,
        /// True if it has a sign.
        signed: bool,
    },
    /// `float32`.
    Real32,
    /// `float64`: REAL64, and every number with a factor, which is applied.
    Real64,
    /// `uint8[]`: strings, dates, and what is longer than 64 bits.
    Bytes,
}

impl FieldForm {
    /// The form of an entry; `None` where it has no bits.
    pub(super) fn of(mapped: &Mapped) -> Option<Self> {
        use DataType as T;
        let bits = mapped.bits;
        let text = matches!(
            mapped.data_type,
            Some(T::VisibleString | T::OctetString | T::UnicodeString | T::Domain | T::TimeOfDay | T::TimeDifference)
        );
        let scaled = mapped.factor != 1.0;
        Some(match (mapped.data_type, bits) {
            (_, 0) => return None,
            (_, 65..) => Self::Bytes,
            _ if text => Self::Bytes,
            _ if scaled => Self::Real64,
            (Some(T::Boolean), 1) => Self::Bool,
            (Some(T::Real32), 32) => Self::Real32,
            (Some(T::Real64), 64) => Self::Real64,
            (data_type, bits) => {
                let size = usize::from(bits).div_ceil(8).next_power_of_two();
                Self::Whole { size, signed: data_type.is_some_and(is_signed) }
            }
        })
    }

    /// The type in a definition.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Whole { size: 1, signed: true } => "int8",
            Self::Whole { size: 2, signed: true } => "int16",
            Self::Whole { size: 4, signed: true } => "int32",
            Self::Whole { signed: true, .. } => "int64",
            Self::Whole { size: 1, .. } => "uint8",
            Self::Whole { size: 2, .. } => "uint16",
            Self::Whole { size: 4, .. } => "uint32",
            Self::Whole { .. } => "uint64",
            Self::Real32 => "float32",
            Self::Real64 => "float64",
            Self::Bytes => "uint8[]",
        }
    }
}

fn is_signed(data_type: DataType) -> bool {
    data_type.name().starts_with("INTEGER")
}

/// The name of an entry's field: that of the object in small letters, `velocity_actual_value`, or where that has no
/// letters that ROS allows `object_6041_00`. `taken` are the names before it, of which it becomes one.
pub(super) fn name(mapped: &Mapped, taken: &mut Vec<String>) -> String {
    let mut shown = Vec::new();
    if signal::has_name(Lang::En, mapped) {
        signal::name(&mut shown, Lang::En, mapped);
    }
    let mut name = snake(&shown);
    if name.is_empty() {
        name = format!("object_{:04x}_{:02x}", mapped.index, mapped.sub);
    } else if name.starts_with(|c: char| c.is_ascii_digit()) || RESERVED.binary_search(&&*name).is_ok() {
        name.insert_str(0, "signal_");
    }
    unique(name, taken)
}

/// A name that is not among `taken`, of which it becomes one.
pub(super) fn unique(name: String, taken: &mut Vec<String>) -> String {
    let mut free = name.clone();
    let mut number = 2;
    while taken.contains(&free) {
        free = format!("{name}_{number}");
        number += 1;
    }
    taken.push(free.clone());
    free
}

/// Small letters and digits, with one underscore for all between them. Empty where letters of other scripts would be
/// lost: what is left then is no name.
fn snake(shown: &[u8]) -> String {
    let text = String::from_utf8_lossy(shown);
    if text.chars().any(|c| !c.is_ascii() && c.is_alphabetic()) {
        return String::new();
    }
    let mut name = String::new();
    let mut before = ' ';
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            // `TargetPosition`: a capital behind a small letter begins a word.
            if c.is_ascii_uppercase() && before.is_ascii_lowercase() && !name.ends_with('_') {
                name.push('_');
            }
            name.push(c.to_ascii_lowercase());
        } else if !name.is_empty() && !name.ends_with('_') {
            name.push('_');
        }
        before = c;
    }
    name.truncate(LONGEST);
    name.truncate(name.trim_end_matches('_').len());
    name
}

/// A name as part of a type's: letters and digits, each word with a capital: `can0` is `Can0`.
pub(super) fn camel(given: &str) -> String {
    let mut name = String::new();
    for word in given.split(|c: char| !c.is_ascii_alphanumeric()) {
        let mut letters = word.chars();
        name.extend(letters.next().map(|c| c.to_ascii_uppercase()));
        name.extend(letters);
    }
    if !name.starts_with(|c: char| c.is_ascii_uppercase()) {
        name.insert_str(0, "Bus");
    }
    name
}

/// A comment in a definition: one line, whatever stands in the description.
pub(super) fn comment(out: &mut String, words: &[u8]) {
    let text = String::from_utf8_lossy(words);
    out.extend(text.chars().map(|c| if c.is_control() { ' ' } else { c }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::pdo::mapping::Mapping;
    use std::sync::Arc;

    fn entry(word: u32, name: &str, data_type: Option<DataType>) -> Mapped {
        let mut entries = Mapping::from_words(&[word]).entries;
        let mut mapped = entries.remove(0);
        mapped.name = (!name.is_empty()).then(|| Arc::from(name));
        mapped.data_type = data_type;
        mapped
    }

    #[test]
    fn names_that_ros_allows() {
        const LONG: &str = "the temperature of the motor as measured by the sensor in its winding";
        let mut taken = Vec::new();
        let mut named = |word, given| name(&entry(word, given, None), &mut taken);
        assert_eq!(named(0x2000_0110, "Motor temperature [°C]"), "motor_temperature_c");
        assert_eq!(named(0x2000_0210, "TargetPosition"), "target_position");
        assert_eq!(named(0x2000_0310, "Target Position"), "target_position_2");
        assert_eq!(named(0x2000_0410, "3 phase__current_"), "signal_3_phase_current");
        assert_eq!(named(0x2000_0510, "class"), "signal_class");
        assert_eq!(named(0x2000_0610, "Header"), "signal_header");
        assert_eq!(named(0x2000_0710, "\u{7535}\u{673A}"), "object_2000_07");
        assert_eq!(named(0x2000_0810, "-- !"), "object_2000_08");
        assert_eq!(named(0x2000_0910, ""), "object_2000_09");
        assert_eq!(named(0x2000_0A10, "DI1State"), "di1state");
        assert_eq!(named(0x2000_0B10, LONG).len(), LONGEST);
        assert_eq!(named(0x2000_0C10, "a\n# b\u{202e}c"), "a_x0a_b_u_202e_c");
    }

    #[test]
    fn reserved_words_are_sorted() {
        assert!(RESERVED.is_sorted());
    }

    #[test]
    fn forms() {
        use DataType as T;
        let form = |bits: u32, data_type| FieldForm::of(&entry(0x2000_0000 | bits, "", data_type)).map(FieldForm::name);
        assert_eq!(form(0, None), None);
        assert_eq!(form(1, Some(T::Boolean)), Some("bool"));
        assert_eq!(form(8, Some(T::Boolean)), Some("uint8"));
        assert_eq!(form(8, Some(T::Integer8)), Some("int8"));
        assert_eq!(form(12, Some(T::Integer16)), Some("int16"));
        assert_eq!(form(24, Some(T::Integer24)), Some("int32"));
        assert_eq!(form(40, Some(T::Unsigned40)), Some("uint64"));
        assert_eq!(form(3, None), Some("uint8"));
        assert_eq!(form(32, Some(T::Real32)), Some("float32"));
        assert_eq!(form(16, Some(T::Real32)), Some("uint16"));
        assert_eq!(form(64, Some(T::Real64)), Some("float64"));
        assert_eq!(form(64, Some(T::VisibleString)), Some("uint8[]"));
        assert_eq!(form(128, None), Some("uint8[]"));
        let scaled = Mapped { factor: 0.1, ..entry(0x2000_0010, "", Some(T::Integer16)) };
        assert_eq!(FieldForm::of(&scaled).map(FieldForm::name), Some("float64"));
    }

    #[test]
    fn types() {
        assert_eq!(camel("can0"), "Can0");
        assert_eq!(camel("my-bus 2"), "MyBus2");
        assert_eq!(camel("2"), "Bus2");
        assert_eq!(camel("\u{603B}"), "Bus");
    }
}
