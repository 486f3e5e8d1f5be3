"""Pages that are made of what the core has: its rules, its kinds of problems, its terms, its tables of columns.

`python tests/regenerate.py pages` writes them; `test_pages.py` holds that they are current. Must not: say anything of
its own beyond headings, and what is around the tables of columns.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from captures import SAMPLES

from canalyze import _core
from canalyze.pages import FOLDER
from canalyze.words import LANGUAGES, Words

TERMS = SAMPLES.parent / "canalyze/core/words/glossary.tsv"
FAMILIES = {
    "BUS": ("总线和控制器", "Bus and controller"),
    "CAP": ("报文记录本身", "The capture itself"),
    "EDS": ("与设备描述的差异", "Differences from the device description"),
    "MPD": ("MPDO", "MPDO"),
    "NMT": ("NMT", "NMT"),
    "HBT": ("心跳", "Heartbeat"),
    "GRD": ("节点保护", "Node guarding"),
    "EMC": ("紧急报文(EMCY)", "EMCY"),
    "SDO": ("SDO", "SDO"),
    "PDO": ("PDO", "PDO"),
    "SYN": ("SYNC", "SYNC"),
    "TIM": ("时间报文(TIME)", "TIME"),
    "LSS": ("LSS", "LSS"),
    "DRV": ("驱动器(CiA 402)", "Drives (CiA 402)"),
    "SRD": ("SRDO(CiA 304)", "SRDO (CiA 304)"),
    "EXP": ("期望", "Expectations"),
}
"""Titles of families of rules; one that has none is shown by its letters."""


def _pick(lang: str, pair: tuple[str, str]) -> str:
    return pair[LANGUAGES.index(lang)]


def cell(text: str) -> str:
    """Text for the cell of a table."""
    return re.sub(r"\s*\n\s*", " ", text.strip()).replace("|", "\\|").replace("<", "&lt;")


def rules(lang: str) -> str:
    """The rules, by family."""
    words = Words(lang)
    head = (
        "# 规则\n\n每条检查结果都由一条规则得出，代码不变，可用于 `check --ignore`、过滤条件 `code=` 和配置文件。"
        "一条规则的完整说明：`canalyze rules HBT002`。在CI里怎样取舍见[ci](ci.md)。\n",
        "# Rules\n\nEvery finding comes from one rule. Its code does not change; use it in `check --ignore` and in "
        "`canalyze.toml`. `canalyze rules HBT002` explains one. How to choose among them in CI: [ci](ci.md).\n",
    )
    lines = [_pick(lang, head)]
    family = ""
    for rule in _core.rules(lang):
        if rule.code[:3] != family:
            family = rule.code[:3]
            lines.append(f"\n## {family}: {_pick(lang, FAMILIES.get(family, (family, family)))}\n")
        lines.append(f"\n### {rule.code} {_plain(rule.message)}\n")
        severity = words.of("severity", rule.severity)
        clause = "" if rule.clause in ("", "-") else f" · {rule.clause.replace(' to ', ' ~ ')}"
        lines.append(f"\n`{rule.name}` · {severity}{clause}\n")
        meaning, cause = words("rules.meaning"), words("rules.cause")
        colon = "：" if lang == "zh" else ": "
        lines.append(f"\n- {meaning}{colon}{_plain(rule.meaning)}\n")
        lines.append(f"- {cause}{colon}{_plain(rule.cause)}\n")
    return "".join(lines)


def _plain(text: str) -> str:
    """Text that markdown leaves alone."""
    return re.sub(r"([*_<])", r"\\\1", " ".join(text.split()))


def problems(lang: str) -> str:
    """The kinds of problems, as `explain` has them."""
    head = (
        "# 问题类型\n\n`canalyze diagnose` 把相关的检查结果归并为问题。以下是全部类型及其含义；"
        "`canalyze explain node-silent` 显示其中一种。在期望文件的 `[[problem]]` 里用 `kind` 指定。诊断见"
        "[diagnosis](diagnosis.md)。\n",
        "# Kinds of problems\n\n`canalyze diagnose` groups findings into problems. These are all kinds; "
        "`canalyze explain node-silent` shows one. `kind` of `[[problem]]` in a file of expectations takes "
        "these names. "
        "See [diagnosis](diagnosis.md).\n",
    )
    lines = [_pick(lang, head)]
    for kind in _core.PROBLEMS:
        said = (_core.explain(kind, lang) or "").splitlines()
        begin = next(at for at, line in enumerate(said) if line.startswith(f"{kind}: ") and "BUS" not in line)
        end = next((at for at, line in enumerate(said) if at > begin and not line.startswith(" ")), len(said))
        lines.append(f"\n## {kind}: {_plain(said[begin].removeprefix(f'{kind}: '))}\n\n")
        lines += [f"- {_plain(line)}\n" for line in said[begin + 1 : end]]
    return "".join(lines)


def glossary(lang: str) -> str:
    """The terms in both languages, and what each is."""
    head = (
        "# 术语表\n\n中英文对照；`canalyze explain 'sync window'` 或 `canalyze explain 同步窗口` 显示一个术语的完"
        "整说明。\n\n"
        "| 中文 | English | 含义 | 出处 |\n|---|---|---|---|\n",
        "# Glossary\n\nTerms in English and Chinese; `canalyze explain 'sync window'` shows one in full.\n\n"
        "| English | Chinese | meaning | source |\n|---|---|---|---|\n",
    )
    rows = []
    found = re.findall(r"^([^#,\t\n]+), ([^,\t]+).*\t(.*)$", TERMS.read_text(encoding="utf-8"), re.MULTILINE)
    for english, chinese, clause in found:
        said = (_core.explain(english, lang) or "").splitlines()
        meaning = said[0].partition("): ")[2]
        pair = (chinese, english) if lang == "zh" else (english, chinese)
        rows.append((pair[0].casefold(), f"| {pair[0]} | {pair[1]} | {cell(meaning)} | {clause} |\n"))
    return _pick(lang, head) + "".join(row for _, row in sorted(rows))


UNITS = {"_ns": "ns", "_percent": "%", "_per_s": "1/s"}
"""Units by the suffix of a column's name."""

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
WIDE = (
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
    """The records of the schema that are tables."""
    return [record for record in json.loads(_core.schema()) if record["table"]]


def columns(lang: str) -> str:
    """The tables that the core builds, their columns with type and unit, and their meaning, from its schema."""
    pick = 0 if lang == "zh" else 1
    lines = [HEAD[pick]]
    for record in tables():
        table = record["table"]
        lines.append(WIDE[pick] if table == "pdo" else f"\n## {table}\n\n{record[lang]}\n")
        lines.append(
            ("\n| 列 | 类型 | 单位 | 含义 |\n", "\n| column | type | unit | meaning |\n")[pick] + "|---|---|---|---|\n"
        )
        for column in record["columns"]:
            if name := column["column"]:
                unit = next((unit for end, unit in UNITS.items() if name.endswith(end)), "")
                kind = column["arrow"] + (("，可空", ", optional")[pick] if column["nullable"] else "")
                lines.append(f"| `{name}` | {kind} | {unit} | {column[lang]} |\n")
    return "".join(lines)


PAGES: dict[str, Callable[[str], str]] = {
    "rules": rules,
    "problems": problems,
    "glossary": glossary,
    "columns": columns,
}


def write() -> list[Path]:
    """Write those that are other ones now; give them."""
    changed = []
    for lang in LANGUAGES:
        for topic, make in PAGES.items():
            path = FOLDER / lang / f"{topic}.md"
            new = make(lang)
            if not path.exists() or path.read_text(encoding="utf-8") != new:
                path.write_text(new, encoding="utf-8")
                changed.append(path)
    return changed
