"""The wording of findings for pages of other programs, shared by the JUnit, SARIF and GitHub reports.

All text that leaves here is one printable line: what a capture or a file name holds can break no format and drive no
terminal. Must not: know one of the formats.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from canalyze.output import printable
from canalyze.sources import STDIN
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze.check.verdict import Counted, Verdict
    from canalyze.records.problems import Finding

_ALSO: Final = 9
"""Frames of further findings of one kind that are named."""


def capture_name(file: str) -> str:
    """Returns a capture's name for people."""
    return "stdin" if file == STDIN else printable(file)


def ranges(numbers: Iterable[int], between: str = ",") -> str:
    """Returns numbers in their order, runs as 1-4."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and runs[-1][-1] == number - 1:
            runs[-1][1:] = [number]
        else:
            runs.append([number])
    return between.join("-".join(map(str, run)) for run in runs)


def place(file: str, line: int | None) -> str:
    """Returns file and line as compilers do, for whoever makes links of it."""
    return capture_name(file) if line is None else f"{capture_name(file)}:{line}"


def title(finding: "Finding") -> str:
    """Returns the rule: SDO001 toggle-bit."""
    return printable(f"{finding.code} {finding.name}")


def kind(finding: "Finding", words: Words) -> str:
    """Returns the key of a kind of finding in one capture: rule, bus, node, object, expectation."""
    parts = [
        title(finding),
        finding.bus,
        finding.node is not None and words("reports.node", node=finding.node),
        finding.object,
        expectation(finding),
    ]
    return printable(" ".join(part for part in parts if part))


def expectation(finding: "Finding") -> str | None:
    """Returns the line of the expectation: of its file the name only, which is the same wherever this runs."""
    if finding.expectation is None:
        return None
    from pathlib import PurePath

    return PurePath(finding.expectation).name


def where(finding: "Finding", words: Words, *, shown: str | None = None) -> list[str]:
    """Returns the frame it is about, then the one that shows it, if another; `shown` is a link to that one."""
    said = []
    if finding.about_frame is not None:
        said.append(words("reports.frame", frame=finding.about_frame))
    if finding.about_line is not None and finding.about_line != finding.about_frame:
        said.append(words("reports.line", line=finding.about_line))
    if finding.about_frame != finding.frame and finding.frame is not None:
        said.append(words("reports.shown", frame=shown or words("reports.frame", frame=finding.frame)))
    if finding.t is not None:
        said.append(f"{printable(finding.t)} s")
    return said


def repeats(counted: "Counted", words: Words) -> list[str]:
    """Returns the number of findings, if more than one, and the part that the baseline allows."""
    said = []
    count = max(counted.count, counted.alike) if counted.known else counted.count
    if count > 1 or counted.known:
        said.append(words("reports.count", count=count))
    if counted.known:
        said.append(words("reports.known", known=counted.known))
    return said


def unjudged(verdict: "Verdict", words: Words) -> str:
    """Returns the reason why nothing was judged."""
    return words("check.then").join((words.of("check_nature", verdict.nature), words("check.unjudged")))


def consequences(found: "Sequence[Counted]", words: Words) -> str:
    """Returns the number of consequences and their rules: 3 consequences: PDO004, SYN008 (2)."""
    counts = Counter[str]()
    for one in found:
        counts[printable(one.finding.code)] += one.count
    listed = [code if count == 1 else f"{code} ({count})" for code, count in sorted(counts.items())]
    return words("reports.consequences", count=counts.total(), codes=words("reports.list").join(listed))


def of_events(verdict: "Verdict", words: Words) -> Iterator[str]:
    """Returns a line for each cause that is no finding: its frame, and what it explains."""
    frames = sorted({one.finding.because_of or 0 for one in verdict.consequences})
    for frame in frames:
        found = [one for one in verdict.consequences if one.finding.because_of == frame]
        said = consequences(found, words)
        yield words("reports.because_of", place=words("reports.frame", frame=frame), said=said)


def other_frames(counted: "Counted") -> list[int]:
    """Returns the frames that the further ones shown of its kind are about, each once."""
    frames = dict.fromkeys(one.about_frame for one in counted.shown)
    return [frame for frame in frames if frame is not None and frame != counted.finding.about_frame]


def further(counted: "Counted", words: Words) -> str | None:
    """Returns the frames of the others of its kind; None if there are none."""
    frames = other_frames(counted)
    if not frames:
        return None
    listed = words("reports.list").join(str(frame) for frame in frames[:_ALSO])
    whole = counted.count <= len(counted.shown) and len(frames) <= _ALSO
    if not whole:
        return words("reports.also_more", frames=listed)
    return words("reports.also_one" if len(frames) == 1 else "reports.also", frames=listed)


def sentence(counted: "Counted", words: Words, *, shown: str | None = None) -> str:
    """Returns all of it in one line: the message, then where and how often; `shown` as in `where`."""
    return _said(counted, where(counted.finding, words, shown=shown), words)


def brief(counted: "Counted", words: Words) -> str:
    """Returns the message with its frame and how often, for places that name file, line and rule by themselves."""
    frame = counted.finding.about_frame
    return _said(counted, [] if frame is None else [words("reports.frame", frame=frame)], words)


def _said(counted: "Counted", places: list[str], words: Words) -> str:
    parts = [*places, *repeats(counted, words)]
    said = printable(counted.finding.message)
    return words("reports.said", message=said, place=words("reports.then").join(parts)) if parts else said


def annotated(finding: "Finding") -> Iterator[str]:
    """Returns the lines of its context; that of the frame that it is about is marked.

    Where that line is not among them, the one that shows it is.
    """
    about = finding.about_frame
    marked = about if any(line.frame == about for line in finding.lines) else finding.frame
    for line in finding.lines:
        mark = ">" if line.frame == marked else " "
        yield f"{mark} {printable(line.text)}"
