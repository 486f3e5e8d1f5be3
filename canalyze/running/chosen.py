"""The short forms of --filter on a command line, as conditions of its expression.

What they choose and what the expression chooses must both hold. A problem is found by a diagnosis, which reads the
capture once more. Must not: judge, or read an expression.
"""

from typing import Any

import click

from canalyze.configuration.options import PROBLEM, SHORT, open_session, usage
from canalyze.output import Output, Progress
from canalyze.records import records
from canalyze.records.problems import Problem
from canalyze.reports.diagnosis_text import near, tree
from canalyze.reports.wording import ranges
from canalyze.running.run import Run
from canalyze.sources.file import STDIN, total_size
from canalyze.words import Words


def choose(context: click.Context, words: Words) -> None:
    """Adds the conditions of the short forms before the expression of --filter."""
    given = context.params
    conditions = [given.get(one.name) for one in SHORT]
    if (number := given.get(PROBLEM.name)) is not None:
        conditions.append(_near(number, context, words))
    # An expression whose last quotation mark is missing goes on to its end: it comes last.
    given["expression"] = " ".join(filter(None, [*conditions, given["expression"]])) or None


def _near(number: int, context: click.Context, words: Words) -> str | None:
    """Returns the condition for the frames around a problem and what comes from it; None if nothing could be read."""
    given: Any = context.params
    names = given["files"]
    if not names or STDIN in names:
        raise usage(words, "opt.problem_stdin")
    session = open_session(words, given, format="diagnosis", stamps=given["stamps"])
    results: list[bytes] = []
    progress = Progress(words, Output(), total_size(names), until_output=True)
    code = Run(session, words, progress, results.append, given, tell=lambda _: None).over(names)
    if code >= 128:
        context.exit(code)
    if not session.frames:
        return None
    by_id = {one.id: one for one in records(b"".join(results), Problem)}
    if number not in by_id:
        key = "diagnose.no_problem" if by_id else "diagnose.no_problems"
        raise usage(words, key, number=number, numbers=ranges(by_id, ", "))
    frames = near(one for _, one in tree(by_id[number], by_id))
    return f"frame={ranges((frame for frame in frames if frame > 0), ',')}"
