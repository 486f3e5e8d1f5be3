"""Every rule has a capture that raises it and a clean one beside it, one change away, that does not.

`samples/rules/CODE.log` (or `.mcap`) raises exactly what `data/raised.txt` has, at that frame and no other;
`CODE-FACE.log` are the rule's other faces; `CODE.eds` or `CODE.dcf` describes their node, `CODE.expect.toml` says
what is expected of both. A clean neighbour, `NAME.clean.log`, has nothing above info. A new rule without these fails
here. What it must not do: look at the wording; the goldens beside the captures freeze that.
"""

from __future__ import annotations

import difflib
import re
from pathlib import Path

import pytest
from captures import DATA, SAMPLES, Analysis, Row, analyze, described_beside, expected_beside
from regenerate import CAPTURES, PIPED

from canalyze import _core

RULES = SAMPLES / "rules"
CODES = [rule.code for rule in _core.rules()]

Raised = tuple[str, int, int | None]
"""A code, the frame it stands at (the line, where a reader raises it), and the frame it is about, if another."""


def raised_by_captures() -> dict[str, list[Raised]]:
    """Returns the rows of `data/raised.txt`: codes with their frames, and behind `<` the frame that each is about."""
    rows = (line.split(": ") for line in (DATA / "raised.txt").read_text().splitlines())
    place = re.compile(r"(\w+) (\d+)(?:<(\d+))?")
    return {
        name: [(code, int(frame), int(about) if about else None) for code, frame, about in place.findall(found)]
        for name, found in rows
    }


RAISED = raised_by_captures()
"""All that a capture raises, in order: its own rule and what goes with it (an abort is said whatever its reason)."""

FACTS: dict[str, dict[str, object]] = {
    "SDO019": {"computed": "9015", "found": "0000", "matches": None},
    "SDO019-initial-ffff": {"computed": "9015", "found": "A12B", "matches": "initial_ffff"},
    "SDO019-padding": {"computed": "9015", "found": "E9A9", "matches": "with_padding"},
    "SDO019-reflected": {"computed": "9015", "found": "8B19", "matches": "reflected"},
}
"""What tells the faces of a rule apart, where its place does not."""

CLEAN = sorted(path.name.split(".")[0] for path in RULES.glob("*.clean.*") if path.suffix in CAPTURES)


def capture(name: str) -> Path:
    return next(path for path in (RULES / f"{name}{suffix}" for suffix in CAPTURES) if path.is_file())


def analysis(path: Path, lang: str = "en") -> Analysis:
    piped = path.name.split(".")[0] in PIPED
    known, expected = described_beside(path), expected_beside(path)
    return analyze(
        path.read_bytes(), name=path.name, lang=lang, regular=not piped, network=known, expectations=expected
    )


def raised(said: Analysis) -> list[Raised]:
    def place(row: Row) -> int:
        by_line = row["code"].startswith("CAP") and row["line"] is not None
        return int(row["line" if by_line else "frame"])

    return [(row["code"], place(row), row["cause_frame"]) for row in said.findings]


def own_code(name: str) -> str:
    return name.split("-")[0]


CHANGES = {"CAP009": 2, "GRD002": 2}
"""What one change does not show: a single missing frame is no sign that the recording loses frames."""


def test_every_rule_has_its_capture_and_its_clean_neighbour() -> None:
    captures = {path.stem for path in RULES.glob("*.*") if path.suffix in CAPTURES and ".clean." not in path.name}
    assert captures == set(RAISED), "a capture without row, or a row without capture"
    assert [code for code in CODES if code not in captures] == []
    assert [code for code in CODES if code not in CLEAN] == []
    assert set(CLEAN) <= captures
    assert {own_code(name) for name in captures} <= set(CODES)


@pytest.mark.parametrize("name", RAISED)
def test_a_capture_raises_its_rule_and_nothing_else(name: str) -> None:
    said = analysis(capture(name))
    assert raised(said) == RAISED[name], said.findings
    assert own_code(name) in {code for code, _, _ in RAISED[name]}
    lines = {row["frame"]: row["line"] for row in said.frames}
    for row in said.findings:
        assert row["code"].startswith("CAP") or row["line"] == lines[row["frame"]]


@pytest.mark.parametrize("name", FACTS)
def test_what_a_finding_measured(name: str) -> None:
    (finding,) = analysis(capture(name)).findings
    assert finding["facts"] == FACTS[name]


@pytest.mark.parametrize("name", CLEAN)
def test_a_clean_neighbour_raises_nothing(name: str) -> None:
    said = analysis(capture(f"{name}.clean"))
    assert not said.above_info(), said.complaint()
    assert own_code(name) not in {row["code"] for row in said.findings}
    assert said.transfers
    assert {row["status"] for row in said.transfers} <= {"ok", "aborted"}


@pytest.mark.parametrize("name", CLEAN)
def test_a_clean_neighbour_is_one_change_away(name: str) -> None:
    if capture(name).suffix != ".log":
        damaged, whole = capture(name).read_bytes(), capture(f"{name}.clean").read_bytes()
        flipped = [left ^ right for left, right in zip(damaged, whole, strict=False) if left != right]
        cut = len(damaged) < len(whole)
        assert flipped == [] if cut else [flip.bit_count() for flip in flipped] == [1]
        return
    before, after = (
        [line for line in (RULES / file).read_text().splitlines() if not line.startswith("#")]
        for file in (f"{name}.log", f"{name}.clean.log")
    )
    changes = [change for change in difflib.SequenceMatcher(None, before, after).get_opcodes() if change[0] != "equal"]
    assert len(changes) == CHANGES.get(name, 1)
    assert all(max(to_a - from_a, to_b - from_b) == 1 for _, from_a, to_a, from_b, to_b in changes)


@pytest.mark.parametrize("name", RAISED)
def test_a_finding_is_the_same_in_both_languages_but_for_its_words(name: str) -> None:
    path = capture(name)
    chinese, english = (analysis(path, lang) for lang in ("zh", "en"))
    assert raised(chinese) == raised(english)
    for left, right in zip(chinese.findings, english.findings, strict=True):
        assert is_chinese(left["message"]) and right["message"] and not is_chinese(right["message"])
        assert left["facts"] == right["facts"]


def test_every_rule_has_words_in_both_languages() -> None:
    assert [rule.code for rule in _core.rules("zh")] == [rule.code for rule in _core.rules("en")] == sorted(CODES)
    for chinese, english in zip(_core.rules("zh"), _core.rules("en"), strict=True):
        for part in ("message", "meaning", "cause"):
            left, right = getattr(chinese, part), getattr(english, part)
            assert left.strip() and right.strip() and left != right, (chinese.code, part)
            assert is_chinese(left) and right.replace("µ", "u").isascii(), (chinese.code, part)
        same = ("code", "name", "severity", "clause")
        assert [getattr(chinese, part) for part in same] == [getattr(english, part) for part in same]


def is_chinese(text: str) -> bool:
    return any("\u4e00" <= character <= "\u9fff" for character in text)
