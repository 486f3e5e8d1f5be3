//! XDD and XDC (CiA 311), the XML form of a description, as the sections of an EDS.
//!
//! Only the data that an EDS has too are read: device, file, objects with their parameters, dummies, bit rates. A document
//! type declaration is refused, since nothing here needs one and its entities can make a small file large.

use std::collections::BTreeMap;

use quick_xml::errors::{Error, IllFormedError};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::ini::{KeyLine, Section, Sections};
use super::{Defects, MOST_SHOWN, Unusable, cut, encoding};

const TOKEN: &str = "not well-formed (invalid token)";
/// Elements that name a data type.
const TYPES: [(&str, &str); 19] = [
    ("BOOL", "0x0001"),
    ("SINT", "0x0002"),
    ("INT", "0x0003"),
    ("DINT", "0x0004"),
    ("LINT", "0x0015"),
    ("USINT", "0x0005"),
    ("BYTE", "0x0005"),
    ("UINT", "0x0006"),
    ("WORD", "0x0006"),
    ("UDINT", "0x0007"),
    ("DWORD", "0x0007"),
    ("ULINT", "0x001b"),
    ("LWORD", "0x001b"),
    ("REAL", "0x0008"),
    ("LREAL", "0x0011"),
    ("CHAR", "0x0009"),
    ("STRING", "0x0009"),
    ("WSTRING", "0x000b"),
    ("BITSTRING", "0x000a"),
];
const ACCESSES: [(&str, &str); 7] = [
    ("const", "const"),
    ("read", "ro"),
    ("write", "wo"),
    ("noAccess", "ro"),
    ("readWrite", "rw"),
    ("readWriteInput", "rwr"),
    ("readWriteOutput", "rww"),
];
/// Elements of a parameter, with the key of their value.
const VALUES: [(&str, &str); 2] = [("defaultValue", "DefaultValue"), ("actualValue", "ParameterValue")];
const LIMITS: [(&str, &str); 2] = [("minValue", "LowLimit"), ("maxValue", "HighLimit")];
/// Attributes of an object, with their keys; they take precedence over the parameter that the object refers to.
const ATTRIBUTES: [(&str, &str); 6] = [
    ("name", "ParameterName"),
    ("accessType", "AccessType"),
    ("defaultValue", "DefaultValue"),
    ("actualValue", "ParameterValue"),
    ("lowLimit", "LowLimit"),
    ("highLimit", "HighLimit"),
];
const IDENTITY: [(&str, &str); 5] = [
    ("vendorName", "VendorName"),
    ("vendorID", "VendorNumber"),
    ("productName", "ProductName"),
    ("productID", "ProductNumber"),
    ("orderNumber", "OrderCode"),
];
const FILE: [(&str, &str); 8] = [
    ("fileName", "FileName"),
    ("fileVersion", "FileVersion"),
    ("fileCreator", "CreatedBy"),
    ("fileCreationDate", "CreationDate"),
    ("fileCreationTime", "CreationTime"),
    ("fileModifiedBy", "ModifiedBy"),
    ("fileModificationDate", "ModificationDate"),
    ("fileModificationTime", "ModificationTime"),
];
const FEATURES: [(&str, &str); 3] =
    [("nrOfRxPDO", "NrOfRXPDO"), ("nrOfTxPDO", "NrOfTXPDO"), ("layerSettingServiceSlave", "LSS_Supported")];

/// Returns the value of a word in a table.
fn of(table: &[(&'static str, &'static str)], word: &str) -> Option<&'static str> {
    table.iter().find(|(one, _)| *one == word).map(|(_, value)| *value)
}

/// Returns a truth value as an EDS writes it; other values are unchanged.
fn flag(value: &str) -> &str {
    match value {
        "true" => "1",
        "false" => "0",
        other => other,
    }
}

/// Reads a document, which has to be well-formed.
pub(super) fn sections(data: &[u8], defects: &mut Defects) -> Result<Sections, Unusable> {
    let text = encoding::document(data).map_err(|(line, problem)| Unusable::Xml { line, problem })?;
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let line_of = |at: usize| 1 + text.as_bytes().iter().take(at).filter(|byte| **byte == b'\n').count();
    let wrong = |at: usize, problem: &'static str| Unusable::Xml { line: line_of(at), problem };
    let is_invalid =
        |c: char| c.is_ascii_control() && !matches!(c, '\t' | '\n' | '\x7F') || matches!(c, '\u{FFFE}' | '\u{FFFF}');
    if let Some(at) = text.find(is_invalid) {
        return Err(wrong(at, TOKEN));
    }
    let mut reader = Reader::from_str(&text);
    reader.config_mut().expand_empty_elements = true;
    let mut document = Document { line: 1, ..Document::default() };
    let (mut depth, mut roots, mut at) = (0_usize, 0, 0);
    loop {
        let begin = reader.buffer_position() as usize;
        document.line +=
            text.as_bytes().get(at..begin).unwrap_or_default().iter().filter(|byte| **byte == b'\n').count();
        at = begin;
        let event = reader.read_event().map_err(|error| wrong(reader.error_position() as usize, problem(&error)))?;
        match event {
            Event::Start(tag) => {
                roots += usize::from(depth == 0);
                depth += 1;
                let name = tag.name().into_inner();
                if roots > 1 || !name.starts_with(|first: char| first.is_alphabetic() || matches!(first, '_' | ':')) {
                    return Err(wrong(at, if roots > 1 { "junk after document element" } else { TOKEN }));
                }
                if let Some(inside) = tag.find('<') {
                    return Err(wrong(at + 1 + inside, TOKEN));
                }
                let given = attributes(&tag).map_err(|problem| wrong(at, problem))?;
                document.text_ends();
                document.start(tag.local_name().into_inner(), &given, defects);
            }
            Event::End(tag) => {
                depth = depth.saturating_sub(1);
                document.text_ends();
                document.end(tag.local_name().into_inner());
            }
            Event::Text(text) if depth == 0 && text.trim().is_empty() => {}
            Event::Text(_) | Event::CData(_) | Event::GeneralRef(_) if depth == 0 => {
                return Err(wrong(at, if roots > 0 { "junk after document element" } else { "syntax error" }));
            }
            Event::Text(text) => document.text.push_str(&text),
            Event::CData(text) => document.text.push_str(&text),
            Event::GeneralRef(reference) => {
                let c = reference.resolve_char_ref().map_err(|_| wrong(at, "reference to invalid character number"))?;
                let predefined = || quick_xml::escape::resolve_predefined_entity(&reference);
                match (c, predefined()) {
                    (Some(c), _) => document.text.push(c),
                    (None, Some(text)) => document.text.push_str(text),
                    (None, None) => return Err(wrong(at, "undefined entity")),
                }
            }
            Event::DocType(_) => return Err(Unusable::Doctype),
            Event::Comment(_) | Event::PI(_) | Event::Decl(_) | Event::Empty(_) => {}
            Event::Eof if depth == 0 && roots > 0 => return Ok(document.sections()),
            Event::Eof => return Err(wrong(at, "no element found")),
        }
    }
}

/// Returns the problem in the words of other XML parsers.
fn problem(error: &Error) -> &'static str {
    match error {
        Error::IllFormed(IllFormedError::MismatchedEndTag { .. } | IllFormedError::UnmatchedEndTag(_)) => {
            "mismatched tag"
        }
        Error::Syntax(_) => "unclosed token",
        _ => TOKEN,
    }
}

/// The attributes of an element.
type Attributes = BTreeMap<String, String>;

fn attributes(tag: &BytesStart<'_>) -> Result<Attributes, &'static str> {
    let mut all = Attributes::new();
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.map_err(|_| TOKEN)?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|_| "undefined entity")?;
        if all.insert(attribute.key.into_inner().to_owned(), value.into_owned()).is_some() {
            return Err("duplicate attribute");
        }
    }
    Ok(all)
}

/// The content of the elements so far.
#[derive(Default)]
struct Document {
    sections: Sections,
    /// Keys of the parameters, by their ID.
    parameters: BTreeMap<String, BTreeMap<&'static str, String>>,
    /// The ID of the parameter that is open.
    parameter: Option<String>,
    /// The parameter of each object, by the place of its section.
    references: BTreeMap<usize, String>,
    index: String,
    identity: Option<&'static str>,
    /// Text since the last tag.
    text: String,
    line: usize,
}

impl Document {
    /// Returns the sections, objects with the parameters they refer to.
    fn sections(mut self) -> Sections {
        for (place, reference) in self.references {
            let Some(section) = self.sections.at(place) else { continue };
            for (key, value) in self.parameters.get(&reference).into_iter().flatten() {
                section.complete(key, value);
            }
            if section.get("datatype").is_some() {
                section.complete("AccessType", "ro");
            }
        }
        self.sections
    }

    fn put(&mut self, section: &str, key: &str, value: &str) {
        let (place, _) = self.sections.open(section, self.line);
        if let Some(section) = self.sections.at(place) {
            section.put(KeyLine { name: key.to_owned(), value: value.trim().to_owned(), line: self.line });
        }
    }

    fn put_all(&mut self, section: &str, table: &[(&str, &str)], given: &Attributes, read: fn(&str) -> &str) {
        for (attribute, key) in table {
            if let Some(value) = given.get(*attribute) {
                self.put(section, key, read(value));
            }
        }
    }

    /// Takes the text before a tag.
    fn text_ends(&mut self) {
        let text = std::mem::take(&mut self.text);
        if let Some(key) = self.identity.filter(|_| !text.trim().is_empty()) {
            self.put("DeviceInfo", key, &text);
        }
    }

    fn start(&mut self, tag: &str, given: &Attributes, defects: &mut Defects) {
        let attribute = |name: &str| given.get(name).map_or("", String::as_str);
        if tag == "CANopenObject" {
            self.index = attribute("index").to_owned();
            self.object(attribute("index"), given, defects);
        } else if tag == "CANopenSubObject" {
            self.object(&format!("{}sub{}", self.index, attribute("subIndex")), given, defects);
        } else if tag == "parameter" {
            let access = given.get("access").map_or("ro", |access| of(&ACCESSES, access).unwrap_or("ro"));
            let id = attribute("uniqueID").to_owned();
            let new = || BTreeMap::from([("AccessType", access.to_owned())]);
            self.parameters.entry(id.clone()).or_insert_with(new);
            self.parameter = Some(id);
        } else if let Some(parameter) = self.parameter.as_ref().and_then(|id| self.parameters.get_mut(id)) {
            if let Some(data_type) = of(&TYPES, tag) {
                parameter.insert("DataType", data_type.to_owned());
            } else if let Some(key) = of(&VALUES, tag) {
                parameter.insert(key, flag(attribute("value")).to_owned());
            } else if let Some(key) = of(&LIMITS, tag) {
                parameter.insert(key, attribute("value").to_owned());
            }
        } else if let Some(key) = of(&IDENTITY, tag) {
            self.identity = Some(key);
        } else {
            self.device(tag, given);
        }
    }

    fn end(&mut self, tag: &str) {
        self.identity = None;
        if tag == "parameter" {
            self.parameter = None;
        }
    }

    fn device(&mut self, tag: &str, given: &Attributes) {
        let attribute = |name: &str| given.get(name).map_or("", String::as_str);
        match tag {
            "ProfileBody" => self.put_all("FileInfo", &FILE, given, |value| value),
            "CANopenGeneralFeatures" => self.put_all("DeviceInfo", &FEATURES, given, flag),
            "dummy" => {
                let entry = attribute("entry");
                let (key, value) = entry.split_once('=').unwrap_or((entry, ""));
                self.put("DummyUsage", key, value);
            }
            "supportedBaudRate" => {
                let rate = attribute("value").split(' ').next().unwrap_or_default();
                self.put("DeviceInfo", &format!("BaudRate_{rate}"), "1");
            }
            "deviceCommissioning" => {
                for (name, value) in given {
                    self.put("DeviceComissioning", name, value.strip_suffix(" Kbps").unwrap_or(value));
                }
            }
            _ => {}
        }
    }

    fn object(&mut self, name: &str, given: &Attributes, defects: &mut Defects) {
        let mut section = Section::new(name, self.line);
        let mut put = |key: &str, value: &str| {
            section.put(KeyLine { name: key.to_owned(), value: value.trim().to_owned(), line: self.line });
        };
        for (attribute, key) in ATTRIBUTES {
            if let Some(value) = given.get(attribute) {
                put(key, value);
            }
        }
        put("ObjectType", given.get("objectType").map_or("7", String::as_str));
        put("PDOMapping", if given.get("PDOmapping").is_none_or(|mapping| mapping == "no") { "0" } else { "1" });
        if let Some(data_type) = given.get("dataType") {
            put("DataType", &format!("0x{}", data_type.strip_prefix("0x").unwrap_or(data_type)));
        }
        if let Some(number) = given.get("subNumber") {
            put("SubNumber", number);
        }
        let (place, found) = self.sections.open(name, self.line);
        if let Some(held) = self.sections.at(place) {
            if found {
                let facts = vec![("section", cut(name, MOST_SHOWN).into()), ("first", held.line.into())];
                defects.note(self.line, "duplicate-section", facts);
            }
            *held = section;
        }
        self.references.insert(place, given.get("uniqueIDRef").cloned().unwrap_or_default());
    }
}
