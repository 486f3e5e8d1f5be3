"""`check` over a whole folder of captures, as CI runs it: sessions with one seeded fault each, and the clean ones.

Every fault of the tables of `faults_of_sdo.py` and `faults_in_networks.py` fails its capture by the finding that
`decode` raises there, at its frame, with the annotated line of that frame; no clean session fails. What it must not do:
judge again which finding is right; those tables do.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

import faults_in_networks as network
import faults_of_sdo as seeded
import pytest
from captures import EDS, Analysis, CanFrame, Row, analyze, log_text, run_canalyze
from network_sessions import SESSIONS

Described = tuple[tuple[int, str], ...]
"""Node-IDs and their files of eds/."""


def seeded_capture(fault: seeded.Fault) -> list[CanFrame]:
    session = list(fault.session)
    fault.change(session, fault.at)
    return seeded.in_company(session)[0]


def faulty() -> dict[Described, dict[str, list[CanFrame]]]:
    """The captures by the descriptions that belong to them, by name."""
    captures: dict[Described, dict[str, list[CanFrame]]] = defaultdict(dict)
    for number, fault in enumerate(seeded.FAULTS):
        captures[()][f"seeded-{number:02}"] = seeded_capture(fault)
    for number, case in enumerate(network.CASES):
        frames, _ = case.fault(list(network.clean_frames(case.session)))
        captures[tuple(sorted(case.eds.items()))][f"network-{number:02}"] = frames
    return captures


def clean() -> dict[str, Iterable[CanFrame]]:
    return {name: network.clean_frames(name) for name in sorted(SESSIONS)}


def checked(
    folder: Path, captures: Mapping[str, Iterable[CanFrame]], eds: Described, expected_exit: int
) -> dict[str, list[Row]]:
    """The kinds of finding of each capture, of one call for all of them; a name without any is there too."""
    for name, frames in captures.items():
        (folder / f"{name}.log").write_bytes(log_text(frames))
    options = [part for node, file in eds for part in ("--eds", f"{node}={EDS / file}")]
    command = ["check", "--lang", "en", "--format", "jsonl", *options, "*.log"]
    rows = [json.loads(line) for line in run_canalyze(command, expected_exit=expected_exit, folder=folder).splitlines()]
    found: dict[str, list[Row]] = {Path(row["file"]).stem: [] for row in rows if row["kind"] == "check"}
    for row in rows:
        if row["kind"] == "finding":
            found[Path(row["file"]).stem].append(row)
    return found


def kind(row: Row) -> tuple[str, int | None, str | None, int | None]:
    return (row["code"], row["node"], row["index"], row["sub"])


def firsts(said: Analysis) -> dict[tuple[str, int | None, str | None, int | None], int]:
    """The frame of the first finding of each kind."""
    found: dict[tuple[str, int | None, str | None, int | None], int] = {}
    for row in said.findings:
        found.setdefault(kind(row), row["frame"])
    return found


CAPTURES = faulty()


@pytest.mark.parametrize("eds", sorted(CAPTURES), ids=lambda eds: "-".join(str(node) for node, _ in eds) or "none")
def test_every_fault_fails_its_capture_at_its_frame(eds: Described, tmp_path: Path) -> None:
    captures = CAPTURES[eds]
    found = checked(tmp_path, captures, eds, 1)
    assert sorted(found) == sorted(captures)
    failing = 0
    for name, frames in captures.items():
        said = analyze(log_text(frames), eds=dict(eds))
        # A kind may stand twice: by itself, and as a consequence of another.
        places = [(row["frame"], kind(row)) for row in found[name]]
        assert {of: frame for frame, of in sorted(places, key=lambda place: -place[0])} == firsts(said), name
        loud = {kind(row) for row in said.findings if row["severity"] != "info"}
        assert {kind(row) for row in found[name] if row["fails"]} == loud, name
        failing += bool(said.above_info())
        for row in found[name]:
            assert row["frame"] in [line["frame"] for line in row["lines"]], (name, row["code"])
    assert failing > len(captures) * 3 // 4


def test_no_clean_session_fails(tmp_path: Path) -> None:
    """But for the errors that devices report in some of them."""
    captures = clean()
    found = checked(tmp_path, captures, (), 1)
    assert sorted(found) == sorted(captures)
    failing = {name: {row["code"] for row in rows if row["fails"]} for name, rows in found.items()}
    for name, frames in captures.items():
        assert failing[name] <= {"EMC007", "EMC008"}, name
        assert not analyze(log_text(frames)).above_info(), name
    assert len(found) > 15


def test_there_are_enough() -> None:
    assert sum(map(len, CAPTURES.values())) > 150
