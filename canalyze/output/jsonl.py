"""JSON output that cannot mislead a person: control and invisible characters are escaped.

Characters that could control a terminal, reorder or hide text, or break a line, and commands of CI runners are
written as hexadecimal escapes, as the core writes them. Must not: know a key.
"""

import json
import re
from typing import Any, Final

_COMMAND: Final = re.compile(r"(##(?:vso)?)\[")
"""Commands of the runners of GitHub and Azure."""


def text(value: Any, *, compact: bool = False, indent: int | None = None) -> str:
    """Returns the JSON of a value."""
    separators = (",", ":") if compact else None
    written = json.dumps(value, ensure_ascii=False, separators=separators, indent=indent)
    written = _COMMAND.sub(r"\1\\u005b", written)
    if written.isprintable():
        return written
    return "".join(char if char.isprintable() or char == "\n" else _escaped(char) for char in written)


def line(value: Any, *, compact: bool = False) -> bytes:
    """Returns one line of JSON, with its line end."""
    return text(value, compact=compact).encode() + b"\n"


def fields(record: object, names: str) -> dict[str, Any]:
    """Returns attributes of a record; names: with blanks between."""
    return {name: getattr(record, name) for name in names.split()}


def _escaped(char: str) -> str:
    return json.dumps(char)[1:-1]
