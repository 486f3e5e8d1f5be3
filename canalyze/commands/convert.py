"""`canalyze convert`: captures in another format. What a format holds and loses, the core and the sinks say."""

import errno
import os
from pathlib import Path
from typing import Unpack

import click

from canalyze.configuration.options import (
    ANY_PATH,
    CaptureOptions,
    OneOf,
    open_session,
    problem_option,
    reading_options,
)
from canalyze.errors import OutputError
from canalyze.output import Progress, complain
from canalyze.output.help import Command
from canalyze.running.run import Run
from canalyze.sinks.target import RECORDS, STDOUT, Target, compressions, forms, open_target, suffixes, target
from canalyze.sources.file import STDIN, total_size
from canalyze.words import Words


class _Unwanted(Exception):
    """Leaves the block of an output so that no file is left behind."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        files: tuple[str, ...],
        out: str | None,
        to: str | None,
        force: bool,
        expression: str | None,
        stamps: str,
        decoded: bool,
        mcap_fd_schema: str | None,
        mcap_archive: bool,
        **given: Unpack[CaptureOptions],
    ) -> int:
        if out is None:
            raise click.UsageError(words("convert.none"), click.get_current_context())
        if not files:
            example = "capture.mcap" if out.endswith(".log") else "capture.log"
            raise click.UsageError(words("convert.one", name=out, out=example), click.get_current_context())
        where = _where(out, to, words)
        wanted = {"--decoded": decoded, "--mcap-fd-schema": mcap_fd_schema, "--mcap-archive": mcap_archive}
        for option in (name for name, value in wanted.items() if value and where.form != "mcap"):
            raise click.UsageError(words("convert.mcap_only", option=option), click.get_current_context())
        session = open_session(
            words,
            given,
            format="convert",
            to=where.written,
            stamps=stamps,
            filter=expression,
            decoded=decoded,
            mcap_fd_schema=mcap_fd_schema or "ros2",
            mcap_archive=mcap_archive,
        )
        itself = _is_input(out, files)
        if itself and not force:
            raise OutputError("convert.itself", name=out)
        total = total_size(files)
        name = words("convert.stdout") if out == STDOUT else os.fsencode(out).decode("utf-8", "backslashreplace")
        output, losses = open_target(where, force=force)
        code = 0
        try:
            with output:
                code = Run(session, words, Progress(words, output, total), output.write, given).over(files)
                if session.frames == 0 or (itself and code):
                    raise _Unwanted
                # Files that were not read to their ends must not look whole when written; a stream has no other end.
                part = output.leave() if code >= 128 and total is not None else None
        except _Unwanted:
            if itself or code >= 128:
                key = "convert.kept" if itself else "output.dropped"
                complain(f"canalyze: {words(key, name=name)}")
            return code
        for line in session.losses(name, dict(losses)):
            complain(line)
        if code >= 128:
            key = "output.part" if part else "convert.cut"
            complain(f"canalyze: {words(key, name=name, part=part, frames=session.frames)}")
        return code

    return Command(
        "convert",
        words,
        run,
        [
            click.Argument(["files"], nargs=-1, type=ANY_PATH, metavar="IN"),
            click.Argument(["out"], required=False, type=ANY_PATH, metavar="OUT"),
            click.Option(["--to"], type=OneOf(forms(), words), help=words("convert.to")),
            problem_option(words),
            *reading_options(words),
            click.Option(["--decoded"], is_flag=True, help=words("convert.decoded")),
            click.Option(
                ["--mcap-fd-schema"],
                type=OneOf(("ros2", "dataspeed"), words),
                help=words("convert.fd_schema"),
            ),
            click.Option(["--mcap-archive"], is_flag=True, help=words("convert.archive")),
            click.Option(["--force"], is_flag=True, help=words("opt.force")),
        ],
    )


def _where(out: str, to: str | None, words: Words) -> Target:
    """Give where it goes; a usage error where that cannot be."""
    context = click.get_current_context()
    where = target(out, to)
    if where is None:
        if Path(out).is_dir():
            raise OutputError(
                "output.write", name=out, error=IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            )
        if out == STDOUT:
            raise click.UsageError(words("convert.needs_to", choices=", ".join(forms())), context)
        allowed, packed = " ".join(suffixes()), " ".join(compressions())
        raise click.UsageError(words("convert.suffix", name=out, allowed=allowed, packed=packed), context)
    if where.written == RECORDS and (where.compression or out == STDOUT):
        key = "convert.no_stdout" if out == STDOUT else "convert.no_compression"
        raise click.UsageError(words(key, form=where.form, name=out), context)
    if out == STDOUT and not where.fits_terminal and os.isatty(1):
        raise click.UsageError(words("convert.terminal", form=where.form), context)
    return where


def _is_input(out: str, files: tuple[str, ...]) -> bool:
    """Tell whether the file to be written is one of those that are read."""
    try:
        written = Path(out).stat()
    except (OSError, ValueError):
        return False
    for name in files:
        try:
            if os.path.samestat(os.fstat(0) if name == STDIN else Path(name).stat(), written):
                return True
        except (OSError, ValueError):
            continue
    return False
