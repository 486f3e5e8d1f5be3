"""Frames as any capture format may hold them, and how the program's command line reads a file of them.

Why it exists: the suites compare files of a dozen formats, and each comparison needs the same frame and the same
reading: `canalyze decode FILE --format jsonl`, as a user types it, run in this process. What it must not do: know how
a format is written.
"""

from __future__ import annotations

import contextlib
import faulthandler
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Literal

from captures import Analysis, Row, sort_rows

from canalyze.cli import main

PATIENCE_S = 120.0
"""Longest that one run may take; longer is a hang, and ends the tests with a traceback of where it is."""

Kind = Literal["data", "remote", "fd", "error"]


@dataclass(frozen=True, slots=True)
class Recorded:
    """One frame of a capture."""

    t_ns: int
    """Since 1970-01-01, or since the capture's start."""
    bus: str
    can_id: int
    """The identifier; of an error frame the class bits, without the flag."""
    data: bytes = b""
    kind: Kind = "data"
    extended: bool = False
    asked: int = 0
    """The length that a remote frame asks for."""
    brs: bool = False
    esi: bool = False
    sent: bool | None = False
    """Sent by the capturing host; None where that is not known."""

    def log_line(self, decimals: int = 6) -> str:
        """The frame as `candump -l -x` writes it, its stamp with so many digits (6 or 9) behind the point."""
        seconds, rest = divmod(self.t_ns, 1_000_000_000)
        digits = f"{rest:09d}"[:decimals]
        wide = self.extended or self.kind == "error"
        can_id = self.can_id | (0x2000_0000 if self.kind == "error" else 0)
        shown = {
            "data": self.data.hex().upper(),
            "error": self.data.hex().upper(),
            "remote": f"R{self.asked or ''}",
            "fd": f"#{self.brs | self.esi << 1:X}{self.data.hex().upper()}",
        }[self.kind]
        side = {None: "", False: " R", True: " T"}[self.sent]
        return f"({seconds}.{digits}) {self.bus} {f'{can_id:08X}' if wide else f'{can_id:03X}'}#{shown}{side}\n"


def candump_text(frames: Iterable[Recorded]) -> bytes:
    """A capture in candump's log form, in ns where one stamp needs them."""
    frames = list(frames)
    decimals = 9 if any(frame.t_ns % 1000 for frame in frames) else 6
    return "".join(frame.log_line(decimals) for frame in frames).encode()


@dataclass(slots=True)
class Reading:
    """What one run of `canalyze decode --format jsonl` left behind."""

    code: int
    said: Analysis
    complaints: str

    @property
    def frames(self) -> list[Recorded]:
        """The frames in the order in which they were said."""
        return [recorded(row) for row in self.said.frames]

    @property
    def meanings(self) -> list[tuple[str, list[str]]]:
        """What is said on each frame: the phrase, and the codes of its findings."""
        return [(row["text"], row["findings"]) for row in self.said.frames]


def recorded(row: Row) -> Recorded:
    """A frame row of the program's JSON lines."""
    kind: Kind = "error" if row["err"] else "remote" if row["rtr"] else "fd" if row["fd"] else "data"
    flags = row["fd"] or {"brs": False, "esi": False}
    return Recorded(
        t_ns=int(Decimal(row["t"]) * 1_000_000_000) if row["t"] is not None else 0,
        bus=row["bus"],
        can_id=int(row["id"], 16),
        data=bytes.fromhex(row["data"]),
        kind=kind,
        extended=row["ext"],
        asked=row["len"] if kind == "remote" else 0,
        brs=flags["brs"],
        esi=flags["esi"],
        sent={None: None, "rx": False, "tx": True}[row["dir"]],
    )


@dataclass(frozen=True, slots=True)
class Ran:
    """What one command line left behind."""

    code: int
    out: bytes
    complaints: str


def run(arguments: Sequence[str | Path], output: Path | None = None) -> Ran:
    """One command line in English, in this process. `output` is where its -o goes; an exception is the test's end."""
    errors = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
    line = ["--lang", "en", *map(str, arguments), *(["-o", str(output), "--force"] if output else [])]
    faulthandler.dump_traceback_later(PATIENCE_S, exit=True)
    try:
        with contextlib.redirect_stderr(errors):
            code = main(line)
    finally:
        faulthandler.cancel_dump_traceback_later()
    complaints = errors.buffer.getvalue().decode()
    assert "Traceback" not in complaints, complaints
    return Ran(code, output.read_bytes() if output and output.exists() else b"", complaints)


def read(*paths: Path, options: Sequence[str] = (), output: Path | None = None) -> Reading:
    """What `canalyze decode --format jsonl` says about the files; it is put beside the first one, or where told."""
    output = output or paths[0].with_name(f"{paths[0].name}.said")
    output.unlink(missing_ok=True)
    ran = run(["decode", *paths, "--format", "jsonl", *options], output)
    return Reading(ran.code, sort_rows(ran.out), ran.complaints)


def decoded_text(path: Path) -> bytes:
    """What `canalyze decode` says about a file, for people."""
    return run(["decode", path], path.with_name(f"{path.name}.txt")).out


def transfers(path: Path) -> list[Row]:
    """The rows of `canalyze sdo --format jsonl`."""
    out = run(["sdo", path, "--format", "jsonl"], path.with_name(f"{path.name}.sdo")).out
    return [json.loads(line) for line in out.splitlines()]


def annotated(text: bytes) -> list[str]:
    """What stands behind the # of each line."""
    return [line.partition("#")[2].strip() for line in text.decode().splitlines()]


def without(rows: Iterable[Row], *keys: str) -> list[Row]:
    """Rows without what differs from format to format."""
    return [{key: value for key, value in row.items() if key not in keys} for row in rows]


def from_start(frames: Iterable[Recorded]) -> Iterator[Recorded]:
    """The same with stamps counted from the first frame's."""
    start = None
    for frame in frames:
        start = frame.t_ns if start is None else start
        yield replace(frame, t_ns=frame.t_ns - start)


def read_candump(text: bytes, scratch: Path) -> Reading:
    """What the program says about candump text."""
    path = scratch / "reference.log"
    path.write_bytes(text)
    return read(path)
