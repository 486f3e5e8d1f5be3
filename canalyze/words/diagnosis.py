"""The report of `diagnose`.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    (
        "diagnose.short",
        "诊断：出了什么问题、是否仍存在、为什么、先查什么",
        "What broke, whether it still is, why, what to check",
    ),
    ("diagnose.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "diagnose.help",
        "诊断记录：把发现归结为问题，每个问题说明对象、起止、起因、后果和先查什么；最重要的在前。"
        "不写命令而只写文件名时就是这个命令；文件与命令同名时写成“./名字”。#后面是帧号。",
        "Diagnose captures: findings become problems, each with its subject, begin and end, cause, consequences and "
        "what to check first; the most important comes first. A file name without a command means this command; a file "
        "that is called as a command is written './NAME'. A number behind # is that of a frame.",
    ),
    ("diagnose.story", "完整讲述一个问题，并带注释的帧。", "Tell one problem in full, with its annotated frames."),
    ("diagnose.all", "列出全部问题，包括无害的。", "List all problems, harmless ones too."),
    (
        "diagnose.since",
        "只列从记录开始S秒之后仍存在的问题。",
        "Only problems that still were there S seconds after the begin of the capture.",
    ),
    ("diagnose.node", "只列与这个节点有关的问题。", "Only problems that concern this node."),
    ("diagnose.bus", "只列这条总线上的问题。", "Only problems of this bus."),
    (
        "diagnose.html",
        "另写一个HTML页面：结论、每个问题、因果图、节点和驱动的状态、相关信号和帧；不访问网络，中英文都有，可打印。",
        "Also write an HTML page: the verdict, each problem, the picture of causes, states of nodes and drives, "
        "signals and frames around them; it loads nothing, has both languages and can be printed.",
    ),
    (
        "diagnose.needs_html",
        "{error}；HTML页面需要jinja2：pip install 'canalyze[html]'",
        "{error}; the HTML page needs jinja2: pip install 'canalyze[html]'",
    ),
    ("diagnose.html_bus", "总线", "bus"),
    ("diagnose.html_node", "节点", "node "),
    ("diagnose.html_nodes", "节点", "Nodes"),
    ("diagnose.html_frames", "相关的帧", "Frames around the steps"),
    ("diagnose.html_chain", "因果", "Causes"),
    ("diagnose.html_lanes", "状态", "States"),
    ("diagnose.html_nmt", "NMT", "NMT"),
    ("diagnose.html_drive", "驱动", "drive"),
    ("diagnose.html_plots", "相关信号（虚线：问题开始）", "Signals around it (dashed: a problem begins)"),
    ("diagnose.html_others", "不属于以上问题的其他检查结果（{count}）", "Other findings ({count})"),
    ("diagnose.html_every", "全部帧", "All frames"),
    (
        "diagnose.html_option",
        "--html 页面里的帧：near 只有各步骤附近的(默认)；all 是全部帧，可在页面里搜索，页面会大得多。",
        "Frames in the page of --html: near, those around the steps (default); all, every frame, to be searched in the "
        "page, which is then much larger.",
    ),
    ("diagnose.frames_html", "--frames 只用于 --html", "--frames needs --html"),
    ("diagnose.html_check", "先查", "Check first"),
    ("diagnose.html_ok", "正常", "ok"),
    ("diagnose.html_see", "见{number}号", "see {number}"),
    (
        "diagnose.fail_on",
        "有这样的问题时退出码为1：stands 仍存在，unknown 也包括状态不明的，over 也包括已恢复的。",
        "Exit code 1 where there is such a problem: stands, unknown (those too), over (those too).",
    ),
    (
        "diagnose.format",
        "text 给人看；jsonl 每行一个问题(JSON对象)。",
        "text for people; jsonl is one JSON object a problem.",
    ),
    (
        "diagnose.examples",
        "canalyze capture.log                   诊断一个记录\n"
        "canalyze capture.log -n 1              完整讲述1号问题\n"
        "canalyze diagnose --node 5 a.log b.log 只看节点5\n"
        "canalyze capture.log --format jsonl --fail-on stands",
        "canalyze capture.log                   diagnose a capture\n"
        "canalyze capture.log -n 1              tell problem 1 in full\n"
        "canalyze diagnose --node 5 a.log b.log only what concerns node 5\n"
        "canalyze capture.log --format jsonl --fail-on stands",
    ),
    ("examples.short", "写出五个小的示例记录", "Write five small example captures"),
    ("examples.usage", "[选项] [目录]", "[OPTIONS] [DIR]"),
    (
        "examples.help",
        "把五个小的记录写到目录里(不给则为当前目录)，每个讲一件事，并告诉接下来可以输入什么。",
        "Write five small captures into a folder (the current one without DIR), each with a story, and say what to "
        "type next.",
    ),
    (
        "examples.examples",
        "canalyze examples\ncanalyze examples demo/\ncanalyze demo/node-lost.log",
        "canalyze examples\ncanalyze examples demo/\ncanalyze demo/node-lost.log",
    ),
    (
        "examples.next",
        "接下来：canalyze {file} · canalyze {file} -n 1 · canalyze decode {file}",
        "next: canalyze {file} · canalyze {file} -n 1 · canalyze decode {file}",
    ),
    ("example.node-lost", "一个节点失去联系", "a node is lost"),
    ("example.node-restarted", "一个节点断电后回来", "a node loses its power and comes back"),
    ("example.mapping-refused", "PDO映射先被拒绝，后来改正", "a PDO mapping is refused, then made good"),
    ("example.drive-fault", "驱动故障，第二次复位才成功", "a drive faults, and only the second reset helps"),
    ("example.all-well", "一切正常，中间有一次按命令复位", "all is well, with a reset by command"),
    (
        "diagnose.story_stdin",
        "{option}需要能再次读取的文件，不能用标准输入",
        "{option} reads the files again; standard input cannot be",
    ),
    ("diagnose.no_story", "没有{number}号问题", "there is no problem {number}"),
    ("incident_one.stands", "1个问题仍存在", "1 problem stands"),
    ("incident_one.unknown", "1个状态不明", "1 is not known to be over"),
    ("incident_one.over", "1个已恢复", "1 is over"),
    ("incident_one.harmless", "1个无害", "1 is harmless"),
    ("incident_many.stands", "{count}个问题仍存在", "{count} problems stand"),
    ("incident_many.unknown", "{count}个状态不明", "{count} are not known to be over"),
    ("incident_many.over", "{count}个已恢复", "{count} are over"),
    ("incident_many.harmless", "{count}个无害", "{count} are harmless"),
    ("diagnose.none_stands", "没有仍存在的问题", "no problem stands"),
    ("diagnose.none", "没有发现问题", "no problem found"),
    ("diagnose.seconds", "{seconds} s", "{seconds} s"),
    ("diagnose.frames", "{count}帧", "frames: {count}"),
    ("diagnose.nodes", "{count}个节点", "nodes: {count}"),
    (
        "diagnose.foreign",
        "这不像CANopen的报文：没有可以判断的",
        "this does not look like CANopen: nothing could be judged",
    ),
    ("diagnose.silent", "没有报文：没有可以判断的", "there is no traffic: nothing could be judged"),
    (
        "diagnose.unproven",
        "没有报文能证明这是CANopen：判断有限",
        "nothing proves that this is CANopen: little could be judged",
    ),
    (
        "diagnose.no_stamps",
        "没有时间戳：只判断了顺序和内容，没有判断心跳、周期和超时",
        "no stamps: judged were order and content; heartbeats, periods and timeouts were not",
    ),
    (
        "diagnose.short_capture",
        "记录只有{seconds} s：心跳丢失和周期可能看不出",
        "the capture has only {seconds} s: lost heartbeats and periods may not show",
    ),
    (
        "diagnose.looked",
        "检查了心跳、启动、EMCY、SDO、PDO、SYNC、驱动状态和错误帧",
        "looked at: heartbeats, boot-ups, EMCY, SDO, PDO, SYNC, drive states, error frames",
    ),
    (
        "diagnose.looked_without",
        "检查了心跳、启动、EMCY、SDO、PDO、SYNC和驱动状态；记录中没有错误帧",
        "looked at: heartbeats, boot-ups, EMCY, SDO, PDO, SYNC, drive states; no error frames are recorded here",
    ),
    ("incident_heading.stands", "未解决", "STANDS"),
    ("incident_heading.unknown", "状态不明", "NOT KNOWN"),
    ("incident_heading.over", "已恢复", "OVER"),
    ("incident_heading.harmless", "无害", "HARMLESS"),
    ("diagnose.heading_nodes", "节点  ", "NODES  "),
    ("diagnose.node_ok", "{node} 正常", "{node} ok"),
    ("diagnose.node_in", "{node} 见{number}号", "{node} see {number}"),
    ("diagnose.node_more", "另有{count}个", "{count} more"),
    ("diagnose.more_effects", "另有{count}个后果", "{count} more consequences"),
    ("diagnose.alike", "同样的问题另有{count}次：--all", "{count} more like it: --all"),
    ("diagnose.check_first", "先查：{said}", "check first: {said}"),
    ("diagnose.between", "；", "; "),
    ("diagnose.because", "起因：{number}号 {title}（{grade}）", "because of {number}, {title} ({grade})"),
    ("diagnose.after", "，{ms} ms后", ", {ms} ms after"),
    ("diagnose.findings", "规则：{said}", "rules: {said}"),
    ("diagnose.more", "更多：{said}", "more: {said}"),
    ("incident_status.stands", "仍存在", "stands"),
    ("incident_status.unknown", "不明", "not known"),
    ("incident_status.over", "已恢复", "over"),
    ("incident_status.harmless", "无害", "harmless"),
    ("incident_grade.certain", "确定", "certain"),
    ("incident_grade.likely", "很可能", "likely"),
    ("incident_grade.possible", "可能", "possible"),
    ("incident_role.sign", "征兆", "sign"),
    ("incident_role.reaction", "反应", "reaction"),
    ("incident_role.attempt", "尝试", "attempt"),
    ("incident_role.recovery", "恢复", "recovery"),
)
