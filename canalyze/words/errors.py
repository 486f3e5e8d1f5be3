"""Errors: wrong usage, configuration, what is known of the network, inputs and outputs.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
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
    (
        "usage.node",
        "选项 {option} 不能是 {value}，可以是1到127",
        "option {option}: {value} is not a node-ID, 1 to 127",
    ),
    # What is known of the network.
    (
        "network.no_node",
        "{name}：没有写明节点ID；请指定，如 --eds 5={name}，或在 canalyze.toml 里写 node = 5",
        "{name}: names no node-ID; give one, as --eds 5={name} or as node = 5 in canalyze.toml",
    ),
    (
        "network.twice",
        "节点 {node} 有两个设备描述：{one} 和 {other}；只能用一个",
        "node {node} has two device descriptions, {one} and {other}; give one",
    ),
    (
        "network.other_node",
        "{name}：是节点 {own} 的DCF，现用于节点 {nodes}，其中不含$NODEID的值不随节点ID改变",
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
        "节点ID是1到127",
        "option {option}: {value} is not of the form 5=drive.eds, 1-4,7=io.eds, can1:0x10=drive.eds or drive.dcf; "
        "node-IDs are 1 to 127",
    ),
    (
        "usage.cob",
        "选项 {option} 不能是 {value}，可以写成 1A5=5.TPDO1、can1:1A5=5.RPDO2 或 000001A5=5.TPDO1（29位ID）；"
        "ID是十六进制，节点ID是1到127，PDO编号是1到512",
        "option {option}: {value} is not of the form 1A5=5.TPDO1, can1:1A5=5.RPDO2 or 000001A5=5.TPDO1 (29-bit ID); "
        "IDs are hexadecimal, node-IDs 1 to 127, PDOs 1 to 512",
    ),
    (
        "usage.sdo",
        "选项 {option} 不能是 {value}，可以写成 640,5C0=5 或 can1:640,5C0=5；两个ID是不同的十六进制数，节点ID是1到127",
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
        "{file}:{line}:{column}：不是有效的TOML（解析器的原话：“{problem}”）",
        "{file}:{line}:{column}: not valid TOML (the parser says: {problem})",
    ),
    (
        "config.large",
        "{file}：超过 {most} MiB，不读取",
        "{file}: more than {most} MiB; not read",
    ),
    (
        "config.deep",
        "{file}:{line}：嵌套超过 {most} 层，不读取",
        "{file}:{line}: nested more than {most} deep; not read",
    ),
    (
        "config.long",
        "{file}:{line}：有一个数或键超过 {most} 个字符，不读取",
        "{file}:{line}: a number or a key of more than {most} characters; not read",
    ),
    ("config.not_utf8", "{file}:{line}：不是UTF-8编码的文本", "{file}:{line}: not text in UTF-8"),
    (
        "config.unknown",
        "{file}：没有配置项 {key}，可以有的是 {allowed}",
        "{file}: unknown key {key}; allowed: {allowed}",
    ),
    (
        "config.unknown_near",
        "{file}：没有配置项 {key}，是 {near} 吗；可以有的是 {allowed}",
        "{file}: unknown key {key}, did you mean {near}; allowed: {allowed}",
    ),
    ("config.lacks", "{file}：缺少配置项 {key}", "{file}: key {key} is missing"),
    ("config.table", "{file}：配置项 {key} 应写成表 {table}", "{file}: key {key} has to be a table, {table}"),
    (
        "config.choice",
        "{file}：配置项 {key} 不能是 {value}，可以是 {allowed}",
        "{file}: key {key}: {value} is not one of {allowed}",
    ),
    (
        "config.text",
        "{file}：配置项 {key} 不能是 {value}，应是引号里的文字，不能为空",
        "{file}: key {key}: {value} is not a text in quotes, or is empty",
    ),
    (
        "config.node",
        "{file}：配置项 {key} 不能是 {value}，可以是1到127的节点ID",
        "{file}: key {key}: {value} is not a node-ID, 1 to 127",
    ),
    (
        "config.nodes",
        '{file}：配置项 {key} 不能是 {value}，可以是1到127的节点ID，几个则写成 [1, 2] 或 "1-4,7"',
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
    (
        "source.channel",
        "{name}：不能打开：{error}；要监听总线，请用 canalyze sniff {name}",
        "{name}: cannot be opened: {error}; canalyze sniff {name} listens to a bus",
    ),
    ("source.read", "{name}：读取中断：{error}", "{name}: reading stopped: {error}"),
    ("source.empty", "{name}：里面什么都没有", "{name}: there is nothing in it"),
    (
        "source.nothing",
        "{name}：没有CAN帧，不是可读的格式；可读的有candump的屏幕输出（can0  60A   [8]  40 ...）和记录"
        "（(时间) can0 60A#40...）、Vector ASC和BLF、MCAP、pcap、pcapng、PEAK TRC、MF4，以及python-can的CSV和SQLite，"
        "也可以是压缩过的",
        "{name}: no CAN frame in it, and none of the formats that can be read: candump's console form "
        "(can0  60A   [8]  40 ...) and its log form ((stamp) can0 60A#40...), Vector ASC and BLF, MCAP, pcap, pcapng, "
        "PEAK TRC, MF4, python-can's CSV and SQLite, each also compressed",
    ),
    (
        "source.nested",
        "{name}：{outer}压缩里面还是{inner}压缩；只解一层，请先解开外层",
        "{name}: {inner} compressed inside {outer}; only one compression is undone, undo the outer one first",
    ),
    (
        "merge.no_stamps",
        "{name}：帧没有时间戳，不能用 --merge 按时间合并",
        "{name}: its frames have no stamps, so --merge cannot join it by time",
    ),
    (
        "merge.no_clock",
        "{name} 的时间戳是绝对时间，{other} 的从零开始且不知起点；二者没有共同的时钟，不能用 --merge 合并",
        "the stamps of {name} are absolute, those of {other} count from a start that is not told: --merge finds no "
        "clock that they share",
    ),
    (
        "source.frameless",
        "{name}：作为{form}读取，里面没有CAN帧；文件里有什么，见 canalyze info",
        "{name}: read as {form}, no CAN frame in it; canalyze info shows what it has",
    ),
    (
        "source.unfit",
        "{name}：作为{form}读取，里面没有CAN帧；--input-format 可以是 {formats}；不给出时自动识别",
        "{name}: read as {form}, no CAN frame in it; --input-format takes {formats}; without it the format is told by "
        "the content",
    ),
    (
        "bridge.unfit",
        "{name}：不能作为{form}读取（python-can报告：{problem}）；--input-format 可以是 {formats}；不给出时自动识别",
        "{name}: cannot be read as {form} (python-can says: {problem}); --input-format takes {formats}; without it the "
        "format is told by the content",
    ),
    (
        "source.implausible",
        "{name}：作为{form}读取，但大多数记录按两种字节序都不是CAN标识符；未读取任何帧",
        "{name}: read as {form}, but most records hold no CAN identifier in either byte order; no frame was read",
    ),
    ("bridge.said", "{name}：python-can报告：{problem}", "{name}: python-can says: {problem}"),
    (
        "bridge.unreadable",
        "{name}：不能作为{form}读取（python-can报告：{problem}）",
        "{name}: cannot be read as {form} (python-can says: {problem})",
    ),
    (
        "bridge.computed",
        "{name}：其中的{table}不是表，而是视图，或有算出的列；这样的数据库不读取",
        "{name}: {table} in it is no table but a view, or has computed columns; such a database is not read",
    ),
    (
        "bridge.mf4",
        "{name}：MF4文件需要asammdf，尚未安装；安装：{line}",
        "{name}: MF4 needs asammdf, which is not installed: {line}",
    ),
    (
        "source.no_topic",
        "{name}：没有一个topic读作CAN帧；文件里有：{topics}。用 --topic 选择，用 --mcap-map 说明字段，"
        "如 --mcap-map topic=/x,id=can_id,data=payload",
        "{name}: no topic of it is read as CAN frames; there are: {topics}. Choose with --topic, name the fields with "
        "--mcap-map, as in --mcap-map topic=/x,id=can_id,data=payload",
    ),
    (
        "source.other",
        "{name}：转换编码后仍是{kind}，不能读取",
        "{name}: still {kind} after it was decoded once; cannot be read",
    ),
    (
        "source.more_complaints",
        "{name}：此前还有{count}条同类提示",
        "{name}: {count} more such lines before this",
    ),
    ("output.exists", "{name}：文件已存在；要覆盖请加 --force", "{name}: exists; --force overwrites it"),
    ("output.write", "{name}：不能写入：{error}", "{name}: cannot be written: {error}"),
    (
        "output.part",
        "{name}：已中断，此前读到的内容保存在 {part}",
        "{name}: interrupted; what was read by then is in {part}",
    ),
    (
        "output.cut",
        "{name}：已中断，只含此前读到的内容",
        "{name}: interrupted, holds only what was read by then",
    ),
    ("output.dropped", "{name}：已中断，没有写出", "{name}: interrupted, nothing was written"),
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
    ("os.large", "文件太大", "file too large"),
    ("os.quota", "磁盘配额已满", "disk quota exceeded"),
    ("os.long_name", "文件名太长", "file name too long"),
)
