"""`check`: its page of help, its report, its baseline, and what cannot be said of either.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

_EXAMPLES: Final = (
    "canalyze check capture.log\n"
    "canalyze check 'captures/**/*.log' --junit report.xml --sarif report.sarif\n"
    "canalyze check --fail-on error --ignore SYN003,PDO 'captures/*.asc'\n"
    "canalyze check --baseline known.json --update-baseline captures/*.log\n"
    "canalyze check --baseline known.json captures/*.log\n"
    "canalyze check --expect boot.expect.toml 'captures/*.log'\n"
    "canalyze check --eds 5=drive.eds --format jsonl capture.log | jq -r 'select(.fails) | .message'\n"
    "candump -L can0 | canalyze check -"
    "\n\n"
    "# canalyze.toml\n"
    "[check]\n"
    'fail_on = "warning"\n'
    'ignore = ["SYN003"]\n'
    'baseline = "known.json"\n'
    "\n"
    "[[check.override]]\n"
    'codes = ["HBT001", "SDO"]\n'
    'severity = "ignore"          # "info", "warning", "error"\n'
    'reason = "old master"\n'
    'files = ["captures/old/**/*.log"]\n'
    'nodes = [5, "7-9"]\n'
    'bus = "can1"'
)

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("check.short", "检查记录，供回归测试和CI使用", "Check captures: findings for regression tests and CI"),
    ("check.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "check.help",
        "逐个检查记录：每个文件自成一个记录，多个文件同时处理，结果按给出的顺序。文件名可以带通配符（* ? [..] **），"
        "加引号时由本程序展开。达到 --fail-on 级别的发现算作不合格：每类（规则、总线、节点、对象相同）一条，"
        "附上相关的注释行。退出码：0 合格，1 有不合格的发现，2 有文件不能读取。已知的发现可以存入基线文件，"
        "只有更多的才算不合格；记录必须显示的内容写成期望（见 canalyze expect --help）；按文件、节点、"
        "总线的例外和理由写在 canalyze.toml 的 [[check.override]] 里（见下面的例子；files、nodes、bus 可不写，"
        "有几条符合时以最后一条为准）。读不了的文件不影响其他文件的结果。",
        "Check captures one by one: every file is a capture of its own, several are worked on side by side, results "
        "come in the order given. Names may hold * ? [..] and **, which are expanded here where the shell has not. "
        "Findings at or above --fail-on fail the check: one entry a kind (same rule, bus, node and object), with the "
        "annotated lines of its context. Exit codes: 0 nothing fails, 1 findings fail, 2 a file could not be read. "
        "Known findings may be kept in a baseline, of which only more fail; what a capture must show is written as "
        "expectations (canalyze expect --help); exceptions by file, node and bus, with their reasons, are "
        "[[check.override]] of canalyze.toml (below; files, nodes and bus may be left out; of several that fit the "
        "last one counts). A file that cannot be read does not hide the results of others.",
    ),
    (
        "check.fail_on",
        "此级别及更严重的发现算作不合格，并在报告中列出；never：都不算。默认 warning；用 info 可看到全部发现。",
        "Findings of this severity or a worse one fail the check and are shown; never: none do. warning by default; "
        "info shows every finding.",
    ),
    (
        "check.select",
        "只检查这些规则：代码或其开头，用逗号隔开，如 SDO,HBT001；可重复。比 --ignore 写得更长的优先。",
        "Only these rules: codes or their beginnings, with commas between, such as SDO,HBT001; may be repeated. A "
        "longer one wins over --ignore.",
    ),
    (
        "check.ignore",
        "不检查这些规则，写法相同；可重复。比 --select 写得更长或一样长的优先。",
        "Not these rules, in the same form; may be repeated. A longer one, or one as long, wins over --select.",
    ),
    (
        "check.baseline",
        "已知发现和问题的文件：每类在一个记录中不超过其中的次数即为合格；不再出现的条目在标准错误上指出。",
        "A file of known findings and problems: a kind fails only where a capture has more of it; entries that no "
        "longer occur are named on standard error.",
    ),
    (
        "check.update_baseline",
        "把此次不合格的发现和问题写入基线文件（原有内容被取代），退出码为0。",
        "Write the baseline anew, of what would fail now, and exit with 0.",
    ),
    (
        "check.expect",
        "按这个期望文件（TOML）检验每个记录；不给则用记录旁边的 NAME.expect.toml（若有）。"
        "写法见 canalyze expect --help。",
        "Judge every capture by this file of expectations (TOML); without it by NAME.expect.toml beside the capture, "
        "if there is one. canalyze expect --help shows its form.",
    ),
    ("check.no_expect", "不用记录旁边的期望文件。", "Leave out expectations beside a capture."),
    (
        "check.format",
        "text 给人看；jsonl 每类发现一个JSON对象，每个文件末尾再有一个；github 是GitHub Actions的注解。",
        "text for people; jsonl is one JSON object a kind of finding and one at the end of each file; github is "
        "annotations of GitHub Actions.",
    ),
    (
        "check.incidents",
        "同时诊断，并按问题判断：stands 仍存在的问题不合格，over 已恢复的也不合格，never 只列出。也可写在 [check] 里。",
        "Diagnose, too, and judge by problems: stands (those that stand fail), over (those that are over as well), "
        "never (they are only listed). Also a key of [check].",
    ),
    ("check.problem", "问题", "problem"),
    ("check.problems", "问题 {count}", "problems: {count}"),
    ("check.junit", "另写一份JUnit报告（XML）。", "Also write a JUnit report (XML)."),
    ("check.sarif", "另写一份SARIF 2.1.0报告（JSON）。", "Also write a SARIF 2.1.0 report (JSON)."),
    ("check.examples", _EXAMPLES, _EXAMPLES),
    # The report.
    ("check.file", "{name}：{said}", "{name}: {said}"),
    ("check.entry", "{head}：{message}", "{head}: {message}"),
    ("check.then", "，", ", "),
    ("check.clean", "合格", "clean"),
    ("check.foreign", "不是CANopen", "not CANopen"),
    ("check.unproven", "没有报文表明是CANopen", "nothing shows that it is CANopen"),
    ("check.silent", "没有数据帧", "no data frames"),
    ("check.unjudged", "未作判断", "nothing judged"),
    ("check.none", "没有不合格的发现", "nothing fails"),
    ("check.frames", "{frames}帧", "frames: {frames}"),
    ("check.error", "错误 {count}", "errors: {count}"),
    ("check.warning", "警告 {count}", "warnings: {count}"),
    ("check.info", "提示 {count}", "infos: {count}"),
    ("check.consequences", "后果 {count}", "consequences: {count}"),
    ("check.known", "基线内 {count}", "in the baseline: {count}"),
    ("check.overruled", "忽略 {count}", "ignored: {count}"),
    ("check.unreadable", "未能检查", "not checked"),
    ("check.unread", "没有读完", "not read to its end"),
    ("check.node", "节点{node}", "node {node}"),
    ("check.frame", "第{frame}帧", "frame {frame}"),
    ("check.line", "第{line}行", "line {line}"),
    ("check.times", "共{count}次", "{count} times"),
    ("check.times_known", "共{count}次，基线 {known}", "{count} times, baseline {known}"),
    ("check.also", "；又见第{frames}帧", "; also at frames {frames}"),
    ("check.between", "、", ", "),
    ("check.and_more", "……", " ..."),
    ("check.reason", "按例外处理的发现 {count}：{reason}", "findings overridden: {count}, {reason}"),
    ("check.by_rule", "{rule}：共{count}次（{files}个文件）", "{rule}: {count} (files: {files})"),
    ("check.expectations", "期望：{said}", "expectations: {said}"),
    ("check.expected_by", "{name}（{files}个文件）", "{name} (files: {files})"),
    (
        "check.expected_by_files",
        "{expected}个期望文件（{files}个文件）",
        "{expected} files of them (captures: {files})",
    ),
    ("check.expected_by_none", "没有期望的文件 {files}", "captures without: {files}"),
    ("check.total", "合计：{said}", "total: {said}"),
    ("check.files", "{files}个文件", "files: {files}"),
    ("check.in_files", "（{files}个文件）", " (in files: {files})"),
    ("check.unread_files", "未检查完的文件 {files}", "files not fully checked: {files}"),
    ("check.died", "{name}：处理它的进程意外结束（{by}）", "{name}: the process that worked on it has died ({by})"),
    (
        "check.broken_off",
        "检查被中断：没有读完的文件 {count}，所列只是中断前的结果",
        "the check was broken off, files not read to their end: {count}; this is what was known by then",
    ),
    # The baseline.
    (
        "check.no_baseline",
        "--update-baseline 需要 --baseline，或 canalyze.toml 中 [check] 的 baseline",
        "--update-baseline needs --baseline, or baseline in [check] of canalyze.toml",
    ),
    (
        "baseline.missing",
        "{file}：没有这个基线文件；加 --update-baseline 生成",
        "{file}: no such baseline; --update-baseline writes it",
    ),
    ("baseline.read", "{file}：不能读取基线：{error}", "{file}: the baseline cannot be read: {error}"),
    (
        "baseline.broken",
        "{file}：基线不是有效的JSON（解析器的原话：“{problem}”）；可用 --update-baseline 重新生成",
        "{file}: the baseline is not valid JSON (the parser says: {problem}); --update-baseline writes it anew",
    ),
    (
        "baseline.none",
        '{file}：不是基线文件；应以 {{"canalyze_baseline": 1, "findings": [ 开头，由 --update-baseline 生成',
        '{file}: no baseline, which begins with {{"canalyze_baseline": 1, "findings": [; --update-baseline writes one',
    ),
    (
        "baseline.other",
        "{file}：已存在，且不是基线文件；--update-baseline 不覆盖它",
        "{file}: exists and is no baseline; --update-baseline does not overwrite it",
    ),
    (
        "baseline.version",
        "{file}：基线的版本是 {version}，此程序只认得 {own}；可用 --update-baseline 重新生成",
        "{file}: a baseline of version {version}, only {own} is known here; --update-baseline writes it anew",
    ),
    (
        "baseline.entry",
        '{file}：基线条目的 {key} 不能是 {value}；条目如 {{"code": "SDO001", "bus": "can0" 或 null, "node": 5 或 null, '
        '"object": "1017:00" 或 null, "count": 1}}',
        '{file}: {key} of an entry of the baseline: {value} is not allowed; an entry is {{"code": "SDO001", "bus": '
        '"can0" or null, "node": 5 or null, "object": "1017:00" or null, "count": 1}}',
    ),
    (
        "baseline.problem",
        '{file}：基线条目的 {key} 不能是 {value}；条目如 {{"kind": "node-silent", "bus": "can0" 或 null, '
        '"subject": "node 5" 或 null, "object": "1017:00" 或 null, "count": 1}}',
        '{file}: {key} of an entry of the baseline: {value} is not allowed; an entry is {{"kind": "node-silent", '
        '"bus": "can0" or null, "subject": "node 5" or null, "object": "1017:00" or null, "count": 1}}',
    ),
    (
        "baseline.twice",
        "{file}：基线中已有同一条目（{code}，总线、节点或对象等都相同）",
        "{file}: the baseline has this entry already ({code}, all else the same, too)",
    ),
    (
        "baseline.gone",
        "{name}：不再出现：{entry}；--update-baseline 可将其去掉",
        "{name}: no longer occurs: {entry}; --update-baseline takes it out",
    ),
    (
        "baseline.fewer",
        "{name}：每个文件最多只出现{count}次，基线为{known}次：{entry}；--update-baseline 可将其改小",
        "{name}: at most {count} times in a capture, baseline {known}: {entry}; --update-baseline lowers it",
    ),
    (
        "baseline.more_gone",
        "{name}：不再出现或出现次数减少的条目还有{count}条",
        "{name}: {count} more entries no longer occur, or not as often",
    ),
    ("baseline.written", "{name}：已写入基线，{count}条", "{name}: baseline written, entries: {count}"),
    (
        "baseline.kept",
        "{name}：基线未更新，因为有文件没有读完",
        "{name}: the baseline is kept as it was, since not all files could be read",
    ),
    # What cannot be.
    (
        "check.no_stdout",
        "选项 {option} 需要一个文件名；标准输出留给 --format 的报告",
        "option {option} needs the name of a file; standard output is for the report of --format",
    ),
    (
        "usage.codes",
        "选项 {option} 不能是 {value}，可以是规则的代码或其开头，用逗号隔开，如 SDO,HBT001；见 canalyze rules",
        "option {option}: {value} is not of the form SDO,HBT001: codes of rules or their beginnings; canalyze rules "
        "lists them",
    ),
    (
        "usage.no_rule",
        "选项 {option}：没有规则以 {value} 开头，最接近的是 {near}",
        "option {option}: no rule begins with {value}; the nearest are {near}",
    ),
    (
        "config.no_rule",
        "{file}：配置项 {key}：没有规则以 {value} 开头，最接近的是 {near}",
        "{file}: key {key}: no rule begins with {value}; the nearest are {near}",
    ),
    (
        "config.threshold",
        '{file}：配置项 {key} 不能是 {value}，可以是 "error", "warning", "info", "never"',
        '{file}: key {key}: {value} is not one of "error", "warning", "info", "never"',
    ),
    (
        "config.ruling",
        '{file}：配置项 {key} 不能是 {value}，可以是 "ignore", "info", "warning", "error"',
        '{file}: key {key}: {value} is not one of "ignore", "info", "warning", "error"',
    ),
    (
        "config.codes",
        '{file}：配置项 {key} 不能是 {value}，可以是规则的代码或其开头，如 ["SDO", "HBT001"]',
        '{file}: key {key}: {value} does not hold codes of rules or their beginnings, such as ["SDO", "HBT001"]',
    ),
    (
        "config.globs",
        '{file}：配置项 {key} 不能是 {value}，可以是文件名，带通配符也行，如 ["captures/**/*.log"]',
        '{file}: key {key}: {value} does not hold names of files or patterns, such as ["captures/**/*.log"]',
    ),
    (
        "config.several_nodes",
        '{file}：配置项 {key} 不能是 {value}，可以是1到127的节点ID，如 [5, "7-9"]',
        '{file}: key {key}: {value} does not hold node-IDs, 1 to 127, such as [5, "7-9"]',
    ),
    (
        "source.no_match",
        "{name}：没有符合的文件",
        "{name}: no file fits",
    ),
    (
        "source.directory",
        "{name}：是目录；请写明检查其中哪些文件，如 {pattern}",
        "{name}: is a directory; say which files in it, such as {pattern}",
    ),
)
