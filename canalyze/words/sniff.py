"""Listening: the command `sniff`, options of commands that listen, adapters, recordings.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("sniff.short", "监听总线，逐帧注释，可同时记录", "Listen to a bus, annotate each frame, record it"),
    ("sniff.usage", "[选项] 通道...", "[OPTIONS] CHANNEL..."),
    (
        "sniff.help",
        "监听一条或几条总线，收到一帧就注释一帧，写法与decode相同：状态、PDO信号、同步周期、发现；总线安静时，"
        "心跳停止等超时也会及时报告。只监听，从不发送任何帧。Linux上默认用SocketCAN，"
        "其余适配器经python-can（-i）；适配器有只听模式的就使用它。通道名后可跟candump的过滤器，如 can0,580:780,#123："
        "只决定显示哪些帧，状态和记录不受影响。Ctrl-C正常结束：报告未完成的传输，并在标准错误上给出小结。",
        "Listen to one bus or several and annotate each frame as it comes, written as decode does: state, signals of "
        "PDOs, SYNC cycle, findings; while the bus is silent, what is overdue, such as a heartbeat that has stopped, "
        "is reported too. It only listens and never sends a frame. On Linux SocketCAN is the default; other adapters "
        "are used through python-can (-i), in listen-only mode where they have it. Behind a channel may stand "
        "candump's filters, as can0,580:780,#123: they choose what is shown; state and recordings get every frame. "
        "Ctrl-C is the normal end: open transfers are reported, a short summary goes to standard error.",
    ),
    (
        "sniff.duration",
        "监听这么久后结束，如 10、10s、5m、1h。",
        "End after this time, e.g. 10, 10s, 5m, 1h.",
    ),
    ("sniff.count", "显示这么多帧后结束。", "End after so many frames were shown."),
    (
        "sniff.expect",
        "期望文件：收到的报文与它不符则退出码为1。写法见 canalyze expect --help。",
        "A file of expectations; the exit code is 1 where one is not met. canalyze expect --help shows how it is "
        "written.",
    ),
    (
        "sniff.examples",
        "canalyze sniff can0\n"
        "canalyze sniff can0 can1 --record bus.mcap\n"
        "canalyze sniff can0 --rerun\n"
        "canalyze sniff can0,580:780,600:780 --eds 5=drive.eds\n"
        "canalyze sniff can0 --record bus.log --rotate 100MB --keep 10 --reconnect\n"
        "canalyze sniff can0 --duration 30s --expect boot.expect.toml\n"
        "canalyze sniff -i pcan PCAN_USBBUS1 --bitrate 500k\n"
        "canalyze sniff -i slcan /dev/ttyACM0 --bitrate 1M --option tty_baudrate=115200\n"
        "canalyze sniff can0 --format jsonl | jq -r '.text // .message'",
        "canalyze sniff can0\n"
        "canalyze sniff can0 can1 --record bus.mcap\n"
        "canalyze sniff can0 --rerun\n"
        "canalyze sniff can0,580:780,600:780 --eds 5=drive.eds\n"
        "canalyze sniff can0 --record bus.log --rotate 100MB --keep 10 --reconnect\n"
        "canalyze sniff can0 --duration 30s --expect boot.expect.toml\n"
        "canalyze sniff -i pcan PCAN_USBBUS1 --bitrate 500k\n"
        "canalyze sniff -i slcan /dev/ttyACM0 --bitrate 1M --option tty_baudrate=115200\n"
        "canalyze sniff can0 --format jsonl | jq -r '.text // .message'",
    ),
    # The summary at the end.
    (
        "sniff.bus",
        "{bus}：{frames}帧，历时{seconds}秒，每秒{rate}帧",
        "{bus}: {frames} frames in {seconds} s, {rate}/s",
    ),
    ("sniff.nothing", "{bus}：{seconds}秒内没有收到帧", "{bus}: no frame in {seconds} s"),
    ("sniff.error_frames", "错误帧{count}", "error frames {count}"),
    ("sniff.dropped", "丢失{count}帧", "{count} dropped"),
    ("sniff.then", "；", "; "),
    ("sniff.findings", "发现：{listed}", "findings: {listed}"),
    ("sniff.error", "错误{count}", "{count} error"),
    ("sniff.warning", "警告{count}", "{count} warning"),
    ("sniff.info", "提示{count}", "{count} info"),
    ("sniff.transfers", "SDO传输：{listed}", "SDO transfers: {listed}"),
    ("sniff.ok", "完成{count}", "{count} completed"),
    ("sniff.aborted", "中止{count}", "{count} aborted"),
    ("sniff.incomplete", "未完成{count}", "{count} incomplete"),
    ("sniff.failed", "失败{count}", "{count} failed"),
    ("sniff.shown", "显示了其中{shown}帧", "{shown} of these frames shown"),
    (
        "sniff.unshown",
        "输出太慢，{count}帧没有显示，也未参与判断",
        "{count} frames were neither shown nor judged, since the output was too slow",
    ),
    (
        "sniff.unshown_recorded",
        "输出太慢，{count}帧没有显示，也未参与判断；记录中有这些帧",
        "{count} frames were neither shown nor judged, since the output was too slow; recordings have them",
    ),
    ("sniff.met", "期望：全部符合", "expectations: all met"),
    ("sniff.missed", "期望：{count}处不符", "expectations: {count} not met"),
    (
        "sniff.unchecked",
        "期望：没有收到帧，未检查",
        "expectations: not checked, no frame was received",
    ),
    # Options of commands that listen.
    (
        "listen.bitrate",
        "总线的波特率，如 500000、125k、1M。SocketCAN的波特率由系统设置（ip link），"
        "此选项不改变它，只用于计算总线负载。",
        "Bit rate of the bus, e.g. 500000, 125k, 1M. That of SocketCAN is set by the system (ip link); this does not "
        "change it and is only for the bus load.",
    ),
    (
        "listen.interface",
        "经哪种接口监听：socketcan（Linux上的默认值），或python-can的接口，如 pcan、kvaser、slcan、vector。",
        "Kind of interface: socketcan (the default on Linux) or one of python-can's, e.g. pcan, kvaser, slcan, vector.",
    ),
    (
        "listen.data_bitrate",
        "CAN FD数据段的波特率，如 2M、5M；与 --fd 一起用。",
        "Bit rate of the data phase of CAN FD, e.g. 2M, 5M; with --fd.",
    ),
    (
        "listen.fd",
        "让适配器接收CAN FD帧；SocketCAN总是接收。",
        "Have the adapter receive CAN FD frames; SocketCAN always does.",
    ),
    (
        "listen.option",
        "python-can接口的其他参数，可重复；如 --option f_clock=80000000。总线上只有一个节点时，"
        "没有应答就收不到帧：用 --option listen_only=false 让适配器应答（各接口的参数名不同）。",
        "A further parameter of python-can's interface, repeatable, e.g. --option f_clock=80000000. Where there is "
        "only one node, nothing is received unless someone acknowledges: --option listen_only=false has the adapter do "
        "it (interfaces name it differently).",
    ),
    (
        "listen.reconnect",
        "接口没有启用或适配器被拔出时等待其恢复，而不是结束。",
        "Wait for an interface that is down, or an adapter that is unplugged, instead of ending.",
    ),
    (
        "listen.hardware_stamps",
        "使用适配器的硬件时间戳（若有）；只用于socketcan。",
        "Use the stamps of the adapter's hardware where it has them; socketcan only.",
    ),
    (
        "listen.record",
        "把收到的全部帧写入文件，与过滤器无关；可重复。格式由文件名决定：.log .asc .mcap .pcapng。"
        "边收边写，进程被终止时文件仍可读。",
        "Write everything that is received to a file, whatever the filters; repeatable. Its name tells the format: "
        ".log .asc .mcap .pcapng. Written as it comes: the file can be read even if the process is killed.",
    ),
    (
        "listen.rotate",
        "文件达到此大小（100MB、64MiB）或时长（30s、10m、1h）就换下一个：bus.log 成为 bus-0001.log、bus-0002.log 等。",
        "Go on in the next file at this size (100MB, 64MiB) or age (30s, 10m, 1h): bus.log becomes bus-0001.log, "
        "bus-0002.log, and so on.",
    ),
    (
        "listen.keep",
        "与 --rotate 一起用：只保留最近的这么多个文件，更早的删除。",
        "With --rotate: keep so many files, the latest ones; older ones of this run are deleted.",
    ),
    ("listen.comma", "，", ", "),
    (
        "listen.none",
        "没有给出通道；给出通道名，如 canalyze sniff can0",
        "no channel given; name one, as canalyze sniff can0",
    ),
    (
        "listen.no_name",
        "{value} 里没有通道名；过滤器写在通道名之后，如 can0,580:780",
        "{value} names no channel; filters stand behind its name, as can0,580:780",
    ),
    (
        "listen.twice",
        "通道 {name} 给出了两次；它的过滤器写在一起，如 can0,580:780,600:780",
        "channel {name} is given twice; its filters stand together, as can0,580:780,600:780",
    ),
    (
        "listen.a_file",
        "{name} 是文件，不是通道；读文件用 canalyze decode {name}",
        "{name} is a file, not a channel; canalyze decode {name} reads it",
    ),
    (
        "listen.stdin",
        "- 是标准输入，不是通道；读标准输入用 canalyze decode -",
        "- is standard input, not a channel; canalyze decode - reads it",
    ),
    ("listen.many", "通道太多，最多 {most} 个", "too many channels, at most {most}"),
    (
        "listen.needs_interface",
        "要用 -i 给出接口：{names}",
        "-i has to name an interface: {names}",
    ),
    (
        "listen.only_linux",
        "socketcan 只在Linux上有；可用的接口：{names}",
        "socketcan is only there on Linux; interfaces: {names}",
    ),
    (
        "listen.unknown",
        "没有接口 {name}；可用的接口：{names}",
        "no such interface: {name}; there are: {names}",
    ),
    (
        "listen.unknown_near",
        "没有接口 {name}，是 {near} 吗；可用的接口：{names}",
        "no such interface: {name}, did you mean {near}; there are: {names}",
    ),
    ("listen.only_own", "{option} 只用于socketcan", "{option} is only for socketcan"),
    (
        "listen.own_rate",
        "{option} 不用于socketcan：波特率由系统设置，如 "
        "ip link set can0 up type can bitrate 500000 dbitrate 2000000 fd on",
        "{option} is not for socketcan: the system sets the rates, as ip link set can0 up type can bitrate 500000 "
        "dbitrate 2000000 fd on",
    ),
    ("listen.not_own", "{option} 只用于python-can的接口", "{option} is only for python-can's interfaces"),
    ("listen.needs_fd", "{option} 要与 --fd 一起用", "{option} goes with --fd"),
    (
        "usage.option",
        "选项 {option} 不能是 {value}，应写成 名称=值，如 tty_baudrate=115200",
        "option {option}: {value} is not of the form NAME=VALUE, as tty_baudrate=115200",
    ),
    (
        "usage.duration",
        "选项 {option} 不能是 {value}，可以是大于0的时间，如 10、10s、500ms、5m、1h",
        "option {option}: {value} is not a time above 0, such as 10, 10s, 500ms, 5m or 1h",
    ),
    (
        "usage.positive",
        "选项 {option} 不能是 {value}，可以是大于0的整数",
        "option {option}: {value} is not a whole number above 0",
    ),
    (
        "usage.rotate",
        "选项 {option} 不能是 {value}，可以是大小，如 100MB、64MiB、500k，或时间，如 30s、10m、1h",
        "option {option}: {value} is neither a size, such as 100MB, 64MiB or 500k, nor a time, such as 30s, 10m or 1h",
    ),
    (
        "usage.data_rate",
        "选项 {option} 不能是 {value}，可以是1k到20M，如 2M、5M",
        "option {option}: {value} is not a bit rate from 1k to 20M, such as 2M or 5M",
    ),
    # Adapters.
    (
        "bus.acknowledges",
        "接口 {interface}：python-can不能让它只听，适配器会像节点一样应答帧（不发送帧）",
        "interface {interface}: python-can cannot make it listen only; the adapter acknowledges frames as a node does "
        "(no frame is sent)",
    ),
    (
        "bus.needs_rate",
        "{name}：接口 {interface} 不能只听，波特率不对会干扰总线；请用 --bitrate 给出总线的波特率，如 --bitrate 500k",
        "{name}: interface {interface} cannot listen only, and at a wrong bit rate it would disturb the bus; --bitrate "
        "has to say the rate, e.g. --bitrate 500k",
    ),
    (
        "bus.no_package",
        "{name}：接口 {interface} 需要的软件包尚未安装；安装：{line}（python-can报告：{problem}）",
        "{name}: interface {interface} needs a package that is not installed: {line} (python-can says: {problem})",
    ),
    (
        "bus.no_driver",
        "{name}：接口 {interface} 需要厂商的驱动 {driver}，没有找到；请安装（python-can报告：{problem}）",
        "{name}: interface {interface} needs the maker's driver, {driver}, which was not found; install it (python-can "
        "says: {problem})",
    ),
    (
        "bus.no_support",
        "{name}：接口 {interface} 在这里不能用；缺少它的软件包、驱动，或不支持本系统（python-can报告：{problem}）",
        "{name}: interface {interface} cannot be used here: its package or driver is missing, or the system is not "
        "supported (python-can says: {problem})",
    ),
    (
        "bus.settings",
        "{name}：接口 {interface} 不接受这些参数；检查通道名、--bitrate 和 --option（python-can报告：{problem}）",
        "{name}: interface {interface} does not accept these settings; look at the channel's name, --bitrate and "
        "--option (python-can says: {problem})",
    ),
    (
        "bus.refused",
        "{name}：接口 {interface} 打不开；检查适配器是否插好、通道名是否正确、是否被其他程序占用、有无权限"
        "（python-can报告：{problem}）",
        "{name}: interface {interface} cannot be opened; is the adapter plugged in, the channel's name right, no other "
        "program using it, and access allowed? (python-can says: {problem})",
    ),
    (
        "bus.gone",
        "{name}：接口 {interface} 不再能接收，适配器可能被拔出（python-can报告：{problem}）",
        "{name}: interface {interface} cannot be received from any more, the adapter may be unplugged (python-can "
        "says: {problem})",
    ),
    (
        "bus.rates",
        "波特率 {bitrate} 和 {data_bitrate} 不能同时设置（python-can报告：{problem}）；"
        "可用 --option 给出位时间，如 f_clock、nom_brp 等",
        "the rates {bitrate} and {data_bitrate} cannot be set together (python-can says: {problem}); --option can give "
        "the bit timing: f_clock, nom_brp and so on",
    ),
    # Recordings.
    (
        "record.suffix",
        "由文件名 {name} 看不出可记录的格式；--record 的文件名可以用 {allowed} 结尾",
        "{name} does not tell a format that can be recorded; a name for --record may end in {allowed}",
    ),
    ("record.twice", "--record {name} 给出了两次", "--record {name} is given twice"),
    ("record.needs", "{option} 要与 {other} 一起用", "{option} goes with {other}"),
    (
        "record.gone",
        "{name}：文件已不在原处，记录到此为止；监听继续",
        "{name}: the file is no longer there; the recording ends, the listening goes on",
    ),
    (
        "record.failed",
        "{name}：不能写入：{error}；记录到此为止，监听继续",
        "{name}: cannot be written: {error}; the recording ends, the listening goes on",
    ),
    (
        "record.no_file",
        "{name}：不是普通文件；--record 只能写入普通文件",
        "{name}: is not a regular file; --record writes to no other",
    ),
    ("record.kept", "{name}：不能删除：{error}", "{name}: cannot be deleted: {error}"),
    ("record.file", "已记录 {name}：{frames}帧，{size}", "recorded {name}: {frames} frames, {size}"),
    (
        "record.files",
        "已记录 {first} 到 {last}：{frames}帧，{files}个文件，{size}",
        "recorded {first} to {last}: {frames} frames, {files} files, {size}",
    ),
    ("record.deleted", "更早的{count}个已删除（{frames}帧）", "{count} older ones deleted ({frames} frames)"),
    ("record.broken_off", "中途中断", "broken off"),
)
