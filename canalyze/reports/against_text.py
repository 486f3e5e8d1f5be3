"""Differences of a device from its description, as a table or as JSON lines.

JSON, the same in every language but for `text`; a test freezes the keys:
    od_difference   bus node file what severity index sub name described shown text frame
    od_against      bus node file error warning info objects seen unseen
`what` is the kind of difference, a key of `SEVERITIES` in `dictionary/against.py`; `described` is what the file says,
`shown` what the traffic shows. `sub` is null for a whole object. `od_against` comes last. Must not: judge.
"""

import os
from collections import Counter
from pathlib import Path
from typing import Final

from canalyze.dictionary.against import Comparison, Difference
from canalyze.output import Output, dyed, jsonl, printable
from canalyze.reports.table import EMPTY, Column, Row, Table
from canalyze.words import Words

_COLUMNS: Final = ("severity", "object", "name", "difference", "frame")


def show(held: Comparison, file: str, out: Output, words: Words) -> None:
    """Writes a heading, a table, and how much of the description the traffic shows."""
    counts = Counter(one.severity for one in held.differences)
    said = [dyed(words(f"check.{key}", count=counts[key]), key, out=out) for key in counts]
    told = words("check.then").join(said) or words("against.alike")
    out.text(words("against.head", node=held.node, name=printable(Path(file).name), said=told) + "\n")
    colours = {words.of("severity", key): key for key in counts}
    headings = (words(f"col.{key}") if key != "difference" else words("against.col") for key in _COLUMNS)
    columns = [
        Column(
            heading,
            right=key == "frame",
            folds=key in ("name", "difference"),
            leaves={"frame": 1, "name": 2}.get(key, 0),
            colour=colours.__getitem__ if key == "severity" else None,
        )
        for key, heading in zip(_COLUMNS, headings, strict=True)
    ]
    if held.differences:
        table = Table(columns, out, live=False)
        table.add([Row(_cells(one, words), number) for number, one in enumerate(held.differences)])
        table.close()
    unseen = len(held.unseen)
    out.text(words("against.seen", all=held.seen + unseen, seen=held.seen, unseen=unseen) + "\n")


def lines(held: Comparison, file: str, words: Words) -> bytes:
    """Returns the JSON lines."""
    head = {"bus": held.bus, "node": held.node, "file": os.fsencode(file).decode("utf-8", "backslashreplace")}
    found = [
        {"kind": "od_difference", **head}
        | {"what": one.kind, "severity": one.severity, "index": f"{one.index:04X}", "sub": one.sub, "name": one.name}
        | {"described": one.filed, "shown": one.shown, "text": _text(one, words), "frame": one.frame}
        for one in held.differences
    ]
    counts = Counter(one.severity for one in held.differences)
    figures = {"objects": held.seen + len(held.unseen), "seen": held.seen, "unseen": len(held.unseen)}
    last = {"kind": "od_against", **head, **{key: counts[key] for key in ("error", "warning", "info")}, **figures}
    return b"".join(map(jsonl.line, [*found, last]))


def _cells(one: Difference, words: Words) -> list[str]:
    place = f"{one.index:04X}h" + ("" if one.sub is None else f":{one.sub:02X}")
    frame = EMPTY if one.frame is None else str(one.frame)
    return [words.of("severity", one.severity), place, one.name or EMPTY, _text(one, words), frame]


def _text(one: Difference, words: Words) -> str:
    return words(f"against.{one.kind}", filed=one.filed, shown=one.shown)
