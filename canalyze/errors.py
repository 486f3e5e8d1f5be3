"""Everything that can go wrong for a reason outside the program, as one tree.

    CanalyzeError
    ├── ConfigError     canalyze.toml, CANALYZE_LANG or a global option says something that cannot be
    ├── SourceError     an input cannot be opened or read, or nothing in it can be understood
    ├── OutputError     a result cannot be written
    │   ├── ReaderGone  whoever read the pipe has seen enough: the end, but no failure
    │   └── BrokenOff   a signal has ended the writing of a file, which stays a part
    └── CoreError       the compiled core is not there

An error carries a key of `words` and its facts, not a sentence: it is put into words where it is shown. What a
capture contains is never an error here; the core answers that with findings and complaints.
"""

import errno

from canalyze.words import Words


class CanalyzeError(Exception):
    """Root of the tree; `str()` gives the English sentence."""

    exit_code: int = 2

    def __init__(self, key: str, /, **facts: object) -> None:
        """Keep the key of the sentence and what fills it."""
        super().__init__(key)
        self.key = key
        self.facts = facts

    def __str__(self) -> str:
        return self.in_words(Words("en"))

    def in_words(self, words: Words) -> str:
        """Give the sentence in the language of `words`; an error among the facts becomes its reason."""
        return words(self.key, **{name: _said(fact, words) for name, fact in self.facts.items()})


class ConfigError(CanalyzeError):
    """canalyze.toml, CANALYZE_LANG or a global option says something that cannot be."""


class SourceError(CanalyzeError):
    """An input cannot be opened or read, or nothing in it can be understood."""


class OutputError(CanalyzeError):
    """A result cannot be written."""


class ReaderGone(OutputError):
    """Whoever read the pipe has seen enough: the end, but no failure."""

    exit_code = 0


class BrokenOff(OutputError):
    """A signal has ended the writing of a file; what was written stays beside its name."""

    def __init__(self, name: str, part: str, by: SystemExit | KeyboardInterrupt) -> None:
        """Keep what has ended it: the exit code is that of the signal."""
        super().__init__("output.part", name=name, part=part)
        code = getattr(by, "code", None)
        self.exit_code = code if isinstance(code, int) else 130


class CoreError(CanalyzeError):
    """The compiled core is not there."""


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
    """Say in words why the operating system refused; its own words where we have none."""
    key = _REASONS.get(error.errno or 0)
    return words(key) if key else error.strerror or type(error).__name__
