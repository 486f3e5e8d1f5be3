//! A reader's knowledge of its file beyond frames, as one JSON object: for `info`, and for files without any frame.

use super::obj::{WriteJson, array, map, obj};
use crate::bytes::readers::Contents;

/// Appends the object, without a line's end.
pub fn contents(out: &mut Vec<u8>, contents: &Contents) {
    obj! {
        /// Words of the format's own, each with its value as a string.
        "dialect": map(contents.dialect.iter().map(|(word, value)| (*word, &**value))),
        "passed_over": array(contents.passed_over.iter().map(|(kind, count)| obj! { "kind": &**kind, "count": *count })),
        "topics": array(contents.topics.iter().map(|topic| obj! {
            "name": &*topic.name, "schema": &*topic.schema, "encoding": &*topic.encoding, "read_as": &*topic.read_as,
            "bus": &*topic.bus, "messages": topic.messages,
        })),
    }
    .write_json(out);
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
