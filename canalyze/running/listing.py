"""A live bus as an annotated listing, from its first frame to what is reported at the end.

Ctrl-C is the usual end: what was received is still shown. Must not: open a bus, or know what a frame means.
"""

import signal
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from msgspec.json import decode

from canalyze.errors import CanalyzeError, OutputError
from canalyze.output import Output, Progress, complain, hint
from canalyze.records import decoder
from canalyze.records.live import CountedNode, Tally
from canalyze.reports.sniff_text import held, seen, show_nodes
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
    for line in opened.complete(words):
        complain(line)
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
