"""The page of columns: every table that the core builds, its columns with type and unit, and what each holds.

Types and which columns may be empty come from the core's tables themselves; here stand only the meanings. Must not:
leave a column without one (`columns` fails then).
"""

from __future__ import annotations

from functools import cache

import pyarrow
from captures import EDS, SAMPLES

import canalyze

TABLES = {
    "frames": ("一行是一帧", "One row per frame."),
    "transfers": ("一行是一次SDO传输", "One row per SDO transfer."),
    "states": ("一行是一次NMT状态变化或一条NMT命令", "One row per change of an NMT state, and per NMT command."),
    "emcy": ("一行是一个紧急报文", "One row per EMCY."),
    "findings": ("一行是一条检查结果", "One row per finding."),
    "incidents": (
        "一行是一个问题，读完整个记录后得出；原因排在它引起的问题之前",
        "One row per problem, known at the end of the capture; a cause comes before its consequences.",
    ),
    "sync_cycles": ("一行是一个同步周期", "One row per SYNC cycle."),
    "signals": ("一行是PDO里的一个信号值", "One row per value of a signal in a PDO."),
    "objects": (
        "一行是一个对象的值，无论由哪种服务传送：PDO、SDO、EMCY（错误码和1001h）、NMT状态",
        "One row per value of an object, whatever carried it: PDO, SDO, EMCY (its code and 1001h), NMT state.",
    ),
    "od": (
        "一行是一个节点的一个对象，读完整个记录后得出：`canalyze od` 列出的内容",
        "One row per object of a node, known at the end of the capture: what `canalyze od` lists.",
    ),
    "listing": ("一行是注释列表的一行", "One row per line of the annotated listing."),
    "lanes": ("一行是时间轴上一条状态条的一次变化", "One row per change in a lane of the timeline."),
    "log": ("一行是一条检查结果或一个紧急报文", "One row per finding or EMCY, in words."),
    "load": ("一行是一条总线的100 ms", "One row per bus and 100 ms."),
}
"""The tables, and what a row of each is."""

UNITS = {"_ns": "ns", "_percent": "%", "_per_s": "1/s"}
"""Units by the end of a name."""

MEANINGS = {
    "frame": ("帧号，从1起", "number of the frame, from 1"),
    "line": ("文件的行号；二进制格式为空", "line of the file; empty in binary formats"),
    "file": ("文件名", "name of the file"),
    "t_ns": ("时间戳", "timestamp"),
    "bus": ("总线名；记录中没有时为空", "bus; empty where the capture names none"),
    "node": ("节点ID；与节点无关时为空", "node-ID; empty where it is about no node"),
    "id": ("CAN-ID；错误帧为其类别", "CAN-ID; of an error frame its class"),
    "extended": ("29位ID", "29-bit identifier"),
    "kind": ("data、remote、error等", "data, remote, error, ..."),
    "brs": ("CAN FD的BRS位", "BRS bit of CAN FD"),
    "esi": ("CAN FD的ESI位", "ESI bit of CAN FD"),
    "dir": ("方向 rx、tx", "direction, rx or tx"),
    "len": ("数据长度，字节", "length of the data, in bytes"),
    "data": ("数据字节", "data bytes"),
    "service": ("服务：nmt、sync、pdo、sdo等", "service: nmt, sync, pdo, sdo, ..."),
    "transfer": ("传输编号，从1起", "number of the transfer, from 1"),
    "direction": ("download 写，upload 读", "download writes, upload reads"),
    "mode": ("expedited、segmented、block", "expedited, segmented or block"),
    "index": ("对象索引", "index of the object"),
    "sub": ("子索引", "sub-index"),
    "object": ("对象，如 1008:00", "object, as 1008:00"),
    "name": ("名称", "name"),
    "type": ("数据类型", "data type"),
    "size_indicated": ("声明的长度，字节", "indicated size, in bytes"),
    "size": ("实际传输的长度，字节", "transferred size, in bytes"),
    "string": ("值：字符串类型", "value of a string type"),
    "boolean": ("值：布尔类型", "value of a boolean type"),
    "integer": ("值：有符号整数", "value as a signed integer"),
    "raw": ("未换算的无符号值", "value as an unsigned number, not scaled"),
    "value": ("换算后的值", "value, scaled"),
    "text": ("文字说明", "in words"),
    "status": (
        "结果：传输为 ok aborted incomplete failed；问题为 stands over harmless unknown",
        "outcome: of a transfer ok, aborted, incomplete, failed; of a problem stands, over, harmless, unknown",
    ),
    "abort_code": ("中止码", "abort code"),
    "abort_by": ("中止方 client、server", "who aborted: client or server"),
    "abort_text": ("中止原因", "meaning of the abort code"),
    "first_frame": ("第一帧", "first frame"),
    "last_frame": ("最后一帧", "last frame"),
    "first_line": ("第一帧的行号", "line of the first frame"),
    "last_line": ("最后一帧的行号", "line of the last frame"),
    "duration_ns": ("从请求到结束", "from the request to the end"),
    "reordered": ("记录中帧的次序颠倒过，已纠正", "its frames were recorded out of order; this was corrected"),
    "retransmissions": ("块传输中重发的段数", "segments sent again in a block transfer"),
    "crc_negotiated": ("块传输约定了CRC", "a CRC was agreed on for the block transfer"),
    "findings": ("相关规则的代码", "codes of its findings"),
    "state": (
        "状态；states里为NMT状态码，lanes里为显示的文字",
        "state: in states its NMT code, in lanes the text shown",
    ),
    "source": ("状态由什么报文得出；log里为来源", "the kind of message it comes from"),
    "command": ("NMT命令字", "NMT command specifier"),
    "code": ("代码：规则代码或EMCY错误码", "code of the rule, or EMCY error code"),
    "register": ("错误寄存器（1001h）", "error register (1001h)"),
    "manufacturer": ("制造商数据，5字节", "manufacturer bytes (5)"),
    "active": ("此后仍存在的错误码", "error codes that are active after it"),
    "cleared": ("由它清除的错误码", "error codes that it clears"),
    "severity": ("error、warning、info", "error, warning or info"),
    "cause_frame": ("引起它的帧", "frame that caused it"),
    "cause_line": ("引起它的帧的行号", "line of that frame"),
    "about_frame": ("它所说的帧", "frame that it is about"),
    "because_of": ("它是哪一条检查结果的后果", "the finding of which it is a consequence"),
    "message": ("文字说明", "in words"),
    "facts": ("数值，JSON", "its figures, as JSON"),
    "cycle": ("同步周期的编号，从1起", "number of the SYNC cycle, from 1"),
    "period_ns": ("距上一个SYNC", "since the previous SYNC"),
    "counter": ("SYNC计数器", "SYNC counter"),
    "pdos": ("该周期内同步PDO的个数", "synchronous PDOs in this cycle"),
    "delay_min_ns": ("同步PDO距SYNC的最短延迟", "shortest delay of a synchronous PDO after SYNC"),
    "delay_max_ns": ("同步PDO距SYNC的最长延迟", "longest delay of a synchronous PDO after SYNC"),
    "window_ns": ("同步窗口（1007h）", "synchronous window (1007h)"),
    "pdo": ("PDO，如 TPDO1", "PDO, as TPDO1"),
    "signal": ("信号名", "name of the signal"),
    "unit": ("单位", "unit"),
    "provenance": (
        "映射的来源：observed 由SDO写入得出，其余来自设备描述或选项",
        "where the mapping comes from: observed (written by SDO), else a description or an option",
    ),
    "lane": ("状态条的名称", "name of the lane"),
    "class": ("颜色类别", "class of its colour"),
    "level": ("级别", "severity"),
    "frames": ("帧数；incidents里为依据的帧号", "number of frames; in incidents the numbers of its evidence"),
    "bits": ("总线上的位数", "bits on the wire"),
    "frames_per_s": ("帧率", "frame rate"),
    "load_percent": ("总线负载；需要波特率", "bus load; needs a bit rate"),
    "incident": ("问题类型，如 node-silent", "kind, as node-silent"),
    "impact": ("影响等级 A至E", "impact, A (worst) and on"),
    "grade": ("把握程度", "how sure it is"),
    "depth": ("因果层次，0为根", "depth in the tree of causes, 0 is a root"),
    "nodes": ("涉及的节点", "nodes concerned"),
    "axis": ("轴号（CiA 402）", "axis (CiA 402)"),
    "subject": ("对象：哪个节点、总线或PDO", "what it is about: a node, a bus, a PDO"),
    "begin_frame": ("第一个迹象所在的帧", "frame of its first sign"),
    "noticed_frame": ("能够判定时的帧", "frame from which it could be known"),
    "noticed_t_ns": ("能够判定的时刻", "time from which it could be known"),
    "end_frame": ("结束时的帧；仍存在时为空", "frame of its end; empty while it stands"),
    "end_t_ns": ("结束时刻", "time of its end"),
    "end_cycle": ("结束时的同步周期", "SYNC cycle of its end"),
    "count": ("次数", "how many times"),
    "root": ("不是其他问题的后果", "no consequence of another problem"),
    "cause": ("原因的编号（id列）", "the problem that caused it (column id)"),
    "cause_link": ("因果关系的类型", "kind of the causal link"),
    "cause_grade": ("因果关系的把握程度", "how sure the link is"),
    "delay_ns": ("距原因开始", "since the cause began; of a PDO since its SYNC"),
    "checks": ("应先检查什么", "what to check first"),
    "running_cycle": ("全记录连续的周期编号", "number of the cycle, counted through the whole capture"),
}
"""What a column holds; TABLE.COLUMN overrules COLUMN."""

_OWN = {
    "incidents.id": ("问题编号", "number of the problem"),
    "findings.name": ("规则名", "name of the rule"),
    "findings.code": ("规则代码", "code of the rule"),
    "emcy.code": ("EMCY错误码", "EMCY error code"),
    "load.frames": ("帧数", "number of frames"),
    "incidents.frames": ("依据的帧号", "frames that show it"),
    "transfers.status": ("ok、aborted、incomplete、failed", "ok, aborted, incomplete or failed"),
    "incidents.status": (
        "stands（存在）、over（已恢复）、harmless（无害）、unknown（未知）",
        "stands, over, harmless or unknown",
    ),
    "states.state": ("NMT状态码", "code of the NMT state"),
    "lanes.state": ("显示的文字；空表示不再有", "text shown; empty where it ends"),
    "incidents.delay_ns": ("距原因开始", "since the cause began"),
    "pdo.delay_ns": ("距SYNC", "since SYNC"),
    "od.index": ("对象索引", "index of the object"),
    "od.sub": ("子索引", "sub-index"),
    "od.name": ("名称；没有时为空", "name; empty where it has none"),
    "od.type": ("数据类型", "data type"),
    "od.type_from": (
        "类型的依据：eds、standard（CiA 301）、profile（设备规范）、inferred（由值推断）",
        "where the type is from: eds, standard (CiA 301), profile, or inferred from the values",
    ),
    "od.bits": ("值的位数", "size of the value in bits"),
    "od.access": (
        "访问权限：rw、ro、wo；只知其一时为 r 或 w",
        "access: rw, ro, wo; r or w where the other one is not known",
    ),
    "od.readable": ("能否读；报文中看不出时为空", "whether it can be read; empty where the traffic does not tell"),
    "od.writable": ("能否写；报文中看不出时为空", "whether it can be written; empty where the traffic does not tell"),
    "od.exists": (
        "设备中是否有此对象；看不出时为空",
        "whether the device has the object; empty where the traffic does not tell",
    ),
    "od.value": ("最后一个值，已换算", "last value, scaled"),
    "od.integer": ("整数值（不带系数时）", "the same as an integer, where it has no factor"),
    "od.text": ("最后一个值的文字", "last value in words"),
    "od.data": ("最后一个值的字节，最多4096个", "bytes of the last value, the first 4096"),
    "od.source": (
        "最后一个值的来源：read、written、tpdo、rpdo、emcy",
        "what carried the last value: read, written, tpdo, rpdo or emcy",
    ),
    "od.t_ns": ("最后一个值的时间戳", "timestamp of the last value"),
    "od.frame": ("最后一个值的帧号", "frame of the last value"),
    "od.values": ("值的个数", "number of values"),
    "od.read": ("读出的次数", "number of uploads that are ok"),
    "od.written": ("写入的次数", "number of downloads that are ok"),
    "od.tpdo": ("TPDO中的次数", "number of TPDOs that carried it"),
    "od.rpdo": ("RPDO中的次数", "number of RPDOs that carried it"),
    "od.emcy": ("EMCY中的次数", "number of EMCYs that carried it"),
    "od.refused": ("被设备中止的请求数", "number of requests that the device aborted"),
    "od.unconfirmed": (
        "没有结果的请求数：无响应、被客户端放弃、不完整、违反协议",
        "number of requests without a sound end: unanswered, given up, incomplete, or failed",
    ),
    "od.abort_codes": ("出现过的中止码", "abort codes seen"),
    "od.in_force": (
        "当前有效的值：由全部已知信息得出，复位后可能不同于最后一个值；只用于解码所依据的通信对象",
        "value in force by all that is known: after a reset it may differ from the last one; only of communication "
        "objects that decoding depends on",
    ),
    "od.in_force_from": (
        "其依据：observed、option、dcf、eds；unknown 表示不再知道",
        "where that is from: observed, option, dcf or eds; unknown where it is no longer known",
    ),
    "od.first_frame": ("首次出现的帧号", "first frame that shows it"),
    "od.last_frame": ("最后出现的帧号", "last frame that shows it"),
    "objects.source": ("由哪种服务传送：pdo、sdo、emcy、nmt", "what carried it: pdo, sdo, emcy or nmt"),
    "objects.index": ("对象索引；NMT状态和EMCY错误码没有", "index of the object; NMT states and EMCY codes have none"),
    "objects.sub": ("子索引", "sub-index"),
    "objects.name": ("名称（英文）", "name, in English"),
    "objects.value": ("换算后的值，单位见unit列", "value in the unit of column unit"),
    "objects.integer": ("整数值（不带系数时）", "the same as an integer, where it has no factor"),
    "objects.text": ("字符串的值，或数值的含义（英文）", "value of a string, or what a number means, in English"),
}


@cache
def _schemas() -> dict[str, list[tuple[str, str, bool]]]:
    """Every table's columns: name, type, whether it may be empty."""
    with canalyze.open(SAMPLES / "network/sync-and-pdos.log", eds={5: EDS / "drive.eds"}) as capture:
        found = {name: pyarrow.table(capture.tables(name)[name]).schema for name in TABLES}
        pdos = capture.tables("pdo")
        found["pdo"] = pyarrow.table(next(iter(pdos.values()))).schema
    schemas = {
        name: [(one.name, _type(str(one.type)), one.nullable) for one in schema] for name, schema in found.items()
    }
    own = [column[0] for column in schemas["pdo"]].index("running_cycle") + 1
    schemas["pdo"] = schemas["pdo"][:own]
    return schemas


def _type(name: str) -> str:
    if name.startswith("dictionary"):
        return "string"
    return name.replace("list<item: ", "list of ").removesuffix(">").replace("double", "float64")


HEAD = (
    '# 各表的列\n\n`canalyze.open(...).tables("frames", "transfers")` 按名称给出这些表'
    "（Arrow格式，可交给pyarrow、polars、pandas）；"
    "用法见[library](library.md)。列名和类型不随语言变化，也不会改名。时间列（`..._ns`）是以ns为单位的整数：有绝"
    "对时间戳时从1970年（UTC）算起，"
    "否则从记录的起点算起。“可空”的列没有值时为空。\n\n"
    "`canalyze signals` 输出的CSV有 `t`（秒）、`frame`、`bus`、`node`、`pdo`、`signal`、`value`、`raw`、`unit`、"
    "`provenance`、`object`，"
    "含义同表 `signals`。各命令的 `--format jsonl` 使用同样的名称；其中 `t` 的单位是秒，`*_us` 是微秒。\n",
    '# Columns of every table\n\n`canalyze.open(...).tables("frames", "transfers")` gives these tables by name, '
    "in Arrow's layout "
    "(for pyarrow, polars, pandas); see [library](library.md). Names and types do not depend on the language and "
    "are never "
    "renamed. Times (`..._ns`) are integers in ns: since 1970 (UTC) where the capture has absolute timestamps, "
    "else since its "
    'own start. An "optional" column is null where there is no value.\n\n'
    "The CSV of `canalyze signals` has `t` (seconds), `frame`, `bus`, `node`, `pdo`, `signal`, `value`, `raw`, `unit`, "
    "`provenance` and `object`, as in table `signals`. `--format jsonl` of the commands uses the same names; `t` "
    "is in seconds "
    "there, `*_us` in microseconds.\n",
)
PDO = (
    "\n## pdo\n\n每个PDO的每种映射各有一张宽表，名称如 `pdo/can0/5.TPDO1/1`：一行是一个PDO，除下列各列外，每个信"
    "号一列（列名是信号名，"
    "单位等在该列的元数据中）。\n\n"
    "表 `wide`（如 `wide/can0/5.TPDO1/1`）的列相同，但信号是换算成单位的值；状态字、控制字和模式是英文文字，"
    "数值在后面的 `名称__raw` 列；列名是英文。`canalyze export` 用的是它。\n",
    "\n## pdo\n\nEach mapping of each PDO is a wide table of its own, named `pdo/can0/5.TPDO1/1`: one row per "
    "PDO, with one column "
    "per signal behind those below (its unit and object are in the column's metadata).\n\n"
    "Tables of `wide` (as `wide/can0/5.TPDO1/1`) have the same columns, but values are in their units; status words, "
    "control words and modes are words, with the number in `NAME__raw` behind them; names are English. "
    "`canalyze export` uses these.\n",
)


def columns(lang: str) -> str:
    """The page."""
    pick = 0 if lang == "zh" else 1
    lines = [HEAD[pick]]
    for table, schema in _schemas().items():
        lines.append(PDO[pick] if table == "pdo" else f"\n## {table}\n\n{TABLES[table][pick]}\n")
        lines.append(
            ("\n| 列 | 类型 | 单位 | 含义 |\n", "\n| column | type | unit | meaning |\n")[pick] + "|---|---|---|---|\n"
        )
        for name, kind, optional in schema:
            meaning = (_OWN.get(f"{table}.{name}") or MEANINGS[name])[pick]
            unit = next((unit for end, unit in UNITS.items() if name.endswith(end)), "")
            kind += ("，可空", ", optional")[pick] if optional else ""
            lines.append(f"| `{name}` | {kind} | {unit} | {meaning} |\n")
    return "".join(lines)
