//! Updates object by object give the same roles as compiling anew.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
use proptest::prelude::*;

use super::*;
use crate::sdo::transfer::Direction;
use crate::sdo::wire::Mux;

/// A change of a node's configuration.
#[derive(Clone, Debug)]
enum Change {
    Learn(bool, Mux, u32),
    Attempt(Mux),
    Ask(Mux, u32),
    Refuse(Mux),
    Save,
    Load,
    Reset,
    Doubt,
    Move,
}

const NODES: [u8; 3] = [1, 2, 5];

fn values() -> impl Strategy<Value = u32> {
    let ids =
        prop::sample::select(vec![0x080_u32, 0x101, 0x103, 0x104, 0x181, 0x182, 0x201, 0x281, 0x601, 0x581, 0x640]);
    let bits = prop::sample::select(vec![0, 0, 0, 1 << 29, 1 << 31, 1 << 30]);
    prop_oneof![4 => (ids, bits).prop_map(|(id, bits)| id | bits), 1 => 0..3_u32, 1 => Just(0x6040_0010)]
}

fn muxes() -> impl Strategy<Value = Mux> {
    let common = prop::sample::select(vec![(0x1000, 0), (0x1005, 0), (0x1012, 0), (0x1014, 0), (0x1016, 1)]);
    let pdo = (prop::sample::select(vec![0x1400, 0x1600, 0x1800, 0x1A00]), 0..6_u16, 0..3_u8);
    let pdo = pdo.prop_map(|(base, number, sub)| (base + number, sub));
    let further = (prop::sample::select(vec![0x1200, 0x1201, 0x1202, 0x1280, 0x1281]), 1..4_u8);
    let safety = (0x1301..0x1304_u16, prop::sample::select(vec![1, 5, 6]));
    let all = prop_oneof![1 => common, 5 => pdo, 1 => further, 1 => safety];
    all.prop_map(|(index, sub)| Mux { index, sub })
}

fn changes() -> impl Strategy<Value = Change> {
    prop_oneof![
        8 => (any::<bool>(), muxes(), values()).prop_map(|(write, mux, value)| Change::Learn(write, mux, value)),
        2 => muxes().prop_map(Change::Attempt),
        3 => (muxes(), values()).prop_map(|(mux, value)| Change::Ask(mux, value)),
        1 => muxes().prop_map(Change::Refuse),
        1 => prop::sample::select(vec![Change::Save, Change::Load, Change::Reset, Change::Doubt, Change::Move]),
    ]
}

fn happen(change: &Change, node: &mut Node, frame: u64) {
    let configuration = &mut node.configuration;
    let parameters = |index| Mux { index, sub: 1 };
    match *change {
        Change::Learn(write, mux, value) => {
            let direction = if write { Direction::Download } else { Direction::Upload };
            configuration.learn(direction, mux, &value.to_le_bytes(), frame);
        }
        Change::Attempt(mux) => _ = configuration.attempted(mux, frame),
        Change::Ask(mux, value) => {
            configuration.request(mux, &value.to_le_bytes(), frame);
            configuration.unanswered(mux);
        }
        Change::Refuse(mux) => _ = configuration.refused(mux, 0),
        Change::Save => {
            configuration.learn(Direction::Download, parameters(0x1010), b"save", frame);
        }
        Change::Load => {
            configuration.learn(Direction::Download, parameters(0x1011), b"load", frame);
        }
        Change::Reset => _ = configuration.reset(),
        Change::Doubt => _ = configuration.doubt(frame),
        Change::Move => {}
    }
}

proptest! {
    #[test]
    fn object_by_object_is_as_all_at_once(changes in prop::collection::vec((0..NODES.len(), changes()), 1..60)) {
        let (network, mut nodes) = (Network::default(), PerNode::<Node>::default());
        NODES.iter().for_each(|id| nodes.put(*id, Box::new(Node::new(*id))));
        let mut roles = Roles::compile(&network, b"", &nodes);
        for (frame, (place, change)) in (1..).zip(&changes) {
            let id = NODES[*place];
            if matches!(change, Change::Move) {
                let (from, to) = if nodes.get(id).is_some() { (id, id + 0x10) } else { (id + 0x10, id) };
                let mut node = nodes.take(from).unwrap();
                roles.refresh_all(from, None);
                node.configuration.leave(from);
                node.rename(to);
                roles.refresh_all(to, Some(&node));
                nodes.put(to, node);
            }
            let id = if nodes.get(id).is_some() { id } else { id + 0x10 };
            happen(change, nodes.get_mut(id).unwrap(), frame);
            nodes.get_mut(id).unwrap().compile();
            for (_, node) in nodes.iter_mut() {
                for index in node.configuration.unassigned() {
                    roles.refresh(node, index);
                }
            }
            let compiled = format!("{:?}", nodes.get(id).unwrap().pdos());
            let asked = format!("{:?}", nodes.get(id).unwrap().unconfirmed_pdos());
            let anew = Roles::compile(&network, b"", &nodes);
            prop_assert_eq!(&roles.standard, &anew.standard);
            prop_assert_eq!(&roles.extended, &anew.extended);
            prop_assert_eq!(&roles.consumers, &anew.consumers);
            prop_assert_eq!(&roles.channels, &anew.channels);
            prop_assert_eq!(&roles.unconfirmed, &anew.unconfirmed);
            nodes.get_mut(id).unwrap().compile_all();
            prop_assert_eq!(compiled, format!("{:?}", nodes.get(id).unwrap().pdos()));
            prop_assert_eq!(asked, format!("{:?}", nodes.get(id).unwrap().unconfirmed_pdos()));
        }
    }
}

#[test]
fn what_too_many_claim_costs_no_more() {
    let (network, mut nodes) = (Network::default(), PerNode::<Node>::default());
    for id in 1..=4 {
        let mut node = Box::new(Node::new(id));
        for index in 0x1400..0x1600 {
            let value = 0x300_u32.to_le_bytes();
            node.configuration.learn(Direction::Download, Mux { index, sub: 1 }, &value, 1);
        }
        node.compile();
        nodes.put(id, node);
    }
    let roles = Roles::compile(&network, b"", &nodes);
    assert_eq!(roles.claims.keys().filter(|(id, _)| *id == CanId::standard(0x300)).count(), 4 * 512);
    assert_eq!(roles.of(CanId::standard(0x300)), Role::Rpdo { number: 1, node: 1 });
}
