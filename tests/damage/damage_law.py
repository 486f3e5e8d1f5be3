"""What may not happen to a damaged capture: frames lost, changed or invented silently, and counts that differ.

Why it exists: one judge for the test and for campaigns by hand. What it must not do: ask that frames are recovered.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import forked
from damage_seeds import FORMS, Form, sound

COMMANDS = ("info", "check", "summary")
OF_THE_FILE = {"CAP001", "CAP002", "CAP004", "CAP005", "CAP008"}
"""Findings that say that the file lacks something, not what its frames show."""


@dataclass(frozen=True)
class Said:
    """What the commands say of a file."""

    frames: list[str]
    complaints: list[str]
    """Of `convert`."""
    code: int
    counts: dict[str, int | None]
    """How many frames there are, by each command."""
    doubts: dict[str, bool]
    """Whether something is wrong with the file, by each command."""
    passed_over: int
    """How many records are counted as no frames, by `info`."""
    doubtful: bool
    """Whether all that was read is said to be perhaps wrong."""


def run(*arguments: str, folder: Path) -> tuple[int, str, str]:
    """Runs a command line; its exit code, and both streams."""
    env = {**os.environ, "CANALYZE_LANG": "en"}
    done = forked.run(arguments, cwd=folder, env=env, timeout_s=30, kept=True)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def complains(err: str) -> bool:
    """Whether standard error is about the file, not about what the format that is written cannot hold."""
    return any(not line.startswith(("canalyze: ", "standard output: ")) for line in err.splitlines())


def rows(text: str, kind: str) -> list[dict[str, Any]]:
    """The lines of this kind."""
    return [row for row in map(json.loads, text.splitlines()) if row["kind"] == kind]


def said(folder: Path, name: str) -> Said:
    """What is said of a file."""
    code, out, err = run("convert", "--to", "candump", name, "-", folder=folder)
    assert code in (0, 1, 2), err
    assert "Traceback" not in err, err
    frames = [line for line in out.splitlines() if line.startswith("(")]
    counts: dict[str, int | None] = {"convert": len(frames)}
    doubts = {"convert": complains(err)}
    passed_over, doubtful = 0, False
    for command, kind in zip(COMMANDS, ("info", "check", "summary_capture"), strict=True):
        ended, text, complaints = run(command, "--format", "jsonl", name, folder=folder)
        assert "Traceback" not in complaints, complaints
        found = rows(text, kind)
        counts[command] = found[0]["frames"] if found else None
        row = found[0] if found else {}
        if command == "info" and found:
            passed_over = sum(one["count"] for one in row["contents"]["passed_over"])
            doubtful = any(one["kind"] == "doubtful" and one["offset"] == 0 for one in row["damage"])
        doubts[command] = bool(
            ended == 2
            or complains(complaints)
            or any(row.get(key) for key in ("damages", "gaps", "dropped", "error", "left_out"))
            or (row["unreadable"]["count"] if isinstance(row.get("unreadable"), dict) else row.get("unreadable"))
            or (command == "check" and any(found["code"] in OF_THE_FILE for found in rows(text, "finding")))
        )
    return Said(frames, err.splitlines(), code, counts, doubts, passed_over, doubtful)


@cache
def whole(form: str, folder: Path) -> list[str]:
    """What is read of the sound file."""
    name = f"sound.{FORMS[form].suffix}"
    Path(folder, name).write_bytes(sound(form))
    of_sound = said(folder, name)
    assert not of_sound.complaints, of_sound.complaints
    assert not any(of_sound.doubts.values()), of_sound.doubts
    return of_sound.frames


def falsehoods(form: str, kind: str, damaged: bytes, folder: Path) -> Iterator[str]:
    """What is wrong in what is said of a damaged file."""
    name = f"damaged.{FORMS[form].suffix}"
    Path(folder, name).write_bytes(damaged)
    of_damaged = said(folder, name)
    yield from of_frames(FORMS[form], kind, whole(form, folder), of_damaged)
    if of_damaged.code != 2 or of_damaged.frames:
        known = {command: count for command, count in of_damaged.counts.items() if count is not None}
        if len(set(known.values())) > 1:
            yield f"counts: {known}"
    if of_damaged.frames and len(set(of_damaged.doubts.values())) > 1:
        yield f"doubts: {of_damaged.doubts}; {of_damaged.complaints[:2]}"


def of_frames(form: Form, kind: str, before: list[str], of_damaged: Said) -> Iterator[str]:
    """Frames against frames."""
    after = of_damaged.frames
    lost, new = Counter(before) - Counter(after), Counter(after) - Counter(before)
    # What is shown as another frame, or counted as another record, is no frame that is gone.
    shown = new.total() if kind != "doubled" else 0
    gone = max(0, lost.total() - shown - of_damaged.passed_over)
    new = Counter({frame: count for frame, count in new.items() if frame not in before})
    count = new.total()
    silent = not of_damaged.complaints
    cut = form.open_end and kind == "cut" and after == before[: len(after)]
    # Where what stands before a piece goes on behind it, nothing shows that the piece is gone.
    joined = not form.checksum and kind == "removed"
    if silent and gone and not cut and not joined:
        yield f"lost silently: {gone}, first {next(iter(lost))}"
    if silent and count and (form.checksum or count > most_changed(kind)):
        yield f"changed silently: {count}, first {next(iter(new))}"
    if not of_damaged.doubtful and new.total() > lost.total() + (0 if form.checksum else most_changed(kind) - 1):
        yield f"invented: {new.total() - lost.total()}, {next(iter(new))}{', silently' if silent else ''}"


def most_changed(kind: str) -> int:
    """How many frames one damage may change where there is no checksum: those on both sides of its ends."""
    return {"flip": 1, "cut": 1, "swapped": 4}.get(kind, 2)
