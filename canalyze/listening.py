"""The options of commands that listen to a bus: what is listened to, and what of it is recorded.

From names and options to open sources and open files; usage errors in the words of the run. Must not: read a source,
or show anything but what is to be known of an adapter before it is listened to.
"""

import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, TypedDict

import click

from canalyze import network
from canalyze.errors import CanalyzeError
from canalyze.options import ANY_PATH, Spelled, bitrate_option
from canalyze.recording import Limit, Recordings, form_of, limit, open_recordings, recordable
from canalyze.sources import buses, netdevices
from canalyze.sources.file import STDIN
from canalyze.sources.live import MOST_BUSES, Bus
from canalyze.words import Words

OWN: Final = "socketcan"
"""The interface that is not python-can's."""
_UNITS: Final = {"": 1.0, "ms": 0.001, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0, "d": 86400.0}
_FILTER: Final = re.compile("[0-9A-Fa-f]+[:~][0-9A-Fa-f]+|#[0-9A-Fa-f]+")
"""One of candump's filters: no interface can be called so."""
_LONGEST_S: Final = 366 * 86400.0


class ListeningOptions(TypedDict, total=False):
    """What `listening_options` give a command beside --bitrate, by the names of its parameters."""

    interface: str | None
    data_bitrate: int | None
    fd: bool
    option: tuple[tuple[str, Any], ...]
    reconnect: bool
    hardware_stamps: bool
    record: tuple[str, ...]
    rotate: Limit | None
    keep: int | None
    force: bool


class Channel(NamedTuple):
    """A channel as the user has named it."""

    name: str
    """As the interface knows it."""
    bus: str
    """As listings call it."""
    filters: str
    """candump's filters that stood behind its name; "" if there were none."""

    @property
    def mask(self) -> str:
        """What the core is told of the filters."""
        return f"{self.bus},{self.filters}"


def listening_options(words: Words) -> list[click.Parameter]:
    """Give the options of a command that listens; it takes them as `**given`."""

    def option(names: list[str], read: Callable[[str], object], form: str, metavar: str, **more: Any) -> click.Option:
        key = names[-1].lstrip("-").replace("-", "_")
        return click.Option(
            names, type=Spelled(read, form, words), metavar=metavar, help=words(f"listen.{key}"), **more
        )

    def flag(name: str) -> click.Option:
        return click.Option([name], is_flag=True, help=words(f"listen.{name.lstrip('-').replace('-', '_')}"))

    return [
        click.Option(["-i", "--interface"], metavar="NAME", help=words("listen.interface")),
        bitrate_option(words, "listen.bitrate"),
        option(["--data-bitrate"], data_rate, "data_rate", "BPS"),
        flag("--fd"),
        option(["--option"], buses.option, "option", "KEY=VALUE", multiple=True),
        flag("--reconnect"),
        flag("--hardware-stamps"),
        click.Option(["--record"], type=ANY_PATH, metavar="FILE", multiple=True, help=words("listen.record")),
        option(["--rotate"], limit, "rotate", "SIZE|TIME"),
        option(["--keep"], positive, "positive", "N"),
        click.Option(["--force"], is_flag=True, help=words("opt.force")),
    ]


def positive(text: str) -> int | None:
    """Read a number above 0."""
    return int(text) or None if text.isdecimal() and len(text) < 19 else None


def seconds(text: str) -> float | None:
    """Read a time above 0: 10, 10s, 500ms, 5m, 1h."""
    number = text.rstrip("abcdefghijklmnopqrstuvwxyz")
    unit = _UNITS.get(text[len(number) :])
    try:
        found = float(number) * unit if unit is not None and number[:1].isdecimal() else 0.0
    except ValueError:
        return None
    return found if 0 < found <= _LONGEST_S else None


def data_rate(text: str) -> int | None:
    """Read a bit rate of CAN FD data, up to 20M."""
    amount = text.rstrip("kKM")
    factor = {"": 1, "k": 1000, "K": 1000, "M": 1_000_000}.get(text[len(amount) :])
    if factor is None or not amount.isdecimal() or len(amount) > 9:
        return network.bit_rate(text)
    rate = int(amount) * factor
    return rate if 1000 <= rate <= 20_000_000 else None


def channels_of(texts: Sequence[str], words: Words) -> list[Channel]:
    """Take the names of channels apart; none, or one named twice, is a usage error."""
    context = click.get_current_context()
    channels: list[Channel] = []
    for text in texts:
        name, _, filters = text.partition(",")
        if not name:
            raise click.UsageError(words("listen.no_name", value=text or '""'), context)
        bus = buses.bus_name(name)
        if any(other.name == name or other.bus == bus for other in channels):
            raise click.UsageError(words("listen.twice", name=name), context)
        channels.append(Channel(name, bus, filters))
    if not channels:
        raise click.UsageError(words("listen.none"), context)
    if len(channels) > MOST_BUSES:
        raise click.UsageError(words("listen.many", most=MOST_BUSES), context)
    return channels


def refuse_others(channels: Sequence[Channel], given: ListeningOptions, words: Words) -> None:
    """Make sure that what is given as an interface of the system may be one: a file, or a filter, is a usage error."""
    if given.get("interface") not in (None, OWN):
        return
    there = [name for names in netdevices.interfaces() for name in names]
    for name, _, _ in channels:
        if name == STDIN:
            raise click.UsageError(words("listen.stdin"), click.get_current_context())
        if name not in there and Path(name).is_file():
            raise click.UsageError(words("listen.a_file", name=name), click.get_current_context())
        if _FILTER.fullmatch(name):
            raise click.UsageError(words("listen.no_name", value=name), click.get_current_context())


def interface_of(given: ListeningOptions, words: Words) -> str:
    """Give the interface that is listened to; one that does not exist is a usage error."""
    context = click.get_current_context()
    asked = given.get("interface")
    if asked is None and sys.platform.startswith("linux"):
        asked = OWN
    if asked is None:
        raise click.UsageError(words("listen.needs_interface", names=_listed(words)), context)
    if asked == OWN and not sys.platform.startswith("linux"):
        raise click.UsageError(words("listen.only_linux", names=_listed(words)), context)
    if asked != OWN and not buses.known(asked):
        near = buses.near(asked)
        key = "listen.unknown_near" if near else "listen.unknown"
        facts = {"name": asked or '""', "near": words("usage.or").join(near), "names": _listed(words)}
        raise click.UsageError(words(key, **facts), context)
    wrong = [
        ("--hardware-stamps", given.get("hardware_stamps") and asked != OWN, "listen.only_own"),
        ("--data-bitrate", given.get("data_bitrate") and asked == OWN, "listen.own_rate"),
        ("--option", given.get("option") and asked == OWN, "listen.not_own"),
        ("--data-bitrate", given.get("data_bitrate") and not given.get("fd"), "listen.needs_fd"),
    ]
    for option, is_wrong, key in wrong:
        if is_wrong:
            raise click.UsageError(words(key, option=option), context)
    return asked


def _listed(words: Words) -> str:
    own = {OWN} if not sys.platform.startswith("linux") else set()
    return words("listen.comma").join(name for name in buses.names() if name not in own)


def open_buses(
    channels: Sequence[Channel],
    given: ListeningOptions,
    words: Words,
    *,
    bitrate: int | None,
    tell: Callable[[str], None],
) -> list[Bus]:
    """Open what is listened to; SourceError for what cannot be. tell: gets what is to be known before."""
    interface = interface_of(given, words)
    patient = given.get("reconnect", False)
    if interface == OWN:
        from canalyze.sources.socketcan import SocketCan

        names = [channel.name for channel in channels]
        return [SocketCan(names, first=0, hardware_stamps=given.get("hardware_stamps", False), patient=patient)]
    opened: list[buses.PythonCan] = []
    try:
        for place, channel in enumerate(channels):
            opened.append(
                buses.PythonCan(
                    interface,
                    channel.name,
                    first=place,
                    bitrate=bitrate,
                    data_bitrate=given.get("data_bitrate"),
                    fd=given.get("fd", False),
                    options=dict(given.get("option", ())),
                    name=channel.bus,
                    patient=patient,
                )
            )
    except CanalyzeError:
        for one in opened:
            one.close()
        raise
    if opened and opened[0].acknowledges:
        tell(f"canalyze: {words('bus.acknowledges', interface=interface)}")
    return list(opened)


def check_recordings(given: ListeningOptions, words: Words) -> None:
    """Make sure that what is to be recorded can be told from the names and options; else it is a usage error."""
    context = click.get_current_context()
    names = given.get("record", ())
    for name in names:
        if form_of(name) is None:
            raise click.UsageError(words("record.suffix", name=name, allowed=" ".join(recordable())), context)
        if names.count(name) > 1:
            raise click.UsageError(words("record.twice", name=name), context)
    for option, value, needed in (
        ("--rotate", given.get("rotate"), "--record" if not names else ""),
        ("--keep", given.get("keep"), "--rotate" if not given.get("rotate") else ""),
        ("--force", given.get("force") or None, "--record" if not names else ""),
    ):
        if value is not None and needed:
            raise click.UsageError(words("record.needs", option=option, other=needed), context)


def open_recordings_of(given: ListeningOptions, words: Words) -> Recordings | None:
    """Open what is recorded, after `check_recordings`; None if nothing is. OutputError for what cannot be written."""
    names = given.get("record", ())
    if not names:
        return None
    return open_recordings(
        names, words, limit=given.get("rotate"), keep=given.get("keep"), force=given.get("force", False)
    )
