"""Values that a device was configured with -> a DCF (CiA 306): a description with ParameterValue and a node-ID.

The core puts lines beside those of the description. Must not: know where the values come from, or which of them are
worth keeping.
"""

from collections.abc import Mapping
from typing import NamedTuple

from canalyze import _core
from canalyze.dictionary.model import Address
from canalyze.errors import SourceError


class Configured(NamedTuple):
    """A DCF."""

    text: str
    values: int
    """How many values stand in it."""
    left_out: tuple[Address, ...]
    """Objects that the description does not have, or whose value it cannot hold."""


def configured(
    description: bytes, name: str, values: Mapping[Address, bytes], node: int, keys: Mapping[str, str]
) -> Configured:
    """Put values, as SDO transfers them, into a description that was read from `name`. SourceError where it is none.

    keys: of [FileInfo].
    """
    try:
        text, left_out = _core.configured(description, values, node, list(keys.items()))
    except _core.DescriptionError as error:
        key, facts = error.args
        raise SourceError(key, name=name, **facts) from None
    return Configured(text, len(values) - len(left_out), tuple(left_out))
