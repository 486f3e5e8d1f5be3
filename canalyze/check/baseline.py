"""The file of known findings: what a check allows because it was there before.

JSON for version control: sorted, one entry a line, nothing that changes by itself. An entry is a kind of finding (code,
bus, node, object) with the most of it in any one capture of the set. Expectations are not told apart: their lines
move with every edit of their file. Must not: judge.
"""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

from canalyze import bounded, jsonl
from canalyze.bounded import short
from canalyze.errors import ConfigError
from canalyze.finding import Finding

VERSION: Final = 1
_HEAD: Final = "canalyze_baseline"
_KEYS: Final = ("code", "bus", "node", "object", "count")
_CODE: Final = re.compile(r"[A-Z]{3}[0-9]{3}")
_BETWEEN: Final = re.compile(r"[\s,]*+")
_DIGITS: Final = 18
"""Of the largest number that an entry may have."""
_DECODER: Final = json.JSONDecoder(parse_int=lambda digits: int(digits) if len(digits) <= _DIGITS else digits)
"""What is longer stays a text, which no entry has there."""
_OBJECT: Final = re.compile(r"[0-9A-F]{4}:[0-9A-F]{2}")


class Kind(NamedTuple):
    """What findings have in common that are counted together."""

    code: str
    bus: str | None
    node: int | None
    object: str | None
    """1017:00."""

    @classmethod
    def of(cls, finding: Finding) -> "Kind":
        """Give the kind of a finding."""
        place = None if finding.index is None else f"{finding.index}:{finding.sub or 0:02X}"
        return cls(finding.code, finding.bus, finding.node, place)

    @property
    def order(self) -> tuple[str, str, int, str]:
        """By code, bus, node, object; what is about none comes first."""
        return (self.code, self.bus or "", self.node or 0, self.object or "")


Baseline = Mapping[Kind, int]
"""How many of each kind are known, at least one."""


def text(known: Baseline) -> str:
    """Give the file."""
    rows = [jsonl.text(kind._asdict() | {"count": known[kind]}) for kind in sorted(known, key=lambda kind: kind.order)]
    inner = ",\n".join(f"  {row}" for row in rows)
    return (
        f'{{"{_HEAD}": {VERSION}, "findings": [\n{inner}\n]}}\n'
        if rows
        else f'{{"{_HEAD}": {VERSION}, "findings": []}}\n'
    )


def read(name: str) -> dict[Kind, int]:
    """Read the file; ConfigError, with its line, for what cannot be."""
    try:
        content = bounded.content(Path(name)).decode("utf-8-sig")
        values = _DECODER.decode(content)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        raise ConfigError("baseline.missing" if missing else "baseline.read", file=name, error=error) from error
    except UnicodeDecodeError as error:
        raise ConfigError("config.not_utf8", file=name, line=error.object.count(b"\n", 0, error.start) + 1) from error
    except json.JSONDecodeError as error:
        raise ConfigError("baseline.broken", file=f"{name}:{error.lineno}:{error.colno}", problem=error.msg) from error
    except RecursionError as error:
        raise ConfigError("baseline.none", file=name) from error
    if not isinstance(values, dict) or _HEAD not in values or not isinstance(values.get("findings"), list):
        raise ConfigError("baseline.none", file=name)
    if values[_HEAD] != VERSION:
        raise ConfigError("baseline.version", file=name, version=short(str(values[_HEAD])), own=VERSION)
    known: dict[Kind, int] = {}
    for place, entry in enumerate(values["findings"]):
        problem = _problem(entry)
        if problem:
            at, shown = _at(name, content, place), _shown(entry, problem)
            raise ConfigError("baseline.entry", file=at, key=short(problem), value=shown)
        kind = Kind(*(entry.get(key) for key in _KEYS[:-1]))
        if kind in known:
            raise ConfigError("baseline.twice", file=_at(name, content, place), code=kind.code)
        known[kind] = entry["count"]
    return known


def _problem(entry: Any) -> str:
    """Give the key of an entry that cannot be, "" if all is well."""
    if not isinstance(entry, dict):
        return "{}"
    strange = next((key for key in entry if key not in _KEYS), "")
    bus, node, place = entry.get("bus"), entry.get("node"), entry.get("object")
    fine = {
        "code": isinstance(entry.get("code"), str) and _CODE.fullmatch(entry["code"]),
        "bus": bus is None or (isinstance(bus, str) and bus != ""),
        "node": node is None or (type(node) is int and 1 <= node <= 127),
        "object": place is None or (isinstance(place, str) and _OBJECT.fullmatch(place)),
        "count": type(entry.get("count")) is int and entry["count"] >= 1,
    }
    return strange or next((key for key, good in fine.items() if not good), "")


def _shown(entry: Any, key: str) -> str:
    value = entry.get(key) if isinstance(entry, dict) else entry
    return short(jsonl.text(value))


def _at(name: str, content: str, place: int) -> str:
    """Give FILE:LINE of an entry; FILE if its line cannot be told."""
    begin = re.search(r'"findings"\s*:\s*\[', content)
    at = begin.end() if begin else len(content)
    for _ in range(place + 1):
        at = _BETWEEN.match(content, at).end()  # type: ignore[union-attr]  # it matches nothing, too
        if at >= len(content) or content[at] == "]":
            return name
        start = at
        _, at = _DECODER.raw_decode(content, at)
    return f"{name}:{content.count(chr(10), 0, start) + 1}"


def replaceable(name: str) -> bool:
    """Tell whether a new baseline may take the place of a file: of one, whole or not, of an empty one, of none."""
    try:
        content = bounded.content(Path(name)).decode("utf-8-sig", "replace").strip()
    except FileNotFoundError:
        return True
    except OSError as error:
        raise ConfigError("baseline.read", file=name, error=error) from error
    return not content or (content.startswith("{") and f'"{_HEAD}"' in content)


def most(counts: Iterable[Mapping[Kind, int]]) -> dict[Kind, int]:
    """Give of each kind the most in any one capture."""
    known: dict[Kind, int] = {}
    for one in counts:
        for kind, count in one.items():
            known[kind] = max(count, known.get(kind, 0))
    return known


def exists(name: str) -> bool:
    """Tell whether there is such a file."""
    return Path(name).exists()
