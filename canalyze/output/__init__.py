"""Outputs of results and messages: standard output, a file, standard error; text and JSON that cannot mislead a person.

Results are bytes in UTF-8 and are written before `write` returns; only a terminal of another encoding gets them
transcoded. A file is a part with a temporary name until it is complete (`files`). The first output to a terminal starts
the pager (`help`), if there is one. Nothing here knows the content.
"""

import errno
import os
import re
import stat
import sys
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

from canalyze.errors import BrokenOff, OutputError, ReaderGone, as_error
from canalyze.output.files import AS_IT_IS, Part, write_all
from canalyze.words import Words

if TYPE_CHECKING:
    from pathlib import Path

    from canalyze.output.help import Pager

_STDOUT: Final = 1
_MARK: Final = re.compile(rb"(##(?:vso)?)\[")
_MARK_IN_JSON: Final = re.compile(r"(##(?:vso)?)\[")
"""Commands of the runners of GitHub and Azure."""
_COMMAND: Final = re.compile(
    rb"^((?:[\t\v\f\r ]|\xc2[\x85\xa0]|\xe1\x9a\x80|\xe2\x80[\x80-\xaf]|\xe2\x81\x9f|\xe3\x80\x80)*+):(?=:)", re.M
)
"""Skips blanks of any kind."""
_UTF8: Final = frozenset({"utf-8", "utf8", "utf_8"})


def printable(text: str) -> str:
    """Escapes characters that could control a terminal or break a line, and undecodable bytes of file names."""
    return text if text.isprintable() else "".join(c if c.isprintable() else _escaped(c) for c in text)


def _escaped(char: str) -> str:
    code = ord(char)
    if 0xDC80 <= code <= 0xDCFF:  # a byte of a file name that is no UTF-8, as os.fsdecode keeps it
        code -= 0xDC00
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def commandless(lines: bytes) -> bytes:
    """Escapes commands of CI runners in lines: `::` at the beginning of a line, `##[` or `##vso[` anywhere."""
    try:
        from canalyze._core import may_hold_command
    except ImportError:  # the line about a missing core is written, too
        pass
    else:
        if not may_hold_command(lines):
            return lines
    return _COMMAND.sub(rb"\1\\x3a", _MARK.sub(rb"\1\\x5b", lines))


def json_text(value: Any, *, compact: bool = False, indent: int | None = None) -> str:
    """Returns the JSON of a value, escaped as the core escapes it, so that it cannot mislead a person.

    Characters that could control a terminal, reorder or hide text, or break a line, and commands of CI runners are
    hexadecimal escapes.
    """
    import json

    separators = (",", ":") if compact else None
    written = json.dumps(value, ensure_ascii=False, separators=separators, indent=indent)
    written = _MARK_IN_JSON.sub(r"\1\\u005b", written)
    if written.isprintable():
        return written
    return "".join(char if char.isprintable() or char == "\n" else json.dumps(char)[1:-1] for char in written)


def json_line(value: Any, *, compact: bool = False) -> bytes:
    """Returns one line of JSON, with its line end."""
    return json_text(value, compact=compact).encode() + b"\n"


def fields(record: object, names: str) -> dict[str, Any]:
    """Returns attributes of a record; names: with blanks between."""
    return {name: getattr(record, name) for name in names.split()}


def complain(*lines: str) -> None:
    """Writes lines to standard error."""
    for line in lines:
        _put(commandless(printable(line).encode("utf-8", "backslashreplace")).decode() + "\n")


def hint(line: str) -> None:
    """Writes one line to standard error if it is a terminal."""
    if sys.stderr is not None and sys.stderr.isatty():
        complain(line)


def _put(text: str) -> None:
    """Writes to standard error, in UTF-8 unless it is a terminal of another encoding; errors are ignored."""
    try:
        if sys.stderr.isatty():
            sys.stderr.write(text)
        else:
            sys.stderr.buffer.write(text.encode("utf-8", "backslashreplace"))
        sys.stderr.flush()
    except (OSError, ValueError, AttributeError):
        pass


def terminal_encoding() -> str | None:
    """Returns the encoding of the terminal at standard output; None if it is no terminal."""
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
    """Returns true if standard output can show Chinese, as pipes, files, and suitable terminals can."""
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
    """Standard output, or the base of other outputs; a context manager."""

    name: str | None = None
    """The name of the file as given by the user; None for standard output."""
    is_terminal: bool
    """True if a person reads it as it comes."""
    is_quiet: bool
    """True if nothing of it reaches a terminal, so that progress may be shown."""
    coloured = False
    """True if colours may be used (see `open_output`)."""
    columns: int | None = None
    """Maximum width of lines for people; longer ones are broken with a hanging indent (see `open_output`)."""
    pager: "ClassVar[Pager | None]" = None
    """The pager to start before something is written to a terminal."""

    def __init__(self) -> None:
        """Inspects standard output."""
        encoding = terminal_encoding()
        self.is_terminal = encoding is not None
        self.is_quiet = not self.is_terminal and not _is_pipe()
        self._encoding = None if encoding is None or encoding.lower() in _UTF8 else encoding

    def __enter__(self) -> Self:
        """Returns the output."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Does nothing."""

    def write(self, data: bytes) -> None:
        """Writes complete lines without buffering."""
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
        """Writes complete lines for people."""
        if self.columns is not None:
            from canalyze.output.layout import hanging

            lines = hanging(lines, self.columns)
        self.write(commandless(lines))

    def text(self, text: str) -> None:
        """Writes text for people."""
        self.shown(text.encode("utf-8", "backslashreplace"))

    def drop(self) -> None:
        """Discards the file, because there is nothing to write."""

    def leave(self) -> str | None:
        """Keeps the written data as a part of a file; returns the part's name, or None if there is none."""
        return None


class Kept(Output):
    """An output that keeps its data in memory."""

    is_terminal = False
    is_quiet = True

    def __init__(self) -> None:
        """Creates an output without data."""
        self.data = bytearray()

    def __str__(self) -> str:
        return self.data.decode("utf-8", "replace")

    def write(self, data: bytes) -> None:
        """Keeps lines."""
        self.data += data


class FileOutput(Output):
    """A file, complete when its block ends without an error; an existing one is replaced only with `force`."""

    def __init__(self, name: str, *, force: bool) -> None:
        """Creates the part of the file. Raises OutputError if `name` exists or cannot be written."""
        from pathlib import Path

        self.name: str = name
        self.is_terminal = False
        self.is_quiet = True
        self._encoding = None
        self._wanted = self._complete = True
        self._part: Part | None = None
        # A link given by the user is followed; a dangling one exists, too.
        path = Path(os.path.realpath(name))
        with as_error(OutputError, "output.write", name=name):
            if _is_device(path):
                self._path, self._fd = path, os.open(path, os.O_WRONLY | AS_IT_IS)
                return
            if not force and os.path.lexists(name):
                raise OutputError("output.exists", name=name)
            self._part = Part(path, replace=force)
            self._path, self._fd = self._part.path, self._part.fd

    @property
    def path(self) -> str:
        """The path of the part, for a writer that opens by name."""
        return str(self._path)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Renames the part to the file, or removes it after an error; after a signal it is kept as a part."""
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
        """Returns the name of the part, relative like that of the user."""
        from pathlib import Path

        beside = Path(self.name).with_name(part.path.name)
        return str(beside if beside.exists() else part.path)

    def write(self, data: bytes) -> None:
        """Writes to the part."""
        try:
            write_all(self._fd, data)
        except BrokenPipeError as error:
            raise ReaderGone("output.gone") from error
        except OSError as error:
            raise OutputError("output.write", name=self.name, error=error) from error

    def drop(self) -> None:
        """Discards the file, because there is nothing to write."""
        self._wanted = False

    def leave(self) -> str | None:
        """Keeps the written data as a part."""
        if self._part is None:
            return None
        self._complete = False
        return self._shown(self._part)


def dyed(text: str, colour: str, *, out: Output) -> str:
    """Returns a text in a colour of the core's table, if the output has colours."""
    if not out.coloured:
        return text
    from canalyze._core import COLOURS, PLAIN

    return f"{COLOURS[colour]}{text}{PLAIN}"


def _is_device(path: "Path") -> bool:
    """Returns true for a file that renaming would replace, such as /dev/null or a FIFO."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    return not stat.S_ISREG(mode)


def open_output(name: str | None, *, force: bool = False, color: str = "auto", hangs: bool = False) -> Output:
    """Returns standard output, or the file of that name ('-' is standard output).

    color: the value of --color. hangs: on a terminal, lines for people get a hanging indent.
    """
    out = Output() if name is None or name == "-" else FileOutput(name, force=force)
    out.coloured = color == "always" or (color == "auto" and _coloured(out))
    if hangs and out.is_terminal:
        import shutil

        out.columns = shutil.get_terminal_size().columns
    return out


def _coloured(out: Output) -> bool:
    """Returns true if colours are wanted, by NO_COLOR, then FORCE_COLOR, then the terminal."""
    found = os.environ.get
    if found("NO_COLOR"):
        return False
    if any(found(name, "0") not in ("", "0") for name in ("FORCE_COLOR", "CLICOLOR_FORCE")):
        return out.name is None
    return out.is_terminal and found("TERM") != "dumb" and found("CLICOLOR") != "0"


def told(code: int, out: Output, words: Words, *, stream: bool, some: bool = True) -> int:
    """Reports an output whose input was ended by a signal; returns the exit code unchanged.

    A file whose input was not read to its end stays a part. stream: only a signal ends the input, so the output is
    complete. some: anything was read.
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
    """Cuts a text to the width of a terminal, because the rest of a broken line could not be erased."""
    from canalyze.output.layout import width

    while text and width(text) > columns:
        text = text[:-1]
    return text


class Progress:
    """A progress line on standard error: only on a terminal, and only after a second."""

    def __init__(self, words: Words, output: Output, total: int | None, *, until_output: bool = False) -> None:
        """Prepares the line; `total` is the size of all inputs in bytes, None if unknown.

        until_output: nothing is written to `output` before the work is done, so the line may use its terminal.
        """
        self._words = words
        self._total = total
        self._done = 0
        self._shown = False
        # A pager or a filter behind a pipe may use the same terminal, and the line would disturb it.
        room = output.is_quiet or (until_output and output.is_terminal)
        self._wanted = room and sys.stderr is not None and sys.stderr.isatty()
        if self._wanted:
            import time

            self._clock = time.monotonic
            self._next = self._clock() + 1.0

    def step(self, size: int, frames: int) -> None:
        """Adds `size` bytes; updates the line at most ten times per second."""
        self._done += size
        key = "progress.some" if self._total is None else "progress.of"
        total = (self._total or 0) / 1e6
        self.show(lambda: self._words(key, done=f"{self._done / 1e6:.1f}", total=f"{total:.1f}", frames=frames))

    def show(self, line: Callable[[], str]) -> None:
        """Shows another line; it is called at most ten times per second."""
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
        """Erases the line, before another is written."""
        if self._shown:
            _put("\r\x1b[K")
            self._shown = False


def hexadecimal(value: object, text: str | None) -> str | None:
    """Returns a number as 0x... with the digits of its type, if its text is hexadecimal in all languages; else None."""
    found = re.match("([0-9A-F]{2,16})h", text or "")
    return f"0x{found[1]}" if found and isinstance(value, int) and int(found[1], 16) == value else None
