"""Ways in which a file is damaged, each drawn from a number.

Why it exists: a case is known by its format and number, in every run. What it must not do: know a format.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random

Damage = Callable[[bytes, Random], bytes]


def cut(sound: bytes, draw: Random) -> bytes:
    """The end is missing."""
    return sound[: draw.randrange(len(sound))]


def flip(sound: bytes, draw: Random) -> bytes:
    """One byte has another value."""
    at = draw.randrange(len(sound))
    return sound[:at] + bytes([sound[at] ^ draw.randrange(1, 256)]) + sound[at + 1 :]


def inserted(sound: bytes, draw: Random) -> bytes:
    """Bytes of something else stand in between."""
    at = draw.randrange(len(sound) + 1)
    return sound[:at] + draw.randbytes(draw.choice([1, 4, 17, 100, 700])) + sound[at:]


def zeroed(sound: bytes, draw: Random) -> bytes:
    """A block was never written."""
    size = draw.choice([16, 64, 512, 2048])
    at = draw.randrange(len(sound)) // size * size
    block = sound[at : at + size]
    return sound[:at] + bytes(len(block)) + sound[at + size :]


def doubled(sound: bytes, draw: Random) -> bytes:
    """A block stands there twice."""
    size = draw.choice([16, 64, 512, 2048])
    at = draw.randrange(len(sound)) // size * size
    return sound[: at + size] + sound[at:]


def removed(sound: bytes, draw: Random) -> bytes:
    """A block is missing."""
    size = draw.choice([1, 16, 64, 512])
    at = draw.randrange(len(sound)) // size * size
    return sound[:at] + sound[at + size :]


def swapped(sound: bytes, draw: Random) -> bytes:
    """Two neighbouring blocks are exchanged."""
    size = draw.choice([16, 64, 512])
    at = draw.randrange(len(sound)) // size * size
    first, second = sound[at : at + size], sound[at + size : at + 2 * size]
    return sound[:at] + second + first + sound[at + 2 * size :]


KINDS: list[tuple[Damage, int]] = [
    (cut, 4),
    (flip, 10),
    (inserted, 2),
    (zeroed, 2),
    (doubled, 1),
    (removed, 1),
    (swapped, 1),
]
"""Each with its weight."""


def damaged(form: str, sound: bytes, number: int) -> tuple[str, bytes]:
    """A case: the kind of damage, and the file."""
    draw = Random(f"{form} {number}")
    damage = draw.choices([damage for damage, _ in KINDS], [weight for _, weight in KINDS])[0]
    return damage.__name__, damage(sound, draw)
