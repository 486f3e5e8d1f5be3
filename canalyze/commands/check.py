"""`canalyze check`: captures as regression tests, each by itself.

What a finding is, the core says; what counts, `check.policy`; how it is written, `reports`.

Exit codes: 0 nothing fails, 1 findings fail, 2 something could not be read.
"""

from contextlib import ExitStack, suppress

from canalyze.check import policy
from canalyze.check.examination import JUDGING, held_policy, job_of, known_findings, report_stale, updated
from canalyze.configuration.options import (
    ANY_PATH,
    BITRATE,
    CLOCK,
    COLOR,
    MERGE,
    clock,
    configured,
    form,
    known_of,
    option,
)
from canalyze.errors import ReaderGone
from canalyze.output import FileOutput, Progress, complain
from canalyze.reports import check
from canalyze.running.passes import Pass, capture_command
from canalyze.sources import STDIN, total_size
from canalyze.sources.names import expanded


def run(one: Pass) -> int:
    """Examines captures, then judges and reports."""
    from canalyze.check.examination import complaints, examine_all, in_order

    words = one.words
    held = held_policy(one.given, words)
    known = known_findings(held, words, update=one.update_baseline)
    documents = [name for name in check.DOCUMENTS if one.given[name]]
    # Reports in files have the times of the capture, whatever a terminal shows.
    time = one.time if documents else clock(one.time, one.form, one.output)
    job = job_of(one.given, held, words, {"time": time})
    named = list(expanded(one.names))
    names = tuple(found.name for found in named if found.error is None)
    with one.opened(hangs=one.form == "text") as out:
        with ExitStack() as stack:
            files = _opened(one, stack)
            progress = Progress(words, out, total_size(names), until_output=True)
            found, signal = examine_all(names, job, progress) if names else ([], 0)
            progress.clear()
            examined = in_order(named, found, words)
            described = [
                file.file for known in (configured().known, known_of(one.given)) for file in known.descriptions
            ]
            complain(*complaints(examined, described))
            read = not any(capture.error for capture in examined)
            if one.update_baseline:
                known = updated(held, examined, words, whole=read and not signal)
            elif known and read and not signal:
                report_stale(held, known, examined, words)
            verdicts = [policy.judge(capture, held, known) for capture in examined]
            for name, file in files.items():
                if signal:  # half a set would pass for a whole one
                    file.drop()
                else:
                    file.write(check.document(name, verdicts, words))
        if signal:
            whole = sum(1 for capture in found if capture is not None and not capture.signal)
            one.note("check.broken_off", count=len(names) - whole)
            out.drop()
        with suppress(ReaderGone):  # a closed pipe does not mean that the check is passed
            check.write(one.form, verdicts, out, words)
    if signal:
        return 128 + signal
    return 2 if not read else 1 if any(verdict.failed for verdict in verdicts) else 0


def _opened(one: Pass, stack: ExitStack) -> dict[str, FileOutput]:
    """Opens the files of documents, by the names of their options."""
    given = {name: one.given[name] for name in check.DOCUMENTS if one.given[name] is not None}
    for name in (name for name, file in given.items() if file == STDIN):
        raise one.usage("check.no_stdout", option=f"--{name.replace('_', '-')}")
    return {name: stack.enter_context(FileOutput(file, force=one.force)) for name, file in given.items()}


command = capture_command(
    "check",
    run,
    *JUDGING,
    option("--update-baseline"),
    form(*check.FORMS),
    CLOCK,
    COLOR,
    option("--junit", "FILE", usual=0, type=ANY_PATH),
    option("--sarif", "FILE", type=ANY_PATH),
    option("--code-quality", "FILE", type=ANY_PATH),
    option("--markdown", "FILE", type=ANY_PATH),
    BITRATE,
    without=(MERGE,),
)
