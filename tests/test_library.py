"""canalyze.open and what a capture has: lists, series, nodes, complaints, and that nothing is written or left open."""

import gc
import gzip
import json
import pickle
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from captures import SAMPLES, run_canalyze
from msgspec.structs import fields, replace

import canalyze
from canalyze.library import Options
from canalyze.values import nanoseconds

DRIVE = SAMPLES.parent / "eds/drive.eds"
NETWORK = SAMPLES / "network/sync-and-pdos.log"
ABORTS = SAMPLES / "sdo-abort.log"
WELL_READ = [*SAMPLES.glob("*.log"), *SAMPLES.glob("*.mcap"), *SAMPLES.glob("*.asc"), *SAMPLES.glob("network/*.log")]


@pytest.mark.parametrize("path", WELL_READ, ids=lambda path: path.name)
def test_events_are_those_of_the_command(path: Path) -> None:
    rows = [
        json.loads(line) for line in run_canalyze(["decode", "--lang", "en", "--format", "jsonl", path]).splitlines()
    ]
    events = list(canalyze.open(path))
    kinds = {canalyze.Frame: "frame", canalyze.Note: "note", canalyze.Finding: "finding", canalyze.Transfer: "transfer"}
    assert [kinds[type(event)] for event in events] == [row["kind"] for row in rows]
    for event, row in zip(events, rows, strict=True):
        if isinstance(event, canalyze.Frame):
            assert (event.frame, event.t, event.text, event.data.hex().upper()) == (
                *(row["frame"], row["t"], row["text"]),
                row["data"],
            )
            assert (event.id, event.fields) == (int(row["id"], 16), row.get(row["service"], {}))


def test_lists_are_those_of_iterating() -> None:
    capture = canalyze.open(ABORTS)
    events = list(capture)
    assert list(capture.transfers) == [one for one in events if isinstance(one, canalyze.Transfer)]
    findings = [replace(one, lines=()) for one in capture.findings]
    assert findings == [one for one in events if isinstance(one, canalyze.Finding)]
    assert list(capture.frames) == [one for one in events if isinstance(one, canalyze.Frame)]
    assert capture.events == events
    assert list(capture) == events  # now out of the list


def test_transfers_are_found() -> None:
    transfers = canalyze.open(NETWORK).transfers
    (one,) = transfers.of(node=5, object="1017:00", direction="download")
    assert (one.object, one.value, one.data, one.status, one.duration) == ("1017h:00", 100, b"d\0", "ok", 0.000384)
    assert one.t_ns == 1795232031698520000
    assert transfers.of(object="0x1017") == transfers.of(object="1017h:0") != transfers.of(object="1017:01")
    assert transfers.of(object="0x1017:0x00") == transfers.of(object="1017:00")  # as in expectations
    assert len(transfers.of(object="1017")) == 3
    assert transfers.of(bus="nowhere") == [] == transfers.of(status="failed")
    with pytest.raises(ValueError, match="1018:01"):
        transfers.of(object="17")


def test_an_abort_is_typed() -> None:
    one = canalyze.open(ABORTS).transfers[0]
    assert one.abort is not None
    assert (one.status, one.value, one.abort.code, one.abort.by) == ("aborted", None, 0x06010002, "server")
    assert str(one.abort) == "06010002h by the server: attempt to write a read-only object"


def test_findings_are_found() -> None:
    findings = canalyze.open(ABORTS).findings
    assert {one.severity for one in findings} == {"info", "warning", "error"}
    assert {one.severity for one in findings.at_least("warning")} == {"warning", "error"}
    assert {one.code for one in findings.of("sdo001")} == {"SDO001"}
    assert findings.of("SDO") == findings
    assert findings[:2] == list(findings)[:2]
    assert not findings.of("HBT")


def test_signals_are_those_of_the_command() -> None:
    arguments: list[str | Path] = ["signals", "--lang", "en", "--format", "jsonl", "--eds", f"5={DRIVE}", NETWORK]
    rows = [json.loads(line) for line in run_canalyze(arguments).splitlines()]
    signals = canalyze.open(NETWORK, eds={5: DRIVE}).signals
    names = [one.name for one in fields(canalyze.Signal)]
    assert [[getattr(one, name) for name in names] for one in signals] == [
        [row[name] for name in names] for row in rows
    ]


def test_a_signal_is_a_series() -> None:
    signals = canalyze.open(NETWORK, eds={5: DRIVE}).signals
    series = signals["5.TPDO4.velocity actual value"]
    assert (series.min, series.max, series.last, series.unit, len(series)) == (-900, 900, -900, "rpm", 34)
    assert len(series.values) == len(series.times_ns) == len(series.frames) == 34
    assert series.times_ns == sorted(time for time in series.times_ns if time is not None)
    assert signals["velocity actual value"] == series == signals["5.606c:00"] == signals["vcan0:5.tpdo4.606ch:00"]
    assert series.name in signals.names
    with pytest.raises(KeyError, match=r"no signal '5\.velocity'; there are 5\.TPDO4\.velocity actual value"):
        signals["5.velocity"]
    with pytest.raises(KeyError, match=r"several signals: .*5\.TPDO1\.statusword, 5\.TPDO2\.statusword"):
        signals["5.statusword"]


def test_nodes_have_states_and_figures() -> None:
    nodes = canalyze.open(NETWORK, eds={5: DRIVE}).nodes
    node = nodes[5]
    assert [change.state for change in node.states] == ["boot-up", "operational", "pre-operational"]
    assert (node.state, node.boot_ups, node.name, node.error_control) == (
        "pre-operational",
        1,
        "Servo drive",
        "heartbeat",
    )
    assert node.heartbeat is not None and node.heartbeat.max_us == 100230
    assert (node.transfers, node.ok, node.emcy_count) == (9, 9, 0)
    assert [one.node for one in nodes] == [5, 6, 7]
    assert nodes["vcan0", 6] is nodes[6]
    assert 5 in nodes and ("vcan0", 5) in nodes and 9 not in nodes
    with pytest.raises(KeyError, match=r"no node 9; nodes: 5, 6, 7"):
        nodes[9]


def test_a_node_on_two_buses_needs_its_bus() -> None:
    nodes = canalyze.open([NETWORK, SAMPLES / "services.log"]).nodes
    with pytest.raises(KeyError, match=r'several buses: \["vcan0", 5\], \["can1", 5\]'):
        nodes[5]
    assert nodes["can1", 5].bus == "can1"


def test_emcys_are_in_nodes(tmp_path: Path) -> None:
    (tmp_path / "emcy.log").write_text("(1.0) can0 085#3081110000000000\n(1.1) can0 085#0000000000000000\n")
    node = canalyze.open(tmp_path / "emcy.log").nodes[5]
    assert node.emcy_count == 2
    assert [(one.code, one.count, one.first_frame) for one in node.emcys if one.code] == [(0x8130, 1, 1)]


def test_lines_are_those_of_the_command() -> None:
    decoded = run_canalyze(["decode", "--lang", "en", NETWORK]).decode().splitlines()
    capture = canalyze.open(NETWORK)
    assert [line.text for line in capture.lines(1, 10)] == decoded[:10]
    assert [line.frame for line in capture.annotated([(8, 9), (2, 3)])] == [2, 3, 8, 9]
    assert capture.lines(100_000) == [] == capture.annotated([])


def test_finding_a_frame_ignores_the_filter() -> None:
    capture = canalyze.open(NETWORK, filter="service=sync")
    assert {frame.service for frame in capture.frames} == {"sync"}
    assert capture.lines(1)[0].text.endswith("boot-up of node 5")


def test_several_files_are_one_capture(tmp_path: Path) -> None:
    lines = NETWORK.read_text().splitlines(keepends=True)
    (tmp_path / "one.log").write_text("".join(lines[:100]))
    (tmp_path / "two.log.gz").write_bytes(gzip.compress("".join(lines[100:]).encode()))
    whole = canalyze.open(NETWORK)
    parts = canalyze.open(["one.log", "two.log.gz"], folder=tmp_path)
    assert [one.text for one in parts.transfers] == [one.text for one in whole.transfers]
    turned = canalyze.open(["two.log.gz", "one.log"], folder=tmp_path, merge=True)
    assert [one.text for one in turned.frames] == [one.text for one in whole.frames]


def test_what_cannot_be_opened_is_said(tmp_path: Path) -> None:
    (tmp_path / "empty.log").write_bytes(b"")
    (tmp_path / "other.txt").write_text("what is this\n" * 30)
    with pytest.raises(canalyze.SourceError, match="no such file"):
        canalyze.open("missing.log", folder=tmp_path)
    with pytest.raises(canalyze.SourceError, match="directory"):
        canalyze.open(tmp_path)
    with pytest.raises(canalyze.SourceError, match=r"missing\.eds"):
        canalyze.open(NETWORK, eds={5: "missing.eds"}, folder=tmp_path)
    for name in ("empty.log", "other.txt"):
        capture = canalyze.open(name, folder=tmp_path)
        for ask in ("transfers", "findings", "nodes", "signals", "events", "complaints"):
            with pytest.raises(canalyze.SourceError, match=name):
                getattr(capture, ask)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"filter": "colour=red"}, "colour=red"),
        ({"eds": {200: "x.eds"}}, "option eds 200: node-IDs are 1 to 127"),
        ({"eds": ["x=y=z"]}, "eds"),
        ({"eds": [5]}, "eds"),
        ({"cob": ["xyz"]}, "cob"),
        ({"sdo": ["640=5"]}, "sdo"),
        ({"bitrate": "125"}, "bitrate"),
        ({"sync_period": "0"}, "sync_period"),
        ({"jitter": -1}, "jitter"),
        ({"lang": "de"}, "lang"),
        ({"stamps": "odd"}, "stamps"),
        ({"input_format": "doc"}, "input_format"),
        ({"time_source": "clock"}, "time_source"),
        ({"mcap_map": ["x"]}, "x"),
    ],
)
def test_options_that_cannot_be_are_refused_at_once(options: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        canalyze.open(NETWORK, **options)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no file"):
        canalyze.open([])


def test_damage_and_unreadable_lines_are_complaints(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    text = NETWORK.read_bytes()
    (tmp_path / "odd.log").write_bytes(text + b"(1.0) vcan0 nonsense\n")
    (tmp_path / "cut.log.gz").write_bytes(gzip.compress(text)[:-200])
    (tmp_path / "odd.eds").write_text(
        "[FileInfo]\n[1000]\nParameterName=x\nObjectType=7\nDataType=0x7\nAccessType=zz\n"
    )
    odd = canalyze.open("odd.log", folder=tmp_path)
    assert [line for line in odd.complaints if "330" in line]
    assert odd.findings.of("CAP001")
    cut = canalyze.open("cut.log.gz", folder=tmp_path)
    assert cut.findings.of("CAP") and cut.complaints
    assert canalyze.open(NETWORK).complaints == ()
    assert canalyze.open(NETWORK, eds={5: tmp_path / "odd.eds"}).complaints
    assert capfd.readouterr() == ("", "")


def test_names_for_people_are_short_and_files_are_found_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "one.log").write_bytes(ABORTS.read_bytes())
    monkeypatch.chdir(tmp_path)
    capture = canalyze.open("one.log")
    monkeypatch.chdir("/")
    assert capture.name == "one.log" == capture.findings[0].file
    assert repr(capture) == "<Capture one.log>"


def test_nothing_of_the_folder_or_environment_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "canalyze.toml").write_text(f'lang = "zh"\n[[eds]]\nnode = 5\nfile = "{DRIVE.as_posix()}"\n')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CANALYZE_LANG", "zh")
    assert "5.TPDO4.velocity actual value" not in canalyze.open(NETWORK).signals.names
    asked = canalyze.open(NETWORK, config="canalyze.toml")
    assert "5.TPDO4.velocity actual value" in asked.signals.names
    # Names are keys: they are the same in every language.
    assert canalyze.open(NETWORK, config="canalyze.toml", lang="zh").signals.names == asked.signals.names
    (tmp_path / "canalyze.toml").write_text("nonsense = 1\n")
    with pytest.raises(canalyze.ConfigError, match="nonsense"):
        canalyze.open(NETWORK, config="canalyze.toml")


def test_iterating_leaves_no_file_open() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        capture = canalyze.open(NETWORK)
        with capture:
            events = iter(capture)
            first = next(events)
            assert isinstance(first, canalyze.Frame) and first.frame == 1
        assert list(events) == []
        for _ in capture:
            break
        del events
        gc.collect()
    assert len(capture.transfers) == 63


def test_signals_of_the_system_are_let_alone() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    found: list[int] = []
    for _ in canalyze.open(NETWORK):
        assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before
        break
    thread = threading.Thread(target=lambda: found.append(len(canalyze.open(NETWORK).transfers)))
    thread.start()
    thread.join()
    assert found == [63]


def test_importing_is_light() -> None:
    code = "import sys, canalyze; print([name for name in sys.modules if name.startswith('canalyze.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert done.stdout.strip() == "[]"


def test_public_names_are_there() -> None:
    for name in canalyze.__all__:
        assert getattr(canalyze, name) is not None
        assert getattr(canalyze, name).__doc__ or name == "__version__" or name == "Event"
    assert set(canalyze.__all__) <= set(dir(canalyze))
    with pytest.raises(AttributeError):
        canalyze.nothing  # noqa: B018


def test_options_are_those_of_open() -> None:
    hints = [name for name in canalyze.open.__annotations__ if name not in ("source", "return")]
    assert hints == list(Options.__annotations__)
    described = (canalyze.open.__doc__ or "").replace(",", " ").replace(":", " ").split()
    assert all(name in described for name in hints)


@pytest.mark.parametrize(
    ("text", "ns"),
    [("1.5", 1_500_000_000), ("-0.000001", -1000), ("1795232031.698520", 1795232031698520000), ("3", 3_000_000_000)],
)
def test_times_are_exact(text: str, ns: int) -> None:
    assert nanoseconds(text) == ns


def test_rows_are_shown_short() -> None:
    capture = canalyze.open(ABORTS)
    assert repr(capture.findings.of("SDO012")) == "<1 finding: error SDO012 at frame 47>"
    assert repr(capture.transfers.of(node=1)) == "<0 transfers>"
    assert repr(capture.transfers[0]) == "<Transfer 1: node 10 download 2005h:00 aborted 06010002h, frames 1-2>"
    assert repr(canalyze.open(NETWORK).nodes) == "<3 nodes: 5 pre-operational, 6 pre-operational, 7 pre-operational>"


def test_one_of_everything_is_shown_in_a_line() -> None:
    capture = canalyze.open(NETWORK, eds={5: DRIVE})
    assert repr(capture.frames[3]).startswith(
        "<Frame 4: 605 [8] 2B 17 10 00 64 00 00 00: SDO request sent by the client: write 1017h:00 "
    )
    assert repr(capture.nodes[5]) == "<Node 5 on vcan0 'Servo drive': pre-operational, 118 frames>"
    assert repr(capture.signals["5.TPDO4.velocity actual value"][0]) == (
        "<Signal 5.TPDO4.velocity actual value = 0 rpm, frame 150>"
    )
    finding = canalyze.open(ABORTS).findings.of("SDO012")[0]
    assert repr(finding) == f"<Finding error SDO012 at frame 47: {finding.message}>"


def test_a_word_that_nothing_has_is_a_mistake() -> None:
    """A finder that gives nothing would make `assert not ...` pass."""
    capture = canalyze.open(ABORTS)
    wrong: list[tuple[Callable[..., object], dict[str, str], str]] = [
        (capture.findings.of, {"code": "SD0001"}, "no rule begins so"),
        (capture.findings.at_least, {"severity": "fatal"}, "one of info, warning, error"),
        (capture.transfers.of, {"direction": "write"}, "one of upload, download"),
        (capture.transfers.of, {"status": "okay"}, "one of ok, aborted"),
    ]
    for finder, given, said in wrong:
        with pytest.raises(ValueError, match=said):
            finder(**given)
    assert capture.findings.of("HBT") == []


def test_tables_are_the_lists_as_columns() -> None:
    capture = canalyze.open(NETWORK, eds={5: DRIVE})
    tables = capture.tables("transfers", "signals", "pdo")
    assert tables["transfers"].column("data") == [one.data for one in capture.transfers]
    assert tables["transfers"].column("t_ns") == [one.t_ns for one in capture.transfers]
    assert tables["signals"].column("signal") == [one.signal for one in capture.signals]
    assert tables["pdo/vcan0/5.TPDO4/1"].num_rows == 34
    assert repr(tables["pdo/vcan0/5.TPDO4/1"]) == "<Table pdo/vcan0/5.TPDO4/1: 34 rows>"
    assert capture.tables("signals", select="5.TPDO4.*")["signals"].num_rows == 34 * 3
    assert {"frames", "transfers", "states", "emcy", "findings", "sync_cycles", "signals"} <= set(capture.tables())
    with pytest.raises(ValueError, match="colours"):
        capture.tables("colours")


def test_expectations_are_checked(tmp_path: Path) -> None:
    (tmp_path / "boot.expect.toml").write_text(
        '[[sdo]]\nnode = 5\nobject = "1017:00"\nvalue = 100\n\n[[sdo]]\nnode = 5\nobject = "1017:00"\nvalue = 1000\n'
    )
    (tmp_path / "wrong.expect.toml").write_text("[[colours]]\n")
    (tmp_path / "boot.log").write_bytes(NETWORK.read_bytes())
    capture = canalyze.open("boot.log", folder=tmp_path)
    assert capture.check() == []
    (found,) = capture.check(expect="boot.expect.toml")
    assert found.code.startswith("EXP") and found.severity == "error" and "boot.expect.toml" in found.message
    assert capture.gave(found)
    assert canalyze.open(ABORTS).check(at_least="error") == canalyze.open(ABORTS).findings.at_least("error")
    for name, said in (("wrong.expect.toml", "colours"), ("missing.toml", "missing")):
        with pytest.raises(canalyze.ConfigError, match=said):
            capture.check(expect=name)


def test_findings_come_with_the_lines_that_led_to_them() -> None:
    for finding in canalyze.open(ABORTS).findings.at_least("warning"):
        assert finding.lines and finding.lines[-1].frame == finding.frame
        assert all("  # " in line.text for line in finding.lines)


def test_fields_are_read_when_they_are_asked_for() -> None:
    events = canalyze.open(NETWORK).events
    frame = next(one for one in events if isinstance(one, canalyze.Frame) and one.service == "sdo")
    assert frame.fields == frame.fields != {}
    assert (frame, frame.fields) == (replace(frame), pickle.loads(pickle.dumps(frame)).fields)
    assert len({id(one.file) for one in events if isinstance(one, canalyze.Frame)}) == 1  # a million names are one


def test_the_collector_runs_again_after_a_list() -> None:
    assert gc.isenabled()
    with pytest.raises(canalyze.SourceError):
        _ = canalyze.open(SAMPLES / "README.md").events
    assert gc.isenabled()
    gc.disable()
    try:
        assert canalyze.open(NETWORK).events
        assert not gc.isenabled()
    finally:
        gc.enable()
