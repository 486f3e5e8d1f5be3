"""The report of `check` for people and for the log of a CI job: one block a capture, then a line of totals.

A clean capture is one line. Findings of one kind are one entry: where and what, the annotated lines around the first
of them, the one that it is about marked, how many there are, and in one line what follows from it. Must not: judge.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from canalyze.check.verdict import Counted, Verdict
from canalyze.output import Output, dyed, printable
from canalyze.records import SEVERITIES
from canalyze.records.findings import Finding
from canalyze.records.problems import Problem
from canalyze.reports import wording
from canalyze.words import Words

_FILES: Final = 3
"""Files of expectations that are named; further ones are counted with them."""
_MANY: Final = 10
"""Failing captures from which on the report closes with a line a rule, since their blocks are too many to read."""
_UNJUDGED: Final = frozenset({"EXP015", "BUS009"})
"""Findings about what was not judged: an expectation that this capture cannot show, traffic that is not CANopen. They
are no failures, but neither met nor clean."""


def show(verdicts: Sequence[Verdict], out: Output, words: Words, *, totals: bool = False) -> None:
    """Writes the whole report. totals: only what is said of all captures."""
    report = Report(words, out)
    for verdict in () if totals else verdicts:
        for line in report.block(verdict):
            out.text(line + "\n")
    for line in report.totals(verdicts, 1 if totals else _MANY):
        out.text(line + "\n")


def unjudged(verdict: Verdict) -> list[Counted]:
    """Returns the findings that could not be judged and are shown all the same."""
    return [one for one in verdict.others if one.finding.code in _UNJUDGED]


class Report:
    """The lines of a report."""

    def __init__(self, words: Words, out: Output) -> None:
        """Begins a report for an output, which says if there are colours."""
        self._words = words
        self._out = out

    def block(self, verdict: Verdict) -> Iterator[str]:
        """Returns the lines about one capture."""
        name = wording.capture_name(verdict.file)
        if verdict.error is not None and not verdict.frames:  # the reason is on standard error
            yield self._words("check.file", name=name, said=self._dyed(self._words("check.unreadable"), "error"))
            return
        yield self._words("check.capture", name=name, frames=verdict.frames, said=self.result(verdict))
        for one in verdict.failures:
            yield from self._entry(one)
        for problem in verdict.stories:
            yield "  " + self.problem(problem, verdict)
        for one in unjudged(verdict):
            yield "  " + self.head(one.finding)
        if verdict.failures or verdict.stories or unjudged(verdict):
            yield ""

    def result(self, verdict: Verdict) -> str:
        """Returns the result of a capture as a line."""
        parts = [*self._said(verdict), *self._rest(verdict)]
        if verdict.error is not None:
            parts.insert(0, self._dyed(self._words("check.unread"), "error"))
        return self._words("check.then").join(parts)

    def _said(self, verdict: Verdict) -> Iterator[str]:
        """Returns the failures; traffic that is not CANopen is not judged, rather than clean."""
        alien = verdict.nature != "canopen"
        if verdict.failures or not (alien or verdict.problems):
            yield self._severities(verdict.failures)
        if verdict.problems:
            yield self._dyed(self._words("check.problems", count=len(verdict.problems)), "error")
        if not verdict.judged:
            yield self._dyed(wording.unjudged(verdict, self._words), "warning")
        elif alien:
            yield self._words.of("check_nature", verdict.nature)

    def _rest(self, verdict: Verdict) -> Iterator[str]:
        """Returns lines about findings that do not count."""
        known = sum(one.count for one in verdict.others if one.known)
        known += len(verdict.excused)
        below = Counter[str]()
        for one in verdict.others:
            if not one.known:
                below[one.finding.severity] += one.count
        for severity in reversed(SEVERITIES):
            if below[severity]:
                yield self._words(f"check.{severity}", count=below[severity])
        if explained := sum(one.count for one in verdict.every_consequence):
            yield self._words("check.consequences", count=explained)
        if known:
            yield self._words("check.known", count=known)
        if verdict.overruled:
            yield self._words("check.overruled", count=verdict.overruled)

    def _severities(self, found: Sequence[Counted]) -> str:
        if not found:
            return self._dyed(self._words("check.clean"), "clean")
        counts = Counter[str]()
        for one in found:
            counts[one.finding.severity] += one.count
        return self._words("check.then").join(
            self._dyed(self._words(f"check.{severity}", count=counts[severity]), severity)
            for severity in reversed(SEVERITIES)
            if counts[severity]
        )

    def _entry(self, one: Counted) -> Iterator[str]:
        finding = one.finding
        yield "  " + self.head(finding)
        for line in wording.annotated(finding):
            yield f"    {self._dyed(line, 'own') if line.startswith('>') else line}"
        if one.count > 1 or one.known:
            yield f"    {self.repeats(one)}"
        if one.consequences:
            yield f"    {wording.consequences(one.consequences, self._words)}"

    def problem(self, one: Problem, verdict: Verdict) -> str:
        """Returns the line of a problem."""
        fails, known = one.id in verdict.problems, verdict.known_problems.get(one.id, 0)
        status = self._dyed(self._words.of("problem_status", one.status), "error" if fails else "info")
        place = self._words("check.frame", frame=one.begin.frame)
        head = f"{status} {self._words('check.problem')} {place}"
        said = f" ({self._words('reports.known', known=known)})" if known else ""
        return self._words("check.entry", head=head, message=printable(one.message) + said)

    def head(self, finding: Finding) -> str:
        """Returns the line of a finding."""
        where = [
            finding.bus and printable(finding.bus),
            finding.about_frame and self._words("check.frame", frame=finding.about_frame),
            finding.about_line
            and finding.about_line != finding.about_frame
            and self._words("check.line", line=finding.about_line),
        ]
        severity = self._dyed(self._words.of("severity", finding.severity), finding.severity)
        place = self._words("check.then").join(str(part) for part in where if part)
        head = f"{severity} {finding.code} {place}".rstrip()
        return self._words("check.entry", head=head, message=printable(finding.message))

    def repeats(self, one: Counted) -> str:
        """Returns the number of findings of the kind, and their frames."""
        said = self._words("check.times", count=one.count)
        if one.known:
            said = self._words("check.times_known", count=max(one.count, one.alike), known=one.known)
        frames = [str(frame) for frame in wording.other_frames(one)]
        if not frames:
            return said
        more = self._words("check.and_more") if one.count > len(one.shown) else ""
        return said + self._words("check.also", frames=self._words("check.between").join(frames) + more)

    def totals(self, verdicts: Sequence[Verdict], many: int = _MANY) -> Iterator[str]:
        """Returns the closing lines: why findings were overruled, what fails many captures, all figures."""
        reasons = Counter[str]()
        for verdict in verdicts:
            reasons.update(dict(verdict.reasons))
        for reason, count in sorted(reasons.items()):
            yield self._words("check.reason", count=count, reason=printable(reason))
        yield from self._held_against(verdicts)
        yield from self._by_rule(verdicts, many)
        found = [one for verdict in verdicts for one in verdict.failures]
        read = [verdict for verdict in verdicts if verdict.error is None]
        unjudged = sum(not verdict.judged for verdict in read)
        failed = sum(verdict.failed for verdict in verdicts)
        frames = sum(verdict.frames for verdict in verdicts)
        parts = []
        problems = sum(len(verdict.problems) for verdict in verdicts)
        if problems:
            parts.append(self._dyed(self._words("check.problems", count=problems), "error"))
        if found:
            parts.append(self._severities(found))
        if found or problems:
            parts[-1] += self._words("check.in_files", files=failed)
        elif len(read) > unjudged:
            parts.append(self._dyed(self._words("check.none"), "clean"))
        if unjudged:
            parts.append(self._dyed(self._words("check.unjudged_files", files=unjudged), "warning"))
        if len(read) < len(verdicts):
            said = self._words("check.unread_files", files=len(verdicts) - len(read))
            parts.append(self._dyed(said, "error"))
        said = self._words("check.then").join(parts)
        yield self._words("check.total", files=len(verdicts), frames=frames, said=said)

    def _by_rule(self, verdicts: Sequence[Verdict], many: int) -> Iterator[str]:
        """Returns the rules that fail many captures, each with their number, the most frequent first."""
        failed = [verdict for verdict in verdicts if verdict.failures]
        if len(failed) < many:
            return
        files = Counter(
            title for verdict in failed for title in {wording.title(one.finding) for one in verdict.failures}
        )
        counts = Counter[str]()
        for one in (one for verdict in failed for one in verdict.failures):
            counts[wording.title(one.finding)] += one.count
        for title, number in sorted(files.items(), key=lambda row: (-row[1], row[0])):
            yield self._words("check.by_rule", rule=title, count=counts[title], files=number)

    def _held_against(self, verdicts: Sequence[Verdict]) -> Iterator[str]:
        """Returns a line about the expectations: file by file, or the number of files if many."""
        files = Counter(verdict.expectations for verdict in verdicts if verdict.expectations is not None)
        count = sum(files.values())
        without = len(verdicts) - count
        if len(files) > _FILES:
            parts = [self._words("check.expected_by_files", expected=len(files), files=count)]
        else:
            parts = [
                self._words("check.expected_by", name=printable(file), files=number) for file, number in files.items()
            ]
        if parts and without:
            parts.append(self._words("check.expected_by_none", files=without))
        if parts:
            yield self._words("check.expectations", said=self._words("check.then").join(parts))

    def _dyed(self, text: str, colour: str) -> str:
        return dyed(text, colour, out=self._out)
