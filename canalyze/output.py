"""Where results and complaints go: standard output, a file, standard error.

Results are bytes in UTF-8 and are on their way as soon as `write` returns; only a terminal of another encoding gets
them transcoded. A file is written beside its name and renamed when complete. Nothing here knows what is written.
"""

import errno
import os
import re
import stat
import sys
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from canalyze.errors import OutputError, ReaderGone
from canalyze.layout import width
from canalyze.words import Words

_STDOUT: Final = 1
_AS_IT_IS: Final = getattr(os, "O_BINARY", 0)
"""Where the system would else translate line ends."""
_UTF8: Final = frozenset({"utf-8", "utf8", "utf_8"})


def printable(text: str) -> str:
    """Escape what could drive a terminal or break a line: control characters, undecodable bytes of file names."""
    return text if text.isprintable() else "".join(c if c.isprintable() else _escaped(c) for c in text)


def _escaped(char: str) -> str:
    code = ord(char)
    if 0xDC80 <= code <= 0xDCFF:  # a byte of a file name that is no UTF-8, as os.fsdecode keeps it
        code -= 0xDC00
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def complain(line: str) -> None:
    """Write one line to standard error."""
    _put(printable(line) + "\n")


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

    is_terminal: bool
    """People read it as it comes."""
    is_quiet: bool
    """Nothing of it reaches a terminal: progress may be shown meanwhile."""

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
        if self._encoding is not None:
            data = data.decode("utf-8", "replace").encode(self._encoding, "replace")
        try:
            write_all(_STDOUT, data)
        except BrokenPipeError as error:
            raise ReaderGone("output.gone") from error
        except OSError as error:
            raise OutputError("output.stdout", error=error) from error

    def text(self, text: str) -> None:
        """Write text."""
        self.write(text.encode("utf-8", "backslashreplace"))

    def drop(self) -> None:
        """There was nothing to write: leave no file."""


class FileOutput(Output):
    """A file, written beside its name and renamed at the end; kept if it exists, unless forced."""

    def __init__(self, name: str, *, force: bool) -> None:
        """Open the file beside `name`; OutputError if `name` exists or cannot be written."""
        self.is_terminal = False
        self.is_quiet = True
        self._encoding = None
        self._name = name
        self._force = force
        self._wanted = True
        self._path = Path(os.path.realpath(name))
        self._beside: Path | None = self._path.with_name(f"{self._path.name}.{os.getpid()}.part")
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        try:
            if self._is_device():
                self._beside = None
                flags = os.O_WRONLY
            elif self._path.exists() and not force:
                raise OutputError("output.exists", name=name)
            self._fd = os.open(self._beside or self._path, flags | _AS_IT_IS, 0o666)
        except OSError as error:
            raise OutputError("output.write", name=name, error=error) from error

    @property
    def path(self) -> str:
        """Where it is being written, for another program's writer that opens by name."""
        return str(self._beside or self._path)

    def _is_device(self) -> bool:
        """Tell whether the name stands for something that renaming would replace, such as /dev/null or a FIFO."""
        try:
            mode = self._path.stat().st_mode
        except FileNotFoundError:
            return False
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        return not stat.S_ISREG(mode)

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        """Rename the file when the work came to its end, else leave nothing behind."""
        try:
            os.close(self._fd)
            if self._beside is None:
                return
            if kind is not None or not self._wanted:
                self._beside.unlink()
            elif self._path.exists() and not self._force:
                self._beside.unlink()
                raise OutputError("output.exists", name=self._name)
            else:
                self._beside.replace(self._path)
        except OSError as error:
            raise OutputError("output.write", name=self._name, error=error) from error

    def write(self, data: bytes) -> None:
        """Write to the file beside."""
        try:
            write_all(self._fd, data)
        except BrokenPipeError as error:
            raise ReaderGone("output.gone") from error
        except OSError as error:
            raise OutputError("output.write", name=self._name, error=error) from error

    def drop(self) -> None:
        """There was nothing to write: leave no file."""
        self._wanted = False


def open_output(name: str | None, *, force: bool) -> Output:
    """Give standard output, or the file of that name ('-' is standard output)."""
    return Output() if name is None or name == "-" else FileOutput(name, force=force)


def write_all(fd: int, data: bytes) -> None:
    """Write everything, also to a pipe that another program made non-blocking."""
    view = memoryview(data)
    while view:
        try:
            view = view[os.write(fd, view) :]
        except BlockingIOError:
            import select

            select.select([], [fd], [])


def _in_columns(text: str, columns: int) -> str:
    """Cut a text that a terminal would break: the rest of a broken line could not be taken away again."""
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
        if not self._wanted:
            return
        self._done += size
        now = self._clock()
        if now < self._next:
            return
        self._next = now + 0.1
        key = "progress.some" if self._total is None else "progress.of"
        total = (self._total or 0) / 1e6
        line = self._words(key, done=f"{self._done / 1e6:.1f}", total=f"{total:.1f}", frames=frames)
        _put(f"\r{_in_columns(line, self._columns() - 1)}\x1b[K")
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
