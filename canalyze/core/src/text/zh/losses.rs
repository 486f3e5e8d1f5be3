//! What a capture format cannot hold, in Chinese.

use crate::text::digits::put;
use crate::writers::loss::Loss;

/// `12帧: 未保留收发方向`.
pub fn loss(out: &mut Vec<u8>, loss: Loss, count: u64) {
    let (unit, what) = match loss {
        Loss::Direction => ("帧", "未保留收发方向"),
        Loss::UnknownDirection => ("帧", "收发方向未知, 记为接收"),
        Loss::BusName => ("帧", "总线名未能原样保留"),
        Loss::StampDigits => ("帧", "未保留时间戳的末几位"),
        Loss::NoStamp => ("帧", "没有可写入的时间戳, 写入的是虚构的时间戳"),
        Loss::Order => ("帧", "时间戳倒退, 该格式不允许"),
        Loss::NoDate => ("帧", "日期未知, 时间戳从零开始"),
        Loss::FdFlags => ("帧", "未保留比特率切换或错误状态指示"),
        Loss::FdFormat => ("个CAN FD帧", "以经典帧格式写入"),
        Loss::FdFrame => ("个CAN FD帧", "该格式没有这种帧, 未写入"),
        Loss::RawDlc => ("帧", "未保留大于8的原始DLC"),
        Loss::RemoteLength => ("个远程帧", "未保留所请求的长度"),
        Loss::ErrorDetails => ("个错误帧", "未保留错误类别和详情"),
        Loss::ErrorFrame => ("个错误帧", "该格式没有这种帧, 未写入"),
        Loss::Gap => ("处缺口", "未保留记录程序丢帧的信息"),
        Loss::Topics => ("帧", "topic数已达上限, 未写入其信号"),
    };
    put!(out; count, unit, ": ", what);
}
