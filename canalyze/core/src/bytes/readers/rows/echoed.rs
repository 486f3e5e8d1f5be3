//! Messages of ROS as `ros2 topic echo` and `rostopic echo` print them: a name and its value in each line, a list over
//! several. Each message becomes a row that names its values.

use super::LONGEST;

/// The first line of a message.
const FIRST: &[u8] = b"header:";

/// A message that is printed.
#[derive(Debug, Default)]
pub(super) struct Echoed {
    /// The row so far; empty outside a message.
    row: Vec<u8>,
    /// The whole seconds of its stamp.
    seconds: Vec<u8>,
    /// Bytes that the list of data still has; the array is longer than the frame.
    left: usize,
    /// The list of data is open.
    listed: bool,
}

impl Echoed {
    /// Returns true if the line begins a message.
    pub(super) fn begins(line: &[u8]) -> bool {
        line == FIRST
    }

    /// Begins a message.
    pub(super) fn begin(&mut self) {
        *self = Self { row: b"{".to_vec(), left: usize::MAX, ..Self::default() };
    }

    /// Takes a line of the message; returns false if the line is none, so that the message has ended.
    pub(super) fn take(&mut self, line: &[u8]) -> bool {
        if self.row.is_empty() || self.row.len() > LONGEST {
            return false;
        }
        if let Some(item) = line.strip_prefix(b"- ") {
            self.byte(item);
            return self.listed;
        }
        let Some(sign) = memchr::memchr(b':', line) else { return false };
        let (name, rest) = line.split_at_checked(sign).unwrap_or_default();
        let value = rest.get(1..).unwrap_or_default().trim_ascii();
        self.close();
        match name {
            b"sec" | b"secs" => self.seconds = value.to_vec(),
            b"nanosec" | b"nsecs" if value.iter().all(u8::is_ascii_digit) && value.len() <= 9 => {
                let zeros = b"000000000".get(value.len()..).unwrap_or_default();
                let seconds = std::mem::take(&mut self.seconds);
                self.pair(b"time", &[&seconds, &b"."[..], zeros, value].concat());
            }
            b"frame_id" => self.pair(b"channel", value),
            b"data" => {
                self.row.extend_from_slice(b"\"data\": [");
                self.listed = true;
                let inner = value.strip_prefix(b"[").and_then(|value| value.strip_suffix(b"]")).unwrap_or_default();
                inner.split(|byte| *byte == b',').map(<[u8]>::trim_ascii).for_each(|item| self.byte(item));
            }
            _ => {
                if name == b"dlc" {
                    let length = std::str::from_utf8(value).ok().and_then(|value| value.parse().ok());
                    self.left = length.unwrap_or(usize::MAX);
                }
                self.pair(name, value);
            }
        }
        true
    }

    /// Ends the message and returns its row, if there was one.
    pub(super) fn end(&mut self) -> Option<Vec<u8>> {
        self.close();
        let mut row = std::mem::take(&mut self.row);
        (!row.is_empty()).then(|| {
            row.push(b'}');
            row
        })
    }

    fn pair(&mut self, name: &[u8], value: &[u8]) {
        if !value.is_empty() {
            for part in [b"\"", name, b"\": ", value, b", "] {
                self.row.extend_from_slice(part);
            }
        }
    }

    fn byte(&mut self, item: &[u8]) {
        if self.listed && self.left > 0 && !item.is_empty() {
            self.left -= 1;
            self.row.extend_from_slice(item);
            self.row.push(b',');
        }
    }

    fn close(&mut self) {
        if std::mem::take(&mut self.listed) {
            self.row.extend_from_slice(b"], ");
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::bytes::frame::{Buses, Frame};
    use crate::bytes::ns::Ns;
    use crate::bytes::readers::Item;
    use crate::bytes::readers::rows::{Rows, has_object};

    fn read(text: &str) -> (Vec<Frame>, usize) {
        let (mut frames, mut unreadable) = (Vec::new(), 0);
        let (mut rows, mut buses) = (Rows::default(), Buses::default());
        let mut take = |item: Item, _: &Buses| match item {
            Item::Frame(frame) => frames.push(frame),
            Item::Unreadable { .. } => unreadable += 1,
            _ => {}
        };
        for piece in text.as_bytes().chunks(7) {
            rows.feed(piece, &mut buses, &mut take);
        }
        rows.finish(&mut buses, &mut take);
        (frames, unreadable)
    }

    const HEAD: &str = "header:\n  stamp:\n    sec: 1700000000\n    nanosec: 2000\n  frame_id: can1\n";
    const KIND: &str = "is_rtr: false\nis_extended: false\nis_error: false\n";

    #[test]
    fn messages_as_they_are_printed() {
        let listed = format!("{HEAD}id: 1537\n{KIND}dlc: 2\ndata:\n- 64\n- 23\n- 0\n- 0\n- 0\n- 0\n- 0\n- 0\n---\n");
        let inline = format!("{HEAD}id: 1409\n{KIND}dlc: 3\ndata: [75, 23, 16, 0, 0, 0, 0, 0]\n---\n");
        let text = format!("$ ros2 topic echo /from_can_bus\n{listed}{inline}");
        assert!(has_object(text.as_bytes()));
        let (frames, unreadable) = read(&text);
        let said: Vec<_> = frames.iter().map(|frame| (frame.id.raw(), frame.payload())).collect();
        assert_eq!(said, [(1537, &[64, 23][..]), (1409, &[75, 23, 16][..])]);
        assert!(frames.iter().all(|frame| frame.t_ns == Some(Ns(1_700_000_000_000_002_000))));
        assert_eq!(unreadable, 0);
    }

    #[test]
    fn a_message_without_its_end_is_unreadable() {
        let whole = format!("{HEAD}id: 1537\n{KIND}dlc: 1\ndata: [64]\n---\n");
        let (frames, unreadable) = read(&format!("{whole}{HEAD}id: 1537\n{KIND}dlc: 8\ndata:\n- 64\n- 23\n"));
        assert_eq!((frames.len(), unreadable), (1, 1));
        let (frames, _) = read("header:\n  title: prose\nid: 5\n");
        assert!(frames.is_empty());
    }
}
