"""A command that reads captures once: its rows of options, and one pass from its files to its output.

    command = capture_command("signals", run, SELECT, form("csv", "jsonl"), TIME, PROBLEM)

`run` gets a `Pass` and returns the exit code. The objects of devices, by what a capture shows of them, are read for
several commands. Must not: know what a command shows.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import click

from canalyze.configuration.options import CAPTURE, Parameter, inputs, moment, open_session, option, usage
from canalyze.output import Output, Progress, complain, open_output, told
from canalyze.output.help import simple_command
from canalyze.running.run import Run
from canalyze.sources import total_size
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session


class Pass:
    """One command line: what is asked for, by the names of its parameters, and the way of its files to the output."""

    out: Output
    """The output; open while `opened` is."""
    progress: Progress

    def __init__(self, words: Words, given: Any) -> None:
        """Nothing is read yet."""
        self.words = words
        self.given = given

    def __getattr__(self, name: str) -> Any:
        """Returns the value of a parameter."""
        try:
            return self.__dict__["given"][name]
        except KeyError:
            raise AttributeError(name) from None

    def usage(self, key: str, **facts: object) -> click.UsageError:
        """Returns a usage error."""
        return usage(self.words, key, **facts)

    def complain(self, line: str) -> None:
        """Writes a line to standard error, with the progress out of its way."""
        if "progress" in self.__dict__:
            self.progress.clear()
        complain(f"canalyze: {line}")

    def note(self, key: str, **facts: object) -> None:
        """Writes a sentence to standard error."""
        self.complain(self.words(key, **facts))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The inputs; a usage error without any."""
        return inputs(self.given["files"], self.words)

    @property
    def total(self) -> int | None:
        """The bytes of all inputs; None if unknown."""
        return total_size(self.names)

    @contextmanager
    def opened(self, *, hangs: bool = False) -> Iterator[Output]:
        """Opens the output. hangs: lines have a hanging indent on a terminal."""
        given = self.given
        total = self.total
        with open_output(given["output"], force=given["force"], color=given.get("color", "auto"), hangs=hangs) as out:
            self.out, self.progress = out, Progress(self.words, out, total)
            yield out

    def session(self, words: Words | None = None, *, read: dict[str, Any] | None = None, **settings: Any) -> "Session":
        """Starts the core with what is asked for and these settings; words: in another language."""
        given = self.given
        asked = {"stamps": given["stamps"], "filter": given.get("expression"), "time": given.get("time")}
        return open_session(words or self.words, given, read=read, **asked | settings)

    def read(self, session: "Session", take: Callable[[bytes], None], names: tuple[str, ...] = (), **how: Any) -> int:
        """Reads everything, or these inputs; returns the exit code. take: gets every result. how: as of `Run`."""
        return Run(session, self.words, self.progress, take, self.given, **how).over(names or self.names)

    def report_end(self, code: int, some: object) -> None:
        """Reports what an output has whose reading a signal has ended."""
        told(code, self.out, self.words, stream=self.total is None, some=bool(some))

    def end(self, code: int, some: object) -> int:
        """Reports the same, and leaves no output that is empty; returns the code."""
        self.report_end(code, some)
        if not some:
            self.out.drop()
        return code


def pass_command(
    name: str, run: Callable[[Pass], int], *rows: Parameter, paged: bool = False
) -> Callable[[Words], click.Command]:
    """Returns how a command is made in one language whose parameters are a `Pass`."""
    return simple_command(name, lambda words, **given: run(Pass(words, given)), *rows, paged=paged)


def capture_command(
    name: str, run: Callable[[Pass], int], *rows: Parameter, without: tuple[Parameter, ...] = (), paged: bool = True
) -> Callable[[Words], click.Command]:
    """Returns the same, with the rows of all commands that read captures. without: those of them that it has not."""
    return pass_command(name, run, *rows, *(row for row in CAPTURE if row not in without), paged=paged)


FORMS: Final = {"text": "-text", "jsonl": "", "csv": "-csv"}
"""The ends of the core's names of what comes out, by the values of --format."""
AT: Final = option("--at", "S", moment, "moment", key="od.at", usual=0)
_NO_OBJECT: Final = b'{"kind":"od_pdo"'
"""PDOs come behind all objects: a result that begins so has none."""


class Objects(NamedTuple):
    """The objects of a capture, and how its reading ended."""

    code: int
    frames: int
    result: bytes
    """The JSON lines of the core."""
    some: bool
    """True if an object was seen."""


def settings_of(one: Pass) -> dict[str, Any]:
    """Returns the settings of the core for --at."""
    return {"until_ns": None if one.at is None else round(one.at * 1e9)}


def has_object(result: bytes) -> bool:
    """Returns true if a result of the core has an object."""
    return bool(result) and not result.startswith(_NO_OBJECT)


def read_objects(one: Pass, kind: str, names: tuple[str, ...] = (), **how: Any) -> Objects:
    """Reads a capture to its end. kind: the core's name of what comes out. how: as of `Pass.session`."""
    session = one.session(format=kind, **settings_of(one), **how)
    results: list[bytes] = []
    code = one.read(session, results.append, names)
    return Objects(code, session.frames, b"".join(results), any(map(has_object, results)))
