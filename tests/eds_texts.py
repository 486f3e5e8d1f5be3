"""Small device descriptions for tests, and what is asked of them.

Why it exists: each test reads a few lines of text and looks at one value or defect. What it must not do: know a repair.
"""

from __future__ import annotations

import canopen

from canalyze.dictionary import Dictionary, read

LISTS = "[OptionalObjects]\nSupportedObjects=1\n1=0x2000\n"
"""Three lines before each text: the lists of a file whose only object is 2000h."""


def load(text: str, node: int | None = None) -> Dictionary:
    """Read a text behind LISTS."""
    return read((LISTS + text).encode(), "x.eds", node)


def codes(found: Dictionary) -> list[tuple[int, str]]:
    """The defects, by line."""
    return [(defect.line, defect.code) for defect in found.defects]


def pdos(found: Dictionary, node: int) -> list[tuple[object, ...]]:
    """Our PDOs: which, identifier, whether it is valid, whether remote frames are allowed, what is mapped where."""
    return [
        (
            *(pdo.direction, pdo.number, pdo.cob_id.at(node), pdo.cob_id.valid, pdo.cob_id.rtr_allowed),
            [(entry.index, entry.sub, entry.offset, entry.bits) for entry in pdo.mapped],
        )
        for pdo in found.pdos
    ]


def pdos_of_the_library(file: str, node: int) -> list[tuple[object, ...]]:
    """The same by python-canopen."""
    theirs = canopen.Network().add_node(node, file)
    found: list[tuple[object, ...]] = []
    for direction, side in (("rpdo", theirs.rpdo), ("tpdo", theirs.tpdo)):
        side.read(from_od=True)  # type: ignore[no-untyped-call]
        for number, pdo in side.items():
            mapped = [(one.index, one.subindex, one.offset, one.length) for one in pdo.map]
            found.append((direction, number, pdo.cob_id, pdo.enabled, pdo.rtr_allowed, mapped))
    return found
