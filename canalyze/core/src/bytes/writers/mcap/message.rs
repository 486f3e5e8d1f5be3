//! ROS messages, declared once: each field with its comment, name and value. The type is that of the value; definition and
//! CDR follow.

use super::cdr::Cdr;

/// The contained types of a message with a header. Readers decode by the definitions in the file, so each includes every
/// type that its message contains.
const CONTAINED: &str = "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Returns the complete definition of a message with these fields, the first of which is a header or a time.
pub(super) fn whole(fields: &str) -> String {
    [fields, CONTAINED].concat()
}

/// A value of a field.
pub(super) trait RosValue {
    /// The type in definitions.
    const TYPE: &'static str;
    /// Appends itself.
    fn append(self, cdr: &mut Cdr);
}

/// Declares types: each in Rust, in ROS, and the method of [`Cdr`].
macro_rules! types {
    ($($rust:ty, $ros:literal, |$cdr:ident, $value:pat_param| $append:expr;)*) => {$(
        impl RosValue for $rust {
            const TYPE: &'static str = $ros;
            fn append(self, $cdr: &mut Cdr) {
                let $value = self;
                $append;
            }
        }
    )*};
}

/// The standard header: a time in ns, and the name of a bus.
pub(super) struct Header<'a>(pub(super) u64, pub(super) &'a str);
/// A time in ns.
pub(super) struct Time(pub(super) u64);
/// At most 64 bytes.
pub(super) struct AtMost64<'a>(pub(super) &'a [u8]);
/// Bytes that are no text.
pub(super) struct Octets<'a>(pub(super) &'a [u8]);

types! {
    Header<'_>, "std_msgs/Header", |cdr, Header(time, bus)| cdr.header(time, bus.as_bytes());
    Time, "builtin_interfaces/Time", |cdr, Time(time)| cdr.time(time);
    bool, "bool", |cdr, yes| cdr.bool(yes);
    u8, "uint8", |cdr, number| cdr.u8(number);
    u16, "uint16", |cdr, number| cdr.u16(number);
    u32, "uint32", |cdr, number| cdr.u32(number);
    u64, "uint64", |cdr, number| cdr.u64(number);
    f64, "float64", |cdr, number| cdr.f64(number);
    &str, "string", |cdr, text| cdr.string(text.as_bytes());
    &[u8], "string", |cdr, text| cdr.string(text);
    [u8; 5], "uint8[5]", |cdr, bytes| cdr.array(&bytes);
    [u8; 8], "uint8[8]", |cdr, bytes| cdr.array(&bytes);
    AtMost64<'_>, "uint8[<=64]", |cdr, AtMost64(bytes)| cdr.sequence(bytes);
    Octets<'_>, "uint8[]", |cdr, Octets(bytes)| cdr.sequence(bytes);
}

/// The values of a message, a pair of the first one and the rest.
pub(super) trait RosValues {
    /// Appends the definitions of their fields, each a comment and a name.
    fn define(fields: &[[&str; 2]], out: &mut String);
    /// Appends them.
    fn append(self, cdr: &mut Cdr);
}

impl RosValues for () {
    fn define(_: &[[&str; 2]], _: &mut String) {}
    fn append(self, _: &mut Cdr) {}
}

impl<V: RosValue, R: RosValues> RosValues for (V, R) {
    fn define(fields: &[[&str; 2]], out: &mut String) {
        let [[comment, name], rest @ ..] = fields else { return };
        out.extend([comment, V::TYPE, " ", name, "\n"]);
        R::define(rest, out);
    }

    fn append(self, cdr: &mut Cdr) {
        let (value, rest) = self;
        value.append(cdr);
        rest.append(cdr);
    }
}

/// A message; see [`message`].
pub(super) struct RosMessage<V> {
    /// `package/msg/Name`.
    pub(super) name: &'static str,
    /// Comments and constants before the fields.
    pub(super) head: &'static str,
    /// Comments and names of the fields.
    pub(super) fields: &'static [[&'static str; 2]],
    /// Values of the fields.
    pub(super) values: V,
}

impl<V: RosValues> RosMessage<V> {
    /// Returns the complete definition.
    pub(super) fn definition(&self) -> String {
        let mut text = self.head.to_owned();
        V::define(self.fields, &mut text);
        whole(&text)
    }
}

/// Declares a message: `message! { "package/msg/Name" { field: value, ... } }`. Doc comments are comments of the
/// definition; constants may be before the fields. The first field is a [`Header`] or a [`Time`].
macro_rules! message {
    ($(#[doc = $head:literal])* $name:literal $($constants:literal)? {
        $($(#[doc = $doc:literal])* $field:ident: $value:expr),* $(,)?
    }) => {
        $crate::bytes::writers::mcap::message::RosMessage {
            name: $name,
            head: concat!($("#", $head, "\n",)* $($constants)?),
            fields: const { &[$([concat!($("#", $doc, "\n"),*), stringify!($field)]),*] },
            values: $crate::bytes::writers::mcap::message::message!(@values $($value,)*),
        }
    };
    (@values) => { () };
    (@values $value:expr, $($rest:expr,)*) => {
        ($value, $crate::bytes::writers::mcap::message::message!(@values $($rest,)*))
    };
}
pub(super) use message;
