"""Whatever is done to a good description, reading it gives a description or our one-line error, and nothing else."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path

import pytest

from canalyze.dictionary import read
from canalyze.errors import SourceError
from canalyze.reports.dictionary import defect_line, json_lines
from canalyze.words import Words

OWN = Path(__file__).parent.parent / "eds"
SEEDS = range(150)
XML = b"""<?xml version="1.0"?><C><CANopenObjectList><CANopenObject index="1800" name="c" objectType="9" subNumber="2">
<CANopenSubObject subIndex="00" name="n" objectType="7" dataType="0005" accessType="const" defaultValue="1"/>
<CANopenSubObject subIndex="01" name="i" objectType="7" dataType="0007" accessType="rw" defaultValue="$NODEID+0x180"/>
</CANopenObject></CANopenObjectList></C>"""

ODD_VALUES = (
    b"",
    b"$NODEID",
    b"$NODEID+$NODEID",
    b"0x" + b"F" * 50,
    b"-" + b"9" * 400,
    b"1" * 5000,
    b"nan",
    b"0b1",
    b"1_0",
    b"\xd9\xa3",  # an Arabic digit
    b"\xff\xfe",
    b"a=b=c",
    b"[x]",
    b"%(x)s",
    b" ; only a comment",
    b"{facts}",
)
ODD_LINES = (
    b"[DEFAULT]",
    b"[]",
    b"[",
    b"]",
    b"=",
    b"= x",
    b"[1800sub1]",
    b"[1A00Name]",
    b"[1A00Value]",
    b"[10000]",
    b"[1800subFFFF]",
    b"[0005]",
    b"[5sub1]",
    b"CompactSubObj=254",
    b"CompactPDO=0xFFFF",
    b"NrOfRXPDO=100000",
    b"ObjectType=2",
    b"ObjectType=6",
    b"DataType=0x1A00",
    b"Lines=99999999999",
    b"Line99999999999=x",
    b"\x00",
    b"\x85\x1c\xe2\x80\xa8",
)


def value_changed(text: bytes, pick: random.Random) -> bytes:
    rows = text.split(b"\n")
    place = pick.randrange(len(rows))
    rows[place] = rows[place].partition(b"=")[0] + b"=" + pick.choice(ODD_VALUES)
    return b"\n".join(rows)


def line_put_in(text: bytes, pick: random.Random) -> bytes:
    rows = text.split(b"\n")
    rows.insert(pick.randrange(len(rows)), pick.choice(ODD_LINES))
    return b"\n".join(rows)


def line_moved(text: bytes, pick: random.Random) -> bytes:
    rows = text.split(b"\n")
    rows.insert(pick.randrange(len(rows)), rows.pop(pick.randrange(len(rows))))
    return b"\n".join(rows)


def line_twice_or_lost(text: bytes, pick: random.Random) -> bytes:
    rows = text.split(b"\n")
    place = pick.randrange(len(rows))
    rows[place : place + 1] = [rows[place]] * pick.choice((0, 2))
    return b"\n".join(rows)


def bytes_changed(text: bytes, pick: random.Random) -> bytes:
    changed = bytearray(text)
    for _ in range(pick.randrange(1, 20)):
        changed[pick.randrange(len(changed))] = pick.randrange(256)
    return bytes(changed)


def cut(text: bytes, pick: random.Random) -> bytes:
    start = pick.randrange(len(text))
    return text[:start] + text[start + pick.randrange(len(text)) :] or b"[1000]"


def sections_shuffled(text: bytes, pick: random.Random) -> bytes:
    sections = text.split(b"\n[")
    pick.shuffle(sections)
    return b"\n[".join(sections)


MUTATIONS: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    value_changed,
    value_changed,
    line_put_in,
    line_put_in,
    line_moved,
    line_twice_or_lost,
    bytes_changed,
    cut,
    sections_shuffled,
)


def texts() -> list[bytes]:
    return [path.read_bytes() for path in sorted(OWN.glob("*.eds"))]


@pytest.mark.parametrize("seed", SEEDS)
def test_any_mutation_is_read_or_refused(seed: int) -> None:
    pick = random.Random(seed)
    text = pick.choice(texts())
    for _ in range(pick.choice((1, 3, 30))):
        text = pick.choice(MUTATIONS)(text, pick)
    read_and_show(text)


@pytest.mark.parametrize("seed", SEEDS)
def test_any_mutation_of_xml_is_read_or_refused(seed: int) -> None:
    pick = random.Random(seed)
    text = XML
    for _ in range(pick.choice((1, 2, 5))):
        text = pick.choice((bytes_changed, cut, line_twice_or_lost, line_moved))(text, pick) or XML
    read_and_show(text)


def test_any_bytes_are_read_or_refused() -> None:
    pick = random.Random(0)
    for size in range(200):
        read_and_show(pick.randbytes(size))
        read_and_show(b"[2000]\n" + pick.randbytes(size))


def read_and_show(text: bytes) -> None:
    try:
        found = read(text, "x.eds", 5)
    except SourceError as error:
        assert error.key in {"eds.nothing", "eds.xml", "eds.doctype", "source.empty"}
        assert "\n" not in str(error)
        return
    assert [json.loads(line)["file"] for line in json_lines(found)]
    for words in (Words("zh"), Words("en")):
        assert all(defect_line(defect, found.file, words) for defect in found.defects)


def test_the_order_of_sections_does_not_matter() -> None:
    for text in texts():
        head, *sections = text.split(b"\n[")
        random.Random(1).shuffle(sections)
        mixed = b"\n[".join([head, *sections])
        given, shuffled = read(text, "x.eds"), read(mixed, "x.eds")
        assert shuffled.defects == ()
        values = [
            [(e.index, e.sub, e.name, e.value) for o in found.objects for e in o.entries] for found in (given, shuffled)
        ]
        assert values[0] == values[1]
        assert [pdo.mapped for pdo in given.pdos] != [] and len(given.pdos) == len(shuffled.pdos)
