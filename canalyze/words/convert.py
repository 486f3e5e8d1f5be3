"""What `canalyze convert` says of itself: its page of help, its own options and errors.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("convert.short", "转换记录的格式", "Convert captures to another format"),
    ("convert.usage", "[选项] 输入... 输出", "[OPTIONS] IN... OUT"),
    (
        "convert.help",
        "把记录转换成另一种格式，格式由输出的文件名决定，或由 --to 指定。多个输入按给出的顺序当作同一个记录。"
        "“-”是标准输入或标准输出。"
        "帧、时间戳、总线名、方向、CAN FD标志、远程帧和错误帧都保留；目标格式容纳不下的，逐种计数，写到标准错误。"
        "文件名再以 .gz、.zst、.xz 或 .bz2 结尾就同时压缩。输出先写在旁边，完成时才改名；"
        "中断时已读到的内容留在以 .part 结尾的文件里，但输入若是管道，则仍写入输出文件。",
        "Convert captures to another format, told by the name of the output or by --to. Several inputs are one capture "
        "in the given order. '-' is standard input or standard output. Frames, stamps, bus names, directions, "
        "CAN FD flags, remote and error frames are kept; what the format cannot hold is counted by kind and said on "
        "standard error. A name that ends in .gz, .zst, .xz or .bz2 as well gets it compressed. The output is written "
        "beside its name and renamed when complete; an interrupted run leaves what was read by then in a file that "
        "ends in .part, but of a pipe it is written under the name.",
    ),
    (
        "convert.decoded",
        "MCAP：另写入解码后的topic：每个PDO的信号、NMT状态、驱动器状态、EMCY、SDO传输和发现，"
        "Foxglove、PlotJuggler 直接显示；Rerun 用 canalyze view 输出.mcap --save 输出.rbl 写出的布局显示。",
        "MCAP: topics of what the frames mean as well: signals of each PDO, NMT states, states of drives, EMCY, SDO "
        "transfers, findings; Foxglove and PlotJuggler show them as they are, Rerun with the layout that canalyze view "
        "OUT.mcap --save OUT.rbl writes.",
    ),
    (
        "convert.fd_schema",
        "MCAP：CAN FD帧的消息类型。ros2 最常用，不含BRS和ESI；dataspeed 含有。",
        "MCAP: type of the messages of CAN FD frames. ros2 is the usual one and lacks BRS and ESI; dataspeed has them.",
    ),
    (
        "convert.archive",
        "MCAP：不写消息索引，文件约小四成；有的读取程序不接受这种文件。",
        "MCAP: without message indexes; files are some 40 % smaller, and some programs refuse them.",
    ),
    ("convert.to", "输出的格式；不给则由文件名决定。", "Format of the output; without it, told by its name."),
    (
        "convert.examples",
        "canalyze convert capture.asc capture.log\n"
        "canalyze convert part1.asc part2.asc all.mcap\n"
        "canalyze convert --filter 'node=5 t=10..20' capture.log node5.log.zst\n"
        "candump -L can0 | canalyze convert - capture.pcapng\n"
        "canalyze convert capture.blf --to candump - | canplayer vcan0=can0",
        "canalyze convert capture.asc capture.log\n"
        "canalyze convert part1.asc part2.asc all.mcap\n"
        "canalyze convert --filter 'node=5 t=10..20' capture.log node5.log.zst\n"
        "candump -L can0 | canalyze convert - capture.pcapng\n"
        "canalyze convert capture.blf --to candump - | canplayer vcan0=can0",
    ),
    (
        "convert.one",
        "只给出了 {name}；先写输入，最后写输出，如 canalyze convert {name} {out}",
        "only {name} is given; name the inputs, then the output, as canalyze convert {name} {out}",
    ),
    (
        "convert.none",
        "没有给出文件；先写输入，最后写输出，如 canalyze convert capture.asc capture.log",
        "no file given; name the inputs, then the output, as canalyze convert capture.asc capture.log",
    ),
    ("convert.stdout", "标准输出", "standard output"),
    (
        "convert.suffix",
        "由文件名 {name} 看不出格式；文件名可以用 {allowed} 结尾（再加 {packed} 即压缩），或用 --to 指定",
        "{name} does not tell a format; a name may end in {allowed} (and {packed} to compress), or --to says it",
    ),
    (
        "convert.needs_to",
        "写到标准输出时要用 --to 指定格式：{choices}",
        "standard output needs --to with a format: {choices}",
    ),
    (
        "convert.no_stdout",
        "{form} 只能写到文件，不能写到标准输出",
        "{form} can only be written to a file, not to standard output",
    ),
    (
        "convert.no_compression",
        "{name}：{form} 文件不能同时压缩",
        "{name}: files of the format {form} cannot be compressed on the way",
    ),
    (
        "convert.terminal",
        "{form} 是二进制格式，不写到终端；请给出文件名，或重定向",
        "{form} is binary and not written to a terminal; name a file, or redirect it",
    ),
    ("convert.mcap_only", "{option} 只用于MCAP", "{option} is only for MCAP"),
    (
        "convert.itself",
        "{name}：就是输入文件本身；要用结果替换它请加 --force",
        "{name}: is the input itself; --force replaces it by the result",
    ),
    (
        "convert.kept",
        "{name}：没有读完，原文件保持不变",
        "{name}: was not read to its end and stays as it is",
    ),
    (
        "convert.cut",
        "{name}：已中断，写出的是此前读到的{frames}帧",
        "{name}: interrupted, holds the {frames} frames read by then",
    ),
)
