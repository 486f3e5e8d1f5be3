"""`canalyze export`: a capture as tables in files of columns. What is in them, `exporting/` says."""

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from canalyze.configuration.network import carriers
from canalyze.configuration.options import OUTPUT, PROBLEM, SELECT, configured, known_of, option, usage
from canalyze.exporting import FIRST, FOLDER, FORMS, TABLES, Target, form_of, require
from canalyze.output import Output, Progress
from canalyze.running.passes import Pass, capture_command
from canalyze.sources import STDIN
from canalyze.sources.compressed import COMPRESSIONS
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.dictionary import Dictionary

_PACKED: Final = frozenset(one.suffix for one in COMPRESSIONS.values())


def run(one: Pass) -> int:
    """Writes the tables as they come."""
    where = _target(one.output, one.tables, one.words)
    names = one.names
    require()
    from canalyze.exporting.export import SETTINGS, About, Export
    from canalyze.exporting.shaping import SIGNALS

    read: dict[str, Dictionary] = {}
    settings: dict[str, Any] = {**SETTINGS, "tables": where.core, "select": one.select}
    session = one.session(read=read, **settings)
    described = carriers(configured().known, known_of(one.given), read) if read else {}
    about = About(one.capture or name_of(names[0]), one.device, names, described)
    one.progress = Progress(one.words, Output(), one.total, until_output=True)
    with Export(where, about, force=one.force) as made:
        code = one.read(session, lambda result: made.take(session, result))
        made.take(session)
        # A stream has no other end than a signal.
        if session.frames and (code < 128 or one.total is None):
            made.complete()
            for message, count in made.left_out.items():
                one.note("export.left_out", message=message, count=count, most=SIGNALS)
    if code >= 128:
        key = "convert.cut" if session.frames and one.total is None else "output.dropped"
        one.note(key, name=one.output, frames=session.frames)
    return code


def name_of(file: str) -> str:
    """Returns the name of a capture that is read from a file: that of the file without its ends."""
    path = Path("stdin" if file == STDIN else file)
    path = path.with_suffix("") if path.suffix.lower() in _PACKED else path
    return re.sub(r"[^\w.-]+", "_", os.fsencode(path.stem).decode("utf-8", "replace")).lstrip(".") or "capture"


def _name(text: str) -> str | None:
    """Reads a name that files can have."""
    return text if text == name_of(f"{text}.log") else None


def _target(output: str | None, tables: tuple[str, ...], words: Words) -> Target:
    """Returns where it goes; a usage error where that cannot be."""
    if output is None:
        raise usage(words, "export.none")
    form = form_of(output) if output != STDIN else None
    if form is None:
        raise usage(words, "export.suffix", name=output or '""', allowed=" ".join(FORMS))
    chosen = tuple(dict.fromkeys(tables)) or (tuple(TABLES) if form == FOLDER else (FIRST,))
    if form != FOLDER and len(chosen) > 1:
        raise usage(words, "export.one", name=output)
    if form != FOLDER and "signals" in chosen:
        raise usage(words, "export.wide", name=output)
    # A link that the user names is replaced by its target.
    path = Path(output)
    return Target(Path(os.path.realpath(path)) if path.is_symlink() else path, form, chosen)


TABLE: Final = option(
    "--table tables",
    "TABLE",
    choices=tuple(TABLES),
    key=lambda words: words("export.table", tables=", ".join(TABLES)),
    multiple=True,
)
command = capture_command(
    "export",
    run,
    TABLE,
    option("--device", "NAME", default=""),
    option("--capture", "NAME", _name, "capture"),
    SELECT,
    PROBLEM,
    OUTPUT[0]._replace(metavar="DIR|FILE", key="export.output", more={}),
    without=OUTPUT[:1],
    paged=False,
)
