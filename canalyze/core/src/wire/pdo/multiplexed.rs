//! The content of a multiplex PDO (CiA 301, 7.2.2.4), with its layout at the head of `services::pdo`.

/// The content of a multiplex PDO (CiA 301, 7.2.2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multiplexed {
    /// Destination address mode: node and object are the consumer's, otherwise the producer's.
    pub destination: bool,
    /// Node-ID, 0..=127; in destination address mode 0 is all nodes.
    pub node: u8,
    /// Index of the object.
    pub index: u16,
    /// Sub-index of the object.
    pub sub: u8,
    /// The object's data, four bytes.
    pub data: [u8; 4],
}

/// Decodes the content of a multiplex PDO; `None` unless it is exactly eight bytes.
pub fn multiplexed(payload: &[u8]) -> Option<Multiplexed> {
    let [address, low, high, sub, a, b, c, d] = *payload else {
        return None;
    };
    Some(Multiplexed {
        destination: address & 0x80 != 0,
        node: address & 0x7F,
        index: u16::from_le_bytes([low, high]),
        sub,
        data: [a, b, c, d],
    })
}
