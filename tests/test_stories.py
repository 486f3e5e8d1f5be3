"""Recorded stories against their truth: roots, when they begin, how they stand, and what caused what.

Those of samples/stories are of our own nodes; further ones, of real stacks, lie beside the checkout or nowhere. The
truth lies in JSON beside each. What it must not do: test words, or what single faults are called.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from captures import SAMPLES, SHARED, Row
from diagnoses import Diagnosed, diagnosed

from canalyze.records.problems import FORMER_STATUSES

STORIES = [*sorted((SAMPLES / "stories").glob("*.json")), *sorted((SHARED / "stories").glob("*.json"))]


def test_there_are_stories() -> None:
    assert STORIES


@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.stem)
def test_a_truth_fits_its_recording(path: Path) -> None:
    truth = json.loads(path.read_text())
    lines = path.with_name(truth["capture"]).read_text().splitlines()
    assert truth["frames"] == len(lines)
    known = {one["node"] for one in truth["nodes"]}
    for number, story in enumerate(truth["stories"]):
        begin, visible, end = (story[f"{name}_line"] for name in ("begin", "visible_from", "end"))
        assert 1 <= begin <= visible <= len(lines)
        assert (end is None) == (FORMER_STATUSES.get(story["status"], story["status"]) == "open")
        assert end is None or visible <= end <= len(lines) or story["status"] == "harmless"
        assert story["root"] == (story["caused_by"] is None)
        assert story["root"] or 0 <= story["caused_by"] < number
        assert {begin, visible} <= set(story["evidence_lines"]) <= set(range(1, len(lines) + 1))
        if story["status"] != "harmless" and "absent" not in path.stem:
            assert nodes(story["subject"]) <= known


def nodes(subject: Row) -> set[int]:
    """The nodes of a subject."""
    alone = [subject["node"]] if subject.get("node") is not None else []
    return {*alone, *(subject.get("nodes") or ())}


def fitting(story: Row, found: Diagnosed) -> list[Row]:
    """The incidents that may be a story: of its bus and nodes, and begun where it can have begun."""
    wanted = nodes(story["subject"])
    return [
        one
        for one in found.incidents
        if one["subject"]["bus"] == story["subject"]["bus"]
        and story["begin_line"] <= one["begin"]["frame"] <= story["visible_from_line"]
        and (bool(nodes(one["subject"]) & wanted) if wanted else not nodes(one["subject"]))
        and (one["cause"] is None) == story["root"]
    ]


@pytest.mark.parametrize("path", STORIES, ids=lambda path: path.stem)
def test_a_story_is_told_as_it_was(path: Path) -> None:
    truth = json.loads(path.read_text())
    found = diagnosed(path.with_suffix(".log").read_bytes())
    told = [fitting(story, found) for story in truth["stories"]]
    for story, incidents in zip(truth["stories"], told, strict=True):
        assert incidents, f"not told: {story['kind']}; told: {found.said}"
        assert {one["status"] for one in incidents} == {FORMER_STATUSES.get(story["status"], story["status"])}, story[
            "kind"
        ]
        if story["caused_by"] is not None:
            causes = {one["id"] for one in told[story["caused_by"]]}
            assert {one["cause"]["id"] for one in incidents} <= causes, story["kind"]
    known = {one["id"] for incidents in told for one in incidents}
    further = [one["message"] for one in found.incidents if one["cause"] is None and one["id"] not in known]
    assert not further
