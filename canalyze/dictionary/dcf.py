"""Values that a device was configured with -> a DCF (CiA 306): a description with ParameterValue and a node-ID.

What stands in the description stays as it is: lines are put beside its own. Must not: know where the values come
from, or which of them are worth keeping.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

from canalyze.dictionary import read
from canalyze.dictionary.encoding import decode
from canalyze.dictionary.ini import Ini, Section, parse
from canalyze.dictionary.model import DOMAIN, VAR, Address
from canalyze.dictionary.objects import place
from canalyze.dictionary.values import spelled

_COMMISSIONING: Final = "DeviceComissioning"
"""As CiA 306 spells it."""


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
    found = read(description, name)
    entries = {(entry.index, entry.sub): entry for thing in found.objects for entry in thing.entries}
    variables = {thing.index for thing in found.objects if thing.code in (VAR, DOMAIN)}
    text = decode(description)[0]
    ending = "\r\n" if "\r\n" in text else "\n"
    sheet = _Sheet(text)
    left_out = []
    for address, data in sorted(values.items()):
        entry = entries.get(address)
        value = None if entry is None else spelled(data, entry.type)
        if value is None or not sheet.put(address, value, alone=address[0] in variables):
            left_out.append(address)
    sheet.keep(_COMMISSIONING, {"NodeID": str(node)})
    sheet.keep("FileInfo", keys)
    return Configured(ending.join(sheet.lines()), len(values) - len(left_out), tuple(left_out))


class _Sheet:
    """The lines of a description, and where its keys stand."""

    def __init__(self, text: str) -> None:
        self._lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")
        self._ini: Ini = parse(text)
        self._behind: dict[int, list[str]] = {}
        """Lines that come behind one, by its number."""
        self._further: dict[str, dict[str, str]] = {}
        """Keys of sections that are not there."""
        self._listed: dict[int, dict[str, str]] = {}
        """Values of arrays without sections of their own, by sub-index."""
        self._places = {
            (index, sub, part.lower()): section
            for section in self._ini.sections.values()
            if (found := place(section.name))
            for index, sub, part in [found]
        }

    def lines(self) -> list[str]:
        """Give all of them, a line end behind the last."""
        for index, values in self._listed.items():
            given = self._places.get((index, None, "value"))
            known = {key for key in (given.keys if given else ()) if key.isdecimal()}
            keys = {"NrOfEntries": str(len(known | set(values))), **values}
            self.keep(given.name if given else f"{index:04X}Value", keys)
        lines = []
        for number, line in enumerate(self._lines, 1):
            lines += [line, *self._behind.get(number, ())]
        for name, keys in self._further.items():
            lines += ["", f"[{name}]", *(f"{key}={value}" for key, value in keys.items())]
        return [*lines, ""]

    def put(self, address: Address, value: str, *, alone: bool) -> bool:
        """Give an object a ParameterValue; tell whether there is a place for it. alone: it is a variable."""
        index, sub = address
        head = self._places.get((index, None, ""))
        section = head if alone else self._places.get((index, sub, ""))
        if section is not None:
            self._set(section, "ParameterValue", value)
        elif head is not None and head.get("CompactSubObj"):
            self._listed.setdefault(index, {})[str(sub)] = value
        else:
            return False
        return True

    def keep(self, name: str, keys: Mapping[str, str]) -> None:
        """Give a section these keys; one that is not there comes at the end."""
        section = self._ini.section(name)
        for key, value in keys.items():
            if section is None:
                self._further.setdefault(name, {})[key] = value
            else:
                self._set(section, key, value)

    def _set(self, section: Section, key: str, value: str) -> None:
        line = f"{key}={value}"
        given = section.keys.get(key.lower())
        if given is not None and given.line:
            self._lines[given.line - 1] = line
            return
        last = max([section.line, *(one.line for one in section.keys.values())])
        self._behind.setdefault(last, []).append(line)
