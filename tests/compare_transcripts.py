"""Compares what canalyze reads from third-party transcripts with what their authors say is in them.

    python tests/compare_transcripts.py [DIRECTORY]

DIRECTORY holds captures (`*.candump`, `*.log`), each with a JSON file of the same name that states the known
answers: a list `expected` of sentences ("upload 4/1017:00 = 0 (U16)") or a list `cases`, each with the number of
its frames, a sentence, and the assertions of the test it was taken from. Every capture must decode with exit status
0 and give as many frames as it has frame lines; every statement about an SDO answer must hold. Ends with 1 if one
does not, or if there was nothing to compare.

What it must not do: bring text of those files into this repository.
"""

from __future__ import annotations

import ast
import json
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from captures import SHARED, Row, decoded

DEFAULT_DIRECTORY = SHARED / "corpus" / "transcripts"

_FRAME_LINE = re.compile(
    r"""^\s*(\([\d .:-]+\)\s+)?                  # a stamp
        ( \S+\s+[0-9A-F]{3,8}\s+\[\d+\]          # console form
        | (\S+\s+)?[0-9A-Fa-f]{3,8}\#            # log form
        )""",
    re.VERBOSE,
)

_VALUE = re.compile(
    r"""(?P<direction>upload|download)\s (?:(?P<node>\d+)/)? (?P<index>[0-9A-F]{4}):(?P<sub>[0-9A-F]{2})
        (?:\sto\snode\s(?P<to_node>\d+))? [^=]*?\s=\s (?P<value>0x[0-9A-Fa-f]+|\d+|"[^"]*")""",
    re.VERBOSE,
)
_OF_TO = re.compile(r"(?P<index>[0-9A-F]{4}) (?P<direction>download) of (?P<value>\d+) to node (?P<node>\d+)")
_DATA = re.compile(
    r"(?P<direction>upload|download) (?P<index>[0-9A-F]{4}):(?P<sub>[0-9A-F]{2}).*-> data (?P<data>[0-9A-F]+)"
)
_ABORTED = re.compile(
    r"(?P<direction>upload|download) (?P<index>[0-9A-F]{4}):(?P<sub>[0-9A-F]{2})"
    r" aborted by (?P<by>\w+), code 0x(?P<code>[0-9A-F]{8})"
)
_DISABLED = re.compile(r"(?P<first>[0-9A-F]{4})\.\.(?P<last>[0-9A-F]{4}):(?P<sub>\d)(?=.*bit 31 set)")
_EMPTY = re.compile(r"segmented download of 0 bytes")
_ASSERTED = re.compile(r"self\.assertEqual\(\w+, (?P<literal>b?['\"].*['\"])\)$")


@dataclass(slots=True)
class Comparison:
    """What came of it."""

    files: int = 0
    frames: int = 0
    answers: int = 0
    wrong: list[str] = field(default_factory=list)

    def check(self, holds: bool, what: str) -> None:
        """One answer compared."""
        self.answers += 1
        if not holds:
            self.wrong.append(what)

    @property
    def summary(self) -> str:
        """One line, and one for each difference."""
        head = (
            f"{self.files} captures, {self.frames} frames, {self.answers} SDO answers compared, {len(self.wrong)} wrong"
        )
        return "\n".join([head, *self.wrong])


def frame_lines(text: str) -> int:
    """How many lines of a capture are frames, seen with nothing but a pattern."""
    return sum(1 for line in text.splitlines() if _FRAME_LINE.match(line))


def literal_value(text: str) -> bytes | int:
    """A value of a sentence: a number or the bytes of a string."""
    return text.strip('"').encode() if text.startswith('"') else int(text, 0)


def has_value(row: Row, value: bytes | int) -> bool:
    """Whether a transfer carried this value."""
    data = bytes.fromhex(row["data"])
    return data == value if isinstance(value, bytes) else int.from_bytes(data, "little") == value


def about(rows: list[Row], direction: str, index: str, sub: int | None, node: int | None) -> list[Row]:
    """The transfers of one object."""
    return [
        row
        for row in rows
        if (row["direction"], row["index"]) == (direction, index)
        and sub in (None, row["sub"])
        and node in (None, row["node"])
    ]


def statements(sentence: str, rows: list[Row]) -> Iterator[bool]:
    """Every statement about an SDO answer in one sentence, and whether it holds for these transfers."""
    if found := _VALUE.search(sentence):
        node = found["node"] or found["to_node"]
        ours = about(rows, found["direction"], found["index"], int(found["sub"], 16), int(node) if node else None)
        yield any(has_value(row, literal_value(found["value"])) for row in ours)
    if found := _OF_TO.search(sentence):
        ours = about(rows, found["direction"], found["index"], None, int(found["node"]))
        yield any(has_value(row, int(found["value"])) for row in ours)
    if found := _DATA.search(sentence):
        # the source knew the object's length; the frame does not say it, so the value only has to begin like this
        ours = about(rows, found["direction"], found["index"], int(found["sub"], 16), None)
        yield any(bytes.fromhex(row["data"]).startswith(bytes.fromhex(found["data"])) for row in ours)
    if found := _ABORTED.search(sentence):
        ours = about(rows, found["direction"], found["index"], int(found["sub"], 16), None)
        yield any(
            row["abort"] and (row["abort"]["code"], row["abort"]["by"]) == (found["code"], found["by"]) for row in ours
        )
    if _EMPTY.search(sentence):
        yield any(
            (row["direction"], row["mode"], row["size"], row["data"]) == ("download", "segmented", 0, "")
            for row in rows
        )
    for found in _DISABLED.finditer(sentence):
        for index in range(int(found["first"], 16), int(found["last"], 16) + 1):
            ours = about(rows, "download", f"{index:04X}", int(found["sub"]), None)
            yield any(int.from_bytes(bytes.fromhex(row["data"]), "little") >> 31 for row in ours)


def asserted(lines: list[str], rows: list[Row]) -> Iterator[bool]:
    """Every value that a test of the source asserts, and whether a transfer of the case has it."""
    for line in lines:
        if found := _ASSERTED.match(line):
            literal = ast.literal_eval(found["literal"])
            value = literal.encode() if isinstance(literal, str) else literal
            unknown_size = [row for row in rows if row["size_indicated"] is None]
            yield any(has_value(row, value) for row in rows) or any(
                bytes.fromhex(row["data"]).startswith(value) for row in unknown_size
            )


def compare_cases(name: str, cases: list[Row], rows: list[Row], frames: int, result: Comparison) -> None:
    """A capture that is a row of cases, each with its own frames."""
    if sum(case["frames"] for case in cases) != frames:
        result.wrong.append(f"{name}: the cases do not add up to the frames")
    first = 1
    for case in cases:
        beyond = first + case["frames"]
        ours = [row for row in rows if first <= row["first_frame"] < beyond]
        for holds in [*statements(case.get("expected", ""), ours), *asserted(case["asserts_in_source"], ours)]:
            result.check(holds, f"{name}: {case['case']}, frames {first} to {beyond - 1}: {ours}")
        first = beyond


def compare(directory: Path) -> Comparison:
    """Every capture of the directory."""
    result = Comparison()
    for capture in sorted([*directory.glob("*.candump"), *directory.glob("*.log")]):
        said = decoded(capture)
        lines = frame_lines(capture.read_text())
        result.files += 1
        result.frames += lines
        if len(said.frames) != lines:
            result.wrong.append(f"{capture.name}: {len(said.frames)} frames decoded, {lines} frame lines in the file")
        known = json.loads(capture.with_suffix(".json").read_text())
        for sentence in known.get("expected", []):
            for holds in statements(sentence, said.transfers):
                result.check(holds, f"{capture.name}: {sentence}")
        if "cases" in known:
            compare_cases(capture.name, known["cases"], said.transfers, lines, result)
    return result


def main() -> int:
    """The command line; the exit status."""
    result = compare(Path(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT_DIRECTORY)
    print(result.summary)
    return 1 if result.wrong or not result.answers else 0


if __name__ == "__main__":
    raise SystemExit(main())
