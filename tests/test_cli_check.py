"""`canalyze check` as a user and a CI job run it: what fails, what is said, and with which exit code."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from captures import SAMPLES, SHARED
from conftest import Runner, command, environment
from fleet_works import Here
from processes import wait_until_idle
from test_cli_terminal import on_terminal

from canalyze._core import COLOURS
from canalyze.check import examination
from canalyze.check.examination import Far, Job
from canalyze.check.verdict import Examined
from canalyze.configuration.network import Known
from canalyze.running import pool

RULES = SAMPLES / "rules"
GOLDEN = SAMPLES / "check"
CHINESE = re.compile("[\u4e00-\u9fff]")


def jsonl(canalyze: Runner, *args: str, code: int = 1) -> list[dict[str, Any]]:
    done = canalyze("check", "--format", "jsonl", "--lang", "en", *args)
    assert done.code == code, done
    return [json.loads(line) for line in done.lines]


def ends(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [row for row in found if row["kind"] == "check"]


def codes(found: list[dict[str, Any]], *, fails: bool = True) -> list[str]:
    return [row["code"] for row in found if row["kind"] == "finding" and row["fails"] == fails]


# What is written.


@pytest.mark.parametrize(("form", "suffix"), [("text", "txt"), ("markdown", "md")])
@pytest.mark.parametrize("lang", ["zh", "en"])
def test_the_report_is_the_golden_one(tmp_path: Path, lang: str, form: str, suffix: str) -> None:
    """Read it before it is kept: `canalyze check FILES -o samples/check/report.LANG.txt --force` in samples/rules."""
    names = ["SDO001.log", "SDO001.clean.log", "SDO012.log", "HBT002.log", "PDO002.log", "CAP001.log", "NMT002.log"]
    arguments = ["check", "--lang", lang, "--format", form, "--ignore", "CAP", *names]
    done = subprocess.run(
        command(*arguments), cwd=RULES, env=environment(), capture_output=True, check=False, timeout=60
    )
    assert done.returncode == 1
    assert done.stdout.decode() == (GOLDEN / f"report.{lang}.{suffix}").read_text(encoding="utf-8")
    assert lang == "zh" or not CHINESE.search(done.stdout.decode())


def test_a_clean_capture_is_one_line(canalyze: Runner, set_of_captures: Path) -> None:
    done = canalyze("check", "--lang", "en", "captures/clean.log")
    assert (done.code, done.err) == (0, "")
    assert done.lines == ["captures/clean.log, 8 frames: clean", "1 file, 8 frames: no failing findings"]


def test_findings_of_one_kind_are_one_entry(canalyze: Runner, tmp_path: Path) -> None:
    lines = ["(1.000000) can0 705#00\n"]
    lines += [f"({2 + turn}.000000) can0 085#1081000000000000\n" for turn in range(25)]
    (tmp_path / "emcy.log").write_text("".join(lines))
    found = jsonl(canalyze, "emcy.log")
    (row,) = [row for row in found if row.get("code") == "EMC001"]
    assert (row["count"], row["frame"], row["frames"]) == (25, 2, list(range(2, 12)))
    assert ends(found)[0]["failures"] == 26  # and the EMCY that the node reports
    done = canalyze("check", "--lang", "en", "emcy.log")
    assert "    25 times; also at frames 3, 4, 5, 6, 7, 8, 9, 10, 11 ..." in done.lines


def test_jsonl(canalyze: Runner, set_of_captures: Path) -> None:
    found = jsonl(canalyze, "captures/toggle.log", "captures/clean.log")
    (finding,) = [row for row in found if row["kind"] == "finding"]
    assert (finding["code"], finding["severity"], finding["file"]) == ("SDO001", "error", "captures/toggle.log")
    assert (finding["frame"], finding["count"], finding["known"], finding["fails"]) == (8, 1, 0, True)
    assert [line["frame"] for line in finding["lines"]] == list(range(1, 9))
    assert ends(found) == [
        {
            "kind": "check",
            "file": f"captures/{name}.log",
            "frames": 8,
            "failed": failed,
            "failures": int(failed),
            "others": 0,
            "nature": "canopen",
            "judged": True,
            "overruled": 0,
            "reasons": [],
            "expectations": None,
            "error": None,
        }
        for name, failed in (("toggle", True), ("clean", False))
    ]


def test_lines_are_those_of_decode(canalyze: Runner, set_of_captures: Path) -> None:
    decoded = canalyze("decode", "--lang", "en", "captures/toggle.log").lines
    for row in jsonl(canalyze, "captures/toggle.log"):
        for line in row.get("lines", ()):
            assert line["text"] in decoded


def test_reports_are_written_beside(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    further = ("--code-quality", "q.json", "--markdown", "m.md")
    args = ("check", "captures/toggle.log", "--junit", "j.xml", "--sarif", "s.json", *further, "-o", "out.txt")
    assert canalyze(*args).code == 1
    assert ElementTree.parse(tmp_path / "j.xml").getroot().find(".//failure") is not None
    (run,) = json.loads((tmp_path / "s.json").read_text())["runs"]
    assert [result["ruleId"] for result in run["results"]] == ["SDO001"]
    assert "SDO001" in (tmp_path / "out.txt").read_text()
    assert [entry["check_name"] for entry in json.loads((tmp_path / "q.json").read_text())] == ["SDO001"]
    shown = canalyze("check", "captures/toggle.log", "--format", "markdown")
    assert shown.out == (tmp_path / "m.md").read_text() and "SDO001" in shown.out
    again = canalyze(*args)
    assert again.code == 2 and "--force" in again.err
    assert canalyze(*args, "--force").code == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        *("captures", "j.xml", "m.md", "out.txt", "q.json", "s.json"),
    ]


def test_github(canalyze: Runner, set_of_captures: Path) -> None:
    done = canalyze("check", "--format", "github", "captures/toggle.log", "captures/sync.log")
    assert done.code == 1
    assert [line.split(" ")[0] for line in done.lines] == ["::error", "::warning"]


def test_colours_are_for_terminals(set_of_captures: Path, tmp_path: Path) -> None:
    code, shown = on_terminal(tmp_path, "check", "captures/toggle.log")
    assert code == 1 and COLOURS["error"].encode() in shown
    for name, value in (("NO_COLOR", "1"), ("TERM", "dumb")):
        code, shown = on_terminal(tmp_path, "check", "captures/toggle.log", only_err=False, **{name: value})
        assert code == 1 and b"\x1b" not in shown
    assert (
        b"\x1b"
        not in subprocess.run(
            command("check", "captures/toggle.log"), cwd=tmp_path, env=environment(), capture_output=True, check=False
        ).stdout
    )


# Many captures.


def test_results_come_in_the_order_given(canalyze: Runner, set_of_captures: Path) -> None:
    big = (set_of_captures / "clean.log").read_text() * 2000
    (set_of_captures / "big.log").write_text(big)
    names = ["captures/big.log", "captures/toggle.log", "captures/clean.log", "captures/sync.log"]
    for order in (names, names[::-1]):
        assert [row["file"] for row in ends(jsonl(canalyze, *order))] == order


def test_the_largest_captures_are_begun_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = [str(tmp_path / name) for name in ("a.log", "b.log", "none.log", "c.log")]
    for name, size in zip(names, (20, 300, 0, 30), strict=True):
        if size:
            Path(name).write_bytes(bytes(size))
    begun: list[str] = []

    def noted(name: str, *_: object) -> Examined:
        begun.append(Path(name).name)
        return Examined(name)

    monkeypatch.setattr(examination, "examine", noted)
    monkeypatch.setattr(pool, "Pool", Here)
    found, signal = examination.examine_all(names, Job("en", {}, Known(), {}), Far(lambda word: None))
    assert ([one.file for one in found if one], signal) == (names, 0)
    assert begun == ["b.log", "c.log", "a.log", "none.log"]


def test_quoted_globs(canalyze: Runner, set_of_captures: Path) -> None:
    deep = set_of_captures / "a" / "b"
    deep.mkdir(parents=True)
    (deep / "deep.log").write_bytes((set_of_captures / "clean.log").read_bytes())
    (set_of_captures / "odd[1].log").write_bytes((set_of_captures / "clean.log").read_bytes())
    found = jsonl(canalyze, "captures/toggle.log", "captures/**/*.log")
    assert [row["file"] for row in ends(found)] == [
        "captures/toggle.log",
        "captures/a/b/deep.log",
        "captures/clean.log",
        "captures/odd[1].log",
        "captures/sync.log",
    ]
    assert [row["file"] for row in ends(jsonl(canalyze, "captures/odd[1].log", code=0))] == ["captures/odd[1].log"]


def test_a_pattern_that_nothing_fits_is_an_error(canalyze: Runner, set_of_captures: Path) -> None:
    done = canalyze("check", "--lang", "en", "captures/*.asc", "captures/toggle.log")
    assert done.code == 2
    assert done.complaints == ["canalyze: captures/*.asc: no matching files"]
    assert "SDO001" in done.out
    alone = canalyze("check", "--lang", "en", "captures/*.asc")
    assert alone.code == 2
    assert alone.lines[-1] == "1 file, 0 frames: 1 file not fully checked"  # not "no failing findings"


def test_a_directory_stands_for_its_captures(canalyze: Runner, set_of_captures: Path) -> None:
    (set_of_captures / "deep").mkdir()
    (set_of_captures / "deep" / "more.log").write_bytes((set_of_captures / "toggle.log").read_bytes())
    (set_of_captures / "notes.md").write_text("nothing")
    done = canalyze("check", "--lang", "en", "captures", "captures/clean.log")
    assert done == canalyze(
        "check", "--lang", "en", *(f"captures/{n}.log" for n in ("clean", "sync", "toggle", "deep/more"))
    )
    assert done.code == 1 and done.lines[-1].startswith("4 files")


def test_a_directory_without_captures_says_what_to_write(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "notes.md").write_text("nothing")
    done = canalyze("check", "--lang", "en", "empty")
    assert done.code == 2
    assert done.complaints == [
        "canalyze: empty: no file in this directory is named as captures are; name the files, such as 'empty/**/*.log'"
    ]


def test_a_load_is_told_with_as_many_digits_as_exceed_the_limit(canalyze: Runner, set_of_captures: Path) -> None:
    """Not: 0.05 %, expected at most 0.05 %."""
    file = set_of_captures / "clean.expect.toml"

    def told(limit: float, bit_rate: int) -> float:
        file.write_text(f"[[load]]\nmax_percent = {limit:.6f}\nbitrate = {bit_rate}\n")
        return float(re.findall(r"load ([\d.]+) %", canalyze("check", "--lang", "en", "captures/clean.log").out)[0])

    bits = told(0.001, 10_000) * 100  # of the first frame
    limit = bits / 10_000 - 0.0001
    assert limit < told(limit, 1_000_000) < limit + 0.01


def test_expectations_that_could_not_be_judged_are_shown(canalyze: Runner, set_of_captures: Path) -> None:
    """A clean capture would pass for one that meets them."""
    (set_of_captures / "clean.expect.toml").write_text(
        "[[load]]\nmax_percent = 60\n[[load]]\nmax_percent = 50\nbus = 'can0'\n"
    )
    done = canalyze("check", "--lang", "en", "captures/clean.log")
    assert (done.code, done.err) == (0, "")
    assert done.lines[0] == "captures/clean.log, 8 frames: clean, 2 notes"
    places = sorted(line.rpartition("/")[2] for line in done.lines[1:3])
    assert places == ["clean.expect.toml:1)", "clean.expect.toml:3)"]
    assert all("EXP015" in line and "bit rate" in line for line in done.lines[1:3])


def test_what_cannot_be_read_hides_nothing(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    (set_of_captures / "empty.log").write_bytes(b"")
    (set_of_captures / "notes.log").write_text("no capture\n")
    names = ["empty.log", "toggle.log", "notes.log", "missing.log", "sync.log"]
    args = [f"captures/{name}" for name in names]
    done = canalyze("check", "--lang", "en", *args)
    assert done.code == 2
    assert [line.split(": ")[1] for line in done.complaints] == [args[0], args[2], args[3]]
    assert "SDO001" in done.out and "SYN003" in done.out
    assert done.lines[-1].endswith("3 files not fully checked")
    found = jsonl(canalyze, *args, code=2)
    assert [row["error"] is None for row in ends(found)] == [False, True, False, False, True]


def test_a_damaged_capture_is_judged_as_far_as_it_goes(canalyze: Runner, tmp_path: Path) -> None:
    import gzip

    whole = (RULES / "SDO001.log").read_bytes() + (RULES / "SDO001.clean.log").read_bytes() * 3000
    packed = gzip.compress(whole)
    (tmp_path / "cut.log.gz").write_bytes(packed[: len(packed) // 2])
    found = jsonl(canalyze, "--ignore", "CAP003", "cut.log.gz")
    assert "SDO001" in codes(found) and "CAP005" in codes(found, fails=False)


def test_other_formats(canalyze: Runner, tmp_path: Path) -> None:
    for form in ("asc", "mcap", "pcapng", "log.gz"):
        assert canalyze("convert", str(RULES / "SDO001.log"), f"a.{form}").code == 0
        (finding,) = [row for row in jsonl(canalyze, f"a.{form}") if row["kind"] == "finding"]
        assert (finding["code"], len(finding["lines"])) == ("SDO001", 8)
    assert [row["frames"] for row in ends(jsonl(canalyze, "a.*"))] == [8, 8, 8, 8]


def test_standard_input(canalyze: Runner, set_of_captures: Path) -> None:
    text = (set_of_captures / "toggle.log").read_bytes()
    for args in ((), ("-",)):
        done = canalyze("check", "--lang", "en", *args, stdin=text)
        assert done.code == 1
        assert done.lines[0] == "stdin, 8 frames: 1 error"
    done = canalyze("check", "--format", "jsonl", "captures/sync.log", "-", "captures/clean.log", stdin=text)
    assert [row["file"] for row in map(json.loads, done.lines) if row["kind"] == "check"] == [
        "captures/sync.log",
        "-",
        "captures/clean.log",
    ]
    assert "SDO001" in done.out


def test_descriptions_are_read_for_every_capture(canalyze: Runner, tmp_path: Path) -> None:
    eds = RULES / "PDO012.eds"
    names = [str(RULES / "PDO012.log"), str(RULES / "PDO012.clean.log")]
    found = jsonl(canalyze, "--eds", f"5={eds}", *names)
    assert codes(found) == ["PDO012"]
    assert codes(jsonl(canalyze, *names, code=0)) == []


def test_a_node_that_is_in_some_captures_is_no_mistake(canalyze: Runner, set_of_captures: Path) -> None:
    """Descriptions are those of a whole network, captures may be of a part of it."""
    eds = str(RULES / "PDO012.eds")
    every = (str(RULES / "PDO012.clean.log"), "captures/clean.log")
    assert canalyze("check", "--eds", f"5={eds}", *every).err == ""
    assert canalyze("check", "--eds", f"6={eds}", "--lang", "en", *every).complaints == [
        f"{eds}: no frames of node 6 in the capture"
    ]


def test_a_mistake_in_an_option_is_one_line(canalyze: Runner, set_of_captures: Path) -> None:
    for args in (
        ("--junit", "-"),
        ("--sarif=-",),
        ("--filter", "nodes=5"),
        ("--eds", "5=missing.eds"),
        ("--merge",),
        ("--update-baseline",),
    ):
        done = canalyze("check", *args, "captures/toggle.log", "captures/sync.log")
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1), args


def test_a_filter_shows_findings_of_what_passes(canalyze: Runner, tmp_path: Path) -> None:
    """Also those that only the end of the capture proves."""
    lines = ["(1.000000) can0 705#00\n", "(1.000000) can0 706#00\n"]
    for turn in range(30):
        lines += [f"({2 + turn / 10:.6f}) can0 {node}#7F\n" for node in ("705", "706")]
    lines += [f"({5 + turn / 10:.6f}) can0 706#7F\n" for turn in range(20)]
    (tmp_path / "lost.log").write_text("".join(lines))
    assert codes(jsonl(canalyze, "lost.log")) == ["HBT002"]
    assert codes(jsonl(canalyze, "--filter", "service=heartbeat", "lost.log")) == ["HBT002"]
    assert codes(jsonl(canalyze, "--filter", "service=sync", "lost.log", code=0)) == []


def test_a_process_that_dies_is_an_error_of_its_capture(
    canalyze: Runner, set_of_captures: Path, tmp_path: Path
) -> None:
    code = (
        "import os, signal, sys\n"
        "from canalyze.check import examination\n"
        "examine = examination.examine\n"
        "def dying(name, job, progress):\n"
        "    if 'sync' in name:\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
        "    return examine(name, job, progress)\n"
        "examination.examine = dying\n"
        "from canalyze.cli import main\n"
        "raise SystemExit(main(sys.argv[1:]))\n"
    )
    args = ["check", "--lang", "en", *(f"captures/{name}.log" for name in ("toggle", "sync", "clean"))]
    done = subprocess.run(
        [command()[0], "-c", code, *args], cwd=tmp_path, env=environment(), capture_output=True, check=False, timeout=60
    )
    assert done.returncode == 2
    assert b"SDO001" in done.stdout and b"captures/clean.log, 8 frames: clean" in done.stdout
    assert b"captures/sync.log: its worker process died (SIGKILL)" in done.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("other", [[], ["captures/clean.log"]], ids=["alone", "in a set"])
@pytest.mark.parametrize("filed", [False, True], ids=["stdout", "file"])
def test_the_end_can_be_wished(
    set_of_captures: Path, tmp_path: Path, number: signal.Signals, other: list[str], filed: bool
) -> None:
    """What is known by then is said; no process is left; reports of half a set are not written."""
    fifo = tmp_path / "live"
    os.mkfifo(fifo)
    to_file = ["-o", "out.txt"] if filed else []
    process = subprocess.Popen(
        command("check", "--lang", "en", *other, "live", "--junit", "j.xml", *to_file),
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    with fifo.open("wb", buffering=0) as live:
        live.write((set_of_captures / "toggle.log").read_bytes())
        wait_until_idle(process.pid, unread=live.fileno())
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert b"Traceback" not in err
    assert b"interrupted: 1 file not read to the end" in err
    assert filed or (b"captures/clean.log, 8 frames: clean" if other else b"SDO001") in out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["captures", "live"]


def test_a_reader_that_leaves_does_not_pass_the_check(set_of_captures: Path, tmp_path: Path) -> None:
    process = subprocess.Popen(
        command("check", "captures/toggle.log", "--junit", "j.xml"),
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout and process.stderr
    process.stdout.close()
    with process.stderr:
        assert process.stderr.read() == b""
    assert process.wait(timeout=60) == 1
    assert (tmp_path / "j.xml").exists()


# Real captures.


def stacks(*folders: Path) -> list[Path]:
    return [path for folder in folders for path in sorted(folder.glob("*.log"))]


def test_sessions_of_real_stacks_are_clean(canalyze: Runner) -> None:
    names = stacks(SAMPLES / "stacks", SAMPLES / "network", SHARED / "stacks")
    # What devices report themselves is true, and no fault of the verdicts.
    done = canalyze("check", "--lang", "en", "--ignore", "EMC007,EMC008", *map(str, names))
    assert (done.code, done.err) == (0, ""), done.out
    assert done.lines[-1].endswith("no failing findings")


def test_every_sample_as_a_user_would(canalyze: Runner) -> None:
    """Each rule's capture fails or not by the severity of its rule; its clean neighbour never does."""
    from canalyze._core import rules

    severities = {rule.code: rule.severity for rule in rules("en")}
    names = [str(path) for path in sorted(RULES.glob("*.log")) if path.name != "CAP003.log"]  # that one is for pipes
    alone = [name for name in names if not any(Path(name).with_name(f"{code(name)}{form}").exists() for form in EDS)]
    found = jsonl(canalyze, *alone)
    failed = {row["file"]: row["failed"] for row in ends(found)}
    raised: dict[str, set[str]] = {}
    consequences = {(row["file"], row["code"]) for row in found if row.get("because_of") is not None}
    for row in found:
        if row["kind"] == "finding":
            raised.setdefault(row["file"], set()).add(row["code"])
            own = row["frame"] is None or row["frame"] in {line["frame"] for line in row["lines"]}
            assert own or row["code"].startswith(("CAP", "BUS009", "SDO03")), row
            assert len(row["lines"]) <= 8
            assert row["lines"] == sorted(row["lines"], key=lambda line: line["frame"])
    for name in alone:
        rule = code(name)[:6]
        if ".clean." in name:
            # An EMCY that a device has sent fails a capture by itself.
            assert not failed[name] or raised[name] & {"EMC007", "EMC008"}, name
        else:
            assert rule in raised[name]
            assert failed[name] or severities[rule] == "info" or (name, rule) in consequences, name
    assert len(alone) > 150


EDS = (".eds", ".dcf")


def code(name: str) -> str:
    return Path(name).name.split(".")[0]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="Linux tells the peak of a process")
def test_memory_is_flat(tmp_path: Path) -> None:
    """Ten times the frames, and the findings, take no more memory."""
    peaks = []
    for frames in (20_000, 200_000):
        path = tmp_path / f"{frames}.log"
        with path.open("w") as out:
            for turn in range(frames):
                out.write(f"({turn // 1000}.{turn % 1000:03d}000) can0 {0x81 + turn % 100:03X}#1081000000000000\n")
        script = (
            "import sys; from canalyze.cli import main; main(sys.argv[1:]);"
            "peak = next(line for line in open('/proc/self/status') if line.startswith('VmHWM'));"
            "sys.stderr.write(peak.split()[1])"
        )
        arguments = [command()[0], "-c", script, "check", str(path)]
        done = subprocess.run(arguments, capture_output=True, check=True, cwd=tmp_path)
        peaks.append(int(done.stderr))
    assert peaks[1] - peaks[0] < 6 * 1024, peaks  # in KiB


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere names of files are text")
def test_a_name_that_is_no_text_is_json_all_the_same(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    name = os.fsdecode(b"bad\xff.log")
    (set_of_captures / "clean.log").rename(tmp_path / name)
    done = canalyze("check", "--format", "jsonl", name)
    assert json.loads(done.out.splitlines()[-1])["file"] == "bad\\xff.log"
