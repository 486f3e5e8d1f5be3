//! The transfers that are listed: those of channels proved to be SDO.
//!
//! Sensor values on an SDO identifier look like transfers now and then. Transfers wait for the proof of their channel;
//! those of other protocols are never listed.

use std::sync::Arc;

use super::state::SdoChannel;
use super::transfer::Transfer;
use crate::bytes::frame::FrameRef;
use crate::world::context::Context;
use crate::world::event::{Event, What};

/// Maximum number of waiting transfers (invariant 6).
const UNLISTED: usize = 64;

impl SdoChannel {
    /// Lists a finished transfer, or makes it wait.
    pub(super) fn list(&mut self, transfer: Arc<Transfer>, cx: &mut Context<'_>) {
        if self.is_certain() {
            self.list_withheld(cx);
            let about = (!self.own).then_some(transfer.last);
            cx.events.push(self.listed(about, transfer, cx));
        } else if self.unlisted.len() < UNLISTED {
            self.unlisted.push(transfer);
        }
    }

    /// Lists the waiting transfers.
    pub(super) fn list_withheld(&mut self, cx: &mut Context<'_>) {
        for transfer in std::mem::take(&mut self.unlisted) {
            cx.events.push(self.listed(Some(transfer.last), transfer, cx));
        }
    }

    fn listed(&self, about: Option<FrameRef>, transfer: Arc<Transfer>, cx: &Context<'_>) -> Event {
        let (about, bus, node) = (about.map(Box::new), self.server.bus, Some(self.server.node));
        Event { at: cx.at, about, bus, node, transfer: Some(transfer.id), what: What::Transfer(transfer) }
    }
}
