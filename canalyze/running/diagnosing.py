"""Recordings diagnosed: one, or several, each by itself.

What went wrong, the core says; how it is laid out, `reports.diagnosis_text`. Must not: read an option's text.
"""

import json
from collections.abc import Iterable
from contextlib import suppress

from canalyze.errors import ReaderGone
from canalyze.output import Output, Progress, jsonl, told
from canalyze.records.problems import KEYS, Problem, diagnosed
from canalyze.reports import diagnosis_text
from canalyze.reports.diagnosis_chosen import fails, select
from canalyze.reports.diagnosis_text import Chosen, Diagnosed
from canalyze.running.passes import Pass
from canalyze.sources.file import total_size


def diagnose(one: Pass, names: tuple[str, ...] = ()) -> tuple[int, bytes]:
    """Returns the exit code, and the JSON lines of the diagnosis; none if nothing could be read."""
    session = one.session(format="diagnosis")
    results: list[bytes] = []
    one.progress = Progress(one.words, one.out, total_size(names or one.names))
    code = one.read(session, results.append, names)
    return code, b"" if code and not session.frames else b"".join(results)


def each(one: Pass, found: list[tuple[str, ...]], chosen: Chosen) -> tuple[int, list[tuple[str, ...]]]:
    """Diagnoses recordings, each by itself; returns the exit code, and the files of those that could be read."""
    rows: list[Diagnosed] = []
    worst = 0
    failing = False
    with suppress(ReaderGone):
        for names in found:
            code, result = diagnose(one, names)
            incidents, whole = diagnosed(result)
            worst = worst or code
            if code >= 128:
                worst = code
                told(code, one.out, one.words, stream=False, some=bool(rows))
                break
            shown = select(incidents, whole, chosen)
            failing = failing or fails(shown, one.fail_on)
            if whole is None:
                continue
            if one.form == "jsonl":
                write_lines(result, shown, one.out, names)
            rows.append(Diagnosed(names, shown, whole.order, whole.nature))
        if one.form == "text":
            diagnosis_text.show_each(rows, one.out, one.words, chosen, unread=len(found) - len(rows))
            diagnosis_text.further_of_each(rows, one.out, one.words)
    if not rows:
        one.out.drop()
    return worst or int(failing), [row.names for row in rows]


def write_lines(result: bytes, shown: Iterable[Problem], out: Output, names: tuple[str, ...] = ()) -> None:
    """Writes a JSON object for each problem; names: with the files of its recording, where there are several."""
    wanted = {one.id for one in shown}
    for row in map(json.loads, result.splitlines()):
        if row["kind"] != "problem" or row["id"] not in wanted:
            continue
        record = {key: row[key] for key in KEYS} | ({"files": list(names)} if names else {})
        out.write(f"{jsonl.text(record)}\n".encode("utf-8", "backslashreplace"))
