//! How a frame is read from messages of a type: the fields found once, then the steps through each message.
//!
//! A type is read by its fields, known or not by name: an identifier and data, and a sign that it is CAN. The steps end
//! behind the last field that is wanted. `can_msgs/Frame` and `ros2_socketcan_msgs/FdFrame` have readers of their own,
//! in `layout`, taken where the steps are theirs exactly.

use std::sync::OnceLock;

use super::bytes::Wire;
use super::choice::Role;
use super::fields::{BusField, Fields};
use super::layout;
use super::schema::{Definitions, Field, Kind, Many};

/// Types that are known, where a file does not bring their definition along (or in a language that is not read).
const KNOWN: &[(&str, &str)] = &[
    ("can_msgs/Frame", layout::CAN_FRAME),
    ("ros2_socketcan_msgs/FdFrame", layout::FD_FRAME),
    (
        "dataspeed_can_msgs/Frame",
        "std_msgs/Header header\nuint32 id\nbool extended\nbool fdf\nbool brs\nbool esi\nbool rtr\nuint8[<=64] data",
    ),
];

/// Names of fields, by what they are. The first that is there counts.
const ALIASES: &[(Role, &[&str])] = &[
    (Role::Id, &["can_id", "arbitration_id", "id", "message_id", "frame_id"]),
    (Role::Data, &["data", "payload", "bytes"]),
    (Role::Ext, &["is_extended", "extended", "is_ext", "ide", "is_extended_id"]),
    (Role::Rtr, &["is_rtr", "rtr", "is_remote", "is_remote_frame"]),
    (Role::Err, &["is_error", "error", "err", "is_error_frame"]),
    (Role::Len, &["dlc", "len", "size", "length", "data_length"]),
    (Role::Fd, &["fdf", "is_fd", "fd"]),
    (Role::Brs, &["brs", "bitrate_switch"]),
    (Role::Esi, &["esi", "error_state_indicator"]),
    (Role::Bus, &["bus", "channel", "interface", "can_interface_id"]),
];
/// Fields that only CAN frames have: one of them makes an identifier with data a frame.
const SIGNS: &[&str] = &[
    "can_id",
    "arbitration_id",
    "is_extended",
    "extended",
    "is_ext",
    "ide",
    "is_extended_id",
    "is_rtr",
    "rtr",
    "dlc",
    "fdf",
    "is_fd",
    "brs",
    "esi",
];
/// Types in types, at most; and steps of all of them.
const DEPTH: usize = 8;
const MOST_STEPS: usize = 1024;

/// One step through a message.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    /// Numbers of this size, so many.
    Pass { size: u8, count: u32 },
    /// A sequence of numbers of this size.
    PassSequence { size: u8 },
    /// A text.
    PassText,
    /// So many times, or as often as the message says.
    Repeat { count: Option<u32>, steps: Vec<Step> },
    /// A number that is wanted.
    Number { size: u8, role: Role },
    /// Seconds and nanoseconds.
    Stamp,
    /// A text that is wanted: the bus.
    Text,
    /// The payload: an array, or a sequence.
    Data { count: Option<u32> },
}

/// How messages of one type are read.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    wire: Wire,
    steps: Vec<Step>,
    fast: Option<layout::Layout>,
    fd: Option<bool>,
    len_is_code: bool,
    /// For people: `id=id data=data`.
    pub(super) read_as: String,
}

/// A field that is wanted, by its path from the message: the numbers of fields.
type Wanted = (Vec<usize>, Role);

impl Plan {
    /// The plan for a type of this name; `None` where its messages are no frames. `asked`: fields the user named.
    pub(super) fn new(name: &str, text: Option<&str>, wire: Wire, asked: &[(Role, &str)]) -> Option<Self> {
        let text = text.filter(|text| !text.trim().is_empty());
        let text = text.or_else(|| KNOWN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text))?;
        let definitions = Definitions::read(name, text, wire == Wire::Ros1);
        let mut wanted = Vec::new();
        if !group(&definitions, &definitions.fields, &mut Vec::new(), asked, &mut wanted) {
            return None;
        }
        stamp(&definitions, asked, &mut wanted);
        let mut made = Making { definitions: &definitions, wanted: &wanted, found: 0, steps: 0 };
        let steps = made.steps(&definitions.fields, &mut Vec::new())?;
        let names: Vec<String> = Role::NAMES
            .iter()
            .filter_map(|(word, role)| {
                let (path, _) = wanted.iter().find(|(_, wanted)| wanted == role)?;
                Some(format!("{word}={}", path_name(&definitions, path)))
            })
            .collect();
        let kind = name.rsplit('/').next().unwrap_or(name).to_ascii_lowercase();
        let has_fd = wanted.iter().any(|(_, role)| *role == Role::Fd);
        let len_is_code = names.iter().any(|name| name.ends_with("dlc"));
        let fd = (!has_fd && kind.contains("fd")).then_some(true);
        let mut plan = Self { wire, steps, fast: None, fd, len_is_code, read_as: names.join(" ") };
        plan.fast = layout::Layout::ALL.into_iter().find(|layout| {
            let (name, text) = layout.definition();
            fd == layout.fd() && own_steps(*layout, name, text, wire) == Some(plan.steps.as_slice())
        });
        Some(plan)
    }

    /// The fields of a message; `None` where it is shorter than its type.
    #[inline(always)]
    pub(super) fn read<'a>(&self, message: &'a [u8]) -> Option<Fields<'a>> {
        if let Some(layout) = self.fast
            && let Some(fields) = layout.read(self.wire, message)
        {
            return Some(fields);
        }
        self.by_steps(message)
    }

    /// Whether [`layout::plain`] may read its messages.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        self.fast == Some(layout::Layout::Can) && self.wire == Wire::Cdr
    }

    #[cfg(test)]
    pub(super) fn is_by_hand(&self) -> bool {
        self.fast.is_some()
    }

    pub(super) fn by_steps<'a>(&self, message: &'a [u8]) -> Option<Fields<'a>> {
        let mut fields = Fields { fd: self.fd, len_is_code: self.len_is_code, ..Fields::default() };
        let mut at = match self.wire {
            Wire::Ros1 => At { body: message, at: 0, align: 1, big: false },
            Wire::Cdr => {
                let (head, body) = message.split_first_chunk::<4>()?;
                let (big, align) = match head {
                    [0, 0, ..] => (true, 8),
                    [0, 1, ..] => (false, 8),
                    [0, 6, ..] => (true, 4),
                    [0, 7, ..] => (false, 4),
                    _ => return None,
                };
                At { body, at: 0, align, big }
            }
        };
        run(&self.steps, &mut at, &mut fields)?;
        Some(fields)
    }
}

/// Whether a type of this name holds CAN frames, as far as is known.
pub(super) fn is_known(name: &str) -> bool {
    KNOWN.iter().any(|(known, _)| *known == name)
}

/// The steps of a definition of our own, found out once.
fn own_steps(layout: layout::Layout, name: &str, text: &str, wire: Wire) -> Option<&'static [Step]> {
    type Steps = OnceLock<Option<Vec<Step>>>;
    static STEPS: [[Steps; 2]; 2] = [const { [const { OnceLock::new() }; 2] }; 2];
    let of_layout = STEPS.get(usize::from(layout == layout::Layout::Fd))?;
    let own = of_layout.get(usize::from(wire == Wire::Ros1))?;
    own.get_or_init(|| steps_of(name, text, wire)).as_deref()
}

fn steps_of(name: &str, text: &str, wire: Wire) -> Option<Vec<Step>> {
    let definitions = Definitions::read(name, text, wire == Wire::Ros1);
    let mut wanted = Vec::new();
    group(&definitions, &definitions.fields, &mut Vec::new(), &[], &mut wanted);
    stamp(&definitions, &[], &mut wanted);
    Making { definitions: &definitions, wanted: &wanted, found: 0, steps: 0 }
        .steps(&definitions.fields, &mut Vec::new())
}

/// Finds the fields of a frame: in the message itself, else in the first type in it that has them.
fn group(
    definitions: &Definitions,
    fields: &[Field],
    path: &mut Vec<usize>,
    asked: &[(Role, &str)],
    wanted: &mut Vec<Wanted>,
) -> bool {
    let mut found: Vec<(usize, Role)> = Vec::new();
    for (role, aliases) in ALIASES {
        let fits = |name: &&str| fields.iter().position(|field| field.name == *name && can_be(field, *role));
        let own = asked.iter().find(|(of, _)| of == role).map(|(_, name)| *name);
        let at = match own {
            Some(name) => {
                let prefix = path_name(definitions, path);
                let within = name.strip_prefix(&prefix).map(|rest| rest.trim_start_matches('.')).unwrap_or(name);
                fields.iter().position(|field| field.name == within && can_be_asked(field, *role))
            }
            None => aliases.iter().find_map(fits),
        };
        found.extend(at.map(|at| (at, *role)));
    }
    let has = |role| found.iter().any(|(_, found)| *found == role);
    let named = asked.iter().any(|(role, _)| matches!(role, Role::Id | Role::Data));
    let sign = found.iter().any(|(at, _)| fields.get(*at).is_some_and(|field| SIGNS.contains(&field.name.as_str())));
    if has(Role::Id) && has(Role::Data) && (named || sign) {
        wanted.extend(found.into_iter().map(|(at, role)| ([path.as_slice(), &[at]].concat(), role)));
        return true;
    }
    if path.len() + 1 >= DEPTH {
        return false;
    }
    for (at, field) in fields.iter().enumerate() {
        if let (Kind::Message(name), Many::One) = (&field.kind, field.many)
            && let Some(inner) = definitions.of(name)
        {
            path.push(at);
            let fine = group(definitions, inner, path, asked, wanted);
            path.pop();
            if fine {
                return true;
            }
        }
    }
    false
}

fn can_be(field: &Field, role: Role) -> bool {
    match (role, &field.kind, field.many) {
        (Role::Id, Kind::Number { size, integer: true }, Many::One) => *size >= 2,
        (Role::Data, Kind::Number { size: 1, integer: true }, Many::Fixed(count)) => count <= 64,
        (Role::Data, Kind::Number { size: 1, integer: true }, Many::Sequence(most)) => {
            most.is_none_or(|most| most <= 64)
        }
        (Role::Bus, Kind::Text, Many::One) => true,
        (Role::Id | Role::Data, ..) => false,
        (Role::Len | Role::Bus, Kind::Number { integer, .. }, Many::One) => *integer,
        (_, Kind::Number { .. }, Many::One) => true,
        _ => false,
    }
}

fn can_be_asked(field: &Field, role: Role) -> bool {
    let bytes = matches!((&field.kind, field.many), (Kind::Number { size: 1, .. }, Many::Fixed(_) | Many::Sequence(_)));
    let number = matches!((&field.kind, field.many), (Kind::Number { integer: true, .. }, Many::One));
    match role {
        Role::Data => bytes,
        Role::Id => number,
        _ => can_be(field, role),
    }
}

/// Finds the driver's time: in a header, else beside the other fields.
fn stamp(definitions: &Definitions, asked: &[(Role, &str)], wanted: &mut Vec<Wanted>) {
    let own = asked.iter().find(|(role, _)| *role == Role::Stamp).map(|(_, name)| *name);
    for (at, field) in definitions.fields.iter().enumerate() {
        let (Kind::Message(name), Many::One) = (&field.kind, field.many) else { continue };
        let called = own.map_or(matches!(field.name.as_str(), "stamp" | "timestamp" | "time"), |own| own == field.name);
        if is_time(name) && called {
            return wanted.push((vec![at], Role::Stamp));
        }
        let inner = definitions.of(name).unwrap_or_default();
        let within = inner.iter().position(|inner| match (&inner.kind, own) {
            (Kind::Message(kind), None) => name == "std_msgs/Header" && is_time(kind),
            (Kind::Message(kind), Some(own)) => is_time(kind) && own == format!("{}.{}", field.name, inner.name),
            _ => false,
        });
        if let Some(within) = within {
            return wanted.push((vec![at, within], Role::Stamp));
        }
    }
}

fn is_time(name: &str) -> bool {
    matches!(name, "builtin_interfaces/Time" | "time")
}

fn path_name(definitions: &Definitions, path: &[usize]) -> String {
    let mut fields = definitions.fields.as_slice();
    let mut names = Vec::new();
    for at in path {
        let Some(field) = fields.get(*at) else { break };
        names.push(field.name.as_str());
        fields = match &field.kind {
            Kind::Message(name) => definitions.of(name).unwrap_or_default(),
            _ => &[],
        };
    }
    names.join(".")
}

/// The making of steps.
struct Making<'a> {
    definitions: &'a Definitions,
    wanted: &'a [Wanted],
    found: usize,
    steps: usize,
}

impl Making<'_> {
    /// The steps through these fields, up to the last that is wanted; `None` where that cannot be.
    fn steps(&mut self, fields: &[Field], path: &mut Vec<usize>) -> Option<Vec<Step>> {
        if path.len() > DEPTH {
            return None;
        }
        let mut steps = Vec::new();
        for (at, field) in fields.iter().enumerate() {
            if self.found == self.wanted.len() {
                break;
            }
            path.push(at);
            self.field(field, path, &mut steps)?;
            path.pop();
            self.steps += 1;
            if self.steps > MOST_STEPS {
                return None;
            }
        }
        Some(steps)
    }

    fn field(&mut self, field: &Field, path: &mut Vec<usize>, steps: &mut Vec<Step>) -> Option<()> {
        let role = self.wanted.iter().find(|(wanted, _)| wanted == path).map(|(_, role)| *role);
        self.found += usize::from(role.is_some());
        let count = match field.many {
            Many::One => Some(1),
            Many::Fixed(count) => Some(count),
            Many::Sequence(_) => None,
        };
        let step = match (&field.kind, role) {
            (Kind::Unknown, _) => return None,
            (_, Some(Role::Stamp)) => Step::Stamp,
            (Kind::Text, Some(_)) => Step::Text,
            (Kind::Number { .. }, Some(Role::Data)) => Step::Data { count },
            (Kind::Number { size, .. }, Some(role)) => Step::Number { size: *size, role },
            (Kind::Number { size, .. }, None) => match count {
                Some(count) => Step::Pass { size: *size, count },
                None => Step::PassSequence { size: *size },
            },
            (Kind::Text, None) if field.many == Many::One => Step::PassText,
            (Kind::Text, None) => Step::Repeat { count, steps: vec![Step::PassText] },
            (Kind::Message(name), _) => {
                let inner = match name.as_str() {
                    "time" | "duration" => vec![Step::Pass { size: 4, count: 2 }],
                    name => {
                        let inner = self.definitions.of(name)?;
                        self.steps(inner, path)?
                    }
                };
                if field.many == Many::One {
                    steps.extend(inner);
                    return Some(());
                }
                // Of a type without fields there is nothing to pass over.
                if inner.is_empty() {
                    return None;
                }
                Step::Repeat { count, steps: inner }
            }
        };
        steps.push(step);
        Some(())
    }
}

/// A place in a message.
#[derive(Clone, Copy)]
struct At<'a> {
    body: &'a [u8],
    at: usize,
    /// Numbers are aligned to their size, but to no more than this.
    align: usize,
    big: bool,
}

impl<'a> At<'a> {
    fn align(&mut self, size: usize) {
        let to = size.min(self.align);
        if to > 1 {
            self.at = self.at.next_multiple_of(to);
        }
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.body.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    fn number(&mut self, size: u8) -> Option<u64> {
        self.align(usize::from(size));
        let bytes = self.take(usize::from(size))?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(if self.big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) })
    }

    fn pass(&mut self, size: u8, count: u64) -> Option<()> {
        if count > 0 {
            self.align(usize::from(size));
        }
        self.take(usize::try_from(count).ok()?.checked_mul(usize::from(size))?).map(|_| ())
    }

    /// A text, without the zero that CDR ends it with.
    fn text(&mut self) -> Option<&'a [u8]> {
        let len = self.number(4)?;
        let text = self.take(usize::try_from(len).ok()?)?;
        Some(text.strip_suffix(&[0]).unwrap_or(text))
    }
}

fn run<'a>(steps: &[Step], at: &mut At<'a>, fields: &mut Fields<'a>) -> Option<()> {
    for step in steps {
        match step {
            Step::Pass { size, count } => at.pass(*size, u64::from(*count))?,
            Step::PassSequence { size } => {
                let count = at.number(4)?;
                at.pass(*size, count)?;
            }
            Step::PassText => {
                at.text()?;
            }
            Step::Repeat { count, steps } => {
                let count = match count {
                    Some(count) => u64::from(*count),
                    None => at.number(4)?,
                };
                // Every round takes at least a byte, so the message ends before the count does any harm.
                for _ in 0..count {
                    let before = at.at;
                    run(steps, at, fields)?;
                    if at.at == before {
                        break;
                    }
                }
            }
            Step::Number { size, role } => {
                let value = at.number(*size)?;
                match role {
                    Role::Id => fields.id = value,
                    Role::Ext => fields.ext = value != 0,
                    Role::Rtr => fields.rtr = value != 0,
                    Role::Err => fields.err = value != 0,
                    Role::Len => fields.len = Some(value),
                    Role::Fd => fields.fd = Some(value != 0),
                    Role::Brs => fields.brs = value != 0,
                    Role::Esi => fields.esi = value != 0,
                    Role::Bus => fields.bus = Some(BusField::Number(value)),
                    Role::Data | Role::Stamp => {}
                }
            }
            Step::Stamp => {
                let (seconds, ns) = (at.number(4)? as u32, at.number(4)?);
                fields.stamp_ns = Some(layout::nanoseconds(seconds, ns as u32));
            }
            Step::Text => fields.bus = Some(BusField::Name(at.text()?)),
            Step::Data { count } => {
                let count = match count {
                    Some(count) => u64::from(*count),
                    None => at.number(4)?,
                };
                fields.data = at.take(usize::try_from(count).ok()?)?;
            }
        }
    }
    Some(())
}
