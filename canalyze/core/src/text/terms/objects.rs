//! Names of the standard objects: the communication profile area (CiA 301, 302, 304). Those of 6000h-9FFFh are the
//! device profile's. The caller has to let a name from an EDS win.

use crate::profiles::Profile;
use crate::text::Lang;

/// A range of objects with one name: first and last index, zh, en. Sorted, without overlap.
type Object = (u16, u16, &'static str, &'static str);
/// A sub-index with a name of its own: first and last index, sub-index, zh, en. Sorted.
type Sub = (u16, u16, u8, &'static str, &'static str);

/// The name of an object or of one of its sub-indices. Where the sub-index has no name of its own, the object's.
pub fn object_name(lang: Lang, profile: Profile, index: u16, sub: u8) -> Option<&'static str> {
    if index >= 0x6000 {
        return profile.name(index, sub).map(|(zh, en)| lang.pick(zh, en));
    }
    let subs = SUBS.iter().filter(|row| (row.0..=row.1).contains(&index) && row.2 == sub);
    let (zh, en) = match subs.map(|row| (row.3, row.4)).next() {
        Some(words) => words,
        None => {
            let after = OBJECTS.partition_point(|row| row.0 <= index);
            let row = OBJECTS.get(after.checked_sub(1)?)?;
            if index > row.1 {
                return None;
            }
            (row.2, row.3)
        }
    };
    Some(lang.pick(zh, en))
}

static OBJECTS: &[Object] = &[
    (0x1000, 0x1000, "设备类型", "device type"),
    (0x1001, 0x1001, "错误寄存器", "error register"),
    (0x1002, 0x1002, "制造商状态寄存器", "manufacturer status register"),
    (0x1003, 0x1003, "预定义错误区", "pre-defined error field"),
    (0x1005, 0x1005, "同步报文COB-ID", "COB-ID SYNC message"),
    (0x1006, 0x1006, "同步周期", "communication cycle period"),
    (0x1007, 0x1007, "同步窗口长度", "synchronous window length"),
    (0x1008, 0x1008, "设备名称", "manufacturer device name"),
    (0x1009, 0x1009, "硬件版本", "manufacturer hardware version"),
    (0x100A, 0x100A, "软件版本", "manufacturer software version"),
    (0x100C, 0x100C, "保护时间", "guard time"),
    (0x100D, 0x100D, "寿命因子", "life time factor"),
    (0x1010, 0x1010, "存储参数", "store parameters"),
    (0x1011, 0x1011, "恢复默认参数", "restore default parameters"),
    (0x1012, 0x1012, "时间报文COB-ID", "COB-ID time stamp object"),
    (0x1013, 0x1013, "高分辨率时间戳", "high resolution time stamp"),
    (0x1014, 0x1014, "紧急报文COB-ID", "COB-ID EMCY"),
    (0x1015, 0x1015, "紧急报文抑制时间", "inhibit time EMCY"),
    (0x1016, 0x1016, "消费者心跳时间", "consumer heartbeat time"),
    (0x1017, 0x1017, "生产者心跳时间", "producer heartbeat time"),
    (0x1018, 0x1018, "标识对象", "identity object"),
    (0x1019, 0x1019, "同步计数器溢出值", "synchronous counter overflow value"),
    (0x1020, 0x1020, "验证配置", "verify configuration"),
    (0x1021, 0x1021, "存储EDS", "store EDS"),
    (0x1022, 0x1022, "EDS存储格式", "store format"),
    (0x1023, 0x1023, "OS命令", "OS command"),
    (0x1024, 0x1024, "OS命令模式", "OS command mode"),
    (0x1025, 0x1025, "OS调试接口", "OS debugger interface"),
    (0x1026, 0x1026, "OS提示符", "OS prompt"),
    (0x1027, 0x1027, "模块列表", "module list"),
    (0x1028, 0x1028, "紧急报文消费者", "emergency consumer object"),
    (0x1029, 0x1029, "错误行为", "error behavior object"),
    (0x102A, 0x102A, "NMT抑制时间", "NMT inhibit time"),
    (0x1200, 0x127F, "SDO服务器参数", "SDO server parameter"),
    (0x1280, 0x12FF, "SDO客户端参数", "SDO client parameter"),
    (0x1300, 0x1300, "全局故障安全命令参数", "global fail-safe command parameter"),
    (0x1301, 0x1340, "SRDO通信参数", "SRDO communication parameter"),
    (0x1381, 0x13C0, "SRDO映射参数", "SRDO mapping parameter"),
    (0x13FE, 0x13FE, "安全配置有效", "configuration valid"),
    (0x13FF, 0x13FF, "安全配置校验和", "safety configuration signature"),
    (0x1400, 0x15FF, "RPDO通信参数", "RPDO communication parameter"),
    (0x1600, 0x17FF, "RPDO映射参数", "RPDO mapping parameter"),
    (0x1800, 0x19FF, "TPDO通信参数", "TPDO communication parameter"),
    (0x1A00, 0x1BFF, "TPDO映射参数", "TPDO mapping parameter"),
    (0x1F20, 0x1F20, "存储DCF", "store DCF"),
    (0x1F21, 0x1F21, "DCF存储格式", "storage format of DCF"),
    (0x1F22, 0x1F22, "简明DCF", "concise DCF"),
    (0x1F23, 0x1F23, "存储从站EDS", "store EDS of slaves"),
    (0x1F24, 0x1F24, "从站EDS存储格式", "storage format of EDS of slaves"),
    (0x1F25, 0x1F25, "配置请求", "configuration request"),
    (0x1F26, 0x1F26, "期望的配置日期", "expected configuration date"),
    (0x1F27, 0x1F27, "期望的配置时间", "expected configuration time"),
    (0x1F50, 0x1F50, "程序数据", "program data"),
    (0x1F51, 0x1F51, "程序控制", "program control"),
    (0x1F52, 0x1F52, "验证应用软件", "verify application software"),
    (0x1F53, 0x1F53, "期望的应用软件日期", "expected application software date"),
    (0x1F54, 0x1F54, "期望的应用软件时间", "expected application software time"),
    (0x1F55, 0x1F55, "期望的软件标识", "expected software identification"),
    (0x1F56, 0x1F56, "程序软件标识", "program software identification"),
    (0x1F57, 0x1F57, "闪存状态标识", "flash status identification"),
    (0x1F80, 0x1F80, "NMT启动", "NMT startup"),
    (0x1F81, 0x1F81, "NMT从站分配", "NMT slave assignment"),
    (0x1F82, 0x1F82, "请求NMT", "request NMT"),
    (0x1F83, 0x1F83, "请求节点保护", "request node guarding"),
    (0x1F84, 0x1F84, "期望的设备类型", "device type identification"),
    (0x1F85, 0x1F85, "期望的制造商ID", "vendor identification"),
    (0x1F86, 0x1F86, "期望的产品码", "product code"),
    (0x1F87, 0x1F87, "期望的修订号", "revision number"),
    (0x1F88, 0x1F88, "期望的序列号", "serial number"),
    (0x1F89, 0x1F89, "启动时间", "boot time"),
    (0x1F90, 0x1F90, "NMT飞行主站定时参数", "NMT flying master timing parameters"),
    (0x1F91, 0x1F91, "自启动节点定时参数", "self starting nodes timing parameters"),
    (0x1FA0, 0x1FCF, "对象扫描列表", "object scanner list"),
    (0x1FD0, 0x1FFF, "对象分派列表", "object dispatching list"),
];

static SUBS: &[Sub] = &[
    (0x1003, 0x1003, 0, "错误个数", "number of errors"),
    (0x1010, 0x1010, 1, "存储所有参数", "save all parameters"),
    (0x1010, 0x1010, 2, "存储通信参数", "save communication parameters"),
    (0x1010, 0x1010, 3, "存储应用参数", "save application parameters"),
    (0x1011, 0x1011, 1, "恢复所有默认参数", "restore all default parameters"),
    (0x1011, 0x1011, 2, "恢复默认通信参数", "restore communication default parameters"),
    (0x1011, 0x1011, 3, "恢复默认应用参数", "restore application default parameters"),
    (0x1018, 0x1018, 1, "制造商ID", "vendor-ID"),
    (0x1018, 0x1018, 2, "产品码", "product code"),
    (0x1018, 0x1018, 3, "修订号", "revision number"),
    (0x1018, 0x1018, 4, "序列号", "serial number"),
    (0x1020, 0x1020, 1, "配置日期", "configuration date"),
    (0x1020, 0x1020, 2, "配置时间", "configuration time"),
    (0x1029, 0x1029, 1, "通信错误行为", "communication error behavior"),
    (0x1200, 0x12FF, 1, "客户端->服务器COB-ID", "COB-ID client -> server"),
    (0x1200, 0x12FF, 2, "服务器->客户端COB-ID", "COB-ID server -> client"),
    (0x1200, 0x127F, 3, "SDO客户端节点ID", "node-ID of the SDO client"),
    (0x1280, 0x12FF, 3, "SDO服务器节点ID", "node-ID of the SDO server"),
    (0x1301, 0x1340, 1, "SRDO信息方向", "SRDO information direction"),
    (0x1301, 0x1340, 2, "安全周期时间", "safeguard cycle time"),
    (0x1301, 0x1340, 3, "安全相关验证时间", "safety-relevant validation time"),
    (0x1301, 0x1340, 4, "SRDO传输类型", "SRDO transmission type"),
    (0x1301, 0x1340, 5, "SRDO正常数据COB-ID", "SRDO COB-ID, normal data"),
    (0x1301, 0x1340, 6, "SRDO取反数据COB-ID", "SRDO COB-ID, inverted data"),
    (0x1381, 0x13C0, 0, "SRDO映射对象个数", "number of objects mapped in the SRDO"),
    (0x1400, 0x15FF, 1, "RPDO的COB-ID", "COB-ID used by RPDO"),
    (0x1400, 0x15FF, 2, "RPDO传输类型", "RPDO transmission type"),
    (0x1400, 0x15FF, 3, "RPDO抑制时间", "RPDO inhibit time"),
    (0x1400, 0x15FF, 5, "RPDO事件定时器", "RPDO event timer"),
    (0x1400, 0x15FF, 6, "RPDO同步起始值", "RPDO SYNC start value"),
    (0x1600, 0x17FF, 0, "RPDO映射对象个数", "number of objects mapped in the RPDO"),
    (0x1800, 0x19FF, 1, "TPDO的COB-ID", "COB-ID used by TPDO"),
    (0x1800, 0x19FF, 2, "TPDO传输类型", "TPDO transmission type"),
    (0x1800, 0x19FF, 3, "TPDO抑制时间", "TPDO inhibit time"),
    (0x1800, 0x19FF, 5, "TPDO事件定时器", "TPDO event timer"),
    (0x1800, 0x19FF, 6, "TPDO同步起始值", "TPDO SYNC start value"),
    (0x1A00, 0x1BFF, 0, "TPDO映射对象个数", "number of objects mapped in the TPDO"),
    (0x1F90, 0x1F90, 3, "NMT主站优先级", "NMT master priority"),
    (0x1F90, 0x1F90, 4, "优先级时隙", "priority time slot"),
    (0x1F90, 0x1F90, 5, "设备时隙", "device time slot"),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, clippy::panic)]
    use super::*;
    use crate::text::lang::tests::sound;

    #[test]
    fn tables_are_sound() {
        for pair in OBJECTS.windows(2) {
            assert!(pair[0].1 < pair[1].0, "{:04X}", pair[1].0);
        }
        for (first, last, ..) in OBJECTS {
            assert!(first <= last, "{first:04X}");
        }
        sound(&OBJECTS.iter().map(|row| (row.0, row.2, row.3)).collect::<Vec<_>>());
        sound(&SUBS.iter().map(|row| ((row.0, row.2, row.1), row.3, row.4)).collect::<Vec<_>>());
        for (first, last, sub, ..) in SUBS {
            assert!(OBJECTS.iter().any(|object| object.0 <= *first), "{first:04X}");
            for index in [first, last] {
                // A sub-index that has a name has a type, and no other row names it.
                assert!(crate::od::communication(*index, *sub).is_some(), "{index:04X}:{sub}");
                let rows = SUBS.iter().filter(|row| (row.0..=row.1).contains(index) && row.2 == *sub);
                assert_eq!(rows.count(), 1, "{index:04X}:{sub}");
            }
        }
    }

    #[test]
    fn names() {
        assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, 0x1008, 0), Some("设备名称"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1008, 0), Some("manufacturer device name"));
        assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, 0x1018, 1), Some("制造商ID"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1018, 0), Some("identity object"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1805, 1), Some("COB-ID used by TPDO"));
        assert_eq!(object_name(Lang::En, Profile::UNKNOWN, 0x1A05, 3), Some("TPDO mapping parameter"));
        assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, 0x6841, 0), Some("状态字"));
        for unknown in [0x0000, 0x0FFF, 0x1004, 0x1341, 0x1C00, 0x2000, 0x6000, 0xA040, 0xFFFF] {
            assert_eq!(object_name(Lang::Zh, Profile::UNKNOWN, unknown, 0), None, "{unknown:04X}");
        }
    }

    #[test]
    fn every_standard_type_has_a_name() {
        for index in 0x1000..=0x1FFF {
            for sub in 0..=8 {
                if crate::od::communication(index, sub).is_some() {
                    assert!(object_name(Lang::Zh, Profile::UNKNOWN, index, sub).is_some(), "{index:04X}:{sub}");
                }
            }
        }
    }
}
