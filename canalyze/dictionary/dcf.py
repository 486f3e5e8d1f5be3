"""Configured values of a device -> a DCF (CiA 306): a description with ParameterValue and a node-ID.

The core inserts the lines into the description. Must not: know the source of the values, or select them.
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
    """Number of values in it."""
    left_out: tuple[Address, ...]
    """Objects that are not in the description, or whose value it cannot hold."""


def configured(
    description: bytes, name: str, values: Mapping[Address, bytes], node: int, keys: Mapping[str, str]
) -> Configured:
    """Inserts values, as SDO transfers them, into a description read from `name`. Raises SourceError for other files.

    keys: entries of [FileInfo].
    """
    try:
        text, left_out = _core.configured(description, values, node, list(keys.items()))
    except _core.DescriptionError as error:
        key, facts = error.args
        raise SourceError(key, name=name, **facts) from None
    return Configured(text, len(values) - len(left_out), tuple(left_out))
