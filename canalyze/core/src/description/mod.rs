//! Device descriptions, EDS and DCF (CiA 306), XDD (CiA 311) and concise DCF, read as they are found.
//!
//! ```text
//! bytes -encoding-> text -ini-> sections -objects, number-> objects -> table of the world, PDOs
//!   |                 XML -xdd----^
//!   +---concise--> entries of a concise DCF
//! ```
//!
//! Repairs, and parts that cannot be used, are defects. Only a file without any object is refused. `$NODEID` stays
//! unresolved, so that one description serves every node with it.

mod compact;
mod concise;
mod configured;
mod encoding;
mod ini;
mod number;
mod objects;
mod pdos;
mod xdd;

use std::sync::Arc;

pub use self::configured::{Dcf, configured};
use self::ini::{Section, Sections};
use crate::world::dictionary::{Access, Dictionary, Form, Object, Preset};
use crate::world::preset;

/// Maximum number of defects of one code that are kept; the rest is counted.
const MOST_DEFECTS: usize = 1000;
/// Maximum number of characters of a text in a defect.
const MOST_SHOWN: usize = 60;
/// The bit rates of DeviceInfo in kbit/s.
const BIT_RATES: [i128; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// The form of a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileForm {
    /// Electronic data sheet.
    Eds,
    /// Device configuration file.
    Dcf,
    /// XML device description.
    Xdd,
    /// Concise DCF.
    Concise,
}

impl FileForm {
    /// Returns the name in options and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Eds => "eds",
            Self::Dcf => "dcf",
            Self::Xdd => "xdd",
            Self::Concise => "concise",
        }
    }
}

/// A value as a description has it.
#[derive(Clone, Debug, PartialEq)]
pub enum FiledValue {
    /// An integer.
    Whole(i128),
    /// An integer to which the node-ID is to be added.
    Offset(i128),
    /// A floating point number.
    Real(f64),
    /// A text.
    Text(String),
    /// Bytes.
    Bytes(Vec<u8>),
}

/// One sub-object, or an object that is a single variable (sub-index 0).
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// The manufacturer's name.
    pub name: String,
    /// Data type code (CiA 301, 7.4.7); 0 if the file has none.
    pub data_type: u16,
    /// Access: ro, wo, rw, rwr, rww or const.
    pub access: &'static str,
    /// DefaultValue.
    pub default: Option<FiledValue>,
    /// ParameterValue of a DCF.
    pub parameter: Option<FiledValue>,
    /// It may be mapped into a PDO.
    pub mappable: bool,
    /// Minimum value.
    pub low: Option<FiledValue>,
    /// Maximum value.
    pub high: Option<FiledValue>,
    /// Unit; empty if the file has none.
    pub unit: String,
    /// Factor of raw values; 1 by default.
    pub factor: f64,
    /// The line of its section.
    pub line: usize,
}

/// One index of a description.
#[derive(Clone, Debug, PartialEq)]
pub struct FiledObject {
    /// Index.
    pub index: u16,
    /// The manufacturer's name.
    pub name: String,
    /// Object code (CiA 301, 7.4.3): DOMAIN, VAR, ARRAY or RECORD.
    pub code: u8,
    /// Its sub-objects, by sub-index.
    pub entries: Vec<Entry>,
    /// The line of its section.
    pub line: usize,
}

/// Section FileInfo, as written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileInfo {
    /// FileName.
    pub name: String,
    /// FileVersion.
    pub version: String,
    /// FileRevision.
    pub revision: String,
    /// EDSVersion.
    pub eds_version: String,
    /// Description.
    pub description: String,
    /// Date, time and author.
    pub created: String,
    /// Date, time and author.
    pub modified: String,
}

/// Section DeviceInfo; `None` if the file has no such key.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Device {
    /// VendorName.
    pub vendor_name: Option<String>,
    /// VendorNumber.
    pub vendor_number: Option<i128>,
    /// ProductName.
    pub product_name: Option<String>,
    /// ProductNumber.
    pub product_number: Option<i128>,
    /// RevisionNumber.
    pub revision_number: Option<i128>,
    /// OrderCode.
    pub order_code: Option<String>,
    /// In bit/s.
    pub bit_rates: Vec<i128>,
    /// NrOfRXPDO.
    pub rpdos: Option<i128>,
    /// NrOfTXPDO.
    pub tpdos: Option<i128>,
    /// LSS_Supported.
    pub lss: Option<bool>,
}

/// A fact in the sentence of a defect.
#[derive(Clone, Debug, PartialEq)]
pub enum DefectFact {
    /// An integer.
    Whole(i128),
    /// A floating point number.
    Real(f64),
    /// A text.
    Text(String),
}

impl From<i128> for DefectFact {
    fn from(value: i128) -> Self {
        Self::Whole(value)
    }
}

impl From<usize> for DefectFact {
    fn from(value: usize) -> Self {
        Self::Whole(value as i128)
    }
}

impl From<String> for DefectFact {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for DefectFact {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// A repair, a part that cannot be used, or a part that does not agree with another.
#[derive(Clone, Debug, PartialEq)]
pub struct Defect {
    /// Its line; 0 if no line is at fault.
    pub line: usize,
    /// Its code.
    pub code: &'static str,
    /// The facts in its sentence.
    pub facts: Vec<(&'static str, DefectFact)>,
}

/// One device description.
#[derive(Clone, Debug)]
pub struct DeviceDescription {
    /// The form of the file.
    pub form: FileForm,
    /// The name of its encoding.
    pub encoding: &'static str,
    /// The file.
    pub info: FileInfo,
    /// The device.
    pub device: Device,
    /// Section Comments, by line.
    pub comments: Vec<String>,
    /// The node-ID of a DCF.
    pub node: Option<u8>,
    /// The node's name in a DCF.
    pub node_name: String,
    /// The bit rate of a DCF, in bit/s.
    pub bit_rate: Option<i128>,
    /// The objects, by index.
    pub objects: Vec<FiledObject>,
    /// The data types that may be mapped to skip bits, ascending.
    pub dummies: Vec<u16>,
    /// The table for frames.
    pub table: Arc<Dictionary>,
    /// The PDOs that it presets: RPDOs, then TPDOs, by number.
    pub pdos: Vec<preset::Preset>,
    /// The defects, by line.
    pub defects: Vec<Defect>,
}

/// The reason why a file is no description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// It is empty.
    Empty,
    /// It has no object.
    Nothing,
    /// It is XML with a document type declaration, whose entities can make a small file large.
    Doctype,
    /// It is XML that is not well-formed.
    Xml {
        /// The line.
        line: usize,
        /// The problem in English, as XML parsers name it.
        problem: &'static str,
    },
}

impl Unusable {
    /// Returns the key of its sentence and the facts in it.
    pub fn sentence(self) -> (&'static str, Vec<(&'static str, DefectFact)>) {
        match self {
            Self::Empty => ("source.empty", Vec::new()),
            Self::Nothing => ("eds.nothing", Vec::new()),
            Self::Doctype => ("eds.doctype", Vec::new()),
            Self::Xml { line, problem } => ("eds.xml", vec![("line", line.into()), ("problem", problem.into())]),
        }
    }
}

/// The defects so far.
#[derive(Default)]
struct Defects {
    noted: Vec<Defect>,
    counts: Vec<(&'static str, usize)>,
}

impl Defects {
    fn note(&mut self, line: usize, code: &'static str, facts: Vec<(&'static str, DefectFact)>) {
        let place = self.counts.iter().position(|(of, _)| *of == code).unwrap_or(self.counts.len());
        if place == self.counts.len() {
            self.counts.push((code, 0));
        }
        if let Some((_, count)) = self.counts.get_mut(place) {
            *count += 1;
            if *count <= MOST_DEFECTS {
                self.noted.push(Defect { line, code, facts });
            }
        }
    }

    /// Returns all of them by line, the number of those that are not kept first.
    fn by_line(self) -> Vec<Defect> {
        let more = self.counts.into_iter().filter(|(_, count)| *count > MOST_DEFECTS).map(|(code, count)| Defect {
            line: 0,
            code: "more",
            facts: vec![("code", code.into()), ("count", (count - MOST_DEFECTS).into())],
        });
        let mut all: Vec<Defect> = more.chain(self.noted).collect();
        all.sort_by_key(|defect| defect.line);
        all
    }
}

/// Returns the beginning of a text that is too long for a sentence.
fn short(text: &str) -> String {
    if text.chars().nth(MOST_SHOWN).is_none() { text.to_owned() } else { cut(text, MOST_SHOWN - 1) + "…" }
}

fn cut(text: &str, most: usize) -> String {
    text.chars().take(most).collect()
}

/// Reads a description from its bytes; `file` is its name in messages about frames.
pub fn read(data: &[u8], file: String) -> Result<DeviceDescription, Unusable> {
    if data.iter().all(|byte| byte.is_ascii_whitespace() || *byte == 0x0B) {
        return Err(Unusable::Empty);
    }
    let mut defects = Defects::default();
    let concise = concise::entries(data);
    let is_text = concise.is_none();
    let mut encoding = "binary";
    let mut is_xml = false;
    let sections = if let Some(entries) = concise {
        concise::sections(&entries)
    } else {
        let decoded = encoding::decode(data);
        encoding = decoded.encoding;
        is_xml = is_document(&decoded.text);
        let read = match is_xml {
            true => xdd::sections(data, &mut defects)?,
            false => ini::parse(&decoded.text, &mut defects),
        };
        if decoded.marked {
            defects.note(1, "bom", Vec::new());
        }
        if encoding != "utf-8" && !is_xml {
            let line = decoded.text.find(|c: char| !c.is_ascii()).unwrap_or(0);
            let line = ini::line_at(decoded.text.as_bytes(), line);
            defects.note(line, "encoding", vec![("encoding", encoding.into())]);
        }
        read
    };
    let (device, compact_pdos) = device(&sections, &mut defects);
    let numbers = (device.rpdos.unwrap_or(0), device.tpdos.unwrap_or(0));
    let (sections, parts) = objects::Parts::divide(sections, &mut defects);
    let objects = parts.read(&sections, is_text && !is_xml, compact_pdos, numbers, &mut defects);
    if objects.is_empty() {
        return Err(Unusable::Nothing);
    }
    let dummies = dummies(&sections, &mut defects);
    let commissioning = commissioning(&sections, &mut defects);
    let (node, node_name, bit_rate) = node(commissioning, &mut defects);
    let entries = || objects.iter().flat_map(|object| &object.entries);
    let configured = commissioning.is_some() || entries().any(|entry| entry.parameter.is_some());
    let form = match (is_text, is_xml, configured) {
        (false, _, _) => FileForm::Concise,
        (_, true, _) => FileForm::Xdd,
        (_, _, true) => FileForm::Dcf,
        (_, _, false) => FileForm::Eds,
    };
    modules(&sections, &mut defects);
    let product = device.product_name.clone().unwrap_or_default();
    let of_a_device = if matches!(form, FileForm::Dcf | FileForm::Concise) { Form::Dcf } else { Form::Eds };
    let table = Arc::new(Dictionary::new(file, of_a_device, product, entries().map(row).collect()));
    let pdos = pdos::presets(&table, &dummies, &objects, is_text.then_some(&mut defects));
    Ok(DeviceDescription {
        form,
        encoding,
        info: info(&sections),
        device,
        comments: comments(&sections),
        node,
        node_name,
        bit_rate,
        objects,
        dummies,
        table,
        pdos,
        defects: defects.by_line(),
    })
}

/// Returns true if a file that begins like this is a description and no capture.
pub fn is_description(head: &[u8]) -> bool {
    let section = |line: &[u8]| {
        let inside = line.trim_ascii_start().strip_prefix(b"[")?;
        let (name, behind) = inside.split_at_checked(inside.iter().position(|byte| *byte == b']')?)?;
        // `[1000] 60A#40..` is a stamp and a frame.
        let alone = matches!(behind.get(1..)?.trim_ascii(), [] | [b';' | b'#', ..]);
        ["FileInfo", "DeviceInfo", "1000"].iter().find(|one| alone && name.eq_ignore_ascii_case(one.as_bytes()))
    };
    head.trim_ascii_start().starts_with(b"<?xml")
        || head.split(|byte| *byte == b'\n').any(|line| section(line).is_some())
        || concise::entries(head).is_some()
}

/// Returns true for XML, which no EDS looks like.
fn is_document(text: &str) -> bool {
    text.trim_start_matches(['\u{FEFF}', ' ', '\t', '\r', '\n']).starts_with('<')
}

/// Returns a sub-object as a row of the table.
fn row(entry: &Entry) -> Object {
    let configured = entry.parameter.is_some();
    let preset = match entry.parameter.as_ref().or(entry.default.as_ref()) {
        Some(FiledValue::Whole(value)) => Some(Preset::new(*value, entry.data_type, false, configured)),
        Some(FiledValue::Offset(value)) => Some(Preset::new(*value, entry.data_type, true, configured)),
        _ => None,
    };
    Object {
        index: entry.index,
        sub: entry.sub,
        name: Arc::from(entry.name.as_str()),
        data_type: entry.data_type,
        access: Access::from_name(entry.access).unwrap_or(Access::Rw),
        preset,
        mappable: entry.mappable,
        unit: (!entry.unit.is_empty()).then(|| Arc::from(entry.unit.as_str())),
        // 0 would make every value 0: it stands for none.
        factor: if entry.factor == 0.0 { 1.0 } else { entry.factor },
    }
}

fn text(section: Option<&Section>, name: &str) -> String {
    section.and_then(|section| section.text(name)).unwrap_or_default().to_owned()
}

fn info(sections: &Sections) -> FileInfo {
    let section = sections.get("fileinfo");
    let joined = |names: &[&str]| {
        let given = names.iter().filter_map(|name| section?.get(name)).map(|given| given.value);
        given.collect::<Vec<_>>().join(" ")
    };
    FileInfo {
        name: joined(&["filename"]),
        version: joined(&["fileversion"]),
        revision: joined(&["filerevision"]),
        eds_version: joined(&["edsversion"]),
        description: joined(&["description"]),
        created: joined(&["creationdate", "creationtime", "createdby"]),
        modified: joined(&["modificationdate", "modificationtime", "modifiedby"]),
    }
}

/// Returns the device, and the mask of CompactPDO.
fn device(sections: &Sections, defects: &mut Defects) -> (Device, i128) {
    let none = Section::new("DeviceInfo", 0);
    let section = sections.get("deviceinfo").unwrap_or(&none);
    let mut whole = |name: &str| number::whole(section.get(name), defects);
    let supported = |rate: &i128| whole(&format!("baudrate_{rate}")).is_some_and(|supported| supported != 0);
    let bit_rates = BIT_RATES.into_iter().filter(supported).map(|rate| rate * 1000).collect();
    let lss = whole("lss_supported").map(|lss| lss != 0);
    let device = Device {
        vendor_name: section.text("vendorname").map(str::to_owned),
        vendor_number: whole("vendornumber"),
        product_name: section.text("productname").map(str::to_owned),
        product_number: whole("productnumber"),
        revision_number: whole("revisionnumber"),
        order_code: section.text("ordercode").map(str::to_owned),
        bit_rates,
        rpdos: whole("nrofrxpdo"),
        tpdos: whole("nroftxpdo"),
        lss,
    };
    (device, whole("compactpdo").unwrap_or(0))
}

/// Returns the data types that DummyUsage allows; the first seven have to be named.
fn dummies(sections: &Sections, defects: &mut Defects) -> Vec<u16> {
    let Some(section) = sections.get("dummyusage") else { return Vec::new() };
    let key = |kind: &u16| format!("dummy{kind:04x}");
    let missing = (1..8).filter(|kind| section.any(&key(kind)).is_none()).map(|kind| format!("Dummy{kind:04X}"));
    let missing = missing.collect::<Vec<_>>().join(", ");
    if !missing.is_empty() {
        defects.note(section.line, "dummy-missing", vec![("keys", missing.into())]);
    }
    (1..0x20).filter(|kind| number::whole(section.get(&key(kind)), defects).is_some_and(|used| used != 0)).collect()
}

/// Returns the section that CiA 306 spells with one m in the middle, and people with two.
fn commissioning<'a>(sections: &'a Sections, defects: &mut Defects) -> Option<&'a Section> {
    let other = sections.get("devicecommissioning");
    if let Some(other) = other {
        defects.note(other.line, "commissioning", vec![("section", other.name.as_str().into())]);
    }
    sections.get("devicecomissioning").or(other)
}

/// Returns node-ID, name and bit rate of a DCF.
fn node(section: Option<&Section>, defects: &mut Defects) -> (Option<u8>, String, Option<i128>) {
    let Some(of) = section else { return (None, String::new(), None) };
    let given = of.get("nodeid");
    let number = number::whole(given, defects);
    let node = number.and_then(|node| u8::try_from(node).ok()).filter(|node| matches!(node, 1..=127));
    // Both stand for a device without a node-ID.
    let unconfigured = matches!(number, None | Some(0 | 255));
    if let Some(given) = given.filter(|_| node.is_none() && !unconfigured) {
        defects.note(given.line, "node-id", vec![("value", cut(given.value, MOST_SHOWN).into())]);
    }
    let rate = number::whole(of.get("baudrate"), defects).filter(|rate| *rate > 0);
    (node, text(section, "nodename"), rate.map(|rate| rate.saturating_mul(1000)))
}

fn comments(sections: &Sections) -> Vec<String> {
    let pairs = sections.get("comments").map_or(&[][..], Section::pairs);
    let numbered = pairs.iter().filter_map(|pair| {
        let (key, digits) = pair.name.split_at_checked(4)?;
        let fits = key.eq_ignore_ascii_case("line") && digits.bytes().all(|digit| digit.is_ascii_digit());
        let number = digits.parse::<u32>().ok().filter(|_| fits && digits.len() <= 4)?;
        Some((number, pair.value.clone()))
    });
    let mut lines: Vec<_> = numbered.collect();
    lines.sort_unstable();
    lines.into_iter().map(|(_, text)| text).collect()
}

/// Notes modular devices (CiA 306, 4.8): the objects of their modules are not read.
fn modules(sections: &Sections, defects: &mut Defects) {
    let Some(section) = sections.get("supportedmodules") else { return };
    let count = section.get("nrofentries").and_then(|given| number::integer(given.value)).map(|number| number.value);
    if let Some(count) = count.filter(|count| *count > 0) {
        let facts = vec![("section", section.name.as_str().into()), ("count", count.into())];
        defects.note(section.line, "modules", facts);
    }
}

#[cfg(test)]
mod tests;
