//! The text of a single frame, with a file for each service.
//!
//! A new service gets its arm in [`message`] (the compiler asks for it) and, where it has more than a phrase, a file
//! here. A phrase is one `say!`: the languages beside each other, each in its own order of words. What has a name, such
//! as a state or an error code, stands in `terms`. Must not decide anything. No `format!` and no allocation: these are
//! the lines of the hot path.

pub mod pdo;
pub mod sdo;

use super::digits::put;
use super::{Depth, Lang};
use crate::bytes::frame::Frame;
use crate::wire;
use crate::wire::message::Message;
use crate::wire::role::PdoLabel;

/// Appends the phrase of a message, and at other depths than brief its content. No line end.
pub fn message(out: &mut Vec<u8>, lang: Lang, depth: Depth, message: &Message, frame: &Frame) {
    let full = depth != Depth::Brief;
    match *message {
        Message::Pdo { transmit, number, node } => {
            pdo::undecoded(out, lang, full, PdoLabel { lang, transmit, number, node }, frame.len);
        }
        Message::Mpdo { transmit, number, node, content } => {
            put!(out; PdoLabel { lang, transmit, number, node });
            if full {
                put!(out; ": ");
                pdo::multiplexed(out, lang, &content, None);
            }
        }
        Message::PdoRequest { transmit, number, node } => {
            pdo::request(out, lang, full, PdoLabel { lang, transmit, number, node }, frame.len);
        }
        _ => wire::line(out, lang, full, message, frame),
    }
}
