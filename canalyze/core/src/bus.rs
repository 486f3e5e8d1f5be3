//! One bus: the owner of its channels' state, and the way of a frame through it.
//!
//! It asks what an identifier carries, hands SDO frames to their channel and everything else to the service's
//! decoder, and passes on what one service means for another: a reset ends the node's transfers.

use std::collections::BTreeMap;

use crate::cob_id::{Role, predefined};
use crate::event::{Event, What};
use crate::frame::{BusId, Frame, Kind};
use crate::message::Message;
use crate::services;
use crate::services::sdo::channel::{Channel, Context};
use crate::services::sdo::wire::Side;

/// NMT commands that reset the node: reset node, reset communication (CiA 301, 7.2.8.3.1).
const RESETS: [u8; 2] = [0x81, 0x82];

/// The state of one bus.
#[derive(Debug, Default)]
pub struct Bus {
    /// Channels of the pre-defined connection set, by the server's node-ID.
    channels: BTreeMap<u8, Box<Channel>>,
}

impl Bus {
    /// Takes one frame: appends its events, the frame's own first.
    pub fn step(&mut self, frame: &Frame, cx: &mut Context<'_>) {
        let role = predefined(frame.id);
        if frame.kind == Kind::Data {
            match role {
                Role::SdoRequest(node) => return self.channel(frame.bus, node).step(Side::Client, frame, cx),
                Role::SdoResponse(node) => return self.channel(frame.bus, node).step(Side::Server, frame, cx),
                _ => {}
            }
        }
        let message = services::decode(role, frame);
        cx.events.push(Event {
            at: cx.at,
            about: None,
            bus: frame.bus,
            node: message.node(),
            transfer: None,
            what: What::Message(message),
        });
        match message {
            Message::BootUp { node } => self.lost(Some(node), true, cx),
            Message::Nmt { command, node: 0 } if RESETS.contains(&command) => self.lost(None, true, cx),
            Message::Nmt { command, node } if RESETS.contains(&command) => self.lost(Some(node), true, cx),
            _ => {}
        }
    }

    fn channel(&mut self, bus: BusId, node: u8) -> &mut Channel {
        self.channels.entry(node).or_insert_with(|| Box::new(Channel::new(bus, node)))
    }

    /// What was open is over: one node (or all) was reset, or frames of the bus were lost.
    pub fn lost(&mut self, node: Option<u8>, reset: bool, cx: &mut Context<'_>) {
        for channel in self.channels.values_mut() {
            if node.is_none_or(|node| node == channel.node()) {
                channel.lost(reset, cx);
            }
        }
    }

    /// The capture is over.
    pub fn finish(&mut self, cx: &mut Context<'_>) {
        for channel in self.channels.values_mut() {
            channel.finish(cx);
        }
    }
}
