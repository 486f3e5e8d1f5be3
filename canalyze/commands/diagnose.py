"""`canalyze diagnose`, and `canalyze FILE` without a command: what went wrong, whether it still is, and why.

What went wrong, the core says; how it is laid out, `reports/diagnosis.py`.

Exit codes: 0, whatever was found; with --fail-on 1 where such a problem is there; 2 something could not be read.
"""

from contextlib import suppress

from canalyze.configuration import network
from canalyze.configuration.options import (
    ANY_PATH,
    BITRATE,
    COLOR,
    FILTER,
    SHORT,
    form,
    inputs,
    moment,
    option,
    positive,
)
from canalyze.errors import ReaderGone
from canalyze.records.problems import Overview, Problem, diagnosed
from canalyze.reports import diagnosis, wording
from canalyze.reports.diagnosis import FAIL_ON, Chosen, check_places, fails, select
from canalyze.running import diagnosing
from canalyze.running.passes import Pass, capture_command
from canalyze.sources import STDIN


def run(one: Pass) -> int:
    """Diagnoses a recording, or several."""
    one.names = inputs(diagnosing.listed(one.files), one.words)
    number, html = one.number, one.html
    _check(one)
    signalled = diagnosing.keep_stdin() if STDIN in one.names and (number is not None or html is not None) else 0
    chosen = Chosen(one.node, one.bus, one.since)
    with one.opened(hangs=one.form == "text") as out:
        found = [one.names] if one.join or one.merge else diagnosing.recordings_of(one)
        if len(found) > 1:
            if number is not None:
                raise one.usage("diagnose.one_recording", option="-n", count=len(found))
            code, read = diagnosing.each(one, found, chosen)
            if html is not None and read:
                _write_page(one, read)
            return code
        one.names = found[0]
        code, result = diagnosing.diagnose(one)
        incidents, whole = diagnosed(result)
        if whole is not None and code < 128:
            check_places(chosen, incidents, whole, one.words)
        shown = select(incidents, whole, chosen)
        numbers = [incident.id for incident in incidents]
        if number is not None and number not in numbers:
            key = "diagnose.no_problem" if numbers else "diagnose.no_problems"
            raise one.usage(key, number=number, numbers=wording.ranges(numbers, ", "))
        with suppress(ReaderGone):  # a closed pipe, as of `| head`: page and exit code are still wanted
            if one.form == "jsonl":
                diagnosing.write_lines(result, shown, out)
            elif whole is not None:
                _show(one, diagnosis.of_buses(incidents), diagnosis.of_buses(shown), whole, chosen)
        if html is not None and whole is not None:
            _write_page(one, [one.names])
        one.end(code, whole is not None)
    return code or signalled or int(fails(shown, one.fail_on))


def _check(one: Pass) -> None:
    """Raises a usage error for options that do not go together."""
    if one.expression is not None:  # what goes wrong is no matter of single frames
        raise one.usage("diagnose.no_filter")
    if one.html == STDIN:
        raise one.usage("check.no_stdout", option="--html")
    if one.html is not None:
        diagnosing.can_write_page(one)
    if one.number is not None and one.form != "text":
        raise one.usage("usage.text_only", option="-n")


def _show(one: Pass, incidents: list[Problem], shown: list[Problem], whole: Overview, chosen: Chosen) -> None:
    """Shows all problems that are asked for, or one at length, with the frames around its steps."""
    named = tuple(name for name in one.names if name != STDIN)
    if one.number is None:
        diagnosis.show(shown, whole, one.out, one.words, named, everything=one.everything, chosen=chosen)
        return
    by_id = {incident.id: incident for incident in incidents}
    near = diagnosis.near(incident for _, incident in diagnosis.tree(by_id[one.number], by_id))
    diagnosis.tell(one.number, incidents, whole, diagnosing.lines_of(one, near), one.out, one.words, named)


def _write_page(one: Pass, found: list[tuple[str, ...]]) -> None:
    """Writes the page with the captures inside, which are read again."""
    from canalyze.commands import page

    diagnosing.rewind(one)
    pieces = page.pieces(found, one.given, one.stamps, one.words, some=True, problem=one.number)
    page.write(one.html, pieces, force=one.force)


command = capture_command(
    "diagnose",
    run,
    option("-n number", "N", positive, "positive", key="diagnose.number", usual=0),
    option("--all everything", usual=0),
    option("--join"),
    option("--since", "S", moment, "moment", topic="chosen"),
    option("--node", "N", network.node, "node", topic="chosen"),
    option("--bus", "NAME", topic="chosen"),
    option("--html", "FILE", usual=0, type=ANY_PATH),
    option("--frames", choices=("near", "all"), key="diagnose.html", hidden=True),  # of a former page
    option("--fail-on", choices=tuple(FAIL_ON), usual=0),
    form("text", "jsonl"),
    COLOR,
    BITRATE,
    FILTER._replace(more={"hidden": True}),  # known only to be refused
    without=(FILTER, *SHORT),
)
