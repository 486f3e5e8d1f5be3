"""The functions that are named as commands give what those print; drawing; short names; lists and tables.

Lists and tables are had by pyarrow, pandas and polars, and in notebooks. Must not: know what a capture means; the
commands' own tests do.
"""

from __future__ import annotations

import json
import pickle
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import can
import canopen
import pandas
import polars
import pyarrow
import pytest
from captures import SAMPLES, run_canalyze

import canalyze
from canalyze.values import ObjectRef

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


ABORTS = SAMPLES / "sdo-abort.log"
LISTS = ["frames", "transfers", "findings", "signals", "problems"]


@pytest.fixture(scope="module")
def capture() -> canalyze.Capture:
    return canalyze.open(NETWORK, eds={5: DRIVE})


def kind(of: pyarrow.DataType) -> str:
    if pyarrow.types.is_dictionary(of):
        return "word"
    if pyarrow.types.is_list(of):
        return f"list<{kind(of.value_type)}>"
    return {"double": "float64"}.get(str(of), str(of))


def test_columns_are_those_of_the_core(capture: canalyze.Capture) -> None:
    """So the list in the code, which pages show, cannot go its own way."""
    tables = capture.tables()
    assert {name.split("/")[0] for name in tables} == set(canalyze.column_tables()) - {"nodes", "events"}
    for name, table in tables.items():
        schema = table.arrow().schema
        listed = canalyze.columns(name.split("/")[0])
        fields = list(schema)[: len(listed)] if name.startswith(("pdo/", "wide/")) else list(schema)
        assert [(one.name, kind(one.type), one.nullable) for one in fields] == [
            (one.name, one.type, one.nullable) for one in listed
        ], name
    assert {one.unit for one in canalyze.columns("load")} >= {"%", "1/s", "ns", "bits"}
    with pytest.raises(ValueError, match="table='colours'"):
        canalyze.columns("colours")


@pytest.mark.parametrize("path", [NETWORK, ABORTS, SAMPLES / "services.log", SAMPLES / "stories/c01-boot-and-run.log"])
@pytest.mark.parametrize("name", LISTS)
def test_a_list_has_the_columns_of_the_table(path: Path, name: str) -> None:
    capture = canalyze.open(path, eds={5: DRIVE})
    rows = getattr(capture, name).arrow()
    table = capture.tables(name)[name]
    assert rows.num_rows == len(table)
    left_out = {
        "frames": set[str](),
        "transfers": {"raw", "first_line", "last_line"},
        "findings": set[str](),
        "signals": {"line", "data"},
        "problems": {"depth", "subject", "cycle", "end_cycle", "delay_ns", "checks", "facts"},
    }[name]
    assert set(table.column_names) - set(rows.column_names) == left_out
    order = "id" if name == "problems" else None
    for column in set(rows.column_names) - ({"facts"} if name == "findings" else set()):
        mine, theirs = rows[column].to_pylist(), table.column(column)
        if order:
            mine = [one for _, one in sorted(zip(rows[order].to_pylist(), mine, strict=True), key=lambda pair: pair[0])]
            theirs = [one for _, one in sorted(zip(table.column(order), theirs, strict=True), key=lambda pair: pair[0])]
        assert mine == theirs, column


def test_pandas_and_polars_have_the_same(capture: canalyze.Capture) -> None:
    for name in [*LISTS, "nodes", "events"]:
        rows = getattr(capture, name)
        frame, other = rows.to_pandas(), rows.to_polars()
        assert isinstance(frame, pandas.DataFrame) and isinstance(other, polars.DataFrame)
        assert len(frame) == other.height == len(rows)
        assert list(frame.columns) == other.columns == rows.arrow().column_names
    times = capture.transfers.to_pandas()["t_ns"]
    assert str(times.dtype) == "Int64" and list(times) == [one.t_ns for one in capture.transfers]
    nodes = capture.nodes.to_polars()
    assert nodes.filter(polars.col("node") == 5)["name"].to_list() == ["Servo drive"]
    assert capture.signals["5.TPDO4.velocity actual value"].to_polars()["value"].max() == 900
    assert capture.transfers.of(node=5).to_polars()["node"].unique().to_list() == [5]
    assert capture.tables("transfers")["transfers"].to_polars().height == len(capture.transfers)
    assert capture.transfers.of(node=99).to_pandas().empty


def test_events_are_a_table_of_everything(capture: canalyze.Capture) -> None:
    frame = canalyze.open(ABORTS).events.to_polars()
    assert set(frame["event"]) >= {"frame", "finding", "transfer"}
    assert frame["frame"].null_count() == 0


@pytest.mark.parametrize(
    ("library", "method"), [("pandas", "to_pandas"), ("polars", "to_polars"), ("pyarrow", "arrow")]
)
def test_what_is_not_installed_is_said(
    monkeypatch: pytest.MonkeyPatch, capture: canalyze.Capture, library: str, method: str
) -> None:
    import importlib

    real = importlib.import_module

    def without(name: str, package: str | None = None) -> Any:
        if name == library:
            raise ModuleNotFoundError(name)
        return real(name, package)

    monkeypatch.setattr(importlib, "import_module", without)
    extra = {"pyarrow": "arrow"}.get(library, library)
    for rows in (capture.transfers, capture.nodes, capture.tables("transfers")["transfers"]):
        with pytest.raises(canalyze.CanalyzeError, match=rf"{library} .*canalyze\[{extra}\]"):
            getattr(rows, method)()


def test_an_object_is_its_text_and_its_numbers(capture: canalyze.Capture) -> None:
    one = capture.transfers.of(object="1017:00")[0].object
    assert one == "1017h:00" and f"{one}" == "1017h:00" and one != "1017:00"
    assert one is not None and (one.index, one.sub) == (0x1017, 0)
    assert {str(one): 1}[one] == 1 and hash(one) == hash("1017h:00")
    assert json.dumps(one) == '"1017h:00"'
    again = pickle.loads(pickle.dumps(ObjectRef(0x6041, 1)))
    assert again == "6041h:01" and again.sub == 1
    assert capture.signals[0].object.index == int(capture.signals[0].index, 16)


def test_notebooks_show_little_and_nothing_as_code(tmp_path: Path) -> None:
    capture = canalyze.open(SAMPLES / "services.log")
    for shown in (capture, capture.events, capture.frames, capture.transfers, capture.findings, capture.nodes):
        html = shown._repr_html_()
        assert html.startswith("<table>") and html.count("<tr>") <= 11 and len(html) < 12_000
    assert f"{len(capture.events)} events" in capture.events._repr_html_()
    evil = tmp_path / "<script>.log"
    evil.write_bytes(ABORTS.read_bytes())
    opened = canalyze.open(evil)
    assert len(opened.findings) and "<script>" not in opened._repr_html_()
    assert "&lt;script&gt;" in opened._repr_html_()
    name = canopen.ObjectDictionary()  # type: ignore[no-untyped-call]
    variable = canopen.objectdictionary.ODVariable("<img src=x>", 0x2005, 0)
    variable.data_type, variable.access_type = 5, "rw"
    name.add_object(variable)
    html = canalyze.open(ABORTS, eds={10: name}).transfers._repr_html_()
    assert "&lt;img" in html and "<img" not in html
    table = capture.tables("transfers")["transfers"]
    assert table._repr_html_().startswith("<table>")


def test_an_object_dictionary_stands_for_a_file(capture: canalyze.Capture) -> None:
    given = canopen.import_od(str(DRIVE), 5)
    taken = canalyze.open(NETWORK, eds={5: given})
    assert taken.signals == capture.signals != []
    assert list(taken.transfers) == list(capture.transfers)
    assert taken.nodes[5].name == "Servo drive"
    assert taken.nodes[5].dictionary is given
    assert capture.nodes[6].dictionary is None
    both = canalyze.open(NETWORK, eds={5: given, ("vcan0", 6): given})
    assert both.nodes[6].dictionary is given
    listener = canalyze.Listener(eds={5: given})
    listener.stop()


def test_a_description_is_given_as_python_canopen_has_it(capture: canalyze.Capture) -> None:
    made = capture.nodes[5].dictionary
    read = canopen.import_od(str(DRIVE), 5)
    assert isinstance(made, canopen.ObjectDictionary) and made.node_id == 5
    assert list(made) == [index for index in read if index >= 0x1000]
    for index in made:
        mine, theirs = made[index], read[index]
        assert type(mine) is type(theirs) and mine.name == theirs.name
        for one, other in zip(variables(mine), variables(theirs), strict=True):
            facts = ("index", "subindex", "name", "data_type", "access_type", "value", "pdo_mappable")
            assert [getattr(one, fact) for fact in facts] == [getattr(other, fact) for fact in facts]
            own, its = one.default, other.default
            # What the file writes as the two's complement is the number that it stands for.
            assert own == its or (own < 0 and own + (1 << 32) == its)
    again = canalyze.open(NETWORK, eds={5: made})
    assert again.signals == capture.signals


def variables(thing: Any) -> list[Any]:
    if isinstance(thing, canopen.objectdictionary.ODVariable):
        return [thing]
    return [thing.subindices[sub] for sub in sorted(thing.subindices)]


def test_two_captures_are_compared() -> None:
    other = SAMPLES / "network/sync-and-pdos.log"
    assert not canalyze.diff(NETWORK, other)
    found = canalyze.diff(NETWORK, ABORTS)
    assert found and found.differences > 0
    run = run_canalyze(["diff", "--lang", "en", "--format", "jsonl", NETWORK, ABORTS], expected_exit=1).decode()
    assert [one["kind"] for one in found] == [json.loads(line)["kind"] for line in run.splitlines()]
    assert str(found).strip() and repr(found) == f"<Diff: {found.differences} differences>"
    assert canalyze.diff(canalyze.open(NETWORK), NETWORK.read_bytes()).differences == 0
    with pytest.raises(ValueError, match="buses='nowhere'"):
        canalyze.diff(NETWORK, ABORTS, buses=[("nowhere", "can0")])
    with pytest.raises(ValueError, match="tolerance=-1"):
        canalyze.diff(NETWORK, ABORTS, tolerance=-1)
    with pytest.raises(TypeError, match="lang: a capture"):
        canalyze.diff(canalyze.open(NETWORK), ABORTS, lang="zh")


def test_figures_are_those_of_the_command() -> None:
    figures = canalyze.summary(NETWORK)
    run = run_canalyze(["summary", "--lang", "en", "--format", "jsonl", NETWORK])
    assert list(figures) == [json.loads(line) for line in run.splitlines()]
    assert [one["node"] for one in figures.of("node")] == [5, 6, 7]
    assert str(figures) == run_canalyze(["summary", "--lang", "en", NETWORK]).decode()
    assert figures._repr_html_().startswith("<table>")
    with pytest.raises(ValueError, match="kind='colours'"):
        figures.of("colours")


def test_a_capture_is_converted(tmp_path: Path) -> None:
    assert canalyze.convert(NETWORK, "out.asc", folder=tmp_path) is not None
    assert [one.data for one in canalyze.open(tmp_path / "out.asc").frames] == [
        one.data for one in canalyze.open(NETWORK).frames
    ]
    with pytest.raises(canalyze.OutputError, match=r"out\.asc"):
        canalyze.convert(NETWORK, tmp_path / "out.asc")
    canalyze.convert(canalyze.open(NETWORK, filter="service=sync"), tmp_path / "out.asc", force=True)
    assert {one.service for one in canalyze.open(tmp_path / "out.asc").frames} == {"sync"}
    canalyze.convert(NETWORK.read_bytes(), tmp_path / "out.blf")
    assert len(canalyze.open(tmp_path / "out.blf").frames) == len(canalyze.open(NETWORK).frames)
    for out, to, said in (("out.xyz", None, "out='out.xyz'"), ("out.log", "doc", "to='doc'")):
        with pytest.raises(ValueError, match=said):
            canalyze.convert(NETWORK, out, to=to, folder=tmp_path)
    with pytest.raises(canalyze.OutputError, match=r"out\.asc"):
        canalyze.convert(tmp_path / "out.asc", tmp_path / "out.asc", force=True)
    with pytest.raises(canalyze.SourceError):
        canalyze.convert(SAMPLES / "README.md", tmp_path / "none.asc")
    assert not (tmp_path / "none.asc").exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.asc", "out.blf"]


def test_rules_are_there_in_both_languages() -> None:
    english, chinese = canalyze.rules(), canalyze.rules("zh")
    assert [one.code for one in english] == [one.code for one in chinese]
    assert english[0].meaning.isascii() and not chinese[0].meaning.isascii()
    with pytest.raises(ValueError, match="lang='de'"):
        LIBRARY.rules("de")


def test_nothing_of_it_prints(capfd: pytest.CaptureFixture[str]) -> None:
    canalyze.diff(NETWORK, ABORTS)
    canalyze.summary(NETWORK)
    canalyze.rules()
    assert capfd.readouterr() == ("", "")
