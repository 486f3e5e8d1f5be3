"""`canalyze sdo`: one row a transfer, and their data as files. What a transfer is, the core says."""

from typing import Final

from canalyze.configuration.options import ANY_PATH, CLOCK, COLOR, PROBLEM, clock, form, option
from canalyze.running.passes import Pass, capture_command

FORMS: Final = {"text": "transfers-text", "jsonl": "transfers", "csv": "transfers-csv"}
"""The core's names of the values of --format."""
HEADINGS: Final = {"text": 0, "jsonl": 0, "csv": 1}
"""Lines that are no transfer."""


def run(one: Pass) -> int:
    """Lists every transfer, and takes their data out."""
    time = clock(one.time, one.form, one.output)
    session = one.session(format=FORMS[one.form], time=time, extract=one.extract is not None)
    rows = -HEADINGS[one.form]

    with one.opened() as out:
        table = directory = None
        if one.form == "text":
            from canalyze.reports.sdo import Transfers

            live = one.total is None
            table = Transfers(one.words, out, live=live, moments=one.time is None, since_start=time == "z")
        if one.extract is not None:
            from canalyze.reports.extract import Directory

            directory = Directory(one.extract, one.words, one.complain, force=one.force)

        def take(result: bytes) -> None:
            nonlocal rows
            if rows <= 0:
                rows += result.count(b"\n")
            (table.put if table else out.write)(result)
            if directory is not None:
                directory.add(session.extracted())

        try:
            code = one.read(session, take)
        finally:
            if directory is not None:
                directory.close()
        if table:
            table.close()
        if directory is not None and one.form != "csv":
            from canalyze.reports.sdo import list_files

            list_files(directory.described(), out, one.words, as_json=one.form == "jsonl")
        one.end(code, session.frames)
    if rows <= 0 and session.frames:
        one.note("sdo.none", frames=session.frames)
    if directory is not None:
        if session.frames:
            one.note("sdo.extracted", files=directory.written, directory=one.extract)
            if directory.holed:
                one.note("sdo.holed", files=directory.holed)
        code = code or directory.code
    return code


command = capture_command(
    "sdo", run, form(*FORMS), CLOCK, COLOR, option("--extract", "DIR", usual=0, type=ANY_PATH), PROBLEM
)
