"""What the layout of an MCAP's decoded topics says of itself.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    (
        "topics.one",
        "布局（.rbl）只能由一个MCAP生成：canalyze view {name} --save {save}",
        "a layout (.rbl) is made from one MCAP: canalyze view {name} --save {save}",
    ),
    (
        "topics.written",
        "{save}：这样打开：rerun --bind 127.0.0.1 {name} - < {save}",
        "{save}: to open it: rerun --bind 127.0.0.1 {name} - < {save}",
    ),
    (
        "topics.none",
        "{name}：没有解码后的topic，布局（.rbl）无从生成；canalyze convert --decoded 写出的MCAP才有",
        "{name}: has no decoded topics that a layout (.rbl) could show; canalyze convert --decoded writes them",
    ),
    (
        "topics.damaged",
        "{name}：不是完整的MCAP，Rerun打不开；canalyze convert --decoded 可重新写出一个",
        "{name}: is no complete MCAP, Rerun does not open it; canalyze convert --decoded writes one",
    ),
)
