"""The page of `diff` and its own errors. What differs, the core says.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("diff.short", "比较两个记录的CANopen内容", "Compare two captures as CANopen"),
    ("diff.usage", "[选项] A B", "[OPTIONS] A B"),
    (
        "diff.help",
        "按CANopen的含义比较两个记录，不比较字节和时间：SDO传输（缺少、多出、值、结果、方式）、NMT命令、"
        "启动报文和状态、EMCY、LSS、驱动器状态、PDO的映射和COB-ID、周期和抖动、警告以上的发现。"
        "最先列出问题（canalyze diagnose 所说的）的差异：仅一方有的，两者都有而状态、持续时间、次数或原因不同的；"
        "两者都要有时间戳，用了 --filter 则不比较问题。再"
        "指出首处差异及其前后各帧，再按节点列出全部差异。上传的值在一个记录里有变化时只比较结果，"
        "轮询的次数只比较快慢；EMCY按错误码和错误寄存器计数。每个记录最多保留200万个传输等事件和800万个周期帧，"
        "其余的会说明没有比较。只比较两者都记录到的时段；一个记录开始或结束得比另一个早或晚时，那里2 ms"
        "（没有时间戳时为两帧）之内的不作判断，因为主机自己的帧可能记录得晚。总线名称、方向、时间戳和记录格式不算差异，"
        "由不同适配器录下的同一过程是相同的。退出码：0 相同，1 有差异，2 无法读取。",
        "Compare two captures by what happens in CANopen terms, not by bytes or times: SDO transfers (missing, "
        "added, with other value, outcome or mode), NMT commands, boot-ups and states, EMCY, LSS, drive states, "
        "mappings and COB-IDs of PDOs, periods and jitter, findings from warning on. Problems, as canalyze diagnose "
        "tells them, come before all: those in one capture only, and those in both with another status, duration, "
        "count or cause; both need stamps for that, and with --filter problems are not compared. The first other "
        "difference comes with the frames around it, then all of them by node. An upload whose value varies within a "
        "capture is compared by its outcome only, a poll by its pace; EMCYs count by error code and register. Up to "
        "2 million transfers and the like and 8 million periodic frames of each capture are kept; the rest is said "
        "not to be compared. Only the span that both captures cover counts; where one begins or ends apart from the "
        "other, what lies within 2 ms of there (two frames without stamps) is not judged, since a host may list its "
        "own frames late. Names of buses, directions, stamps and formats are no difference: one session recorded by "
        "two adapters is the same. Exit code: 0 the same, 1 different, 2 something could not be read.",
    ),
    (
        "diff.format",
        "text 给人看；jsonl 每行一处差异，问题在前，最后一行是总结。",
        "text for people; jsonl is one difference a line, problems first, and a line that closes them.",
    ),
    (
        "diff.tolerance",
        "周期允许相差百分之几，0到1000，默认10；抖动允许相差它的两倍；问题的持续时间和次数同周期。",
        "By how many percent periods may differ, 0 to 1000, 10 by default; jitter may differ by twice as much, "
        "durations and counts of problems as much as periods.",
    ),
    (
        "diff.bus",
        "记录A的哪条总线对应记录B的哪条，如 can0=vcan0；可重复。不给则按名称，再按节点对应。",
        "Which bus of capture A is which of capture B, e.g. can0=vcan0; repeatable. Without it they are matched by "
        "name, then by their nodes.",
    ),
    ("diff.two", "要两个不同的输入，给出了{count}个", "two inputs are compared, given: {count}; only one can be '-'"),
    (
        "diff.examples",
        "canalyze diff good.log new.log\n"
        "canalyze diff --eds 5=drive.eds --filter node=5 good.log new.mcap\n"
        "canalyze diff --tolerance 20 --bus can0=vcan0 good.asc new.log\n"
        "canalyze diff --format jsonl good.log new.log | jq -r .text",
        "canalyze diff good.log new.log\n"
        "canalyze diff --eds 5=drive.eds --filter node=5 good.log new.mcap\n"
        "canalyze diff --tolerance 20 --bus can0=vcan0 good.asc new.log\n"
        "canalyze diff --format jsonl good.log new.log | jq -r .text",
    ),
    (
        "diff.no_bus",
        "选项 --bus：记录{side}没有总线 {name}，有的是：{there}",
        "option --bus: capture {side} has no bus {name}; it has: {there}",
    ),
    ("diff.unnamed", "没有名称的总线", "a bus without a name"),
    (
        "usage.percent",
        "选项 {option} 不能是 {value}，可以是0到1000的百分比",
        "option {option}: {value} is no percentage from 0 to 1000",
    ),
    (
        "usage.bus_pair",
        "选项 {option} 不能是 {value}，要写成 can0=vcan0",
        "option {option}: {value} cannot be read; write it as can0=vcan0",
    ),
)
