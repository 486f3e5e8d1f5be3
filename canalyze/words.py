"""Python's own words: help, errors, headings.

Rows (key, zh, en), complete in both languages; a test keeps it. Words about frames stand in the core (`text/`), never
here, and nothing outside this file prints a sentence of its own.
"""

from typing import Final

LANGUAGES: Final = ("zh", "en")

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    # Help: the parts of a page.
    ("help.usage", "用法：", "Usage: "),
    ("help.options", "选项", "Options"),
    ("help.commands", "命令", "Commands"),
    ("help.examples", "例子", "Examples"),
    ("help.completion", "命令行补全", "Shell completion"),
    # Options that every command has.
    ("opt.help", "显示这页说明。", "Show this page."),
    ("opt.version", "显示版本。", "Show the version."),
    (
        "opt.lang",
        "输出语言；先看此选项，再看环境变量 CANALYZE_LANG，再看 canalyze.toml，都没有则为 zh。",
        "Language of all words; else CANALYZE_LANG, else canalyze.toml, else zh.",
    ),
    (
        "opt.config",
        "配置文件；不给则用当前目录的 canalyze.toml（若有）。",
        "Configuration file; without it canalyze.toml of the current directory, if there is one.",
    ),
    # Options that several commands share.
    (
        "opt.output",
        "写入文件而不是标准输出；先写在旁边，完成后才改名。",
        "Write to a file instead of standard output; it is written beside and renamed when complete.",
    ),
    ("opt.force", "允许覆盖已有的文件。", "Overwrite files that exist."),
    (
        "opt.filter",
        "只显示符合条件的帧，如 'service=sdo,emcy node=5 id=180-1FF bus=can1 t=1.0..2.5'；"
        "空格是“且”，逗号是“或”；状态仍由全部帧得出。t 的单位是秒：小于100000000时从记录的第一帧算起，否则是绝对时间。",
        "Show only what fits, e.g. 'service=sdo,emcy node=5 id=180-1FF bus=can1 t=1.0..2.5'; "
        "blank is and, comma is or; state still comes from every frame. t is in seconds: below 100000000 since the "
        "first frame of the capture, else absolute.",
    ),
    (
        "opt.stamps",
        "文件里的时间戳是什么：绝对时间、从零开始、与上一帧之差；auto 由内容判断。",
        "What the stamps of the input are: absolute, zero-based or deltas; auto decides by content.",
    ),
    # canalyze
    ("canalyze.usage", "[选项] 命令 [参数]...", "[OPTIONS] COMMAND [ARGS]..."),
    (
        "canalyze.help",
        "被动式CANopen分析器：读candump的记录，结合此前的全部报文说明每一帧的含义。从不发送任何帧。",
        "A passive CANopen analyzer: reads candump captures and says what each frame means, given everything seen "
        "before it. It never sends a frame.",
    ),
    (
        "canalyze.examples",
        "canalyze decode samples/zephyr-sdo.log      逐帧注释一个记录\n"
        "candump can0 | canalyze decode -            实时注释\n"
        "canalyze explain '60A#4008100000000000'     逐字段解释一帧\n"
        "canalyze sdo capture.log --extract out/     列出SDO传输并取出数据\n"
        "canalyze --lang en decode --help            英文说明",
        "canalyze decode samples/zephyr-sdo.log      annotate a capture frame by frame\n"
        "candump can0 | canalyze decode -            annotate live\n"
        "canalyze explain '60A#4008100000000000'     explain one frame field by field\n"
        "canalyze sdo capture.log --extract out/     list SDO transfers, take out their data\n"
        "canalyze --lang zh decode --help            help in Chinese",
    ),
    (
        "canalyze.completion",
        'bash   eval "$(_CANALYZE_COMPLETE=bash_source canalyze)"    写入 ~/.bashrc\n'
        'zsh    eval "$(_CANALYZE_COMPLETE=zsh_source canalyze)"     写入 ~/.zshrc\n'
        "fish   _CANALYZE_COMPLETE=fish_source canalyze | source     写入 config.fish",
        'bash   eval "$(_CANALYZE_COMPLETE=bash_source canalyze)"    in ~/.bashrc\n'
        'zsh    eval "$(_CANALYZE_COMPLETE=zsh_source canalyze)"     in ~/.zshrc\n'
        "fish   _CANALYZE_COMPLETE=fish_source canalyze | source     in config.fish",
    ),
    # decode
    ("decode.short", "逐帧注释记录", "Annotate captures frame by frame"),
    ("decode.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "decode.help",
        "逐帧注释记录：每行是candump屏幕格式的一帧，后面是它的含义。多个文件按给出的顺序当作同一个记录。"
        "“-”是标准输入；不给文件而有管道时也读标准输入，每一行立即输出。读不懂的行在标准错误上指出并计数，不会中断。",
        "Annotate captures: each line is a frame in candump's console form, followed by what it means. Several files "
        "are one capture in the given order. '-' is standard input, which is also read when no file is given and it "
        "is a pipe; every line comes out at once. Lines that cannot be read are named and counted on standard error "
        "and never stop the run.",
    ),
    ("decode.brief", "只写简短的说法，不带内容。", "Only the phrase, without the content."),
    (
        "decode.explain",
        "每帧下面再加以 # 开头的逐字段、逐位解释。",
        "Under each frame, as # lines, explain every field and bit.",
    ),
    (
        "decode.format",
        "text 给人看；jsonl 每行一个JSON对象。",
        "text for people; jsonl is one JSON object a line.",
    ),
    (
        "decode.time",
        "时间的写法，同candump：a 绝对，d 与上一帧之差，z 从零开始，A 日期和时间(UTC)，n 不写；不给则照原样。",
        "How stamps are written, as in candump: a absolute, d delta, z zero-based, A date and time in UTC, n none; "
        "without it as they came.",
    ),
    (
        "decode.examples",
        "canalyze decode capture.log\n"
        "canalyze decode --explain --filter 'service=sdo node=10' capture.log\n"
        "canalyze decode part1.log part2.log -o all.txt\n"
        "candump -ta can0 | canalyze decode -\n"
        "canalyze decode --format jsonl capture.log | jq -r .text",
        "canalyze decode capture.log\n"
        "canalyze decode --explain --filter 'service=sdo node=10' capture.log\n"
        "canalyze decode part1.log part2.log -o all.txt\n"
        "candump -ta can0 | canalyze decode -\n"
        "canalyze decode --format jsonl capture.log | jq -r .text",
    ),
    # explain
    ("explain.short", "逐字段解释一帧", "Explain one frame field by field"),
    ("explain.usage", "[选项] 帧...", "[OPTIONS] FRAME..."),
    (
        "explain.help",
        "逐字段、逐位解释一帧或几帧。帧可以是cansend的写法，也可以是贴进来的一行candump输出（引号可省）；“-”从标准输入逐行读，"
        "跳过空行和以 # 开头的行。"
        "单独的一帧没有上下文，所以只说它自身能说明的内容。",
        "Explain a frame, or several, every field and bit. A frame is in cansend's form or a pasted line of candump "
        "(quotes may be left out); '-' reads lines from standard input and skips blank lines and those that begin "
        "with #. A frame alone has no history, so only what it says by itself is said.",
    ),
    (
        "explain.examples",
        "canalyze explain '60A#4008100000000000'\n"
        "canalyze explain '60A#4008100000000000' '58A#4108100017000000'\n"
        "canalyze explain can1  58A   [8]  41 08 10 00 17 00 00 00\n"
        "canalyze explain '(1612345678.123456) can0 70A#05'\n"
        "tail -n 3 capture.log | canalyze explain -",
        "canalyze explain '60A#4008100000000000'\n"
        "canalyze explain '60A#4008100000000000' '58A#4108100017000000'\n"
        "canalyze explain can1  58A   [8]  41 08 10 00 17 00 00 00\n"
        "canalyze explain '(1612345678.123456) can0 70A#05'\n"
        "tail -n 3 capture.log | canalyze explain -",
    ),
    (
        "explain.no_frame",
        "这不是一帧：{line}；可以写成 60A#4008100000000000 或 can1  60A   [8]  40 08 10 00 00 00 00 00",
        "not a frame: {line}; write it as 60A#4008100000000000 or can1  60A   [8]  40 08 10 00 00 00 00 00",
    ),
    (
        "explain.no_frame_at",
        "{name}:{number}: 这不是一帧：{line}；可以写成 60A#4008100000000000 或 "
        "can1  60A   [8]  40 08 10 00 00 00 00 00",
        "{name}:{number}: not a frame: {line}; write it as 60A#4008100000000000 or "
        "can1  60A   [8]  40 08 10 00 00 00 00 00",
    ),
    (
        "explain.nothing",
        "没有给出帧；例如 canalyze explain '60A#4008100000000000'，或用 - 从标准输入读",
        "no frame given; e.g. canalyze explain '60A#4008100000000000', or - for standard input",
    ),
    (
        "explain.empty",
        "{name}：里面没有帧；每行给出一帧，如 60A#4008100000000000",
        "{name}: there is no frame in it; give one a line, such as 60A#4008100000000000",
    ),
    # sdo
    ("sdo.short", "列出SDO传输，取出其数据", "List SDO transfers, take out their data"),
    ("sdo.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "sdo.help",
        "列出SDO传输：对象、值、字节数、方式、耗时、结果。文件的给法与decode相同。",
        "List SDO transfers: object, value, size, mode, duration, outcome. Files are given as for decode.",
    ),
    ("sdo.format", "text 是表格；jsonl 每行一个传输。", "text is a table; jsonl is one transfer a line."),
    (
        "sdo.extract",
        "把每个传输的数据写入此目录，一个传输一个文件；没有成功的以其结果作后缀（.aborted .incomplete .failed）。",
        "Write the data of each transfer to this directory, one file each; those that did not succeed end in their "
        "outcome (.aborted .incomplete .failed).",
    ),
    (
        "sdo.examples",
        "canalyze sdo capture.log\n"
        "canalyze sdo capture.log --filter node=10 --extract out/\n"
        "canalyze sdo --format jsonl capture.log | jq -r 'select(.status != \"ok\")'\n"
        "candump can0 | canalyze sdo -",
        "canalyze sdo capture.log\n"
        "canalyze sdo capture.log --filter node=10 --extract out/\n"
        "canalyze sdo --format jsonl capture.log | jq -r 'select(.status != \"ok\")'\n"
        "candump can0 | canalyze sdo -",
    ),
    ("sdo.none", "{frames}帧中没有SDO传输", "no SDO transfer in {frames} frames"),
    (
        "sdo.extracted",
        "已将{files}个文件写入 {directory}",
        "files written to {directory}: {files}",
    ),
    (
        "sdo.kept",
        "{name}：文件已存在，未覆盖；要覆盖请加 --force",
        "{name}: exists and is kept; --force overwrites it",
    ),
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
    ("col.access", "读写", "access"),
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
    # rules
    ("rules.short", "列出或解释检查规则", "List the rules, or explain one"),
    ("rules.usage", "[选项] [代码]...", "[OPTIONS] [CODE]..."),
    (
        "rules.help",
        "列出检查规则；给出代码则解释它（大小写不限）。",
        "List the rules; with a code (in either case), explain it.",
    ),
    ("rules.format", "text 给人看；jsonl 每行一条规则。", "text for people; jsonl is one rule a line."),
    (
        "rules.examples",
        "canalyze rules\ncanalyze rules SDO001\ncanalyze rules --format jsonl",
        "canalyze rules\ncanalyze rules SDO001\ncanalyze rules --format jsonl",
    ),
    (
        "rules.unknown",
        "没有规则 {code}；全部规则见 canalyze rules",
        "no rule {code}; canalyze rules lists them",
    ),
    (
        "rules.near",
        "没有规则 {code}；最接近的是 {near}",
        "no rule {code}; the nearest are {near}",
    ),
    ("col.code", "代码", "code"),
    ("col.severity", "级别", "severity"),
    ("col.rule", "名称", "name"),
    ("col.message", "含义", "message"),
    ("severity.error", "错误", "error"),
    ("severity.warning", "警告", "warning"),
    ("severity.info", "提示", "info"),
    ("rules.clause", "依据", "clause"),
    ("rules.no_clause", "无", "none"),
    ("rules.meaning", "含义", "what it means"),
    ("rules.cause", "常见原因", "usual causes"),
    # Usage errors; {command} is what was typed, such as `canalyze decode`.
    ("usage.line", "{command}: {problem}；用法见 {command} --help", "{command}: {problem}; see {command} --help"),
    (
        "usage.core_line",  # {problem} is a sentence of the core, with its punctuation
        "{command}: {problem}; 用法见 {command} --help",
        "{command}: {problem}; see {command} --help",
    ),
    ("usage.no_option", "没有选项 {option}", "no such option: {option}"),
    ("usage.no_option_near", "没有选项 {option}，是 {near} 吗", "no such option: {option}, did you mean {near}"),
    ("usage.no_command", "没有命令 {name}", "no such command: {name}"),
    ("usage.no_command_near", "没有命令 {name}，是 {near} 吗", "no such command: {name}, did you mean {near}"),
    ("usage.or", " 或 ", " or "),
    ("usage.needs_value", "选项 {option} 需要一个值", "option {option} needs a value"),
    ("usage.takes_no_value", "选项 {option} 不带值", "option {option} takes no value"),
    (
        "usage.choice",
        "选项 {option} 不能是 {value}，可以是 {choices}",
        "option {option}: {value} is not one of {choices}",
    ),
    ("usage.missing", "缺少 {what}", "missing {what}"),
    ("usage.exclusive", "{one} 和 {other} 不能同时使用", "{one} and {other} exclude each other"),
    (
        "usage.text_only",
        "{option} 只用于 --format text",
        "{option} is only for --format text",
    ),
    (
        "usage.no_input",
        "没有给出文件；给出文件名，或用 - 读标准输入",
        "no file given; name a file, or - for standard input",
    ),
    # Configuration.
    (
        "config.lang_option",
        "--lang 不能是 {value}，可以是 zh 或 en",
        "--lang: {value} is neither zh nor en",
    ),
    (
        "config.lang_env",
        "环境变量 CANALYZE_LANG 不能是 {value}，可以是 zh 或 en",
        "CANALYZE_LANG: {value} is neither zh nor en",
    ),
    ("config.unreadable", "{file}：不能读取配置：{error}", "{file}: the configuration cannot be read: {error}"),
    (
        "config.broken",
        "{file}:{line}:{column}: 不是有效的TOML（解析器的原话：“{problem}”）",
        "{file}:{line}:{column}: not valid TOML (the parser says: {problem})",
    ),
    ("config.not_utf8", "{file}:{line}: 不是UTF-8编码的文本", "{file}:{line}: not text in UTF-8"),
    (
        "config.unknown",
        "{file}：没有配置项 {key}，可以有的是 {allowed}",
        "{file}: unknown key {key}; allowed: {allowed}",
    ),
    (
        "config.value",
        "{file}：配置项 {key} 不能是 {value}，可以是 {allowed}",
        "{file}: key {key}: {value} is not allowed; allowed: {allowed}",
    ),
    # Inputs and outputs.
    ("source.open", "{name}：不能打开：{error}", "{name}: cannot be opened: {error}"),
    ("source.read", "{name}：读取中断：{error}", "{name}: reading stopped: {error}"),
    ("source.empty", "{name}：里面什么都没有", "{name}: there is nothing in it"),
    (
        "source.nothing",
        "{name}：没有一行能读作CAN帧；可读的是candump的屏幕输出"
        "（can0  60A   [8]  40 ...）和记录（(时间) can0 60A#40...）",
        "{name}: no line of it can be read as a CAN frame; candump's console form (can0  60A   [8]  40 ...) and its "
        "log form ((stamp) can0 60A#40...) can",
    ),
    ("source.packed", "{name}：是{kind}压缩的；先解压：{line}", "{name}: {kind} compressed: {line}"),
    ("source.encoded", "{name}：是{kind}编码的文本；先转换：{line}", "{name}: text in {kind}: {line}"),
    (
        "source.other",
        "{name}：是{kind}文件，还不支持；目前只读candump的文本",
        "{name}: {kind}, not supported yet: only candump text",
    ),
    (
        "source.more_complaints",
        "{name}：此前还有{count}条同类提示",
        "{name}: {count} more such lines before this",
    ),
    ("output.exists", "{name}：文件已存在；要覆盖请加 --force", "{name}: exists; --force overwrites it"),
    ("output.write", "{name}：不能写入：{error}", "{name}: cannot be written: {error}"),
    ("output.stdout", "标准输出：不能写入：{error}", "standard output: cannot be written: {error}"),
    ("output.gone", "读取管道的程序已结束", "the reader of the pipe is gone"),
    (
        "output.english",
        "canalyze: 终端不能显示中文，改用英文；可用 --lang 指定",
        "canalyze: this terminal cannot show Chinese, so English is used; --lang chooses",
    ),
    ("progress.of", "{done}/{total} MB，{frames}帧", "{done}/{total} MB, {frames} frames"),
    ("progress.some", "{done} MB，{frames}帧", "{done} MB, {frames} frames"),
    (
        "core.missing",
        "编译好的核心不在（{problem}）；在源码目录里运行 pip install -e .",
        "the compiled core is missing ({problem}); run pip install -e . in the checkout",
    ),
    # Reasons of the operating system.
    ("os.missing", "没有这个文件或目录", "no such file or directory"),
    ("os.forbidden", "没有权限", "permission denied"),
    ("os.directory", "是目录，不是文件", "is a directory"),
    ("os.not_directory", "不是目录", "not a directory"),
    ("os.full", "磁盘已满", "no space left"),
    ("os.read_only", "文件系统是只读的", "read-only file system"),
    ("os.exists", "文件已存在", "file exists"),
    ("os.closed", "已经关闭", "it is closed"),
    ("os.io", "输入输出错误", "input/output error"),
    ("os.long_name", "文件名太长", "file name too long"),
)


class Words:
    """The words of one language: `words(key, **facts)` is the sentence."""

    def __init__(self, lang: str) -> None:
        """Take the column of `lang`, one of LANGUAGES."""
        self.lang = lang
        column = 1 + LANGUAGES.index(lang)
        self._table = {row[0]: row[column] for row in ROWS}

    def __call__(self, key: str, /, **facts: object) -> str:
        """Give the sentence of `key` with its facts filled in."""
        sentence = self._table[key]
        return sentence.format_map(facts) if facts else sentence

    def of(self, table: str, value: str) -> str:
        """Give the word for a value of the core, such as `block` of `mode`; the value itself if there is none."""
        return self._table.get(f"{table}.{value}", value)
