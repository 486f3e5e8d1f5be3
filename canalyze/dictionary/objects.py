"""The sections of objects -> objects, with what CompactSubObj and CompactPDO stand for, and every key that is needed.

A key that is missing or cannot be gets what is most likely meant, and a defect says so. Must not: know what a mapping
or a COB-ID means.
"""

import re
from collections.abc import Iterator
from typing import Final, cast

from canalyze.dictionary.compact import implied
from canalyze.dictionary.ini import Ini, Key, Section
from canalyze.dictionary.model import ARRAY, DEFSTRUCT, DEFTYPE, DOMAIN, NULL, RECORD, VAR, Access, Entry, Object
from canalyze.dictionary.values import NAMES, OPAQUE, UNSIGNED8, Values, integer, without_comment

_MOST_ENTRIES: Final = 30_000
"""CompactSubObj lets a small file claim millions; no device has a third of it."""
_FIRST_OBJECT: Final = 0x1000
_LISTS: Final = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
_SECTION: Final = re.compile(
    r"(?P<index>(?:0x)?[0-9a-f]{1,4})"
    r"(?:\s*sub\s*0*(?P<sub>[0-9a-f]{1,2})|\s*(?P<part>name|value|denotation|objectlinks))?",
    re.IGNORECASE,
)
_ACCESSES: Final = frozenset({"ro", "wo", "rw", "rwr", "rww", "const"})
_ALMOST: Final = {"r": "ro", "w": "wo", "r/w": "rw", "wr": "rw", "read": "ro", "write": "wo", "readonly": "ro"}


class _Parts:
    """All sections of one index."""

    __slots__ = ("head", "names", "subs", "values")

    def __init__(self) -> None:
        self.head: Section | None = None
        self.subs: dict[int, Section] = {}
        self.names: Section | None = None
        self.values: Section | None = None


class Objects:
    """All sections of objects of one file."""

    def __init__(self, ini: Ini, values: Values, *, has_lists: bool) -> None:
        """Find them among the sections. `has_lists`: the form of the file has lists of its objects."""
        self._ini = ini
        self._has_lists = has_lists
        self._values = values
        self._parts: dict[int, _Parts] = {}
        self._types: dict[int, _Parts] = {}
        self._found: dict[int, Object] = {}
        self._count_of_entries = 0
        for section in list(ini.sections.values()):
            self._find(section)

    def _find(self, section: Section) -> None:
        match = _SECTION.fullmatch(section.name)
        if match is None or (match["sub"] is None and match["part"] is None and len(match["index"]) < 4):
            if re.match(r"[0-9a-f]{4}(?![0-9a-z])|[0-9a-f]{4}sub", section.name, re.IGNORECASE):
                self._ini.complain(section.line, "section-unused", section=section.name[:60])
            return
        # It is kept here alone, for as long as it takes to write it anew.
        self._ini.sections.pop(section.name.lower(), None)
        index = int(match["index"], 16)
        if "x" in section.name.lower() or len(section.name.split()) > 1:
            read = f"{index:04X}" + (f"sub{int(match['sub'], 16):X}" if match["sub"] else match["part"] or "")
            self._ini.complain(section.line, "section-name", section=section.name[:60], read=read)
        table = self._parts if index >= _FIRST_OBJECT else self._types
        parts = table.setdefault(index, _Parts())
        if match["sub"] is not None:
            sub = int(match["sub"], 16)
            parts.subs[sub] = self._joined(parts.subs.get(sub), section)
        elif match["part"] is None:
            parts.head = self._joined(parts.head, section)
        elif match["part"].lower() == "name":
            parts.names = self._joined(parts.names, section)
        elif match["part"].lower() == "value":
            parts.values = self._joined(parts.values, section)

    def _joined(self, earlier: Section | None, later: Section) -> Section:
        """Join two spellings of one section, such as sub1 and sub01; of keys in both the later one counts."""
        if earlier is None:
            return later
        self._ini.complain(later.line, "duplicate-section", section=later.name, first=earlier.line)
        return Section(earlier.name, earlier.line, earlier.keys | later.keys)

    def read(self, compact_pdo: int, pdos: tuple[int, int]) -> dict[int, Object]:
        """Read all objects, by index; `pdos` are the numbers of RPDOs and TPDOs that exist implicitly by CompactPDO."""
        lists = self._listed()
        for index in sorted(self._parts):
            self._object(index, self._parts[index], lists)
        for index, name, subs in implied(compact_pdo, pdos, set(self._parts)):
            made = {sub: {key.lower(): Key(key, text, 0) for key, text in keys.items()} for sub, keys in subs.items()}
            entries = [self._entry(index, sub, Section(name, 0, keys), 0) for sub, keys in made.items()]
            self._put(index, name, RECORD, entries, 0)
        return dict(sorted(self._found.items()))

    def _put(self, index: int, name: str, code: int, entries: list[Entry], line: int) -> None:
        self._found[index] = Object(index, name, code, tuple(entries), line)
        self._count_of_entries += len(entries)

    def _listed(self) -> set[int] | None:
        """Give the indices in the lists, None if the file has no list; say which of them have no section."""
        found: dict[int, tuple[str, Key]] = {}
        lists = [section for name in _LISTS if (section := self._ini.section(name))]
        for section in lists:
            entries = [key for key in section.keys.values() if key.name.isdecimal()]
            for key in entries:
                index = self._values.whole(key)
                if index is not None:
                    found[index] = (section.name, key)
            self._count(section.keys.get("supportedobjects"), section.name, len(entries))
        for index, (name, key) in found.items():
            if index not in self._parts:
                self._ini.complain(key.line, "not-there", object=f"{index:04X}h", section=name)
        if not lists and self._parts and self._has_lists:
            self._ini.complain(0, "no-lists")
        return set(found) if lists else None

    def _count(self, key: Key | None, section: str, found: int) -> None:
        said = self._values.whole(key)
        if key and said is not None and said != found:
            self._ini.complain(key.line, "count", section=section, key=key.name, said=said, found=found)

    def _object(self, index: int, parts: _Parts, lists: set[int] | None) -> None:
        head, ini = parts.head, self._ini
        if head is None:
            if not parts.subs:
                return  # names or values of nothing; what lists it is said already
            first = next(iter(parts.subs.values()))
            ini.complain(first.line, "no-index-section", object=f"{index:04X}h")
            head = Section(f"{index:04X}", first.line)
            head.keys = {"parametername": Key("ParameterName", f"{index:04X}", 0), "objecttype": Key("", "9", 0)}
        if lists is not None and index not in lists:
            ini.complain(head.line, "unlisted", object=f"{index:04X}h")
        compact = min(max(self._values.whole(head.get("CompactSubObj")) or 0, 0), 254)
        code = self._code(index, head, bool(parts.subs or compact))
        if code in (NULL, DEFTYPE, DEFSTRUCT):
            return
        if self._count_of_entries >= _MOST_ENTRIES:
            ini.complain(head.line, "too-many", object=f"{index:04X}h", most=_MOST_ENTRIES)
            return
        if code in (VAR, DOMAIN):
            entry, kind = self._typed(f"{index:04X}h", index, 0, head, head.line, code)
            self._put(index, entry.name, DOMAIN if code == DOMAIN and kind == OPAQUE else VAR, [entry], head.line)
            return
        name = self._name(head)
        if not compact:
            self._count(head.get("SubNumber"), f"{index:04X}", len(parts.subs))
        entries: list[Entry] = []
        for sub in sorted({*parts.subs, *range(compact + 1 if compact else 0)}):
            if self._count_of_entries + len(entries) >= _MOST_ENTRIES:
                ini.complain(head.line, "too-many", object=f"{index:04X}h", most=_MOST_ENTRIES)
                break
            section = parts.subs.get(sub) or self._compact(head, sub, compact)
            entries.append(self._entry(index, sub, self._with_lists(section, sub, parts), head.line))
        else:
            self._say_strays(parts, {*parts.subs, *range(compact + 1)} if compact else set(parts.subs))
        self._put(index, name, code, entries, head.line)

    def _code(self, index: int, head: Section, has_subs: bool) -> int:
        key = head.get("ObjectType")
        code = self._values.whole(key)
        read = code
        if code is None:
            read = RECORD if has_subs and head.get("SubNumber") else ARRAY if has_subs else VAR
        elif code in (VAR, DOMAIN) and has_subs:
            read = ARRAY if head.get("CompactSubObj") else RECORD
        elif code not in (NULL, DOMAIN, DEFTYPE, DEFSTRUCT, VAR, ARRAY, RECORD):
            read = RECORD if has_subs else VAR
        if key and code is not None and read != code:
            self._ini.complain(key.line, "object-type", object=f"{index:04X}h", value=code, read=read)
        assert read is not None
        return read

    def _compact(self, head: Section, sub: int, last: int) -> Section:
        """Give the section that CompactSubObj stands for."""
        if sub == 0:
            fixed = {"ParameterName": "Number of entries", "DataType": "5", "AccessType": "ro"}
            fixed["DefaultValue"] = str(last)
            return Section(head.name, head.line, {key.lower(): Key(key, value, 0) for key, value in fixed.items()})
        section = Section(head.name, head.line, dict(head.keys))
        if sub > 1:
            name = head.text("ParameterName") or ""
            section.keys["parametername"] = Key("ParameterName", f"{name}_{sub:x}", head.line)
            # What is odd about the section's keys is said once, of sub 1.
            section = _silent(section)
        return section

    def _with_lists(self, section: Section, sub: int, parts: _Parts) -> Section:
        """Put the entry of [xxxxName] and [xxxxValue] into a section."""
        for place, key in ((parts.names, "ParameterName"), (parts.values, "ParameterValue")):
            given = _numbered(place).get(sub)
            if given and given.value:
                section = Section(section.name, section.line, section.keys | {key.lower(): given})
        return section

    def _say_strays(self, parts: _Parts, subs: set[int]) -> None:
        for place in (parts.names, parts.values):
            for sub, key in _numbered(place).items():
                if place and sub not in subs:
                    self._ini.complain(key.line, "no-such-sub", section=place.name, sub=f"{sub:02X}h")

    def _entry(self, index: int, sub: int, keys: Section, line: int) -> Entry:
        """Read one entry of an array or record, whose own section begins on `line`."""
        return self._typed(f"{index:04X}h:{sub:02X}", index, sub, keys, line, VAR)[0]

    def _typed(self, where: str, index: int, sub: int, keys: Section, line: int, code: int) -> tuple[Entry, int]:
        """Read one entry; give it and the type that its values have, which is none of the file's own."""
        values = self._values
        given = self._type(where, sub, keys, code)
        kind = self._resolved(where, given, keys)
        # Of the values of a type that nobody knows nothing more is to be said.
        filled = _silent(keys) if kind == OPAQUE != given else keys
        low, high = (values.limit(filled.get(name), kind) for name in ("LowLimit", "HighLimit"))
        name, access = self._name(keys), self._access(where, keys)
        default, parameter = (values.value(filled.get(name), kind) for name in ("DefaultValue", "ParameterValue"))
        mappable = bool(values.whole(keys.get("PDOMapping")))
        factor = values.real(keys.get("Factor"))
        entry = Entry(
            *(index, sub, name, given, access, default, parameter, mappable, low, high),
            unit=keys.text("Unit") or "",
            factor=1.0 if factor is None else factor,
            line=keys.line or line,
        )
        return entry, kind

    def _name(self, keys: Section) -> str:
        """Give the name; without one, that of the section."""
        name = keys.text("ParameterName")
        if not name:
            self._missing(keys, "ParameterName", keys.name)
        return name or keys.name

    def _missing(self, keys: Section, key: str, read: str) -> None:
        if keys.line:
            self._ini.complain(keys.line, "missing-key", section=keys.name, key=key, read=read)

    def _type(self, where: str, sub: int, keys: Section, code: int) -> int:
        kind = self._values.whole(keys.get("DataType"))
        if kind is not None and 0 <= kind <= 0xFFFF:
            return kind
        if code == DOMAIN:
            return OPAQUE
        guess = UNSIGNED8 if sub == 0 and where.count(":") else 0
        if not keys.get("DataType"):
            self._missing(keys, "DataType", f"{guess or OPAQUE:04X}h")
        return guess

    def _resolved(self, where: str, kind: int, keys: Section) -> int:
        """Give a type of CiA 301: one that the file defines itself is what it is made of."""
        if kind in NAMES:
            return kind
        definition = (self._types.get(kind) or self._parts.get(kind) or _Parts()).subs.get(1)
        made_of = definition and integer((definition.get("DefaultValue") or Key("", "", 0)).value)
        if made_of and made_of.value in NAMES:
            return made_of.value
        key = keys.get("DataType")
        if key and key.line:
            self._ini.complain(key.line, "unknown-type", object=where, type=f"{kind:04X}h")
        return OPAQUE

    def _access(self, where: str, keys: Section) -> Access:
        key = keys.get("AccessType")
        if key is None:
            self._missing(keys, "AccessType", "rw")
            return "rw"
        access = key.value.lower()
        if access in _ACCESSES:
            return cast(Access, access)
        bare = re.sub(r"[\s_-]", "", without_comment(access))
        read = bare if bare in _ACCESSES else _ALMOST.get(bare, "rw")
        if key.line:
            self._ini.complain(key.line, "access", object=where, value=key.value[:60], read=read)
        return cast(Access, read)


def _silent(section: Section) -> Section:
    """Give a copy whose keys have no line, so that nothing is said of them."""
    return Section(section.name, 0, {name: Key(key.name, key.value, 0) for name, key in section.keys.items()})


def _numbered(section: Section | None) -> dict[int, Key]:
    """Give the entries of [xxxxName] and [xxxxValue], whose keys are sub-indices in decimal; gaps are allowed."""
    keys: Iterator[Key] = iter(section.keys.values() if section else ())
    return {int(key.name): key for key in keys if key.name.isdecimal() and len(key.name) <= 3 and int(key.name) <= 255}
