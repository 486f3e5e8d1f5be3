//! What each CAN-ID of a bus carries: the pre-defined connection set, overruled by what is known of the nodes.
//!
//! One array look-up for 11-bit identifiers, a small bounded map for 29-bit ones. Made anew when a COB-ID changes.
//! It must not look at frames.

use std::collections::BTreeMap;

use crate::cob_id::{Role, predefined};
use crate::configuration::Provenance;
use crate::frame::CanId;
use crate::network::{Network, Sdo};
use crate::node::{CobId, Node, PREDEFINED, Pdo, PerNode};

/// Distinct 29-bit identifiers with a role, at most (invariant 6).
const EXTENDED: usize = 4096;
/// Identifiers that no configuration moves (CiA 301, 7.3.5): NMT, and from the default SDO channels on.
const FIXED: [u32; 2] = [0x000, 0x7E4];

/// The roles of a bus.
#[derive(Debug)]
pub struct Roles {
    standard: Vec<Role>,
    extended: BTreeMap<u32, Role>,
    /// PDOs that are received on an identifier which is another node's TPDO: consumer and number of its RPDO.
    consumers: BTreeMap<CanId, (u8, u16)>,
    /// Further SDO channels, by either of their identifiers.
    channels: BTreeMap<CanId, CanId>,
    /// Identifiers whose role only unanswered writes give them, with the provenance.
    unconfirmed: BTreeMap<CanId, Provenance>,
}

impl Default for Roles {
    fn default() -> Self {
        Self {
            standard: (0..0x800).map(|id| predefined(CanId::standard(id))).collect(),
            extended: BTreeMap::new(),
            consumers: BTreeMap::new(),
            channels: BTreeMap::new(),
            unconfirmed: BTreeMap::new(),
        }
    }
}

impl Roles {
    /// What an identifier carries.
    pub fn of(&self, id: CanId) -> Role {
        let found = if id.is_extended() { self.extended.get(&id.raw()) } else { self.standard.get(id.raw() as usize) };
        found.copied().unwrap_or(Role::Foreign)
    }

    /// From where the role of an identifier is known, where only unanswered writes give it.
    #[inline]
    pub fn unconfirmed(&self, id: CanId) -> Option<Provenance> {
        if self.unconfirmed.is_empty() { None } else { self.unconfirmed.get(&id).copied() }
    }

    /// The RPDO that receives an identifier whose role is a TPDO: consumer and number.
    pub fn consumer(&self, id: CanId) -> Option<(u8, u16)> {
        self.consumers.get(&id).copied()
    }

    /// The identifier (client to server) that names the channel of an SDO identifier, where it is not the default
    /// channel of its server.
    pub fn channel(&self, id: CanId) -> Option<CanId> {
        self.channels.get(&id).copied()
    }

    /// Roles from what is known of a bus.
    pub fn compile(network: &Network, bus: &[u8], nodes: &PerNode<Node>) -> Self {
        let mut roles = Self::default();
        let mut claims = BTreeMap::new();
        for (_, node) in nodes.iter() {
            roles.moved(node);
        }
        for (_, node) in nodes.iter() {
            roles.services(node, &mut claims);
            roles.process_data(node, &mut claims);
            roles.servers(node, &mut claims);
            roles.safety(node, &mut claims);
            roles.clients(node, &mut claims);
        }
        for Sdo { bus: of, client, server, node } in &network.sdos {
            if Network::holds(of.as_ref(), bus) {
                roles.further_channel(*client, *server, *node, Provenance::Option, &mut claims);
            }
        }
        for (_, node) in nodes.iter() {
            roles.disabled(node, &claims);
        }
        let asked = || nodes.iter().map(|(_, node)| node).filter(|node| node.configuration.is_requested());
        for transmit in [true, false] {
            asked().for_each(|node| roles.ask_process_data(node, transmit, &claims));
        }
        asked().for_each(|node| roles.ask_services(node, &claims));
        roles
    }

    /// PDOs on identifiers that only unanswered writes give them: what is known otherwise comes first, but for the
    /// pre-defined places of other PDOs.
    fn ask_process_data(&mut self, node: &Node, transmit: bool, claims: &Claims) {
        for pdo in node.unconfirmed_pdos().iter().filter(|pdo| pdo.transmit == transmit) {
            let Some((cob, from)) = pdo.cob.filter(|(cob, _)| cob.valid) else { continue };
            let (number, node) = (pdo.number, node.id());
            let (id, asked) =
                (cob.id, if transmit { Role::Tpdo { number, node } } else { Role::Rpdo { number, node } });
            match self.of(id) {
                before if before == asked || claims.contains_key(&id) && transmit => {}
                Role::Tpdo { .. } if !transmit && self.consumer(id).is_some() => {}
                Role::Tpdo { .. } if !transmit => self.consume(id, node, number),
                _ if claims.contains_key(&id) => {}
                Role::Rpdo { number, node } if transmit => {
                    self.consume(id, node, number);
                    self.ask(id, asked, from);
                }
                Role::Tpdo { .. } | Role::Rpdo { .. } | Role::Unassigned | Role::Foreign => self.ask(id, asked, from),
                _ => {}
            }
        }
    }

    /// SYNC and EMCY likewise. What comes there may be theirs, and is no other node's EMCY for certain.
    fn ask_services(&mut self, node: &Node, claims: &Claims) {
        for (index, own) in [(0x1005, Role::Sync), (0x1014, Role::Emcy(node.id()))] {
            let Some(known) = node.configuration.requested(index, 0) else { continue };
            let cob = CobId::from_entry(if index == 0x1005 { known.value & !(3 << 30) } else { known.value });
            let before = self.of(cob.id);
            if cob.valid && before != own && matches!(before, Role::Emcy(_)) && !claims.contains_key(&cob.id) {
                self.ask(cob.id, Role::Unassigned, known.from);
            }
        }
    }

    fn ask(&mut self, id: CanId, role: Role, from: Provenance) {
        if is_fixed(id) || self.unconfirmed.contains_key(&id) || self.unconfirmed.len() >= EXTENDED {
            return;
        }
        self.set(id, role);
        self.unconfirmed.insert(id, from);
    }

    /// SYNC, TIME and EMCY, where they are configured elsewhere (1005h, 1012h, 1014h).
    fn services(&mut self, node: &Node, claims: &mut Claims) {
        if let Some((value, from)) = node.value(0x1005, 0) {
            self.claim(CobId::from_entry(value & !(3 << 30)).id, Role::Sync, from, claims);
        }
        if let Some((value, from)) = node.value(0x1012, 0) {
            self.claim(CobId::from_entry(value & !(3 << 30)).id, Role::Time, from, claims);
        }
        if let Some((value, from)) = node.value(0x1014, 0) {
            let cob = CobId::from_entry(value);
            if cob.valid {
                self.claim(cob.id, Role::Emcy(node.id()), from, claims);
            }
        }
    }

    /// PDOs that are elsewhere have left their pre-defined identifiers. An EDS only presets: what is sent there all
    /// the same is still best called by its pre-defined name.
    fn moved(&mut self, node: &Node) {
        let elsewhere = |pdo: &&Pdo| pdo.cob.1.is_told() && pdo.number <= PREDEFINED;
        for pdo in node.pdos().iter().filter(elsewhere) {
            self.leave(role(node, pdo));
        }
    }

    fn process_data(&mut self, node: &Node, claims: &mut Claims) {
        for pdo in node.pdos().iter().filter(|pdo| pdo.cob.0.valid) {
            let (cob, from) = pdo.cob;
            let role = role(node, pdo);
            match (self.of(cob.id), role) {
                (Role::Tpdo { .. }, Role::Rpdo { number, node }) => {
                    self.consume(cob.id, node, number);
                }
                (Role::Rpdo { number, node: other }, Role::Tpdo { .. }) if self.may(cob.id, role, from) => {
                    let before = claims.get(&cob.id).copied().unwrap_or(Provenance::Default);
                    self.consume(cob.id, other, number);
                    self.set(cob.id, role);
                    claims.insert(cob.id, before.max(from));
                }
                _ => self.claim(cob.id, role, from, claims),
            }
        }
    }

    fn consume(&mut self, id: CanId, node: u8, number: u16) {
        if self.consumers.len() < EXTENDED {
            self.consumers.insert(id, (node, number));
        }
    }

    /// A PDO that was made invalid keeps the identifier that stands in its COB-ID, unless that is anything else's: what
    /// comes there is best called by it.
    fn disabled(&mut self, node: &Node, claims: &Claims) {
        for pdo in node.pdos().iter().filter(|pdo| !pdo.cob.0.valid && pdo.cob.1.is_told()) {
            let id = pdo.cob.0.id;
            if matches!(self.of(id), Role::Unassigned | Role::Foreign) && !claims.contains_key(&id) {
                self.set(id, role(node, pdo));
            }
        }
    }

    /// SDO servers beyond the default channel (1201h to 127Fh).
    fn servers(&mut self, node: &Node, claims: &mut Claims) {
        for index in node.configuration.indices(0x1201..=0x127F) {
            let (Some((client, from)), Some((server, _))) = (node.value(index, 1), node.value(index, 2)) else {
                continue;
            };
            let (client, server) = (CobId::from_entry(client), CobId::from_entry(server));
            if client.valid && server.valid {
                self.further_channel(client.id, server.id, node.id(), from, claims);
            }
        }
    }

    /// SRDO pairs (1301h to 1340h) where both identifiers are known. They keep to 101h to 180h (CiA 304), and the
    /// normal one says the number, as in the default assignment.
    fn safety(&mut self, node: &Node, claims: &mut Claims) {
        let allowed = |id: &CanId| !id.is_extended() && (0x101..=0x180).contains(&id.raw());
        for index in node.configuration.indices(0x1301..=0x1340) {
            let id = |sub| node.value(index, sub).map(|(value, from)| (CobId::from_entry(value).id, from));
            let used = node.value(index, 1).is_some_and(|(direction, _)| direction != 0);
            let (true, Some((normal, from)), Some((inverted, _))) = (used, id(5), id(6)) else { continue };
            if normal != inverted && allowed(&normal) && allowed(&inverted) {
                let number = ((normal.raw() - 0xFF) / 2) as u8;
                self.claim(normal, Role::Srdo { number, inverted: false }, from, claims);
                self.claim(inverted, Role::Srdo { number, inverted: true }, from, claims);
            }
        }
    }

    /// SDO channels by what a client knows of them (1280h to 12FFh): sub-index 3 is the server's node-ID.
    fn clients(&mut self, node: &Node, claims: &mut Claims) {
        for index in node.configuration.indices(0x1280..=0x12FF) {
            let known = |sub| node.value(index, sub).filter(|(_, from)| from.is_told());
            let (Some((client, from)), Some((server, _)), Some((id @ 1..=127, _))) = (known(1), known(2), known(3))
            else {
                continue;
            };
            let (client, server) = (CobId::from_entry(client), CobId::from_entry(server));
            if client.valid && server.valid {
                self.further_channel(client.id, server.id, id as u8, from, claims);
            }
        }
    }

    fn further_channel(&mut self, client: CanId, server: CanId, node: u8, from: Provenance, claims: &mut Claims) {
        if self.of(client) == Role::SdoRequest(node) && self.of(server) == Role::SdoResponse(node) {
            return;
        }
        self.claim(client, Role::SdoRequest(node), from, claims);
        self.claim(server, Role::SdoResponse(node), from, claims);
        if self.channels.len() < EXTENDED {
            self.channels.insert(client, client);
            self.channels.insert(server, client);
        }
    }

    /// Gives an identifier to a role, unless a more trusted source has given it away.
    fn claim(&mut self, id: CanId, role: Role, from: Provenance, claims: &mut Claims) {
        if is_fixed(id) || !self.may(id, role, from) || claims.get(&id).is_some_and(|before| *before >= from) {
            return;
        }
        self.set(id, role);
        claims.insert(id, from);
    }

    /// Whether a role may have an identifier. An EDS may lack `$NODEID`, and serve several nodes: what it presets does
    /// not take another node's place of the same kind, nor that of another service.
    fn may(&self, id: CanId, role: Role, from: Provenance) -> bool {
        let place = predefined(id);
        if from.is_told() || place == role {
            return true;
        }
        match (place, role) {
            (Role::Unassigned | Role::Foreign, _) => true,
            (Role::Tpdo { number: one, .. }, Role::Tpdo { number: other, .. })
            | (Role::Rpdo { number: one, .. }, Role::Rpdo { number: other, .. }) => one != other,
            (Role::Tpdo { .. } | Role::Rpdo { .. }, Role::Tpdo { .. } | Role::Rpdo { .. }) => true,
            _ => false,
        }
    }

    fn set(&mut self, id: CanId, role: Role) {
        if !id.is_extended() {
            if let Some(slot) = self.standard.get_mut(id.raw() as usize) {
                *slot = role;
            }
        } else if self.extended.len() < EXTENDED || self.extended.contains_key(&id.raw()) {
            self.extended.insert(id.raw(), role);
        }
    }

    fn leave(&mut self, role: Role) {
        let id = match role {
            Role::Tpdo { number, node } => 0x080 + 0x100 * number + u16::from(node),
            Role::Rpdo { number, node } => 0x100 + 0x100 * number + u16::from(node),
            _ => return,
        };
        if let Some(slot) = self.standard.get_mut(usize::from(id))
            && *slot == role
        {
            *slot = Role::Unassigned;
        }
    }
}

/// Whether no configuration moves an identifier.
fn is_fixed(id: CanId) -> bool {
    !id.is_extended() && (id.raw() == FIXED[0] || id.raw() >= FIXED[1])
}

fn role(node: &Node, pdo: &Pdo) -> Role {
    let (number, node) = (pdo.number, node.id());
    if pdo.transmit { Role::Tpdo { number, node } } else { Role::Rpdo { number, node } }
}

type Claims = BTreeMap<CanId, Provenance>;
