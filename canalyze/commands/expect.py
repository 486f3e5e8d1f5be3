"""`canalyze expect`: writes a first version of a file of expectations from a good capture.

What was seen, the core says; how much room it gets, `expectations/draft.py`.
"""

import shlex
from pathlib import PurePath

from canalyze.configuration.options import BITRATE
from canalyze.expectations.draft import Draft
from canalyze.output import hint
from canalyze.running.passes import Pass, capture_command


def run(one: Pass) -> int:
    """Reads, then drafts."""
    session = one.session(format="observed", incidents=True)
    draft = Draft()
    with one.opened() as out:
        code = one.read(session, draft.take)
        one.end(code, draft.frames)
        if draft.frames:
            out.write(draft.text(one.words, ", ".join(PurePath(name).name for name in one.names)).encode())
    if draft.findings:
        one.note("expect.not_good", codes=", ".join(draft.findings))
    if out.name is not None and draft.frames and not code:
        hint(f"canalyze: {one.words('expect.written', name=shlex.quote(out.name))}")
    return code


command = capture_command("expect", run, BITRATE, paged=False)
