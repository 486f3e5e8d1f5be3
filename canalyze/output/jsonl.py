"""JSON as it is written: any reader gets the same values, and nobody who looks at it is misled.

What could drive a terminal, reorder or hide text, break a line, or be a command to the runner of GitHub is written as
its number in hexadecimal, as the core does it. Must not: know a key.
"""

import json
import re
from typing import Any, Final

_COMMAND: Final = re.compile(r"(##(?:vso)?)\[")
"""What a runner of GitHub or Azure takes for a command."""


def text(value: Any, *, compact: bool = False, indent: int | None = None) -> str:
    """Give the JSON of a value."""
    separators = (",", ":") if compact else None
    written = json.dumps(value, ensure_ascii=False, separators=separators, indent=indent)
    written = _COMMAND.sub(r"\1\\u005b", written)
    if written.isprintable():
        return written
    return "".join(char if char.isprintable() or char == "\n" else _escaped(char) for char in written)


def line(value: Any, *, compact: bool = False) -> bytes:
    """Give one line of JSON, with its end."""
    return text(value, compact=compact).encode() + b"\n"


def _escaped(char: str) -> str:
    return json.dumps(char)[1:-1]
