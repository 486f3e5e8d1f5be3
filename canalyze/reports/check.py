"""The reports of `check` by their names: the forms of --format, documents in files; text, Markdown and JSON lines.

For people and for the log of a CI job: one block a capture, then a line of totals. A clean capture is one line.
Findings of one kind are one entry: where and what, the annotated lines around the first of them, the one that it is
about marked, how many there are, and in one line what follows from it. Must not: judge.

Markdown, for summaries of steps on GitHub, and for comments of merge and pull requests: a table of the captures that
are not clean, then each of them with its findings and the annotated lines of the first ones. The clean ones are
counted. A document is at most as long as a comment may be on GitHub, and says what it leaves out. Nothing of a capture
or of its name is markup, or mentions a person.

JSON lines: one object a kind of finding, and one at the end of each capture. Keys are only ever added, never renamed,
but for those of problems (CHANGELOG). `finding` has those of the core's (`canalyze/core/src/tables/jsonl`), of the
first of its kind, and

| key | is |
|---|---|
| `lines` | the annotated lines of its context, oldest first, `{"frame","text"}` each |
| `count` | how many of the kind there are |
| `frames` | where the first ten stand |
| `known` | how many of them the baseline allows |
| `fails` | whether the check fails by it |

`problem`, with --problems, has `id problem bus node nodes status impact grade begin end message frames known fails`
(`known`: how many of its kind the baseline allows), and `incident`, which is deprecated, the former name of `problem`;
only roots are listed, and harmless ones are not.

`check` has `file`, `frames` (how many were read), `failed`, `failures` and `others` (how many findings fail, and how
many do not), `nature` (what the capture has shown of its buses: `canopen` where one is; `unproven`, `foreign`, or
`silent` without data frames), `judged` (false where nothing fails because none of it is CANopen, and no expectations
were held against it), `overruled` (how many were taken away), `reasons` (`{"reason","count"}` of each override
that changed some), `expectations` (the file of them that it was held against, or null) and `error` (why the file could
not be read, or null).
"""

import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

from msgspec import to_builtins

from canalyze.check.verdict import Counted, Verdict
from canalyze.output import Output, dyed, fields, json_text, printable
from canalyze.records import SEVERITIES
from canalyze.records.problems import Finding, Problem
from canalyze.reports import wording
from canalyze.words import Words

_FILES: Final = 3
"""Files of expectations that are named; further ones are counted with them."""
_MANY: Final = 10
"""Failing captures from which on the report closes with a line a rule, since their blocks are too many to read."""
_OF_PROBLEM: Final = "bus node nodes status impact grade begin end message frames"
"""Attributes of a problem in JSON."""
_UNJUDGED: Final = frozenset({"EXP015", "BUS009"})
"""Findings about what was not judged: an expectation that this capture cannot show, traffic that is not CANopen. They
are no failures, but neither met nor clean."""


def show(verdicts: Sequence[Verdict], out: Output, words: Words, *, totals: bool = False) -> None:
    """Writes the whole report. totals: only the lines about all captures."""
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
        key = "check.also_one" if len(frames) == 1 and not more else "check.also"
        return said + self._words(key, frames=self._words("check.between").join(frames) + more)

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


def json_lines(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Returns the lines, without their ends."""
    for verdict in verdicts:
        passing = (*verdict.others, *verdict.every_consequence)
        both = [(one, True) for one in verdict.failures] + [(one, False) for one in passing]
        for one, fails in sorted(both, key=lambda row: row[0].finding.frame or 0):
            yield _line(_finding(one, fails))
        for problem in verdict.stories:
            known = verdict.known_problems.get(problem.id, 0)
            fails = problem.id in verdict.problems
            yield _line(
                {
                    "kind": "problem",
                    "id": problem.id,
                    "problem": problem.kind,
                    "incident": problem.kind,
                    **to_builtins(fields(problem, _OF_PROBLEM)),
                    "known": known,
                    "fails": fails,
                }
            )
        yield _line(
            {
                "kind": "check",
                "file": os.fsencode(verdict.file).decode("utf-8", "backslashreplace"),
                **fields(verdict, "frames failed"),
                "failures": sum(one.count for one in verdict.failures),
                "others": sum(one.count for one in passing),
                **fields(verdict, "nature judged overruled"),
                "reasons": [{"reason": reason, "count": count} for reason, count in verdict.reasons],
                **fields(verdict, "expectations error"),
            }
        )


def _finding(one: Counted, fails: bool) -> dict[str, Any]:
    return {
        **to_builtins(one.finding),
        "about_frame": one.finding.about_frame,
        "count": one.count,
        "frames": [other.frame for other in one.shown if other.frame is not None],
        "known": one.known,
        "fails": fails,
    }


def _line(row: dict[str, Any]) -> str:
    return json_text(row, compact=True)


DOCUMENTS: Final = ("junit", "sarif", "code_quality", "markdown")
FORMS: Final = ("text", "jsonl", "github", "markdown")


def document(name: str, verdicts: Sequence[Verdict], words: Words) -> bytes:
    """Returns one of DOCUMENTS."""
    if name == "junit":
        from canalyze.reports import hosts

        return hosts.junit(verdicts, words)
    if name == "sarif":
        from canalyze._core import rules
        from canalyze.reports import sarif

        return sarif.document(verdicts, rules(words.lang), words)
    if name == "code_quality":
        from canalyze.reports import hosts

        return hosts.code_quality(verdicts, words)
    return b"".join(map(_encoded, markdown(verdicts, words)))


def write(form: str, verdicts: Sequence[Verdict], out: Output, words: Words) -> None:
    """Writes one of FORMS."""
    if form == "text":
        show(verdicts, out, words)
        return
    if form == "jsonl":
        lines = json_lines(verdicts)
    elif form == "markdown":
        lines = markdown(verdicts, words)
    else:
        from canalyze.reports import hosts

        lines = hosts.github(verdicts, words)
    for line in lines:
        out.write(_encoded(line))


def _encoded(line: str) -> bytes:
    return f"{line}\n".encode("utf-8", "backslashreplace")


_MOST: Final = 65_000
"""Characters of a document. A comment on GitHub has 65,536 at most."""
_CHECKS: Final = 3
"""Of what to check first, so much."""
_LAST: Final = 200
"""Characters that are kept for the sentence on what is left out."""
_MARKUP: Final = re.compile(r"([\\`*_{}\[\]<>#&|~$!]|^[-+=]|(?<=\d)[.)](?=\s|$)|:(?=//)|(?<=www)\.)", re.I)
"""Markup within a line or at its start, and the signs that make links."""


def markdown(verdicts: Sequence[Verdict], words: Words) -> Iterator[str]:
    """Returns the lines of the document, without line ends."""
    report = Report(words, Output())
    *further, total = report.totals(verdicts)
    listed = [verdict for verdict in verdicts if not _is_clean(verdict)]
    document = [f"## canalyze check: {_text(total)}", ""]
    if listed:
        document += _table(listed, report, words)
    if clean := len(verdicts) - len(listed):
        document += [_text(words("check.clean_files", files=clean)), ""]
    if further and _length(document) + sum(map(len, further)) * 2 < _MOST // 2:
        document += [*(f"- {_text(said)}" for said in further), ""]
    left = _MOST - _length(document) - _LAST
    yield from document
    for place, verdict in enumerate(listed):
        for bare in (False, True):
            block = list(_block(verdict, report, words, bare=bare))
            if _length(block) <= left:
                break
        else:
            yield _text(words("check.cut", files=len(listed) - place))
            return
        left -= _length(block)
        yield from block


def _is_clean(verdict: Verdict) -> bool:
    """Returns true if a capture needs no row."""
    shown = verdict.failed or verdict.stories or unjudged(verdict)
    return verdict.error is None and verdict.judged and not shown


def _table(listed: Sequence[Verdict], report: Report, words: Words) -> Iterator[str]:
    """Returns a row a capture, as many as take a third of the document."""
    yield f"| {words('check.column_capture')} | {words('check.column_frames')} | {words('check.column_result')} |"
    yield "|---|---:|---|"
    left = _MOST // 3
    shown = 0
    for verdict in listed:
        result = report.result(verdict) if verdict.frames or verdict.error is None else words("check.unreadable")
        row = f"| {_code(wording.capture_name(verdict.file), cell=True)} | {verdict.frames} | {_text(result)} |"
        left -= len(row) + 1
        if left < 0:
            break
        shown += 1
        yield row
    yield ""
    if more := len(listed) - shown:
        yield _text(words("check.more_files", files=more))
        yield ""


def _block(verdict: Verdict, report: Report, words: Words, *, bare: bool = False) -> Iterator[str]:
    """Returns the lines about one capture. bare: without the annotated lines."""
    yield f"### {_code(wording.capture_name(verdict.file))}"
    yield ""
    if verdict.error is not None:
        yield f"- {_text(printable(verdict.error))}"
    elif not verdict.judged:
        yield f"- {_text(wording.unjudged(verdict, words))}"
    for problem in verdict.stories:
        yield f"- {_text(report.problem(problem, verdict))}"
        if problem.id in verdict.problems and problem.checks:
            said = words("diagnose.between").join(problem.checks[:_CHECKS])
            yield f"  - {_text(words('diagnose.check_first', said=said))}"
    for one in verdict.failures:
        yield from _entry(one, report, words, bare=bare)
    for one in unjudged(verdict):
        yield f"- {_text(report.head(one.finding))}"
    yield ""


def _entry(one: Counted, report: Report, words: Words, *, bare: bool) -> Iterator[str]:
    yield f"- {_text(report.head(one.finding))}"
    annotated = [] if bare else list(wording.annotated(one.finding))
    if annotated:
        fence = "`" * max(3, _longest_run(annotated) + 1)
        yield from ("", f"  {fence}text", *(f"  {line}" for line in annotated), f"  {fence}")
    if one.count > 1 or one.known:
        yield from ("", f"  {_text(report.repeats(one))}")
    if one.consequences:
        yield from ("", f"  {_text(wording.consequences(one.consequences, words))}")


def _longest_run(texts: Iterable[str]) -> int:
    """Returns the length of the longest run of backticks."""
    return max((len(run) for text in texts for run in re.findall("`+", text)), default=0)


def _text(text: str) -> str:
    """Returns a text that has no markup. A word joiner behind an `@` keeps it from naming a person."""
    return _MARKUP.sub(r"\\\1", printable(text).strip()).replace("@", "@\u2060")


def _code(text: str, *, cell: bool = False) -> str:
    """Returns a code span. cell: within a table, where a bar has to be escaped even there."""
    fence = "`" * (_longest_run([text]) + 1)
    shown = text.replace("|", "\\|") if cell else text
    return f"{fence} {shown} {fence}" if shown[:1] in "` " or shown[-1:] in "` " else f"{fence}{shown}{fence}"


def _length(lines: Sequence[str]) -> int:
    return sum(len(line) + 1 for line in lines)
