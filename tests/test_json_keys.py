"""The keys of the machine output, frozen: keys may be added here, none may be renamed or go."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

from captures import SAMPLES, Row, analyze, described_beside, session_output
from conftest import Runner

from canalyze import _core

SOURCE = Path(__file__).parent.parent / "canalyze/core/src/tables/jsonl"

KEYS = {
    "frame": {
        *("kind", "frame", "line", "file", "t", "bus", "dir", "id", "ext", "rtr", "fd", "err", "len", "data"),
        *("service", "node", "text", "findings"),
    },
    "finding": {
        *("kind", "code", "name", "severity", "file", "frame", "line", "t", "cause_frame", "cause_line", "bus", "node"),
        *("about_frame", "because_of", "index", "sub", "message", "facts"),
    },
    "note": {"kind", "note", "frame", "line", "about_frame", "about_line", "bus", "node", "transfer", "text", "facts"},
    "transfer": {
        *(
            "kind",
            "transfer",
            "bus",
            "node",
            "client",
            "session",
            "direction",
            "mode",
            "index",
            "sub",
            "name",
            "type",
            "size_indicated",
        ),
        *("size", "data", "value", "text", "status", "abort", "first_frame", "last_frame", "t", "duration"),
        *("reordered", "retransmissions", "crc_negotiated", "findings", "requested"),
    },
    "od_node": {
        *("kind", "bus", "node", "objects", "values", "further", "booted", "device_type", "profile"),
        *("vendor_id", "product_code", "revision", "serial", "device_name"),
    },
    "od_pdo": {"kind", "bus", "node", "pdo", "id", "ext", "frames", "length_min", "length_max"},
    "od_object": {
        *("kind", "bus", "node", "index", "sub", "name", "type", "type_from", "bits", "access", "readable", "writable"),
        *("exists", "value", "text", "data", "source", "t", "frame", "values", "varies"),
        *("read", "written", "tpdo", "rpdo"),
        *(
            "emcy",
            "refused",
            "unconfirmed",
            "requested",
            "configured",
            "aborts",
            "in_force",
            "first",
            "sizes",
            "extremes",
            "first_frame",
            "last_frame",
        ),
    },
}
INFO = {
    "": {
        *(
            "kind",
            "file",
            "format",
            "compression",
            "checked",
            "size",
            "frames",
            "buses",
            "kinds",
            "directions",
            "unstamped",
        ),
        *("first_t", "last_t", "seconds", "first_date", "last_date", "zone", "decimals", "backward"),
        *(
            "backward_most_us",
            "unreadable",
            "gaps",
            "dropped",
            "left_out",
            "error_markers",
            "clamped_stamps",
            "damage",
            "damages",
            "contents",
        ),
    },
    "buses": {"bus", "frames"},
    "kinds": {"data", "remote", "fd", "error", "standard", "extended"},
    "directions": {"rx", "tx"},
    "unreadable": {"count", "first_line", "first_offset", "further_buses"},
    "damage": {"kind", "line", "offset", "bytes", "frames"},
    "contents": {"dialect", "passed_over", "topics"},
}
"""Of `info`: the object, and the objects in it."""
CHECK = {
    "finding": KEYS["finding"] | {"lines", "count", "frames", "known", "fails"},
    "check": {
        "kind",
        "file",
        "frames",
        "failed",
        "failures",
        "others",
        "nature",
        "judged",
        "overruled",
        "reasons",
        "expectations",
        "error",
    },
}
"""Of `check`: a kind of finding, and the end of a capture."""
DIFF = {
    "difference": {
        *("kind", "what", "bus", "node", "service", "index", "sub", "direction", "count", "text", "a", "b"),
        *("a_near", "b_near"),
    },
    "side": {"bus", "frame", "line", "t", "last_frame", "text", "value"},
    "problem_difference": {"kind", "problem", "bus", "node", "differs", "a", "b"},
    "problem": {"bus", "id", "frame", "t", "end_frame", "status", "duration_ns", "count", "cause", "text"},
    "diff": {"kind", "same", "problems", "incidents", "differences", "more", "rigid", "times", "placed", "a", "b"},
    "capture": {"file", "frames", "first_frame", "last_frame", "outside", "full"},
}
"""Of `diff`: a difference and what each capture has of it; the end and what is said of each capture."""
OBSERVED = {
    "signal": {
        *("kind", "bus", "node", "pdo", "index", "sub", "signal", "select", "unit", "count", "min", "max"),
        "first_frame",
    },
    "pdo": {"kind", "bus", "node", "pdo", "count", "period", "silence_us"},
    "state": {
        *(
            "kind",
            "bus",
            "node",
            "state",
            "count",
            "first_frame",
            "first_t",
            "since_start_ns",
            "since_boot_up_ns",
            "left",
        ),
    },
    "drive": {
        *("kind", "bus", "node", "axis", "state", "count", "first_frame", "first_t", "since_start_ns"),
        *("since_boot_up_ns", "left"),
    },
    "emcy": {"kind", "bus", "node", "code", "count", "first_frame"},
    "heartbeat": {"kind", "bus", "node", "count", "period", "silence_us"},
    "sync": {"kind", "bus", "count", "period", "silence_us"},
}
"""Of the form `observed`, by what follows `observed_` in the kind."""
PERIOD = {"count", "min_us", "mean_us", "max_us"}
SDO = {"by", "command", "transfer", "index", "sub", "segment", "place", "answered_by"}
HOLE = {"offset", "length"}
"""Of a transfer with the key `holes`, which only those have of which bytes are missing."""
MALFORMED = {"malformed", "least", "most"}
"""Of a frame whose length says that nothing can be read from it."""


def rows() -> list[Row]:
    found = []
    for path in sorted(SAMPLES.rglob("*.jsonl")):
        found += [json.loads(line) for line in path.read_text().splitlines()]
    return found


def test_keys_are_those_that_are_documented() -> None:
    seen: dict[str, int] = {}
    for row in rows():
        kind = row["kind"]
        seen[kind] = seen.get(kind, 0) + 1
        extra = {row["service"]} if kind == "frame" else {"holes"} & set(row)
        assert set(row) == KEYS[kind] | extra, row
        assert all(set(hole) == HOLE for hole in row.get("holes", ({"offset", "length"},))), row
        if kind == "frame" and row["service"] == "sdo":
            assert set(row["sdo"]) >= SDO or set(row["sdo"]) in (MALFORMED, {"malformed"}), row
    assert seen.get("frame", 0) > 300
    assert seen.get("finding", 0) > 10
    assert seen.get("transfer", 0) > 20


def test_a_note_has_its_keys() -> None:
    reset = b"".join(
        b"(1.%06d) can0 %s\n" % (number, frame)
        for number, frame in enumerate(
            [
                b"60A#4002200000000000",
                b"58A#4F0220005A000000",
                b"60A#4008100000000000",
                b"58A#4108100017000000",
                b"70A#00",
            ]
        )
    )
    notes = [row for row in analyze(reset).notes if row["kind"] == "note"]
    assert [set(row) for row in notes] == [KEYS["note"]]
    assert [(row["note"], row["about_frame"]) for row in notes] == [("lost_by_reset", 3)]


def test_info_has_its_keys(canalyze: Runner, tmp_path: Path) -> None:
    log = b"(1.0) can0 701#05\n(1.0) can0 701#0\n" * 1000
    (tmp_path / "cut.gz").write_bytes(gzip.compress(log)[:-10])
    (row,) = map(json.loads, canalyze("info", "--format", "jsonl", "cut.gz").lines)
    assert set(row) == INFO[""]
    for key in INFO.keys() - {""}:
        objects = row[key] if isinstance(row[key], list) else [row[key]]
        assert objects and all(set(one) == INFO[key] for one in objects), key
    documented = (SOURCE / "info.rs").read_text()
    assert all(key in documented for keys in INFO.values() for key in keys if keys is not INFO["contents"])


def test_observed_has_its_keys() -> None:
    """All kinds, and what stands in them of a network with a drive on node 5."""
    capture = SAMPLES / "network" / "sync-and-pdos.log"
    emergency = b"(1700009999.000000) vcan0 085#3081110000000000\n"
    text = capture.read_bytes() + emergency
    known = described_beside(capture)
    output = session_output([text], name=capture.name, output_format="observed", lang="en", network=known)
    found = [json.loads(line) for line in output.decode().splitlines()]
    assert {"transfer", "summary_capture", "summary_node"} <= {row["kind"] for row in found}
    seen = {row["kind"]: row for row in found if row["kind"].startswith("observed_")}
    assert set(seen) == {f"observed_{kind}" for kind in OBSERVED}
    for row in found:
        if row["kind"] in seen:
            assert set(row) == OBSERVED[row["kind"].removeprefix("observed_")]
            assert row.get("period") is None or set(row["period"]) == PERIOD
    documented = (SOURCE / "observed.rs").read_text()
    assert all(key in documented for keys in OBSERVED.values() for key in keys | PERIOD if key != "kind")


def test_check_has_its_keys(canalyze: Runner) -> None:
    rules = [str(SAMPLES / "rules" / f"{code}.log") for code in ("SDO001", "SYN003", "CAP001")]
    found = [json.loads(line) for line in canalyze("check", "--format", "jsonl", *rules).lines]
    assert {row["kind"] for row in found} == set(CHECK)
    for row in found:
        assert set(row) == CHECK[row["kind"]]
        for line in row.get("lines", ()):
            assert set(line) == {"frame", "text"}
    documented = (SOURCE.parents[3] / "reports/check_jsonl.py").read_text() + _core.schema().decode()
    assert all(key in documented for keys in CHECK.values() for key in keys)


def test_diff_has_its_keys(canalyze: Runner, tmp_path: Path) -> None:
    capture = SAMPLES / "network" / "boot-and-states.log"
    lines = capture.read_bytes().splitlines(keepends=True)
    (tmp_path / "other.log").write_bytes(b"".join(lines[:40] + lines[60:]))
    *found, closing = map(json.loads, canalyze("diff", "--format", "jsonl", str(capture), "other.log").lines)
    pair = (str(SAMPLES / "rules" / name) for name in ("HBT002.log", "HBT002.clean.log"))
    lost = json.loads(canalyze("diff", "--format", "jsonl", *pair).lines[0])
    assert found and set(closing) == DIFF["diff"]
    assert {row["kind"] for row in (lost, *found)} == {"problem_difference", "difference"}
    for row in (lost, *found):
        assert set(row) == DIFF[row["kind"]]
        side_keys = DIFF["side" if row["kind"] == "difference" else "problem"]
        assert all(set(row[side]) == side_keys for side in "ab" if row[side])
    assert all(set(closing[side]) == DIFF["capture"] for side in "ab")
    documented = (SOURCE / "diff.rs").read_text()
    assert all(key in documented for keys in DIFF.values() for key in keys)


def test_the_schema_has_every_key() -> None:
    schema = {record["kind"]: record["columns"] for record in json.loads(_core.schema())}
    for kind, keys in KEYS.items():
        assert {"kind"} | {one["key"] for one in schema[kind] if one["key"] and not one["optional"]} == keys
