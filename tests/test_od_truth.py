"""`canalyze od` against what happened: every object and value of the truth is in the table, and nothing that is not.

The truth is beside each session: SDO transfers, mappings and EMCYs of real stacks (`samples/stacks`, and the same and
more in `../shared/stacks`, where that is there), signals and EMCYs of made networks (`samples/network`), whose SDO a
second, strict reader reads. Must not: take a value from the program that is not compared.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from captures import EDS, SAMPLES, SHARED, CanFrame, Row, eds_options, read_log, run_canalyze
from sdo_reading import read_transfers

from canalyze.dictionary import load

STACKS = sorted((SAMPLES / "stacks").glob("*.log"))
NETWORKS = sorted((SAMPLES / "network").glob("*.log"))
SECOND = {0x684: 0x604, 0x6C4: 0x584}
"""The second SDO channel of node 4, as if it were the first one."""


@dataclass
class Seen:
    """What the truth has of one object."""

    counts: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    last: tuple[int, str, Any] | None = None
    """Frame, source, and the value: bytes or a number."""
    aborts: set[tuple[str, str]] = field(default_factory=set)

    def value(self, frame: int, source: str, value: Any) -> None:
        self.counts[source] += 1
        if self.last is None or frame >= self.last[0]:
            self.last = (frame, source, value)


Truth = dict[tuple[int, int, int], Seen]
"""By node, index and sub-index."""


def transfers(truth: Truth, rows: list[Row]) -> None:
    """Adds SDO transfers: node, direction, index, sub, data, status, abort code and by whom, last frame."""
    for row in rows:
        seen = truth[row["node"], int(row["index"], 16), row["sub"]]
        if row["status"] == "ok":
            source = "read" if row["direction"] == "upload" else "written"
            seen.value(row["last_frame"], source, bytes.fromhex(row["data"]))
        elif row["abort_by"] == "server":
            seen.counts["refused"] += 1
        else:
            seen.counts["unconfirmed"] += 1
        if row["abort_code"]:
            seen.aborts.add((row["direction"], row["abort_code"]))


def stack(log: Path) -> Truth:
    """What happened in a session of a real stack."""
    told = json.loads(log.with_suffix(".json").read_text())
    truth: Truth = defaultdict(Seen)
    rows = [
        {
            **one,
            "direction": one["dir"],
            "status": "ok" if one["result"] == "ok" else "aborted",
            "last_frame": one["last_line"],
            "abort_code": one.get("abort_code"),
            "abort_by": one.get("abort_by"),
        }
        for one in told["sdo"]
    ]
    transfers(truth, rows)
    frames = read_log(log.read_bytes())
    for pdo in told["pdo"]:
        lines = range(pdo["valid_from_line"], (pdo["valid_to_line"] or len(frames)) + 1)
        for line in lines:
            frame = frames[line - 1]
            if frame.can_id == int(pdo["cob"], 16) and len(frame.data) == pdo["bytes"]:
                whole, offset = int.from_bytes(frame.data, "little"), 0
                for mapped in pdo["mapping"]:
                    raw = whole >> offset & (1 << mapped["bits"]) - 1
                    offset += mapped["bits"]
                    seen = truth[pdo["node"], int(mapped["index"], 16), mapped["sub"]]
                    seen.value(line, "tpdo", raw.to_bytes(mapped["bits"] // 8, "little"))
    emergencies(truth, told)
    return truth


def network(log: Path) -> Truth:
    """What happened in a session of a made network."""
    told = json.loads(log.with_suffix(".json").read_text())
    truth: Truth = defaultdict(Seen)
    frames: list[CanFrame] = read_log(log.read_bytes())
    channels: tuple[dict[int, int], ...] = ({}, SECOND)
    for channel in channels:
        default = [replace(frame, can_id=channel.get(frame.can_id, 0 if channel else frame.can_id)) for frame in frames]
        transfers(truth, [asdict(one) | {"data": one.data.hex()} for one in read_transfers(default)])
    for pdo in told["pdo"]:
        for place, value in pdo["signals"].items():
            index, sub = (int(part, 16) for part in place.split(":"))
            source = "tpdo" if pdo["pdo"].startswith("TPDO") else "rpdo"
            truth[pdo["node"], index, sub].value(pdo["line"], source, value)
    for mpdo in told["mpdo"]:
        source = "tpdo" if mpdo["mpdo"] == "sam" else "rpdo"
        truth[mpdo["node"], int(mpdo["index"], 16), mpdo["sub"]].value(mpdo["line"], source, mpdo["value"])
    emergencies(truth, told)
    return truth


def emergencies(truth: Truth, told: Row) -> None:
    for emcy in told["emcy"]:
        truth[emcy["node"], 0x1001, 0].value(emcy["line"], "emcy", int(emcy["error_register"], 16))


def objects(log: Path, *options: str) -> Iterator[Row]:
    """The objects that the program shows."""
    for line in run_canalyze(["od", log, "--format", "jsonl", "--lang", "en", *options]).splitlines():
        row = json.loads(line)
        if row["kind"] == "od_object":
            yield row


def compare(truth: Truth, rows: list[Row]) -> None:
    """Raise AssertionError where the table is not the truth."""
    shown = {(row["node"], int(row["index"], 16), row["sub"]): row for row in rows}
    assert len(shown) == len(rows), "an object stands there twice"
    assert sorted(shown) == sorted(truth)
    for place, seen in truth.items():
        row = shown[place]
        counts = {key: row[key] for key in ("read", "written", "tpdo", "rpdo", "emcy", "refused", "unconfirmed")}
        assert {key: count for key, count in counts.items() if count} == dict(seen.counts), place
        assert {(one["request"], one["code"]) for one in row["aborts"]} == seen.aborts, place
        if seen.last is None:
            assert (row["value"], row["data"], row["frame"]) == (None, None, None), place
            continue
        frame, source, value = seen.last
        assert (row["frame"], row["source"]) == (frame, source), place
        if isinstance(value, bytes):
            assert bytes.fromhex(row["data"]) == value[:4096], place
        else:
            assert row["value"] == value, place


def _stacks() -> list[Path]:
    beside = SHARED / "stacks"
    if not beside.is_dir():
        pytest.skip(f"{beside} is not there")
    return sorted(beside.glob("*.log"))


@pytest.mark.parametrize("log", STACKS, ids=lambda path: path.stem)
def test_stacks(log: Path) -> None:
    compare(stack(log), list(objects(log)))


def test_shared_stacks() -> None:
    for log in _stacks():
        compare(stack(log), list(objects(log)))


@pytest.mark.parametrize("log", NETWORKS, ids=lambda path: path.stem)
def test_networks(log: Path) -> None:
    compare(network(log), list(objects(log, *eds_options(log))))


@pytest.mark.parametrize("log", NETWORKS, ids=lambda path: path.stem)
def test_a_described_object_is_as_described(log: Path) -> None:
    """Name and type are those of the description, and each object that has a value stands in it."""
    nodes = json.loads(log.with_suffix(".json").read_text())["nodes"]
    described = {node["node"]: load(EDS / node["eds"]) for node in nodes if node.get("eds")}
    for row in objects(log, *eds_options(log)):
        if (found := described.get(row["node"])) is None:
            continue
        entries = {(entry.index, entry.sub): entry for thing in found.objects for entry in thing.entries}
        entry = entries.get((int(row["index"], 16), row["sub"]))
        assert (entry is None) == (row["exists"] is not True), row
        if entry is not None:
            assert row["type_from"] == "eds"
            if row["access"] in ("ro", "wo"):
                assert entry.access in (row["access"], "const"), row


def test_a_mapping_at_a_time() -> None:
    """Mapping and COB-ID in force in the middle of each stretch of the truth are those that the table has then."""
    (log,) = (path for path in STACKS if path.stem.startswith("c3"))
    told = json.loads(log.with_suffix(".json").read_text())
    frames = read_log(log.read_bytes())
    assert len(told["pdo"]) > 3
    for pdo in told["pdo"]:
        last = pdo["valid_to_line"] or len(frames)
        line = (pdo["valid_from_line"] + last) // 2
        at = (frames[line - 1].t_us - frames[0].t_us) / 1e6
        rows = {(row["index"], row["sub"]): row for row in objects(log, "--at", f"{at:.6f}")}
        assert max(row["last_frame"] for row in rows.values()) <= line
        number = int(pdo["pdo"][4:]) - 1
        cob, count = rows[f"{0x1800 + number:04X}", 1], rows[f"{0x1A00 + number:04X}", 0]
        assert cob["in_force"]["value"] & 0x800007FF == int(pdo["cob"], 16)
        assert count["in_force"]["value"] == len(pdo["mapping"])
        for sub, mapped in enumerate(pdo["mapping"], 1):
            word = rows[f"{0x1A00 + number:04X}", sub]["in_force"]["value"]
            assert word == int(mapped["index"], 16) << 16 | mapped["sub"] << 8 | mapped["bits"]


@pytest.mark.parametrize("log", [*STACKS, *NETWORKS], ids=lambda path: path.stem)
def test_the_history_adds_up(log: Path) -> None:
    """What single values add up to is the table, at the end and at any time."""
    options = eds_options(log)
    lines = run_canalyze(["od", log, "--history", "--format", "jsonl", "--lang", "en", *options]).splitlines()
    history = [json.loads(line) for line in lines]
    frames = read_log(log.read_bytes())
    half = (frames[len(frames) // 2].t_us - frames[0].t_us) / 1e6
    for at, rows in ((None, history), (half, [one for one in history if one["frame"] <= len(frames) // 2 + 1])):
        truth: Truth = defaultdict(Seen)
        for one in rows:
            seen = truth[one["node"], int(one["index"], 16), one["sub"]]
            if one["source"] in ("refused", "unconfirmed"):
                seen.counts[one["source"]] += 1
            elif one["data"] is not None:
                seen.value(one["frame"], one["source"], bytes.fromhex(one["data"]))
        table = list(objects(log, *options, *(() if at is None else ("--at", f"{at:.6f}"))))
        for row in table:
            seen = truth[row["node"], int(row["index"], 16), row["sub"]]
            if at is not None and row["unconfirmed"] and not seen.counts:
                continue  # a request to which there is no answer by then
            counts = {key: row[key] for key in seen.counts}
            assert counts == dict(seen.counts), row
            if seen.last is not None:
                assert (row["frame"], bytes.fromhex(row["data"])) == (seen.last[0], seen.last[2][:4096])
        assert len(truth) == len(table)
