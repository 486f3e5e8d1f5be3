"""`canalyze explain` of codes: what a number from a manual or a display is.

What it must not do: test how frames are explained.
"""

from __future__ import annotations

import pytest
from conftest import Runner

from canalyze._core import explain, rules

CODES = {
    "06020000h": ("SDO abort code", "object does not exist"),
    "0x06040041": ("SDO abort code", "cannot be mapped"),
    "8130h": ("EMCY error code", "heartbeat"),
    "emcy 2310": ("EMCY error code", "current"),
    "1016h": ("object 1016h", "heartbeat time"),
    "1016h:01": ("object 1016h:01", "heartbeat time"),
    "0x1F80": ("object 1F80h", ""),
    "register 11": ("generic error", "communication error"),
    "register 00": ("error register", "no error"),
    "statusword 0218": ("statusword 0218h", "fault"),
    "statusword FFFF": ("statusword FFFFh", "no state"),
    "controlword 000F": ("controlword 000Fh", "enable operation"),
    "state 7F": ("NMT state 7Fh", "Pre-operational"),
    "182": ("COB-ID 182h", "node 2"),
    "70Ah": ("COB-ID 70Ah", "node 10"),
    "000": ("COB-ID 000h", "NMT"),
    "node-silent": ("node-silent", "impact A"),
}


@pytest.mark.parametrize("code", CODES)
def test_a_code_is_explained_in_both_languages(code: str) -> None:
    said = explain(code, "en")
    assert said is not None
    for part in CODES[code]:
        assert part.lower() in said.lower()
    assert explain(code, "zh") not in (None, said)


def test_every_rule_is_explained() -> None:
    for rule in rules("en"):
        for name in (rule.code, rule.code.lower()):
            said = explain(name, "en")
            assert said is not None and rule.meaning in said and rule.cause in said


@pytest.mark.parametrize(
    "text", ["", "foo", "emcy", "emcy zz", "statusword 12345", "register 111", "800:1:2", "1FFFFFFFF"]
)
def test_what_is_no_code(text: str) -> None:
    assert explain(text, "en") is None


def test_several_codes(canalyze: Runner) -> None:
    done = canalyze("explain", "--lang", "en", "06020000h", "8130h", "register 11")
    assert done.code == 0
    assert "object does not exist" in done.out and "communication error" in done.out
    mixed = canalyze("explain", "--lang", "en", "8130h", "foo")
    assert mixed.code == 2 and "EMCY" in mixed.out and "foo" in mixed.err
    assert canalyze("explain", "--lang", "en", "emcy", "8130").out.startswith("EMCY error code")
    assert "node 10" in canalyze("explain", "--lang", "en", "-", stdin=b"70A\n").out
