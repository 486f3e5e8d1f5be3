//! Laws of every kind of output of the same frames, for the targets whose frames carry transfers.

use std::collections::BTreeMap;

use canalyze_core::bytes::frame::{Frame, Stamp, StampForm};
use canalyze_core::bytes::ns::Ns;
use canalyze_core::sdo::transfer::{Hole, KEPT, Status};
use canalyze_core::session::{Options, Output, Rows, Session};
use canalyze_core::words::{Depth, Lang};
use serde_json::Value;

/// Sets the line and the stamp of a frame behind `before` others.
pub fn place(frame: &mut Frame, before: usize, t_ns: Option<Ns>) {
    frame.line = Some(before as u64 + 1);
    frame.t_ns = t_ns;
    frame.stamp = t_ns.map(|ns| Stamp { form: StampForm::Seconds, ns, width: 3, decimals: 6 });
}

/// The bytes of a transfer that are handed out, how it ended, and its holes.
type File = (Vec<u8>, Option<Status>, Vec<Hole>);

/// Returns the output of a session for the frames, and the bytes of each transfer that it hands out.
fn run(frames: &[Frame], options: Options) -> (String, BTreeMap<String, File>) {
    // Frames are pushed on one thread; without the number each session asks the system how many it has.
    let mut session = Session::new(Options { threads: Some(1), ..options });
    let mut out = Vec::new();
    let mut files: BTreeMap<String, File> = BTreeMap::new();
    for frame in frames {
        session.push(*frame, &mut out);
    }
    session.finish(&mut out);
    for piece in session.take_extracted() {
        let (bytes, status, holes) = files.entry(piece.name).or_default();
        assert_eq!(*status, None, "bytes of a transfer that has ended");
        bytes.extend_from_slice(&piece.bytes);
        (*status, *holes) = (piece.status, piece.holes);
    }
    assert_eq!(session.frames().0, frames.len() as u64);
    assert!(session.take_complaints().is_empty());
    (String::from_utf8(out).expect("output is UTF-8"), files)
}

fn rows(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))).collect()
}

fn of_kind<'a>(rows: &'a [Value], kind: &str) -> Vec<&'a Value> {
    rows.iter().filter(|row| row["kind"] == kind).collect()
}

fn check_transfer(transfer: &Value, frames: &[Frame]) {
    let size = transfer["size"].as_u64().expect("a size");
    let kept = transfer["data"].as_str().expect("data").len() as u64 / 2;
    assert!(kept <= size && kept <= KEPT as u64, "{transfer}");
    // Transfers are put together in the order of time, which a step back makes another one than that of the numbers.
    let number =
        |name: &str| transfer[name].as_u64().and_then(|number| usize::try_from(number).ok()).expect("a number");
    let (first, last) = (number("first_frame"), number("last_frame"));
    assert!(first <= last || frames[first - 1].t_ns < frames[last - 1].t_ns, "{transfer}");
    assert_ne!(transfer["status"], "open", "{transfer}");
}

fn check_text(frames: &[Frame], lang: Lang, depth: Depth) {
    let mut options = Options::of(lang, &[Output::Lines]);
    options.writing.depth = depth;
    let (text, _) = run(frames, options);
    assert_eq!(text.lines().filter(|line| !line.starts_with('#')).count(), frames.len(), "a line a frame");
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "nothing that controls a terminal");
}

fn check_json(frames: &[Frame], lang: Lang) {
    let (lines, _) = run(frames, Options::of(lang, &[Output::json(Rows::Frames)]));
    let all = rows(&lines);
    let numbers: Vec<u64> = of_kind(&all, "frame").iter().filter_map(|row| row["frame"].as_u64()).collect();
    assert_eq!(numbers, (1..=frames.len() as u64).collect::<Vec<_>>(), "a line a frame, in order");
    let said = of_kind(&all, "transfer");
    said.iter().for_each(|transfer| check_transfer(transfer, frames));

    let mut options = Options::of(lang, &[Output::json(Rows::Transfers)]);
    options.writing.extract = true;
    let (lines, files) = run(frames, options);
    let transfers = rows(&lines);
    assert_eq!(said, transfers.iter().collect::<Vec<_>>(), "the same transfers");
    for transfer in &transfers {
        let number = format!("{:05}_", transfer["transfer"].as_u64().expect("a number"));
        let mut files = files.iter().filter(|(name, _)| name.starts_with(&number));
        let (_, (bytes, status, holes)) = files.next().expect("a file a transfer");
        assert!(files.next().is_none(), "one file a transfer: {transfer}");
        let size = transfer["size"].as_u64().expect("a size");
        let filled: u64 = holes.iter().filter(|hole| hole.offset < size).filter_map(|hole| hole.length).sum();
        // Of a write that was not confirmed, what was requested is handed out.
        let requested = size == 0 && !transfer["text"].as_str().unwrap_or("").is_empty();
        assert!(requested || bytes.len() as u64 + filled == size, "{transfer}");
        assert_eq!(status.map(Status::name), transfer["status"].as_str());
    }
}

/// Checks one kind of output, which the bits of `options` set: bit 0 the language, bits 2 and 3 the output. One at a time,
/// since two would halve what can be tried.
pub fn check(frames: &[Frame], options: u8) {
    let lang = if options & 1 == 0 { Lang::Zh } else { Lang::En };
    match options >> 2 & 3 {
        0 | 1 => check_json(frames, lang),
        2 => check_text(frames, lang, Depth::Default),
        _ => check_text(frames, lang, Depth::Explain),
    }
}
