"""Every repair of a device description's objects: a small text of our own, and what it must say."""

from __future__ import annotations

from pathlib import Path

import pytest
from eds_texts import codes, load

from canalyze.dictionary import EFFECTS
from canalyze.dictionary import load as load_file
from canalyze.errors import SourceError
from canalyze.words import sentences


def test_compact_cannot_blow_up() -> None:
    keys = "ParameterName=x\nObjectType=8\nDataType=5\nAccessType=ro\nCompactSubObj=254\n"
    found = load("".join(f"[{index:04X}]\n{keys}" for index in range(0x2000, 0x2000 + 119)))
    assert [len(thing.entries) for thing in found.objects] == [*[255] * 117, 165]
    assert [code for _, code in codes(found)][-4:] == ["unlisted", "too-many", "unlisted", "too-many"]
    assert {defect.facts["most"] for defect in found.defects if defect.code == "too-many"} == {30_000}


def test_defects_are_bounded() -> None:
    found = load("[2000]\nParameterName=x\nDataType=7\nAccessType=rw\n" + "no key\n" * 3000)
    assert len(found.defects) == 1001
    assert (found.defects[0].code, found.defects[0].facts) == ("more", {"code": "no-equals", "count": 2000})


def test_a_file_too_large(tmp_path: Path) -> None:
    (tmp_path / "large.eds").write_bytes(b"; nothing\n" * (1 << 20))
    with pytest.raises(SourceError) as raised:
        load_file(str(tmp_path / "large.eds"))
    assert raised.value.key == "eds.large"


def test_every_defect_has_words() -> None:
    keys = sentences("defect", "en").keys() | sentences("effect", "en").keys()
    for code, effect in EFFECTS.items():
        assert {f"defect.{code}", f"effect.{effect}"} <= keys
