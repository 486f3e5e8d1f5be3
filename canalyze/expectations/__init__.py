"""The expectations of a capture: a TOML file beside it, checked key by key, into what the core judges by.

Every mistake is a ConfigError with the file, the line and what is allowed. Must not: judge a capture, or know what an
expectation means beyond its own table; that is the core's (`expectation/`).
"""

import json
import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from canalyze.configuration import bounded, network
from canalyze.configuration.toml import File, Key, as_text, as_toml, bit_rate, choice, node, text
from canalyze.errors import ConfigError
from canalyze.sources.compression import COMPRESSIONS

if TYPE_CHECKING:
    from canalyze._core import Expectations

SUFFIX: Final = ".expect.toml"
STATES: Final = ("boot-up", "stopped", "operational", "pre-operational")
DRIVE_STATES: Final = (
    *("not-ready-to-switch-on", "switch-on-disabled", "ready-to-switch-on", "switched-on", "operation-enabled"),
    *("quick-stop-active", "fault-reaction-active", "fault"),
)

_CAPTURES: Final = frozenset(
    {
        *(".asc", ".blf", ".candump", ".cap", ".csv", ".db", ".log", ".mcap", ".mf4", ".pcap", ".pcapng"),
        *(".sqlite", ".sqlite3", ".trc", ".txt"),
    }
)
"""How names of captures end."""
_NS: Final = 1_000_000_000
_OFTEN: Final = 1_000_000
"""The greatest number of times."""
_LONGEST_S: Final = 1_000_000_000
_TOLERANCE_PERCENT: Final = 10
"""Of a period, where the file gives no tolerance."""
_CODE: Final = re.compile(r"(?:0x)?([0-9a-f]{4}|[0-9a-f]{3}x|[0-9a-f]{2}xx|[0-9a-f]xxx)h?", re.IGNORECASE)
_KIND: Final = re.compile(r"[a-z?*-]{1,64}")
"""A kind of incident, or a glob of them."""
_RANGE: Final = re.compile(r"([0-9]{1,7})\s*-\s*([0-9]{1,7})?")
_ABORT: Final = re.compile(r"(?:0x)?([0-9a-f]{8})h?", re.IGNORECASE)


def beside(name: str) -> Path | None:
    """Give the file that lies beside a capture, boot.expect.toml of boot.log.gz; None where there is none."""
    path = Path(name)
    if path.suffix.lower() in {one.suffix for one in COMPRESSIONS.values()}:
        path = path.with_suffix("")
    if path.suffix.lower() in _CAPTURES:
        path = path.with_suffix("")
    if name == "-" or not path.name:
        return None
    file = path.with_name(path.name + SUFFIX)
    return file if file.is_file() else None


def read(path: Path) -> "Expectations":
    """Read a file for the core; ConfigError for what cannot be."""
    from canalyze._core import Expectations

    return Expectations(json.dumps(normalize(path), ensure_ascii=False))


def normalize(path: Path) -> dict[str, Any]:
    """Read a file into what the core takes: every key, units in ns, numbers for what is written in hexadecimal."""
    try:
        content = bounded.content(path)
    except OSError as error:
        raise ConfigError("expect.unreadable", file=path, error=error) from error
    file, values = File.parsed(path, content)
    file.allow(values, (), tables=(), lists=TABLES)
    normal: dict[str, Any] = {"file": str(path)}
    for name, table in TABLES.items():
        entries = file.entries(name, values, {**table.keys, "bus": Key(text, "text")})
        normal[name] = [
            {"line": file.line(name, place) or 1, "bus": found.get("bus")}
            | table.normal(Entry(file, name, place, found, values[name][place]))
            for place, found in enumerate(entries)
        ]
    return normal


class Entry(NamedTuple):
    """One table of the file, its keys read."""

    file: File
    table: str
    place: int
    """Which of its name, from 0."""
    found: Mapping[str, Any]
    given: Mapping[str, Any]
    """As the file has it."""

    def __call__(self, key: str, otherwise: Any = None) -> Any:
        """Give what was read of a key."""
        return self.found.get(key, otherwise)

    def refuse(self, key: str, why: str, other: str = "") -> ConfigError:
        """Give the error about a key that stands in the file, in the words `expect.WHY`."""
        file = self.file.at(self.table, self.place, key)
        shown, value = f"{self.table}.{key}", as_toml(self.given.get(key))
        return ConfigError(f"expect.{why}", file=file, key=shown, value=value, other=other)

    def only(self, *keys: str, needed: bool = False) -> str | None:
        """Give the one of these keys that is there; there may not be two."""
        there = [key for key in self.found if key in keys]
        if len(there) > 1:
            raise self.refuse(there[1], "exclusive", there[0])
        if needed and not there:
            file = self.file.at(self.table, self.place)
            raise ConfigError("expect.lacks_one", file=file, table=self.table, keys=", ".join(keys))
        return there[0] if there else None

    def apart(self, key: str, *others: str) -> None:
        """Refuse these keys where `key` stands."""
        for other in others:
            if key in self.found:
                self.only(key, other)

    def goes(self, key: str, allowed: bool, other: str) -> None:
        """Refuse a key that does not go without another, which is shown as it would be written."""
        if key in self.found and not allowed:
            raise self.refuse(key, "goes_with", other)


def _object(value: str) -> tuple[int, int] | None:
    index, sub = network.address(value) or (None, None)
    return None if index is None or sub is None else (index, sub)


def _abort_code(value: str) -> int | None:
    match = _ABORT.fullmatch(value)
    return int(match[1], 16) if match else None


def _emcy_code(value: str) -> list[int] | None:
    """Read the value and the mask of an error code: 81xx is any of 8100h to 81FFh."""
    match = _CODE.fullmatch(value)
    if match is None:
        return None
    digits = match[1].lower()
    return [int(digits.replace("x", "0"), 16), int(re.sub("[0-9a-f]", "f", digits).replace("x", "0"), 16)]


def _often(value: object) -> list[int | None] | None:
    """Read how often: a number, or a range in quotes of which the end may be open."""
    if type(value) is int:
        return [value, value] if 0 <= value <= _OFTEN else None
    match = _RANGE.fullmatch(value.strip()) if isinstance(value, str) else None
    if match is None:
        return None
    least, most = int(match[1]), None if match[2] is None else int(match[2])
    return [least, most] if least <= (_OFTEN if most is None else most) <= _OFTEN else None


def _number(value: object) -> int | float | None:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    try:
        return value if math.isfinite(value) else None
    except OverflowError:  # no double is as large
        return None


def _value(value: object) -> dict[str, object] | None:
    """Read the value of an object, which can be any that TOML has a plain word for."""
    if isinstance(value, bool):
        return {"bool": value}
    if isinstance(value, str):
        return {"text": value}
    number = _number(value)
    if number is None or (isinstance(number, int) and not -(1 << 63) <= number < 1 << 64):
        return None
    return {"number": number}


def _bytes(value: str) -> dict[str, object] | None:
    try:
        return {"data": bytes.fromhex(value).hex().upper()}
    except ValueError:
        return None


def _above_zero(most: float, unit_ns: int) -> Callable[[object], int | None]:
    """Give a reader of times above zero, in ns."""
    return lambda value: _time(value, most, unit_ns) or None


def _from_zero(most: float, unit_ns: int) -> Callable[[object], int | None]:
    """Give a reader of times that may be zero, in ns."""
    return lambda value: _time(value, most, unit_ns)


def _time(value: object, most: float, unit_ns: int) -> int | None:
    number = _number(value)
    return round(number * unit_ns) if number is not None and 0 <= number <= most else None


def _percent(least: float, most: float) -> Callable[[object], int | float | None]:
    """Give a reader of percentages."""

    def read(value: object) -> int | float | None:
        number = _number(value)
        return number if number is not None and least <= number <= most else None

    return read


def _whole(least: int, most: int) -> Callable[[object], int | None]:
    return lambda value: value if type(value) is int and least <= value <= most else None


def _truth(value: object) -> bool | None:
    return value if isinstance(value, bool) else None


def _tpdo(value: str) -> int | None:
    found = network.pdo(value)
    return found[1] if found and found[0] == "tpdo" else None


_NODE: Final = Key(node, "node")
_NEEDED_NODE: Final = Key(node, "node", needed=True)
_OBJECT_KEY: Final = Key(as_text(_object), "object")
_SECONDS: Final = Key(_above_zero(_LONGEST_S, _NS), "above_zero", allowed="1000000000")
_KINDS: Final = Key(as_text(lambda value: value if _KIND.fullmatch(value) else None), "incident_kind")
_TRUTH: Final = Key(_truth, "truth")
_ANY_NUMBER: Final = Key(_number, "number")
_MS: Final = 1_000_000
_US: Final = 1_000


def _times(name: str) -> dict[str, Key]:
    """Give the two keys of a time above zero: NAME_ms, NAME_us."""
    return {
        f"{name}_ms": Key(_above_zero(4_000_000, _MS), "above_zero", allowed="4000000"),
        f"{name}_us": Key(_above_zero(4_000_000_000, _US), "above_zero", allowed="4000000000"),
    }


_PERIOD: Final = {
    **_times("period"),
    "tolerance_ms": Key(_from_zero(4_000_000, _MS), "from_zero", allowed="4000000"),
    "tolerance_us": Key(_from_zero(4_000_000_000, _US), "from_zero", allowed="4000000000"),
    "tolerance_percent": Key(_percent(0, 1000), "from_zero", allowed="1000"),
}


def _period(entry: Entry, *, needed: bool) -> dict[str, Any]:
    period = entry.only("period_ms", "period_us", needed=needed)
    tolerance = entry.only("tolerance_ms", "tolerance_us", "tolerance_percent")
    if period is None:
        if tolerance:
            raise entry.refuse(tolerance, "goes_with", "period_ms, period_us")
        return {"period_ns": None, "tolerance_ns": None}
    period_ns = entry(period)
    if tolerance is None or tolerance == "tolerance_percent":
        tolerance_ns = round(period_ns * entry("tolerance_percent", _TOLERANCE_PERCENT) / 100)
    else:
        tolerance_ns = entry(tolerance)
    return {"period_ns": period_ns, "tolerance_ns": tolerance_ns}


def _sdo(entry: Entry) -> dict[str, Any]:
    entry.only("value", "data")
    if not entry("never", True):
        raise entry.refuse("never", "only_true")
    never = "never" in entry.found
    entry.apart("never", "count", "sequence", "within_s")
    entry.apart("sequence", "count")
    outcome = entry("outcome", "aborted" if "abort" in entry.found else "any" if never else "ok")
    entry.goes("abort", outcome == "aborted", 'outcome = "aborted"')
    for key in ("value", "data"):
        entry.goes(key, outcome != "aborted", 'outcome = "ok"')
    index, sub = entry("object")
    return {
        "node": entry("node"),
        "index": index,
        "sub": sub,
        "direction": entry("direction"),
        "value": entry("value", entry("data")),
        "outcome": outcome,
        "abort": entry("abort"),
        "sequence": entry("sequence"),
        "count": 0 if never else entry("count", 1),
        "within_ns": entry("within_s"),
    }


def _state(entry: Entry) -> dict[str, Any]:
    entry.only("state", "drive", needed=True)
    entry.goes("axis", "drive" in entry.found, "drive")
    if entry("stays") and entry("state") == "boot-up":
        raise entry.refuse("stays", "boot_up_passes")
    return {
        "node": entry("node"),
        "state": entry("state"),
        "drive": entry("drive"),
        "axis": entry("axis", 1 if "drive" in entry.found else None),
        "by_ns": entry("by_s"),
        "since": entry("since", "start"),
        "stays": entry("stays", False),
    }


def _signal(entry: Entry) -> dict[str, Any]:
    least, most = entry("min"), entry("max")
    if least is not None and most is not None and least > most:
        raise entry.refuse("max", "below_min", as_toml(least))
    return {"select": entry("select"), "min": least, "max": most} | _period(entry, needed=False)


def _heartbeat(entry: Entry) -> dict[str, Any]:
    return {"node": entry("node")} | _period(entry, needed=True)


def _sync(entry: Entry) -> dict[str, Any]:
    return _period(entry, needed=True)


def _emcy(entry: Entry) -> dict[str, Any]:
    return {"node": entry("node"), "code": entry("code"), "occurs": entry("occurs")}


def _incident(entry: Entry) -> dict[str, Any]:
    if not {"occurs", "ends_within_s", "cause"} & set(entry.found):
        file = entry.file.at(entry.table, entry.place)
        keys = "occurs, ends_within_s, cause"
        raise ConfigError("expect.lacks_one", file=file, table=entry.table, keys=keys)
    for key in ("kind", "cause"):
        _kinds(entry, key)
    for key in ("ends_within_s", "cause"):
        if key in entry.found and entry("occurs") == [0, 0]:
            raise entry.refuse(key, "exclusive", "occurs = 0")
    return {
        "node": entry("node"),
        "kind": entry("kind"),
        "occurs": entry("occurs"),
        "ends_within_ns": entry("ends_within_s"),
        "cause": entry("cause"),
    }


def _kinds(entry: Entry, key: str) -> None:
    """Refuse what fits no kind of incident: it could never be found."""
    from difflib import get_close_matches
    from fnmatch import fnmatchcase

    from canalyze._core import INCIDENTS

    glob = entry(key)
    if glob is not None and not any(fnmatchcase(kind, glob) for kind in INCIDENTS):
        near = get_close_matches(glob, INCIDENTS, n=3, cutoff=0.5)
        raise entry.refuse(key, "no_incident_near" if near else "no_incident", ", ".join(near))


def _latency(entry: Entry) -> dict[str, Any]:
    of = entry("of")
    entry.goes("object", of == "sdo", 'of = "sdo"')
    entry.goes("pdo", of == "sync", 'of = "sync"')
    index, sub = entry("object", (None, None))
    most = entry.only("max_ms", "max_us", needed=True)
    return {
        "node": entry("node"),
        "of": of,
        "index": index,
        "sub": sub,
        "pdo": entry("pdo"),
        "max_ns": entry(most or ""),
    }


def _load(entry: Entry) -> dict[str, Any]:
    return {
        "max_percent": entry("max_percent"),
        "bit_rate": entry("bitrate"),
        "window_ns": entry("window_ms", 100 * _MS),
    }


class Table(NamedTuple):
    """A table of the file: its keys beside `bus`, and what the core gets of it."""

    keys: Mapping[str, Key]
    normal: Callable[[Entry], dict[str, Any]]


TABLES: Final[Mapping[str, Table]] = {
    "sdo": Table(
        {
            "node": _NEEDED_NODE,
            "object": _OBJECT_KEY._replace(needed=True),
            "direction": choice("upload", "download"),
            "value": Key(_value, "value"),
            "data": Key(as_text(_bytes), "data"),
            "outcome": choice("ok", "aborted", "any"),
            "abort": Key(as_text(_abort_code), "abort"),
            "sequence": Key(text, "text"),
            "count": Key(_whole(1, 1_000_000), "whole", allowed="1-1000000"),
            "never": _TRUTH,
            "within_s": _SECONDS,
        },
        _sdo,
    ),
    "state": Table(
        {
            "node": _NEEDED_NODE,
            "state": choice(*STATES),
            "drive": choice(*DRIVE_STATES),
            "axis": Key(_whole(1, 8), "whole", allowed="1-8"),
            "by_s": _SECONDS,
            "since": choice("start", "boot-up"),
            "stays": _TRUTH,
        },
        _state,
    ),
    "signal": Table(
        {"select": Key(text, "text", needed=True), "min": _ANY_NUMBER, "max": _ANY_NUMBER, **_PERIOD}, _signal
    ),
    "heartbeat": Table({"node": _NEEDED_NODE, **_PERIOD}, _heartbeat),
    "sync": Table(_PERIOD, _sync),
    "emcy": Table(
        {
            "node": _NODE,
            "code": Key(as_text(_emcy_code), "emcy_code"),
            "occurs": choice("must", "may", "never", needed=True),
        },
        _emcy,
    ),
    "incident": Table(
        {
            "kind": _KINDS,
            "node": _NODE,
            "occurs": Key(_often, "often"),
            "ends_within_s": _SECONDS,
            "cause": _KINDS,
        },
        _incident,
    ),
    "latency": Table(
        {
            "of": choice("sdo", "sync", "nmt", needed=True),
            "node": _NODE,
            "object": _OBJECT_KEY,
            "pdo": Key(as_text(_tpdo), "tpdo"),
            **_times("max"),
        },
        _latency,
    ),
    "load": Table(
        {
            "max_percent": Key(lambda value: _percent(0, 100)(value) or None, "above_zero", needed=True, allowed="100"),
            "bitrate": Key(bit_rate, "bit_rate"),
            "window_ms": Key(_above_zero(3_600_000, _MS), "above_zero", allowed="3600000"),
        },
        _load,
    ),
}
"""The tables of the file, each of which may come several times: [[sdo]]."""
