"""Lines of a text format for python-can's readers, one line at a time, so that one bad line costs only itself.

A reader of that library reads lines from an open file, and an exception in one ends it. Here it gets the lines through
`Lines`, which knows which line a message came from; behind one that raised, reading begins anew with the next. PEAK's
TRC has its header read here as well: the date is kept apart from the stamps, which keep their digits. Must not: import
python-can.
"""

import datetime
import re
from collections import deque
from collections.abc import Callable, Iterator
from decimal import Decimal, InvalidOperation
from typing import Final

_LONGEST: Final = 64 << 10
"""Longest line that is read; a longer one is none of these formats'."""
_EPOCH: Final = datetime.date(1899, 12, 30)
_TYPE: Final = "(?:Rx|Tx|Warng|Error)"
_ID: Final = "[0-9A-Fa-f]{3,8}"
_ROWS: Final[tuple[tuple[str, str, re.Pattern[str]], ...]] = tuple(
    (version, columns, re.compile(row))
    for version, columns, row in (
        ("1.0", "", rf"\d+\)\s+[\d.]+\s+{_ID}\s+\d\b"),
        ("1.1", "", rf"\d+\)\s+[\d.]+\s+{_TYPE}\s+{_ID}\s+\d\b"),
        ("1.3", "", rf"\d+\)\s+[\d.]+\s+\d\s+{_TYPE}\s+{_ID}\s+-\s+\d"),
        ("1.2", "", rf"\d+\)\s+[\d.]+\s+\d\s+{_TYPE}\s+{_ID}\s+\d\b"),
        ("2.1", "N,O,T,B,I,d,R,L,D", rf"\d+\s+[\d.]+\s+[A-Z]{{2}}\s+\d{{1,2}}\s+(?:{_ID}\s+)?{_TYPE}\s+-\s"),
        ("2.0", "N,O,T,I,d,l,D", rf"\d+\s+[\d.]+\s+[A-Z]{{2}}\s+(?:{_ID}\s+)?{_TYPE}\s"),
    )
)
"""How a row looks in each version, and its columns where the header would name them."""
_UNDECIDED: Final = 1000
"""Lines without a header and of no version's form that are read before it is taken for the first version."""
_NUMBER: Final = re.compile(r"(\d{1,12})(?:\)\s|\s+[\d.]+\s)")
_MARKS: Final = re.compile(r"^(?:[`|\s]|</?[A-Za-z][^<>]*>)+|(?:[`|\s]|</?[A-Za-z][^<>]*>)+$")
"""Mark-up around a row, as the core's readers have it."""
_CONTROL: Final = re.compile(r"[\0-\x08\x0a-\x1f\x7f]")
"""Bytes that no line of text has within it: a block of zeros, a newline that became something else."""
DAMAGED: Final = "\0"
"""What is handed out in place of a line with such bytes: no reader takes it for one of its lines."""
PASSED_OVER: Final = frozenset({"ST", "EC", "EV", "Warng", "FFFFFFFF"})
"""Types of rows that are no frames, as PEAK has them; error frames are told apart elsewhere."""
_FD_LENGTHS: Final = (*range(9), 12, 16, 20, 24, 32, 48, 64)
"""Data lengths by their codes."""
_REMARK: Final = re.compile(r"\s+(?:;|#|//|<-|\u2190).*$")
_VERSIONS: Final = frozenset({"1.0", "1.1", "1.2", "1.3", "2.0", "2.1"})


class Lines:
    """Bytes in, whole lines out, to a reader that takes this for an open text file."""

    def __init__(self, change: Callable[[str], str | None]) -> None:
        """Change: what a line becomes before it is handed out; None leaves it out."""
        self.number = 0
        """Of the line that was handed out last, from 1; 0 before the first and for what no line of the file is."""
        self.line = ""
        self.answered = True
        """Something came of the last line."""
        self.endless = 0
        """The number of a last line that lacks its end, and may be cut."""
        self.unanswered: Callable[[], None] = lambda: None
        """Called when a further line is wanted, and nothing came of the last one."""
        self.aside: Callable[[], bool] | None = None
        """Looks at the line that is to be handed out; what it takes for itself the reader never sees."""
        self._change = change
        self._lines: deque[tuple[int, str]] = deque()
        self._before: list[str] = []
        self._rest = ""
        self._taken = 0
        self._long = False

    def feed(self, data: bytes) -> None:
        """Take the next bytes."""
        *whole, rest = (self._rest + data.decode("latin-1")).split("\n")
        if self._long and whole:
            whole[0], self._long = "\0", False
        self._add(whole)
        self._rest = rest
        if len(rest) > _LONGEST:
            self._rest, self._long = "", True

    def end(self) -> None:
        """Take the end: a last line may lack its end."""
        if self._rest or self._long:
            self._add(["\0" if self._long else self._rest])
            self.endless = self._taken
            self._rest, self._long = "", False

    def _add(self, lines: list[str]) -> None:
        change, append = self._change, self._lines.append
        if lines and self._taken == 0:
            lines[0] = lines[0].removeprefix("\xef\xbb\xbf")
        for number, line in enumerate(lines, self._taken + 1):
            text = line.strip() if len(line) <= _LONGEST else "\0"
            changed = change(text) if text else None
            if changed is not None:
                append((number, changed))
        self._taken += len(lines)

    def begin(self, *lines: str) -> None:
        """Have these handed out before what is there."""
        self._before = [*lines]

    @property
    def waiting(self) -> bool:
        """Whether a line of the file is there."""
        return bool(self._lines)

    def __iter__(self) -> Iterator[str]:
        """Give what is there; its end is the end of the file to whoever reads."""
        lines = self._lines
        while True:
            if not self.answered:
                self.settle()
            if self._before:
                self.number, self.line = 0, self._before.pop(0)
            elif lines:
                self.number, self.line = lines.popleft()
                if self.aside and self.aside():
                    continue
                self.answered = False
            else:
                return
            yield self.line

    def __next__(self) -> str:
        """Give the next line alone."""
        return next(iter(self))

    def settle(self) -> None:
        """Say of the last line that nothing came of it, if so."""
        if not self.answered:
            self.answered = True
            self.unanswered()

    def close(self) -> None:
        """Do nothing: the reader closes what it has read to the end, and this is read on."""


class Trc:
    """The header of a TRC file, and what its columns are."""

    def __init__(self) -> None:
        """Nothing is known yet."""
        self.version = ""
        """As the file has it; empty for 1.0, which says none."""
        self.date_ns: int | None = None
        """The file's start in ns, civil time counted as if it were UTC; None if it is not said."""
        self.header: list[str] = []
        """What python-can has to see of it."""
        self.complete = False
        """A line behind it has come."""
        self.decided = False
        """The version is known, from the header or from the rows."""
        self._undecided = 0
        self._columns: list[str] = []
        self._point = (0, 0, 3)
        """Where the point and the end of the last stamp were, and the digits that it had."""

    @property
    def known(self) -> bool:
        """Whether the version is one that can be read."""
        return not self.version or self.version in _VERSIONS

    def change(self, line: str) -> str | None:
        """Take a line: those of the header are kept back, those of version 1.2 become what 1.3 would have."""
        if not line.isprintable() and is_damaged(line):
            return DAMAGED
        if line[0] in ">`|<" or line[-1] in "`|>":
            line = _MARKS.sub("", _unquoted(line))
            if not line:
                return None
        if not line.startswith(";"):
            self.complete = True
            if not self.decided:
                self._decide(line)
            if self.version.startswith("2") and _may_hold_remark(line):  # whose data are the rest of the line
                line = _REMARK.sub("", line)
            if line.count(".") > 1 and self._holds_two(line):
                return DAMAGED
            parts = line.split(None, 5) if self.version == "1.2" else []
            # Version 1.3 has a reserved column behind the identifier, and is else the same.
            return " ".join([*parts[:5], "-", parts[5]]) if len(parts) == 6 else line
        if self.complete:
            return None
        key, _, value = line.partition("=")
        value = value.strip()
        match key:
            case ";$FILEVERSION":
                self.version = value
                self.header.append(";$FILEVERSION=1.3" if value == "1.2" else line)
            case ";$STARTTIME":
                self.date_ns = _date(value)
                if self.date_ns is None and value.strip("0123456789.,"):
                    return DAMAGED
            case ";$COLUMNS":
                self._columns = value.split(",")
                self.header.append(line)
            case _ if key.startswith(";$"):  # there are no other keys
                return DAMAGED
            case _:
                pass
        return None

    def _holds_two(self, line: str) -> bool:
        """Tell whether a second row begins in a line: damage has made something else of the newline between them."""
        parts = line.split()
        numbers = (part.isdecimal() if self.version.startswith("2") else part.endswith(")") for part in parts[1:])
        stamps = (part.count(".") == 1 and part.replace(".", "").isdecimal() for part in parts[2:])
        return any(number and stamp for number, stamp in zip(numbers, stamps, strict=False))

    def size(self, line: str) -> int | None:
        """Give the data bytes that a row of CAN FD says it has; None where it says none."""
        parts = line.split(None, 12)
        for letter, lengths in (("l", None), ("L", _FD_LENGTHS)):
            at = self._at(letter, {})
            if at is not None and at < len(parts) and parts[at].isdecimal():
                value = int(parts[at][:3])
                return value if lengths is None else lengths[min(value, 15)]
        return None

    @property
    def numbered(self) -> bool:
        """Whether each row begins with its number."""
        return not self.version.startswith("2") or "N" in self._columns

    def _decide(self, line: str) -> None:
        """Find out the version by a row, where no header has named it, or has not named the columns."""
        if self.version and (self._columns or not self.version.startswith("2")):
            self.decided = True
            return
        self._undecided += 1
        for version, columns, row in _ROWS:
            if (self.version or version) == version and row.match(line):
                self._take(version, columns)
        self.decided = self.decided or self._undecided >= _UNDECIDED

    def _take(self, version: str, columns: str) -> None:
        if not self.decided and version != "1.0":
            self.version = version
            self.header.append(f";$FILEVERSION={'1.3' if version == '1.2' else version}")
            if columns:
                self._columns = columns.split(",")
                self.header.append(f";$COLUMNS={columns}")
        self.decided = True

    def _at(self, letter: str, place: dict[str, int]) -> int | None:
        if self.version.startswith("2"):
            return self._columns.index(letter) if letter in self._columns else None
        return place.get(self.version or "1.0")

    def decimals(self, line: str) -> int:
        """Give the digits behind the point that stamps of such a line have, in seconds."""
        begin, end, known = self._point
        if line[begin : begin + 1] == "." and line[end : end + 1] == " ":  # in columns, as mostly
            return known
        at = self._at("O", {}) if self.version.startswith("2") else 1
        parts = line.split(None, 9)
        stamp = parts[at] if at is not None and at < len(parts) else ""
        _, point, digits = stamp.partition(".")
        decimals = min(3 + len(digits), 9) if point else 3
        if point and at == 1:  # the first point of the line
            begin = line.index(".")
            self._point = (begin, begin + 1 + len(digits), decimals)
        return decimals

    def may_go_on(self, line: str) -> bool:
        """Tell whether a line that lacks its end may be the beginning of another frame's.

        Half a byte, or a length of 0 behind which `RTR` may have stood, whole or in part.
        """
        last = line.split()[-1]
        return not self.version.startswith("2") and (len(last) < 2 or last == "RT")

    def kind(self, line: str) -> str:
        """Give the type that the line names; empty if it names none."""
        parts = line.split()
        at = self._at("T", {"1.1": 2, "1.2": 3, "1.3": 3})
        if at is None:  # 1.0 has no types: a number that is no identifier
            return "FFFFFFFF" if len(parts) > 2 and parts[2] == "FFFFFFFF" else ""
        return parts[at] if at < len(parts) and parts[at].isalpha() else ""

    def seconds(self, line: str) -> float:
        """Give the line's stamp; ValueError if it has none."""
        at = self._at("O", {}) if self.version.startswith("2") else 1
        parts = line.split()
        if at is None or at >= len(parts):
            raise ValueError(line)
        return float(parts[at]) / 1000

    def channel(self, line: str) -> int:
        """Give the line's bus, 1 where it has none."""
        at = self._at("B", {"1.2": 2, "1.3": 2})
        parts = line.split()
        return int(parts[at]) if at is not None and at < len(parts) and parts[at].isdecimal() else 1


def is_damaged(line: str) -> bool:
    """Tell whether a line has bytes that no text has. Of a line that is printable it need not be asked."""
    return _CONTROL.search(line) is not None


def _may_hold_remark(line: str) -> bool:
    """Tell whether `_REMARK` has to look at a line."""
    return ";" in line or "#" in line or "/" in line or "<" in line or "\u2190" in line


def _unquoted(line: str) -> str:
    """Give a line without the marks of a quotation."""
    while line.startswith(("> ", ">\t", ">>")):
        line = line[1:].lstrip()
    return line


def number_of(row: str) -> int | None:
    """Give the number of a row; None if it has none."""
    found = _NUMBER.match(row)
    return int(found[1]) if found else None


class Rows:
    """The numbers of rows, and marks that some were left out."""

    def __init__(self) -> None:
        """No row has come."""
        self._last: int | None = None
        self._mark: tuple[int | None, int] | None = None

    def mark(self, rows: int, line: int) -> None:
        """Take a mark: how many rows it tells, -1 for none. Several in a row are one."""
        known, first = self._mark or (None, line)
        self._mark = (known if known is not None or rows < 0 else rows, first)

    def row(self, number: int | None, line: int) -> tuple[int | None, int, int | None] | None:
        """Take a row: give how many are missing before it, where that is, and the number before; None if none is."""
        last = self._last
        if number is None:
            # A row that cannot be read is one.
            self._last = None if last is None else last + 1
            return self.settle()
        self._last = number
        if last is None or number <= last + 1:
            return self.settle()
        self._mark = None
        return number - last - 1, line, last

    def settle(self) -> tuple[int | None, int, None] | None:
        """Give what a mark told, of which no number tells more."""
        mark, self._mark = self._mark, None
        return (*mark, None) if mark else None


def _date(days: str) -> int | None:
    """Give a start time, in days since the end of 1899, in ns.

    It has ten digits behind the point in PEAK's files, 8.6 µs: rounded to 10 µs, which gives back the ms that were
    meant.
    """
    try:
        units = int((Decimal(days) * 8_640_000_000).to_integral_value())
    except (InvalidOperation, ValueError, OverflowError):
        return None
    since = units - (datetime.date(1970, 1, 1) - _EPOCH).days * 8_640_000_000
    # Zero is what a program writes that knows no date.
    return since * 10_000 if 0 < abs(since) < 9 * 10**14 else None
