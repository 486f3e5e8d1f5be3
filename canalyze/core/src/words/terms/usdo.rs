//! USDO's terms (CiA 1301): command specifiers and the one-byte abort codes.

use super::{Row, find};
use crate::words::Lang;

/// Command specifiers without the remote bit (80h).
pub static COMMANDS: &[Row<u8>] = &[
    (0x01, "加速下载请求", "expedited download request"),
    (0x02, "分段下载初始化请求", "segmented download initiate request"),
    (0x03, "分段下载后续段请求", "segmented download continue request"),
    (0x04, "分段下载最后段请求", "segmented download last request"),
    (0x06, "块下载初始化请求", "bulk download initiate request"),
    (0x07, "块下载后续段请求", "bulk download continue request"),
    (0x08, "块下载最后段请求", "bulk download last request"),
    (0x11, "加速上传请求", "expedited upload request"),
    (0x13, "分段上传后续段请求", "segmented upload continue request"),
    (0x21, "加速下载响应", "expedited download response"),
    (0x22, "分段下载初始化响应", "segmented download initiate response"),
    (0x23, "分段下载后续段响应", "segmented download continue response"),
    (0x24, "分段下载最后段响应", "segmented download last response"),
    (0x26, "块下载初始化响应", "bulk download initiate response"),
    (0x28, "块下载最后段响应", "bulk download last response"),
    (0x31, "加速上传响应", "expedited upload response"),
    (0x32, "分段上传初始化响应", "segmented upload initiate response"),
    (0x33, "分段上传后续段响应", "segmented upload continue response"),
    (0x34, "分段上传最后段响应", "segmented upload last response"),
    (0x7F, "中止", "abort"),
];

/// Abort codes.
pub static ABORTS: &[Row<u8>] = &[
    (0x10, "未知原因", "unknown reason"),
    (0x11, "协议错误", "protocol error"),
    (0x12, "协议超时", "protocol timed out"),
    (0x13, "命令字未知", "command specifier unknown"),
    (0x14, "计数字节错误", "counter byte error"),
    (0x15, "CRC校验错误", "CRC error"),
    (0x16, "内存不足", "out of memory"),
    (0x17, "参数不兼容", "parameter incompatible"),
    (0x18, "设备内部不兼容", "internal incompatibility"),
    (0x19, "路由错误", "routing error"),
    (0x1A, "路由错误", "routing error"),
    (0x1B, "路由错误", "routing error"),
    (0x1C, "路由错误", "routing error"),
    (0x1D, "路由错误", "routing error"),
    (0x1E, "数据长度码错误", "DLC error"),
    (0x1F, "索引或子索引错误", "multiplexor error"),
    (0x30, "不支持对该对象的访问", "unsupported access to an object"),
    (0x31, "试图读只写对象", "attempt to read a write-only object"),
    (0x32, "试图写只读对象", "attempt to write a read-only object"),
    (0x33, "对象字典中不存在该对象", "object does not exist in the object dictionary"),
    (0x34, "子索引不存在", "sub-index does not exist"),
    (0x35, "硬件错误导致访问失败", "access failed due to a hardware error"),
    (0x36, "长度不匹配", "length does not match"),
    (0x37, "长度过长", "length too high"),
    (0x38, "长度过短", "length too low"),
    (0x40, "参数值无效", "invalid value"),
    (0x41, "参数值过大", "value too high"),
    (0x42, "参数值过小", "value too low"),
    (0x43, "最大值与最小值不符", "maximum and minimum value do not fit"),
    (0x44, "最大值与最小值不符", "maximum and minimum value do not fit"),
    (0x50, "对象不能映射到PDO", "object cannot be mapped to the PDO"),
    (0x51, "超出PDO长度", "PDO length exceeded"),
    (0x52, "PDO映射或有效位错误", "PDO mapping or valid-bit error"),
    (0x53, "PDO映射或有效位错误", "PDO mapping or valid-bit error"),
    (0x54, "PDO映射或有效位错误", "PDO mapping or valid-bit error"),
    (0x55, "PDO映射或有效位错误", "PDO mapping or valid-bit error"),
    (0x56, "PDO映射或有效位错误", "PDO mapping or valid-bit error"),
    (0x60, "数据无法传送或存储到应用", "data cannot be transferred or stored to the application"),
    (0x61, "由于本地控制, 数据无法传送或存储到应用", "data cannot be stored because of local control"),
    (0x62, "由于当前设备状态, 数据无法传送或存储到应用", "data cannot be stored because of the present device state"),
    (0x63, "对象字典动态生成失败或不存在", "object dictionary dynamic generation fails or none is present"),
    (0x64, "无可用数据", "no data available"),
    (0x70, "服务器忙", "server busy"),
];

/// The name of a command; its remote bit is ignored.
pub fn command(lang: Lang, command: u8) -> Option<&'static str> {
    find(COMMANDS, lang, command & 0x7F)
}

/// Returns the meaning of an abort code.
pub fn abort(lang: Lang, code: u8) -> Option<&'static str> {
    find(ABORTS, lang, code)
}
