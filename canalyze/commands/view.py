"""`canalyze view`: a capture as a timeline, in Rerun's viewer or in a file for it.

The content of the timeline is in `timeline/`, which alone needs Rerun. The capture is read to its end first and written
to a file beside; the viewer shows that file, which goes when the viewer is closed.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from canalyze.configuration.options import BITRATE, FILES, FORCE, PROBLEM, READING, typed, usage
from canalyze.errors import SourceError
from canalyze.output import Output
from canalyze.running.passes import Pass, pass_command
from canalyze.running.run import Interrupt
from canalyze.running.viewing import SUFFIX, VIEWING, ViewingOptions, check, drawn_in, readable, save, show, write
from canalyze.timeline import TABLES
from canalyze.words import Words

_OF_VIEWER: Final = frozenset({"files", *ViewingOptions.__annotations__})
"""Parameters that say how a timeline is shown, not what is on it."""
_MAGIC: Final = b"RRF"
"""First bytes of a file of Rerun."""


def run(one: Pass) -> int:
    """Draws a capture, or shows a timeline that is there."""
    name, given, words = one.given["save"], one.given, one.words
    check(given, words, shown=name is None, why_not=("usage.exclusive", "--save"))
    _check_names(one.names, name)
    if _suffix(one.names[0]) == SUFFIX:
        _check_options(words)
        return show(_timeline(one.names[0]), given, words)
    drawn = words if name is not None else drawn_in(words, one.complain, web=one.web)
    session = one.session(drawn, format="summary", tables=TABLES)
    if name is not None:
        return save(one, session, name)
    # Whatever ends it, and when: the folder goes, and the viewer with it.
    with Interrupt() as ended, TemporaryDirectory(prefix="canalyze-", ignore_cleanup_errors=True) as folder:
        path = str(Path(folder) / f"{readable(one.names)}{SUFFIX}")
        code = write(one, session, path, Output(), drawn, ended)
        if ended.signal or session.frames == 0 or code >= 128:
            return 128 + ended.signal if ended.signal else code
        return show(path, given, words) or code


def _suffix(name: str) -> str:
    return Path(name).suffix.lower()


def _check_names(names: tuple[str, ...], save: str | None) -> None:
    """Raises SourceError for what this command has written, which is no capture."""
    for name in names:
        if _suffix(name) == SUFFIX and (len(names) > 1 or save is not None):
            raise SourceError("view.ready", name=name)


def _check_options(words: Words) -> None:
    """Raises a usage error for what is asked of a timeline that is ready: what is on it is there already."""
    for param in typed():
        if param.name not in _OF_VIEWER:
            raise usage(words, "view.too_late", option=param.opts[0])


def _timeline(name: str) -> str:
    """Returns the name of a file that is a timeline already; SourceError where it is not."""
    try:
        with Path(name).open("rb") as file:
            head = file.read(len(_MAGIC))
    except (OSError, ValueError) as error:
        raise SourceError("source.open", name=name, error=error) from error
    if head != _MAGIC:
        raise SourceError("view.no_timeline", name=name)
    return name


command = pass_command("view", run, FILES, *VIEWING, BITRATE, PROBLEM, *READING, FORCE)
