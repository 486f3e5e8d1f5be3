//! Detection of the format of an input by its first bytes, never by its name.
//!
//! Binary formats have signatures. Text is decided by its first line that belongs to one format, since lines that
//! people write above pasted rows show nothing. Everything else is candump's text, whose reader reports unreadable
//! lines. At most [`HEAD`] bytes are examined.

use super::candump;
use super::listing::{numbered, unmarked, unquoted};
use super::rows;
use crate::bytes::frame::Buses;

/// Maximum number of examined bytes.
pub const HEAD: usize = 64 * 1024;

/// Maximum length of an examined line: the longest of a frame, in any format, is shorter.
const LINE: usize = 4 * 1024;

/// Signatures at fixed offsets: offset, bytes, name.
const SIGNS: &[(usize, &[u8], &str)] = &[
    (0, b"\x89MCAP0\r\n", "mcap"),
    (0, b"\xA1\xB2\xC3\xD4", "pcap"),
    (0, b"\xA1\xB2\x3C\x4D", "pcap"),
    (0, b"\xD4\xC3\xB2\xA1", "pcap"),
    (0, b"\x4D\x3C\xB2\xA1", "pcap"),
    (0, b"LOGG", "blf"),
    (0, b"MDF     ", "mf4"),
    (0, b"UnFinMF ", "mf4"),
    (0, b"SQLite format 3\0", "sqlite"),
    (0, b"\x1F\x8B", "gzip"),
    (0, b"\xFD7zXZ\0", "xz"),
    (0, b"\x28\xB5\x2F\xFD", "zstd"),
    (1, b"\x2A\x4D\x18", "zstd"), // a skippable frame
    (0, b"BZh", "bzip2"),
    (0, b"\xFF\xFE", "utf-16"),
    (0, b"\xFE\xFF", "utf-16"),
];

/// The beginning of a section header of pcapng. Text may begin with it, too, so the byte-order mark is also required.
const BLOCK: &[u8] = b"\n\r\r\n";

/// Number of rows of another program that decide without any line of another format.
const SURE: usize = 16;

/// The words for identifier and data in headings of Chinese programs, in their encoding.
const GBK: [&[&[u8]]; 2] = [&[b"\xD6\xA1ID", b"ID\xBA\xC5"], &[b"\xCA\xFD\xBE\xDD"]];

/// Returns the name of the format that begins with `head`; `None` if more bytes are needed. `complete`: there are no
/// more.
///
/// Besides the names of [`super::Format`], returns formats that need other programs (`blf`, `mf4`, `sqlite`, `trc`,
/// `csv`), compressed files (`gzip`, `xz`, `zstd`, `bzip2`), and text in another encoding (`utf-16`, `utf-16le`,
/// `utf-16be`, `gbk`).
pub fn sniff(head: &[u8], complete: bool) -> Option<&'static str> {
    let complete = complete || head.len() >= HEAD;
    // Of more bytes the last line would be cut.
    let whole = |head: &[u8]| memchr::memrchr(b'\n', head).map_or(head.len(), |end| end + 1);
    let head =
        head.get(..HEAD).filter(|_| head.len() > HEAD).map_or(head, |head| head.get(..whole(head)).unwrap_or(head));
    for (offset, sign, name) in SIGNS {
        let Some(rest) = head.get(*offset..) else { continue };
        if rest.starts_with(sign) {
            return Some(name);
        }
        if !complete && sign.starts_with(rest) {
            return None;
        }
    }
    if let Some(rest) = head.strip_prefix(BLOCK) {
        // The length of the header is in between.
        match rest.get(4..8) {
            Some(b"\x1A\x2B\x3C\x4D" | b"\x4D\x3C\x2B\x1A") => return Some("pcapng"),
            None if !complete => return None,
            _ => {}
        }
    } else if !complete && BLOCK.starts_with(head) {
        return None;
    }
    if GBK.iter().all(|words| words.iter().any(|word| memchr::memmem::find(head, word).is_some())) {
        return Some("gbk");
    }
    if let [first, second, third, fourth, ..] = head {
        // Text in UTF-16 without a byte-order mark: every other byte of the first two letters is zero.
        let zeros = [first, second, third, fourth].map(|byte| *byte == 0);
        match zeros {
            [false, true, false, true] => return Some("utf-16le"),
            [true, false, true, false] => return Some("utf-16be"),
            _ => {}
        }
    }
    text(head, complete)
}

fn text(head: &[u8], complete: bool) -> Option<&'static str> {
    let mut rest = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    let (mut otherwise, mut listed) = ("candump", 0);
    loop {
        let end = memchr::memchr(b'\n', rest);
        if end.is_none() && !complete {
            return None;
        }
        let (line, after) = rest.split_at_checked(end.unwrap_or(rest.len())).unwrap_or((rest, &[]));
        let (whole, line) = (line.trim_ascii(), unmarked(unquoted(line.trim_ascii())));
        let is_read = whole.len() <= LINE;
        if let Some(name) = is_read.then(|| line_of(line)).flatten() {
            return Some(name);
        }
        if is_read && rows::is_row(whole, true) {
            listed += 1;
            otherwise = "rows"; // unless lines of another format follow
            if listed == SURE {
                return Some(otherwise);
            }
        } else if otherwise == "candump" && line.first() == Some(&b';') {
            otherwise = "trc"; // a comment of PEAK's, unless frames of candump's follow
        }
        match after.get(1..) {
            Some(next) if !next.is_empty() || !complete => rest = next,
            _ if otherwise == "candump" && rows::has_object(head) => return Some("rows"),
            _ => return Some(otherwise),
        }
    }
}

/// Returns the format that a line of text shows; `None` if it could be in any file.
fn line_of(line: &[u8]) -> Option<&'static str> {
    let lower = line.to_ascii_lowercase();
    match line.first() {
        None | Some(b'#') => return None,
        _ if line.starts_with(b";$") => return Some("trc"),
        _ if line.starts_with(b"//") || line.first() == Some(&b';') => return None,
        _ if is_trc_row(line) => return Some("trc"),
        _ => {}
    }
    if lower.starts_with(b"timestamp,arbitration_id,") {
        return Some("csv");
    }
    let mut words = lower.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let (first, second) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let third = words.next().unwrap_or_default();
    let header = match first {
        // A date includes a time of day: `date of the recording` is prose.
        b"date" => line.contains(&b':'),
        b"base" => matches!(second, b"hex" | b"dec"),
        b"begin" => second == b"triggerblock",
        b"internal" => second == b"events" && third == b"logged",
        b"no" => second == b"internal" && third == b"events",
        _ => false,
    };
    // A line of Vector's without a header: time, then channel and more, or the kind of an event.
    let said = |word: &[u8]| memchr::memmem::find(&lower, word).is_some();
    let event = second.iter().all(u8::is_ascii_digit)
        && matches!(second.len(), 1 | 2)
        && !third.is_empty()
        && [&b"rx"[..], b"tx", b"errorframe", b"statistic", b"overload", b" d ", b" r "].iter().any(|word| said(word));
    let event = event || matches!(second, b"canfd" | b"canxl" | b"start" | b"can" | b"log" | b"sv:" | b"comment:");
    let stamp = first.iter().filter(|byte| **byte == b'.').count() == 1
        && first.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.')
        && first.first().is_some_and(u8::is_ascii_digit)
        && first.last().is_some_and(u8::is_ascii_digit);
    if rows::is_row(line, second == b"can") {
        return Some("rows");
    }
    if header || stamp && event {
        return Some("asc");
    }
    candump::line(line, &mut Buses::default()).ok().map(|_| "candump")
}

/// Returns true for a row of PEAK's format in any version, without the header: number, offset in ms, then type, bus or
/// identifier.
fn is_trc_row(line: &[u8]) -> bool {
    let Some((_, rest, bare)) = numbered(line) else { return false };
    let mut words = rest.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let mut next = || words.next().unwrap_or_default();
    let (offset, first, second, third) = (next(), next(), next(), next());
    let number = |word: &[u8]| !word.is_empty() && word.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.');
    let id = |word: &[u8]| matches!(word.len(), 3 | 4 | 8) && word.iter().all(u8::is_ascii_hexdigit);
    let is_type = |word: &[u8]| matches!(word, b"Rx" | b"Tx" | b"Warng" | b"Error");
    let short = |word: &[u8]| word.len() <= 2 && word.iter().all(u8::is_ascii_digit) && !word.is_empty();
    if !number(offset) || line.len() - rest.len() < 2 {
        return false;
    }
    if bare {
        // 2.0 and 2.1
        let kind = matches!(first, b"DT" | b"FD" | b"FB" | b"FE" | b"BI" | b"RR" | b"ST" | b"EC" | b"ER" | b"EV");
        return kind && (short(second) || id(second) || is_type(second));
    }
    // 1.0; 1.1; 1.2 and 1.3
    id(first) && short(second)
        || is_type(first) && id(second) && short(third)
        || short(first) && is_type(second) && id(third)
}

#[cfg(test)]
mod tests {
    use super::{HEAD, LINE, sniff};

    #[test]
    fn formats_by_their_first_bytes() {
        let rows: &[(&[u8], &str)] = &[
            (b"(1.5) can0 601#40\n", "candump"),
            (b"  can0  601   [1]  40\n", "candump"),
            (b"# comment\n\n// other\nbase hex  timestamps absolute\n", "asc"),
            (b"date Sam Sep 30 15:06:13.191 2017\n", "asc"),
            (b"\xEF\xBB\xBFdate Sat Sep 30 10:06:13.191 PM 2017\r\n", "asc"),
            (b"   0.000000 1  601             Rx   d 1 40\n", "asc"),
            (b"// version 9.0.0\r\n//\r\n 0.000000 1 601x Rx d 1 40\r\n", "asc"),
            (b"\n  0.0000 CANFD   1 Rx 300 1 0 8 8 00\n", "asc"),
            (b"0.000000 Start of measurement\n", "asc"),
            (b"Begin TriggerBlock\n", "asc"),
            (b"no internal events logged\n", "asc"),
            (b"     1)      1841  0001  8  00 00\n", "trc"),
            (b"     1)      1059.9  Rx         0300  2  00 00\n", "trc"),
            (b"> 1)      1059.9  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY\n", "trc"),
            (b"     1)      1059.900 1  Rx        0300 2  00 00\n", "trc"),
            (b"     1)      1059.900 1  Rx        0300 -  2    00 00\n", "trc"),
            (b"      1      1059.900 DT     0300 Rx 2  00 00\n", "trc"),
            (b"      2     17540.300 ST          Rx    00 00 00 08\n", "trc"),
            (b"      1      1059.900 DT 1      0300 Rx -  2    00 00\n", "trc"),
            (b"This is the trace:\n```\n...\n     14)      1059.9  Rx         0300  2  00 00\n", "trc"),
            (b";---+--   ----+----\n  1) 1.5 Rx 0300 1 00\n", "trc"),
            (b"; a remark\n(1.5) can0 601#40\n", "candump"),
            (b"1) can0 601 [1] 40\n", "candump"),
            (b"1) see 601\n0.5 seconds later it stops\n", "candump"),
            (b"The trace:\n0.000000 1 601 Rx d 1 40\n", "asc"),
            (b"date of the recording\n(1.5) can0 601#40\n", "candump"),
            (b"192.168.1.1 host\n", "candump"),
            (b"(1.5) can0 601#40\n0.000000 1 601 Rx d 1 40\n", "candump"),
            (b";$FILEVERSION=2.1\r\n", "trc"),
            (b"timestamp,arbitration_id,extended,remote,error,dlc,data\n", "csv"),
            (b"\x89MCAP0\r\n\x01", "mcap"),
            (b"LOGG\x90\0\0\0", "blf"),
            (b"\xD4\xC3\xB2\xA1\x02\0", "pcap"),
            (b"\x4D\x3C\xB2\xA1\x02\0", "pcap"),
            (b"\xA1\xB2\x3C\x4D\0\x02", "pcap"),
            (b"\n\r\r\n\x1C\0\0\0\x4D\x3C\x2B\x1A", "pcapng"),
            (b"\n\r\r\n\0\0\0\x1C\x1A\x2B\x3C\x4D", "pcapng"),
            (b"\n\r\r\n(1.5) can0 601#40\n", "candump"),
            (b"\n\r\r\n\n", "candump"),
            (b"\x1F\x8B\x08\0", "gzip"),
            (b"t\0e\0x\0t\0", "utf-16le"),
            (b"", "candump"),
        ];
        for (head, name) in rows {
            assert_eq!(sniff(head, true), Some(*name), "{:?}", String::from_utf8_lossy(head));
            // An early answer equals the final one.
            for cut in 0..head.len() {
                let early = sniff(head.get(..cut).unwrap_or_default(), false);
                assert!(early.is_none() || early == Some(*name), "{name} at {cut}: {early:?}");
            }
        }
    }

    #[test]
    fn long_lines_show_nothing() {
        let long = "(1.5) can0 601#".to_owned() + &"40".repeat(LINE);
        let asc = "   0.000000 1  601             Rx   d 1 40\n";
        assert_eq!(sniff(format!("{long}\n{asc}").as_bytes(), true), Some("asc"));
        assert_eq!(sniff(asc.repeat(HEAD).as_bytes(), true), Some("asc"));
        // Beyond what is examined, a line that is cut shows nothing either.
        let far = " ".repeat(HEAD - 10) + "\n" + asc;
        assert_eq!(sniff(far.as_bytes(), true), Some("candump"));
    }
}
