"""Files that are written: through no link that somebody has laid, by one run each, whole or named as a part.

Modes are kept, and what cannot write is one line.
"""

import ctypes
import os
import resource
import signal
import stat
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from captures import TESTS
from conftest import NOTES, Runner, command, environment, started
from processes import wait_until_idle

from canalyze.output import FileOutput
from canalyze.output.files import Part
from canalyze.reports.extract import Directory
from canalyze.words import Words

TRANSFER = "00001_can1_node10_1008h_00_manufacturer_device_name.bin"
TEXT = b"Zephyr RTOS/CANopenNode"


def names(path: Path) -> list[str]:
    return sorted(one.name for one in path.iterdir())


def extracted(path: Path, told: list[str], *, force: bool = False) -> Directory:
    return Directory(str(path), Words("en"), told.append, force=force)


def laid(path: Path, victim: Path, count: int = 20) -> None:
    """Lays links where parts have been made by name: after the name, and after the name and a process's number."""
    for number in range(os.getpid() - count, os.getpid() + 5 * count):
        path.with_name(f"{path.name}.{number}.part").symlink_to(victim)
    path.with_name(f"{path.name}.part").symlink_to(victim)


# Parts.


def test_a_part_is_random_and_beside_its_file(tmp_path: Path) -> None:
    parts = [Part(tmp_path / "a.log", replace=False) for _ in range(50)]
    for part in parts:
        os.close(part.fd)
        assert part.path.parent == tmp_path and part.path.name.startswith("a.log.") and part.path.suffix == ".part"
    assert len({part.path for part in parts}) == 50


def test_a_name_of_full_length_has_a_part(tmp_path: Path) -> None:
    name = "文" * 80 + "abcdefghijk.log"
    with FileOutput(str(tmp_path / name), force=False) as out:
        out.write(b"x")
    assert names(tmp_path) == [name]


def test_links_laid_in_the_way_are_not_followed(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("mine")
    laid(tmp_path / "out.log", victim)
    (tmp_path / "x").mkdir()
    laid(tmp_path / "x" / TRANSFER, victim)
    assert canalyze("convert", notes, "out.log").code == 0
    assert canalyze("sdo", "--extract", "x", notes).code == 0
    assert victim.read_text() == "mine"
    assert (tmp_path / "x" / TRANSFER).read_bytes() == TEXT
    assert not (tmp_path / "x" / TRANSFER).is_symlink() and not (tmp_path / "out.log").is_symlink()


# Two at once.


def test_two_extractions_do_not_mix(tmp_path: Path) -> None:
    told: list[str] = []
    one, two = extracted(tmp_path, told), extracted(tmp_path, told)
    one.add([("a.bin", b"11", "", [], "")])
    two.add([("a.bin", b"22", "", [], "")])
    one.add([("a.bin", b"11", "ok", [], "")])
    two.add([("a.bin", b"22", "ok", [], "")])
    assert (tmp_path / "a.bin").read_bytes() == b"1111"
    assert names(tmp_path) == ["a.bin"]
    assert ((one.written, one.code), (two.written, two.code), len(told)) == ((1, 0), (0, 2), 1)


def test_of_two_outputs_the_later_one_says_that_there_is_one(tmp_path: Path) -> None:
    name = str(tmp_path / "a.log")
    with pytest.raises(Exception, match="exists"), FileOutput(name, force=False) as one:
        one.write(b"1")
        with FileOutput(name, force=False) as two:
            two.write(b"2")
    assert (tmp_path / "a.log").read_bytes() == b"2"
    assert names(tmp_path) == ["a.log"]


# Modes.


@pytest.mark.parametrize("name", ["out.log", "out.log.gz", "out.blf", "out.csv", "out.db", "out.trc"])
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444])
def test_the_mode_of_a_replaced_file_is_kept(
    canalyze: Runner, notes: str, tmp_path: Path, name: str, mode: int
) -> None:
    (tmp_path / name).write_text("old")
    (tmp_path / name).chmod(mode)
    assert canalyze("convert", "--force", notes, name).code == 0
    assert stat.S_IMODE((tmp_path / name).stat().st_mode) == mode
    assert canalyze("info", name).code == 0


def test_a_new_file_has_the_mode_of_any(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / "other").touch()
    assert canalyze("convert", notes, "out.log").code == 0
    assert (tmp_path / "out.log").stat().st_mode == (tmp_path / "other").stat().st_mode


def test_a_baseline_and_an_extracted_file_keep_their_modes(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / "known.json").write_text("")
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / TRANSFER).write_text("old")
    for path in (tmp_path / "known.json", tmp_path / "x" / TRANSFER):
        path.chmod(0o600)
    assert canalyze("check", "--baseline", "known.json", "--update-baseline", notes).code == 0
    assert canalyze("sdo", "--extract", "x", "--force", notes).code == 0
    assert (tmp_path / "x" / TRANSFER).read_bytes() == TEXT
    for path in (tmp_path / "known.json", tmp_path / "x" / TRANSFER):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600


# What cannot write.


DAC_OVERRIDE, CAPBSET_DROP = 1, 24


def limited(directory: Path, *arguments: str, size: int | None = None) -> tuple[int, str]:
    """Runs a command that may write so many bytes into a file, and nothing where modes forbid it, also for root."""

    def limit() -> None:
        if size is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        if os.geteuid() == 0:
            ctypes.CDLL(None).prctl(CAPBSET_DROP, DAC_OVERRIDE, 0, 0, 0)

    line = command("--lang", "en", *arguments)
    done = subprocess.run(line, cwd=directory, env=environment(), capture_output=True, preexec_fn=limit, check=False)
    return done.returncode, done.stderr.decode()


@pytest.mark.parametrize(
    "arguments",
    [
        ["convert", "notes.log", "closed/out.log"],
        ["convert", "notes.log", "closed/out.blf"],
        ["decode", "notes.log", "-o", "closed/out.txt"],
        ["sdo", "notes.log", "--extract", "closed"],
        ["sdo", "notes.log", "--extract", "closed/below"],
        ["check", "notes.log", "--junit", "closed/junit.xml"],
        ["check", "notes.log", "--baseline", "closed/known.json", "--update-baseline"],
    ],
)
def test_a_folder_that_cannot_be_written_is_one_line(notes: str, tmp_path: Path, arguments: list[str]) -> None:
    (tmp_path / "closed").mkdir(mode=0o555)
    code, err = limited(tmp_path, *arguments)
    assert (code, err.count("\n")) == (2, 1), err
    assert "cannot write: permission denied" in err
    assert names(tmp_path / "closed") == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["decode", "long.log", "-o", "out.txt"],
        ["convert", "long.log", "out.log"],
        ["convert", "long.log", "out.blf"],
        ["sdo", "long.log", "-o", "out.txt"],
    ],
)
def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path: Path, arguments: list[str]) -> None:
    (tmp_path / "long.log").write_text(NOTES * 500)
    code, err = limited(tmp_path, *arguments, size=4096)
    assert code == 2 and "Traceback" not in err
    assert [line for line in err.splitlines() if "cannot write" in line] == err.splitlines()[-1:]
    assert names(tmp_path) == ["long.log"]


def test_a_full_disk_ends_an_extraction_with_one_line(notes: str, tmp_path: Path) -> None:
    code, err = limited(tmp_path, "sdo", notes, "--extract", "x", size=4)
    assert (code, err.count("\n")) == (2, 1)
    assert "cannot write: file too large" in err


# What is interrupted.


def interrupted(directory: Path, arguments: list[str], number: signal.Signals) -> tuple[int, str, str]:
    """Ends a command that waits for the rest of a file; gives its code and what it said."""
    fifo = directory / "waits"
    os.mkfifo(fifo)
    process = started(
        directory, "--lang", "en", *arguments, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    )
    with fifo.open("wb", buffering=0) as writing:
        writing.write(NOTES.encode())
        wait_until_idle(process.pid, unread=writing.fileno())
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    fifo.unlink()
    return process.returncode, out.decode(), err.decode()


COMMANDS = [["decode"], ["sdo"], ["signals"], ["summary"], ["info"], ["expect"], ["summary", "--format", "jsonl"]]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("line", COMMANDS, ids=" ".join)
def test_an_interrupted_file_stays_a_part(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, line: list[str], number: signal.Signals
) -> None:
    (tmp_path / "first.log").write_text(NOTES)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(sized(tmp_path)), os.environ.get("PYTHONPATH", "")]))
    code, out, err = interrupted(tmp_path, [*line, "first.log", "waits", "-o", "out.txt"], number)
    (part,) = tmp_path.glob("out.txt.*.part")
    assert (code, out) == (128 + number, "")
    said = f"canalyze: out.txt: interrupted; what was read so far is in {part.name}"
    assert [line for line in err.splitlines() if "interrupted" in line] == [said]
    assert part.stat().st_size > 0 and not (tmp_path / "out.txt").exists()


@pytest.mark.parametrize("line", COMMANDS, ids=" ".join)
def test_an_interrupted_report_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, line: list[str]) -> None:
    (tmp_path / "first.log").write_text(NOTES)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(sized(tmp_path)), os.environ.get("PYTHONPATH", "")]))
    code, out, err = interrupted(tmp_path, [*line, "first.log", "waits"], signal.SIGINT)
    assert code == 130 and out
    said = "canalyze: standard output: interrupted; holds only what was read so far"
    assert [line for line in err.splitlines() if "interrupted" in line] == [said]


def sized(directory: Path) -> Path:
    """Gives a folder in which Python finds a FIFO to be a file: a file that is still read when the signal comes."""
    folder = directory / "python"
    folder.mkdir(exist_ok=True)
    (folder / "sitecustomize.py").write_text(
        "import canalyze.sources as file\nfile.total_size = lambda names: 1_000_000\n"
    )
    return folder


def test_a_stream_has_no_other_end(tmp_path: Path) -> None:
    code, _, err = interrupted(tmp_path, ["decode", "waits", "-o", "out.txt"], signal.SIGINT)
    assert (code, err) == (130, "canalyze: out.txt: interrupted; holds only what was read so far\n")
    assert (tmp_path / "out.txt").read_text().count("\n") >= 10
    code, out, err = interrupted(tmp_path, ["decode", "waits"], signal.SIGINT)
    assert (code, err) == (130, "") and out


@pytest.mark.parametrize("error", [SystemExit(143), KeyboardInterrupt()])
def test_what_is_ended_at_once_stays_a_part(tmp_path: Path, error: BaseException) -> None:
    from canalyze.errors import BrokenOff

    with pytest.raises(BrokenOff) as raised, FileOutput(str(tmp_path / "a.log"), force=False) as out:
        out.write(b"some")
        raise error
    (part,) = tmp_path.iterdir()
    assert part.read_bytes() == b"some" and part.name in str(raised.value)
    assert raised.value.exit_code == (143 if isinstance(error, SystemExit) else 130)


SOURCES = sorted(path for path in (TESTS.parent / "canalyze").rglob("*.py") if "core" not in path.parts)
OPENS: tuple[Callable[[str], bool], ...] = (
    lambda line: ".write_text(" in line or ".write_bytes(" in line,
    lambda line: "os.O_CREAT" in line or "O_TRUNC" in line,
    lambda line: 'open("w' in line or 'open("a' in line or 'open("x' in line,
)
ELSEWHERE = {
    "canalyze/output/files.py",
    "canalyze/sources/bridge/reading.py",
    "canalyze/fleet/stores.py",
    "canalyze/running/diagnosing.py",
}
"""The one way, and copies of inputs in folders that nobody else has."""


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(TESTS.parent)))
def test_there_is_one_way_in_which_files_are_written(path: Path) -> None:
    if str(path.relative_to(TESTS.parent)) in ELSEWHERE:
        return
    for line in path.read_text(encoding="utf-8").splitlines():
        assert not any(opens(line) for opens in OPENS), line
