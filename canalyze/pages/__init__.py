"""The pages for users, as data: `LANG/TOPIC.md`, for the web and for `canalyze help TOPIC`.

This module lists the topics in their order, and the commands of each. The page of columns has every table that the core
builds, its columns with type and unit, and their meaning; it is made from the core's schema, where each record is
declared with its documentation, and its file is a copy for the web. Must not: hold a sentence of its own beyond those
around these tables, or lay anything out.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from canalyze import _core

FOLDER: Final = Path(__file__).parent
TOPICS: Final[Mapping[str, tuple[str, ...]]] = {
    "decode": ("decode", "explain"),
    "sdo": ("sdo",),
    "pdo": ("signals", "eds"),
    "od": ("od",),
    "summary": ("summary",),
    "diagnosis": ("diagnose", "page", "examples"),
    "standstill": (),
    "recording": (),
    "live": ("sniff",),
    "monitor": ("monitor",),
    "timeline": ("view",),
    "ci": ("check", "diff"),
    "fleet": ("fleet",),
    "expectations": ("expect",),
    "formats": ("convert", "info"),
    "export": ("export",),
    "configuration": (),
    "agents": ("mcp",),
    "library": (),
    "pytest": (),
    "columns": (),
    "rules": ("rules",),
    "problems": (),
    "glossary": (),
}
"""The topics, and the commands that lead to each."""
README: Final = "README"
"""The page that leads to the topics; it is no topic, but is shown as well."""


def page(topic: str, lang: str) -> str:
    """Returns the markdown of a topic, one of TOPICS, or of README; the English README is that of the distribution."""
    if topic == README and lang == "en":
        if (beside := FOLDER.parents[1] / f"{README}.md").exists():
            return beside.read_text(encoding="utf-8")
        from importlib.metadata import metadata

        return metadata("canalyze")["Description"]
    if topic == "columns":
        return columns_page(lang)
    return (FOLDER / lang / f"{topic}.md").read_text(encoding="utf-8")


def title(topic: str, lang: str) -> str:
    """Returns the title of a page, its first line."""
    return page(topic, lang).partition("\n")[0].removeprefix("# ")


def topic_of(name: str) -> str | None:
    """Returns the topic of a name or a command; None for other names."""
    name = name.lower().removesuffix(".md")
    if name == README.lower():
        return README
    if name in TOPICS:
        return name
    return next((topic for topic, commands in TOPICS.items() if name in commands), None)


_UNITS: Final = {"_ns": "ns", "_percent": "%", "_per_s": "1/s"}
"""Units by the suffix of a column's name."""

_HEAD: Final = (
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
_PDO: Final = (
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


def tables() -> list[dict[str, Any]]:
    """Returns the records of the schema that are tables."""
    return [record for record in json.loads(_core.schema()) if record["table"]]


def columns_page(lang: str) -> str:
    """Returns the page as markdown."""
    pick = 0 if lang == "zh" else 1
    lines = [_HEAD[pick]]
    for record in tables():
        table = record["table"]
        lines.append(_PDO[pick] if table == "pdo" else f"\n## {table}\n\n{record[lang]}\n")
        lines.append(
            ("\n| 列 | 类型 | 单位 | 含义 |\n", "\n| column | type | unit | meaning |\n")[pick] + "|---|---|---|---|\n"
        )
        for column in record["columns"]:
            if name := column["column"]:
                unit = next((unit for end, unit in _UNITS.items() if name.endswith(end)), "")
                kind = column["arrow"] + (("，可空", ", optional")[pick] if column["nullable"] else "")
                lines.append(f"| `{name}` | {kind} | {unit} | {column[lang]} |\n")
    return "".join(lines)
