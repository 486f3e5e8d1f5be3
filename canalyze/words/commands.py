"""What each command says of itself: its page of help, its own options, headings and errors.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    # decode
    ("decode.short", "逐帧注释记录", "Annotate captures frame by frame"),
    ("decode.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "decode.help",
        "逐帧注释记录：每行是candump屏幕格式的一帧，后面是它的含义。多个文件按给出的顺序当作同一个记录。"
        "“-”是标准输入；不给文件而有管道时也读标准输入，每一行立即输出。无法读取的行在标准错误上指出并计数，不会中断。"
        "可读candump的屏幕输出和记录、Vector ASC和BLF、MCAP、pcap、pcapng、PEAK TRC、MF4，以及python-can的CSV和SQLite，"
        "也可以经gzip、zstd、xz或bzip2压缩；都由内容判断。",
        "Annotate captures: each line is a frame in candump's console form, followed by what it means. Several files "
        "are one capture in the given order. '-' is standard input, which is also read when no file is given and it "
        "is a pipe; every line comes out at once. Lines that cannot be read are named and counted on standard error "
        "and never stop the run. Read are candump's console form and log, Vector ASC and BLF, MCAP, pcap, pcapng, PEAK "
        "TRC, MF4, python-can's CSV and SQLite, also compressed by gzip, zstd, xz or bzip2; content tells which.",
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
        "decode.incidents",
        "另写出问题(与 diagnose 相同)的变化：text 为注释行；jsonl 为 kind 是 incident 的对象，phase 依次为 "
        "opened(出现)、linked(找到起因)、ended(恢复)，结束时每个问题再写一次 final。不受 --filter 影响。",
        "Also tell of problems, those of diagnose, as they change: text has comment lines, jsonl objects of the kind "
        "incident whose phase is opened, linked (its cause is found), ended, and at the end final for each. A filter "
        "does not apply to them.",
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
        "canalyze decode --eds 5=drive.eds --eds 1-4=io.eds capture.log\n"
        "canalyze decode part1.log part2.log -o all.txt\n"
        "canalyze decode --merge can0.log.gz can1.log.gz\n"
        "candump -ta can0 | canalyze decode -\n"
        "canalyze decode --format jsonl capture.log | jq -r .text",
        "canalyze decode capture.log\n"
        "canalyze decode --explain --filter 'service=sdo node=10' capture.log\n"
        "canalyze decode --eds 5=drive.eds --eds 1-4=io.eds capture.log\n"
        "canalyze decode part1.log part2.log -o all.txt\n"
        "canalyze decode --merge can0.log.gz can1.log.gz\n"
        "candump -ta can0 | canalyze decode -\n"
        "canalyze decode --format jsonl capture.log | jq -r .text",
    ),
    # explain
    ("explain.short", "解释一帧、一个代码或一个术语", "Explain a frame, a code or a term"),
    ("explain.usage", "[选项] 帧...", "[OPTIONS] FRAME..."),
    (
        "explain.help",
        "逐字段、逐位解释一帧或几帧。帧可以是cansend的写法，也可以是贴进来的一行candump输出（引号可省）；“-”从标准输入逐行读，"
        "跳过空行和以 # 开头的行。"
        "单独的一帧没有上下文，所以只说它自身能说明的内容。也可以给出代码：规则(HBT002)、问题的种类(node-silent)、SDO中止码、"
        "EMCY代码、错误寄存器、状态字、控制字、对象、COB-ID；或CANopen的术语(SYNC窗口、抑制时间、寿命保护、块传输)，"
        "说明它是什么、在哪里定义、常见错误。",
        "Explain a frame, or several, every field and bit. A frame is in cansend's form or a pasted line of candump "
        "(quotes may be left out); '-' reads lines from standard input and skips blank lines and those that begin "
        "with #. A frame alone has no history, so only what it says by itself is said. Codes are explained, too: "
        "a rule (HBT002), a kind of problem (node-silent), an SDO abort code, an EMCY code, an error register, "
        "a statusword or controlword, an object, a COB-ID; and terms of CANopen (sync window, inhibit time, life "
        "guarding, block transfer): what it is, where it is defined, what usually goes wrong.",
    ),
    (
        "explain.eds",
        "设备描述（EDS、DCF、XDD），给出对象的名称和PDO的COB-ID；可重复。不写节点时适用于任何节点的对象。",
        "A device description (EDS, DCF, XDD), for names of objects and COB-IDs of PDOs; may be repeated. Without a "
        "node it holds for objects of any.",
    ),
    (
        "explain.examples",
        "canalyze explain '60A#4008100000000000'\n"
        "canalyze explain '60A#4008100000000000' '58A#4108100017000000'\n"
        "canalyze explain can1  58A   [8]  41 08 10 00 17 00 00 00\n"
        "canalyze explain '(1612345678.123456) can0 70A#05'\n"
        "canalyze explain 06020000h 8130h 'statusword 0218' 'register 11' 1016h:01 182\n"
        "canalyze explain 'heartbeat consumer time' 'sync window' node-silent\n"
        "canalyze explain --eds 5=drive.eds 2000h 185 '185#0102'\n"
        "tail -n 3 capture.log | canalyze explain -",
        "canalyze explain '60A#4008100000000000'\n"
        "canalyze explain '60A#4008100000000000' '58A#4108100017000000'\n"
        "canalyze explain can1  58A   [8]  41 08 10 00 17 00 00 00\n"
        "canalyze explain '(1612345678.123456) can0 70A#05'\n"
        "canalyze explain 06020000h 8130h 'statusword 0218' 'register 11' 1016h:01 182\n"
        "canalyze explain 'heartbeat consumer time' 'sync window' node-silent\n"
        "canalyze explain --eds 5=drive.eds 2000h 185 '185#0102'\n"
        "tail -n 3 capture.log | canalyze explain -",
    ),
    (
        "explain.no_frame",
        "这不是一帧，也不是已知的代码：{line}；可以写成 60A#4008100000000000 或 "
        "can1  60A   [8]  40 08 10 00 00 00 00 00",
        "neither a frame nor a known code: {line}; write it as 60A#4008100000000000 or "
        "can1  60A   [8]  40 08 10 00 00 00 00 00",
    ),
    (
        "explain.no_frame_at",
        "{name}:{number}: 这不是一帧，也不是已知的代码：{line}；可以写成 60A#4008100000000000 或 "
        "can1  60A   [8]  40 08 10 00 00 00 00 00",
        "{name}:{number}: neither a frame nor a known code: {line}; write it as 60A#4008100000000000 or "
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
        "把每个传输的数据写入此目录，一个传输一个文件；没有成功的以其结果作后缀（.aborted .incomplete .failed）。"
        "记录里缺失的字节以00填充，使其后的数据保持偏移；缺失之处列在旁边的 .holes.json 里。",
        "Write the data of each transfer to this directory, one file each; those that did not succeed end in their "
        "outcome (.aborted .incomplete .failed). Bytes that the capture lacks are filled with 00, so that those behind "
        "keep their offset; a file .holes.json beside it lists them.",
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
        "sdo.holed",
        "其中{files}个缺少数据，见旁边的 .holes.json",
        "of which with missing bytes, listed in .holes.json beside each: {files}",
    ),
    (
        "sdo.kept",
        "{name}：文件已存在，未覆盖；要覆盖请加 --force",
        "{name}: exists and is kept; --force overwrites it",
    ),
    # signals
    ("signals.short", "列出PDO里的信号及其值", "List the signals in PDOs with their values"),
    ("signals.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "signals.help",
        "解析PDO里的信号，每个值一行：时间、帧、总线、节点、PDO、信号、值、原始值、单位、来源、对象。"
        "映射来自记录里的SDO配置，其次是 --eds 或 canalyze.toml 给出的设备描述；来源说明是哪一个。"
        "文件的给法与decode相同。",
        "Decode the signals in PDOs, one value a line: t, frame, bus, node, pdo, signal, value, raw, unit, provenance, "
        "object. Mappings come from the configuration by SDO that the capture shows, else from the device descriptions "
        "of --eds or canalyze.toml; the provenance says which. Files are given as for decode.",
    ),
    (
        "signals.select",
        "只要这些信号：用逗号隔开的通配符，与信号名称、“节点.信号”、“节点.PDO.信号”比较，信号也可写成对象；"
        "不分大小写。如 '5.*'、'*velocity*,7.TPDO1.*'、'6041:00'。",
        "Only these signals: globs with commas between, compared with the name of the signal, node.signal and "
        "node.PDO.signal, where an object may stand for the signal; case does not count. E.g. '5.*', "
        "'*velocity*,7.TPDO1.*', '6041:00'.",
    ),
    (
        "signals.format",
        "csv 是带标题行的表格；jsonl 每行一个值。",
        "csv is a table with a line of headings; jsonl is one value a line.",
    ),
    (
        "signals.examples",
        "canalyze signals --eds 5=drive.eds capture.log\n"
        "canalyze signals --eds 5=drive.eds --select '5.*,*velocity*' capture.log -o velocity.csv\n"
        "canalyze signals --eds 1-4,7=io.eds --filter 'node=1 t=1.0..2.5' capture.log\n"
        "canalyze signals --format jsonl drive.log | jq -r '[.t, .signal, .value] | @tsv'\n"
        "candump -ta can0 | canalyze signals --eds 5=drive.eds -",
        "canalyze signals --eds 5=drive.eds capture.log\n"
        "canalyze signals --eds 5=drive.eds --select '5.*,*velocity*' capture.log -o velocity.csv\n"
        "canalyze signals --eds 1-4,7=io.eds --filter 'node=1 t=1.0..2.5' capture.log\n"
        "canalyze signals --format jsonl drive.log | jq -r '[.t, .signal, .value] | @tsv'\n"
        "candump -ta can0 | canalyze signals --eds 5=drive.eds -",
    ),
    (
        "signals.none",
        "{frames}帧中没有解析任何信号：没有已知映射的PDO；"
        "用 --eds 5=drive.eds 给出设备描述，或把配置过程（SDO）也录下来",
        "no signal decoded in {frames} frames: no PDO whose mapping is known; give a device description, as "
        "--eds 5=drive.eds, or capture the configuration by SDO too",
    ),
    (
        "signals.none_kept",
        "{frames}帧中没有符合 {options} 的信号；去掉后仍没有，说明PDO的映射未知：请用 --eds 5=drive.eds 给出设备描述",
        "no signal in {frames} frames fits {options}; if there is none without it either, no mapping of a PDO is "
        "known: give a device description, as --eds 5=drive.eds",
    ),
    # summary
    ("summary.short", "统计节点、总线负载、SYNC和发现", "Figures of nodes, bus load, SYNC and findings"),
    ("summary.usage", "[选项] [文件]...", "[OPTIONS] [FILE]..."),
    (
        "summary.help",
        "统计一个记录：每个节点的名称、状态、启动报文、心跳间隔、SDO应答时间、中止、紧急报文和PDO速率；"
        "每条总线的帧数、负载、最长突发和错误帧；SYNC周期和同步PDO的延迟；按规则列出发现；以及记录本身的质量。"
        "文件的给法与decode相同；实时输入在Ctrl-C后给出统计。"
        "负载按每帧在总线上的实际位数计算：填充位由ID、数据和CRC逐帧算出，含3位帧间隔；错误帧不计位数，"
        "带BRS的CAN FD帧只计标称波特率的部分。"
        "p99取自对数分桶，最多偏大3.2%。--filter 只统计符合条件的帧；发现随其所在的帧计数。",
        "Figures of a capture: of each node its name, states, boot-ups, heartbeat interval, SDO response time, aborts, "
        "EMCYs and PDO rates; of each bus its frames, load, longest burst and error frames; the period of SYNC and the "
        "delay of synchronous PDOs; findings by rule; and the quality of the capture itself. Files are given as for "
        "decode; of a live input the figures come after Ctrl-C. Load counts the bits of every frame on the wire: stuff "
        "bits are computed from its identifier, data and CRC, with 3 bits between frames; error frames count no bits, "
        "and of CAN FD frames with bit rate switch only the part at the nominal rate counts. p99 comes from "
        "logarithmic buckets and is at most 3.2 % too high. With --filter only what fits is counted; a finding counts "
        "with its frame.",
    ),
    (
        "summary.format",
        "text 是表格；jsonl 每行一个JSON对象：记录、每条总线、SYNC、每个节点、每个PDO、每条规则。",
        "text is tables; jsonl is one JSON object a line: the capture, every bus, SYNC, node, PDO and rule.",
    ),
    (
        "summary.examples",
        "canalyze summary capture.log\n"
        "canalyze summary --bitrate 500k capture.log\n"
        "canalyze summary --eds 5=drive.eds part1.log part2.log\n"
        "canalyze summary --filter 't=10..20' --bitrate 1M capture.log\n"
        "canalyze summary --format jsonl capture.log | jq 'select(.kind == \"summary_node\")'\n"
        "candump -ta can0 | canalyze summary -",
        "canalyze summary capture.log\n"
        "canalyze summary --bitrate 500k capture.log\n"
        "canalyze summary --eds 5=drive.eds part1.log part2.log\n"
        "canalyze summary --filter 't=10..20' --bitrate 1M capture.log\n"
        "canalyze summary --format jsonl capture.log | jq 'select(.kind == \"summary_node\")'\n"
        "candump -ta can0 | canalyze summary -",
    ),
    # eds
    ("eds.short", "说明设备描述文件（EDS、DCF、XDD）", "Show a device description (EDS, DCF, XDD)"),
    ("eds.usage", "[选项] 文件...", "[OPTIONS] FILE..."),
    (
        "eds.help",
        "说明设备描述文件：设备、通信对象及其值、各区域的对象数、PDO表（COB-ID、传输类型、时间、每个信号所占的位），"
        "以及文件本身的缺陷：修复了什么，什么没有采用。EDS、DCF和XDD都可以，编码和写法不规范的也能读。",
        "Show a device description: the device, its communication objects with their values, counts of all others, the "
        "PDO table (COB-ID, transmission type, times, bits of every signal), and the file's own defects: what was "
        "repaired and what could not be used. EDS, DCF and XDD are read, also in odd encodings and spellings.",
    ),
    (
        "eds.node",
        "用这个节点ID算出COB-ID，十进制或0x十六进制；不给则用DCF里的节点ID，都没有则写成$NODEID加偏移。",
        "Compute COB-IDs for this node-ID, decimal or 0x hexadecimal; else that of a DCF, else they stay $NODEID plus "
        "an offset.",
    ),
    ("eds.all", "列出全部对象，不只是通信对象。", "List every object, not only communication objects."),
    (
        "eds.format",
        "text 给人看；jsonl 每行一个JSON对象：文件、每个对象、每个PDO、每个缺陷。",
        "text for people; jsonl is one JSON object a line: the file, every object, every PDO, every defect.",
    ),
    (
        "eds.examples",
        "canalyze eds eds/drive.eds\n"
        "canalyze eds --node 5 eds/drive.eds\n"
        "canalyze eds --all eds/io.eds | less\n"
        "canalyze eds --format jsonl *.eds | jq -c 'select(.kind == \"defect\")'",
        "canalyze eds eds/drive.eds\n"
        "canalyze eds --node 5 eds/drive.eds\n"
        "canalyze eds --all eds/io.eds | less\n"
        "canalyze eds --format jsonl *.eds | jq -c 'select(.kind == \"defect\")'",
    ),
    (
        "eds.nothing",
        "{name}：里面没有一个CANopen对象；EDS和DCF里的对象写作 [1000] 这样的节",
        "{name}: there is no CANopen object in it; EDS and DCF have them as sections such as [1000]",
    ),
    ("eds.large", "{name}：大于 {most} MiB，不是设备描述文件", "{name}: larger than {most} MiB, no device description"),
    ("eds.xml", "{name}:{line}: 不是完整的XML：{problem}", "{name}:{line}: not well-formed XML: {problem}"),
    (
        "eds.doctype",
        "{name}：含有文档类型声明（DOCTYPE），不读；XDD不需要它",
        "{name}: has a document type declaration (DOCTYPE) and is not read; an XDD needs none",
    ),
    # rules
    ("rules.short", "列出或解释检查规则", "List the rules, or explain one"),
    ("rules.usage", "[选项] [代码]...", "[OPTIONS] [CODE]..."),
    (
        "rules.help",
        "列出检查规则；给出代码则解释它，给出代码的开头则列出那些规则（大小写不限）。",
        "List the rules; with a code explain it, with the beginning of codes list those (in either case).",
    ),
    ("rules.format", "text 给人看；jsonl 每行一条规则。", "text for people; jsonl is one rule a line."),
    (
        "rules.examples",
        "canalyze rules\ncanalyze rules SDO001\ncanalyze rules EXP\ncanalyze rules --format jsonl",
        "canalyze rules\ncanalyze rules SDO001\ncanalyze rules EXP\ncanalyze rules --format jsonl",
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
)
