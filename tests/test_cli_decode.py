"""`canalyze decode` as a user runs it: files, pipes, errors, the output file."""

import json
import os
import re
import subprocess
from pathlib import Path

import pytest
from captures import SHARED, Row
from conftest import NOTES, Runner, annotates, command, environment


def test_annotates_every_frame(canalyze: Runner, notes: str) -> None:
    zh = canalyze("decode", notes)
    en = canalyze("--lang", "en", "decode", notes)
    assert (zh.code, zh.err, en.code, en.err) == (0, "", 0, "")
    assert annotates(zh.lines) and annotates(en.lines)
    assert zh.out != en.out
    assert "1008h:00" in zh.out and "1008h:00" in en.out


def test_jsonl_is_one_object_a_line(canalyze: Runner, notes: str) -> None:
    done = canalyze("decode", "--format", "jsonl", notes)
    assert done.code == 0
    kinds = [json.loads(line)["kind"] for line in done.lines]
    assert kinds.count("frame") == 10
    assert set(kinds) <= {"frame", "note", "finding", "transfer"}


def test_depths_differ(canalyze: Runner, notes: str) -> None:
    brief, default, explained = (canalyze("decode", *depth, notes) for depth in (["--brief"], [], ["--explain"]))
    assert annotates(brief.lines) and annotates(default.lines) and annotates(explained.lines)
    assert len({brief.out, default.out, explained.out}) == 3
    assert len(explained.lines) > len(default.lines)


@pytest.mark.parametrize("args", [["decode", "-"], ["decode"]])
def test_standard_input(canalyze: Runner, args: list[str]) -> None:
    done = canalyze(*args, stdin=NOTES.encode())
    assert (done.code, done.err) == (0, "")
    assert annotates(done.lines)


def test_redirected_file_is_as_the_file(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    with (tmp_path / notes).open("rb") as file:
        done = subprocess.run(command("decode", "-"), stdin=file, capture_output=True, env=environment(), check=True)
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
    return subprocess.Popen(
        command("decode", "-"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=directory,
        env=environment(),
    )


def test_broken_pipe_ends_quietly(tmp_path: Path) -> None:
    (tmp_path / "long.log").write_text(NOTES * 5000)
    process = subprocess.Popen(
        command("decode", "long.log"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        env=environment(),
    )
    assert process.stdout and process.stderr
    assert process.stdout.readline().startswith(b"can1  60A")
    process.stdout.close()
    assert process.stderr.read() == b""
    assert process.wait(timeout=60) == 0
    process.stderr.close()


def test_unreadable_lines_are_named_and_do_not_stop(canalyze: Runner, tmp_path: Path) -> None:
    first, *others = NOTES.splitlines(keepends=True)
    (tmp_path / "mixed.log").write_text(first + "this is no frame\n" + "".join(others))
    done = canalyze("decode", "mixed.log")
    assert done.code == 0
    assert annotates(done.lines)
    assert "mixed.log" in done.err and "2" in done.err
    assert "Traceback" not in done.err


@pytest.mark.parametrize("lang", ["zh", "en"])
@pytest.mark.parametrize(
    ("name", "content"),
    [("empty.log", b""), ("binary.dat", bytes(range(256)) * 40), ("prose.txt", b"no frame here\n" * 50)],
)
def test_nothing_readable_is_one_line(canalyze: Runner, tmp_path: Path, name: str, content: bytes, lang: str) -> None:
    (tmp_path / name).write_bytes(content)
    done = canalyze("--lang", lang, "decode", name)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert name in done.err


@pytest.mark.parametrize(
    ("name", "zh", "en"),
    [
        ("nowhere.log", "文件或目录不存在", "no such file or directory"),
        (".", "是目录", "is a directory"),
        ("notes.log/x", "不是目录", "not a directory"),
        ("a\x1b[31m\nb", "文件或目录不存在", "no such file or directory"),
    ],
)
def test_what_cannot_be_opened_is_one_line(canalyze: Runner, notes: str, name: str, zh: str, en: str) -> None:
    for lang, said in (("zh", zh), ("en", en)):
        done = canalyze("--lang", lang, "decode", name)
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
        assert said in done.err
        assert "\x1b" not in done.err


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_forbidden_file_is_one_line(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / notes).chmod(0)
    done = canalyze("decode", notes)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert "没有权限" in done.err


def test_one_missing_file_does_not_stop_the_others(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / "second.log").write_text(NOTES)
    done = canalyze("decode", notes, "nowhere.log", "second.log")
    assert (done.code, len(done.complaints)) == (2, 1)
    assert annotates(done.lines, NOTES * 2)


def test_several_files_are_one_capture(canalyze: Runner, tmp_path: Path) -> None:
    frames = NOTES.splitlines(keepends=True)
    (tmp_path / "a.log").write_text("".join(frames[:4]))
    (tmp_path / "b.log").write_text("".join(frames[4:]))
    (tmp_path / "ab.log").write_text(NOTES)
    assert canalyze("decode", "a.log", "b.log").out == canalyze("decode", "ab.log").out


def test_filter_that_cannot_be_read(canalyze: Runner, notes: str) -> None:
    done = canalyze("decode", "--filter", "nonsense", notes)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)


def test_what_the_core_refuses_is_one_sentence(canalyze: Runner, notes: str) -> None:
    done = canalyze("decode", "--filter", "nonsense", notes)
    assert done.err.endswith("; 用法见 canalyze decode --help\n")
    assert "；" not in done.err


def test_help_says_what_times_count_from(canalyze: Runner) -> None:
    zh, en = (re.sub(r"\s+", " ", canalyze("--lang", lang, "decode", "--help").out) for lang in ("zh", "en"))
    assert "100000000" in zh and "100000000" in en
    assert "UTC" in zh and "date and time in UTC" in en


def test_output_file(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    assert canalyze("decode", notes, "-o", "out.txt").out == ""
    written = (tmp_path / "out.txt").read_text(encoding="utf-8")
    assert written == canalyze("decode", notes).out

    (tmp_path / "out.txt").write_text("mine")
    done = canalyze("decode", notes, "-o", "out.txt")
    assert (done.code, len(done.complaints)) == (2, 1)
    assert "out.txt" in done.err and "--force" in done.err
    assert (tmp_path / "out.txt").read_text() == "mine"

    assert canalyze("decode", notes, "-o", "out.txt", "--force").code == 0
    assert (tmp_path / "out.txt").read_text(encoding="utf-8") == written
    assert sorted(path.name for path in tmp_path.iterdir()) == ["notes.log", "out.txt"]


def test_output_file_is_not_left_behind_without_result(canalyze: Runner, tmp_path: Path) -> None:
    assert canalyze("decode", "nowhere.log", "-o", "out.txt").code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("target", ["no/such/dir/out.txt", ".", "/dev/full"])
def test_output_that_cannot_be_written_is_one_line(canalyze: Runner, notes: str, target: str) -> None:
    done = canalyze("decode", notes, "-o", target)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert target in done.err


def test_output_to_a_device_does_not_replace_it(canalyze: Runner, notes: str) -> None:
    assert canalyze("decode", notes, "-o", "/dev/null").code == 0
    assert Path("/dev/null").is_char_device()


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


@pytest.mark.usefixtures("examples")
def test_incidents_in_lines(canalyze: Runner) -> None:
    told = canalyze("decode", "--problems", "--lang", "en", "node-lost.log")
    assert any(line.startswith("# ✖ problem") for line in told.lines)
    assert not any(line.startswith("# ✖") for line in canalyze("decode", "--lang", "en", "node-lost.log").lines)


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
