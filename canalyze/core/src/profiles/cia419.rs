//! CiA 419: battery chargers.

use super::Object;
use super::Shape::Var;
use crate::od::DataType::{Integer16, Unsigned8, Unsigned16, Unsigned32};

pub(super) static OBJECTS: &[Object] = &[
    (0x6000, Var(Unsigned8), "电池状态", "battery status"),
    (0x6001, Var(Unsigned8), "充电器状态", "charger status"),
    (0x6010, Var(Integer16), "温度", "temperature"),
    (0x6052, Var(Unsigned16), "上次充电充入的安时", "Ah returned during last charge"),
    (0x6060, Var(Unsigned32), "电池电压", "battery voltage"),
    (0x6070, Var(Unsigned16), "请求的充电电流", "charge current requested"),
    (0x6080, Var(Unsigned8), "充电器给出的荷电状态", "charger state of charge"),
    (0x6081, Var(Unsigned8), "电池荷电状态", "battery state of charge"),
];
