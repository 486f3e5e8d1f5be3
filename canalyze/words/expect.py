"""Words about expectations: mistakes in their file, and the command that writes a first version.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
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
        "expect.boot_up_passes",
        "{file}：配置项 {key} 不能和 boot-up 一起用，节点不会停留在这个状态",
        "{file}: key {key} does not go with boot-up, which no node stays in",
    ),
)
