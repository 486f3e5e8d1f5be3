"""Explanations of failed assertions: differences of transfers and findings, annotated lines, problems.

pytest keeps the values of an assertion's parts in the frame that raised it; those of a capture are taken from there.
It must not make a test fail, nor raise.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

from msgspec.structs import fields

from canalyze.errors import CanalyzeError
from canalyze.library.capture import Capture, Series
from canalyze.library.rows import Findings, Problems, Rows, Transfers
from canalyze.output import printable
from canalyze.records.frames import Signal
from canalyze.records.objects import Transfer
from canalyze.records.problems import Finding, Line, Problem
from canalyze.words import Words

if TYPE_CHECKING:
    import pytest

_SHOWN: Final = 5
"""Findings or transfers whose lines are shown."""
_CAPTURES: Final = 3
"""Captures of which it is told what stands in them."""
_LISTED: Final = 10
"""Items of a list that are named."""
_LINES: Final = 8
"""Frames that are shown at each end of a range."""
_BEFORE: Final = 3
"""Frames before the one that matters."""

Range = tuple[int, int]


def compared(op: str, left: object, right: object, words: Words) -> list[str] | None:
    """Explains a comparison of transfers, findings or lists of them; None for everything else."""
    if op != "==":
        return None
    if isinstance(left, Transfer) and isinstance(right, Transfer):
        return [f"{left!r} == {right!r}", *_fields(left, right, words)]
    if isinstance(right, Rows) and not isinstance(left, Rows):
        left, right = right, left
    if not isinstance(left, Rows) or not isinstance(right, Sequence) or isinstance(right, str | bytes):
        return None
    said = [f"{left!r} == {right!r}" if isinstance(right, Rows) else f"{left!r} == ..."]
    if isinstance(left, Series) and any(isinstance(one, int | float) for one in right):
        return [*said, words("test.values")]
    if len(left) != len(right):
        said.append(words("test.rows", left=len(left), right=len(right)))
    if isinstance(left, Findings):
        said += (_finding(one) for one in left[:_LISTED])
        return said + _more(len(left) - _LISTED, words)
    if isinstance(left, Problems):
        said += (f"  {_incident(one)}" for one in left[:_LISTED])
        return said + _more(len(left) - _LISTED, words)
    for place, (one, other) in enumerate(zip(left, right, strict=False)):
        if one != other:
            said.append(words("test.at", place=place))
            both = isinstance(one, Transfer) and isinstance(other, Transfer)
            said += _fields(one, other, words) if both else [f"  {one!r}", f"  {other!r}"]
            return said
    said += (f"  {one!r}" for one in left[len(right) :][:_LISTED])
    return said


def _fields(left: Transfer, right: Transfer, words: Words) -> list[str]:
    both = ((one.name, getattr(left, one.name), getattr(right, one.name)) for one in fields(Transfer))
    return [
        "  " + words("test.field", name=name, left=repr(one), right=repr(other))
        for name, one, other in both
        if one != other
    ]


def _finding(finding: Finding) -> str:
    where = f", frame {finding.about_frame}" if finding.about_frame else ""
    return f"{finding.code} {finding.severity}{where}: {finding.message}"


def _incident(one: Problem) -> str:
    return f"{one.kind} {one.status}, frame {one.begin.frame}: {one.message}"


def _more(count: int, words: Words) -> list[str]:
    return [words("test.more", count=count)] if count > 0 else []


def sections(
    failure: "pytest.ExceptionInfo[BaseException]", opened: Iterable[Capture], words: Words
) -> list[tuple[str, str]]:
    """Returns sections for the report: annotated lines of the objects of the assertion that failed."""
    entry = failure.traceback[-1]
    local = entry.frame.f_locals
    statement = str(entry.statement)
    parts = [
        value
        for name, value in local.items()
        if name.startswith("@py_assert") or re.search(rf"(?<![\w.]){re.escape(name)}\b", statement)
    ]
    everything = [value for one in failure.traceback for value in one.frame.f_locals.values()]
    captures = list({id(one): one for one in [*opened, *everything] if _is(one, Capture)}.values())
    return list(_sections(parts, captures, statement, words))


def _sections(parts: list[Any], captures: list[Capture], statement: str, words: Words) -> Iterator[tuple[str, str]]:
    """One section for each kind of thing; of lists, the one that was evaluated last is the narrowest."""
    findings = _last(parts, Finding, Findings)
    transfers = _last(parts, Transfer, Transfers)
    signals = _last(parts, Signal, Series)
    whole = next((one for one in parts if _is(one, Capture)), None)
    if not (findings or transfers or signals) and whole is not None:
        # all(... for one in capture.transfers): pytest keeps no list of those.
        findings, transfers = _loaded(whole, transfers=".transfers" in statement)
    if findings:
        blocks = [(_finding(one), one.lines or _around(one)) for one in findings[:_SHOWN]]
        yield words("test.findings"), _shown(blocks, findings, captures, words)
    if transfers:
        wrong = [one for one in transfers if one.status != "ok"] or transfers
        blocks = [(repr(one), [(one.first_frame - 1, one.last_frame + 1)]) for one in wrong[:_SHOWN]]
        yield words("test.transfers"), _shown(blocks, wrong, captures, words)
    if signals:
        numbers = [one for one in signals if isinstance(one.value, int | float)]
        ends = {min(numbers, key=_value).frame, max(numbers, key=_value).frame} if numbers else {signals[0].frame}
        name = f"{signals[0].node}.{signals[0].pdo}.{signals[0].signal}"
        blocks = [(name, [(frame, frame) for frame in sorted(ends)])]
        yield words("test.signals"), _shown(blocks, signals[:1], captures, words)
    if incidents := _last(parts, Problem, Problems):
        capture = next((one for one in captures if one.gave(incidents[0])), None)
        known = {one.id for one in incidents}
        first = [one for one in incidents if one.cause is None or one.cause.id not in known]
        yield words("test.problems"), "\n".join(_told(capture, first, words))
        return
    for capture in captures[:_CAPTURES]:
        if lines := _told(capture, None, words):
            yield words("test.open", name=printable(capture.name)), "\n".join(lines)


def _told(capture: Capture | None, incidents: list[Problem] | None, words: Words) -> list[str]:
    """Returns the lines of `diagnose` about problems, or about the open ones."""
    if capture is None:
        return [_incident(one) for one in incidents or ()]
    try:
        asked = list(capture.problems.roots.open) if incidents is None else incidents
        return capture.diagnosis(asked[:_SHOWN]) + _more(len(asked) - _SHOWN, words)
    except CanalyzeError as error:
        return [words("test.unread", problem=error.in_words(words))] if incidents else []


def _is(value: object, kind: type) -> bool:
    """Returns true if the type itself is this one: a mock of it has nothing to show."""
    return issubclass(type(value), kind)


def _last(parts: list[Any], one: type, several: type[Rows[Any]]) -> list[Any]:
    """Returns the objects of a kind, or those of the last list of them."""
    single = {id(part): part for part in parts if _is(part, one)}
    lists = [part for part in parts if _is(part, several)]
    return list(single.values()) or (list(lists[-1]) if lists else [])


def _loaded(capture: Capture, *, transfers: bool) -> tuple[list[Finding], list[Transfer]]:
    """Returns the findings of a capture, or its transfers."""
    try:
        if transfers:
            return [], [one for one in capture.transfers if one.status != "ok"]
        return list(capture.findings.at_least("warning")), []
    except CanalyzeError:
        return [], []


def _value(signal: Signal) -> float:
    return signal.value if isinstance(signal.value, int | float) else 0.0


def _around(finding: Finding) -> list[Range]:
    """Returns the frames that may have led to a finding that comes without lines."""
    if finding.frame is None:
        return []
    near = max(finding.frame - _BEFORE, 1)
    cause = finding.cause_frame or near
    return [(cause, finding.frame)] if near <= cause + _LINES else [(cause, cause), (near, finding.frame)]


Block = tuple[str, Sequence[Line] | list[Range]]
"""A title, and its lines, or the frames whose lines are to be read."""


def _shown(blocks: Sequence[Block], rows: Sequence[Any], captures: list[Capture], words: Words) -> str:
    """Returns each with its lines below; missing lines are read in one pass."""
    wanted = [part for _, below in blocks for one in below if not isinstance(one, Line) for part in _ends(one)]
    capture = next((one for one in captures if one.gave(rows[0])), None)
    lines: dict[int, list[Line]] = {}
    said: list[str] = []
    if capture is not None and wanted:
        try:
            for line in capture.annotated(wanted):
                lines.setdefault(line.frame, []).append(line)
        except CanalyzeError as error:
            said.append(words("test.unread", problem=error.in_words(words)))
    for title, below in blocks:
        said.append(title)
        for one in below:
            if isinstance(one, Line):
                said.append(f"  {one.text}")
                continue
            parts = _ends(one)
            for place, (first, last) in enumerate(parts):
                if place:
                    said.append(f"  {words('test.cut', count=first - parts[0][1] - 1)}")
                said += (f"  {line.text}" for frame in range(first, last + 1) for line in lines.get(frame, ()))
    return "\n".join([*said, *_more(len(rows) - len(blocks), words)])


def _ends(one: Range) -> list[Range]:
    """Returns a range of frames, of a long one only both ends."""
    first, last = max(one[0], 1), one[1]
    return [(first, last)] if last - first < 2 * _LINES else [(first, first + _LINES - 1), (last - _LINES + 1, last)]
