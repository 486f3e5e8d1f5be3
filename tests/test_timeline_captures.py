"""Timelines of captures: every value, time, state and name against what the JSON lines say of the same capture.

What it must not do: look at the recording's layout, or at how batches become rows.
"""

from __future__ import annotations

import json
import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rerun")

from captures import SAMPLES, Analysis, Row, console_text, described_beside, log_text, read_log, sort_rows
from recordings import Recording, recording, verified

from canalyze import _core
from canalyze.running.reading import SessionOptions
from canalyze.timeline import TABLES
from canalyze.timeline.charts import COLOURS
from canalyze.timeline.recording import Timeline
from canalyze.timeline.stream import escaped, part
from canalyze.words import Words

NETWORKS = sorted((SAMPLES / "network").glob("*.log"))
OTHERS = [SAMPLES / name for name in ("services.log", "zephyr-sdo.log", "sdo-abort.log", "two-nodes-interleaved.log")]
DATES_NS = 631_152_000 * 10**9
NMT = {"00": ("pre-operational",), "04": ("stopped",), "05": ("operational",), "7F": ("pre-operational",)}


class Shown:
    """One capture as a timeline, and what the program says of it otherwise."""

    def __init__(self, folder: Path, data: bytes, network: _core.Network | None, lang: str, **settings: Any) -> None:
        """Read it by canalyze several times."""

        def session(form: str, **more: Any) -> _core.Session:
            return _core.Session(SessionOptions(lang=lang, format=form, network=network, **more, **settings))

        self.said: Analysis = sort_rows(_read(session("jsonl"), data))
        # JSON has the names of no language; those that a reader sees are in the table.
        rows: list[Row] = [json.loads(line) for line in _read(session("signals"), data).splitlines()]
        tables = session("columns", tables=["signals"])
        seen: list[tuple[str, str | None]] = []
        _read(tables, data, lambda: seen.extend(pair for _, one in tables.batches() for pair in _named(one)))
        self.signals = [row | {"signal": name, "text": text} for row, (name, text) in zip(rows, seen, strict=True)]
        self.path = folder / "out.rrd"
        timeline = Timeline(Words(lang), name="capture.log", save=str(self.path))
        shown = session("summary", tables=TABLES)
        summary = _read(shown, data, lambda: timeline.take(shown.batches()))
        timeline.finish(summary)
        self.contents = timeline.contents
        self.recording: Recording = recording(self.path)
        stamps = {row["frame"]: _ns(row["t"]) for row in self.said.frames if row["t"] is not None}
        self.stamps = stamps
        self.start = stamps[min(stamps)] if stamps else 0

    def on_time(self, rows: Sequence[dict[str, Any]]) -> None:
        """Rows stand where their frames do."""
        for row in rows:
            stamp = self.stamps.get(row["frame"])
            assert row.get("time_since_start") == (None if stamp is None else stamp - self.start), row
            dated = stamp is not None and self.start >= DATES_NS
            assert row.get("capture_time") == (stamp if dated else None), row

    def under(self, top: str) -> list[str]:
        return sorted(entity for entity in self.recording.entities() if entity.startswith(top))


def _named(signals: _core.Batch) -> Iterator[tuple[str, str | None]]:
    """Name and text of each row of the table of signals."""
    return zip(signals.column("signal"), signals.column("text"), strict=True)


def _ns(stamp: str) -> int:
    return int(Decimal(stamp) * 10**9)


def _read(session: _core.Session, data: bytes, then: Callable[[], None] = lambda: None) -> bytes:
    form = _core.sniff(data, True)
    session.begin("capture.log", True, form if form in _core.FORMATS else "candump")
    said = []
    for at in range(0, len(data), 4096):
        said.append(session.feed(data[at : at + 4096]))
        then()
    said += [session.end(), session.finish()]
    then()
    return b"".join(said)


@pytest.fixture(params=["zh", "en"])
def lang(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=[*NETWORKS, *OTHERS], ids=lambda path: path.stem)
def shown(request: pytest.FixtureRequest, lang: str, tmp_path: Path) -> Shown:
    path: Path = request.param
    return Shown(tmp_path, path.read_bytes(), described_beside(path), lang)


def _check(shown: Shown) -> None:
    """All that a timeline says of its capture."""
    assert verified(shown.path)
    _frames(shown)
    _signals(shown)
    _holds(shown)
    _delays(shown)
    _logs(shown)
    _sync(shown)
    _nmt(shown)
    _transfers(shown)
    _durations(shown)
    _emergencies(shown)
    _colours(shown)


def test_a_timeline_says_what_the_lines_say(shown: Shown) -> None:
    _check(shown)


def _frames(shown: Shown) -> None:
    rows = shown.recording.rows("/frames", "TextLog:text")
    shown.on_time(rows)
    assert [row["frame"] for row in rows] == [row["frame"] for row in shown.said.frames]
    levels = [row["value"][0] for row in shown.recording.rows("/frames", "TextLog:level")]
    several = len({row["bus"] for row in shown.said.frames}) > 1
    for row, level, said in zip(rows, levels, shown.said.frames, strict=True):
        (text,) = row["value"]
        assert said["err"] or said["id"] in text
        assert said["text"] is None or said["text"] in text, (said["text"], text)
        assert not several or text.startswith(said["bus"] or "-")
        # Of a finding that only later frames prove the line knows nothing.
        at_it = (one for one in shown.said.findings if one["frame"] == row["frame"])
        worst = {one["severity"] for one in at_it if one["code"] in said["findings"]}
        expected = next((shown_as for one, shown_as in SEVERITIES if one in worst), "TRACE")
        assert level == expected, (row, worst)


SEVERITIES = (("error", "ERROR"), ("warning", "WARN"), ("info", "INFO"))


def _pdo(bus: str | None, node: int, pdo: str) -> str:
    return "/".join(one for one in (part(bus or ""), f"node{node}", pdo) if one)


def _signals(shown: Shown) -> None:
    """Every signal is a sample of a line or a state of a lane, and no sample is anything else."""
    samples: dict[tuple[str, int, str], float] = {}
    for entity in shown.under("/pdo/"):
        names = shown.recording.static(entity, "SeriesLines:names")
        rows = shown.recording.rows(entity, "Scalars:scalars")
        shown.on_time(rows)
        whose = entity.removeprefix("/pdo/").partition("/v")[0]
        for row in rows:
            assert len(row["value"]) == len(names)
            for name, one in zip(names, row["value"], strict=True):
                # Where samples do not hold on, nothing follows; that may be at a frame with a sample.
                if not (math.isnan(one) and (whose, row["frame"], name) in samples):
                    samples[whose, row["frame"], name] = one
    # A multiplex PDO has another object in every frame: it is in the annotated frames only.
    plain = {row["frame"] for row in shown.said.frames if "sync" in (row.get("pdo") or {})}
    for said in shown.signals:
        if said["frame"] not in plain:
            continue
        whose, name = _pdo(said["bus"], said["node"], said["pdo"]), said["signal"]
        line = f"{name} [{said['unit']}]" if said["unit"] else name
        value = samples.pop((whose, said["frame"], line), None)
        if value is not None:
            expected = math.nan if said["value"] is None else float(said["value"])
            assert value == pytest.approx(expected, rel=1e-6, nan_ok=True), said
            continue
        entity = escaped(f"value/{whose}/{part(name)}")
        state = _at(shown, entity, said["frame"])
        assert state, (entity, said)
        assert state == (said["text"] or _plain(said["value"])), (entity, said)
    assert not [key for key, value in samples.items() if not math.isnan(value)]


def _holds(shown: Shown) -> None:
    """No sample is drawn on behind a boot-up of its node."""
    for plot in shown.contents.plots.values():
        rows = shown.recording.rows(plot.entity, "Scalars:scalars")
        boots = [
            row["frame"]
            for row in shown.said.frames
            if (row["bus"] or "", row["node"]) == (plot.bus, plot.node) and (row.get("heartbeat") or {}).get("boot_up")
        ]
        for boot in boots:
            before = [row for row in rows if row["frame"] <= boot]
            if before and any(row["frame"] > boot for row in rows):
                assert all(map(math.isnan, before[-1]["value"])), (plot.entity, boot, before[-1])


def _plain(value: Any) -> str:
    return {True: "1", False: "0"}[value] if isinstance(value, bool) else str(value)


def _at(shown: Shown, entity: str, frame: int) -> str | None:
    """The state of a lane at a frame."""
    states = shown.recording.rows(entity, "StateChange:state")
    place = bisect_right([row["frame"] for row in states], frame)
    return str(states[place - 1]["value"][0]) if place else None


def _is_of_class(shown: Shown, entity: str, state: str, *classes: str) -> bool:
    """Whether a state has the colour of one of these classes."""
    values = shown.recording.static(entity, "StateConfiguration:values")
    colours = shown.recording.static(entity, "StateConfiguration:colors")
    palette = COLOURS[entity.split("/")[1]]
    return dict(zip(values, colours, strict=True)).get(state) in {palette[one] for one in classes}


def _delays(shown: Shown) -> None:
    expected = {}
    for row in shown.said.frames:
        sync = (row.get("pdo") or {}).get("sync")
        if sync and sync["delay_us"] is not None:
            expected[_pdo(row["bus"], row["node"], row["pdo"]["pdo"]), row["frame"]] = sync["delay_us"]
    found = {}
    for entity in shown.under("/sync/"):
        whose = entity.removeprefix("/sync/").replace("delay/", "")
        if "delay" in entity.split("/"):
            rows = shown.recording.rows(entity, "Scalars:scalars")
            shown.on_time(rows)
            found.update({(whose, row["frame"]): row["value"][0] for row in rows})
    assert found == {key: pytest.approx(value) for key, value in expected.items()}


def _told(shown: Shown, below: str) -> list[dict[str, Any]]:
    """Lines of all nodes, in the order of their frames."""
    rows = [row for entity in shown.under(below) for row in shown.recording.rows(entity, "TextLog:text")]
    return sorted(rows, key=lambda row: row["frame"])


def _logs(shown: Shown) -> None:
    findings = _told(shown, "/log/findings")
    shown.on_time(findings)
    at = [(row["frame"], row["value"][0]) for row in findings]
    for one in shown.said.findings:
        text = f"{one['code']}  {one['message']}"
        # One about the capture itself stands where it came up.
        place = (one["frame"], text) if one["frame"] is not None else next(row for row in at if row[1] == text)
        at.remove(place)
    assert not at
    emergencies = _told(shown, "/log/emcy")
    shown.on_time(emergencies)
    expected = [(row["frame"], row["emcy"]["code"]) for row in shown.said.frames if row.get("emcy")]
    assert [row["frame"] for row in emergencies] == [frame for frame, _ in expected]
    assert all(row["value"][0].count(f"{code}h") >= 1 for row, (_, code) in zip(emergencies, expected, strict=True))
    assert not any(row["value"][0].startswith(code) for row, (_, code) in zip(emergencies, expected, strict=True))


def _sync(shown: Shown) -> None:
    for entity in shown.under("/sync/"):
        if entity.endswith("/period"):
            rows = shown.recording.rows(entity, "Scalars:scalars")
            shown.on_time(rows)
            assert [row["sync_cycle"] for row in rows] == list(range(1, len(rows) + 1))
            for before, row in pairwise(rows):
                if not shown.stamps:
                    assert math.isnan(row["value"][0])
                    continue
                period = (shown.stamps[row["frame"]] - shown.stamps[before["frame"]]) / 1000
                assert math.isnan(row["value"][0]) or row["value"] == [pytest.approx(period)]


def _nmt(shown: Shown) -> None:
    """At a heartbeat the lane shows the state that it reports."""
    for row in shown.said.frames:
        state = (row.get("heartbeat") or {}).get("state")
        if state in NMT and row["node"]:
            entity = f"/nmt/{'/'.join(one for one in (part(row['bus'] or ''), 'node') if one)}{row['node']}"
            text = _at(shown, entity, row["frame"])
            assert text is not None, row
            assert _is_of_class(shown, entity, text, *NMT[state]), (row, text)
    for entity in shown.under("/nmt/"):
        shown.on_time(shown.recording.rows(entity, "StateChange:state"))


def _transfers(shown: Shown) -> None:
    """Each transfer begins at its first frame, in a lane of its node, in the colour of its end."""
    begun: dict[tuple[str, int], list[tuple[str, str]]] = {}
    for entity in shown.under("/sdo/"):
        rows = shown.recording.rows(entity, "StateChange:state")
        shown.on_time(rows)
        for row in rows:
            begun.setdefault((entity, row["frame"]), []).append((entity, row["value"][0]))
    for said in shown.said.transfers:
        whose = "/sdo/" + "/".join(one for one in (part(said["bus"] or ""), f"node{said['node']}") if one)
        texts = [
            one
            for (entity, frame), all_ in begun.items()
            if frame == said["first_frame"]
            for one in all_
            if entity == whose or entity.startswith(f"{whose}/")
        ]
        wanted = f"{said['index']}h:{said['sub']:02X}" if said["index"] else ""
        found = [(entity, text) for entity, text in texts if text and text.startswith(wanted)]
        assert found, said
        assert any(_is_of_class(shown, *one, said["status"]) for one in found), (said, found)


def _durations(shown: Shown) -> None:
    """Each transfer of several frames is a point at its first one, as high as it took; failed ones are apart."""
    found: dict[tuple[str, int], list[float]] = {}
    for entity in shown.under("/sdo_duration/"):
        rows = shown.recording.rows(entity, "Scalars:scalars")
        shown.on_time(rows)
        for row in rows:
            whose, frame = entity.removeprefix("/sdo_duration/"), row["frame"]
            assert (whose, frame) not in found
            found[whose, frame] = row["value"]
    assert shown.contents.transfers == len(found)
    for said in shown.said.transfers:
        first, last = (shown.stamps.get(said[name]) for name in ("first_frame", "last_frame"))
        if said["status"] not in ("ok", "aborted", "failed") or first is None or last is None:
            continue
        whose = "/".join(one for one in (part(said["bus"] or ""), f"node{said['node']}") if one)
        at = [one for one in found if f"{one[0]}/".startswith(f"{whose}/") and one[1] == said["first_frame"]]
        values = [found.pop(one) for one in at]
        if first == last:
            continue
        ((done, failed),) = values
        took, other = (done, failed) if said["status"] == "ok" else (failed, done)
        assert took == pytest.approx((last - first) / 1e6), said
        assert math.isnan(other), said
    assert not found


def _emergencies(shown: Shown) -> None:
    """After an emergency its lane shows all errors that are active."""
    for row in shown.said.frames:
        if row.get("emcy"):
            entity = f"/emcy/{'/'.join(one for one in (part(row['bus'] or ''), 'node') if one)}{row['node']}"
            text = _at(shown, entity, row["frame"]) or ""
            active = row["emcy"]["active"]
            assert all(f"{code}h" in text for code in active), (row, text)
            assert bool(text) == bool(active), (row, text)


STATUSWORDS = (
    (0x4F, 0x00, "not-ready-to-switch-on"),
    (0x4F, 0x40, "switch-on-disabled"),
    (0x6F, 0x21, "ready-to-switch-on"),
    (0x6F, 0x23, "switched-on"),
    (0x6F, 0x27, "operation-enabled"),
    (0x6F, 0x07, "quick-stop-active"),
    (0x4F, 0x0F, "fault-reaction-active"),
    (0x4F, 0x08, "fault"),
)
"""Mask, value and class of the drive's states (CiA 402)."""


def _colours(shown: Shown) -> None:
    """Every state but a value has a colour that was chosen for it, and a statusword that of the drive's state."""
    for name in ("statusword", "状态字"):
        for entity in (one for one in shown.under("/value/") if one.endswith(f"/{name}")):
            values = shown.recording.static(entity, "StateConfiguration:values")
            for state in values:
                word = int(state[:4], 16)
                for of_class in (one for mask, value, one in STATUSWORDS if word & mask == value):
                    assert _is_of_class(shown, entity, state, of_class), state
    for entity in (one for top in ("/nmt/", "/drive/", "/sdo/", "/emcy/") for one in shown.under(top)):
        states = {row["value"][0] for row in shown.recording.rows(entity, "StateChange:state")} - {""}
        assert states == set(shown.recording.static(entity, "StateConfiguration:values")), entity


def test_without_stamps(tmp_path: Path) -> None:
    path = SAMPLES / "network" / "sync-and-pdos.log"
    data = console_text(read_log(path.read_bytes()))
    shown = Shown(tmp_path, data, described_beside(path), "en")
    _check(shown)
    assert not shown.contents.timed
    assert shown.contents.plots


def test_several_buses(tmp_path: Path) -> None:
    from dataclasses import replace

    path = SAMPLES / "network" / "sync-and-pdos.log"
    frames = read_log(path.read_bytes())
    both = [one for frame in frames for one in (frame, replace(frame, bus="other", t_us=frame.t_us + 1))]
    shown = Shown(tmp_path, log_text(both), None, "zh")
    _check(shown)
    assert len(shown.contents.sync) == 2


def test_synchronous_pdos_of_unknown_mapping_have_delays(tmp_path: Path) -> None:
    """Of TPDO1 the transmission type was written, of TPDO2 nothing is known."""
    lines = ["605#2F00180201000000", "585#6000180200000000"]
    for _ in range(5):
        lines += ["080#", "185#0102030405", "285#0102"]
    text = "".join(f"(1700000000.{number:03d}000) can0 {line}\n" for number, line in enumerate(lines))
    shown = Shown(tmp_path, text.encode(), None, "en")
    _check(shown)
    rows = shown.recording.rows("/sync/can0/delay/node5/TPDO1", "Scalars:scalars")
    assert [row["value"] for row in rows] == [[1000.0]] * 5
    assert [row["sync_cycle"] for row in rows] == [1, 2, 3, 4, 5]
    assert list(shown.contents.delays) == ["/sync/can0/delay/node5/TPDO1"]
    assert not shown.contents.plots


def test_transfers_that_are_alike_are_told_apart(tmp_path: Path) -> None:
    """Back to back their lane shows one bar, and beside ten minutes it shows nothing; one that failed is apart."""
    lines, number = [], 0
    for seconds, answer in ((0.0, "4B41600037060000"), (0.0025, "4B41600037060000"), (600.0, "8041600000000206")):
        for after, frame in ((0.0, "605#4041600000000000"), (0.0012, f"585#{answer}")):
            lines.append(f"({1_700_000_000 + seconds + after:.6f}) can0 {frame}\n")
            number += 1
    shown = Shown(tmp_path, "".join(lines).encode(), None, "en")
    _check(shown)
    rows = shown.recording.rows("/sdo_duration/can0/node5", "Scalars:scalars")
    assert [row["frame"] for row in rows] == [1, 3, 5]
    assert shown.contents.transfers == 3
    assert shown.contents.brief
    names = shown.recording.static("/sdo_duration/can0/node5", "SeriesPoints:names")
    assert names == ["can0/node5 SDO transfer [ms]", "can0/node5 failed SDO transfer [ms]"]


@pytest.mark.parametrize("name", ["SDO002-timeout", "SDO030", "SYN003-late", "HBT007-rate", "LSS012", "GRD004"])
def test_a_finding_told_later_stands_with_its_frame(tmp_path: Path, name: str) -> None:
    """The frame is listed already, without it; the rows of findings, shown among the frames, have its level."""
    path = SAMPLES / "rules" / f"{name}.log"
    shown = Shown(tmp_path, path.read_bytes(), described_beside(path), "en")
    there: dict[int, set[str]] = {}
    for entity in ("/frames", *shown.under("/log/findings")):
        for row in shown.recording.rows(entity, "TextLog:level"):
            there.setdefault(row["frame"], set()).add(row["value"][0])
    assert shown.said.findings
    assert shown.contents.findings == len(shown.said.findings)
    for one in shown.said.findings:
        assert dict(SEVERITIES)[one["severity"]] in there[one["frame"]], one


def test_damaged(tmp_path: Path) -> None:
    lines = (SAMPLES / "network" / "remapping.log").read_bytes().splitlines(keepends=True)
    lines[3:3] = [b"this is no frame\n", b"\xff\xfe\x00\n"]
    lines[30] = lines[30][:20] + b"\n"
    shown = Shown(tmp_path, b"".join(lines), None, "zh")
    _check(shown)


@pytest.mark.parametrize("data", [b"", b"nothing\n"])
def test_no_frames(tmp_path: Path, data: bytes) -> None:
    shown = Shown(tmp_path, data, None, "en")
    assert verified(shown.path)
    assert not shown.contents.frames


def test_the_load(tmp_path: Path) -> None:
    path = SAMPLES / "network" / "sync-and-pdos.log"
    network = _core.Network(bitrate=500_000)
    shown = Shown(tmp_path, path.read_bytes(), network, "en")
    rows = list(_values(shown, "/load/"))
    assert all(0 <= value <= 100 for value in rows)
    assert max(rows) > 0
    assert list(shown.contents.load.values()) == [True]


def _values(shown: Shown, top: str) -> Iterator[float]:
    for entity in shown.under(top):
        for row in shown.recording.rows(entity, "Scalars:scalars"):
            yield from row["value"]


def test_the_summary(tmp_path: Path, lang: str) -> None:
    path = SAMPLES / "network" / "boot-and-states.log"
    shown = Shown(tmp_path, path.read_bytes(), described_beside(path), lang)
    words = Words(lang)
    (text,) = shown.recording.static("/summary", "TextDocument:text")
    for key in ("summary.capture", "summary.buses", "summary.nodes"):
        assert words(key) in text
    assert shown.recording.static("/summary", "TextDocument:media_type") == ["text/markdown"]
    assert shown.contents.summary
