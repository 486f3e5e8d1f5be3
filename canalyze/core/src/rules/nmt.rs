//! Rules about NMT commands and states (CiA 301, 7.2.8.3.1, 7.3.2).

use crate::bytes::ns::Ns;

use super::quantity::{Command, Count, Hex2, State};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// CiA 301定义的命令为01h、02h、80h、81h和82h, 节点ID为0 (所有节点) 到127, 长度2字节; 其他命令会被节点忽略。
    /// CiA 301 defines the commands 01h, 02h, 80h, 81h and 82h, node-IDs 0 (all) to 127, and a length of 2 bytes; nodes ignore anything else.
    ///
    /// 主站程序拼错了命令, 或者其他协议占用了CAN-ID 000h。
    /// A wrong command from the master, or another protocol on CAN-ID 000h.
    Nmt001 "NMT001" "invalid-node-control" Warning "CiA 301 7.2.8.3.1" [Nmt, ErrorControl] {
        message "NMT命令无效" "invalid NMT command";
        Command { found: Hex2 } "未知的NMT命令{found}" "unknown NMT command {found}";
        NodeId { found: Count } "NMT命令的节点ID为{found}, 应为0到127" "NMT command to node-ID {found}, expected 0 to 127";
        Length { found: Count } "NMT命令为{found}字节, 应为2字节" "NMT command is {found|byte|bytes} long, expected 2";
    }

    /// 节点收到命令后必须进入相应状态; 两个心跳周期之后它仍报告其他状态。
    /// A node must enter the commanded state; two heartbeat periods later it still reports another one.
    ///
    /// 节点拒绝启动 (有错误, 或配置不完整), 没有收到命令, 或者命令发给了不执行它的节点。
    /// The node refuses to start (an error, or an incomplete configuration), or did not receive the command.
    Nmt002 "NMT002" "command-without-effect" Warning "CiA 301 7.2.8.3.1" [Nmt, ErrorControl] {
        message "NMT命令未生效" "NMT command without effect";
        Still { command: Command, found: State }
            "NMT命令“{command}”发出后, 节点仍处于{found}" "the node is still {found} after NMT command \"{command}\"";
        NoBootUp { command: Command, found: State } "NMT命令“{command}”发出后, 节点没有发送启动报文, 却报告{found}"
            "the node sent no boot-up after NMT command \"{command}\", but reports {found}";
    }

    /// 启动报文之前没有复位命令, 也没有其他能解释它的帧。
    /// No reset command or other frame before the boot-up explains it.
    ///
    /// 看门狗复位, 电源跌落, 固件崩溃, 或者节点曾被人为断电。
    /// A watchdog reset, a supply dip, a firmware crash, or a manual power cycle.
    Nmt003 "NMT003" "spontaneous-reset" Warning "CiA 301 7.3.2.1" [Nmt, ErrorControl] {
        message "节点自行复位" "unexpected reset";
        SinceBootUp { after: Ns }
            "未见复位命令却收到启动报文, 距上次启动{after}" "boot-up without a reset command, {after} after the previous boot-up";
        BootUp "未见复位命令却收到启动报文" "boot-up without a reset command";
        WhileRunning { after: Ns } "节点正在运行 (上次心跳在{after}前), 未见复位命令却重新启动"
            "the node was running (last heartbeat {after} earlier) and booted without a reset command";
    }

    /// 节点的NMT状态发生变化, 但没有相应的NMT命令, 也没有紧急报文。
    /// The node reports another NMT state although no NMT command changed it and no EMCY explains it.
    ///
    /// 节点内部的错误处理 (1029h), 本地操作, 两个节点使用同一个节点ID, 或者命令不在记录中。
    /// Error behaviour (1029h) or local operation of the node, two nodes with one node-ID, or a command that is not in the capture.
    Nmt004 "NMT004" "state-change-without-command" Warning "CiA 301 7.3.2.1" [Nmt, ErrorControl] {
        message "没有NMT命令的状态变化" "state change without NMT command";
        Changed { from: State, to: State }
            "没有NMT命令, 状态却由{from}变为{to}" "state changed from {from} to {to} without an NMT command";
    }

    /// 节点没有收到命令就离开操作状态或进入停止状态, 并发送了紧急报文: 这是1029h规定的错误行为。此后节点保持该状态, 不会因错误而启动。
    /// The node left Operational, or entered Stopped, without a command and sent an EMCY: the error behaviour of 1029h. It stays in that state; an error never starts a node.
    ///
    /// 通信错误, 例如它监视的心跳丢失。
    /// A communication error, such as the loss of a heartbeat that the node watches.
    Nmt005 "NMT005" "state-change-on-error" Info "CiA 301 7.5.2.32" [Nmt, ErrorControl] {
        message "因错误改变状态" "state change on an error";
        Changed { from: State, to: State } "没有NMT命令, 状态由{from}变为{to}, 并伴有该节点的紧急报文"
            "state changed from {from} to {to} without an NMT command, together with an EMCY of the node";
    }

    /// 节点复位并完成初始化后必须发送启动报文。该节点此前在线, 复位后却没有发送。
    /// After a reset and its initialisation a node sends a boot-up. None was seen, although the node was online before.
    ///
    /// 节点卡在初始化过程中, 掉电, 节点ID或波特率配置丢失, 或者没有收到命令。
    /// The node hangs during initialisation, lost power, lost its node-ID or bit rate configuration, or did not receive the command.
    Nmt006 "NMT006" "boot-up-missing" Error "CiA 301 7.3.2.1" [Nmt, ErrorControl] {
        message "复位后没有启动报文" "no boot-up after a reset";
        Missing { command: Command, age: Ns }
            "NMT命令“{command}”发出后{age}没有启动报文" "no boot-up for {age} after NMT command \"{command}\"";
        Unclear [sender = "perhaps_the_master"] { command: Command, age: Ns }
            "NMT命令“{command}”发出后{age}没有启动报文; 该节点也可能就是主站"
            "no boot-up for {age} after NMT command \"{command}\"; the node may be the master itself";
    }
}
