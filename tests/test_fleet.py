"""Many captures through `canalyze fleet`: each is done once, whatever happens to workers, to the run and to captures.

The ways of doing it (a pool, Dask, Ray) go through the same tests; those that are not installed are skipped.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from captures import SAMPLES, TESTS
from conftest import NOTES, Runner, environment
from fleet_works import Here, Traced, counts, trace

from canalyze.check import policy
from canalyze.check.examination import Far, Job, examine
from canalyze.check.policy import Policy
from canalyze.configuration.network import Known
from canalyze.fleet import run as runs
from canalyze.fleet.stores import Capture, captures
from canalyze.fleet.task import Manifest, Piece, Work, restored, stored, verdict_of
from canalyze.running.pool import Beside, DaskCluster, Executor, Pool, RayCluster
from canalyze.running.run import Interrupt
from canalyze.words import Words

RULES = SAMPLES / "rules"


def work(out: Path | str, **changes: Any) -> Work:
    job = Job("en", {}, Known(), {"stamps": "auto"}, beside=False)
    given: dict[str, Any] = {"action": "check", "job": job, "policy": Policy(), "known": {}, "out": str(out)}
    return Work(**given | changes)


def folder_of(tmp_path: Path, *names: str) -> Path:
    folder = tmp_path / "captures"
    folder.mkdir()
    for name in names:
        (folder / name).write_text(NOTES)
    return folder


@pytest.fixture
def mixed(tmp_path: Path) -> Path:
    """Give a folder: two clean captures, two with findings, one that is none, and files that are not to be read."""
    folder = tmp_path / "captures"
    (folder / "deeper").mkdir(parents=True)
    files = {"clean": "SDO001.clean", "toggle": "SDO001", "sync": "SYN003", "deeper/heartbeat": "HBT001.clean"}
    for name, source in files.items():
        (folder / f"{name}.log").write_bytes((RULES / f"{source}.log").read_bytes())
    (folder / "broken.log").write_bytes(b"\x00\x01nothing" * 20)
    (folder / "notes.md").write_text("no capture")
    (folder / ".hidden.log").write_text(NOTES)
    return folder


def manifests(out: Path, action: str = "check") -> dict[str, dict[str, Any]]:
    rows = [json.loads(path.read_text()) for path in (out / "_manifest" / action).glob("*.json")]
    return {Path(row["capture"]).name: row for row in rows}


# The command.


def test_reports_are_those_of_check(canalyze: Runner, mixed: Path, tmp_path: Path) -> None:
    canalyze("fleet", "check", "captures", "-o", "out", "--lang", "en")
    names = ["captures/broken.log", "captures/clean.log", "captures/sync.log", "captures/toggle.log"]
    names.append("captures/deeper/heartbeat.log")
    canalyze("check", *names, "-o", "check.txt", "--junit", "check.xml", "--lang", "en")
    canalyze("check", *names, "-o", "check.jsonl", "--format", "jsonl", "--lang", "en")
    out = tmp_path / "out"
    text = (out / "check.txt").read_text()
    assert text.startswith((tmp_path / "check.txt").read_text())
    assert (out / "check.jsonl").read_text() == (tmp_path / "check.jsonl").read_text()
    cases = [
        [
            [(case.get("name"), [one.get("message") for one in case]) for case in suite]
            for suite in ElementTree.parse(file).getroot()
        ]
        for file in (out / "check.xml", tmp_path / "check.xml")
    ]
    assert cases[0] == cases[1]


def test_the_page_holds_what_was_found_and_loads_nothing(canalyze: Runner, mixed: Path, tmp_path: Path) -> None:
    (mixed / "toggle.log").rename(mixed / "<b>toggle.log")
    canalyze("fleet", "check", "captures", "-o", "out", "--lang", "en", "--html")
    page = (tmp_path / "out/check.html").read_text()
    assert "&lt;b&gt;toggle.log" in page and "<b>" not in page and "SDO001" in page
    assert page.index("broken.log") < page.index("toggle.log") < page.index("clean.log")
    assert "http" not in page.replace("http-equiv", "") and "<script" not in page
    assert re.search(r'content="default-src \'none\'; style-src \'sha256-[^;]+\'; base-uri', page)


# Again.


def test_other_versions_are_other_work(mixed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one = work(tmp_path / "out")
    every = captures([str(mixed)], one.out, beside=False)
    finish(Pool(Traced(one, str(tmp_path / "trace")), 2), one, every)
    assert len(runs.standing(one, every, retry=False)) == 5
    monkeypatch.setattr(runs, "__version__", "99")
    assert runs.standing(one, every, retry=False) == {}


def test_a_file_that_was_only_touched_is_not_done_again(mixed: Path, tmp_path: Path) -> None:
    one = work(tmp_path / "out")
    finish(Pool(Traced(one, str(tmp_path / "trace")), 1), one, captures([str(mixed)], one.out, beside=False))
    before = manifests(tmp_path / "out")
    os.utime(mixed / "clean.log", (1, 1))
    changed = captures([str(mixed)], one.out, beside=False)
    assert len(runs.standing(one, changed, retry=False)) == 4
    finish(Pool(Traced(one, str(tmp_path / "trace")), 1), one, [item for item in changed if "clean" in item.name])
    after = manifests(tmp_path / "out")
    assert after["clean.log"]["stamp"] != before["clean.log"]["stamp"]
    assert {**after["clean.log"], "stamp": ""} == {**before["clean.log"], "stamp": ""}  # seconds, too


def test_shards_are_complete_and_disjoint(canalyze: Runner, mixed: Path, tmp_path: Path) -> None:
    every = [Capture(str(number), f"/captures/{number}.log") for number in range(1000)]
    shards = [[one.id for one in every if one.in_shard(number, 7)] for number in range(1, 8)]
    assert sorted(number for shard in shards for number in shard) == sorted(one.id for one in every)
    assert min(map(len, shards)) > 90
    for number in (1, 2, 3):
        canalyze("fleet", "check", "captures", "-o", "out", "--shard", f"{number}/3", "--lang", "en")
        assert (tmp_path / f"out/check-{number}-of-3.xml").exists()
    assert len(manifests(tmp_path / "out")) == 5 and not (tmp_path / "out/check.xml").exists()
    assert "5 of them before" in canalyze("fleet", "check", "captures", "-o", "out", "--lang", "en").lines[-1]


def test_verdicts_survive_the_store(mixed: Path, tmp_path: Path) -> None:
    """What reports are made of is the same, but for the lines around findings that are shown by number only."""
    job = Job("en", {}, Known(), {"stamps": "auto"}, incidents=True)
    for name in ("network/drive-states.log", "rules/HBT002.log", "rules/SDO001.log"):
        judged = policy.judge(examine(str(SAMPLES / name), job, Far(lambda word: None)), Policy(incidents="open"), {})
        row = json.loads(json.dumps(stored(judged)))
        back = restored(row)
        assert stored(back) == stored(judged)
        assert [one.finding for one in back.failures] == [one.finding for one in judged.failures]
        assert (back.incidents, back.known_problems) == (judged.incidents, judged.known_problems)


# Whatever happens.


def pool(one: Traced, width: int) -> Executor:
    return Pool(one, width)


def dask(one: Traced, width: int) -> Executor:
    pytest.importorskip("distributed", reason="canalyze[dask] is not installed")
    return DaskCluster(Beside(one), None, width)


def ray(one: Traced, width: int) -> Executor:
    pytest.importorskip("ray", reason="canalyze[ray] is not installed")
    return RayCluster(Beside(one), None, width)


WAYS = pytest.mark.parametrize("way", [pool, dask, ray])
Way = Callable[[Traced, int], Executor]
engines = pytest.mark.filterwarnings("default")
"""Other programs' warnings are theirs."""


def finish(
    executor: Executor, one: Work, every: list[Capture], after: Callable[[int], None] = lambda count: None
) -> list[Manifest]:
    """Run to the end; `after` is told how many are done."""
    found = []
    try:
        for count, done in enumerate(runs.run(executor, one, every), 1):
            found.append(done)
            after(count)
    finally:
        executor.close()
    return found


@pytest.fixture
def found_by_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lead the workers of Ray to the modules of the tests."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(TESTS), str(TESTS.parent)]))


@engines
@WAYS
@pytest.mark.usefixtures("found_by_workers")
def test_a_worker_that_is_killed_loses_nothing(tmp_path: Path, way: Way) -> None:
    names = [f"{number:02}.log" for number in range(30)]
    folder, log = folder_of(tmp_path, *names), tmp_path / "trace"
    one = work(tmp_path / "out")

    def kill(count: int) -> None:
        if count == 10:  # the process that reads; of an engine also its worker
            _, _, process, parent = trace(log)[-1]
            os.kill(int(process if way is pool else parent), signal.SIGKILL)

    found = finish(way(Traced(one, str(log), 0.02), 2), one, captures([str(folder)], one.out, beside=False), kill)
    assert sorted(Path(done.capture).name for done in found) == names
    assert not [done for done in found if done.failed]
    assert set(manifests(tmp_path / "out")) == set(names)
    # What was under way in the killed worker is asked for again; what it had done is found to be there.
    assert len(names) <= counts(log, "begun").total() <= len(names) + 4


@engines
@WAYS
@pytest.mark.usefixtures("found_by_workers")
def test_a_capture_that_kills_its_worker_is_quarantined(tmp_path: Path, way: Way) -> None:
    names = [*(f"{number:02}.log" for number in range(20)), "poison.log"]
    folder, log = folder_of(tmp_path, *names), tmp_path / "trace"
    one = work(tmp_path / "out")
    every = captures([str(folder)], one.out, beside=False)
    found = finish(way(Traced(one, str(log)), 2), one, every)
    (failed,) = [done for done in found if done.failed]
    assert (Path(failed.capture).name, failed.failed, failed.attempts) == ("poison.log", "died", 3)
    assert failed.error is not None and "SIGKILL" in failed.error
    assert counts(log, "begun") == {name: 3 if name == "poison.log" else 1 for name in names}
    assert counts(log, "ended") == dict.fromkeys(names[:-1], 1)
    assert verdict_of("check", failed).error == failed.error
    # It stays so: no run tries it again until it changes.
    assert len(runs.standing(one, every, retry=False)) == len(names)
    assert len(runs.standing(one, every, retry=True)) == len(names) - 1
    (folder / "poison.log").write_text(NOTES + NOTES)
    assert len(runs.standing(one, captures([str(folder)], one.out, beside=False), retry=False)) == len(names) - 1


RUN = """
import sys
from pathlib import Path
from test_fleet import captures, finish, work
from fleet_works import Traced
from canalyze.running.pool import Pool
from canalyze.fleet import run as runs

if __name__ == "__main__":
    folder, out, log = sys.argv[1:]
    one = work(Path(out))
    every = captures([folder], out, beside=False)
    done = runs.standing(one, every, retry=False)
    finish(Pool(Traced(one, log, 0.05), 2), one, [item for item in every if item.id not in done])
"""


def test_a_run_that_is_killed_goes_on_where_it_was(tmp_path: Path) -> None:
    names = [f"{number:02}.log" for number in range(30)]
    folder, log = folder_of(tmp_path, *names), tmp_path / "trace"
    script = tmp_path / "script.py"
    script.write_text(RUN)
    line = [sys.executable, str(script), str(folder), str(tmp_path / "out"), str(log)]
    env = environment(PYTHONPATH=os.pathsep.join([str(TESTS), str(TESTS.parent)]))
    process = subprocess.Popen(line, env=env)
    while counts(log, "ended").total() < 8:
        assert process.poll() is None
        time.sleep(0.01)
    process.kill()
    process.wait()
    workers = {int(process) for _, _, process, _ in trace(log)}
    while any(Path(f"/proc/{worker}").exists() for worker in workers):
        time.sleep(0.01)
    done = set(manifests(tmp_path / "out"))
    assert 8 <= len(done) < 30
    begun = counts(log, "begun")
    subprocess.run(line, env=env, check=True)
    assert set(manifests(tmp_path / "out")) == set(names)
    assert all(counts(log, "begun")[name] == 1 for name in done)
    assert all(counts(log, "begun")[name] == begun[name] + 1 for name in set(names) - done)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_end_can_be_wished(tmp_path: Path, number: signal.Signals) -> None:
    """What is done stays; no report of half a set is written, and no process is left."""
    folder = folder_of(tmp_path, "a.log", "b.log")
    os.mkfifo(folder / "c.log")
    line = [
        sys.executable,
        "-m",
        "canalyze",
        "fleet",
        "check",
        "captures",
        "-o",
        "out",
        "--lang",
        "en",
        "--workers",
        "1",
    ]
    env = environment(PYTHONPATH=str(TESTS.parent))
    process = subprocess.Popen(line, cwd=tmp_path, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    while len(manifests(tmp_path / "out")) < 2:
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (128 + number, b"")
    assert err.decode().splitlines() == ["canalyze: interrupted: 2 of 3 captures done; run again to go on from there"]
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["_manifest"]
    (folder / "c.log").unlink()
    (folder / "c.log").write_text(NOTES)
    done = subprocess.run(line, cwd=tmp_path, env=env, capture_output=True, check=True)
    assert b"3 captures done, 2 of them before" in done.stdout


def test_limits_reach_the_workers(tmp_path: Path, canalyze: Runner) -> None:
    folder_of(tmp_path, "a.log")
    os.mkfifo(tmp_path / "captures/stuck.log")
    done = canalyze("fleet", "check", "captures", "-o", "out", "--timeout", "1", "--memory", "2000", "--lang", "en")
    assert done.code == 3
    (row,) = [row for row in manifests(tmp_path / "out").values() if row["failed"]]
    assert (row["failed"], row["attempts"]) == ("time", 3)
    assert "  captures/stuck.log: took longer than --timeout (3 attempts)" in done.lines


def test_the_largest_captures_are_begun_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "captures"
    folder.mkdir()
    for name, count in (("a.log", 2), ("b.log", 9), ("c.log", 1), ("d.log", 5)):
        (folder / name).write_text(NOTES * count)
    begun: list[str] = []

    def noted(_: Work, piece: Piece, __: object) -> Manifest:
        begun.append(Path(piece.capture.name).name)
        return Manifest(piece.capture.name, piece.capture.id, "", "", "", "", None, None, 1, 0, 0, 0.0, None)

    monkeypatch.setattr(runs, "Pool", Here)
    monkeypatch.setattr(runs, "do", noted)
    how = runs.How(None, 1, None, None, None, retry=False, html=False, color="never")
    assert runs.complete(work(tmp_path / "out"), [str(folder)], how, Words("en")) == 0
    assert begun == ["b.log", "d.log", "a.log", "c.log"]


@pytest.mark.parametrize(
    ("capture", "size"),
    [
        (Capture("a", "/a", None, "120-1-2-3"), 120),
        (Capture("a", "/a", None, "120-1-2-3 7-1-2-3"), 120),
        (Capture("a", "/a"), 0),
        (Capture("s3://b/a", "a", "s3://b", '"0f-1" 44'), 44),
    ],
)
def test_sizes_of_captures(capture: Capture, size: int) -> None:
    assert capture.size == size


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux alone")
@pytest.mark.parametrize(
    ("changes", "store", "megabytes", "method"),
    [
        ({}, None, None, "fork"),
        ({"action": "export"}, None, None, "spawn"),
        ({"out": "s3://results/out"}, None, None, "spawn"),
        ({}, "s3://captures", None, "spawn"),
        ({}, None, 500, "spawn"),
    ],
)
def test_processes_are_forked_only_where_nothing_has_threads(
    tmp_path: Path, changes: dict[str, Any], store: str | None, megabytes: int | None, method: str
) -> None:
    how = runs.How(None, 2, None, megabytes, None, retry=False, html=False, color="auto")
    one = work(**{"out": tmp_path / "out"} | changes)
    made = runs._executor(how, one, [Capture("a.log", "/a.log", store)], Interrupt())
    assert isinstance(made, Pool)
    assert made._context.get_start_method() == method


def test_results_that_cannot_be_written_end_the_run(tmp_path: Path, canalyze: Runner) -> None:
    folder_of(tmp_path, "a.log", "b.log")
    (tmp_path / "out").mkdir()
    (tmp_path / "out/_manifest").write_text("in the way")
    done = canalyze("fleet", "check", "captures", "-o", "out", "--lang", "en")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1), done


# Tables.


def lake(out: Path) -> dict[str, list[Path]]:
    found: dict[str, list[Path]] = {}
    for path in sorted(out.rglob("*.parquet")):
        found.setdefault(path.relative_to(out).parts[0], []).append(path)
    return found


def test_tables_of_all_captures_are_in_one_place(canalyze: Runner, mixed: Path, tmp_path: Path) -> None:
    dataset = pytest.importorskip("pyarrow.dataset")
    done = canalyze("fleet", "export", "captures", "-o", "out", "--device-from", "captures/(deeper)/", "--lang", "en")
    assert done.code == 3, done
    found = lake(tmp_path / "out")
    assert len(found["frames"]) == len(found["captures"]) == 4
    rows = dataset.dataset(str(tmp_path / "out/frames"), partitioning="hive").to_table().to_pylist()
    assert len({row["capture"] for row in rows}) == 4
    assert {row["device"] for row in rows} == {None, "deeper"}
    assert len(rows) == sum(row["frames"] for row in manifests(tmp_path / "out", "export").values())
    assert [line.split() for line in done.lines if line.startswith("frames ")] == [["frames", "4", str(len(rows))]]
    assert not (tmp_path / "out/_parts").exists()


def test_tables_of_a_capture_that_changed_take_the_place_of_the_former(
    canalyze: Runner, mixed: Path, tmp_path: Path
) -> None:
    pytest.importorskip("pyarrow")
    line = ("fleet", "export", "captures/toggle.log", "-o", "out", "--table", "frames", "--lang", "en")
    assert canalyze(*line).code == 0
    (before,) = lake(tmp_path / "out")["frames"]
    (mixed / "toggle.log").write_text("(1700000000.000000) can0 705#05\n(1700000000.100000) can0 705#05\n")
    assert canalyze(*line).code == 0
    (after,) = lake(tmp_path / "out")["frames"]
    assert before.name == after.name and "date=2023-11-14" in str(after)  # another day, and so another folder
    (mixed / "toggle.log").write_bytes(b"\x00" * 100)
    assert canalyze(*line).code == 3
    assert lake(tmp_path / "out") == {}


def test_a_worker_that_dies_while_it_writes_leaves_no_part(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    folder, log = folder_of(tmp_path, "a.log", "b.log"), tmp_path / "trace"
    job = Job("en", {}, Known(), {"tables": ["frames"]}, beside=False)
    one = work(tmp_path / "out", action="export", job=job, tables=("frames",))
    every = captures([str(folder)], one.out, beside=False)
    for capture in every:  # as one leaves it that was killed
        (tmp_path / "out/_parts" / capture.id).mkdir(parents=True)
        (tmp_path / "out/_parts" / capture.id / "frames.1234.part").write_bytes(b"half")
    finish(Pool(Traced(one, str(log)), 2), one, every)
    assert [path.name for path in (tmp_path / "out").rglob("*.part")] == []
    assert len(lake(tmp_path / "out")["frames"]) == 2
