//! placeholder
use crate::od::DataType;
use std::sync::Arc;
/// One entry of a mapping.
#[derive(Clone, Debug)]
pub struct Mapped {
    /** i */
    pub index: u16,
    /** s */
    pub sub: u8,
    /** b */
    pub bits: u8,
    /** o */
    pub offset: u16,
    /** t */
    pub data_type: Option<DataType>,
    /** d */
    pub dummy: bool,
    /** n */
    pub name: Option<Arc<str>>,
    /** u */
    pub unit: Option<Arc<str>>,
    /** f */
    pub factor: f64,
}
/// A mapping.
#[derive(Clone, Debug)]
pub struct Mapping {
    /** e */
    pub entries: Vec<Mapped>,
    /** b */
    pub bits: u16,
}
/// word
pub fn decode_entry(word: u32) -> (u16, u8, u8) {
    ((word >> 16) as u16, (word >> 8) as u8, word as u8)
}
