"""CompactPDO of a description -> the keys of the objects that exist by it alone (CiA 306 4.5.2)."""

from collections.abc import Iterator
from typing import Final

from canalyze._core import pdo_parameters
from canalyze.dictionary.values import UNSIGNED8, UNSIGNED16, UNSIGNED32

_SUBS: Final = (
    ("COB-ID", UNSIGNED32),
    ("Transmission type", UNSIGNED8),
    ("Inhibit time", UNSIGNED16),
    ("Compatibility entry", UNSIGNED8),
    ("Event timer", UNSIGNED16),
    ("SYNC start value", UNSIGNED8),
)
"""Subs 1 to 6 of a communication parameter."""
_MOST_PDOS: Final = 512
"""Of each direction."""
_MOST_MAPPED: Final = 64


def implied(
    mask: int, numbers: tuple[int, int], existing: set[int]
) -> Iterator[tuple[int, str, dict[int, dict[str, str]]]]:
    """Give index, name, and the keys of each sub-index; bit k-1 of the mask stands for sub k.

    numbers: of RPDOs and TPDOs. existing: indices that are described by themselves.
    """
    mask &= (1 << len(_SUBS)) - 1
    for direction, count in zip(("rpdo", "tpdo"), numbers if mask else (0, 0), strict=True):
        for number in range(1, min(count, _MOST_PDOS) + 1):
            communication, mapping, cob_id = pdo_parameters(direction, number)
            if communication not in existing:
                subs = {0: _sub("Highest sub-index supported", UNSIGNED8, "const", f"{mask.bit_length()}")}
                for sub, (name, width) in enumerate(_SUBS, 1):
                    if mask & 1 << (sub - 1):
                        subs[sub] = _sub(name, width, "rw", cob_id if sub == 1 else "")
                yield communication, f"{direction.upper()} communication parameter", subs
            if mapping not in existing:
                subs = {0: _sub("Number of mapped objects", UNSIGNED8, "rw", "0")}
                subs |= {
                    sub: _sub(f"Application object {sub}", UNSIGNED32, "rw", "") for sub in range(1, _MOST_MAPPED + 1)
                }
                yield mapping, f"{direction.upper()} mapping parameter", subs


def _sub(name: str, kind: int, access: str, default: str) -> dict[str, str]:
    return {"ParameterName": name, "DataType": f"{kind:#06x}", "AccessType": access, "DefaultValue": default}
