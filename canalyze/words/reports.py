"""Words of the reports for CI: JUnit, SARIF, annotations of GitHub.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("reports.node", "节点{node}", "node {node}"),
    ("reports.frame", "第{frame}帧", "frame {frame}"),
    ("reports.line", "第{line}行", "line {line}"),
    ("reports.shown", "由{frame}得知", "known by {frame}"),
    ("reports.count", "共{count}次", "{count} times"),
    ("reports.known", "基线允许{known}次", "the baseline allows {known}"),
    ("reports.also", "还有第{frames}帧", "also frames {frames}"),
    ("reports.also_more", "还有第{frames}等帧", "also frames {frames} and more"),
    ("reports.consequence", "{count}条后果：{codes}", "{count} consequence: {codes}"),
    ("reports.consequences", "{count}条后果：{codes}", "{count} consequences: {codes}"),
    ("reports.because_of", "{place}：{said}", "{place}: {said}"),
    ("reports.list", "、", ", "),
    ("reports.then", "，", ", "),
    ("reports.said", "{message}（{place}）", "{message} ({place})"),
    ("reports.shown_here", "由此帧得知", "the frame by which it is known"),
    ("reports.readable", "可以读取", "can be read"),
    ("reports.clean", "没有使检查失败的发现", "no findings that fail the check"),
    ("reports.below", "低于阈值", "below the threshold"),
    (
        "reports.annotations",
        "GitHub每步每种注释最多显示10条；其余在日志中：{counts}",
        "GitHub shows 10 annotations of each kind in a step; the others are in the log: {counts}",
    ),
    ("reports.count_of", "{severity}{count}条", "{severity} {count}"),
    (
        "reports.results",
        "还有{count}个发现没有写入：代码扫描每次最多接受{most}个",
        "{count} more findings are not in this file: code scanning takes {most} at most",
    ),
)
