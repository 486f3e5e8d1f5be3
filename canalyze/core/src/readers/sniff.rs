//! Which format an input has, told by its first bytes: never by its name.
//!
//! Binary formats have a sign of their own. Text is decided by its first line that is neither blank nor a comment of
//! both families. Everything that is nothing else is candump's text, whose reader says line by line what it cannot
//! read. Must not: read frames, or look further than [`HEAD`].

/// Most that is ever looked at.
pub const HEAD: usize = 64 * 1024;

/// Signs at the very beginning: offset, bytes, name.
const SIGNS: &[(usize, &[u8], &str)] = &[
    (0, b"\x89MCAP0\r\n", "mcap"),
    (0, b"\xA1\xB2\xC3\xD4", "pcap"),
    (0, b"\xA1\xB2\x3C\x4D", "pcap"),
    (0, b"\xD4\xC3\xB2\xA1", "pcap"),
    (0, b"\x4D\x3C\xB2\xA1", "pcap"),
    (0, b"\n\r\r\n", "pcapng"),
    (0, b"LOGG", "blf"),
    (0, b"MDF     ", "mf4"),
    (0, b"UnFinMF ", "mf4"),
    (0, b"SQLite format 3\0", "sqlite"),
    (0, b"\x1F\x8B", "gzip"),
    (0, b"\xFD7zXZ\0", "xz"),
    (0, b"\x28\xB5\x2F\xFD", "zstd"),
    (1, b"\x2A\x4D\x18", "zstd"), // a frame of it that is skipped
    (0, b"BZh", "bzip2"),
    (0, b"\xFF\xFE", "utf-16"),
    (0, b"\xFE\xFF", "utf-16"),
];

/// The name of the format that begins with `head`; `None` while more bytes are needed to tell. `complete`: there are
/// no more.
///
/// Beside the names of [`super::Format`]: what other programs are needed for (`blf`, `mf4`, `sqlite`, `trc`, `csv`),
/// what has to be unpacked first (`gzip`, `xz`, `zstd`, `bzip2`), and text of another encoding (`utf-16`, `utf-16le`,
/// `utf-16be`).
pub fn sniff(head: &[u8], complete: bool) -> Option<&'static str> {
    let complete = complete || head.len() >= HEAD;
    for (offset, sign, name) in SIGNS {
        let Some(rest) = head.get(*offset..) else { continue };
        if rest.starts_with(sign) {
            return Some(name);
        }
        if !complete && sign.starts_with(rest) {
            return None;
        }
    }
    if let [first, second, third, fourth, ..] = head {
        // Text in UTF-16 without its mark: every other byte of the first two letters is zero.
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
    loop {
        let end = memchr::memchr(b'\n', rest);
        if end.is_none() && !complete {
            return None;
        }
        let (line, after) = rest.split_at_checked(end.unwrap_or(rest.len())).unwrap_or((rest, &[]));
        if let Some(name) = line_of(line.trim_ascii()) {
            return Some(name);
        }
        match after.get(1..) {
            Some(next) if !next.is_empty() || !complete => rest = next,
            _ => return Some("candump"),
        }
    }
}

/// What a line of text gives away; `None` for one that could stand in any file.
fn line_of(line: &[u8]) -> Option<&'static str> {
    let lower = line.to_ascii_lowercase();
    match line.first() {
        None | Some(b'#') => return None,
        Some(b';') => return Some("trc"),
        _ if line.starts_with(b"//") => return None,
        _ => {}
    }
    if lower.starts_with(b"timestamp,arbitration_id,") {
        return Some("csv");
    }
    let mut words = lower.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
    let (first, second) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let third = words.next().unwrap_or_default();
    let header = match first {
        // A date has a time of the day: `date of the recording` is prose.
        b"date" => line.contains(&b':'),
        b"base" => matches!(second, b"hex" | b"dec"),
        b"begin" => second == b"triggerblock",
        b"internal" => second == b"events" && third == b"logged",
        b"no" => second == b"internal" && third == b"events",
        _ => false,
    };
    // A line of Vector's without its header: time, then channel or the kind of an event.
    let stamp = first.iter().filter(|byte| **byte == b'.').count() == 1
        && first.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.')
        && first.first().is_some_and(u8::is_ascii_digit)
        && first.last().is_some_and(u8::is_ascii_digit);
    Some(if header || stamp && !second.is_empty() { "asc" } else { "candump" })
}

#[cfg(test)]
mod tests {
    use super::sniff;

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
            (b"date of the recording\n(1.5) can0 601#40\n", "candump"),
            (b"192.168.1.1 host\n", "candump"),
            (b"(1.5) can0 601#40\n0.000000 1 601 Rx d 1 40\n", "candump"),
            (b";$FILEVERSION=2.1\r\n", "trc"),
            (b"timestamp,arbitration_id,extended,remote,error,dlc,data\n", "csv"),
            (b"\x89MCAP0\r\n\x01", "mcap"),
            (b"LOGG\x90\0\0\0", "blf"),
            (b"\xD4\xC3\xB2\xA1\x02\0", "pcap"),
            (b"\n\r\r\n\x1C\0\0\0", "pcapng"),
            (b"\x1F\x8B\x08\0", "gzip"),
            (b"t\0e\0x\0t\0", "utf-16le"),
            (b"", "candump"),
        ];
        for (head, name) in rows {
            assert_eq!(sniff(head, true), Some(*name), "{:?}", String::from_utf8_lossy(head));
            // What is said early is what is said late.
            for cut in 0..head.len() {
                let early = sniff(head.get(..cut).unwrap_or_default(), false);
                assert!(early.is_none() || early == Some(*name), "{name} at {cut}: {early:?}");
            }
        }
    }
}
