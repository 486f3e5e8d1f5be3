"""A channel of any python-can interface as blocks of the live stream, listen-only where the adapter can.

Nothing is ever sent. Frames become the records of `packed`; stamps that are no dates are moved by one offset to the
clock of this host. The tables of interfaces are checked against the installed python-can by a test. Must not: read
files, or wait for the reader.
"""

import contextlib
import logging
import time
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from canalyze.errors import CanalyzeError, SourceError
from canalyze.sources.bridge import Heard, Packer, Unfit, bus_name, library
from canalyze.sources.live import Bus, LinkLost, dropped_block, name_block, records_block, until_block
from canalyze.values import DATES_NS

if TYPE_CHECKING:
    from can import BusABC, Message


class Adapter(NamedTuple):
    """The facts about an interface of python-can."""

    quiet: Mapping[str, object] = {}
    """The settings that keep it from acknowledging frames; empty if it has no such switch."""
    pip: str = ""
    """The extra of python-can that it needs."""
    driver: str = ""
    """The vendor's library that it needs, which pip does not install."""
    rated: bool = False
    """True if it acknowledges, and uses a default bit rate where none is given; a wrong one disturbs the bus."""
    real: bool = True
    """False for an interface without an adapter: there is nothing to acknowledge."""
    errors: bool = False
    """True if its error frames have SocketCAN's layout. The content of others is ignored."""
    data_rate: str = "data_bitrate"
    """The name of its parameter for the bit rate of CAN FD data."""
    clock_hz: int = 0
    """Its clock frequency, if it accepts CAN FD rates only as bit timing."""


ADAPTERS: Final[Mapping[str, Adapter]] = {
    "canalystii": Adapter(pip="canalystii"),
    "cantact": Adapter({"monitor": True}, pip="cantact"),
    "etas": Adapter(driver="ETAS BOA (Windows)", rated=True),
    "gs_usb": Adapter(pip="gs-usb", rated=True, errors=True),
    "iscan": Adapter(driver="Thorsis isCAN (Windows)", rated=True),
    "ixxat": Adapter(driver="HMS Ixxat VCI (Windows)", rated=True),
    "kvaser": Adapter({"driver_mode": False}, driver="Kvaser CANlib"),
    "neousys": Adapter(driver="Neousys WDT_DIO", rated=True),
    "neovi": Adapter(pip="neovi", driver="Intrepid ICS neoVI"),
    "nican": Adapter(driver="NI-CAN (Windows)"),
    "nixnet": Adapter({"listen_only": True}, pip="nixnet", driver="NI-XNET (Windows)", data_rate="fd_bitrate"),
    "pcan": Adapter({"state": "PASSIVE"}, driver="PEAK PCAN-Basic", clock_hz=80_000_000),
    "robotell": Adapter(pip="serial"),
    "seeedstudio": Adapter({"operation_mode": "silent"}, pip="seeedstudio"),
    "serial": Adapter(pip="serial"),
    "slcan": Adapter({"listen_only": True}, pip="serial", clock_hz=80_000_000),
    "socketcan": Adapter(errors=True),
    "socketcand": Adapter(errors=True),
    "systec": Adapter({"state": "PASSIVE"}, driver="SYS TEC USB-CANmodul (Windows)"),
    "udp_multicast": Adapter(pip="multicast", real=False, errors=True),
    "usb2can": Adapter(driver="8devices usb2can.dll (Windows)", rated=True),
    "vector": Adapter({"listen_only": True}, driver="Vector XL Driver Library (Windows)"),
    "virtual": Adapter(real=False, errors=True),
}
"""The interfaces of python-can; plugins have no row."""

OWN: Final = "socketcan"
"""The interface that is not python-can's here."""
_MOST: Final = 1000
"""Maximum number of frames in a block."""
_LONGEST_S: Final = 0.02
"""Maximum time for which frames are gathered for one block."""
_MARGIN_S: Final = 0.02
"""Maximum delay of a frame beyond the largest so far."""
_SILENT_S: Final = 0.1
"""The same before the first frame."""
_DRIFT: Final = 1e-4
"""Maximum drift of an adapter's clock against the host's while no frame arrives."""
_WINDOW_S: Final = 10.0
"""Minimum time for which the delay of a frame is remembered."""
_STEP_BACK_S: Final = 1.0
"""A step back of the stamps by this much means that the adapter has restarted."""
_TRIES: Final = 3
"""Number of consecutive errors after which an adapter is lost; fewer cost a frame each."""
_RATES: Final = frozenset({"bitrate", "timing", "f_clock"})
"""Settings that contain the bit rate."""


def names() -> list[str]:
    """Returns the names of all interfaces: SocketCAN, and those of python-can with its plugins."""
    library()
    from can.interfaces import VALID_INTERFACES

    return sorted({OWN, *VALID_INTERFACES})


def known(interface: str) -> bool:
    """Returns true if there is an interface of that name."""
    return interface in names()


def near(interface: str) -> list[str]:
    """Returns interface names that are similar to an unknown one."""
    return get_close_matches(interface.lower().replace("-", "_"), names(), cutoff=0.6)


def option(text: str) -> tuple[str, Any] | None:
    """Parses `key=value`, with the value as python-can reads its configuration: a number, true, false, or text."""
    library()
    from can.util import cast_from_string

    key, equals, value = text.partition("=")
    key = key.strip().replace("-", "_")
    if not equals or not key.isidentifier() or key in ("interface", "channel"):
        return None
    return key, cast_from_string(value)


class PythonCan:
    """One channel of an adapter, as a `live.Bus`."""

    def __init__(
        self,
        interface: str,
        channel: str,
        *,
        first: int,
        bitrate: int | None = None,
        data_bitrate: int | None = None,
        fd: bool = False,
        options: Mapping[str, Any] | None = None,
        name: str | None = None,
        patient: bool = False,
    ) -> None:
        """Opens the channel.

        first: the index of its bus in the stream. name: the name of the bus. bitrate, data_bitrate: in bit/s. options:
        further parameters of python-can. patient: if it cannot be opened now, the first `receive` raises LinkLost, and
        `reopen` tries again. Raises SourceError if a package is missing and, unless patient, if it cannot be opened.
        """
        self.interface = interface
        self.names: Sequence[str] = (name or bus_name(channel),)
        self._channel = channel
        self.first = first
        self._adapter = ADAPTERS.get(interface, Adapter())
        self._settings = _settings(interface, self._adapter, bitrate, data_bitrate, fd=fd) | dict(options or {})
        if self._adapter.rated and self._settings.keys().isdisjoint(_RATES):
            raise SourceError("bus.needs_rate", name=channel, interface=interface)
        self._bus: BusABC | None = None
        self._lost: SourceError | None = None
        logging.getLogger("can").addHandler(_HEARD)
        self._named = False
        self._first_message: Message | None = None
        """The first message after it was opened again."""
        self._open(patient=patient)

    @property
    def acknowledges(self) -> bool:
        """True if the adapter acknowledges frames as a node does, because it cannot be switched to listen only."""
        switch = self._adapter.quiet or {"listen_only": True}
        return self._adapter.real and switch.keys().isdisjoint(self._settings)

    def receive(self, timeout_s: float) -> bytes:
        """Waits up to `timeout_s` for frames and returns them as blocks, with the time up to which all have come.

        Raises LinkLost if the adapter is gone.
        """
        if self._lost is not None:
            lost, self._lost = self._lost, None
            raise LinkLost(self.names[0], lost)
        blocks = [] if self._named else [name_block(self.first, self.names[0])]
        self._named = True
        message, dropped = self._next(timeout_s)
        if message is not None:
            records: list[bytes] = []
            end = time.monotonic() + _LONGEST_S
            while message is not None:
                try:
                    records.append(self._packer.frame(self._clock.settled(message), bare=not self._adapter.errors))
                except Unfit:
                    dropped += 1
                if len(records) >= _MOST or time.monotonic() > end:
                    break
                try:
                    message, more = self._next(0)
                except LinkLost as lost:  # earlier frames are returned first; the next call raises it
                    self._lost = lost.error
                    break
                dropped += more
            if records:
                blocks.append(records_block(self.first, b"".join(records), len(records)))
        if dropped:
            blocks.append(dropped_block(self.first, dropped))
        blocks.append(until_block(self._clock.until()))
        return b"".join(blocks)

    def remarks(self) -> list[CanalyzeError]:
        """Returns the log lines of python-can since the last call, for standard error."""
        lines = _HEARD.take()
        return [SourceError("bridge.said", name=self.names[0], problem=line) for line in lines]

    def reopen(self) -> bool:
        """Tries to open the channel again after LinkLost; returns true on success."""
        self.close()
        with contextlib.suppress(SourceError, LinkLost):
            self._open(patient=False)
            self._first_message, _ = self._next(0)  # an adapter that is gone may be opened all the same
            return True
        self.close()
        return False

    def close(self) -> None:
        """Closes the channel; closing twice is harmless."""
        bus, self._bus = self._bus, None
        if bus is not None:
            with contextlib.suppress(Exception):  # it may be gone
                bus.shutdown()

    def _open(self, *, patient: bool) -> None:
        self._clock = _Clock()
        self._packer = Packer(6, directed=True, bus=lambda _: self.names[0])
        can = library()
        try:
            self._bus = can.Bus(channel=self._channel, interface=self.interface, **self._settings)
        except Exception as error:  # a driver may raise anything
            self._lost = self._refusal(error)
        _HEARD.take()  # of what cannot be opened the error says enough
        if self._lost is not None and (not patient or self._lost.key != "bus.refused"):
            lost, self._lost = self._lost, None
            raise lost

    def _refusal(self, error: Exception) -> SourceError:
        """Returns an error that names python-can's refusal and its remedy in one line."""
        from can import CanInterfaceNotImplementedError

        facts = {"name": self._channel, "interface": self.interface, "problem": _said(error)}
        pip, driver = self._adapter.pip, self._adapter.driver
        # Without its library a backend fails where it first calls it.
        absent = isinstance(error, CanInterfaceNotImplementedError | ImportError | NameError)
        absent = absent or (self.interface == "pcan" and isinstance(error, OSError) and "not found" in str(error))
        if absent and driver and not (pip and "No module" in facts["problem"]):
            return SourceError("bus.no_driver", driver=driver, **facts)
        if absent and pip:
            return SourceError("bus.no_package", line=f"pip install 'python-can[{pip}]'", **facts)
        if absent:
            return SourceError("bus.no_support", **facts)
        if isinstance(error, TypeError | ValueError):
            return SourceError("bus.settings", **facts)
        return SourceError("bus.refused", **facts)

    def _gone(self, problem: str) -> SourceError:
        return SourceError("bus.gone", name=self.names[0], interface=self.interface, problem=problem)

    def _next(self, timeout_s: float) -> tuple["Message | None", int]:
        """Returns the next frame, or None, and the number of frames lost to errors before it."""
        if self._first_message is not None:
            message, self._first_message = self._first_message, None
            return message, 0
        bus = self._bus
        if bus is None:
            raise LinkLost(self.names[0], self._gone("closed"))
        lost = 0
        while True:
            try:
                return bus.recv(timeout_s), lost
            except Exception as error:  # CanOperationError, OSError, and any other exception of a driver
                lost += 1
                if lost >= _TRIES:
                    raise LinkLost(self.names[0], self._gone(_said(error))) from error


def opened(
    interface: str,
    channels: Mapping[str, str | None],
    *,
    hardware_stamps: bool = False,
    patient: bool = False,
    **settings: Any,
) -> list[Bus]:
    """Opens channels of SocketCAN or of an interface of python-can; if one cannot be opened, none stays open.

    channels: the names of their buses, None for the usual ones, by those of the channels. hardware_stamps: of SocketCAN
    alone. settings: those of `PythonCan`.
    """
    if interface == OWN:
        from canalyze.sources.socketcan import SocketCan

        return [SocketCan(list(channels), hardware_stamps=hardware_stamps, patient=patient)]
    buses: list[Bus] = []
    with contextlib.ExitStack() as stack:
        for place, (channel, name) in enumerate(channels.items()):
            one = PythonCan(interface, channel, first=place, name=name, patient=patient, **settings)
            stack.callback(one.close)
            buses.append(one)
        stack.pop_all()
    return buses


def _settings(
    interface: str, adapter: Adapter, bitrate: int | None, data_bitrate: int | None, *, fd: bool
) -> dict[str, Any]:
    """Returns the parameters of python-can's bus; the user's own options override them."""
    given: dict[str, Any] = dict(adapter.quiet or _own_switch(interface))
    if bitrate is not None:
        given["bitrate"] = bitrate
    if fd:
        given["fd"] = True
        if adapter.clock_hz and bitrate and data_bitrate:
            given["timing"] = _timing(adapter.clock_hz, bitrate, data_bitrate)
        elif data_bitrate is not None:
            given[adapter.data_rate] = data_bitrate
    return given


def _own_switch(interface: str) -> Mapping[str, object]:
    """Returns the settings that make a plugin or a newer interface listen only, if it has a `listen_only` parameter."""
    import importlib
    import inspect

    from can.interfaces import BACKENDS

    with contextlib.suppress(Exception):  # a missing package is reported when it is opened
        module, name = BACKENDS[interface]
        if "listen_only" in inspect.signature(getattr(importlib.import_module(module), name).__init__).parameters:
            return {"listen_only": True}
    return {}


def _timing(clock: int, bitrate: int, data_bitrate: int) -> Any:
    can = library()
    try:
        return can.BitTimingFd.from_sample_point(
            f_clock=clock,
            nom_bitrate=bitrate,
            nom_sample_point=80.0,
            data_bitrate=data_bitrate,
            data_sample_point=80.0,
        )
    except ValueError as error:
        raise SourceError("bus.rates", bitrate=bitrate, data_bitrate=data_bitrate, problem=_said(error)) from error


def _said(error: BaseException) -> str:
    """Returns an exception of the library in one line."""
    text = " ".join(str(error).split())[:200].rstrip(".")
    return text or type(error).__name__


class _Clock:
    """The stamps of one adapter against the clock of this host."""

    def __init__(self) -> None:
        self._offset: float | None = None
        self._stamp = 0.0
        self._last = time.time()
        """The time at which the last frame was received."""
        self._late: float | None = None
        """Maximum delay of the frames in this window and the one before."""
        self._later: float | None = None
        self._turn = 0.0

    def settled(self, message: "Message") -> "Message":
        """Returns the message with its stamp moved to the host's clock, or stamped on receipt if it has none."""
        now = self._last = time.time()
        stamp = message.timestamp
        if not stamp > 0:  # also NaN
            message.timestamp = stamp = now
        elif stamp * 1e9 < DATES_NS:
            if self._offset is None or stamp < self._stamp - _STEP_BACK_S:
                self._offset = now - stamp
            self._stamp = stamp
            message.timestamp = stamp = stamp + self._offset
        late = now - stamp
        if self._later is None or late > self._later:
            self._later = late
        if now > self._turn or self._late is None:
            self._turn = now + _WINDOW_S
            self._late, self._later = max(self._later, self._late or self._later), late
        return message

    def until(self) -> int:
        """Returns the time in ns, on the clock of the stamps, before which no further frame will arrive."""
        now = time.time()
        if self._late is None or self._later is None:
            return round((now - _SILENT_S) * 1e9)
        late = max(self._late, self._later) + _MARGIN_S + max(0.0, now - self._last) * _DRIFT
        return round((now - late) * 1e9)


_HEARD: Final = Heard()
"""Shared by all channels, because the library has one log."""
