"""Verdicts to write reports from: a plain one, and many with hostile names and words.

What it must not do: know a form of report. Hostile is what a capture, a file name or an override's reason can hold:
control characters, what XML cannot hold, halves of characters, commands of other programs, markup, Chinese, emptiness.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from msgspec.structs import replace

from canalyze.check.verdict import Counted, Verdict
from canalyze.records import SEVERITIES
from canalyze.records.problems import Finding, Line

FINDING = Finding(
    code="SDO001",
    name="toggle-bit",
    severity="error",
    file="samples/boot.log",
    frame=8,
    line=9,
    t="1700000000.003200",
    cause_frame=7,
    cause_line=8,
    bus="can0",
    node=10,
    index="1008",
    sub=0,
    message="node 10 1008h:00: toggle=0 from the server, 1 was due",
    facts={"expected": 1, "found": 0, "by": "server"},
    lines=(
        Line(7, "can0  60A   [8]  70 00 00 00 00 00 00 00  # segment request from the client (toggle=1)"),
        Line(8, 'can0  58A   [8]  00 4E 6F 70 65 6E 4E 6F  # segment 3 of data from the server: "NopenNo"'),
    ),
)


def one(finding: Finding = FINDING, count: int = 1, known: int = 0) -> Counted:
    cause = finding.cause_frame
    shown = tuple(
        replace(finding, frame=(finding.frame or 0) + step, cause_frame=None if cause is None else cause + step)
        for step in range(1, min(count, 10))
    )
    return Counted(finding, (finding, *shown), count, known)


TEXTS = [
    "",
    " ",
    "plain",
    "第8帧：翻转位错误，应为1",
    "\x00\x01\x08\x0b\x1b[31mred\x1b[0m\x7f\x85\x9f",
    "two\r\nlines\ttab",
    "\ufffe\uffff\ufdd0\U0001fffe \u2028\u2029\u202e\u200b\ufeff",
    "\udc80\udcff bytes of a name",
    "\ud800 half",
    "]]> <![CDATA[ <failure/> &amp; &#0; &lt; \"'",
    "::error file=x::y",
    "  ::stop-commands::z",
    "##[error]x ##[add-mask]y",
    "100%25%0A%%, a:b,c;d=e",
    "[link](https://example.org) [frame](1) {0} {{1}}",
    "# *bold* `code` | a | b",
    "C:\\captures\\a b.asc",
    "\\\\server\\share\\a.log",
    "../up/./a//b.log",
    "/abs/ü ß#?%41.log",
    "a:b.log",
    "-",
    "x" * 5000,
    "😀🚗",
]


def _finding(random_: random.Random, file: str) -> Finding:
    def some(*values: Any) -> Any:
        return random_.choice(values)

    text = random_.choice
    index, sub = some((None, None), ("1008", 0), ("6041", 255), ("FFFF", 3))
    frame = some(None, 1, 8, 10**12)
    return Finding(
        code=some("SDO001", "HBT004", "CAP001", "EXP001", "XXX999"),
        name=some("toggle-bit", "late", text(TEXTS)),
        severity=some(*SEVERITIES),
        file=file,
        frame=frame,
        line=some(None, 1, 2**40),
        t=some(None, "0.000000", text(TEXTS)),
        cause_frame=some(None, None, 3, frame),
        cause_line=some(None, 2),
        bus=some(None, "can0", text(TEXTS)),
        node=some(None, 1, 127),
        index=index,
        sub=sub,
        message=text(TEXTS) + text(TEXTS),
        lines=tuple(Line(number + 1, text(TEXTS)) for number in range(random_.randrange(9))),
    )


BLOCKS = [range(first, first + 25) for first in range(0, 150, 25)]
"""Seeds of `hostile` that the tests take together."""


def hostile(seed: int) -> list[Verdict]:
    """A set of captures; every seed another, always the same."""
    random_ = random.Random(seed)
    verdicts = []
    for _ in range(random_.randrange(6)):
        file = random_.choice(TEXTS)
        kinds: dict[tuple[object, ...], Counted] = {}
        for _ in range(random_.randrange(8)):
            finding = _finding(random_, file)
            count = random_.choice([1, 1, 2, 10, 1234])
            key = (finding.code, finding.bus, finding.node, finding.object)
            kinds.setdefault(key, one(finding, count, random_.choice([0, 0, 1, count])))
        below = [kind for kind in kinds.values() if kind.known >= kind.count or kind.finding.severity == "info"]
        verdicts.append(
            Verdict(
                file=file,
                failures=tuple(kind for kind in kinds.values() if kind not in below),
                others=tuple(below),
                overruled=random_.randrange(3),
                error=random_.choice([None, None, random_.choice(TEXTS)]),
                complaints=tuple(random_.choice(TEXTS) for _ in range(random_.randrange(3))),
                frames=random_.randrange(10**6),
                seconds=random_.choice([0.0, 0.0004, 12.3456, 98765.4321]),
            )
        )
    return verdicts


def many(count: int, severity: Any = "error", file: str = "a.log") -> Verdict:
    """One capture with findings of so many kinds."""

    def kinds() -> Iterator[Counted]:
        for number in range(count):
            yield one(replace(FINDING, file=file, severity=severity, index=f"{number:04X}"))

    return Verdict(file, failures=tuple(kinds()), frames=count)
