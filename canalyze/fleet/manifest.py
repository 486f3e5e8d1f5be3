"""The record of a finished capture: one JSON object each, beside the results.

It is written last and atomically, so a capture is done if its manifest says so, however the run ended. A
verdict is stored as JSON and restored for reports. Must not: do the work, or know the meaning of a result.
"""

import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from typing import Any, Final, Literal

from msgspec import convert, to_builtins
from msgspec.structs import replace

from canalyze.check.verdict import Counted, Verdict
from canalyze.fleet.stores import Place

_FINDINGS: Final = ("failures", "others", "consequences")


def stored(verdict: Verdict) -> dict[str, Any]:
    """Returns a verdict for `json`. Only the first finding of each kind keeps its context lines."""
    lists: dict[str, Any] = {name: tuple(map(_bare, getattr(verdict, name))) for name in _FINDINGS}
    made: dict[str, Any] = to_builtins(replace(verdict, **lists), str_keys=True)
    return made


def _bare(one: Counted) -> Counted:
    shown = (one.shown[0], *(replace(other, lines=()) for other in one.shown[1:]))
    return replace(one, shown=shown, consequences=tuple(map(_bare, one.consequences)))


def restored(row: dict[str, Any]) -> Verdict:
    """Restores a verdict. Raises ValueError for other data."""
    return convert(row, Verdict, str_keys=True)


_FOLDER: Final = "_manifest"
_AT_ONCE: Final = 16
"""Number of manifests read concurrently, because stores have a high latency."""

Reason = Literal["unreadable", "fetch", "died", "time", "memory", "raised"]
"""Reasons for an incomplete result: the capture is damaged or none, it could not be fetched, or the worker failed."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """The record of one capture."""

    capture: str
    """Its name."""
    id: str
    """The name of its objects, see `Capture.id`."""
    content: str
    """Its content: hashes of a file, or ETag and size."""
    stamp: str
    """Size, times and inode of a file, to recognize it without reading; in a store the same as `content`."""
    version: str
    """The program's."""
    settings: str
    """Hash of all options, of the configuration, and of the files that they name."""
    failed: Reason | None
    """None if all of it was read."""
    error: str | None
    """The reason in words."""
    attempts: int
    frames: int
    findings: int
    """Number of findings; for check, of those that fail it."""
    seconds: float
    """The duration of the work."""
    result: Any
    """The result, as JSON."""

    def holds(self, version: str, settings: str) -> bool:
        """Returns true if the work would be the same now, for the same capture."""
        return (self.version, self.settings) == (version, settings)


def name_of(action: str, number: str) -> str:
    """Returns the name of the object."""
    return f"{_FOLDER}/{action}/{number}.json"


def read(place: Place, action: str, number: str) -> Manifest | None:
    """Returns the manifest of a capture; None if there is no valid one."""
    data = place.get(name_of(action, number))
    try:
        row = json.loads(data or b"")
        return Manifest(**{field.name: row[field.name] for field in fields(Manifest)})
    except (ValueError, TypeError, LookupError):
        return None


def read_all(place: Place, action: str, numbers: Sequence[str]) -> dict[str, Manifest]:
    """Returns the manifests of captures that have one."""
    there = {name.removesuffix(".json") for name in place.names(f"{_FOLDER}/{action}")}
    wanted = [number for number in numbers if number in there]
    with ThreadPoolExecutor(_AT_ONCE) as threads:
        found = threads.map(lambda number: read(place, action, number), wanted)
        return {one.id: one for one in found if one is not None}


def write(place: Place, action: str, manifest: Manifest) -> None:
    """Writes a manifest atomically."""
    place.put(name_of(action, manifest.id), json.dumps(asdict(manifest), separators=(",", ":")).encode())
