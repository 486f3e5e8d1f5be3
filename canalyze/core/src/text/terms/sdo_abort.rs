//! SDO abort codes (CiA 301, table 22).

use super::{Row, find};
use crate::text::Lang;

/// All codes that CiA 301 defines. Device profiles and vendors have others.
pub static CODES: &[Row<u32>] = &[
    (0x0503_0000, "toggle位未交替", "toggle bit not alternated"),
    (0x0504_0000, "SDO协议超时", "SDO protocol timed out"),
    (0x0504_0001, "命令字无效或未知", "client/server command specifier not valid or unknown"),
    (0x0504_0002, "无效的块大小(仅块传输)", "invalid block size (block mode only)"),
    (0x0504_0003, "无效的序列号(仅块传输)", "invalid sequence number (block mode only)"),
    (0x0504_0004, "CRC校验错误(仅块传输)", "CRC error (block mode only)"),
    (0x0504_0005, "内存不足", "out of memory"),
    (0x0601_0000, "不支持对该对象的访问", "unsupported access to an object"),
    (0x0601_0001, "试图读只写对象", "attempt to read a write-only object"),
    (0x0601_0002, "试图写只读对象", "attempt to write a read-only object"),
    (0x0602_0000, "对象字典中不存在该对象", "object does not exist in the object dictionary"),
    (0x0604_0041, "对象不能映射到PDO", "object cannot be mapped to the PDO"),
    (
        0x0604_0042,
        "映射对象的数目和长度超出PDO长度",
        "number and length of the objects to be mapped would exceed PDO length",
    ),
    (0x0604_0043, "一般性参数不兼容", "general parameter incompatibility reason"),
    (0x0604_0047, "设备内部一般性不兼容", "general internal incompatibility in the device"),
    (0x0606_0000, "硬件错误导致访问失败", "access failed due to a hardware error"),
    (
        0x0607_0010,
        "数据类型不匹配, 服务参数长度不匹配",
        "data type does not match, length of service parameter does not match",
    ),
    (0x0607_0012, "数据类型不匹配, 服务参数长度过长", "data type does not match, length of service parameter too high"),
    (0x0607_0013, "数据类型不匹配, 服务参数长度过短", "data type does not match, length of service parameter too low"),
    (0x0609_0011, "子索引不存在", "sub-index does not exist"),
    (0x0609_0030, "参数值无效(仅下载)", "invalid value for parameter (download only)"),
    (0x0609_0031, "写入的参数值过大(仅下载)", "value of parameter written too high (download only)"),
    (0x0609_0032, "写入的参数值过小(仅下载)", "value of parameter written too low (download only)"),
    (0x0609_0036, "最大值小于最小值", "maximum value is less than minimum value"),
    (0x060A_0023, "资源不可用: SDO连接", "resource not available: SDO connection"),
    (0x0800_0000, "一般性错误", "general error"),
    (0x0800_0020, "数据无法传送或存储到应用", "data cannot be transferred or stored to the application"),
    (
        0x0800_0021,
        "由于本地控制, 数据无法传送或存储到应用",
        "data cannot be transferred or stored to the application because of local control",
    ),
    (
        0x0800_0022,
        "由于当前设备状态, 数据无法传送或存储到应用",
        "data cannot be transferred or stored to the application because of the present device state",
    ),
    (
        0x0800_0023,
        "对象字典动态生成失败或不存在",
        "object dictionary dynamic generation fails or no object dictionary is present",
    ),
    (0x0800_0024, "无可用数据", "no data available"),
];

/// What an abort code says; `None` for one that CiA 301 does not define.
pub fn abort_code(lang: Lang, code: u32) -> Option<&'static str> {
    find(CODES, lang, code)
}
