"""Listening to a live bus: why it cannot be, what to do, what is told while it goes on.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    # What went wrong while listening; {error} is the system's reason.
    ("live.lost", "{channel}：接收中断：{error}", "{channel}: cannot be received from any more: {error}"),
    ("live.broken", "{channel}：接收出错：{problem}", "{channel}: receiving failed: {problem}"),
    (
        "live.went_down",
        "{channel}：接口已关闭；重新启用：{command}",
        "{channel}: the interface went down; bring it up: {command}",
    ),
    (
        "live.unplugged",
        "{channel}：接口已消失；请检查适配器是否拔出",
        "{channel}: the interface is gone; check whether the adapter was unplugged",
    ),
    ("live.gone", "{reason}（--reconnect 会等它恢复）", "{reason} (--reconnect waits for it)"),
    ("live.waiting", "{reason}；等待 {channel} 恢复", "{reason}; waiting for {channel}"),
    ("live.back", "{channel}：已恢复接收", "{channel}: receiving again"),
    # Why it cannot begin.
    (
        "live.missing",
        "{channel}：没有这个CAN接口；现有：{there}",
        "{channel}: no such CAN interface; there are: {there}",
    ),
    (
        "live.no_interface",
        "{channel}：本机没有CAN接口；请插上适配器或加载其驱动"
        "（试用可建虚拟接口：sudo ip link add vcan0 type vcan && sudo ip link set vcan0 up）",
        "{channel}: this host has no CAN interface; plug the adapter in or load its driver "
        "(to try things: sudo ip link add vcan0 type vcan && sudo ip link set vcan0 up)",
    ),
    ("live.down", "{channel}：接口未启用；启用：{command}", "{channel}: the interface is down; bring it up: {command}"),
    (
        "live.none_up",
        "any：没有已启用的CAN接口；启用：{command}",
        "any: no CAN interface is up; bring one up: {command}",
    ),
    (
        "live.not_can",
        "{channel}：不是CAN接口；现有CAN接口：{there}",
        "{channel}: is no CAN interface; CAN interfaces: {there}",
    ),
    (
        "live.not_can_none",
        "{channel}：不是CAN接口，本机没有CAN接口",
        "{channel}: is no CAN interface; this host has none",
    ),
    (
        "live.not_linux",
        "{channel}：本系统没有SocketCAN；请用 --interface 指定适配器，如 --interface pcan",
        "{channel}: this system has no SocketCAN; name the adapter with --interface, as --interface pcan",
    ),
    (
        "live.no_can",
        "{channel}：内核不支持CAN；加载：sudo modprobe can_raw",
        "{channel}: the kernel has no CAN; load it: sudo modprobe can_raw",
    ),
    (
        "live.forbidden",
        "{channel}：无权打开CAN套接字；请以root运行，容器须允许AF_CAN",
        "{channel}: not allowed to open a CAN socket; run as root, a container has to allow AF_CAN",
    ),
    ("live.refused", "{channel}：无法接收：{error}", "{channel}: cannot be received from: {error}"),
    ("live.twice", "{channel}：重复给出；只写一次", "{channel}: named twice; name it once"),
    ("live.too_many", "通道过多；最多 {most} 个", "too many channels; at most {most}"),
    # What is told while it goes on.
    ("live.any", "any：监听 {channels}", "any: listening to {channels}"),
    (
        "live.small_buffer",
        "{channel}：接收缓冲区过小，内核已丢帧；增大：sudo sysctl -w net.core.rmem_max={bytes}，然后重新运行",
        "{channel}: the kernel dropped frames, its receive buffer is small; "
        "enlarge it: sudo sysctl -w net.core.rmem_max={bytes}, then run again",
    ),
    (
        "live.bus_off",
        "{channel}：控制器已总线关闭（bus-off），重启前收不到帧；"
        "自动恢复：sudo ip link set {channel} type can restart-ms 100",
        "{channel}: the controller went bus-off and receives nothing until it is restarted; "
        "let it restart by itself: sudo ip link set {channel} type can restart-ms 100",
    ),
    (
        "live.no_hardware_stamps",
        "{channel}：适配器不给硬件时间戳，改用内核时间戳",
        "{channel}: the adapter gives no hardware stamps; the kernel's are used",
    ),
    (
        "live.other_clock",
        "{channel}：硬件时间戳不是本机时间，无法与其他通道排序，改用内核时间戳",
        "{channel}: hardware stamps are of another clock and put in no order with other channels; "
        "the kernel's are used",
    ),
)
