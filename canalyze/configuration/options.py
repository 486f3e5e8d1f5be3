"""Options that several commands have, and what becomes of them.

Descriptions stand in `words`. An option of one command only stands in that command's file.
"""

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypedDict

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
        """Take the values in the order in which help shows them."""
        super().__init__(list(values))
        self._words = words

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """Give the values, as help shows them."""
        return "|".join(self.choices)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Give the value if it is one of ours."""
        if value in self.choices:
            return str(value)
        option = param.opts[-1] if param else ""
        choices = ", ".join(self.choices)
        raise click.UsageError(self._words("usage.choice", option=option, value=value or '""', choices=choices), ctx)


class Spelled(click.ParamType[Any]):
    """A value that is read from its text; one that cannot be is a usage error in the words `usage.FORM`."""

    name = "text"

    def __init__(self, read: Callable[[str], object], form: str, words: Words) -> None:
        """`read` gives None for what cannot be."""
        self._read = read
        self._form = form
        self._words = words

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Give what the text says."""
        found = self._read(value)
        if found is not None:
            return found
        option = param.opts[-1] if param else ""
        form = self._form
        if form in ("eds", "cob", "sdo") and (no_node := network.no_node(value, form)) is not None:
            form, value = "node", no_node
        raise click.UsageError(self._words(f"usage.{form}", option=option, value=value or '""'), ctx)


def spelled(
    words: Words, names: str, read: Callable[[str], object], form: str, metavar: str, help_key: str, **more: Any
) -> click.Option:
    """Give an option whose value is `Spelled`; names: those of the option, with blanks between."""
    kind = Spelled(read, form, words)
    return click.Option(names.split(), type=kind, metavar=metavar, help=words(help_key), **more)


def positive(text: str) -> int | None:
    """Read a number above 0."""
    return int(text) or None if text.isdecimal() and len(text) < 19 else None


def moment(text: str) -> float | None:
    """Read a time from the start of a capture, in seconds."""
    return float(text) if re.fullmatch(r"[0-9]{1,12}(?:\.[0-9]{1,12})?", text) else None


class NetworkOptions(TypedDict, total=False):
    """What `network_options` give a command, by the names of its parameters."""

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
    """What `capture_options` give a command beside files, filter, stamps and output, by the names of its parameters."""

    input_format: str | None
    merge: bool
    threads: int | None
    topic: tuple[str, ...]
    time_source: str | None
    mcap_map: tuple[str, ...]


def common_options(words: Words) -> list[click.Parameter]:
    """Return the options that every command has. All but --help are settled before click sees them."""
    return [
        click.Option(["--lang"], type=OneOf(LANGUAGES, words), expose_value=False, help=words("opt.lang")),
        click.Option(["--config"], type=ANY_PATH, metavar="FILE", expose_value=False, help=words("opt.config")),
        click.Option(["--no-pager"], is_flag=True, expose_value=False, help=words("opt.no_pager")),
        click.Option(
            ["-h", "--help"],
            is_flag=True,
            is_eager=True,
            expose_value=False,
            callback=_show_help,
            help=words("opt.help"),
        ),
    ]


def _show_help(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from canalyze.output import Output

        Output().text(ctx.get_help() + "\n")
        ctx.exit()


def capture_options(words: Words) -> list[click.Parameter]:
    """Give what every command that reads captures has."""
    return [
        click.Argument(["files"], nargs=-1, type=ANY_PATH, metavar="FILE"),
        *reading_options(words),
        click.Option(["--eds-from-traffic"], is_flag=True, help=words("stored.option")),
        *output_options(words),
    ]


def reading_options(words: Words) -> list[click.Parameter]:
    """Give how captures are read, whatever becomes of them."""
    from canalyze.sources.format import input_formats

    return [
        *filter_options(words),
        click.Option(
            ["--stamps"],
            type=OneOf(("auto", "absolute", "zero", "delta"), words),
            default="auto",
            help=words("opt.stamps"),
        ),
        click.Option(["--input-format"], type=OneOf(input_formats(), words), help=words("opt.input_format")),
        click.Option(["--merge"], is_flag=True, help=words("opt.merge")),
        spelled(words, "--threads", positive, "positive", "N", "opt.threads"),
        *topic_options(words),
        *network_options(words),
    ]


class Short(NamedTuple):
    """An option that is short for one condition of --filter."""

    option: str
    read: Callable[[str], str | None]
    """Returns the condition, None for a text that cannot be."""
    form: str
    """The words of a usage error."""
    metavar: str
    same: str
    """The condition, as help shows it."""
    help_key: str

    @property
    def name(self) -> str:
        """The name of its parameter; a command may have an option of the same name with a meaning of its own."""
        return f"filter_{self.option.removeprefix('--')}"


def _of_nodes(text: str) -> str | None:
    nodes = network.nodes(text)
    return None if nodes is None else f"node={','.join(map(str, nodes))}"


def _with_text(text: str) -> str | None:
    return None if not text or '"' in text else f'text="{text}"'


SHORT: Final = (
    Short("--node", _of_nodes, "node", "N", "node=N", "opt.short_node"),
    Short("--grep", _with_text, "grep", "TEXT", 'text="TEXT"', "opt.short_grep"),
)
PROBLEM: Final = "filter_problem"
"""The parameter of --problem: the number of a problem, from which `running.chosen` makes a condition."""


def filter_options(words: Words) -> list[click.Parameter]:
    """Return --filter and the options that are short for a condition of it."""
    return [
        click.Option(["--filter", "expression"], metavar="EXPR", help=words("opt.filter")),
        *(
            click.Option(
                [one.option, one.name],
                type=Spelled(one.read, one.form, words),
                metavar=one.metavar,
                help=words("opt.short", what=words(one.help_key), same=one.same),
            )
            for one in SHORT
        ),
    ]


def problem_option(words: Words) -> click.Option:
    """Return --problem, for a command that reads one capture."""
    return spelled(words, f"--problem {PROBLEM}", positive, "positive", "N", "opt.problem")


def filters_given() -> list[str]:
    """Return the options of the command line that choose what is shown."""
    context = click.get_current_context()
    names = {"expression", "select", PROBLEM, *(one.name for one in SHORT)}
    typed = click.core.ParameterSource.COMMANDLINE
    return [
        one.opts[-1]
        for one in context.command.params
        if one.name in names and context.get_parameter_source(one.name) is typed
    ]


def topic_options(words: Words) -> list[click.Parameter]:
    """Give what says how a file of topics (MCAP) is read."""
    return [
        click.Option(["--topic"], metavar="GLOB", multiple=True, help=words("opt.topic")),
        click.Option(["--time-source"], type=OneOf(("stamp", "publish", "log"), words), help=words("opt.time_source")),
        click.Option(["--mcap-map"], metavar="KEY=FIELD,...", multiple=True, help=words("opt.mcap_map")),
    ]


def network_options(words: Words) -> list[click.Parameter]:
    """Give what says which devices are on the bus; a command takes them as `**given: Unpack[NetworkOptions]`."""
    return [
        spelled(words, "--eds", network.description, "eds", "[[BUS:]NODE=]FILE", "opt.eds", multiple=True),
        spelled(words, "--cob", network.cob, "cob", "[BUS:]ID=NODE.PDO", "opt.cob", multiple=True),
        spelled(words, "--pdo", network.pdo_mapping, "pdo", "[BUS:]PDO=MAPPING", "opt.pdo", multiple=True),
        spelled(words, "--profile", network.profile, "profile", "[BUS:]NODE=401|402", "opt.profile", multiple=True),
        spelled(words, "--sdo", network.sdo_channel, "sdo", "[BUS:]ID,ID=NODE", "opt.sdo", multiple=True),
        spelled(words, "--sync-period", network.period, "period", "US", "opt.sync_period"),
        spelled(words, "--sync-window", network.period, "period", "US", "opt.sync_window"),
        spelled(words, "--jitter", network.tolerance, "tolerance", "US", "opt.jitter"),
    ]


def bitrate_option(words: Words, help_key: str = "opt.bitrate") -> click.Option:
    """Give --bitrate, for a command that says how much of the bus is used."""
    return spelled(words, "--bitrate", network.bit_rate, "bit_rate", "BPS", help_key)


def output_options(words: Words) -> list[click.Parameter]:
    """Give what every command that may write a file has."""
    return [
        click.Option(["-o", "--output"], type=ANY_PATH, metavar="FILE", help=words("opt.output")),
        click.Option(["--force"], is_flag=True, help=words("opt.force")),
    ]


def format_option(words: Words, command: str, forms: tuple[str, ...] = ("text", "jsonl")) -> click.Option:
    """Give --format with the command's own description; the first form is the default."""
    return click.Option(
        ["--format", "form"], type=OneOf(forms, words), default=forms[0], help=words(f"{command}.format")
    )


def listing_options(words: Words) -> list[click.Parameter]:
    """Give the options of an annotated listing: --brief, --explain, --format, -t, --number and --color."""
    return [
        click.Option(["--brief"], is_flag=True, help=words("decode.brief")),
        click.Option(["--explain"], is_flag=True, help=words("decode.explain")),
        format_option(words, "decode"),
        time_option(words, "decode.time", deltas=True),
        click.Option(["-n", "--number/--no-number"], default=None, help=words("opt.number")),
        color_option(words),
    ]


def time_option(words: Words, help_key: str = "opt.time", *, deltas: bool = False) -> click.Option:
    """Give -t. deltas: one line follows another, so that there is a time between them."""
    forms = ("a", "d", "z", "A", "n") if deltas else ("a", "z", "A", "n")
    return click.Option(["-t", "time"], type=OneOf(forms, words), help=words(help_key))


def clock(time: str | None, form: str, output: str | None) -> str | None:
    """Return the form of times: that of -t, without it the time since the start for text on a terminal."""
    from canalyze.output import terminal_encoding

    shown = form == "text" and output in (None, "-") and terminal_encoding() is not None
    return "z" if time is None and shown else time


def color_option(words: Words) -> click.Option:
    """Give --color, for a command whose text may stand out by colours."""
    return click.Option(
        ["--color"], type=OneOf(("auto", "always", "never"), words), default="auto", help=words("opt.color")
    )


def depth_of(form: str, words: Words, *, brief: bool, explain: bool, number: bool | None = None) -> str:
    """Give how much a line of a listing says, as the core calls it; what does not go together is a usage error."""
    context = click.get_current_context()
    if brief and explain:
        raise click.UsageError(words("usage.exclusive", one="--brief", other="--explain"), context)
    wanted = {"--brief": brief, "--explain": explain, "--number": number}
    for option in (option for option, given in wanted.items() if given and form != "text"):
        raise click.UsageError(words("usage.text_only", option=option), context)
    return "brief" if brief else "explain" if explain else "default"


class CoreUsageError(click.UsageError):
    """What the core cannot accept, in its own words."""


def open_session(
    words: Words, given: CaptureOptions, *, read: dict[str, Any] | None = None, **settings: Any
) -> "Session":
    """Start the core with these settings and what is known of the network.

    What the core cannot accept (a filter, a map) is a usage error. read: gets the descriptions, by their files.
    """
    from canalyze.configuration.descriptions import network as known

    context = click.get_current_context()
    filed = (context.find_object(Config) or Config()).known
    try:
        return start_session(words, given, network=known(filed, known_of(given), words, read=read), **settings)
    except ValueError as error:
        raise CoreUsageError(str(error), context) from error


def start_session(words: Words, given: CaptureOptions, **settings: Any) -> "Session":
    """Start the core with these settings, the network among them; ValueError for what it cannot accept.

    A setting that is None is as it is without it.
    """
    from canalyze._core import Session
    from canalyze.running.options import SessionOptions

    settings |= {
        "topics": given.get("topic"),
        "mcap_maps": given.get("mcap_map"),
        "time_source": given.get("time_source"),
        "threads": given.get("threads"),
    }
    wanted = {name: value for name, value in settings.items() if value is not None}
    return Session(SessionOptions(words.lang, **wanted))


def known_of(given: CaptureOptions) -> network.Known:
    """Give what options say of the network."""
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
    """Give the inputs: those named, else standard input if it is a pipe or a file; none is a usage error."""
    from canalyze.running.run import piped
    from canalyze.sources.file import STDIN

    if files:
        return files
    if piped():
        return (STDIN,)
    raise click.UsageError(words("usage.no_input"), click.get_current_context())
