"""Headings and words of the tables of `sdo` and of what several reports share.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("col.number", "#", "#"),
    ("col.time", "时间", "time"),
    ("col.relative", "相对(s)", "relative"),
    ("col.bus", "总线", "bus"),
    ("col.node", "节点", "node"),
    ("col.direction", "方向", "direction"),
    ("col.object", "对象", "object"),
    ("col.name", "名称", "name"),
    ("col.value", "值", "value"),
    ("col.size", "字节", "size"),
    ("col.mode", "方式", "mode"),
    ("col.duration", "耗时", "duration"),
    ("col.outcome", "结果", "outcome"),
    ("col.findings", "发现", "findings"),
    ("col.frames", "帧", "frames"),
    ("direction.upload", "上传(读)", "upload"),
    ("direction.download", "下载(写)", "download"),
    ("col.read_write", "读写", "access"),
    ("access.upload", "读", "read"),
    ("access.download", "写", "write"),
    ("mode.expedited", "加速", "expedited"),
    ("mode.segmented", "分段", "segmented"),
    ("mode.block", "块", "block"),
    ("status.ok", "完成", "ok"),
    ("status.aborted", "中止", "aborted"),
    ("status.incomplete", "不完整", "incomplete"),
    ("status.failed", "失败", "failed"),
    ("by.client", "客户端", "client"),
    ("by.server", "服务器", "server"),
)
