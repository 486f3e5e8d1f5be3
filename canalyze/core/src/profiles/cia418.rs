//! CiA 418: battery modules.

use super::Object;
use super::Shape::{Array, Own, Record, Var};
use crate::od::DataType::{Integer16, Unsigned8, Unsigned16, Unsigned32};

pub(super) static OBJECTS: &[Object] = &[
    (0x6000, Var(Unsigned8), "电池状态", "battery status"),
    (0x6001, Var(Unsigned8), "充电器状态", "charger status"),
    (0x6010, Var(Integer16), "温度", "temperature"),
    (
        0x6020,
        Record(&[
            (1, Unsigned8, "电池类型", "battery type"),
            (2, Unsigned16, "安时容量", "Ah capacity"),
            (3, Unsigned16, "最大充电电流", "maximum charge current"),
            (4, Unsigned16, "电池单体数", "number of cells"),
        ]),
        "电池参数",
        "battery parameters",
    ),
    (0x6030, Array(Unsigned32), "电池序列号", "battery serial number"),
    (0x6031, Array(Unsigned32), "电池ID", "battery ID"),
    (0x6040, Array(Unsigned32), "车辆序列号", "vehicle serial number"),
    (0x6041, Array(Unsigned32), "车辆ID", "vehicle ID"),
    (0x6050, Var(Unsigned32), "累计充电安时", "cumulative total Ah charge"),
    (0x6051, Var(Unsigned16), "上次充电后放出的安时", "Ah expended since last charge"),
    (0x6052, Var(Unsigned16), "上次充电充入的安时", "Ah returned during last charge"),
    (0x6053, Var(Unsigned16), "上次均衡后的安时", "Ah since last equalization"),
    (0x6054, Own, "上次均衡日期", "date of last equalization"),
    (0x6060, Var(Unsigned32), "电池电压", "battery voltage"),
    (0x6070, Var(Unsigned16), "请求的充电电流", "charge current requested"),
    (0x6080, Var(Unsigned8), "充电器给出的荷电状态", "charger state of charge"),
    (0x6081, Var(Unsigned8), "电池荷电状态", "battery state of charge"),
    (0x6090, Var(Unsigned8), "水位状态", "water level status"),
];
