"""Options of the library, checked, as the settings of the core's sessions; and the sources that it reads, as inputs.

One way for captures, listeners and buses: descriptions are read here, captures are not. What cannot be is a TypeError
or a ValueError that names the option. An input can be read again and again: files stay where they are, everything else
is taken at once and kept as bytes. It must not print, or know a format: what is in bytes tells the reader, as of a
file.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from canalyze.configuration import network
from canalyze.errors import SourceError, needed
from canalyze.library import Described, Descriptions, Known, Options
from canalyze.library.rows import one_of
from canalyze.running.reading import SessionOptions
from canalyze.sources import Capture, Memory, Source, identified, input_formats
from canalyze.sources.bridge import is_message, of_messages
from canalyze.words import Words

if TYPE_CHECKING:
    from canopen import ObjectDictionary

    from canalyze._core import Session
    from canalyze.dictionary import Dictionary

T = TypeVar("T")

_KINDS: Final[Mapping[str, tuple[type, ...]]] = {
    **dict.fromkeys(("sync_period", "sync_window", "jitter", "bitrate"), (str, int)),
    **dict.fromkeys(("filter", "lang", "stamps", "input_format", "time_source"), (str,)),
    **dict.fromkeys(("config", "folder"), (str, os.PathLike)),
    "merge": (bool,),
}
"""Of which type an option is, where it is not several values; None stands for no option."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The settings by which something is read, checked."""

    folder: Path
    """Where relative names are looked for."""
    options: SessionOptions
    """The options that its sessions have in common."""
    words: Words
    """The language of complaints."""
    input_format: str | None
    """The format of the files, where their content does not tell it."""
    merge: bool
    """True if files are joined by time."""
    said: tuple[str, ...]
    """Lines about descriptions."""
    described: "Mapping[tuple[str | None, int], Dictionary | ObjectDictionary]"
    """Descriptions by bus and node."""
    network_rows: Callable[[], dict[str, Any]]
    """Returns what is known of the network as rows."""

    @property
    def page_options(self) -> dict[str, Any]:
        """The options of a session in a page."""
        options = self.options
        return {
            "stamps": options.stamps,
            "topics": list(options.topics),
            "time_source": options.time_source,
            "mcap_maps": list(options.mcap_maps),
            "network": self.network_rows(),
        }

    def session(self, form: str, filter: str | None = None, **more: Any) -> "Session":  # noqa: A002  an option's name
        """Starts a session of the core; ValueError for settings that it refuses."""
        from canalyze._core import Session

        return Session(self.options._replace(format=form, filter=filter or self.options.filter, **more))

    def dictionary(self, bus: str | None, node: int) -> "ObjectDictionary | None":
        """Returns the description of a node as python-canopen has it; None if it has none."""
        found = self.described.get((bus, node), self.described.get((None, node)))
        from canalyze.dictionary import Dictionary

        if not isinstance(found, Dictionary):
            return found
        from canalyze.dictionary import given

        return given(found, node)


def plan(who: str, options: Known | Options) -> Plan:
    """Checks options and reads descriptions. who: the function with these options."""
    from canalyze.configuration import config as configuration
    from canalyze.configuration.network import carriers, network_rows
    from canalyze.configuration.network import network as known

    asked: dict[str, Any] = dict(options)
    for name, value in asked.items():
        if name not in Options.__annotations__:
            raise TypeError(f"{who}: there is no option {name}")
        kinds = _KINDS.get(name)
        if kinds and value is not None and not isinstance(value, kinds):
            wanted = " or ".join(kind.__name__ for kind in kinds)
            raise TypeError(f"{name}={value!r}: {wanted} is needed, not {type(value).__name__}")
    lang, stamps, form = asked.get("lang", "en"), asked.get("stamps", "auto"), asked.get("input_format")
    one_of("lang", lang, ("en", "zh"))
    one_of("input_format", form, input_formats())
    words = Words(lang)
    base = Path.cwd() / (asked.get("folder") or "")
    read: dict[str, Dictionary] = {}
    own: dict[str, ObjectDictionary] = {}

    def spelled(name: str, reader: Callable[[str], T | None]) -> tuple[T, ...]:
        return tuple(_spelled(name, text, reader, name, words) for text in _texts(name, asked.get(name, ())))

    def amount(name: str, reader: Callable[[str], int | None], kind: str) -> int | None:
        value = asked.get(name)
        return None if value is None else _spelled(name, str(value), reader, kind, words)

    given = network.Known(
        tuple(_described(asked.get("eds", ()), base, words, read, own)),
        spelled("cob", network.cob),
        spelled("sdo", network.sdo_channel),
        amount("sync_period", network.period, "period"),
        amount("sync_window", network.period, "period"),
        amount("jitter", network.tolerance, "tolerance"),
        amount("bitrate", network.bit_rate, "bit_rate"),
        spelled("pdo", network.pdo_mapping),
        spelled("profile", network.profile),
    )
    config = asked.get("config")
    filed = network.Known() if config is None else configuration.read(str(base / os.fspath(config))).known
    said: list[str] = []
    session = SessionOptions(
        lang,
        stamps=stamps,
        filter=asked.get("filter"),
        network=known(filed, given, words, said.append, read),
        topics=_texts("topic", asked.get("topic", ())),
        time_source=asked.get("time_source"),
        mcap_maps=_texts("mcap_map", asked.get("mcap_map", ())),
    )
    carried = carriers(filed, given, read) if read else {}
    made = Plan(
        folder=base,
        options=session,
        words=words,
        input_format=form,
        merge=asked.get("merge", False),
        said=tuple(said),
        described={where: own.get(file, read[file]) for where, file in carried.items()},
        network_rows=partial(network_rows, filed, given, read),
    )
    made.session("info")  # ValueError for what the core cannot accept
    return made


def shown_as(path: Path) -> str:
    """Returns the name for messages: relative to the current directory if the file is below it."""
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else str(path)


def _described(
    eds: Descriptions, base: Path, words: Words, read: "dict[str, Dictionary]", own: "dict[str, ObjectDictionary]"
) -> Iterable[network.Description]:
    """Yields descriptions; those that are no files are read now, each by a name of its own."""
    if not isinstance(eds, Sequence):
        if not hasattr(eds, "items"):
            raise TypeError(f"eds={eds!r}: a dictionary of descriptions by node is needed, not {type(eds).__name__}")
        for key, given in eds.items():
            bus, node = key if isinstance(key, tuple) and len(key) == 2 else (None, key)
            if type(node) is not int or node not in network.NODES or not (bus is None or isinstance(bus, str)):
                raise ValueError(words("usage.node", option="eds", value=repr(key)))
            yield network.Description(bus, (node,), _file(given, key, base, read, own))
        return
    for text in _texts("eds", eds):
        found = _spelled("eds", text, network.description, "eds", words)
        yield network.Description(found.bus, found.nodes, shown_as(base / found.file))


def _file(
    given: Described, key: object, base: Path, read: "dict[str, Dictionary]", own: "dict[str, ObjectDictionary]"
) -> str:
    if isinstance(given, str | os.PathLike):
        return shown_as(base / os.fspath(given))
    if not hasattr(given, "indices"):
        raise TypeError(f"eds[{key!r}]: a file or a canopen.ObjectDictionary is needed, not {type(given).__name__}")
    name = next((name for name, one in own.items() if one is given), None)
    if name is None:
        from canalyze.dictionary import taken

        product = given.device_information.product_name or "ObjectDictionary"
        name = product if product not in read else f"{product} {len(own) + 1}"
        own[name], read[name] = given, taken(given, name)
    return name


def _texts(name: str, given: Any) -> list[str]:
    """Returns a list of texts; a single text is one item."""
    try:
        texts = [given] if isinstance(given, str) else list(given)
    except TypeError:
        texts = [given]
    if not all(isinstance(text, str) for text in texts):
        raise ValueError(f"{name}={given!r}: not texts as on the command line")
    return texts


def _spelled(name: str, text: str, read: Callable[[str], T | None], form: str, words: Words) -> T:
    found = read(text)
    if found is None:
        raise ValueError(words(f"usage.{form}", option=name, value=text or '""'))
    return found


@dataclass(frozen=True, slots=True)
class Input:
    """One file, or what is as good as one."""

    name: str
    """For people."""
    path: Path | None
    """The file, absolute; None for what is in memory."""
    data: bytes = b""
    """The content in memory."""
    form: str | None = None
    """Its format where it is known."""

    def open(self) -> Capture:
        """Opens it; SourceError if that fails."""
        if self.form == "packed":
            return Capture(Memory(self.name, self.data), self.form)
        source = Memory(self.name, self.data) if self.path is None else Source(str(self.path), self.name)
        return identified(source, self.form)


def inputs(source: Any, plan: Plan) -> tuple[Input, ...]:
    """Returns the inputs of a source; TypeError for another type, SourceError for a file that is missing."""
    if isinstance(source, str | os.PathLike):
        return (_input(source, plan),)
    if isinstance(source, bytes | bytearray | memoryview):
        return (Input("bytes", None, bytes(source), plan.input_format),)
    if hasattr(source, "iter_messages"):  # a reader of MCAP; in the order of its file, as a file is read
        return (Input("mcap", None, _mcap_file(source.iter_messages(log_time_order=False)), "mcap"),)
    if hasattr(source, "read"):
        return (_open_file(source, plan),)
    if not isinstance(source, Iterable):
        raise TypeError(f"source: a file, bytes or messages are needed, not {type(source).__name__}")
    items = iter(source)
    first = next(items, None)
    if first is None:
        raise ValueError("source: no file, and no message")
    every = chain([first], items)
    if isinstance(first, str | os.PathLike):
        return tuple(_input(one, plan) for one in every)
    if is_message(first):
        return (Input("messages", None, of_messages(every), "packed"),)
    if _is_mcap(first):
        return (Input("mcap", None, _mcap_file(every), "mcap"),)
    raise TypeError(f"source: files or messages are needed, not {type(first).__name__}")


def _input(name: Any, plan: Plan) -> Input:
    """Returns the input of a file; SourceError, before it is read, if it cannot be opened."""
    if not isinstance(name, str | os.PathLike):
        raise TypeError(f"source: files are needed, not {type(name).__name__}")
    path = plan.folder / os.fspath(name)
    if not path.is_fifo():  # opening it would take the writer's first bytes
        with Source(str(path), shown_as(path)):
            pass
    return Input(shown_as(path), path, form=plan.input_format)


def _open_file(file: Any, plan: Plan) -> Input:
    data = file.read()
    if not isinstance(data, bytes | bytearray):
        raise TypeError("source: a file that is open for text; open it for bytes, as open(name, 'rb')")
    name = getattr(file, "name", None)
    return Input(name if isinstance(name, str) else "bytes", None, bytes(data), plan.input_format)


def _is_mcap(one: object) -> bool:
    """Returns true for an item of MCAP's reader: schema, channel, message, and optionally the decoded message."""
    return isinstance(one, tuple) and len(one) in (3, 4) and hasattr(one[1], "topic") and hasattr(one[2], "log_time")


def _mcap_file(messages: Iterable[tuple[Any, ...]]) -> bytes:
    """Returns messages of MCAP's own reader as a file. Raises SourceError if the library is not installed."""
    with needed(SourceError, "mcap", "mcap"):
        from mcap.writer import Writer
    file = BytesIO()
    writer = Writer(file)
    writer.start()
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    for number, item in enumerate(messages, 1):
        if not _is_mcap(item):
            raise TypeError(f"source: item {number} is no message of MCAP but {type(item).__name__}")
        schema, channel, message = item[:3]
        if channel.id not in channels:
            of = 0
            if schema is not None:
                if schema.id not in schemas:
                    schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
                of = schemas[schema.id]
            channels[channel.id] = writer.register_channel(
                channel.topic, channel.message_encoding, of, dict(channel.metadata)
            )
        writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()
