"""All errors with a cause outside the program, as one tree.

    CanalyzeError
    ├── ConfigError     canalyze.toml, CANALYZE_LANG or a global option is invalid
    ├── SourceError     an input cannot be opened or read, or contains nothing valid
    ├── OutputError     a result cannot be written
    │   ├── ReaderGone  the reader of the pipe went away: the end, but no failure
    │   └── BrokenOff   a signal has ended the writing of a file, which stays a part
    └── CoreError       the compiled core is missing

An error contains a key of `words` and its facts; the sentence is made where it is shown. The content of a capture is
never an error here; the core reports it in findings and complaints.
"""

import errno
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager

from canalyze.words import Words


class CanalyzeError(Exception):
    """Root of the tree; `str()` returns the English sentence."""

    exit_code: int = 2

    def __init__(self, key: str, /, **facts: object) -> None:
        """Keeps the key of the sentence and its facts."""
        super().__init__(key)
        self.key = key
        self.facts = facts

    def __str__(self) -> str:
        return self.in_words(Words("en"))

    def in_words(self, words: Words) -> str:
        """Returns the sentence in the language of `words`; an error among the facts becomes its reason."""
        return words(self.key, **{name: _said(fact, words) for name, fact in self.facts.items()})


class ConfigError(CanalyzeError):
    """canalyze.toml, CANALYZE_LANG or a global option is invalid."""


class SourceError(CanalyzeError):
    """An input cannot be opened or read, or contains nothing valid."""


class OutputError(CanalyzeError):
    """A result cannot be written."""


class ReaderGone(OutputError):
    """The reader of the pipe went away: the end, but no failure."""

    exit_code = 0


class BrokenOff(OutputError):
    """A signal has ended the writing of a file; the data so far stays as a part beside it."""

    def __init__(self, name: str, part: str, by: SystemExit | KeyboardInterrupt) -> None:
        """Keeps the cause; the exit code is that of the signal."""
        super().__init__("output.part", name=name, part=part)
        code = getattr(by, "code", None)
        self.exit_code = code if isinstance(code, int) else 130


class CoreError(CanalyzeError):
    """The compiled core is missing."""


@contextmanager
def as_error(
    kind: type[CanalyzeError], key: str, caught: type[Exception] = OSError, /, **facts: object
) -> Iterator[None]:
    """Raises an exception of the block as an error of this kind, with itself as the reason among the facts."""
    try:
        yield
    except caught as error:
        raise kind(key, **facts, error=error) from error


def needed(kind: type[CanalyzeError], name: str, extra: str) -> AbstractContextManager[None]:
    """Raises an ImportError of the block as an error of this kind, which names the extra that has the library."""
    return as_error(kind, "library.extra", ImportError, name=name, line=f"pip install 'canalyze[{extra}]'")


def one_line(error: BaseException) -> str:
    """Returns an exception of a library in one line, with its type."""
    text = " ".join(str(error).split())[:200]
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def _said(fact: object, words: Words) -> object:
    if isinstance(fact, CanalyzeError):
        return fact.in_words(words)
    return reason(fact, words) if isinstance(fact, OSError) else fact


_REASONS = {
    errno.ENOENT: "os.missing",
    errno.EACCES: "os.forbidden",
    errno.EPERM: "os.forbidden",
    errno.EISDIR: "os.directory",
    errno.ENOTDIR: "os.not_directory",
    errno.ENOSPC: "os.full",
    errno.EROFS: "os.read_only",
    errno.EEXIST: "os.exists",
    errno.EBADF: "os.closed",
    errno.EIO: "os.io",
    errno.ENAMETOOLONG: "os.long_name",
    errno.EFBIG: "os.large",
    errno.EDQUOT: "os.quota",
}


def reason(error: OSError, words: Words) -> str:
    """Returns the reason of a system error in words, or the system's own message."""
    key = _REASONS.get(error.errno or 0)
    return words(key) if key else error.strerror or type(error).__name__
