"""`canalyze summary`: a capture in figures. What is counted and measured, the core says, all of it at the end."""

from canalyze.configuration.options import BITRATE, COLOR, PROBLEM, TIME, form
from canalyze.running.passes import Pass, capture_command


def run(one: Pass) -> int:
    """Reads, then shows."""
    session = one.session(format="summary")
    with one.opened() as out:
        results: list[bytes] = []
        code = one.read(session, results.append)
        records = b"".join(results)
        if one.form == "jsonl":
            out.write(records)
        else:
            from canalyze.reports.summary import show

            show(records, out, one.words, moments=one.time is None)
        return one.end(code, records)


command = capture_command("summary", run, form("text", "jsonl"), TIME, COLOR, BITRATE, PROBLEM)
