//! The conversion of a message's fields to a frame, including contradictory flags, lengths and identifiers.

use crate::bytes::frame::{BusId, CanId, Frame, Kind, LengthForm};
use crate::bytes::readers::Unreadable;

const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = 0x2000_0000;
const NUMBER: u32 = 0x1FFF_FFFF;
/// Lengths of FD frames for the codes 9 to 15.
const FD_LENGTHS: [u8; 7] = [12, 16, 20, 24, 32, 48, 64];

/// The fields of one message.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fields<'a> {
    /// The stamp in ns, if any.
    pub(super) stamp_ns: Option<i64>,
    pub(super) id: u64,
    pub(super) ext: bool,
    pub(super) rtr: bool,
    pub(super) err: bool,
    /// True for an FD frame; `None` if the length decides.
    pub(super) fd: Option<bool>,
    pub(super) brs: bool,
    pub(super) esi: bool,
    /// The length; `None` for all of the data.
    pub(super) len: Option<u64>,
    /// True if the length may be a code when the data are longer.
    pub(super) len_is_code: bool,
    pub(super) bus: Option<BusField<'a>>,
    pub(super) data: &'a [u8],
}

/// The bus in a message.
#[derive(Clone, Copy, Debug)]
pub(super) enum BusField<'a> {
    Name(&'a [u8]),
    Number(u64),
}

impl Fields<'_> {
    /// Returns the frame without time, bus and direction.
    #[inline(always)]
    pub(super) fn frame(&self) -> Result<Frame, Unreadable> {
        let id = u32::try_from(self.id).map_err(|_| Unreadable::Identifier)?;
        let number = id & NUMBER;
        let err = self.err || id & ERROR != 0;
        let rtr = !err && (self.rtr || id & REMOTE != 0);
        // No standard frame has such a number, even if a driver left the flag unset.
        let ext = err || self.ext || id & EXTENDED != 0 || number > 0x7FF;
        let said = self.len.unwrap_or(self.data.len() as u64);
        let (len, raw_dlc, fd) = self.length(said, err || rtr)?;
        let kind = match (err, rtr, fd) {
            (true, ..) => Kind::Error,
            (_, true, _) => Kind::Remote,
            (.., true) => Kind::Fd { brs: self.brs, esi: self.esi },
            _ => Kind::Data,
        };
        let mut data = [0; 64];
        if kind != Kind::Remote {
            let payload = self.data.get(..usize::from(len)).ok_or(Unreadable::Data)?;
            if let (Some(slot), Ok(eight)) = (data.first_chunk_mut::<8>(), <[u8; 8]>::try_from(payload)) {
                *slot = eight;
            } else {
                data.iter_mut().zip(payload).for_each(|(slot, byte)| *slot = *byte);
            }
        }
        Ok(Frame {
            no: 0,
            moved: 0,
            corrected_ns: 0,
            line: None,
            t_ns: None,
            stamp: None,
            bus: BusId(0),
            id: if ext { CanId::extended(number) } else { CanId::standard(number as u16) },
            kind,
            dir: None,
            len,
            length_form: LengthForm { raw_dlc, ..LengthForm::default() },
            data,
        })
    }

    /// Returns the number of bytes, the code above 8 of a classic frame, and true for an FD frame.
    #[inline(always)]
    fn length(&self, said: u64, classic: bool) -> Result<(u8, u8, bool), Unreadable> {
        if let (0..=8, None | Some(false)) = (said, self.fd) {
            return Ok((said as u8, 0, false));
        }
        let room = self.data.len() as u64;
        let fd = !classic && self.fd.unwrap_or(room > 8);
        match said {
            0..=8 => Ok((said as u8, 0, fd)),
            9..=15 if !fd => Ok((8, said as u8, false)),
            _ if !fd => Err(Unreadable::Length),
            9..=15 if self.len_is_code && room > said => {
                let len = FD_LENGTHS.get(said as usize - 9).copied().ok_or(Unreadable::Length)?;
                Ok((len, 0, true))
            }
            _ => match u8::try_from(said) {
                Ok(len) if FD_LENGTHS.contains(&len) => Ok((len, 0, true)),
                _ => Err(Unreadable::Length),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: Fields<'_> = Fields {
        stamp_ns: None,
        id: 0x123,
        ext: false,
        rtr: false,
        err: false,
        fd: None,
        brs: false,
        esi: false,
        len: None,
        len_is_code: false,
        bus: None,
        data: &[1, 2, 3, 4, 5, 6, 7, 8],
    };

    fn shown(fields: Fields<'_>) -> String {
        match fields.frame() {
            Ok(Frame { id, kind, len, length_form, .. }) => format!("{id:?} {kind:?} {len} {}", length_form.raw_dlc),
            Err(reason) => format!("{reason:?}"),
        }
    }

    #[test]
    fn flags_and_lengths() {
        let long = [7; 64];
        let fd = "Fd { brs: false, esi: false }";
        let rows: &[(Fields<'_>, &str)] = &[
            (BASE, "123 Data 8 0"),
            (Fields { ext: true, ..BASE }, "00000123 Data 8 0"),
            (Fields { id: 0x8000_0123, ..BASE }, "00000123 Data 8 0"),
            (Fields { id: 0x18FF_1234, ..BASE }, "18FF1234 Data 8 0"),
            (Fields { id: 0x4000_0123, len: Some(4), ..BASE }, "123 Remote 4 0"),
            (Fields { id: 0x2000_0004, ..BASE }, "00000004 Error 8 0"),
            (Fields { err: true, id: 4, ..BASE }, "00000004 Error 8 0"),
            (Fields { id: 1 << 32, ..BASE }, "Identifier"),
            (Fields { len: Some(3), ..BASE }, "123 Data 3 0"),
            (Fields { len: Some(12), ..BASE }, "123 Data 8 12"),
            (Fields { len: Some(16), ..BASE }, "Length"),
            (Fields { len: Some(8), data: &[1], ..BASE }, "Data"),
            (Fields { rtr: true, len: Some(8), data: &[], ..BASE }, "123 Remote 8 0"),
            (Fields { len: Some(12), data: &long, ..BASE }, &format!("123 {fd} 12 0")),
            (Fields { len: Some(10), data: &long, ..BASE }, "Length"),
            (Fields { len: Some(10), len_is_code: true, data: &long, ..BASE }, &format!("123 {fd} 16 0")),
            (Fields { len: Some(15), len_is_code: true, data: &long, ..BASE }, &format!("123 {fd} 64 0")),
            (Fields { len: Some(4), fd: Some(true), data: &long, ..BASE }, &format!("123 {fd} 4 0")),
            (
                Fields { fd: Some(true), brs: true, esi: true, data: &long, ..BASE },
                "123 Fd { brs: true, esi: true } 64 0",
            ),
            (Fields { fd: Some(false), len: Some(9), data: &long, ..BASE }, "123 Data 8 9"),
            (Fields { len: Some(64), ..BASE }, "Length"),
        ];
        for (fields, expected) in rows {
            assert_eq!(shown(*fields), *expected, "{fields:?}");
        }
    }
}
