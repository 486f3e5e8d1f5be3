"""Listening to a live bus: why it cannot be, what to do, what is told while it goes on.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("live.lost", "{channel}：接收中断：{error}", "{channel}: cannot be received from any more: {error}"),
    ("live.broken", "{channel}：接收出错：{problem}", "{channel}: receiving failed: {problem}"),
    ("live.waiting", "{reason}；等待 {channel} 恢复", "{reason}; waiting for {channel}"),
    ("live.back", "{channel}：已恢复接收", "{channel}: receiving again"),
)
