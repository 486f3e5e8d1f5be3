"""Python's own words: help, errors, headings.

Rows (key, zh, en), complete in both languages; a test keeps it. Words about frames stand in the core (`text/`), never
here, and nothing outside this file prints a sentence of its own.
"""

from typing import Final

LANGUAGES: Final = ("zh", "en")

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
        "只显示符合条件的帧，如 'service=sdo,emcy node=5 id=180-1FF bus=can1 t=1.0..2.5'；"
        "空格是“且”，逗号是“或”；状态仍由全部帧得出。t 的单位是秒：小于100000000时从记录的第一帧算起，否则是绝对时间。",
        "Show only what fits, e.g. 'service=sdo,emcy node=5 id=180-1FF bus=can1 t=1.0..2.5'; "
        "blank is and, comma is or; state still comes from every frame. t is in seconds: below 100000000 since the "
        "first frame of the capture, else absolute.",
    ),
    (
        "opt.stamps",
        "文件里的时间戳是什么：绝对时间、从零开始、与上一帧之差；auto 由内容判断。",
        "What the stamps of the input are: absolute, zero-based or deltas; auto decides by content.",
    ),
    (
        "opt.eds",
        "节点的设备描述（EDS、DCF、XDD），用来解析PDO里的信号和对象的名称；可重复。如 5=drive.eds；"
        "1-4,7=io.eds 由几个节点共用；can1:0x10=drive.eds 只用于一条总线；DCF写明了节点号时，只给文件即可。",
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
        "预定义之外的SDO通道：客户端到服务器和服务器到客户端的CAN-ID，以及服务器的节点号；可重复。如 640,5C0=5。",
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
        "被动式CANopen分析器：读candump的记录，结合此前的全部报文说明每一帧的含义。从不发送任何帧。",
        "A passive CANopen analyzer: reads candump captures and says what each frame means, given everything seen "
        "before it. It never sends a frame.",
    ),
    (
        "canalyze.examples",
        "canalyze decode samples/zephyr-sdo.log      逐帧注释一个记录\n"
        "candump can0 | canalyze decode -            实时注释\n"
        "canalyze explain '60A#4008100000000000'     逐字段解释一帧\n"
        "canalyze sdo capture.log --extract out/     列出SDO传输并取出数据\n"
        "canalyze signals --eds 5=drive.eds a.log    解析PDO里的信号\n"
        "canalyze summary --bitrate 500k capture.log 统计节点和总线负载\n"
        "canalyze --lang en decode --help            英文说明",
        "canalyze decode samples/zephyr-sdo.log      annotate a capture frame by frame\n"
        "candump can0 | canalyze decode -            annotate live\n"
        "canalyze explain '60A#4008100000000000'     explain one frame field by field\n"
        "canalyze sdo capture.log --extract out/     list SDO transfers, take out their data\n"
        "canalyze signals --eds 5=drive.eds a.log    decode the signals in PDOs\n"
        "canalyze summary --bitrate 500k capture.log figures of nodes and bus load\n"
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
    # decode
    ("decode.short", "逐帧注释记录", "Annotate captures frame by frame"),
    ("decode.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "decode.help",
        "逐帧注释记录：每行是candump屏幕格式的一帧，后面是它的含义。多个文件按给出的顺序当作同一个记录。"
        "“-”是标准输入；不给文件而有管道时也读标准输入，每一行立即输出。读不懂的行在标准错误上指出并计数，不会中断。",
        "Annotate captures: each line is a frame in candump's console form, followed by what it means. Several files "
        "are one capture in the given order. '-' is standard input, which is also read when no file is given and it "
        "is a pipe; every line comes out at once. Lines that cannot be read are named and counted on standard error "
        "and never stop the run.",
    ),
    ("decode.brief", "只写简短的说法，不带内容。", "Only the phrase, without the content."),
    (
        "decode.explain",
        "每帧下面再加以 # 开头的逐字段、逐位解释。",
        "Under each frame, as # lines, explain every field and bit.",
    ),
    (
        "decode.format",
        "text 给人看；jsonl 每行一个JSON对象。",
        "text for people; jsonl is one JSON object a line.",
    ),
    (
        "decode.time",
        "时间的写法，同candump：a 绝对，d 与上一帧之差，z 从零开始，A 日期和时间(UTC)，n 不写；不给则照原样。",
        "How stamps are written, as in candump: a absolute, d delta, z zero-based, A date and time in UTC, n none; "
        "without it as they came.",
    ),
    (
        "decode.examples",
        "canalyze decode capture.log\n"
        "canalyze decode --explain --filter 'service=sdo node=10' capture.log\n"
        "canalyze decode --eds 5=drive.eds --eds 1-4=io.eds capture.log\n"
        "canalyze decode part1.log part2.log -o all.txt\n"
        "candump -ta can0 | canalyze decode -\n"
        "canalyze decode --format jsonl capture.log | jq -r .text",
        "canalyze decode capture.log\n"
        "canalyze decode --explain --filter 'service=sdo node=10' capture.log\n"
        "canalyze decode --eds 5=drive.eds --eds 1-4=io.eds capture.log\n"
        "canalyze decode part1.log part2.log -o all.txt\n"
        "candump -ta can0 | canalyze decode -\n"
        "canalyze decode --format jsonl capture.log | jq -r .text",
    ),
    # explain
    ("explain.short", "逐字段解释一帧", "Explain one frame field by field"),
    ("explain.usage", "[选项] 帧...", "[OPTIONS] FRAME..."),
    (
        "explain.help",
        "逐字段、逐位解释一帧或几帧。帧可以是cansend的写法，也可以是贴进来的一行candump输出（引号可省）；“-”从标准输入逐行读，"
        "跳过空行和以 # 开头的行。"
        "单独的一帧没有上下文，所以只说它自身能说明的内容。",
        "Explain a frame, or several, every field and bit. A frame is in cansend's form or a pasted line of candump "
        "(quotes may be left out); '-' reads lines from standard input and skips blank lines and those that begin "
        "with #. A frame alone has no history, so only what it says by itself is said.",
    ),
    (
        "explain.examples",
        "canalyze explain '60A#4008100000000000'\n"
        "canalyze explain '60A#4008100000000000' '58A#4108100017000000'\n"
        "canalyze explain can1  58A   [8]  41 08 10 00 17 00 00 00\n"
        "canalyze explain '(1612345678.123456) can0 70A#05'\n"
        "tail -n 3 capture.log | canalyze explain -",
        "canalyze explain '60A#4008100000000000'\n"
        "canalyze explain '60A#4008100000000000' '58A#4108100017000000'\n"
        "canalyze explain can1  58A   [8]  41 08 10 00 17 00 00 00\n"
        "canalyze explain '(1612345678.123456) can0 70A#05'\n"
        "tail -n 3 capture.log | canalyze explain -",
    ),
    (
        "explain.no_frame",
        "这不是一帧：{line}；可以写成 60A#4008100000000000 或 can1  60A   [8]  40 08 10 00 00 00 00 00",
        "not a frame: {line}; write it as 60A#4008100000000000 or can1  60A   [8]  40 08 10 00 00 00 00 00",
    ),
    (
        "explain.no_frame_at",
        "{name}:{number}: 这不是一帧：{line}；可以写成 60A#4008100000000000 或 "
        "can1  60A   [8]  40 08 10 00 00 00 00 00",
        "{name}:{number}: not a frame: {line}; write it as 60A#4008100000000000 or "
        "can1  60A   [8]  40 08 10 00 00 00 00 00",
    ),
    (
        "explain.nothing",
        "没有给出帧；例如 canalyze explain '60A#4008100000000000'，或用 - 从标准输入读",
        "no frame given; e.g. canalyze explain '60A#4008100000000000', or - for standard input",
    ),
    (
        "explain.empty",
        "{name}：里面没有帧；每行给出一帧，如 60A#4008100000000000",
        "{name}: there is no frame in it; give one a line, such as 60A#4008100000000000",
    ),
    # sdo
    ("sdo.short", "列出SDO传输，取出其数据", "List SDO transfers, take out their data"),
    ("sdo.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "sdo.help",
        "列出SDO传输：对象、值、字节数、方式、耗时、结果。文件的给法与decode相同。",
        "List SDO transfers: object, value, size, mode, duration, outcome. Files are given as for decode.",
    ),
    ("sdo.format", "text 是表格；jsonl 每行一个传输。", "text is a table; jsonl is one transfer a line."),
    (
        "sdo.extract",
        "把每个传输的数据写入此目录，一个传输一个文件；没有成功的以其结果作后缀（.aborted .incomplete .failed）。",
        "Write the data of each transfer to this directory, one file each; those that did not succeed end in their "
        "outcome (.aborted .incomplete .failed).",
    ),
    (
        "sdo.examples",
        "canalyze sdo capture.log\n"
        "canalyze sdo capture.log --filter node=10 --extract out/\n"
        "canalyze sdo --format jsonl capture.log | jq -r 'select(.status != \"ok\")'\n"
        "candump can0 | canalyze sdo -",
        "canalyze sdo capture.log\n"
        "canalyze sdo capture.log --filter node=10 --extract out/\n"
        "canalyze sdo --format jsonl capture.log | jq -r 'select(.status != \"ok\")'\n"
        "candump can0 | canalyze sdo -",
    ),
    ("sdo.none", "{frames}帧中没有SDO传输", "no SDO transfer in {frames} frames"),
    (
        "sdo.extracted",
        "已将{files}个文件写入 {directory}",
        "files written to {directory}: {files}",
    ),
    (
        "sdo.kept",
        "{name}：文件已存在，未覆盖；要覆盖请加 --force",
        "{name}: exists and is kept; --force overwrites it",
    ),
    # signals
    ("signals.short", "列出PDO里的信号及其值", "List the signals in PDOs with their values"),
    ("signals.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "signals.help",
        "解析PDO里的信号，每个值一行：时间、帧、总线、节点、PDO、信号、值、原始值、单位、来源。"
        "映射来自记录里的SDO配置，其次是 --eds 或 canalyze.toml 给出的设备描述；来源说明是哪一个。"
        "文件的给法与decode相同。",
        "Decode the signals in PDOs, one value a line: t, frame, bus, node, pdo, signal, value, raw, unit, provenance. "
        "Mappings come from the configuration by SDO that the capture shows, else from the device descriptions of "
        "--eds or canalyze.toml; the provenance says which. Files are given as for decode.",
    ),
    (
        "signals.select",
        "只要这些信号：用逗号隔开的通配符，与“节点.信号”或信号的名称比较，如 '5.*,*velocity*'。",
        "Only these signals: globs with commas between, compared with node.signal or with the name of the signal, e.g. "
        "'5.*,*velocity*'.",
    ),
    (
        "signals.format",
        "csv 是带标题行的表格；jsonl 每行一个值。",
        "csv is a table with a line of headings; jsonl is one value a line.",
    ),
    (
        "signals.examples",
        "canalyze signals --eds 5=drive.eds capture.log\n"
        "canalyze signals --eds 5=drive.eds --select '5.*,*velocity*' capture.log -o velocity.csv\n"
        "canalyze signals --eds 1-4,7=io.eds --filter 'node=1 t=1.0..2.5' capture.log\n"
        "canalyze signals --format jsonl drive.log | jq -r '[.t, .signal, .value] | @tsv'\n"
        "candump -ta can0 | canalyze signals --eds 5=drive.eds -",
        "canalyze signals --eds 5=drive.eds capture.log\n"
        "canalyze signals --eds 5=drive.eds --select '5.*,*velocity*' capture.log -o velocity.csv\n"
        "canalyze signals --eds 1-4,7=io.eds --filter 'node=1 t=1.0..2.5' capture.log\n"
        "canalyze signals --format jsonl drive.log | jq -r '[.t, .signal, .value] | @tsv'\n"
        "candump -ta can0 | canalyze signals --eds 5=drive.eds -",
    ),
    (
        "signals.none",
        "{frames}帧中没有解析任何信号：没有已知映射的PDO；"
        "用 --eds 5=drive.eds 给出设备描述，或把配置过程（SDO）也录下来",
        "no signal decoded in {frames} frames: no PDO whose mapping is known; give a device description, as "
        "--eds 5=drive.eds, or capture the configuration by SDO too",
    ),
    (
        "signals.none_kept",
        "{frames}帧中没有符合 {options} 的信号；不加此条件仍然没有，则是PDO的映射未知："
        "用 --eds 5=drive.eds 给出设备描述",
        "no signal in {frames} frames fits {options}; if there is none without it either, no mapping of a PDO is "
        "known: give a device description, as --eds 5=drive.eds",
    ),
    # summary
    ("summary.short", "统计节点、总线负载、SYNC和发现", "Figures of nodes, bus load, SYNC and findings"),
    ("summary.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "summary.help",
        "统计一个记录：每个节点的名称、状态、启动报文、心跳间隔、SDO应答时间、中止、紧急报文和PDO速率；"
        "每条总线的帧数、负载、最长突发和错误帧；SYNC周期和同步PDO的延迟；按规则列出发现；以及记录本身的质量。"
        "文件的给法与decode相同；实时输入在Ctrl-C后给出统计。"
        "负载按每帧在总线上的实际位数计算：填充位由ID、数据和CRC逐帧算出，含3位帧间隔；错误帧不计位数，"
        "带BRS的CAN FD帧只计标称波特率的部分。"
        "p99取自对数分桶，最多偏大3.2%。--filter 只统计符合条件的帧；发现随其所在的帧计数。",
        "Figures of a capture: of each node its name, states, boot-ups, heartbeat interval, SDO response time, aborts, "
        "EMCYs and PDO rates; of each bus its frames, load, longest burst and error frames; the period of SYNC and the "
        "delay of synchronous PDOs; findings by rule; and the quality of the capture itself. Files are given as for "
        "decode; of a live input the figures come after Ctrl-C. Load counts the bits of every frame on the wire: stuff "
        "bits are computed from its identifier, data and CRC, with 3 bits between frames; error frames count no bits, "
        "and of CAN FD frames with bit rate switch only the part at the nominal rate counts. p99 comes from "
        "logarithmic buckets and is at most 3.2 % too high. With --filter only what fits is counted; a finding counts "
        "with its frame.",
    ),
    (
        "summary.format",
        "text 是表格；jsonl 每行一个JSON对象：记录、每条总线、SYNC、每个节点、每个PDO、每条规则。",
        "text is tables; jsonl is one JSON object a line: the capture, every bus, SYNC, node, PDO and rule.",
    ),
    (
        "summary.examples",
        "canalyze summary capture.log\n"
        "canalyze summary --bitrate 500k capture.log\n"
        "canalyze summary --eds 5=drive.eds part1.log part2.log\n"
        "canalyze summary --filter 't=10..20' --bitrate 1M capture.log\n"
        "canalyze summary --format jsonl capture.log | jq 'select(.kind == \"summary_node\")'\n"
        "candump -ta can0 | canalyze summary -",
        "canalyze summary capture.log\n"
        "canalyze summary --bitrate 500k capture.log\n"
        "canalyze summary --eds 5=drive.eds part1.log part2.log\n"
        "canalyze summary --filter 't=10..20' --bitrate 1M capture.log\n"
        "canalyze summary --format jsonl capture.log | jq 'select(.kind == \"summary_node\")'\n"
        "candump -ta can0 | canalyze summary -",
    ),
    ("summary.capture", "记录", "Capture"),
    ("summary.row_frames", "帧数", "frames"),
    ("summary.row_time", "时间", "time"),
    ("summary.row_quality", "质量", "quality"),
    ("summary.frames", "{frames}，文件数 {files}", "{frames}, files: {files}"),
    ("summary.time", "{first_t} 到 {last_t}，共 {seconds} s", "{first_t} to {last_t}, {seconds} s"),
    ("summary.no_stamps", "没有时间戳：没有时间、速率和负载", "no stamps: no times, rates and loads"),
    ("summary.unstamped", "没有时间戳的帧：{count}", "frames without a stamp: {count}"),
    (
        "summary.gaps",
        "丢帧：抓包程序报告 {count} 次，共 {frames} 帧；间隔时间不跨越丢帧处",
        "dropped: {frames} frames, in {count} reports; no interval is measured across a gap",
    ),
    ("summary.unreadable", "无法读取的行：{count}", "lines that cannot be read: {count}"),
    (
        "summary.backward",
        "时间戳倒退：{count} 次，最多 {most}",
        "stamps earlier than the one before: {count}, by {most} at most",
    ),
    (
        "summary.reordered",
        "乱序：{count} 个SDO请求记录在其应答之后；其应答时间不计",
        "out of order: {count} SDO requests captured after their response; such responses are not timed",
    ),
    ("summary.good", "无丢帧，无乱序，每行都能读取", "nothing dropped or out of order, every line read"),
    (
        "summary.pause",
        "最长的无帧时间：{ms} ms，到第{frame}帧为止",
        "longest time without a frame: {ms} ms, ended by frame {frame}",
    ),
    (
        "summary.buses",
        "总线（速率：帧/秒；峰值：1秒和100毫秒窗口）",
        "Buses (rates in frames/s; peaks in windows of 1 s and 100 ms)",
    ),
    (
        "summary.no_bit_rate",
        "要看总线负载，请给出波特率，如 --bitrate 500k 或 canalyze.toml 中的 bitrate = 500000",
        "for the bus load give the bit rate, as --bitrate 500k or bitrate = 500000 in canalyze.toml",
    ),
    (
        "summary.load",
        "负载：按 {rate} kbit/s，填充位逐帧算出，含帧间隔；不含错误帧",
        "load at {rate} kbit/s, with the exact stuff bits of each frame and the space between frames, without error "
        "frames",
    ),
    (
        "summary.fd",
        "带BRS的CAN FD帧：{count}；数据段的波特率未知，其位数不计，实际负载更高",
        "CAN FD frames with bit rate switch: {count}; the rate of their data is not known and its bits are not "
        "counted: the true load is higher",
    ),
    ("summary.burst", "{frames}帧/{ms} ms", "{frames} in {ms} ms"),
    ("summary.services", "服务", "Services"),
    (
        "summary.nodes",
        "节点（心跳：最小/平均/最大 ms；应答：最小/平均/p99/最大 ms；PDO：帧/秒）",
        "Nodes (heartbeat: min/mean/max in ms; response: min/mean/p99/max in ms; PDOs: frames/s)",
    ),
    (
        "summary.silent",
        "{bus}只被访问、没有发过任何帧的节点：{nodes}",
        "{bus}addressed, nothing came from them: {nodes}",
    ),
    ("summary.boot_up", "启动报文", "boot-up"),
    ("summary.commanded", "{state}（命令）", "{state} (commanded)"),
    ("summary.states", "状态的变化（从记录的第一帧算起，秒）", "States over time (seconds since the first frame)"),
    ("summary.at", "{seconds} {state}", "{seconds} {state}"),
    ("summary.at_frame", "第{frame}帧 {state}", "frame {frame} {state}"),
    ("summary.then", "，", ", "),
    ("summary.more_changes", "…共 {count} 次", "... {count} in all"),
    ("summary.aborts", "SDO中止", "SDO aborts"),
    ("summary.emcy", "紧急报文", "EMCYs"),
    ("summary.sync", "SYNC（周期：最小/平均/p99/最大 ms）", "SYNC (period: min/mean/p99/max in ms)"),
    (
        "summary.pdos",
        "PDO（间隔：最小/平均/最大 ms；SYNC之后的延迟：最小/平均/p99/最大 ms）",
        "PDOs (interval: min/mean/max in ms; delay after SYNC: min/mean/p99/max in ms)",
    ),
    ("summary.findings", "发现（首次和末次的帧号）", "Findings (first and last frame)"),
    ("summary.no_findings", "没有发现", "No findings"),
    ("summary.line", "第{line}行", "line {line}"),
    ("col.rate", "帧/秒", "frames/s"),
    ("col.rate_1s", "峰值/1s", "peak/1s"),
    ("col.rate_100ms", "峰值/100ms", "peak/100ms"),
    ("col.load", "负载", "load"),
    ("col.load_1s", "负载/1s", "load/1s"),
    ("col.load_100ms", "负载/100ms", "load/100ms"),
    ("col.burst", "最长突发", "longest burst"),
    ("col.errors", "错误帧", "error frames"),
    ("col.service", "服务", "service"),
    ("col.share", "占比", "share"),
    ("col.node_state", "状态", "state"),
    ("col.sent", "发出", "sent"),
    ("col.boot_ups", "启动", "boot-ups"),
    ("col.heartbeat", "心跳", "heartbeat"),
    ("col.transfers", "SDO", "SDO"),
    ("col.response", "应答", "response"),
    ("col.aborts", "中止", "aborts"),
    ("col.emcys", "EMCY", "EMCY"),
    ("col.tpdo_rate", "TPDO/秒", "TPDO/s"),
    ("col.rpdo_rate", "RPDO/秒", "RPDO/s"),
    ("col.states", "状态", "states"),
    ("col.by", "由", "by"),
    ("col.meaning", "含义", "meaning"),
    ("col.count", "次数", "count"),
    ("col.first", "首次", "first"),
    ("col.last", "末次", "last"),
    ("col.period", "周期", "period"),
    ("col.sigma", "标准差(ms)", "sigma (ms)"),
    ("col.counter", "计数器", "counter"),
    ("col.jumps", "跳变", "jumps"),
    ("col.id", "CAN-ID", "CAN-ID"),
    ("col.interval", "间隔", "interval"),
    ("col.synchronous", "同步", "synchronous"),
    ("col.delay", "延迟", "delay"),
    ("col.before_sync", "早于SYNC", "before SYNC"),
    ("col.buses", "总线", "buses"),
    ("col.nodes", "节点", "nodes"),
    # What is known of the network.
    (
        "network.no_node",
        "{name}：没有写明节点号；请指定，如 --eds 5={name}，或在 canalyze.toml 里写 node = 5",
        "{name}: names no node-ID; give one, as --eds 5={name} or as node = 5 in canalyze.toml",
    ),
    (
        "network.twice",
        "节点 {node} 有两个设备描述：{one} 和 {other}；只能用一个",
        "node {node} has two device descriptions, {one} and {other}; give one",
    ),
    (
        "network.other_node",
        "{name}：是节点 {own} 的DCF，现用于节点 {nodes}，其中不含$NODEID的值不随节点号改变",
        "{name}: the DCF of node {own}, used for {nodes}; values without $NODEID in it stay those of node {own}",
    ),
    (
        "network.defects",
        "{name}：已修复 {repaired} 处，未采用 {unused} 处；详见 {command}",
        "{name}: defects repaired: {repaired}, not used: {unused}; {command} shows them",
    ),
    (
        "usage.eds",
        "选项 {option} 不能是 {value}，可以写成 5=drive.eds、1-4,7=io.eds、can1:0x10=drive.eds 或 drive.dcf；"
        "节点号是1到127",
        "option {option}: {value} is not of the form 5=drive.eds, 1-4,7=io.eds, can1:0x10=drive.eds or drive.dcf; "
        "node-IDs are 1 to 127",
    ),
    (
        "usage.cob",
        "选项 {option} 不能是 {value}，可以写成 1A5=5.TPDO1、can1:1A5=5.RPDO2 或 000001A5=5.TPDO1（29位ID）；"
        "ID是十六进制，节点号是1到127，PDO编号是1到512",
        "option {option}: {value} is not of the form 1A5=5.TPDO1, can1:1A5=5.RPDO2 or 000001A5=5.TPDO1 (29-bit ID); "
        "IDs are hexadecimal, node-IDs 1 to 127, PDOs 1 to 512",
    ),
    (
        "usage.sdo",
        "选项 {option} 不能是 {value}，可以写成 640,5C0=5 或 can1:640,5C0=5；两个ID是不同的十六进制数，节点号是1到127",
        "option {option}: {value} is not of the form 640,5C0=5 or can1:640,5C0=5; the IDs are hexadecimal and two, "
        "node-IDs are 1 to 127",
    ),
    (
        "usage.period",
        "选项 {option} 不能是 {value}，可以是大于0、不超过4294秒的时间，如 1000（微秒）、10ms、0.01s",
        "option {option}: {value} is not a time above 0 and up to 4294 s, such as 1000 (microseconds), 10ms or 0.01s",
    ),
    (
        "usage.tolerance",
        "选项 {option} 不能是 {value}，可以是不超过4294秒的时间，如 200（微秒）、0.2ms、0",
        "option {option}: {value} is not a time up to 4294 s, such as 200 (microseconds), 0.2ms or 0",
    ),
    (
        "usage.bit_rate",
        "选项 {option} 不能是 {value}，可以是1k到1M，如 500000、125k、1M",
        "option {option}: {value} is not a bit rate from 1k to 1M, such as 500000, 125k or 1M",
    ),
    ("col.number", "#", "#"),
    ("col.time", "时间", "time"),
    ("col.relative", "相对(s)", "relative"),
    ("col.bus", "总线", "bus"),
    ("col.node", "节点", "node"),
    ("col.direction", "方向", "direction"),
    ("col.object", "对象", "object"),
    ("col.name", "名称", "name"),
    ("col.value", "值", "value"),
    ("col.size", "字节", "size"),
    ("col.mode", "方式", "mode"),
    ("col.duration", "耗时", "duration"),
    ("col.outcome", "结果", "outcome"),
    ("col.findings", "发现", "findings"),
    ("col.frames", "帧", "frames"),
    ("direction.upload", "上传(读)", "upload"),
    ("direction.download", "下载(写)", "download"),
    ("col.read_write", "读写", "access"),
    ("access.upload", "读", "read"),
    ("access.download", "写", "write"),
    ("mode.expedited", "加速", "expedited"),
    ("mode.segmented", "分段", "segmented"),
    ("mode.block", "块", "block"),
    ("status.ok", "完成", "ok"),
    ("status.aborted", "中止", "aborted"),
    ("status.incomplete", "不完整", "incomplete"),
    ("status.failed", "失败", "failed"),
    ("by.client", "客户端", "client"),
    ("by.server", "服务器", "server"),
    # eds
    ("eds.short", "说明一个设备描述文件（EDS、DCF）", "Show a device description (EDS, DCF)"),
    ("eds.usage", "[选项] 文件...", "[OPTIONS] FILE..."),
    (
        "eds.help",
        "说明设备描述文件：设备、通信对象及其值、各区域的对象数、PDO表（COB-ID、传输类型、时间、每个信号所占的位），"
        "以及文件本身的缺陷：修复了什么，什么没有采用。EDS、DCF和XDD都可以，编码和写法不规范的也能读。",
        "Show a device description: the device, its communication objects with their values, counts of all others, the "
        "PDO table (COB-ID, transmission type, times, bits of every signal), and the file's own defects: what was "
        "repaired and what could not be used. EDS, DCF and XDD are read, also in odd encodings and spellings.",
    ),
    (
        "eds.node",
        "用这个节点号算出COB-ID，十进制或0x十六进制；不给则用DCF里的节点号，都没有则写成$NODEID加偏移。",
        "Compute COB-IDs for this node-ID, decimal or 0x hexadecimal; else that of a DCF, else they stay $NODEID plus "
        "an offset.",
    ),
    ("eds.all", "列出全部对象，不只是通信对象。", "List every object, not only communication objects."),
    (
        "eds.format",
        "text 给人看；jsonl 每行一个JSON对象：文件、每个对象、每个PDO、每个缺陷。",
        "text for people; jsonl is one JSON object a line: the file, every object, every PDO, every defect.",
    ),
    (
        "eds.examples",
        "canalyze eds eds/drive.eds\n"
        "canalyze eds --node 5 eds/drive.eds\n"
        "canalyze eds --all eds/io.eds | less\n"
        "canalyze eds --format jsonl *.eds | jq -c 'select(.kind == \"defect\")'",
        "canalyze eds eds/drive.eds\n"
        "canalyze eds --node 5 eds/drive.eds\n"
        "canalyze eds --all eds/io.eds | less\n"
        "canalyze eds --format jsonl *.eds | jq -c 'select(.kind == \"defect\")'",
    ),
    (
        "eds.nothing",
        "{name}：里面没有一个CANopen对象；EDS和DCF里的对象写作 [1000] 这样的节",
        "{name}: there is no CANopen object in it; EDS and DCF have them as sections such as [1000]",
    ),
    ("eds.large", "{name}：大于 {most} MiB，不是设备描述文件", "{name}: larger than {most} MiB, no device description"),
    ("eds.xml", "{name}:{line}: 不是完整的XML：{problem}", "{name}:{line}: not well-formed XML: {problem}"),
    (
        "eds.doctype",
        "{name}：含有文档类型声明（DOCTYPE），不读；XDD不需要它",
        "{name}: has a document type declaration (DOCTYPE) and is not read; an XDD needs none",
    ),
    ("device.vendor", "厂商", "vendor"),
    ("device.product", "产品", "product"),
    ("device.revision", "修订号", "revision"),
    ("device.order_code", "订货号", "order code"),
    ("device.node", "节点号", "node-ID"),
    ("eds.no_node", "未指定", "not given"),
    ("device.bit_rate", "波特率", "bit rate"),
    ("device.bit_rates", "支持的波特率", "supported bit rates"),
    ("device.lss", "支持LSS", "LSS supported"),
    ("device.file_name", "文件名", "file name"),
    ("device.file_version", "文件版本", "file version"),
    ("device.eds_version", "EDS版本", "EDS version"),
    ("device.description", "说明", "description"),
    ("device.created", "创建", "created"),
    ("device.modified", "修改", "modified"),
    ("device.comments", "注释", "comments"),
    ("eds.yes", "是", "yes"),
    ("eds.no", "否", "no"),
    ("eds.objects", "对象", "Objects"),
    ("eds.communication_objects", "通信对象", "Communication objects"),
    ("eds.areas", "对象数", "Number of objects"),
    ("eds.pdos", "PDO", "PDOs"),
    ("eds.mapping", "映射", "Mapping"),
    ("eds.valid", "有效", "valid"),
    ("eds.invalid", "无效", "invalid"),
    ("eds.extended", "(29位)", "(29-bit)"),
    ("eds.assumed", "(预定义)", "(predefined)"),
    ("eds.dummy", "虚映射", "dummy"),
    ("eds.unknown", "文件里没有此对象", "not in the file"),
    ("eds.no_defects", "没有缺陷", "No defects"),
    ("eds.defects", "缺陷：{count}", "Defects: {count}"),
    ("eds.more_defects", "... {code} 还有 {count} 处", "... {count} more of {code}"),
    ("col.type", "类型", "type"),
    ("col.access", "访问", "access"),
    ("col.pdo_mapping", "可映射", "mappable"),
    ("col.limits", "范围", "limits"),
    ("col.unit", "单位", "unit"),
    ("col.range", "范围", "range"),
    ("col.area", "区域", "area"),
    ("col.objects", "对象", "objects"),
    ("col.entries", "子对象", "entries"),
    ("col.pdo", "PDO", "PDO"),
    ("col.cob_id", "COB-ID", "COB-ID"),
    ("col.state", "状态", "state"),
    ("col.rtr", "允许RTR", "RTR"),
    ("col.transmission", "传输类型", "transmission type"),
    ("col.inhibit", "抑制时间", "inhibit time"),
    ("col.event_timer", "事件定时器", "event timer"),
    ("col.sync_start", "同步起始值", "SYNC start"),
    ("col.bits", "位数", "bits"),
    ("col.bit", "位", "bit"),
    ("col.signal", "信号", "signal"),
    ("area.communication", "通信", "communication"),
    ("area.manufacturer", "制造商", "manufacturer"),
    ("area.profile", "设备规范", "device profile"),
    ("area.network", "网络变量", "network variables"),
    ("area.system", "系统变量", "system variables"),
    ("area.reserved", "保留", "reserved"),
    ("transmission.acyclic", "同步非循环", "synchronous, acyclic"),
    ("transmission.every", "同步循环, 每个SYNC", "synchronous, every SYNC"),
    ("transmission.cyclic", "同步循环, 每{n}个SYNC", "synchronous, every {n} SYNCs"),
    ("transmission.at_sync", "同步, 下一个SYNC生效", "synchronous, actuated at the next SYNC"),
    ("transmission.rtr_sync", "仅远程帧, SYNC时采样", "RTR only, sampled at SYNC"),
    ("transmission.rtr", "仅远程帧, 收到时采样", "RTR only, sampled on request"),
    ("transmission.event_manufacturer", "事件驱动(制造商定义)", "event-driven (manufacturer)"),
    ("transmission.event_profile", "事件驱动(设备规范定义)", "event-driven (device profile)"),
    ("transmission.at_once_manufacturer", "事件驱动, 立即生效(制造商定义)", "event-driven, at once (manufacturer)"),
    ("transmission.at_once_profile", "事件驱动, 立即生效(设备规范定义)", "event-driven, at once (device profile)"),
    ("transmission.reserved", "保留值", "reserved"),
    ("effect.repaired", "已修复", "repaired"),
    ("effect.unused", "未采用", "not used"),
    ("effect.noted", "注意", "note"),
    ("defect.encoding", "不是UTF-8，按 {encoding} 读取", "not UTF-8, read as {encoding}"),
    ("defect.bom", "以字节顺序标记开头，已跳过", "begins with a byte order mark, skipped"),
    ("defect.no-equals", "这一行没有“=”：{text}", "a line without '=': {text}"),
    ("defect.no-section", "这一行不在任何节里：{text}", "a line before any section: {text}"),
    ("defect.section-bracket", "{text} 缺少“]”，读作 {read}", "{text} lacks ']', read as {read}"),
    ("defect.section-name", "节名 [{section}] 读作 [{read}]", "section name [{section}] read as [{read}]"),
    ("defect.section-unused", "节名 [{section}] 读不懂", "section name [{section}] is not understood"),
    (
        "defect.duplicate-section",
        "节 [{section}] 在第{first}行已有，合并；相同的键以后面的为准",
        "section [{section}] is already on line {first}; joined, of equal keys the later one counts",
    ),
    (
        "defect.duplicate-key",
        "[{section}] 的 {key} 在第{first}行已有；采用后面的 {used}，不用 {other}",
        "{key} of [{section}] is already on line {first}; the later {used} is used, not {other}",
    ),
    (
        "defect.commissioning",
        "节名 [{section}] 按标准应写作 [DeviceComissioning]",
        "section [{section}] is spelled [DeviceComissioning] in the standard",
    ),
    (
        "defect.modules",
        "[{section}]：模块化设备，{count} 个模块的对象没有读入",
        "[{section}]: a modular device; the objects of its modules ({count}) are not read",
    ),
    ("defect.more", "{code} 还有 {count} 处没有列出", "{count} more of {code} are not listed"),
    ("defect.not-a-number", "{key}={value} 不是数", "{key}={value} is not a number"),
    ("defect.not-bytes", "{key}={value} 不是成对的十六进制字节", "{key}={value} is not bytes in hexadecimal"),
    ("defect.octal", "{key}={value} 以0开头，读作 {read}", "{key}={value} begins with 0, read as {read}"),
    ("defect.trailing-comment", "{key}={value} 后面有注释，读作 {read}", "{key}={value} has a comment, read as {read}"),
    ("defect.nodeid-form", "{key}={value} 写法不规范，读作 {read}", "{key}={value} is not well-formed, read as {read}"),
    (
        "defect.real-as-hex",
        "{key}={value} 是浮点数的位模式，读作 {read}",
        "{key}={value} is the bit pattern of a floating point number, read as {read}",
    ),
    (
        "defect.wrapped",
        "{key}={value} 超出类型的范围，按补码读作 {read}",
        "{key}={value} is beyond its type, read as two's complement: {read}",
    ),
    (
        "defect.out-of-range",
        "{key}={value} 放不进 {bits} 位的类型",
        "{key}={value} does not fit its type of {bits} bits",
    ),
    ("defect.node-id", "节点号 {value} 不在1到127之间", "node-ID {value} is not within 1 to 127"),
    ("defect.missing-key", "[{section}] 没有 {key}，用 {read}", "[{section}] lacks {key}, {read} is used"),
    ("defect.access", "{object} 的访问类型 {value} 读作 {read}", "access type {value} of {object} read as {read}"),
    (
        "defect.unknown-type",
        "{object} 的数据类型 {type} 未知，当作字节",
        "data type {type} of {object} is unknown, taken as bytes",
    ),
    (
        "defect.object-type",
        "{object} 的对象类型 {value} 与其子节不符，读作 {read}",
        "object type {value} of {object} does not suit its sections, read as {read}",
    ),
    (
        "defect.no-index-section",
        "{object} 只有子对象的节，没有自己的节",
        "{object} has sections of sub-objects but none of its own",
    ),
    (
        "defect.no-lists",
        "没有对象清单（MandatoryObjects 等），采用全部对象的节",
        "no lists of objects (MandatoryObjects and so on); all sections of objects are used",
    ),
    (
        "defect.unlisted",
        "{object} 不在任何对象清单里，仍然采用",
        "{object} is in no list of objects, used all the same",
    ),
    ("defect.not-there", "[{section}] 列出的 {object} 没有自己的节", "{object}, listed in [{section}], has no section"),
    (
        "defect.count",
        "[{section}] 的 {key} 是 {said}，实有 {found}",
        "{key} of [{section}] is {said}, there are {found}",
    ),
    (
        "defect.no-such-sub",
        "[{section}] 所指的子索引 {sub} 不存在",
        "[{section}] names sub-index {sub}, which is not there",
    ),
    ("defect.dummy-missing", "DummyUsage 没有 {keys}，当作0", "DummyUsage lacks {keys}, taken as 0"),
    (
        "defect.too-many",
        "子对象总数超过 {most}，{object} 的其余部分没有读入",
        "more than {most} sub-objects in all, the rest of {object} is not read",
    ),
    (
        "defect.cob-id",
        "{pdo} 的COB-ID {value} 未设29位标志，却有第11位以上的位",
        "COB-ID {value} of {pdo} is not marked as 29-bit but has bits above bit 10",
    ),
    ("defect.mapping-missing", "{pdo} 没有映射参数 {object}", "{pdo} has no mapping parameter {object}"),
    (
        "defect.mapping-count",
        "{pdo} 的映射 {object} 说有 {said} 项，有值的只有 {found} 项",
        "mapping {object} of {pdo} says {said} entries, but only {found} have a value",
    ),
    ("defect.mapping-length", "{pdo} 映射了 {bits} 位，最多 {most} 位", "{pdo} maps {bits} bits, at most {most} fit"),
    ("defect.mapped-unknown", "{pdo} 映射的 {object} 不在文件里", "{pdo} maps {object}, which is not in the file"),
    (
        "defect.mapped-size",
        "{pdo} 映射了 {object} 的 {bits} 位，而其类型是 {width} 位",
        "{pdo} maps {bits} bits of {object}, whose type has {width}",
    ),
    (
        "usage.node",
        "选项 {option} 不能是 {value}，可以是1到127",
        "option {option}: {value} is not a node-ID, 1 to 127",
    ),
    # rules
    ("rules.short", "列出或解释检查规则", "List the rules, or explain one"),
    ("rules.usage", "[选项] [代码]...", "[OPTIONS] [CODE]..."),
    (
        "rules.help",
        "列出检查规则；给出代码则解释它（大小写不限）。",
        "List the rules; with a code (in either case), explain it.",
    ),
    ("rules.format", "text 给人看；jsonl 每行一条规则。", "text for people; jsonl is one rule a line."),
    (
        "rules.examples",
        "canalyze rules\ncanalyze rules SDO001\ncanalyze rules --format jsonl",
        "canalyze rules\ncanalyze rules SDO001\ncanalyze rules --format jsonl",
    ),
    (
        "rules.unknown",
        "没有规则 {code}；全部规则见 canalyze rules",
        "no rule {code}; canalyze rules lists them",
    ),
    (
        "rules.near",
        "没有规则 {code}；最接近的是 {near}",
        "no rule {code}; the nearest are {near}",
    ),
    ("col.code", "代码", "code"),
    ("col.severity", "级别", "severity"),
    ("col.rule", "名称", "name"),
    ("col.message", "含义", "message"),
    ("severity.error", "错误", "error"),
    ("severity.warning", "警告", "warning"),
    ("severity.info", "提示", "info"),
    ("rules.clause", "依据", "clause"),
    ("rules.no_clause", "无", "none"),
    ("rules.meaning", "含义", "what it means"),
    ("rules.cause", "常见原因", "usual causes"),
    # Usage errors; {command} is what was typed, such as `canalyze decode`.
    ("usage.line", "{command}: {problem}；用法见 {command} --help", "{command}: {problem}; see {command} --help"),
    (
        "usage.core_line",  # {problem} is a sentence of the core, with its punctuation
        "{command}: {problem}; 用法见 {command} --help",
        "{command}: {problem}; see {command} --help",
    ),
    ("usage.no_option", "没有选项 {option}", "no such option: {option}"),
    ("usage.no_option_near", "没有选项 {option}，是 {near} 吗", "no such option: {option}, did you mean {near}"),
    ("usage.no_command", "没有命令 {name}", "no such command: {name}"),
    ("usage.no_command_near", "没有命令 {name}，是 {near} 吗", "no such command: {name}, did you mean {near}"),
    ("usage.or", " 或 ", " or "),
    ("usage.needs_value", "选项 {option} 需要一个值", "option {option} needs a value"),
    ("usage.takes_no_value", "选项 {option} 不带值", "option {option} takes no value"),
    (
        "usage.choice",
        "选项 {option} 不能是 {value}，可以是 {choices}",
        "option {option}: {value} is not one of {choices}",
    ),
    ("usage.missing", "缺少 {what}", "missing {what}"),
    ("usage.exclusive", "{one} 和 {other} 不能同时使用", "{one} and {other} exclude each other"),
    (
        "usage.text_only",
        "{option} 只用于 --format text",
        "{option} is only for --format text",
    ),
    (
        "usage.no_input",
        "没有给出文件；给出文件名，或用 - 读标准输入",
        "no file given; name a file, or - for standard input",
    ),
    # Configuration.
    (
        "config.lang_option",
        "--lang 不能是 {value}，可以是 zh 或 en",
        "--lang: {value} is neither zh nor en",
    ),
    (
        "config.lang_env",
        "环境变量 CANALYZE_LANG 不能是 {value}，可以是 zh 或 en",
        "CANALYZE_LANG: {value} is neither zh nor en",
    ),
    ("config.unreadable", "{file}：不能读取配置：{error}", "{file}: the configuration cannot be read: {error}"),
    (
        "config.broken",
        "{file}:{line}:{column}: 不是有效的TOML（解析器的原话：“{problem}”）",
        "{file}:{line}:{column}: not valid TOML (the parser says: {problem})",
    ),
    ("config.not_utf8", "{file}:{line}: 不是UTF-8编码的文本", "{file}:{line}: not text in UTF-8"),
    (
        "config.unknown",
        "{file}：没有配置项 {key}，可以有的是 {allowed}",
        "{file}: unknown key {key}; allowed: {allowed}",
    ),
    ("config.lacks", "{file}：缺少配置项 {key}", "{file}: key {key} is missing"),
    ("config.table", "{file}：配置项 {key} 应写成表 {table}", "{file}: key {key} has to be a table, {table}"),
    (
        "config.language",
        '{file}：配置项 {key} 不能是 {value}，可以是 "zh", "en"',
        '{file}: key {key}: {value} is not one of "zh", "en"',
    ),
    (
        "config.text",
        "{file}：配置项 {key} 不能是 {value}，应是引号里的文字",
        "{file}: key {key}: {value} is not a text in quotes",
    ),
    (
        "config.node",
        "{file}：配置项 {key} 不能是 {value}，可以是1到127的节点号",
        "{file}: key {key}: {value} is not a node-ID, 1 to 127",
    ),
    (
        "config.nodes",
        '{file}：配置项 {key} 不能是 {value}，可以是1到127的节点号，几个则写成 [1, 2] 或 "1-4,7"',
        '{file}: key {key}: {value} is not a node-ID, 1 to 127, nor several of them, as [1, 2] or "1-4,7"',
    ),
    (
        "config.can_id",
        '{file}：配置项 {key} 不能是 {value}，应是引号里的十六进制数，如 "1A5"，29位ID写满八位，如 "000001A5"',
        '{file}: key {key}: {value} is not a CAN-ID in hexadecimal and in quotes, such as "1A5", or "000001A5" for a '
        "29-bit one",
    ),
    (
        "config.one_id",
        "{file}：配置项 {key} 不能是 {value}，这是同一通道的另一个ID",
        "{file}: key {key}: {value} is the other ID of the same channel",
    ),
    (
        "config.pdo",
        '{file}：配置项 {key} 不能是 {value}，可以是 "TPDO1" 到 "TPDO512" 或 "RPDO1" 到 "RPDO512"',
        '{file}: key {key}: {value} is not a PDO, "TPDO1" to "TPDO512" or "RPDO1" to "RPDO512"',
    ),
    (
        "config.period",
        "{file}：配置项 {key} 不能是 {value}，应是大于0、不超过4294967295的微秒数",
        "{file}: key {key}: {value} is not a number of microseconds above 0 and up to 4294967295",
    ),
    (
        "config.tolerance",
        "{file}：配置项 {key} 不能是 {value}，应是0到4294967295的微秒数",
        "{file}: key {key}: {value} is not a number of microseconds, 0 to 4294967295",
    ),
    (
        "config.bit_rate",
        '{file}：配置项 {key} 不能是 {value}，可以是1000到1000000，或如 "125k"、"1M"',
        '{file}: key {key}: {value} is not a bit rate, 1000 to 1000000, or as "125k", "1M"',
    ),
    # Inputs and outputs.
    ("source.open", "{name}：不能打开：{error}", "{name}: cannot be opened: {error}"),
    ("source.read", "{name}：读取中断：{error}", "{name}: reading stopped: {error}"),
    ("source.empty", "{name}：里面什么都没有", "{name}: there is nothing in it"),
    (
        "source.nothing",
        "{name}：没有一行能读作CAN帧；可读的是candump的屏幕输出"
        "（can0  60A   [8]  40 ...）和记录（(时间) can0 60A#40...）",
        "{name}: no line of it can be read as a CAN frame; candump's console form (can0  60A   [8]  40 ...) and its "
        "log form ((stamp) can0 60A#40...) can",
    ),
    ("source.packed", "{name}：是{kind}压缩的；先解压：{line}", "{name}: {kind} compressed: {line}"),
    ("source.encoded", "{name}：是{kind}编码的文本；先转换：{line}", "{name}: text in {kind}: {line}"),
    (
        "source.other",
        "{name}：是{kind}文件，还不支持；目前只读candump的文本",
        "{name}: {kind}, not supported yet: only candump text",
    ),
    (
        "source.more_complaints",
        "{name}：此前还有{count}条同类提示",
        "{name}: {count} more such lines before this",
    ),
    ("output.exists", "{name}：文件已存在；要覆盖请加 --force", "{name}: exists; --force overwrites it"),
    ("output.write", "{name}：不能写入：{error}", "{name}: cannot be written: {error}"),
    ("output.stdout", "标准输出：不能写入：{error}", "standard output: cannot be written: {error}"),
    ("output.gone", "读取管道的程序已结束", "the reader of the pipe is gone"),
    (
        "output.english",
        "canalyze: 终端不能显示中文，改用英文；可用 --lang 指定",
        "canalyze: this terminal cannot show Chinese, so English is used; --lang chooses",
    ),
    ("progress.of", "{done}/{total} MB，{frames}帧", "{done}/{total} MB, {frames} frames"),
    ("progress.some", "{done} MB，{frames}帧", "{done} MB, {frames} frames"),
    (
        "core.missing",
        "编译好的核心不在（{problem}）；在源码目录里运行 pip install -e .",
        "the compiled core is missing ({problem}); run pip install -e . in the checkout",
    ),
    # Reasons of the operating system.
    ("os.missing", "没有这个文件或目录", "no such file or directory"),
    ("os.forbidden", "没有权限", "permission denied"),
    ("os.directory", "是目录，不是文件", "is a directory"),
    ("os.not_directory", "不是目录", "not a directory"),
    ("os.full", "磁盘已满", "no space left"),
    ("os.read_only", "文件系统是只读的", "read-only file system"),
    ("os.exists", "文件已存在", "file exists"),
    ("os.closed", "已经关闭", "it is closed"),
    ("os.io", "输入输出错误", "input/output error"),
    ("os.long_name", "文件名太长", "file name too long"),
)


class Words:
    """The words of one language: `words(key, **facts)` is the sentence."""

    def __init__(self, lang: str) -> None:
        """Take the column of `lang`, one of LANGUAGES."""
        self.lang = lang
        column = 1 + LANGUAGES.index(lang)
        self._table = {row[0]: row[column] for row in ROWS}

    def __call__(self, key: str, /, **facts: object) -> str:
        """Give the sentence of `key` with its facts filled in."""
        sentence = self._table[key]
        return sentence.format_map(facts) if facts else sentence

    def of(self, table: str, value: str) -> str:
        """Give the word for a value of the core, such as `block` of `mode`; the value itself if there is none."""
        return self._table.get(f"{table}.{value}", value)
