"""The file of known findings: what a check allows because it was there before.

JSON for version control: sorted, one entry a line, nothing that changes by itself. An entry is a kind of finding (code,
bus, node, object) with the most of it in any one capture of the set. Must not: judge.
"""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

from canalyze.errors import ConfigError
from canalyze.finding import Finding

VERSION: Final = 1
_HEAD: Final = "canalyze_baseline"
_KEYS: Final = ("code", "bus", "node", "object", "count")
_CODE: Final = re.compile(r"[A-Z]{3}[0-9]{3}")
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
    rows = [
        json.dumps(kind._asdict() | {"count": known[kind]}, ensure_ascii=False)
        for kind in sorted(known, key=lambda kind: kind.order)
    ]
    inner = ",\n".join(f"  {row}" for row in rows)
    return (
        f'{{"{_HEAD}": {VERSION}, "findings": [\n{inner}\n]}}\n'
        if rows
        else f'{{"{_HEAD}": {VERSION}, "findings": []}}\n'
    )


def read(name: str) -> dict[Kind, int]:
    """Read the file; ConfigError, with its line, for what cannot be."""
    try:
        content = Path(name).read_bytes().decode("utf-8-sig")
        values = json.loads(content)
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
        raise ConfigError("baseline.version", file=name, version=values[_HEAD], own=VERSION)
    known: dict[Kind, int] = {}
    lines = _lines(content)
    for place, entry in enumerate(values["findings"]):
        file = f"{name}:{lines[place]}" if place < len(lines) else name
        problem = _problem(entry)
        if problem:
            raise ConfigError("baseline.entry", file=file, key=problem, value=_shown(entry, problem))
        kind = Kind(*(entry.get(key) for key in _KEYS[:-1]))
        if kind in known:
            raise ConfigError("baseline.twice", file=file, code=kind.code)
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
    return json.dumps(value, ensure_ascii=False)


def _lines(content: str) -> list[int]:
    """Give the lines in which the entries begin, as far as they can be told."""
    begin = re.search(r'"findings"\s*:\s*\[', content)
    found: list[int] = []
    decoder = json.JSONDecoder()
    at = begin.end() if begin else len(content)
    while blank := re.compile(r"[\s,]*").match(content, at):
        at = blank.end()
        if at >= len(content) or content[at] == "]":
            break
        found.append(content.count("\n", 0, at) + 1)
        _, at = decoder.raw_decode(content, at)
    return found


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
