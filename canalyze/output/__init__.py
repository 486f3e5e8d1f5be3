"""Where results and complaints go: standard output, a file, standard error.

Results are bytes in UTF-8 and are on their way as soon as `write` returns; only a terminal of another encoding gets
them transcoded. A file is a part beside its name until it is complete (`writing`). Nothing here knows what is written.
"""

import errno
import os
import re
import stat
import sys
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, ClassVar, Final, Self

from canalyze.errors import BrokenOff, OutputError, ReaderGone
from canalyze.output.writing import AS_IT_IS, Part, write_all
from canalyze.words import Words

if TYPE_CHECKING:
    from pathlib import Path

    from canalyze.output.paging import Pager

_STDOUT: Final = 1
_MARK: Final = re.compile(rb"(##(?:vso)?)\[")
_COMMAND: Final = re.compile(
    rb"^((?:[\t\v\f\r ]|\xc2[\x85\xa0]|\xe1\x9a\x80|\xe2\x80[\x80-\xaf]|\xe2\x81\x9f|\xe3\x80\x80)*+):(?=:)", re.M
)
"""Blanks of any kind are passed over."""
_UTF8: Final = frozenset({"utf-8", "utf8", "utf_8"})


def printable(text: str) -> str:
    """Escape what could drive a terminal or break a line: control characters, undecodable bytes of file names."""
    return text if text.isprintable() else "".join(c if c.isprintable() else _escaped(c) for c in text)


def _escaped(char: str) -> str:
    code = ord(char)
    if 0xDC80 <= code <= 0xDCFF:  # a byte of a file name that is no UTF-8, as os.fsdecode keeps it
        code -= 0xDC00
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def commandless(lines: bytes) -> bytes:
    """Give lines without what a runner takes for a command: `::` first in a line, `##[` or `##vso[` anywhere."""
    from canalyze._core import may_hold_command

    if not may_hold_command(lines):
        return lines
    return _COMMAND.sub(rb"\1\\x3a", _MARK.sub(rb"\1\\x5b", lines))


def complain(line: str) -> None:
    """Write one line to standard error."""
    _put(commandless(printable(line).encode("utf-8", "backslashreplace")).decode() + "\n")


def hint(line: str) -> None:
    """Write one line to standard error for who sits there: only on a terminal."""
    if sys.stderr is not None and sys.stderr.isatty():
        complain(line)


def _put(text: str) -> None:
    """Write to standard error, in UTF-8 unless it is a terminal of another encoding; that nobody reads is no error."""
    try:
        if sys.stderr.isatty():
            sys.stderr.write(text)
        else:
            sys.stderr.buffer.write(text.encode("utf-8", "backslashreplace"))
        sys.stderr.flush()
    except (OSError, ValueError, AttributeError):
        pass


def terminal_encoding() -> str | None:
    """Give the encoding of the terminal behind standard output; None where there is no terminal."""
    try:
        if sys.stdout is None or not os.isatty(_STDOUT):
            return None
    except OSError:
        return None
    if sys.flags.utf8_mode and not os.environ.get("PYTHONUTF8"):
        import locale  # LC_ALL=C: Python says UTF-8 where the user said ASCII

        return locale.getencoding()
    return sys.stdout.encoding


def shows_chinese() -> bool:
    """Tell whether standard output can show Chinese: a pipe or a file can, a terminal if its encoding and font do."""
    encoding = terminal_encoding()
    if encoding is None:
        return True
    if os.environ.get("TERM") == "linux":  # the kernel's console has no font for it
        return False
    try:
        "中文".encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def _is_pipe() -> bool:
    try:
        mode = os.fstat(_STDOUT).st_mode
    except OSError:
        return False
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)


class Output:
    """Standard output, or the base of what is written instead; a context manager."""

    name: str | None = None
    """As the user has named the file; None for standard output."""
    is_terminal: bool
    """People read it as it comes."""
    is_quiet: bool
    """Nothing of it reaches a terminal: progress may be shown meanwhile."""
    coloured = False
    """What stands out may do so by colour (see `open_output`)."""
    columns: int | None = None
    """Lines for people that are wider than this are broken, with a hanging indent (see `open_output`)."""
    pager: "ClassVar[Pager | None]" = None
    """What has to be begun before something is written to a terminal."""

    def __init__(self) -> None:
        """Look at what standard output is."""
        encoding = terminal_encoding()
        self.is_terminal = encoding is not None
        self.is_quiet = not self.is_terminal and not _is_pipe()
        self._encoding = None if encoding is None or encoding.lower() in _UTF8 else encoding

    def __enter__(self) -> Self:
        """Nothing to open."""
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Nothing to close."""

    def write(self, data: bytes) -> None:
        """Write complete lines and let them go at once."""
        if data and self.is_terminal and Output.pager is not None:
            Output.pager.begin()
        if self._encoding is not None:
            data = data.decode("utf-8", "replace").encode(self._encoding, "replace")
        try:
            write_all(_STDOUT, data)
        except BrokenPipeError as error:
            raise ReaderGone("output.gone") from error
        except OSError as error:
            raise OutputError("output.stdout", error=error) from error

    def shown(self, lines: bytes) -> None:
        """Write complete lines for people."""
        if self.columns is not None:
            from canalyze.output.hanging import hanging

            lines = hanging(lines, self.columns)
        self.write(commandless(lines))

    def text(self, text: str) -> None:
        """Write text for people."""
        self.shown(text.encode("utf-8", "backslashreplace"))

    def drop(self) -> None:
        """There was nothing to write: leave no file."""

    def leave(self) -> str | None:
        """Take what was written for a part only, which keeps the name of one; give that name, None if there is none."""
        return None


class FileOutput(Output):
    """A file, complete when its block ends without an error; one that exists is kept, unless forced."""

    def __init__(self, name: str, *, force: bool) -> None:
        """Make the part of the file; OutputError if `name` exists or cannot be written."""
        from pathlib import Path

        self.name: str = name
        self.is_terminal = False
        self.is_quiet = True
        self._encoding = None
        self._wanted = self._complete = True
        self._part: Part | None = None
        # A link that the user names stands for what it points to; one that points to nothing is somebody's, too.
        path = Path(os.path.realpath(name))
        try:
            if _is_device(path):
                self._path, self._fd = path, os.open(path, os.O_WRONLY | AS_IT_IS)
                return
            if not force and os.path.lexists(name):
                raise OutputError("output.exists", name=name)
            self._part = Part(path, replace=force)
            self._path, self._fd = self._part.path, self._part.fd
        except OSError as error:
            raise OutputError("output.write", name=name, error=error) from error

    @property
    def path(self) -> str:
        """Where it is being written, for another program's writer that opens by name."""
        return str(self._path)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Give the file its name when the work came to its end; what a signal has ended keeps the name of a part."""
        try:
            os.close(self._fd)
            if self._part is not None:
                self._settle(self._part, error)
        except FileExistsError as taken:
            raise OutputError("output.exists", name=self.name) from taken
        except OSError as failure:
            raise OutputError("output.write", name=self.name, error=failure) from failure

    def _settle(self, part: Part, error: BaseException | None) -> None:
        if isinstance(error, SystemExit | KeyboardInterrupt) and self._wanted and not part.empty:
            raise BrokenOff(self.name, self._shown(part), error) from error
        if error is not None or not self._wanted:
            part.discard()
        elif self._complete:
            try:
                part.complete()
            except OSError:
                part.discard()
                raise

    def _shown(self, part: Part) -> str:
        """Give the name of the part as the user would write it."""
        from pathlib import Path

        beside = Path(self.name).with_name(part.path.name)
        return str(beside if beside.exists() else part.path)

    def write(self, data: bytes) -> None:
        """Write to the part."""
        try:
            write_all(self._fd, data)
        except BrokenPipeError as error:
            raise ReaderGone("output.gone") from error
        except OSError as error:
            raise OutputError("output.write", name=self.name, error=error) from error

    def drop(self) -> None:
        """There was nothing to write: leave no file."""
        self._wanted = False

    def leave(self) -> str | None:
        """Take what was written for a part only."""
        if self._part is None:
            return None
        self._complete = False
        return self._shown(self._part)


def dyed(text: str, colour: str, *, out: Output) -> str:
    """Give a text in a colour of the core's table, where the output has colours."""
    if not out.coloured:
        return text
    from canalyze._core import COLOURS, PLAIN

    return f"{COLOURS[colour]}{text}{PLAIN}"


def _is_device(path: "Path") -> bool:
    """Tell whether a file is something that renaming would replace, such as /dev/null or a FIFO."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    return not stat.S_ISREG(mode)


def open_output(name: str | None, *, force: bool = False, color: str = "auto", hangs: bool = False) -> Output:
    """Return standard output, or the file of that name ('-' is standard output).

    color: what --color says. hangs: on a terminal, lines for people have a hanging indent.
    """
    out = Output() if name is None or name == "-" else FileOutput(name, force=force)
    out.coloured = color == "always" or (color == "auto" and _coloured(out))
    if hangs and out.is_terminal:
        import shutil

        out.columns = shutil.get_terminal_size().columns
    return out


def _coloured(out: Output) -> bool:
    """Tell by the environment whether colours are wanted: NO_COLOR goes first, then FORCE_COLOR, then the terminal."""
    found = os.environ.get
    if found("NO_COLOR"):
        return False
    if any(found(name, "0") not in ("", "0") for name in ("FORCE_COLOR", "CLICOLOR_FORCE")):
        return out.name is None
    return out.is_terminal and found("TERM") != "dumb" and found("CLICOLOR") != "0"


def told(code: int, out: Output, words: Words, *, stream: bool, some: bool = True) -> int:
    """Say what is in an output where a signal has ended the reading; give the exit code as it is.

    A file of which the input was not read to its end stays a part. stream: the input has no other end than a signal:
    what was read is all of it. some: anything was read.
    """
    if code < 128 or (stream and out.name is None):
        return code
    name = words("convert.stdout") if out.name is None else out.name
    if not some:
        out.drop()
        complain(f"canalyze: {words('output.dropped', name=name)}")
        return code
    part = None if stream else out.leave()
    complain(f"canalyze: {words('output.part' if part else 'output.cut', name=name, part=part)}")
    return code


def _in_columns(text: str, columns: int) -> str:
    """Cut a text that a terminal would break: the rest of a broken line could not be taken away again."""
    from canalyze.output.layout import width

    while text and width(text) > columns:
        text = text[:-1]
    return text


class Progress:
    """A line on standard error that says how far the work is: only on a terminal, and only after a second."""

    def __init__(self, words: Words, output: Output, total: int | None, *, until_output: bool = False) -> None:
        """`total` is the size of all inputs in bytes, None if unknown.

        until_output: nothing is written to `output` before the work is done, so the line may stand on its terminal.
        """
        self._words = words
        self._total = total
        self._done = 0
        self._shown = False
        # Behind a pipe may be a pager or a filter on the same terminal: the line would stand in their way.
        room = output.is_quiet or (until_output and output.is_terminal)
        self._wanted = room and sys.stderr is not None and sys.stderr.isatty()
        if self._wanted:
            import time

            self._clock = time.monotonic
            self._next = self._clock() + 1.0

    def step(self, size: int, frames: int) -> None:
        """Count `size` bytes more; show it ten times a second at most."""
        self._done += size
        key = "progress.some" if self._total is None else "progress.of"
        total = (self._total or 0) / 1e6
        self.show(lambda: self._words(key, done=f"{self._done / 1e6:.1f}", total=f"{total:.1f}", frames=frames))

    def show(self, line: Callable[[], str]) -> None:
        """Show another line; it is asked for ten times a second at most."""
        if not self._wanted:
            return
        now = self._clock()
        if now < self._next:
            return
        self._next = now + 0.1
        _put(f"\r{_in_columns(line(), self._columns() - 1)}\x1b[K")
        self._shown = True

    @staticmethod
    def _columns() -> int:
        try:
            return os.get_terminal_size(sys.stderr.fileno()).columns or 80
        except (OSError, ValueError):
            return 80

    def clear(self) -> None:
        """Take the line away, before another is written."""
        if self._shown:
            _put("\r\x1b[K")
            self._shown = False


def hexadecimal(value: object, text: str | None) -> str | None:
    """Give a number as 0x..., with the digits of its type, where its text begins so in every language; else None."""
    found = re.match("([0-9A-F]{2,16})h", text or "")
    return f"0x{found[1]}" if found and isinstance(value, int) and int(found[1], 16) == value else None
