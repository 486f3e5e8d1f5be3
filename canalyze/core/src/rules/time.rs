//! Rules about TIME (CiA 301, 7.2.6).

use crate::bytes::ns::Ns;

use super::quantity::{Count, Hex2};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 时间报文(TIME)为6字节, 毫秒数小于86400000 (一天), 保留的四位为0。
    /// TIME has 6 bytes, fewer than 86400000 milliseconds (a day), and its four reserved bits are 0.
    ///
    /// 时间报文的生产者填错了字段, 例如使用了其他的起点或单位。
    /// The producer fills the fields wrongly, such as with another epoch or unit.
    Tim001 "TIM001" "invalid-time" Warning "CiA 301 7.2.6" [Time] {
        message "时间报文无效" "invalid TIME";
        TimeOfDay { found: Count } "毫秒数为{found}, 超出一天(86399999)" "{found} ms exceeds one day (86399999)";
        ReservedBits { found: Hex2 } "保留位为{found}, 应为0" "reserved bits are {found}, expected 0";
        Length { found: Count } "时间报文(TIME)为{found}字节, 应为6字节" "TIME is {found|byte|bytes} long, expected 6";
    }

    /// 两个时间报文之差与记录中经过的时间相差1秒以上, 或多个报文累计相差2秒以上。
    /// The difference of two TIMEs is off by more than a second from the time in the capture, that of several by two.
    ///
    /// 生产者的时钟被校准, 停走或走得不准, 有两个生产者, 或者记录主机的时钟被调整。
    /// The producer's clock was set, stops or drifts, there are two producers, or the capturing host's clock was set.
    Tim002 "TIM002" "time-jump" Warning "CiA 301 7.2.6" [Time] {
        message "时间报文跳变" "TIME jumps";
        Jump { passed: Ns, elapsed: Ns }
            "TIME的时间变化{passed}, 而记录中只过了{elapsed}" "TIME changed by {passed} while {elapsed} passed";
    }
}
