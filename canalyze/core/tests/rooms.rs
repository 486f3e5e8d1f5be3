//! The budget of each room of `src`: product lines, without comments, blank lines and tests.
//!
//! A room over its budget fails. Raise a budget only in a commit that says why, and keep the whole within `WHOLE`.

#![allow(clippy::expect_used, clippy::panic)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Most lines of the core. The words of the diagnosis, and the reader of descriptions, which Python was before, are in it since
/// a page has no Python. So are texts that are kept from one line to the next, frames that show nothing but their gap, values
/// of PDOs that are found without a search, consequences that are counted where they are found, rare events apart from
/// what is moved at every frame, plain lines of candump that are read up to their end, and what people write around frames.
/// Nodes that do not run, senders that are listed twice, and what the recording lacks are models of their own; so are a bus that
/// restarts as a whole, and RPDOs that come evenly. Who is a master is known by what it is asked and what it obeys, and a
/// short absence of a node by all that it sends. Drives are judged by what they would have sent, too. A signal that rests is
/// told from a sender that stops, and what is missing behind a hole of the recording from what is missing in it.
/// It was 68,630 while files whose tests are declared at their head counted up to there only.
const WHOLE: usize = 75_530;

/// A room and its most lines.
const BUDGETS: &[(&str, usize)] = &[
    // With rows inside other text, objects that name their values, several frames in one line, the clocks of adapters, the
    // refusal of tables that may be misread, colons or blanks between the bytes of candump, the type of times, and messages
    // that ROS prints. With columns and seconds that are copied from an earlier line. With plain lines of candump that are read
    // up to their end, without a search for it. With names of services before a frame, a response behind an arrow, times in ms
    // and bytes without leading zeros, which people paste.
    ("bytes", 14_780),
    // With rare cases apart from what every PDO passes through.
    // With TPDOs that never come, or at another interval, against their configuration, and two SYNC producers that are there
    // from the beginning. With a producer that is configured and sends no SYNC. With requests of guarding whose answer the next
    // toggle bit shows to be missing in the recording, and PDOs that wait for the node's next report of its state. With SRDOs
    // that pause or stop, by times that are configured or learnt, and heartbeats that do not follow 1017h at any magnitude. With
    // PDOs that are outside their window, or at another number of SYNCs, each time, and node-IDs that change without a request
    // for the former one. With masters that a tool reads from, and guarding that is switched off. With commands to drives that
    // brake first, and statuswords that are sent by events alone. With clocks of TIME that stop or drift, masters that are
    // switched on with their slaves, signals that rest, and nodes that are not there behind lost frames.
    ("checks", 8_775),
    // With learnt event timers, and findings that wait without a look at each frame. With frames that only add to the usual
    // gaps, which are nearly all, and what rarely happens at a frame apart from its place. With the servers whose answers
    // are in the capture. With senders whose frames a recording lists twice, and holes that a counter of SYNC shows.
    // With timers that changes hide, and the least by which exchanges show own frames to be in their place.
    ("evidence", 4_060),
    ("lib", 50),
    // Was 1,250 lines of Python: a page without Python reads descriptions, too. With the sentence of an unusable file, for
    // every binding.
    ("description", 1_990),
    // With descriptions as rows of Python's tuples, and parts of bytes, which are fed without a copy.
    ("python", 1_260),
    // With TPDOs against their configuration, and sentences about SRDOs that stop. With transfers that their client leaves.
    ("rules", 1_735),
    // With requests that a client gives up, servers that are mute beside others, and late acknowledgements. With
    // transfers that their client leaves, and channels that are SDO since their node reports its state.
    ("sdo", 4_690),
    // With consequences that are counted before they become events.
    ("session", 2_800),
    ("settings", 1_330),
    // Without what a kind of problem is: that is in the table of kinds. With ends that a frame shows, new floods, and
    // the nodes of the first screen, nodes that are not started behind a reset, and who gave a request up. With PDOs that
    // only seemed to be missing before their interval was known. With the end of an SRDO's absence, and heartbeats that only
    // seem to be lost where their former period is back. With nodes that are there and do not run, a bus that restarts as a
    // whole, RPDOs that stop without SYNC, aborts of transfers that an excerpt does not have, and controllers that do not obey
    // themselves. With the silences of a node between its heartbeats, beside which a late heartbeat is the smaller part, and
    // nodes without heartbeats that are never started. With requests for one object that are never served, and boot-ups of the
    // only node while they follow each other. With a SYNC that is unsteady before it stops.
    ("problems", 7_135),
    // With JSON objects and rows of CSV in parts, since most of them is as in an earlier line, and selections that are found
    // without a search.
    ("tables", 6_610),
    // The transfers of CANopen FD.
    ("usdo", 1_030),
    // With lines that differ from an earlier one in stamp and data only, and frames around findings that are kept in place.
    ("views", 8_970),
    // With the relation of a mapped object to its profile.
    ("wire", 2_770),
    // With the reasons why tables are refused, and the words of the diagnosis. With texts that are kept, since nearly every
    // line of a capture says what an earlier one said. With captures of remote requests alone, and drives whose states nobody
    // has read. With guarded nodes apart from those with heartbeats.
    ("words", 4_150),
    // With the states of axes, which views followed for themselves, numbers of descriptions in the width of their type, and rows
    // of descriptions for every binding. With values of PDOs that are found without a search, and the counts of findings that
    // repeat, which are counted where they are found. With the keys of PDOs apart, and PDOs on a bus in a file of their own. With
    // the mappings that show a kind of device, since all would be looked at for each write of one. With the nodes that are
    // expected behind lost frames.
    ("world", 3_460),
];

/// Adds the product lines below a folder, each under its room.
fn count(folder: &Path, room: Option<&str>, rooms: &mut BTreeMap<String, usize>) {
    for entry in fs::read_dir(folder).expect("the source is readable") {
        let path = entry.expect("the source is readable").path();
        let name = path.file_stem().expect("an entry has a name").to_string_lossy().into_owned();
        if name == "tests" {
            continue;
        }
        if path.is_dir() {
            count(&path, room.or(Some(&name)), rooms);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).expect("the source is UTF-8");
            *rooms.entry(room.unwrap_or(&name).to_owned()).or_default() += product_lines(&text);
        }
    }
}

/// Returns the number of lines of a file that are neither blank nor a comment, up to its tests. Tests in a file of their own
/// are declared at its head.
fn product_lines(text: &str) -> usize {
    let product = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = product.lines().map(str::trim_start);
    lines.filter(|line| !line.is_empty() && !line.starts_with("//") && !line.starts_with("#[cfg(test)]")).count()
}

#[test]
fn rooms_keep_to_their_budgets() {
    let mut rooms = BTreeMap::new();
    count(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), None, &mut rooms);
    let whole: usize = rooms.values().sum();
    assert!(whole > 20_000, "the source is where this test looks");
    let of = |room: &str| BUDGETS.iter().find(|(name, _)| *name == room).map(|(_, most)| *most);
    for (room, lines) in &rooms {
        let most = of(room).unwrap_or_else(|| panic!("{room} has no budget"));
        assert!(*lines <= most, "{room} has {lines} lines, {most} are its budget");
    }
    assert!(BUDGETS.iter().all(|(room, _)| rooms.contains_key(*room)), "a budget without a room");
    assert!(whole <= WHOLE, "the core has {whole} lines, {WHOLE} are its budget: {rooms:?}");
}

#[test]
fn comments_blank_lines_and_tests_do_not_count() {
    assert_eq!(product_lines("//! Head.\n\nfn a() {\n    // why\n}\n#[cfg(test)]\nmod tests {}\n"), 2);
    assert_eq!(product_lines("#[cfg(test)]\nmod tests;\n\nfn a() {\n}\n"), 3);
}
