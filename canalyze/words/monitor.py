"""What `canalyze monitor` says of itself: its page of help, its options, and every word on its screen.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("monitor.short", "在屏幕上监视总线，或重放记录", "Watch a bus on the screen, or a replayed capture"),
    ("monitor.usage", "[选项] 通道... | 文件...", "[OPTIONS] CHANNEL... | FILE..."),
    (
        "monitor.help",
        "在终端上监视总线：节点（状态、心跳、EMCY、驱动器）、每个COB-ID的最新数据和信号（标出变化的字节）、"
        "进行中的SDO传输、发现、问题及其起因，以及可暂停、筛选、查找的逐帧注释。只接收，从不发送。"
        "名称是已有的文件时，按其时间戳重放；状态行说明正在重放。按 ? 显示所有按键，按 q 退出。"
        "需要安装：pip install 'canalyze[tui]'。",
        "Watch a bus on the terminal: nodes (state, heartbeat, EMCY, drive), the last data and signals of every COB-ID "
        "with the bytes that changed marked, SDO transfers as they run, findings, problems with what caused them, and "
        "annotated frames that can be paused, filtered and searched. It only listens and never sends. Where the name "
        "is that of a file, it is replayed by its stamps; the status line says so. ? shows all keys, q quits. It "
        "needs: pip install 'canalyze[tui]'.",
    ),
    (
        "monitor.speed",
        "重放文件的速度：2 是两倍，0.1 是十分之一，max 是尽快。不给则为1。没有时间戳的记录按每秒1000帧重放。"
        "超过1分钟没有帧的间隔会跳过。",
        "Speed at which a file is replayed: 2 is twice as fast, 0.1 a tenth, max as fast as can be. Without it 1. A "
        "capture without stamps is replayed at 1000 frames/s. Silence of more than a minute is passed over.",
    ),
    (
        "monitor.bell",
        "每出现一个使设备停止或不能启动的新问题，终端响铃一次。",
        "Ring the terminal's bell once for each new problem that stops something or keeps it from starting.",
    ),
    (
        "monitor.examples",
        "canalyze monitor can0 --bitrate 500k --eds 5=drive.eds\n"
        "canalyze monitor can0 can1 --record session.mcap\n"
        "canalyze monitor --interface pcan --bitrate 250k PCAN_USBBUS1\n"
        "canalyze monitor --speed 2 capture.log.gz",
        "canalyze monitor can0 --bitrate 500k --eds 5=drive.eds\n"
        "canalyze monitor can0 can1 --record session.mcap\n"
        "canalyze monitor --interface pcan --bitrate 250k PCAN_USBBUS1\n"
        "canalyze monitor --speed 2 capture.log.gz",
    ),
    # What keeps it from starting.
    (
        "monitor.missing",
        "monitor 需要 textual：pip install 'canalyze[tui]'",
        "monitor needs textual: pip install 'canalyze[tui]'",
    ),
    (
        "monitor.no_terminal",
        "monitor 只能在终端上运行；要写到文件或管道，请用 canalyze sniff 或 canalyze decode",
        "monitor needs a terminal; for files and pipes use canalyze sniff or canalyze decode",
    ),
    (
        "monitor.dumb",
        "此终端（TERM={term}）不能画出屏幕；请换一个终端，或用 canalyze sniff 或 canalyze decode",
        "this terminal (TERM={term}) cannot draw a screen; use another one, or canalyze sniff or canalyze decode",
    ),
    (
        "monitor.no_stdin",
        "monitor 不读标准输入，键盘要用它；请给出文件名或通道",
        "monitor does not read standard input, which the keyboard needs; name a file or a channel",
    ),
    (
        "monitor.mixed",
        "{file} 是文件，{channel} 不是；只能监视通道，或者只能重放文件",
        "{file} is a file and {channel} is not; give channels only, or files only",
    ),
    (
        "monitor.none",
        "没有给出通道或文件，如 canalyze monitor can0",
        "no channel and no file given, as in canalyze monitor can0",
    ),
    (
        "monitor.only_files",
        "{option} 只用于重放文件",
        "{option} is only for files that are replayed",
    ),
    (
        "monitor.only_channels",
        "{option} 只用于通道，不用于重放文件",
        "{option} is only for channels, not for files that are replayed",
    ),
    (
        "usage.speed",
        "选项 {option} 不能是 {value}，可以是大于0的数，如 2 或 0.5，或者 max",
        "option {option}: {value} is not a speed, such as 2, 0.5 or max",
    ),
    # How it stands with the source.
    ("monitor.live", "实时", "LIVE"),
    ("monitor.replay", "重放", "REPLAY"),
    ("monitor.paused", "暂停", "PAUSED"),
    ("monitor.waiting", "等待", "WAITING"),
    ("monitor.lost", "已断开", "LOST"),
    ("monitor.over", "已结束", "OVER"),
    ("monitor.records", "记录中", "REC"),
    ("monitor.unrecorded", "记录失败", "REC FAILED"),
    ("monitor.fastest", "最快", "max"),
    ("monitor.fixed", "无时间戳，{rate}帧/秒", "no stamps, {rate}/s"),
    # The status line.
    ("monitor.long_frames", "{count}帧", "{count} frames"),
    ("monitor.long_rate", "{count}帧/秒", "{count} frames/s"),
    ("monitor.long_errors", "错误帧 {count}", "error frames {count}"),
    ("monitor.long_dropped", "丢帧 {count}", "dropped {count}"),
    ("monitor.short_frames", "{count}帧", "{count} fr"),
    ("monitor.short_rate", "{count}/秒", "{count}/s"),
    ("monitor.short_errors", "错误帧{count}", "err fr {count}"),
    ("monitor.short_dropped", "丢{count}", "drop {count}"),
    ("monitor.filtered", "筛选 {text}", "filter {text}"),
    ("monitor.searched", "查找 {text}", "search {text}"),
    ("bus_state.error-warning", "错误警告", "error warning"),
    ("bus_state.error-passive", "错误被动", "error passive"),
    ("bus_state.bus-off", "总线关闭", "bus-off"),
    ("monitor_view.overview", "总览", "all"),
    ("monitor_view.nodes", "节点", "nodes"),
    ("monitor_view.objects", "对象", "objects"),
    ("monitor_view.transfers", "SDO", "SDO"),
    ("monitor_view.findings", "发现", "findings"),
    ("monitor_view.trace", "帧", "trace"),
    ("monitor_view.incidents", "问题", "problems"),
    # Headings and cells.
    ("monitor.drive", "驱动器", "drive"),
    ("monitor.object", "对象", "object"),
    ("monitor.jitter", "抖动", "jitter"),
    ("monitor.data", "数据", "data"),
    ("monitor.frame", "帧号", "frame"),
    ("monitor.rule", "规则", "rule"),
    ("monitor.finding", "发现", "finding"),
    ("monitor.number", "号", "no."),
    ("monitor.lasts", "持续", "lasts"),
    ("monitor.problem", "问题", "problem"),
    ("monitor.caused", "起因：{number}号", "because of {number}"),
    ("monitor.show_harmless", "+ {count}个无害的（Enter 展开）", "+ harmless: {count} (Enter shows them)"),
    ("monitor.hide_harmless", "- {count}个无害的（Enter 收起）", "- harmless: {count} (Enter hides them)"),
    ("monitor.trace", "注释", "annotation"),
    ("monitor.trace_back", "注释（已停住，End 回到最新）", "annotation (standing; End follows)"),
    ("monitor.node", "节点{node}", "node {node}"),
    ("monitor.of_node", "{node} {name}", "{node} {name}"),
    ("monitor.runs", "进行中", "running"),
    ("monitor_silent.heartbeat", "无心跳", "no heartbeat"),
    ("monitor_silent.guarding", "保护无应答", "no guarding answer"),
    ("monitor.last_state", "最后的状态: {state}", "last state: {state}"),
    ("monitor.emcy_over", "曾有{text}", "was {text}"),
    ("monitor_empty.nodes", "还没有见到节点", "no node seen yet"),
    ("monitor_empty.objects", "还没有帧", "no frame yet"),
    ("monitor_empty.transfers", "还没有SDO传输", "no SDO transfer yet"),
    ("monitor_empty.findings", "没有发现", "no findings"),
    ("monitor_empty.incidents", "没有发现问题", "no problem found"),
    ("monitor_empty.trace", "没有符合的帧", "no frame that fits"),
    # What is asked and said.
    (
        "monitor_ask.filter",
        "筛选（同 --filter，如 node=5 service=sdo）：",
        "Filter (as --filter, e.g. node=5 service=sdo):",
    ),
    ("monitor_ask.search", "查找：", "Search:"),
    ("monitor.not_found", "没有找到“{text}”", "'{text}' is not found"),
    ("monitor.no_more", "这个方向上没有更多的“{text}”", "no further '{text}' in this direction"),
    (
        "monitor.unfiltered",
        "那一帧不符合筛选条件，已取消筛选",
        "that frame does not fit the filter, which was removed",
    ),
    ("monitor.gone", "第{frame}帧已不在保留的行中", "frame {frame} is no longer among the lines that are kept"),
    # Keys.
    ("monitor.space", "空格", "Space"),
    ("monitor.key_views", "视图", "views"),
    ("monitor.key_tab", "窗格", "pane"),
    ("monitor.key_pick", "转到", "go to"),
    ("monitor.key_pause", "暂停", "pause"),
    ("monitor.key_filter", "筛选", "filter"),
    ("monitor.key_search", "查找", "search"),
    ("monitor.key_help", "帮助", "help"),
    ("monitor.key_quit", "退出", "quit"),
    ("monitor.help_title", "按键（按任意键返回）", "Keys (any key goes back)"),
    (
        "monitor.help_views",
        "总览、节点、对象、SDO传输、发现、逐帧注释、问题",
        "overview, nodes, objects, SDO transfers, findings, annotated frames, problems",
    ),
    (
        "monitor.help_tab",
        "下一个窗格；标题反白的窗格接受按键",
        "next pane; keys go to the one with the reversed heading",
    ),
    (
        "monitor.help_move",
        "移动光标；光标所在行的全文显示在下方",
        "move the cursor; its row is shown in full below",
    ),
    (
        "monitor.help_edge",
        "第一行；最后一行，并继续跟随最新的帧",
        "first row; last row, where the newest frame is followed",
    ),
    (
        "monitor.help_pick",
        "发现、传输：转到它的帧；问题：转到第一帧证据；节点、对象：只看它的帧",
        "of a finding or transfer: go to its frame; of a problem: to its first evidence; of a node or object: see its "
        "frames only",
    ),
    (
        "monitor.help_pause",
        "画面停住；总线的接收和记录照常进行，重放则暂停",
        "the screen stands; reading and recording a bus go on, a replay stands too",
    ),
    ("monitor.help_filter", "筛选帧；空行取消筛选", "filter the frames; an empty line takes the filter away"),
    ("monitor.help_search", "在帧中查找文字，不分大小写", "look for a text in the frames, in any case"),
    ("monitor.help_next", "下一处（较新）", "next place (newer)"),
    ("monitor.help_previous", "上一处（较旧）", "previous place (older)"),
    (
        "monitor.help_leave",
        "依次取消：提示、光标、查找、筛选",
        "take away, one after the other: notice, cursor, search, filter",
    ),
    ("monitor.help_faster", "重放加快一倍", "replay twice as fast"),
    ("monitor.help_slower", "重放减慢一半", "replay half as fast"),
    ("monitor.help_help", "显示这一页", "show this page"),
    ("monitor.help_quit", "退出（Ctrl-C 也可以）", "quit (so does Ctrl-C)"),
    (
        "monitor.help_looks",
        "数据中加亮的字节在最近1秒内变化过。心跳：距上次的时间/周期；该来而没来的写“无心跳”。"
        "EMCY：“曾有”的已消除。发现：✖ 错误，▲ 警告，i 信息。问题：带“?”的还可能改变。",
        "Bytes in bold changed within the last second. Heartbeat: age of the last one / period; 'no heartbeat' where "
        "one is overdue. EMCY: 'was' one that no longer stands. Findings: ✖ errors, ▲ warnings, i infos. "
        "Problems: what has '?' may still change.",
    ),
)
