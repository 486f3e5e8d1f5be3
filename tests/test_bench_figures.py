"""The table of figures: what is divided by what, goals, peers that are missing, and the descriptions measured with."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import bench_captures
import pytest
from conftest import Runner
from figures import FIGURES, Taken, descriptions, document, with_defaults

FRAMES = 4000


def taken(**changes: Taken) -> dict[str, Taken]:
    """Returns the cost of tasks: a second for each of a thousand frames, except those given."""
    names = [
        "text",
        "text, two threads",
        "text, described",
        "text, synchronous",
        "text, unfit",
        "text, MCAP",
        "signals",
    ]
    names += ["JSON", "summary", "check", "tshark", "canopen-lens", "python -c pass", "decode, ten frames"]
    names += ["check, ten frames", "fleet", "fleet, two workers", "fleet, small", "their work"]
    return {name: Taken(1000, 1.0, 1.0, 10.0) for name in names} | changes


def rows(text: str) -> dict[str, list[str]]:
    """The cells of each row of the tables, by the first."""
    lines = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")
    ]
    return {name: cells for name, *cells in lines}


def test_each_figure_has_a_row_with_its_goal() -> None:
    made = taken(tshark=Taken(1000, 26.0, 26.0, 150.0), JSON=Taken(1_000_000, 0.7, 0.9, 40.0))
    found = rows(document(made, {}, ["canalyze 1.2.3"]))
    assert found["text against tshark's one line, one thread"] == ["26.0 x", "at least 25 x", "met"]
    assert found["text, two threads over one, wall clock"] == ["1.00 x", "at least 1.8 x", "not met"]
    assert found["JSON lines"] == ["0.70 s/M frames", "at most 0.6 s/M frames", "not met"]
    assert found["start of check over that of Python"] == ["0.00 ms", "at most 60 ms", "met"]
    assert {figure.title for figure in FIGURES} <= found.keys()
    assert found["tshark"] == ["1,000", "26.000", "26.000", "38", "150"]


def test_a_missing_peer_is_a_line() -> None:
    made = taken()
    del made["tshark"]
    found = rows(document(made, {"tshark": "not installed"}, []))
    assert found["text against tshark's one line, one thread"] == ["tshark: not installed", "at least 25 x", ""]
    assert found["tshark"][0] == "not installed"
    assert found["summary against canopen-lens"][0] == "1.00 x"


def test_instructions_are_left_out_where_none_are_counted() -> None:
    without = document(taken(), {}, [])
    assert "- instructions: left out" in without and "instructions/frame" not in without
    counted = document(taken(text=Taken(1000, 1.0, 1.0, 10.0, 4_405_000)), {}, [])
    assert "left out" not in counted
    assert rows(counted)["text"][-1] == "4,405"
    assert rows(counted)["JSON"][-1] == "-"


@pytest.mark.parametrize(
    ("name", "faults", "synchronous"),
    [("described", False, False), ("synchronous", False, True), ("unfit", True, True)],
)
def test_descriptions_are_what_they_are_called(
    canalyze: Runner, tmp_path: Path, name: str, faults: bool, synchronous: bool
) -> None:
    eds = descriptions(tmp_path)[name]
    (tmp_path / "a.log").write_text("".join(bench_captures.capture_lines(FRAMES)))
    lines = canalyze("decode", "--lang", "en", "--eds", f"1-8={eds}", "a.log").lines
    kinds = Counter(
        word for line in lines for word in ("does not fit", "EDS default mapping)", "[SYNC") if word in line
    )
    assert (kinds["does not fit"] > FRAMES * 0.8) == faults
    assert (kinds["EDS default mapping)"] > FRAMES * 0.8) == (not faults)
    assert (kinds["[SYNC"] > FRAMES * 0.4) == synchronous


def test_a_default_that_is_not_there_is_an_error() -> None:
    with pytest.raises(AssertionError, match="1A02sub9"):
        with_defaults("[1A02sub0]\r\nDefaultValue=2\r\n", {"1A02sub9": "1"})
    assert with_defaults("[1A02sub0]\r\nDefaultValue=2\r\n", {"1A02sub0": "1"}) == "[1A02sub0]\r\nDefaultValue=1\r\n"
