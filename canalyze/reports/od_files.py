"""Files that are made of the objects of one node: a DCF, a concise DCF, an EDS; and the lines about them.

Must not: decide what is configuration.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from canalyze.dictionary.files import concise, configured, skeleton
from canalyze.dictionary.model import Address
from canalyze.errors import OutputError
from canalyze.records import records
from canalyze.records.inventory import Head, Object
from canalyze.words import Words


class Of(NamedTuple):
    """The data that files are made of."""

    node: int
    head: Head
    objects: list[Object]
    values: dict[Address, bytes]
    """Values that were written and accepted, in that order; no bytes where not all of them are there."""
    description: tuple[bytes, str] | None
    """The device's own, and its name."""


class File(NamedTuple):
    """A file that is made."""

    data: bytes
    said: str
    """Key of the sentence that says what is in it."""
    size: int
    """Values, or objects, in it."""
    left_out: Sequence[Address] = ()


def of(result: bytes, node: int, description: tuple[bytes, str] | None) -> Of:
    """Chooses what belongs to a node in JSON lines; OutputError where there is none, or there are several."""
    heads = [one for one in records(result, Head) if one.node == node]
    if len(heads) > 1:
        raise OutputError("od.buses", node=node, buses=", ".join(str(one.bus) for one in heads))
    if not heads:
        raise OutputError("od.no_node", node=node)
    objects = [one for one in records(result, Object) if one.node == node]
    written = [(one.configured, one.address) for one in objects if one.configured]
    written.sort(key=lambda row: row[0].frame)
    values = {address: held.whole or b"" for held, address in written}
    return Of(node, heads[0], objects, values, description)


def made(form: str, name: str, of: Of, words: Words) -> tuple[bytes, list[str]]:
    """Makes the file of that name; give its content and the line about it. form: one of FORMS.

    OutputError where there is nothing to be written.
    """
    file = FORMS[form](name, of)
    said = [words(file.said, name=name, node=of.node, count=file.size)]
    if file.left_out:
        missing = ", ".join(f"{index:04X}h:{sub:02X}" for index, sub in file.left_out)
        said.append(words("od.left_out", name=name, objects=missing))
    return file.data, said


def _dcf(name: str, of: Of) -> File:
    _configured(of)
    keys = {"FileName": Path(name).name}
    if of.description is not None:
        keys["LastEDS"] = Path(of.description[1]).name
    description = of.description or (skeleton(of.head, of.objects).encode(), name)
    found = configured(*description, of.values, of.node, keys)
    return File(found.text.encode(), "od.written", found.values, found.left_out)


def _concise(_: str, of: Of) -> File:
    _configured(of)
    values = {address: data for address, data in of.values.items() if data}
    return File(concise(values), "od.written", len(values), sorted(set(of.values) - set(values)))


def _skeleton(name: str, of: Of) -> File:
    return File(skeleton(of.head, of.objects, Path(name).name).encode(), "od.skeleton_written", len(of.objects))


def _configured(of: Of) -> None:
    if not of.values:
        raise OutputError("od.dcf_none", node=of.node)


FORMS: Final[dict[str, Callable[[str, Of], File]]] = {"dcf": _dcf, "concise_dcf": _concise, "skeleton": _skeleton}
"""By the names of their options."""
