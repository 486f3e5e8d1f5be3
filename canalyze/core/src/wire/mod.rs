//! The services of CANopen, one file each: what their frames mean. Pure functions over one frame, but for SDO,
//! the one place that needs its channel's history.
//!
//! Each file begins with the byte table of its frames. None may look at another frame, at time or at a device
//! description: that is the bus's part.

pub mod cob_id;
pub mod emcy;
pub mod error_control;
pub mod error_frame;
pub(crate) mod fields;
pub mod flying_master;
pub mod lss;
pub mod message;
pub mod nmt;
pub mod pdo;
pub mod role;
pub(crate) mod sdo_command;
pub mod srdo;
pub mod sync;
pub mod time;
mod undecoded;
pub mod usdo;

use crate::bytes::frame::{Frame, Kind};
use crate::tables::jsonl::object::Object;
use crate::wire::cob_id::Role;
use crate::wire::message::{Flaw, Message};
use crate::words::lang::Lang;
use fields::FieldRow;

/// What a frame says by itself, given the role of its identifier. Every frame gets an answer.
///
/// Classic data frames of SDO are the caller's part (their meaning depends on the channel); here they yield
/// [`Message::Malformed`].
pub fn decode(role: Role, frame: &Frame) -> Message {
    match frame.kind {
        Kind::Error => Message::ErrorFrame,
        Kind::Remote => remote(role),
        Kind::Fd { .. } => fd(role, frame),
        Kind::Data => data(role, frame),
    }
}

/// A remote frame has a meaning only where a PDO or error control can be asked for.
fn remote(role: Role) -> Message {
    match role {
        Role::Tpdo { number, node } => Message::PdoRequest { transmit: true, number, node },
        Role::Rpdo { number, node } => Message::PdoRequest { transmit: false, number, node },
        Role::ErrorControl(node) => Message::GuardingRequest { node },
        Role::DynamicSdo | Role::Reserved | Role::Unassigned | Role::Foreign => Message::Foreign { role },
        _ => Message::Malformed { role, flaw: Flaw::Remote },
    }
}

/// CANopen FD (CiA 1301) keeps NMT, SYNC, TIME and the heartbeat as they are, has PDOs of up to 64 bytes, and
/// puts USDO in SDO's place. Its EMCY is another message, and LSS, SRDO and flying master know no FD frames.
fn fd(role: Role, frame: &Frame) -> Message {
    match role {
        Role::SdoRequest(node) => usdo::decode(role, true, node, frame.payload()),
        Role::SdoResponse(node) => usdo::decode(role, false, node, frame.payload()),
        Role::Emcy(node) => emcy::decode_fd(role, node, frame.payload()),
        Role::Nmt
        | Role::Sync
        | Role::Time
        | Role::Tpdo { .. }
        | Role::Rpdo { .. }
        | Role::ErrorControl(_)
        | Role::DynamicSdo
        | Role::Reserved
        | Role::Unassigned
        | Role::Foreign => data(role, frame),
        _ => Message::Malformed { role, flaw: Flaw::Fd },
    }
}

fn data(role: Role, frame: &Frame) -> Message {
    let payload = frame.payload();
    match role {
        Role::Nmt => nmt::decode(role, payload),
        Role::Gfc => srdo::decode_gfc(role, payload),
        Role::FlyingMaster(kind) => flying_master::decode(role, kind, payload),
        Role::Sync => sync::decode(role, payload),
        Role::Emcy(node) => emcy::decode(role, node, payload),
        Role::Time => time::decode(role, payload),
        Role::Srdo { number, inverted } => srdo::decode(role, number, inverted, payload),
        Role::Tpdo { number, node } => Message::Pdo { transmit: true, number, node },
        Role::Rpdo { number, node } => Message::Pdo { transmit: false, number, node },
        Role::ErrorControl(node) => error_control::decode(role, node, payload),
        Role::LssRequest => lss::decode(role, true, payload),
        Role::LssResponse => lss::decode(role, false, payload),
        Role::SdoRequest(_) | Role::SdoResponse(_) => length(role, 8, 8),
        Role::DynamicSdo | Role::Reserved | Role::Unassigned | Role::Foreign => Message::Foreign { role },
    }
}

/// The imports of a service's file.
mod prelude {
    pub(super) use super::fields::{
        self,
        Breakdown::{self, *},
        FieldRow, FieldValue, JsonKey, field,
    };
    pub(super) use super::role::{Named, Nodes};
    pub(super) use super::{WireService, length};
    pub(super) use crate::bytes::frame::Frame;
    pub(super) use crate::tables::jsonl::object::Object;
    pub(super) use crate::wire::cob_id::Role;
    pub(super) use crate::wire::message::Message;
    pub(super) use crate::words::digits::{Bin, Hex, Nibbles, Padded, Put, Spaced, put};
    pub(super) use crate::words::lang::{Bilingual, Lang, Size, Term, find, say};
}

/// The forms of a service's messages.
trait WireService {
    /// Appends the phrase of a message, and its content if `full`. No line end.
    fn line(&self, out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, frame: &Frame);

    /// Returns the fields of the message.
    fn fields(&self) -> &'static [FieldRow] {
        &[]
    }

    /// Appends the lines of the breakdown below that of the COB-ID.
    fn breakdown(&self, out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
        fields::breakdown(out, lang, self.fields(), message, frame);
    }

    /// Appends the keys of the service's JSON object.
    fn json(&self, object: &mut Object<'_>, message: &Message, frame: &Frame) {
        fields::json(object, self.fields(), message, frame);
    }
}

/// Returns the forms of a message.
fn service(message: &Message) -> Option<&'static dyn WireService> {
    Some(match message {
        Message::Nmt { .. } => &nmt::NmtService,
        Message::Sync { .. } => &sync::SyncService,
        Message::Time { .. } => &time::TimeService,
        Message::BootUp { .. } | Message::Heartbeat { .. } | Message::GuardingRequest { .. } => {
            &error_control::ErrorControlService
        }
        Message::Emcy { .. } => &emcy::EmcyService,
        Message::EmcyFd { .. } => &emcy::EmcyFdService,
        Message::Lss { .. } => &lss::LssService,
        Message::Srdo { .. } | Message::Gfc => &srdo::SrdoService,
        Message::FlyingMaster { .. } => &flying_master::FlyingMasterService,
        Message::Usdo { .. } => &usdo::UsdoService,
        Message::ErrorFrame => &error_frame::ErrorFrameService,
        Message::Foreign { .. } | Message::Malformed { .. } => &undecoded::UndecodedService,
        _ => return None,
    })
}

/// Appends the phrase of a message, and its content if `full`. No line end. Nothing for a PDO.
pub fn line(out: &mut Vec<u8>, lang: Lang, full: bool, message: &Message, frame: &Frame) {
    if let Some(service) = service(message) {
        service.line(out, lang, full, message, frame);
    }
}

/// Appends the breakdown of a message below the line of its COB-ID. Nothing for a PDO.
pub fn breakdown(out: &mut Vec<u8>, lang: Lang, message: &Message, frame: &Frame) {
    if let Some(service) = service(message) {
        service.breakdown(out, lang, message, frame);
    }
}

/// Appends the keys of a message in JSON. None for a PDO.
pub(crate) fn json(object: &mut Object<'_>, message: &Message, frame: &Frame) {
    if let Some(service) = service(message) {
        service.json(object, message, frame);
    }
}

/// A frame whose payload is not `least..=most` bytes long.
fn length(role: Role, least: u8, most: u8) -> Message {
    Message::Malformed { role, flaw: Flaw::Length { least, most } }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::bytes::frame::CanId;
    use crate::wire::cob_id::predefined;

    fn kind(id: u16, kind: Kind, payload: &[u8]) -> Message {
        let mut frame = Frame::classic(CanId::standard(id), payload);
        frame.kind = kind;
        decode(predefined(frame.id), &frame)
    }

    #[test]
    fn remote_frames() {
        assert_eq!(kind(0x70A, Kind::Remote, &[]), Message::GuardingRequest { node: 10 });
        assert_eq!(kind(0x285, Kind::Remote, &[0; 8]), Message::PdoRequest { transmit: true, number: 2, node: 5 });
        assert_eq!(kind(0x080, Kind::Remote, &[]), Message::Malformed { role: Role::Sync, flaw: Flaw::Remote });
        assert_eq!(
            kind(0x60A, Kind::Remote, &[]),
            Message::Malformed { role: Role::SdoRequest(10), flaw: Flaw::Remote }
        );
        assert_eq!(kind(0x7FF, Kind::Remote, &[]), Message::Foreign { role: Role::Reserved });
    }

    #[test]
    fn fd_frames() {
        let fd = Kind::Fd { brs: true, esi: false };
        assert_eq!(kind(0x000, fd, &[1, 10]), Message::Nmt { command: 1, node: 10 });
        assert_eq!(
            kind(0x70A, fd, &[5]),
            Message::Heartbeat { node: 10, state: 5, toggle: false, guarding: false, previous: None }
        );
        assert_eq!(kind(0x185, fd, &[0; 8]), Message::Pdo { transmit: true, number: 1, node: 5 });
        assert_eq!(kind(0x08A, fd, &[0; 8]), Message::Malformed { role: Role::Emcy(10), flaw: Flaw::Fd });
        assert!(matches!(kind(0x60A, fd, &[5, 0x11]), Message::Usdo { request: true, source: 10, .. }));
    }

    #[test]
    fn classic_sdo_is_not_decoded_here() {
        assert!(matches!(kind(0x60A, Kind::Data, &[0x40; 8]), Message::Malformed { .. }));
    }
}
