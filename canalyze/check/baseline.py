"""The file of known findings and problems: what a check allows because it was there before.

JSON for version control: sorted, one entry a line, nothing that changes by itself. An entry is a kind of finding (code,
bus, node, object) or of problem (kind, bus, subject, object) with the most of it in any one capture of the set; the
list of problems is there where there are any. Expectations are not told apart: their lines move with every edit of
their file. Must not: judge.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from canalyze.errors import ConfigError
from canalyze.output import files
from canalyze.output.files import short
from canalyze.records.problems import Finding, Problem

if TYPE_CHECKING:
    from json import JSONDecoder

VERSION: Final = 1
_HEAD: Final = "canalyze_baseline"
_CODE: Final = re.compile(r"[A-Z]{3}[0-9]{3}")
_PROBLEM: Final = re.compile(r"[a-z]+(?:-[a-z]+)*")
_SUBJECT: Final = 100
"""Characters of a subject."""
_BETWEEN: Final = re.compile(r"[\s,]*+")
_DIGITS: Final = 18
"""Of the largest number that an entry may have."""
_OBJECT: Final = re.compile(r"[0-9A-F]{4}:[0-9A-F]{2}")


class Kind(NamedTuple):
    """Properties that findings have in common to be counted together."""

    code: str
    bus: str | None
    node: int | None
    object: str | None
    """1017:00."""

    @classmethod
    def of(cls, finding: Finding) -> "Kind":
        """Returns the kind of a finding."""
        place = None if finding.index is None else f"{finding.index}:{finding.sub or 0:02X}"
        return cls(finding.code, finding.bus, finding.node, place)

    @property
    def order(self) -> tuple[str, str, int, str]:
        """By code, bus, node, object; what is about none comes first."""
        return (self.code, self.bus or "", self.node or 0, self.object or "")


class ProblemKind(NamedTuple):
    """Properties that problems have in common to be counted together."""

    kind: str
    """node-silent."""
    bus: str | None
    subject: str | None
    """`node 5`, `node 5 axis 2`, `node 5 TPDO1`, `nodes 3 4`; None: the bus."""
    object: str | None
    """1017:00, the object that it began with, where it is about one."""

    @classmethod
    def of(cls, problem: Problem) -> "ProblemKind":
        """Returns the kind of a problem."""
        parts = [f"node {problem.node}"] if problem.node else []
        if not parts and problem.nodes:
            parts = [" ".join(["nodes", *map(str, problem.nodes)])[:_SUBJECT]]
        parts += [f"axis {problem.axis}"] if problem.axis else []
        parts += [problem.pdo] if problem.pdo else []
        place = problem.facts.get("object")
        return cls(problem.kind, problem.bus, " ".join(parts) or None, place if isinstance(place, str) else None)

    @property
    def order(self) -> tuple[str, str, int, str]:
        """By kind, bus, subject, object; what is about none comes first. Lower case: behind all codes."""
        return (self.kind, self.bus or "", 0, f"{self.subject or ''} {self.object or ''}")


Baseline = Mapping[Kind | ProblemKind, int]
"""Number of known ones of each kind, at least one."""


def text(known: Baseline) -> str:
    """Returns the file."""
    lists = [f'"findings": {_list(known, Kind)}']
    if any(isinstance(kind, ProblemKind) for kind in known):
        lists.append(f'"problems": {_list(known, ProblemKind)}')
    return f'{{"{_HEAD}": {VERSION}, {", ".join(lists)}}}\n'


def _list(known: Baseline, form: type[Kind | ProblemKind]) -> str:
    """Returns the entries of one form."""
    from canalyze.output import json_text

    kinds = sorted((kind for kind in known if isinstance(kind, form)), key=lambda kind: kind.order)
    rows = [json_text(kind._asdict() | {"count": known[kind]}) for kind in kinds]
    inner = ",\n".join(f"  {row}" for row in rows)
    return f"[\n{inner}\n]" if rows else "[]"


@cache
def _decoder() -> "JSONDecoder":
    """Returns a decoder by which a number that is too long stays a text, which no entry has there."""
    from json import JSONDecoder

    return JSONDecoder(parse_int=lambda digits: int(digits) if len(digits) <= _DIGITS else digits)


def read(name: str) -> dict[Kind | ProblemKind, int]:
    """Reads the file; ConfigError, with its line, for content that is not valid."""
    from json import JSONDecodeError

    try:
        content = files.content(Path(name)).decode("utf-8-sig")
        values = _decoder().decode(content)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        raise ConfigError("baseline.missing" if missing else "baseline.read", file=name, error=error) from error
    except UnicodeDecodeError as error:
        raise ConfigError("config.not_utf8", file=name, line=error.object.count(b"\n", 0, error.start) + 1) from error
    except JSONDecodeError as error:
        raise ConfigError("baseline.broken", file=f"{name}:{error.lineno}:{error.colno}", problem=error.msg) from error
    except RecursionError as error:
        raise ConfigError("baseline.none", file=name) from error
    if not isinstance(values, dict) or _HEAD not in values or not isinstance(values.get("findings"), list):
        raise ConfigError("baseline.none", file=name)
    if values[_HEAD] != VERSION:
        raise ConfigError("baseline.version", file=name, version=short(str(values[_HEAD])), own=VERSION)
    if not all(isinstance(values.get(section, []), list) for section in _FORMS):
        raise ConfigError("baseline.none", file=name)
    known: dict[Kind | ProblemKind, int] = {}
    for section, form in _FORMS.items():
        for place, entry in enumerate(values.get(section, [])):
            if not isinstance(entry, dict):
                at = _at(name, content, section, place)
                raise ConfigError("baseline.form", file=at, value=_shown(entry))
            wrong = _wrong(entry, form)
            if wrong:
                at = _at(name, content, section, place)
                key = "baseline.entry" if form is Kind else "baseline.problem"
                raise ConfigError(key, file=at, key=short(wrong), value=_shown(entry.get(wrong)))
            fields: list[Any] = [entry.get(key) for key in form._fields]
            kind = form(*fields)
            if kind in known:
                at = _at(name, content, section, place)
                raise ConfigError("baseline.twice", file=at, code=kind[0])
            known[kind] = entry["count"]
    return known


def _matches(pattern: re.Pattern[str]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, str) and pattern.fullmatch(value) is not None


_ALLOWED: Final[Mapping[str, Callable[[Any], bool]]] = {
    "code": _matches(_CODE),
    "kind": _matches(_PROBLEM),
    "bus": lambda value: value is None or (isinstance(value, str) and value != ""),
    "node": lambda value: value is None or (type(value) is int and 1 <= value <= 127),
    "subject": lambda value: value is None or (isinstance(value, str) and 0 < len(value) <= _SUBJECT),
    "object": lambda value: value is None or _matches(_OBJECT)(value),
    "count": lambda value: type(value) is int and value >= 1,
}
"""Values that a key of an entry may have."""
_FORMS: Final[Mapping[str, type[Kind | ProblemKind]]] = {
    "findings": Kind,
    "problems": ProblemKind,
    "incidents": ProblemKind,
}
"""The lists of the file, and what their entries are; `incidents` is the former name of `problems`."""


def _wrong(entry: Mapping[str, Any], form: type[Kind | ProblemKind]) -> str:
    """Returns the first invalid key of an entry, "" if it is valid."""
    keys = (*form._fields, "count")
    strange = next((key for key in entry if key not in keys), "")
    return strange or next((key for key in keys if not _ALLOWED[key](entry.get(key))), "")


def _shown(value: Any) -> str:
    from canalyze.output import json_text

    return short(json_text(value))


def _at(name: str, content: str, section: str, place: int) -> str:
    """Returns FILE:LINE of an entry of a list; FILE if its line is unknown."""
    begin = re.search(rf'"{section}"\s*:\s*\[', content)
    at = begin.end() if begin else len(content)
    for _ in range(place + 1):
        at = _BETWEEN.match(content, at).end()  # type: ignore[union-attr]  # it matches nothing, too
        if at >= len(content) or content[at] == "]":
            return name
        start = at
        _, at = _decoder().raw_decode(content, at)
    return f"{name}:{content.count(chr(10), 0, start) + 1}"


def replaceable(name: str) -> bool:
    """Returns true if a new baseline may replace a file: a baseline, complete or not, an empty file, or none."""
    try:
        content = files.content(Path(name)).decode("utf-8-sig", "replace").strip()
    except FileNotFoundError:
        return True
    except OSError as error:
        raise ConfigError("baseline.read", file=name, error=error) from error
    return not content or (content.startswith("{") and f'"{_HEAD}"' in content)


def most(counts: Iterable[Mapping[Kind | ProblemKind, int]]) -> dict[Kind | ProblemKind, int]:
    """Returns the maximum of each kind in any one capture."""
    known: dict[Kind | ProblemKind, int] = {}
    for one in counts:
        for kind, count in one.items():
            known[kind] = max(count, known.get(kind, 0))
    return known
