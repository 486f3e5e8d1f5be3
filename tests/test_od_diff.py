"""`canalyze od diff`: what differs in the configuration of devices is reported, and nothing that changes by nature.

Captures are those of made networks and real stacks, with one value changed where a difference is wanted. Must not:
take a difference from the program that is not put in here.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from captures import EDS, SAMPLES, SHARED, CanFrame, eds_options, log_text, read_log, spaced
from conftest import Runner
from sdo_wire import Channel, expedited_download, expedited_upload, segmented_upload
from test_od_dcf import EVERY, SESSIONS, written

from canalyze.dictionary import load
from canalyze.dictionary.difference import compare, standard_nature
from canalyze.dictionary.files import concise
from canalyze.dictionary.model import Dictionary

NETWORK = SAMPLES / "network/sync-and-pdos.log"
Rows = list[dict[str, Any]]


def told(canalyze: Runner, *args: str | Path) -> tuple[int, Rows, dict[str, Any]]:
    """Exit code, the rows that count, and the summary, whose counts are those of the rows."""
    done = canalyze("--lang", "zh", "od", "--format", "jsonl", *map(str, args))
    assert all("canalyze eds" in line for line in done.complaints), done.err  # what is odd about a description
    *rows, last = map(json.loads, done.lines)
    counting = [row for row in rows if row.get("reason") is None]
    assert (last["kind"], last["differences"], last["same"]) == ("od_diff", len(counting), not counting)
    assert sum(last["ignored"].values()) == len(rows) - len(counting)
    return done.code, counting, last


def places(rows: Rows) -> list[str]:
    return [f"{row['node']} {row['index']}:{row['sub']:02X}" for row in rows]


def changed(frames: list[CanFrame], place: int) -> list[CanFrame]:
    """The same capture with another value in one expedited download."""
    frame = frames[place]
    return [
        *frames[:place],
        replace(frame, data=frame.data[:4] + bytes([frame.data[4] ^ 1]) + frame.data[5:]),
        *frames[place + 1 :],
    ]


def downloads(frames: list[CanFrame]) -> Iterator[int]:
    """Places of expedited downloads that are accepted and configure something, each the last one of its object."""
    last: dict[tuple[int, bytes], int] = {}
    for place, frame in enumerate(frames):
        answer = next((one for one in frames[place + 1 :] if one.can_id == frame.can_id - 0x80), None)
        if 0x601 <= frame.can_id <= 0x67F and frame.data[0] & 0xE3 == 0x23 and answer and answer.data[0] == 0x60:
            last[frame.can_id, frame.data[1:4]] = place
    for (_, address), place in last.items():
        index = int.from_bytes(address[:2], "little")
        if standard_nature((index, address[2]), 402) is None and not 0x1400 <= index < 0x1C00:
            yield place


@pytest.mark.parametrize("log", SESSIONS, ids=lambda path: path.stem)
def test_a_capture_and_itself_are_the_same(canalyze: Runner, log: Path) -> None:
    code, rows, last = told(canalyze, log, "--diff", log)
    if not last["compared"]:
        pytest.skip("nothing but heartbeats")
    assert (code, rows, last["ignored"]) == (0, [], {})


@pytest.mark.parametrize(
    "log", [path for path in SESSIONS if written(path, described=True)], ids=lambda path: path.stem
)
def test_one_value_is_found_and_nothing_else(canalyze: Runner, log: Path, tmp_path: Path) -> None:
    frames = read_log(log.read_bytes())
    seeded = list(downloads(frames))[:4]
    for place in seeded:
        (tmp_path / "other.log").write_bytes(log_text(changed(frames, place)))
        frame = frames[place]
        index, sub = int.from_bytes(frame.data[1:3], "little"), frame.data[3]
        code, rows, _ = told(canalyze, log, "--diff", "other.log")
        assert code == 1
        # Reads of what was written there show the old value, which is then the last one of neither.
        assert places(rows) == [f"{frame.can_id - 0x600} {index:04X}:{sub:02X}"]
        (row,) = rows
        a, b = (bytes.fromhex(row[side]["data"]) for side in "ab")
        assert a[0] ^ b[0] == 1 and a[1:] == b[1:] and row["a"]["configured"]


def test_enough_is_seeded() -> None:
    assert sum(len(list(downloads(read_log(log.read_bytes())))[:4]) for log in SESSIONS) > 12


@pytest.mark.parametrize("log", SESSIONS, ids=lambda path: path.stem)
def test_a_device_is_as_the_files_that_were_made_of_it(canalyze: Runner, log: Path) -> None:
    """Over its EDS and without one, in both directions; and the files are the same among themselves."""
    options = eds_options(log)
    known = {int(option[6:].split("=")[0]) for option in options}
    for node in written(log, described=False):
        given = options if node in known else []
        wanted = ("--node", str(node))
        made = ("--dcf", f"{node}.dcf", "--concise-dcf", f"{node}.cdcf", "--skeleton", f"{node}.eds")
        if canalyze("od", str(log), *wanted, *made, *given).code:
            continue  # what is written there, RPDOs write too
        pairs: list[tuple[str | Path, ...]] = [
            (log, f"{node}.dcf", *given),
            (f"{node}.dcf", log, *given),
            (log, f"{node}.cdcf", *given),
            (f"{node}.dcf", f"{node}.cdcf"),
            (log, f"{node}.eds", *given),
        ]
        for pair in pairs:
            code, rows, last = told(canalyze, pair[0], "--diff", *pair[1:], *wanted)
            assert (code, rows) == (0, []), (pair, rows)
            assert last["compared"] > 0 or str(pair[1]).endswith("eds"), pair


def test_a_dcf_with_another_value(canalyze: Runner, tmp_path: Path) -> None:
    canalyze("od", str(NETWORK), "--node", "7", "--dcf", "7.dcf", "--eds", f"7={EDS / 'encoder.eds'}")
    text = (tmp_path / "7.dcf").read_text()
    (tmp_path / "other.dcf").write_text(text.replace("ParameterValue=0x64\n", "ParameterValue=0xc8\n", 1))
    assert text != (tmp_path / "other.dcf").read_text()
    code, rows, _ = told(canalyze, NETWORK, "--diff", "other.dcf")
    assert (code, places(rows)) == (1, ["7 1017:00"])
    assert (rows[0]["a"]["data"], rows[0]["b"]["data"]) == ("6400", "C800")
    # One that the capture never wrote is reported, one that only has a default is not.
    (tmp_path / "more.dcf").write_text(text + "\n[1014]\nParameterName=EMCY\nObjectType=7\nDataType=7\nAccessType=rw\n")
    assert told(canalyze, NETWORK, "--diff", "more.dcf")[0] == 0
    with (tmp_path / "more.dcf").open("a") as file:
        file.write("ParameterValue=0x87\n")
    code, rows, _ = told(canalyze, NETWORK, "--diff", "more.dcf")
    assert (code, places(rows), rows[0]["a"]) == (1, ["7 1014:00"], None)
    # Of chosen objects it is not said that the others are missing.
    assert told(canalyze, NETWORK, "--diff", "more.dcf", "--filter", "object=1017")[0] == 0


def test_what_is_missing_in_a_file(canalyze: Runner, tmp_path: Path) -> None:
    canalyze("od", str(NETWORK), "--node", "7", "--skeleton", "7.eds")
    text = (tmp_path / "7.eds").read_text()
    lines = text.split("[1017]")
    (tmp_path / "less.eds").write_text(lines[0] + "[" + lines[1].split("[", 1)[1])
    code, rows, _ = told(canalyze, "7.eds", "--diff", "less.eds")
    assert (code, [row["index"] for row in rows], rows[0]["b"]) == (1, ["1017"], None)
    code, rows, _ = told(canalyze, NETWORK, "--diff", "less.eds", "--node", "7")
    assert (code, places(rows)) == (1, ["7 1017:00"])


@pytest.mark.parametrize("eds", EVERY, ids=lambda path: path.name)
def test_any_description_is_the_same_as_itself(eds: Path) -> None:
    found = load(str(eds))
    same = compare([found, found], None, filtered=False)
    assert [pair.differences for pair in same.pairs] == [[]] and same.alone == ([], [])
    carried = {(one.index, one.sub) for pdo in found.pdos for one in pdo.mapped}
    for thing in found.objects[::7]:
        for entry in thing.entries[-1:]:
            address, default = (entry.index, entry.sub), entry.default
            by_nature = address in carried or standard_nature(address, 402) or entry.access != "rw"
            if by_nature or not isinstance(default, int) or entry.type not in (5, 6, 7) or entry.parameter is not None:
                continue
            (pair,) = compare([found, with_default(found, *address, default ^ 1)], None, filtered=False).pairs
            assert [(one.address, one.reason) for one in pair.differences] == [(address, None)]


def with_default(found: Dictionary, index: int, sub: int, value: int) -> Dictionary:
    things = tuple(
        one._replace(entries=tuple(e._replace(default=value) if e.sub == sub else e for e in one.entries))
        if one.index == index
        else one
        for one in found.objects
    )
    return found._replace(objects=things)


def capture(tmp_path: Path, name: str, node: int, *transfers: tuple[str, int, int, bytes]) -> str:
    """A capture of these transfers."""
    make = {"w": expedited_download, "r": expedited_upload, "s": segmented_upload}
    frames = [frame for kind, *of in transfers for frame in make[kind](Channel(node), *of)]  # type: ignore[arg-type]
    (tmp_path / name).write_bytes(log_text(spaced(frames)))
    return name


def test_nodes_with_different_ids(canalyze: Runner, tmp_path: Path) -> None:
    """COB-IDs that contain the node-ID are compared without it; those that do not, as they are."""

    def of(node: int, name: str, *, emcy: int, rpdo: int) -> str:
        values = [(0x1014, 0, emcy), (0x1400, 1, rpdo), (0x1800, 1, 0x4000_0180 + node), (0x1005, 0, 0x80)]
        writes = [("w", index, sub, value.to_bytes(4, "little")) for index, sub, value in values]
        return capture(tmp_path, name, node, *writes, ("w", 0x1017, 0, b"\x64\0"))

    a = of(5, "a.log", emcy=0x85, rpdo=0x203)
    code, rows, last = told(canalyze, a, "--diff", of(6, "b.log", emcy=0x86, rpdo=0x203), "--node", "5=6")
    assert (code, rows, last["compared"]) == (0, [], 5)
    code, rows, _ = told(canalyze, a, "--diff", of(6, "c.log", emcy=0x85, rpdo=0x204), "--node", "5=6")
    assert (code, places(rows)) == (1, ["5 1014:00", "5 1400:01"])
    assert (rows[0]["a"]["base"], rows[0]["b"]["base"], rows[0]["node_b"]) == ("80", None, 6)
    text = canalyze("--lang", "en", "od", a, "--diff", "c.log").out
    assert "$NODEID+80h" in text and "node 5 on can0 / 6 on can0" in text
    # With one node-ID the number counts.
    code, rows, _ = told(canalyze, a, "--diff", of(5, "d.log", emcy=0x86, rpdo=0x203))
    assert (code, places(rows)) == (1, ["5 1014:00"])


def test_an_eds_is_of_the_node_that_it_is_compared_with(canalyze: Runner, tmp_path: Path) -> None:
    eds = EDS / "drive.eds"
    a = capture(tmp_path, "a.log", 5, ("r", 0x1014, 0, (0x85).to_bytes(4, "little")))
    for sides in ((a, "--diff", eds), (eds, "--diff", a)):
        code, rows, last = told(canalyze, *sides)
        assert (code, rows, last["compared"]) == (0, [], 1)
    b = capture(tmp_path, "b.log", 5, ("r", 0x1014, 0, (0x86).to_bytes(4, "little")))
    assert places(told(canalyze, b, "--diff", eds)[1]) == ["5 1014:00"]


def test_what_changes_by_nature(canalyze: Runner, tmp_path: Path) -> None:
    def of(name: str, value: int) -> str:
        number, long = bytes([value, 0]), bytes([value, 0, 0, 0])
        return capture(
            tmp_path,
            name,
            5,
            ("r", 0x1000, 0, (0x192).to_bytes(4, "little")),
            *(("r", index, sub, long) for index, sub in ((0x1003, 1), (0x1013, 0), (0x1018, 4), (0x6064, 0))),
            *(("w", index, 0, long) for index in (0x1010, 0x607A)),
            ("r", 0x6041, 0, number),
            ("r", 0x6841, 0, number),
            *(("r", 0x2000, 1, bytes([one])) for one in (value, 100)),
            ("r", 0x2000, 2, number),
            ("w", 0x2000, 3, number),
            ("r", 0x2000, 3, b"\0\0"),
            ("s", 0x1008, 0, f"device of {value}".encode()),
        )  # fmt: skip

    # A value that came once may be a parameter; what was written is one, whatever was read before or later.
    code, rows, last = told(canalyze, of("a.log", 1), "--diff", of("b.log", 2))
    assert (code, places(rows)) == (1, ["5 1008:00", "5 2000:02", "5 2000:03"])
    ignored = {"history": 1, "time": 1, "serial": 1, "process": 1, "command": 1, "set-point": 1, "state": 2}
    assert last["ignored"] == ignored
    text = canalyze("--lang", "en", "od", "a.log", "--diff", "b.log").out
    assert "\n  error history  1: 1003h:01\n" in text and "6041h:00, 6841h:00" in text and "statusword" not in text
    assert "statusword" in canalyze("--lang", "en", "od", "a.log", "--diff", "b.log", "--all").out
    # Of one that changes by itself the last values differ.
    c = capture(tmp_path, "c.log", 5, ("r", 0x2000, 1, b"\1"), ("r", 0x2000, 1, b"\2"))
    d = capture(tmp_path, "d.log", 5, ("r", 0x2000, 1, b"\1"), ("r", 0x2000, 1, b"\3"))
    code, rows, last = told(canalyze, c, "--diff", d)
    assert (code, last["ignored"]) == (0, {"varies": 1})
    e = capture(tmp_path, "e.log", 5, ("r", 0x2000, 1, b"\1"), ("w", 0x2000, 1, b"\4"), ("r", 0x2000, 1, b"\4"))
    assert places(told(canalyze, c, "--diff", e)[1]) == ["5 2000:01"]


def test_a_value_is_read_by_one_type_on_both_sides(canalyze: Runner, tmp_path: Path) -> None:
    """What the capture alone tells of a type counts less than what a description says, and sizes need not be those."""
    values = (
        (0x2000, 3, -1, b"\xff\xff"),
        (0x2001, 0x08, 1.5, b"\0\0\xc0\x3f"),
        (0x2002, 9, "ab", b"ab\0\0"),
        (0x2003, 6, 5, b"\5\0\0\0"),
        (0x2004, 9, "cd", b"cd  "),
    )
    sections = "".join(
        f"[{index:04X}]\nParameterName=x\nObjectType=7\nDataType={kind}\nAccessType=rw\nDefaultValue={value}\n"
        for index, kind, value, _ in values
    )
    listed = "".join(f"{number}={row[0]:#x}\n" for number, row in enumerate(values, 1))
    (tmp_path / "a.eds").write_text(f"[ManufacturerObjects]\nSupportedObjects=5\n{listed}{sections}")
    a = capture(tmp_path, "a.log", 5, *(("r", index, 0, data) for index, _, _, data in values))
    for sides in ((a, "--diff", "a.eds"), ("a.eds", "--diff", a)):
        code, rows, last = told(canalyze, *sides)
        assert (code, rows, last["compared"]) == (0, [], 5)
    b = capture(tmp_path, "b.log", 5, *(("r", index, 0, b"\1" + data[1:]) for index, _, _, data in values))
    assert len(told(canalyze, b, "--diff", "a.eds")[1]) == 5


def test_what_only_one_side_shows(canalyze: Runner, tmp_path: Path) -> None:
    a = capture(tmp_path, "a.log", 5, ("r", 0x2000, 1, b"\1"), ("w", 0x2000, 2, b"\2"), ("r", 0x1017, 0, b"\0\0"))
    b = capture(tmp_path, "b.log", 5, ("r", 0x1017, 0, b"\0\0"))
    code, rows, last = told(canalyze, a, "--diff", b)
    assert (code, places(rows), last["ignored"]) == (1, ["5 2000:02"], {"unseen": 1})
    with (tmp_path / b).open("a") as file:
        file.write("(1700000001.000000) can0 605#4000200100000000\n(1700000001.001000) can0 585#8000200100000206\n")
    code, rows, _ = told(canalyze, a, "--diff", b)
    assert places(rows) == ["5 2000:01", "5 2000:02"] and rows[0]["b"]["exists"] is False
    assert "does not exist" in canalyze("--lang", "en", "od", a, "--diff", b).out
    with (tmp_path / b).open("a") as file:
        file.write("(1700000002.000000) can0 605#2F00200207000000\n(1700000002.001000) can0 585#8000200222000008\n")
    text = canalyze("--lang", "en", "od", a, "--diff", b).out
    assert re.search(r"^2000h:02 +- +2 \(02h\) +refused$", text, re.MULTILINE), text
    # A concise DCF is a part, too.
    (tmp_path / "a.cdcf").write_bytes(concise({(0x2000, 2): b"\2"}))
    assert told(canalyze, a, "--diff", "a.cdcf")[0] == 0
    (tmp_path / "b.cdcf").write_bytes(concise({(0x2000, 2): b"\2", (0x2000, 3): b"\2"}))
    assert places(told(canalyze, a, "--diff", "b.cdcf")[1]) == ["5 2000:03"]


def test_nodes_that_one_side_has(canalyze: Runner, tmp_path: Path) -> None:
    read = ("r", 0x1017, 0, b"\0\0")
    for name, nodes in (("a.log", (5, 6)), ("b.log", (5, 7, 8)), ("c.log", (9, 10))):
        texts = []
        for node in nodes:
            capture(tmp_path, "one.log", node, read)
            texts.append((tmp_path / "one.log").read_text())
        (tmp_path / name).write_text("".join(texts))
    done = canalyze("od", "a.log", "--diff", "b.log", "--format", "jsonl")
    alone = [(row["side"], row["node"]) for row in map(json.loads, done.lines) if row["kind"] == "od_diff_node"]
    assert (done.code, alone) == (1, [("a", 6), ("b", 7), ("b", 8)])
    assert told(canalyze, "a.log", "--diff", "b.log", "--node", "5")[0] == 0
    done = canalyze("--lang", "en", "od", "a.log", "--diff", "c.log")
    assert done.code == 1 and "A: 5, 6; B: 9, 10" in done.complaints[-1]
    assert "only B has node 9 on can0: 1 object\n" in done.out and done.lines[-1].startswith("differences: 4;")
    (tmp_path / "nine.cdcf").write_bytes(concise({(0x1017, 0): b"\0\0"}))
    for other in (["a.log", "--node", "9"], ["a.log", "--node", "5=7"], ["nine.cdcf"]):
        done = canalyze("--lang", "en", "od", "c.log", "--diff", *other)
        assert (done.code, done.out) == (2, "") and "no node is on both sides" in done.complaints[-1], other


def test_what_cannot_be_is_said(canalyze: Runner, tmp_path: Path) -> None:
    log = str(NETWORK)
    for line, said in (
        (["--diff", "none.log"], "none.log"),
        (["--diff", "none.dcf"], "none.dcf"),
        (["--diff", log, "--history"], "--history"),
        (["--diff", log, "--format", "csv"], "csv"),
        (["--diff", log, "--dcf", "a.dcf", "--node", "5"], "--dcf"),
        (["--diff", log, "--node", "5=x"], "--node"),
        (["--all"], "--all"),
        (["--dcf", "a.dcf", "--node", "5=6"], "--node"),
    ):
        done = canalyze("--lang", "en", "od", log, *line)
        assert (done.code, done.out) == (2, ""), line
        assert said in done.complaints[-1], line
        assert not (tmp_path / "a.dcf").exists()


def test_shared_sessions_of_one_stack_differ_only_where_they_were_configured(canalyze: Runner) -> None:
    beside = SHARED / "stacks"
    if not beside.is_dir():
        pytest.skip(f"{beside} is not there")
    for log in sorted(beside.glob("*.log")):
        done = canalyze("od", str(log), "--diff", str(log), "--format", "jsonl")
        assert done.code == 0 and json.loads(done.lines[-1])["same"]
