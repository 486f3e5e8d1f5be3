//! One changed byte of a sound file never changes other records silently, and invents none.
//!
//! The first byte chooses the format, three more where a byte is changed and how, and the others are the frames. Bytes
//! that describe all frames at once and have no checksum (the head of an ASC or pcapng file) stay as they are.
#![no_main]

use canalyze_core::bytes::frame::{Buses, CanId, Frame, Stamp, StampForm};
use canalyze_core::bytes::ns::Ns;
use canalyze_core::bytes::readers::{self, Item, Reader};
use canalyze_core::bytes::writers::{CaptureFacts, Format, Writer, WriterSettings};
use libfuzzer_sys::fuzz_target;

/// Each format, how it is read, and whether a checksum covers every frame.
const FORMATS: [(Format, readers::InputFormat, bool); 5] = [
    (Format::Log, readers::InputFormat::Candump, false),
    (Format::Console, readers::InputFormat::Candump, false),
    (Format::Asc, readers::InputFormat::Asc, false),
    (Format::Pcapng, readers::InputFormat::Pcap, false),
    (Format::Mcap, readers::InputFormat::Mcap, true),
];
const ORIGIN_NS: i64 = 1_700_000_000_000_000_000;
/// Most frames of a file.
const MOST: usize = 8;

type Record = (Option<Ns>, Vec<u8>, CanId, u8, [u8; 64]);

/// The file, and where its first frame is behind.
fn written(format: Format, input: &[u8]) -> (Vec<u8>, usize) {
    let mut buses = Buses::default();
    let mut writer = Writer::new(format, &WriterSettings::default());
    let (mut out, mut begin) = (Vec::new(), 0);
    for (number, bytes) in input.chunks(5).take(MOST).enumerate() {
        let [id, payload @ ..] = bytes else { break };
        let id = CanId::standard(u16::from(*id) << 3 | number as u16 & 7);
        let mut frame = Frame::classic(id, payload);
        frame.no = number as u64 + 1;
        let t_ns = ORIGIN_NS + number as i64 * 1_237_000;
        frame.t_ns = Some(Ns(t_ns));
        frame.stamp = Some(Stamp { form: StampForm::Seconds, ns: Ns(t_ns), width: 10, decimals: 6 });
        frame.bus = buses.intern(if number % 2 == 0 || format == Format::Pcapng { b"can0" } else { b"can1" });
        let setting = CaptureFacts { buses: &buses, date_ns: None };
        writer.frame(&mut out, setting, &frame);
        if number == 0 {
            begin = out.len();
        }
    }
    writer.finish(&mut out, CaptureFacts { buses: &buses, date_ns: None });
    (out, begin)
}

/// The frames of a file, and whether it is said that something is wrong with it.
fn read(format: readers::InputFormat, bytes: &[u8]) -> (Vec<Record>, bool) {
    let mut reader = Reader::new(format, &readers::Settings { regular: true, ..readers::Settings::default() });
    let (mut buses, mut records, mut said) = (Buses::default(), Vec::new(), false);
    let mut sink = |item: &mut Item, buses: &Buses| match *item {
        Item::Frame(frame) => {
            records.push((frame.t_ns, buses.name(frame.bus).to_vec(), frame.id, frame.len, frame.data));
        }
        Item::Marker(readers::Marker::Start { .. }) | Item::Until { .. } => {}
        _ => said = true,
    };
    reader.feed(bytes, &mut buses, &mut sink);
    reader.finish(&mut buses, &mut sink);
    (records, said)
}

fuzz_target!(|input: &[u8]| {
    let [choice, high, low, change, frames @ ..] = input else { return };
    let (format, reader, checksum) = FORMATS[usize::from(*choice) % FORMATS.len()];
    let (mut file, begin) = written(format, frames);
    if file.is_empty() || *change == 0 {
        return;
    }
    let (sound, said) = read(reader, &file);
    assert!(!said && sound.len() == frames.chunks(5).take(MOST).count(), "{}", String::from_utf8_lossy(&file));
    let place = (usize::from(*high) << 8 | usize::from(*low)) % file.len();
    if !checksum && place < begin && !matches!(format, Format::Log | Format::Console) {
        return;
    }
    file[place] ^= change;
    // What a mark of a comment stands in front of was taken out by somebody.
    let marks = matches!(file[place], b'#' | b';' | b'%' | b'/' | b'-' | b'<' | b'=' | 0x80..);
    if matches!(format, Format::Log | Format::Console | Format::Asc) && marks {
        return;
    }
    let (found, said) = read(reader, &file);
    let same = sound.iter().zip(&found).take_while(|(one, other)| one == other).count();
    let (sound, found) = (&sound[same..], &found[same..]);
    let same = sound.iter().rev().zip(found.iter().rev()).take_while(|(one, other)| one == other).count();
    let (lost, new) = (sound.len() - same, found.len() - same);
    let most = if said || checksum { usize::from(!checksum) } else { 1 };
    let silent = !said && (lost > most || lost > new);
    assert!(
        !silent && new <= most.max(lost * usize::from(!checksum)),
        "{place}: {lost} became {new}\n{}",
        String::from_utf8_lossy(&file)
    );
});
