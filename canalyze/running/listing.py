"""A live bus as an annotated listing, from its first frame to what is reported at the end: buses, findings, nodes.

Ctrl-C is the usual end: what was received is still shown. Must not: open a bus, or know what a frame means.
"""

import signal
import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

from msgspec.json import decode

from canalyze.errors import CanalyzeError, OutputError
from canalyze.output import Output, Progress, complain, hint
from canalyze.records import decoder
from canalyze.records.live import CountedNode, Tally
from canalyze.reports.table import EMPTY, Column, write
from canalyze.running.listening import Listening, ListeningOptions, set_rates
from canalyze.running.run import Interrupt, Run
from canalyze.running.viewing import Showing
from canalyze.words import Words

if TYPE_CHECKING:
    from canalyze._core import Session

_REST_S: Final = 2.0
"""Maximum time after the first Ctrl-C in which received frames are still shown."""


def _complain(line: str) -> None:
    complain(f"canalyze: {line}")


def listed(
    opened: Listening,
    session: "Session",
    words: Words,
    given: ListeningOptions,
    showing: Showing | None,
    out: Output,
    *,
    text: bool,
) -> int:
    """Shows what is received until the end; returns the exit code."""
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
                showing.begin(live.name, given, _complain, lambda: early.signal != 0)
            code = run.over((live.name,))
        if early.signal not in (0, signal.SIGINT):
            code = 128 + early.signal
    except SystemExit as ended:  # the second Ctrl-C: what is not shown yet will not be
        code = ended.code if isinstance(ended.code, int) else 2
    except OutputError as error:
        broken, code = error, error.exit_code
    took = (early_end or time.monotonic()) - began
    complain(*opened.complete(words))
    tally: Tally = decoder(Tally)(session.tally())
    written = opened.recordings.written
    said = [] if broken else [*seen(tally, took, live.unshown, bool(written), words), *held(tally, words)]
    if text and not broken and out.is_terminal and (nodes := decode(session.nodes(), type=list[CountedNode])):
        show_nodes(nodes, words, out, several=len(tally.buses) > 1)
    for line in [*said, *(one.in_words(words) for one in written)]:
        complain(f"canalyze: {line}")
    if showing is not None:
        for line in showing.complete(session, said, _complain):
            _complain(line)
    if opened.recordings.failed or (showing is not None and showing.failed):
        code = code or 2
    if broken is not None and code == broken.exit_code:
        raise broken
    if expected := tally.expectations:
        code = code or (2 if not tally.frames else 1 if expected.missed else 0)
    if showing is not None and code < 128:
        _stay(showing)
    return code


def _stay(showing: Showing) -> None:
    """Waits until the user, who has not seen everything yet, has closed the viewer."""
    if told := showing.stays:
        with Interrupt() as interrupt:
            _complain(told)
            interrupt.during(showing.wait)


def _listens(names: Sequence[str], given: ListeningOptions, words: Words) -> str:
    """Returns what is listened to, and how that is ended."""
    rates = set_rates(names, given)
    rated = [
        name if rate is None else words("sniff.rated", name=name, rate=f"{rate / 1000:g}")
        for name, rate in zip(names, rates, strict=True)
    ]
    return words("sniff.listens", channels=words("listen.comma").join(rated))


_FINDINGS: Final = ("error", "warning", "info")
_TRANSFERS: Final = ("ok", "aborted", "incomplete", "failed")


def show_nodes(nodes: Sequence[CountedNode], words: Words, out: Output, *, several: bool) -> None:
    """Shows below the listing what each node was seen to do; the column of the bus only where there are several."""
    keys = ["col.node", "sniff.frames", "col.node_state", "sniff.errors", "sniff.warnings"]
    columns = [Column(words(key), right=key != "col.node_state") for key in keys]
    rows = []
    for node in nodes:
        state = words.of("monitor_silent", node.silent) if node.silent else node.state_text or EMPTY
        cells = [node.node, node.frames, state, node.errors, node.warnings]
        rows.append(map(str, [node.bus, *cells] if several else cells))
    out.text("\n")
    write([Column(words("col.bus")), *columns] if several else columns, rows, out)


def held(tally: Tally, words: Words) -> Iterator[str]:
    """Yields how the expectations came out, if there are any: nothing is known of a bus that was silent."""
    if expected := tally.expectations:
        key = "sniff.unchecked" if not tally.frames else "sniff.missed" if expected.missed else "sniff.met"
        yield words(key, count=expected.missed)


def seen(tally: Tally, seconds: float, unshown: int, recorded: bool, words: Words) -> Iterator[str]:
    """Yields what was seen, a line each: the buses, findings, SDO transfers, what was not shown."""
    comma = words("listen.comma")
    # The core counts what it was not given as dropped, too; it is reported apart below.
    unshown_here = unshown if len(tally.buses) == 1 else 0
    for bus in tally.buses:
        frames = bus.frames
        facts = {"bus": bus.name, "frames": frames, "seconds": f"{seconds:.1f}"}
        rate = _rounded(frames / max(seconds, 0.001))
        parts = [words("sniff.bus" if frames else "sniff.nothing", rate=rate, **facts)]
        lost = {"error_frames": bus.error_frames, "dropped": bus.dropped - unshown_here}
        parts += [words(f"sniff.{key}", count=count) for key, count in lost.items() if count > 0]
        yield comma.join(parts)
    lines = []
    for title, counts, keys in (("findings", tally.findings, _FINDINGS), ("transfers", tally.transfers, _TRANSFERS)):
        if listed := comma.join(words(f"sniff.{key}", count=counts[key]) for key in keys if counts[key]):
            lines.append(words(f"sniff.{title}", listed=listed))
    if lines:
        yield words("sniff.then").join(lines)
    if tally.shown not in (0, tally.frames):  # that nothing passes a filter, the core says
        yield words("sniff.shown", shown=tally.shown)
    if unshown:
        yield words("sniff.unshown_recorded" if recorded else "sniff.unshown", count=unshown)


def _rounded(rate: float) -> str:
    return f"{rate:.1f}" if rate < 100 else f"{rate:.0f}"
