"""What a timeline in Rerun says: titles of its tabs and views, names of lines.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    # Tabs.
    ("timeline.overview", "概览", "Overview"),
    ("timeline.nodes", "节点", "Nodes"),
    ("timeline.some_nodes", "节点 ({every}个中的前{count}个)", "Nodes (the first {count} of {every})"),
    ("timeline.node", "节点{node}", "Node {node}"),
    # Lanes.
    ("timeline.states", "状态", "States"),
    ("timeline.faults", "出过故障的状态带", "Lanes with faults"),
    ("timeline.nmt", "NMT状态", "NMT states"),
    ("timeline.drive", "驱动器状态", "Drive states"),
    ("timeline.emcy", "EMCY：未消除的错误", "EMCY: active errors"),
    ("timeline.incidents", "问题", "Problems"),
    ("timeline.caused", "起因：#{number}", "caused by #{number}"),
    ("timeline.caused_after", "起因：#{number} {ms} ms", "caused by #{number} {ms} ms"),
    ("timeline.begins", "问题{title}", "problem {title}"),
    ("timeline.ends", "已恢复{title}", "over {title}"),
    ("timeline.stories", "问题", "Problems"),
    ("timeline.value", "信号的取值", "Values of signals"),
    ("timeline.sdo", "SDO传输", "SDO transfers"),
    # Plots.
    ("timeline.period", "SYNC周期 [µs]", "SYNC period [µs]"),
    ("timeline.delay", "同步PDO的延迟和同步窗口 [µs]", "Synchronous PDOs: delay and window [µs]"),
    ("timeline.delay_only", "同步PDO的延迟 [µs]", "Synchronous PDOs: delay [µs]"),
    ("timeline.window", "同步窗口", "synchronous window"),
    ("timeline.load", "总线负载 [%]", "Bus load [%]"),
    ("timeline.rate", "每秒帧数", "Frames per second"),
    ("timeline.of_nodes", "{count}个节点的{name}", "{name} of {count} nodes"),
    ("timeline.comma", "、", ", "),
    ("timeline.durations", "SDO传输的时长 [ms]（红：失败）", "SDO transfers: duration [ms] (red: failed)"),
    # Lines that are no signals, by their names in the recording.
    ("timeline.window_line", "同步窗口 [µs]", "synchronous window [µs]"),
    ("timeline.load_line", "{bus} 负载 [%]", "{bus} load [%]"),
    ("timeline.rate_line", "{bus} 帧率 [帧/秒]", "{bus} frame rate [frames/s]"),
    ("timeline.done_line", "{channel} SDO传输 [ms]", "{channel} SDO transfer [ms]"),
    ("timeline.failed_line", "{channel} 失败的SDO传输 [ms]", "{channel} failed SDO transfer [ms]"),
    # Texts.
    ("timeline.log", "发现和EMCY", "Findings and EMCY"),
    ("timeline.faults_log", "发现和EMCY（错误、警告）", "Findings and EMCY (errors, warnings)"),
    ("timeline.frames", "帧", "Frames"),
    ("timeline.summary", "摘要", "Summary"),
)
