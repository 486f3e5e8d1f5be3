"""The expectations of a capture: a TOML file beside it.

Every mistake is a ConfigError with the file, the line and what is allowed. Must not: judge a capture, or know what is
in the file; that is the core's (`settings/`, `expectation/`).
"""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from canalyze.output import files
from canalyze.sources.names import CAPTURES, unpacked

if TYPE_CHECKING:
    from canalyze._core import Expectations

SUFFIX: Final = ".expect.toml"


def beside(name: str) -> Path | None:
    """Returns the file beside a capture, boot.expect.toml of boot.log.gz; None if there is none."""
    path = unpacked(name)
    if path.suffix.lower() in CAPTURES:
        path = path.with_suffix("")
    if name == "-" or not path.name:
        return None
    file = path.with_name(path.name + SUFFIX)
    return file if file.is_file() else None


def read(path: Path) -> "Expectations":
    """Reads a file for the core; ConfigError for content that is not valid."""
    from canalyze._core import Expectations

    return files.checked(path, Expectations, "expect.unreadable")
