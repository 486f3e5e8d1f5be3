//! Rules on what a device's description says and the device does otherwise, in Chinese.
//!
//! It must carry the same facts as `en::findings::description`.

use crate::text::RuleText;

pub(super) const EDS001: RuleText = RuleText {
    message: "读到的值与EDS的默认值不同",
    meaning: "在记录中还没有写过该参数, 读到的值就与EDS的默认值不同, 或者PDO从一开始就与EDS的默认映射长度不同。",
    cause: "设备在记录开始之前已被配置或存储过参数, EDS与固件版本不符, 或者EDS不是这台设备的。",
    faces: &[
        "读到{found}, EDS的默认值为{described}",
        "PDO为{found}字节, EDS的默认映射为{mapped}字节: 设备在记录开始前已被配置, 或者EDS不是这台设备的",
    ],
};

pub(super) const EDS002: RuleText = RuleText {
    message: "读到的值与DCF不同",
    meaning: "在记录中还没有写过该参数, 读到的值就与DCF配置的值不同。",
    cause: "设备没有按这份DCF配置, 或者配置在复位后丢失。",
    faces: &["读到{found}, DCF配置为{described}"],
};

pub(super) const EDS003: RuleText = RuleText {
    message: "设备描述中没有该对象",
    meaning: "访问成功了, 但设备描述中没有这个索引或子索引。",
    cause: "EDS与固件版本不符, 或者厂商没有把该对象写进EDS。",
    faces: &["访问成功, 但设备描述中没有该索引", "访问成功, 但设备描述中该索引没有这个子索引"],
};

pub(super) const EDS004: RuleText = RuleText {
    message: "设备标识与设备描述不符",
    meaning: "设备类型(1000h)、制造商ID或产品码(1018h)与设备描述中的不同: 这份描述很可能不是这台设备的。",
    cause: "给节点指定了错误的EDS, 节点ID弄混, 或者更换了设备。",
    faces: &["读到{found}, 设备描述中为{described}: EDS很可能不是这台设备的"],
};

pub(super) const SDO013: RuleText = RuleText {
    message: "数据长度与对象的数据类型不符",
    meaning: "双方完成了传输, 但数值的字节数不是该数据类型的长度。数据类型以设备描述为准, 没有时以CiA 301规定的通信对象为准, 此时若该节点的短数值一律用4字节传输, 不算不符。",
    cause: "EDS中的数据类型有误, 固件版本不符, 客户端用错了长度而服务器不检查, 或者服务器一律应答4字节。",
    faces: &["写入{found}字节, {type}应为{length}字节", "读到{found}字节, {type}应为{length}字节"],
};

pub(super) const SDO014: RuleText = RuleText {
    message: "与设备描述的访问权限不符的访问成功了",
    meaning: "设备描述不允许这样的访问, 服务器却完成了它。",
    cause: "EDS中的AccessType有误, 固件版本不符, 或者服务器不检查访问权限。",
    faces: &["写入成功, 而设备描述中该对象只读", "读取成功, 而设备描述中该对象只写"],
};
