"""Recordings of what is seen: every format, rotation, what happens to one that cannot write. No bus is needed."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
import pytest

from canalyze._core import Session
from canalyze.errors import OutputError
from canalyze.running import recording
from canalyze.running.reading import SessionOptions
from canalyze.running.recording import Limit, Recording, Recordings, limit, open_recordings
from canalyze.sources import live
from canalyze.sources.bridge import Packer
from canalyze.words import Words

EN = Words("en")
START = 1_700_000_000.0


def blocks(first: int, count: int, *, bus: int = 0, name: str = "can0") -> bytes:
    """Frames 10 ms apart, with the name of their bus and the time after them."""
    packer = Packer(6, directed=True, bus=lambda _: name)
    made = []
    for number in range(first, first + count):
        data = number.to_bytes(4, "little")
        stamp = START + number / 100
        made.append(packer.frame(can.Message(timestamp=stamp, arbitration_id=0x185, data=data, is_extended_id=False)))
    until = live.until_block(round((START + (first + count) / 100) * 1e9))
    return live.name_block(bus, name) + live.records_block(bus, b"".join(made), count) + until


def lines(path: Path, form: str = "") -> list[str]:
    """The frames of a file as candump writes them, however it ends."""
    from canalyze.sources import open_capture

    session = Session(SessionOptions(lang="en", format="convert", to="candump"))
    out = b""
    with open_capture(str(path)) as capture:
        assert not form or capture.format == form
        session.begin(path.name, True, capture.format)
        while data := capture.read():
            out += session.feed(data)
    out += session.end() + session.finish()
    return out.decode().splitlines()


def expected(first: int, count: int) -> list[str]:
    session = Session(SessionOptions(lang="en", format="convert", to="candump"))
    session.begin("live", False, "live")
    return (session.feed(blocks(first, count)) + session.end() + session.finish()).decode().splitlines()


FORMS = [(".log", "candump"), (".candump", "candump"), (".asc", "asc"), (".mcap", "mcap"), (".pcapng", "pcapng")]


def plain(found: list[str]) -> list[str]:
    """Without what formats write in their own way: digits that are zero, a direction that is not known."""
    return [
        line.replace("000)", ")", 1) if line.index(")") > 20 else line
        for line in (one.removesuffix(" R") for one in found)
    ]


def test_a_folder_is_not_said_to_be_overwritten(tmp_path: Path) -> None:
    (tmp_path / "bus.log").mkdir()
    for force in (False, True):
        with pytest.raises(OutputError, match=r"bus\.log: cannot write: is a directory"):
            Recording(str(tmp_path / "bus.log"), EN, force=force)


@pytest.mark.parametrize(("suffix", "form"), FORMS)
def test_every_format_has_every_frame(tmp_path: Path, suffix: str, form: str) -> None:
    path = tmp_path / f"bus{suffix}"
    one = Recording(str(path), EN)
    for place in range(0, 500, 100):
        one.take(blocks(place, 100))
    one.close()
    one.close()
    assert plain(lines(path, form)) == plain(expected(0, 500))
    assert (one.written.frames, one.written.bytes, one.written.failure) == (500, path.stat().st_size, "")
    assert one.remarks() == []


@pytest.mark.parametrize(("suffix", "form"), FORMS)
def test_what_was_written_can_be_read_before_the_end(tmp_path: Path, suffix: str, form: str) -> None:
    """As if the process were killed: nothing is done that the next line does not ask for."""
    path = tmp_path / f"bus{suffix}"
    one = Recording(str(path), EN)
    for place in range(0, 500, 10):
        one.take(blocks(place, 10))
    there = plain(lines(path, form))
    wanted = plain(expected(0, 500))
    assert there == wanted[: len(there)]
    assert len(there) >= (400 if form == "mcap" else 500)
    one.close()


def test_an_existing_file_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "bus.log"
    path.write_text("precious\n")
    with pytest.raises(OutputError, match=r"bus\.log: file exists; use --force"):
        Recording(str(path), EN)
    assert path.read_text() == "precious\n"
    one = Recording(str(path), EN, force=True)
    one.take(blocks(0, 3))
    one.close()
    assert lines(path) == expected(0, 3)


def test_a_file_of_an_earlier_rotation_is_kept(tmp_path: Path) -> None:
    (tmp_path / "bus-0003.log").write_text("precious\n")
    with pytest.raises(OutputError, match=r"bus-0003\.log: file exists"):
        Recording(str(tmp_path / "bus.log"), EN, limit=Limit(1000, None))
    assert [one.name for one in tmp_path.iterdir()] == ["bus-0003.log"]


def test_several_are_opened_or_none(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="no such file or directory"):
        names = [str(tmp_path / "a.log"), str(tmp_path / "missing" / "b.log")]
        open_recordings(names, EN, limit=None, keep=None, force=False)
    assert not list(tmp_path.iterdir())


def test_what_was_to_be_replaced_stays_where_not_all_can_be_opened(tmp_path: Path) -> None:
    before, new = tmp_path / "a.log", tmp_path / "b.log"
    before.write_text("(1.000000) can0 123#\n")
    with pytest.raises(OutputError, match="no such file or directory"):
        names = [str(before), str(new), str(tmp_path / "missing" / "c.log")]
        open_recordings(names, EN, limit=None, keep=None, force=True)
    assert before.read_text() == "(1.000000) can0 123#\n" and not new.exists()


def test_what_is_replaced_leaves_nothing(tmp_path: Path) -> None:
    for frames in (0, 1):
        path = tmp_path / "a.log"
        path.write_text("(1.000000) can0 123#\n" * 100)
        one = Recording(str(path), EN, force=True)
        one.take(blocks(0, frames))
        one.close()
        assert path.read_text().count("\n") == frames and " 123#" not in path.read_text()


@pytest.mark.parametrize("suffix", [".log", ".asc", ".mcap", ".pcapng"])
def test_rotation_by_size_loses_nothing(tmp_path: Path, suffix: str) -> None:
    one = Recording(str(tmp_path / f"bus{suffix}"), EN, limit=Limit(4000, None))
    for place in range(0, 3000, 25):
        one.take(blocks(place, 25))
    one.close()
    files = [Path(name) for name in one.written.files]
    assert [file.name for file in files[:2]] == [f"bus-0001{suffix}", f"bus-0002{suffix}"]
    assert sorted(tmp_path.iterdir()) == files and len(files) > 3
    parts = [lines(file) for file in files]  # each is read by itself
    assert all(parts)
    assert plain([line for part in parts for line in part]) == plain(expected(0, 3000))
    assert all(file.stat().st_size < 8000 for file in files)
    assert one.written.bytes == sum(file.stat().st_size for file in files)
    assert one.written.frames == 3000


def test_rotation_by_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    one = Recording(str(tmp_path / "bus.log"), EN, limit=Limit(None, 60.0))
    for place in range(0, 100, 10):
        one.take(blocks(place, 10))
        one.take(live.until_block(0))  # a silent bus makes no empty files
        now[0] += 30.0
    one.close()
    assert [len(lines(Path(name))) for name in one.written.files] == [20] * 5


def test_a_silent_bus_makes_no_empty_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    one = Recording(str(tmp_path / "bus.log"), EN, limit=Limit(None, 1.0))
    for _ in range(10):
        now[0] += 10.0
        one.take(live.until_block(round(now[0] * 1e9)))
    one.close()
    assert [Path(name).name for name in one.written.files] == ["bus-0001.log"]


def test_the_oldest_are_deleted(tmp_path: Path) -> None:
    one = Recording(str(tmp_path / "bus.log"), EN, limit=Limit(2000, None), keep=3)
    for place in range(0, 2000, 10):
        one.take(blocks(place, 10))
    one.close()
    kept = [Path(name) for name in one.written.files]
    assert sorted(tmp_path.iterdir()) == kept and len(kept) == 3
    left = [line for file in kept for line in lines(file)]
    assert left == expected(0, 2000)[-len(left) :]
    assert one.written.deleted == int(kept[0].stem[-4:]) - 1
    assert (one.written.frames, one.written.frames_deleted) == (len(left), 2000 - len(left))
    assert one.written.bytes == sum(file.stat().st_size for file in kept)


@pytest.mark.parametrize("keep", [1, 2])
def test_the_last_file_stays_where_no_further_one_can_be_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, keep: int
) -> None:
    """A disk that has become read-only, for example."""
    one = Recording(str(tmp_path / "bus.log"), EN, limit=Limit(400, None), keep=keep)
    one.take(blocks(0, 10))
    one.take(blocks(10, 10))
    open_, name = os.open, one.written.files[-1]

    def refuse(path: Any, *how: Any) -> int:
        if Path(path).parent == tmp_path:
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        return open_(path, *how)

    with monkeypatch.context() as patch:
        patch.setattr(os, "open", refuse)
        one.take(blocks(20, 10))
    one.close()
    assert one.written.files[-1] == name and one.written.failure
    assert lines(Path(name)) == expected(10, 10)
    assert "bus-0002.log" in one.written.in_words(EN)


def test_one_that_cannot_be_deleted_is_not_counted_as_deleted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(Path, "unlink", refuse)
    one = Recording(str(tmp_path / "bus.log"), EN, limit=Limit(400, None), keep=1)
    for place in range(0, 30, 10):
        one.take(blocks(place, 10))
    one.close()
    assert (one.written.deleted, len(one.written.files), len(one.remarks())) == (0, 1, 2)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
@pytest.mark.parametrize("force", [False, True])
def test_what_is_no_file_is_refused_at_once(tmp_path: Path, force: bool) -> None:
    """Receiving would wait for whoever reads a pipe, and opening it does already."""
    os.mkfifo(tmp_path / "pipe.log")
    (tmp_path / "null.log").symlink_to(os.devnull)
    for name in ("pipe.log", "null.log"):
        with pytest.raises(OutputError, match="not a regular file"):
            Recording(str(tmp_path / name), EN, force=force)


def test_a_name_that_somebody_else_took_is_passed_over(tmp_path: Path) -> None:
    one = Recording(str(tmp_path / "bus.log"), EN, limit=Limit(400, None))
    one.take(blocks(0, 10))
    (tmp_path / "bus-0002.log").write_text("precious\n")
    one.take(blocks(10, 10))
    one.close()
    assert [Path(name).name for name in one.written.files] == ["bus-0001.log", "bus-0003.log"]
    assert (tmp_path / "bus-0002.log").read_text() == "precious\n"


def full_after(room: int) -> Callable[[int, Any], int]:
    """A disk that has so many bytes left: the last write is done in part."""
    write, left = os.write, [room]

    def write_some(fd: int, data: Any) -> int:
        if left[0] <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = write(fd, data[: left[0]])
        left[0] -= written
        return written

    return write_some


@pytest.mark.parametrize("suffix", [".log", ".mcap", ".pcapng"])
def test_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str) -> None:
    """It is told once and at once; the file ends with a whole frame, and the others go on."""
    broken = Recording(str(tmp_path / f"bus{suffix}"), EN)
    other = Recording(str(tmp_path / "other.log"), EN)
    both = Recordings([broken, other])
    both.take(blocks(0, 400))
    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full_after(150))
        broken.take(blocks(400, 400) + blocks(800, 400))
    (remark,) = both.remarks()
    for lang, said in (("zh", "磁盘已满"), ("en", "no space left on device; recording stopped, listening continues")):
        assert said in remark.in_words(Words(lang))
    both.take(blocks(400, 100))
    both.close()
    assert both.failed and not both.remarks()
    assert lines(tmp_path / "other.log") == expected(0, 500)
    there = plain(lines(tmp_path / f"bus{suffix}"))
    assert there == plain(expected(0, 400))[: len(there)]
    assert (tmp_path / f"bus{suffix}").stat().st_size == broken.written.bytes


def test_a_file_that_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "_LOOK_S", 0.0)
    folder = tmp_path / "usb"
    folder.mkdir()
    one = Recording(str(folder / "bus.log"), EN)
    one.take(blocks(0, 10))
    (folder / "bus.log").unlink()
    folder.rmdir()
    one.take(blocks(10, 10))
    (remark,) = one.remarks()
    assert "the file is gone" in str(remark)
    assert one.written.failure


def test_a_directory_that_is_gone_at_a_rotation(tmp_path: Path) -> None:
    folder = tmp_path / "usb"
    folder.mkdir()
    one = Recording(str(folder / "bus.log"), EN, limit=Limit(400, None))
    one.take(blocks(0, 10))
    (folder / "bus-0001.log").unlink()
    folder.rmdir()
    one.take(blocks(10, 10))
    one.take(blocks(20, 10))
    assert len(one.remarks()) == 1
    one.close()


def test_buses_are_named_in_every_file(tmp_path: Path) -> None:
    one = Recording(str(tmp_path / "bus.log"), EN, limit=Limit(600, None))
    one.take(live.name_block(0, "can0") + live.name_block(1, "can1"))
    for place in range(0, 200, 10):
        named = blocks(place, 10, bus=place // 10 % 2, name=f"can{place // 10 % 2}")
        one.take(b"".join(named[at:end] for kind, _, _, at, end in live.heads(named) if kind != live.BUS))
    one.close()
    found = [line for name in one.written.files for line in lines(Path(name))]
    assert len(one.written.files) > 3
    assert [line.split()[1] for line in found] == [f"can{number // 10 % 2}" for number in range(200)]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("100MB", Limit(100_000_000, None)),
        ("100M", Limit(100_000_000, None)),
        ("64MiB", Limit(64 << 20, None)),
        ("1.5k", Limit(1500, None)),
        ("1GiB", Limit(1 << 30, None)),
        ("30s", Limit(None, 30.0)),
        ("10m", Limit(None, 600.0)),
        ("1h", Limit(None, 3600.0)),
        ("0s", None),
        ("0MB", None),
        ("100", None),
        ("1x", None),
        ("", None),
        ("-1h", None),
    ],
)
def test_limits(text: str, found: Limit | None) -> None:
    assert limit(text) == found


def test_names_that_can_be_recorded() -> None:
    assert set(recording.recordable().values()) == set(recording.FORMS)
    assert recording.form_of("a.LOG") == "candump"
    assert recording.form_of("a.log.gz") is None
    assert recording.form_of("a.blf") is None
