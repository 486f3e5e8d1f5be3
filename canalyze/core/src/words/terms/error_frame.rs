//! SocketCAN error frames' terms: classes and details.

use super::Row;

/// Error classes, by bit of the identifier.
pub static CLASSES: &[Row<u32>] = &[
    (0x001, "发送超时", "TX timeout"),
    (0x002, "仲裁丢失", "lost arbitration"),
    (0x004, "控制器问题", "controller problem"),
    (0x008, "协议违规", "protocol violation"),
    (0x010, "收发器状态", "transceiver status"),
    (0x020, "发送未得到应答(ACK)", "no acknowledgement on transmission"),
    (0x040, "总线关闭", "bus off"),
    (0x080, "总线错误", "bus error"),
    (0x100, "控制器已重启", "controller restarted"),
    (0x200, "错误计数器", "error counters"),
];

/// Controller status, by bit of byte 1.
pub static CONTROLLER: &[Row<u8>] = &[
    (0x01, "接收缓冲区溢出", "RX buffer overflow"),
    (0x02, "发送缓冲区溢出", "TX buffer overflow"),
    (0x04, "接收错误达到警告水平", "RX error warning level"),
    (0x08, "发送错误达到警告水平", "TX error warning level"),
    (0x10, "接收错误达到被动水平", "RX error passive level"),
    (0x20, "发送错误达到被动水平", "TX error passive level"),
    (0x40, "恢复到错误主动状态", "recovered to error active state"),
];

/// Protocol violation type, by bit of byte 2.
pub static PROTOCOL: &[Row<u8>] = &[
    (0x01, "单个位错误", "single bit error"),
    (0x02, "格式错误", "frame format error"),
    (0x04, "位填充错误", "bit stuffing error"),
    (0x08, "无法发送显性位", "unable to send dominant bit"),
    (0x10, "无法发送隐性位", "unable to send recessive bit"),
    (0x20, "总线过载", "bus overload"),
    (0x40, "主动错误通告", "active error announcement"),
    (0x80, "发生在发送时", "occurred on transmission"),
];

/// Protocol violation location, byte 3: the field of the frame.
pub static LOCATION: &[Row<u8>] = &[
    (0x02, "ID位28-21", "ID bits 28-21"),
    (0x03, "帧起始", "start of frame"),
    (0x04, "SRTR位", "SRTR bit"),
    (0x05, "IDE位", "IDE bit"),
    (0x06, "ID位20-18", "ID bits 20-18"),
    (0x07, "ID位17-13", "ID bits 17-13"),
    (0x08, "CRC序列", "CRC sequence"),
    (0x09, "保留位0", "reserved bit 0"),
    (0x0A, "数据段", "data section"),
    (0x0B, "数据长度码", "data length code"),
    (0x0C, "RTR位", "RTR bit"),
    (0x0D, "保留位1", "reserved bit 1"),
    (0x0E, "ID位4-0", "ID bits 4-0"),
    (0x0F, "ID位12-5", "ID bits 12-5"),
    (0x12, "帧间隔", "intermission"),
    (0x18, "CRC界定符", "CRC delimiter"),
    (0x19, "应答槽", "ACK slot"),
    (0x1A, "帧结束", "end of frame"),
    (0x1B, "应答界定符", "ACK delimiter"),
];

/// Transceiver status, byte 4: one value for each wire (low nibble CANH, high nibble CANL).
pub static TRANSCEIVER: &[Row<u8>] = &[
    (0x04, "CANH断线", "CANH no wire"),
    (0x05, "CANH对电池短路", "CANH short to BAT"),
    (0x06, "CANH对VCC短路", "CANH short to VCC"),
    (0x07, "CANH对地短路", "CANH short to GND"),
    (0x40, "CANL断线", "CANL no wire"),
    (0x50, "CANL对电池短路", "CANL short to BAT"),
    (0x60, "CANL对VCC短路", "CANL short to VCC"),
    (0x70, "CANL对地短路", "CANL short to GND"),
    (0x80, "CANL与CANH短路", "CANL short to CANH"),
];
