"""`canalyze fleet`: many captures, each by itself, on several processors or machines, into one place.

The work on one capture is in `canalyze/fleet/task.py`, the run over all of them in `run.py` there.

Exit codes: as those of `check`, and 3 where all is done but for captures that failed.
"""

import re
import tempfile
from contextlib import nullcontext
from typing import Any, Final

from canalyze import exporting
from canalyze.check.examination import JUDGING, held_policy, job_of, known_findings
from canalyze.commands.export import TABLE
from canalyze.configuration.options import (
    ANY_PATH,
    BITRATE,
    COLOR,
    FORCE,
    MERGE,
    OUTPUT,
    READING,
    SELECT,
    THREADS,
    TIME,
    argument,
    option,
    positive,
    typed,
)
from canalyze.running.passes import Pass, pass_command

_ACTIONS: Final = ("check", "diagnose", "export", "summary")
_OF: Final = {row.name: "check" for row in JUDGING} | dict.fromkeys(("tables", "signals", "device_from"), "export")
"""Options that are of one action only."""


def run(one: Pass) -> int:
    """Works on every capture that is not done."""
    from canalyze.fleet import run
    from canalyze.fleet.task import Work

    _agree(one)
    action, words = one.action, one.words
    one.given["threads"] = 1  # the processors are shared by captures already
    held = held_policy(one.given, words)
    tables: tuple[str, ...] = ()
    settings: dict[str, Any] = {"time": one.time}
    if action == "export":
        exporting.require()
        tables = tuple(dict.fromkeys(one.tables)) or tuple(exporting.TABLES)
        settings |= {"tables": [exporting.TABLES[name] for name in tables], "select": one.signals}
    job = job_of(one.given, held, words, settings)
    with nullcontext() if one.on else tempfile.TemporaryDirectory(prefix="canalyze-fleet-") as scratch:
        known = known_findings(held, words) if action == "check" else {}
        work = Work(action, job, held, known, one.output, tables, one.device_from or "", one.force, scratch)
        return run.complete(work, one.sources, run.How(**{name: one.given[name] for name in run.How._fields}), words)


def _group(text: str) -> str | None:
    """Reads a regular expression with a group."""
    try:
        return text if re.compile(text).groups else None
    except re.error:
        return None


def _shard(text: str) -> tuple[int, int] | None:
    """Reads K/N, K from 1 to N."""
    number, of = (positive(part) for part in text.partition("/")[::2])
    return (number, of) if number and of and number <= of else None


def _engine(text: str) -> tuple[str, str | None] | None:
    """Reads ENGINE or ENGINE=ADDRESS."""
    name, equals, address = text.partition("=")
    return (name, address or None) if name in ("dask", "ray") and (address or not equals) else None


def _agree(one: Pass) -> None:
    """Raises a usage error for what is missing, and for what does not go together."""
    if not one.sources:
        raise one.usage("usage.missing", what="SOURCE")
    if one.output is None:
        raise one.usage("fleet.no_output")
    for param in typed():
        if (of := _OF.get(param.name or "", one.action)) != one.action:
            raise one.usage("fleet.other", option=param.opts[0], action=of)


command = pass_command(
    "fleet",
    run,
    argument("action", "|".join(_ACTIONS), choices=_ACTIONS),
    argument("sources", "SOURCE...", nargs=-1, type=ANY_PATH),
    OUTPUT[0]._replace(metavar="OUT", key="fleet.output"),
    option("--workers", "N", positive, "positive"),
    option("--shard", "K/N", _shard, "shard"),
    option("--on", "ENGINE", _engine, "engine"),
    option("--timeout seconds", "S", positive, "positive"),
    option("--memory megabytes", "MB", positive, "positive"),
    option("--retry"),
    option("--html", usual=0),
    FORCE._replace(key="fleet.force"),
    *JUDGING,
    TABLE,
    SELECT._replace(names=("--signals",), topic="own", usual=None),
    option("--device-from", "REGEX", _group, "group"),
    TIME,
    COLOR,
    BITRATE,
    *(row for row in READING if row not in (MERGE, THREADS)),
)
