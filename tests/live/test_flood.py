"""No loss at a rate at which `candump -r 8000000` on the same bus loses none. The figures are `flood.py`'s."""

from __future__ import annotations

from pathlib import Path

import pytest
from flood import flood
from listeners import need


@pytest.fixture(autouse=True, scope="module")
def socketcan() -> None:
    need("vcan0")


def test_where_candump_loses_nothing_sniff_loses_nothing(tmp_path: Path) -> None:
    for attempt, gap in enumerate(("0.02", "0.05", "0.2")):
        directory = tmp_path / str(attempt)
        directory.mkdir()
        told = flood(directory, seconds=8, gap=gap, senders=1, form="text", records=["log", "mcap"])
        if told["candump"] == told["carried"]:
            break
    else:
        pytest.fail(f"candump loses frames at any rate on this machine, so that nothing can be said: {told}")
    assert told["exit"] == 0, told
    assert told["shown"] == told["carried"] > 1000, told
    recorded, log = (directory / "flood.log").read_bytes(), Path(told["log"]).read_bytes()
    assert without_side(recorded) == without_side(log)


def without_side(log: bytes) -> bytes:
    """Candump's log with all that says who sent taken away."""
    return b"\n".join(line.removesuffix(b" T").removesuffix(b" R").rstrip() for line in log.splitlines())
