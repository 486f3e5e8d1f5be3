"""`canalyze diagnose`, and files without a command: what is printed, and the exit codes.

What it must not do: test what is diagnosed.
"""

from __future__ import annotations

import json
import re
import signal
import subprocess
from pathlib import Path

import pytest
from captures import SAMPLES, run_canalyze
from conftest import Runner, command, environment
from network_sessions import SESSIONS
from processes import wait_until_idle
from test_diagnosis import frames_of, lost

from canalyze.output.layout import width
from canalyze.reports.diagnosis import _fitted

LINES = 30
CHINESE = re.compile("[\u4e00-\u9fff]")


@pytest.fixture(autouse=True)
def lost_log(tmp_path: Path) -> None:
    """A capture in which node 5 is lost."""
    (tmp_path / "lost.log").write_bytes(lost(20))


def test_a_file_without_a_command_is_diagnosed(canalyze: Runner) -> None:
    alone, named = canalyze("lost.log"), canalyze("diagnose", "lost.log")
    assert alone.code == named.code == 0
    assert alone.out == named.out
    assert "节点5" in alone.out
    assert "node 5" in canalyze("lost.log", "--lang", "en").out


def test_a_file_that_is_not_there_is_one_line(canalyze: Runner) -> None:
    done = canalyze("missing.log")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "missing.log" in done.err


def test_a_file_that_is_called_as_a_command(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "info").write_bytes(lost(20))
    assert "node 5" in canalyze("./info", "--lang", "en").out
    assert "did you mean" in canalyze("inof", "--lang", "en").err or canalyze("inof").code == 2


def test_a_command_that_is_spelt_wrong_is_no_file(canalyze: Runner, tmp_path: Path) -> None:
    for args in (["decde", "lost.log"], ["diagnoze", "lost.log"], ["decde"]):
        done = canalyze(*args, "--lang", "en")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert f"no such command: {args[0]} (did you mean " in done.err
    (tmp_path / "decde").write_bytes(lost(20))
    assert "node 5" in canalyze("decde", "lost.log", "--lang", "en").out


def test_from_standard_input(canalyze: Runner) -> None:
    assert "node 5" in canalyze("-", "--lang", "en", stdin=lost(20)).out
    for args in ([], ["--all"], ["-n", "1"], ["-", "-n", "1"], ["diagnose", "-n", "1"], ["--since", "1"]):
        done = canalyze(*args, "--lang", "en", stdin=lost(20))
        assert (done.code, done.err) == (0, "") and "node 5" in done.out, args
    whole = canalyze("lost.log", "--lang", "en", "-n", "1").out
    piped = canalyze("-n", "1", "--lang", "en", stdin=lost(20)).out
    assert piped == whole.replace("canalyze decode lost.log", "canalyze decode FILE")


def test_from_a_file_as_standard_input(tmp_path: Path) -> None:
    for args in ([], ["-n", "1"]):
        with (tmp_path / "lost.log").open("rb") as stdin:
            done = subprocess.run(
                command(*args, "--lang", "en"), stdin=stdin, env=environment(), capture_output=True, check=False
            )
        assert (done.returncode, done.stderr) == (0, b"") and b"node 5" in done.stdout


def test_a_signal_ends_the_reading_of_a_pipe_not_the_report(tmp_path: Path) -> None:
    with subprocess.Popen(
        command("-n", "1", "--lang", "en"), stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment()
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        process.stdin.write(lost(20))
        process.stdin.flush()
        wait_until_idle(process.pid)
        process.send_signal(signal.SIGINT)
        assert b"node 5" in process.stdout.read()
        assert process.wait(30) == 130


def test_a_pipe_with_what_is_no_option_or_no_capture(canalyze: Runner) -> None:
    for args, said in ((["--bogus"], "no such option: --bogus"), (["decde"], "no such command"), ([], "stdin")):
        done = canalyze(*args, "--lang", "en", stdin=b"")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1) and said in done.err
    assert canalyze("--help", "--lang", "en", stdin=lost(20)).out.startswith("Usage: canalyze [OPTIONS] COMMAND")
    assert canalyze("--version", stdin=lost(20)).out.startswith("canalyze ")


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("name", SESSIONS)
def test_a_report_is_short(canalyze: Runner, tmp_path: Path, name: str, lang: str) -> None:
    (tmp_path / "a.log").write_bytes(frames_of(name))
    done = canalyze("a.log", "--lang", lang)
    assert done.code == 0
    assert 1 <= len(done.out.splitlines()) <= LINES
    if lang == "en":
        assert not CHINESE.search(done.out)


def test_a_healthy_capture_shows_its_nodes(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_bytes(lost(40))
    for lang, state in (("zh", "操作状态"), ("en", "Operational")):
        lines = canalyze("a.log", "--lang", lang).out.splitlines()
        assert len(lines) == 7
        assert lines[2] == ("2个节点有心跳" if lang == "zh" else "2 nodes with heartbeats")
        assert lines[3] == ("节点" if lang == "zh" else "NODES")
        role = "只有心跳" if lang == "zh" else "heartbeats only"
        assert lines[4:6] == [f"  5  {role}  {state}", f"  6  {role}  {state}"]
        assert "canalyze summary a.log" in lines[6]


def test_each_node_has_a_row_with_what_is_known_of_it(canalyze: Runner, tmp_path: Path) -> None:
    """Its kind by the device type or by what it maps, its state, its axes, its error, and its problem."""
    read = "".join(
        f"({at:.3f}) can0 {frame}\n"
        for at, frame in [
            (0.1, "602#4000100000000000"),
            (0.101, "582#4300100091010200"),
            (0.2, "60A#4000100000000000"),
            (0.201, "58A#4300100092010200"),
            (0.3, "60A#4041600000000000"),
            (0.301, "58A#4B41600008020000"),
            (0.4, "08A#1023810000000000"),
            *((0.5 + step / 2, f"{node:03X}#05") for step in range(9) for node in (0x702, 0x70A, 0x70B)),
        ]
    )
    (tmp_path / "a.log").write_text(read)
    lines = canalyze("a.log", "--lang", "en").lines
    begin = lines.index("NODES")
    assert lines[begin + 1] == "   2  I/O              Operational"
    assert lines[begin + 2].startswith("  10  drive            Operational  fault  EMCY 2310h continuous")
    assert lines[begin + 2].endswith("  problem 1")
    assert lines[begin + 3] == "  11  heartbeats only  Operational"


@pytest.mark.parametrize(
    ("frames", "row"),
    [
        ([(1, "087#10838100AA000000"), (2, "087#0000000000000000")], "  7  Operational"),
        ([(1, "087#10838100AA000000")], "  7  Operational  fault  EMCY 8310h monitoring  problem 1"),
        ([(1, "607#4000100000000000")], "  7  Operational  fault  problem 1"),
        (
            [
                *((1 + step / 10, "187#0802") for step in range(80)),
                *((5.05, "087#30811100AA000000"), (6.05, "087#0000000000000000")),
            ],
            "  7  Operational  fault  problem 1",
        ),
    ],
)
def test_a_row_says_how_a_node_is_now(
    canalyze: Runner, tmp_path: Path, frames: list[tuple[float, str]], row: str
) -> None:
    """A fault is over once no error is left, unless a problem says that it is not; who is asked is no mere listener."""
    lines = [(0.0, "607#4041600000000000"), (0.001, "587#4B41600008020000"), *frames]
    lines = sorted([*lines, *((3 + step / 2, "707#05") for step in range(14))])
    (tmp_path / "a.log").write_text("".join(f"({at:.3f}) can0 {frame}\n" for at, frame in lines))
    said = canalyze("a.log", "--lang", "en").lines
    assert row in said, said


@pytest.mark.parametrize("count", [12, 40])
def test_a_row_for_up_to_12_nodes_and_those_with_problems_first(canalyze: Runner, tmp_path: Path, count: int) -> None:
    beats = [
        (step + node / 1000, f"{0x700 + node:03X}#05")
        for step in range(20)
        for node in range(1, count + 1)
        if node != count or step < 4
    ]
    (tmp_path / "a.log").write_text("".join(f"({at:.3f}) can0 {frame}\n" for at, frame in sorted(beats)))
    lines = canalyze("a.log", "--lang", "en").lines
    rows = lines[lines.index("NODES") + 1 : -1]
    assert len(lines) <= LINES == 30
    assert [int(row.split()[0]) for row in rows[:12]] == ([*range(1, 13)] if count == 12 else [40, *range(1, 12)])
    assert rows[12:] == ([] if count == 12 else ["  28 more"])
    assert sum("problem 1" in row for row in rows) == 1


def test_what_could_not_be_judged(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "short.log").write_bytes(lost(3, until=3))
    assert "only 0.2 s" in canalyze("short.log", "--lang", "en").out
    (tmp_path / "bare.log").write_text("".join(f"can0  70{5 + n % 2}   [1]  05\n" for n in range(40)))
    assert "no usable timestamps" in canalyze("bare.log", "--lang", "en").out


def test_one_problem_in_full(canalyze: Runner) -> None:
    done = canalyze("lost.log", "-n", "1", "--lang", "en")
    assert done.code == 0
    assert "> #39 " in done.out
    assert "heartbeat of node 5" in done.out
    assert canalyze("lost.log", "-n", "9").code == 2


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("name", ["node-lost", "node-restarted", "mapping-refused", "drive-fault"])
def test_a_story_has_all_of_it(canalyze: Runner, name: str, lang: str) -> None:
    assert canalyze("examples", ".").code == 0
    incidents = [json.loads(line) for line in canalyze(f"{name}.log", "--format", "jsonl", "--lang", lang).lines]
    for one in incidents:
        told = canalyze(f"{name}.log", "-n", str(one["id"]), "--lang", lang)
        assert told.code == 0 and "\\x" not in told.out
        assert one["message"] in told.lines[0]
        assert all(step["text"] in told.out and f"#{step['frame']} " in told.out for step in one["steps"])
        assert all(entry["code"] in told.out for entry in one["findings"])
        assert f"canalyze explain {one['problem']}" in told.lines[-1]
        if one["cause"] is not None:
            assert f"-n {one['cause']['id']}" in told.lines[-1]
        if lang == "en":
            assert not CHINESE.search(told.out)


def test_each_line_of_a_frame_stands_by_itself(canalyze: Runner) -> None:
    """Findings below a frame are lines, not escaped ends of lines."""
    path = SAMPLES / "stories/t01-node-dead.log"
    numbers = [json.loads(line)["id"] for line in canalyze(str(path), "--format", "jsonl").lines]
    told = [line for number in numbers for line in canalyze(str(path), "-n", str(number), "--lang", "en").lines]
    assert any(line.strip().startswith("#   HBT002") for line in told)
    assert not any("\\x0a" in line for line in told)


def test_what_tells_causes_apart(canalyze: Runner) -> None:
    """Of a node that did not come back, what the capture cannot tell is said with what would."""
    told = canalyze("lost.log", "-n", "1", "--lang", "en").out
    assert "? it has not come back: power loss or broken connection cannot be distinguished" in told
    assert "no other node went silent" not in told  # of two nodes one alone says nothing of cable and supply
    assert "? no error frames in the capture" in told
    assert told.count("berr-reporting") == 1
    canalyze("examples", ".")
    restarted = canalyze("node-restarted.log", "-n", "1", "--lang", "en").out
    assert "+ it came back with a boot-up" in restarted and "cannot be distinguished" not in restarted
    refused = canalyze("mapping-refused.log", "-n", "1", "--lang", "en").out
    assert "+ written successfully later" in refused


def test_why_it_is_a_consequence(canalyze: Runner) -> None:
    canalyze("examples", ".")
    lines = [json.loads(line) for line in canalyze("node-lost.log", "--format", "jsonl").lines]
    effect = next(one for one in lines if one["cause"] is not None and one["cause"]["link"] == "L1")
    told = canalyze("node-lost.log", "-n", str(effect["id"]), "--lang", "en").out
    assert re.search(r"why: a heartbeat consumer \(1016h\).*; \+\d+ ms \(1016h \d+ ms\)", told)


def test_only_some_problems(canalyze: Runner) -> None:
    for option in (["--node", "5"], ["--since", "3"], ["--bus", "can0"]):
        assert "node 5" in canalyze("lost.log", *option, "--lang", "en").out
    other = canalyze("lost.log", "--node", "6", "--lang", "en")
    assert other.out.startswith("✔ no problems found (node 6 only)   ") and "node 5" not in other.out
    assert "(仅总线can0、3 s后)" in canalyze("lost.log", "--bus", "can0", "--since", "3").lines[0]
    assert not re.search(r"NODES.* 6 ok", canalyze("lost.log", "--node", "5", "--lang", "en").out)


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize("columns", [40, 60, 80, 100])
def test_lines_fit_a_narrow_terminal(lang: str, columns: int) -> None:
    report = run_canalyze(["diagnose", SAMPLES / "problems.log", "--lang", lang]).decode().splitlines()
    for line in report:
        fitted = _fitted(line, columns)
        assert "".join("".join(fitted).replace(" · ", "").split()) == "".join(line.replace(" · ", "").split())
        if "canalyze" not in line:
            assert max(map(width, fitted)) <= columns, fitted
        if match := re.search(r"  (#[0-9]+)$", line):
            assert fitted[-1].endswith(match[1])


@pytest.mark.parametrize("form", ["text", "jsonl"])
def test_what_is_not_in_the_capture_is_an_error(canalyze: Runner, form: str) -> None:
    for option, said in (
        (["--node", "99"], "canalyze: node 99 is not in the capture; nodes: 5-6\n"),
        (["--bus", "can0", "--node", "99"], "canalyze: node 99 is not on bus can0; nodes: 5-6\n"),
        (["--bus", "can7"], "canalyze: bus can7 is not in the capture; buses: can0\n"),
    ):
        done = canalyze("lost.log", *option, "--format", form, "--lang", "en", "-o", "out")
        assert (done.code, done.out, done.err) == (2, "", said)
        assert not Path("out").exists()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["-n", "0"], "option -n 0: expected a whole number above 0"),
        (["-n", "9"], "no problem 9; problems: 1"),
        (["--since", "abc"], "option --since abc: expected seconds"),
        (["--since", "nan"], "option --since nan: expected seconds"),
        (["--filter", "node=5"], "--filter does not apply to diagnose"),
    ],
)
def test_wrong_values_are_said_in_our_words(canalyze: Runner, args: list[str], said: str) -> None:
    done = canalyze("lost.log", *args, "--lang", "en")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1) and said in done.err
    assert "--filter" not in canalyze("diagnose", "--help").out


def test_no_problem_to_tell(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "well.log").write_bytes(lost(40))
    assert "no problem 1: no problems found" in canalyze("well.log", "-n", "1", "--lang", "en").err


def test_exit_codes(canalyze: Runner, tmp_path: Path) -> None:
    assert canalyze("lost.log").code == 0
    assert canalyze("lost.log", "--fail-on", "open").code == 1
    (tmp_path / "well.log").write_bytes(lost(40))
    assert canalyze("well.log", "--fail-on", "open").code == 0
