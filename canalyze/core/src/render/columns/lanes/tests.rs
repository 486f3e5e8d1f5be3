//! Lanes against captures: every row as it stands, in both languages, and what must not be shown.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Int32Type, UInt64Type};
use arrow_array::{Array, DictionaryArray, StringArray};

use crate::readers::Format as Input;
use crate::render::columns::{Batch, Name};
use crate::session::{Format, Options, Session};
use crate::text::Lang;

#[test]
fn dump() {
    for name in std::env::var("LANES").unwrap_or_default().split(',') {
        let path = format!("{}/../../samples/{name}.log", env!("CARGO_MANIFEST_DIR"));
        let Ok(capture) = std::fs::read(path) else { continue };
        println!("== {name}");
        for row in rows(&capture, options(if std::env::var("ZH").is_ok() { Lang::Zh } else { Lang::En })) {
            println!("{row}");
        }
    }
}

fn options(lang: Lang) -> Options {
    Options { lang, format: Format::Columns, tables: vec![Name::Lanes], ..Options::default() }
}

/// `FRAME LANE CLASS STATE`, `-` for null.
fn rows(capture: &[u8], options: Options) -> Vec<String> {
    rows_in(capture, options, capture.len().max(1))
}

fn rows_in(capture: &[u8], options: Options, chunk: usize) -> Vec<String> {
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"x.log", Input::Candump, true);
    let mut batches = Vec::new();
    for piece in capture.chunks(chunk) {
        session.feed(piece, &mut out);
        batches.extend(session.take_batches(false));
    }
    session.finish(&mut out);
    batches.extend(session.take_batches(false));
    batches.iter().flat_map(listed).collect()
}

fn word(array: &dyn Array, row: usize) -> Option<String> {
    let words: &DictionaryArray<Int32Type> = array.as_dictionary();
    let values: &StringArray = words.values().as_string();
    words.is_valid(row).then(|| values.value(words.keys().value(row) as usize).to_owned())
}

fn listed(batch: &Batch) -> Vec<String> {
    let rows = &batch.rows;
    let column = |name: &str| Arc::clone(rows.column_by_name(name).unwrap());
    let (lane, state, class) = (column("lane"), column("state"), column("class"));
    let (frame, _t) = (column("frame"), column("t_ns"));
    let frame = frame.as_primitive::<UInt64Type>().clone();
    let mut all = Vec::new();
    for row in 0..rows.num_rows() {
        let dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        let (lane, class, state) = (word(&lane, row).unwrap(), word(&class, row), word(&state, row));
        all.push(format!("{} {lane} {} {}", frame.value(row), dash(class), dash(state)));
    }
    all
}
