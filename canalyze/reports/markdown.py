"""Markdown of a `check`, for summaries of steps on GitHub, and for comments of merge and pull requests.

A table of the captures that are not clean, then each of them with its findings and the annotated lines of the first
ones. The clean ones are counted. A document is at most as long as a comment may be on GitHub, and says what it leaves
out. Nothing of a capture or of its name is markup, or mentions a person. Must not: judge.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from canalyze.check.verdict import Counted, Verdict
from canalyze.output import Output, printable
from canalyze.reports import check_text, wording
from canalyze.words import Words

_MOST: Final = 65_000
"""Characters of a document. A comment on GitHub has 65,536 at most."""
_CHECKS: Final = 3
"""Of what to check first, so much."""
_LAST: Final = 200
"""Characters that are kept for the sentence on what is left out."""
_MARKUP: Final = re.compile(r"([\\`*_{}\[\]<>#&|~$!]|^[-+=]|(?<=\d)[.)](?=\s|$)|:(?=//)|(?<=www)\.)", re.I)
"""Markup within a line or at its start, and the signs that make links."""


def lines(verdicts: Sequence[Verdict], words: Words) -> Iterator[str]:
    """Returns the lines of the document, without line ends."""
    report = check_text.Report(words, Output())
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
    shown = verdict.failed or verdict.stories or check_text.unjudged(verdict)
    return verdict.error is None and verdict.judged and not shown


def _table(listed: Sequence[Verdict], report: check_text.Report, words: Words) -> Iterator[str]:
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


def _block(verdict: Verdict, report: check_text.Report, words: Words, *, bare: bool = False) -> Iterator[str]:
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
    for one in check_text.unjudged(verdict):
        yield f"- {_text(report.head(one.finding))}"
    yield ""


def _entry(one: Counted, report: check_text.Report, words: Words, *, bare: bool) -> Iterator[str]:
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
