"""Properties of files for people: one block a file, a line a fact.

It computes nothing but units. What a file does not have is left out.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from msgspec import convert
from msgspec.structs import asdict

from canalyze.output import Output, printable
from canalyze.output.layout import definitions
from canalyze.records.info import Info, Opened, Topic
from canalyze.reports.summary_text import left_out_key
from canalyze.words import Words

_DOUBTFUL: Final = ("doubtful", "definition", "unlocated")
"""Kinds of damage whose frames are there, and may be wrong."""
_LISTED: Final = 20
"""Topics, buses, damages and the like that are shown of each; JSON has more."""


def show(row: Mapping[str, Any], out: Output, words: Words, *, first: bool) -> None:
    """Writes the block of one file, a blank line before it if it is not the first one."""
    record, opened = convert(row, Info), convert(row, Opened)
    rows: list[tuple[str, str]] = []
    before = ""
    for term, fact in _rows(record, opened, words):
        rows.append(("" if term == before else term, printable(fact)))
        before = term
    lines = [*([] if first else [""]), printable(record.file), *definitions(rows)]
    out.text("".join(f"{line}\n" for line in lines))


def _rows(record: Info, opened: Opened, words: Words) -> Iterator[tuple[str, str]]:
    """Returns term and fact; a term that comes again is written once."""
    contents = record.contents

    def row(key: str, fact: str) -> tuple[str, str]:
        return words(f"info.{key}"), fact

    key = "info.packed" if opened.compression else "info.plain"
    title = words.of("info.title", opened.format)
    fact = words(key, format=title, compression=opened.compression, size=f"{opened.size:,}")
    unchecked = [words("info.unchecked")] if opened.checked is False else []
    yield row("format_row", words("info.then").join([fact, *unchecked]))
    for name, value in contents.dialect.items():
        yield row("dialect", f"{name}: {value}")
    yield row("frames", _frames(record, words))
    for fact in _times(record, words):
        yield row("time", fact)
    for bus in record.buses[:_LISTED]:
        yield row("buses", words("info.bus", bus=bus.bus or words("info.nameless"), frames=bus.frames))
    yield from (row("buses", more) for more in _more(record.buses, len(record.buses), words))
    for topic in contents.topics[:_LISTED]:
        yield row("topics", _topic(topic, words))
    yield from (row("topics", more) for more in _more(contents.topics, len(contents.topics), words))
    if any(topic.messages and not topic.read_as for topic in contents.topics):
        yield row("topics", words("info.map"))
    for kind in contents.passed_over[:_LISTED]:
        yield row("passed_over", f"{kind.kind}: {kind.count}")
    yield from (row("passed_over", more) for more in _more(contents.passed_over, len(contents.passed_over), words))
    for fact in _quality(record, opened, words):
        yield row("quality", fact)


def _more(items: Sequence[object], count: int, words: Words) -> Iterator[str]:
    shown = min(len(items), _LISTED)
    if count > shown:
        yield words("info.more", count=count - shown)


def _frames(record: Info, words: Words) -> str:
    parts = [str(record.frames)]
    kinds = record.kinds
    parts += [words(f"info.{kind}", count=count) for kind, count in kinds.items() if count]
    parts += [words(f"info.{way}", count=count) for way, count in record.directions.items() if count]
    return words("info.then").join(parts)


def _times(record: Info, words: Words) -> Iterator[str]:
    if record.first_t is None:
        if record.frames:
            yield words("info.no_stamps")
        return
    if record.zone:
        zone = words(f"info.{record.zone}")
        yield words("info.dates", first=record.first_date, last=record.last_date, zone=zone)
    else:
        yield words("info.stamps", first=record.first_t, last=record.last_t)
    fewest, most = record.decimals or (0, 0)
    digits = str(most) if fewest == most else f"{fewest}-{most}"
    yield words("info.span", seconds=record.seconds, digits=digits)
    if record.unstamped:
        yield words("info.unstamped", count=record.unstamped)
    if record.backward:
        yield words("info.backward", count=record.backward, most=f"{record.backward_most_us / 1000:g}")


def _topic(topic: Topic, words: Words) -> str:
    kind = " ".join(part for part in (topic.schema, f"({topic.encoding})" if topic.encoding else "") if part)
    read = words("info.read_as", fields=topic.read_as) if topic.read_as else words("info.not_read")
    parts = [topic.name, kind, words("info.messages", count=topic.messages), read, topic.bus]
    return words("info.then").join(part for part in parts if part)


def _quality(record: Info, opened: Opened, words: Words) -> Iterator[str]:
    """Returns lines about losses."""
    unreadable = record.unreadable
    if unreadable:
        line, offset = unreadable.first_line, unreadable.first_offset
        if line is None and offset is None:
            yield words("info.unreadable_somewhere", count=unreadable.count)
        else:
            yield words("info.unreadable", count=unreadable.count, place=_place(line, offset, words))
        if unreadable.further_buses:
            yield words("info.further_buses", count=unreadable.further_buses)
    if record.clamped_stamps:
        yield words("info.clamped_stamps", count=record.clamped_stamps)
    if record.gaps:
        yield words("info.gaps", count=record.gaps, frames=record.dropped)
    left_out = record.left_out
    if left_out:
        yield words(f"info.{left_out_key(left_out)}", **asdict(left_out))
    if record.error_markers:
        yield words("info.error_markers", count=record.error_markers)
    for damage in record.damage[:_LISTED]:
        of_frames = "doubtful" if damage.kind in _DOUBTFUL else "lost"
        counted = {"bytes": "info.lost_bytes", "frames": f"info.{of_frames}_frames"}
        lost = [words(said, count=count) for key, said in counted.items() if (count := getattr(damage, key))]
        fact = words(
            "info.damage",
            place=_place(damage.line, damage.offset, words),
            kind=words.of("damage", damage.kind),
        )
        yield words("info.then").join([fact, *lost])
    yield from _more(record.damage, record.damages, words)
    if opened.format == "mcap" and any(damage.kind == "cut" for damage in record.damage):
        yield words("info.unfinished", name=record.file)
    wrong = ("unreadable", "clamped_stamps", "gaps", "left_out", "error_markers", "damages")
    if not any(getattr(record, key) for key in wrong):
        yield words("info.whole")


def _place(line: int | None, offset: int | None, words: Words) -> str:
    return words("info.line", line=line) if line is not None else words("info.offset", offset=offset)
