"""The DBC of a capture held against the capture's own signals: cantools decodes each frame by the one file.

Why it exists: tests ask the same of many captures, and people of large ones (`python tests/dbc_decoding.py CAPTURE
[OPTION]...`, with options of `canalyze od`). What it must not do: know what a PDO is.
"""

from __future__ import annotations

import csv
import math
import os
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

import cantools
import forked
from cantools.database.can import Message
from captures import _read_log, run_canalyze

PLACE = re.compile(r"([0-9A-F]{4})h:([0-9A-F]{2})")


def read(path: Path) -> cantools.database.can.Database:
    """Read a DBC as strictly as cantools can."""
    database = cantools.database.load_file(path, strict=True, encoding="cp1252")
    assert isinstance(database, cantools.database.can.Database)
    return database


def made(capture: Path, options: list[str], folder: Path) -> tuple[Path, list[str]]:
    """The DBC of a capture, and the lines about it."""
    path = folder / "made.dbc"
    line = ["od", "--lang", "en", "--dbc", str(path), "--force", *options, str(capture)]
    done = forked.run(line, env=os.environ, timeout_s=6000)
    assert done.returncode == 0, done.stderr.decode()
    return path, done.stderr.decode().splitlines()


def compare(capture: Path, options: list[str], folder: Path) -> Counter[str]:
    """Decode every frame both ways. What is counted: values that are equal, frames that only one side can read."""
    path, said = made(capture, options, folder)
    messages = {(one.frame_id, one.is_extended_frame): one for one in read(path).messages}
    changed = {int(line.split(": ")[2].split("h ")[0], 16) for line in said if "mapping changed" in line}
    run_canalyze(["signals", *options, capture, "-o", folder / "signals.csv", "--force"])
    with (folder / "signals.csv").open(encoding="utf-8", newline="") as listing:
        rows = ((int(row["frame"]), row["object"], row["value"]) for row in csv.DictReader(listing))
        return held(capture, groupby(rows, key=lambda row: row[0]), messages, changed)


def held(
    capture: Path,
    rows: Iterator[tuple[int, Iterator[tuple[int, str, str]]]],
    messages: dict[tuple[int, bool], Message],
    changed: set[int],
) -> Counter[str]:
    """The same of the rows of signals, by frame."""
    counted: Counter[str] = Counter()
    ours = next(rows, None)
    for number, frame in enumerate(_read_log(capture.read_bytes()), 1):
        message = messages.get((frame.can_id, frame.extended))
        wanted = []
        if ours is not None and ours[0] == number:
            wanted = [(place, value) for _, place, value in ours[1]]
            ours = next(rows, None)
        if message is None or not wanted or frame.remote:
            counted["only signals"] += bool(wanted)
            counted["only DBC"] += message is not None
            continue
        found = by_place(message, frame.data)
        if frame.can_id in changed and [place for place, _ in found] != [place for place, _ in wanted]:
            counted["another mapping"] += 1
            continue
        left = [pair for pair in wanted if pair[1] and pair[0] in {place for place, _ in found}]
        assert len(left) == len(found), (number, message.name, found, wanted)
        for (place, value), (ours_place, our_value) in zip(found, left, strict=True):
            assert place == ours_place and same(value, our_value), (number, message.name, place, value, our_value)
            counted["equal"] += 1
    return counted


def by_place(message: Message, data: bytes) -> list[tuple[str, Any]]:
    """What cantools reads of a frame, by the object in the comment of each signal, in the order of the payload."""
    decoded = message.decode(data, decode_choices=False, allow_truncated=True)
    assert isinstance(decoded, dict)
    found = []
    for signal in sorted(message.signals, key=lambda one: one.start):
        place = PLACE.match(signal.comment or "")
        value = decoded.get(signal.name)
        if place and isinstance(value, int | float) and math.isfinite(value):  # as ours
            found.append((f"{place[1]}:{place[2]}", value))
    return found


def same(value: Any, text: str) -> bool:
    """Whether a value is the one that is written: reals to the digits of their type."""
    return float(value) == float(text) or abs(float(value) - float(text)) <= 1e-6 * abs(float(text))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place_of_file:
        print(dict(compare(Path(sys.argv[1]), sys.argv[2:], Path(place_of_file))))
