"""`check --format markdown`: what a reader of CommonMark with tables makes of it, whatever captures are called."""

from __future__ import annotations

import re
from typing import Any

import pytest
from markdown_it import MarkdownIt
from msgspec.structs import replace
from report_verdicts import BLOCKS, FINDING, hostile, many, one

from canalyze.check.verdict import Verdict
from canalyze.output import printable
from canalyze.reports import check
from canalyze.words import LANGUAGES, Words

MOST = 65_536
"""Characters of a comment on GitHub."""


def text(*verdicts: Verdict, lang: str = "en") -> str:
    return "\n".join(check.markdown(verdicts, Words(lang)))


def tokens(document: str) -> list[Any]:
    """The tokens of a reader: blocks, and those in their lines."""
    found = []
    for token in MarkdownIt("commonmark").enable("table").parse(document):
        found += [token, *(token.children or [])]
    return found


def cells(document: str) -> list[str]:
    """The text in the cells of the table, row by row."""
    rows = re.search(r"<tbody>(.*)</tbody>", MarkdownIt("commonmark").enable("table").render(document), re.DOTALL)
    return re.findall(r"<td[^>]*>(.*?)</td>", rows[1]) if rows else []


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("seeds", BLOCKS)
def test_nothing_of_a_capture_is_markup(seeds: range, lang: str) -> None:
    ours = {"heading", "paragraph", "inline", "text", "softbreak", "table", "thead", "tbody", "tr", "th", "td"}
    ours |= {"bullet_list", "list_item", "fence", "code_inline"}
    for seed in seeds:
        verdicts = hostile(seed)
        document = text(*verdicts, lang=lang)
        found = tokens(document)
        assert {token.type.removesuffix("_open").removesuffix("_close") for token in found} <= ours
        assert len(document) <= MOST
        assert not re.search(r"@(?!\u2060)", "".join(token.content for token in found if token.type == "text"))
        for token in found:
            if token.type == "heading_open":
                assert token.tag in ("h2", "h3")
        assert sum(token.type == "heading_open" and token.tag == "h2" for token in found) == 1
        lines = [line.text for verdict in verdicts for one in verdict.failures for line in one.finding.lines]
        fenced = [line for token in found if token.type == "fence" for line in token.content.splitlines()]
        assert {line[2:].strip() for line in fenced} <= {printable(line).strip() for line in lines}


def test_no_person_is_mentioned_and_nothing_is_a_link() -> None:
    said = "@team see https://example.org www.example.org #7 :tada: $x$ <b>"
    document = text(Verdict("@team.log", (one(replace(FINDING, message=said, lines=())),), error="@team"))
    assert "- @\u2060team" in document.splitlines()
    assert "@\u2060team see https\\://example.org www\\.example.org \\#7 :tada: \\$x\\$ \\<b\\>" in document


def test_a_long_document_says_what_it_leaves_out() -> None:
    verdicts = [replace(many(3, file=f"{number}.log"), frames=1) for number in range(1000)]
    document = text(*verdicts)
    assert len(document) <= MOST
    shown = len(cells(document)) // 3
    detailed = document.count("### ")
    assert 100 < shown < 1000 and 10 < detailed < 1000
    assert f"{1000 - shown} more files are not in the table" in document
    assert document.endswith(f"the details of {1000 - detailed} more files are left out to keep this short")
    without = text(*(Verdict(f"{number}.log", (one(count=1),)) for number in range(10)))
    assert "left out" not in without and "not in the table" not in without


def test_what_is_too_long_with_its_lines_is_shown_without() -> None:
    wide = replace(FINDING, lines=tuple(replace(line, text="x" * 40_000) for line in FINDING.lines))
    document = text(Verdict("a.log", (one(wide),)), Verdict("b.log", (one(),)))
    assert "x" * 100 not in document and document.count("- error SDO001") == 2
    assert sum(token.type == "fence" for token in tokens(document)) == 1
