"""`canalyze.open`: what is asked for in Python, as the settings by which a capture is read.

It checks what it is given at once and reads descriptions, not captures. It must not print, and it looks for no
canalyze.toml: what a program means does not depend on the folder in which it is started.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias, TypedDict, TypeVar

from canalyze import network
from canalyze.library.rows import one_of
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.library.capture import Capture

T = TypeVar("T")

StrPath: TypeAlias = str | os.PathLike[str]


class ByNode(Protocol):
    """Files by node-ID, or by bus and node-ID: a dictionary whose keys may be of one kind, or of both."""

    def items(self) -> Iterable[tuple[int | tuple[str, int], StrPath]]:
        """Give node and file."""


Descriptions: TypeAlias = ByNode | Sequence[str]


class Options(TypedDict, total=False):
    """The options of `open`, which says what they mean."""

    eds: Descriptions
    cob: Iterable[str]
    sdo: Iterable[str]
    sync_period: str | int | None
    sync_window: str | int | None
    jitter: str | int | None
    bitrate: str | int | None
    filter: str | None
    lang: Literal["en", "zh"]
    stamps: Literal["auto", "absolute", "zero", "delta"]
    input_format: str | None
    merge: bool
    topic: Iterable[str]
    time_source: Literal["stamp", "publish", "log"] | None
    mcap_map: Iterable[str]
    config: StrPath | None
    folder: StrPath | None


def open(  # noqa: A001  canalyze.open, as tarfile.open
    path: StrPath | Sequence[StrPath],
    *,
    eds: Descriptions = (),
    cob: Iterable[str] = (),
    sdo: Iterable[str] = (),
    sync_period: str | int | None = None,
    sync_window: str | int | None = None,
    jitter: str | int | None = None,
    bitrate: str | int | None = None,
    filter: str | None = None,  # noqa: A002  the command line's word
    lang: Literal["en", "zh"] = "en",
    stamps: Literal["auto", "absolute", "zero", "delta"] = "auto",
    input_format: str | None = None,
    merge: bool = False,
    topic: Iterable[str] = (),
    time_source: Literal["stamp", "publish", "log"] | None = None,
    mcap_map: Iterable[str] = (),
    config: StrPath | None = None,
    folder: StrPath | None = None,
) -> "Capture":
    """Open a capture of one file, or of several that are one capture; it is read when it is asked for something.

    path: a file in any format that canalyze reads, compressed or not; several are read in the given order. No
    bus: only `canalyze sniff` and `canalyze monitor` listen to one, and what they record can be opened.
    eds: which device is which, `{5: "drive.eds", ("can1", 6): "io.dcf"}`, or as --eds: `["5=drive.eds", "1-4=io.eds"]`.
    cob: which CAN-ID carries which PDO, as --cob: `["1A5=5.TPDO1"]`.
    sdo: further SDO channels, as --sdo: `["640,5C0=5"]`.
    sync_period, sync_window, jitter: in microseconds, or with a unit (`"10ms"`): 1006h, 1007h, and the error of the
    stamps to allow for. What the capture shows overrules the first two.
    bitrate: in bit/s, or `"500k"`.
    filter: which frames are told of, as --filter: `"service=sdo node=5 t=1.0..2.5"`. State comes from every frame.
    lang: the language of `text`, `message` and of names. English whatever the environment says, since names of
    signals stand in code.
    stamps: what small stamps mean. input_format: what the files are, where their content does not tell.
    merge: files are joined by time, not read one after the other.
    topic, time_source, mcap_map: how MCAP is read, as the options of these names.
    config: a canalyze.toml whose network counts too; none is looked for.
    folder: where relative names, also those of descriptions, are looked for; the current directory by default.

    SourceError for a capture or description that is missing or cannot be read (of a capture's content only once it is
    read), ConfigError for a configuration that cannot be, ValueError for an option that cannot be. Damage and lines
    that cannot be read are no error but `Capture.complaints`.
    """
    from canalyze import config as configuration
    from canalyze.descriptions import network as known
    from canalyze.library.capture import Capture, Plan
    from canalyze.sources.format import input_formats

    words = Words(_one_of("lang", lang, ("en", "zh")))
    base = Path.cwd() if folder is None else Path.cwd() / folder
    names = [path] if isinstance(path, str | os.PathLike) else list(path)
    if not names:
        raise ValueError("path: no file")
    paths = tuple(base / os.fspath(name) for name in names)
    shown = tuple(map(shown_as, paths))
    for one, name in zip(paths, shown, strict=True):
        _there(one, name)
    given = network.Known(
        tuple(_described(eds, base, words)),
        tuple(_spelled("cob", text, network.cob, words) for text in _texts("cob", cob)),
        tuple(_spelled("sdo", text, network.sdo_channel, words) for text in _texts("sdo", sdo)),
        _amount("sync_period", sync_period, network.period, "period", words),
        _amount("sync_window", sync_window, network.period, "period", words),
        _amount("jitter", jitter, network.tolerance, "tolerance", words),
        _amount("bitrate", bitrate, network.bit_rate, "bit_rate", words),
    )
    filed = network.Known() if config is None else configuration.read(str(base / os.fspath(config))).known
    if input_format is not None:
        _one_of("input_format", input_format, input_formats())
    said: list[str] = []
    settings = {
        "lang": lang,
        "stamps": stamps,
        "network": known(filed, given, words, said.append),
        "topics": _texts("topic", topic),
        "time_source": time_source,
        "mcap_maps": _texts("mcap_map", mcap_map),
    }
    plan = Plan(
        folder=base,
        paths=paths,
        shown=shown,
        settings={name: value for name, value in settings.items() if value is not None},
        filter=filter,
        words=words,
        input_format=input_format,
        merge=merge,
        said=tuple(said),
    )
    plan.session("info")  # ValueError for what the core cannot accept
    return Capture(plan)


def _there(path: Path, shown: str) -> None:
    """Raise SourceError where the file cannot be opened: nobody wants to hear of it only when it is read."""
    from canalyze.sources.file import Source

    if path.is_fifo():  # opening it would take the writer's first bytes
        return
    with Source(str(path), shown):
        pass


def shown_as(path: Path) -> str:
    """Give the name for messages: relative to the current directory where the file is below it."""
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else str(path)


def _described(eds: Descriptions, base: Path, words: Words) -> Iterable[network.Description]:
    if not isinstance(eds, Sequence):
        for key, file in eds.items():
            bus, node = key if isinstance(key, tuple) else (None, key)
            if type(node) is not int or node not in network.NODES:
                raise ValueError(words("usage.node", option="eds", value=repr(key)))
            yield network.Description(bus, (node,), shown_as(base / os.fspath(file)))
        return
    for text in _texts("eds", eds):
        found = _spelled("eds", text, network.description, words)
        yield network.Description(found.bus, found.nodes, shown_as(base / found.file))


def _texts(name: str, given: Iterable[str]) -> list[str]:
    """Take several texts; one text alone is several letters, which nobody means."""
    texts = [given] if isinstance(given, str) else list(given)
    if not all(isinstance(text, str) for text in texts):
        raise ValueError(f"{name}={given!r}: not texts as on the command line")
    return texts


def _spelled(name: str, text: str, read: Callable[[str], T | None], words: Words) -> T:
    found = read(text)
    if found is None:
        raise ValueError(words(f"usage.{name}", option=name, value=text or '""'))
    return found


def _amount(
    name: str, value: str | int | None, read: Callable[[str], int | None], form: str, words: Words
) -> int | None:
    if value is None:
        return None
    found = read(str(value))
    if found is None:
        raise ValueError(words(f"usage.{form}", option=name, value=value or '""'))
    return found


def _one_of(name: str, value: str, choices: Sequence[str]) -> str:
    one_of(name, value, choices)
    return value
