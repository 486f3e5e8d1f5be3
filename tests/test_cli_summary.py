"""`canalyze summary`: figures that equal what a capture holds, and how they are shown."""

from __future__ import annotations

import itertools
import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from captures import SAMPLES, Row, session_output
from conftest import Runner
from test_cli_terminal import on_terminal

from canalyze.output.layout import width

STACKS = sorted((SAMPLES / "stacks").glob("*.log"))
STATES = {"00": "boot-up", "04": "stopped", "05": "operational", "7F": "pre-operational"}
CHINESE = re.compile("[\u4e00-\u9fff]")

SPREAD = {"count", "min_us", "mean_us", "max_us", "sigma_us"}
KEYS = {
    "summary_capture": {
        *("kind", "files", "frames", "unstamped", "buses", "first_t", "last_t", "seconds", "backward"),
        *("backward_most_us", "pause_us", "pause_frame", "reordered", "unreadable", "gaps", "dropped", "left_out"),
        *("damages", "bit_rate"),
    },
    "summary_bus": {
        *("kind", "bus", "frames", "rate", "peak_rate_1s", "peak_rate_100ms", "sent_by_host", "remote", "fd"),
        *("fd_switched", "extended", "errors", "gaps", "dropped", "services", "bits", "load", "load_peak_1s"),
        *("load_peak_1s_frame", "load_peak_100ms", "load_peak_100ms_frame", "burst"),
    },
    "summary_sync": {"kind", "bus", "frames", "period", "counted", "counter_min", "counter_max", "counter_jumps"},
    "summary_node": {
        *("kind", "bus", "node", "name", "name_from", "frames", "sent", "tpdo", "rpdo", "tpdo_rate", "rpdo_rate"),
        *(
            "state",
            "state_text",
            "state_name",
            "lost",
            "changes",
            "states",
            "boot_ups",
            "error_control",
            "heartbeats",
            "heartbeat",
            "sdo",
        ),
        *("response", "aborts", "emcys", "emcy"),
    },
    "summary_pdo": {
        *("kind", "bus", "node", "pdo", "id", "ext", "frames", "rate", "interval", "synchronous", "before_sync"),
        "delay",
    },
    "summary_identifier": {
        *("kind", "bus", "id", "ext", "frames", "rate", "interval", "length_min", "length_max"),
    },
    "summary_finding": {
        *("kind", "code", "name", "severity", "message", "count", "first_frame", "first_line", "first_t"),
        *("last_frame", "last_line", "last_t", "buses", "nodes"),
    },
}
INNER = {
    ("summary_bus", "burst"): {"frames", "length_us", "first_frame"},
    ("summary_sync", "period"): SPREAD | {"p99_us"},
    ("summary_node", "states"): {"state", "text", "name", "t", "frame", "commanded"},
    ("summary_node", "heartbeat"): SPREAD,
    ("summary_node", "response"): SPREAD | {"p99_us"},
    ("summary_node", "sdo"): {"transfers", "ok", "aborted", "failed", "incomplete"},
    ("summary_node", "aborts"): {"code", "text", "by", "count", "first_frame", "last_frame"},
    ("summary_node", "emcy"): {"code", "text", "count", "first_frame", "last_frame"},
    ("summary_pdo", "interval"): SPREAD,
    ("summary_pdo", "delay"): SPREAD | {"p99_us"},
    ("summary_identifier", "interval"): SPREAD,
}


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


@pytest.fixture
def capture(tmp_path: Path) -> str:
    """Give the name of a capture of two seconds: SYNC, heartbeat, a PDO, SDO reads, an EMCY."""
    frames: list[tuple[float, str]] = [(0, "705#00"), (1, "000#0105")]
    frames += [(10 + 10 * turn, f"080#{turn % 4 + 1:02X}") for turn in range(200)]
    frames += [(12 + 10 * turn, "185#0102030405060708") for turn in range(200)]
    frames += [(100 * turn + 5, "705#05") for turn in range(1, 20)]
    frames += [(55, "605#4008100000000000"), (57, "585#4308100044524956")]
    frames += [(1000, "085#1042090000000000"), (1500, "605#4000300000000000"), (1504, "585#8000300000000206")]
    (tmp_path / "capture.log").write_bytes(log(sorted(frames)))
    return "capture.log"


def jsonl(canalyze: Runner, *args: str) -> list[Row]:
    done = canalyze("summary", "--format", "jsonl", "--lang", "en", *args)
    assert (done.code, done.err) == (0, "")
    return [json.loads(line) for line in done.lines]


def test_the_figures_of_a_capture(canalyze: Runner, capture: str) -> None:
    found = jsonl(canalyze, "--bitrate", "125k", capture)
    (whole,), (bus,), (node,) = of(found, "capture"), of(found, "bus"), of(found, "node")
    (sync,), (pdo,) = of(found, "sync"), of(found, "pdo")
    assert (whole["frames"], whole["files"], whole["seconds"], whole["backward"]) == (426, 1, "2.002000", 0)
    assert bus["services"] == {"nmt": 1, "sync": 200, "emcy": 1, "pdo": 200, "sdo": 4, "heartbeat": 20}
    assert bus["rate"] == pytest.approx(425 / 2.002, abs=0.001)
    assert bus["load"] == pytest.approx((bus["bits"] - 57) / 2.002 / 125_000 * 100, abs=0.03)
    assert bus["load_peak_1s"] >= bus["load"] - 0.1
    assert (sync["frames"], sync["counter_min"], sync["counter_max"], sync["counter_jumps"]) == (200, 1, 4, 0)
    assert sync["period"] == {
        "count": 199,
        "min_us": 10000,
        "mean_us": 10000,
        "max_us": 10000,
        "sigma_us": 0,
        "p99_us": 10000,
    }
    assert (pdo["pdo"], pdo["id"], pdo["frames"], pdo["interval"]["mean_us"]) == ("TPDO1", "185", 200, 10000)
    assert node["heartbeat"] == {
        "count": 18,
        "min_us": 100000,
        "mean_us": 100000,
        "max_us": 100000,
        "sigma_us": 0,
    }
    assert (node["boot_ups"], node["state"], node["state_text"]) == (1, "05", "Operational")
    assert (node["name"], node["name_from"]) == ("DRIV", "1008")
    assert node["sdo"] == {"transfers": 2, "ok": 1, "aborted": 1, "failed": 0, "incomplete": 0}
    assert (node["response"]["min_us"], node["response"]["mean_us"], node["response"]["max_us"]) == (2000, 3000, 4000)
    assert [(one["code"], one["by"], one["count"]) for one in node["aborts"]] == [("06020000", "server", 1)]
    assert [(one["code"], one["count"], one["first_frame"] > 0) for one in node["emcy"]] == [("4210", 1, True)]


def test_keys_are_those_that_are_documented(canalyze: Runner, capture: str) -> None:
    found = jsonl(canalyze, "--bitrate", "500000", capture)
    for path in [*STACKS, SAMPLES / "services.log", SAMPLES / "rules/BUS009.log"]:
        found += records(path.read_bytes())
    assert {record["kind"] for record in found} == set(KEYS)
    inner = set()
    for record in found:
        assert set(record) == KEYS[record["kind"]], record
        for key, value in record.items():
            wanted = INNER.get((record["kind"], key))
            for one in value if isinstance(value, list) else [value]:
                if wanted is not None and one is not None:
                    assert set(one) == wanted, (record["kind"], key)
                    inner.add((record["kind"], key))
    assert inner >= set(INNER) - {("summary_pdo", "delay")}
    source = Path(__file__).parent.parent / "canalyze/core/src/tables/jsonl/summary.rs"
    declared = source.read_text()
    for keys in (*KEYS.values(), *INNER.values()):
        for key in keys:
            assert f'"{key}": ' in declared, key


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


def test_names_come_from_descriptions_first(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    eds = SAMPLES.parent / "eds" / "drive.eds"
    (node,) = of(jsonl(canalyze, "--eds", f"5={eds}", capture), "node")
    assert node["name_from"] == "description"
    assert node["name"] in eds.read_text()


def test_several_files_are_one_capture(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    lines = (tmp_path / capture).read_text().splitlines(keepends=True)
    (tmp_path / "a.log").write_text("".join(lines[:200]))
    (tmp_path / "b.log").write_text("".join(lines[200:]))
    one, two = jsonl(canalyze, capture), jsonl(canalyze, "a.log", "b.log")
    assert of(two, "capture")[0]["files"] == 2
    for kind in ("bus", "sync", "node", "pdo"):
        assert of(one, kind) == of(two, kind)


def test_standard_input_and_filter(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    text = (tmp_path / capture).read_bytes()
    done = canalyze("summary", "--format", "jsonl", "--filter", "service=sync", "-", stdin=text)
    found = [json.loads(line) for line in done.lines]
    assert of(found, "bus")[0]["services"] == {"sync": 200}
    assert of(found, "node") == []
    nothing = canalyze("summary", "--filter", "node=9", capture)
    assert (nothing.code, nothing.out, len(nothing.complaints)) == (0, "", 1)


def test_without_stamps() -> None:
    found = records((SAMPLES / "zephyr-sdo.log").read_bytes())
    (capture,), (bus,), (node,) = of(found, "capture"), of(found, "bus"), of(found, "node")
    assert (capture["unstamped"], capture["seconds"], capture["first_t"]) == (capture["frames"], None, None)
    assert (bus["rate"], bus["load"], bus["burst"], node["response"]) == (None, None, None, None)
    assert (node["name"], node["sdo"]["ok"], capture["reordered"]) == ("Zephyr RTOS/CANopenNode", 1, 2)


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_quality_is_said(canalyze: Runner, tmp_path: Path, lang: str) -> None:
    (tmp_path / "bad.log").write_text(
        "(10.000000) can0 080#\nnonsense\n(10.010000) can0 080#\n DROPCOUNT: dropped 3 CAN frames on 'can0' socket"
        " (total drops 3)\n(9.000000) can0 080#\n"
    )
    done = canalyze("summary", "--lang", lang, "bad.log")
    said = done.out.split("\n\n")[0]
    wanted = {
        "zh": ["报告1次，共3帧", "1行无法读取", "时间戳倒退：1次，最多 1010.0 ms"],
        "en": ["3 frames dropped, in 1 report", "1 unreadable line", "going back: 1 time, by up to 1010.0 ms"],
    }
    for part in wanted[lang]:
        assert part in said
    assert "CAP001" in done.out and "CAP002" in done.out


@pytest.mark.parametrize("lang", ["zh", "en"])
def test_tables_are_aligned_and_in_one_language(canalyze: Runner, capture: str, lang: str) -> None:
    done = canalyze("summary", "--lang", lang, "--bitrate", "500k", capture, str(SAMPLES / "services.log"))
    assert done.code == 0
    blocks = done.out.split("\n\n")
    assert len(blocks) >= 8
    if lang == "en":
        assert not CHINESE.search(done.out)
    services = next(block for block in blocks if "heartbeat" in block and "%" in block and "sync" in block)
    assert len({width(line) for line in services.splitlines()[2:]}) == 1


def test_no_bit_rate_says_how(canalyze: Runner, capture: str) -> None:
    assert "--bitrate" in canalyze("summary", capture).out
    assert "--bitrate" not in canalyze("summary", "--bitrate", "1M", capture).out
    assert canalyze("summary", "--bitrate", "fast", capture).code == 2


def test_bit_rate_of_the_configuration(canalyze: Runner, capture: str, tmp_path: Path) -> None:
    (tmp_path / "canalyze.toml").write_text("bitrate = 250000\n")
    assert of(jsonl(canalyze, capture), "capture")[0]["bit_rate"] == 250_000


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("columns", [80, 120])
def test_a_terminal_is_not_overrun(capture: str, tmp_path: Path, lang: str, columns: int) -> None:
    code, shown = on_terminal(tmp_path, "summary", "--bitrate", "1M", capture, "--lang", lang, COLUMNS=str(columns))
    assert code == 0
    tables = re.sub("\x1b\\[[0-9;]*m", "", shown.decode()).split("\r\n\r\n")[2:]
    rows = [line for block in tables for line in block.splitlines()[1:]]
    assert rows
    assert max(map(width, rows)) <= columns


def many_nodes() -> Iterator[tuple[float, str]]:
    for node in range(1, 128):
        yield node, f"{0x700 + node:03X}#00"
        yield 200 + node, f"{0x700 + node:03X}#7F"
    for node in range(1, 128):
        yield 400 + node, f"{0x700 + node:03X}#7F"


def test_a_full_network_is_one_line_a_node(canalyze: Runner, tmp_path: Path) -> None:
    frames = list(many_nodes()) + [(600 + node, f"{0x600 + node:03X}#4000100000000000") for node in (3, 4, 5)]
    (tmp_path / "full.log").write_bytes(log(frames))
    done = canalyze("summary", "--lang", "en", "full.log")
    nodes = next(block for block in done.out.split("\n\n") if block.startswith("Nodes"))
    assert len(nodes.splitlines()) == 2 + 127


def test_nodes_that_are_only_addressed_share_a_line(canalyze: Runner, tmp_path: Path) -> None:
    frames = [(float(node), f"{0x600 + node:03X}#4000100000000000") for node in range(1, 128)]
    (tmp_path / "scan.log").write_bytes(log([*frames, (200, "589#4F00100005000000")]))
    done = canalyze("summary", "--lang", "en", "scan.log")
    assert "can0: addressed but never seen sending: 1-8,10-127" in done.lines


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="Linux tells the peak of a process")
def test_memory_is_flat(tmp_path: Path) -> None:
    """Ten times the frames take no more memory."""
    peaks = []
    for frames in (20_000, 200_000):
        path = tmp_path / f"{frames}.log"
        text = log((turn, f"{0x181 + turn % 8:03X}#{turn:016X}") for turn in range(frames))
        path.write_bytes(text)
        code = (
            "import sys; from canalyze.cli import main; code = main(sys.argv[1:]);"
            "peak = next(line for line in open('/proc/self/status') if line.startswith('VmHWM'));"
            "sys.stderr.write(peak.split()[1]); raise SystemExit(code)"
        )
        arguments = [sys.executable, "-c", code, "summary", "--bitrate", "1M", str(path)]
        done = subprocess.run(arguments, capture_output=True, check=True, cwd=tmp_path)
        peaks.append(int(done.stderr))
    assert peaks[1] - peaks[0] < 6 * 1024, peaks  # in KiB
