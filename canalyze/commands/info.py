"""`canalyze info`: what a file is, before anything is decoded. Each file is by itself; the core counts its frames."""

import json
from typing import Any

from canalyze.configuration.options import FILES, INPUT_FORMAT, OUTPUT, TOPICS, form, open_session
from canalyze.output import json_line
from canalyze.running.passes import Pass, pass_command
from canalyze.running.run import Run


def run(one: Pass) -> int:
    """Shows each file."""
    from canalyze.reports.summary import show_file

    code = shown = ended = 0
    with one.opened() as out:
        for name in one.names:
            results: list[bytes] = []
            session = open_session(one.words, one.given, format="info")
            reading = Run(session, one.words, one.progress, results.append, one.given, frameless=True)
            ended = reading.over((name,))
            code = ended or code
            if reading.last is not None and (reading.understood or ended > 128):
                record: dict[str, Any] = json.loads(b"".join(results))
                record |= {
                    "format": reading.last.kind,
                    "compression": reading.last.compression,
                    "checked": reading.last.checked,
                    "size": reading.last.taken,
                }
                if one.form == "jsonl":
                    out.write(json_line(record, compact=True))
                else:
                    show_file(record, out, one.words, first=not shown)
                shown += 1
            if ended > 128:
                break
        one.end(ended, shown)
    return code


command = pass_command("info", run, FILES, form("text", "jsonl"), INPUT_FORMAT, *TOPICS, *OUTPUT, paged=True)
