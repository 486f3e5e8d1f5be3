"""`canalyze export`: a capture as tables in files of columns. What is in them, `exporting/` says."""

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final, Unpack

import click

from canalyze.configuration.config import Config
from canalyze.configuration.descriptions import carriers
from canalyze.configuration.options import (
    CaptureOptions,
    OneOf,
    capture_options,
    inputs,
    known_of,
    open_session,
    problem_option,
    spelled,
)
from canalyze.exporting import FIRST, FOLDER, FORMS, TABLES, Target, form_of, require
from canalyze.output import Output, Progress, complain
from canalyze.output.help import Command
from canalyze.running.run import Run
from canalyze.sources.compressed import COMPRESSIONS
from canalyze.sources.file import STDIN, total_size
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.dictionary.model import Dictionary

_PACKED: Final = frozenset(one.suffix for one in COMPRESSIONS.values())


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        tables: tuple[str, ...],
        device: str,
        capture: str | None,
        select: str | None,
        output: str | None,
        force: bool,
        expression: str | None,
        stamps: str,
        **given: Unpack[CaptureOptions],
    ) -> int:
        where = _target(output, tables, words)
        names = inputs(files, words)
        require()
        from canalyze.exporting.export import SETTINGS, About, Export

        read: dict[str, Dictionary] = {}
        settings = {**SETTINGS, "tables": where.core, "select": select, "filter": expression, "stamps": stamps}
        session = open_session(words, given, read=read, **settings)
        filed = (click.get_current_context().find_object(Config) or Config()).known
        described = carriers(filed, known_of(given), read) if read else {}
        about = About(capture or name_of(names[0]), device, names, described)
        total = total_size(names)
        with Export(where, about, force=force) as made:

            def take(result: bytes) -> None:
                made.take(session, result)

            progress = Progress(words, Output(), total, until_output=True)
            code = Run(session, words, progress, take, given).over(names)
            made.take(session)
            # A stream has no other end than a signal.
            if session.frames and (code < 128 or total is None):
                made.complete()
        if code >= 128:
            key = "convert.cut" if session.frames and total is None else "output.dropped"
            complain(f"canalyze: {words(key, name=output, frames=session.frames)}")
        return code

    return Command(
        "export",
        words,
        run,
        [
            table_option(words),
            click.Option(["--device"], metavar="NAME", default="", help=words("export.device")),
            spelled(words, "--capture", _name, "capture", "NAME", "export.capture"),
            click.Option(["--select"], metavar="GLOBS", help=words("signals.select")),
            problem_option(words),
            *(option for option in capture_options(words) if option.name != "output"),
            click.Option(["-o", "--output"], metavar="DIR|FILE", help=words("export.output")),
        ],
    )


def table_option(words: Words) -> click.Option:
    """Give --table."""
    names = tuple(TABLES)
    said = words("export.table", tables=", ".join(names))
    return click.Option(["--table", "tables"], type=OneOf(names, words), metavar="TABLE", multiple=True, help=said)


def name_of(file: str) -> str:
    """Give what a capture is called that is read from a file: the file's name without its ends."""
    path = Path("stdin" if file == STDIN else file)
    path = path.with_suffix("") if path.suffix.lower() in _PACKED else path
    return re.sub(r"[^\w.-]+", "_", os.fsencode(path.stem).decode("utf-8", "replace")).lstrip(".") or "capture"


def _name(text: str) -> str | None:
    """Read a name that files can have."""
    return text if text == name_of(f"{text}.log") else None


def _target(output: str | None, tables: tuple[str, ...], words: Words) -> Target:
    """Give where it goes; a usage error where that cannot be."""
    context = click.get_current_context()
    if output is None:
        raise click.UsageError(words("export.none"), context)
    form = form_of(output) if output != STDIN else None
    if form is None:
        raise click.UsageError(words("export.suffix", name=output or '""', allowed=" ".join(FORMS)), context)
    chosen = tuple(dict.fromkeys(tables)) or (tuple(TABLES) if form == FOLDER else (FIRST,))
    if form != FOLDER and len(chosen) > 1:
        raise click.UsageError(words("export.one", name=output), context)
    if form != FOLDER and "signals" in chosen:
        raise click.UsageError(words("export.wide", name=output), context)
    # A link that the user names stands for what it points to.
    path = Path(output)
    return Target(Path(os.path.realpath(path)) if path.is_symlink() else path, form, chosen)
