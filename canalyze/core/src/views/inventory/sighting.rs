//! The objects and values that single frames and transfers show, with node and service.
//!
//! | shown by | as | whose |
//! |---|---|---|
//! | a transfer that is ok | `read`, `written` | the server's |
//! | a transfer that the server has aborted | `refused` | the server's |
//! | any other one: without a response, given up, cut, or against the protocol | `unconfirmed` | the server's |
//! | a signal of a TPDO | `tpdo` | the producer's; by a consumer's mapping that consumer's, as `rpdo` |
//! | a signal of an RPDO | `rpdo` | the consumer's |
//! | an MPDO | `tpdo`; in destination address mode `rpdo` | the producer's; the addressed node's; none if addressed to all nodes |
//! | an EMCY, which carries the error register 1001h | `emcy` | the producer's |
//!
//! Nothing is kept here.

use crate::bytes::frame::{BusId, Frame, FrameRef};
use crate::sdo::transfer::{Abort, Direction, Mode, Status, Transfer};
use crate::sdo::wire::{Mux, Side};
use crate::wire::pdo::mapping::{Mapped, Mapping};
use crate::words::profiles::Profile;
use crate::world::change::{Change, EmcyChange};
use crate::world::event::{Event, Signals, What};

/// The error register, which each EMCY carries.
const REGISTER: Mux = Mux { index: 0x1001, sub: 0 };

/// The service by which something of an object is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A successful upload.
    Read,
    /// A successful download.
    Written,
    /// A PDO of the device.
    Tpdo,
    /// A PDO to the device.
    Rpdo,
    /// An EMCY.
    Emcy,
    /// A request that the device has aborted.
    Refused,
    /// A request without a successful end in the capture.
    Unconfirmed,
}

impl Source {
    /// All of them, in the order of the columns.
    pub const ALL: [Self; 7] =
        [Self::Read, Self::Written, Self::Tpdo, Self::Rpdo, Self::Emcy, Self::Refused, Self::Unconfirmed];

    /// The word in machine output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Written => "written",
            Self::Tpdo => "tpdo",
            Self::Rpdo => "rpdo",
            Self::Emcy => "emcy",
            Self::Refused => "refused",
            Self::Unconfirmed => "unconfirmed",
        }
    }

    /// Returns true if the device sends the value, by itself or on request.
    pub fn is_given(self) -> bool {
        matches!(self, Self::Read | Self::Tpdo | Self::Emcy)
    }

    /// Returns true if it shows a value of the object.
    pub fn is_value(self) -> bool {
        !matches!(self, Self::Refused | Self::Unconfirmed)
    }
}

/// The origin of a sighting.
#[derive(Clone, Copy, Debug)]
pub enum Shown<'a> {
    /// A transfer.
    Transfer(&'a Transfer),
    /// Bits of a PDO.
    Bits(&'a Mapped, u64),
    /// Whole bytes of a PDO that are not a number.
    Octets(&'a Mapped, &'a [u8]),
    /// The error register of a device of this profile.
    Register(u8, Profile),
}

/// A value, if there is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content<'a> {
    /// It is unknown, or not completely known.
    None,
    /// The first bytes, and the size in bytes.
    Bytes(&'a [u8], u64),
    /// Bits, the first lowest, and their number.
    Bits(u64, u8),
}

impl Content<'_> {
    /// Returns its size in bytes.
    pub fn size(self) -> u64 {
        match self {
            Self::None => 0,
            Self::Bytes(_, size) => size,
            Self::Bits(_, bits) => u64::from(bits).div_ceil(8),
        }
    }

    /// Returns true if it is another value of the same form; bytes are compared up to the kept length of the shorter
    /// one.
    pub(super) fn differs(self, other: Content<'_>) -> bool {
        match (self, other) {
            (Self::Bytes(one, size), Content::Bytes(two, other)) => {
                size != other || one.iter().zip(two).any(|(one, two)| one != two)
            }
            (Self::Bits(one, bits), Content::Bits(two, other)) => bits == other && one != two,
            _ => false,
        }
    }
}

/// An observation of an object.
#[derive(Clone, Copy, Debug)]
pub struct ObjectSighting<'a> {
    /// The bus.
    pub bus: BusId,
    /// The node that has the object.
    pub node: u8,
    /// The object.
    pub object: Mux,
    /// The frame that shows it; of a transfer the last one.
    pub at: FrameRef,
    /// The service.
    pub source: Source,
    /// The origin.
    pub shown: Shown<'a>,
}

impl<'a> ObjectSighting<'a> {
    /// Returns the sighting of a transfer that has ended; `None` if its object is unknown.
    pub fn of(transfer: &'a Transfer) -> Option<Self> {
        let by_server = transfer.outcome.abort.is_some_and(|abort| abort.by == Side::Server);
        let source = match (transfer.outcome.status, transfer.direction) {
            (Status::Ok, _) if transfer.outcome.bad => Source::Unconfirmed,
            (Status::Ok, Direction::Upload) => Source::Read,
            (Status::Ok, Direction::Download) => Source::Written,
            (Status::Aborted, _) if by_server => Source::Refused,
            _ => Source::Unconfirmed,
        };
        let Transfer { bus, node, last, .. } = *transfer;
        Some(Self { bus, node, object: transfer.mux?, at: last, source, shown: Shown::Transfer(transfer) })
    }

    /// Returns the value that was seen, or that was requested.
    pub fn content(&self) -> Content<'a> {
        match self.shown {
            Shown::Bits(mapped, raw) => Content::Bits(raw, mapped.bits),
            Shown::Octets(_, bytes) => Content::Bytes(bytes, bytes.len() as u64),
            Shown::Register(register, _) => Content::Bits(u64::from(register), 8),
            Shown::Transfer(transfer) if self.source.is_value() => {
                let kept = transfer.data.kept.as_slice();
                if transfer.data.hole { Content::None } else { Content::Bytes(kept, transfer.data.size) }
            }
            Shown::Transfer(transfer) if transfer.data.requested.is_empty() => Content::None,
            Shown::Transfer(transfer) => {
                let asked = transfer.data.requested.as_slice();
                Content::Bytes(asked, asked.len() as u64)
            }
        }
    }

    /// Returns true if the size of its value is known: an expedited transfer need not indicate it.
    pub fn is_sized(&self) -> bool {
        match self.shown {
            Shown::Transfer(transfer) => transfer.mode != Mode::Expedited || transfer.data.size_indicated.is_some(),
            _ => true,
        }
    }

    /// The abort that ended it.
    pub fn aborted(&self) -> Option<(Direction, Abort)> {
        match self.shown {
            Shown::Transfer(transfer) => Some((transfer.direction, transfer.outcome.abort?)),
            _ => None,
        }
    }
}

/// Passes on the objects that a frame shows, except by transfers that end with it.
pub fn each(frame: &Frame, events: &[Event], take: &mut dyn FnMut(ObjectSighting<'_>)) {
    for event in events {
        match &event.what {
            What::Pdo(data) => match &data.content {
                Signals::Mapped(mapping, _) => {
                    let source = if data.transmit { Source::Tpdo } else { Source::Rpdo };
                    signals(frame, mapping, (data.node, source), take);
                }
                Signals::ByConsumer(mapping, _, consumer, _) => {
                    signals(frame, mapping, (*consumer, Source::Rpdo), take);
                }
                Signals::None(_) => {}
            },
            What::Mpdo(data) if data.content.destination && data.content.node == 0 => {}
            What::Mpdo(data) => {
                let source = if data.content.destination { Source::Rpdo } else { Source::Tpdo };
                signals(frame, &data.mapping, (data.content.node, source), take);
            }
            What::Change(Change::Error(EmcyChange { node, register, profile, .. })) => take(ObjectSighting {
                bus: event.bus,
                node: *node,
                object: REGISTER,
                at: event.at,
                source: Source::Emcy,
                shown: Shown::Register(*register, *profile),
            }),
            _ => {}
        }
    }
}

fn signals(frame: &Frame, mapping: &Mapping, (node, source): (u8, Source), take: &mut dyn FnMut(ObjectSighting<'_>)) {
    let payload = frame.payload();
    for mapped in mapping.entries.iter().filter(|mapped| !mapped.dummy) {
        let bits = mapping.raw(mapped, payload).map(|raw| Shown::Bits(mapped, raw));
        let octets = || mapping.octets(mapped, payload).map(|bytes| Shown::Octets(mapped, bytes));
        let Some(shown) = bits.or_else(octets) else { continue };
        let object = Mux { index: mapped.index, sub: mapped.sub };
        take(ObjectSighting { bus: frame.bus, node, object, at: frame.reference(), source, shown });
    }
}
