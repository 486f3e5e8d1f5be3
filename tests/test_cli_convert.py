"""`canalyze convert`: every sample in every format that can be written comes back as it was, or the loss was said.

A format that the core or a sink learns to write joins by itself: the formats are asked for by name.
"""

import itertools
import json
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from conftest import NOTES, Runner, command, environment
from reader_suite import read_here
from test_cli_terminal import on_terminal

from canalyze._core import WRITERS, Session
from canalyze.output import Output, Progress
from canalyze.running.reading import SessionOptions
from canalyze.running.run import Run
from canalyze.sinks import RECORDS, Target, forms, open_target, target
from canalyze.sources.bridge import reading
from canalyze.words import Words

ROOT = Path(__file__).parent.parent
SAMPLES = [path for end in ("log", "candump", "asc", "mcap") for path in sorted(ROOT.glob(f"samples/**/*.{end}"))]
FORMS = [form for form in forms() if form != "mf4" or find_spec("asammdf")]
BINARY = frozenset(form for form in forms() if form not in ("candump", "console", "asc"))
EN = Words("en")
THOROUGH = os.environ.get("CANALYZE_TESTS") == "thorough"
"""Also what neighbours test as well."""


class Frame(NamedTuple):
    """What has to come back."""

    t: int | None
    """Its moment in ns: with the date from which its stamp counts, where one is known."""
    bus: str
    dir: str | None
    id: str
    ext: bool
    rtr: bool
    err: bool
    len: int
    data: str
    fd: bool
    flags: str | None
    """The flags of an FD frame, as candump's log has them."""
    raw: str | None
    """The raw DLC of a classic frame, where it is another than its length."""


def _pass(session: Session, path: Path) -> bytes:
    taken: list[bytes] = []
    Run(session, EN, Progress(EN, Output(), None), taken.append, {}).over((str(path),))
    return b"".join(taken)


def _log(path: Path) -> list[tuple[str, str | None, str | None]]:
    """Give moment, flags and raw DLC of each frame, from candump's log form."""
    found = []
    for line in _pass(Session(SessionOptions(format="convert")), path).decode().splitlines():
        if not line.startswith("("):
            continue
        moment, _, payload = line.split()[:3]
        payload = payload.partition("#")[2]
        flags = re.match(r"#(.)", payload)
        raw = re.search(r"_(.)$", payload)
        found.append((moment.strip("()"), flags and flags[1], raw and raw[1]))
    return found


def _frames(path: Path) -> tuple[list[Frame], list[tuple[Any, ...]]]:
    """Give the frames of a capture, and the findings on them (what is said of the capture itself apart)."""
    rows = [json.loads(line) for line in _pass(Session(SessionOptions(lang="en", format="jsonl")), path).splitlines()]
    frames = [row for row in rows if row["kind"] == "frame"]
    keys = ("bus", "dir", "id", "ext", "rtr", "err", "len", "data")
    read = [
        Frame._make(
            [None if row["t"] is None else _ns(moment), *(row[key] for key in keys), bool(row["fd"]), flags, raw]
        )
        for row, (moment, flags, raw) in zip(frames, _log(path), strict=True)
    ]
    findings = [
        (row["code"], row["severity"], row["frame"], row["bus"], row["node"], row["message"])
        for row in rows
        if row["kind"] == "finding" and not row["code"].startswith("CAP")
    ]
    return read, findings


@cache
def _original(path: Path) -> tuple[list[Frame], list[tuple[Any, ...]]]:
    return _frames(path)


def _converted(path: Path, name: Path, form: str) -> list[str]:
    """Convert in this process; give what is said of losses."""
    where = target(str(name), form)
    assert where is not None
    session = Session(SessionOptions(lang="en", format="convert", to=where.written))
    output, losses = open_target(where, force=False)
    with output:
        code = Run(session, EN, Progress(EN, output, None), output.write, {}).over((str(path),))
    assert code == 0
    return session.losses("out", dict(losses))


def _ns(t: str) -> int:
    whole, _, fraction = t.partition(".")
    return int(whole) * 10**9 + int(fraction.ljust(9, "0"))


def _rounded(frame: Frame) -> Frame:
    return frame if frame.t is None else frame._replace(t=round(frame.t, -3))


Ease = Callable[[Frame], Frame | None]
EASED: dict[str, Ease] = {
    "direction not kept": lambda frame: frame._replace(dir=None),
    "direction unknown": lambda frame: frame._replace(dir=frame.dir or "rx"),
    "bus name not kept": lambda frame: frame._replace(bus=""),
    "last digits of the timestamp": _rounded,
    "no usable timestamp": lambda frame: frame._replace(t=None),
    "timestamp goes back": lambda frame: frame._replace(t=None),
    "bit rate switch or error state": lambda frame: frame._replace(flags=None),
    "in the classic frame format": lambda frame: frame._replace(fd=frame.len > 8, flags=None) if frame.fd else frame,
    "CAN FD frames?: not supported": lambda frame: None if frame.fd else frame,
    "raw DLC": lambda frame: frame._replace(raw=None),
    "requested length": lambda frame: frame._replace(len=0) if frame.rtr else frame,
    "class and details": lambda frame: frame._replace(id="", ext=False, len=0, data="") if frame.err else frame,
    "error frames?: not supported": lambda frame: None if frame.err else frame,
    "marker of lost frames": lambda frame: frame,
    "date unknown": lambda frame: frame,
}
"""What is taken from a frame before it is compared, where the loss was said."""


def _eased(frames: list[Frame], said: list[str]) -> list[Frame]:
    # A frame without a bus is on can0 where a format wants one.
    frames = [frame._replace(bus=frame.bus or "can0") for frame in frames]
    for line in said:
        ease = next((ease for words, ease in EASED.items() if re.search(words, line)), None)
        assert ease, line
        frames = [kept for frame in frames if (kept := ease(frame)) is not None]
    return frames


def _pairs() -> Iterator[Any]:
    """Every sample in every form; of those that are many and alike, each in one of them."""
    many = {"rules": WRITERS, "stories": FORMS}  # python-can's forms take their time
    turns = {folder: itertools.cycle(every) for folder, every in many.items()}
    for path in SAMPLES:
        name = str(path.relative_to(ROOT / "samples"))
        folder = name.partition("/")[0]
        each = many.get(folder, FORMS)
        for form in each if THOROUGH or folder not in turns else [next(turns[folder])]:
            kept = (
                "candump" if path.stem == "CAP006" and form == "mcap" else form
            )  # an MCAP file is read in the order of time
            yield pytest.param(path, kept, id=f"{name}-{form}")


@pytest.mark.parametrize(("path", "form"), list(_pairs()))
def test_comes_back_as_it_was(tmp_path: Path, path: Path, form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "from_process", read_here)  # saves seconds for each MF4
    frames, findings = _original(path)
    if not frames:
        pytest.skip("no frames in it")
    out = tmp_path / f"out.{form}"
    said = _converted(path, out, form)
    back, found = _frames(out)
    assert _eased(back, said) == _eased(frames, said)
    if not said:
        assert found == findings


@pytest.mark.parametrize("name", ["session.log", "session.L-x.log"])
def test_log_form_is_as_candump_writes_it(tmp_path: Path, name: str) -> None:
    path = ROOT / "samples/recorded" / name
    assert _converted(path, tmp_path / "out.log", "candump") == []
    assert (tmp_path / "out.log").read_bytes() == path.read_bytes()


@pytest.mark.parametrize("options", ["plain", "ta", "tA", "tz", "x"])
def test_console_form_is_as_candump_prints_it(tmp_path: Path, options: str) -> None:
    path = ROOT / f"samples/recorded/session.{options}.candump"
    assert _converted(path, tmp_path / "out.txt", "console") == []
    assert (tmp_path / "out.txt").read_bytes() == path.read_bytes()


def test_differences_become_times_of_their_own(tmp_path: Path) -> None:
    recorded = ROOT / "samples/recorded"
    _converted(recorded / "session.td.candump", tmp_path / "out.txt", "console")
    assert (tmp_path / "out.txt").read_bytes() == (recorded / "session.tz.candump").read_bytes()


RICH = """\
(1700000000.123456789) vcan0 123#1122334455667788_C T
(1700000000.123456790) can3 12345678#R8 R
(1700000000.2) can3 7FF#R T
(1700000001.000001) vcan0 123##3112233445566778899AABBCC R
(1700000001.000002) vcan0 00000123##2 R
(1700000001.000003) vcan0 20000008#0000040000000000 R
"""


@pytest.mark.parametrize("form", FORMS)
def test_everything_a_frame_can_have(tmp_path: Path, form: str) -> None:
    rich, out = tmp_path / "rich.log", tmp_path / f"out.{form}"
    rich.write_text(RICH)
    said = _converted(rich, out, form)
    assert _eased(_frames(out)[0], said) == _eased(_frames(rich)[0], said)


def test_the_same_bytes_whatever_the_time(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    canalyze("convert", notes, "a.log.gz")
    time.sleep(1.1)
    canalyze("convert", notes, "b.log.gz")
    assert (tmp_path / "a.log.gz").read_bytes() == (tmp_path / "b.log.gz").read_bytes()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize("form", forms())
def test_a_full_device_is_said_in_the_words_of_the_run(canalyze: Runner, notes: str, form: str) -> None:
    done = canalyze("convert", notes, "/dev/full", "--to", form)
    assert (done.code, done.complaints[-1]) == (2, "canalyze: /dev/full：无法写入：磁盘已满")


@pytest.mark.parametrize("how", ["same", "link", "hard", "stdin"])
def test_the_input_itself(canalyze: Runner, notes: str, tmp_path: Path, how: str) -> None:
    path, out = tmp_path / notes, tmp_path / "out.log"
    if how == "link":
        out.symlink_to(path)
    elif how == "hard":
        out.hardlink_to(path)
    else:
        out = path
    if how == "stdin":
        with path.open("rb") as file:
            line = command("convert", "-", str(out))
            done = subprocess.run(line, stdin=file, capture_output=True, env=environment(), check=False)
        code, err = done.returncode, done.stderr.decode()
    else:
        run = canalyze("convert", notes, out.name)
        code, err = run.code, run.err
    assert (code, err.count("\n")) == (2, 1)
    assert "输出就是输入文件" in err
    assert path.read_text() == NOTES
    assert canalyze("convert", "--force", notes, out.name).code == 0
    assert out.read_text().startswith("(0000000000.000000) can1 60A#4008100000000000\n")


@pytest.mark.parametrize("content", [b"", b"no frame here\n" * 5, bytes(range(256))])
@pytest.mark.parametrize("form", FORMS)
def test_nothing_readable_leaves_nothing(canalyze: Runner, tmp_path: Path, content: bytes, form: str) -> None:
    (tmp_path / "in.log").write_bytes(content)
    done = canalyze("convert", "in.log", "out", "--to", form)
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
    assert [path.name for path in tmp_path.iterdir()] == ["in.log"]


@pytest.mark.parametrize("form", sorted(set(forms()) & {"candump", "console", "asc", "mcap", "pcapng"}))
def test_nothing_readable_writes_nothing_to_a_pipe(canalyze: Runner, form: str) -> None:
    done = canalyze("convert", "-", "-", "--to", form, stdin=b"no frame\n")
    assert (done.code, done.out) == (2, "")
    assert done.complaints[-1].startswith("canalyze: stdin")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_directory_that_cannot_be_written(canalyze: Runner, notes: str, tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o555)
    done = canalyze("convert", notes, "closed/out.log")
    assert (done.code, done.out, len(done.complaints)) == (2, "", 1)


def test_a_full_disk_leaves_nothing(notes: str, tmp_path: Path) -> None:
    (tmp_path / "long.log").write_text(NOTES * 20_000)
    limited = ["bash", "-c", 'ulimit -f 100; trap "" XFSZ; exec "$@"', "-", *command("convert", "long.log", "out.log")]
    done = subprocess.run(limited, capture_output=True, cwd=tmp_path, env=environment(), check=False)
    assert (done.returncode, done.stderr.count(b"\n")) == (2, 1)
    assert not list(tmp_path.glob("out.log*"))


def test_a_pipe_answers_each_line_at_once(tmp_path: Path) -> None:
    process = _piped(tmp_path, "-", "-", "--to", "console")
    assert process.stdin and process.stdout
    for frame in NOTES.splitlines():
        process.stdin.write(frame.encode() + b"\n")
        process.stdin.flush()
        assert process.stdout.readline().decode() == f"  {frame}\n"
    _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, b"")


def _piped(directory: Path, *args: str) -> subprocess.Popen[bytes]:
    pipe = subprocess.PIPE
    line = command("--lang", "en", "convert", *args)
    return subprocess.Popen(line, stdin=pipe, stdout=pipe, stderr=pipe, cwd=directory, env=environment())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_pipe_keeps_what_was_read(tmp_path: Path, number: signal.Signals) -> None:
    process = _piped(tmp_path, "-", "out.txt")
    assert process.stdin
    process.stdin.write(NOTES.encode() + b"  can1  60A   [8]  40 08")
    process.stdin.flush()
    _until(lambda: any(path.stat().st_size for path in tmp_path.glob("out.txt.*.part")))
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert err == b"canalyze: out.txt: interrupted; holds the 10 frames read so far\n"
    assert (tmp_path / "out.txt").read_text() == "".join(f"  {line}\n" for line in NOTES.splitlines())


def test_an_interrupted_file_stays_a_part(canalyze: Runner, tmp_path: Path) -> None:
    (tmp_path / "long.log").write_text(NOTES * 200_000)
    process = _piped(tmp_path, "long.log", "out.log.xz")
    _until(lambda: any(path.stat().st_size for path in tmp_path.glob("out.log.xz.*.part")))
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    (part,) = tmp_path.glob("out.log.xz.*.part")
    said = f"canalyze: out.log.xz: interrupted; what was read so far is in {part.name}"
    assert err.decode().splitlines()[-1] == said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["long.log", part.name]
    assert 0 < json.loads(canalyze("info", "--format", "jsonl", part.name).out)["frames"] < 2_000_000


def _until(done: Callable[[], bool]) -> None:
    for _ in range(600):
        if done():
            return
        time.sleep(0.05)
    raise AssertionError("it did not happen within 30 s")


def test_broken_pipe_ends_quietly(tmp_path: Path) -> None:
    (tmp_path / "long.log").write_text(NOTES * 5000)
    with _piped(tmp_path, "long.log", "-", "--to", "console") as process:
        assert process.stdout and process.stderr
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(timeout=60) == 0


@pytest.mark.parametrize("form", FORMS)
def test_a_terminal_gets_no_bytes_that_are_no_text(tmp_path: Path, form: str) -> None:
    (tmp_path / "in.log").write_text("(1.5) can0 123#11\n")
    code, shown = on_terminal(tmp_path, "convert", "in.log", "-", "--to", form)
    if form in BINARY:
        assert (code, shown.count(b"\n")) == (2, 1)
    else:
        assert code == 0 and shown


@pytest.mark.parametrize("form", [form for form in FORMS if Target("x", form, None).written == RECORDS])
def test_a_form_of_python_can_wants_a_file_of_its_own(canalyze: Runner, notes: str, form: str) -> None:
    for args in (["-", "--to", form], [f"out.{form}.gz", "--to", form]):
        done = canalyze("convert", notes, *args)
        assert (done.code, done.out, len(done.complaints)) == (2, "", 1)
