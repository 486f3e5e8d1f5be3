"""Every kind of incident: told of its sample, not of the clean neighbour, and with words in both languages.

What it must not do: test causes, or how incidents are ranked.
"""

from __future__ import annotations

import re

import pytest
from captures import described_beside, log_text
from conftest import Runner
from diagnoses import ABOVE_HARMLESS, Diagnosed, diagnosed
from kind_row import Node
from kind_samples import FURTHER, TABLE, Further
from network import find

from canalyze import _core

KINDS = list(_core.PROBLEMS)
CASES = [
    pytest.param(kind, marks=[pytest.mark.xfail(strict=True, reason=sample.defect)] if sample.defect else [])
    for kind, sample in TABLE.items()
]


FURTHER_CASES = [
    pytest.param(case, id=name, marks=[pytest.mark.xfail(strict=True, reason=case.defect)] if case.defect else [])
    for name, case in FURTHER.items()
]


def found(kind: str, *, faulty: bool, lang: str = "en") -> Diagnosed:
    sample = TABLE[kind]
    network = None if sample.described is None else described_beside(sample.described)
    return diagnosed(sample.text(faulty), network, lang)


def every(said: Diagnosed) -> str:
    """All incidents in one line each, for messages."""
    return "\n".join(
        f"{one['problem']} {one['status']} #{one['begin']['frame']} {one['subject']} {one['message']}"
        for one in said.incidents
    )


def concerns(subject: dict[str, object], node: Node) -> bool:
    """Whether an incident is about this node, these nodes, or none."""
    if isinstance(node, tuple):
        return "node" not in subject and subject.get("nodes") == list(node)
    return subject.get("node") == node and (node is not None or not subject.get("nodes"))


def test_there_is_a_sample_of_each_kind() -> None:
    assert sorted(TABLE) == sorted(KINDS)


@pytest.mark.parametrize("kind", CASES)
def test_a_kind_is_told_of_its_sample(kind: str) -> None:
    sample, said = TABLE[kind], found(kind, faulty=True)
    told = [one for one in said.incidents if one["problem"] == kind]
    assert [one["status"] for one in told] == [sample.status], every(said)
    (one,) = told
    assert concerns(one["subject"], sample.node), one["subject"]
    assert sample.begin is None or one["begin"]["frame"] == sample.begin_frame(), every(said)


@pytest.mark.parametrize("kind", KINDS)
def test_a_clean_neighbour_has_no_incident(kind: str) -> None:
    said = found(kind, faulty=False)
    harmless = TABLE[kind].status == "harmless"
    told = [one for one in said.incidents if harmless and one["problem"] == kind]
    wrong = [*told, *(one for one in said.incidents if one["status"] in ABOVE_HARMLESS)]
    assert not wrong, every(said)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_has_words_in_both_languages(kind: str, lang: str) -> None:
    said = [one for one in found(kind, faulty=True, lang=lang).incidents if one["problem"] == kind]
    explained = _core.explain(kind, lang)
    assert explained is not None and kind in explained
    for text in [explained, *(one["message"] for one in said)]:
        assert text.strip() and not re.search(r"[{}]|%[sd]|None|Some\(", text), text
    chinese = re.compile(r"[\u4e00-\u9fff]")
    for one in said:
        assert bool(chinese.search(one["message"])) == (lang == "zh"), one["message"]


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_all_kinds_are_explained(canalyze: Runner, lang: str) -> None:
    explained = canalyze("explain", "--lang", lang, *KINDS)
    assert (explained.code, explained.err) == (0, "")
    for kind in KINDS:
        (first, *_) = (_core.explain(kind, lang) or "").splitlines()
        assert first in explained.out


@pytest.mark.parametrize("case", FURTHER_CASES)
def test_a_kind_is_told_as_it_stands(case: Further) -> None:
    frames = case.make()
    said = diagnosed(log_text(frames))
    told = [one for one in said.incidents if one["problem"] == case.kind]
    assert [one["status"] for one in told] == list(case.statuses), every(said)
    assert not case.unsaid or all(case.unsaid not in one["message"] for one in told), every(said)
    assert case.end is None or told[-1]["end"]["frame"] == find(frames, *case.end) + 1, told[-1]["end"]
