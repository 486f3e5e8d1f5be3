//! No false statement: what is said of an excerpt is true of the whole, or marked as not known or incomplete.
//!
//! It must not ask for completeness.

use super::cut::Excerpt;
use super::{Input, Sent, Truth, conversation};
use canalyze_core::bytes::readers::InputFormat as Reader;
use canalyze_core::session::{Options, Output, Rows, Session};
use canalyze_core::words::Lang;
use serde_json::Value;

/// What is true of every excerpt that lacks frames: so many were lost, and requests have no response in it.
const MISSING: [&str; 3] = ["CAP002", "SDO024", "SDO031"];
/// A write that was refused and not made good later: it may be made good behind a cut.
const REFUSED: &str = "SDO018";

/// A case: the truth, what is left of it, and what is said falsely of that.
pub struct Case {
    pub excerpt: Excerpt,
    pub text: String,
    pub falsehoods: Vec<String>,
}

/// Builds a case from arbitrary bytes, and judges it.
pub fn judge(bytes: &[u8]) -> Case {
    let mut input = Input(bytes);
    let options = input.byte();
    let mut cutting = [0; 24];
    cutting.iter_mut().for_each(|byte| *byte = input.byte());
    let (truths, frames) = conversation(&mut input);
    let mut excerpt = Excerpt::whole(frames.clone());
    let mut cutting = Input(&cutting);
    for _ in 0..=(options >> 1 & 1) {
        excerpt.cut(&mut cutting);
    }
    let lang = if options & 1 == 0 { Lang::Zh } else { Lang::En };
    let whole = Excerpt::whole(frames);
    let all = rows(&whole.text(), lang);
    let mut falsehoods = Vec::new();
    of_whole(&truths, &whole.frames, &all, &mut falsehoods);
    let text = excerpt.text();
    if falsehoods.is_empty() && !excerpt.frames.is_empty() {
        let said = rows(&text, lang);
        let texts = texts(&whole.frames, &all);
        let judged = Judged { truths: &truths, excerpt: &excerpt, texts };
        judged.falsehoods(&said, &mut falsehoods);
    }
    Case { excerpt, text, falsehoods }
}

/// Every line of the JSON output.
fn rows(text: &str, lang: Lang) -> Vec<Value> {
    let mut session = Session::new(Options::of(lang, &[Output::json(Rows::Frames)]));
    let mut out = Vec::new();
    session.begin(b"capture.log", Reader::Candump, true);
    session.feed(text.as_bytes(), &mut out);
    session.end(false, &mut out);
    session.finish(&mut out);
    let out = String::from_utf8(out).expect("output is UTF-8");
    out.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))).collect()
}

fn of_kind<'a>(rows: &'a [Value], kind: &'a str) -> impl Iterator<Item = &'a Value> {
    rows.iter().filter(move |row| row["kind"] == kind)
}

/// The whole conversation is clean, and is decoded as it was made.
fn of_whole(truths: &[Truth], frames: &[Sent], rows: &[Value], falsehoods: &mut Vec<String>) {
    for row in of_kind(rows, "finding").filter(|row| row["severity"] != "info" && row["code"] != REFUSED) {
        falsehoods.push(format!("whole: finding {} {}", row["code"], row["message"]));
    }
    for row in of_kind(rows, "transfer") {
        let truth = &truths[transfer_of(frames, &row["first_frame"]).expect("a transfer's frame")];
        let status = if truth.abort.is_none() { "ok" } else { "aborted" };
        let same = row["status"] == status && (status != "ok" || row["data"] == hex(&truth.data).as_str());
        if !same || row["index"] != format!("{:04X}", truth.object.0).as_str() {
            falsehoods.push(format!("whole: {} {} {}", row["status"], row["index"], row["data"]));
        }
    }
    let count = of_kind(rows, "transfer").count();
    if count != truths.len() {
        falsehoods.push(format!("whole: {count} transfers of {}", truths.len()));
    }
}

/// Which transfer a frame of the capture belongs to; its number counts from 1.
fn transfer_of(frames: &[Sent], number: &Value) -> Option<usize> {
    let place = usize::try_from(number.as_u64()?).ok()?.checked_sub(1)?;
    frames.get(place)?.transfer
}

/// What is said in words of each frame of the whole, by the frame, and of each transfer.
struct Texts {
    frames: Vec<(u16, Vec<u8>, Option<usize>, String)>,
    transfers: String,
}

fn texts(frames: &[Sent], rows: &[Value]) -> Texts {
    let text = |row: &Value| row["text"].as_str().unwrap_or("").to_owned();
    let said = of_kind(rows, "frame").map(text);
    let frames = frames.iter().zip(said).map(|(frame, said)| (frame.id, frame.data.clone(), frame.transfer, said));
    let transfers = of_kind(rows, "transfer").map(text).collect::<Vec<_>>().join("\n");
    Texts { frames: frames.collect(), transfers }
}

struct Judged<'a> {
    truths: &'a [Truth],
    excerpt: &'a Excerpt,
    texts: Texts,
}

impl Judged<'_> {
    fn falsehoods(&self, rows: &[Value], falsehoods: &mut Vec<String>) {
        for (row, frame) in of_kind(rows, "frame").zip(&self.excerpt.frames) {
            if frame.transfer.is_some() && row["sdo"].is_object() {
                self.of_frame(row, frame, falsehoods);
            } else if frame.transfer.is_none() != row["sdo"].is_null() {
                falsehoods.push(format!("service: frame {} is {}", row["frame"], row["service"]));
            }
        }
        of_kind(rows, "transfer").for_each(|row| self.of_transfer(row, falsehoods));
        let refused = self.truths.iter().any(|truth| !truth.upload && truth.abort.is_some());
        let known = |code: &Value| MISSING.iter().any(|known| code == known) || (refused && code == REFUSED);
        let above = |row: &&Value| row["severity"] != "info" && !known(&row["code"]);
        for row in of_kind(rows, "finding").filter(above).filter(|_| !self.excerpt.unannounced) {
            falsehoods.push(format!("finding {} at {}: {}", row["code"], row["frame"], row["message"]));
        }
    }

    fn of_frame(&self, row: &Value, frame: &Sent, falsehoods: &mut Vec<String>) {
        let truth = &self.truths[frame.transfer.unwrap_or(0)];
        let (sdo, text) = (&row["sdo"], row["text"].as_str().unwrap_or(""));
        let where_ = format!("frame {} {:03X}#{}: {text:?}", row["frame"], frame.id, hex(&frame.data));
        let (index, sub) = truth.object;
        if !sdo["index"].is_null() && (sdo["index"] != format!("{index:04X}").as_str() || sdo["sub"] != sub) {
            falsehoods.push(format!("object {where_}, is {index:04X}:{sub}"));
        } else if sdo["command"] != frame.command && sdo["command"] != "undetermined" {
            falsehoods.push(format!("command {where_}, is {}", frame.command));
        } else if !text.contains("[incomplete]") && !text.contains("[不完整]") {
            let stated = |said: &&str| {
                let known = |(id, data, transfer, whole): &(u16, Vec<u8>, Option<usize>, String)| {
                    (*id, data, *transfer) == (frame.id, &frame.data, frame.transfer) && whole.contains(*said)
                };
                !self.texts.frames.iter().any(known) && !self.texts.transfers.contains(*said)
            };
            falsehoods.extend(values(text).filter(stated).map(|said| format!("value {where_}: {said}")));
        }
    }

    fn of_transfer(&self, row: &Value, falsehoods: &mut Vec<String>) {
        let frames = &self.excerpt.frames;
        let Some(number) = transfer_of(frames, &row["first_frame"]) else {
            return falsehoods.push(format!("phantom {}", where_(row)));
        };
        let said = self.claims(row, number);
        let other = transfer_of(frames, &row["last_frame"]).filter(|last| self.is_like(number, *last));
        let undecidable = other.is_some_and(|last| self.at_late_edge(row) && self.claims(row, last).is_empty());
        if !undecidable {
            falsehoods.extend(said);
        }
    }

    /// Whether two transfers ask for the same thing.
    fn is_like(&self, one: usize, other: usize) -> bool {
        let (one, other) = (&self.truths[one], &self.truths[other]);
        (one.object, one.upload) == (other.object, other.upload)
    }

    /// Whether a transfer begins with the first request of its channel, in a capture that lists requests late: the answer
    /// may lie before the capture, and an answer that comes be that of the next request of the same object, which is
    /// listed behind it. No reader can tell.
    fn at_late_edge(&self, row: &Value) -> bool {
        let frames = &self.excerpt.frames;
        let first = row["first_frame"].as_u64().and_then(|number| usize::try_from(number).ok()?.checked_sub(1));
        let Some((place, request)) = first.and_then(|place| Some((place, frames.get(place)?))) else { return false };
        self.excerpt.is_late() && !frames[..place].iter().any(|frame| frame.id == request.id && request.is_client())
    }

    /// What a row says falsely of a transfer.
    fn claims(&self, row: &Value, number: usize) -> Vec<String> {
        let mut falsehoods = Vec::new();
        let where_ = where_(row);
        let truth = &self.truths[number];
        let (index, sub) = truth.object;
        let status = if truth.abort.is_none() { "ok" } else { "aborted" };
        let incomplete = row["status"] == "incomplete" || row["status"] == "open";
        let data = hex(&truth.data);
        let mut claim = |kind: &str, holds: bool| {
            if !holds {
                falsehoods.push(format!("{kind} {where_}, is {truth:?}"));
            }
        };
        // Of a refused transfer there are no data.
        let same = row["status"] == status && (truth.abort.is_some() || row["data"] == data.as_str());
        claim("joined", same || transfer_of(&self.excerpt.frames, &row["last_frame"]) == Some(number));
        claim(
            "object",
            row["index"].is_null() || (row["index"] == format!("{index:04X}").as_str() && row["sub"] == sub),
        );
        claim("direction", row["direction"] == if truth.upload { "upload" } else { "download" });
        claim("status", incomplete || row["status"] == status);
        claim("value", row["status"] != "ok" || row["data"] == data.as_str());
        claim("size", row["size_indicated"].is_null() || row["size_indicated"] == truth.data.len());
        claim("mode", incomplete || row["mode"] == truth.mode || truth.abort.is_some());
        let abort = truth.abort.map(|code| format!("{code:08X}"));
        claim("abort", row["abort"].is_null() || row["abort"]["code"].as_str() == abort.as_deref());
        let placed = placed(row, &truth.data);
        claim("placed", placed.is_ok());
        let lacks = row["size"].as_u64() < Some(truth.data.len() as u64) && row["size"] != 0;
        claim("hole", !incomplete || !lacks || row["holes"].is_array());
        claim("requested", row["requested"].is_null() || (!truth.upload && truth.mode == "expedited"));
        falsehoods
    }
}

/// What a row of the list of transfers says, in short.
fn where_(row: &Value) -> String {
    format!(
        "transfer of frames {}..{}: {} {} {}:{} = {} {}",
        row["first_frame"],
        row["last_frame"],
        row["direction"],
        row["mode"],
        row["index"],
        row["sub"],
        row["data"],
        row["status"]
    )
}

/// Whether the bytes that are given stand in the data, each at its place where that is known, and holes are as long as
/// what they lack.
fn placed(row: &Value, truth: &[u8]) -> Result<(), ()> {
    let text = row["data"].as_str().ok_or(())?;
    let data: Vec<u8> =
        (0..text.len() / 2).filter_map(|at| u8::from_str_radix(text.get(2 * at..2 * at + 2)?, 16).ok()).collect();
    let mut given: Vec<Option<u8>> = data.iter().copied().map(Some).collect();
    let holes: Vec<(usize, Option<u64>)> = row["holes"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|hole| (hole["offset"].as_u64().unwrap_or(0) as usize, hole["length"].as_u64()))
        .collect();
    let mut known = true;
    for (offset, length) in &holes {
        if let Some(length) = length.filter(|_| *offset == data.len()) {
            // Only the end is missing.
            let whole = data.len() as u64 + length == truth.len() as u64;
            known.then_some(()).filter(|()| whole).ok_or(())?;
        }
        let end = length.map_or(0, |length| offset + length as usize);
        given.iter_mut().take(end).skip(*offset).for_each(|byte| *byte = None);
        known &= length.is_some();
    }
    let mut begin = 0;
    let ends: Vec<usize> = holes.iter().filter(|(_, length)| length.is_none()).map(|(offset, _)| *offset).collect();
    for (number, end) in ends.iter().copied().chain([given.len()]).enumerate() {
        let run = given.get(begin..end).ok_or(())?;
        let stands = |at: &usize| {
            truth.get(*at..).is_some_and(|there| {
                run.len() <= there.len()
                    && run.iter().zip(there).all(|(one, other)| one.is_none_or(|one| one == *other))
            })
        };
        let mut places = if number == 0 { 0..=0 } else { 0..=truth.len() };
        places.find(stands).ok_or(())?;
        begin = end;
    }
    Ok(())
}

/// What a text states as values: each ` = ` up to the next `;`, without what is said about it.
fn values(text: &str) -> impl Iterator<Item = &str> {
    text.split(';').filter_map(|part| part.split_once(" = ")).map(|(_, value)| {
        let value = value.split_once(" [").map_or(value, |(value, _)| value);
        value
            .rsplit_once(" (")
            .filter(|(_, size)| size.ends_with("bytes)") || size.ends_with("byte)") || size.ends_with("字节)"))
            .map_or(value, |(value, _)| value)
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}
