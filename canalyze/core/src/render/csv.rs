//! Cells of CSV (RFC 4180). Must not: know what is in them.

use crate::text::escape;

/// A cell of CSV (RFC 4180): in quotes where it holds a comma, a quote or a line end. Control characters are escaped,
/// and what a spreadsheet would take for a formula is quoted with an apostrophe.
pub(super) fn cell(out: &mut Vec<u8>, text: &[u8]) {
    let mut safe = Vec::new();
    if matches!(text.first(), Some(b'=' | b'+' | b'-' | b'@')) {
        safe.push(b'\'');
    }
    escape::terminal(&mut safe, text);
    if safe.iter().any(|byte| matches!(byte, b',' | b'"' | b'\n' | b'\r')) {
        out.push(b'"');
        for byte in safe {
            if byte == b'"' {
                out.push(b'"');
            }
            out.push(byte);
        }
        out.push(b'"');
    } else {
        out.extend_from_slice(&safe);
    }
}

/// What `write` appends as JSON without its quotes; nothing for null.
pub(super) fn bare(out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
    let mut written = Vec::new();
    write(&mut written);
    let text = written.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\"")).unwrap_or(&written);
    if text != b"null" {
        out.extend_from_slice(text);
    }
}
