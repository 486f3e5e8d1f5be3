"""The command `info`: its page of help, its report.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    (
        "info.short",
        "说明记录文件本身：格式、总线、时间、损坏",
        "Show what a capture file is: format, buses, time, damage",
    ),
    ("info.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "info.help",
        "说明每个文件本身：格式和方言、压缩、大小、总线及其帧数、时间范围和精度、各类帧的数量、topic及其读法、"
        "跳过的内容、无法读取的行、损坏及其位置。每个文件单独说明，不解析CANopen，所以很快。没有CAN帧的文件也说明其内容。",
        "Show what each file is: format and dialect, compression, size, buses with their frames, span and resolution "
        "of time, frames by kind, topics and how they are read, what was passed over, lines that cannot be read, "
        "damage and where. Each file is by itself, and nothing of CANopen is decoded, so it is fast. A file without "
        "CAN frames shows what it has.",
    ),
    (
        "info.format",
        "text 给人看；jsonl 每个文件一个JSON对象。",
        "text for people; jsonl is one JSON object a file.",
    ),
    (
        "info.examples",
        "canalyze info capture.log\n"
        "canalyze info *.log.gz\n"
        "canalyze info --format jsonl *.log | jq -r '[.file, .frames, .first_date] | @tsv'\n"
        "zcat capture.log.gz | canalyze info -",
        "canalyze info capture.log\n"
        "canalyze info *.log.gz\n"
        "canalyze info --format jsonl *.log | jq -r '[.file, .frames, .first_date] | @tsv'\n"
        "zcat capture.log.gz | canalyze info -",
    ),
    ("info.format_row", "格式", "format"),
    ("info.dialect", "方言", "dialect"),
    ("info.frames", "帧数", "frames"),
    ("info.time", "时间", "time"),
    ("info.buses", "总线", "buses"),
    ("info.topics", "topic", "topics"),
    ("info.passed_over", "跳过", "passed over"),
    ("info.quality", "质量", "quality"),
    ("info.title.candump", "candump文本", "candump text"),
    ("info.title.asc", "Vector ASC", "Vector ASC"),
    ("info.title.mcap", "MCAP", "MCAP"),
    ("info.title.blf", "Vector BLF", "Vector BLF"),
    ("info.title.trc", "PEAK TRC", "PEAK TRC"),
    ("info.title.mf4", "MF4", "MF4"),
    ("info.title.csv", "CSV", "CSV"),
    ("info.title.sqlite", "SQLite", "SQLite"),
    ("info.plain", "{format}，{size}字节", "{format}, {size} bytes"),
    (
        "info.packed",
        "{format}，{compression}压缩，压缩后{size}字节",
        "{format}, {compression} compressed to {size} bytes",
    ),
    ("info.bus", "{bus}：{frames}帧", "{bus}: {frames} frames"),
    ("info.nameless", "（没有写明）", "(not named)"),
    ("info.more", "…还有{count}个", "... {count} more"),
    ("info.then", "，", ", "),
    ("info.data", "数据帧 {count}", "data {count}"),
    ("info.remote", "远程帧 {count}", "remote {count}"),
    ("info.fd", "CAN FD帧 {count}", "CAN FD {count}"),
    ("info.error", "错误帧 {count}", "error {count}"),
    ("info.standard", "标准帧（11位ID） {count}", "standard (11-bit ID) {count}"),
    ("info.extended", "扩展帧（29位ID） {count}", "extended (29-bit ID) {count}"),
    ("info.rx", "接收 {count}", "received {count}"),
    ("info.tx", "发送 {count}", "sent {count}"),
    ("info.no_stamps", "没有时间戳", "no stamps"),
    ("info.unstamped", "没有时间戳的帧：{count}", "frames without a stamp: {count}"),
    ("info.dates", "{first} 到 {last}（{zone}）", "{first} to {last} ({zone})"),
    ("info.utc", "UTC", "UTC"),
    (
        "info.local",
        "按文件所写，未注明时区，一般是记录地的当地时间",
        "as the file has it, zone not told: local time where it was recorded, as a rule",
    ),
    ("info.stamps", "{first} 到 {last}（秒，起点未知）", "{first} to {last} (seconds since a start that is not told)"),
    ("info.span", "共 {seconds} s，时间戳有 {digits} 位小数", "{seconds} s, stamps have {digits} decimals"),
    (
        "info.backward",
        "时间戳倒退：{count} 次，最多 {most} ms",
        "stamps earlier than the one before: {count}, by {most} ms at most",
    ),
    ("info.messages", "{count}条消息", "messages: {count}"),
    ("info.read_as", "按 {fields} 读作CAN帧", "read as CAN frames by {fields}"),
    ("info.not_read", "不读作CAN帧", "not read as CAN frames"),
    ("info.unreadable", "无法读取：{count}处，首先是{place}", "cannot be read: {count}, first {place}"),
    ("info.clamped_stamps", "超出可表示范围的时间戳：{count}个", "stamps out of range: {count}"),
    ("info.unreadable_somewhere", "无法读取：{count}处", "cannot be read: {count}"),
    (
        "info.further_buses",
        "总线过多：其余总线上的 {count} 帧已跳过",
        "too many buses; what is on further ones was passed over, frames: {count}",
    ),
    ("info.gaps", "丢帧：记录程序报告 {count} 次，共 {frames} 帧", "dropped: {frames} frames, in {count} reports"),
    ("info.left_out", "缺行：{places} 处，共 {rows} 行", "rows left out: {rows}, in {places} places"),
    (
        "info.left_out_unknown",
        "缺行：{places} 处，均未注明数目",
        "rows left out: in {places} places, how many is not told",
    ),
    (
        "info.left_out_partly",
        "缺行：{places} 处，其中 {uncounted} 处未注明数目，其余共 {rows} 行",
        "rows left out: in {places} places, {uncounted} of them without a number, {rows} in the others",
    ),
    ("info.error_markers", "没有内容的错误标记：{count}", "error markers without content: {count}"),
    ("info.damage", "损坏：{place}，{kind}", "damage at {place}: {kind}"),
    ("info.lost_bytes", "损失{count}字节", "{count} bytes lost"),
    ("info.lost_frames", "损失{count}帧", "{count} frames lost"),
    ("info.doubtful_frames", "{count}帧可能有误", "{count} frames may be wrong"),
    ("info.unchecked", "没有校验和，内容被改动无法察觉", "without a check sum: changes of it cannot be seen"),
    ("info.line", "第{line}行", "line {line}"),
    ("info.offset", "偏移{offset}", "byte {offset}"),
    ("info.whole", "没有损坏，没有无法读取的内容", "no damage, nothing that cannot be read"),
    ("damage.cut", "文件在一条记录中间结束", "the file ends in the middle of a record"),
    ("damage.checksum", "校验和不符", "the check sum does not match"),
    ("damage.structure", "长度或类型无效", "a length or type that cannot be"),
    ("damage.compression", "压缩数据损坏", "compressed data are damaged"),
    (
        "damage.doubtful",
        "压缩数据损坏，由此起解出的内容都可能有误",
        "compressed data are damaged, all unpacked from here on may be wrong",
    ),
    ("damage.definition", "此处损坏，其中的定义只能照用", "what is damaged here defines topics, and had to be used"),
    ("damage.missing", "按文件自身的统计缺少消息", "messages are missing by the file's own statistics"),
    (
        "damage.unlocated",
        "全部数据的校验和不符，看不出损坏在何处",
        "the check sum over all of the data does not match, and nothing shows where",
    ),
    (
        "damage.undefined",
        "消息所属的topic没有定义或定义无法使用",
        "messages of topics whose definition is lost or cannot be used",
    ),
    ("damage.rest", "文件的其余部分无法读取", "the rest of the file cannot be read"),
)
