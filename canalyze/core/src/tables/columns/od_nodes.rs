//! Nodes and their PDOs as JSON lines, as far as the traffic shows them.
//!
//! A node comes before its objects, which are in order; PDOs come behind the nodes. The identity of a node (1000h,
//! 1008h, 1018h) is null as far as the capture does not show it. Must not: decide anything.

use super::od;
use crate::bytes::frame::{BusId, CanId};
use crate::tables::setting::Setting;
use crate::tables::table::{Cx, Hex8, Identifier, Name, Truth, U8, U64, Word, table};
use crate::views::inventory::{Inventory, NodeObjects, ObservedObject, PdoFrames};
use crate::words::Lang;

/// A node, and its booting.
#[derive(Clone, Copy)]
pub(in crate::tables) struct SeenNode<'a> {
    bus: BusId,
    id: u8,
    node: &'a NodeObjects,
    booted: bool,
}

table! {
    /// One line per node.
    /// 一行是一个节点
    Nodes json "od_node", |cx, one: SeenNode<'_>| {
        bus: Name or null = cx.setting.bus(one.bus);
        node: U8 = one.id;
        /// number of objects
        /// 对象的个数
        objects: U64 = one.node.objects.len() as u64;
        /// number of values
        /// 值的个数
        values: U64 = one.node.objects.values().map(ObservedObject::values).sum::<u64>();
        /// how often something was seen of objects for which there is no room
        /// 因数量过多而未列出的对象出现的次数
        further: U64 = one.node.further;
        /// the capture shows a boot-up of it, and no frames were lost since
        /// 记录中有它的启动报文，且此后没有丢帧
        booted: Truth = one.booted;
        /// device type (1000h)
        /// 设备类型（1000h）
        device_type: Hex8 or null = one.node.number(0x1000, 0);
        /// vendor-ID (1018h:01)
        /// 制造商ID（1018h:01）
        vendor_id: Hex8 or null = one.node.number(0x1018, 1);
        /// product code (1018h:02)
        /// 产品码（1018h:02）
        product_code: Hex8 or null = one.node.number(0x1018, 2);
        /// revision number (1018h:03)
        /// 修订号（1018h:03）
        revision: Hex8 or null = one.node.number(0x1018, 3);
        /// serial number (1018h:04)
        /// 序列号（1018h:04）
        serial: Hex8 or null = one.node.number(0x1018, 4);
        /// number of the device profile
        /// 设备规范的编号
        profile: U64 or null = profile(one.node);
        /// device name (1008h)
        /// 设备名称（1008h）
        device_name: Name or null = one.node.text(0x1008, 0).unwrap_or("");
    }
}

table! {
    /// One line per identifier that carries a PDO.
    /// 一行是一个传送PDO的标识符
    Pdos json "od_pdo", |cx, one: (BusId, CanId, &PdoFrames)| {
        bus: Name or null = cx.setting.bus(one.0);
        node: U8 = one.2.node;
        pdo: Word = &*format!("{}{}", if one.2.transmit { "TPDO" } else { "RPDO" }, one.2.number);
        /// identifier
        /// 标识符
        id: Identifier = one.1;
        /// 29-bit identifier
        /// 29位ID
        ext: Truth = one.1.is_extended();
        /// number of frames
        /// 帧数
        frames: U64 = one.2.frames;
        /// least length in bytes
        /// 最短的长度，字节
        length_min: U8 = one.2.lengths.0;
        /// greatest length in bytes
        /// 最长的长度，字节
        length_max: U8 = one.2.lengths.1;
    }
}

/// Appends all nodes, each with its objects, and the PDOs. `names`: the language of names.
pub fn lines(out: &mut Vec<u8>, setting: Setting<'_>, all: &Inventory, names: Lang) {
    let cx = Cx { setting, names };
    for ((bus, id), node) in &all.nodes {
        Nodes::json(out, &cx, SeenNode { bus: *bus, id: *id, node, booted: all.has_booted(*bus, *id) });
        out.push(b'\n');
        od::lines(out, &cx, (*bus, *id), node);
    }
    for ((bus, id), pdo) in &all.pdos {
        Pdos::json(out, &cx, (*bus, *id, pdo));
        out.push(b'\n');
    }
}

fn profile(node: &NodeObjects) -> Option<u64> {
    node.number(0x1000, 0).map(|number| u64::from(number & 0xFFFF)).filter(|number| *number != 0)
}
