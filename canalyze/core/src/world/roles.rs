//! The role of each CAN-ID of a bus: the pre-defined connection set, overruled by the knowledge of the nodes.
//!
//! One array look-up for 11-bit identifiers, a map for 29-bit ones. Every object that holds a COB-ID has claims on
//! identifiers; a change of an object reassigns only the identifiers of its old and new claims. Frames are never
//! examined.

use std::collections::{BTreeMap, BTreeSet};

use crate::bytes::frame::CanId;
use crate::wire::cob_id::{Role, predefined};
use crate::wire::pdo::{communication_parameter, of_parameter, predefined_id};
use crate::world::configuration::Provenance;
use crate::world::network::{Network, Sdo};
use crate::world::node::{CobId, Node, Pdo, PerNode};

/// Maximum number of claims on a bus (invariant 6): enough for the PDOs of 127 nodes.
const CLAIMS: usize = 1 << 17;
/// Maximum number of claims that count on one identifier, far above what nodes share.
const SHARED: usize = 1024;
/// Identifiers that no configuration moves (CiA 301, 7.3.5): NMT, and all from 7E4h on.
const FIXED: [u32; 2] = [0x000, 0x7E4];

/// The roles of a bus.
#[derive(Debug)]
pub struct Roles {
    standard: Vec<Role>,
    extended: BTreeMap<u32, Role>,
    /// RPDOs on an identifier that is another node's TPDO: consumer and number.
    consumers: BTreeMap<CanId, (u8, u16)>,
    /// Further SDO channels by either of their identifiers.
    channels: BTreeMap<CanId, CanId>,
    /// Identifiers whose role comes only from unanswered writes, with its source.
    unconfirmed: BTreeMap<CanId, Provenance>,
    /// All claims by identifier and turn.
    claims: BTreeMap<(CanId, Turn), Claim>,
    /// The identifiers and turns of the claims of each node's object.
    objects: BTreeMap<(u8, u16), Vec<(CanId, Turn)>>,
}

/// The order of claims on an identifier; of two equal ones the first counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Turn {
    phase: ClaimPhase,
    node: u8,
    service: ClaimService,
    /// The object.
    index: u16,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ClaimPhase {
    Moved,
    Configured,
    Option,
    Disabled,
    AskedTransmit,
    AskedReceive,
    AskedService,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ClaimService {
    Common,
    ProcessData,
    Server,
    Safety,
    Client,
}

/// An object's claim on an identifier.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Claim {
    /// Leaves this pre-defined role.
    Leave(Role),
    /// Takes this role unless a better source has assigned it.
    Take(Role, Provenance),
    /// Takes a PDO's role, in which one node may send what others receive.
    ProcessData(Role, Provenance),
    /// Takes the role of a further SDO channel, which the identifier names.
    Channel(Role, Provenance, CanId),
    /// Gives an unused identifier the role of the invalid PDO whose COB-ID holds it.
    Disabled(Role),
    /// Takes a PDO's role by an unanswered write: other knowledge has priority, except pre-defined PDOs.
    AskProcessData(Role, Provenance),
    /// Takes SYNC or EMCY by an unanswered write; frames may belong to it, and are certainly no other node's EMCY.
    AskService(Role, Provenance),
}

/// An identifier during the evaluation of its claims.
#[derive(Debug)]
struct Identifier {
    id: CanId,
    role: Role,
    claimed: Option<Provenance>,
    consumer: Option<(u8, u16)>,
    channel: Option<CanId>,
    unconfirmed: Option<Provenance>,
}

type Claims = Vec<(CanId, Turn, Claim)>;

impl Default for Roles {
    fn default() -> Self {
        Self {
            standard: (0..0x800).map(|id| predefined(CanId::standard(id))).collect(),
            extended: BTreeMap::new(),
            consumers: BTreeMap::new(),
            channels: BTreeMap::new(),
            unconfirmed: BTreeMap::new(),
            claims: BTreeMap::new(),
            objects: BTreeMap::new(),
        }
    }
}

impl Roles {
    /// Returns the role of an identifier.
    pub fn of(&self, id: CanId) -> Role {
        let found = if id.is_extended() { self.extended.get(&id.raw()) } else { self.standard.get(id.raw() as usize) };
        found.copied().unwrap_or(Role::Foreign)
    }

    /// Returns the source of an identifier's role that comes only from unanswered writes.
    #[inline]
    pub fn unconfirmed(&self, id: CanId) -> Option<Provenance> {
        if self.unconfirmed.is_empty() { None } else { self.unconfirmed.get(&id).copied() }
    }

    /// Returns consumer and number of the RPDO that receives an identifier whose role is a TPDO.
    pub fn consumer(&self, id: CanId) -> Option<(u8, u16)> {
        self.consumers.get(&id).copied()
    }

    /// Returns the identifier (client to server) that names an SDO identifier's channel unless it is the default one.
    pub fn channel(&self, id: CanId) -> Option<CanId> {
        self.channels.get(&id).copied()
    }

    /// Compiles the roles of a bus.
    pub fn compile(network: &Network, bus: &[u8], nodes: &PerNode<Node>) -> Self {
        let mut roles = Self::default();
        let mut concerned = BTreeSet::new();
        for (place, Sdo { bus: of, client, server, node }) in network.sdos.iter().enumerate() {
            if Network::holds(of.as_ref(), bus) {
                let place = place.min(usize::from(u16::MAX)) as u16;
                let turn = Turn { phase: ClaimPhase::Option, node: 0, service: ClaimService::Common, index: place };
                let mut claims = Claims::new();
                further_channel(*client, *server, (*node, Provenance::Option), turn, &mut claims);
                // Node 0 has no objects, so its entries are free.
                roles.hold((0, place), claims, &mut concerned);
            }
        }
        for (id, node) in nodes.iter() {
            for index in indices(node) {
                roles.hold((id, index), claims(node, index), &mut concerned);
            }
        }
        concerned.into_iter().for_each(|id| roles.give_away(id));
        roles
    }

    /// Updates the claims of a changed object.
    pub fn refresh(&mut self, node: &Node, index: u16) {
        // Both parameters of a PDO are one object here.
        let index = of_parameter(index).map_or(index, |(transmit, number)| communication_parameter(transmit, number));
        let mut concerned = BTreeSet::new();
        self.hold((node.id(), index), claims(node, index), &mut concerned);
        concerned.into_iter().for_each(|id| self.give_away(id));
    }

    /// Updates the claims of all objects of a node; without it there are none.
    pub fn refresh_all(&mut self, id: u8, node: Option<&Node>) {
        let mut concerned = BTreeSet::new();
        let mut all: BTreeSet<u16> =
            self.objects.range((id, 0)..=(id, u16::MAX)).map(|((_, index), _)| *index).collect();
        all.extend(node.into_iter().flat_map(indices));
        for index in all {
            self.hold((id, index), node.map_or_else(Claims::new, |node| claims(node, index)), &mut concerned);
        }
        concerned.into_iter().for_each(|id| self.give_away(id));
    }

    /// Replaces the claims of an object; adds the affected identifiers to `concerned`.
    fn hold(&mut self, object: (u8, u16), claims: Claims, concerned: &mut BTreeSet<CanId>) {
        let before = self.objects.remove(&object).unwrap_or_default();
        let same = before.len() == claims.len()
            && before.iter().zip(&claims).all(|((id, turn), (new, when, claim))| {
                (id, turn) == (new, when) && self.claims.get(&(*id, *turn)) == Some(claim)
            });
        if same {
            if !before.is_empty() {
                self.objects.insert(object, before);
            }
            return;
        }
        for (id, turn) in before {
            self.claims.remove(&(id, turn));
            concerned.insert(id);
        }
        let mut held = Vec::with_capacity(claims.len());
        for (id, turn, claim) in claims {
            if self.claims.len() < CLAIMS {
                self.claims.insert((id, turn), claim);
                held.push((id, turn));
                concerned.insert(id);
            }
        }
        if !held.is_empty() {
            self.objects.insert(object, held);
        }
    }

    /// Assigns an identifier by its claims.
    fn give_away(&mut self, id: CanId) {
        let role = predefined(id);
        let mut one = Identifier { id, role, claimed: None, consumer: None, channel: None, unconfirmed: None };
        let claims = self.claims.range((id, Turn::FIRST)..).take_while(|((of, _), _)| *of == id);
        claims.take(SHARED).for_each(|(_, claim)| one.take(*claim));
        if !id.is_extended() {
            if let Some(slot) = self.standard.get_mut(id.raw() as usize) {
                *slot = one.role;
            }
        } else if one.role == role {
            self.extended.remove(&id.raw());
        } else {
            self.extended.insert(id.raw(), one.role);
        }
        set(&mut self.consumers, id, one.consumer);
        set(&mut self.channels, id, one.channel);
        set(&mut self.unconfirmed, id, one.unconfirmed);
    }
}

impl Turn {
    const FIRST: Self = Self { phase: ClaimPhase::Moved, node: 0, service: ClaimService::Common, index: 0 };
}

impl Identifier {
    fn take(&mut self, claim: Claim) {
        match claim {
            Claim::Leave(role) if self.role == role => self.role = Role::Unassigned,
            Claim::Leave(_) => {}
            Claim::Take(role, from) => self.claim(role, from),
            Claim::ProcessData(role, from) => self.process_data(role, from),
            Claim::Channel(role, from, channel) => {
                self.claim(role, from);
                self.channel = Some(channel);
            }
            Claim::Disabled(role) => {
                if matches!(self.role, Role::Unassigned | Role::Foreign) && self.claimed.is_none() {
                    self.role = role;
                }
            }
            Claim::AskProcessData(role, from) => self.ask_process_data(role, from),
            Claim::AskService(own, from) => {
                if self.role != own && matches!(self.role, Role::Emcy(_)) && self.claimed.is_none() {
                    self.ask(Role::Unassigned, from);
                }
            }
        }
    }

    /// Takes a role unless a better source has assigned the identifier.
    fn claim(&mut self, role: Role, from: Provenance) {
        if !is_fixed(self.id) && may(self.id, role, from) && self.claimed.is_none_or(|before| before < from) {
            self.role = role;
            self.claimed = Some(from);
        }
    }

    fn process_data(&mut self, role: Role, from: Provenance) {
        match (self.role, role) {
            (Role::Tpdo { .. }, Role::Rpdo { number, node }) => self.consumer = Some((node, number)),
            (Role::Rpdo { number, node: other }, Role::Tpdo { .. }) if may(self.id, role, from) => {
                self.consumer = Some((other, number));
                self.role = role;
                self.claimed = Some(self.claimed.unwrap_or(Provenance::Default).max(from));
            }
            _ => self.claim(role, from),
        }
    }

    fn ask_process_data(&mut self, asked: Role, from: Provenance) {
        let transmit = matches!(asked, Role::Tpdo { .. });
        match (self.role, asked) {
            (before, _) if before == asked || self.claimed.is_some() && transmit => {}
            (Role::Tpdo { .. }, Role::Rpdo { .. }) if self.consumer.is_some() => {}
            (Role::Tpdo { .. }, Role::Rpdo { number, node }) => self.consumer = Some((node, number)),
            _ if self.claimed.is_some() => {}
            (Role::Rpdo { number, node }, Role::Tpdo { .. }) => {
                self.consumer = Some((node, number));
                self.ask(asked, from);
            }
            (Role::Tpdo { .. } | Role::Rpdo { .. } | Role::Unassigned | Role::Foreign, _) => self.ask(asked, from),
            _ => {}
        }
    }

    fn ask(&mut self, role: Role, from: Provenance) {
        if !is_fixed(self.id) && self.unconfirmed.is_none() {
            self.role = role;
            self.unconfirmed = Some(from);
        }
    }
}

/// Returns the objects of a node that may have claims.
fn indices(node: &Node) -> BTreeSet<u16> {
    let mut all = BTreeSet::from([SYNC, TIME, EMCY]);
    all.extend(node.pdos().iter().map(Pdo::communication));
    all.extend(node.unconfirmed_pdos().iter().map(|pdo| communication_parameter(pdo.transmit, pdo.number)));
    all.extend(node.configuration.indices(0x1201..=0x12FF));
    all.extend(node.configuration.indices(0x1301..=0x1340));
    all
}

const SYNC: u16 = 0x1005;
const TIME: u16 = 0x1012;
const EMCY: u16 = 0x1014;

/// Returns the claims of a node's object.
fn claims(node: &Node, index: u16) -> Claims {
    let mut claims = Claims::new();
    let turn = |phase, service| Turn { phase, node: node.id(), service, index };
    match index {
        SYNC | TIME | EMCY => common(node, index, &turn, &mut claims),
        0x1400..=0x1BFF => {
            if let Some((transmit, number)) = of_parameter(index) {
                process_data(node, (transmit, number), &turn, &mut claims);
            }
        }
        0x1201..=0x127F => server(node, index, turn(ClaimPhase::Configured, ClaimService::Server), &mut claims),
        0x1280..=0x12FF => client(node, index, turn(ClaimPhase::Configured, ClaimService::Client), &mut claims),
        0x1301..=0x1340 => safety(node, index, turn(ClaimPhase::Configured, ClaimService::Safety), &mut claims),
        _ => {}
    }
    claims
}

/// Adds claims of SYNC, TIME and EMCY configured elsewhere (1005h, 1012h, 1014h).
fn common(node: &Node, index: u16, turn: &impl Fn(ClaimPhase, ClaimService) -> Turn, claims: &mut Claims) {
    let own = match index {
        SYNC => Role::Sync,
        TIME => Role::Time,
        _ => Role::Emcy(node.id()),
    };
    // The highest bit marks only EMCY as invalid; in the others the two highest bits have other meanings.
    let cob = |value: u64| CobId::from_entry(if index == EMCY { value } else { value & !(3 << 30) });
    if let Some((cob, from)) = node.value(index, 0).map(|(value, from)| (cob(value), from))
        && cob.valid
    {
        claims.push((cob.id, turn(ClaimPhase::Configured, ClaimService::Common), Claim::Take(own, from)));
    }
    let asked = node.configuration.requested(index, 0).filter(|_| index != TIME);
    if let Some((cob, from)) = asked.map(|known| (cob(known.value), known.from))
        && cob.valid
    {
        claims.push((cob.id, turn(ClaimPhase::AskedService, ClaimService::Common), Claim::AskService(own, from)));
    }
}

fn process_data(
    node: &Node,
    (transmit, number): (bool, u16),
    turn: &impl Fn(ClaimPhase, ClaimService) -> Turn,
    claims: &mut Claims,
) {
    let turn = |phase| turn(phase, ClaimService::ProcessData);
    let id = node.id();
    let role = if transmit { Role::Tpdo { number, node: id } } else { Role::Rpdo { number, node: id } };
    if let Some(pdo) = node.pdo(transmit, number) {
        let (cob, from) = pdo.cob;
        // A moved PDO has left its pre-defined identifier. An EDS only presets: frames there are still best named by
        // the pre-defined role.
        if let Some(base) = predefined_id(transmit, number).filter(|_| from.is_told()) {
            claims.push((CanId::standard(base + u16::from(id)), turn(ClaimPhase::Moved), Claim::Leave(role)));
        }
        if cob.valid {
            claims.push((cob.id, turn(ClaimPhase::Configured), Claim::ProcessData(role, from)));
        } else if from.is_told() {
            claims.push((cob.id, turn(ClaimPhase::Disabled), Claim::Disabled(role)));
        }
    }
    let asked = node.unconfirmed_pdo(transmit, number).and_then(|pdo| pdo.cob);
    if let Some((cob, from)) = asked.filter(|(cob, _)| cob.valid) {
        let phase = if transmit { ClaimPhase::AskedTransmit } else { ClaimPhase::AskedReceive };
        claims.push((cob.id, turn(phase), Claim::AskProcessData(role, from)));
    }
}

/// Adds claims of an SDO server beyond the default channel (1201h to 127Fh).
fn server(node: &Node, index: u16, turn: Turn, claims: &mut Claims) {
    if let (Some((client, from)), Some((server, _))) = (node.value(index, 1), node.value(index, 2)) {
        let (client, server) = (CobId::from_entry(client), CobId::from_entry(server));
        if client.valid && server.valid {
            further_channel(client.id, server.id, (node.id(), from), turn, claims);
        }
    }
}

/// Adds claims of a known pair of SRDO identifiers (1301h to 1340h). They are within 101h to 180h (CiA 304), and the
/// normal one determines the number, as by default.
fn safety(node: &Node, index: u16, turn: Turn, claims: &mut Claims) {
    let allowed = |id: &CanId| !id.is_extended() && (0x101..=0x180).contains(&id.raw());
    let id = |sub| node.value(index, sub).map(|(value, from)| (CobId::from_entry(value).id, from));
    let used = node.value(index, 1).is_some_and(|(direction, _)| direction != 0);
    let (true, Some((normal, from)), Some((inverted, _))) = (used, id(5), id(6)) else { return };
    if normal != inverted && allowed(&normal) && allowed(&inverted) {
        let number = ((normal.raw() - 0xFF) / 2) as u8;
        claims.push((normal, turn, Claim::Take(Role::Srdo { number, inverted: false }, from)));
        claims.push((inverted, turn, Claim::Take(Role::Srdo { number, inverted: true }, from)));
    }
}

/// Adds claims of an SDO channel by its client (1280h to 12FFh); sub-index 3 is the server's node-ID.
fn client(node: &Node, index: u16, turn: Turn, claims: &mut Claims) {
    let known = |sub| node.value(index, sub).filter(|(_, from)| from.is_told());
    let (Some((client, from)), Some((server, _)), Some((id @ 1..=127, _))) = (known(1), known(2), known(3)) else {
        return;
    };
    let (client, server) = (CobId::from_entry(client), CobId::from_entry(server));
    if client.valid && server.valid {
        further_channel(client.id, server.id, (id as u8, from), turn, claims);
    }
}

/// Adds claims of an SDO channel of a node; the default one keeps its name.
fn further_channel(client: CanId, server: CanId, (node, from): (u8, Provenance), turn: Turn, claims: &mut Claims) {
    let (request, response) = (Role::SdoRequest(node), Role::SdoResponse(node));
    let default = predefined(client) == request && predefined(server) == response;
    let claim = |role| if default { Claim::Take(role, from) } else { Claim::Channel(role, from, client) };
    claims.push((client, turn, claim(request)));
    if server != client {
        claims.push((server, turn, claim(response)));
    }
}

/// Returns true if a role may take an identifier. An EDS may lack `$NODEID` and serve several nodes: its presets take
/// neither another node's place of the same kind nor that of another service.
fn may(id: CanId, role: Role, from: Provenance) -> bool {
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

/// Returns true if no configuration moves an identifier.
fn is_fixed(id: CanId) -> bool {
    !id.is_extended() && (id.raw() == FIXED[0] || id.raw() >= FIXED[1])
}

fn set<T>(of: &mut BTreeMap<CanId, T>, id: CanId, value: Option<T>) {
    match value {
        Some(value) => _ = of.insert(id, value),
        None => _ = of.remove(&id),
    }
}

#[cfg(test)]
mod tests;
