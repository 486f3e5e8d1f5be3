//! Cells of CSV (RFC 4180). Must not: know what is in them.

use crate::words::digits::put;
use crate::words::escape;

/// A cell of CSV (RFC 4180): in quotes where it holds a comma, a quote or a line end. Control characters are escaped,
/// and what a spreadsheet would take for a formula is quoted with an apostrophe.
pub(super) fn cell(out: &mut Vec<u8>, text: &[u8]) {
    let start = out.len();
    if matches!(text.first(), Some(b'=' | b'+' | b'-' | b'@')) {
        out.push(b'\'');
    }
    escape::terminal(out, text);
    let is_apart = |byte: &u8| matches!(byte, b',' | b'"' | b'\n' | b'\r');
    if out.get(start..).is_some_and(|safe| safe.iter().any(is_apart)) {
        let safe = out.split_off(start);
        out.push(b'"');
        for byte in safe {
            if byte == b'"' {
                out.push(b'"');
            }
            out.push(byte);
        }
        out.push(b'"');
    }
}

/// Appends the JSON that `write` appends, without its quotes; nothing for null.
pub(super) fn bare(out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    write(out);
    let written = out.get(start..).unwrap_or(&[]);
    if written == b"null" {
        out.truncate(start);
    } else if written.len() > 1 && written.starts_with(b"\"") && written.ends_with(b"\"") {
        out.pop();
        out.remove(start);
    }
}

/// Appends the line of headings.
pub(super) fn headings(out: &mut Vec<u8>, headings: &[&str]) {
    for (place, heading) in headings.iter().enumerate() {
        put!(out; if place > 0 { "," } else { "" }, *heading);
    }
    out.push(b'\n');
}
