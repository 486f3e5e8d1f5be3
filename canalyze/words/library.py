"""What the pytest plugin says.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    (
        "test.update",
        "写入 canalyze_snapshot 的快照，不作比较",
        "write the snapshots of canalyze_snapshot instead of comparing",
    ),
    (
        "test.lang",
        "解码文字和名称的语言：en 或 zh，默认 en",
        "language of decoded text and names: en or zh, en by default",
    ),
    ("test.findings", "canalyze：发现", "canalyze: findings"),
    ("test.transfers", "canalyze：SDO传输", "canalyze: SDO transfers"),
    ("test.signals", "canalyze：信号", "canalyze: signals"),
    ("test.incidents", "canalyze：问题", "canalyze: problems"),
    ("test.stands", "canalyze：{name} 中未解决的问题", "canalyze: what stands in {name}"),
    ("test.more", "……另有{count}个", "... and {count} more"),
    ("test.cut", "……略去{count}帧", "... {count} frames left out"),
    ("test.unread", "无法再次读取：{problem}", "cannot be read again: {problem}"),
    ("test.rows", "{left} 个，应为 {right} 个", "{left} there, {right} expected"),
    ("test.field", "{name}：{left}，应为 {right}", "{name}: {left}, expected {right}"),
    ("test.at", "第{place}项：", "item {place}:"),
    ("test.values", "序列与数值比较请用 .values", "compare the .values of a series with numbers"),
    (
        "test.missing",
        "没有快照 {file}；核对后写入：{command}",
        "no snapshot {file}; look at it and write it: {command}",
    ),
    ("test.shows", "记录显示：", "the capture shows:"),
    (
        "test.differs",
        "与快照 {file} 不同（- 快照，+ 记录）；若这样才对：{command}",
        "not as in the snapshot {file} (- snapshot, + capture); if this is right: {command}",
    ),
    (
        "test.again",
        "同一测试里快照 {file} 用了两次；请给其中一个 name=",
        "the snapshot {file} is used twice in one test; give one of them a name=",
    ),
    ("test.unreadable", "快照 {file} 无法读写：{problem}", "snapshot {file}: {problem}"),
    ("test.written", "canalyze：写入了{count}个快照", "canalyze: snapshots written: {count}"),
    (
        "test.orphan",
        "canalyze：没有测试使用快照 {file}，可以删除",
        "canalyze: no test uses the snapshot {file}; it can be deleted",
    ),
)
