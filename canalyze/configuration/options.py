"""Options as rows: those that several commands have, and what becomes of them.

A row says once what help, usage errors and completion need; `built` makes it a parameter of click in one language. Its
words are in `words`: `COMMAND.NAME`, or the key that the row names. An option of one command only is in that command's
file.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypedDict, cast

import click

from canalyze.configuration import network
from canalyze.configuration.config import Config
from canalyze.words import LANGUAGES, Words

if TYPE_CHECKING:
    from canalyze._core import Session


ANY_PATH: Final = click.Path(allow_dash=True, readable=False)
"""A name of a file, also `-`: what is wrong with it is said when it is opened, in the words of the run."""


class OneOf(click.Choice[str]):
    """A choice whose error is in the words of the run."""

    def __init__(self, values: Sequence[str], words: Words) -> None:
        """Takes the values in the order in which help shows them."""
        super().__init__(list(values))
        self._words = words

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """Returns the values, as help shows them."""
        return "|".join(self.choices)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Returns the value if it is one of them; a usage error for another."""
        if value in self.choices:
            return str(value)
        option = param.opts[-1] if param else ""
        choices = ", ".join(self.choices)
        raise click.UsageError(self._words("usage.choice", option=option, value=value or '""', choices=choices), ctx)


class Spelled(click.ParamType[Any]):
    """A value that is read from its text; one that cannot be is a usage error in the words `usage.FORM`."""

    name = "text"

    def __init__(self, read: Callable[[str], object], form: str, words: Words) -> None:
        """`read` returns None for what cannot be."""
        self._read = read
        self._form = form
        self._words = words

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Returns the value of the text."""
        found = self._read(value)
        if found is not None:
            return found
        option = param.opts[-1] if param else ""
        form = self._form
        if form in ("eds", "cob", "sdo") and (no_node := network.no_node(value, form)) is not None:
            form, value = "node", no_node
        raise click.UsageError(self._words(f"usage.{form}", option=option, value=value or '""'), ctx)


class HelpOption(click.Option):
    """An option that knows where help shows it, and looks its words up when they are shown."""

    def __init__(
        self, names: Sequence[str], said: Callable[[], str], *, topic: str, usual: int | None, **more: Any
    ) -> None:
        """Takes its heading, and its rank among the usual options of a command; None: it is not one of them."""
        super().__init__(names, **more)
        self.said = said
        self.topic = topic
        self.usual = usual

    @property
    def help(self) -> str:
        """Its words."""
        return self.said()

    @help.setter  # noqa: A003 - as click calls it
    def help(self, _: str | None) -> None:
        """Ignores what click sets."""


class Parameter(NamedTuple):
    """A row: an argument or an option, before its language is known."""

    names: tuple[str, ...]
    """As on the command line; without a dash, the name of the parameter."""
    metavar: str | None
    read: Callable[[str], object] | None
    """Returns the value, None for a text that cannot be: a usage error in the words `usage.FORM`."""
    form: str
    choices: Sequence[str] | Callable[[], Sequence[str]]
    key: str | Callable[[Words], str]
    """The words of its help; "": `COMMAND.NAME`."""
    topic: str
    """Its heading in help."""
    usual: int | None
    """Its rank among the usual options, which help shows first; those of one rank in the order of the command."""
    more: dict[str, Any]
    """Further arguments for click."""

    @property
    def name(self) -> str:
        """The name of the parameter."""
        last = self.names[-1]
        return last if not last.startswith("-") else last.partition("/")[0].lstrip("-").replace("-", "_")

    def built(self, command: str, words: Words) -> click.Parameter:
        """Returns it in one language."""
        choices = self.choices() if callable(self.choices) else self.choices
        more = dict(self.more)
        if choices:
            more["type"] = OneOf(choices, words)
        elif self.read is not None:
            more["type"] = Spelled(self.read, self.form, words)
        if not self.names[0].startswith("-"):
            return click.Argument(self.names, metavar=self.metavar, **more)
        if not (self.metavar or "type" in more):
            more["is_flag"] = True
        long = next((name for name in self.names[::-1] if name.startswith("--")), self.names[-1]).partition("/")[0]
        key = self.key or f"{command}.{long.lstrip('-').replace('-', '_')}"
        said = partial(words, key) if isinstance(key, str) else partial(key, words)
        return HelpOption(self.names, said, metavar=self.metavar, topic=self.topic, usual=self.usual, **more)


def option(
    names: str,
    metavar: str | None = None,
    read: Callable[[str], object] | None = None,
    form: str = "",
    *,
    choices: Sequence[str] | Callable[[], Sequence[str]] = (),
    key: str | Callable[[Words], str] = "",
    topic: str = "own",
    usual: int | None = None,
    **more: Any,
) -> Parameter:
    """Returns the row of an option, a flag without a value; names: with blanks between."""
    return Parameter(tuple(names.split()), metavar, read, form, choices, key, topic, usual, more)


def argument(name: str, metavar: str, *, choices: Sequence[str] = (), **more: Any) -> Parameter:
    """Returns the row of an argument."""
    return Parameter((name,), metavar, None, "", choices, "", "", None, more)


def built(rows: Iterable[Parameter], command: str, words: Words) -> list[click.Parameter]:
    """Returns the parameters of a command in one language."""
    return [row.built(command, words) for row in rows]


def usage(words: Words, key: str, **facts: object) -> click.UsageError:
    """Returns a usage error of the command that is run."""
    return click.UsageError(words(key, **facts), click.get_current_context())


def configured() -> Config:
    """Returns the configuration of the run."""
    return click.get_current_context().find_object(Config) or Config()


def positive(text: str) -> int | None:
    """Reads a number above 0."""
    return int(text) or None if text.isdecimal() and len(text) < 19 else None


def moment(text: str) -> float | None:
    """Reads a time from the start of a capture, in seconds."""
    return float(text) if re.fullmatch(r"[0-9]{1,12}(?:\.[0-9]{1,12})?", text) else None


class NetworkOptions(TypedDict, total=False):
    """The parameters of `NETWORK`, by their names."""

    eds: tuple[network.Description, ...]
    cob: tuple[network.Cob, ...]
    pdo: tuple[network.PdoMapping, ...]
    profile: tuple[network.NodeProfile, ...]
    sdo: tuple[network.SdoChannel, ...]
    sync_period: int | None
    sync_window: int | None
    jitter: int | None
    bitrate: int | None


class CaptureOptions(NetworkOptions, total=False):
    """The parameters of `CAPTURE` beside files, filter, stamps and output, by their names."""

    input_format: str | None
    merge: bool
    threads: int | None
    topic: tuple[str, ...]
    time_source: str | None
    mcap_map: tuple[str, ...]


def _show_help(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from canalyze.output import Output

        Output().text(ctx.get_help() + "\n")
        ctx.exit()


def _formats() -> Sequence[str]:
    from canalyze.sources import input_formats

    return input_formats()


def _of_nodes(text: str) -> str | None:
    nodes = network.nodes(text)
    return None if nodes is None else f"node={','.join(map(str, nodes))}"


def _with_text(text: str) -> str | None:
    return None if not text or '"' in text else f'text="{text}"'


def _short(key: str, same: str) -> Callable[[Words], str]:
    return lambda words: words("opt.short", what=words(key), same=same)


COMMON: Final = (
    option("--lang", choices=LANGUAGES, key="opt.lang", topic="general", expose_value=False),
    option("--config", "FILE", key="opt.config", topic="general", type=ANY_PATH, expose_value=False),
    option("--no-pager", key="opt.no_pager", topic="general", expose_value=False),
    option("-h --help", key="opt.help", topic="general", is_eager=True, expose_value=False, callback=_show_help),
)
"""Options of every command. All but --help are settled before click sees them."""

FILES: Final = argument("files", "FILE", nargs=-1, type=ANY_PATH)
FILTER: Final = option("--filter expression", "EXPR", key="opt.filter", topic="chosen", usual=2)
SHORT: Final = (
    option("--node filter_node", "N", _of_nodes, "node", key=_short("opt.short_node", "node=N"), topic="chosen"),
    option(
        "--grep filter_grep", "TEXT", _with_text, "grep", key=_short("opt.short_grep", 'text="TEXT"'), topic="chosen"
    ),
)
"""Options that are short for a condition of --filter; a command may have one of the name with a meaning of its own."""
PROBLEM: Final = option("--problem filter_problem", "N", positive, "positive", key="opt.problem", topic="chosen")
"""The number of a problem, from which `running.diagnosing` makes a condition; for a command that reads one capture."""
SELECT: Final = option("--select", "GLOBS", key="signals.select", topic="chosen", usual=3)
STAMPS: Final = option(
    "--stamps", choices=("auto", "absolute", "zero", "delta"), default="auto", key="opt.stamps", topic="time"
)
INPUT_FORMAT: Final = option("--input-format", choices=_formats, key="opt.input_format", topic="input")
TOPICS: Final = (
    option("--topic", "GLOB", key="opt.topic", topic="input", multiple=True),
    option("--time-source", choices=("stamp", "publish", "log"), key="opt.time_source", topic="input"),
    option("--mcap-map", "KEY=FIELD,...", key="opt.mcap_map", topic="input", multiple=True),
)
"""Options for reading a file of topics (MCAP)."""
EDS: Final = option(
    *("--eds", "[[BUS:]NODE=]FILE", network.description, "eds"), key="opt.eds", topic="network", usual=1, multiple=True
)
NETWORK: Final = (
    EDS,
    option("--cob", "[BUS:]ID=NODE.PDO", network.cob, "cob", key="opt.cob", topic="network", multiple=True),
    option("--pdo", "[BUS:]PDO=MAPPING", network.pdo_mapping, "pdo", key="opt.pdo", topic="network", multiple=True),
    option(
        *("--profile", "[BUS:]NODE=401|402", network.profile, "profile"),
        key="opt.profile",
        topic="network",
        multiple=True,
    ),
    option("--sdo", "[BUS:]ID,ID=NODE", network.sdo_channel, "sdo", key="opt.sdo", topic="network", multiple=True),
    option("--sync-period", "US", network.period, "period", key="opt.sync_period", topic="time"),
    option("--sync-window", "US", network.period, "period", key="opt.sync_window", topic="time"),
    option("--jitter", "US", network.tolerance, "tolerance", key="opt.jitter", topic="time"),
)
"""Options for the devices on the bus: `NetworkOptions`."""
MERGE: Final = option("--merge", key="opt.merge", topic="input", usual=10)
THREADS: Final = option("--threads", "N", positive, "positive", key="opt.threads", topic="input")
READING: Final = (FILTER, *SHORT, STAMPS, INPUT_FORMAT, MERGE, THREADS, *TOPICS, *NETWORK)
"""Options for reading captures, for all commands."""
FORCE: Final = option("--force", key="opt.force", topic="output", usual=11)
OUTPUT: Final = (option("-o --output", "FILE", key="opt.output", topic="output", usual=7, type=ANY_PATH), FORCE)
CAPTURE: Final = (FILES, *READING, option("--eds-from-traffic", key="stored.option", topic="network"), *OUTPUT)
"""Rows of every command that reads captures."""
BITRATE: Final = option("--bitrate", "BPS", network.bit_rate, "bit_rate", key="opt.bitrate", topic="network", usual=5)
"""For a command that says how much of the bus is used."""
TIME: Final = option("-t time", choices=("a", "z", "A", "n"), key="opt.time", topic="time", usual=6)
CLOCK: Final = TIME._replace(key="opt.clock")
"""For a command that uses `clock`."""
COLOR: Final = option("--color", choices=("auto", "always", "never"), default="auto", key="opt.color", topic="output")
"""For a command whose text may have colours."""


def form(*forms: str, key: str = "") -> Parameter:
    """Returns --format with the command's own description; the first form is the default."""
    return option("--format form", choices=forms, default=forms[0], key=key, topic="output", usual=9)


LISTING: Final = (
    option("--brief", key="decode.brief"),
    option("--explain", key="decode.explain", usual=0),
    form("text", "jsonl", key="decode.format"),
    TIME._replace(choices=("a", "d", "z", "A", "n"), key="decode.time"),
    option("-n --number/--no-number", default=None, key="opt.number", topic="output"),
    COLOR,
)
"""Options of an annotated listing; -t has the time between lines, too."""


def typed() -> list[click.Parameter]:
    """Returns the parameters that are on the command line."""
    context = click.get_current_context()
    line = click.core.ParameterSource.COMMANDLINE
    return [one for one in context.command.params if context.get_parameter_source(one.name or "") is line]


def filters_given() -> list[str]:
    """Returns the options of the command line that choose what is shown."""
    return [one.opts[-1] for one in typed() if isinstance(one, HelpOption) and one.topic == "chosen"]


def clock(time: str | None, form: str, output: str | None) -> str | None:
    """Returns the form of times: that of -t, without it the time since the start for text on a terminal."""
    from canalyze.output import terminal_encoding

    shown = form == "text" and output in (None, "-") and terminal_encoding() is not None
    return "z" if time is None and shown else time


def depth_of(form: str, words: Words, *, brief: bool, explain: bool, number: bool | None = None) -> str:
    """Returns the core's name of how much a line says; options that do not go together are a usage error."""
    if brief and explain:
        raise usage(words, "usage.exclusive", one="--brief", other="--explain")
    wanted = {"--brief": brief, "--explain": explain, "--number": number}
    for name in (name for name, given in wanted.items() if given and form != "text"):
        raise usage(words, "usage.text_only", option=name)
    return "brief" if brief else "explain" if explain else "default"


class CoreUsageError(click.UsageError):
    """A setting that the core cannot accept, in its own words."""


@contextmanager
def accepted() -> Iterator[None]:
    """Raises a ValueError of the core as a usage error."""
    try:
        yield
    except ValueError as error:
        raise CoreUsageError(str(error), click.get_current_context()) from error


def open_session(
    words: Words, given: CaptureOptions, *, read: dict[str, Any] | None = None, **settings: Any
) -> "Session":
    """Starts the core with these settings and what is known of the network.

    What the core cannot accept (a filter, a map) is a usage error. read: gets the descriptions, by their files.
    """
    from canalyze.configuration.network import network as known

    with accepted():
        told = known(configured().known, known_of(given), words, read=read)
        return start_session(words, given, network=told, **settings)


def start_session(words: Words, given: CaptureOptions, **settings: Any) -> "Session":
    """Starts the core with these settings, the network among them; ValueError for what it cannot accept.

    A setting that is None is as it is without it.
    """
    from canalyze._core import Session
    from canalyze.running.reading import SessionOptions

    settings |= {
        "topics": given.get("topic"),
        "mcap_maps": given.get("mcap_map"),
        "time_source": given.get("time_source"),
        "threads": given.get("threads"),
    }
    wanted = {name: value for name, value in settings.items() if value is not None}
    return Session(SessionOptions(words.lang, **wanted))


def reading_of(given: Any) -> CaptureOptions:
    """Returns how captures are read, of all parameters of a command."""
    read = {name: given[name] for name in CaptureOptions.__annotations__ if name in given}
    return cast("CaptureOptions", read)


def known_of(given: CaptureOptions) -> network.Known:
    """Returns the network of the options."""
    return network.Known(
        given.get("eds", ()),
        given.get("cob", ()),
        given.get("sdo", ()),
        given.get("sync_period"),
        given.get("sync_window"),
        given.get("jitter"),
        given.get("bitrate"),
        given.get("pdo", ()),
        given.get("profile", ()),
    )


def inputs(files: tuple[str, ...], words: Words) -> tuple[str, ...]:
    """Returns the inputs: those named, else standard input if it is a pipe or a file; none is a usage error."""
    from canalyze.running.run import piped
    from canalyze.sources import STDIN

    if files:
        return files
    if piped():
        return (STDIN,)
    raise usage(words, "usage.no_input")
