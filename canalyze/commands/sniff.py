"""`canalyze sniff`: the annotated listing of a live bus. It only listens; every word of a line is the core's.

What is listened to, `listening` opens; it is read by the one loop that reads files. Exit codes: 0 done, also by
Ctrl-C; 1 an expectation does not hold; 2 something could not be opened, received or written, or nothing came that
expectations could be checked by; 143 SIGTERM, 129 SIGHUP.
"""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

from canalyze import expectations
from canalyze.configuration.options import (
    ANY_PATH,
    FILTER,
    LISTING,
    NETWORK,
    SHORT,
    argument,
    depth_of,
    open_session,
    option,
    positive,
)
from canalyze.output import complain, open_output
from canalyze.running.listening import LISTENING, channels_of, listening, seconds
from canalyze.running.listing import listed
from canalyze.running.passes import Pass, pass_command
from canalyze.running.viewing import VIEWING, Showing, check, drawn_in
from canalyze.timeline import TABLES


def run(one: Pass) -> int:
    """Listens until the end."""
    given, words = one.given, one.words
    depth = depth_of(one.form, words, brief=one.brief, explain=one.explain, number=one.number)
    out = open_output(None, color=one.color)
    drawn = one.rerun or one.save is not None
    named = channels_of(one.channels, given, words, writes=one.save is not None)
    check(given, words, drawn=drawn, shown=one.rerun, why_not=("sniff.needs_rerun", "--rerun"))
    text = one.form == "text"
    settings: dict[str, Any] = {
        "format": one.form,
        "depth": depth,
        "time": one.time,
        "filter": one.expression,
        "limit": one.count,
        "numbered": bool(one.number),
        "coloured": text and out.coloured,
        "masks": [channel.mask for channel in named if channel.filters],
        "incidents": depth != "brief",
        "expectations": None if one.expect is None else expectations.read(Path(one.expect)),
    }
    # What is printed and what is drawn come from one session, in one language.
    drawing = drawn_in(words, one.complain, web=one.web) if one.rerun else words
    session = open_session(drawing, given, tables=TABLES if drawn else (), **settings)
    with ExitStack() as stack:
        showing = stack.enter_context(Showing(given, drawing, shown=one.rerun, force=one.force)) if drawn else None
        opened = stack.enter_context(listening(named, given, words, complain, duration_s=one.duration))
        return listed(opened, session, drawing, given, showing, out, text=text)


command = pass_command(
    "sniff",
    run,
    argument("channels", "CHANNEL", nargs=-1),
    *LISTENING,
    FILTER,
    *SHORT,
    option("--duration", "TIME", seconds, "duration"),
    option("--count", "N", positive, "positive"),
    *LISTING,
    option("--expect", "FILE", type=ANY_PATH),
    option("--rerun", topic="timeline"),
    *VIEWING,
    *NETWORK,
)
