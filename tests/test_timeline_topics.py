"""The layout for an MCAP's own topics: what it draws is there, and right, when Rerun itself reads the file."""

from __future__ import annotations

import importlib
import json
import os
import re
import socket
import subprocess
import time
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from captures import SAMPLES
from conftest import Done, Runner
from test_mcap_writing import NETWORK, definitions

pytest.importorskip("rerun.chunk")

from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from canalyze.cli import main

RERUN = str(Path(str(importlib.import_module("rerun_cli").__file__)).with_name("rerun"))
SERVICES = SAMPLES / "services.log"
NAMED = [("sync-and-pdos", "en"), ("drive-states", "zh"), ("remapping", "zh"), ("multiplex-and-safety", "en")]


class Drawn(NamedTuple):
    """What a view draws: a field of an entity's messages, as what."""

    entity: str
    target: str
    component: str
    name: str


@pytest.fixture
def strict(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the library raise what it would only warn of."""
    monkeypatch.setenv("RERUN_STRICT", "1")


@pytest.fixture
def view(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Runner:
    """Run a command line in this process, which has loaded Rerun; as the fixture `canalyze` does otherwise."""
    monkeypatch.chdir(tmp_path)

    def run(*args: str) -> Done:
        capfd.readouterr()
        code = main(args)
        return Done(code, *capfd.readouterr())

    return run


def made(canalyze: Runner, capture: Path, lang: str = "en") -> None:
    """Write out.mcap and its layout."""
    done = canalyze("--lang", lang, "convert", "--decoded", *NETWORK, str(capture), "out.mcap")
    assert done.code == 0, done.err
    done = canalyze("--lang", lang, "view", "out.mcap", "--save", "out.rbl")
    assert (done.code, done.out) == (0, "")
    assert done.complaints[-1].endswith("rerun --bind 127.0.0.1 out.mcap - < out.rbl")


def drawn(layout: Path) -> list[Drawn]:
    """Give what the views of a layout draw out of messages."""
    reader = RrdReader(str(layout))
    (store,) = reader.blueprints()
    assert store.application_id == layout.stem
    found = []
    for chunk in reader.stream(store=store):
        batch = chunk.to_record_batch()
        if "VisualizerInstruction:component_map" in batch.schema.names:
            entity = re.sub(r"^/view/[^/]+/ViewContents/overrides|/visualizers/[^/]+$", "", chunk.entity_path)
            for one in batch.column("VisualizerInstruction:component_map")[0].as_py():
                found.append(Drawn(entity, one["target"], one["source_component"], one["selector"].lstrip(".")))
    return found


def converted(folder: Path) -> dict[str, list[tuple[int, dict[str, Any]]]]:
    """Give the messages of each entity as Rerun itself reads the file: times and fields."""
    command = [RERUN, "mcap", "convert", "out.mcap", "--application-id", "out", "-o", "out.rrd"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=60)
    reader = RrdReader(str(folder / "out.rrd"))
    (store,) = reader.recordings()
    found: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    for chunk in reader.stream(store=store):
        batch = chunk.to_record_batch()
        if chunk.is_static or "message_log_time" not in batch.schema.names:
            continue
        times = batch.column("message_log_time").cast("int64").to_pylist()
        name = batch.schema.names[-1]
        for at, row in zip(times, batch.column(name).to_pylist(), strict=True):
            found.setdefault(chunk.entity_path, []).append((at, {"": name, **(row[0] if name[-1] == "e" else {})}))
    return found


@pytest.mark.parametrize(("name", "lang"), NAMED)
@pytest.mark.usefixtures("strict")
def test_what_is_drawn_is_in_the_file(name: str, lang: str, canalyze: Runner, tmp_path: Path) -> None:
    capture = SAMPLES / "network" / f"{name}.log"
    made(canalyze, capture, lang)
    lines = drawn(tmp_path / "out.rbl")
    assert lines
    rows = converted(tmp_path)
    fields = definitions((tmp_path / "out.mcap").read_bytes())
    truth = signals(canalyze, capture, lang)
    shown: set[tuple[str, ...]] = set()
    for one in set(lines):
        assert {row[""] for _, row in rows[one.entity]} == {one.component}
        values = [(at, row[one.name]) for at, row in rows[one.entity]]
        if one.target == "Scalars:scalars":
            place = re.fullmatch(r"/(.*)/node(\d+)/([tr]pdo\d+)(?:_v\d+)?(?:/\w+)?", one.entity)
            assert place
            (address,) = (address for address, field in fields[one.entity].items() if field == one.name)
            key = (place[1], place[2], place[3].upper(), address)
            shown.add(key)
            for at, value in values:
                assert value == pytest.approx(truth[key][at], rel=1e-6)
        elif one.target == "StateChange:state":
            assert all(isinstance(value, str | bool) for _, value in values)
        else:
            assert one.target in ("TextLog:text", "TextLog:level")
            assert all(value and isinstance(value, str) for _, value in values)
    # What is no line is a state, with words of its own or true and false.
    words = {f"{one.entity} {one.name.removesuffix('_text')}" for one in lines if one.target == "StateChange:state"}
    for topic, known in fields.items():
        for address, field in known.items():
            bus, node, pdo = topic.split("/")[1:4]
            key = (bus, node[4:], re.sub("_V.*", "", pdo.upper()), address)
            assert key in shown or f"{topic} {field}" in words or not is_number(truth[key])


def signals(canalyze: Runner, capture: Path, lang: str) -> dict[tuple[str, ...], dict[int, float]]:
    """Give each signal's values by their times, from `signals --format jsonl`."""
    done = canalyze("--lang", lang, "signals", "--format", "jsonl", *NETWORK, str(capture))
    found: dict[tuple[str, ...], dict[int, float]] = {}
    for row in map(json.loads, done.out.splitlines()):
        if row["kind"] == "signal":
            key = (row["bus"], str(row["node"]), row["pdo"], f"{row['index']}:{row['sub']:02X}")
            try:
                value = float(row["value"])
            except ValueError:
                value = float("nan")
            found.setdefault(key, {})[int(Decimal(row["t"]) * 10**9)] = value
    return found


def is_number(values: dict[int, float]) -> bool:
    return any(value == value for value in values.values())


def test_states_have_their_colours(view: Runner, tmp_path: Path) -> None:
    made(view, SAMPLES / "network" / "drive-states.log", "zh")
    reader = RrdReader(str(tmp_path / "out.rbl"))
    (store,) = reader.blueprints()
    colours: dict[str, int] = {}
    for chunk in reader.stream(store=store):
        batch = chunk.to_record_batch()
        if "StateConfiguration:values" in batch.schema.names:
            values = batch.column("StateConfiguration:values")[0].as_py()
            colours |= dict(zip(values, batch.column("StateConfiguration:colors")[0].as_py(), strict=True))
    assert colours["故障"] == colours["停止状态"] != colours["操作状态"] == colours["运行使能"]


def test_log_and_transfers(view: Runner, tmp_path: Path) -> None:
    made(view, SERVICES)
    rows = converted(tmp_path)
    assert {row[""] for _, row in rows["/log"]} == {"TextLog:text"} or "/log" in rows
    texts = {one for one in drawn(tmp_path / "out.rbl") if one.target == "TextLog:text"}
    assert {one.entity for one in texts} == {entity for entity in rows if entity.endswith("/sdo")}
    (first, *_) = (row for _, row in rows["/can0/node10/sdo"])
    assert first["text"].startswith(f"{first['index']:04X}h:{first['sub']:02X} = ")


def test_files_that_have_none(view: Runner, tmp_path: Path) -> None:
    view("convert", str(SERVICES), "frames.mcap")
    whole = (tmp_path / "frames.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.mcap").write_text("no MCAP\n")
    for name in ("frames.mcap", "cut.mcap", "text.mcap", "none.mcap", "."):
        done = view("--lang", "en", "view", name, "--save", "out.rbl")
        (line,) = done.complaints
        assert done.code == 2 and line.startswith(f"canalyze: {name}"), done.err
    assert not list(tmp_path.glob("out.rbl*"))


def test_usage(view: Runner, tmp_path: Path) -> None:
    for names in (["a.mcap", "b.mcap"], ["-"]):
        done = view("--lang", "en", "view", *names, "--save", "out.rbl")
        assert done.code == 2 and "from a single MCAP" in done.err
    made(view, SERVICES)
    before = (tmp_path / "out.rbl").read_bytes()
    done = view("--lang", "en", "view", "out.mcap", "--save", "out.rbl")
    assert done.code == 2 and "--force" in done.err and (tmp_path / "out.rbl").read_bytes() == before
    assert view("view", "out.mcap", "--save", "out.rbl", "--force").code == 0
    assert view("view", "out.mcap", "--save", "out.rbl", "--web").code == 2


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def test_viewer_draws_it(view: Runner, tmp_path: Path) -> None:
    """By the command line of the manual, without a window: every view draws, none reports a fault."""
    made(view, SAMPLES / "network" / "sync-and-pdos.log")
    port = free_port()
    command = [RERUN, "--bind", "127.0.0.1", "--port", str(port), "--headless", "out.mcap", "-"]
    environment = {**os.environ, "CI": "1", "XDG_RUNTIME_DIR": str(tmp_path)}
    with (
        (tmp_path / "out.rbl").open("rb") as layout,
        (tmp_path / "said").open("wb") as said,
        subprocess.Popen(command, cwd=tmp_path, stdin=layout, stdout=said, stderr=said, env=environment) as viewer,
    ):
        try:
            views = shown(viewer, f"rerun+http://127.0.0.1:{port}/proxy")
        finally:
            viewer.kill()
    log = (tmp_path / "said").read_text()
    if views is None and "panicked" not in log:
        pytest.skip("the viewer does not run here: no Vulkan driver")
    assert views is not None and "panicked" not in log, log
    assert {view.view_class for view in views} == {"StateTimeline", "TimeSeries", "TextLog"}
    assert [report for view in views for report in view.reports] == []


def shown(viewer: subprocess.Popen[bytes], address: str) -> list[Any] | None:
    """Give the views when they have had time to draw; None where the viewer ends by itself."""
    until = time.monotonic() + 60
    while time.monotonic() < until and viewer.poll() is None:
        try:
            client = ViewerClient.connect(address)
            state = client.get_state()
        except (ConnectionError, TimeoutError):
            time.sleep(0.2)
            continue
        if state.recordings and state.views and not state.loading:
            time.sleep(2)
            return list(client.get_state().views)
        time.sleep(0.2)
    return None
