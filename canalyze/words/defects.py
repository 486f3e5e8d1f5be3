"""Defects of device descriptions and what was done about each.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
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
    ("defect.node-id", "节点ID {value} 不在1到127之间", "node-ID {value} is not within 1 to 127"),
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
)
