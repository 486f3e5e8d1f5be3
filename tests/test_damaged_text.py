"""Text captures with zeroed blocks, changed bytes and cut ends: nothing is lost, and no frame made, without a word.

The same figures for each form: of frames that are gone something is said, frames that come out were there, and
`info`, `summary`, `check` and the exit code agree.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from captures import SAMPLES
from conftest import Runner

from canalyze.cli import main

SOURCE = SAMPLES / "services.log"
FORMS = {"candump": "log", "console": "txt", "asc": "asc", "trc": "trc", "csv": "csv"}
ROWS = 60
"""Frames of each seed."""
TRIES = 120


def _log(directed: bool) -> bytes:
    lines = [line for line in SOURCE.read_bytes().splitlines(keepends=True) if line.startswith(b"(")][:ROWS]
    return b"".join(line.replace(b"\n", b" R\n") if directed else line for line in lines)


@pytest.fixture(scope="module")
def seeds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A small capture in each form."""
    folder = tmp_path_factory.mktemp("seeds")
    log = folder / "seed.log"
    log.write_bytes(_log(directed=True))
    made = {"candump": log.read_bytes(), "candump-undirected": _log(directed=False)}
    for form, ending in FORMS.items():
        if form != "candump":
            path = folder / f"seed.{ending}"
            assert main(["convert", "--to", form, str(log), str(path)]) == 0
            made[form] = path.read_bytes()
    return made


def _zeroed(data: bytes, source: random.Random) -> bytes:
    at = source.randrange(len(data))
    return data[:at] + bytes(len(data[at : at + 512])) + data[at + 512 :]


def _flipped(data: bytes, source: random.Random) -> bytes:
    at = source.randrange(len(data))
    return data[:at] + bytes([data[at] ^ source.randrange(1, 256)]) + data[at + 1 :]


def _cut(data: bytes, source: random.Random) -> bytes:
    return data[: source.randrange(len(data))]


class Read:
    """What `info` and `convert` say of bytes."""

    def __init__(self, capfd: pytest.CaptureFixture[str], path: Path, data: bytes) -> None:
        """Have both read them."""
        path.write_bytes(data)
        main(["info", "--format", "jsonl", "--lang", "en", str(path)])
        said = capfd.readouterr()
        # Of what is no capture any more there is a line on standard error, and no figures.
        figures = json.loads((said.out or '{"kind": "refused"}').splitlines()[0])
        assert said.out or said.err or not data
        self.frames: int = figures.get("frames") or 0
        self.said = bool(
            figures.get("unreadable") or figures.get("damages") or figures.get("left_out") or figures["kind"] != "info"
        )
        main(["convert", "--to", "console", "--lang", "en", str(path), "-"])
        self.lines = [line.strip() for line in capfd.readouterr().out.splitlines()]


@pytest.mark.parametrize("damage", [_zeroed, _flipped, _cut])
@pytest.mark.parametrize("form", ["candump", "candump-undirected", "console", "asc", "trc", "csv"])
def test_no_frame_is_lost_or_made_in_silence(
    seeds: dict[str, bytes],
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
    form: str,
    damage: Callable[[bytes, random.Random], bytes],
) -> None:
    """A frame that is gone was told; the frames in front of a cut are those that were there."""
    data, source = seeds[form], random.Random(f"{form} {damage.__name__}")
    path = tmp_path / f"damaged.{FORMS[form.partition('-')[0]]}"
    whole = Read(capfd, path, data)
    assert (whole.frames, whole.said) == (ROWS, False)
    for _ in range(TRIES):
        damaged = damage(data, source)
        read = Read(capfd, path, damaged)
        if damage is _cut:
            assert read.lines == whole.lines[: len(read.lines)], damaged[-80:]
        else:
            assert read.frames >= ROWS or read.said, damaged


@pytest.mark.parametrize(
    ("before", "line", "whole"),
    [
        ("(1.500000) can0 185#0000000000000000", "(1.600000) can0 185#0000000000", False),
        ("(1.500000) can0 185#0000000000000000", "(1.600000) can0 185#0000000000000001", True),
        ("(1.500000) can0 705#05", "(1.600000) can0 705#05", True),
        ("(1.500000)  can0  705   [1]  05", "(1.600000)  can0  185   [2]  05 00", True),
        ("(1.500000)  can0  705   [1]  05", "(1.600000)  can0  185   [2]  05", False),
    ],
)
@pytest.mark.parametrize("way", ["file", "pipe"])
def test_a_last_line_without_end_is_told_alike(
    canalyze: Runner, tmp_path: Path, before: str, line: str, whole: bool, way: str
) -> None:
    """It is doubtful where it may have been longer: once, in every command; a whole one says nothing."""
    text = f"{before}\n{line}".encode()
    path = tmp_path / "cut.log"
    path.write_bytes(text)
    name, stdin = (str(path), None) if way == "file" else ("-", text)

    def said(*arguments: str) -> tuple[int, str, str]:
        done = canalyze(*arguments, name, "--lang", "en", stdin=stdin)
        return done.code, done.out, done.err

    _, figures, _ = said("info", "--format", "jsonl")
    info = json.loads(figures)
    assert (info["frames"], bool(info["unreadable"])) == ((2, False) if whole else (1, True))
    _, summary, _ = said("summary")
    assert ("CAP001" in summary) is not whole
    code, _, told = said("check")
    assert (code, told.count("truncated")) == ((0, 0) if whole else (1, 1))


@pytest.mark.parametrize(
    "line", ["      2      1.600 DX  1     0185 Rx -  1    05", "      2      1.600 DT  1  0185\0"]
)
def test_a_row_of_a_type_that_peak_has_not_is_damage(canalyze: Runner, tmp_path: Path, line: str) -> None:
    """It is no kind of row that is passed over; status rows are."""
    head = ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n      1      1.500 DT  1     0185 Rx -  1    05\n"
    path = tmp_path / "rows.trc"
    path.write_text(f"{head}{line}\n      3      1.700 ST  1        - Rx -  4    00 00 00 08\n")
    done = canalyze("info", "--format", "jsonl", "--lang", "en", str(path))
    info = json.loads(done.out)
    assert (info["frames"], info["unreadable"]["count"]) == (1, 1)
    assert [tuple(kind.values())[-1] for kind in info["contents"]["passed_over"]] == [1]
