//! The running USDO transfers of a bus, and the frame that goes to one of them.

use std::collections::BTreeMap;

use super::open::{OpenTransfer, TransferKey, UsdoPhase};
use super::servers::Servers;
use crate::bytes::frame::{Frame, FrameRef};
use crate::evidence::When;
use crate::evidence::duplicates::Sighting;
use crate::sdo::proof::OneSided;
use crate::sdo::transfer::{Beginning, Direction, Mode, Transfer, TransferId, UsdoSession};
use crate::sdo::wire::Mux;
use crate::wire::message::Message;
use crate::wire::usdo::Pdu;
use crate::world::context::Context;
use crate::world::event::What;
use crate::world::node::{Node, PerNode};

/// Maximum number of transfers kept (invariant 6); ended ones make room.
pub(super) const KEPT: usize = 1024;

/// The USDO transfers of a bus.
#[derive(Debug, Default)]
pub struct Usdo {
    pub(super) running: BTreeMap<TransferKey, Box<OpenTransfer>>,
    /// Requests to all nodes by client and session-ID, until the client uses the session-ID again.
    pub(super) broadcast: BTreeMap<(u8, u8), (FrameRef, When, Vec<u8>)>,
    /// A client frame without a transfer, which the server may refuse.
    pub(super) stray: Option<(TransferKey, FrameRef)>,
    pub(super) servers: Servers,
}

impl Usdo {
    /// Takes a frame: appends its own event and its consequences.
    pub fn step(&mut self, message: Message, frame: &Frame, nodes: &PerNode<Node>, cx: &mut Context<'_>) {
        let Message::Usdo { request, source, destination, .. } = message else { return };
        let (client, server) = if request { (source, destination) } else { (destination, source) };
        let place = cx.events.len();
        cx.push(None, Some(server).filter(|server| (1..=127).contains(server)), What::Message(message));
        let Some(pdu) = Pdu::read(frame.payload()).filter(|_| cx.sighting != Sighting::Duplicate) else { return };
        if client > 127 || server > 127 {
            // A group of nodes, or no node.
            return;
        }
        let key = TransferKey { client, server, session: pdu.session };
        self.servers.count(request, server, &pdu, usize::from(frame.len), cx);
        let id = match (request, server) {
            (true, 0) => self.sent_to_all(key, &pdu, frame, nodes, cx),
            (true, _) => self.client(key, &pdu, nodes, cx),
            (false, _) => self.server(key, &pdu, nodes, cx),
        };
        if let Some(event) = cx.events.get_mut(place) {
            event.transfer = id;
        }
    }

    pub(super) fn is_open(&self, key: TransferKey) -> bool {
        self.running.get(&key).is_some_and(|one| one.phase != UsdoPhase::Over)
    }

    pub(super) fn transfer(
        &self,
        key: TransferKey,
        direction: Direction,
        mode: Mode,
        mux: Option<Mux>,
        cx: &mut Context<'_>,
    ) -> Transfer {
        *cx.next_transfer = cx.next_transfer.saturating_add(1);
        let id = TransferId(*cx.next_transfer);
        let beginning = Beginning { id, bus: cx.bus, node: key.server, channel: None, extract: cx.extract, at: cx.at };
        let session = Some(UsdoSession { client: key.client, id: key.session });
        Transfer { session, ..Transfer::new(beginning, direction, mode, mux) }
    }

    /// Returns the number of frames, and whether they are known to be USDO.
    pub fn shown(&self) -> Option<(Option<bool>, u64)> {
        self.servers.shown()
    }

    /// Returns the servers of which one direction only was recorded.
    pub fn one_sided(&self) -> Vec<OneSided> {
        self.servers.one_sided()
    }
}
