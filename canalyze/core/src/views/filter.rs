//! The expression of `--filter`, which chooses the frames to show. Hidden frames still count for all state.
//!
//! `service=sdo,emcy node=5 object=6040 code=SDO text="bus off" t=1.0..2.5 frame=10-20`: a blank means "and", a comma
//! "or"; in double quotes both are plain characters. A filter only compares what is already decoded.

use crate::bytes::frame::{Buses, CanId, Frame, Kind};
use crate::bytes::ns::Ns;
use crate::rules::finding::{Finding, Severity};
use crate::rules::{RULES, SEVERITIES};
use crate::sdo::transfer::Transfer;
use crate::sdo::wire::Mux;
use crate::world::event::{Event, What};

/// Names of all services, as used for files, in JSON and in text.
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

/// Lower limit of absolute stamps, in ns (1973); smaller ones count from the start of a capture.
const EPOCH_NS: Ns = Ns::from_s(100000000);
/// Base identifiers of the default SDO channels; the server's node-ID is added.
const SDO_REQUEST: u32 = 0x600;
const SDO_RESPONSE: u32 = 0x580;
/// Largest identifier of 29 bits.
const LARGEST_ID: u32 = 0x1FFF_FFFF;

/// A filter: every clause must hold.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    clauses: Vec<Clause>,
}

/// The origins of frame times, in ns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilterClock {
    /// Time of the first frame of the capture.
    pub start_ns: Ns,
    /// The date from which stamps count; 0 if they are absolute or no date is known.
    pub date_ns: Ns,
}

/// The decoded facts about a frame that a filter can ask for.
pub trait Subject {
    /// Returns its service and the node that it concerns.
    fn service(&self) -> (&str, Option<u8>);
    /// Returns true if it concerns a wanted object.
    fn has_object(&self, wanted: &dyn Fn(Mux) -> bool) -> bool;
    /// Returns true if it has a finding whose code and severity are wanted.
    fn has_finding(&self, wanted: &dyn Fn(&str, Severity) -> bool) -> bool;
    /// Appends its text.
    fn annotation(&self, out: &mut Vec<u8>);
}

#[derive(Clone, Debug)]
enum Clause {
    Service(Vec<String>),
    Node(Vec<(u32, u32)>),
    Id(Vec<(u32, u32)>),
    Bus(Vec<String>),
    /// Spans in ns, both ends inclusive.
    Time(Vec<(Ns, Ns)>),
    /// Frame numbers in the capture, from 1.
    Number(Vec<(u32, u32)>),
    /// Indexes with the sub-index in the lowest byte.
    Object(Vec<(u32, u32)>),
    /// Prefixes of rule codes.
    Code(Vec<String>),
    Severity(Vec<Severity>),
    /// In lower-case ASCII.
    Text(Vec<String>),
}

/// The reason that an expression is invalid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilterMistake {
    /// A word without `=`, or with an unknown key; the word.
    Key(String),
    /// A value that is invalid for its key: key and value.
    Value(String, String),
    /// A number that is not a node-ID: the value.
    Node(String),
}

impl Filter {
    /// Parses an expression.
    pub fn parse(expression: &str) -> Result<Self, FilterMistake> {
        let mut clauses = Vec::new();
        for word in parts(expression, char::is_whitespace).into_iter().filter(|word| !word.is_empty()) {
            let Some((key, values)) = word.split_once('=') else { return Err(FilterMistake::Key(word.into())) };
            let values = parts(values, |c| c == ',');
            clauses.push(match key {
                "service" => {
                    Clause::Service(each(key, &values, |value| SERVICES.contains(&value).then(|| value.to_owned()))?)
                }
                "node" => {
                    let ranges = each(key, &values, |value| range(value, number(10)))?;
                    let beyond = ranges.iter().position(|(from, to)| *from < 1 || *to > 127);
                    if let Some(value) = beyond.and_then(|place| values.get(place)) {
                        return Err(FilterMistake::Node((*value).into()));
                    }
                    Clause::Node(ranges)
                }
                "id" => Clause::Id(each(key, &values, |value| {
                    range(value, number(16)).filter(|(_, to)| *to <= LARGEST_ID)
                })?),
                "bus" => Clause::Bus(each(key, &values, words)?),
                "frame" => Clause::Number(each(key, &values, |value| range(value, number(10)))?),
                "t" => Clause::Time(each(key, &values, span)?),
                "object" => Clause::Object(each(key, &values, objects)?),
                "code" => Clause::Code(each(key, &values, code)?),
                "severity" => Clause::Severity(each(key, &values, |value| {
                    SEVERITIES.iter().copied().find(|severity| severity.name() == value)
                })?),
                "text" => Clause::Text(each(key, &values, |value| Some(words(value)?.to_ascii_lowercase()))?),
                _ => return Err(FilterMistake::Key(word.into())),
            });
        }
        Ok(Self { clauses })
    }

    /// Returns true if it has no clauses and shows everything.
    pub fn is_empty(&self) -> bool {
        self.clauses.is_empty()
    }

    /// Returns the requested frame numbers above `frames`, and true if a clause requests no others.
    pub fn beyond(&self, frames: u64) -> (Vec<(u32, u32)>, bool) {
        let (mut beyond, mut all) = (Vec::new(), false);
        for clause in &self.clauses {
            if let Clause::Number(ranges) = clause {
                let before = beyond.len();
                beyond.extend(ranges.iter().copied().filter(|(from, _)| u64::from(*from) > frames));
                all |= beyond.len() - before == ranges.len();
            }
        }
        (beyond, all)
    }

    /// Returns true if it depends only on the frame itself and not on its meaning.
    pub fn is_plain(&self) -> bool {
        let plain =
            |clause: &Clause| matches!(clause, Clause::Id(_) | Clause::Bus(_) | Clause::Time(_) | Clause::Number(_));
        self.clauses.iter().all(plain)
    }

    /// Returns true if an SDO transfer is shown. Its channel has two identifiers; its time is from first to last frame.
    /// `annotation` appends its text.
    pub fn shows_transfer(
        &self,
        transfer: &Transfer,
        annotation: &dyn Fn(&mut Vec<u8>),
        buses: &Buses,
        clock: FilterClock,
    ) -> bool {
        let node = u32::from(transfer.node);
        let client = transfer.session.map_or(node, |session| session.client.into());
        let service = if transfer.session.is_some() { "usdo" } else { "sdo" };
        self.clauses.iter().all(|clause| match clause {
            Clause::Service(services) => services.iter().any(|known| known == service || known == "sdo"),
            Clause::Node(ranges) => within(ranges, node) || within(ranges, client),
            Clause::Id(ranges) => within(ranges, SDO_REQUEST + client) || within(ranges, SDO_RESPONSE + node),
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
            Clause::Object(ranges) => transfer.mux.is_some_and(|mux| within(ranges, place_of(mux))),
            Clause::Code(_) | Clause::Severity(_) => transfer.outcome.findings.iter().any(|code| {
                let rule = code.rule();
                clause.takes(rule.id, rule.severity)
            }),
            Clause::Text(texts) => holds(texts, annotation),
        })
    }

    /// Returns true if a frame is shown.
    pub fn shows(&self, frame: &Frame, subject: &impl Subject, buses: &Buses, clock: FilterClock) -> bool {
        self.clauses.iter().all(|clause| match clause {
            Clause::Service(services) => services.iter().any(|known| known == subject.service().0),
            Clause::Node(ranges) => {
                let (service, node) = subject.service();
                // The sender of a USDO frame is in its identifier, the destination in its first byte.
                let ends = [frame.id.raw() & 0x7F, frame.payload().first().copied().unwrap_or(0).into()];
                node.is_some_and(|node| within(ranges, u32::from(node)))
                    || service == "usdo" && ends.into_iter().any(|node| within(ranges, node))
            }
            Clause::Id(ranges) => frame.kind != Kind::Error && within(ranges, frame.id.raw()),
            Clause::Bus(names) => names.iter().any(|name| name.as_bytes() == buses.name(frame.bus)),
            Clause::Time(spans) => frame.t_ns.is_some_and(|t| spans.iter().any(|span| overlaps(*span, t, t, clock))),
            Clause::Number(ranges) => u32::try_from(frame.no).is_ok_and(|number| within(ranges, number)),
            Clause::Object(ranges) => subject.has_object(&|mux| within(ranges, place_of(mux))),
            Clause::Code(_) | Clause::Severity(_) => subject.has_finding(&|id, severity| clause.takes(id, severity)),
            Clause::Text(texts) => holds(texts, &|out| subject.annotation(out)),
        })
    }

    /// Returns true if the code and severity of a finding are wanted, wherever it is.
    pub fn takes_finding(&self, finding: &Finding) -> bool {
        self.clauses.iter().all(|clause| match clause {
            Clause::Code(_) | Clause::Severity(_) => clause.takes(finding.code.rule().id, finding.severity()),
            _ => true,
        })
    }

    /// Returns true if an object of a node is wanted, wherever it appears.
    pub fn takes_object(&self, node: u8, object: Mux) -> bool {
        self.clauses.iter().all(|clause| match clause {
            Clause::Node(ranges) => within(ranges, u32::from(node)),
            Clause::Object(ranges) => within(ranges, place_of(object)),
            _ => true,
        })
    }

    /// Returns true if an identifier of a node is wanted.
    pub fn takes_identifier(&self, node: u8, id: CanId, bus: &[u8]) -> bool {
        self.clauses.iter().all(|clause| match clause {
            Clause::Node(ranges) => within(ranges, u32::from(node)),
            Clause::Id(ranges) => within(ranges, id.raw()),
            Clause::Bus(names) => names.iter().any(|name| name.as_bytes() == bus),
            _ => true,
        })
    }

    /// Returns true if an event without a frame at hand is shown, as far as it has the facts. `annotation` appends its
    /// text.
    pub fn shows_aside(
        &self,
        event: &Event,
        annotation: &dyn Fn(&mut Vec<u8>),
        buses: &Buses,
        clock: FilterClock,
    ) -> bool {
        let at = event.about.as_deref().copied().unwrap_or(event.at);
        self.clauses.iter().all(|clause| match (clause, &event.what) {
            (_, What::Transfer(transfer)) => {
                Self { clauses: vec![clause.clone()] }.shows_transfer(transfer, annotation, buses, clock)
            }
            (Clause::Node(ranges), _) => event.node.is_none_or(|node| within(ranges, u32::from(node))),
            (Clause::Bus(names), _) => names.iter().any(|name| name.as_bytes() == buses.name(event.bus)),
            (Clause::Number(ranges), _) => u32::try_from(at.no).is_ok_and(|no| no == 0 || within(ranges, no)),
            (Clause::Time(spans), _) => at.t_ns.is_none_or(|t| spans.iter().any(|span| overlaps(*span, t, t, clock))),
            (Clause::Object(ranges), What::Finding(finding)) => {
                finding.object.is_some_and(|mux| within(ranges, place_of(mux)))
            }
            (Clause::Code(_) | Clause::Severity(_), What::Finding(finding)) => self.takes_finding(finding),
            (Clause::Object(_) | Clause::Code(_) | Clause::Severity(_), _) => false,
            (Clause::Text(texts), _) => holds(texts, annotation),
            (Clause::Service(_) | Clause::Id(_), _) => true,
        })
    }
}

impl Clause {
    /// Returns true if this clause accepts a finding; clauses of other kinds accept every one.
    fn takes(&self, id: &str, severity: Severity) -> bool {
        match self {
            Self::Code(codes) => codes.iter().any(|code| id.starts_with(code.as_str())),
            Self::Severity(severities) => severities.contains(&severity),
            _ => true,
        }
    }
}

/// Splits at characters that satisfy `ends`, except within double quotes.
fn parts(text: &str, ends: impl Fn(char) -> bool) -> Vec<&str> {
    let mut quoted = false;
    let cut = |c: char| {
        quoted ^= c == '"';
        !quoted && ends(c)
    };
    text.split(cut).collect()
}

/// Parses all values of a key.
fn each<T>(key: &str, values: &[&str], read: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, FilterMistake> {
    let read = |value: &&str| read(value).ok_or_else(|| FilterMistake::Value(key.into(), (*value).into()));
    values.iter().map(read).collect()
}

/// Parses a non-empty name or text, quoted or not.
fn words(value: &str) -> Option<String> {
    let bare = value.replace('"', "");
    (!bare.is_empty()).then_some(bare)
}

/// Parses the code of a rule or a common prefix: `SDO002`, `SDO`.
fn code(value: &str) -> Option<String> {
    let code = value.to_ascii_uppercase();
    RULES.iter().any(|rule| !code.is_empty() && rule.id.starts_with(&code)).then_some(code)
}

/// Returns true if the annotation contains one of the texts.
fn holds(texts: &[String], annotation: &dyn Fn(&mut Vec<u8>)) -> bool {
    let mut said = Vec::new();
    annotation(&mut said);
    said.make_ascii_lowercase();
    texts.iter().any(|text| memchr::memmem::find(&said, text.as_bytes()).is_some())
}

/// Returns true if a span overlaps the time from `first` to `last`. Small numbers count from the first frame of the
/// capture.
fn overlaps((from, to): (Ns, Ns), first: Ns, last: Ns, clock: FilterClock) -> bool {
    let counts_from_start = |end: Ns| end == Ns::MIN || end == Ns::MAX || end < EPOCH_NS;
    let origin = match counts_from_start(from) && counts_from_start(to) {
        true => clock.start_ns,
        false => -clock.date_ns,
    };
    from <= last - origin && first - origin <= to
}

fn within(ranges: &[(u32, u32)], value: u32) -> bool {
    ranges.iter().any(|(from, to)| (*from..=*to).contains(&value))
}

/// Returns index and sub-index as one number.
fn place_of(mux: Mux) -> u32 {
    u32::from(mux.index) << 8 | u32::from(mux.sub)
}

/// Parses `5` or `180-1FF`.
fn range(text: &str, number: impl Fn(&str) -> Option<u32>) -> Option<(u32, u32)> {
    match text.split_once('-') {
        Some((from, to)) => Some((number(from)?, number(to)?)).filter(|(from, to)| from <= to),
        None => number(text).map(|value| (value, value)),
    }
}

/// Returns a parser for numbers in this base; after `0x` they are hexadecimal.
fn number(base: u32) -> impl Fn(&str) -> Option<u32> {
    move |text| {
        let (digits, base) = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
            Some(digits) => (digits, 16),
            None => (text, base),
        };
        u32::from_str_radix(digits, base).ok().filter(|_| !digits.starts_with('+'))
    }
}

/// Parses `6040`, `6040h`, `0x6040` (all sub-indexes), `6040:00`, `6040h:00` (one), or a range `1A00-1BFF`.
fn objects(text: &str) -> Option<(u32, u32)> {
    let one = |text: &str| {
        let (index, sub) = text.split_once(':').map_or((text, None), |(index, sub)| (index, Some(sub)));
        let hex = number(16);
        let index = hex(index.trim_end_matches(['h', 'H'])).filter(|index| *index <= 0xFFFF)? << 8;
        match sub {
            None => Some((index, index | 0xFF)),
            Some(sub) => {
                hex(sub.trim_end_matches(['h', 'H'])).filter(|sub| *sub <= 0xFF).map(|sub| (index | sub, index | sub))
            }
        }
    };
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    Some((one(from)?.0, one(to)?.1)).filter(|(from, to)| from <= to)
}

/// Parses `1.0..2.5`, `1.0..` or `..2.5`, in seconds.
fn span(text: &str) -> Option<(Ns, Ns)> {
    let (from, to) = text.split_once("..")?;
    let from = if from.is_empty() { Ns::MIN } else { nanoseconds(from)? };
    let to = if to.is_empty() { Ns::MAX } else { nanoseconds(to)? };
    (from <= to).then_some((from, to))
}

fn nanoseconds(text: &str) -> Option<Ns> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > 9 {
        return None;
    }
    let fraction: i64 = format!("{fraction:0<9}").parse().ok()?;
    whole.parse::<i64>().ok()?.checked_mul(1_000_000_000)?.checked_add(fraction).map(Ns)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::bytes::frame::CanId;

    const SUBJECT: Fixed = Fixed;

    /// A PDO of node 5 that contains the statusword and has a finding.
    struct Fixed;

    impl Subject for Fixed {
        fn service(&self) -> (&str, Option<u8>) {
            ("pdo", Some(5))
        }

        fn has_object(&self, wanted: &dyn Fn(Mux) -> bool) -> bool {
            wanted(Mux { index: 0x6041, sub: 0 })
        }

        fn has_finding(&self, wanted: &dyn Fn(&str, Severity) -> bool) -> bool {
            wanted("PDO002", Severity::Error)
        }

        fn annotation(&self, out: &mut Vec<u8>) {
            out.extend_from_slice("TPDO1 of node 5: Statusword=0637h, ready".as_bytes());
        }
    }

    #[test]
    fn expressions() {
        let mut buses = Buses::default();
        let mut frame = Frame::classic(CanId::standard(0x185), &[0; 8]);
        frame.bus = buses.intern(b"can1");
        frame.t_ns = Some(Ns(2_500_000_000));
        frame.no = 12;
        let shows = |text: &str| Filter::parse(text).unwrap().shows(&frame, &SUBJECT, &buses, FilterClock::default());
        for yes in [
            "",
            "frame=12",
            "frame=1,10-20",
            "service=sdo,pdo",
            "node=5",
            "node=1-9",
            "node=0x05",
            "node=0x1-0xA",
            "object=6041",
            "object=6041h",
            "object=0x6041",
            "object=6041:00",
            "object=6041h:00",
            "object=1000,6000-6FFF",
            "object=6040:05-6041:00",
            "code=PDO002",
            "code=sdo,pdo",
            "severity=error",
            "severity=info,error",
            "text=STATUSWORD",
            "text=nothing,ready",
            "text=\"node 5: \" node=5",
            "text=\"0637h, ready\"",
            "id=185",
            "id=180-1FF",
            "id=0x185",
            "bus=can0,can1",
        ] {
            assert!(shows(yes), "{yes}");
        }
        assert!(shows("t=1.0..2.5") && shows("t=2.5..") && shows("service=pdo node=5 bus=can1 t=..3"));
        assert!(shows("frame=12") && shows("frame=1,10-12") && !shows("frame=13-20"));
        for no in [
            "object=6040",
            "object=6041:01",
            "object=6042-6FFF",
            "code=PDO003",
            "code=SDO",
            "severity=warning",
            "text=statusword node=6",
            "text=\"ready,\"",
            "frame=1-11",
            "service=sdo",
            "node=6",
            "id=205",
            "bus=can0",
            "t=2.6..3",
            "service=pdo node=6",
        ] {
            assert!(!shows(no), "{no}");
        }
    }

    #[test]
    fn times_of_a_capture_whose_stamps_count_from_a_date() {
        const DATE: i64 = 1_700_000_000_000_000_000;
        let buses = Buses::default();
        let mut frame = Frame::classic(CanId::standard(0x185), &[0; 8]);
        frame.t_ns = Some(Ns(2_500_000_000));
        let shows = |text: &str, date_ns| {
            let clock = FilterClock { start_ns: Ns(1_000_000_000), date_ns };
            Filter::parse(text).unwrap().shows(&frame, &SUBJECT, &buses, clock)
        };
        for yes in ["t=1700000002..1700000003", "t=1700000002.5..", "t=1.5..1.5"] {
            assert!(shows(yes, Ns(DATE)), "{yes}");
        }
        assert!(!shows("t=1700000003..", Ns(DATE)) && !shows("t=1700000002..", Ns::ZERO) && !shows("t=2..3", Ns(DATE)));
    }

    #[test]
    fn mistakes() {
        for (text, mistake) in [
            ("sdo", FilterMistake::Key("sdo".into())),
            ("color=red", FilterMistake::Key("color=red".into())),
            ("service=foo", FilterMistake::Value("service".into(), "foo".into())),
            ("node=x", FilterMistake::Value("node".into(), "x".into())),
            ("node=200", FilterMistake::Node("200".into())),
            ("node=5,0", FilterMistake::Node("0".into())),
            ("node=100-0x80", FilterMistake::Node("100-0x80".into())),
            ("id=20000000", FilterMistake::Value("id".into(), "20000000".into())),
            ("object=10000", FilterMistake::Value("object".into(), "10000".into())),
            ("object=6040:100", FilterMistake::Value("object".into(), "6040:100".into())),
            ("object=6041-6040", FilterMistake::Value("object".into(), "6041-6040".into())),
            ("code=XYZ", FilterMistake::Value("code".into(), "XYZ".into())),
            ("code=", FilterMistake::Value("code".into(), String::new())),
            ("severity=fatal", FilterMistake::Value("severity".into(), "fatal".into())),
            ("text=\"\"", FilterMistake::Value("text".into(), "\"\"".into())),
            ("id=1FF-180", FilterMistake::Value("id".into(), "1FF-180".into())),
            ("t=1", FilterMistake::Value("t".into(), "1".into())),
            ("frame=20-10", FilterMistake::Value("frame".into(), "20-10".into())),
            ("bus=", FilterMistake::Value("bus".into(), String::new())),
        ] {
            assert_eq!(Filter::parse(text).unwrap_err(), mistake, "{text}");
        }
    }
}
