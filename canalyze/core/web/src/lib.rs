//! The core for a web page, beside the binding for Python: numbers and bytes in, bytes out.
//!
//! A page writes bytes into the buffer that [`input`] returns, calls a function, and reads as many bytes as it returned
//! from [`output`]. No pointer of JavaScript is read here: the only `unsafe` are the names of exported functions. There
//! is one session and one thread. Options are JSON with the names of `canalyze/running/reading.py` (see [`given`]),
//! columns are described by [`layout`], device descriptions are kept by [`descriptions`].

pub mod descriptions;
pub mod given;
pub mod layout;

use std::cell::RefCell;

use canalyze_core::bytes::readers::{Damage, FilePlace, InputFormat, sniff};
use canalyze_core::description::is_description;
use canalyze_core::session::Session;
use canalyze_core::settings;
use canalyze_core::tables::columns::Batch;
use canalyze_core::tables::jsonl::DAMAGES;
use serde_json::json;
use zstd::bulk::{Compressor, Decompressor};
use zstd::stream::raw::{Decoder, InBuffer, Operation, OutBuffer};

use self::descriptions::Descriptions;
use self::given::{GivenDamage, GivenFile, GivenOptions, choose};

/// Bytes that are unpacked at once.
const PIECE: usize = 128 << 10;
/// Level at which bytes are packed that the page keeps: the fastest one that packs lines of text to a fifth.
const LEVEL: i32 = 1;

#[derive(Default)]
struct State {
    input: Vec<u8>,
    output: Vec<u8>,
    session: Option<Session>,
    descriptions: Descriptions,
    packer: Option<Compressor<'static>>,
    unpacker: Option<Decompressor<'static>>,
    /// The decoders of packed files, with the number of bytes that the present frame lacks; `None` behind damage.
    unpackers: Vec<Option<(Decoder<'static>, usize)>>,
    /// The batches that were described last, whose columns the page reads in place.
    batches: Vec<Batch>,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

fn with<T>(act: impl FnOnce(&mut State) -> T) -> T {
    STATE.with(|state| act(&mut state.borrow_mut()))
}

/// Runs a call of the session, with the bytes of the input; returns the length of its output.
fn step(act: impl FnOnce(&mut Session, &[u8], &mut Vec<u8>)) -> usize {
    with(|state| {
        let State { input, output, session, .. } = state;
        output.clear();
        if let Some(session) = session {
            act(session, input, output);
        }
        output.len()
    })
}

/// Puts an error in words into the output; returns its length, 0 if there is none.
fn report(output: &mut Vec<u8>, result: Result<(), String>) -> usize {
    output.clear();
    if let Err(error) = result {
        output.extend_from_slice(error.as_bytes());
    }
    output.len()
}

/// Returns the address of a buffer of `len` bytes for the input of the next call.
#[unsafe(no_mangle)]
pub extern "C" fn input(len: usize) -> *mut u8 {
    with(|state| {
        state.input.resize(len, 0);
        state.input.as_mut_ptr()
    })
}

/// Returns the address of the output of the last call.
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const u8 {
    with(|state| state.output.as_ptr())
}

/// Begins a session with the options in the input. Returns the length of an error; 0 without one.
#[unsafe(no_mangle)]
pub extern "C" fn open() -> usize {
    with(|state| {
        let State { input, output, session, descriptions, batches, unpackers, .. } = state;
        batches.clear();
        unpackers.clear();
        *session = None;
        let options = GivenOptions::read(input).and_then(|given| given.options(descriptions));
        report(output, options.map(|options| *session = Some(Session::new(options))))
    })
}

/// Drops the session and all memory that can be returned.
#[unsafe(no_mangle)]
pub extern "C" fn close() {
    with(|state| *state = State::default());
}

/// Returns the length of the name of the format that the input begins with; 0 while more is needed to know.
#[unsafe(no_mangle)]
pub extern "C" fn sniffed(complete: bool) -> usize {
    with(|state| {
        state.output.clear();
        state.output.extend_from_slice(sniff::sniff(&state.input, complete).unwrap_or_default().as_bytes());
        state.output.len()
    })
}

/// Begins to unpack a file packed by zstd. Returns its number for the calls that follow, until the next [`open`].
#[unsafe(no_mangle)]
pub extern "C" fn unpack() -> usize {
    with(|state| {
        state.unpackers.push(Decoder::new().ok().map(|decoder| (decoder, 0)));
        state.unpackers.len() - 1
    })
}

/// Unpacks more of a file. Returns the number of bytes before its end or damage.
#[unsafe(no_mangle)]
pub extern "C" fn unpacked(number: usize) -> usize {
    with(|state| {
        let State { input, output, unpackers, .. } = state;
        output.clear();
        let Some(unpacker) = unpackers.get_mut(number) else { return 0 };
        let mut packed = InBuffer::around(input);
        let mut piece = vec![0; PIECE];
        while let Some((decoder, missing)) = unpacker {
            let mut room = OutBuffer::around(&mut piece[..]);
            let Ok(hint) = decoder.run(&mut packed, &mut room) else {
                *unpacker = None;
                break;
            };
            *missing = hint;
            let made = room.as_slice();
            output.extend_from_slice(made);
            if packed.pos() >= input.len() && made.len() < PIECE {
                break;
            }
        }
        output.len()
    })
}

/// Returns true if all that was unpacked of a file is sound and ends where it has to.
#[unsafe(no_mangle)]
pub extern "C" fn sound(number: usize) -> bool {
    with(|state| matches!(state.unpackers.get(number), Some(Some((_, 0)))))
}

/// Packs the input, so that the page can keep it. Returns the length.
#[unsafe(no_mangle)]
pub extern "C" fn packed() -> usize {
    with(|state| {
        let State { input, output, packer, .. } = state;
        if packer.is_none() {
            *packer = Compressor::new(LEVEL).ok();
        }
        *output = packer.as_mut().and_then(|packer| packer.compress(input).ok()).unwrap_or_default();
        output.len()
    })
}

/// Restores `len` bytes that [`packed`] has packed. Returns the length.
#[unsafe(no_mangle)]
pub extern "C" fn restored(len: usize) -> usize {
    with(|state| {
        let State { input, output, unpacker, .. } = state;
        if unpacker.is_none() {
            *unpacker = Decompressor::new().ok();
        }
        *output = unpacker.as_mut().and_then(|unpacker| unpacker.decompress(input, len).ok()).unwrap_or_default();
        output.len()
    })
}

/// Returns true if a file that begins like the input is a device description and no capture.
#[unsafe(no_mangle)]
pub extern "C" fn describes() -> bool {
    with(|state| is_description(&state.input))
}

/// Reads a device description; the first `name` bytes of the input are its name, the others its content. Returns the
/// length of JSON, as [`Descriptions::add`] describes it. Descriptions are numbered from 0 and stay until [`close`].
#[unsafe(no_mangle)]
pub extern "C" fn describe(name: usize) -> usize {
    with(|state| {
        let State { input, output, descriptions, .. } = state;
        let (name, content) = input.split_at_checked(name).unwrap_or_default();
        *output = descriptions.add(content, String::from_utf8_lossy(name).into_owned()).to_string().into_bytes();
        output.len()
    })
}

/// Makes a DCF as the input says. Returns the length of JSON, as [`Descriptions::configured`] describes it.
#[unsafe(no_mangle)]
pub extern "C" fn configured() -> usize {
    with(|state| {
        let State { input, output, descriptions, .. } = state;
        *output = descriptions.configured(input).to_string().into_bytes();
        output.len()
    })
}

/// Returns the node-IDs that the input spells, as a JSON list; `null` if it cannot be read.
#[unsafe(no_mangle)]
pub extern "C" fn spelled_nodes() -> usize {
    with(|state| {
        let spelled = String::from_utf8_lossy(&state.input);
        state.output = json!(settings::nodes(&spelled)).to_string().into_bytes();
        state.output.len()
    })
}

/// Begins the file that the input describes. Returns the length of an error; 0 without one.
#[unsafe(no_mangle)]
pub extern "C" fn begin(place: usize) -> usize {
    with(|state| {
        let State { input, output, session, .. } = state;
        let file = GivenFile::read(input).and_then(|file| {
            let format = match file.format.as_str() {
                "packed" => InputFormat::Packed, // records of python-can's reader
                format => choose("format", format, InputFormat::NAMES)?,
            };
            if let Some(session) = session {
                session.begin_one(place, file.name.as_bytes(), format, file.regular);
            }
            Ok(())
        });
        report(output, file)
    })
}

/// Feeds the input to a file.
#[unsafe(no_mangle)]
pub extern "C" fn feed(place: usize) -> usize {
    step(|session, input, output| session.feed_one(place, input, output))
}

/// Reports that a file goes on no further: the input has kind, offset and, if known, number of bytes from there on.
/// Returns the length of an error; 0 without one.
#[unsafe(no_mangle)]
pub extern "C" fn damaged(place: usize) -> usize {
    with(|state| {
        let State { input, output, session, .. } = state;
        let damage =
            serde_json::from_slice::<GivenDamage>(input).map_err(|error| error.to_string()).and_then(|given| {
                let kind = choose("kind", &given.kind, DAMAGES)?;
                if let Some(session) = session {
                    let place_of = FilePlace::Byte(given.offset);
                    session.damaged(place, Damage { place: place_of, kind, bytes: given.bytes, frames: None });
                }
                Ok(())
            });
        report(output, damage)
    })
}

/// Ends a file.
#[unsafe(no_mangle)]
pub extern "C" fn end(place: usize, interrupted: bool) -> usize {
    step(|session, _, output| session.end_one(place, interrupted, output))
}

/// Ends the capture.
#[unsafe(no_mangle)]
pub extern "C" fn finish() -> usize {
    step(|session, _, output| session.finish(output))
}

/// Returns true if as many frames were shown as the options allow.
#[unsafe(no_mangle)]
pub extern "C" fn done() -> bool {
    with(|state| state.session.as_ref().is_some_and(Session::is_done))
}

/// Returns the number of the file that has to be fed next; -1 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn wants() -> i32 {
    let wanted = with(|state| state.session.as_ref().and_then(Session::wants));
    wanted.and_then(|place| i32::try_from(place).ok()).unwrap_or(-1)
}

/// Returns the number of frames so far. It is exact up to 2^53.
#[unsafe(no_mangle)]
pub extern "C" fn frames() -> f64 {
    with(|state| state.session.as_mut().map_or(0.0, |session| session.frames().0 as f64))
}

/// Returns the complaints since the last call, as a JSON list.
#[unsafe(no_mangle)]
pub extern "C" fn complaints() -> usize {
    step(|session, _, output| output.extend_from_slice(json!(session.take_complaints()).to_string().as_bytes()))
}

/// Returns the counts so far, as a JSON object.
#[unsafe(no_mangle)]
pub extern "C" fn tally() -> usize {
    step(|session, _, output| *output = session.tally())
}

/// Returns the counts of each node so far, as a JSON list.
#[unsafe(no_mangle)]
pub extern "C" fn nodes() -> usize {
    step(|session, _, output| *output = session.nodes())
}

/// Returns the present state in the format `monitor`, as a JSON object.
#[unsafe(no_mangle)]
pub extern "C" fn snapshot() -> usize {
    step(|session, _, output| *output = session.snapshot())
}

/// Returns what the file holds beyond its frames, as a JSON object.
#[unsafe(no_mangle)]
pub extern "C" fn contents() -> usize {
    step(|session, _, output| *output = session.contents())
}

/// Returns the nature of the buses by its name.
#[unsafe(no_mangle)]
pub extern "C" fn nature() -> usize {
    step(|session, _, output| output.extend_from_slice(session.nature().name().as_bytes()))
}

/// Takes batches of the tables and returns their layout in JSON. Its addresses are valid until the next call of this
/// function or of [`open`].
#[unsafe(no_mangle)]
pub extern "C" fn batches(flush: bool) -> usize {
    with(|state| {
        let State { output, session, batches, .. } = state;
        output.clear();
        *batches = session.as_mut().map(|session| session.take_batches(flush)).unwrap_or_default();
        if !batches.is_empty() {
            output.extend_from_slice(layout::of(batches).to_string().as_bytes());
        }
        output.len()
    })
}
