"""Names of the lines that a timeline plots beside those of signals.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("series.period", "SYNC周期 [µs]", "SYNC period [µs]"),
    ("series.window", "同步窗口 [µs]", "synchronous window [µs]"),
    ("series.load", "{bus} 负载 [%]", "{bus} load [%]"),
    ("series.rate", "{bus} 帧率 [帧/秒]", "{bus} frame rate [frames/s]"),
)
