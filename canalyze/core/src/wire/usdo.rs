//! USDO, CANopen FD's service data (CiA 1301), in SDO's place on 600h/580h + the sender's node-ID.
//!
//! | byte | field |
//! |---|---|
//! | 0 | destination node-ID, 0 = all |
//! | 1 | command specifier; bit 7: remote (across networks) |
//! | 2 | session-ID |
//! | 3 | sub-index |
//! | 4-5 | index |
//! | 6 | data type, or the abort code |
//! | 7 | size of the data in bytes |
//! | 8.. | data, at most 56 bytes |
//!
//! Only the first three bytes are common to all commands; the others stand where a command names an object. Open
//! sources are few, so what is not certain (segments, bulk transfer) is left as bytes.

use super::length;
use crate::wire::cob_id::Role;
use crate::wire::message::Message;

/// The abort command.
pub const ABORT: u8 = 0x7F;

/// What a command that names an object carries after the common bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UsdoObject<'a> {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
    /// Data type code (CiA 301's), where the command carries data.
    pub data_type: Option<u8>,
    /// Size of the data in bytes as stated, where the command carries data.
    pub size: Option<u8>,
    /// Abort code, of the abort command only.
    pub abort: Option<u8>,
    /// Data, as far as the frame reaches; padding of the frame cut off by the stated size.
    pub data: &'a [u8],
}

/// Decodes an FD frame on an SDO identifier.
pub fn decode(role: Role, request: bool, source: u8, payload: &[u8]) -> Message {
    match *payload {
        [destination, command, ..] => Message::Usdo { request, source, destination, command },
        _ => length(role, 2, 64),
    }
}

/// The object that a command names; `None` for those that name none or where the frame is too short.
pub fn object(payload: &[u8]) -> Option<UsdoObject<'_>> {
    let [_, command, _, sub, low, high, rest @ ..] = payload else {
        return None;
    };
    let mut object = UsdoObject {
        index: u16::from_le_bytes([*low, *high]),
        sub: *sub,
        data_type: None,
        size: None,
        abort: None,
        data: &[],
    };
    match (command & 0x7F, rest) {
        (ABORT, [code, ..]) => object.abort = Some(*code),
        // Upload request and the server's confirmations: the object alone.
        (0x11 | 0x21 | 0x22 | 0x26 | ABORT, _) => {}
        (0x01 | 0x31 | 0x02 | 0x32 | 0x06, [data_type, size, data @ ..]) => {
            object.data_type = Some(*data_type);
            object.size = Some(*size);
            object.data = data.get(..usize::from(*size)).unwrap_or(data);
        }
        (0x01 | 0x31 | 0x02 | 0x32 | 0x06, _) => {}
        _ => return None,
    }
    Some(object)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;

    #[test]
    fn expedited_download() {
        let payload = [5, 0x01, 7, 0x01, 0x00, 0x20, 0x07, 4, 0x2A, 0, 0, 0];
        assert_eq!(
            decode(Role::SdoRequest(10), true, 10, &payload),
            Message::Usdo { request: true, source: 10, destination: 5, command: 1 }
        );
        let object = object(&payload).unwrap();
        assert_eq!((object.index, object.sub, object.data_type, object.size), (0x2000, 1, Some(7), Some(4)));
        assert_eq!(object.data, [0x2A, 0, 0, 0]);
    }

    #[test]
    fn aborts_and_short_frames() {
        assert_eq!(object(&[5, 0x7F, 7, 0, 0x00, 0x20, 0x33]).unwrap().abort, Some(0x33));
        assert_eq!(object(&[5, 0x03, 7, 0, 0, 0, 0, 0]), None);
        assert_eq!(object(&[5, 0x01, 7]), None);
        assert_eq!(decode(Role::SdoRequest(10), true, 10, &[5]), length(Role::SdoRequest(10), 2, 64));
    }
}
