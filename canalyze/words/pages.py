"""The pages of help: their parts, the program's own page, options that several commands share.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    # Help: the parts of a page.
    ("help.usage", "用法：", "Usage: "),
    ("help.options", "选项", "Options"),
    ("help.commands", "命令", "Commands"),
    ("help.examples", "例子", "Examples"),
    ("help.completion", "命令行补全", "Shell completion"),
    # Options that every command has.
    ("opt.help", "显示这页说明。", "Show this page."),
    ("opt.version", "显示版本。", "Show the version."),
    (
        "opt.lang",
        "输出语言；先看此选项，再看环境变量 CANALYZE_LANG，再看 canalyze.toml，都没有则为 zh。",
        "Language of all words; else CANALYZE_LANG, else canalyze.toml, else zh.",
    ),
    (
        "opt.config",
        "配置文件；不给则用当前目录的 canalyze.toml（若有）。",
        "Configuration file; without it canalyze.toml of the current directory, if there is one.",
    ),
    # Options that several commands share.
    (
        "opt.output",
        "写入文件而不是标准输出；先写在旁边，完成后才改名。",
        "Write to a file instead of standard output; it is written beside and renamed when complete.",
    ),
    ("opt.force", "允许覆盖已有的文件。", "Overwrite files that exist."),
    (
        "opt.filter",
        "只取符合条件的帧，如 'service=sdo,emcy node=5 id=180-1FF bus=can1 t=1.0..2.5 frame=10-20'；"
        "空格是“且”，逗号是“或”；状态仍由全部帧得出。t 的单位是秒：小于100000000时从记录的第一帧算起，否则是绝对时间。",
        "Only what fits, e.g. 'service=sdo,emcy node=5 id=180-1FF bus=can1 t=1.0..2.5 frame=10-20'; "
        "blank is and, comma is or; state still comes from every frame. t is in seconds: below 100000000 since the "
        "first frame of the capture, else absolute.",
    ),
    (
        "opt.stamps",
        "文件里的时间戳是什么：绝对时间、从零开始、与上一帧之差；auto 由内容判断。",
        "What the stamps of the input are: absolute, zero-based or deltas; auto decides by content.",
    ),
    (
        "opt.input_format",
        "输入的格式，对所有输入有效；不给则由各文件的内容判断，与文件名无关。压缩总是由内容判断。",
        "The format of all inputs; without it the content of each tells, never its name. Compression is always told by "
        "content.",
    ),
    (
        "opt.merge",
        "把几个文件按时间合并成一个记录，而不是一个接一个；用于分段或按总线分开记录的文件。时间戳相同的按给出的顺序。"
        "同名的总线是同一条总线：两个适配器各自记录的同一总线会使每帧出现两次。只写当地时间的文件（如ASC）按UTC处理。",
        "Join the files by time into one capture, instead of one after the other: for recordings split into parts or "
        "by bus. Of equal stamps the file named first comes first. Buses of the same name are the same bus: two "
        "adapters' recordings of one bus would show every frame twice. Local dates, as in ASC, are taken as UTC.",
    ),
    (
        "opt.topic",
        "只读MCAP里名称匹配的topic；可重复，* 和 ? 为通配符。不给则读所有能读作CAN帧的topic。",
        "Read only the topics of an MCAP file that match; repeatable, with * and ?. Without it all topics of CAN "
        "frames.",
    ),
    (
        "opt.time_source",
        "MCAP消息的时间取自哪里：stamp 为驱动的header.stamp，publish 为发布时间，log 为记录时间；不给则按topic判断。"
        "publish 和 log 里的抖动不是总线上的抖动。",
        "Which time of an MCAP message counts: the driver's header.stamp, the time of publishing, or of recording; "
        "without it found out for each topic. Jitter of publish and log is not jitter of the bus.",
    ),
    (
        "opt.mcap_map",
        "MCAP消息里哪些字段是CAN帧，如 topic=/x,id=can_id,data=payload；可重复。"
        "键：id、data、ext、rtr、err、len、fd、brs、esi、bus、stamp。",
        "Which fields of an MCAP message are the frame, as in topic=/x,id=can_id,data=payload; repeatable. Keys: id, "
        "data, ext, rtr, err, len, fd, brs, esi, bus, stamp.",
    ),
    (
        "opt.eds",
        "节点的设备描述（EDS、DCF、XDD），用来解析PDO里的信号和对象的名称；可重复。如 5=drive.eds；"
        "1-4,7=io.eds 由几个节点共用；can1:0x10=drive.eds 只用于一条总线；DCF写明了节点ID时，只给文件即可。",
        "Device description (EDS, DCF, XDD) of a node, for the signals in its PDOs and the names of its objects; "
        "repeatable. E.g. 5=drive.eds; 1-4,7=io.eds is shared by several nodes; can1:0x10=drive.eds holds on one bus; "
        "the file alone where a DCF names its node.",
    ),
    (
        "opt.cob",
        "某个CAN-ID传的是哪个PDO；可重复。如 1A5=5.TPDO1；ID是十六进制，写满八位的是29位ID；"
        "can1:1A5=5.TPDO1 只用于一条总线。",
        "Which PDO a CAN-ID carries; repeatable. E.g. 1A5=5.TPDO1; the ID is hexadecimal, with eight digits it is a "
        "29-bit one; can1:1A5=5.TPDO1 holds on one bus.",
    ),
    (
        "opt.sdo",
        "预定义之外的SDO通道：客户端到服务器和服务器到客户端的CAN-ID，以及服务器的节点ID；可重复。如 640,5C0=5。",
        "An SDO channel beyond the pre-defined ones: CAN-ID from client to server, from server to client, and the "
        "server's node-ID; repeatable. E.g. 640,5C0=5.",
    ),
    (
        "opt.sync_period",
        "同步周期（1006h），单位是微秒，也可写成 10ms、0.01s；不给则由记录得出。",
        "Period of SYNC (1006h) in microseconds, or as 10ms, 0.01s; without it the capture tells.",
    ),
    (
        "opt.sync_window",
        "同步窗口的长度（1007h），写法同 --sync-period。",
        "Length of the synchronous window (1007h), written as for --sync-period.",
    ),
    (
        "opt.jitter",
        "判断时间时允许的时间戳误差，写法同 --sync-period，也可以是0；不给则由记录得出。",
        "Error of the stamps that is allowed for where time is judged, written as for --sync-period, also 0; without "
        "it the capture tells.",
    ),
    ("opt.bitrate", "总线的波特率，如 500000、125k、1M。", "Bit rate of the bus, e.g. 500000, 125k, 1M."),
    # canalyze
    ("canalyze.usage", "[选项] 命令 [参数]...", "[OPTIONS] COMMAND [ARGS]..."),
    (
        "canalyze.help",
        "被动式CANopen分析器：读CAN记录（candump、Vector ASC和BLF、MCAP、pcap、PEAK TRC、MF4等），或监听总线，"
        "结合此前的全部报文说明每一帧的含义，并在各种格式之间转换。从不发送任何帧。",
        "A passive CANopen analyzer: reads CAN captures (candump, Vector ASC and BLF, MCAP, pcap, PEAK TRC, MF4 and "
        "others) or listens to a bus, and says what each frame means, given everything seen before it; converts "
        "between their formats. It never sends a frame.",
    ),
    (
        "canalyze.examples",
        "canalyze decode samples/zephyr-sdo.log      逐帧注释一个记录\n"
        "canalyze sniff can0 --record bus.mcap       实时注释，同时记录\n"
        "canalyze explain '60A#4008100000000000'     逐字段解释一帧\n"
        "canalyze sdo capture.log --extract out/     列出SDO传输并取出数据\n"
        "canalyze signals --eds 5=drive.eds a.log    解析PDO里的信号\n"
        "canalyze summary --bitrate 500k capture.log 统计节点和总线负载\n"
        "canalyze check 'captures/**/*.log'          检查记录，供CI使用\n"
        "canalyze info capture.mcap                  说明文件本身：格式、总线、时间、损坏\n"
        "canalyze convert capture.asc capture.log    转换格式\n"
        "canalyze --lang en decode --help            英文说明",
        "canalyze decode samples/zephyr-sdo.log      annotate a capture frame by frame\n"
        "canalyze sniff can0 --record bus.mcap       annotate a live bus and record it\n"
        "canalyze explain '60A#4008100000000000'     explain one frame field by field\n"
        "canalyze sdo capture.log --extract out/     list SDO transfers, take out their data\n"
        "canalyze signals --eds 5=drive.eds a.log    decode the signals in PDOs\n"
        "canalyze summary --bitrate 500k capture.log figures of nodes and bus load\n"
        "canalyze check 'captures/**/*.log'          findings of many captures, for CI\n"
        "canalyze info capture.mcap                  what a file is: format, buses, time, damage\n"
        "canalyze convert capture.asc capture.log    convert to another format\n"
        "canalyze --lang zh decode --help            help in Chinese",
    ),
    (
        "canalyze.completion",
        'bash   eval "$(_CANALYZE_COMPLETE=bash_source canalyze)"    写入 ~/.bashrc\n'
        'zsh    eval "$(_CANALYZE_COMPLETE=zsh_source canalyze)"     写入 ~/.zshrc\n'
        "fish   _CANALYZE_COMPLETE=fish_source canalyze | source     写入 config.fish",
        'bash   eval "$(_CANALYZE_COMPLETE=bash_source canalyze)"    in ~/.bashrc\n'
        'zsh    eval "$(_CANALYZE_COMPLETE=zsh_source canalyze)"     in ~/.zshrc\n'
        "fish   _CANALYZE_COMPLETE=fish_source canalyze | source     in config.fish",
    ),
)
