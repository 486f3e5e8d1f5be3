//! A JSON object that is appended key by key.
//!
//! It must not know what the keys mean. Keys are the program's own words; values from a capture are escaped.

use crate::words::digits::{Hex, Joined, Put, put};
use crate::words::escape;

/// A JSON object being written. Keys are the program's own and need no escaping.
pub(crate) struct Object<'a> {
    out: &'a mut Vec<u8>,
    empty: bool,
}

impl<'a> Object<'a> {
    pub(crate) fn open(out: &'a mut Vec<u8>) -> Self {
        out.push(b'{');
        Self { out, empty: true }
    }

    pub(crate) fn close(self) {
        self.out.push(b'}');
    }

    pub(crate) fn key(&mut self, key: &'static str) -> &mut Vec<u8> {
        put!(self.out; if self.empty { "\"" } else { ",\"" }, key, "\":");
        self.empty = false;
        self.out
    }

    pub(crate) fn number(&mut self, key: &'static str, value: impl Put) {
        value.put(self.key(key));
    }

    pub(crate) fn maybe(&mut self, key: &'static str, value: Option<impl Put>) {
        match value {
            Some(value) => value.put(self.key(key)),
            None => put!(self.key(key); "null"),
        }
    }

    pub(crate) fn hex<const DIGITS: usize>(&mut self, key: &'static str, value: u64) {
        put!(self.key(key); "\"", Hex::<DIGITS>(value), "\"");
    }

    pub(crate) fn maybe_hex(&mut self, key: &'static str, present: bool, value: u8) {
        if present {
            self.hex::<2>(key, u64::from(value));
        } else {
            put!(self.key(key); "null");
        }
    }

    pub(crate) fn flag(&mut self, key: &'static str, value: bool) {
        put!(self.key(key); if value { "true" } else { "false" });
    }

    pub(crate) fn word(&mut self, key: &'static str, value: &'static str) {
        escape::json(self.key(key), value.as_bytes());
    }

    pub(crate) fn optional(&mut self, key: &'static str, value: Option<&'static str>) {
        match value {
            Some(value) => self.word(key, value),
            None => put!(self.key(key); "null"),
        }
    }

    pub(crate) fn bytes(&mut self, key: &'static str, value: &[u8]) {
        put!(self.key(key); "\"", Joined(value), "\"");
    }

    pub(crate) fn list<T>(
        &mut self,
        key: &'static str,
        items: impl Iterator<Item = T>,
        write: impl Fn(&mut Vec<u8>, T),
    ) {
        let out = self.key(key);
        out.push(b'[');
        for (i, item) in items.enumerate() {
            if i > 0 {
                out.push(b',');
            }
            write(out, item);
        }
        out.push(b']');
    }
}
