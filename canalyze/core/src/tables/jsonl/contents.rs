//! What a reader knows of its file beyond frames, as one JSON object: for `info`, and for files without any frame.
//!
//! | key | value |
//! |---|---|
//! | `dialect` | object: a word of the format's own, and its value as a string |
//! | `passed_over` | list of `{"kind", "count"}` |
//! | `topics` | list of `{"name", "schema", "encoding", "messages", "read_as", "bus"}` |

use crate::bytes::readers::Contents;
use crate::words::digits::put;
use crate::words::escape;

/// Appends the object, without a line's end.
pub fn contents(out: &mut Vec<u8>, contents: &Contents) {
    put!(out; "{\"dialect\":{");
    for (no, (word, value)) in contents.dialect.iter().enumerate() {
        put!(out; if no > 0 { "," } else { "" }, "\"", *word, "\":");
        escape::json(out, value);
    }
    put!(out; "},\"passed_over\":[");
    for (no, (kind, count)) in contents.passed_over.iter().enumerate() {
        put!(out; if no > 0 { "," } else { "" }, "{\"kind\":");
        escape::json(out, kind);
        put!(out; ",\"count\":", *count, "}");
    }
    put!(out; "],\"topics\":[");
    for (no, topic) in contents.topics.iter().enumerate() {
        put!(out; if no > 0 { "," } else { "" }, "{\"name\":");
        escape::json(out, &topic.name);
        let texts = [
            ("schema", &topic.schema),
            ("encoding", &topic.encoding),
            ("read_as", &topic.read_as),
            ("bus", &topic.bus),
        ];
        for (key, value) in texts {
            put!(out; ",\"", key, "\":");
            escape::json(out, value);
        }
        put!(out; ",\"messages\":", topic.messages, "}");
    }
    put!(out; "]}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bytes::readers::Topic;

    #[test]
    fn an_object() {
        let topic = Topic { name: b"/can0".to_vec(), messages: 3, bus: b"can0".to_vec(), ..Topic::default() };
        let known = Contents {
            dialect: vec![("profile", b"ros2".to_vec()), ("library", b"\"x\"".to_vec())],
            passed_over: vec![(b"Attachment".to_vec(), 2)],
            topics: vec![topic],
        };
        let mut out = Vec::new();
        contents(&mut out, &known);
        let expected = r#"{"dialect":{"profile":"ros2","library":"\"x\""},"passed_over":[{"kind":"Attachment","count":2}],"topics":[{"name":"/can0","schema":"","encoding":"","read_as":"","bus":"can0","messages":3}]}"#;
        assert_eq!(out, expected.as_bytes());
    }
}
