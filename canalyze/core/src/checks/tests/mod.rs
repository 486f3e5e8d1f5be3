//! Tables of captures and their findings, one file per family of checks.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic, dead_code)]

mod clock;
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

use crate::session::{Options, Output, Rows, Session};
use crate::words::Lang;
use crate::world::network::Network;

/// One finding: its code, its frame, and the earlier frame it is about.
pub(super) type Raised = (String, u64, Option<u64>);

/// Returns all findings of a candump log above info, in order.
pub(super) fn raised(log: &str) -> Vec<Raised> {
    raised_with(log, Network::default(), &["warning", "error"])
}

/// Returns all findings of a candump log of the given severities, with a network's configuration.
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

/// Returns the JSON lines of a candump log.
pub(crate) fn lines(log: &str, network: Network) -> Vec<serde_json::Value> {
    let text = written(log, network, &[Output::json(Rows::Frames)]);
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
}

/// Returns all that a session with these outputs writes about a candump log.
pub(super) fn written(log: &str, network: Network, outputs: &[Output]) -> String {
    let mut options = Options::of(Lang::Zh, outputs);
    options.known.network = Arc::new(network);
    let mut session = Session::new(options);
    let mut out = Vec::new();
    session.begin(b"capture.log", crate::bytes::readers::InputFormat::Candump, true);
    session.feed(log.as_bytes(), &mut out);
    session.finish(&mut out);
    String::from_utf8(out).unwrap()
}

/// Converts lines `ms ID#DATA`, such as `12.5 185#0102`, to a log; skips blank lines.
pub(crate) fn log(lines: &str) -> String {
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

/// Returns a log as candump prints it without stamps.
pub(super) fn without_stamps(log: &str) -> String {
    let bare = |line: &str| {
        let (id, data) = line.rsplit(' ').next()?.split_once('#')?;
        let bytes: Vec<&str> = (0..data.len() / 2).map(|no| &data[2 * no..2 * no + 2]).collect();
        Some(format!("  can0  {id}   [{}]  {}\n", bytes.len(), bytes.join(" ")))
    };
    log.lines().filter_map(bare).collect()
}
