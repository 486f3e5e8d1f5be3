"""`canalyze summary`: figures that equal what a capture holds, and how they are shown."""

from __future__ import annotations

import itertools
import json
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, Row, session_output
from processes import peak_kib
from test_cli_terminal import on_terminal

from canalyze.output.layout import width

PROBLEMS = str(SAMPLES / "problems.log")
STACKS = sorted((SAMPLES / "stacks").glob("*.log"))
STATES = {"00": "boot-up", "04": "stopped", "05": "operational", "7F": "pre-operational"}


def records(text: bytes, lang: str = "en") -> list[Row]:
    output = session_output([text], lang=lang, output_format="summary")
    return [json.loads(line) for line in output.splitlines()]


def of(found: Iterable[Row], kind: str) -> list[Row]:
    return [record for record in found if record["kind"] == f"summary_{kind}"]


def log(frames: Iterable[tuple[float, str]], bus: str = "can0") -> bytes:
    """Frames with their time in ms, as `ID#DATA`."""
    lines = []
    for ms, frame in frames:
        us = 1_700_000_000_000_000 + round(ms * 1000)
        lines.append(f"({us // 1_000_000}.{us % 1_000_000:06d}) {bus} {frame}\n")
    return "".join(lines).encode()


@pytest.mark.parametrize("path", STACKS, ids=lambda path: path.stem)
def test_the_counts_of_real_stacks_are_true(path: Path) -> None:
    truth: Any = json.loads(path.with_suffix(".json").read_text())
    found = records(path.read_bytes())
    nodes = {record["node"]: record for record in of(found, "node")}
    assert of(found, "capture")[0]["frames"] == truth["frames"]
    assert of(found, "capture")[0]["seconds"] == f"{truth['seconds']:.6f}"
    assert sum(bus["services"].get("nmt", 0) for bus in of(found, "bus")) == len(truth["nmt"])
    for key, kind in (("boot_ups", "boot_ups"), ("emcys", "emcy")):
        assert Counter(one["node"] for one in truth[kind]) == Counter({n: r[key] for n, r in nodes.items() if r[key]})
    transfers = Counter((one["node"], one["result"] == "ok") for one in truth["sdo"])
    for number, node in nodes.items():
        shown = [(one["frame"], STATES[one["state"]]) for one in node["states"] if not one["commanded"]]
        assert shown == [(one["line"], one["state"]) for one in truth["state_changes"] if one["node"] == number]
        assert node["sdo"]["ok"] == transfers[number, True]
        assert node["sdo"]["aborted"] == transfers[number, False]
        assert node["sdo"]["transfers"] == node["sdo"]["ok"] + node["sdo"]["aborted"]
    for producer in truth["heartbeat_producers"]:
        assert nodes[producer["node"]]["heartbeats"] == producer["frames"]
    for wanted, sync in itertools.zip_longest(truth["sync"], of(found, "sync")):
        measured = wanted["measured_us"]
        assert sync["frames"] == wanted["count"]
        assert (sync["period"]["min_us"], sync["period"]["max_us"]) == (measured["min"], measured["max"])
        assert sync["period"]["mean_us"] == pytest.approx(measured["mean"], abs=0.06)
    frames = Counter[tuple[int, str]]()
    for one in truth["pdo"]:
        frames[one["node"], one["pdo"]] += one["frames"]
    assert frames == Counter({(pdo["node"], pdo["pdo"]): pdo["frames"] for pdo in of(found, "pdo")})


def test_the_delay_of_a_synchronous_pdo() -> None:
    """It is the time since the last SYNC, for the PDOs whose transmission type the capture shows."""
    path = SAMPLES / "stacks" / "c3-pdo-remap-master-sync.log"
    text = path.read_bytes()
    names = {pdo["cob"]: pdo["pdo"] for pdo in json.loads(path.with_suffix(".json").read_text())["pdo"]}
    sync_us = 0
    delays: dict[str, list[int]] = {}
    for line in text.decode().splitlines():
        stamp, _, frame = line.split()
        now_us = round(float(stamp[9:-1]) * 1_000_000)
        can_id = frame.split("#")[0]
        if can_id == "080":
            sync_us = now_us
        elif can_id in names:
            delays.setdefault(names[can_id], []).append(now_us - sync_us)
    synchronous = [pdo for pdo in of(records(text), "pdo") if pdo["synchronous"]]
    assert len(synchronous) == 2
    for pdo in synchronous:
        own, delay = delays[pdo["pdo"]], pdo["delay"]
        assert (pdo["synchronous"], pdo["before_sync"], delay["count"]) == (len(own), 0, len(own))
        assert (delay["min_us"], delay["max_us"], delay["p99_us"]) == (min(own), max(own), max(own))
        assert delay["mean_us"] == pytest.approx(sum(own) / len(own), abs=0.001)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("columns", [80, 120])
def test_a_terminal_is_not_overrun(tmp_path: Path, lang: str, columns: int) -> None:
    code, shown = on_terminal(tmp_path, "summary", "--bitrate", "1M", PROBLEMS, "--lang", lang, COLUMNS=str(columns))
    assert code == 0
    tables = re.sub("\x1b\\[[0-9;]*m", "", shown.decode()).split("\r\n\r\n")[2:]
    rows = [line for block in tables for line in block.splitlines()[1:]]
    assert rows
    assert max(map(width, rows)) <= columns


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="Linux tells the peak of a process")
def test_memory_is_flat(tmp_path: Path) -> None:
    """Ten times the frames take no more memory."""
    peaks = []
    for frames in (20_000, 200_000):
        path = tmp_path / f"{frames}.log"
        text = log((turn, f"{0x181 + turn % 8:03X}#{turn:016X}") for turn in range(frames))
        path.write_bytes(text)
        peaks.append(peak_kib(tmp_path, "summary", "--bitrate", "1M", str(path)))
    assert peaks[1] - peaks[0] < 6 * 1024, peaks  # in KiB
