//! What captures raise, as tables: one file a family of checks, each a capture in words and what it must raise.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic, dead_code)]

mod drive;
mod emcy;
mod error_frames;
mod lss;
mod network;
mod nodes;
mod pdo;
mod srdo;
mod sync;

use std::sync::Arc;

use crate::network::Network;
use crate::session::{Format, Options, Session};

/// One finding: its code, the frame at which it stands, the earlier frame it is about.
pub(super) type Raised = (String, u64, Option<u64>);

/// Everything that a candump log raises above info, in order.
pub(super) fn raised(log: &str) -> Vec<Raised> {
    raised_with(log, Network::default(), &["warning", "error"])
}

/// Everything that a candump log raises at the given severities, with what is known of the network.
pub(super) fn raised_with(log: &str, network: Network, severities: &[&str]) -> Vec<Raised> {
    let lines = lines(log, network);
    let findings = lines.iter().filter(|line| line["kind"] == "finding");
    let wanted = findings.filter(|line| severities.contains(&line["severity"].as_str().unwrap()));
    wanted
        .map(|line| {
            (line["code"].as_str().unwrap().into(), line["frame"].as_u64().unwrap_or(0), line["cause_frame"].as_u64())
        })
        .collect()
}

/// The JSON lines of a candump log.
pub(super) fn lines(log: &str, network: Network) -> Vec<serde_json::Value> {
    let options = Options { format: Format::Jsonl, network: Arc::new(network), ..Options::default() };
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"capture.log", crate::readers::Format::Candump, true);
    session.feed(log.as_bytes(), &mut out);
    session.finish(&mut out);
    let text = String::from_utf8(out).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
}

/// A log from lines `ms ID#DATA`, such as `12.5 185#0102`, blank lines left out. Times in ms.
pub(super) fn log(lines: &str) -> String {
    let written = lines.lines().map(str::trim).filter(|line| !line.is_empty()).map(|line| {
        let (ms, frame) = line.split_once(' ').unwrap();
        let us = (ms.parse::<f64>().unwrap() * 1000.0).round() as i64;
        format!(
            "({}.{:06}) can0 {}\n",
            1_700_000_000 + us.div_euclid(1_000_000),
            us.rem_euclid(1_000_000),
            frame.trim()
        )
    });
    written.collect()
}

/// A log as candump prints it without stamps.
pub(super) fn without_stamps(log: &str) -> String {
    let bare = |line: &str| {
        let (id, data) = line.rsplit(' ').next()?.split_once('#')?;
        let bytes: Vec<&str> = (0..data.len() / 2).map(|no| &data[2 * no..2 * no + 2]).collect();
        Some(format!("  can0  {id}   [{}]  {}\n", bytes.len(), bytes.join(" ")))
    };
    log.lines().filter_map(bare).collect()
}
