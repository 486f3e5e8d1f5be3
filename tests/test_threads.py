"""Threads that share the work on one file: what comes out is the same, and so is what is known after.

The captures are the samples, each repeated until it is worth threads: stamps that go back, transfers that are cut,
names of buses that come late, lines that cannot be read.
"""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from conftest import Runner

from canalyze._core import Session, sniff
from canalyze.running.reading import SessionOptions

SAMPLES = Path(__file__).parent.parent / "samples"
PIECE = 40 << 10
"""Bytes that are fed at once: above what is worth threads."""
LENGTH = 3 * PIECE
LOGS = sorted(path for path in SAMPLES.rglob("*.log") if "rules" not in path.parts)[::4]
FORMS: dict[str, dict[str, Any]] = {
    "text": {"lang": "en"},
    "brief": {"depth": "brief"},
    "explain": {"depth": "explain", "coloured": True, "numbered": True},
    "since the frame before": {"time": "d"},
    "filter": {"filter": "service=sdo", "format": "jsonl"},
    "words": {"filter": "text=SYNC", "lang": "en"},
    "no more than": {"limit": 700, "format": "jsonl"},
    "jsonl": {"format": "jsonl"},
    "events": {"format": "events", "incidents": True},
    "incidents": {"incidents": True},
    "lines": {"format": "lines"},
    "signals": {"format": "signals"},
    "signals-csv": {"format": "signals-csv"},
    "transfers": {"format": "transfers", "extract": True},
    "check": {"format": "check", "incidents": True},
    "summary": {"format": "summary"},
    "diagnosis": {"format": "diagnosis"},
    "info": {"format": "info"},
    "asc": {"format": "convert", "to": "asc"},
    "pcapng": {"format": "convert", "to": "pcapng"},
    "mcap": {"format": "convert", "to": "mcap", "decoded": True},
    "tables": {"format": "text", "tables": ("listing", "pdo")},
}


@cache
def long(path: Path) -> bytes:
    """The bytes of a sample, often enough."""
    once = path.read_bytes()
    return once * (LENGTH // len(once) + 1)


def all_of(data: bytes, threads: int, piece: int = PIECE, form: str = "candump", **settings: Any) -> dict[str, Any]:
    """All that a session gives of a file."""
    session = Session(SessionOptions(threads=threads, **settings))
    session.begin("a.log", True, form)
    out, complaints, done = [], [], False
    for at in range(0, len(data), piece):
        out.append(session.feed(data[at : at + piece]))
        complaints += session.complaints()
        done = done or session.done
    out += [session.end(), session.finish()]
    complaints += session.complaints()
    return {
        "out": b"".join(out),
        "complaints": complaints,
        "done": done,
        "frames": session.frames,
        "tally": json.loads(session.tally()),
        "nodes": json.loads(session.nodes()),
        "pieces": session.extracted(),
        "batches": [
            (name, [batch.column(column) for column in batch.column_names]) for name, batch in session.batches(True)
        ],
        "losses": session.losses("a.log"),
    }


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("path", LOGS, ids=lambda path: path.name)
def test_the_same_comes_out(path: Path, form: str) -> None:
    data = long(path)
    alone = all_of(data, 1, **FORMS[form])
    assert alone["frames"] > 0
    for threads in (2, 5):
        shared = all_of(data, threads, **FORMS[form])
        assert shared == alone, f"{threads} threads"


def buses(count: int) -> bytes:
    """A capture in which a further bus appears every few frames, also beyond those that are kept apart."""
    lines = (f"({i / 1000:017.6f}) can{min(i // 40, count)} {0x181 + i % 4:03X}#{i % 256:02X}" for i in range(4000))
    return "\n".join(lines).encode()


def damaged() -> bytes:
    """Lines that cannot be read, some of them long, and the marks of a capturing program."""
    whole = long(SAMPLES / "zephyr-sdo.log").splitlines()
    for at in range(0, len(whole), 37):
        whole[at] = whole[at][: len(whole[at]) // 2]
    for at in range(5, len(whole), 501):
        whole[at] = b"DROPCOUNT: dropped 3 CAN frames on 'can1' socket (total drops 3)"
    whole[100] = b"x" * (PIECE // 2)
    return b"\n".join(whole)


@pytest.mark.parametrize("make", [lambda: buses(3), lambda: buses(90), damaged, lambda: b"nothing\n" * 20000])
@pytest.mark.parametrize("piece", [PIECE, 100_000, 1 << 20])
@pytest.mark.parametrize("form", ["jsonl", "text", "asc", "check", "info"])
def test_odd_captures_too(make: Callable[[], bytes], piece: int, form: str) -> None:
    data = make()
    alone = all_of(data, 1, piece, **FORMS[form])
    assert all_of(data, 4, piece, **FORMS[form]) == alone
    # However it is cut, as without threads.
    assert all_of(data, 2, 1 << 20, **FORMS[form])["out"] == alone["out"]


@pytest.mark.parametrize("suffix", ["asc", "pcapng", "mcap"])
def test_of_every_format(suffix: str) -> None:
    log = long(SAMPLES / "network" / "drive-states.log")
    file = all_of(log, 1, format="convert", to={"asc": "asc", "pcapng": "pcapng", "mcap": "mcap"}[suffix])["out"]
    assert sniff(file[:4096], True) in (suffix, "pcap")
    alone = all_of(file, 1, form=suffix, format="jsonl")
    assert alone["frames"] > 1000
    assert all_of(file, 3, form=suffix, format="jsonl") == alone


def test_the_option(canalyze: Runner) -> None:
    path = str(SAMPLES / "zephyr-sdo.log")
    alone = canalyze("decode", "--threads", "1", path)
    assert (alone.code, alone.err) == (0, "")
    assert alone.out == canalyze("decode", "--threads", "3", path).out == canalyze("decode", path).out
    refused = canalyze("decode", "--threads", "0", "--lang", "en", path)
    assert refused.code == 2
    assert "--threads 0: expected a whole number above 0" in refused.err
