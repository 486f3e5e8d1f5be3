"""`canalyze decode` as a user runs it: files, pipes, errors, the output file."""

import json
import os
import subprocess
from pathlib import Path

import pytest
from captures import EDS, SHARED, Row
from conftest import NOTES, Runner, command, environment, ran, started


def test_redirected_file_is_as_the_file(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    with (tmp_path / notes).open("rb") as file:
        done = ran(None, "decode", "-", stdin=file, check=True)
    assert done.stdout.decode() == canalyze("decode", notes).out


def test_a_pipe_answers_each_line_at_once(tmp_path: Path) -> None:
    process = _live(tmp_path)
    assert process.stdin and process.stdout
    for frame in NOTES.splitlines():
        process.stdin.write(frame.encode() + b"\n")
        process.stdin.flush()
        while not (line := process.stdout.readline()).startswith(frame.encode()):
            assert line, "the output ended before the frame's line"
    _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, b"")


def _live(directory: Path) -> subprocess.Popen[bytes]:
    return started(directory, "decode", "-", stdin=subprocess.PIPE)


def test_broken_pipe_ends_quietly(tmp_path: Path) -> None:
    (tmp_path / "long.log").write_text(NOTES * 5000)
    process = started(tmp_path, "decode", "long.log")
    assert process.stdout and process.stderr
    assert process.stdout.readline().startswith(b"can1  60A")
    process.stdout.close()
    assert process.stderr.read() == b""
    assert process.wait(timeout=60) == 0
    process.stderr.close()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_forbidden_file_is_one_line(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / notes).chmod(0)
    done = canalyze("decode", notes)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "没有权限" in done.err


def test_a_reader_that_is_gone_is_no_error(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    line = command("eds", str(EDS / "drive.eds"))
    done = subprocess.run(line, stdout=writer, stderr=subprocess.PIPE, cwd=tmp_path, env=environment(), check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, b"")


def _records(out: str) -> tuple[list[str], list[Row]]:
    """The lines that are no incident, and the incidents."""
    lines = out.splitlines()
    incidents = [json.loads(line) for line in lines if line.startswith('{"kind":"problem"')]
    return [line for line in lines if not line.startswith('{"kind":"problem"')], incidents


def _unnumbered(incidents: list[Row]) -> list[str]:
    """The incidents without their numbers: those are given in the order of telling, or in that of reading."""

    def said(one: Row) -> Row:
        kept = {key: one[key] for key in one if key not in ("id", "parts", "effects", "cause")}
        return kept | {"cause": one["cause"] and one["cause"]["link"], "effects": len(one["effects"])}

    return sorted(json.dumps(said(one)) for one in incidents)


EXAMPLES = ("node-lost", "node-restarted", "mapping-refused", "drive-fault", "all-well")


@pytest.fixture
def examples(canalyze: Runner) -> None:
    """The five example captures."""
    assert canalyze("examples", ".").code == 0


@pytest.mark.usefixtures("examples")
@pytest.mark.parametrize("name", EXAMPLES)
def test_incidents_as_they_change(canalyze: Runner, name: str) -> None:
    told = canalyze("decode", "--format", "jsonl", "--problems", f"{name}.log")
    others, incidents = _records(told.out)
    diagnosed = [json.loads(line) for line in canalyze("diagnose", "--format", "jsonl", f"{name}.log").lines]
    ends = [one for one in incidents if one["phase"] == "final"]
    assert _unnumbered(ends) == _unnumbered(diagnosed), "the end is that of diagnose"
    assert told.lines[-len(diagnosed) :] == [line for line in told.lines if '"phase":"final"' in line]
    phases: dict[int, list[str]] = {}
    for one in incidents:
        phases.setdefault(one["id"], []).append(one["phase"])
        if one["phase"] != "final":
            assert one.keys() == diagnosed[0].keys()
    for each in phases.values():
        assert each[0] in ("opened", "final")
        assert each.index("opened") < each.index("final") if "opened" in each and "final" in each else True
    plain = canalyze("decode", "--format", "jsonl", f"{name}.log")
    assert plain.lines == others, "who does not ask sees what was there before"


@pytest.mark.usefixtures("examples")
def test_incidents_are_opened_linked_and_ended(canalyze: Runner) -> None:
    _, lost = _records(canalyze("decode", "--format", "jsonl", "--problems", "node-restarted.log").out)
    assert {"opened", "ended", "final"} <= {one["phase"] for one in lost}
    linked = [one for one in lost if one["phase"] == "linked"]
    assert all(one["cause"] is not None for one in linked)


@pytest.mark.usefixtures("examples")
def test_a_filter_leaves_incidents(canalyze: Runner) -> None:
    asked = ("decode", "--format", "jsonl", "--problems", "node-lost.log")
    _, every = _records(canalyze(*asked).out)
    frames, some = _records(canalyze(*asked, "--filter", "node=99").out)
    assert some == every and not any('"kind":"frame"' in line for line in frames)


@pytest.mark.parametrize("path", sorted((SHARED / "stories").glob("*.log")), ids=lambda path: path.stem)
def test_incidents_of_a_recorded_story(canalyze: Runner, path: Path) -> None:
    _, incidents = _records(canalyze("decode", "--format", "jsonl", "--problems", str(path)).out)
    final = [one for one in incidents if one["phase"] == "final"]
    diagnosed = [json.loads(line) for line in canalyze("diagnose", "--format", "jsonl", str(path)).lines]
    assert _unnumbered(final) == _unnumbered(diagnosed)
    told = {one["id"]: [one["cause"]] for one in incidents if one["phase"] == "opened"}
    for one in (one for one in incidents if one["phase"] == "linked"):
        # Another cause is news, and once that it stays.
        assert told[one["id"]][-2:] != [one["cause"]] * 2
        told[one["id"]].append(one["cause"])
