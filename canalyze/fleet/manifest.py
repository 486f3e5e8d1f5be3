"""What is known of a capture that was worked on: one JSON object each, in the place of the results.

It is written last and as a whole, so a capture is done if its manifest says so, whatever has become of the run. Must
not: do the work, or know what a result means.
"""

import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from typing import Any, Final, Literal

from canalyze.fleet.stores import Place

_FOLDER: Final = "_manifest"
_AT_ONCE: Final = 16
"""Manifests that are read at once, since a store takes its time for each."""

Reason = Literal["unreadable", "fetch", "died", "time", "memory", "raised"]
"""Why there is no whole result: the capture is damaged or none, it did not come, or what its worker ended by."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """One capture, worked on."""

    capture: str
    """Its name."""
    id: str
    """What its objects are named by, see `Capture.id`."""
    content: str
    """What it was: hashes of a file, or ETag and size."""
    stamp: str
    """Of a file size, times and inode, by which it is known unread; of a store the same as `content`."""
    version: str
    """The program's."""
    settings: str
    """Hash of all options, of the configuration, and of the files that they name."""
    failed: Reason | None
    """None: all of it was read."""
    error: str | None
    """The same in words."""
    attempts: int
    frames: int
    findings: int
    """How many findings there are, of check those that fail it."""
    seconds: float
    """How long the work took."""
    result: Any
    """What came of it, as JSON."""

    def holds(self, version: str, settings: str) -> bool:
        """Tell whether the work would be the same now, if the capture is."""
        return (self.version, self.settings) == (version, settings)


def name_of(action: str, number: str) -> str:
    """Give the name of the object."""
    return f"{_FOLDER}/{action}/{number}.json"


def read(place: Place, action: str, number: str) -> Manifest | None:
    """Read the manifest of a capture; None where there is none, or where it is none of ours."""
    data = place.get(name_of(action, number))
    try:
        row = json.loads(data or b"")
        return Manifest(**{field.name: row[field.name] for field in fields(Manifest)})
    except (ValueError, TypeError, LookupError):
        return None


def read_all(place: Place, action: str, numbers: Sequence[str]) -> dict[str, Manifest]:
    """Read the manifests of captures; those that there are."""
    there = {name.removesuffix(".json") for name in place.names(f"{_FOLDER}/{action}")}
    wanted = [number for number in numbers if number in there]
    with ThreadPoolExecutor(_AT_ONCE) as threads:
        found = threads.map(lambda number: read(place, action, number), wanted)
        return {one.id: one for one in found if one is not None}


def write(place: Place, action: str, manifest: Manifest) -> None:
    """Write it, as a whole."""
    place.put(name_of(action, manifest.id), json.dumps(asdict(manifest), separators=(",", ":")).encode())
