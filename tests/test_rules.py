"""Every rule has a capture that raises it and a clean one beside it, one change away, that does not.

`samples/rules/CODE.log` (or `.mcap`) raises exactly what stands in the table, at that frame and no other;
`CODE-FACE.log` are the rule's other faces; `CODE.eds` or `CODE.dcf` describes their node, `CODE.expect.toml` says
what is expected of both. A clean neighbour, `NAME.clean.log`, has nothing above info. A new rule without these fails
here. What it must not do: look at the wording; the goldens beside the captures freeze that.
"""

from __future__ import annotations

import difflib
from pathlib import Path

import pytest
from captures import SAMPLES, Analysis, Row, analyze, described_beside, expected_beside
from regenerate import CAPTURES, PIPED

from canalyze import _core

RULES = SAMPLES / "rules"
CODES = [rule.code for rule in _core.rules()]

Raised = tuple[str, int, int | None]
"""A code, the frame it stands at (the line, where a reader raises it), and the frame it is about, if another."""

RAISED: dict[str, list[Raised]] = {
    "BUS001": [("BUS001", 3, None)],
    "BUS001-storm": [("BUS001", 6, None), ("BUS004", 3, None), ("BUS002", 5, None), ("BUS006", 7, 6)],
    "BUS001-unseen": [("BUS001", 3, None)],
    "BUS002": [("BUS002", 3, None)],
    "BUS003": [("BUS003", 3, None)],
    "BUS004": [("BUS004", 3, None)],
    "BUS004-timeout": [("BUS004", 3, None)],
    "BUS005": [("BUS005", 3, None)],
    "BUS005-transmit": [("BUS005", 3, None)],
    "BUS006": [("BUS006", 3, None)],
    "BUS007": [("BUS007", 3, None)],
    "BUS007-lasting": [("BUS007", 3, None), ("BUS007", 5, 3)],
    "BUS007-unspecified": [("BUS007", 3, None)],
    "BUS008": [("BUS008", 3, None)],
    "BUS009": [("BUS009", 3, None)],
    "BUS009-extended": [("BUS009", 3, None)],
    "BUS009-identifier": [("BUS009", 3, None)],
    "CAP001": [("CAP001", 4, None)],
    "CAP002": [("CAP002", 4, None)],
    "CAP003": [("CAP003", 4, None)],
    "CAP004": [("CAP004", 3, None)],
    "CAP005": [("CAP005", 5, None)],
    "CAP006": [("CAP006", 5, 3)],
    "CAP007": [("CAP007", 10, 8)],
    "CAP008": [("CAP008", 4, None)],
    "CAP009": [("CAP009", 19, None), ("SYN003", 18, 15), ("SYN003", 25, 22)],
    "DRV001": [("DRV001", 17, None)],
    "DRV002": [("DRV002", 20, 14)],
    "DRV003": [("DRV005", 13, None), ("DRV003", 15, 13)],
    "DRV004": [("DRV004", 21, 18)],
    "DRV005": [("DRV005", 13, None)],
    "EDS001": [("EDS001", 2, None)],
    "EDS002": [("EDS002", 2, None)],
    "EDS003": [("EDS003", 4, None)],
    "EDS003-sub": [("EDS003", 4, None)],
    "EDS004": [("EDS004", 2, None)],
    "EDS004-controller": [("EDS004", 2, None)],
    "EDS005": [("SDO017", 4, None), ("EDS005", 4, None)],
    "EDS005-sub": [("SDO017", 4, None), ("EDS005", 4, None)],
    "EMC001": [("EMC008", 3, None), ("EMC001", 3, None), ("EMC009", 3, 3)],
    "EMC002": [("EMC002", 3, None)],
    "EMC002-left": [("EMC008", 3, None), ("EMC007", 4, None), ("EMC002", 5, None)],
    "EMC002-one-of": [("EMC008", 3, None), ("EMC007", 4, None), ("EMC002", 5, None)],
    "EMC002-several": [("EMC008", 3, None), ("EMC007", 4, None), ("EMC007", 5, None), ("EMC002", 6, None)],
    "EMC002-unseen": [("EMC008", 3, None), ("EMC002", 4, None)],
    "EMC003": [("EMC008", 3, None), ("EMC003", 3, None), ("EMC009", 3, 3)],
    "EMC004": [("EMC008", 6, None), ("EMC004", 6, None), ("EMC009", 7, 6)],
    "EMC004-reset": [("EMC008", 5, None), ("EMC004", 5, None)],
    "EMC005": [("EMC007", 3, None), ("EMC007", 4, None), ("EMC005", 4, None), ("EMC009", 4, 3), ("EMC009", 4, 3)],
    "EMC006": [("EMC006", 3, None)],
    "EMC007": [("EMC007", 3, None)],
    "EMC008": [("EMC008", 3, None)],
    "EMC009": [("EMC007", 3, None), ("EMC009", 4, 3)],
    "EMC009-repeated": [("EMC007", 3, None), ("EMC009", 6, 3)],
    "EMC010": [("EMC007", 3, None), ("EMC010", 3, None), ("EMC009", 13, 3)],
    "EMC011": [("EMC011", 6, None)],
    "EXP001": [("EXP001", 3, None)],
    "EXP002": [("EXP002", 4, None)],
    "EXP003": [("EXP003", 4, None)],
    "EXP004": [("EXP004", 4, None)],
    "EXP005": [("EXP005", 7, None)],
    "EXP006": [("EXP006", 6, None)],
    "EXP007": [("EXP007", 9, None)],
    "EXP008": [("EXP008", 9, 8), ("EXP008", 10, 9)],
    "EXP009": [("EXP009", 6, 5), ("EXP009", 7, 6)],
    "EXP010": [("EXP010", 7, 6), ("EXP010", 8, 7)],
    "EXP011": [("EXP011", 5, None)],
    "EXP012": [("EMC008", 5, None), ("EXP012", 5, None), ("EMC009", 6, 5)],
    "EXP013": [("EXP013", 4, 3)],
    "EXP014": [("EXP014", 10, None)],
    "EXP015": [("EXP015", 3, None)],
    "EXP016": [("EXP016", 6, None)],
    "EXP017": [("EXP017", 5, None)],
    "EXP018": [("SDO017", 2, None), ("EXP018", 4, 1)],
    "EXP019": [("SDO017", 2, None), ("EXP019", 4, 1)],
    "EXP020": [("SDO017", 2, None), ("EXP020", 4, 1)],
    "GRD001": [("GRD001", 8, None)],
    "GRD002": [("GRD002", 8, 7)],
    "GRD003": [("GRD003", 14, 13)],
    "GRD003-producer": [("GRD003", 10, 8)],
    "GRD004": [("GRD004", 4, 3)],
    "GRD005": [("GRD005", 22, 17)],
    "HBT001": [("HBT001", 8, None)],
    "HBT002": [("HBT002", 8, 7)],
    "HBT002-consumer": [("HBT002", 8, 7)],
    "HBT003": [("HBT003", 4, None)],
    "HBT003-bit-7": [("HBT003", 8, None)],
    "HBT004": [("HBT004", 5, None)],
    "HBT004-gaps": [("HBT004", 12, 11)],
    "HBT004-rate": [("HBT004", 10, 9)],
    "HBT004-states": [("HBT004", 7, 6), ("NMT004", 4, None)],
    "HBT005": [("HBT005", 11, None)],
    "HBT006": [("HBT006", 4, None)],
    "HBT007": [("HBT007", 37, None)],
    "LSS001": [("LSS001", 9, None)],
    "LSS001-length": [("LSS001", 9, None)],
    "LSS001-slave": [("LSS001", 9, None)],
    "LSS002": [("LSS002", 10, 9)],
    "LSS003": [("LSS003", 12, None)],
    "LSS004": [("LSS004", 10, 9)],
    "LSS004-specific": [("LSS004", 10, 9)],
    "LSS005": [("LSS005", 14, 13)],
    "LSS005-old": [("LSS005", 15, 14)],
    "LSS006": [("LSS006", 12, 10)],
    "LSS007": [("LSS007", 7, 6)],
    "LSS007-selective": [("LSS007", 10, 9)],
    "LSS008": [("LSS008", 12, 11)],
    "LSS009": [("LSS009", 12, 11)],
    "LSS010": [("LSS010", 12, None)],
    "LSS010-part": [("LSS010", 12, None)],
    "LSS011": [("LSS011", 13, None)],
    "LSS012": [("LSS012", 11, 10)],
    "LSS012-global": [("LSS012", 5, 4)],
    "LSS030": [("LSS030", 3, None)],
    "MPD001": [("MPD001", 4, None)],
    "NMT001": [("NMT001", 3, None)],
    "NMT001-length": [("NMT001", 3, None)],
    "NMT001-node": [("NMT001", 3, None)],
    "NMT002": [("NMT002", 10, 8)],
    "NMT002-reset": [("NMT002", 20, 9)],
    "NMT003": [("NMT003", 4, None)],
    "NMT003-running": [("NMT003", 7, None)],
    "NMT004": [("NMT004", 7, None)],
    "NMT005": [("EMC008", 7, None), ("NMT005", 8, None), ("EMC009", 9, 7)],
    "NMT006": [("NMT006", 54, 23)],
    "PDO001": [("PDO001", 15, None)],
    "PDO001-receiver": [("PDO001", 8, None)],
    "PDO002": [("PDO002", 4, None)],
    "PDO003": [("PDO003", 4, None)],
    "PDO004": [("PDO004", 13, 12)],
    "PDO005": [("PDO005", 16, 12)],
    "PDO006": [("PDO006", 15, None)],
    "PDO006-receiver": [("PDO006", 8, None)],
    "PDO008": [("PDO008", 2, 1)],
    "PDO008-rpdo": [("PDO008", 2, 1)],
    "PDO009": [("PDO009", 4, 3)],
    "PDO009-not-invalid": [("PDO009", 6, 5)],
    "PDO010": [("PDO010", 4, 3)],
    "PDO011": [("PDO011", 3, None)],
    "PDO012": [("PDO012", 4, None)],
    "PDO013": [("PDO013", 8, 5)],
    "PDO014": [("PDO014", 2, 1)],
    "PDO015": [("PDO015", 3, None)],
    "PDO016": [("PDO016", 8, 7)],
    "PDO018": [("PDO018", 5, None)],
    "PDO019": [("PDO019", 3, None)],
    "PDO020": [("PDO020", 5, 3)],
    "PDO021": [("PDO021", 7, None)],
    "SDO001": [("SDO001", 8, None)],
    "SDO001-counter": [("SDO001", 7, None), ("SDO017", 8, None)],
    "SDO001-refused": [("SDO001", 7, None), ("SDO017", 8, None)],
    "SDO001-request": [("SDO001", 5, None)],
    "SDO002": [("SDO002", 4, 3)],
    "SDO002-acknowledgement": [("SDO002", 7, 6)],
    "SDO002-duplicate": [("SDO002", 3, None)],
    "SDO002-end": [("SDO002", 4, 3)],
    "SDO002-gave-up": [("SDO002", 6, 5), ("SDO017", 6, None)],
    "SDO002-response": [("SDO002", 3, None)],
    "SDO002-timeout": [("SDO002", 4, 3), ("SDO017", 4, None)],
    "SDO003": [("SDO003", 4, None)],
    "SDO004": [("SDO004", 4, None)],
    "SDO004-segments": [("SDO004", 4, None)],
    "SDO004-size": [("SDO004", 4, None)],
    "SDO005": [("SDO005", 6, None)],
    "SDO006": [("SDO006", 6, 4)],
    "SDO006-block": [("SDO006", 9, 4)],
    "SDO006-refused": [("SDO006", 5, None), ("SDO017", 6, None)],
    "SDO007": [("SDO007", 7, None)],
    "SDO007-no-last": [("SDO007", 7, 6)],
    "SDO007-refused": [("SDO007", 3, None), ("SDO017", 4, None)],
    "SDO008": [("SDO008", 5, None)],
    "SDO009": [("SDO009", 3, None)],
    "SDO009-command": [("SDO009", 3, None)],
    "SDO009-unused": [("SDO009", 6, None)],
    "SDO010": [("SDO010", 3, None)],
    "SDO010-empty": [("SDO010", 3, None)],
    "SDO010-response": [("SDO010", 4, None)],
    "SDO011": [("SDO011", 7, None)],
    "SDO011-reset": [("SDO011", 4, None)],
    "SDO012": [("SDO012", 7, None)],
    "SDO012-acknowledged": [("SDO012", 8, None)],
    "SDO012-block-size": [("SDO012", 3, None)],
    "SDO012-early-end": [("SDO025", 7, None), ("SDO012", 8, None)],
    "SDO012-next-block-size": [("SDO012", 6, None)],
    "SDO012-not-confirmed": [("SDO012", 10, 9)],
    "SDO013": [("SDO013", 2, None)],
    "SDO013-write": [("SDO013", 2, 1)],
    "SDO014": [("SDO014", 4, 3)],
    "SDO014-read": [("SDO014", 4, 3)],
    "SDO015": [("SDO015", 4, 3)],
    "SDO016": [("SDO016", 4, None), ("SDO017", 4, None)],
    "SDO017": [("SDO017", 4, None)],
    "SDO017-client": [("SDO017", 5, None)],
    "SDO018": [("SDO017", 4, None), ("SDO018", 4, None)],
    "SDO019": [("SDO019", 9, None)],
    "SDO019-initial-ffff": [("SDO019", 9, None)],
    "SDO019-padding": [("SDO019", 9, None)],
    "SDO019-reflected": [("SDO019", 9, None)],
    "SDO020": [("SDO017", 4, None), ("SDO020", 5, 3)],
    "SDO020-slow": [("SDO020", 6, 3)],
    "SDO020-timeout": [("SDO002", 4, 3), ("SDO017", 4, None), ("SDO020", 5, 3)],
    "SDO021": [("SDO021", 3, None)],
    "SDO022": [("SDO022", 4, None)],
    "SDO024": [("SDO024", 8, None)],
    "SDO025": [("SDO025", 9, None), ("SDO012", 10, None)],
    "SDO023": [("SDO023", 3, None)],
    "SDO023-response": [("SDO023", 4, None)],
    "SDO030": [("SDO030", 3, None)],
    "SDO030-flood": [("SDO030", 3, None)],
    "SDO030-foreign": [("SDO030", 1, None)],
    "SDO031": [("SDO031", 1, None)],
    "SDO032": [("SDO032", 1, None)],
    "SDO032-answers": [("SDO032", 1, None)],
    "SDO032-answers-of-two": [("SDO032", 1, None)],
    "SRD001": [("SRD001", 12, 11)],
    "SRD001-length": [("SRD001", 12, 11)],
    "SRD002": [("SRD002", 12, 11)],
    "SRD003": [("SRD003", 12, None)],
    "SRD004": [("SRD004", 14, 11)],
    "SRD004-normal": [("SRD004", 13, 11)],
    "SRD004-order": [("SRD004", 13, 12), ("SRD004", 15, 14)],
    "SRD005": [("SRD005", 14, None)],
    "SYN001": [("SYN001", 4, None)],
    "SYN001-changed": [("SYN001", 7, None)],
    "SYN001-long": [("SYN001", 5, None)],
    "SYN002": [("SYN002", 7, None)],
    "SYN002-outside": [("SYN002", 7, None)],
    "SYN003": [("SYN003", 9, 8)],
    "SYN003-configured": [("SYN003", 11, None)],
    "SYN003-early": [("SYN003", 10, 9)],
    "SYN003-late": [("SYN003", 9, 8)],
    "SYN004": [("SYN004", 16, None)],
    "SYN005": [("SYN005", 4, 3)],
    "SYN006": [("SYN006", 10, 8)],
    "SYN006-counters": [("SYN006", 7, None), ("SYN002", 5, None)],
    "SYN006-trains": [("SYN006", 12, 11), ("SYN003", 8, 7), ("SYN003", 10, 9)],
    "SYN007": [("SYN007", 6, 4)],
    "SYN008": [("SYN008", 15, 13)],
    "SYN008-stopped": [("SYN008", 18, 14)],
    "SYN009": [("SYN009", 15, 14)],
    "SYN010": [("SYN010", 12, 10)],
    "SYN010-late": [("SYN010", 15, None)],
    "SYN011": [("SYN011", 30, None)],
    "SYN011-no-stamps": [("SYN011", 6, None)],
    "SYN012": [("SYN012", 10, None)],
    "SYN013": [("SYN013", 18, 15)],
    "TIM001": [("TIM001", 3, None)],
    "TIM001-length": [("TIM001", 3, None)],
    "TIM001-reserved": [("TIM001", 3, None)],
    "TIM002": [("TIM002", 4, 3)],
}
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


CHANGES = {"CAP009": 2}
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
