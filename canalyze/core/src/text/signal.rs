//! placeholder
use super::Lang;
use super::digits::put;
use crate::services::pdo::mapping::Mapping;
/// all
pub fn all(out: &mut Vec<u8>, _lang: Lang, mapping: &Mapping, _payload: &[u8]) {
    put!(out; mapping.entries.len());
}
