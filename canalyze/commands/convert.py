"""`canalyze convert`: captures in another format. What a format holds and loses, the core and the sinks say."""

import errno
import os
from pathlib import Path

from canalyze.configuration.options import ANY_PATH, FORCE, PROBLEM, READING, argument, option, usage
from canalyze.errors import OutputError
from canalyze.output import Progress, complain
from canalyze.running.passes import Pass, pass_command
from canalyze.sinks import RECORDS, STDOUT, Target, compressions, forms, open_target, suffixes, target
from canalyze.sources import STDIN, total_size
from canalyze.words import Words


class _Unwanted(Exception):
    """Leaves the block of an output so that no file is left behind."""


def run(one: Pass) -> int:
    """Writes every frame in the other format."""
    files, out = one.files, one.given["out"]
    if out is None:
        raise one.usage("convert.none")
    if not files:
        raise one.usage("convert.one", name=out, out="capture.mcap" if out.endswith(".log") else "capture.log")
    where = _where(out, one.to, one.words)
    wanted = {"--decoded": one.decoded, "--mcap-fd-schema": one.mcap_fd_schema, "--mcap-archive": one.mcap_archive}
    for name in (name for name, value in wanted.items() if value and where.form != "mcap"):
        raise one.usage("convert.mcap_only", option=name)
    session = one.session(
        format="convert",
        to=where.written,
        decoded=one.decoded,
        mcap_fd_schema=one.mcap_fd_schema or "ros2",
        mcap_archive=one.mcap_archive,
    )
    itself = _is_input(out, files)
    if itself and not one.force:
        raise OutputError("convert.itself", name=out)
    total = total_size(files)
    name = one.words("convert.stdout") if out == STDOUT else os.fsencode(out).decode("utf-8", "backslashreplace")
    output, losses = open_target(where, force=one.force)
    one.progress = Progress(one.words, output, total)
    code = 0
    try:
        with output:
            code = one.read(session, output.write)
            if session.frames == 0 or (itself and code):
                raise _Unwanted
            # Files that were not read to their ends must not look whole when written; a stream has no other end.
            part = output.leave() if code >= 128 and total is not None else None
    except _Unwanted:
        if itself or code >= 128:
            one.note("convert.kept" if itself else "output.dropped", name=name)
        return code
    complain(*session.losses(name, dict(losses)))
    if code >= 128:
        one.note("output.part" if part else "convert.cut", name=name, part=part, frames=session.frames)
    return code


def _where(out: str, to: str | None, words: Words) -> Target:
    """Returns where it goes; a usage error where that cannot be."""
    where = target(out, to)
    if where is None:
        if Path(out).is_dir():
            raise OutputError(
                "output.write", name=out, error=IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            )
        if out == STDOUT:
            raise usage(words, "convert.needs_to", choices=", ".join(forms()))
        raise usage(words, "convert.suffix", name=out, allowed=" ".join(suffixes()), packed=" ".join(compressions()))
    if where.written == RECORDS and (where.compression or out == STDOUT):
        key = "convert.no_stdout" if out == STDOUT else "convert.no_compression"
        raise usage(words, key, form=where.form, name=out)
    if out == STDOUT and not where.fits_terminal and os.isatty(1):
        raise usage(words, "convert.terminal", form=where.form)
    return where


def _is_input(out: str, files: tuple[str, ...]) -> bool:
    """Returns true if the file to be written is one of those that are read."""
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


command = pass_command(
    "convert",
    run,
    argument("files", "IN", nargs=-1, type=ANY_PATH),
    argument("out", "OUT", required=False, type=ANY_PATH),
    option("--to", choices=forms, usual=0),
    PROBLEM,
    *READING,
    option("--decoded"),
    option("--mcap-fd-schema", choices=("ros2", "dataspeed"), key="convert.fd_schema"),
    option("--mcap-archive", key="convert.archive"),
    FORCE,
)
