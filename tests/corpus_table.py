"""What the program says of each capture that other people published, as one table: tests/corpus.md.

    python tests/corpus_table.py

Read its difference line by line against the known answers before it is kept: a line that is false is a defect. It holds
names of files and counts, and nothing of what is in the files. What it must not do: judge.
"""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from capture_frames import Reading, read, run
from captures import SHARED, TESTS

CORPUS = SHARED / "corpus"
TABLE = TESTS / "corpus.md"
FOLDERS = ("asc", "blf", "mcap", "transcripts", "trc")
OTHER = {".json", ".md"}
"""Ends of the names of files that are no captures."""
HEAD = """\
# What is said of captures that other people published

One row a file, as `python tests/corpus_table.py` writes it; test_stacks.py holds it against the program where the
files are at hand. *Is* is what `check` takes the capture for; *nodes* are those of the services that belong to a node;
*transfers* are those of `sdo` by status; *findings* are all of them, with their counts.

| file | frames | is | services | nodes | transfers | findings | not read |
|---|---|---|---|---|---|---|---|
"""
PROPER = {"emcy", "heartbeat", "guarding", "pdo", "sdo", "lss"}
"""Services of one node."""


def captures() -> list[Path]:
    """The captures of the corpus."""
    files = (path for folder in FOLDERS for path in (CORPUS / folder).glob("*"))
    return sorted((path for path in files if path.suffix not in OTHER), key=lambda path: (path.parent.name, path.name))


def table(scratch: Path) -> str:
    """The page."""
    return HEAD + "".join(f"| {' | '.join(row(path, scratch))} |\n" for path in captures())


def row(path: Path, scratch: Path) -> Iterator[str]:
    """What is said of one file."""
    reading = read(path, output=scratch / "said.jsonl")
    frames = reading.said.frames
    yield f"{path.parent.name}/{path.name}"
    yield str(len(frames))
    yield nature(path, scratch) if frames else "-"
    yield counted(one["service"] for one in frames)
    nodes = {one["node"] for one in frames if one["service"] in PROPER and one["node"]}
    yield ", ".join(map(str, sorted(nodes))) or "-"
    yield counted(one["status"] for one in reading.said.transfers)
    yield counted(f"{one['code']} {one['severity']}" for one in reading.said.findings)
    yield unread(reading)


def nature(path: Path, scratch: Path) -> str:
    """What `check` takes it for."""
    out = run(["check", path, "--format", "jsonl", "--fail-on", "never"], scratch / "check.jsonl").out
    return str(json.loads(out.splitlines()[-1])["nature"])


def unread(reading: Reading) -> str:
    """How many complaints there are about what is not read."""
    return f"{len(reading.complaints.splitlines())}, exit code {reading.code}" if reading.complaints else "-"


def counted(names: Iterable[str]) -> str:
    """Names with their counts."""
    return ", ".join(f"{name} {count}" for name, count in sorted(Counter(names).items())) or "-"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        TABLE.write_text(table(Path(folder)), encoding="utf-8")
