"""What is printed keeps to the house's terms (`tests/terms.toml`): the core and Python, in both languages.

The core's sentences are read from its source: most of them are printed in a state of the bus that no test can bring
about for all. What it must not do: judge a sentence beyond the table.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from captures import TESTS, run_canalyze

from canalyze.words import FOLDER, LANGUAGES, sentences

PACKAGE = TESTS.parent / "canalyze"
CORE = PACKAGE / "core" / "src"
TABLES = PACKAGE / "core" / "words"
CHINESE = re.compile("[\u4e00-\u9fff]")
LITERAL = re.compile(r'"((?:[^"\\]|\\.)*)"', re.DOTALL)
ROOMS = ("words", "wire", "rules", "problems")


@dataclass(frozen=True)
class Term:
    """A row of the table."""

    lang: str
    use: str
    wrong: re.Pattern[str]
    but: tuple[str, ...]
    where: str

    def found(self, place: str, sentence: str) -> str:
        """What of a sentence is not the house's; nothing where all is."""
        if not place.startswith(self.where):
            return ""
        quoted = f'"{sentence}"'
        for right in self.but:
            quoted = quoted.replace(right, '""' if right.startswith('"') else "")
        hit = self.wrong.search(quoted[1:-1])
        return hit.group() if hit else ""


def _terms() -> tuple[Term, ...]:
    table = tomllib.loads((TESTS / "terms.toml").read_text("utf-8"))
    return tuple(
        Term(lang, row["use"], re.compile("|".join(row["not"])), tuple(row.get("but", ())), row.get("where", ""))
        for lang in ("zh", "en")
        for row in table[lang]
    )


TERMS = _terms()


def _printed(path: Path) -> Iterator[str]:
    """The literals of a source file that may be printed, and the documentation of rules: no attributes, no tests."""
    text = path.read_text("utf-8").split("#[cfg(test)]")[0]
    if "rules! {" in text:
        yield from re.findall(r"^    /// (.+)$", text, flags=re.MULTILINE)
    text = re.sub(r"^\s*//.*$|\s// .*$|^\s*#\[.*\]$", "", text, flags=re.MULTILINE)
    yield from (found.group(1) for found in LITERAL.finditer(text))


def _of_core() -> Iterator[tuple[str, str]]:
    for room in ROOMS:
        for path in sorted((CORE / room).rglob("*.rs")):
            if path.name != "tests.rs" and "tests" not in path.parts:
                place = path.relative_to(PACKAGE).as_posix()
                yield from ((place, one) for one in _printed(path) if CHINESE.search(one) or " " in one.strip())
    # Device profiles have CiA's own names.
    for path in sorted(set(TABLES.glob("*.tsv")) - set(TABLES.glob("cia*"))):
        rows = [line.split("\t") for line in path.read_text("utf-8").splitlines() if line[:1] != "#"]
        cells = [cell for first, *others in rows for cell in (*first.split(", "), *others)]
        yield from ((f"core/words/{path.name}", one) for one in cells if CHINESE.search(one) or " " in one)


def _of_python() -> Iterator[tuple[str, str]]:
    for topic in sorted(path.stem for path in Path(FOLDER).glob("*.txt")):
        for lang in LANGUAGES:
            yield from ((f"words: {key}", sentence) for key, sentence in sentences(topic, lang).items())


def _faults(sentences: Iterator[tuple[str, str]]) -> list[str]:
    faults = []
    for place, sentence in sentences:
        lang = "zh" if CHINESE.search(sentence) else "en"
        for term in TERMS:
            if term.lang == lang and (found := term.found(place, sentence)):
                faults.append(f"{place}: {found!r} (use {term.use}) in: {sentence[:160]}")
    return faults


def test_the_core_keeps_to_the_terms() -> None:
    assert sum(1 for _ in _of_core()) > 1500
    assert _faults(_of_core()) == []


FULL = re.compile("[，：；（）！？]")
HALF = re.compile(r"[一-龥}”》)][,;:](?= |$|[一-龥])|\d[;:](?= |$)|[一-龥]\(|\([^()]*[一-龥][^()]*\)")
CODE = re.compile(r"^(canalyze|\{command\}): |索引\[:子索引\]:位数|^\(.*\)$")
"""The program's name, syntax, and a note in a table."""


def _other_marks(text: str, style: str) -> bool:
    """Returns true if a Chinese text has marks of another style: `full`, `half`, or `one`, which is either of them."""
    full, half = FULL.search(text) is not None, HALF.search(CODE.sub("", text)) is not None
    return {"full": half, "half": full, "one": full and half}[style]


def test_chinese_punctuation() -> None:
    table = tomllib.loads((TESTS / "terms.toml").read_text("utf-8"))
    half = set(table["punctuation"]["half"])
    python = [
        (key, sentence, "one" if {topic, key} & half else "full")
        for topic in sorted(path.stem for path in Path(FOLDER).glob("*.txt"))
        for key, sentence in sentences(topic, "zh").items()
        if not key.endswith(".examples")  # command lines and files
    ]
    core = [(place, one, "half") for place, one in _of_core() if place.startswith("core/words/")]
    wrong = [
        f"{key}: {text}" for key, text, style in python + core if CHINESE.search(text) and _other_marks(text, style)
    ]
    assert wrong == []


@pytest.mark.parametrize(
    ("text", "style", "wrong"),
    [
        ("共3次，基线1次", "full", False),
        ("共3次, 基线1次", "full", True),
        ("共3次, 基线1次", "half", False),
        ("{name}: 没有记录", "full", True),
        ("规则(HBT002)、代码", "full", True),
        ("如 185=6041:16,6064:32；每项为 索引[:子索引]:位数", "full", False),
        ("节点5: 无应答（超时）", "one", True),
        ("节点5: 无应答(超时)", "one", False),
        ("无应答（超时）", "half", True),
    ],
)
def test_what_punctuation_finds(text: str, style: str, wrong: bool) -> None:
    assert _other_marks(text, style) == wrong


def test_python_keeps_to_the_terms() -> None:
    assert sum(1 for _ in _of_python()) > 1500
    assert _faults(_of_python()) == []


@pytest.mark.parametrize(
    ("sentence", "wrong"),
    [
        ("没有不合格的发现", True),
        ("未发现问题", False),
        ("厂商字节 00", True),
        ("节点守护无应答", True),
        ("节点5的保护应答", True),
        ("节点5的节点保护应答", False),
        ("没有心跳300ms", True),
        ("没有心跳300 ms", False),
        ("1 was due", True),
        ("it is told once", True),
        ("expected 1", False),
        ("2 bytes passed over", True),
        ("emergency of node 5", True),
        ("STO, emergency stop or supply", False),
    ],
)
def test_the_table_finds_what_it_should(sentence: str, wrong: bool) -> None:
    assert bool(_faults(iter([("core", sentence)]))) == wrong


def test_each_row_finds_something() -> None:
    """A row whose expression can find nothing is none."""
    for term in TERMS:
        assert term.wrong.pattern and not term.wrong.search(""), term.use


def _terms_to_explain() -> list[str]:
    table = tomllib.loads((TESTS / "terms.toml").read_text("utf-8"))
    rows = [row for lang in ("zh", "en") for row in table[lang] if not row.get("style")]
    return [name for row in rows for name in row["use"].split(", ")]


MORE = [
    "客户端",
    "服务器",
    "同步",
    "心跳",
    "master",
    "slave",
    "client",
    "server",
    "SDO client",
    "NMT主站",
    "error active",
]


@pytest.mark.parametrize("name", [*_terms_to_explain(), *MORE])
@pytest.mark.parametrize("lang", LANGUAGES)
def test_each_term_is_explained(name: str, lang: str) -> None:
    assert run_canalyze(["explain", "--lang", lang, name]).strip()
