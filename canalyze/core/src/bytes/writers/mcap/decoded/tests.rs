#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
use std::sync::Arc;

use super::super::tests::{messages, texts};
use super::super::{Loss, Mcap, McapSettings};
use super::*;
use crate::bytes::frame::{Buses, CanId};
use crate::bytes::ns::Ns;
use crate::wire::pdo::mapping::Mapping;
use crate::world::configuration::Provenance;
use crate::world::event::{ProcessData, Signals};

fn pdo(mapping: &Arc<Mapping>, frame: &Frame) -> Event {
    let content = Signals::Mapped(Arc::clone(mapping), Provenance::Eds);
    let data = ProcessData { transmit: true, number: 1, node: 5, content, state: None, sync: None, is_off: false };
    let at = frame.reference();
    Event { at, about: None, bus: frame.bus, node: Some(5), transfer: None, what: What::Pdo(data) }
}

fn written(pdos: &[(&Arc<Mapping>, &[u8])]) -> (Vec<u8>, Vec<(Loss, u64)>) {
    let mut buses = Buses::default();
    buses.intern(b"can0");
    let setting = CaptureFacts { buses: &buses, date_ns: None };
    let mut writer = Mcap::new(McapSettings { decoded: Some(Lang::En), ..McapSettings::default() });
    let mut out = Vec::new();
    for (no, (mapping, payload)) in (1..).zip(pdos) {
        let frame = Frame { no, t_ns: Some(Ns(no as i64)), ..Frame::classic(CanId::standard(0x185), payload) };
        writer.events(&mut out, setting, Some(&frame), &[pdo(mapping, &frame)]);
    }
    writer.finish(&mut out, setting);
    (out, writer.losses.iter().collect())
}

/// Topics and what stands behind the header, whose frame ID is `can0`.
fn shown(file: &[u8]) -> Vec<(String, Vec<u8>)> {
    messages(file).into_iter().map(|(topic, _, _, data)| (topic, data[21..].to_vec())).collect()
}

#[test]
fn a_topic_for_each_mapping() {
    let first = Arc::new(Mapping::from_words(&[0x2000_0008, 0x2001_0010]));
    let again = Arc::new(Mapping::from_words(&[0x2000_0008, 0x2001_0010]));
    let other = Arc::new(Mapping::from_words(&[0x2002_0008]));
    let (file, losses) =
        written(&[(&first, &[1, 2, 3]), (&other, &[9]), (&again, &[4, 5, 6]), (&first, &[7, 8]), (&other, &[8, 8])]);
    let row = |topic: &str, data: &[u8]| (topic.to_owned(), data.to_vec());
    // A frame that is too short shows what it has.
    let expected = [
        row("/can0/node5/tpdo1", &[1, 2, 3]),
        row("/can0/node5/tpdo1_v2", &[9]),
        row("/can0/node5/tpdo1", &[4, 5, 6]),
        row("/can0/node5/tpdo1_v3", &[7]),
        row("/can0/node5/tpdo1_v2", &[8]),
    ];
    assert_eq!(shown(&file), expected);
    assert_eq!(losses, []);
}

#[test]
fn definitions_and_values() {
    let mut mapping = Mapping::from_words(&[0x6041_0010, 0x2000_0110, 0x0005_0008, 0x2000_0204, 0x2000_0301]);
    mapping.entries[1].name = Some(Arc::from("Motor temperature"));
    mapping.entries[1].unit = Some(Arc::from("degC"));
    mapping.entries[1].data_type = Some(crate::world::od::DataType::Integer16);
    mapping.entries[1].factor = 0.1;
    mapping.entries[3].data_type = Some(crate::world::od::DataType::Integer8);
    mapping.entries[4].data_type = Some(crate::world::od::DataType::Boolean);
    let mapping = Arc::new(mapping);
    let (file, _) = written(&[(&mapping, &[0x37, 2, 0xD6, 0xFF, 0xAA, 0x1E])]);
    let text = texts(&file).into_iter().find(|(name, _)| name == "canalyze_msgs/msg/Can0Node5Tpdo1").unwrap().1;
    let expected = "std_msgs/Header header\n\
        # statusword, 6041h:00\nuint16 statusword\nstring statusword_text\n\
        # Motor temperature, 2000h:01, degC\nfloat64 motor_temperature\n\
        # 2000h:02\nint8 object_2000_02\n\
        # 2000h:03\nbool object_2000_03\n";
    assert_eq!(text.split("====").next().unwrap(), expected);
    let rows = shown(&file);
    assert_eq!(rows[0].0, "/can0/node5/tpdo1");
    let data = &rows[0].1;
    let words = b"operation enabled\0";
    let at = data.windows(words.len()).position(|window| window == words).unwrap() + words.len();
    assert_eq!(data[data.len() - 10..], [&(-4.2_f64).to_le_bytes()[..], &[0xFE, 1]].concat());
    assert!(data.len() - 10 - at < 8);
}
