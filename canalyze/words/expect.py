"""Words about expectations: mistakes in their file, and the command that writes a first version.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    # expect
    ("expect.short", "由一个好的记录写出期望的第一版", "Write a first version of expectations from a good capture"),
    ("expect.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "expect.help",
        "由一个好的记录写出期望的第一版：按顺序写入的配置、设备标识、各节点到达的状态、心跳、同步和PDO的周期、信号的范围、"
        "可以出现的紧急报文和问题、SDO应答时间和总线负载的上限（要有波特率），每个数旁边注明记录里看到的。期望是一个TOML文件，"
        "用 canalyze check --expect 检验别的记录，也可放在记录旁边（boot.log 旁的 boot.expect.toml 自动使用）。"
        "不满足的期望是一条发现（EXP开头），指出期望的文件和行。各表可以出现多次，"
        "每个表都可以有 bus；全部配置项见下面的例子。"
        "几个文件同 decode 一样是一个记录。",
        "Write a first version of expectations from a good capture: the configuration that was written, in its "
        "order; the identity of devices; the states that nodes reached; periods of heartbeats, SYNC and PDOs; "
        "ranges of signals; the EMCYs and problems that may occur; limits for SDO responses and bus load (with a bit "
        "rate), each with what was seen. Expectations are a TOML file by which canalyze check --expect judges other "
        "captures; it can also lie beside a capture (boot.expect.toml beside boot.log is used by itself). One that "
        "is not met is a finding (EXP...) that names the file and line of the expectation. Every table may come "
        "several times, and each may have a bus; all keys are in the example below. Several files are one capture, "
        "as for decode.",
    ),
    (
        "expect.examples",
        "canalyze expect boot.log -o boot.expect.toml\n"
        "canalyze expect --bitrate 500k --eds 5=drive.eds boot.log -o boot.expect.toml\n"
        "canalyze check boot.log\n"
        "canalyze check --expect boot.expect.toml build/*.log\n"
        "\n"
        "[[sdo]]                      # 必须发生的SDO传输\n"
        "node = 5\n"
        'object = "1017:00"           # 十六进制，子索引在冒号后\n'
        'direction = "download"       # "upload"\n'
        'value = 1000                 # 数、true、"文字"；或 data = "E8 03"\n'
        'outcome = "ok"               # "aborted", "any"; abort = "06010002"\n'
        'sequence = "boot"            # 同名的必须按文件里的顺序发生\n'
        '# count = 2  never = true  within_s = 2.5  bus = "can1"\n'
        "\n"
        "[[state]]                    # 节点必须到达的状态\n"
        "node = 5\n"
        'state = "operational"        # "boot-up", "stopped", "pre-operational"\n'
        '                             # 或 drive = "operation-enabled"，axis = 1\n'
        "by_s = 2.5\n"
        'since = "boot-up"            # "start"\n'
        "stays = true\n"
        "\n"
        "[[signal]]                   # 没有min、max和周期时，只要求出现\n"
        'select = "5.TPDO4.606C:00"   # 写法同 signals --select\n'
        "min = -10\n"
        "max = 10\n"
        "period_ms = 10               # period_us\n"
        "tolerance_percent = 10       # tolerance_ms, tolerance_us\n"
        "\n"
        "[[heartbeat]]\n"
        "node = 5\n"
        "period_ms = 1000\n"
        "tolerance_ms = 100\n"
        "\n"
        "[[sync]]\n"
        "period_us = 10000\n"
        "tolerance_us = 100\n"
        "\n"
        "[[emcy]]                     # 没有code：没有may或must允许的都算\n"
        "node = 5\n"
        'code = "81xx"\n'
        'occurs = "never"             # "must", "may"\n'
        "\n"
        "[[incident]]                 # canalyze diagnose 所说的问题；没有kind：不由其他问题引起的任何一种\n"
        'kind = "node-silent"         # 也可用 * 和 ?；没有kind的 occurs = 0 不含别处允许的\n'
        "node = 5\n"
        'occurs = 1                   # 0：不得出现；"1-3"、"1-"\n'
        "ends_within_s = 2            # 从第一个迹象到恢复\n"
        '# cause = "bus-off"          # 由哪一种问题引起\n'
        "\n"
        "[[latency]]                  # 应答时间；SYNC之后的PDO；NMT命令之后的状态\n"
        'of = "sdo"                   # "sync" (pdo = "TPDO1"), "nmt"\n'
        "node = 5\n"
        'object = "1018:01"\n'
        "max_ms = 20                  # max_us\n"
        "\n"
        "[[load]]\n"
        "max_percent = 60\n"
        'bitrate = "500k"\n'
        "window_ms = 100",
        "canalyze expect boot.log -o boot.expect.toml\n"
        "canalyze expect --bitrate 500k --eds 5=drive.eds boot.log -o boot.expect.toml\n"
        "canalyze check boot.log\n"
        "canalyze check --expect boot.expect.toml build/*.log\n"
        "\n"
        "[[sdo]]                      # a transfer that must occur\n"
        "node = 5\n"
        'object = "1017:00"           # hexadecimal, sub-index behind the colon\n'
        'direction = "download"       # "upload"\n'
        'value = 1000                 # a number, true, "text"; or data = "E8 03"\n'
        'outcome = "ok"               # "aborted", "any"; abort = "06010002"\n'
        'sequence = "boot"            # those of one name occur in the order of the file\n'
        '# count = 2  never = true  within_s = 2.5  bus = "can1"\n'
        "\n"
        "[[state]]                    # a state that the node must reach\n"
        "node = 5\n"
        'state = "operational"        # "boot-up", "stopped", "pre-operational"\n'
        '                             # or drive = "operation-enabled", axis = 1\n'
        "by_s = 2.5\n"
        'since = "boot-up"            # "start"\n'
        "stays = true\n"
        "\n"
        "[[signal]]                   # without min, max and period it must just occur\n"
        'select = "5.TPDO4.606C:00"   # as for signals --select\n'
        "min = -10\n"
        "max = 10\n"
        "period_ms = 10               # period_us\n"
        "tolerance_percent = 10       # tolerance_ms, tolerance_us\n"
        "\n"
        "[[heartbeat]]\n"
        "node = 5\n"
        "period_ms = 1000\n"
        "tolerance_ms = 100\n"
        "\n"
        "[[sync]]\n"
        "period_us = 10000\n"
        "tolerance_us = 100\n"
        "\n"
        "[[emcy]]                     # without code: what no may or must entry covers\n"
        "node = 5\n"
        'code = "81xx"\n'
        'occurs = "never"             # "must", "may"\n'
        "\n"
        "[[incident]]                 # a problem as told by canalyze diagnose; without kind: any but consequences\n"
        'kind = "node-silent"         # with * and ?; an occurs = 0 without kind leaves out what others allow\n'
        "node = 5\n"
        'occurs = 1                   # 0: must not; "1-3", "1-"\n'
        "ends_within_s = 2            # from its first evidence until it is over\n"
        '# cause = "bus-off"          # the kind of problem that it comes from\n'
        "\n"
        "[[latency]]                  # of a response; of a PDO after SYNC; of a state after NMT\n"
        'of = "sdo"                   # "sync" (pdo = "TPDO1"), "nmt"\n'
        "node = 5\n"
        'object = "1018:01"\n'
        "max_ms = 20                  # max_us\n"
        "\n"
        "[[load]]\n"
        "max_percent = 60\n"
        'bitrate = "500k"\n'
        "window_ms = 100",
    ),
    (
        "expect.not_good",
        "这个记录有级别高于“提示”的发现：{codes}；由它得出的期望未必正确",
        "the capture has findings above info: {codes}; what is expected from it may be wrong",
    ),
    # Values of keys; {file} is FILE:LINE.
    (
        "config.object",
        '{file}：配置项 {key} 不能是 {value}，应是引号里的十六进制索引和子索引，如 "1017:00"、"0x1018:04"',
        '{file}: key {key}: {value} is not index and sub-index in hexadecimal and in quotes, such as "1017:00" or '
        '"0x1018:04"',
    ),
    (
        "config.value",
        "{file}：配置项 {key} 不能是 {value}，可以是64位以内的数、true、false或引号里的文字；十六进制的字节用 data",
        "{file}: key {key}: {value} is not a number of up to 64 bits, true, false or a text in quotes; bytes in "
        "hexadecimal are for data",
    ),
    (
        "config.data",
        '{file}：配置项 {key} 不能是 {value}，应是引号里的十六进制字节，如 "E8 03"',
        '{file}: key {key}: {value} is not bytes in hexadecimal and in quotes, such as "E8 03"',
    ),
    (
        "config.abort",
        '{file}：配置项 {key} 不能是 {value}，应是引号里的八位十六进制中止代码，如 "06010002"',
        '{file}: key {key}: {value} is not an abort code, eight hexadecimal digits in quotes such as "06010002"',
    ),
    (
        "config.emcy_code",
        '{file}：配置项 {key} 不能是 {value}，应是引号里的四位十六进制错误代码，末尾可用x代替，如 "8130"、"81xx"',
        "{file}: key {key}: {value} is not an error code, four hexadecimal digits in quotes, the last ones may be x, "
        'such as "8130" or "81xx"',
    ),
    (
        "config.incident_kind",
        '{file}：配置项 {key} 不能是 {value}，应是引号里的问题种类，如 "node-silent"，可用 * 和 ?',
        '{file}: key {key}: {value} is not a kind of problem in quotes, such as "node-silent"; * and ? may stand in it',
    ),
    (
        "config.often",
        '{file}：配置项 {key} 不能是 {value}，应是次数（0到1000000的整数）或引号里的范围，如 "1-3"、"1-"',
        '{file}: key {key}: {value} is neither a number of times, 0 to 1000000, nor a range in quotes such as "1-3" or '
        '"1-"',
    ),
    (
        "config.tpdo",
        '{file}：配置项 {key} 不能是 {value}，可以是 "TPDO1" 到 "TPDO512"',
        '{file}: key {key}: {value} is not a TPDO, "TPDO1" to "TPDO512"',
    ),
    (
        "config.number",
        "{file}：配置项 {key} 不能是 {value}，应是一个数",
        "{file}: key {key}: {value} is not a number",
    ),
    (
        "config.above_zero",
        "{file}：配置项 {key} 不能是 {value}，应是大于0、不超过{allowed}的数",
        "{file}: key {key}: {value} is not a number above 0 and up to {allowed}",
    ),
    (
        "config.from_zero",
        "{file}：配置项 {key} 不能是 {value}，应是0到{allowed}的数",
        "{file}: key {key}: {value} is not a number, 0 to {allowed}",
    ),
    (
        "config.whole",
        "{file}：配置项 {key} 不能是 {value}，应是{allowed}的整数",
        "{file}: key {key}: {value} is not a whole number, {allowed}",
    ),
    (
        "config.truth",
        "{file}：配置项 {key} 不能是 {value}，可以是 true、false",
        "{file}: key {key}: {value} is neither true nor false",
    ),
    # How keys go together.
    ("expect.unreadable", "{file}：不能读取期望：{error}", "{file}: the expectations cannot be read: {error}"),
    (
        "expect.exclusive",
        "{file}：配置项 {key} 和 {other} 不能同时有",
        "{file}: key {key} and {other} exclude each other",
    ),
    (
        "expect.lacks_one",
        "{file}：[[{table}]] 缺少配置项，需要其中一个：{keys}",
        "{file}: [[{table}]] needs one of these keys: {keys}",
    ),
    (
        "expect.goes_with",
        "{file}：配置项 {key} 只能和 {other} 一起用",
        "{file}: key {key} only goes with {other}",
    ),
    (
        "expect.only_true",
        "{file}：配置项 {key} 不能是 {value}，只能是 true，否则不写",
        "{file}: key {key}: {value} is not true; leave it out otherwise",
    ),
    (
        "expect.below_min",
        "{file}：配置项 {key} 不能是 {value}，它小于最小值 {other}",
        "{file}: key {key}: {value} is below min, {other}",
    ),
    (
        "expect.no_incident",
        "{file}：配置项 {key} 不能是 {value}，没有这一种问题",
        "{file}: key {key}: {value} is no kind of problem",
    ),
    (
        "expect.no_incident_near",
        "{file}：配置项 {key} 不能是 {value}，没有这一种问题；相近的有：{other}",
        "{file}: key {key}: {value} is no kind of problem; near it: {other}",
    ),
    (
        "expect.boot_up_passes",
        "{file}：配置项 {key} 不能和 boot-up 一起用，节点不会停留在这个状态",
        "{file}: key {key} does not go with boot-up, which no node stays in",
    ),
    # The first version of a file: its comments.
    (
        "expect.head",
        "期望的第一版，由 {name} 生成（{frames}帧，{seconds} s）。每个数旁边注明实测值；不关心的请删去，过宽的请收紧。",
        "Expectations, a first version from {name} ({frames} frames, {seconds} s). Each figure has what was seen "
        "beside it; remove what does not matter, tighten what is too wide.",
    ),
    (
        "expect.head_use",
        "用法：canalyze check --expect 本文件 记录；与记录同名、放在一起的 NAME.expect.toml 会自动使用。"
        "全部配置项见 canalyze expect --help。",
        "To use it: canalyze check --expect THIS_FILE CAPTURE; NAME.expect.toml beside a capture NAME.log is used by "
        "itself. canalyze expect --help has all keys.",
    ),
    (
        "expect.head_findings",
        "注意：这个记录有级别高于“提示”的发现：{codes}；由它得出的期望未必正确。",
        "Note that this capture has findings above info: {codes}; what is expected from it may be wrong.",
    ),
    (
        "expect.writes",
        "SDO写入（配置）：每个节点按此顺序，中间可以有别的传输。共{count}个。",
        "SDO writes (configuration), at each node in this order, with others in between or not; {count} of them.",
    ),
    (
        "expect.writes_left",
        "另有{count}个写入没有列出：最多列{most}个，同一对象写了{alike}次以上的不算配置。",
        "{count} more writes are not listed: {most} at most, and an object written more than {alike} times is no "
        "configuration.",
    ),
    (
        "expect.reads",
        "读取的设备标识；序列号不列，同型号的另一台也可以。",
        "The identity that was read, without serial numbers: another device of the same kind will do.",
    ),
    (
        "expect.transfers_left",
        "没有列出的传输：中止{aborted}个，不完整或失败{incomplete}个。",
        "Transfers that are not listed: {aborted} aborted, {incomplete} incomplete or failed.",
    ),
    (
        "expect.states",
        "节点到达过的状态；启动过程中的状态带有时限，至少是实测时间（从启动报文算起）的两倍。",
        "States that nodes have shown; those on the way up have a limit, at least twice what it took from boot-up.",
    ),
    ("expect.after_boot_up", "实测：启动报文后 {seconds} s", "seen {seconds} s after boot-up"),
    ("expect.heartbeats", "心跳周期。", "Periods of heartbeats."),
    ("expect.syncs", "同步周期。", "Period of SYNC."),
    ("expect.pdos", "周期性的PDO，节点在操作状态时。", "PDOs that come periodically, while their node is Operational."),
    (
        "expect.no_heartbeat_period",
        "没有列出心跳周期的节点：{count}个（次数太少、不是周期性的，或中途停止）。",
        "Nodes without a heartbeat period here: {count} (too few heartbeats, not periodic, or they stopped).",
    ),
    (
        "expect.no_sync_period",
        "没有列出同步周期的总线：{count}条（次数太少、不是周期性的，或中途停止）。",
        "Buses without a SYNC period here: {count} (too few SYNCs, not periodic, or they stopped).",
    ),
    (
        "expect.no_pdo_period",
        "没有列出周期的PDO：{count}个（次数太少、不是周期性的，或中途停止）。",
        "PDOs without a period here: {count} (too few of them, not periodic, or they stopped).",
    ),
    (
        "expect.seen_period",
        "实测 {least} .. {most} ms（{count}个间隔）",
        "seen {least} .. {most} ms, intervals: {count}",
    ),
    ("expect.seen_longest", "实测最长 {most} ms（{count}个间隔）", "seen at most {most} ms, intervals: {count}"),
    (
        "expect.signals",
        "信号的范围：看到的最小值和最大值，两边各留四分之一。",
        "Ranges of signals: the least and the greatest value seen, with a quarter of that range on either side.",
    ),
    ("expect.signals_left", "另有{count}个信号没有列出。", "{count} more signals are not listed."),
    (
        "expect.emcys",
        "紧急报文：出现过的允许出现，其余的不应出现。",
        "EMCYs: those seen may occur, all others must not.",
    ),
    (
        "expect.incidents",
        "问题（canalyze diagnose 所说的）：出现过的允许出现，其余的不应出现；由其他问题引起的和无害的不算。",
        "Problems, as canalyze diagnose tells them: those seen may occur, all others must not; what they cause and "
        "what is harmless does not count.",
    ),
    ("expect.seen_at", "第{frame}帧：{message}", "seen at frame {frame}: {message}"),
    ("expect.seen_times", "出现{count}次", "times seen: {count}"),
    (
        "expect.latencies",
        "SDO应答时间的上限，至少是最慢的一次的三倍。",
        "Limit for the response to an SDO request, at least three times the slowest.",
    ),
    ("expect.seen_slowest", "最慢 {milliseconds} ms，节点{node}", "slowest {milliseconds} ms, node {node}"),
    ("expect.loads", "总线负载的上限，100 ms 窗口。", "Limit for the bus load in windows of 100 ms."),
    ("expect.seen_load", "峰值 {percent} %", "peak {percent} %"),
)
