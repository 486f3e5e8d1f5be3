"""The records of the core, typed: the one form in which commands, reports and library have them.

They are decoded from the core's JSON lines and never made here: the meaning of a capture is the core's. Keys that a
record does not list are passed over; `tests/test_records.py` holds each against the schema of the core. It must not
read a capture, judge or print.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, TypeVar, Union, get_args

from msgspec import Struct, convert
from msgspec.json import Decoder

R = TypeVar("R", bound=Struct)

Severity = Literal["info", "warning", "error"]
SEVERITIES: Final[tuple[Severity, ...]] = get_args(Severity)
"""From harmless to bad: those of the core."""
Value: TypeAlias = int | float | str | None
"""A number; bytes as hexadecimal text, an integer beyond 2^53 as decimal text; None where the payload is too short."""

if TYPE_CHECKING:
    Hex: TypeAlias = int
    HexBytes: TypeAlias = bytes
    Seconds: TypeAlias = float
else:

    class _FromText(type):
        """A type of values that are texts in JSON; `_converted` makes them."""

        def __instancecheck__(cls, value: object) -> bool:
            return True

    class Hex(metaclass=_FromText):
        """An integer, hexadecimal in JSON."""

    class HexBytes(metaclass=_FromText):
        """Bytes, hexadecimal in JSON."""

    class Seconds(metaclass=_FromText):
        """Seconds, a decimal string in JSON."""


def _converted(kind: Any, text: str) -> Any:
    if kind is Hex:  # first: each frame has one
        return int(text, 16)
    return bytes.fromhex(text) if kind is HexBytes else float(text)


@cache
def decoder(*kinds: type[Struct]) -> Callable[[bytes | str], Any]:
    """Returns the function that makes a record of one of these kinds of a JSON line."""
    return Decoder(Union[kinds], dec_hook=_converted).decode  # noqa: UP007  as many as there are


@cache
def _begins(*kinds: type[Struct]) -> tuple[bytes, ...]:
    return tuple(f'{{"kind":"{kind.__struct_config__.tag}"'.encode() for kind in kinds)


def records(result: bytes, *kinds: type[R]) -> Iterator[R]:
    """Yields the records of these kinds in complete JSON lines of the core."""
    read, begins = decoder(*kinds), _begins(*kinds)
    start = 0
    while start < len(result):
        end = result.find(b"\n", start) + 1 or len(result)
        if result.startswith(begins, start):
            yield read(result[start:end])
        start = end


def of_rows(rows: Any, *kinds: type[R]) -> list[R]:
    """Returns the records of these kinds that were decoded as JSON, as those that a fleet has stored."""
    found: list[R] = convert(rows, list[Union[kinds]], dec_hook=_converted)  # type: ignore[valid-type]  # noqa: UP007
    return found
