//! The head of an object, and the search for one behind damage.

use memchr::memmem;

/// The sign of an object.
pub(super) const SIGN: &[u8] = b"LOBJ";
/// Size of an object's first fields, in bytes.
pub(super) const HEAD: usize = 16;
/// Maximum number of bytes between two objects.
pub(super) const PADDING: usize = 4;
/// Number of bytes within which the next object's sign is.
pub(super) const NEAR: usize = PADDING + SIGN.len();

/// The first fields of an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectHead {
    /// Size of its header, in bytes.
    pub(super) header: usize,
    /// Version of its header.
    pub(super) version: u16,
    /// Its size, in bytes.
    pub(super) size: usize,
    /// Its type.
    pub(super) kind: u32,
}

impl ObjectHead {
    /// Reads the head at a place; `None` if it is not complete.
    pub(super) fn read(data: &[u8], at: usize) -> Option<Self> {
        let head = data.get(at..)?.first_chunk::<HEAD>()?;
        let (header, version) = (u16_at(head, 4).into(), u16_at(head, 6));
        Some(Self { header, version, size: u32_at(head, 8) as usize, kind: u32_at(head, 12) })
    }
}

/// Returns two bytes as a number; 0 beyond the end.
pub(super) fn u16_at(data: &[u8], at: usize) -> u16 {
    data.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| u16::from_le_bytes(*bytes))
}

/// Returns four bytes as a number; 0 beyond the end.
pub(super) fn u32_at(data: &[u8], at: usize) -> u32 {
    data.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

/// Returns eight bytes as a number; 0 beyond the end.
pub(super) fn u64_at(data: &[u8], at: usize) -> u64 {
    data.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

/// Returns the number of bytes from a place to the next object's sign, if it is near.
pub(super) fn sign_near(data: &[u8], at: usize) -> Option<usize> {
    let near = data.get(at..)?;
    let near = near.get(..NEAR).unwrap_or(near);
    near.windows(SIGN.len()).position(|bytes| bytes == SIGN)
}

/// Returns true if the bytes between two objects are padding: as many as the size before them asks for, or few zeros.
pub(super) fn is_padding(gap: &[u8], before: usize) -> bool {
    let (size, over) = (gap.len(), before % 4);
    let asked = size == over || size == (4 - over) % 4;
    size == 0 || size <= PADDING && (asked || gap.iter().all(|byte| *byte == 0))
}

/// Returns the place of the next head between two places: four letters alone may be in data.
pub(super) fn next_head(data: &[u8], from: usize, to: usize) -> Option<usize> {
    search(data, from, to, |head: &[u8; HEAD]| {
        let [_, _, _, _, header, h, version, v, _, _, size, s, kind, a, b, c] = *head;
        header >= 0x10 && h == 0 && version <= 3 && v == 0 && size <= 0x80 && s == 0 && kind >= 1 && [a, b, c] == [0; 3]
    })
}

/// Returns the place of the next container's head between two places.
pub(super) fn next_container(data: &[u8], from: usize, to: usize) -> Option<usize> {
    search(data, from, to, |head: &[u8; HEAD + 2]| {
        let [_, _, _, _, header, h, version, v, _, _, size, s, kind, a, b, c, method, m] = *head;
        [header, h, version, v] == [0x10, 0, 1, 0]
            && size <= 0x80
            && s <= 4
            && [kind, a, b, c] == [10, 0, 0, 0]
            && matches!([method, m], [0 | 2, 0])
    })
}

/// Returns the place of the next sign between two places whose head `fits`.
fn search<const N: usize>(data: &[u8], from: usize, to: usize, fits: impl Fn(&[u8; N]) -> bool) -> Option<usize> {
    let data = data.get(..to.min(data.len()))?;
    memmem::find_iter(data.get(from..)?, SIGN)
        .map(|place| from + place)
        .find(|place| data.get(*place..).and_then(<[u8]>::first_chunk).is_some_and(&fits))
}

/// Returns the place at the end of data where a head may begin that goes on behind them; their end if there is none.
pub(super) fn partial_head(data: &[u8], from: usize) -> usize {
    let first = from.max((data.len() + 1).saturating_sub(HEAD));
    let begins = |at: &usize| {
        let rest = data.get(*at..).unwrap_or_default();
        SIGN.starts_with(rest.get(..SIGN.len()).unwrap_or(rest))
    };
    (first..data.len()).find(begins).unwrap_or(data.len())
}
