"""Recordings of a live bus: `Live` hands its blocks to them, whatever is shown of it.

A session of its own turns the blocks into the format of the file. Each piece is with the system as soon as `take`
returns, so that a killed process leaves a readable file. A file that cannot be written is told once and left; nothing
here stops the listening. Must not: know a frame, or print.
"""

import errno
import os
import re
import stat
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

from canalyze.errors import CanalyzeError, OutputError, as_error
from canalyze.output.files import in_place
from canalyze.sinks import suffixes
from canalyze.sources.live import BUS, MESSAGES, RECORDS, heads
from canalyze.words import Words

FORMS: Final = ("candump", "asc", "mcap", "pcapng")
"""Formats that are readable up to where a process was killed."""

_LOOK_S: Final = 1.0
"""Interval of checks that a file still exists."""
_MCAP: Final = b"\x89MCAP0\r\n"
"""First and last bytes of an MCAP."""
_LOSSES: Final = 20
"""Most lines of losses that are kept of one recording."""

_LIMIT: Final = re.compile(r"([0-9]+(?:\.[0-9]+)?)\s*([A-Za-z]+)")
_BYTES: Final = {
    **dict.fromkeys(("k", "K", "kB", "KB", "kb"), 10**3),
    **dict.fromkeys(("M", "MB", "mb"), 10**6),
    **dict.fromkeys(("G", "GB", "gb"), 10**9),
    "KiB": 1 << 10,
    "MiB": 1 << 20,
    "GiB": 1 << 30,
}
_SECONDS: Final = {"s": 1, "min": 60, "m": 60, "h": 3600, "d": 86400}


class Limit(NamedTuple):
    """When a file is full: by its bytes, or by its age in seconds."""

    size: int | None
    seconds: float | None


def limit(text: str) -> Limit | None:
    """Reads a size (100MB, 64MiB, 500k) or a time (30s, 10m, 1h); None for what is neither."""
    match = _LIMIT.fullmatch(text.strip())
    if match is None:
        return None
    amount, unit = float(match[1]), match[2]
    if unit in _BYTES:
        size = round(amount * _BYTES[unit])
        return Limit(size, None) if size > 0 else None
    return Limit(None, amount * _SECONDS[unit]) if unit in _SECONDS and amount > 0 else None


def recordable() -> dict[str, str]:
    """Returns the formats by the ends of names that a recording may have."""
    return {suffix: form for suffix, form in suffixes().items() if form in FORMS}


def form_of(name: str) -> str | None:
    """Returns the format of a recording of that name; None without one that can be recorded."""
    return recordable().get(Path(name).suffix.lower())


@dataclass
class Written:
    """The result of one recording."""

    name: str
    """As the user has named it."""
    files: list[str]
    """Those that are there; the oldest first."""
    bytes: int = 0
    """In those files."""
    frames: int = 0
    """In those files."""
    deleted: int = 0
    """Files of the row that are there no more."""
    frames_deleted: int = 0
    failure: str = ""
    """Why it was broken off; "" if it was not."""

    def in_words(self, words: Words) -> str:
        """Returns its result in words."""
        facts = {"frames": self.frames, "size": _size(self.bytes)}
        if len(self.files) + self.deleted > 1:
            facts |= {"first": self.files[0], "last": self.files[-1], "files": len(self.files)}
            parts = [words("record.files", **facts)]
            parts += [words("record.deleted", count=self.deleted, frames=self.frames_deleted)] if self.deleted else []
        else:
            parts = [words("record.file", name=self.files[0], **facts)]
        if self.failure:
            parts.append(words("record.broken_off"))
        return words("listen.comma").join(parts)


def _size(size: int) -> str:
    for unit, least in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if size >= least:
            return f"{size / least:.1f} {unit}"
    return f"{size} B"


def _is_unfinished(name: str) -> bool:
    """Returns true for an MCAP file without its end, as a killed process leaves it."""
    try:
        with Path(name).open("rb") as file:
            begin = file.read(len(_MCAP))
            file.seek(-len(_MCAP), os.SEEK_END)
            return begin == _MCAP and file.read() != _MCAP
    except OSError:
        return False


class Recording:
    """One recording: a file, or a row of them where there is a limit."""

    def __init__(
        self, name: str, words: Words, *, limit: Limit | None = None, keep: int | None = None, force: bool = False
    ) -> None:
        """Opens the first file; OutputError if it exists and is not to be replaced, or cannot be written.

        The format is told by the name (`form_of`). keep: so many files are left, those before them are deleted.
        """
        self.written = Written(name, [])
        self._words = words
        self._form = form_of(name) or FORMS[0]
        self._limit = limit
        self._keep = keep
        self._force = force
        self._number = 0
        self._held: dict[str, tuple[int, int]] = {}
        """Bytes and frames of the files of a row that may be deleted."""
        self._losses: list[str] = []
        self._said: list[CanalyzeError] = []
        self._names: dict[int, bytes] = {}
        self._fd = -1
        if limit is not None and not force:
            for other in sorted(self._others()):
                raise OutputError("output.exists", name=other)
        self._open(self._next_name())

    def _others(self) -> list[str]:
        path = Path(self.written.name)
        numbered = re.compile(re.escape(path.stem) + r"-[0-9]{4,}" + re.escape(path.suffix))
        folder = path.parent
        try:
            return [str(folder / one.name) for one in folder.iterdir() if numbered.fullmatch(one.name)]
        except OSError:  # opening the file says why
            return []

    def _next_name(self) -> str:
        self._number += 1
        if self._limit is None:
            return self.written.name
        path = Path(self.written.name)
        return str(path.with_name(f"{path.stem}-{self._number:04}{path.suffix}"))

    def _open(self, name: str) -> None:
        from canalyze._core import Session
        from canalyze.running.reading import SessionOptions

        self._replaces = os.path.lexists(name)
        with suppress(OSError, ValueError):  # opening it says what is wrong
            mode = Path(name).stat().st_mode
            if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):  # receiving would wait for whoever reads a pipe
                raise OutputError("record.no_file", name=name)
        try:
            self._fd = in_place(name, force=self._force, typed=self._limit is None)
        except FileExistsError as error:
            if Path(name).is_dir():
                raise OutputError("output.write", name=name, error=IsADirectoryError(errno.EISDIR, "")) from error
            key = "record.unfinished" if self._form == "mcap" and _is_unfinished(name) else "output.exists"
            raise OutputError(key, name=name) from error
        except (OSError, ValueError) as error:
            raise OutputError("output.write", name=name, error=error) from error
        self._name, self._size = name, 0
        self._began = self._looked = time.monotonic()
        self._session = Session(SessionOptions(self._words.lang, "convert", to=self._form))
        self._session.begin("live", False, "live")
        self.written.files.append(name)
        if self._names:
            self._write(self._session.feed(b"".join(self._names.values())))

    def abandon(self) -> None:
        """Leaves everything as it was, where nothing was written yet."""
        fd, self._fd = self._fd, -1
        os.close(fd)
        if not self._replaces:
            Path(self._name).unlink(missing_ok=True)

    def take(self, blocks: bytes) -> None:
        """Writes whole blocks of the live stream. A failure is among `remarks`."""
        if self._fd < 0:
            return
        try:
            if self._limit is None:
                self._write(self._session.feed(blocks))
            else:
                self._take_apart(blocks)
            self._look()
        except OutputError as error:
            self._fail(error)

    def _take_apart(self, blocks: bytes) -> None:
        """Writes block by block: a file that is full ends before frames."""
        start = 0
        for kind, bus, _, at, end in heads(blocks):
            if kind == BUS:
                self._names[bus] = blocks[at:end]
            if kind in (MESSAGES, RECORDS):
                if at > start:
                    self._write(self._session.feed(blocks[start:at]))
                    start = at
                if self._full():
                    self._turn()
        self._write(self._session.feed(blocks[start:]))

    def _full(self) -> bool:
        if self._limit is None or self._session.frames == 0:
            return False
        size, seconds = self._limit
        by_size = size is not None and self._size >= size
        return by_size or (seconds is not None and time.monotonic() - self._began >= seconds)

    def _turn(self) -> None:
        self._finish()
        name = self._next_name()
        while not self._force and os.path.lexists(name):  # somebody else's
            name = self._next_name()
        self._open(name)
        self._drop_oldest()  # not before: where no further file can be opened, the last one is all there is

    def _drop_oldest(self) -> None:
        """Deletes files beyond those that are kept; one that cannot be deleted is reported once and left."""
        while self._keep is not None and len(self.written.files) > self._keep:
            name = self.written.files.pop(0)
            size, frames = self._held.pop(name, (0, 0))
            self.written.bytes -= size
            self.written.frames -= frames
            try:
                Path(name).unlink(missing_ok=True)
                self.written.deleted += 1
                self.written.frames_deleted += frames
            except OSError as error:
                self._said.append(OutputError("record.kept", name=name, error=error))

    def _write(self, data: bytes) -> None:
        if not data:
            return
        view = memoryview(data)
        try:
            if self._size == 0:
                os.ftruncate(self._fd, 0)  # not when it is opened: another recording may still be refused
            while view:
                view = view[os.write(self._fd, view) :]
        except OSError as error:
            self._cut()
            raise OutputError("record.failed", name=self._name, error=error) from error
        self._size += len(data)

    def _cut(self) -> None:
        """Removes the part of a piece that was written: a file ends with a whole frame."""
        with suppress(OSError):
            os.ftruncate(self._fd, self._size)

    def _look(self) -> None:
        """Raises if the file is no longer where it was opened: what is written would be lost in silence."""
        now = time.monotonic()
        if now - self._looked < _LOOK_S:
            return
        self._looked = now
        try:
            there = os.path.samestat(Path(self._name).stat(), os.fstat(self._fd))
        except OSError:
            there = False
        if not there:
            raise OutputError("record.gone", name=self._name)

    def _finish(self) -> None:
        """Ends the file that is written."""
        try:
            self._write(self._session.end())
            self._write(self._session.finish())
        finally:
            self._account()

    def _account(self) -> None:
        """Counts what is in the file, and closes it."""
        fd, self._fd = self._fd, -1
        self.written.bytes += self._size
        self.written.frames += self._session.frames
        if self._keep is not None:
            self._held[self._name] = self._size, self._session.frames
        room = _LOSSES - len(self._losses)
        self._losses += self._session.losses(self._name)[:room]
        with as_error(OutputError, "record.failed", name=self._name):
            if self._size == 0:
                os.ftruncate(fd, 0)
            os.close(fd)

    def _fail(self, error: OutputError) -> None:
        self.written.failure = error.in_words(self._words)
        self._said.append(error)
        if self._fd >= 0:
            with suppress(OutputError):
                self._account()

    def remarks(self) -> list[CanalyzeError]:
        """Returns what is to be reported since the last call, for standard error."""
        said, self._said = self._said, []
        return said

    def close(self) -> None:
        """Ends it; closing twice is harmless."""
        if self._fd < 0:
            return
        try:
            self._finish()
        except OutputError as error:
            self._fail(error)

    def losses(self) -> list[str]:
        """Returns what the format could not hold, a line each in words; after `close`."""
        return self._losses


class Recordings:
    """Several recordings of the same bus; one that fails does not stop the others."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        """Takes them; they are closed with this."""
        self._recordings = tuple(recordings)
        self._lock = threading.Lock()

    @property
    def failed(self) -> bool:
        """True if one of them was broken off."""
        return any(one.written.failure for one in self._recordings)

    @property
    def written(self) -> list[Written]:
        """The result of each."""
        return [one.written for one in self._recordings]

    def take(self, blocks: bytes) -> None:
        """Hands whole blocks of the live stream to each; never raises."""
        with self._lock:
            for one in self._recordings:
                one.take(blocks)

    def remarks(self) -> list[CanalyzeError]:
        """Returns what is to be reported since the last call, for standard error."""
        with self._lock:
            return [remark for one in self._recordings for remark in one.remarks()]

    def close(self) -> None:
        """Ends all of them; closing twice is harmless."""
        with self._lock:
            for one in self._recordings:
                one.close()

    def losses(self) -> list[str]:
        """Returns what the formats could not hold, a line each in words; after `close`."""
        return [line for one in self._recordings for line in one.losses()]


def open_recordings(
    names: Sequence[str], words: Words, *, limit: Limit | None, keep: int | None, force: bool
) -> Recordings:
    """Opens all of them, or none; OutputError as `Recording` has it."""
    opened: list[Recording] = []
    try:
        for name in names:
            opened.append(Recording(name, words, limit=limit, keep=keep, force=force))
    except OutputError:
        for one in opened:
            one.abandon()
        raise
    return Recordings(opened)
