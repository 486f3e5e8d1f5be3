"""What becomes of the bytes of a form that python-can reads in this process: records for the core.

Text goes to its reader line by line (`trace`). Must not: open a file, or say
anything to a person.
"""

import struct
from collections import Counter
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final, Protocol, TextIO, cast

from canalyze.sources import packed
from canalyze.sources.library import library
from canalyze.sources.packed import Packer, Unfit
from canalyze.sources.trace import DAMAGED, PASSED_OVER, Lines, Rows, Trc, is_damaged, number_of

if TYPE_CHECKING:
    from can import Message

    from canalyze.sources.pythoncan import PythonCanCapture

_COMMAS: Final = 6
"""Of a row of python-can's table."""


class Pieces(Protocol):
    """What becomes of the bytes of one form."""

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Take the next bytes; give records."""

    def end(self, *, broken: bool) -> Iterator[bytes]:
        """Take the end of the file; give the rest. `broken`: it was unpacked only so far, reported elsewhere."""


def _peak(channel: object) -> str:
    """Give the bus of a channel counted from 1, as PEAK does."""
    return f"can{max(channel - 1, 0)}" if isinstance(channel, int) else "can0"


def as_numbered(channel: object) -> str:
    """Give the bus of a channel by its number as it stands."""
    return f"can{channel}" if isinstance(channel, int) else "can0"


def _channels(packer: Packer) -> Iterator[bytes]:
    """Say which bus a channel of the file is."""
    known = [f"{channel} = {bus}" for channel, bus in packer.buses.items() if isinstance(channel, int)]
    if known:
        yield packed.dialect("channels", ", ".join(known))


def only(_: object) -> str:
    """Give the bus of a form that has no channels."""
    return "can0"


class Text:
    """Lines through one of python-can's readers of text."""

    def __init__(self, capture: "PythonCanCapture", lines: Lines, packer: Packer) -> None:
        """Read for a capture, which says what is wrong with it; `lines` as the library wants them."""
        self.lines = lines
        self.packer = packer
        self.capture = capture
        self.counts: Counter[str] = Counter()
        self.out: list[bytes] = []
        """Records that are not given yet."""
        self.before: Callable[[Message], None] | None = None
        """Looks at a message before it is packed."""
        lines.unanswered = self._unanswered

    def reader(self) -> "Iterator[Message]":
        """Give a reader that goes on with the next line."""
        raise NotImplementedError

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Take the next bytes; give records."""
        self.lines.feed(data)
        yield from self.drain()

    def end(self, *, broken: bool) -> Iterator[bytes]:
        """Take the end of the file; give the rest."""
        if not broken:
            self.lines.end()
        yield from self.drain()
        for what, count in sorted(self.counts.items()):
            yield packed.passed_over(what, count)

    def drain(self) -> Iterator[bytes]:
        """Read the lines that are there; one that the library cannot read costs only itself."""
        lines, frame, before = self.lines, self.packer.frame, self.before
        out = self.out
        append = out.append
        while lines.waiting:
            try:
                for message in self.reader():
                    lines.answered = True
                    try:
                        if before:
                            before(message)
                        append(frame(message, lines.number))
                    except (Unfit, TypeError, struct.error) as error:
                        reason = error.reason if isinstance(error, Unfit) else packed.DATA
                        out.append(self._unreadable(reason))
            except Exception:  # of the line: its message says nothing that the line does not
                lines.answered = True
                out.append(self._unreadable(packed.NO_FRAME))
            lines.settle()
        yield b"".join(out)
        out.clear()

    def _unanswered(self) -> None:
        self.out.append(self.nothing())

    def nothing(self) -> bytes:
        """Give the record of a line of which nothing came."""
        return self._unreadable(packed.NO_FRAME)

    def _unreadable(self, reason: int) -> bytes:
        """Say of the last line that it cannot be read; one without its end was cut."""
        number = self.lines.number
        return packed.unreadable(packed.CUT_LINE if number == self.lines.endless else reason, number)


class TrcText(Text):
    """PEAK's traces."""

    def __init__(self, capture: "PythonCanCapture") -> None:
        """Read for a capture."""
        from canalyze._core import omission

        self._trc = Trc()
        super().__init__(capture, Lines(self._trc.change), Packer(3, directed=False, bus=_peak))
        self.before = self._settle
        self._begun = False
        self._rows = Rows()
        self._omission = omission
        self.lines.aside = self._aside
        self._reader = library().TRCReader(cast("TextIO", self.lines))

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Take the next bytes; give records."""
        self.lines.feed(data)
        if self.lines.waiting and self._trc.decided:
            yield from self._begin()
            yield from self.drain()

    def _begin(self) -> Iterator[bytes]:
        if self._begun:
            return
        self._begun = True
        trc = self._trc
        if not trc.known:
            raise self.capture.refused(f"$FILEVERSION={trc.version}")
        self.packer.directed = bool(trc.version) and trc.version != "1.0"
        self.lines.begin(*trc.header)
        yield packed.dialect("version", trc.version or "1.0")
        if trc.date_ns is not None:
            yield packed.start(trc.date_ns)

    def end(self, *, broken: bool) -> Iterator[bytes]:
        """Take the end of the file; give the rest."""
        if not broken:
            self.lines.end()
        if self.lines.waiting:
            yield from self._begin()
        yield from super().end(broken=broken)
        self._left_out(self._rows.settle())
        yield b"".join(self.out)
        yield from _channels(self.packer)

    def _aside(self) -> bool:
        """Follow the numbers of the rows; take a line that only says that rows were left out."""
        at, line = self.lines.number, self.lines.line
        number = number_of(line)
        if number is None and (left_out := self._omission(line.encode("latin-1"))) is not None:
            self._rows.mark(left_out, at)
            return True
        if missing := self._rows.row(number, at):
            self._left_out(missing)
        return False

    def _left_out(self, missing: tuple[int | None, int, int | None] | None) -> None:
        if missing:
            self.out.append(packed.left_out(*missing))

    def reader(self) -> "Iterator[Message]":
        """Give a reader that goes on with the next line."""
        return iter(self._reader)

    def _settle(self, message: "Message") -> None:
        decimals = self._trc.decimals(self.lines.line)
        if decimals > self.packer.decimals:
            self.packer.decimals = decimals
        if message.is_fd:
            size = self._trc.size(self.lines.line)
            message.dlc = len(message.data)  # the library leaves the code there
            if size is not None and size != message.dlc:
                raise Unfit(packed.DATA)
        if self.lines.number == self.lines.endless and self._trc.may_go_on(self.lines.line):
            raise Unfit(packed.CUT_LINE)

    def nothing(self) -> bytes:
        """Give the record of a line of which nothing came."""
        line, trc = self.lines.line, self._trc
        kind = trc.kind(line)
        try:
            if kind in ("ER", "Error"):
                self.packer.decimals = max(self.packer.decimals, trc.decimals(line))
                return self.packer.error(trc.channel(line), trc.seconds(line), self.lines.number)
        except (ValueError, OverflowError, struct.error):
            kind = ""
        if kind not in PASSED_OVER or (trc.numbered and number_of(line) is None):
            return super().nothing()
        self.counts[kind] += 1
        return b""


class CsvText(Text):
    """python-can's own table."""

    def __init__(self, capture: "PythonCanCapture") -> None:
        """Read for a capture."""
        super().__init__(capture, Lines(self._change), Packer(6, directed=False, bus=only))
        self._reader = library().CSVReader(cast("TextIO", self.lines))

    @staticmethod
    def _change(line: str) -> str | None:
        if not line.isprintable() and is_damaged(line):
            return DAMAGED
        return None if line.startswith("timestamp,") and line.count(",") <= _COMMAS else line

    def reader(self) -> "Iterator[Message]":
        """Give a reader that goes on with the next line."""
        self.lines.begin("headings")
        return iter(self._reader)
