"""Every clean session, recorded or generated, and what is known of its nodes.

Why it exists: what is measured with distortions and with faults is measured on the same sessions. What it must not do:
judge them.
"""

from __future__ import annotations

import json
from functools import cache

from captures import EDS, SAMPLES, SHARED, read_log
from network_sessions import SESSIONS
from plants import MASTERS, Session, as_made, calm, counted, drive, guarded, plant, reset, slow, transfers

from canalyze import _core
from canalyze.dictionary import load

GENERATED = (
    "states",
    "stopped",
    "emergencies",
    "times",
    "lss_configured",
    "synchronous_counted",
    "event_driven",
    "safety",
)
"""Sessions of `network_sessions`, one for each service; longer ones are those of `plants`."""

OWN = {"sync-counter": MASTERS - {0x080}, "multiplex-and-safety": MASTERS - {0x6C4}}
"""What the recording host sends, where that is not the usual: SYNC of a node, the answers of a second SDO channel."""


@cache
def recorded() -> dict[str, Session]:
    """Sessions of `samples`, and others of real stacks where there are any; the same capture once."""
    found: dict[str, Session] = {}
    seen: set[bytes] = set()
    folders = (SAMPLES / "network", SAMPLES / "stacks", SHARED / "stacks")
    for path in (path for folder in folders for path in sorted(folder.glob("*.log"))):
        text = path.read_bytes()
        if text not in seen:
            seen.add(text)
            found[path.stem] = as_made(read_log(text), OWN.get(path.stem, MASTERS))
    return found


@cache
def sessions() -> dict[str, Session]:
    """Every clean session by its name."""
    found = dict(recorded())
    found |= {name: as_made(SESSIONS[name]().frames()) for name in GENERATED}
    for known in ("traffic", "written", "described"):
        found |= {f"{made.__name__} {known}": made(known) for made in (plant, calm, guarded, drive)}
    found |= {made.__name__: made() for made in (counted, transfers, slow, reset)}
    return found


@cache
def beside(name: str) -> tuple[_core.Network | None, ...]:
    """What a session is judged with: by itself, and with the descriptions of its nodes."""
    truth = SAMPLES / "network" / f"{name}.json"
    if not truth.is_file():
        return (sessions()[name].network,)
    files = [(row["node"], row["eds"]) for row in json.loads(truth.read_text())["nodes"] if row["eds"]]
    if not files:
        return (None,)
    return None, _core.Network(descriptions=[(None, node, load(str(EDS / eds)).table) for node, eds in files])
