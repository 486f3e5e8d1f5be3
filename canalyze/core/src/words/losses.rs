//! Losses by conversion to a capture format, in both languages.

use super::digits::put;
use super::{Lang, say};
use crate::bytes::writers::loss::Loss;

/// Appends a loss with its count: `12帧: 未保留收发方向`, `12 frames: direction not kept`.
pub fn loss(out: &mut Vec<u8>, lang: Lang, loss: Loss, count: u64) {
    let one = count == 1;
    match loss {
        Loss::FdFormat | Loss::FdFrame => {
            say!(out, lang; zh: count, "个CAN FD帧"; en: count, if one { " CAN FD frame" } else { " CAN FD frames" });
        }
        Loss::RemoteLength => {
            say!(out, lang; zh: count, "个远程帧"; en: count, if one { " remote frame" } else { " remote frames" });
        }
        Loss::ErrorDetails | Loss::ErrorFrame => {
            say!(out, lang; zh: count, "个错误帧"; en: count, if one { " error frame" } else { " error frames" });
        }
        Loss::Gap => say!(out, lang; zh: count, "处缺口"; en: count, if one { " gap" } else { " gaps" }),
        _ => say!(out, lang; zh: count, "帧"; en: count, if one { " frame" } else { " frames" }),
    }
    let (zh, en) = what(loss);
    put!(out; ": ", lang.pick(zh, en));
}

/// The loss, in Chinese and in English.
fn what(loss: Loss) -> (&'static str, &'static str) {
    match loss {
        Loss::Direction => ("未保留收发方向", "direction not kept"),
        Loss::UnknownDirection => ("收发方向未知, 记为接收", "direction unknown, written as received"),
        Loss::BusName => ("总线名未能原样保留", "bus name not kept unchanged"),
        Loss::StampDigits => ("未保留时间戳的末几位", "last digits of the timestamp not kept"),
        Loss::NoStamp => {
            ("没有可写入的时间戳, 写入的是人为生成的时间戳", "no usable timestamp, an artificial one was written")
        }
        Loss::Order => ("时间戳倒退, 该格式不允许", "timestamp goes back, which the format does not allow"),
        Loss::NoDate => ("日期未知, 时间戳从零开始", "date unknown, timestamps start from zero"),
        Loss::FdFlags => ("未保留比特率切换或错误状态指示", "bit rate switch or error state indicator not kept"),
        Loss::FdFormat => ("以经典帧格式写入", "written in the classic frame format"),
        Loss::FdFrame | Loss::ErrorFrame => ("该格式不支持这种帧, 未写入", "not supported by the format, left out"),
        Loss::RawDlc => ("未保留大于8的原始DLC", "raw DLC above 8 not kept"),
        Loss::RemoteLength => ("未保留所请求的长度", "requested length not kept"),
        Loss::ErrorDetails => ("未保留错误类别和详情", "error class and details not kept"),
        Loss::Gap => ("未保留记录程序丢帧的信息", "marker of lost frames not kept"),
        Loss::Topics => ("topic数已达上限, 未写入其信号", "topic limit reached, signals not written"),
    }
}
