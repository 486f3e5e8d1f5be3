"""`canalyze sniff`: the annotated listing of a live bus. It only listens; every word of a line is the core's.

What is listened to, `listening` opens; it is read by the one loop that reads files. Exit codes: 0 done, also by
Ctrl-C; 1 an expectation does not hold; 2 something could not be opened, received or written, or nothing came that
expectations could be checked by; 143 SIGTERM, 129 SIGHUP.
"""

import json
import signal
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final, Unpack

import click

from canalyze import expectations
from canalyze.configuration.options import (
    ANY_PATH,
    depth_of,
    filter_options,
    listing_options,
    network_options,
    open_session,
    positive,
    spelled,
)
from canalyze.errors import CanalyzeError, OutputError
from canalyze.output import Output, Progress, complain, hint, open_output
from canalyze.output.help import Command
from canalyze.reports.table import EMPTY, Column, write
from canalyze.running.listening import (
    Listening,
    ListeningOptions,
    channels_of,
    listening,
    listening_options,
    seconds,
    set_rates,
)
from canalyze.running.run import Interrupt, Run
from canalyze.running.viewing import Showing, ViewingOptions, check, drawn_in, viewing_options
from canalyze.timeline import TABLES
from canalyze.words import Words

_REST_S: Final = 2.0
"""How long, after the first Ctrl-C, what was received may still take to be shown."""
_COUNTED: Final = {
    "sniff.findings": ("findings", ("sniff.error", "sniff.warning", "sniff.info")),
    "sniff.transfers": ("transfers", ("sniff.ok", "sniff.aborted", "sniff.incomplete", "sniff.failed")),
}
"""What the summary counts, in its order: in which words, and how the core calls it."""


class SniffOptions(ListeningOptions, ViewingOptions, total=False):
    """What the command is given beside its own parameters."""


def command(words: Words) -> click.Command:
    """Build the command in one language."""

    def run(
        channels: tuple[str, ...],
        brief: bool,
        explain: bool,
        form: str,
        expression: str | None,
        time: str | None,
        number: bool | None,
        color: str,
        duration: float | None,
        count: int | None,
        expect: str | None,
        rerun: bool,
        **given: Unpack[SniffOptions],
    ) -> int:
        depth = depth_of(form, words, brief=brief, explain=explain, number=number)
        out = open_output(None, color=color)
        named = channels_of(channels, given, words, writes=given.get("save") is not None)
        drawn = rerun or given.get("save") is not None
        check(given, words, drawn=drawn, shown=rerun, why_not=("sniff.needs_rerun", "--rerun"))
        settings: dict[str, Any] = {"format": form, "depth": depth, "time": time, "filter": expression, "limit": count}
        settings |= {"numbered": bool(number), "coloured": form == "text" and out.coloured}
        settings["masks"] = [channel.mask for channel in named if channel.filters]
        settings["incidents"] = depth != "brief"
        if expect is not None:
            settings["expectations"] = expectations.read(Path(expect))
        # What is printed and what is drawn come from one session, in one language.
        drawing = drawn_in(words, _tell, web=given.get("web", False)) if rerun else words
        session = open_session(drawing, given, tables=TABLES if drawn else (), **settings)
        with ExitStack() as stack:
            force = given.get("force", False)
            showing = stack.enter_context(Showing(given, drawing, shown=rerun, force=force)) if drawn else None
            opened = stack.enter_context(listening(named, given, words, complain, duration_s=duration))
            return _listen(opened, session, drawing, given, showing, out, text=form == "text")

    return Command(
        "sniff",
        words,
        run,
        [
            click.Argument(["channels"], nargs=-1, metavar="CHANNEL"),
            *listening_options(words),
            *filter_options(words),
            spelled(words, "--duration", seconds, "duration", "TIME", "sniff.duration"),
            spelled(words, "--count", positive, "positive", "N", "sniff.count"),
            *listing_options(words),
            click.Option(["--expect"], type=ANY_PATH, metavar="FILE", help=words("sniff.expect")),
            click.Option(["--rerun"], is_flag=True, help=words("sniff.rerun")),
            *viewing_options(words, "sniff"),
            *network_options(words),
        ],
    )


def _tell(line: str) -> None:
    complain(f"canalyze: {line}")


def _listen(
    opened: Listening,
    session: Any,
    words: Words,
    given: ListeningOptions,
    showing: Showing | None,
    out: Output,
    *,
    text: bool,
) -> int:
    """Show what is received until the end; give the exit code."""
    show = out.shown if text else out.write
    live = opened.live
    began = time.monotonic()
    stopped = early_end = 0.0

    def stop() -> None:
        nonlocal early_end
        early_end = early_end or time.monotonic()
        live.stop()

    def take(result: bytes) -> None:
        nonlocal stopped
        if result:
            show(result)
        if showing is not None:
            showing.step(session, lambda line: run.complain(f"canalyze: {line}"))
        if run.signal or early.signal:  # the rest is shown, but not for long
            stopped = stopped or time.monotonic()
            if time.monotonic() - stopped > _REST_S:
                live.stop(now=True)

    run = Run(session, words, Progress(words, out, None), take, given, frameless=True, live=live)
    hint(f"canalyze: {_listens(live.names, given, words)}")
    broken: CanalyzeError | None = None
    early = Interrupt(stop)
    try:
        with early:  # what is loaded, and a viewer that starts, take seconds: their end is that of the listening, too
            if showing is not None:
                live.start()  # what comes until the viewer is ready is not lost
                showing.begin(live.name, given, _tell, lambda: early.signal != 0)
            code = run.over((live.name,))
        if early.signal not in (0, signal.SIGINT):
            code = 128 + early.signal
    except SystemExit as ended:  # the second Ctrl-C: what is not shown yet will not be
        code = ended.code if isinstance(ended.code, int) else 2
    except OutputError as error:
        broken, code = error, error.exit_code
    took = (early_end or time.monotonic()) - began
    for line in opened.complete(words):
        complain(line)
    tally = json.loads(session.tally())
    written = opened.recordings.written
    seen = [] if broken else [*_seen(tally, took, live.unshown, bool(written), words), *_held(tally, words)]
    if text and not broken and out.is_terminal and (nodes := json.loads(session.nodes())):
        _show_nodes(nodes, words, out, several=len(tally["buses"]) > 1)
    for line in [*seen, *(one.in_words(words) for one in written)]:
        complain(f"canalyze: {line}")
    if showing is not None:
        for line in showing.complete(session, seen, _tell):
            _tell(line)
    if opened.recordings.failed or (showing is not None and showing.failed):
        code = code or 2
    if broken is not None and code == broken.exit_code:
        raise broken
    if tally["expectations"]:
        code = code or (2 if not tally["frames"] else 1 if tally["expectations"]["missed"] else 0)
    if showing is not None and code < 128:
        _stay(showing)
    return code


def _stay(showing: Showing) -> None:
    """Leave the viewer to the user, who has not seen everything yet when the listening ends."""
    if told := showing.stays:
        with Interrupt() as interrupt:
            _tell(told)
            interrupt.during(showing.wait)


def _listens(names: Sequence[str], given: ListeningOptions, words: Words) -> str:
    """Say what is listened to, and how that is ended."""
    rates = set_rates(names, given)
    rated = [
        name if rate is None else words("sniff.rated", name=name, rate=f"{rate / 1000:g}")
        for name, rate in zip(names, rates, strict=True)
    ]
    return words("sniff.listens", channels=words("listen.comma").join(rated))


def _show_nodes(nodes: Sequence[Mapping[str, Any]], words: Words, out: Output, *, several: bool) -> None:
    """Show below the listing what each node was seen to do; the column of the bus only where there are several."""
    keys = ["col.node", "sniff.frames", "col.node_state", "sniff.errors", "sniff.warnings"]
    columns = [Column(words(key), right=key != "col.node_state") for key in keys]
    rows = []
    for node in nodes:
        state = words.of("monitor_silent", node["silent"]) if node["silent"] else node["state_text"] or EMPTY
        cells = [node["node"], node["frames"], state, node["errors"], node["warnings"]]
        rows.append(map(str, [node["bus"], *cells] if several else cells))
    out.text("\n")
    write([Column(words("col.bus")), *columns] if several else columns, rows, out)


def _held(tally: Mapping[str, Any], words: Words) -> Iterator[str]:
    """Say how the expectations came out, if there are any: nothing is known of a bus that was silent."""
    if expected := tally["expectations"]:
        key = "sniff.unchecked" if not tally["frames"] else "sniff.missed" if expected["missed"] else "sniff.met"
        yield words(key, count=expected["missed"])


def _seen(tally: Mapping[str, Any], seconds: float, unshown: int, recorded: bool, words: Words) -> Iterator[str]:
    """Give what was seen, a line each: the buses, findings, SDO transfers, what was not shown."""
    comma = words("listen.comma")
    # The core counts what it was not given as dropped, too; it is told apart below.
    unshown_here = unshown if len(tally["buses"]) == 1 else 0
    for bus in tally["buses"]:
        frames = bus["frames"]
        facts = {"bus": bus["name"], "frames": frames, "seconds": f"{seconds:.1f}"}
        rate = _rounded(frames / max(seconds, 0.001))
        parts = [words("sniff.bus" if frames else "sniff.nothing", rate=rate, **facts)]
        lost = {"error_frames": bus["error_frames"], "dropped": bus["dropped"] - unshown_here}
        parts += [words(f"sniff.{key}", count=count) for key, count in lost.items() if count > 0]
        yield comma.join(parts)
    lines = []
    for title, (kind, keys) in _COUNTED.items():
        counts = {key: tally[kind][key.removeprefix("sniff.")] for key in keys}
        if listed := comma.join(words(key, count=count) for key, count in counts.items() if count):
            lines.append(words(title, listed=listed))
    if lines:
        yield words("sniff.then").join(lines)
    if tally["shown"] not in (0, tally["frames"]):  # that nothing passes a filter, the core says
        yield words("sniff.shown", shown=tally["shown"])
    if unshown:
        yield words("sniff.unshown_recorded" if recorded else "sniff.unshown", count=unshown)


def _rounded(rate: float) -> str:
    return f"{rate:.1f}" if rate < 100 else f"{rate:.0f}"
