"""The options of commands that listen to a bus: what is listened to, and what of it is recorded.

From names and options to open sources and open files, and to their end; usage errors in the words of the run. Must not:
read a source, or decide where a line for people goes.
"""

import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Final, NamedTuple, TypedDict

from canalyze.configuration import network
from canalyze.configuration.options import ANY_PATH, BITRATE, FORCE, CaptureOptions, configured, option, positive, usage
from canalyze.running.recording import Limit, Recordings, form_of, limit, open_recordings, recordable
from canalyze.sources import STDIN, netdevices
from canalyze.sources.bridge import bus_name, buses
from canalyze.sources.bridge.buses import OWN
from canalyze.sources.live import MOST_BUSES, Bus, Live
from canalyze.words import Words

_UNITS: Final = {"": 1.0, "ms": 0.001, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0, "d": 86400.0}
_FILTER: Final = re.compile("[0-9A-Fa-f]+[:~][0-9A-Fa-f]+|#[0-9A-Fa-f]+")
"""One of candump's filters: no interface can be called so."""
_LONGEST_S: Final = 366 * 86400.0


class OwnOptions(TypedDict, total=False):
    """The parameters that only `LISTENING` has, by their names."""

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


class ListeningOptions(CaptureOptions, OwnOptions, total=False):
    """The parameters of a command that listens: `LISTENING`, --bitrate among them, and those about the network."""


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
        """The filters as the core has them."""
        return f"{self.bus},{self.filters}"


class Listening(NamedTuple):
    """A bus that is listened to, and its recordings; there may be none."""

    live: Live
    recordings: Recordings

    def complete(self, words: Words) -> list[str]:
        """Ends the receiving, then the files; returns what is still to be reported of them, a line each."""
        self.live.close()
        self.recordings.close()
        return [*(remark.in_words(words) for remark in self.recordings.remarks()), *self.recordings.losses()]


def set_rates(names: Sequence[str], given: ListeningOptions) -> list[int | None]:
    """Returns the bit rate of each channel, in bit/s: that of --bitrate, else of the system; None if unknown."""
    if rate := given.get("bitrate"):
        return [rate] * len(names)
    own = given.get("interface") in (None, OWN)
    return [netdevices.bit_rate(name) if own else None for name in names]


def seconds(text: str) -> float | None:
    """Reads a time above 0: 10, 10s, 500ms, 5m, 1h."""
    number = text.rstrip("abcdefghijklmnopqrstuvwxyz")
    unit = _UNITS.get(text[len(number) :])
    try:
        found = float(number) * unit if unit is not None and number[:1].isdecimal() else 0.0
    except ValueError:
        return None
    return found if 0 < found <= _LONGEST_S else None


def data_rate(text: str) -> int | None:
    """Reads a bit rate of CAN FD data, up to 20M."""
    amount = text.rstrip("kKM")
    factor = {"": 1, "k": 1000, "K": 1000, "M": 1_000_000}.get(text[len(amount) :])
    if factor is None or not amount.isdecimal() or len(amount) > 9:
        return network.bit_rate(text)
    rate = int(amount) * factor
    return rate if 1000 <= rate <= 20_000_000 else None


LISTENING: Final = (
    option("-i --interface", "NAME", key="listen.interface", topic="bus"),
    BITRATE._replace(key="listen.bitrate"),
    option("--data-bitrate", "BPS", data_rate, "data_rate", key="listen.data_bitrate", topic="bus"),
    option("--fd", key="listen.fd", topic="bus"),
    option("--option", "KEY=VALUE", buses.option, "option", key="listen.option", topic="bus", multiple=True),
    option("--reconnect", key="listen.reconnect", topic="bus"),
    option("--hardware-stamps", key="listen.hardware_stamps", topic="bus"),
    option("--record", "FILE", key="listen.record", topic="recording", usual=0, type=ANY_PATH, multiple=True),
    option("--rotate", "SIZE|TIME", limit, "rotate", key="listen.rotate", topic="recording"),
    option("--keep", "N", positive, "positive", key="listen.keep", topic="recording"),
    FORCE,
)
"""Options of a command that listens: `ListeningOptions`."""


def channels_of(texts: Sequence[str], given: ListeningOptions, words: Words, *, writes: bool = False) -> list[Channel]:
    """Parses the names of channels; an error in them or in the options of listening is a usage error.

    A channel named twice, and none, are wrong too. Nothing is opened. writes: the command writes something else that
    --force may be for.
    """
    channels = _channels(texts, words)
    _refuse_others(channels, given, words)
    _interface(given, words)
    _check_recordings(given, words, writes=writes)
    return channels


@contextmanager
def listening(
    channels: Sequence[Channel],
    given: ListeningOptions,
    words: Words,
    tell: Callable[[str], None],
    *,
    duration_s: float | None = None,
) -> Iterator[Listening]:
    """Opens what is listened to, then the files; all of it is closed at the end, also after an error.

    tell: gets what is to be known before, in words. SourceError and OutputError for what cannot be opened.
    """
    with ExitStack() as stack:
        opened = _open_buses(channels, given, words, tell)
        for bus in opened:
            stack.callback(bus.close)
        recordings = open_recordings(
            given.get("record", ()),
            words,
            limit=given.get("rotate"),
            keep=given.get("keep"),
            force=given.get("force", False),
        )
        stack.callback(recordings.close)
        live = Live(opened, recording=recordings, reconnect=given.get("reconnect", False), duration_s=duration_s)
        stack.callback(live.close)
        yield Listening(live, recordings)


def _channels(texts: Sequence[str], words: Words) -> list[Channel]:
    channels: list[Channel] = []
    for text in texts:
        name, _, filters = text.partition(",")
        if not name:
            raise usage(words, "listen.no_name", value=text or '""')
        bus = bus_name(name)
        if any(other.name == name or other.bus == bus for other in channels):
            raise usage(words, "listen.twice", name=name)
        channels.append(Channel(name, bus, filters))
    if not channels:
        raise usage(words, "listen.none")
    if len(channels) > MOST_BUSES:
        raise usage(words, "listen.many", most=MOST_BUSES)
    return channels


def _refuse_others(channels: Sequence[Channel], given: ListeningOptions, words: Words) -> None:
    """Raises a usage error for a file or a filter that is given as an interface of the system."""
    if given.get("interface") not in (None, OWN):
        return
    there = [name for names in netdevices.interfaces() for name in names]
    for name, _, _ in channels:
        if name == STDIN:
            raise usage(words, "listen.stdin")
        if name not in there and Path(name).is_file():
            raise usage(words, "listen.a_file", name=name)
        if _FILTER.fullmatch(name):
            raise usage(words, "listen.no_name", value=name)


def _interface(given: ListeningOptions, words: Words) -> str:
    """Returns the interface that is listened to; one that does not exist is a usage error."""
    asked = given.get("interface")
    if asked is None and sys.platform.startswith("linux"):
        asked = OWN
    if asked is None:
        raise usage(words, "listen.needs_interface", names=_listed(words))
    if asked == OWN and not sys.platform.startswith("linux"):
        raise usage(words, "listen.only_linux", names=_listed(words))
    if asked != OWN and not buses.known(asked):
        near = buses.near(asked)
        key = "listen.unknown_near" if near else "listen.unknown"
        raise usage(words, key, name=asked or '""', near=words("usage.or").join(near), names=_listed(words))
    wrong = [
        ("--hardware-stamps", given.get("hardware_stamps") and asked != OWN, "listen.only_own"),
        ("--data-bitrate", given.get("data_bitrate") and asked == OWN, "listen.own_rate"),
        ("--option", given.get("option") and asked == OWN, "listen.not_own"),
        ("--data-bitrate", given.get("data_bitrate") and not given.get("fd"), "listen.needs_fd"),
    ]
    for name, is_wrong, key in wrong:
        if is_wrong:
            raise usage(words, key, option=name)
    return asked


def _listed(words: Words) -> str:
    own = {OWN} if not sys.platform.startswith("linux") else set()
    return words("listen.comma").join(name for name in buses.names() if name not in own)


def _open_buses(
    channels: Sequence[Channel], given: ListeningOptions, words: Words, tell: Callable[[str], None]
) -> list[Bus]:
    interface = _interface(given, words)
    opened = buses.opened(
        interface,
        {channel.name: channel.bus for channel in channels},
        bitrate=given.get("bitrate") or configured().known.bitrate,
        data_bitrate=given.get("data_bitrate"),
        fd=given.get("fd", False),
        options=dict(given.get("option", ())),
        hardware_stamps=given.get("hardware_stamps", False),
        patient=given.get("reconnect", False),
    )
    if isinstance(opened[0], buses.PythonCan) and opened[0].acknowledges:
        tell(f"canalyze: {words('bus.acknowledges', interface=interface)}")
    return opened


def _check_recordings(given: ListeningOptions, words: Words, *, writes: bool) -> None:
    """Raises a usage error for names and options of recordings that do not fit."""
    names = given.get("record", ())
    for name in names:
        if form_of(name) is None:
            raise usage(words, "record.suffix", name=name, allowed=" ".join(recordable()))
        if sum(os.path.realpath(other) == os.path.realpath(name) for other in names) > 1:  # also by another way
            raise usage(words, "record.twice", name=name)
    for name, value, needed in (
        ("--rotate", given.get("rotate"), "--record" if not names else ""),
        ("--keep", given.get("keep"), "--rotate" if not given.get("rotate") else ""),
        ("--force", given.get("force") or None, "--record" if not names and not writes else ""),
    ):
        if value is not None and needed:
            raise usage(words, "record.needs", option=name, other=needed)
