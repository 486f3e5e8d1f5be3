"""What is shown of a node and its drive once the node is lost, or the bus is away: unknown, not what was known last.

In lanes, which the page and a timeline draw, and in `monitor`. What it must not do: test when a node is lost.
"""

from __future__ import annotations

import json
from typing import Any

from captures import SAMPLES
from live_blocks import blocks
from test_core_live import block

from canalyze import _core
from canalyze.running.reading import SessionOptions

LINES = (SAMPLES / "stories" / "t13-both-axes.log").read_bytes().splitlines(keepends=True)
"""A drive of two axes, node 5."""
CUT = 417
"""The line of a heartbeat after which something is taken out, while both axes go on."""
OWN = (b" 705#", b" 185#", b" 285#", b" 585#", b" 085#")


def without(*taken: bytes) -> bytes:
    """The capture without some frames of node 5 behind the cut."""
    return b"".join(line for at, line in enumerate(LINES, 1) if at <= CUT or not any(one in line for one in taken))


GONE, MUTE, WHOLE = without(*OWN), without(b" 705#"), without()


def lanes(text: bytes) -> dict[str, list[tuple[int, str | None, str | None]]]:
    """By lane: since when, the state and its class."""
    session = _core.Session(SessionOptions(lang="en", format="diagnosis", tables=("lanes",)))
    session.begin("capture.log", True, "candump")
    session.feed(text)
    session.end()
    session.finish()
    found: dict[str, list[tuple[int, str | None, str | None]]] = {}
    for _, batch in session.batches(flush=True):
        columns = (batch.column(name) for name in ("lane", "t_ns", "state", "class"))
        for name, *row in zip(*columns, strict=True):
            found.setdefault(name, []).append(tuple(row))
    return found


def at_end(text: bytes, form: str = "candump") -> Any:
    """What `monitor` shows of node 5 when the capture is over."""
    session = _core.Session(SessionOptions(lang="en", format="monitor"))
    session.begin("capture.log", False, form)
    session.feed(text)
    session.rest()
    return next(one for one in json.loads(session.snapshot())["nodes"] if one["node"] == 5)


def test_a_drive_is_unknown_from_the_moment_on_at_which_its_node_is_lost() -> None:
    found = lanes(GONE)
    lost_ns, _, of_class = found["nmt/vcan0/node5"][-1]
    assert of_class == "lost"
    drives = [rows for name, rows in found.items() if name.startswith("drive/vcan0/node5")]
    assert drives
    for rows in drives:
        assert rows[-1] == (lost_ns, None, None)
    assert found["nmt/vcan0/node2"][-1][2] == "operational", "another node goes on"


def test_a_drive_that_goes_on_without_heartbeats_is_known() -> None:
    found = lanes(MUTE)
    assert found["nmt/vcan0/node5"][-1][2] == "lost"
    drives = [rows for name, rows in found.items() if name.startswith("drive/vcan0/node5")]
    assert drives and all(rows[-1][1] is not None for rows in drives)
    whole = lanes(WHOLE)
    assert whole["nmt/vcan0/node5"][-1][2] == "operational"


def test_monitor_shows_no_drive_of_a_lost_node() -> None:
    gone, mute, whole = at_end(GONE), at_end(MUTE), at_end(WHOLE)
    assert (gone["silent"], gone["drive"]) == ("heartbeat", None)
    assert mute["silent"] == "heartbeat" and mute["drive"] == whole["drive"], "who goes on is known"
    assert whole["silent"] is None and "1: " in whole["drive"]


def test_monitor_shows_no_drive_once_the_interface_was_away() -> None:
    session = _core.Session(SessionOptions(lang="en", format="monitor"))
    session.begin("vcan0", False, "live")

    def drive() -> object:
        return next(one for one in json.loads(session.snapshot())["nodes"] if one["node"] == 5)["drive"]

    session.feed(b"".join(blocks(WHOLE)))
    assert drive()
    session.feed(block(6, 0, which=1))
    assert drive() is None
