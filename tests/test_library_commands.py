"""The functions that are named as commands give what those print; drawing; short names.

Must not: know what a capture means; the commands' own tests do.
"""

from __future__ import annotations

import json
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import can
import pytest
from captures import SAMPLES, run_canalyze

import canalyze

PROBLEMS = SAMPLES / "problems.log"
SERVICES = SAMPLES / "services.log"
NETWORK = SAMPLES / "network/sync-and-pdos.log"
STORIES = sorted((SAMPLES / "stories").glob("*.log"))[::6]
DRIVE = SAMPLES.parent / "eds/drive.eds"
LIBRARY: Any = canalyze
"""Without types: what a program that has none may do."""


def printed(*arguments: str | Path, lang: str = "en") -> str:
    return run_canalyze([*arguments, "--lang", lang], folder=SAMPLES).decode()


@pytest.mark.parametrize("lang", ["en", "zh"])
@pytest.mark.parametrize("path", [PROBLEMS, SERVICES, *STORIES], ids=lambda path: path.name)
def test_a_diagnosis_is_that_of_the_command(path: Path, lang: Any) -> None:
    name = str(path.relative_to(SAMPLES))
    found = canalyze.diagnose(name, folder=SAMPLES, lang=lang)
    shown = printed("diagnose", name, lang=lang)
    # The names of files are shown from where each runs.
    bare = re.compile(rf"\S*{re.escape(path.name)}")
    assert bare.sub("F", str(found)) == bare.sub("F", shown)
    rows = [json.loads(line) for line in printed("diagnose", "--format", "jsonl", name, lang=lang).splitlines()]
    assert {one.id for one in found.problems} == {row["id"] for row in rows}
    roots = {row["id"] for row in rows if row["cause"] is None and row["status"] != "harmless"}
    assert {one.id for one in found} == roots and bool(found) == bool(roots)


def test_a_diagnosis_has_what_is_open() -> None:
    with canalyze.open(PROBLEMS) as capture:
        found = canalyze.diagnose(capture)
        assert [one.kind for one in found.open] == ["node-silent"]
        assert [one.status for one in found] == ["open", "ended"] and len(found.problems) > len(found) == 2
        assert found.problems == capture.problems
    assert repr(found) == f"<Diagnosis: {str(found).splitlines()[0]}>"
    assert not canalyze.diagnose(NETWORK)


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("705#7F", "705#7F"),
        ("inhibit time", "inhibit time"),
        (0x05040001, "05040001"),
        (0x1017, "1017h"),
        (0x182, "182h"),
        (0x8130, "8130h"),
        (can.Message(arbitration_id=0x705, data=[0x7F], is_extended_id=False), "705#7F"),
        (can.Message(arbitration_id=0x12345, data=[1, 2]), "00012345#0102"),
        (can.Message(arbitration_id=0x705, is_remote_frame=True, dlc=1, is_extended_id=False), "705#R1"),
        (
            can.Message(arbitration_id=0x185, data=[1], is_fd=True, bitrate_switch=True, is_extended_id=False),
            "185##101",
        ),
    ],
    ids=str,
)
def test_an_explanation_is_that_of_the_command(what: Any, said: str) -> None:
    assert canalyze.explain(what) + "\n" == printed("explain", said)


def test_a_frame_of_a_capture_is_explained_by_the_description_of_its_node() -> None:
    frame = next(one for one in canalyze.open(NETWORK).frames if one.id == 0x605)
    text = f"605#{frame.data.hex().upper()}"
    assert canalyze.explain(frame) == canalyze.explain(text) != canalyze.explain(text, lang="zh")
    described = canalyze.explain("605#4002200000000000", eds={5: DRIVE})
    assert described + "\n" == printed("explain", "605#4002200000000000", "--eds", f"5={DRIVE}")


def test_what_cannot_be_explained_says_so() -> None:
    for what in ("no such thing", "705#ZZ", -1):
        with pytest.raises(ValueError, match=r"\w"):
            canalyze.explain(what)
    with pytest.raises(TypeError, match="NoneType"):
        LIBRARY.explain(None)


@pytest.mark.parametrize("at", [None, 0.0, 0.3])
def test_an_inventory_is_that_of_the_command(at: float | None) -> None:
    found = canalyze.od(SERVICES, at=at)
    further = [] if at is None else ["--at", str(at)]
    rows = [json.loads(line) for line in printed("od", "--format", "jsonl", SERVICES, *further).splitlines()]
    assert [*found] == [row for row in rows if row["kind"] == "od_object"]
    assert [*found.nodes] == [row for row in rows if row["kind"] == "od_node"]
    assert str(found) == printed("od", SERVICES, *further)
    assert repr(found) == f"<Inventory: {len(found)} objects of {len(found.nodes)} nodes>"


def test_an_inventory_in_chinese() -> None:
    assert str(canalyze.od(SERVICES, lang="zh")) == printed("od", SERVICES, lang="zh")
    with pytest.raises(ValueError, match="at=-1"):
        canalyze.od(SERVICES, at=-1)


def test_objects_are_named_by_texts_or_integers() -> None:
    found = canalyze.od(SERVICES)
    (register,) = found.of(node=10, object=0x1001)
    assert (register["index"], register["value"]) == ("1001", 0)
    assert found.of(object=(0x1A00, 0)) == found.of(object="1A00:00") != [] == found.of(object=(0x1A00, 1))
    assert found.of(bus="can1") == found.of(node=5) != []
    transfers = canalyze.open(NETWORK).transfers
    assert transfers.of(object=0x1017) == transfers.of(object="1017") != []
    assert transfers.of(object=(0x1017, 0)) == transfers.of(object="1017:00")
    one = transfers[0]
    assert one.object is not None and one in transfers.of(object=(one.object.index, one.object.sub))
    assert one in transfers.of(object=one.object)


@pytest.mark.parametrize("value", [-1, 1017, 0x10000, (0x1017, 256), (-1, 0), "17", ""])
def test_numbers_that_are_no_object(value: Any) -> None:
    with pytest.raises(ValueError, match=r"written 1018:01"):
        canalyze.open(NETWORK).transfers.of(object=value)


@pytest.mark.parametrize("value", [1.5, True, (1,), (1, 2, 3), ("1017", 0), b"1017"])
def test_what_is_neither_text_nor_integers(value: Any) -> None:
    with pytest.raises(TypeError, match="a text or integers are needed"):
        LIBRARY.open(NETWORK).transfers.of(object=value)


# Drawing.


class Axes:
    """Takes what matplotlib's axes would be given."""

    x: list[Any]
    y: list[Any]
    options: dict[str, Any]
    labels: tuple[str, ...] = ()

    def step(self, x: list[Any], y: list[Any], **options: Any) -> None:
        self.x, self.y, self.options = x, y, options

    def set_xlabel(self, text: str) -> None:
        self.labels += (text,)

    set_ylabel = set_xlabel


def speed(path: Path = NETWORK, **options: Any) -> canalyze.Series:
    return canalyze.open(path, eds={5: DRIVE}, **options).signals["5.TPDO4.velocity actual value"]


def test_a_series_has_its_times_in_seconds() -> None:
    series = speed()
    assert len(series.times) == len(series) and series.times == [row.t_s for row in series]
    assert [round((time or 0) * 1e6) for time in series.times] == [(ns or 0) // 1000 for ns in series.times_ns]


def test_a_series_is_drawn_over_its_times(tmp_path: Path) -> None:
    series, axes = speed(), Axes()
    drawn: Any = series.plot(axes, color="red")
    assert drawn is axes and axes.y == series.values and axes.labels == ("UTC", "rpm")
    assert axes.x[0] == datetime.fromtimestamp(series.times[0] or 0, UTC)
    assert axes.options == {"where": "post", "label": series.name, "color": "red"}

    text = NETWORK.read_text()
    (tmp_path / "zero.log").write_text(re.sub(r"\(17952320(\d\d\.)", r"(\1", text))
    series, axes = speed(tmp_path / "zero.log"), Axes()
    series.plot(axes)
    assert axes.x == series.times and axes.labels == ("s", "rpm")

    (tmp_path / "bare.log").write_text("".join(re.sub(r"^\(\S+\) ", "", line) for line in text.splitlines(True)))
    series, axes = speed(tmp_path / "bare.log"), Axes()
    series.plot(axes)
    assert series.times == [None] * len(series) and axes.x == series.frames and axes.labels[0] == "frame"


def test_a_series_without_numbers_cannot_be_drawn() -> None:
    with pytest.raises(ValueError, match="no value is a number"):
        speed()[:0].plot(Axes())


def test_a_series_is_drawn_by_matplotlib() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    axes = speed().plot()
    assert len(axes.lines) == 1


def test_without_matplotlib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(canalyze.CanalyzeError, match=r"canalyze\[plot\]"):
        speed().plot()


# Names.


def test_what_is_shown_of_an_object_is_one_short_line() -> None:
    capture = canalyze.open(PROBLEMS)
    shown = [capture, capture.problems[0], *capture.findings[:1], *capture.transfers[:1], *capture.events[:1]]
    with canalyze.Listener() as listener:
        assert repr(listener) == "<Listener: listening, 0 frames>"
    assert repr(listener) == "<Listener: stopped, 0 frames>"
    for one in [*shown, capture.findings[:1], canalyze.diagnose(capture), canalyze.od(capture), capture.nodes]:
        assert "\n" not in repr(one) and len(repr(one)) < 200
    assert repr(capture.problems[0]).startswith("<Problem 1 node-silent, open, frame 126: node 9: silent")
    assert repr(capture.findings[:1]).startswith("<1 finding: ")


def test_a_change_of_a_problem_is_one_short_line() -> None:
    with canalyze.Listener() as listener:
        for message in can.LogReader(PROBLEMS):
            listener(message)
        change = next(one for one in listener.take() if isinstance(one, canalyze.ProblemChange))
    assert (
        repr(change).startswith(f"<ProblemChange {change.id} {change.kind} opened, frame ") and len(repr(change)) < 200
    )


def test_own_messages_are_received_only_if_the_bus_says_so() -> None:
    """As the page and `Listener` say: without them a response has no request."""
    for own in (False, True):
        with (
            can.Bus(f"own-{own}", interface="virtual", receive_own_messages=own) as bus,
            can.Bus(f"own-{own}", interface="virtual") as device,
            canalyze.Listener() as listener,
        ):
            request = can.Message(arbitration_id=0x605, data=bytes.fromhex("4017100000000000"), is_extended_id=False)
            response = can.Message(arbitration_id=0x585, data=bytes.fromhex("4B17100064000000"), is_extended_id=False)
            bus.send(request)
            device.send(response)
            while (message := bus.recv(0.5)) is not None:
                listener(message)
            listener.stop()
            frames = [one for one in listener.take() if isinstance(one, canalyze.Frame)]
        assert [one.id for one in frames] == ([0x605, 0x585] if own else [0x585])
