//! The way to read frames from the messages of a type: its fields are found once, then each message is read in steps.
//!
//! The fields are those of a type known by its name, or those that the user names; all of them have to be present. The
//! steps end after the last of them. `can_msgs/Frame` and `ros2_socketcan_msgs/FdFrame` have faster readers in
//! `layout`, used if the steps are the same.

use super::bytes::Wire;
use super::choice::Role;
use super::fields::{BusField, Fields};
use super::layout::{self, Layout};
use super::schema::{Definitions, Field, Kind, Many};

/// A known type of frames.
struct KnownType {
    name: &'static str,
    /// Its definition, for files without one (or in a language that is not supported).
    text: &'static str,
    fields: &'static [(Role, &'static str)],
    layout: Option<Layout>,
    fd: Option<bool>,
}

const CAN_FIELDS: &[(Role, &str)] = &[
    (Role::Id, "id"),
    (Role::Ext, "is_extended"),
    (Role::Rtr, "is_rtr"),
    (Role::Err, "is_error"),
    (Role::Len, "dlc"),
    (Role::Data, "data"),
];
const FD_FIELDS: &[(Role, &str)] =
    &[(Role::Id, "id"), (Role::Ext, "is_extended"), (Role::Err, "is_error"), (Role::Len, "len"), (Role::Data, "data")];
const DATASPEED: &str =
    "std_msgs/Header header\nuint32 id\nbool extended\nbool fdf\nbool brs\nbool esi\nbool rtr\nuint8[<=64] data";
const DATASPEED_FIELDS: &[(Role, &str)] = &[
    (Role::Id, "id"),
    (Role::Ext, "extended"),
    (Role::Rtr, "rtr"),
    (Role::Fd, "fdf"),
    (Role::Brs, "brs"),
    (Role::Esi, "esi"),
    (Role::Data, "data"),
];
const DATASPEED_SIZED: &[(Role, &str)] = &[
    (Role::Id, "id"),
    (Role::Ext, "extended"),
    (Role::Rtr, "rtr"),
    (Role::Fd, "fdf"),
    (Role::Brs, "brs"),
    (Role::Esi, "esi"),
    (Role::Len, "size"),
    (Role::Data, "data"),
];
const DATASPEED_NESTED: &[(Role, &str)] =
    &[(Role::Id, "msg.id"), (Role::Ext, "msg.extended"), (Role::Len, "msg.dlc"), (Role::Data, "msg.data")];

const KNOWN: &[KnownType] = &[
    KnownType {
        name: "can_msgs/Frame",
        text: layout::CAN_FRAME,
        fields: CAN_FIELDS,
        layout: Some(Layout::Can),
        fd: None,
    },
    KnownType {
        name: "ros2_socketcan_msgs/FdFrame",
        text: layout::FD_FRAME,
        fields: FD_FIELDS,
        layout: Some(Layout::Fd),
        fd: Some(true),
    },
    dataspeed("dataspeed_can_msgs/Frame", DATASPEED, DATASPEED_FIELDS),
    dataspeed("dataspeed_can_msgs/Frame16", "", DATASPEED_SIZED),
    dataspeed("dataspeed_can_msgs/Frame32", "", DATASPEED_SIZED),
    dataspeed("dataspeed_can_msgs/Frame48", "", DATASPEED_SIZED),
    dataspeed("dataspeed_can_msgs/Frame64", "", DATASPEED_SIZED),
    dataspeed("dataspeed_can_msgs/CanMessageStamped", "", DATASPEED_NESTED),
];

const fn dataspeed(name: &'static str, text: &'static str, fields: &'static [(Role, &'static str)]) -> KnownType {
    KnownType { name, text, fields, layout: None, fd: None }
}

fn known(name: &str) -> Option<&'static KnownType> {
    KNOWN.iter().find(|known| known.name == name)
}

/// The path of the driver's time, unless the user names another.
const STAMP: &str = "header.stamp";
/// Maximum depth of nested types, and maximum number of all steps.
const DEPTH: usize = 8;
const MOST_STEPS: usize = 1024;

/// One step through a message.
#[derive(Clone, Debug, PartialEq, Eq)]
enum PlanStep {
    /// `count` numbers of this size, skipped.
    Pass { size: u8, count: u32 },
    /// A sequence of numbers of this size, skipped.
    PassSequence { size: u8 },
    /// A text, skipped.
    PassText,
    /// `count` repetitions, or as many as the message says.
    Repeat { count: Option<u32>, steps: Vec<PlanStep> },
    /// A wanted number.
    Number { size: u8, role: Role },
    /// Seconds and nanoseconds.
    Stamp,
    /// The wanted text: the bus.
    Text,
    /// The payload: an array, or a sequence.
    Data { count: Option<u32> },
}

/// The way to read messages of one type.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    wire: Wire,
    steps: Vec<PlanStep>,
    fast: Option<Layout>,
    fd: Option<bool>,
    len_is_code: bool,
    /// The fields for people: `id=id data=data`.
    pub(super) read_as: String,
}

/// The path of field indexes from the message to a wanted field, and its role.
type Wanted = (Vec<usize>, Role);

impl Plan {
    /// Makes the plan for a type of this name; `None` if its messages are not frames. `asked`: fields that the user
    /// named.
    pub(super) fn new(name: &str, text: Option<&str>, wire: Wire, asked: &[(Role, &str)]) -> Option<Self> {
        // A user who names identifier and data describes the whole type.
        let has = |fields: &[(Role, &str)], role| fields.iter().any(|(of, _)| *of == role);
        let whole = has(asked, Role::Id) && has(asked, Role::Data);
        let known = known(name).filter(|_| !whole);
        let text = text.filter(|text| !text.trim().is_empty()).or(known.map(|known| known.text))?;
        let mut fields: Vec<(Role, &str)> = Vec::new();
        for field in asked.iter().chain(known.map_or(&[][..], |known| known.fields)) {
            if !has(&fields, field.0) {
                fields.push(*field);
            }
        }
        if !has(&fields, Role::Id) || !has(&fields, Role::Data) {
            return None;
        }
        let definitions = Definitions::read(name, text, wire == Wire::Ros1);
        if !has(&fields, Role::Stamp) && resolve(&definitions, Role::Stamp, STAMP).is_some() {
            fields.push((Role::Stamp, STAMP));
        }
        let steps = steps(&definitions, &fields)?;
        let names = Role::NAMES.iter().filter_map(|(word, role)| {
            let (_, path) = fields.iter().find(|(of, _)| of == role)?;
            Some(format!("{word}={path}"))
        });
        let read_as = names.collect::<Vec<_>>().join(" ");
        let len_is_code = fields.iter().any(|(role, path)| *role == Role::Len && path.ends_with("dlc"));
        let own = |known: &&KnownType| {
            let definitions = Definitions::read(name, known.text, wire == Wire::Ros1);
            self::steps(&definitions, &fields).as_ref() == Some(&steps)
        };
        let fast = known.filter(own).and_then(|known| known.layout);
        Some(Self { wire, steps, fast, fd: known.and_then(|known| known.fd), len_is_code, read_as })
    }

    /// Returns the fields of a message; `None` if it is shorter than its type.
    #[inline(always)]
    pub(super) fn read<'a>(&self, message: &'a [u8]) -> Option<Fields<'a>> {
        if let Some(layout) = self.fast
            && let Some(fields) = layout.read(self.wire, message)
        {
            return Some(fields);
        }
        self.by_steps(message)
    }

    /// Returns true if [`layout::plain`] may read its messages.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        self.fast == Some(Layout::Can) && self.wire == Wire::Cdr
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

/// Returns true if a type of this name is known to hold CAN frames.
pub(super) fn is_known(name: &str) -> bool {
    known(name).is_some()
}

/// Makes the steps to these fields; `None` if the type lacks one.
fn steps(definitions: &Definitions, fields: &[(Role, &str)]) -> Option<Vec<PlanStep>> {
    let wanted = fields.iter().map(|(role, path)| Some((resolve(definitions, *role, path)?, *role)));
    let wanted: Vec<Wanted> = wanted.collect::<Option<_>>()?;
    Making { definitions, wanted: &wanted, found: 0, steps: 0 }.steps(&definitions.fields, &mut Vec::new())
}

/// Finds a field by its path (`msg.id`); `None` if there is none, or it cannot have this role.
fn resolve(definitions: &Definitions, role: Role, path: &str) -> Option<Vec<usize>> {
    let (mut fields, mut found, mut last) = (definitions.fields.as_slice(), Vec::new(), None);
    for name in path.split('.') {
        let at = fields.iter().position(|field| field.name == name)?;
        let field = fields.get(at)?;
        fields = match &field.kind {
            Kind::Message(name) if field.many == Many::One => definitions.of(name).unwrap_or_default(),
            _ => &[],
        };
        found.push(at);
        last = Some(field);
    }
    last.filter(|field| can_be(field, role)).map(|_| found)
}

fn can_be(field: &Field, role: Role) -> bool {
    match (role, &field.kind, field.many) {
        (Role::Data, Kind::Number { size: 1, .. }, Many::Fixed(_) | Many::Sequence(_)) => true,
        (Role::Bus, Kind::Text, Many::One) => true,
        (Role::Stamp, Kind::Message(name), Many::One) => matches!(name.as_str(), "builtin_interfaces/Time" | "time"),
        (Role::Data | Role::Stamp, ..) => false,
        (Role::Id | Role::Len | Role::Bus, Kind::Number { integer, .. }, Many::One) => *integer,
        (_, Kind::Number { .. }, Many::One) => true,
        _ => false,
    }
}

/// The state of making steps.
struct Making<'a> {
    definitions: &'a Definitions,
    wanted: &'a [Wanted],
    found: usize,
    steps: usize,
}

impl Making<'_> {
    /// Makes the steps through these fields, up to the last wanted one; `None` if that is impossible.
    fn steps(&mut self, fields: &[Field], path: &mut Vec<usize>) -> Option<Vec<PlanStep>> {
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

    fn field(&mut self, field: &Field, path: &mut Vec<usize>, steps: &mut Vec<PlanStep>) -> Option<()> {
        let role = self.wanted.iter().find(|(wanted, _)| wanted == path).map(|(_, role)| *role);
        self.found += usize::from(role.is_some());
        let count = match field.many {
            Many::One => Some(1),
            Many::Fixed(count) => Some(count),
            Many::Sequence(_) => None,
        };
        let step = match (&field.kind, role) {
            (Kind::Unknown, _) => return None,
            (_, Some(Role::Stamp)) => PlanStep::Stamp,
            (Kind::Text, Some(_)) => PlanStep::Text,
            (Kind::Number { .. }, Some(Role::Data)) => PlanStep::Data { count },
            (Kind::Number { size, .. }, Some(role)) => PlanStep::Number { size: *size, role },
            (Kind::Number { size, .. }, None) => match count {
                Some(count) => PlanStep::Pass { size: *size, count },
                None => PlanStep::PassSequence { size: *size },
            },
            (Kind::Text, None) if field.many == Many::One => PlanStep::PassText,
            (Kind::Text, None) => PlanStep::Repeat { count, steps: vec![PlanStep::PassText] },
            (Kind::Message(name), _) => {
                let inner = match name.as_str() {
                    "time" | "duration" => vec![PlanStep::Pass { size: 4, count: 2 }],
                    name => {
                        let inner = self.definitions.of(name)?;
                        self.steps(inner, path)?
                    }
                };
                if field.many == Many::One {
                    steps.extend(inner);
                    return Some(());
                }
                // A type without fields takes no bytes.
                if inner.is_empty() {
                    return None;
                }
                PlanStep::Repeat { count, steps: inner }
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
    /// Maximum alignment of numbers, which are aligned to their size.
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

    /// Reads a text without the final zero of CDR.
    fn text(&mut self) -> Option<&'a [u8]> {
        let len = self.number(4)?;
        let text = self.take(usize::try_from(len).ok()?)?;
        Some(text.strip_suffix(&[0]).unwrap_or(text))
    }
}

fn run<'a>(steps: &[PlanStep], at: &mut At<'a>, fields: &mut Fields<'a>) -> Option<()> {
    for step in steps {
        match step {
            PlanStep::Pass { size, count } => at.pass(*size, u64::from(*count))?,
            PlanStep::PassSequence { size } => {
                let count = at.number(4)?;
                at.pass(*size, count)?;
            }
            PlanStep::PassText => {
                at.text()?;
            }
            PlanStep::Repeat { count, steps } => {
                let count = match count {
                    Some(count) => u64::from(*count),
                    None => at.number(4)?,
                };
                // Every round takes at least a byte, so the message ends before a wrong count does harm.
                for _ in 0..count {
                    let before = at.at;
                    run(steps, at, fields)?;
                    if at.at == before {
                        break;
                    }
                }
            }
            PlanStep::Number { size, role } => {
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
            PlanStep::Stamp => {
                let (seconds, ns) = (at.number(4)? as u32, at.number(4)?);
                fields.stamp_ns = Some(layout::nanoseconds(seconds, ns as u32));
            }
            PlanStep::Text => fields.bus = Some(BusField::Name(at.text()?)),
            PlanStep::Data { count } => {
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
