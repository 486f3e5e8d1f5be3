//! The filters behind a live channel's name as in candump, which choose the frames to show:
//! `can0,123:7FF,400~7F0,#1F,j`.
//!
//! The rules are those of the kernel, so that the same frames are shown as by candump. Hidden frames are still received
//! and count for all state. Channels that are not named are shown whole.

use crate::bytes::frame::{Buses, CanId, Frame, Kind};

const EFF: u32 = 0x8000_0000;
const RTR: u32 = 0x4000_0000;
/// Flag of an inverted match in an identifier. In a mask it means error frames and has no effect.
const INVERTED: u32 = 0x2000_0000;
const SFF_MASK: u32 = 0x7FF;
/// Number of digits of a 29-bit identifier.
const EFF_DIGITS: usize = 8;
/// The channel name that matches all channels.
const ANY: &[u8] = b"any";

/// The filters of all named channels; other channels are shown whole.
#[derive(Clone, Debug, Default)]
pub struct Masks {
    channels: Vec<MaskChannel>,
}

/// The filters of one channel.
#[derive(Clone, Debug)]
struct MaskChannel {
    name: Vec<u8>,
    pairs: Vec<MaskPair>,
    /// Classes of error frames.
    errors: u32,
    /// True if all pairs have to match instead of any.
    join: bool,
}

/// An identifier and a mask.
#[derive(Clone, Copy, Debug)]
struct MaskPair {
    id: u32,
    mask: u32,
    inverted: bool,
}

/// An invalid filter, and the whole argument that contains it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaskMistake(pub String, pub String);

impl Masks {
    /// Parses channels with their filters; a channel without filters is shown whole.
    pub fn parse(channels: &[String]) -> Result<Self, MaskMistake> {
        let channels = channels.iter().map(|text| MaskChannel::parse(text));
        Ok(Self { channels: channels.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect() })
    }

    /// Returns true if everything is shown.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    /// Returns true if any entry for the frame's channel shows the frame.
    #[inline]
    pub fn shows(&self, frame: &Frame, buses: &Buses) -> bool {
        if self.channels.is_empty() {
            return true;
        }
        let name = buses.name(frame.bus);
        let mut named = self.channels.iter().filter(|channel| channel.name == name || channel.name == ANY).peekable();
        named.peek().is_none() || named.any(|channel| channel.shows(frame))
    }
}

impl MaskChannel {
    /// Parses one channel; `None` if it has no filters.
    fn parse(text: &str) -> Result<Option<Self>, MaskMistake> {
        let mut parts = text.split(',');
        let name = parts.next().unwrap_or_default().as_bytes().to_vec();
        let mut channel = Self { name, pairs: Vec::new(), errors: 0, join: false };
        let mut any = false;
        for part in parts {
            any = true;
            let wrong = || MaskMistake(part.to_owned(), text.to_owned());
            if let Some(classes) = part.strip_prefix('#') {
                channel.errors = number(classes).ok_or_else(wrong)?;
            } else if matches!(part, "j" | "J") {
                channel.join = true;
            } else {
                channel.pairs.push(MaskPair::parse(part).ok_or_else(wrong)?);
            }
        }
        Ok(any.then_some(channel))
    }

    fn shows(&self, frame: &Frame) -> bool {
        let all = self.join && self.pairs.len() > 1;
        if frame.kind == Kind::Error {
            // An error frame matches no pair, so none passes if all have to match.
            return !all && frame.id.raw() & self.errors != 0;
        }
        let id = identifier(frame.id) | if frame.kind == Kind::Remote { RTR } else { 0 };
        let mut pairs = self.pairs.iter();
        if all {
            pairs.all(|pair| pair.matches(id))
        } else {
            self.pairs.is_empty() || pairs.any(|pair| pair.matches(id))
        }
    }
}

impl MaskPair {
    fn parse(text: &str) -> Option<Self> {
        let at = text.find([':', '~'])?;
        let (id, mask) = (text.get(..at)?, text.get(at + 1..)?);
        let long = if id.len() == EFF_DIGITS { EFF } else { 0 };
        let (id, mask) = (number(id)? | long, number(mask)? & !INVERTED);
        // If the mask includes the frame format, an 11-bit identifier is compared only in the bits that it has.
        let mask = if mask & EFF != 0 && id & EFF == 0 { mask & (SFF_MASK | EFF | RTR) } else { mask };
        Some(Self { id: id & mask, mask, inverted: text.get(at..=at) == Some("~") || id & INVERTED != 0 })
    }

    fn matches(self, id: u32) -> bool {
        (id & self.mask == self.id) != self.inverted
    }
}

/// Returns the identifier with the flag bits of SocketCAN.
fn identifier(id: CanId) -> u32 {
    id.raw() | if id.is_extended() { EFF } else { 0 }
}

/// Parses a hexadecimal number of 32 bits.
fn number(text: &str) -> Option<u32> {
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")).unwrap_or(text);
    u32::from_str_radix(digits, 16).ok().filter(|_| digits.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn shown(masks: &[&str], bus: &str, frame: &Frame) -> bool {
        let masks: Vec<String> = masks.iter().map(|text| (*text).to_owned()).collect();
        let mut buses = Buses::default();
        let bus = buses.intern(bus.as_bytes());
        Masks::parse(&masks).unwrap().shows(&Frame { bus, ..*frame }, &buses)
    }

    fn standard(id: u16) -> Frame {
        Frame::classic(CanId::standard(id), &[0; 8])
    }

    fn extended(id: u32) -> Frame {
        Frame::classic(CanId::extended(id), &[0; 8])
    }

    fn error(class: u32) -> Frame {
        Frame { kind: Kind::Error, ..extended(class) }
    }

    #[test]
    fn pairs_as_candump_has_them() {
        let remote = Frame { kind: Kind::Remote, ..standard(0x123) };
        for (filters, frame, expected) in [
            ("can0", standard(0x123), true),
            ("can0", error(4), true),
            ("can0,123:7FF", standard(0x123), true),
            ("can0,123:7FF", standard(0x124), false),
            ("can0,123:7FF", remote, true),
            ("can0,123:400007FF", remote, false),
            // Without the format bit in the mask, a 29-bit identifier matches by its lower bits.
            ("can0,123:7FF", extended(0x1FFF_F923), true),
            ("can0,123:C00007FF", extended(0x123), false),
            ("can0,123:C00007FF", standard(0x123), true),
            ("can0,00000123:DFFFFFFF", extended(0x123), true),
            ("can0,00000123:DFFFFFFF", standard(0x123), false),
            ("can0,80000123:9FFFFFFF", extended(0x123), true),
            ("can0,0x123:0x7ff", standard(0x123), true),
            // A mask is reduced to the bits of an 11-bit identifier.
            ("can0,123:DFFFFFFF", standard(0x123), true),
            ("can0,123~7FF", standard(0x123), false),
            ("can0,123~7FF", standard(0x124), true),
            ("can0,20000123:7FF", standard(0x124), true),
            ("can0,123:7FF,124:7FF", standard(0x124), true),
            ("can0,100~7FF,200~7FF", standard(0x100), true),
            ("can0,100~7FF,200~7FF,j", standard(0x100), false),
            ("can0,100~7FF,200~7FF,J", standard(0x101), true),
            ("can0,0:0", standard(0x7FF), true),
        ] {
            assert_eq!(shown(&[filters], "can0", &frame), expected, "{filters} {frame:?}");
        }
    }

    #[test]
    fn error_frames_come_by_class_only() {
        assert!(!shown(&["can0,0:0"], "can0", &error(4)));
        assert!(shown(&["can0,#4"], "can0", &error(4)) && !shown(&["can0,#8"], "can0", &error(4)));
        assert!(shown(&["can0,#4"], "can0", &standard(1)) && shown(&["can0,123:7FF,#FF"], "can0", &error(0x40)));
        assert!(!shown(&["can0,1:1,2:2,#FF,j"], "can0", &error(0x40)));
    }

    #[test]
    fn channels_by_themselves() {
        let one = standard(1);
        assert!(shown(&["can0,2:7FF"], "can1", &one) && !shown(&["can0,2:7FF", "can1"], "can0", &one));
        assert!(shown(&["can0,2:7FF", "can1"], "can1", &one));
        assert!(shown(&["can0,2:7FF", "can0,1:7FF"], "can0", &one) && !shown(&["any,2:7FF"], "can7", &one));
    }

    #[test]
    fn mistakes() {
        for part in ["", "123", "123:", ":7FF", "12G:7FF", "#", "#x", "jj", "123:7FF ", "+1:7FF", "123456789:7FF"] {
            let text = format!("can0,{part}");
            assert_eq!(Masks::parse(std::slice::from_ref(&text)).unwrap_err(), MaskMistake(part.to_owned(), text));
        }
    }
}
