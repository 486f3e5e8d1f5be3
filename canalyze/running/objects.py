"""The objects of devices, by what a capture shows of them. What that is, the core says."""

from typing import Any, Final, NamedTuple

from canalyze.configuration.options import moment, option
from canalyze.running.passes import Pass

FORMS: Final = {"text": "-text", "jsonl": "", "csv": "-csv"}
"""The ends of the core's names of what comes out, by the values of --format."""
AT: Final = option("--at", "S", moment, "moment", key="od.at", usual=0)
_NO_OBJECT: Final = b'{"kind":"od_pdo"'
"""PDOs come behind all objects: a result that begins so has none."""


class Objects(NamedTuple):
    """The objects of a capture, and how its reading ended."""

    code: int
    frames: int
    result: bytes
    """The JSON lines of the core."""
    some: bool
    """True if an object was seen."""


def settings_of(one: Pass) -> dict[str, Any]:
    """Returns the settings of the core for --at."""
    return {"until_ns": None if one.at is None else round(one.at * 1e9)}


def has_object(result: bytes) -> bool:
    """Returns true if a result of the core has an object."""
    return bool(result) and not result.startswith(_NO_OBJECT)


def read_objects(one: Pass, kind: str, names: tuple[str, ...] = (), **how: Any) -> Objects:
    """Reads a capture to its end. kind: the core's name of what comes out. how: as of `Pass.session`."""
    session = one.session(format=kind, **settings_of(one), **how)
    results: list[bytes] = []
    code = one.read(session, results.append, names)
    return Objects(code, session.frames, b"".join(results), any(map(has_object, results)))
