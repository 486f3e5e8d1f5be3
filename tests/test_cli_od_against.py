"""`canalyze od against`: which device is compared, what is printed, and how it ends.

What differs and what does not is in `test_od_against.py`.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from captures import EDS, SAMPLES
from conftest import Runner

LOG = str(SAMPLES / "od/other-firmware.log")
NETWORK = str(SAMPLES / "network/sync-and-pdos.log")
DRIVE = str(EDS / "drive.eds")
KEYS = {
    "od_difference": {
        *("kind", "bus", "node", "file", "what", "severity", "index", "sub", "name", "described", "shown", "text"),
        "frame",
    },
    "od_against": {"kind", "bus", "node", "file", "error", "warning", "info", "objects", "seen", "unseen"},
}
"""The keys of the machine output, frozen: keys may be added here, none may be renamed or go."""
TOLD = [
    ("absent", "60F4", 0),
    ("size", "6083", 0),
    ("revision", "1018", 3),
    ("not-writable", "607F", 0),
    ("mapping", "1A00", None),
    ("limits", "6060", 0),
    ("unlisted", "2003", 0),
    ("default", "1017", 0),
    ("default", "100A", 0),
]


def test_the_differences_in_json(canalyze: Runner) -> None:
    outputs = {}
    for lang in ("en", "zh"):
        done = canalyze("--lang", lang, "od", LOG, "--against", DRIVE, "--format", "jsonl")
        assert (done.code, done.err) == (1, "")
        outputs[lang] = [json.loads(line) for line in done.lines]
    *rows, last = outputs["en"]
    assert {(one["what"], one["index"], one["sub"]) for one in rows} == set(TOLD) and len(rows) == len(TOLD)
    assert all(one.keys() == KEYS["od_difference"] for one in rows) and last.keys() == KEYS["od_against"]
    assert (last["error"], last["warning"], last["info"]) == (2, 5, 2)
    assert last["objects"] == last["seen"] + last["unseen"] and last["seen"] == 15
    texts = [[one.pop("text", None) for one in rows] for rows in outputs.values()]
    assert outputs["en"] == outputs["zh"] and texts[0] != texts[1]
    for one in rows:
        frame = Path(LOG).read_text().splitlines()[one["frame"] - 1]
        assert frame.split()[2][:3] in ("585", "185"), "the frame is one of the device"


def test_the_table(canalyze: Runner) -> None:
    done = canalyze("--lang", "en", "od", LOG, "--against", DRIVE)
    assert done.code == 1
    assert done.lines[0] == "node 5 against drive.eds: 2 errors, 5 warnings, 2 notes"
    assert done.lines[-1] == "187 objects in the description: 15 seen, 172 never seen"
    assert len(done.lines) == len(TOLD) + 3
    unseen = canalyze("--lang", "en", "od", LOG, "--against", DRIVE, "--unseen")
    assert sum("never seen" in line for line in unseen.lines) == 172 + 1
    done = canalyze("--lang", "zh", "od", NETWORK, "--against", DRIVE, "--node", "5")
    assert (done.code, done.lines[0]) == (0, "节点5与drive.eds比较：没有差异")


def test_notes_alone_do_not_fail(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text(
        "(1.0) can0 705#00\n(1.1) can0 605#4017100000000000\n(1.2) can0 585#4B171000F4010000\n"
    )
    done = canalyze("--lang", "en", "od", "a.log", "--against", DRIVE)
    assert (done.code, done.lines[0]) == (0, "node 5 against drive.eds: 1 note")


def test_which_device(canalyze: Runner, tmp_path: Path) -> None:
    done = canalyze("--lang", "en", "od", NETWORK, "--against", DRIVE)
    assert (done.code, done.out) == (2, "")
    assert done.complaints[-1].endswith("drive.eds: the capture shows several nodes (5, 6, 7); choose one with --node")
    done = canalyze("--lang", "en", "od", NETWORK, "--against", DRIVE, "--node", "9")
    assert (done.code, done.complaints[-1][-44:]) == (2, "drive.eds: no objects of node 9 in the capture"[-44:])
    done = canalyze("--lang", "en", "od", LOG, "--against", DRIVE, "--filter", "service=nmt")
    assert done.code == 2 and done.complaints[-1].endswith("drive.eds: no objects in the capture to compare")
    dcf = (EDS / "drive.eds").read_text() + "\n[DeviceComissioning]\nNodeID=5\n"
    (tmp_path / "own.dcf").write_text(dcf)
    done = canalyze("--lang", "en", "od", NETWORK, "--against", "own.dcf")
    assert (done.code, done.lines[0]) == (0, "node 5 against own.dcf: no difference")
    done = canalyze("--lang", "en", "od", NETWORK, "--against", "own.dcf", "--node", "6")
    assert done.code == 1 and done.lines[0].startswith("node 6 against own.dcf")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (["--against", DRIVE, "--history"], "--history"),
        (["--against", DRIVE, "--format", "csv"], "csv"),
        (["--against", DRIVE, "--dcf", "a.dcf", "--node", "5"], "--dcf"),
        (["--unseen"], "--unseen"),
        (["--against", "missing.eds"], "missing.eds"),
        (["--against", LOG], "other-firmware.log"),
    ],
)
def test_what_cannot_be_is_said(canalyze: Runner, line: list[str], said: str) -> None:
    done = canalyze("--lang", "en", "od", LOG, *line)
    assert (done.code, done.out) == (2, "")
    assert said in done.complaints[-1] and "Traceback" not in done.err
