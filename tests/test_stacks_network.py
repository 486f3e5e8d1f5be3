"""Sessions of real stacks: node states, SYNC, PDOs, EMCY and LSS must be those that happened.

`samples/stacks/NAME.json` says what happened in NAME.log, list by list; SDO is `test_stacks.py`. A list that is empty
in all captures compares nothing, so the number of compared entries is asserted for each.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache

import pytest
from captures import SAMPLES, Analysis, Row, analyze

CAPTURES = sorted(path.stem for path in (SAMPLES / "stacks").glob("*.log"))
STATES = {"00": "boot-up", "04": "stopped", "05": "operational", "7F": "pre-operational"}


@cache
def said(name: str) -> Analysis:
    return analyze((SAMPLES / "stacks" / f"{name}.log").read_bytes())


@cache
def truth(name: str) -> Row:
    found: Row = json.loads((SAMPLES / "stacks" / f"{name}.json").read_text())
    return found


def of(name: str, service: str) -> Iterator[Row]:
    return (frame for frame in said(name).frames if frame["service"] == service)


def nmt(name: str) -> list[Row]:
    return [
        {"line": f["line"], "bus": f["bus"], "cs": f["nmt"]["command"], "node": f["nmt"]["target"]}
        for f in of(name, "nmt")
    ]


def boot_ups(name: str) -> list[Row]:
    return [
        {"line": f["line"], "bus": f["bus"], "node": f["node"]}
        for f in of(name, "heartbeat")
        if f["heartbeat"]["boot_up"]
    ]


def state_changes(name: str) -> list[Row]:
    found = []
    last: dict[int, str] = {}
    for frame in of(name, "heartbeat"):
        state = STATES[frame["heartbeat"]["state"]]
        if last.get(frame["node"]) != state:
            found.append({"line": frame["line"], "bus": frame["bus"], "node": frame["node"], "state": state})
        last[frame["node"]] = state
    return found


def emcy(name: str) -> list[Row]:
    return [
        {
            "line": f["line"],
            "bus": f["bus"],
            "node": f["node"],
            "code": f["emcy"]["code"],
            "error_register": f["emcy"]["register"],
            "data": f["emcy"]["manufacturer"].lower(),
        }
        for f in of(name, "emcy")
    ]


def lss(name: str) -> list[Row]:
    found = []
    for frame in of(name, "lss"):
        fields = frame["lss"]
        row = {
            "line": frame["line"],
            "bus": frame["bus"],
            "dir": "request" if fields["from"] == "master" else "answer",
            "cs": fields["command"],
        }
        for key in ("value", "mode", "new_node", "node"):
            if key in fields:
                row["value"] = fields[key]
        row |= {key: fields[key] for key in ("error", "specific") if key in fields}
        found.append(row)
    return found


LISTS: dict[str, Callable[[str], list[Row]]] = {
    "nmt": nmt,
    "boot_ups": boot_ups,
    "state_changes": state_changes,
    "emcy": emcy,
    "lss": lss,
}
LEFT_OUT = {"cause", "command", "service"}
"""Words of the truth for people."""


@pytest.mark.parametrize("kind", LISTS)
@pytest.mark.parametrize("name", CAPTURES)
def test_what_happened(name: str, kind: str) -> None:
    wanted = [{key: one[key] for key in one if key not in LEFT_OUT} for one in truth(name)[kind]]
    assert LISTS[kind](name) == wanted


@pytest.mark.parametrize("kind", [*LISTS, "heartbeat_producers", "sync", "pdo"])
def test_the_captures_hold_some(kind: str) -> None:
    assert sum(len(truth(name)[kind]) for name in CAPTURES) > 0


@pytest.mark.parametrize("name", CAPTURES)
def test_heartbeat_producers(name: str) -> None:
    counts: dict[int, int] = {}
    for frame in of(name, "heartbeat"):
        counts[frame["node"]] = counts.get(frame["node"], 0) + (not frame["heartbeat"]["boot_up"])
    for producer in truth(name)["heartbeat_producers"]:
        assert counts[producer["node"]] == producer["frames"]


@pytest.mark.parametrize("name", CAPTURES)
def test_sync(name: str) -> None:
    syncs = [(frame["line"], frame["id"], float(frame["t"])) for frame in of(name, "sync")]
    for wanted in truth(name)["sync"]:
        train = [one for one in syncs if wanted["first_line"] <= one[0] <= wanted["last_line"]]
        assert (train[0][0], train[-1][0], len(train)) == (wanted["first_line"], wanted["last_line"], wanted["count"])
        assert {can_id for _, can_id, _ in train} == {wanted["cob"]}


@pytest.mark.parametrize("name", CAPTURES)
def test_process_data(name: str) -> None:
    """Frames, lengths and mappings of every PDO, by what the capture itself shows."""
    frames = [frame for frame in of(name, "pdo") if not frame["rtr"]]
    seen = 0
    for wanted in truth(name)["pdo"]:
        last = wanted["valid_to_line"] or len(said(name).frames) + 1
        own = [
            frame
            for frame in frames
            if (frame["node"], frame["pdo"]["pdo"], frame["id"]) == (wanted["node"], wanted["pdo"], wanted["cob"])
            and wanted["valid_from_line"] <= frame["line"] <= last
        ]
        assert (len(own), own[0]["line"]) == (wanted["frames"], wanted["first_frame_line"])
        seen += len(own)
        for frame in own:
            pdo = frame["pdo"]
            mapped = [{key: signal[key] for key in ("index", "sub", "bits")} for signal in pdo["signals"]]
            assert (frame["len"], mapped, pdo["provenance"]) == (wanted["bytes"], wanted["mapping"], "observed")
    assert seen == len(frames)
