//! The expression of `--filter`: which frames are shown. State still sees every frame.
//!
//! `service=sdo,emcy node=5 id=180-1FF bus=can1 t=1.0..2.5 frame=10-20`: a blank is "and", a comma is "or". It only compares
//! what a frame and its own event say; it must not decode.

use crate::frame::{Buses, Frame, Kind};
use crate::services::sdo::transfer::Transfer;

/// Every service a frame can belong to, as in file names, JSON and text.
pub const SERVICES: &[&str] = &[
    "nmt",
    "gfc",
    "flying_master",
    "sync",
    "time",
    "emcy",
    "pdo",
    "srdo",
    "sdo",
    "heartbeat",
    "guarding",
    "lss",
    "usdo",
    "error",
    "foreign",
];

/// Stamps from here on (in ns: 1973) are those of a clock, smaller ones count from a capture's beginning.
const EPOCH_NS: i64 = 100_000_000_000_000_000;
/// First identifiers of the default SDO channels, to which the server's node-ID is added.
const SDO_REQUEST: u32 = 0x600;
const SDO_RESPONSE: u32 = 0x580;

/// A filter: every clause must hold.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    clauses: Vec<Clause>,
}

/// What the stamps of frames count from, in ns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    /// The stamp of the capture's first frame.
    pub start_ns: i64,
    /// The date that stamps count from; zero where they are absolute, or no date is known.
    pub date_ns: i64,
}

#[derive(Clone, Debug)]
enum Clause {
    Service(Vec<String>),
    Node(Vec<(u32, u32)>),
    Id(Vec<(u32, u32)>),
    Bus(Vec<String>),
    /// Seconds in ns, both ends inclusive.
    Time(Vec<(i64, i64)>),
    /// Numbers in the capture, from 1.
    Number(Vec<(u32, u32)>),
}

/// Why an expression is no filter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// A word without `=`, or with an unknown key; the word.
    Key(String),
    /// A value that the key does not take: key and value.
    Value(String, String),
}

impl Filter {
    /// Reads an expression.
    pub fn parse(expression: &str) -> Result<Self, Mistake> {
        let mut clauses = Vec::new();
        for word in expression.split_whitespace() {
            let Some((key, values)) = word.split_once('=') else { return Err(Mistake::Key(word.into())) };
            let wrong = |value: &str| Mistake::Value(key.into(), value.into());
            let each = values.split(',');
            clauses.push(match key {
                "service" => Clause::Service(
                    each.map(|value| match SERVICES.contains(&value) {
                        true => Ok(value.to_owned()),
                        false => Err(wrong(value)),
                    })
                    .collect::<Result<_, _>>()?,
                ),
                "node" => Clause::Node(each.map(|v| range(v, 10).ok_or_else(|| wrong(v))).collect::<Result<_, _>>()?),
                "id" => Clause::Id(each.map(|v| range(v, 16).ok_or_else(|| wrong(v))).collect::<Result<_, _>>()?),
                "bus" if values.is_empty() => return Err(wrong(values)),
                "bus" => Clause::Bus(each.map(str::to_owned).collect()),
                "frame" => {
                    Clause::Number(each.map(|v| range(v, 10).ok_or_else(|| wrong(v))).collect::<Result<_, _>>()?)
                }
                "t" => Clause::Time(each.map(|v| span(v).ok_or_else(|| wrong(v))).collect::<Result<_, _>>()?),
                _ => return Err(Mistake::Key(word.into())),
            });
        }
        Ok(Self { clauses })
    }

    /// Whether it has no clause, so that it shows everything.
    pub fn is_empty(&self) -> bool {
        self.clauses.is_empty()
    }

    /// Whether it asks only for what a frame itself says, not for what it means.
    pub fn is_plain(&self) -> bool {
        !self.clauses.iter().any(|clause| matches!(clause, Clause::Service(_) | Clause::Node(_)))
    }

    /// Whether an SDO transfer is shown: its channel has both identifiers, its time is from first to last frame.
    pub fn shows_transfer(&self, transfer: &Transfer, buses: &Buses, clock: Clock) -> bool {
        let node = u32::from(transfer.node);
        self.clauses.iter().all(|clause| match clause {
            Clause::Service(services) => services.iter().any(|known| known == "sdo"),
            Clause::Node(ranges) => within(ranges, node),
            Clause::Id(ranges) => within(ranges, SDO_REQUEST + node) || within(ranges, SDO_RESPONSE + node),
            Clause::Bus(names) => names.iter().any(|name| name.as_bytes() == buses.name(transfer.bus)),
            Clause::Time(spans) => match (transfer.first.t_ns, transfer.last.t_ns) {
                (Some(first), Some(last)) => spans.iter().any(|span| overlaps(*span, first, last, clock)),
                _ => false,
            },
            Clause::Number(ranges) => {
                let meets = |(from, to): &(u32, u32)| {
                    u64::from(*from) <= transfer.last.no && transfer.first.no <= u64::from(*to)
                };
                ranges.iter().any(meets)
            }
        })
    }

    /// Whether a frame is shown, given the service and node of its event.
    pub fn shows(&self, frame: &Frame, service: &str, node: Option<u8>, buses: &Buses, clock: Clock) -> bool {
        self.clauses.iter().all(|clause| match clause {
            Clause::Service(services) => services.iter().any(|known| known == service),
            Clause::Node(ranges) => node.is_some_and(|node| within(ranges, u32::from(node))),
            Clause::Id(ranges) => frame.kind != Kind::Error && within(ranges, frame.id.raw()),
            Clause::Bus(names) => names.iter().any(|name| name.as_bytes() == buses.name(frame.bus)),
            Clause::Time(spans) => frame.t_ns.is_some_and(|t| spans.iter().any(|span| overlaps(*span, t, t, clock))),
            Clause::Number(ranges) => u32::try_from(frame.no).is_ok_and(|number| within(ranges, number)),
        })
    }
}

/// Whether a span meets the time from `first` to `last`. Small numbers count from the capture's first frame.
fn overlaps((from, to): (i64, i64), first: i64, last: i64, clock: Clock) -> bool {
    let counts_from_start = |end: i64| end == i64::MIN || end == i64::MAX || end < EPOCH_NS;
    let origin = match counts_from_start(from) && counts_from_start(to) {
        true if clock.start_ns >= EPOCH_NS => clock.start_ns,
        true => 0,
        false => clock.date_ns.saturating_neg(),
    };
    from <= last.saturating_sub(origin) && first.saturating_sub(origin) <= to
}

fn within(ranges: &[(u32, u32)], value: u32) -> bool {
    ranges.iter().any(|(from, to)| (*from..=*to).contains(&value))
}

/// `5` or `180-1FF`.
fn range(text: &str, radix: u32) -> Option<(u32, u32)> {
    let number = |digits: &str| {
        let digits = digits.strip_prefix("0x").unwrap_or(digits);
        u32::from_str_radix(digits, radix).ok().filter(|_| !digits.starts_with('+'))
    };
    match text.split_once('-') {
        Some((from, to)) => Some((number(from)?, number(to)?)).filter(|(from, to)| from <= to),
        None => number(text).map(|value| (value, value)),
    }
}

/// `1.0..2.5`, `1.0..`, `..2.5`, in seconds of the capture's own clock.
fn span(text: &str) -> Option<(i64, i64)> {
    let (from, to) = text.split_once("..")?;
    let from = if from.is_empty() { i64::MIN } else { nanoseconds(from)? };
    let to = if to.is_empty() { i64::MAX } else { nanoseconds(to)? };
    (from <= to).then_some((from, to))
}

fn nanoseconds(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > 9 {
        return None;
    }
    let fraction: i64 = format!("{fraction:0<9}").parse().ok()?;
    whole.parse::<i64>().ok()?.checked_mul(1_000_000_000)?.checked_add(fraction)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::frame::CanId;

    #[test]
    fn expressions() {
        let mut buses = Buses::default();
        let mut frame = Frame::classic(CanId::standard(0x185), &[0; 8]);
        frame.bus = buses.intern(b"can1");
        frame.t_ns = Some(2_500_000_000);
        frame.no = 12;
        let shows = |text: &str| Filter::parse(text).unwrap().shows(&frame, "pdo", Some(5), &buses, Clock::default());
        for yes in [
            "",
            "frame=12",
            "frame=1,10-20",
            "service=sdo,pdo",
            "node=5",
            "node=1-9",
            "id=185",
            "id=180-1FF",
            "id=0x185",
            "bus=can0,can1",
        ] {
            assert!(shows(yes), "{yes}");
        }
        assert!(shows("t=1.0..2.5") && shows("t=2.5..") && shows("service=pdo node=5 bus=can1 t=..3"));
        assert!(shows("frame=12") && shows("frame=1,10-12") && !shows("frame=13-20"));
        for no in ["frame=1-11", "service=sdo", "node=6", "id=205", "bus=can0", "t=2.6..3", "service=pdo node=6"] {
            assert!(!shows(no), "{no}");
        }
    }

    #[test]
    fn times_of_a_capture_whose_stamps_count_from_a_date() {
        const DATE: i64 = 1_700_000_000_000_000_000;
        let buses = Buses::default();
        let mut frame = Frame::classic(CanId::standard(0x185), &[0; 8]);
        frame.t_ns = Some(2_500_000_000);
        let shows = |text: &str, date_ns| {
            let clock = Clock { start_ns: 1_000_000_000, date_ns };
            Filter::parse(text).unwrap().shows(&frame, "pdo", Some(5), &buses, clock)
        };
        for yes in ["t=1700000002..1700000003", "t=1700000002.5..", "t=2..3"] {
            assert!(shows(yes, DATE), "{yes}");
        }
        assert!(!shows("t=1700000003..", DATE) && !shows("t=1700000002..", 0));
    }

    #[test]
    fn mistakes() {
        for (text, mistake) in [
            ("sdo", Mistake::Key("sdo".into())),
            ("color=red", Mistake::Key("color=red".into())),
            ("service=foo", Mistake::Value("service".into(), "foo".into())),
            ("node=x", Mistake::Value("node".into(), "x".into())),
            ("id=1FF-180", Mistake::Value("id".into(), "1FF-180".into())),
            ("t=1", Mistake::Value("t".into(), "1".into())),
            ("frame=20-10", Mistake::Value("frame".into(), "20-10".into())),
            ("bus=", Mistake::Value("bus".into(), String::new())),
        ] {
            assert_eq!(Filter::parse(text).unwrap_err(), mistake, "{text}");
        }
    }
}
