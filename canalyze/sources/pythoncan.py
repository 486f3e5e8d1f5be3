"""What python-can reads (MF4, CSV, SQLite), in batches of records for the core.

Only this file and `pieces` read by it. Its readers give one message at a time and were not made for damaged files. So
they get text line by line (`lines`); what an exception ends is told as damage, what came before it stays, and what the
library prints, logs or warns becomes one line each. Must not: decode a format itself beyond that.

| form | channel | direction | stamps |
|---|---|---|---|
| mf4 | its number is the name's | yes | absolute, µs |
| csv, sqlite | `can0` | no | as they are, µs where they are dates |
"""

import gc
import struct
import tempfile
import traceback
from collections.abc import Generator, Iterator
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources import apart, packed
from canalyze.sources.database import Copy, bound, copied, heed
from canalyze.sources.heard import Heard
from canalyze.sources.library import has_asammdf, library
from canalyze.sources.packed import Packer, Unfit
from canalyze.sources.pieces import CsvText, Pieces, as_numbered, only

if TYPE_CHECKING:
    from canalyze.sources.compressed import Damage as Damaged
    from canalyze.sources.format import Opened

TITLES: Final = {"mf4": "MF4", "csv": "CSV", "sqlite": "SQLite"}
"""How a form is called in a sentence."""
_BATCH: Final = 4096
"""Most frames that are joined at once."""
_BYTES: Final = 128 << 10
"""Bytes of a batch."""
_TABLE: Final = "messages"
"""The table that python-can writes."""
_COMMAS: Final = 6
"""Of a row of python-can's table."""
_REMARKS: Final = 20
"""Most lines of the library's that are passed on."""


class PythonCanCapture:
    """An open input that python-can reads; a context manager with the face of `format.Capture`."""

    format: Final = "packed"

    def __init__(
        self, source: "Opened", head: bytes, form: str, *, trusting: bool = False, asked: bool = False
    ) -> None:
        """Take over the source; `head` is what was read of it already, `form` one of TITLES.

        trusting: in this process whatever the form, though the file may bring it down. asked: the user says that it has
        this form. SourceError if what the form
        needs is not installed.
        """
        self.name = source.name
        self.compression = source.compression
        """gzip, xz, bzip2 or zstd, if it is compressed."""
        self.regular = source.regular
        self._source = source
        self._form = form
        self._asked = asked
        self._heard = Heard()
        self._remarks: list[CanalyzeError] = []
        self._apart = form == "mf4" and not trusting
        self._records = self._batches(head)
        self._first = self._begun = False
        """The records given last were the first; some were given."""
        if form == "mf4" and not has_asammdf():
            raise SourceError("bridge.mf4", name=self.name, line="pip install 'canalyze[mf4]'")

    @property
    def taken(self) -> int:
        """Bytes of the file behind it that have been read: what progress counts."""
        return self._source.taken

    @property
    def kind(self) -> str:
        """The name of its format."""
        return self._form

    @property
    def damage(self) -> "Damaged | None":
        """Why the file could be unpacked no further; known when nothing comes any more."""
        return self._source.damage

    @property
    def begins(self) -> bool:
        """Whether the records given last begin under a check sum: of rows read ahead only the first can be told."""
        return self._first and self.compression is not None

    @property
    def checked(self) -> bool | None:
        """Whether all that was unpacked so far has a check sum; None: nothing is."""
        return self._source.checked

    @property
    def _broken(self) -> bool:
        return self._source.damage is not None

    def read(self) -> bytes:
        """Give the next records, b"" at the end; SourceError if the system refuses or nothing can be read."""
        with self._heard:
            batch = next(self._records, b"")
        self._first, self._begun = not self._begun, True
        for line in self._heard.take():
            self._remarks.append(SourceError("bridge.said", name=self.name, problem=line))
        return batch

    def rests(self) -> bool:
        """Tell whether nothing more comes at the moment: python-can reads what is there at once."""
        return False

    def remarks(self) -> list[CanalyzeError]:
        """Give what is to be told of the file since the last call, for standard error."""
        remarks, self._remarks = self._remarks, []
        return remarks

    def __enter__(self) -> Self:
        """Give the capture itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Close it."""
        self._records.close()
        self._source.close()

    def _batches(self, head: bytes) -> Generator[bytes, None, None]:
        if self._apart:
            yield from self._from_path(head)
            return
        can = library()
        yield packed.dialect("reader", f"python-can {can.__version__}")
        if self._form in ("mf4", "sqlite"):
            yield from self._from_path(head)
            return
        pieces: Pieces = CsvText(self)
        data = head
        while data:
            yield from _batched(pieces.feed(data))
            data = self._source.read()
        yield from _batched(pieces.end(broken=self._broken))

    def _from_path(self, head: bytes) -> Iterator[bytes]:
        """Read what its reader opens by name: the file itself, or what was in it put down elsewhere."""
        with tempfile.TemporaryDirectory(prefix="canalyze-") as directory:
            path = self._source.path
            copy = None
            try:
                if path is None:
                    path = Path(directory, f"spool.{self._form}")
                    self._put_down(path, head)
                    copy = Copy(path, None) if self._form == "sqlite" else None
                elif self._form == "sqlite":  # its reader would write in the file
                    copy = copied(path, Path(directory))
            except OSError as error:
                raise SourceError("source.read", name=self.name, error=error) from error
            if copy and copy.computes(_TABLE):
                raise SourceError("bridge.computed", name=self.name, table=_TABLE)
            if self._apart:
                yield from self._from_other_process(path, Path(directory))
            else:
                yield from _batched(self._messages(copy.path if copy else path, copy))

    def _from_other_process(self, path: Path, scratch: Path) -> Iterator[bytes]:
        batches = 0
        try:
            for tag, piece in apart.pieces(path, scratch):
                if tag == apart.RECORDS:
                    batches += 1
                    yield piece
                elif tag == apart.REMARK:
                    self.remark(piece.decode())
                elif tag == apart.REFUSED:
                    raise self.refused(piece.decode())
        except apart.BroughtDown as error:
            problem = f"asammdf: {error}"
            if batches < 2:  # the first says whose they are
                raise self.refused(problem) from error
            self.remark(problem)
            yield packed.damage(packed.REST, 0)

    def _put_down(self, path: Path, data: bytes) -> None:
        with path.open("wb") as spool:
            while data:
                spool.write(data)
                data = self._source.read()

    def _messages(self, path: Path, copy: Copy | None) -> Iterator[bytes]:
        can = library(mf4=self._form == "mf4")
        packer = Packer(6, directed=self._form == "mf4", bus=as_numbered if self._form == "mf4" else only)
        row = 0
        problem = None
        try:
            reader: Any = can.MF4Reader(str(path)) if self._form == "mf4" else can.SqliteReader(str(path), _TABLE)
            if copy:
                bound(reader._conn)
            with reader:
                for message in reader:
                    if copy and row >= copy.most_rows:
                        break
                    row += 1
                    try:
                        if packer.directed:  # the date was added to it: more than µs is noise
                            message.timestamp = round(message.timestamp, 6)
                        yield packer.frame(message)
                    except (Unfit, TypeError, ValueError, struct.error) as error:
                        yield packed.unreadable(error.reason if isinstance(error, Unfit) else packed.DATA, row)
        except Exception as error:  # whatever a stranger's file makes the library raise
            heed(error)
            problem = _said(error)
            traceback.clear_frames(error.__traceback__)
        if problem:
            reader = None
            gc.collect()  # what the library says when it is thrown away is heard as well
            if packer.frames == 0:
                raise self.refused(problem)
        if copy and copy.cut:
            if not self._broken:
                yield packed.damage(packed.CUT, *copy.cut)
        elif problem:
            self.remark(problem)
            yield packed.damage(packed.REST, 0)
        elif self._heard.errors or (copy and not copy.sound()):  # asammdf goes on without what it could not read
            yield packed.damage(packed.STRUCTURE, 0)

    def remark(self, problem: str) -> None:
        """Have something told that was wrong with the file."""
        if len(self._remarks) < _REMARKS:
            self._remarks.append(SourceError("bridge.said", name=self.name, problem=problem))

    def refused(self, problem: str) -> SourceError:
        """Give the error of a file that cannot be read at all."""
        said: dict[str, str] = {"name": self.name, "form": TITLES[self._form], "problem": problem}
        if self._asked:
            from canalyze.sources.format import input_formats

            return SourceError("bridge.unfit", **said, formats=", ".join(input_formats()))
        return SourceError("bridge.unreadable", **said)


def _batched(records: Iterator[bytes]) -> Iterator[bytes]:
    """Join records to batches; what was there before an error comes before it."""
    batch: list[bytes] = []
    size = 0
    stopped: SourceError | None = None
    try:
        for record in records:
            batch.append(record)
            size += len(record)
            if size >= _BYTES:
                yield b"".join(batch)
                batch, size = [], 0
    except SourceError as error:
        stopped = error
    if size:
        yield b"".join(batch)
    if stopped:
        raise stopped


def _said(error: BaseException) -> str:
    """Give an exception of the library in one line."""
    text = " ".join(str(error).split())[:200]
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
