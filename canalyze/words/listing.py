"""Options that listings and tables share: colours, numbers of frames, the form of time.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    (
        "opt.color",
        "是否着色；默认 auto：只在终端上着色，遵守环境变量 NO_COLOR 和 FORCE_COLOR。",
        "Whether to use colours; default auto: on terminals only, as NO_COLOR and FORCE_COLOR have it.",
    ),
    ("opt.number", "每行前写帧序号。", "Begin each line with the number of its frame."),
    (
        "opt.time",
        "时间的写法：a 绝对，z 从记录的第一帧算起，A 日期和时间（UTC），n 不写；默认照原样。",
        "How time is written: a absolute, z since the first frame of the capture, A date and time in UTC, n none; "
        "default: as it came.",
    ),
    (
        "decode.around",
        "只显示第N帧及其前后各K帧（默认10），带帧序号；可重复。状态仍由全部帧得出。",
        "Show only frame N and K frames before and behind it (default 10), with numbers; may be repeated. State is "
        "still tracked over all frames.",
    ),
    (
        "decode.frame",
        "只显示第A帧到第B帧，带帧序号；可重复。",
        "Show only frames A to B, with numbers; may be repeated.",
    ),
    ("summary.states_at", "各节点的状态变化", "States over time"),
    ("summary.at_moment", "{moment} {state}", "{moment} {state}"),
    ("summary.duration", "共 {seconds} s", "{seconds} s"),
    (
        "usage.around",
        "{option} {value}：应为帧序号，或 N:K（前后各K帧），如 120 或 120:5",
        "{option} {value}: give the number of a frame, or N:K for K frames on each side, such as 120 or 120:5",
    ),
    (
        "usage.frame",
        "{option} {value}：应为帧序号或范围，如 12 或 10-20",
        "{option} {value}: give the number of a frame or a range, such as 12 or 10-20",
    ),
)
