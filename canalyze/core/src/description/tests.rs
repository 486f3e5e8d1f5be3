//! The repairs are tested on the product, in `tests/test_eds_*.py`; here stands what holds for any bytes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use proptest::prelude::*;

use super::*;

const XML: &str = r#"<?xml version="1.0"?><C><CANopenObject index="1800" name="c" objectType="9">
<CANopenSubObject subIndex="01" name="i" dataType="0007" accessType="rw" defaultValue="$NODEID+0x180"/>
</CANopenObject></C>"#;
const VALUES: [&str; 12] = [
    "",
    "$NODEID",
    "$NODEID+$NODEID",
    "0xFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFF",
    "-99999999999999999999999999999999999999",
    "nan",
    "1e999",
    "0b1",
    "; x",
    "[x]",
    "0",
    "255",
];
const LINES: [&str; 12] = [
    "[",
    "=",
    "[1800sub1]",
    "[1A00Name]",
    "[1A00Value]",
    "[1800subFF]",
    "[0005]",
    "CompactSubObj=254",
    "CompactPDO=0xFF",
    "NrOfRXPDO=100000",
    "ObjectType=8",
    "\0",
];

fn own() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../eds");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|file| fs::read_to_string(file).unwrap()).collect()
}

fn text(data: &[u8]) -> Result<DeviceDescription, Unusable> {
    read(data, "x.eds".to_owned())
}

/// Checks a description that was read of any bytes.
fn check(data: &[u8]) {
    let Ok(found) = text(data) else { return };
    assert!(found.objects.is_sorted_by(|one, next| one.index < next.index));
    assert!(found.objects.iter().all(|object| object.entries.is_sorted_by(|one, next| one.sub < next.sub)));
    assert!(found.defects.is_sorted_by_key(|defect| defect.line));
    let lines = data.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() + 1;
    assert!(found.defects.iter().all(|defect| defect.line <= lines));
    let entries = found.objects.iter().map(|object| object.entries.len()).sum::<usize>();
    assert_eq!(found.table.objects().len(), entries);
}

fn changed() -> impl Strategy<Value = Vec<u8>> {
    let change =
        (any::<prop::sample::Index>(), 0..5, prop::sample::select(&VALUES[..]), prop::sample::select(&LINES[..]));
    let texts: Vec<String> = own().into_iter().chain([XML.to_owned()]).collect();
    (prop::sample::select(texts), prop::collection::vec(change, 1..12)).prop_map(|(text, changes)| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        for (place, kind, value, line) in changes {
            let place = place.index(lines.len());
            match kind {
                0 => lines.insert(place, line.to_owned()),
                1 => lines[place] = format!("{}={value}", lines[place].split('=').next().unwrap()),
                2 => lines.insert(place, lines[place].clone()),
                3 => lines.rotate_left(place),
                _ => lines[place].truncate(3),
            }
        }
        lines.join("\n").into_bytes()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_bytes_are_read_or_refused(data in prop::collection::vec(any::<u8>(), 0..300), ahead in any::<bool>()) {
        let head: &[u8] = if ahead { b"[2000]\nParameterName=x\n" } else { b"" };
        check(&[head, &data].concat());
        is_description(&data);
    }

    #[test]
    fn any_change_of_a_description_is_read_or_refused(data in changed()) {
        check(&data);
    }
}

#[test]
fn a_stamp_in_brackets_begins_no_description() {
    for (head, is) in [
        ("[1000]\nParameterName=x\n", true),
        ("  [FileInfo] ; of a tool\r\n", true),
        ("[1000] 60A#4017100000000000\n", false),
        ("[1000] can0 60A [8] 40 17 10 00 00 00 00 00\n", false),
        ("[1000", false),
    ] {
        assert_eq!(is_description(head.as_bytes()), is, "{head}");
    }
}

#[test]
fn own_descriptions_have_no_defect_and_take_any_value() {
    for file in own() {
        let found = text(file.as_bytes()).unwrap();
        assert!(found.objects.len() > 10 && found.defects.is_empty() && is_description(file.as_bytes()));
        let one = [(0x1017, 0), (0x1005, 0), (0x9FFF, 0)];
        let values = BTreeMap::from(one.map(|address| (address, vec![0x64, 0])));
        let made = configured(file.as_bytes(), &values, 7, &[("FileName".to_owned(), "x.dcf".to_owned())]).unwrap();
        let dcf = text(made.text.as_bytes()).unwrap();
        assert_eq!((dcf.form, dcf.node, dcf.info.name.as_str()), (FileForm::Dcf, Some(7), "x.dcf"));
        assert!(made.left_out.contains(&(0x9FFF, 0)));
        let entry =
            |index| dcf.objects.iter().find(|object| object.index == index).unwrap().entries[0].parameter.clone();
        assert_eq!(entry(0x1017), Some(FiledValue::Whole(100)));
        assert_eq!(
            dcf.table.get(0x1017, 0).unwrap().preset.map(|preset| (preset.value, preset.configured)),
            Some((100, true))
        );
    }
}

#[test]
fn the_table_has_the_number_that_a_device_starts_with() {
    let object = |index: u16, keys: &str| format!("[{index:04X}]\nParameterName=x\nAccessType=rww\n{keys}\n");
    let file = [
        object(0x2000, "DataType=3\nDefaultValue=-2"),
        object(0x2001, "DataType=7\nDefaultValue=$NODEID+0x80\nPDOMapping=1\nUnit=mm\nFactor=0.5"),
        object(0x2002, "DataType=5\nDefaultValue=1\nParameterValue=3\nFactor=0"),
        object(0x2003, "DataType=9\nDefaultValue=7"),
    ];
    let table = text(file.concat().as_bytes()).unwrap().table;
    let rows =
        table.objects().iter().map(|row| (row.preset, row.mappable, row.unit.as_deref(), row.factor, row.access));
    let preset = |value, relative, configured| Some(Preset { value, relative, configured });
    let expected = [
        (preset(0xFFFE, false, false), false, None, 1.0, Access::Rw),
        (preset(0x80, true, false), true, Some("mm"), 0.5, Access::Rw),
        (preset(3, false, true), false, None, 1.0, Access::Rw),
        (None, false, None, 1.0, Access::Rw),
    ];
    assert_eq!(rows.collect::<Vec<_>>(), expected);
    assert_eq!((table.file.as_str(), table.form), ("x.eds", Form::Dcf));
}

#[test]
fn xml_that_is_not_well_formed_is_refused_at_its_line() {
    let cases = [
        ("<a>\n<b>\n</a>", 3, "mismatched tag"),
        ("<a>\n<b>", 2, "no element found"),
        ("<a/>\n<b/>", 2, "junk after document element"),
        ("<a/>\nx", 1, "junk after document element"),
        ("<a>\n&x;</a>", 2, "undefined entity"),
        ("<a>\n&#0;</a>", 2, "reference to invalid character number"),
        ("<a>\n\n<b c='1' c='2'/></a>", 3, "duplicate attribute"),
        ("<a>\n<b c='<'/></a>", 2, "not well-formed (invalid token)"),
        ("<a>\n\u{1}</a>", 2, "not well-formed (invalid token)"),
        ("<a>\n<b", 2, "unclosed token"),
        ("<?xml version='1.0' encoding='x'?><a/>", 1, "unknown encoding"),
        ("<?xml version='1.0' encoding='utf-16'?><a/>", 1, "encoding specified in XML declaration is incorrect"),
    ];
    for (document, line, problem) in cases {
        assert_eq!(text(document.as_bytes()).unwrap_err(), Unusable::Xml { line, problem }, "{document}");
    }
    assert_eq!(
        text(b"<a>\n\xff</a>").unwrap_err(),
        Unusable::Xml { line: 2, problem: "not well-formed (invalid token)" }
    );
    assert_eq!(text(b"<!DOCTYPE a><a/>").unwrap_err(), Unusable::Doctype);
}

#[test]
fn xml_is_read_in_the_encoding_that_it_names() {
    let document = |encoding: &str, name: &[u8]| {
        let head =
            format!("<?xml version='1.0' encoding='{encoding}'?><a><CANopenObject index='2000' dataType='0005' name='");
        let found = text(&[head.as_bytes(), name, b"'/></a>"].concat()).unwrap();
        found.objects[0].name.clone()
    };
    assert_eq!(document("utf-8", "Größe".as_bytes()), "Größe");
    assert_eq!(document("ISO-8859-1", b"Gr\xF6\xDFe"), "Größe");
    assert_eq!(document("gb2312", b"\xCB\xC5\xB7\xFE"), "伺服");
    let units = "<a><CANopenObject index='2000' dataType='0005' name='Größe'/></a>".encode_utf16();
    let wide: Vec<u8> = units.flat_map(u16::to_le_bytes).collect();
    assert_eq!(text(&wide).unwrap().objects[0].name, "Größe");
}

#[test]
fn a_written_real_is_read_as_the_same_value() {
    let cases = [
        (0.1, "0.1"),
        (100.0, "100.0"),
        (1e16, "1e+16"),
        (1e15, "1000000000000000.0"),
        (1.5e-7, "1.5e-07"),
        (-2.5, "-2.5"),
    ];
    for (real, written) in cases {
        let data = f64::to_le_bytes(real);
        assert_eq!(number::spelled(&data, crate::world::od::DataType::Real64).as_deref(), Some(written));
    }
    assert_eq!(number::spelled(&f32::NAN.to_le_bytes(), crate::world::od::DataType::Real32), None);
}
