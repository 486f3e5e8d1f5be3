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

import pytest
from captures import SAMPLES, SHARED
from conftest import Runner, command, environment, ran, started
from fleet_works import Here
from processes import peak_kib, wait_until_idle
from test_cli_terminal import on_terminal

from canalyze._core import COLOURS
from canalyze.check import examination
from canalyze.check.examination import Far, Job
from canalyze.check.verdict import Examined
from canalyze.configuration.network import Known
from canalyze.running import pool
from canalyze.words import LANGUAGES, Words

RULES = SAMPLES / "rules"
GOLDEN = SAMPLES / "check"
CHINESE = re.compile("[\u4e00-\u9fff]")


def jsonl(canalyze: Runner, *args: str, code: int = 1) -> list[dict[str, Any]]:
    done = canalyze("check", "--format", "jsonl", "--lang", "en", *args)
    assert done.code == code, done
    return [json.loads(line) for line in done.lines]


def ends(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [row for row in found if row["kind"] == "check"]


# What is written.


@pytest.mark.parametrize(("form", "suffix"), [("text", "txt"), ("markdown", "md")])
@pytest.mark.parametrize("lang", ["zh", "en"])
def test_the_report_is_the_golden_one(tmp_path: Path, lang: str, form: str, suffix: str) -> None:
    """Read it before it is kept: `canalyze check FILES -o samples/check/report.LANG.txt --force` in samples/rules."""
    names = ["SDO001.log", "SDO001.clean.log", "SDO012.log", "HBT002.log", "PDO002.log", "CAP001.log", "NMT002.log"]
    arguments = ["check", "--lang", lang, "--format", form, "--ignore", "CAP", *names]
    done = ran(RULES, *arguments, timeout=60)
    assert done.returncode == 1
    assert done.stdout.decode() == (GOLDEN / f"report.{lang}.{suffix}").read_text(encoding="utf-8")
    assert lang == "zh" or not CHINESE.search(done.stdout.decode())


def test_lines_are_those_of_decode(canalyze: Runner, set_of_captures: Path) -> None:
    decoded = canalyze("decode", "--lang", "en", "captures/toggle.log").lines
    for row in jsonl(canalyze, "captures/toggle.log"):
        for line in row.get("lines", ()):
            assert line["text"] in decoded


def test_colours_are_for_terminals(set_of_captures: Path, tmp_path: Path) -> None:
    code, shown = on_terminal(tmp_path, "check", "captures/toggle.log")
    assert code == 1 and COLOURS["error"].encode() in shown
    for name, value in (("NO_COLOR", "1"), ("TERM", "dumb")):
        code, shown = on_terminal(tmp_path, "check", "captures/toggle.log", only_err=False, **{name: value})
        assert code == 1 and b"\x1b" not in shown
    assert b"\x1b" not in ran(tmp_path, "check", "captures/toggle.log").stdout


# Many captures.


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


def test_a_load_is_told_with_as_many_digits_as_exceed_the_limit(canalyze: Runner, set_of_captures: Path) -> None:
    """Not: 0.05 %, expected at most 0.05 %."""
    file = set_of_captures / "clean.expect.toml"

    def told(limit: float, bit_rate: int) -> float:
        file.write_text(f"[[load]]\nmax_percent = {limit:.6f}\nbitrate = {bit_rate}\n")
        return float(re.findall(r"load ([\d.]+) %", canalyze("check", "--lang", "en", "captures/clean.log").out)[0])

    bits = told(0.001, 10_000) * 100  # of the first frame
    limit = bits / 10_000 - 0.0001
    assert limit < told(limit, 1_000_000) < limit + 0.01


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
    process = started(tmp_path, "check", "--lang", "en", *other, "live", "--junit", "j.xml", *to_file)
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
    process = started(tmp_path, "check", "captures/toggle.log", "--junit", "j.xml")
    assert process.stdout and process.stderr
    process.stdout.close()
    with process.stderr:
        assert process.stderr.read() == b""
    assert process.wait(timeout=60) == 1
    assert (tmp_path / "j.xml").exists()


def examples_of_the_configuration() -> list[str]:
    """Returns the parts of canalyze.toml about `check` that help and README show."""
    readme = (SAMPLES.parent / "README.md").read_text(encoding="utf-8")
    fenced = re.findall(r"^```toml\n(.*?)^```$", readme, flags=re.DOTALL | re.MULTILINE)
    shown = [Words(lang)("check.examples").partition("# canalyze.toml\n")[2] for lang in LANGUAGES]
    return [*shown, *(part for part in fenced if "[[check.override]]" in part)]


@pytest.mark.parametrize("text", examples_of_the_configuration())
def test_what_is_shown_of_the_configuration_is_valid(
    canalyze: Runner, set_of_captures: Path, tmp_path: Path, text: str
) -> None:
    (tmp_path / "canalyze.toml").write_text(text)
    (tmp_path / "known.json").write_text('{"canalyze_baseline": 1, "findings": []}\n')
    assert canalyze("check", "captures/clean.log").code == 0


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
        peaks.append(peak_kib(tmp_path, "check", str(path)))
    assert peaks[1] - peaks[0] < 6 * 1024, peaks  # in KiB


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere names of files are text")
def test_a_name_that_is_no_text_is_json_all_the_same(canalyze: Runner, set_of_captures: Path, tmp_path: Path) -> None:
    name = os.fsdecode(b"bad\xff.log")
    (set_of_captures / "clean.log").rename(tmp_path / name)
    done = canalyze("check", "--format", "jsonl", name)
    assert json.loads(done.out.splitlines()[-1])["file"] == "bad\\xff.log"
