//! Rules about drives (CiA 402-2).

use crate::bytes::ns::Ns;

use super::quantity::{Controlword, Mode, Statusword};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 驱动器只能按CiA 402状态机转换; 朝"运行使能"方向的每一步都需要控制字中的相应命令。这里前后两个状态字之间, 没有任何控制字能引起这一变化。
    /// A drive follows CiA 402's state machine; each step toward operation enabled needs its command in the controlword. No controlword between these two statuswords can have caused the change.
    ///
    /// 驱动器固件的状态机有误, 另有主站或本地面板在控制, 或者记录中丢了控制字。
    /// A bug in the drive's state machine, another master or a local panel in control, or a controlword missing from the capture.
    Drv001 "DRV001" "illegal-transition" Warning "CiA 402-2, power drive system" [Pdo, Sdo, Emcy] {
        message "状态跳变没有对应的控制字" "drive state changed without a matching controlword";
        Unexplained { from: Statusword, to: Statusword, controlword: Option<Controlword> }
            "状态字由{from}变为{to}, 其间没有对应的控制字 (最后的控制字: {controlword})"
            "statusword changed from {from} to {to} without a matching controlword (last one: {controlword})";
    }

    /// 控制字给出了应使驱动器离开当前状态的命令, 状态字持续上报(或者仅在变化时发送, 而节点仍在线), 状态却不变。断电方向的命令和故障复位等待1秒, 使能方向的命令和先制动的命令(关闭、禁止操作)等待5秒; 本地控制(位9为0)和使能方向上主电源未接入(位4为0)时不判断。
    /// The controlword holds a command that should lead out of the current state, and statuswords keep coming, or are sent by events alone while the node goes on, but the state does not change. The limit is 1 second for a fault reset or a command away from operation enabled, 5 seconds toward it and for commands that brake first (shutdown, disable operation). Not judged: local operation (bit 9 is 0) and, toward operation enabled, missing voltage (bit 4 is 0).
    ///
    /// 使能输入、STO或制动器条件不满足, 故障原因仍在, 命令顺序不对, 或者驱动器没有接收该RPDO。
    /// A condition is missing (enable input, STO, brake), the cause of the fault is still there, the commands came in the wrong order, or the drive does not receive the RPDO.
    Drv002 "DRV002" "command-without-effect" Warning "CiA 402-2, power drive system" [Pdo, Sdo, Emcy] {
        message "命令没有生效" "a command has no effect";
        StillIn { controlword: Controlword, statusword: Statusword, after: Ns }
            "发出控制字{controlword}后{after}, 状态字仍为{statusword}"
            "{after} after controlword {controlword} the statusword is still {statusword}";
    }

    /// 驱动器进入故障状态, 前后500 ms内没有该节点的紧急报文(EMCY)。
    /// The drive entered a fault state without an EMCY of the node within 500 ms before or after.
    ///
    /// 驱动器不发送EMCY, 同一错误此前已经报告过, 或者记录时滤掉了EMCY。
    /// The drive sends no EMCY, the same error was reported earlier, or EMCYs were filtered out of the capture.
    Drv003 "DRV003" "fault-without-emcy" Info "CiA 402-2, EMCY" [Pdo, Sdo, Emcy] {
        message "进入故障状态却没有紧急报文" "fault state without EMCY";
        Unannounced { statusword: Statusword }
            "状态字变为{statusword}, 前后没有紧急报文" "statusword changed to {statusword} without an EMCY before or after";
    }

    /// 写入6060h的操作模式在1秒内没有出现在6061h中。有些驱动器只在特定状态下才切换模式, 不支持的模式不会切换。
    /// The mode of operation written to 6060h did not appear in 6061h within 1 second. Some drives change modes in certain states only, and an unsupported mode is not taken at all.
    ///
    /// 驱动器不支持该模式(见6502h), 当前状态下不允许切换, 或者另一个PDO写入了别的模式。
    /// The drive does not support the mode (see 6502h), does not change it in this state, or another PDO writes another mode.
    Drv004 "DRV004" "mode-not-taken" Info "CiA 402-2, 6060h, 6061h" [Pdo, Sdo, Emcy] {
        message "6061h未显示请求的操作模式" "6061h does not show the requested mode";
        StillDisplayed { requested: Mode, displayed: Mode, after: Ns } "请求的模式为{requested}, {after}后6061h仍为{displayed}"
            "mode {requested} requested, {after} later 6061h still reads {displayed}";
    }

    /// 状态字表明驱动器进入故障状态: 已经停止或正在停止, 需要故障复位。若该节点有紧急报文(EMCY)报告了此故障, 则以紧急报文为准, 本条是其后果。
    /// The statusword shows that the drive entered a fault state: it has stopped or is stopping, and needs a fault reset. Where the node reports it by EMCY, that EMCY is the finding and this is its consequence.
    ///
    /// 见紧急报文或603Fh中的错误码和制造商手册; 通信中断也可能是原因。
    /// See the error code in the EMCY or 603Fh, and the manufacturer's manual; lost communication may also be the cause.
    Drv005 "DRV005" "drive-fault" Error "CiA 402-2, power drive system" [Pdo, Sdo, Emcy] {
        message "驱动器故障" "drive fault";
        Entered { statusword: Statusword } "状态字变为{statusword}" "statusword changed to {statusword}";
    }
}
