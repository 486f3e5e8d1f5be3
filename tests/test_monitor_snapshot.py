"""What a view shows of a capture is what the other forms say of it; its keys are frozen, keys may only be added."""

from __future__ import annotations

import json
from collections import Counter
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from captures import DATA, SAMPLES, Row, described_beside, session_output

from canalyze import _core
from canalyze.running.reading import SessionOptions

SOURCE = Path(__file__).parent.parent / "canalyze/core/src/views/monitor"
KEYS = {
    place: set(keys.split())
    for place, keys in (line.split(": ") for line in (DATA / "monitor_keys.txt").read_text().splitlines())
}
CAPTURES = sorted(
    path.relative_to(SAMPLES).as_posix()
    for path in SAMPLES.rglob("*.log")
    if path.parent.name in {"network", "rules", "samples"}
)
ROWS = 500
DONE = 200


def ns(seconds: str | None) -> int | None:
    """Decimal seconds of JSON lines in ns."""
    return None if seconds is None else int(Decimal(seconds) * 10**9)


def watched(text: bytes, name: str, lang: str, network: _core.Network | None, *, over: bool = True) -> _core.Session:
    session = _core.Session(SessionOptions(format="monitor", lang=lang, network=network))
    form = _core.sniff(text, True)
    session.begin(name, True, form if form in _core.FORMATS else "candump")
    assert session.feed(text) + session.end() == b""
    if over:
        assert session.finish() == b""
    return session


def told(text: bytes, name: str, form: str, lang: str, network: _core.Network | None) -> list[Row]:
    output = session_output([text], name=name, output_format=form, lang=lang, network=network)
    return [json.loads(line) for line in output.decode().splitlines()]


def by_object(frame: Row) -> tuple[str, str, bool]:
    """Under which line a frame stands: all error frames of a bus under one."""
    return frame["bus"] or "", "error" if frame["err"] else frame["id"], frame["rtr"]


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("name", CAPTURES)
def test_it_shows_what_the_other_forms_say(name: str, lang: str) -> None:
    path = SAMPLES / name
    text, known = path.read_bytes(), described_beside(path)
    session = watched(text, path.name, lang, known)
    shown: dict[str, Any] = json.loads(session.snapshot())
    rows = told(text, path.name, "jsonl", lang, known)
    summary = told(text, path.name, "summary", lang, known)

    frames = [row for row in rows if row["kind"] == "frame"]
    assert shown["tally"]["frames"] == shown["tally"]["shown"] == len(frames)
    stamps = [stamp for stamp in (ns(frame["t"]) for frame in frames) if stamp is not None]
    assert (shown["start_ns"], shown["now_ns"]) == ((min(stamps), max(stamps)) if stamps else (None, None))

    counts = Counter(by_object(frame) for frame in frames)
    last = {by_object(frame): frame for frame in frames}
    objects = {}
    for row in shown["objects"]:
        objects[row["bus"], "error" if row["service"] == "error" else row["id"], row["rtr"]] = row
    assert len(objects) == len(shown["objects"]) and shown["objects_more"] == 0
    assert {key: row["count"] for key, row in objects.items()} == counts
    for key, frame in last.items():
        row = objects[key]
        assert [row[one] for one in ("service", "node", "ext", "text")] == [
            frame[one] for one in ("service", "node", "ext", "text")
        ]
        assert row["last_ns"] == ns(frame["t"]) and row["data"] == frame["data"]
        assert len(row["changed"]) == len(row["data"]) and set(row["changed"]) <= {"0", "F"}
        assert row["name"]
    order = [(row["bus"], row["service"] == "error", row["ext"], row["id"], row["rtr"]) for row in shown["objects"]]
    buses = [row["name"] for row in shown["buses"]]
    assert order == sorted(order, key=lambda one: (buses.index(one[0]), *one[1:]))

    check_nodes(shown, summary)
    check_transfers(shown, rows, told(text, path.name, "transfers-text", lang, known))
    check_findings(shown, summary)
    check_trace(session, frames, rows)


def check_nodes(shown: dict[str, Any], summary: list[Row]) -> None:
    """Nodes and buses are those of the figures."""
    counted = {(row["bus"] or "", row["node"]): row for row in summary if row["kind"] == "summary_node"}
    assert [(row["bus"], row["node"]) for row in shown["nodes"]] == list(counted)
    for row in shown["nodes"]:
        figures = counted[row["bus"], row["node"]]
        for key in ("state", "frames", "sent", "boot_ups"):
            assert row[key] == figures[key], key
        assert (row["name"] or None, row["state_text"] or None) == (figures["name"], figures["state_text"])
        assert row["guarded"] == (figures["error_control"] == "guarding")
        if row["emcy"]:
            assert row["emcy"]["code"] in {emcy["code"] for emcy in figures["emcy"]}
    figures_of = {row["bus"] or "": row for row in summary if row["kind"] == "summary_bus"}
    for bus in shown["buses"]:
        if bus["name"] in figures_of:
            assert bus["frames"] == figures_of[bus["name"]]["frames"]
    assert {bus["name"] for bus in shown["buses"]} >= set(figures_of)


def check_transfers(shown: dict[str, Any], rows: list[Row], transfers: list[Row]) -> None:
    """Transfers are those that `sdo` lists, and after the end of the capture none runs."""
    assert shown["transfers"]["running"] == []
    done = shown["transfers"]["done"]
    assert len(done) == min(len(transfers), DONE)
    for row, one in zip(done, transfers[-DONE:], strict=True):
        same = KEYS["done"] - {"bus", "t_ns", "duration_ns"}
        assert {key: row[key] for key in same} == {key: one[key] for key in same}
        assert (row["bus"], row["t_ns"]) == (one["bus"] or "", ns(one["t"]))
        assert row["duration_ns"] == ns(one["duration"])
    ended = Counter(row["status"] for row in rows if row["kind"] == "transfer")
    assert Counter(shown["tally"]["transfers"]) == ended


def check_findings(shown: dict[str, Any], summary: list[Row]) -> None:
    """As many findings of each rule as the figures have, each in at most ten rows a kind."""
    counts: Counter[str] = Counter()
    for row in shown["findings"]:
        counts[row["code"]] += row["count"]
        assert row["text"]
    # A rule whose consequences are told beside it has a row for each severity.
    expected: Counter[str] = Counter()
    for row in summary:
        if row["kind"] == "summary_finding":
            expected[row["code"]] += row["count"]
    assert counts == expected
    severities: Counter[str] = Counter()
    for row in summary:
        if row["kind"] == "summary_finding":
            severities[row["severity"]] += row["count"]
    assert Counter(shown["tally"]["findings"]) == severities
    assert len(shown["findings"]) <= ROWS


def check_trace(session: _core.Session, frames: list[Row], rows: list[Row]) -> None:
    """A line for each frame with its words, and below it a line for each finding and note."""
    lines = session.trace(rows=100_000)
    own = [line for line in lines if line[4]]
    assert [(line[0], line[2], line[3], line[6]) for line in own] == [
        (frame["frame"], ns(frame["t"]), frame["bus"] or "", frame["text"]) for frame in frames
    ]
    for line, frame in zip(own, frames, strict=True):
        assert line[5] == ("remote request" if frame["rtr"] else bytes.fromhex(frame["data"]).hex(" ").upper())
        if line[1]:
            assert frame["findings"]
    below = [line for line in lines if not line[4]]
    findings = Counter(row["code"] for row in rows if row["kind"] == "finding")
    said = Counter(line[6].split()[0] for line in below if line[1])
    assert said.keys() == findings.keys()
    assert [line[0] for line in lines] == sorted(line[0] for line in lines)


def test_keys_are_those_that_are_documented() -> None:
    seen: Counter[str] = Counter()
    parts = {"emergency": b"(1700000000.000000) can0 085#2081110000000000\n"}
    for name in CAPTURES:
        text = (SAMPLES / name).read_bytes()
        # Before the end, so that something runs.
        parts[name] = text[: text.rfind(b"\n", 0, len(text) * 2 // 3) + 1]
    for name, part in parts.items():
        known = None if name == "emergency" else described_beside(SAMPLES / name)
        shown = json.loads(watched(part, name, "en", known, over=False).snapshot())
        assert set(shown) == KEYS["snapshot"] and set(shown["transfers"]) == {"running", "done"}
        found = {key: shown[key] for key in ("buses", "nodes", "objects", "findings", "problems")} | shown["transfers"]
        found["emcy"] = [node["emcy"] for node in shown["nodes"] if node["emcy"]]
        found["problem"] = [node["problem"] for node in shown["nodes"] if node["problem"]]
        for kind, rows in found.items():
            seen[kind] += len(rows)
            assert all(set(row) == KEYS[kind] for row in rows), (name, kind)
        assert all(set(node["findings"]) == {"error", "warning"} for node in shown["nodes"])
    assert set(seen) == KEYS.keys() - {"snapshot"} and all(seen.values()), seen
    declared = "".join(path.read_text() for path in SOURCE.glob("*.rs"))
    for documented in (declared, (SOURCE.parents[3] / "_core.pyi").read_text()):
        assert all(key in documented for keys in KEYS.values() for key in keys)


def test_other_formats_have_neither_snapshot_nor_trace() -> None:
    session = _core.Session(SessionOptions(format="text"))
    assert session.snapshot() == "" and session.trace() == []


@pytest.mark.parametrize(("lang", "words"), [("zh", "过滤"), ("en", "filter")])
def test_a_bad_filter_is_said_in_words(lang: str, words: str) -> None:
    session = _core.Session(SessionOptions(format="monitor", lang=lang))
    with pytest.raises(ValueError, match=words):
        session.trace(filter="service=nothing")


def test_a_network_of_300_objects() -> None:
    lines = []
    for number in range(6000):
        node = 1 + number % 30
        base = (0x180, 0x280, 0x380, 0x480, 0x200, 0x300, 0x400, 0x500, 0x080, 0x700)[number // 30 % 10]
        data = b"05" if base == 0x700 else b"%016X" % (number * 0x9E3779B97F4A7C15 % 2**64)
        lines.append(b"(%d.%06d) can0 %03X#%s\n" % (100 + number // 3000, number % 3000 * 333, base + node, data))
    session = watched(b"".join(lines), "capture.log", "zh", None)
    shown = json.loads(session.snapshot())
    assert (len(shown["nodes"]), len(shown["objects"])) == (30, 300)
